"""Main pressure of a log beside what the valve body permits, and beside what was commanded."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from types import MappingProxyType

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from atleak.catalogue.circuits import PermissiblePressure
from atleak.catalogue.controller import Controller
from atleak.common.units import KPA, RPM
from atleak.engine.extremes import CountedSamples, Lasting
from atleak.engine.road_pressure import RoadPressure, compare_with_commanded, judge_pressure
from atleak.measurements.road_test import RoadTest, Segment

NAN = float("nan")
STEP = 0.05
LogOf = Callable[..., RoadTest]


def permitted(gears: set[int], state: str, low: float | None, high: float | None = None) -> PermissiblePressure:
    ends = (None if kpa is None else kpa * 1e3 for kpa in (low, high))
    return PermissiblePressure(frozenset(gears), state, *ends, source="a chart")  # type: ignore[arg-type]


@pytest.fixture
def limited(four_speed: Controller) -> Controller:
    """At idle 400 to 600 kPa, at stall from 800, driving from 500 in first and second and from 450 in third."""
    chart = (
        permitted({1, 2, 3, 4}, "idle", 400.0, 600.0),
        permitted({1, 2}, "stall", 800.0),
        permitted({1, 2}, "driving", 500.0, 1200.0),
        permitted({3}, "driving", 450.0),
    )
    return replace(four_speed, permissible=chart)


@pytest.fixture
def drive(log_of: LogOf) -> Callable[..., RoadTest]:
    """A log of stretches ``(seconds, rpm, gear, kPa)``, twenty samples a second; more channels by name."""

    def build(*stretches: tuple[float, float, float, float], **more: object) -> RoadTest:
        counts = [round(seconds / STEP) for seconds, *_ in stretches]
        rpm, gear, kpa = (np.repeat([each[place] for each in stretches], counts) for place in (1, 2, 3))
        time = np.arange(sum(counts)) * STEP
        return log_of(time, engine_speed=rpm / RPM, gear=gear, main_pressure=kpa / KPA, **more)

    return build


Drive = Callable[..., RoadTest]


def judged(controller: Controller, road_test: RoadTest) -> RoadPressure:
    found = judge_pressure(controller, road_test)
    assert isinstance(found, RoadPressure), found
    return found


def with_channel(road_test: RoadTest, quantity: str, **changes: object) -> RoadTest:
    channel = replace(road_test.channels[quantity], **changes)  # type: ignore[arg-type]
    return replace(road_test, channels=MappingProxyType({**road_test.channels, quantity: channel}), _held={})


def test_each_gear_and_state_has_its_own_limit(limited: Controller, drive: Drive) -> None:
    found = judged(limited, drive((5, 800, 1, 410), (5, 2000, 2, 510), (5, 2000, 3, 460), (5, 2000, 4, 300)))
    assert [(place.gear, place.state, place.below) for place in found.places] == [
        (1, "idle", 0.0),
        (2, "driving", 0.0),
        (3, "driving", 0.0),
    ]
    assert [place.worst.pressure * KPA for place in found.places] == pytest.approx([410.0, 510.0, 460.0], abs=1e-9)
    assert found.judged == pytest.approx(15.0 - 2 * 2 * STEP, abs=2 * STEP)  # without the shifts between
    assert (found.below, found.above) == (0.0, 0.0)
    assert found.lowest.fraction == pytest.approx(1.0 - 510.0 / 500.0, abs=1e-12)  # the nearest, two per cent above


def test_below_is_said_with_how_long_where_and_how_far(limited: Controller, drive: Drive) -> None:
    found = judged(limited, drive((5, 800, 1, 410), (4, 2000, 2, 520), (3, 2000, 2, 450), (3, 2000, 2, 520)))
    worst = found.lowest
    assert (worst.gear, worst.state, worst.source) == (2, "driving", "a chart")
    assert worst.outside * KPA == pytest.approx(50.0, abs=1e-9)
    assert worst.fraction == pytest.approx(0.1, abs=1e-12)
    assert (worst.start, worst.stop) == (pytest.approx(9.0, abs=2 * STEP), pytest.approx(12.0, abs=2 * STEP))
    assert worst.start <= worst.at <= worst.stop
    assert found.below == pytest.approx(3.0, abs=2 * STEP)
    assert {place.state: place.below > 0.0 for place in found.places} == {"idle": False, "driving": True}


def test_coasting_is_no_idle_and_has_no_limit(limited: Controller, drive: Drive) -> None:
    stretches = ((5, 800, 3, 450), (5, 800, 3, 700), (5, 2000, 3, 460))
    rolls = np.repeat([0.0, 5.4, 12.0], 100)  # m/s
    for speed in ({"vehicle_speed": rolls}, {"output_speed": rolls * 2.0}):
        found = judged(limited, drive(*stretches, **speed))
        assert [(place.gear, place.state) for place in found.places] == [(3, "idle"), (3, "driving")]
        assert (found.below, found.above) == (0.0, 0.0)
        assert found.places[0].judged == pytest.approx(5.0, abs=2 * STEP)
    unknown = judged(limited, drive(*stretches, vehicle_speed=np.where(rolls == 5.4, NAN, rolls)))
    assert unknown.above == pytest.approx(5.0, abs=2 * STEP)  # nothing shows that it rolls
    assert judged(limited, drive(*stretches)).above == pytest.approx(5.0, abs=2 * STEP)


def test_pressure_is_given_over_the_temperature_in_each_gear_and_state(limited: Controller, drive: Drive) -> None:
    stretches = ((5, 800, 1, 420), (5, 2000, 2, 520), (5, 800, 1, 300), (2, 800, 1, 200))
    celsius = np.r_[np.full(60, 31.0), np.full(40, 39.0), np.full(100, 60.0), np.full(100, 95.0), np.full(40, 118.0)]
    idle, driving = judged(limited, drive(*stretches, atf_temperature=celsius)).places
    assert [(round(each.temperature, 1), round(each.pressure * KPA)) for each in driving.by_temperature] == [
        (60.0, 520)
    ]
    found = [(each.temperature, each.pressure * KPA, each.seconds) for each in idle.by_temperature]
    expected = [(34.2, 420.0, 5.0), (95.0, 300.0, 5.0), (118.0, 200.0, 2.0)]
    for each, wanted in zip(found, expected, strict=True):
        assert each == pytest.approx(wanted, abs=2.5)  # where one ends, half a second is smoothed
    assert [round(each.temperature) for each in idle.slump] == [34, 95]  # two seconds are too short to count
    assert driving.slump is None
    without = judged(limited, drive(*stretches)).places
    assert [(place.by_temperature, place.slump) for place in without] == [((), None)] * 2


@pytest.mark.parametrize(("seconds", "below"), [(0.7, 0.0), (1.3, 1.3)])
def test_what_does_not_last_a_second_does_not_count(
    limited: Controller, drive: Drive, seconds: float, below: float
) -> None:
    found = judged(limited, drive((5, 2000, 2, 520), (seconds, 2000, 2, 100), (5, 2000, 2, 520)))
    assert found.below == pytest.approx(below, abs=3 * STEP)
    assert (found.lowest.fraction > 0.0) == (below > 0.0)


def test_a_dip_counts_as_deep_as_it_stays_for_a_second(limited: Controller, drive: Drive) -> None:
    found = judged(limited, drive((5, 2000, 2, 520), (2, 2000, 2, 480), (0.6, 2000, 2, 100), (2, 2000, 2, 480)))
    assert found.lowest.fraction == pytest.approx(0.04, abs=1e-12)


def test_single_wrong_samples_neither_make_nor_part_a_stretch(limited: Controller, drive: Drive) -> None:
    log = drive((5, 2000, 2, 520), (4, 2000, 2, 400), (5, 2000, 2, 520))
    values = log.channels["main_pressure"].values.copy()
    values[[20, 140]] = 0.0, 2e6
    found = judged(limited, with_channel(log, "main_pressure", values=values))
    assert found.below == pytest.approx(4.0, abs=3 * STEP)
    assert found.lowest.fraction == pytest.approx(0.2, abs=1e-12)


def test_a_stretch_goes_on_through_a_short_shift(limited: Controller, drive: Drive) -> None:
    found = judged(limited, drive((0.7, 2000, 2, 300), (0.7, 2000, 3, 300), (5, 2000, 4, 900)))
    assert found.below > 1.0
    assert {place.gear for place in found.places if place.below} == {2, 3}


def test_no_stretch_reaches_over_a_break_of_the_log(limited: Controller, drive: Drive) -> None:
    log = drive((0.7, 2000, 2, 300), (0.7, 2000, 2, 300))
    assert judged(limited, log).below > 1.0
    later = np.concatenate([log.time[:14], log.time[14:] + 60.0])
    parts = (Segment(0, 14, 0.0, 13 * STEP), Segment(14, 14, later[14], 13 * STEP))
    channels = {name: replace(channel, time=later) for name, channel in log.channels.items()}
    apart = replace(log, time=later, segments=parts, channels=MappingProxyType(channels), _held={})
    found = judged(limited, apart)
    assert found.below == 0.0
    assert found.judged == pytest.approx(26 * STEP, abs=1e-9)  # the gap is no time


@pytest.mark.parametrize("gear", [0.0, -1.0, 9.0, NAN])
def test_in_neutral_or_an_unknown_gear_there_is_no_limit(limited: Controller, drive: Drive, gear: float) -> None:
    assert judge_pressure(limited, drive((5, 2000, gear, 100))) == "never_there"
    found = judged(limited, drive((5, 2000, gear, 100), (5, 2000, 2, 520)))
    assert found.below == 0.0
    assert {place.gear for place in found.places} == {2}


def test_the_selector_in_park_or_neutral_counts_before_the_gear(limited: Controller, drive: Drive) -> None:
    assert judge_pressure(limited, drive((5, 2000, 2, 100), selector=-2.0)) == "never_there"
    assert judged(limited, drive((5, 2000, 2, 100), selector=10.0)).below > 4.0


def test_stall_needs_a_logged_vehicle_speed(limited: Controller, drive: Drive) -> None:
    stretch = (5.0, 2000.0, 1.0, 700.0)
    assert judged(limited, drive(stretch)).places[0].state == "driving"
    standing = judged(limited, drive(stretch, vehicle_speed=0.0))
    assert standing.places[0].state == "stall"
    assert standing.lowest.outside * KPA == pytest.approx(100.0, abs=1e-9)
    assert judged(limited, drive(stretch, vehicle_speed=10.0)).places[0].state == "driving"


def test_a_start_of_the_engine_and_its_standstill_do_not_count(limited: Controller, drive: Drive) -> None:
    found = judged(limited, drive((2, 0, 1, 0), (1, 200, 1, 50), (2.5, 800, 1, 100), (6, 800, 1, 420), (3, 0, 1, 0)))
    assert found.below == 0.0
    assert found.judged == pytest.approx(5.5, abs=3 * STEP)


def test_above_the_high_limit_is_said_too(limited: Controller, drive: Drive) -> None:
    found = judged(limited, drive((5, 800, 1, 660), (5, 2000, 2, 520)))
    assert found.above == pytest.approx(5.0, abs=3 * STEP)
    assert found.highest.fraction == pytest.approx(0.1, abs=1e-12)
    assert found.highest.state == "idle"


def test_an_assumed_or_commanded_pressure_is_never_judged(limited: Controller, drive: Drive) -> None:
    log = drive((5, 2000, 2, 100))
    assert judge_pressure(limited, with_channel(log, "main_pressure", source="constant")) == "not_measured"
    assert judge_pressure(limited, with_channel(log, "main_pressure", kind="commanded")) == "not_measured"


def test_what_is_missing_is_named(limited: Controller, four_speed: Controller, drive: Drive) -> None:
    log = drive((5, 2000, 2, 100))

    def without(quantity: str) -> RoadTest:
        kept = {name: channel for name, channel in log.channels.items() if name != quantity}
        return replace(log, channels=MappingProxyType(kept), _held={})

    assert judge_pressure(limited, without("main_pressure")) == "no_main_pressure"
    assert judge_pressure(limited, without("engine_speed")) == "no_engine_speed"
    assert judge_pressure(limited, without("gear")) == "no_gear"
    assert judge_pressure(replace(four_speed, permissible=()), log) == "not_permitted"


def test_a_slow_log_is_judged_by_the_answers_that_it_has(limited: Controller, log_of: LogOf) -> None:
    time = np.arange(6) * 7.0
    kpa = np.array([520.0, 300.0, 520.0, 400.0, 410.0, 520.0])
    log = log_of(time, engine_speed=2000.0 / RPM, gear=2.0, main_pressure=kpa / KPA)
    found = judged(limited, log)
    # one answer alone may be held from before; two that follow one another last
    assert found.lowest.pressure * KPA == pytest.approx(410.0, abs=1e-9)
    assert (found.lowest.start, found.lowest.stop) == (21.0, 28.0)


def test_what_lasts_agrees_with_a_slow_loop(log_of: LogOf) -> None:
    generator = np.random.default_rng(4)
    time = np.cumsum(generator.uniform(0.02, 0.4, 300))
    counted = CountedSamples(log_of(time))

    @settings(max_examples=30)
    @given(st.integers(0, 10_000))
    def agrees(seed: int) -> None:
        values = np.cumsum(np.random.default_rng(seed).normal(0.0, 1.0, len(time)))
        values[np.random.default_rng(seed).integers(0, len(time), 3)] = NAN
        lasting = Lasting(counted, values)
        best = -np.inf
        for end in range(len(time)):
            begin = np.flatnonzero(time <= time[end] - 1.0 + 1e-9)
            if len(begin) and np.isfinite(values[begin[-1] : end + 1]).all():
                best = max(best, values[begin[-1] : end + 1].min())
        sample = lasting.worst(np.ones(len(time), bool))
        assert values[sample] == best

    agrees()


# --- commanded ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("actual", "difference"), [(430.0, -90.0), (620.0, 100.0), (520.0, 0.0)])
def test_actual_minus_commanded_counts_as_it_stays_for_a_second(drive: Drive, actual: float, difference: float) -> None:
    log = drive(
        (5, 2000, 2, 520), (3, 2000, 2, actual), (0.5, 2000, 2, 2000), (5, 2000, 2, 520), commanded_pressure=520e3
    )
    found = compare_with_commanded(log)
    assert found.difference * KPA == pytest.approx(difference, abs=1e-6)
    assert found.commanded * KPA == pytest.approx(520.0, abs=1e-9)
    assert found.compared == pytest.approx(13.45, abs=1e-6)
    if difference:
        assert 4.9 <= found.start <= found.at <= found.stop <= 8.6


def test_nothing_is_compared_with_a_pressure_that_is_not_there(drive: Drive) -> None:
    log = drive((5, 2000, 2, 520))
    assert compare_with_commanded(log) is None
    both = drive((5, 2000, 2, 520), commanded_pressure=600e3)
    assert compare_with_commanded(with_channel(both, "main_pressure", kind="commanded")) is None
    assert compare_with_commanded(with_channel(both, "main_pressure", source="constant")) is None
    assert compare_with_commanded(both).difference * KPA == pytest.approx(-80.0, abs=1e-6)


def test_nothing_is_compared_while_the_engine_stands(drive: Drive) -> None:
    assert compare_with_commanded(drive((10.0, 0.0, 1.0, 500.0), commanded_pressure=600e3)) is None
