"""Write a fleet's summary as an Excel workbook: an overview, then one table for each thing that was counted.

Numbers are numbers, in the units that the headings name; what each column means stands in a note on its heading and on
the last sheet. Text is always written as text: nothing that somebody typed becomes a formula or a link.
"""

from __future__ import annotations

import datetime as dt
import io
import math
from collections.abc import Iterator
from typing import Any

import xlsxwriter
from xlsxwriter.worksheet import Worksheet

from atleak.fleet.summary_excel_charts import add_charts, add_verdicts, rows_of_verdicts
from atleak.fleet.summary_sheets import SheetColumn, SummarySheet, sheets_of
from atleak.fleet.summary_words import TERMS, FleetWords, called
from atleak.fleet.summed import FleetSummary, ValveBody
from atleak.look import DATA_BAR, HEADING
from atleak.paper import DEFAULT_PAPER, find_paper
from atleak.report.paging import LINE_OF_A_BOOK, row_height
from atleak.report.xlsx import WORKBOOK_OPTIONS
from atleak.report.xlsx.book import Book
from atleak.report.xlsx.summary_page import SummaryPage
from atleak.system.marks import PROPERTY, sealed, unsealed
from atleak.verdicts import VERDICTS, Verdict
from atleak.version import __version__
from atleak.wording import wording

_UNDATED = dt.datetime(2000, 1, 1)  # the same summary gives the same bytes
_DATE = "yyyy-mm-dd"
_LEADING = 5  # pairs of each valve body in the overview
_DIFFERENCES = 5  # most that the overview tells
_ACROSS = 240  # characters that a page has room for side by side, at six tenths of their size
_SIDE = 0.4  # [in] margins
_HIGHEST = 409.0  # [pt] that Excel allows
_BARS = "pair_replace.percent"  # column of the pairs that has bars behind its numbers


def write_summary_workbook(
    summary: FleetSummary, *, language: str = "en", units: str = "metric", paper: str = DEFAULT_PAPER
) -> bytes:
    """Return the bytes of the workbook.

    Parameters
    ----------
    summary
        the fleet in numbers; nothing is computed from it that it does not hold.
    language
        one of `atleak.wording.languages`.
    units
        one of `atleak.unit_systems.SYSTEMS`.
    paper
        one of `atleak.paper.PAPERS`, for printing.

    Raises
    ------
    InputError
        if there is no such paper, language or system of units.
    """
    size, say = find_paper(paper), wording(language, units)
    words, target = FleetWords(summary, say), io.BytesIO()
    with xlsxwriter.Workbook(target, WORKBOOK_OPTIONS) as workbook:
        workbook.set_properties(
            {
                "title": say("fleet_summary.title"),
                "author": "",
                "comments": f"atleak {__version__}",
                "created": _UNDATED,
            }
        )
        workbook.set_custom_property(PROPERTY, unsealed("report workbook"))
        _Writer(Book(workbook, size, say), words).write()
    return sealed(target.getvalue())


