"""A unit with its clearances → how sure every number and every verdict is."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from atleak.equations.gap import FULLY_ECCENTRIC, axial_cube, circumferential_cube
from atleak.equations.uncertainty import normal_quantile, probability_over
from atleak.errors import InputError, Message
from atleak.instruments import Instruments, Part, load_instruments
from atleak.leakage import LeakageModel
from atleak.limits import Limits, Steps
from atleak.projection import Projection
from atleak.readings import LandClearance, Readings
from atleak.uncertainty.advice import Remedy, advise, remedy
from atleak.uncertainty.assumptions import DEFAULTS, Assumptions
from atleak.uncertainty.decision import GUARD_FACTOR, Decision, RuleDecision, decide_rule
from atleak.uncertainty.propagation import DRAWS, SEED, LandSpread, TotalSpread, propagate
from atleak.uncertainty.sources import LandSources, RepeatSpread, find_sources

COVERAGE = 0.95
Interval = tuple[float, float]


@dataclass(frozen=True)
class Shape:
    """What the mean clearance of a land hides.

    ``effective_clearance`` [m] is the cube root of what stands for c³: the mean of c³ around each plane, the harmonic
    mean along the planes. ``cube_factor`` is that over the cube of the mean clearance: what the engine's flow would be
    multiplied by; None where a direction closes the gap. ``lower_bound`` says that the sleeve was measured in
    one direction only, so that wear to one side may not be in the clearance at all.
    """

    worst_direction: float | None  # [°]
    worst_clearance: float  # [m]
    effective_clearance: float | None  # [m]
    cube_factor: float | None
    lower_bound: bool


@dataclass(frozen=True)
class AtCondition:
    """A land's leakage and share at one condition, with 95 % intervals (or what ``coverage`` was set to)."""

    condition: str  # name of the operating point
    label: str
    leakage: float  # [m³/s]
    u_leakage: float
    leakage_interval: Interval
    share: float
    u_share: float
    share_interval: Interval
    eccentric: Interval  # [m³/s] the leakage concentric and fully eccentric, everything else as measured
    budget: tuple[tuple[str, float], ...]  # of the share's linear variance, the largest first
    clearance_fraction: float  # of it that the clearance carries
    closed_form: bool  # leakage by closed form instead of draws


@dataclass(frozen=True)
class LandUncertainty:
    """How sure one land's numbers and decisions are. Nothing is said of a land that was not measured."""

    sources: LandSources
    u_clearance: float | None  # [m] standard uncertainty of the radial clearance
    clearance_interval: Interval | None  # [m]
    conditions: tuple[AtCondition, ...]  # the stated one first; empty where not measured
    rules: tuple[RuleDecision, ...]
    shape: Shape
    guard_factor: float

    @property
    def key(self) -> tuple[str, int]:
        return self.sources.state.land.key

    @property
    def budget(self) -> tuple[tuple[str, float], ...]:
        """What each source carries of the clearance's variance, the largest first."""
        return tuple((source.label, fraction) for source, fraction in self.sources.budget if fraction > 0.0)

    @property
    def leakage_interval(self) -> Interval | None:
        """At the stated condition [m³/s]."""
        return self.conditions[0].leakage_interval if self.conditions else None

    @property
    def share_interval(self) -> Interval | None:
        """At the stated condition, as a fraction."""
        return self.conditions[0].share_interval if self.conditions else None

    @property
    def deciding(self) -> RuleDecision | None:
        """The rule with the worst verdict; of several, the likeliest to be over its limit."""
        return max(self.rules, key=lambda rule: rule.severity, default=None)

    @property
    def decision(self) -> Decision | None:
        """About the limit of the deciding rule."""
        return self.deciding.decision if self.deciding else None

    @property
    def probability_over_limit(self) -> float | None:
        """Of the deciding rule."""
        return self.deciding.probability_over_limit if self.deciding else None

    def rule(self, name: str) -> RuleDecision | None:
        """The decision of the rule of that name."""
        return next((rule for rule in self.rules if rule.rule == name), None)

    def remedy(self, rule: RuleDecision) -> Remedy | None:
        """What would settle a conditional rule; None where it is settled."""
        if not rule.conditional:
            return None
        return remedy(self.sources, rule, self._per_clearance(rule), self.guard_factor)

    def advice_on(self, rule: RuleDecision) -> str | None:
        """The same in plain words."""
        found = self.remedy(rule)
        if found is None:
            return None
        name, limit, guard = _in_words(rule, self)
        return advise(rule, name, found, self.sources, limit, guard)

    @cached_property
    def advice(self) -> str | None:
        """In plain words, about the deciding rule, or else about its next limit; None where both are settled."""
        rule = self.deciding
        if rule is None:
            return None
        above = rule.at_next_level
        return self.advice_on(rule) or (self.advice_on(above) if above else None)

    def _per_clearance(self, rule: RuleDecision) -> float:
        if rule.rule == "radial_clearance":
            return 1.0
        if rule.rule == "wear":
            return 1.0 / self.sources.state.land.mounting_clearance
        at = next(at for at in self.conditions if f"share_{at.condition}" == rule.rule)
        return at.u_share * math.sqrt(at.clearance_fraction) / self.u_clearance if self.u_clearance else 0.0


