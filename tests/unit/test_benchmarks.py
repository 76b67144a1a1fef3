"""Every benchmark can be imported and has a small size, which continuous integration runs."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from types import ModuleType

import pytest

FOLDER = Path(__file__).resolve().parents[2] / "benchmarks"
HELPERS = ("timing", "postgresql", "servers")  # what benchmarks share
NAMES = sorted(path.stem for path in FOLDER.glob("*.py") if path.stem not in HELPERS)


@pytest.mark.parametrize("name", NAMES)
def test_a_benchmark_is_imported_and_has_a_small_size(benchmark_of: Callable[[str], ModuleType], name: str) -> None:
    module = benchmark_of(name)
    assert module.OPTIONS.parse_args(["--small"]).small
    assert callable(module.main)
