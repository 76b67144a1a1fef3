"""What truly leaks from a simulated unit: the gap law written out once more, with true fluid, pressures and pump.

Of a unit with circuits the engine solves the pressures, with clearances at which its gaps pass what that law says.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from atleak.catalogue.controller import Controller
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.operating_point import OperatingPoint
from atleak.diagnosis.uncertainty import Assumptions
from atleak.engine.leakage import LeakageModel
from atleak.engine.profile import WORKSHOP
from atleak.engine.projection import project
from atleak.measurements.clearances import clearances
from simulated.pairs import Pair

LandKey = tuple[str, int]
ROUNDS = 8  # in which clearances and pressures come to agree
ENTRY_AND_EXIT = 1.5  # velocity heads lost at a sharp-edged entrance (0.5) and at the exit (1)


@dataclass(frozen=True)
class TrueFlows:
    """The true flows at one operating point."""

    leakage: dict[LandKey, float]  # [m³/s] of each land
    drawn: dict[LandKey, float]  # [m³/s] what of that is drawn from the pump
    capacity: float  # [m³/s] of the pump
    beside: float = 0.0  # [m³/s] drawn by what is no land
    pressures: dict[str, float] = field(default_factory=dict)  # [Pa] that each fed circuit holds

    def share(self, key: LandKey) -> float:
        """Return what one land takes of the pump's flow, as a fraction."""
        return self.drawn[key] / self.capacity

    @property
    def total(self) -> float:
        """Return what leaves the pump [m³/s]."""
        return math.fsum(self.drawn.values()) + self.beside


@dataclass(frozen=True)
class Circumstances:
    """How fluid, pressures and pump of a unit differ from what is stated: each in its standard uncertainty."""

    temperature: float
    viscosity: float
    main: float
    converter: float
    slip: float

    @classmethod
    def draw(cls, rng: np.random.Generator) -> Circumstances:
        """Draw each from a standard normal distribution."""
        return cls(*rng.normal(size=5).tolist())


def true_flows(
    pairs: Sequence[Pair],
    controller: Controller,
    fluid: Fluid,
    point: OperatingPoint,
    by: Circumstances,
    u: Assumptions,
) -> TrueFlows:
    """Compute the flows of the true unit at one operating point.

    Parameters
    ----------
    controller
        which has the gaps between the pressures, their relations and the pump.
    by, u
        the differences from the stated circumstances, and what one of them is worth.
    """
    temperature = point.temperature + u.temperature * by.temperature
    mu = fluid.kinematic_viscosity(temperature) * fluid.density(temperature) * math.exp(u.viscosity * by.viscosity)
    main = point.main_pressure * (1.0 + u.main_pressure * by.main)
    converter = point.converter_pressure * (1.0 + u.converter_pressure * by.converter)
    pressures = controller.section_pressures(main, converter)
    by_key = {pair.land.key: pair for pair in pairs}
    leakage, drawn = dict.fromkeys(by_key, 0.0), dict.fromkeys(by_key, 0.0)
    for gap in controller.gaps_in(point.gear):
        pair = by_key[gap.key]
        high, low = (
            end.coefficient * float(pressures[end.section]) if end.section else 0.0 for end in (gap.high, gap.low)
        )
        flow = _gap_flow(pair, max(high - low, 0.0), mu, fluid.density(temperature), temperature)
        leakage[gap.key] += flow
        drawn[gap.key] += flow if gap.into_sump else 0.0
    pump = controller.pump
    slip = (pump.slip_coefficient or 0.0) * math.exp(u.slip_coefficient * by.slip)
    capacity = pump.displacement * (point.engine_speed - slip * main / (2.0 * math.pi * mu))
    return TrueFlows(leakage, drawn, capacity)


def flows_in_circuits(
    pairs: Sequence[Pair],
    controller: Controller,
    fluid: Fluid,
    point: OperatingPoint,
    by: Circumstances,
    u: Assumptions,
) -> TrueFlows:
    """Compute the flows of a true unit with circuits, and what these hold; parameters as of `true_flows`."""
    thicker, setting = math.exp(u.viscosity * by.viscosity), 1.0 + u.main_pressure * by.main
    points = tuple((at, nu * thicker) for at, nu in fluid.points)
    fluid = replace(fluid, points=points, table=tuple((at, nu * thicker, rho) for at, nu, rho in fluid.table))
    slip, line = controller.pump.slip_coefficient, controller.line
    pump = replace(controller.pump, slip_coefficient=slip and slip * math.exp(u.slip_coefficient * by.slip))
    if line is not None and line.following is not None:
        follows = line.following
        follows = replace(follows, ratio=follows.ratio * setting, offset=follows.offset * setting)
        line = replace(line, following=follows)
    controller = replace(controller, pump=pump, line=line)
    at = replace(
        point,
        temperature=point.temperature + u.temperature * by.temperature,
        main_pressure=point.main_pressure * setting,
        converter_pressure=point.converter_pressure * (1.0 + u.converter_pressure * by.converter),
    )
    rho = float(fluid.density(at.temperature))
    mu = float(fluid.kinematic_viscosity(at.temperature)) * rho
    by_key = {pair.land.key: pair for pair in pairs}
    states = {
        state.land.key: replace(
            state,
            radial_clearance=by_key[state.land.key].clearance,
            land=replace(state.land, contact_length=by_key[state.land.key].length),
        )
        for state in clearances(None, controller)
    }
    for _ in range(ROUNDS):
        found = project(LeakageModel(controller, tuple(states.values()), fluid, WORKSHOP), at)
        for gap in sorted(found.gaps, key=lambda each: each.leakage):  # of several gaps of a land the largest counts
            if gap.leakage > 0.0:
                state = states[gap.gap.key]
                ratio = _gap_flow(by_key[gap.gap.key], gap.pressure_drop, mu, rho, at.temperature) / gap.leakage
                states[gap.gap.key] = replace(state, radial_clearance=state.radial_clearance * ratio ** (1.0 / 3.0))
    leakage, drawn = defaultdict[LandKey, float](float), defaultdict[LandKey, float](float)
    for gap in found.gaps:
        leakage[gap.gap.key] += gap.leakage
        drawn[gap.gap.key] += gap.leakage if gap.drawn_from_pump else 0.0
    held = {each.circuit.id: each.pressure for each in found.circuits if each.circuit.feeds}
    return TrueFlows(leakage, drawn, found.pump_capacity, found.leakage - math.fsum(drawn.values()), held)


def _gap_flow(pair: Pair, drop: float, mu: float, density: float, temperature: float) -> float:
    """Compute the flow of one gap [m³/s], strip by strip around the spool.

    In each strip the velocity w takes 12 μ l w / c² for friction and K ρ w² / 2 to enter and leave the gap.
    """
    land = pair.land
    sleeve = pair.spool + 2.0 * pair.clearance
    widened = 0.5 * (land.body_expansion * sleeve - land.spool_expansion * pair.spool) * (temperature - 20.0)
    c = pair.around(widened)
    friction = 12.0 * mu * pair.length
    velocity = 2.0 * drop * c**2 / (friction + np.sqrt(friction**2 + 2.0 * ENTRY_AND_EXIT * density * drop * c**4))
    return math.pi * (pair.spool + pair.clearance + widened) * float(np.mean(velocity * c))
