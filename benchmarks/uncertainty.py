"""Time the uncertainty of a whole unit beside bare NumPy drawing and cubing as many clearances.

    python benchmarks/uncertainty.py [--small]

The first unit is the shipped controller with the sample job's readings, judged at both operating points with 20 000
draws; the second has 60 lands on 12 circuits, whose pressures are solved in each of its 8 000 draws at 4 operating
points (goal: 1.0 s).
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from circuits import unit
from timing import median_time, options

from atleak.catalogue.controller_reading import load_controller
from atleak.catalogue.fluid import load_fluid
from atleak.catalogue.limits import load_limits
from atleak.engine.leakage import LeakageModel
from atleak.engine.profile import WORKSHOP
from atleak.engine.projection import project, project_unworn
from atleak.intake.readings import read_readings
from atleak.readings import Readings, clearances
from atleak.rules import unit_rules
from atleak.uncertainty import assess
from atleak.uncertainty.propagation import DRAWS, DRAWS_OF_CIRCUITS

SAMPLE = Path(__file__).resolve().parents[1] / "sample_data" / "measuring_sheet_four_speed.xlsx"
OPTIONS = options(__doc__)
SMALL = 500


def main(chosen: argparse.Namespace) -> None:
    controller = load_controller("four_speed_2023")
    readings = read_readings(SAMPLE, controller)
    model = LeakageModel(controller, clearances(readings, controller), load_fluid("hipol_atf_iid"), WORKSHOP)
    compare(model, readings, SMALL if chosen.small else DRAWS)
    worn, _ = unit()
    sheet = read_readings(written(worn), worn.controller, name="worn.csv")
    worn = replace(worn, clearances=clearances(sheet, worn.controller))
    compare(worn, sheet, SMALL if chosen.small else DRAWS_OF_CIRCUITS)


def written(model: LeakageModel) -> bytes:
    """Return a measuring sheet with the clearances of a unit, in two directions, as CSV text."""
    rows = ["component;part;plane;direction;diameter [mm]"]
    for state in model.clearances:
        spool = state.land.nominal_diameter
        for part, diameter in (("spool", spool), ("sleeve", spool + 2.0 * state.radial_clearance)):
            places = [(plane, angle) for plane in state.land.planes for angle in (0, 90)]
            rows += [f"{state.land.component};{part};{plane};{angle};{diameter * 1e3:.5f}" for plane, angle in places]
    return "\n".join(rows).encode("utf-8")


def compare(model: LeakageModel, readings: Readings, number: int) -> None:
    """Time one unit and print it beside the bare sums."""
    limits, states = load_limits("project_default"), model.clearances
    points = [project(model, point) for point in model.controller.operating_points]
    unworn = project_unworn(states, model, points)
    means = np.array([state.radial_clearance for state in states])[:, None]

    def bare() -> Any:
        draws = np.random.default_rng(1).standard_normal((len(means), number))
        return [np.quantile((means + 1e-6 * draws) ** 3, (0.025, 0.975), axis=1) for _ in points]

    ours = median_time(
        lambda: assess(
            model, states, points, unit_rules(states, points, unworn, limits), readings=readings, draws=number
        )
    )
    peer = median_time(bare)
    circuits = len(model.controller.circuits)
    print(f"{len(states)} lands, {circuits} circuits x {number} draws x {len(points)} conditions")
    print(f"assess / drawing, cubing, quantiles   {ours / peer:.2f}   ({ours * 1e3:.0f} ms / {peer * 1e3:.0f} ms)")


if __name__ == "__main__":
    main(OPTIONS.parse_args())
