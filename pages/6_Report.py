"""Write the report: PDF, workbook, JSON and job file to download."""

from collections.abc import Callable
from functools import partial

import streamlit as st

from atleak.job.file import write_job_file
from atleak.paper import PAPERS
from atleak.report.pdf import write_pdf
from atleak.report.pdf.body import SECTIONS
from atleak.report.xlsx import write_workbook
from atleak.views.diagnosis_record import diagnosis_record, to_json
from atleak.wording import languages, wording
from pages.shared import conditions, files, panel
from pages.shared.cases import case_with_columns
from pages.shared.state import job

ALL = "Record, sheet, log, photos and catalogue files in one zip: another atleak comes to the same verdict."
RECORD = "What page Job holds, for the next time or for the command line."

case, diagnosis = panel.shown()
st.title("Report")
record = job()
name = files.named("atleak", record.number)

conditions.undecided(diagnosis, closing=True)
st.subheader("Take it along")
options = st.columns(2)
named = {language: wording(language).texts["language"] for language in languages()}
language = options[0].selectbox(
    "Language", list(named), list(named).index("en"), named.__getitem__, key="report-language"
)
paper = options[1].selectbox("Paper", list(PAPERS), format_func=lambda name: PAPERS[name].label, key="report-paper")
titles = wording("en").texts["sections"]
picked = st.pills(
    "Sections",
    SECTIONS,
    selection_mode="multi",
    default=SECTIONS,
    format_func=titles.__getitem__,
    key="report-sections",
)
sections = [name for name in SECTIONS if name in picked]
printed = partial(write_pdf, diagnosis, record, language=language, paper=paper, sections=sections)
downloads: dict[str, tuple[str, Callable[[], str | bytes], str]] = {
    "PDF": ("pdf", printed, "Ready to print, hand over and keep."),
    "Excel workbook": ("xlsx", lambda: write_workbook(diagnosis, record, paper=paper), "With live formulas."),
    "JSON": ("json", lambda: to_json(diagnosis_record(diagnosis)), "Every number, for other programs."),
    "Job record": ("record.json", lambda: record.model_dump_json(indent=2, exclude_defaults=True), RECORD),
    "Job file": ("zip", lambda: write_job_file(diagnosis, record, case_with_columns(case)), ALL),
}
with st.container(horizontal=True):
    for label, (suffix, content, tip) in downloads.items():
        st.download_button(label, content, f"{name}.{suffix}", key=f"report-{suffix}", on_click="ignore", help=tip)
