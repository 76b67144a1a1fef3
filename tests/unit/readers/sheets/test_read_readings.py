"""Each form of measuring sheet that atleak knows is read."""

from __future__ import annotations

import datetime
import subprocess
import sys
import zipfile
from io import BytesIO

import openpyxl
import pytest
import xlsxwriter

from atleak.common.errors import ReadingsError
from atleak.measurements.clearances import clearances
from atleak.readers.sheets.measuring_sheet import read_readings

TABLE_1 = (
    *("No. Acc. to Figure 8", "Component", "Measurement Plane", "Measurement Direction:"),
    *("Coordinate\nx1 (y1) [mm]", "Coordinate\nx2 (y2) [mm]"),
    *("Diameter:\nx1-x2 (y1-y2)\n[mm]", "Diameter Mean Value\ndi (Di) [mm]"),
)


@pytest.fixture(scope="module")
def controller(three_pairs):
    return three_pairs


def sizes(readings):
    """Return the diameters in mm by what they are of, to a nanometre."""
    return {
        (each.component, each.part, each.plane, each.direction, each.repeat): round(each.diameter * 1e3, 6)
        for each in readings.readings
    }


def codes(readings):
    return [message.code for message in readings.messages]


EXPECTED = {
    ("6", "spool", "1", 0.0, 1): 9.939,
    ("6", "spool", "1", 0.0, 2): 9.940,
    ("6", "spool", "1", 90.0, 1): 9.938,
    ("6", "spool", "1", 90.0, 2): 9.939,
    ("6", "sleeve", "1", 0.0, 1): 9.995,
    ("6", "sleeve", "1", 0.0, 2): 9.996,
    ("6", "sleeve", "1", 90.0, 1): 10.001,
    ("6", "sleeve", "1", 90.0, 2): 10.002,
}


def test_a_tidy_workbook(controller, make_workbook, tidy):
    readings = read_readings(make_workbook(tidy()), controller, name="job 7.xlsx")
    assert sizes(readings) == EXPECTED
    assert (readings.file, readings.sheet, readings.layout) == ("job 7.xlsx", "Readings", "tidy")
    assert (readings.unit, readings.unit_assumed, readings.messages) == ("mm", False, ())
    assert (readings.readings[0].place.row, readings.readings[0].place.column) == (2, "F")
    assert len(readings.sha256) == 64


def test_the_name_of_a_path_is_its_own(controller, make_text, tidy, tmp_path):
    path = tmp_path / "Schieber 6 übermaß.csv"
    path.write_bytes(make_text(tidy()))
    for source in (path, str(path)):
        readings = read_readings(source, controller)
        assert (readings.file, readings.sheet) == (path.name, None)
        assert readings.readings[0].place.column == "diameter_mm"
        assert readings.readings[0].place.row == 2


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "cp1252", "cp1250"])
@pytest.mark.parametrize("delimiter", [",", ";", "\t", "|"])
def test_text_in_any_encoding_and_with_any_delimiter(controller, make_text, tidy, encoding, delimiter):
    readings = read_readings(make_text(tidy(), delimiter=delimiter, encoding=encoding), controller)
    assert sizes(readings) == EXPECTED
    assert codes(readings) == ["read_as"]


@pytest.mark.parametrize("delimiter", [";", "\t"])
def test_decimal_commas_in_text(controller, make_text, tidy, delimiter):
    rows = [[str(cell).replace(".", ",") for cell in row] for row in tidy()]
    assert sizes(read_readings(make_text(rows, delimiter=delimiter), controller)) == EXPECTED


def test_decimal_commas_in_quotes_between_commas(controller, make_text, tidy):
    rows = [[*row[:-1], f'"{row[-1]}"'.replace(".", ",")] for row in tidy()]
    assert sizes(read_readings(make_text(rows), controller)) == EXPECTED


