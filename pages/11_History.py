"""Show one unit over its visits, and two jobs side by side: before and after a repair, or one visit and the next."""

import streamlit as st

from atleak.common.errors import AtleakError
from atleak.report.tables.comparison import comparison_sections
from pages.shared import comparison, fields, panel, places, reader, show, unit
from pages.shared.book import book

panel.shown()
say = reader.say()


def one_unit() -> None:
    """Show what was found and left undone of one unit, how it wears, and how it stands among its kind."""
    jobs = book()
    chosen = unit.choose(jobs)
    if chosen is None:
        return
    visited = unit.visits(jobs, chosen)
    st.header(say("unit.visits"))
    unit.draw_visits(visited)
    if (goal := unit.goal(visited)) is not None:
        page, parameters = goal
        st.switch_page(places.page(page), query_params=parameters)
    unit.draw_left_undone(visited)
    seen = unit.seen(visited)
    if seen is None:
        st.info(say("unit.no_sheet"))
        return
    st.header(say("unit.clearance"))
    unit.draw_clearance(seen)
    st.header(say("unit.wear"))
    unit.draw_wear(seen)
    st.header(say("unit.totals"))
    unit.draw_totals(seen)
    st.header(say("unit.kind"))
    unit.draw_kind(jobs, chosen, seen)


def compare() -> None:
    """Put two jobs of one unit side by side."""
    st.write(say("compare.what"))
    chosen = comparison.choose()
    found = None if chosen is None else comparison.compared(*chosen)
    if found is None:
        st.info(say("compare.choose"))
        return
    head, *sections = comparison_sections(found.comparison, say, drawn=comparison.DRAWN)
    show.section(head, "compare")
    show.messages(found.comparison.messages, say("about.comparison"))
    for section in sections:
        st.header(section.title)
        if section.name == "logs":
            comparison.draw_logs(found.comparison)
        show.section(section, "compare")
    st.header(say("take_along.title"))
    comparison.downloads(found)


PARTS = {"unit": one_unit, "compare": compare}
st.title(say("pages.History"))
try:
    PARTS[fields.part("history", {name: say(f"parts.{name}") for name in PARTS})]()
except AtleakError as error:
    st.error(show.plain(error))
