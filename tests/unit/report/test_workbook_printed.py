"""The workbook on paper: legible letters, headings on every page, no raw series; and no number that stands as text."""

from __future__ import annotations

import io
import zipfile
from typing import Any

import openpyxl
import pypdfium2
import pytest
from openpyxl.utils import get_column_letter, range_boundaries

from atleak.analysis.repair.plan import plan_repairs
from atleak.common.sentences import Sentence
from atleak.common.wording import wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.measurements.job_card import Job
from atleak.report.xlsx import write_workbook

LEAST = 6.0  # [pt]
PAPERS = {"9": (210.0, 297.0), "1": (215.9, 279.4)}  # A4 and Letter [mm]
ONE_TABLE = {
    *("Lands", "Land by condition", "Rules", "Conditions", "Limits", "Constants", "Estimate", "Messages"),
    *("Road test events", "Instruments", "Readings", "Directions"),
}  # sheets with one row of headings
FOR_SCREEN = {"Readings", "What was read", "Directions", "Gaps", "Gaps hot idle"}
OF_NAMES = ("component", "plane", "flagged", "number")  # headings of what is a name, though it looks like a number
JOB = Job(
    number="7",
    estimate={"currency": "EUR", "labour_rate": 80.0, "tax_percent": 19.0},
    repair_decisions=[{"component": "25", "work": "sleeve", "price": 120.0, "hours": 1.5, "decision": "proposed"}],
)


@pytest.fixture(scope="module")
def found(sample_diagnoses) -> Diagnosis:
    """The sample job, with its road test."""
    return sample_diagnoses["workshop"]


@pytest.fixture(scope="module", params=["a4", "letter"])
def content(request: pytest.FixtureRequest, found: Diagnosis) -> bytes:
    assert plan_repairs(found).order
    return write_workbook(found, JOB, paper=request.param)


@pytest.fixture(scope="module")
def book(content: bytes) -> openpyxl.Workbook:
    return openpyxl.load_workbook(io.BytesIO(content))


def printed(sheet: Any) -> tuple[int, int, int, int]:
    """First column, first row, last column and last row of what is printed."""
    area = sheet.print_area
    return range_boundaries(area.rpartition("!")[2].replace("$", "")) if area else range_boundaries(sheet.dimensions)


def scale_of(sheet: Any) -> float:
    """At which it is printed: as wide as its page, and as high where it is to stand on one."""
    first, top, last, bottom = printed(sheet)
    widths = {
        column: each.width for each in sheet.column_dimensions.values() for column in range(each.min, each.max + 1)
    }
    wide = sum(7 * widths.get(column, 9.0) for column in range(first, last + 1)) / 96  # [in]
    high = sum(sheet.row_dimensions[row].height or 15.0 for row in range(top, bottom + 1)) / 72
    paper = PAPERS[str(sheet.page_setup.paperSize)]
    across, down = paper if sheet.page_setup.orientation == "portrait" else paper[::-1]
    margins = sheet.page_margins
    scales = [(across / 25.4 - margins.left - margins.right) / wide]
    pages = int(sheet.page_setup.fitToHeight if sheet.page_setup.fitToHeight is not None else 1)
    repeated = (pages - 1) * (sheet.row_dimensions[1].height or 15.0) / 72
    scales += [(down / 25.4 - margins.top - margins.bottom) * pages / (high + repeated)] if pages else []
    return min(1.0, *scales)


def test_the_smallest_letters_that_are_printed_can_be_read(book):
    for sheet in book:
        first, top, last, bottom = printed(sheet)
        sizes = [
            cell.font.sz for row in sheet.iter_rows(top, bottom, first, last) for cell in row if cell.value is not None
        ]
        assert bool(sizes) != (sheet.title in FOR_SCREEN)
        assert min(sizes, default=10.0) * scale_of(sheet) >= LEAST, sheet.title


def test_headings_come_again_on_every_page_and_the_series_of_the_road_test_is_not_printed(book):
    for sheet in book:
        assert (sheet.print_title_rows == "$1:$1") == (sheet.title in ONE_TABLE or sheet.title.startswith("Gaps"))
    road = book["Road test"]
    *_, bottom = printed(road)
    assert str(road.cell(bottom + 1, 1).value).startswith("time [")
    assert road.max_row - bottom > 1000


def test_what_looks_like_a_number_and_is_text_is_a_name(book, content):
    for sheet in book:
        for row in sheet.iter_rows():
            for cell in row:
                if cell.data_type == "s" and cell.value.replace(".", "", 1).isdigit() and sheet.title in ONE_TABLE:
                    assert str(sheet.cell(1, cell.column).value).startswith(OF_NAMES), (sheet.title, cell.coordinate)
    with zipfile.ZipFile(io.BytesIO(content)) as parts:
        sheets = [parts.read(name).decode() for name in parts.namelist() if name.startswith("xl/worksheets/sheet")]
    assert len(sheets) == len(book.sheetnames)
    assert all('<ignoredError sqref="A1:XFD1048576" numberStoredAsText="1"/>' in sheet for sheet in sheets)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("language", "units", "paper"),
    [("en", "metric", "a4"), ("en", "us", "letter"), ("de", "metric", "a4"), ("pl", "metric", "a4")],
)
def test_the_whole_workbook_of_the_sample_job_takes_twenty_pages(found, language, units, paper, tmp_path, convert):
    (tmp_path / "report.xlsx").write_bytes(write_workbook(found, JOB, language=language, units=units, paper=paper))
    convert(tmp_path / "report.xlsx", "pdf")
    with pypdfium2.PdfDocument(tmp_path / "report.pdf") as document:
        assert len(document) <= 20
        feet = [page.get_textpage().get_text_range() for page in document]
    screen = [
        wording(language).sentence(Sentence(name)) for name in ("Readings", "What was read", "Directions", "Gaps")
    ]
    assert not [name for name in screen for text in feet if text.startswith(f"{name}\r\n")]


def test_widths_are_those_of_letters_that_are_as_wide_in_every_program(book):
    fonts = {(cell.font.name, cell.font.sz) for cell in book["Lands"][2]}
    assert fonts == {("Arial", 10.0)}
    assert get_column_letter(printed(book["Lands"])[2]) >= "L"  # up to the wear at least
