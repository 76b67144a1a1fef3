"""Work out how sure every number and every verdict of a unit is."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from types import MappingProxyType

from atleak.catalogue.instruments import Instruments, Part, load_instruments
from atleak.catalogue.limits import Limits, RuleKind
from atleak.catalogue.operating_point import OperatingPoint
from atleak.common.errors import InputError, Message
from atleak.common.sentences import Name, Sentence
from atleak.common.units import UM, Quantity
from atleak.common.verdicts import Band
from atleak.diagnosis.rules import Rule, UnitRules
from atleak.diagnosis.uncertainty.assumptions import DEFAULTS, Assumptions
from atleak.diagnosis.uncertainty.decision import GUARD_FACTOR, RuleDecision, decide_normal, decide_rule
from atleak.diagnosis.uncertainty.drawn_unit import PressureSpread
from atleak.diagnosis.uncertainty.draws import Interval, rounded_up
from atleak.diagnosis.uncertainty.one_sided_wear import fitted_side
from atleak.diagnosis.uncertainty.propagation import (
    DRAWS,
    DRAWS_OF_CIRCUITS,
    SEED,
    LandSpread,
    SpreadCache,
    TotalSpread,
    propagate,
)
from atleak.diagnosis.uncertainty.results import (
    AtCondition,
    InstantUncertainty,
    LandUncertainty,
    Shape,
    TotalUncertainty,
    UnitUncertainty,
)
from atleak.diagnosis.uncertainty.sources import PARTS, LandSources, RepeatSpread, find_sources
from atleak.diagnosis.uncertainty.wear import UnitWear
from atleak.engine.extremes import Instant
from atleak.engine.gap_messages import named_land
from atleak.engine.leakage import LeakageModel
from atleak.engine.projection import Projection
from atleak.equations.statistics import normal_quantile
from atleak.measurements.clearances import LandClearance
from atleak.measurements.readings import Readings

COVERAGE = 0.95
_OPEN = 0.49  # at most so likely is it that a land which has not surely grown draws too much because of its wear


def assess(
    model: LeakageModel,
    states: Sequence[LandClearance],
    projections: Sequence[Projection],
    rules: UnitRules,
    *,
    readings: Readings | None = None,
    instants: Mapping[Instant, Projection] = MappingProxyType({}),
    instruments: Instruments | None = None,
    assumptions: Assumptions = DEFAULTS,
    coverage: float = COVERAGE,
    guard_factor: float = GUARD_FACTOR,
    draws: int | None = None,
    seed: int = SEED,
    cache: SpreadCache | None = None,
) -> UnitUncertainty:
    """Carry the measurement uncertainty of a unit through the cube to every flow, the total and every decision.

    Parameters
    ----------
    projections
        the conditions that are judged, the stated one first.
    rules
        rules of the same states and projections, already judged; a decision is added to each.
    readings
        the measuring sheet of the clearances: planes, directions and repeats. Without it nothing was measured.
    instants
        instants of a road test whose intervals are wanted, each with its own pressures, temperature, gear and speed.
    instruments
        those with which the lands were measured; the catalogue's defaults unless given.
    assumptions
        all that is uncertain besides the readings.
    coverage
        probability of every interval; as much is left out below as above.
    guard_factor
        k of the guard band k·u around a limit; 1.645 leaves 5 % one-sided.
    draws, seed
        number of draws, rounded up to a power of two, and seed of the Monte Carlo; the same input gives the same
        digits. Unless given, `DRAWS`, or `DRAWS_OF_CIRCUITS` where pressures of circuits are solved.
    cache
        what was carried through before, with the same of everything but ``projections`` and ``instants``.

    Raises
    ------
    InputError
        coverage outside 0 … 1, a negative guard factor, fewer than 100 draws, or no condition.
    DomainError
        a condition's temperature outside the fluid's data.

    Notes
    -----
    The clearance is normal with the root sum of squares of its sources (linear in the diameters, so this is exact);
    its decisions and those on wear are closed forms. Flows, shares and growth are the draws'. The linear (GUM)
    propagation serves the budgets alone.

    References
    ----------
    JCGM 100:2008, JCGM 101:2008, JCGM 106:2012; ILAC-G8:09/2019.
    """
    if draws is None:
        solves = model.profile.circuits == "on" and any(circuit.feeds for circuit in model.controller.circuits)
        draws = DRAWS_OF_CIRCUITS if solves else DRAWS
    _check(projections, coverage, guard_factor, draws)
    draws = rounded_up(draws)
    instruments = instruments or load_instruments()
    sources, repeats = find_sources(states, readings, model.controller, instruments, assumptions)
    limits = rules.limits
    units, of_instants = propagate(
        model,
        sources,
        projections,
        assumptions,
        limits=limits,
        coverage=coverage,
        draws=draws,
        seed=seed,
        instants=tuple(instants.values()),
        cache=cache,
    )
    worn = UnitWear(sources, assumptions).past(limits.wear) if limits.wear else {}
    lands = tuple(
        _land(
            land, [unit.lands[number] for unit in units], projections, rules, coverage, guard_factor, worn.get(land.key)
        )
        for number, land in enumerate(sources)
    )
    totals = tuple(
        _total(projection, unit.total, rule, rules, guard_factor)
        for projection, unit, rule in zip(projections, units, rules.totals, strict=True)
    )
    return UnitUncertainty(
        lands=lands,
        totals=totals,
        instants={
            instant: _at_instant(instant, projection, *intervals)
            for (instant, projection), intervals in zip(instants.items(), of_instants, strict=True)
        },
        instruments=instruments,
        assumptions=assumptions,
        repeats=repeats,
        coverage=coverage,
        guard_factor=guard_factor,
        draws=draws,
        seed=seed,
        messages=(*_messages(sources, instruments, repeats, model), *_too_fine(lands)),
    )


def _check(projections: Sequence[Projection], coverage: float, guard_factor: float, draws: int) -> None:
    if not projections:
        raise InputError(Sentence("no condition to assess"), expected=Sentence("at least one projection"))
    if not 0.0 < coverage < 1.0:
        expected = Sentence("a number between 0 and 1, such as 0.95")
        raise InputError(Sentence("coverage not accepted"), value=coverage, expected=expected)
    if not (guard_factor >= 0.0 and math.isfinite(guard_factor)):
        expected = Sentence("0 or more, such as 1.645")
        raise InputError(Sentence("guard factor not accepted"), value=guard_factor, expected=expected)
    if draws < 100:
        raise InputError(Sentence("too few draws"), value=draws, expected=Sentence("at least 100, such as 8192"))


# --- one land


def _land(
    land: LandSources,
    land_spreads: Sequence[LandSpread],
    projections: Sequence[Projection],
    rules: UnitRules,
    coverage: float,
    guard_factor: float,
    worn: tuple[float, ...] | None,
) -> LandUncertainty:
    state = land.state
    if not state.measured:
        return LandUncertainty(land, None, None, None, (), (), _shape(state), guard_factor)
    u = land.standard_uncertainty
    z = float(normal_quantile(0.5 + 0.5 * coverage))
    reach, wear_reach = z * u, z * _wear_uncertainty(land, 1.0 + state.wear)
    c = state.radial_clearance
    conditions = tuple(
        _at(land, projection, spread) for projection, spread in zip(projections, land_spreads, strict=True)
    )
    spreads = {projection.condition: spread for projection, spread in zip(projections, land_spreads, strict=True)}
    decided = tuple(_decided(rule, land, spreads, rules.limits, guard_factor, worn) for rule in rules.of_land(land.key))
    # a true clearance cannot be below zero
    interval = (max(c - reach, min(c, 0.0)), c + reach)
    wear = state.wear - wear_reach, state.wear + wear_reach
    return LandUncertainty(land, u, interval, wear, conditions, decided, _shape(state), guard_factor)


def _decided(
    rule: Rule,
    land: LandSources,
    spreads: Mapping[OperatingPoint, LandSpread],
    limits: Limits,
    guard_factor: float,
    worn: tuple[float, ...] | None,
) -> RuleDecision:
    """Decide a land's rule: clearance and wear by closed forms, a share by the draws at its condition.

    ``worn``, of a land of whose new clearance a range is known: how likely each limit of wear is passed.
    """
    if rule.kind is RuleKind.PAIR_SHARE:
        assert rule.condition is not None
        share = spreads[rule.condition].share_spread
        likely = share.probabilities if land.grown else tuple(min(p, _OPEN) for p in share.probabilities)
        return decide_rule(rule, share.level_uncertainties, likely, guard_factor, skewed=True, interval=share.interval)
    if rule.kind is RuleKind.CLEARANCE:
        return decide_normal(rule, land.standard_uncertainty, guard_factor)
    us = _wear_uncertainties(land, limits)
    if worn is None:
        return decide_normal(rule, us, guard_factor)
    return decide_rule(rule, us, worn, guard_factor, skewed=True, by_value=True)


def _wear_uncertainties(land: LandSources, limits: Limits) -> tuple[float, ...]:
    """Return the standard uncertainty of wear at each limit.

    Wear over a limit Z means c_r − (1 + Z) c_m above zero, which is normal: no ratio of two uncertain values is needed.
    Over a limit in µm it means c_r − c_m above it.
    """
    pair, steps = land.state.land, limits.wear
    assert steps is not None
    stated = dict(steps.levels)
    applied = steps.of_wear(pair.mounting_high, pair.mounting_tolerance or 0.0)
    factors = (1.0 + (stated[level] if limit <= stated[level] else 0.0) for level, limit in applied)
    return tuple(_wear_uncertainty(land, factor) for factor in factors)


def _wear_uncertainty(land: LandSources, factor: float) -> float:
    """Return the standard uncertainty of c_r − factor · c_m, over c_m.

    From the upper end of a range wear is sure as far as c_r is.
    """
    pair = land.state.land
    u_mounting = 0.0 if isinstance(pair.mounting_clearance, tuple) else land.u_mounting
    return math.hypot(land.standard_uncertainty, factor * u_mounting) / pair.mounting_high


def _at(land: LandSources, projection: Projection, spread: LandSpread) -> AtCondition:
    gaps = projection.gaps_of(land.key)
    share = projection.share_drawn_by(land.key)
    of_clearance = (spread.slopes.share_per_clearance * land.standard_uncertainty) ** 2
    effects = {source.label: fraction * of_clearance for source, fraction in land.budget}
    effects |= {name: effect**2 for name, effect in spread.slopes.share_effects.items()}
    variance = math.fsum(effects.values())
    return AtCondition(
        condition=projection.condition.name,
        label=projection.condition.label,
        leakage=spread.slopes.leakage,
        u_leakage=spread.leakage_spread.standard_uncertainty,
        leakage_interval=spread.leakage_spread.interval,
        share=share,
        u_share=spread.share_spread.standard_uncertainty,
        share_interval=spread.share_spread.interval,
        eccentric=(sum(gap.concentric_leakage for gap in gaps), sum(gap.touching_leakage for gap in gaps)),
        budget=_fractions(effects),
        clearance_fraction=of_clearance / variance if variance > 0.0 and math.isfinite(variance) else 0.0,
    )


def _fractions(variances: dict[str, float]) -> tuple[tuple[str, float], ...]:
    total = math.fsum(variances.values())
    if not (total > 0.0 and math.isfinite(total)):
        return ()
    shares = [(name, variance / total) for name, variance in variances.items() if variance > 0.0]
    return tuple(sorted(shares, key=lambda item: -item[1]))


def _shape(state: LandClearance) -> Shape:
    square, third = state.form_moments
    mean = state.radial_clearance
    cube = mean**3 + 3.0 * mean * square + third
    open_ = min((station.radial_clearance for station in state.stations), default=mean) > 0.0
    return Shape(
        worst_direction=state.worst_direction,
        worst_clearance=state.max_clearance,
        effective_clearance=cube ** (1.0 / 3.0) if open_ else None,
        cube_factor=cube / mean**3 if open_ else None,
        lower_bound=_lower_bound(state),
    )


def _lower_bound(state: LandClearance) -> bool:
    """Return whether the sleeve was measured in one direction only: ovality needs two in one plane."""
    return state.leak is None and state.status in {"measured", "sleeve_only"} and state.sleeve_ovality is None


# --- the whole


def _total(
    projection: Projection, spread: TotalSpread, rule: Rule, rules: UnitRules, guard_factor: float
) -> TotalUncertainty:
    condition, share, bands = projection.condition, projection.share, rule.steps.levels
    u = spread.share_spread.standard_uncertainty
    us, probabilities = spread.share_spread.level_uncertainties, spread.share_spread.probabilities
    interval = spread.share_spread.interval
    decision = decide_rule(rule, us, probabilities, guard_factor, skewed=u > 0.0, interval=interval)
    names = (Band.GREEN, *(Band(band) for band, _ in bands))
    return TotalUncertainty(
        condition=condition.name,
        label=condition.label,
        leakage=projection.leakage,
        u_leakage=spread.leakage_spread.standard_uncertainty,
        leakage_interval=spread.leakage_spread.interval,
        share=share,
        u_share=u,
        share_interval=spread.share_spread.interval,
        minimum_speed_interval=spread.minimum_speed_interval,
        new_leakage_interval=spread.new_leakage_interval,
        growth_interval=spread.growth_interval,
        decision=decision,
        reserve_interval=spread.pressures.reserve,
        main_pressure_interval=spread.pressures.main_pressure,
        circuit_intervals=spread.pressures.circuits,
        pressures=tuple(
            _pressure_decision(each, spread.pressures, guard_factor)
            for each in rules.pressures
            if each.condition == condition
        ),
        band_probabilities=tuple(zip(names, spread.band_probabilities, strict=True)),
        budget=_fractions({name: effect**2 for name, effect in spread.effects.items()}),
    )


def _pressure_decision(rule: Rule, spread: PressureSpread, guard_factor: float) -> RuleDecision:
    """Decide a rule about the pump's reserve or a pressure by the draws, which follow no normal distribution."""
    drawn = spread.limited[rule.kind, rule.circuit.id if rule.circuit else None]
    skewed = drawn.standard_uncertainty > 0.0
    us, probabilities = drawn.level_uncertainties, drawn.probabilities
    return decide_rule(rule, us, probabilities, guard_factor, skewed=skewed, interval=drawn.interval)


