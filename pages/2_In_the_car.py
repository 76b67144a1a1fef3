"""Guide from the complaint to what to open: what each step would add, its form, and what came of it."""

import streamlit as st

from pages.shared import (
    choices,
    conditions,
    guide,
    job_form,
    log_form,
    log_view,
    panel,
    pressure_form,
    reader,
    remembered_columns,
    road,
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
        job_form.draw_part(job_form.scan_and_fluid)

with guide.step("gauges") as opened:
    if opened:
        panel.drop("gauges", say("in_the_car.drop"))
        pressure_form.draw(case, diagnosis.controller)
        pressure_form.card(diagnosis)
if diagnosis.pressures is not None:
    pressure_form.result(diagnosis, diagnosis.pressures)

log_form.keep_what_was_taken(case)
pending = log_form.pending(case)
with guide.step("drive") as opened:
    if opened:
        panel.drop("drive", say("in_the_car.drop"))
        remembered_columns.draw()
if pending is not None:
    if diagnosis.log is not None and pending[0] == case.road_test:
        road.findings(diagnosis)
    log_form.draw(*pending, case)
    log_view.in_full(diagnosis, *pending)
