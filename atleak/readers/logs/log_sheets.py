"""Opens workbooks: a log on one sheet, or one signal per sheet with its own time.

Cells are held block by block and column by column, numbers packed.
"""

from __future__ import annotations

import datetime as dt
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import islice

import numpy as np
import pandas as pd

from atleak.common.errors import RoadTestError
from atleak.readers.cells.extent import cut
from atleak.readers.dates import words
from atleak.readers.logs.delimited import every_nth
from atleak.readers.logs.headings import VALUE_HEADERS, Heading, HeadRow, nameless
from atleak.readers.logs.log_cells import MISSING, OFF, Decimal, without_unit
from atleak.readers.logs.log_file import LogFile
from atleak.readers.logs.log_table import Layout, LogTable, find_table
from atleak.readers.logs.names import match_name, split_unit
from atleak.readers.process.parent import WORKBOOK, read_apart
from atleak.readers.process.workbooks import log_blocks

_Cell = object  # str, float, int, bool, date or time; None where empty
_Column = bytes | list[_Cell]  # packed floats where every cell is a number or empty (NaN), else a list of cells


@dataclass
class SheetCells:
    """The cells of one sheet in ``blocks`` of rows: how many, and their columns."""

    blocks: list[tuple[int, list[_Column]]] = field(default_factory=list)

    @property
    def rows(self) -> int:
        """Return the number of rows."""
        return sum(count for count, _ in self.blocks)

    def head(self, most: int) -> list[list[_Cell]]:
        """Return the first rows."""
        _, columns = self.blocks[0]
        return [list(row) for row in islice(zip(*map(_cells, columns), strict=True), most)]

    def column(self, index: int, start: int) -> np.ndarray | list[_Cell]:
        """Return a column from a row of the first block on: floats where every cell is a number or empty."""
        parts: list[_Column] = [
            columns[index] if index < len(columns) else [None] * count for count, columns in self.blocks
        ]
        first, *others = _cells(parts[0])[start:], *parts[1:]
        packed = [np.frombuffer(part) for part in others if isinstance(part, bytes)]
        if len(packed) == len(others) and all(cell is None or isinstance(cell, int | float) for cell in first):
            return np.concatenate([np.array([np.nan if cell is None else cell for cell in first], float), *packed])
        return [*first, *(cell for part in others for cell in _cells(part))]


def _cells(column: _Column) -> list[_Cell]:
    if isinstance(column, list):
        return column
    return [None if cell != cell else cell for cell in np.frombuffer(column).tolist()]


_GENERIC_NAMES = VALUE_HEADERS | {"", "y", "signal"}
_HEAD = 2000  # rows of a sheet among which its table is sought


@dataclass(frozen=True)
class LogSheet(LogTable):
    """One sheet whose table is located."""

    name: str
    cells: SheetCells
    layout: Layout
    decimal: Decimal
    titled: bool = False

    @cached_property
    def headings(self) -> tuple[Heading, ...]:  # type: ignore[override]
        """Return the columns' headings; a column with a name such as *value* takes the sheet's name."""
        if not self.titled:
            return self.layout.headings
        split = split_unit(self.name)
        result = []
        for heading in self.layout.headings:
            has_quantity = any(match_name(name) for name in heading.names)
            if heading.index == 0 and self._is_a_pair_without_names:
                heading = replace(heading, names=("time",))
            elif not has_quantity and (nameless(heading) or words(heading.names[0]) in _GENERIC_NAMES):
                heading = Heading(heading.index, self.name, (split.text,), heading.unit or split.unit)
            result.append(heading)
        return tuple(result)

    @property
    def _is_a_pair_without_names(self) -> bool:
        """Return whether it is a signal and, in front of it, its time, neither of which is named."""
        return self.width == 2 and all(map(nameless, self.layout.headings))

    @property
    def has_header(self) -> bool:
        """Return whether any row names the columns, or the sheet's own name does."""
        return self.layout.has_header or (self.titled and self._is_a_pair_without_names)

    @cached_property
    def sample(self) -> tuple[HeadRow, ...]:  # type: ignore[override]
        """Return the first data rows as text."""
        body = self.cells.head(self.layout.start + 400)[self.layout.start :]
        return tuple([text_of_cell(cell, self.decimal) for cell in row] for row in body)

    @property
    def rows(self) -> int:  # type: ignore[override]
        """Return how many rows there are, blank ones among them."""
        return self.cells.rows - self.layout.start

    def read(self, columns: Sequence[int], every: int = 1) -> pd.DataFrame:
        """Read these columns."""
        return every_nth(pd.DataFrame({index: self._column(index) for index in columns}), every)

    def _column(self, index: int) -> pd.Series:
        cells = self.cells.column(index, self.layout.start)
        column = pd.Series(cells) if isinstance(cells, np.ndarray) else _column(cells)
        unit = self.layout.cell_units.get(index)
        return column if unit is None or column.dtype != "str" else without_unit(column, unit)


