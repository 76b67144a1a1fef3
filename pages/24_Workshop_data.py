"""Edit limits, instruments and fluids in forms and tables, and save them as the user's own."""

import streamlit as st

from pages.shared import entry_tables, font_form, panel, reader, workshop_data
from pages.shared.editing import checked_now, draw_faults

panel.shown()
say = reader.say()
st.title(say("workshop_data.title"))
st.write(say("workshop_data.what"))
desk = workshop_data.choose_kind(say)
editing = desk.current()
workshop_data.draw_undo(desk, say)
if editing is None:
    workshop_data.choose_start(desk, say)
    font_form.draw(say)
    st.stop()
checked = checked_now(editing)
workshop_data.draw_head(desk, editing, checked, say)
step = workshop_data.choose_step(editing, checked, say)
draw_faults(editing, checked, say)
entry_tables.draw(editing, [step], checked)
workshop_data.draw_curve(checked, say)
st.subheader(say("workshop_data.keep"))
workshop_data.draw_saving(desk, editing, checked, say)
