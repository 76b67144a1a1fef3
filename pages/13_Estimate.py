"""Choose repairs, decide on them with the customer, and say what they cost."""

import streamlit as st

from atleak.report.estimate_words import EstimateWords
from atleak.report.pdf import write_pdf
from atleak.wording import languages, wording
from pages.shared import estimate_form, files, panel
from pages.shared.state import job

case, diagnosis = panel.shown()
st.title("Estimate")
if diagnosis.without_sheet:
    st.info("No measuring sheet in the job: without lands that were measured there is nothing to estimate.")
    st.stop()
st.write(
    "Every flagged land starts as proposed, with the repair that was chosen for it. What you change is your own and "
    "stays as it is, whatever is measured next. Further lines: among the repair decisions on the page Job."
)
made = estimate_form.draw(diagnosis)

st.subheader("Take it along")
named = {language: wording(language).texts["language"] for language in languages()}
language = st.selectbox("Language", list(named), list(named).index("en"), named.__getitem__, key="estimate-language")
record = job()
name = files.named("estimate", record.number)
with st.container(horizontal=True):
    st.download_button(
        "PDF",
        lambda: write_pdf(diagnosis, record, language=language, sections=("repair", "estimate", "signatures")),
        f"{name}.pdf",
        key="estimate-pdf",
        on_click="ignore",
        disabled=not record.estimated,
        help="With boxes to agree to each line. State a currency, a labour rate or a price first.",
    )
    st.download_button(
        "CSV", EstimateWords(made, wording(language)).csv, f"{name}.csv", key="estimate-csv", on_click="ignore"
    )
