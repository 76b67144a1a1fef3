"""Show what is remembered of the columns of logs and measuring sheets, and let it be forgotten."""

from __future__ import annotations

import datetime as dt

import streamlit as st

from atleak.common.files import damaged_before
from atleak.common.sentences import Sentence
from atleak.common.wording import Wording
from atleak.readers.logs import FORMATS, default_path, forget_columns
from atleak.readers.remembered_columns import RememberedColumns, recall_all, restore_columns
from atleak.readers.sheets.mapping import FORMAT
from pages.shared import fields, reader, show
from pages.shared.cases import readings_of
from pages.shared.state import choose, session

_FORGOTTEN = "forgotten-columns"


def draw() -> None:
    """Draw the part of the page: what is remembered, of which logs, since when, each with a button to forget it."""
    say = reader.say()
    with fields.fold(say("remembered.fold"), key="remembered-columns") as place:
        if not place.open:
            return
        st.caption(say("remembered.help"))
        show.refused(_FORGOTTEN)
        for file in damaged_before(default_path()):
            st.warning(say("remembered.set_aside", file=show.plain(str(file))))
        kept = recall_all(default_path())
        if not kept:
            st.write(say("remembered.none"))
        for header, entry in kept.items():
            text, button = st.columns([5, 1], vertical_alignment="center")
            text.markdown(_words(entry, say))
            button.button(
                say("remembered.forget"),
                key=f"forget-{header}",
                on_click=_forget,
                args=(header, entry),
                width="stretch",
            )
        if _FORGOTTEN in st.session_state:
            header, entry = st.session_state[_FORGOTTEN]
            text, button = st.columns([5, 1], vertical_alignment="center")
            text.caption(say("remembered.forgotten", columns=show.plain(_choices(entry, say))))
            button.button(say("remembered.undo"), key="forget-undo", on_click=_undo, width="stretch")


def _words(entry: RememberedColumns, say: Wording) -> str:
    if entry.columns:
        columns = ", ".join(entry.columns[:6]) + (" …" if len(entry.columns) > 6 else "")
        count = say.number(len(entry.columns), 0)
        format_ = show.plain({**FORMATS, FORMAT: Sentence("measuring sheet")}.get(entry.format, entry.format))
        head = say("remembered.entry", format=format_, count=count, columns=show.plain(columns))
    else:
        head = say("remembered.entry_unknown")
    when = say("remembered.when", when=_local(entry.when)) if entry.when else ""
    return "  \n".join(part for part in (head, show.plain(_choices(entry, say)), when) if part)


def _choices(entry: RememberedColumns, say: Wording) -> str:
    """Return which column and unit were chosen for each quantity."""
    names = dict.fromkeys((*entry.mapping, *entry.units))
    parts = []
    for name in names:
        column = entry.mapping.get(name)
        shown = say("remembered.no_choice") if column is None else column or say("mapping.not_in_log")
        quantity = say.get("log_quantities", name)
        unit = entry.units.get(name)
        key = "remembered.pair_unit" if unit else "remembered.pair"
        parts.append(say(key, quantity=quantity, column=shown, unit=unit))
    return "; ".join(parts) or say("remembered.no_choice")


def _local(when: str) -> str:
    """Return a stamp in the time of the computer that runs the dashboard, to the minute."""
    try:
        return dt.datetime.fromisoformat(when).astimezone().isoformat(" ", "minutes")[:16]
    except ValueError:
        return when


def _forget(header: str, entry: RememberedColumns) -> None:
    now = session()
    if now.case.road_test is not None and now.case.road_test == now.good.road_test:  # this job keeps its log's columns
        choose(columns=now.good.columns, units=now.good.units, remember=now.good.remember)
    sheet = now.good.readings
    if entry.format == FORMAT and sheet is not None and now.case.readings == sheet and not now.case.sheet_columns:
        readings = readings_of(now.good, sheet)  # this job keeps its sheet's columns
        if readings.columns:
            choose(sheet_columns=readings.columns, sheet_unit=now.case.sheet_unit or entry.units.get("value"))
    with show.refusing(_FORGOTTEN):
        forget_columns(default_path(), header)
        st.session_state[_FORGOTTEN] = (header, entry)


def _undo() -> None:
    with show.refusing(_FORGOTTEN):
        restore_columns(default_path(), *st.session_state[_FORGOTTEN])
        del st.session_state[_FORGOTTEN]
