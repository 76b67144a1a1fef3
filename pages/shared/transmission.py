"""The valve body that is being described on the page Transmission: its tables, what it learns, its workbook."""

from __future__ import annotations

import streamlit as st

from atleak.catalogue.pump_dimensions import other_dimensions
from atleak.catalogue.workbook.draft import Checked, Draft, draft_of
from atleak.catalogue.workbook.subjects import CONTROLLER
from atleak.readers.controller_workbook import read_controller_workbook
from atleak.report.sheets.controller_workbook import write_controller_workbook
from atleak.report.tables.catalogue import evidence_counts, open_values
from pages.shared import entry_tables, reader, workshop_data
from pages.shared.editing import Desk, Editing
from pages.shared.learn_form import learn_form

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


def _of_workbook(content: bytes, name: str) -> Draft:
    workbook = read_controller_workbook(content, name=name)
    return draft_of(CONTROLLER, workbook.data, workbook.units)


_UNITS = ("length", "clearance", "pressure")
DESK = Desk(CONTROLLER, "transmission", _UNITS, _of_workbook)


def draw_head(editing: Editing, found: Checked) -> None:
    """Show what is described and how its values are known, and ask in which units its numbers are typed."""
    say, told = reader.say(), ""
    if found.entry is not None:
        counts = evidence_counts(found.entry)
        known = ", ".join(
            say("transmission.count", count=count, known=say(f"evidence.{name}"))
            for name, count in counts.items()
            if count
        )
        lacking = "; ".join(open_values(found.entry, say)) or say("transmission.nothing")
        told = say("transmission.counts", known=known, lacking=lacking)
    workshop_data.draw_head(DESK, editing, found, say, told)


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


def draw_saving(editing: Editing, found: Checked) -> None:
    """Offer to save it as an own file, to use it for the job, and to take it along, as a workbook too."""
    say = reader.say()

    def workbook(name: str) -> None:
        st.download_button(
            say("transmission.workbook"),
            lambda: write_controller_workbook(found.data, editing.draft.units),
            f"{name}.xlsx",
            on_click="ignore",
            disabled=found.entry is None,
            help=say("transmission.workbook_help"),
        )

    workshop_data.draw_saving(DESK, editing, found, say, workbook)
