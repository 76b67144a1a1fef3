"""Rows of a unit's history as people read it: how each land wears, when it reaches its limits, how it stands."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

from atleak.catalogue.controller import Controller
from atleak.history.land_wear import LandLimit, LandWear, WearHistory
from atleak.history.totals import TotalOverMileage
from atleak.verdicts import Verdict
from atleak.views.land_names import land_words
from atleak.views.sentences import crossing_in_words
from atleak.wear_line import WearLine
from atleak.wording import Wording
from atleak.workshop_units import PERCENT, UM

PER = 1e4  # [km], or miles where people read those, for which they read a rate


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


def rate_in_words(line: WearLine | None, say: Wording) -> str | None:
    """Say how fast a clearance grows with its 90 % interval, per `PER` of distance; None where nothing tells it."""
    if line is None:
        return None
    per = PER / say.convert(1.0, "distance") * UM
    value, low, high = (say.value(each * per, "clearance", 2) for each in (line.rate, *line.rate_interval()))
    return say("history.rate" if line.certain else "history.no_wear", value=value, low=low, high=high)


def limit_in_words(limit: LandLimit, say: Wording) -> str:
    """Say at which mileage a limit of a land is reached; a dash where nothing tells it."""
    if limit.past:
        return say("history.reached")
    return "–" if limit.at is None else crossing_in_words(limit.at, say)


def levels_of(history: WearHistory) -> list[Verdict]:
    """Return the levels that any limit of any land leads to, the mildest first."""
    return sorted({limit.level for land in history.lands for limit in land.limits}, key=lambda level: level.rank)


def wear_rows(history: WearHistory, controller: Controller, say: Wording) -> list[dict[str, Any]]:
    """Return a row for each land: clearance, rate, and the mileage of each level's first limit, the soonest first."""
    levels = levels_of(history)
    rows: list[dict[str, Any]] = []
    for land in soonest_first(history):
        reached: dict[str, str] = {level: _first_at(land, level, say) for level in levels}
        points = land.series.measured
        rows.append(
            {
                "pair": land_words(controller, land.key, say),
                "clearance": points[-1].clearance * UM if points else None,
                "rate": rate_in_words(land.line, say),
                **reached,
                "visits": len(points),
                "since": _since(land, history, say),
            }
        )
    return rows


def _first_at(land: LandWear, level: Verdict, say: Wording) -> str:
    """Say when the first limit of a level is reached: a land may have one of wear and one of its own."""
    return next((limit_in_words(limit, say) for limit in land.limits if limit.level is level), "–")


def _since(land: LandWear, history: WearHistory, say: Wording) -> str | None:
    if land.series.restart is None or land.series.since is None:
        return None
    date = say.date(history.visits[land.series.since].date)
    return f"{date}: {say(f'restarts.{land.series.restart}')}"


def total_rows(totals: Iterable[TotalOverMileage], say: Wording) -> list[dict[str, Any]]:
    """Return a row for each condition: the total now and at the end of the way ahead, and when it reaches each band."""
    return [
        {
            "condition": say.condition(total.condition),
            "now": total.median[0] * PERCENT,
            "ahead": _within(total, -1, say),
            **{
                limit.level: say("history.reached") if limit.at is None else crossing_in_words(limit.at, say)
                for limit in total.limits
            },
        }
        for total in totals
    ]


def _within(total: TotalOverMileage, place: int, say: Wording) -> str:
    low, median, high = (say.number(each[place] * PERCENT, 1) for each in (total.low, total.median, total.high))
    return say("history.within", value=median, low=low, high=high)
