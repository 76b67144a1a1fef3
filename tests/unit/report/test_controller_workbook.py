"""The workbook that describes a valve body, as it is written."""

from __future__ import annotations

import io
import tomllib
from pathlib import Path
from typing import Any

import openpyxl
import pytest

from atleak.catalogue.workbook.cells import ChoiceCell, Units, YesNo
from atleak.catalogue.workbook.shapes import Form
from atleak.catalogue.workbook.sheets import INSTRUCTIONS, LISTS, NAMES, SHEETS, UNIT_LINES
from atleak.common.errors import OutputError
from atleak.readers.controller_workbook import read_controller_workbook
from atleak.report.sheets.controller_workbook import write_controller_workbook

INCH = Units("inch", "diametral", "psi")


@pytest.fixture(scope="module")
def template() -> Any:
    return openpyxl.load_workbook(io.BytesIO(write_controller_workbook(units=INCH)))


@pytest.fixture(scope="module")
def tables(root: Path) -> dict[str, Any]:
    return tomllib.loads((root / "tests" / "three_circuits.toml").read_text(encoding="utf-8"))


def _cells(page: Any) -> dict[Any, Any]:
    """Cells by what stands in them, the first of each."""
    cells: dict[Any, Any] = {}
    for row in page.iter_rows():
        for cell in row:
            cells.setdefault(cell.value, cell)
    return cells


def _offered(page: Any, address: str) -> list[str]:
    return [each.formula1 for each in page.data_validations.dataValidation if address in each.sqref]


def test_every_closed_list_and_every_name_of_another_sheet_has_its_drop_down(template: Any) -> None:
    for sheet in SHEETS:
        page, cells = template[sheet.name], _cells(template[sheet.name])
        for column in sheet.columns:
            if isinstance(sheet, Form):
                if column.how_known:
                    continue
                address = f"C{cells[column.heading].row}"
            else:
                address = f"{cells[column.heading].column_letter}{page.max_row}"
            offered = _offered(page, address)
            if isinstance(column.kind, ChoiceCell):
                assert offered == [f'"{",".join(column.kind.shown)}"'], column
            elif isinstance(column.kind, YesNo):
                assert offered == ['"yes,no"'], column
            elif column.names:
                assert offered == [f"{column.names.replace(' ', '_')}_names"], column
            else:
                assert offered == [], column
    assert {f"{names.replace(' ', '_')}_names" for names in NAMES} <= set(template.defined_names)


def test_units_under_the_headings_follow_the_choice_on_the_first_sheet(template: Any) -> None:
    page = template["Lands"]
    column = _cells(page)["Mounting clearance"]
    formula = page.cell(column.row + 1, column.column).value
    assert formula == '=IF(\'Head\'!$C$5="inch","inch","µm")&", "&\'Head\'!$C$6'
    assert [template["Head"].cell(row, 2).value for row in (5, 6, 7)] == [line.heading for line in UNIT_LINES]
    assert [template["Head"].cell(row, 3).value for row in (5, 6, 7)] == ["inch", "diametral", "psi"]


def test_examples_in_inches_show_as_few_digits_as_what_people_type(template: Any) -> None:
    page = template["Lands"]
    examples = {page.cell(4, cell.column).value: cell for cell in page[6]}
    assert 0.387 < examples["Diameter"].value < 0.389
    for heading in ("Diameter", "Contact length", "Mounting clearance", "Up to"):
        assert examples[heading].number_format == "0.0####"


def test_the_first_sheet_has_a_picture_and_leads_to_every_other(template: Any) -> None:
    assert template.sheetnames == [INSTRUCTIONS, *(sheet.name for sheet in SHEETS), LISTS]
    assert template[LISTS].sheet_state == "hidden"
    page = template[INSTRUCTIONS]
    assert len(page._images) == 1
    named = {cell.value for row in page.iter_rows(max_col=1) for cell in row}
    assert named >= {sheet.name for sheet in SHEETS}


def test_the_same_tables_give_the_same_bytes(tables: dict[str, Any]) -> None:
    assert write_controller_workbook(tables, INCH) == write_controller_workbook(tables, INCH)


def test_text_stays_text(tables: dict[str, Any]) -> None:
    given = {**tables, "note": "=1+1\nhttps://example.org", "name": "0012"}
    described = read_controller_workbook(write_controller_workbook(given), name="unit.xlsx")
    assert (described.data["note"], described.data["name"]) == (given["note"], given["name"])


def test_what_no_cell_can_hold_is_refused(tables: dict[str, Any]) -> None:
    with pytest.raises(OutputError, match="Note is too long for a cell"):
        write_controller_workbook({**tables, "note": "x" * 32_768})


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["ods", "xlsx"])
def test_a_workbook_saved_by_libreoffice_describes_the_same(
    tables: dict[str, Any], tmp_path: Path, convert: Any, kind: str
) -> None:
    folder = tmp_path / "saved"
    folder.mkdir()
    path = folder / "unit.xlsm"  # a name of its own, so that the copy is another file
    path.write_bytes(write_controller_workbook(tables, INCH))
    convert(path, kind)
    assert read_controller_workbook(path.with_suffix(f".{kind}")).data == read_controller_workbook(path).data
