"""Two jobs side by side on the command line, each a job file or a job of the book."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from atleak.job.file import read_job_file
from atleak.job.parts import job_parts
from atleak.jobs.book import open_book
from atleak.jobs.compared import compare_jobs
from atleak.version import __version__

Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def job_file(run: Run, small_sheet: Callable[..., Path], tmp_path: Path) -> Callable[..., Path]:
    """Writes the job file of one land of the minimal example."""

    def write(name: str, sleeve: float, date: str = "2026-03-02", serial: str = "MADE-UP-1") -> Path:
        record, target = tmp_path / f"{name}.toml", tmp_path / f"{name}.zip"
        text = f'number = "{name}"\ndate = {date}\n[transmission]\nserial = "{serial}"\n'
        record.write_text(text, encoding="utf-8")
        sheet = small_sheet(sleeve)
        status, _, err = run(
            "diagnose", sheet, "--controller", "minimal_example", "--job", record, "--job-file", target
        )
        assert status == 0, err
        return target

    return write


def test_the_json_has_both_sides_by_the_keys_of_a_diagnosis_and_the_changes(run: Run, job_file) -> None:
    before, after = job_file("before", 11.09), job_file("after", 11.04, "2026-03-09")
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


def test_a_job_is_named_by_its_file_or_by_its_id_in_the_book(run: Run, job_file) -> None:
    before, after = job_file("before", 11.09), job_file("after", 11.04, "2026-03-09")
    kept = read_job_file(before)
    id = open_book().save(job_parts(kept.diagnose(), kept.job, kept.case)).id
    _, of_file, _ = run("compare", before, after, "--json", "-")
    status, of_book, err = run("compare", id, after, "--json", "-")
    assert (status, err) == (0, "")
    assert json.loads(of_book)["lands"] == json.loads(of_file)["lands"]
    assert run("jobs", "compare", "before", after, "--json", "-") == (0, of_book, "")  # by its number


def test_the_terminal_says_both_verdicts_and_what_changed(run: Run, job_file, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "160")
    status, out, _ = run("compare", job_file("before", 11.09), job_file("after", 11.04, "2026-03-09"))
    assert status == 0
    assert "Before: ■ replace. After: ▲ watch." in out
    assert "1 of 1 lands that were measured at both visits changed" in out
    assert "−25.0 ± " in out
    assert "share of the pump's flow" in out


def test_the_page_is_written_and_never_over_a_foreign_file(run: Run, job_file, tmp_path: Path) -> None:
    jobs = job_file("before", 11.09), job_file("after", 11.04, "2026-03-09")
    target = tmp_path / "page.pdf"
    assert run("compare", *jobs, "--pdf", target, "--language", "de", "--paper", "letter")[0] == 0
    first = target.read_bytes()
    assert run("compare", *jobs, "--pdf", target, "--language", "de", "--paper", "letter")[0] == 0
    assert target.read_bytes() == first
    target.write_bytes(b"%PDF of somebody else")
    status, _, err = run("compare", *jobs, "--pdf", target)
    assert status == 2
    assert "--force" in err
    assert run("compare", *jobs, "--pdf", target, "--force")[0] == 0
    status, _, err = run("compare", *jobs, "--pdf", jobs[0], "--force")
    assert status == 2
    assert jobs[0].name in err


@pytest.mark.parametrize(
    ("named", "said"),
    [
        ("missing.zip", "missing.zip: there is no such job file"),
        ("0123456789abcdef", "the job book has no such job (found '0123456789abcdef')"),
    ],
)
def test_a_job_that_is_not_there_is_named(run: Run, job_file, named: str, said: str) -> None:
    status, out, err = run("compare", named, job_file("after", 11.04), "--json", "-")
    assert (status, out) == (2, "")
    assert said in err


def test_two_valve_bodies_are_refused(run: Run, job_file, sample_readings: Path, tmp_path: Path) -> None:
    other = tmp_path / "other.zip"
    run("diagnose", sample_readings, "--job-file", other)
    status, out, err = run("compare", job_file("before", 11.09), other, "--json", "-")
    assert (status, out) == (2, "")
    assert "two different valve bodies" in err


def test_records_that_contradict_each_other_are_said(run: Run, job_file) -> None:
    before = job_file("before", 11.09, "2026-03-09", serial="MADE-UP-1")
    after = job_file("after", 11.04, "2026-03-02", serial="made up 2")
    _, out, _ = run("compare", before, after, "--json", "-")
    codes = {message["code"]: message["text"] for message in json.loads(out)["messages"]}
    assert "2026-03-02" in codes["order_of_dates"]
    assert "MADE-UP-1 before, made up 2 after" in codes["other_unit"]


def test_a_result_of_another_version_is_said_with_its_verdict(job_file) -> None:
    before, after = (read_job_file(job_file(name, sleeve)) for name, sleeve in (("before", 11.09), ("after", 11.04)))
    older = replace(before, result={**before.result, "atleak": "0.1.0", "verdict": "watch"})
    said = [message.text for message in compare_jobs(older, after).comparison.messages]
    assert any("given by atleak 0.1.0 and said watch; by this version it is replace" in text for text in said)
