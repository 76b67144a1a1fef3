"""Say in one line what this is, and offer where to begin."""

import streamlit as st

from pages.shared import panel, places, reader, show
from pages.shared.state import new_job, session, take_sample

panel.shown()
say = reader.say()
st.title("atleak")
st.markdown(show.plain(say("start.what")))
with st.container(horizontal=True):
    if st.button(say("start.sample"), type="primary"):
        if not session().case.sample:
            take_sample()
        st.switch_page(places.page("Diagnosis"))
    if st.button(say("start.new")):
        new_job()
        st.switch_page(places.page("Job"))
    if st.button(say("pages.Jobs")):
        st.switch_page(places.page("Jobs"))
st.caption(show.plain(say("start.open")))
