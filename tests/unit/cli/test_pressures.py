"""``atleak diagnose --pressures``: alone, beside a sheet, and what is refused."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def gauges(tmp_path: Path) -> Path:
    path = tmp_path / "gauges.csv"
    path.write_text("Fahrstufe;Leerlauf [bar];Festbremsdrehzahl [bar]\nD;3,9;11\n1;2,9;\n", encoding="utf-8")
    return path


def test_a_table_alone_is_diagnosed_and_decides(run: Run, record_of, gauges: Path) -> None:
    status, out, err = run("diagnose", "--pressures", gauges)
    assert (status, err) == (0, "")
    assert (
        "unit: ✖ critical (provisional), decided by the main pressure below the permissible, 1, slow idle"
        in " ".join(out.split())
    )
    record = record_of("--pressures", gauges)
    assert record["verdict"] == record["pressure_table"]["verdict"] == "critical"
    decided_by = record["unit"]["decided_by"]
    assert (decided_by["kind"], decided_by["where"]) == ("permissible_pressure", "1, slow idle")
    assert [reading["pressure_kpa"] for reading in record["pressure_table"]["readings"]] == [390.0, 1100.0, 290.0]
    assert run("diagnose", "--pressures", gauges, "--fail-on", "critical")[0] == 1


def test_the_terminal_names_the_unit_of_its_pressures(run: Run, gauges: Path) -> None:
    out = run("diagnose", "--pressures", gauges)[1]
    readings, split = out.split("Missing pressure, split by cause")
    assert readings.count("[kPa]") == 3, "gauge, permitted, expected or when new"
    assert split.count("[kPa]") >= 3, "measured, when new, missing"


def test_a_table_stands_beside_a_measuring_sheet(record_of, sample_readings: Path, gauges: Path) -> None:
    record = record_of(sample_readings, "--pressures", gauges)
    assert record["readings"]["lands_measured"] == 47
    assert record["pressure_table"]["sha256"]
    assert record_of(sample_readings)["pressure_table"] is None


def test_a_bad_table_exits_2_with_its_place(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "bad.csv"
    path.write_text("range,slow idle [kPa]\nD,x4\n", encoding="utf-8")
    status, out, err = run("diagnose", "--pressures", path)
    assert (status, out) == (2, "")
    assert "bad.csv, row 2, column slow idle [kPa]: D, slow idle: not a pressure (found 'x4')" in err


def test_nothing_at_all_is_refused(run: Run) -> None:
    status, _, err = run("diagnose")
    assert status == 2
    assert "--pressures FILE" in err


def test_the_table_is_not_written_over(run: Run, gauges: Path) -> None:
    before = gauges.read_bytes()
    assert run("diagnose", "--pressures", gauges, "--json", gauges)[0] == 2
    assert gauges.read_bytes() == before
