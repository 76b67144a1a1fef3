"""Keep an entry of the catalogue that is being typed: its draft over reloads, its faults, and its saving."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from functools import partial
from typing import Any

import streamlit as st

from atleak.catalogue.entries import own_files, read_tables
from atleak.catalogue.workbook.cells import CLEARANCES, LENGTHS, PRESSURES, Units
from atleak.catalogue.workbook.draft import Checked, Draft, Subject, checked, copy_of, draft_of, read_draft
from atleak.common.errors import OutputError
from atleak.common.files import draft_text, drafts, forget_draft, keep_draft, new_token
from atleak.common.wording import Wording
from pages.shared import entrance, fields, reader, show

_SHOWN = 15  # faults in one list
_UNITS = {"length": LENGTHS, "clearance": CLEARANCES, "pressure": PRESSURES}  # by attribute of `Units`


@dataclass
class Editing:
    """One entry being typed. Another ``generation`` gives fresh widgets."""

    draft: Draft
    state: str  # under which the session keeps it
    token: str = field(default_factory=new_token)  # under which the draft is kept
    seen: str | None = None  # the draft as it was read from there, or kept there last
    apart: bool = False  # another window changed that draft, so that this is one of its own
    widgets: str = field(default_factory=new_token)  # part of the keys of its widgets
    over: str = ""  # SHA-256 of the own file that it was read from or saved as
    own: str = ""  # id of that file
    generation: int = 0
    base: dict[str, list[dict[str, str]]] = field(default_factory=dict)  # rows that an editor began with, by its key
    spare: dict[str, int] = field(default_factory=dict)  # empty rows asked for, by table
    unkept: str = ""  # why the draft could not be kept

    def put(self, draft: Draft) -> None:
        """Take over what was typed, and keep it where a page that is loaded anew still has it.

        A draft that another window has changed since stays as that one left it, and this one becomes another.
        """
        if draft == self.draft:
            return
        self.draft = draft
        if not self._is_mine():
            self.token, self.apart = new_token(), True
        try:
            keep_draft(self.token, draft.written(), entrance.person())
            self.unkept, self.seen = "", draft.written()
        except OutputError as error:
            self.unkept = error.sentence

    def _is_mine(self) -> bool:
        return draft_text(self.token, entrance.person()) in (None, self.seen)

    def saved_as(self, name: str, sha256: str) -> None:
        """Forget the draft, as the own file of this id holds it, unless another window has changed it since."""
        self.own, self.over = name, sha256
        if self._is_mine():
            forget_draft(self.token, entrance.person())

    def anew(self) -> None:
        """Draw every field and table anew from the draft."""
        self.generation += 1
        self.base.clear()
        self.spare.clear()

    def key(self, name: str) -> str:
        """Return the key of a widget."""
        return f"{self.state}-{self.widgets}-{self.generation}-{name}"


@dataclass(frozen=True)
class Desk:
    """Where entries of one kind are typed: one at a time in each session."""

    subject: Subject
    state: str
    units: tuple[str, ...] = ()  # that numbers are typed in, by attribute of `Units`
    workbook: Callable[[bytes, str], Draft] | None = None  # reads an uploaded workbook

    def current(self) -> Editing | None:
        """Return what is being typed in this session or, after the page was loaded anew, before it."""
        editing = self._held()
        if editing is None:
            if token := st.query_params.get("draft"):
                self.go_on(token)
            if self._held() is None and (name := st.query_params.get("own")) in own_files(self.subject.kind):
                self.start(name)
            editing = self._held()
        if editing is not None:
            st.query_params["draft"] = editing.token
            if editing.own:
                st.query_params["own"] = editing.own
        return editing

    def _held(self) -> Editing | None:
        held: Editing | None = st.session_state.get(self.state)
        return held if held is not None and held.draft.subject is self.subject else None

    def take(self, draft: Draft, **more: Any) -> None:
        """Begin to type a draft."""
        st.session_state[self.state] = Editing(draft, self.state, **more)

    def start(self, name: str | None) -> None:
        """Begin with a copy of a shipped entry, with an own one itself, or with nothing."""
        if name is None:
            self.take(Draft(self.subject))
            return
        data, origin = read_tables(self.subject.kind, name)
        if origin.own:
            self.take(draft_of(self.subject, data), over=origin.sha256, own=name)
        else:
            self.take(draft_of(self.subject, copy_of(data)))

    def kept(self) -> dict[str, str]:
        """Return the drafts of this kind that were kept, by token, each with its name and time."""
        labels = {}
        for token, path in drafts(entrance.person()).items():
            draft = read_draft(self.subject, draft_text(token, entrance.person()) or "")
            if draft is not None:
                name = draft.cell(self.subject.sheets[0].name, "Name") or "–"
                labels[token] = f"{name}, {datetime.fromtimestamp(path.stat().st_mtime):%Y-%m-%d %H:%M}"
        return labels

    def go_on(self, token: str) -> None:
        """Go on with a draft that was kept."""
        text = draft_text(token, entrance.person())
        draft = read_draft(self.subject, text or "")
        if draft is not None:
            self.take(draft, token=token, seen=text)

    def throw_away(self, token: str) -> None:
        """Delete a draft."""
        forget_draft(token, entrance.person())
        if (editing := self._held()) is not None and editing.token == token:
            self.close()

    def close(self) -> None:
        """Put what is being typed aside; it stays among the drafts."""
        st.session_state.pop(self.state, None)
        for name in ("draft", "own"):
            st.query_params.pop(name, None)


# --- what is typed ------------------------------------------------------------------------------------------------


def ask_step(editing: Editing, steps: Sequence[str], said: Callable[[str], str], say: Wording) -> str:
    """Ask which tables to show; they stay chosen over other pages."""
    return st.segmented_control(
        say("typed_entries.tables"), steps, format_func=said, default=steps[0], required=True,
        key=f"{editing.state}-{editing.widgets}-step", persist_state="session", label_visibility="collapsed",
    )  # fmt: skip


def checked_now(editing: Editing) -> Checked:
    """Return what the draft describes and what is wrong with it; checked once for each state of the draft."""
    return _checked(editing.draft.written(), editing.draft)


@st.cache_resource(max_entries=16, show_spinner=False)
def _checked(key: str, _draft: Draft) -> Checked:
    return checked(_draft)


def ask_unit(editing: Editing, attribute: str, label: str, place: Any) -> None:
    """Ask in which unit numbers are typed; another one converts them."""

    def convert(unit: str) -> None:
        units: dict[str, Any] = vars(editing.draft.units) | {attribute: unit}
        editing.put(editing.draft.in_units(Units(**units)))
        editing.anew()

    current, said = getattr(editing.draft.units, attribute), partial(reader.say().get, "typed_units")
    fields.choice(label, _UNITS[attribute], current, convert, said, key=editing.key(attribute), place=place)


def draw_faults(editing: Editing, found: Checked, say: Wording) -> None:
    """Say what is missing, wrong or in doubt, all at once, with table, row and column."""
    lines = [_line(editing, "✗", each, say) for each in found.faults]
    lines += [_line(editing, "?", each, say) for each in found.doubts]
    with st.container():
        if not lines:
            st.success(say("typed_entries.nothing_wrong"))
        else:
            more = [say("typed_entries.and_more", number=len(lines) - _SHOWN)] if len(lines) > _SHOWN else []
            head = say("typed_entries.faults", number=len(found.faults), doubts=len(found.doubts))
            with st.expander(head, expanded=len(lines) <= 5):
                st.markdown("\n".join(f"- {line}" for line in [*lines[:_SHOWN], *more]))
        for note in found.notes:
            st.caption(show.plain(note))
        if editing.apart:
            st.warning(say("typed_entries.apart"))
        if editing.unkept:
            st.caption(show.plain(say("typed_entries.unkept", why=editing.unkept)))


def _line(editing: Editing, sign: str, fault: Any, say: Wording) -> str:
    table, number, heading = fault.spot
    row = "" if number is None else f", {say('typed_entries.in_row', number=number)}"
    column = "" if heading is None else f", {say.name(heading, 'form')}"
    return f"{sign} **{say.name(table, 'form')}**{show.plain(row + column)}: {show.plain(fault.text)}"
