"""Detect idling, stall tests, lock-ups, steady driving and starts of the engine in a road test."""

from __future__ import annotations

import numpy as np
import pandas as pd

from atleak.events.event import Event, Thresholds, runs, segments, standing_samples
from atleak.road_test import ChannelSource, RoadTest
from atleak.sentence import Sentence


def hot_idle(road_test: RoadTest, limits: Thresholds | None = None) -> list[Event]:
    """Return hot idling: the car stands, the engine idles, the fluid is at working temperature."""
    limits = limits or Thresholds()
    engine, standing, atf = (
        road_test.values("engine_speed"),
        standing_samples(road_test, limits),
        road_test.values("atf_temperature"),
    )
    if engine is None or standing is None or atf is None:
        return []
    mask = standing & (engine > limits.idle_low) & (engine < limits.idle_high) & (atf >= limits.hot)
    time = road_test.time
    return [
        Event("hot_idle", float(time[low]), float(time[high]))
        for low, high in runs(road_test, mask, limits.idle_seconds)
    ]


def stalls(road_test: RoadTest, limits: Thresholds | None = None) -> list[Event]:
    """Return stall tests: the car stands while the engine pulls against the converter; a logged turbine stands too.

    A run longer than `Thresholds.stall_longest` is no stall test but an engine revved in neutral or park.
    """
    limits = limits or Thresholds()
    engine, standing = road_test.values("engine_speed"), standing_samples(road_test, limits)
    if engine is None or standing is None:
        return []
    mask = standing & (engine > limits.stall_speed)
    turbine, gear = road_test.values("turbine_speed"), road_test.values("gear")
    if turbine is not None:
        mask &= ~(turbine > 0.15 * engine)
    elif gear is not None:
        mask &= ~(gear == 0)
    else:
        return []  # revving in neutral looks the same
    time = road_test.time
    return [
        Event("stall", float(time[low]), float(time[high]))
        for low, high in runs(road_test, mask, limits.stall_seconds)
        if time[high] - time[low] <= limits.stall_longest
    ]


def lock_ups(road_test: RoadTest, limits: Thresholds | None = None) -> list[Event]:
    """Return lock-ups: engine and turbine turn alike; without a turbine speed, the lock-up is commanded."""
    limits = limits or Thresholds()
    engine, turbine = road_test.values("engine_speed"), road_test.values("turbine_speed")
    source: ChannelSource = "logged"
    note = Sentence("")
    if engine is not None and turbine is not None:
        mask = (np.abs(engine - turbine) < limits.slip) & (engine > limits.idle_high)
    else:
        channel = road_test.values("lock_up")
        if channel is None or not np.isfinite(channel).any() or not np.nanmax(channel) > 0:
            return []
        mask = channel >= 0.5 * np.nanmax(channel)
        note = Sentence("commanded: no turbine speed shows whether it held")
    time = road_test.time
    return [
        Event("lock_up", float(time[low]), float(time[high]), source=source, note=note)
        for low, high in runs(road_test, mask, limits.lock_up_seconds)
    ]


def steady_driving(road_test: RoadTest, limits: Thresholds | None = None) -> list[Event]:
    """Return steady driving: vehicle and engine speed stay within a narrow band for some seconds."""
    limits = limits or Thresholds()
    engine, vehicle = road_test.values("engine_speed"), road_test.values("vehicle_speed")
    if engine is None or vehicle is None:
        return []
    mask = np.zeros(len(road_test.time), bool)
    for part in segments(road_test):
        time = road_test.time[part]
        steps = np.diff(time)
        steps = steps[steps > 0]
        if not len(steps):
            continue
        count = max(3, int(np.ceil(limits.steady_seconds / np.median(steps))) + 1)
        if count > len(time):
            continue
        calm = (vehicle[part] > limits.steady_speed) & _band(engine[part], count, limits.steady_engine)
        calm &= _band(vehicle[part], count, limits.steady_vehicle)
        # every sample of a calm window belongs to it
        ends = pd.Series(calm[::-1].astype(float)).rolling(count, min_periods=1).max().to_numpy()[::-1] > 0
        mask[part] = ends
    time = road_test.time
    return [
        Event("steady_driving", float(time[low]), float(time[high]))
        for low, high in runs(road_test, mask, limits.steady_seconds)
    ]


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
