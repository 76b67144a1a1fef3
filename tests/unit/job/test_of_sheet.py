"""What the head of a measuring sheet says of the job comes into its record, and where the two differ is told."""

from __future__ import annotations

import datetime as dt
from dataclasses import replace

import pytest

from atleak.analysis.record_doubts import record_doubts, taken_from_sheet, with_sheet
from atleak.catalogue.controller_file import load_controller
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.job.case import Case, SourceFile
from atleak.job.zip_file import read_job_file, write_job_file
from atleak.measurements.job_card import Job
from atleak.measurements.readings import Readings, SheetIdentity

HEAD = SheetIdentity("4711", "Golf IV", "WVWZZZ1JZXW000001", "S-1", "J. K.", ("micrometer", "bore gauge"), 182_000.0)


@pytest.fixture
def readings(worn: Diagnosis) -> Readings:
    assert worn.readings is not None
    return replace(worn.readings, identity=HEAD)


def test_an_empty_record_takes_all_that_the_head_says(readings: Readings) -> None:
    filled = with_sheet(None, readings)
    assert filled is not None
    assert filled.identity == {
        "number": "4711",
        "date": None,
        "vin": "WVWZZZ1JZXW000001",
        "plate": None,
        "serial": "S-1",
        "mileage_km": 182_000.0,
        "measured_by": "J. K.",
    }
    assert (filled.vehicle.model, [each.name for each in filled.instruments]) == (
        "Golf IV",
        ["micrometer", "bore gauge"],
    )
    assert len(taken_from_sheet(Job(), filled)) == 7


def test_the_date_of_the_head_is_the_jobs_where_it_has_none(worn: Diagnosis) -> None:
    assert worn.readings is not None
    dated = replace(worn.readings, identity=SheetIdentity(), date=dt.date(2026, 10, 1))
    filled = with_sheet(None, dated)
    assert filled is not None
    assert (filled.date, taken_from_sheet(Job(), filled)) == (dt.date(2026, 10, 1), ("date",))
    own = Job(date=dt.date(2026, 9, 30))
    assert with_sheet(own, dated) == own


def test_what_the_record_says_itself_counts(readings: Readings) -> None:
    own = Job(
        number="12",
        technician="A. B.",
        vehicle={"make": "Ford", "vin": "1FA", "mileage_km": 5.0},
        transmission={"serial": "S-2"},
        instruments=[{"name": "bore gauge"}],
    )
    assert with_sheet(own, readings) == own
    assert taken_from_sheet(own, own) == ()


def test_a_sheet_without_a_head_makes_no_record(worn: Diagnosis) -> None:
    assert with_sheet(None, worn.readings) is None
    assert with_sheet(None, None) is None


def test_a_sheet_of_another_unit_is_doubted(worn: Diagnosis, readings: Readings) -> None:
    own = Job(number="4711", vehicle={"vin": "1FA", "mileage_km": 18_200.0}, transmission={"serial": "s-1"})
    diagnosis = replace(worn, readings=readings, mileage=182_000.0)
    said = {doubt.code: doubt.text for doubt in record_doubts(own, diagnosis)}
    assert "the VIN 1FA, the head of the measuring sheet WVWZZZ1JZXW000001" in said["sheet_of_another_job"]
    differ = "18\xa0200 km, the head of the measuring sheet 182\xa0000 km: 182\xa0000 km counts"
    assert differ in said["mileages_differ"]
    assert len(said) == 2  # neither number nor serial differ


@pytest.mark.parametrize(
    ("unit", "record"),
    [
        *(("minimal_example", record) for record in (None, 120_000.0, 150_000.0)),
        *(("five_speed_2005", record) for record in (None, 120_000.0)),
        *(pytest.param(unit, 120_000.0, marks=pytest.mark.slow) for unit in ("zf_6hp26", "gm_4l60e")),
    ],
)
def test_a_mileage_that_is_corrected_on_the_sheet_counts_in_a_job_that_was_saved(
    unit: str, record: float | None
) -> None:
    land = load_controller(unit).lands[0]
    row = f"{land.component};{land.planes[0]};spool;{land.nominal_diameter * 1e3:.4f}"

    def sheet(mileage: str) -> SourceFile:
        return SourceFile("sheet.csv", f"Mileage;{mileage} km\n\nComponent;Plane;Part;Diameter [mm]\n{row}".encode())

    job = Job(vehicle={"mileage_km": record})
    case = Case(controller=unit, readings=sheet("120000"))
    saved = read_job_file(write_job_file(case.diagnose(), job, case)).case
    corrected = replace(saved, readings=sheet("150000")).diagnose()
    assert corrected.mileage == 150_000.0
    doubts = [each.text for each in record_doubts(job, corrected) if each.code == "mileages_differ"]
    assert len(doubts) == (record == 120_000.0)
    # one that was stated stays, and is told of
    typed = replace(case, mileage=120_000.0)
    kept = read_job_file(write_job_file(typed.diagnose(), job, typed)).case
    again = replace(kept, readings=sheet("150000")).diagnose()
    assert again.mileage == 120_000.0
    [said] = [each.text for each in record_doubts(job, again) if each.code == "mileages_differ"]
    assert "120\xa0000 km, the head of the measuring sheet 150\xa0000 km: 120\xa0000 km counts" in said


def test_nothing_is_taken_of_the_sheet_of_another_unit(readings: Readings) -> None:
    own = Job(vehicle={"vin": "1FA"})
    assert with_sheet(own, readings) == own
    assert with_sheet(Job(vehicle={"vin": HEAD.vin.lower()}), readings).technician == "J. K."  # type: ignore[union-attr]
