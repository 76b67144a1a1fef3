"""Judge a land: its verdict, the rule that decided it, what it costs the pump, and how long it will last; and the pump.

A straight line of wear over mileage needs two points. The second one, at 0 km, is the mounting clearance, where that
was measured: on this pair when it was new, or on new units of its type. That wear grows in proportion to mileage is an
assumption of this project, as it accelerates with contaminated fluid: more than two points show where it does not hold.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from atleak.catalogue.limits import RuleKind
from atleak.catalogue.pump import Pump
from atleak.catalogue.repairs import LandKey
from atleak.common.errors import Message
from atleak.common.printable import brief
from atleak.common.sentences import Sentence
from atleak.common.units import Quantity
from atleak.common.verdicts import Verdict, worst
from atleak.diagnosis.rules import Rule, UnitRules, pump_rules
from atleak.diagnosis.uncertainty import Decision, LandUncertainty, RuleDecision, UnitUncertainty
from atleak.diagnosis.uncertainty.decision import decide_normal
from atleak.diagnosis.uncertainty.sources import LandSources
from atleak.engine.projection import Projection
from atleak.equations.statistics import normal_quantile
from atleak.measurements.clearances import LandClearance

MILEAGE_COVERAGE = 0.90  # of the intervals of rates and of mileages
FARTHEST = 1.0e6  # [km] beyond which nobody foresees a repair: choice of this project
SERVICE_INTERVAL = 60_000.0  # [km] from one service of the transmission to the next: choice of this project, assumed
_LEAST = 1e-12  # [m] that a clearance is uncertain at least: without any error a weight would be infinite
_LEAST_WAY = 1.0  # [km] over which a rate can be told at all: a choice of this project
_BENT = 0.99  # probability that the points of a straight line scatter less than those of one called bent


@dataclass(frozen=True)
class Crossing:
    """The mileage [km] at which a limit is reached: its median and its interval.

    The vehicle has not come there yet, so none of them is before ``present``, its mileage now.
    """

    value: float  # infinite where the limit is never reached
    low: float  # lower end of the interval
    high: float  # infinite where the limit may never be reached
    present: float  # the vehicle's mileage now, before which none of them lies

    @property
    def foreseeable(self) -> bool:
        """Return whether the interval ends within what a vehicle runs."""
        return self.high <= FARTHEST

    @property
    def not_before(self) -> float | None:
        """Return the mileage up to which it is not reached, where no more can be told; None where that is no later."""
        least = min(self.low, FARTHEST)
        return None if self.foreseeable or least <= self.present else least


@dataclass(frozen=True)
class WearLine:
    """A clearance that grows in a straight line: what it is at some mileage, and its rate, both normal."""

    origin: float  # [km] at which it is ``clearance``
    clearance: float  # [m]
    rate: float  # [m/km]
    covariance: NDArray[np.float64]  # of both
    weights: NDArray[np.float64]  # by which both follow from the points, shape (2, points)
    scatter: float  # by which the points scatter more than measuring explains; 1 where they do not

    @property
    def straight(self) -> bool:
        """Return whether the points may lie on a straight line, as far as measuring tells."""
        return self.scatter == 1.0

    def at(self, mileage: float) -> float:
        """Return the clearance [m] at a mileage [km]."""
        return self.clearance + self.rate * (mileage - self.origin)

    def uncertainty_at(self, mileage: float) -> float:
        """Return the standard uncertainty of the clearance [m] at a mileage [km]."""
        way = np.array([1.0, mileage - self.origin])
        return math.sqrt(max(float(way @ self.covariance @ way), 0.0))

    def band(self, mileage: float, coverage: float = MILEAGE_COVERAGE) -> tuple[float, float]:
        """Return the interval of the clearance [m] at a mileage [km].

        Parameters
        ----------
        mileage
            of the vehicle [km].
        coverage
            probability [-] of the interval.
        """
        reach = _deviate(coverage) * self.uncertainty_at(mileage)
        return self.at(mileage) - reach, self.at(mileage) + reach

    def rate_interval(self) -> tuple[float, float]:
        """Return the interval of the rate [m/km]."""
        reach = _deviate(MILEAGE_COVERAGE) * math.sqrt(float(self.covariance[1, 1]))
        return self.rate - reach, self.rate + reach

    @property
    def certain(self) -> bool:
        """Return whether wear can be told from measurement: the interval of the rate is above zero."""
        return self.rate_interval()[0] > 0.0

    def reaches(self, limit: float, present: float) -> Crossing:
        """Return the mileage at which the clearance reaches a limit [m].

        Parameters
        ----------
        present
            mileage of the vehicle [km], before which it has not happened.

        Notes
        -----
        The limit is passed by a mileage with the probability that the clearance there is above it, which is normal: no
        ratio of two uncertain values is drawn. So the interval ends where the band of the line crosses the limit
        (Fieller, J. R. Stat. Soc. B 16 (1954) 175-185).
        """
        z = _deviate(MILEAGE_COVERAGE)
        most, least = (self._crosses(limit, present, deviate) for deviate in (z, -z))
        return Crossing(self._crosses(limit, present, 0.0), most, least if self.certain else math.inf, present)

    def _crosses(self, limit: float, present: float, deviate: float) -> float:
        """Return from which mileage the line, or the edge of its band so many deviations above it, is past a limit."""
        clearance, u = self.at(present), self.uncertainty_at(present)
        if clearance + deviate * u >= limit:
            return present
        (_, of_both), (_, of_rate) = (deviate * deviate * self.covariance).tolist()
        past, way = clearance - limit, present - self.origin
        if deviate == 0.0:
            return present - past / self.rate if self.rate > 0.0 else math.inf
        # (past + rate·x)² = z² u(x)², with x the way from the present mileage on
        square = self.rate**2 - of_rate
        linear = 2.0 * (self.rate * past - of_both - of_rate * way)
        constant = past**2 - (deviate * u) ** 2
        ways = (x for x in _roots(square, linear, constant) if x > 0.0 and (past + self.rate * x) * deviate <= 0.0)
        return present + min(ways, default=math.inf)


def wear_line(
    mileages: Sequence[float], clearances: Sequence[float], covariance: NDArray[np.float64]
) -> WearLine | None:
    """Return the straight line that explains clearances best; None where all mileages are within a kilometre.

    Parameters
    ----------
    mileages, clearances
        of every point [km, m].
    covariance
        of the errors of the clearances [m²], shape (points, points): an error that points share tells no rate.

    Notes
    -----
    The weighted mean with the least variance, for errors that are not independent. Points that scatter more than
    measuring explains, with a probability of less than 1 %, widen all its uncertainties by as much.

    References
    ----------
    Aitken A. C., Proc. R. Soc. Edinburgh 55 (1936) 42-48; Birge R. T., Phys. Rev. 40 (1932) 207-227.
    """
    x, y = np.asarray(mileages, float), np.asarray(clearances, float)
    if x.size < 2 or np.ptp(x) < _LEAST_WAY:
        return None
    origin = float(x[-1])
    design = np.column_stack([np.ones(x.size), x - origin])
    weight = np.linalg.inv(np.asarray(covariance, float) + _LEAST**2 * np.eye(x.size))
    scale = np.array([1.0, 1.0 / max(float(np.ptp(x)), 1.0)])  # of both unknowns: one is a million times the other
    scaled = design * scale
    of_both = np.linalg.inv(scaled.T @ weight @ scaled) * np.outer(scale, scale)
    weights = of_both @ design.T @ weight
    clearance, rate = weights @ y
    residual = y - design @ (clearance, rate)
    scatter = _scatter(float(residual @ weight @ residual), x.size - 2)
    return WearLine(origin, float(clearance), float(rate), scatter**2 * of_both, weights, scatter)


def _scatter(squares: float, degrees: int) -> float:
    """Return how much wider than measuring explains the points scatter: 1 where that may be chance."""
    if degrees < 1:
        return 1.0
    # the chi-square's quantile: Wilson and Hilferty, Proc. Natl. Acad. Sci. 17 (1931) 684-688
    part = 2.0 / (9.0 * degrees)
    most = degrees * (1.0 - part + float(normal_quantile(_BENT)) * math.sqrt(part)) ** 3
    return math.sqrt(squares / degrees) if squares > most else 1.0


def _deviate(coverage: float) -> float:
    return float(normal_quantile(0.5 + 0.5 * coverage))


def _roots(square: float, linear: float, constant: float) -> tuple[float, ...]:
    """Return the real roots of a quadratic, or of the straight line that it may be."""
    if square == 0.0:
        return (-constant / linear,) if linear else ()
    within = linear * linear - 4.0 * square * constant
    if within < 0.0:
        return ()
    far = -0.5 * (linear + math.copysign(math.sqrt(within), linear))
    return (far / square, constant / far) if far else (0.0,)


NO_RATE = "no_wear_over_mileage"  # code of the message that one visit gives none


def known_at_start(land: LandSources) -> bool:
    """Return whether the clearance that a land had at 0 km was measured; of one that was repaired since it was not."""
    return land.state.land.mounting_measured and land.state.land.fitted is None


def replace_mileage(
    rules: Iterable[Rule], mileage: float | None, uncertainty: LandUncertainty | None
) -> Crossing | None:
    """Return the mileage at which a land reaches the wear limit; None where one visit cannot tell it, or it is passed.

    Parameters
    ----------
    mileage
        of the vehicle [km]; None where it is not known.
    """
    rule = next((rule for rule in rules if rule.kind is RuleKind.WEAR), None)
    if rule is None or uncertainty is None:
        return None
    line = line_from_new(uncertainty.sources, mileage)
    if line is None or mileage is None:
        return None
    worn = rule.steps.limit_of(Verdict.REPLACE) or rule.steps.levels[-1][1]
    state = uncertainty.sources.state
    limit = (1.0 + worn) * state.land.mounting_high
    return None if state.radial_clearance >= limit else line.reaches(limit, mileage)


def line_from_new(land: LandSources, mileage: float | None) -> WearLine | None:
    """Return the line from the mounting clearance at 0 km to the clearance as measured; None where either lacks."""
    if mileage is None or not land.state.whole or not known_at_start(land):
        return None
    of_both = np.diag([land.u_mounting**2, land.standard_uncertainty**2])
    return wear_line([0.0, mileage], [land.state.land.new_clearance, land.state.radial_clearance], of_both)


def without_rate(lands: Iterable[LandUncertainty], mileage: float | None) -> Message | None:
    """Say how many measured lands have no rate of wear; None where all have one, or no mileage asks for it."""
    measured = [land.sources for land in lands if land.sources.state.can_be_ok]
    unknown = sum(not known_at_start(land) for land in measured)
    if mileage is None or not unknown:
        return None
    text = Sentence(
        "One visit tells no wear over mileage of {unknown} of {measured} measured lands: what they had at {start} "
        "{start.unit} was not measured. A second visit tells it, or mounting clearances that are learned from new "
        "units.",
        unknown=unknown,
        measured=len(measured),
        start=Quantity(0.0, "distance"),
    )
    return Message("info", NO_RATE, text)


@brief
@dataclass(frozen=True)
class LandDiagnosis:
    """One land's clearance, its leakage at the stated condition, its verdict and how sure that is."""

    state: LandClearance  # its clearance
    wear: float | None  # (c_r − c_m)/c_m; None where not measured
    effective_clearance: float  # [m] at the stated condition
    leakage: float  # [m³/s] at the stated condition, through every gap of the land
    drawn_from_pump: float  # [m³/s] the part of the leakage that counts in the total
    share: float  # what it draws / pump capacity at the stated condition
    excess_share: float  # what it draws above the same land at its mounting clearance, where that costs most
    verdict: Verdict  # the worst of its rules
    rules: tuple[Rule, ...]  # by which it is judged
    replace_mileage: Crossing | None  # None where one visit cannot tell it, and where it has been passed
    uncertainty: LandUncertainty | None  # None where nothing was measured
    messages: tuple[Message, ...]  # what a reader must know of it

    @property
    def key(self) -> LandKey:
        """Return component and land."""
        return self.state.land.key

    @property
    def decision(self) -> Decision | None:
        """Say how sure the verdict is, about the limit of the rule that gave it; None where not measured."""
        return self.uncertainty.decision if self.uncertainty and self.verdict != Verdict.NOT_MEASURED else None

    @property
    def shown_as(self) -> str | None:
        """Return the decision as a key of its words, which tell one within the range of new pairs apart."""
        return self.uncertainty.shown_as if self.uncertainty and self.decision else None

    @property
    def suspect(self) -> bool:
        """Return whether the pair measures tighter than a new one can be."""
        return self.uncertainty is not None and self.uncertainty.suspect

    @property
    def in_doubt(self) -> bool:
        """Return whether its readings contradict one another, or say that the pair is tighter than a new one."""
        return self.suspect or self.state.contradicted or bool(self.state.doubts)

    @property
    def probability_over_limit(self) -> float | None:
        """Return the probability that the true value is over the limit of the rule that gave the verdict."""
        decided = self.deciding_uncertainty
        return decided.probability_over_limit if decided and self.verdict != Verdict.NOT_MEASURED else None

    @property
    def within_new(self) -> bool:
        """Tell whether a land whose clearance when new is known as a range measures within it: it shows no wear."""
        return self.wear is not None and self.state.within_new

    @property
    def deciding_uncertainty(self) -> RuleDecision | None:
        """Return the decision that belongs to the verdict."""
        return self.uncertainty.deciding if self.uncertainty else None

    @property
    def deciding(self) -> Rule | None:
        """Return the rule that gave the verdict: the worst; of several, the likeliest to be over its limit."""
        decided = self.deciding_uncertainty
        if decided is not None:
            return decided.rule
        return max(self.rules, key=lambda rule: rule.verdict.rank, default=None)


