"""Read a table into signals and time.

A wide table has a time column, or one for each channel; in a long one a row is a time, a name, a value and perhaps a
unit. Units may stand in a column of their own beside the numbers; of several none is believed.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import pandas as pd

from atleak.common.errors import RoadTestError
from atleak.common.sentences import Sentence
from atleak.common.units import kinds_of
from atleak.measurements.road_test import QUANTITIES, Segment
from atleak.readers.dates import words
from atleak.readers.logs import names as words_as_numbers
from atleak.readers.logs.channels import say_strays
from atleak.readers.logs.clock import Clock, Motion
from atleak.readers.logs.columns import Assigner, Candidate, OfferedColumn, find_candidates, map_columns
from atleak.readers.logs.delimited import Cells, numbers
from atleak.readers.logs.headings import VALUE_HEADERS, Heading
from atleak.readers.logs.log_cells import kind_of_cells
from atleak.readers.logs.log_table import LogTable
from atleak.readers.logs.names import clean_unit, is_unit, match_name, split_unit
from atleak.readers.logs.rows import LeftOutRow, LogRows, columns_of_numbers, holds_clocks, rows_of_log
from atleak.readers.logs.time_column import (
    best_clock,
    clock_of,
    motions_beside,
    no_time,
    rising_without_name,
    runs_of_rows,
)
from atleak.readers.logs.timeline import Timeline
from atleak.readers.logs.timeline import build as build_timeline
from atleak.readers.logs.understood import TableResult
from atleak.readers.logs.units import same_unit
from atleak.readers.remembered_columns import NOT_LOGGED

UNIT_HEADERS = frozenset({"unit", "units", "einheit", "jednostka", "unite", "unidade", "единицы"})
_NAME_HEADERS = {
    "pid", "name", "signal", "channel", "parameter", "sensor", "kanal", "key", "item", "variable", "description",
    "signal name", "sensor name", "measurement", "parametr", "parameter name",
}  # fmt: skip


def with_units_beside(
    channels: list[Candidate], table: LogTable, rows: pd.Index, assigner: Assigner
) -> tuple[list[Candidate], tuple[str, ...]]:
    """Return the channels with the units of a column *Unit* on their right, and the names of those columns used.

    A channel in several units is left out, which a message says.
    """
    beside = {heading.index - 1: heading for heading in table.headings[: table.width] if _of_units(heading, table)}
    result: list[Candidate] = []
    used: list[str] = []
    for channel in channels:
        heading = beside.get(channel.heading.index) if channel.heading.unit is None else None
        if heading is None:
            result.append(channel)
            continue
        cells = table.read([heading.index], assigner.every)[heading.index].reindex(rows)
        unit, other = two_units(cells, QUANTITIES[channel.quantity].unit_kind)
        if other is not None:
            say_two_units(channel, unit, other, assigner)
            continue
        result.append(replace(channel, unit=unit or channel.unit))
        used.append(heading.label)
    return result, tuple(used)


def _of_units(heading: Heading, table: LogTable) -> bool:
    if not heading.names or words(heading.names[0]) not in UNIT_HEADERS:
        return False
    cells = list(filter(None, table.sampled(heading.index)))
    return sum(map(is_unit, cells)) > 0.8 * len(cells)


def two_units(cells: pd.Series, kind: str | None) -> tuple[str | None, str | None]:
    """Return the first unit in the cells of a column, and the first that is another; None where there is none."""
    written = cells.dropna().astype("str").str.strip().unique()
    units = [unit for text in written if (unit := clean_unit(text))]
    first = units[0] if units else None
    return first, next((unit for unit in units if not same_unit(units[0], unit, kind)), None)


def say_two_units(channel: Candidate, first: str | None, other: str, assigner: Assigner) -> None:
    """Say that a channel is not taken because its numbers are in several units."""
    text = Sentence("{column!r} holds numbers in several units ({first}, {other}): it is not used")
    assigner.refuse(channel, "column_refused", text, first=str(first), other=other)


@dataclass(frozen=True)
class _LongColumns:
    """The columns of a long table."""

    time: Candidate
    name: Heading
    value: Heading
    unit: Heading | None

    @property
    def headings(self) -> tuple[Heading, ...]:
        """Return the headings of all of them."""
        return (self.time.heading, self.name, self.value, *([self.unit] if self.unit else ()))


def long_shape(table: LogTable, candidates: list[Candidate], mapping: Mapping[str, str]) -> _LongColumns | None:
    """Return the columns of a long table, or None where the table is no such."""
    headings = [heading for heading in table.headings if heading.index < table.width]
    if not 3 <= len(headings) <= 8 or not table.sample:
        return None
    times = [candidate for candidate in candidates if candidate.quantity == "time"]
    if not times:
        return None

    def called(names: Collection[str]) -> list[Heading]:
        return [heading for heading in headings if heading.names and words(heading.names[0]) in names]

    value = next(iter(called(VALUE_HEADERS)), None)
    named = [heading for heading in called(_NAME_HEADERS) if _wordy(table, heading)]
    # else the column of words among which are names of quantities
    named += [
        heading
        for heading in headings
        if heading is not value and _wordy(table, heading)
        and any(match_name(split_unit(cell).text) for cell in set(table.sampled(heading.index)))
    ]  # fmt: skip
    if not named or value is None or _names_headings(table, mapping):
        return None
    return _LongColumns(times[0], named[0], value, next(iter(called(UNIT_HEADERS)), None))


def _names_headings(table: LogTable, mapping: Mapping[str, str]) -> bool:
    """Tell whether the user names headings of the table, and not names within its rows."""
    named = {quantity: column for quantity, column in mapping.items() if column != NOT_LOGGED}
    labels = {heading.label for heading in table.headings}
    return any(quantity != "time" for quantity in named) and all(column in labels for column in named.values())


def _wordy(table: LogTable, heading: Heading) -> bool:
    cells = table.sampled(heading.index)
    return sum(kind_of_cells(cell, table.decimal) == "text" for cell in cells) > 0.8 * len(cells)


class _LongRows:
    """The rows of a long table that name a signal, and the signals that they name."""

    def __init__(self, table: LogTable, shape: _LongColumns, assigner: Assigner | None = None) -> None:
        columns = sorted({heading.index for heading in shape.headings})
        if assigner is not None:
            assigner.refuse_too_large(table.rows, table.bytes_of_row(columns), thins=False)
        self.every = table.read(columns)
        names = self.every[shape.name.index].astype("str").str.strip()
        keep = self.every[shape.name.index].notna() & (names != shape.name.label)
        self.frame, self.shape, self.decimal = self.every[keep], shape, table.decimal
        self.codes, self.names = pd.factorize(names[keep])

    @cached_property
    def cells(self) -> Cells:
        """Return the numbers of all rows, and the cells that are none."""
        return numbers(self.frame, self.shape.value.index, self.decimal)

    @cached_property
    def headings(self) -> list[Heading]:
        """Return a heading for every signal, with the unit that its name or its rows state."""
        headings = []
        for index, name in enumerate(self.names):
            split = split_unit(str(name))
            unit = split.unit
            if unit is None and self.shape.unit is not None:
                units = self.frame[self.shape.unit.index].to_numpy(dtype=object)[self.of(index)]
                unit = next((str(cell) for cell in units if isinstance(cell, str) and cell.strip()), None)
            headings.append(Heading(index, str(name), (split.text,), unit))
        return headings

    def of(self, signal: int) -> np.ndarray:
        """Return which rows name a signal."""
        return self.codes == signal

    def has_two_units(self, candidate: Candidate, assigner: Assigner) -> bool:
        """Return whether the rows of a signal state two units, which is said."""
        if self.shape.unit is None or split_unit(candidate.label).unit is not None:
            return False
        units = self.frame[self.shape.unit.index][self.of(candidate.heading.index)]
        first, other = two_units(units, QUANTITIES[candidate.quantity].unit_kind)
        if other is not None:
            say_two_units(candidate, first, other, assigner)
        return other is not None

    def values(self, candidate: Candidate) -> np.ndarray:
        """Return the numbers of a signal; words for a gear, a range or a clutch are such, too."""
        rows = self.of(candidate.heading.index)
        values = self.cells[0][rows]
        if candidate.quantity in ("gear", "selector", "lock_up") and np.isnan(values).all():
            return words_as_numbers.as_numbers(candidate.quantity, self.frame[self.shape.value.index][rows])
        return values


def read_long(table: LogTable, shape: _LongColumns, assigner: Assigner, mapping: Mapping[str, str]) -> TableResult:
    """Read a long table: its signals go to the assigner."""
    rows = _LongRows(table, shape, assigner)
    left = LeftOutRow.of(rows.every, table)
    left.say(assigner)
    if nameless := len(rows.every) - len(rows.frame):
        text = Sentence("{count} row(s) name no signal, or repeat the header, and are left out")
        assigner.say("lines_left_out", text, count=nameless)
    clock = clock_of(shape.time, rows.frame, table, assigner, ())
    if clock is None or not runs_of_rows(clock.seconds):
        raise no_time(table, assigner)
    if clock.unit_assumed:
        assigner.assume_unit(shape.time.label, clock.unit, "time")
    whole = build_timeline(clock.seconds)
    row_times = np.full(len(rows.frame), np.nan)
    row_times[whole.order if whole.order is not None else slice(None)] = whole.time
    candidates = find_candidates(rows.headings)
    own_mapping = {quantity: column for quantity, column in mapping.items() if quantity != "time"}
    candidates = map_columns(candidates, rows.headings, own_mapping, assigner.file)
    assigner.neighbours = tuple(heading.unit for heading in rows.headings if heading.unit)
    offered: list[OfferedColumn] = []
    for candidate in (each for each in candidates if each.quantity != "time"):
        if rows.has_two_units(candidate, assigner):
            continue
        values, time = rows.values(candidate), row_times[rows.of(candidate.heading.index)]
        good = np.isfinite(values) & np.isfinite(time)
        by_time = np.argsort(time[good], kind="stable")[:: assigner.every]
        offered.append((candidate, values[good][by_time], time[good][by_time]))
    assigner.decide_all(offered)
    stamps = [signal.time for signal in assigner.signals.values() if signal.time is not None]
    base = np.unique(np.concatenate(stamps)) if stamps else np.unique(whole.time)
    names, left_out = tuple(map(str, rows.names)), left.rows + nameless
    return TableResult(
        len(rows.frame), _on_base(base, whole), shape.time.label, clock, True, names, whole.segments, left_out
    )


def long_columns(table: LogTable, shape: _LongColumns) -> Iterator[tuple[Heading, np.ndarray, pd.Series]]:
    """Yield the heading of every signal of a long table, its numbers and its cells that are none."""
    rows = _LongRows(table, shape)
    values, words_there = rows.cells
    for heading in rows.headings:
        these = rows.of(heading.index)
        yield heading, values[these], words_there[words_there.index.isin(rows.frame.index[these])]


def _on_base(base: np.ndarray, whole: Timeline) -> Timeline:
    """Return the file's timeline with its segments counted on another time base."""
    segments = []
    for segment in whole.segments:
        low = int(np.searchsorted(base, segment.start, side="left"))
        high = int(np.searchsorted(base, segment.stop, side="right"))
        if high > low:
            segments.append(Segment(low, high - low, float(base[low]), float(base[high - 1] - base[low])))
    return replace(whole, time=base, order=None, segments=tuple(segments))


