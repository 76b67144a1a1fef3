"""Detects what happened in a road test: shifts, idle, stall, lock-up, steady driving, minimum-acceleration test.

Every event is a window of time; `RoadTest.window` gives the samples in it. The thresholds are choices of this project,
gathered in `Thresholds`, except where the field's source is named.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Literal

import numpy as np
import pandas as pd

from atleak.errors import Message
from atleak.road_test import Channel, ChannelSource, RoadTest

EventKind = Literal[
    "minimum_acceleration", "gear_shift", "hot_idle", "stall", "lock_up", "steady_driving", "engine_start"
]


@dataclass(frozen=True)
class Thresholds:
    """Limits of the events. Speeds of rotation [1/s], vehicle speeds [m/s], temperatures [°C], durations [s]."""

    standing: float = 1.0 / 3.6
    idle_low: float = 400 / 60
    idle_high: float = 1100 / 60
    hot: float = 70.0
    idle_seconds: float = 3.0
    stall_speed: float = 1400 / 60
    stall_seconds: float = 0.4
    stall_longest: float = 15.0
    gentle_speed: float = 2500 / 60
    gentle_end: float = 30 / 3.6
    gentle_back: float = 5 / 3.6
    slip: float = 50 / 60
    lock_up_seconds: float = 1.0
    steady_seconds: float = 5.0
    steady_speed: float = 20 / 3.6
    steady_vehicle: float = 3 / 3.6
    steady_engine: float = 100 / 60
    ratio_tolerance: float = 0.06
    engine_standing: float = 50 / 60
    engine_standing_seconds: float = 0.5
    start_seconds: float = 3.0


@dataclass(frozen=True)
class Event:
    """One event: ``start`` and ``stop`` [s] on the road test's time; gears only for shifts."""

    kind: EventKind
    start: float
    stop: float
    from_gear: int | None = None
    to_gear: int | None = None
    source: ChannelSource = "logged"
    note: str = ""

    @property
    def duration(self) -> float:
        """Return the length [s]."""
        return self.stop - self.start


def events(road_test: RoadTest, thresholds: Thresholds | None = None) -> tuple[Event, ...]:
    """Return all events of a road test by their start; a missing channel leaves out only the events that need it."""
    limits = thresholds or Thresholds()
    all_events = [
        *gear_shifts(road_test, limits),
        *hot_idle(road_test, limits),
        *stalls(road_test, limits),
        *lock_ups(road_test, limits),
        *steady_driving(road_test, limits),
        *minimum_acceleration(road_test, limits),
        *engine_starts(road_test, limits),
    ]
    return tuple(sorted(all_events, key=lambda event: (event.start, event.kind)))


# --- runs of a condition ------------------------------------------------------------------------------------


def _segments(road_test: RoadTest) -> Iterator[slice]:
    if not road_test.segments:
        yield slice(0, len(road_test.time))
    for segment in road_test.segments:
        yield slice(segment.start_row, segment.start_row + segment.rows)


def _runs(road_test: RoadTest, mask: np.ndarray, shortest: float) -> Iterator[tuple[int, int]]:
    """Yield first and last index of every run of True that lasts long enough; none crosses a segment's end."""
    for part in _segments(road_test):
        edges = np.flatnonzero(np.diff(np.concatenate([[0], mask[part].astype(np.int8), [0]])))
        for low, high in zip(edges[::2], edges[1::2], strict=True):
            first, last = part.start + int(low), part.start + int(high) - 1
            if road_test.time[last] - road_test.time[first] >= shortest:
                yield first, last


def _standing(road_test: RoadTest, limits: Thresholds) -> np.ndarray | None:
    speed = road_test.values("vehicle_speed")
    if speed is not None:
        return speed < limits.standing
    output = road_test.values("output_speed")
    return output < 0.5 if output is not None else None


# --- the events ---------------------------------------------------------------------------------------------


def hot_idle(road_test: RoadTest, limits: Thresholds | None = None) -> list[Event]:
    """Return hot idling: the car stands, the engine idles, the fluid is at working temperature."""
    limits = limits or Thresholds()
    engine, standing, atf = (
        road_test.values("engine_speed"),
        _standing(road_test, limits),
        road_test.values("atf_temperature"),
    )
    if engine is None or standing is None or atf is None:
        return []
    mask = standing & (engine > limits.idle_low) & (engine < limits.idle_high) & (atf >= limits.hot)
    time = road_test.time
    return [
        Event("hot_idle", float(time[low]), float(time[high]))
        for low, high in _runs(road_test, mask, limits.idle_seconds)
    ]


