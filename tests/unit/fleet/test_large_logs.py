"""A unit whose log takes more memory than it may is refused, and one row in some of it is evaluated."""

from __future__ import annotations

import pickle
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from atleak.fleet import worker as task
from atleak.fleet.columns import Rows
from atleak.fleet.unit_table import TableUnits
from atleak.fleet.units import FleetUnit
from atleak.fleet.worker import evaluate_unit
from atleak.job import zip_file as job_file
from atleak.job.case import Case, SourceFile
from atleak.job.zip_file import write_job_file
from atleak.readers.logs import columns as assign
from atleak.readers.logs.columns import BESIDE
from atleak.version import __version__

LITTLE = BESIDE + 10_000  # bytes of memory into which the sample log does not fit


@pytest.fixture
def unit(sample_readings: Path, sample_log: Path) -> FleetUnit:
    case = Case(readings=SourceFile.at(sample_readings), road_test=SourceFile.at(sample_log), remember=False)
    return FleetUnit("unit", "file:unit", case=case)


@pytest.fixture(autouse=True)
def none_small(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(assign, "SMALL", 1)


def the(rows: Rows, data_set: str) -> dict[str, Any]:
    (row,) = rows.tables[data_set].to_pylist()  # type: ignore[index]
    return row  # type: ignore[no-any-return]


def test_a_log_that_takes_more_than_a_unit_may_is_refused_with_what_to_do(unit: FleetUnit) -> None:
    whole, refused = evaluate_unit(unit), evaluate_unit(unit, memory=LITTLE)
    assert the(refused, "errors")["kind"] == "refused"
    assert "would take 0.2 GB of memory" in the(refused, "errors")["message"]
    assert "--every" in the(refused, "errors")["message"]
    some = evaluate_unit(replace(unit, case=replace(unit.case, every=50)), memory=LITTLE)
    assert the(some, "units")["road_rows"] == -(-the(whole, "units")["road_rows"] // 50)
    assert some.input_sha256 != whole.input_sha256


def test_a_worker_gives_a_unit_what_it_has(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, unit: FleetUnit) -> None:
    memory = SimpleNamespace(memory_limit=LITTLE)
    worker = SimpleNamespace(memory_manager=memory, local_directory=str(tmp_path))
    monkeypatch.setattr(task, "get_worker", lambda: worker)
    packed = pickle.dumps(unit)
    for limit, data_set in ((LITTLE, "errors"), (LITTLE + (1 << 30), "units"), (0, "units")):
        memory.memory_limit = limit
        assert data_set in task.on_worker(packed, "unit", 1, None, __version__).tables
    assert list(tmp_path.iterdir()) == []


def test_the_choice_counts_for_the_rows_of_a_table(tmp_path: Path, sample_readings: Path, sample_log: Path) -> None:
    table = tmp_path / "fleet.csv"
    table.write_text(f"Sheet;Log\n{sample_readings};{sample_log}\n", encoding="utf-8")
    (unit,) = TableUnits(table, Case(remember=False, every=50))
    assert the(evaluate_unit(unit, memory=LITTLE), "units")["road_rows"] < 100


def test_a_large_log_of_a_job_file_is_unpacked_to_the_disk(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, unit: FleetUnit
) -> None:
    monkeypatch.setattr(job_file, "_LARGE", 1000)
    case = unit.opened()[0]
    path = tmp_path / "job.zip"
    path.write_bytes(write_job_file(case.diagnose(), None, case))
    of_file = FleetUnit("job.zip", f"file:{path}", job_file=SourceFile.at(path))
    kept, _ = of_file.opened(tmp_path)
    assert kept.road_test is not None
    assert kept.road_test.data is None
    told, expected = (the(evaluate_unit(each), "units")["result_sha256"] for each in (of_file, unit))
    assert told == expected
