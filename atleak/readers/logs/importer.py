"""Understand a log's file as far as it can be, even where the user must still answer a question.

What every column holds, its range and its course, is shown so that a person can tell which is which.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd

from atleak.catalogue.written_numbers import INTERVAL
from atleak.common.damage import own_errors_only
from atleak.common.errors import InputError, Message, Place, RoadTestError
from atleak.common.memory import free_memory
from atleak.common.sentences import Sentence
from atleak.measurements.road_test import thinned
from atleak.readers import remembered_columns as memory
from atleak.readers.dates import words
from atleak.readers.logs.columns import (
    BESIDE,
    Ambiguous,
    Assigner,
    find_candidates,
    match_heading,
    own_part_of,
    stated_units,
)
from atleak.readers.logs.delimited import Delimited, must_be_held, numbers, open_delimited
from atleak.readers.logs.headings import Heading
from atleak.readers.logs.json_log import as_text
from atleak.readers.logs.log_file import HEAD_BYTES, TIMES, LogFile, of_measured_parts, open_source, without_a_table
from atleak.readers.logs.log_sheets import LogSheet, open_log_sheets
from atleak.readers.logs.log_table import LogTable
from atleak.readers.logs.mdf_log import mdf_columns, understand_mdf
from atleak.readers.logs.mlg_log import open_mlg
from atleak.readers.logs.parquet_log import open_parquet
from atleak.readers.logs.table_reader import long_columns, long_shape, read_table
from atleak.readers.logs.timeline import Timeline
from atleak.readers.logs.timeline import build as build_timeline
from atleak.readers.logs.understood import TableResult, Understood, finish, labels_of

_OPENED: Mapping[str, tuple[str, Callable[[LogFile], LogTable | None]]] = {  # by form: its name, what finds the table
    "parquet": ("Parquet", open_parquet),
    "mlg": ("MLG", open_mlg),
    "json": ("JSON", lambda source: open_delimited(as_text(source))),
    "text": ("delimited text", open_delimited),
}
_POINTS = 60  # of a small curve
_WORDS = 6  # different cells that are shown of a column of words


@dataclass
class _Job:
    """One log to understand, and what its caller states about it."""

    source: LogFile
    mapping: Mapping[str, str]
    units: Mapping[str, str]
    constants: Mapping[str, float]
    memory: Path | None
    every: int = 1
    room: float = math.inf  # bytes of memory that may be taken

    @property
    def interval(self) -> float | None:
        """Return the time from row to row [s] that is stated for a log without a clock."""
        interval = self.constants.get("time")
        least, longest = INTERVAL.limits
        if interval is None or least <= interval <= longest:
            return interval
        expected = Sentence("more than 0 and at most {longest:g} s", longest=longest)
        raise self.source.error(Sentence("an interval between rows that no log has"), interval, expected)


@own_errors_only(RoadTestError, "name", "source")
def understand(
    source: str | Path | bytes,
    *,
    name: str | None = None,
    mapping: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
    constants: Mapping[str, float] | None = None,
    every: int = 1,
    remembered: Path | None = None,
    memory: int | None = None,
    tell: Callable[[int], object] = lambda _: None,
) -> Understood:
    """Read a road-test log of any logger and return what is understood of it.

    Parameters are those of `atleak.readers.logs.read_road_test`; ``memory``: the bytes that this process may take, None
    for as many as are free; and ``tell``: called again and again with how many rows are read so far; what
    it raises ends the reading. A `RoadTestError` refuses what is no log at all: empty, a picture, damaged. A log that
    lacks an answer does not raise: ``problem`` says what is needed.
    """
    if every < 1:
        problem = Sentence("no number of rows of which one is read")
        raise RoadTestError(problem, value=every, expected=Sentence("a whole number above 0"))
    opened = replace(open_source(source, name), tell=tell)
    room = free_memory() if memory is None else memory
    job = _Job(opened, dict(mapping or {}), dict(units or {}), dict(constants or {}), remembered, every, room)
    try:
        understood = _by_form(job)
        digest = opened.sha256  # computed beside all this; only here is it waited for
    except InputError as error:
        if isinstance(error, RoadTestError):
            raise
        raise RoadTestError(
            error.problem, place=error.place if str(error.place) else Place(file=opened.file), value=error.value,
            expected=error.expected, nearest=error.nearest,
        ) from error  # fmt: skip
    except MemoryError as error:
        problem = Sentence("is too large for the memory of this computer")
        raise opened.error(problem, expected=Sentence("part of the drive")) from error
    finally:
        opened.digest.stop()  # who is told that it cannot be read may delete the file
        opened.close()
    test = understood.road_test
    return replace(understood, sha256=digest, road_test=replace(test, sha256=digest) if test else None)


def _by_form(job: _Job) -> Understood:
    source = job.source
    if source.form == "workbook":
        return _workbook(job)
    if source.form == "mdf":
        return understand_mdf(source, job.mapping, job.units, job.constants, job.every, job.room)
    held, form = TIMES * source.size, source.form
    if held > own_part_of(job.room) and (form == "json" or (form == "text" and must_be_held(source))):
        problem = Sentence("takes up to {needed:.1f} GB of memory where it is read whole, and {room:.1f} GB are free")
        expected = Sentence("UTF-8 or a code page of one byte a sign, with a line feed behind every line")
        problem = problem.of(needed=(BESIDE + held) / 1e9, room=job.room / 1e9)
        raise source.error(problem, expected=expected)
    name, opened = _OPENED[form]
    table = opened(source)
    if table is None:
        raise without_a_table(source.head[:HEAD_BYTES], source.file)
    understood = _one_table(table, name, job)
    if form != "text" or understood.road_test is not None or job.mapping:
        return understood
    return replace(understood, problem=of_measured_parts(source.head[:HEAD_BYTES], source.file) or understood.problem)


def _one_table(table: LogTable, form: str, job: _Job) -> Understood:
    blank = _blank_of(job, table, form)
    mapping, units, notes = _with_memory(job, blank.signature)
    assigner = Assigner(job.source.file, units, stated_units(table.headings), job.interval, job.every, job.room)
    assigner.messages += notes
    if table.layout.note is not None:
        assigner.say("logger", table.layout.note)
    if isinstance(table, Delimited):
        assigner.messages += table.source.notes
    assigner.leave_out(mapping)
    try:
        reading = read_table(table, assigner, mapping)
    except RoadTestError as error:
        return replace(blank, messages=tuple(assigner.messages), problem=error, ambiguous=tuple(assigner.ambiguous))
    return finish(blank, assigner, reading, job.constants)


def _blank_of(job: _Job, table: LogTable, form: str) -> Understood:
    """Return what is known of a table before its columns are read."""
    written: tuple[str | None, str | None, str | None] = None, None, None
    if isinstance(table, Delimited) and job.source.form == "text":
        written = table.encoding, table.delimiter, table.decimal
    # choices for logs like this one are kept under the names of its columns; under none where its header names none
    signature = memory.signature(labels_of(table.headings)) if table.has_header else ""
    preview = tuple(tuple(row) for row in table.sample[:8])
    return Understood(job.source.file, "", form, *written, table.headings, preview, signature)


def _with_memory(job: _Job, signature: str) -> tuple[dict[str, str], dict[str, str], list[Message]]:
    mapping, units = dict(job.mapping), dict(job.units)
    if job.memory is None:
        return mapping, units, []
    remembered = memory.recall(job.memory, signature)
    if remembered is None:
        return mapping, units, []
    mapped = {words(column) for column in mapping.values() if column != memory.NOT_LOGGED}
    earlier = {quantity: column for quantity, column in remembered.mapping.items() if words(column) not in mapped}
    return {**earlier, **mapping}, {**remembered.units, **units}, [remembered.note]


def _workbook(job: _Job) -> Understood:
    sheets = open_log_sheets(job.source)
    if not sheets:
        expected = Sentence("a sheet with a header and rows of numbers")
        raise job.source.error(Sentence("holds no sheet with a table of numbers"), expected=expected)
    if len(sheets) == 1:
        return _one_table(sheets[0], "workbook", job)
    titled = [replace(sheet, titled=True) for sheet in sheets]
    good = [reading for sheet in titled if (reading := _read_sheet(sheet, job)) is not None]
    if not good:
        first = max(sheets, key=lambda sheet: sheet.cells.rows)
        return _one_table(first, "workbook", job)
    with_several_signals = [reading for reading in good if len(reading.assigner.signals) >= 2]
    if with_several_signals or len(good) == 1:
        best = max(
            with_several_signals or good, key=lambda reading: (len(reading.assigner.signals), reading.result.rows)
        )
        others = [sheet.name for sheet in sheets if sheet.name != best.sheet.name]
        understood = _one_table(best.sheet, "workbook", job)
        text = Sentence("sheet {name!r} is read; also there: {others}", name=best.sheet.name, others=tuple(others))
        note = Message("info", "sheet_chosen", text)
        return replace(understood, messages=(*understood.messages, note))
    return _sheet_per_signal(job, good)


class _SheetReading(NamedTuple):
    """A sheet read as a log of its own."""

    sheet: LogSheet
    assigner: Assigner
    result: TableResult


def _read_sheet(sheet: LogSheet, job: _Job) -> _SheetReading | None:
    """Read one sheet of several; None where it is no log."""
    assigner = Assigner(job.source.file, job.units, stated_units(sheet.headings), job.interval, job.every, job.room)
    labels = {heading.label for heading in sheet.headings}
    mapping = {quantity: column for quantity, column in job.mapping.items() if column in (*labels, memory.NOT_LOGGED)}
    try:
        return _SheetReading(sheet, assigner, read_table(sheet, assigner, mapping))
    except RoadTestError:
        return None


def _sheet_per_signal(job: _Job, good: list[_SheetReading]) -> Understood:
    """Put sheets that hold one signal each, with a time of its own, on one time axis."""
    headings = tuple(heading for reading in good for heading in reading.sheet.headings)
    signature = memory.signature(labels_of(headings))
    blank = replace(_blank_of(job, good[0].sheet, "workbook"), headings=headings, signature=signature)
    main = Assigner(job.source.file, job.units, (), every=job.every)
    offered: dict[str, list[_SheetReading]] = {}
    for reading in good:
        main.messages += reading.assigner.messages
        main.refused |= reading.assigner.refused
        main.ambiguous += reading.assigner.ambiguous
        for quantity in reading.assigner.signals:
            offered.setdefault(quantity, []).append(reading)
    stamps = []
    for quantity, sources in offered.items():
        asked = [question for question in main.ambiguous if question.quantity == quantity]
        if len(sources) > 1 or asked:
            names = [name for question in asked for name in question.candidates]
            names += [f"{sheet.name}: {assigner.signals[quantity].candidate.label}" for sheet, assigner, _ in sources]
            main.ambiguous = [question for question in main.ambiguous if question not in asked]
            main.ambiguous.append(Ambiguous(quantity, tuple(names), Sentence("several sheets hold it")))
            continue
        source = sources[0]
        signal = source.assigner.signals[quantity]
        time = signal.time
        if time is None:
            values, time = source.result.timeline.samples(signal.values)
            signal = replace(signal, values=values, time=time)
        main.signals[quantity] = signal
        stamps.append(time)
    longest = max((reading.result for reading in good), key=lambda result: result.rows)
    base = build_timeline(np.unique(np.concatenate(stamps))) if stamps else longest.timeline
    timeline = Timeline(base.time, None, base.segments, base.duration)
    merged = TableResult(longest.rows, timeline, longest.time_label, longest.clock)
    return finish(blank, main, merged, job.constants)


@dataclass(frozen=True)
class LogColumn:
    """A column of a log as a person tells it from the others, in the file's own unit."""

    label: str  # heading, or ``column 3``
    unit: str | None  # as the file states it
    quantity: str | None  # that its name stands for; None where the name says nothing
    numbers: int  # how many cells hold one
    least: float | None = None  # None where it holds no number
    largest: float | None = None  # likewise
    curve: tuple[float, ...] = ()  # its course
    words: tuple[str, ...] = ()  # some of its cells that are no numbers


