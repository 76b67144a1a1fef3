"""Show the diagnosis: which pairs are past their limits, what they cost, what to repair first."""

from pathlib import Path

import streamlit as st

from atleak.figures import diagnosis_figures as figures
from atleak.repair import plan_repairs
from atleak.report.xlsx import write_workbook
from atleak.views.diagnosis_record import diagnosis_record, to_json
from pages.shared import conditions, panel, pressures, show, words

case, diagnosis = panel.shown()
record = diagnosis_record(diagnosis)
st.title("Diagnosis")
show.banner(diagnosis, words.verdict_sentence(diagnosis, record))
conditions.complaint(diagnosis)

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

with st.expander("Where they are: the valve body's picture"):
    show.controller_picture(diagnosis)

if diagnosis.road is not None:
    st.subheader("Over the road test")
    show.chart(figures.road_leakage(diagnosis.road, diagnosis.limits), "road")
    show.extremes(diagnosis.road, diagnosis.uncertainty)
    show.log_messages(diagnosis)

st.subheader("Lands by leakage")
show.chart(figures.leakage_ranking(diagnosis), "ranking")
with st.expander(f"All {len(diagnosis.lands)} lands"):
    show.verdict_table(words.land_rows(diagnosis, record, diagnosis.ranked), words.DIGITS)

st.subheader("Take it along")
with st.container(horizontal=True):
    name = f"diagnosis_{Path(case.readings.name).stem if case.readings else diagnosis.controller.id}"
    st.download_button("JSON", lambda: to_json(record), f"{name}.json", on_click="ignore")
    st.download_button("Excel workbook", lambda: write_workbook(diagnosis), f"{name}.xlsx", on_click="ignore")
show.basis(diagnosis, record)
