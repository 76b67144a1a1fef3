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
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np

from atleak.catalogue.controller import REFERENCE_TEMPERATURE, Gap
from atleak.catalogue.limits import Limits, Steps
from atleak.catalogue.section_pressures import SECTIONS
from atleak.engine.circuits import Balance, Network, leaks_both_ways
from atleak.engine.circuits import network as circuit_network
from atleak.engine.leakage import LeakageModel, PumpFlow
from atleak.engine.line import consumed
from atleak.engine.projection import Projection
from atleak.equations.clearance import effective_clearance
from atleak.equations.fluid import dynamic_viscosity
from atleak.equations.uncertainty import rectangular
from atleak.uncertainty.assumptions import Assumptions
from atleak.uncertainty.draws import (
    Bore,
    Positions,
    measured_clearance,
    new_bore,
    rectangular_draws,
    unworn_bore,
    with_one_side,
    worn_bore,
)
from atleak.uncertainty.pressures import DrawnUnit, PressureSpread, pressure_spread
from atleak.uncertainty.sources import MEASURING_TEMPERATURE, LandSources
from atleak.uncertainty.spread import Spread, interval_of, spread_of

SEED = 7667
DRAWS = 20_000

_SMALL = 0.01  # step of the numerical derivatives in the budget, as a fraction of a standard uncertainty
_LOWEST_EFFICIENCY = 0.01  # volumetric; lower draws are raised to it
_SHORTEST = 0.1  # fraction of the nominal contact length; shorter draws are raised to it

ONE_SIDE, POSITION = "wear to one side", "where the spool lies"  # names in the budgets
_NORMAL_FACTORS = ("viscosity", "temperature", "main pressure", "converter pressure", "pump efficiency")
FLUID_STATE = "viscosity of the used fluid"  # rectangular; only where the fluid has no data of its own used state
FACTORS = (*_NORMAL_FACTORS, FLUID_STATE)


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


class _Condition:
    """One operating condition, evaluated for whole arrays of the uncertain factors."""

    def __init__(self, model: LeakageModel, projection: Projection, assumptions: Assumptions) -> None:
        self.model, self.point, self.assumptions = model, projection.condition, assumptions
        self.gaps: dict[tuple[str, int], list[tuple[Gap, bool]]] = {}
        for gap_leakage in projection.gaps:
            self.gaps.setdefault(gap_leakage.gap.key, []).append((gap_leakage.gap, gap_leakage.drawn_from_pump))

    def at(self, deviates: dict[str, Any]) -> _Drawn:
        """Return fluid, pressures and pump at given standard deviates of `FACTORS`."""
        model, point, u = self.model, self.point, self.assumptions
        temperature = point.temperature + u.temperature * deviates["temperature"]
        nu, rho = _fluid_at(model, temperature)
        nu = nu * np.exp(u.viscosity * deviates["viscosity"])
        if model.fluid.viscosity_half_width:
            nu = nu * (1.0 + rectangular(model.fluid.viscosity_half_width) * deviates[FLUID_STATE])
        main = point.main_pressure * np.maximum(1.0 + u.main_pressure * deviates["main pressure"], 0.0)
        converter = point.converter_pressure * np.maximum(
            1.0 + u.converter_pressure * deviates["converter pressure"], 0.0
        )
        pressures: dict[str, Any] = model.controller.section_pressures(main, converter)
        pump = model.controller.pump
        if model.uses_slip:
            coefficient = pump.slip_coefficient * np.exp(u.slip_coefficient * deviates["pump efficiency"])
            pump = replace(pump, slip_coefficient=coefficient)
        else:
            efficiency = pump.volumetric_efficiency + u.volumetric_efficiency * deviates["pump efficiency"]
            pump = replace(pump, volumetric_efficiency=np.clip(efficiency, _LOWEST_EFFICIENCY, 1.0))
        rise = temperature - REFERENCE_TEMPERATURE
        return _Drawn(self, rise, nu, rho, pressures, PumpFlow(pump, model.uses_slip))


