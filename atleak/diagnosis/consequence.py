"""Say what a land's wear does now, and what it will do before the next service, beside its verdict by clearance.

Nominal values decide, judged as sure as the unit is: a rule's likely value is as far from its value as it was measured.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import TYPE_CHECKING, Any

import numpy as np

from atleak.catalogue.limits import RuleKind, falls_below, reaches
from atleak.catalogue.repairs import LandKey
from atleak.common.verdicts import Band, Verdict
from atleak.diagnosis.land import SERVICE_INTERVAL, LandDiagnosis, WearLine
from atleak.diagnosis.rules import Rule, permissible_low
from atleak.engine.operation import LINE, LandStates, Repaired
from atleak.engine.projection import Projection, with_wear
from atleak.equations.statistics import normal_quantile

if TYPE_CHECKING:
    from atleak.diagnosis.diagnosis import Diagnosis


class Consequence(StrEnum):
    """What a land's wear does to its unit; the most urgent last."""

    NONE = "none"  # computed: no rule of the unit is past a limit because of it
    UNKNOWN = "unknown"  # not fully measured, or it leaks at no condition, or nobody described where
    BEFORE_NEXT_SERVICE = "before_next_service"  # a rule will be, as its wear line has it
    NOW = "now"  # a pressure, reserve or total is past a limit because of it

    @property
    def rank(self) -> int:
        """Place in the order of urgency; the most urgent has the highest."""
        return _RANKS[self]


_RANKS = {consequence: rank for rank, consequence in enumerate(Consequence)}


@dataclass(frozen=True)
class JudgedTotal:
    """One rule of the unit at one condition, to be judged again after repairs."""

    rule: Rule  # of the unit as measured, whose limits hold after a repair too
    projection: Projection  # as measured
    likely: float = 1.0  # the likely value over the value, where the two have reached different levels

    @classmethod
    def of(cls, diagnosis: Diagnosis, rule: Rule, projection: Projection) -> JudgedTotal:
        """Return a rule with how far its likely value is from its value: a repaired unit is no surer than before."""
        decided = diagnosis.decided(rule)
        passes, sign = (falls_below, -1.0) if rule.steps.falling else (reaches, 1.0)
        levels = () if decided is None else zip(decided.levels, decided.level_uncertainties, strict=True)
        apart = [
            level.limit + sign * float(normal_quantile(min(max(level.probability_over, 0.001), 0.999))) * u
            for level, u in levels
            if (level.probability_over >= 0.5) != passes(rule.value, level.limit) and math.isfinite(u)
        ]
        return cls(rule, projection, apart[-1] / rule.value if apart and 0.0 < rule.value < math.inf else 1.0)

    @classmethod
    def all_at(cls, diagnosis: Diagnosis, projection: Projection) -> tuple[JudgedTotal, ...]:
        """Return every rule of the unit at a condition, that of the total first."""
        rules = diagnosis.total_rule(projection), *diagnosis.pressure_rules_at(projection)
        return tuple(cls.of(diagnosis, rule, projection) for rule in rules)

    def value(self, leakage: Any, pressures: Mapping[str, Any]) -> Any:
        """Return the rule's value from the leakage [m³/s] and the pressures held [Pa]; numbers or arrays."""
        rule, at = self.rule, self.projection
        if rule.kind is RuleKind.TOTAL_SHARE:
            nothing = np.where(np.asarray(leakage) > 0.0, math.inf, 0.0)
            return leakage / at.pump_capacity if at.pump_capacity > 0.0 else nothing
        if rule.kind is RuleKind.RESERVE:
            demand = np.asarray(leakage + at.slip + at.consumers, float)
            return np.divide(at.pump_supply, demand, out=np.full(demand.shape, math.inf), where=demand > 0.0)
        if rule.circuit is not None:
            return abs((rule.new or 0.0) - pressures[rule.circuit.id])
        low = permissible_low(at)
        return 1.0 - pressures[LINE] / low if low else rule.value + 0.0 * pressures[LINE]

    def after(self, leakage: float, pressures: Mapping[str, float], *, repaired: bool) -> Rule:
        """Return the rule with the value that it has then, of a repaired unit at the level of the likely value."""
        value = float(self.value(leakage, pressures))
        if not repaired:
            return replace(self.rule, value=value)
        passes = falls_below if self.rule.steps.falling else reaches
        past = tuple(float(passes(value * self.likely, limit)) for _, limit in self.rule.steps.levels)
        return replace(self.rule, value=value, reached=past if self.likely != 1.0 else None)

    def limit(self, worst: Verdict) -> float | None:
        """Return the limit that the value must keep to be no worse than a verdict; None where there is none."""
        steps = self.rule.steps
        worse = [
            limit
            for level, limit in steps.levels
            if (level.verdict if isinstance(level, Band) else level).rank > worst.rank
        ]
        if not worse:
            return None
        return (max(worse) if steps.falling else min(worse)) / self.likely

    def ranks(self, done: Repaired, *, as_measured: bool) -> list[int]:
        """Return the rank of the rule's verdict for several choices; the first is the unit as measured where it is."""
        rules = (
            self.after(
                float(leakage),
                {name: float(pressure[number]) for name, pressure in done.pressures.items()},
                repaired=bool(number) or not as_measured,
            )
            for number, leakage in enumerate(done.leakage)
        )
        return [rule.verdict.rank for rule in rules]


