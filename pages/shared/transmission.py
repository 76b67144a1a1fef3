"""Keep the valve body that is being described on the page Transmission: its start, its faults, and its saving."""

from __future__ import annotations

import hashlib
import tomllib
from dataclasses import dataclass, field
from datetime import datetime
from typing import Any

import streamlit as st

from atleak.catalogue.controller_reading import checked_controller
from atleak.catalogue.controller_toml import written_toml
from atleak.catalogue.entries import own_files, read_tables, write_own
from atleak.controller_sheets.units import CLEARANCES, LENGTHS, PRESSURES, Units
from atleak.errors import CatalogueError, OutputError
from atleak.intake.controller_workbook import read_controller_workbook
from atleak.report.controller_workbook import write_controller_workbook
from atleak.system.drafts import draft_text, drafts, forget_draft, keep_draft, new_token
from atleak.views.controller_form import Checked, Draft, checked, copy_of, draft_of, read_draft
from atleak.views.evidence_rows import evidence_counts, still_to_measure
from pages.shared import show
from pages.shared.cases import catalogue_list, shown_name
from pages.shared.learn_form import learn_form
from pages.shared.state import pick
from pages.shared.transmission_tables import NEW_PARTS

_STATE = "transmission"
_EMPTY = "an empty description"
_SHOWN = 15  # faults in one list
_CHOICES = (  # of the units: attribute, label, values
    ("length", "Lengths are in", LENGTHS),
    ("clearance", "Clearances are", CLEARANCES),
    ("pressure", "Pressures are in", PRESSURES),
)


@dataclass
class Editing:
    """One valve body being described. Another ``generation`` gives fresh widgets."""

    draft: Draft
    token: str = field(default_factory=new_token)  # under which the draft is kept
    over: str = ""  # SHA-256 of the own file that it was read from or saved as
    own: str = ""  # id of that file
    generation: int = 0
    step: str = ""  # the tables that are shown
    base: dict[str, list[dict[str, str]]] = field(default_factory=dict)  # rows that an editor began with, by its key
    spare: dict[str, int] = field(default_factory=dict)  # empty rows asked for, by table
    unkept: str = ""  # why the draft could not be kept

    def put(self, draft: Draft) -> None:
        """Take over what was typed, and keep it where a page that is loaded anew still has it."""
        if draft == self.draft:
            return
        self.draft = draft
        try:
            keep_draft(self.token, draft.written())
            self.unkept = ""
        except OutputError as error:
            self.unkept = str(error)

    def anew(self) -> None:
        """Draw every field and table anew from the draft."""
        self.generation += 1
        self.base.clear()
        self.spare.clear()

    def key(self, name: str) -> str:
        """Return the key of a widget."""
        return f"{_STATE}-{self.token}-{self.generation}-{name}"


def current() -> Editing | None:
    """Return what is being described in this session or, after the page was loaded anew, before it."""
    editing: Editing | None = st.session_state.get(_STATE)
    if editing is None:
        if token := st.query_params.get("draft"):
            _go_on(token)
        if _STATE not in st.session_state and (name := st.query_params.get("own")) in own_files("controllers"):
            _start(name)
        editing = st.session_state.get(_STATE)
    if editing is not None:
        st.query_params["draft"] = editing.token
        if editing.own:
            st.query_params["own"] = editing.own
    return editing


def checked_now(editing: Editing) -> Checked:
    """Return what the draft describes and what is wrong with it; checked once for each state of the draft."""
    return _checked(editing.draft.written(), editing.draft)


@st.cache_resource(max_entries=16, show_spinner=False)
def _checked(key: str, _draft: Draft) -> Checked:
    return checked(_draft)


# --- the start ----------------------------------------------------------------------------------------------------


def choose_start() -> None:
    """Ask from what to start."""
    entries = catalogue_list("controller").entries
    kept = drafts()
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
            format_func=_draft_label,
            disabled=not kept,
            placeholder="none is kept",
            help="What was typed on this page and not saved. The newest are kept in your own folder.",
        )
        with st.container(horizontal=True):
            st.button("Go on", disabled=not kept, on_click=_go_on, args=(token,))
            st.button("Throw it away", disabled=not kept, on_click=_throw_away, args=(token,))


def _draft_label(token: str) -> str:
    draft, path = read_draft(draft_text(token) or ""), drafts().get(token)
    name = (draft.cell("Head", "Name") if draft is not None else "") or "without a name"
    return name if path is None else f"{name}, {datetime.fromtimestamp(path.stat().st_mtime):%Y-%m-%d %H:%M}"


def _start(name: str) -> None:
    entry = catalogue_list("controller").entries.get(name)
    if entry is None:
        st.session_state[_STATE] = Editing(Draft())
        return
    data, origin = read_tables("controllers", name)
    if origin.own:
        st.session_state[_STATE] = Editing(draft_of(data), over=origin.sha256, own=name)
    else:
        st.session_state[_STATE] = Editing(draft_of(copy_of(data)))


def _go_on(token: str) -> None:
    draft = read_draft(draft_text(token) or "")
    if draft is not None:
        st.session_state[_STATE] = Editing(draft, token)


def _throw_away(token: str) -> None:
    forget_draft(token)
    if (editing := st.session_state.get(_STATE)) is not None and editing.token == token:
        _close()


def _close() -> None:
    st.session_state.pop(_STATE, None)
    for name in ("draft", "own"):
        st.query_params.pop(name, None)


