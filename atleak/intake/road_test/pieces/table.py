"""Reads a large table with a time column into columns on disk, as `channels.reader` reads one that is held."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import replace

import numpy as np
import pandas as pd

from atleak.columns import DiskColumn, spans
from atleak.intake.road_test.channels.assign import Assigner, Candidate, find_candidates, map_columns
from atleak.intake.road_test.channels.column_values import (
    REMARKS,
    LeftOut,
    last_filled,
    without_words,
    words_for_time,
)
from atleak.intake.road_test.channels.headers_between import check_clock_stated_again, with_units_stated_again
from atleak.intake.road_test.channels.long import long_shape
from atleak.intake.road_test.channels.protocol import LogTable, TableResult
from atleak.intake.road_test.channels.reader import no_header, own_times, refuse_split_decimals, time_candidates
from atleak.intake.road_test.channels.timing import best_clock, motions_beside, no_time
from atleak.intake.road_test.channels.unit_cells import columns_of_units
from atleak.intake.road_test.files.delimited import counted_short, refuse_too_wide
from atleak.intake.road_test.pieces import timelines
from atleak.intake.road_test.pieces.columns import ChannelColumn, TimeColumn
from atleak.intake.road_test.pieces.spool import Spool, too_large_for
from atleak.intake.road_test.pieces.timelines import OF_CLOCK, PIECE, LargeTimeline
from atleak.road_test import QUANTITIES
from atleak.sentence import Sentence

Blocks = Callable[[Sequence[int]], Generator[pd.DataFrame]]
"""Gives some columns of a table block by block, each as `LogTable.read` gives the whole."""


def read_in_pieces(
    table: LogTable, blocks: Blocks, assigner: Assigner, mapping: Mapping[str, str], spool: Spool, rows: float
) -> tuple[TableResult, LargeTimeline]:
    """Read a table's time and quantities; the assigner gets the signals.

    Parameters
    ----------
    rows
        how many it has, more or less.

    Raises
    ------
    RoadTestError
        as `channels.reader.read_table`, and of a form of table that is not read in pieces.
    """
    if not table.has_header and not mapping:
        raise no_header(table, assigner)
    candidates = map_columns(find_candidates(table.headings), table.headings, mapping, assigner.file)
    one_column_each = Sentence("one column for each quantity, and one for the time")
    if long_shape(table, candidates, mapping) is not None:
        what = Sentence("a table with one signal below the other")
        raise too_large_for(assigner.file, what, one_column_each)
    candidates = [candidate for candidate in candidates if candidate.heading.index < table.width]
    refuse_split_decimals(table, assigner)
    times = time_candidates(table, candidates)
    channels = [candidate for candidate in candidates if candidate.quantity != "time"]
    if own_times(table.headings, times, channels) is not None:
        what = Sentence("a table with a clock for each signal")
        raise too_large_for(assigner.file, what, one_column_each)
    read = _Reading(table, times, channels, assigner, spool)
    spool.check_room(rows * (2 * len(channels) + OF_CLOCK * max(len(times), 1)))  # as they are read, and on the base
    with closing(blocks(read.columns)) as frames:  # what reads them goes on with other files
        for frame in frames:
            read.add(frame)
    return read.result()


class _Reading:
    """A table that is read block by block."""

    def __init__(
        self, table: LogTable, times: list[Candidate], channels: list[Candidate], assigner: Assigner, spool: Spool
    ) -> None:
        self.table, self.assigner, self.spool = table, assigner, spool
        self.times = [TimeColumn(candidate, spool) for candidate in times]
        self.channels = [ChannelColumn(candidate, spool) for candidate in channels]
        self.units = {each.channel.heading.index: each for each in columns_of_units(channels, table)}
        self.left = LeftOut(above=table.above)
        self.rows = self.lines = self.words_for_time = self._blank = 0
        self._filled = False
        self._before: dict[int, int] = {}  # rows before a line that states a unit again
        self._remarks: bool | None = None  # whether words in place of the time are remarks: the first block tells

    @property
    def _every(self) -> Iterator[ChannelColumn | TimeColumn]:
        yield from self.times
        yield from self.channels

    @property
    def columns(self) -> list[int]:
        """Return which columns are read."""
        used = {each.candidate.heading.index for each in self._every}
        return sorted(used | {each.heading.index for each in self.units.values()}) or [0]

    def add(self, frame: pd.DataFrame) -> None:
        """Add the next block."""
        times, channels = [each.candidate for each in self.times], [each.candidate for each in self.channels]
        self.left.add(LeftOut.of(frame, self.table))
        words = words_for_time(frame, times, self.table)
        if self._remarks is None:
            self._remarks = len(words) < REMARKS * len(frame)
        words = words if self._remarks else words[:0]
        self.words_for_time += len(words)
        before, units = len(frame), {each.heading.index: each for each in self.units.values()}
        beside = frame[[index for index in units if index in frame]]
        attributes = frame.attrs
        frame = frame.drop(columns=list(beside.columns))
        frame.attrs = attributes
        frame, lines = without_words(frame, times, channels, self.table, self.assigner, words, self.lines)
        for again in self.assigner.again.values():
            stands = self.rows + self._blank + int(frame.index.searchsorted(again.row - self.lines))
            self._before.setdefault(again.row, stands)
        self.left.lines += lines
        self.lines += before
        for index, each in units.items():
            each.add(beside[index].reindex(frame.index))
        end = last_filled(frame)
        if end:
            self._take_blank()
            self._filled = True
            attributes, behind = frame.attrs, len(frame) - end
            frame = frame.iloc[:end]
            frame.attrs = attributes
            for column in self._every:
                column.add(frame, self.table)
            self.rows += end
            self._blank = behind
        else:
            self._blank += len(frame)

    def _take_blank(self) -> None:
        """Add the blank rows between others: only those at the end are left out."""
        if self._blank:
            for column in self._every:
                column.add_blank(self._blank)
            self.rows += self._blank
        self._blank = 0

    def result(self) -> tuple[TableResult, LargeTimeline]:
        """Decide what the columns are."""
        table, assigner = self.table, self.assigner
        if not self._filled:  # the columns are blank throughout, but the rows exist
            self._take_blank()
        self.left.blank = self._blank
        self.left.short = counted_short(self.left.short, self.lines, self.left.breaks_off)
        refuse_too_wide(self.left.too_wide, self.lines, assigner.file)
        self.left.say(assigner)
        if self.words_for_time >= REMARKS * max(self.lines, 1):
            raise no_time(table, assigner)
        used: list[str] = []
        offered: list[tuple[Candidate, DiskColumn | np.ndarray]] = []
        for column in self.channels:
            units = self.units.get(column.candidate.heading.index)
            channel = column.candidate if units is None else units.told(assigner)
            if channel is None:
                column.column.remove()
                continue
            used += [] if units is None else [units.heading.label]
            column.candidate = channel
            offered.append((channel, column.values(table, assigner)))
        columns = {candidate.heading.index: values for candidate, values in offered}
        told = with_units_stated_again([each for each, _ in offered], columns, self._before.__getitem__, assigner)
        offered = [(candidate, columns[candidate.heading.index]) for candidate in told]
        usable = [candidate for candidate, values in offered if isinstance(values, DiskColumn)]
        motions = motions_beside(usable, columns)
        clocks = {each.candidate.heading.index: each for each in self.times}
        units_before = {
            (index, again.row): clocks[index].unit_before(self._before[again.row])
            for index, again in assigner.again.items()
            if index in clocks
        }
        label, clock = best_clock(
            [each.candidate for each in self.times],
            table,
            assigner,
            lambda candidate: clocks[candidate.heading.index].clock(table, assigner, motions),
            self._counted,
        )
        check_clock_stated_again(
            [each.candidate for each in self.times],
            (label, clock),
            lambda candidate, line: units_before[candidate.heading.index, line],
            assigner,
        )
        assert isinstance(clock.seconds, DiskColumn)
        timeline = timelines.build(clock.seconds, self.spool)
        if not len(timeline.time):
            raise no_time(table, assigner)
        for quantity in QUANTITIES:
            of_quantity = [(candidate, values, None) for candidate, values in offered if candidate.quantity == quantity]
            if of_quantity:
                assigner.decide(quantity, of_quantity)
        taken = {id(signal.on_disk) for signal in assigner.signals.values()}
        for _, values in offered:
            if isinstance(values, DiskColumn) and id(values) not in taken:
                values.remove()
        result = TableResult(
            self.rows, timeline.told, label, replace(clock, seconds=np.empty(0)), used=(label, *used),
            left_out=self.left.rows,
        )  # fmt: skip
        return result, timeline

    def _counted(self, interval: float) -> DiskColumn:
        column = self.spool.column()
        for start, stop in spans(self.rows, PIECE):
            column.append(np.arange(start, stop) * interval)
        return column
