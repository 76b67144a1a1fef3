"""Draw numbers that spread evenly, and say how the draws of a quantity spread.

The draws are points that fill a cube evenly, which a fixed seed scrambles. Intervals from some thousands of them are as
steady as those from several times as many random draws (Owen, SIAM J. Numer. Anal. 34, 1997). The points are Sobol's,
each dimension one quantity; a digital shift and a random triangular matrix for each dimension scramble them, so that
every point alone is spread like a random one (Matoušek, J. Complexity 14, 1998). They have few dimensions, and a unit
has hundreds of quantities: those that belong together, of one land or of the whole unit, share a cube, and every land
goes through its cube in an order of its own (Latin supercube sampling: Owen, ACM Trans. Model. Comput. Simul. 8, 1998).
That order is random only among draws in which what all lands share is about the same (as in array-RQMC: L'Ecuyer, Lécot
& Tuffin, Oper. Res. 56, 2008), because a land's flow depends on both.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from atleak.equations.statistics import normal_quantile

Interval = tuple[float, float]


@dataclass(frozen=True)
class DrawnSpread:
    """The standard uncertainty and the interval of one quantity, from its draws."""

    standard_uncertainty: float
    interval: Interval
    probabilities: tuple[float, ...]  # that the quantity has reached each of the limits
    level_uncertainties: tuple[float, ...]  # of the quantity over each limit, which may follow what was new


def spread_of(values: np.ndarray, limits: Sequence[Any], coverage: float, *, falling: bool = False) -> DrawnSpread:
    """Return how draws spread, shape (draws,); each limit is a number or has a value for each draw.

    ``falling`` limits are reached by what is under them.
    """
    reached = tuple(
        float(np.count_nonzero(values < limit if falling else values >= limit)) / values.size for limit in limits
    )
    u = _standard_deviation(values)
    finite = math.isfinite(u)
    return DrawnSpread(
        u,
        interval_of(values, coverage),
        reached,
        tuple(_standard_deviation(values - limit) if finite and np.ndim(limit) else u for limit in limits),
    )


def _standard_deviation(values: np.ndarray) -> float:
    """Return it; infinite where a value is no finite number. Several times as quick as NumPy's own."""
    mean = float(np.add.reduce(values)) / values.size
    if not math.isfinite(mean):
        return math.inf
    from_mean = values - mean
    variance = float(np.dot(from_mean, from_mean)) / values.size
    return math.sqrt(variance) if math.isfinite(variance) else math.inf


def interval_of(values: np.ndarray, coverage: float) -> tuple[float, float]:
    """Return the interval of draws that leaves out as much below as above."""
    probabilities = 0.5 - 0.5 * coverage, 0.5 + 0.5 * coverage
    places = [(values.size - 1) * p for p in probabilities]
    edges = [int(place) for place in places]
    ends = sorted({min(edge + step, values.size - 1) for edge in edges for step in (0, 1)})
    ordered = np.partition(values, ends)
    quantiles = []
    for place, edge in zip(places, edges, strict=True):
        low, high = float(ordered[edge]), float(ordered[min(edge + 1, values.size - 1)])
        quantiles.append(low if low == high else low + (place - edge) * (high - low))
    return quantiles[0], quantiles[1]


def flow_ratio(flow: np.ndarray, capacity: Any) -> np.ndarray:
    """Return the share of the pump's flow; infinite where the pump delivers nothing."""
    with np.errstate(divide="ignore", invalid="ignore"):
        share = flow / capacity
    return share if np.all(capacity) else np.where(np.isnan(share), np.inf, share)


#: Of each dimension after the first: degree and coefficients of its polynomial, and the first direction numbers
#: (Joe & Kuo, SIAM J. Sci. Comput. 30, 2008, the set "new-joe-kuo-6").
_JOE_KUO: tuple[tuple[int, int, tuple[int, ...]], ...] = (
    (1, 0, (1,)),
    (2, 1, (1, 3)),
    (3, 1, (1, 3, 1)),
    (3, 2, (1, 1, 1)),
    (4, 1, (1, 1, 3, 3)),
    (4, 4, (1, 3, 5, 13)),
    (5, 2, (1, 1, 5, 5, 17)),
    (5, 4, (1, 1, 5, 5, 5)),
    (5, 7, (1, 1, 7, 11, 19)),
    (5, 11, (1, 1, 5, 1, 1)),
    (5, 13, (1, 1, 1, 3, 11)),
    (5, 14, (1, 3, 5, 5, 31)),
    (6, 1, (1, 3, 3, 9, 7, 49)),
    (6, 13, (1, 1, 1, 15, 21, 21)),
    (6, 16, (1, 3, 1, 13, 27, 49)),
)
DIMENSIONS = len(_JOE_KUO) + 1
_TOGETHER = 128  # draws of about the same score, a power of two


@lru_cache(maxsize=8)
def directions(bits: int) -> np.ndarray:
    """Return Sobol's direction numbers, shape (DIMENSIONS, bits), of points with so many binary digits."""
    numbers = np.empty((DIMENSIONS, bits), np.int64)
    numbers[0] = [1 << (bits - 1 - k) for k in range(bits)]
    for row, (degree, coefficients, first) in zip(numbers[1:], _JOE_KUO, strict=True):
        odd = list(first[:bits])
        for k in range(degree, bits):
            number = odd[k - degree] ^ (odd[k - degree] << degree)
            for j in range(1, degree):
                if coefficients >> (degree - 1 - j) & 1:
                    number ^= odd[k - j] << j
            odd.append(number)
        row[:] = [number << (bits - 1 - k) for k, number in enumerate(odd)]
    numbers.flags.writeable = False
    return numbers


