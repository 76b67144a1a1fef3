"""Rows and cells that hold numbers and no reading: means and sums, what was hidden, crossed out or called void."""

from __future__ import annotations

import io
import zipfile
from contextlib import nullcontext
from xml.etree.ElementTree import ParseError

import openpyxl
import pytest
from openpyxl.cell.rich_text import CellRichText, TextBlock
from openpyxl.cell.text import InlineFont
from openpyxl.styles import Font

from atleak.catalogue.controller_file import load_controller
from atleak.common.errors import ReadingsError
from atleak.readers.cells import workbook_marks
from atleak.readers.cells.workbook_marks import marks
from atleak.readers.sheets.measuring_sheet import read_readings
from tests.effort import in_time, most_calls


def sheet(*lines):
    return "\n".join(lines).encode()


def sizes(readings):
    return [(each.component, each.part, each.repeat, round(each.diameter * 1e3, 6)) for each in readings.readings]


def said(readings, code):
    return [message.text for message in readings.messages if message.code == code]


ENGLISH, GERMAN = "Valve;Land;Part;Diameter [mm]", "Ventil;Steg;Teil;Durchmesser [mm]"
POLISH = "Zawór;Land;Część;Średnica [mm]"
PISTON = [("accumulator", "spool", 1, 17.998), ("accumulator", "spool", 2, 17.996)]

# --- rows of means and sums -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("headings", "part", "word"),
    [
        ("Valve;Land;Part;Measurement;Diameter [mm]", "piston", "mean"),
        ("Valve;Land;Part;Measurement No.;Diameter [mm]", "piston", "Average"),
        ("Valve;Land;Part;Repeat;Diameter [mm]", "piston", "avg."),
        ("Valve;Land;Part;Repeat;Diameter [mm]", "piston", "Ø"),
        ("Valve;Land;Part;Repeat;Diameter [mm]", "piston", "x̄"),
        ("Ventil;Steg;Teil;Messung;Durchmesser [mm]", "Kolben", "Mittelwert"),
        ("Ventil;Steg;Teil;Wiederholung;Durchmesser [mm]", "Kolben", "MW"),
        ("Zawór;Land;Część;Pomiar;Średnica [mm]", "tłok", "średnia"),
        ("Zawór;Land;Część;Powtórzenie;Średnica [mm]", "tłok", "śr."),
    ],
)
def test_a_row_of_means_is_left_aside(controller, headings, part, word):
    rows = [f"accumulator;1;{part};{at};{size}" for at, size in ((1, 17.998), (2, 17.996), (word, 17.997))]
    readings = read_readings(sheet(headings, *rows), controller)
    assert sizes(readings) == PISTON
    assert said(readings, "summaries_left_aside") == ["1 row of means left aside (row 4)"]
    assert not said(readings, "summary_disagrees")


@pytest.mark.parametrize("remark", ["mean", "Mittelwert aus 2 Messungen", "wartość średnia", "x-bar = average"])
def test_a_remark_says_so_too(controller, remark):
    readings = read_readings(
        sheet(
            "Valve;Land;Part;Diameter [mm];Remark",
            "accumulator;1;piston;17.998;",
            "accumulator;1;piston;17.996;",
            f"accumulator;1;piston;17.997;{remark}",
        ),
        controller,
    )
    if remark.startswith("x-bar"):  # more than a word for a mean
        assert len(readings.readings) == 3
    else:
        assert sizes(readings) == PISTON


@pytest.mark.parametrize(
    ("headings", "part", "key", "grand", "kind", "numbers"),
    [
        (ENGLISH, "piston", "accumulator Average", "Grand Average", "means", (17.997, 17.997)),
        (ENGLISH, "piston", "accumulator Total", "Grand Total", "sums", (35.994, 35.994)),
        (GERMAN, "Kolben", "accumulator Ergebnis", "Gesamtergebnis", "sums", (35.994, 35.994)),
        (GERMAN, "Kolben", "accumulator Mittelwert", "Gesamtmittelwert", "means", (17.997, 17.997)),
        (POLISH, "tłok", "accumulator Suma", "Suma końcowa", "sums", (35.994, 35.994)),
        (
            "Zawór;Land;Część;Średnica [mm]",
            "tłok",
            "accumulator Średnia",
            "Średnia całkowita",
            "means",
            (17.997, 17.997),
        ),
    ],
)
def test_subtotals_of_a_spreadsheet_program(controller, headings, part, key, grand, kind, numbers):
    readings = read_readings(
        sheet(
            headings,
            f"accumulator;1;{part};17.998",
            f"accumulator;1;{part};17.996",
            f"{key};;;{numbers[0]}",
            f"{grand};;;{numbers[1]}",
        ),
        controller,
    )
    assert sizes(readings) == PISTON
    assert said(readings, "summaries_left_aside") == [f"2 rows of {kind} left aside (rows 4–5)"]
    assert not said(readings, "summary_disagrees")


