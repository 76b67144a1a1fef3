"""Describe a valve body in tables: from a shipped one, an own one or from nothing, and save it as an own file."""

import streamlit as st

from pages.shared import panel, reader, transmission, transmission_picture, transmission_tables
from pages.shared.editing import checked_now, draw_faults

case, diagnosis = panel.shown()
st.title("Transmission")
st.write(
    "Describe any valve body in tables and keep it in your own catalogue. Numbers may have a decimal comma or point; "
    "rows can be pasted from a spreadsheet. Shipped files stay as they are: a copy is edited."
)
editing = transmission.DESK.current()
if editing is None:
    transmission.choose_start()
    st.stop()
checked = checked_now(editing)
transmission.draw_head(editing, checked)
step = transmission_tables.choose_step(editing)
draw_faults(editing, checked, reader.say())
transmission_picture.draw_spools(step, checked)
transmission_tables.draw(editing, step, checked)
transmission.draw_learning(editing, step, checked)
transmission_picture.draw_flow(step, checked, diagnosis)
st.subheader("Keep it")
transmission.draw_saving(editing, checked)