def test_decimal_commas_and_units_in_cells_of_a_workbook(controller, make_workbook, tidy):
    rows = [[*row[:-1], f"{row[-1]:.3f}\u00a0mm".replace(".", ",")] for row in tidy()[1:]]
    readings = read_readings(
        make_workbook([("component", "part", "plane", "direction", "repeat", "diameter"), *rows]), controller
    )
    assert sizes(readings) == EXPECTED
    assert (readings.unit, readings.unit_assumed) == ("mm", False)


def test_excel_says_which_delimiter(controller, make_text, tidy):
    data = b"sep=;\r\n" + make_text(tidy(), delimiter=";")
    readings = read_readings(data, controller)
    assert sizes(readings) == EXPECTED
    assert readings.readings[0].place.row == 3


@pytest.mark.parametrize(
    ("heading", "factor", "unit"),
    [
        ("diameter_um", 1e3, "µm"),
        ("Diameter [µm]", 1e3, "µm"),
        ("Diameter (μm)", 1e3, "µm"),
        ("Diameter in micron", 1e3, "µm"),
        ("Durchmesser [mm]", 1.0, "mm"),
        ("Średnica [mm]", 1.0, "mm"),
        ("diameter, inch", 1 / 25.4, "inch"),
        ('Diameter ["]', 1 / 25.4, "inch"),
        ("Ø in mm", 1.0, "mm"),
        ("Reading [mm]", 1.0, "mm"),
    ],
)
def test_units_in_headings(controller, make_workbook, tidy, heading, factor, unit):
    rows = [[*row[:-1], row[-1] * factor] for row in tidy()[1:]]
    readings = read_readings(
        make_workbook([("component", "part", "plane", "direction", "repeat", heading), *rows]), controller
    )
    assert sizes(readings) == EXPECTED
    assert (readings.unit, readings.unit_assumed) == (unit, False)


@pytest.mark.parametrize(("factor", "unit"), [(1.0, "mm"), (1e3, "µm"), (1 / 25.4, "inch"), (0.1, "cm")])
def test_a_missing_unit_is_told_by_the_nominal_diameters_and_flagged(controller, make_workbook, tidy, factor, unit):
    rows = [("component", "part", "plane", "direction", "repeat", "diameter")]
    rows += [(*row[:-1], row[-1] * factor) for row in tidy()[1:]]
    readings = read_readings(make_workbook(rows), controller)
    assert sizes(readings) == EXPECTED
    assert (readings.unit, readings.unit_assumed) == (unit, True)
    message = readings.messages[0]
    assert (message.level, message.code, message.place.row, message.place.column) == ("warning", "unit_assumed", 1, "F")
    assert unit in message.text


def test_a_unit_that_is_told_goes_before_the_heading_and_is_mentioned(controller, make_workbook, tidy):
    rows = [tidy()[0], *[(*row[:-1], row[-1] * 1000) for row in tidy()[1:]]]
    readings = read_readings(make_workbook(rows), controller, unit="um")
    assert sizes(readings) == EXPECTED
    assert codes(readings) == ["unit_told"]


@pytest.mark.parametrize("preamble", [("Unit: mm",), ("Units", "mm"), ("All dimensions in mm",), ("Maße in mm",)])
def test_a_unit_above_the_table(controller, make_workbook, tidy, preamble):
    rows = [
        ("Workshop sheet", "job 12"),
        preamble,
        (),
        ("component", "part", "plane", "direction", "repeat", "diameter"),
    ]
    readings = read_readings(make_workbook([*rows, *tidy()[1:]]), controller)
    assert sizes(readings) == EXPECTED
    assert not readings.unit_assumed


def test_a_unit_in_its_own_column(controller, make_workbook, tidy):
    rows = [("component", "part", "plane", "direction", "repeat", "diameter", "unit")]
    for index, row in enumerate(tidy()[1:]):
        rows.append((*row, "mm") if index % 2 else (*row[:-1], row[-1] * 1000, "µm"))
    readings = read_readings(make_workbook(rows), controller)
    assert sizes(readings) == EXPECTED
    assert readings.unit == "µm, mm"


