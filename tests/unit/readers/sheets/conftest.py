"""A small controller and two ways to write a measuring sheet."""

from __future__ import annotations

import io
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import openpyxl
import pytest

from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import load_controller
from atleak.readers.sheets.measuring_sheet import ReadingsRefused, read_readings

CONTROLLER = """
id = "three_pairs"
name = "Three pairs"
source = "made up for tests"
date = "2026-01-01"
representative = "Everything here is representative."
representative_values = ["nominal_diameter_mm", "contact_length_mm", "mounting_clearance_um"]
gears = [1, 2]

[materials.aluminium]
expansion_per_k = 21.3e-6
source = "representative"

[defaults]
contact_length_mm = 5.0
body = "aluminium"
spool = "aluminium"

[pump]
displacement_mm3 = 18000.0
volumetric_efficiency = 0.92
source = "representative"

[[operating_points]]
name = "driving_second"
label = "driving"
temperature_c = 80.0
engine_rpm = 1500.0
gear = 2
p_g_kpa = 800.0
p_k_kpa = 400.0
source = "representative"

[[components]]
id = "1"
name = "pump"

[[components]]
id = "6"
name = "clutch B valve"
lands = [
  { land = 1, nominal_diameter_mm = 9.939, mounting_clearance_um = 25.0 },
  { land = 2, nominal_diameter_mm = 9.942, mounting_clearance_um = 25.0 },
]

[[components]]
id = "8"
name = "brake C1 valve"
lands = [{ land = 1, planes = ["1", "2"], nominal_diameter_mm = 10.0, mounting_clearance_um = 30.0 }]

[[components]]
id = "12'"
name = "brake F damper"
part = "piston"
lands = [{ land = 1, nominal_diameter_mm = 14.0, mounting_clearance_um = 35.0 }]
"""

TIDY = ("component", "part", "plane", "direction", "repeat", "diameter_mm")

Row = Sequence[Any]


@pytest.fixture(scope="session")
def three_pairs(tmp_path_factory: pytest.TempPathFactory) -> Controller:
    path = tmp_path_factory.mktemp("controllers") / "three_pairs.toml"
    path.write_text(CONTROLLER, encoding="utf-8")
    return load_controller(path)


def workbook(rows: Sequence[Row], *, title: str = "Readings", merge: Sequence[str] = ()) -> bytes:
    book = openpyxl.Workbook()
    book.active.title = title
    for row in rows:
        book.active.append(list(row))
    for cells in merge:
        book.active.merge_cells(cells)
    return saved(book)


def saved(book: openpyxl.Workbook) -> bytes:
    buffer = io.BytesIO()
    book.save(buffer)
    return buffer.getvalue()


def text(rows: Sequence[Row], *, delimiter: str = ",", encoding: str = "utf-8") -> bytes:
    return "\r\n".join(delimiter.join(str(cell) for cell in row) for row in rows).encode(encoding)


@pytest.fixture
def make_workbook() -> Callable[..., bytes]:
    return workbook


@pytest.fixture
def save_book() -> Callable[[openpyxl.Workbook], bytes]:
    return saved


@pytest.fixture
def make_text() -> Callable[..., bytes]:
    return text


@pytest.fixture(scope="session")
def example() -> Controller:
    return load_controller("minimal_example")


@pytest.fixture(scope="module")
def controller(example: Controller) -> Controller:
    """Return the controller that sheets are of where a module has no other."""
    return example


def _typed(cell: str) -> str | float | None:
    """Return what a spreadsheet program makes of a typed text: a number where it can be one."""
    try:
        return float(cell.replace(",", ".")) if cell else None
    except ValueError:
        return cell


@pytest.fixture
def filled_in() -> Callable[..., bytes]:
    """Return a sheet written with semicolons as a text file, or as a workbook; several by name as a workbook."""

    def build(sheets: str | dict[str, str], form: str, merged: Sequence[str] = ()) -> bytes:
        if form == "text":
            assert isinstance(sheets, str)
            return sheets.encode()
        book = openpyxl.Workbook()
        book.remove(book.active)
        for title, lines in ({"Readings": sheets} if isinstance(sheets, str) else sheets).items():
            sheet = book.create_sheet(title)
            for line in lines.split("\n"):
                sheet.append([_typed(cell) for cell in line.split(";")])
            for cells in merged:
                sheet.merge_cells(cells)
        return saved(book)

    return build


@pytest.fixture
def tidy() -> Callable[..., list[Row]]:
    """Return headings and both parts of component 6, land 1, two directions, two repeats, all as they should be.

    ``changed`` replaces rows by their index (0 is the first under the headings), ``added`` puts some at the end.
    """

    def build(changed: dict[int, Row] | None = None, added: Sequence[Row] = ()) -> list[Row]:
        rows: list[Row] = [
            ("6", "spool", "1", "0°", 1, 9.939),
            ("6", "spool", "1", "0°", 2, 9.940),
            ("6", "spool", "1", "90°", 1, 9.938),
            ("6", "spool", "1", "90°", 2, 9.939),
            ("6", "sleeve", "1", "0°", 1, 9.995),
            ("6", "sleeve", "1", "0°", 2, 9.996),
            ("6", "sleeve", "1", "90°", 1, 10.001),
            ("6", "sleeve", "1", "90°", 2, 10.002),
        ]
        for index, row in (changed or {}).items():
            rows[index] = row
        return [TIDY, *rows, *added]

    return build


@pytest.fixture
def refused(controller: Controller) -> Callable[..., ReadingsRefused]:
    """Read what must be refused and return the error."""

    def read(data: bytes | Path, **options: Any) -> ReadingsRefused:
        with pytest.raises(ReadingsRefused) as caught:
            read_readings(data, controller, **{"name": "sheet.xlsx", **options})
        return caught.value

    return read
