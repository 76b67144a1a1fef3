"""What the uncertainty of a unit comes to: of its lands, its totals and pressures, and the instants of a log.

The clearance of a land has a budget with a row per source, as the GUM has them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

from atleak.catalogue.instruments import Instruments, Part
from atleak.catalogue.limits import RuleKind
from atleak.common.errors import Message
from atleak.common.printable import brief
from atleak.common.sentences import Sentence
from atleak.common.units import UM
from atleak.common.verdicts import Band
from atleak.diagnosis.rules import Rule, UnitRules
from atleak.diagnosis.uncertainty.assumptions import Assumptions
from atleak.diagnosis.uncertainty.decision import (
    Decision,
    Remedy,
    RuleDecision,
    advise,
    allowed_variance,
    gauges_that_do,
    remedy,
)
from atleak.diagnosis.uncertainty.draws import Interval
from atleak.diagnosis.uncertainty.sources import (
    MEASURING_TEMPERATURE_SOURCE,
    MOUNTING,
    OF_A_DIAMETER,
    VACUUM_KINDS,
    LandSources,
    RepeatSpread,
    UncertaintySource,
)
from atleak.engine.extremes import Instant
from atleak.equations.statistics import rectangular

MOST_BUDGETS = 12  # lands of a unit whose budget a report shows in full, the worst first
InputKind = Literal["diameter", "temperature", "clearance"]


@dataclass(frozen=True)
class BudgetLine:
    """One source in the budget of a radial clearance c_r = (D − d)/2.

    ``input_uncertainty`` is the standard uncertainty u(x) of what the source is about [m, or K of a temperature],
    ``sensitivity`` the change of c_r with it [1, or m/K], ``contribution`` their product [m], which keeps its sign.
    An error of both parts is one line: what it does to D and to d is added before. ``degrees_of_freedom`` are those
    behind a spread that this unit's repeats show; infinite where the source is no sample of readings, but a
    certificate, a step or an assumption.
    """

    source: UncertaintySource
    input_kind: InputKind
    input_uncertainty: float
    degrees_of_freedom: float
    sensitivity: float
    contribution: float
    fraction: float  # of the variance of c_r

    @property
    def statistical(self) -> bool:
        """Return whether it was evaluated from repeated readings (type A), not otherwise (type B)."""
        return math.isfinite(self.degrees_of_freedom)


def budget_lines(land: LandSources) -> tuple[BudgetLine, ...]:
    """Return the budget of a land's clearance, the largest contribution first; without what is taken as exact.

    Notes
    -----
    The spread of few repeats is widened beforehand by √(ν/(ν − 2)), the standard deviation of Student's t with ν
    degrees of freedom, so the combined uncertainty takes the factors of a normal distribution.

    References
    ----------
    JCGM 100:2008, 5.1 and H.1; JCGM 101:2008, 6.4.9.
    """
    return tuple(line for line in every_line(land) if line.input_uncertainty > 0.0)


def every_line(land: LandSources) -> tuple[BudgetLine, ...]:
    """Return the same with what is taken as exact: what may become uncertain where a number is changed."""
    return tuple(_line(land, source, fraction) for source, fraction in land.budget)


def effective_degrees(lines: Sequence[BudgetLine]) -> float:
    """Return the effective degrees of freedom of the combined uncertainty; infinite where nothing rests on repeats.

    They say how much of it repeats carry. No factor is taken from them: the spread of few repeats is widened already.

    References
    ----------
    JCGM 100:2008, G.4.1 (Welch-Satterthwaite).
    """
    over = math.fsum(line.contribution**4 / line.degrees_of_freedom for line in lines)
    return combined(lines) ** 4 / over if over > 0.0 else math.inf


def combined(lines: Sequence[BudgetLine]) -> float:
    """Return the combined standard uncertainty of a budget [m]: its lines are independent of one another."""
    return math.sqrt(math.fsum(line.contribution**2 for line in lines))


def _line(land: LandSources, source: UncertaintySource, fraction: float) -> BudgetLine:
    kind = _input_kind(source)
    u = _input_uncertainty(land, source, kind)
    return BudgetLine(
        source=source,
        input_kind=kind,
        input_uncertainty=u,
        degrees_of_freedom=_degrees_of_freedom(land, source),
        sensitivity=source.standard_uncertainty / u if u > 0.0 else 0.0,
        contribution=source.standard_uncertainty,
        fraction=fraction,
    )


def _input_kind(source: UncertaintySource) -> InputKind:
    if source.kind == MEASURING_TEMPERATURE_SOURCE:
        return "temperature"
    return "clearance" if source.kind in (MOUNTING, *VACUUM_KINDS) else "diameter"


def _input_uncertainty(land: LandSources, source: UncertaintySource, kind: InputKind) -> float:
    """Return u(x) of a source: of the temperature, or of the diameter, of which the clearance takes half."""
    if kind == "temperature":
        return rectangular(land.assumptions.room_temperature)
    members = [each for each in land.sources if source.group is not None and each.group == source.group] or [source]
    u = max(abs(each.standard_uncertainty) for each in members)
    if source.kind not in VACUUM_KINDS and land.state.leak is not None:
        u /= 1.0 - land.state.leak_weight  # by as much diameters count beside a vacuum test
    return u if kind == "clearance" else u / OF_A_DIAMETER


def _degrees_of_freedom(land: LandSources, source: UncertaintySource) -> float:
    spread = land.spreads.get(source.part) if source.kind == "repeats" and source.part is not None else None
    if spread is None or spread.origin != "repeats":
        return math.inf
    return float(spread.degrees_of_freedom)


@dataclass(frozen=True)
class Shape:
    """The shape of a land's clearance, which its mean does not show."""

    worst_direction: float | None  # [°]
    worst_clearance: float  # [m]
    effective_clearance: float | None  # [m] cube root of the mean of c³ over directions and planes, which leaks
    cube_factor: float | None  # mean of c³ over the cube of the mean; None where a direction closes the gap
    lower_bound: bool  # sleeve measured in one direction only: wear to one side may be missed


