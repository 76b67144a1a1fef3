"""Workbooks that describe a valve body, written cell by cell without the looks of the real ones."""

from __future__ import annotations

import io
import tomllib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pytest
import xlsxwriter

from atleak.catalogue.workbook.cells import Units
from atleak.catalogue.workbook.shapes import Form
from atleak.catalogue.workbook.sheets import FIELD, HEAD, HOW_KNOWN, NOTE_HEADING, SHEETS, UNIT_LINES, VALUE
from atleak.common.errors import CatalogueError
from atleak.readers.controller_workbook import DescribedController, read_controller_workbook


class Book:
    """The cells of a workbook by sheet; a test changes some of them and reads the rest."""

    def __init__(self, data: Mapping[str, Any], units: Units) -> None:
        self.sheets: dict[str, list[list[Any]]] = {}
        self.merged: list[tuple[str, int, int, str]] = []  # sheet, first and last row below the headings, heading
        for sheet in SHEETS:
            columns = sheet.columns_for(data)
            rows = [
                {
                    column.heading: column.kind.cell(values[column.heading], units)
                    for column in columns
                    if column.heading in values
                }
                for values in sheet.rows(data)
            ]
            if isinstance(sheet, Form):
                known = {column.how_known: column.heading for column in columns if column.how_known}
                head = [[line.heading, getattr(units, line.keys[0])] for line in UNIT_LINES] if sheet is HEAD else []
                lines = [
                    [column.heading, rows[0].get(column.heading, ""), rows[0].get(known.get(column.key, ""), "")]
                    for column in columns
                    if not column.how_known
                ]
                self.sheets[sheet.name] = [[FIELD, VALUE, HOW_KNOWN, NOTE_HEADING], *head, *lines]
            else:
                headings = [NOTE_HEADING, *(column.heading for column in columns)]
                cells = [[row.get(heading, "") for heading in headings] for row in rows]
                self.sheets[sheet.name] = [headings, *cells]

    def put(self, sheet: str, row: int, heading: str, value: Any) -> None:
        """Write into a table's row, counted from 1 below the headings, or into the field of a form."""
        rows = self.sheets[sheet]
        if rows[0][0] == FIELD:
            next(line for line in rows if line[0] == heading)[1] = value
        else:
            rows[row][rows[0].index(heading)] = value

    def add(self, sheet: str, values: Mapping[str, Any]) -> None:
        """Add a row to a table."""
        rows = self.sheets[sheet]
        rows.append([values.get(heading, "") for heading in rows[0]])

    def workbook(self) -> bytes:
        """The file; text that begins with "=" is a formula without a result."""
        stream = io.BytesIO()
        with xlsxwriter.Workbook(
            stream, {"in_memory": True, "strings_to_formulas": False, "default_date_format": "yyyy-mm-dd"}
        ) as target:
            for name, rows in self.sheets.items():
                page = target.add_worksheet(name)
                for number, row in enumerate(rows):
                    for column, cell in enumerate(row):
                        if isinstance(cell, str) and cell.startswith("="):
                            page.write_formula(number, column, cell, None, "")
                        elif isinstance(cell, str):
                            page.write_string(number, column, cell)
                        else:
                            page.write(number, column, cell)
            for name, first, last, heading in self.merged:
                column = self.sheets[name][0].index(heading)
                cell = self.sheets[name][first][column]
                target.get_worksheet_by_name(name).merge_range(first, column, last, column, cell)
        return stream.getvalue()

    def read(self) -> DescribedController:
        """The valve body that it describes."""
        return read_controller_workbook(self.workbook(), name="unit.xlsx")

    def faults(self) -> list[CatalogueError]:
        """Everything that is wrong with it."""
        with pytest.raises(CatalogueError) as caught:
            self.read()
        return [caught.value, *caught.value.others]  # type: ignore[list-item]


@pytest.fixture(scope="session")
def tables(root: Path) -> Callable[[str], dict[str, Any]]:
    """The tables of a shipped controller, or of one of the tests."""

    def read(name: str) -> dict[str, Any]:
        own = root / "tests" / f"{name}.toml"
        path = own if own.exists() else root / "atleak" / "catalogue" / "controllers" / f"{name}.toml"
        return tomllib.loads(path.read_text(encoding="utf-8"))

    return read


@pytest.fixture
def minimal_book(tables: Callable[[str], dict[str, Any]]) -> Book:
    """The minimal example in millimetres, with radial clearances."""
    return Book(tables("minimal_example"), Units())


@pytest.fixture
def inch_book(tables: Callable[[str], dict[str, Any]]) -> Book:
    """The minimal example in inches, with diametral clearances."""
    return Book(tables("minimal_example"), Units("inch", "diametral"))


@pytest.fixture
def five_speed_book(tables: Callable[[str], dict[str, Any]]) -> Book:
    """The five-speed in inches, with diametral clearances and pressures in psi."""
    return Book(tables("five_speed_2005"), Units("inch", "diametral", "psi"))
