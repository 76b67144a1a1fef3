"""Time the pressures that a unit's circuits hold, beside scipy's root finder.

    python benchmarks/circuits.py [--small]

prints, for a valve body of 60 lands and 12 circuits at 4 operating points: the time in which the pressures of one
condition are solved as a ratio to scipy.optimize.root with the same balances (goal: at most 1); scipy once for each
land as a ratio to each land new in turn, which tells what every land costs its circuit, line and leakage with it (goal:
at least 20); and the largest difference between the two (exit status 1 where they disagree).
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace
from types import MappingProxyType
from typing import Any

import numpy as np
from scipy.optimize import root
from timing import median_time, options

from atleak.catalogue.circuits import Circuit, Feed, Pressure, SetPressure
from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.fluid import load_fluid
from atleak.catalogue.operating_point import OperatingPoint
from atleak.engine.leakage import LeakageModel
from atleak.engine.network import Network
from atleak.engine.operation import with_new
from atleak.engine.profile import WORKSHOP
from atleak.measurements.clearances import clearances

OPTIONS = options(__doc__)
CIRCUITS, LANDS = 12, 60
AGREEMENT = 1e-6  # largest difference of a pressure over the line's


def main(chosen: argparse.Namespace) -> int:
    model, new = unit()
    points = model.controller.operating_points[:1] if chosen.small else model.controller.operating_points
    keys = [state.land.key for state in model.clearances]
    networks = [model.network(point) for point in points]
    solve = median_time(lambda: [network.balance(_sections(network)) for network in networks]) / len(points)
    slow = median_time(lambda: [by_scipy(network) for network in networks], rounds=3) / len(points)
    lands = keys[:3] if chosen.small else keys
    choices = [{key} for key in lands]
    held = median_time(lambda: [with_new(model, new, point, choices) for point in points], rounds=3) / len(points)
    difference = max(_difference(network) for network in networks)
    print(f"{len(model.controller.gaps)} lands, {len(model.controller.circuits)} circuits, {len(points)} conditions")
    print(f"  solve / scipy                      {solve / slow:8.3f}   ({solve * 1e3:.2f} / {slow * 1e3:.1f} ms)")
    print(f"  scipy once a land / each land new  {len(lands) * slow / held:8.1f}   ({held * 1e3:.1f} ms)")
    print(f"  largest difference of a pressure   {difference:8.1e}   of the line's")
    return 0 if difference <= AGREEMENT else 1


def unit() -> tuple[LeakageModel, LeakageModel]:
    """Return a worn unit of 60 lands on 12 circuits, and the same unit new."""
    shipped = load_controller("four_speed_2023")
    gears = frozenset(shipped.gears)
    names = [f"circuit_{number}" for number in range(CIRCUITS)]
    circuits = tuple(
        Circuit(
            name,
            name,
            gears,
            (Feed(names[number - 1] if number % 4 == 3 else "p_g", 0.5e-3 + 0.1e-3 * (number % 5), 0.62),),
            SetPressure(number=250e3) if number % 5 == 4 else None,
            "made for this benchmark",
        )
        for number, name in enumerate(names)
    )
    drain, lands = Pressure(0.0, None), shipped.lands
    land_of = [replace(lands[number % len(lands)], component=f"v{number}", land=1) for number in range(LANDS)]
    gaps = []
    for number, land in enumerate(land_of):
        low = Pressure(1.0, names[(number + 1) % CIRCUITS]) if number % 6 == 0 else drain
        high = names[number % CIRCUITS]
        template = replace(shipped.gaps[0], component=land.component, land=1, gears=gears)
        gaps.append(replace(template, section=high, high=Pressure(1.0, high), low=low, into_sump=not low.is_section))
    points = tuple(
        replace(shipped.operating_points[0], name=f"at_{celsius}", temperature=float(celsius), main_pressure=kpa * 1e3)
        for celsius, kpa in ((60, 700.0), (80, 800.0), (100, 500.0), (120, 900.0))
    )
    controller = replace(
        shipped,
        components=MappingProxyType({land.component: f"valve {land.component[1:]}" for land in land_of}),
        operating_points=points,
        circuits=circuits,
        lands=tuple(land_of),
        gaps=tuple(gaps),
        complaints=(),
    )
    fluid, states = load_fluid("hipol_atf_iid"), clearances(None, controller)
    worn = tuple(
        replace(state, radial_clearance=(14e-6, 20e-6, 35e-6)[number % 3]) for number, state in enumerate(states)
    )
    return LeakageModel(controller, worn, fluid, WORKSHOP), LeakageModel(controller, states, fluid, WORKSHOP)


def _sections(network: Network) -> dict[str, Any]:
    point: OperatingPoint = network.point
    controller: Controller = network.controller
    return controller.section_pressures(point.main_pressure, point.converter_pressure)


def by_scipy(network: Network) -> dict[str, float]:
    """Solve the same balances as a straightforward program does: every flow on its own, circuits set by a minimum."""
    sections = _sections(network)
    line = sections["p_g"]
    circuits = network.applied
    limits = [line if each.set_pressure is None else each.set_pressure.at(network.point) for each in circuits]

    def surpluses(values: np.ndarray) -> list[float]:
        pressures = sections | {each.id: value * line for each, value in zip(circuits, values, strict=True)}
        surplus = {each.id: 0.0 for each in circuits}
        feeds = {each.id: 0.0 for each in circuits}
        for branch in network.branches:
            flow = network.flow(branch, pressures)
            if branch.high.section in surplus:
                surplus[branch.high.section] += flow
            if branch.into in surplus:
                surplus[branch.into] -= flow
        for feed in reversed(network.feeds):  # those that are fed come before those that feed them
            flow = feed.restriction.flow(feed.drop(pressures))
            limit = next(limit for each, limit in zip(circuits, limits, strict=True) if each.id == feed.into)
            drawn = min(flow, max(surplus[feed.into], 0.0)) if pressures[feed.into] >= limit else flow
            feeds[feed.into] += flow
            if feed.high.section in surplus:
                surplus[feed.high.section] += drawn
        scale = 1e-5
        return [
            max(pressures[each.id] / line - limit / line, (surplus[each.id] - feeds[each.id]) / scale)
            for each, limit in zip(circuits, limits, strict=True)
        ]

    start = [min(limit / line, 1.0) * 0.7 for limit in limits]
    values = root(surpluses, start, tol=1e-12).x
    return {each.id: value * line for each, value in zip(circuits, values.tolist(), strict=True)}


def _difference(network: Network) -> float:
    solved, other = network.balance(_sections(network)).pressures, by_scipy(network)
    return max(abs(solved[name] - pressure) for name, pressure in other.items()) / network.point.main_pressure


if __name__ == "__main__":
    sys.exit(main(OPTIONS.parse_args()))
