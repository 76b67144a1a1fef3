"""Reads the long format, in which a row is a time, a name, a value and perhaps a unit."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from atleak.intake.plain_words import words
from atleak.intake.road_test.channels.assign import Assigner, Candidate, Offered, find_candidates, map_columns
from atleak.intake.road_test.channels.column_values import LeftOut
from atleak.intake.road_test.channels.protocol import TableResult, width_of
from atleak.intake.road_test.channels.timing import clock_of, no_time, runs
from atleak.intake.road_test.channels.unit_cells import UNIT_HEADERS, say_two_units, two_units
from atleak.intake.road_test.clock.timeline import Timeline
from atleak.intake.road_test.clock.timeline import build as build_timeline
from atleak.intake.road_test.files.cells import kind_of
from atleak.intake.road_test.files.delimited import numbers
from atleak.intake.road_test.files.headings import Heading
from atleak.intake.road_test.files.layout import LogTable
from atleak.intake.road_test.names import words_as_numbers
from atleak.intake.road_test.names.matching import match_name, split_unit
from atleak.intake.road_test.names.memory import NOT_LOGGED
from atleak.road_test import QUANTITIES, Segment
from atleak.sentence import Sentence

_NAME_HEADERS = {
    "pid", "name", "signal", "channel", "parameter", "sensor", "kanal", "key", "item", "variable", "description",
    "signal name", "sensor name", "measurement", "parametr", "parameter name",
}  # fmt: skip
_VALUE_HEADERS = {
    "value", "values", "wert", "messwert", "reading", "wartosc", "valeur", "valor", "значение", "data",
    "physical value",
}  # fmt: skip


@dataclass(frozen=True)
class _LongColumns:
    """The columns of a long table."""

    time: Candidate
    name: Heading
    value: Heading
    unit: Heading | None


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

    value = next(iter(called(_VALUE_HEADERS)), None)
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
    return bool(cells) and sum(kind_of(cell, table.decimal) == "text" for cell in cells) > 0.8 * len(cells)


def read_long(table: LogTable, shape: _LongColumns, assigner: Assigner, mapping: Mapping[str, str]) -> TableResult:
    """Read a long table: its signals go to the assigner.

    Raises
    ------
    RoadTestError
        when its time cannot be read or the user names a column that it lacks.
    """
    read, frame, names = _rows(table, shape, assigner)
    left = LeftOut.of(read, table)
    left.say(assigner)
    if nameless := len(read) - len(frame):
        text = Sentence("{count} row(s) name no signal, or repeat the header, and are left out", count=nameless)
        assigner.say("lines_left_out", text)
    left_out = left.rows + nameless
    clock = clock_of(shape.time, frame, table, assigner, ())
    if clock is None or not runs(clock.seconds):
        raise no_time(table, assigner)
    if clock.unit_assumed:
        assigner.assume_unit(shape.time.label, clock.unit, "time")
    whole = build_timeline(clock.seconds)
    row_times = np.full(len(frame), np.nan)
    row_times[whole.order if whole.order is not None else slice(None)] = whole.time
    values, _ = numbers(frame, shape.value.index, table.decimal)
    texts = frame[shape.value.index]
    codes, uniques = pd.factorize(names)
    headings = _headings(uniques, codes, frame, shape)
    candidates = find_candidates(headings)
    own_mapping = {quantity: column for quantity, column in mapping.items() if quantity != "time"}
    candidates = map_columns(candidates, headings, own_mapping, assigner.file)
    assigner.neighbours = tuple(heading.unit for heading in headings if heading.unit)
    offered: list[Offered] = []
    for candidate in (each for each in candidates if each.quantity != "time"):
        quantity, rows = candidate.quantity, codes == candidate.heading.index
        if shape.unit is not None and split_unit(candidate.label).unit is None:
            first, other = two_units(frame[shape.unit.index][rows], QUANTITIES[quantity].unit_kind)
            if other is not None:
                say_two_units(candidate, first, other, assigner)
                continue
        channel_values = values[rows]
        if quantity in ("gear", "selector", "lock_up") and np.isnan(channel_values).all():
            channel_values = words_as_numbers.as_numbers(quantity, texts[rows])
        good = np.isfinite(channel_values) & np.isfinite(row_times[rows])
        time = row_times[rows][good]
        by_time = np.argsort(time, kind="stable")[:: assigner.every]
        offered.append((candidate, channel_values[good][by_time], time[by_time]))
    assigner.decide_all(offered)
    stamps = [signal.time for signal in assigner.signals.values() if signal.time is not None]
    base = np.unique(np.concatenate(stamps)) if stamps else np.unique(whole.time)
    timeline = _on_base(base, whole)
    column_names = tuple(map(str, uniques))
    return TableResult(len(frame), timeline, shape.time.label, clock, True, column_names, whole.segments, left_out)


def _rows(
    table: LogTable, shape: _LongColumns, assigner: Assigner | None = None
) -> tuple[pd.DataFrame, pd.DataFrame, pd.Series]:
    """Return all rows, those that name a signal, and those names."""
    columns = [shape.time.heading.index, shape.name.index, shape.value.index]
    if shape.unit:
        columns.append(shape.unit.index)
    columns = sorted(set(columns))
    if assigner is not None:
        assigner.refuse_too_large(table.rows, width_of(table, columns), thins=False)
    frame = table.read(columns)
    names = frame[shape.name.index].astype("str").str.strip()
    keep = frame[shape.name.index].notna() & (names != shape.name.label)
    return frame, frame[keep], names[keep]


def _headings(uniques: pd.Index, codes: np.ndarray, frame: pd.DataFrame, shape: _LongColumns) -> list[Heading]:
    """Return a heading for every signal, with the unit that its name or its rows state."""
    headings = []
    for index, name in enumerate(uniques):
        split = split_unit(str(name))
        unit = split.unit
        if unit is None and shape.unit is not None:
            unit_cells = frame[shape.unit.index].to_numpy(dtype=object)[codes == index]
            unit = next((str(cell) for cell in unit_cells if isinstance(cell, str) and cell.strip()), None)
        headings.append(Heading(index, str(name), (split.text,), unit))
    return headings


def long_columns(table: LogTable, shape: _LongColumns) -> Iterator[tuple[Heading, np.ndarray, pd.Series]]:
    """Yield the heading of every signal of a long table, its numbers and its cells that are none."""
    _, frame, names = _rows(table, shape)
    values, words_there = numbers(frame, shape.value.index, table.decimal)
    codes, uniques = pd.factorize(names)
    for heading in _headings(uniques, codes, frame, shape):
        rows = codes == heading.index
        yield heading, values[rows], words_there[words_there.index.isin(frame.index[rows])]


def _on_base(base: np.ndarray, whole: Timeline) -> Timeline:
    """Return the file's timeline with its segments counted on another time base."""
    segments = []
    for segment in whole.segments:
        low = int(np.searchsorted(base, segment.start, side="left"))
        high = int(np.searchsorted(base, segment.stop, side="right"))
        if high > low:
            segments.append(Segment(low, high - low, float(base[low]), float(base[high - 1] - base[low])))
    return replace(whole, time=base, order=None, segments=tuple(segments))
