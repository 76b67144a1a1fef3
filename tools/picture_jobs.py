"""Make what the pictures of the documentation show besides the sample job itself: a second visit, a job book, a fleet.

Everything follows from the sample's measuring sheets. No unit, vehicle or workshop of these jobs exists, and all call
themselves sample.
"""

from __future__ import annotations

import datetime as dt
import os
import random
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from functools import cache
from pathlib import Path

from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import load_controller
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.fleet.folder import note
from atleak.fleet.results import Results
from atleak.fleet.units import FleetUnit
from atleak.fleet.worker import evaluate_unit
from atleak.job.case import Case, SourceFile
from atleak.job.parts import job_parts
from atleak.job_book.book import open_book
from atleak.job_book.tables import jobs, results
from atleak.measurements.clearances import clearances
from atleak.measurements.job_card import Job, RepairDecision, Transmission, Vehicle
from atleak.measurements.readings import Reading, Readings
from atleak.readers.sheets.measuring_sheet import read_readings
from atleak.report.sheets.measuring_sheet import write_readings

SAMPLE_DATA = Path(__file__).resolve().parents[1] / "sample_data"
FOUR_SPEED, FIVE_SPEED = "measuring_sheet_four_speed.xlsx", "measuring_sheet_five_speed.xlsx"
FOUR_SPEED_REPAIRED = "measuring_sheet_four_speed_repaired.xlsx"
LOG = "minimum_acceleration_test.csv"
FIRST, SECOND = "SAMPLE-1", "SAMPLE-2"  # numbers of the two visits of one unit
REPAIRED = (("25", 1), ("26", 2))  # lands whose bores have a new sleeve at the second visit
FLEET = "spring"  # name of the folder of a fleet's results
FLEET_SIZE = 30  # units, half of them from either supplier
SEED = 7667
DAY = dt.date(2026, 4, 17)
KEPT_AT = dt.datetime(2026, 4, 17, 9, 30, tzinfo=dt.UTC)  # when the book says that a job was changed
MILEAGE, MILEAGE_REPAIRED = 106_315.0, 106_320.0  # [km], as the sample's sheets state

Key = tuple[str, int]


def sample_case(content: bytes | None = None, name: str = FOUR_SPEED, **more: object) -> Case:
    """Return the case of a sample's sheet with the sample's log; ``content`` takes the place of the sheet's."""
    sheet = SourceFile(name, content or (SAMPLE_DATA / name).read_bytes())
    log = SourceFile(LOG, (SAMPLE_DATA / LOG).read_bytes())
    return Case(**{"readings": sheet, "road_test": log, "remember": False, **more})  # type: ignore[arg-type]


@cache
def _four_speed() -> tuple[Controller, Readings]:
    controller = load_controller("four_speed_2023")
    return controller, read_readings(SAMPLE_DATA / FOUR_SPEED, controller)


def sheet_with(mileage: float, changed: Callable[[Key, float, float], float]) -> bytes:
    """Return the four-speed's sample sheet with other bores, measured at a mileage [km].

    ``changed`` gets a land's key, its radial clearance as measured and that when new [m], and returns the clearance
    that the sheet shall have.
    """
    controller, read = _four_speed()
    wider: dict[tuple[str, str], float] = {}
    for state in clearances(read, controller):
        measured = state.radial_clearance
        assert measured is not None
        wanted = changed(state.land.key, measured, state.land.new_clearance)
        wider |= dict.fromkeys(
            ((state.land.component, plane) for plane in state.land.planes), 2.0 * (wanted - measured)
        )

    def moved(reading: Reading) -> Reading:
        if reading.part != "sleeve":
            return reading
        more = wider[reading.component, reading.plane]
        return replace(reading, diameter=round(reading.diameter + more, 6), coordinates=None)

    fields = {"Job": "atleak sample", "Vehicle": "sample, no real vehicle", "Mileage": f"{mileage:.0f} km"}
    return write_readings(controller, map(moved, read.readings), fields=fields, blank_rows=False)


