"""Looks through a channel's own samples on disk: which are suspect, how many are true, and how they lie on the base.

What is doubted, counted and held is what `channels.build`, `channels.suspects` and `RoadTest.values` doubt, count and
hold of a log in memory. A channel's own samples are its cells that are not blank, in the order of time.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import numpy as np
import pandas as pd

from atleak.columns import DiskColumn, Stream, median_of, percentiles_of, positive, spans
from atleak.intake.road_test.channels import suspects
from atleak.intake.road_test.channels.assign import Signal
from atleak.intake.road_test.pieces.timelines import PIECE, LargeTimeline
from atleak.road_test import QUANTITIES

_MARGIN = 8  # samples on either side that show a spike
_AT_ENDS = 11  # samples at either end that show a start-up
_MIDDLE = 20_000  # samples that show whether a logger repeats its answers


@dataclass(frozen=True)
class Samples:
    """Some of a channel's own samples: number of the first, the file's numbers, stamps [s]."""

    first: int
    raw: np.ndarray
    time: np.ndarray
    moves: np.ndarray | None  # where the car's other speed changes


class OwnSamples:
    """A channel's own samples, piece by piece."""

    def __init__(self, signal: Signal, timeline: LargeTimeline, speed: Signal | None) -> None:
        assert signal.on_disk is not None
        self.signal, self.timeline, self._numbers = signal, timeline, signal.on_disk
        self._stamps = signal.time if isinstance(signal.time, DiskColumn) else None
        of_rows = speed is not None and speed.time is None and self._stamps is None
        self._beside = speed.on_disk if speed is not None and of_rows else None

    def __iter__(self) -> Iterator[Samples]:
        return self._with_stamps(self._stamps) if self._stamps is not None else self._of_rows()

    @property
    def moves_beside(self) -> bool:
        """Return whether another speed of the car stands beside them."""
        return self._beside is not None

    def steps(self) -> Stream:
        """Return the steps between the stamps, as a stream."""

        def looked() -> Iterator[np.ndarray]:
            last = np.empty(0)
            for each in self:
                yield np.diff(np.concatenate([last, each.time]))
                last = each.time[-1:]

        return looked

    def _with_stamps(self, stamps: DiskColumn) -> Iterator[Samples]:
        for start, stop in spans(len(self._numbers), PIECE):
            yield Samples(start, self._numbers[start:stop], stamps[start:stop], None)

    def _of_rows(self) -> Iterator[Samples]:
        first, last = 0, np.nan
        for start, stop in spans(len(self.timeline.time), PIECE):
            raw = self.timeline.rows(self._numbers, start, stop)
            time, moves = self.timeline.time[start:stop], None
            if self._beside is not None:
                beside = self.timeline.rows(self._beside, start, stop)
                moves = np.diff(beside, prepend=last) != 0
                moves[0] &= start > 0
                last = float(beside[-1])
            present = ~np.isnan(raw)
            if not present.all():
                raw, time = raw[present], time[present]
                moves = None if moves is None else moves[present]
            if len(raw):
                yield Samples(first, raw, time, moves)
            first += len(raw)


