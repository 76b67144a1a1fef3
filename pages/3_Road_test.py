"""The road-test log: what was understood of it, what is asked, its picture, and the leakage over it."""

import streamlit as st

from atleak import figures
from atleak.intake.road_test import tidy_csv
from pages.shared import log_form, panel, show

bench, diagnosis = panel.shown()
st.title("Road test")
file, found = log_form.pending(bench)
if found is None:
    st.info("No road-test log on the bench. Upload one in the panel at the side.")
    st.stop()
test = found.road_test
facts = [found.format, found.encoding, f"decimal sign {found.decimal}" if found.decimal else None]
if test is not None:
    breaks = len(test.segments) - 1
    facts += [f"{test.rows} rows over {test.duration:.1f} s", f"{breaks} breaks" if breaks > 0 else "no break"]
st.markdown(f"**{show.plain(found.file)}**: {show.plain(', '.join(fact for fact in facts if fact))}")
if found.problem is not None:
    st.error(show.plain(found.problem))
log_form.form(file, found, bench)
if test is None:
    st.stop()

st.subheader("As understood")
show.table(log_form.column_rows(found))
if found.unused:
    st.caption(f"Not used: {show.plain(', '.join(found.unused))}")
show.messages(found.messages, "the road-test log")

st.subheader("Channels")
st.plotly_chart(figures.road_channels(test, log_form.scales(test)), key="channels")
st.caption("× suspect samples, left out of every result; dotted: breaks in the log. Drag to zoom.")
st.download_button("Tidy table (CSV)", lambda: tidy_csv(test), f"{file.name}.tidy.csv", on_click="ignore")

if diagnosis.road is not None and diagnosis.road.road_test is test:
    st.subheader("Leakage")
    st.plotly_chart(figures.road_leakage(diagnosis.road, diagnosis.limits), key="road")
    show.messages(diagnosis.road.messages, "leakage over this log")
