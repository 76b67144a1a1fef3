"""Reads a table with a time column (or one for each channel, or long: time, name, value) into signals and time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from atleak.errors import Place, RoadTestError
from atleak.intake.plain_words import words
from atleak.intake.road_test.channels.assign import Assigner, Candidate, Offered, find_candidates, map_columns
from atleak.intake.road_test.channels.build import say_strays
from atleak.intake.road_test.channels.column_values import Rows, columns_of_numbers, rows_of
from atleak.intake.road_test.channels.headers_between import check_clock_stated_again, with_units_stated_again
from atleak.intake.road_test.channels.long import long_shape, read_long
from atleak.intake.road_test.channels.protocol import TableResult, width_of
from atleak.intake.road_test.channels.timing import (
    best_clock,
    clock_of,
    motions_beside,
    no_time,
    rising_without_name,
    runs,
)
from atleak.intake.road_test.channels.unit_cells import with_units_beside
from atleak.intake.road_test.clock.clocks import Clock, Motion, numeric_clock
from atleak.intake.road_test.clock.timeline import build as build_timeline
from atleak.intake.road_test.files.cells import is_clock
from atleak.intake.road_test.files.delimited import numbers
from atleak.intake.road_test.files.headings import Heading, named_by_a_date
from atleak.intake.road_test.files.layout import LogTable
from atleak.intake.road_test.names.matching import clean_unit
from atleak.intake.units import kinds_of
from atleak.sentence import Sentence


def read_table(table: LogTable, assigner: Assigner, mapping: Mapping[str, str]) -> TableResult:
    """Read a table's time and quantities.

    Raises
    ------
    RoadTestError
        when no column tells the time, numbers are destroyed, another header begins in the middle, or the table has no
        header and the user has not named columns.
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
        expected = Sentence(
            "names for the columns, such as time = {time!r} and engine_speed = {speed!r}", time=rising, speed=speed
        )
    return RoadTestError(
        Sentence("has no header: nothing tells what its columns are"),
        place=Place(file=assigner.file),
        value="; ".join(table.sample[0][:8]) if table.sample else None,
        expected=expected,
    )


# --- wide ---------------------------------------------------------------------------------------------------


def _read_wide(table: LogTable, candidates: list[Candidate], assigner: Assigner) -> TableResult:
    candidates = [candidate for candidate in candidates if candidate.heading.index < table.width]
    refuse_split_decimals(table, assigner)
    times = time_candidates(table, candidates)
    channels = [candidate for candidate in candidates if candidate.quantity != "time"]
    chosen = [candidate.heading.index for candidate in (*times, *channels)]
    columns_read = sorted(set(chosen)) or [0]
    assigner.refuse_too_large(table.rows, width_of(table, columns_read))
    frame = table.read(columns_read, assigner.every)
    rows = rows_of(frame, times, channels, table, assigner)
    frame = rows.frame
    channels, unit_columns = with_units_beside(channels, table, frame.index, assigner)
    columns = columns_of_numbers(channels, frame, table.decimal, assigner)
    channels = with_units_stated_again(channels, columns, rows.before, assigner)
    motions = motions_beside(channels, columns)
    clocks = own_times(table.headings, times, channels)
    if clocks is not None:
        return _read_own_times(clocks, rows, columns, channels, table, assigner, motions)

    def unit_before(candidate: Candidate, line: int) -> str:
        some = frame.iloc[: rows.before(line)]
        return numeric_clock(numbers(some, candidate.heading.index, table.decimal).values, None).unit

    label, clock = best_clock(times, rows, table, assigner, motions)
    check_clock_stated_again(times, (label, clock), unit_before, assigner)
    timeline = build_timeline(clock.seconds)
    if not len(timeline.time):
        raise no_time(table, assigner)
    assigner.decide_all((candidate, columns[candidate.heading.index], None) for candidate in channels)
    return TableResult(rows.number, timeline, label, clock, used=(label, *unit_columns), left_out=rows.left_out)


