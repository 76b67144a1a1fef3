"""Time, leakage, share and pressure of a log by ranges of fluid temperature: against a slow loop over its samples."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from atleak.catalogue.controller import Controller
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.limits import Limits
from atleak.common.verdicts import BANDS, Band
from atleak.engine.extremes import CountedSamples
from atleak.engine.leakage import LeakageModel
from atleak.engine.profile import WORKSHOP
from atleak.engine.projection import model_unworn
from atleak.engine.road_leakage import RoadLeakage, evaluate_road_test
from atleak.engine.road_pressure import temperature_classes
from atleak.measurements.clearances import LandClearance, clearances
from atleak.measurements.road_test import RoadTest, Segment
from atleak.readers.sheets.measuring_sheet import read_readings

LogOf = Callable[..., RoadTest]
NAN = math.nan


@pytest.fixture(scope="module")
def states(four_speed: Controller, sample_readings: Path) -> tuple[LandClearance, ...]:
    return clearances(read_readings(sample_readings, four_speed), four_speed)


@pytest.fixture(scope="module")
def model(four_speed: Controller, hipol: Fluid, states: tuple[LandClearance, ...]) -> LeakageModel:
    return LeakageModel(four_speed, states, hipol, WORKSHOP)


@pytest.fixture(scope="module")
def unworn(model: LeakageModel, states: tuple[LandClearance, ...]) -> LeakageModel:
    return model_unworn(states, model)


@pytest.fixture(scope="module")
def warming(log_of: LogOf) -> RoadTest:
    """Two stretches in which the fluid warms, from an engine that stands to one that turns fast, with holes."""
    generator = np.random.default_rng(3)
    count = 900
    time = np.cumsum(generator.uniform(0.02, 0.2, count))
    pressure = generator.uniform(300e3, 1500e3, count)
    temperature = np.linspace(41.0, 108.0, count) + generator.normal(0.0, 3.0, count)
    speed = np.where(np.arange(count) < 60, 0.0, generator.uniform(8.0, 60.0, count))
    for channel in (pressure, temperature, speed):
        channel[generator.random(count) < 0.03] = NAN
    gear = np.repeat([1.0, 2.0, 3.0, 2.0, 7.0, 4.0], count // 6)
    log = log_of(
        time, main_pressure=pressure, atf_temperature=temperature, engine_speed=speed, gear=gear,
        converter_pressure=250e3,
    )  # fmt: skip
    halves = ((0, 400), (400, count - 400))
    return replace(
        log, segments=tuple(Segment(at, rows, time[at], time[at + rows - 1] - time[at]) for at, rows in halves)
    )


def over(model: LeakageModel, log: RoadTest) -> RoadLeakage:
    return evaluate_road_test(model, log, model.controller.operating_points[0])


def by_loop(road: RoadLeakage, new: RoadLeakage, limits: Limits) -> dict[float, dict[str, float]]:
    """The sums of every class, sample by sample."""
    log, steps = road.road_test, CountedSamples(road.road_test).steps
    temperature, pressure = log.values("atf_temperature"), log.values("main_pressure")
    ends = {segment.start_row + segment.rows - 1 for segment in log.segments}
    found: dict[float, dict[str, float]] = defaultdict(lambda: defaultdict(float))
    for sample in range(len(log.time)):
        if sample in ends or steps[sample] == 0.0 or math.isnan(temperature[sample] + road.leakage[sample]):
            continue
        step = log.time[sample + 1] - log.time[sample]
        sums = found[5.0 * math.floor(temperature[sample] / 5.0)]
        sums["seconds"] += step
        sums["leakage"] += step * road.leakage[sample]
        sums["pressure"] += step * pressure[sample]
        sums["pressure_min"] = min(sums.get("pressure_min", math.inf), pressure[sample])
        capacity = road.pump_capacity[sample]
        if capacity > 0.0:
            share, share_new = road.leakage[sample] / capacity, new.leakage[sample] / capacity
            judged = replace(limits.total_share, levels=limits.total_share.over(share_new))
            sums[judged.judge(share, Band.GREEN)[0]] += step
            sums["with_share"] += step
            sums["share"] += step * share
            sums["share_max"] = max(sums["share_max"], share)
    return found


def test_every_class_agrees_with_a_loop_over_the_samples(
    model: LeakageModel, unworn: LeakageModel, limits: Limits, warming: RoadTest
) -> None:
    road = over(model, warming)
    classes = temperature_classes(road, limits.total_share, unworn)
    expected = by_loop(road, over(unworn, warming), limits)
    assert [each.low for each in classes] == sorted(expected)
    assert len({band for each in classes for band, seconds in each.in_bands.items() if seconds > 0.0}) >= 3
    for each in classes:
        sums = expected[each.low]
        assert each.high == each.low + 5.0
        assert each.seconds == pytest.approx(sums["seconds"], rel=1e-12, abs=0.0)
        assert each.leakage_mean == pytest.approx(sums["leakage"] / sums["seconds"], rel=1e-12, abs=0.0)
        assert each.pressure_mean == pytest.approx(sums["pressure"] / sums["seconds"], rel=1e-12, abs=0.0)
        assert each.pressure_min == sums["pressure_min"]
        assert each.share_mean == pytest.approx(sums["share"] / sums["with_share"], rel=1e-12, abs=0.0)
        assert each.share_max == pytest.approx(sums["share_max"], rel=1e-15, abs=0.0)
        assert dict(each.in_bands) == pytest.approx({band: sums[band] for band in BANDS}, rel=1e-12, abs=0.0)


def test_what_is_not_known_is_in_no_class_or_band(
    model: LeakageModel, unworn: LeakageModel, limits: Limits, log_of: LogOf
) -> None:
    time = np.arange(0.0, 10.0, 0.5)
    full = {"main_pressure": 800e3, "gear": 2.0, "converter_pressure": 250e3}
    assert temperature_classes(over(model, log_of(time, **full)), limits.total_share, unworn) == ()
    (alone,) = temperature_classes(over(model, log_of(time, **full, atf_temperature=82.0)), limits.total_share, unworn)
    assert (alone.low, alone.seconds, alone.pressure_mean) == (80.0, 9.5, 800e3)
    assert (alone.share_mean, alone.share_max, sum(alone.in_bands.values())) == (None, None, 0.0)
    road = over(model, log_of(time, **full, atf_temperature=82.0, engine_speed=30.0))
    (unmeasured,) = temperature_classes(road, limits.total_share, None)
    assert unmeasured.share_mean == pytest.approx(road.share[0], rel=1e-12, abs=0.0)
    assert sum(unmeasured.in_bands.values()) == 0.0


def test_a_pressure_that_is_assumed_is_none_of_a_class(
    model: LeakageModel, unworn: LeakageModel, limits: Limits, log_of: LogOf
) -> None:
    log = log_of(np.arange(0.0, 10.0, 0.5), main_pressure=800e3, atf_temperature=82.0, gear=2.0)
    derived = replace(log.channels["main_pressure"], source="derived")
    road = over(model, replace(log, channels={**log.channels, "main_pressure": derived}))
    (alone,) = temperature_classes(road, limits.total_share, unworn)
    assert (alone.pressure_mean, alone.pressure_min) == (None, None)
    assert alone.leakage_mean == pytest.approx(road.leakage[0], rel=1e-12, abs=0.0)
