"""Keep the valve body that is being described on the page Transmission: its start, its tables, and its saving."""

from __future__ import annotations

import streamlit as st

from atleak.catalogue.pump_reading import other_dimensions
from atleak.intake.controller_workbook import read_controller_workbook
from atleak.report.controller_workbook import write_controller_workbook
from atleak.views.controller_form import CONTROLLER
from atleak.views.entry_form import Checked, Draft, draft_of
from atleak.views.evidence_rows import evidence_counts, open_values
from pages.shared import entry_tables, reader, show
from pages.shared.cases import catalogue_list, shown_name
from pages.shared.editing import (
    Desk,
    Editing,
    ask_replacing,
    ask_unit,
    draw_kept,
    draw_save_button,
    draw_saved,
    draw_toml,
    draw_upload,
    draw_use,
    saving_of,
)
from pages.shared.learn_form import learn_form

_EMPTY = ""  # to start from nothing
_CHOICES = {"length": "lengths_in", "clearance": "clearances_are", "pressure": "pressures_in"}  # of the units
COMPONENTS, NEW_PARTS, PUMP = "components", "new_parts", "pump"
STEPS = {
    "head": ("Head",),
    COMPONENTS: ("Components", "Lands", "Materials"),
    NEW_PARTS: (),  # no tables of its own: sheets of new units, from which mounting clearances are learned
    PUMP: ("Pump",),
    "points": ("Operating points",),
    "circuits": ("Circuits", "Feeds", "Set pressures", "Apply chart"),
    "gaps": ("Gaps", "Section pressures"),
    "pressures": ("Line pressures",),
    "leaks": ("Leaks", "Consumers", "Consumer flows"),
    "repairs": ("Repairs", "Complaints"),
}
DESK = Desk(CONTROLLER, "transmission", "transmission_fields")


# --- the start ----------------------------------------------------------------------------------------------------


def choose_start() -> None:
    """Ask from what to start."""
    say, entries = reader.say(), catalogue_list("controller").entries
    left, right = st.columns(2)
    with left, st.container(border=True):
        start = st.selectbox(
            say("transmission.start_from"),
            [_EMPTY, *entries],
            format_func=lambda name: shown_name(entries[name], say) if name in entries else say("transmission.empty"),
            help=say("transmission.start_help"),
        )
        st.button(say("transmission.start"), type="primary", on_click=_start, args=(start,))
        draw_upload(DESK, say("transmission.or_read"), ["xlsx", "toml"], say, _of_workbook)
    with right, st.container(border=True):
        draw_kept(DESK, say)


def _start(name: str) -> None:
    DESK.start(name if name in catalogue_list("controller").entries else None)


def _of_workbook(content: bytes, name: str) -> Draft:
    workbook = read_controller_workbook(content, name=name)
    return draft_of(CONTROLLER, workbook.data, workbook.units)


# --- the head of the page -----------------------------------------------------------------------------------------


def draw_head(editing: Editing, found: Checked) -> None:
    """Show what is described, and ask in which units its numbers are typed."""
    say = reader.say()
    name = found.data.get("name") or say("transmission.nameless")
    st.markdown(f"**{show.plain(name)}** · {say('transmission.id')} `{found.data.get('id', '–')}`")
    with st.container():
        if found.entry is not None:
            counts = evidence_counts(found.entry)
            known = ", ".join(
                say("transmission.count", count=count, known=say(f"evidence.{name}"))
                for name, count in counts.items()
                if count
            )
            lacking = "; ".join(open_values(found.entry, say)) or say("transmission.nothing")
            st.caption(show.plain(say("transmission.counts", known=known, lacking=lacking)))
    places = st.columns([1, 1, 1, 1], vertical_alignment="bottom")
    for place, (attribute, label) in zip(places, _CHOICES.items(), strict=False):
        ask_unit(editing, attribute, say(f"transmission.{label}"), place)
    places[3].button(say("transmission.another"), on_click=DESK.close, help=say("transmission.another_help"))


def draw_tables(editing: Editing, step: str, found: Checked) -> None:
    """Draw the tables and fields of a step; a pump's dimensions of other kinds in a fold."""
    kind = found.data.get("pump", {}).get("kind")
    entry_tables.draw(editing, STEPS[step], found, frozenset(other_dimensions(kind)) if step == PUMP else ())


def draw_learning(editing: Editing, step: str, found: Checked) -> None:
    """Learn mounting clearances from measuring sheets of new units, into the tables of lands."""
    if step != NEW_PARTS:
        return
    say = reader.say()
    st.subheader(say("transmission.learning"))
    if found.entry is None:
        st.caption(say("transmission.learning_later"))
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
        draw_use(editing, found, saving, "controller", say("typed_entries.use"), say)
        draw_toml(saving, say)
        st.download_button(
            say("transmission.workbook"),
            lambda: write_controller_workbook(found.data, editing.draft.units),
            f"{saving.name or 'unnamed'}.xlsx",
            on_click="ignore",
            disabled=found.entry is None,
            help=say("transmission.workbook_help"),
        )
    draw_saved(editing, found, saving, say)
