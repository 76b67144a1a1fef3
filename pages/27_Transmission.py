"""Describe a valve body in tables: from a shipped one, an own one or from nothing, and save it as an own file."""

import streamlit as st

from pages.shared import panel, reader, transmission, transmission_picture, workshop_data
from pages.shared.editing import ask_step, checked_now, draw_faults

case, diagnosis = panel.shown()
say = reader.say()
st.title(say("pages.Transmission"))
st.write(say("transmission.about"))
editing = transmission.DESK.current()
workshop_data.draw_undo(transmission.DESK, say)
if editing is None:
    workshop_data.choose_start(transmission.DESK, say)
    st.stop()
checked = checked_now(editing)
transmission.draw_head(editing, checked)
step = ask_step(editing, list(transmission.STEPS), lambda name: say(f"transmission.step_{name}"), say)
draw_faults(editing, checked, say)
transmission_picture.draw_spools(step, checked)
transmission.draw_tables(editing, step, checked)
transmission.draw_learning(editing, step, checked)
transmission_picture.draw_flow(step, checked, diagnosis)
st.subheader(say("transmission.keep"))
transmission.draw_saving(editing, checked)
