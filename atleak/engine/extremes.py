"""Find the instants of a log that are worth knowing: the largest and the smallest leakage, the largest share.

A single sample may be noise, and pressure rises and falls within a shift. The sustained extremes are those of a running
median over half a second, which people read first; a value counts as large as it stays for a second on end. Where
several samples are equal but for rounding, the first is the instant.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from importlib.util import find_spec

import numpy as np
import pandas as pd

from atleak.common.memory import kept_with
from atleak.measurements.events import Thresholds, engine_starts, gear_shifts
from atleak.measurements.events.event import segments, within_span
from atleak.measurements.road_test import RoadTest, Segment

SUSTAINED_SECONDS = 0.5  # of the running median: choice of this project
SUSTAINED_SAMPLES = 5  # that it takes at least: choice of this project
_ROUNDING = 1e-12  # relative: values that differ by less are equal but for rounding
_LONG = 100_000  # samples of a log for which scipy's median is worth its import
_LIVELY = ("main_pressure", "converter_pressure", "engine_speed")  # channels whose noise the median is to take out


@dataclass(frozen=True)
class Instant:
    """One instant of a log that is worth knowing: a sample, or the medians of the samples around it."""

    time: float  # [s]
    leakage: float  # [m³/s]
    pump_capacity: float | None  # [m³/s], None where no engine speed was logged
    share: float | None  # leakage / pump capacity; None where the pump delivers nothing
    sample: int  # of the log: the instant itself or, of a median, the sample that comes nearest to it


def share_of_samples(leakage: np.ndarray, capacity: np.ndarray) -> np.ndarray:
    """Return leakage / pump capacity; NaN where the pump delivers nothing."""
    return leakage / np.where(capacity > 0.0, capacity, np.nan)


def first_largest(values: np.ndarray) -> int:
    """Return the first place of the largest value, or of one that equals it but for rounding; NaN is left out.

    >>> first_largest(np.array([1.0, 2.0, np.nan, 2.0000000000000004]))
    1
    """
    most = float(values[np.nanargmax(values)])
    return int(np.argmax(values >= most - _ROUNDING * abs(most)))


@dataclass(frozen=True, eq=False)
class Extremes:
    """The extremes of the leakage over a log, or over some of its samples, each worked out when it is asked for.

    Arrays have shape (samples,). ``leakage`` is NaN where a sample does not count and finite in one at least.
    """

    time: np.ndarray  # [s]
    leakage: np.ndarray  # [m³/s]
    pump_capacity: np.ndarray | None  # [m³/s]
    segments: Sequence[Segment]  # stretches of the log without a gap
    window: float  # [s] of the running median

    @cached_property
    def max_leakage(self) -> Instant:
        """Return the sample with the largest leakage."""
        return self._at(first_largest(self.leakage))

    @cached_property
    def min_leakage(self) -> Instant:
        """Return the sample with the smallest leakage."""
        return self._at(first_largest(-self.leakage))

    @cached_property
    def max_share(self) -> Instant | None:
        """Return the sample with the largest share; None where no sample has one."""
        share = self._share
        return None if share is None or not np.isfinite(share).any() else self._at(first_largest(share))

    @cached_property
    def max_leakage_sustained(self) -> Instant | None:
        """Return the largest running median of the leakage; None where no window holds enough samples."""
        return self._sustained(self.leakage)

    @cached_property
    def max_share_sustained(self) -> Instant | None:
        """Return the largest running median of the share; None where no window holds enough samples with one."""
        return None if self._share is None else self._sustained(self._share)

    @property
    def instants(self) -> tuple[Instant, ...]:
        """Return every extreme there is."""
        every = (
            self.max_leakage, self.min_leakage, self.max_share, self.max_leakage_sustained, self.max_share_sustained,
        )  # fmt: skip
        return tuple(instant for instant in every if instant is not None)

    @property
    def samples(self) -> int:
        """Return how many samples count."""
        return int(np.count_nonzero(np.isfinite(self.leakage)))

    @cached_property
    def _share(self) -> np.ndarray | None:
        return None if self.pump_capacity is None else share_of_samples(self.leakage, self.pump_capacity)

    def _at(self, sample: int) -> Instant:
        flow = float(self.leakage[sample])
        capacity = None if self.pump_capacity is None else _known(float(self.pump_capacity[sample]))
        share = flow / capacity if capacity else None
        return Instant(float(self.time[sample]), flow, capacity, share, sample)

    def _sustained(self, values: np.ndarray) -> Instant | None:
        if not np.isfinite(values).any():
            return None
        clock = clock_at(self.time, self.segments, self.window)
        medians = running_median(values, clock, self.window)
        if not np.isfinite(medians).any():
            return None
        middle = first_largest(medians)
        near = np.flatnonzero(np.abs(clock - clock[middle]) <= 0.5 * self.window * (1.0 + 1e-9))
        near = near[np.isfinite(values[near])]
        capacity = None if self.pump_capacity is None else self.pump_capacity[near]
        share = None if capacity is None else share_of_samples(self.leakage[near], capacity)
        away = np.abs(values[near] - medians[middle])  # of an even number of samples two are as near
        nearest = int(np.argmax(away <= away.min() + _ROUNDING * abs(medians[middle])))
        return Instant(
            time=float(self.time[middle]),
            leakage=float(np.median(self.leakage[near])),
            pump_capacity=None if capacity is None else _median(capacity),
            share=None if share is None else _median(share),
            sample=int(near[nearest]),
        )


def sustained_window(road_test: RoadTest) -> float:
    """Return the length of the running median for a log [s].

    Half a second or, where a pressure or the engine speed is sampled more slowly than ten times a second, five of its
    intervals: otherwise a single answer that the logger holds would fill the window.
    """
    intervals = [SUSTAINED_SECONDS / SUSTAINED_SAMPLES]
    for channel in (road_test.channel(name) for name in _LIVELY):
        if channel is None or channel.source == "constant":
            continue
        steps = np.diff(channel.time)
        interval = _median(steps[steps > 0.0]) if len(steps) else None
        if channel.sampling_hz > 0.0:
            interval = 1.0 / channel.sampling_hz
        intervals.append(interval or 0.0)
    return SUSTAINED_SAMPLES * max(intervals)


def running_median(values: np.ndarray, clock: np.ndarray, window: float) -> np.ndarray:
    """Compute the median of the values around each stamp of a clock.

    Parameters
    ----------
    values
        shape (samples,); NaN is left out.
    clock
        stamps [s], ascending.
    window
        length [s]; half of it lies before a stamp, half behind, both ends included.

    Returns
    -------
    np.ndarray
        NaN where fewer than `SUSTAINED_SAMPLES` values lie in the window.
    """
    ticks, length = np.round(clock * 1e9).astype(np.int64), round(window * 1e9)
    if len(values) < _LONG or find_spec("scipy") is None:
        return _rolling_median(values, ticks, length)
    from scipy.ndimage import median_filter  # six times as fast, but dear to import

    reach, even = _even_windows(np.isfinite(values), ticks, length // 2)
    if not even.any():
        return _rolling_median(values, ticks, length)
    medians: np.ndarray = median_filter(np.where(np.isfinite(values), values, 0.0), 2 * reach + 1)
    rest = np.flatnonzero(~even)
    edges = np.zeros(len(values) + 1, int)
    np.add.at(edges, np.searchsorted(ticks, ticks[rest] - length // 2, "left"), 1)
    np.add.at(edges, np.searchsorted(ticks, ticks[rest] + length // 2, "right"), -1)
    near = np.cumsum(edges[:-1]) > 0  # all that the windows of the rest hold
    medians[rest] = _rolling_median(values[near], ticks[near], length)[~even[near]]
    return medians


def _rolling_median(values: np.ndarray, ticks: np.ndarray, window: int) -> np.ndarray:
    index = pd.TimedeltaIndex(ticks.astype("timedelta64[ns]"))
    rolling = pd.Series(values, index, copy=False).rolling(
        pd.Timedelta(window, "ns"), min_periods=SUSTAINED_SAMPLES, center=True, closed="both"
    )
    return rolling.median().to_numpy()


def _even_windows(known: np.ndarray, ticks: np.ndarray, half: int) -> tuple[int, np.ndarray]:
    """Return how far the window in the middle reaches to each side, in samples, and which windows are like it.

    Those hold as many samples on each side, all of them known.
    """
    size, middle = len(ticks), len(ticks) // 2
    reach = int(np.searchsorted(ticks, ticks[middle] + half, "right")) - 1 - middle
    even = np.zeros(size, bool)
    if 2 * reach + 1 < SUSTAINED_SAMPLES or size < 4 * reach + 4:
        return reach, even
    within, beyond = ticks[reach:] - ticks[:-reach] <= half, ticks[reach + 1 :] - ticks[: -reach - 1] > half
    start, stop = reach + 1, size - reach - 1
    on_both = within[start:stop] & within[1 : stop - reach] & beyond[start:stop] & beyond[: stop - start]
    unknown = np.cumsum(~known)
    even[start:stop] = on_both & (unknown[start + reach : stop + reach] == unknown[: stop - start])
    return reach, even


def clock_at(time: np.ndarray, segments: Sequence[Segment], window: float) -> np.ndarray:
    """Return the stamps from zero on, with the segments so far apart that no window reaches from one into the next."""
    breaks = np.zeros(len(time))
    breaks[[segment.start_row for segment in segments]] = 1.0
    return time - time[0] + 2.0 * window * np.cumsum(breaks)


def _median(values: np.ndarray) -> float | None:
    return _known(float(np.nanmedian(values))) if np.isfinite(values).any() else None


def _known(value: float) -> float | None:
    return value if np.isfinite(value) else None


LASTING = 1.0  # [s] that a value must last, and under which a shift does not count: choice of this project
_ENOUGH = LASTING * (1.0 - 1e-9)
_NEVER = -1e300  # stands for an unknown value, below all others: pandas' windows leave out what is not finite
_APART = 10.0 * LASTING  # [s] between two segments on the clock that counts: more than any window


class CountedSamples:
    """The samples of a log that count: not those of a standstill or start of the engine, nor of short shifts.

    What does not count is cut out of the clock: it neither lasts nor parts what lies before from what lies behind.
    """

    def __init__(self, road_test: RoadTest) -> None:
        self.time = road_test.time
        shifts = (event for event in gear_shifts(road_test) if event.duration < LASTING)
        cut_out = (*engine_starts(road_test), *shifts)
        engine, out = road_test.values("engine_speed"), within_span(self.time, cut_out)
        if engine is not None:
            out |= engine < Thresholds.idle_low
        part, steps = np.zeros(len(self.time), int), np.zeros(len(self.time))
        for number, each in enumerate(segments(road_test)):
            part[each] = number
            steps[each.start : max(each.stop - 1, each.start)] = np.diff(self.time[each])
        self.samples = np.flatnonzero(~out)
        self.part = part[self.samples]  # number of the segment of each that counts
        # [s] to the next sample of the same segment; 0 of one that does not count
        self.steps = np.where(out, 0.0, steps)
        elapsed = np.cumsum(self.steps) - self.steps
        self.clock = elapsed[self.samples] + _APART * self.part  # [s] of those that count

    @cached_property
    def seconds(self) -> tuple[np.ndarray, np.ndarray]:
        """Return with which of them the second up to each begins, and whether that is whole within its segment."""
        starts = np.flatnonzero(np.append(True, self.part[1:] != self.part[:-1])[: len(self.part)])
        begins = np.repeat(starts, np.diff(np.append(starts, len(self.part))))
        since = np.searchsorted(self.clock, self.clock - _ENOUGH, side="right") - 1
        return np.maximum(since, begins), since >= begins

    def time_of(self, mask: np.ndarray) -> float:
        """Return how long some of the log's samples take [s], each until the next one of its segment."""
        return float(np.sum(self.steps[mask]))