@dataclass
class Facts:
    """What all of a channel's samples together say of each of them."""

    count: int = 0
    span: tuple[float, float] = (0.0, 0.0)  # first and last stamp [s]
    repeats: int = 0  # samples that equal the one before
    of_file: tuple[float, float] = (np.inf, -np.inf)  # least and greatest of the file's numbers
    of_si: tuple[float, float] = (np.inf, -np.inf)
    whole: bool = False  # whether every row of the log has a sample
    sentinels: bool = False  # whether error codes are no ordinary values
    failed: bool = False  # whether an end of the sensor's scale is none
    at_start: int = 0  # samples with which it starts up
    at_end: int = 0
    frozen: list[tuple[int, int]] = field(default_factory=list)  # first and last sample of runs

    @classmethod
    def of(cls, own: OwnSamples) -> Facts:
        """Look through a channel."""
        facts, last = cls(), np.nan
        for each in own:
            si = own.signal.fit.to_si(each.raw)
            facts.span = (facts.span if facts.count else (float(each.time[0]), 0.0))[0], float(each.time[-1])
            facts.count += len(each.raw)
            facts.repeats += int(np.count_nonzero(np.diff(each.raw, prepend=last) == 0))
            facts.of_file, facts.of_si = _wider(facts.of_file, each.raw), _wider(facts.of_si, si)
            last = float(each.raw[-1])
        facts.whole = facts.count == len(own.timeline.time)
        quantity = own.signal.candidate.quantity
        if np.isin(facts.of_file, suspects.SENTINELS).any():
            codes = sum(int(np.isin(each.raw, suspects.SENTINELS).sum()) for each in own)
            facts.sentinels = codes <= 0.5 * facts.count
        if QUANTITIES[quantity].unit_kind == "temperature":
            facts._of_temperature(own)
        seconds = suspects.FROZEN_SECONDS.get(QUANTITIES[quantity].unit_kind or "")
        if seconds is not None and facts.count >= suspects.LEAST_RUN:
            facts._of_runs(own, seconds)
        return facts

    def _of_temperature(self, own: OwnSamples) -> None:
        """Tell whether a sensor has failed, and with how many samples it starts up."""

        def others() -> Iterator[np.ndarray]:
            for each in own:
                clean = self.clean(own.signal, each.raw)
                yield clean[np.isfinite(clean) & ~suspects.at_scale_end(clean)]

        low, high = suspects.SCALE
        if self.of_si[0] <= low or self.of_si[1] >= high:
            clean = (np.inf, -np.inf)
            for each in own:
                clean = _wider(clean, self.clean(own.signal, each.raw))
            self.failed = (clean[0] <= low or clean[1] >= high) and median_of(others) > suspects.ORDINARY
        if self.count < 3 * (_AT_ENDS - 1):
            return
        first, last = np.empty(0), np.empty(0)
        for each in own:
            if len(first) < _AT_ENDS:
                first = np.concatenate([first, self.clean(own.signal, each.raw[:_AT_ENDS])])[:_AT_ENDS]
            last = np.concatenate([last, self.clean(own.signal, each.raw[-_AT_ENDS:])])[-_AT_ENDS:]
        self.at_start = int(np.max(np.flatnonzero(_leaps(first)), initial=-1)) + 1
        tail = np.flatnonzero(_leaps(last))
        self.at_end = _AT_ENDS - 1 - int(tail[0]) if len(tail) else 0

    def _of_runs(self, own: OwnSamples, seconds: float) -> None:
        """Find the runs in which the channel is frozen."""
        stride = suspects.probe_stride(self.count, self.span[1] - self.span[0], seconds)
        probes, stamps = [np.empty(0)], [np.empty(0)]
        for each in own:
            probed = slice(-each.first % stride, None, stride)
            probes.append(self.clean(own.signal, each.raw[probed].copy()))  # not a view, which would hold all samples
            stamps.append(each.time[probed].copy())
        many = self.count > 2 * stride
        if not suspects.shows_long_run(np.concatenate(probes), np.concatenate(stamps), self.span[1], seconds, many):
            return
        runs = _LongRuns(seconds)
        for each in own:
            runs.add(each, self.clean(own.signal, each.raw))
        runs.close()
        found = runs.found
        if own.moves_beside and self.whole:
            self.frozen = [(run.first, run.last) for run in found if run.moves > suspects.FEW_MOVES]
            return
        length = sum(run.last - run.first + 1 for run in found)
        if suspects.stands_out(length, len(found), runs.count, self.count):
            self.frozen = [(run.first, run.last) for run in found]

    def clean(self, signal: Signal, raw: np.ndarray) -> np.ndarray:
        """Return samples in SI, NaN where they are error codes, out of range or of a failed sensor."""
        si = signal.fit.to_si(raw)
        wrong = self.sentinel(raw) | self.out_of_range(signal, si)
        clean = np.where(wrong, np.nan, si) if wrong.any() else si
        if self.failed:
            clean = np.where(suspects.at_scale_end(clean), np.nan, clean)
        return clean

    def sentinel(self, raw: np.ndarray) -> np.ndarray:
        """Return which of the file's numbers are error codes."""
        return np.isin(raw, suspects.SENTINELS) if self.sentinels else np.zeros(len(raw), bool)

    def out_of_range(self, signal: Signal, si: np.ndarray) -> np.ndarray:
        """Return which samples the quantity cannot have."""
        limits = QUANTITIES[signal.candidate.quantity]
        if self.of_si[0] >= limits.low and self.of_si[1] <= limits.high:
            return np.zeros(len(si), bool)
        outside: np.ndarray = (si < limits.low) | (si > limits.high)
        return outside


