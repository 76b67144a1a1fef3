"""Print on a terminal: a diagnosis, what was understood of a log, sections, tables and records."""

from __future__ import annotations

import itertools
import sys
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Any, Literal, TextIO

from rich.console import Console, ConsoleOptions, RenderableType
from rich.segment import Segment
from rich.table import Table as Grid
from rich.text import Text

from atleak.analysis.pressures import pressures_at
from atleak.analysis.repair.plan import PumpStep, RepairStep, plan_repairs
from atleak.common.errors import Message
from atleak.common.printable import printable, unguarded
from atleak.common.style import look_of
from atleak.common.units import DM3_MIN, HHMMSS, KPA, PERCENT, RPM, SYSTEMS, find_unit, gear_name, kinds_of
from atleak.common.verdicts import Verdict
from atleak.common.wording import Wording, begun, signed, wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.land import LandDiagnosis
from atleak.diagnosis.road import RoadFindings
from atleak.diagnosis.rules import Rule
from atleak.diagnosis.uncertainty import UnitUncertainty
from atleak.engine.projection import Projection
from atleak.engine.road_leakage import RoadLeakage
from atleak.measurements.gauge_readings import LINE_TAP
from atleak.measurements.readings import LENGTHS_MEASURED, REPAIR_FITTED
from atleak.report.tables.answer import answer_facts, missing_table
from atleak.report.tables.before_opening import before_opening
from atleak.report.tables.complaint import MEASURE_FIRST, finding, measure_first, reason
from atleak.report.tables.evidence import next_sentence
from atleak.report.tables.first_sentence import impossible_part, may_parts, pump_sentence, shown_verdict, worn_pump
from atleak.report.tables.gauges import gauge_table, pattern_sentences
from atleak.report.tables.lands import ON_PAPER, leaking_worst_first, matrix_table, pair_table
from atleak.report.tables.names import positions
from atleak.report.tables.repairs import (
    no_help,
    option_rows,
    plan_ends,
    planned,
    pump_brings,
    step_consequence,
    step_in_words,
)
from atleak.report.tables.road_test import instant_record, road_instants
from atleak.report.tables.road_words import (
    check_sentences,
    log_sentences,
    pressure_sentences,
    test_sentences,
    warm_up_section,
)
from atleak.report.tables.sentences import (
    because_of,
    caveat_marks,
    caveats,
    circuit_sentence,
    counted_in_speed,
    fluid_in_state,
    measuring_temperature,
    nothing_now,
    pressure_sentence,
    readings_in_doubt,
    reserve_sentence,
    when_new,
)
from atleak.report.tables.table import VERDICT, Column, Facts, Picture, Points, Section, SectionPart, Table, with_sign
from atleak.report.tables.table import Text as Paragraph

CONDITIONS_ABREAST = 6  # columns of the matrix that fit beside one another
LARGEST = 5  # lands of the matrix where none is flagged
GAUGES_ABREAST = 8  # columns of gauge readings that fit beside one another


class TerminalConsole(Console):
    """A console that prints names from somebody's file safely; to standard output unless another stream is given."""

    def __init__(self, stream: TextIO | None = None) -> None:
        super().__init__(file=unguarded(stream or sys.stdout), highlight=False)

    def render(self, renderable: RenderableType, options: ConsoleOptions | None = None) -> Iterator[Segment]:
        """Make the text printable; the console's own signals to the terminal stay as they are."""
        for segment in super().render(renderable, options):
            yield segment if segment.control else segment._replace(text=printable(segment.text))

    def on_broken_pipe(self) -> None:
        """Let the command line handle a reader that went away: rich would end with status 1."""
        raise BrokenPipeError


def _print(*parts: str | RenderableType) -> None:
    """Print texts sign for sign, and whatever else rich can show."""
    console = TerminalConsole()
    for part in parts:
        console.print(Text(part) if isinstance(part, str) else part)


def print_diagnosis(diagnosis: Diagnosis, units: str = "metric") -> None:
    """Print totals, flagged lands with the rule that flagged them, order of repair, and warnings."""
    _print(*_diagnosis(diagnosis, wording("en", units)))


