"""One worn unit with a road test, and one that nobody measured: what every report is tested on."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import openpyxl
import pytest
from openpyxl.utils.cell import coordinate_to_tuple
from python_calamine import CalamineWorkbook


@pytest.fixture(scope="session")
def referee() -> ModuleType:
    """What judges a workbook: a calculator of its own, and the comparison with what atleak gives."""
    path = Path(__file__).with_name("sheet_calculator.py")
    spec = importlib.util.spec_from_file_location("sheet_calculator", path)
    module = importlib.util.module_from_spec(spec)  # type: ignore[arg-type]
    spec.loader.exec_module(module)  # type: ignore[union-attr]
    return module


@pytest.fixture(scope="session")
def calculator(referee) -> type:
    """The referee that calculates a workbook's formulas."""
    return referee.SheetCalculator


@pytest.fixture
def recalculated(tmp_path, convert) -> Callable[[openpyxl.Workbook], Callable[[str, str], Any]]:
    """LibreOffice again: it gets formulas without cached values, and says what each cell gives."""

    def run(book):
        book.save(tmp_path / "in.xlsx")  # openpyxl writes no cached values
        convert(tmp_path / "in.xlsx", "ods")
        sheets = CalamineWorkbook.from_path(tmp_path / "in.ods")
        rows = {name: sheets.get_sheet_by_name(name).to_python(skip_empty_area=False) for name in sheets.sheet_names}

        def value(sheet, address):
            row, column = coordinate_to_tuple(address)
            return rows[sheet][row - 1][column - 1]

        return value

    return run
