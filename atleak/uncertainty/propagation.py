"""Carry uncertain clearances, fluid, pressures and pump into the spread of every flow and of the total.

This is the Monte Carlo method of JCGM 101. An error that lands share is drawn once per trial and used for all of them.
What a share has grown by is judged against the same unit unworn in the same trial: with the same fluid, pressures, pump
and contact lengths, and with mounting clearances drawn from what is known of them. Where only a range or a type's value
is known, a land is unworn as far as its reading may be that of a new pair.

A bore wears to one side, which two-point diameters cannot see: by how much is one fraction of all wear, drawn once per
trial for the whole unit, with a phase of its own for each land. Where nobody knows how the spools lie, e/c is drawn for
each component, the same for its lands now and new.

The circuits' pressures are solved in every trial: a land that leaks more in it finds less pressure before it.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from atleak.catalogue.limits import Limits, Steps
from atleak.engine.leakage import LeakageModel
from atleak.engine.line import consumed
from atleak.engine.projection import Projection
from atleak.uncertainty.assumptions import Assumptions
from atleak.uncertainty.drawn import Condition, Drawn, leakiest
from atleak.uncertainty.draws import (
    FACTORS,
    Bore,
    LandDraws,
    Positions,
    common_errors,
    deviates_of_factors,
    land_draws,
    one_sided_fraction,
    with_one_side,
)
from atleak.uncertainty.points import Beside, Cube, Draws, rounded_up
from atleak.uncertainty.pressures import DrawnUnit, PressureSpread, pressure_spread
from atleak.uncertainty.sources import LandSources
from atleak.uncertainty.spread import Spread, flow_ratio, interval_of, spread_of

SEED = 7667
DRAWS = 8_192
DRAWS_OF_CIRCUITS = 8_192  # of a unit with circuits, whose pressures are solved anew in every one

_SMALL = 0.01  # step of the numerical derivatives in the budget, as a fraction of a standard uncertainty

ONE_SIDE, POSITION = "wear to one side", "where the spool lies"  # names in the budgets


@dataclass(frozen=True)
class LandSpread:
    """The leakage of one land at one condition and its spread; the derivative serves the linear budget."""

    leakage: float  # [m³/s] at the values as measured
    leakage_spread: Spread
    share_spread: Spread
    share_per_clearance: float  # [1/m]
    share_effects: dict[str, float]  # change of the share for one standard uncertainty


@dataclass(frozen=True)
class TotalSpread:
    """The leakage of the whole controller at one condition, and its spread."""

    leakage_spread: Spread
    share_spread: Spread
    minimum_speed_interval: tuple[float, float]  # [1/s]
    band_probabilities: tuple[float, ...]  # below the first limit, between, above the last
    new_leakage_interval: tuple[float, float]  # [m³/s] of the same unit new
    growth_interval: tuple[float, float]  # of the leakage over that of the same unit new
    pressures: PressureSpread
    effects: dict[str, float]  # change of the share for one standard uncertainty of each source


@dataclass(frozen=True)
class InstantSpread:
    """The intervals of the whole controller's leakage [m³/s] and share at one instant of a log."""

    leakage_interval: tuple[float, float]
    share_interval: tuple[float, float]


@dataclass
class Propagated:
    """The spread of every land and of the total, at each condition in the order given; of the instants' totals."""

    lands: list[tuple[LandSpread, ...]]
    totals: list[TotalSpread]
    instants: list[InstantSpread]


