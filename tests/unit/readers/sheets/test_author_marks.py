"""A comment on a reading is quoted and a colour of its own told: what an author marked is not averaged in silently."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Callable
from typing import Any

import openpyxl
import pytest
from openpyxl.comments import Comment
from openpyxl.styles import Font, PatternFill

from atleak.catalogue.controller import Controller
from atleak.common.errors import Message
from atleak.measurements.readings import Reading
from atleak.readers.cells.workbook_marks import marks
from atleak.readers.sheets.measuring_sheet import read_readings
from atleak.report.sheets.measuring_sheet import write_readings

RED, GREEN = PatternFill("solid", fgColor="FFFF0000"), PatternFill("solid", fgColor="FF00B050")
Change = Callable[[Any], None]


@pytest.fixture
def told(example: Controller, save_book: Callable[[openpyxl.Workbook], bytes]) -> Callable[..., list[Message]]:
    """Read a sheet of forty readings, changed by a test; return what is said of marks."""

    def read(change: Change, head: str = "Measurements") -> list[Message]:
        book = openpyxl.Workbook()
        book.active.append([head])
        book.active.append(["Valve", "Land", "Part", "Repeat", "Diameter [mm]", "Note"])
        for part, size in (("spool", 17.998), ("sleeve", 18.036)):
            for repeat in range(1, 21):
                book.active.append(["accumulator", 1, part, repeat, size + 0.001 * (repeat % 3)])
        change(book.active)
        readings = read_readings(save_book(book), example, name="sheet.xlsx")
        assert len(readings.readings) == 40
        return [each for each in readings.messages if each.code in ("readings_commented", "readings_coloured")]

    return read


def fill(colour: PatternFill, *cells: str) -> Change:
    def change(page: Any) -> None:
        for cell in cells:
            page[cell].fill = colour

    return change


@pytest.mark.parametrize(("cell", "words", "level"), [("E5", "rejected: burr", "warning"), ("A5", "by JK", "info")])
def test_a_comment_in_the_row_of_a_reading_is_quoted(
    told: Callable[..., list[Message]], cell: str, words: str, level: str
) -> None:
    def change(page: Any) -> None:
        page[cell].comment = Comment(words, "JK")
        page["A1"].comment = Comment("of nothing that is read", "JK")

    (message,) = told(change)
    assert (message.code, message.level, message.place.row) == ("readings_commented", level, 5)
    assert f"{cell}: {words!r}." in message.text
    assert "count all the same" in message.text


@pytest.mark.parametrize("count", [1, 4])
def test_few_readings_of_another_colour_are_told(told: Callable[..., list[Message]], count: int) -> None:
    cells = [f"E{row}" for row in range(6, 6 + count)]
    (message,) = told(fill(RED, *cells))
    assert (message.code, message.level, message.place.row) == ("readings_coloured", "warning", 6)
    assert f"{count} of 40 readings: {', '.join(cells)}." in message.text


def test_letters_of_another_colour_are_told_too_and_black_ones_are_none(told: Callable[..., list[Message]]) -> None:
    def change(page: Any) -> None:
        page["E7"].font = Font(color="FFC00000")
        page["E8"].font = Font(color="FF000000", bold=True)
        page["E9"].fill = PatternFill("solid", fgColor="FFFFFFFF")

    (message,) = told(change)
    assert "1 of 40 readings: E7." in message.text


def test_many_of_another_colour_are_told_and_most_are_the_usual_one(told: Callable[..., list[Message]]) -> None:
    (message,) = told(fill(RED, *(f"E{row}" for row in range(3, 15))))
    assert "12 of 40 readings: E3, E4, E5, E6 …." in message.text


def test_colours_of_whole_columns_and_of_other_cells_mean_nothing(told: Callable[..., list[Message]]) -> None:
    assert told(fill(GREEN, *(f"E{row}" for row in range(3, 43)))) == []
    assert told(fill(RED, "A1", "A5", "F5")) == []


def test_the_programs_own_sheet_says_nothing_of_its_colours(four_speed: Controller) -> None:
    land = four_speed.lands[0]
    given = [
        Reading(land.component, part, plane, direction, repeat, land.nominal_diameter + 40e-6 * (part == "sleeve"))
        for part in ("spool", "sleeve")
        for plane in land.planes
        for direction in (0.0, 90.0)
        for repeat in (1, 2)
    ]
    read = read_readings(write_readings(four_speed, given), four_speed)
    assert [each.code for each in read.messages if each.code.startswith("readings_")] == []


CONTENT = """<office:document-content xmlns:office="urn:oasis:names:tc:opendocument:xmlns:office:1.0"
 xmlns:table="urn:oasis:names:tc:opendocument:xmlns:table:1.0"
 xmlns:text="urn:oasis:names:tc:opendocument:xmlns:text:1.0"
 xmlns:style="urn:oasis:names:tc:opendocument:xmlns:style:1.0" xmlns:dc="http://purl.org/dc/elements/1.1/"
 xmlns:fo="urn:oasis:names:tc:opendocument:xmlns:xsl-fo-compatible:1.0"><office:automatic-styles>
<style:style style:name="red"><style:table-cell-properties fo:background-color="#ff0000"/></style:style>
<style:style style:name="plain"><style:text-properties fo:color="#000000"/></style:style></office:automatic-styles>
<office:body><office:spreadsheet><table:table table:name="S"><table:table-column table:number-columns-repeated="2"/>
<table:table-column table:default-cell-style-name="red"/><table:table-row>
<table:table-cell table:style-name="red"><text:p>1</text:p></table:table-cell>
<table:table-cell table:style-name="plain"><office:annotation><dc:date>2026</dc:date><text:p>rejected</text:p>
</office:annotation><text:p>2</text:p></table:table-cell>
<table:table-cell><text:p>3</text:p></table:table-cell></table:table-row></table:table></office:spreadsheet></office:body>
</office:document-content>"""


def test_an_ods_tells_its_comments() -> None:
    target = io.BytesIO()
    with zipfile.ZipFile(target, "w") as archive:
        archive.writestr("content.xml", CONTENT)
    found = marks(target.getvalue())["S"]
    assert found.comments == {(0, 1): "rejected"}
