"""A unit on its way to a worker: small, pickled and whole, with a hash of all that its result rests on."""

from __future__ import annotations

import hashlib
import pickle
from dataclasses import replace
from pathlib import Path

import pytest

from atleak.common.errors import InputError, Place
from atleak.common.sentences import Sentence
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.fleet import units
from atleak.fleet.units import FleetUnit, travelling
from atleak.job.case import Case, SourceFile
from atleak.job.zip_file import write_job_file
from atleak.measurements.job_card import Job, Photo, Vehicle


def _sent(unit: FleetUnit) -> FleetUnit:
    """The unit as it arrives at a worker."""
    arrived: FleetUnit = pickle.loads(pickle.dumps(unit))
    return arrived


def test_a_job_file_travels_with_its_bytes_and_is_known_by_their_hash(unmeasured: Diagnosis, tmp_path: Path) -> None:
    content = write_job_file(unmeasured, Job(number="17"))
    path = tmp_path / "17.zip"
    path.write_bytes(content)
    unit = FleetUnit("17.zip", f"file:{path}", job_file=travelling(path))
    assert unit.input_sha256 == hashlib.sha256(content).hexdigest()
    path.unlink()
    arrived = _sent(unit)
    assert arrived.input_sha256 == unit.input_sha256
    case, job = arrived.opened()
    assert job.number == "17"
    assert case.diagnose().verdict == unmeasured.verdict


def test_a_row_travels_with_its_case_and_record(tmp_path: Path) -> None:
    case = Case(readings=SourceFile("sheet.csv", b"1,2\n"), mileage=120_000.0)
    job = Job(number="7", date="2026-04-17", photos=(Photo(file="a.png"),)).with_pictures({"a.png": b"1"})
    unit = FleetUnit("t.csv, row 7", "table:t#7", group="A", labels=(("Batch", "3"),), case=case, job=job)
    arrived = _sent(unit)
    assert arrived == unit
    assert arrived.opened() == (case, job)
    assert arrived.opened()[1].pictures == {"a.png": b"1"}
    assert arrived.input_sha256 == unit.input_sha256


def test_the_hash_of_a_row_is_of_its_files_its_record_its_group_and_its_labels() -> None:
    case = Case(readings=SourceFile("sheet.csv", b"1,2\n"))
    unit = FleetUnit("t.csv, row 7", "table:t#7", group="A", labels=(("Batch", "3"),), case=case, job=Job(number="7"))
    others = [
        replace(unit, case=Case(readings=SourceFile("sheet.csv", b"1,3\n"))),
        replace(unit, case=replace(case, mileage=1000.0)),
        replace(unit, job=Job(number="7", vehicle=Vehicle(vin="W1"))),
        replace(unit, group="B"),
        replace(unit, labels=(("Batch", "4"),)),
    ]
    assert len({unit.input_sha256, *(each.input_sha256 for each in others)}) == 6
    assert replace(unit, name="t.csv, row 8", reference="table:t#8").input_sha256 == unit.input_sha256


def test_a_large_file_is_read_where_the_work_is_done_and_must_be_what_it_was(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(units, "TRAVELS_UP_TO", 10)
    log, small = tmp_path / "log.csv", tmp_path / "sheet.csv"
    log.write_bytes(b"time;pressure\n" * 3)
    small.write_bytes(b"1;2\n")
    unit = FleetUnit("t.csv, row 2", "table:t#2", case=Case(readings=travelling(small), road_test=travelling(log)))
    assert unit.input_sha256
    assert len(pickle.dumps(unit)) < 4000
    assert b"time;pressure" not in pickle.dumps(unit)
    small.write_bytes(b"other")  # has gone along
    assert _sent(unit).opened()[0].road_test == SourceFile("log.csv", path=log)
    log.write_bytes(b"time;pressure\n" * 4)
    with pytest.raises(InputError, match="has changed since the run found it; expected the run to be started"):
        _sent(unit).opened()


def test_what_was_wrong_when_it_was_found_is_said_where_it_is_opened() -> None:
    fault = InputError(Sentence("no such file"), place=Place("t.csv", row=3, column="Sheet"), value="x.xlsx")
    unit = _sent(FleetUnit("t.csv, row 3", "table:t#3", fault=fault))
    with pytest.raises(InputError) as raised:
        unit.opened()
    assert str(raised.value) == str(fault) == "t.csv, row 3, column Sheet: no such file (found 'x.xlsx')"
    assert raised.value.place == fault.place
    assert raised.value.sentence.template == fault.sentence.template
    assert unit.input_sha256 == FleetUnit("t.csv, row 3", "table:t#3", fault=fault).input_sha256


def test_an_error_in_a_job_file_names_it_and_the_file_in_it() -> None:
    error = InputError(Sentence("is empty"), place=Place("sheet.xlsx", row=2))
    FleetUnit("a/7.zip", "file:/a/7.zip", job_file=SourceFile("7.zip", b"")).name_within(error)
    assert str(error) == "7.zip: sheet.xlsx, row 2: is empty"
    damaged = FleetUnit("a/7.zip", "file:/a/7.zip", job_file=SourceFile("7.zip", b"no job"))
    with pytest.raises(InputError) as raised:
        damaged.opened()
    damaged.name_within(raised.value)
    assert str(raised.value).startswith("7.zip: is no sound zip")


def test_a_file_that_cannot_be_read_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"^gone\.zip: cannot be read: "):
        travelling(tmp_path / "gone.zip")
