"""Limits → verdicts: which pairs, by which rule, what they cost the pump, and what to repair first."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from atleak.controller import HOT_IDLE, Controller, OperatingPoint
from atleak.errors import Message
from atleak.fluid import Fluid
from atleak.instruments import Instruments
from atleak.leakage import LeakageModel
from atleak.limits import VERDICTS, Band, Limits, Steps, Verdict, worst
from atleak.profile import WORKSHOP, Profile
from atleak.projection import Projection, mileage_at_wear, project, repaired
from atleak.readings import LandClearance, Readings, clearances
from atleak.road_leakage import RoadLeakage, evaluate_road_test
from atleak.road_test import RoadTest
from atleak.uncertainty import (
    DEFAULTS,
    GUARD_FACTOR,
    Assumptions,
    Decision,
    LandUncertainty,
    RuleDecision,
    UnitUncertainty,
    assess,
)


@dataclass(frozen=True)
class RuleResult:
    """One rule applied to one land: ``value`` and ``limit`` in SI or as a fraction, ``unit`` for people.

    ``limit`` is the limit that was reached, or the first one where none was.
    """

    rule: str
    label: str
    value: float
    limit: float
    unit: str
    verdict: Verdict
    origin: str
    source: str


@dataclass(frozen=True)
class LandDiagnosis:
    """One land's state, its leakage at the stated condition, its verdict and how sure that is."""

    state: LandClearance
    wear: float | None  # (c_r − c_m)/c_m; None where not measured
    effective_clearance: float  # [m] at the stated condition
    leakage: float  # [m³/s] at the stated condition, through every gap of the land
    drawn_from_pump: float  # [m³/s] what of it counts in the total
    share: float  # leakage / pump capacity at the stated condition
    excess_share: float  # what it draws above the same land at its mounting clearance, where that costs most
    verdict: Verdict
    rules: tuple[RuleResult, ...]
    replace_mileage: (
        float | None
    )  # [km] at which the wear limit for replacing is reached, wear ∝ mileage; None in doubt or past
    uncertainty: LandUncertainty | None  # None where nothing was measured
    messages: tuple[Message, ...]

    @property
    def key(self) -> tuple[str, int]:
        return self.state.land.key

    @property
    def decision(self) -> Decision | None:
        """How sure the verdict is, about the limit of the rule that gave it; None where not measured."""
        found = self.deciding_uncertainty
        return found.decision if found and self.verdict != "not_measured" else None

    @property
    def probability_over_limit(self) -> float | None:
        """That the true value is over the limit of the rule that gave the verdict."""
        found = self.deciding_uncertainty
        return found.probability_over_limit if found and self.verdict != "not_measured" else None

    @property
    def deciding_uncertainty(self) -> RuleDecision | None:
        """The decision that belongs to the verdict."""
        return self.uncertainty.deciding if self.uncertainty else None

    @property
    def deciding(self) -> RuleResult | None:
        """The rule that gave the verdict: the worst; of several, the likeliest to be over its limit."""
        sure = self.deciding_uncertainty
        if sure is not None:
            return next(rule for rule in self.rules if rule.rule == sure.rule)
        return max(self.rules, key=lambda rule: VERDICTS.index(rule.verdict), default=None)


@dataclass(frozen=True)
class RepairStep:
    """One land brought back to its mounting clearance, after those before it."""

    land: LandDiagnosis
    condition: OperatingPoint
    share_before: float  # total, at that condition
    share_after: float


@dataclass(frozen=True)
class Diagnosis:
    """All that is known of a unit, with the inputs it follows from. Renderers compute nothing."""

    readings: Readings | None
    controller: Controller
    fluid: Fluid
    limits: Limits
    profile: Profile
    mileage: float | None  # [km]
    lands: tuple[LandDiagnosis, ...]  # in the controller's order
    projection: Projection
    hot_idle: Projection | None
    road: RoadLeakage | None
    repair_plan: tuple[RepairStep, ...]  # flagged lands in order of repair
    uncertainty: UnitUncertainty | None  # None without readings
    messages: tuple[Message, ...]

    @property
    def projections(self) -> tuple[Projection, ...]:
        """The stated condition and hot idle; one where they are the same."""
        idle = self.hot_idle
        return (self.projection,) if idle is None or idle is self.projection else (self.projection, idle)

    def band(self, projection: Projection) -> Band:
        """The band of a projection's total share."""
        return self.limits.band(projection.share)

    @property
    def flagged(self) -> tuple[LandDiagnosis, ...]:
        """Lands at watch or past it, the worst first, then the costliest."""
        return _flagged(self.lands)

    @property
    def ranked(self) -> tuple[LandDiagnosis, ...]:
        """All lands by leakage at the stated condition, the largest first."""
        return tuple(sorted(self.lands, key=lambda land: -land.leakage))

    @property
    def verdict(self) -> Verdict:
        """The worst verdict of any measured land, ``not_measured`` where none was."""
        measured = [land.verdict for land in self.lands if land.verdict != "not_measured"]
        return worst(measured) if measured else "not_measured"

    @property
    def measured(self) -> int:
        """Lands of which both parts were measured."""
        return sum(land.state.status == "measured" for land in self.lands)