def stalls(road_test: RoadTest, limits: Thresholds | None = None) -> list[Event]:
    """Return stall tests: the car stands while the engine pulls against the converter; a logged turbine stands too.

    A run longer than `Thresholds.stall_longest` is no stall test but an engine revved in neutral or park.
    """
    limits = limits or Thresholds()
    engine, standing = road_test.values("engine_speed"), _standing(road_test, limits)
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
        for low, high in _runs(road_test, mask, limits.stall_seconds)
        if time[high] - time[low] <= limits.stall_longest
    ]


def lock_ups(road_test: RoadTest, limits: Thresholds | None = None) -> list[Event]:
    """Return lock-ups: engine and turbine turn alike; without a turbine speed, the lock-up is commanded."""
    limits = limits or Thresholds()
    engine, turbine = road_test.values("engine_speed"), road_test.values("turbine_speed")
    source: ChannelSource = "logged"
    note = ""
    if engine is not None and turbine is not None:
        mask = (np.abs(engine - turbine) < limits.slip) & (engine > limits.idle_high)
    else:
        channel = road_test.values("lock_up")
        if channel is None or not np.isfinite(channel).any() or not np.nanmax(channel) > 0:
            return []
        mask = channel >= 0.5 * np.nanmax(channel)
        note = "commanded: no turbine speed shows whether it held"
    time = road_test.time
    return [
        Event("lock_up", float(time[low]), float(time[high]), source=source, note=note)
        for low, high in _runs(road_test, mask, limits.lock_up_seconds)
    ]


def steady_driving(road_test: RoadTest, limits: Thresholds | None = None) -> list[Event]:
    """Return steady driving: vehicle and engine speed stay within a narrow band for some seconds."""
    limits = limits or Thresholds()
    engine, vehicle = road_test.values("engine_speed"), road_test.values("vehicle_speed")
    if engine is None or vehicle is None:
        return []
    mask = np.zeros(len(road_test.time), bool)
    for part in _segments(road_test):
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
        for low, high in _runs(road_test, mask, limits.steady_seconds)
    ]


def _band(values: np.ndarray, count: int, width: float) -> np.ndarray:
    """Return whether the ``count`` samples up to each one lie within ± width of their middle."""
    rolling = pd.Series(values).rolling(count, min_periods=count)
    with np.errstate(invalid="ignore"):
        return ((rolling.max() - rolling.min()) <= 2 * width).to_numpy()


def minimum_acceleration(road_test: RoadTest, limits: Thresholds | None = None) -> list[Event]:
    """Return accelerations from standstill through the gears with little throttle: engine never above 2500 rpm.

    It begins with the last sample at standstill and ends where the car slows down, the engine is revved higher, or the
    recording breaks off; one that stays below 30 km/h, or in first gear, does not count.
    """
    limits = limits or Thresholds()
    engine, vehicle = road_test.values("engine_speed"), road_test.values("vehicle_speed")
    if engine is None or vehicle is None:
        return []
    gear = road_test.values("gear")
    accelerations = []
    for part in _segments(road_test):
        speed, engine_speed = vehicle[part], engine[part]
        standing = speed < limits.standing
        starts = np.flatnonzero(standing[:-1] & (speed[1:] >= limits.standing))
        for first in starts:
            later = np.flatnonzero(standing[first + 1 :])
            end = first + 1 + int(later[0]) if len(later) else len(speed)
            run = speed[first:end]
            top = np.fmax.accumulate(run)
            broken_off = np.flatnonzero(
                (run < top - limits.gentle_back) | (engine_speed[first:end] > limits.gentle_speed)
            )
            last = first + int(broken_off[0]) - 1 if len(broken_off) else end - 1
            if last <= first or not np.nanmax(speed[first : last + 1]) >= limits.gentle_end:
                continue
            if gear is not None and not np.nanmax(gear[part][first : last + 1], initial=0) >= 2:
                continue
            last = first + int(np.nanargmax(speed[first : last + 1]))
            time = road_test.time[part]
            accelerations.append(Event("minimum_acceleration", float(time[first]), float(time[last])))
    return accelerations


def gear_shifts(road_test: RoadTest, limits: Thresholds | None = None) -> list[Event]:
    """Return shifts between forward gears.

    They follow from the ratio of turbine to output speed where both are logged, since a logged gear may lag by half a
    second; else from the gear channel.
    """
    limits = limits or Thresholds()
    gear = road_test.values("gear")
    ratio = _ratio(road_test, ("turbine_speed",))
    if gear is None and ratio is None:
        return []
    shifts: list[Event] = []
    if gear is None:
        derived = with_derived_gear(road_test)
        gear = derived.values("gear")
        if gear is None:
            return []
    channel = road_test.channel("gear")
    source: ChannelSource = channel.source if channel else "derived"
    for part in _segments(road_test):
        in_gear = np.flatnonzero(gear[part] > 0)
        if len(in_gear) < 2:
            continue
        values = gear[part][in_gear]
        for step in np.flatnonzero(np.diff(values) != 0):
            before, after = in_gear[step], in_gear[step + 1]
            event = Event(
                "gear_shift", float(road_test.time[part][before]), float(road_test.time[part][after]),
                int(values[step]), int(values[step + 1]), source,
            )  # fmt: skip
            shifts.append(_by_ratio(event, road_test, ratio, part, int(before), int(after), limits))
    return shifts


