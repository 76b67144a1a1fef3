"""Find the instants of a log that are worth knowing: the largest and the smallest leakage, the largest share.

A single sample may be noise. The sustained extremes are those of a running median over half a second, which one wrong
sample cannot move: people read these first. Where several samples are equal but for rounding, the first is the instant.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pandas as pd

from atleak.road_test import RoadTest, Segment

SUSTAINED_SECONDS = 0.5  # of the running median: choice of this project
SUSTAINED_SAMPLES = 5  # that it takes at least: choice of this project
ROUNDING = 1e-12  # relative: values that differ by less are equal but for rounding
_LIVELY = ("main_pressure", "converter_pressure", "engine_speed")  # channels whose noise the median is to take out


@dataclass(frozen=True)
class Instant:
    """One instant of a log that is worth knowing: a sample, or the medians of the samples around it."""

    time: float  # [s]
    leakage: float  # [m³/s]
    pump_capacity: float | None  # [m³/s], None where no engine speed was logged
    share: float | None
    sample: int  # of the log: the instant itself or, of a median, the sample that comes nearest to it


def share_of(leakage: np.ndarray, capacity: np.ndarray) -> np.ndarray:
    """Return leakage / pump capacity; NaN where the pump delivers nothing."""
    return leakage / np.where(capacity > 0.0, capacity, np.nan)


def first_largest(values: np.ndarray) -> int:
    """Return the first place of the largest value, or of one that equals it but for rounding; NaN is left out.

    >>> first_largest(np.array([1.0, 2.0, np.nan, 2.0000000000000004]))
    1
    """
    most = float(values[np.nanargmax(values)])
    return int(np.argmax(values >= most - ROUNDING * abs(most)))


@dataclass(frozen=True, eq=False)
class Extremes:
    """The extremes of the leakage over a log, or over some of its samples, each worked out when it is asked for.

    Arrays have shape (samples,). ``leakage`` is NaN where a sample does not count and finite in one at least.
    """

    time: np.ndarray  # [s]
    leakage: np.ndarray  # [m³/s]
    pump_capacity: np.ndarray | None  # [m³/s]
    segments: Sequence[Segment]
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
        return None if self.pump_capacity is None else share_of(self.leakage, self.pump_capacity)

    def _at(self, sample: int) -> Instant:
        flow = float(self.leakage[sample])
        capacity = None if self.pump_capacity is None else _known(float(self.pump_capacity[sample]))
        share = flow / capacity if capacity else None
        return Instant(float(self.time[sample]), flow, capacity, share, sample)

    def _sustained(self, values: np.ndarray) -> Instant | None:
        if not np.isfinite(values).any():
            return None
        clock = clock_of(self.time, self.segments, self.window)
        medians = running_median(values, clock, self.window)
        if not np.isfinite(medians).any():
            return None
        middle = first_largest(medians)
        near = np.flatnonzero(np.abs(clock - clock[middle]) <= 0.5 * self.window * (1.0 + 1e-9))
        near = near[np.isfinite(values[near])]
        capacity = None if self.pump_capacity is None else self.pump_capacity[near]
        share = None if capacity is None else share_of(self.leakage[near], capacity)
        away = np.abs(values[near] - medians[middle])  # of an even number of samples two are as near
        nearest = int(np.argmax(away <= away.min() + ROUNDING * abs(medians[middle])))
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
    index = pd.TimedeltaIndex(np.round(clock * 1e9).astype("timedelta64[ns]"))
    rolling = pd.Series(values, index, copy=False).rolling(
        pd.Timedelta(round(window * 1e9), "ns"), min_periods=SUSTAINED_SAMPLES, center=True, closed="both"
    )
    return rolling.median().to_numpy()


def clock_of(time: np.ndarray, segments: Sequence[Segment], window: float) -> np.ndarray:
    """Return the stamps from zero on, with the segments so far apart that no window reaches from one into the next."""
    breaks = np.zeros(len(time))
    breaks[[segment.start_row for segment in segments]] = 1.0
    return time - time[0] + 2.0 * window * np.cumsum(breaks)


def _median(values: np.ndarray) -> float | None:
    return _known(float(np.nanmedian(values))) if np.isfinite(values).any() else None


def _known(value: float) -> float | None:
    return value if np.isfinite(value) else None
