"""Write the sheets on the road test and on gauge readings: what was shown, what is permissible, what it says."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

from xlsxwriter.worksheet import Worksheet

from atleak.catalogue.workbook.cells import gear_shown
from atleak.common.sentences import Name, Sentence
from atleak.common.style import CHART_GRID, PAPER_INKS
from atleak.common.units import UnitOf, gear_name
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.road import RoadFindings
from atleak.engine.road_leakage import RoadLeakage
from atleak.report.tables.answer import missing_table
from atleak.report.tables.gauges import gauge_table, pattern_sentences
from atleak.report.tables.road_test import RoadSeries, instant_table, place_table, road_series
from atleak.report.tables.road_words import (
    check_sentences,
    log_sentences,
    pressure_sentences,
    test_sentences,
    warm_up_section,
)
from atleak.report.xlsx.book import ReportBook, cell_span
from atleak.report.xlsx.live_sheet import FLOW
from atleak.report.xlsx.page import SheetPage, widths_for

ROAD_TEST, ROAD_EVENTS = Sentence("Road test"), Sentence("Road test events")
ROAD_ROWS = 2000  # rows of the thinned road test
_FORMATS = {"pressure": "kpa", "engine_speed": "rpm", "": "count"}  # of numbers, named otherwise than their kind


class RoadSheets:
    """The sheets on the road test."""

    def __init__(self, book: ReportBook, diagnosis: Diagnosis, log: RoadFindings) -> None:
        self.book, self.diagnosis, self.log = book, diagnosis, log

    def write(self, sheet: Worksheet) -> None:
        """Write what the log says by itself, then the leakage over it with two charts and the thinned series."""
        road = self.diagnosis.road
        series = None if road is None else road_series(road, ROAD_ROWS)
        page = SheetPage(self.book, sheet, (40, *[15] * (len(series.columns) - 1 if series else 11)))
        row = page.pairs(0, [(Sentence("file"), self.log.road_test.file)]) + 1
        for sentence, leads in self.findings():
            row = page.across(row, sentence, bold=leads)
        row += 1
        if self.log.permitted is not None:
            row = page.printed(row, place_table(self.log.permitted, self.book.say))
        section = warm_up_section(self.diagnosis, self.book.say)
        row = page.section(row + 1, section) if section else row + 1
        if road is not None and series is not None:
            self._leakage(page, row, road, series)

    def findings(self) -> Iterator[tuple[str, bool]]:
        """Give what the log says and what to check next, sentence by sentence, and whether it leads those below it."""
        say, log = self.book.say, self.log
        for sentence in (*pressure_sentences(log, say), *test_sentences(log, say), *log_sentences(log, say)):
            yield sentence, False
        checks = check_sentences(self.diagnosis, say)
        if checks:
            yield say("findings.check_next"), True
        yield from ((check, False) for check in checks)

    def _leakage(self, page: SheetPage, row: int, road: RoadLeakage, series: RoadSeries) -> None:
        book, say, sheet = self.book, self.book.say, page.sheet
        if not self.diagnosis.judged:
            row = page.across(row, say("findings.unmeasured"), bold=True)
        rows: list[tuple[str, Any]] = [(Sentence("gears"), ", ".join(map(gear_name, road.gears)))]
        rows += [
            (Sentence("of the volume leaked from {name}", name=Name(name)), say.percent(share))
            for name, share in road.section_shares.items()
            if share is not None
        ]
        row = page.pairs(row, rows)
        row = page.printed(row + 1, instant_table(road, self.diagnosis.uncertainty, book.say))
        row = page.across(row, say("texts.sustained", seconds=say.plain(road.extremes.window)))
        kept = len(series.columns["time_s"])
        if series.thinned:
            text = Sentence(
                "{kept} of {samples} samples: every stretch keeps its lowest and highest values.",
                kept=kept,
                samples=series.samples,
            )
            page.across(row, text)
        row += 16  # the charts take so many rows
        names = list(series.columns)
        sheet.print_area(0, 0, row - 1, page.last)  # the series is for the screen
        book.few_pages(sheet, page.lines(row), 0)
        page.headings(row, [_with_unit(label, kind) for label, kind in series.labels.values()])
        for column, (name, values) in enumerate(series.columns.items()):
            kind = series.labels[name][1]
            form = book.form(_FORMATS.get(kind, kind), kind or None)
            for line, value in enumerate((say.convert(values, kind) if kind else values).tolist(), start=row + 1):
                if math.isfinite(value) and name != "gear":
                    sheet.write_number(line, column, value, form)
                elif value == value:  # NaN: an empty cell, a gap in the chart
                    book.put(sheet, line, column, gear_shown(int(value)) if name == "gear" else value, form)
        first, last = row + 1, row + kept
        flows = [name for name in ("pump_capacity_dm3_min", "leakage_dm3_min") if name in names]
        drawn = [(name, series.labels[name][0], names.index(name)) for name in flows]
        self._chart(sheet, row - 15, book.words(Sentence("Flow [{unit}]", unit=FLOW)), drawn, first, last)
        if "share_percent" in names:
            share = ("share_percent", Sentence("share"), names.index("share_percent"))
            self._chart(sheet, row - 15, book.words(Sentence("Share [%]")), [share], first, last, column=6)

    def _chart(
        self,
        sheet: Worksheet,
        row: int,
        axis: str,
        series: Sequence[tuple[str, str, int]],
        first: int,
        last: int,
        column: int = 0,
    ) -> None:
        chart = self.book.workbook.add_chart({"type": "scatter", "subtype": "straight"})
        dashes = {"pump_capacity_dm3_min": (PAPER_INKS.pump, "dash"), "leakage_dm3_min": (PAPER_INKS.leakage, "solid")}
        for name, label, at in series:
            colour, dash = dashes.get(name, (PAPER_INKS.share, "solid"))
            chart.add_series(
                {
                    "name": self.book.words(label),
                    "categories": "=" + cell_span(first, last, 0, self.book.words(ROAD_TEST)),
                    "values": "=" + cell_span(first, last, at, self.book.words(ROAD_TEST)),
                    "line": {"color": colour, "width": 1.25, "dash_type": dash},
                }
            )
        chart.set_x_axis({"name": self.book.words(Sentence("time [s]")), "min": 0, "label_position": "low"})
        chart.set_y_axis({"name": axis, "major_gridlines": {"visible": True, "line": {"color": CHART_GRID}}})
        chart.set_title({"none": True})
        chart.set_legend({"position": "top"} if len(series) > 1 else {"none": True})
        chart.show_blanks_as("gap")
        chart.set_size({"width": 770, "height": 280})
        sheet.insert_chart(
            row, column, chart, {"description": self.book.words(Sentence("{axis} over the road test", axis=axis))}
        )


def _with_unit(label: Sentence, kind: str) -> Sentence:
    return Sentence("{label} [{unit}]", label=label, unit=UnitOf(kind)) if kind else label


ROAD_SHEET = Sentence("Gauge readings")


def write_gauges(book: ReportBook, sheet: Worksheet, diagnosis: Diagnosis) -> None:
    """Write a row for every reading, in the order of the ranges, and the patterns below."""
    check, say = diagnosis.pressures, book.say
    if check is None:
        return
    tables = [gauge_table(check, say).without("lost_between")]
    tables += [missing_table(diagnosis, say)] if diagnosis.missing_flagged else []
    page, row = SheetPage(book, sheet, widths_for(tables)), 0
    for table in tables:
        row = page.printed(row, table) + 1
    notes = [(Sentence("file"), check.table.file), (Sentence("sheet"), check.table.sheet or "")]
    notes += [(Sentence("permitted by"), text) for text in dict.fromkeys(_sources(diagnosis))]
    notes += [(Sentence("pattern"), each) for each in pattern_sentences(check, diagnosis.controller, say)]
    page.pairs(row, notes)


def _sources(diagnosis: Diagnosis) -> list[str]:
    readings = diagnosis.pressures.readings if diagnosis.pressures else ()
    return [Name(each.permissible.source) for each in readings if each.permissible]
