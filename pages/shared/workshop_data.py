"""Start, name, save, use, rename and delete an entry of the user's own catalogue on the page Workshop data."""

from __future__ import annotations

from dataclasses import dataclass

import streamlit as st

from atleak.catalogue.entries import own_files, remove_own, removed_own, restore_own
from atleak.catalogue.fluid import Fluid
from atleak.errors import AtleakError, OutputError
from atleak.figures.fluid_figures import viscosity_curve
from atleak.job.case import SLOTS, Slot, SourceFile
from atleak.views.entry_form import Checked
from atleak.views.workshop_data import SUBJECTS
from atleak.wording import Wording
from pages.shared import show
from pages.shared.cases import catalogue_list, shown_name
from pages.shared.editing import (
    Desk,
    Editing,
    ask_replacing,
    ask_step,
    ask_unit,
    draw_kept,
    draw_save_button,
    draw_saved,
    draw_toml,
    draw_upload,
    draw_use,
    saving_of,
)
from pages.shared.state import pick, session

DESKS = {kind: Desk(subject, f"workshop-data-{kind}", "workshop_fields") for kind, subject in SUBJECTS.items()}
_KIND = "workshop-data-kind"
_DONE = "workshop-data-done"


@dataclass(frozen=True)
class Done:
    """What was done with an own file last, and can be undone: it was deleted, or renamed."""

    kind: str
    gone: str  # id of the file that was taken away
    now: str = ""  # its id after it was renamed


def choose_kind(say: Wording) -> Desk:
    """Ask what to edit; it stays chosen over other pages, and in the address."""
    first = st.session_state.get(_KIND) or st.query_params.get("kind")
    kinds = list(DESKS)
    first = first if first in kinds else kinds[0]
    picked = st.segmented_control(
        say("workshop_data.kind"), kinds, default=first, format_func=lambda kind: say(f"workshop_data.{kind}"),
        key=f"{_KIND}-widget", label_visibility="collapsed", on_change=_forget_address,
    )  # fmt: skip
    kind = picked or first
    st.session_state[_KIND] = st.query_params["kind"] = kind
    return DESKS[kind]


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
    options, in_job = [*names, ""], getattr(session().case, _slots(desk)[0].name)
    left, right = st.columns(2)
    with left, st.container(border=True):
        start = st.selectbox(
            say("workshop_data.start_from"),
            options,
            options.index(in_job) if in_job in options else 0,
            format_func=lambda name: names.get(name) or say("workshop_data.empty"),
            help=say("workshop_data.start_help"),
            key=f"{desk.state}-start",
        )
        st.button(say("workshop_data.start"), type="primary", on_click=desk.start, args=(start or None,))
        draw_upload(desk, say("workshop_data.read"), ["toml"], say)
    with right, st.container(border=True):
        draw_kept(desk, say)
    st.subheader(say("workshop_data.own"))
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


# --- delete, rename, undo -----------------------------------------------------------------------------------------


def _delete(desk: Desk, name: str) -> None:
    """Take an own file away; a job that uses it goes on with what it holds."""
    file = SourceFile.at(own_files(desk.subject.kind)[name])
    content = file.content
    if _tried(remove_own, desk.subject.kind, name):
        for slot in _used_by(desk, name):
            pick(slot.name, SourceFile(file.name, content))
        st.session_state[_DONE] = Done(desk.subject.kind, name)


def _used_by(desk: Desk, name: str) -> list[Slot]:
    return [slot for slot in _slots(desk) if getattr(session().case, slot.name) == name]


def _renamed(desk: Desk, old: str, name: str) -> None:
    """Take the file of the former name away, and let the job use the new one."""
    used = _used_by(desk, old)
    if _tried(remove_own, desk.subject.kind, old):
        for slot in used:
            pick(slot.name, name)
        st.session_state[_DONE] = Done(desk.subject.kind, old, name)


def _restore(kind: str, name: str) -> None:
    if _tried(restore_own, kind, name):
        st.session_state.pop(_DONE, None)


