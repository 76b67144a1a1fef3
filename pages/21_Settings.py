"""Choose what a job takes from the catalogue, its instruments and how the engine computes."""

import streamlit as st

from atleak.job.case import SLOTS
from pages.shared import choices, panel, reader

panel.shown()
say = reader.say()
st.title(say("settings.title"))
st.header(say("reader.title"))
reader.draw_choices()
st.header(say("settings.fluid"))
choices.catalogue_entry("fluid")
choices.fluid_state()
choices.own_fluid()
st.header(say("settings.limits"))
choices.catalogue_entry("limits")
st.caption(say("settings.own"))
st.header(say("settings.instruments"))
for slot in SLOTS.values():
    if slot.part is not None:
        choices.catalogue_entry(slot.name)
with st.expander(say("settings.engine")):
    choices.engine()