def test_a_row_of_units_under_the_headings(controller, make_workbook, tidy):
    rows = [
        ("component", "part", "plane", "direction", "repeat", "diameter"),
        ("", "", "", "[°]", "", "[mm]"),
        *tidy()[1:],
    ]
    readings = read_readings(make_workbook(rows), controller)
    assert sizes(readings) == EXPECTED
    assert not readings.unit_assumed


def test_table_1_as_a_workbook_with_merged_cells(controller, make_workbook):
    def coordinates(diameter):
        return 50.0 + diameter, 50.0, diameter

    rows = [
        ("Measurement of controller no. 3",),
        TABLE_1,
        (6, "spool", 1, "0°", *coordinates(9.939), 9.939),
        ("", "", "", "", *coordinates(9.940), ""),
        ("", "", "", "90°", *coordinates(9.938), ""),
        ("", "", "", "", *coordinates(9.939), ""),
        ("", "sleeve", 1, "0°", *coordinates(9.995), 9.9985),
        ("", "", "", "", *coordinates(9.996), ""),
        ("", "", "", "90°", *coordinates(10.001), ""),
        ("", "", "", "", *coordinates(10.002), ""),
    ]
    merge = ["A3:A10", "B3:B6", "B7:B10", "C3:C6", "C7:C10", "D3:D4", "D5:D6", "D7:D8", "D9:D10", "H3:H6", "H7:H10"]
    readings = read_readings(make_workbook(rows, merge=merge), controller)
    assert sizes(readings) == EXPECTED
    assert readings.layout == "table"
    assert readings.readings[0].coordinates == pytest.approx((59.939e-3, 50e-3), rel=1e-9, abs=0.0)
    assert readings.readings[4].place.row == 7


def test_a_merged_diameter_is_one_reading_not_two(controller, make_workbook, tidy):
    rows = tidy({1: ("6", "spool", "1", "0°", 2, "")})
    readings = read_readings(make_workbook(rows, merge=["F2:F3"]), controller)
    assert len(readings.readings) == 7


def test_columns_in_another_order_with_columns_that_do_not_matter(controller, make_workbook, tidy):
    names, *rows = tidy()
    order = [5, 3, 0, 4, 2, 1]
    shuffled = [("Remarks", *[names[index] for index in order], "Nominal diameter [mm]", "Check", "Date")]
    shuffled += [("ok", *[row[index] for index in order], 77.0, "x", datetime.date(2026, 1, 2)) for row in rows]
    assert sizes(read_readings(make_workbook(shuffled), controller)) == EXPECTED


@pytest.mark.parametrize(
    "headings",
    [
        ("Nr. nach Bild 8", "Bauteil", "Messebene", "Messrichtung", "Wiederholung", "Durchmesser [mm]"),
        ("Ventil", "Teil", "Ebene", "Richtung", "Messung Nr. Wiederholung", "Durchmesser [mm]"),
        ("Nr elementu", "Część", "Płaszczyzna", "Kierunek", "Powtórzenie", "Średnica [mm]"),
        ("Item", "Part", "Plane", "Angle", "Rep", "Dia. (mm)"),
        ("component", "spool/sleeve", "land/plane", "direction", "repeat", "value_mm"),
    ],
)
@pytest.mark.parametrize(
    "parts", [("spool", "sleeve"), ("Schieber", "Bohrung"), ("Tłok", "Tuleja"), ("d", "D"), ("PISTON", "Bore")]
)
def test_headings_and_parts_in_three_languages(controller, make_workbook, tidy, headings, parts):
    words = dict(zip(("spool", "sleeve"), parts, strict=True))
    rows = [(row[0], words[row[1]], *row[2:]) for row in tidy()[1:]]
    assert sizes(read_readings(make_workbook([headings, *rows]), controller)) == EXPECTED


