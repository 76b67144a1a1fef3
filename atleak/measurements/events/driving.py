"""Detect idling, stall tests, lock-ups, steady driving and starts of the engine; how far the converter slips."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pandas as pd

from atleak.common.sentences import Sentence
from atleak.measurements.events.event import (
    USUAL,
    Event,
    EventKind,
    Thresholds,
    gear_engaged,
    runs,
    segments,
    standing_samples,
)
from atleak.measurements.road_test import RoadTest


def hot_idle(road_test: RoadTest, limits: Thresholds = USUAL) -> list[Event]:
    """Return hot idling: the car stands, the engine idles, the fluid is at working temperature."""
    engine, atf = road_test.values("engine_speed"), road_test.values("atf_temperature")
    standing = standing_samples(road_test, limits)
    if engine is None or standing is None or atf is None:
        return []
    mask = standing & (engine > limits.idle_low) & (engine < limits.idle_high) & (atf >= limits.hot)
    return _events("hot_idle", road_test, mask, limits.idle_seconds)


_NOTHING = Sentence("")


def _events(
    kind: EventKind, road_test: RoadTest, mask: np.ndarray, shortest: float, note: Sentence = _NOTHING
) -> list[Event]:
    """Return an event for every run of samples that lasts long enough [s]."""
    time, found = road_test.time, runs(road_test, mask, shortest)
    return [Event(kind, float(time[low]), float(time[high]), note=note) for low, high in found]


def stalls(road_test: RoadTest, limits: Thresholds = USUAL) -> list[Event]:
    """Return stall tests: the car stands while the engine pulls against the converter; a logged turbine stands too.

    A run longer than `Thresholds.stall_longest` is no stall test but an engine revved in neutral or park.
    """
    engine, standing = road_test.values("engine_speed"), standing_samples(road_test, limits)
    if engine is None or standing is None:
        return []
    mask = standing & (engine > limits.stall_speed)
    turbine, gear = road_test.values("turbine_speed"), gear_engaged(road_test)
    if turbine is not None:
        mask &= turbine <= 0.15 * engine
    elif gear is None or road_test.channel("gear") is None:
        return []  # revving in neutral looks the same
    else:
        mask &= np.isfinite(gear) & (gear != 0)
    return [
        event
        for event in _events("stall", road_test, mask, limits.stall_seconds)
        if event.duration <= limits.stall_longest
    ]


def lock_ups(road_test: RoadTest, limits: Thresholds = USUAL) -> list[Event]:
    """Return lock-ups: engine and turbine turn alike; without a turbine speed, the lock-up is commanded.

    Where the car stands, or no gear is engaged, there is none: the engine turns an idle turbine along.
    """
    engine, turbine = road_test.values("engine_speed"), road_test.values("turbine_speed")
    channel, note = road_test.values("lock_up"), _NOTHING
    if engine is not None and turbine is not None:
        locked = (np.abs(engine - turbine) < limits.slip) & (engine > limits.idle_high)
    elif channel is not None and (commanded := np.fmax.reduce(channel, initial=np.nan)) > 0:
        locked = channel >= 0.5 * commanded
        note = Sentence("commanded: no turbine speed shows whether it held")
    else:
        return []
    standing, gear = standing_samples(road_test, limits), gear_engaged(road_test)
    for idle in (standing, None if gear is None else gear == 0):
        if idle is not None:
            locked &= ~idle
    return _events("lock_up", road_test, locked, limits.lock_up_seconds, note)


def steady_driving(road_test: RoadTest, limits: Thresholds = USUAL) -> list[Event]:
    """Return steady driving: vehicle and engine speed stay within a narrow band for some seconds."""
    engine, vehicle = road_test.values("engine_speed"), road_test.values("vehicle_speed")
    if engine is None or vehicle is None:
        return []
    mask = np.zeros(len(road_test.time), bool)
    for part in segments(road_test):
        steps = np.diff(road_test.time[part])
        step = float(np.median(steps[steps > 0])) if (steps > 0).any() else 0.0
        count = max(3, math.ceil(limits.steady_seconds / step) + 1) if step > 0.0 else math.inf
        if count <= part.stop - part.start:
            window = int(count)
            calm = (vehicle[part] > limits.steady_speed) & _band(engine[part], window, limits.steady_engine)
            calm &= _band(vehicle[part], window, limits.steady_vehicle)
            # every sample of a calm window belongs to it
            mask[part] = pd.Series(calm[::-1].astype(float)).rolling(window, min_periods=1).max().to_numpy()[::-1] > 0
    return _events("steady_driving", road_test, mask, limits.steady_seconds)


def _band(values: np.ndarray, count: int, width: float) -> np.ndarray:
    """Return whether the ``count`` samples up to each one lie within ± width of their middle."""
    rolling = pd.Series(values).rolling(count, min_periods=count)
    with np.errstate(invalid="ignore"):
        return ((rolling.max() - rolling.min()) <= 2 * width).to_numpy()


def engine_starts(road_test: RoadTest, limits: Thresholds = USUAL) -> list[Event]:
    """Return the first moments after each start of the engine, in which pressure builds up.

    A start begins with the first sample at which a standing engine turns, in the same stretch of the log, and ends
    three seconds after the engine first runs by itself. One sample without speed between others is a fault of the
    logger, not a standstill. A log that begins with the engine running has no start there.
    """
    engine = road_test.values("engine_speed")
    if engine is None:
        return []
    time, starts = road_test.time, []
    begins = {part.start for part in segments(road_test)}
    stands = list(runs(road_test, engine < limits.engine_standing, 0.0))
    # the engine turns until it stands again or the stretch ends
    ends = np.unique([*(part.stop for part in segments(road_test)), *(low for low, _ in stands)])
    for low, high in stands:
        first = high + 1
        end = int(ends[np.searchsorted(ends, high, side="right")])
        if first == end or not (low in begins or time[first] - time[low] >= limits.engine_standing_seconds):
            continue
        running = np.flatnonzero(engine[first:end] >= limits.idle_low)
        last = float(time[end - 1])
        if len(running):
            last = min(last, float(time[first + int(running[0])]) + limits.start_seconds)
        starts.append(Event("engine_start", float(time[first]), last))
    return starts


_TURNS = 100 / 60  # [1/s] of the turbine, below which the car stands
_FEWEST = 20  # samples of which a range is told


@dataclass(frozen=True)
class ConverterSlip:
    """Engine speed minus turbine speed [1/s] while the car drives: 5 and 95 of 100 samples lie below the ends."""

    low: float  # [1/s] 5 % of the samples lie below
    median: float  # [1/s]
    high: float  # [1/s] 5 % lie above
    locked_seconds: float  # [s] with hardly any slip
    commanded_seconds: float | None  # [s] with lock-up commanded; None where that is not logged
    commanded_median: float | None  # [1/s] of slip then, either way


def converter_slip(road_test: RoadTest, limits: Thresholds = USUAL) -> ConverterSlip | None:
    """Return the slip of the converter; None where engine or turbine speed are not logged, or the car never drives."""
    engine, turbine = road_test.values("engine_speed"), road_test.values("turbine_speed")
    if engine is None or turbine is None:
        return None
    slip, standing = engine - turbine, standing_samples(road_test, limits)
    driving = np.isfinite(slip) & (engine >= limits.idle_low) & (turbine > _TURNS)
    if standing is not None:
        driving &= ~standing
    if np.count_nonzero(driving) < _FEWEST:
        return None
    low, median, high = (float(percentile) for percentile in np.percentile(slip[driving], (5, 50, 95)))
    locked = sum(event.duration for event in lock_ups(road_test, limits))
    command = road_test.values("lock_up")
    if command is None or not np.isfinite(command).any() or not np.nanmax(command) > 0:
        return ConverterSlip(low, median, high, locked, None, None)
    wanted = driving & (command >= 0.5 * np.nanmax(command))
    spans = [slice(first, last + 1) for first, last in runs(road_test, wanted, limits.lock_up_seconds)]
    seconds = sum(float(road_test.time[span.stop - 1] - road_test.time[span.start]) for span in spans)
    then = np.concatenate([np.abs(slip[span]) for span in spans]) if spans else np.zeros(0)
    return ConverterSlip(low, median, high, locked, seconds, float(np.median(then)) if len(then) else None)
