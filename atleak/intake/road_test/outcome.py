"""Holds what is understood of a log and makes a road test of its assigned columns."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

from atleak.errors import Message, Place, RoadTestError
from atleak.intake.road_test.channels import build
from atleak.intake.road_test.channels.assign import Ambiguous, Assigner
from atleak.intake.road_test.channels.protocol import TableResult
from atleak.intake.road_test.clock.clocks import YEAR
from atleak.intake.road_test.files.headings import Heading
from atleak.intake.road_test.names.memory import NOT_LOGGED
from atleak.road_test import QUANTITIES, RoadTest, Segment
from atleak.sentence import Sentence

FORMATS: Mapping[str, Sentence] = MappingProxyType(  # of files, as pages name them; those of MDF and Parquet are names
    {"delimited text": Sentence("delimited text"), "workbook": Sentence("workbook")}
)


@dataclass(frozen=True)
class Understood:
    """What is understood of a log, even while questions are open.

    ``road_test`` is None while ``problem`` says what is needed. ``headings`` are all columns, ``preview`` the first
    rows as text, ``ambiguous`` the quantities to choose a column for, ``unused`` the columns no quantity came from.
    ``signature`` is the key under which an answer is remembered; ``segments`` count the file's rows.
    """

    file: str
    sha256: str
    format: str
    encoding: str | None
    delimiter: str | None
    decimal: str | None
    headings: tuple[Heading, ...]
    preview: tuple[tuple[str, ...], ...]
    signature: str
    ambiguous: tuple[Ambiguous, ...] = ()
    unused: tuple[str, ...] = ()
    messages: tuple[Message, ...] = ()
    road_test: RoadTest | None = None
    problem: RoadTestError | None = None
    time_label: str = ""
    time_unit: str = ""
    time_assumed: bool = False
    segments: tuple[Segment, ...] = ()
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
        text = Sentence(
            "{quantity}: {why}: {columns}; choose one",
            quantity=QUANTITIES[ambiguous.quantity].said,
            why=ambiguous.why,
            columns=tuple(map(repr, ambiguous.candidates)),
        )
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
