"""What is refused, and how the refusal names the place, the value and what was expected."""

from __future__ import annotations

import datetime
import io
import zipfile

import openpyxl
import pytest
import xlsxwriter

from atleak.common.errors import InputError, ReadingsError
from atleak.measurements.clearances import clearances
from atleak.readers.sheets.measuring_sheet import read_readings

PLACED = ("component", "part", "plane", "x1 [mm]", "x2 [mm]")
OF_ONE = ("component", "part", "plane", "diameter_mm")


@pytest.fixture(scope="module")
def controller(three_pairs):
    return three_pairs


def where(error):
    return error.place.file, error.place.sheet, error.place.row, error.place.column


@pytest.fixture
def refused_row(refused, make_workbook, tidy):
    """Refuse component 6 land 1 with one row changed, and return the only problem."""

    def read(index, *row):
        error = refused(make_workbook(tidy({index: row})))
        assert len(error.problems) == 1, error
        return error.problems[0]

    return read


# --- one cell -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("value", "said", "shown"),
    [
        ("abc", "not a number", "abc"),
        ("9.9.39", "not a number", "9.9.39"),
        ("9,939 kg", "not a number", "9,939 kg"),
        ("inf", "not a number", "inf"),
        (True, "not a number", True),
        (datetime.date(2026, 3, 12), "into a date", "2026-03-12"),
        (datetime.time(9, 9, 39), "into a date or time", "09:09:39"),
        (-9.939, "must be positive", -9.939),
        (0, "must be positive", 0.0),
    ],
)
def test_a_cell_that_is_no_diameter(refused_row, value, said, shown):
    error = refused_row(2, "6", "spool", "1", "90°", 1, value)
    assert said in error.problem
    assert where(error) == ("sheet.xlsx", "Readings", 4, "F")
    assert error.value == shown
    assert "9.939" in error.expected


@pytest.mark.parametrize(
    ("index", "row", "at", "said"),
    [
        (4, ("12", "sleeve", "1", "0°", 1, 9.995), (6, "A"), ("unknown component", "12", "6, 8, 12'", "12'")),
        (0, (1, "spool", "1", "0°", 1, 9.939), (2, "A"), ("component 1 (pump) of three_pairs has no precision pair",)),
        (5, ("6", "sleve", "1", "0°", 2, 9.996), (7, "B"), ("unknown part", "sleve", "", "sleeve")),
        (3, ("6", "spool", "3", "90°", 2, 9.939), (5, "C"), ("component 6", "3", "plane 1, 2")),
        (0, ("6", "spool", "1", "up", 1, 9.939), (2, "D"), ("direction", "up")),
        (0, ("6", "spool", "1", "0°", "again", 9.939), (2, "E"), ("repeat", "again")),
        (1, ("6", "spool", "1", "0°", 1, 9.940), (3, "F"), ("stands in row 2 already", 9.940)),
        (1, ("6", "spool", "1", "0°", 2, 10.939), (3, "F"), ("rows 2 and 3", "10.939 mm")),
    ],
)
def test_a_cell_that_is_not_understood(refused_row, index, row, at, said):
    """``said`` is part of the problem, the value that was found, part of what was expected, and the nearest name."""
    error = refused_row(index, *row)
    problem, value, expected, nearest = (*said, None, None, None)[:4]
    assert where(error) == ("sheet.xlsx", "Readings", *at)
    assert problem in error.problem
    assert value is None or error.value == value
    assert (expected or "") in str(error.expected)
    assert error.nearest == nearest


