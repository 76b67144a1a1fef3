"""Show how sure the numbers are: intervals, their sources, and what would make a verdict clear."""

import streamlit as st

from atleak.report.charts import land_figures as figures
from atleak.report.charts.drawing import spool_svg
from atleak.report.charts.land_figures import total_share
from atleak.report.tables.clearances import budget_rows
from atleak.report.tables.sentences import land_in_words
from atleak.report.tables.table import Column, Table
from pages.shared import pairs, panel, reader, show

case, diagnosis = panel.shown()
say = reader.say()
st.title(say("pages.Uncertainty"))
unit = diagnosis.uncertainty
if unit is None:
    st.info(say("uncertainty.nothing"))
    st.stop()
spool, sleeve = (f"**{show.plain(say.name(each.name))}**" for each in (unit.instruments.spool, unit.instruments.sleeve))
st.markdown(say("uncertainty.instruments", spool=spool, sleeve=sleeve, coverage=say.percent(unit.coverage, 0)))
show.messages(unit.messages, say("about.uncertainty"))

st.subheader(say("uncertainty.total"))
show.chart(total_share(diagnosis, say), "totals")

advised = pairs.advised(diagnosis, say)
show.open_verdicts(pairs.advice(diagnosis, advised, say))

st.subheader(say("uncertainty.clearances"))
of_land = {land.key: land for land in diagnosis.lands}
show.chart(figures.land_clearances(unit, say, advised=lambda key: advised(of_land[key])), "clearances")
st.subheader(say("uncertainty.leakages"))
show.chart(figures.leakages(unit, diagnosis.projection.condition, say), "leakages")

st.subheader(say("uncertainty.made_of"))
measured = [land.uncertainty for land in diagnosis.ranked if land.uncertainty is not None]
land = st.selectbox(say("columns.land"), measured, format_func=lambda each: land_in_words(diagnosis, each.key, say))
show.chart(figures.budget(land, say), "budget")
verdicts = {each.key: each.verdict for each in diagnosis.lands}
label = f"{say('columns.component')} {land.key[0]}"
show.svg(spool_svg(diagnosis.controller, land.key[0], verdicts, say), label, least_width=300)
with st.expander(say("uncertainty.in_numbers")):
    columns = (Column("uncertain_source"), Column("of_clearance", "percent"), Column("of_share", "percent"))
    show.table(Table("budget", columns, budget_rows(land, say), say))
with st.expander(say("uncertainty.assumed")):
    what = Column("what", of=lambda each: say.get("uncertainty_assumed", each[0]))
    value = Column("value", of=lambda each: say.plain_quantity(each[1].value, each[1].kind))
    show.table(Table("assumed", (what, value), [*unit.assumptions.quantities.items()], say))