def read_table(table: LogTable, assigner: Assigner, mapping: Mapping[str, str]) -> TableResult:
    """Read a table's time and quantities.

    A `RoadTestError` says that no column tells the time, numbers are destroyed, another header begins in the middle, or
    the table has no header and the user has not named columns.
    """
    headings = table.headings
    if not table.has_header and not mapping:
        raise no_header(table, assigner)
    candidates = map_columns(find_candidates(headings), headings, mapping, assigner.file)
    if (shape := long_shape(table, candidates, mapping)) is not None:
        return read_long(table, shape, assigner, mapping)
    return _read_wide(table, candidates, assigner)


def no_header(table: LogTable, assigner: Assigner) -> RoadTestError:
    """Return the error that asks for the names of columns, and for the time where a column may be it."""
    rising = rising_without_name(table)
    expected = Sentence("names for the columns, such as engine_speed = 'column 2', and the interval between rows")
    if rising is not None:
        speed = "column 2" if rising != "column 2" else "column 1"
        expected = Sentence("names for the columns, such as time = {time!r} and engine_speed = {speed!r}")
        expected = expected.of(time=rising, speed=speed)
    first = "; ".join(table.sample[0][:8]) if table.sample else None
    return assigner.error(Sentence("has no header: nothing tells what its columns are"), first, expected)