def _at_instant(instant: Instant, projection: Projection, leakage: Interval, share: Interval) -> InstantUncertainty:
    """Return the intervals at an instant; those of a median are in proportion to those of the sample nearest to it."""

    def scaled(interval: Interval, value: float, nearest: float) -> Interval:
        factor = value / nearest if 0.0 < nearest < math.inf else 1.0
        return interval[0] * factor, interval[1] * factor

    of_share = None if instant.share is None else scaled(share, instant.share, projection.share)
    return InstantUncertainty(scaled(leakage, instant.leakage, projection.leakage), of_share)


_VALUES = {
    "resolution_um": Sentence("resolution"),
    "calibration_um": Sentence("uncertainty of its calibration"),
    "common_part": Sentence("part of it that all readings share"),
    "repeatability_um": Sentence("repeatability"),
    "expansion_per_k": Sentence("expansion of its scale or masters"),
}


def _messages(
    sources: Sequence[LandSources], instruments: Instruments, repeats: dict[Part, RepeatSpread], model: LeakageModel
) -> list[Message]:
    messages: list[Message] = []
    used = [part for part in PARTS if any(part in land.plans for land in sources)]
    for instrument in dict.fromkeys(instruments.of(part) for part in used):
        messages += instrument.doubts
        if instrument.representative:
            text = Sentence(
                "{instrument}: assumed, not from a certificate: {quantities}. Set your own instrument's.",
                instrument=Name(instrument.name),
                quantities=tuple(_VALUES[each] for each in instrument.representative),
            )
            messages.append(Message("info", "instrument_representative", text))
    for part in used:
        spread = repeats[part]
        if spread.degrees_of_freedom == 0:
            if spread.origin == "instrument":
                taken = Sentence(
                    "{spread:.2g} {spread.unit} is taken from the instrument",
                    spread=Quantity(spread.standard_deviation * UM, "clearance"),
                )
            else:
                taken = Sentence(
                    "the reading's step of {step:g} {step.unit} is taken instead",
                    step=Quantity(spread.resolution * UM, "clearance"),
                )
            if part == "spool":
                text = Sentence(
                    "No independent repeats of any spool: how far readings spread is not known, {taken}.", taken=taken
                )
            else:
                text = Sentence(
                    "No independent repeats of any sleeve: how far readings spread is not known, {taken}.", taken=taken
                )
            messages.append(Message("info", "no_independent_repeats", text))
    single = [land.state for land in sources if _lower_bound(land.state)]
    if single:
        text = Sentence(
            "Sleeve measured in one direction only, so the clearance is a lower bound: {lands}.",
            lands=tuple(named_land(state.land.key) for state in single),
        )
        messages.append(Message("warning", "clearance_lower_bound", text))
    assumed = [land for land in sources if land.grown and land.sees_sides and fitted_side(land) is None]
    if model.law.counts_form and any(land.assumptions.one_sided_wear for land in assumed):
        text = Sentence("Fewer than four directions: the shape of wear to one side is assumed. Four show it.")
        messages.append(Message("info", "wear_shape_assumed", text))
    missing = sum(not land.state.measured for land in sources)
    if missing < len(sources) and missing:
        text = Sentence(
            "{missing} of {lands} lands were not measured and are in the total at their mounting clearance.",
            missing=missing,
            lands=len(sources),
        )
        messages.append(Message("warning", "total_with_unmeasured", text))
    return messages


def _too_fine(lands: Sequence[LandUncertainty]) -> list[Message]:
    """Name the lands that are left open because their limit is finer than the gauges, with gauges that would do."""
    by_gauges = [land for land in lands if land.sources.state.leak_weight < 1.0]
    first = [(land, rule.at_first_level) for land in by_gauges for rule in land.rules]
    fine = [(land, rule) for land, rule in first if rule.conditional and not land.measurable(rule)]
    if not fine:
        return []
    names = tuple(dict.fromkeys(named_land(land.key) for land, _ in fine))
    land, rule = min(fine, key=lambda each: each[1].limit / each[1].standard_uncertainty)
    text = Sentence(
        "Not measurable with this gauge: a limit is finer than what the gauges can tell from a new pair at {lands}. "
        "{gauges}",
        lands=names,
        gauges=land.gauges_that_do(rule),
    )
    return [Message("info", "limit_finer_than_gauge", text)]