def propagate(
    model: LeakageModel,
    sources: Sequence[LandSources],
    projections: Sequence[Projection],
    assumptions: Assumptions,
    *,
    limits: Limits,
    coverage: float,
    draws: int,
    seed: int,
    instants: Sequence[Projection] = (),
) -> Propagated:
    """Carry every uncertainty through the gap law.

    Parameters
    ----------
    limits
        of shares, reserve and pressures: the probability of having reached each is computed, growth against the same
        land or unit new included.
    coverage
        probability of the intervals, 0 … 1; they leave out as much below as above.
    draws, seed
        number of draws and seed of the Monte Carlo. Each land has its own stream of PCG64: the same input gives the
        same digits.
    instants
        conditions of which only the total's interval is wanted: those of some instants of a log.

    Raises
    ------
    DomainError
        A condition's temperature outside the fluid's data.
    """
    draws = rounded_up(draws)
    shared = Draws(Cube(draws, seed, 0))
    deviates = deviates_of_factors(shared)
    common = common_errors(shared, sources)
    fraction = one_sided_fraction(shared, model, assumptions)
    conditions = [Condition(model, projection, assumptions) for projection in projections]
    drawn = [condition.at(deviates) for condition in conditions]
    probes = [condition.at(_probe_deviates()) for condition in conditions]
    at_instants = [Condition(model, instant, assumptions).at(deviates) for instant in instants]
    own = Beside(Cube(draws, seed, 3), drawn[0].score(leakiest(sources, projections[0]), common, fraction))
    positions = Positions(model, own, seed)
    instant_totals = [np.zeros(draws) for _ in instants]
    lands = [
        land_draws(own.draws(seed, 1, number), land, common, fraction, assumptions, positions.of(land))
        for number, land in enumerate(sources)
    ]
    for now, total in zip(at_instants, instant_totals, strict=True):
        solved, network, balance = now.with_circuits(each.now for each in lands)
        total += network.beside_lands(balance)
        for each in lands:
            total += solved.leakage(*each.now)[1]

    def spreads_at(number: int) -> tuple[list[LandSpread], TotalSpread]:
        each = projections[number], drawn[number], probes[number]
        return _at_condition(model, *each, lands, assumptions, positions.relative_spread, limits, coverage)

    by_condition = [spreads_at(number) for number in range(len(projections))]
    return Propagated(
        [tuple(spreads[number] for spreads, _ in by_condition) for number in range(len(lands))],
        [total for _, total in by_condition],
        [
            InstantSpread(interval_of(total, coverage), interval_of(flow_ratio(total, now.capacity), coverage))
            for now, total in zip(at_instants, instant_totals, strict=True)
        ],
    )


