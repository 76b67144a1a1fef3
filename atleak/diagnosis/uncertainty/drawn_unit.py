"""Evaluate a unit at one operating condition for whole arrays of draws: pump, line pressure and every circuit."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from atleak.catalogue.circuits import SECTIONS
from atleak.catalogue.controller import REFERENCE_TEMPERATURE, Gap
from atleak.catalogue.limits import Limits, RuleKind
from atleak.catalogue.operating_point import OperatingPoint
from atleak.catalogue.pump import Pump
from atleak.diagnosis.rules import permissible_steps
from atleak.diagnosis.uncertainty.assumptions import Assumptions
from atleak.diagnosis.uncertainty.draws import DrawnSpread, Draws, Interval, flow_ratio, interval_of, spread_of
from atleak.diagnosis.uncertainty.land_draws import LandInState
from atleak.diagnosis.uncertainty.one_sided_wear import Bore, OneSided, with_one_side
from atleak.diagnosis.uncertainty.sources import LandSources
from atleak.engine.balance import Balance
from atleak.engine.leakage import LeakageModel, PumpFlow
from atleak.engine.network import Network
from atleak.engine.network import network as circuit_network
from atleak.engine.operation import consumed, fall_to_set_pressure, sections_held, spread_over
from atleak.engine.projection import Projection
from atleak.engine.restrictions import GapBranch as Restricted
from atleak.engine.restrictions import leaks_both_ways
from atleak.equations.clearance import effective_clearance
from atleak.equations.fluid import dynamic_viscosity

NORMAL_FACTORS = ("viscosity", "temperature", "main pressure", "converter pressure", "pump efficiency")
FLUID_STATE = "range of the fluid's viscosity"  # rectangular: of one without data of its own used state, or assumed
FACTORS = (*NORMAL_FACTORS, FLUID_STATE)
_GRID = np.linspace(0.0, 1.0, 17)  # fractions of the required pressure at which the demand is worked out
_HALVINGS = 40  # of the pressure that holds


@dataclass(frozen=True)
class PressureSpread:
    """The spread of the pump's reserve and of every pressure at one condition."""

    reserve: Interval
    main_pressure: Interval  # [Pa] that holds of what is required, however well that is known
    circuits: Mapping[str, Interval]  # [Pa] that each holds, by id; without those that are vented
    #: of what a rule limits, by its kind and circuit: the reserve, how far main pressure is below the permissible, and
    #: what a circuit has lost or gained against the same unit unworn
    limited: Mapping[tuple[RuleKind, str | None], DrawnSpread]


def deviates_of_factors(shared: Draws) -> dict[str, np.ndarray]:
    """Draw the standard deviates of `FACTORS`."""
    deviates = {name: shared.normal() for name in NORMAL_FACTORS}
    deviates[FLUID_STATE] = shared.rectangular()
    return deviates


@dataclass(frozen=True)
class DrawnUnit:
    """One unit with its uncertain factors drawn, at one condition; arrays of shape (draws,)."""

    network: Network
    balance: Balance  # at the required line pressure
    leakage: np.ndarray  # [m³/s] drawn from the pump
    pressures: Mapping[str, Any]  # [Pa] of the sections at the required line pressure
    pump: PumpFlow
    viscosity: Any  # [Pa·s]

    @property
    def demand(self) -> Any:
        """Return all that leaves the pump, its own slip included [m³/s]."""
        required = self.pressures["p_g"]
        slip = self.pump.slip(required, self.viscosity)
        return self.leakage + slip + consumed(self.network, required, required)

    def reserve(self, point: OperatingPoint) -> np.ndarray:
        """Return the pump's supply over it."""
        with np.errstate(divide="ignore"):
            return np.divide(self.pump.per_revolution * point.engine_speed, self.demand)

    def left(self, point: OperatingPoint) -> Any:
        """Return what the line leaves to what is fed behind its regulator [m³/s]; below zero where it falls."""
        required = self.pressures["p_g"]
        before = self.leakage + consumed(self.network, required, required, after_line=False)
        return self.pump.capacity(point.engine_speed, required, self.viscosity) - before

    def held(self, demand: DemandShape) -> tuple[np.ndarray, Mapping[str, Any]]:
        """Return the line pressure that holds, and all pressures with it [Pa], at the condition of a demand.

        How a demand falls with the pressure is taken from the unit as measured for every draw.
        """
        point = demand.point
        main = spread_over(self.pressures["p_g"], self.leakage.shape)
        converter = self.pressures["p_k"]
        if not self.network.solves:
            return main, self.balance.pressures

        def lacking(fraction: Any, left: Any) -> Any:
            supply = self.pump.capacity(point.engine_speed, fraction * main, self.viscosity)
            before_line = consumed(self.network, fraction * main, main, after_line=False)
            return self.leakage * left + before_line - supply

        held, falls = main, lacking(1.0, 1.0) > 0.0
        if falls.any():
            low, high = np.zeros_like(main), np.ones_like(main)
            for _ in range(_HALVINGS):
                middle = 0.5 * (low + high)
                over = lacking(middle, np.interp(middle, _GRID, demand.left)) > 0.0
                low, high = np.where(over, low, middle), np.where(over, middle, high)
            held = np.where(falls, low * main, main)

        def at(main: Any, near: Balance) -> Balance:
            return self.network.balance(sections_held(self.network.controller, main, converter), near)

        balance, line = at(held, self.balance) if falls.any() else self.balance, self.network.controller.line
        if line is not None and line.following is not None:
            # what the line is set to is as uncertain as what is required
            factor = main / point.main_pressure
            held, balance, _ = fall_to_set_pressure(line, point, held, balance, at, factor)
        return held, balance.pressures