def smoothed(road_test: RoadTest, name: str) -> np.ndarray:
    """Return a channel's median of half a second where there are samples enough for one; what is unknown stays so."""

    def smooth() -> np.ndarray:
        values = np.asarray(road_test.values(name))
        clock = clock_at(road_test.time, road_test.segments, SUSTAINED_SECONDS)
        medians = running_median(values, clock, SUSTAINED_SECONDS)
        return np.where(np.isnan(values) | np.isnan(medians), values, medians)

    return kept_with(road_test, "smoothed", name, smooth, most=2)


class Lasting:
    """Values of a log, outside where they are positive, and what of them lasts.

    Parameters
    ----------
    counted
        the samples that count.
    values
        shape (samples of the log,); NaN ends a stretch.
    """

    def __init__(self, counted: CountedSamples, values: np.ndarray) -> None:
        self.excess, self._counted = values, counted
        samples, clock, part = counted.samples, counted.clock, counted.part
        known = np.where(np.isnan(values), _NEVER, values)[samples]
        self._since, whole = counted.seconds
        self._least = np.where(whole, least_since(known, self._since), _NEVER)  # of the second up to each sample
        over = known > 0.0
        edges = np.flatnonzero(np.append(over[:1] | True, (over[1:] != over[:-1]) | (part[1:] != part[:-1])))
        stops = np.append(edges[1:], len(samples))[: len(edges)] - 1
        kept = over[edges] & (clock[stops] - clock[edges] >= _ENOUGH)
        self._starts, self._stops = edges[kept], stops[kept]
        self.outside = np.zeros(len(values), bool)  # in a stretch outside that lasts
        for start, stop in zip(self._starts, self._stops, strict=True):
            self.outside[samples[start : stop + 1]] = True

    def worst(self, among: np.ndarray) -> int | None:
        """Return the sample at which the worst second is least bad; None where none of these samples ends one."""
        least = np.where(among[self._counted.samples], self._least, _NEVER)
        if not np.max(least, initial=_NEVER) > _NEVER:
            return None
        end = int(np.argmax(least))
        window = self._counted.samples[self._since[end] : end + 1]
        window = window[among[window]]
        return int(window[np.argmin(self.excess[window])])

    def stretch(self, sample: int) -> tuple[float, float]:
        """Return begin and end [s] of the stretch outside that a sample lies in; the sample's own where in none."""
        time, samples = self._counted.time, self._counted.samples
        place = int(np.searchsorted(samples, sample))
        number = int(np.searchsorted(self._starts, place, side="right")) - 1
        if number < 0 or place > self._stops[number]:
            return float(time[sample]), float(time[sample])
        return float(time[samples[self._starts[number]]]), float(time[samples[self._stops[number]]])


def least_since(values: np.ndarray, begins: np.ndarray) -> np.ndarray:
    """Return the least of the values from a given place up to each one.

    >>> least_since(np.array([3.0, 1.0, 2.0, 4.0]), np.array([0, 0, 2, 1]))
    array([3., 1., 2., 1.])
    """
    lengths = np.arange(1, len(values) + 1) - begins
    widest = 1 << int(np.max(lengths, initial=1)).bit_length() - 1
    shorter = np.flatnonzero(lengths < widest)  # a few, as a rule
    of_shorter, of_width, width = values[shorter], values.copy(), 1  # the least of the last ``width`` values, at each
    while width < widest:
        fits = lengths[shorter] // width == 1  # two of this width cover their windows
        here = shorter[fits]
        of_shorter[fits] = np.minimum(of_width[here], of_width[begins[here] + width - 1])
        np.minimum(of_width[width:], of_width[:-width].copy(), out=of_width[width:])
        width *= 2
    least = np.minimum(of_width, of_width[np.minimum(begins + (widest - 1), len(values) - 1)])
    least[shorter] = of_shorter
    return least
