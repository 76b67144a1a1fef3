"""Show which part it is: the answer, the valve body, the plan; pressures, lands, log and remarks when asked for."""

import streamlit as st

from atleak.report.charts.land_figures import total_share
from pages.shared import answer, conditions, fields, pairs, panel, plan, reader, road, show

case, diagnosis = panel.shown()
say = reader.say()
answer.draw_head(diagnosis)
if diagnosis.without_sheet:
    said = st.container()
else:
    with st.container(horizontal=True, gap="medium"):
        said, drawn = st.container(key="said"), st.container(key="drawn")
with said:
    answer.draw_verdict(diagnosis)
answer.draw_reason(diagnosis)  # seen before all that takes longer
with said:
    answer.draw(diagnosis)
if not diagnosis.without_sheet:
    with said:
        plan.draw_switches(diagnosis)
    with drawn:
        pairs.picture(diagnosis, say)
        pairs.opened_pair(diagnosis, say)
        show.chart(total_share(diagnosis, say, repaired=plan.ends(diagnosis)), "share")

parts = {
    "pressures": lambda: conditions.pressures(diagnosis, plan.ends(diagnosis)),
    "lands": lambda: pairs.lands(diagnosis),
    "log": lambda: road.section(diagnosis),
    "remarks": lambda: show.basis(diagnosis),
}
labels = {name: say(f"parts.{name}") for name in parts}
labels["remarks"] += f" ({sum(map(len, show.remarks(diagnosis).values()))})"
if diagnosis.without_sheet and diagnosis.pressures is None:
    labels = {name: labels[name] for name in ("log", "pressures", "lands", "remarks")}
if opened := fields.part("diagnosis", labels, closable=not diagnosis.without_sheet):
    parts[opened]()
