"""Tell what of a log's values lasts where the log comes in pieces: the same that `atleak.engine.lasting` tells.

A stretch in which a value lies outside may last for hours, and what does not count is cut out of the second in which a
value must last. So the samples of that second are kept from piece to piece, and the stretch that has not ended.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from atleak.engine.lasting import APART, ENOUGH, NEVER, CountedSamples, events_cut_out, least_since
from atleak.events import Event
from atleak.large_log import LargeLog
from atleak.road_test import RoadTest

EVERYWHERE = -1
"""The group that holds every sample of the others."""


@dataclass(frozen=True)
class CountedPiece:
    """A piece of a log with the rows around it."""

    road_test: RoadTest
    first: int  # number of its first row in the log
    core: slice  # the rows of the piece in it
    stretch: np.ndarray  # number of the stretch of the log that each row lies in
    counted: CountedSamples

    @property
    def counting(self) -> np.ndarray:
        """Return the places of the piece's samples that count."""
        samples = self.counted.samples
        low, high = np.searchsorted(samples, (self.core.start, self.core.stop))
        return samples[low:high]

    def near(self, events: Sequence[Event]) -> list[Event]:
        """Return those of some events that may touch the rows."""
        time = self.road_test.time
        return [event for event in events if event.stop >= time[0] and event.start <= time[-1]]

    def time_of(self, mask: np.ndarray) -> float:
        """Return how long some of the samples take [s], of those of the piece."""
        return float(np.sum(self.counted.steps[self.core][mask[self.core]]))


def counted_pieces(
    log: LargeLog, events: Sequence[Event], seconds: float, names: Collection[str] | None = None
) -> Iterator[CountedPiece]:
    """Yield the pieces of a log, each with the rows that lie up to some seconds around it in the same stretch.

    Parameters
    ----------
    events
        those of the whole log.
    names
        channels that are read besides the engine speed; all of them unless given.
    """
    cut_out = events_cut_out(events)
    begins, ends = (np.array([getattr(event, end) for event in cut_out]) for end in ("start", "stop"))
    read, origin = None if names is None else {*names, "engine_speed"}, float(log.time[0]) if len(log) else 0.0
    for start, stop in log.spans():
        low = log.back(start, seconds)
        high = max(log.onward(stop - 1, seconds), min(stop + 1, log.stop_of(stop - 1)))
        part = log.part(low, high, read)
        near = np.flatnonzero((ends >= part.time[0]) & (begins <= part.time[-1])) if cut_out else ()
        stretch = np.searchsorted(log.begins, np.arange(low, high), side="right")
        counted = CountedSamples(part, [cut_out[number] for number in near], origin, int(stretch[0]) - 1)
        yield CountedPiece(part, low, slice(start - low, stop - low), stretch, counted)


@dataclass
class _Stretch:
    """A stretch outside: its first and last sample on time [s] and on the clock that counts [s]."""

    start: float
    stop: float
    begun: float
    ended: float
    pending: dict[int, list[float]] = field(default_factory=lambda: defaultdict(list))  # time of each group [s]

    @property
    def lasts(self) -> bool:
        return self.ended - self.begun >= ENOUGH


@dataclass(frozen=True)
class Worst:
    """The sample at which the worst second is least bad, with what is known of it."""

    least: float  # of the second
    time: float  # [s]
    excess: float
    values: dict[str, float]
    stretch: _Stretch | None

    @property
    def span(self) -> tuple[float, float]:
        """Return begin and end [s] of the stretch outside that it lies in; its own time where in none that lasts."""
        if self.stretch is None or not self.stretch.lasts:
            return self.time, self.time
        return self.stretch.start, self.stretch.stop


