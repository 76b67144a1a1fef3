"""Detect minimum-acceleration tests in a road test: from idle through the gears, the engine never above 2500 rpm.

The source study's own logger recorded no vehicle speed, so a test is recognised by what there is: vehicle speed, else
the gear, else the falls of the engine speed at each shift.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from atleak.events.event import AccelerationTest, Event, TestFault, Thresholds, segments
from atleak.road_test import RoadTest


@dataclass(frozen=True)
class _Climb:
    """An acceleration from rest, by first and last sample of the log; ``carried``: far enough to be a test."""

    first: int
    last: int
    gears: tuple[int, ...]  # passed, rising; none where no gear is known
    carried: bool
    begun: bool  # far enough to have been meant as a test


def minimum_acceleration(
    road_test: RoadTest, limits: Thresholds | None = None, gears: Sequence[int] = ()
) -> list[Event]:
    """Return the minimum-acceleration tests, each with how it was driven.

    A test begins with the last sample at rest and ends where the car slows down or the recording breaks off. One that
    was driven too fast or broken off is named only where it is the one acceleration of its stretch and most of what was
    driven there: elsewhere it is a drive like any other. An acceleration that stays below 30 km/h, or in first gear,
    does not count; nor does what follows an engine speed above the limit.

    Parameters
    ----------
    gears
        those of the valve body; with them a test that does not reach the highest is broken off.
    """
    limits = limits or Thresholds()
    engine, vehicle = road_test.values("engine_speed"), road_test.values("vehicle_speed")
    gear = road_test.values("gear")
    if engine is None:
        return []
    find: Callable[[slice], Iterator[_Climb]]
    if vehicle is not None:
        find = _ByVehicleSpeed(engine, vehicle, gear, limits).climbs
    elif gear is not None:
        find = _ByGear(road_test.time, engine, gear, limits).climbs
    else:
        find = _ByEngineSpeed(road_test.time, engine, limits).climbs
    events = []
    for part in segments(road_test):
        climbs = [climb for climb in find(part) if climb.begun]
        alone = len(climbs) == 1 and _most_of_the_driving(road_test.time, engine, part, climbs[0], limits)
        for climb in climbs:
            event = _judged(road_test.time, engine, climb, limits, max(gears, default=0), alone)
            if event is None:
                event = _gentle_part(road_test.time, engine, climb, find, limits)
            if event is not None:
                events.append(event)
    return events


def _judged(
    time: np.ndarray, engine: np.ndarray, climb: _Climb, limits: Thresholds, top: int, alone: bool
) -> Event | None:
    """Return the test that a climb is; None where it is none."""
    speeds = engine[climb.first : climb.last + 1]
    if not np.isfinite(speeds).any():
        return None
    at = int(np.nanargmax(speeds))
    highest = float(speeds[at])
    missing = tuple(range(climb.gears[-1] + 1, top + 1)) if climb.gears else ()
    fault: TestFault | None = None
    if highest > limits.gentle_speed:
        if not alone or highest > limits.driven_otherwise:
            return None
        fault = "too_fast"
    elif alone and (missing or not climb.carried):
        fault = "broken_off"
    elif not climb.carried:
        return None
    start, stop, highest_at = (float(time[sample]) for sample in (climb.first, climb.last, climb.first + at))
    test = AccelerationTest(climb.gears, missing, highest, highest_at, limits.gentle_speed, fault)
    return Event("minimum_acceleration", start, stop, test=test)


def _gentle_part(
    time: np.ndarray,
    engine: np.ndarray,
    climb: _Climb,
    find: Callable[[slice], Iterator[_Climb]],
    limits: Thresholds,
) -> Event | None:
    """Return the test that a climb was until the engine was revved higher; None where that is none."""
    fast = np.flatnonzero(engine[climb.first : climb.last + 1] > limits.gentle_speed)
    if not len(fast):
        return None
    for part in find(slice(climb.first, climb.first + int(fast[0]))):
        if part.carried:
            return _judged(time, engine, part, limits, 0, False)
    return None


def _most_of_the_driving(time: np.ndarray, engine: np.ndarray, part: slice, climb: _Climb, limits: Thresholds) -> bool:
    """Tell whether a climb takes at least half of the time in which the engine of its stretch does not idle."""
    steps = np.diff(time[part], append=time[part][-1])
    driven = float(np.sum(steps[~(engine[part] < limits.idle_high)]))
    return bool(time[climb.last] - time[climb.first] >= 0.5 * driven)


class _ByVehicleSpeed:
    """Climbs where the vehicle speed is logged: from the last sample at standstill to the highest speed."""

    def __init__(self, engine: np.ndarray, vehicle: np.ndarray, gear: np.ndarray | None, limits: Thresholds) -> None:
        self.engine, self.vehicle, self.gear, self.limits = engine, vehicle, gear, limits

    def climbs(self, part: slice) -> Iterator[_Climb]:
        speed, limits = self.vehicle[part], self.limits
        standing = speed < limits.standing
        rests = np.flatnonzero(standing)
        for first in np.flatnonzero(standing[:-1] & (speed[1:] >= limits.standing)):
            later = np.searchsorted(rests, first, side="right")
            end = int(rests[later]) if later < len(rests) else len(speed)
            run = speed[first:end]
            slower = np.flatnonzero(run < np.fmax.accumulate(run) - limits.gentle_back)
            run = run[: int(slower[0])] if len(slower) else run
            if len(run) < 2 or not np.isfinite(run).any():
                continue
            last = int(first) + int(np.nanargmax(run))
            passed = _passed(self.gear, part.start + int(first), part.start + last)
            fastest, shifted = float(np.nanmax(run)), max(passed, default=0) >= 2
            carried = fastest >= limits.gentle_end and (shifted or self.gear is None)
            begun = shifted if self.gear is not None else fastest >= limits.gentle_begun
            yield _Climb(part.start + int(first), part.start + last, passed, carried, begun)


class _ByGear:
    """Climbs where a gear is logged and no vehicle speed: from idle in first gear up through the gears."""

    def __init__(self, time: np.ndarray, engine: np.ndarray, gear: np.ndarray, limits: Thresholds) -> None:
        self.time, self.engine, self.gear, self.limits = time, engine, gear, limits

    def climbs(self, part: slice) -> Iterator[_Climb]:
        engine, gear, limits = self.engine[part], self.gear[part], self.limits
        resting = (engine > limits.idle_low) & (engine < limits.idle_high) & ((gear == 0) | (gear == 1))
        rests = np.flatnonzero(resting)
        for leaving in np.flatnonzero(resting[:-1] & ~resting[1:]):
            later = np.searchsorted(rests, leaving, side="right")
            end = int(rests[later]) if later < len(rests) else len(engine)
            last = self._end(engine, gear, part.start, int(leaving), end)
            passed = _passed(gear, int(leaving), last)
            if max(passed, default=0) < 2:
                continue
            first = _leaves_idle(engine, resting, int(leaving), limits)
            yield _Climb(part.start + first, part.start + last, _passed(gear, first, last), True, True)

    def _end(self, engine: np.ndarray, gear: np.ndarray, offset: int, first: int, end: int) -> int:
        """Return the last sample of a climb: before a shift down, and where the engine is fastest in its last gear."""
        known = np.where(np.isnan(gear[first:end]), 0.0, gear[first:end])
        highest = np.maximum.accumulate(known)
        down = np.flatnonzero((known < highest) & ~np.isnan(gear[first:end]))
        stop = first + int(down[0]) if len(down) else end
        entered = first + int(np.argmax(highest[: stop - first] == highest[stop - first - 1]))
        return _fastest(self.time[offset + entered : offset + stop], engine[entered:stop], self.limits) + entered


class _ByEngineSpeed:
    """Climbs where neither gear nor vehicle speed is logged: the engine speed falls at every shift and rises again.

    Lifting the foot looks the same, so two such falls are asked for, and a sampling that shows them.
    """

    def __init__(self, time: np.ndarray, engine: np.ndarray, limits: Thresholds) -> None:
        self.time, self.engine, self.limits = time, engine, limits

    def climbs(self, part: slice) -> Iterator[_Climb]:
        time, engine, limits = self.time[part], self.engine[part], self.limits
        steps = np.diff(time)
        if len(time) < 10 or np.median(steps) > limits.shift_sampling:
            return
        smooth = pd.Series(engine).rolling(5, center=True, min_periods=1).median().to_numpy()
        resting = (smooth > limits.idle_low) & (smooth < limits.idle_high)
        rests = np.flatnonzero(resting)
        for leaving in np.flatnonzero(resting[:-1] & ~resting[1:]):
            later = np.searchsorted(rests, leaving, side="right")
            end = int(rests[later]) if later < len(rests) else len(smooth)
            shifts = self._shifts(time[leaving:end], smooth[leaving:end])
            if len(shifts) < 2:
                continue
            entered = int(leaving) + shifts[-1]
            last = entered + _fastest(time[entered:end], smooth[entered:end], limits)
            first = _leaves_idle(smooth, resting, int(leaving), limits)
            yield _Climb(part.start + first, part.start + last, (), True, True)

    def _shifts(self, time: np.ndarray, speed: np.ndarray) -> list[int]:
        """Return the samples to which the speed falls within a second, not to idle, and from which it rises again."""
        shifts: list[int] = []
        before = 0  # sample from which the next fall is looked for
        while True:
            tops = np.fmax.accumulate(speed[before:])
            fallen = np.flatnonzero(speed[before:] <= (1.0 - self.limits.shift_fall) * tops)
            if not len(fallen):
                return shifts
            at = before + int(fallen[0])
            near = np.flatnonzero((time >= time[at]) & (time <= time[at] + 1.0))
            lowest = int(near[np.nanargmin(speed[near])])
            top = before + int(np.nanargmax(speed[before : at + 1]))
            sudden = time[lowest] - time[_last_near(speed[: lowest + 1], speed[top])] <= self.limits.shift_longest
            after = speed[lowest : lowest + int(np.searchsorted(time[lowest:], time[lowest] + 2.0))]
            rises = len(after) > 1 and np.nanmax(after) >= 1.02 * speed[lowest]
            if not sudden or not rises or speed[lowest] < 0.55 * speed[top]:
                return shifts  # the foot was lifted: the climb ends
            shifts.append(lowest)
            before = lowest


def _last_near(speed: np.ndarray, top: float) -> int:
    """Return the last sample within 3 % of a top speed."""
    return int(np.flatnonzero(speed >= 0.97 * top)[-1])


def _leaves_idle(engine: np.ndarray, resting: np.ndarray, leaving: int, limits: Thresholds) -> int:
    """Return the last sample of a run at rest that is within 50 rpm of the idle speed."""
    earlier = np.flatnonzero(~resting[:leaving])
    begin = int(earlier[-1]) + 1 if len(earlier) else 0
    run = engine[begin : leaving + 1]
    return begin + int(np.flatnonzero(run <= np.nanmin(run) + limits.idle_spread)[-1])


def _fastest(time: np.ndarray, engine: np.ndarray, limits: Thresholds) -> int:
    """Return the sample at which the engine turns fastest in the last gear, once the shift is over.

    What follows a fall by more than 15 % is left out: the car slows down.
    """
    settled = int(np.searchsorted(time, time[0] + limits.shift_settles))
    speeds = engine[settled:]
    if not len(speeds) or not np.isfinite(speeds).any():
        return len(engine) - 1
    slower = np.flatnonzero(speeds < (1.0 - limits.slows) * np.fmax.accumulate(speeds))
    return settled + int(np.nanargmax(speeds[: int(slower[0])] if len(slower) else speeds))


def _passed(gear: np.ndarray | None, first: int, last: int) -> tuple[int, ...]:
    """Return the forward gears between two samples, rising."""
    if gear is None:
        return ()
    values = gear[first : last + 1]
    return tuple(int(each) for each in np.unique(values[values > 0]))