def test_polish_headings_in_the_windows_code_page(controller, make_text, tidy):
    headings = ("Nr elementu", "Część", "Płaszczyzna", "Kierunek", "Powtórzenie", "Średnica [mm]")
    words = {"spool": "tłok", "sleeve": "otwór"}
    rows = [(row[0], words[row[1]], *row[2:]) for row in tidy()[1:]]
    readings = read_readings(make_text([headings, *rows], delimiter=";", encoding="cp1250"), controller)
    assert sizes(readings) == EXPECTED
    assert "cp1250" in readings.messages[0].text


@pytest.mark.parametrize(
    ("across", "along"),
    [
        (0, 90),
        ("x", "y"),
        ("x1-x2", "y1-y2"),
        ("I", "II"),
        ("0 deg", "90 deg"),
        ("180°", "270°"),
        ("X1–X2", "Y1–Y2"),
        (1, 2),
    ],
)
def test_spellings_of_directions(controller, make_workbook, tidy, across, along):
    rows = [tidy()[0], *[(*row[:3], across if row[3] == "0°" else along, *row[4:]) for row in tidy()[1:]]]
    assert sizes(read_readings(make_workbook(rows), controller)) == EXPECTED


@pytest.mark.parametrize("name", ["12'", "12′", "12’", " 12' ", "No. 12'", "brake F damper", "12' brake F damper"])
def test_spellings_of_components(controller, make_workbook, tidy, name):
    rows = [tidy()[0], (name, "piston", "Plane 1", "0°", 1, 13.99)]
    assert sizes(read_readings(make_workbook(rows), controller)) == {("12'", "spool", "1", 0.0, 1): 13.99}


def test_a_running_number_beside_the_component(controller, make_workbook, tidy):
    rows = [("No.", *tidy()[0]), *[(index, *row) for index, row in enumerate(tidy()[1:], start=1)]]
    assert sizes(read_readings(make_workbook(rows), controller)) == EXPECTED


def test_repeats_as_columns(controller, make_workbook):
    rows = [
        ("Component", "Part", "Plane", "Direction", "Diameter 1 [mm]", "Diameter 2 [mm]"),
        (6, "spool", 1, "0°", 9.939, 9.940),
        (6, "spool", 1, "90°", 9.938, 9.939),
        (6, "sleeve", 1, "0°", 9.995, 9.996),
        (6, "sleeve", 1, "90°", 10.001, 10.002),
        (8, "sleeve", 1, "0°", 10.06, ""),
    ]
    readings = read_readings(make_workbook(rows), controller)
    assert sizes(readings) == {**EXPECTED, ("8", "sleeve", "1", 0.0, 1): 10.06}
    assert readings.layout == "columns"
    assert readings.readings[1].place.column == "F"


def test_one_heading_over_the_repeats(controller, make_workbook):
    rows = [
        ("", "", "", "", "Diameter [mm]", ""),
        ("Component", "Part", "Plane", "Direction", "1", "2"),
        (6, "spool", 1, "0°", 9.939, 9.940),
        (6, "spool", 1, "90°", 9.938, 9.939),
        (6, "sleeve", 1, "0°", 9.995, 9.996),
        (6, "sleeve", 1, "90°", 10.001, 10.002),
    ]
    assert sizes(read_readings(make_workbook(rows, merge=["E1:F1"]), controller)) == EXPECTED


def test_repeats_of_coordinates_under_merged_headings(controller, make_workbook):
    rows = [
        ("No.", "Part", "Plane", "Direction", "Repeat 1", "", "Repeat 2", ""),
        ("", "", "", "", "x1 [mm]", "x2 [mm]", "x1 [mm]", "x2 [mm]"),
        (6, "spool", 1, "0°", 59.939, 50, 50, 59.940),
        (6, "spool", 1, "90°", 59.938, 50, 50, 59.939),
        (6, "sleeve", 1, "0°", 59.995, 50, 50, 59.996),
        (6, "sleeve", 1, "90°", 60.001, 50, 50, 60.002),
    ]
    merge = ["A1:A2", "B1:B2", "C1:C2", "D1:D2", "E1:F1", "G1:H1"]
    readings = read_readings(make_workbook(rows, merge=merge), controller)
    assert sizes(readings) == EXPECTED
    assert readings.layout == "table"


