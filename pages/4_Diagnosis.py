"""Show the diagnosis: which pairs are past their limits, what they cost, what to repair first."""

import streamlit as st

from atleak.figures import diagnosis_figures as figures
from atleak.repair import plan_repairs
from atleak.views.diagnosis_record import diagnosis_record
from pages.shared import conditions, files, panel, pressures, road, show, words

case, diagnosis = panel.shown()
record = diagnosis_record(diagnosis)
st.title("Diagnosis")
show.banner(diagnosis, words.verdict_sentence(diagnosis, record))
conditions.complaint(diagnosis)
if diagnosis.without_sheet:
    if diagnosis.pressures is not None:
        st.subheader("What gauges show")
        show.gauges(diagnosis.pressures)
    if diagnosis.log is not None:
        road.alone(diagnosis)
    files.take_along(case, diagnosis, record)
    st.stop()

st.subheader("Flagged pairs")
if diagnosis.flagged:
    show.verdict_table(words.land_rows(diagnosis, record, diagnosis.flagged, brief=True), words.DIGITS)
else:
    st.write("No measured land has reached a limit.")
show.what_is_shown(diagnosis)
show.open_verdicts(words.advice(diagnosis))
show.sheet_messages(diagnosis)

st.subheader("Total share of the pump's flow")
show.chart(figures.total_share(diagnosis), "share")
conditions.totals(diagnosis, record)

st.subheader("Pressures")
plan = plan_repairs(diagnosis)
pressures.section(diagnosis, plan)

st.subheader("Land by condition")
conditions.matrix(diagnosis)

st.subheader("Order of repair")
conditions.repairs(diagnosis, plan)
conditions.undecided(diagnosis, closing=False)

with st.expander("Where they are: the valve body's picture"):
    show.controller_picture(diagnosis)

if diagnosis.pressures is not None:
    st.subheader("What gauges show")
    show.gauges(diagnosis.pressures)

if diagnosis.log is not None:
    st.subheader("Over the road test")
    road.findings(diagnosis)
    road.leakage(diagnosis)

st.subheader("Lands by leakage")
show.chart(figures.leakage_ranking(diagnosis), "ranking")
with st.expander(f"All {len(diagnosis.lands)} lands"):
    show.verdict_table(words.land_rows(diagnosis, record, diagnosis.ranked), words.DIGITS)

files.take_along(case, diagnosis, record)
