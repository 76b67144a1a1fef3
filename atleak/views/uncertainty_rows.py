"""The same result as rows for people: one row a land or a source, units in the column names."""

from __future__ import annotations

import math
from typing import Any

from atleak.uncertainty.assess import Interval, LandUncertainty, UnitUncertainty
from atleak.workshop_units import DM3_MIN, PERCENT, UM


def land_rows(unit: UnitUncertainty) -> list[dict[str, Any]]:
    """One row for every land that was measured, at the stated condition; unknown and infinite are None."""
    return [_land_row(land) for land in unit.lands if land.u_clearance is not None]


def budget_rows(land: LandUncertainty) -> list[dict[str, Any]]:
    """What makes one land's clearance uncertain, and its share at the stated condition, source by source."""
    of_clearance = dict(land.budget)
    of_share = dict(land.conditions[0].budget) if land.conditions else {}
    return [
        {
            "source": name,
            "of_clearance_percent": PERCENT * of_clearance.get(name, 0.0),
            "of_share_percent": PERCENT * of_share.get(name, 0.0),
        }
        for name in dict.fromkeys([*of_share, *of_clearance])
    ]


def _land_row(land: LandUncertainty) -> dict[str, Any]:
    state, shape, stated = land.sources.state, land.shape, land.conditions[0]
    deciding = land.deciding
    return {
        "component": state.land.component,
        "land": state.land.land,
        "radial_clearance_um": state.radial_clearance * UM,
        "uncertainty_um": _scaled(land.u_clearance, UM),
        **_interval("radial_clearance", "um", land.clearance_interval, UM),
        "worst_direction_deg": shape.worst_direction,
        "worst_clearance_um": shape.worst_clearance * UM,
        "flow_equivalent_clearance_um": _scaled(shape.effective_clearance, UM),
        "lower_bound": shape.lower_bound,
        "leakage_dm3_min": stated.leakage * DM3_MIN,
        **_interval("leakage", "dm3_min", stated.leakage_interval, DM3_MIN),
        "leakage_concentric_dm3_min": stated.eccentric[0] * DM3_MIN,
        "leakage_fully_eccentric_dm3_min": stated.eccentric[1] * DM3_MIN,
        "share_percent": _scaled(stated.share, PERCENT),
        **_interval("share", "percent", stated.share_interval, PERCENT),
        "deciding_rule": deciding.rule if deciding else None,
        "decision": land.decision,
        "probability_over_limit_percent": _scaled(land.probability_over_limit, PERCENT),
        "advice": land.advice,
    }


def _interval(name: str, unit: str, interval: Interval | None, factor: float) -> dict[str, float | None]:
    low, high = interval or (None, None)
    return {f"{name}_low_{unit}": _scaled(low, factor), f"{name}_high_{unit}": _scaled(high, factor)}


def _scaled(value: float | None, factor: float) -> float | None:
    return None if value is None or not math.isfinite(value) else value * factor