@dataclass(frozen=True)
class AtCondition:
    """A land's leakage and share at one condition, with 95 % intervals (or what ``coverage`` was set to)."""

    condition: str  # name of the operating point
    label: str  # of the condition, as people read it
    leakage: float  # [m³/s]
    u_leakage: float  # [m³/s] standard uncertainty of the leakage
    leakage_interval: Interval  # [m³/s]
    share: float  # of the pump's flow, what is drawn from the pump
    u_share: float  # standard uncertainty of the share
    share_interval: Interval  # fractions
    eccentric: Interval  # [m³/s] the leakage concentric and touching the bore, everything else as measured
    budget: tuple[tuple[str, float], ...]  # parts of the share's linear variance, the largest first
    clearance_fraction: float  # part of that variance which the clearance carries


@brief
@dataclass(frozen=True)
class LandUncertainty:
    """The uncertainty of one land's numbers and decisions; a land that was not measured has none."""

    sources: LandSources  # all that makes its clearance uncertain
    u_clearance: float | None  # [m] standard uncertainty of the radial clearance
    clearance_interval: Interval | None  # [m]
    wear_interval: Interval | None  # of (c_r − c_m)/c_m, what is known of c_m included
    conditions: tuple[AtCondition, ...]  # the stated one first; empty where not measured
    rules: tuple[RuleDecision, ...]  # decisions on its rules
    shape: Shape  # of its clearance over directions and planes
    guard_factor: float  # k of the guard band

    @property
    def key(self) -> tuple[str, int]:
        """Return component and number of the land."""
        return self.sources.key

    @property
    def budget(self) -> tuple[tuple[str, float], ...]:
        """Return the part of the clearance's variance that each source carries, the largest first."""
        return tuple((source.label, fraction) for source, fraction in self.sources.budget if fraction > 0.0)

    @property
    def leakage_interval(self) -> Interval | None:
        """Return the interval of the leakage at the stated condition [m³/s]."""
        return self.conditions[0].leakage_interval if self.conditions else None

    @property
    def share_interval(self) -> Interval | None:
        """Return the interval of the share at the stated condition, as a fraction."""
        return self.conditions[0].share_interval if self.conditions else None

    @cached_property
    def deciding(self) -> RuleDecision | None:
        """Return the rule with the worst verdict; of several, the likeliest to be over its limit."""
        return max(self.rules, key=lambda rule: rule.severity, default=None)

    @property
    def suspect(self) -> bool:
        """Return whether the pair measures tighter than a new one can be, so that no limit is surely kept."""
        return self.sources.suspect

    @property
    def decision(self) -> Decision | None:
        """Return the decision about the limit of the deciding rule; a suspect pair is never a plain pass."""
        decided = self.deciding.decision if self.deciding else None
        return "conditional_pass" if decided == "pass" and self.suspect else decided

    @property
    def shown_as(self) -> str | None:
        """Return the decision as a key of its words: a conditional pass as new pairs measure is within their range."""
        within = self.sources.state.within_new and self.decision == "conditional_pass"
        return "within_range" if within else self.decision

    @property
    def probability_over_limit(self) -> float | None:
        """Return the probability that the limit of the deciding rule is passed."""
        return self.deciding.probability_over_limit if self.deciding else None

    def on(self, rule: Rule) -> RuleDecision | None:
        """Return the decision on one of the land's rules."""
        return next((decided for decided in self.rules if decided.rule == rule), None)

    def measurable(self, rule: RuleDecision) -> bool:
        """Return whether these gauges can tell a pair at the limit of wear or clearance from a new one."""
        allowed = self._allowed_wear(rule)
        return allowed is None or self.guard_factor * rule.standard_uncertainty < allowed

    def _allowed_wear(self, rule: RuleDecision) -> float | None:
        """Return how far the limit is above a new pair, in the rule's unit; None for a share, or below a new pair."""
        if rule.rule.kind is RuleKind.WEAR:
            return rule.limit
        allowed = rule.limit - self.sources.state.land.mounting_high
        return allowed if rule.rule.kind is RuleKind.CLEARANCE and allowed > 0.0 else None

    def gauges_that_do(self, rule: RuleDecision) -> Sentence:
        """Say which gauges of the catalogue tell the limit from a new pair."""
        return gauges_that_do(self.sources, self._allowed_variance(rule, self._allowed_wear(rule)))

    def _allowed_variance(self, rule: RuleDecision, distance: float | None) -> float:
        return allowed_variance(self.sources, rule, self._per_clearance(rule), self.guard_factor, distance or 0.0)

    def remedy(self, rule: RuleDecision) -> Remedy | None:
        """Return what would decide a conditional rule; None where it is decided already.

        Where the limit is finer than the gauge, this is what would tell a pair at the limit from a new one.
        """
        if not rule.conditional:
            return None
        measurable = self.measurable(rule)
        distance = abs(rule.value - rule.limit) if measurable else self._allowed_wear(rule)
        allowed = self._allowed_variance(rule, distance)
        way = remedy(self.sources, rule, self._per_clearance(rule), allowed, measurable)
        low, high = self.sources.state.land.mounting_range
        if rule.rule.kind is not RuleKind.WEAR or low == high:
            return way
        # a bore against its own unworn end, on one and the same spool
        u = math.sqrt(2.0 * self.sources.part_fraction("sleeve")) * self.sources.standard_uncertainty
        return replace(way, by_range=True, unworn_end=0.0 < self.guard_factor * u < rule.limit * high)

    def advice_on(self, rule: RuleDecision) -> str | None:
        """Say in plain words what would decide a conditional rule; None where it is decided already."""
        way = self.remedy(rule)
        if way is None:
            return None
        name, limit, guard = _in_words(rule, self)
        return advise(rule, name, way, self.sources, limit, guard)

    @cached_property
    def advice(self) -> str | None:
        """Say in plain words what would decide the deciding rule, or else its next limit.

        None where both are decided already.
        """
        rule = self.deciding
        if rule is None:
            return None
        above = rule.at_next_level
        advice = self.advice_on(rule) or (self.advice_on(above) if above else None)
        if self.suspect:
            tight = "tighter than when new, which wear cannot do: check the readings and the gauges, and measure again"
            return f"{tight}; {advice}" if advice else f"{tight}."
        return advice

    def _at(self, rule: Rule) -> AtCondition:
        """Return the condition at which a rule about a share holds."""
        return next(each for each in self.conditions if rule.condition and each.condition == rule.condition.name)

    def _per_clearance(self, decided: RuleDecision) -> float:
        rule = decided.rule
        if rule.kind is RuleKind.CLEARANCE:
            return 1.0
        if rule.kind is RuleKind.WEAR:
            return 1.0 / self.sources.state.land.mounting_high
        if not self.u_clearance:
            return 0.0
        condition = self._at(rule)
        return condition.u_share * math.sqrt(condition.clearance_fraction) / self.u_clearance


