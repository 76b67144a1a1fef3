"""Show the grid into which readings are typed. What is typed is the job's measuring sheet, sign for sign."""

from __future__ import annotations

import secrets
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import streamlit as st

from atleak.common.errors import AtleakError
from atleak.common.memory import kept_with
from atleak.common.units import unit_names
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.evidence import quick_pass
from atleak.job.case import SourceFile
from atleak.measurements.measuring_plan import MOST_DIRECTIONS, MOST_REPEATS, Order, Plan
from atleak.readers.gauges.typed_values import TYPED_GAUGES_FILE as TYPED_GAUGES
from atleak.readers.gauges.typed_values import TypedGauges
from atleak.readers.typed_sheet import TYPED_FILE, JudgedEntry, Typed, judge, typed_in, written_sheet
from atleak.report.measuring_grid import Grid, grid_record
from atleak.report.tables.evidence import next_sentence
from atleak.report.tables.names import land_words
from pages.shared import book, fields, reader, show
from pages.shared.cases import PageCase, controller_of, diagnosis_of, instruments_of, readings_of
from pages.shared.state import new_job, put_file, remember, session

_GRID = show.component("measuring")
_WORDS = (
    *("hint", "back", "next", "undo", "repeat", "kept", "under_way", "doubtful", "counts_not"),
    *("land", "clearance", "wear", "ovality", "verdict", "bench", "sheet", "last", "open"),
)
_TYPED_UNITS = ("mm", "µm", "inch")
_UNITS = {"metric": "mm", "metric_bar": "mm", "us": "inch"}  # typed in, unless another is chosen


@dataclass
class _Kept:
    """What a session keeps of the grid: the entries of one sheet, by job, valve body and file, and the last answer.

    The entries and their answer change together, in plain attributes: a script that is stopped for a newer one can stop
    wherever the session's state is asked, and must not have answered what it has not done.
    """

    name: tuple[int, str, str | None] | None = None
    typed: Typed = Typed()  # noqa: RUF009  frozen, so safe to share
    answer: dict[str, Any] | None = None
    quick: tuple[str, Plan | None] = ("", None)  # the quick pass last offered, and of what
    fresh: bool = False  # nothing typed, nothing chosen: the quick pass is asked for, as it is by now
    session: str = field(default_factory=partial(secrets.token_hex, 6))  # by which the browser tells sessions apart


def draw(case: PageCase, diagnosis: Diagnosis) -> Plan | None:
    """Draw the choices of what is measured, and the grid; the sample's can only be looked at.

    Return the plan where it is that of a quick pass.
    """
    say, typed = reader.say(), _typed(case)
    if case.sample:
        with st.container(horizontal=True, vertical_alignment="center"):
            st.info(say("measuring.sample"))
            st.button(say("measuring.begin"), on_click=new_job, key="measuring-begin")
    with st.container():  # one element whatever is asked: the grid below keeps its place
        typed = _how_much(typed, diagnosis)
    _choices(typed, diagnosis)
    key = f"measuring-{session().generation}"
    grid = Grid(typed.plan.cells(diagnosis.controller, typed.entries), typed, _judged(typed, case), diagnosis)
    words = {name: say(f"measuring.{'land_head' if name == 'land' else name}") for name in _WORDS}
    if session().in_book.conflict is not None and book.unsaved():
        words["kept"] = say("measuring.not_saved")
    data = {
        **grid_record(grid, say, dark=show.dark()),
        "words": words,
        "readonly": case.sample,
        "job": book.job_id(),
        "owner": f"{_kept().session}-{session().generation}",
        "answer": _kept().answer,
    }
    _GRID(key=key, data=data, on_batch_change=lambda: _take(key))
    if typed.plan.order is not Order.QUICK:
        return None
    if grid.counting and all(grid.counting[key] in (0, asked) for key, asked in grid.asked.items()):
        st.info(show.plain(next_sentence(diagnosis, say)))
    return typed.plan


