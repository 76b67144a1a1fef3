"""Show the tables and fields in which a valve body is typed. What is typed is text, so that no number is read twice.

A table has a fixed number of rows, some of them empty: its editor then keeps what is typed while the signs of what is
wrong in it change.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import pandas as pd
import streamlit as st

from atleak.catalogue.pump_reading import other_dimensions
from atleak.controller_sheets.circuit_shapes import Mark
from atleak.controller_sheets.kinds import Choice, YesNo
from atleak.controller_sheets.layout import NAMES, SHEETS
from atleak.controller_sheets.shapes import Column, Sheet
from atleak.controller_sheets.valve_sheets import PUMP
from atleak.views.controller_form import Checked, Draft
from pages.shared import fields, show

if TYPE_CHECKING:
    from pages.shared.transmission import Editing

COMPONENTS, NEW_PARTS = "Components", "New parts"
STEPS = {
    "Head": ("Head",),
    COMPONENTS: ("Components", "Lands", "Materials"),
    NEW_PARTS: (),  # no tables of its own: sheets of new units, from which mounting clearances are learned
    "Pump": ("Pump",),
    "Operating points": ("Operating points",),
    "Circuits": ("Circuits", "Feeds", "Set pressures", "Apply chart"),
    "Gaps": ("Gaps", "Section pressures"),
    "Pressures": ("Line pressures",),
    "Leaks, consumers": ("Leaks", "Consumers", "Consumer flows"),
    "Repairs, complaints": ("Repairs", "Complaints"),
}
_SHEETS = {sheet.name: sheet for sheet in SHEETS}
_WRONG, _ROW = "What is wrong", "Row"
_SPARE = 6  # empty rows at the end of a table
_MORE = 10
_NAMED = 5  # rows of which is said beneath their table what is wrong, too
_TALL, _LINE = 20, 35  # rows that are shown at most, and pixels of one
_LETTER, _SIGN = 7, 40  # pixels of a letter, and of the sign before a heading
_OPEN = {"pressure"}  # whose names are offered by no list: a share of one may be typed too
_WIDEST = 40  # letters of a column
_NONE = ""


def choose_step(editing: Editing) -> str:
    """Ask which tables to show; they stay chosen over other pages."""
    editing.step = editing.step or next(iter(STEPS))
    key = editing.key("step")
    picked = st.segmented_control("Tables", list(STEPS), default=editing.step, key=key, label_visibility="collapsed")
    editing.step = picked or editing.step
    return editing.step


def draw(editing: Editing, step: str, found: Checked) -> None:
    """Draw the tables and fields of a step."""
    for name in STEPS[step]:
        sheet = _SHEETS[name]
        st.subheader(name)
        star = "A star marks what must be filled in."
        st.caption(star if sheet.is_form else f"{sheet.about}. {star}")
        if sheet.is_form:
            _form(editing, sheet, found)
        else:
            _table(editing, sheet, found)


# --- fields -------------------------------------------------------------------------------------------------------


def _form(editing: Editing, sheet: Sheet, found: Checked) -> None:
    """Draw a field for each line of a form, what is wrong beneath it; a pump's dimensions of other kinds in a fold."""
    wrong = {fault.heading: fault.text for fault in found.of(sheet.name)}
    groups = _together(sheet.columns)
    aside = _of_other_pumps(found) if sheet is PUMP else frozenset()
    _fields(editing, sheet, [group for group in groups if aside.isdisjoint(group[0].keys)], wrong)
    others = [group for group in groups if not aside.isdisjoint(group[0].keys)]
    if others:
        with fields.fold("Dimensions of other kinds of pumps", key=editing.key("fold-pump")):
            _fields(editing, sheet, others, wrong)
    if None in wrong:
        st.markdown(f":red[✗ {show.plain(wrong[None])}]")


def _of_other_pumps(found: Checked) -> frozenset[str]:
    """Return the keys of what the pump described so far does not have."""
    kind = found.data.get("pump", {}).get("kind")
    return frozenset(other_dimensions(kind))


def _together(columns: Sequence[Column]) -> list[tuple[Column, ...]]:
    """Return each value's column with that of what it is known from, where it has one."""
    groups: list[tuple[Column, ...]] = []
    for column in columns:
        if column.how_known and groups and groups[-1][-1].keys[-1:] == (column.how_known,):
            groups[-1] = (*groups[-1], column)
        else:
            groups.append((column,))
    return groups


def _fields(
    editing: Editing, sheet: Sheet, groups: Sequence[tuple[Column, ...]], wrong: Mapping[str | None, str]
) -> None:
    in_pairs = any(len(group) > 1 for group in groups)
    beside = 2 if in_pairs else 3
    for start in range(0, len(groups), beside):
        places = st.columns([3, 2] * beside if in_pairs else beside)
        for number, group in enumerate(groups[start : start + beside]):
            for place, column in zip(places[number * (2 if in_pairs else 1) :], group, strict=False):
                with place:
                    _field(editing, sheet, column, _label(column, editing) if column is group[0] else "How known")
                    with st.container():
                        if column.heading in wrong:
                            st.markdown(f":red[✗ {show.plain(wrong[column.heading])}]")


