"""Give the source study's tables as rows for a page or a sheet: units in the headings, None where unknown."""

from __future__ import annotations

from collections.abc import Sequence
from decimal import Decimal
from typing import Any, Literal

from atleak.engine.extremes import Instant
from atleak.variants.article import ERRATA, ComparedPoint
from atleak.variants.run import OptionRow, VariantResult, reaches_digits
from atleak.workshop_units import DM3_MIN, G_CM3, PERCENT

PeakQuantity = Literal["max_leakage", "share_at_max_leakage", "max_share"]


def table_2_rows(results: Sequence[VariantResult]) -> list[dict[str, Any]]:
    """Return Table 2: every variant, with the viscosity that its printed results follow from."""
    return [
        {
            "variant": result.variant.name,
            "T [°C]": result.variant.temperature,
            "wear [%]": result.variant.wear * PERCENT,
            "ν printed [mm²/s]": result.variant.kinematic_viscosity / 1e-6,
            "ν used [mm²/s]": result.kinematic_viscosity / 1e-6,
            "ρ [g/cm³]": result.density * G_CM3,
        }
        for result in results
    ]


def table_3_rows(results: Sequence[VariantResult]) -> list[dict[str, Any]]:
    """Return Table 3: most leakage q and share U at that instant, printed and computed; the largest share of the test.

    ``digits`` is ✓ where the computed value rounds to every printed digit.
    """
    rows = []
    for result in results:
        variant, run = result.variant, result.computed
        leakage, share = run.max_leakage.leakage * DM3_MIN, _percent(run.max_leakage)
        rows.append(
            {
                "variant": variant.name,
                "q printed [dm³/min]": float(variant.printed_max_leakage),
                "q computed": leakage,
                "q digits": _digits(variant.printed_max_leakage, leakage),
                "q, ν printed": result.as_tabulated.max_leakage.leakage * DM3_MIN,
                "U printed [%]": float(variant.printed_max_share),
                "U computed": share,
                "U digits": _digits(variant.printed_max_share, share),
                "U largest": _percent(run.max_share),
            }
        )
    return rows


def notes(results: Sequence[VariantResult]) -> dict[str, str]:
    """Return the remarks on the variants, by their names."""
    return {result.variant.name: result.variant.note for result in results if result.variant.note}


def point_rows(points: Sequence[ComparedPoint]) -> list[dict[str, Any]]:
    """Return the points of the test that the article states, beside the computed ones."""
    return [
        {
            "what": f"{each.point.variant or 'pump'}: {each.point.quantity}",
            "at [s]": each.time,
            "stated [dm³/min]": float(each.point.printed),
            "computed [dm³/min]": each.computed,
            "deviation [%]": each.deviation * PERCENT,
            "stated in": "inferred from Table 3" if each.point.inferred else "section 4",
        }
        for each in points
    ]


def option_rows(options: Sequence[OptionRow], quantity: PeakQuantity = "max_leakage") -> list[dict[str, Any]]:
    """Return the results of every set of options, by variant: dm³/min, or % for a share."""
    factor = DM3_MIN if quantity == "max_leakage" else PERCENT
    return [
        {"options": row.label}
        | {name: None if value is None else value * factor for name, value in getattr(row, quantity).items()}
        for row in options
    ]


def option_changes(options: Sequence[OptionRow], quantity: PeakQuantity = "max_leakage") -> list[dict[str, Any]]:
    """Return the results of the options as change against the first row, ``paper`` [%], which is left out itself."""
    base = getattr(options[0], quantity)
    return [
        {"options": row.label}
        | {
            name: None if value is None or not base[name] else (value / base[name] - 1.0) * PERCENT
            for name, value in getattr(row, quantity).items()
        }
        for row in options[1:]
    ]


def errata_rows() -> list[dict[str, Any]]:
    """Return where the article contradicts itself, and what is done here."""
    return [
        {"no.": item.number, "article": item.article, "finding": item.finding, "here": item.here} for item in ERRATA
    ]


def _digits(printed: Decimal, value: float | None) -> str | None:
    if value is None:
        return None
    return "✓" if reaches_digits(printed, value) else "≠"


def _percent(instant: Instant | None) -> float | None:
    return None if instant is None or instant.share is None else instant.share * PERCENT
