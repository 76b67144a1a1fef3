"""Extremes of a log: single samples, and a running median that noise and single wrong samples do not move."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

import numpy as np
import pytest

from atleak.catalogue.controller import Controller
from atleak.catalogue.fluid import Fluid
from atleak.engine.extremes import SUSTAINED_SECONDS, Extremes, running_median, sustained_window
from atleak.engine.leakage import LeakageModel
from atleak.engine.profile import WORKSHOP
from atleak.engine.road_leakage import RoadLeakage, evaluate_road_test
from atleak.measurements.clearances import clearances
from atleak.measurements.road_test import RoadTest, Segment
from atleak.readers.logs import read_road_test
from atleak.readers.sheets.measuring_sheet import read_readings
from tests.effort import most_calls

LogOf = Callable[..., RoadTest]
NAN = float("nan")


def slow_median(values: np.ndarray, time: np.ndarray, window: float) -> np.ndarray:
    """The running median one window at a time, as it is defined."""
    medians = []
    for middle in time:
        near = values[np.abs(time - middle) <= 0.5 * window + 1e-9]
        near = near[np.isfinite(near)]
        medians.append(np.median(near) if len(near) >= 5 else NAN)
    return np.array(medians)


def extremes_of(values: np.ndarray, time: np.ndarray, segments: tuple[Segment, ...] = ()) -> Extremes:
    return Extremes(time, values, None, segments, SUSTAINED_SECONDS)


def test_the_running_median_agrees_with_one_window_at_a_time() -> None:
    generator = np.random.default_rng(5)
    time = np.cumsum(generator.uniform(0.01, 0.2, 400))
    values = generator.normal(size=400)
    values[generator.random(400) < 0.1] = NAN
    np.testing.assert_allclose(running_median(values, time, 1.3), slow_median(values, time, 1.3), rtol=1e-12)


def test_the_median_of_a_long_log_is_the_same_at_gaps_missing_values_and_uneven_stamps(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    generator = np.random.default_rng(6)
    steps = np.full(3000, 0.01)
    steps[700] = 40.0  # a gap
    steps[1200:1300] = generator.uniform(0.002, 0.1, 100)
    time, values = np.cumsum(steps), generator.normal(size=3000)
    values[[3, 400, 401, 1250, 2400]] = NAN
    values[2000:2100] = NAN
    expected = running_median(values, time, 0.5)
    monkeypatch.setattr("atleak.engine.extremes._LONG", 0)
    np.testing.assert_array_equal(running_median(values, time, 0.5), expected)
    np.testing.assert_allclose(expected, slow_median(values, time, 0.5), rtol=1e-12)


def test_a_spike_is_a_single_sample_and_what_lasts_is_sustained() -> None:
    time = np.arange(0.0, 5.0, 0.01)
    values = np.ones(len(time))
    values[100] = 9.0
    values[300:360] = 2.0
    extremes = extremes_of(values, time)
    assert (extremes.max_leakage.time, extremes.max_leakage.leakage) == (1.0, 9.0)
    sustained = extremes.max_leakage_sustained
    assert sustained is not None
    assert sustained.leakage == 2.0
    assert 3.0 <= sustained.time <= 3.6
    assert values[sustained.sample] == 2.0
    assert (sustained.pump_capacity, sustained.share) == (None, None)


def test_no_window_reaches_into_another_segment() -> None:
    time = np.arange(40) * 0.05
    values = np.ones(40)
    values[18:24] = 5.0  # six neighbours, two in each of three segments
    assert extremes_of(values, time).max_leakage_sustained.leakage == 5.0
    apart = tuple(Segment(row, rows, row * 0.05, (rows - 1) * 0.05) for row, rows in ((0, 20), (20, 2), (22, 18)))
    assert extremes_of(values, time, apart).max_leakage_sustained.leakage == 1.0


def test_fewer_than_five_samples_sustain_nothing() -> None:
    time = np.arange(0.0, 0.04, 0.01)
    extremes = extremes_of(np.array([1.0, 2.0, NAN, 1.0]), time)
    assert extremes.max_leakage.leakage == 2.0
    assert extremes.max_leakage_sustained is None


@pytest.mark.parametrize(("rate", "window"), [(100.0, 0.5), (10.0, 0.5), (2.0, 2.5)])
def test_a_slow_log_has_a_window_of_five_samples(log_of: LogOf, rate: float, window: float) -> None:
    log = log_of(np.arange(0.0, 20.0, 1.0 / rate), main_pressure=600e3, atf_temperature=80.0)
    assert sustained_window(log) == pytest.approx(window, rel=1e-9, abs=0.0)


def test_a_pressure_that_the_logger_holds_counts_by_its_own_rate(log_of: LogOf) -> None:
    log = log_of(np.arange(0.0, 20.0, 0.01), main_pressure=600e3, engine_speed=20.0)
    held = replace(log.channels["main_pressure"], sampling_hz=2.0)
    slow = replace(log, channels=MappingProxyType({**log.channels, "main_pressure": held}))
    assert sustained_window(slow) == pytest.approx(2.5, rel=1e-9, abs=0.0)


# --- the sample log


@pytest.fixture(scope="module")
def model(four_speed: Controller, hipol: Fluid, sample_readings: Path) -> LeakageModel:
    states = clearances(read_readings(sample_readings, four_speed), four_speed)
    return LeakageModel(four_speed, states, hipol, WORKSHOP.with_options(form="cube_of_mean", entry_loss="off"))


@pytest.fixture(scope="module")
def log(sample_log: Path) -> RoadTest:
    return read_road_test(sample_log)


def over(model: LeakageModel, log: RoadTest) -> RoadLeakage:
    return evaluate_road_test(model, log, model.controller.operating_points[0])


def noisy(log: RoadTest, pressure: float, temperature: float, seed: int) -> RoadTest:
    """The log with white noise on its pressures [Pa] and its temperature [K]."""
    generator = np.random.default_rng(seed)
    spread = {"main_pressure": pressure, "converter_pressure": pressure, "atf_temperature": temperature}
    channels = dict(log.channels)
    for name, width in spread.items():
        values = channels[name].values
        channels[name] = replace(channels[name], values=values + generator.normal(0.0, width, len(values)))
    return replace(log, channels=MappingProxyType(channels), _held={})


def test_the_sample_log_is_read_as_before_and_its_sustained_extremes_lie_near(
    model: LeakageModel, log: RoadTest
) -> None:
    road = over(model, log)
    assert road.start is None
    assert (road.max_leakage.time, round(road.max_leakage.leakage * 6e4, 2)) == (2.10, 2.83)
    sustained = road.extremes.max_leakage_sustained
    assert sustained is not None
    assert sustained.leakage == pytest.approx(road.max_leakage.leakage, rel=0.01, abs=0.0)


def test_noise_lifts_the_largest_sample_by_a_quarter_and_the_sustained_extremes_by_next_to_nothing(
    model: LeakageModel, log: RoadTest
) -> None:
    clean = over(model, log).extremes
    lifted, moved = [], []
    for seed in range(10):
        extremes = over(model, noisy(log, 40e3, 2.0, seed)).extremes
        lifted.append(extremes.max_leakage.leakage / clean.max_leakage.leakage)
        for now, before in (
            (extremes.max_leakage_sustained.leakage, clean.max_leakage_sustained.leakage),
            (extremes.max_share_sustained.share, clean.max_share_sustained.share),
        ):
            moved.append(now / before)
    assert np.mean(lifted) > 1.15
    assert max(lifted) > 1.25
    np.testing.assert_allclose(moved, 1.0, rtol=0.05)


def test_a_long_log_has_no_loop_over_its_samples() -> None:
    time = np.arange(180_000) * 0.01
    values = np.random.default_rng(1).normal(size=len(time))
    import scipy.ndimage  # noqa: F401  whose own calls do not count

    with most_calls(10_000):
        assert extremes_of(values, time).max_leakage_sustained is not None
