"""Looks through long columns a block at a time, each small enough for the processor's cache, without a copy."""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any, TypeVar

import numpy as np

from atleak.errors import InputError
from atleak.sentence import Sentence

_BLOCK = 1 << 15
"""Numbers in a block: 256 kB."""

Item = TypeVar("Item")
Result = TypeVar("Result")


class Filled:
    """An array that takes each ``every``-th of some numbers that come part by part, ``count`` of them at most."""

    def __init__(self, count: int, every: int, kind: Any = float) -> None:
        self._room, self._every, self._met = np.empty(-(-count // every), kind), every, 0

    @property
    def numbers(self) -> np.ndarray:
        """Return those that came: a file may hold fewer than it states."""
        return self._room[: -(-self._met // self._every)]

    def add(self, part: np.ndarray) -> None:
        """Add the next numbers.

        Raises
        ------
        InputError
            where more come than were stated.
        """
        kept, first = part[-self._met % self._every :: self._every], len(self.numbers)
        if first + len(kept) > len(self._room):
            raise InputError(Sentence("is damaged: it holds more samples than it states"))
        self._room[first : first + len(kept)] = kept
        self._met += len(part)


Ends = tuple[float, float]
"""The least and the greatest number of a column whose cells are all finite numbers."""


def in_turn(work: Callable[[Item], Result], items: Iterable[Item]) -> Iterator[Result]:
    """Yield what work makes of every item, a few of them at once: numpy and pandas leave the cores free."""
    cores = min(4, os.cpu_count() or 1)
    with ThreadPoolExecutor(cores) as pool:
        waiting: deque[Future[Result]] = deque()
        for item in items:
            waiting.append(pool.submit(work, item))
            if len(waiting) > cores:
                yield waiting.popleft().result()
        while waiting:
            yield waiting.popleft().result()


def ends_of(values: np.ndarray) -> Ends | None:
    """Return the least and the greatest number; None where there is none, or one of them is NaN or infinite.

    >>> ends_of(np.array([3.0, -1.0, 2.0])), ends_of(np.array([3.0, np.nan])), ends_of(np.array([]))
    ((-1.0, 3.0), None, None)
    """
    least, most = np.inf, -np.inf
    for start in range(0, len(values), _BLOCK):
        block = values[start : start + _BLOCK]
        low, high = float(block.min()), float(block.max())
        if not (low > -np.inf and high < np.inf):  # NaN is neither
            return None
        least, most = min(least, low), max(most, high)
    return (least, most) if least <= most else None


def blocks_of(values: np.ndarray) -> Iterator[np.ndarray]:
    """Yield a column block by block."""
    return (values[start : start + _BLOCK] for start in range(0, len(values), _BLOCK))


def any_finite(values: np.ndarray) -> bool:
    """Return whether any number of a column is finite."""
    return any(bool(np.isfinite(block).any()) for block in blocks_of(values))


def finite_of(values: np.ndarray) -> np.ndarray:
    """Return the finite numbers of a column."""
    return np.concatenate([np.empty(0), *(block[np.isfinite(block)] for block in blocks_of(values))])


def only(values: np.ndarray, value: float) -> bool:
    """Return whether a column holds nothing but one value, and cells without any."""
    return all(bool(((block == value) | np.isnan(block)).all()) for block in blocks_of(values))


def span_of(values: np.ndarray) -> Ends | None:
    """Return the least and the greatest number of a column, NaN left out; None where it has none.

    >>> span_of(np.array([3.0, np.nan, 2.0])), span_of(np.array([np.nan]))
    ((2.0, 3.0), None)
    """
    ends = [(np.fmin.reduce(block), np.fmax.reduce(block)) for block in blocks_of(values)]
    known = [(float(low), float(high)) for low, high in ends if low == low]
    return (min(low for low, _ in known), max(high for _, high in known)) if known else None


def rising(values: np.ndarray) -> int:
    """Return how often a finite number of a column is larger than the finite one before it."""
    count, last = 0, np.nan
    for block in blocks_of(values):
        good = block[np.isfinite(block)]
        if len(good):
            count += int(np.count_nonzero(np.diff(good, prepend=last) > 0))
            last = float(good[-1])
    return count


def ends_of_steps(values: np.ndarray) -> Ends | None:
    """Return the least and the greatest step from a number to the next; None as `ends_of` does.

    >>> ends_of_steps(np.array([3.0, -1.0, 2.0])), ends_of_steps(np.array([3.0]))
    ((-4.0, 3.0), None)
    """
    least, most = np.inf, -np.inf
    for _, steps in steps_in(values):
        ends = ends_of(steps)
        if ends is None:
            return None
        least, most = min(least, ends[0]), max(most, ends[1])
    return (least, most) if least <= most else None


def steps_over(values: np.ndarray, limit: float) -> np.ndarray:
    """Return the places from which the step to the next number is larger than a limit.

    >>> steps_over(np.array([0.0, 1.0, 5.0, 5.5, 9.0]), 2.0).tolist()
    [1, 3]
    """
    places = [start + np.flatnonzero(steps > limit) for start, steps in steps_in(values)]
    return np.concatenate(places) if places else np.zeros(0, int)


def turned(table: np.ndarray) -> np.ndarray:
    """Return a long table of few columns as rows of its columns.

    >>> turned(np.array([[1, 2], [3, 4], [5, 6]])).tolist()
    [[1, 3, 5], [2, 4, 6]]
    """
    result = np.empty(table.shape[::-1], table.dtype)
    for start in range(0, len(table), _BLOCK):
        result[:, start : start + _BLOCK] = table[start : start + _BLOCK].T
    return result


def steps_in(values: np.ndarray) -> Iterator[tuple[int, np.ndarray]]:
    """Yield where a block begins, and its steps, each block's in place of the ones before."""
    room = np.empty(min(_BLOCK, max(len(values) - 1, 0)))
    for start in range(0, len(values) - 1, _BLOCK):
        after = values[start + 1 : start + _BLOCK + 1]
        yield start, np.subtract(after, values[start : start + len(after)], out=room[: len(after)])
