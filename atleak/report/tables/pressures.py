"""Say what a unit's pump and circuits hold: sections on all conditions and on one of them, their tables and chart."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from atleak.analysis.pressures import HeldPressure, PressuresAt
from atleak.catalogue.limits import Level
from atleak.common.style import AS_NEW, LEAST, MOST, NOT_JUDGED, REPAIRED, STATED_INKS, Look, look_of
from atleak.common.units import DM3_MIN, KPA, RPM
from atleak.common.verdicts import Verdict
from atleak.common.wording import Wording, isolated
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.uncertainty import RuleDecision
from atleak.diagnosis.uncertainty.draws import Interval
from atleak.report.charts.chart import LayerOf, RowChart, layers_of
from atleak.report.json.conditions import finite
from atleak.report.tables.first_sentence import pump_sentence
from atleak.report.tables.gauges import permissible_text
from atleak.report.tables.section import Picture, Section, SectionPart, Text
from atleak.report.tables.sentences import (
    circuit_sentence,
    decision_words,
    full_stroke,
    land_in_words,
    permissible_words,
    pressure_sentence,
    reserve_sentence,
    unsolved,
)
from atleak.report.tables.table import VERDICT, Column, Table, VerdictOrBand


def condition_table(conditions: Sequence[PressuresAt], say: Wording) -> Table:
    """Return a row for every condition: what the line holds there, and the pump's reserve."""

    def worst(at: PressuresAt) -> Verdict | None:
        verdicts = (at.reserve_verdict, *(held.verdict for held in at.applied))
        return max((each for each in verdicts if each is not None), key=lambda each: each.rank, default=None)

    def level(at: PressuresAt) -> VerdictOrBand | None:
        rule, verdict = at.reserve_rule, at.reserve_verdict
        return rule.level if rule is not None and verdict == rule.verdict else verdict

    def within(at: PressuresAt) -> str | None:
        return at.reserve_interval and "–".join(say.number(end, 2) for end in at.reserve_interval)

    columns = (
        Column("verdict", VERDICT, width=92, of=worst),
        Column("condition", width=190, of=lambda at: say.condition(at.projection.condition)),
        Column("required", "pressure", of=lambda at: at.projection.condition.main_pressure, times=KPA),
        Column("held", "pressure", of=lambda at: at.line.now, times=KPA),
        Column("held_repaired", "pressure", of=lambda at: at.line.repaired, times=KPA),
        Column("reserve", digits=2, of=lambda at: finite(at.projection.reserve)),
        Column("reserve_is", VERDICT, of=level),
        Column("covered_from", "engine_speed", of=lambda at: at.projection.minimum_speed, times=RPM),
        Column("permissible", of=lambda at: permissible_words(at.line, say) or None),
        Column("held_new", "pressure", of=lambda at: at.line.new, times=KPA),
        Column("held_low", "pressure", of=lambda at: _end(at.line.interval, 0), times=KPA),
        Column("held_high", "pressure", of=lambda at: _end(at.line.interval, 1), times=KPA),
        Column("reserve_within", of=within),
        Column("reserve_decision", width=50, of=lambda at: _decided(at.reserve_decided, say)),
        Column("reserve_new", digits=2, of=lambda at: finite(at.reserve_new)),
        Column("reserve_repaired", digits=2),
        Column("pump_supply", "flow", of=lambda at: at.projection.pump_supply, times=DM3_MIN),
        Column("leakage", "flow", of=lambda at: at.projection.leakage, times=DM3_MIN),
        Column("slip", "flow", of=lambda at: at.projection.slip, times=DM3_MIN),
        Column("consumers", "flow", of=lambda at: at.projection.consumers, times=DM3_MIN),
        Column("starved", "flow", of=lambda at: at.projection.starved, times=DM3_MIN),
    )
    return Table("pressures", columns, conditions, say)


def held_table(diagnosis: Diagnosis, conditions: Sequence[PressuresAt], say: Wording) -> Table:
    """Return a row for the line and every circuit that is applied, at each of some conditions."""
    where = {id(held): at.projection.condition for at in conditions for held in at.applied}

    def costly(held: HeldPressure) -> str | None:
        costs = (
            f"{land_in_words(diagnosis, key, say)}: {say.quantity(loss * KPA, 'pressure')}" for key, loss in held.costly
        )
        return "; ".join(costs) or None

    columns = (
        Column("verdict", VERDICT, width=92),
        Column("circuit", width=170, of=lambda each: say.name(each.circuit.name) if each.circuit else say("held.line")),
        Column("held", "pressure", of="now", times=KPA),
        Column("held_new", "pressure", of="new", times=KPA),
        Column("lost", "pressure", 1, of="loss", times=KPA),
        Column("lands_that_cost", width=300, of=costly),
        Column("held_repaired", "pressure", of="repaired", times=KPA),
        Column("set_pressure", "pressure", times=KPA),
        Column("permissible", words_of="pressure", of=lambda each: permissible_text(each.permissible, say)),
        Column("held_low", "pressure", of=lambda each: _end(each.interval, 0), times=KPA),
        Column("held_high", "pressure", of=lambda each: _end(each.interval, 1), times=KPA),
        Column("decision", width=100, of=lambda each: _decided(each.decided, say)),
    )
    rows = [held for at in conditions for held in at.applied]
    return Table("circuits", columns, rows, say, group=lambda held: say.condition(where[id(held)]))


