"""Write a fleet's summary as an Excel workbook: an overview with charts, then one table for each thing counted.

Numbers are numbers, in the units that the headings name; what each column means stands in a note on its heading and on
the last sheet. Excel draws the charts from the cells of the tables. Text is always written as text: nothing that
somebody typed becomes a formula or a link.
"""

from __future__ import annotations

import datetime as dt
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

from xlsxwriter.chart import Chart
from xlsxwriter.worksheet import Worksheet

from atleak.common.style import (
    CHART_GRID,
    CURVES,
    DATA_BAR,
    DEFAULT_PAPER,
    HEADING,
    LOOKS,
    OK_IN_PART,
    PAPER_INKS,
    Look,
    find_paper,
)
from atleak.common.verdicts import FLAGGED, VERDICTS, Verdict
from atleak.common.wording import wording
from atleak.fleet.summary_sections import Depth, FleetSections
from atleak.fleet.summary_tables import FleetTables, SummaryRow, by_trouble
from atleak.fleet.summary_words import TERMS, FleetWords
from atleak.fleet.sums import FleetSummary, LandOverMileage, ValveBody
from atleak.report.sheets.paging import row_height
from atleak.report.tables.table import VERDICT, Column, Table
from atleak.report.xlsx import report_workbook
from atleak.report.xlsx.book import HIGHEST_ROW, ReportBook, cell_span
from atleak.report.xlsx.page import SheetPage
from atleak.report.xlsx.summary import summary_page

_ROWS = 22  # that a chart takes, the free ones below it with them
_CHARTED = 12  # most valve bodies with charts
_PAIRS, _CURVES = 15, 5  # pairs in the Pareto, and over mileage
_WIDTH, _HEIGHT = 600, 420  # [px]
_ROW = 20  # [px]
_BAR, _AROUND = 28, 150  # [px] of the verdicts of a valve body, and of what stands around them
_PRINTED = 55  # [%] two charts beside one another fit on A4 and Letter, also where columns are drawn a third wider
_ACROSS, _COLUMN = 10, 64  # columns that a chart takes, each so wide [px]
_PATTERNS = {"///": "wide_upward_diagonal", "...": "percent_20"}  # of a look's hatch, as Excel has it
_DASHES = ("solid", "dash", "round_dot", "long_dash", "dash_dot")
_MARKERS = ("circle", "square", "diamond", "triangle", "x")
_SPREAD = (  # curves over temperature: parts of a spread, with dash and width
    ("quantile_95", "round_dot", 0.75),
    ("quantile_75", "dash", 0.75),
    ("median", "solid", 1.75),
    ("quantile_25", "dash", 0.75),
    ("quantile_5", "round_dot", 0.75),
)


class _Source(NamedTuple):
    """Rows of a sheet from which a chart is drawn."""

    table: Table
    first: int
    last: int

    def cells(self, key: str) -> str:
        """Return the cells of a column, as a chart refers to them."""
        at = next(number for number, column in enumerate(self.table.columns) if column.key == key)
        return "=" + cell_span(self.first, self.last, at, self.table.title)

    def heading(self, key: str) -> str:
        """Return what stands over a column."""
        return next(column for column in self.table.columns if column.key == key).heading(self.table.say)


_Made = tuple[Chart, str, str]  # with its title, and what it shows in words


