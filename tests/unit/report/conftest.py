"""One worn unit with a road test, and one that nobody measured: what every report is tested on."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from types import ModuleType

import pytest


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
