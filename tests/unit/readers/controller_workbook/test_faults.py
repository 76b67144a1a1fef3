"""What is wrong with a workbook is listed at once, each fault with its sheet, row and column."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import pytest

from atleak.catalogue.workbook.cells import Units
from atleak.catalogue.workbook.sheets import SHEETS
from atleak.common.errors import CatalogueError
from atleak.common.wording import wording
from atleak.readers.controller_workbook import read_controller_workbook
from atleak.report.sheets.controller_workbook import write_controller_workbook

Book = Any

# sheet, row below the headings, column or field, what is written there, part of the message
ONE_PER_SHEET = (
    ("Head", 0, "Date", "last summer", "a day such as 2026-01-31"),
    ("Materials", 1, "Expansion", "twenty", "a number in 10⁻⁶/K"),
    ("Components", 3, "Part", "slide", "one of spool, piston, end plug"),
    ("Lands", 4, "Diameter", 9855.0, "was it in µm?"),
    ("Pump", 0, "Volumetric efficiency", 92.0, "less than or equal to 1"),
    ("Operating points", 2, "Gear", 9.0, "expected one of R (-1), N (0), 1, 2, 3, 4, 5"),
    ("Circuits", 3, "Name", "", "this cell must be filled in"),
    ("Feeds", 2, "Fed from", "solenoid_fed", "no such section or circuit"),
    ("Set pressures", 2, "At", "full", "a number in mA or %"),
    ("Apply chart", 1, "3", "maybe", "x where the circuit is applied"),
    ("Gaps", 5, "To", "drian", "no such section or circuit"),
    ("Line pressures", 1, "Highest", -10.0, "greater than 0"),
    ("Leaks", 1, "Law", "linear", "one of laminar, orifice"),
    ("Consumers", 1, "After the line", "mostly", "yes or no"),
    ("Consumer flows", 2, "Operating point", "hot_idel", "no such operating point"),
    ("Complaints", 1, "Operating points", "reverse_idel", "no such operating point"),
)
ENGLISH = {"accepted", "cell", "expected", "found", "greater", "less", "must", "not", "row", "such", "than", "was"}


def test_one_mistake_on_every_sheet_gives_one_list(five_speed_book: Book) -> None:
    made_up = {"Source": "made up for this test"}
    five_speed_book.add("Section pressures", {"Section": "p_m", "Relation": "line", **made_up})
    repair = {"Id": "kit", "Component": "boost_valv", "Kind": "new valve", "Name": "boost valve"}
    five_speed_book.add("Repairs", {**repair, **made_up})
    for sheet, row, heading, value, _ in ONE_PER_SHEET:
        five_speed_book.put(sheet, row, heading, value)
    faults = five_speed_book.faults()
    by_sheet = {sheet: [str(fault) for fault in faults if fault.place.sheet == sheet] for sheet in _names()}
    for sheet, row, heading, value, message in ONE_PER_SHEET:
        first = by_sheet[sheet][0]
        assert message in first, sheet
        assert heading in first
        if sheet not in {"Head", "Pump"}:
            assert f"row {row + 1}," in first
        if value != "":
            assert repr(value) in first
    assert "column C (Component): no such component with lands" in by_sheet["Repairs"][0]
    assert by_sheet["Repairs"][0].endswith("did you mean 'boost_valve'?")
    assert "a line with its ratio" in by_sheet["Section pressures"][0]
    assert {sheet: len(listed) for sheet, listed in by_sheet.items()} == dict.fromkeys(_names(), 1)
    # the one message shows them all, in the order of the sheets
    lines = str(faults[0]).splitlines()
    assert len(lines) == len(SHEETS)
    assert [next(name for name in _names() if f"sheet {name!r}" in line) for line in lines] == _names()
    for language in ("de", "pl"):
        said = wording(language).sentence(faults[0].sentence)
        assert len(said.splitlines()) == len(SHEETS)
        assert not ENGLISH & set(re.findall(r"\w+", said)), said


def _names() -> list[str]:
    return [sheet.name for sheet in SHEETS]


@pytest.mark.parametrize(
    ("heading", "value", "message"),
    [
        ("Diameter", "thick", "not accepted (found 'thick'); expected a number in inch"),
        ("Diameter", "", "this cell must be filled in; expected a number in inch"),
        ("Diameter", 0.0, "expected greater than 0.5"),
        ("Diameter", 14.5, "(it is 368.3 mm) (found 14.5); expected less than 200; was it in mm?"),
        ("Land", 1.5, "a whole number"),
        ("Component", "solenoid_modulators", "no such id here"),
        ("Component", "", "this row does not say to what it belongs"),
        ("Mounting clearance", 14.0, "(it is 177800 µm, radial) (found 14.0)"),
        ("Diameter", "=1/0", "a formula without a result"),
        ("Spool", "brass", "unknown material"),
    ],
)
def test_a_wrong_cell_is_named(inch_book: Book, heading: str, value: object, message: str) -> None:
    inch_book.put("Lands", 4, heading, value)
    faults = inch_book.faults()
    column = inch_book.sheets["Lands"][0].index(heading)
    assert message in str(faults[0])
    assert (faults[0].place.sheet, faults[0].place.row) == ("Lands", 5)
    assert faults[0].place.column == f"{chr(ord('A') + column)} ({heading})"
    assert faults[0].place.file == "unit.xlsx"
    # what rests on the row is not called wrong as well, but for a land that is then missing
    assert len(faults) == 1 or (heading, value) in {("Land", 1.5), ("Component", "")}


@pytest.mark.parametrize(
    ("sheet", "row", "heading"),
    [
        ("Head", 0, "Contact length unless stated"),
        ("Head", 0, "Material of the body"),
        ("Consumer flows", 3, "Operating point"),
        ("Consumer flows", 3, "Flow"),
        ("Set pressures", 2, "Set by"),
        ("Set pressures", 2, "Pressure"),
        ("Pump", 0, "Displacement of one revolution"),
        ("Leaks", 4, "At viscosity"),
    ],
)
def test_what_follows_from_a_fault_is_none_of_its_own(
    five_speed_book: Book, sheet: str, row: int, heading: str
) -> None:
    five_speed_book.put(sheet, row, heading, "?x")
    (fault,) = five_speed_book.faults()
    assert fault.place.sheet == sheet
    assert f"({heading})" in fault.place.column


def test_columns_that_are_missing_unknown_or_without_heading_are_named(minimal_book: Book) -> None:
    lands = minimal_book.sheets["Lands"]
    lands[0][lands[0].index("Diameter")] = "Diametre"
    lands[1] += ["", 5.0]
    faults = [str(fault) for fault in minimal_book.faults()]
    assert len(faults) == 3
    assert "did you mean 'Diameter'?" in faults[0] or "did you mean 'Diameter'?" in faults[1]
    assert any("the column 'Diameter' is missing" in fault for fault in faults)
    assert any("column U holds something and has no heading" in fault for fault in faults)


@pytest.mark.parametrize("heading", [1e300, True, "1-3", "D"])
def test_a_heading_of_the_apply_chart_that_is_no_gear_is_named(five_speed_book: Book, heading: object) -> None:
    five_speed_book.sheets["Apply chart"][0][4] = heading
    places = [(fault.problem, fault.place.sheet, fault.place.row) for fault in five_speed_book.faults()]
    assert ("unknown column", "Apply chart", 1) in places


def test_a_missing_sheet_is_named_and_nothing_that_follows_from_it(minimal_book: Book) -> None:
    del minimal_book.sheets["Pump"]
    minimal_book.sheets["Operating points"] = [["nothing", "of", "use"]]
    faults = minimal_book.faults()
    assert [(fault.place.sheet, fault.problem) for fault in faults] == [
        ("Pump", "this sheet is missing, or its headings are"),
        ("Operating points", "this sheet is missing, or its headings are"),
    ]


def test_a_sheet_that_needs_a_row_says_so(minimal_book: Book) -> None:
    del minimal_book.sheets["Materials"][1:]
    faults = minimal_book.faults()
    assert faults[0].place.sheet == "Materials"
    assert "required key is missing" in str(faults[0])


def test_units_that_are_not_chosen_are_asked_for(minimal_book: Book) -> None:
    minimal_book.put("Head", 0, "Lengths are in", "")
    minimal_book.put("Head", 0, "Clearances are", "round")
    faults = [str(fault) for fault in minimal_book.faults()]
    assert len(faults) == 2
    assert "Clearances are): not accepted (found 'round'); expected one of radial, diametral" in faults[1]
    assert "Lengths are in): not chosen; expected one of mm, inch" in faults[0]


def test_a_unit_under_a_heading_that_is_not_the_workbook_s_is_a_fault(minimal_book: Book) -> None:
    lands = minimal_book.sheets["Lands"]
    lands.insert(1, ["unit", *("inch" if heading == "Diameter" else "" for heading in lands[0][1:])])
    (fault,) = minimal_book.faults()
    assert "another unit than that of the workbook (found 'inch'); expected mm, as the sheet Head says" in str(fault)


@pytest.mark.parametrize("units", [Units(), Units("inch", "diametral", "psi")], ids=["mm", "inch"])
def test_an_untouched_template_describes_nothing(units: Units) -> None:
    with pytest.raises(CatalogueError, match="nothing is filled in yet"):
        read_controller_workbook(write_controller_workbook(units=units), name="unit.xlsx")


def test_an_example_that_was_changed_is_not_left_out_silently(minimal_book: Book) -> None:
    minimal_book.put("Lands", 3, "Note", "e.g.")
    faults = [str(fault) for fault in minimal_book.faults()]
    assert "row 4: a row marked as an example was changed" in faults[0]


def test_set_pressures_that_do_not_go_together_are_named(five_speed_book: Book) -> None:
    for values in (
        {"Circuit": "solenoid_feed", "Set by": "gear", "Which": "1", "Pressure": 100.0},
        {"Circuit": "direct_clutch", "Set by": "gear", "Which": "top", "Pressure": 100.0},
        {"Circuit": "forward_clutch", "Set by": "another circuit", "Which": "epc"},
        {"Circuit": "reverse_servo", "Pressure": 100.0},
        {"Circuit": "overdrive_band", "Set by": "operating point", "Which": "hot_idle", "Pressure": 100.0},
    ):
        five_speed_book.add("Set pressures", values)
    faults = {fault.place.row: str(fault) for fault in five_speed_book.faults()}
    first = len(five_speed_book.sheets["Set pressures"]) - 4
    assert "does not go with the rows before it" in faults[first]
    assert "not a gear (found 'top')" in faults[first + 1]
    assert "G (Ratio): missing where it is set by another circuit" in faults[first + 2]
    assert "what is it set by?" in faults[first + 3]
    assert "not all operating points are stated" in faults[first + 4]


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"id = 'unit'\n", "this is no workbook"),
        (b"", "this is no workbook"),
        (b"PK\x03\x04 and then nothing of use", "unit.xlsx"),
    ],
)
def test_what_is_no_workbook_is_refused(content: bytes, message: str) -> None:
    with pytest.raises(CatalogueError, match=message):
        read_controller_workbook(content, name="unit.xlsx")


def test_another_workbook_is_refused(bare_workbook: Callable[..., bytes], stray_workbook: bytes) -> None:
    other = bare_workbook("<sheetData><row r='1'><c r='A1'><v>1</v></c></row></sheetData>")
    with pytest.raises(CatalogueError, match="describes no valve body"):
        read_controller_workbook(other, name="unit.xlsx")
    with pytest.raises(CatalogueError, match="delete what lies outside the table"):
        read_controller_workbook(stray_workbook, name="unit.xlsx")


@pytest.mark.parametrize(
    ("heading", "value", "question"),
    [
        ("Diameter", 7.2, "7.2 inch is unusual (it is 182.88 mm): was it in mm?"),
        ("Contact length", 5.0, "5 inch is unusual (it is 127 mm): was it in mm?"),
        ("Mounting clearance", 0.02, "0.02 inch, diametral is unusual (it is 254 µm, radial): was it in mm?"),
    ],
)
def test_a_number_that_another_unit_would_make_usual_is_taken_and_asked_about(
    inch_book: Book, heading: str, value: float, question: str
) -> None:
    inch_book.put("Lands", 4, heading, value)
    column = chr(ord("A") + inch_book.sheets["Lands"][0].index(heading))
    assert inch_book.read().notes == (f"unit.xlsx, sheet 'Lands', row 5, column {column} ({heading}): {question}",)


def test_a_number_with_its_own_unit_is_not_asked_about(inch_book: Book) -> None:
    inch_book.put("Lands", 4, "Contact length", "60 mm")
    assert inch_book.read().notes == ()


def test_a_field_of_the_head_that_means_nothing_is_named_once_with_all_that_it_could_be(minimal_book: Book) -> None:
    minimal_book.sheets["Head"].append(["Pressures are inn", "psi"])
    (fault,) = minimal_book.faults()
    assert (fault.problem, fault.place.sheet, fault.nearest) == ("unknown field", "Head", "Pressures are in")
    assert "Date" in fault.expected
