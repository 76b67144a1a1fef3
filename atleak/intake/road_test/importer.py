"""A log's file → what is understood of it, even where something must be asked."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from atleak.errors import InputError, Message, Place, RoadTestError
from atleak.intake.road_test.channels.assign import Ambiguous, Assigner, stated_units
from atleak.intake.road_test.channels.protocol import LogTable, TableResult
from atleak.intake.road_test.channels.reader import read_table
from atleak.intake.road_test.clock.timeline import Timeline
from atleak.intake.road_test.clock.timeline import build as build_timeline
from atleak.intake.road_test.files.delimited import open_delimited
from atleak.intake.road_test.files.log_file import LogFile, open_source
from atleak.intake.road_test.files.log_sheets import LogSheet, open_sheets
from atleak.intake.road_test.mdf import understand_mdf
from atleak.intake.road_test.names import memory
from atleak.intake.road_test.names.matching import words
from atleak.intake.road_test.outcome import Understood, finish, labels_of


@dataclass
class _Job:
    source: LogFile
    mapping: Mapping[str, str]
    units: Mapping[str, str]
    constants: Mapping[str, float]
    memory: Path | None


def understand(
    source: str | Path | bytes,
    *,
    name: str | None = None,
    mapping: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
    constants: Mapping[str, float] | None = None,
    remembered: Path | None = None,
) -> Understood:
    """Reads a road-test log of any logger and says what it understood.

    Parameters are those of `atleak.intake.road_test.read_road_test`.

    Raises
    ------
    RoadTestError
        when the file is no log at all: empty, a picture, damaged. A log that lacks an answer does not raise:
        ``problem`` says what is needed.
    """
    opened = open_source(source, name)
    job = _Job(opened, dict(mapping or {}), dict(units or {}), dict(constants or {}), remembered)
    try:
        understood = _understand(job)
    except InputError as error:
        if isinstance(error, RoadTestError):
            raise
        raise RoadTestError(
            error.problem, place=error.place if str(error.place) else Place(file=opened.file), value=error.value,
            expected=error.expected, nearest=error.nearest,
        ) from error  # fmt: skip
    finally:
        opened.close()
    # the sum is computed beside all this; only now is it waited for
    digest = opened.sha256
    test = understood.road_test
    return replace(understood, sha256=digest, road_test=replace(test, sha256=digest) if test else None)


def _understand(job: _Job) -> Understood:
    opened = job.source
    if opened.form == "workbook":
        return _workbook(job)
    if opened.form == "mdf":
        return understand_mdf(opened, job.mapping, job.units, job.constants)
    return _delimited(job)


_BUS_TRACE = re.compile(
    rb"^;\$FILEVERSION=|^\s*\(\d+\.\d+\)\s+\w*can\d+\s|^date .*\nbase (?:hex|dec)|^\s*\d+\)\s+[\d.]+\s+(?:Rx|Tx)\s",
    re.MULTILINE,
)


def _delimited(job: _Job) -> Understood:
    if _BUS_TRACE.search(job.source.head[:8192]):
        raise RoadTestError(
            "is a recording of a CAN bus: turning its frames into quantities needs the car's database (DBC)",
            place=Place(file=job.source.file),
            expected="the logger's export with decoded channels",
        )
    table = open_delimited(job.source)
    if table is None:
        raise RoadTestError(
            "no table of numbers was found in it",
            place=Place(file=job.source.file),
            expected="a log with a header and rows of numbers, as the logger exports it",
        )
    blank = Understood(
        job.source.file, "", "delimited text", table.encoding, table.delimiter, table.decimal,
        table.headings, tuple(tuple(row) for row in table.sample[:8]), memory.signature(labels_of(table.headings)),
    )  # fmt: skip
    return _one_table(table, blank, job)


def _one_table(table: LogTable, blank: Understood, job: _Job) -> Understood:
    mapping, units, notes = _with_memory(job, blank.signature)
    assigner = Assigner(job.source.file, units, stated_units(table.headings))
    assigner.messages += notes
    try:
        reading = read_table(table, assigner, mapping)
    except RoadTestError as error:
        return replace(blank, messages=tuple(assigner.messages), problem=error, ambiguous=tuple(assigner.ambiguous))
    return finish(blank, assigner, reading, job.constants)


def _with_memory(job: _Job, signature: str) -> tuple[dict[str, str], dict[str, str], list[Message]]:
    mapping, units = dict(job.mapping), dict(job.units)
    if job.memory is None:
        return mapping, units, []
    settled = memory.recall(job.memory, signature)
    if settled is None:
        return mapping, units, []
    note = Message("info", "remembered", "columns are taken as settled earlier for logs with this header")
    taken = {words(column) for column in mapping.values()}
    earlier = {quantity: column for quantity, column in settled.mapping.items() if words(column) not in taken}
    return {**earlier, **mapping}, {**settled.units, **units}, [note]


# --- workbooks ----------------------------------------------------------------------------------------------


def _workbook(job: _Job) -> Understood:
    sheets = open_sheets(job.source)
    if not sheets:
        raise RoadTestError(
            "holds no sheet with a table of numbers",
            place=Place(file=job.source.file),
            expected="a sheet with a header and rows of numbers",
        )
    if len(sheets) == 1:
        return _one_table(sheets[0], _blank(job, sheets[0], labels_of(sheets[0].headings)), job)
    titled = [replace(sheet, titled=True) for sheet in sheets]
    tries = [(sheet, _try(sheet, job)) for sheet in titled]
    good = [(sheet, assigner, reading) for sheet, (assigner, reading) in tries if reading is not None]
    if not good:
        first = max(sheets, key=lambda sheet: len(sheet.rows))
        return _one_table(first, _blank(job, first, labels_of(first.headings)), job)
    whole = [one for one in good if len(one[1].signals) >= 2]
    if whole or len(good) == 1:
        best = max(whole or good, key=lambda one: (len(one[1].signals), one[2].rows))
        others = [sheet.name for sheet in sheets if sheet.name != best[0].name]
        understood = _one_table(best[0], _blank(job, best[0], labels_of(best[0].headings)), job)
        note = Message("info", "sheet_chosen", f"sheet {best[0].name!r} is read; also there: {', '.join(others)}")
        return replace(understood, messages=(*understood.messages, note))
    return _sheet_per_signal(job, good)


def _blank(job: _Job, sheet: LogSheet, labels: list[str]) -> Understood:
    return Understood(
        job.source.file, "", "workbook", None, None, None, sheet.headings,
        tuple(tuple(row) for row in sheet.sample[:8]), memory.signature(labels),
    )  # fmt: skip


def _try(sheet: LogSheet, job: _Job) -> tuple[Assigner, TableResult | None]:
    assigner = Assigner(job.source.file, job.units, stated_units(sheet.headings))
    labels = {heading.label for heading in sheet.headings}
    mapping = {quantity: column for quantity, column in job.mapping.items() if column in labels}
    try:
        return assigner, read_table(sheet, assigner, mapping)
    except RoadTestError:
        return assigner, None


def _sheet_per_signal(job: _Job, good: list[tuple[LogSheet, Assigner, TableResult]]) -> Understood:
    """One signal a sheet, each with its own time: put on one axis."""
    labels = [heading.label for sheet, _, _ in good for heading in sheet.headings]
    blank = _blank(job, good[0][0], labels)
    main = Assigner(job.source.file, job.units, ())
    offered: dict[str, list[tuple[LogSheet, Assigner, TableResult]]] = {}
    for sheet, assigner, reading in good:
        main.messages += assigner.messages
        main.ambiguous += assigner.ambiguous
        for quantity in assigner.signals:
            offered.setdefault(quantity, []).append((sheet, assigner, reading))
    stamps = []
    for quantity, found in offered.items():
        if len(found) > 1:
            names = tuple(f"{sheet.name}: {one.signals[quantity].candidate.label}" for sheet, one, _ in found)
            main.ambiguous.append(Ambiguous(quantity, names, "several sheets hold it"))
            continue
        _, assigner, reading = found[0]
        signal = assigner.signals[quantity]
        time = signal.time
        if time is None:
            values, timeline = signal.values, reading.timeline
            values = values if timeline.order is None else values[timeline.order]
            kept = np.isfinite(values)
            time = timeline.time[kept]
            signal = replace(signal, values=values[kept], time=time)
        main.signals[quantity] = signal
        stamps.append(time)
    longest = max(good, key=lambda one: one[2].rows)[2]
    base = build_timeline(np.unique(np.concatenate(stamps))) if stamps else longest.timeline
    merged = TableResult(
        longest.rows, Timeline(base.time, None, base.segments, base.duration), longest.time_label, longest.clock
    )
    return finish(
        replace(blank, headings=tuple(h for s, _, _ in good for h in s.headings)), main, merged, job.constants
    )
