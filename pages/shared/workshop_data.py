"""Start, name, save, use, rename and delete an own entry of the catalogue: Workshop data and Transmission."""

from __future__ import annotations

import hashlib
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import streamlit as st

from atleak.catalogue.castings import keep_casting, sound_casting
from atleak.catalogue.entries import own_files, remove_own, removed_own, restore_own, write_own
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.workbook.draft import Checked, draft_of
from atleak.catalogue.workbook.subjects import SUBJECTS
from atleak.common.errors import AtleakError, CatalogueError, text_reason
from atleak.common.wording import Wording
from atleak.job.case import SLOTS, Slot, SourceFile
from atleak.report.charts.condition_figures import viscosity_curve
from pages.shared import address, entry_tables, fields, font_form, show
from pages.shared.cases import catalogue_list, shown_name
from pages.shared.editing import Desk, Editing, ask_step, ask_unit, checked_now, draw_faults
from pages.shared.state import pick, session

_UNITS = {"limits": ("length", "pressure"), "instruments": ("length",), "fluids": ()}
DESKS = {kind: Desk(subject, f"workshop-data-{kind}", _UNITS[kind]) for kind, subject in SUBJECTS.items()}
_DONE = "workshop-data-done"


@dataclass(frozen=True)
class Done:
    """What was done with an own file last, and can be undone: it was deleted, or renamed."""

    kind: str
    gone: str  # id of the file that was taken away
    now: str = ""  # its id after it was renamed


def draw(say: Wording) -> None:
    """Edit limits, instruments and fluids in forms and tables, and save them as the user's own."""
    st.write(say("workshop_data.what"))
    kinds = {kind: say(f"workshop_data.{kind}") for kind in DESKS}
    desk = DESKS[fields.part("kind", kinds, left=_forget_address)]
    editing = desk.current()
    draw_undo(desk, say)
    if editing is None:
        choose_start(desk, say)
        font_form.draw(say)
        return
    checked = checked_now(editing)
    draw_head(desk, editing, checked, say)
    signs = {each.spot.sheet: " ?" for each in checked.doubts} | {each.spot.sheet: " ✗" for each in checked.faults}
    steps = [sheet.name for sheet in editing.draft.subject.sheets]
    step = ask_step(editing, steps, lambda step: say.name(step, "form") + signs.get(step, ""), say)
    draw_faults(editing, checked, say)
    entry_tables.draw(editing, [step], checked)
    if isinstance(checked.entry, Fluid):
        st.header(say("workshop_data.curve"))
        try:
            show.chart(viscosity_curve(checked.entry, say), "workshop-data-viscosity")
        except AtleakError as error:
            st.caption(show.plain(error))
    st.header(say("workshop_data.keep"))
    draw_saving(desk, editing, checked, say)


def go_on_with(kind: str, data: Mapping[str, Any]) -> None:
    """Begin to type an entry of a kind with what is known of it, and show it; for a callback."""
    DESKS[kind].take(draft_of(DESKS[kind].subject, data))
    address.keep("kind", kind, of_job=False)
    address.keep("library", "workshop_data", of_job=False)


def _forget_address() -> None:
    """Take the entry of another kind out of the address."""
    for name in ("draft", "own"):
        st.query_params.pop(name, None)


def _slots(desk: Desk) -> list[Slot]:
    return [slot for slot in SLOTS.values() if slot.folder == desk.subject.kind]


# --- the start ----------------------------------------------------------------------------------------------------


def choose_start(desk: Desk, say: Wording) -> None:
    """Ask from what to start, and show what of this kind is the user's own."""
    known = catalogue_list(_slots(desk)[0].name)
    names = {entry.id: shown_name(entry, say) for entry in known.entries.values()}
    options, in_job = {**names, "": say("typed_entries.empty")}, getattr(session().case, _slots(desk)[0].name)
    left, right = st.columns(2)
    with left, st.container(border=True):
        label, tip = say("typed_entries.start_from"), say("typed_entries.start_help")
        start = fields.one_of(label, options, f"{desk.state}-start", in_job, help=tip)
        st.button(say("typed_entries.start"), type="primary", on_click=desk.start, args=(start or None,))
        _draw_upload(desk, say)
    with right, st.container(border=True):
        _draw_kept(desk, say)
    st.header(say("workshop_data.own"))
    own = own_files(desk.subject.kind)
    if not own:
        st.caption(say("workshop_data.none_own"))
    for name in own:
        with st.container(horizontal=True, vertical_alignment="center"):
            st.markdown(show.plain(names.get(name, name)), width="stretch")
            key = f"{desk.state}-{name}"
            usable = name in names
            st.button(
                say("workshop_data.edit"), key=f"{key}-edit", disabled=not usable, on_click=desk.start, args=(name,)
            )
            st.button(say("workshop_data.delete"), key=f"{key}-delete", on_click=_delete, args=(desk, name))
    for fault in known.faults:
        st.error(show.plain(fault))
    back = [name for name in removed_own(desk.subject.kind) if name not in own]
    with st.container(horizontal=True):
        for name in back:
            label = show.plain(say("workshop_data.bring_back", name=name))
            st.button(label, key=f"{desk.state}-{name}-back", on_click=_restore, args=(desk.subject.kind, name))


