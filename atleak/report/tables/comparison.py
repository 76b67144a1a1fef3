"""Say what two visits of one unit come to: verdicts, what changed, tables of lands, totals, pressures and events.

`comparison_sections` is what page and terminal print; `comparison_record` is what scripts read, each side by the keys
of a diagnosis.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from atleak.analysis.changes import (
    SIDES,
    Change,
    ChoiceName,
    Comparison,
    ConditionComparison,
    EventPair,
    LandComparison,
    LogComparison,
)
from atleak.common.units import DM3_MIN, KPA, PERCENT, UM
from atleak.common.wording import Wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.land import LandDiagnosis
from atleak.engine.projection import Projection
from atleak.measurements.road_test import RoadTest
from atleak.report.charts.comparison_figures import clearance_chart, total_chart
from atleak.report.json.conditions import (
    condition_record,
    finite,
    interval_ends,
    message_record,
    named_record,
    of_land,
    scaled,
)
from atleak.report.json.diagnosis import FORMAT, head_record, land_record
from atleak.report.tables.first_sentence import shown_verdict
from atleak.report.tables.lands import MatrixRow
from atleak.report.tables.names import land_words
from atleak.report.tables.road_words import event_name
from atleak.report.tables.sentences import caveats
from atleak.report.tables.table import VERDICT, Column, Picture, Section, SectionPart, Table, Text, columns
from atleak.version import __version__


def comparison_record(comparison: Comparison) -> dict[str, Any]:
    """Return the record of a comparison, in the form ``atleak compare --json`` writes.

    ``before`` and ``after`` hold what ``atleak diagnose --json`` says of the same job; ``alike`` is the unit after by
    the choices of the job before, null where no choice differs. Changes of conditions are to ``alike``.
    """
    before, after = comparison.before, comparison.after
    alike = comparison.alike if comparison.differing else None
    return {
        "format": FORMAT,
        "atleak": __version__,
        "before": head_record(before),
        "after": head_record(after),
        "alike": None if alike is None else head_record(alike),
        "differing": [vars(each) for each in comparison.differing],
        "lands_compared": len(comparison.compared),
        "lands_changed": len(comparison.changed),
        "lands": [_land(comparison, land) for land in comparison.lands],
        "conditions": [_condition(comparison, each) for each in comparison.conditions],
        "events": None if comparison.logs is None else [_pair(pair) for pair in comparison.logs.pairs],
        "messages": [message_record(message) for message in comparison.messages],
    }


def _land(comparison: Comparison, land: LandComparison) -> dict[str, Any]:
    change = land.change
    return {
        **of_land(land.key),
        "before": _side_of_land(comparison.before, land.before),
        "after": _side_of_land(comparison.after, land.after),
        **named_record(change, change_um="value", change_u_um="standard_uncertainty"),
        **interval_ends("change_{}_um", change.interval if change else None, UM),
        **named_record(change, "significant"),
    }


def _side_of_land(diagnosis: Diagnosis, land: LandDiagnosis | None) -> dict[str, Any] | None:
    return None if land is None else land_record(diagnosis, MatrixRow.of(land, diagnosis, diagnosis.projections))


def _condition(comparison: Comparison, each: ConditionComparison) -> dict[str, Any]:
    record = {
        "name": each.name,
        "label": each.projection.condition.label,
        "before": _side(comparison.before, each.before),
        "after": _side(comparison.after, each.after),
        "alike": _side(comparison.alike, each.alike) if comparison.differing else None,
        **_change("leakage", "dm3_min", each.leakage, DM3_MIN),
        **_change("share", "percent", each.share, PERCENT),
        **_change("reserve", "", each.reserve, 1.0),
        **_change("p_g_held", "kpa", each.main_pressure, KPA),
    }
    record["circuits"] = [
        {**named_record(one.circuit, "id", "name"), **_change("pressure", "kpa", one.change, KPA)}
        for one in each.circuits
    ]
    return record


def _side(diagnosis: Diagnosis, at: Projection | None) -> dict[str, Any] | None:
    return None if at is None else condition_record(diagnosis, at)


def _change(name: str, unit: str, change: Change | None, factor: float) -> dict[str, Any]:
    """Return a change with its interval, the unit last in each key."""
    low, high = (change.interval if change else None) or (None, None)
    values = {"change": change.value if change else None, "change_low": low, "change_high": high}
    record: dict[str, Any] = {
        "_".join(filter(None, (name, what, unit))): scaled(value, factor) for what, value in values.items()
    }
    return {**record, f"{name}_significant": change.significant if change else None}


def _pair(pair: EventPair) -> dict[str, Any]:
    return {
        **named_record(pair.event, "kind", "from_gear", "to_gear"),
        "order": pair.order,
        "before": pair.before and named_record(pair.before, "start_s", "stop_s"),
        "after": pair.after and named_record(pair.after, "start_s", "stop_s"),
    }


def verdicts_sentence(comparison: Comparison, say: Wording) -> str:
    """Say the verdict of the unit at both visits, with their signs."""
    before, after = (say.signed(each.verdict) for each in (comparison.before, comparison.after))
    return say("comparison.verdicts", before=before, after=after)


def visit_caveats(comparison: Comparison, say: Wording) -> list[str]:
    """Say what each verdict rests on; what is so at one visit alone, or differs, begins with whose it is."""
    before, after = caveats(comparison.before, say), caveats(comparison.after, say)
    return [
        *(line for line in before if line in after),
        *(f"{say('comparison.before')}: {line}" for line in before if line not in after),
        *(f"{say('comparison.after')}: {line}" for line in after if line not in before),
    ]


def changed_sentence(comparison: Comparison, say: Wording) -> str:
    """Say how many lands changed by more than the measurements can be off."""
    compared = len(comparison.compared)
    if not compared:
        return say("comparison.none_compared")
    return say("comparison.changed", changed=len(comparison.changed), compared=compared)


def total_sentence(comparison: Comparison, say: Wording) -> str | None:
    """Say what the total was and is where it was worst before; None where no total can be compared.

    Where choices differ this is the unit after by the choices of the job before, and its own total stands beside it.
    """
    leading = comparison.leading
    if leading is None or leading.before is None or leading.share is None:
        return None
    own = leading.after if comparison.differing else None
    return say(
        "comparison.total" if own is None else "comparison.total_alike",
        condition=say.condition(leading.before.condition),
        before=say.percent(leading.share.before),
        after=say.percent(leading.share.after),
        own="" if own is None else say.percent(own.share),
        new=say.percent(comparison.before.new_at(leading.before).share),
        how=how_sure(leading.share, say),
    )


def how_sure(change: Change | None, say: Wording) -> str:
    """Say whether a change is more than the measurements can be off."""
    known = None if change is None else change.significant
    return say(f"comparison.{'unknown' if known is None else 'beyond' if known else 'within'}")


def differing_sentence(comparison: Comparison, say: Wording) -> str | None:
    """Say in which choices the two jobs differ, and that the difference is not the repair's alone."""
    if not comparison.differing:
        return None
    names: list[ChoiceName] = [each.name for each in comparison.differing]
    return say("comparison.differing", choices=", ".join(say(f"choices.{name}") for name in names))


