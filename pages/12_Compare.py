"""Put two jobs of one unit side by side: before and after a repair, or two visits."""

import streamlit as st

from atleak.common.errors import AtleakError
from atleak.report.charts import comparison_figures as figures
from atleak.report.tables.comparison import land_table
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
both = found.comparison
show.banner(both.after, comparison.sentence(both))
show.messages(both.messages, say("about.comparison"))

st.subheader(say("compare.lands"))
lands = comparison.lands(both)
if lands:
    show.table(land_table(both, lands, say))
    st.caption(say("compare.lands_note"))
    show.chart(figures.compared_clearances(both, lands, say), "clearances")
    st.caption(say("compare.clearances_note"))
else:
    st.write(say("compare.no_land"))
with st.expander(say("compare.all_lands", count=len(both.lands))):
    show.table(land_table(both, both.lands, say))

st.subheader(say("compare.totals"))
comparison.totals(both)

st.subheader(say("compare.logs"))
comparison.logs(both)

st.subheader(say("take_along.title"))
comparison.downloads(found)
