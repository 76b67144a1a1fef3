"""Run the dashboard: ``atleak app`` starts it."""

import streamlit as st

from atleak.common.memory import collect_soon, imports
from pages.shared import entrance, places, reader

st.set_page_config("atleak", page_icon=places.PAGES / "shared" / "icon.svg", layout="wide")
say = reader.say()
pages = [st.Page(path, title=say.get("pages", places.name_of(path))) for path in (places.START, *places.EVERY)]
page = st.navigation(pages, position="hidden")
reader.mark_page()
if not entrance.is_open():
    entrance.draw()
    st.stop()
heading = st.empty()
if "framed" not in st.session_state:  # seen while all else is imported, read and computed
    heading.title(page.title)

with imports():
    from pages.shared import book, customer, panel, show

diagnosis = panel.draw()
entrance.draw_sign_out()
heading.empty()
try:
    with show.faults():
        page.run()
finally:  # also where the page ends early
    answered = customer.take_answers(diagnosis)
    news = book.keep(page.url_path)
    collect_soon()
if news or answered:
    st.rerun()
