"""Show what was learned from measuring sheets: rows for people, and the record that scripts rely on."""

from __future__ import annotations

from typing import Any

from atleak.learning.learned import Learned, LearnedLand
from atleak.learning.words import messages, summary
from atleak.version import __version__
from atleak.views.message_record import message_record
from atleak.workshop_units import UM

FORMAT = 1


def land_rows(learned: Learned) -> list[dict[str, Any]]:
    """Return a row for every land that was learned, with the unit in the heading."""
    return [
        {
            "Pair": f"{land.land.component}/{land.land.land}",
            "New [µm]": round(land.clearance * UM, 2),
            "Sure to ±": round(land.uncertainty * UM, 2),
            "95 % of pairs ±": round(land.tolerance * UM, 2),
            "Spread": None if land.spread is None else round(land.spread * UM, 2),
            "Units": land.units,
            "Unworn ends": land.unworn_ends,
            "So far [µm]": "–".join(f"{end * UM:.3g}" for end in land.land.mounting_ends),
        }
        for land in learned.lands
    ]


def learned_record(learned: Learned) -> dict[str, Any]:
    """Return all of it under stable keys: lengths in µm, nothing rounded, unknown as None."""
    controller = learned.controller
    return {
        "format": FORMAT,
        "atleak": __version__,
        "controller": {"id": controller.id, "name": controller.name, "sha256": controller.sha256},
        "summary": summary(learned),
        "spread_um": _um(learned.spread),
        "measurement_um": _um(learned.measurement),
        "units": [
            {
                "file": unit.file,
                "sha256": unit.sha256,
                "lands": unit.lands,
                "of_used_unit": unit.of_used_unit,
                "shift_um": unit.shift * UM,
                "left_out": unit.left_out,
            }
            for unit in learned.units
        ],
        "lands": [_land_record(land) for land in learned.lands],
        "lands_not_learned": [{"component": land.component, "land": land.land} for land in learned.unlearned],
        "outliers": [
            {
                "file": pair.file,
                "component": pair.component,
                "land": pair.land,
                "clearance_um": pair.clearance * UM,
                "expected_um": pair.expected * UM,
                "wider": pair.wider,
            }
            for pair in learned.left_out
        ],
        "messages": [message_record(message) for message in messages(learned)],
    }


def _land_record(land: LearnedLand) -> dict[str, Any]:
    return {
        "component": land.land.component,
        "land": land.land.land,
        "mounting_clearance_um": land.clearance * UM,
        "uncertainty_um": land.uncertainty * UM,
        "uncertainty_by_units_um": land.uncertainty_by_units * UM,
        "mounting_tolerance_um": land.tolerance * UM,
        "tolerance_from": land.tolerance_from,
        "spread_um": _um(land.spread),
        "measurement_um": land.measurement * UM,
        "calibration_um": land.calibration * UM,
        "learned_from_units": land.units,
        "unworn_ends": land.unworn_ends,
        "mounting_clearance_um_so_far": [end * UM for end in land.land.mounting_ends],
    }


def _um(length: float | None) -> float | None:
    return None if length is None else length * UM
