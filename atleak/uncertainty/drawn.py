"""Evaluate one operating condition, and a unit in it, for whole arrays of what is uncertain there."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import Any

import numpy as np

from atleak.catalogue.controller import REFERENCE_TEMPERATURE, Gap
from atleak.catalogue.pump import Pump
from atleak.catalogue.section_pressures import SECTIONS
from atleak.engine.balance import Balance
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
from atleak.uncertainty.sources import LandSources
from atleak.uncertainty.spread import flow_ratio

_LOWEST_EFFICIENCY = 0.01  # volumetric; lower draws are raised to it


class Condition:
    """One operating condition, evaluated for whole arrays of the uncertain factors."""

    def __init__(self, model: LeakageModel, projection: Projection, assumptions: Assumptions) -> None:
        self.model, self.point, self.assumptions = model, projection.condition, assumptions
        self.gaps: dict[tuple[str, int], list[tuple[Gap, bool]]] = {}
        for gap_leakage in projection.gaps:
            self.gaps.setdefault(gap_leakage.gap.key, []).append((gap_leakage.gap, gap_leakage.drawn_from_pump))

    def at(self, deviates: dict[str, Any]) -> Drawn:
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
        now = model.controller.pump
        pumps = [self._pump(pump, deviates["pump efficiency"]) for pump in dict.fromkeys([now, now.new])]
        rise = temperature - REFERENCE_TEMPERATURE
        return Drawn(self, rise, nu, rho, pressures, pumps[0], pumps[-1])

    def _pump(self, pump: Pump, deviate: Any) -> PumpFlow:
        """Return a pump whose slip, or else its efficiency, is uncertain."""
        model, u = self.model, self.assumptions
        if model.uses_slip:
            at = self.point.main_pressure, model.dynamic_viscosity(self.point.temperature)
            spread = math.hypot(u.slip_coefficient, pump.relative_uncertainty(u.pump_clearance, *at))
            return PumpFlow(pump, True, np.exp(spread * deviate))
        efficiency = pump.volumetric_efficiency + u.volumetric_efficiency * deviate
        return PumpFlow(replace(pump, volumetric_efficiency=np.clip(efficiency, _LOWEST_EFFICIENCY, 1.0)), False)


def leakiest(lands: Sequence[LandSources], projection: Projection) -> LandSources:
    """Return the land that draws most from the pump as measured."""
    return max(lands, key=lambda land: projection.drawn_by(land.key))


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


class Drawn:
    """A condition with its uncertain factors drawn; arrays of shape (draws,)."""

    def __init__(
        self,
        condition: Condition,
        rise: Any,
        nu: Any,
        rho: Any,
        pressures: dict[str, Any],
        pump: PumpFlow,
        new_pump: PumpFlow,
        solved: frozenset[str] = frozenset(),
        restrictions: Mapping[Any, Restricted] = MappingProxyType({}),
    ) -> None:
        self.solved = solved  # the circuits whose pressure follows from a balance
        self.restrictions = restrictions  # of the lands of which circuits needed them already, by their keys
        self.condition, self.rise, self.nu, self.rho = condition, rise, nu, rho
        self.pressures, self.pump, self.new_pump = pressures, pump, new_pump
        self.viscosity = dynamic_viscosity(nu, rho)
        self.capacity = pump.capacity(condition.point.engine_speed, pressures["p_g"], self.viscosity)
        self._drops: dict[Any, Any] = {}

    def with_circuits(
        self,
        lands: Iterable[LandInState],
        *,
        keep: bool = True,
        changed: Callable[[Network], Network] = lambda network: network,
    ) -> tuple[Drawn, Network, Balance]:
        """Return the same with the pressures that the circuits hold where the lands are as given.

        Each land comes with its bore, its contact length and where its spool lies; ``keep`` says that `leakage` will be
        asked for with the same, and ``changed`` returns the network with feeds and leaks as they are drawn.
        """
        model, point = self.condition.model, self.condition.point
        restrictions: dict[Any, Restricted] = {}
        gaps = []
        for land, bore, length, position in lands:
            touching = [each for each in self.condition.gaps.get(land.state.land.key, ()) if _touches_circuit(each[0])]
            if touching:
                restriction = self._restriction(land, bore, length, position)
                restrictions[land.state.land.key] = restriction
                gaps += [(gap, restriction, counts) for gap, counts in touching]
        solves = model.profile.circuits == "on"
        network = changed(circuit_network(model.controller, point, gaps, self.nu, self.rho, solves=solves))
        balance = network.balance(self.pressures)
        if not network.has_circuits:
            return self, network, balance
        parts = self.rise, self.nu, self.rho, dict(balance.pressures), self.pump, self.new_pump
        return Drawn(self.condition, *parts, network.solved, restrictions if keep else {}), network, balance

    def _restriction(self, land: LandSources, bore: Bore, length: Any, position: Any) -> Restricted:
        """Return what all gaps of a land have in common."""
        law = self.condition.model.law
        mean = effective_clearance(bore.clearance, land.thermal_rate, self.rise)
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
        conductance = self._restriction(land, bore, state.land.contact_length, None).conductance
        return flow_ratio(conductance * self.pressures["p_g"], self.capacity)

    def drop(self, gap: Gap) -> Any:
        """Return the pressure drop [Pa]; a negative one that leaks nothing is given as zero."""
        key = gap.high, gap.low
        if key not in self._drops:
            drop = gap.high.at(self.pressures) - gap.low.at(self.pressures)
            self._drops[key] = drop if leaks_both_ways(gap, self.solved) else np.maximum(drop, 0.0)
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
        restriction = self.restrictions.get(state.land.key)
        if restriction is None:
            restriction = self._restriction(land, bore, length, position)
        if not self.condition.model.law.linear:
            flows = [restriction.flow(self.drop(gap)) for gap, _ in gaps]
            flow = sum(flows)
            drawn_flows = [flow for flow, (_, counts) in zip(flows, gaps, strict=True) if counts]
            if len(drawn_flows) == len(flows):
                return flow, flow
            return flow, sum(drawn_flows) if drawn_flows else np.zeros_like(flow)
        drops = sum(self.drop(gap) for gap, _ in gaps)
        drawn_gaps = [gap for gap, counts in gaps if counts]
        flow = restriction.conductance * drops
        if len(drawn_gaps) == len(gaps):
            return flow, flow
        drawn_drops = sum(self.drop(gap) for gap in drawn_gaps)
        return flow, restriction.conductance * drawn_drops if drawn_gaps else np.zeros_like(flow)

    def leakages(self, lands: Sequence[LandSources], bore: Bore, lengths: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return what `leakage` does for all lands at once, shapes (lands, columns); so are their bores and lengths."""
        law = self.condition.model.law
        shape = bore.clearance.shape
        rates, diameters = np.array([(land.thermal_rate, land.state.spool_diameter) for land in lands]).reshape(-1, 2).T
        mean = effective_clearance(bore.clearance, rates[:, None], self.rise)
        clearance = law.flow_clearance(mean, bore.square, bore.cube)
        restriction = law.restriction(law.diameter(diameters[:, None], mean), clearance, self.nu, self.rho, lengths)
        ways = [(row, *way) for row, land in enumerate(lands) for way in self.condition.gaps.get(land.key, ())]
        rows = [row for row, _, _ in ways]
        conductance, bend = (np.broadcast_to(each, shape)[rows] for each in (restriction.conductance, restriction.bend))
        drops = np.array([np.broadcast_to(self.drop(gap), shape[1:]) for _, gap, _ in ways]).reshape(-1, *shape[1:])
        flow, drawn = np.zeros(shape), np.zeros(shape)
        for (row, _, counts), through in zip(ways, Restricted(conductance, bend).flow(drops), strict=True):
            flow[row] += through
            if counts:
                drawn[row] += through
        return flow, drawn
