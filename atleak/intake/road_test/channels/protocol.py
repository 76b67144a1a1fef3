"""Declares what a file format provides: a table to read, and the result of reading it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import pandas as pd

from atleak.intake.road_test.clock.clocks import Clock
from atleak.intake.road_test.clock.timeline import Timeline
from atleak.intake.road_test.files.cells import Decimal
from atleak.intake.road_test.files.headings import Heading, Row
from atleak.road_test import Segment


class LogTable(Protocol):
    """A table of any file format: headings, some rows as a sample, and columns on request."""

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
    def read(self, columns: Sequence[int]) -> pd.DataFrame: ...


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