def _read_wide(table: LogTable, candidates: list[Candidate], assigner: Assigner) -> TableResult:
    candidates = [candidate for candidate in candidates if candidate.heading.index < table.width]
    refuse_split_decimals(table, assigner)
    times = time_candidates(table, candidates)
    channels = [candidate for candidate in candidates if candidate.quantity != "time"]
    chosen = [candidate.heading.index for candidate in (*times, *channels)]
    columns_read = sorted(set(chosen)) or [0]
    assigner.refuse_too_large(table.rows, table.bytes_of_row(columns_read))
    frame = table.read(columns_read, assigner.every)
    rows = rows_of_log(frame, times, channels, table, assigner)
    frame = rows.frame
    channels, unit_columns = with_units_beside(channels, table, frame.index, assigner)
    columns = columns_of_numbers(channels, frame, table.decimal, assigner)
    motions = motions_beside(channels, columns)
    clocks = own_times(table.headings, times, channels)
    if clocks is not None:
        return _read_own_times(clocks, rows, columns, channels, table, assigner, motions)

    label, clock = best_clock(times, rows, table, assigner, motions)
    timeline = build_timeline(clock.seconds)
    if not len(timeline.time):
        raise no_time(table, assigner)
    assigner.decide_all((candidate, columns[candidate.heading.index], None) for candidate in channels)
    return TableResult(rows.number, timeline, label, clock, used=(label, *unit_columns), left_out=rows.left_out)


