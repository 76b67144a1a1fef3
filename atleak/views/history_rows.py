"""Rows of a unit's history as people read it: how each land wears, when it reaches its limits, how it stands."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

from atleak.catalogue.controller import Controller
from atleak.history.land_wear import LandLimit, LandWear, WearHistory
from atleak.history.series import Restart
from atleak.history.totals import TotalOverMileage
from atleak.rules import LandKey
from atleak.verdicts import Verdict
from atleak.views.sentences import crossing_in_words
from atleak.wear_line import WearLine
from atleak.wording import isolated, signed, wording
from atleak.workshop_units import PERCENT, UM

PER_10_000 = 1e4  # [km] for which people read a rate
NO_WEAR = "no wear that can be told from measurement"
_SINCE = {
    Restart.REPAIRED: "repaired",
    Restart.FITTED: "another part",
    Restart.NARROWER: "narrower",
    Restart.ODOMETER: "mileage falls",
}


def land_name(controller: Controller, key: LandKey) -> str:
    """Name a land, its number first, so that a narrow column cuts the name only: ``25/1 main pressure valve``."""
    component, land = key
    return f"{component}/{land} {isolated(controller.components.get(component, ''))}".strip()


def soonest_first(history: WearHistory) -> tuple[LandWear, ...]:
    """Return the lands by the mileage at which they reach their next limit, those past one first, unknown ones last."""
    return tuple(sorted(history.lands, key=lambda land: (-_past(land), _soonest(land))))


def _past(land: LandWear) -> int:
    return max((limit.level.rank for limit in land.limits if limit.past), default=0)


def _soonest(land: LandWear) -> tuple[float, float]:
    limit = land.next_limit
    if limit is None or limit.at is None:
        return math.inf, math.inf
    return (limit.at.value, limit.at.low) if land.line is not None and land.line.certain else (math.inf, limit.at.low)


def rate_in_words(line: WearLine | None) -> str | None:
    """Say how fast a clearance grows [µm per 10 000 km] with its 90 % interval; None where nothing tells it."""
    if line is None:
        return None
    value, low, high = (f"{each * PER_10_000 * UM:z.2f}" for each in (line.rate, *line.rate_interval()))
    said = f"{value} ({low} to {high})" if line.certain else f"{NO_WEAR} ({low} to {high})"
    return said.replace("-", "−")


def limit_in_words(limit: LandLimit) -> str:
    """Say at which mileage a limit of a land is reached; a dash where nothing tells it."""
    if limit.past:
        return "reached"
    return "–" if limit.at is None else crossing_in_words(limit.at, wording("en"))


def wear_rows(history: WearHistory, controller: Controller) -> list[dict[str, Any]]:
    """Return a row for each land: clearance, rate, and the mileage of each level's first limit, the soonest first."""
    levels = sorted({limit.level for land in history.lands for limit in land.limits}, key=lambda level: level.rank)
    rows = []
    for land in soonest_first(history):
        points = land.series.measured
        rows.append(
            {
                "Pair": land_name(controller, land.key),
                "Clearance [µm]": points[-1].clearance * UM if points else None,
                "µm per 10 000 km": rate_in_words(land.line),
                **{_at_level(level): _first_at(land, level) for level in levels},
                "Visits": len(points),
                "Since": _since(land, history),
            }
        )
    return rows


def _at_level(level: Verdict) -> str:
    return f"{signed(level)} at"


def _first_at(land: LandWear, level: Verdict) -> str:
    """Say when the first limit of a level is reached: a land may have one of wear and one of its own."""
    return next((limit_in_words(limit) for limit in land.limits if limit.level is level), "–")


def _since(land: LandWear, history: WearHistory) -> str | None:
    if land.series.restart is None or land.series.since is None:
        return None
    return f"{history.visits[land.series.since].date.isoformat()}: {_SINCE[land.series.restart]}"


def total_rows(totals: Iterable[TotalOverMileage]) -> list[dict[str, Any]]:
    """Return a row for each condition: the total now and at the end of the way ahead, and when it reaches each band."""
    return [
        {
            "Condition": total.condition.label,
            "Now [%]": total.median[0] * PERCENT,
            f"At {wording('en').number(total.mileages[-1], 0)} km [%]": _within(total, -1),
            **{
                f"{signed(limit.level)} at": "reached"
                if limit.at is None
                else crossing_in_words(limit.at, wording("en"))
                for limit in total.limits
            },
        }
        for total in totals
    ]


def _within(total: TotalOverMileage, place: int) -> str:
    low, median, high = (each[place] * PERCENT for each in (total.low, total.median, total.high))
    return f"{median:.1f} ({low:.1f} to {high:.1f})"
