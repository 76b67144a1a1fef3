"""Detect shifts between gears, and derive a gear from the speed ratio where none is logged."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from atleak.common.errors import Message
from atleak.common.sentences import Sentence
from atleak.measurements.events.event import USUAL, Event, Thresholds, gear_engaged, segments
from atleak.measurements.road_test import Channel, ChannelSource, RoadTest


def gear_shifts(road_test: RoadTest, limits: Thresholds = USUAL) -> list[Event]:
    """Return shifts between forward gears.

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


_APART, _NEAR = 0.12, 0.03  # of the logarithm: between two levels, and around one
_FEWEST = 0.02  # part of a log's samples that are near a level


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
        if wide[index] < _FEWEST * len(logarithms):
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
