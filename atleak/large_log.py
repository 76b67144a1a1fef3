"""Defines a road test that is larger than memory: its samples lie on disk and are held piece by piece.

A piece is a `RoadTest` like any other, with every channel on the common base. What looks at neighbours takes a piece
with some rows more on either side, and keeps what it finds in its middle.
"""

from __future__ import annotations

import tempfile
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from types import MappingProxyType

import numpy as np

from atleak.columns import Column, DiskColumn, median_of, positive, spans, steps_of
from atleak.road_test import Channel, RoadTest, Segment

PIECE = 1 << 18
"""Rows that are worked on at once."""


@dataclass(frozen=True, eq=False)
class LargeLog:
    """A road test whose samples lie on disk; temporary files are deleted when it is closed.

    ``head`` is all that a road test says of itself, without a sample: its channels are empty, but for constants. A
    channel's numbers stand in ``columns``, on the base ``time``, in SI, NaN where not sampled or suspect.
    """

    head: RoadTest
    time: Column
    columns: Mapping[str, Column]
    begins: np.ndarray  # first row of every stretch in which time runs on, ascending, from 0 on
    piece: int = PIECE
    folder: tempfile.TemporaryDirectory[str] | None = field(default=None, repr=False)

    @classmethod
    def of(cls, road_test: RoadTest, piece: int = PIECE) -> LargeLog:
        """Return a road test as one that is worked on in pieces."""
        columns = {
            name: np.asarray(road_test.values(name))
            for name, channel in road_test.channels.items()
            if channel.source != "constant"
        }
        begins = [segment.start_row for segment in road_test.segments] or [0]
        head = without_samples(road_test)
        rated = {
            name: replace(head.channels[name], sampling_hz=_rate(each)) for name, each in road_test.channels.items()
        }
        head = replace(head, channels=MappingProxyType(rated))
        return cls(head, road_test.time, columns, np.array(begins), piece)

    def __len__(self) -> int:
        return len(self.time)

    def close(self) -> None:
        """Delete the files on disk."""
        if self.folder is not None:
            self.folder.cleanup()

    @cached_property
    def stops(self) -> np.ndarray:
        """Return the row behind the last one of every stretch."""
        return np.append(self.begins[1:], len(self))

    @cached_property
    def usual_step(self) -> float:
        """Return the median step of time, of those forwards [s]; NaN where there are none."""
        return median_of(positive(steps_of(self.time)))

    def spans(self) -> Iterator[tuple[int, int]]:
        """Yield first row and end of every piece."""
        return spans(len(self), self.piece)

    def values(self, quantity: str, start: int, stop: int) -> np.ndarray | None:
        """Return some rows of a channel; None where the log does not hold the quantity."""
        channel = self.head.channel(quantity)
        if channel is None:
            return None
        if channel.source == "constant":
            return np.full(stop - start, channel.values[0])
        values: np.ndarray = self.columns[quantity][start:stop]
        return values

    def begin_of(self, row: int) -> int:
        """Return the first row of the stretch that a row lies in."""
        return int(self.begins[np.searchsorted(self.begins, row, side="right") - 1])

    def stop_of(self, row: int) -> int:
        """Return the row behind the last one of the stretch that a row lies in."""
        return int(self.stops[np.searchsorted(self.begins, row, side="right") - 1])

    def back(self, row: int, seconds: float) -> int:
        """Return the first row of the same stretch that lies no more than some seconds before a row."""
        return self._place(self.begin_of(row), row, float(self.time[row]) - seconds, after=False)

    def onward(self, row: int, seconds: float) -> int:
        """Return the row behind the last one of the same stretch that lies no more than some seconds behind a row."""
        return self._place(row, self.stop_of(row), float(self.time[row]) + seconds, after=True)

    def _place(self, low: int, high: int, time: float, *, after: bool) -> int:
        """Return the place of a time among ascending rows, behind those that are equal or before them."""
        while low < high:
            middle = (low + high) // 2
            stamp = float(self.time[middle])
            if stamp < time or (after and stamp == time):
                low = middle + 1
            else:
                high = middle
        return low

    def with_channel(self, channel: Channel, parts: Iterable[np.ndarray]) -> LargeLog:
        """Return the log with one channel more.

        Parameters
        ----------
        channel
            without samples.
        parts
            these, one part behind the other; they are put where the others are.
        """
        column: Column
        if self.folder is None:
            column = np.concatenate([np.empty(0), *parts])
        else:
            column = DiskColumn(Path(self.folder.name) / f"{channel.quantity}.column")
            for part in parts:
                column.append(part)
        channels = MappingProxyType({**self.head.channels, channel.quantity: channel})
        head = replace(self.head, channels=channels, _held={})
        return replace(self, head=head, columns={**self.columns, channel.quantity: column})

    def begin_mask(self, start: int, stop: int) -> np.ndarray:
        """Return which of some rows are the first of their stretch."""
        mask, (low, high) = np.zeros(stop - start, bool), np.searchsorted(self.begins, (start, stop))
        mask[self.begins[low:high] - start] = True
        return mask

    def part(self, start: int, stop: int, names: Collection[str] | None = None) -> RoadTest:
        """Return some rows as a road test, every channel on its base, or those of some names alone."""
        time: np.ndarray = self.time[start:stop]
        channels: dict[str, Channel] = {}
        for name, channel in self.head.channels.items():
            if names is not None and name not in names:
                continue
            if channel.source == "constant":
                channels[name] = replace(channel, time=time[:1])
                continue
            values = self.columns[name][start:stop]
            channels[name] = replace(channel, time=time, values=values, suspect=np.zeros(len(time), bool))
        return replace(
            self.head,
            rows=len(time),
            duration=float(time[-1] - time[0]) if len(time) else 0.0,
            time=time,
            channels=MappingProxyType(channels),
            segments=tuple(self._segments(time, start, stop)),
            _held={},
        )

    def stretches(self, start: int, stop: int) -> Iterator[tuple[int, int, int]]:
        """Yield number, first row and end of every stretch that some rows lie in."""
        first, last = np.searchsorted(self.begins, (start, stop - 1), side="right")
        for number in range(first - 1, last):
            yield number, int(self.begins[number]), int(self.stops[number])

    def _segments(self, time: np.ndarray, start: int, stop: int) -> Iterator[Segment]:
        for _, begin, end in self.stretches(start, stop) if stop > start else ():
            low, high = max(begin, start) - start, min(end, stop) - start
            yield Segment(low, high - low, float(time[low]), float(time[high - 1] - time[low]))


