"""Readings in four and eight directions of bores whose shape is known: against the mean cube integrated around them."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from atleak.catalogue.controller import Controller
from atleak.diagnosis.uncertainty import DEFAULTS, NOTHING_ELSE
from atleak.engine.profile import WORKSHOP
from atleak.measurements.readings import Reading, Readings
from tests.unit.diagnosis.uncertainty.conftest import two_instruments

AROUND = np.arange(720) * math.pi / 360.0
FOUR, EIGHT = (tuple(180.0 / count * number for number in range(count)) for count in (4, 8))
OF_FORM = replace(
    NOTHING_ELSE, **{name: getattr(DEFAULTS, name) for name in ("one_sided_wear", "form_residual", "unseen_ovality")}
)
Shape = Callable[[np.random.Generator], np.ndarray]  # what is added to the clearance when new [m], at `AROUND`


@pytest.fixture
def compared(twenty_lands: Controller, judge: Callable) -> Callable[..., np.ndarray]:
    """Twenty bores read in some directions: what truly leaks, what is said, and its interval; the total comes last."""

    def run(shape: Shape, directions: tuple[float, ...]) -> np.ndarray:
        rng, readings, truth = np.random.default_rng(3), list[Reading](), []
        point = twenty_lands.operating_points[0]
        for land in twenty_lands.lands:
            d, gap = land.nominal_diameter, land.mounting_clearance + shape(rng)
            across = d + gap + np.roll(gap, 360)
            for angle in directions:
                at = land.component, land.planes[0], angle
                readings.append(Reading(at[0], "spool", at[1], at[2], 1, d))
                readings.append(Reading(at[0], "sleeve", at[1], at[2], 1, float(across[round(2 * angle)])))
            hot = gap + land.thermal_rate(d, d + 2.0 * gap.mean()) * (point.temperature - 20.0)
            truth.append(np.mean(hot**3) * (d + hot.mean()))
        case = judge(
            Readings("own.csv", "0" * 64, None, "mm", False, "tidy", tuple(readings)), controller=twenty_lands,
            instruments=two_instruments(calibration=0.5e-6), assumptions=OF_FORM,
            profile=WORKSHOP.with_options(entry_loss="off"),
        )  # fmt: skip
        gap = case.projections[0].gaps[0]
        unit = math.pi * gap.pressure_drop / (12.0 * gap.kinematic_viscosity * gap.density * gap.contact_length)
        said = [(each.leakage, *each.leakage_interval) for each in (land.conditions[0] for land in case.unit.lands)]
        said.append((case.unit.totals[0].leakage, *case.unit.totals[0].leakage_interval))
        return np.column_stack([unit * np.array([*truth, sum(truth)]), said])

    return run


def lobes(rng: np.random.Generator, four: float) -> np.ndarray:
    """Worn by 10 µm, oval by up to 20 µm across at any angle, and with four lobes."""
    phase = rng.uniform(0.0, math.pi, 2)
    oval = rng.uniform(0.0, 5e-6) * np.cos(2.0 * (AROUND - phase[0]))
    return 10e-6 + oval + four * np.cos(4.0 * (AROUND - phase[1]))


@pytest.mark.parametrize(("directions", "four"), [(FOUR, 0.0), (EIGHT, 3e-6)])
def test_what_an_oval_bore_leaks_is_the_mean_cube_around_it(
    compared: Callable, directions: tuple[float, ...], four: float
) -> None:
    truth, said, *_ = compared(lambda rng: lobes(rng, four), directions).T
    assert said == pytest.approx(truth, rel=1e-6, abs=0.0)


@pytest.mark.parametrize("power", [None, 1, 2, 3])
@pytest.mark.parametrize("depth", [15e-6, 40e-6])
@pytest.mark.parametrize("directions", [FOUR, EIGHT])
def test_intervals_hold_what_a_bore_leaks_that_is_worn_evenly_or_to_one_side(
    compared: Callable, directions: tuple[float, ...], depth: float, power: int | None
) -> None:
    def worn(rng: np.random.Generator) -> np.ndarray:
        deep, phase = depth * rng.uniform(0.5, 1.5), rng.uniform(0.0, 2.0 * math.pi)
        return deep * (0.4 + 0.0 * AROUND if power is None else np.maximum(np.cos(AROUND - phase), 0.0) ** power)

    truth, _, low, high = compared(worn, directions).T
    held = (low <= truth * (1.0 + 1e-6)) & (truth <= high * (1.0 + 1e-6))
    assert held[-1]
    assert np.count_nonzero(held[:-1]) >= 18
