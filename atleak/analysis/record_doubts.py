"""Relate a job's record to its measuring sheet, its repairs and its result, and doubt what does not agree.

The head of a sheet fills the record, what the record says of measuring fills a case, and decisions about repairs are
related to the lands that they cover.
"""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import Any

from atleak.analysis.pressures import behind_limits
from atleak.catalogue.controller import Controller
from atleak.catalogue.instruments import Instrument, Part
from atleak.catalogue.repairs import PUMP, LandKey
from atleak.common.errors import InputError, Message, Place, unknown
from atleak.common.sentences import Name, Sentence
from atleak.common.translations import languages
from atleak.common.units import Quantity
from atleak.common.wording import wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.land import LandDiagnosis
from atleak.measurements.job_card import InstrumentUsed, Job, RepairDecision
from atleak.measurements.own_forms import TYPED
from atleak.measurements.readings import Readings, SheetIdentity
from atleak.readers.sheets.words import plain, text_of


def with_sheet(job: Job | None, readings: Readings | None) -> Job | None:
    """Return the record with what the sheet's head says where the record says nothing; None where neither does.

    Nothing is taken of a sheet whose head names another job or unit: `sheet_doubts` asks whose it is.
    """
    if readings is None or (readings.identity.empty and readings.date is None):
        return job
    head, record = readings.identity, job or Job()
    if any(_contradictions(record, head)):
        return job
    vehicle = record.vehicle
    of_vehicle = {
        "model": vehicle.model or ("" if vehicle.make else head.vehicle),
        "vin": vehicle.vin or head.vin,
        "mileage_km": head.mileage if vehicle.mileage_km is None else vehicle.mileage_km,
    }
    changes = {
        "number": record.number or head.job,
        "date": record.date or readings.date,
        "technician": record.technician or head.technician,
        "vehicle": vehicle.model_copy(update=of_vehicle),
        "transmission": record.transmission.model_copy(update={"serial": record.transmission.serial or head.serial}),
        "instruments": record.instruments or tuple(InstrumentUsed(name=name) for name in head.instruments),
    }
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

    The notes then say so. Only a number that is to the letter what 0.2.0 made of this very file of readings goes.
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
    number = text_of(row[1].partition(":")[2]) if row[:1] == [TYPED.mark] and len(row) > 1 else ""
    return number if 0 < len(number) <= 200 else None  # signs: 0.2.0 took no longer text for a field


def check_decisions(job: Job, controller: Controller, file: str = "job record") -> None:
    """Check that every repair decision is about a component, a land and a repair that the valve body has.

    Raises
    ------
    InputError
        the first that is not, with its number, its value, and the nearest name.
    """
    fault = next(decision_faults(job, controller, file), None)
    if fault is not None:
        raise fault


def decision_faults(job: Job, controller: Controller, file: str = "job record") -> Iterator[InputError]:
    """Return what is wrong with each decision on a component, land or repair that the valve body does not have."""
    for number, decision in enumerate(job.repair_decisions, start=1):
        place = Place(file=file, table=f"repair_decisions {number}")
        if decision.component and decision.component not in _parts(controller):
            problem = Sentence("{controller} has no such component", controller=Name(controller.name))
            yield unknown(problem, decision.component, _parts(controller), place=place)
            continue
        lands = [land.key[1] for land in controller.lands_of(decision.component)] if decision.component else []
        if decision.land is not None and decision.land not in lands:
            problem = Sentence("a decision without a component has no such land")
            if decision.component:
                problem = Sentence("component {component} has no such land", component=decision.component)
            expected = Sentence("the component that it belongs to")
            if lands:
                expected = Sentence("one of its lands: {lands}", lands=lands)
            yield InputError(problem, place=place, value=decision.land, expected=expected)
        repairs = {repair.id: repair for repair in controller.repairs}
        if decision.repair and decision.repair not in repairs:
            problem = Sentence("{controller} names no such repair", controller=Name(controller.name))
            yield unknown(problem, decision.repair, repairs, place=place)
        elif decision.repair and decision.component not in ("", *repairs[decision.repair].components):
            of = {"repair": decision.repair, "component": decision.component}
            problem = Sentence("repair {repair} is none of component {component}", **of)
            expected = Sentence("component {component}", component=repairs[decision.repair].components)
            yield InputError(problem, place=place, expected=expected)


def _parts(controller: Controller) -> tuple[str, ...]:
    """Return what a record can be about: the components, and the pump."""
    return (*controller.components, PUMP)


def is_of_pump(decision: RepairDecision, controller: Controller) -> bool:
    """Tell whether a decision is about the pump; one that names a component of that id is about the component."""
    repair = next((each for each in controller.repairs if each.id == decision.repair), None)
    if repair is not None:
        return repair.of_pump
    return decision.component == PUMP and PUMP not in controller.components


def components_of(decision: RepairDecision, controller: Controller) -> tuple[str, ...]:
    """Return the components that a decision is about: all of those that a kit mends, or its own."""
    repair = next((each for each in controller.repairs if each.id == decision.repair), None)
    return repair.components if repair is not None else (decision.component,)


def covered(decision: RepairDecision, controller: Controller) -> frozenset[LandKey]:
    """Return the lands that a decision is about: those that its repair changes, its land, or all of its component."""
    repair = next((each for each in controller.repairs if each.id == decision.repair), None)
    if repair is not None:
        return frozenset(repair.lands)
    lands = controller.lands_of(decision.component) if decision.component in controller.components else ()
    return frozenset(land.key for land in lands if decision.land in (None, land.key[1]))


def repaired_lands(job: Job, controller: Controller) -> frozenset[LandKey]:
    """Return the lands that were repaired, by the record; one that was only cleaned keeps its wear."""
    cleaned = {repair.id for repair in controller.repairs if repair.keeps_clearance}
    done = (each for each in job.repair_decisions if each.decision == "done" and each.repair not in cleaned)
    return frozenset[LandKey]().union(*(covered(each, controller) for each in done))


