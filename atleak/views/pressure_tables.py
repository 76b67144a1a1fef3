"""Show the pressures of a unit as tables: line and reserve at every condition, and every circuit at one."""

from __future__ import annotations

from collections.abc import Sequence

from atleak.diagnosis import Diagnosis
from atleak.verdicts import Verdict
from atleak.views.condition_record import finite
from atleak.views.gauge_rows import permissible_text
from atleak.views.pressures import HeldPressure, Interval, PressuresAt
from atleak.views.sentences import land_in_words, permissible_words
from atleak.views.table import VERDICT, Column, Table
from atleak.wording import Wording
from atleak.workshop_units import KPA, RPM


def condition_table(conditions: Sequence[PressuresAt], say: Wording) -> Table:
    """Return a row for every condition: what the line holds there, and the pump's reserve."""

    def worst(at: PressuresAt) -> Verdict | None:
        verdicts = (at.reserve_verdict, *(held.verdict for held in at.applied))
        return max((each for each in verdicts if each is not None), key=lambda each: each.rank, default=None)

    def within(at: PressuresAt) -> str | None:
        return at.reserve_interval and "–".join(say.number(end, 2) for end in at.reserve_interval)

    columns = (
        Column("verdict", VERDICT, width=92, of=worst),
        Column("condition", width=190, of=lambda at: say.condition(at.projection.condition)),
        Column("required", "pressure", of=lambda at: at.projection.condition.main_pressure, times=KPA),
        Column("held", "pressure", of=lambda at: at.line.now, times=KPA),
        Column("held_repaired", "pressure", of=lambda at: at.line.repaired, times=KPA),
        Column("reserve", digits=2, of=lambda at: finite(at.projection.reserve)),
        Column("reserve_is", of=lambda at: at.reserve_verdict and say.signed(at.reserve_verdict)),
        Column("covered_from", "engine_speed", of=lambda at: at.projection.minimum_speed, times=RPM),
        Column("permissible", of=lambda at: permissible_words(at.line, say) or None),
        Column("held_new", "pressure", of=lambda at: at.line.new, times=KPA),
        Column("held_low", "pressure", of=lambda at: _end(at.line.interval, 0), times=KPA),
        Column("held_high", "pressure", of=lambda at: _end(at.line.interval, 1), times=KPA),
        Column("reserve_within", of=within),
    )
    return Table("pressures", columns, conditions, say)


def held_table(diagnosis: Diagnosis, conditions: Sequence[PressuresAt], say: Wording) -> Table:
    """Return a row for the line and every circuit that is applied, at each of some conditions."""
    where = {id(held): at.projection.condition for at in conditions for held in at.applied}

    def costly(held: HeldPressure) -> str | None:
        costs = (
            f"{land_in_words(diagnosis, key, say)}: {say.quantity(loss * KPA, 'pressure')}" for key, loss in held.costly
        )
        return "; ".join(costs) or None

    def decision(held: HeldPressure) -> str | None:
        if held.decided is None:
            return None
        words, chance = say.get("decisions", held.decided.decision), held.decided.probability_over_limit
        return f"{words} ({say.percent(chance, 0)})"

    columns = (
        Column("verdict", VERDICT, width=92),
        Column("circuit", width=170, of=lambda each: say.name(each.circuit.name) if each.circuit else say("held.line")),
        Column("held", "pressure", of="now", times=KPA),
        Column("held_new", "pressure", of="new", times=KPA),
        Column("lost", "pressure", 1, of="loss", times=KPA),
        Column("lands_that_cost", width=300, of=costly),
        Column("held_repaired", "pressure", of="repaired", times=KPA),
        Column("set_pressure", "pressure", times=KPA),
        Column("permissible", words_of="pressure", of=lambda each: permissible_text(each.permissible, say)),
        Column("held_low", "pressure", of=lambda each: _end(each.interval, 0), times=KPA),
        Column("held_high", "pressure", of=lambda each: _end(each.interval, 1), times=KPA),
        Column("decision", width=100, of=decision),
    )
    rows = [held for at in conditions for held in at.applied]
    return Table("circuits", columns, rows, say, group=lambda held: say.condition(where[id(held)]))


def _end(interval: Interval | None, end: int) -> float | None:
    return None if interval is None else interval[end]
