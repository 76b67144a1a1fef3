"""Simulated units of groups that differ, or do not, in what they are said to: wear grows with mileage and is skewed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pandas as pd

from atleak.common.verdicts import VERDICTS
from atleak.fleet.counts import Lands
from atleak.fleet.groups import compared

LANDS = 47
_LIMITS = (45.0, 70.0, 110.0)  # [%] of wear: watch, replace, critical


class Called(NamedTuple):
    """What a comparison calls a difference."""

    rates: list[bool]
    wear: list[bool]
    same_mileage: list[bool]

    @property
    def any(self) -> bool:
        return any((*self.rates, *self.wear, *self.same_mileage))


def called(
    random: np.random.Generator,
    units: Sequence[int],
    *,
    worse: float = 0.0,
    worse_lands: int = LANDS,
    further: float = 0.0,
    shuffles: int = 199,
) -> Called:
    """What is called of groups of so many units, the first worn by so many points more, or driven so much further."""
    of_units, lands = simulated(random, units, worse=worse, worse_lands=worse_lands, further=further)
    comparison = compared(of_units, lands, shuffles=shuffles)
    assert comparison is not None
    return Called(
        [bool(each.points.differs) for each in comparison.verdicts if each.points],
        [bool(each.mean_points.differs) for each in comparison.lands if each.mean_points],
        [bool(each.same_mileage_points.differs) for each in comparison.lands if each.same_mileage_points],
    )


def simulated(
    random: np.random.Generator,
    units: Sequence[int],
    *,
    worse: float = 0.0,
    worse_lands: int = LANDS,
    further: float = 0.0,
) -> tuple[pd.DataFrame, Lands]:
    """Units and their lands: every land wears at a rate of its own, every unit by a factor of its own."""
    label = np.repeat([f"g{number}" for number in range(len(units))], units)
    number, is_first = len(label), label == "g0"
    mileage = random.uniform(20e3, 320e3, number) + further * is_first
    rate = np.random.default_rng(5).uniform(2.0, 25.0, LANDS)  # [%] per 100 000 km
    scatter = random.lognormal(0.0, 0.25, (number, 1)) * random.lognormal(0.0, 0.4, (number, LANDS))
    wear = mileage[:, None] / 1e5 * rate * scatter
    wear[:, :worse_lands] += worse * is_first[:, None]
    wear[random.random(wear.shape) < 0.02] = np.nan
    rank = np.where(np.isnan(wear), 0, 1 + np.searchsorted(_LIMITS, np.nan_to_num(wear), side="right"))
    of_units = pd.DataFrame(
        {
            "label": label,
            "mileage_km": np.where(random.random(number) < 0.05, np.nan, mileage),
            "verdict": [str(VERDICTS[worst]) for worst in rank.max(axis=1)],
            "decision": "pass",
            "provisional": False,
            "by_lands": True,
            "lands_measured": LANDS,
            "lands_total": LANDS,
        }
    )
    keys = tuple((str(land), 1) for land in range(LANDS))
    return of_units, Lands(keys, ~np.isnan(wear), rank, np.zeros(wear.shape, bool), wear)