@dataclass(frozen=True)
class DemandShape:
    """How the leakage of a unit as measured falls with the line pressure at one condition."""

    model: LeakageModel
    point: OperatingPoint

    @cached_property
    def left(self) -> np.ndarray:
        """Return the part of it that is left at each fraction of the required line pressure in `_GRID`."""
        network = self.model.network(self.point)
        pressures = _GRID * self.point.main_pressure, self.point.converter_pressure
        balance = network.balance(sections_held(self.model.controller, *pressures))
        drawn = np.broadcast_to(network.drawn_from_pump(balance), _GRID.shape)
        return drawn / drawn[-1] if drawn[-1] > 0.0 else _GRID


def pressure_spread(
    projection: Projection,
    model: LeakageModel,
    now: DrawnUnit,
    unworn: DrawnUnit,
    limits: Limits,
    coverage: float,
) -> PressureSpread:
    """Return the spread of reserve and pressures of a unit, judged beside the same unit unworn, draw by draw.

    Parameters
    ----------
    projection
        the unit as measured, at the condition of the draws.
    limits
        whose probabilities of having been reached are wanted.
    """
    point, steps = projection.condition, limits.reserve
    reserve, when_unworn = now.reserve(point), unworn.reserve(point)
    reached: Sequence[Any] = [limit for _, limit in steps.under(when_unworn)] if steps else ()
    of_reserve = spread_of(reserve, reached, coverage, falling=True)
    limited: dict[tuple[RuleKind, str | None], DrawnSpread] = {(RuleKind.RESERVE, None): of_reserve}
    demand = DemandShape(model, point)
    main, pressures = now.held(demand)
    _, pressures_unworn = unworn.held(demand)
    below = _below(projection, main, now.pressures["p_g"], limits, coverage)
    if below is not None:
        limited[RuleKind.PERMISSIBLE_PRESSURE, None] = below
    losses = [limit for _, limit in limits.circuit_loss.levels] if limits.circuit_loss else []
    circuits = {}
    for name in (state.circuit.id for state in projection.circuits if not state.vented):
        pressure, before = (spread_over(each[name], main.shape) for each in (pressures, pressures_unworn))
        circuits[name] = interval_of(pressure, coverage)
        limited[RuleKind.CIRCUIT_LOSS, name] = spread_of(np.abs(before - pressure), losses, coverage)
    main_pressure = interval_of(main / now.pressures["p_g"] * point.main_pressure, coverage)
    return PressureSpread(of_reserve.interval, main_pressure, circuits, limited)


def _below(
    projection: Projection, main: np.ndarray, required: Any, limits: Limits, coverage: float
) -> DrawnSpread | None:
    """Return how far the line pressure that holds is below the permissible.

    What is required is required: how well it is known does not count, only how much of it holds.
    """
    permissible = projection.permissible
    steps = None if permissible is None else permissible_steps(permissible, limits)
    if permissible is None or permissible.low is None or steps is None:
        return None
    stated = projection.condition.main_pressure
    below = 1.0 - main / required * stated / max(min(permissible.low, stated), 1.0)
    tiny = 1e-9  # a pressure that equals the permissible is not below it
    return spread_of(below, [max(limit, tiny) for _, limit in steps.levels], coverage)


_GIVEN = {None, *SECTIONS}  # pressures that no circuit holds
_LOWEST_EFFICIENCY = 0.01  # volumetric; lower draws are raised to it


