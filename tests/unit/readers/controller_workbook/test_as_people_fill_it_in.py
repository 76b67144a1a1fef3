"""A workbook as people fill it in: commas, merged cells, renamed sheets, remarks, formulas."""

from __future__ import annotations

import datetime
from typing import Any

import pytest

from atleak.catalogue.controller_file import written_toml

Book = Any


def test_text_commas_dates_and_units_of_their_own_are_read(minimal_book: Book) -> None:
    plain = written_toml(minimal_book.read().data)
    minimal_book.put("Head", 0, "Date", datetime.date(2026, 11, 21))
    minimal_book.put("Head", 0, "Gears", "1-6")
    minimal_book.put("Lands", 1, "Diameter", "15,0")
    minimal_book.put("Lands", 2, "Diameter", "12.5 mm")
    minimal_book.put("Lands", 3, "Diameter", "0.43307086614173228346 in")
    minimal_book.put("Lands", 1, "Mounting clearance", "0,018 mm")
    minimal_book.put("Lands", 5, "Contact length", " 9 ")
    minimal_book.put("Operating points", 1, "Gear", "2")
    minimal_book.put("Operating points", 1, "Main pressure", "8 bar")
    minimal_book.put("Pump", 0, "Volumetric efficiency", "0,92")
    assert written_toml(minimal_book.read().data) == plain
    minimal_book.put("Head", 0, "Date", "21.11.2026")
    assert written_toml(minimal_book.read().data) == plain


def test_gears_are_read_as_people_name_them(five_speed_book: Book) -> None:
    plain = five_speed_book.read().data
    five_speed_book.put("Head", 0, "Gears", "R, P N 1-5")
    five_speed_book.put("Gaps", 1, "Gears", "all")
    five_speed_book.put("Gaps", 2, "Gears", "R N 1 – 5")
    assert five_speed_book.read().data == plain


def test_rows_may_be_empty_and_columns_in_another_order(minimal_book: Book) -> None:
    plain = minimal_book.read().data
    lands = minimal_book.sheets["Lands"]
    lands.insert(3, [""] * len(lands[0]))
    for row in minimal_book.sheets["Operating points"]:
        row.reverse()
    minimal_book.sheets["Lands"] = [["Anything about this sheet"], [], *lands]
    assert minimal_book.read().data == plain


def test_a_merged_cell_holds_for_all_its_rows(minimal_book: Book) -> None:
    plain = minimal_book.read().data
    minimal_book.put("Lands", 2, "Component", "")
    minimal_book.merged.append(("Lands", 1, 2, "Component"))
    assert minimal_book.read().data == plain


def test_a_renamed_sheet_is_known_by_its_headings_and_a_foreign_one_is_left_out(minimal_book: Book) -> None:
    plain = minimal_book.read().data
    minimal_book.sheets["Kolben und Bohrungen"] = minimal_book.sheets.pop("Lands")
    minimal_book.sheets["my sums"] = [["a", 1.0], ["b", 2.0]]
    minimal_book.sheets["HEAD "] = minimal_book.sheets.pop("Head")
    described = minimal_book.read()
    assert described.data == plain
    assert described.notes == (
        "sheet 'Kolben und Bohrungen' is read as 'Lands', by its headings",
        "sheet 'my sums' is not read",
    )


def test_remarks_are_left_out_and_that_is_said(minimal_book: Book) -> None:
    plain = minimal_book.read().data
    minimal_book.put("Lands", 2, "Note", "bore looks scratched")
    minimal_book.put("Lands", 3, "Note", "new spool")
    minimal_book.sheets["Head"][5] += [*[""] * (3 - len(minimal_book.sheets["Head"][5])), "ask the owner"]
    described = minimal_book.read()
    assert described.data == plain
    assert described.notes == (
        "sheet 'Head', row 6: what stands under Note is not carried over",
        "sheet 'Lands', rows 3–4: what stands under Note is not carried over",
    )


def test_sheets_that_hold_nothing_may_be_deleted(minimal_book: Book) -> None:
    plain = minimal_book.read().data
    for name in ("Circuits", "Feeds", "Set pressures", "Apply chart", "Gaps", "Repairs", "Leaks", "Consumers"):
        del minimal_book.sheets[name]
    assert minimal_book.read().data == plain


def test_each_land_says_for_itself_how_its_values_are_known(minimal_book: Book) -> None:
    minimal_book.put("Head", 0, "Diameters are", "published")
    for row, known in enumerate(("measured", "", "representative"), start=1):
        minimal_book.put("Lands", row, "Diameter is", known)
    described = minimal_book.read()
    assert [land.representative for land in described.controller.lands][:3] == [
        ("contact_length_mm", "mounting_clearance_um"),
        ("contact_length_mm", "mounting_clearance_um"),
        ("nominal_diameter_mm", "contact_length_mm", "mounting_clearance_um"),
    ]
    assert described.notes == ()


def test_a_circuit_without_a_mark_is_said_to_be_applied_everywhere(five_speed_book: Book) -> None:
    chart = five_speed_book.sheets["Apply chart"]
    assert chart[0] == ["Note", "Circuit", "R", "N", "1", "2", "3", "4", "5"]
    five_speed_book.add("Apply chart", {"Circuit": "epc"})
    described = five_speed_book.read()
    assert described.notes == ("sheet 'Apply chart', row 8: epc has no mark and is taken as applied in every gear",)


@pytest.mark.parametrize("mark", ["X", "yes", 1.0, "●"])
def test_marks_of_the_apply_chart(five_speed_book: Book, mark: object) -> None:
    plain = five_speed_book.read().data
    for row in five_speed_book.sheets["Apply chart"][1:]:
        row[2:] = [mark if cell else "no" for cell in row[2:]]
    assert five_speed_book.read().data == plain
