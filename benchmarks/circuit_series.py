"""Time the pressures of circuits over a long log, beside scipy's root finder at every sample.

    python benchmarks/circuit_series.py [--small]

prints, for 1.8 million samples and a valve body of 24 lands on 6 fed circuits: the time of the whole series, pressures
and leakage; scipy.optimize.root with the same balances, timed over some samples and multiplied, as a ratio to the
series (goal: at least 200); the largest difference of a pressure between the two over the line's (exit status 1 where
they disagree); and the time of the same log without circuits.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.optimize import root
from timing import median_time, options

from atleak.catalogue.circuits import Circuit, Feed, Pressure, SetPressure
from atleak.catalogue.controller import Gap
from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.fluid import load_fluid
from atleak.engine.leakage import LeakageModel
from atleak.engine.profile import WORKSHOP
from atleak.engine.series import leakage_series
from atleak.equations import gap as gap_equations
from atleak.equations import orifice as orifice_equations
from atleak.measurements.clearances import clearances

OPTIONS = options(__doc__)
SAMPLES, SMALL, SLOW = 1_800_000, 20_000, 200
FEEDS = (0.5e-3, 0.8e-3, 1.0e-3, 0.6e-3, 0.5e-3, 0.7e-3)  # [m]; the last is fed by the first circuit
LIMITS = (None, 250e3, None, 400e3, None, None)  # [Pa]
LANDS = 4  # on each circuit
AGREEMENT = 1e-6  # largest difference of a pressure over the line's
DISCHARGE = 0.62


def main(chosen: argparse.Namespace) -> int:
    samples, slow = (SMALL, 20) if chosen.small else (SAMPLES, SLOW)
    rng = np.random.default_rng(1)
    seconds = np.arange(samples) / 100.0
    p_g = 7.0e5 + 2.5e5 * np.sin(seconds / 7.0) + rng.normal(0.0, 5.0e3, samples)
    log = (p_g, 0.5 * p_g, 80.0 + 20.0 * np.sin(seconds / 600.0), 1.0 + np.floor(seconds / 30.0) % 4.0)
    model = unit()
    some = np.linspace(0, samples - 1, slow).astype(int)
    loop = median_time(lambda: [by_scipy(model, *(float(channel[at]) for channel in log)) for at in some], rounds=1)
    loop *= samples / slow
    series = median_time(lambda: leakage_series(model, *log), rounds=3)
    held = leakage_series(model, *log)
    difference = max(
        float(np.max(np.abs([held.circuits[name][at] - pressure for name, pressure in by_scipy_at(model, log, at)])))
        / p_g[at]
        for at in some
    )
    plain = LeakageModel(load_controller("four_speed_2023"), model.clearances, model.fluid, WORKSHOP)
    plain = replace(plain, clearances=clearances(None, plain.controller))
    without = median_time(lambda: leakage_series(plain, *log), rounds=3)
    print(f"{samples} samples, {len(model.controller.gaps)} lands on {len(FEEDS)} fed circuits")
    print(f"  series                             {series:8.2f} s")
    print(f"  scipy at every sample / series     {loop / series:8.0f}   ({loop:.0f} s, from {slow} samples)")
    print(f"  largest difference of a pressure   {difference:8.1e}   of the line's")
    print(f"  without circuits                   {without:8.2f} s")
    return 0 if difference <= AGREEMENT and held.unbalanced == 0 else 1


def unit() -> LeakageModel:
    """Return a unit of 24 lands, from new to worn, on 6 fed circuits, all of which are applied in every gear."""
    shipped = load_controller("four_speed_2023")
    gears, names = frozenset(shipped.gears), [f"circuit_{number}" for number in range(len(FEEDS))]
    circuits, lands, gaps = [], [], []
    for number, (name, diameter, limit) in enumerate(zip(names, FEEDS, LIMITS, strict=True)):
        source = names[0] if number == len(FEEDS) - 1 else "p_g"
        stated = None if limit is None else SetPressure(number=limit)
        feeds = (Feed(source, diameter, DISCHARGE),)
        circuits.append(Circuit(name, name, gears, feeds, stated, "made for this benchmark"))
        for land in range(LANDS):
            component = f"{name}_{land}"
            lands.append(replace(shipped.lands[(number + land) % len(shipped.lands)], component=component, land=1))
            drain = Pressure(0.0, None)
            gaps.append(Gap(component, 1, name, Pressure(1.0, name), drain, gears, True, False))
    controller = replace(shipped, circuits=tuple(circuits), lands=tuple(lands), gaps=tuple(gaps))
    states = tuple(
        replace(state, radial_clearance=(13e-6, 20e-6, 28e-6)[number % 3])
        for number, state in enumerate(clearances(None, controller))
    )
    return LeakageModel(controller, states, load_fluid("hipol_atf_iid"), WORKSHOP)


def by_scipy(model: LeakageModel, p_g: float, p_k: float, temperature: float, gear: float) -> dict[str, float]:
    """Solve one sample as a straightforward program does; the loss at a gap's entry is left out, as the series does."""
    fluid, profile = model.fluid, model.profile
    nu, rho = fluid.kinematic_viscosity(temperature, profile.viscosity), fluid.density(temperature, profile.viscosity)
    names = [circuit.id for circuit in model.controller.circuits]
    limits = [np.inf if limit is None else limit / p_g for limit in LIMITS]
    leaks = dict.fromkeys(names, 0.0)
    for geometry in model.geometries:
        clearance = float(geometry.effective_clearance(temperature))
        diameter = geometry.spool_diameter + clearance
        leaks[geometry.gap.section] += gap_equations.annular_flow(
            p_g, diameter, clearance, nu, rho, geometry.contact_length
        )
    coefficients = [orifice_equations.turbulent_coefficient(diameter, DISCHARGE, rho) for diameter in FEEDS]
    transitions = [orifice_equations.transition_pressure(diameter, DISCHARGE, nu, rho) for diameter in FEEDS]

    def surpluses(values: np.ndarray) -> list[float]:
        before = [1.0] * (len(values) - 1) + [float(values[0])]
        fed = [
            orifice_equations.orifice_flow(p_g * (source - float(value)), coefficient, transition)
            for source, value, coefficient, transition in zip(before, values, coefficients, transitions, strict=True)
        ]
        out = [leaks[name] * float(value) for name, value in zip(names, values, strict=True)]
        out[0] += fed[-1]
        scale = max(fed) or 1.0
        return [
            max(float(value) - limit, (leaving - coming) / scale)
            for value, limit, leaving, coming in zip(values, limits, out, fed, strict=True)
        ]

    start = [min(0.9, limit) for limit in limits]
    return dict(zip(names, (root(surpluses, start, tol=1e-12).x * p_g).tolist(), strict=True))


def by_scipy_at(model: LeakageModel, log: tuple[np.ndarray, ...], at: int) -> Any:
    """Return the pressures of one sample of a log."""
    return by_scipy(model, *(float(channel[at]) for channel in log)).items()


if __name__ == "__main__":
    sys.exit(main(OPTIONS.parse_args()))
