"""Show the eight variants: the article's tables for people, and the JSON record that scripts rely on."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from decimal import Decimal
from typing import Any

from atleak.analysis.source_study import (
    VariantResult,
    gear_at_most_leakage,
    reaches_digits,
)
from atleak.catalogue.controller import Controller
from atleak.common.errors import Message
from atleak.common.units import DM3_MIN, G_CM3, MM2_S, PERCENT
from atleak.common.wording import Wording
from atleak.engine.extremes import Instant
from atleak.engine.road_leakage import RoadLeakage
from atleak.measurements.road_test import RoadTest
from atleak.report.json.conditions import message_record, named_record
from atleak.report.json.diagnosis import FORMAT
from atleak.report.tables.table import Column, Table
from atleak.version import __version__


def table_2(results: Sequence[VariantResult], say: Wording) -> Table:
    """Return Table 2 in the article's units: every variant, with the viscosity that its printed results follow from."""
    columns = (
        _column("variant", say, lambda result: result.variant.name),
        _column("T [°C]", say, lambda result: result.variant.temperature, 0),
        _column("wear [%]", say, lambda result: result.variant.wear * PERCENT, 0),
        _column("ν printed [mm²/s]", say, lambda result: result.variant.kinematic_viscosity * MM2_S, 2),
        _column("ν used [mm²/s]", say, lambda result: result.kinematic_viscosity * MM2_S, 2),
        _column("ρ [g/cm³]", say, lambda result: result.density * G_CM3, 3),
    )
    return Table("table_2", columns, results, say, say("study.table_2_is"))


def table_3(results: Sequence[VariantResult], say: Wording) -> Table:
    """Return Table 3: most leakage q and share U at that instant, printed and computed; the largest share of the test.

    ``digits`` is ✓ where the computed value rounds to every printed digit.
    """

    def leakage(run: RoadLeakage) -> float:
        return run.max_leakage.leakage * DM3_MIN

    def share(result: VariantResult) -> float | None:
        return _share(result.computed.max_leakage)

    def remark(result: VariantResult) -> str:
        note = result.variant.note
        return f"{result.variant.name}: {say.get('study_words', note)}" if note else ""

    columns = (
        _column("variant", say, lambda result: result.variant.name),
        _column("q printed [dm³/min]", say, lambda result: str(result.variant.printed_max_leakage)),
        _column("q computed", say, lambda result: leakage(result.computed), 3),
        _column("q digits", say, lambda result: _digits(result.variant.printed_max_leakage, leakage(result.computed))),
        _column("q, ν printed", say, lambda result: leakage(result.as_tabulated), 3),
        _column("U printed [%]", say, lambda result: str(result.variant.printed_max_share)),
        _column("U computed", say, share, 3),
        _column("U digits", say, lambda result: _digits(result.variant.printed_max_share, share(result))),
        _column("U largest", say, lambda result: _share(result.computed.max_share), 3),
    )
    return Table("table_3", columns, results, say, say("study.table_3_is"), remark=remark)


def _column(heading: str, say: Wording, of: Callable[[Any], Any], digits: int | None = None) -> Column:
    return Column(heading, digits=digits, words=say.get("study_words", heading), of=of)


def _digits(printed: Decimal, value: float | None) -> str | None:
    return None if value is None else "✓" if reaches_digits(printed, value) else "≠"


def variants_record(results: Sequence[VariantResult], controller: Controller, road_test: RoadTest) -> dict[str, Any]:
    """Return the record of `source_study.run_variants`, in the form ``atleak variants --json`` writes."""
    profile = results[0].profile if results else None
    return {
        "format": FORMAT,
        "atleak": __version__,
        "profile": {"name": profile.name, **profile.options} if profile else None,
        "controller": {
            **named_record(controller, "id", "name", "sha256"),
            "representative": bool(controller.representative),
            "representative_note": controller.representative or None,
        },
        "road_test": named_record(road_test, "file", "sha256", "rows", "duration_s"),
        "variants": [_variant(result) for result in results],
        "messages": [message_record(message) for message in _unique(results)],
    }


def _variant(result: VariantResult) -> dict[str, Any]:
    variant = result.variant
    return {
        **named_record(variant, variant="name", temperature_c="temperature", wear_percent="wear"),
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
    most = run.max_leakage
    return {
        **named_record(most, max_leakage_dm3_min="leakage", max_leakage_time_s="time"),
        "gear_at_max_leakage": gear_at_most_leakage(run),
        **named_record(
            most, pump_capacity_at_max_leakage_dm3_min="pump_capacity", share_at_max_leakage_percent="share"
        ),
        **named_record(run.min_leakage, min_leakage_dm3_min="leakage", min_leakage_time_s="time"),
        **named_record(run.max_share, max_share_percent="share", max_share_time_s="time"),
    }


def _share(instant: Instant | None) -> float | None:
    return None if instant is None or instant.share is None else instant.share * PERCENT


def _unique(results: Sequence[VariantResult]) -> list[Message]:
    return list({(each.code, each.text): each for result in results for each in result.messages}.values())
