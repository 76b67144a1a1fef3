"""Show the sidebar: files and choices of the job. Every page draws it, so that none of its widgets loses its state."""

from __future__ import annotations

import glob
from pathlib import Path
from typing import Any, get_args, get_type_hints

import streamlit as st

from atleak.catalogue.controller import Controller
from atleak.catalogue.fluid import USED_THINNER, FluidState
from atleak.diagnosis import Diagnosis
from atleak.engine.profile import PROFILES, UNKNOWN, Profile
from atleak.errors import AtleakError
from atleak.intake.units import unit
from atleak.job.case import SLOTS, Slot, SourceFile
from atleak.written_numbers import ENGINE_SPEED, MILEAGE, TEMPERATURE
from pages.shared import book, fields, show
from pages.shared.cases import PageCase, catalogue_list, controller_of, diagnosis_of, own_faults, shown_name
from pages.shared.state import choose, current_diagnosis, job, new_job, open_job, put_file, session, take_sample

PAGES = Path(__file__).resolve().parents[1]
OWN = "own file (TOML) …"
WHERE = {"readings": "Readings", "road_test": "Road test", "pressures": "Pressures"}
FILES = {
    "readings": (
        "Measuring sheet",
        "Spool and sleeve diameters: xlsx, xls, ods or csv. Recognised by its content, not its name.",
    ),
    "road_test": ("Road-test log", "As the logger wrote it: csv, txt, xlsx … Decimal point or comma."),
    "pressures": (
        "Gauge readings",
        "Pressures of the standing vehicle, range by range: xlsx or csv. Page Pressures takes typed ones.",
    ),
}
RPM = unit("rpm", "rotational_speed")
LOOKS = Path(__file__).with_name("page.css")
OPTIONS = {
    "diameter": "Diameter in the gap law",
    "viscosity": "Viscosity",
    "pump_draw": "Counted as drawn from the pump",
    "pump_efficiency": "Pump efficiency",
    "entry_loss": "Loss at a gap's entry and exit",
    "form": "Clearance that differs around the bore",
}
VALUES = {
    "mean": "mean of spool and sleeve",
    "spool": "of the spool",
    "d341": "ASTM D341",
    "tabulated": "table",
    "regression": "the study's regression",
    "into_sump": "flow into the sump",
    "all_gaps": "flow of all gaps",
    "wilson": "Wilson slip",
    "constant": "constant",
    "auto": "subtracted where it matters",
    "on": "subtracted everywhere",
    "off": "left out",
    "mean_of_cubes": "mean of the cubes",
    "cube_of_mean": "cube of the mean",
}


def draw() -> None:
    """Draw the sidebar, bring the job's results up to date and show refusals at the head of the page."""
    st.session_state["framed"] = True
    for path in PAGES.glob(f"[0-9]*_{st.session_state.pop('wanted', '?')}.py"):
        st.switch_page(path, query_params=st.query_params.to_dict())
    book.follow_address()
    st.html(LOOKS)
    with st.sidebar:
        places = {slot: _uploader(slot) for slot in FILES}
        sample = session().case.sample
        cleared = "Takes what is in the job and in the job record away."
        st.button("New, empty job", on_click=new_job, width="stretch", help=cleared)
        st.button("Take the sample job", on_click=take_sample, disabled=sample, width="stretch", help=cleared)
        _job_file()
        _in_book()
        for choice in SLOTS.values():
            if choice.part is None:
                with st.container():
                    _choice(choice)
                    if choice.name == "fluid":
                        _fluid_state()
        with st.expander("Instruments"):
            for choice in SLOTS.values():
                if choice.part is not None:
                    _choice(choice)
        _left_aside()
        _complaint()
        _condition()
        _profile()
    result = current_diagnosis()
    for slot, place in places.items():
        with place:
            _status(slot, result)
    with st.container():  # one element however many notices there are: the elements below keep their places
        _notices()


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


def _uploader(slot: str) -> Any:
    label, tip = FILES[slot]
    key = _key(slot)

    def changed() -> None:
        upload = st.session_state[key]
        put_file(slot, None if upload is None else SourceFile(upload.name, upload.getvalue()))

    st.file_uploader(label, key=key, help=tip, on_change=changed)
    return st.container()


def _job_file() -> None:
    key = _key("job-file")

    def changed() -> None:
        upload = st.session_state[key]
        session().refused.pop("job", None)
        if upload is not None:
            open_job(upload.name, upload.getvalue())

    with st.expander("Open a job file"):
        st.file_uploader(
            "Job file", ["zip"], key=key, help="As the page Report or the command line writes it.", on_change=changed
        )
        st.caption("Sheet, log, job record and every choice come from it, in place of what is in the job.")
    place, case = st.container(), session().case
    kept = {"guard factor": case.guard_factor, "assumptions": case.assumptions, "values for the log": case.constants}
    if any(kept.values()):
        place.caption(f"Taken from the job file: {', '.join(name for name, value in kept.items() if value)}.")


