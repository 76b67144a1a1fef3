"""Ask how a measuring sheet is to be read: which sheet, rows and unit, and which column is what."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import pandas as pd
import streamlit as st

from atleak.catalogue.words import PART_WORDS
from atleak.common.errors import AtleakError, OutputError
from atleak.common.units import MM, unit_names
from atleak.common.wording import Wording
from atleak.job.case import SourceFile
from atleak.measurements.readings import Readings
from atleak.readers.cells.sheet import column_letter
from atleak.readers.logs import NOT_LOGGED, default_path
from atleak.readers.remembered_columns import CONSTANT
from atleak.readers.sheets.mapping import remember_sheet
from atleak.readers.sheets.measuring_sheet import SheetLook
from atleak.readers.typed_sheet import TYPED_FILE
from pages.shared import fields, reader, show
from pages.shared.cases import PageCase, controller_of, readings_of, sheet_look
from pages.shared.state import choose, put_file, session

AS_STATED = ""  # the unit that the sheet says
AS_HEADED = "\x00headed"  # no column has such a name
_ROLES = ("component", "plane", "part", "direction", "repeat", "new")
_TEXTS = ("rows", "missing", "spool", "sleeve")
_VALUES = 4  # columns of diameters that can be named
_SHOWN = 200  # readings of a preview


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
        _columns(file, case)


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


# --- which column is what


@dataclass(frozen=True)
class _Asked:
    """What is asked of one sheet: how it looks, and what was chosen so far."""

    file: SourceFile
    case: PageCase
    look: SheetLook
    chosen: Mapping[str, str]
    key: str

    def option(self, option: str) -> str:
        """Return how a column is offered: by letter and heading, with a cell of the last row that is shown."""
        say = reader.say()
        if option == AS_HEADED:
            return say("sheet_columns.as_headed")
        if option == NOT_LOGGED:
            return say("sheet_columns.no_column")
        if option.startswith(CONSTANT):
            return say("sheet_columns.in_all_rows", what=_part_said(option[1:], say))
        if option not in self.look.columns:
            return option
        index, rows = self.look.columns.index(option), self.look.rows
        cell = rows[-1][index] if rows and index < len(rows[-1]) else ""
        return f"{column_letter(index)} · {option}" + (f": {cell}" if cell else "")

    def pick(self, place: Any, name: str, label: str, start: str | None) -> str:
        """Ask for one column."""
        parts = [f"{CONSTANT}{part}" for part in PART_WORDS] if name == "part" else []
        options = list(dict.fromkeys([AS_HEADED, NOT_LOGGED, *parts, *self.look.columns, *filter(None, [start])]))
        index = options.index(AS_HEADED if start is None else start)
        picked: str = place.selectbox(label, options, index, key=f"{self.key}-{name}", format_func=self.option)
        return picked


def _columns(file: SourceFile, case: PageCase) -> None:
    """Show the file's own table and ask which column is what; opened by itself where the headings do not tell."""
    say, stored = reader.say(), f"sheet-look-{file.sha256}"
    mine, controller = file == case.readings, controller_of(case)
    sheet, header = st.session_state.get(stored, (case.sheet_name if mine else None, ""))
    settled: dict[str, str] = {}
    try:
        look = sheet_look(file, controller, sheet, "")
        if mine:
            settled = dict(readings_of(case, file).columns)
            header = header or settled.get("header", "")
    except AtleakError:
        return  # the file is no table at all, and was refused
    wanting = not mine and not look.understood
    with fields.fold(say("sheet_columns.title"), key=f"sheet-columns-{file.sha256}-{wanting}", opened=wanting) as place:
        if not place.open:
            return
        if session().unkept[0] == file.sha256:
            st.warning(say("mapping.not_kept", why=show.plain(session().unkept[1])))
        if header:
            try:
                look = sheet_look(file, controller, sheet, header)
            except AtleakError as error:
                st.error(show.plain(error))
        _ask_for_the_table(look, stored)
        start = settled or ({} if look.understood else dict(look.likely))
        with st.form("sheet-columns", border=False):
            _ask_for_columns(_Asked(file, case, look, start, f"{stored}-{look.sheet}-{look.header}"))


