"""Foresee the mileage at which a land reaches the limit of wear for replacing, wear growing with mileage."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from atleak.catalogue.limits import RuleKind
from atleak.engine.projection import mileage_at_wear
from atleak.rules import Rule
from atleak.uncertainty import LandUncertainty
from atleak.verdicts import Verdict

FARTHEST = 1.0e6  # [km] beyond which nobody foresees a repair: choice of this project


@dataclass(frozen=True)
class ReplaceMileage:
    """The mileage [km] at which the wear limit for replacing is reached, wear ∝ mileage, with its 95 % interval.

    The vehicle has not come there yet, so the interval begins at its mileage at the earliest.
    """

    value: float | None  # None where it cannot be told whether the land wears at all
    low: float  # infinite where the land does not wear
    high: float  # infinite where the limit may never be reached

    @property
    def foreseeable(self) -> bool:
        """Return whether the interval ends within what a vehicle runs."""
        return self.high <= FARTHEST


def replace_mileage(
    rules: Iterable[Rule], mileage: float | None, uncertainty: LandUncertainty | None
) -> ReplaceMileage | None:
    """Return the mileage at which a land reaches the wear limit; None where it is unknown, or passed."""
    rule = next((rule for rule in rules if rule.kind is RuleKind.WEAR), None)
    if rule is None or mileage is None or uncertainty is None or uncertainty.wear_interval is None:
        return None
    limit = rule.steps.limit_of(Verdict.REPLACE) or rule.steps.levels[-1][1]

    def reached_with(wear: float) -> float:
        reached = mileage_at_wear(mileage, wear, limit)
        return math.inf if reached is None else reached

    least, most = uncertainty.wear_interval
    if reached_with(rule.value) <= mileage:
        return None
    low, high = max(reached_with(most), mileage), reached_with(least)
    return ReplaceMileage(reached_with(rule.value) if math.isfinite(high) else None, low, high)
