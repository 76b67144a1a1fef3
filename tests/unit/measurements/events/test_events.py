"""Road test as a type, and what happened in it."""

from __future__ import annotations

from dataclasses import replace
from types import MappingProxyType

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from atleak.measurements.events import (
    Thresholds,
    engine_starts,
    events,
    gear_shifts,
    hot_idle,
    lock_ups,
    minimum_acceleration,
    ratio_levels,
    stalls,
    steady_driving,
    with_derived_gear,
)
from atleak.measurements.road_test import Channel, RoadTest, Segment, hold

STEP = 0.1


def road_test(segments: tuple[Segment, ...] | None = None, **channels: np.ndarray) -> RoadTest:
    size = len(next(iter(channels.values())))
    time = np.arange(size) * STEP
    made = {
        name: Channel(name, time, np.asarray(values, float), np.zeros(size, bool), column=name, independent=size)
        for name, values in channels.items()
    }
    whole = (Segment(0, size, 0.0, float(time[-1])),)
    return RoadTest("drive.csv", "0" * 64, size, float(time[-1]), time, MappingProxyType(made), segments or whole)


def drive() -> dict[str, np.ndarray]:
    """Idle 10 s, stall 2 s, through three gears to 60 km/h, steady with lock-up, coming to rest."""
    ratios = {1: 2.5, 2: 1.5, 3: 1.0}
    speed, gear, engine, turbine = [], [], [], []

    def add(count: int, v0: float, v1: float, g: int, slip: float, rpm: float | None = None) -> None:
        for v in np.linspace(v0, v1, count, endpoint=False):
            through = v * 30 * ratios[g]  # rpm at the turbine
            speed.append(v)
            gear.append(g)
            turbine.append(through)
            engine.append(rpm if rpm is not None else max(through * (1 + slip), 800))

    add(100, 0, 0, 1, 0, 750)
    add(20, 0, 0, 1, 0, 2100)
    add(30, 0, 0, 1, 0, 750)
    add(60, 0, 25, 1, 0.10)
    add(50, 25, 40, 2, 0.06)
    add(60, 40, 60, 3, 0.04)
    add(200, 60, 60, 3, 0.0)
    add(80, 60, 0.0, 3, 0.0)
    add(60, 0, 0, 1, 0, 750)
    values = {"vehicle_speed": np.array(speed) / 3.6, "gear": np.array(gear), "turbine_speed": np.array(turbine) / 60}
    values |= {"engine_speed": np.array(engine) / 60, "atf_temperature": np.full(len(speed), 85.0)}
    values["output_speed"] = np.array(speed) * 30 / 60
    return values


def engine_at(*stretches: tuple[float, float]) -> np.ndarray:
    """Engine speed [1/s] of stretches of some seconds at some rpm, ten samples a second."""
    return np.concatenate([np.full(round(seconds / STEP), rpm / 60.0) for seconds, rpm in stretches])


def test_a_start_lasts_from_the_first_turn_to_three_seconds_after_the_engine_runs() -> None:
    log = road_test(engine_speed=engine_at((2.0, 0), (1.0, 200), (10.0, 800), (4.0, 0), (10.0, 800)))
    starts = engine_starts(log)
    assert [(round(event.start, 6), round(event.stop, 6)) for event in starts] == [(2.0, 6.0), (17.0, 20.0)]
    assert {event.kind for event in events(log)} == {"engine_start"}


def test_an_engine_that_is_cranked_and_does_not_run_starts_until_it_stands() -> None:
    starts = engine_starts(road_test(engine_speed=engine_at((1.0, 0), (1.5, 200), (2.0, 0), (5.0, 800))))
    assert [(round(event.start, 6), round(event.stop, 6)) for event in starts] == [(1.0, 2.4), (4.5, 7.5)]


