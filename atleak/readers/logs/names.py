"""Derives the quantity that a column may hold from the name a logger gives it, and numbers from words for gears.

The unit is taken out of the name first; the rest is compared, as a whole and longest first, with the synonyms of
``synonyms.toml``. Words that say nothing (*SAE*, *OBD*) are left out; a veto word (*target*, *duty*) forbids the match.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cache, lru_cache
from typing import Literal

import numpy as np
import pandas as pd

from atleak.common.units import find_unit, kinds_of
from atleak.measurements.road_test import QUANTITIES, ChannelKind
from atleak.readers.dates import vocabulary, words

Tier = Literal[0, 1, 2]
"""0: the quantity's own name; 1: a second choice (a GPS speed); 2: only offered to the user, never chosen."""

# units of other things a logger records: they end a name in brackets without being part of it
_OTHER_UNITS = frozenset(
    {
        "v", "mv", "volt", "volts", "%", "g/s", "kg/h", "g", "lb/min", "nm", "ft-lb", "lb-ft", "lbft", "hp", "ps", "kw",
        "a", "ma", "ppm", "°", "deg", "degree", "degrees", "λ", "lambda", "afr", "none", "index", "gear", "on/off",
        "raw", "count", "counts", "steps", "mg/stk", "mg/cyl", "mg/s", "ml", "l", "gal", "miles", "km", "m", "ft",
        "g/rev", "g/cyl", "l/100km", "l/h", "mpg", "gph", "€", "rpm/s", "kpa/s", "km/l", "bit", "bool", "boolean",
        "enum", "state", "code", "text", "n/a", "unitless", "mm", "cm", "in", "µm", "n", "kn", "db", "j", "wh", "ohm",
        "ω", "f/c", "psi/bar", "°btdc", "°ca", "multiplier", "inhg", "in.hg", "inh2o", "mmhg", "torr", "mg/m3", "sat/s",
        "l/min", "gpm", "°/s", "kg", "kg/s", "btdc", "deg/s", "g/l", "uv", "w", "var", "°crk", "%pwm",
    }
)  # fmt: skip
_GROUP = re.compile(r"^(.*?)[\s_]*[(\[{]([^()\[\]{}]*(?:\([^()]*\))?[^()\[\]{}]*)[)\]}]\s*$", re.DOTALL)
_FOOTNOTE = re.compile(r"(?<=[)\]])\s*\*\s*\w*$")


@dataclass(frozen=True)
class _Name:
    """A column's name without its unit, and the unit's text (None where the name states none)."""

    text: str
    unit: str | None


@lru_cache(maxsize=4096)
def split_unit(name: str) -> _Name:
    """Separate the unit from a column's name.

    Only the last group in brackets can be the unit, and only if it is one: ``Speed (OBD)(km/h)``.

    >>> split_unit("Catalyst Temperature (Bank 1 Sensor 1)(°C)")
    _Name(text='Catalyst Temperature (Bank 1 Sensor 1)', unit='°C')
    >>> split_unit("Speed (OBD)")
    _Name(text='Speed (OBD)', unit=None)
    """
    text = name.replace("\ufeff", "").strip().strip('"').strip()
    if text.count("|") >= 2:  # "Name"|"unit"|min|max|rate
        parts = [part.strip().strip('"').strip() for part in text.split("|")]
        return _Name(parts[0], parts[1] or None)
    text = _FOOTNOTE.sub("", text)  # "Engine Speed (rpm) *OBD"
    unit: str | None = None
    while match := _GROUP.match(text):
        inside = match[2].strip().strip('"').strip()
        if unit is not None and inside.lower() != unit.lower():
            break
        if not (inside == "" or is_unit(inside)):
            break
        text, unit = match[1].strip(), inside
        if not text:
            return _Name(name.strip(), None)
    return _Name(text, unit or None)


@lru_cache(maxsize=4096)
def is_unit(text: str) -> bool:
    """Return whether a text is a unit of anything a logger records."""
    bare = clean_unit(text)
    if _ABSOLUTE.match(bare) or _ABSOLUTE.match(text.strip()):
        return True
    return bool(bare) and (bare.lower() in _OTHER_UNITS or bool(kinds_of(bare)))


_ABSOLUTE = re.compile(r"^(?:k?pa|m?bar|mpa|hpa|psi)\s*[ (_]?\s*(?:a|abs\.?|absolute?|g|gauge)\s*\)?$", re.IGNORECASE)


def clean_unit(text: str) -> str:
    """Return a unit without the brackets and quotes some loggers put round it.

    >>> clean_unit(" [°C] ")
    '°C'
    """
    return text.strip().strip('"').strip("[](){}").strip()


@dataclass(frozen=True)
class Match:
    """The quantity that a name may stand for. ``unit`` is its last word if that is one (``engine_speed_rpm``)."""

    quantity: str
    tier: Tier
    kind: ChannelKind = "unknown"
    unit: str | None = None


_SYNONYMS = ("atleak.readers.logs", "synonyms.toml")