def consequences(
    diagnosis: Diagnosis,
    responsible: Collection[LandKey] = (),
) -> Mapping[LandKey, Consequence]:
    """Return the consequence of every land's wear, in the controller's order; unknown of a unit that cannot be right.

    A pump past its limits is repaired first and counts as new. By the next service every land with a line has worn as
    that says, and lands with a consequence now are mended.

    Parameters
    ----------
    responsible
        lands found responsible for a pressure that gauges or a log measured past its limit.
    """
    if diagnosis.impossible:
        return {land.key: Consequence.UNKNOWN for land in diagnosis.lands}
    unit = diagnosis.valve_body
    grown = [
        land for land in unit.lands if land.state.judged and land.state.radial_clearance > land.state.land.widest_new
    ]
    now = {*responsible, *_behind_now(unit, grown)}
    before = _behind_at_service(unit, now, diagnosis.mileage, diagnosis.wear_lines)

    def consequence(land: LandDiagnosis) -> Consequence:
        key = land.key
        leaks = any(each.gaps_of(key) for each in unit.projections)
        if key in now:
            return Consequence.NOW
        if not land.state.can_be_ok or not leaks or key in unit.controller.gaps_not_described:
            return Consequence.UNKNOWN
        return Consequence.BEFORE_NEXT_SERVICE if key in before else Consequence.NONE

    return {land.key: consequence(land) for land in diagnosis.lands}


def _behind_now(unit: Diagnosis, grown: Sequence[LandDiagnosis]) -> Iterable[LandKey]:
    """Yield the lands behind what is past a limit as measured."""
    surely = {land.key for land in grown if land.verdict.flagged or _significant(land)}
    worn = [land.key for land in grown]
    for projection in unit.projections if worn else ():
        past = [each for each in JudgedTotal.all_at(unit, projection) if each.rule.verdict.flagged]
        if past:
            at = LandStates.of((unit.model, unit.as_new), projection.condition)
            yield from _behind(at, past, worn, surely, as_measured=True)


def _significant(land: LandDiagnosis) -> bool:
    """Tell whether a land is wider than new by more than measuring, and what is known of new ones, can be off."""
    known = land.uncertainty.wear_interval if land.uncertainty else None
    return known is not None and known[0] > 0.0


def _behind_at_service(
    unit: Diagnosis, now: Collection[LandKey], mileage: float | None, lines: Mapping[LandKey, WearLine]
) -> set[LandKey]:
    """Return the lands behind what is past a limit at the next service, those with a consequence now mended."""
    wearing = {key: line for key, line in lines.items() if line.certain and key not in now}
    if mileage is None or not wearing:
        return set()
    clearances: list[Any] = []
    for state, new in zip((land.state for land in unit.lands), unit.as_new.clearances, strict=True):
        line = wearing.get(state.land.key)
        wider = 0.0 if line is None else line.at(mileage + SERVICE_INTERVAL) / state.radial_clearance - 1.0
        clearances += [new] if state.land.key in now else with_wear([state], max(wider, 0.0))
    worn = replace(unit.model, clearances=tuple(clearances))
    found: set[LandKey] = set()
    for projection in unit.projections:
        at = LandStates.of((worn, unit.as_new), projection.condition)
        found |= _behind(at, JudgedTotal.all_at(unit, projection), [*wearing], wearing, as_measured=False)
    return found


def _behind(
    at: LandStates,
    rules: Iterable[JudgedTotal],
    worn: Sequence[LandKey],
    surely: Collection[LandKey],
    *,
    as_measured: bool,
) -> set[LandKey]:
    """Return the worn lands without whose wear a rule past a limit would be at a milder level.

    Each that lowers the level alone, where it has ``surely`` worn; and where the level that all of them new would bring
    takes several, the fewest that do, in the order of what each costs the rule, those that surely have worn first.
    """
    alone = at.repaired([{}, *({key: 1} for key in worn), dict.fromkeys(worn, 1)])
    found: set[LandKey] = set()
    together: list[tuple[JudgedTotal, int, list[LandKey]]] = []
    for rule in rules:
        now, *singles, best = rule.ranks(alone, as_measured=as_measured)
        if now <= Verdict.OK.rank:
            continue
        by_land = {key: rank for key, rank in zip(worn, singles, strict=True) if key in surely}
        found |= {key for key, rank in by_land.items() if rank < now}
        if best < min([now, *by_land.values()]):
            value = np.broadcast_to(rule.value(alone.leakage, alone.pressures), alone.leakage.shape)
            more = value[0] - value[1:-1]
            costs = dict(zip(worn, -more if rule.rule.steps.falling else more, strict=True))
            together.append((rule, best, sorted(worn, key=lambda key: (key not in surely, -costs[key]))))
    if together:
        sets = [order[:count] for _, _, order in together for count in range(1, len(worn) + 1)]
        done = at.repaired([dict.fromkeys(each, 1) for each in sets])
        for number, (rule, best, order) in enumerate(together):
            ranks = rule.ranks(done, as_measured=False)[number * len(worn) :][: len(worn)]
            fewest = next((count for count, rank in enumerate(ranks, 1) if rank <= best), len(order))
            found |= {*order[:fewest]}
    return found
