"""Say what a unit's pump and circuits hold: sections on all conditions and on one of them, their tables and chart.

Over engine speed, what the pump supplies is compared with what is taken from it, at several temperatures.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from atleak.analysis.pressures import HeldPressure, PressuresAt
from atleak.catalogue.limits import Level
from atleak.common.style import AS_NEW, LEAST, MOST, NOT_JUDGED, REPAIRED, STATED_INKS, Look, look_of
from atleak.common.units import DM3_MIN, KPA, RPM
from atleak.common.verdicts import Verdict
from atleak.common.wording import Wording, isolated
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.uncertainty import RuleDecision
from atleak.diagnosis.uncertainty.draws import Interval
from atleak.engine.projection import Projection, project
from atleak.report.charts.chart import LayerOf, RowChart, layers_of
from atleak.report.json.conditions import finite
from atleak.report.tables.first_sentence import pump_sentence
from atleak.report.tables.gauges import permissible_text
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
from atleak.report.tables.table import VERDICT, Column, Picture, Section, SectionPart, Table, Text, VerdictOrBand

_FEWEST = 4  # temperatures that are drawn, where there are two to draw between: choice of this project
_POINTS = 61  # of the speeds
_BEYOND = 1.25  # part of the speeds that is drawn beyond the last one that matters


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
        Column("decision", width=150, of=lambda each: _decided(each.decided, say)),
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


@dataclass(frozen=True)
class Demand:
    """What is taken from the pump at one temperature, at the pressure that a condition requires."""

    temperature: float  # [°C]
    leakage: float  # [m³/s]
    slip: float  # [m³/s]
    consumers: float  # [m³/s]
    crossing: float  # [1/s] the lowest engine speed at which the pump supplies as much
    of_condition: bool  # it is the temperature of the condition

    @property
    def flow(self) -> float:
        """Return leakage, slip and consumers together [m³/s]."""
        return self.leakage + self.slip + self.consumers


@dataclass(frozen=True)
class PumpOverSpeed:
    """The pump's supply over engine speed against the demand at each temperature, for one condition."""

    projection: Projection
    speeds: np.ndarray  # [1/s], shape (n,)
    supply: np.ndarray  # [m³/s] before slip, shape (n,)
    demands: tuple[Demand, ...]  # in the order of their temperatures
    marked: tuple[tuple[str, float], ...]  # label and engine speed [1/s]: of the condition, and of idle
    interval: tuple[float, float] | None  # [1/s] of the crossing at the condition's temperature

    @property
    def demand(self) -> Demand:
        """Return that at the condition's temperature."""
        return next(each for each in self.demands if each.of_condition)


def pump_over_speed(diagnosis: Diagnosis, projection: Projection, say: Wording) -> PumpOverSpeed:
    """Compute the pump's supply over engine speed, and what is taken from it at the temperatures of all conditions.

    Gear, required pressure and consumers are those of the condition; leakage and slip follow the temperature. Slip is
    counted with what is taken, so that supply over demand at any speed is the reserve there.

    Raises
    ------
    DomainError
        temperature outside the fluid's data.
    """
    condition, model = projection.condition, diagnosis.model
    demands = []
    for temperature in _temperatures([each.condition.temperature for each in diagnosis.projections]):
        own = temperature == condition.temperature
        at = projection if own else project(model, replace(condition, temperature=temperature))
        demands.append(Demand(temperature, at.leakage, at.slip, at.consumers, at.minimum_speed, own))
    idle = diagnosis.hot_idle
    marked = [(say.condition(condition), condition.engine_speed)]
    if idle is not None and idle.condition.engine_speed != condition.engine_speed:
        marked.append((say.condition(idle.condition), idle.condition.engine_speed))
    last = max(each.crossing for each in demands if np.isfinite(each.crossing)) if demands else 0.0
    speeds = np.linspace(0.0, _BEYOND * max(last, *(speed for _, speed in marked)), _POINTS)
    total = diagnosis.uncertainty.total(condition.name) if diagnosis.uncertainty else None
    return PumpOverSpeed(
        projection=projection,
        speeds=speeds,
        supply=np.asarray(model.pump.per_revolution * speeds, dtype=float),
        demands=tuple(demands),
        marked=tuple(marked),
        interval=total.minimum_speed_interval if total else None,
    )


def _temperatures(stated: Sequence[float]) -> list[float]:
    """Return the temperatures of the conditions, and a few between them [°C].

    >>> _temperatures([80.0, 100.0, 80.0])
    [80.0, 87.0, 93.0, 100.0]
    """
    known = sorted(set(stated))
    missing = _FEWEST - len(known)
    if len(known) < 2 or missing <= 0:
        return known
    between = np.linspace(known[0], known[-1], missing + 2)[1:-1].round()
    return sorted({*known, *(float(each) for each in between)})
