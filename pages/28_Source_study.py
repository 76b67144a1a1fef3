"""Compare the source study's tables and figures with the engine, and show where the article contradicts itself."""

import streamlit as st

from atleak.analysis.source_study import compare_points
from atleak.common.errors import AtleakError
from atleak.report.charts import study_figures as figures
from atleak.report.json.diagnosis import to_json
from atleak.report.tables.source_study import (
    errata_table,
    option_share_table,
    option_table,
    point_table,
    table_2,
    table_3,
    variants_record,
)
from pages.shared import panel, reader, show
from pages.shared.cases import result_key, study_of

CITED = "Dziubak & Szczepaniak, *Energies* 2023, 16, 7667, [doi 10.3390/en16227667](https://doi.org/10.3390/en16227667)"
STUDY, JOB = "of_study", "of_job"
case, diagnosis = panel.shown()
say = reader.say()
st.title(say("study.title"))
st.markdown(say("study.about", cited=CITED))
own, said_of = None if case.sample else diagnosis.road, {of: say(f"study.{of}") for of in (STUDY, JOB)}
what = st.radio(say("study.run_on"), list(said_of), 0, said_of.get, horizontal=True) if own else STUDY
try:
    job = (result_key(case), diagnosis.controller, own.road_test) if own and what == JOB else ("study", None, None)
    controller, road_test, results, options, curves = study_of(*job)
except AtleakError as error:
    st.error(show.error_line(error))
    st.stop()
if controller.representative:
    test = f" {say('study.test_too')}" if what == STUDY else ""
    st.caption(f"**{say('catalogue.representative')}** {show.plain(say.name(controller.representative))}{test}")

names = [say(f"study.tab_{name}") for name in ("tables", "time", "temperature", "share", "physics", "errata")]
variants, over_time, over_temperature, share, physics, errata = st.tabs(names)
gear = road_test.values("gear")
with variants:
    st.markdown(say("study.table_2_is"))
    show.table(table_2(results, say), height="content")
    st.markdown(say("study.table_3_is"))
    show.table(table_3(results, say), height="content")
    st.caption(say("study.table_3_help"))
    notes = {each.variant.name: say.get("study_words", each.variant.note) for each in results if each.variant.note}
    st.markdown("\n".join(f"- **{name}** {show.plain(note)}" for name, note in notes.items()))
    record = to_json(variants_record(results, controller, road_test))
    st.download_button(say("study.download"), record, "variants.json", "application/json", on_click="ignore")
    if what == STUDY:
        st.subheader(say("study.points"))
        show.table(point_table(compare_points(results), say), height="content")
with over_time:
    show.chart(figures.leakage_over_time(results, say, gear), "time")
    st.caption(say("study.time_help"))
with over_temperature:
    log_y = st.toggle(say("study.log_scale"))
    chart = figures.leakage_over_temperature(curves, say, results, printed=what == STUDY, log_y=log_y)
    show.chart(chart, "temperature")
    st.caption(say("study.temperature_help"))
with share:
    if results[0].computed.share is None:
        st.info(say("study.no_share"))
    else:
        show.chart(figures.share_over_time(results, say, gear), "share")
        st.caption(say("study.share_help"))
with physics:
    st.markdown(say("study.physics_is"))
    show.table(option_table(options, say), height="content")
    st.markdown(say("study.physics_share"))
    show.table(option_share_table(options, say), height="content")
with errata:
    st.table(errata_table(say).frame(), hide_index=True)
