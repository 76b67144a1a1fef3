"""Looks through long columns a block at a time, each small enough for the processor's cache, without a copy."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

import numpy as np

_BLOCK = 1 << 15
"""Numbers in a block: 256 kB."""

_MANY = 200_000
"""Rows from which on threads are worth their while."""

Column = TypeVar("Column")
Result = TypeVar("Result")

Ends = tuple[float, float]
"""The least and the greatest number of a column whose cells are all finite numbers."""


def each(work: Callable[[Column], Result], columns: Iterable[Column], rows: int) -> list[Result]:
    """Return what work makes of every column, on several cores where there are many rows: numpy leaves them free."""
    if rows <= _MANY:
        return [work(column) for column in columns]
    with ThreadPoolExecutor(min(4, os.cpu_count() or 1)) as pool:
        return list(pool.map(work, columns))


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


def ends_of_steps(values: np.ndarray) -> Ends | None:
    """Return the least and the greatest step from a number to the next; None as `ends_of` does.

    >>> ends_of_steps(np.array([3.0, -1.0, 2.0])), ends_of_steps(np.array([3.0]))
    ((-4.0, 3.0), None)
    """
    least, most = np.inf, -np.inf
    for _, steps in _steps(values):
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
    places = [start + np.flatnonzero(steps > limit) for start, steps in _steps(values)]
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


def _steps(values: np.ndarray) -> Iterator[tuple[int, np.ndarray]]:
    """Yield where a block begins, and its steps, each block's in place of the ones before."""
    room = np.empty(min(_BLOCK, max(len(values) - 1, 0)))
    for start in range(0, len(values) - 1, _BLOCK):
        after = values[start + 1 : start + _BLOCK + 1]
        yield start, np.subtract(after, values[start : start + len(after)], out=room[: len(after)])
