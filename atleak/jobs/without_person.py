"""Take a person out of a job: its record, its files and its results, and nothing that a verdict rests on.

What stays is listed; everything else goes. So a field that is added to the record later goes too, until it is listed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any, TypeVar

from atleak.catalogue.controller import Controller
from atleak.errors import AtleakError
from atleak.job.case import OWN_FILES, SLOTS, Case, Reader, SourceFile
from atleak.job.parts import JobFile, JobParts, job_parts
from atleak.job.record import Job
from atleak.jobs.plain_files import PlainLog, plain_gauges, plain_log, plain_sheet
from atleak.pressure_table import PressureTable

_OF_JOB = ("date", "measuring_temperature_c", "pump_side_clearance_um", "pump_tip_clearance_um")
_OF_DECISION = ("decision", "date", "price", "hours")  # besides component, land and repair, which the valve body names
_LEVELS = ("verdict", "decision", "band", "atleak", "measured")  # keys of a result whose words are atleak's own
Of = TypeVar("Of")

_CALLED = {"readings": "measuring sheet", "pressures": "gauge readings", "road_test": "road-test log"}
_SHORT = 4  # characters: shorter names stand in any text


@dataclass(frozen=True)
class WithoutPerson:
    """A job without the person, and what it cost."""

    parts: JobParts
    lost: tuple[str, ...]  # files that could not be written anew: they are gone, and the stored result rests on them
    left_in: tuple[str, ...]  # catalogue files in which something of the person stands: they were left as they are


def without_person(file: JobFile) -> WithoutPerson:
    """Return a job with nothing of its customer: the same readings and channels in plain files, or without them.

    Raises
    ------
    AtleakError
        a valve body, fluid or limits that this version cannot use.
    """
    case, reader = file.case, Reader()
    controller: Controller = reader.entry(SLOTS["controller"], case.controller)
    files, log, lost = _plain_files(case, controller, reader)
    own = {slot: choice for slot in SLOTS if isinstance(choice := getattr(case, slot), SourceFile)}
    renamed = {slot: SourceFile(f"{slot}.toml", file.content) for slot, file in own.items()}
    bare = replace(
        case.with_files({**dict.fromkeys(OWN_FILES), **files, **renamed}),
        mileage=case.mileage if "readings" in files else file.result.get("mileage_km"),  # the sheet's head may state it
        sheet_name=None,
        sheet_unit=None,
        sheet_where=(),
        sheet_fill_down=False,
        columns=log.columns if log else (),
        units=log.units if log else (),
        every=1,
        remember=False,
    )
    diagnosis = bare.diagnose()
    parts = job_parts(diagnosis, _without_person(file.job, controller, lost), bare)
    names = _names(file.job)
    left_in = tuple(file.name for file in own.values() if _holds(file.content, names))
    return WithoutPerson(parts, lost, left_in)


# --- the files


def _plain_files(
    case: Case, controller: Controller, reader: Reader
) -> tuple[dict[str, SourceFile], PlainLog | None, tuple[str, ...]]:
    """Return files that say the same and nothing else, by slot, the log among them, and what of them cannot be had."""
    files: dict[str, SourceFile | None] = {}
    gauges: PressureTable | None = None
    if case.readings is not None:
        readings = _read(reader.readings, case, controller)
        gauges = None if readings is None else readings.pressures
        if readings is None or readings.readings:
            files["readings"] = None if readings is None else plain_sheet(readings, controller)
    if case.pressures is not None:
        gauges = _read(reader.pressures, case, controller)
    if gauges is not None or case.pressures is not None:
        files["pressures"] = None if gauges is None else plain_gauges(gauges, controller)
    log = None
    if case.road_test is not None:
        understood = _read(reader.log, case)
        test = None if understood is None else understood.road_test
        log = None if test is None else plain_log(test, tuple(case.log_choices["constants"].items()))
        files["road_test"] = None if log is None else log.file
    kept = {slot: file for slot, file in files.items() if file is not None}
    return kept, log, tuple(_CALLED[slot] for slot in files if slot not in kept)


def _read(read: Callable[..., Of], *given: Any) -> Of | None:
    """Return what a file says; None where this version cannot read it."""
    try:
        return read(*given)
    except AtleakError:
        return None


# --- the record


def _without_person(job: Job, controller: Controller, lost: tuple[str, ...]) -> Job:
    """Return the record with what the list allows, and a note that says what happened."""
    note = "The customer's data were erased from this job."
    if lost:
        note += f" Gone with them: {', '.join(lost)}. The stored result rests on it and cannot be computed anew."
    return Job.model_validate(
        {
            **{name: getattr(job, name) for name in _OF_JOB},
            "vehicle": {"mileage_km": job.vehicle.mileage_km},
            "contamination": {"grade": job.contamination.grade},
            "repair_decisions": list(_decisions(job, controller)),
            "notes": note,
        }
    )


def _decisions(job: Job, controller: Controller) -> Iterator[dict[str, Any]]:
    for each in job.repair_decisions:
        if each.component not in controller.components:
            continue
        row = each.model_dump()
        kept = {name: row[name] for name in _OF_DECISION if name in row}
        repairs = {repair.id for repair in controller.repairs_of(each.component)}
        if row.get("repair") in repairs:
            kept["repair"] = row["repair"]
        yield {"component": each.component, "land": each.land, **kept}


def _names(job: Job) -> tuple[bytes, ...]:
    """Return what tells the person, to look for it elsewhere."""
    customer, vehicle = job.customer, job.vehicle
    texts = (*customer.model_dump().values(), vehicle.vin, vehicle.registration, job.transmission.serial)
    return tuple(text.casefold().encode() for text in texts if len(text) >= _SHORT)


def _holds(content: bytes, names: tuple[bytes, ...]) -> bool:
    text = content.decode("utf-8", "replace").casefold().encode()
    return any(name in text for name in names)


# --- results


def result_without_person(record: dict[str, Any], parts: JobParts) -> dict[str, Any]:
    """Return a result as it was stored, to the last digit, with only those texts that the job without the person has.

    Parameters
    ----------
    record
        as ``diagnose --json`` writes it, of any version.
    parts
        the job without the person.
    """
    return dict(_cleared(record, frozenset(_texts(parts.result))))


def _texts(value: Any) -> Iterator[str]:
    if isinstance(value, str):
        yield value
    elif isinstance(value, dict):
        for each in value.values():
            yield from _texts(each)
    elif isinstance(value, list):
        for each in value:
            yield from _texts(each)


def _cleared(value: Any, known: frozenset[str], key: str = "") -> Any:
    if isinstance(value, str):
        return value if value in known or key in _LEVELS else None
    if isinstance(value, dict):
        return {name: _cleared(each, known, name) for name, each in value.items()}
    if isinstance(value, list):
        kept = (each for each in value if not (_is_message(each) and each["text"] not in known))
        return [each for each in (_cleared(item, known, key) for item in kept) if each is not None]
    return value


def _is_message(value: Any) -> bool:
    return isinstance(value, dict) and "code" in value and "text" in value