@dataclass
class _Run:
    """Equal samples one behind the other."""

    first: int
    begun: float  # [s]
    value: float
    last: int = 0
    ended: float = 0.0  # [s]
    moves: int = 0  # of the car's other speed


class _LongRuns:
    """The runs of one value other than zero that last long, as they grow from piece to piece."""

    def __init__(self, seconds: float) -> None:
        self.seconds, self.count = seconds, 0
        self.found: list[_Run] = []
        self._open: _Run | None = None

    def add(self, each: Samples, clean: np.ndarray) -> None:
        moved = np.zeros(len(clean), int) if each.moves is None else each.moves.astype(int)
        before = np.nan if self._open is None else self._open.value
        edges = np.flatnonzero(np.concatenate([[before], clean[:-1]]) != clean)
        bounds = [*edges.tolist(), len(clean)]
        if self._open is not None and bounds[0]:
            self._extend(self._open, each, 0, bounds[0], moved)
        if not len(edges):
            return
        self.close()
        self.count += len(edges)
        starts, stops = edges, np.array(bounds[1:]) - 1
        long = (each.time[stops] - each.time[starts] > self.seconds) & (stops - starts >= suspects.LEAST_RUN)
        for number in np.flatnonzero(long[:-1] & (clean[starts[:-1]] != 0)).tolist():
            self.found.append(self._run(each, clean, bounds[number], bounds[number + 1], moved))
        self._open = self._run(each, clean, bounds[-2], bounds[-1], moved)

    def _run(self, each: Samples, clean: np.ndarray, start: int, stop: int, moved: np.ndarray) -> _Run:
        run = _Run(each.first + start, float(each.time[start]), float(clean[start]))
        self._extend(run, each, start, stop, moved)
        return run

    @staticmethod
    def _extend(run: _Run, each: Samples, start: int, stop: int, moved: np.ndarray) -> None:
        run.last, run.ended = each.first + stop - 1, float(each.time[stop - 1])
        run.moves += int(moved[start:stop].sum())

    def close(self) -> None:
        run, self._open = self._open, None
        if run is None or not run.value:
            return
        if run.ended - run.begun > self.seconds and run.last - run.first >= suspects.LEAST_RUN:
            self.found.append(run)


def _wider(ends: tuple[float, float], values: np.ndarray) -> tuple[float, float]:
    low, high = np.fmin.reduce(values, initial=np.inf), np.fmax.reduce(values, initial=-np.inf)
    return min(ends[0], float(low)), max(ends[1], float(high))


def _leaps(values: np.ndarray) -> np.ndarray:
    with np.errstate(invalid="ignore"):
        leaps: np.ndarray = np.abs(np.diff(values)) > suspects.START_UP
    return leaps


