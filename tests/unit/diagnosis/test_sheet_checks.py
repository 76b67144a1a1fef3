"""A measuring sheet as a whole: what its lands show only together."""

from __future__ import annotations

import datetime as dt
from collections.abc import Callable
from dataclasses import replace
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.instruments import load_instruments
from atleak.catalogue.limits import Limits
from atleak.common.errors import Message
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.diagnosis.messages import CommonShift, common_shift
from atleak.diagnosis.uncertainty import DEFAULTS
from atleak.diagnosis.uncertainty.sources import find_sources
from atleak.measurements.clearances import clearances
from atleak.measurements.readings import Reading, Readings
from atleak.measurements.road_test import RoadTest

UM = 1e-6
CONTROLLERS = {name: load_controller(name) for name in ("four_speed_2023", "minimal_example")}
every_controller = pytest.mark.parametrize("controller", CONTROLLERS.values(), ids=CONTROLLERS)
Clearance = Callable[[float], float]  # mounting clearance → clearance [m]


def a_sheet(
    controller: Controller,
    clearance: Clearance,
    repeats: tuple[int, int] = (2, 2),
    worn: dict[int, float] | None = None,
) -> Readings:
    """Every land as asked, written to 0.001 mm; ``worn`` adds to the clearance of lands by their index [m]."""
    readings = []
    for index, land in enumerate(controller.lands):
        open_by = clearance(land.new_clearance) + (worn or {}).get(index, 0.0)
        sizes = (("spool", land.nominal_diameter), ("sleeve", land.nominal_diameter + 2.0 * open_by))
        for (part, diameter), count in zip(sizes, repeats, strict=True):
            for direction in (0.0, 90.0):
                for repeat in range(1, count + 1):
                    read = round(diameter, 6)
                    readings.append(Reading(land.component, part, land.planes[0], direction, repeat, read))  # type: ignore[arg-type]
    return Readings("sheet.csv", "0" * 64, None, "mm", False, "tidy", tuple(readings))


def shift_of(controller: Controller, sheet: Readings) -> CommonShift | None:
    sources, _ = find_sources(clearances(sheet, controller), sheet, controller, load_instruments(), DEFAULTS)
    return common_shift(sources)


# --- all pairs moved alike


@every_controller
@pytest.mark.parametrize("offset", [3.0, -3.0, 5.0])
def test_a_setting_ring_moves_all_pairs_alike(controller: Controller, offset: float) -> None:
    found = shift_of(controller, a_sheet(controller, lambda new: new + offset * UM))
    assert found is not None
    assert found.shift == pytest.approx(offset * UM, abs=0.15 * UM)
    assert found.pairs == found.agreeing == len(controller.lands)
    assert 0.0 < found.standard_uncertainty < 0.6 * UM < found.common_error < 1.0 * UM


@every_controller
@pytest.mark.parametrize("times", [1.0, 1.05, 1.1, 1.25, 2.0])
def test_a_new_or_evenly_grown_unit_did_not_move(controller: Controller, times: float) -> None:
    assert shift_of(controller, a_sheet(controller, lambda new: times * new)) is None


@every_controller
def test_what_a_certificate_allows_is_not_reported(controller: Controller) -> None:
    assert shift_of(controller, a_sheet(controller, lambda new: new + 1.5 * UM)) is None


@pytest.mark.parametrize("seed", range(20))
def test_wear_that_spreads_is_no_shift(seed: int) -> None:
    controller = CONTROLLERS["four_speed_2023"]
    worn = dict(enumerate(np.random.default_rng(seed).exponential(5 * UM, len(controller.lands))))
    assert shift_of(controller, a_sheet(controller, lambda new: new, worn=worn)) is None


def test_a_few_worn_pairs_do_not_hide_that_all_moved() -> None:
    controller = CONTROLLERS["four_speed_2023"]
    found = shift_of(
        controller, a_sheet(controller, lambda new: new + 3 * UM, worn={1: 12 * UM, 7: 8 * UM, 20: 30 * UM})
    )
    assert found is not None
    assert found.shift == pytest.approx(3 * UM, abs=0.1 * UM)
    assert found.agreeing == len(controller.lands) - 3


def test_a_mounting_clearance_that_is_hardly_known_shows_no_shift() -> None:
    controller = CONTROLLERS["four_speed_2023"]
    sheet = a_sheet(controller, lambda new: new + 3 * UM)
    by_range = (replace(land, mounting_clearance=(6.4 * UM, 30 * UM)) for land in controller.lands)
    assert shift_of(replace(controller, lands=tuple(by_range)), sheet) is None
    by_type = (replace(land, mounting_tolerance=6 * UM) for land in controller.lands)
    assert shift_of(replace(controller, lands=tuple(by_type)), sheet) is None


