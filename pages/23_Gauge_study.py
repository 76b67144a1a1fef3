"""Tell how well a gauge measures in the workshop's own hands, and take the result as an instrument."""

import streamlit as st

from atleak.report.charts.study_figures import by_part_and_operator
from atleak.report.tables.gauge_study import study_sections
from pages.shared import gauge_study_form, panel, reader, show

panel.shown()
say = reader.say()
st.title(say("gauge_study.title"))
st.write(say("gauge_study.what"))
gauge_study_form.draw_blank_form(say)
study = gauge_study_form.asked_study(say)
if study is None:
    st.stop()
sections = study_sections(study, say)
show.section(sections["title"], "gauge-study")
show.messages(study.messages, say("gauge_study.about"))
st.subheader(sections["components"].title)
show.section(sections["components"], "gauge-study")
st.subheader(say("gauge_study.readings"))
show.chart(by_part_and_operator(study, say), "gauge-study-readings")
st.caption(say("gauge_study.readings_help"))
with st.expander(sections["anova"].title):
    show.section(sections["anova"], "gauge-study")
st.subheader(say("gauge_study.take"))
gauge_study_form.draw_taking(study, say)
