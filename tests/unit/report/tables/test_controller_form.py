"""A valve body typed in tables of text: nothing is lost on the way to its file, and every fault has its cell."""

from __future__ import annotations

from typing import Any

import pytest

from atleak.catalogue.controller_file import checked_controller, written_toml
from atleak.catalogue.entries import read_tables, shipped_files
from atleak.catalogue.workbook.cells import Units
from atleak.catalogue.workbook.draft import Checked, Draft, checked, copy_of, draft_of, read_draft
from atleak.catalogue.workbook.shapes import SheetFault
from atleak.catalogue.workbook.subjects import CONTROLLER, sketch
from atleak.common.errors import CatalogueError

INCH = Units("inch", "diametral", "psi")


@pytest.fixture(scope="module")
def minimal_tables() -> dict[str, Any]:
    return read_tables("controllers", "minimal_example")[0]


@pytest.fixture(scope="module")
def typed(minimal_tables: dict[str, Any]) -> Draft:
    return draft_of(CONTROLLER, minimal_tables)


def with_row(draft: Draft, table: str, row: int, **cells: str) -> Draft:
    """The draft with some cells of a row, counted from 1, typed over."""
    rows = [dict(each) for each in draft.rows(table)]
    rows[row - 1] |= {heading.replace("_", " "): text for heading, text in cells.items()}
    return draft.with_rows(table, rows)


def fault_of(draft: Draft) -> SheetFault:
    (fault,) = checked(draft).faults
    return fault


@pytest.mark.parametrize("name", shipped_files("controllers"))
@pytest.mark.parametrize("units", [Units(), INCH], ids=["mm", "inch"])
def test_a_shipped_valve_body_typed_in_tables_is_the_same_to_the_last_digit(name: str, units: Units) -> None:
    data, _ = read_tables("controllers", name)
    found = checked(draft_of(CONTROLLER, data, units))
    assert (found.faults, found.doubts, found.notes) == ((), (), ())
    assert found.entry is not None
    known = checked_controller(data, "this description")
    assert found.entry.lands == known.lands
    parts = "gaps circuits pump operating_points leaks consumers line permissible repairs"
    for part in parts.split():
        assert getattr(found.entry, part) == getattr(known, part)


def test_changing_the_units_and_back_changes_no_digit(typed: Draft) -> None:
    inch = typed.in_units(INCH)
    assert inch != typed
    assert inch.rows("Lands")[0]["Mounting clearance"].startswith("0.00141")  # 2 · 18 µm
    assert inch.in_units(Units()) == typed


def test_what_cannot_be_read_stays_as_it_was_typed_whatever_the_units(typed: Draft) -> None:
    wrong = with_row(typed, "Lands", 1, Diameter="about 15")
    assert wrong.in_units(INCH).rows("Lands")[0]["Diameter"] == "about 15"
    fault = fault_of(wrong)
    assert fault.spot == ("Lands", 1, "Diameter")
    assert fault.text == "cannot be read (found 'about 15'); expected a number in mm"


@pytest.mark.parametrize("text", ["23,4", "23.4", " 23,40 mm"])
def test_a_comma_is_a_decimal_sign(typed: Draft, text: str) -> None:
    data = checked(with_row(typed, "Lands", 1, Diameter=text)).data
    assert data["components"][0]["lands"][0]["nominal_diameter_mm"] == 23.4


def test_every_fault_is_named_at_once_with_its_cell(typed: Draft) -> None:
    wrong = with_row(typed, "Lands", 2, Diameter="1500", Mounting_clearance="x")
    wrong = with_row(wrong, "Operating points", 1, Gear="9").with_cell("Pump", "Volumetric efficiency", "1,5")
    wrong = with_row(wrong, "Components", 4, Name="")
    places = [fault.spot for fault in checked(wrong).faults]
    assert places == [
        ("Components", 4, "Name"),
        ("Lands", 2, "Mounting clearance"),
        ("Lands", 2, "Diameter"),
        ("Pump", None, "Volumetric efficiency"),
        ("Operating points", 1, "Gear"),
    ]


