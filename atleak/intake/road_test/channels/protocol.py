"""What a format hands over: a table, and what came of reading it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import pandas as pd

from atleak.intake.road_test.clock.clocks import Clock
from atleak.intake.road_test.clock.timeline import Timeline
from atleak.intake.road_test.files.cells import Decimal
from atleak.intake.road_test.files.layout import Heading, Row
from atleak.road_test import Segment


class LogTable(Protocol):
    """What a format gives: headings, a few rows to look at, and columns on request."""

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
    def read(self, columns: Sequence[int]) -> pd.DataFrame: ...


@dataclass(frozen=True)
class TableResult:
    """What came of a table: rows counted and the time base; the signals are with the assigner."""

    rows: int
    timeline: Timeline
    time_label: str
    clock: Clock
    long: bool = False
    used: frozenset[str] = frozenset()
    file_segments: tuple[Segment, ...] | None = None


def reach(sample: Sequence[Row]) -> int:
    """Cells of the widest row."""
    return max((len(row) for row in sample), default=0)
