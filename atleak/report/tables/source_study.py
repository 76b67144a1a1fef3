"""Show the eight variants: the article's tables for people, and the JSON record that scripts rely on."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from decimal import Decimal
from functools import partial
from typing import Any

from atleak.analysis.source_study import (
    ERRATA,
    VARIANTS,
    ComparedPoint,
    Erratum,
    OptionRow,
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


def point_table(points: Sequence[ComparedPoint], say: Wording) -> Table:
    """Return the points of the test that the article states, beside the computed ones."""

    def said(words: str) -> str:
        return say.get("study_words", words)

    columns = (
        _column("what", say, lambda each: said(f"{each.point.variant or 'pump'}: {each.point.quantity}")),
        _column("at [s]", say, lambda each: each.time, 3),
        _column("stated [dm³/min]", say, lambda each: float(each.point.printed), 3),
        _column("computed [dm³/min]", say, lambda each: each.computed, 3),
        _column("deviation [%]", say, lambda each: each.deviation * PERCENT, 3),
        _column("stated in", say, lambda each: said("inferred from Table 3" if each.point.inferred else "section 4")),
    )
    return Table("points", columns, points, say)


def option_table(options: Sequence[OptionRow], say: Wording) -> Table:
    """Return what every set of options changes in the most leakage against the first, ``paper``, by variant [%]."""
    base = options[0]

    def change(name: str, row: OptionRow) -> float | None:
        run, paper = row.runs[name], base.runs[name]
        if run is None or paper is None:
            return None
        return (run.max_leakage.leakage / paper.max_leakage.leakage - 1.0) * PERCENT

    return _by_variant("options", options[1:], change, say)


def option_share_table(options: Sequence[OptionRow], say: Wording) -> Table:
    """Return the share at the instant of most leakage with every set of options, by variant [%]."""

    def share(name: str, row: OptionRow) -> float | None:
        run = row.runs[name]
        return None if run is None else _share(run.max_leakage)

    return _by_variant("option_shares", options, share, say)


def _by_variant(
    name: str, options: Sequence[OptionRow], of: Callable[[str, OptionRow], float | None], say: Wording
) -> Table:
    first = _column("options", say, lambda row: say.get("study_words", row.label))
    variants = (_column(each.name, say, partial(of, each.name), 2) for each in VARIANTS)
    return Table(name, (first, *variants), options, say)


def errata_table(say: Wording) -> Table:
    """Return where the article contradicts itself, and what is done here."""

    def said(name: str, erratum: Erratum) -> str:
        return say.get("study_words", getattr(erratum, name))

    columns = (_column(name, say, partial(said, name)) for name in ("article", "finding", "here"))
    return Table("errata", (_column("no.", say, lambda each: str(each.number)), *columns), ERRATA, say)


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
