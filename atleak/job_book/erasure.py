"""Erase a customer's personal data from the job book for good; what was measured, and the verdicts on it, stay.

What stays of a job is listed; everything else goes. So a field that is added to the record later goes too, until it is
listed.
"""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TypeVar

import sqlalchemy as sa

from atleak.catalogue.controller import Controller
from atleak.catalogue.repairs import PUMP
from atleak.common.errors import AtleakError, BookError, InputError, Place
from atleak.common.sentences import Sentence
from atleak.job.case import OWN_FILES, SLOTS, Case, Reader, SourceFile
from atleak.job.parts import JobFile, JobParts, job_parts
from atleak.job_book.book import Book, JobRow, StoredJob, drop_files, keep_log_table, packed
from atleak.job_book.database import in_words, kept_before
from atleak.job_book.merges import lead, root_of
from atleak.job_book.plain_files import PlainLog, plain_flows, plain_gauges, plain_log, plain_sheet, plain_vacuum
from atleak.job_book.search import Query
from atleak.job_book.tables import customer_links, job_files, jobs, key_of_row, metadata, results, units, visits
from atleak.job_book.units import drop_empty, rows_of_unit, unit_key, unit_of_job
from atleak.measurements.gauge_readings import PressureTable
from atleak.measurements.job_card import Job

_OF_JOB = ("date", "measuring_temperature_c", "pump_side_clearance_um", "pump_tip_clearance_um")
_OF_DECISION = ("decision", "date", "price", "hours")  # besides component, land and repair, which the valve body names
_LEVELS = ("verdict", "decision", "band", "atleak", "measured")  # keys of a result whose words are atleak's own
Of = TypeVar("Of")

_CALLED = {
    "readings": "measuring sheet",
    "pressures": "gauge readings",
    "vacuum": "vacuum test",
    "flows": "flows",
    "road_test": "road-test log",
}
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
        sheet_columns=(),
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
    if case.vacuum is not None:
        vacuum = _read(reader.vacuum, case, controller)
        files["vacuum"] = None if vacuum is None else plain_vacuum(vacuum, controller)
    if case.flows is not None:
        flows = _read(reader.flows, case, controller)
        files["flows"] = None if flows is None else plain_flows(flows, controller)
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
        if each.component not in controller.components and each.component != PUMP:
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
    """Return a result as it was stored, to the last digit, with only the texts that the job without the person has."""
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


_PATIENCE = 5_000  # [ms] with others who read the book while its files are written anew


@dataclass(frozen=True)
class Erased:
    """What became of one job."""

    id: str
    lost: tuple[str, ...] = ()  # files that could not be kept without the person
    left_in: tuple[str, ...] = ()  # catalogue files of the job in which something of the person stands
    deleted: bool = False  # it could not be kept at all


def jobs_of_customer(book: Book, customer: str) -> list[JobRow]:
    """Return the jobs, archived ones too, of the customer with this very name or number.

    Case, spaces and signs do not count; the beginning of a name is not enough.
    """
    wanted = key_of_row(customer)
    if not wanted:
        return []
    near = book.rows(Query(customer=customer, archived=None, limit=None))
    return [row for row in near if wanted in (key_of_row(row.customer), key_of_row(_customer_number(book, row)))]


def _customer_number(book: Book, row: JobRow) -> str:
    return book.load(row.id).file.job.customer.number


def same_vehicle(book: Book, ids: Collection[str]) -> list[JobRow]:
    """Return further jobs, archived ones too, that name a VIN, plate or serial which one of these jobs names."""
    every = book.rows(Query(archived=None, limit=None))
    keys = {key for row in every if row.id in ids for key in _keys_of(row)}
    return [row for row in every if row.id not in ids and keys & _keys_of(row)]


def _keys_of(row: JobRow) -> set[tuple[str, str]]:
    texts = {"vin": row.vin, "plate": row.plate, "serial": row.serial}
    return {(name, key_of_row(text)) for name, text in texts.items() if key_of_row(text)}


def erase(book: Book, ids: Sequence[str], *, delete: bool = False) -> list[Erased]:
    """Take the person out of jobs, all of them or none; nothing of it is left in the database's files afterwards.

    Record, files, file names, photos and every stored result are replaced by what is left without the person; see
    `atleak.job_book.erasure`. Jobs of one transmission stay jobs of one transmission, which no longer has a name.
    Copies elsewhere, backups and exports, are not reached.

    Parameters
    ----------
    delete
        whether a job that this version cannot open or judge goes as a whole.

    Raises
    ------
    BookError
        an id that the book does not have; jobs that cannot be opened or judged, unless they are to be deleted; a
        database that another program is reading, so that its files cannot be swept: the jobs are erased then, and
        erasing again sweeps.
    """
    units_of = {row.id: row.unit for row in book.rows(Query(archived=None, limit=None)) if row.id in ids}
    bare, stuck = _without_persons(book, ids)
    if stuck and not delete:
        raise BookError(
            Sentence("nothing was erased: not every job can be kept without the person"),
            place=Place(file=book.name),
            expected=Sentence("--delete, to delete such jobs as a whole"),
            others=list(stuck.values()),
        )
    with book.writing() as connection:
        families: defaultdict[int, list[str]] = defaultdict(list, {units_of[id]: [] for id in (*bare, *stuck)})
        for id, (stored, left) in bare.items():
            families[stored.unit].append(id)
            _erase(book, connection, id, stored.version, left.parts, sample=stored.sample)
        for id in stuck:
            _delete(connection, id)
        for unit, together in families.items():
            _unname(connection, unit)
            _keep_together(book, connection, together)
        drop_empty(connection)
    sweep(book)
    kept = [Erased(id, left.lost, left.left_in) for id, (_, left) in bare.items()]
    return kept + [Erased(id, deleted=True) for id in stuck]


