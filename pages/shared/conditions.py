"""Show what depends on the condition: pressures, totals, the matrix of lands, the complaint, the order of repair."""

from __future__ import annotations

from collections.abc import Sequence

import streamlit as st

from atleak.analysis.pressures import lowest_first, pressures_at
from atleak.analysis.repair.plan import plan_repairs
from atleak.analysis.repair.totals import Total
from atleak.common.units import DM3_MIN, KPA, RPM
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.engine.projection import Projection
from atleak.report.charts.condition_figures import pump_speed_chart
from atleak.report.tables.answer import missing_table
from atleak.report.tables.before_opening import before_opening
from atleak.report.tables.complaint import finding, measure_first, reason
from atleak.report.tables.estimate import open_words
from atleak.report.tables.gauges import gauge_table
from atleak.report.tables.lands import leaking_worst_first, matrix_table
from atleak.report.tables.pressures import conditions_section, held_section, pump_over_speed
from atleak.report.tables.repairs import option_table, order_table, plan_ends, totals_table
from atleak.report.tables.sentences import counted_in_speed, land_in_words, position_sentence, shares_add_up
from pages.shared import fields, reader, show
from pages.shared.show import plain
from pages.shared.state import job, session

MEASURE_FIRST = 8  # lands named for a complaint; the others are in a fold


def complaint(diagnosis: Diagnosis) -> None:
    """Show the customer's complaint, where it can show, what explains it, and which lands to measure first."""
    if diagnosis.complaint is None:
        return
    say = reader.say()
    shows = ", ".join(f"**{plain(say.condition(each.condition))}**" for each in diagnosis.complained)
    ranked = measure_first(diagnosis)
    lines = [
        f"- **{plain(land_in_words(diagnosis, each.land.key, say))}**: {plain(reason(each, say))}" for each in ranked
    ]
    st.header(say("diagnosis.complaint", label=plain(say.name(diagnosis.complaint.label))))
    said = f"{say('diagnosis.complaint_shows', conditions=shows)} {plain(finding(diagnosis, say))}"
    st.markdown("\n".join([said, "", *lines[:MEASURE_FIRST]]))
    if lines[MEASURE_FIRST:]:
        with st.expander(say("diagnosis.complaint_more", count=len(lines) - MEASURE_FIRST)):
            st.markdown("\n".join(lines[MEASURE_FIRST:]))
    st.caption(plain(say("diagnosis.complaint_source", source=say.name(diagnosis.complaint.source))))


def pressures(diagnosis: Diagnosis, repaired: Sequence[Total]) -> None:
    """Show the pressures of a diagnosis: every condition in a table, one of them in full when it is asked for.

    Beside them stands what gauges showed, what is missing of it, and what else was measured before it was opened.
    """
    say = reader.say()
    if diagnosis.pressures is not None:
        st.header(say("diagnosis.gauges"))
        show.table(gauge_table(diagnosis.pressures, say))
    if diagnosis.missing_flagged:
        st.header(say("answer.split"))
        show.table(missing_table(diagnosis, say))
    for content in before_opening(diagnosis, say):
        st.header(content.title)
        show.section(content, content.name)
    if diagnosis.without_sheet:
        return
    st.header(say("diagnosis.pressures"))
    every = [pressures_at(diagnosis, each, repaired) for each in diagnosis.presented]
    show.section(conditions_section(diagnosis, every, say), "pressures")
    fields.unfold(say("circuits.in_full"), f"pressures-in-full-{session().generation}", _in_full, diagnosis, repaired)


