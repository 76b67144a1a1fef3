"""A log without main pressure takes that of the valve body's operating points, says so, and is not judged by it."""

from __future__ import annotations

import numpy as np
import pytest

from atleak.catalogue.controller_file import load_controller
from atleak.engine.road_leakage import with_assumed_pressure
from atleak.engine.road_pressure import judge_pressure
from atleak.measurements.road_test import RoadTest
from atleak.readers.logs import read_road_test


def log(head: str = "Time (s),RPM (rpm),Gear", row: str = "{i},{rpm},{gear}") -> RoadTest:
    rows = (row.format(i=i, rpm=800 if i < 10 else 1500, gear=1 if i < 20 else 3) for i in range(40))
    return read_road_test("\n".join([head, *rows]).encode())


def test_every_sample_has_the_pressure_of_its_gear_and_state() -> None:
    controller = load_controller("four_speed_2023")
    driven = with_assumed_pressure(controller, log())
    kpa = driven.values("main_pressure") / 1e3
    assert kpa[:10] == pytest.approx(np.full(10, 500.0), rel=1e-12, abs=0.0)  # hot idle, first gear
    assert kpa[10:] == pytest.approx(np.full(30, 800.0), rel=1e-12, abs=0.0)  # the only point that drives
    assert driven.channels["main_pressure"].source == "derived"
    (said,) = (message for message in driven.messages if message.code == "pressure_assumed")
    assert said.level == "warning"
    assert "500 kPa (hot idle in drive, 100 °C); 800 kPa (driving in second, 80 °C)" in said.text
    assert judge_pressure(controller, driven) == "not_measured"


def test_without_gear_and_speed_the_first_operating_point_stands_for_all() -> None:
    driven = with_assumed_pressure(load_controller("four_speed_2023"), log("Time (s),ATF Temp (C)", "{i},80"))
    assert set(driven.values("main_pressure")) == {800e3}


def test_a_logged_pressure_is_never_replaced() -> None:
    logged = log("Time (s),Line Pressure (kPa)", "{i},{rpm}")
    driven = with_assumed_pressure(load_controller("four_speed_2023"), logged)
    assert driven.values("main_pressure") is logged.values("main_pressure")
    assert "pressure_not_assumed" in {message.code for message in driven.messages}
