"""Makes an ascending time base with segments of a log's clock; nothing is invented between stamps."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from atleak.intake.road_test.blocks import ends_of_steps, steps_over
from atleak.road_test import Segment


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


def gap_limit(steps: np.ndarray) -> float:
    """Return the step [s] from which on time has a gap, derived from the usual steps of the log.

    An evenly sampled log breaks at 3.5 usual steps, an irregular one (answers in turn) at 10 medians or 5 times the
    step that 19 of 20 stay under.
    """
    steps = steps[steps > 0]
    if not len(steps):
        return np.inf
    median = float(np.median(steps))
    usual = float(np.percentile(steps, 95, method="lower"))
    if usual <= 1.5 * median:
        return max(0.5, 3.5 * usual)
    return max(1.0, 10 * median, 5 * usual)


_MANY = 100_000


def _gap_limit_of(time: np.ndarray) -> float:
    """Return the limit by some 100 000 steps of a long log; by all where none of those goes on."""
    before, after = time[:-1], time[1:]
    stride = max(1, len(before) // _MANY)
    limit = gap_limit(after[::stride] - before[::stride])
    return limit if limit < np.inf or stride == 1 else gap_limit(after - before)


def build(seconds: np.ndarray) -> Timeline:
    """Build time base and segments from stamps in file order.

    Unreadable stamps and a single stale or stray stamp are left out; stamps slightly out of order are sorted;
    a backward jump means that the clock was restarted: the later stretch is placed behind the earlier one.
    """
    ends = ends_of_steps(seconds)
    if ends is not None and ends[0] >= 0:
        return _finish(seconds, None, longest=ends[1])
    usable = np.flatnonzero(np.isfinite(seconds))
    unreadable = len(seconds) - len(usable)
    usable, stale = _without_strays(seconds, usable)
    stamps = seconds[usable]
    steps = np.diff(stamps)
    if not (steps < 0).any():
        return _finish(stamps, usable, unreadable=unreadable, stale=stale)
    median = float(np.median(steps[steps > 0])) if (steps > 0).any() else 0.0
    shifted, order, reordered, restarts = _in_order(stamps, steps, median)
    time = np.maximum.accumulate(shifted[order])  # a stretch that was moved may begin a rounding error too early
    return _finish(
        time, usable[order],
        unreadable=unreadable, stale=stale, reordered=reordered, restarts=restarts[0], breaks=restarts[1],
    )  # fmt: skip


def _without_strays(seconds: np.ndarray, usable: np.ndarray) -> tuple[np.ndarray, int]:
    stamps = seconds[usable]
    if len(stamps) < 4:
        return usable, 0
    steps = np.diff(stamps)
    positive = steps[steps > 0]
    median = float(np.median(positive)) if len(positive) else 0.0
    stray = np.zeros(len(stamps), bool)
    # first stamp left over from an earlier recording
    if steps[0] < 0 and steps[1] >= 0:
        stray[0] = True
    # one stamp off the line while its neighbours go on
    onward = stamps[2:] - stamps[:-2]
    off = np.abs(steps[:-1]) > 20 * max(median, 1e-9)
    back = np.sign(steps[:-1]) == -np.sign(steps[1:])
    stray[1:-1] |= off & back & (onward >= 0) & (onward <= 20 * max(median, 1e-9))
    return usable[~stray], int(stray.sum())


def _in_order(
    stamps: np.ndarray, steps: np.ndarray, median: float
) -> tuple[np.ndarray, np.ndarray, int, tuple[int, tuple[int, ...]]]:
    falls = np.flatnonzero(steps < 0)
    starts, begin = [], 0
    for fall in falls:
        landing = stamps[fall + 1]
        if -steps[fall] > 10 * median or landing <= stamps[begin] + 0.5 * median:
            begin = int(fall) + 1
            starts.append(begin)
    shifted = stamps.astype(float).copy()
    order = np.arange(len(stamps))
    reordered, end = 0, None
    edges = [0, *starts, len(stamps)]
    for low, high in pairwise(edges):
        part = shifted[low:high]
        if (np.diff(part) < 0).any():
            ranks = np.argsort(part, kind="stable")
            reordered += int((np.diff(part) < 0).sum())
            order[low:high] = low + ranks
        if end is not None:
            part += end + median - part.min()
        end = float(part.max())
    return shifted, order, reordered, (len(starts), tuple(starts))


def _finish(
    time: np.ndarray,
    order: np.ndarray | None,
    *,
    longest: float = np.inf,
    unreadable: int = 0,
    stale: int = 0,
    reordered: int = 0,
    restarts: int = 0,
    breaks: tuple[int, ...] = (),
) -> Timeline:
    if not len(time):
        return Timeline(time, order, (), 0.0, unreadable, stale)
    limit = _gap_limit_of(time)
    gaps: list[int] = (steps_over(time, limit) + 1).tolist() if longest > limit else []
    restarted = set(breaks)
    lengths = tuple(float(time[index] - time[index - 1]) for index in gaps if index not in restarted)
    edges = sorted({0, len(time), *gaps, *restarted})
    segments = tuple(
        Segment(low, high - low, float(time[low]), float(time[high - 1] - time[low])) for low, high in pairwise(edges)
    )
    lost = sum(float(time[index] - time[index - 1]) for index in breaks)
    duration = float(time[-1] - time[0]) - lost
    return Timeline(time, order, segments, duration, unreadable, stale, reordered, restarts, lengths)
