"""The head of a measuring sheet: which job, vehicle and unit, when and with what was measured, and its QR code."""

from __future__ import annotations

import io
from collections.abc import Mapping
from typing import TYPE_CHECKING

import segno

from atleak.catalogue.controller import Controller
from atleak.report.measuring_sheet.words import PUMP_SIDE, PUMP_TIP
from atleak.sentence import Sentence

if TYPE_CHECKING:
    from atleak.job.record import Job

JOB, VEHICLE, DATE = Sentence("Job"), Sentence("Vehicle"), Sentence("Date")
MILEAGE, MEASURED_BY, VIN = Sentence("Mileage"), Sentence("Measured by"), Sentence("VIN")
SERIAL, TEMPERATURE = Sentence("Serial number"), Sentence("Measuring temperature")
INSTRUMENT = Sentence("Instrument")
PLACES = {  # row, column of the label, first and last column of the field; from 0
    JOB: (3, 0, 2, 3),
    VEHICLE: (3, 4, 6, 7),
    DATE: (3, 8, 9, 10),
    PUMP_SIDE: (3, 11, 13, 13),
    MILEAGE: (4, 0, 2, 3),
    MEASURED_BY: (4, 4, 6, 7),
    VIN: (4, 8, 9, 10),
    PUMP_TIP: (4, 11, 13, 13),
    SERIAL: (5, 0, 2, 3),
    TEMPERATURE: (5, 4, 6, 7),
    INSTRUMENT: (5, 8, 9, 10),
}
KINDS = {MILEAGE: "distance", TEMPERATURE: "temperature"}  # of what stands without a unit: the label states it
FIELDS: tuple[Sentence, ...] = tuple(PLACES)
_NAMED_BY = (JOB, SERIAL, VIN)  # the first that is known tells the job from others
_LONGEST = 80  # characters of a number that a code of the head's size takes
_MODULE = 4  # dots of the code's smallest square


def fields_of(job: Job) -> dict[str, str]:
    """Return what a job's record says of the head's fields, by the names of `FIELDS`.

    The date is that of measuring: where the record has none, whoever measures writes it down. Quantities have their
    unit behind them, so that they mean the same on a sheet in any units.
    """
    vehicle = job.vehicle
    car = " ".join(filter(None, (vehicle.make, vehicle.model, vehicle.year)))
    numbers = (
        (MILEAGE, vehicle.mileage_km, "km"),
        (TEMPERATURE, job.measuring_temperature_c, "°C"),
        (PUMP_SIDE, job.pump_side_clearance_um, "µm"),
        (PUMP_TIP, job.pump_tip_clearance_um, "µm"),
    )
    fields: dict[str, str] = {
        JOB: job.number,
        VEHICLE: ", ".join(filter(None, (car, vehicle.registration))),
        DATE: job.measured_on.isoformat() if job.measured_on else "",
        MEASURED_BY: job.technician,
        VIN: vehicle.vin,
        SERIAL: job.transmission.serial,
        INSTRUMENT: ", ".join(filter(None, (each.name for each in job.instruments))),
        **{label: "" if value is None else f"{value:.10g} {unit}" for label, value, unit in numbers},
    }
    return {label: text for label, text in fields.items() if text}


def code_text(controller: Controller, fields: Mapping[str, str]) -> str:
    """Return what a scanner types for this sheet: the job's number, else serial or VIN, and the valve body's id.

    Without any of the three there is nothing to tell the job from others by, and the text is empty; so it is where
    squares of the paper's size could not be scanned.
    """
    name = next((" ".join(fields[label].split()) for label in _NAMED_BY if fields.get(label, "").strip()), "")
    return f"{name} {controller.id}" if 0 < len(name) <= _LONGEST else ""


def qr_code(text: str) -> bytes:
    """Return a QR code as PNG, with the white rim that scanners need; the same text gives the same bytes."""
    target = io.BytesIO()
    segno.make(text, micro=False, error="m").save(target, kind="png", scale=_MODULE)
    return target.getvalue()
