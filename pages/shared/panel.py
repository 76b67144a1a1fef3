"""Show the sidebar: the files of the job, its valve body and its stated condition. Every page draws it."""

from __future__ import annotations

import glob
from pathlib import Path

import streamlit as st

from atleak.catalogue.controller import Controller
from atleak.diagnosis import Diagnosis
from atleak.errors import AtleakError
from atleak.intake.units import unit
from atleak.job.case import SourceFile
from atleak.written_numbers import ENGINE_SPEED, MILEAGE, TEMPERATURE
from pages.shared import book, choices, dropped, fields, show
from pages.shared.cases import PageCase, controller_of, diagnosis_of, own_faults
from pages.shared.state import (
    FILES,
    choose,
    current_diagnosis,
    job,
    last_done,
    new_job,
    session,
    take_away,
    take_sample,
    undo,
)

PAGES = Path(__file__).resolve().parents[1]
NAMES = {"readings": "Measuring sheet", "road_test": "Road-test log", "pressures": "Gauge readings"}
WHERE = {"readings": "Readings", "road_test": "Road test", "pressures": "Pressures"}
RPM = unit("rpm", "rotational_speed")
DROP_HELP = (
    "Measuring sheet, road-test log, gauge readings, job file, job record, photos, and your own valve body, fluid, "
    "limits or instrument: each is recognised by its content, not its name."
)
NARROW_MARGINS = "<style>.stMainBlockContainer {padding: 4rem clamp(0.8rem, 2vw, 2rem) 4rem;}</style>"


def draw() -> Diagnosis:
    """Draw the sidebar, bring the job's results up to date and show refusals at the head of the page; return them."""
    st.session_state["framed"] = True
    for path in PAGES.glob(f"[0-9]*_{st.session_state.pop('wanted', '?')}.py"):
        st.switch_page(path, query_params=st.query_params.to_dict())
    book.follow_address()
    st.html(NARROW_MARGINS)
    with st.sidebar:
        _drop_zone()
        in_job = st.container()
        with st.container():
            choices.catalogue_entry("controller")
        _left_aside()
        _complaint()
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
            st.caption(show.plain(notice))
    with st.container():  # one element however many notices there are: the elements below keep their places
        _notices()
    return diagnosis_of(session().good)


def shown() -> tuple[PageCase, Diagnosis]:
    """Return the job that is shown and its diagnosis."""
    if "framed" not in st.session_state:
        # a fresh server that gets a request for a page's own address first runs that page without app.py
        st.session_state["wanted"] = glob.escape(str(st.context.url or "?").rsplit("/", 1)[-1])
        st.switch_page("app.py", query_params=st.query_params.to_dict())
    case = session().good
    return case, diagnosis_of(case)


def _key(name: str) -> str:
    return f"{name}-{session().generation}"


def _drop_zone() -> None:
    """Take whatever files are dropped; the zone is empty again once they are in."""
    turn = f"drop-{st.session_state.setdefault('drops', 0)}"

    def changed() -> None:
        st.session_state["drops"] += 1
        dropped.take([SourceFile(each.name, each.getvalue()) for each in st.session_state[turn]])

    st.file_uploader("Files of the job", key=turn, accept_multiple_files=True, help=DROP_HELP, on_change=changed)


def _status(slot: str, result: Diagnosis) -> None:
    """Say which file of a kind is in the job, which was refused, and offer to take it away."""
    now = session()
    file, refused = getattr(now.good, slot), now.refused.get(slot)
    if refused is not None:
        st.error(f"**{show.plain(refused.name)}: not taken.** {show.error_line(refused.error)}")
    if file is None and refused is None:
        if slot == "readings":
            st.caption("No measuring sheet yet: every land is at its mounting clearance.")
        return
    about = "" if file is None else _about(slot, result)
    origin = "sample: " if now.good.sample else "still " if refused is not None else ""
    said, away = st.columns([5, 1], gap="small", vertical_alignment="center")
    if file is not None:
        said.caption(f"{origin}**{show.plain(file.name)}** · {about}")
    tip = f"Take {(refused or file).name} away"
    away.button("✕", key=f"away-{slot}", on_click=take_away, args=(slot,), help=tip, type="tertiary")


def _about(slot: str, result: Diagnosis) -> str:
    """Return what is in the job's file of a kind."""
    if slot == "readings":
        return f"{result.measured} of {len(result.lands)} lands measured"
    if slot == "pressures":
        return f"{len(result.pressures.readings) if result.pressures else 0} gauge readings"
    if result.log is None:
        return ""
    test = result.log.road_test
    return f"{test.rows} rows, {test.duration:.0f} s"


def _jobs() -> None:
    """Offer a new job, the sample and the way back, and say under which name this one is kept."""
    last = last_done()
    with st.container():
        if last is not None:
            st.button(f"Undo: {last}", on_click=undo, width="stretch", key="undo")
    cleared = "Takes what is in the job and in the job record away. It can be undone, and stays in the job book."
    st.button("New, empty job", on_click=new_job, width="stretch", help=cleared)
    sample = session().case.sample
    st.button("Take the sample job", on_click=take_sample, disabled=sample, width="stretch", help=cleared)
    place, case = st.container(), session().case
    kept = {"guard factor": case.guard_factor, "assumptions": case.assumptions, "values for the log": case.constants}
    if any(kept.values()):
        place.caption(f"Taken from the job file: {', '.join(name for name, value in kept.items() if value)}.")
    _in_book()


