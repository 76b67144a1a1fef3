"""Decides what a single cell is: a number, a clock's reading, missing, or text."""

from __future__ import annotations

import re
from functools import lru_cache
from typing import Literal

Decimal = Literal[".", ","]
CellKind = Literal["number", "clock", "missing", "text"]

MISSING = frozenset(
    {
        "", "-", "--", "---", "nan", "-nan", "nan(ind)", "-nan(ind)", "inf", "-inf", "+inf", "infinity", "-infinity",
        "∞", "-∞", "n/a", "na", "#n/a", "null", "none", "off", "not running", "läuft nicht", "laeuft nicht",
        "nie pracuje", "не работает", "?", "---.-", "no data", "nodata", "n.a.", "n.v.", "not available",
        "not supported", "invalid", "err", "error", "#ref!", "#value!", "#div/0!", "#num!", "#name?", "<null>", "nil",
        "undefined", "x", "*", ".", "не число",
    }
)  # fmt: skip
"""Spellings of "no value", in lower case. None of them is ever a zero."""

_NUMBER = {
    ".": re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?\Z"),
    ",": re.compile(r"[+-]?(?:\d+,?\d*|,\d+)(?:[eE][+-]?\d+)?\Z"),
}
_CLOCK = re.compile(
    r"\d{8}[ T]\d{1,2}:\d\d"
    r"|\d{1,4}\s*[:/.\-]\s*(?:\d{1,4}|[^\W\d_]{3,5}\.?)\s*[:/.\-]\s*-?\d{1,5}(?!\d*[.,]\d{3}\b)"
    r"|\d{1,3}:\d{2}(?:[.,]\d+)?\Z|\d{1,2}:\d{2}"
)
_WORDY_DATE = re.compile(
    r"[^\W\d_]{2,4}\.?,?\s+(?:[^\W\d_]{3,5}\.?\s+\d{1,2}|\d{1,2}\.?\s+[^\W\d_]{3,5}\.?)\s+.*\d:\d\d"
)
# numbers a spreadsheet has destroyed: thousands signs repeated, or a long number cut to three digits and a power of ten
_DESTROYED = re.compile(r"[+-]?\d{1,3}(?:[.,']\d{3}){2,}\Z|[+-]?\d[.,]\d{1,2}E\+(?:0?[5-9]|\d{2,})\Z|#{3,}\Z")


@lru_cache(maxsize=65536)
def kind_of(cell: str, decimal: Decimal) -> CellKind:
    """Return what a cell is, given the decimal sign.

    >>> kind_of("-0,5", ","), kind_of("13:40:39.474", "."), kind_of("Not Running", "."), kind_of("EGR A:0/0/0 %", ".")
    ('number', 'clock', 'missing', 'text')
    """
    text = cell.strip()
    if text.lower() in MISSING:
        return "missing"
    if _NUMBER[decimal].match(text):
        return "number"
    if is_clock(text):
        return "clock"
    return "text"


def is_clock(text: str) -> bool:
    """Return whether a text reads like a date, a time of day, or both."""
    text = text.strip()
    if not any(character.isdigit() for character in text) or len(text) > 48 or is_destroyed(text):
        return False
    if _WORDY_DATE.match(text):
        return True
    return bool(_CLOCK.match(text)) and len(re.findall(r"\d+", text)) >= 2


def is_destroyed(text: str) -> bool:
    """Return whether a spreadsheet has made this number unreadable.

    >>> is_destroyed("-583.206.639"), is_destroyed("1,51E+12"), is_destroyed("1,000000E-5")
    (True, True, False)
    """
    return bool(_DESTROYED.match(text.strip()))


def to_float(cell: str, decimal: Decimal) -> float:
    """Return a number, or NaN for anything else."""
    text = cell.strip()
    if not _NUMBER[decimal].match(text):
        return float("nan")
    return float(text.replace(",", ".") if decimal == "," else text)
