"""A road test alone is a job: its main pressure, events and gears are findings, and nothing unmeasured is green."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from atleak.job.zip_file import read_job_file
from atleak.report.json.diagnosis import diagnosis_record

Run = Callable[..., tuple[int, str, str]]
WithPressure = Callable[..., Path]


def test_neither_sheet_nor_log_is_refused(run: Run) -> None:
    status, out, err = run("diagnose", "--json", "-")
    assert (status, out) == (2, "")
    said = " ".join(err.split())
    assert "no measuring sheet, road test, gauge readings, vacuum test or flows are given; expected READINGS" in said
    assert "usage: atleak diagnose" in said


def test_a_road_test_alone_is_judged_by_its_main_pressure(run: Run, sample_log: Path) -> None:
    status, out, _ = run("diagnose", "--road-test", sample_log, "--fail-on", "watch")
    said = " ".join(out.split())
    assert status == 0
    assert "No measuring sheet was given and no land was measured." in said
    assert "unit: ● ok (provisional), by the main pressure of the log alone" in said
    assert "green" not in said
    assert "Order of repair" not in said


@pytest.mark.parametrize("with_sheet", [True, False])
def test_a_log_of_two_fifths_of_the_pressure_is_critical_because_of_it(
    run: Run, sample_readings: Path, with_pressure: WithPressure, tmp_path: Path, with_sheet: bool
) -> None:
    low = with_pressure("low.csv", lambda kpa: f"{0.4 * float(kpa):.3f}")
    record_file = tmp_path / "result.json"
    sheet = (sample_readings,) if with_sheet else ()
    options = ("--road-test", low, "--fail-on", "critical", "--json", record_file)
    status, out, _ = run("diagnose", *sheet, *options)
    said = " ".join(out.split())
    assert status == 1
    assert (
        "unit: ✖ critical (provisional), decided by the main pressure below the permissible, gear 4, driving, at 11.0 s"
        in said
    )
    record = json.loads(record_file.read_text(encoding="utf-8"))
    assert record["verdict"] == record["unit"]["verdict"] == "critical"
    assert record["unit"]["decision"] == "fail"
    assert record["unit"]["decided_by"]["kind"] == "permissible_pressure"
    of_log = record["road_test"]["permissible_pressure"]
    assert of_log["verdict"] == "critical"
    assert of_log["below_s"] == of_log["judged_s"] == pytest.approx(11.94, abs=0.05)
    assert of_log["worst_below_kpa"] == pytest.approx(412.0 - 252.94, abs=0.1)
    assert record["road_test"]["leakage_as_new"] is not with_sheet


def test_a_log_without_main_pressure_is_a_job_alone(run: Run, sample_log: Path, tmp_path: Path) -> None:
    log, record_file = tmp_path / "phone.csv", tmp_path / "result.json"
    rows = [row.split(";") for row in sample_log.read_text(encoding="utf-8").splitlines()]
    log.write_text("\n".join(";".join([*row[:2], *row[4:]]) for row in rows), encoding="utf-8")
    outputs = ("--json", record_file, "--pdf", tmp_path / "a.pdf", "--xlsx", tmp_path / "a.xlsx")
    status, out, _ = run("diagnose", "--road-test", log, *outputs, "--job-file", tmp_path / "a.zip")
    assert status == 0
    assert "unit: ○ not measured" in out
    assert "Gauge it at the main pressure tap in P R N D 3 2 1" in " ".join(out.split())
    record = json.loads(record_file.read_text(encoding="utf-8"))
    road = record["road_test"]
    unit = record["unit"]
    assert (unit["verdict"], unit["decision"], unit["decided_by"]) == ("not_measured", None, None)
    assert (unit["provisional"], unit["provisional_because"]) == (False, [])
    assert (road["permissible_pressure"], road["permissible_pressure_not_judged"]) == (None, "no_main_pressure")
    assert road["max_leakage"] is road["max_share"] is None
    assert road["gears"] == [1, 2, 3, 4]
    assert (road["temperature_low_c"], road["temperature_high_c"]) == (79.8, 80.2)
    assert [event["kind"] for event in road["events"]].count("gear_shift") == 3
    (test,) = (event["test"] for event in road["events"] if event["test"])
    assert test["fault"] is None
    assert {condition["band"] for condition in record["conditions"]} == {None}
    assert not record["repair_plan_ends"]["reached"]
    again = read_job_file(tmp_path / "a.zip").diagnose()
    assert diagnosis_record(again)["road_test"] == road


def test_a_scan_tool_s_log_is_worth_its_slip_and_an_estimate_of_leakage(
    run: Run, sample_log: Path, tmp_path: Path
) -> None:
    log, record_file = tmp_path / "scan.csv", tmp_path / "result.json"
    rows = [row.split(";") for row in sample_log.read_text(encoding="utf-8").splitlines()[1::10]]
    head = "engine_speed [rpm];turbine speed [rpm];atf_temperature [°C];gear"
    body = [f"{cells[1]};{float(cells[1]) - 90};{cells[4]};{cells[5]}" for cells in rows]
    log.write_text("\n".join([head, *body]) + "\n", encoding="utf-8")
    options = ("--interval", "0,1", "--constant", "main_pressure=operating-points", "--json", record_file)
    status, out, _ = run("diagnose", "--road-test", log, *options, "--job-file", tmp_path / "a.zip")
    assert status == 0
    said = " ".join(out.split())
    assert "Converter slip (engine minus turbine speed) while driving: 90 rpm in the middle" in said
    assert "Main pressure is not logged: that of the valve body's operating points is assumed" in said
    record = json.loads(record_file.read_text(encoding="utf-8"))
    road = record["road_test"]
    assert road["converter_slip"]["median_rpm"] == pytest.approx(90, abs=1e-6)
    assert (road["permissible_pressure_not_judged"], road["leakage_as_new"]) == ("not_measured", True)
    assert road["max_leakage_sustained"]["leakage_dm3_min"] > 0.0
    assert road["duration_s"] == pytest.approx(12.0, abs=0.05)
    again = read_job_file(tmp_path / "a.zip").diagnose()
    assert diagnosis_record(again)["road_test"] == road
