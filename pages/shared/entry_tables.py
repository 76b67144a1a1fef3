"""Show the tables and fields in which an entry of the catalogue is typed. What is typed is text, read once.

A table has a fixed number of rows, some of them empty: its editor then keeps what is typed while the signs of what is
wrong in it change.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import pandas as pd
import streamlit as st

from atleak.catalogue.workbook.cells import ChoiceCell, YesNo
from atleak.catalogue.workbook.circuit_sheets import Mark
from atleak.catalogue.workbook.draft import Checked, Draft
from atleak.catalogue.workbook.shapes import SheetColumn, SheetFault, WorkbookSheet
from atleak.common.wording import Wording
from pages.shared import fields, reader, show

if TYPE_CHECKING:
    from pages.shared.editing import Editing

_WRONG, _ROW = "What is wrong", "Row"
_SPARE = 6  # empty rows at the end of a table
_MORE = 10
_NAMED = 5  # rows of which is said beneath their table what is wrong, too
_TALL, _LINE = 20, 35  # rows that are shown at most, and pixels of one
_LETTER, _SIGN = 7, 40  # pixels of a letter, and of the sign before a heading
_SIGN_OF = {"red": "✗", "orange": "?"}
_OPEN = {"pressure", "repaired part"}  # whose names no list offers: a share of one, or several, may be typed
_WIDEST = 40  # letters of a column
_NONE = ""


def draw(editing: Editing, names: Iterable[str], found: Checked, aside: frozenset[str] = frozenset()) -> None:
    """Draw some tables and fields of what is being typed; those of the keys ``aside`` of a form in a fold."""
    say = reader.say()
    for name in names:
        sheet = editing.draft.subject.sheet(name)
        st.header(say.name(name, "form"))
        st.caption(f"{say.name(sheet.about, 'form')}. {say('typed_entries.star')}")
        if sheet.is_form:
            _form(editing, sheet, found, aside, say)
        else:
            _table(editing, sheet, found, say)


# --- fields -------------------------------------------------------------------------------------------------------


def _form(editing: Editing, sheet: WorkbookSheet, found: Checked, aside: frozenset[str], say: Wording) -> None:
    """Draw a field for each line of a form, with what is wrong or in doubt beneath it."""
    signs = {doubt.spot.heading: f":orange[? {show.plain(doubt.text)}]" for doubt in found.doubted_in(sheet.name)}
    signs |= {fault.spot.heading: f":red[✗ {show.plain(fault.text)}]" for fault in found.of(sheet.name)}
    groups = _together(sheet.columns)
    _fields(editing, sheet, [group for group in groups if aside.isdisjoint(group[0].keys)], signs, say)
    others = [group for group in groups if not aside.isdisjoint(group[0].keys)]
    if others:
        with fields.fold(say("typed_entries.other_pumps"), key=editing.key(f"fold-{sheet.name}")):
            _fields(editing, sheet, others, signs, say)
    with st.container():
        if None in signs:
            st.markdown(signs[None])


def _together(columns: Sequence[SheetColumn]) -> list[tuple[SheetColumn, ...]]:
    """Return each value's column with that of what it is known from, where it has one."""
    groups: list[tuple[SheetColumn, ...]] = []
    for column in columns:
        if column.how_known and groups and groups[-1][-1].keys[-1:] == (column.how_known,):
            groups[-1] = (*groups[-1], column)
        else:
            groups.append((column,))
    return groups


def _fields(
    editing: Editing,
    sheet: WorkbookSheet,
    groups: Sequence[tuple[SheetColumn, ...]],
    signs: Mapping[str | None, str],
    say: Wording,
) -> None:
    in_pairs = any(len(group) > 1 for group in groups)
    beside = 2 if in_pairs else 3
    for start in range(0, len(groups), beside):
        places = st.columns([3, 2] * beside if in_pairs else beside)
        for number, group in enumerate(groups[start : start + beside]):
            for place, column in zip(places[number * (2 if in_pairs else 1) :], group, strict=False):
                with place:
                    label = _label(column, editing, say) if column is group[0] else say("typed_entries.how_known")
                    _field(editing, sheet, column, label, say)
                    with st.container():
                        if column.heading in signs:
                            st.markdown(signs[column.heading])


def _field(editing: Editing, sheet: WorkbookSheet, column: SheetColumn, label: str, say: Wording) -> None:
    key = editing.key(f"{sheet.name}-{column.heading}")
    typed = editing.draft.cell(sheet.name, column.heading)
    options = _options(column, editing.draft, typed)
    help = say.name(column.help, "form") or None

    def put() -> None:
        editing.put(editing.draft.with_cell(sheet.name, column.heading, st.session_state[key] or ""))

    shared: dict[str, Any] = {"key": key, "help": help, "on_change": put}
    if options is None:
        made = say("typed_entries.made") if column.keys == ("id",) else None
        st.text_input(label, typed, placeholder=made, **shared)
    else:
        choices = [_NONE, *options]
        said = _choice_text(column, say)
        st.selectbox(label, choices, choices.index(typed), said, **shared)


# --- tables -------------------------------------------------------------------------------------------------------


