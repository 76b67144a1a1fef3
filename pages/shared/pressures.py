"""Show the pressures: what the line and every circuit hold, the pump's reserve, and where its flow goes."""

from __future__ import annotations

from collections.abc import Sequence

import streamlit as st

from atleak.analysis.pressures import lowest_first, pressures_at
from atleak.analysis.repair.totals import Total
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.report.charts.condition_figures import pump_speed_chart
from atleak.report.charts.flows import flow_diagram, flow_svg, flow_table
from atleak.report.tables.pressures import conditions_section, held_section, pump_over_speed
from pages.shared import answer, fields, reader, show
from pages.shared.conditions import total
from pages.shared.show import plain
from pages.shared.state import session

_COLUMN = 135  # pixels of the drawing of flows, at which its words can be read


def section(diagnosis: Diagnosis, repaired: Sequence[Total]) -> None:
    """Show the pressures of a diagnosis: every condition in a table, one of them in full when it is asked for.

    Beside them stands what gauges showed, what is missing of it, and what else was measured before it was opened.
    """
    say = reader.say()
    if diagnosis.pressures is not None:
        st.subheader(say("diagnosis.gauges"))
        show.gauges(diagnosis.pressures)
    answer.missing(diagnosis)
    show.before_opening(diagnosis)
    if diagnosis.without_sheet:
        return
    st.subheader(say("diagnosis.pressures"))
    every = [pressures_at(diagnosis, each, repaired) for each in diagnosis.presented]
    show.section(conditions_section(diagnosis, every, say), "pressures")
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
    total(diagnosis, projection)
    at = pressures_at(diagnosis, projection, repaired)
    show.section(held_section(diagnosis, at, say), "pressures")
    st.markdown(f"**{say('circuits.pump_over_speed')}**")
    show.chart(pump_speed_chart(pump_over_speed(diagnosis, projection, say), say), "speed")
    st.caption(plain(say("circuits.pump_caption", condition=condition)))
    st.markdown(f"**{say('circuits.flow')}**")
    leaks_only = st.toggle(say("circuits.leaks_alone"), key="leaks-alone")
    diagram = flow_diagram(diagnosis, projection, leaks_only=leaks_only, say=say)
    title = say("circuits.flow_title", condition=condition)
    show.svg(flow_svg(diagram, title, say), title, least_width=_COLUMN * diagram.columns)
    st.caption(plain(say("circuits.flow_caption")))
    with st.expander(say("circuits.flow_table")):
        show.table(flow_table(diagram, say))