def _left_aside() -> None:
    """Say which files of the user's own catalogue cannot be used, and where they are explained."""
    faults = own_faults()
    with st.container():
        if faults:
            files = ", ".join(show.plain(fault.place.file) for fault in faults)
            st.warning(f"**Own files that cannot be used:** {files}. What is wrong: page Catalogue.")


def _start() -> PageCase:
    """Return the first values of what belongs to the controller: none for one that was chosen since."""
    now = session()
    return now.start if now.start.controller == now.case.controller else PageCase()


def _complaint() -> None:
    controller, first = _controller(), _start().complaint
    labels = {complaint.id: complaint.label for complaint in controller.complaints}
    options = [None, *labels]
    picked = st.selectbox(
        "Complaint",
        options,
        index=options.index(first if first in labels else None),
        key=f"{_key('complaint')}-{controller.sha256}",
        format_func=lambda name: "none chosen" if name is None else labels[name],
        disabled=not labels,
        help="What the customer says. Its conditions lead the result, and it says which lands to measure first."
        if labels
        else "The file of this valve body maps no complaint to its operating points.",
    )
    choose(complaint=picked)


def _condition() -> None:
    now = session()
    controller = _controller()
    start = _start()
    point = start.point or controller.operating_points[0]
    with st.expander("Stated condition and mileage"):
        owner = f"{_key('at')}-{controller.sha256}"
        gears = list(dict.fromkeys([*controller.gears, point.gear]))
        temperature, speed, first_gear = (
            getattr(point, name) if getattr(start, name) is None else getattr(start, name)
            for name in ("temperature", "engine_speed", "gear")
        )
        temperature = fields.number("Temperature", TEMPERATURE, temperature, key=f"{owner}-t")
        rpm = round(RPM.from_si(speed), 6)
        typed = fields.number("Engine speed", ENGINE_SPEED, rpm, key=f"{owner}-n")
        gear = st.selectbox("Gear", gears, gears.index(first_gear), key=f"{owner}-g")
        mileage = fields.number("Mileage", MILEAGE, now.start.mileage, key=_key("mileage"), optional=True)
        st.caption(f"Pressures as {show.plain(point.label)}: {show.plain(point.source)}")
    if typed is not None and typed != rpm:
        speed = RPM.to_si(typed)
    choose(
        temperature=None if temperature == point.temperature else temperature,
        engine_speed=None if speed == point.engine_speed else speed,
        gear=None if gear == point.gear else gear,
        mileage=mileage,
    )


def _controller() -> Controller:
    """Return the controller as chosen or, while that is refused, the one that is shown."""
    try:
        return controller_of(session().case)
    except AtleakError:
        return controller_of(session().good)


def _in_book() -> None:
    """Say under which name the job is kept."""
    in_book = session().in_book
    if in_book.id is None:
        st.caption("Kept in the job book from the first file or entry on.")
    else:
        state = " · **not saved**" if any(in_book.news) and book.unsaved() else " (archived)" * in_book.archived
        st.caption(f"In the job book: **{show.plain(job().number or in_book.id)}**{state}")


def _book_notices() -> None:
    """Say where the job in the book is another one than that which is shown, or could not be saved."""
    in_book = session().in_book
    if any(in_book.news) and book.unsaved():  # seen from wherever on the page somebody types
        st.toast("**Not saved.** The head of the page says why, and what can be done.")
    if in_book.fault is not None:
        st.error(
            f"**Not saved.** {show.plain(in_book.fault)}. The job stays in this window, and is saved as soon as it can "
            "be; page Report gives it as a job file."
        )
    if in_book.conflict is not None:
        unsaved = book.unsaved()
        mine = " What was changed here since is not saved." if unsaved else ""
        st.warning(f"**Changed elsewhere.** {show.plain(in_book.conflict)}.{mine}")
        with st.container(horizontal=True):
            st.button("Show the newer state", on_click=book.show_theirs, key="book-theirs")
            if unsaved:
                st.button("Keep mine as another job", on_click=book.keep_as_another, key="book-another")
                st.button("Write mine over it", on_click=book.write_over, key="book-over")
    if in_book.judged_otherwise:
        several = "".join(f"\n- {show.plain(each)}" for each in in_book.judged_otherwise[: show.SHOWN])
        more = len(in_book.judged_otherwise) - show.SHOWN
        st.info(
            f"**Judged otherwise than when it was stored** by atleak {show.plain(in_book.result_by)}:{several}"
            + (f"\n- … and {more} more" if more > 0 else "")
        )


def _notices() -> None:
    now = session()
    _book_notices()
    if now.good.sample:
        st.caption("**Sample job**: representative data. Put your own files in the sidebar (top left on a phone).")
    for slot, label in NAMES.items():
        if slot in now.refused:
            kept = getattr(now.good, slot)
            still = f"Shown are still the results of {kept.name}." if kept else "The job is as it was."
            hint = f"What was read of it, and how to have it read otherwise: page {WHERE[slot]}."
            show.refusal(label.lower(), now.refused[slot], f"{still} {hint}")
    for slot in ("job", "dropped"):
        if slot in now.refused:
            show.refusal("part of the job", now.refused[slot], "The job is as it was.")
    for slot in ("catalogue", "settings"):
        if slot in now.refused:
            show.refusal("These choices cannot be computed.", now.refused[slot], "Shown is the last job that could.")