@dataclass(frozen=True)
class PumpDiagnosis:
    """What was measured of the pump against its limits, and what is past a limit by its wear."""

    decisions: tuple[RuleDecision, ...]  # on its measured clearances
    lacking: tuple[Rule, ...]  # of one past its limits: totals and pressures better with a new one, the worst first

    @property
    def rules(self) -> tuple[Rule, ...]:
        """Return every rule that it is judged by."""
        return (*(decided.rule for decided in self.decisions), *self.lacking)

    @property
    def deciding(self) -> Rule | None:
        """Return the worst of them; None where nothing that was measured has a limit."""
        return max(self.rules, key=lambda rule: rule.verdict.rank, default=None)

    @property
    def verdict(self) -> Verdict:
        """Return the verdict of that."""
        return Verdict.NOT_MEASURED if self.deciding is None else self.deciding.verdict


def diagnosed_pump(
    pump: Pump, rules: UnitRules, with_new: Iterable[Rule], uncertainty: float, guard_factor: float
) -> PumpDiagnosis:
    """Judge the pump: its clearances, and of one past them what of the unit's rules stands better ``with_new`` one.

    A pump within its own limits is not worn, whatever the unit lacks. ``uncertainty`` is that of a measured
    clearance [m].
    """
    decisions = tuple(decide_normal(rule, uncertainty, guard_factor) for rule in pump_rules(pump))
    if not any(decided.rule.verdict.flagged for decided in decisions):
        return PumpDiagnosis(decisions, ())
    better = {rule.id: rule.verdict.rank for rule in with_new}
    unit = sorted(rules.of_unit, key=lambda rule: rule.kind is not RuleKind.PERMISSIBLE_PRESSURE)  # what drivers feel
    lacking = [rule for rule in unit if rule.verdict.rank > better.get(rule.id, rule.verdict.rank)]
    return PumpDiagnosis(decisions, tuple(sorted(lacking, key=lambda rule: -rule.verdict.rank)))


