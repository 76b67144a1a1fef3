"""Keep the job of this session in the job book, and bring a job of the book, or of a fleet, into the session."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import streamlit as st

from atleak.analysis.record_doubts import with_sheet
from atleak.common.errors import AtleakError, ChangedElsewhere, ErasedElsewhere, FleetError
from atleak.common.files import home
from atleak.common.sentences import Sentence
from atleak.job.parts import job_parts
from atleak.job.result import judged_otherwise
from atleak.report.json.diagnosis import diagnosis_record
from pages.shared import reader
from pages.shared.cases import case_with_columns, diagnosis_of, held, opened_case
from pages.shared.state import (
    JOB,
    OF_FLEET,
    InBook,
    Refusal,
    Session,
    job,
    left,
    session,
    show_job,
    state_of_job,
    unsaved,
    way_back,
)
from pages.shared.undo import Left, Step, Steps, Told

if TYPE_CHECKING:
    from atleak.fleet.sources import KeptUnit
    from atleak.job_book.book import Book


def book() -> Book:
    """Return the job book; its database is imported with the first job that is kept or looked up.

    Raises
    ------
    BookError
        where it cannot be opened.
    """
    from atleak.common.files import DATABASE_URL

    opened: Book = _book(os.environ.get(DATABASE_URL) or str(home()))
    return opened


@st.cache_resource(max_entries=4, show_spinner=False)
def _book(where: str) -> Any:
    from atleak.job_book.book import open_book

    return open_book()


def job_id() -> str | None:
    """Return the id under which the job of this session is in the book; None while nothing of it is."""
    return session().in_book.id


def follow_address() -> None:
    """Open the job that the address names, where that is another one: after a reload, in a second tab, going back."""
    in_book = session().in_book
    if (wanted := st.query_params.get(JOB)) is not None:
        if wanted not in (in_book.id, in_book.unknown):
            open_from_book(wanted)
    elif (unit := st.query_params.get(OF_FLEET)) is not None and unit not in (in_book.of_fleet, in_book.unknown):
        _open_unit(unit)


def open_from_book(id: str, steps: Steps | None = None) -> bool:
    """Open a job of the book in this session, with fresh widgets; return whether that was possible, else say why.

    Parameters
    ----------
    steps
        of the job that can be taken back and done again; none unless given, but for the way back to a job of which
        something is not in the book.
    """
    now = session()
    name = reader.say()("done.job_of_book", id=id)
    if steps is None:
        steps = Steps()
        if unsaved():
            steps = way_back(lambda say: say("done.opened", name=say("done.job_of_book", id=id)))
    try:
        stored = book().load(id)
        case = held(replace(opened_case(stored.file.case), sample=stored.sample))
        parts = job_parts(diagnosis_of(case), stored.file.job, case_with_columns(case))
        otherwise = judged_otherwise(stored.file.result, parts.result)
    except AtleakError as error:
        now.refused["job"] = Refusal(name, error)
        now.in_book.unknown = id
        return False
    in_book = InBook(id, stored.version, archived=stored.archived_at is not None, result_by=stored.result_by)
    in_book.judged_otherwise = otherwise
    show_job(case, stored.file.job, in_book, steps)
    in_book.state = state_of_job()
    return True


def undo() -> None:
    """Take the last step back; for a callback."""
    steps = session().steps
    _travel(steps.past[-1], replace(steps, past=steps.past[:-1]), back=True)


def redo() -> None:
    """Do again what was taken back last; for a callback."""
    steps = session().steps
    _travel(steps.future[-1], replace(steps, future=steps.future[:-1]), back=False)


def _travel(step: Step | Left, rest: Steps, *, back: bool) -> None:
    """Take a step back, or do it again, and keep the way round; ``rest`` are the job's other steps."""

    def with_way(steps: Steps, way: Step | Left) -> Steps:
        return replace(steps, future=(*steps.future, way)) if back else replace(steps, past=(*steps.past, way))

    if isinstance(step, Step):
        case, record = step.taken_back(session().case, job())
        try:
            diagnosis_of(case)
        except AtleakError:
            case = step.case  # as what was chosen since fits only what the step did
        show_job(case, record, session().in_book, with_way(rest, step.turned))
        return
    steps = with_way(_without_erased(step), left(step.done, rest))
    if not step.saved:
        show_job(step.case, step.record, step.in_book, steps)
    elif step.in_book.id is not None and not open_from_book(step.in_book.id, steps):
        session().steps = rest


def _without_erased(step: Left) -> Steps:
    """Return the steps of a job that was left; none where they would bring back whom somebody has erased since."""
    try:
        if step.in_book.id is not None:
            book().refuse_erased(step.in_book.id, step.in_book.version)
    except ErasedElsewhere:
        return Steps()
    except AtleakError:  # said where the job is opened or saved
        pass
    return step.steps


