"""Type gauge readings of the standing vehicle, and show them beside what is permitted and expected."""

import streamlit as st

from atleak.views.gauge_rows import pattern_text
from atleak.wording import wording
from pages.shared import panel, pressure_form, show

case, diagnosis = panel.shown()
controller, check, say = diagnosis.controller, diagnosis.pressures, wording("en")
st.title("Pressures")
st.write(
    "What gauges show while the vehicle stands, range by range, the fluid warm: a job of its own, or beside the "
    "measuring sheet. Leave empty what was not measured. Stall for five seconds at most."
)
pressure_form.draw(case, controller)
if check is None:
    st.info("No gauge readings in the job: type some, or give a file in the sidebar.")
    st.stop()

st.subheader("Beside what is permitted")
show.gauge_banner(check)
show.gauges(check)
st.caption(
    "Permitted: by the valve body's file, for the range or its gear. Expected: what pump and circuits hold by the "
    "clearances as measured, or when new. Below line: a circuit against what the line's gauge beside it should give. "
    "A dash in place of a verdict: the file says nothing that the reading must reach."
)
if check.patterns:
    st.subheader("What the table hints at")
    hints = [(pattern_text(each, controller, say), say.get("pattern_sources", each.source)) for each in check.patterns]
    st.markdown("\n".join(f"- {show.plain(hint)} *({show.plain(source)})*" for hint, source in hints))
    st.caption("Hints where to look first, no verdict.")
show.messages(check.messages, "the gauge readings")
