"""Rules of the house that a machine can see."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
CORE = sorted((ROOT / "atleak").rglob("*.py"))


def _imports(path: Path) -> set[str]:
    tree = ast.parse(path.read_text(encoding="utf-8"))
    names = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            names |= {node.module} | {f"{node.module}.{alias.name}" for alias in node.names}
    return names


@pytest.mark.parametrize("path", CORE, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_core_never_imports_streamlit(path: Path) -> None:
    assert not {name for name in _imports(path) if name.split(".")[0] == "streamlit"}


def _room(path: Path) -> str:
    return path.relative_to(ROOT / "atleak").as_posix()


# What flows from files to reports flows one way: no room imports one that comes after it.
BEFORE = {
    "equations/": (
        "catalogue.controller",
        "catalogue.fluid",
        "readings",
        "road_test",
        "engine.leakage",
        "diagnosis",
        "intake",
        "report",
        "cli",
    ),
    "engine/leakage.py": (
        "intake",
        "diagnosis",
        "report",
        "cli",
        "road_test",
        "readings",
        "engine.projection",
        "engine.series",
    ),
    "engine/series.py": ("intake", "diagnosis", "report", "cli", "road_test", "readings", "engine.projection"),
    "readings.py": ("intake", "engine.leakage", "diagnosis", "report", "cli"),
    "road_test.py": ("intake", "engine.leakage", "diagnosis", "report", "cli"),
    "uncertainty/": ("intake", "diagnosis", "report", "cli", "road_test"),
    "engine/projection.py": ("intake", "diagnosis", "report", "cli"),
    "engine/road_leakage.py": ("intake", "diagnosis", "report", "cli"),
    "diagnosis.py": ("intake", "report", "cli"),
    "intake/": ("engine.leakage", "diagnosis", "engine.projection", "report", "cli"),
    "report/": ("cli", "intake"),
    "views/": ("report", "cli", "intake"),
}


@pytest.mark.parametrize("room", BEFORE)
def test_flow_has_one_direction(room: str) -> None:
    paths = [path for path in CORE if _room(path).startswith(room)]
    assert paths
    for path in paths:
        for later in BEFORE[room]:
            taken = {n for n in _imports(path) if n == f"atleak.{later}" or n.startswith(f"atleak.{later}.")}
            assert not taken, f"{_room(path)} imports {taken}"


def test_import_is_quick_because_rooms_are_loaded_when_used() -> None:
    code = "import sys, atleak; print([m for m in ('numpy', 'pandas', 'pydantic', 'streamlit') if m in sys.modules])"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.strip() == "[]"


def test_diagnosing_needs_no_heavy_room() -> None:
    heavy = ("streamlit", "plotly", "matplotlib", "typst", "openpyxl", "scipy", "asammdf", "xlsxwriter")
    code = f"import sys, atleak.cli, atleak.diagnosis, atleak.intake.readings\n\
import atleak.views.diagnosis_record, atleak.report.terminal\n\
print([m for m in {heavy!r} if m in sys.modules])"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.strip() == "[]"


def test_public_names_are_all_there() -> None:
    import atleak

    assert all(getattr(atleak, name) is not None for name in atleak.__all__)
    assert set(atleak.__all__) <= set(dir(atleak))
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = atleak.nothing


TESTS = sorted((ROOT / "tests").rglob("*.py"))


@pytest.mark.parametrize("path", TESTS, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_comparisons_say_their_absolute_tolerance(path: Path) -> None:
    """Left to itself it is 1e-12, which hides any error of a flow [m³/s], a cube [m³] or a variance [m²]."""
    silent = [
        call.lineno
        for call in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(call, ast.Call)
        and (call.func.attr if isinstance(call.func, ast.Attribute) else getattr(call.func, "id", "")) == "approx"
        and not any(keyword.arg == "abs" for keyword in call.keywords)
    ]
    assert not silent, f"approx() without abs= in lines {silent}; abs=0.0 where the expected value is not 0"
