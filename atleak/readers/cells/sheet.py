"""A sheet as read, before anything in it is understood."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from itertools import groupby
from typing import Any

from atleak.common.errors import Place, ReadingsError
from atleak.common.sentences import Sentence
from atleak.measurements.readings import CellKind, CellMeaning, SheetCells
from atleak.readers.cells.workbook_marks import Marks

_RUNS_SHOWN = 12
NO_WIDTH = dict.fromkeys(map(ord, "\u200b\u200c\u200d\u2060\ufeff\u00ad"))  # signs that nobody sees, to be left out
Cell = Any  # str, float, int, bool, date or time; "" where empty
BRACKETS = re.compile(r"[\[(]([^\])]*)[\])]")  # and what stands in them
_SPACES = re.compile(r"\s+")
_DITTO = re.compile(
    r"""[-–—\s]*(?:["“”„″〃]|'{2}|’{2}|,,)[-–—\s]*|di?t?to\.?|idem|j\. ?w\.|[sw]\. ?o\.|то же""", re.IGNORECASE
)


@lru_cache(maxsize=8192, typed=True)  # 1, 1.0 and True are not the same text
def text_of(cell: Cell) -> str:
    """Return a cell as the label it is: 8.0 → "8", primes as one sign.

    >>> text_of(8.0), text_of(" 12′ ")
    ('8', "12'")
    """
    if isinstance(cell, float) and cell.is_integer():
        return str(int(cell))
    text = _SPACES.sub(" ", str(cell).replace("\u00a0", " ")).strip()
    return re.sub(r"\s*[′’‘`´ʹ]", "'", text)


@dataclass(frozen=True)
class Sheet:
    """Cells by row and column, both from 0.

    ``merged`` leads from every further cell of a merged range to its first. ``faults`` holds cells whose formula has
    no usable result. ``lines`` are the rows' numbers in the file where they differ from their position.
    """

    file: str
    name: str | None
    rows: Sequence[Sequence[Cell]]
    merged: Mapping[tuple[int, int], tuple[int, int]] = field(default_factory=dict)
    faults: Mapping[tuple[int, int], str] = field(default_factory=dict)
    lines: Sequence[int] | None = None
    hidden: bool = False
    note: Sentence | None = None  # how a text file was read
    marks: Marks = Marks()  # noqa: RUF009  frozen, so safe to share; rows, columns and cells hidden or crossed out
    turned: bool = False  # its rows are the columns of the file, because its headings run down the first one
    derived: Mapping[int, int] = field(default_factory=dict)  # columns made from others of the file, and from which

    @property
    def is_text(self) -> bool:
        return self.name is None

    def cell(self, row: int, column: int) -> Cell:
        """Return what stands in the cell itself; "" outside the sheet."""
        if row < len(self.rows) and column < len(self.rows[row]):
            return self.rows[row][column]
        return ""

    def filled(self, row: int, column: int) -> Cell:
        """Return what `cell` returns, but in a merged range what its first cell holds, at a ditto what is above."""
        cell = self.cell(*self.merged.get((row, column), (row, column)))
        ditto = isinstance(cell, str) and row > 0 and not self.turned and _DITTO.fullmatch(cell)
        return self.filled(row - 1, column) if ditto else cell

    @cached_property
    def width(self) -> int:
        return max((len(row) for row in self.rows), default=0)

    def is_struck(self, row: int, column: int) -> bool:
        """Return whether what stands there, or in the first cell of its merged range, is crossed out."""
        return self.merged.get((row, column), (row, column)) in self.marks.struck

    def row_number(self, row: int) -> int:
        """Return the row's number as a spreadsheet or an editor shows it; of a turned sheet that of the column."""
        return self.lines[row] if self.lines is not None and not self.turned else row + 1

    def place(self, row: int | None = None, column: int | None = None, heading: str = "") -> Place:
        """Return where a cell is: a workbook's column by its letter, a text file's by its heading."""
        if column is not None:
            column = self.derived.get(column, column)
        if self.turned:
            line = None if column is None else self.lines[column] if self.lines is not None else column + 1
            return Place(self.file, self.name, line, None if row is None else self._column_said(row))
        where = None if column is None else (heading if self.is_text else "") or self._column_said(column)
        return Place(self.file, self.name, None if row is None else self.row_number(row), where)

    def _column_said(self, column: int) -> str:
        return str(column + 1) if self.is_text else column_letter(column)


def rows_named(sheet: Sheet, rows: Sequence[int]) -> Sentence:
    """Name rows as a spreadsheet or an editor numbers them: "row 4", "rows 2–5, 9"."""
    runs = runs_of(sheet.row_number(row) for row in rows)
    shown = ", ".join(f"{run[0]}" if len(run) == 1 else f"{run[0]}–{run[-1]}" for run in runs[:_RUNS_SHOWN])
    numbers = shown + (" …" if len(runs) > _RUNS_SHOWN else "")
    if len(runs) > 1 or len(runs[0]) > 1:
        return Sentence("rows {numbers}", numbers=numbers)
    return Sentence("row {numbers}", numbers=numbers)


def runs_of(numbers: Iterable[int]) -> list[list[int]]:
    """Return numbers in order, those together that follow each other.

    >>> runs_of([4, 1, 2])
    [[1, 2], [4]]
    """
    ordered = enumerate(sorted(set(numbers)))
    return [[number for _, number in run] for _, run in groupby(ordered, key=lambda each: each[1] - each[0])]


def column_letter(column: int) -> str:
    """Return the letters by which a spreadsheet names a column, counted from 0.

    >>> column_letter(0), column_letter(27)
    ('A', 'AB')
    """
    before, last = divmod(column, 26)
    return (column_letter(before - 1) if before else "") + chr(ord("A") + last)


def sheet_cells(
    page: Sheet, done: Mapping[tuple[int, int], CellMeaning], problems: Iterable[ReadingsError] = ()
) -> SheetCells:
    """Return a sheet as it stands in the file, with what its cells became; where problems stand they are refused."""
    meanings = [
        [None if text_of(cell) == "" else done.get((row, column)) for column, cell in enumerate(cells)]
        for row, cells in enumerate(page.rows)
    ]
    numbers = [page.row_number(row) for row in range(len(page.rows))]
    at = {number: row for row, number in enumerate(numbers)}
    for problem in problems:
        row, column = at.get(problem.place.row or 0), problem.place.column
        if row is None:
            continue
        headed = (cells for cells in page.rows if any(text_of(cell) == column for cell in cells))
        named = [index for cells in headed for index, cell in enumerate(cells) if text_of(cell) == column]
        letters_of = (str(index + 1) if page.is_text else column_letter(index) for index in range(page.width))
        index = {letter: index for index, letter in enumerate(letters_of)}.get(column or "", next(iter(named), None))
        for column_at, cell in enumerate(page.rows[row]):
            if index == column_at or (column is None and text_of(cell)):
                meanings[row][column_at] = CellMeaning(CellKind.REFUSED, problem.problem)
    return SheetCells(page.name, page.rows, meanings, numbers)