def _by_ratio(
    event: Event, road_test: RoadTest, ratio: np.ndarray | None, part: slice, low: int, high: int, limits: Thresholds
) -> Event:
    """Correct a shift's beginning and end by the ratio of turbine speed to output speed."""
    if ratio is None or event.source != "logged":
        return event
    time, values = road_test.time[part], ratio[part]
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
    return replace(
        event, start=float(start), stop=float(stop), note=f"the logged gear lags by {lag:.2f} s" if lag > 0 else ""
    )


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
    begins = {part.start for part in _segments(road_test)}
    stands = list(_runs(road_test, engine < limits.engine_standing, 0.0))
    # the engine turns until it stands again or the stretch ends
    ends = np.unique([*(part.stop for part in _segments(road_test)), *(low for low, _ in stands)])
    for low, high in stands:
        first = high + 1
        end = int(ends[np.searchsorted(ends, high, side="right")])
        if first == end or not (low in begins or time[first] - time[low] >= limits.engine_standing_seconds):
            continue
        runs = np.flatnonzero(engine[first:end] >= limits.idle_low)
        last = float(time[end - 1])
        if len(runs):
            last = min(last, float(time[first + int(runs[0])]) + limits.start_seconds)
        starts.append(Event("engine_start", float(time[first]), last))
    return starts


# --- gear from the speed ratio ------------------------------------------------------------------------------


def _ratio(road_test: RoadTest, drivers: Sequence[str] = ("turbine_speed", "engine_speed")) -> np.ndarray | None:
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


def ratio_levels(ratio: np.ndarray, share: float = 0.02) -> list[float]:
    """Return the ratios at which a log stays, highest first: the gears. Levels closer than 12 % are one.

    >>> r = np.repeat([2.8, 1.5, 1.0], 200)
    >>> [round(level, 2) for level in ratio_levels(r)]
    [2.8, 1.5, 1.0]
    """
    good = np.log(ratio[np.isfinite(ratio) & (ratio > 0)])
    if len(good) < 50:
        return []
    edges = np.arange(good.min() - 0.02, good.max() + 0.04, 0.02)
    counts, _ = np.histogram(good, edges)
    wide = np.convolve(counts, np.ones(3), "same")
    order = np.argsort(wide)[::-1]
    levels: list[float] = []
    for index in order:
        if wide[index] < share * len(good):
            break
        middle = 0.5 * (edges[index] + edges[index + 1])
        near = good[np.abs(good - middle) < 0.03]
        if not len(near):
            continue
        middle = float(np.median(near))
        if all(abs(middle - level) > 0.12 for level in levels):
            # a gear stands out from the ratios that a shift passes through
            around = good[(np.abs(good - middle) < 0.12)]
            if np.mean(np.abs(around - middle) < 0.03) > 0.45:
                levels.append(middle)
    return [float(np.exp(level)) for level in sorted(levels, reverse=True)]


def with_derived_gear(road_test: RoadTest, ratios: Sequence[float] | None = None, tolerance: float = 0.06) -> RoadTest:
    """Return the road test with a gear derived from the speed ratio, marked ``derived``; unchanged where one is logged.

    Parameters
    ----------
    ratios
        Ratios of the gears from first on, in the scale of turbine (or engine) over output (or vehicle) speed. Without
        them the levels found in the log are numbered from the highest ratio as first gear.
    tolerance
        How far from a gear's ratio a sample may be [1]; between gears, and with a slipping converter, it is unknown.
    """
    if road_test.channel("gear") is not None:
        return road_test
    ratio = _ratio(road_test)
    if ratio is None:
        return road_test
    levels = list(ratios) if ratios else ratio_levels(ratio)
    if not levels:
        return road_test
    distance = np.abs(ratio[:, None] / np.array(levels)[None, :] - 1)
    nearest = np.argmin(np.where(np.isnan(distance), np.inf, distance), axis=1)
    close = distance[np.arange(len(ratio)), nearest] <= tolerance
    gear = np.where(close, nearest + 1.0, np.nan)
    how = "given ratios" if ratios else f"{len(levels)} ratios found in the log, the highest taken as first gear"
    channel = Channel(
        "gear",
        road_test.time,
        gear,
        np.zeros(len(gear), bool),
        column="",
        source="derived",
        independent=int(close.sum()),
    )
    note = Message("warning", "gear_derived", f"no gear is logged: it is derived from the speed ratio ({how})")
    return replace(
        road_test,
        channels=MappingProxyType({**road_test.channels, "gear": channel}),
        messages=(*road_test.messages, note),
        _held={},
    )
