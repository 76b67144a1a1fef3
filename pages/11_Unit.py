"""Show one unit over its visits: what was found and left undone, how it wears, and how it stands among its kind."""

import streamlit as st

from atleak.common.errors import BookError
from pages.shared import panel, reader, show, unit
from pages.shared.book import book

panel.shown()
say = reader.say()
st.title(say("unit.title"))
try:
    jobs = book()
    chosen = unit.choose(jobs)
    if chosen is None:
        st.stop()
    visited = unit.visits(jobs, chosen)
    st.subheader(say("unit.visits"))
    unit.draw_visits(visited)
    if (goal := unit.goal(visited)) is not None:
        page, parameters = goal
        st.switch_page(panel.PAGES / f"{page}.py", query_params=parameters)
    unit.draw_left_undone(visited)
    seen = unit.seen(visited)
    if seen is None:
        st.info(say("unit.no_sheet"))
        st.stop()
    st.subheader(say("unit.clearance"))
    unit.draw_clearance(seen)
    st.subheader(say("unit.wear"))
    unit.draw_wear(seen)
    st.subheader(say("unit.totals"))
    unit.draw_totals(seen)
    st.subheader(say("unit.kind"))
    unit.draw_kind(jobs, chosen, seen)
except BookError as error:
    st.error(show.plain(error))
