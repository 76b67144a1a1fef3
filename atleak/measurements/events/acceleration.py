"""Detect minimum-acceleration tests in a road test: from idle through the gears, the engine never above 2500 rpm.

The source study's own logger recorded no vehicle speed, so a test is recognised by what there is: vehicle speed, else
the gear, else the falls of the engine speed at each shift.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
import pandas as pd

from atleak.measurements.events.event import USUAL, AccelerationTest, Event, TestFault, Thresholds, segments
from atleak.measurements.road_test import RoadTest


@dataclass(frozen=True)
class Climb:
    """An acceleration from rest, by first and last sample of the log; ``carried``: far enough to be a test."""

    first: int
    last: int
    gears: tuple[int, ...]  # passed, rising; none where no gear is known
    carried: bool
    begun: bool  # far enough to have been meant as a test


def minimum_acceleration(road_test: RoadTest, limits: Thresholds = USUAL, gears: Sequence[int] = ()) -> list[Event]:
    """Return the minimum-acceleration tests, each with how it was driven: broken off below the highest of ``gears``.

    A test begins with the last sample at rest and ends where the car slows down or the recording breaks off. One that
    was driven too fast or broken off is named only where it is the one acceleration of its stretch and most of what was
    driven there: elsewhere it is a drive like any other. An acceleration that stays below 30 km/h, or in first gear,
    does not count; nor does what follows an engine speed above the limit.
    """
    engine, vehicle = road_test.values("engine_speed"), road_test.values("vehicle_speed")
    time, gear = road_test.time, road_test.values("gear")
    if engine is None:
        return []
    if vehicle is not None:
        climbs_of = partial(_by_vehicle_speed, vehicle, gear, limits)
    elif gear is not None:
        climbs_of = partial(_by_gear, time, engine, gear, limits)
    else:
        climbs_of = partial(_by_engine_speed, time, engine, limits)
    tests: list[Event | None] = []
    for part in segments(road_test):
        climbs = [climb for climb in climbs_of(part) if climb.begun]
        steps = np.diff(time[part], append=time[part][-1])
        driven = float(np.sum(steps[~(engine[part] < limits.idle_high)]))  # [s] for which the engine does not idle
        for climb in climbs:
            alone = len(climbs) == 1 and bool(time[climb.last] - time[climb.first] >= 0.5 * driven)
            test = _judged(time, engine, climb, limits, max(gears, default=0), alone)
            fast = np.flatnonzero(engine[climb.first : climb.last + 1] > limits.gentle_speed)
            if test is None and len(fast):  # it may be one until the engine was revved higher
                gentle = climbs_of(slice(climb.first, climb.first + int(fast[0])))
                first = next((climb for climb in gentle if climb.carried), None)
                test = None if first is None else _judged(time, engine, first, limits, 0, False)
            tests.append(test)
    return [test for test in tests if test is not None]


def _judged(
    time: np.ndarray, engine: np.ndarray, climb: Climb, limits: Thresholds, top: int, alone: bool
) -> Event | None:
    """Return the test that a climb is; None where it is none.

    ``top`` is the highest gear of the valve body, 0 where it is not known; ``alone``: whether it is the one
    acceleration of its stretch and most of what was driven there.
    """
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


def _by_vehicle_speed(vehicle: np.ndarray, gear: np.ndarray | None, limits: Thresholds, part: slice) -> Iterator[Climb]:
    """Return every acceleration from rest, however far: from the last sample at standstill to the highest speed."""
    speed = vehicle[part]
    standing = speed < limits.standing
    for _, first, end in _departures(standing, speed >= limits.standing):
        run = speed[first:end]
        slower = np.flatnonzero(run < np.fmax.accumulate(run) - limits.gentle_back)
        run = run[: int(slower[0])] if len(slower) else run
        if len(run) < 2 or not np.isfinite(run).any():
            continue
        last = first + int(np.nanargmax(run))
        passed = _passed(gear, part.start + first, part.start + last)
        fastest, shifted = float(np.nanmax(run)), max(passed, default=0) >= 2
        carried = fastest >= limits.gentle_end and (shifted or gear is None)
        begun = shifted if gear is not None else fastest >= limits.gentle_begun
        yield Climb(part.start + first, part.start + last, passed, carried, begun)


def _by_gear(
    time: np.ndarray, engine: np.ndarray, gear: np.ndarray, limits: Thresholds, part: slice
) -> Iterator[Climb]:
    """Return the accelerations from idle in first gear up to another gear, where no vehicle speed is logged."""
    engine, gear = engine[part], gear[part]
    resting = _idling(engine, limits) & ((gear == 0) | (gear == 1))
    for begin, leaving, end in _departures(resting, ~resting):
        # before a shift down, and where the engine is fastest in its last gear
        known = np.where(np.isnan(gear[leaving:end]), 0.0, gear[leaving:end])
        highest = np.maximum.accumulate(known)
        down = np.flatnonzero((known < highest) & ~np.isnan(gear[leaving:end]))
        stop = leaving + int(down[0]) if len(down) else end
        entered = leaving + int(np.argmax(highest[: stop - leaving] == highest[stop - leaving - 1]))
        last = _fastest(time[part.start + entered : part.start + stop], engine[entered:stop], limits) + entered
        if max(_passed(gear, leaving, last), default=0) >= 2:
            first = _leaves_idle(engine, begin, leaving, limits)
            yield Climb(part.start + first, part.start + last, _passed(gear, first, last), True, True)


def _by_engine_speed(time: np.ndarray, engine: np.ndarray, limits: Thresholds, part: slice) -> Iterator[Climb]:
    """Return the accelerations with two shifts and more, at each of which the engine speed falls and rises again.

    Lifting the foot looks the same, so two such falls are asked for, and a sampling that shows them.
    """
    time = time[part]
    if len(time) < 10 or np.median(np.diff(time)) > limits.shift_sampling:
        return
    smooth = pd.Series(engine[part]).rolling(5, center=True, min_periods=1).median().to_numpy()
    resting = _idling(smooth, limits)
    for begin, leaving, end in _departures(resting, ~resting):
        shifts = _shifts(time[leaving:end], smooth[leaving:end], limits)
        if len(shifts) >= 2:
            entered = leaving + shifts[-1]
            last = entered + _fastest(time[entered:end], smooth[entered:end], limits)
            first = _leaves_idle(smooth, begin, leaving, limits)
            yield Climb(part.start + first, part.start + last, (), True, True)


def _shifts(time: np.ndarray, speed: np.ndarray, limits: Thresholds) -> list[int]:
    """Return the samples to which the speed falls within a second, not to idle, and from which it rises again."""
    shifts: list[int] = []
    before = 0  # sample from which the next fall is looked for
    while True:
        tops = np.fmax.accumulate(speed[before:])
        fallen = np.flatnonzero(speed[before:] <= (1.0 - limits.shift_fall) * tops)
        if not len(fallen):
            return shifts
        at = before + int(fallen[0])
        near = np.flatnonzero((time >= time[at]) & (time <= time[at] + 1.0))
        lowest = int(near[np.nanargmin(speed[near])])
        top = before + int(np.nanargmax(speed[before : at + 1]))
        last_near_top = int(np.flatnonzero(speed[: lowest + 1] >= 0.97 * speed[top])[-1])
        sudden = time[lowest] - time[last_near_top] <= limits.shift_longest
        after = speed[lowest : lowest + int(np.searchsorted(time[lowest:], time[lowest] + 2.0))]
        rises = len(after) > 1 and np.nanmax(after) >= 1.02 * speed[lowest]
        if not sudden or not rises or speed[lowest] < 0.55 * speed[top]:
            return shifts  # the foot was lifted: the climb ends
        shifts.append(lowest)
        before = lowest


def _departures(resting: np.ndarray, away: np.ndarray) -> Iterator[tuple[int, int, int]]:
    """Yield where a rest begins and ends whose next sample is away, and the next sample at rest, or the log's end."""
    rests, moves = np.append(np.flatnonzero(resting), len(resting)), np.append(-1, np.flatnonzero(~resting))
    for leaving in np.flatnonzero(resting[:-1] & away[1:]):
        begin = moves[np.searchsorted(moves, leaving) - 1] + 1
        yield int(begin), int(leaving), int(rests[np.searchsorted(rests, leaving, side="right")])


def _idling(engine: np.ndarray, limits: Thresholds) -> np.ndarray:
    idles: np.ndarray = (engine > limits.idle_low) & (engine < limits.idle_high)
    return idles


def _leaves_idle(engine: np.ndarray, begin: int, leaving: int, limits: Thresholds) -> int:
    """Return the last sample of a run at rest that is within 50 rpm of the idle speed."""
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
    return tuple(int(number) for number in np.unique(values[values > 0]))
