"""Converts gears and selector positions written in words to numbers."""

from __future__ import annotations

import re

import numpy as np
import pandas as pd

from atleak.intake.plain_words import words

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

SELECTOR = {"park": -2.0, "reverse": -1.0, "neutral": 0.0, "drive": 10.0}
"""Numbers of selector positions written in words; a forward range with a digit is that digit."""


_POSITIONS = {
    "p": "park", "park": "park", "parking": "park", "r": "reverse", "reverse": "reverse", "rev": "reverse",
    "n": "neutral", "neutral": "neutral",
}  # fmt: skip


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
    """Return a selector position's number (see `SELECTOR`), NaN where the word names none."""
    plain = words(text)
    if plain in _POSITIONS:
        return SELECTOR[_POSITIONS[plain]]
    number = gear_of(text)
    if number == number:
        return number
    return SELECTOR["drive"] if plain in _DRIVE or plain[:1] == "d" else float("nan")


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
