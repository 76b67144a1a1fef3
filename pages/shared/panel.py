"""Show what frames every page: the sidebar with the job's files, valve body and condition, and the job's steps."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import wait
from functools import partial
from pathlib import Path

import streamlit as st
from streamlit.delta_generator import DeltaGenerator
from streamlit.typing import UploadedFile

from atleak.catalogue.written_numbers import ENGINE_SPEED, MILEAGE, TEMPERATURE
from atleak.common.errors import ErasedElsewhere
from atleak.common.units import gear_name, unit
from atleak.common.wording import Wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.job.case import SourceFile
from atleak.job.result import Step, job_steps
from atleak.report.tables.road_test import whole
from pages.shared import book, choices, drop_zone, fields, places, reader, show
from pages.shared.cases import WHILE_READING, LogReading, PageCase, diagnosis_of, own_faults
from pages.shared.state import (
    FILES,
    choose,
    current_diagnosis,
    give_up_log,
    job,
    new_job,
    session,
    sheet_beside,
    take_away,
    take_sample,
)

WHERE = {"readings": "Measure", **dict.fromkeys(("road_test", "pressures", "vacuum", "flows"), "In_the_car")}
RPM = unit("rpm", "rotational_speed")
_SOON = 0.2  # [s]
_ROOM = 28  # letters of a name that the sidebar's field shows
LOOKS = Path(__file__).with_name("page.css")


def draw() -> Diagnosis:
    """Draw sidebar and navigation, bring the job's results up to date and show refusals above the page; return them."""
    st.session_state["framed"] = True
    if wanted := st.session_state.pop("wanted", ""):
        st.switch_page(places.page(wanted), query_params=st.query_params.to_dict())
    WHILE_READING.set(partial(_count_rows, st.empty()))
    book.follow_address()
    st.html(LOOKS)
    say = reader.say()
    with st.sidebar:
        drop("job", say("panel.files"), say("panel.files_help"))
        in_job = st.container()
        with st.container():
            choices.catalogue_entry("controller")
            if len(name := say.name(choices.controller().name)) > _ROOM:
                st.caption(show.plain(name))
        with st.container():
            if faults := own_faults():
                files = ", ".join(show.plain(fault.place.file) for fault in faults)
                st.warning(say("panel.left_aside", files=files))
        choices.complaint("panel")
        _condition()
        jobs = st.container()
    turns = session().turns
    result = current_diagnosis()
    if session().turns != turns:
        st.rerun()  # the sheet's head chose another valve body than the one drawn above
    with jobs:
        _jobs()
    with in_job:
        for slot in FILES:
            with st.container():
                _status(slot, result)
        for notice in session().notices:
            st.caption(show.plain(notice(reader.say())))
        if beside := sheet_beside():
            st.page_link(
                places.page("History"), label=say("panel.compare"), icon=":material/compare_arrows:",
                query_params={"history": "compare"}, help=beside.name,
            )  # fmt: skip
    shown = diagnosis_of(session().good)
    with show.faults():
        _draw_steps(shown)
    with st.container():  # one element however many notices there are: the elements below keep their places
        _notices()
    return shown


def _count_rows(place: DeltaGenerator, reading: LogReading) -> None:
    """Count a large log's rows while it is read; what somebody does meanwhile on the page begins it anew, and waits."""
    say = reader.say()
    if wait([reading.understood], _SOON).done:
        return
    with place.container(horizontal=True, vertical_alignment="center"):
        said = st.empty()
        if reading.log is session().case.road_test:  # and not of a job that is opened
            st.button(say("panel.cancel"), key=f"cancel-{id(reading)}", on_click=give_up_log)
    while not wait([reading.understood], _SOON).done:
        said.markdown(say("panel.reading", name=show.plain(reading.log.name), rows=whole(reading.rows, say)))
    place.empty()


def shown() -> tuple[PageCase, Diagnosis]:
    """Return the job that is shown and its diagnosis."""
    if "framed" not in st.session_state:
        # a fresh server that gets a request for a page's own address first runs that page without app.py
        st.session_state["wanted"] = str(st.context.url or "").rsplit("/", 1)[-1]
        st.switch_page("app.py", query_params=st.query_params.to_dict())
    case = session().good
    return case, diagnosis_of(case)


