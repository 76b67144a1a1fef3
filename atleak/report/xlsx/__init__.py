"""Write a diagnosis as an Excel workbook that an auditor can recompute.

Diameters, clearances, flows, shares and verdicts are live formulas with cached values: changing a diameter changes what
follows from it. Text is always written as text: nothing a user typed becomes a formula or a link.
"""

from __future__ import annotations

import datetime as dt
from collections.abc import Callable

import xlsxwriter

from atleak.common.sentences import Sentence
from atleak.common.style import DEFAULT_PAPER, find_paper
from atleak.common.wording import wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.measurements.job_card import Job
from atleak.report.json.diagnosis import FORMAT, head_record
from atleak.report.sheets.paging import UNDATED, workbook
from atleak.report.tables.assumed import assumed_section
from atleak.report.tables.evidence import printed_sections
from atleak.report.tables.road_test import event_table
from atleak.report.tables.what_was_read import WHAT_WAS_READ
from atleak.report.xlsx.book import ReportBook
from atleak.report.xlsx.circuits import CIRCUITS
from atleak.report.xlsx.conditions import CONDITIONS
from atleak.report.xlsx.constants import CONSTANTS
from atleak.report.xlsx.estimate import ESTIMATE_SHEET, write_estimate
from atleak.report.xlsx.lands import LANDS_SHEET, LiveSheets
from atleak.report.xlsx.page import SheetPage, widths_for, write_sections
from atleak.report.xlsx.reader_units import in_reader_units
from atleak.report.xlsx.readings import DIRECTIONS_SHEET, READINGS
from atleak.report.xlsx.road_sheet import ROAD_EVENTS, ROAD_TEST, RoadSheets, write_gauges
from atleak.report.xlsx.road_sheet import ROAD_SHEET as GAUGES
from atleak.report.xlsx.rules import LIMITS_SHEET, RULES
from atleak.report.xlsx.sheets import Sheets, write_what_was_read
from atleak.report.xlsx.uncertainty import BUDGET, INSTRUMENTS_SHEET
from atleak.version import __version__

__all__ = ["report_workbook", "write_workbook"]


def write_workbook(
    diagnosis: Diagnosis,
    job: Job | None = None,
    *,
    language: str = "en",
    units: str = "metric",
    paper: str = DEFAULT_PAPER,
) -> bytes:
    """Return the bytes of the workbook.

    Parameters
    ----------
    diagnosis
        the frozen result; nothing is computed from it that it does not hold.
    job
        what the workshop wrote down; what is not filled in is left out.
    language
        one of `atleak.common.wording.languages`.
    units
        one of `atleak.common.units.SYSTEMS`, of every cell and sentence; formulas convert what they
        take and give.
    paper
        one of `atleak.common.style.PAPERS`, for printing.

    Raises
    ------
    InputError
        if there is no such paper, language or system of units.
    """
    filled, size, say = job or Job(), find_paper(paper), wording(language, units)
    created = dt.datetime.combine(filled.date, dt.time()) if filled.date else UNDATED
    return report_workbook(
        lambda book: _write(ReportBook(book, size, say), diagnosis, filled),
        say.sentence(Sentence("Valve body leakage")),
        created,
    )


def report_workbook(write: Callable[[xlsxwriter.Workbook], None], title: str, created: dt.datetime = UNDATED) -> bytes:
    """Return the bytes of a workbook that reports something, marked as made by this version of atleak."""
    made_by = {"author": "", "comments": f"atleak {__version__}"}
    return workbook(write, title, mark="report workbook", created=created, properties=made_by)


def _write(book: ReportBook, diagnosis: Diagnosis, job: Job) -> None:
    record = {"format": FORMAT, "atleak": __version__, **head_record(diagnosis)}
    live = LiveSheets(diagnosis, book.say)
    rest = Sheets(book, diagnosis, record, job, live)
    summary = book.sheet(Sentence("Summary"))
    rest.write_summary(summary)
    if not diagnosis.without_sheet:
        _write_unit(book, diagnosis, live, rest)
    if diagnosis.pressures is not None:
        write_gauges(book, book.sheet(GAUGES, frozen=(1, 2)), diagnosis)
    sections = list(printed_sections(diagnosis, book.say))
    if sections:
        write_sections(book, book.sheet(Sentence("Before opening")), sections)
    if diagnosis.log is not None:
        road = RoadSheets(book, diagnosis, diagnosis.log)
        road.write(book.sheet(ROAD_TEST))
        events = book.sheet(ROAD_EVENTS, frozen=(1, 0))
        if diagnosis.log.events:
            table = event_table(diagnosis.log.events, book.say)
            SheetPage(book, events, widths_for([table])).printed(0, table)
        else:
            book.put(events, 0, 0, book.say("findings.no_events"))
    if not diagnosis.without_sheet:
        live.totals.write(book, book.sheet(CONDITIONS, frozen=(1, 2)))
        live.limits.write(book, book.sheet(LIMITS_SHEET, frozen=(1, 1)))
        live.constants.write(book, book.sheet(CONSTANTS, frozen=(1, 1)))
    write_sections(book, book.sheet(Sentence("Assumed")), [assumed_section(diagnosis, book.say)])
    if job.estimated and not diagnosis.without_sheet:
        write_estimate(book, book.sheet(ESTIMATE_SHEET, frozen=(1, 1)), diagnosis, job)
    if not job.empty:
        rest.write_job(book.sheet(Sentence("Job"), landscape=False))
    rest.write_messages(book.sheet(Sentence("Messages"), frozen=(1, 0)))
    rest.write_provenance(book.sheet(Sentence("Provenance"), landscape=False))
    in_reader_units(book)
    summary.activate()


def _write_unit(book: ReportBook, diagnosis: Diagnosis, live: LiveSheets, rest: Sheets) -> None:
    """Write the sheets on the lands: a road test alone has none."""
    live.write_lands(book, book.sheet(LANDS_SHEET, frozen=(1, 3)))
    rest.write_matrix(book.sheet(Sentence("Land by condition"), frozen=(1, 3)))
    for at in live.conditions:
        live.gaps.at[at.prefix].write(book, book.sheet(at.sheet, frozen=(1, 2)), printed=False)
    if live.circuits.sheet.items:
        live.circuits.write(book, book.sheet(CIRCUITS, frozen=(1, 3)))
    live.rules.write(book, book.sheet(RULES, frozen=(1, 3), landscape=False))
    if diagnosis.readings:
        live.readings.write(book, book.sheet(READINGS, frozen=(1, 2)))
    if diagnosis.readings and diagnosis.readings.sheets:
        write_what_was_read(book, book.sheet(WHAT_WAS_READ), diagnosis.readings.sheets)
    if live.directions.sheet.items:
        live.directions.sheet.write(book, book.sheet(DIRECTIONS_SHEET, frozen=(1, 2)), printed=False)
    if live.instruments is not None and live.budget is not None:
        live.instruments.write(book, book.sheet(INSTRUMENTS_SHEET, frozen=(1, 1)))
        live.budget.write(book, book.sheet(BUDGET))
