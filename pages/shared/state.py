"""Keep the session: the job as chosen, the last job that computed, and what was refused since."""

from __future__ import annotations

import hashlib
import weakref
from dataclasses import dataclass, field, replace
from itertools import count
from threading import RLock
from typing import Any

import streamlit as st

from atleak.analysis.record_doubts import taken_from_sheet, with_sheet
from atleak.common.errors import (
    AtleakError,
    CatalogueError,
    FlowTableError,
    OtherControllerError,
    PressureTableError,
    ReadingsError,
    RoadTestError,
    VacuumTableError,
)
from atleak.common.memory import give_back_soon
from atleak.common.sentences import Sentence
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.job.case import SLOTS, CaseChoice, SourceFile
from atleak.job.result import judged_otherwise
from atleak.job.watched_log import WatchedLog
from atleak.job.zip_file import read_job_file
from atleak.measurements.job_card import Job
from atleak.report.json.diagnosis import diagnosis_record
from pages.shared.cases import (
    FITTED,
    PageCase,
    cancel_reading,
    catalogue_names,
    chosen_by_id,
    diagnosis_of,
    held,
    is_large,
    opened_case,
    sample_case,
)
from pages.shared.undo import Left, Step, Steps, Told

FILES = tuple(FITTED)
KEPT = (*SLOTS, "profile", "options")  # choices that a new, empty job takes over
JOB = "job"  # the parameter of the address that names a job of the job book
OF_FLEET = "fleet-unit"  # the one that names a unit of a fleet whose own job is shown, as long as the book has none
RECORD = "job-record"  # where the session keeps it; no parameter of the address may have this name
RESULTS = 2  # that a session keeps


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
    of_fleet: str = ""  # as which unit of a fleet the address names it while it has no id
    unknown: str = ""  # id, or unit of a fleet, in the address that could not be opened
    page: str = ""  # on which the address was given the id last
    archived: bool = False
    result_by: str = ""  # version of atleak that gave the stored result
    judged_otherwise: tuple[Sentence, ...] = ()  # where this version judges otherwise
    place: int = field(default_factory=count().__next__)  # part of the keys of its drop zones: each job has its own
    saving: RLock = field(default_factory=RLock, compare=False, repr=False)  # a run may end after the next has begun

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
    tried: dict[str, PageCase] = field(default_factory=dict)  # by slot: the job before the file that is tried came in
    own: dict[str, SourceFile] = field(default_factory=dict)  # by slot: the last file of one's own that was given
    turns: int = 0  # part of the keys of the choices' widgets: they start anew where something else made the choice
    not_taken: tuple[Refusal, ...] = ()  # of the files that came in last, those that are no part of a job
    notices: tuple[Told, ...] = ()  # what was done with the files that came in last
    sheet_before: SourceFile | None = None  # of this unit, whose place in the job another has taken
    follow: bool = False  # whether the sheet that is tried may choose the controller that its head names
    steps: Steps = field(default_factory=Steps)  # that can be taken back and done again
    windows: dict[str, tuple[float, float]] = field(default_factory=dict)  # part shown [s], by the log's SHA-256
    watched: WatchedLog | None = None  # a log that is followed while it is being written
    over: SourceFile | None = None  # a second log, drawn over the job's
    offset: float = 0.0  # [s] by which it is shifted
    unkept: tuple[str, str] = ("", "")  # SHA-256 of a log whose columns could not be remembered, and why
    start: PageCase = field(default_factory=PageCase)  # the first values of the sidebar's widgets
    generation: int = 0  # part of every widget's key: the sample job gives fresh widgets
    in_book: InBook = field(default_factory=InBook)
    results: tuple[Diagnosis, ...] = ()  # the latest, kept as long as this session may come back to them
    gives_back: bool = False  # whether memory goes back to the system when this ends


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
    """Take in a file of the job, or take it away. One that cannot be used leaves the job as it was."""
    now = session()
    now.refused.pop(slot, None)
    now.tried.setdefault(slot, next(iter(now.tried.values()), now.case))
    now.case = now.case.with_file(slot, file)