@pytest.mark.parametrize(
    "speed",
    [
        engine_at((5.0, 800), (5.0, 2000)),
        engine_at((5.0, 800), (5.0, 0)),
        engine_at((5.0, 0)),
        engine_at((5.0, 800), (0.2, 0), (5.0, 800)),
    ],
    ids=["runs from the first sample", "is switched off", "stands", "two samples without speed"],
)
def test_an_engine_that_runs_from_the_beginning_is_not_started(speed: np.ndarray) -> None:
    assert engine_starts(road_test(engine_speed=speed)) == []


def test_a_start_is_in_one_stretch_of_the_log() -> None:
    speed = engine_at((2.0, 0), (5.0, 800))
    apart = (Segment(0, 20, 0.0, 1.9), Segment(20, 50, 2.0, 4.9))
    assert engine_starts(road_test(apart, engine_speed=speed)) == []
    assert engine_starts(road_test(vehicle_speed=speed)) == []


def test_the_whole_drive() -> None:
    drive_events = events(road_test(**drive()))
    kinds = [event.kind for event in drive_events]
    assert kinds.count("minimum_acceleration") == 1
    assert kinds.count("stall") == 1
    assert kinds.count("hot_idle") == 3
    assert "steady_driving" in kinds
    assert "lock_up" in kinds
    assert [(event.from_gear, event.to_gear) for event in drive_events if event.kind == "gear_shift"] == [
        (1, 2),
        (2, 3),
        (3, 1),
    ]
    assert [event.start for event in drive_events] == sorted(event.start for event in drive_events)


def test_minimum_acceleration_ends_at_the_top_and_refuses_high_revs() -> None:
    channels = drive()
    (event,) = minimum_acceleration(road_test(**channels))
    assert event.start == pytest.approx(15.0, abs=0.3)
    assert event.stop == pytest.approx(32.0, abs=0.2)
    fast = {**channels, "engine_speed": channels["engine_speed"] * 2.5}
    assert minimum_acceleration(road_test(**fast)) == []
    first_only = {**channels, "gear": np.ones(len(channels["gear"]))}
    assert minimum_acceleration(road_test(**first_only)) == []


def test_hot_idle_needs_a_hot_fluid() -> None:
    channels = drive()
    assert len(hot_idle(road_test(**channels))) == 3
    assert hot_idle(road_test(**{**channels, "atf_temperature": channels["atf_temperature"] - 40})) == []
    del channels["atf_temperature"]
    assert hot_idle(road_test(**channels)) == []


def test_stall_needs_a_turbine_at_rest_or_a_gear() -> None:
    channels = drive()
    (event,) = stalls(road_test(**channels))
    assert (event.start, event.stop) == (pytest.approx(10.0, rel=1e-9, abs=0.0), pytest.approx(11.9, rel=1e-9, abs=0.0))
    spinning = {**channels, "turbine_speed": channels["engine_speed"]}
    assert stalls(road_test(**spinning)) == []
    bare = {name: channels[name] for name in ("engine_speed", "vehicle_speed")}
    assert stalls(road_test(**bare)) == []
    assert len(stalls(road_test(**bare, gear=channels["gear"]))) == 1
    assert stalls(road_test(**bare, gear=0 * channels["gear"])) == []


def test_lock_up_by_slip_and_else_by_command() -> None:
    channels = drive()
    assert any(event.duration > 15 for event in lock_ups(road_test(**channels)))
    bare = {name: channels[name] for name in ("engine_speed", "vehicle_speed")}
    assert lock_ups(road_test(**bare)) == []
    command = np.zeros(len(bare["engine_speed"]))
    command[300:400] = 260e3
    (event,) = lock_ups(road_test(**bare, lock_up=command))
    assert (event.start, event.stop) == (pytest.approx(30.0, rel=1e-9, abs=0.0), pytest.approx(39.9, rel=1e-9, abs=0.0))
    assert "commanded" in event.note


NEUTRAL = {"gear": np.zeros, "selector": np.zeros, "park": lambda size: np.full(size, -2.0)}


