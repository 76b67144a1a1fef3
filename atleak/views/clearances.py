"""List the measured clearances land by land: rows with the unit in the key, unrounded, None where unknown."""

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
    """Return one row per land: diameters, clearance and range, ovality, taper, spread of repeats, readings used."""
    return [_row(land) for land in lands]


def _row(land: LandDiagnosis) -> dict[str, Any]:
    state, nominal = land.state, land.state.land
    return {
        "component": nominal.component,
        "land": nominal.land,
        "verdict": land.verdict,
        "status": STATUS[state.status],
        "planes": ", ".join(nominal.planes),
        "spool_diameter_mm": state.spool_diameter * MM,
        "sleeve_diameter_mm": state.sleeve_diameter * MM,
        "radial_clearance_um": state.radial_clearance * UM,
        "min_clearance_um": state.min_clearance * UM if state.measured else None,
        "max_clearance_um": state.max_clearance * UM if state.measured else None,
        "worst_direction_deg": state.worst_direction,
        "mounting_clearance_um": nominal.mounting_high * UM,
        "wear_percent": None if land.wear is None else land.wear * PERCENT,
        "spool_ovality_um": _scaled(state.spool_ovality),
        "sleeve_ovality_um": _scaled(state.sleeve_ovality),
        "spool_taper_um": _scaled(state.spool_taper),
        "sleeve_taper_um": _scaled(state.sleeve_taper),
        "spool_spread_um": _scaled(state.spool_repeat_spread),
        "sleeve_spread_um": _scaled(state.sleeve_repeat_spread),
        "readings": state.spool_readings + state.sleeve_readings,
        "representative": value_names(nominal.representative) or None,
    }


def _scaled(metres: float | None) -> float | None:
    return None if metres is None else metres * UM
