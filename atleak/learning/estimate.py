"""Estimate the clearance of new pairs of every land from several units, its uncertainty and the spread of pairs.

A pair's clearance is that of its type, plus what its unit's lands have in common, plus its own deviation, plus the
error of its measurement: a two-way analysis of variance with random units. Variances are pooled over all lands, and
their degrees of freedom follow Welch and Satterthwaite: two units whose lands all differ by the same amount tell as
much as two values, not as sixty.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from atleak.learning.outliers import Mask, Table, prior_degrees


@dataclass(frozen=True)
class Estimate:
    """What the kept pairs tell of each land; NaN where none was kept."""

    clearance: NDArray[np.float64]  # [m] their mean
    pairs: NDArray[np.int_]
    standard_error: NDArray[np.float64]  # [m] of the mean, from the scatter of units and of readings
    degrees: NDArray[np.float64]  # of freedom of that scatter; infinite where only the readings' own error is known
    spread: NDArray[np.float64]  # [m] standard deviation between new pairs, measurement taken off; NaN for one unit
    unresolved: NDArray[np.float64]  # [m] the largest of that and of what the readings could hide of it; NaN likewise
    spread_degrees: NDArray[np.float64]  # of freedom of the unresolved spread, which are fewer
    measurement: NDArray[np.float64]  # [m] standard uncertainty of one unit's clearance that units do not share


def estimate(clearances: Table, own: Table, kept: Mask) -> Estimate:
    """Return the estimate of every land.

    Parameters
    ----------
    clearances
        radial clearances [m], a row for each unit and a column for each land.
    own
        standard uncertainty of each that the units do not share [m].
    kept
        the pairs that count.
    """
    pairs = kept.sum(axis=0)
    some = np.maximum(pairs, 1)
    there = pairs > 0
    mean = np.where(there, np.where(kept, clearances, 0.0).sum(axis=0) / some, np.nan)
    noise = np.where(there, np.where(kept, own**2, 0.0).sum(axis=0) / some, np.nan)  # [m²]
    residual = np.where(kept, clearances - mean, 0.0)
    free = np.maximum(pairs - 1, 0)
    if not free.any():
        unknown = np.full(mean.shape, np.nan)
        endless = np.full(mean.shape, math.inf)
        return Estimate(mean, pairs, np.sqrt(noise), endless, unknown, unknown, unknown, np.sqrt(noise))
    pooled, pooled_degrees = _pooled(residual, kept, free)
    squares = (residual**2).sum(axis=0)
    prior = prior_degrees(squares, free.astype(float))
    if math.isinf(prior):
        variance, degrees = np.full(mean.shape, pooled), np.full(mean.shape, pooled_degrees)
    else:
        variance = (prior * pooled + squares) / (prior + free)
        degrees = np.minimum(prior + free, pooled_degrees)
    # no readings agree better, in the long run, than they can be read
    total = np.maximum(variance, noise)
    between = np.maximum(variance - noise, 0.0)
    unresolved = np.maximum(between, variance * np.sqrt(2.0 / degrees))  # no less than a variance's standard error
    return Estimate(
        clearance=mean,
        pairs=pairs,
        standard_error=np.where(there, np.sqrt(total / some), np.nan),
        degrees=np.maximum(degrees, 1.0),
        spread=np.where(there, np.sqrt(between), np.nan),
        unresolved=np.where(there, np.sqrt(unresolved), np.nan),
        spread_degrees=np.maximum(degrees * (unresolved / np.where(variance > 0.0, variance, 1.0)) ** 2, 1.0),
        measurement=np.sqrt(noise),
    )


def _pooled(residual: Table, kept: Mask, free: NDArray[np.int_]) -> tuple[float, float]:
    """Return the variance of one pair among units [m²], pooled over lands, and its degrees of freedom."""
    measured = kept.sum(axis=1)
    units = int((measured > 0).sum())
    lands = float(kept.sum()) / units  # of a unit, on average
    shift = residual.sum(axis=1) / np.maximum(measured, 1)
    of_units = float((measured * shift**2).sum()) / (units - 1)
    rest = max(float(free.sum()) - (units - 1), 1.0)
    of_rest = float(np.where(kept, (residual - shift[:, None]) ** 2, 0.0).sum()) / rest
    parts = of_units / lands, (1.0 - 1.0 / lands) * of_rest
    variance = sum(parts)
    if variance <= 0.0:
        return 0.0, rest + units - 1.0
    return variance, variance**2 / (parts[0] ** 2 / (units - 1) + parts[1] ** 2 / rest)