def _diagnosis(diagnosis: Diagnosis, say: Wording) -> Iterator[str | RenderableType]:
    controller, readings = diagnosis.controller, diagnosis.readings
    yield f"{controller.name} · {fluid_in_state(diagnosis, say)} · profile {diagnosis.profile.label}"
    measured = f"{diagnosis.measured} of {len(diagnosis.lands)} lands measured"
    if readings is not None:
        measured += f" in {readings.file}; temperature of measuring: {measuring_temperature(diagnosis, say)}"
    yield say("findings.alone") if diagnosis.without_sheet else measured
    of_sheet = readings.messages if readings is not None else ()
    yield from (say.sentence(message.text) for message in of_sheet if message.code in (LENGTHS_MEASURED, REPAIR_FITTED))
    style = look_of(shown_verdict(diagnosis)).style
    yield from (Text(f"{name}: {said}", style=style) for name, said in answer_facts(diagnosis, say).rows)
    yield Text(_verdict(diagnosis, say), style=style)
    yield from filter(None, (*caveats(diagnosis, say), readings_in_doubt(diagnosis, say)))
    said = "; ".join(filter(None, (nothing_now(diagnosis, say), *may_parts(diagnosis, say))))
    if said:
        yield f"{begun(said)}."
    if readings is not None and readings.one_direction and diagnosis.open_lands:
        yield next_sentence(diagnosis, say)
    yield from _complaint(diagnosis, say)
    if not diagnosis.without_sheet:
        yield from _unit(diagnosis, say)
    yield from _gauges(diagnosis, say)
    for section in before_opening(diagnosis, say):
        yield section.title
        for part in section.parts:
            yield from (laid_out(part),) if isinstance(part, Table) else _lines(part)
    if diagnosis.log is not None:
        yield from _log(diagnosis, diagnosis.log, say)
    if diagnosis.missing_flagged:
        yield laid_out(missing_table(diagnosis, say))
    yield from (f"! {say.sentence(message.text)}" for message in diagnosis.messages if message.level == "warning")


def _unit(diagnosis: Diagnosis, say: Wording) -> Iterator[str | RenderableType]:
    """Return what follows from the clearances: totals, flagged lands, order of repair."""
    for number, projection in enumerate(diagnosis.presented, start=1):
        yield from _total(diagnosis, projection, number, say)
        yield from _pressures(diagnosis, projection, say)
    yield from filter(None, [pump_sentence(diagnosis, say)])
    counted = counted_in_speed(diagnosis, say)
    yield f"At these speeds the pump covers the leakage and its own slip; {counted}."
    if diagnosis.flagged:
        flagged = pair_table(diagnosis, diagnosis.flagged, say, at=())
        flagged = flagged.without(*(key for key in ON_PAPER if key != "mounting"), "decision")
        named = {"pair": Column("pair", of=lambda land: _named(diagnosis, land))}
        yield laid_out(replace(flagged, columns=tuple(named.get(each.key, each) for each in flagged.columns)))
        if say.units == "us":
            yield say("texts.radial")
    else:
        yield "No measured land has reached a limit."
    yield from _matrix(diagnosis, say)
    yield from _repairs(diagnosis, say)


def print_log(record: dict[str, Any], units: str | None = None) -> None:
    """Print what was understood of a log, from its record: in the log's own units, or in those of a system."""
    say = wording("en", units or "metric")
    form = [record["format"], record["encoding"], record["decimal"] and f"decimal {record['decimal']}"]
    segments = record["segments"]
    left_out = f" ({record['rows_left_out']} line(s) left out)" if record["rows_left_out"] else ""
    table = Grid("quantity", "column", "unit", "samples", "lowest", "highest", "Hz")
    for each in table.columns:
        each.no_wrap, each.overflow = each.header not in ("column", "unit"), "fold"  # no number goes on in another line
    for column in record["columns"]:
        unit, ends = _in_own_unit(column) if units is None else _in_units(column, say)
        unit = f"{unit or '–'}{' (assumed)' if column['unit_assumed'] else ''}"
        numbers = [_short(number) for number in (*ends, column["sampling_hz"])]
        if column["quantity"] == "gear":
            numbers[:2] = ["–" if end is None else gear_name(int(end)) for end in ends]
        quantity = "\n".join([column["quantity"], *([column["kind"]] if column["kind"] != "unknown" else [])])
        cells = (quantity, column["column"] or column["source"], unit, str(column["samples"]))
        table.add_row(*(Text(cell) for cell in (*cells, *numbers)))
    _print(
        f"{record['file']}: {', '.join(str(part) for part in form if part)}",
        f"{record['rows']} rows{left_out}, {record['duration_s']:.3f} s in {len(segments)} segment(s)",
        table,
        *([f"not used: {', '.join(record['unused'])}"] if record["unused"] else []),
        *(f"? {each['quantity']}: {', '.join(map(str, each['candidates']))}" for each in record["ambiguous"]),
        *(f"{'!' if each['level'] == 'warning' else '·'} {each['text']}" for each in record["messages"]),
    )