class _Writer:
    """Writes the sheets of one summary."""

    def __init__(self, book: Book, words: FleetWords) -> None:
        self.book, self.words, self.say, self.summary = book, words, words.say, words.summary
        self.sheets = sheets_of(words)

    def write(self) -> None:
        """Write the overview, the tables, the charts and what everything means."""
        overview = self.book.sheet(self.say("fleet_sheets.overview"), protected=False)
        self._overview(overview)
        for sheet in self.sheets:
            self._table(sheet)
        if self.summary.bodies:
            charts = self.book.sheet(self.say("fleet_sheets.charts"), protected=False)
            add_charts(self.book, charts, self.words, self.sheets)
        self._meanings(self.book.sheet(self.say("fleet_sheets.meanings"), frozen=(1, 0), protected=False))
        overview.activate()

    # --- tables

    def _table(self, made: SummarySheet) -> None:
        book, last = self.book, len(made.rows)
        sheet = book.sheet(self.say(f"fleet_sheets.{made.name}"), frozen=(1, made.frozen), protected=False)
        headings = ((column.heading, width) for column, width in zip(made.columns, made.widths, strict=True))
        sheet.set_row(0, row_height(headings, bold=True, line=LINE_OF_A_BOOK))
        sheet.repeat_columns(0, made.frozen - 1)
        sheet.fit_to_pages(_pages_across(made), 0)
        sheet.set_margins(left=_SIDE, right=_SIDE)
        look: dict[str, Any] = {"bold": True, "bottom": 1, "text_wrap": True, "bg_color": HEADING}
        for number, column in enumerate(made.columns):
            sheet.set_column(number, number, made.widths[number])
            form = book.form(**look, align="right") if column.is_number else book.form(**look)
            book.put(sheet, 0, number, column.heading, form)
            if column.note:
                sheet.write_comment(0, number, column.note, {"x_scale": 2.0, "author": "atleak"})
            self._cells(sheet, number, column, made)
            if column.verdict:
                book.colour_words(sheet, (1, number), (last, number), VERDICTS)
            if column.key == _BARS:
                bar = {"type": "data_bar", "bar_color": DATA_BAR, "min_type": "num", "min_value": 0}
                sheet.conditional_format(1, number, last, number, bar)
        sheet.autofilter(0, 0, last, len(made.columns) - 1)

    def _cells(self, sheet: Worksheet, number: int, column: SheetColumn, made: SummarySheet) -> None:
        form = self.book.form(num_format=column.form) if column.form else self.book.form(text_wrap=column.wrapped)
        for line, row in enumerate(made.rows, start=1):
            value = column.cell(row)
            if column.wrapped:
                text = [(str(value), made.widths[number])]
                sheet.set_row(line, min(row_height(text, line=LINE_OF_A_BOOK), _HIGHEST))
            if isinstance(value, dt.date):
                moment = dt.datetime.combine(value, dt.time())
                sheet.write_datetime(line, number, moment, self.book.form(num_format=_DATE, align="left"))
            else:
                self.book.put(sheet, line, number, value, form)

    # --- overview

    def _overview(self, sheet: Worksheet) -> None:
        say, words, summary = self.say, self.words, self.summary
        headings = self._headings()
        page = SummaryPage(self.book, sheet, len(headings))
        self.book.put(sheet, 0, 0, say("fleet_summary.title"), self.book.title)
        sheet.set_row(0, 24)
        row = page.across(1, words.headline(), bold=True)
        findings = " ".join(words.findings())
        row = page.across(row, findings) if findings else row
        failed = sum(each.count for each in summary.errors)
        facts: list[tuple[str, Any]] = [
            (say("fleet_summary.fact_folder"), summary.folder),
            (say("fleet_summary.fact_units"), summary.counts.units),
            (say("fleet_summary.fact_judged"), summary.counts.judged),
            (say("fleet_summary.fact_visits"), summary.visits),
            (say("fleet_summary.fact_bodies"), len(summary.bodies)),
            (say("fleet_summary.fact_failed"), failed),
            (say("fleet_summary.fact_by"), words.heading() or say("fleet_summary.by_nothing")),
            (say("fleet_summary.fact_atleak"), summary.atleak),
        ]
        row = page.pairs(row + 1, facts) + 1
        page.headings(row, headings)
        for body in summary.bodies:
            for values in self._rows(body):
                row += 1
                for column, value in enumerate(values):
                    if isinstance(value, str):
                        page.text(row, column, value)
                    else:
                        form = self.book.form(num_format="#,##0" if column in _WHOLE else "0.0")
                        self.book.put(sheet, row, column, value, form)
        row += 2
        if summary.counts.units:
            add_verdicts(self.book, sheet, row, self.words, self.sheets)
            row += rows_of_verdicts(len(summary.bodies))
        for title, said in self._said():
            row = page.across(row, title, bold=True)
            for sentence in said:
                row = page.across(row, sentence)
            row += 1
        page.across(row, say("fleet_summary.more_on_sheets"))
        sheet.print_area(0, 0, row, page.last)

    def _headings(self) -> list[str]:
        say = self.say
        names = ("units", "judged", "pair", "measured", "pair_replace")
        units, judged, pair, measured, replace = (say(f"fleet_columns.{name}").replace("\n", " ") for name in names)
        low, high = (say("fleet_parts.of", what=replace, part=say(f"fleet_parts.{end}")) for end in ("low", "high"))
        body = say("fleet_columns.body")
        return [body, pair, units, judged, measured, replace, f"{replace} [%]", f"{low} [%]", f"{high} [%]"]

    def _rows(self, body: ValveBody) -> Iterator[list[Any]]:
        """Yield the rates of a valve body's units, then those of its leading pairs."""
        name, counts = self.words.body(body.controller), body.counts
        whole = counts.rates[Verdict.REPLACE]
        of_units = [counts.units, counts.judged]
        yield [name, self.say("fleet_summary.whole_unit"), *of_units, whole.of, *_rate(whole)]
        for pair in [pair for pair in body.pairs if pair.replace.count][:_LEADING]:
            land = self.words.land(body.controller, pair.key)
            yield ["", land, *of_units, pair.replace.of, *_rate(pair.replace)]

    def _said(self) -> Iterator[tuple[str, list[str]]]:
        """Yield what differs between groups, and what to know, each with its title."""
        differ = [each for body in self.summary.bodies for each in self._differences(body)]
        if differ:
            yield self.say("fleet_summary.section_comparison"), differ
        know = self.words.messages(self.summary.messages)
        for body in self.summary.bodies:
            comparison = body.comparison.messages if body.comparison else ()
            said = self.words.messages((*body.messages, *comparison))
            know += [f"{self.words.body(body.controller)}: {each}" for each in said]
        if know:
            yield self.say("fleet_summary.section_know"), know

    def _differences(self, body: ValveBody) -> Iterator[str]:
        if body.comparison is None:
            return
        name = self.words.body(body.controller)
        rates = [each for each in body.comparison.verdicts if each.points is not None and each.points.differs]
        for each in rates[:_DIFFERENCES]:
            yield f"{name}: {self.words.difference_of_rates(each)}"
        decided = [found for found in map(called, body.comparison.lands) if found is not None]
        if decided:
            said = self.say("fleet_summary.wear_differs", found=sum(decided), count=len(decided))
            yield f"{name}: {said}"

    # --- what everything means

    def _meanings(self, sheet: Worksheet) -> None:
        book, say = self.book, self.say
        widths = (28, 48, 100)
        for number, width in enumerate(widths):
            sheet.set_column(number, number, width)
        book.headings(sheet, 0, [say(f"fleet_summary.meanings_{name}") for name in ("sheet", "column", "meaning")], 1)
        rows = [("", say(f"fleet_terms.{name}"), say(f"fleet_meaning.{name}")) for name in TERMS]
        for made in self.sheets:
            name = say(f"fleet_sheets.{made.name}")
            rows.append((name, "", say(f"fleet_about.{made.name}")))
            whole = [column for column in made.columns if not column.part]
            parted = dict.fromkeys((column.what, column.about) for column in made.columns if column.part)
            said = [*((column.heading, column.note) for column in whole), *parted]
            rows += [(name, *each) for each in said if each[1]]
        parts = dict.fromkeys(column.part for made in self.sheets for column in made.columns if column.part)
        named = [(say(f"fleet_parts.{part}"), say(f"fleet_part_notes.{part}")) for part in parts]
        rows += [("", *each) for each in named if each[0]]
        for line, row in enumerate(rows, start=1):
            for number, text in enumerate(row):
                book.put(sheet, line, number, text or None, book.wrapped)
            sheet.set_row(line, row_height(zip(row, widths, strict=True), line=LINE_OF_A_BOOK))
        sheet.autofilter(0, 0, len(rows), len(widths) - 1)


_WHOLE = (2, 3, 4, 5)  # columns of the overview that hold numbers of units


def _pages_across(sheet: SummarySheet) -> int:
    """Return on how many pages side by side a sheet is printed, so that its words stay legible."""
    repeated, others = sum(sheet.widths[: sheet.frozen]), sum(sheet.widths[sheet.frozen :])
    return max(math.ceil(others / max(_ACROSS - repeated, 1)), 1)


def _rate(rate: Any) -> list[Any]:
    return [rate.count, rate.percent, rate.low_percent, rate.high_percent]