@dataclass(frozen=True)
class _Table:
    exact: dict[str, tuple[str, Tier, ChannelKind]]
    neutral: tuple[str, ...]
    veto: tuple[str, ...]
    commanded: tuple[str, ...]
    measured: tuple[str, ...]
    with_unit: dict[str, str]


@cache
def synonyms() -> _Table:
    """Load the table of synonyms, by spelling without blanks."""
    data, with_unit = vocabulary(*_SYNONYMS), dict[str, str]()
    exact: dict[str, tuple[str, Tier, ChannelKind]] = {}
    lists: tuple[tuple[str, Tier, ChannelKind], ...] = (
        ("names", 0, "unknown"), ("measured", 0, "measured"), ("commanded", 0, "commanded"),
        ("offered", 2, "commanded"), ("second_choice", 1, "unknown"),
    )  # fmt: skip
    for quantity in QUANTITIES:
        own = data.get(quantity, {})
        for key, tier, kind in lists:
            exact |= {_squash(words(name)): (quantity, tier, kind) for name in own.get(key, ())}
        with_unit |= {_squash(words(name)): quantity for name in own.get("with_unit", ())}
    lexicon = {key: tuple(words(word) for word in value) for key, value in data["words"].items()}
    lexicon["neutral"] = tuple(sorted(lexicon["neutral"], key=len, reverse=True))
    return _Table(exact, **lexicon, with_unit=with_unit)


@cache
def _words_of_names() -> frozenset[str]:
    names = (name for own in vocabulary(*_SYNONYMS).values() for said in own.values() for name in said)
    return frozenset(word for name in names for word in words(name).split())


def in_synonyms(word: str) -> bool:
    """Return whether a single word stands in a name of any quantity.

    >>> in_synonyms("Coolant"), in_synonyms("Getriebeöltemperatur"), in_synonyms("Kowalski")
    (True, True, False)
    """
    return words(word) in _words_of_names()


def _squash(text: str) -> str:
    return text.replace(" ", "")


def _holds(text: str, word: str) -> bool:
    return f" {word} " in f" {text} "


def _without(text: str, unwanted: tuple[str, ...]) -> str:
    padded = f" {text} "
    for word in unwanted:
        while f" {word} " in padded:
            padded = padded.replace(f" {word} ", " ", 1)
    return padded.strip()


def unit_at_the_end(name: str, kind: str | None) -> _Name | None:
    """Separate a last word that is a unit of this kind: ``engine_speed_rpm``, ``Vehicle speed, km/h``."""
    match = re.match(r"^(.*\S)[\s_,;:.\-]+(\S+)$", name.strip())
    if kind is None or not match:
        return None
    ends = [(match[1], match[2])]
    if two := re.match(r"^(.*\S)[\s_,]+(\S+)$", match[1]):
        ends.append((two[1], f"{two[2]} {match[2]}"))
    for head, tail in ends:
        if find_unit(clean_unit(tail), kind):
            return _Name(head.strip(" ,;:_-"), clean_unit(tail))
    return None


@lru_cache(maxsize=4096)
def match_name(name: str) -> Match | None:
    """Return the quantity a name (without its bracketed unit) stands for, or None.

    >>> match_name("Engine RPM (SAE)").quantity, match_name("Line Pressure Correction")
    ('engine_speed', None)
    """
    table, text = synonyms(), words(name)
    if not text:
        return None
    bare = _without(text, table.neutral)
    entry = table.exact.get(_squash(text)) or table.exact.get(_squash(bare))
    if entry is not None:
        quantity, tier, kind = entry
        return Match(quantity, tier, _pressure_kind(quantity, text, kind), _own_unit(name, quantity))
    for candidate in QUANTITIES.values():
        ending = unit_at_the_end(name, candidate.unit_kind)
        if ending is None or not ending.text:
            continue
        inner = match_name(ending.text)
        if inner and inner.quantity == candidate.name:
            return Match(inner.quantity, inner.tier, inner.kind, ending.unit)
    return _offer(text, bare)


def match_short_name(name: str, unit: str | None) -> Match | None:
    """Return the quantity that a short name stands for in a unit of its kind: *N* in rpm, *VS* in km/h; else None."""
    quantity = synonyms().with_unit.get(_squash(words(name)))
    kind = QUANTITIES[quantity].unit_kind if quantity else None
    if quantity is None or kind is None or unit is None or find_unit(clean_unit(unit), kind) is None:
        return None
    return Match(quantity, 0)


def _own_unit(name: str, quantity: str) -> str | None:
    kind = QUANTITIES[quantity].unit_kind
    if kind is None or words(name) == "time of day":  # which is in seconds, as a rule, and never in days
        return None
    if find_unit(name, kind):  # a column called "mph" or "RPM"
        return name.strip()
    ending = unit_at_the_end(name, kind)
    if ending is None and "/" in name and find_unit(name.rsplit("/", 1)[1], kind):  # a path: "engine/rpm"
        return name.rsplit("/", 1)[1]
    return ending.unit if ending else None


