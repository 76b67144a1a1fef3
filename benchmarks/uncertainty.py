"""Time the uncertainty of a whole unit beside bare NumPy drawing and cubing, and say how steady its intervals are.

    python benchmarks/uncertainty.py [--small]

The first unit is the shipped controller with the sample job's readings, judged at both operating points; the second has
60 lands on 12 circuits, whose pressures are solved in every draw at 4 operating points. Of both it prints the CPU
time (goals for the whole diagnosis: 100 ms and 400 ms), and by how much the ends of 95 % intervals scatter from seed to
seed, in standard uncertainties of their quantity: the root mean square (goal: 0.03), and the most. At last it prints
the time of the second over that of the first (goal: at most 4).
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from circuits import unit
from timing import median_time, options

from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.fluid import load_fluid
from atleak.catalogue.limits import load_limits
from atleak.diagnosis.rules import unit_rules
from atleak.diagnosis.uncertainty import UnitUncertainty, assess
from atleak.diagnosis.uncertainty.propagation import DRAWS, DRAWS_OF_CIRCUITS, SEED
from atleak.engine.leakage import LeakageModel
from atleak.engine.profile import WORKSHOP
from atleak.engine.projection import project, project_unworn
from atleak.measurements.clearances import clearances
from atleak.measurements.readings import Readings
from atleak.readers.sheets.measuring_sheet import read_readings

SAMPLE = Path(__file__).resolve().parents[1] / "sample_data" / "measuring_sheet_four_speed.xlsx"
OPTIONS = options(__doc__)
SMALL = 512


def main(chosen: argparse.Namespace) -> None:
    controller = load_controller("four_speed_2023")
    readings = read_readings(SAMPLE, controller)
    model = LeakageModel(controller, clearances(readings, controller), load_fluid("hipol_atf_iid"), WORKSHOP)
    plain = compare(model, readings, SMALL if chosen.small else DRAWS, 2 if chosen.small else 40)
    worn, _ = unit()
    sheet = read_readings(written(worn), worn.controller, name="worn.csv")
    worn = replace(worn, clearances=clearances(sheet, worn.controller))
    solved = compare(worn, sheet, SMALL if chosen.small else DRAWS_OF_CIRCUITS, 2 if chosen.small else 12)
    print(f"with circuits / without                {solved / plain:.2f}")


def written(model: LeakageModel) -> bytes:
    """Return a measuring sheet with the clearances of a unit, in two directions, as CSV text."""
    rows = ["component;part;plane;direction;diameter [mm]"]
    for state in model.clearances:
        spool = state.land.nominal_diameter
        for part, diameter in (("spool", spool), ("sleeve", spool + 2.0 * state.radial_clearance)):
            places = [(plane, angle) for plane in state.land.planes for angle in (0, 90)]
            rows += [f"{state.land.component};{part};{plane};{angle};{diameter * 1e3:.5f}" for plane, angle in places]
    return "\n".join(rows).encode("utf-8")


def compare(model: LeakageModel, readings: Readings, number: int, seeds: int) -> float:
    """Time one unit and print it beside the bare sums; return the time [s]."""
    limits, states = load_limits("project_default"), model.clearances
    points = [project(model, point) for point in model.controller.operating_points]
    unworn = project_unworn(states, model, points)
    means = np.array([state.radial_clearance for state in states])[:, None]

    def bare() -> Any:
        draws = np.random.default_rng(1).standard_normal((len(means), number))
        return [np.quantile((means + 1e-6 * draws) ** 3, (0.025, 0.975), axis=1) for _ in points]

    rules = unit_rules(states, points, unworn, limits)

    def ours(seed: int = SEED) -> UnitUncertainty:
        return assess(model, states, points, rules, readings=readings, draws=number, seed=seed)

    times = [median_time(each, clock=time.process_time) for each in (ours, bare)]
    circuits = len(model.controller.circuits)
    print(f"{len(states)} lands, {circuits} circuits x {number} draws x {len(points)} conditions")
    ratio = times[0] / times[1]
    print(f"assess / drawing, cubing, quantiles   {ratio:.2f}   ({times[0] * 1e3:.0f} ms / {times[1] * 1e3:.0f} ms)")
    units = [ours(seed) for seed in range(seeds)]
    scatter("shares of lands", [[at for land in unit.lands for at in land.conditions] for unit in units])
    scatter("total shares", [unit.totals for unit in units])
    held = [[held for total in unit.totals for held in total.circuit_intervals.values()] for unit in units]
    if held[0]:
        ends = np.array(held)
        widths = (ends[..., 1] - ends[..., 0]).mean(axis=0) / (2.0 * 1.96)
        moves = widths > 0.0  # a regulator may hold its pressure in every draw
        print_noise("pressures of circuits", ends[:, moves], widths[moves])
    return times[0]


def scatter(what: str, seeds: Sequence[Sequence[Any]]) -> None:
    """Print the noise of some shares, of which each seed gives a row."""
    drawing = [number for number, each in enumerate(seeds[0]) if 0.0 < each.u_share < np.inf]
    ends = np.array([[row[number].share_interval for number in drawing] for row in seeds])
    u = np.array([[row[number].u_share for number in drawing] for row in seeds]).mean(axis=0)
    print_noise(what, ends, u)


def print_noise(what: str, ends: np.ndarray, u: np.ndarray) -> None:
    """Print how much ends of intervals scatter; shapes (seeds, quantities, 2) and (quantities,)."""
    noise = ends.std(axis=0, ddof=1) / u[:, None]
    low, high = np.sqrt((noise**2).mean(axis=0))
    most = noise.max()
    print(f"  {what:24} ends of intervals scatter by {low:.3f} u (low), {high:.3f} u (high), at most {most:.3f} u")


if __name__ == "__main__":
    main(OPTIONS.parse_args())