def give_up_log() -> None:
    """End the reading of a log, and leave the job as it was before that came in; for a callback."""
    now, file = session(), session().case.road_test
    cancel_reading()
    if file is not None:
        now.case = _without(now.case, "road_test", now.tried.pop("road_test", now.good))
        if now.case.road_test is not file:  # of one that is read anew the job keeps what was read before
            now.notices = (lambda say: say("done.not_read", name=file.name),)


def sheet_beside() -> SourceFile | None:
    """Return the sheet that the job's own may be compared with: it was in the job before, or came with it."""
    now = session()
    return None if now.good.readings in (None, now.sheet_before) else now.sheet_before


def take_away(slot: str) -> None:
    """Take a file out of the job, or the refused one that was to replace it; for a callback."""
    now = session()
    if now.refused.pop(slot, None) is None:
        name = getattr(now.case, slot).name
        remember(lambda say: say("done.taken_away", name=name))
        put_file(slot, None)


def choose(**changes: Any) -> None:
    """Change choices; another controller than the sample's drops the sample's files, which fit only that.

    Files that were refused are tried again: a sheet that was made for another valve body is why it is chosen.
    """
    now = session()
    other = changes.get("controller", now.case.controller) != now.case.controller
    if other:
        changes |= {"point": None, "temperature": None, "engine_speed": None, "gear": None, "complaint": None}
        changes["repairs"] = ()
        if now.case.sample:
            changes |= {**dict.fromkeys(FILES), "sample": False}
    chosen = replace(now.case, **changes)
    if chosen == now.case:
        return
    now.case = chosen
    for slot, refusal in list(now.refused.items()):
        if slot in FILES and refusal.file is not None:
            put_file(slot, refusal.file)


def pick(slot: str, choice: CaseChoice) -> None:
    """Make a choice in place of the widget that shows it, which starts anew; for a callback."""
    now = session()
    now.turns += 1
    if isinstance(choice, SourceFile):
        now.own[slot] = choice
    choose(**{slot: choice})


def remember(done: Told) -> None:
    """Keep the job as it is, so that what is done to it next can be taken back."""
    now = session()
    now.steps = now.steps.settled(now.case, job()).with_step(Step(done, now.case, job()))


def unsaved() -> bool:
    """Tell whether this session holds something that the book does not."""
    in_book = session().in_book
    return in_book.state is not None and in_book.state != state_of_job()


def state_of_job() -> str:
    """Return what tells two states of the job apart: files and choices, record, the bytes of the pictures."""
    record = job()
    pictures = {name: hashlib.sha256(content).hexdigest() for name, content in record.pictures.items()}
    return repr((session().good.key, record.model_dump_json(exclude_defaults=True), sorted(pictures.items())))


def left(done: Told, steps: Steps) -> Left:
    """Return the job on the screen, with its steps, as one that another takes the place of."""
    now = session()
    saved = now.in_book.id is not None and not unsaved()
    return Left(done, now.case, job(), now.in_book, saved, steps)


def way_back(done: Told) -> Steps:
    """Return the steps of a job that is shown next: back to the one on the screen."""
    return Steps().with_step(left(done, replace(session().steps, future=())))


def take_sample() -> None:
    """Return to the sample job, with fresh widgets and an empty job record."""
    show_job(sample_case(), Job(), InBook(), way_back(lambda say: say("done.sample")))


def new_job() -> None:
    """Start an empty job; the controller, the instruments and the engine's options stay."""
    now = session()
    case = PageCase(**{name: getattr(now.good, name) for name in KEPT} | chosen_by_id(now.good))
    show_job(case, Job(), InBook(), way_back(lambda say: say("done.new")))


def show_job(case: PageCase, record: Job, in_book: InBook, steps: Steps) -> None:
    """Show a job with fresh widgets, and what of its steps can be taken back and done again."""
    now = session()
    st.session_state["atleak"] = Session(
        case, case, {}, watched=now.watched, start=case, generation=now.generation + 1, in_book=in_book, steps=steps
    )
    for name in (JOB, OF_FLEET):
        st.query_params.pop(name, None)
    put_job(record)


