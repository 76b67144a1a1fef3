"""The clearances as measured, land by land: rows with the unit in the key, unrounded, unknown as None."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from atleak.diagnosis import LandDiagnosis
from atleak.wording import value_names
from atleak.workshop_units import MM, PERCENT, UM

STATUS = {
    "measured": "measured",
    "spool_only": "sleeve at its nominal diameter",
    "sleeve_only": "spool at its nominal diameter",
    "not_measured": "not measured",
}


def clearance_rows(lands: Iterable[LandDiagnosis]) -> list[dict[str, Any]]:
    """One row per land: diameters, clearance and its range, ovality, taper, spread of repeats, what was read."""
    return [_row(land) for land in lands]


def _row(found: LandDiagnosis) -> dict[str, Any]:
    state = found.state
    land = state.land
    return {
        "component": land.component,
        "land": land.land,
        "verdict": found.verdict,
        "status": STATUS[state.status],
        "planes": ", ".join(land.planes),
        "spool_diameter_mm": state.spool_diameter * MM,
        "sleeve_diameter_mm": state.sleeve_diameter * MM,
        "radial_clearance_um": state.radial_clearance * UM,
        "min_clearance_um": state.min_clearance * UM if state.measured else None,
        "max_clearance_um": state.max_clearance * UM if state.measured else None,
        "worst_direction_deg": state.worst_direction,
        "mounting_clearance_um": land.mounting_clearance * UM,
        "wear_percent": None if found.wear is None else found.wear * PERCENT,
        "spool_ovality_um": _scaled(state.spool_ovality),
        "sleeve_ovality_um": _scaled(state.sleeve_ovality),
        "spool_taper_um": _scaled(state.spool_taper),
        "sleeve_taper_um": _scaled(state.sleeve_taper),
        "spool_spread_um": _scaled(state.spool_repeat_spread),
        "sleeve_spread_um": _scaled(state.sleeve_repeat_spread),
        "readings": state.spool_readings + state.sleeve_readings,
        "representative": value_names(land.representative) or None,
    }


def _scaled(metres: float | None) -> float | None:
    return None if metres is None else metres * UM
