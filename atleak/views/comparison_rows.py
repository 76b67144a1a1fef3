"""Lay out a comparison as tables: lands, totals, pressures and the events of two logs."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from atleak.comparison import Change, Comparison, ConditionComparison, EventPair, LandComparison, LogComparison
from atleak.land_diagnosis import LandDiagnosis
from atleak.road_test import RoadTest
from atleak.views.comparison_words import event_name, land_name, signed_number, with_uncertainty
from atleak.views.condition_record import finite
from atleak.views.table import VERDICT, Column, Table, columns
from atleak.wording import Wording
from atleak.workshop_units import DM3_MIN, KPA, PERCENT, UM

_OF_A_QUANTITY = ("condition", "what", "before", "after", "change", "interval", "unit", "changed")
_SHOWN = 0.5  # [kPa] that a pressure without decimals shows
_UM = "clearance", 1


def land_table(comparison: Comparison, lands: Sequence[LandComparison], say: Wording) -> Table:
    """Return one row for every land: both verdicts, clearances and what changed, wear, share and decision."""

    def both(key: str, of: Callable[[LandDiagnosis], Any], *kind: Any, times: float | None = None) -> Iterator[Column]:
        def at(side: str, land: LandComparison) -> Any:
            diagnosed: LandDiagnosis | None = getattr(land, side)
            return None if diagnosed is None else of(diagnosed)

        for side in ("before", "after"):
            yield replace(Column(f"{key}_{side}", *kind), of=partial(at, side), times=times)

    shown = (
        Column("verdict", VERDICT, width=92, of=lambda land: land.after and land.after.verdict),
        Column("was", of=lambda land: land.before and say.signed(land.before.verdict)),
        Column("pair", width=176, of=lambda land: land_name(comparison, land, say)),
        *both("clearance", lambda land: land.state.radial_clearance if land.state.measured else None, *_UM, times=UM),
        Column("change", words_of="clearance", of=lambda land: land.change and with_uncertainty(land.change, say)),
        Column("changed", of=lambda land: land.change and land.significant),
        *both("wear", lambda land: land.wear, "percent", 1, times=PERCENT),
        *both("share", lambda land: finite(land.share), "percent", 2, times=PERCENT),
        *both("decision", lambda land: land.decision and say.get("decisions", land.decision)),
    )
    return Table("lands", shown, lands, say).filled


def condition_table(comparison: Comparison, say: Wording, *, brief: bool = False) -> Table:
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
    return Table("totals", columns(*_OF_A_QUANTITY), rows, say).filled


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
        "changed": change.significant,
    }


def _interval(ends: tuple[float, float], scale: float, places: int, say: Wording) -> str:
    low, high = (say.number(end * scale, places) for end in ends)
    return say("written.to", low=low, high=high)


def event_table(logs: LogComparison, say: Wording) -> Table:
    """Return one row for every event of either log, before → after: start, duration, mean pressure and fluid."""

    def means(pair: EventPair, quantity: str, factor: float) -> list[float | None]:
        sides = (logs.before.road_test, pair.before), (logs.after.road_test, pair.after)
        return [
            _mean(None if event is None else test.window(event.start, event.stop), quantity, factor)
            for test, event in sides
        ]

    def both(pair: EventPair, name: str) -> list[float | None]:
        return [None if event is None else getattr(event, name) for event in (pair.before, pair.after)]

    def arrow(key: str, kind: str, digits: int, of: Callable[[EventPair], Iterable[float | None]]) -> Column:
        return Column(key, words_of=kind, of=lambda pair: " → ".join(say.value(at, kind, digits) for at in of(pair)))

    shown = (
        Column("event", of=lambda pair: event_name(pair, say)),
        arrow("starts", "time", 1, lambda pair: both(pair, "start")),
        arrow("lasts", "time", 1, lambda pair: both(pair, "duration")),
        arrow("mean_pressure", "pressure", 0, lambda pair: means(pair, "main_pressure", KPA)),
        arrow("fluid", "temperature", 0, lambda pair: means(pair, "atf_temperature", 1.0)),
    )
    return Table("logs", shown, logs.pairs, say)


def _mean(part: RoadTest | None, quantity: str, factor: float) -> float | None:
    values = None if part is None else part.values(quantity)
    if values is None or not np.isfinite(values).any():
        return None
    return float(np.nanmean(values)) * factor