def _land_name(comparison: Comparison, land: LandComparison, say: Wording) -> str:
    """Name a land: ``25/1 main pressure valve``."""
    after = comparison.after.controller
    return land_words(after if land.key[0] in after.components else comparison.before.controller, land.key, say)


def with_uncertainty(change: Change | None, say: Wording) -> str:
    """Return a change of a clearance [µm] with its sign and half of its 95 % interval: ``−23.5 ± 3.2``."""
    if change is None or change.interval is None:
        return "–"
    half = 0.5 * (change.interval[1] - change.interval[0]) * UM
    digits = say.digits("clearance", 1)
    value = signed_number(say.convert(change.value * UM, "clearance"), digits, say)
    return f"{value} ± {say.value(half, 'clearance', 1)}"


def signed_number(value: float, digits: int, say: Wording) -> str:
    """Return a number with its sign, also where it is positive; no sign where it rounds to zero."""
    text = say.number(value, digits)
    return f"+{text}" if value > 0.0 and float(f"{value:.{digits}f}") != 0.0 else text


def compared_event_name(pair: EventPair, say: Wording) -> str:
    """Name a matched event: ``shift 1 → 2``; of several alike with its place among them."""
    return event_name(pair.event, say) + (f" ({pair.order})" if pair.order > 1 else "")


_OF_A_QUANTITY = ("condition", "what", "before", "after", "change", "interval", "unit", "changed")
_SHOWN = 0.5  # [kPa] that a pressure without decimals shows
_UM = "clearance", 1