def text_of_cell(cell: object, decimal: Decimal = ".") -> str:
    """Return a cell as a logger would have written it."""
    if cell is None:
        return ""
    if isinstance(cell, bool):
        return "1" if cell else "0"
    if isinstance(cell, float):
        text = str(int(cell)) if cell.is_integer() and abs(cell) < 1e15 else repr(cell)
        return text.replace(".", ",") if decimal == "," else text
    if isinstance(cell, dt.datetime):
        return cell.isoformat(sep=" ")
    if isinstance(cell, dt.time):
        return cell.isoformat()
    if isinstance(cell, dt.timedelta):
        seconds = cell.total_seconds()
        return f"{int(seconds // 3600)}:{int(seconds % 3600 // 60):02d}:{seconds % 60:06.3f}"
    return str(cut(str(cell).strip()))


def _column(cells: list[object]) -> pd.Series:
    floats = np.full(len(cells), np.nan)
    for index, cell in enumerate(cells):
        if isinstance(cell, int | float):
            floats[index] = cell
        elif cell is None or (isinstance(cell, str) and cell.strip().lower() in MISSING - {OFF}):
            continue
        else:
            break
    else:
        return pd.Series(floats)
    if any(isinstance(cell, dt.date | dt.time | dt.timedelta) for cell in cells):
        return pd.Series(cells, dtype=object)
    return pd.Series([None if cell is None or cell == "" else text_of_cell(cell) for cell in cells], dtype="str")


def open_log_sheets(source: LogFile) -> list[LogSheet]:
    """Return every sheet of a workbook that holds a table."""
    by_name: dict[str, SheetCells] = {}
    blocks = read_apart(log_blocks, source.data, source.file, RoadTestError, WORKBOOK)
    for name, count, columns in blocks:
        by_name.setdefault(name, SheetCells()).blocks.append((count, columns))
    sheets = [_sheet(name, cells) for name, cells in by_name.items()]
    return [sheet for sheet in sheets if sheet is not None]


def _sheet(name: str, cells: SheetCells) -> LogSheet | None:
    """Locate the table on a sheet; None where there is none."""
    rows = cells.head(_HEAD)
    width = max((index + 1 for row in rows for index, cell in enumerate(row) if cell is not None), default=0)
    if width < 2:
        return None
    for row in rows:
        del row[width:]
    for decimal in (".", ","):
        texts = [[text_of_cell(cell, decimal) for cell in row] for row in rows]
        layout = find_table([_without_blank_end(row) for row in texts], decimal)
        if layout is not None:
            best: Decimal = decimal
            text = [cell for row in rows[layout.start :] for cell in row if isinstance(cell, str)]
            commas = sum("," in cell and cell.replace(",", "", 1).lstrip("-").isdigit() for cell in text)
            if decimal == "." and commas > 0.1 * max(len(text), 1):
                continue
            return LogSheet(name, cells, layout, best)
    return None


def _without_blank_end(row: HeadRow) -> HeadRow:
    """Return a row without the blank cells at its end, but never less than two cells wide."""
    end = max((index + 1 for index, cell in enumerate(row) if cell), default=0)
    return row if end > len(row) // 2 else row[: max(end, 1)]