@dataclass(frozen=True)
class TotalUncertainty:
    """The whole controller at one condition."""

    condition: str
    label: str
    leakage: float  # [m³/s]
    u_leakage: float
    leakage_interval: Interval
    share: float
    u_share: float
    share_interval: Interval
    minimum_speed_interval: Interval  # [1/s]
    decision: RuleDecision  # about the total's bands
    band_probabilities: tuple[tuple[str, float], ...]
    budget: tuple[tuple[str, float], ...]  # of the share's linear variance, the largest first


@dataclass(frozen=True)
class UnitUncertainty:
    """All lands and totals, with what they rest on."""

    lands: tuple[LandUncertainty, ...]
    totals: tuple[TotalUncertainty, ...]  # in the order of the projections given
    instruments: Instruments
    assumptions: Assumptions
    repeats: dict[Part, RepeatSpread]
    coverage: float
    guard_factor: float
    draws: int
    seed: int
    messages: tuple[Message, ...]

    @cached_property
    def _by_key(self) -> dict[tuple[str, int], LandUncertainty]:
        return {land.key: land for land in self.lands}

    def land(self, key: tuple[str, int]) -> LandUncertainty:
        """One land by component and number."""
        return self._by_key[key]

    def total(self, condition: str) -> TotalUncertainty | None:
        """The total at the operating point of that name."""
        return next((total for total in self.totals if total.condition == condition), None)


def assess(
    model: LeakageModel,
    states: Sequence[LandClearance],
    projections: Sequence[Projection],
    limits: Limits,
    *,
    readings: Readings | None = None,
    instruments: Instruments | None = None,
    assumptions: Assumptions = DEFAULTS,
    coverage: float = COVERAGE,
    guard_factor: float = GUARD_FACTOR,
    draws: int = DRAWS,
    seed: int = SEED,
) -> UnitUncertainty:
    """Measurement uncertainty of a unit, carried through the cube to every flow, the total and every decision.

    Parameters
    ----------
    model
        the engine with the clearances as measured.
    states
        the clearance of every land, as the model has them.
    projections
        the conditions that are judged, the stated one first.
    limits
        whose rules are decided.
    readings
        the sheet behind the clearances: planes, directions and repeats. Without it nothing was measured.
    instruments
        with which; the catalogue's defaults unless given.
    assumptions
        all that is uncertain besides the readings.
    coverage
        of every interval; as much is left out below as above.
    guard_factor
        k of the guard band k·u around a limit; 1.645 leaves 5 % one-sided.
    draws, seed
        of the Monte Carlo; the same input gives the same digits.

    Returns
    -------
    UnitUncertainty

    Raises
    ------
    InputError
        coverage outside 0 … 1, a negative guard factor, fewer than 100 draws, or no condition.
    DomainError
        a condition's temperature outside the fluid's data.

    Notes
    -----
    The clearance is normal with the root sum of squares of its sources (linear in the diameters, so this is exact);
    its decisions and those on wear are closed forms. Flows and shares are the draws'; only where nothing but a normal
    clearance is uncertain does the flow have its closed form. The linear (GUM) propagation serves the budgets alone.

    References
    ----------
    JCGM 100:2008, JCGM 101:2008, JCGM 106:2012; ILAC-G8:09/2019.
    """
    _check(projections, coverage, guard_factor, draws)
    instruments = instruments or load_instruments()
    sources, repeats = find_sources(states, readings, model.controller, instruments, assumptions)
    pair = limits.pair_share
    pair_limits = [limit for _, limit in pair.levels] if pair else []
    total_limits = [limit for _, limit in limits.total_share.levels]
    spread = propagate(
        model,
        sources,
        projections,
        assumptions,
        pair_limits=pair_limits,
        total_limits=total_limits,
        coverage=coverage,
        draws=draws,
        seed=seed,
    )
    eccentric = model.law.eccentricity_factor
    lands = tuple(
        _land(land, found, projections, limits, coverage, guard_factor, eccentric)
        for land, found in zip(sources, spread.lands, strict=True)
    )
    totals = tuple(
        _total(projection, found, limits, guard_factor)
        for projection, found in zip(projections, spread.totals, strict=True)
    )
    return UnitUncertainty(
        lands=lands,
        totals=totals,
        instruments=instruments,
        assumptions=assumptions,
        repeats=repeats,
        coverage=coverage,
        guard_factor=guard_factor,
        draws=draws,
        seed=seed,
        messages=tuple(_messages(sources, instruments, repeats)),
    )