def diagnose(
    controller: Controller,
    fluid: Fluid,
    limits: Limits,
    *,
    readings: Readings | None = None,
    road_test: RoadTest | None = None,
    profile: Profile = WORKSHOP,
    condition: OperatingPoint | None = None,
    mileage: float | None = None,
    instruments: Instruments | None = None,
    assumptions: Assumptions = DEFAULTS,
    guard_factor: float = GUARD_FACTOR,
) -> Diagnosis:
    """The main job: readings and a road test in, a verdict for every land out.

    Parameters
    ----------
    controller, fluid, limits
        from the catalogue or the workshop's own files.
    readings
        of the measuring sheet; without them every land is at its mounting clearance and ``not_measured``.
    road_test
        log to run the engine over.
    condition
        at which leakage is projected; the controller's first operating point unless given.
    mileage
        of the vehicle [km]; with it the mileage at which each worn land reaches its limit is projected.
    instruments, assumptions
        with which the readings were taken, and what else is uncertain; the catalogue's defaults unless given.
    guard_factor
        k of the guard band k·u around every limit; 1.645 leaves a risk of 5 %.

    Raises
    ------
    DomainError
        a condition's temperature outside the fluid's data.
    RoadTestError
        a road test without usable main pressure.
    """
    condition = condition or controller.operating_points[0]
    states = clearances(readings, controller)
    model = LeakageModel(controller, states, fluid, profile)
    new = LeakageModel(controller, repaired(states, [state.land.key for state in states]), fluid, profile)
    conditions = [condition]
    conditions += [point for point in controller.operating_points if point != condition]
    projections = [project(model, point) for point in conditions]
    when_new = [project(new, point) for point in conditions]
    idle = next((found for found in projections if found.condition.name == HOT_IDLE), None)
    road = None if road_test is None else evaluate_road_test(model, road_test, condition)
    sure = None
    if readings is not None:
        sure = assess(
            model,
            states,
            projections,
            limits,
            readings=readings,
            instruments=instruments,
            assumptions=assumptions,
            guard_factor=guard_factor,
        )
    lands = tuple(_land(state, projections, when_new, limits, mileage, sure) for state in states)
    messages = _messages(readings, controller, fluid, profile, projections, idle, road, states)
    if sure is not None:
        messages = list(dict.fromkeys([*messages, *sure.messages]))
    return Diagnosis(
        readings=readings,
        controller=controller,
        fluid=fluid,
        limits=limits,
        profile=profile,
        mileage=mileage,
        lands=lands,
        projection=projections[0],
        hot_idle=idle,
        road=road,
        repair_plan=_repair_plan(lands, projections, when_new, idle),
        uncertainty=sure,
        messages=tuple(messages),
    )


def _flagged(lands: Iterable[LandDiagnosis]) -> tuple[LandDiagnosis, ...]:
    past = [land for land in lands if land.verdict in {"watch", "replace", "critical"}]
    return tuple(sorted(past, key=lambda land: (-VERDICTS.index(land.verdict), -land.excess_share)))


def _repair_plan(
    lands: Iterable[LandDiagnosis],
    projections: list[Projection],
    when_new: list[Projection],
    idle: Projection | None,
) -> tuple[RepairStep, ...]:
    """Flagged lands in order, with the total share before and after each comes back to its mounting clearance.

    The total is that at hot idle where the controller states it: there the pump is weakest.
    """
    at = projections.index(idle) if idle is not None else 0
    now, new = projections[at], when_new[at]
    left, steps = now.leakage, []
    for land in _flagged(lands):
        before, left = left, left - (now.drawn_by(land.key) - new.drawn_by(land.key))
        steps.append(RepairStep(land, now.condition, now.share_of(before), now.share_of(left)))
    return tuple(steps)


