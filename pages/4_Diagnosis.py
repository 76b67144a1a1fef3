"""Show the diagnosis: how the unit stands, which pairs are past their limits, what they cost, what to repair."""

import streamlit as st

from atleak.analysis.repair.plan import plan_repairs
from atleak.report.charts import land_figures as figures
from atleak.report.json.diagnosis import diagnosis_record
from atleak.report.tables.lands import ON_PAPER, pair_table
from pages.shared import conditions, fields, files, pairs, panel, pressures, reader, repair_plan, road, show
from pages.shared.state import session

case, diagnosis = panel.shown()
record, say = diagnosis_record(diagnosis), reader.say()
st.title(say("diagnosis.title"))
show.answer(diagnosis)
show.first_sentence(diagnosis)
show.assumed(diagnosis)
show.missing(diagnosis)
conditions.complaint(diagnosis)
if diagnosis.without_sheet:
    if diagnosis.pressures is not None:
        st.subheader(say("diagnosis.gauges"))
        show.gauges(diagnosis.pressures)
    show.before_opening(diagnosis)
    if diagnosis.log is not None:
        road.alone(diagnosis)
    files.take_along(case, diagnosis, record)
    st.stop()

show.jumps(
    {"flagged-pairs": "diagnosis.flagged_pairs", "pressures": "diagnosis.pressures", "repair-plan": "repair_plan.title"}
)
pairs.section(diagnosis, pairs.advised(diagnosis, say))

st.subheader(say("diagnosis.totals"))
show.chart(figures.total_share(diagnosis, say), "share")
conditions.totals(diagnosis, record)

st.subheader(say("diagnosis.pressures"), anchor="pressures")
pressures.section(diagnosis, repair_plan.decided_totals(diagnosis))

st.subheader(say("diagnosis.matrix"))
conditions.matrix(diagnosis)

st.subheader(say("repair_plan.title"), anchor="repair-plan")
repair_plan.draw(diagnosis)
conditions.undecided(diagnosis, closing=False)
order = fields.fold(say("repair_plan.order"), key=f"order-of-repair-{session().generation}")
if order.open:
    with order:
        conditions.repairs(diagnosis, plan_repairs(diagnosis))

if diagnosis.pressures is not None:
    st.subheader(say("diagnosis.gauges"))
    show.gauges(diagnosis.pressures)
show.before_opening(diagnosis)
if diagnosis.log is not None:
    st.subheader(say("diagnosis.road"))
    road.findings(diagnosis)
    road.leakage(diagnosis)

st.subheader(say("diagnosis.rest"))
show.open_verdicts(pairs.advice(diagnosis, pairs.advised(diagnosis, say), say))
show.sheet_messages(diagnosis)
every = fields.fold(say("diagnosis.all_lands", count=len(diagnosis.lands)), key=f"all-lands-{session().generation}")
if every.open:
    with every:
        show.chart(figures.leakage_ranking(diagnosis, say), "ranking")
        pairs.table(
            pair_table(diagnosis, diagnosis.ranked, say, at=diagnosis.presented).without(*ON_PAPER),
            "all",
            pressable=True,
        )
files.take_along(case, diagnosis, record)