def refuse_split_decimals(table: LogTable, assigner: Assigner) -> None:
    """Refuse rows in which a decimal comma has become a delimiter: nearly two cells for every name.

    Raises
    ------
    RoadTestError
        with the last row of the sample.
    """
    named = sum(1 for heading in table.headings if heading.names)
    filled = max((sum(1 for cell in row if cell) for row in table.sample), default=0)
    if table.has_header and named >= 2 and filled >= 2 * named - 1 and filled - named >= 2:
        raise RoadTestError(
            Sentence(
                "its rows have about twice as many cells as there are names: the decimal comma was used as delimiter "
                "too"
            ),
            place=Place(file=assigner.file),
            value=",".join(table.sample[-1][:8]),
            expected=Sentence("the log exported with ';' between cells or with a decimal point"),
        )


def time_candidates(table: LogTable, candidates: list[Candidate]) -> list[Candidate]:
    """Return the columns that may be the clock, the likeliest first."""
    times = []
    for candidate in candidates:
        kinds = kinds_of(clean_unit(candidate.unit or ""))  # a column T in °C is no time
        possible = candidate.mapped or not kinds or "time" in kinds or kinds == ["ratio"]
        if candidate.quantity == "time" and possible:
            times.append(candidate)
    if any(candidate.heading.stamped for candidate in times):
        times = [candidate for candidate in times if candidate.mapped or candidate.heading.stamped]
    if not any(candidate.mapped for candidate in times):
        for heading in table.headings[: table.width]:
            if named_by_a_date(heading) and not any(candidate.heading is heading for candidate in times):
                times.append(Candidate(heading, "time", 0, "unknown", None))
    if not any(candidate.mapped or _runs_in_sample(candidate, table) for candidate in times):
        # columns without a telling name that hold clock readings serve where no other does
        named = {candidate.heading.index for candidate in candidates}
        for heading in table.headings[: table.width]:
            unnamed = heading.index not in named and not named_by_a_date(heading)
            cells = table.sampled(heading.index)
            if unnamed and cells and sum(map(is_clock, cells)) > 0.8 * len(cells):
                times.append(Candidate(heading, "time", 2, "unknown", None))
    return sorted(times, key=lambda candidate: (not candidate.mapped, candidate.tier))


def _runs_in_sample(candidate: Candidate, table: LogTable) -> bool:
    """Return whether a time column's cells differ from row to row, as far as a clock's do."""
    cells = table.sampled(candidate.heading.index)
    return len(set(cells)) > max(1, len(cells) / 20)


# --- a time column before each channel ----------------------------------------------------------------------


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
    clock_columns: dict[int, Candidate], rows: Rows, columns: dict[int, np.ndarray], channels: Sequence[Candidate],
    table: LogTable, assigner: Assigner, motions: Sequence[Motion],
) -> TableResult:  # fmt: skip
    clocks_by_column: dict[int, Clock] = {}
    time_columns = sorted({candidate.heading.index: candidate for candidate in clock_columns.values()}.items())
    for index, candidate in time_columns:
        clock = clock_of(candidate, rows.frame, table, assigner, motions)
        if clock is not None and runs(clock.seconds):
            clocks_by_column[index] = clock
    if not clocks_by_column:
        raise no_time(table, assigner)
    first = min(clocks_by_column)
    timelines = {index: build_timeline(clock.seconds) for index, clock in clocks_by_column.items()}
    base = timelines[first]
    for index, timeline in timelines.items():
        if index != first:  # what is to be said of the first is said of the log
            say_strays(assigner, timeline, dict(time_columns)[index].label)
    assigner.base = base.time if base.order is None else None
    offered: list[Offered] = []
    for candidate in channels:
        index = clock_columns[candidate.heading.index].heading.index
        values = columns[candidate.heading.index]
        if index == first:
            offered.append((candidate, values, None))
        elif index in timelines:
            timeline = timelines[index]
            values = values if timeline.order is None else values[timeline.order]
            good = np.isfinite(values)
            offered.append((candidate, values[good], timeline.time[good]))
    assigner.decide_all(offered)
    label = dict(time_columns)[first].label
    clock = clocks_by_column[first]
    return TableResult(rows.number, base, label, clock, used=(label,), left_out=rows.left_out)
