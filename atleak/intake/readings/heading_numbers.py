"""What the words and numbers in the heading of a diameter say: land, plane, direction, repeat, coordinate, or else."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache

from atleak.intake.readings.words import SIZES, UNITS_BEHIND, direction_of, part_of, plain, vocabulary

_COUNTED = vocabulary("repeat", "reading", "actual")
_DIAMETER = vocabulary("diameter")
_NUMBER = vocabulary("number")
_PART_OR_OTHER = vocabulary("part_or_other")
_EXPLAINED = vocabulary(
    *("repeat", "reading", "actual", "diameter", "coordinate", "number", "direction", "outer", "inner", "dimension"),
    *("land", "plane"),
)
_LAND = vocabulary("land")
_PLANE = vocabulary("plane")
_DIRECTION = vocabulary("direction")
_BESIDE_A_PART = {"of", "the", "der", "des", "du", "de", "la", "l", "le", "del", "at", "in", "an", "am"}
_ORDINAL = {"st", "nd", "rd", "th"}
_ENDS = {"x1", "x2", "y1", "y2"}
_DIRECTED = {"x": 0.0, "dx": 0.0, "x-x": 0.0, "a-a": 0.0, "y": 90.0, "dy": 90.0, "y-y": 90.0, "b-b": 90.0}
_AXES = _ENDS | {"i", "ii", *_DIRECTED}
_ROMAN = {"i": "1", "ii": "2", "iii": "3", "iv": "4"}
_MOST_REPEATS = 30
_PLAIN_ANGLES = {"0", "90"}  # behind the word for the diameter also without "°"


_TOKEN = re.compile(
    r"(?<![^\W_])(?:x-x|y-y|a-a|b-b)(?![^\W_])|(?:12-6|6-12|3-9|9-3)(?=\s*(?:o'?\s?clock|uhr|godz|h\b))"
    r"|\d+(?:°|deg\b)|[ø⌀φ#]|[^\W\d_øφ]+\d*|\d+"
)
_COMPOUND = re.compile(r"(\w{4,}?)(durchmesser|durchm|mass)")


@lru_cache(maxsize=4096)
def tokens_of(text: str) -> tuple[str, ...]:
    """Return the words and numbers of a heading without its unit; of a compound that names a part its two words.

    >>> tokens_of("Hülsendurchmesser 2"), tokens_of("Solldurchmesser"), tokens_of("Ø A-A")
    (('hulsen', 'durchmesser', '2'), ('solldurchmesser',), ('ø', 'a-a'))
    """
    return tuple(word for token in _TOKEN.findall(plain(text).replace("_", " ")) for word in _halves(token))


def _halves(word: str) -> tuple[str, ...]:
    match = _COMPOUND.fullmatch(word)
    if match is None:
        return (word,)
    first = match[1]
    for known in (first, first.removesuffix("s"), first.removesuffix("en"), first.removesuffix("n")):
        if part_of(known) is not None or known in {"aussen", "innen"}:
            return known, match[2]
    return (word,)


@dataclass(frozen=True)
class Spot:
    """Where on its spool a heading says that its diameters were taken: land or plane by name, angle [°]."""

    land: str | None = None
    plane: str | None = None
    direction: float | None = None

    @property
    def is_somewhere(self) -> bool:
        """Return whether the heading says any of it."""
        return self != Spot()


def spot_of_heading(tokens: Sequence[str]) -> tuple[Spot, tuple[str, ...]]:
    """Return where a heading says that its diameters were taken, and its other words.

    >>> spot_of_heading(["spool", "land", "2"])[0].land, spot_of_heading(["2", "ebene", "ø"])
    ('2', (Spot(land=None, plane='2', direction=None), ('ø',)))
    """
    words = [token for token in tokens if token not in _ORDINAL]
    said: dict[str, str] = {}
    others: list[str] = []
    at = 0
    while at < len(words):
        glued = re.fullmatch(r"([^\W\d]+)(\d{1,2})", words[at])
        kind = _kind(glued[1] if glued else words[at])
        step = 2 if at + 1 < len(words) and words[at + 1] in _NUMBER else 1
        name = glued[2] if glued else words[at + step] if at + step < len(words) else ""
        if kind is not None and kind not in said and _names_spot(name, kind):
            said[kind] = _ROMAN.get(name, name)
            at += 1 if glued else step + 1
        elif kind in ("land", "plane") and kind not in said and others and others[-1].isdigit():
            said[kind] = others.pop()
            at += 1
        else:
            others.append(words[at])
            at += 1
    direction = direction_of(said["direction"]) if "direction" in said else None
    return Spot(said.get("land"), said.get("plane"), direction), tuple(others)


def _kind(word: str) -> str | None:
    if word in _LAND or word == "l":
        return "land"
    if word in _PLANE:
        return "plane"
    return "direction" if word in _DIRECTION else None


def _names_spot(name: str, kind: str) -> bool:
    if kind == "direction":
        return direction_of(name) is not None
    return bool(re.fullmatch(r"\d{1,2}|[a-h]", name)) or name in _ROMAN


def is_explained(tokens: Iterable[str]) -> bool:
    """Return whether words say only of which part and place a diameter is, and which repeat."""
    return all(
        token in _EXPLAINED
        or token in _AXES
        or token in _ORDINAL
        or token in _ROMAN
        or token in _BESIDE_A_PART
        or token in {"od", "id", "o", "clock", "uhr"}
        or token.isdigit()
        or is_angle(token)
        or part_of(token) is not None
        or direction_of(token) is not None
        for token in tokens
    )


def numbers_of_heading(role: str, tokens: Sequence[str]) -> tuple[int | None, float | None, int | None]:
    """Return coordinate 1 or 2, direction [°] and repeat from the words of a value's heading.

    A number is a repeat behind a word for one or beside the word for the diameter. In front of a unit, in a date, or
    behind any other word it says something else: a mileage, a temperature, a vehicle.

    >>> numbers_of_heading("diameter", ["diameter", "2"]), numbers_of_heading("diameter", ["diameter", "50", "km"])
    ((None, None, 2), (None, None, None))
    """
    angles = [token for token, after in _followed(tokens) if is_angle(token) and after not in UNITS_BEHIND]
    angles += [
        token
        for before, (token, after) in zip(("", *tokens), _followed(tokens), strict=False)
        if token in _PLAIN_ANGLES and (before in SIZES or part_of(before)) and after not in UNITS_BEHIND
    ]
    angles += [token for token in tokens if "-" in token or (token.isalpha() and len(token) > 3)]
    direction = next((angle for each in angles if (angle := direction_of(each)) is not None), None)
    if direction is None and role == "diameter":
        direction = next((_DIRECTED[token] for token in tokens if token in _DIRECTED), None)
    axes = {token for token in tokens if token in _ENDS}
    letters = {axis[0] for axis in axes}
    if len(letters) == 1 and direction is None:
        direction = 0.0 if letters == {"x"} else 90.0
    repeat = coordinate = None
    beside: list[int] = []
    for before, token, after in _numbered(tokens):
        glued = re.fullmatch(r"([^\W\d]+)(\d+)", token)
        word, number = (glued[1], int(glued[2])) if glued else (before, int(token))
        if after in UNITS_BEHIND or after[:1].isdigit() or before.isdigit() or not 0 < number <= _MOST_REPEATS:
            continue
        if word in _COUNTED or word in {"#", "r"}:
            repeat = number if repeat is None else repeat
        elif word in SIZES or _may_be_numbered(word, after):
            beside.append(number)
    if role == "coordinate":
        ends = {axis[1] for axis in axes}
        if len(ends) == 1:
            coordinate = int(ends.pop())
        elif beside:
            coordinate = beside.pop(0)
    if repeat is None and beside:
        repeat = beside[0]
    return coordinate, direction, repeat


def besides_numbers(words: Iterable[str]) -> frozenset[str]:
    """Return the words of a value's heading that say neither what it is nor of which part, and numbers of no repeat.

    >>> besides_numbers({"diameter", "1", "before", "spool"}), besides_numbers({"measurement", "2024"})
    (frozenset({'before'}), frozenset({'2024'}))
    """
    return frozenset(
        word
        for word in words
        if (word.isdigit() and int(word) > _MOST_REPEATS)
        or (
            word.isalpha()
            and len(word) > 1
            and not (word in _EXPLAINED or word in _ORDINAL or word in _AXES or word in _ROMAN)
            and part_of(word) is None
        )
    )


def is_angle(word: str) -> bool:
    return re.fullmatch(r"\d+(?:°|deg)", word) is not None


def _followed(tokens: Sequence[str]) -> Iterator[tuple[str, str]]:
    return zip(tokens, (*tokens[1:], ""), strict=False)


def _numbered(tokens: Sequence[str]) -> Iterator[tuple[str, str, str]]:
    """Yield each number with the word before it, past "no.", and the word behind it, past "st" and "nd"."""
    words = [token for token in tokens if (token not in _NUMBER or token == "#") and token not in _ORDINAL]
    words = [
        _ROMAN[token] if token in _ROMAN and before in _COUNTED else token
        for before, token in zip(("", *words), words, strict=False)
    ]
    for before, (token, after) in zip(("", *words), _followed(words), strict=False):
        if token.isdigit() or (re.fullmatch(r"[^\W\d]+\d+", token) and token not in _AXES):
            yield before, token, after


def _may_be_numbered(word: str, after: str) -> bool:
    """Return whether a part, a direction, or nothing stands before the word for the diameter: "1. diameter"."""
    if word == "":
        return after in _DIAMETER or after in _COUNTED or part_of(after) is not None
    return (part_of(word) is not None and word not in _PART_OR_OTHER) or word in _AXES or is_angle(word)
