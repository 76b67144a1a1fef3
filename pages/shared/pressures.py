"""Show the pressures: what the line and every circuit hold, the pump's reserve, and where its flow goes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import streamlit as st

from atleak.diagnosis import Diagnosis
from atleak.figures import pressure_figures as figures
from atleak.repair import Total
from atleak.views.flow_diagram import flow_diagram, flow_rows
from atleak.views.flow_svg import flow_svg
from atleak.views.pressures import HeldPressure, PressuresAt, lowest_first, pressures_at
from atleak.views.pump_speed import pump_over_speed
from atleak.views.pump_words import pump_sentence
from atleak.views.sentences import (
    full_stroke,
    land_in_words,
    permissible_words,
    pressure_sentence,
    reserve_sentence,
    unsolved,
)
from atleak.views.table import VERDICT, Column
from atleak.wording import Wording
from atleak.workshop_units import KPA, RPM
from pages.shared import fields, reader, show
from pages.shared.show import plain
from pages.shared.state import session

_CONDITIONS = (
    Column("verdict", VERDICT, width=92),
    Column("condition", width=190),
    Column("required", "pressure"),
    Column("held", "pressure"),
    Column("held_repaired", "pressure"),
    Column("reserve", digits=2),
    Column("reserve_is"),
    Column("covered_from", "engine_speed"),
    Column("permissible"),
    Column("held_new", "pressure"),
    Column("held_low", "pressure"),
    Column("held_high", "pressure"),
    Column("reserve_within"),
)
_CIRCUITS = (
    Column("verdict", VERDICT, width=92),
    Column("circuit", width=170),
    Column("held", "pressure"),
    Column("held_new", "pressure"),
    Column("lost", "pressure", 1),
    Column("lands_that_cost", width=300),
    Column("held_repaired", "pressure"),
    Column("set_pressure", "pressure"),
    Column("held_low", "pressure"),
    Column("held_high", "pressure"),
    Column("decision"),
)
_FLOWS = (
    Column("verdict", VERDICT, width=92),
    Column("flows_from"),
    Column("flows_to"),
    Column("flow", "flow", 3),
)
_COLUMN = 135  # pixels of the drawing of flows, at which its words can be read


def section(diagnosis: Diagnosis, repaired: Sequence[Total]) -> None:
    """Show the pressures of a diagnosis: every condition in a table, one of them in full when it is asked for.

    Parameters
    ----------
    repaired
        the totals with the repairs made that were decided; none where nothing was.
    """
    say = reader.say()
    for sentence in (unsolved(diagnosis, say), pump_sentence(diagnosis, say)):
        if sentence is not None:
            st.write(plain(sentence))
    every = [pressures_at(diagnosis, each, repaired) for each in diagnosis.presented]
    _table([_condition_row(each, say) for each in every], _CONDITIONS)
    st.caption(plain(" ".join(filter(None, (say("circuits.conditions"), full_stroke(diagnosis, say))))))
    fold = fields.fold(say("circuits.in_full"), key=f"pressures-in-full-{session().generation}")
    if fold.open:
        with fold:
            _in_full(diagnosis, repaired)


@st.fragment
@show.faults()
def _in_full(diagnosis: Diagnosis, repaired: Sequence[Total]) -> None:
    """Show one condition in full; another one is chosen without computing the rest of the page again."""
    say = reader.say()
    conditions = {each.condition.name: each for each in lowest_first(diagnosis)}
    chosen = st.selectbox(
        say("circuits.at"),
        list(conditions),
        format_func=lambda name: say.condition(conditions[name].condition),
        key=f"pressures-at-{diagnosis.controller.id}",  # another valve body has other conditions
    )
    projection = conditions[chosen]
    condition = say.condition(projection.condition)
    at = pressures_at(diagnosis, projection, repaired)
    st.markdown(f"{plain(pressure_sentence(at, say))}  \n{plain(reserve_sentence(at, say))}")
    show.chart(figures.circuit_pressures(at, say), "circuits")
    if at.circuits:
        _table([_held_row(diagnosis, each, say) for each in at.applied], _CIRCUITS)
        vented = ", ".join(say.name(each.circuit.name) for each in at.circuits if each.vented and each.circuit)
        empty = say("circuits.vented", circuits=vented) if vented else ""
        st.caption(plain(f"{say('circuits.lost')} {empty}".rstrip()))
    st.markdown(f"**{say('circuits.pump_over_speed')}**")
    show.chart(figures.pump_over_speed(pump_over_speed(diagnosis, projection, say), say), "speed")
    st.caption(plain(say("circuits.pump_caption", condition=condition)))
    st.markdown(f"**{say('circuits.flow')}**")
    leaks_only = st.toggle(say("circuits.leaks_alone"), key="leaks-alone")
    diagram = flow_diagram(diagnosis, projection, leaks_only=leaks_only, say=say)
    title = say("circuits.flow_title", condition=condition)
    show.svg(flow_svg(diagram, title, say), title, least_width=_COLUMN * diagram.columns)
    st.caption(plain(say("circuits.flow_caption")))
    with st.expander(say("circuits.flow_table")):
        show.rows_table(flow_rows(diagram), _FLOWS)


def _condition_row(at: PressuresAt, say: Wording) -> dict[str, Any]:
    low, high = at.line.interval or (None, None)
    verdicts = [each for each in (at.reserve_verdict, *(held.verdict for held in at.applied)) if each is not None]
    reserve = at.projection.reserve
    return {
        "verdict": max(verdicts, key=lambda each: each.rank, default=None),
        "condition": say.condition(at.projection.condition),
        "required": at.projection.condition.main_pressure * KPA,
        "held": at.line.now * KPA,
        "held_repaired": _scaled(at.line.repaired),
        "reserve": reserve if math.isfinite(reserve) else None,
        "reserve_is": None if at.reserve_verdict is None else say.signed(at.reserve_verdict),
        "covered_from": at.projection.minimum_speed * RPM,
        "permissible": permissible_words(at.line, say) or None,
        "held_new": at.line.new * KPA,
        "held_low": _scaled(low),
        "held_high": _scaled(high),
        "reserve_within": _within(at.reserve_interval, say),
    }


def _within(interval: tuple[float, float] | None, say: Wording) -> str | None:
    return None if interval is None else "–".join(say.number(end, 2) for end in interval)


def _held_row(diagnosis: Diagnosis, held: HeldPressure, say: Wording) -> dict[str, Any]:
    low, high = held.interval or (None, None)
    costs = "; ".join(
        f"{land_in_words(diagnosis, key, say)}: {say.quantity(loss * KPA, 'pressure')}" for key, loss in held.costly
    )
    decided = None if held.decided is None else held.decided.decision
    return {
        "verdict": held.verdict,
        "circuit": say("held.line") if held.circuit is None else say.name(held.circuit.name),
        "held": held.now * KPA,
        "held_new": held.new * KPA,
        "lost": held.loss * KPA,
        "lands_that_cost": costs or None,
        "held_repaired": _scaled(held.repaired),
        "set_pressure": _scaled(held.set_pressure),
        "held_low": _scaled(low),
        "held_high": _scaled(high),
        "decision": None if decided is None else say.get("decisions", decided),
    }


def _scaled(pressure: float | None) -> float | None:
    return None if pressure is None else pressure * KPA


def _table(rows: list[dict[str, Any]], columns: Sequence[Column]) -> None:
    """Show rows without the columns that none has a value in."""
    show.rows_table(rows, [each for each in columns if any(row[each.key] is not None for row in rows)])
