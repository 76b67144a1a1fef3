"""Evaluate one operating condition, and a unit in it, for whole arrays of what is uncertain there."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from copy import copy
from dataclasses import replace
from typing import Any

import numpy as np

from atleak.catalogue.controller import REFERENCE_TEMPERATURE, Gap
from atleak.catalogue.pump import Pump
from atleak.catalogue.section_pressures import SECTIONS
from atleak.engine.circuits import Network
from atleak.engine.circuits import network as circuit_network
from atleak.engine.leakage import LeakageModel, PumpFlow
from atleak.engine.projection import Projection
from atleak.engine.restrictions import Gap as Restricted
from atleak.engine.restrictions import leaks_both_ways
from atleak.equations.clearance import effective_clearance
from atleak.equations.fluid import dynamic_viscosity
from atleak.equations.uncertainty import rectangular
from atleak.uncertainty.assumptions import Assumptions
from atleak.uncertainty.draws import FLUID_STATE, Bore, LandInState, with_one_side
from atleak.uncertainty.pressures import DrawnUnit
from atleak.uncertainty.sources import LandSources
from atleak.uncertainty.spread import flow_ratio

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
        nu = nu * np.exp(u.viscosity * deviates["viscosity"])
        if model.fluid.viscosity_half_width:
            nu = nu * (1.0 + rectangular(model.fluid.viscosity_half_width) * deviates[FLUID_STATE])
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
        return law.restriction(diameter, clearance, self.nu, self.rho, length, position)

    def score(self, land: LandSources, common: Mapping[str, np.ndarray], fraction: np.ndarray) -> np.ndarray:
        """Return how much a land would draw by what it shares with others, all that is its own as it was measured.

        ``common`` and ``fraction`` are the shared errors and the part of the wear that lies to one side. The number is
        in proportion to a share of the pump's flow where the land's pressure follows that of the line.
        """
        state = land.state
        mean = np.maximum(state.radial_clearance + sum(u * common[name] for name, u in land.groups.items()), 0.0)
        wear = fraction * np.maximum(mean - state.land.new_clearance, 0.0)
        bore = Bore(mean, *with_one_side(wear, *state.form_moments))
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