@pytest.mark.parametrize("shown", [*NEUTRAL, "standing", "output at rest"])
@pytest.mark.parametrize("by", ["speeds", "command"])
def test_an_engine_that_turns_an_idle_turbine_along_locks_nothing_up(shown: str, by: str) -> None:
    engine = engine_at((10.0, 800), (10.0, 2000), (5.0, 800))
    size = len(engine)
    channels = {"engine_speed": engine, "vehicle_speed": np.full(size, 15.0)}
    channels |= {"turbine_speed": engine * 0.99} if by == "speeds" else {"lock_up": np.full(size, 100.0)}
    assert lock_ups(road_test(**channels))  # a car that coasts in gear
    if shown in NEUTRAL:
        channels["selector" if shown == "park" else shown] = NEUTRAL[shown](size)
    else:
        channels.pop("vehicle_speed")
        channels |= {"vehicle_speed" if shown == "standing" else "output_speed": np.zeros(size)}
    assert lock_ups(road_test(**channels)) == []


def in_turn(*stretches: tuple[float, float]) -> np.ndarray:
    """Gear in stretches of some seconds, ten samples a second."""
    return np.concatenate([np.full(round(seconds / STEP), gear) for seconds, gear in stretches])


@pytest.mark.parametrize(
    ("gear", "expected"),
    [
        (in_turn((5.0, 3), (30.0, 0), (5.0, 1)), []),
        (in_turn((5.0, 3), (30.0, np.nan), (5.0, 1)), []),
        (in_turn((5.0, 1), (30.0, -1), (5.0, 2)), []),
        (in_turn((5.0, 1), (0.5, -1), (5.0, 2)), []),
        (in_turn((5.0, 3), (0.5, 0), (5.0, 2)), [(3, 2)]),
        (in_turn((5.0, 3), (1.5, np.nan), (5.0, 4)), [(3, 4)]),
        (in_turn((5.0, 3), (5.0, 4), (30.0, 0), (5.0, 1), (5.0, 2)), [(3, 4), (1, 2)]),
    ],
    ids=[
        "neutral",
        "unknown",
        "reverse",
        "reverse for a moment",
        "neutral in the shift",
        "unknown in it",
        "two drives",
    ],
)
def test_a_shift_leads_from_one_gear_to_the_next(gear: np.ndarray, expected: list[tuple[int, int]]) -> None:
    channels = {"gear": gear, "engine_speed": np.full(len(gear), 30.0), "vehicle_speed": np.full(len(gear), 15.0)}
    shifts = gear_shifts(road_test(**channels))
    assert [(event.from_gear, event.to_gear) for event in shifts] == expected
    assert all(event.duration <= Thresholds().shift_pause for event in shifts)


def test_neighbours_are_a_shift_however_slow_the_logger() -> None:
    slow = road_test(gear=in_turn((0.2, 2), (0.2, 3)), engine_speed=np.full(4, 30.0))
    channels = {name: replace(each, time=100.0 * each.time) for name, each in slow.channels.items()}
    slow = replace(slow, time=np.arange(4) * 10.0, channels=MappingProxyType(channels))
    assert [(event.from_gear, event.to_gear) for event in gear_shifts(slow)] == [(2, 3)]


@pytest.mark.parametrize("hidden", ["gear", "turbine_speed"])
def test_an_engine_that_is_revved_while_nothing_is_known_of_the_gear_is_no_stall(hidden: str) -> None:
    channels = drive()
    bare = {name: channels[name] for name in ("engine_speed", "vehicle_speed", hidden)}
    assert len(stalls(road_test(**bare))) == 1
    bare[hidden] = np.where(
        (channels["engine_speed"] > 1400 / 60) & (channels["vehicle_speed"] < 0.1), np.nan, bare[hidden]
    )
    assert stalls(road_test(**bare)) == []
    in_neutral = {**channels, "selector": np.zeros(len(channels["gear"]))}
    in_neutral.pop("turbine_speed")
    assert stalls(road_test(**in_neutral)) == []


