"""Show the clearances as measured: diameters, range, ovality, taper, spread, and what was not measured."""

import streamlit as st

from atleak.figures import diagnosis_figures as figures
from atleak.report.measuring_sheet import write_template
from atleak.views.clearances import clearance_rows
from atleak.views.sentences import measuring_temperature
from atleak.wording import wording
from pages.shared import panel, sheet_form, show, words

case, diagnosis = panel.shown()
controller, readings = diagnosis.controller, diagnosis.readings
st.title("Readings")
if readings is None:
    st.info("No measuring sheet in the job: every land is at its mounting clearance.")
else:
    where = f", sheet {readings.sheet}" if readings.sheet else ""
    unit = f"{readings.unit} (assumed from the nominal diameters)" if readings.unit_assumed else readings.unit
    said = f"{len(readings.readings)} readings in {unit}; {diagnosis.measured} of {len(diagnosis.lands)} lands measured"
    st.markdown(f"**{show.plain(readings.file)}**{show.plain(where)}: {show.plain(said)}.")
    at = measuring_temperature(diagnosis, wording("en"))
    st.caption(f"Temperature of measuring: {at}. It is stated in the job record, page Job, or in the sheet's head.")
st.download_button(
    "Measuring sheet to fill in",
    lambda: write_template(controller),
    f"measuring_sheet_{controller.id}.xlsx",
    on_click="ignore",
    help=f"An Excel workbook with every land of {controller.name}, and how to measure.",
)
file = sheet_form.pending(case)
if file is not None:
    sheet_form.form(file, case)
show.sheet_messages(diagnosis)

only = st.segmented_control("Lands", ["all", "flagged", "not fully measured"], default="all")
chosen = {
    "flagged": diagnosis.flagged,
    "not fully measured": [land for land in diagnosis.lands if land.state.status != "measured"],
}.get(only or "all", diagnosis.lands)
if chosen:
    show.verdict_table(words.clearance_table(controller, clearance_rows(chosen)), words.DIGITS)
    st.caption(
        "Clearances are radial. Ovality: largest difference between the directions of a plane; taper: between the "
        "planes; spread: between independent repeats. An empty cell: the readings cannot tell."
    )
    st.subheader("Wear against its limits")
    show.chart(figures.wear(diagnosis, chosen), "wear")
else:
    st.write("None.")
if controller.representative:
    st.info(f"**Representative:** {show.plain(controller.representative)}")
