"""The form that says which sheet of a workbook to read, which of its rows, and in which unit its diameters stand."""

from __future__ import annotations

import streamlit as st

from atleak.intake.units import unit_names
from pages.shared.bench import Bench, File
from pages.shared.state import choose, put_file, session

AS_STATED = "as the sheet says"


def pending(bench: Bench) -> File | None:
    """The sheet to talk about: the one refused last, else the one on the bench."""
    refused = session().refused.get("sheet")
    return refused.file if refused is not None else bench.sheet


def form(file: File, bench: Bench) -> None:
    """Sheet, unit and rows: for a workbook with several sheets, a sheet without its unit, one of several states."""
    mine = file == bench.sheet
    with st.expander("Read it as", expanded=not mine), st.form("sheet", border=False):
        name = st.text_input("Sheet", bench.sheet_name if mine else "", placeholder="the one that holds readings")
        units = [AS_STATED, *unit_names("length")]
        now = units.index(bench.sheet_unit) if mine and bench.sheet_unit in units else 0
        unit = st.selectbox("Unit of the diameters", units, now)
        where = bench.sheet_where if mine else ()
        first, second = st.columns(2)
        told = where[0] if where else ("", "")
        heading = first.text_input("Only rows where column", told[0], placeholder="Inspection").strip()
        value = second.text_input("says", told[1], placeholder="May").strip()
        if st.form_submit_button(f"Read {file.name} again"):
            put_file("sheet", file)
            choose(
                sheet_name=name.strip(),
                sheet_unit="" if unit == AS_STATED else unit,
                sheet_where=((heading, value), *where[1:]) if heading else (),
            )
            st.rerun()