class WorkbookCharts:
    """The charts of a summary, from the sheets of its tables."""

    def __init__(self, book: ReportBook, words: FleetWords, tables: Sequence[Table]) -> None:
        self.book, self.words, self.say = book, words, words.say
        self._tables = {table.name: table for table in tables}

    def add_verdicts(self, sheet: Worksheet, row: int) -> int:
        """Draw the verdicts of every valve body as bars; return how many rows they take, a free one with them."""
        source = self._source("verdicts", lambda each: each.body is not None and each.group is None)
        if source is None:
            return 0
        say, chart = self.say, self._chart("bar", "percent_stacked")
        flagged = ((f"verdict_{level}", say.signed(level), LOOKS[level]) for level in reversed(FLAGGED))
        parts = [
            *flagged,
            ("ok_throughout", say.signed(Verdict.OK), LOOKS[Verdict.OK]),  # what is ok in part is not green
            ("ok_in_part", source.heading("ok_in_part"), OK_IN_PART),
            (f"verdict_{Verdict.NOT_MEASURED}", say.signed(Verdict.NOT_MEASURED), LOOKS[Verdict.NOT_MEASURED]),
        ]
        for key, name, look in parts:
            labels = {"value": True, "font": {"color": look.on_fill}, "num_format": "#,##0;;"}
            series = {"name": name, "categories": source.cells("body"), "values": source.cells(key), "gap": 60}
            chart.add_series({**series, "data_labels": labels, **_filled(look)})
        chart.set_y_axis({"reverse": True})
        chart.set_x_axis({"num_format": "0%", **_GRID})
        height = _AROUND + _BAR * len(self.words.summary.bodies)
        made = chart, say("fleet_summary.section_verdicts"), say("fleet_summary.caption_verdicts")
        _place(sheet, row, 0, made, height)
        return math.ceil(height / _ROW) + 1

    def add(self, sheet: Worksheet) -> None:
        """Draw pairs, wear, share and pressure of every valve body, two charts beside one another."""
        row, ends, bodies = 0, [], self.words.summary.bodies
        sheet.set_print_scale(_PRINTED)
        sheet.set_column_pixels(0, 2 * _ACROSS - 1, _COLUMN)
        sheet.set_margins(left=0.4, right=0.4, top=0.5, bottom=0.6)
        for body in bodies[:_CHARTED]:
            self.book.put(sheet, row, 0, self.words.body(body.controller), self.book.title)
            sheet.set_row(row, 24)
            row += 1
            made = list(self._of_body(body))
            for number, each in enumerate(made):
                _place(sheet, row + number // 2 * _ROWS, number % 2 * _ACROSS, each)
            row += -(-len(made) // 2) * _ROWS
            ends.append(row)
        sheet.set_h_pagebreaks(ends[:-1])
        if len(bodies) > _CHARTED:
            self.book.put(sheet, row, 0, self.say("fleet_summary.more_charts", count=len(bodies) - _CHARTED))

    def _of_body(self, body: ValveBody) -> Iterator[_Made]:
        drawers = {"pairs": self._pareto, "wear": self._mileage, "temperatures": self._temperatures}
        for name, draw in drawers.items():
            source = self._source(name, lambda row: row.body is body)
            if source is not None:
                yield from draw(source, body)

    def _chart(self, kind: str, subtype: str = "") -> Chart:
        return self.book.workbook.add_chart({"type": kind, **({"subtype": subtype} if subtype else {})})

    def _source(self, name: str, wanted: Callable[[Any], bool]) -> _Source | None:
        """Return the rows of a sheet that hold such items, which stand together; None without any."""
        table = self._tables.get(name)
        found = [number for number, row in enumerate(table.rows, start=1) if wanted(row)] if table else []
        return _Source(table, found[0], found[-1]) if table and found else None

    def _pareto(self, source: _Source, body: ValveBody) -> Iterator[_Made]:
        """Draw how often the leading pairs are flagged, and to be replaced."""
        say, count = self.say, sum(pair.flagged.count > 0 for pair in body.pairs[:_PAIRS])
        if not count:
            return
        rows, chart = source._replace(last=source.first + count - 1), self._chart("bar")
        for key, verdict in (("pair_flagged.percent", FLAGGED[0]), ("pair_replace.percent", Verdict.REPLACE)):
            cells = {"name": source.heading(key), "categories": rows.cells("pair"), "values": rows.cells(key)}
            chart.add_series({**cells, "overlap": 100, "gap": 40, **_filled(LOOKS[verdict])})
        chart.set_x_axis(_axis(say("fleet_summary.chart_pairs"), min=0))
        chart.set_y_axis({"reverse": True, "num_font": {"size": 8}})
        first, words = body.pairs[0], self.words
        land, rate = words.land(body.controller, first.key), words.counted(first.replace.count, first.replace.of)
        alt = say("fleet_summary.alt_pairs", body=words.body(body.controller), pair=land, rate=rate)
        yield chart, say("fleet_summary.section_pairs"), alt

    def _mileage(self, source: _Source, body: ValveBody) -> Iterator[_Made]:
        """Draw the median wear of the leading pairs over mileage."""
        say, chart, names = self.say, self._chart("scatter", "straight_with_markers"), []
        lands = [land for land in by_trouble(body) if land.classes][:_CURVES]
        for number, (land, colour) in enumerate(zip(lands, CURVES.values(), strict=False)):
            rows = self._source("wear", partial(_is_of, body, land))
            assert rows is not None
            names.append(self.words.land(body.controller, land.key))
            ink = {"color": colour}
            chart.add_series(
                {
                    "name": names[-1],
                    "categories": rows.cells("mileage_middle"),
                    "values": rows.cells("wear.median"),
                    "line": {**ink, "width": 1.5, "dash_type": _DASHES[number]},
                    "marker": {"type": _MARKERS[number], "size": 6, "fill": ink, "border": ink},
                }
            )
        chart.set_x_axis(_axis(say("fleet_summary.chart_mileage"), min=0, label_position="low", num_format="#,##0"))
        chart.set_y_axis(_axis(source.heading("wear.median")))
        alt = say("fleet_summary.alt_wear", body=self.words.body(body.controller), pairs=", ".join(names))
        yield chart, say("fleet_summary.section_wear"), alt

    def _temperatures(self, source: _Source, body: ValveBody) -> Iterator[_Made]:
        """Draw the spread of share and of pressure over temperature, and the mean of all time."""
        say, classes = self.say, body.temperatures
        if any(each.share_percent for each in classes):
            yield self._temperature(source, body, "share", 0.0)
        if any(each.pressure_kpa for each in classes):
            ends = [end for each in classes if each.pressure_kpa for end in each.pressure_kpa.most_of_all]
            ends += [each.pressure_mean_kpa for each in classes if each.pressure_mean_kpa is not None]
            yield self._temperature(source, body, "pressure", _low_end([say.convert(end, "pressure") for end in ends]))

    def _temperature(self, source: _Source, body: ValveBody, kind: str, low: float) -> _Made:
        say, chart = self.say, self._chart("scatter", "straight")
        over, ink = {"categories": source.cells("temperature_middle")}, {"color": PAPER_INKS.ink}
        colour = PAPER_INKS.pump if kind == "pressure" else PAPER_INKS.leakage
        for part, dash, width in _SPREAD:
            line = {"color": colour, "width": width, "dash_type": dash}
            name, values = say(f"fleet_parts.{part}"), source.cells(f"{kind}.{part}")
            chart.add_series({**over, "name": name, "values": values, "line": line})
        mean, marker = f"{kind}_mean", {"type": "diamond", "size": 6, "fill": ink, "border": ink}
        look = {"line": {"none": True}, "marker": marker}
        chart.add_series({**over, "name": source.heading(mean), "values": source.cells(mean), **look})
        chart.set_x_axis(_axis(say("fleet_summary.chart_temperature"), label_position="low", crossing="min"))
        chart.set_y_axis(_axis(say(f"fleet_summary.over_{kind}"), crossing="min", min=low, num_format="General"))
        title = say(f"fleet_summary.title_{kind}")
        return chart, title, f"{title}: {self.words.body(body.controller)}"


def _is_of(body: ValveBody, land: LandOverMileage, row: SummaryRow) -> bool:
    return row.body is body and row.item is land


_GRID = {"major_gridlines": {"visible": True, "line": {"color": CHART_GRID}}}


def _axis(name: str, **more: Any) -> dict[str, Any]:
    return {"name": name, **_GRID, **more}


def _filled(look: Look) -> dict[str, Any]:
    """Return the fill of a verdict's bar: its shade, and the pattern that tells it without colour."""
    border = {"border": {"color": look.line, "width": 0.75}}
    pattern = _PATTERNS.get(look.hatch)
    if pattern is None:
        return {"fill": {"color": look.fill}, **border}
    return {"pattern": {"pattern": pattern, "fg_color": look.line, "bg_color": look.fill}, **border}


def _low_end(ends: Sequence[float]) -> float:
    """Return a round value a little below all of some values, at which their axis begins."""
    low, high = min(ends), max(ends)
    step = 10.0 ** math.floor(math.log10(max(high - low, 1e-6)))
    return math.floor((low - 0.05 * (high - low)) / step) * step


def _place(sheet: Worksheet, row: int, column: int, made: _Made, height: int = _HEIGHT) -> None:
    chart, title, alt = made
    chart.set_title({"name": title, "name_font": {"size": 11}, "overlay": False})
    chart.set_legend({"position": "bottom"})
    chart.show_blanks_as("gap")
    chart.set_size({"width": _WIDTH, "height": height})
    sheet.insert_chart(row, column, chart, {"description": alt, "object_position": 2})


_DATE = "yyyy-mm-dd"
_OVERVIEW = Depth(pairs=5, drawn=0, groups=12, differences=5, compared=False)
_COLUMNS = 7  # of the widest table in the overview
_FROZEN = {"pairs": 3, "wear": 3, "latest": 3, "temperatures": 3, "rates_compared": 3, "wear_compared": 5,
           "deciders": 2, "conditions": 2}  # fmt: skip  # columns that stay in sight
_NUMBER, _LEAST, _MOST, _WIDEST = 12, 10, 48, 90  # [characters] of columns: numbers, words, long texts that wrap
_LONG, _BARS = "message", "pair_replace.percent"  # columns of long texts, and of bars behind their numbers
_ON_A_PAGE = 225  # characters that a page has room for side by side, at six tenths of their size
_SIDE = 0.4  # [in] margins


def write_summary_workbook(
    summary: FleetSummary, *, language: str = "en", units: str = "metric", paper: str = DEFAULT_PAPER
) -> bytes:
    """Return the bytes of the workbook.

    Parameters
    ----------
    summary
        the fleet in numbers; nothing is computed from it that it does not hold.
    language, units, paper
        as `atleak.report.xlsx.write_workbook` takes them.

    Raises
    ------
    InputError
        if there is no such paper, language or system of units.
    """
    size, say = find_paper(paper), wording(language, units)
    words = FleetWords(summary, say)
    return report_workbook(lambda book: _Writer(ReportBook(book, size, say), words).write(), say("fleet_summary.title"))


class _Writer:
    """Writes the sheets of one summary."""

    def __init__(self, book: ReportBook, words: FleetWords) -> None:
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
        verdicts, know = sections.section("verdicts"), sections.know()
        page = summary_page(self.book, sheet, _COLUMNS)
        head = sections.head()
        row = page.section(0, replace(head, parts=head.parts[:-1]))
        row = page.section(page.pairs(row, sections.figures()) + 1, verdicts)
        sheet.set_row(0, 24)
        self.book.put(sheet, 0, 0, self.say("fleet_summary.title"), self.book.title)
        if self.summary.counts.units:
            row += charts.add_verdicts(sheet, row)
        for body in self.summary.bodies:
            row = page.across(row, self.words.body(body.controller), bold=True, font_size=13)
            for section in (sections.section("pairs", body), sections.section("comparison", body)):
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
        sheet.set_row(0, row_height(zip(made.headings, widths, strict=True), bold=True))
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
                sheet.set_row(line, min(row_height([(str(value), _WIDEST)]), HIGHEST_ROW))
            if isinstance(value, dt.date):
                moment = dt.datetime.combine(value, dt.time())
                sheet.write_datetime(line, number, moment, book.form(_DATE, align="left"))
            else:
                book.put(sheet, line, number, self.say.signed(value) if column.kind == VERDICT else value, form)

    def _meanings(self, sheet: Worksheet) -> None:
        """Write what the terms, the sheets and their columns mean; of the parts of things, each once."""
        book, say = self.book, self.say
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
        page = SheetPage(book, sheet, (28, 48, 100))
        headings = [say(f"fleet_summary.meanings_{name}") for name in ("sheet", "column", "meaning")]
        page.table(0, headings, ([text or None for text in row] for row in rows))
        sheet.autofilter(0, 0, len(rows), page.last)


def _width(column: Column, values: Sequence[Any]) -> int:
    """Return how wide a column is [characters]: its words, up to a limit."""
    if column.key == _LONG or column.is_number:
        return _WIDEST if column.key == _LONG else _NUMBER
    return min(max([_LEAST, *(len(str(value or "")) + 2 for value in values)]), _MOST)