def _without_persons(
    book: Book, ids: Sequence[str]
) -> tuple[dict[str, tuple[StoredJob, WithoutPerson]], dict[str, InputError]]:
    """Return jobs without their persons, and why there are none of others."""
    bare, stuck = {}, {}
    for id in dict.fromkeys(ids):
        book.version(id)  # one that the book does not have
        try:
            stored = book.load(id)
            bare[id] = stored, without_person(stored.file)
        except AtleakError as error:
            stuck[id] = error if isinstance(error, InputError) else InputError(error.sentence)
    return bare, stuck


def _delete(connection: sa.Connection, id: str) -> None:
    contents = set(connection.execute(sa.select(job_files.c.sha256).where(job_files.c.job == id)).scalars())
    connection.execute(jobs.delete().where(jobs.c.id == id))
    drop_files(connection, contents)


def _erase(book: Book, connection: sa.Connection, id: str, version: int, parts: JobParts, *, sample: bool) -> None:
    """Save a job without the person in the place of the one with him; results and lands stay as they were stored."""
    before = connection.execute(sa.select(jobs).where(jobs.c.id == id)).one()
    saved = book.save_in(connection, parts, id, version, sample, judged=False)
    keep_log_table(connection, id, parts)
    connection.execute(customer_links.delete().where(customer_links.c.job == id))
    stored = connection.execute(sa.select(results).where(results.c.job == id).order_by(results.c.made_at)).all()
    for row in stored:
        values = _result(book, row, parts, last=row is stored[-1])
        connection.execute(results.update().where(results.c.id == row.id).values(**values))
    unchanged = {name: getattr(before, name) for name in ("changed_at", "verdict", "mileage_km")}
    connection.execute(jobs.update().where(jobs.c.id == id).values(erased=saved.version, **unchanged))


def _result(book: Book, row: Any, parts: JobParts, *, last: bool) -> dict[str, Any]:
    record = result_without_person(json.loads(book.unpacked(row.record, Sentence("a result"))), parts)
    hashes = {
        slot: parts.sources[slot].sha256 if last and slot in parts.sources else None
        for slot in ("readings", "road_test")
    }
    return {
        **{f"{slot}_sha256": sha256 for slot, sha256 in hashes.items()},
        "key": parts.case.key if last else "",
        "record": packed(json.dumps(record, ensure_ascii=False).encode()),
    }


# --- units that nothing names any more


def _unname(connection: sa.Connection, unit: int) -> None:
    """Take the keys of a unit away that told it by what no job states any more."""
    rows = connection.execute(sa.select(units).where(units.c.id.in_(rows_of_unit(unit)))).all()
    left = connection.execute(
        sa.select(jobs.c.id, jobs.c.serial, jobs.c.vin, jobs.c.plate)
        .join(visits, visits.c.id == jobs.c.visit)
        .where(visits.c.unit.in_([row.id for row in rows]))
    ).all()
    if not left:
        connection.execute(visits.delete().where(visits.c.unit.in_([row.id for row in rows])))
        connection.execute(units.delete().where(units.c.id.in_([row.id for row in rows])))
        return
    stated = {unit_key(row.id, row.serial, row.vin, row.plate) for row in left}
    for row in rows:
        if row.key not in stated:
            connection.execute(units.update().where(units.c.id == row.id).values(key=f"erased:{row.id}", serial=""))


def _keep_together(book: Book, connection: sa.Connection, ids: Sequence[str]) -> None:
    """Let jobs that were of one unit be of one still."""
    found = [connection.execute(sa.select(jobs.c.visit).where(jobs.c.id == id)).scalar_one() for id in ids]
    if not found:
        return
    first, *others = dict.fromkeys(root_of(connection, book, unit_of_job(connection, visit)) for visit in found)
    for other in others:
        lead(connection, other, first)


# --- the database's own files


def sweep(book: Book) -> None:
    """Write the database's files anew, so that nothing that was deleted is left in them, nor in what an update kept.

    Raises
    ------
    BookError
        where another program reads the book meanwhile.
    """
    with in_words(book.name), book.engine.connect().execution_options(isolation_level="AUTOCOMMIT") as connection:
        if connection.dialect.name == "postgresql":
            for table in metadata.sorted_tables:
                connection.exec_driver_sql(f"VACUUM (FULL, ANALYZE) {table.name}")
            return
        for before in kept_before(Path(str(book.engine.url.database))):
            before.unlink()
        usual = connection.exec_driver_sql("PRAGMA busy_timeout").scalar()
        connection.exec_driver_sql(f"PRAGMA busy_timeout = {_PATIENCE}")
        connection.exec_driver_sql("VACUUM")
        busy = connection.exec_driver_sql("PRAGMA wal_checkpoint(TRUNCATE)").one()[0]
        connection.exec_driver_sql(f"PRAGMA busy_timeout = {usual}")
    if busy:
        raise BookError(
            Sentence("the data are erased, but another program has the job book open: its journal may still hold them"),
            place=Place(file=book.name),
            expected=Sentence("the same command again, with every other atleak closed"),
        )
