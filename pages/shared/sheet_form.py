"""Ask which sheet of a workbook to read, which of its rows, and in which unit its diameters stand."""

from __future__ import annotations

import streamlit as st

from atleak.intake.units import unit_names
from atleak.job.case import SourceFile
from atleak.measuring.typed_file import TYPED_FILE
from pages.shared.cases import PageCase
from pages.shared.state import choose, put_file, session

AS_STATED = "as the sheet says"


def pending(case: PageCase) -> SourceFile | None:
    """Return the sheet to ask about: the one refused last, else that of the job."""
    refused = session().refused.get("readings")
    return refused.file if refused is not None else case.readings


def draw(case: PageCase) -> None:
    """Draw the form where the job has a sheet, or one was refused, that was not typed in here."""
    file = pending(case)
    if file is not None and file.name != TYPED_FILE:
        _form(file, case)


def _form(file: SourceFile, case: PageCase) -> None:
    """Ask for sheet, unit and rows: of a workbook with several sheets, no unit, or several states of one unit."""
    mine = file == case.readings
    with st.expander("Read it as", expanded=not mine), st.form("sheet", border=False):
        name = st.text_input(
            "Sheet", (case.sheet_name or "") if mine else "", placeholder="the one that holds readings"
        )
        units = [AS_STATED, *unit_names("length")]
        now = units.index(case.sheet_unit) if mine and case.sheet_unit in units else 0
        unit = st.selectbox("Unit of the diameters", units, now)
        where = case.sheet_where if mine else ()
        first, second = st.columns(2)
        chosen = where[0] if where else ("", "")
        heading = first.text_input("Only rows where column", chosen[0], placeholder="Inspection").strip()
        value = second.text_input("says", chosen[1], placeholder="May").strip()
        if st.form_submit_button(f"Read {file.name} again"):
            put_file("readings", file)
            choose(
                sheet_name=name.strip() or None,
                sheet_unit=None if unit == AS_STATED else unit,
                sheet_where=((heading, value), *where[1:]) if heading else (),
            )
            st.rerun()
