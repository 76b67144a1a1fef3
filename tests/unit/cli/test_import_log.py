"""What is understood of a log."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path

import pytest

from atleak.readers.logs import columns as assign
from atleak.readers.logs import importer
from atleak.readers.logs.columns import BESIDE

Run = Callable[..., tuple[int, str, str]]


def test_import_log_writes_the_record_alone(run: Run, sample_log: Path, tmp_path: Path) -> None:
    status, out, err = run("import-log", sample_log, "--json", "-", "--csv", tmp_path / "plain.csv")
    assert (status, err) == (0, "")
    record = json.loads(out)
    promised = (
        "file sha256 format encoding delimiter decimal rows duration_s segments columns ambiguous unused messages"
    )
    assert [key for key in promised.split() if key not in record] == []
    quantities = {column["quantity"] for column in record["columns"]}
    assert quantities == {"time", "engine_speed", "main_pressure", "converter_pressure", "atf_temperature", "gear"}
    assert (tmp_path / "plain.csv").stat().st_size > 1000


def test_import_log_never_writes_over_the_log(run: Run, sample_log: Path, tmp_path: Path) -> None:
    log = tmp_path / "log.csv"
    log.write_bytes(sample_log.read_bytes())
    for options in (["--csv", log], ["--json", log], ["--json", "-", "--csv", "-"]):
        status, out, err = run("import-log", log, *options)
        assert (status, out) == (2, "")
        assert "would be written over" in err
    assert log.read_bytes() == sample_log.read_bytes()


def test_a_home_that_cannot_be_written_is_no_failure(
    run: Run, sample_log: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("", encoding="utf-8")
    monkeypatch.setenv("ATLEAK_HOME", str(tmp_path / "file"))
    status, out, err = run("import-log", sample_log, "--unit", "engine_speed=rpm")
    assert status == 0
    assert "1201 rows" in out
    assert "not remembered" in err


def test_columns_are_shared_by_a_file_and_forgotten(run: Run, tmp_path: Path) -> None:
    log, file = tmp_path / "log.csv", tmp_path / "map.json"
    log.write_text("t;a;b\n" + "".join(f"{n / 2};{900 + n};{500 + n}\n" for n in range(40)), encoding="utf-8")
    named = ("--map", "time=t", "--map", "engine_speed=a", "--map", "main_pressure=b", "--unit", "main_pressure=kPa")
    assert run("import-log", log, *named, "--map-file", file)[0] == 0
    content = json.loads(file.read_text(encoding="utf-8"))
    assert {"name": "b", "type": "any", "atleak:roles": ["main_pressure"]} in content["schema"]["fields"]

    def pressure(*options: object) -> float | None:
        record = json.loads(run("import-log", log, *options, "--json", "-")[1] or "{}")
        return next((each["max"] for each in record.get("columns", ()) if each["quantity"] == "main_pressure"), None)

    assert pressure() == 539.0  # remembered
    assert pressure("--forget") is None
    assert pressure() is None
    assert pressure("--map-file", file) == 539.0
    status, _, err = run("import-log", log, "--map", "component=a")
    assert status == 2
    assert "no quantity of a log" in err


def test_the_table_shows_every_number_in_the_unit_beside_it(run: Run, tmp_path: Path) -> None:
    log = tmp_path / "imperial.csv"
    rows = "".join(f"{i * 500};{700 + i};{140 + i};{57 + i / 10};{i}\n" for i in range(40))
    log.write_text("Time (ms);RPM (rpm);Trans Fluid Temp (F);Line Pressure (psi);Vehicle Speed (mph)\n" + rows)
    _, out, _ = run("import-log", log)
    cells = [[cell.strip() for cell in line.split("│")[1:-1]] for line in out.splitlines() if line.count("│") > 6]
    shown = {row[0]: (row[2], row[4], row[5]) for row in cells if row[0]}
    assert shown["time"] == ("ms", "0", "19500")
    assert shown["atf_temperature"] == ("°F", "140", "179")
    assert shown["main_pressure"] == ("psi", "57", "60.9")
    assert shown["vehicle_speed"] == ("mph", "0", "39")
    _, out, _ = run("import-log", log, "--json", "-")
    record = {column["quantity"]: column["max"] for column in json.loads(out)["columns"]}
    assert record["time"] == pytest.approx(19.5, rel=1e-9, abs=0.0)
    assert record["atf_temperature"] == pytest.approx((179 - 32) / 1.8, rel=1e-9, abs=0.0)


def test_one_row_in_some_is_read_and_that_is_said(run: Run, sample_log: Path) -> None:
    _, out, _ = run("import-log", sample_log, "--json", "-")
    status, some, _ = run("import-log", sample_log, "--every", "7", "--json", "-")
    assert status == 0
    assert json.loads(some)["rows"] == -(-json.loads(out)["rows"] // 7)
    assert "only one row in 7 of the log is read" in {each["text"] for each in json.loads(some)["messages"]}
    for wrong in ("0", "-1", "2.5", "x"):
        status, _, err = run("import-log", sample_log, f"--every={wrong}")
        assert (status, "is no whole number above 0" in err) == (2, True)


def test_a_log_that_does_not_fit_exits_with_what_to_do(
    run: Run, sample_log: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(assign, "SMALL", 1)
    monkeypatch.setattr(importer, "free_memory", lambda: BESIDE + 60_000)
    status, _, err = run("diagnose", "--road-test", sample_log)
    assert status == 2
    every = re.search(r"would take .* GB of memory .* one row in (\d+): --every \1", " ".join(err.split()))
    assert every is not None
    assert run("diagnose", "--road-test", sample_log, "--every", every[1])[0] == 0
