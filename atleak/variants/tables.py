"""Give the source study's tables as rows for a page or a sheet: units in the headings, None where unknown."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal

from atleak.variants.article import ERRATA, ComparedPoint
from atleak.variants.run import OptionRow
from atleak.workshop_units import DM3_MIN, PERCENT

PeakQuantity = Literal["max_leakage", "share_at_max_leakage", "max_share"]


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