def _status(slot: str, result: Diagnosis) -> None:
    now = session()
    file, refused = getattr(now.good, slot), now.refused.get(slot)
    if refused is not None:
        st.error(f"**Not taken.** {show.error_line(refused.error)}")
    if file is None:
        st.caption("None yet: every land is at its mounting clearance." if slot == "readings" else "None yet.")
        return
    origin = "sample: " if now.good.sample else "still " if refused is not None else ""
    if slot == "readings":
        about = f"{result.measured} of {len(result.lands)} lands measured"
    elif slot == "pressures":
        about = f"{len(result.pressures.readings) if result.pressures else 0} readings"
    elif result.log is not None:
        test = result.log.road_test
        about = f"{test.rows} rows, {test.duration:.0f} s"
    st.caption(f"{origin}**{show.plain(file.name)}** · {about}")


def _choice(slot: Slot) -> None:
    current = getattr(session().case, slot.name)
    known = catalogue_list(slot.name).entries
    ids = [name for name, entry in known.items() if slot.part is None or slot.part in entry.measures]
    options = [*dict.fromkeys([*ids, *([current] if isinstance(current, str) else [])]), OWN]
    picked = st.selectbox(
        slot.label,
        options,
        index=options.index(current if isinstance(current, str) else OWN),
        key=_key(slot.name),
        format_func=lambda option: shown_name(known[option]) if option in known else option,
    )
    if picked != OWN:
        choose(**{slot.name: picked})
        return
    if isinstance(current, SourceFile):
        st.caption(f"**{show.plain(current.name)}**")
    own = st.file_uploader(f"Your own file: {slot.label.lower()}", key=_key(f"own-{slot.name}"))
    if own is not None:
        choose(**{slot.name: SourceFile(own.name, own.getvalue())})


def pick(slot: str, name: str) -> None:
    """Choose an entry of the catalogue by id, in job and sidebar; for a callback, before anything is drawn."""
    choose(**{slot: name})
    st.session_state[_key(slot)] = name


def _left_aside() -> None:
    """Say which files of the user's own catalogue cannot be used, and where they are explained."""
    faults = own_faults()
    with st.container():
        if faults:
            files = ", ".join(show.plain(fault.place.file) for fault in faults)
            st.warning(f"**Own files that cannot be used:** {files}. What is wrong: page Catalogue.")


def _fluid_state() -> None:
    """Ask whether the fluid in the transmission is fresh or used."""
    states = (None, *get_args(FluidState))
    low, high = USED_THINNER
    picked = st.radio(
        "The fluid is",
        states,
        states.index(session().case.fluid_state),
        key=_key("fluid_state"),
        format_func=lambda state: state or "not known: taken as fresh",
        horizontal=True,
        help=f"Used fluid is thinner: as its own data say or, without any, by {low} to {high} % (representative).",
    )
    choose(fluid_state=picked)


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


def _profile() -> None:
    hints, start = get_type_hints(Profile), session().start
    with st.expander("Engine: profile and options"):
        name = st.selectbox("Profile", list(PROFILES), list(PROFILES).index(start.profile), key=_key("profile"))
        base = PROFILES[name].options
        first = base | dict(start.options if name == start.profile else ())
        options = {}
        for option, label in OPTIONS.items():
            values = list(get_args(hints[option]))
            key = f"{_key(option)}-{name}"
            tip = "; ".join(f"{VALUES.get(value, value)}: `{option}={value}`" for value in values)
            options[option] = st.selectbox(label, values, values.index(first[option]), _value_name, key=key, help=tip)
        options["eccentricity"] = _eccentricity(name, first["eccentricity"])
        st.caption("`workshop` is the better physics; `paper` computes as the source study printed.")
    choose(profile=name, options=tuple((key, value) for key, value in options.items() if value != base[key]))


def _eccentricity(profile: str, first: float | str) -> float | str:
    unknown = st.toggle(
        "Where the spools lie is unknown",
        first == UNKNOWN,
        key=f"{_key('position')}-{profile}",
        help="Every flow is the mean over all positions, 1.5 times that of concentric spools.",
    )
    fixed = 0.0 if isinstance(first, str) else first
    ratio = st.slider("Eccentricity e/c", 0.0, 1.0, fixed, 0.05, key=f"{_key('ecc')}-{profile}", disabled=unknown)
    return UNKNOWN if unknown else ratio


def _value_name(value: str) -> str:
    return VALUES.get(value, value)


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
    for slot, (label, _) in FILES.items():
        if slot in now.refused:
            kept = getattr(now.good, slot)
            still = f"Shown are still the results of {kept.name}." if kept else "The job is as it was."
            hint = f"What was read of it, and how to have it read otherwise: page {WHERE[slot]}."
            show.refusal(label.lower(), now.refused[slot], f"{still} {hint}")
    if "job" in now.refused:
        show.refusal("job", now.refused["job"], "The job is as it was.")
    for slot in ("catalogue", "settings"):
        if slot in now.refused:
            show.refusal("These choices cannot be computed.", now.refused[slot], "Shown is the last job that could.")