@dataclass(frozen=True)
class TotalUncertainty:
    """The uncertainty of the whole controller's leakage at one condition."""

    condition: str  # its name
    label: str  # of the condition, as people read it
    leakage: float  # [m³/s]
    u_leakage: float  # [m³/s] standard uncertainty of the leakage
    leakage_interval: Interval  # [m³/s]
    share: float  # as a fraction
    u_share: float  # standard uncertainty of the share
    share_interval: Interval  # fractions
    minimum_speed_interval: Interval  # [1/s]
    new_leakage_interval: Interval  # [m³/s] of the same unit new
    growth_interval: Interval  # of the leakage over that of the same unit new, as a fraction
    decision: RuleDecision  # about the total's bands
    reserve_interval: Interval  # of the pump's reserve
    main_pressure_interval: Interval  # [Pa] that holds
    circuit_intervals: Mapping[str, Interval]  # [Pa] that each circuit holds, by its id
    pressures: tuple[RuleDecision, ...]  # about reserve, circuits and permissible pressure at this condition
    band_probabilities: tuple[tuple[Band, float], ...]  # that the true share lies in each band
    budget: tuple[tuple[str, float], ...]  # of the share's linear variance, the largest first


@dataclass(frozen=True)
class InstantUncertainty:
    """The 95 % intervals of leakage [m³/s] and share at one instant of a road test."""

    leakage_interval: Interval  # [m³/s]
    share_interval: Interval | None  # None where the instant has no share


