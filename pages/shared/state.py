"""Keep the session: the job as chosen, the last job that computed, and what was refused since."""

from __future__ import annotations

import time
from dataclasses import dataclass, field, replace
from typing import Any

import streamlit as st

from atleak.diagnosis import Diagnosis
from atleak.errors import AtleakError, CatalogueError, PressureTableError, ReadingsError, RoadTestError
from atleak.job.case import SLOTS, SourceFile
from atleak.job.file import read_job_file
from atleak.job.record import Job
from atleak.jobs.judged_anew import JudgedOtherwise
from pages.shared.cases import FITTED, PageCase, chosen_by_id, diagnosis_of, held, opened_case, sample_case

FILES = tuple(FITTED)
KEPT = (*SLOTS, "profile", "options")  # choices that a new, empty job takes over
JOB = "job"  # the parameter of the address that names a job of the job book
RECORD = "job-record"  # where the session keeps it; no parameter of the address may have this name
REPLACING = 60.0  # [s] within which a new file replaces the one taken away: an uploader does both, one after the other


@dataclass(frozen=True)
class Refusal:
    """A file or choice that was refused, and why."""

    name: str
    error: AtleakError
    file: SourceFile | None = None


@dataclass
class InBook:
    """How the job of a session stands in the job book."""

    id: str | None = None  # None: nothing of it is in the book
    version: int = 0  # the one that this session saw last
    state: str | None = None  # of the job as it was saved, or as it was before anybody touched it
    new: bool = False  # to be saved as it stands, before anything changes
    conflict: AtleakError | None = None  # somebody else has saved it since
    fault: AtleakError | None = None  # why it could not be saved
    unknown: str = ""  # id in the address that could not be opened
    left: str | None = None  # id in the address, of the job that was shown before this one: not to be opened again
    page: str = ""  # on which the address was given the id last
    archived: bool = False
    result_by: str = ""  # version of atleak that gave the stored result
    judged_otherwise: tuple[JudgedOtherwise, ...] = ()  # where this version judges otherwise

    @property
    def news(self) -> tuple[str, str]:
        """Return what a page must show at once."""
        return str(self.conflict or ""), str(self.fault or "")


@dataclass
class Session:
    """One user's state; ``good`` is what is shown."""

    case: PageCase
    good: PageCase
    refused: dict[str, Refusal]
    before: PageCase | None = None  # the job before the last file came in, to return to if that file is refused
    away: dict[str, tuple[float, dict[str, Any]]] = field(
        default_factory=dict
    )  # by slot: when a file was taken out of the job, and the choices that went with it
    windows: dict[str, tuple[float, float]] = field(default_factory=dict)  # part shown [s], by the log's SHA-256
    over: SourceFile | None = None  # a second log, drawn over the job's
    offset: float = 0.0  # [s] by which it is shifted
    unkept: tuple[str, str] = ("", "")  # SHA-256 of a log whose columns could not be remembered, and why
    start: PageCase = field(default_factory=PageCase)  # the first values of the sidebar's widgets
    generation: int = 0  # part of every widget's key: the sample job gives fresh widgets
    in_book: InBook = field(default_factory=InBook)


def session() -> Session:
    """Return this user's session; a fresh one starts with the sample job."""
    if "atleak" not in st.session_state:
        case = sample_case()
        st.session_state["atleak"] = Session(case, case, {})
    return st.session_state["atleak"]


def job() -> Job:
    """Return the record of the job that is shown."""
    record: Job = st.session_state.setdefault(RECORD, Job())
    return record


def put_job(record: Job) -> None:
    """Replace the record by another one, with fresh widgets."""
    st.session_state[RECORD] = record
    st.session_state["job-generation"] = job_generation() + 1


def job_generation() -> int:
    """Return the part of the keys of the record's widgets that changes when it is replaced."""
    return int(st.session_state.get("job-generation", 0))


