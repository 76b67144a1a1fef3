"""Guide from the complaint to what to open: what each step would add, its form, and what came of it."""

import streamlit as st

from pages.shared import (
    choices,
    conditions,
    guide,
    job_form,
    live_log,
    log_form,
    log_view,
    panel,
    places,
    reader,
    remembered_columns,
    road,
    typed_form,
)

case, diagnosis = panel.shown()
say = reader.say()
st.title(say("in_the_car.title"))
st.write(say("in_the_car.what"))
guide.begin()

with guide.step("complaint") as opened:
    if opened:
        choices.complaint("step")
        job_form.draw_part(job_form.complaint)
        conditions.complaint(diagnosis)

with guide.step("fluid") as opened:
    if opened:
        choices.catalogue_entry("fluid")
        choices.fluid_state()
        choices.own_fluid()
        job_form.draw_part(job_form.scan_and_fluid)

with guide.step("gauges") as opened:
    if opened:
        guide.card(diagnosis)
        st.caption(say("gauge_page.what"))
        typed_form.GaugeForm(diagnosis.controller).draw()
        panel.drop("gauges", say("in_the_car.drop"))
guide.gauges(diagnosis)

log_form.keep_what_was_taken(case)
pending = log_form.pending(case)
with guide.step("drive") as opened:
    if opened:
        panel.drop("drive", say("in_the_car.drop_log"))
        live_log.ask()
        remembered_columns.draw()
live_log.draw()
if pending is not None:
    if diagnosis.log is not None and pending[0] == case.road_test:
        road.findings(diagnosis)
    log_form.draw(*pending, case)
    log_view.in_full(diagnosis, *pending)

for name, form, slot in (("jug", typed_form.FlowForm, "flows"), ("vacuum", typed_form.VacuumForm, "vacuum")):
    with guide.step(name) as opened:
        if opened:
            st.caption(say(f"in_the_car.{name}_what"))
            form(diagnosis.controller).draw()
            panel.drop(name, say("in_the_car.drop"))
    guide.closed(diagnosis, slot)

with guide.step("open") as opened:
    if opened:
        guide.likely_worn(diagnosis)
        st.page_link(places.page("Measure"), label=say("in_the_car.measure"))
