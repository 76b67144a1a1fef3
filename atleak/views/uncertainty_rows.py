"""List what makes a land uncertain: one row per source."""

from __future__ import annotations

from typing import Any

from atleak.uncertainty import LandUncertainty
from atleak.wording import Wording
from atleak.workshop_units import PERCENT


def budget_rows(land: LandUncertainty, say: Wording) -> list[dict[str, Any]]:
    """Return what makes one land's clearance, and its share at the stated condition, uncertain [%]."""
    of_clearance = dict(land.budget)
    of_share = dict(land.conditions[0].budget) if land.conditions else {}
    return [
        {
            "uncertain_source": say.get("uncertainty_sources", name),
            "of_clearance": PERCENT * of_clearance.get(name, 0.0),
            "of_share": PERCENT * of_share.get(name, 0.0),
        }
        for name in dict.fromkeys([*of_share, *of_clearance])
    ]
