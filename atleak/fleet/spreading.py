"""Count and spread values over units, with intervals where there are enough of them."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from atleak.equations.proportions import wilson_interval
from atleak.spreads import ENOUGH_UNITS, PARTS, Rate, Spread
from atleak.workshop_units import PERCENT


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
    parts = tuple(map(float, np.quantile(known, PARTS))) if known.size >= ENOUGH_UNITS else None
    least, median, most = np.min(known), np.median(known), np.max(known)
    return Spread(known.size, float(known.mean()), float(least), float(median), float(most), parts)
