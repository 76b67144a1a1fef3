"""Makes an ascending time base with segments of a log's clock; nothing is invented between stamps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from atleak.measurements.road_test import Segment


@dataclass(frozen=True)
class Timeline:
    """A log's time base.

    ``order`` picks the usable rows in ascending time (None: all rows as they stand); ``time`` are their stamps [s].
    """

    time: np.ndarray
    order: np.ndarray | None
    segments: tuple[Segment, ...]
    duration: float
    unreadable: int = 0
    stale: int = 0
    reordered: int = 0
    restarts: int = 0
    gaps: tuple[float, ...] = ()

    def in_order(self, values: np.ndarray) -> np.ndarray:
        """Return the numbers of all rows in the order of its stamps."""
        return values if self.order is None else values[self.order]

    def samples(self, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return of the numbers of all rows those that are some, and their stamps."""
        values = self.in_order(values)
        good = np.isfinite(values)
        return values[good], self.time[good]


def running(seconds: np.ndarray, period: float | None = None) -> np.ndarray:
    """Return stamps counted from the first one; NaN where unreadable.

    Of a clock that starts again after each ``period`` [s] a fall by more than half of it adds one.
    """
    good = np.flatnonzero(np.isfinite(seconds))
    if not len(good):
        return seconds
    values = seconds[good]
    if period is not None:
        steps = np.diff(values, prepend=values[0])
        turns = (steps < -period / 2).astype(int) - (steps > period / 2)
        # a single stamp that falls or rises so, and the one behind it goes back: neither begins a period
        before = np.append(0, turns[:-1])
        values = values + period * np.cumsum(np.where(turns * before < 0, np.minimum(turns, 0), np.maximum(turns, 0)))
    result = np.full(len(seconds), np.nan)
    result[good] = np.round(values - values[0], 9)
    return result


def gap_limit(steps: np.ndarray) -> float:
    """Return the step [s] from which on time has a gap, derived from the usual steps of the log.

    An evenly sampled log breaks at 3.5 usual steps, an irregular one (answers in turn) at 10 medians or 5 times the
    step that 19 of 20 stay under.
    """
    steps = steps[steps > 0]
    if not len(steps):
        return np.inf
    median, usual = float(np.median(steps)), float(np.percentile(steps, 95, method="lower"))
    if usual <= 1.5 * median:
        return max(0.5, 3.5 * usual)
    return max(1.0, 10 * median, 5 * usual)


_MANY = 100_000


