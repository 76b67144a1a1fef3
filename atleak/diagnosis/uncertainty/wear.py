"""Say how likely a land has worn past a limit where what the pair was when new is known as a range only.

The lands of one unit ran in the same fluid over the same way: how many of them are worn, and by how much, is learned
from all that were measured, and counts for each.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from atleak.catalogue.limits import Steps
from atleak.catalogue.repairs import LandKey
from atleak.diagnosis.uncertainty.assumptions import Assumptions
from atleak.diagnosis.uncertainty.sources import LandSources
from atleak.equations.statistics import normal_cdf, probability_over

_PLACES = (np.arange(32) + 0.5) / 32.0  # in the range of new pairs
_MEANS = 4.0 ** (
    2.0 * (np.arange(9) + 0.5) / 9.0 - 1.0
)  # of the wear of a unit's lands, over the usual one, alike likely
_WORN = (np.arange(20) + 0.5) / 20.0  # part of a worn unit's lands that are worn
_FINEST = 0.05e-6  # [m] no reading is surer
_NOTHING = 1e-300


class UnitWear:
    """How many lands of a unit are worn and by how much, as its measured lands show together.

    A pair was new anywhere in its range alike likely, at c_m; its reading is normal about c_m + w. A unit is unworn
    throughout, or a part p of its lands is worn, of density 4p³, exponentially with a mean that all its lands share, of
    density 1/mean. A land's own probability and the unit's follow from Bayes' rule over a grid of p and mean.
    """

    def __init__(self, lands: Iterable[LandSources], assumptions: Assumptions) -> None:
        """Take the lands of one unit, and how many lands are usually worn, and by how much."""
        self._lands = [land for land in lands if land.state.shows_wear and not land.state.land.seal]
        ends = np.array([land.state.land.mounting_range for land in self._lands]).reshape(-1, 2)
        step = (ends[:, 1:] - ends[:, :1]) / len(_PLACES)
        known = np.array([[land.u_mounting] for land in self._lands]).reshape(-1, 1)
        readings = [[land.state.radial_clearance, land.standard_uncertainty] for land in self._lands]
        clearance, u = np.array(readings).reshape(-1, 2, 1).swapaxes(0, 1)
        variance = u**2 + np.where(step > 0.0, step**2 / 12.0, known**2)
        self._u = np.maximum(np.sqrt(variance), _FINEST)
        self._new = ends[:, :1] + len(_PLACES) * step * _PLACES
        self._past = clearance - self._new
        self._means = assumptions.land_wear * _MEANS
        whole = max(1.0 - 1.25 * assumptions.worn_lands, 0.0)  # chance of no wear: so many lands are worn in all
        self._part = np.concatenate(([0.0], _WORN))
        prior = np.concatenate(([whole], (1.0 - whole) * _WORN**3 / np.sum(_WORN**3)))
        unworn = np.exp(-0.5 * (self._past / self._u) ** 2).mean(axis=1) / (np.sqrt(2.0 * np.pi) * self._u[:, 0])
        worn = _worn(self._past, self._u, self._means, 0.0)
        # by land, mean and part
        self._density = (1.0 - self._part) * unworn[:, None, None] + self._part * worn[:, :, None] + _NOTHING
        told = np.log(self._density).sum(axis=0) + np.log(prior + _NOTHING)
        told = np.exp(told - told.max())
        self._told = told / told.sum()

    @property
    def usual(self) -> tuple[float, float]:
        """Return which part of its lands is worn, and how far on average [m]."""
        part = self._told * self._part
        chance = float(part.sum())
        return chance, float(part.sum(axis=1) @ self._means) / max(chance, _NOTHING)

    def past(self, steps: Steps) -> Mapping[LandKey, tuple[float, ...]]:
        """Return how likely each land of which a range is known when new has grown past each limit of wear.

        No less is said than of a pair that was as wide as the range allows.

        Returns
        -------
        Mapping
            by land, one probability for each level.
        """
        found = {}
        for row, land in enumerate(self._lands):
            low, high = land.state.land.mounting_range
            if low < high:
                limits = np.array([[limit * c for _, limit in steps.of_wear(c)] for c in self._new[row].tolist()]).T
                widest = [limit * high for _, limit in steps.of_wear(high)]
                least = probability_over(land.state.radial_clearance - high, widest, land.standard_uncertainty)
                this = slice(row, row + 1)
                over = [_worn(self._past[this], self._u[this], self._means, each)[0] for each in limits]
                weights = self._told * self._part / self._density[row]
                likely = [float(np.sum(weights * each[:, None])) for each in over]
                found[land.key] = tuple(np.maximum(likely, least).clip(0.0, 1.0).tolist())
        return found


def new_before(
    now: np.ndarray, mounting_range: tuple[float, float], usual: tuple[float, float], uniform: np.ndarray
) -> np.ndarray:
    """Return what a pair was when new that is so wide now [m]: as wide, or narrower and worn since.

    Parameters
    ----------
    now
        its clearance [m], shape (draws,).
    mounting_range
        of new pairs [m].
    usual
        which part of the unit's lands is worn, and how far on average [m], as `UnitWear.usual` says.
    uniform
        a number from 0 … 1 for each draw.
    """
    (low, high), (chance, mean) = mounting_range, usual
    mean = max(mean, _FINEST)
    ways = np.clip(now, low, high) - low  # from where it may have worn
    by_wear = -chance * np.expm1(-ways / mean)
    worn = np.where(now > high, 1.0, by_wear / np.maximum(by_wear + 1.0 - chance, _NOTHING))
    new = low + mean * np.log1p(np.minimum(uniform / np.maximum(worn, _NOTHING), 1.0) * np.expm1(ways / mean))
    return np.where(uniform < worn, new, now)


def _worn(past: np.ndarray, u: np.ndarray, means: np.ndarray, least: np.ndarray | float) -> np.ndarray:
    """Return the density of a reading of lands that are worn by ``least`` or more, by land and mean [1/m].

    The integral over w from ``least`` of e^(−w/mean)/mean times the normal density of ``past`` − w, averaged over
    where the pair was new.
    """
    mean = np.maximum(means[:, None, None], 0.25 * u)  # by mean, land and place
    exponent = np.minimum(0.5 * (u / mean) ** 2 - past / mean, 700.0)
    tail = normal_cdf((past - least) / u - u / mean)
    return np.asarray((np.exp(exponent) * tail / mean).mean(axis=2).T)