@brief
@dataclass(frozen=True)
class UnitUncertainty:
    """The uncertainty of all lands and totals, with the inputs it follows from."""

    lands: tuple[LandUncertainty, ...]  # that were measured
    totals: tuple[TotalUncertainty, ...]  # in the order of the projections given
    instants: Mapping[Instant, InstantUncertainty]  # of the road test
    instruments: Instruments  # with which the readings were taken
    assumptions: Assumptions  # what else is uncertain
    repeats: dict[Part, RepeatSpread]  # how far readings of each part scatter
    coverage: float  # of the intervals, a fraction
    guard_factor: float  # k of the guard band
    draws: int  # how many
    seed: int  # of the draws, so that they are the same each time
    messages: tuple[Message, ...]  # what a reader must know of it

    @cached_property
    def _by_key(self) -> dict[tuple[str, int], LandUncertainty]:
        return {land.key: land for land in self.lands}

    def land(self, key: tuple[str, int]) -> LandUncertainty:
        """Return one land by component and number."""
        return self._by_key[key]

    def with_lands_of(self, other: UnitUncertainty) -> UnitUncertainty:
        """Return the same with the lands' rules of the same unit with another pump, by which they are judged."""
        lands = (replace(mine, rules=theirs.rules) for mine, theirs in zip(self.lands, other.lands, strict=True))
        return replace(self, lands=tuple(lands))

    def judged(self, rules: UnitRules) -> UnitRules:
        """Return the rules that were decided, each with the level that is most likely reached."""
        of_lands = {land.key: tuple(each.rule for each in land.rules) for land in self.lands if land.key in rules.lands}
        totals = tuple(each.decision.rule for each in self.totals)
        pressures = tuple(each.rule for total in self.totals for each in total.pressures)
        return replace(rules, lands=of_lands, totals=totals, pressures=pressures)

    def on(self, rule: Rule) -> RuleDecision | None:
        """Return the decision on a rule of the whole unit; None where there is none."""
        decisions = (each for total in self.totals for each in (total.decision, *total.pressures))
        return next((decided for decided in decisions if decided.rule == rule), None)

    def total(self, condition: str) -> TotalUncertainty | None:
        """Return the total at the operating point of that name; None where there is none."""
        return next((total for total in self.totals if total.condition == condition), None)


def _in_words(decided: RuleDecision, land: LandUncertainty) -> tuple[str, str, str]:
    guard, kind = land.guard_factor * decided.standard_uncertainty, decided.rule.kind
    if kind is RuleKind.CLEARANCE:
        name = f"radial clearance {decided.value * UM:.1f} µm"
        return name, f"{decided.about} limit of {decided.limit * UM:.1f} µm", f"± {guard * UM:.1f} µm"
    if kind is RuleKind.WEAR:
        name = f"wear {100.0 * decided.value:.1f} %"
    else:
        name = f"share of pump flow {100.0 * decided.value:.3g} % ({land._at(decided.rule).label})"
    band = f"± {100.0 * guard:.2g} %" if math.isfinite(guard) else "the pump may deliver nothing"
    return name, f"{decided.about} limit of {100.0 * decided.limit:.3g} %", band
