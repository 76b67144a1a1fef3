"""Decides what a single cell is: a number, a clock's reading, missing, or text.

Of a column whose cells are no numbers it says why: thousands parted by a sign, another decimal sign, several units.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable
from functools import lru_cache
from typing import Literal

import numpy as np
import pandas as pd

from atleak.common.sentences import Sentence
from atleak.readers.logs.names import is_unit

Decimal = Literal[".", ","]
CellKind = Literal["number", "clock", "missing", "text"]

OFF = "off"
"""A word for *missing* that is a value in a column of switches."""
MISSING = frozenset(
    {
        "", "-", "--", "---", "nan", "-nan", "nan(ind)", "-nan(ind)", "inf", "-inf", "+inf", "infinity", "-infinity",
        "∞", "-∞", "n/a", "na", "#n/a", "null", "none", OFF, "not running", "läuft nicht", "laeuft nicht",
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
def kind_of_cells(cell: str, decimal: Decimal) -> CellKind:
    """Return what a cell is, given the decimal sign.

    >>> [kind_of_cells(cell, ".") for cell in ("13:40:39.474", "Not Running", "EGR A:0/0/0 %")]
    ['clock', 'missing', 'text']
    >>> kind_of_cells("-0,5", ",")
    'number'
    """
    text = cell.strip()
    if text.lower() in MISSING:
        return "missing"
    if _NUMBER[decimal].match(text):
        return "number"
    if is_clock(text):
        return "clock"
    return "number" if _with_unit(text, decimal) else "text"


_WITH_UNIT = re.compile(r"([+-]?[\d.,]+(?:[eE][+-]?\d+)?)\s*([^\W\d_][^\d,;:\s]*|[%°][^\d,;:\s]*)\Z")


def _with_unit(text: str, decimal: Decimal) -> str | None:
    """Return the unit of a cell that holds a number and behind it its unit, else None."""
    match = _WITH_UNIT.match(text)
    return match[2] if match and _NUMBER[decimal].match(match[1]) and is_unit(match[2]) else None


def unit_in_cells(cells: Iterable[str], decimal: Decimal) -> str | None:
    """Return the unit that stands behind the number in nearly all cells of a column, None where there is no one.

    >>> unit_in_cells(["900RPM", "910RPM", "-"], "."), unit_in_cells(["20km/h", "12mph"], ".")
    ('RPM', None)
    """
    filled = [cell for cell in cells if cell.strip().lower() not in MISSING]
    if len(filled) < 2 or filled[0][-1:].isdigit():
        return None
    units = Counter(_with_unit(cell.strip(), decimal) for cell in filled)
    unit, count = units.most_common(1)[0]
    return unit if unit is not None and count >= 0.95 * len(filled) else None


def without_unit(column: pd.Series, unit: str) -> pd.Series:
    """Return the cells of a column without the unit that stands behind their numbers."""
    return column.str.strip().str.removesuffix(unit).str.strip()


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


TEXT = Sentence("text instead of numbers")
HOLDS = Sentence("{column!r} holds {what} ({found}): it is not used")
_LONGEST_QUOTE = 40  # characters of a cell that a message shows
_THOUSANDS = re.compile(r"[+-]?\d{1,3}(?P<sign>[.,'’\u00a0\u202f ])\d{3}(?:(?P=sign)\d{3})*(?P<rest>[.,]\d*)?\Z")
_OTHER: dict[Decimal, Decimal] = {".": ",", ",": "."}


def quoted(cell: object) -> str:
    """Return a cell as a message shows it: cut where it is long.

    >>> quoted(" 1.#INF"), quoted("9" * 5000)[-3:]
    ('1.#INF', '99…')
    """
    text = str(cell).strip()
    return text if len(text) <= _LONGEST_QUOTE else text[:_LONGEST_QUOTE] + "…"


def cause(cells: pd.Series, values: np.ndarray, decimal: Decimal) -> tuple[Sentence, str]:
    """Return what is wrong with cells that are no numbers, and one of them.

    ``values`` are the column's numbers, NaN where there is none.
    """
    few = [str(cell).strip() for cell in (*cells.head(200), *cells.tail(50))]
    destroyed = next(filter(is_destroyed, few), None)
    if destroyed is not None:
        return Sentence("numbers a spreadsheet has destroyed"), destroyed
    units = {unit: text for text in few if (unit := _with_unit(text, ".") or _with_unit(text, ","))}
    if len(units) > 1:
        return Sentence("numbers in several units"), ", ".join(map(quoted, list(units.values())[:2]))
    numbers = [match for text in few if (match := _THOUSANDS.match(text))]
    if 2 * len(numbers) > len(few):
        sign, shown = numbers[0]["sign"], quoted(numbers[0][0])
        finite = values[np.isfinite(values)]
        if sign not in ".," or any(match["rest"] for match in numbers) or (len(finite) and np.median(finite) > 100):
            return Sentence("numbers in which {sign!r} parts thousands", sign=sign), shown
        return Sentence("numbers in which {sign!r} parts thousands or is the decimal sign", sign=sign), shown
    if sum(kind_of_cells(text, _OTHER[decimal]) == "number" for text in few) * 2 > len(few):
        text = Sentence("numbers with the decimal sign {sign!r}, beside others with {usual!r}", sign=_OTHER[decimal],
                        usual=decimal)  # fmt: skip
        return text, quoted(few[0])
    return TEXT, quoted(few[0])
