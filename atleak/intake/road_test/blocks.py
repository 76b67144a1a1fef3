"""Takes long columns part by part."""

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


def turned(table: np.ndarray) -> np.ndarray:
    """Return a long table of few columns as rows of its columns.

    >>> turned(np.array([[1, 2], [3, 4], [5, 6]])).tolist()
    [[1, 3, 5], [2, 4, 6]]
    """
    result = np.empty(table.shape[::-1], table.dtype)
    for start in range(0, len(table), _BLOCK):
        result[:, start : start + _BLOCK] = table[start : start + _BLOCK].T
    return result