def _scrambled(bits: int, stream: np.random.Generator) -> np.ndarray:
    """Return the scrambled points as whole numbers below 2^bits, shape (DIMENSIONS, 2^bits)."""
    plain = directions(bits)
    unit = 1 << np.arange(bits - 1, -1, -1)
    columns = unit + stream.integers(0, unit, size=(DIMENSIONS, bits))  # of a triangular matrix of each dimension
    digits = plain[:, :, None] & unit != 0
    turned = np.bitwise_xor.reduce(np.where(digits, columns[:, None, :], 0), axis=2).astype(np.uint32)
    points = np.empty((DIMENSIONS, 1 << bits), np.uint32)
    points[:, 0] = stream.integers(0, 1 << bits, size=DIMENSIONS)
    for k in range(bits):
        np.bitwise_xor(points[:, : 1 << k], turned[:, k, None], out=points[:, 1 << k : 2 << k])
    return points


@lru_cache(maxsize=8)
def _uniform(bits: int) -> np.ndarray:
    """Return the middles of 2^bits equal parts of 0 … 1."""
    return (np.arange(1 << bits) + 0.5) / (1 << bits)


@lru_cache(maxsize=8)
def _normal(bits: int) -> np.ndarray:
    """Return the normal quantiles of the same."""
    upper = normal_quantile(_uniform(bits)[1 << (bits - 1) :])
    return np.concatenate([-upper[::-1], upper])


class Cube:
    """Points of one cube, from whose dimensions quantities are drawn; ``draws`` is a power of two."""

    def __init__(self, draws: int, *seed: int) -> None:
        self.draws = draws
        self._bits = draws.bit_length() - 1
        self._points = _scrambled(self._bits, stream_of(*seed))
        self._kept: dict[Hashable, np.ndarray] = {}

    def ranks(self, dimension: int) -> np.ndarray:
        """Return the whole numbers below ``draws``, each once: the place of every point in a dimension."""
        return self._points[dimension]

    def values(self, dimension: int, name: Hashable, table: Callable[[int], np.ndarray]) -> np.ndarray:
        """Return a dimension's values, looked up by the points' ranks in a table; kept by name."""
        key = dimension, name
        if key not in self._kept:
            self._kept[key] = table(self._bits)[self._points[dimension]]
        return self._kept[key]


class Draws:
    """One quantity after the other, drawn from the dimensions of a cube; shape (draws,)."""

    def __init__(self, cube: Cube, order: np.ndarray | None = None, first: int = 0) -> None:
        """Go through a cube in an order, that of its points unless given, from a first dimension on."""
        self._cube, self._order, self._next = cube, order, first

    def onward_from(self, dimension: int) -> Draws:
        """Return the draws of the same points from another dimension on, whatever was drawn before it."""
        return Draws(self._cube, self._order, dimension)

    def _values(self, name: Hashable, table: Callable[[int], np.ndarray]) -> np.ndarray:
        values = self._cube.values(self._next, name, table)
        self._next += 1
        return values.copy() if self._order is None else values.take(self._order)

    def among(self, name: Hashable, functions: Callable[[np.ndarray], Any], which: np.ndarray) -> np.ndarray:
        """Draw one or another function of a number from 0 … 1.

        ``functions`` returns the values of each in a column, and ``which`` says the column that counts in each draw.
        """
        values = self._cube.values(self._next, name, lambda bits: functions(_uniform(bits)))
        self._next += 1
        order = np.arange(which.size) if self._order is None else self._order
        return values.ravel().take(order * values.shape[1] + which)

    def normal(self) -> np.ndarray:
        """Draw from the standard normal distribution."""
        return self._values("normal", _normal)

    def uniform(self) -> np.ndarray:
        """Draw from 0 … 1, any value alike likely."""
        return self._values("uniform", _uniform)

    def rectangular(self) -> np.ndarray:
        """Draw from a rectangular distribution of unit standard deviation about zero."""
        return self._values("rectangular", lambda bits: (_uniform(bits) - 0.5) * math.sqrt(12.0))

    def of_uniform(self, name: Hashable, function: Callable[[np.ndarray], Any]) -> np.ndarray:
        """Draw a function of a number from 0 … 1; a function of the same name is computed once for a cube."""
        return self._values(name, lambda bits: function(_uniform(bits)))


class Beside:
    """Draws of many, all from one cube and each in an order of its own, beside others that are drawn already.

    What is drawn already has a score in every draw. The first dimension of the cube stands for its rank, so that with
    any score the points spread evenly over the other dimensions; among some draws of about the same score each order
    is a random one.
    """

    def __init__(self, cube: Cube, score: np.ndarray) -> None:
        self._cube = cube
        self._by_score = np.argsort(score, kind="stable")
        together = min(_TOGETHER, cube.draws)
        self._points = np.argsort(cube.ranks(0)).reshape(-1, together)

    def draws(self, *seed: int) -> Draws:
        """Return the draws of one of them; independent of all others but for the score."""
        order = np.empty(self._cube.draws, np.intp)
        order[self._by_score] = stream_of(*seed).permuted(self._points, axis=1).ravel()
        return Draws(self._cube, order, first=1)


def rounded_up(draws: int) -> int:
    """Return the power of two that is a number of draws, or the next one."""
    return 1 << (draws - 1).bit_length()


def stream_of(*seed: int) -> np.random.Generator:
    """Return the random numbers of a seed: the same ones each time."""
    return np.random.Generator(np.random.PCG64(np.random.SeedSequence(seed)))
