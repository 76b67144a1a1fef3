"""Show the road-test log: what was understood of it, open questions, its curves, and the leakage over it."""

from functools import partial

import streamlit as st

from atleak.common.errors import AtleakError
from atleak.common.memory import kept_with
from atleak.measurements.events import events
from atleak.readers.logs import tidy_csv
from pages.shared import log_form, log_view, panel, reader, remembered_columns, show
from pages.shared import road as road_page

case, diagnosis = panel.shown()
say = reader.say()
st.title(say("road_test.title"))
log_form.keep_what_was_taken(case)
pending = log_form.pending(case)
if pending is None:
    st.info(say("road_test.no_log"))
    remembered_columns.draw()
    st.stop()
file, log = pending
test = log.road_test
st.markdown(f"**{show.plain(log.file)}**: {show.plain(log_form.facts(log, say))}")
if log.problem is not None:
    st.error(show.plain(log.problem))
log_form.form(file, log, case)
if test is None:
    remembered_columns.draw()
    st.stop()

st.subheader(say("road_test.understood"))
log_form.understood_table(log)
if log.unused:
    st.caption(say("road_test.not_used", columns=show.plain(", ".join(log.unused))))
show.messages(log.messages, say("road_test.about_log"), opened=log_form.refused(file))

own = diagnosis.log if file == case.road_test else None
if own is not None:
    test = own.road_test
    st.subheader(say("road_test.says"))
    road_page.findings(diagnosis)
happened = kept_with(test, "events", "", partial(events, test)) if own is None else own.events
st.subheader(say("road_test.happened"))
log_view.events_table(test, happened)

st.subheader(say("road_test.picture"))
ends = log_view.window(test, happened)
log_view.formulas_form(test)
part = log_view.part_of(test, ends, log_view.overlay())
log_view.picture(part, happened)

road = None
if own is not None and diagnosis.road is not None:
    try:
        road = log_view.leakage(diagnosis, part)
        st.subheader(say("road_test.leakage"))
        road_page.as_new(diagnosis)
        road_page.leakage_chart(road, diagnosis)
        road_page.extremes(road, diagnosis.uncertainty)
        show.messages(road.messages, say("road_test.about_leakage"))
    except AtleakError as error:
        st.warning(show.plain(error))
st.subheader(say("road_test.values"))
log_view.values_table(part, road)
log_view.operating_part(part, road)
shown = part.test
st.download_button(say("road_test.tidy"), lambda: tidy_csv(shown), f"{file.name}.tidy.csv", on_click="ignore")
remembered_columns.draw()
