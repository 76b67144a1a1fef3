"""Say how likely a land has worn past a limit where what the pair was when new is known as a range only.

The lands of one unit ran in the same fluid over the same way: how many of them are worn, and by how much, is learned
from all that were measured, and counts for each.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from atleak.catalogue.limits import Steps
from atleak.catalogue.repairs import LandKey
from atleak.diagnosis.uncertainty.assumptions import Assumptions
from atleak.diagnosis.uncertainty.sources import LandSources
from atleak.equations.statistics import normal_cdf, probability_over

_PLACES = (np.arange(32) + 0.5) / 32.0  # in the range of new pairs
_MEANS = np.geomspace(0.25, 4.0, 9)  # of a unit's wear, over the usual one, alike likely
_WORN = (np.arange(20) + 0.5) / 20.0  # part of a worn unit's lands that are worn
_FINEST = 0.05e-6  # [m] no reading is surer
_NOTHING = 1e-300


def probabilities_worn(
    lands: Sequence[LandSources], steps: Steps, assumptions: Assumptions
) -> Mapping[LandKey, tuple[float, ...]]:
    """Return how likely each land of whose new clearance a range is known has grown past each limit of wear.

    Parameters
    ----------
    lands
        of one unit; those that were measured tell how it is worn.
    steps
        limits of wear, as of `Limits.wear`.
    assumptions
        how many lands are usually worn, and by how much.

    Returns
    -------
    Mapping
        by land, one probability for each level.

    Notes
    -----
    A pair was new anywhere in its range alike likely, c_m; its reading is normal about c_m + w. A unit is unworn
    throughout, or a part p of its lands is worn, of density 2p, exponentially with a mean that all its lands share, of
    density 1/mean. A land's own probability and the unit's follow from Bayes' rule over a grid of p and mean. No less
    is said than of a pair that was as wide as the range allows.
    """
    measured = [land for land in lands if land.state.measured and not land.state.land.seal]
    if not any(len(set(land.state.land.mounting_range)) == 2 for land in measured):
        return {}
    ends = np.array([land.state.land.mounting_range for land in measured])
    step = (ends[:, 1] - ends[:, 0]) / len(_PLACES)
    known = [0.0 if width else land.u_mounting for land, width in zip(measured, step, strict=True)]
    u = np.sqrt(np.square([land.standard_uncertainty for land in measured]) + np.square(known) + step**2 / 12.0)
    u = np.maximum(u, _FINEST)[:, None]
    new = ends[:, :1] + len(_PLACES) * step[:, None] * _PLACES
    past = np.array([[land.state.radial_clearance] for land in measured]) - new
    unworn = np.exp(-0.5 * (past / u) ** 2).mean(axis=1) / (np.sqrt(2.0 * np.pi) * u[:, 0])
    means = assumptions.land_wear * _MEANS
    worn = _worn(past, u, means, 0.0)

    whole = max(1.0 - 1.5 * assumptions.worn_lands, 0.0)  # chance of a unit without wear: so many lands are worn in all
    part = np.concatenate(([0.0], _WORN))
    prior = np.concatenate(([whole], (1.0 - whole) * _WORN / _WORN.sum()))
    # by land, mean and part
    density = (1.0 - part) * unworn[:, None, None] + part * worn[:, :, None] + _NOTHING
    of_unit = np.log(density).sum(axis=0) + np.log(prior + _NOTHING)
    of_unit = np.exp(of_unit - of_unit.max())
    of_unit /= of_unit.sum()

    found = {}
    for row, land in enumerate(measured):
        if step[row] > 0.0:
            limits = np.array([[limit * each for _, limit in steps.of_wear(each)] for each in new[row].tolist()]).T
            high = ends[row, 1]
            at_least = probability_over(
                land.state.radial_clearance - high,
                [limit * high for _, limit in steps.of_wear(high)],
                land.standard_uncertainty,
            )
            over = [_worn(past[row : row + 1], u[row : row + 1], means, least)[0] for least in limits]
            likely = [float(np.sum(of_unit * part * each[:, None] / density[row])) for each in over]
            found[land.key] = tuple(np.maximum(likely, at_least).clip(0.0, 1.0).tolist())
    return found


def _worn(past: np.ndarray, u: np.ndarray, means: np.ndarray, least: np.ndarray | float) -> np.ndarray:
    """Return the density of a reading of lands that are worn by ``least`` or more, by land and mean [1/m].

    The integral over w from ``least`` of e^(−w/mean)/mean times the normal density of ``past`` − w, averaged over
    where the pair was new.
    """
    mean = np.maximum(means[:, None, None], 0.25 * u)  # by mean, land and place
    exponent = np.minimum(0.5 * (u / mean) ** 2 - past / mean, 700.0)
    tail = normal_cdf((past - least) / u - u / mean)
    return np.asarray((np.exp(exponent) * tail / mean).mean(axis=2).T)
