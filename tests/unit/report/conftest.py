"""One worn unit with a road test, and one that nobody measured: what every report is tested on."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def calculator() -> type:
    """The referee that calculates a workbook's formulas."""
    path = Path(__file__).with_name("sheet_calculator.py")
    spec = importlib.util.spec_from_file_location("sheet_calculator", path)
    module = importlib.util.module_from_spec(spec)  # type: ignore[arg-type]
    spec.loader.exec_module(module)  # type: ignore[union-attr]
    return module.SheetCalculator
