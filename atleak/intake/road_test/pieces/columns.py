"""Puts the columns of a large table on the disk as its blocks come, and keeps what tells how they are to be read."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from typing import Literal

import numpy as np
import pandas as pd

from atleak.columns import DiskColumn, spans
from atleak.intake.road_test.channels.assign import Assigner, Candidate
from atleak.intake.road_test.channels.column_values import CellTally
from atleak.intake.road_test.channels.protocol import LogTable
from atleak.intake.road_test.channels.timing import (
    TimeNumbers,
    clock_of_numbers,
    holds_clock_strings,
    probe_of,
    say_destroyed,
)
from atleak.intake.road_test.clock.clocks import (
    Clock,
    ClockParts,
    ClockTally,
    Motion,
    NumericForm,
    numeric_form,
    read_clocks,
)
from atleak.intake.road_test.clock.timeline import Running
from atleak.intake.road_test.files.delimited import numbers
from atleak.intake.road_test.pieces.spool import Spool
from atleak.intake.road_test.pieces.timelines import PIECE

_CLOCK_PARTS = np.dtype([("major", "i4"), ("minor", "i4"), ("seconds", "f8"), ("parts", "i1"), ("dates", "i4")])


class ChannelColumn:
    """A column that may be a channel."""

    def __init__(self, candidate: Candidate, spool: Spool) -> None:
        self.candidate, self.column = candidate, spool.column()
        self.tally = CellTally(candidate.quantity)

    def add(self, frame: pd.DataFrame, table: LogTable) -> None:
        """Add the cells of the next block."""
        index = self.candidate.heading.index
        self.column.append(self.tally.add(numbers(frame, index, table.decimal), frame.index))

    def add_blank(self, rows: int) -> None:
        """Add rows without a cell."""
        self.tally.cells += rows
        self.column.append(np.full(rows, np.nan))

    def values(self, table: LogTable, assigner: Assigner) -> DiskColumn | np.ndarray:
        """Return the numbers, or nothing but NaN where they cannot be used, which is said."""
        if self.tally.usable(self.candidate, self.column, table.decimal, assigner):
            return self.column
        self.column.remove()
        return np.array([np.nan])


class TimeColumn:
    """A column that may be the clock: numbers, clock strings, or dates with times."""

    def __init__(self, candidate: Candidate, spool: Spool) -> None:
        self.candidate, self._spool = candidate, spool
        self._kind: Literal["numbers", "strings", "stamps"] | None = None
        self._column: DiskColumn | None = None
        self._probe: list[str] = []
        self._strings = ClockTally()
        self._first: pd.Timestamp | None = None
        self._words: list[str] = []
        self._last_words: deque[str] = deque(maxlen=50)
        self._unreadable = self._finite = 0

    def add(self, frame: pd.DataFrame, table: LogTable) -> None:
        """Add the cells of the next block; the first one tells what they are."""
        cells = frame[self.candidate.heading.index]
        if self._column is None:
            self._begin(cells)
        assert self._column is not None
        if self._kind == "strings":
            read = read_clocks(cells)
            self._strings.add(read, int(cells.notna().sum()))
            parts = np.empty(len(cells), _CLOCK_PARTS)
            for name in _CLOCK_PARTS.names or ():
                parts[name] = getattr(read, name)
            self._column.append(parts)
        elif self._kind == "stamps":
            stamps = cells.dropna()
            if self._first is None and len(stamps):
                self._first = stamps.iloc[0]
            seconds = np.full(len(cells), np.nan)
            if self._first is not None:
                seconds = np.round((cells - self._first).dt.total_seconds().to_numpy(), 9)
            self._column.append(seconds)
        else:
            values, words, _ = numbers(frame, self.candidate.heading.index, table.decimal)
            self._unreadable += len(words)
            self._words += [str(word) for word in words.head(max(200 - len(self._words), 0))]
            self._last_words.extend(str(word) for word in words.tail(50))
            self._finite += int(np.isfinite(values).sum())
            self._column.append(values)

    def _begin(self, cells: pd.Series) -> None:
        if cells.dtype.kind == "M":
            self._kind = "stamps"
        elif cells.dtype.kind not in "fiub":
            self._probe = probe_of(cells)
            self._kind = "strings" if holds_clock_strings(self._probe, self.candidate) else "numbers"
        else:
            self._kind = "numbers"
        self._column = self._spool.column(_CLOCK_PARTS if self._kind == "strings" else np.float64)

    def add_blank(self, rows: int) -> None:
        """Add rows without a cell."""
        if self._column is None:
            self._begin(pd.Series(dtype=float))
        assert self._column is not None
        nothing = np.zeros(rows, _CLOCK_PARTS) if self._kind == "strings" else np.full(rows, np.nan)
        self._column.append(nothing)

    def unit_before(self, row: int) -> str:
        """Return in which unit the numbers before a row seem to be; nothing of clock strings and dates."""
        if self._kind != "numbers" or self._column is None:
            return ""
        return numeric_form(self._column.part(0, row), None).unit

    def clock(self, table: LogTable, assigner: Assigner, motions: Sequence[Motion]) -> Clock | None:
        """Return the clock; None where it cannot be read, which is said where a spreadsheet has spoilt it."""
        column = self._column
        if column is None:
            return None
        if self._kind == "stamps":
            day = None if self._first is None else self._first.date()
            return Clock(column, "clock", False, "date and time", date=day)
        if self._kind == "strings":
            return self._of_strings(column)
        if say_destroyed(self.candidate, self._probe, assigner):
            return None
        words = pd.Series([*self._words, *self._last_words], dtype="str")
        read = TimeNumbers(column, words, self._unreadable, self._finite)

        def converted(form: NumericForm) -> Clock:
            if not form.as_is:
                runs = Running(form.period)
                for start, stop in spans(len(column), PIECE):
                    column.write(start, form.seconds(column[start:stop], runs))
            return form.clock(column)

        return clock_of_numbers(self.candidate, read, table, assigner, motions, converted)

    def _of_strings(self, parts: DiskColumn) -> Clock | None:
        form = self._strings.form()
        if form is None:
            return None
        seconds, runs = self._spool.column(), Running(form.period)
        for start, stop in spans(len(parts), PIECE):
            part = parts[start:stop]
            read = ClockParts(
                major=part["major"].astype(float),
                minor=part["minor"].astype(float),
                seconds=part["seconds"],
                parts=part["parts"],
                fraction=np.zeros(len(part), bool),
                dates=part["dates"],
            )
            seconds.append(form.seconds(read, runs))
        parts.remove()
        return form.clock(seconds)
