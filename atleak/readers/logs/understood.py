"""Holds what is understood of a log, makes a road test of its assigned columns, and writes both for other programs.

``describe`` is the JSON form, ``tidy_csv`` a plain table in workshop units.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

import numpy as np
import pandas as pd

from atleak.common.errors import Message, Place, RoadTestError
from atleak.common.sentences import Sentence
from atleak.common.units import Unit, unit
from atleak.measurements.road_test import QUANTITIES, Channel, RoadTest, Segment
from atleak.readers.logs import channels as build
from atleak.readers.logs.clock import YEAR, Clock
from atleak.readers.logs.columns import Ambiguous, Assigner
from atleak.readers.logs.headings import Heading
from atleak.readers.logs.timeline import Timeline
from atleak.readers.remembered_columns import NOT_LOGGED
from atleak.version import __version__

FORMATS: Mapping[str, Sentence] = MappingProxyType(  # of files, as pages name them; those of MDF and Parquet are names
    {"delimited text": Sentence("delimited text"), "workbook": Sentence("workbook")}
)


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


@dataclass(frozen=True)
class Understood:
    """What is understood of a log, even while questions are open."""

    file: str  # name of the log
    sha256: str  # of its bytes
    format: str  # one of `FORMATS`
    encoding: str | None  # of a text
    delimiter: str | None  # of a text, between its columns
    decimal: str | None  # of a text, the decimal sign
    headings: tuple[Heading, ...]  # of all columns
    preview: tuple[tuple[str, ...], ...]  # the first rows, as text
    signature: str  # key under which an answer is remembered
    ambiguous: tuple[Ambiguous, ...] = ()  # quantities to choose a column for
    unused: tuple[str, ...] = ()  # columns that no quantity came from
    messages: tuple[Message, ...] = ()  # what was assumed
    road_test: RoadTest | None = None  # None while ``problem`` says what is needed
    problem: RoadTestError | None = None  # what is needed
    time_label: str = ""  # heading of the column of time
    time_unit: str = ""  # of that column
    time_assumed: bool = False  # nothing in the file states the unit
    segments: tuple[Segment, ...] = ()  # stretches without a gap; they count the file's rows
    rows_left_out: int = 0  # lines below the header that are no rows: messages say what they are

    @property
    def rows(self) -> int:
        """Return the number of data rows of the file, 0 while it is not read."""
        return self.road_test.rows if self.road_test else 0

    def uses(self, mapping: Mapping[str, str]) -> bool:
        """Tell whether every column that was named gave its quantity: one may lack the unit or the values for it."""
        named = [quantity for quantity, column in mapping.items() if column != NOT_LOGGED and quantity != "time"]
        return self.road_test is not None and all(quantity in self.road_test.channels for quantity in named)


def labels_of(headings: Sequence[Heading]) -> list[str]:
    """Return the names of the columns."""
    return [heading.label for heading in headings]


def finish(blank: Understood, assigner: Assigner, reading: TableResult, constants: Mapping[str, float]) -> Understood:
    """Make the road test of signals and clock, with every message about it.

    A log that lasts for more than a year is none:
    ``problem`` says so.
    """
    timeline = reading.timeline
    if assigner.every > 1:
        assigner.say("thinned", Sentence("only one row in {every} of the log is read", every=assigner.every))
    build.time_messages(assigner, timeline)
    if timeline.duration > YEAR:
        return replace(blank, messages=tuple(assigner.messages), problem=_lasts_too_long(blank.file, reading))
    if "time" in constants and reading.clock.form != "counted":
        text = Sentence("the log has a clock, {column!r}: the stated interval is not used", column=reading.time_label)
        assigner.say("interval_not_used", text, "warning")
    channels = build.channels(assigner, timeline, constants)
    used = {signal.candidate.label for signal in assigner.signals.values()} | {reading.time_label}
    if not reading.long:
        used |= set(reading.used)
    offered = {label for ambiguous in assigner.ambiguous for label in ambiguous.candidates}
    offered |= {heading.label for heading in blank.headings if heading.numbered in offered}
    labels = list(reading.used) if reading.long else labels_of(blank.headings)
    unused = tuple(dict.fromkeys(label for label in labels if label not in used | offered))
    if not assigner.signals and not assigner.ambiguous:
        text = Sentence("none of the columns is a known quantity: name them, such as engine_speed or main_pressure")
        assigner.say("no_quantity", text, "warning")
    _ask_for_a_measured_pressure(assigner)
    for ambiguous in assigner.ambiguous:
        text, columns = Sentence("{quantity}: {why}: {columns}; choose one"), tuple(map(repr, ambiguous.candidates))
        text = text.of(quantity=QUANTITIES[ambiguous.quantity].said, why=ambiguous.why, columns=columns)
        assigner.say("ambiguous", text, "warning")
        assigner.refused.setdefault(ambiguous.quantity, text)
    road_test = RoadTest(
        blank.file, blank.sha256, reading.rows, timeline.duration, timeline.time, channels, timeline.segments,
        tuple(assigner.messages), blank.format, blank.encoding, blank.delimiter, blank.decimal,
        MappingProxyType({name: why for name, why in assigner.refused.items() if name not in channels}),
        reading.clock.date,
    )  # fmt: skip
    return replace(
        blank,
        ambiguous=tuple(assigner.ambiguous),
        unused=unused,
        messages=road_test.messages,
        road_test=road_test,
        time_label=reading.time_label,
        time_unit=reading.clock.unit,
        time_assumed=reading.clock.unit_assumed,
        rows_left_out=reading.left_out,
        segments=timeline.segments if reading.file_segments is None else reading.file_segments,
    )


def _lasts_too_long(file: str, reading: TableResult) -> RoadTestError:
    problem = Sentence(
        "by its clock, which leaps by {leap:.6g} s, the log lasts {years:.3g} years",
        leap=max(reading.timeline.gaps, default=reading.timeline.duration),
        years=reading.timeline.duration / YEAR,
    )
    expected = Sentence("the stamps of one drive: where the clock was set while it recorded, the log cut there")
    return RoadTestError(problem, place=Place(file=file, column=reading.time_label or None), expected=expected)


def _ask_for_a_measured_pressure(assigner: Assigner) -> None:
    """Ask for the main pressure where only a commanded one is logged: the user may know that it is measured."""
    commanded = assigner.signals.get("commanded_pressure")
    asked = {question.quantity for question in assigner.ambiguous}
    if commanded is not None and "main_pressure" not in {*assigner.signals, *assigner.refused, *asked}:
        why = Sentence("only a commanded one is logged, in which no leak shows")
        assigner.ambiguous.append(Ambiguous("main_pressure", (commanded.candidate.label,), why))


_DELIMITERS = {"\t": "\\t", " ": "whitespace"}


def workshop_unit(quantity: str, channel: Channel | None = None) -> Unit | None:
    """Return the unit in which people see a quantity; None for plain numbers."""
    info = QUANTITIES[quantity]
    if info.unit_kind is not None:
        return unit(info.workshop_unit, info.unit_kind)
    if quantity == "lock_up" and channel is not None:
        if channel.unit in ("kPa", "bar", "psi", "MPa", "Pa", "mbar", "kgf/cm²"):
            return unit("kPa", "pressure")
        if channel.unit == "%":
            return unit("%", "ratio")
    return None


def _number(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def _column(channel: Channel) -> dict[str, Any]:
    shown_unit = workshop_unit(channel.quantity, channel)
    good = channel.good
    good = good[np.isfinite(good)]
    ends = (float(good.min()), float(good.max())) if len(good) else (np.nan, np.nan)
    low, high = (shown_unit.from_si(end) for end in ends) if shown_unit else ends
    return {
        "quantity": channel.quantity,
        "column": channel.column or None,
        "unit": channel.unit or None,
        "unit_assumed": channel.unit_assumed,
        "kind": channel.kind,
        "source": channel.source,
        "samples": channel.samples,
        "suspect_samples": int(channel.suspect.sum()),
        "independent_samples": channel.independent,
        "min": _number(round(low, 9)),
        "max": _number(round(high, 9)),
        "value_unit": shown_unit.name if shown_unit else None,
        "sampling_hz": _number(channel.sampling_hz),
    }


def describe(understood: Understood) -> dict[str, Any]:
    """Return the ``import-log --json`` form: values in rpm, °C, kPa, km/h and s; ``unit`` is the file's own.

    While the log lacks an answer, ``rows`` and ``duration_s`` are None and ``needs`` says what is missing.
    """
    test = understood.road_test
    result: dict[str, Any] = {
        "atleak": __version__,
        "file": understood.file,
        "sha256": understood.sha256,
        "format": understood.format,
        "encoding": understood.encoding,
        "delimiter": _DELIMITERS.get(understood.delimiter or "", understood.delimiter),
        "decimal": understood.decimal,
        "rows": test.rows if test else None,
        "rows_left_out": understood.rows_left_out if test else None,
        "duration_s": _number(test.duration) if test else None,
        "segments": [],
        "columns": [],
        "ambiguous": [
            {"quantity": question.quantity, "candidates": list(question.candidates), "why": question.why}
            for question in understood.ambiguous
        ],
        "unused": list(understood.unused),
        "needs": str(understood.problem) if understood.problem else None,
        "messages": [{"level": each.level, "code": each.code, "text": each.text} for each in understood.messages],
    }
    if test is not None:
        result["segments"] = [
            {"start_row": each.start_row, "rows": each.rows, "start_s": each.start, "duration_s": each.duration}
            for each in understood.segments
        ]
        result["columns"] = [_time_column(understood, test), *map(_column, test.channels.values())]
    return result


def _time_column(understood: Understood, test: RoadTest) -> dict[str, Any]:
    steps = sum(segment.duration for segment in test.segments)
    count = sum(max(segment.rows - 1, 0) for segment in test.segments)
    return _column(
        Channel(
            "time", test.time, test.time, np.zeros(len(test.time), bool), understood.time_label, understood.time_unit,
            understood.time_assumed, source="logged" if understood.time_label else "derived",
            independent=len(test.time), sampling_hz=count / steps if steps > 0 else float("nan"),
        )
    )  # fmt: skip


def tidy_csv(test: RoadTest) -> str:
    """Return a road test as a plain table: one row a stamp, workshop units in the names, blank without sample."""
    columns = {"time [s]": test.time}
    for quantity, channel in test.channels.items():
        shown, values = workshop_unit(quantity, channel), test.values(quantity)
        assert values is not None
        columns[f"{quantity} [{shown.name}]" if shown else quantity] = shown.from_si(values) if shown else values
    return str(pd.DataFrame(columns).to_csv(index=False, float_format="%.10g", lineterminator="\n"))
