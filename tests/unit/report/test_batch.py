"""Reports of many jobs: one that cannot be read stops none of the others."""

from __future__ import annotations

import json

from atleak.job import batch
from atleak.job.batch import Reported, write_reports
from atleak.job.zip_file import write_job_file
from atleak.measurements.job_card import Job


def test_every_job_gets_its_reports_and_progress_is_told(unmeasured, tmp_path):
    sources = []
    for folder in ("a", "b", "c"):
        (tmp_path / folder).mkdir()
        sources.append(tmp_path / folder / "job.zip")
        sources[-1].write_bytes(write_job_file(unmeasured, Job(number=folder)))
    sources[1].write_bytes(b"no job at all")
    calls: list[tuple[int, int, Reported]] = []
    done = write_reports(
        sources, tmp_path / "out", formats=("pdf", "xlsx", "json"), progress=lambda *each: calls.append(each)
    )
    assert [each[:2] for each in calls] == [(1, 3), (2, 3), (3, 3)]
    assert [each.error is None for each in done] == [True, False, True]
    assert "no sound zip" in str(done[1].error)
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == [
        f"{stem}.{form}" for stem in ("job-3", "job") for form in ("json", "pdf", "xlsx")
    ]
    assert json.loads((tmp_path / "out" / "job.json").read_text(encoding="utf-8"))["verdict"] == "not_measured"
    assert done[2].verdict == "not_measured"


def test_a_fault_of_the_program_in_one_job_stops_no_other(unmeasured, tmp_path, monkeypatch):
    sources = [tmp_path / "first.zip", tmp_path / "second.zip"]
    for source in sources:
        source.write_bytes(write_job_file(unmeasured, Job(number=source.stem)))
    write = batch.write_workbook

    def faulty(diagnosis, job, **options):
        if job.number == "first":
            raise ZeroDivisionError("division by zero")
        return write(diagnosis, job, **options)

    monkeypatch.setattr(batch, "write_workbook", faulty)
    first, second = write_reports(sources, tmp_path / "out", formats=("json", "xlsx"))
    assert str(first.error).startswith("first.zip: unexpected ZeroDivisionError: division by zero")
    assert [path.name for path in first.written] == ["first.json"]
    assert [path.name for path in second.written] == ["second.json", "second.xlsx"]