def _draw_upload(desk: Desk, say: Wording) -> None:
    """Offer to read a file, which is then typed on."""
    label, kinds = say("typed_entries.read"), ["toml"]
    if desk.workbook is not None:
        label, kinds = say("typed_entries.read_workbook"), ["xlsx", "toml"]
    upload = st.file_uploader(label, kinds, key=f"{desk.state}-file")
    if upload is None:
        return
    name, content = upload.name, upload.getvalue()
    try:
        if desk.workbook is not None and content.startswith(b"PK"):
            draft = desk.workbook(content, name)
        else:
            data = tomllib.loads(content.decode("utf-8-sig"))
            desk.subject.shelf.checked(data, name)
            draft = draft_of(desk.subject, data)
    except (CatalogueError, ValueError, RecursionError) as error:
        why = error if isinstance(error, CatalogueError) else text_reason(error)
        st.error(f"**{show.plain(say('typed_entries.not_taken', file=name))}** {show.plain(why)}")
        return
    desk.take(draft)
    st.rerun()


def _draw_kept(desk: Desk, say: Wording) -> None:
    """Offer to go on with a draft, or to throw it away."""
    kept = desk.kept()
    token = fields.one_of(
        say("typed_entries.go_on_with"), kept, f"{desk.state}-draft", disabled=not kept,
        placeholder=say("typed_entries.none_kept"), help=say("typed_entries.drafts_help"),
    )  # fmt: skip
    with st.container(horizontal=True):
        st.button(say("typed_entries.go_on"), disabled=not kept, on_click=desk.go_on, args=(token,))
        st.button(say("typed_entries.throw_away"), disabled=not kept, on_click=desk.throw_away, args=(token,))


# --- delete, rename, undo -----------------------------------------------------------------------------------------


def _delete(desk: Desk, name: str) -> None:
    """Take an own file away; a job that uses it goes on with what it holds."""
    file = SourceFile.at(own_files(desk.subject.kind)[name])
    content = file.content
    if show.tried(_DONE, remove_own, desk.subject.kind, name):
        for slot in _used_by(desk, name):
            pick(slot.name, SourceFile(file.name, content))
        st.session_state[_DONE] = Done(desk.subject.kind, name)


def _used_by(desk: Desk, name: str) -> list[Slot]:
    return [slot for slot in _slots(desk) if getattr(session().case, slot.name) == name]


def _renamed(desk: Desk, old: str, name: str) -> None:
    """Take the file of the former name away, and let the job use the new one."""
    used = _used_by(desk, old)
    if desk.subject.kind == "controllers" and (casting := sound_casting(old)):
        keep_casting(name, casting)
    if show.tried(_DONE, remove_own, desk.subject.kind, old):
        for slot in used:
            pick(slot.name, name)
        st.session_state[_DONE] = Done(desk.subject.kind, old, name)


def _restore(kind: str, name: str) -> None:
    if show.tried(_DONE, restore_own, kind, name):
        st.session_state.pop(_DONE, None)


def _undo(desk: Desk, done: Done) -> None:
    """Bring the file back; where it was renamed, the one of the new name goes."""
    used = _used_by(desk, done.now) if done.now else []
    if not show.tried(_DONE, restore_own, done.kind, done.gone):
        return
    st.session_state.pop(_DONE, None)
    for slot in used:
        pick(slot.name, done.gone)
    if done.now:
        show.tried(_DONE, remove_own, done.kind, done.now)
        desk.close()


