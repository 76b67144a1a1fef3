"""Limits, instruments and fluids typed in forms: nothing is lost on the way to a file, every fault has its field."""

from __future__ import annotations

import tomllib
from typing import Any

import pytest

from atleak.catalogue.entries import read_tables, shipped_files
from atleak.catalogue.workbook.cells import Units
from atleak.catalogue.workbook.draft import Draft, Subject, checked, copy_of, draft_of, read_draft
from atleak.catalogue.workbook.subjects import CONTROLLER, FLUID, INSTRUMENT, LIMITS, SUBJECTS

SHIPPED = [(kind, name) for kind in SUBJECTS for name in shipped_files(kind)]


def typed(subject: Subject, name: str) -> Draft:
    return draft_of(subject, read_tables(subject.kind, name)[0])


def at(found: Any) -> list[tuple[str, str | None]]:
    return [fault.spot[::2] for fault in found]


def _meant(tables: dict[str, Any]) -> dict[str, Any]:
    """The tables without what says nothing."""
    return {key: value for key, value in tables.items() if value != []}


@pytest.mark.parametrize(("kind", "name"), SHIPPED)
@pytest.mark.parametrize("units", [Units(), Units("inch", "diametral", "psi")], ids=["mm", "inch"])
def test_a_shipped_entry_typed_in_forms_is_the_same_to_the_last_digit(kind: str, name: str, units: Units) -> None:
    data, _ = read_tables(kind, name)
    found = checked(draft_of(SUBJECTS[kind], data, units))
    assert (found.faults, found.doubts) == ((), ())
    assert _meant(tomllib.loads(SUBJECTS[kind].toml(found.data))) == _meant(data)


@pytest.mark.parametrize("subject", SUBJECTS.values(), ids=SUBJECTS)
def test_every_key_of_the_file_has_a_field(subject: Subject) -> None:
    known = {key for sheet in subject.sheets for column in sheet.columns for key in (*sheet.at, *column.keys)}
    known |= {"representative"}  # of an instrument: the fields beside its numbers
    assert set(subject.shelf.model.model_fields) <= known


@pytest.mark.parametrize(
    ("table", "cells", "heading", "said"),
    [
        ("Wear", {"Replace": "5"}, "Replace", "replace above watch (10)"),
        ("Wear", {"Watch": "0"}, "Watch", "a number greater than 0 in wear_percent.watch"),
        ("Wear", {"Replace": "half"}, "Replace", "cannot be read (found 'half'); expected a number in %"),
        ("Wear", {"Source of the limit": ""}, "Source of the limit", "this cell must be filled in"),
        ("Reserve", {"Red": "1,6"}, "Red", "amber above red above critical"),
        ("Share of the unit", {"Critical": ""}, "Critical", "this cell must be filled in"),
        ("Share of a pair", {"Replace": "1"}, "Replace", "replace above watch"),
        ("Head", {"Date": "yesterday"}, "Date", "a day such as 2026-01-31"),
    ],
)
def test_a_limit_that_cannot_be_is_named_at_its_field(
    table: str, cells: dict[str, str], heading: str, said: str
) -> None:
    draft = typed(LIMITS, "project_default")
    for name, text in cells.items():
        draft = draft.with_cell(table, name, text)
    found = checked(draft)
    assert found.entry is None
    (fault,) = found.faults
    assert fault.spot[::2] == (table, heading)
    assert said in fault.text


def test_doubts_stand_at_their_fields_and_do_not_keep_it_from_being_saved() -> None:
    draft = typed(LIMITS, "project_default").with_cell("Wear", "Replace", "5000").with_cell("Wear", "Watch", "10,5")
    found = checked(draft)
    assert found.entry is not None
    assert at(found.doubts) == [("Wear", "Replace"), ("Wear", "Limit is")]
    assert found.data["wear_percent"]["watch"]["percent"] == 10.5


def test_doubts_are_seen_while_something_else_is_still_missing() -> None:
    draft = (
        typed(INSTRUMENT, "micrometer").with_cell("Head", "Source", "").with_cell("Uncertainty", "Calibration", "1000")
    )
    found = checked(draft)
    assert at(found.faults) == [("Head", "Source")]
    assert at(found.doubts) == [("Uncertainty", "Calibration")]


def test_a_viscosity_that_rises_with_temperature_is_named_in_its_row() -> None:
    draft = typed(FLUID, "mobil_atf_220")
    rows = [dict(row) for row in draft.rows("Viscosity")]
    rows[1]["Kinematic viscosity"] = "7000"
    (fault,) = checked(draft.with_rows("Viscosity", rows)).faults
    assert fault.spot == ("Viscosity", 2, "Kinematic viscosity")
    assert "viscosity must fall from 40 to 100 °C" in fault.text


def test_an_empty_entry_says_what_must_be_filled_in() -> None:
    assert set(at(checked(Draft(INSTRUMENT)).faults)) >= {
        ("Head", "Name"), ("Head", "Source"), ("Head", "Date"), ("Head", "Measures"), ("Uncertainty", "Resolution"),
    }  # fmt: skip
    assert {table for table, _ in at(checked(Draft(FLUID)).faults)} == {"Head", "Density", "Viscosity"}


def test_lengths_typed_in_inches_are_saved_in_micrometres() -> None:
    draft = typed(INSTRUMENT, "micrometer").in_units(Units("inch"))
    found = checked(draft.with_cell("Uncertainty", "Resolution", "0,00005"))
    assert found.data["resolution_um"] == pytest.approx(1.27, abs=1e-12)


def test_a_copy_has_an_id_of_its_own() -> None:
    data = read_tables("instruments", "micrometer")[0]
    found = checked(draft_of(INSTRUMENT, copy_of(data)))
    assert found.entry is not None
    assert found.data["id"] == "outside_micrometer_own_copy"


def test_a_draft_is_read_back_only_as_what_it_is() -> None:
    draft = typed(FLUID, "mobil_atf_220")
    assert read_draft(FLUID, draft.written()) == draft
    assert read_draft(INSTRUMENT, draft.written()) is None
    assert read_draft(CONTROLLER, draft.written()) is None


@pytest.mark.parametrize("subject", [*SUBJECTS.values(), CONTROLLER], ids=lambda subject: subject.kind)
def test_no_heading_stands_over_two_keys_of_a_table(subject: Subject) -> None:
    for sheet in subject.sheets:
        headings = [column.heading for column in sheet.columns]
        assert len(headings) == len(set(headings))