def _field(editing: Editing, sheet: Sheet, column: Column, label: str) -> None:
    key = editing.key(f"{sheet.name}-{column.heading}")
    typed = editing.draft.cell(sheet.name, column.heading)
    options = _options(column, editing.draft, typed)
    shared: dict[str, Any] = {"key": key, "help": column.help or None, "on_change": _put_field}
    shared["args"] = (editing, sheet.name, column.heading, key)
    if options is None:
        made = "made from the name" if column.keys == ("id",) else None
        st.text_input(label, typed, placeholder=made, **shared)
    else:
        choices = [_NONE, *options]
        st.selectbox(label, choices, choices.index(typed), **shared)


def _put_field(editing: Editing, sheet: str, heading: str, key: str) -> None:
    editing.put(editing.draft.with_cell(sheet, heading, st.session_state[key] or ""))


# --- tables -------------------------------------------------------------------------------------------------------


def _table(editing: Editing, sheet: Sheet, found: Checked) -> None:
    """Draw a table to edit, with the number of each row and what is wrong in it."""
    key = editing.key(f"{sheet.name}-{editing.spare.get(sheet.name, 0)}")
    if key not in st.session_state or key not in editing.base:
        _begin(editing, sheet, key)
    base, columns = editing.base[key], sheet.columns_for(found.data)
    wrong: dict[int, list[str]] = {}
    for fault in found.of(sheet.name):
        wrong.setdefault(fault.row or 0, []).append(f"{fault.heading}: {fault.text}" if fault.heading else fault.text)
    with st.container():
        for text in wrong.get(0, ()):
            st.markdown(f":red[✗ {show.plain(text)}]")
    numbers = range(1, len(base) + 1)
    frame = pd.DataFrame(
        {
            _ROW: [f"{number} ✗" if number in wrong else str(number) for number in numbers],
            **{column.heading: _cells(column, base) for column in columns},
            _WRONG: [" · ".join(wrong.get(number, ())) for number in numbers],
        }
    )
    config = {column.heading: _config(column, editing, sheet, base) for column in columns}
    config[_ROW] = st.column_config.TextColumn(_ROW, width=52, disabled=True, pinned=True)
    config[_WRONG] = st.column_config.TextColumn(_WRONG, width=420, disabled=True)
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
        for number in [number for number in sorted(wrong) if number][:_NAMED]:
            st.markdown(f":red[✗ Row {number}. {show.plain(' · '.join(wrong[number]))}]")
    st.button("More rows", key=f"{key}-more", on_click=_more, args=(editing, sheet.name))


def _begin(editing: Editing, sheet: Sheet, key: str) -> None:
    """Let an editor begin with the rows of the draft, and with some to fill in."""
    rows = [dict(row) for row in editing.draft.rows(sheet.name)]
    editing.base[key] = [*rows, *({} for _ in range(_SPARE + editing.spare.get(sheet.name, 0)))]


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


def _more(editing: Editing, name: str) -> None:
    editing.spare[name] = editing.spare.get(name, 0) + _MORE


def _cells(column: Column, rows: list[dict[str, str]]) -> Any:
    cells = [row.get(column.heading, "") for row in rows]
    if isinstance(column.kind, Mark):
        return [bool(cell) for cell in cells]
    return pd.array([cell or None for cell in cells], dtype="string")


# --- columns ------------------------------------------------------------------------------------------------------


def _config(column: Column, editing: Editing, sheet: Sheet, base: list[dict[str, str]]) -> Any:
    label, tip = _label(column, editing), column.help or None
    longest = max((len(row.get(column.heading, "")) for row in base), default=0)
    width = max(min(max(column.width, longest + 2), _WIDEST) * _LETTER, len(label) * _LETTER + _SIGN)
    if isinstance(column.kind, Mark):
        return st.column_config.CheckboxColumn(label, width=60, help=tip)
    typed = (row.get(column.heading, "") for row in editing.draft.rows(sheet.name))
    options = _options(column, editing.draft, *typed)
    if options is None:
        return st.column_config.TextColumn(label, width=width, help=tip)
    return st.column_config.SelectboxColumn(label, width=width, help=tip, options=options)


def _label(column: Column, editing: Editing) -> str:
    unit = column.kind.label(editing.draft.units)
    return f"{column.heading}{f' [{unit}]' if unit else ''}{' *' if column.required else ''}"


def _options(column: Column, draft: Draft, *typed: str) -> list[str] | None:
    """Return what a drop-down offers, what is typed already included; None where anything may be typed."""
    if isinstance(column.kind, Choice):
        known = column.kind.shown
    elif isinstance(column.kind, YesNo):
        known = ("yes", "no")
    elif column.names and column.names not in _OPEN:
        offered = NAMES[column.names]
        known = (*offered.fixed, *(row.get(offered.heading, "") for row in draft.rows(offered.sheet)))
    else:
        return None
    return [name for name in dict.fromkeys((*known, *typed)) if name]
