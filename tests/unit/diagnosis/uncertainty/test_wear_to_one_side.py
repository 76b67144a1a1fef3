"""What diameters cannot see of a bore worn to one side: in the intervals, as far as it can be bounded."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from atleak.catalogue.controller import Controller
from atleak.diagnosis.uncertainty import NOTHING_ELSE
from atleak.diagnosis.uncertainty.one_sided_wear import SIDES, chances_of_sides
from atleak.equations.clearance import seen_of_one_sided
from atleak.measurements.readings import Reading, Readings
from tests.unit.diagnosis.uncertainty.conftest import a_sheet, two_instruments

ONE_SIDED = replace(NOTHING_ELSE, one_sided_wear=1.0)
EXACT = two_instruments(calibration=0.0)
WORN = 1.5  # times the mounting clearance


@pytest.fixture
def worn(twenty_lands: Controller, judge: Callable) -> Callable:
    def run(
        directions: tuple[float, ...], assumptions: object = ONE_SIDED, exponent: float | None = None
    ) -> tuple[float, float, float]:
        land = twenty_lands.lands[0]
        sheet = a_sheet(twenty_lands, clearance=WORN * land.mounting_clearance, directions=directions)
        if exponent is not None:
            sheet = worn_to_one_side(sheet, (WORN - 1.0) * land.mounting_clearance, exponent)
        total = judge(sheet, controller=twenty_lands, instruments=EXACT, assumptions=assumptions).unit.totals[0]
        return (total.leakage, *total.leakage_interval)

    return run


def worn_to_one_side(sheet: Readings, wear: float, exponent: float) -> Readings:
    """The same sheet with all wear of a mean [m] to one side, each component's its own; 0 leaves it even."""

    def worn(reading: Reading) -> Reading:
        if reading.part == "spool" or not exponent:
            return reading
        angle = math.radians(reading.direction or 0.0) - 2.4 * int(reading.component)
        return replace(reading, diameter=reading.diameter + 2.0 * wear * (seen_of_one_sided(angle, exponent) - 1.0))

    return replace(sheet, readings=tuple(map(worn, sheet.readings)))


def warmed(controller: Controller) -> float:
    """By how much the clearance of a land grows to its temperature [m]."""
    land, point = controller.lands[0], controller.operating_points[0]
    sleeve = land.nominal_diameter + 2.0 * WORN * land.mounting_clearance
    return land.thermal_rate(land.nominal_diameter, sleeve) * (point.temperature - 20.0)


def one_sided_over_even(controller: Controller, seen: np.ndarray, warm: float, exponent: float = 1.0) -> float:
    """What leaks on average where all of the wear shown is to one side, over what leaks where it is even."""
    new = controller.lands[0].mounting_clearance
    shown = (WORN - 1.0) * new
    around = np.maximum(np.cos(np.linspace(0.0, 2.0 * math.pi, 720, endpoint=False)), 0.0) ** exponent
    cubes = [np.mean((new + warm + (shown / s) * around / around.mean()) ** 3) for s in seen]
    return float(np.mean(cubes)) / (new + shown + warm) ** 3


def test_the_total_may_be_that_of_even_wear_or_of_all_wear_to_one_side(
    worn: Callable, twenty_lands: Controller
) -> None:
    leakage, low, high = worn((0.0, 90.0))
    assert low == pytest.approx(leakage, rel=1e-3, abs=0.0)
    phases = np.linspace(0.0, math.pi, 360, endpoint=False)
    seen = 0.5 * (seen_of_one_sided(phases, 3.0) + seen_of_one_sided(phases + 0.5 * math.pi, 3.0))
    most = leakage * one_sided_over_even(twenty_lands, seen, warmed(twenty_lands), 3.0)
    assert 1.2 * leakage < most < high  # phases differ from land to land, so that totals scatter around it
    assert high == pytest.approx(most, rel=0.1, abs=0.0)


@pytest.mark.parametrize("exponent", [1.0, 2.0, 3.0])
def test_four_directions_show_the_shape_and_two_some_of_it(
    worn: Callable, twenty_lands: Controller, exponent: float
) -> None:
    factor = one_sided_over_even(twenty_lands, np.array([1.0]), warmed(twenty_lands), exponent)
    even = worn((0.0, 45.0, 90.0, 135.0))[0]
    _, low, high = worn((0.0, 45.0, 90.0, 135.0), exponent=exponent)
    _, low_of_two, high_of_two = worn((0.0, 90.0), exponent=exponent)
    assert 0.94 * low < factor * even < 1.06 * high  # the gap's ends take some of a wide gap's flow
    assert low_of_two < factor * even < high_of_two
    assert high - low < 0.6 * (high_of_two - low_of_two)
    _, low, high = worn((0.0, 45.0, 90.0, 135.0), exponent=0.0)
    assert (low, high) == (pytest.approx(even, rel=0.02, abs=0.0), pytest.approx(even, rel=0.02, abs=0.0))


def test_differences_of_many_lands_tell_even_wear_from_a_crescent(twenty_lands: Controller, judge: Callable) -> None:
    assumptions = replace(ONE_SIDED, unseen_ovality=4e-6)
    likely = {}
    for exponent, ovality in ((0.0, 1e-6), (1.0, 0.0), (3.0, 0.0)):
        wear = (WORN - 1.0) * twenty_lands.lands[0].mounting_clearance
        sheet = a_sheet(twenty_lands, clearance=wear / (WORN - 1.0) * WORN, ovality=ovality)
        unit = judge(
            worn_to_one_side(sheet, wear, exponent),
            controller=twenty_lands,
            instruments=EXACT,
            assumptions=assumptions,
        ).unit
        sources = [land.sources for land in unit.lands]
        likely[exponent] = chances_of_sides(sources, 1.0, assumptions)
        assert likely[exponent].sum() == pytest.approx(1.0, abs=1e-12)
    even = slice(0, 3)
    assert likely[0.0][even].sum() > 0.9 > 0.11 > likely[1.0][even].sum()
    assert likely[3.0][-1] > likely[1.0][-1]
    copied = judge(a_sheet(twenty_lands, clearance=30e-6), controller=twenty_lands, instruments=EXACT).unit
    prior = chances_of_sides([land.sources for land in copied.lands], 1.0, assumptions)
    assert prior == pytest.approx([chance for *_, chance in SIDES], abs=1e-15)


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
