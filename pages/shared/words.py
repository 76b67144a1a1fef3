"""The sentences and rows a page shows, from the record: only words and choice of columns."""

from __future__ import annotations

from typing import Any

from atleak.controller import Controller
from atleak.diagnosis import Diagnosis
from atleak.figures import BAND_SYMBOLS
from atleak.limits import Verdict
from pages.shared.show import plain, verdict

FLAGGED: tuple[Verdict, ...] = ("critical", "replace", "watch")
DIGITS = {
    "Clearance [µm]": 1,
    "± [µm]": 1,
    "Mounting [µm]": 1,
    "Wear [%]": 1,
    "Share [%]": 2,
    "Leakage [dm³/min]": 3,
    "Spool [mm]": 4,
    "Sleeve [mm]": 4,
    "Least [µm]": 1,
    "Largest [µm]": 1,
    "At [°]": 0,
    **dict.fromkeys(
        (f"{part} {what} [µm]" for what in ("ovality", "taper", "spread") for part in ("Spool", "Sleeve")), 1
    ),
    "Limit reached at [km]": 0,
}


def verdict_sentence(diagnosis: Diagnosis, record: dict[str, Any]) -> str:
    """The verdict in one paragraph, in markdown."""
    lands = record["lands"]
    counts = {name: sum(land["verdict"] == name for land in lands) for name in FLAGGED}
    flagged = ", ".join(f"{count} {verdict(name)}" for name, count in counts.items() if count)
    measured = record["readings"]["lands_measured"]
    if not measured:
        head = f"**{verdict('not_measured')}:** no land is measured; all {len(lands)} are at their mounting clearance."
    elif flagged:
        pairs = len({land["component"] for land in lands if land["verdict"] in FLAGGED})
        head = f"**{verdict(record['verdict'])}:** {flagged} of {measured} measured lands, in {pairs} components."
    else:
        head = f"**{verdict('ok')}:** none of {measured} measured lands has reached a limit."
    totals = [_total(record[name], point.condition.label) for name, point in _points(diagnosis, record)]
    return f"{head} The unit leaks {' and '.join(totals)}."


def _points(diagnosis: Diagnosis, record: dict[str, Any]) -> list[tuple[str, Any]]:
    names = ["projection"] + (["hot_idle"] if record["hot_idle"] is not None else [])
    return list(zip(names, diagnosis.projections, strict=False))


def _total(point: dict[str, Any], label: str) -> str:
    share, band = point["share_percent"], point["band"]
    if share is None:
        return f"more than the pump delivers at {plain(label)} (✖ critical)"
    return f"**{share:.1f} %** of the pump's flow at {plain(label)} ({BAND_SYMBOLS[band]} {band})"


def component(diagnosis: Diagnosis, land: dict[str, Any]) -> str:
    """``25 · regulator valve``."""
    return f"{land['component']} · {diagnosis.controller.components[land['component']]}"


def land_rows(diagnosis: Diagnosis, lands: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Rows of a table of lands; columns that nothing fills are left out."""
    rows = []
    for land in lands:
        rule = deciding(land)
        rows.append(
            {
                "Verdict": land["verdict"],
                "Component": component(diagnosis, land),
                "Land": land["land"],
                "Clearance [µm]": land["radial_clearance_um"],
                "± [µm]": land["uncertainty_um"],
                "Mounting [µm]": land["mounting_clearance_um"],
                "Wear [%]": land["wear_percent"],
                "Share [%]": land["share_percent"],
                "Decided by": None if rule is None else rule_text(rule),
                "Limit is": None if rule is None else rule["origin"],
                "Decision": land["decision"],
                "Leakage [dm³/min]": land["leakage_dm3_min"],
                "Limit reached at [km]": land["replace_mileage_km"],
            }
        )
    filled = [name for name in rows[0] if any(row[name] is not None for row in rows)] if rows else []
    return [{name: row[name] for name in filled} for row in rows]


def deciding(land: dict[str, Any]) -> dict[str, Any] | None:
    """The rule that gave a land's verdict."""
    return next((rule for rule in land["rules"] if rule["verdict"] == land["verdict"]), None)


def rule_text(rule: dict[str, Any]) -> str:
    """``wear 69 %, limit 50 %``."""
    name, unit = (
        (rule["rule"].removesuffix("_percent"), "%")
        if rule["rule"].endswith("_percent")
        else (rule["rule"].removesuffix("_um"), "µm")
    )
    value = "beyond the pump" if rule["value"] is None else f"{rule['value']:.3g} {unit}"
    return f"{name.replace('_', ' ')} {value}, limit {rule['limit']:g} {unit}"


def clearance_table(controller: Controller, rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Rows of the clearances as measured."""
    names = {
        "radial_clearance_um": "Clearance [µm]",
        "mounting_clearance_um": "Mounting [µm]",
        "wear_percent": "Wear [%]",
        "spool_diameter_mm": "Spool [mm]",
        "sleeve_diameter_mm": "Sleeve [mm]",
        "status": "Status",
        "min_clearance_um": "Least [µm]",
        "max_clearance_um": "Largest [µm]",
        "worst_direction_deg": "At [°]",
        "spool_ovality_um": "Spool ovality [µm]",
        "sleeve_ovality_um": "Sleeve ovality [µm]",
        "spool_taper_um": "Spool taper [µm]",
        "sleeve_taper_um": "Sleeve taper [µm]",
        "spool_spread_um": "Spool spread [µm]",
        "sleeve_spread_um": "Sleeve spread [µm]",
        "planes": "Planes",
        "readings": "Readings",
        "representative": "Representative",
    }
    return [
        {
            "Verdict": row["verdict"],
            "Component": f"{row['component']} · {controller.components[row['component']]}",
            "Land": row["land"],
            **{heading: row[name] for name, heading in names.items()},
        }
        for row in rows
    ]
