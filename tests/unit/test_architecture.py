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
    assert with_colours == {ROOT / "atleak" / "look.py"}


def test_core_never_imports_streamlit() -> None:
    assert not [path for path in CORE if any(name.split(".")[0] == "streamlit" for name in _imports(path))]


# From the ground up. A module imports its own room and the floors below: nothing from above, and nothing from another
# room of its own floor. `docs/architecture.md` draws them. A room is a module or a folder; the longest name counts.
FLOORS = (
    ("sentence", "verdicts"),
    (
        "errors",
        "schemas",
        "system.printable",
        "system.reasons",
        "version",
        "workshop_units",
        "thinning",
        "keeping",
    ),
    (
        "equations",
        "faults",
        "doors",
        "system.files",
        "system.home",
        "system.marks",
        "system.memory",
        "look",
        "paper",
        "unit_systems",
    ),
    ("catalogue", "wording", "system.drafts", "system.entries", "admission", "spreads"),
    ("written_numbers", "phrases", "report.printed_fonts"),
    ("pressure_table", "controller_sheets", "own_lands", "wear_line"),
    ("readings", "road_test", "gauge_study", "job.record"),
    ("events", "engine.profile", "engine.extremes", "engine.restrictions"),
    ("engine.balance",),
    ("engine.circuits",),
    ("engine.leakage", "engine.lasting"),
    ("engine.line", "engine.gap_polynomials", "engine.assumed_pressure"),
    ("engine.circuit_series",),
    ("engine.series", "engine.projection", "engine.repaired", "engine.flows"),
    ("engine.road_samples",),
    ("engine.road_leakage", "engine.road_pressure", "rules"),
    ("engine.road_bands", "uncertainty", "variants"),
    ("sheet_checks", "provisional", "replace_mileage", "road_findings", "gauges", "learning"),
    ("driven",),
    ("land_diagnosis", "result_messages"),
    ("diagnosis",),
    ("repair", "next_checks", "comparison", "history", "what_if", "fleet.summed"),
    ("views", "intake"),
    ("channel_formulas", "report.drawn_png", "report.own_font", "report.paging"),
    (
        "figures",
        "measuring",
        "job.case",
        "report.printed_charts",
        "report.terminal",
        "report.pressure_sheet",
        "report.gauge_study_sheet",
        "report.controller_workbook",
        "report.lands_sheet",
    ),
    (
        "job.decisions",
        "job.of_sheet",
        "job.judged_anew",
        "job.kinds",
        "job.photo_notes",
        "job.steps",
    ),
    ("job.doubts",),
    ("job.estimate", "job.issued"),
    ("report.estimate_words", "report.pictures", "job.repair_set"),
    (
        "job.parts",
        "report.pdf",
        "report.xlsx",
        "report.measuring_sheet",
        "report.comparison_terminal",
    ),
    ("job.file",),
    ("report.batch", "jobs"),
    ("fleet",),
    ("cli",),
    ("__main__", "__init__"),
)
FLOOR_OF = {room: number for number, floor in enumerate(FLOORS) for room in floor}
# The intake stands beside the engine and neither knows the other: its floor is above the engine, its imports end here.
INTAKE_STANDS_ON = FLOOR_OF["road_test"]
MODULES = {".".join(path.relative_to(ROOT / "atleak").with_suffix("").parts): path for path in CORE}


def _room(module: str) -> str | None:
    """The room of a module; None where it stands on no floor."""
    parts = module.split(".")
    names = (".".join(parts[:length]) for length in range(len(parts), 0, -1))
    return next((name for name in names if name in FLOOR_OF), None)


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
    assert room is not None, f"{module} stands on no floor of FLOORS"
    wrong = []
    for other in sorted(taken):
        target = _room(other)
        assert target is not None, f"{other} stands on no floor of FLOORS"
        highest = INTAKE_STANDS_ON if room == "intake" else FLOOR_OF[room] - 1
        if target != room and FLOOR_OF[target] > highest:
            wrong.append(other)
    return wrong


def test_imports_lead_down() -> None:
    taken = {module: _taken(path) for module, path in MODULES.items() if module != "__init__"}  # it gives the names
    rooms = {module: names for module, names in taken.items() if names or not module.endswith(".__init__")}
    wrong = {module: _wrong_imports(module, names) for module, names in rooms.items()}
    assert {module: names for module, names in wrong.items() if names} == {}


def test_every_room_of_the_floors_is_there() -> None:
    rooms = {_room(module) for module in MODULES}
    assert set(FLOOR_OF) == rooms - {None}
    assert sum(map(len, FLOORS)) == len(FLOOR_OF), "a room stands on two floors"


@pytest.mark.parametrize(
    ("module", "taken"),
    [
        ("equations.gap", "diagnosis"),  # upward
        ("engine.leakage", "engine.series"),  # upward inside the engine
        ("engine.series", "engine.projection"),  # sideways
        ("views.log_rows", "intake.units"),  # sideways
        ("intake.readings.rows", "engine.leakage"),  # the intake knows no engine
        ("diagnosis", "intake.readings"),  # and the engine no intake
        ("system.files", "__init__"),  # the public names are for users
    ],
)
def test_an_import_that_leads_up_or_sideways_is_noticed(module: str, taken: str) -> None:
    assert _wrong_imports(module, {taken}) == [taken]


def test_a_module_without_a_floor_is_noticed() -> None:
    with pytest.raises(AssertionError, match="stands on no floor"):
        _wrong_imports("attic", set())


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
    rows = re.findall(r"^\| (`[^|]+) \|", text, re.MULTILINE)
    drawn = [sorted(re.findall(r"`([\w.]+)`", row)) for row in rows]
    assert drawn == [sorted(floor) for floor in FLOORS[:-1]]  # the last is for users alone


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
    assert len(folders & package) > 20
