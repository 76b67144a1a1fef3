"""Two jobs side by side on the command line, each a job file or a job of the book."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from atleak.job.case import Case, SourceFile
from atleak.job.parts import job_parts
from atleak.job.zip_file import read_job_file, write_job_file
from atleak.job_book.book import open_book
from atleak.job_book.compared_jobs import compare_jobs
from atleak.measurements.job_card import Job, Transmission
from atleak.version import __version__

Run = Callable[..., tuple[int, str, str]]


def written(folder: Path, name: str, case: Case, date: str = "2026-03-02", serial: str = "MADE-UP-1") -> Path:
    record = Job(number=name, date=date, transmission={"serial": serial})
    path = folder / f"{name}.zip"
    path.write_bytes(write_job_file(case.diagnose(), record, case))
    return path


@pytest.fixture(scope="module")
def jobs(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """Two visits of a unit of which one land was measured, 45 µm before and 20 µm after, as job files."""
    folder, head = tmp_path_factory.mktemp("jobs"), "component;part;plane;direction;diameter [mm]"
    paths = []
    for name, sleeve, date in (("before", "11,09", "2026-03-02"), ("after", "11,04", "2026-03-09")):
        rows = [
            f"tcc_regulator;{part};1;{at};{size}"
            for part, size in (("spool", "11"), ("sleeve", sleeve))
            for at in (0, 90)
        ]
        sheet = SourceFile(f"{name}.csv", "\n".join([head, *rows]).encode())
        paths.append(written(folder, name, Case(readings=sheet, controller="minimal_example"), date))
    return paths[0], paths[1]


def test_the_json_has_both_sides_by_the_keys_of_a_diagnosis_and_the_changes(run: Run, jobs: tuple[Path, Path]) -> None:
    before, after = jobs
    status, out, err = run("compare", before, after, "--json", "-")
    assert (status, err) == (0, "")
    record = json.loads(out)
    assert (record["format"], record["atleak"]) == (1, __version__)
    assert [record[side]["job"]["number"] for side in ("before", "after")] == ["before", "after"]
    lands = {(land["component"], land["land"]): land for land in record["lands"]}
    regulator, accumulator = lands["tcc_regulator", 1], lands["accumulator", 1]
    for side, diagnosed in (("before", before), ("after", after)):
        result = read_job_file(diagnosed).result
        same = next(land for land in result["lands"] if land["component"] == "tcc_regulator")
        assert regulator[side] == same
        assert [each[side] for each in record["conditions"]] == result["conditions"]
        assert record[side]["unit"] == result["unit"]
    assert regulator["change_um"] == pytest.approx(-25.0, abs=1e-6)
    us = [regulator[side]["uncertainty_um"] for side in ("before", "after")]
    assert regulator["change_u_um"] == pytest.approx((us[0] ** 2 + us[1] ** 2) ** 0.5, abs=1e-9)
    assert regulator["significant"] is True
    assert [accumulator[key] for key in ("change_um", "change_u_um", "significant")] == [None, None, None]
    assert all(each["share_change_percent"] < 0.0 and each["share_significant"] for each in record["conditions"])


def test_a_job_is_named_by_its_file_or_by_its_id_in_the_book(run: Run, jobs: tuple[Path, Path]) -> None:
    before, after = jobs
    kept = read_job_file(before)
    id = open_book().save(job_parts(kept.diagnose(), kept.job, kept.case)).id
    _, of_file, _ = run("compare", before, after, "--json", "-")
    status, of_book, err = run("compare", id, after, "--json", "-")
    assert (status, err) == (0, "")
    assert json.loads(of_book)["lands"] == json.loads(of_file)["lands"]
    assert run("jobs", "compare", "before", after, "--json", "-") == (0, of_book, "")  # by its number


def test_the_terminal_says_both_verdicts_and_what_changed(run: Run, jobs, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "160")
    status, out, _ = run("compare", *jobs)
    assert status == 0
    assert "Before: ■ replace. After: ▲ watch." in out
    assert "1 of 1 lands that were measured at both visits changed" in out
    assert "−25.0 ± " in out
    assert "share of the pump's flow" in out


def test_the_terminal_speaks_the_language_and_units_that_are_asked_for(run: Run, jobs, monkeypatch) -> None:
    monkeypatch.setenv("COLUMNS", "160")
    status, out, err = run("compare", *jobs, "--language", "de", "--units", "us")
    assert (status, err) == (0, "")
    assert "Vorher: ■ ersetzen. Nachher: ▲ beobachten." in out
    assert "Vorher [0.0001 in]" in out
    assert "−9,8" in out  # 25 µm


def test_the_terminal_puts_the_road_tests_beside_one_another(
    run: Run, jobs: tuple[Path, Path], sample_log: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "160")
    job = written(tmp_path, "driven", Case(controller="minimal_example", road_test=SourceFile.at(sample_log)))
    status, out, _ = run("compare", job, job)
    assert status == 0
    (row,) = (line for line in out.splitlines() if "minimum-acceleration test" in line)
    assert "0.3 → 0.3" in row
    out = run("compare", job, jobs[1], "--language", "de")[1]
    assert "· Der Auftrag nachher hat keine Probefahrt" in out


def test_the_page_is_written_and_never_over_a_foreign_file(run: Run, jobs: tuple[Path, Path], tmp_path: Path) -> None:
    target = tmp_path / "page.pdf"
    assert run("compare", *jobs, "--pdf", target, "--language", "de", "--paper", "letter")[0] == 0
    assert target.read_bytes().startswith(b"%PDF")
    target.write_bytes(b"%PDF of somebody else")
    status, _, err = run("compare", *jobs, "--pdf", target)
    assert status == 2
    assert "--force" in err
    status, _, err = run("compare", *jobs, "--pdf", jobs[0], "--force")
    assert status == 2
    assert jobs[0].name in err
    assert run("compare", *jobs, "--pdf", "-")[0] == 2


@pytest.mark.parametrize(
    ("named", "said"),
    [
        ("missing.zip", "missing.zip: there is no such job file"),
        ("0123456789abcdef", "the job book has no such job (found '0123456789abcdef')"),
    ],
)
def test_a_job_that_is_not_there_is_named(run: Run, jobs: tuple[Path, Path], named: str, said: str) -> None:
    status, out, err = run("compare", named, jobs[1], "--json", "-")
    assert (status, out) == (2, "")
    assert said in err


def test_two_valve_bodies_are_refused(run: Run, jobs: tuple[Path, Path], root: Path, tmp_path: Path) -> None:
    other = written(tmp_path, "other", Case(controller=SourceFile.at(root / "tests" / "three_circuits.toml")))
    status, out, err = run("compare", jobs[0], other, "--json", "-")
    assert (status, out) == (2, "")
    assert "two different valve bodies" in err


def test_records_and_results_that_say_something_else_are_named(jobs: tuple[Path, Path]) -> None:
    after, before = map(read_job_file, jobs)  # the wrong way round
    older = {**after.result, "atleak": "0.1.0", "verdict": "watch"}
    other = after.job.model_copy(update={"transmission": Transmission(serial="made up 2")})
    found = compare_jobs(before, replace(after, result=older, job=other))
    said = {message.code: message.text for message in found.comparison.messages}
    assert "2026-03-02" in said["order_of_dates"]
    assert "MADE-UP-1 before, made up 2 after" in said["other_unit"]
    assert "given by atleak 0.1.0 and said watch; by this version it is replace" in said["other_version"]
