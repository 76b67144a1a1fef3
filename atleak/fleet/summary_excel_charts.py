"""Draw a fleet's summary with Excel's own charts, from the cells of its tables."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Any, NamedTuple

from xlsxwriter.chart import Chart
from xlsxwriter.worksheet import Worksheet

from atleak.fleet.summary_tables import Row, by_trouble
from atleak.fleet.summary_words import FleetWords
from atleak.fleet.summed import LandOverMileage, ValveBody
from atleak.look import CHART_GRID, CURVES, LOOKS, OK_IN_PART, PAPER, Look
from atleak.report.xlsx.book import Book, span
from atleak.verdicts import FLAGGED, Verdict
from atleak.views.table import Table

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
        return "=" + span(self.first, self.last, at, self.table.title)

    def heading(self, key: str) -> str:
        """Return what stands over a column."""
        return next(column for column in self.table.columns if column.key == key).heading(self.table.say)


_Made = tuple[Chart, str, str]  # with its title, and what it shows in words


class WorkbookCharts:
    """The charts of a summary, from the sheets of its tables."""

    def __init__(self, book: Book, words: FleetWords, tables: Sequence[Table]) -> None:
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
        over, ink = {"categories": source.cells("temperature_middle")}, {"color": PAPER.ink}
        colour = PAPER.pump if kind == "pressure" else PAPER.leakage
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


def _is_of(body: ValveBody, land: LandOverMileage, row: Row) -> bool:
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