def test_steady_driving_does_not_cross_a_gap() -> None:
    channels = drive()
    (event,) = steady_driving(road_test(**channels))
    assert event.start == pytest.approx(31.0, abs=1.0)
    assert event.stop == pytest.approx(52.0, abs=1.0)
    size = len(channels["gear"])
    halves = (Segment(0, 340, 0.0, 33.9), Segment(340, size - 340, 34.0, (size - 1) * STEP - 34.0))
    for event in steady_driving(road_test(halves, **channels)):
        assert event.start >= 34.0


def test_lagging_gear_is_corrected_by_the_speed_ratio() -> None:
    channels = drive()
    lagging = np.concatenate([np.ones(5), channels["gear"][:-5]])
    shift = gear_shifts(road_test(**{**channels, "gear": lagging}))[0]
    assert (shift.from_gear, shift.to_gear) == (1, 2)
    assert shift.stop == pytest.approx(21.0, abs=0.15)
    assert "lags by 0.5" in shift.note


def test_gear_is_derived_from_the_ratio_and_marked() -> None:
    channels = drive()
    logged = channels.pop("gear")
    derived = with_derived_gear(road_test(**channels))
    gear = derived.values("gear")
    known = np.isfinite(gear) & (channels["vehicle_speed"] > 3)
    assert known.sum() > 200
    assert (gear[known] == logged[known]).all()
    assert derived.channels["gear"].source == "derived"
    assert derived.messages[-1].code == "gear_derived"
    with_gear = road_test(**channels, gear=logged)
    assert with_derived_gear(with_gear) is with_gear


@given(st.lists(st.sampled_from([4.2, 2.6, 1.7, 1.25, 1.0, 0.72]), min_size=1, max_size=6, unique=True))
def test_ratio_levels_find_every_gear(ratios: list[float]) -> None:
    noise = np.random.default_rng(1).normal(1, 0.004, 200 * len(ratios))
    levels = ratio_levels(np.repeat(sorted(ratios, reverse=True), 200) * noise)
    assert levels == pytest.approx(sorted(ratios, reverse=True), rel=0.02, abs=0.0)


def test_thresholds_can_be_set() -> None:
    channels = drive()
    assert hot_idle(road_test(**channels), replace(Thresholds(), idle_seconds=60.0)) == []


# --- the type -----------------------------------------------------------------------------------------------


def test_suspect_samples_are_hidden_and_kept() -> None:
    test = road_test(**drive())
    channel = test.channels["engine_speed"]
    suspect = channel.suspect.copy()
    suspect[3] = True
    doubted = replace(channel, suspect=suspect)
    test = replace(test, channels=MappingProxyType({**test.channels, "engine_speed": doubted}))
    assert np.isnan(test.values("engine_speed")[3])
    assert test.channels["engine_speed"].values[3] == channel.values[3]


def test_window_cuts_every_channel_and_segment() -> None:
    size = len(drive()["gear"])
    halves = (Segment(0, 300, 0.0, 29.9), Segment(300, size - 300, 30.0, (size - 1) * STEP - 30.0))
    test = road_test(halves, **drive())
    part = test.window(25.0, 35.0)
    assert part.rows == len(part.time) == 101
    assert part.duration == pytest.approx(10.0, rel=1e-9, abs=0.0)
    assert [segment.rows for segment in part.segments] == [50, 51]
    assert part.values("engine_speed").tolist() == test.values("engine_speed")[250:351].tolist()
    assert test.window(1e6, 2e6).rows == 0


def test_unknown_quantity_and_missing_channel() -> None:
    test = road_test(engine_speed=np.ones(5))
    assert test.values("main_pressure") is None
    assert test.kind("main_pressure") is None
    with pytest.raises(KeyError):
        test.values("engine_sped")


@given(
    own=st.lists(st.floats(0, 100), min_size=1, max_size=30), base=st.lists(st.floats(0, 100), min_size=1, max_size=50)
)
def test_hold_never_looks_ahead(own: list[float], base: list[float]) -> None:
    stamps, grid = np.sort(np.array(own)), np.sort(np.array(base))
    held = hold(stamps, stamps, grid)
    good = np.isfinite(held)
    assert (held[good] <= grid[good]).all()
    assert not good[grid < stamps[0]].any()
