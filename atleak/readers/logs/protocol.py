"""Declares the result of reading a table, and how wide its rows are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from atleak.measurements.road_test import Segment
from atleak.readers.logs.clock import Clock
from atleak.readers.logs.log_cells import to_float
from atleak.readers.logs.log_table import LogTable
from atleak.readers.logs.timeline import Timeline


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


def bytes_of(table: LogTable, columns: Sequence[int]) -> float:
    """Return how many bytes the cells of a row take: eight as a number, as text by their length."""
    width = 0.0
    for index in columns:
        cells = table.sampled(index)
        texts = [cell for cell in cells if cell and np.isnan(to_float(cell, table.decimal))]
        width += 8 + (20 + sum(map(len, texts)) / len(texts) if 2 * len(texts) > len(cells) else 0)
    return width
