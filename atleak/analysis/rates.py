"""What a number over many units rests on: a rate and a spread, each with how many units it is of."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from atleak.common.units import PERCENT
from atleak.equations.proportions import wilson_interval

ENOUGH_UNITS = 10  # from which on more is said than a count, a middle and the ends: choice of this project
SHOWN_QUANTILES = (0.05, 0.25, 0.5, 0.75, 0.95)  # of the units, whose quantiles are shown


@dataclass(frozen=True)
class Rate:
    """How many of some units something is true of, with the 95 % interval of the share of units (Wilson)."""

    count: int
    of: int
    low_percent: float | None  # None below `ENOUGH_UNITS` units: nothing is to be said beyond the count
    high_percent: float | None

    @property
    def percent(self) -> float | None:
        """Return the share of the units [%]; None of no unit."""
        return 100.0 * self.count / self.of if self.of else None

    @property
    def enough(self) -> bool:
        """Return whether there are enough units for an interval."""
        return self.of >= ENOUGH_UNITS

    @property
    def span(self) -> tuple[float, float] | None:
        """Return the 95 % interval of the share of the units [%]; None of too few units."""
        return None if self.low_percent is None or self.high_percent is None else (self.low_percent, self.high_percent)


@dataclass(frozen=True)
class Spread:
    """How a value is spread over units, each of them counted once; in the value's own unit."""

    units: int  # one or more
    mean: float
    least: float
    median: float
    most: float
    quantiles: tuple[float, ...] | None  # at `SHOWN_QUANTILES` of the units; None below `ENOUGH_UNITS` units

    @property
    def enough(self) -> bool:
        """Return whether there are enough units for quantiles."""
        return self.units >= ENOUGH_UNITS

    @property
    def most_of_all(self) -> tuple[float, float]:
        """Return between which values nine of ten units are; of too few units, all of them."""
        return (self.least, self.most) if self.quantiles is None else (self.quantiles[0], self.quantiles[-1])


def rate(count: int, of: int) -> Rate:
    """Return how many of some units something is true of, with the interval of their share."""
    if of < ENOUGH_UNITS:
        return Rate(int(count), int(of), None, None)
    low, high = wilson_interval(count, of)
    return Rate(int(count), int(of), low * PERCENT, high * PERCENT)


def spread(values: Iterable[float]) -> Spread | None:
    """Return how values are spread, those that are none left out; None where none is left.

    Between two units a quantile is interpolated, as numpy and spreadsheets do.
    """
    known = np.asarray(values, dtype=float)
    known = known[np.isfinite(known)]
    if not known.size:
        return None
    parts = tuple(map(float, np.quantile(known, SHOWN_QUANTILES))) if known.size >= ENOUGH_UNITS else None
    least, median, most = np.min(known), np.median(known), np.max(known)
    return Spread(known.size, float(known.mean()), float(least), float(median), float(most), parts)