def test_a_mean_that_is_not_that_of_the_rows_above_it(controller):
    readings = read_readings(
        sheet(
            "Valve;Land;Part;Repeat;Diameter [mm]",
            "accumulator;1;piston;1;17.998",
            "accumulator;1;piston;2;17.996",
            "accumulator;1;piston;mean;17.987",
        ),
        controller,
    )
    assert sizes(readings) == PISTON
    text = "the mean 17.987 stands in row 4, but that of rows 2–3 is 17.997: a slip in one of them"
    assert said(readings, "summary_disagrees") == [text]


def test_a_mean_without_its_readings_is_one_reading(controller):
    readings = read_readings(
        sheet(
            "Valve;Land;Part;Repeat;Diameter [mm]",
            "accumulator;1;piston;1;17.998",
            "accumulator;1;piston;2;17.996",
            "accumulator;1;bore;mean;18.042",
        ),
        controller,
    )
    assert sizes(readings) == [*PISTON, ("accumulator", "sleeve", 1, 18.042)]
    assert len(said(readings, "summary_as_reading")) == 1


def test_largest_and_smallest_values_beside_their_readings(controller):
    readings = read_readings(
        sheet(
            "Valve;Land;Part;Direction;Diameter [mm]",
            *("accumulator;1;piston;0;17.998", "accumulator;1;piston;90;17.996"),
            *("accumulator;1;piston;max;17.998", "accumulator;1;piston;min;17.996"),
        ),
        controller,
    )
    assert [reading[3] for reading in sizes(readings)] == [17.998, 17.996]
    assert len(said(readings, "summaries_left_aside")) == 2


@pytest.mark.parametrize("heading", ["Measurement", "Measurement No.", "Messung", "Messung Nr.", "Pomiar", "Reading"])
def test_a_column_that_counts_is_no_diameter(controller, heading):
    rows = [
        f"{at};accumulator;1;{part};{size}" for part, size in (("piston", 17.998), ("bore", 18.041)) for at in (2, 1)
    ]
    data = sheet(f"{heading};Valve;Land;Part;Diameter [mm]", *rows)
    mapping = {}
    if heading == "Reading":  # as good a word for the other column
        with pytest.raises(ReadingsError, match=r"--map .value=Diameter"):
            read_readings(data, controller)
        mapping = {"value": "Diameter [mm]", "repeat": heading}
    assert [reading[2] for reading in sizes(read_readings(data, controller, mapping=mapping))] == (
        [2, 1, 2, 1] if mapping else [1, 2, 1, 2]
    )


def test_a_measurement_by_its_number_is_no_component(controller):
    """The controller of the source study numbers its components, and yet this number names none of them."""
    study = load_controller("four_speed_2023")
    land = study.lands[0]
    name = study.components[land.component]
    size = land.nominal_diameter * 1e3
    readings = read_readings(
        sheet(
            "Messung Nr.;Ventil;Ebene;Teil;Durchmesser [mm]",
            *(f"{at};{name};{land.planes[0]};Kolben;{size}" for at in (1, 2)),
        ),
        study,
    )
    assert {reading.component for reading in readings.readings} == {land.component}


# --- rows that do not count -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("headings", "part", "heading", "yes", "no"),
    [
        ("Valve;Land;Part;Diameter [mm]", "piston", "Valid", "yes", "no"),
        ("Valve;Land;Part;Diameter [mm]", "piston", "Use (y/n)", "y", "n"),
        ("Valve;Land;Part;Diameter [mm]", "piston", "Counts", "1", "0"),
        ("Valve;Land;Part;Diameter [mm]", "piston", "Use?", "x", ""),
        ("Valve;Land;Part;Diameter [mm]", "piston", "Outlier", "", "x"),
        ("Valve;Land;Part;Diameter [mm]", "piston", "Remark", "", "rejected"),
        ("Ventil;Steg;Teil;Durchmesser [mm]", "Kolben", "Gültig", "ja", "nein"),
        ("Ventil;Steg;Teil;Durchmesser [mm]", "Kolben", "Bemerkung", "", "Ausreißer"),
        ("Valve;Land;Part;Diameter [mm]", "piston", "Remark", "", "ignore"),
        ("Zawór;Land;Część;Średnica [mm]", "tłok", "Ważny", "tak", "nie"),
    ],
)
def test_a_row_that_does_not_count_is_left_aside_and_named(controller, headings, part, heading, yes, no):
    readings = read_readings(
        sheet(
            f"{headings};{heading}",
            f"accumulator;1;{part};17.998;{yes}",
            f"accumulator;1;{part};17.900;{no}",
            f"accumulator;1;{part};17.996;{yes}",
        ),
        controller,
    )
    assert sizes(readings) == PISTON
    (text,) = said(readings, "rejected_left_aside")
    assert text.startswith("1 row left aside, because")
    assert text.endswith("(row 3)")


