"""Choose two jobs, compare them, and show what changed."""

from __future__ import annotations

from functools import partial

import streamlit as st

from atleak.analysis.changes import Comparison
from atleak.analysis.record_doubts import with_sheet
from atleak.common.errors import AtleakError
from atleak.common.verdicts import Verdict
from atleak.common.wording import Wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.job.parts import JobFile
from atleak.job.zip_file import read_job_file
from atleak.job_book.book import JobRow
from atleak.job_book.compared_jobs import ComparedJobs, compare_jobs, compared_record
from atleak.job_book.search import Query
from atleak.job_book.unit_history import unit_of_visit
from atleak.measurements.job_card import Job
from atleak.report.charts.comparison_figures import logs_over_one_another
from atleak.report.json.diagnosis import to_json
from atleak.report.pdf.comparison import write_comparison_pdf
from atleak.report.tables.comparison import compared_event_name
from atleak.report.tables.road_test import channel_scales
from pages.shared import fields, font_form, reader, show
from pages.shared.book import book, job_id
from pages.shared.cases import PageCase, diagnosis_of, opened_case, result_key
from pages.shared.state import KEPT, job, session, sheet_beside

THIS, FILE, SHEET = "this_job", "job_file", "sheet"  # beside the ids of jobs
LISTED = 200  # most jobs of the book to choose from
DRAWN = 20  # most lands in the first table and its chart
Chosen = tuple[JobFile, JobFile]


def choose() -> Chosen | None:
    """Ask for both jobs; None while one is missing.

    Unless the address names them (``?before=ID&after=ID``), the later one is this session's job, and the earlier one
    the sheet that its own took the place of, unless that is dated later, or the visit of its unit before it.

    Raises
    ------
    AtleakError
        a job file that is none, or a job that is not in the book.
    """
    say, rows = reader.say(), _offered()
    earlier, _ = _visits_beside(rows)
    both, sheet, sides = [earlier or FILE, THIS], sheet_beside(), []
    try:
        if sheet is not None:
            read = [diagnosis_of(case).readings for case in (_of_sheet(), session().good)]
            dates = [each.date for each in read if each is not None and each.date is not None]
            both = [THIS, SHEET] if dates[1:] and dates[0] > dates[1] else [SHEET, THIS]
    except AtleakError as error:  # of another valve body, say
        st.warning(show.plain(error))
        sheet = None
    for column, side, usual in zip(st.columns(2), ("before", "after"), both, strict=True):
        with column:
            options = [THIS, *[SHEET] * (sheet is not None), FILE, *(id for id in rows if id != job_id())]
            asked = st.query_params.get(side)
            start = asked if asked in options else THIS if asked is not None and asked == job_id() else usual
            names = {each: _label(rows, "" if sheet is None else sheet.name, say, each) for each in options}
            sides.append(_job(side, fields.one_of(say(f"compare.{side}"), names, f"compare-{side}-{start}", start)))
    first, second = sides
    return None if first is None or second is None else (first, second)


def _offered() -> dict[str, JobRow]:
    """Return the jobs to choose from: the latest, and however old all of the units of this job and of those named."""
    jobs = book()
    asked = [id for side in ("before", "after") if (id := st.query_params.get(side)) is not None]
    for id in asked:
        jobs.version(id)  # one that the book does not have is refused
    named = (unit_of_visit(jobs, id) for id in (*asked, job_id()) if id is not None)
    rows = jobs.rows(Query(limit=LISTED))
    for unit in dict.fromkeys(each for each in named if each is not None):
        rows += jobs.rows(Query(unit=unit, archived=None, limit=None))
    return {row.id: row for row in rows}


def _visits_beside(rows: dict[str, JobRow]) -> tuple[str | None, str | None]:
    """Return the ids of the jobs of this unit's visits before and after this session's; None without one."""
    this = rows.get(job_id() or "")
    if this is None:
        return None, None
    others = [row for row in rows.values() if (row.unit, row.controller) == (this.unit, this.controller)]
    others = [row for row in others if row.visit != this.visit and row.archived_at is None]
    others.sort(key=lambda row: row.order)
    before = [row.id for row in others if row.order < this.order]
    return before[-1] if before else None, next((row.id for row in others if row.id not in before), None)