def put_file(slot: str, file: SourceFile | None) -> None:
    """Take in a file that was chosen, or take away the one that was removed.

    An uploader whose file is replaced takes the old one away first. The job to go back to holds that file again, should
    the new one be refused.
    """
    now = session()
    refused = now.refused.pop(slot, None)
    if file is None and refused is not None:
        return  # the refused file was taken away: the one before it is still in the job
    at, fitted = now.away.pop(slot, (0.0, {}))
    now.before = now.case
    if file is None and not now.case.sample:
        now.away[slot] = time.monotonic(), {name: getattr(now.case, name) for name in (slot, *FITTED[slot])}
    elif file is not None and fitted and time.monotonic() - at < REPLACING:
        now.before = replace(now.case, **fitted)
    now.case = now.case.with_file(slot, file)


def choose(**changes: Any) -> None:
    """Change choices; another controller than the sample's drops the sample's files, which fit only that.

    Files that were refused are tried again with it: a sheet that was made for another valve body is why it is chosen.
    """
    now = session()
    other = changes.get("controller", now.case.controller) != now.case.controller
    if other:
        changes |= {"point": None, "temperature": None, "engine_speed": None, "gear": None, "complaint": None}
        changes["repairs"] = ()
        now.away.clear()
        if now.case.sample:
            changes |= {**dict.fromkeys(FILES), "sample": False}
    now.case = replace(now.case, **changes)
    for slot, refusal in list(now.refused.items()) if other else ():
        if slot in FILES and refusal.file is not None:
            put_file(slot, refusal.file)


def take_sample() -> None:
    """Return to the sample job, with fresh widgets and an empty job record."""
    show_job(sample_case(), Job(), InBook())


def new_job() -> None:
    """Start an empty job; the controller, the instruments and the engine's options stay."""
    now = session()
    case = PageCase(**{name: getattr(now.good, name) for name in KEPT} | chosen_by_id(now.good))
    show_job(case, Job(), InBook())


def show_job(case: PageCase, record: Job, in_book: InBook) -> None:
    """Show another job, with fresh widgets."""
    now = session()
    st.session_state["atleak"] = Session(case, case, {}, start=case, generation=now.generation + 1, in_book=in_book)
    st.session_state.pop("pictures", None)
    st.query_params.pop(JOB, None)
    put_job(record)


def open_job(name: str, content: bytes) -> bool:
    """Open a job file with fresh widgets; return whether it was taken."""
    now = session()
    try:
        job_file = read_job_file(content, name=name)
        case = opened_case(job_file.case)
        diagnosis_of(case)
    except AtleakError as error:
        now.refused["job"] = Refusal(name, error)
        return False
    show_job(case, job_file.job, InBook(new=True))
    return True


def current_diagnosis() -> Diagnosis:
    """Return the diagnosis of the job as chosen, or of the last that computed; ``refused`` keeps the reason."""
    now = session()
    for slot in ("settings", *(kind for kind in now.refused if kind not in (*FILES, "job"))):
        now.refused.pop(slot, None)
    try:
        result = diagnosis_of(now.case)
    except AtleakError as error:
        slot = _at_fault(now, error)
        if slot in FILES and now.before is not None:
            file = getattr(now.case, slot)
            now.refused[slot] = Refusal(file.name, error, file)
            now.case, now.before = now.before, None
            return current_diagnosis()
        now.refused[slot] = Refusal("", error)
        return diagnosis_of(now.good)
    now.good, now.before = held(now.case), None
    return result


def _at_fault(now: Session, error: AtleakError) -> str:
    changed = [
        slot for slot in FILES if now.before is not None and getattr(now.case, slot) != getattr(now.before, slot)
    ]
    if isinstance(error, PressureTableError):
        return next((slot for slot in ("pressures", "readings") if slot in changed), "settings")
    if isinstance(error, ReadingsError):
        return "readings" if "readings" in changed else "settings"
    if isinstance(error, RoadTestError):
        return "road_test" if "road_test" in changed else "settings"
    if isinstance(error, CatalogueError):
        return "catalogue"
    return changed[0] if changed else "settings"