def _how_much(typed: Typed, diagnosis: Diagnosis) -> Typed:
    """Ask whether the few lands that tell most are measured or all; those few stay until somebody chooses anew.

    Return what is typed, by the plan that is asked for: that of the quick pass for a sheet that nobody has begun.
    """
    say, controller, kept = reader.say(), diagnosis.controller, _kept()
    key = f"pass{session().generation}-{controller.sha256[:12]}"
    if kept.fresh or not (typed.entries or typed.plan.order is Order.QUICK):
        kept.quick = key, kept_with(diagnosis, "quick pass", "", lambda: quick_pass(diagnosis), most=1)
        if kept.fresh:
            typed = kept.typed = replace(typed, plan=kept.quick[1] or Plan())
    elif typed.plan.order is Order.QUICK:
        kept.quick = key, typed.plan
    plan, (of, quick) = typed.plan, kept.quick
    if of == key and quick is None:
        return typed

    def label(name: str) -> str:
        asked = quick if name == "quick" and of == key else Plan() if name == "whole" else None
        if asked is None:
            return say("measuring.quick_pass")
        counts = {"lands": len(asked.lands or controller.lands), "readings": len(asked.cells(controller))}
        return say(f"measuring.{name}_counted", **counts)

    def chosen() -> None:
        now, picked = _typed(session().case), st.session_state[key]
        if picked == "whole" and now.plan.order is Order.QUICK:
            _choose(replace(now, plan=Plan()))
        elif picked == "quick" and now.plan.order is not Order.QUICK:
            found = quick_pass(diagnosis)
            if found is None:
                st.toast(say("likely.enough"))
            else:
                _choose(replace(now, plan=found))

    st.session_state[key] = "quick" if plan.order is Order.QUICK else "whole"
    st.segmented_control(
        say("measuring.how_much"),
        ["quick", "whole"],
        format_func=label,
        key=key,
        on_change=chosen,
        help=say("measuring.quick_help"),
    )
    return typed


def _take(key: str) -> None:
    """Take what was typed, each step once, and answer; for the grid's callback."""
    batch = st.session_state[key]["batch"]
    last = _kept().answer or {}
    done_before = last["number"] if last.get("page") == batch["page"] else 0
    steps = [step for step in batch["steps"] if step["number"] > done_before]
    case = session().case
    if not steps or case.sample:
        return  # sent once more, before the answer arrived
    controller = diagnosis_of(session().good).controller
    if controller_of(case).sha256 != controller.sha256:
        return  # another valve body is being chosen: what is not answered is sent again
    typed = _typed(case)
    asked = {cell.key for cell in typed.plan.cells(controller)}
    if _kept().fresh and any(tuple(step["cell"]) not in asked for step in steps if step["do"] != "undo"):
        typed = replace(typed, plan=Plan())  # typed into the whole sheet, before the page was loaded anew
    done = typed.after(steps, typed.plan.cells(controller, typed.entries))
    at = None if done.at is None else list(done.at.key)
    _put(done.typed, {"page": batch["page"], "number": steps[-1]["number"], "at": at})
    if done.left_over:
        st.toast(reader.say()("measuring.left_over", count=done.left_over))


