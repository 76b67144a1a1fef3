"""Tell how well a gauge measures in the workshop's own hands, and take the result as an instrument."""

import streamlit as st

from atleak.report.charts import study_figures as figures
from atleak.report.tables.gauge_study import anova_table, component_table, result_sentence
from pages.shared import gauge_study_form, panel, reader, show

panel.shown()
say = reader.say()
st.title(say("gauge_study.title"))
st.write(say("gauge_study.what"))
gauge_study_form.draw_blank_form(say)
study = gauge_study_form.asked_study(say)
if study is None:
    st.stop()
sentence = show.plain(result_sentence(study, say))
{"accepted": st.success, "marginal": st.warning, "refused": st.error, None: st.info}[study.judged](sentence)
show.messages(study.messages, say("gauge_study.about"))
st.subheader(say("gauge_study.components"))
show.chart(figures.components(study, say), "gauge-study-components")
show.table(component_table(study, say))
st.caption(show.plain(say("gauge_study.whose")))
st.subheader(say("gauge_study.readings"))
show.chart(figures.by_part_and_operator(study, say), "gauge-study-readings")
st.caption(say("gauge_study.readings_help"))
with st.expander(say("gauge_study.anova")):
    show.table(anova_table(study, say))
st.subheader(say("gauge_study.take"))
gauge_study_form.draw_taking(study, say)
