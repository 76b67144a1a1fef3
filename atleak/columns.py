"""Columns of numbers that are larger than memory: on disk, read and written piece by piece; and their exact ranks.

Nothing is mapped into memory: a mapped file's pages count as memory used for as long as the system keeps them.
"""

from __future__ import annotations

import errno
from collections.abc import Callable, Iterator, Sequence
from copy import copy
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import numpy as np

from atleak.errors import InputError, Place
from atleak.sentence import Sentence

ROOM = Sentence("room there, or another folder for temporary files (TMPDIR, on Windows TEMP)")
"""What is expected where a disk is full."""
_FULL = (errno.ENOSPC, getattr(errno, "EDQUOT", errno.ENOSPC))
PIECE = 1 << 20
"""Numbers of a column that are held at once."""
_FEW = 1 << 20  # numbers that are simply sorted
_BITS = 16  # of a number that one look through all of them settles
_WHOLE = 64  # bits of a number
_SIGN = np.uint64(1 << 63)


class DiskColumn:
    """Numbers of one kind in a file of their own; slices of it are arrays."""

    def __init__(self, path: Path, dtype: Any = np.float64) -> None:
        self.path, self.dtype = path, np.dtype(dtype)
        self._size = self._begin = 0
        path.write_bytes(b"")

    def __len__(self) -> int:
        return self._size

    def append(self, values: np.ndarray) -> None:
        """Add numbers at the end."""
        self._put(values, "ab")
        self._size += len(values)

    def write(self, start: int, values: np.ndarray) -> None:
        """Put numbers in place of those from ``start`` on."""
        self._put(values, "r+b", start)

    def _put(self, values: np.ndarray, mode: Literal["ab", "r+b"], start: int = 0) -> None:
        try:
            with self.path.open(mode) as stream:
                stream.seek(start * self.dtype.itemsize)
                stream.write(np.ascontiguousarray(values, self.dtype).data)
        except OSError as error:
            if error.errno not in _FULL:
                raise
            problem = Sentence("has no room left for the samples of a large log, which is read in pieces")
            raise InputError(problem, place=Place(file=str(self.path.parent.parent)), expected=ROOM) from error

    def __getitem__(self, part: slice | int) -> Any:
        """Return some of the numbers, those of a slice forwards, or a single one."""
        if not isinstance(part, slice):
            place = range(self._size)[part]
            return self._read(place, place + 1)[0]
        start, stop, step = part.indices(self._size)
        if step == 1:
            return self._read(start, stop)
        length = max(PIECE // step, 1) * step
        parts = [self._read(first, min(first + length, stop))[::step] for first in range(start, stop, length)]
        return np.concatenate([np.empty(0, self.dtype), *parts])

    def _read(self, start: int, stop: int) -> np.ndarray:
        with self.path.open("rb") as stream:
            offset = (self._begin + start) * self.dtype.itemsize
            return np.fromfile(stream, self.dtype, max(stop - start, 0), offset=offset)

    def part(self, start: int, stop: int) -> DiskColumn:
        """Return some of the numbers as a column to be read, in the same file."""
        some = copy(self)
        start, stop, _ = slice(start, stop).indices(self._size)
        some._begin, some._size = self._begin + start, max(stop - start, 0)
        return some

    def remove(self) -> None:
        """Delete the file."""
        self.path.unlink(missing_ok=True)
        self._size = 0


Column = np.ndarray | DiskColumn


def held(column: Column) -> np.ndarray:
    """Return all numbers of a column, in memory."""
    whole: np.ndarray = column[:] if isinstance(column, DiskColumn) else column
    return whole


def part_of(column: Column, start: int, stop: int) -> Column:
    """Return some of a column, without a copy."""
    return column.part(start, stop) if isinstance(column, DiskColumn) else column[start:stop]


def spans(size: int, length: int = PIECE) -> Iterator[tuple[int, int]]:
    """Yield first and end of pieces that together are a column.

    >>> list(spans(5, 2))
    [(0, 2), (2, 4), (4, 5)]
    """
    for start in range(0, size, length):
        yield start, min(start + length, size)


Stream = Callable[[], Iterator[np.ndarray]]
"""Begins a look through numbers, which come in arrays; it is called again for every look."""


def stream_of(column: Column, length: int = PIECE) -> Stream:
    """Return a column as a stream of its pieces."""
    return lambda: (column[start:stop] for start, stop in spans(len(column), length))


def steps_of(column: Column, start: int = 0, stop: int | None = None, length: int = PIECE) -> Stream:
    """Return the differences between the neighbours in a column, or a part of it, as a stream."""
    end = len(column) if stop is None else stop
    return lambda: (
        np.diff(column[start + low : min(start + high + 1, end)]) for low, high in spans(end - start, length)
    )


def positive(stream: Stream) -> Stream:
    """Return the numbers of a stream that are above zero."""
    return lambda: (part[part > 0.0] for part in stream())


def median_of(stream: Stream) -> float:
    """Return the median as `numpy.median` computes it; NaN of nothing.

    >>> median_of(lambda: iter([np.array([4.0, 1.0]), np.array([2.0, 8.0])]))
    3.0
    """
    found = ranked(stream, lambda count: [(count - 1) // 2, count // 2])
    return float(np.mean(found)) if found else float("nan")


def percentiles_of(stream: Stream, percents: Sequence[float]) -> list[float]:
    """Return percentiles as `numpy.percentile` computes them, between the two next to each; NaN of nothing.

    >>> percentiles_of(lambda: iter([np.arange(50.0), np.arange(50.0, 101.0)]), (50, 90))
    [50.0, 90.0]
    """
    places: list[float] = []

    def around(count: int) -> list[int]:
        places.extend((count - 1) * (percent / 100.0) for percent in percents)
        return [rank for place in places for rank in (int(place), min(int(place) + 1, count - 1))]

    found = ranked(stream, around)
    if not found:
        return [float("nan")] * len(percents)
    pairs = zip(places, found[::2], found[1::2], strict=True)
    return [low + (high - low) * (place - int(place)) for place, low, high in pairs]


@dataclass
class _Target:
    """One rank that is looked for: which bits are settled, and which rank it is among those that share them."""

    rank: int
    prefix: int = 0
    settled: int = 0  # bits
    alike: int = 0  # how many numbers share them
    value: float | None = None


@dataclass
class _Look:
    """What one look through the numbers finds among those with one prefix."""

    gathers: bool
    found: list[np.ndarray] = field(default_factory=list)
    counts: np.ndarray = field(default_factory=lambda: np.zeros(1 << _BITS, np.int64))


def ranked(stream: Stream, ranks: Callable[[int], Sequence[int]]) -> list[float]:
    """Return the numbers of a stream that have certain ranks, exactly, and without holding many of them.

    Each look through the stream settles sixteen bits of a number; those that are then few are gathered and sorted.

    Parameters
    ----------
    stream
        without NaN.
    ranks
        which are wanted, from the smallest number on, where there are so many numbers; nothing is where there are none.
    """
    count = sum(len(part) for part in stream())
    if not count:
        return []
    targets = [_Target(rank, alike=count) for rank in ranks(count)]
    while any(target.value is None for target in targets):
        open_ = [target for target in targets if target.value is None]
        looks = {(each.settled, each.prefix): _Look(each.alike <= _FEW) for each in open_}
        for part in stream():
            keys = _keys(part)
            for (settled, prefix), look in looks.items():
                here = keys if not settled else keys[keys >> np.uint64(_WHOLE - settled) == np.uint64(prefix)]
                if look.gathers:
                    look.found.append(here)
                else:
                    digits = (here >> np.uint64(_WHOLE - settled - _BITS)) & np.uint64((1 << _BITS) - 1)
                    look.counts += np.bincount(digits.astype(np.int64), minlength=1 << _BITS)
        for target in open_:
            _narrow(target, looks[target.settled, target.prefix])
    return [float(target.value) for target in targets if target.value is not None]


def _narrow(target: _Target, look: _Look) -> None:
    if look.gathers:
        keys = np.concatenate(look.found)
        target.value = _number(np.partition(keys, target.rank)[target.rank])
        return
    below = np.cumsum(look.counts)
    digit = int(np.searchsorted(below, target.rank, side="right"))
    target.rank -= int(below[digit] - look.counts[digit])
    target.alike = int(look.counts[digit])
    target.prefix = target.prefix << _BITS | digit
    target.settled += _BITS
    if target.settled == _WHOLE:
        target.value = _number(np.uint64(target.prefix))


def _keys(values: np.ndarray) -> np.ndarray:
    """Return whole numbers that are in the same order as floats."""
    bits = np.ascontiguousarray(values, np.float64).view(np.uint64)
    return np.where(bits & _SIGN, ~bits, bits | _SIGN)


def _number(key: np.uint64) -> float:
    bits = key ^ _SIGN if key & _SIGN else ~key
    return float(np.array([bits], np.uint64).view(np.float64)[0])
