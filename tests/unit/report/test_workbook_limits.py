"""What Excel asks of a workbook beyond the schema of its format, of every sheet; it opens no other without repair."""

from __future__ import annotations

import datetime as dt
import io
from collections.abc import Iterator
from typing import Any

import openpyxl
import pytest
from openpyxl.formula import Tokenizer
from openpyxl.utils import FORMULAE

from atleak.diagnosis.diagnosis import Diagnosis
from atleak.job.case import Case, SourceFile
from atleak.measurements.job_card import Job
from atleak.report.xlsx import write_workbook

ARGUMENTS, TEXT, FORMULA = 255, 255, 8192  # of a function, in a formula, of a whole formula
LINES = 250
STATES = ("proposed", "declined", "approved", "deferred", "done")
WRAPPING = ("Conditions", "Limits", "Constants", "Instruments", "Gauge readings", "Assumed", "Road test", "Messages")
NARROW = 0.75  # of a digit's width: a letter of a sentence, on average, in the narrowest font


def job_of_many_lines() -> Job:
    """A job whose estimate has many lines, their states mixed, and of some of them no price."""
    lines = [
        {"component": "25", "work": f"work {n}", "hours": 0.5, "decision": STATES[n % len(STATES)]}
        | ({"price": 10.0 + n} if n % 7 else {})
        for n in range(LINES)
    ]
    terms = {"currency": "EUR", "labour_rate": 80.0, "tax_percent": 19.0}
    return Job(date=dt.date(2026, 3, 14), estimate=terms, repair_decisions=lines)


@pytest.fixture(scope="module", params=["four", "five"])
def content(request: pytest.FixtureRequest, sample_diagnoses: dict[str, Diagnosis], sample_readings: Any) -> bytes:
    if request.param == "four":
        return write_workbook(sample_diagnoses["workshop"], job_of_many_lines())
    files = ("measuring_sheet_five_speed.xlsx", "gauge_readings_five_speed.csv")
    readings, gauges = (SourceFile.at(sample_readings.with_name(name)) for name in files)
    five = Case(controller="five_speed_2005", readings=readings, pressures=gauges).diagnose()
    return write_workbook(five, Job(date=dt.date(2026, 3, 14)))


@pytest.fixture(scope="module")
def book(content: bytes) -> openpyxl.Workbook:
    return openpyxl.load_workbook(io.BytesIO(content))


def arguments(formula: str) -> Iterator[int]:
    """How many arguments each function of a formula has."""
    counts: list[int] = []
    for token in Tokenizer(formula).items:
        if token.subtype == "OPEN":
            counts.append(1)
        elif token.subtype == "CLOSE":
            yield counts.pop()
        elif token.type == "SEP" and counts:
            counts[-1] += 1


def test_excel_takes_every_formula(book: openpyxl.Workbook) -> None:
    formulas = {str(cell.value) for sheet in book for row in sheet for cell in row if cell.data_type == "f"}
    assert len(formulas) > 1500
    assert max(map(len, formulas)) <= FORMULA
    tokens = [token for each in formulas for token in Tokenizer(each).items]
    assert {token.value[:-1] for token in tokens if token.type == "FUNC" and token.subtype == "OPEN"} <= FORMULAE
    assert max(len(token.value) - 2 for token in tokens if token.subtype == "TEXT") <= TEXT
    assert max(count for each in formulas for count in arguments(each)) <= ARGUMENTS


@pytest.mark.parametrize("content", ["four"], indirect=True)
def test_an_estimate_of_many_lines_adds_up(content: bytes, calculator: type) -> None:
    sheets = calculator(content)
    rows = {row[0].value: row for row in sheets.book["Estimate"].iter_rows(max_col=10)}
    for row in sheets.book["Estimate"].iter_rows(min_row=2, max_col=6):
        if row[4].value is None and row[5].data_type == "f":  # hours that nobody knows: the referee cannot skip them
            sheets.set("Estimate", row[4].coordinate, 0.0)
    parts = {state: sum(10.0 + n for n in range(at, LINES, len(STATES)) if n % 7) for at, state in enumerate(STATES)}
    parts["proposed, approved, done"] = parts["proposed"] + parts["approved"] + parts["done"]
    cached = sheets.cached()
    for name, known in parts.items():
        price, *others = [cell.coordinate for cell in rows[name] if cell.data_type == "f"]
        assert sheets.value("Estimate", price) == known
        assert [sheets.value("Estimate", each) for each in others] == [cached["Estimate", each] for each in others]
        assert len(others) == 5


def test_merged_cells_do_not_overlap_and_a_date_is_one(book: openpyxl.Workbook) -> None:
    for sheet in book:
        merged = [place for each in sheet.merged_cells.ranges for place in each.cells]
        assert len(merged) == len(set(merged)), sheet.title
    for name in ("Summary", "Job"):
        (day,) = [row[1] for row in book[name].iter_rows(max_col=2) if row[0].value == "date"]
        assert (day.value, day.number_format) == (dt.datetime(2026, 3, 14), "yyyy-mm-dd")


def test_no_text_is_cut_by_the_cell_beside_it_or_makes_the_page_wider(book: openpyxl.Workbook) -> None:
    for sheet in (book[name] for name in WRAPPING if name in book.sheetnames):
        widths = [0.0] * sheet.max_column
        for each in sheet.column_dimensions.values():
            widths[each.min - 1 : each.max] = [each.width] * (min(each.max, len(widths)) - each.min + 1)
        for row in sheet.iter_rows():
            for at, cell in enumerate(row):
                if cell.data_type == "s" and not cell.alignment.wrap_text:
                    beside = next((n for n in range(at + 1, len(row)) if row[n].value is not None), len(row))
                    assert len(cell.value) * NARROW <= sum(widths[at:beside]), (sheet.title, cell.value)


def test_a_date_before_those_that_excel_knows_is_written_as_words(sample_diagnoses: dict[str, Diagnosis]) -> None:
    content = write_workbook(sample_diagnoses["workshop"], Job(date=dt.date(1206, 3, 14)))
    sheet = openpyxl.load_workbook(io.BytesIO(content))["Summary"]
    assert [row[1].value for row in sheet.iter_rows(max_col=2) if row[0].value == "date"] == ["1206-03-14"]
