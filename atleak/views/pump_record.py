"""Gather the pump of a job as JSON, and what it slips beside what it did when new."""

from __future__ import annotations

from typing import Any

from atleak.diagnosis import Diagnosis
from atleak.engine.projection import Projection
from atleak.workshop_units import MM3_S


def slips(diagnosis: Diagnosis, projection: Projection) -> tuple[float, float | None]:
    """Return what the pump slips at a condition, and what it did when new [m³/s]; None where that is not known."""
    compared = diagnosis.controller.pump.as_new is not None
    return projection.slip, diagnosis.new_at(projection).slip if compared else None


def pump_record(diagnosis: Diagnosis) -> dict[str, Any]:
    """Return the pump as ``atleak diagnose --json`` has it."""
    pump = diagnosis.controller.pump
    record: dict[str, Any] = {
        "kind": pump.kind,
        "displacement_mm3": pump.displacement * MM3_S,
        "held_at_demand": pump.held_at_demand,
        "slip_coefficient": pump.slip_coefficient if diagnosis.model.uses_slip else None,
        "slip_coefficient_new": pump.as_new.slip_coefficient if pump.as_new is not None else None,
    }
    of = {"measured": pump.measured, "new": pump.clearances, "limit": pump.limits}
    verdict = diagnosis.pump.verdict
    record |= {"verdict": verdict, "repairs": [{"work": "as_new"}] if verdict.flagged else []}
    for number, name in enumerate(("side", "tip")):
        record |= {f"{name}_clearance_{which}_um": each.um[number] for which, each in of.items()}
    return record
