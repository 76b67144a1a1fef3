"""The command line run in this process, and the small files that its tests read."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from atleak import cli

Run = Callable[..., tuple[int, str, str]]
JOB = """
number = "2026-0417"
date = 2026-04-17
technician = "B. Nowak"
[vehicle]
vin = "WVWZZZ1JZXW000001"
mileage_km = 90000
"""


@pytest.fixture(autouse=True)
def home(own_home: Path) -> Path:
    """Keep columns that one test chose from deciding another."""
    return own_home


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Run:
    """Runs the command line here; exit status, standard output, standard error. Faults of the program come through."""
    monkeypatch.setenv("ATLEAK_TRACEBACK", "1")

    def command(*arguments: object) -> tuple[int, str, str]:
        try:
            status = cli.main([str(argument) for argument in arguments])
        except SystemExit as ended:  # argparse, on a fault of usage
            status = int(ended.code or 0)
        out, err = capsys.readouterr()
        assert "Traceback" not in err
        return status, out, err

    return command


@pytest.fixture
def record_of(run: Run) -> Callable[..., dict[str, Any]]:
    """Diagnoses; the record, which stands alone on standard output."""

    def record(*arguments: object) -> dict[str, Any]:
        status, out, err = run("diagnose", *arguments, "--json", "-")
        assert (status, err) == (0, "")
        return json.loads(out)

    return record


@pytest.fixture
def small_sheet(tmp_path: Path) -> Callable[..., Path]:
    """A measuring sheet of one land of the minimal example."""

    def write(sleeve: float = 11.04) -> Path:
        path = tmp_path / "small.csv"
        rows = ["component,part,plane,direction,diameter [mm]"]
        for direction in (0, 90):
            rows += [f"tcc_regulator,spool,1,{direction},11.000", f"tcc_regulator,sleeve,1,{direction},{sleeve:.3f}"]
        path.write_text("\n".join(rows) + "\n", encoding="utf-8")
        return path

    return write


@pytest.fixture
def process() -> Callable[..., subprocess.CompletedProcess[bytes]]:
    """Runs the command line as a process of its own; the keywords are set in its environment."""

    def command(*arguments: object, **environment: str) -> subprocess.CompletedProcess[bytes]:
        return subprocess.run(
            [sys.executable, "-m", "atleak", *map(str, arguments)],
            capture_output=True,
            check=False,
            env={**os.environ, **environment},
        )

    return command


@pytest.fixture
def with_pressure(sample_log: Path, tmp_path: Path) -> Callable[..., Path]:
    """Writes the sample log under another name, each main pressure as a function of the one that stands there."""

    def write(name: str, changed: Callable[[str], str]) -> Path:
        head, *rows = sample_log.read_text(encoding="utf-8").splitlines()
        cells = [row.split(";") for row in rows]
        lines = [";".join([*row[:2], changed(row[2]), *row[3:]]) for row in cells]
        target = tmp_path / name
        target.write_text("\n".join([head, *lines]), encoding="utf-8")
        return target

    return write