def _ask_for_the_table(look: SheetLook, stored: str) -> None:
    """Show the first rows, and ask for the sheet and the rows of the headings."""
    say = reader.say()
    width = len(look.columns)
    rows = [[*cells, *[""] * (width - len(cells))][:width] for cells in look.rows]
    letters = [column_letter(index) for index in range(width)]
    st.dataframe(pd.DataFrame(rows, columns=letters, index=range(1, len(rows) + 1), dtype=str), width="stretch")
    with st.form("sheet-table", border=False):
        left, right, button = st.columns([2, 2, 1], vertical_alignment="bottom")
        sheet = look.sheet
        if len(look.sheets) > 1:
            sheet = left.selectbox(say("sheet_form.sheet"), look.sheets, look.sheets.index(str(look.sheet)))
        header = right.text_input(say("sheet_columns.header"), look.header, help=say("sheet_columns.header_help"))
        if button.form_submit_button(say("sheet_columns.show")):
            st.session_state[stored] = sheet, header.strip()
            st.rerun()


def _ask_for_columns(asked: _Asked) -> None:
    say, chosen = reader.say(), asked.chosen
    mapping: dict[str, str] = {}
    for first in range(0, len(_ROLES), 3):
        for name, place in zip(_ROLES[first : first + 3], st.columns(3), strict=True):
            mapping[name] = asked.pick(place, name, say(f"sheet_columns.{name}"), chosen.get(name))
    values: list[tuple[str, str | None]] = [
        (name.removeprefix("value").strip(), column) for name, column in chosen.items() if name[:5] == "value"
    ]
    values += [("", None)] * (_VALUES - len(values))
    for number, (words, column) in enumerate(values, 1):
        left, right = st.columns(2)
        picked = asked.pick(left, f"value-{number}", say("sheet_columns.value", number=number), column)
        of_which = right.text_input(
            say("sheet_columns.of_which", number=number), words, key=f"{asked.key}-of-{number}",
            placeholder=say("sheet_columns.such_words"),
        )  # fmt: skip
        if picked not in (AS_HEADED, NOT_LOGGED):
            mapping[f"value {of_which}".strip()] = picked
    for name, place in zip(_TEXTS, st.columns(len(_TEXTS)), strict=True):
        text = place.text_input(say(f"sheet_columns.{name}"), chosen.get(name, ""), key=f"{asked.key}-{name}")
        mapping |= {name: text.strip()} if text.strip() else {}
    units = [AS_STATED, *unit_names("length")]
    mine = asked.file == asked.case.readings
    now = units.index(asked.case.sheet_unit) if mine and asked.case.sheet_unit in units else 0
    unit = st.selectbox(say("sheet_form.unit"), units, now, format_func=unit_said, key=f"{asked.key}-unit")
    st.caption(say("sheet_columns.remembered_here"))
    left, right = st.columns(2)
    preview = left.form_submit_button(say("sheet_columns.preview"), width="stretch")
    used = right.form_submit_button(say("sheet_columns.use"), width="stretch", type="primary")
    if preview or used:
        mapping = {name: column for name, column in mapping.items() if column != AS_HEADED}
        mapping |= {"header": asked.look.header} if mapping else {}
        _read(asked, mapping, unit or None, used)


def _read(asked: _Asked, mapping: Mapping[str, str], unit: str | None, used: bool) -> None:
    """Read the sheet so, and show its readings with all that is said of them; use it so, where that is asked for."""
    file, look = asked.file, asked.look
    sheet = look.sheet if len(look.sheets) > 1 else None
    choices: dict[str, Any] = {"sheet_columns": tuple(mapping.items()), "sheet_unit": unit, "sheet_name": sheet}
    try:
        readings = readings_of(replace(asked.case, **choices, remember=False), file)
    except AtleakError as error:
        st.error(show.plain(error))
        return
    if not used:
        _preview(readings)
        return
    if mapping:
        try:
            remember_sheet(default_path(), readings, unit)
            session().unkept = ("", "")
        except OutputError as error:
            session().unkept = (file.sha256, error.problem)
    put_file("readings", file)
    choose(**choices)
    st.rerun()


def _part_said(part: str, say: Wording) -> str:
    return next((say.sentence(words) for name, words in PART_WORDS.items() if name == part), part)


def _preview(readings: Readings) -> None:
    say = reader.say()
    st.markdown(say("sheet_columns.read", count=len(readings.readings), unit=readings.unit))
    rows = [
        {
            say("sheet_columns.component"): one.component,
            say("sheet_columns.plane"): one.plane,
            say("sheet_columns.part"): _part_said(one.part, say),
            say("sheet_columns.direction"): None if one.direction is None else f"{one.direction:g}°",
            say("sheet_columns.repeat"): one.repeat,
            say("sheet_columns.diameter"): round(one.diameter * MM, 6),
            say("sheet_columns.place"): show.plain(one.place),
        }
        for one in readings.readings[:_SHOWN]
    ]
    st.dataframe(pd.DataFrame(rows), hide_index=True, width="stretch", placeholder="–")
    show.messages(readings.messages, say("about.sheet"), opened=True)