def _decided(decided: RuleDecision | None, say: Wording) -> str | None:
    return None if decided is None else decision_words(decided.decision, decided.probability_over_limit, say)


def _end(interval: Interval | None, end: int) -> float | None:
    return None if interval is None else interval[end]


def conditions_section(diagnosis: Diagnosis, conditions: Sequence[PressuresAt], say: Wording) -> Section:
    """Return what the line holds at some conditions and the pump's reserve, or why that is not known."""
    said = filter(None, (unsolved(diagnosis, say), pump_sentence(diagnosis, say)))
    note = " ".join(filter(None, (say("circuits.conditions"), full_stroke(diagnosis, say))))
    parts: list[SectionPart] = [*map(Text, said), condition_table(conditions, say), Text(note, small=True)]
    return Section("pressures", say("diagnosis.pressures"), parts)


def held_section(diagnosis: Diagnosis, at: PressuresAt, say: Wording) -> Section:
    """Return what the line and every circuit hold at one condition."""
    name = say.condition(at.projection.condition)
    words = pressure_sentence(at, say), reserve_sentence(at, say)
    alt = ". ".join(circuit_sentence(diagnosis, each, say) for each in at.applied)
    parts: list[SectionPart] = [*map(Text, words), Picture("circuits", pressure_chart(at, say), alt)]
    if at.circuits:
        vented = ", ".join(say.name(each.circuit.name) for each in at.circuits if each.vented and each.circuit)
        empty = say("circuits.vented", circuits=vented) if vented else ""
        parts += [held_table(diagnosis, [at], say), Text(f"{say('circuits.lost')} {empty}".rstrip(), small=True)]
    return Section("circuits", name, parts)


def pressure_chart(at: PressuresAt, say: Wording) -> RowChart:
    """Return what the line and every applied circuit hold: new, now with its interval, and with the planned repairs.

    Marks are the limits that apply: where a loss is judged worse, what a regulator is set to, and the permissible
    main pressure.
    """
    held, scale, unit = at.applied, say.convert(KPA, "pressure"), say.unit("pressure")
    names = [say("held.line") if each.circuit is None else isolated(say.name(each.circuit.name)) for each in held]

    def layer(
        name: str, look: Look, of: Callable[[HeldPressure], float | None], lift: float | None = None, **more: Any
    ) -> LayerOf:
        values = [None if (value := of(each)) is None or value <= 0.0 else value * scale for each in held]
        shown = [say.number(value, say.digits("pressure", 0)) for value in values]
        hover = [f"{row}: {value} {unit} {name}" for row, value in zip(names, shown, strict=True)]
        bar = {} if lift is None else {"thick": 0.24, "lift": lift}
        return name, look, values, {"hover": hover, **bar, **more}

    def now(verdict: Verdict | None) -> LayerOf:
        name = say("figures.now") if verdict is None else f"{say('figures.now')}: {say.signed(verdict)}"
        look = NOT_JUDGED if verdict is None else look_of(verdict)
        spans = [each.interval and (each.interval[0] * scale, each.interval[1] * scale) for each in held]
        return layer(name, look, lambda each: each.now if each.verdict is verdict else None, 0.0, spans=spans)

    def limit(level: Level) -> LayerOf:
        name = say("figures.from_here_down", level=say.signed(level))
        return layer(name, look_of(level), lambda each: dict(each.limits).get(level) if each.circuit else None)

    def permitted(end: str) -> Callable[[HeldPressure], float | None]:
        return lambda each: None if each.permissible is None else getattr(each.permissible, end)

    layers = layers_of(
        (
            layer(say("figures.new"), AS_NEW, lambda each: each.new, 0.26),
            *map(now, (*Verdict, None)),
            layer(say("figures.after_repair"), REPAIRED, lambda each: each.repaired, -0.26),
            *map(limit, dict.fromkeys(level for each in held for level, _ in each.limits)),
            layer(say("figures.set_or_required"), STATED_INKS, lambda each: each.set_pressure),
            layer(say("figures.permissible"), LEAST, permitted("low")),
            layer(say("figures.permissible"), MOST, permitted("high")),
        )
    )
    said = [say.value(each.now * KPA, "pressure", 0) for each in held]
    said = [
        words if each.verdict is None else f"{words} {say.level(each.verdict)}"
        for words, each in zip(said, held, strict=True)
    ]
    return RowChart(names, layers, f"{say('figures.pressure')} [{unit}]", said)