class LastingInPieces:
    """Values of the samples that count, outside where they are positive, and what of them lasts, by group."""

    def __init__(self) -> None:
        self._kept: dict[str, np.ndarray] = {}  # of the latest samples
        self._stretches: list[_Stretch | None] = []  # in which they lie
        self._elapsed = 0.0  # [s] on the clock from the first that is kept to the next one
        self._open: _Stretch | None = None
        self._worst: dict[int, Worst] = {}
        self._outside: dict[int, list[float]] = defaultdict(list)

    def worst(self, group: int = EVERYWHERE) -> Worst | None:
        """Return the sample at which the worst second of a group is least bad; None where there is no such second."""
        return self._worst.get(group)

    def outside(self, group: int) -> float:
        """Return for how long a group's samples lay in stretches outside that last [s]."""
        open_ = self._open.pending[group] if self._open is not None and self._open.lasts else []
        return math.fsum([*self._outside[group], *open_])

    def add(
        self, time: np.ndarray, steps: np.ndarray, part: np.ndarray, excess: np.ndarray, group: np.ndarray,
        **values: np.ndarray,
    ) -> None:  # fmt: skip
        """Add the next samples that count.

        Parameters
        ----------
        time, steps
            of each, and to the next sample of its stretch of the log [s].
        part
            number of the stretch of the log.
        excess
            NaN ends a stretch outside.
        group
            number of the group, from 0 on; −1 of a sample in none.
        values
            what else is to be known of the worst one.
        """
        if not len(time):
            return
        elapsed = self._elapsed + np.cumsum(steps) - steps
        fresh = {"time": time, "steps": steps, "part": part, "excess": excess, "group": group, "elapsed": elapsed}
        fresh |= values
        kept = len(self._stretches)
        every = {name: np.concatenate([self._kept[name], new]) if kept else new for name, new in fresh.items()}
        self._elapsed += float(np.sum(steps))
        clock = every["elapsed"] + APART * every["part"]
        known = np.where(np.isnan(every["excess"]), NEVER, every["excess"])
        place_of = self._follow(every, clock, known > 0.0, kept)
        begins = np.searchsorted(every["part"], every["part"])
        since = np.searchsorted(clock, clock - ENOUGH, side="right") - 1
        windows = np.maximum(since, begins)
        least = np.where(since >= begins, least_since(known, windows), NEVER)
        least[:kept] = NEVER
        self._look(every, least, windows, place_of)
        self._keep(every, clock, place_of)

    def _follow(self, every: dict[str, np.ndarray], clock: np.ndarray, over: np.ndarray, kept: int) -> _Places:
        """Follow the stretches outside through the new samples; return in which each sample lies."""
        part, time = every["part"], every["time"]
        changes = (np.diff(over) | (np.diff(part) != 0)) if len(over) > 1 else np.empty(0, bool)
        edges = np.flatnonzero(np.concatenate([[not kept], changes]))
        edges = edges[edges >= kept]
        bounds = [*edges.tolist(), len(over)]
        places = _Places(self._stretches, self._open, bounds, every, clock, over)
        if self._open is not None and bounds[0] > kept:
            self._extend(self._open, every, clock, slice(kept, bounds[0]))
        if len(edges):
            self._close()
            starts, stops = edges[:-1], edges[1:] - 1
            long = np.flatnonzero(over[starts] & (clock[stops] - clock[starts] >= ENOUGH))
            for number in long.tolist():
                lasting = slice(int(starts[number]), int(stops[number]) + 1)
                for group, seconds in _by_group(every, lasting):
                    self._outside[group].append(seconds)
            last = int(edges[-1])
            if over[last]:
                self._open = _Stretch(float(time[last]), float(time[last]), float(clock[last]), float(clock[last]))
                self._extend(self._open, every, clock, slice(last, len(over)))
                places.last = self._open
        return places

    def _extend(self, stretch: _Stretch, every: dict[str, np.ndarray], clock: np.ndarray, samples: slice) -> None:
        stretch.stop, stretch.ended = float(every["time"][samples.stop - 1]), float(clock[samples.stop - 1])
        for group, seconds in _by_group(every, samples):
            stretch.pending[group].append(seconds)

    def _close(self) -> None:
        if self._open is not None and self._open.lasts:
            for group, seconds in self._open.pending.items():
                self._outside[group] += seconds
        self._open = None

    def _look(self, every: dict[str, np.ndarray], least: np.ndarray, windows: np.ndarray, places: _Places) -> None:
        """Look for seconds that are worse than the worst so far."""
        groups = every["group"]
        for group in [EVERYWHERE, *np.unique(groups[groups >= 0]).tolist()]:
            among = groups >= 0 if group == EVERYWHERE else groups == group
            here = np.where(among, least, NEVER)
            end = int(np.argmax(here))
            if not here[end] > (self._worst[group].least if group in self._worst else NEVER):
                continue
            window = np.arange(windows[end], end + 1)
            window = window[among[window]]
            at = int(window[np.argmin(every["excess"][window])])
            known = {name: float(values[at]) for name, values in every.items()}
            stretch = places.stretch_of(at)
            self._worst[group] = Worst(float(here[end]), known["time"], known["excess"], known, stretch)

    def _keep(self, every: dict[str, np.ndarray], clock: np.ndarray, places: _Places) -> None:
        """Keep the samples of the second in which the next one may lie, counting the clock from the first of them."""
        ahead = self._elapsed + APART * float(every["part"][-1]) - ENOUGH
        first = min(max(int(np.searchsorted(clock, ahead, side="right")) - 1, 0), len(clock) - 1)
        self._stretches = [places.stretch_of(place) for place in range(first, len(clock))]
        base = float(every["elapsed"][first])
        self._kept = {name: values[first:] for name, values in every.items()}
        self._kept["elapsed"] = self._kept["elapsed"] - base
        self._elapsed -= base
        if self._open is not None:
            self._open.begun -= base
            self._open.ended -= base


def _by_group(every: dict[str, np.ndarray], samples: slice) -> Iterator[tuple[int, float]]:
    """Yield the time of each group among some samples [s]."""
    groups, steps = every["group"][samples], every["steps"][samples]
    for group in np.unique(groups[groups >= 0]).tolist():
        yield group, float(np.sum(steps[groups == group]))


@dataclass
class _Places:
    """In which stretch outside each of some samples lies: those that were kept, then the new ones."""

    kept: list[_Stretch | None]
    before: _Stretch | None  # that had not ended with those that were kept
    bounds: list[int]  # where the new samples change sides, and their end
    every: dict[str, np.ndarray]
    clock: np.ndarray
    over: np.ndarray
    last: _Stretch | None = None  # that has not ended with the new ones
    _made: dict[int, _Stretch] = field(default_factory=dict)

    def stretch_of(self, place: int) -> _Stretch | None:
        """Return the stretch of a sample; None where it does not lie outside."""
        if place < len(self.kept):
            return self.kept[place]
        if not self.over[place]:
            return None
        if place < self.bounds[0]:
            return self.before
        number = int(np.searchsorted(self.bounds, place, side="right")) - 1
        if number == len(self.bounds) - 2:
            return self.last
        if number not in self._made:
            start, stop = self.bounds[number], self.bounds[number + 1] - 1
            time, clock = self.every["time"], self.clock
            made = _Stretch(float(time[start]), float(time[stop]), float(clock[start]), float(clock[stop]))
            self._made[number] = made
        return self._made[number]
