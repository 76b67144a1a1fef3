"""A fleet's summary as a workbook, read back: numbers as numbers, what they are of, charts from its own cells."""

from __future__ import annotations

import io
import re
import zipfile
from dataclasses import replace
from functools import cache
from typing import Any
from xml.etree import ElementTree

import openpyxl
import pytest
from openpyxl.utils import range_boundaries
from openpyxl.worksheet.worksheet import Worksheet
from python_calamine import CalamineWorkbook

from atleak.common.translations import languages
from atleak.common.verdicts import FLAGGED, Verdict
from atleak.common.wording import wording
from atleak.fleet.summary_tables import FleetTables
from atleak.fleet.summary_words import FleetWords, cumulated
from atleak.fleet.summary_workbook import write_summary_workbook
from atleak.fleet.sums import FleetSummary
from tests.unit.fleet.made_up import summary

FROZEN = {
    "verdicts": 2, "pairs": 3, "deciders": 2, "wear": 3, "latest": 3, "temperatures": 3, "conditions": 2,
    "rates_compared": 3, "wear_compared": 5, "units": 1, "errors": 1,
}  # fmt: skip
TWO = ("four_speed_2023", "five_speed_2005")


@cache
def written(language: str = "en", units: str = "metric") -> tuple[FleetSummary, bytes]:
    made = summary(TWO, units=120, lands=8)
    return made, write_summary_workbook(made, language=language, units=units)


@cache
def opened(language: str = "en", units: str = "metric") -> openpyxl.Workbook:
    return openpyxl.load_workbook(io.BytesIO(written(language, units)[1]))


def rows(sheet: Worksheet) -> list[dict[str, Any]]:
    head, *others = sheet.iter_rows(values_only=True)
    return [dict(zip(map(str, head), row, strict=True)) for row in others]


def assert_close(found: Any, wanted: float | None) -> None:
    assert found is None if wanted is None else found == pytest.approx(wanted, abs=1e-9)


def test_rates_of_pairs_are_numbers_with_their_interval_and_units() -> None:
    made, _ = written()
    found = rows(opened()["Pairs"])
    wanted = [(body, pair) for body in made.bodies for pair in body.pairs]
    assert len(found) == len(wanted)
    parts = [part for body in made.bodies for part in cumulated(body.pairs)]
    for row, (body, pair), part in zip(found, wanted, parts, strict=True):
        assert row["valve body"] == FleetWords(made, wording("en")).body(body.controller)
        assert row["units measured"] == pair.flagged.of
        assert row["replace or worse"] == pair.replace.count
        assert_close(row["replace or worse [%]"], pair.replace.percent)
        assert_close(row["replace or worse, 95 % from [%]"], pair.replace.low_percent)
        assert_close(row["flagged, 95 % to [%]"], pair.flagged.high_percent)
        assert (row["deciding"], row["deciding, units"]) == (pair.deciding.count, pair.deciding.of)
        assert_close(row["of all findings, summed [%]"], part)


def test_verdicts_are_those_of_all_units_of_each_valve_body_and_of_each_group() -> None:
    made, _ = written()
    found = rows(opened()["Verdicts"])
    all_units, *others = found
    assert all_units["units"] == made.counts.units
    assert [all_units[wording("en").level(verdict)] for verdict in Verdict][:2] == [
        made.counts.verdicts[Verdict.NOT_MEASURED],
        made.counts.verdicts[Verdict.OK],
    ]
    assert [row["units"] for row in others[: len(TWO)]] == [body.counts.units for body in made.bodies]
    groups = [group for body in made.bodies for group in (body.comparison.groups if body.comparison else ())]
    assert len(found) == 1 + len(TWO) + len(made.groups) + len(groups)
    for row, group in zip(found[-len(groups) :], groups, strict=True):
        assert row["supplier"] == group.name
        assert row["with a verdict"] == group.counts.judged
        assert_close(row["watch or worse, 95 % to [%]"], group.counts.rates[Verdict.WATCH].high_percent)


def test_every_table_can_be_filtered_and_printed_and_says_what_its_columns_mean() -> None:
    made, _ = written()
    book = opened()
    assert book.sheetnames[0] == "Overview"
    assert book.sheetnames[-2:] == ["Charts", "What it means"]
    sheets = [table.parted for table in FleetTables(FleetWords(made, wording("en"))).all()]
    assert len(sheets) == len(book.sheetnames) - 3
    for laid_out in sheets:
        sheet = book[laid_out.title]
        assert range_boundaries(sheet.auto_filter.ref) == (1, 1, len(laid_out.columns), len(laid_out.rows) + 1)
        assert sheet.freeze_panes == sheet.cell(2, FROZEN[laid_out.name] + 1).coordinate
        assert sheet.print_title_rows == "$1:$1"
        assert sheet.page_setup.orientation == "landscape"
        assert sheet.page_setup.fitToHeight == 0
        for cell, column in zip(sheet[1], laid_out.columns, strict=True):
            assert (cell.comment.text if cell.comment else "") == column.note
    headings = [cell.value for sheet in book.worksheets[1:-2] for cell in sheet[1]]
    assert all("\n" not in heading for heading in headings)
    for quantity in ("share", "main pressure", "temperature", "mileage", "wear"):
        named = [heading for heading in headings if heading.startswith(quantity)]
        assert named
        assert [heading for heading in named if not re.search(r"\[.+\]$|units$", heading)] == []
    meanings = [*book["What it means"].iter_rows(min_row=2, values_only=True)]
    assert len(meanings) == len(set(meanings))