class Drawn:
    """One operating condition with fluid, pressures and pump drawn; arrays of shape (draws,)."""

    def __init__(
        self, model: LeakageModel, projection: Projection, assumptions: Assumptions, deviates: Mapping[str, Any]
    ) -> None:
        """Draw a condition at given standard deviates of `FACTORS`."""
        self.model, self.point, self._assumptions, u = model, projection.condition, assumptions, assumptions
        self.gaps: dict[tuple[str, int], list[tuple[Gap, bool]]] = {}  # of each land, and whether they count
        for each in projection.gaps:
            self.gaps.setdefault(each.gap.key, []).append((each.gap, each.drawn_from_pump))
        temperature = self.point.temperature + u.temperature * deviates["temperature"]
        self.rise = temperature - REFERENCE_TEMPERATURE
        nu, self.rho = _fluid_at(model, temperature)
        nu = nu * np.exp(u.viscosity * deviates["viscosity"]) * model.fluid.viscosity_factor(deviates[FLUID_STATE])
        self.nu, self.viscosity = nu, dynamic_viscosity(nu, self.rho)
        main = self.point.main_pressure * np.maximum(1.0 + u.main_pressure * deviates["main pressure"], 0.0)
        converter = self.point.converter_pressure * np.maximum(
            1.0 + u.converter_pressure * deviates["converter pressure"], 0.0
        )
        self.pressures: dict[str, Any] = model.controller.section_pressures(main, converter)
        now = model.controller.pump
        pumps = [self._pump(pump, deviates["pump efficiency"]) for pump in dict.fromkeys([now, now.new])]
        self.pump, self.new_pump = pumps[0], pumps[-1]
        self.capacity = self.pump.capacity(self.point.engine_speed, main, self.viscosity)

    def _pump(self, pump: Pump, deviate: Any) -> PumpFlow:
        """Return a pump whose slip, or else its efficiency, is uncertain."""
        model, u = self.model, self._assumptions
        if model.uses_slip:
            at = self.point.main_pressure, model.dynamic_viscosity(self.point.temperature)
            spread = math.hypot(u.slip_coefficient, pump.relative_uncertainty(u.pump_clearance, *at))
            return PumpFlow(pump, True, np.exp(spread * deviate))
        efficiency = pump.volumetric_efficiency + u.volumetric_efficiency * deviate
        return PumpFlow(replace(pump, volumetric_efficiency=np.clip(efficiency, _LOWEST_EFFICIENCY, 1.0)), False)

    def restriction(self, land: LandSources, bore: Bore, length: Any, position: Any) -> Restricted:
        """Return what all gaps of a land have in common."""
        law = self.model.law
        mean = effective_clearance(bore.clearance, land.state.thermal_rate, self.rise)
        clearance = law.flow_clearance(mean, bore.square, bore.cube)
        diameter = law.diameter(land.state.spool_diameter, mean)
        gap = law.restriction(diameter, clearance, self.nu, self.rho, length, position)
        return gap if np.ndim(bore.entry_loss) == 0 else Restricted(gap.conductance, gap.bend * bore.entry_loss)

    def score(self, land: LandSources, common: Mapping[str, np.ndarray], one_sided: OneSided) -> np.ndarray:
        """Return how much a land would draw by what it shares with others, all that is its own as it was measured.

        ``common`` and ``one_sided`` are the shared errors and the wear that lies to one side. The number is in
        proportion to a share of the pump's flow where the land's pressure follows that of the line.
        """
        state = land.state
        mean = np.maximum(state.radial_clearance + sum(u * common[name] for name, u in land.groups.items()), 0.0)
        wear = one_sided.fraction * np.maximum(mean - state.land.new_clearance, 0.0)
        bore = Bore(mean, *with_one_side(one_sided.moments(wear), *state.form_moments))
        conductance = self.restriction(land, bore, state.land.contact_length, None).conductance
        return flow_ratio(conductance * self.pressures["p_g"], self.capacity)


