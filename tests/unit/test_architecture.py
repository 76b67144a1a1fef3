"""Rules of the house that a machine can see."""

from __future__ import annotations

import ast
import re
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


def test_colours_stand_in_one_place() -> None:
    modules = {*CORE, *(ROOT / "pages").rglob("*.py"), ROOT / "app.py", ROOT / "serve.py"}
    with_colours = {path for path in modules if re.search(r"#[0-9A-Fa-f]{6}\b", path.read_text(encoding="utf-8"))}
    assert with_colours == {ROOT / "atleak" / "common" / "style.py"}


def test_core_never_imports_streamlit() -> None:
    assert not [path for path in CORE if any(name.split(".")[0] == "streamlit" for name in _imports(path))]


# From the ground up. A module imports its own room and those of the floors below: nothing from above, and nothing from
# the other room of its floor. `docs/architecture.md` says what each holds. A room is a folder of the package.
FLOORS = (
    ("equations",),
    ("common",),
    ("catalogue",),
    ("measurements",),
    ("engine", "readers"),
    ("diagnosis",),
    ("analysis",),
    ("report",),
    ("job",),
    ("job_book",),
    ("fleet",),
    ("cli",),
)
FLOOR_OF = {room: number for number, floor in enumerate(FLOORS) for room in floor}
OUTSIDE = {"__init__", "__main__", "version"}  # the public names, the command, the number of the version
MODULES = {".".join(path.relative_to(ROOT / "atleak").with_suffix("").parts): path for path in CORE}


def _room(module: str) -> str:
    """The room of a module."""
    room = module.split(".")[0]
    assert room in FLOOR_OF, f"{module} stands on no floor of FLOORS"
    return room


def _taken(path: Path) -> set[str]:
    """The modules of the package that a file imports, wherever in the file and for whatever purpose."""
    taken = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path.name}: imports say the package's name"
            names = [f"{node.module}.{alias.name}" for alias in node.names]
        else:
            continue
        taken |= {_module(name) for name in names if name.split(".")[0] == "atleak"}
    return taken


def _module(name: str) -> str:
    """The module in which an imported name stands: ``atleak.diagnosis.rules.Rule`` is in ``rules``."""
    parts = name.split(".")[1:]
    for length in range(len(parts), 0, -1):
        for module in (".".join(parts[:length]), ".".join([*parts[:length], "__init__"])):
            if module in MODULES:
                return module
    return "__init__"


def _wrong_imports(module: str, taken: set[str]) -> list[str]:
    """The imports that lead upward, or sideways out of the room."""
    room = _room(module)
    others = sorted(taken - {"version"})  # everything may say of which version it is
    return [
        each for each in others if each in OUTSIDE or (FLOOR_OF[_room(each)] >= FLOOR_OF[room] and _room(each) != room)
    ]


def test_imports_lead_down() -> None:
    wrong = {module: _wrong_imports(module, _taken(path)) for module, path in MODULES.items() if module not in OUTSIDE}
    assert {module: names for module, names in wrong.items() if names} == {}


def test_equations_need_numpy_alone() -> None:
    modules = [f"import atleak.{module}" for module in MODULES if module.startswith("equations.")]
    others = "[m for m in sys.modules if m.startswith('atleak.') and not m.startswith('atleak.equations')]"
    libraries = "[m for m in ('pandas', 'pydantic', 'scipy') if m in sys.modules]"
    code = "\n".join([*modules, f"import sys; print({others}, {libraries})"])
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.strip() == "['atleak.version'] []"


def test_every_room_of_the_floors_is_there() -> None:
    assert set(FLOOR_OF) == {_room(module) for module in MODULES if module not in OUTSIDE}
    assert sum(map(len, FLOORS)) == len(FLOOR_OF), "a room stands on two floors"


@pytest.mark.parametrize(
    ("module", "taken"),
    [
        ("equations.gap", "common.errors"),  # upward: whoever computes with the equations alone needs nothing else
        ("readers.sheets.rows", "engine.leakage"),  # sideways: the readers know no engine
        ("engine.leakage", "readers.sheets.rows"),  # and the engine no reader
        ("common.files", "__init__"),  # the public names are for users
    ],
)
def test_an_import_that_leads_up_or_sideways_is_noticed(module: str, taken: str) -> None:
    assert _wrong_imports(module, {taken}) == [taken]


def test_a_module_without_a_floor_is_noticed() -> None:
    with pytest.raises(AssertionError, match="stands on no floor"):
        _wrong_imports("attic", set())


# What the package may grow to; lowered when something is taken away, raised only with a reason in the commit.
MOST_MODULES, MOST_LINES = 392, 98_861


def test_the_package_stays_small() -> None:
    lines = sum(len(path.read_text(encoding="utf-8").splitlines()) for path in CORE)
    assert len(CORE) <= MOST_MODULES
    assert lines <= MOST_LINES


def test_import_is_quick_because_rooms_are_loaded_when_used() -> None:
    code = "import sys, atleak; print([m for m in ('numpy', 'pandas', 'pydantic', 'streamlit') if m in sys.modules])"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.strip() == "[]"


def test_diagnosing_needs_no_heavy_room() -> None:
    heavy = ("streamlit", "plotly", "matplotlib", "typst", "openpyxl", "scipy", "asammdf", "xlsxwriter")
    code = f"import sys, atleak.cli, atleak.diagnosis.diagnosis, atleak.readers.sheets.measuring_sheet\n\
import atleak.report.json.diagnosis, atleak.report.terminal\n\
print([m for m in {heavy!r} if m in sys.modules])"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.strip() == "[]"


def test_public_names_are_all_there() -> None:
    import atleak

    assert all(getattr(atleak, name) is not None for name in atleak.__all__)
    assert set(atleak.__all__) <= set(dir(atleak))
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = atleak.nothing


def test_type_checkers_are_given_the_same_public_names() -> None:
    import atleak

    tree = ast.parse((ROOT / "atleak" / "__init__.py").read_text(encoding="utf-8"))
    checked = next(node for node in tree.body if isinstance(node, ast.If))
    told = {
        alias.asname: node.module.removeprefix("atleak.")
        for node in checked.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
    assert told == atleak._MODULES


def test_the_architecture_page_draws_the_floors_that_are_checked() -> None:
    text = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    drawn = re.findall(r"^\| (\d+) \| `(\w+)` \|", text, re.MULTILINE)
    assert drawn == [(str(number), room) for number, floor in enumerate(FLOORS, 1) for room in sorted(floor)]


TESTS = sorted((ROOT / "tests").rglob("*.py"))


def test_comparisons_say_their_absolute_tolerance() -> None:
    """Left to itself it is 1e-12, which hides any error of a flow [m³/s], a cube [m³] or a variance [m²]."""
    silent = [
        f"{path.relative_to(ROOT).as_posix()}:{call.lineno}"
        for path in TESTS
        for call in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(call, ast.Call)
        and (call.func.attr if isinstance(call.func, ast.Attribute) else getattr(call.func, "id", "")) == "approx"
        and not any(keyword.arg == "abs" for keyword in call.keywords)
    ]
    assert not silent, "approx() without abs=; abs=0.0 where the expected value is not 0"


def test_the_folders_of_tests_are_those_of_the_package() -> None:
    beside = {"pages", "docs", "benchmarks"}  # what is tested besides the package
    package = {path.name for path in (ROOT / "atleak").iterdir() if (path / "__init__.py").is_file()}
    folders = {path.name for path in (ROOT / "tests" / "unit").iterdir() if any(path.glob("**/test_*.py"))}
    assert folders - package - beside == set()
    assert len(folders & package) == len(FLOOR_OF)
