"""The sheet as it was measured: its temperature, and pairs that cannot be as tight as they read."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from atleak.catalogue.controller import Controller
from atleak.catalogue.entries import catalogue_files

Run = Callable[..., tuple[int, str, str]]
RecordOf = Callable[..., dict[str, Any]]
SmallSheet = Callable[..., Path]


def _of(record: dict[str, Any], component: str, land: int) -> dict[str, Any]:
    return next(each for each in record["lands"] if (each["component"], each["land"]) == (component, land))


def test_at_35_degrees_a_pair_of_the_sample_is_worn_by_less_than_a_tenth(
    sample_readings: Path, record_of: RecordOf, tmp_path: Path
) -> None:
    cold = record_of(sample_readings)
    assert cold["readings"]["measuring_temperature_c"] == 20.0
    assert cold["readings"]["measuring_temperature_assumed"] is True
    job = tmp_path / "job.toml"
    job.write_text("measuring_temperature_c = 35", encoding="utf-8")
    warm = record_of(sample_readings, "--measuring-temperature", "35,0 °C")
    assert warm["readings"]["measuring_temperature_c"] == 35.0
    assert warm["readings"]["measuring_temperature_assumed"] is False
    assert _of(cold, "23", 1)["wear_percent"] == pytest.approx(10.849, abs=0.001)
    assert _of(warm, "23", 1)["wear_percent"] == pytest.approx(7.938, abs=0.001)
    assert record_of(sample_readings, "--job", job)["lands"] == warm["lands"]
    given = record_of(sample_readings, "--job", job, "--measuring-temperature", "20")
    assert given["lands"] == cold["lands"]
    assert given["readings"]["measuring_temperature_assumed"] is False


def test_the_pump_s_clearances_are_options_with_their_unit_or_stand_in_the_job_record(
    record_of: RecordOf, tmp_path: Path, sample_readings: Path
) -> None:
    unit, job = tmp_path / "unit.toml", tmp_path / "job.toml"
    text = Path(catalogue_files("controllers")["four_speed_2023"]).read_text(encoding="utf-8")
    lands = "kind = 'crescent'\nroot_diameter_mm = 42.0\nshaft_diameter_mm = 32.0\nring_root_diameter_mm = 70.0\n"
    lands += "ring_outer_diameter_mm = 82.0\nside_clearance_um = 35.0\n"
    unit.write_text(text.replace("[pump]\n", f"[pump]\n{lands}", 1), encoding="utf-8")
    job.write_text("pump_side_clearance_um = 76.2", encoding="utf-8")
    record = record_of(sample_readings, "--controller", unit, "--job", job, "--pump-tip-clearance", "0.006in")
    pump, idle = record["pump"], record["hot_idle"]
    assert (pump["side_clearance_measured_um"], pump["tip_clearance_measured_um"]) == (76.2, 152.4)
    assert idle["pump_slip_dm3_min"] > idle["pump_slip_new_dm3_min"] > 0.0
    (left_out,) = [each["text"] for each in record["messages"] if each["code"] == "pump_clearance_left_out"]
    assert "does not state tip_land_mm, sealing_tips" in left_out


def test_the_limits_of_earlier_versions_called_that_pair_watch_only_when_it_was_warm(
    sample_readings: Path, record_of: RecordOf, tmp_path: Path
) -> None:
    limits = tmp_path / "limits.toml"
    text = Path(catalogue_files("limits")["project_default"]).read_text(encoding="utf-8")
    head = "[wear_percent]\nwatch = "
    assert head in text
    start = text.index(head) + len(head)
    limits.write_text(text[:start] + "10.0" + text[text.index("\n", start) :], encoding="utf-8")
    for more, verdict in (([], "watch"), (["--measuring-temperature", 35], "ok")):
        record = record_of(sample_readings, "--limits", limits, *more)
        assert _of(record, "23", 1)["verdict"] == verdict


def test_the_terminal_says_at_which_temperature(run: Run, sample_readings: Path) -> None:
    for more, said in (([], "assumed 20 °C"), (["--measuring-temperature", 35], "35 °C, diameters corrected to 20 °C")):
        status, out, _ = run("diagnose", sample_readings, *more)
        assert status == 0
        assert f"temperature of measuring: {said}" in " ".join(out.split())


@pytest.mark.parametrize("value", ["350", "warm", "-40"])
def test_a_temperature_at_which_nobody_measures_is_refused(run: Run, sample_readings: Path, value: str) -> None:
    status, out, err = run("diagnose", sample_readings, f"--measuring-temperature={value}")
    assert (status, out) == (2, "")
    assert "measuring temperature" in err


def test_the_job_goes_before_the_head_of_the_sheet_and_says_so(
    small_sheet: SmallSheet, record_of: RecordOf, tmp_path: Path
) -> None:
    sheet = small_sheet()
    text = sheet.read_text(encoding="utf-8")
    delimiter = next(sign for sign in ";,\t" if sign in text.splitlines()[0])
    sheet.write_text(f"Temperature{delimiter}23 °C\n\n{text}", encoding="utf-8")
    options = (sheet, "--controller", "minimal_example")
    record = record_of(*options)
    assert record["readings"]["measuring_temperature_c"] == 23.0
    assert "measuring_temperature_differs" not in {message["code"] for message in record["messages"]}
    record = record_of(*options, "--measuring-temperature", "35")
    assert record["readings"]["measuring_temperature_c"] == 35.0
    (message,) = [each for each in record["messages"] if each["code"] == "measuring_temperature_differs"]
    assert (message["level"], message["place"]["file"]) == ("warning", sheet.name)
    assert "23 °C, the job 35 °C: the job's is taken" in message["text"]


def test_pairs_tighter_than_new_are_suspect_and_not_passed(
    four_speed: Controller, record_of: RecordOf, tmp_path: Path
) -> None:
    rows = ["component;part;plane;direction;repeat;diameter [mm]"]
    for land in four_speed.lands:
        spool = land.nominal_diameter * 1e3
        for part, diameter in (("spool", spool), ("sleeve", spool + 2e3 * 0.52 * land.new_clearance)):
            rows += [f"{land.component};{part};{land.land};{angle};1;{diameter:.3f}" for angle in (0, 90)]
    sheet = tmp_path / "tight.csv"
    sheet.write_text("\n".join(rows), encoding="utf-8")
    record = record_of(sheet)
    assert all(land["suspect"] and land["decision"] == "conditional_pass" for land in record["lands"])
    assert (record["verdict"], record["unit"]["decision"]) == ("watch", "conditional_pass")
    assert record["unit"]["decided_by"]["kind"] == "readings"
    (message,) = [each for each in record["messages"] if each["code"] == "tighter_than_new"]
    assert message["level"] == "warning"
    assert all(f"{land.component}/{land.land}" in message["text"] for land in four_speed.lands)
    assert message["place"] == {"file": "tight.csv", "row": 2, "column": "diameter [mm]"}