def _key(name: str) -> str:
    return f"{name}-{session().generation}"


def drop(place: str, label: str, help: str | None = None) -> None:
    """Offer a place for files of the job; whatever is dropped there finds where it belongs by its content."""

    def take(files: Sequence[UploadedFile]) -> None:
        from pages.shared import dropped  # dear to import, and no first page needs it

        dropped.take([SourceFile(each.name, each.getvalue()) for each in files])

    drop_zone.draw(f"{place}-{session().in_book.place}", label, take, several=True, help=help)


def _status(slot: str, result: Diagnosis) -> None:
    """Say which file of a kind is in the job, which was refused, and offer to take it away."""
    say, now = reader.say(), session()
    file, refused = getattr(now.good, slot), now.refused.get(slot)
    if refused is not None:
        st.error(f"**{say('panel.not_taken', name=show.plain(refused.name))}** {show.error_line(refused.error)}")
    if file is None and refused is None:
        if slot == "readings":
            st.caption(say("panel.no_sheet"))
        return
    about = "" if file is None else _about(slot, result, say)
    origin = f"{say('panel.sample')}: " if now.good.sample else f"{say('panel.still')} " if refused is not None else ""
    said, away = st.columns([5, 1], gap="small", vertical_alignment="center")
    if file is not None:
        said.caption(f"{origin}**{show.plain(file.name)}** · {about}")
    tip = show.plain(say("panel.take_away", name=(refused or file).name))
    away.button("✕", key=f"away-{slot}", on_click=take_away, args=(slot,), help=tip, type="tertiary")


def _about(slot: str, result: Diagnosis, say: Wording) -> str:
    """Return what is in the job's file of a kind."""
    if slot == "readings":
        return say("panel.lands_measured", measured=result.measured, lands=len(result.lands))
    if slot == "pressures":
        return say("panel.gauge_readings", count=len(result.pressures.readings) if result.pressures else 0)
    if slot in ("vacuum", "flows"):
        table = result.vacuum_table if slot == "vacuum" else result.flow_table
        return say(f"panel.{slot}_read", count=len(table.readings) if table else 0)
    if result.log is None:
        return ""
    test = result.log.road_test
    return say("panel.log_rows", rows=test.rows, seconds=say.number(test.duration, 0))


def _jobs() -> None:
    """Offer a new job, the sample, the way back and forth, and say under which name this one is kept."""
    say, steps = reader.say(), session().steps
    with st.container():
        for name, way, done in (("undo", book.undo, steps.past), ("redo", book.redo, steps.future)):
            if done:
                what = show.plain(say(f"panel.{name}", what=done[-1].done(say)))
                st.button(what, on_click=way, width="stretch", key=name)
    cleared = say("panel.cleared")
    st.button(say("panel.new_job"), on_click=new_job, width="stretch", help=cleared)
    sample = session().case.sample
    st.button(say("panel.take_sample"), on_click=take_sample, disabled=sample, width="stretch", help=cleared)
    place, case = st.container(), session().case
    kept = {"guard_factor": case.guard_factor, "assumptions": case.assumptions, "constants": case.constants}
    if any(kept.values()):
        names = ", ".join(say(f"panel.{name}") for name, value in kept.items() if value)
        place.caption(say("panel.from_file", names=names))
    _in_book()


def _condition() -> None:
    say, now = reader.say(), session()
    controller = choices.controller()
    start = now.start if now.start.controller == now.case.controller else PageCase()  # none for one chosen since
    point = start.point or controller.operating_points[0]
    with st.expander(say("panel.condition")):
        owner = f"{_key('at')}-{controller.sha256}"
        gears = list(dict.fromkeys([*controller.gears, point.gear]))
        temperature, speed, first_gear = (
            getattr(point, name) if getattr(start, name) is None else getattr(start, name)
            for name in ("temperature", "engine_speed", "gear")
        )
        temperature = fields.number(say("columns.temperature"), TEMPERATURE, temperature, key=f"{owner}-t")
        rpm = round(RPM.from_si(speed), 6)
        typed = fields.number(say("columns.engine_speed"), ENGINE_SPEED, rpm, key=f"{owner}-n")
        gear = st.selectbox(say("columns.gear"), gears, gears.index(first_gear), gear_name, key=f"{owner}-g")
        mileage = fields.number(say("columns.mileage"), MILEAGE, now.start.mileage, key=_key("mileage"), optional=True)
        st.caption(
            say(
                "panel.pressures_as",
                condition=show.plain(say.condition(point)),
                source=show.plain(say.name(point.source)),
            )
        )
    if typed is not None and typed != rpm:
        speed = RPM.to_si(typed)
    choose(
        temperature=None if temperature == point.temperature else temperature,
        engine_speed=None if speed == point.engine_speed else speed,
        gear=None if gear == point.gear else gear,
        mileage=mileage,
    )