def test_directions_as_columns(controller, make_workbook):
    rows = [
        ("Component", "Part", "Plane", "Repeat", "x1-x2 [mm]", "y1-y2 [mm]"),
        (6, "spool", 1, 1, 9.939, 9.938),
        (6, "spool", 1, 2, 9.940, 9.939),
        (6, "sleeve", 1, 1, 9.995, 10.001),
        (6, "sleeve", 1, 2, 9.996, 10.002),
    ]
    assert sizes(read_readings(make_workbook(rows), controller)) == EXPECTED


def test_coordinates_of_both_directions_in_one_row(controller, make_workbook):
    rows = [
        ("Component", "Part", "Plane", "Repeat", "x1", "x2", "y1", "y2 [mm]"),
        (6, "spool", 1, 1, 59.939, 50, 59.938, 50),
        (6, "spool", 1, 2, 59.940, 50, 59.939, 50),
        (6, "sleeve", 1, 1, 59.995, 50, 60.001, 50),
        (6, "sleeve", 1, 2, 59.996, 50, 60.002, 50),
    ]
    assert sizes(read_readings(make_workbook(rows), controller)) == EXPECTED


@pytest.mark.parametrize(
    "headings", [("spool_diameter_mm", "sleeve_diameter_mm"), ("d [mm]", "D [mm]"), ("Spool", "Bore")]
)
def test_parts_as_columns(controller, make_workbook, headings):
    rows = [
        ("Component", "Plane", "Direction", "Repeat", *headings),
        (6, 1, "0°", 1, 9.939, 9.995),
        (6, 1, "0°", 2, 9.940, 9.996),
        (6, 1, "90°", 1, 9.938, 10.001),
        (6, 1, "90°", 2, 9.939, 10.002),
    ]
    readings = read_readings(make_workbook(rows), controller)
    assert sizes(readings) == EXPECTED
    assert readings.layout == "columns"


def test_a_column_of_lands_instead_of_planes(controller, make_text):
    rows = [("component", "land", "part", "direction", "repeat", "diameter_mm"), ("6", 2, "spool", "0°", 1, 9.941)]
    readings = read_readings(make_text(rows), controller)
    assert sizes(readings) == {("6", "spool", "2", 0.0, 1): 9.941}


def test_lands_and_planes_together(controller, make_text):
    rows = [
        ("component", "land", "plane", "part", "diameter_mm"),
        ("8", 1, 2, "spool", 9.99),
        ("8", 1, "", "spool", 9.98),
    ]
    readings = read_readings(make_text(rows), controller)
    assert sizes(readings) == {("8", "spool", "2", None, 1): 9.99, ("8", "spool", "1", None, 1): 9.98}


def test_repeats_count_themselves_where_no_column_does(controller, make_text):
    rows = [("component", "part", "plane", "direction", "diameter_mm")]
    rows += [("6", "spool", "1", "0°", diameter) for diameter in (9.939, 9.940, 9.941)]
    assert [readings.repeat for readings in read_readings(make_text(rows), controller).readings] == [1, 2, 3]


def test_rows_without_a_diameter_are_not_measured(controller, make_workbook, tidy):
    rows = tidy(
        added=[
            ("8", "spool", "1", "0°", 1, ""),
            ("8", "spool", "1", "0°", 2, "–"),
            ("8", "sleeve", "1", "0°", 1, "n/a"),
        ]
    )
    readings = read_readings(make_workbook(rows), controller)
    assert sizes(readings) == EXPECTED
    message = readings.messages[0]
    assert (message.level, message.code) == ("info", "rows_not_measured")
    assert message.text.startswith("3 rows")


