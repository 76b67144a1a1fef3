"""The article's minimum-acceleration test: recognised by what a log holds, and told when it was driven otherwise."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from atleak.common.units import RPM
from atleak.measurements.events import Event, events, minimum_acceleration
from atleak.measurements.road_test import RoadTest
from atleak.readers.logs import read_road_test

STEP = 0.05
Channels = dict[str, np.ndarray]
LogOf = Callable[..., RoadTest]


def driven(*, top: float = 2000.0, gears: int = 4, after: tuple[tuple[float, float], ...] = ()) -> Channels:
    """Idle 3 s, then 3 s in each gear up to ``top`` rpm; engine and gear. ``after``: seconds at a speed in top gear."""
    speed, gear = [np.full(60, 800.0)], [np.ones(60)]
    for number in range(1, gears + 1):
        low = 850.0 if number == 1 else 0.72 * top
        speed.append(np.linspace(low, top, 60))
        gear.append(np.full(60, float(number)))
    for seconds, rpm in after:
        speed.append(np.full(round(seconds / STEP), rpm))
        gear.append(np.full(round(seconds / STEP), float(gears)))
    return {"engine_speed": np.concatenate(speed) / RPM, "gear": np.concatenate(gear)}


@pytest.fixture
def log(log_of: LogOf) -> Callable[[Channels], RoadTest]:
    return lambda channels: log_of(np.arange(len(channels["engine_speed"])) * STEP, **channels)


Log = Callable[[Channels], RoadTest]


def only(found: list[Event]) -> Event:
    (event,) = found
    assert event.test is not None
    return event


@pytest.mark.parametrize("dropped", [(), ("gear",)], ids=["with its gear", "by engine speed alone"])
def test_the_sample_is_a_test_without_vehicle_speed(sample_log: Path, log_of: LogOf, dropped: tuple[str, ...]) -> None:
    whole = read_road_test(sample_log)
    assert whole.channel("vehicle_speed") is None
    kept = {name: channel.values for name, channel in whole.channels.items() if name not in dropped}
    event = only(minimum_acceleration(log_of(whole.time, **kept), gears=(1, 2, 3, 4)))
    assert event.test.fault is None
    assert event.start == pytest.approx(0.34, abs=0.01)  # the last sample within 50 rpm of idle
    assert event.stop == pytest.approx(11.9, abs=0.15)
    assert event.test.highest_speed * RPM == pytest.approx(2068.3, abs=0.05)
    assert event.test.gears == (() if dropped else (1, 2, 3, 4))


@pytest.mark.parametrize("dropped", [(), ("gear",)], ids=["with its gear", "by engine speed alone"])
def test_a_test_driven_too_fast_says_when_and_by_how_much(log: Log, dropped: tuple[str, ...]) -> None:
    channels = driven(top=2690.0)
    event = only(minimum_acceleration(log({name: channels[name] for name in channels if name not in dropped})))
    assert event.test.fault == "too_fast"
    assert event.test.over_by * RPM == pytest.approx(190.0, abs=1e-6)
    assert event.test.highest_at == pytest.approx(5.95, abs=1e-6)  # the end of first gear


def test_a_test_that_is_broken_off_names_the_gears_it_did_not_reach(log: Log) -> None:
    whole = driven(gears=3)
    event = only(minimum_acceleration(log(whole), gears=(-1, 1, 2, 3, 4, 5)))
    assert (event.test.fault, event.test.missing) == ("broken_off", (4, 5))
    assert event.stop == pytest.approx(11.95, abs=1e-6)
    assert only(minimum_acceleration(log(whole), gears=(1, 2, 3))).test.fault is None
    assert only(minimum_acceleration(log(whole))).test.fault is None  # nobody says how many gears there are


@pytest.mark.parametrize(
    "channels",
    [
        driven(top=4500.0),
        driven(top=2690.0, after=((60.0, 2100.0),)),
        {"engine_speed": np.full(400, 800.0) / RPM, "gear": np.ones(400)},
        {"engine_speed": np.linspace(800.0, 2300.0, 400) / RPM, "gear": np.ones(400)},
        {"engine_speed": np.linspace(2600.0, 1500.0, 400) / RPM, "gear": np.repeat([4.0, 3.0], 200)},
        {"engine_speed": driven(top=2690.0)["engine_speed"][90:], "gear": driven(top=2690.0)["gear"][90:] + 1.0},
    ],
    ids=["full throttle", "a drive", "idle", "one gear", "coming to rest", "not from rest"],
)
@pytest.mark.parametrize("dropped", [(), ("gear",)], ids=["with its gear", "by engine speed alone"])
def test_a_log_that_is_no_such_test_says_nothing_of_it(log: Log, channels: Channels, dropped: tuple[str, ...]) -> None:
    kept = {name: values for name, values in channels.items() if name not in dropped}
    assert minimum_acceleration(log(kept), gears=(1, 2, 3, 4, 5)) == []


def test_several_accelerations_are_a_drive_of_which_the_gentle_ones_count(log: Log) -> None:
    gentle, fast = driven(gears=3), driven(top=2900.0, gears=3)
    both = {name: np.concatenate([gentle[name], fast[name]]) for name in gentle}
    event = only(minimum_acceleration(log(both), gears=(1, 2, 3, 4)))
    assert event.test.fault is None
    assert event.test.gears == (1, 2, 3)
    assert event.stop < 12.1


def test_a_test_ends_where_the_car_slows_down(log: Log) -> None:
    event = only(minimum_acceleration(log(driven(after=((2.0, 1500.0), (2.0, 900.0)))), gears=(1, 2, 3, 4)))
    assert event.test.fault is None
    assert event.stop == pytest.approx(14.95, abs=1e-6)  # of 20 s


def test_lifting_the_foot_is_not_a_shift(log: Log) -> None:
    there_and_back = np.concatenate(
        [np.full(60, 800.0), *[np.linspace(900, 2200, 80), np.linspace(2200, 1000, 80)] * 3]
    )
    assert minimum_acceleration(log({"engine_speed": there_and_back / RPM})) == []


def test_events_know_the_gears_of_the_valve_body(log: Log) -> None:
    faults = {event.test.fault for event in events(log(driven(gears=3)), gears=(1, 2, 3, 4)) if event.test}
    assert faults == {"broken_off"}