@own_errors_only(RoadTestError, "name", "source")
def log_columns(source: str | Path | bytes, *, name: str | None = None) -> tuple[LogColumn, ...]:
    """Return every column of a log, in file order; none where no table of numbers is found in it.

    A `RoadTestError` refuses what is no log at all: empty, a picture, damaged.
    """
    opened = open_source(source, name)
    try:
        read = list(_read(opened))
        labels = Counter(heading.label for heading, *_ in read)
        return tuple(_column(*parts, labels[parts[0].label] > 1) for parts in read)
    finally:
        opened.close()


def _read(opened: LogFile) -> Iterator[tuple[Heading, np.ndarray, Iterable[str]]]:
    if opened.form == "mdf":
        for heading, values in mdf_columns(opened):
            yield heading, values, ()
        return
    tables = open_log_sheets(opened) if opened.form == "workbook" else [_OPENED[opened.form][1](opened)]
    for table in filter(None, tables):
        shape = long_shape(table, find_candidates(table.headings), {})
        if shape is not None:
            yield from long_columns(table, shape)
            continue
        headings = [heading for heading in table.headings if heading.index < table.width]
        frame = table.read([heading.index for heading in headings])
        for heading in headings:
            yield heading, *numbers(frame, heading.index, table.decimal)


def _column(heading: Heading, values: np.ndarray, words: Iterable[str], repeated: bool) -> LogColumn:
    label = heading.numbered if repeated else heading.label
    match = match_heading(heading)
    good = values[np.isfinite(values)]
    some = tuple(dict.fromkeys(str(word) for word in pd.Series(words, dtype=object).head(10_000)))[:_WORDS]
    unit, quantity = heading.unit or (match.unit if match else None), match.quantity if match else None
    if not len(good):
        return LogColumn(label, unit, quantity, 0, words=some)
    curve = tuple(good[thinned([good], _POINTS)].tolist())
    return LogColumn(label, unit, quantity, len(good), float(good.min()), float(good.max()), curve, some)
