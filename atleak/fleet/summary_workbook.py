"""Write a fleet's summary as an Excel workbook: an overview, then one table for each thing that was counted.

Numbers are numbers, in the units that the headings name; what each column means stands in a note on its heading and on
the last sheet. Text is always written as text: nothing that somebody typed becomes a formula or a link.
"""

from __future__ import annotations

import datetime as dt
import math
from collections.abc import Sequence
from typing import Any

from xlsxwriter.worksheet import Worksheet

from atleak.fleet.summary_excel_charts import WorkbookCharts
from atleak.fleet.summary_sections import Depth, FleetSections
from atleak.fleet.summary_tables import FleetTables
from atleak.fleet.summary_words import TERMS, FleetWords
from atleak.fleet.summed import FleetSummary
from atleak.look import DATA_BAR, HEADING
from atleak.paper import DEFAULT_PAPER, find_paper
from atleak.report.paging import LINE_OF_A_BOOK, row_height
from atleak.report.xlsx import report_workbook
from atleak.report.xlsx.book import Book
from atleak.report.xlsx.summary_page import SummaryPage
from atleak.verdicts import VERDICTS
from atleak.views.table import VERDICT, Column, Table
from atleak.wording import wording

_DATE = "yyyy-mm-dd"
_OVERVIEW = Depth(pairs=5, drawn=0, groups=12, differences=5, compared=False)
_COLUMNS = 7  # of the widest table in the overview
_FROZEN = {"pairs": 3, "wear": 3, "latest": 3, "temperatures": 3, "rates_compared": 3, "wear_compared": 5,
           "deciders": 2, "conditions": 2}  # fmt: skip  # columns that stay in sight
_NUMBER, _LEAST, _MOST, _WIDEST = 12, 10, 48, 90  # [characters] of columns: numbers, words, long texts that wrap
_LONG, _BARS = "message", "pair_replace.percent"  # columns of long texts, and of bars behind their numbers
_ON_A_PAGE = 240  # characters that a page has room for side by side, at six tenths of their size
_SIDE = 0.4  # [in] margins
_HIGHEST = 409.0  # [pt] that Excel allows


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
    words = FleetWords(summary, say)
    return report_workbook(lambda book: _Writer(Book(book, size, say), words).write(), say("fleet_summary.title"))