def diagnosed_land(
    state: LandClearance,
    projections: Sequence[Projection],
    when_new: Sequence[Projection],
    rules: UnitRules,
    mileage: float | None,
    uncertainty: UnitUncertainty | None,
) -> LandDiagnosis:
    """Judge a land by the rules of its unit; ``when_new`` are the same conditions with every land as new."""
    land = state.land
    stated = projections[0]
    wear = state.wear if state.measured else None
    own_rules = rules.of_land(land.key)
    excess = max(
        now.share_of(now.drawn_by(land.key)) - new.share_of(new.drawn_by(land.key)) if now.pump_capacity > 0.0 else 0.0
        for now, new in zip(projections, when_new, strict=True)
    )
    leakage = stated.leakage_of(land.key)
    own_uncertainty = uncertainty.land(land.key) if uncertainty is not None and state.measured else None
    return LandDiagnosis(
        state=state,
        wear=wear,
        effective_clearance=state.effective_clearance(stated.condition.temperature),
        leakage=leakage,
        drawn_from_pump=stated.drawn_by(land.key),
        share=stated.share_drawn_by(land.key),
        excess_share=excess,
        verdict=_verdict(state, own_rules),
        rules=own_rules,
        replace_mileage=replace_mileage(own_rules, mileage, own_uncertainty),
        uncertainty=own_uncertainty,
        messages=state.messages,
    )


def _verdict(state: LandClearance, rules: Iterable[Rule]) -> Verdict:
    """Return the verdict of the worst rule.

    With one part at its nominal diameter a limit can be passed, but ``ok`` cannot be claimed; nor of a sealed land.
    """
    reached = worst(rule.verdict for rule in rules)
    return Verdict.NOT_MEASURED if reached == Verdict.OK and not state.can_be_ok else reached
