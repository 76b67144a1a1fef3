"""The sample is reached without a checkout: by its name, and as files in a folder of one's own."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

Run = Callable[..., tuple[int, str, str]]


def test_sample_is_the_shipped_sheet_and_log(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, sample_readings: Path, sample_log: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "sample").mkdir()  # a folder is no measuring sheet
    status, out, _ = run("diagnose", "sample", "--road-test", "sample", "--json", "-")
    assert status == 0
    named = run("diagnose", sample_readings, "--road-test", sample_log, "--json", "-")[1]
    assert json.loads(out)["lands"] == json.loads(named)["lands"]
    assert json.loads(out)["readings"]["file"] == sample_readings.name
    assert run("import-log", "sample", "--json", "-") == run("import-log", sample_log, "--json", "-")


def test_a_file_of_that_name_in_the_folder_wins(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, sample_log: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "sample").write_text("Valve;Land;Part;Diameter [mm]\naccumulator;1;spool;17.998\n", encoding="utf-8")
    status, out, _ = run("diagnose", "sample", "--controller", "minimal_example", "--json", "-")
    assert status == 0
    assert json.loads(out)["readings"]["file"] == "sample"
    shutil.copy(sample_log, tmp_path / "sample")
    assert json.loads(run("import-log", "sample", "--json", "-")[1])["file"] == "sample"


def test_the_sample_files_are_written_into_a_folder_and_over_none_that_is_there(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, sample_readings: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    status, out, _ = run("sample")
    names = sorted(path.name for path in sample_readings.parent.iterdir())
    folder = tmp_path / "sample_data"
    assert (status, sorted(path.name for path in folder.iterdir())) == (0, names)
    assert out.count("written: ") == len(names)
    assert (folder / sample_readings.name).read_bytes() == sample_readings.read_bytes()

    mine = tmp_path / "mine" / "fleet.csv"
    mine.parent.mkdir()
    mine.write_text("my own", encoding="utf-8")
    status, out, err = run("sample", mine.parent)
    assert (status, out) == (2, "")
    assert "fleet.csv: is there already; expected another folder, or --force to write over it" in err
    assert [path.name for path in mine.parent.iterdir()] == ["fleet.csv"]
    assert mine.read_text(encoding="utf-8") == "my own"
    assert run("sample", mine.parent, "--force")[0] == 0
    assert mine.read_bytes() == (sample_readings.parent / "fleet.csv").read_bytes()


def test_a_folder_that_is_a_file_is_named(run: Run, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("", encoding="utf-8")
    status, _, err = run("sample", tmp_path / "file")
    assert status == 2
    assert f"atleak: {tmp_path / 'file'}: " in err