def gap_limit_of(time: np.ndarray) -> float:
    """Return the limit by some 100 000 steps of a long log; by all where none of those goes on."""
    stride = max(1, (len(time) - 1) // _MANY)
    limit = gap_limit(time[1::stride] - time[0 : len(time) - 1 : stride])
    if limit < np.inf or stride == 1:
        return limit
    return gap_limit(np.diff(time))


def build(seconds: np.ndarray) -> Timeline:
    """Build time base and segments from stamps in file order.

    Unreadable stamps and a single stale or stray stamp, at either end too, are left out; stamps slightly out of order
    are sorted; a backward jump means that the clock was restarted: the later stretch is placed behind the earlier one.
    """
    if len(seconds) > 1 and np.diff(seconds).min() >= 0 and not an_end_is_far(seconds):  # no step is NaN
        return _finish(seconds, None)
    usable = np.flatnonzero(np.isfinite(seconds))
    unreadable = len(seconds) - len(usable)
    stray = strays_of(seconds[usable])
    usable, stale = usable[~stray], int(stray.sum())
    stamps = seconds[usable]
    steps = np.diff(stamps)
    if not (steps < 0).any():
        return _finish(stamps, usable, unreadable=unreadable, stale=stale)
    median = float(np.median(steps[steps > 0])) if (steps > 0).any() else 0.0
    breaks = restarts(stamps, np.flatnonzero(steps < 0), median)
    shifted, order, reordered = _in_order(stamps, breaks, median)
    time = np.maximum.accumulate(shifted[order])  # a stretch that was moved may begin a rounding error too early
    return _finish(time, usable[order], breaks, unreadable=unreadable, stale=stale, reordered=reordered)


def strays_of(stamps: np.ndarray) -> np.ndarray:
    """Return which stamps, in file order, are stray."""
    if len(stamps) < 4:
        return np.zeros(len(stamps), bool)
    steps = np.diff(stamps)
    onward = steps[steps > 0]
    median = float(np.median(onward)) if len(onward) else 0.0
    stray = strays_among(stamps, median)
    stray[0], stray[-1] = stray_ends(stamps[:4], stamps[-4:], median)
    return stray


def an_end_is_far(stamps: np.ndarray) -> bool:
    """Return whether the first or the last stamp is farther from its neighbour than all others are from each other."""
    if len(stamps) < 4:
        return False
    (first, second), (last_but_one, last) = stamps[:2], stamps[-2:]
    return bool(max(second - first, last - last_but_one) > last_but_one - second)


def stray_ends(head: np.ndarray, tail: np.ndarray, median: float) -> tuple[bool, bool]:
    """Return whether the first and the last stamp are stray, by the four at either end and the usual step.

    A first one is left over from an earlier recording where the second is earlier; either is stray that is farther from
    its neighbour than all others are from each other, and a last one to which the clock falls back.
    """
    head, tail = (each[~strays_among(each, median)] for each in (head, tail))
    far = max(float(tail[-2] - head[1]), 20 * median)
    left_over = len(head) > 2 and bool(head[1] <= head[2] < head[0])
    return left_over or bool(head[1] - head[0] > far), bool(not -10 * median <= tail[-1] - tail[-2] <= far)


def strays_among(stamps: np.ndarray, median: float) -> np.ndarray:
    """Return which stamps are off the line on which the one before and the one behind go on; neither end is."""
    stray, steps = np.zeros(len(stamps), bool), np.diff(stamps)
    onward = stamps[2:] - stamps[:-2]
    off = np.abs(steps[:-1]) > 20 * max(median, 1e-9)
    back = np.sign(steps[:-1]) == -np.sign(steps[1:])
    stray[1:-1] = off & back & (onward >= 0) & (onward <= 20 * max(median, 1e-9))
    return stray


def _in_order(stamps: np.ndarray, breaks: Sequence[int], median: float) -> tuple[np.ndarray, np.ndarray, int]:
    """Return the stamps, each stretch behind the one before, their order, and how many were out of turn."""
    shifted, order = stamps.astype(float), np.arange(len(stamps))
    reordered, end = 0, None
    for low, high in pairwise([0, *breaks, len(stamps)]):
        part = shifted[low:high]
        if (np.diff(part) < 0).any():
            ranks = np.argsort(part, kind="stable")
            reordered += int((np.diff(part) < 0).sum())
            order[low:high] = low + ranks
        if end is not None:
            part += end + median - part.min()
        end = float(part.max())
    return shifted, order, reordered


def restarts(stamps: np.ndarray, falls: np.ndarray, median: float) -> list[int]:
    """Return the places at which the clock begins anew, of those behind which it falls and does not go back at once."""
    starts, begin = [], 0
    for fall in falls.tolist():
        before, landing, *behind = stamps[fall : fall + 3]
        if behind and behind[0] >= before:
            continue
        if before - landing > 10 * median or landing <= stamps[begin] + 0.5 * median:
            begin = fall + 1
            starts.append(begin)
    return starts


def _finish(
    time: np.ndarray, order: np.ndarray | None, breaks: Sequence[int] = (), unreadable: int = 0, stale: int = 0,
    reordered: int = 0,
) -> Timeline:  # fmt: skip
    if not len(time):
        return Timeline(time, order, (), 0.0, unreadable, stale)
    limit = gap_limit_of(time)
    gaps: list[int] = (np.flatnonzero(np.diff(time) > limit) + 1).tolist()
    restarted = set(breaks)
    lengths = tuple(float(time[index] - time[index - 1]) for index in gaps if index not in restarted)
    edges = sorted({0, len(time), *gaps, *restarted})
    segments = tuple(
        Segment(low, high - low, float(time[low]), float(time[high - 1] - time[low])) for low, high in pairwise(edges)
    )
    lost = sum(float(time[index] - time[index - 1]) for index in breaks)
    duration = float(time[-1] - time[0]) - lost
    return Timeline(time, order, segments, duration, unreadable, stale, reordered, len(breaks), lengths)