def _in_units(column: dict[str, Any], say: Wording) -> tuple[str | None, tuple[float | None, float | None]]:
    """Return the reader's unit of a log's column, and in it the least and the greatest value."""
    ends = column["min"], column["max"]
    kind = next((kind for kind, unit in SYSTEMS["metric"].items() if unit.name == column["value_unit"]), None)
    if kind is None:
        return column["value_unit"], ends
    low, high = (None if end is None else round(say.convert(end, kind), max(say.digits(kind), 1)) for end in ends)
    return say.unit(kind), (low, high)


def _in_own_unit(column: dict[str, Any]) -> tuple[str | None, tuple[float | None, float | None]]:
    """Return the unit of a log's column, and in it the least and the greatest value; of a clock they are in seconds."""
    own, of_record, ends = column["unit"], column["value_unit"], (column["min"], column["max"])
    for kind in kinds_of(own or "") if of_record else ():
        to, written = find_unit(own, kind), find_unit(of_record, kind)
        if to is not None and written is not None and to.name != HHMMSS:
            least, most = (None if end is None else to.from_si(written.to_si(end)) for end in ends)
            return own, (least, most)
    return (f"{of_record} ({own})" if of_record and own else own or of_record), ends


def _short(value: float | None) -> str:
    return "–" if value is None else f"{value + 0.0:.{4 if abs(value) < 1e4 else 9}g}"


def _widths(content: Table, texts: Sequence[Sequence[str]]) -> tuple[list[int], int]:
    """Return the width of each column, and of the blanks beside it; no width where not even single words fit.

    No number and no id is broken. What room is left goes to cells, then to headings, each by what it lacks.
    """
    least, cells, whole = [], [], []
    for column, heading, *said in zip(content.columns, content.headings, *texts, strict=True):
        unbroken = column.whole or column.is_number or bool(column.words_of) or column.kind == VERDICT
        words = said if unbroken else [word for each in said for word in each.split()]
        least.append(max(map(len, [*words, *heading.split()])))
        cells.append(max(map(len, said), default=0))
        whole.append(max(cells[-1], len(heading)))
    room = TerminalConsole().width - len(least) - 1 - sum(least)  # beside the lines between them
    blanks = int(2 * len(least) <= room)
    room -= 2 * blanks * len(least)
    if room < 0:
        return [], blanks
    for wanted in (cells, whole):
        while room > 0 and any(width < most for width, most in zip(least, wanted, strict=True)):
            least[max(range(len(least)), key=lambda at: wanted[at] / least[at])] += 1
            room -= 1
    return least, blanks


def laid_out(content: Table) -> Grid:
    """Return a table as a terminal shows it, with verdicts in their colours.

    Where its words do not fit beside one another with blanks between them, it has none; only then is a word broken.
    """
    levels = [[column.judged(item).level for column in content.columns] for item in content.rows]
    texts = [[*map(with_sign, content.texts(item), row)] for item, row in zip(content.rows, levels, strict=True)]
    widths, blanks = _widths(content, texts)
    grid = Grid(title=content.title or None, title_justify="left", title_style="", padding=(0, blanks))
    for column, heading, width in itertools.zip_longest(content.columns, content.headings, widths):
        side: Literal["left", "right"] = "right" if column.is_number else "left"
        grid.add_column(Text(heading), justify=side, overflow="fold", width=width)
    for row, judged in zip(texts, levels, strict=True):
        styles = ["" if level is None else look_of(level).style for level in judged]
        grid.add_row(*(Text(text, style=style) for text, style in zip(row, styles, strict=True)))
    return grid


def print_table(content: Table) -> None:
    """Print a table, and below it the remarks on its items."""
    remarks = filter(None, map(content.remark, content.rows)) if content.remark else ()
    _print(laid_out(content), *dict.fromkeys(remarks))