def _touches_circuit(gap: Gap) -> bool:
    """Return whether a gap leads from or to a circuit."""
    return any(end.section is not None and end.section not in SECTIONS for end in (gap.high, gap.low))


def _fluid_at(model: LeakageModel, temperature: Any) -> tuple[Any, Any]:
    """Return ν and ρ at a temperature [°C].

    A draw beyond the end of the fluid's data follows the slope of ln ν and of ρ over the last kelvin.
    """
    fluid, kind = model.fluid, model.profile.viscosity
    low, high = fluid.span(kind)
    inside = np.clip(temperature, low, high)
    nu, rho = fluid.kinematic_viscosity(inside, kind), fluid.density(inside, kind)
    beyond = temperature - inside
    if np.any(beyond):
        ends = np.array([low, low + 1.0, high - 1.0, high])
        ln_nu, densities = np.log(fluid.kinematic_viscosity(ends, kind)), fluid.density(ends, kind)
        nu = nu * np.exp(beyond * np.where(beyond < 0.0, ln_nu[1] - ln_nu[0], ln_nu[3] - ln_nu[2]))
        rho = rho + beyond * np.where(beyond < 0.0, densities[1] - densities[0], densities[3] - densities[2])
    return nu, rho


class _Drawn:
    """A condition with its uncertain factors drawn; arrays of shape (draws,)."""

    def __init__(
        self,
        condition: _Condition,
        rise: Any,
        nu: Any,
        rho: Any,
        pressures: dict[str, Any],
        pump: PumpFlow,
        solved: frozenset[str] = frozenset(),
    ) -> None:
        self.solved = solved  # the circuits whose pressure follows from a balance
        self.condition, self.rise, self.nu, self.rho = condition, rise, nu, rho
        self.pressures, self.pump = pressures, pump
        self.viscosity = dynamic_viscosity(nu, rho)
        self.capacity = pump.capacity(condition.point.engine_speed, pressures["p_g"], self.viscosity)
        self._drops: dict[Any, Any] = {}

    def with_circuits(self, lands: Iterable[tuple[LandSources, Bore, Any, Any]]) -> tuple[_Drawn, Network, Balance]:
        """Return the same with the pressures that the circuits hold where the lands are as given.

        Each land comes with its bore, its contact length and where its spool lies.
        """
        model, point = self.condition.model, self.condition.point
        law, gaps = model.law, []
        for land, bore, length, position in lands:
            touching = [each for each in self.condition.gaps.get(land.state.land.key, ()) if _touches_circuit(each[0])]
            if touching:
                mean = effective_clearance(bore.clearance, land.thermal_rate, self.rise)
                c = law.flow_clearance(mean, bore.square, bore.cube)
                factors = law.diameter(land.state.spool_diameter, mean), c, self.nu, self.rho, length, position
                gaps += [(gap, law.restriction(*factors), counts) for gap, counts in touching]
        solves = model.profile.circuits == "on"
        network = circuit_network(model.controller, point, gaps, self.nu, self.rho, solves=solves)
        balance = network.balance(self.pressures)
        if not network.has_circuits:
            return self, network, balance
        parts = self.rise, self.nu, self.rho, dict(balance.pressures), self.pump
        return _Drawn(self.condition, *parts, network.solved), network, balance

    def drop(self, gap: Gap) -> Any:
        """Return the pressure drop [Pa]; a negative one that leaks nothing is given as zero."""
        key = gap.high, gap.low
        if key not in self._drops:
            drop = gap.high.at(self.pressures) - gap.low.at(self.pressures)
            self._drops[key] = drop if leaks_both_ways(gap, self.solved) else np.maximum(drop, 0.0)
        return self._drops[key]

    def driving(self, gaps: Sequence[Gap]) -> Any:
        """Return the sum of the pressure drops, divided by the dynamic viscosity [1/s]."""
        key = tuple((gap.high, gap.low) for gap in gaps)
        if key not in self._drops:
            self._drops[key] = sum(self.drop(gap) for gap in gaps) / self.viscosity
        return self._drops[key]

    def leakage(self, land: LandSources, bore: Bore, length: Any, position: Any = None) -> tuple[Any, Any]:
        """Return the flow of one land through all its gaps, and the part of it drawn from the pump [m³/s].

        ``position`` takes the place of the profile's factor for an eccentric spool.
        A clearance below zero cannot exist: it is taken as zero and leaks nothing.
        """
        state = land.state
        gaps = self.condition.gaps.get(state.land.key)
        if not gaps:
            nothing = np.zeros_like(self.viscosity)
            return nothing, nothing
        law = self.condition.model.law
        mean = effective_clearance(bore.clearance, land.thermal_rate, self.rise)
        c, d = law.flow_clearance(mean, bore.square, bore.cube), law.diameter(state.spool_diameter, mean)
        if not law.linear:
            flows = [law.flow(self.drop(gap), d, c, self.nu, self.rho, length, position) for gap, _ in gaps]
            flow = sum(flows)
            drawn_flows = [flow for flow, (_, counts) in zip(flows, gaps, strict=True) if counts]
            return flow, sum(drawn_flows) if drawn_flows else np.zeros_like(flow)
        geometry = law.flow(1.0, d, c, 1.0, 1.0, length, position)  # for a pressure drop over viscosity of one
        flow = geometry * self.driving([gap for gap, _ in gaps])
        drawn_gaps = [gap for gap, counts in gaps if counts]
        if len(drawn_gaps) == len(gaps):
            return flow, flow
        return flow, geometry * self.driving(drawn_gaps) if drawn_gaps else np.zeros_like(flow)


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
    shared = np.random.Generator(np.random.PCG64(np.random.SeedSequence((seed, 0))))
    deviates = {name: shared.standard_normal(draws) for name in _NORMAL_FACTORS}
    deviates[FLUID_STATE] = rectangular_draws(np.random.Generator(np.random.PCG64((seed, 3))), draws)
    names = sorted({group for land in sources for group in land.groups})
    common = {
        name: rectangular_draws(shared, draws) if name == MEASURING_TEMPERATURE else shared.standard_normal(draws)
        for name in names
    }
    # of all wear, how much lies to one side of the bores; the cube of the mean clearance knows no sides
    most = assumptions.one_sided_wear if model.law.counts_form else 0.0
    fraction = 0.5 * most * shared.integers(3, size=draws)
    positions = Positions(model, draws, seed)
    conditions = [_Condition(model, projection, assumptions) for projection in projections]
    drawn = [condition.at(deviates) for condition in conditions]
    probes = [condition.at(_probe_deviates()) for condition in conditions]
    at_instants = [_Condition(model, instant, assumptions).at(deviates) for instant in instants]
    instant_totals = [np.zeros(draws) for _ in instants]
    lands: list[_LandDraws] = []
    for number, land in enumerate(sources):
        stream = np.random.Generator(np.random.PCG64(np.random.SeedSequence((seed, 1, number))))
        lands.append(_land_draws(stream, land, common, fraction, assumptions, positions.of(land)))
    for now, total in zip(at_instants, instant_totals, strict=True):
        solved, network, balance = now.with_circuits(each.now for each in lands)
        total += network.beside_lands(balance)
        for each in lands:
            total += solved.leakage(*each.now)[1]
    by_condition = [
        _at_condition(model, projection, now, probe, lands, assumptions, positions.relative_spread, limits, coverage)
        for projection, now, probe in zip(projections, drawn, probes, strict=True)
    ]
    return Propagated(
        [tuple(spreads[number] for spreads, _ in by_condition) for number in range(len(lands))],
        [total for _, total in by_condition],
        [
            InstantSpread(interval_of(total, coverage), interval_of(_ratio(total, now.capacity), coverage))
            for now, total in zip(at_instants, instant_totals, strict=True)
        ],
    )