def middle_of(own: OwnSamples, count: int) -> np.ndarray:
    """Return the samples in the middle of a channel, or all of a short one: the file's numbers."""
    low, high = (count // 2 - _MIDDLE // 2, count // 2 + _MIDDLE // 2) if count > _MIDDLE else (0, count)
    parts = [np.empty(0)]
    for each in own:
        if each.first >= high:
            break
        if each.first + len(each.raw) > low:  # an empty view would hold all samples before, too
            parts.append(each.raw[max(low - each.first, 0) : high - each.first])
    return np.concatenate(parts)


def judged(own: OwnSamples, facts: Facts, counts: dict[str, int]) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Yield stamps [s] and samples in SI, NaN where suspect; ``counts`` gets how many each check doubts."""
    step = suspects.STEP.get(QUANTITIES[own.signal.candidate.quantity].unit_kind or "")
    for each, before, behind in _with_neighbours(own):
        raw = each.raw
        si, core = own.signal.fit.to_si(raw), slice(before, len(raw) - behind)
        clean = facts.clean(own.signal, raw)
        numbers = each.first + np.arange(len(raw))
        failed = suspects.at_scale_end(si) if facts.failed else np.zeros(len(raw), bool)
        masks = {
            "sentinel": facts.sentinel(raw),
            "out of range": facts.out_of_range(own.signal, si),
            "failed sensor": failed & ~facts.sentinel(raw) & ~facts.out_of_range(own.signal, si),
            "start-up": (numbers < facts.at_start) | (numbers >= facts.count - facts.at_end),
            "spike": np.zeros(len(raw), bool) if step is None else suspects.spikes(pd.Series(clean), step).to_numpy(),
            "frozen": _inside(facts.frozen, numbers),
        }
        suspect = np.zeros(len(raw), bool)
        for name, mask in masks.items():
            counts[name] = counts.get(name, 0) + int(mask[core].sum())
            suspect |= mask
        yield each.time[core], np.where(suspect, np.nan, si)[core]


def _inside(runs: list[tuple[int, int]], numbers: np.ndarray) -> np.ndarray:
    mask = np.zeros(len(numbers), bool)
    for first, last in runs:
        low, high = np.searchsorted(numbers, (first, last + 1))
        mask[low:high] = True
    return mask


def _with_neighbours(own: OwnSamples) -> Iterator[tuple[Samples, int, int]]:
    """Yield the samples with some on either side, and how many of these stand before and behind."""
    tail, held = _NOTHING, _NOTHING
    for each in own:
        if len(held.raw) < _MARGIN or len(each.raw) < _MARGIN:
            held = _joined(held, each)
            continue
        yield _joined(_joined(tail, held), _part(each, 0, _MARGIN)), len(tail.raw), _MARGIN
        tail, held = _part(held, len(held.raw) - _MARGIN, len(held.raw)), each
    if len(held.raw):
        yield _joined(tail, held), len(tail.raw), 0


_NOTHING = Samples(0, np.empty(0), np.empty(0), None)


def _joined(one: Samples, other: Samples) -> Samples:
    if not len(one.raw):
        return other
    return Samples(one.first, np.concatenate([one.raw, other.raw]), np.concatenate([one.time, other.time]), None)


def _part(each: Samples, start: int, stop: int) -> Samples:
    return Samples(each.first + start, each.raw[start:stop], each.time[start:stop], None)


# --- on the common base


def hold_limit(steps: Stream) -> float:
    """Return how long a sample may be held [s], as `atleak.road_test.hold_limit` does."""
    forwards = positive(steps)
    median = median_of(forwards)
    if np.isnan(median):
        return np.inf
    return float(np.round(max(3 * median, percentiles_of(forwards, [90])[0]), 9))


def held(
    timeline: LargeTimeline, samples: Callable[[], Iterator[tuple[np.ndarray, np.ndarray]]], count: int, limit: float
) -> Iterator[np.ndarray]:
    """Yield a channel's last own sample at each stamp of the base, as `atleak.road_test.hold` does, piece by piece.

    Parameters
    ----------
    samples
        stamps and values of the channel's own samples, and how many there are.
    limit
        how long one may be held [s].
    """
    own = samples()
    size = len(timeline.time)
    length = max(int(PIECE * min(1.0, size / max(count, 1))), 1000)  # so that few of many own samples are held at once
    stamps, values, more = np.empty(0), np.empty(0), True
    for start, stop in spans(size, length):
        time = timeline.time[start:stop]
        parts = [(stamps, values)]
        while more and not (len(parts[-1][0]) and parts[-1][0][-1] > time[-1]):
            following = next(own, None)
            more = following is not None
            if following is not None:
                parts.append(following)
        stamps, values = (np.concatenate(each) for each in zip(*parts, strict=True))
        if not len(stamps):
            yield np.full(stop - start, np.nan)
            continue
        last = np.searchsorted(stamps, time, side="right") - 1
        stamp = stamps[np.maximum(last, 0)]
        usable = (last >= 0) & (stamp >= timeline.begun(start, stop)) & (time - stamp <= limit * (1 + 1e-9))
        yield np.where(usable, values[np.maximum(last, 0)], np.nan)
        kept = max(int(last[-1]), 0)
        stamps, values = stamps[kept:], values[kept:]
    for _ in own:  # behind the base: they count, and are held nowhere
        pass
