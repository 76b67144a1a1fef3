"""Where the uncertainty of a clearance comes from."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from atleak.catalogue.controller import Controller
from atleak.catalogue.instruments import Instruments, load_instruments
from atleak.diagnosis.uncertainty import NOTHING_ELSE, Assumptions
from atleak.diagnosis.uncertainty.sources import LandSources, RepeatSpread, find_sources
from atleak.measurements.clearances import clearances
from tests.unit.diagnosis.uncertainty.conftest import a_sheet, an_instrument, two_instruments

UM = 1e-6


def _found(
    controller: Controller,
    sheet: object,
    instruments: Instruments,
    assumptions: Assumptions = NOTHING_ELSE,
) -> tuple[LandSources, dict[str, RepeatSpread]]:
    states = clearances(sheet, controller)
    lands, spreads = find_sources(states, sheet, controller, instruments, assumptions)
    return lands[0], spreads


def test_a_micrometre_and_a_half_on_each_diameter(four_speed: Controller) -> None:
    land, _ = _found(four_speed, a_sheet(four_speed, clearance=25 * UM), two_instruments())
    assert land.standard_uncertainty == pytest.approx(1.5 * UM / math.sqrt(2.0), rel=1e-6, abs=0.0)
    assert land.standard_uncertainty / land.state.radial_clearance == pytest.approx(0.04, abs=0.005)
    assert math.fsum(fraction for _, fraction in land.budget) == pytest.approx(1.0, rel=1e-12, abs=0.0)
    assert land.part_fraction("sleeve") == pytest.approx(0.5, rel=1e-6, abs=0.0)


def test_resolution_of_one_reading_is_rectangular(four_speed: Controller) -> None:
    tools = two_instruments(calibration=0.0, resolution=1 * UM, repeatability=None)
    land, spreads = _found(four_speed, a_sheet(four_speed, directions=(0.0,)), tools)
    # half the difference of two diameters, each within half a micrometre either way
    assert land.standard_uncertainty == pytest.approx(0.5 * math.sqrt(2.0) * UM / math.sqrt(12.0), rel=1e-9, abs=0.0)
    assert spreads["spool"].origin == "resolution"


def test_two_directions_a_step_apart_round_apart_whatever_the_diameter(four_speed: Controller) -> None:
    """A difference of one step decided by the last digit of floating point, from one diameter to the next."""
    tools = two_instruments(calibration=0.0, resolution=1 * UM, repeatability=None)
    sheet = a_sheet(four_speed, clearance=25 * UM)
    found = set()
    for size in range(12_001, 12_013):
        readings = tuple(
            replace(each, diameter=(size + 50 * (each.part == "sleeve") + (each.direction == 90.0)) * UM)
            for each in sheet.readings
        )
        land, _ = _found(four_speed, replace(sheet, readings=readings), tools)
        found.add(round(land.standard_uncertainty / UM, 9))
    assert found == {round(0.5 / math.sqrt(12.0), 9)}


def test_mirrored_and_identical_repeats_count_as_resolution_not_as_zero(four_speed: Controller) -> None:
    tools = two_instruments(calibration=0.0, resolution=1 * UM, repeatability=None)
    once, _ = _found(four_speed, a_sheet(four_speed), tools)
    copied, spreads = _found(four_speed, a_sheet(four_speed, repeats=3), tools)
    assert spreads["sleeve"].degrees_of_freedom == 0
    assert copied.standard_uncertainty == pytest.approx(once.standard_uncertainty, rel=1e-12, abs=0.0)
    assert copied.standard_uncertainty > 0.2 * UM
    one, _ = _found(four_speed, a_sheet(four_speed, repeats=1, mirrored=True), tools)
    two, spreads = _found(four_speed, a_sheet(four_speed, repeats=2, mirrored=True), tools)
    assert spreads["spool"].degrees_of_freedom == 0
    assert two.standard_uncertainty == pytest.approx(one.standard_uncertainty, rel=1e-12, abs=0.0)
    # a diameter from two coordinates is rounded twice
    assert one.standard_uncertainty == pytest.approx(math.sqrt(2.0) * once.standard_uncertainty, rel=1e-9, abs=0.0)


def test_no_independent_repeats_falls_back_on_the_instruments_own_repeatability(four_speed: Controller) -> None:
    tools = two_instruments(calibration=0.0, repeatability=1 * UM)
    one, spreads = _found(four_speed, a_sheet(four_speed, directions=(0.0,)), tools)
    assert spreads["spool"].origin == "instrument"
    assert one.standard_uncertainty == pytest.approx(UM / math.sqrt(2.0), rel=1e-6, abs=0.0)
    copied, _ = _found(four_speed, a_sheet(four_speed, directions=(0.0,), repeats=2, mirrored=True), tools)
    assert copied.standard_uncertainty == pytest.approx(one.standard_uncertainty, rel=1e-6, abs=0.0)


@pytest.mark.parametrize("step", [0.0, 1e-6, 2e-6])
def test_repeats_are_pooled_over_the_unit_and_freed_of_rounding(four_speed: Controller, step: float) -> None:
    tools = two_instruments(calibration=0.0, resolution=max(step, 1e-9))
    sheet = a_sheet(four_speed, repeats=5, noise=0.9 * UM, step=step)
    land, spreads = _found(four_speed, sheet, tools)
    degrees = spreads["sleeve"].degrees_of_freedom
    assert degrees == 2 * 4 * sum(len(each.planes) for each in four_speed.lands)
    error = 4.0 / math.sqrt(2.0 * degrees)  # four standard errors of a standard deviation
    assert spreads["sleeve"].standard_deviation == pytest.approx(0.9 * UM, rel=error, abs=0.0)
    plan = land.plans["sleeve"]
    assert plan.repeats == 5
    assert plan.repeat_weight == pytest.approx(1.0 / (2 * 5 * len(land.state.land.planes)), rel=1e-12, abs=0.0)


def test_few_repeats_that_agree_by_chance_do_not_make_a_good_instrument(four_speed: Controller) -> None:
    one_land = replace(four_speed, lands=four_speed.lands[:1])
    tools = two_instruments(calibration=0.0, resolution=0.1 * UM, repeatability=1 * UM)
    _, spreads = _found(one_land, a_sheet(one_land, repeats=2, noise=0.15 * UM, step=0.1 * UM), tools)
    assert 0 < spreads["spool"].degrees_of_freedom < 6
    assert spreads["spool"].origin == "instrument"
    assert spreads["spool"].standard_deviation == 1 * UM


def test_common_error_of_one_instrument_for_both_parts_drops_out(four_speed: Controller) -> None:
    tool = an_instrument(common_part=1.0)
    sheet = a_sheet(four_speed)
    same, _ = _found(four_speed, sheet, Instruments(tool, tool))
    assert same.standard_uncertainty < 0.01 * UM
    two, _ = _found(four_speed, sheet, two_instruments(common_part=1.0))
    assert two.own_variance < (0.01 * UM) ** 2
    assert two.standard_uncertainty == pytest.approx(1.0607 * UM, rel=1e-3, abs=0.0)
    heads = an_instrument(common_part=1.0, alike_inside_and_outside=False)
    apart, _ = _found(four_speed, sheet, Instruments(heads, heads))
    assert apart.standard_uncertainty == pytest.approx(two.standard_uncertainty, rel=1e-9, abs=0.0)


def test_a_sheet_written_coarser_than_the_instrument_reads(four_speed: Controller) -> None:
    tools = two_instruments(calibration=0.0, resolution=0.1 * UM)
    _, fine = _found(four_speed, a_sheet(four_speed, noise=9 * UM, step=1 * UM), tools)
    _, coarse = _found(four_speed, a_sheet(four_speed, clearance=300 * UM, noise=40 * UM, step=10 * UM), tools)
    assert fine["spool"].resolution == pytest.approx(1 * UM, rel=1e-12, abs=0.0)
    assert coarse["spool"].resolution == pytest.approx(10 * UM, rel=1e-12, abs=0.0)


def test_directions_that_cross_evenly_take_the_ovality_out(four_speed: Controller) -> None:
    tools = two_instruments(calibration=0.0)
    seen = replace(NOTHING_ELSE, unseen_ovality=4 * UM)
    crossed, _ = _found(four_speed, a_sheet(four_speed, directions=(0.0, 90.0)), tools, seen)
    assert crossed.standard_uncertainty < 0.01 * UM
    three, _ = _found(four_speed, a_sheet(four_speed, directions=(0.0, 60.0, 120.0)), tools, seen)
    assert three.standard_uncertainty < 0.01 * UM
    askew, _ = _found(four_speed, a_sheet(four_speed, directions=(0.0, 45.0), ovality=4 * UM), tools, seen)
    assert askew.standard_uncertainty > 0.4 * UM


def test_what_was_not_measured_has_the_uncertainty_of_its_catalogue_value(four_speed: Controller) -> None:
    sheet = a_sheet(four_speed)
    only_sleeves = replace(sheet, readings=tuple(r for r in sheet.readings if r.part == "sleeve"))
    given = replace(NOTHING_ELSE, nominal_diameter=3 * UM, mounting_clearance=0.5 * UM)
    land, _ = _found(four_speed, only_sleeves, two_instruments(calibration=0.0), given)
    assert land.standard_uncertainty == pytest.approx(1.5 * UM, rel=1e-4, abs=0.0)
    only_spools = replace(sheet, readings=tuple(r for r in sheet.readings if r.part == "spool"))
    land, _ = _found(four_speed, only_spools, two_instruments(calibration=0.0), given)
    assert land.standard_uncertainty == pytest.approx(0.5 * math.hypot(3.0, 1.0) * UM, rel=1e-4, abs=0.0)
    land, _ = _found(four_speed, None, two_instruments(), given)
    assert land.standard_uncertainty == pytest.approx(0.5 * UM, rel=1e-9, abs=0.0)


def test_a_gauge_that_expands_as_the_part_does_hides_the_temperature(four_speed: Controller) -> None:
    given = replace(NOTHING_ELSE, room_temperature=5.0)
    sheet = a_sheet(four_speed)
    only_spools = replace(sheet, readings=tuple(r for r in sheet.readings if r.part == "spool"))
    steel, _ = _found(four_speed, only_spools, two_instruments(calibration=0.0, expansion=12e-6), given)
    assert steel.state.land.spool_expansion == 12e-6
    assert steel.groups["measuring temperature"] == 0.0
    # another gauge may expand otherwise: what if it had measured counts that too
    glass = two_instruments(calibration=0.0, expansion=8e-6)
    other = steel.variance_with(instruments={"spool": glass.spool})
    alone, _ = _found(four_speed, only_spools, glass, given)
    assert other == pytest.approx(alone.standard_uncertainty**2, rel=1e-12, abs=0.0)
    assert other > steel.standard_uncertainty**2


def test_what_if_agrees_with_measuring_so(four_speed: Controller) -> None:
    tools = load_instruments()
    noisy = a_sheet(four_speed, repeats=2, noise=1 * UM, step=1 * UM)
    land, spreads = _found(four_speed, noisy, tools)
    assert land.variance_with() == pytest.approx(land.standard_uncertainty**2, rel=1e-12, abs=0.0)
    many = land.variance_with(repeats={"spool": 8, "sleeve": 8})
    repeats = sum(source.standard_uncertainty**2 for source in land.sources if source.kind == "repeats")
    assert many == pytest.approx(land.standard_uncertainty**2 - 0.75 * repeats, rel=1e-9, abs=0.0)
    air = load_instruments("air_gauge", "air_gauge")
    better = land.variance_with(instruments={"spool": air.spool, "sleeve": air.sleeve})
    assert better < 0.2 * land.standard_uncertainty**2
    assert spreads["spool"].origin == "repeats"


def test_settings_speak_the_workshops_units() -> None:
    given = Assumptions().with_settings({"viscosity_percent": "12,5", "room_temperature_k": 3})
    assert given.viscosity == 0.125
    assert given.room_temperature == 3.0
    assert Assumptions().with_settings(Assumptions().settings) == Assumptions()