@st.fragment
@show.faults()
def _in_full(diagnosis: Diagnosis, repaired: Sequence[Total]) -> None:
    """Show one condition in full; another one is chosen without computing the rest of the page again."""
    from atleak.report.charts.flows import flow_diagram, flow_svg, flow_table  # with the fonts, dear to import

    say = reader.say()
    conditions = {each.condition.name: each for each in lowest_first(diagnosis)}
    names = {name: say.condition(each.condition) for name, each in conditions.items()}
    key = f"pressures-at-{diagnosis.controller.id}"  # another valve body has other conditions
    projection = conditions[fields.one_of(say("circuits.at"), names, key)]
    condition = say.condition(projection.condition)
    _total(diagnosis, projection)
    at = pressures_at(diagnosis, projection, repaired)
    show.section(held_section(diagnosis, at, say), "pressures")
    st.markdown(f"**{say('circuits.pump_over_speed')}**")
    show.chart(pump_speed_chart(pump_over_speed(diagnosis, projection, say), say), "speed")
    st.caption(plain(say("circuits.pump_caption", condition=condition)))
    st.markdown(f"**{say('circuits.flow')}**")
    leaks_only = st.toggle(say("circuits.leaks_alone"), key="leaks-alone")
    diagram = flow_diagram(diagnosis, projection, leaks_only=leaks_only, say=say)
    title = say("circuits.flow_title", condition=condition)
    show.svg(flow_svg(diagram, title, say), title, diagram.columns)
    st.caption(plain(say("circuits.flow_caption")))
    with st.expander(say("circuits.flow_table")):
        show.table(flow_table(diagram, say))


def _total(diagnosis: Diagnosis, point: Projection) -> None:
    """Say the total at a condition, and from which speed the pump covers the leakage."""
    say = reader.say()
    label = say.condition(point.condition)
    if point is diagnosis.worst and len(diagnosis.presented) > 1:
        label = say("diagnosis.total_worst", condition=label)
    said = say(
        "diagnosis.total_line",
        condition=label,
        leakage=say.quantity(point.leakage * DM3_MIN, "flow"),
        capacity=say.quantity(point.pump_capacity * DM3_MIN, "flow"),
        pressure=say.quantity(point.condition.main_pressure * KPA, "pressure"),
        speed=say.number(point.condition.engine_speed * RPM, 0),
        new=say.quantity(diagnosis.new_at(point).leakage * DM3_MIN, "flow"),
        covered=say.number(point.minimum_speed * RPM, 0),
        counted=counted_in_speed(diagnosis, say),
        positions=position_sentence(diagnosis, point, say),
        source=say.name(point.condition.source),
    )
    st.caption(plain(said))


def matrix(diagnosis: Diagnosis) -> None:
    """Show every land that leaks at every condition: its share of the pump's flow with the sign of its verdict."""
    say = reader.say()
    rows = leaking_worst_first(diagnosis, diagnosis.presented)
    if not rows:
        st.write(say("diagnosis.matrix_none"))
        return
    show.table(matrix_table(diagnosis, rows, say), pinned="pair")
    added = shares_add_up(diagnosis, say)
    st.caption(plain(say("diagnosis.matrix_caption", added=added)))


def order_of_repair(diagnosis: Diagnosis) -> None:
    """Show in a fold the order of repair with what each step brings, and where it ends."""
    fields.unfold(reader.say()("repair_plan.order"), f"order-of-repair-{session().generation}", _order, diagnosis)


def _order(diagnosis: Diagnosis) -> None:
    say, plan = reader.say(), plan_repairs(diagnosis)
    if plan.order:
        show.table(order_table(diagnosis, plan, say))
        st.caption(say(f"repair_plan.order_caption_{'cost' if plan.cost else 'new'}"))
        if (options := option_table(plan, say)).rows:
            show.table(options)
            st.caption(say("repair_plan.planned"))
    st.markdown("  \n".join(map(plain, plan_ends(plan, say))))
    if plan.order and len(diagnosis.projections) > 1:
        st.markdown(f"**{say('repair_plan.every_step')}**")
        show.table(totals_table(diagnosis, plan, say), pinned="after_step")
        st.caption(say("repair_plan.every_step_caption"))


def undecided(diagnosis: Diagnosis, *, closing: bool) -> None:
    """Point out the lands that are to be replaced and about which nothing was decided, and reasons that lack."""
    say = reader.say()
    said = " ".join(open_words(diagnosis, job(), say, closing=closing))
    if said:
        st.warning(plain(say("repair_plan.estimate_place", said=said) if closing else said))
