"""Draw a fleet's summary with Excel's own charts, from the cells of its tables."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from xlsxwriter.chart import Chart
from xlsxwriter.worksheet import Worksheet

from atleak.fleet.summary_sheets import SummarySheet
from atleak.fleet.summary_words import FleetWords
from atleak.fleet.summed import ValveBody
from atleak.look import CHART_GRID, CURVES, LOOKS, OK_IN_PART, PAPER, Look
from atleak.report.printed_charts.fleet import STACKED
from atleak.report.xlsx.book import Book, span
from atleak.rules import LandKey
from atleak.verdicts import FLAGGED, Verdict

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


@dataclass(frozen=True)
class _Source:
    """Rows of a sheet from which a chart is drawn."""

    book: Book
    sheet: SummarySheet
    first: int
    last: int

    def cells(self, key: str, stretch: tuple[int, int] | None = None) -> str:
        """Return the cells of a column, as a chart refers to them."""
        first, last = stretch or (self.first, self.last)
        name = self.book.say(f"fleet_sheets.{self.sheet.name}")
        return "=" + span(first, last, self.sheet.column(key), name)

    def heading(self, key: str) -> str:
        """Return what stands over a column."""
        return self.sheet.columns[self.sheet.column(key)].heading


def add_verdicts(book: Book, sheet: Worksheet, row: int, words: FleetWords, sheets: Sequence[SummarySheet]) -> None:
    """Draw the verdicts of every valve body as bars."""
    source = _source(book, sheets, "verdicts", lambda each: each.body is not None and each.group is None)
    if source is None:
        return
    chart = book.workbook.add_chart({"type": "bar", "subtype": "percent_stacked"})
    parts = [(f"verdict_{verdict}", book.say.signed(verdict), LOOKS[verdict]) for verdict in STACKED]
    ok = STACKED.index(Verdict.OK)  # what is ok in part is not green
    parts[ok : ok + 1] = [
        ("ok_throughout", book.say.signed(Verdict.OK), LOOKS[Verdict.OK]),
        ("ok_in_part", source.heading("ok_in_part"), OK_IN_PART),
    ]
    for key, name, look in parts:
        chart.add_series(
            {
                "name": name,
                "categories": source.cells("body"),
                "values": source.cells(key),
                "gap": 60,
                "data_labels": {"value": True, "font": {"color": look.on_fill}, "num_format": "#,##0;;"},
                **_filled(look),
            }
        )
    chart.set_y_axis({"reverse": True})
    chart.set_x_axis({"num_format": "0%", "major_gridlines": {"visible": True, "line": {"color": CHART_GRID}}})
    title, alt = book.say("fleet_summary.section_verdicts"), book.say("fleet_summary.caption_verdicts")
    _place(sheet, row, 0, chart, title, alt, _AROUND + _BAR * len(words.summary.bodies))


def rows_of_verdicts(bodies: int) -> int:
    """Return how many rows the chart of the verdicts of so many valve bodies takes, a free one below it with them."""
    return math.ceil((_AROUND + _BAR * bodies) / _ROW) + 1


def add_charts(book: Book, sheet: Worksheet, words: FleetWords, sheets: Sequence[SummarySheet]) -> None:
    """Draw pairs, wear, share and pressure of every valve body, two charts beside one another."""
    row, ends = 0, []
    sheet.set_print_scale(_PRINTED)
    sheet.set_column_pixels(0, 2 * _ACROSS - 1, _COLUMN)
    sheet.set_margins(left=0.4, right=0.4, top=0.5, bottom=0.6)
    bodies = words.summary.bodies
    for body in bodies[:_CHARTED]:
        book.put(sheet, row, 0, words.body(body.controller), book.title)
        sheet.set_row(row, 24)
        row += 1
        made = [
            made
            for made in (
                _pareto(book, words, sheets, body),
                _mileage(book, words, sheets, body),
                _temperature(book, sheets, body, "share", words.body(body.controller)),
                _temperature(book, sheets, body, "pressure", words.body(body.controller)),
            )
            if made is not None
        ]
        for number, (chart, title, alt) in enumerate(made):
            _place(sheet, row + number // 2 * _ROWS, number % 2 * _ACROSS, chart, title, alt)
        row += -(-len(made) // 2) * _ROWS
        ends.append(row)
    sheet.set_h_pagebreaks(ends[:-1])
    if len(bodies) > _CHARTED:
        book.put(sheet, row, 0, book.say("fleet_summary.more_charts", count=len(bodies) - _CHARTED))


_Made = tuple[Chart, str, str]


def _source(book: Book, sheets: Sequence[SummarySheet], name: str, wanted: Any) -> _Source | None:
    sheet = next((sheet for sheet in sheets if sheet.name == name), None)
    stretch = sheet.stretch(wanted) if sheet is not None else None
    return None if sheet is None or stretch is None else _Source(book, sheet, *stretch)


def _of(body: ValveBody) -> Any:
    return lambda row: row[0] is body


def _of_land(body: ValveBody, key: LandKey, row: Any) -> bool:
    return row[0] is body and row[1].key == key


def _pareto(book: Book, words: FleetWords, sheets: Sequence[SummarySheet], body: ValveBody) -> _Made | None:
    """Draw how often the leading pairs are flagged, and to be replaced."""
    source, say = _source(book, sheets, "pairs", _of(body)), book.say
    count = sum(pair.flagged.count > 0 for pair in body.pairs[:_PAIRS])
    if source is None or not count:
        return None
    rows = source.first, source.first + count - 1
    chart = book.workbook.add_chart({"type": "bar"})
    for key, verdict in (("pair_flagged.percent", FLAGGED[0]), ("pair_replace.percent", Verdict.REPLACE)):
        chart.add_series(
            {
                "name": source.heading(key),
                "categories": source.cells("pair", rows),
                "values": source.cells(key, rows),
                "overlap": 100,
                "gap": 40,
                **_filled(LOOKS[verdict]),
            }
        )
    chart.set_x_axis(_axis(say("fleet_summary.chart_pairs"), min=0))
    chart.set_y_axis({"reverse": True, "num_font": {"size": 8}})
    name = words.body(body.controller)
    land = words.land(body.controller, body.pairs[0].key)
    rate = words.counted(body.pairs[0].replace)
    return chart, say("fleet_summary.section_pairs"), say("fleet_summary.alt_pairs", body=name, pair=land, rate=rate)


def _mileage(book: Book, words: FleetWords, sheets: Sequence[SummarySheet], body: ValveBody) -> _Made | None:
    """Draw the median wear of the leading pairs over mileage."""
    source, say = _source(book, sheets, "wear", _of(body)), book.say
    if source is None:
        return None
    chart = book.workbook.add_chart({"type": "scatter", "subtype": "straight_with_markers"})
    wear = {land.key: land for land in body.wear}
    keys = [pair.key for pair in body.pairs if pair.key in wear and wear[pair.key].classes][:_CURVES]
    for number, (key, colour) in enumerate(zip(keys, CURVES.values(), strict=False)):
        rows = source.sheet.stretch(partial(_of_land, body, key))
        chart.add_series(
            {
                "name": words.land(body.controller, key),
                "categories": source.cells("mileage_middle", rows),
                "values": source.cells("wear.median", rows),
                "line": {"color": colour, "width": 1.5, "dash_type": _DASHES[number]},
                "marker": {"type": _MARKERS[number], "size": 6, "fill": {"color": colour}, "border": {"color": colour}},
            }
        )
    chart.set_x_axis(_axis(say("fleet_summary.chart_mileage"), min=0, label_position="low", num_format="#,##0"))
    chart.set_y_axis(_axis(source.heading("wear.median")))
    names = ", ".join(words.land(body.controller, key) for key in keys)
    alt = say("fleet_summary.alt_wear", body=words.body(body.controller), pairs=names)
    return chart, say("fleet_summary.section_wear"), alt


def _temperature(book: Book, sheets: Sequence[SummarySheet], body: ValveBody, kind: str, name: str) -> _Made | None:
    """Draw the spread of share or pressure over temperature, and the mean of all time."""
    known = any(each.share_percent if kind == "share" else each.pressure_kpa for each in body.temperatures)
    source, say = _source(book, sheets, "temperatures", _of(body)), book.say
    if source is None or not known:
        return None
    chart = book.workbook.add_chart({"type": "scatter", "subtype": "straight"})
    colour = PAPER.pump if kind == "pressure" else PAPER.leakage
    for part, dash, width in _SPREAD:
        chart.add_series(
            {
                "name": say(f"fleet_parts.{part}"),
                "categories": source.cells("temperature_middle"),
                "values": source.cells(f"{kind}.{part}"),
                "line": {"color": colour, "width": width, "dash_type": dash},
            }
        )
    chart.add_series(
        {
            "name": source.heading(f"{kind}_mean"),
            "categories": source.cells("temperature_middle"),
            "values": source.cells(f"{kind}_mean"),
            "line": {"none": True},
            "marker": {"type": "diamond", "size": 6, "fill": {"color": PAPER.ink}, "border": {"color": PAPER.ink}},
        }
    )
    chart.set_x_axis(_axis(say("fleet_summary.chart_temperature"), label_position="low", crossing="min"))
    low = 0.0 if kind == "share" else _low_end([say.convert(end, "pressure") for end in _ends(body)])
    chart.set_y_axis(_axis(say(f"fleet_summary.over_{kind}"), crossing="min", min=low, num_format="General"))
    title = say(f"fleet_summary.title_{kind}")
    return chart, title, f"{title}: {name}"


def _ends(body: ValveBody) -> list[float]:
    """Return between which values main pressure is drawn [kPa]."""
    known = [each.pressure_kpa for each in body.temperatures if each.pressure_kpa]
    means = [each.pressure_mean_kpa for each in body.temperatures if each.pressure_mean_kpa is not None]
    return means + [end for each in known for end in (each.quantiles or (each.median,))]


def _axis(name: str, **more: Any) -> dict[str, Any]:
    return {"name": name, "major_gridlines": {"visible": True, "line": {"color": CHART_GRID}}, **more}


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


def _place(sheet: Worksheet, row: int, column: int, chart: Chart, title: str, alt: str, height: int = _HEIGHT) -> None:
    chart.set_title({"name": title, "name_font": {"size": 11}, "overlay": False})
    chart.set_legend({"position": "bottom"})
    chart.show_blanks_as("gap")
    chart.set_size({"width": _WIDTH, "height": height})
    sheet.insert_chart(row, column, chart, {"description": alt, "object_position": 2})
