"""What the results of a fleet hold of one unit, and its own job as long as that is what it was."""

from __future__ import annotations

from pathlib import Path

import pytest

from atleak.common.errors import FleetError, InputError
from atleak.common.verdicts import Verdict
from atleak.fleet.results import Results
from atleak.fleet.sources import find_units, kept_unit
from atleak.fleet.worker import evaluate_unit
from atleak.job.case import Case, SourceFile
from atleak.job.result import judged_otherwise
from atleak.job.zip_file import write_job_file
from atleak.measurements.job_card import Job
from atleak.report.json.diagnosis import diagnosis_record
from tests.unit.fleet.made_up import CONTROLLERS, POINTS, made_up_results
from tests.unit.fleet.small_units import small_unit


def job_file(path: Path, number: int = 1) -> Path:
    """A small job file; its wear is told by its number."""
    unit = small_unit(number)
    assert unit.case is not None
    path.write_bytes(write_job_file(unit.case.diagnose(), Job(number=f"N{number}"), unit.case))
    return path


def results_of(*paths: Path, folder: Path) -> Results:
    with Results.open(folder, for_writing=True) as writing:
        writing.add([evaluate_unit(unit) for unit in find_units(paths)])
    return Results.open(folder)


def test_a_unit_is_found_among_others_with_its_lands_the_worst_first(tmp_path: Path) -> None:
    results = made_up_results(tmp_path / "fleet", units=20)
    units = results.table("units", controllers=[CONTROLLERS[1]]).to_pylist()
    lands = results.table("lands", controllers=[CONTROLLERS[1]]).to_pylist()
    for unit in units[:3]:
        kept = kept_unit(results, unit["input_sha256"])
        mine = [row for row in lands if row["input_sha256"] == unit["input_sha256"]]
        assert kept.unit == unit
        assert {(row["component"], row["land"], row["wear_percent"]) for row in kept.lands} == {
            (row["component"], row["land"], row["wear_percent"]) for row in mine
        }
        ranks = [Verdict(row["verdict"]).rank for row in kept.lands]
        assert ranks == sorted(ranks, reverse=True)
        assert [row["name"] for row in kept.conditions] == list(POINTS)


def test_a_unit_that_the_results_do_not_hold_is_said(tmp_path: Path) -> None:
    results = made_up_results(tmp_path / "fleet", units=4)
    with pytest.raises(FleetError, match="no result of this unit any more"):
        kept_unit(results, "0" * 64)


def test_its_own_job_is_opened_and_is_judged_as_its_rows_say(tmp_path: Path) -> None:
    path = job_file(tmp_path / "1.zip")
    kept = kept_unit(results_of(path, folder=tmp_path / "fleet"), SourceFile.at(path).sha256)
    case, job = kept.opened()
    assert (job.number, type(case)) == ("N1", Case)
    today = diagnosis_record(case.diagnose())
    without_circuits = {**today, "conditions": [{**each, "circuits": []} for each in today["conditions"]]}
    assert judged_otherwise(kept.result, without_circuits, numbers=True) == ()
    worse = {**without_circuits, "verdict": "critical"}
    (said,) = judged_otherwise(kept.result, worse, numbers=True)
    assert str(said).startswith("the unit")


def test_a_job_that_has_changed_since_or_is_gone_is_not_opened(tmp_path: Path) -> None:
    path = job_file(tmp_path / "1.zip")
    kept = kept_unit(results_of(path, folder=tmp_path / "fleet"), SourceFile.at(path).sha256)
    job_file(path, number=2)
    with pytest.raises(InputError, match="other content now"):
        kept.opened()
    path.unlink()
    with pytest.raises(InputError, match="not there any more"):
        kept.opened()