def _table(editing: Editing, sheet: WorkbookSheet, found: Checked, say: Wording) -> None:
    """Draw a table to edit, with the number of each row and what is wrong in it."""
    key = editing.key(f"{sheet.name}-{editing.spare.get(sheet.name, 0)}")
    if key not in st.session_state or key not in editing.base:  # it begins with the draft's rows, and some to fill in
        rows = [dict(row) for row in editing.draft.rows(sheet.name)]
        editing.base[key] = [*rows, *({} for _ in range(_SPARE + editing.spare.get(sheet.name, 0)))]
    base, columns = editing.base[key], sheet.columns_for(found.data)
    wrong, doubted = (_by_row(faults, say) for faults in (found.of(sheet.name), found.doubted_in(sheet.name)))
    said = {number: [*wrong.get(number, ()), *doubted.get(number, ())] for number in {*wrong, *doubted}}
    with st.container():
        for colour, texts in (("red", wrong.get(0, ())), ("orange", doubted.get(0, ()))):
            for text in texts:
                st.markdown(f":{colour}[{_SIGN_OF[colour]} {show.plain(text)}]")
    numbers = range(1, len(base) + 1)
    frame = pd.DataFrame(
        {
            _ROW: [f"{number}{' ✗' * (number in wrong) or ' ?' * (number in doubted)}" for number in numbers],
            **{column.heading: _cells(column, base) for column in columns},
            _WRONG: [" · ".join(said.get(number, ())) for number in numbers],
        }
    )
    config = {column.heading: _config(column, editing, sheet, base, say) for column in columns}
    config[_ROW] = st.column_config.TextColumn(say("typed_entries.row"), width=52, disabled=True, pinned=True)
    config[_WRONG] = st.column_config.TextColumn(say("typed_entries.wrong"), width=420, disabled=True)
    st.data_editor(
        frame,
        key=key,
        num_rows="fixed",
        hide_index=True,
        placeholder="",
        column_config=config,
        height=_LINE * (min(len(base), _TALL) + 1) + 3,
        on_change=_take,
        args=(editing, sheet.name, key),
    )
    with st.container():
        for number in [number for number in sorted(said) if number][:_NAMED]:
            colour = "red" if number in wrong else "orange"
            row = say("typed_entries.row_number", number=number)
            st.markdown(f":{colour}[{_SIGN_OF[colour]} {row} {show.plain(' · '.join(said[number]))}]")

    def more() -> None:
        editing.spare[sheet.name] = editing.spare.get(sheet.name, 0) + _MORE

    st.button(say("typed_entries.more"), key=f"{key}-more", on_click=more)


def _by_row(faults: Iterable[SheetFault], say: Wording) -> dict[int, list[str]]:
    """Return what is said of each row, under 0 what is of the whole table."""
    said: dict[int, list[str]] = {}
    for fault in faults:
        text = say.sentence(fault.text)
        heading = f"{say.name(fault.spot.heading, 'form')}: " if fault.spot.heading else ""
        said.setdefault(fault.spot.row or 0, []).append(f"{heading}{text}")
    return said


def _take(editing: Editing, name: str, key: str) -> None:
    """Take over what was typed into a table, before anything is drawn."""
    rows = [dict(row) for row in editing.base[key]]
    for number, cells in st.session_state[key]["edited_rows"].items():
        rows[int(number)] |= {heading: _typed(value) for heading, value in cells.items()}
    editing.put(editing.draft.with_rows(name, rows))


def _typed(value: Any) -> str:
    if isinstance(value, bool):
        return "x" if value else ""
    return "" if value is None else str(value)


def _cells(column: SheetColumn, rows: list[dict[str, str]]) -> Any:
    cells = [row.get(column.heading, "") for row in rows]
    if isinstance(column.kind, Mark):
        return [bool(cell) for cell in cells]
    return pd.array([cell or None for cell in cells], dtype="string")


# --- columns ------------------------------------------------------------------------------------------------------


def _config(
    column: SheetColumn, editing: Editing, sheet: WorkbookSheet, base: list[dict[str, str]], say: Wording
) -> Any:
    label, tip = _label(column, editing, say), say.name(column.help, "form") or None
    longest = max((len(row.get(column.heading, "")) for row in base), default=0)
    width = max(min(max(column.width, longest + 2), _WIDEST) * _LETTER, len(label) * _LETTER + _SIGN)
    if isinstance(column.kind, Mark):
        return st.column_config.CheckboxColumn(label, width=60, help=tip)
    typed = (row.get(column.heading, "") for row in editing.draft.rows(sheet.name))
    options = _options(column, editing.draft, *typed)
    if options is None:
        return st.column_config.TextColumn(label, width=width, help=tip)
    said = _choice_text(column, say)
    return st.column_config.SelectboxColumn(label, width=width, help=tip, options=options, format_func=said)


def _label(column: SheetColumn, editing: Editing, say: Wording) -> str:
    unit = say.get("typed_units", column.kind.label(editing.draft.units))
    return f"{say.name(column.heading, 'form')}{f' [{unit}]' if unit else ''}{' *' if column.required else ''}"


def _choice_text(column: SheetColumn, say: Wording) -> Callable[[Any], str]:
    """Return what says a choice in the reader's language; what somebody named stands as it is."""
    words = isinstance(column.kind, ChoiceCell | YesNo)
    return lambda typed: say.name(typed, "form") if words and typed else str(typed)


def _options(column: SheetColumn, draft: Draft, *typed: str) -> list[str] | None:
    """Return what a drop-down offers, what is typed already included; None where anything may be typed."""
    if isinstance(column.kind, ChoiceCell):
        known = column.kind.shown
    elif isinstance(column.kind, YesNo):
        known = ("yes", "no")
    elif column.names and column.names not in _OPEN:
        offered = draft.subject.names[column.names]
        known = (*offered.fixed, *(row.get(offered.heading, "") for row in draft.rows(offered.sheet)))
    else:
        return None
    return [name for name in dict.fromkeys((*known, *typed)) if name]
