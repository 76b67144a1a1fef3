"""List the measured clearances land by land, and what makes them uncertain: rows with the unit in the key."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from atleak.catalogue.controller import Controller
from atleak.common.units import MM, PERCENT, UM
from atleak.common.wording import Wording
from atleak.diagnosis.land import LandDiagnosis
from atleak.diagnosis.uncertainty import LandUncertainty
from atleak.report.tables.names import has_number
from atleak.report.tables.table import VERDICT, Column, Table


def clearance_table(lands: Sequence[LandDiagnosis], controller: Controller, say: Wording) -> Table:
    """Return a row per land: verdict, diameters, clearance and range, ovality, taper, repeats.

    What tells pairs apart comes first, so that a narrow screen shows it.
    """

    def name(land: LandDiagnosis) -> str:
        return say.name(controller.components[land.key[0]])

    def wear(land: LandDiagnosis) -> float | None:
        return 0.0 if land.within_new else land.wear

    def extreme(land: LandDiagnosis, which: str) -> float | None:
        return getattr(land.state, f"{which}_clearance") if land.state.measured else None

    def of_state(key: str, attribute: str) -> Column:
        return Column(key, "clearance", of=lambda land: getattr(land.state, attribute), times=UM)

    parts = "spool", "sleeve"
    columns = (
        Column("verdict", VERDICT, width=104),
        Column(
            "component",
            width=140,
            of=lambda land: land.key[0] if has_number(controller, land.key[0]) else name(land),
        ),
        Column("land", digits=0, width=64, of=lambda land: land.key[1]),
        Column("wear", "percent", 1, width=82, of=wear, times=PERCENT),
        Column("clearance", "clearance", width=104, of=lambda land: land.state.radial_clearance, times=UM),
        Column("mounting", "clearance", width=104, of=lambda land: land.state.land.mounting_high, times=UM),
        Column("spool_diameter", "length", 4, of=lambda land: land.state.spool_diameter, times=MM),
        Column("sleeve_diameter", "length", 4, of=lambda land: land.state.sleeve_diameter, times=MM),
        Column("component_name", width=220, of=name),
        Column("measured_parts", of=lambda land: say(f"measured_parts.{land.state.status}")),
        Column("clearance_least", "clearance", of=lambda land: extreme(land, "min"), times=UM),
        Column("clearance_largest", "clearance", of=lambda land: extreme(land, "max"), times=UM),
        Column("direction_largest", digits=0, of=lambda land: land.state.worst_direction),
        *(of_state(f"{part}_{form}", f"{part}_{form}") for form in ("ovality", "taper") for part in parts),
        *(of_state(f"{part}_spread", f"{part}_repeat_spread") for part in parts),
        Column("planes", of=lambda land: ", ".join(land.state.land.planes)),
        Column("readings", digits=0, of=lambda land: land.state.spool_readings + land.state.sleeve_readings),
        Column(
            "representative_values",
            of=lambda land: ", ".join(say.get("parts", each) for each in land.state.land.representative) or None,
        ),
    )
    return Table("clearances", columns, lands, say)


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