@pytest.mark.parametrize(
    ("rows", "at", "said"),
    [
        ([("component", "land", "part", "diameter_mm"), ("6", 7, "spool", 9.94)], (2, "B"), "no such land"),
        ([("component", "land", "plane", "part", "diameter_mm"), ("6", 1, 2, "spool", 9.94)], (2, "C"), "on land 1"),
        ([PLACED[:4], (6, "spool", 1, 50)], (1, "D"), "one coordinate alone"),
        ([PLACED, (6, "spool", 1, 59.939, 50), (6, "spool", 1, 59.94, None)], (3, "E"), "coordinate 2 is missing"),
        (
            [(*PLACED[:3], "x2 [mm]", "diameter [mm]"), (6, "spool", 1, 59.94, None)],
            (2, "D"),
            "coordinate 1 is missing",
        ),
        ([PLACED, (6, "spool", 1, 50, 50)], (2, "D"), "equal"),
        ([(*PLACED, "diameter [mm]"), (6, "spool", 1, 59.939, 50, 9.949)], (2, "F"), "coordinates (9.939)"),
        ([(*PLACED[:3], "diameter [mm]"), (6, "spool", 1, "=D1+0.002")], (2, "D"), "no stored result"),
        ([("Component", "Plane", "Diameter [mm]"), (6, 1, 9.94)], (1, None), "the part (spool or sleeve)"),
        ([("Component", "Part", "Diameter [mm]"), (6, "spool", 9.94)], (1, None), "the measurement plane"),
        (
            [("Component", "Part", "Plane", "Diameter [mm]", "Diameter (mm)"), (6, "spool", 1, 9.94, 9.941)],
            (1, "E"),
            "two columns are read as the same diameter",
        ),
        (
            [("No.", "Component", "Part", "Plane", "Diameter [mm]"), (6, "brake C1 valve", "spool", 1, 9.94)],
            (2, "B"),
            "this is component 8, in a row of component 6",
        ),
        ([("component", "part", "plane", "diameter"), (6, "spool", 1, 70.0)], (1, "D"), "names no unit"),
        ([OF_ONE, ("12'", "piston", "1", 14.0), ("12'", "bore", "1", 13.0)], (3, "D"), "smaller than the piston"),
        ([OF_ONE, ("12'", "piston", "1", 14.0), ("12'", "bore", "1", 15.01)], (3, "D"), "clearance 0.505 mm"),
        ([OF_ONE, ("6", "spool", "1", 10.0)], (2, "D"), "the sleeve was not measured"),
        ([OF_ONE, ("6", "bore", "1", 9.9)], (2, "D"), "the spool was not measured"),
    ],
)
def test_a_sheet_with_one_fault(refused, make_workbook, rows, at, said):
    error = refused(make_workbook(rows))
    assert len(error.problems) == 1
    assert where(error) == ("sheet.xlsx", "Readings", *at)
    assert said in error.problem
    assert "swapped" not in error.problem


def test_an_unknown_unit_in_a_row(refused, make_workbook, tidy):
    rows = [(*row, "unit" if index == 0 else "mm") for index, row in enumerate(tidy())]
    rows[4] = (*rows[4][:-1], "furlong")
    error = refused(make_workbook(rows))
    assert where(error) == ("sheet.xlsx", "Readings", 5, "G")
    assert error.value == "furlong"


@pytest.mark.parametrize(("column", "letter"), [(0, "A"), (1, "B"), (2, "C"), (3, "D"), (4, "E")])
def test_an_empty_cell_in_a_row_that_holds_a_reading(refused, make_workbook, tidy, column, letter):
    rows = [list(row) for row in tidy()]
    rows[3][column] = None
    error = refused(make_workbook(rows))
    assert len(error.problems) == 1
    assert where(error) == ("sheet.xlsx", "Readings", 4, letter)
    assert "is empty" in error.problem
    assert "merged" in error.expected


def test_empty_cells_below_a_component_are_not_filled_in(refused, make_text):
    """The printed form of Table 1 saved as text has lost its merged cells: nothing is invented for them."""
    rows = [
        ("component_no", "component", "measurement_plane", "measurement_direction", "diameter_mm"),
        ("6", "spool", "1", "0°", 9.939),
        ("", "", "", "", 9.939),
        ("", "", "", "90°", 9.939),
    ]
    error = refused(make_text(rows), name="table.csv")
    assert [(problem.place.row, problem.place.column) for problem in error.problems] == [
        (3, "component_no"),
        (3, "component"),
        (3, "measurement_direction"),
    ]
    assert "and in 1 more: 4" in error.problems[0].problem


def test_a_name_that_contradicts_the_number(refused, make_workbook):
    rows = [("No.", "Component", "Part", "Plane", "Diameter [mm]"), (6, "brake C1 valve", "spool", 1, 9.94)]
    rows += [(6, "clutch B valve", "spool", 2, 9.94), (8, "brake C1 valve", "spool", 2, 9.99)]
    error = refused(make_workbook(rows))
    assert len(error.problems) == 1
    assert error.place.row == 2
    assert "component 8" in error.problem or "component 6" in error.problem


