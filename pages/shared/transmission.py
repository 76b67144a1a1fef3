"""Keep the valve body that is being described on the page Transmission: its start, its faults, and its saving."""

from __future__ import annotations

import tomllib

import streamlit as st

from atleak.catalogue.controller_reading import checked_controller
from atleak.errors import CatalogueError
from atleak.intake.controller_workbook import read_controller_workbook
from atleak.report.controller_workbook import write_controller_workbook
from atleak.views.controller_form import CONTROLLER
from atleak.views.entry_form import Checked, draft_of
from atleak.views.evidence_rows import evidence_counts, still_to_measure
from pages.shared import reader, show
from pages.shared.cases import catalogue_list, shown_name
from pages.shared.editing import (
    Desk,
    Editing,
    ask_replacing,
    ask_unit,
    draw_save_button,
    draw_saved,
    saving_of,
)
from pages.shared.learn_form import learn_form
from pages.shared.state import pick
from pages.shared.transmission_tables import NEW_PARTS

_EMPTY = "an empty description"
_CHOICES = {  # of the units: attribute and label
    "length": "Lengths are in",
    "clearance": "Clearances are",
    "pressure": "Pressures are in",
}
DESK = Desk(CONTROLLER, "transmission")


# --- the start ----------------------------------------------------------------------------------------------------


def choose_start() -> None:
    """Ask from what to start."""
    entries = catalogue_list("controller").entries
    kept = DESK.kept()
    left, right = st.columns(2)
    with left, st.container(border=True):
        start = st.selectbox(
            "Start from",
            [_EMPTY, *entries],
            format_func=lambda name: shown_name(entries[name]) if name in entries else name,
            help="A shipped valve body is copied under another name; an own one is edited itself.",
        )
        st.button("Start", type="primary", on_click=_start, args=(start,))
        upload = st.file_uploader("or read a workbook or a TOML file", ["xlsx", "toml"], key="transmission-file")
        if upload is not None:
            _read_file(upload.name, upload.getvalue())
    with right, st.container(border=True):
        token = st.selectbox(
            "Go on with a draft",
            list(kept),
            format_func=lambda token: kept.get(token, token),
            disabled=not kept,
            placeholder="none is kept",
            help="What was typed on this page and not saved. The newest are kept in your own folder.",
        )
        with st.container(horizontal=True):
            st.button("Go on", disabled=not kept, on_click=DESK.go_on, args=(token,))
            st.button("Throw it away", disabled=not kept, on_click=DESK.throw_away, args=(token,))


def _start(name: str) -> None:
    DESK.start(name if name in catalogue_list("controller").entries else None)


def _read_file(name: str, content: bytes) -> None:
    try:
        if content.startswith(b"PK"):
            workbook = read_controller_workbook(content, name=name)
            draft = draft_of(CONTROLLER, workbook.data, workbook.units)
        else:
            data = tomllib.loads(content.decode("utf-8-sig"))
            checked_controller(data, name)
            draft = draft_of(CONTROLLER, data)
    except (CatalogueError, ValueError, RecursionError) as error:
        st.error(f"**{show.plain(name)} was not taken.** {show.plain(error)}")
        return
    DESK.take(draft)
    st.rerun()


# --- the head of the page -----------------------------------------------------------------------------------------


def draw_head(editing: Editing, found: Checked) -> None:
    """Show what is described, and ask in which units its numbers are typed."""
    name = found.data.get("name") or "A valve body without a name"
    st.markdown(f"**{show.plain(name)}** · id `{found.data.get('id', '–')}`")
    with st.container():
        if found.entry is not None:
            counts = evidence_counts(found.entry)
            known = ", ".join(f"{count} {name.replace('_', ' ')}" for name, count in counts.items() if count)
            lacking = "; ".join(still_to_measure(found.entry)) or "nothing"
            st.caption(f"Values: {known}. Still to be measured or looked up: {lacking}.")
    places = st.columns([1, 1, 1, 1], vertical_alignment="bottom")
    for place, (attribute, label) in zip(places, _CHOICES.items(), strict=False):
        ask_unit(editing, attribute, label, place)
    places[3].button("Describe another one", on_click=DESK.close, help="This one stays among the drafts.")


def draw_learning(editing: Editing, step: str, found: Checked) -> None:
    """Learn mounting clearances from measuring sheets of new units, into the tables of lands."""
    if step != NEW_PARTS:
        return
    st.subheader("Mounting clearances from new parts")
    if found.entry is None:
        st.caption("Sheets can be read once nothing is missing or wrong: type a guess for clearances not known yet.")
        return
    tables = learn_form(found.data, key=editing.key("learn"))
    if tables is not None:
        editing.put(draft_of(CONTROLLER, tables, editing.draft.units))
        editing.anew()
        st.rerun()


# --- saving -------------------------------------------------------------------------------------------------------


def draw_saving(editing: Editing, found: Checked) -> None:
    """Offer to save it as an own file, to use it for the job, and to take it along."""
    say = reader.say()
    saving = saving_of(editing, found)
    over = ask_replacing(editing, saving, say)
    with st.container(horizontal=True):
        draw_save_button(editing, found, saving, over, say)
        st.button(
            "Use it for this job",
            disabled=found.entry is None or not saving.saved,
            on_click=pick,
            args=("controller", saving.name),
            help="Chooses it as the valve body in the sidebar. Save it first.",
        )
        st.download_button("TOML file", saving.text, f"{saving.name or 'unnamed'}.toml", on_click="ignore")
        st.download_button(
            "Workbook",
            lambda: write_controller_workbook(found.data, editing.draft.units),
            f"{saving.name or 'unnamed'}.xlsx",
            on_click="ignore",
            disabled=found.entry is None,
            help="The same tables as sheets, to be filled in elsewhere and read here again.",
        )
    draw_saved(editing, found, saving, say)