def test_headings_printed_again_on_the_next_page(controller, make_workbook, tidy):
    rows = tidy()
    assert sizes(read_readings(make_workbook([*rows[:5], (), rows[0], *rows[5:]]), controller)) == EXPECTED


def test_remarks_under_the_table(controller, make_workbook, tidy):
    rows = tidy(added=[(), ("Measured at 20 °C",), ("Reviewed",)])
    assert sizes(read_readings(make_workbook(rows), controller)) == EXPECTED


def test_a_table_that_starts_far_from_the_corner(controller, save_book, tidy):
    book = openpyxl.Workbook()
    for down, row in enumerate(tidy()):
        for across, cell in enumerate(row):
            book.active.cell(12 + down, 5 + across, cell)
    readings = read_readings(save_book(book), controller)
    assert sizes(readings) == EXPECTED
    assert (readings.readings[0].place.row, readings.readings[0].place.column) == (13, "J")


def test_the_sheet_is_found_by_what_it_holds(controller, save_book, tidy):
    book = openpyxl.Workbook()
    book.active.title = "Read me"
    book.active.append(["Measure every component twice, in the plane of the drawing; diameter in mm."])
    book.create_sheet("Nothing here")
    sheet = book.create_sheet("Werte")
    for row in tidy():
        sheet.append(row)
    empty = book.create_sheet("Second job")
    empty.append(tidy()[0])
    readings = read_readings(save_book(book), controller)
    assert (readings.sheet, sizes(readings)) == ("Werte", EXPECTED)
    message = readings.messages[0]
    assert (message.code, message.level) == ("sheet_chosen", "info")
    assert "'Second job'" in message.text


def test_a_sheet_can_be_named_and_a_hidden_one_is_left_aside(controller, save_book, tidy):
    book = openpyxl.Workbook()
    for row in tidy():
        book.active.append(row)
    hidden = book.create_sheet("old")
    for row in tidy({0: ("6", "spool", "1", "0°", 1, 9.941)}):
        hidden.append(row)
    hidden.sheet_state = "hidden"
    data = save_book(book)
    assert sizes(read_readings(data, controller)) == EXPECTED
    assert read_readings(data, controller, sheet="old").readings[0].diameter == pytest.approx(
        9.941e-3, rel=1e-9, abs=0.0
    )


def test_a_diameter_beside_its_coordinates_may_be_rounded(controller, make_workbook):
    rows = [
        ("component", "part", "plane", "x1 [mm]", "x2 [mm]", "diameter [mm]"),
        (6, "spool", 1, 59.9391, 50.0, 9.939),
    ]
    readings = read_readings(make_workbook(rows), controller)
    assert readings.readings[0].diameter == pytest.approx(9.939e-3, rel=1e-12, abs=0.0)


def test_coordinates_and_diameter_in_different_units(controller, make_workbook):
    rows = [("component", "part", "plane", "x1 [mm]", "x2 [mm]", "diameter [µm]"), (6, "spool", 1, 59.939, 50.0, 9939)]
    readings = read_readings(make_workbook(rows), controller)
    assert readings.readings[0].diameter == pytest.approx(9.939e-3, rel=1e-12, abs=0.0)


def test_a_formula_without_stored_result_does_not_matter_beside_its_coordinates(controller, save_book):
    book = openpyxl.Workbook()
    book.active.append(["component", "part", "plane", "x1 [mm]", "x2 [mm]", "diameter [mm]"])
    book.active.append([6, "spool", 1, 59.939, 50, "=ABS(D2-E2)"])
    book.active.append([6, "sleeve", 1, None, None, "=ABS(D3-E3)"])
    readings = read_readings(save_book(book), controller)
    assert len(readings.readings) == 1