@pytest.mark.parametrize("fault", ["#DIV/0!", "#REF!"])
def test_a_formula_that_gives_an_error(refused, fault):
    buffer = io.BytesIO()
    with xlsxwriter.Workbook(buffer, {"in_memory": True}) as book:
        sheet = book.add_worksheet("Readings")
        sheet.write_row(0, 0, ["component", "part", "plane", "diameter [mm]"])
        sheet.write_row(1, 0, [6, "spool", 1, 9.939])
        sheet.write_row(2, 0, [6, "spool", 2])
        sheet.write_formula(2, 3, "=1/0", None, fault)
    error = refused(buffer.getvalue())
    assert where(error) == ("sheet.xlsx", "Readings", 3, "D")
    assert error.value == fault


def test_decimal_commas_between_commas(refused, make_text, tidy):
    rows = [[str(cell).replace(".", ",") for cell in row] for row in tidy()]
    error = refused(make_text(rows), name="a.csv")
    assert error.place.row == 2
    assert "decimal comma" in error.problem


# --- against the nominal diameters --------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("factor", "times", "fits"),
    [
        (1000.0, "1000 times", "µm"),
        (10.0, "10 times", None),
        (1 / 25.4, "1/25.4 of", "inch"),
        (25.4, "25.4 times", None),
        (0.1, "1/10 of", "cm"),
        (0.001, "1/1000 of", "m"),
    ],
)
def test_a_whole_sheet_in_the_wrong_unit_names_the_factor(refused, make_workbook, tidy, factor, times, fits):
    rows = [tidy()[0], *[(*row[:-1], row[-1] * factor) for row in tidy()[1:]]]
    error = refused(make_workbook(rows))
    assert len(error.problems) == 1
    assert where(error) == ("sheet.xlsx", "Readings", 2, "F")
    assert "8 of 8 diameters" in error.problem
    assert f"{times} the nominal" in error.problem
    assert ("wrong unit (" in error.problem) == (fits is not None)
    if fits is not None:
        assert f"({fits}?)" in error.problem
    assert "9.939 mm" in error.expected


@pytest.mark.parametrize(
    ("factor", "said"),
    [(10.0, "10 times"), (0.1, "1/10 of"), (1000.0, "1000 times"), (25.4, "inch"), (1 / 25.4, "inch"), (3.0, "3 times"),
     (0.5, "a radius?")],
)  # fmt: skip
def test_one_diameter_off_by_a_factor(refused_row, factor, said):
    error = refused_row(3, "6", "spool", "1", "90°", 2, 9.939 * factor)
    assert where(error) == ("sheet.xlsx", "Readings", 5, "F")
    assert said in error.problem
    assert error.expected.startswith("about 9.939 mm (component 6 land 1)")


def test_an_unknown_unit_that_is_told(controller, make_workbook, tidy):
    with pytest.raises(InputError, match="unknown unit") as caught:
        read_readings(make_workbook(tidy()), controller, unit="bar")
    assert caught.value.value == "bar"


# --- spool against sleeve -----------------------------------------------------------------------------------------


def test_spool_and_sleeve_swapped(refused, make_workbook, tidy):
    other = {"spool": "sleeve", "sleeve": "spool"}
    rows = [tidy()[0], *[(row[0], other[row[1]], *row[2:]) for row in tidy()[1:]]]
    error = refused(make_workbook(rows))
    assert len(error.problems) == 1
    assert "component 6 land 1" in error.problem
    assert "swapped?" in error.problem
    assert "29.8 µm" in error.problem  # the other way round
    assert where(error) == ("sheet.xlsx", "Readings", 2, "F")
    assert error.value == "9.939 mm"


def test_spool_and_sleeve_swapped_in_the_whole_sheet(refused, make_text):
    rows = [("component", "part", "plane", "diameter_mm")]
    for component, plane, small, large in (("6", 1, 9.939, 9.99), ("6", 2, 9.942, 9.99), ("12'", 1, 14.0, 14.07)):
        rows += [(component, "sleeve", plane, small), (component, "spool", plane, large)]
    error = refused(make_text(rows), name="a.csv")
    assert "in 3 of 3 lands" in error.problem
    assert "whole sheet" in error.problem
    assert where(error) == ("a.csv", None, 2, None)
    assert [problem.place.row for problem in error.problems] == [2, 2, 4, 6]


