"""Choose repairs, decide on them with the customer, and say what they cost."""

from functools import partial

import streamlit as st

from atleak.analysis.record_doubts import record_doubts
from atleak.common.wording import wording
from atleak.report.pdf import write_pdf
from atleak.report.tables.estimate import EstimateWords
from pages.shared import estimate_form, files, font_form, panel, reader, show
from pages.shared.state import job

_SECTIONS = ("repair", "estimate", "signatures")

case, diagnosis = panel.shown()
say = reader.say()
st.title(say("estimate_page.title"))
if diagnosis.without_sheet:
    st.info(say("estimate_page.no_sheet"))
    st.stop()
st.write(say("estimate_page.intro"))
made = estimate_form.draw(diagnosis)
show.messages(record_doubts(job(), diagnosis), say("about.record"))

st.subheader(say("estimate_page.take_along"))
options = st.columns(2)
language = reader.pick_language(options[0], "estimate-language")
paper = reader.pick_paper(options[1], "estimate-paper")
record = job()
name = files.named("estimate", record.number)
with st.container(horizontal=True):
    st.download_button(
        "PDF",
        font_form.printing(
            partial(write_pdf, diagnosis, record, language=language, paper=paper, sections=_SECTIONS, units=say.units)
        ),
        f"{name}.pdf",
        key="estimate-pdf",
        on_click="ignore",
        disabled=not record.estimated,
        help=say("estimate_page.pdf_help"),
    )
    st.download_button(
        "CSV", EstimateWords(made, wording(language)).csv, f"{name}.csv", key="estimate-csv", on_click="ignore"
    )