def print_sections(sections: Iterable[Section], messages: Iterable[Message] = (), say: Wording | None = None) -> None:
    """Print sections, one after the other, of a chart the numbers that it shows; then messages, warnings marked."""
    console = TerminalConsole()
    for section in sections:
        console.print()
        console.print(Text(section.title, style="bold" if section.level > 1 else "bold underline"))
        for part in section.parts:
            if isinstance(part, Table):
                print_table(replace(part, title=""))
            elif isinstance(part, Picture) and part.numbers is not None:
                print_table(replace(part.numbers, title=""))
            level = part.level if isinstance(part, Paragraph) else None
            for line in _lines(part):
                console.print(Text(line, style="" if level is None else look_of(level).style))
    for message in messages:
        said = message.text if say is None else say.sentence(message.text)
        console.print(Text(f"{'!' if message.level == 'warning' else '·'} {said}"))


def _lines(part: SectionPart) -> Iterator[str]:
    if isinstance(part, Paragraph):
        yield part.words
    elif isinstance(part, Points):
        yield from (f"- {item}" for item in part.items)
    elif isinstance(part, Facts):
        yield from (f"{name}: {value}" for name, value in part.rows)


def print_records(columns: Sequence[str], rows: Sequence[dict[str, Any]], whole: Sequence[str] = ()) -> None:
    """Print records as a table; neither the first column nor those that are ``whole`` are ever cut."""
    whole = (columns[0], *whole)
    shown = [{name: _cell(row[name]) for name in columns} for row in rows]
    made = tuple(Column(name, words=name.replace("_", " "), whole=name in whole) for name in columns)
    print_table(Table("", made, shown, wording("en")))


def _cell(value: Any) -> str:
    if isinstance(value, dict):
        return ", ".join(f"{number:g} at {name} °C" for name, number in value.items())
    if isinstance(value, list):
        return ", ".join(map(str, value))
    if isinstance(value, float):
        return f"{value:g}"
    if isinstance(value, bool):  # before any comparison: 1 == True
        return "yes" if value else "no"
    return "–" if value is None else str(value)


def _log(diagnosis: Diagnosis, log: RoadFindings, say: Wording) -> Iterator[str | RenderableType]:
    """Return what the log says by itself, the leakage over it, and what to check next, one line each."""
    yield f"Road test {log.road_test.file}:"
    for sentence in (*pressure_sentences(log, say), *test_sentences(log, say), *log_sentences(log, say)):
        yield f"  {sentence}"
    if diagnosis.road is not None and diagnosis.judged:  # else it is that of a new unit
        yield f"  {begun(_road(diagnosis.road, diagnosis.uncertainty, say))}"
    section = warm_up_section(diagnosis, say)
    for part in section.parts if section else ():
        yield from ([laid_out(part)] if isinstance(part, Table) else (f"  {line}" for line in _lines(part)))
    checks = check_sentences(diagnosis, say)
    if checks:
        yield say("findings.check_next")
        yield from (f"  {number}. {check}" for number, check in enumerate(checks, start=1))


def _road(road: RoadLeakage, uncertainty: UnitUncertainty | None, say: Wording) -> str:
    parts = []
    for row in road_instants(road):
        if row.name != "min_leakage":
            at = row.instant
            record = instant_record(at, uncertainty)
            share = ""
            if at.share is not None:
                between = _between(record, "share_{}_percent", "percent", 1, say)
                share = f" ({at.share * PERCENT:.1f} % of the pump's flow{between})"
            between = _between(record, "leakage_{}_dm3_min", "flow", 2, say)
            leakage = f"{_plainly(at.leakage * DM3_MIN, 'flow', 2, say)} {say.unit('flow')}{between}"
            parts.append(f"{row.label(say)} {leakage}{share} at {at.time:.2f} s")
    return f"{'; '.join(parts)}."


def _between(record: dict[str, Any], name: str, kind: str, digits: int, say: Wording) -> str:
    """Return the interval of a value of a record; an empty text where it is not known."""
    low, high = (record[name.format(end)] for end in ("low", "high"))
    if low is None or high is None:
        return ""
    return f", {_plainly(low, kind, digits, say)} to {_plainly(high, kind, digits, say)}"


def _plainly(carried: float, kind: str, digits: int, say: Wording) -> str:
    """Return a value in the reader's unit without blanks between its thousands."""
    return f"{say.convert(carried, kind):.{say.digits(kind, digits)}f}"