class DrawnLands:
    """The lands of a unit in one state at a drawn condition, at the pressures that its circuits hold then."""

    def __init__(
        self,
        given: Drawn,
        lands: Iterable[LandInState],
        changed: Callable[[Network], Network] = lambda network: network,
    ) -> None:
        """Solve the circuits; ``changed`` returns the network with feeds and leaks as they are drawn."""
        self.given = given
        self._restrictions: dict[Any, Restricted] = {}  # of the lands of which the circuits need them
        gaps = []
        for land, *state in lands:
            ways = given.gaps.get(land.key, ())
            touching = [each for each in ways if {each[0].high.section, each[0].low.section} - _GIVEN]
            if touching:
                self._restrictions[land.key] = restriction = given.restriction(land, *state)
                gaps += [(gap, restriction, counts) for gap, counts in touching]
        model, solves = given.model, given.model.profile.circuits == "on"
        self.network = changed(circuit_network(model.controller, given.point, gaps, given.nu, given.rho, solves=solves))
        self.balance = self.network.balance(given.pressures)
        self._drops: dict[Any, Any] = {}
        #: [m³/s] drawn from the pump by all that is counted so far: at first by what no land leaks
        self.leakage = np.zeros(given.viscosity.shape) + self.network.beside_lands(self.balance)

    def copy(self) -> DrawnLands:
        """Return the same, with lands to be counted on their own."""
        other = copy(self)
        other.leakage = self.leakage.copy()
        return other

    @property
    def share(self) -> np.ndarray:
        """Return it as a share of the pump's flow."""
        return flow_ratio(self.leakage, self.given.capacity)

    def count(self, *land: Any) -> tuple[Any, Any]:
        """Count a land; return its flow, and the part of it that is drawn from the pump [m³/s]."""
        flow, drawn = self.flow(*land)
        self.leakage += drawn
        return flow, drawn

    def unit(self, pump: PumpFlow | None = None) -> DrawnUnit:
        """Return the unit with all that was counted, with another pump than the present one if given."""
        given = self.given
        of_pump = pump or given.pump
        return DrawnUnit(self.network, self.balance, self.leakage, given.pressures, of_pump, given.viscosity)

    def _drop(self, gap: Gap) -> Any:
        """Return the pressure drop [Pa]; a negative one that leaks nothing is given as zero."""
        key, pressures = (gap.high, gap.low), self.balance.pressures
        if key not in self._drops:
            drop = gap.high.at(pressures) - gap.low.at(pressures)
            self._drops[key] = drop if leaks_both_ways(gap, self.network.solved) else np.maximum(drop, 0.0)
        return self._drops[key]

    def flow(self, land: LandSources, bore: Bore, length: Any, position: Any) -> tuple[Any, Any]:
        """Return the flow of one land through all its gaps, and the part of it drawn from the pump [m³/s].

        A clearance below zero cannot exist: it is taken as zero and leaks nothing.
        """
        gaps = self.given.gaps.get(land.key)
        if not gaps:
            nothing = np.zeros_like(self.given.viscosity)
            return nothing, nothing
        restriction = self._restrictions.get(land.key) or self.given.restriction(land, bore, length, position)
        drops = [self._drop(gap) for gap, _ in gaps]
        linear = self.given.model.law.linear  # then the drops are added up first
        parts = drops if linear else [restriction.flow(drop) for drop in drops]
        flow = sum(parts)
        counted = [part for part, (_, counts) in zip(parts, gaps, strict=True) if counts]
        drawn = flow if len(counted) == len(parts) else sum(counted) if counted else np.zeros_like(flow)
        if not linear:
            return flow, drawn
        flow = restriction.conductance * flow
        return flow, flow if len(counted) == len(parts) else restriction.conductance * drawn

    def more_than(self, now: LandInState, new: LandInState) -> Any:
        """Return what a land leaks in one state more than in the other, at the same pressures [m³/s]."""
        drops = [self._drop(gap) for gap, _ in self.given.gaps.get(now[0].key, ())]
        flows = [sum(map(self.given.restriction(*each).flow, drops)) for each in (now, new)]
        return np.zeros_like(self.given.viscosity) + flows[0] - flows[1]

    def flows(self, lands: Sequence[LandSources], bore: Bore, lengths: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return what `count` does for all lands at once, shapes (lands, columns); so are their bores and lengths."""
        given, law, shape = self.given, self.given.model.law, bore.clearance.shape
        rates, diameters = (
            np.array([(land.state.thermal_rate, land.state.spool_diameter) for land in lands]).reshape(-1, 2).T
        )
        mean = effective_clearance(bore.clearance, rates[:, None], given.rise)
        clearance = law.flow_clearance(mean, bore.square, bore.cube)
        restriction = law.restriction(law.diameter(diameters[:, None], mean), clearance, given.nu, given.rho, lengths)
        ways = [(row, *way) for row, land in enumerate(lands) for way in given.gaps.get(land.key, ())]
        rows = [row for row, _, _ in ways]
        conductance, bend = (np.broadcast_to(each, shape)[rows] for each in (restriction.conductance, restriction.bend))
        drops = np.array([np.broadcast_to(self._drop(gap), shape[1:]) for _, gap, _ in ways]).reshape(-1, *shape[1:])
        flow, drawn = np.zeros(shape), np.zeros(shape)
        for (row, _, counts), through in zip(ways, Restricted(conductance, bend).flow(drops), strict=True):
            flow[row] += through
            if counts:
                drawn[row] += through
        return flow, drawn


def leakiest(lands: Sequence[LandSources], projection: Projection) -> LandSources:
    """Return the land that draws most from the pump as measured."""
    return max(lands, key=lambda land: projection.drawn_by(land.key))


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
