"""Ranges of the lever, the gears that stand for them, and what a file permits in each."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from atleak.catalogue.controller_file import load_controller
from atleak.common.errors import CatalogueError, Place
from atleak.measurements.gauge_readings import (
    LINE_TAP,
    Engine,
    GaugeCell,
    GaugeReading,
    PressureTable,
    gear_in,
    ranges_of,
)

Permitting = Callable[[str], Path]
PERMISSIBLE = (
    '\n[[permissible_pressure]]\ngear = 1\nstate = "idle"\nlow_kpa = 412.0\nhigh_kpa = 539.0\nsource = "own"\n'
    '\n[[permissible_pressure]]\nranges = ["R", "N"]\nstate = "idle"\nlow_kpa = 726.0\nsource = "own"\n'
    '\n[[permissible_pressure]]\ngears = [1]\nranges = ["S"]\nstate = "fast_idle"\nhigh_kpa = 900.0\nsource = "own"\n'
)


@pytest.mark.parametrize(
    ("selected", "gears", "gear"),
    [
        ("D", (1, 2, 3, 4), 1),
        ("2", (-1, 0, 1, 2), 1),
        ("R", (-1, 0, 1, 2), -1),
        ("R", (-2, -1, 1), -1),
        ("N", (-1, 0, 1), 0),
        ("N", (1, 2), None),
        ("P", (-1, 0, 1), 0),
        ("P", (-1, 1), None),
        ("R", (1, 2), None),
        ("D", (0,), None),
    ],
)
def test_a_standing_vehicle_is_in_the_lowest_gear_of_a_forward_range(selected, gears, gear) -> None:
    assert gear_in(selected, gears) == gear


def test_a_unit_has_a_range_for_every_gear_below_the_highest_and_those_its_file_names(permitting: Permitting) -> None:
    assert ranges_of(load_controller("four_speed_2023")) == ("P", "R", "N", "D", "3", "2", "1")
    assert ranges_of(load_controller(permitting(PERMISSIBLE)))[-1] == "S"


def test_a_files_permissible_pressure_holds_for_the_range_it_names_or_else_for_its_gear(permitting: Permitting) -> None:
    controller = load_controller(permitting(PERMISSIBLE))
    low = {
        selected: getattr(controller.permissible_in(selected, gear_in(selected, controller.gears), "idle"), "low", None)
        for selected in ranges_of(controller)
    }
    assert low == {"P": None, "R": 726e3, "N": 726e3, "D": 412e3, "3": 412e3, "2": 412e3, "1": 412e3, "S": 412e3}
    fast = controller.permissible_in("D", 1, "fast_idle")
    assert fast is not None
    assert (fast.low, fast.high) == (None, 900e3)
    assert controller.permissible_at(1, "idle") is not None
    assert controller.permissible_at(2, "idle") is None


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ('state = "idle"\nlow_kpa = 400.0', "gear, gears or ranges"),
        ('ranges = ["Z"]\nstate = "idle"\nlow_kpa = 400.0', "'P', 'R', 'N', 'D'"),
        ('ranges = []\nstate = "idle"\nlow_kpa = 400.0', "a list of at least 1"),
        ('ranges = ["R"]\nstate = "idle"\nlow_kpa = 400.0', "range given twice for the state idle"),
        ('gear = 1\nstate = "idle"\nlow_kpa = 400.0', "gear given twice for the state idle"),
        ('gear = 1\ngears = [1]\nstate = "stall"\nlow_kpa = 400.0', "either gear or gears"),
    ],
)
def test_permissible_pressures_that_cannot_be_are_refused(permitting: Permitting, table: str, said: str) -> None:
    path = permitting(f'{PERMISSIBLE}\n[[permissible_pressure]]\n{table}\nsource = "own"\n')
    with pytest.raises(CatalogueError) as caught:
        load_controller(path)
    assert said in str(caught.value)


def test_readings_of_a_cell_come_in_the_order_in_which_they_were_taken() -> None:
    cell = GaugeCell("D", Engine.SLOW_IDLE)
    readings = (
        GaugeReading(cell, 2.0, 2),
        GaugeReading(cell, 1.0, 1),
        GaugeReading(GaugeCell("R", Engine.STALL, "c1"), 3.0),
    )
    table = PressureTable("f", "0", None, ("kPa",), readings)
    assert [each.pressure for each in table.at(cell)] == [1.0, 2.0]
    assert table.at(GaugeCell("N", Engine.STALL)) == ()
    assert table.taps == (LINE_TAP, "c1")
    assert readings[0].place == Place()