def _verdict(diagnosis: Diagnosis, say: Wording) -> str:
    """Return the verdict of the unit, and which land or total gave it."""
    decided_by, marks, level = diagnosis.decided_by, caveat_marks(diagnosis, say), shown_verdict(diagnosis)
    within = level != diagnosis.verdict  # nothing is past a limit, and something is open or in doubt
    word = f"{look_of(level).sign} {say('diagnosis.open')}" if within else signed(level)
    sentence = f"unit: {word}" + (f" ({', '.join(marks)})" if marks else "")
    worn = worn_pump(diagnosis, say)
    if diagnosis.impossible:
        return f"{sentence}: {impossible_part(diagnosis, say)}"
    if worn is not None:
        pump = f"{worn} {say('pump.repair_first')}"
        if decided_by is diagnosis.pump:
            return f"{sentence}. {pump}"
        sentence = f"{pump}\n{sentence}"
    if decided_by is None:
        alone = diagnosis.without_sheet and diagnosis.verdict != Verdict.NOT_MEASURED
        return f"{sentence}, by the {_measured_by(diagnosis)} alone" if alone else sentence
    if isinstance(decided_by, Rule):
        because = because_of(diagnosis, decided_by, say)
        return f"{sentence} {because}" if because else f"{sentence}, decided by the {say.sentence(decided_by.label)}"
    assert isinstance(decided_by, LandDiagnosis)
    return f"{sentence}, decided by {_named(diagnosis, decided_by)}"


def _named(diagnosis: Diagnosis, found: LandDiagnosis) -> str:
    """Name a land by its id, which options and records take, and its component's name."""
    component, land = found.key
    return f"{component}/{land} {diagnosis.controller.components[component]}".rstrip()


def _measured_by(diagnosis: Diagnosis) -> str:
    """Name what was judged, and what it was measured with: gauges, a log, or both."""
    readings = diagnosis.pressures.readings if diagnosis.pressures else ()
    main = "main pressure"
    taps = {each.cell.tap == LINE_TAP for each in readings if each.verdict is not None}
    judged = "circuit pressures" if taps == {False} else "main and circuit pressures" if False in taps else main
    if diagnosis.log is None:
        return f"{judged} of gauges"
    if diagnosis.pressures is None or judged == main:
        return f"{main} of {'the log' if diagnosis.pressures is None else 'gauges and the log'}"
    return f"{judged} of gauges and the {main} of the log"


def _complaint(diagnosis: Diagnosis, say: Wording) -> Iterator[str]:
    """Return the customer's complaint, what explains it, and the lands that it asks to measure first, one line each."""
    if diagnosis.complaint is None:
        return
    shows = "; ".join(say.condition(each.condition) for each in diagnosis.complained)
    ranked = measure_first(diagnosis)
    yield f"Complaint: {diagnosis.complaint.label}. It shows at: {shows}. {finding(diagnosis, say)}"
    for each in ranked[:MEASURE_FIRST]:
        yield f"  {_named(diagnosis, each.land)}: {reason(each, say)}"
    if len(ranked) > MEASURE_FIRST:
        yield f"  … and {len(ranked) - MEASURE_FIRST} more that leak there"


def _total(diagnosis: Diagnosis, projection: Projection, number: int, say: Wording) -> Iterator[str]:
    """Return the lines of one condition: the share beside that of the same unit new, then the flows."""
    worst = ", the worst condition" if projection is diagnosis.worst and len(diagnosis.projections) > 1 else ""
    rule = diagnosis.total_rule(projection)
    new = "" if rule.growth is None else f"; {when_new(diagnosis, projection, rule.growth)}"
    share = f"{projection.share * PERCENT:.1f} % of the pump's flow" + (" demanded" if projection.share > 1.0 else "")
    share = share if projection.pump_capacity > 0.0 else "at this condition the pump delivers nothing"
    band = diagnosis.band(projection) or "as new, not measured"
    decided = diagnosis.decided(rule)
    if rule.probable and rule.verdict.flagged and decided is not None:
        band = f"{band} with a probability of {decided.probability_over_limit * PERCENT:.0f} %"
    yield f"{number}. {say.condition(projection.condition)}: {share}, {band}{worst}{new}"
    leakage, capacity = (
        _plainly(flow * DM3_MIN, "flow", 2, say) for flow in (projection.leakage, projection.pump_capacity)
    )
    flows = f"{leakage} of {capacity} {say.unit('flow')}"
    yield f"   {flows}; {positions(diagnosis, projection)}; covered from {projection.minimum_speed * RPM:.0f} rpm"


