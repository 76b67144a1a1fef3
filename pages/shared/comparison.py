"""Choose two jobs, compare them, and show what changed."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import streamlit as st

from atleak.channel_formulas import channel_scales
from atleak.comparison import Comparison, LandComparison
from atleak.diagnosis import Diagnosis
from atleak.figures import comparison_figures as figures
from atleak.job.file import read_job_file
from atleak.job.parts import JobFile
from atleak.jobs.book import JobRow
from atleak.jobs.compared import ComparedJobs, compare_jobs, compared_record
from atleak.jobs.search import Query
from atleak.jobs.unit_visits import unit_of_job
from atleak.paper import PAPERS
from atleak.report.pdf.comparison import write_comparison_pdf
from atleak.verdicts import Verdict
from atleak.views.comparison_rows import condition_rows, event_rows, land_rows
from atleak.views.comparison_words import changed_sentence, event_name, total_sentence, verdicts_sentence
from atleak.views.diagnosis_record import to_json
from atleak.wording import languages, signed, wording
from pages.shared import files, show
from pages.shared.book import book, job_id
from pages.shared.cases import diagnosis_of, opened_case, result_key
from pages.shared.show import plain
from pages.shared.state import job, session

THIS, FILE = "this job", "a job file …"
LISTED = 200  # most jobs of the book to choose from
DRAWN = 20  # most lands in the table and the figure at the head
DIGITS = {
    **dict.fromkeys(("Before [µm]", "After [µm]", "Wear before [%]", "Wear after [%]"), 1),
    **dict.fromkeys(("Share before [%]", "Share after [%]"), 2),
}
Chosen = tuple[JobFile, JobFile]


def choose() -> Chosen | None:
    """Ask for both jobs; None while one is missing.

    Unless the address names them (``?before=ID&after=ID``), the later one is this session's job, and the earlier one
    the visit of its unit before it.

    Raises
    ------
    AtleakError
        a job file that is none, or a job that is not in the book.
    """
    rows = _offered()
    earlier = _visit_before(rows)
    sides = []
    for column, side, usual in zip(st.columns(2), ("before", "after"), (earlier or FILE, THIS), strict=True):
        with column:
            options = [THIS, FILE, *(id for id in rows if id != job_id())]
            asked = st.query_params.get(side)
            start = asked if asked in options else THIS if asked is not None and asked == job_id() else usual
            chosen = st.selectbox(
                side.capitalize(),
                options,
                options.index(start),
                format_func=partial(_label, rows),
                key=f"compare-{side}-{start}",
            )
            sides.append(_job(side, chosen))
    first, second = sides
    return None if first is None or second is None else (first, second)


def _offered() -> dict[str, JobRow]:
    """Return the jobs to choose from: the latest, and however old all of the units of this job and of those named."""
    jobs = book()
    asked = [id for side in ("before", "after") if (id := st.query_params.get(side)) is not None]
    for id in asked:
        jobs.version(id)  # one that the book does not have is refused
    named = (unit_of_job(jobs, id) for id in (*asked, job_id()) if id is not None)
    rows = jobs.rows(Query(limit=LISTED))
    for unit in dict.fromkeys(each for each in named if each is not None):
        rows += jobs.rows(Query(unit=unit, archived=None, limit=None))
    return {row.id: row for row in rows}


def _visit_before(rows: dict[str, JobRow]) -> str | None:
    """Return the id of the job of the same unit's visit before this session's job; None without one."""
    this = rows.get(job_id() or "")
    if this is None:
        return None
    others = [row for row in rows.values() if (row.unit, row.controller) == (this.unit, this.controller)]
    others = [row for row in others if row.visit != this.visit and row.archived_at is None]
    dated = [row for row in others if row.date is not None and (this.date is None or row.date <= this.date)]
    latest = max(dated or others, key=lambda row: (row.date is not None, row.date, row.changed_at), default=None)
    return None if latest is None else latest.id


def _label(rows: dict[str, JobRow], chosen: str) -> str:
    row = rows.get(chosen)
    if row is None:
        return chosen
    named = [row.number, str(row.date or ""), row.plate or row.vin or row.serial, row.customer, row.controller]
    return " · ".join([*filter(None, named), signed(Verdict(row.verdict))])


def _job(side: str, chosen: str) -> JobFile | None:
    if chosen == THIS:
        return JobFile(job(), session().good, {}, "this job")
    if chosen != FILE:
        return book().load(chosen).file
    given = st.file_uploader(f"Job file {side}", ["zip"], key=f"compare-file-{side}")
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


@st.cache_resource(max_entries=6, show_spinner="Comparing …")
def _compared(key: str, _jobs: Chosen, _diagnoses: tuple[Diagnosis, Diagnosis]) -> ComparedJobs:
    return compare_jobs(*_jobs, _diagnoses)


def sentence(comparison: Comparison) -> str:
    """Return both verdicts and what changed, in markdown."""
    say = wording("en")
    more = [changed_sentence(comparison, say), total_sentence(comparison, say)]
    return " ".join([f"**{plain(verdicts_sentence(comparison, say))}**", *(plain(each) for each in more if each)])


def lands(comparison: Comparison) -> Sequence[LandComparison]:
    """Return the lands that are shown first: those flagged at either visit, then others that changed."""
    return [*comparison.flagged, *(land for land in comparison.changed if not land.flagged)][:DRAWN]


def land_table(comparison: Comparison, shown: Sequence[LandComparison]) -> None:
    """Show lands side by side, columns without any value left out."""
    rows = land_rows(comparison, shown)
    filled = [name for name in rows[0] if name == "Verdict" or any(row[name] is not None for row in rows)]
    show.verdict_table([{name: row[name] for name in filled} for row in rows], DIGITS)


def totals(comparison: Comparison) -> None:
    """Show totals and the pressures that changed, all of them in a fold."""
    rows = condition_rows(comparison, brief=True)
    if not rows:
        st.write("No operating point was judged at both visits.")
        return
    show.table(rows)
    st.caption(
        "After: where the two jobs were judged by other choices, the unit after by those of the job before. Changed: "
        "by more than clearances and instruments can be off, at the same fluid, temperature and pump."
    )
    with st.expander("Every pressure at every operating point"):
        show.table(condition_rows(comparison))


def logs(comparison: Comparison) -> None:
    """Show the two road tests over one another, event by event, or say which is missing."""
    both = comparison.logs
    if both is None:
        missing = [name for name in ("before", "after") if getattr(comparison, name).log is None]
        st.write(f"No road test in the job {' nor in the job '.join(missing)}: nothing to lay over one another.")
        return
    matched = both.matched
    if matched:
        say = wording("en")
        pair = st.selectbox("Event", matched, format_func=lambda each: event_name(each, say), key="compare-event")
        scales = channel_scales(both.before.road_test, say)
        show.chart(figures.logs_over_one_another(both, pair, scales), "logs")
        st.caption("Dashed: before; full: after; both from the start of the event in their own log (dotted).")
    else:
        st.write("No event is in both road tests: there is nothing to align them by.")
    if both.pairs:
        show.table(event_rows(both))


def downloads(found: ComparedJobs) -> None:
    """Offer the page for the customer, and the record."""
    columns = st.columns(2)
    named = {language: wording(language).texts["language"] for language in languages()}
    language = columns[0].selectbox(
        "Language", list(named), list(named).index("en"), named.__getitem__, key="compare-language"
    )
    paper = columns[1].selectbox(
        "Paper", list(PAPERS), format_func=lambda name: PAPERS[name].label, key="compare-paper"
    )
    printed = partial(
        write_comparison_pdf,
        found.comparison,
        found.before.job,
        found.after.job,
        language=language,
        paper=paper,
    )
    name = files.named("before_and_after", found.after.job.number)
    with st.container(horizontal=True):
        st.download_button("Page for the customer (PDF)", printed, f"{name}.pdf", on_click="ignore")
        st.download_button("JSON", lambda: to_json(compared_record(found)), f"{name}.json", on_click="ignore")