def _pressure_kind(quantity: str, text: str, kind: ChannelKind) -> ChannelKind:
    if kind != "unknown" or QUANTITIES[quantity].unit_kind != "pressure":
        return kind
    return name_kind(text)


def name_kind(name: str) -> ChannelKind:
    """Return whether a pressure's name says that it is commanded or measured."""
    table, text = synonyms(), words(name)
    if any(_holds(text, word) for word in table.commanded):
        return "commanded"
    if any(_holds(text, word) for word in table.measured):
        return "measured"
    return "unknown"


_NOT_OFFERED = {"time", "gear", "selector", "lock_up", "coolant_temperature"}


def _offer(text: str, bare: str) -> Match | None:
    """Match a name that holds a synonym of two or more words among others: offered to the user, never chosen."""
    table = synonyms()
    if any(_holds(text, word) for word in table.veto):
        return None
    offered = (
        (synonym, quantity, kind) for synonym, (quantity, tier, kind) in _phrases()
        if " " in synonym and quantity not in _NOT_OFFERED and tier != 1 and _holds(bare, synonym)
    )  # fmt: skip
    _, quantity, kind = max(offered, key=lambda each: len(each[0]), default=("", None, None))
    return Match(quantity, 2, _pressure_kind(quantity, text, kind)) if quantity and kind else None


@cache
def _phrases() -> tuple[tuple[str, tuple[str, Tier, ChannelKind]], ...]:
    of_quantities = [vocabulary(*_SYNONYMS).get(quantity, {}) for quantity in QUANTITIES]
    lists = [names for own in of_quantities for key, names in own.items() if key != "with_unit"]
    phrases = [words(name) for names in lists for name in names]
    return tuple((phrase, synonyms().exact[_squash(phrase)]) for phrase in phrases)


_ORDINALS = ("first", "second", "third", "fourth", "fifth", "sixth", "seventh", "eighth", "ninth", "tenth")
_GEARS: dict[str, float] = {
    **{name: float(number) for number, name in enumerate(_ORDINALS, start=1)},
    "reverse": -1.0, "r": -1.0, "rev": -1.0, "rueckwaerts": -1.0, "rueckwaertsgang": -1.0, "wsteczny": -1.0,
    "marche arriere": -1.0, "задняя": -1.0, "neutral": 0.0, "n": 0.0, "park": 0.0, "p": 0.0, "parking": 0.0, "p n": 0.0,
    "park neutral": 0.0, "neutralny": 0.0, "luz": 0.0, "leerlauf": 0.0, "neutre": 0.0, "neutro": 0.0, "нейтраль": 0.0,
}  # fmt: skip
_DRIVE = frozenset({"d", "s", "m", "l", "drive", "sport", "manual", "low", "b"})
_DIGIT = re.compile(
    r"(?:gear|gang|bieg|marcha|rapport|передача|d|m|s)?\s*(\d{1,2})(?:st|nd|rd|th|e|я)?"
    r"\s*(?:gear|gang|bieg|marcha|передача)?\Z"
)

_PARK = ("p", "park", "parking")


def gear_of(text: str) -> float:
    """Return a gear's number from its word, NaN where the word names no gear.

    >>> gear_of("First"), gear_of("3rd gear"), gear_of("R"), gear_of("D")
    (1.0, 3.0, -1.0, nan)
    """
    plain = words(text)
    if plain in _GEARS:
        return _GEARS[plain]
    match = _DIGIT.match(plain)
    return float(match[1]) if match and int(match[1]) <= 12 else float("nan")


def selector_of(text: str) -> float:
    """Return a selector position's number: park −2, else its gear's, drive 10; NaN where the word names none."""
    plain, number = words(text), gear_of(text)
    if plain in _PARK:
        return -2.0
    if number == number:
        return number
    return 10.0 if plain in _DRIVE or plain[:1] == "d" else float("nan")


def switch_of(text: str) -> float:
    """Return 1 for on or locked, 0 for off or open, NaN for anything else."""
    plain = words(text)
    if plain in ("on", "locked", "lock", "yes", "true", "closed", "ein", "applied", "engaged", "wlaczone", "1"):
        return 1.0
    if plain in ("off", "unlocked", "open", "no", "false", "aus", "released", "disengaged", "wylaczone", "0"):
        return 0.0
    return float("nan")


def as_numbers(quantity: str, column: pd.Series) -> np.ndarray:
    """Return a column of words as the quantity's numbers."""
    reader = {"gear": gear_of, "selector": selector_of, "lock_up": switch_of}[quantity]
    codes, uniques = pd.factorize(column.astype("str").where(column.notna()))
    table = np.array([*(reader(str(word)) for word in uniques), np.nan])
    return table[codes]


def only_positions(column: pd.Series) -> bool:
    """Return whether a column named *gear* holds selector letters only."""
    cells = {words(str(word)) for word in column.dropna().unique()}
    return bool(cells) and cells <= {"p", "r", "n", "d", "s", "m", "l", "park", "reverse", "neutral", "drive", "b"}
