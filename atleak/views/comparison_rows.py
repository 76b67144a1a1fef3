"""Lay out a comparison in rows: lands, totals, pressures and the events of two logs, in workshop units."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import numpy as np

from atleak.comparison import Change, Comparison, ConditionComparison, LandComparison, LogComparison
from atleak.land_diagnosis import LandDiagnosis
from atleak.road_test import RoadTest
from atleak.views.comparison_words import event_name, land_name, signed_number, with_uncertainty
from atleak.views.table import Column
from atleak.wording import Wording
from atleak.workshop_units import DM3_MIN, KPA, PERCENT, UM

LAND_COLUMNS = (
    Column("verdict", "verdict", width=92),
    Column("was"),
    Column("pair", width=176),
    *(Column(f"clearance_{side}", "clearance", 1) for side in ("before", "after")),
    Column("change", words_of="clearance"),
    Column("changed"),
    *(Column(f"wear_{side}", "percent", 1) for side in ("before", "after")),
    *(Column(f"share_{side}", "percent", 2) for side in ("before", "after")),
    *(Column(f"decision_{side}") for side in ("before", "after")),
)
CONDITION_COLUMNS = tuple(
    Column(name) for name in ("condition", "what", "before", "after", "change", "interval", "unit", "changed")
)
EVENT_COLUMNS = (
    Column("event"),
    Column("starts", words_of="time"),
    Column("lasts", words_of="time"),
    Column("mean_pressure", words_of="pressure"),
    Column("fluid", words_of="temperature"),
)
_SHOWN = 0.5  # [kPa] that a pressure without decimals shows


def land_rows(comparison: Comparison, lands: Iterable[LandComparison], say: Wording) -> list[dict[str, Any]]:
    """Return one row for every land, as `LAND_COLUMNS` show them."""
    return [_land_row(comparison, land, say) for land in lands]


def _land_row(comparison: Comparison, land: LandComparison, say: Wording) -> dict[str, Any]:
    before, after = land.before, land.after
    return {
        "verdict": None if after is None else after.verdict,
        "was": None if before is None else say.signed(before.verdict),
        "pair": land_name(comparison, land, say),
        "clearance_before": _clearance(before),
        "clearance_after": _clearance(after),
        "change": with_uncertainty(land.change, say) if land.change else None,
        "changed": None if land.change is None else _whether(land.significant, say),
        "wear_before": None if before is None or before.wear is None else before.wear * PERCENT,
        "wear_after": None if after is None or after.wear is None else after.wear * PERCENT,
        "share_before": _share(before),
        "share_after": _share(after),
        "decision_before": _decision(before, say),
        "decision_after": _decision(after, say),
    }


def _whether(is_so: bool, say: Wording) -> str:
    return say("answers.yes" if is_so else "answers.no")


def _clearance(land: LandDiagnosis | None) -> float | None:
    return land.state.radial_clearance * UM if land is not None and land.state.measured else None


def _share(land: LandDiagnosis | None) -> float | None:
    return land.share * PERCENT if land is not None and math.isfinite(land.share) else None


def _decision(land: LandDiagnosis | None, say: Wording) -> str | None:
    return None if land is None or land.decision is None else say.get("decisions", land.decision)


def condition_rows(comparison: Comparison, say: Wording, *, brief: bool = False) -> list[dict[str, Any]]:
    """Return one row for every total, reserve and pressure of every condition that both jobs were judged at.

    In brief a pressure that did not change by as much as is shown is left out, and so is the flow behind a share; a
    condition is named in its first row only.
    """
    rows: list[dict[str, Any]] = []
    for each in comparison.on_both_sides:
        of_condition = _quantities(each, say, brief=brief)
        if brief:
            of_condition[1:] = [{**row, "condition": ""} for row in of_condition[1:]]
        rows += of_condition
    return rows


def _quantities(each: ConditionComparison, say: Wording, *, brief: bool) -> list[dict[str, Any]]:
    rows = [
        _row(each, say("compared.share"), "percent", each.share, PERCENT, 1, say),
        None if brief else _row(each, say("compared.leakage"), "flow", each.leakage, DM3_MIN, 2, say),
        _row(each, say("compared.reserve"), "number", each.reserve, 1.0, 2, say),
    ]
    line = say("compared.main_pressure")
    pressures = [(line, each.main_pressure), *((say.name(one.circuit.name), one.change) for one in each.circuits)]
    for name, change in pressures:
        moved = change is not None and (change.significant or abs(change.value * KPA) >= _SHOWN)
        rows.append(_row(each, name, "pressure", change, KPA, 0, say) if moved or not brief else None)
    return [row for row in rows if row is not None]


def _row(
    each: ConditionComparison, what: str, kind: str, change: Change | None, factor: float, digits: int, say: Wording
) -> dict[str, Any] | None:
    if change is None:
        return None
    places, scale = say.digits(kind, digits), say.convert(factor, kind)  # none of these kinds has a zero of its own
    return {
        "condition": say.condition(each.before.condition) if each.before else "",
        "what": what,
        "before": say.number(change.before * scale, places),
        "after": say.number(change.after * scale, places),
        "change": signed_number(change.value * scale, places, say),
        "interval": "" if change.interval is None else _interval(change.interval, scale, places, say),
        "unit": say.unit(kind),
        "changed": None if change.significant is None else _whether(change.significant, say),
    }


def _interval(ends: tuple[float, float], scale: float, places: int, say: Wording) -> str:
    low, high = (say.number(end * scale, places) for end in ends)
    return say("written.to", low=low, high=high)


def event_rows(logs: LogComparison, say: Wording) -> list[dict[str, Any]]:
    """Return one row for every event of either log, before → after: start, duration, mean pressure and fluid."""
    rows = []
    for pair in logs.pairs:
        sides = (logs.before.road_test, pair.before), (logs.after.road_test, pair.after)
        parts = [None if event is None else test.window(event.start, event.stop) for test, event in sides]
        events = [event for _, event in sides]
        pressures = [_mean(part, "main_pressure", KPA) for part in parts]
        temperatures = [_mean(part, "atf_temperature", 1.0) for part in parts]
        rows.append(
            {
                "event": event_name(pair, say),
                "starts": _arrow([None if event is None else event.start for event in events], "time", 1, say),
                "lasts": _arrow([None if event is None else event.duration for event in events], "time", 1, say),
                "mean_pressure": _arrow(pressures, "pressure", 0, say),
                "fluid": _arrow(temperatures, "temperature", 0, say),
            }
        )
    return rows


def _arrow(values: Iterable[float | None], kind: str, digits: int, say: Wording) -> str:
    return " → ".join(say.value(value, kind, digits) for value in values)


def _mean(part: RoadTest | None, quantity: str, factor: float) -> float | None:
    values = None if part is None else part.values(quantity)
    if values is None or not np.isfinite(values).any():
        return None
    return float(np.nanmean(values)) * factor