def _pressures(diagnosis: Diagnosis, projection: Projection, say: Wording) -> Iterator[str]:
    """Return the lines of one condition about its pressures: line, reserve, then the circuits, the worst by itself."""
    at = pressures_at(diagnosis, projection)
    yield f"   {pressure_sentence(at, say)}"
    level = "" if at.reserve_verdict is None else f" {signed(at.reserve_verdict)}"
    yield f"   {reserve_sentence(at, say)}{level}"
    others: dict[Verdict | None, list[str]] = {}
    for circuit in at.circuits:
        if circuit.verdict is not None and circuit.verdict.flagged:
            yield f"   {circuit_sentence(diagnosis, circuit, say)}"
        elif not circuit.vented and circuit.circuit is not None:
            others.setdefault(circuit.verdict, []).append(
                f"{circuit.circuit.name} {_plainly(circuit.now * KPA, 'pressure', 0, say)} {say.unit('pressure')}"
            )
    for verdict, circuits in others.items():
        yield f"   {signed(verdict) + ': ' if verdict else ''}{', '.join(circuits)}"


def _matrix(diagnosis: Diagnosis, say: Wording) -> Iterator[str | RenderableType]:
    """Return the flagged lands, or where none is the largest leaks, at every condition by its number."""
    rows = leaking_worst_first(diagnosis, diagnosis.presented)
    shown = [row for row in rows if row.land.verdict.flagged] or rows[:LARGEST]
    if not shown:
        return
    what = "flagged lands" if diagnosis.flagged else "lands that leak most"
    yield f"Share of the pump's flow [%] of the {what} at the conditions above, by their numbers:"
    table = matrix_table(diagnosis, shown, say)
    pair = Column("pair", words="pair", of=lambda row: "/".join(map(str, row.land.key)))
    _, *shares, _ = (replace(each, kind=None, words=f"{number}.") for number, each in enumerate(table.columns))
    for first in range(0, len(shares), CONDITIONS_ABREAST):
        yield laid_out(replace(table, columns=(pair, *shares[first : first + CONDITIONS_ABREAST])))
    for row in shown:
        if row.elsewhere:
            component, land = row.land.key
            yield f"{component}/{land} {row.elsewhere}"


def _repairs(diagnosis: Diagnosis, say: Wording) -> Iterator[str]:
    """Return the order of repair, each land with what it brings where it helps most, and where that ends."""
    plan = plan_repairs(diagnosis)
    rows = option_rows(plan)
    if plan.order:
        as_left = "as its repair leaves it" if rows else "as new"
        yield f"Order of repair, each land {as_left} after those before it:"
    for number, step in enumerate(plan.order, start=1):
        named = _named(diagnosis, step.land) if isinstance(step, RepairStep) else step_in_words(diagnosis, step, say)
        yield f"{number:3}. {named}: {_helps(step, say)}; {step_consequence(diagnosis, step, say)}"
        for row in rows:
            if row.step is step:
                yield f"       {'→' if row.chosen else 'or'} {planned(row, say)}"
    yield from plan_ends(plan, say)


def _helps(step: PumpStep | RepairStep, say: Wording) -> str:
    if not step.helps:
        return no_help(step, say)
    at = step.at
    if isinstance(step, PumpStep):
        return pump_brings(at, say)
    before, after = (say.number(each.share * PERCENT, 1) for each in (at.before, at.after))
    shares = f"{before} → {after} %"
    return f"total share at {say.condition(at.condition)} {shares} ({at.after.band})"


def _gauges(diagnosis: Diagnosis, say: Wording) -> Iterator[str | RenderableType]:
    """Return what gauges showed, reading by reading, and the patterns in it."""
    check = diagnosis.pressures
    if check is None:
        return
    judged = "not judged" if check.verdict is None else signed(check.verdict)
    yield f"Gauge readings of {check.table.file}, the vehicle standing: {judged}"
    table = gauge_table(check, say).without("lost_between")
    yield laid_out(table if len(table.columns) <= GAUGES_ABREAST else table.without("decision"))
    for pattern in pattern_sentences(check, diagnosis.controller, say):
        yield f"→ {pattern}"
