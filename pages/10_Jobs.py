"""Look jobs up in the job book: open, archive, export, import, merge and erase them."""

import streamlit as st

from atleak.common.errors import BookError
from pages.shared import job_list, panel, places, reader, show
from pages.shared.book import book
from pages.shared.state import new_job

panel.shown()
say = reader.say()
st.title(say("pages.Jobs"))
try:
    jobs = book()
    query = job_list.asked(jobs)
    picked = job_list.listed(jobs, query)
    goal = job_list.actions(jobs, picked)
    if goal is not None:
        page, parameters = goal
        st.switch_page(places.page(page), query_params=parameters)
    job_list.erasing(jobs)
    if st.button(say("job_book.new_job"), on_click=new_job, help=say("job_book.new_job_help")):
        st.switch_page(places.page("Diagnosis"))
    job_list.taken_in(jobs)
    job_list.suggestions(jobs, picked)
except BookError as error:
    st.error(f"{show.plain(error)}\n\n{say('job_book.unreadable')}")
