"""A table of units as workshops write it: headings understood, rows with their numbers, refusals in words."""

from __future__ import annotations

import datetime as dt
import io
import re
from collections import defaultdict
from pathlib import Path

import openpyxl
import pandas as pd
import pytest

from atleak.common.errors import InputError
from atleak.readers.dates import words
from atleak.readers.unit_table import UnitTable, column_meant, read_unit_table, spellings

_CODE = re.compile("`([^`]+)`")
_ROWS = [["Messblatt", "Laufleistung", "Lieferant"], ["a.xlsx", "123,5", "Müller"], ["b.xlsx", "", "Żółty"]]


def _read(folder: Path, name: str, content: bytes) -> UnitTable:
    path = folder / name
    path.write_bytes(content)
    return read_unit_table(path)


def _text(delimiter: str) -> str:
    return "\n".join(delimiter.join(f'"{cell}"' if delimiter in cell else cell for cell in row) for row in _ROWS)


@pytest.mark.parametrize("delimiter", [";", "\t", ",", "|"])
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
def test_text_is_read_whatever_separates_its_columns(tmp_path: Path, delimiter: str, encoding: str) -> None:
    table = _read(tmp_path, "fleet.csv", _text(delimiter).encode(encoding))
    assert [column.meaning for column in table.columns] == ["readings", "mileage", None]
    assert [list(row.cells) for row in table.rows] == _ROWS[1:]
    assert [row.number for row in table.rows] == [2, 3]
    assert table.labels == ("Lieferant",)


def test_a_spreadsheet_program_s_code_page_is_read(tmp_path: Path) -> None:
    text = "sheet;Lieferant\nmüller.xlsx;Groß\n"
    assert _read(tmp_path, "fleet.csv", text.encode("cp1252")).rows[0].cells == ["müller.xlsx", "Groß"]


def test_titles_empty_rows_and_a_stated_delimiter_are_understood(tmp_path: Path) -> None:
    text = 'sep=;\nFleet of May\n\nSheet;Note\na.xlsx;"two\nlines"\n;\n\nb.xlsx;x\n'
    table = _read(tmp_path, "fleet.csv", text.encode())
    assert [(row.number, row.cells[0]) for row in table.rows] == [(5, "a.xlsx"), (8, "b.xlsx")]
    assert str(table.place(table.rows[1], "readings")) == "fleet.csv, row 8, column Sheet"


def test_a_workbook_is_read_from_the_sheet_with_the_headings(tmp_path: Path) -> None:
    book = openpyxl.Workbook()
    book.active.append(["About this fleet"])
    hidden = book.create_sheet("old")
    hidden.append(["Sheet"])
    hidden.append(["old.xlsx"])
    hidden.sheet_state = "hidden"
    sheet = book.create_sheet("Units")
    sheet.append(["Sheet", "Mileage", "Date"])
    sheet.append(["a.xlsx", 120000, dt.date(2026, 4, 17)])
    target = io.BytesIO()
    book.save(target)
    table = _read(tmp_path, "fleet.xlsx", target.getvalue())
    assert (table.sheet, table.rows[0].number) == ("Units", 2)
    assert [table.cell(table.rows[0], name) for name in ("readings", "mileage")] == ["a.xlsx", 120000]
    assert str(table.cell(table.rows[0], "date"))[:10] == "2026-04-17"
    assert table.cell(table.rows[0], "vin") == ""


def test_parquet_is_read_with_its_types_and_without_an_index(tmp_path: Path) -> None:
    frame = pd.DataFrame({"log": ["a.csv", "b.csv"], "mileage_km": [1.5, None]}, index=[7, 9])
    target = io.BytesIO()
    frame.to_parquet(target)
    table = _read(tmp_path, "fleet.parquet", target.getvalue())
    assert [column.heading for column in table.columns] == ["log", "mileage_km"]
    assert [(row.number, tuple(row.cells)) for row in table.rows] == [(1, ("a.csv", 1.5)), (2, ("b.csv", ""))]


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", "the file is empty"),
        (b"time;pressure\n1;2\n", "no headings of a table of units are found (found 'time, pressure')"),
        (b"sheet;log\n;\n", "no row stands under the headings"),
        (b"sheet;Messblatt\na;b\n", "row 1, column Messblatt: says the same as the column sheet"),
        (b"sheet;Batch;batch\na;1;2\n", "row 1, column batch: says the same as the column Batch"),
        (b"sheet;Temperature\na;1\n", "column Temperature: this heading can be understood in two ways"),
        (b"PAR1 no parquet PAR1", "fleet.csv: is no sound Parquet file"),
        (b"PK\x03\x04 no workbook", "fleet.csv: "),
    ],
)
def test_what_is_no_table_of_units_is_refused_in_words(tmp_path: Path, content: bytes, said: str) -> None:
    with pytest.raises(InputError) as refused:
        _read(tmp_path, "fleet.csv", content)
    assert said in str(refused.value)
    assert "expected" in str(refused.value)
    assert "measuring sheet as" not in str(refused.value)  # the words of another door


def test_a_table_that_is_not_there_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"cannot be read: .*; expected a table of units"):
        read_unit_table(tmp_path / "fleet.csv")


def test_every_spelling_of_a_heading_means_one_column() -> None:
    meant: dict[str, set[str]] = defaultdict(set)
    for column, name in spellings():
        meant[words(name)].add(column)
        assert column_meant(name.upper() if name.isascii() else name) == column
    assert {name: columns for name, columns in meant.items() if len(columns) > 1} == {}


@pytest.mark.parametrize(
    ("heading", "column"),
    [
        ("Mileage [km]", "mileage"),
        ("Odometer (miles)", "mileage"),
        ("Fahrgestellnummer", "vin"),
        ("Serial number of the transmission", "serial"),
        ("Auftragsnummer", "number"),
        ("fluid-state", "fluid_state"),
        ("S/N", "serial"),
        ("Unit", None),
        ("Batch", None),
        ("", None),
    ],
)
def test_headings_of_measuring_sheets_mean_the_same_in_a_table(heading: str, column: str | None) -> None:
    assert column_meant(heading) == column


def test_the_documentation_names_headings_that_are_understood(root: Path, tmp_path: Path) -> None:
    text = (root / "docs" / "fleet.md").read_text(encoding="utf-8")
    told = text.split("### A table of units")[1].split("Every other column")[0]
    named = [name for line in told.splitlines() if line.startswith("| `") for name in _CODE.findall(line.split("|")[1])]
    assert len(named) > 25
    assert [name for name in named if column_meant(name) is None] == []
    shown = told.split("```")[1].strip()
    table = _read(tmp_path, "fleet.csv", shown.encode())
    assert table.labels == ("Supplier", "Batch")
    assert len(table.rows) == 2