def test_few_pairs_show_no_shift() -> None:
    controller = CONTROLLERS["four_speed_2023"]
    sheet = a_sheet(controller, lambda new: new + 5 * UM)
    components = list(dict.fromkeys(land.component for land in controller.lands))[:2]
    few = tuple(each for each in sheet.readings if each.component in components)
    assert shift_of(controller, replace(sheet, readings=few)) is None


def test_the_rates_of_the_benchmark_hold(benchmark_of: Callable[[str], ModuleType]) -> None:
    """Of a few units each: worn ones are not said to have moved, those that moved mostly are."""
    module = benchmark_of("common_shift")
    kinds = {kind.name: kind for kind in module.KINDS}

    def said(name: str, units: int = 15) -> int:
        controller = CONTROLLERS["four_speed_2023"]
        generators = (np.random.default_rng((1, unit)) for unit in range(units))
        return sum(module._shift_of(controller, kinds[name], rng) is not None for rng in generators)

    assert said("worn by 15 % in the mean") == 0
    assert said("new, +5 µm") >= 13


# --- what is said


@pytest.fixture
def messages_of(hipol: Fluid, limits: Limits) -> Callable[..., dict[str, Message]]:
    def diagnosed(sheet: Readings, controller: Controller, **more: Any) -> dict[str, Message]:
        result: Diagnosis = diagnose(controller, hipol, limits, readings=sheet, **more)
        codes = [message.code for message in result.messages]
        assert len([code for code in codes if code in OF_SHEET]) == len({code for code in codes if code in OF_SHEET})
        return {message.code: message for message in result.messages if message.code in OF_SHEET}

    return diagnosed


OF_SHEET = {
    "pairs_moved_alike",
    "tighter_than_new",
    "clearance_far_open",
    "unequal_repeats",
    "measuring_temperature_differs",
    "sheet_older_than_road_test",
}


def test_nothing_is_said_of_a_sound_sheet(messages_of: Callable, minimal: Controller) -> None:
    assert messages_of(a_sheet(minimal, lambda new: new), minimal) == {}


@pytest.mark.parametrize("times", [6.0, 9.0])
def test_a_pair_opened_many_times_its_mounting_clearance_is_asked_about(
    messages_of: Callable, minimal: Controller, times: float
) -> None:
    land = minimal.lands[-1]
    sheet = a_sheet(minimal, lambda new: new, worn={len(minimal.lands) - 1: (times - 1.0) * land.new_clearance})
    message = messages_of(sheet, minimal).get("clearance_far_open")
    assert (message is not None) == (times > 8.0)
    assert message is None or message.text.startswith(f"{land.component}/{land.land}: radial clearance 1")


def test_a_shift_is_said_once_with_its_estimate_and_corrects_nothing(
    messages_of: Callable, minimal: Controller, hipol: Fluid, limits: Limits
) -> None:
    sheet = a_sheet(minimal, lambda new: new + 3 * UM)
    message = messages_of(sheet, minimal)["pairs_moved_alike"]
    assert message.level == "warning"
    assert message.place.file == "sheet.csv"
    assert "5 of 5 measure 3.0 ± " in message.text
    assert "µm wider than their mounting clearance" in message.text
    lands = diagnose(minimal, hipol, limits, readings=sheet).lands
    for land in lands:
        grown = land.state.radial_clearance - land.state.land.new_clearance
        assert grown == pytest.approx(3 * UM, abs=0.5 * UM)


def test_parts_measured_unequally_often_are_said_once_for_the_sheet(messages_of: Callable, minimal: Controller) -> None:
    message = messages_of(a_sheet(minimal, lambda new: new, repeats=(3, 1)), minimal)["unequal_repeats"]
    assert "In 5 of 5 pairs spools were measured 3 times in each place, sleeves once" in message.text
    assert "the sleeve limits" in message.text
    one = a_sheet(minimal, lambda new: new)
    last = [
        each for each in one.readings if each.component != "accumulator" or each.part == "sleeve" or each.repeat == 1
    ]
    assert "unequal_repeats" not in messages_of(replace(one, readings=tuple(last)), minimal)


@pytest.mark.parametrize(("days", "said"), [(-400, False), (0, False), (30, False), (31, True), (400, True)])
def test_a_sheet_much_older_than_the_road_test_is_named(
    messages_of: Callable, minimal: Controller, log_of: Callable[..., RoadTest], days: int, said: bool
) -> None:
    sheet = replace(a_sheet(minimal, lambda new: new), date=dt.date(2026, 3, 14))
    log = log_of(np.arange(10.0), engine_speed=20.0, main_pressure=8e5, atf_temperature=80.0, gear=2.0)
    drive = replace(log, date=dt.date(2026, 3, 14) + dt.timedelta(days))
    assert ("sheet_older_than_road_test" in messages_of(sheet, minimal, road_test=drive)) is said
    assert messages_of(sheet, minimal, road_test=log) == {}
    if said:
        text = messages_of(sheet, minimal, road_test=drive)["sheet_older_than_road_test"].text
        assert f"dated 2026-03-14, the road test own.csv {drive.date}: {days} days later" in text