@dataclass(frozen=True)
class _LandDraws:
    """What is not known of one land, drawn: its bore now, new and unworn, its contact length, where its spool lies."""

    land: LandSources
    bore: Bore
    new_bore: Bore
    unworn_bore: Bore
    length: Any
    position: Any

    @property
    def now(self) -> tuple[LandSources, Bore, Any, Any]:
        return self.land, self.bore, self.length, self.position

    @property
    def new(self) -> tuple[LandSources, Bore, Any, Any]:
        return self.land, self.new_bore, self.length, self.position

    @property
    def unworn(self) -> tuple[LandSources, Bore, Any, Any]:
        return self.land, self.unworn_bore, self.length, self.position


def _land_draws(
    stream: np.random.Generator,
    land: LandSources,
    common: dict[str, np.ndarray],
    fraction: np.ndarray,
    assumptions: Assumptions,
    position: Any,
) -> _LandDraws:
    draws = fraction.size
    new = new_bore(stream, land, draws)
    # what was not measured is as new: the same in every trial
    bore = unworn = new
    if land.state.measured:
        measured = measured_clearance(stream, land, common, new.clearance)
        bore = worn_bore(stream, land, measured, new.clearance, fraction)
        unworn = unworn_bore(land, measured, new)
    nominal = land.state.land.contact_length
    length: float | np.ndarray = nominal
    if assumptions.contact_length:
        lengths = stream.standard_normal(draws)
        lengths *= assumptions.contact_length
        lengths += nominal
        length = np.maximum(lengths, _SHORTEST * nominal, out=lengths)
    return _LandDraws(land, bore, new, unworn, length, position)


