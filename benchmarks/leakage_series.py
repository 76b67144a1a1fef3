"""Time the total leakage of a long log, beside copying its arrays and beside a loop over the gaps.

    python benchmarks/leakage_series.py [--small]

prints, for 1.8 million samples and a controller of 60 gaps: the time of the series as a ratio to copying its input and
output arrays (goal: at most 3), the loop over gaps as a ratio to the series (goal: at least 50), the largest relative
difference between the two (exit status 1 where they disagree), the time with 600 gaps as a ratio to the time with
6 (goal: within 10 %), and that with one wide gap, which entry loss sets apart from the others, as a ratio to without.

The loop leaves entry loss out, as the series does here: it stays under 1 % of every gap that is not wide.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace
from typing import Any

import numpy as np
from timing import median_time, options

from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.fluid import load_fluid
from atleak.engine.leakage import LeakageModel
from atleak.engine.profile import PAPER, WORKSHOP, Profile
from atleak.engine.series import leakage_series
from atleak.equations import gap as gap_equations
from atleak.measurements.clearances import clearances

OPTIONS = options(__doc__)
SAMPLES = 1_800_000
SMALL = 20_000
AGREEMENT = 1e-9  # largest relative difference between the series and the loop


def main(chosen: argparse.Namespace) -> int:
    samples, agreed = SMALL if chosen.small else SAMPLES, True
    rng = np.random.default_rng(1)
    seconds = np.arange(samples) / 100.0
    p_g = 7.0e5 + 2.5e5 * np.sin(seconds / 7.0) + rng.normal(0.0, 5.0e3, samples)
    p_k = 0.5 * p_g
    temperature = 80.0 + 20.0 * np.sin(seconds / 600.0)
    gear = 1.0 + np.floor(seconds / 30.0) % 4.0
    log = (p_g, p_k, temperature, gear)
    for profile in (WORKSHOP, PAPER):
        model = _model(60, profile)
        copies = median_time(lambda: [array.copy() for array in (*log, p_g)])
        series = median_time(lambda model=model: leakage_series(model, *log))
        loop = median_time(lambda model=model: loop_over_gaps(model, *log), rounds=3)
        total, slow = leakage_series(model, *log).total, loop_over_gaps(model, *log)
        difference = float(np.max(np.abs(total - slow) / np.abs(slow)))
        agreed &= difference <= AGREEMENT  # not where a flow is not a number
        small, large = _model(6, profile), _model(600, profile)
        few, many = (
            median_time(lambda model=small: leakage_series(model, *log)),
            median_time(lambda model=large: leakage_series(model, *log)),
        )
        print(f"{profile.name}: {samples} samples x {len(model.controller.gaps)} gaps")
        print(f"  series / copying its arrays   {series / copies:6.2f}   ({series * 1e3:.0f} / {copies * 1e3:.0f} ms)")
        print(f"  loop over gaps / series       {loop / series:6.1f}   ({loop * 1e3:.0f} ms)")
        print(f"  largest relative difference   {difference:.1e}")
        print(f"  600 gaps / 6 gaps             {many / few:6.2f}   ({many * 1e3:.0f} ms / {few * 1e3:.0f} ms)")
        one_wide = _with_a_wide_gap(model)
        wide = median_time(lambda model=one_wide: leakage_series(model, *log))
        print(f"  with one wide gap / without   {wide / series:6.2f}   ({wide * 1e3:.0f} ms)")
    return 0 if agreed else 1


def loop_over_gaps(model: LeakageModel, p_g: Any, p_k: Any, temperature: Any, gear: Any) -> np.ndarray:
    """Add up every gap's flow over the whole log, as a straightforward program does."""
    profile, fluid = model.profile, model.fluid
    viscosity = fluid.kinematic_viscosity(temperature, profile.viscosity)
    density = fluid.density(temperature, profile.viscosity)
    pressures = model.controller.section_pressures(p_g, p_k)
    states = {state.land.key: state for state in model.clearances}
    total = np.zeros_like(p_g)
    for gap in model.controller.gaps:
        if profile.pump_draw == "into_sump" and not gap.into_sump:
            continue
        state = states[gap.key]
        high, low = (pressures[end.section] * end.coefficient if end.section else 0.0 for end in (gap.high, gap.low))
        rate = state.land.thermal_rate(state.spool_diameter, state.sleeve_diameter)
        clearance = state.radial_clearance + rate * (temperature - 20.0)
        diameter = state.spool_diameter + (clearance if profile.diameter == "mean" else 0.0)
        length = state.land.contact_length
        flow = gap_equations.annular_flow(high - low, diameter, clearance, viscosity, density, length)
        total += np.where(np.isin(gear, list(gap.gears)), np.maximum(flow, 0.0), 0.0)
    return total


def _model(gaps: int, profile: Profile) -> LeakageModel:
    controller = load_controller("four_speed_2023")
    chosen = _published_kinds(controller, gaps)
    controller = replace(controller, gaps=chosen)
    return LeakageModel(controller, clearances(None, controller), load_fluid("hipol_atf_iid"), profile)


def _with_a_wide_gap(model: LeakageModel) -> LeakageModel:
    """Return the model with the first land at 100 µm, and with only one gap of that land."""
    first, *others = model.controller.gaps
    gaps = (first, *(gap for gap in others if gap.key != first.key))
    states = tuple(
        replace(state, radial_clearance=100e-6) if state.land.key == first.key else state for state in model.clearances
    )
    return replace(model, controller=replace(model.controller, gaps=gaps), clearances=states)


def _published_kinds(controller: Controller, count: int) -> tuple[Any, ...]:
    """Return so many gaps with a pressure drop in every gear, repeating the controller's kinds of drop."""
    every = frozenset(controller.gears)
    kinds = {(gap.section, str(gap.high), str(gap.low)): replace(gap, gears=every) for gap in controller.gaps}
    gaps = list(kinds.values())[:6]
    return tuple(gaps[number % len(gaps)] for number in range(count))


if __name__ == "__main__":
    sys.exit(main(OPTIONS.parse_args()))
