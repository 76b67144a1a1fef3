"""Workbooks (xlsx, xlsb, xls, ods) into sheets, merged ranges and unusable formulas included."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from atleak.errors import ReadingsError
from atleak.intake.native.process import WORKBOOK, read_apart
from atleak.intake.native.workbooks import Range, first_rows, measuring_sheets, stray_cells
from atleak.intake.sheets.sheet import NO_WIDTH, Cell, Sheet
from atleak.intake.workbook_marks import Marks


def read_workbook(data: bytes, file: str, *, only_look: bool = False) -> list[Sheet]:
    """Read all worksheets of a workbook.

    Parameters
    ----------
    only_look
        read no more than their first rows, of a workbook that holds a log too.

    Raises
    ------
    ReadingsError
        where the file is damaged, protected by a password, holds more cells than a measuring sheet can, or takes more
        time or memory than a workbook of its size may.
    """
    read = first_rows if only_look else measuring_sheets
    return [
        Sheet(
            file=file,
            name=worksheet["name"],
            rows=[_seen(row) for row in worksheet["rows"]],
            merged=_merged(worksheet["merged"]),
            faults=worksheet["faults"],
            hidden=worksheet["hidden"],
            marks=Marks(**worksheet["marks"]),
        )
        for worksheet in read_apart(read, data, file, ReadingsError, WORKBOOK, stray_cells)
    ]


def _seen(row: Sequence[Cell]) -> Sequence[Cell]:
    """Return a row without the signs in its texts that nobody sees."""
    if all(not isinstance(cell, str) or cell.isascii() for cell in row):
        return row
    return [cell.translate(NO_WIDTH).strip() if isinstance(cell, str) else cell for cell in row]


def _merged(ranges: Iterable[Range]) -> dict[tuple[int, int], tuple[int, int]]:
    return {
        (row, column): (top, left)
        for (top, left), (bottom, right) in ranges
        for row in range(top, bottom + 1)
        for column in range(left, right + 1)
        if (row, column) != (top, left)
    }
