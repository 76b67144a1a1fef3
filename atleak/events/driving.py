"""Detect idling, stall tests, lock-ups, steady driving and starts of the engine in a road test."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd

from atleak.events.event import Event, Thresholds, gear_engaged, runs, segments, standing_samples
from atleak.road_test import RoadTest
from atleak.sentence import Sentence


def hot_idle(road_test: RoadTest, limits: Thresholds | None = None) -> list[Event]:
    """Return hot idling: the car stands, the engine idles, the fluid is at working temperature."""
    limits = limits or Thresholds()
    mask = hot_idling_samples(road_test, limits)
    if mask is None:
        return []
    time = road_test.time
    return [
        Event("hot_idle", float(time[low]), float(time[high]))
        for low, high in runs(road_test, mask, limits.idle_seconds)
    ]


def hot_idling_samples(road_test: RoadTest, limits: Thresholds) -> np.ndarray | None:
    """Return at which samples the engine idles hot, the car at rest; None where the log does not show it."""
    engine, standing, atf = (
        road_test.values("engine_speed"),
        standing_samples(road_test, limits),
        road_test.values("atf_temperature"),
    )
    if engine is None or standing is None or atf is None:
        return None
    idling: np.ndarray = standing & (engine > limits.idle_low) & (engine < limits.idle_high) & (atf >= limits.hot)
    return idling


def stalls(road_test: RoadTest, limits: Thresholds | None = None) -> list[Event]:
    """Return stall tests: the car stands while the engine pulls against the converter; a logged turbine stands too.

    A run longer than `Thresholds.stall_longest` is no stall test but an engine revved in neutral or park.
    """
    limits = limits or Thresholds()
    mask = stalling_samples(road_test, limits)
    if mask is None:
        return []
    time = road_test.time
    return [
        Event("stall", float(time[low]), float(time[high]))
        for low, high in runs(road_test, mask, limits.stall_seconds)
        if time[high] - time[low] <= limits.stall_longest
    ]


def stalling_samples(road_test: RoadTest, limits: Thresholds) -> np.ndarray | None:
    """Return at which samples the engine pulls against the converter; None where the log does not show it."""
    engine, standing = road_test.values("engine_speed"), standing_samples(road_test, limits)
    if engine is None or standing is None:
        return None
    mask: np.ndarray = standing & (engine > limits.stall_speed)
    turbine = road_test.values("turbine_speed")
    if turbine is not None:
        return mask & (turbine <= 0.15 * engine)
    if road_test.channel("gear") is None:
        return None  # revving in neutral looks the same
    gear = np.asarray(gear_engaged(road_test))
    return mask & np.isfinite(gear) & (gear != 0)


def lock_ups(road_test: RoadTest, limits: Thresholds | None = None) -> list[Event]:
    """Return lock-ups: engine and turbine turn alike; without a turbine speed, the lock-up is commanded.

    Where the car stands, or no gear is engaged, there is none: the engine turns an idle turbine along.
    """
    limits = limits or Thresholds()
    locked = locked_samples(road_test, limits, largest(road_test.values("lock_up")))
    if locked is None:
        return []
    mask, note = locked
    time = road_test.time
    return [
        Event("lock_up", float(time[low]), float(time[high]), note=note)
        for low, high in runs(road_test, mask, limits.lock_up_seconds)
    ]


def largest(values: np.ndarray | None) -> float:
    """Return the largest of some values that are known; NaN of none."""
    return float("nan") if values is None else float(np.fmax.reduce(values, initial=np.nan))


def locked_samples(road_test: RoadTest, limits: Thresholds, commanded: float) -> tuple[np.ndarray, Sentence] | None:
    """Return at which samples the converter is locked, and what is to be said of that; None where nothing shows it.

    ``commanded`` is the largest value of the log's command to lock up.
    """
    engine, turbine = road_test.values("engine_speed"), road_test.values("turbine_speed")
    channel = road_test.values("lock_up")
    if engine is not None and turbine is not None:
        locked, note = (np.abs(engine - turbine) < limits.slip) & (engine > limits.idle_high), Sentence("")
    elif channel is not None and commanded > 0:
        locked = channel >= 0.5 * commanded
        note = Sentence("commanded: no turbine speed shows whether it held")
    else:
        return None
    standing, gear = standing_samples(road_test, limits), gear_engaged(road_test)
    for idle in (standing, None if gear is None else gear == 0):
        if idle is not None:
            locked &= ~idle
    return locked, note


def steady_driving(road_test: RoadTest, limits: Thresholds | None = None) -> list[Event]:
    """Return steady driving: vehicle and engine speed stay within a narrow band for some seconds."""
    limits = limits or Thresholds()
    engine, vehicle = road_test.values("engine_speed"), road_test.values("vehicle_speed")
    if engine is None or vehicle is None:
        return []
    mask = np.zeros(len(road_test.time), bool)
    for part in segments(road_test):
        steps = np.diff(road_test.time[part])
        count = steady_count(float(np.median(steps[steps > 0])) if (steps > 0).any() else 0.0, limits)
        if count <= part.stop - part.start:
            mask[part] = steady_samples(engine[part], vehicle[part], count, limits)
    time = road_test.time
    return [
        Event("steady_driving", float(time[low]), float(time[high]))
        for low, high in runs(road_test, mask, limits.steady_seconds)
    ]


def steady_count(step: float, limits: Thresholds) -> float:
    """Return how many samples make steady driving, by the median step of their stretch [s]; endless at no step."""
    return max(3, math.ceil(limits.steady_seconds / step) + 1) if step > 0.0 else math.inf


def steady_samples(engine: np.ndarray, vehicle: np.ndarray, count: float, limits: Thresholds) -> np.ndarray:
    """Return which samples of one stretch lie in a window of so many in which the speeds stay in narrow bands."""
    window = int(count)
    calm = (vehicle > limits.steady_speed) & _band(engine, window, limits.steady_engine)
    calm &= _band(vehicle, window, limits.steady_vehicle)
    # every sample of a calm window belongs to it
    return pd.Series(calm[::-1].astype(float)).rolling(window, min_periods=1).max().to_numpy()[::-1] > 0


def _band(values: np.ndarray, count: int, width: float) -> np.ndarray:
    """Return whether the ``count`` samples up to each one lie within ± width of their middle."""
    rolling = pd.Series(values).rolling(count, min_periods=count)
    with np.errstate(invalid="ignore"):
        return ((rolling.max() - rolling.min()) <= 2 * width).to_numpy()


def engine_starts(road_test: RoadTest, limits: Thresholds | None = None) -> list[Event]:
    """Return the first moments after each start of the engine, in which pressure builds up.

    A start begins with the first sample at which a standing engine turns, in the same stretch of the log, and ends
    three seconds after the engine first runs by itself. One sample without speed between others is a fault of the
    logger, not a standstill. A log that begins with the engine running has no start there.
    """
    limits = limits or Thresholds()
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
