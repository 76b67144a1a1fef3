"""Show the results of a fleet: verdicts, pairs, wear, temperatures, groups, and every unit down to its own job."""

import streamlit as st

from atleak.common.errors import AtleakError
from pages.shared import fleet, fleet_units, panel, places, reader, show

panel.shown()
if fleet_units.opened():
    st.switch_page(places.page("Diagnosis"))
say = reader.say()
st.title(say("pages.Fleet"))
try:
    folder = fleet.choose()
    if folder is None:
        st.stop()
    words = fleet.summed(folder)
    fleet.draw_whole(words)
    if words.summary.bodies:
        st.markdown(" · ".join(f"[{say(key)}](#{anchor})" for anchor, key in fleet.SECTIONS.items()))
        st.header(say("fleet.units_of_all"), anchor="fleet-units")
        unit = fleet_units.choose(words)
        if unit is not None:
            fleet_units.draw(folder, unit, words)
        st.header(say("fleet.one_body"), anchor="fleet-body")
        fleet.draw_body(words, fleet.choose_body(words))
    st.header(say("fleet_summary.section_errors"), anchor="fleet-errors")
    show.section(fleet.sections(words).section("errors"), "fleet")
    st.header(say("take_along.title"), anchor="fleet-files")
    fleet.draw_files(words)
except AtleakError as error:
    st.error(show.plain(error))
