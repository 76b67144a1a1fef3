"""The reports of job files."""

from __future__ import annotations

import json
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from atleak.cli.shared import named_job_files
from atleak.common.errors import InputError

Run = Callable[..., tuple[int, str, str]]
RecordOf = Callable[..., dict[str, Any]]


def test_a_job_travels_as_one_file_and_reads_the_same_elsewhere(
    run: Run, sample_readings: Path, sample_log: Path, tmp_path: Path, record_of: RecordOf
) -> None:
    record = tmp_path / "job.toml"
    record.write_text('number = "atleak sample"\n[workshop]\nname = "Werkstatt Łódź"\n', encoding="utf-8")
    bundle = tmp_path / "a-17.zip"
    first = record_of(sample_readings, "--road-test", sample_log, "--job", record, "--job-file", bundle)
    status, out, _ = run("report", bundle, "-o", tmp_path / "reports", "--formats", "json,xlsx")
    assert status == 0
    assert "a-17.json" in out
    again = json.loads((tmp_path / "reports" / "a-17.json").read_text(encoding="utf-8"))
    assert again["lands"] == first["lands"]
    assert again["road_test"] == first["road_test"]
    assert (tmp_path / "reports" / "a-17.xlsx").stat().st_size > 10_000


def test_one_bad_job_does_not_stop_the_others(run: Run, sample_readings: Path, tmp_path: Path) -> None:
    good, bad = tmp_path / "good.zip", tmp_path / "bad.zip"
    run("diagnose", sample_readings, "--job-file", good)
    bad.write_bytes(b"PK nothing")
    status, _, err = run("report", bad, good, "-o", tmp_path / "out", "--formats", "json")
    assert status == 2
    assert "bad.zip" in err
    assert (tmp_path / "out" / "good.json").is_file()


def test_a_folder_and_a_pattern_name_the_job_files_in_them(
    run: Run, small_sheet: Callable[..., Path], tmp_path: Path
) -> None:
    jobs = tmp_path / "jobs"
    jobs.mkdir()
    for name in ("one.zip", "two.zip", "other.zip"):
        status, _, _ = run("diagnose", small_sheet(), "--controller", "minimal_example", "--job-file", jobs / name)
        assert status == 0
    status, out, _ = run("report", jobs / "[ot][nw]*.zip", "-o", tmp_path / "some", "--formats", "json")
    assert (status, sorted(path.name for path in (tmp_path / "some").iterdir())) == (0, ["one.json", "two.json"])
    status, out, _ = run("report", jobs, "-o", tmp_path / "all", "--formats", "json")
    assert (status, out.count("written:")) == (0, 3)
    status, _, err = run("report", tmp_path / "some", "-o", tmp_path / "none", "--formats", "json")
    assert status == 2
    assert "no job file is there" in err


def test_a_pattern_names_job_files_alone(tmp_path: Path) -> None:
    (tmp_path / "folder.zip").mkdir()
    for name in ("one.zip", "two.ZIP", "notes.txt"):
        (tmp_path / name).write_text("", encoding="utf-8")
    assert [path.name for path in named_job_files([str(tmp_path / "*")])] == ["one.zip", "two.ZIP"]
    for name in ("f*", "n*.txt", "missing*.zip"):
        with pytest.raises(InputError, match="no job file is there"):
            named_job_files([str(tmp_path / "one.zip"), str(tmp_path / name)])


def test_unknown_report_format_is_refused(run: Run, tmp_path: Path) -> None:
    status, _, err = run("report", tmp_path / "x.zip", "-o", tmp_path, "--formats", "docx")
    assert status == 2
    assert "'docx' is not one of pdf, xlsx, json" in err


def test_what_is_doubtful_about_a_job_is_said_beside_its_reports(
    run: Run, small_sheet: Callable[..., Path], tmp_path: Path
) -> None:
    record, bundle = tmp_path / "job.toml", tmp_path / "job.zip"
    record.write_text('[[scratches]]\ncomponent = "77"\n[[instruments]]\nname = "air gauge"\n', encoding="utf-8")
    _, _, err = run("diagnose", small_sheet(), "--controller", "minimal_example", "--job", record, "--job-file", bundle)
    assert "[scratches 1]" in err
    assert "the uncertainty of the sleeves is computed with Two-point bore gauge" in err
    with zipfile.ZipFile(bundle) as whole:
        entries = {name: whole.read(name) for name in whole.namelist()}
    result = json.loads(entries["result.json"])
    entries["result.json"] = json.dumps({**result, "verdict": "ok", "atleak": "0.1.0"}).encode()
    with zipfile.ZipFile(bundle, "w") as changed:
        for name, content in entries.items():
            changed.writestr(name, content)
    status, _, err = run("report", bundle, "-o", tmp_path / "out", "--formats", "json")
    assert status == 0
    assert "[scratches 1]" in err
    assert "job.zip: differs from its result, made by atleak 0.1.0:\n  the unit: ok" in err
