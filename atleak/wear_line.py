"""Lay a straight line through clearances over mileage, with what measuring leaves open of it, and see where it leads.

That a clearance grows in proportion to mileage is an assumption of this project: wear accelerates with contaminated
fluid. A line through more than two points shows where it does not hold.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from atleak.equations.uncertainty import normal_quantile

COVERAGE = 0.90  # of the intervals of rates and of mileages
FARTHEST = 1.0e6  # [km] beyond which nobody foresees a repair: choice of this project
_LEAST = 1e-12  # [m] that a clearance is uncertain at least: without any error a weight would be infinite
_LEAST_WAY = 1.0  # [km] over which a rate can be told at all: a choice of this project
_BENT = 0.99  # probability that the points of a straight line scatter less than those of one called bent


@dataclass(frozen=True)
class Crossing:
    """The mileage [km] at which a limit is reached: its median and its interval.

    The vehicle has not come there yet, so none of them is before ``present``, its mileage now.
    """

    value: float  # infinite where the limit is never reached
    low: float
    high: float  # infinite where the limit may never be reached
    present: float

    @property
    def foreseeable(self) -> bool:
        """Return whether the interval ends within what a vehicle runs."""
        return self.high <= FARTHEST

    @property
    def not_before(self) -> float | None:
        """Return the mileage up to which it is not reached, where no more can be told; None where that is no later."""
        least = min(self.low, FARTHEST)
        return None if self.foreseeable or least <= self.present else least


@dataclass(frozen=True)
class WearLine:
    """A clearance that grows in a straight line: what it is at some mileage, and its rate, both normal."""

    origin: float  # [km] at which it is ``clearance``
    clearance: float  # [m]
    rate: float  # [m/km]
    covariance: NDArray[np.float64]  # of both
    weights: NDArray[np.float64]  # by which both follow from the points, shape (2, points)
    scatter: float  # by which the points scatter more than measuring explains; 1 where they do not

    @property
    def straight(self) -> bool:
        """Return whether the points may lie on a straight line, as far as measuring tells."""
        return self.scatter == 1.0

    def at(self, mileage: float) -> float:
        """Return the clearance at a mileage [m]."""
        return self.clearance + self.rate * (mileage - self.origin)

    def uncertainty_at(self, mileage: float) -> float:
        """Return the standard uncertainty of that [m]."""
        way = np.array([1.0, mileage - self.origin])
        return math.sqrt(max(float(way @ self.covariance @ way), 0.0))

    def band(self, mileage: float, coverage: float = COVERAGE) -> tuple[float, float]:
        """Return the interval of the clearance at a mileage [m]."""
        reach = _deviate(coverage) * self.uncertainty_at(mileage)
        return self.at(mileage) - reach, self.at(mileage) + reach

    def rate_interval(self, coverage: float = COVERAGE) -> tuple[float, float]:
        """Return the interval of the rate [m/km]."""
        reach = _deviate(coverage) * math.sqrt(float(self.covariance[1, 1]))
        return self.rate - reach, self.rate + reach

    @property
    def certain(self) -> bool:
        """Return whether wear can be told from measurement: the interval of the rate is above zero."""
        return self.rate_interval()[0] > 0.0

    def reaches(self, limit: float, present: float, coverage: float = COVERAGE) -> Crossing:
        """Return the mileage at which the clearance reaches a limit [m].

        Parameters
        ----------
        present
            mileage of the vehicle [km], before which it has not happened.

        Notes
        -----
        The limit is passed by a mileage with the probability that the clearance there is above it, which is normal: no
        ratio of two uncertain values is drawn. So the interval ends where the band of the line crosses the limit
        (Fieller, J. R. Stat. Soc. B 16 (1954) 175-185).
        """
        z = _deviate(coverage)
        most, least = (self._crosses(limit, present, deviate) for deviate in (z, -z))
        return Crossing(self._crosses(limit, present, 0.0), most, least if self.certain else math.inf, present)

    def _crosses(self, limit: float, present: float, deviate: float) -> float:
        """Return from which mileage the line, or the edge of its band so many deviations above it, is past a limit."""
        clearance, u = self.at(present), self.uncertainty_at(present)
        if clearance + deviate * u >= limit:
            return present
        (_, of_both), (_, of_rate) = (deviate * deviate * self.covariance).tolist()
        past, way = clearance - limit, present - self.origin
        if deviate == 0.0:
            return present - past / self.rate if self.rate > 0.0 else math.inf
        # (past + rate·x)² = z² u(x)², with x the way from the present mileage on
        square = self.rate**2 - of_rate
        linear = 2.0 * (self.rate * past - of_both - of_rate * way)
        constant = past**2 - (deviate * u) ** 2
        ways = (x for x in _roots(square, linear, constant) if x > 0.0 and (past + self.rate * x) * deviate <= 0.0)
        return present + min(ways, default=math.inf)


def wear_line(
    mileages: Sequence[float], clearances: Sequence[float], covariance: NDArray[np.float64]
) -> WearLine | None:
    """Return the straight line that explains clearances best; None where all mileages are within a kilometre.

    Parameters
    ----------
    mileages, clearances
        of every point [km, m].
    covariance
        of the errors of the clearances [m²], shape (points, points): an error that points share tells no rate.

    Notes
    -----
    The weighted mean with the least variance, for errors that are not independent. Points that scatter more than
    measuring explains, with a probability of less than 1 %, widen all its uncertainties by as much.

    References
    ----------
    Aitken A. C., Proc. R. Soc. Edinburgh 55 (1936) 42-48; Birge R. T., Phys. Rev. 40 (1932) 207-227.
    """
    x, y = np.asarray(mileages, float), np.asarray(clearances, float)
    if x.size < 2 or np.ptp(x) < _LEAST_WAY:
        return None
    origin = float(x[-1])
    design = np.column_stack([np.ones(x.size), x - origin])
    weight = np.linalg.inv(np.asarray(covariance, float) + _LEAST**2 * np.eye(x.size))
    scale = np.array([1.0, 1.0 / max(float(np.ptp(x)), 1.0)])  # of both unknowns: one is a million times the other
    scaled = design * scale
    of_both = np.linalg.inv(scaled.T @ weight @ scaled) * np.outer(scale, scale)
    weights = of_both @ design.T @ weight
    clearance, rate = weights @ y
    residual = y - design @ (clearance, rate)
    scatter = _scatter(float(residual @ weight @ residual), x.size - 2)
    return WearLine(origin, float(clearance), float(rate), scatter**2 * of_both, weights, scatter)


def _scatter(squares: float, degrees: int) -> float:
    """Return how much wider than measuring explains the points scatter: 1 where that may be chance."""
    if degrees < 1:
        return 1.0
    # the chi-square's quantile: Wilson and Hilferty, Proc. Natl. Acad. Sci. 17 (1931) 684-688
    part = 2.0 / (9.0 * degrees)
    most = degrees * (1.0 - part + float(normal_quantile(_BENT)) * math.sqrt(part)) ** 3
    return math.sqrt(squares / degrees) if squares > most else 1.0


def _deviate(coverage: float) -> float:
    return float(normal_quantile(0.5 + 0.5 * coverage))


def _roots(square: float, linear: float, constant: float) -> tuple[float, ...]:
    """Return the real roots of a quadratic, or of the straight line that it may be."""
    if square == 0.0:
        return (-constant / linear,) if linear else ()
    within = linear * linear - 4.0 * square * constant
    if within < 0.0:
        return ()
    far = -0.5 * (linear + math.copysign(math.sqrt(within), linear))
    return (far / square, constant / far) if far else (0.0,)