def test_what_is_wrong_with_a_default_of_all_lands_is_said_once_at_the_head(typed: Draft) -> None:
    fault = fault_of(typed.with_cell("Head", "Tolerance of mounting clearances", "30"))
    assert fault.spot[::2] == ("Head", "Tolerance of mounting clearances")
    assert "its mounting clearance of" in fault.text


def test_an_empty_description_says_what_is_to_be_filled_in() -> None:
    found = checked(Draft(CONTROLLER))
    assert found.entry is None
    assert [(*fault.spot[::2], fault.text) for fault in found.faults] == [
        *(("Head", heading, "this cell must be filled in") for heading in ("Name", "Source", "Date", "Gears")),
        *(
            (table, None, "nothing is filled in yet")
            for table in ("Materials", "Components", "Pump", "Operating points")
        ),
    ]
    assert sketch(found.data) is None


def test_the_id_is_made_from_the_name_unless_it_is_typed(typed: Draft) -> None:
    named = typed.with_cell("Head", "Id", "").with_cell("Head", "Name", "Our box, 2012")
    assert checked(named).data["id"] == "our_box_2012"
    assert checked(named.with_cell("Head", "Id", "box")).data["id"] == "box"


def test_a_copy_has_a_name_and_an_id_of_its_own(minimal_tables: dict[str, Any]) -> None:
    found = checked(draft_of(CONTROLLER, copy_of(minimal_tables)))
    assert found.data["name"] == f"{minimal_tables['name']}, own copy"
    assert found.data["id"] not in shipped_files("controllers")
    assert found.faults == ()


def test_empty_rows_between_others_mean_nothing(typed: Draft) -> None:
    rows = typed.rows("Lands")
    spread = typed.with_rows("Lands", [{}, *rows[:2], {"Land": "  "}, *rows[2:], {}, {}])
    assert checked(spread).data == checked(typed).data
    assert len(spread.rows("Lands")) == len(rows) + 2
    fault = fault_of(with_row(spread, "Lands", 5, Diameter="x"))
    assert fault.spot[:2] == ("Lands", 5)


def test_a_draft_is_read_back_as_it_was_kept_and_a_damaged_one_is_none(typed: Draft) -> None:
    assert read_draft(CONTROLLER, typed.in_units(INCH).written()) == typed.in_units(INCH)
    for text in ("", "[", "{}", "[]", '{"format": 0}', '{"format": 1, "units": {"length": "ell"}, "tables": 3}'):
        assert read_draft(CONTROLLER, text) is None


def test_what_was_typed_is_written_as_a_file_and_read_again(typed: Draft, tmp_path: Any) -> None:
    found = checked(typed)
    path = tmp_path / "own.toml"
    path.write_text(written_toml(found.data), encoding="utf-8")
    assert checked(draft_of(CONTROLLER, read_tables("controllers", path)[0])).data == found.data


def _drawn(found: Checked) -> list[tuple[str, int]]:
    controller = sketch(found.data)
    return [] if controller is None else [land.key for land in controller.lands]


def test_lands_are_drawn_before_the_rest_is_filled_in() -> None:
    draft = Draft(CONTROLLER).with_rows("Components", [{"Id": "8", "Name": "shift valve"}, {"Id": "9"}])
    lands = [
        {"Component": "8", "Land": "1", "Diameter": "12,5"},
        {"Component": "8", "Land": "2"},  # no diameter yet
        {"Component": "8", "Land": "3", "Diameter": "14", "Contact length": "4"},
        {"Component": "9", "Land": "1", "Diameter": "900"},  # no spool is that thick
    ]
    found = checked(draft.with_rows("Lands", lands))
    assert found.faults
    assert _drawn(found) == [("8", 1), ("8", 3)]
    with pytest.raises(CatalogueError):
        checked_controller(found.data)


def test_a_number_that_another_unit_would_make_usual_is_asked_about_and_saved_all_the_same(typed: Draft) -> None:
    found = checked(with_row(typed, "Lands", 1, Diameter="0,59"))
    assert found.entry is not None
    (doubt,) = found.doubts
    assert doubt.spot == ("Lands", 1, "Diameter")
    assert doubt.text == "0,59 mm is unusual: was it in inch?"
    refused = checked(with_row(typed, "Lands", 1, Diameter="1500"))
    assert (len(refused.faults), refused.doubts) == (1, ())
