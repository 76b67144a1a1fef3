"""Gather the pressures of a unit at one condition: what the line and every circuit hold, now, new and once repaired."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from atleak.analysis.repair.totals import Total
from atleak.catalogue.circuits import Circuit, PermissiblePressure
from atleak.catalogue.limits import Level, RuleKind
from atleak.catalogue.repairs import LandKey
from atleak.common.verdicts import Verdict
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.rules import Rule, permissible_low
from atleak.diagnosis.uncertainty import RuleDecision
from atleak.diagnosis.uncertainty.draws import Interval
from atleak.engine.operation import LINE
from atleak.engine.projection import CircuitState, Projection


@dataclass(frozen=True)
class HeldPressure:
    """The pressure of the line or of one circuit at one condition [Pa]."""

    circuit: Circuit | None  # None: the line
    now: float
    interval: Interval | None  # None where nothing was measured
    new: float  # of the same unit as it may have been when new, which it is judged against
    repaired: float | None  # with repairs made; None where none is asked for
    set_pressure: float | None  # of the circuit's regulator; what is required of the line
    vented: bool  # not applied in this gear
    rule: Rule | None  # that judges it; None where no such limit is set, and of a vented circuit
    decided: RuleDecision | None
    verdict: Verdict | None  # ``not_measured`` where nothing was measured and no limit is passed
    causes: Mapping[LandKey, float]  # [Pa] that it would gain with one of these lands new
    permissible: PermissiblePressure | None = None  # of the line
    low: float | None = None  # [Pa] the least permissible pressure by which the line is judged

    @property
    def id(self) -> str:
        """Return the name that the valve body's file has for it."""
        return LINE if self.circuit is None else self.circuit.id

    @property
    def loss(self) -> float:
        """Return what it holds less than when new [Pa]; negative where it holds more."""
        return self.new - self.now

    @property
    def limits(self) -> tuple[tuple[Level, float], ...]:
        """Return the pressures [Pa] under which a level is reached, the mildest first; none where nothing is judged."""
        if self.rule is None:
            return ()
        if self.rule.kind is RuleKind.CIRCUIT_LOSS:
            return tuple((level, max(self.new - limit, 0.0)) for level, limit in self.rule.steps.levels)
        low = self.low if self.low is not None else 0.0
        return tuple((level, low * (1.0 - limit)) for level, limit in self.rule.steps.levels)

    @property
    def costly(self) -> tuple[tuple[LandKey, float], ...]:
        """Return the lands that cost it most of what it lost, or raise it most where it rose, the worst first [Pa]."""
        same = {key: loss for key, loss in self.causes.items() if loss * self.loss > 0.0}
        return tuple((key, same[key]) for key in _worth_a_look({key: abs(same[key]) for key in same}, abs(self.loss)))


_WORTH_A_LOOK = 0.1  # part of a loss, or of a leakage more than new, that one land is behind: choice of this project


def _worth_a_look(parts: Mapping[LandKey, float], whole: float) -> tuple[LandKey, ...]:
    """Return the lands behind most of a loss, the first of them always, the largest part first."""
    largest_first = sorted((key for key in parts if parts[key] > 0.0), key=lambda key: -parts[key])
    return tuple(key for place, key in enumerate(largest_first) if not place or parts[key] >= _WORTH_A_LOOK * whole)


@dataclass(frozen=True)
class PressuresAt:
    """The pump's reserve and every pressure at one condition."""

    projection: Projection
    solved: bool  # else pressures are taken as given
    line: HeldPressure
    circuits: tuple[HeldPressure, ...]  # in the order of the controller's file
    followed: HeldPressure | None  # the circuit that the line's set pressure follows
    reserve_interval: Interval | None
    reserve_new: float
    reserve_repaired: float | None  # with repairs made
    reserve_rule: Rule | None
    reserve_decided: RuleDecision | None
    reserve_verdict: Verdict | None

    @property
    def applied(self) -> tuple[HeldPressure, ...]:
        """Return the line and the circuits that are applied in this gear."""
        return (self.line, *(each for each in self.circuits if not each.vented))

    @property
    def rules(self) -> tuple[Rule, ...]:
        """Return every rule that judged a pressure or the reserve here."""
        every = (self.reserve_rule, *(each.rule for each in self.applied))
        return tuple(rule for rule in every if rule is not None)