def record(number: str, day: dt.date, mileage: float, serial: str = "SAMPLE UNIT") -> Job:
    """Return what a workshop would have written down of a sample."""
    return Job(
        number=number,
        date=day,
        measured_on=day,
        technician="sample",
        vehicle=Vehicle(make="sample", model="no real vehicle", registration="SAMPLE", mileage_km=mileage),
        transmission=Transmission(code="four-speed", serial=serial),
    )


def visits() -> Iterator[tuple[Case, Diagnosis, Job]]:
    """Return the two visits of the sample unit: as it came, and after the repair that a tutorial writes down."""
    first = sample_case()
    yield first, first.diagnose(), record(FIRST, DAY, MILEAGE)
    second = sample_case(name=FOUR_SPEED_REPAIRED)
    done = tuple(
        RepairDecision(component=component, land=land, work="new sleeve", decision="done")
        for component, land in REPAIRED
    )
    after = record(SECOND, DAY + dt.timedelta(days=5), MILEAGE_REPAIRED)
    after = after.model_copy(update={"repair_decisions": done})
    yield second, second.diagnose(), after


def fill_book() -> Mapping[str, str]:
    """Put the two visits and a five-speed into the job book of the user's folder; return their ids by number."""
    five = sample_case(name=FIVE_SPEED, controller="five_speed_2005", road_test=None)
    third = record("SAMPLE-3", DAY + dt.timedelta(days=11), 212_000.0, "SAMPLE FIVE-SPEED")
    third = third.model_copy(update={"transmission": Transmission(code="five-speed", serial="SAMPLE FIVE-SPEED")})
    held = [*visits(), (five, five.diagnose(), third)]
    book = open_book()
    ids = {}
    for days, (case, diagnosis, job) in enumerate(held):
        saved = book.save(job_parts(diagnosis, job, case))
        ids[job.number] = saved.id
        moment = KEPT_AT + dt.timedelta(days=(0, 5, 11)[days])
        with book.writing() as connection:
            where = jobs.c.id == saved.id
            connection.execute(jobs.update().where(where).values(made_at=moment, changed_at=moment))
            connection.execute(results.update().where(results.c.job == saved.id).values(made_at=moment))
    return ids


def make_fleet(folder: Path) -> Path:
    """Evaluate a fleet of sample units with wear drawn at random; return the folder of its results, which is noted."""
    chance = random.Random(SEED)
    units = []
    for number in range(1, FLEET_SIZE + 1):
        supplier = ("east", "west")[number % 2]
        age = chance.uniform(0.2, 1.0)
        mileage = 40_000.0 + 120_000.0 * age

        def worn(key: Key, measured: float, new: float, age: float = age, supplier: str = supplier) -> float:
            more = 1.5 if supplier == "west" and key == ("25", 1) else 1.0
            return new + (measured - new) * age * more * chance.uniform(0.7, 1.2)

        case = sample_case(sheet_with(mileage, worn), f"unit_{number:02d}.xlsx", road_test=None)
        job = record(f"SAMPLE-{number:02d}", DAY, mileage, f"SAMPLE {number:02d}")
        labels = (("supplier", supplier),)
        units.append(FleetUnit(f"unit {number:02d}", f"file:{number}", labels=labels, case=case, job=job))
    with Results.open(folder / FLEET, for_writing=True) as kept:
        kept.add([evaluate_unit(unit) for unit in units])
    note(folder / FLEET)
    return folder / FLEET


@contextmanager
def user_folder(home: Path) -> Iterator[None]:
    """Work for the user of a folder of their own."""
    before = os.environ.get("ATLEAK_HOME")
    os.environ["ATLEAK_HOME"] = str(home)
    try:
        yield
    finally:
        if before is None:
            del os.environ["ATLEAK_HOME"]
        else:
            os.environ["ATLEAK_HOME"] = before