def open_job(name: str, content: bytes) -> bool:
    """Open a job file with fresh widgets; return whether it was taken."""
    now = session()
    try:
        job_file = read_job_file(content, name=name)
        case = opened_case(job_file.case)
        otherwise = judged_otherwise(job_file.result, diagnosis_record(diagnosis_of(case)), numbers=True)
    except AtleakError as error:
        now.refused["job"] = Refusal(name, error)
        return False
    place = now.in_book.place  # what is dropped after it is meant for it
    in_book = InBook(new=True, result_by=job_file.result_by, judged_otherwise=otherwise, place=place)
    show_job(case, job_file.job, in_book, way_back(lambda say: say("done.opened", name=name)))
    return True


def current_diagnosis() -> Diagnosis:
    """Return the diagnosis of the job as chosen, or of the last that computed; ``refused`` keeps the reason.

    A file that cannot be used is left out, and the rest of what is tried with it is taken.
    """
    now = session()
    for slot in set(now.refused) - {*FILES, "job"}:
        now.refused.pop(slot)
    while not isinstance(result := _result(now), Diagnosis):
        slot, error = result
        if slot not in now.tried:
            now.refused[slot] = Refusal("", error)
            now.steps = now.steps.settled(now.case, job())
            return diagnosis_of(now.good)
        if not _followed(now, error):
            file = getattr(now.case, slot)
            now.refused[slot] = Refusal(file.name, error, file)
            now.case = _without(now.case, slot, now.tried.pop(slot))
    now.good = held(now.case)
    if "readings" in now.tried:
        _take_head(result)
    now.tried.clear()
    now.follow = False
    now.steps = now.steps.settled(now.case, job())
    if not is_large(now.good.road_test):
        if all(result is not each for each in now.results):
            now.results = (*now.results[1 - RESULTS :], result)
    elif not now.gives_back:
        now.gives_back = True
        weakref.finalize(now, give_back_soon)  # a log's bytes go with the session
    return result


def _result(now: Session) -> Diagnosis | tuple[str, AtleakError]:
    """Return the diagnosis of the job as chosen, or what of it cannot be used, and why."""
    try:
        return diagnosis_of(now.case)
    except AtleakError as error:
        return _at_fault(now, error), error


def _take_head(diagnosis: Diagnosis) -> None:
    """Bring what the head of a new sheet says of the job into the record, where that says nothing; tell what."""
    before = job()
    filled = with_sheet(before, diagnosis.readings) or before
    taken = taken_from_sheet(before, filled)
    if taken:
        put_job(filled)
        session().notices += (
            lambda say: say("done.head_taken", names=", ".join(say(f"head.{name}") for name in taken)),
        )


def _followed(now: Session, error: AtleakError) -> bool:
    """Choose the controller that the head of a new sheet names, where the catalogue holds it; return whether it did."""
    first = next(iter(getattr(error, "problems", (error,))))
    known = {name.casefold(): name for name in catalogue_names("controller")} if now.follow else {}
    name = known.get(first.named.casefold()) if isinstance(first, OtherControllerError) else None
    if name is None:
        return False
    now.follow = False
    pick("controller", name)
    now.notices += (lambda say: say("done.head_chose", name=name),)
    return True


def _without(case: PageCase, slot: str, before: PageCase) -> PageCase:
    """Return the job without a file that cannot be used: with the one before it, or all of the sample again.

    The sample comes back only where nothing else was given or chosen since.
    """
    if not before.sample:
        return replace(case, **{name: getattr(before, name) for name in (slot, *FITTED[slot])})
    case = replace(case, **FITTED[slot]).with_files({slot: None})
    others = any(getattr(case, name) for name in FILES)
    return case if others or any(getattr(case, name) != getattr(before, name) for name in SLOTS) else before


def _at_fault(now: Session, error: AtleakError) -> str:
    """Return the file that is tried and cannot be used, or which kind of choice cannot be."""
    files = {
        PressureTableError: ("pressures", "readings"),
        VacuumTableError: ("vacuum",),
        FlowTableError: ("flows",),
        ReadingsError: ("readings",),
        RoadTestError: ("road_test",),
    }
    slots = next((slots for kind, slots in files.items() if isinstance(error, kind)), None)
    if slots is None and isinstance(error, CatalogueError):
        return "catalogue"
    new = (slot for slot in slots or FILES if slot in now.tried)
    return next((slot for slot in new if getattr(now.tried[slot], slot) != getattr(now.case, slot)), "settings")
