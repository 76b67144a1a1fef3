"""Lay out a comparison in rows: lands, totals, pressures and the events of two logs, in workshop units."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import numpy as np

from atleak.comparison import Change, Comparison, ConditionComparison, LandComparison, LogComparison
from atleak.diagnosis import LandDiagnosis
from atleak.road_test import RoadTest
from atleak.views.comparison_words import event_name, land_name, signed_number, with_uncertainty
from atleak.wording import signed, wording
from atleak.workshop_units import DM3_MIN, KPA, PERCENT, UM

YES, NO = "yes", "no"
_SHOWN = 0.5  # [kPa] that a pressure without decimals shows


def land_rows(comparison: Comparison, lands: Iterable[LandComparison]) -> list[dict[str, Any]]:
    """Return one row for every land, in English."""
    return [_land_row(comparison, land) for land in lands]


def _land_row(comparison: Comparison, land: LandComparison) -> dict[str, Any]:
    before, after = land.before, land.after
    return {
        "Verdict": None if after is None else after.verdict,
        "Was": None if before is None else signed(before.verdict),
        "Pair": land_name(comparison, land),
        "Before [µm]": _clearance(before),
        "After [µm]": _clearance(after),
        "Change [µm]": with_uncertainty(land.change, wording("en")) if land.change else None,
        "Changed": None if land.change is None else YES if land.significant else NO,
        "Wear before [%]": None if before is None or before.wear is None else before.wear * PERCENT,
        "Wear after [%]": None if after is None or after.wear is None else after.wear * PERCENT,
        "Share before [%]": _share(before),
        "Share after [%]": _share(after),
        "Decision before": _decision(before),
        "Decision after": _decision(after),
    }


def _clearance(land: LandDiagnosis | None) -> float | None:
    return land.state.radial_clearance * UM if land is not None and land.state.measured else None


def _share(land: LandDiagnosis | None) -> float | None:
    return land.share * PERCENT if land is not None and math.isfinite(land.share) else None


def _decision(land: LandDiagnosis | None) -> str | None:
    return None if land is None or land.decision is None else land.decision.replace("_", " ")


def condition_rows(comparison: Comparison, *, brief: bool = False) -> list[dict[str, Any]]:
    """Return one row for every total, reserve and pressure of every condition that both jobs were judged at.

    In brief a pressure that did not change by as much as is shown is left out, and so is the flow behind a share; a
    condition is named in its first row only.
    """
    rows: list[dict[str, Any]] = []
    for each in comparison.on_both_sides:
        of_condition = _quantities(each, brief=brief)
        if brief:
            of_condition[1:] = [{**row, "Operating point": ""} for row in of_condition[1:]]
        rows += of_condition
    return rows


def _quantities(each: ConditionComparison, *, brief: bool) -> list[dict[str, Any]]:
    rows = [
        _row(each, "share of the pump's flow", "%", each.share, PERCENT, 1),
        None if brief else _row(each, "leakage", "dm³/min", each.leakage, DM3_MIN, 2),
        _row(each, "reserve of the pump", "", each.reserve, 1.0, 2),
    ]
    pressures = [("main pressure held", each.main_pressure), *((one.circuit.name, one.change) for one in each.circuits)]
    for name, change in pressures:
        moved = change is not None and (change.significant or abs(change.value * KPA) >= _SHOWN)
        rows.append(_row(each, name, "kPa", change, KPA, 0) if moved or not brief else None)
    return [row for row in rows if row is not None]


def _row(
    each: ConditionComparison, what: str, unit: str, change: Change | None, factor: float, digits: int
) -> dict[str, Any] | None:
    if change is None:
        return None
    say = wording("en")
    low, high = change.interval or (math.nan, math.nan)
    return {
        "Operating point": each.label,
        "What": what,
        "Before": say.number(change.before * factor, digits),
        "After": say.number(change.after * factor, digits),
        "Change": signed_number(change.value * factor, digits, say),
        "95 % interval": ""
        if change.interval is None
        else f"{say.number(low * factor, digits)} to {say.number(high * factor, digits)}",
        "Unit": unit,
        "Changed": None if change.significant is None else YES if change.significant else NO,
    }


def event_rows(logs: LogComparison) -> list[dict[str, Any]]:
    """Return one row for every event of either log, before → after: start, duration, mean pressure and fluid."""
    say = wording("en")
    rows = []
    for pair in logs.pairs:
        sides = (logs.before.road_test, pair.before), (logs.after.road_test, pair.after)
        parts = [None if event is None else test.window(event.start, event.stop) for test, event in sides]
        events = [event for _, event in sides]
        rows.append(
            {
                "Event": event_name(pair, say),
                "Starts [s]": _arrow([None if event is None else event.start for event in events], 1),
                "Lasts [s]": _arrow([None if event is None else event.duration for event in events], 1),
                "Mean main pressure [kPa]": _arrow([_mean(part, "main_pressure", KPA) for part in parts], 0),
                "Fluid [°C]": _arrow([_mean(part, "atf_temperature", 1.0) for part in parts], 0),
            }
        )
    return rows


def _arrow(values: Iterable[float | None], digits: int) -> str:
    return " → ".join(wording("en").number(value, digits) for value in values)


def _mean(part: RoadTest | None, quantity: str, factor: float) -> float | None:
    values = None if part is None else part.values(quantity)
    if values is None or not np.isfinite(values).any():
        return None
    return float(np.nanmean(values)) * factor
