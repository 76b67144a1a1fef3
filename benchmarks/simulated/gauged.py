"""Units with circuits that wear, and gauges that are read on them while the vehicle stands: their truth in full.

A true unit is a valve body's file with its own numbers put in, solved as one unit by the engine: worn lands, leaking
seals, a pump that slips more, feeds, a line setting and a fluid that differ from what the file states. How much parts
are worn differs from unit to unit, which nothing that judges the readings knows.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Literal

import numpy as np

from atleak.catalogue.circuits import Leak, Pressure
from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.fluid import Fluid, load_fluid
from atleak.catalogue.operating_point import OperatingPoint
from atleak.catalogue.repairs import LandKey
from atleak.engine.leakage import LeakageModel
from atleak.engine.profile import WORKSHOP
from atleak.engine.projection import project
from atleak.measurements.clearances import clearances
from atleak.measurements.gauge_readings import LINE_TAP, Engine, GaugeCell, GaugeReading, PressureTable

Gauges = Literal["each reading", "each tap", "one"]  # what errs alike
WORN = 0.2  # of the lands
MEAN_WEAR = 9e-6, 15e-6  # [m] of the worn lands of a unit, exponential; no land more than `MOST_WEAR`
MOST_WEAR = 60e-6
WORN_SEALS, SEAL_FLOW = 0.05, 1.5e-5  # of clutches and bands; [m³/s] at line pressure, exponential
WORN_PUMPS, PUMP_SLIP = 0.2, 1.5  # slip grows by up to so much
VISCOSITY, TEMPERATURE, SLIP, FEED = 0.05, 3.0, 0.2, 0.02  # one standard deviation


@dataclass(frozen=True)
class Faults:
    """What is wrong with a unit; what it does not name is as when new."""

    wear: Mapping[LandKey, float] = field(default_factory=dict)  # [m]
    seals: Mapping[str, float] = field(default_factory=dict)  # [m³/s] out of a clutch or band at 900 kPa
    slip: float = 1.0  # of the pump, over that when new
    fall: float = 0.0  # of the line, held down by its regulator
    most_speed: float = math.inf  # [1/s] beyond which a blocked filter lets the pump deliver no more


@dataclass(frozen=True)
class TrueUnit:
    """A true unit as it is and new, and how its truth differs from an operating point of the file."""

    now: LeakageModel
    new: LeakageModel
    setting: float  # factor on what the line is set to
    warmer: float  # [K]
    faults: Faults

    def at(self, point: OperatingPoint, *, new: bool = False) -> OperatingPoint:
        """Return what an operating point truly is, or would be without regulator or filter at fault."""
        held, most = (1.0, math.inf) if new else (1.0 - self.faults.fall, self.faults.most_speed)
        return replace(
            point,
            temperature=point.temperature + self.warmer,
            main_pressure=point.main_pressure * self.setting * held,
            engine_speed=min(point.engine_speed, most),
        )

    def held(self, point: OperatingPoint, tap: str, *, new: bool = False) -> float:
        """Return what a tap truly holds at an operating point of the file, or held when new [Pa]."""
        projection = project(self.new if new else self.now, self.at(point, new=new))
        return projection.main_pressure_held if tap == LINE_TAP else projection.circuit(tap).pressure


@dataclass(frozen=True)
class Tapped:
    """A simulated unit: what every tap truly holds and has lost [Pa], and a table of what gauges showed."""

    held: dict[GaugeCell, float]
    lost: dict[GaugeCell, float]
    table: PressureTable

    @property
    def worst(self) -> dict[str, float]:
        """Return the largest true loss of every circuit at the cells of the table [Pa]."""
        circuits = dict.fromkeys(cell.tap for cell in self.lost if cell.tap != LINE_TAP)
        return {tap: max(loss for cell, loss in self.lost.items() if cell.tap == tap) for tap in circuits}


@cache
def file_of(unit: str) -> tuple[Controller, Fluid]:
    """Return a shipped valve body, and the fluid that is in it."""
    return load_controller(unit), load_fluid("hipol_atf_iid")


def cells_of(controller: Controller) -> dict[GaugeCell, OperatingPoint]:
    """Return line and applied clutches in reverse and drive, at idle and stall, as far as the file has such points."""
    cells: dict[GaugeCell, OperatingPoint] = {}
    gears = sorted(gear for gear in controller.gears if gear > 0)[:1], [-1]
    for selected, (gear,) in zip(("D", "R"), gears, strict=True):
        for state, engine in (("idle", Engine.SLOW_IDLE), ("stall", Engine.STALL)):
            points = (each for each in controller.operating_points if (each.gear, each.state) == (gear, state))
            for point in list(points)[:1]:
                clutches = [
                    each.id
                    for each in controller.circuits
                    if gear in each.gears and each.gears != frozenset(controller.gears)
                ]
                cells |= {GaugeCell(selected, engine, tap): point for tap in (LINE_TAP, *clutches)}
    return cells


def simulate(unit: str, number: int, gauge: float, alike: Gauges = "each reading") -> Tapped:
    """Simulate one unit and its gauge readings, which err by ``gauge`` of what they show (one standard deviation)."""
    rng = np.random.default_rng((20260301, sum(map(ord, unit)), number))
    controller, fluid = file_of(unit)
    cells = cells_of(controller)
    true = true_unit(rng, controller, fluid)
    held = {cell: true.held(point, cell.tap) for cell, point in cells.items()}
    lost = {cell: true.held(point, cell.tap, new=True) - held[cell] for cell, point in cells.items()}
    errors = {cell: rng.normal() for cell in cells}
    if alike != "each reading":
        by_gauge = {
            tap: rng.normal() for tap in dict.fromkeys(cell.tap if alike == "each tap" else "" for cell in cells)
        }
        errors = {cell: by_gauge[cell.tap if alike == "each tap" else ""] for cell in cells}
    readings = tuple(GaugeReading(cell, held[cell] * (1.0 + gauge * errors[cell])) for cell in cells)
    return Tapped(held, lost, PressureTable("simulated", "0" * 64, None, ("kPa",), readings))


def true_unit(rng: np.random.Generator, controller: Controller, fluid: Fluid, faults: Faults | None = None) -> TrueUnit:
    """Draw a true unit: its own numbers in place of the file's, with given faults, else with such as are drawn too."""
    low, high = MEAN_WEAR
    mean, worn, fresh = rng.uniform(low, high), [], []
    for state in clearances(None, controller):
        begin, end = state.land.mounting_range
        first = rng.uniform(begin, end) if begin < end else rng.normal(begin, 0.5e-6)
        if faults is not None:
            gone = faults.wear.get(state.land.key, 0.0)
        else:
            gone = min(rng.exponential(mean), MOST_WEAR) if rng.random() < WORN and not state.land.seal else 0.0
        fresh.append(replace(state, radial_clearance=first))
        worn.append(replace(state, radial_clearance=first + gone))
    thicker = math.exp(VISCOSITY * rng.normal())
    points = tuple((at, nu * thicker) for at, nu in fluid.points)
    fluid = replace(fluid, points=points, table=tuple((at, nu * thicker, rho) for at, nu, rho in fluid.table))
    setting, warmer = 1.0 + 0.01 * rng.normal(), TEMPERATURE * rng.normal()
    circuits = tuple(
        replace(
            each,
            feeds=tuple(
                replace(feed, discharge_coefficient=feed.discharge_coefficient * (1.0 + FEED * rng.normal()))
                for feed in each.feeds
            ),
        )
        for each in controller.circuits
    )
    line = controller.line
    if line is not None and line.following is not None:
        follows = line.following
        line = replace(line, following=replace(follows, ratio=follows.ratio * setting, offset=follows.offset * setting))
    coefficient = controller.pump.slip_coefficient
    own = coefficient and coefficient * math.exp(SLIP * rng.normal())
    more = faults.slip - 1.0 if faults is not None else rng.uniform(0.0, PUMP_SLIP) * (rng.random() < WORN_PUMPS)
    slips = own and own * (1.0 + more)
    new = replace(controller, circuits=circuits, line=line, pump=replace(controller.pump, slip_coefficient=own))
    if faults is not None:
        seals = dict(faults.seals)
    else:
        seals = {
            each.id: rng.exponential(SEAL_FLOW)
            for each in controller.circuits
            if each.gears != frozenset(controller.gears) and rng.random() < WORN_SEALS
        }
    faults = faults or Faults()
    leaks = tuple(
        Leak(
            f"seal of {each.id}", "seal", Pressure(1.0, each.id), Pressure(0.0, None), "laminar",
            seals[each.id], 900e3, 5e-3, 800.0, each.gears, True, "simulated",
        )
        for each in controller.circuits
        if each.id in seals
    )  # fmt: skip
    if line is not None and line.following is not None:
        follows, held = line.following, 1.0 - faults.fall
        line = replace(line, following=replace(follows, ratio=follows.ratio * held, offset=follows.offset * held))
    now = replace(
        new, line=line, leaks=(*controller.leaks, *leaks), pump=replace(controller.pump, slip_coefficient=slips)
    )
    return TrueUnit(
        LeakageModel(now, tuple(worn), fluid, WORKSHOP),
        LeakageModel(new, tuple(fresh), fluid, WORKSHOP),
        setting,
        warmer,
        faults,
    )
