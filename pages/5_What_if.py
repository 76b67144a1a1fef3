"""Try the unit at another temperature, wear, fluid, speed, gear or position of its spools; the job stays as it is."""

import streamlit as st

from pages.shared import panel, reader, what_if

case, diagnosis = panel.shown()
say = reader.say()
st.title(say("what_if.title"))
st.caption(say("what_if.about"))
what_if.draw(case, diagnosis)
