"""Show how sure the numbers are: intervals, their sources, and what would make a verdict clear."""

import streamlit as st

from atleak.figures import uncertainty_figures as figures
from atleak.figures.diagnosis_figures import total_share
from atleak.views.drawing import spool_svg
from atleak.views.uncertainty_rows import budget_rows
from pages.shared import panel, show, words

case, diagnosis = panel.shown()
st.title("Uncertainty")
unit = diagnosis.uncertainty
if unit is None:
    st.info("No measuring sheet in the job: nothing was measured, so nothing can be said of its uncertainty.")
    st.stop()
spool, sleeve = unit.instruments.spool, unit.instruments.sleeve
st.markdown(
    f"Spools measured with **{show.plain(spool.name)}**, sleeves with **{show.plain(sleeve.name)}**; bars are "
    f"{unit.coverage:.0%} intervals. Choose the instruments on the page Settings."
)
show.messages(unit.messages, "the instruments and what else is uncertain")

st.subheader("Total share")
show.chart(total_share(diagnosis), "totals")

show.open_verdicts(words.advice(diagnosis))

st.subheader("Clearances")
show.chart(figures.clearances(unit), "clearances")
st.subheader("Leakages")
show.chart(figures.leakages(unit), "leakages")

st.subheader("What one land's uncertainty is made of")
measured = [land.uncertainty for land in diagnosis.ranked if land.uncertainty is not None]
land = st.selectbox("Land", measured, format_func=lambda each: words.land_name(diagnosis, each.key))
show.chart(figures.budget(land), "budget")
verdicts = {each.key: each.verdict for each in diagnosis.lands}
show.svg(spool_svg(diagnosis.controller, land.key[0], verdicts), f"component {land.key[0]}", least_width=300)
with st.expander("In numbers"):
    show.table(budget_rows(land))
with st.expander("What is assumed of everything that was not measured"):
    show.table([{"what": name.replace("_", " "), "value": value} for name, value in unit.assumptions.settings.items()])
