"""What diameters cannot see of a bore worn to one side: in the intervals, as far as it can be bounded."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from atleak.catalogue.controller import Controller
from atleak.diagnosis.uncertainty import NOTHING_ELSE
from tests.unit.diagnosis.uncertainty.conftest import a_sheet, two_instruments

ONE_SIDED = replace(NOTHING_ELSE, one_sided_wear=1.0)
EXACT = two_instruments(calibration=0.0)
WORN = 1.5  # times the mounting clearance


@pytest.fixture
def worn(twenty_lands: Controller, judge: Callable) -> Callable:
    def run(directions: tuple[float, ...], assumptions: object = ONE_SIDED) -> tuple[float, float, float]:
        land = twenty_lands.lands[0]
        sheet = a_sheet(twenty_lands, clearance=WORN * land.mounting_clearance, directions=directions)
        total = judge(sheet, controller=twenty_lands, instruments=EXACT, assumptions=assumptions).unit.totals[0]
        return (total.leakage, *total.leakage_interval)

    return run


def one_sided_over_even(controller: Controller, seen: np.ndarray, warm: float) -> float:
    """What leaks on average where all of the wear shown is to one side, over what leaks where it is even."""
    new = controller.lands[0].mounting_clearance
    shown = (WORN - 1.0) * new
    around = np.maximum(np.cos(np.linspace(0.0, 2.0 * math.pi, 720, endpoint=False)), 0.0)
    cubes = [np.mean((new + warm + math.pi * (shown / s) * around) ** 3) for s in seen]
    return float(np.mean(cubes)) / (new + shown + warm) ** 3


def test_the_total_may_be_that_of_even_wear_or_of_all_wear_to_one_side(
    worn: Callable, twenty_lands: Controller
) -> None:
    leakage, low, high = worn((0.0, 90.0))
    assert low == pytest.approx(leakage, rel=1e-3, abs=0.0)
    land, point = twenty_lands.lands[0], twenty_lands.operating_points[0]
    sleeve = land.nominal_diameter + 2.0 * WORN * land.mounting_clearance
    warm = land.thermal_rate(land.nominal_diameter, sleeve) * (point.temperature - 20.0)
    phases = np.linspace(0.0, math.pi, 360, endpoint=False)
    seen = 0.25 * math.pi * (np.abs(np.cos(phases)) + np.abs(np.sin(phases)))
    most = leakage * one_sided_over_even(twenty_lands, seen, warm)
    assert 1.2 * leakage < most < high  # phases differ from land to land, so that totals scatter around it
    assert high == pytest.approx(most, rel=0.06, abs=0.0)


def test_it_can_be_left_out(worn: Callable) -> None:
    leakage, low, high = worn((0.0, 90.0), NOTHING_ELSE)
    assert (low, high) == (pytest.approx(leakage, rel=1e-4, abs=0.0), pytest.approx(leakage, rel=1e-4, abs=0.0))


def test_one_direction_alone_doubts_the_wear_by_no_more_than_twice(worn: Callable, twenty_lands: Controller) -> None:
    leakage, _, high = worn((0.0,))
    _, _, with_two = worn((0.0, 90.0))
    # nine times would be the cube of a clearance of which a tenth of the wear shows
    assert with_two < high < leakage * one_sided_over_even(twenty_lands, np.array([0.5]), 0.0)


def test_a_sleeve_that_was_not_measured_is_as_it_was_when_new(judge: Callable, twenty_lands: Controller) -> None:
    """What a range leaves open of it is the same error now and when new: it is no growth."""
    by_range = replace(
        twenty_lands, lands=tuple(replace(land, mounting_clearance=(6.4e-6, 20e-6)) for land in twenty_lands.lands)
    )
    sheet = a_sheet(twenty_lands, step=1e-9)
    spools = replace(sheet, readings=tuple(each for each in sheet.readings if each.part == "spool"))
    perfect = two_instruments(calibration=1e-9, repeatability=1e-9)
    total = judge(spools, controller=by_range, instruments=perfect).unit.totals[0]
    assert total.growth_interval == pytest.approx((0.0, 0.0), abs=0.01)
    low, high = total.leakage_interval
    assert high > 1.2 * low
