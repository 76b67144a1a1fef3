"""Erase a customer's personal data from the job book for good; what was measured, and the verdicts on it, stay."""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import sqlalchemy as sa

from atleak.errors import AtleakError, BookError, InputError, Place
from atleak.job.parts import JobParts
from atleak.jobs.book import Book, JobRow, StoredJob, drop_files, keep_log_table, packed
from atleak.jobs.merge import lead, root_of
from atleak.jobs.opening import in_words, kept_before
from atleak.jobs.search import Query
from atleak.jobs.tables import job_files, jobs, key_of, metadata, results, units, visits
from atleak.jobs.units import drop_empty, rows_of_unit, unit_key, unit_of
from atleak.jobs.without_person import WithoutPerson, result_without_person, without_person
from atleak.sentence import Sentence

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
    wanted = key_of(customer)
    if not wanted:
        return []
    near = book.rows(Query(customer=customer, archived=None, limit=None))
    return [row for row in near if wanted in (key_of(row.customer), key_of(_customer_number(book, row)))]


def _customer_number(book: Book, row: JobRow) -> str:
    return book.load(row.id).file.job.customer.number


def same_vehicle(book: Book, ids: Collection[str]) -> list[JobRow]:
    """Return further jobs, archived ones too, that name a VIN, plate or serial which one of these jobs names."""
    every = book.rows(Query(archived=None, limit=None))
    keys = {key for row in every if row.id in ids for key in _keys_of(row)}
    return [row for row in every if row.id not in ids and keys & _keys_of(row)]


def _keys_of(row: JobRow) -> set[tuple[str, str]]:
    texts = {"vin": row.vin, "plate": row.plate, "serial": row.serial}
    return {(name, key_of(text)) for name, text in texts.items() if key_of(text)}


def erase(book: Book, ids: Sequence[str], *, delete: bool = False) -> list[Erased]:
    """Take the person out of jobs, all of them or none; nothing of it is left in the database's files afterwards.

    Record, files, file names, photos and every stored result are replaced by what is left without the person; see
    `atleak.jobs.without_person`. Jobs of one transmission stay jobs of one transmission, which no longer has a name.
    Copies elsewhere, backups and exports, are not reached.

    Parameters
    ----------
    ids
        of the jobs.
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
    first, *others = dict.fromkeys(root_of(connection, book, unit_of(connection, visit)) for visit in found)
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
