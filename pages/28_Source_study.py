"""Compare the source study's tables and figures with the engine, and show where the article contradicts itself."""

import pandas as pd
import streamlit as st

from atleak.errors import AtleakError
from atleak.figures.variant_figures import figure
from atleak.variants import charts, tables
from atleak.variants.article import compare_points
from atleak.views.diagnosis_record import to_json
from atleak.views.variant_rows import variants_record
from pages.shared import panel, show
from pages.shared.cases import result_key
from pages.shared.study import CITED, computed, table

STUDY, JOB = "the study's valve body and test", "this job's valve body and log"

case, diagnosis = panel.shown()
st.title("The source study, reproduced")
st.markdown(f"{CITED}. Its eight variants W1 to W8 run through the same engine as every job, in the `paper` profile.")
own = None if case.sample else diagnosis.road
what = st.radio("Run them on", [STUDY, JOB], horizontal=True) if own else STUDY
try:
    job = (result_key(case), diagnosis.controller, own.road_test) if own and what == JOB else ("study", None, None)
    controller, road_test, results, options, curves = computed(*job)
except AtleakError as error:
    st.error(show.error_line(error))
    st.stop()
if controller.representative:
    test = " The road test is representative too." if what == STUDY else ""
    st.caption(f"**Representative:** {show.plain(controller.representative)}{test}")

names = ["Tables 2 and 3", "Over time (Fig. 13)", "Over temperature (Fig. 14)", "Share", "Workshop or paper", "Errata"]
variants, over_time, over_temperature, share, physics, errata = st.tabs(names)
gear = road_test.values("gear")
with variants:
    st.markdown("**Table 2**: the variants; wear is on top of the valve body's mounting clearances")
    table(tables.table_2_rows(results))
    st.markdown("**Table 3**: most leakage q of the test and its share U of the pump flow then")
    table(tables.table_3_rows(results))
    st.caption(
        "✓ every printed digit, ≠ not. *q, ν printed*: with Table 2's viscosity. *U largest*: of the whole test."
    )
    st.markdown("\n".join(f"- **{name}** {show.plain(note)}" for name, note in tables.notes(results).items()))
    record = to_json(variants_record(results, controller, road_test))
    st.download_button("Download as JSON", record, "variants.json", "application/json", on_click="ignore")
    if what == STUDY:
        st.subheader("Points of the test that the article states")
        table(tables.point_rows(compare_points(results)), "{:.3f}")
with over_time:
    show.chart(figure(charts.leakage_chart(results, gear)), "time")
    st.caption("Triangles: least and most leakage of each variant. Click in the legend to hide a variant.")
with over_temperature:
    log_y = st.toggle("Logarithmic scale")
    chart = figure(charts.temperature_chart(curves, results, printed=what == STUDY, log_y=log_y))
    show.chart(chart, "temperature")
    st.caption("Curves: fresh oil. W4 lies above them: its printed result is that of the used oil.")
with share:
    if results[0].computed.share is None:
        st.info("The log has no engine speed, so there is no pump flow and no share.")
    else:
        show.chart(figure(charts.share_chart(results, gear)), "share")
        st.caption("Circles: largest share; in the study at idle, the pump at its slowest. Triangles: most leakage.")
with physics:
    st.markdown("What each option changes in the most leakage [%], one at a time and together; `–`: no data so cold.")
    table(tables.option_changes(options), "{:+.2f}")
    st.markdown("Leakage share at that instant [%]")
    table(tables.option_rows(options, "share_at_max_leakage"))
with errata:
    st.table(pd.DataFrame(tables.errata_rows()), hide_index=True)
