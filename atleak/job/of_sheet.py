"""Bring what a measuring sheet's head says of the job into its record, and what that says of measuring into a case."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator, Mapping
from typing import Any

from atleak.errors import Message
from atleak.intake.readings.words import plain, text_of
from atleak.job.record import InstrumentUsed, Job
from atleak.readings import TYPED_MARK, Readings, SheetIdentity
from atleak.sentence import Sentence
from atleak.unit_systems import Quantity


def with_sheet(job: Job | None, readings: Readings | None) -> Job | None:
    """Return the record with what the sheet's head says where the record says nothing; None where neither does.

    Nothing is taken of a sheet whose head names another job or unit: `sheet_doubts` asks whose it is.

    Parameters
    ----------
    job
        what the workshop wrote down; what stands there counts.
    readings
        as the measuring sheet was read.
    """
    if readings is None or (readings.identity.empty and readings.date is None):
        return job
    head, record = readings.identity, job or Job()
    if any(_contradictions(record, head)):
        return job
    vehicle: dict[str, Any] = {}
    if head.vehicle and not (record.vehicle.make or record.vehicle.model):
        vehicle["model"] = head.vehicle
    if head.vin and not record.vehicle.vin:
        vehicle["vin"] = head.vin
    if head.mileage is not None and record.vehicle.mileage_km is None:
        vehicle["mileage_km"] = head.mileage
    changes: dict[str, Any] = {
        "number": record.number or head.job,
        "date": record.date or readings.date,
        "technician": record.technician or head.technician,
        "vehicle": record.vehicle.model_copy(update=vehicle),
        "transmission": record.transmission.model_copy(update={"serial": record.transmission.serial or head.serial}),
    }
    if head.instruments and not record.instruments:
        changes["instruments"] = tuple(InstrumentUsed(name=name) for name in head.instruments)
    return record.model_copy(update=changes).with_pictures(record.pictures)


def taken_from_sheet(before: Job, filled: Job) -> tuple[str, ...]:
    """Return the names of what `with_sheet` brought into a record."""
    return tuple(name for name, value in _filled(filled).items() if value != _filled(before)[name])


def _filled(job: Job) -> dict[str, Any]:
    return {
        "number": job.number,
        "date": job.date,
        "vehicle": job.vehicle.model,
        "vin": job.vehicle.vin,
        "serial": job.transmission.serial,
        "mileage": job.vehicle.mileage_km,
        "technician": job.technician,
        "instrument": job.instruments,
    }


def sheet_doubts(job: Job, readings: Readings | None, mileage: float | None) -> Iterator[Message]:
    """Doubt that a sheet is of this job: its head names another unit, or another mileage, than the job does.

    ``mileage`` is the one [km] that counts, whoever stated it.
    """
    if readings is None:
        return
    head = readings.identity
    for what, own, written in _contradictions(job, head):
        text = Sentence(
            "The record has the {what} {own}, the head of the measuring sheet {written}: is it the sheet of this "
            "unit? The record counts.",
            what=what,
            own=own,
            written=written,
        )
        yield Message("warning", "sheet_of_another_job", text)
    for km in (mileage, job.vehicle.mileage_km):
        if km is None or mileage is None or head.mileage is None or abs(km - head.mileage) < 1.0:
            continue
        text = Sentence(
            "The job has a mileage of {own:,.0f} {own.unit}, the head of the measuring sheet {written:,.0f} "
            "{written.unit}: {counts:,.0f} {counts.unit} counts.",
            own=Quantity(km, "distance"),
            written=Quantity(head.mileage, "distance"),
            counts=Quantity(mileage, "distance"),
        )
        yield Message("warning", "mileages_differ", text)
        return


def _contradictions(job: Job, head: SheetIdentity) -> Iterator[tuple[Sentence, str, str]]:
    """Yield what tells units apart and differs: what it is, that of the record and that of the sheet's head."""
    for what, own, written in (
        (Sentence("job number"), job.number, head.job),
        (Sentence("VIN"), job.vehicle.vin, head.vin),
        (Sentence("serial number"), job.transmission.serial, head.serial),
    ):
        if own and written and plain(own) != plain(written):
            yield what, own, written


def without_plan_as_number(choices: Mapping[str, Any], sheet: bytes) -> Mapping[str, Any]:
    """Return the content of ``job.json`` without the number that version 0.2.0 made of the plan of typed readings.

    The notes then say so. Only a number that is to the letter what 0.2.0 made of this very file goes.

    Parameters
    ----------
    choices
        as it was kept.
    sheet
        the job's file of readings.
    """
    record = choices.get("job")
    if not isinstance(record, Mapping) or not record.get("number") or record["number"] != _number_of_plan(sheet):
        return choices
    note = "The job number was emptied: atleak 0.2.0 had put the plan of the typed readings in its place. It read:"
    notes = "\n".join(text for text in (record.get("notes"), f"{note} {record['number']}") if text)
    return {**choices, "job": {**{name: record[name] for name in record if name != "number"}, "notes": notes}}


def _number_of_plan(sheet: bytes) -> str | None:
    """Return what 0.2.0 took for the job's number in the first row of a file of typed readings; None in any other."""
    try:
        lines = io.StringIO(sheet.decode().removeprefix("sep=;\r\n"), newline="")
        row = next(csv.reader(lines, delimiter=";"), [])
    except (UnicodeDecodeError, csv.Error):
        return None
    number = text_of(row[1].partition(":")[2]) if row[:1] == [TYPED_MARK] and len(row) > 1 else ""
    return number if 0 < len(number) <= 200 else None  # signs: 0.2.0 took no longer text for a field