def beside() -> Comparison | None:
    """Return this session's job beside the visit of its unit before it, else after it; None without another."""
    try:
        jobs, here = book(), job_id()
        unit = None if here is None else unit_of_visit(jobs, here)
        rows = [] if unit is None else jobs.rows(Query(unit=unit, limit=None))
        before, after = _visits_beside({row.id: row for row in rows})
        sides = [_job("", each) for each in (before, THIS, None if before else after) if each is not None]
        first, second = sides if len(sides) > 1 else (None, None)
        return None if first is None or second is None else compared(first, second).comparison
    except AtleakError:  # said in full where two visits are compared
        return None


def _label(rows: dict[str, JobRow], sheet: str, say: Wording, chosen: str) -> str:
    row = rows.get(chosen)
    if row is None:
        return say(f"compare.{chosen}", name=sheet)
    day, mileage = row.date or row.made_on, row.mileage_km
    named = [
        "" if day is None else say.date(day),
        row.plate or row.vin or row.serial,
        "" if mileage is None else say.quantity(mileage, "distance", 0),
        row.number or row.id[:6],
        row.customer,
        row.controller,
    ]
    return " · ".join([*filter(None, named), say.signed(Verdict(row.verdict))])


def _of_sheet() -> PageCase:
    return PageCase(**{name: getattr(session().good, name) for name in KEPT}, readings=sheet_beside())


def _job(side: str, chosen: str) -> JobFile | None:
    if chosen == THIS:
        return JobFile(job(), session().good, {}, reader.say()("compare.this_job"))
    if chosen == SHEET:
        case = _of_sheet()
        name = "" if case.readings is None else case.readings.name
        return JobFile(with_sheet(None, diagnosis_of(case).readings) or Job(), case, {}, name)
    if chosen != FILE:
        return book().load(chosen).file
    given = st.file_uploader(reader.say()(f"compare.file_{side}"), ["zip"], key=f"compare-file-{side}")
    return None if given is None else read_job_file(given.getvalue(), name=given.name)


def compared(before: JobFile, after: JobFile) -> ComparedJobs:
    """Return the comparison of two jobs, kept as long as neither changes.

    Raises
    ------
    AtleakError
        a job that cannot be diagnosed; two different valve bodies.
    """
    cases = [opened_case(each.case) for each in (before, after)]
    records = [each.job.model_dump_json(exclude_defaults=True) for each in (before, after)]
    diagnoses = diagnosis_of(cases[0]), diagnosis_of(cases[1])
    return _compared(repr(([result_key(case) for case in cases], records)), (before, after), diagnoses)


@st.cache_resource(max_entries=2, scope="session", show_spinner="…")
def _compared(key: str, _jobs: Chosen, _diagnoses: tuple[Diagnosis, Diagnosis]) -> ComparedJobs:
    return compare_jobs(*_jobs, _diagnoses)


def draw_logs(comparison: Comparison) -> None:
    """Draw the two road tests over one another, from the start of an event that is chosen; nothing without a pair."""
    say, both = reader.say(), comparison.logs
    if both is None or not both.matched:
        return
    names = {number: compared_event_name(each, say) for number, each in enumerate(both.matched)}
    pair = both.matched[fields.one_of(say("columns.event"), names, "compare-event")]
    scales = channel_scales(both.before.road_test, say)
    show.chart(logs_over_one_another(both, pair, scales, say), "logs")
    st.caption(say("compare.logs_note"))


def downloads(found: ComparedJobs) -> None:
    """Offer the page for the customer, and the record."""
    say, (language, paper) = reader.say(), reader.pick_print("compare")
    printed = partial(
        write_comparison_pdf,
        found.comparison,
        found.before.job,
        found.after.job,
        language=language,
        paper=paper,
        units=say.units,
    )
    name = show.named("before_and_after", found.after.job.number)
    font_form.draw_missing([found.before.job, found.after.job])
    pdf, record = font_form.printing(printed), lambda: to_json(compared_record(found))
    show.downloads(name, "compare", {say("compare.page"): ("pdf", pdf), "JSON": ("json", record)}, {})
