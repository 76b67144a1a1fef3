"""Declares what a file format provides: a table to read, and the result of reading it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import pandas as pd

from atleak.intake.road_test.clock.clocks import Clock
from atleak.intake.road_test.clock.timeline import Timeline
from atleak.intake.road_test.files.cells import Decimal, to_float
from atleak.intake.road_test.files.headings import Heading, Row
from atleak.road_test import Segment


class LogTable(Protocol):
    """A table of any file format: headings, some rows as a sample, how many there are, and columns on request."""

    @property
    def headings(self) -> tuple[Heading, ...]: ...
    @property
    def has_header(self) -> bool: ...
    @property
    def sample(self) -> Sequence[Row]: ...
    @property
    def width(self) -> int: ...
    @property
    def preamble(self) -> Sequence[Row]: ...
    @property
    def decimal(self) -> Decimal: ...
    @property
    def above(self) -> int: ...
    @property
    def rows(self) -> int: ...  # more or less
    def read(self, columns: Sequence[int], every: int = 1) -> pd.DataFrame: ...


@dataclass(frozen=True)
class TableResult:
    """The result of reading a table: number of rows and time base; the assigner holds the signals."""

    rows: int
    timeline: Timeline
    time_label: str
    clock: Clock
    long: bool = False
    used: tuple[str, ...] = ()
    file_segments: tuple[Segment, ...] | None = None
    left_out: int = 0  # lines of the table that are no rows


def reach(sample: Sequence[Row]) -> int:
    """Return the number of cells in the widest row."""
    return max((len(row) for row in sample), default=0)


def width_of(table: LogTable, columns: Sequence[int]) -> float:
    """Return how many bytes the cells of a row take: eight as a number, as text by their length."""
    width = 0.0
    for index in columns:
        cells = [row[index] for row in table.sample if index < len(row)]
        texts = [cell for cell in cells if cell and np.isnan(to_float(cell, table.decimal))]
        width += 8 + (20 + sum(map(len, texts)) / len(texts) if 2 * len(texts) > len(cells) else 0)
    return width
