"""Plan the repair: switches with their prices, what they leave of the unit; and try the unit otherwise."""

from functools import partial

import streamlit as st

from atleak.analysis.record_doubts import record_doubts
from atleak.common.wording import wording
from atleak.report.pdf import write_pdf
from atleak.report.tables.estimate import EstimateWords
from pages.shared import conditions, fields, font_form, panel, plan, reader, show, what_if
from pages.shared.state import job

_SECTIONS = ("repair", "estimate", "signatures")

case, diagnosis = panel.shown()
say = reader.say()


def repairs() -> None:
    """Choose repairs, decide on them with the customer, and say what they cost."""
    if diagnosis.without_sheet or not (diagnosis.judged or plan.made(diagnosis).lines):
        st.info(say("estimate_page.no_sheet"))
        return
    made = plan.draw(diagnosis)
    conditions.undecided(diagnosis, closing=False)
    show.messages(record_doubts(job(), diagnosis), say("about.record"))
    conditions.order_of_repair(diagnosis)
    st.header(say("estimate_page.take_along"))
    (language, paper), record = reader.pick_print("estimate"), job()
    name = show.named("estimate", record.number)
    printed = partial(write_pdf, diagnosis, record, language=language, paper=paper, sections=_SECTIONS, units=say.units)
    pdf, csv = font_form.printing(printed) if record.estimated else None, EstimateWords(made, wording(language)).csv
    files = {"PDF": ("pdf", pdf), "CSV": ("csv", csv)}
    show.downloads(name, "estimate", files, {"PDF": say("estimate_page.pdf_help")})


def tried() -> None:
    """Try the unit at another temperature, wear, fluid, speed, gear or position of its spools; the job stays as is."""
    st.caption(say("what_if.about"))
    what_if.draw(case, diagnosis)


PARTS = {"repairs": repairs, "what_if": tried}
st.title(say("pages.Plan"))
PARTS[fields.part("plan", {name: say(f"parts.{name}") for name in PARTS})]()
