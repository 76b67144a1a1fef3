"""Time and share over engine speed and temperature: sums against counting by hand, edges around every value."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from atleak.diagnosis.diagnosis import Diagnosis
from atleak.measurements.road_test import RoadTest, Segment
from atleak.report.charts.operating_map import histogram, operating_map, sample_times

RPM = ("rpm", lambda value: value * 60.0)
CELSIUS = ("°C", lambda value: value)


def test_every_second_of_the_log_is_in_one_cell(worn: Diagnosis) -> None:
    test = worn.road.road_test
    cells = operating_map(test, worn.road, RPM, CELSIUS)
    assert cells.seconds.sum() + cells.left_out == pytest.approx(sample_times(test).sum(), rel=1e-9, abs=0.0)
    assert cells.speeds[0] <= np.nanmin(test.values("engine_speed")) * 60.0
    assert cells.speeds[-1] >= np.nanmax(test.values("engine_speed")) * 60.0
    assert cells.seconds.shape == (len(cells.temperatures) - 1, len(cells.speeds) - 1)
    assert np.nanmax(cells.largest) == pytest.approx(np.nanmax(worn.road.share) * 100.0, rel=1e-9, abs=0.0)


def test_the_mean_share_counts_each_sample_by_its_time(worn: Diagnosis, log_of) -> None:
    test = log_of([0.0, 1.0, 4.0, 5.0], engine_speed=20.0, atf_temperature=80.0)
    flow, pump = np.array([1.0, 3.0, 5.0, 9.0]), np.full(4, 10.0)
    road = replace(worn.road, road_test=test, time=test.time, leakage=flow, pump_capacity=pump)
    cells = operating_map(test, road, RPM, CELSIUS)
    assert cells.seconds.max() == pytest.approx(5.0, rel=1e-12, abs=0.0)
    assert np.nanmax(cells.share) == pytest.approx(100.0 * (0.1 * 1 + 0.3 * 3 + 0.5 * 1) / 5.0, rel=1e-9, abs=0.0)
    assert np.nanmax(cells.largest) == pytest.approx(90.0, rel=1e-9, abs=0.0)


def test_a_break_takes_no_time(log_of) -> None:
    log = log_of([0.0, 1.0, 100.0, 101.0], engine_speed=20.0)
    broken = RoadTest("", "", 4, 101.0, log.time, log.channels, (Segment(0, 2, 0.0, 1.0), Segment(2, 2, 100.0, 1.0)))
    assert sample_times(broken).tolist() == [1.0, 0.0, 1.0, 0.0]


def test_without_temperature_there_is_no_map_but_without_leakage_there_is(log_of) -> None:
    speed = log_of(np.arange(4.0), engine_speed=20.0)
    assert operating_map(speed, None, RPM, CELSIUS) is None
    both = log_of(np.arange(4.0), engine_speed=20.0, atf_temperature=[80.0, 90.0, np.nan, 80.0])
    cells = operating_map(both, None, RPM, CELSIUS)
    assert cells.share is None
    assert (cells.seconds.sum(), cells.left_out) == (2.0, 1.0)


@pytest.mark.parametrize("values", [[3.0, 3.0, 3.0], [0.0, 1e-3, 2e-3], [-40.0, 215.0, 80.0], [0.1, 1234.5, 99.0]])
def test_edges_are_few_and_around_every_value(log_of, values: list[float]) -> None:
    test = log_of([0.0, 1.0, 2.0], main_pressure=600e3)
    bars = histogram(test, np.array(values))
    assert bars.edges[0] <= min(values) <= max(values) <= bars.edges[-1] + 1e-9
    assert 1 <= len(bars.seconds) <= 25
    assert bars.seconds.sum() == pytest.approx(2.0, rel=1e-12, abs=0.0)


def test_a_channel_without_a_value_has_no_histogram(log_of) -> None:
    assert histogram(log_of([0.0, 1.0], main_pressure=600e3), np.full(2, np.nan)) is None
