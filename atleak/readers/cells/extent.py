"""How much a table holds that people fill in: what is far more is refused before anybody looks for its meaning.

A person's sheet is looked at in many ways, each slow; a log, which is long, is read by other code.

The child process that reads workbooks imports this: nothing heavy at its top.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from atleak.common.sentences import Sentence

_ROWS, COLUMNS, _CELLS = 10_000, 300, 50_000  # that a sheet may reach, and fill; a measuring sheet fills some thousands
_WORDS = 5_000  # different texts with a letter in them, on one sheet
MOST_SHEETS = 200  # of one workbook
LETTERS = 300  # of a cell that are read; what follows is no part of a name, a heading or a number
MOST_TABLES = 200  # under headings of their own on one sheet
FAULTS = 300  # after which no more of a file is read: it is not what it was given as
MOST_TEXT = 4 << 20  # bytes of a text file

EXPECTED = Sentence(
    "a table that was filled in at a bench: at most {rows} rows, {columns} columns and {cells} filled cells",
    rows=_ROWS,
    columns=COLUMNS,
    cells=_CELLS,
)


def trimmed(rows: Sequence[Sequence[Any]]) -> list[list[Any]]:
    """Return rows without the blank ones at their end and the blank columns at the right.

    >>> trimmed([["a", "", ""], [1.5, " ", ""], [""]])
    [['a'], [1.5]]
    """
    ends = [_end(row) for row in rows]
    height = next((number for number in range(len(ends), 0, -1) if ends[number - 1]), 0)
    width = max(ends, default=0)
    return [list(row[:width]) for row in rows[:height]]


def bounded(rows: Sequence[Sequence[Any]]) -> list[list[Any]]:
    """Return rows as `trimmed` does, of a long text its beginning: of a table in which it is a heading or a remark."""
    return [[cut(cell) for cell in row] for row in trimmed(rows)]


def excess(rows: Sequence[Sequence[Any]]) -> Sentence | None:
    """Return what of a sheet is more than people fill in; None where nothing is."""
    width = max(map(len, rows), default=0)
    filled = sum(cell != "" for row in rows for cell in row)
    if len(rows) <= _ROWS and width <= COLUMNS and filled <= _CELLS:
        texts = {cell for row in rows for cell in row if isinstance(cell, str)}
        worded = sum(any(map(str.isalpha, text)) for text in texts) if len(texts) > _WORDS else 0
        if worded <= _WORDS:
            return None
        return Sentence("this sheet has {count} different texts", count=worded)
    text = Sentence("this sheet has {rows} rows, {columns} columns and {cells} filled cells")
    return text.of(rows=len(rows), columns=width, cells=filled)


def _end(row: Sequence[Any]) -> int:
    """Return how many cells there are up to the last that is filled."""
    ends = (at for at in range(len(row), 0, -1) if row[at - 1] != "" and not str(row[at - 1]).isspace())
    return next(ends, 0)


def cut(cell: Any) -> Any:
    """Return what stands in a cell, of a long text its beginning."""
    return f"{cell[:LETTERS]}…" if isinstance(cell, str) and len(cell) > LETTERS else cell
