"""List the measured clearances land by land: rows with the unit in the key, unrounded, None where unknown."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from atleak.catalogue.controller import Controller
from atleak.land_diagnosis import LandDiagnosis
from atleak.views.land_names import has_number
from atleak.views.table import VERDICT, Column
from atleak.wording import Wording
from atleak.workshop_units import MM, PERCENT, UM

CLEARANCE_COLUMNS = (
    Column("verdict", VERDICT, width=104),
    Column("component", width=140),
    Column("land", digits=0, width=64),
    Column("wear", "percent", 1, width=82),
    Column("clearance", "clearance", width=104),
    Column("mounting", "clearance", width=104),
    Column("spool_diameter", "length", 4),
    Column("sleeve_diameter", "length", 4),
    Column("component_name", width=220),
    Column("measured_parts"),
    Column("clearance_least", "clearance"),
    Column("clearance_largest", "clearance"),
    Column("direction_largest", digits=0),
    Column("spool_ovality", "clearance"),
    Column("sleeve_ovality", "clearance"),
    Column("spool_taper", "clearance"),
    Column("sleeve_taper", "clearance"),
    Column("spool_spread", "clearance"),
    Column("sleeve_spread", "clearance"),
    Column("planes"),
    Column("readings", digits=0),
    Column("representative_values"),
)
"""Of the clearances as measured; what tells pairs apart comes first, so that a narrow screen shows it."""


def clearance_rows(lands: Iterable[LandDiagnosis], controller: Controller, say: Wording) -> list[dict[str, Any]]:
    """Return one row per land for `CLEARANCE_COLUMNS`: diameters, clearance and range, ovality, taper, repeats."""
    return [_row(land, controller, say) for land in lands]


def _row(land: LandDiagnosis, controller: Controller, say: Wording) -> dict[str, Any]:
    state, nominal = land.state, land.state.land
    name = say.name(controller.components[nominal.component])
    return {
        "verdict": land.verdict,
        "component": nominal.component if has_number(controller, nominal.component) else name,
        "land": nominal.land,
        "wear": 0.0 if land.within_new else None if land.wear is None else land.wear * PERCENT,
        "clearance": state.radial_clearance * UM,
        "mounting": nominal.mounting_high * UM,
        "spool_diameter": state.spool_diameter * MM,
        "sleeve_diameter": state.sleeve_diameter * MM,
        "component_name": name,
        "measured_parts": say(f"measured_parts.{state.status}"),
        "clearance_least": state.min_clearance * UM if state.measured else None,
        "clearance_largest": state.max_clearance * UM if state.measured else None,
        "direction_largest": state.worst_direction,
        "spool_ovality": _scaled(state.spool_ovality),
        "sleeve_ovality": _scaled(state.sleeve_ovality),
        "spool_taper": _scaled(state.spool_taper),
        "sleeve_taper": _scaled(state.sleeve_taper),
        "spool_spread": _scaled(state.spool_repeat_spread),
        "sleeve_spread": _scaled(state.sleeve_repeat_spread),
        "planes": ", ".join(nominal.planes),
        "readings": state.spool_readings + state.sleeve_readings,
        "representative_values": ", ".join(say.get("parts", each) for each in nominal.representative) or None,
    }


def _scaled(metres: float | None) -> float | None:
    return None if metres is None else metres * UM
