"""Detect minimum-acceleration tests in a road test: from idle through the gears, the engine never above 2500 rpm.

The source study's own logger recorded no vehicle speed, so a test is recognised by what there is: vehicle speed, else
the gear, else the falls of the engine speed at each shift.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import pandas as pd

from atleak.events.event import AccelerationTest, Event, TestFault, Thresholds, segments
from atleak.road_test import RoadTest


@dataclass(frozen=True)
class Climb:
    """An acceleration from rest, by first and last sample of the log; ``carried``: far enough to be a test."""

    first: int
    last: int
    gears: tuple[int, ...]  # passed, rising; none where no gear is known
    carried: bool
    begun: bool  # far enough to have been meant as a test

    def most_of(self, time: np.ndarray, driven: float) -> bool:
        """Tell whether it takes at least half of the time [s] in which the engine of its stretch does not idle."""
        return bool(time[self.last] - time[self.first] >= 0.5 * driven)


class Finder(Protocol):
    """Finds the accelerations in a part of a log that lies in one stretch."""

    engine: np.ndarray  # speed [1/s] of the log's samples

    def resting(self, part: slice) -> np.ndarray: ...
    def climbs(self, part: slice) -> Iterator[Climb]: ...


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
    finder = finder_of(road_test, limits)
    if finder is None:
        return []
    engine, events = finder.engine, []
    for part in segments(road_test):
        climbs = [climb for climb in finder.climbs(part) if climb.begun]
        driven = seconds_driven(np.diff(road_test.time[part], append=road_test.time[part][-1]), engine[part], limits)
        for climb in climbs:
            alone = len(climbs) == 1 and climb.most_of(road_test.time, driven)
            event = as_test(road_test.time, climb, finder, limits, max(gears, default=0), alone=alone)
            if event is not None:
                events.append(event)
    return events


def finder_of(road_test: RoadTest, limits: Thresholds) -> Finder | None:
    """Return what finds the accelerations of a log, by what the log holds; None without an engine speed."""
    engine, vehicle = road_test.values("engine_speed"), road_test.values("vehicle_speed")
    gear = road_test.values("gear")
    if engine is None:
        return None
    if vehicle is not None:
        return ByVehicleSpeed(engine, vehicle, gear, limits)
    if gear is not None:
        return ByGear(road_test.time, engine, gear, limits)
    return ByEngineSpeed(road_test.time, engine, limits)


def as_test(
    time: np.ndarray, climb: Climb, finder: Finder, limits: Thresholds, top: int, *, alone: bool
) -> Event | None:
    """Return the test that an acceleration is, or that it was until the engine was revved higher; None where neither.

    Parameters
    ----------
    top
        the highest gear of the valve body; 0 where it is not known.
    alone
        whether it is the one acceleration of its stretch and most of what was driven there.
    """
    event = _judged(time, finder.engine, climb, limits, top, alone)
    return _gentle_part(time, climb, finder, limits) if event is None else event


def seconds_driven(steps: np.ndarray, engine: np.ndarray, limits: Thresholds) -> float:
    """Return for how long the engine of a stretch does not idle [s], by the time to each next sample."""
    return float(np.sum(steps[~(engine < limits.idle_high)]))


def _judged(
    time: np.ndarray, engine: np.ndarray, climb: Climb, limits: Thresholds, top: int, alone: bool
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


def _gentle_part(time: np.ndarray, climb: Climb, finder: Finder, limits: Thresholds) -> Event | None:
    """Return the test that a climb was until the engine was revved higher; None where that is none."""
    engine = finder.engine
    fast = np.flatnonzero(engine[climb.first : climb.last + 1] > limits.gentle_speed)
    if not len(fast):
        return None
    for part in finder.climbs(slice(climb.first, climb.first + int(fast[0]))):
        if part.carried:
            return _judged(time, engine, part, limits, 0, False)
    return None


class ByVehicleSpeed:
    """Climbs where the vehicle speed is logged: from the last sample at standstill to the highest speed."""

    def __init__(self, engine: np.ndarray, vehicle: np.ndarray, gear: np.ndarray | None, limits: Thresholds) -> None:
        self.engine, self.vehicle, self.gear, self.limits = engine, vehicle, gear, limits

    def resting(self, part: slice) -> np.ndarray:
        """Return at which samples the car stands."""
        return self.vehicle[part] < self.limits.standing

    def climbs(self, part: slice) -> Iterator[Climb]:
        """Return every acceleration from rest, however far it goes."""
        speed, limits = self.vehicle[part], self.limits
        standing = self.resting(part)
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
            yield Climb(part.start + int(first), part.start + last, passed, carried, begun)


class ByGear:
    """Climbs where a gear is logged and no vehicle speed: from idle in first gear up through the gears."""

    def __init__(self, time: np.ndarray, engine: np.ndarray, gear: np.ndarray, limits: Thresholds) -> None:
        self.time, self.engine, self.gear, self.limits = time, engine, gear, limits

    def resting(self, part: slice) -> np.ndarray:
        """Return at which samples the engine idles in first gear or none."""
        engine, gear = self.engine[part], self.gear[part]
        return idling(engine, self.limits) & ((gear == 0) | (gear == 1))

    def climbs(self, part: slice) -> Iterator[Climb]:
        """Return the accelerations that reach another gear than the first."""
        engine, gear, limits = self.engine[part], self.gear[part], self.limits
        resting = self.resting(part)
        rests = np.flatnonzero(resting)
        for leaving in np.flatnonzero(resting[:-1] & ~resting[1:]):
            later = np.searchsorted(rests, leaving, side="right")
            end = int(rests[later]) if later < len(rests) else len(engine)
            last = self._end(engine, gear, part.start, int(leaving), end)
            passed = _passed(gear, int(leaving), last)
            if max(passed, default=0) < 2:
                continue
            first = _leaves_idle(engine, resting, int(leaving), limits)
            yield Climb(part.start + first, part.start + last, _passed(gear, first, last), True, True)

    def _end(self, engine: np.ndarray, gear: np.ndarray, offset: int, first: int, end: int) -> int:
        """Return the last sample of a climb: before a shift down, and where the engine is fastest in its last gear."""
        known = np.where(np.isnan(gear[first:end]), 0.0, gear[first:end])
        highest = np.maximum.accumulate(known)
        down = np.flatnonzero((known < highest) & ~np.isnan(gear[first:end]))
        stop = first + int(down[0]) if len(down) else end
        entered = first + int(np.argmax(highest[: stop - first] == highest[stop - first - 1]))
        return _fastest(self.time[offset + entered : offset + stop], engine[entered:stop], self.limits) + entered


class ByEngineSpeed:
    """Climbs where neither gear nor vehicle speed is logged: the engine speed falls at every shift and rises again.

    Lifting the foot looks the same, so two such falls are asked for, and a sampling that shows them.
    """

    def __init__(self, time: np.ndarray, engine: np.ndarray, limits: Thresholds) -> None:
        self.time, self.engine, self.limits = time, engine, limits

    def resting(self, part: slice) -> np.ndarray:
        """Return at which samples the engine idles."""
        return idling(smoothed(self.engine[part]), self.limits)

    def climbs(self, part: slice) -> Iterator[Climb]:
        """Return the accelerations with two shifts and more; none in a stretch that is too coarse to show them."""
        time = self.time[part]
        if shows_shifts(len(time), np.median(np.diff(time)) if len(time) > 1 else np.inf, self.limits):
            yield from self.climbs_in(part, smoothed(self.engine[part]))

    def climbs_in(self, part: slice, smooth: np.ndarray) -> Iterator[Climb]:
        """Return the accelerations of a part whose engine speed is smoothed already."""
        time, limits = self.time[part], self.limits
        resting = idling(smooth, limits)
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
            yield Climb(part.start + first, part.start + last, (), True, True)

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


def smoothed(engine: np.ndarray) -> np.ndarray:
    """Return the engine speed of one stretch as the median of each sample and two on either side."""
    return pd.Series(engine).rolling(5, center=True, min_periods=1).median().to_numpy()


def idling(engine: np.ndarray, limits: Thresholds) -> np.ndarray:
    """Return at which samples the engine idles."""
    idles: np.ndarray = (engine > limits.idle_low) & (engine < limits.idle_high)
    return idles


def shows_shifts(samples: int, step: float, limits: Thresholds) -> bool:
    """Tell whether the engine speed of a stretch of so many samples, so far apart in the median [s], shows shifts."""
    return samples >= 10 and step <= limits.shift_sampling


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
