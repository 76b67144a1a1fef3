"""Define an event of a road test, its thresholds, and the runs of samples from which events are made."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np

from atleak.common.sentences import Sentence
from atleak.common.units import gear_name
from atleak.measurements.road_test import ChannelSource, RoadTest

EventKind = Literal[
    "minimum_acceleration", "gear_shift", "hot_idle", "stall", "lock_up", "steady_driving", "engine_start"
]


@dataclass(frozen=True)
class Thresholds:
    """Limits of the events. Speeds of rotation [1/s], vehicle speeds [m/s], temperatures [°C], durations [s]."""

    standing: float = 1.0 / 3.6  # vehicle speed below which the car stands
    idle_low: float = 400 / 60  # engine speed above which it runs
    idle_high: float = 1100 / 60  # engine speed below which it idles
    hot: float = 70.0  # fluid temperature of hot idle
    idle_seconds: float = 3.0  # shortest hot idle
    stall_speed: float = 1400 / 60  # engine speed of a stall
    stall_seconds: float = 0.4  # shortest stall
    stall_longest: float = 15.0  # longest stall
    gentle_speed: float = 2500 / 60  # engine speed that such a test may reach
    gentle_end: float = 30 / 3.6  # vehicle speed that such a test must reach
    gentle_back: float = 5 / 3.6  # fall of the vehicle speed that ends a run
    slip: float = 50 / 60  # of a locked converter, at the most
    lock_up_seconds: float = 1.0  # shortest lock-up
    steady_seconds: float = 5.0  # shortest steady driving
    steady_speed: float = 20 / 3.6  # vehicle speed above which driving may be steady
    steady_vehicle: float = 3 / 3.6  # band of the vehicle speed
    steady_engine: float = 100 / 60  # band of the engine speed
    ratio_tolerance: float = 0.06  # relative, of a gear's ratio
    shift_pause: float = 3.0  # longest between the two gears of a shift, while none or no gear is known
    engine_standing: float = 50 / 60  # engine speed below which it stands
    engine_standing_seconds: float = 0.5  # shortest standstill before a start
    start_seconds: float = 3.0  # that a start takes once the engine runs
    # of a minimum-acceleration test
    gentle_begun: float = 15 / 3.6  # at which it is one that was begun, where no gear is known
    driven_otherwise: float = 4000 / 60  # above which nobody meant to drive one
    idle_spread: float = 50 / 60  # engine speed over the lowest that is still idle
    slows: float = 0.15  # fall of the engine speed in the last gear with which the car slows down
    shift_settles: float = 1.0  # after a shift, until it is over
    shift_fall: float = 0.12  # of the engine speed at a shift
    shift_longest: float = 1.5  # time in which the engine speed falls at a shift
    shift_sampling: float = 0.5  # longest interval that shows such a fall


USUAL = Thresholds()


TestFault = Literal["too_fast", "broken_off"]


@dataclass(frozen=True)
class AccelerationTest:
    """How a minimum-acceleration test was driven: speeds of the engine [1/s], times [s] on the road test's time."""

    gears: tuple[int, ...]  # passed, rising; none where no gear is logged
    missing: tuple[int, ...]  # gears of the valve body above them
    highest_speed: float  # [1/s] that the engine reached
    highest_at: float  # [s] when
    speed_limit: float  # [1/s] under which it had to stay
    fault: TestFault | None  # None: driven as it is meant to be

    @property
    def over_by(self) -> float:
        """Return how far the engine speed went over the limit [1/s]; 0 where it did not."""
        return max(0.0, self.highest_speed - self.speed_limit)


@dataclass(frozen=True)
class Event:
    """What happened in a window of a road test."""

    kind: EventKind  # what happened
    start: float  # [s] on the road test's time
    stop: float  # [s] likewise
    from_gear: int | None = None  # of a shift
    to_gear: int | None = None  # of a shift
    source: ChannelSource = "logged"  # whether the log says it, or it was derived
    note: Sentence = Sentence("")  # noqa: RUF009  frozen, so safe to share
    test: AccelerationTest | None = None  # of a minimum-acceleration test: how it was driven

    @property
    def duration(self) -> float:
        """Return the length [s]."""
        return self.stop - self.start

    @property
    def gears(self) -> str | None:
        """Return the gears of a shift: ``1 → 2``; None of what is no shift."""
        if self.from_gear is None or self.to_gear is None:
            return None
        return f"{gear_name(self.from_gear)} → {gear_name(self.to_gear)}"


def segments(road_test: RoadTest) -> Iterator[slice]:
    """Yield the samples of every stretch in which time runs on without a break."""
    if not road_test.segments:
        yield slice(0, len(road_test.time))
    for segment in road_test.segments:
        yield slice(segment.start_row, segment.start_row + segment.rows)


def runs(road_test: RoadTest, mask: np.ndarray, shortest: float) -> Iterator[tuple[int, int]]:
    """Yield first and last index of every run of True that lasts long enough; none crosses a segment's end."""
    for part in segments(road_test):
        edges = np.flatnonzero(np.diff(np.concatenate([[0], mask[part].astype(np.int8), [0]])))
        for low, high in zip(edges[::2], edges[1::2], strict=True):
            first, last = part.start + int(low), part.start + int(high) - 1
            if road_test.time[last] - road_test.time[first] >= shortest:
                yield first, last


def within_span(time: np.ndarray, events: Iterable[Event]) -> np.ndarray:
    """Return which stamps [s], ascending, lie in one of some events, ends included."""
    inside = np.zeros(len(time), bool)
    for event in events:
        inside[np.searchsorted(time, event.start) : np.searchsorted(time, event.stop, side="right")] = True
    return inside


def standing_samples(road_test: RoadTest, limits: Thresholds) -> np.ndarray | None:
    """Return at which samples the car stands, shape (samples,); None where the log does not show it."""
    behind = _behind_the_gears(road_test, limits)
    return None if behind is None else behind[0] < behind[1]


def rolling_samples(road_test: RoadTest, limits: Thresholds) -> np.ndarray:
    """Return at which samples the log shows that the car rolls, shape (samples,)."""
    behind = _behind_the_gears(road_test, limits)
    return np.zeros(len(road_test.time), bool) if behind is None else behind[0] >= behind[1]


def _behind_the_gears(road_test: RoadTest, limits: Thresholds) -> tuple[np.ndarray, float] | None:
    """Return the speed behind the gears and below which it stands; None where none is logged."""
    for name, stands in (("vehicle_speed", limits.standing), ("output_speed", 0.5)):
        speed = road_test.values(name)
        if speed is not None:
            return speed, stands
    return None


def gear_engaged(road_test: RoadTest) -> np.ndarray | None:
    """Return the gear of every sample, 0 where the selector is in neutral or park, NaN where it is unknown.

    None where neither is logged. Shape (samples,).
    """
    gear, selector = road_test.values("gear"), road_test.values("selector")
    if selector is None:
        return gear
    return np.where((selector == 0) | (selector == -2), 0.0, np.nan if gear is None else gear)
