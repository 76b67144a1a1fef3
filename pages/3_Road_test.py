"""Show the road-test log: what was understood of it, open questions, its curves, and the leakage over it."""

from functools import partial

import streamlit as st

from atleak.errors import AtleakError
from atleak.events import events
from atleak.figures import diagnosis_figures as figures
from atleak.intake.road_test import tidy_csv
from atleak.views.window import event_rows, window_rows
from pages.shared import log_form, panel, show
from pages.shared import road as road_page

case, diagnosis = panel.shown()
st.title("Road test")
pending = log_form.pending(case)
if pending is None:
    st.info("No road-test log in the job. Upload one in the sidebar.")
    st.stop()
file, log = pending
test = log.road_test
facts = [log.format, log.encoding, f"decimal sign {log.decimal}" if log.decimal else None]
if test is not None:
    breaks = len(test.segments) - 1
    facts += [f"{test.rows} rows over {test.duration:.1f} s", f"{breaks} breaks" if breaks > 0 else "no break"]
st.markdown(f"**{show.plain(log.file)}**: {show.plain(', '.join(fact for fact in facts if fact))}")
if log.problem is not None:
    st.error(show.plain(log.problem))
log_form.form(file, log, case)
if test is None:
    st.stop()

st.subheader("As understood")
show.table(log_form.column_rows(log))
if log.unused:
    st.caption(f"Not used: {show.plain(', '.join(log.unused))}")
show.messages(log.messages, "the road-test log")

own = diagnosis.log if file == case.road_test else None
if own is not None:
    st.subheader("What the log says")
    road_page.findings(diagnosis)
happened = events(test) if own is None else own.events
st.subheader("What happened")
if happened:
    show.table(event_rows(happened))
else:
    st.write("No event was recognised with the channels there are.")

st.subheader("The log's picture")
ends = log_form.window(test, happened)
over = log_form.overlay()
part = test if ends is None else test.window(*ends)
scales = log_form.scales(test)
look = partial(log_form.look_between, test)
show.chart(figures.road_channels(part, scales, happened, over), f"channels-{ends}", on_span=look)
st.caption(
    "× suspect samples, left out of every result; dotted: breaks in the log; dashed: events. Drag across the chart to "
    "look closer: the stretch is drawn anew from the full log."
)

road = None
if file == case.road_test and diagnosis.road is not None:
    try:
        road = diagnosis.road if ends is None else diagnosis.over(part)
        st.subheader("Leakage over it")
        road_page.as_new(diagnosis)
        show.chart(figures.road_leakage(road, diagnosis.limits), "road")
        show.extremes(road, diagnosis.uncertainty)
        show.messages(road.messages, "leakage over this log")
    except AtleakError as error:
        st.warning(show.plain(error))
st.subheader("Least, mean and largest")
show.table(window_rows(part, road, scales), number=show.rounded)
st.download_button("Tidy table (CSV)", lambda: tidy_csv(part), f"{file.name}.tidy.csv", on_click="ignore")
