"""A unit with its clearances → how sure every number and every verdict is."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from atleak.catalogue.controller import OperatingPoint
from atleak.catalogue.instruments import Instruments, Part, load_instruments
from atleak.catalogue.limits import Limits, RuleKind
from atleak.engine.leakage import LeakageModel
from atleak.engine.projection import Projection
from atleak.equations.gap import FULLY_ECCENTRIC, axial_cube, circumferential_cube
from atleak.equations.uncertainty import normal_quantile, probability_over
from atleak.errors import InputError, Message
from atleak.readings import LandClearance, Readings
from atleak.rules import Rule, UnitRules
from atleak.uncertainty.advice import Remedy, advise, remedy
from atleak.uncertainty.assumptions import DEFAULTS, Assumptions
from atleak.uncertainty.decision import GUARD_FACTOR, Decision, RuleDecision, decide_rule
from atleak.uncertainty.propagation import DRAWS, SEED, LandSpread, TotalSpread, propagate
from atleak.uncertainty.sources import PARTS, LandSources, RepeatSpread, find_sources
from atleak.verdicts import Band
from atleak.workshop_units import UM

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

    def on(self, rule: Rule) -> RuleDecision | None:
        """The decision on one of the land's rules."""
        return next((decided for decided in self.rules if decided.rule == rule), None)

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

    def _at(self, rule: Rule) -> AtCondition:
        """The condition that a rule of share holds at."""
        return next(at for at in self.conditions if rule.condition and at.condition == rule.condition.name)

    def _per_clearance(self, decided: RuleDecision) -> float:
        rule = decided.rule
        if rule.kind is RuleKind.CLEARANCE:
            return 1.0
        if rule.kind is RuleKind.WEAR:
            return 1.0 / self.sources.state.land.mounting_clearance
        at = self._at(rule)
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
    band_probabilities: tuple[tuple[Band, float], ...]
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
    rules: UnitRules,
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
    rules
        of the same states and projections, judged; a decision is added to each.
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
    limits = rules.limits
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
        _land(land, found, projections, rules.of_land(land.state.land.key), coverage, guard_factor, eccentric)
        for land, found in zip(sources, spread.lands, strict=True)
    )
    totals = tuple(
        _total(projection, found, rule, rules.limits, guard_factor)
        for projection, found, rule in zip(projections, spread.totals, rules.totals, strict=True)
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
    rules: Sequence[Rule],
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
    spreads = {projection.condition: spread for projection, spread in zip(projections, found, strict=True)}
    decided = tuple(_decided(rule, land, spreads, guard_factor) for rule in rules)
    # a true clearance is not below zero
    interval = (max(c - reach, min(c, 0.0)), c + reach)
    return LandUncertainty(land, u, interval, conditions, decided, _shape(state), guard_factor)


def _decided(
    rule: Rule, land: LandSources, spreads: Mapping[OperatingPoint, LandSpread], guard_factor: float
) -> RuleDecision:
    """Decide a land's rule: clearance and wear by closed forms, a share by the draws at its condition."""
    limits = [limit for _, limit in rule.steps.levels]
    if rule.kind is RuleKind.PAIR_SHARE:
        assert rule.condition is not None
        share = spreads[rule.condition].share_spread
        us = (share.standard_uncertainty,) * len(limits)
        skewed = share.standard_uncertainty > 0.0
        return decide_rule(rule, us, share.probabilities, guard_factor, skewed=skewed)
    worn = rule.kind is RuleKind.WEAR
    us = _wear_uncertainties(land, limits) if worn else (land.standard_uncertainty,) * len(limits)
    each = tuple(probability_over(rule.value, limits, us).tolist())
    return decide_rule(rule, us, each, guard_factor, skewed=False)


def _wear_uncertainties(land: LandSources, limits: Sequence[float]) -> tuple[float, ...]:
    """Wear over a limit Z means c_r − (1 + Z) c_m above zero, which is normal: no ratio of two uncertain values."""
    mounting, u_mounting = land.state.land.mounting_clearance, land.assumptions.mounting_clearance
    return tuple(math.hypot(land.standard_uncertainty, (1.0 + limit) * u_mounting) / mounting for limit in limits)


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


def _total(
    projection: Projection, found: TotalSpread, rule: Rule, limits: Limits, guard_factor: float
) -> TotalUncertainty:
    at, share, bands = projection.condition, projection.share, limits.bands
    u = found.share_spread.standard_uncertainty
    decision = decide_rule(rule, (u,) * len(bands), found.share_spread.probabilities, guard_factor, skewed=u > 0.0)
    names = (Band.GREEN, *(band for band, _ in bands))
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
    used = [part for part in PARTS if any(part in land.plans for land in sources)]
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