def _rate(channel: Channel) -> float:
    """Return a channel's true rate or, where it is not known, that of its stamps [1/s]; NaN where it has none."""
    if channel.sampling_hz > 0.0 or channel.source != "logged":
        return channel.sampling_hz
    steps = np.diff(channel.time)
    forwards = steps[steps > 0.0]
    return 1.0 / float(np.median(forwards)) if len(forwards) else float("nan")


def without_samples(road_test: RoadTest) -> RoadTest:
    """Return all that a road test says of itself but its samples."""
    nothing = np.empty(0)
    channels = {
        name: channel
        if channel.source == "constant"
        else replace(channel, time=nothing, values=nothing, suspect=np.empty(0, bool))
        for name, channel in road_test.channels.items()
    }
    return replace(road_test, time=nothing, channels=MappingProxyType(channels), segments=(), in_pieces=True, _held={})


def rows_of(part: RoadTest, start: int, stop: int) -> RoadTest:
    """Return some rows of a piece, whose channels are all on its base."""
    time = part.time[start:stop]
    channels = {
        name: replace(channel, time=time[:1])
        if channel.source == "constant"
        else replace(channel, time=time, values=channel.values[start:stop], suspect=channel.suspect[start:stop])
        for name, channel in part.channels.items()
    }
    return replace(part, rows=len(time), time=time, channels=MappingProxyType(channels), segments=(), _held={})