def _at_condition(
    model: LeakageModel,
    projection: Projection,
    drawn: _Drawn,
    probe: _Drawn,
    lands: Sequence[_LandDraws],
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
    probe, probe_network, probe_balance = probe.with_circuits(_as_measured(each) for each in lands)
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
        shares = _ratio(drawn_flow, now.capacity), _ratio(unworn_flow, now.capacity)
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
        DrawnUnit(each, at, leakage, drawn.pressures, drawn.pump, drawn.viscosity)
        for each, at, leakage in ((network, balance, total), (unworn_network, unworn_balance, unworn_total))
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


def _as_measured(draws: _LandDraws) -> tuple[LandSources, Bore, Any, Any]:
    """Return a land as its readings have it: the budget changes one land at a time, at the same circuit pressures."""
    state = draws.land.state
    return draws.land, Bore(state.radial_clearance, *state.form_moments), state.land.contact_length, None


# --- what the draws say


def _ratio(flow: np.ndarray, capacity: Any) -> np.ndarray:
    """Return the share of the pump's flow; infinite where the pump delivers nothing."""
    with np.errstate(divide="ignore", invalid="ignore"):
        share = flow / capacity
    return np.where(np.isnan(share), np.inf, share) if np.any(np.equal(capacity, 0.0)) else share


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


def _probe(probe: _Drawn, land: LandSources, assumptions: Assumptions, position: float) -> _Slopes:
    state = land.state
    step = _SMALL * (land.standard_uncertainty or 1e-7)
    clearance = np.full(_PROBES, state.radial_clearance)
    length = np.full(_PROBES, state.land.contact_length)
    clearance[-5] += step
    clearance[-4] -= step
    length[-3] += _SMALL * assumptions.contact_length
    length[-2] -= _SMALL * assumptions.contact_length
    bore = Bore(clearance, *_one_side_probes(probe.condition.model, land, assumptions))
    flow, drawn_flow = probe.leakage(land, bore, length)
    share = _ratio(drawn_flow, probe.capacity)

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
    now: _Drawn,
    probe: _Drawn,
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
    share_spread = _share_spread(_ratio(total, now.capacity), _ratio(unworn_total, now.capacity), steps, coverage)
    # a band counts as reached where a worse one is
    over = (1.0, *np.maximum.accumulate(share_spread.probabilities[::-1])[::-1].tolist(), 0.0)
    probe_share = _ratio(probe_total, probe.capacity)
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
        growth_interval=interval_of(_ratio(total, new_total) - 1.0, coverage),
        pressures=pressures,
        effects=effects,
    )