def _undo(desk: Desk, done: Done) -> None:
    """Bring the file back; where it was renamed, the one of the new name goes."""
    used = _used_by(desk, done.now) if done.now else []
    if not _tried(restore_own, done.kind, done.gone):
        return
    st.session_state.pop(_DONE, None)
    for slot in used:
        pick(slot.name, done.gone)
    if done.now:
        _tried(remove_own, done.kind, done.now)
        desk.close()


def _tried(act: object, kind: str, name: str) -> bool:
    """Do something with an own file; where that fails, keep why."""
    try:
        act(kind, name)  # type: ignore[operator]
    except OutputError as error:
        st.session_state[f"{_DONE}-refused"] = error.sentence
        return False
    return True


def draw_undo(desk: Desk, say: Wording) -> None:
    """Say what was deleted or renamed last, and offer to undo it."""
    done: Done | None = st.session_state.get(_DONE)
    with st.container():
        if refused := st.session_state.pop(f"{_DONE}-refused", None):
            st.error(show.plain(refused))
        if done is not None and done.kind == desk.subject.kind:
            key = "workshop_data.renamed" if done.now else "workshop_data.deleted"
            with st.container(horizontal=True, vertical_alignment="center"):
                st.markdown(show.plain(say(key, old=done.gone, name=done.now or done.gone)), width="stretch")
                st.button(say("workshop_data.undo"), key=f"{_DONE}-undo", on_click=_undo, args=(desk, done))


# --- what is being typed ------------------------------------------------------------------------------------------


def draw_head(desk: Desk, editing: Editing, found: Checked, say: Wording) -> None:
    """Show what is edited, and ask in which units its numbers are typed."""
    name = found.data.get("name") or say("workshop_data.nameless")
    st.markdown(f"**{show.plain(name)}** · id `{found.data.get('id', '–')}`")
    places = iter(st.columns(3, vertical_alignment="bottom"))
    if desk.subject.kind != "fluids":  # of which nothing is a length or a pressure
        ask_unit(editing, "length", say("workshop_data.lengths"), next(places))
    if desk.subject.kind == "limits":
        ask_unit(editing, "pressure", say("workshop_data.pressures"), next(places))
    next(places).button(say("workshop_data.another"), on_click=desk.close, help=say("workshop_data.another_help"))


def choose_step(editing: Editing, found: Checked, say: Wording) -> str:
    """Ask which form or table to show, each with a sign where something is wrong or in doubt in it."""
    signs = {doubt.spot.sheet: " ?" for doubt in found.doubts} | {fault.spot.sheet: " ✗" for fault in found.faults}
    steps = [sheet.name for sheet in editing.draft.subject.sheets]
    return ask_step(editing, steps, lambda step: editing.said(step, say) + signs.get(step, ""), say)


def draw_curve(found: Checked, say: Wording) -> None:
    """Draw the viscosity of a fluid that is described well enough."""
    if isinstance(found.entry, Fluid):
        st.subheader(say("workshop_data.curve"))
        try:
            show.chart(viscosity_curve(found.entry, say), "workshop-data-viscosity")
        except AtleakError as error:
            st.caption(show.plain(error))


def draw_saving(desk: Desk, editing: Editing, found: Checked, say: Wording) -> None:
    """Offer to save it as an own file, to use it for the job, and to take it along."""
    saving = saving_of(editing, found)
    over = ask_replacing(editing, saving, say)
    old, renaming = editing.own, False
    with st.container():
        if old and saving.name != old and old in own_files(desk.subject.kind) and found.entry is not None:
            label = show.plain(say("workshop_data.rename", old=old, name=saving.name))
            renaming = st.checkbox(label, key=editing.key("rename"))
    with st.container(horizontal=True):
        over = "" if over == editing.over and saving.name != old else over
        then = (lambda name: _renamed(desk, old, name)) if renaming else None
        draw_save_button(editing, found, saving, over, say, then)
        for slot in _slots(desk):
            if slot.part is None or slot.part in getattr(found.entry, "measures", (slot.part,)):
                label = say("typed_entries.use" if slot.part is None else f"workshop_data.use_{slot.part}")
                draw_use(editing, found, saving, slot.name, label, say)
        draw_toml(saving, say)
    with st.container():
        if saving.saved and _used_by(desk, saving.name):
            st.caption(say("workshop_data.used"))
    draw_saved(editing, found, saving, say)
