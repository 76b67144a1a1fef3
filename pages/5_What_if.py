"""Try the unit at another temperature, wear, fluid, speed, gear or position of its spools; the job stays as it is."""

import streamlit as st

from atleak.errors import AtleakError
from pages.shared import panel, reader, show, steps, what_if, what_if_form

case, diagnosis = panel.shown()
steps.draw(diagnosis)
say = reader.say()
st.title(say("what_if.title"))
st.caption(say("what_if.about"))
settings = what_if_form.draw(case, diagnosis)
try:
    what_if.beside(diagnosis, settings)
except AtleakError as error:
    st.error(show.plain(error))
try:
    what_if.maps(diagnosis, settings)
except AtleakError:
    st.stop()  # said above
what_if.study(case, diagnosis, settings)
