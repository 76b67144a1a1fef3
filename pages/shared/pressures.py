"""Show the pressures: what the line and every circuit hold, the pump's reserve, and where its flow goes."""

from __future__ import annotations

import math
from typing import Any

import streamlit as st

from atleak.catalogue.circuits import PermissiblePressure
from atleak.diagnosis import Diagnosis
from atleak.figures import pressure_figures as figures
from atleak.repair import RepairPlan
from atleak.uncertainty import RuleDecision
from atleak.views.flow_diagram import flow_diagram, flow_rows
from atleak.views.flow_svg import flow_svg
from atleak.views.pressures import HeldPressure, PressuresAt, lowest_first, pressures_at
from atleak.views.pump_speed import pump_over_speed
from atleak.views.pump_words import full_stroke, pump_sentence
from atleak.views.sentences import pressure_sentence, reserve_sentence, unsolved
from atleak.wording import signed, wording
from atleak.workshop_units import KPA, RPM
from pages.shared import show
from pages.shared.show import plain

DIGITS = {
    **dict.fromkeys(("Required [kPa]", "Held [kPa]", "Low [kPa]", "High [kPa]", "New [kPa]", "Lost [kPa]"), 0),
    "Lost [kPa]": 1,
    "After repair [kPa]": 0,
    "Reserve": 2,
    "Covered from [rpm]": 0,
    "Flow [dm³/min]": 4,
}

_COLUMN = 135  # pixels of the drawing of flows, at which its words can be read


def section(diagnosis: Diagnosis, plan: RepairPlan) -> None:
    """Show the pressures of a diagnosis: every condition in a table, one of them in full."""
    every = [pressures_at(diagnosis, each, plan) for each in diagnosis.presented]
    said = unsolved(diagnosis, wording("en"))
    for sentence in (said, pump_sentence(diagnosis, wording("en"))):
        if sentence is not None:
            st.write(plain(sentence))
    show.verdict_table(_filled([_condition_row(each) for each in every]), DIGITS)
    st.caption(
        "Reserve: how many times the pump supplies what leakage, slip and consumers take at the required pressure; "
        "under 1 main pressure falls. Low to high, and the reserve within: 95 % intervals. The verdict is the worst of "
        f"reserve, permissible main pressure and circuits.{_of_full_stroke(diagnosis)}"
    )
    _in_full(diagnosis, plan)


def _of_full_stroke(diagnosis: Diagnosis) -> str:
    said = full_stroke(diagnosis, wording("en"))
    return "" if said is None else f" {said}"


@st.fragment
def _in_full(diagnosis: Diagnosis, plan: RepairPlan) -> None:
    """Show one condition in full; another one is chosen without computing the rest of the page again."""
    say = wording("en")
    conditions = {each.condition.name: each for each in lowest_first(diagnosis)}
    chosen = st.selectbox(
        "Pressures in full at",
        list(conditions),
        format_func=lambda name: conditions[name].condition.label,
        key=f"pressures-at-{diagnosis.controller.id}",  # another valve body has other conditions
    )
    projection = conditions[chosen]
    at = pressures_at(diagnosis, projection, plan)
    st.markdown(f"{plain(pressure_sentence(at, say))}  \n{plain(reserve_sentence(at, say))}")
    show.chart(figures.circuit_pressures(at), "circuits")
    if at.circuits:
        show.verdict_table(_filled([_held_row(each) for each in at.applied]), DIGITS)
        vented = ", ".join(each.circuit.name for each in at.circuits if each.vented and each.circuit)
        empty = f" Not applied in this gear: {plain(vented)}." if vented else ""
        st.caption(
            "Lost is against the same unit new, with pairs as wide as these may have been then; a rise is judged "
            f"too.{empty}"
        )
    st.markdown("**Pump over engine speed**")
    show.chart(figures.pump_over_speed(pump_over_speed(diagnosis, projection)), "speed")
    st.caption(
        "The rising line is what the pump supplies; each level line is what leakage, slip and consumers take with "
        f"fluid of that temperature, at the pressure required at {plain(projection.condition.label)}. From where they "
        "cross that pressure holds; at any speed the pump's line over the level one is the reserve."
    )
    st.markdown("**Where the flow goes**")
    leaks_only = st.toggle("The leaks alone, drawn larger", key="leaks-alone")
    diagram = flow_diagram(diagnosis, projection, leaks_only=leaks_only)
    title = f"Where the flow goes, {projection.condition.label}; the same stands as a table below"
    show.svg(flow_svg(diagram, title), title, least_width=_COLUMN * diagram.columns)
    st.caption(
        "Flows in dm³/min at the pressures that hold; a ribbon is as wide as its flow, shade and sign are verdicts."
    )
    with st.expander("The same as a table"):
        show.table([{**row, "Verdict": _signed(row["Verdict"])} for row in flow_rows(diagram)])


def _signed(verdict: Any) -> str | None:
    return signed(verdict) if verdict else None


def _condition_row(at: PressuresAt) -> dict[str, Any]:
    point, line = at.projection.condition, at.line
    low, high = line.interval or (None, None)
    verdicts = [each for each in (at.reserve_verdict, *(held.verdict for held in at.applied)) if each is not None]
    reserve = at.projection.reserve
    return {
        "Verdict": max(verdicts, key=lambda each: each.rank, default=None),
        "Operating point": point.label,
        "Required [kPa]": point.main_pressure * KPA,
        "Held [kPa]": line.now * KPA,
        "Reserve": reserve if math.isfinite(reserve) else None,
        "Reserve is": None if at.reserve_verdict is None else signed(at.reserve_verdict),
        "Covered from [rpm]": at.projection.minimum_speed * RPM,
        "Permissible [kPa]": _permissible(line.permissible),
        "New [kPa]": line.new * KPA,
        "Low [kPa]": _scaled(low),
        "High [kPa]": _scaled(high),
        "Reserve within": _within(at.reserve_interval),
    }


def _within(interval: tuple[float, float] | None) -> str | None:
    return None if interval is None else " to ".join(f"{end:.2f}" for end in interval)


def _permissible(stated: PermissiblePressure | None) -> str | None:
    if stated is None:
        return None
    low, high = (None if end is None else f"{end * KPA:.0f}" for end in (stated.low, stated.high))
    return f"{low} to {high}" if low and high else f"from {low}" if low else f"up to {high}"


def _held_row(held: HeldPressure) -> dict[str, Any]:
    low, high = held.interval or (None, None)
    costs = "; ".join(f"{component}/{land}: {loss * KPA:.0f} kPa" for (component, land), loss in held.costly)
    return {
        "Verdict": held.verdict,
        "Circuit": figures.LINE_NAME if held.circuit is None else held.circuit.name,
        "Held [kPa]": held.now * KPA,
        "New [kPa]": held.new * KPA,
        "Lost [kPa]": held.loss * KPA,
        "Lands that cost it": costs or None,
        "After repair [kPa]": _scaled(held.repaired),
        "Set [kPa]": None if held.set_pressure is None else f"{held.set_pressure * KPA:.0f}",
        "Low [kPa]": _scaled(low),
        "High [kPa]": _scaled(high),
        "Decision": _decision(held.decided),
    }


def _decision(decided: RuleDecision | None) -> str | None:
    return None if decided is None or decided.decision is None else decided.decision.replace("_", " ")


def _scaled(pressure: float | None) -> float | None:
    return None if pressure is None else pressure * KPA


def _filled(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Leave out the columns that no row has a value in."""
    names = [name for name in rows[0] if any(row[name] is not None for row in rows)]
    return [{name: row[name] for name in names} for row in rows]