def _land(
    state: LandClearance,
    projections: list[Projection],
    when_new: list[Projection],
    limits: Limits,
    mileage: float | None,
    sure: UnitUncertainty | None,
) -> LandDiagnosis:
    land = state.land
    stated = projections[0]
    wear = state.wear if state.measured else None
    rules = tuple(_rules(state, wear, projections, limits)) if state.measured else ()
    excess = max(
        now.share_of(now.drawn_by(land.key)) - new.share_of(new.drawn_by(land.key)) if now.pump_capacity > 0.0 else 0.0
        for now, new in zip(projections, when_new, strict=True)
    )
    leakage = stated.leakage_of(land.key)
    known = sure.land(land.key) if sure is not None and state.measured else None
    return LandDiagnosis(
        state=state,
        wear=wear,
        effective_clearance=state.effective_clearance(stated.condition.temperature),
        leakage=leakage,
        drawn_from_pump=stated.drawn_by(land.key),
        share=stated.share_of(leakage),
        excess_share=excess,
        verdict=_verdict(state, rules),
        rules=rules,
        replace_mileage=_replace_mileage(state, wear, limits, mileage, known),
        uncertainty=known,
        messages=state.messages,
    )


def _verdict(state: LandClearance, rules: Iterable[RuleResult]) -> Verdict:
    """The worst rule's; with one part at its nominal diameter a limit can be passed, but ``ok`` cannot be claimed."""
    found = worst([rule.verdict for rule in rules])
    return "not_measured" if found == "ok" and state.status != "measured" else found


def _rules(
    state: LandClearance, wear: float | None, projections: list[Projection], limits: Limits
) -> Iterable[RuleResult]:
    if limits.wear is not None and wear is not None:
        yield _apply("wear", "wear", wear, "%", limits.wear)
    own = state.land.clearance_limit
    if own is not None:
        steps = Steps((("replace", own),), "set by the workshop", "the controller's file")
        yield _apply("radial_clearance", "radial clearance", state.radial_clearance, "µm", steps)
    elif limits.clearance is not None:
        yield _apply("radial_clearance", "radial clearance", state.radial_clearance, "µm", limits.clearance)
    if limits.pair_share is not None:
        for projection in projections:
            at = projection.condition
            share = projection.share_of(projection.leakage_of(state.land.key))
            yield _apply(f"share_{at.name}", f"share of pump flow, {at.label}", share, "%", limits.pair_share)


def _apply(rule: str, label: str, value: float, unit: str, steps: Steps) -> RuleResult:
    verdict, limit = steps.judge(value, "ok")
    return RuleResult(rule, label, value, limit, unit, verdict, steps.origin, steps.source)  # type: ignore[arg-type]


def _replace_mileage(
    state: LandClearance, wear: float | None, limits: Limits, mileage: float | None, known: LandUncertainty | None
) -> float | None:
    """Only ahead of the vehicle, and where wear is past the readings' doubt: two standard uncertainties."""
    if wear is None or mileage is None or limits.wear is None:
        return None
    doubt = known.u_clearance if known is not None and known.u_clearance is not None else 0.0
    if state.radial_clearance - state.land.mounting_clearance <= 2.0 * doubt:
        return None
    reached = mileage_at_wear(mileage, wear, dict(limits.wear.levels).get("replace", limits.wear.levels[-1][1]))
    return reached if reached is not None and reached > mileage else None


def _messages(
    readings: Readings | None,
    controller: Controller,
    fluid: Fluid,
    profile: Profile,
    projections: list[Projection],
    idle: Projection | None,
    road: RoadLeakage | None,
    states: Iterable[LandClearance],
) -> list[Message]:
    found: list[Message] = []
    if controller.representative:
        found.append(Message("warning", "controller_representative", f"{controller.name}: {controller.representative}"))
    leaking = {gap.key for gap in controller.gaps}
    silent = [f"{land.component}/{land.land}" for land in controller.lands if land.key not in leaking]
    if silent:
        text = f"{controller.name} names no gap of lands {', '.join(silent)}: they are taken to leak nothing."
        found.append(Message("warning", "land_without_gap", text))
    if readings is None:
        text = "No measuring sheet: every land is computed at its mounting clearance."
        found.append(Message("warning", "no_readings", text))
    else:
        found += readings.messages
    for state in states:
        found += state.messages
    temperatures = [projection.condition.temperature for projection in projections]
    if road is not None:
        logged = road.road_test.values("atf_temperature")
        if logged is not None:
            temperatures += [float(value) for value in (np.nanmin(logged), np.nanmax(logged))]
    found += fluid.messages(min(temperatures), max(temperatures), profile.viscosity)
    for projection in projections:
        found += projection.messages
        if projection.pump_capacity <= 0.0:
            text = f"{projection.condition.label}: the pump delivers nothing at this pressure and viscosity."
            found.append(Message("warning", "pump_delivers_nothing", text))
    if idle is None:
        text = f"{controller.name} states no operating point hot_idle, where a worn unit fails first."
        found.append(Message("info", "no_hot_idle", text))
    if road is not None:
        found += road.road_test.messages
        found += road.messages
    return list(dict.fromkeys(found))
