"""Opens Parquet logs: one table whose columns have names, types and perhaps units."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from atleak.common.errors import RoadTestError
from atleak.common.sentences import Sentence
from atleak.readers.logs.delimited import Filled
from atleak.readers.logs.headings import HeadRow, headings_of, names_columns
from atleak.readers.logs.log_cells import Decimal, kind_of_cells, unit_in_cells, without_unit
from atleak.readers.logs.log_file import LogFile, open_source
from atleak.readers.logs.log_sheets import text_of_cell
from atleak.readers.logs.log_table import Layout, LogTable
from atleak.readers.process.parent import PARQUET, read_apart, read_apart_in_parts
from atleak.readers.process.parquet import parquet_head, parquet_parts

_SAMPLE = 400  # rows
_LARGEST = 400 << 20  # bytes of numbers to which even a small file may unfold


@dataclass(frozen=True)
class ParquetLog(LogTable):
    """A Parquet file of which the columns and the first rows are known."""

    source: LogFile
    layout: Layout
    kinds: tuple[str, ...]
    rows: int
    sample: tuple[HeadRow, ...]
    decimal: Decimal

    def read(self, columns: Sequence[int], every: int = 1) -> pd.DataFrame:
        """Read these columns block by block; stamps are dates with times in UTC."""
        limit = _LARGEST + int(PARQUET.memory_per_byte * self.source.size)
        numbers: dict[int, Filled] = {}
        texts: dict[int, list[pd.Series]] = {}
        done = 0
        parts = read_apart_in_parts(
            parquet_parts, self.source.apart, self.source.file, RoadTestError, PARQUET, columns=list(columns),
            limit=limit,
        )  # fmt: skip
        for block in (block for kind, block in parts if kind == "block"):
            for index, part in zip(columns, block, strict=True):
                cells = _cells(part, self.kinds[index])
                if isinstance(cells, pd.Series):
                    texts.setdefault(index, []).append(cells.iloc[-done % every :: every])
                else:
                    numbers.setdefault(index, Filled(self.rows, every, cells.dtype)).add(cells)
            done += len(cells)
            self.source.tell(done)
        together: dict[int, Any] = {index: pd.concat(parts, ignore_index=True) for index, parts in texts.items()}
        joined = together | {index: room.numbers for index, room in numbers.items()}
        frame = pd.DataFrame({index: joined[index] for index in columns}, copy=False)
        frame.attrs["lines"] = np.arange(0, done, every)
        for index, unit in self.layout.cell_units.items():  # which stands behind every number
            if index in frame and self.kinds[index] == "text":
                frame[index] = without_unit(frame[index], unit)
        return frame


def open_parquet(source: LogFile) -> ParquetLog:
    """Return the table of a Parquet file, of which only what it says of itself and the first rows are read."""
    ((_, parts),) = read_apart(parquet_parts, source.apart, source.file, RoadTestError, PARQUET)
    columns, rows = parts["columns"], parts["rows"]
    if not rows or not columns:
        raise source.error(Sentence("holds no rows: the logger wrote nothing"))
    _, (_, block) = read_apart(
        parquet_parts, source.apart, source.file, RoadTestError, PARQUET, columns=list(range(len(columns))),
        rows=_SAMPLE,
    )  # fmt: skip
    kinds = tuple(column["kind"] for column in columns)
    cells = [_cells_of(part, kind) for part, kind in zip(block, kinds, strict=True)]
    decimal = _decimal([text for texts, kind in zip(cells, kinds, strict=True) if kind == "text" for text in texts])
    texts = [[text_of_cell(cell, decimal) for cell in column] for column in cells]
    names = [column["name"].strip() for column in columns]
    units = {
        index: unit
        for index, (column, kind) in enumerate(zip(texts, kinds, strict=True))
        if kind == "text" and (unit := unit_in_cells(column, decimal))
    }
    headings = tuple(
        replace(heading, unit=units.get(heading.index) or column["unit"] or heading.unit)
        for heading, column in zip(headings_of([names], len(names)), columns, strict=True)
    )
    has_header = names_columns([[name for name in names if not name.isdigit()]])
    layout = Layout(0, len(names), headings, has_header, (), (names,), units)
    sample = tuple([list(row) for row in zip(*texts, strict=True)])
    return ParquetLog(source, layout, kinds, rows, sample, decimal)


def head_of_parquet(source: str | Path | bytes, name: str) -> bytes:
    """Return a small Parquet log with the first rows alone, by which it is told what its columns are."""
    opened = open_source(source, name)
    (head,) = read_apart(parquet_head, opened.apart, name, RoadTestError, PARQUET, rows=_SAMPLE)
    return head


def _cells(part: Any, kind: str) -> np.ndarray | pd.Series:
    """Return the cells of a column in a block."""
    if kind == "text":
        texts, places = part
        return pd.Series(pd.array(texts, dtype="str").take(np.frombuffer(places, np.int32), allow_fill=True))
    return np.frombuffer(part, "datetime64[ns]" if kind == "stamp" else np.float64)


def _cells_of(part: Any, kind: str) -> list[object]:
    """Return cells as they stand, None where they are blank."""
    cells = pd.Series(_cells(part, kind))
    return [None if blank else cell for cell, blank in zip(cells.tolist(), cells.isna(), strict=True)]


def _decimal(cells: Sequence[object]) -> Decimal:
    """Return the decimal sign of the numbers that are written as text."""
    texts = [cell for cell in cells if isinstance(cell, str) and "," in cell]
    commas = sum(kind_of_cells(text, ",") == "number" for text in texts)
    return "," if commas > 0.5 * len(texts) else "."
