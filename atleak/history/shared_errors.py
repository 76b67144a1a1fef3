"""Say which errors of measuring the clearances of a unit have in common, over the lands of one visit.

Every clearance is uncertain by some errors that others share, each with the factor by which it acts on this one, and
by what it has alone. What all readings of an instrument share (its zero, its ring, its scale) and the temperature of
measuring are shared by the lands of one visit. Nothing is taken as the same at two visits: a job names a kind of
instrument, not the one gauge and its setting, and what is not known must be inside the intervals. Where the gauge was
the same after all, the intervals of rates are wider than they had to be. These are choices of this project.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Hashable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from atleak.uncertainty.sources import MEASURING_TEMPERATURE, LandSources

Factors = Mapping[Hashable, float]  # [m] by which one standard deviation of each shared error acts on a clearance


def factors_of(land: LandSources, visit: int) -> Factors:
    """Return the errors that a clearance shares with others; ``visit`` is its number among those of the unit."""
    factors: dict[Hashable, float] = defaultdict(float)
    for source in land.sources:
        if source.group == MEASURING_TEMPERATURE:
            factors[visit, MEASURING_TEMPERATURE] += source.standard_uncertainty
        elif source.group is not None and source.part is not None:
            factors[visit, source.group, land.instruments.of(source.part).id] += source.standard_uncertainty
    return dict(factors)


def covariance(points: Sequence[tuple[Factors, float]]) -> NDArray[np.float64]:
    """Return the covariance of clearances [m²], each with its shared errors and the variance that it has alone."""
    names = {name for factors, _ in points for name in factors}
    shared = np.array([[factors.get(name, 0.0) for name in names] for factors, _ in points])
    alone = np.diag([variance for _, variance in points])
    return alone + shared @ shared.T if names else alone