def refuse_split_decimals(table: LogTable, assigner: Assigner) -> None:
    """Refuse rows in which a decimal comma has become a delimiter: nearly two cells for every name."""
    named = sum(1 for heading in table.headings if heading.names)
    filled = max((sum(1 for cell in row if cell) for row in table.sample), default=0)
    if table.has_header and named >= 2 and filled >= 2 * named - 1 and filled - named >= 2:
        problem = Sentence(
            "its rows have about twice as many cells as there are names: the decimal comma was used as delimiter too"
        )
        expected = Sentence("the log exported with ';' between cells or with a decimal point")
        raise assigner.error(problem, ",".join(table.sample[-1][:8]), expected)


def time_candidates(table: LogTable, candidates: list[Candidate]) -> list[Candidate]:
    """Return the columns that may be the clock, the likeliest first."""
    times = [candidate for candidate in candidates if candidate.quantity == "time" and _may_be_time(candidate)]
    if not any(candidate.mapped or _runs_in_sample(candidate, table) for candidate in times):
        # columns without a telling name that hold clock readings serve where no other does
        taken = {candidate.heading.index for candidate in candidates}
        headings = [heading for heading in table.headings[: table.width] if heading.index not in taken]
        times += [Candidate(each, "time", 2, "unknown", None) for each in headings if holds_clocks(table, each, 0.8)]
    return sorted(times, key=lambda candidate: (not candidate.mapped, candidate.tier))


def _may_be_time(candidate: Candidate) -> bool:
    """Return whether the unit of a column is one of time: a column T in °C is none."""
    kinds = kinds_of(clean_unit(candidate.unit or ""))
    return candidate.mapped or not kinds or "time" in kinds or kinds == ["ratio"]


def _runs_in_sample(candidate: Candidate, table: LogTable) -> bool:
    """Return whether a time column's cells differ from row to row, as far as a clock's do."""
    cells = table.sampled(candidate.heading.index)
    return len(set(cells)) > max(1, len(cells) / 20)


def own_times(
    headings: Sequence[Heading], times: list[Candidate], channels: list[Candidate]
) -> dict[int, Candidate] | None:
    """Return each channel's own time column, by channel index, where one stands before each channel or group."""
    if any(candidate.mapped for candidate in times) and len(times) == 1:
        return None
    alike: dict[str, list[Candidate]] = {}
    for candidate in times:
        alike.setdefault(words(candidate.heading.names[0] if candidate.heading.names else ""), []).append(candidate)
    group = max(alike.values(), key=len, default=[])
    if len(group) < 2:
        return None
    group = sorted(group, key=lambda candidate: candidate.heading.index)
    result = {}
    for channel in channels:
        before = [candidate for candidate in group if candidate.heading.index < channel.heading.index]
        if not before:
            return None
        result[channel.heading.index] = before[-1]
    return result or {-1: group[0]}


def _read_own_times(
    clock_columns: dict[int, Candidate], rows: LogRows, columns: dict[int, np.ndarray], channels: Sequence[Candidate],
    table: LogTable, assigner: Assigner, motions: Sequence[Motion],
) -> TableResult:  # fmt: skip
    clocks_by_column: dict[int, Clock] = {}
    time_columns = sorted({candidate.heading.index: candidate for candidate in clock_columns.values()}.items())
    for index, candidate in time_columns:
        clock = clock_of(candidate, rows.frame, table, assigner, motions)
        if clock is not None and runs_of_rows(clock.seconds):
            clocks_by_column[index] = clock
    if not clocks_by_column:
        raise no_time(table, assigner)
    first = min(clocks_by_column)
    timelines = {index: build_timeline(clock.seconds) for index, clock in clocks_by_column.items()}
    base = timelines[first]
    labels = {index: candidate.label for index, candidate in time_columns}
    for index, timeline in timelines.items():
        if index != first:  # what is to be said of the first is said of the log
            say_strays(assigner, timeline, labels[index])
    assigner.base = base.time if base.order is None else None
    offered: list[OfferedColumn] = []
    for candidate in channels:
        index = clock_columns[candidate.heading.index].heading.index
        values = columns[candidate.heading.index]
        if index == first:
            offered.append((candidate, values, None))
        elif index in timelines:
            offered.append((candidate, *timelines[index].samples(values)))
    assigner.decide_all(offered)
    label, clock = labels[first], clocks_by_column[first]
    return TableResult(rows.number, base, label, clock, used=(label,), left_out=rows.left_out)