def test_swapped_in_one_direction_only(refused, make_workbook, tidy):
    changed = {
        2: ("6", "sleeve", "1", "90°", 1, 9.938),
        3: ("6", "sleeve", "1", "90°", 2, 9.939),
        6: ("6", "spool", "1", "90°", 1, 10.001),
        7: ("6", "spool", "1", "90°", 2, 10.002),
    }
    error = refused(make_workbook(tidy(changed)))
    assert "component 6 land 1, plane 1, 90°" in error.problem
    assert "row 9" in error.problem
    assert "swapped there?" in error.problem
    assert where(error) == ("sheet.xlsx", "Readings", 4, "F")


def test_two_rows_swapped(refused, make_workbook, tidy):
    changed = {1: ("6", "spool", "1", "0°", 2, 9.996), 5: ("6", "sleeve", "1", "0°", 2, 9.940)}
    error = refused(make_workbook(tidy(changed)))
    assert len(error.problems) == 1
    assert "row 3 (9.996 mm)" in error.problem
    assert where(error) == ("sheet.xlsx", "Readings", 7, "F")


def test_a_clearance_of_half_a_millimetre_is_still_a_clearance(controller, make_text):
    rows = [("component", "part", "plane", "diameter_mm"), ("12'", "piston", "1", 14.0), ("12'", "bore", "1", 14.99)]
    gap = clearances(read_readings(make_text(rows), controller), controller)[3]
    assert gap.radial_clearance == pytest.approx(0.495e-3, rel=1e-9, abs=0.0)


def test_repeats_that_disagree_a_little_are_flagged_with_place_and_values(controller, make_workbook, tidy):
    data = make_workbook(tidy({1: ("6", "spool", "1", "0°", 2, 9.949)}))
    gap = clearances(read_readings(data, controller, name="sheet.xlsx"), controller)[0]
    message = next(message for message in gap.messages if message.code == "repeats_disagree")
    assert "9.939, 9.949 mm" in message.text
    assert (message.place.sheet, message.place.row, message.place.column) == ("Readings", 3, "F")


# --- several problems at once -------------------------------------------------------------------------------------


def test_all_problems_are_told_at_once_in_the_order_of_the_sheet(refused, make_workbook, tidy):
    changed = {
        0: ("9", "spool", "1", "0°", 1, 9.939),
        2: ("6", "spool", "1", "90°", 1, "x"),
        4: ("6", "sleeve", "4", "0°", 1, 9.995),
        5: ("6", "sleeve", "1", "0°", 2, 99.96),
    }
    error = refused(make_workbook(tidy(changed)))
    assert [(problem.place.row, problem.place.column) for problem in error.problems] == [
        (2, "A"),
        (4, "F"),
        (6, "C"),
        (7, "F"),
    ]
    for problem in error.problems:
        assert str(problem) in str(error)
    assert (error.place, error.value) == (error.problems[0].place, error.problems[0].value)


def test_the_text_of_many_problems_is_cut_but_none_is_lost(refused, make_workbook, tidy):
    rows = [tidy()[0], *[(f"77{number}", *row[1:]) for number, row in enumerate([*tidy()[1:], *tidy()[1:]])]]
    error = refused(make_workbook(rows))
    assert len(error.problems) == 16
    assert "… and 6 more" in str(error)
    assert len(str(error).splitlines()) == 11


# --- the file as a whole ------------------------------------------------------------------------------------------


@pytest.fixture
def unusable(controller):
    def read(data, **options):
        with pytest.raises(ReadingsError) as caught:
            read_readings(data, controller, **{"name": "sheet.xlsx", **options})
        assert caught.value.place.file
        assert caught.value.expected
        return caught.value

    return read


@pytest.mark.parametrize("data", [b"", b"\n\n  \r\n", b"\xef\xbb\xbf"])
def test_an_empty_file(unusable, data):
    assert unusable(data).problem == "the file is empty"


def test_an_empty_workbook(unusable, make_workbook):
    error = unusable(make_workbook([]))
    assert error.problem == "the workbook is empty"
    assert error.place.file == "sheet.xlsx"


