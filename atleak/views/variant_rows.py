"""Turn the eight variants into the JSON record that scripts rely on: unrounded, units in the keys."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from atleak.catalogue.controller import Controller
from atleak.engine.extremes import Instant
from atleak.engine.road_leakage import RoadLeakage
from atleak.errors import Message
from atleak.road_test import RoadTest
from atleak.variants import VariantResult, gear_at_most_leakage
from atleak.version import __version__
from atleak.views.diagnosis_record import FORMAT
from atleak.views.message_record import message_record
from atleak.workshop_units import DM3_MIN, G_CM3, PERCENT


def variants_record(results: Sequence[VariantResult], controller: Controller, road_test: RoadTest) -> dict[str, Any]:
    """Return the record of `atleak.variants.run_variants`, in the form ``atleak variants --json`` writes."""
    profile = results[0].profile if results else None
    return {
        "format": FORMAT,
        "atleak": __version__,
        "profile": {"name": profile.name, **profile.options} if profile else None,
        "controller": {
            "id": controller.id,
            "name": controller.name,
            "sha256": controller.sha256,
            "representative": bool(controller.representative),
            "representative_note": controller.representative or None,
        },
        "road_test": {
            "file": road_test.file,
            "sha256": road_test.sha256,
            "rows": road_test.rows,
            "duration_s": road_test.duration,
        },
        "variants": [_variant(result) for result in results],
        "messages": [message_record(message) for message in _unique(results)],
    }


def _variant(result: VariantResult) -> dict[str, Any]:
    variant = result.variant
    return {
        "variant": variant.name,
        "temperature_c": variant.temperature,
        "wear_percent": variant.wear * PERCENT,
        "kinematic_viscosity_mm2_s": variant.kinematic_viscosity / 1e-6,
        "density_g_cm3": variant.density * G_CM3,
        "kinematic_viscosity_used_mm2_s": result.kinematic_viscosity / 1e-6,
        "density_used_g_cm3": result.density * G_CM3,
        "printed": {
            "max_leakage_dm3_min": float(variant.printed_max_leakage),
            "max_share_percent": float(variant.printed_max_share),
        },
        "computed": _run(result.computed),
        "as_tabulated": _run(result.as_tabulated),
        "note": variant.note or None,
    }


def _run(run: RoadLeakage) -> dict[str, Any]:
    return {
        "max_leakage_dm3_min": run.max_leakage.leakage * DM3_MIN,
        "max_leakage_time_s": run.max_leakage.time,
        "gear_at_max_leakage": gear_at_most_leakage(run),
        "pump_capacity_at_max_leakage_dm3_min": _pump(run.max_leakage),
        "share_at_max_leakage_percent": _share(run.max_leakage),
        "min_leakage_dm3_min": run.min_leakage.leakage * DM3_MIN,
        "min_leakage_time_s": run.min_leakage.time,
        "max_share_percent": _share(run.max_share),
        "max_share_time_s": run.max_share.time if run.max_share else None,
    }


def _share(instant: Instant | None) -> float | None:
    return None if instant is None or instant.share is None else instant.share * PERCENT


def _pump(instant: Instant) -> float | None:
    return None if instant.pump_capacity is None else instant.pump_capacity * DM3_MIN


def _unique(results: Sequence[VariantResult]) -> list[Message]:
    messages: dict[tuple[str, str], Message] = {}
    for result in results:
        for message in result.messages:
            messages.setdefault((message.code, message.text), message)
    return list(messages.values())
