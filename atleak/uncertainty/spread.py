"""Say how draws of one quantity spread: its standard uncertainty, its interval, and how likely it is past limits."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

Interval = tuple[float, float]


@dataclass(frozen=True)
class Spread:
    """The standard uncertainty and the interval of one quantity, from its draws."""

    standard_uncertainty: float
    interval: Interval
    probabilities: tuple[float, ...]  # that the quantity has reached each of the limits
    level_uncertainties: tuple[float, ...]  # of the quantity over each limit, which may follow what was new


def spread_of(values: np.ndarray, limits: Sequence[Any], coverage: float, *, falling: bool = False) -> Spread:
    """Return how draws spread, shape (draws,); each limit is a number or has a value for each draw.

    ``falling`` limits are reached by what is under them.
    """
    reached = tuple(
        float(np.count_nonzero(values < limit if falling else values >= limit)) / values.size for limit in limits
    )
    u = _standard_deviation(values)
    finite = math.isfinite(u)
    return Spread(
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
