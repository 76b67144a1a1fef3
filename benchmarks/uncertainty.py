"""Time the uncertainty of a whole unit, 20 000 draws, beside bare NumPy drawing and cubing as many clearances.

    python benchmarks/uncertainty.py [--small]

The unit is the shipped controller with the sample job's readings, judged at both operating points.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import numpy as np
from timing import median_time, options

from atleak.catalogue.controller import load_controller
from atleak.catalogue.fluid import load_fluid
from atleak.catalogue.limits import load_limits
from atleak.engine.leakage import LeakageModel
from atleak.engine.profile import WORKSHOP
from atleak.engine.projection import project, project_unworn
from atleak.intake.readings import read_readings
from atleak.readings import clearances
from atleak.rules import unit_rules
from atleak.uncertainty import assess

SAMPLE = Path(__file__).resolve().parents[1] / "sample_data" / "measuring_sheet_four_speed.xlsx"
OPTIONS = options(__doc__)
DRAWS = 20_000
SMALL = 500


def main(chosen: argparse.Namespace) -> None:
    number = SMALL if chosen.small else DRAWS
    controller, fluid, limits = (
        load_controller("four_speed_2023"),
        load_fluid("hipol_atf_iid"),
        load_limits("project_default"),
    )
    readings = read_readings(SAMPLE, controller)
    states = clearances(readings, controller)
    model = LeakageModel(controller, states, fluid, WORKSHOP)
    points = [project(model, point) for point in controller.operating_points]
    means = np.array([state.radial_clearance for state in states])[:, None]

    def bare() -> Any:
        draws = np.random.default_rng(1).standard_normal((len(means), number))
        return [np.quantile((means + 1e-6 * draws) ** 3, (0.025, 0.975), axis=1) for _ in points]

    ours = median_time(
        lambda: assess(
            model,
            states,
            points,
            unit_rules(states, points, project_unworn(states, model, points), limits),
            readings=readings,
            draws=number,
        )
    )
    peer = median_time(bare)
    print(f"{len(states)} lands x {number} draws x {len(points)} conditions")
    print(f"assess / drawing, cubing, quantiles   {ours / peer:.2f}   ({ours * 1e3:.0f} ms / {peer * 1e3:.0f} ms)")


if __name__ == "__main__":
    main(OPTIONS.parse_args())
