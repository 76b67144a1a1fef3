"""Show how a log was understood, and ask what its file leaves open."""

from __future__ import annotations

from typing import Any

import streamlit as st

from atleak.errors import AtleakError
from atleak.events import Event
from atleak.intake.road_test import Understood, describe
from atleak.intake.road_test.describe import workshop_unit
from atleak.intake.road_test.names.memory import RememberedColumns
from atleak.intake.units import unit_names
from atleak.job.case import SourceFile
from atleak.road_test import QUANTITIES, RoadTest
from atleak.views.window import event_label
from atleak.written_numbers import SHIFT
from pages.shared import fields, show
from pages.shared.cases import Kept, PageCase, remember_columns, remembered_columns, understood
from pages.shared.state import choose, put_file, session

ASK = "choose …"
NONE = "not in this log"


def pending(case: PageCase) -> tuple[SourceFile, Understood] | None:
    """Return the log to show: the one refused for an open question, else that of the job."""
    refused = session().refused.get("road_test")
    if refused is not None and refused.file is not None:
        try:
            return refused.file, understood(refused.file)
        except AtleakError:
            pass  # the file is no log at all, so there is nothing to ask about it
    return None if case.road_test is None else (case.road_test, Kept().log(case))


def scales(test: RoadTest) -> dict[str, tuple[str, Any]]:
    """Return, by quantity, the unit that people read and the function from SI to it."""
    units = {name: workshop_unit(name, channel) for name, channel in test.channels.items()}
    return {name: (unit.name, unit.from_si) for name, unit in units.items() if unit is not None}


def column_rows(log: Understood) -> list[dict[str, Any]]:
    """Return what was understood of every column."""
    return [
        {
            "quantity": QUANTITIES[row["quantity"]].label,
            "column": row["column"] or row["source"],
            "unit in the file": (row["unit"] or "–") + (" (assumed)" if row["unit_assumed"] else ""),
            "kind": row["kind"] if row["quantity"].endswith("pressure") else None,
            "least": row["min"],
            "largest": row["max"],
            "in": row["value_unit"],
            "samples": row["samples"],
            "suspect": row["suspect_samples"],
            "per second": row["sampling_hz"],
        }
        for row in describe(log)["columns"]
    ]


def form(file: SourceFile, log: Understood, case: PageCase) -> None:
    """Ask for columns and units, where the file leaves them open or the user knows better."""
    asked = {question.quantity for question in log.ambiguous}
    for question in log.ambiguous:
        st.warning(f"**{QUANTITIES[question.quantity].label}:** {show.plain(question.why)}. Which column is it?")
    earlier = (remembered_columns(file) if file != case.road_test or case.remember else None) or RememberedColumns()
    chosen_columns, chosen_units = dict(earlier.mapping), dict(earlier.units)
    if file == case.road_test:
        chosen_columns |= dict(case.columns)
        chosen_units |= dict(case.units)
    if session().unkept[0] == file.sha256:
        st.warning(f"These columns are used, but could not be remembered: {show.plain(session().unkept[1])}.")
    with st.expander("Columns and units", expanded=bool(asked)), st.form("columns", border=False):
        labels = [heading.label for heading in log.headings]
        columns, units = {}, {}
        for name, quantity in QUANTITIES.items():
            taken = None if log.road_test is None else log.road_test.channels.get(name)
            now = chosen_columns.get(name) or (taken.column if taken is not None else None)
            options = [ASK if name in asked else NONE, *labels]
            index = options.index(now) if now in options else 0
            left, right = st.columns([3, 1])
            picked = left.selectbox(quantity.label, options, index, key=f"column-{file.sha256}-{name}")
            if picked not in (ASK, NONE) and (picked != now or name in chosen_columns):
                columns[name] = picked
            if quantity.unit_kind is not None:
                names = ["as stated", *unit_names(quantity.unit_kind)]
                at = names.index(chosen_units[name]) if chosen_units.get(name) in names else 0
                unit = right.selectbox("unit", names, at, key=f"unit-{file.sha256}-{name}")
                if unit != names[0]:
                    units[name] = unit
        st.caption("Remembered on the computer that runs this dashboard, for everyone who uses it.")
        if st.form_submit_button("Use and remember for logs with this header"):
            why = remember_columns(file, columns, units)
            session().unkept = (file.sha256, why) if why else ("", "")
            put_file("road_test", file)
            choose(columns=tuple(columns.items()), units=tuple(units.items()))
            st.rerun()


def overlay() -> tuple[RoadTest, float] | None:
    """Return another log to lay over the job's, and by how much it is shifted; kept while pages change."""
    now = session()
    with fields.fold("Lay another log over it: before and after a repair", key=f"over-fold-{now.generation}"):
        own = st.file_uploader("Other road-test log", key=f"over-{now.generation}")
        if own is not None:
            now.over = SourceFile(own.name, own.getvalue())
        if now.over is None:
            return None
        st.caption(f"Dashed: **{show.plain(now.over.name)}**")
        now.offset = fields.number("Shifted by", SHIFT, 0.0, key=f"shift-{now.generation}-{now.over.sha256}")
        if st.button("Take it away", disabled=own is not None, help="or remove the file above"):
            now.over = None
            st.rerun()
        try:
            test = understood(now.over).road_test
        except AtleakError as error:
            st.error(show.plain(error))
            return None
    return None if test is None else (test, now.offset)


def window(test: RoadTest, happened: tuple[Event, ...]) -> tuple[float, float] | None:
    """Return the part of the log to look at: an event, or between two cursors; None for the whole log."""
    first, last = float(test.time[0]), float(test.time[-1])
    if not last > first:
        return None
    kept = session().windows
    chosen = st.selectbox("Look at", [None, *happened], key="window-event", format_func=_event_name)
    ends = (first, last) if chosen is None else (chosen.start, chosen.stop)
    if chosen is None:
        ends = kept.get(test.sha256, ends)
    key = f"window-{test.sha256}-{st.session_state.get('window-set', 0)}-{ends if chosen is not None else 'own'}"
    start, stop = st.slider("Between two cursors [s]", first, last, ends, key=key)
    whole = (start, stop) == (first, last)
    if chosen is None:
        kept.pop(test.sha256, None) if whole else kept.update({test.sha256: (start, stop)})
    return None if whole else (start, stop)


def look_between(test: RoadTest, start: float, stop: float) -> None:
    """Set both cursors; a chart calls this before the cursors are drawn."""
    first, last = float(test.time[0]), float(test.time[-1])
    ends = (min(max(start, first), last), min(max(stop, first), last))
    if ends[1] > ends[0]:
        session().windows[test.sha256] = ends
        st.session_state["window-event"] = None
        st.session_state["window-set"] = st.session_state.get("window-set", 0) + 1  # a fresh slider starts from it


def _event_name(event: Event | None) -> str:
    return "the whole log, or between the cursors" if event is None else event_label(event)