def land_table(comparison: Comparison, lands: Sequence[LandComparison], say: Wording) -> Table:
    """Return one row for every land: both verdicts, clearances and what changed, wear, share and decision."""

    def both(key: str, of: Callable[[LandDiagnosis], Any], *kind: Any, times: float | None = None) -> Iterator[Column]:
        def at(side: str, land: LandComparison) -> Any:
            diagnosed: LandDiagnosis | None = getattr(land, side)
            return None if diagnosed is None else of(diagnosed)

        for side in ("before", "after"):
            yield replace(Column(f"{key}_{side}", *kind), of=partial(at, side), times=times)

    shown = (
        Column("verdict", VERDICT, width=92, of=lambda land: land.after and land.after.verdict),
        Column("was", of=lambda land: land.before and say.signed(land.before.verdict)),
        Column("pair", width=176, of=lambda land: _land_name(comparison, land, say)),
        *both("clearance", lambda land: land.state.radial_clearance if land.state.measured else None, *_UM, times=UM),
        Column("change", words_of="clearance", of=lambda land: land.change and with_uncertainty(land.change, say)),
        Column("changed", of=lambda land: land.change and land.significant),
        *both("wear", lambda land: land.wear, "percent", 1, times=PERCENT),
        *both("share", lambda land: finite(land.share), "percent", 2, times=PERCENT),
        *both("decision", lambda land: land.shown_as and say.get("decisions", land.shown_as)),
    )
    return Table("lands", shown, lands, say).filled


def compared_condition_table(comparison: Comparison, say: Wording, *, brief: bool = False) -> Table:
    """Return one row for every total, reserve and pressure of every condition that both jobs were judged at.

    In brief a pressure that did not change by as much as is shown is left out, and so is the flow behind a share; a
    condition is named in its first row only.
    """
    rows: list[dict[str, Any]] = []
    for each in comparison.on_both_sides:
        of_condition = _quantities(each, say, brief=brief)
        if brief:
            of_condition[1:] = [{**row, "condition": ""} for row in of_condition[1:]]
        rows += of_condition
    return Table("totals", columns(*_OF_A_QUANTITY), rows, say).filled


def _quantities(each: ConditionComparison, say: Wording, *, brief: bool) -> list[dict[str, Any]]:
    rows = [
        _row(each, say("compared.share"), "percent", each.share, PERCENT, 1, say),
        None if brief else _row(each, say("compared.leakage"), "flow", each.leakage, DM3_MIN, 2, say),
        _row(each, say("compared.reserve"), "number", each.reserve, 1.0, 2, say),
    ]
    line = say("compared.main_pressure")
    pressures = [(line, each.main_pressure), *((say.name(one.circuit.name), one.change) for one in each.circuits)]
    for name, change in pressures:
        moved = change is not None and (change.significant or abs(change.value * KPA) >= _SHOWN)
        rows.append(_row(each, name, "pressure", change, KPA, 0, say) if moved or not brief else None)
    return [row for row in rows if row is not None]


def _row(
    each: ConditionComparison, what: str, kind: str, change: Change | None, factor: float, digits: int, say: Wording
) -> dict[str, Any] | None:
    if change is None:
        return None
    places, scale = say.digits(kind, digits), say.convert(factor, kind)  # none of these kinds has a zero of its own
    return {
        "condition": say.condition(each.before.condition) if each.before else "",
        "what": what,
        "before": say.number(change.before * scale, places),
        "after": say.number(change.after * scale, places),
        "change": signed_number(change.value * scale, places, say),
        "interval": "" if change.interval is None else _interval(change.interval, scale, places, say),
        "unit": say.unit(kind),
        "changed": change.significant,
    }


def _interval(ends: tuple[float, float], scale: float, places: int, say: Wording) -> str:
    low, high = (say.number(end * scale, places) for end in ends)
    return say("written.to", low=low, high=high)


def compared_event_table(logs: LogComparison, say: Wording) -> Table:
    """Return one row for every event of either log, before → after: start, duration, mean pressure and fluid."""

    def means(pair: EventPair, quantity: str, factor: float) -> list[float | None]:
        sides = (logs.before.road_test, pair.before), (logs.after.road_test, pair.after)
        return [
            _mean(None if event is None else test.window(event.start, event.stop), quantity, factor)
            for test, event in sides
        ]

    def both(pair: EventPair, name: str) -> list[float | None]:
        return [None if event is None else getattr(event, name) for event in (pair.before, pair.after)]

    def arrow(key: str, kind: str, digits: int, of: Callable[[EventPair], Iterable[float | None]]) -> Column:
        return Column(key, words_of=kind, of=lambda pair: " → ".join(say.value(at, kind, digits) for at in of(pair)))

    shown = (
        Column("event", of=lambda pair: compared_event_name(pair, say)),
        arrow("starts", "time", 1, lambda pair: both(pair, "start")),
        arrow("lasts", "time", 1, lambda pair: both(pair, "duration")),
        arrow("mean_pressure", "pressure", 0, lambda pair: means(pair, "main_pressure", KPA)),
        arrow("fluid", "temperature", 0, lambda pair: means(pair, "atf_temperature", 1.0)),
    )
    return Table("logs", shown, logs.pairs, say)