def _read_file(name: str, content: bytes) -> None:
    try:
        if content.startswith(b"PK"):
            workbook = read_controller_workbook(content, name=name)
            draft = draft_of(workbook.data, workbook.units)
        else:
            data = tomllib.loads(content.decode("utf-8-sig"))
            checked_controller(data, name)
            draft = draft_of(data)
    except (CatalogueError, ValueError, RecursionError) as error:
        st.error(f"**{show.plain(name)} was not taken.** {show.plain(error)}")
        return
    st.session_state[_STATE] = Editing(draft)
    st.rerun()


# --- the head of the page -----------------------------------------------------------------------------------------


def draw_head(editing: Editing, found: Checked) -> None:
    """Show what is described, and ask in which units its numbers are typed."""
    name = found.data.get("name") or "A valve body without a name"
    st.markdown(f"**{show.plain(name)}** · id `{found.data.get('id', '–')}`")
    with st.container():
        if found.controller is not None:
            counts = evidence_counts(found.controller)
            known = ", ".join(f"{count} {name.replace('_', ' ')}" for name, count in counts.items() if count)
            lacking = "; ".join(still_to_measure(found.controller)) or "nothing"
            st.caption(f"Values: {known}. Still to be measured or looked up: {lacking}.")
    places = st.columns([1, 1, 1, 1], vertical_alignment="bottom")
    for place, (attribute, label, values) in zip(places, _CHOICES, strict=False):
        key = editing.key(attribute)
        first = values.index(getattr(editing.draft.units, attribute))
        place.selectbox(label, values, first, key=key, on_change=_convert, args=(editing, attribute, key))
    places[3].button("Describe another one", on_click=_close, help="This one stays among the drafts.")
    if editing.unkept:
        st.caption(f"What you type is not kept beyond this page: {show.plain(editing.unkept)}")


def _convert(editing: Editing, attribute: str, key: str) -> None:
    units: dict[str, Any] = vars(editing.draft.units) | {attribute: st.session_state[key]}
    editing.put(editing.draft.in_units(Units(**units)))
    editing.anew()


def draw_faults(found: Checked) -> None:
    """Say what is missing or wrong, all at once, with table, row and column."""
    with st.container():
        if not found.faults:
            st.success("Nothing is missing or wrong.")
        else:
            many = len(found.faults)
            lines = [
                f"- **{fault.table}**{', ' if fault.where else ''}{show.plain(fault.where)}: {show.plain(fault.text)}"
                for fault in found.faults[:_SHOWN]
            ]
            more = [f"- … and {many - _SHOWN} more"] if many > _SHOWN else []
            with st.expander(
                f"{many} {'thing is' if many == 1 else 'things are'} missing or wrong", expanded=many <= 5
            ):
                st.markdown("\n".join([*lines, *more]))
        for note in found.notes:
            st.caption(show.plain(note))


def draw_learning(editing: Editing, step: str, found: Checked) -> None:
    """Learn mounting clearances from measuring sheets of new units, into the tables of lands."""
    if step != NEW_PARTS:
        return
    st.subheader("Mounting clearances from new parts")
    if found.controller is None:
        st.caption("Sheets can be read once nothing is missing or wrong: type a guess for clearances not known yet.")
        return
    tables = learn_form(found.data, key=editing.key("learn"))
    if tables is not None:
        editing.put(draft_of(tables, editing.draft.units))
        editing.anew()
        st.rerun()


# --- saving -------------------------------------------------------------------------------------------------------


def draw_saving(editing: Editing, found: Checked) -> None:
    """Offer to save it as an own file, to use it for the job, and to take it along."""
    text = written_toml(found.data)
    name = str(found.data.get("id", ""))
    known = own_files("controllers").get(name)
    there = "" if known is None else hashlib.sha256(known.read_bytes()).hexdigest()
    is_saved = there == hashlib.sha256(text.encode("utf-8")).hexdigest()
    replacing = False
    with st.container():
        if there and there != editing.over and not is_saved:
            label = f"Replace {name}.toml, which is in your catalogue already"
            replacing = st.checkbox(label, key=editing.key("replace"))
    with st.container(horizontal=True):
        st.button(
            "Save as own file",
            type="primary",
            disabled=found.controller is None or is_saved,
            on_click=_save,
            args=(editing, name, text, there if replacing else editing.over),
            help="Into your own catalogue, where every drop-down offers it. Comments of an earlier file are not kept.",
        )
        st.button(
            "Use it for this job",
            disabled=found.controller is None or not is_saved,
            on_click=pick,
            args=("controller", name),
            help="Chooses it as the valve body in the sidebar. Save it first.",
        )
        st.download_button("TOML file", text, f"{name or 'unnamed'}.toml", on_click="ignore")
        st.download_button(
            "Workbook",
            lambda: write_controller_workbook(found.data, editing.draft.units),
            f"{name or 'unnamed'}.xlsx",
            on_click="ignore",
            disabled=found.controller is None,
            help="The same tables as sheets, to be filled in elsewhere and read here again.",
        )
    with st.container():
        if refused := st.session_state.pop(editing.key("refused"), None):
            st.error(show.plain(refused))
        elif is_saved and known is not None:
            st.caption(f"Saved: {show.plain(known)}")
        elif found.controller is None:
            st.caption("It can be saved once nothing is missing or wrong. Until then it is kept as a draft.")


def _save(editing: Editing, name: str, text: str, over: str) -> None:
    try:
        path = write_own("controllers", name, text, over=over)
    except OutputError as error:
        st.session_state[editing.key("refused")] = str(error)
        return
    editing.over = hashlib.sha256(path.read_bytes()).hexdigest()
    forget_draft(editing.token)
    editing.own = name
