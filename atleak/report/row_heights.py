"""How high the rows of a sheet must be: not every program fits rows to their texts, nor has every one the same font."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable

_LINE = 13.5  # [pt] height of a line of text
LINE_OF_A_BOOK = 15.0  # [pt] the same of the larger letters of a workbook to be read on a screen
PENCIL = 27.0  # [pt] least height of a row to fill in by hand: 7 mm on paper at three quarters of its size
_FULL, _FULL_BOLD = 0.9, 0.75  # of a column's characters: without the sheet's font a program takes a wider one


def height_of(text: str, width: float, *, bold: bool = False, line: float = _LINE) -> float:
    """Return the height of a text [pt] in a column of so many characters, broken at spaces and line ends.

    >>> height_of("contact length", 20) < height_of("contact length of the land", 20)
    True
    """
    most = max(int((_FULL_BOLD if bold else _FULL) * width), 1)
    return line * sum(max(len(textwrap.wrap(part, most)), 1) for part in text.split("\n"))


def row_height(cells: Iterable[tuple[str, float]], *, bold: bool = False, line: float = _LINE) -> float:
    """Return the height of a row [pt] whose texts stand in columns of so many characters each."""
    return max(height_of(text, width, bold=bold, line=line) for text, width in cells)
