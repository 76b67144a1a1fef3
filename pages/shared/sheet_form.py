"""Ask which sheet of a workbook to read, which of its rows, and in which unit its diameters stand."""

from __future__ import annotations

import streamlit as st

from atleak.common.units import unit_names
from atleak.job.case import SourceFile
from atleak.readers.typed_sheet import TYPED_FILE
from pages.shared import reader, show
from pages.shared.cases import PageCase
from pages.shared.state import choose, put_file, session

AS_STATED = ""  # the unit that the sheet says


def pending(case: PageCase) -> SourceFile | None:
    """Return the sheet to ask about: the one refused last, else that of the job."""
    refused = session().refused.get("readings")
    return refused.file if refused is not None else case.readings


def unit_said(unit: str) -> str:
    """Return the name of a unit to choose, or that the sheet's own is taken."""
    return unit or reader.say()("sheet_form.as_stated")


def draw(case: PageCase) -> None:
    """Draw the form where the job has a sheet, or one was refused, that was not typed in here."""
    file = pending(case)
    if file is not None and file.name != TYPED_FILE:
        _form(file, case)


def _form(file: SourceFile, case: PageCase) -> None:
    """Ask for sheet, unit and rows: of a workbook with several sheets, no unit, or several states of one unit."""
    mine = file == case.readings
    say = reader.say()
    with st.expander(say("sheet_form.title"), expanded=not mine), st.form("sheet", border=False):
        name = st.text_input(
            say("sheet_form.sheet"), (case.sheet_name or "") if mine else "", placeholder=say("sheet_form.any_sheet")
        )
        units = [AS_STATED, *unit_names("length")]
        now = units.index(case.sheet_unit) if mine and case.sheet_unit in units else 0
        unit = st.selectbox(say("sheet_form.unit"), units, now, format_func=unit_said)
        where = case.sheet_where if mine else ()
        first, second = st.columns(2)
        chosen = where[0] if where else ("", "")
        heading = first.text_input(
            say("sheet_form.column"), chosen[0], placeholder=say("sheet_form.such_column")
        ).strip()
        value = second.text_input(say("sheet_form.says"), chosen[1], placeholder=say("sheet_form.such_value")).strip()
        fill_down = st.checkbox(say("sheet_form.fill_down"), mine and case.sheet_fill_down)
        if st.form_submit_button(show.plain(say("sheet_form.again", file=file.name))):
            put_file("readings", file)
            choose(
                sheet_name=name.strip() or None,
                sheet_unit=unit or None,
                sheet_where=((heading, value), *where[1:]) if heading else (),
                sheet_fill_down=fill_down,
            )
            st.rerun()
