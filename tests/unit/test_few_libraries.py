"""Engine, catalogue and ``diagnose --json`` need numpy, pandas and pydantic alone; what needs more says what."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]

#: The three, and what they bring themselves. Everything else that is installed is not found.
FEW = """
import importlib.abc, sys
FEW = {"numpy", "pandas", "pydantic", "pydantic_core", "annotated_types", "typing_extensions", "typing_inspection"}
FEW |= {"dateutil", "pytz", "tzdata", "six", "atleak"}

class Blocked(importlib.abc.MetaPathFinder):
    def find_spec(self, name, path=None, target=None):
        top = name.partition(".")[0]
        if top not in FEW | sys.stdlib_module_names and not top.startswith("_"):
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)

sys.meta_path.insert(0, Blocked())
"""


def few(code: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Run code in a process that has few libraries."""
    command = [sys.executable, "-c", FEW + code, *arguments]
    environment = {name: value for name, value in os.environ.items() if name != "ATLEAK_TRACEBACK"}
    return subprocess.run(command, capture_output=True, encoding="utf-8", cwd=ROOT, env=environment, check=False)


COMMAND = "from atleak.cli import main; sys.exit(main())"


@pytest.fixture
def sheet(tmp_path: Path) -> Path:
    """One land of the four-speed, worn."""
    rows = ["component;part;plane;direction;repeat;diameter [mm]"]
    diameters = {"spool": 13.999, "sleeve": 14.119}
    rows += [f"25;{part};1;{angle};1;{size}" for part, size in diameters.items() for angle in (0, 90)]
    path = tmp_path / "sheet.csv"
    path.write_text("\n".join(rows), encoding="utf-8")
    return path


def test_a_diagnosis_as_json_needs_few_libraries(sheet: Path) -> None:
    log = ROOT / "sample_data" / "minimum_acceleration_test.csv"
    done = few(COMMAND, "diagnose", str(sheet), "--road-test", str(log), "--json", "-")
    assert done.returncode == 0, done.stderr
    record = json.loads(done.stdout)
    assert record["readings"]["lands_measured"] == 1
    assert record["road_test"]["rows"] == 1201
    assert record["verdict"] in ("replace", "critical")


def test_the_engine_as_a_library_needs_few_libraries(sheet: Path) -> None:
    code = """
import atleak
unit = atleak.load("five_speed_2005")
frame = unit.with_clearance("manual_valve/3", um=40).sweep("hot_idle", temperature_c=[60, 120])
print(frame["leakage_dm3_min"].is_monotonic_increasing)
four = atleak.load("four_speed_2023")
sheet = atleak.read_readings(sys.argv[1], four.controller)
diagnosis = atleak.diagnose(four.controller, None, atleak.load_limits("project_default"), readings=sheet)
print(len(diagnosis.to_frame()), "<svg" in diagnosis._repr_html_())
"""
    done = few(code, str(sheet))
    assert done.stdout.split() == ["True", "47", "True"], done.stderr


@pytest.mark.parametrize(
    ("arguments", "library"),
    [
        (("diagnose", "SHEET"), "rich"),
        (("diagnose", "SHEET", "--quiet", "--xlsx", "OUT"), "xlsxwriter"),
        (("diagnose", str(ROOT / "sample_data" / "measuring_sheet_four_speed.xlsx"), "--json", "-"), "psutil"),
        (("jobs", "list"), "sqlalchemy"),
        (("app",), "streamlit"),
    ],
)
def test_what_needs_another_library_says_which(
    arguments: tuple[str, ...], library: str, sheet: Path, tmp_path: Path
) -> None:
    given = [{"SHEET": str(sheet), "OUT": str(tmp_path / "out.xlsx")}.get(each, each) for each in arguments]
    done = few(COMMAND, *given)
    assert done.returncode == 2
    assert done.stderr.splitlines()[-1] == f"atleak: this needs the library {library}, which is not installed"
    assert not (tmp_path / "out.xlsx").exists()