def test_every_chart_draws_cells_that_hold_something() -> None:
    made, content = written()
    book, spaces = opened(), {"c": "http://schemas.openxmlformats.org/drawingml/2006/chart"}
    drawn = []
    with zipfile.ZipFile(io.BytesIO(content)) as parts:
        charts = [name for name in parts.namelist() if name.startswith("xl/charts/chart")]
        for name in charts:
            tree = ElementTree.fromstring(parts.read(name))
            drawn += [element.text or "" for element in tree.iterfind(".//c:f", spaces)]
    assert len(charts) == 1 + 4 * len(made.bodies)
    for reference in drawn:
        name, _, cells = reference.partition("!")
        sheet = book[name.strip("'")]
        values = [cell.value for row in sheet[cells.replace("$", "")] for cell in row]
        assert None not in values, reference
    assert any("Pairs!" in reference for reference in drawn)


def test_units_that_are_ok_in_part_stand_apart_in_the_chart_of_verdicts() -> None:
    _, content = written()
    spaces = {"c": "http://schemas.openxmlformats.org/drawingml/2006/chart"}
    with zipfile.ZipFile(io.BytesIO(content)) as parts:
        tree = ElementTree.fromstring(parts.read("xl/charts/chart1.xml"))
    headings = [cell.value for cell in opened()["Verdicts"][1]]
    columns = [
        headings[range_boundaries(cells.text.partition("!")[2].replace("$", ""))[0] - 1]
        for cells in tree.iterfind(".//c:val//c:f", spaces)
        if cells.text
    ]
    assert columns[3:5] == ["ok at every land", "ok in part"]
    assert wording("en").level(Verdict.OK) not in columns


def test_nothing_that_somebody_typed_is_a_formula_or_a_link() -> None:
    typed = ["=1+1", "http://example.org", "\x07bell", "'quoted"]
    made = summary(groups=tuple(typed[:2]), units=30, lands=3, name="=HYPERLINK(1)/{number}")
    listed = replace(made, by="=by", folder=typed[2])
    book = openpyxl.load_workbook(io.BytesIO(write_summary_workbook(listed)))
    cells = [cell for sheet in book for row in sheet.iter_rows() for cell in row if cell.value is not None]
    assert [cell for cell in cells if cell.data_type == "f" or cell.hyperlink is not None] == []
    assert {"=1+1", "http://example.org", "=HYPERLINK(1)/0", "bell", "=by"} <= {cell.value for cell in cells}


@pytest.mark.slow
@pytest.mark.parametrize("language", languages())
@pytest.mark.parametrize("units", ["metric", "metric_bar", "us"])
def test_another_program_reads_every_language_and_unit(language: str, units: str) -> None:
    made, content = written(language, units)
    say = wording(language, units)
    book = CalamineWorkbook.from_filelike(io.BytesIO(content))
    head, *others = book.get_sheet_by_name(say("fleet_sheets.temperatures")).to_python()
    places = {heading: number for number, heading in enumerate(head)}
    heading = f"{say('fleet_columns.pressure_mean')} [{say.unit('pressure')}]"
    classes = [each for body in made.bodies for each in body.temperatures]
    for row, each in zip(others, classes, strict=True):
        assert row[places[heading]] == pytest.approx(say.convert(each.pressure_mean_kpa, "pressure"), abs=1e-9)
        assert row[1] == pytest.approx(say.convert(each.low_c, "temperature"), abs=1e-9)
    assert head[1].endswith(f"[{say.unit('temperature')}]")
    assert len(set(head)) == len(head)
    assert content == write_summary_workbook(made, language=language, units=units)  # the same bytes


@pytest.mark.slow
@pytest.mark.parametrize(
    "case",
    [
        {"units": 1, "groups": (), "errors": False},
        {"units": 6, "logs": False, "mileage": False, "groups": ("a", "b")},
        {"units": 40, "flagged": False, "groups": ("only",)},
        {"units": 400, "groups": tuple(f"batch {number:02}" for number in range(12))},
        {"controllers": ("nowhere",), "units": 9, "keys": tuple((f"valve_{'long_' * 30}{n}", 1) for n in range(60))},
    ],
)
def test_whatever_a_fleet_is_it_can_be_read_back(case: dict[str, Any]) -> None:
    made = summary(**case)
    book = openpyxl.load_workbook(io.BytesIO(write_summary_workbook(made)))
    for laid_out in FleetTables(FleetWords(made, wording("en"))).all():
        assert book[laid_out.title].max_row == len(laid_out.rows) + 1
    assert ("Temperatures" in book.sheetnames) == case.get("logs", True)
    assert ("Rates compared" in book.sheetnames) == (len(case.get("groups", "abc")) > 1)
    replaced = [row["replace or worse, 95 % from [%]"] for row in rows(book["Verdicts"])]
    enough = made.counts.rates[Verdict.REPLACE].enough
    assert (replaced[0] is not None) == enough


@pytest.mark.slow
def test_the_overview_says_what_the_paper_says() -> None:
    made, _ = written()
    texts = [str(cell.value) for row in opened()["Overview"].iter_rows() for cell in row if cell.value is not None]
    words = FleetWords(made, wording("en"))
    assert words.headline() in texts
    for body in made.bodies:
        assert words.land(body.controller, body.pairs[0].key) in texts
        assert body.comparison is not None
        differ = [each for each in body.comparison.verdicts if each.points is not None and each.points.differs]
        assert all(any(words.difference_of_rates(each) in text for text in texts) for each in differ)
    assert {str(made.counts.rates[verdict].of) for verdict in FLAGGED} <= set(texts)