def _at_condition(
    model: LeakageModel,
    projection: Projection,
    drawn: Drawn,
    probe: Drawn,
    lands: Sequence[LandDraws],
    assumptions: Assumptions,
    relative_spread: float,
    limits: Limits,
    coverage: float,
) -> tuple[list[LandSpread], TotalSpread]:
    """Return the spread of every land and of the total at one condition."""
    draws = lands[0].bore.clearance.size if lands else 1
    now, network, balance = drawn.with_circuits(each.now for each in lands)
    new, new_network, new_balance = drawn.with_circuits(each.new for each in lands)
    same = all(each.unworn_bore is each.new_bore for each in lands)
    unworn, unworn_network, unworn_balance = (
        (new, new_network, new_balance) if same else drawn.with_circuits(each.unworn for each in lands)
    )
    probe, probe_network, probe_balance = probe.with_circuits((_as_measured(each) for each in lands), keep=False)
    total, new_total, unworn_total = (
        np.full(draws, 0.0) + each.beside_lands(at)
        for each, at in ((network, balance), (new_network, new_balance), (unworn_network, unworn_balance))
    )
    probe_total = np.zeros(_PROBES) + probe_network.beside_lands(probe_balance)
    variance = 0.0  # of the total, from errors that no land shares
    group_slopes: dict[str, float] = defaultdict(float)
    by_component: dict[str, float] = defaultdict(float)  # drawn, as measured
    spreads = []
    for each in lands:
        land = each.land
        flow, drawn_flow = now.leakage(*each.now)
        as_new = new is now and each.bore is each.new_bore
        new_flow = drawn_flow if as_new else new.leakage(*each.new)[1]
        as_unworn = unworn is new and each.unworn_bore is each.new_bore
        unworn_flow = new_flow if as_unworn else unworn.leakage(*each.unworn)[1]
        total += drawn_flow
        new_total += new_flow
        unworn_total += unworn_flow
        slopes = _probe(probe, land, assumptions, relative_spread)
        by_component[land.key[0]] += float(slopes.counted_probe[-1])
        shares = flow_ratio(drawn_flow, now.capacity), flow_ratio(unworn_flow, now.capacity)
        spreads.append(
            LandSpread(
                leakage=slopes.leakage,
                leakage_spread=spread_of(flow, (), coverage),
                share_spread=_share_spread(*shares, limits.pair_share, coverage),
                share_per_clearance=slopes.share_per_clearance,
                share_effects=slopes.share_effects,
            )
        )
        probe_total += slopes.counted_probe
        variance += slopes.counted_per_clearance**2 * land.own_variance
        variance += slopes.counted_length_effect**2
        for name, u in land.groups.items():
            group_slopes[name] += slopes.counted_per_clearance * u
    measured_unit, unworn_unit = (
        DrawnUnit(each, at, leakage, drawn.pressures, pump, drawn.viscosity)
        for each, at, leakage, pump in (
            (network, balance, total, drawn.pump),
            (unworn_network, unworn_balance, unworn_total, drawn.new_pump),
        )
    )
    return spreads, _total(
        now,
        probe,
        total,
        new_total,
        unworn_total,
        probe_total,
        variance,
        relative_spread * math.hypot(*by_component.values()),
        group_slopes,
        limits.total_share,
        coverage,
        pressure_spread(projection, model, measured_unit, unworn_unit, limits, coverage),
    )


def _as_measured(draws: LandDraws) -> tuple[LandSources, Bore, Any, Any]:
    """Return a land as its readings have it: the budget changes one land at a time, at the same circuit pressures."""
    state = draws.land.state
    return draws.land, Bore(state.radial_clearance, *state.form_moments), state.land.contact_length, None


# --- what the draws say


def _share_spread(share: np.ndarray, unworn: np.ndarray, steps: Steps | None, coverage: float) -> Spread:
    """Return the spread of a share, and how likely it has reached each limit beside that of an unworn land or unit."""
    return spread_of(share, [limit for _, limit in steps.over(unworn)] if steps else (), coverage)


# --- the linear budget: one factor is changed at a time, by central differences

#: Two per factor, two of the wear to one side, two of the clearance, two of the contact length, one as it is.
_PROBES = 2 * len(FACTORS) + 7


def _probe_deviates() -> dict[str, np.ndarray]:
    deviates = {}
    for number, name in enumerate(FACTORS):
        column = np.zeros(_PROBES)
        column[2 * number], column[2 * number + 1] = _SMALL, -_SMALL
        deviates[name] = column
    return deviates


@dataclass(frozen=True)
class _Slopes:
    leakage: float
    share_per_clearance: float
    share_effects: dict[str, float]
    counted_probe: np.ndarray
    counted_per_clearance: float
    counted_length_effect: float


def _probe(probe: Drawn, land: LandSources, assumptions: Assumptions, position: float) -> _Slopes:
    state = land.state
    step = _SMALL * (land.standard_uncertainty or 1e-7)
    clearance = np.full(_PROBES, state.radial_clearance)
    length = np.full(_PROBES, state.land.contact_length)
    clearance[-5] += step
    clearance[-4] -= step
    uncertain = assumptions.of_contact_length(measured=state.land.contact_length_measured)
    length[-3] += _SMALL * uncertain
    length[-2] -= _SMALL * uncertain
    bore = Bore(clearance, *_one_side_probes(probe.condition.model, land, assumptions))
    flow, drawn_flow = probe.leakage(land, bore, length)
    share = flow_ratio(drawn_flow, probe.capacity)

    def effects(values: np.ndarray) -> dict[str, float]:
        by_factor = {name: _difference(values, 2 * number) / _SMALL for number, name in enumerate(FACTORS)}
        by_factor["contact length"] = _difference(values, -3) / _SMALL
        by_factor[ONE_SIDE] = _one_side_effect(values)
        by_factor[POSITION] = position * float(values[-1])
        return by_factor

    counted_effects = effects(drawn_flow)
    return _Slopes(
        leakage=float(flow[-1]),
        share_per_clearance=_difference(share, -5) / step,
        share_effects=effects(share),
        counted_probe=drawn_flow,
        counted_per_clearance=_difference(drawn_flow, -5) / step,
        counted_length_effect=counted_effects["contact length"],
    )


