"""Say in one line what this is, and offer where to begin."""

import streamlit as st

from atleak.report.tables.first_sentence import shown_verdict
from pages.shared import panel, places, reader, show
from pages.shared.state import FILES, new_job, session, take_sample

_, diagnosis = panel.shown()
say = reader.say()
st.title("atleak")
st.markdown(show.plain(say("start.what")))
good = session().good
own = not good.sample and any(getattr(good, slot) for slot in FILES)
with st.container(horizontal=True):
    if own and st.button(
        show.plain(f"{say('pages.Diagnosis')}: {say.signed(shown_verdict(diagnosis))}"), type="primary"
    ):
        st.switch_page(places.page("Diagnosis"))
    if st.button(say("start.sample"), type="secondary" if own else "primary"):
        if not session().case.sample:
            take_sample()
        st.switch_page(places.page("Diagnosis"))
    if st.button(say("start.new")):
        new_job()
        st.switch_page(places.page("Job"))
    if st.button(say("pages.Jobs")):
        st.switch_page(places.page("Jobs"))
st.caption(show.plain(say("start.open")))