@pytest.mark.parametrize("formula", ["=1/0", "=9.9+0.2", "=$G$1+F9"])
def test_a_formula_without_stored_result_is_not_taken_for_an_empty_cell(controller, save_book, formula):
    """Beside coordinate columns too: a worn sleeve written as a formula must not become its nominal diameter."""
    book = openpyxl.Workbook()
    book.active.append(["component", "part", "plane", "x1 [mm]", "x2 [mm]", "diameter [mm]"])
    book.active.append([6, "spool", 1, 59.939, 50, None])
    book.active.append([6, "sleeve", 1, None, None, formula])
    with pytest.raises(ReadingsError, match="row 3, column F: this cell's formula has no stored result") as caught:
        read_readings(save_book(book), controller)
    assert formula in str(caught.value)


def test_a_formula_with_its_result(controller):
    buffer = BytesIO()
    with xlsxwriter.Workbook(buffer, {"in_memory": True}) as book:
        sheet = book.add_worksheet()
        sheet.write_row(0, 0, ["component", "part", "plane", "diameter [mm]"])
        sheet.write_row(1, 0, [6, "spool", 1])
        sheet.write_formula(1, 3, "=9.9+0.039", None, 9.939)
    assert read_readings(buffer.getvalue(), controller).readings[0].diameter == pytest.approx(
        9.939e-3, rel=1e-9, abs=0.0
    )


ODS_CONTENT = """<?xml version="1.0" encoding="UTF-8"?>
<office:document-content xmlns:office="urn:oasis:names:tc:opendocument:xmlns:office:1.0"
 xmlns:table="urn:oasis:names:tc:opendocument:xmlns:table:1.0"
 xmlns:text="urn:oasis:names:tc:opendocument:xmlns:text:1.0"
 office:version="1.2"><office:body><office:spreadsheet><table:table table:name="Blatt">{rows}</table:table>
</office:spreadsheet></office:body></office:document-content>"""
ODS_CELL = (
    '<table:table-cell {kind} table:number-rows-spanned="{span}" '
    'table:number-columns-spanned="1"><text:p>{value}</text:p></table:table-cell>'
)


def test_merged_cells_of_an_opendocument_sheet(controller):
    def cell(value, span=1):
        number = isinstance(value, float)
        kind = f'office:value-type="float" office:value="{value}"' if number else 'office:value-type="string"'
        return ODS_CELL.format(kind=kind, value=value, span=span)

    def row(*cells):
        return f"<table:table-row>{''.join(cells)}</table:table-row>"

    covered = "<table:covered-table-cell/>"
    content = ODS_CONTENT.format(
        rows=row(*map(cell, ("component", "part", "plane", "diameter [mm]")))
        + row(cell("6", 2), cell("spool", 2), cell("1", 2), cell(9.939))
        + row(covered, covered, covered, cell(9.940))
    )
    buffer = BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        archive.writestr("mimetype", "application/vnd.oasis.opendocument.spreadsheet")
        archive.writestr("content.xml", content)
        archive.writestr(
            "META-INF/manifest.xml",
            '<manifest:manifest xmlns:manifest="urn:oasis:names:tc:opendocument:xmlns:manifest:1.0"/>',
        )
    readings = read_readings(buffer.getvalue(), controller, name="sheet.ods")
    assert list(sizes(readings).values()) == [9.939, 9.94]


def test_five_thousand_rows(controller, make_workbook):
    rows = [("component", "part", "plane", "direction", "diameter_mm")]
    for index in range(5000):
        part, diameter = (("spool", 9.939), ("sleeve", 9.995))[index % 2]
        rows.append((6, part, 1 + index // 2 % 2, ("0°", "90°")[index // 4 % 2], diameter + 1e-6 * (index % 7)))
    data = make_workbook(rows)
    readings = read_readings(data, controller)
    assert len(readings.readings) == 5000
    assert sum(land.measured for land in clearances(readings, controller)) == 2


def test_reading_a_sheet_needs_no_pandas():
    script = (
        "import sys, atleak.readers.sheets.measuring_sheet\n"
        "print([name for name in ('pandas', 'openpyxl', 'xlsxwriter') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
