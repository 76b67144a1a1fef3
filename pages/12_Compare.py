"""Put two jobs of one unit side by side: before and after a repair, or two visits."""

import streamlit as st

from atleak.errors import AtleakError
from atleak.figures import comparison_figures as figures
from pages.shared import comparison, panel, show

panel.shown()
st.title("Compare")
st.write("Two jobs of one unit side by side: before and after a repair, or one visit and the next.")
try:
    chosen = comparison.choose()
    found = None if chosen is None else comparison.compared(*chosen)
except AtleakError as error:
    st.error(show.plain(error))
    st.stop()
if found is None:
    st.info("Choose a job for either side, from the job book or as a job file.")
    st.stop()
both = found.comparison
show.banner(both.after, comparison.sentence(both))
show.messages(both.messages, "this comparison")

st.subheader("Lands")
lands = comparison.lands(both)
if lands:
    comparison.land_table(both, lands)
    st.caption(
        "Lands that are or were flagged, or changed. ±: 95 % interval of the change, by the uncertainty of both "
        "measurements; of lands that stayed as they were one in twenty is called changed by chance."
    )
    show.chart(figures.clearances(both, lands), "clearances")
    st.caption("Open: before; filled: after, each with the sign of its verdict.")
else:
    st.write("No land is flagged at either visit, and none changed.")
with st.expander(f"All {len(both.lands)} lands"):
    comparison.land_table(both, both.lands)

st.subheader("Totals and pressures")
comparison.totals(both)

st.subheader("Road tests")
comparison.logs(both)

st.subheader("Take it along")
comparison.downloads(found)