def _check(projections: Sequence[Projection], coverage: float, guard_factor: float, draws: int) -> None:
    if not projections:
        raise InputError("no condition to assess", expected="at least one projection")
    if not 0.0 < coverage < 1.0:
        raise InputError("coverage not accepted", value=coverage, expected="a number between 0 and 1, such as 0.95")
    if not (guard_factor >= 0.0 and math.isfinite(guard_factor)):
        raise InputError("guard factor not accepted", value=guard_factor, expected="0 or more, such as 1.645")
    if draws < 100:
        raise InputError("too few draws", value=draws, expected="at least 100, such as 20000")


# --- one land


def _land(
    land: LandSources,
    found: Sequence[LandSpread],
    projections: Sequence[Projection],
    limits: Limits,
    coverage: float,
    guard_factor: float,
    eccentric: float,
) -> LandUncertainty:
    state = land.state
    if not state.measured:
        return LandUncertainty(land, None, None, (), (), _shape(state), guard_factor)
    u = land.standard_uncertainty
    reach = float(normal_quantile(0.5 + 0.5 * coverage)) * u
    c = state.radial_clearance
    conditions = tuple(
        _at(land, projection, spread, eccentric) for projection, spread in zip(projections, found, strict=True)
    )
    rules = []
    if limits.wear is not None:
        rules.append(_wear(land, limits.wear, guard_factor))
    own = state.land.clearance_limit
    steps = limits.clearance if own is None else Steps((("replace", own),), "set by the workshop", "")
    if steps is not None:
        each = tuple(probability_over(c, [limit for _, limit in steps.levels], u).tolist())
        rules.append(
            decide_rule("radial_clearance", c, steps, "ok", (u,) * len(each), each, guard_factor, skewed=False)
        )
    if limits.pair_share is not None:
        for at, spread in zip(conditions, found, strict=True):
            each = spread.share_spread.probabilities
            name = f"share_{at.condition}"
            spreads = (at.u_share,) * len(each)
            rules.append(
                decide_rule(
                    name, at.share, limits.pair_share, "ok", spreads, each, guard_factor, skewed=at.u_share > 0.0
                )
            )
    # a true clearance is not below zero
    interval = (max(c - reach, min(c, 0.0)), c + reach)
    return LandUncertainty(land, u, interval, conditions, tuple(rules), _shape(state), guard_factor)


def _wear(land: LandSources, steps: Steps, guard_factor: float) -> RuleDecision:
    """Wear over a limit Z means c_r − (1 + Z) c_m above zero, which is normal: no ratio of two uncertain values."""
    state = land.state
    mounting, u_mounting = state.land.mounting_clearance, land.assumptions.mounting_clearance
    wear = state.wear
    limits = [limit for _, limit in steps.levels]
    spreads = tuple(math.hypot(land.standard_uncertainty, (1.0 + limit) * u_mounting) / mounting for limit in limits)
    each = tuple(probability_over(wear, limits, spreads).tolist())
    return decide_rule("wear", wear, steps, "ok", spreads, each, guard_factor, skewed=False)


def _at(land: LandSources, projection: Projection, found: LandSpread, eccentric: float) -> AtCondition:
    share = projection.share_of(found.leakage)
    of_clearance = (found.share_per_clearance * land.standard_uncertainty) ** 2
    effects = {source.label: fraction * of_clearance for source, fraction in land.budget}
    effects |= {name: effect**2 for name, effect in found.share_effects.items()}
    whole = math.fsum(effects.values())
    return AtCondition(
        condition=projection.condition.name,
        label=projection.condition.label,
        leakage=found.leakage,
        u_leakage=found.leakage_spread.standard_uncertainty,
        leakage_interval=found.leakage_spread.interval,
        share=share,
        u_share=found.share_spread.standard_uncertainty,
        share_interval=found.share_spread.interval,
        eccentric=(found.leakage / eccentric, FULLY_ECCENTRIC * found.leakage / eccentric),
        budget=_fractions(effects),
        clearance_fraction=of_clearance / whole if whole > 0.0 and math.isfinite(whole) else 0.0,
        closed_form=found.by_quadrature,
    )


def _fractions(variances: dict[str, float]) -> tuple[tuple[str, float], ...]:
    total = math.fsum(variances.values())
    if not (total > 0.0 and math.isfinite(total)):
        return ()
    shares = [(name, variance / total) for name, variance in variances.items() if variance > 0.0]
    return tuple(sorted(shares, key=lambda item: -item[1]))