def keep(page: str) -> bool:
    """Save the job where it has changed since it was saved, the sample only when asked; return whether there is news.

    Parameters
    ----------
    page
        the page that was drawn: the browser drops what names the job from the address where another page is chosen.
    """
    now = session()
    in_book = now.in_book
    with in_book.saving:
        before, state = in_book.news, state_of_job()
        if in_book.state is None and not in_book.new:
            in_book.state = state  # as it was opened, its widgets drawn
        name, of_job = (OF_FLEET, in_book.of_fleet) if in_book.id is None else (JOB, in_book.id)
        if of_job and (st.query_params.get(name), in_book.page) != (of_job, page):
            st.query_params[name] = of_job
        in_book.page = page
        with _faults_said(in_book):
            if state == in_book.state:
                id = None if in_book.conflict is not None else in_book.id
                if id is not None and book().version(id) != in_book.version:
                    book().refuse_erased(id, in_book.version)
                    was = Sentence("this job was changed elsewhere; what you see is as it was before")
                    in_book.conflict = ChangedElsewhere(was)  # though it is only looked at here
            elif in_book.conflict is None and (in_book.id is not None or not now.good.sample):
                _save(now, in_book.id, in_book.version)  # the sample's only once somebody has it kept
        return in_book.news != before


@contextmanager
def _faults_said(in_book: InBook) -> Iterator[None]:
    """Keep what goes wrong with saving, to be said at the head of the page."""
    try:
        yield
        in_book.fault = None
    except ChangedElsewhere as error:
        in_book.conflict = error
    except AtleakError as error:
        in_book.fault = error


def _save(now: Session, id: str | None, version: int | None) -> None:
    in_book, record, state = now.in_book, job(), state_of_job()
    parts = job_parts(diagnosis_of(now.good), record, case_with_columns(now.good))
    saved = book().save(parts, id=id, version=version, sample=now.good.sample)
    in_book.id, in_book.version, in_book.state = saved.id, saved.version, state
    in_book.new, in_book.conflict, in_book.of_fleet = False, None, ""
    st.query_params.pop(OF_FLEET, None)
    st.query_params[JOB] = saved.id


def save_anyway(*, as_another: bool) -> None:
    """Save this session's job over what somebody else saved meanwhile, or as another one beside it; for a callback."""
    now = session()
    with now.in_book.saving, _faults_said(now.in_book):
        held, now.in_book.conflict = now.in_book.id, None
        if held is not None:
            book().refuse_erased(held, now.in_book.version)
        id = None if as_another else held
        _save(now, id, None if id is None else book().version(id))


def keep_sample() -> None:
    """Put the sample job, as it was changed here, into the book; for a callback."""
    with session().in_book.saving, _faults_said(session().in_book):
        _save(session(), None, None)


def show_theirs() -> None:
    """Open what somebody else saved meanwhile; for a callback."""
    if (id := job_id()) is not None:
        open_from_book(id)


# --- units of a fleet: the address names one as long as nothing of it is in the book


def show_unit(kept: KeptUnit, folder: str, *, done: Told | None = None) -> None:
    """Show the own job of a unit; the job book has it once it is changed.

    Parameters
    ----------
    folder
        id of the folder of results, as addresses name it.
    done
        what was done, by which the way back to the job shown before is offered; no way back unless given.

    Raises
    ------
    AtleakError
        it cannot be opened any more.
    """
    from atleak.fleet.columns import HASH

    given, record = kept.opened()
    case = opened_case(given)
    diagnosis = diagnosis_of(case)
    result = diagnosis_record(diagnosis)
    result = {**result, "conditions": [{**each, "circuits": []} for each in result["conditions"]]}  # as a row holds it
    otherwise = judged_otherwise(kept.result, result, numbers=True)
    in_book = InBook(result_by=kept.unit["atleak"], judged_otherwise=otherwise, of_fleet=f"{folder}-{kept.unit[HASH]}")
    steps = way_back(done) if done is not None else Steps()
    show_job(case, with_sheet(record, diagnosis.readings) or record, in_book, steps)


def _open_unit(wanted: str) -> None:
    """Open the unit of a fleet that the address names; one from the book has no job of its own beside the book's."""
    from atleak.fleet.units import BOOK

    now = session()
    try:
        kept, folder = _kept(wanted)
        reference = kept.unit["reference"]
        if not reference.startswith(BOOK):
            show_unit(kept, folder)
        elif not open_from_book(reference.removeprefix(BOOK)):
            now.in_book.unknown = wanted
    except AtleakError as error:
        now.refused["job"] = Refusal(reader.say()("fleet.of_address"), error)
        now.in_book.unknown = wanted


def _kept(wanted: str) -> tuple[KeptUnit, str]:
    from atleak.fleet.folder import known_folders
    from atleak.fleet.results import Results
    from atleak.fleet.sources import kept_unit

    id, _, sha256 = wanted.partition("-")
    folder = next((each for each in known_folders() if each.id == id), None)
    if folder is None:
        problem = Sentence("the folder of results that the address names is not known on this computer")
        raise FleetError(problem, expected=Sentence("the folder that 'atleak fleet run' was given for its results"))
    return kept_unit(Results.open(folder.path), sha256), folder.id
