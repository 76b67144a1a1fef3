"""Rows of a unit's history as people read it: how each land wears, when it reaches its limits, how it stands."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

from atleak.analysis.history.wear import LandLimit, LandWear, TotalOverMileage, WearHistory
from atleak.common.units import PERCENT, UM
from atleak.common.verdicts import Band, Verdict
from atleak.common.wording import Wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.land import WearLine
from atleak.report.tables.names import land_words
from atleak.report.tables.sentences import consequence_words, crossing_in_words
from atleak.report.tables.table import Column, Table

PER = 1e4  # [km], or miles where people read those, for which they read a rate


def soonest_first(history: WearHistory) -> tuple[LandWear, ...]:
    """Return the lands by the mileage at which they reach their next limit, those past one first, unknown ones last."""

    def order(land: LandWear) -> tuple[int, tuple[float, float]]:
        return -max((limit.level.rank for limit in land.limits if limit.past), default=0), _soonest(land)

    return tuple(sorted(history.lands, key=order))


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


def wear_table(history: WearHistory, diagnosis: Diagnosis, say: Wording) -> Table:
    """Return a row for each land: clearance, rate, and the mileage of each level's first limit, the soonest first.

    Parameters
    ----------
    diagnosis
        of the last visit that measured; what wear does by the next service follows from the lines of all visits.
    """
    lines = {land.key: land.line for land in history.lands if land.line is not None}
    last = replace(diagnosis, lines_of_visits=lines, mileage=history.present)
    by_key = {land.key: land for land in last.lands}

    def consequence(land: LandWear) -> str | None:
        return consequence_words(last, by_key[land.key], say) if land.key in by_key else None

    def clearance(land: LandWear) -> float | None:
        return land.series.measured[-1].clearance if land.series.measured else None

    def first_at(level: Verdict, land: LandWear) -> str | None:
        """Say when the first limit of a level is reached: a land may have one of wear and one of its own."""
        return next((limit_in_words(limit, say) for limit in land.limits if limit.level is level), None)

    distance = f"{say.number(PER, 0)} {say.unit('distance')}"
    rate = say("history.rate_heading", unit=say.unit("clearance"), distance=distance)
    columns = (
        Column("pair", width=150, of=lambda land: land_words(diagnosis.controller, land.key, say)),
        Column("clearance", "clearance", of=clearance, times=UM),
        Column("rate", words=rate, of=lambda land: rate_in_words(land.line, say)),
        *(_at(level, partial(first_at, level), say) for level in levels_of(history)),
        Column("consequence", width=150, of=consequence),
        Column("visits", digits=0, of=lambda land: len(land.series.measured)),
        Column("since", of=lambda land: _since(land, history, say)),
    )
    return Table("wear", columns, soonest_first(history), say)


def _at(level: Verdict | Band, of: Callable[[Any], str | None], say: Wording) -> Column:
    return Column(level, words=say("history.at", level=say.signed(level)), of=of)


def _since(land: LandWear, history: WearHistory, say: Wording) -> str | None:
    if land.series.restart is None or land.series.since is None:
        return None
    date = say.date(history.visits[land.series.since].date)
    return f"{date}: {say(f'restarts.{land.series.restart}')}"


def total_table(totals: Sequence[TotalOverMileage], say: Wording) -> Table:
    """Return a row for each condition: the total now and at the end of the way ahead, and when it reaches each band."""

    def reached(level: Verdict | Band, total: TotalOverMileage) -> str | None:
        limit = next((limit for limit in total.limits if limit.level is level), None)
        if limit is None:
            return None
        return say("history.reached") if limit.at is None else crossing_in_words(limit.at, say)

    ahead = say("history.ahead", mileage=say.quantity(totals[0].mileages[-1], "distance", 0))
    levels = dict.fromkeys(limit.level for total in totals for limit in total.limits)
    columns = (
        Column("condition", width=150, of=lambda total: say.condition(total.condition)),
        Column("now", "percent", of=lambda total: total.median[0], times=PERCENT),
        Column("ahead", words=f"{ahead} [%]", of=lambda total: _within(total, -1, say)),
        *(_at(level, partial(reached, level), say) for level in levels),
    )
    return Table("totals", columns, totals, say)


def _within(total: TotalOverMileage, place: int, say: Wording) -> str:
    low, median, high = (say.number(each[place] * PERCENT, 1) for each in (total.low, total.median, total.high))
    return say("history.within", value=median, low=low, high=high)
