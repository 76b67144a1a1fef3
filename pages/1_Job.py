"""Ask whose job this is, and what was seen and decided: the job record as a form."""

import streamlit as st

from pages.shared import job_form, panel, reader

case, diagnosis = panel.shown()
say = reader.say()
st.title(say("job.title"))
st.caption(say("job.optional"))
job_form.draw(diagnosis.controller)
