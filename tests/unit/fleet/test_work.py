"""What a worker does for one unit: the same diagnosis as anywhere else, or one row that says why there is none."""

from __future__ import annotations

import io
import os
import pickle
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from atleak.catalogue.entries import catalogue_files
from atleak.common.errors import InputError
from atleak.common.sentences import Sentence
from atleak.fleet import worker as work
from atleak.fleet.columns import DATA_SETS
from atleak.fleet.units import FleetUnit
from atleak.fleet.worker import evaluate_unit
from atleak.job.batch import write_reports
from atleak.job.case import Case, SourceFile
from atleak.job.result import result_record
from atleak.job.zip_file import write_job_file
from atleak.measurements.job_card import Job
from tests.unit.fleet.small_units import Faulty, Short, bad_unit, small_unit


def _error(unit: FleetUnit, **options: Any) -> dict[str, Any]:
    rows = evaluate_unit(unit, **options)
    assert list(rows.tables) == ["errors"]
    assert (rows.controller, rows.verdict) == (None, None)
    (row,) = rows.tables["errors"].to_pylist()
    return row


def test_a_unit_has_the_result_that_its_files_have_alone() -> None:
    unit = small_unit(300)
    case, job = unit.opened()
    diagnosis = case.diagnose()
    rows = evaluate_unit(unit, tries=2)
    (of_unit,) = rows.tables["units"].to_pylist()
    assert of_unit["result_sha256"] == result_record(diagnosis, job)["result_sha256"]
    assert (of_unit["verdict"], of_unit["tries"], of_unit["number"]) == (diagnosis.verdict.value, 2, "300")
    assert (rows.controller, rows.verdict) == ("minimal_example", diagnosis.verdict)
    assert of_unit["seconds"] > 0.0


def test_an_entry_of_the_catalogue_is_kept_by_its_bytes_alone() -> None:
    """Two files of one name are two valve bodies."""
    text = catalogue_files("controllers")["minimal_example"].read_text(encoding="utf-8")
    renamed = text.replace('name = "', 'name = "other ', 1)
    assert renamed != text
    case, job = small_unit(1).opened()
    names = []
    for content in (text, renamed, text):
        own = Case(readings=case.readings, controller=SourceFile("own.toml", content.encode()))
        rows = evaluate_unit(FleetUnit("u", "file:u", case=own, job=job))
        names.append(rows.tables["units"].column("controller_name")[0].as_py())
    assert names[0] == names[2] == names[1].removeprefix("other ")
    assert names[0] != names[1]


def test_threads_that_load_more_entries_than_are_kept_do_not_disturb_each_other(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Another thread drops, at the worst moment, what this one has just put there and what it is about to drop."""

    class Disturbed(dict[Any, Any]):
        def __setitem__(self, key: Any, value: Any) -> None:
            super().__setitem__(key, value)
            if len(self) > 1:
                listed.append(key)

        def __iter__(self) -> Iterator[Any]:
            kept = list(super().__iter__())
            if len(kept) > 1:
                self.clear()
            return iter(kept)

    listed: list[Any] = []
    monkeypatch.setattr(work, "_ENTRIES", Disturbed())
    monkeypatch.setattr(work, "_KEPT", 1)
    with_body = [evaluate_unit(small_unit(number)) for number in range(2)]
    assert [rows.controller for rows in with_body] == ["minimal_example"] * 2
    assert listed, "more entries than are kept"


def test_a_bad_file_is_an_error_in_the_words_that_a_person_would_have_got() -> None:
    unit = bad_unit(1)
    with pytest.raises(Exception, match="not a measuring sheet") as alone:
        unit.opened()[0].diagnose()
    row = _error(unit, tries=3)
    assert (row["kind"], row["message"], row["tries"]) == ("refused", str(alone.value), 3)


def test_a_bad_file_in_a_job_file_is_named_as_in_a_batch_of_reports(tmp_path: Path) -> None:
    case = small_unit(1).opened()[0]
    path = tmp_path / "job.zip"
    whole = zipfile.ZipFile(io.BytesIO(write_job_file(case.diagnose(), Job(), case)))
    with zipfile.ZipFile(path, "w") as damaged:
        for name in whole.namelist():
            damaged.writestr(name, b"no sheet" if name == "readings" else whole.read(name))
    unit = FleetUnit("folder/job.zip", f"file:{path}", job_file=SourceFile.at(path))
    (reported,) = write_reports([path], tmp_path / "out", formats=["json"])
    assert _error(unit)["message"] == str(reported.error)
    assert str(reported.error).startswith("job.zip: ")


def test_a_fault_of_atleak_s_own_is_told_from_a_bad_file() -> None:
    row = _error(small_unit(1, Faulty))
    assert row["kind"] == "fault"
    assert row["message"] == "unit 1: unexpected ZeroDivisionError: of atleak's own. This is a fault of atleak"


def test_a_unit_for_which_the_memory_does_not_suffice_is_as_one_whose_worker_was_ended() -> None:
    assert _error(small_unit(1, Short))["kind"] == "ended"


def test_a_lack_of_memory_is_known_behind_the_package_s_own_error(monkeypatch: pytest.MonkeyPatch) -> None:
    def short(case: Case, *_: object) -> None:
        raise MemoryError

    monkeypatch.setattr(Case, "_diagnosed", short)
    row = _error(small_unit(1))
    assert row["kind"] == "ended"
    assert "MemoryError" in row["message"]


def test_rows_travel_as_they_are() -> None:
    rows = evaluate_unit(small_unit(3))
    arrived = pickle.loads(pickle.dumps(rows))
    assert (arrived.error, arrived.verdict, arrived.reference) == (None, rows.verdict, rows.reference)
    assert {name: table.to_pylist() for name, table in arrived.tables.items()} == {
        name: table.to_pylist() for name, table in rows.tables.items()
    }
    assert set(arrived.tables) <= set(DATA_SETS)
    assert pickle.loads(pickle.dumps(evaluate_unit(bad_unit(1)))).error == "refused"


def test_a_refusal_is_told_where_a_file_that_is_still_open_cannot_be_deleted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def kept(*_: object, **__: object) -> None:
        raise PermissionError

    def opened(unit: FleetUnit, folder: Path) -> None:
        (folder / "log.csv").write_bytes(b"")
        monkeypatch.setattr(os, "unlink", kept)
        raise InputError(Sentence("the refusal"))

    monkeypatch.setattr(FleetUnit, "opened", opened)
    (row,) = evaluate_unit(small_unit(1), folder=tmp_path).tables["errors"].to_pylist()
    assert (row["kind"], row["message"]) == ("refused", "the refusal")