def test_out_of_tolerance_is_a_reading(controller):
    rows = ["accumulator;1;piston;17.998;yes", "accumulator;1;bore;18.141;no"]
    readings = read_readings(sheet("Valve;Land;Part;Diameter [mm];OK?", *rows), controller)
    assert len(readings.readings) == 2


# --- hidden and crossed out -------------------------------------------------------------------------------------------

TIDY = (
    ("Valve", "Land", "Part", "Diameter [mm]"),
    ("accumulator", 1, "piston", 17.998),
    ("accumulator", 1, "piston", 17.900),
    ("accumulator", 1, "piston", 17.996),
)
WIDE = (
    ("Valve", "Land", "Piston 1 [mm]", "Piston 2 [mm]", "Bore 1 [mm]"),
    ("accumulator", 1, 17.998, 17.900, 18.041),
)


@pytest.fixture
def book(save_book):
    def build(rows, change):
        made = openpyxl.Workbook()
        for row in rows:
            made.active.append(list(row))
        change(made.active)
        return save_book(made)

    return build


def hide_row(page, row=3, level=0):
    page.row_dimensions[row].hidden = True
    page.row_dimensions[row].outlineLevel = level


def test_rows_hidden_by_hand_are_left_aside_and_named(controller, book):
    readings = read_readings(book(TIDY, hide_row), controller)
    assert sizes(readings) == PISTON
    assert said(readings, "hidden_rows")[0].startswith("1 row with readings, hidden by hand: left aside")


def test_rows_under_a_filter_are_read(controller, book):
    def change(page):
        page.auto_filter.ref = "A1:D4"
        page.auto_filter.add_filter_column(3, ["17.998"])
        hide_row(page)

    readings = read_readings(book(TIDY, change), controller)
    assert [reading[3] for reading in sizes(readings)] == [17.998, 17.900, 17.996]
    assert said(readings, "hidden_rows") == ["1 row with readings, hidden by a filter: read all the same (row 3)"]


def test_rows_of_a_folded_outline_are_read(controller, book):
    readings = read_readings(book(TIDY, lambda page: hide_row(page, level=1)), controller)
    assert len(readings.readings) == 3
    assert "in a folded outline" in said(readings, "hidden_rows")[0]


def test_every_row_hidden(controller, book):
    def change(page):
        for row in (2, 3, 4):
            hide_row(page, row)

    with pytest.raises(ReadingsError, match="no reading is left: 3 rows with readings, hidden by hand"):
        read_readings(book(TIDY, change), controller)


def test_a_hidden_column_is_not_read_while_a_visible_one_holds_the_part(controller, book):
    def change(page):
        page.column_dimensions["D"].hidden = True

    readings = read_readings(book(WIDE, change), controller)
    assert [reading[3] for reading in sizes(readings)] == [17.998, 18.041]
    text = "hidden column 'Piston 2 [mm]' left aside, because a visible column holds the same part"
    assert said(readings, "hidden_columns") == [text]
    assert not said(readings, "not_read")


def test_a_hidden_column_that_alone_holds_a_part_is_read(controller, book):
    def change(page):
        page.column_dimensions["E"].hidden = True

    readings = read_readings(book(WIDE, change), controller)
    assert len(readings.readings) == 3
    assert said(readings, "hidden_columns")[0].startswith("hidden column 'Bore 1 [mm]' read")


@pytest.mark.parametrize("cells", ["D3", "A3"])
def test_a_crossed_out_reading_is_left_aside_and_named(controller, book, cells):
    def change(page):
        page[cells].font = Font(strike=True)

    readings = read_readings(book(TIDY, change), controller)
    assert sizes(readings) == PISTON
    assert said(readings, "struck_left_aside") == ["1 row with a crossed-out reading: it was left aside (row 3)"]
    assert not said(readings, "rows_not_measured")


