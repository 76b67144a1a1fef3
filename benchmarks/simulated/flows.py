"""What truly leaks from a simulated unit: the gap law written out once more, with true fluid, pressures and pump."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from atleak.catalogue.controller import Controller
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.operating_point import OperatingPoint
from atleak.diagnosis.uncertainty import Assumptions
from simulated.pairs import Pair

LandKey = tuple[str, int]
ENTRY_AND_EXIT = 1.5  # velocity heads lost at a sharp-edged entrance (0.5) and at the exit (1)


@dataclass(frozen=True)
class TrueFlows:
    """The true flows at one operating point."""

    leakage: dict[LandKey, float]  # [m³/s] of each land
    drawn: dict[LandKey, float]  # [m³/s] what of that is drawn from the pump
    capacity: float  # [m³/s] of the pump

    def share(self, key: LandKey) -> float:
        """Return what one land takes of the pump's flow, as a fraction."""
        return self.drawn[key] / self.capacity

    @property
    def total(self) -> float:
        """Return what all lands draw from the pump [m³/s]."""
        return math.fsum(self.drawn.values())


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