def pressures_at(diagnosis: Diagnosis, projection: Projection, repaired: Sequence[Total] = ()) -> PressuresAt:
    """Gather reserve and pressures at one condition of a diagnosis; with its totals after repairs also those."""
    total = diagnosis.uncertainty.total(projection.condition.name) if diagnosis.uncertainty else None
    new, losses = diagnosis.unworn_at(projection), diagnosis.losses_at(projection)
    end = next((each for each in repaired if each.condition == projection.condition), None)
    after: Mapping[str, float] = {} if end is None else end.pressures
    reserve, permissible = (
        diagnosis.pressure_rule(projection, kind) for kind in (RuleKind.RESERVE, RuleKind.PERMISSIBLE_PRESSURE)
    )

    def held(rule: Rule | None, **values: Any) -> HeldPressure:
        decided = None if rule is None else diagnosis.decided(rule)
        return HeldPressure(rule=rule, decided=decided, verdict=diagnosis.verdict_on(rule), **values)

    def circuit(state: CircuitState) -> HeldPressure:
        circuit = state.circuit
        rule = diagnosis.pressure_rule(projection, RuleKind.CIRCUIT_LOSS, circuit)
        return held(
            rule,
            circuit=circuit,
            now=state.pressure,
            interval=total.circuit_intervals.get(circuit.id) if total else None,
            new=new.circuit(circuit.id).pressure,
            repaired=after.get(circuit.id),
            set_pressure=state.set_pressure,
            vented=state.vented,
            causes={} if rule in diagnosis.pump.lacking else losses.get(circuit.id, {}),
        )

    line = held(
        permissible,
        circuit=None,
        now=projection.main_pressure_held,
        interval=total.main_pressure_interval if total else None,
        new=new.main_pressure_held,
        repaired=after.get(LINE),
        set_pressure=projection.condition.main_pressure,
        vented=False,
        permissible=projection.permissible,
        low=permissible_low(projection),
        causes={} if any(each in diagnosis.pump.lacking for each in (permissible, reserve)) else losses.get(LINE, {}),
    )
    circuits = tuple(circuit(state) for state in projection.circuits)
    stated = diagnosis.controller.line
    follows = stated.following.section if stated is not None and stated.following is not None else None
    return PressuresAt(
        projection=projection,
        solved=diagnosis.profile.circuits == "on",
        line=line,
        circuits=circuits,
        followed=next((each for each in circuits if each.id == follows), None),
        reserve_interval=total.reserve_interval if total else None,
        reserve_new=new.reserve,
        reserve_repaired=None if end is None else end.reserve,
        reserve_rule=reserve,
        reserve_decided=diagnosis.decided(reserve) if reserve else None,
        reserve_verdict=diagnosis.verdict_on(reserve),
    )


def drawing_more(diagnosis: Diagnosis, projection: Projection) -> tuple[LandKey, ...]:
    """Return the lands that draw most of what the unit draws more than when new, the most first."""
    new = diagnosis.new_at(projection)
    more = {land.key: projection.drawn_by(land.key) - new.drawn_by(land.key) for land in diagnosis.lands}
    return _worth_a_look(more, projection.leakage - new.leakage)


def behind_limits(diagnosis: Diagnosis) -> frozenset[LandKey]:
    """Return the lands past a limit, and those behind a total, a reserve or a pressure that is."""
    keys = {land.key for land in diagnosis.flagged}
    for projection in diagnosis.projections if diagnosis.judged else ():
        at = pressures_at(diagnosis, projection)
        past = [each for each in at.applied if each.verdict is not None and each.verdict.flagged]
        keys |= {key for each in past for key, _ in each.costly}
        shared = (diagnosis.total_rule(projection), at.reserve_rule)
        if any(rule is not None and rule.verdict.flagged for rule in shared):
            keys |= {*drawing_more(diagnosis, projection)}
    return frozenset(keys)


def worst_pressure(diagnosis: Diagnosis) -> Rule | None:
    """Return the worst rule of a reserve or pressure past a limit; None where none is, or nothing was measured."""
    past = [rule for rule in diagnosis.pressure_rules if rule.verdict.flagged and rule.condition is not None]
    return max(past, key=_badness, default=None) if diagnosis.judged else None


def _badness(rule: Rule) -> tuple[float, float]:
    return rule.verdict.rank, rule.severity


def lowest_first(diagnosis: Diagnosis) -> tuple[Projection, ...]:
    """Return the conditions with that first at which a pressure or the reserve is judged worst.

    Of several that are judged alike the one that is farthest past its limit, or nearest to it, comes first.
    """

    def badness(projection: Projection) -> tuple[float, float]:
        return max(map(_badness, diagnosis.pressure_rules_at(projection)), default=(-1.0, 0.0))

    return tuple(sorted(diagnosis.presented, key=badness, reverse=True))