def test_no_such_file(unusable, tmp_path):
    assert unusable(tmp_path / "nothing.xlsx").problem == "no such file"
    assert "cannot be read" in unusable(tmp_path).problem


@pytest.mark.parametrize(
    ("start", "kind"),
    [
        (b"\x89PNG\r\n\x1a\n", "PNG picture"),
        (b"\xff\xd8\xff\xe0", "JPEG picture"),
        (b"%PDF-1.7", "PDF document"),
        (b"MDF     4.10", "MDF measurement file"),
        (b"PAR1", "Parquet file"),
        (b"<html><body><table>", "web page"),
        (b"<?xml version='1.0'?><Workbook>", "web page or XML"),
        (b"\x01\x02\x00\x07" * 9, "neither a workbook nor text"),
    ],
)
def test_a_file_of_another_kind(unusable, start, kind):
    assert kind in unusable(start + b" rest of it").problem


def test_a_damaged_workbook(unusable, make_workbook, tidy):
    data = make_workbook(tidy())
    start = data.index(b"xl/worksheets/sheet1.xml") + 40
    for broken in (
        data[: len(data) // 2],
        data[:start] + b"\0" * 200 + data[start + 200 :],
        b"PK\x03\x04 nothing else",
    ):
        assert "damaged" in unusable(broken).problem


def test_another_archive(unusable):
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        archive.writestr("word/document.xml", "<w/>")
    assert "archive, not a workbook" in unusable(buffer.getvalue()).problem


def test_a_workbook_protected_by_a_password(unusable):
    ole = b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1" + b"\0" * 600 + "EncryptedPackage".encode("utf-16-le") + b"\0" * 600
    assert "password" in unusable(ole).problem


def test_an_old_workbook_that_is_broken(unusable):
    assert "damaged" in unusable(b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1" + b"\0" * 600).problem


def test_a_stray_cell_in_the_last_corner(unusable, save_book, tidy):
    book = openpyxl.Workbook()
    for row in tidy():
        book.active.append(row)
    book.active["XFD1048576"] = "x"
    error = unusable(save_book(book))
    assert "far outside its table" in error.problem
    assert "delete what lies outside" in error.expected


def test_no_headings_at_all(unusable, make_workbook):
    error = unusable(make_workbook([("Hello", "world"), (1, 2)]))
    assert "no row of headings" in error.problem
    assert error.place.sheet == "Readings"
    for word in ("component", "part", "plane", "diameter"):
        assert word in error.expected


def test_headings_without_a_diameter(unusable, make_workbook):
    error = unusable(make_workbook([("Component", "Part", "Plane", "Direction"), (6, "spool", 1, "0°")]))
    assert "no heading for diameter" in error.problem
    assert error.place.row == 1
    assert "'Component', 'Part'" in error.value


def test_a_road_test_log_instead(unusable, make_text):
    rows = [("time [s]", "engine_speed [rpm]", "p_g [kPa]", "atf_temperature [°C]"), (0.0, 750, 500, 80)]
    assert "no row of headings" in unusable(make_text(rows), name="log.csv").problem


def test_a_template_not_filled_in(unusable, make_workbook, tidy):
    rows = [tidy()[0], *[(*row[:-1], None) for row in tidy()[1:]]]
    error = unusable(make_workbook(rows))
    assert "no readings are filled in" in error.problem
    assert (error.place.sheet, error.place.row) == ("Readings", 1)


def test_two_sheets_with_readings(unusable, save_book, tidy):
    book = openpyxl.Workbook()
    book.active.title = "before"
    other = book.create_sheet("after")
    for row in tidy():
        book.active.append(row)
        other.append(row)
    error = unusable(save_book(book))
    assert error.value == "'before', 'after'"
    assert "say which sheet" in error.expected


def test_a_sheet_that_is_not_there_or_holds_no_readings(unusable, save_book, tidy):
    book = openpyxl.Workbook()
    book.active.title = "notes"
    book.active.append(["hello"])
    for row in tidy():
        (book["Job 7"] if "Job 7" in book.sheetnames else book.create_sheet("Job 7")).append(row)
    error = unusable(save_book(book), sheet="Job 8")
    assert (error.value, error.nearest) == ("Job 8", "Job 7")
    error = unusable(save_book(book), sheet="notes")
    assert "readings are in sheet 'Job 7'" in error.problem
    assert error.place.sheet == "notes"
