"""Write the report: PDF, workbook, JSON and job file to download."""

from collections.abc import Callable
from functools import partial

import streamlit as st

from atleak.job.batch import attachments
from atleak.job.result import result_record
from atleak.job.zip_file import write_job_file
from atleak.report.json.diagnosis import to_json
from atleak.report.pdf import write_pdf
from atleak.report.pdf.body import DOCUMENTS
from atleak.report.printed_fonts import OwnFont
from atleak.report.xlsx import write_workbook
from pages.shared import comparison, conditions, customer, font_form, panel, reader, show
from pages.shared.cases import case_with_columns
from pages.shared.state import job

case, diagnosis = panel.shown()
say = reader.say()
st.title(say("pages.Report"))
record = job()
name = show.named("atleak", record.number)

conditions.undecided(diagnosis, closing=True)
st.header(say("take_along.title"))
language, paper = reader.pick_print("report")
document = st.radio(
    say("take_along.document"), list(DOCUMENTS), format_func=lambda each: say(f"documents.{each}"), horizontal=True,
    key="report-document",
)  # fmt: skip
of_document = DOCUMENTS[document]
with st.expander(say("take_along.sections")):
    picked = st.pills(
        say("take_along.sections"), of_document, selection_mode="multi", default=of_document,
        key=f"report-sections-{document}", format_func=lambda section: say(f"sections.{section}"),
        label_visibility="collapsed",
    )  # fmt: skip
sections = [name for name in of_document if name in picked]
font_form.draw_missing([record])
visits = None if document in ("workshop", "annex") else comparison.beside()
printed: dict[str, str] = {"language": language, "paper": paper, "units": say.units}


def of_pdf(font: OwnFont | None) -> bytes:
    """Write the document; a whole annex carries workbook, result and job file."""
    whole = document in ("annex", "all") and len(sections) == len(of_document)
    attached = attachments(diagnosis, record, case_with_columns(case), **printed) if whole else ()
    return write_pdf(
        diagnosis, record, **printed, document=document, sections=sections, font=font, visits=visits, attached=attached
    )


files: dict[str, tuple[str, Callable[[], str | bytes]]] = {
    "pdf": (f"{document}.pdf", font_form.printing(of_pdf)),
    "workbook": ("xlsx", partial(write_workbook, diagnosis, record, **printed)),
    "json": ("json", lambda: to_json(result_record(diagnosis, record))),
    "record": ("record.json", lambda: record.model_dump_json(indent=2, exclude_defaults=True)),
    "job_file": ("zip", lambda: write_job_file(diagnosis, record, case_with_columns(case))),
}
labels = {what: say(f"take_along.{what}") for what in files}
tips = {label: say(f"take_along.{what}_help") for what, label in labels.items()}
show.downloads(name, "report", {labels[what]: each for what, each in files.items()}, tips)
st.header(say("customer_link.title"))
customer.section(diagnosis, name, language)
