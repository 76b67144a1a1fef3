"""Put two jobs of one unit side by side: before and after a repair, or two visits."""

import streamlit as st

from atleak.common.errors import AtleakError
from atleak.report.tables.comparison import comparison_sections
from pages.shared import comparison, panel, reader, show

panel.shown()
say = reader.say()
st.title(say("pages.Compare"))
st.write(say("compare.what"))
try:
    chosen = comparison.choose()
    found = None if chosen is None else comparison.compared(*chosen)
except AtleakError as error:
    st.error(show.plain(error))
    st.stop()
if found is None:
    st.info(say("compare.choose"))
    st.stop()
head, *sections = comparison_sections(found.comparison, say, drawn=comparison.DRAWN)
show.section(head, "compare")
show.messages(found.comparison.messages, say("about.comparison"))
for section in sections:
    st.subheader(section.title)
    if section.name == "logs":
        comparison.draw_logs(found.comparison)
    show.section(section, "compare")

st.subheader(say("take_along.title"))
comparison.downloads(found)
