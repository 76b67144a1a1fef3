"""Type readings in at the bench, and show the clearances that they give: range, ovality, taper, what is missing."""

import streamlit as st

from atleak.report.charts import land_figures as figures
from atleak.report.sheets.measuring_head import fields_of
from atleak.report.sheets.measuring_sheet import write_template
from atleak.report.tables.clearances import clearance_table
from atleak.report.tables.sentences import measuring_temperature
from pages.shared import measuring_form, panel, reader, sheet_form, show, state

case, diagnosis = panel.shown()
say, controller, readings = reader.say(), diagnosis.controller, diagnosis.readings
st.title(say("pages.Measure"))
with st.container():  # one element whatever is said: the grid below keeps its place
    if readings is None:
        st.markdown(say("readings.none"))
    elif not readings.readings:
        st.markdown(say("readings.none_counts"))
    else:
        unit = f"{readings.unit} ({say('readings.unit_assumed')})" if readings.unit_assumed else readings.unit
        counts = {"count": len(readings.readings), "measured": diagnosis.measured, "lands": len(diagnosis.lands)}
        said = say("readings.holds", unit=unit, **counts)
        where = f", {say('readings.sheet', sheet=readings.sheet)}" if readings.sheet else ""
        st.markdown(f"**{show.plain(readings.file)}**{show.plain(where)}: {show.plain(said)}")
        for note in (message for message in readings.messages if message.code == "remembered"):
            st.caption(show.plain(note.text))
        st.caption(show.plain(say("readings.measured_at", temperature=measuring_temperature(diagnosis, say))))

sheet_form.draw(case)
typing, clearances = st.tabs(
    [say("readings.typing"), say("readings.clearances")], key=f"readings-{say.language}", on_change="rerun"
)
if typing.open:
    with typing:
        plan = measuring_form.draw(case, diagnosis)
        fields = {} if case.sample else fields_of(state.job(), say.units)
        language = reader.pick_language("template")
        st.download_button(
            say("readings.template"),
            lambda: write_template(controller, plan=plan, fields=fields, language=language, units=say.units),
            f"measuring_sheet_{controller.id}.xlsx",
            on_click="ignore",
            help=say("readings.template_help"),
        )
if clearances.open:
    with clearances:
        show.messages(show.remarks(diagnosis)["sheet"], say("about.sheet"))
        kinds = ["all", "flagged", "not_fully_measured"]
        kind = st.segmented_control(
            say("readings.lands"), kinds, format_func=lambda name: say(f"readings.{name}"), default="all"
        )
        chosen = {
            "flagged": diagnosis.flagged,
            "not_fully_measured": [land for land in diagnosis.lands if not land.state.whole],
        }.get(kind or "all", diagnosis.lands)
        if chosen:
            show.table(clearance_table(chosen, controller, say))
            st.caption(say("readings.columns"))
            st.header(say("readings.wear"))
            show.chart(figures.land_wear(diagnosis, chosen, say), "wear")
        else:
            st.write(say("readings.no_lands"))