def _choices(typed: Typed, diagnosis: Diagnosis) -> None:
    """Ask what is measured, in which order, and in which unit it is typed."""
    say, controller, plan = reader.say(), diagnosis.controller, typed.plan
    owner = f"plan{session().generation}-{controller.sha256[:12]}"

    def take(name: str, picked: Any) -> None:
        now = _typed(session().case)
        _choose(replace(now, plan=replace(now.plan, **{name: picked})))

    def ask(place: Any, name: str, options: list[Any], shown: Any = str) -> None:
        label, current = say(f"measuring.{name}"), getattr(plan, name)
        fields.choice(label, options, current, partial(take, name), shown, key=f"{owner}-{name}", place=place)

    with fields.fold(say("measuring.choices"), key=f"{owner}-fold"):
        places = st.columns(4)
        orders = [order for order in Order if order is not Order.QUICK or plan.order is order]
        ask(places[0], "order", orders, lambda order: say(f"measuring.order_{order}"))
        ask(places[1], "directions", list(range(1, MOST_DIRECTIONS + 1)))
        ask(places[2], "repeats", list(range(1, MOST_REPEATS + 1)))
        units = [name for name in unit_names("length") if name in _TYPED_UNITS]
        fields.choice(
            say("measuring.unit"), units, typed.unit, lambda unit: _choose(_typed(session().case).in_unit(unit)),
            key=f"{owner}-unit", place=places[3],
        )  # fmt: skip
        most = max(len(land.planes) for land in controller.lands)
        if most > 1:
            ask(
                st,
                "planes",
                [None, *range(1, most)],
                lambda count: say("measuring.all") if count is None else str(count),
            )
        st.multiselect(
            say("measuring.lands"),
            [land.key for land in controller.lands],
            [*plan.lands],
            lambda key: land_words(controller, key, say),
            key=f"{owner}-lands",
            on_change=lambda: take("lands", tuple(st.session_state[f"{owner}-lands"])),
            placeholder=say("measuring.all"),
        )


def _choose(typed: Typed) -> None:
    """Put another choice into the job.

    A browser can send the choices of a tab that has just been left once more, as if somebody had made them anew: then
    nothing changes, and the job's sheet stays the file that it is.
    """
    if typed != _typed(session().case):
        _put(typed)


def _judged(typed: Typed, case: PageCase) -> JudgedEntry:
    diagnosis = diagnosis_of(session().good)
    return judge(typed, diagnosis.controller, temperature=case.measuring_temperature, instruments=instruments_of(case))


def _typed(case: PageCase) -> Typed:
    """Return what was typed so far: of the job's sheet, or before it holds anything."""
    file = _file(case)
    name = _name(case, file)
    kept = _kept()
    if kept.name != name:
        kept.name, kept.typed, kept.fresh = name, _opened(case, file), file is None
    return kept.typed


def _kept() -> _Kept:
    kept: _Kept = st.session_state.setdefault("measuring", _Kept())
    return kept


def _name(case: PageCase, file: SourceFile | None) -> tuple[int, str, str | None]:
    """Return what tells the entries of one sheet from others: the job, its valve body, the sheet."""
    return session().generation, controller_of(case).sha256, None if file is None else file.sha256


def _file(case: PageCase) -> SourceFile | None:
    """Return the job's sheet, or the typed one where that was refused: nothing typed is lost by it."""
    refused = session().refused.get("readings")
    typed = refused is not None and refused.file is not None and refused.file.name == TYPED_FILE
    return refused.file if refused is not None and typed else case.readings


def _opened(case: PageCase, file: SourceFile | None) -> Typed:
    """Return what a job's sheet holds as typed entries; none where it cannot be read."""
    fresh = Typed(unit=_UNITS[reader.say().units])
    if file is None:
        return fresh
    try:
        sheet = readings_of(case, file)
    except AtleakError:
        return fresh
    try:
        typed = typed_in(file.content, sheet, controller_of(case))
    except AtleakError:
        typed = None
    return typed or Typed.going_on_from(sheet, decimal=reader.say().decimal)


def _put(typed: Typed, answer: dict[str, Any] | None = None) -> None:
    """Put what was typed into the job: as its measuring sheet, in place of the one that it goes on from."""
    case, kept = session().case, _kept()
    before = _file(case)
    content = written_sheet(typed, _judged(typed, case).counting, controller_of(case))
    file = None if content is None else SourceFile(TYPED_FILE, content)
    if before is not None and before.name != TYPED_FILE:
        gone_on_from = before.name
        remember(lambda say: say("done.typed_on", name=gone_on_from))
        gauges = None if typed.sheet is None else typed.sheet.pressures
        if gauges is not None and case.pressures is None:
            put_file("pressures", SourceFile(TYPED_GAUGES, TypedGauges.going_on_from(gauges).written()))
    name = _name(case, file)
    if file != before:
        put_file("readings", file)
    kept.name, kept.typed, kept.answer, kept.fresh = name, typed, answer or kept.answer, False
