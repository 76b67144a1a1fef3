"""Detect the events of a log that is larger than memory: those that `atleak.events.events` finds in the whole.

A run that lasts from one piece into the next is carried over; what looks at the samples around it gets some rows more.
An acceleration is looked at from its beginning to the next rest, `LONGEST` samples of it at most.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from atleak.columns import median_of, percentiles_of, positive, spans, steps_of
from atleak.events.acceleration import (
    ByEngineSpeed,
    as_test,
    finder_of,
    idling,
    seconds_driven,
    shows_shifts,
    smoothed,
)
from atleak.events.driving import hot_idling_samples, locked_samples, stalling_samples, steady_count, steady_samples
from atleak.events.event import Event, EventKind, Thresholds, gear_engaged
from atleak.events.gears import (
    RATIO_AFTER,
    RATIO_BEFORE,
    by_ratio,
    in_gear,
    levels_among,
    logarithms_of,
    shifts_among,
    speed_ratio,
    with_derived_gear,
)
from atleak.events.slip import FEWEST, ConverterSlip, slip_and_driving
from atleak.large_log import LargeLog
from atleak.road_test import ChannelSource, RoadTest
from atleak.sentence import Sentence

LONGEST = 2_000_000
"""Samples of one acceleration that are looked at: more than five hours without a rest at 100 Hz."""
_OF_TESTS = ("engine_speed", "vehicle_speed", "gear")
_AROUND = 2  # samples on either side that smooth an engine speed


def events_in_pieces(
    log: LargeLog, thresholds: Thresholds | None = None, gears: Sequence[int] = ()
) -> tuple[Event, ...]:
    """Return all events of a log, as `atleak.events.events` does."""
    limits = thresholds or Thresholds()
    found = _Looked(log, limits)
    all_events = [
        *found.shifts.events,
        *found.lasting(),
        *_tests(log, found.rests, limits, gears),
        *_starts(log, found.stands, limits),
    ]
    return tuple(sorted(all_events, key=lambda event: (event.start, event.kind)))


@dataclass
class Runs:
    """The runs of True in a mask that comes in pieces, as `atleak.events.event.runs` yields them."""

    shortest: float = 0.0  # [s]
    found: list[tuple[int, int]] = field(default_factory=list)  # first and last row
    times: list[tuple[float, float]] = field(default_factory=list)  # of them [s]
    _open: tuple[int, float] | None = None  # row and time with which the one begins that has not ended
    _last: tuple[int, float] = (-1, 0.0)  # row and time of the sample before

    def add(self, start: int, mask: np.ndarray, time: np.ndarray, begins: np.ndarray) -> None:
        """Add the next rows, from number ``start`` on; ``begins`` says which are the first of their stretch."""
        if not len(mask):
            return
        before = np.concatenate([[self._open is not None], mask[:-1]])
        firsts, ends = np.flatnonzero(mask & (~before | begins)), np.flatnonzero(before & (~mask | begins))
        opened = [] if self._open is None else [self._open]
        opened += zip((start + firsts).tolist(), time[firsts].tolist(), strict=True)
        for first, end in zip(opened, ends.tolist(), strict=False):
            self._keep(first, (start + end - 1, float(time[end - 1])) if end else self._last)
        self._open = opened[len(ends)] if len(opened) > len(ends) else None
        self._last = start + len(mask) - 1, float(time[-1])

    def close(self) -> None:
        """End with the log."""
        if self._open is not None:
            self._keep(self._open, self._last)
            self._open = None

    def _keep(self, first: tuple[int, float], last: tuple[int, float]) -> None:
        if last[1] - first[1] >= self.shortest:
            self.found.append((first[0], last[0]))
            self.times.append((first[1], last[1]))


class _Looked:
    """What one look through a log finds of its events."""

    def __init__(self, log: LargeLog, limits: Thresholds) -> None:
        self.limits, self.note = limits, Sentence("")
        self.hot_idle, self.stall = Runs(limits.idle_seconds), Runs(limits.stall_seconds)
        self.lock_up, self.steady = Runs(limits.lock_up_seconds), Runs(limits.steady_seconds)
        self.stands, self.rests = Runs(), Runs()  # of the engine; from which an acceleration may begin
        self.shifts = _Shifts(log, limits)
        commanded, steady, rests = largest_command(log), _Steady(log, limits), _Rests(log, limits)
        for start, stop in log.spans():
            part, begins = log.part(start, stop), log.begin_mask(start, stop)
            engine, locked = part.values("engine_speed"), locked_samples(part, limits, commanded)
            if locked is not None:
                self.note = locked[1]
            masks = (
                (self.hot_idle, hot_idling_samples(part, limits)),
                (self.stall, stalling_samples(part, limits)),
                (self.lock_up, None if locked is None else locked[0]),
                (self.steady, steady.samples(start, stop)),
                (self.stands, None if engine is None else engine < limits.engine_standing),
                (self.rests, rests.samples(part, start, stop)),
            )
            for runs, mask in masks:
                if mask is not None:
                    runs.add(start, mask, part.time, begins)
            self.shifts.add(part, start)
        for runs in (self.hot_idle, self.stall, self.lock_up, self.steady, self.stands, self.rests):
            runs.close()

    def lasting(self) -> Iterator[Event]:
        """Yield the events that last as long as their samples do."""
        kinds: tuple[tuple[EventKind, Runs], ...] = (
            ("hot_idle", self.hot_idle), ("stall", self.stall), ("lock_up", self.lock_up),
            ("steady_driving", self.steady),
        )  # fmt: skip
        for kind, runs in kinds:
            for start, stop in runs.times:
                if kind != "stall" or stop - start <= self.limits.stall_longest:
                    yield Event(kind, start, stop, note=self.note if kind == "lock_up" else Sentence(""))


def largest_command(log: LargeLog) -> float:
    """Return the largest value of the command to lock up; NaN where there is none."""
    most = float("nan")
    if log.head.channel("lock_up") is not None:
        for start, stop in log.spans():
            most = float(np.fmax.reduce(np.asarray(log.values("lock_up", start, stop)), initial=most))
    return most


# --- what depends on the usual step of a stretch


def _medians(log: LargeLog, *, forwards: bool) -> list[float]:
    """Return the median step of every stretch [s], of those forwards or of all; NaN where it has none."""
    medians: list[float] = []
    while len(medians) < len(log.begins):
        number = len(medians)
        low = int(log.begins[number])
        last = int(np.searchsorted(log.stops, low + log.piece, side="right"))  # behind those that are held together
        if last <= number:
            steps = steps_of(log.time, low, int(log.stops[number]), log.piece)
            medians.append(median_of(positive(steps) if forwards else steps))
            continue
        time = log.time[low : int(log.stops[last - 1])]
        for each in range(number, last):
            there = np.diff(time[log.begins[each] - low : log.stops[each] - low])
            there = there[there > 0] if forwards else there
            medians.append(float(np.median(there)) if len(there) else math.nan)
    return medians


class _Steady:
    """Finds the samples of steady driving."""

    def __init__(self, log: LargeLog, limits: Thresholds) -> None:
        self.log, self.limits = log, limits
        self.shown = None not in (log.head.channel("engine_speed"), log.head.channel("vehicle_speed"))
        steps = _medians(log, forwards=True) if self.shown else []
        self.counts = [steady_count(step, limits) for step in steps]

    def samples(self, start: int, stop: int) -> np.ndarray | None:
        """Return which rows belong to steady driving; None where the log does not show it."""
        if not self.shown:
            return None
        mask = np.zeros(stop - start, bool)
        for number, begin, end in self.log.stretches(start, stop):
            if (count := self.counts[number]) <= end - begin:
                more = int(count) - 1
                low, high = max(begin, start - more), min(end, stop + more)
                engine, vehicle = (self.log.values(name, low, high) for name in ("engine_speed", "vehicle_speed"))
                steady = steady_samples(np.asarray(engine), np.asarray(vehicle), count, self.limits)
                first, last = max(begin, start), min(end, stop)
                mask[first - start : last - start] = steady[first - low : last - low]
        return mask


class _Rests:
    """Finds the samples at rest, from which an acceleration may begin."""

    def __init__(self, log: LargeLog, limits: Thresholds) -> None:
        self.log, self.limits = log, limits
        self.shows: list[bool] = []
        if isinstance(finder_of(log.head, limits), ByEngineSpeed):
            lengths = (log.stops - log.begins).tolist()
            steps = zip(lengths, _medians(log, forwards=False), strict=True)
            self.shows = [shows_shifts(length, step, limits) for length, step in steps]

    def samples(self, part: RoadTest, start: int, stop: int) -> np.ndarray | None:
        """Return which rows are at rest, ``part`` being these rows; None where the log does not show it."""
        finder = finder_of(part, self.limits)
        if finder is None:
            return None
        if not isinstance(finder, ByEngineSpeed):
            return finder.resting(slice(0, stop - start))
        smooth = np.full(stop - start, np.nan)
        for number, begin, end in self.log.stretches(start, stop):
            if self.shows[number]:
                first, last = max(begin, start), min(end, stop)
                smooth[first - start : last - start] = _smoothed(self.log, begin, end, first, last)
        return idling(smooth, self.limits)


def _smoothed(log: LargeLog, begin: int, end: int, first: int, last: int) -> np.ndarray:
    """Return the smoothed engine speed of some rows of a stretch."""
    low, high = max(begin, first - _AROUND), min(end, last + _AROUND)
    return smoothed(np.asarray(log.values("engine_speed", low, high)))[first - low : last - low]


# --- shifts


class _Shifts:
    """Finds the shifts between forward gears, as `atleak.events.gears.gear_shifts` does."""

    def __init__(self, log: LargeLog, limits: Thresholds) -> None:
        self.log, self.limits = log, limits
        self.events: list[Event] = []
        channel = log.head.channel("gear")
        self.source: ChannelSource = channel.source if channel else "derived"
        self.ratio = speed_ratio(log.head, ("turbine_speed",)) is not None
        self.levels: list[float] = []
        if channel is None and self.ratio:
            self.levels = levels_among(self._logarithms)
        self._last: tuple[int, float, float] | None = None  # row, time and gear of the latest sample in gear

    def _logarithms(self) -> Iterator[np.ndarray]:
        for start, stop in self.log.spans():
            ratio = speed_ratio(self.log.part(start, stop))
            if ratio is not None:
                yield logarithms_of(ratio)

    def add(self, part: RoadTest, start: int) -> None:
        """Find the shifts in some rows, and that from those before."""
        if self.levels:
            part = with_derived_gear(part, self.levels)
        if part.channel("gear") is None:
            return
        gear = np.asarray(gear_engaged(part))
        here = in_gear(gear)
        if not len(here):
            return
        rows, times, gears = start + here, part.time[here], gear[here]
        if self._last is not None:
            last = zip(self._last, (rows, times, gears), strict=True)
            rows, times, gears = (np.concatenate([[before], these]) for before, these in last)
        stretch = np.searchsorted(self.log.begins, rows, side="right")
        for step in shifts_among(rows, times, gears, self.limits):
            if stretch[step] != stretch[step + 1]:
                continue
            before, after = float(times[step]), float(times[step + 1])
            event = Event("gear_shift", before, after, int(gears[step]), int(gears[step + 1]), self.source)
            self.events.append(self._by_ratio(event, int(rows[step + 1])) if self.ratio else event)
        self._last = int(rows[-1]), float(times[-1]), float(gears[-1])

    def _by_ratio(self, event: Event, row: int) -> Event:
        if event.source != "logged":
            return event
        low, high = self.log.back(row, RATIO_BEFORE), self.log.onward(row, RATIO_AFTER)
        low = max(low - 1, self.log.begin_of(row))
        part = self.log.part(low, high)
        ratio = speed_ratio(part, ("turbine_speed",))
        return event if ratio is None else by_ratio(event, part.time, ratio, row - low, self.limits)


# --- minimum-acceleration tests


def _tests(log: LargeLog, rests: Runs, limits: Thresholds, gears: Sequence[int]) -> Iterator[Event]:
    """Yield the minimum-acceleration tests, as `atleak.events.acceleration.minimum_acceleration` finds them."""
    top = max(gears, default=0)
    found: dict[int, list[tuple[float, Event | None, Event | None]]] = {}  # by stretch: duration, test if alone or not
    for place, (first, last) in enumerate(rests.found):
        begin, end = log.begin_of(last), log.stop_of(last)
        following = rests.found[place + 1][0] if place + 1 < len(rests.found) else end
        stop = min(end, following)
        if last + 1 < stop:
            climb = _climb(log, (begin, end), (first, last), stop, limits, top)
            if climb is not None:
                found.setdefault(begin, []).append(climb)
    for begin, climbs in found.items():
        for duration, alone, beside in climbs:
            test = alone if len(climbs) == 1 and duration >= 0.5 * _driven(log, begin, limits) else beside
            if test is not None:
                yield test


def _climb(
    log: LargeLog, stretch: tuple[int, int], rest: tuple[int, int], stop: int, limits: Thresholds, top: int
) -> tuple[float, Event | None, Event | None] | None:
    """Return how long an acceleration takes [s], and the tests that it is, alone and beside others.

    None where none begins behind this rest, or none that was meant as a test.
    """
    first, last = rest
    by_vehicle = log.head.channel("vehicle_speed") is not None
    low = last if by_vehicle else max(first, last + 1 - LONGEST)
    high = min(stop, last + 1 + LONGEST)
    part = log.part(low, high, _OF_TESTS)
    finder = finder_of(part, limits)
    if finder is None:
        return None
    whole = slice(0, high - low)
    climbs = (
        finder.climbs_in(whole, _smoothed(log, *stretch, low, high))
        if isinstance(finder, ByEngineSpeed)
        else finder.climbs(whole)
    )
    climb = next((each for each in climbs if each.begun), None)
    if climb is None:
        return None
    alone, beside = (as_test(part.time, climb, finder, limits, top, alone=each) for each in (True, False))
    return float(part.time[climb.last] - part.time[climb.first]), alone, beside


def _driven(log: LargeLog, begin: int, limits: Thresholds) -> float:
    """Return for how long the engine of a stretch does not idle [s]."""
    end, parts = log.stop_of(begin), []
    for low, high in spans(end - begin, log.piece):
        time = log.time[begin + low : min(begin + high + 1, end)]
        engine = np.asarray(log.values("engine_speed", begin + low, begin + high))
        parts.append(seconds_driven(np.diff(time, append=time[-1])[: high - low], engine, limits))
    return math.fsum(parts)


# --- starts of the engine


def _starts(log: LargeLog, stands: Runs, limits: Thresholds) -> Iterator[Event]:
    """Yield the first moments after each start, as `atleak.events.driving.engine_starts` finds them."""
    begins = set(log.begins[np.isin(log.begins, [low for low, _ in stands.found])].tolist())
    for place, (low, high) in enumerate(stands.found):
        first = high + 1
        following = stands.found[place + 1][0] if place + 1 < len(stands.found) else len(log)
        end = min(log.stop_of(high), following)
        if first >= end:
            continue
        begin = float(log.time[first])
        if not (low in begins or begin - stands.times[place][0] >= limits.engine_standing_seconds):
            continue
        running, last = _runs_from(log, first, end, limits), float(log.time[end - 1])
        if running is not None:
            last = min(last, float(log.time[running]) + limits.start_seconds)
        yield Event("engine_start", begin, last)


def _runs_from(log: LargeLog, first: int, end: int, limits: Thresholds) -> int | None:
    """Return the first of some rows at which the engine runs by itself; None where it does not."""
    for low, high in spans(end - first, log.piece):
        running = np.flatnonzero(np.asarray(log.values("engine_speed", first + low, first + high)) >= limits.idle_low)
        if len(running):
            return first + low + int(running[0])
    return None


# --- slip of the converter


def slip_in_pieces(
    log: LargeLog, events: Sequence[Event], thresholds: Thresholds | None = None
) -> ConverterSlip | None:
    """Return the slip of the converter, as `atleak.events.converter_slip` does; ``events`` are those of the log."""
    limits = thresholds or Thresholds()
    if slip_and_driving(log.head, limits) is None:
        return None

    def parts() -> Iterator[tuple[int, RoadTest, np.ndarray, np.ndarray]]:
        for start, stop in log.spans():
            part = log.part(start, stop)
            shown = slip_and_driving(part, limits)
            if shown is not None:
                yield start, part, *shown

    if sum(int(np.count_nonzero(driving)) for *_, driving in parts()) < FEWEST:
        return None
    low, median, high = percentiles_of(lambda: (slip[driving] for *_, slip, driving in parts()), (5, 50, 95))
    locked, most = sum(event.duration for event in events if event.kind == "lock_up"), largest_command(log)
    if not most > 0:
        return ConverterSlip(low, median, high, locked, None, None)
    wanted = Runs(limits.lock_up_seconds)
    for start, part, _, driving in parts():
        begins = log.begin_mask(start, start + len(driving))
        wanted.add(start, driving & (np.asarray(part.values("lock_up")) >= 0.5 * most), part.time, begins)
    wanted.close()

    def then() -> Iterator[np.ndarray]:
        for first, last in wanted.found:
            for low_row, high_row in spans(last + 1 - first, log.piece):
                shown = slip_and_driving(log.part(first + low_row, first + high_row), limits)
                if shown is not None:
                    yield np.abs(shown[0])

    seconds = sum(stop - start for start, stop in wanted.times)
    return ConverterSlip(low, median, high, locked, seconds, median_of(then) if wanted.found else None)