def _shape(state: LandClearance) -> Shape:
    planes: dict[str, list[float]] = {}
    for station in state.stations:
        planes.setdefault(station.plane, []).append(station.radial_clearance)
    clearances = list(planes.values()) or [[state.radial_clearance]]
    effective = factor = None
    if min(min(plane) for plane in clearances) > 0.0:
        cube = float(axial_cube([float(circumferential_cube(plane)) ** (1.0 / 3.0) for plane in clearances]))
        effective = cube ** (1.0 / 3.0)
        factor = cube / state.radial_clearance**3
    return Shape(
        worst_direction=state.worst_direction,
        worst_clearance=state.max_clearance,
        effective_clearance=effective,
        cube_factor=factor,
        lower_bound=_lower_bound(state),
    )


def _lower_bound(state: LandClearance) -> bool:
    """Whether the sleeve was measured in one direction only: ovality needs two in one plane."""
    return state.status in {"measured", "sleeve_only"} and state.sleeve_ovality is None


# --- the whole


def _total(projection: Projection, found: TotalSpread, limits: Limits, guard_factor: float) -> TotalUncertainty:
    steps, at = limits.total_share, projection.condition
    share, u = projection.share, found.share_spread.standard_uncertainty
    decision = decide_rule(
        f"total_share_{at.name}",
        share,
        steps,
        "green",
        (u,) * len(steps.levels),
        found.share_spread.probabilities,
        guard_factor,
        skewed=u > 0.0,
    )
    names = ("green", *(name for name, _ in steps.levels))
    return TotalUncertainty(
        condition=at.name,
        label=at.label,
        leakage=projection.leakage,
        u_leakage=found.leakage_spread.standard_uncertainty,
        leakage_interval=found.leakage_spread.interval,
        share=share,
        u_share=u,
        share_interval=found.share_spread.interval,
        minimum_speed_interval=found.minimum_speed_interval,
        decision=decision,
        band_probabilities=tuple(zip(names, found.band_probabilities, strict=True)),
        budget=_fractions({name: effect**2 for name, effect in found.effects.items()}),
    )


def _messages(
    sources: Sequence[LandSources], instruments: Instruments, repeats: dict[Part, RepeatSpread]
) -> list[Message]:
    found = []
    used = [part for part in ("spool", "sleeve") if any(part in land.plans for land in sources)]
    for instrument in dict.fromkeys(instruments.of(part) for part in used):
        if instrument.representative:
            said = ", ".join(instrument.representative)
            text = f"{instrument.name}: representative, not from a certificate: {said}. Set your own instrument's."
            found.append(Message("info", "instrument_representative", text))
    for part in used:
        spread = repeats[part]
        if spread.degrees_of_freedom == 0:
            taken = (
                f"{spread.standard_deviation * 1e6:.2g} µm is taken from the instrument"
                if spread.origin == "instrument"
                else f"the reading's step of {spread.resolution * 1e6:g} µm is taken instead"
            )
            text = f"No independent repeats of any {part}: how far readings spread is not known, {taken}."
            found.append(Message("info", "no_independent_repeats", text))
    single = [land.state for land in sources if _lower_bound(land.state)]
    if single:
        names = ", ".join(f"{state.land.component} land {state.land.land}" for state in single)
        text = f"Sleeve measured in one direction only, so the clearance is a lower bound: {names}."
        found.append(Message("warning", "clearance_lower_bound", text))
    missing = sum(not land.state.measured for land in sources)
    if used and missing:
        text = f"{missing} of {len(sources)} lands were not measured and are in the total at their mounting clearance."
        found.append(Message("warning", "total_with_unmeasured", text))
    return found


def _in_words(rule: RuleDecision, land: LandUncertainty) -> tuple[str, str, str]:
    guard = land.guard_factor * rule.standard_uncertainty
    if rule.rule == "radial_clearance":
        name = f"radial clearance {rule.value * 1e6:.1f} µm"
        return name, f"{rule.about} limit of {rule.limit * 1e6:.1f} µm", f"± {guard * 1e6:.1f} µm"
    if rule.rule == "wear":
        name = f"wear {100.0 * rule.value:.1f} %"
    else:
        label = next(at.label for at in land.conditions if f"share_{at.condition}" == rule.rule)
        name = f"share of pump flow {100.0 * rule.value:.3g} % ({label})"
    band = f"± {100.0 * guard:.2g} %" if math.isfinite(guard) else "the pump may deliver nothing"
    return name, f"{rule.about} limit of {100.0 * rule.limit:.3g} %", band
