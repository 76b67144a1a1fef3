"""Ask whose job this is, and what was seen and decided: the job record as a form."""

import streamlit as st

from atleak.analysis.record_doubts import record_doubts
from pages.shared import job_form, panel, reader, show

case, diagnosis = panel.shown()
say = reader.say()
st.title(say("job.title"))
st.caption(say("job.optional"))
record = job_form.draw(diagnosis.controller)
with st.container():
    show.messages(record_doubts(record, diagnosis), say("about.record"))
