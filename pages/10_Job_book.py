"""Look jobs up in the job book: open, archive, export, import, merge and erase them."""

import streamlit as st

from atleak.errors import BookError
from pages.shared import job_list, panel, show
from pages.shared.book import book
from pages.shared.state import new_job

panel.shown()
st.title("Job book")
try:
    jobs = book()
    job_list.fault()
    query = job_list.asked(jobs)
    picked = job_list.listed(jobs, query)
    goal = job_list.actions(jobs, picked)
    if goal is not None:
        page, parameters = goal
        st.switch_page(panel.PAGES / f"{page}.py", query_params=parameters)
    job_list.erasing(jobs)
    if st.button("New job", on_click=new_job, help="An empty job; this one stays in the book."):
        st.switch_page(panel.PAGES / "4_Diagnosis.py")
    job_list.taken_in(jobs)
    job_list.suggestions(jobs, picked)
except BookError as error:
    st.error(f"{show.plain(error)}\n\nEverything else works as ever; what you do now is kept in this tab alone.")
