"""Detect idling, stall tests, shifts, lock-ups, steady driving and starts of the engine; how far the converter slips.

Where no gear is logged it is derived from the ratio of the speeds.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np
import pandas as pd

from atleak.common.errors import Message
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
from atleak.measurements.road_test import Channel, ChannelSource, RoadTest

_NOTHING = Sentence("")
_TURNS = 100 / 60  # [1/s] of the turbine, below which the car stands
_FEWEST = 20  # samples of which a range is told
_APART, _NEAR = 0.12, 0.03  # of the logarithm: between two levels, and around one
_FEWEST_OF_A_GEAR = 0.02  # part of a log's samples that are near a level


def hot_idle(road_test: RoadTest, limits: Thresholds = USUAL) -> list[Event]:
    """Return hot idling: the car stands, the engine idles, the fluid is at working temperature."""
    engine, atf = road_test.values("engine_speed"), road_test.values("atf_temperature")
    standing = standing_samples(road_test, limits)
    if engine is None or standing is None or atf is None:
        return []
    mask = standing & (engine > limits.idle_low) & (engine < limits.idle_high) & (atf >= limits.hot)
    return _events("hot_idle", road_test, mask, limits.idle_seconds)


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
    """Return the slip of the converter [1/s]; None without engine or turbine speed, or where the car never drives."""
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


def gear_shifts(road_test: RoadTest, limits: Thresholds = USUAL) -> list[Event]:
    """Return shifts between forward gears in their order; none where neither gear nor ratio is logged.

    They follow from the ratio of turbine to output speed where both are logged, since a logged gear may lag by half a
    second; else from the gear channel. Two gears with reverse between them, or with neutral or an unknown gear for
    longer than `Thresholds.shift_pause`, are no shift.
    """
    channel = road_test.channel("gear")
    ratio = speed_ratio(road_test, ("turbine_speed",))
    if channel is None and ratio is None:
        return []
    shifts: list[Event] = []
    known = with_derived_gear(road_test)
    if known.channel("gear") is None:
        return []
    gear = np.asarray(gear_engaged(known))
    source: ChannelSource = channel.source if channel else "derived"
    for part in segments(road_test):
        rows = np.flatnonzero(np.isfinite(gear[part]) & (gear[part] != 0))
        times, values = road_test.time[part][rows], gear[part][rows]
        # neighbours, or soon after each other
        soon = (np.diff(rows) == 1) | (np.diff(times) <= limits.shift_pause)
        forward = (values[:-1] > 0) & (values[1:] > 0)
        for step in np.flatnonzero((np.diff(values) != 0) & forward & soon):
            after = rows[step + 1]
            event = Event(
                "gear_shift", float(times[step]), float(times[step + 1]), int(values[step]), int(values[step + 1]),
                source,
            )  # fmt: skip
            if ratio is not None and event.source == "logged":
                event = _by_ratio(event, road_test.time[part], ratio[part], int(after), limits)
            shifts.append(event)
    return shifts


def _by_ratio(event: Event, time: np.ndarray, values: np.ndarray, high: int, limits: Thresholds) -> Event:
    """Correct a shift's beginning and end by the ratio of turbine speed to output speed in its stretch.

    ``high`` is the sample with which the new gear begins.
    """
    before = (time > time[high] - 4.0) & (time < time[high] - 2.0)
    after = (time > time[high]) & (time < time[high] + 2.0)
    if not np.isfinite(values[before]).any() or not np.isfinite(values[after]).any():
        return event
    old, new = float(np.nanmedian(values[before])), float(np.nanmedian(values[after]))
    if abs(new / old - 1) < 0.1:
        return event
    near = np.flatnonzero((time >= time[high] - 2.0) & (time <= time[high] + 1.0))
    left = near[np.abs(values[near] / old - 1) > limits.ratio_tolerance]
    reached = near[np.abs(values[near] / new - 1) <= limits.ratio_tolerance]
    if not len(left) or not len(reached):
        return event
    start, stop = time[max(left[0] - 1, 0)], time[reached[0]]
    if stop <= start:
        return event
    lag = float(time[high] - stop)
    note = Sentence("the logged gear lags by {lag:.2f} s", lag=lag) if lag > 0 else Sentence("")
    return replace(event, start=float(start), stop=float(stop), note=note)


def speed_ratio(road_test: RoadTest, drivers: Sequence[str] = ("turbine_speed", "engine_speed")) -> np.ndarray | None:
    """Return the ratio of speed before the gears to speed behind them; its scale is arbitrary for vehicle speed."""
    above = next((road_test.values(name) for name in drivers if road_test.values(name) is not None), None)
    below = next(
        (road_test.values(name) for name in ("output_speed", "vehicle_speed") if road_test.values(name) is not None),
        None,
    )
    if above is None or below is None:
        return None
    moving = below > (2.0 if road_test.values("output_speed") is None else 1.0)
    return np.where(moving & (above > 0), above / np.where(moving, below, 1.0), np.nan)


def ratio_levels(ratio: np.ndarray) -> list[float]:
    """Return the ratios at which a log stays, highest first: the gears. Levels closer than 12 % are one.

    >>> r = np.repeat([2.8, 1.5, 1.0], 200)
    >>> [round(level, 2) for level in ratio_levels(r)]
    [2.8, 1.5, 1.0]
    """
    logarithms = np.log(ratio[np.isfinite(ratio) & (ratio > 0)])
    if len(logarithms) < 50:
        return []
    least, most = logarithms.min(), logarithms.max()
    edges = np.arange(least - 0.02, most + 0.04, 0.02)
    counts = np.histogram(logarithms, edges)[0]
    wide = np.convolve(counts, np.ones(3), "same")
    order = np.argsort(wide)[::-1]
    levels: list[float] = []
    for index in order:
        if wide[index] < _FEWEST_OF_A_GEAR * len(logarithms):
            break
        bin_middle = 0.5 * (edges[index] + edges[index + 1])
        if any(abs(bin_middle - level) <= _APART - _NEAR for level in levels):
            continue  # whatever is near it is near that level
        near = logarithms[np.abs(logarithms - bin_middle) < _NEAR]
        if not len(near):
            continue
        middle = float(np.median(near))
        if all(abs(middle - level) > _APART for level in levels):
            # a gear stands out from the ratios that a shift passes through
            wide_around, near_it = (np.count_nonzero(np.abs(logarithms - middle) < width) for width in (_APART, _NEAR))
            if near_it / wide_around > 0.45:
                levels.append(middle)
    return [float(np.exp(level)) for level in sorted(levels, reverse=True)]


def with_derived_gear(road_test: RoadTest) -> RoadTest:
    """Return the road test with a gear derived from the speed ratio, marked ``derived``; unchanged where one is logged.

    A warning says how many ratios were found; without any the test is the same.

    The levels found in the log are numbered from the highest ratio as first gear. Between gears, and with a slipping
    converter, the gear is unknown.
    """
    ratio = None if road_test.channel("gear") is not None else speed_ratio(road_test)
    levels = np.array([] if ratio is None else ratio_levels(ratio))
    if ratio is None or not len(levels):
        return road_test
    distance = np.abs(ratio[:, None] / levels - 1)
    nearest = np.argmin(np.where(np.isnan(distance), np.inf, distance), axis=1)
    close = distance[np.arange(len(ratio)), nearest] <= Thresholds.ratio_tolerance
    gear = np.where(close, nearest + 1.0, np.nan)
    channel = Channel(
        *("gear", road_test.time, gear, np.zeros(len(gear), bool)),
        source="derived",
        independent=int(np.count_nonzero(gear > 0)),
    )
    text = Sentence(
        "no gear is logged: it is derived from the speed ratio ({count} ratios found in the log, the highest taken "
        "as first gear)",
        count=len(levels),
    )
    return replace(
        road_test,
        channels=MappingProxyType({**road_test.channels, "gear": channel}),
        messages=(*road_test.messages, Message("warning", "gear_derived", text)),
        _held={},
    )