def draw_undo(desk: Desk, say: Wording) -> None:
    """Say what was deleted or renamed last, and offer to undo it."""
    done: Done | None = st.session_state.get(_DONE)
    with st.container():
        show.refused(_DONE)
        if done is not None and done.kind == desk.subject.kind:
            key = "workshop_data.renamed" if done.now else "workshop_data.deleted"
            with st.container(horizontal=True, vertical_alignment="center"):
                st.markdown(show.plain(say(key, old=done.gone, name=done.now or done.gone)), width="stretch")
                st.button(say("workshop_data.undo"), key=f"{_DONE}-undo", on_click=_undo, args=(desk, done))


# --- what is being typed ------------------------------------------------------------------------------------------


def draw_head(desk: Desk, editing: Editing, found: Checked, say: Wording, counts: str = "") -> None:
    """Show what is edited, with what is ``told`` of it, and ask in which units its numbers are typed."""
    name = found.data.get("name") or say("typed_entries.nameless")
    st.markdown(f"**{show.plain(name)}** · {say('typed_entries.id')} `{found.data.get('id', '–')}`")
    with st.container():
        if counts:
            st.caption(show.plain(counts))
    *places, last = st.columns(len(desk.units) + 1, vertical_alignment="bottom")
    for attribute, place in zip(desk.units, places, strict=True):
        ask_unit(editing, attribute, say(f"typed_entries.in_{attribute}"), place)
    last.button(say("typed_entries.another"), on_click=desk.close, help=say("typed_entries.another_help"))


# --- saving -------------------------------------------------------------------------------------------------------


def draw_saving(
    desk: Desk, editing: Editing, found: Checked, say: Wording, more: Callable[[str], None] | None = None
) -> None:
    """Offer to save it as an own file, to use it for the job, and to take it along; ``more`` is given its id."""
    kind = desk.subject.kind
    name, text = str(found.data.get("id", "")), desk.subject.toml(found.data)
    path = own_files(kind).get(name)
    there = "" if path is None else _sha256(path.read_bytes())
    complete, saved = found.entry is not None, there == _sha256(text.encode("utf-8"))
    over = "" if editing.own not in ("", name) else editing.over
    with st.container():
        if there and there != editing.over and not saved:
            label = show.plain(say("typed_entries.replace", file=f"{name}.toml"))
            over = there if st.checkbox(label, key=editing.key("replace")) else over
    old, renaming = editing.own, False
    with st.container():
        if old and name != old and old in own_files(kind) and complete:
            label = show.plain(say("workshop_data.rename", old=old, name=name))
            renaming = st.checkbox(label, key=editing.key("rename"))
    with st.container(horizontal=True):
        st.button(
            say("typed_entries.save"),
            type="primary",
            disabled=not complete or saved,
            on_click=_save,
            args=(editing, name, text, over, partial(_renamed, desk, old) if renaming else None),
            help=say("typed_entries.save_help"),
        )
        _draw_uses(desk, editing, found, name, say, usable=complete and saved)
        st.download_button(say("typed_entries.toml"), text, f"{name or 'unnamed'}.toml", on_click="ignore")
        if more is not None:
            more(name or "unnamed")
    with st.container():
        if saved and _used_by(desk, name):
            st.caption(say("workshop_data.used"))
        if show.refused(editing.state):
            return
        if saved:
            st.caption(show.plain(say("typed_entries.saved", path=path)))
        elif not complete:
            st.caption(say("typed_entries.not_yet"))


def _draw_uses(desk: Desk, editing: Editing, found: Checked, name: str, say: Wording, *, usable: bool) -> None:
    """Offer to take it for each part of the job that it may be taken for."""
    for slot in _slots(desk):
        if slot.part is None or slot.part in getattr(found.entry, "measures", (slot.part,)):
            st.button(
                say("typed_entries.use" if slot.part is None else f"workshop_data.use_{slot.part}"),
                disabled=not usable,
                on_click=pick,
                args=(slot.name, name),
                help=say("typed_entries.use_help"),
                key=editing.key(f"use-{slot.name}"),
            )


def _save(editing: Editing, name: str, text: str, over: str, then: Callable[[str], None] | None) -> None:
    with show.refusing(editing.state):
        path: Path = write_own(editing.draft.subject.kind, name, text, over=over)
        editing.saved_as(name, _sha256(path.read_bytes()))
        if then is not None:
            then(name)


def _sha256(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()