def _one_side_probes(model: LeakageModel, land: LandSources, assumptions: Assumptions) -> tuple[np.ndarray, np.ndarray]:
    """Return the moments of each probe: as measured, and with half and all of the wear to one side."""
    square, cube = land.state.form_moments
    squares, cubes = np.full(_PROBES, square), np.full(_PROBES, cube)
    if model.law.counts_form and "sleeve" in land.plans:
        shown = max(land.state.radial_clearance - land.state.land.new_clearance, 0.0)
        for place, part in ((-7, 0.5), (-6, 1.0)):
            squares[place], cubes[place] = with_one_side(part * assumptions.one_sided_wear * shown, square, cube)
    return squares, cubes


def _one_side_effect(values: np.ndarray) -> float:
    """Return the standard deviation over none, half and all of the wear to one side, all three alike likely."""
    three = values[[-1, -7, -6]]
    return float(three.std()) if np.isfinite(three).all() else math.nan


def _difference(values: np.ndarray, index: int) -> float:
    first, second = float(values[index]), float(values[index + 1])
    return 0.5 * (first - second) if math.isfinite(first) and math.isfinite(second) else math.nan


def _total(
    now: Drawn,
    probe: Drawn,
    total: np.ndarray,
    new_total: np.ndarray,
    unworn_total: np.ndarray,
    probe_total: np.ndarray,
    own_variance: float,
    position: float,
    group_slopes: dict[str, float],
    steps: Steps,
    coverage: float,
    pressures: PressureSpread,
) -> TotalSpread:
    share_spread = _share_spread(
        flow_ratio(total, now.capacity), flow_ratio(unworn_total, now.capacity), steps, coverage
    )
    # a band counts as reached where a worse one is
    over = (1.0, *np.maximum.accumulate(share_spread.probabilities[::-1])[::-1].tolist(), 0.0)
    probe_share = flow_ratio(probe_total, probe.capacity)
    capacity = float(probe.capacity[-1]) if np.ndim(probe.capacity) else float(probe.capacity)
    per_flow = 1.0 / capacity if capacity > 0.0 else math.nan
    effects = {name: _difference(probe_share, 2 * number) / _SMALL for number, name in enumerate(FACTORS)}
    effects["each land's own readings and contact length"] = math.sqrt(own_variance) * per_flow
    effects[ONE_SIDE] = _one_side_effect(probe_share)
    effects[POSITION] = position * per_flow
    effects |= {f"common to all lands: {name}": slope * per_flow for name, slope in group_slopes.items()}
    consumers = consumed(now.condition.model.controller, now.condition.point)
    speed = now.pump.minimum_speed(total + consumers, now.pressures["p_g"], now.viscosity)
    return TotalSpread(
        leakage_spread=spread_of(total, (), coverage),
        share_spread=share_spread,
        minimum_speed_interval=interval_of(speed, coverage),
        band_probabilities=tuple(max(a - b, 0.0) for a, b in pairwise(over)),
        new_leakage_interval=interval_of(new_total, coverage),
        growth_interval=interval_of(flow_ratio(total, new_total) - 1.0, coverage),
        pressures=pressures,
        effects=effects,
    )