def _mean(part: RoadTest | None, quantity: str, factor: float) -> float | None:
    values = None if part is None else part.values(quantity)
    if values is None or not np.isfinite(values).any():
        return None
    return float(np.nanmean(values)) * factor


def comparison_sections(
    comparison: Comparison, say: Wording, *, brief: bool = False, drawn: int | None = None
) -> list[Section]:
    """Return the sections of a comparison in a reader's words: what it comes to, lands, totals, and events of the logs.

    Parameters
    ----------
    brief
        whether it is as short as a terminal needs it: without notes, and without tables of all lands and pressures.
    drawn
        most lands in the first table and its chart, where not all are wanted.
    """
    said = [changed_sentence(comparison, say), total_sentence(comparison, say), *visit_caveats(comparison, say)]
    verdicts = Text(verdicts_sentence(comparison, say), level=shown_verdict(comparison.after))
    head = [verdicts, *map(Text, filter(None, said))]
    title = f"{say.name(comparison.after.controller.name)} · {say('comparison.title')}"
    named = {
        "lands": _lands(comparison, say, drawn),
        "totals": _totals(comparison, say),
        "logs": _logs(comparison, say),
    }
    sections = [Section("comparison", title, head, level=1)]
    for name, parts in {**named, "logs": _logs(comparison, say)}.items():
        sections.append(Section(name, say(f"compare.{name}"), [*_briefly(parts)] if brief else [*parts]))
    return sections


def _briefly(parts: Iterable[SectionPart]) -> Iterator[SectionPart]:
    """Yield what a terminal has room for: no notes, no table in full, of a land neither wear, share nor decision."""
    for part in parts:
        if isinstance(part, Table) and not part.title:
            yield part.without(*(f"{key}_{side}" for key in ("wear", "share", "decision") for side in SIDES))
        elif isinstance(part, Text) and not part.small:
            yield part


def _lands(comparison: Comparison, say: Wording, drawn: int | None) -> Iterator[SectionPart]:
    """Yield the lands that are or were flagged, or changed."""
    shown = [*comparison.flagged, *(land for land in comparison.changed if not land.flagged)][:drawn]
    if shown:
        yield land_table(comparison, shown, say)
        yield Text(say("compare.lands_note"), small=True)
        names = [_land_name(comparison, land, say) for land in shown]
        chart, note = clearance_chart(shown, names, say), say("compare.clearances_note")
        yield Picture("clearances", chart, say("compare.lands"), note)
    else:
        yield Text(say("compare.no_land"))
    title = say("compare.all_lands", count=len(comparison.lands))
    yield replace(land_table(comparison, comparison.lands, say), title=title)


def _totals(comparison: Comparison, say: Wording) -> Iterator[SectionPart]:
    """Yield totals, and the pressures that changed."""
    brief = compared_condition_table(comparison, say, brief=True)
    if not brief.rows:
        yield Text(say("compare.no_condition"))
        return
    yield brief
    yield Text(say("compare.totals_note"), small=True)
    yield from total_picture(comparison, comparison.on_both_sides, say)
    yield replace(compared_condition_table(comparison, say), title=say("compare.every_pressure"))


def _logs(comparison: Comparison, say: Wording) -> Iterator[SectionPart]:
    """Yield the events of both road tests side by side, or say which test is missing."""
    if comparison.logs is None:
        missing = [side for side in SIDES if getattr(comparison, side).log is None]
        yield Text(say(f"compare.no_log_{'either' if len(missing) > 1 else missing[0]}"))
        return
    if not comparison.logs.matched:
        yield Text(say("compare.no_event"))
    if comparison.logs.pairs:
        yield compared_event_table(comparison.logs, say)


def total_picture(comparison: Comparison, conditions: Sequence[ConditionComparison], say: Wording) -> Iterator[Picture]:
    """Yield the chart of totals before and after at some conditions; none where no total can be compared."""
    shown = [(each, each.share) for each in conditions if each.before and each.alike and each.share]
    if not shown:
        return
    said = (
        say(
            "comparison.chart_condition",
            condition=say.condition(each.projection.condition),
            before=say.percent(share.before),
            after=say.percent(share.after),
        )
        for each, share in shown
    )
    drawn = total_chart(comparison, [each for each, _ in shown], say)
    alt = say("comparison.chart_alt", conditions=" ".join(said))
    yield Picture("totals", drawn, alt, say("comparison.caption"))