def test_a_number_as_text_with_its_letters_crossed_out(controller, book):
    def change(page):
        page["D3"] = CellRichText(TextBlock(InlineFont(strike=True), "17,900"))

    assert sizes(read_readings(book(TIDY, change), controller)) == PISTON


def test_a_crossed_out_cell_of_a_row_with_several(controller, book):
    def change(page):
        page["D2"].font = Font(strike=True)

    readings = read_readings(book(WIDE, change), controller)
    assert [reading[3] for reading in sizes(readings)] == [17.998, 18.041]


ODS = """<?xml version="1.0" encoding="UTF-8"?>
<office:document-content xmlns:office="urn:oasis:names:tc:opendocument:xmlns:office:1.0"
 xmlns:table="urn:oasis:names:tc:opendocument:xmlns:table:1.0"
 xmlns:text="urn:oasis:names:tc:opendocument:xmlns:text:1.0"
 xmlns:style="urn:oasis:names:tc:opendocument:xmlns:style:1.0"><office:automatic-styles>
<style:style style:name="ce1" style:family="table-cell"><style:text-properties
 style:text-line-through-style="solid"/></style:style></office:automatic-styles>
<office:body><office:spreadsheet><table:table table:name="Blatt">
<table:table-column/><table:table-column table:visibility="collapse" table:number-columns-repeated="2"/>
<table:table-row><table:table-cell><text:p>a</text:p></table:table-cell></table:table-row>
<table:table-row table:visibility="collapse"><table:table-cell><text:p>b</text:p></table:table-cell></table:table-row>
<table:table-row table:visibility="filter"><table:table-cell><text:p>c</text:p></table:table-cell></table:table-row>
<table:table-row-group table:display="false"><table:table-row table:visibility="collapse">
<table:table-cell><text:p>d</text:p></table:table-cell></table:table-row></table:table-row-group>
<table:table-row><table:table-cell table:number-columns-repeated="2"/>
<table:table-cell table:style-name="ce1"><text:p>e</text:p></table:table-cell></table:table-row>
<table:table-row table:visibility="collapse" table:number-rows-repeated="1048571"><table:table-cell/></table:table-row>
</table:table></office:spreadsheet></office:body></office:document-content>"""


def archive(**parts):
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as made:
        for name, content in parts.items():
            made.writestr(name.replace("__", "/").replace("_xml", ".xml"), content)
    return buffer.getvalue()


def test_marks_of_an_opendocument_sheet():
    sheet_marks = marks(archive(content_xml=ODS))["Blatt"]
    assert sheet_marks.hidden_rows == {1: "by hand", 2: "by a filter", 3: "in a folded outline"}
    assert marks(archive(content_xml=ODS.replace(' table:display="false"', "")))["Blatt"] == sheet_marks
    assert sheet_marks.hidden_columns == {1, 2}
    assert sheet_marks.struck == {(4, 2)}


def test_a_part_that_unpacks_to_too_much_is_not_looked_through(monkeypatch):
    monkeypatch.setattr(workbook_marks, "PART_LIMIT", 100)
    with pytest.raises(zipfile.BadZipFile, match=r"content.xml unpacks to more than"):
        marks(archive(content_xml=ODS))


def test_marks_are_cheap_even_where_the_xml_is_hostile(book):
    def change(page):
        page["D3"].font = Font(strike=True)

    data = book([TIDY[0], *[TIDY[1]] * 5000], change)
    with most_calls(5_000_000):
        assert marks(data)["Sheet"].struck == {(2, 3)}
    source = zipfile.ZipFile(io.BytesIO(data))
    parts = {name: source.read(name) for name in source.namelist()}
    wide, broken = b'<col min="1" max="16384" hidden="1"/>' * 200_000, b'<c hidden="1" <row <c s="1" ' * 200_000
    for xml, told in (
        (b"<x><cols>" + wide + b"</cols></x>", nullcontext()),
        (b"<x>" + broken, pytest.raises(ParseError)),
    ):
        buffer = io.BytesIO()
        with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as made:
            for name, content in (parts | {"xl/worksheets/sheet1.xml": xml}).items():
                made.writestr(name, content)
        with in_time(), told:
            assert len(marks(buffer.getvalue())["Sheet"].hidden_columns) == 16384
