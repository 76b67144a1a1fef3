"""What the record of a diagnosis says of its job, and the hash by which the result is known."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from pathlib import Path

import pytest

from atleak.version import __version__
from tests.unit.cli.conftest import JOB

Run = Callable[..., tuple[int, str, str]]
MINIMAL = ("--controller", "minimal_example")


@pytest.fixture
def job(tmp_path: Path) -> Path:
    path = tmp_path / "job.toml"
    path.write_text(JOB, encoding="utf-8")
    return path


def test_the_record_says_whose_job_it_is_and_who_measured(
    run: Run, small_sheet: Callable[..., Path], job: Path
) -> None:
    of_job, of_none = (
        json.loads(run("diagnose", small_sheet(), *MINIMAL, *options, "--json", "-")[1])
        for options in (("--job", job), ("--mileage", "90000"))
    )
    assert of_job["job"] == {
        "number": "2026-0417",
        "date": "2026-04-17",
        "vin": "WVWZZZ1JZXW000001",
        "plate": None,
        "serial": None,
        "mileage_km": 90000.0,
        "measured_by": "B. Nowak",
        "doubts": [],
    }
    assert of_none["job"] is None
    assert of_job["atleak"] == __version__
    assert of_job["result_sha256"] == of_none["result_sha256"], "the same result, whosever job it is"


def test_the_hash_is_that_of_the_result_and_follows_it(run: Run, small_sheet: Callable[..., Path], job: Path) -> None:
    sheets = (small_sheet(11.04), "--job", job), (small_sheet(11.041),)
    first, second = (json.loads(run("diagnose", *sheet, *MINIMAL, "--json", "-")[1]) for sheet in sheets)
    assert first["result_sha256"] != second["result_sha256"]
    result = {key: value for key, value in first.items() if key not in ("job", "result_sha256")}
    text = json.dumps(result, ensure_ascii=False, sort_keys=True, separators=(",", ":"))
    assert first["result_sha256"] == hashlib.sha256(text.encode()).hexdigest()