def _in_book() -> None:
    """Say under which name the job is kept."""
    say, in_book = reader.say(), session().in_book
    if in_book.id is None and session().good.sample:
        st.caption(say("panel.sample_not_kept"))
        st.button(say("panel.keep_sample"), on_click=book.keep_sample, disabled=not book.unsaved(), width="stretch")
    elif in_book.id is None:
        st.caption(say("panel.will_be_kept"))
    else:
        unsaved = any(in_book.news) and book.unsaved()
        state = f" · **{say('panel.unsaved')}**" if unsaved else f" ({say('panel.archived')})" * in_book.archived
        st.caption(f"{say('panel.in_book')}: **{show.plain(job().number or in_book.id)}**{state}")


def _book_notices() -> None:
    """Say where the job in the book is another one than that which is shown, or could not be saved."""
    say, in_book = reader.say(), session().in_book
    if any(in_book.news) and book.unsaved():  # seen from wherever on the page somebody types
        st.toast(say("panel.not_saved_see"))
    if in_book.fault is not None:
        st.error(say("panel.not_saved", problem=show.plain(in_book.fault)))
    if in_book.conflict is not None:
        unsaved = book.unsaved()
        mine = f" {say('panel.changed_here')}" if unsaved else ""
        st.warning(f"{say('panel.changed_elsewhere', what=show.plain(in_book.conflict))}{mine}")
        with st.container(horizontal=True):
            st.button(say("panel.show_newer"), on_click=book.show_theirs, key="book-theirs")
            if unsaved and not isinstance(in_book.conflict, ErasedElsewhere):
                for name, another in (("keep_mine", True), ("write_over", False)):
                    save, own = partial(book.save_anyway, as_another=another), "another" if another else "over"
                    st.button(say(f"panel.{name}"), on_click=save, key=f"book-{own}")
    if in_book.judged_otherwise:
        st.info(show.judged_otherwise(in_book.result_by, in_book.judged_otherwise))


def _notices() -> None:
    say, now = reader.say(), session()
    _book_notices()
    if now.good.sample:
        st.caption(say("panel.is_sample"))
    for slot, page in WHERE.items():
        if slot in now.refused:
            kept = getattr(now.good, slot)
            still = say("panel.still_shown", name=kept.name) if kept else say("panel.as_it_was")
            hint = say("panel.what_was_read", page=say(f"pages.{page}"))
            show.refusal(say(f"panel.as_{slot}"), now.refused[slot], f"{still} {hint}")
    of_job = [now.refused["job"]] if "job" in now.refused else []
    for refused in (*of_job, *now.not_taken):
        show.refusal(say("panel.as_part"), refused, say("panel.as_it_was"))
    for slot in ("catalogue", "settings"):
        if slot in now.refused:
            show.refusal(say("panel.not_computed"), now.refused[slot], say("panel.last_that_could"))


def _draw_steps(diagnosis: Diagnosis) -> None:
    """Draw the one navigation: the job's steps, each with what is there or missing, and the pages beside them."""
    say = reader.say()
    steps = {step.name: step for step in job_steps(diagnosis, job(), say)}
    with st.container(horizontal=True, gap="small", key="steps"):
        for path in places.EVERY:
            name = places.name_of(path)
            label = _step_label(steps[name.lower()], say) if path in places.STEPS else say.get("pages", name)
            st.page_link(path, label=label, width="content")


def _step_label(step: Step, say: Wording) -> str:
    name, state = say(f"steps.{step.name}"), show.plain(step.state)
    return f"{name} · {state if step.complete else f'**{state}**'}" if state else name