def undecided(diagnosis: Diagnosis, job: Job, *, closing: bool = False) -> tuple[LandDiagnosis, ...]:
    """Return the lands to be replaced about which nothing was decided, the worst first.

    Parameters
    ----------
    closing
        the job is handed over: a repair that is only proposed is then open too.
    """
    decided = frozenset[LandKey]().union(
        *(covered(decision, diagnosis.controller) for decision in _settled(job, closing=closing))
    )
    return tuple(
        land for land in diagnosis.flagged if diagnosis.urgency_of(land).calls_for_repair and land.key not in decided
    )


def pump_undecided(diagnosis: Diagnosis, job: Job, *, closing: bool = False) -> bool:
    """Tell whether the pump is to be replaced and nothing was decided about it."""
    if not diagnosis.pump.verdict.calls_for_repair or PUMP in diagnosis.controller.components:
        return False
    return not any(is_of_pump(each, diagnosis.controller) for each in _settled(job, closing=closing))


def _settled(job: Job, *, closing: bool) -> Iterator[RepairDecision]:
    settled = {"approved", "done", "declined", "deferred", *(() if closing else ("proposed",))}
    return (each for each in job.repair_decisions if each.decision in settled)


def without_reason(job: Job) -> tuple[RepairDecision, ...]:
    """Return the repairs that the workshop noted as declined without writing down why."""
    declined = (each for each in job.repair_decisions if each.decision == "declined")
    return tuple(each for each in declined if not each.reason and not each.decided_by)


_WORD = re.compile(r"[^\W\d_]{3,}")  # neither a size nor a serial number tells instruments apart
_PARTS: Mapping[Part, Sentence] = MappingProxyType({"spool": Sentence("spools"), "sleeve": Sentence("sleeves")})


def record_doubts(job: Job, diagnosis: Diagnosis) -> tuple[Message, ...]:
    """Return what is doubtful about a record, each a warning: nothing of it changes the result."""
    return (
        *_unknown_parts(job, diagnosis),
        *_other_instruments(job, diagnosis),
        *_needless(job, diagnosis),
        *sheet_doubts(job, diagnosis.readings, diagnosis.mileage),
    )


def _unknown_parts(job: Job, diagnosis: Diagnosis) -> Iterator[Message]:
    """Doubt decisions, scratches and photos of parts that the valve body does not have, with the nearest name."""
    controller = diagnosis.controller
    for each in decision_faults(job, controller):
        yield Message("warning", "record_unknown_part", each.sentence)
    stated = {
        "scratches": [each.component for each in job.scratches],
        "photos": [each.component for each in job.photos],
    }
    for table, components in stated.items():
        for number, component in enumerate(components, start=1):
            if component and component not in _parts(controller):
                place = Place(file="job record", table=f"{table} {number}")
                problem = Sentence("{controller} has no such component", controller=Name(controller.name))
                fault: InputError = unknown(problem, component, _parts(controller), place=place)
                yield Message("warning", "record_unknown_part", fault.sentence)


def needless_work(job: Job, diagnosis: Diagnosis) -> Iterator[RepairDecision]:
    """Return the work still to be done on lands of which none is past a limit, nor behind one that is passed."""
    asked = behind_limits(diagnosis)
    for each in job.repair_decisions if diagnosis.judged else ():
        keys = covered(each, diagnosis.controller)
        if each.decision in ("proposed", "approved") and keys and not keys & asked:
            yield each


def _needless(job: Job, diagnosis: Diagnosis) -> Iterator[Message]:
    for each in needless_work(job, diagnosis):
        keys, components = sorted(covered(each, diagnosis.controller)), diagnosis.controller.components
        names = tuple(Name(components[component]) for component in dict.fromkeys(component for component, _ in keys))
        text = Sentence(
            "{component} ({lands}): work is decided here that no limit asks for. None of these lands is past a limit, "
            "nor behind a total or pressure that is.",
            component=names,
            lands=[f"{component}/{land}" for component, land in keys],
        )
        yield Message("warning", "work_without_need", text)


def _other_instruments(job: Job, diagnosis: Diagnosis) -> Iterator[Message]:
    """Doubt that the instruments of the record are those by which the uncertainty was computed."""
    used = tuple(each for each in job.instruments if each.name)
    uncertainty = diagnosis.uncertainty
    if not used or uncertainty is None:
        return
    taken = [uncertainty.instruments.of(part) for part in _PARTS]
    if all(any(_alike(each, instrument) for instrument in taken) for each in used):
        return  # one is named, and it is one of the two
    for (part, what), instrument in zip(_PARTS.items(), taken, strict=True):
        if not any(_alike(each, instrument) for each in used):
            text = Sentence(
                "Measured with {used}, as the job's record or the measuring sheet's head says, but the uncertainty "
                "of the {parts} is computed with {taken}: choose the instrument with which they were measured (page "
                "Settings, --{part}-instrument), or correct its name.",
                used=tuple(each.name for each in used),
                parts=what,
                taken=Name(instrument.name),
                part=part,
            )
            yield Message("warning", "instruments_differ", text)


def _alike(used: InstrumentUsed, taken: Instrument) -> bool:
    """Tell whether a name of the record can be an instrument's in any language: one has all words of the other."""
    mine = _words(used.name)
    names = (taken.id, taken.name, *(wording(language).name(taken.name) for language in languages()))
    return any(mine <= words or words <= mine for words in map(_words, names) if words and mine)


def _words(name: str) -> frozenset[str]:
    return frozenset(word.casefold() for word in _WORD.findall(name.replace("_", " ")))
