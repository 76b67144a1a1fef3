"""Show gauge readings as a table in a reader's language and units: what was shown, permitted, expected, the verdict."""

from __future__ import annotations

from typing import Any

from atleak.catalogue.circuits import StandingPressure
from atleak.gauges.check import CheckedReading, PressureCheck
from atleak.pressure_table import LINE
from atleak.views.condition_record import scaled
from atleak.views.table import VERDICT, Column
from atleak.wording import Wording
from atleak.workshop_units import KPA

GAUGE_COLUMNS = (
    Column("verdict", VERDICT, width=92),
    Column("range"),
    Column("engine_state"),
    Column("tap"),
    Column("reading_number", digits=0, width=44),
    Column("gauge", "pressure", 1),
    Column("permitted", words_of="pressure"),
    Column("expected", "pressure", 1),
    Column("lost", "pressure", 0),
    Column("lost_between", words_of="pressure"),
    Column("past_limit"),
    Column("decision", width=110),
)


def gauge_table_rows(check: PressureCheck, say: Wording) -> list[dict[str, Any]]:
    """Return a row for every reading as `GAUGE_COLUMNS` show it; one that nothing judges has no verdict."""
    repeated = any(each.reading.repeat > 1 for each in check.readings)
    circuits = any(each.cell.tap != LINE for each in check.readings)
    return [
        {
            "verdict": each.verdict,
            "range": each.cell.range,
            "engine_state": say.sentence(each.cell.engine.label),
            "tap": _tap(each, say) if circuits else None,
            "reading_number": each.reading.repeat if repeated else None,
            "gauge": each.reading.pressure * KPA,
            "permitted": _permitted(each.permissible, say),
            "expected": scaled(each.expected, KPA),
            "lost": scaled(each.loss, KPA),
            "lost_between": _between(each, say),
            "past_limit": None if each.over_limit is None else say.percent(each.over_limit, 0),
            "decision": say.get("decisions", each.deciding.decision) if each.deciding else None,
        }
        for each in check.readings
    ]


def _tap(each: CheckedReading, say: Wording) -> str:
    return say("permissible.line") if each.cell.tap == LINE else say.name(each.tap_name)


def _between(each: CheckedReading, say: Wording) -> str | None:
    if each.loss_interval is None:
        return None
    low, high = (say.value(max(end, 0.0) * KPA, "pressure", 0) for end in each.loss_interval)
    return say("permissible.low_and_high", low=low, high=high)


def _permitted(permissible: StandingPressure | None, say: Wording) -> str | None:
    if permissible is None:
        return None
    low, high = (
        "" if end is None else say.plain_value(end * KPA, "pressure") for end in (permissible.low, permissible.high)
    )
    return say(f"permissible.{'low_and_high' if low and high else 'low' if low else 'high'}", low=low, high=high)
