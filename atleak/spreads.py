"""What a number over many units rests on: a rate and a spread, each with how many units it is of."""

from __future__ import annotations

from dataclasses import dataclass

ENOUGH_UNITS = 10  # from which on more is said than a count, a middle and the ends: choice of this project
PARTS = (0.05, 0.25, 0.5, 0.75, 0.95)  # of the units, whose quantiles are shown


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


@dataclass(frozen=True)
class Spread:
    """How a value is spread over units, each of them counted once; in the value's own unit."""

    units: int  # one or more
    mean: float
    least: float
    median: float
    most: float
    quantiles: tuple[float, ...] | None  # at `PARTS` of the units; None below `ENOUGH_UNITS` units

    @property
    def enough(self) -> bool:
        """Return whether there are enough units for quantiles."""
        return self.units >= ENOUGH_UNITS