class _Writer:
    """Writes the sheets of one summary."""

    def __init__(self, book: Book, words: FleetWords) -> None:
        self.book, self.words, self.say, self.summary = book, words, words.say, words.summary
        self.tables = FleetTables(words).all()

    def write(self) -> None:
        """Write the overview, the tables, the charts and what everything means."""
        numbers = [table.parted for table in self.tables]
        charts = WorkbookCharts(self.book, self.words, numbers)
        overview = self.book.sheet(self.say("fleet_sheets.overview"), protected=False)
        self._overview(overview, charts)
        for table in numbers:
            self._table(table)
        if self.summary.bodies:
            charts.add(self.book.sheet(self.say("fleet_sheets.charts"), protected=False))
        self._meanings(self.book.sheet(self.say("fleet_sheets.meanings"), frozen=(1, 0), protected=False))
        overview.activate()

    def _overview(self, sheet: Worksheet, charts: WorkbookCharts) -> None:
        """Write what leads: the sections without their charts, but for the one of the verdicts."""
        sections = FleetSections(self.words, _OVERVIEW)
        verdicts, know, *_ = sections.verdicts(), sections.know()
        page = SummaryPage(self.book, sheet, _COLUMNS)
        row = page.section(page.section(0, sections.head()), verdicts)
        sheet.set_row(0, 24)
        self.book.put(sheet, 0, 0, self.say("fleet_summary.title"), self.book.title)
        if self.summary.counts.units:
            row += charts.add_verdicts(sheet, row)
        for body in self.summary.bodies:
            row = page.across(row, self.words.body(body.controller), bold=True, font_size=13)
            for section in (sections.pairs(body), sections.comparison(body)):
                row = page.section(row, section) if section.parts else row
        row = page.section(row, know) if know.parts else row
        page.across(row, self.say("fleet_summary.more_on_sheets"))
        sheet.print_area(0, 0, row, page.last)

    def _table(self, made: Table) -> None:
        book, last, say = self.book, len(made.rows), self.say
        frozen = _FROZEN.get(made.name, 1) + (made.name == "verdicts" and self.summary.by is not None)
        cells = [[column.cell(item, say) for item in made.rows] for column in made.columns]
        widths = [_width(column, values) for column, values in zip(made.columns, cells, strict=True)]
        sheet = book.sheet(made.title, frozen=(1, frozen), protected=False)
        sheet.set_row(0, row_height(zip(made.headings, widths, strict=True), bold=True, line=LINE_OF_A_BOOK))
        sheet.repeat_columns(0, frozen - 1)
        across = max(_ON_A_PAGE - sum(widths[:frozen]), 1)  # on so many pages beside one another words stay legible
        sheet.fit_to_pages(max(math.ceil(sum(widths[frozen:]) / across), 1), 0)
        sheet.set_margins(left=_SIDE, right=_SIDE)
        for number, (column, heading, values) in enumerate(zip(made.columns, made.headings, cells, strict=True)):
            sheet.set_column(number, number, widths[number])
            look: dict[str, Any] = {"bold": True, "bottom": 1, "text_wrap": True, "bg_color": HEADING}
            form = book.form(**look, align="right") if column.is_number else book.form(**look)
            book.put(sheet, 0, number, heading, form)
            if column.note:
                sheet.write_comment(0, number, column.note, {"x_scale": 2.0, "author": "atleak"})
            self._cells(sheet, number, column, values)
            if column.kind == VERDICT:
                book.colour_words(sheet, (1, number), (last, number), VERDICTS)
            if column.key == _BARS:
                bar = {"type": "data_bar", "bar_color": DATA_BAR, "min_type": "num", "min_value": 0}
                sheet.conditional_format(1, number, last, number, bar)
        sheet.autofilter(0, 0, last, len(made.columns) - 1)

    def _cells(self, sheet: Worksheet, number: int, column: Column, values: Sequence[Any]) -> None:
        book, long = self.book, column.key == _LONG
        places = column.places(self.say) if column.is_number else 0
        number_form = "#,##0" + ("." + "0" * places if places else "")
        form = book.form(number_form) if column.is_number else book.form(text_wrap=long)
        for line, value in enumerate(values, start=1):
            if long:
                sheet.set_row(line, min(row_height([(str(value), _WIDEST)], line=LINE_OF_A_BOOK), _HIGHEST))
            if isinstance(value, dt.date):
                moment = dt.datetime.combine(value, dt.time())
                sheet.write_datetime(line, number, moment, book.form(_DATE, align="left"))
            else:
                book.put(sheet, line, number, self.say.signed(value) if column.kind == VERDICT else value, form)

    def _meanings(self, sheet: Worksheet) -> None:
        """Write what the terms, the sheets and their columns mean; of the parts of things, each once."""
        book, say = self.book, self.say
        widths = (28, 48, 100)
        for number, width in enumerate(widths):
            sheet.set_column(number, number, width)
        book.headings(sheet, 0, [say(f"fleet_summary.meanings_{name}") for name in ("sheet", "column", "meaning")], 1)
        rows = [("", say(f"fleet_terms.{name}"), say(f"fleet_meaning.{name}")) for name in TERMS]
        parts: dict[str, None] = {}
        for made in self.tables:
            rows.append((made.title, "", say(f"fleet_about.{made.name}")))
            for column in made.columns:
                own = [part.key.rpartition(".")[2] for part in column.parts if "." in part.key]
                parts |= dict.fromkeys(own)
                whole = [column] if own or not column.parts else column.parts
                rows += [(made.title, each.title(say).replace("\n", " "), each.note) for each in whole if each.note]
        named = ((say(f"fleet_parts.{part}"), say(f"fleet_part_notes.{part}")) for part in parts)
        rows += [("", *each) for each in named if each[0]]
        for line, row in enumerate(rows, start=1):
            for number, text in enumerate(row):
                book.put(sheet, line, number, text or None, book.wrapped)
            sheet.set_row(line, row_height(zip(row, widths, strict=True), line=LINE_OF_A_BOOK))
        sheet.autofilter(0, 0, len(rows), len(widths) - 1)


def _width(column: Column, values: Sequence[Any]) -> int:
    """Return how wide a column is [characters]: its words, up to a limit."""
    if column.key == _LONG or column.is_number:
        return _WIDEST if column.key == _LONG else _NUMBER
    return min(max([_LEAST, *(len(str(value or "")) + 2 for value in values)]), _MOST)
