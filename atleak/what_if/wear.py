"""Let the lands of a unit wear further, or bring them back to new."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from atleak.catalogue.controller import Land
from atleak.engine.leakage import Clearance
from atleak.readings import LandClearance


@dataclass(frozen=True)
class TriedClearance:
    """The clearance of a land as it is tried; arrays of one shape where several wears are."""

    land: Land
    spool_diameter: float  # [m]: the bore wears, the spool keeps its diameter
    radial_clearance: Any  # [m], cold, the mean
    form_moments: tuple[Any, Any]  # [m²], [m³]

    @property
    def sleeve_diameter(self) -> Any:
        """Return the diameter of the worn bore [m]."""
        return self.spool_diameter + 2.0 * self.radial_clearance


def measured_growth(state: LandClearance) -> float:
    """Return by how much a land's clearance has grown over what it may have been when new [m].

    A reading within what new pairs have is no growth; a land that nobody measured, or that is tighter than new, has
    none.
    """
    return max(state.radial_clearance - float(state.land.unworn(state.radial_clearance)), 0.0)


def worn(states: Sequence[LandClearance], factor: Any, further: Any) -> tuple[Clearance, ...]:
    """Return the lands with their measured growth times a factor, and further growth on top; arrays give arrays.

    Parameters
    ----------
    states
        the lands as measured.
    factor
        on the growth of each: 0 is as new, 1 as measured. What makes a worn gap uneven is part of its wear: deviations
        from its mean clearance follow the factor too. A land without growth stays as it is.
    further
        of every land, as a fraction of its clearance when new, the same all around.
    """
    if np.ndim(factor) == np.ndim(further) == 0 and factor == 1.0 and further == 0.0:
        return tuple(states)
    return tuple(_worn(state, factor, further) for state in states)


def _worn(state: LandClearance, factor: Any, further: Any) -> TriedClearance:
    growth, (second, third) = measured_growth(state), state.form_moments
    added = further * state.land.new_clearance
    if not growth:
        return TriedClearance(state.land, state.spool_diameter, state.radial_clearance + added, (second, third))
    mean = state.radial_clearance + (factor - 1.0) * growth + added
    return TriedClearance(state.land, state.spool_diameter, mean, (second * factor**2, third * factor**3))
