"""The job book: save a job whole or not at all, find it again, and notice when two people change the same one."""

from __future__ import annotations

import datetime as dt
import hashlib
import io
import json
import secrets
import zlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import sqlalchemy as sa
from sqlalchemy import exc

from atleak.common.errors import BookError, ChangedElsewhere, ErasedElsewhere, Place
from atleak.common.memory import kept_with
from atleak.common.sentences import Sentence
from atleak.job.parts import JobFile, JobParts
from atleak.job_book.database import database_url, in_words, opened_engine, shown, writing
from atleak.job_book.search import Query, counted_by, found_by, search_words_of
from atleak.job_book.tables import (
    decisions,
    files,
    job_files,
    jobs,
    lands,
    log_tables,
    put_once,
    replace_rows,
    results,
    search_words,
    visits,
)
from atleak.job_book.units import drop_empty, unit_of_job, visit_for
from atleak.measurements.road_test import RoadTest
from atleak.version import __version__


def log_table(log: RoadTest) -> bytes:
    """Return a log's channels on its common base of time as Parquet: one column a quantity, in SI, NaN where missing.

    Temperatures are in °C and speeds in revolutions per second.
    """
    return kept_with(log, "table", "", lambda: _written(log))  # a job is saved many times with one log


def _written(log: RoadTest) -> bytes:
    import pyarrow as pa  # most jobs that are looked up need none
    import pyarrow.parquet as pq

    columns = pa.table({"time": log.time, **{quantity: log.values(quantity) for quantity in log.channels}})
    target = io.BytesIO()
    pq.write_table(columns, target, compression="zstd", use_dictionary=False, use_byte_stream_split=True)
    return target.getvalue()


PICTURE = "picture"  # the slot of a picture
_LARGE, _ZSTD = 1_000_000, b"\x28\xb5\x2f\xfd"  # bytes of a file that is packed fast, and how it then begins
_TRIES = 3  # at a save that another one crossed
_DEADLOCK = "40P01"  # PostgreSQL's code of it
LAND_COLUMNS = [column.name for column in lands.c if column.name not in ("id", "job", "measured")]


@dataclass(frozen=True)
class Saved:
    """What was saved: under which id, and as which version of it."""

    id: str  # of the job
    version: int  # counted from 1, one more at each save


@dataclass(frozen=True)
class JobRow:
    """A job as the book lists it."""

    id: str  # of the job
    number: str  # of the workshop
    vin: str  # of the vehicle
    plate: str  # registration of the vehicle
    serial: str  # of the transmission
    customer: str  # name
    date: dt.date | None  # of the job
    controller: str  # id of the type
    verdict: str  # of the unit
    mileage_km: float | None  # of the vehicle
    unit: int  # the unit's id
    visit: int  # the visit's id
    made_on: dt.date | None  # when it was first saved
    changed_at: dt.datetime  # when it was last saved
    archived_at: dt.datetime | None  # None: not archived
    sample: bool  # made of the sample data

    @property
    def order(self) -> tuple[dt.date, float, dt.datetime]:
        """Return by what the visits of a unit follow one another."""
        return self.date or self.made_on or dt.date.min, self.mileage_km or 0.0, self.changed_at

    @property
    def in_words(self) -> Sentence:
        """Return whose job it is, in words."""
        parts = [part for part in (self.number, self.customer, self.date, self.plate, self.vin, self.serial) if part]
        return Sentence("{parts}", parts=parts) if parts else Sentence("job {id}, which names nobody", id=self.id)


@dataclass(frozen=True)
class StoredJob:
    """A job as the book holds it: the content of ``job.json``, files by slot, pictures by name, the last result."""

    id: str  # of the job
    version: int  # counted from 1, one more at each save
    date: dt.date | None  # as the record states it
    made_at: dt.datetime  # when it was first saved
    made_on: dt.date | None  # that day in the workshop
    changed_at: dt.datetime  # when it was last saved
    archived_at: dt.datetime | None  # None: not archived
    sample: bool  # made of the sample data
    unit: int  # the unit's id
    name: Sentence  # for messages
    choices: bytes  # the content of ``job.json``
    sources: Mapping[str, bytes]  # files by slot
    pictures: Mapping[str, bytes]  # by name
    result: dict[str, Any]  # the last one, as JSON has it
    result_by: str  # version of atleak that gave the result

    @cached_property
    def file(self) -> JobFile:
        """Return record, case and the result as it was stored.

        Raises
        ------
        InputError
            a job that this version cannot open.
        """
        return JobFile.of(self.choices, self.sources, self.pictures, self.result, name=self.name)


def open_book(url: str | None = None) -> Book:
    """Open the job book, and make it where there is none yet.

    Parameters
    ----------
    url
        a SQLAlchemy URL of SQLite or PostgreSQL; unless given, that of ``ATLEAK_DATABASE_URL``, else a file in the
        user's folder.

    Raises
    ------
    BookError
        a database that cannot be opened or written, or that a newer atleak has made.
    """
    where = database_url(url)
    return Book(opened_engine(where), shown(where))


class Book:
    """An open job book. It can be shared between threads."""

    def __init__(self, engine: sa.Engine, name: str) -> None:
        self.engine, self.name = engine, name
        # PostgreSQL shows each statement of a transaction another state of the book unless it is asked not to
        one_moment = {"isolation_level": "REPEATABLE READ"} if engine.dialect.name == "postgresql" else {}
        self._reader = engine.execution_options(**one_moment)

    @contextmanager
    def reading(self) -> Iterator[sa.Connection]:
        """Open a transaction that sees the book as it is at one moment.

        Raises
        ------
        BookError
            where the database cannot be used.
        """
        with in_words(self.name), self._reader.begin() as connection:
            yield connection

    @contextmanager
    def writing(self) -> Iterator[sa.Connection]:
        """Open a transaction that writes all or nothing.

        Raises
        ------
        BookError
            where the database cannot be used.
        """
        with in_words(self.name), writing(self.engine) as connection:
            yield connection

    def save(
        self,
        parts: JobParts,
        *,
        id: str | None = None,
        version: int | None = None,
        sample: bool = False,
        kept: Mapping[str, Any] | None = None,
    ) -> Saved:
        """Save a job whole: when this returns, the job is safe; when it raises, the book is as it was.

        Parameters
        ----------
        parts
            the job with its result.
        id
            of a job of the book; None makes a new one.
        version
            of that job, as it was last seen here.
        sample
            whether the job was made of the shipped sample.
        kept
            ``archived_at`` and ``made_on`` of a new job that another book held.

        Raises
        ------
        ChangedElsewhere
            the book holds another version of the job, or does not hold it any more; `ErasedElsewhere` where its
            customer was erased since that version.
        BookError
            the database cannot be used.
        """
        with self.reading() as connection:
            known = id is not None and _has_result(connection, id, parts)
        if not known:
            _ = parts.result  # takes a second: computed before anybody has to wait for this transaction
        for left in reversed(range(_TRIES)):
            try:
                with self.writing() as connection:
                    return self.save_in(connection, parts, id, version, sample, kept)
            except BookError as error:
                if not _crossed(error) or not left:
                    raise
        raise AssertionError("the last try raises")

    def save_in(
        self,
        connection: sa.Connection,
        parts: JobParts,
        id: str | None,
        version: int | None,
        sample: bool,
        kept: Mapping[str, Any] | None = None,
        *,
        judged: bool = True,
    ) -> Saved:
        """Save a job as part of a transaction that writes more, ``judged`` with its result; `save` says the rest."""
        now = dt.datetime.now(dt.UTC)
        earlier = None if id is None else self._row(connection, id, lock=True)
        if earlier is not None and earlier.version != version:
            _refuse_erased(earlier, version)
            raise ChangedElsewhere(_saved_elsewhere(earlier))
        saved = Saved(id or secrets.token_hex(8), 1 if earlier is None else earlier.version + 1)
        contents = {source.sha256: source.content for source in parts.sources.values()}
        pictures = {name: hashlib.sha256(content).hexdigest() for name, content in parts.pictures.items()}
        contents |= {pictures[name]: content for name, content in parts.pictures.items()}
        _keep_files(connection, contents)
        record, before = parts.job, None if earlier is None else earlier.visit
        unit = sa.select(visits.c.unit).where(visits.c.id == before)
        left = None if before is None else (before, connection.execute(unit).scalar_one())
        values: dict[str, Any] = {
            "version": saved.version,
            "visit": visit_for(connection, saved.id, parts, before),
            "sample": sample,
            "changed_at": now,
            "choices": packed(parts.choices.model_dump_json(exclude_defaults=True).encode()),
            "number": record.number[:80],
            "date": record.date,
            "technician": record.technician,
            "customer": record.customer.name,
            "vin": record.vehicle.vin[:80],
            "plate": record.vehicle.registration[:80],
            "serial": record.transmission.serial[:80],
            "mileage_km": record.mileage_or(parts.diagnosis.mileage),
            "controller": parts.diagnosis.controller.id,
            "verdict": str(parts.diagnosis.verdict),
        }
        if left is None:
            made = {"made_at": now, "made_on": now.astimezone().date(), **(kept or {})}
            connection.execute(jobs.insert().values(id=saved.id, **made, **values))
        else:
            connection.execute(jobs.update().where(jobs.c.id == saved.id).values(**values))
            drop_empty(connection, left)
        held = [(slot, source.name, source.sha256) for slot, source in parts.sources.items()]
        held += [(PICTURE, name, sha256) for name, sha256 in pictures.items()]
        _keep_list(connection, saved.id, held)
        words = [{"field": field, "word": word} for field, word in sorted(search_words_of(record))]
        replace_rows(connection, search_words, saved.id, words)
        decided = [_decision(each.model_dump()) for each in record.repair_decisions]
        replace_rows(connection, decisions, saved.id, decided)
        if judged and not _has_result(connection, saved.id, parts):
            _keep_result(connection, saved.id, parts, now)
            keep_log_table(connection, saved.id, parts)
        return saved

    def load(self, id: str) -> StoredJob:
        """Return a job of the book, as it was saved.

        Returns
        -------
        StoredJob
            choices, files, pictures and the last result.

        Raises
        ------
        BookError
            an id that the book does not have; a job that was damaged in the database.
        """
        with self.reading() as connection:
            row = self._row(connection, id)
            called, unit = _called(row), unit_of_job(connection, row.visit)
            kept = connection.execute(
                sa.select(job_files.c.slot, job_files.c.name, files.c.sha256, files.c.content)
                .join(files, files.c.sha256 == job_files.c.sha256)
                .where(job_files.c.job == row.id)
            ).all()
            result = connection.execute(
                sa.select(results.c.record, results.c.atleak)
                .where(results.c.job == row.id)
                .order_by(results.c.made_at.desc(), results.c.id.desc())
                .limit(1)
            ).one_or_none()
            if result is None:
                problem = Sentence("the stored result of {job} is missing", job=called)
                raise BookError(problem, place=Place(file=self.name))
        contents = {(each.slot, each.name): self._whole(each, called) for each in kept}
        names = ("id", "version", "date", "made_at", "made_on", "changed_at", "archived_at", "sample")
        return StoredJob(
            **{name: getattr(row, name) for name in names},
            unit=unit,
            name=called,
            choices=self.unpacked(row.choices, called),
            sources={slot: content for (slot, _), content in contents.items() if slot != PICTURE},
            pictures={name: content for (slot, name), content in contents.items() if slot == PICTURE},
            result=json.loads(self.unpacked(result.record, called)),
            result_by=result.atleak,
        )

    def version(self, id: str) -> int:
        """Return the version of a job, without loading it.

        Raises
        ------
        BookError
            an id that the book does not have.
        """
        with self.reading() as connection:
            row = self._row(connection, id)
        return int(row.version)

    def refuse_erased(self, id: str, version: int) -> None:
        """Refuse what was seen of a job before its customer was erased; a job that is not there was not erased.

        Raises
        ------
        ErasedElsewhere
            the customer was erased after that version.
        """
        with self.reading() as connection:
            row = connection.execute(sa.select(jobs.c.erased).where(jobs.c.id == id)).one_or_none()
        if row is not None:
            _refuse_erased(row, version)

    def rows(self, query: Query | None = None) -> list[JobRow]:
        """Return the jobs that a query asks for, the last changed one first.

        Parameters
        ----------
        query
            what to look for; unless given, the last changed jobs that are not archived.

        Returns
        -------
        list
            a `JobRow` for each job, as many as the query's limit allows.

        Raises
        ------
        BookError
            where the database cannot be used.
        """
        with self.reading() as connection:
            found = connection.execute(found_by(connection, query or Query())).mappings().all()
        return [JobRow(**row) for row in found]

    def count(self, query: Query | None = None) -> int:
        """Return how many jobs a query asks for, whatever its limit.

        Parameters
        ----------
        query
            what to look for; unless given, all jobs that are not archived.

        Raises
        ------
        BookError
            where the database cannot be used.
        """
        with self.reading() as connection:
            return int(connection.execute(counted_by(connection, query or Query())).scalar_one())

    def archive(self, id: str, *, back: bool = False) -> None:
        """Take a job out of lists and statistics, or put it back.

        Raises
        ------
        BookError
            an id that the book does not have.
        """
        with self.writing() as connection:
            self._row(connection, id)
            moment = None if back else dt.datetime.now(dt.UTC)
            connection.execute(jobs.update().where(jobs.c.id == id).values(archived_at=moment))

    def _row(self, connection: sa.Connection, id: str, *, lock: bool = False) -> Any:
        wanted = sa.select(jobs).where(jobs.c.id == id)
        row = connection.execute(wanted.with_for_update() if lock else wanted).one_or_none()
        if row is None:
            missing = ChangedElsewhere if lock else BookError  # what is to be saved was opened once: it is gone since
            raise missing(Sentence("the job book has no such job"), place=Place(file=self.name), value=id)
        return row

    def _whole(self, row: Any, called: str) -> bytes:
        content = self.unpacked(row.content, called)
        if hashlib.sha256(content).hexdigest() != row.sha256:
            problem = Sentence("{file} of {job} was damaged in the database", file=row.name, job=called)
            raise BookError(problem, place=Place(file=self.name))
        return content

    def unpacked(self, content: bytes, called: str) -> bytes:
        """Return content as it came.

        Raises
        ------
        BookError
            naming what was damaged in the database.
        """
        try:
            if content.startswith(_ZSTD):
                import pyarrow as pa

                return bytes(pa.CompressedInputStream(pa.BufferReader(content), "zstd").read())
            return zlib.decompress(content)
        except (zlib.error, OSError) as error:
            problem = Sentence("{what} was damaged in the database", what=called)
            raise BookError(problem, place=Place(file=self.name)) from error


def packed(content: bytes) -> bytes:
    """Return content as the book keeps it: compressed; what is large, in a twentieth of the time."""
    if len(content) < _LARGE:
        return zlib.compress(content)
    import pyarrow as pa

    return bytes(pa.Codec("zstd", compression_level=1).compress(content, asbytes=True))


def _crossed(error: BookError) -> bool:
    """Tell whether a save failed by another one: it has just dropped a file, or each waited for the other."""
    cause = error.__cause__
    waited = isinstance(cause, exc.OperationalError) and getattr(cause.orig, "sqlstate", None) == _DEADLOCK
    return waited or isinstance(cause, exc.IntegrityError)


def local_time(moment: dt.datetime) -> str:
    """Return a moment as the clock here shows it, with its zone: 2026-04-17 18:30-06:00."""
    return moment.astimezone().isoformat(" ", "minutes")


def _saved_elsewhere(row: Any) -> Sentence:
    at = local_time(row.changed_at)
    if not row.technician:
        return Sentence("this job was saved elsewhere at {at}, after it was opened here", at=at)
    who = row.technician
    return Sentence("this job was saved elsewhere by {who} at {at}, after it was opened here", who=who, at=at)


def _refuse_erased(row: Any, version: int | None) -> None:
    if row.erased is not None and (version or 0) < row.erased:
        raise ErasedElsewhere(
            Sentence(
                "the customer was erased from this job after it was opened here, so nothing of what is here can be "
                "saved: what was typed since has to be typed again into the newer state"
            )
        )


def _called(row: Any) -> Sentence:
    return Sentence("job {name}", name=row.number or row.id)


def _keep_files(connection: sa.Connection, contents: Mapping[str, bytes]) -> None:
    """Put files into the book that it does not hold yet."""
    held = set(connection.execute(sa.select(files.c.sha256).where(files.c.sha256.in_(contents))).scalars())
    for sha256, content in contents.items():
        if sha256 not in held:
            values = {"sha256": sha256, "size": len(content), "content": packed(content)}
            put_once(connection, files, values)


def _keep_list(connection: sa.Connection, id: str, held: list[tuple[str, str, str]]) -> None:
    """Write down which files a job has; contents that no job has any more go."""
    columns = job_files.c.slot, job_files.c.name, job_files.c.sha256
    earlier = {tuple(row) for row in connection.execute(sa.select(*columns).where(job_files.c.job == id))}
    if earlier == set(held):
        return
    replace_rows(
        connection, job_files, id, [{"slot": slot, "name": name, "sha256": sha256} for slot, name, sha256 in held]
    )
    dropped = {sha256 for _, _, sha256 in earlier} - {sha256 for _, _, sha256 in held}
    drop_files(connection, dropped)


def drop_files(connection: sa.Connection, sha256s: set[str]) -> None:
    """Delete contents that no job has any more, of those given."""
    used = sa.select(job_files.c.sha256).where(job_files.c.sha256 == files.c.sha256)
    if sha256s:
        connection.execute(files.delete().where(files.c.sha256.in_(sha256s), ~sa.exists(used)))


def _decision(row: Mapping[str, Any]) -> dict[str, Any]:
    values = {column.name: row[column.name] for column in decisions.c if column.name in row}
    return {**values, "decision": row["decision"] or ""}


def _has_result(connection: sa.Connection, id: str, parts: JobParts) -> bool:
    """Tell whether the last result of a job is by this version of atleak, of the same files and choices."""
    newest = sa.select(results.c.atleak, results.c.key).where(results.c.job == id)
    newest = newest.order_by(results.c.made_at.desc(), results.c.id.desc()).limit(1)
    return bool(connection.execute(newest).one_or_none() == (__version__, parts.case.key))


def _keep_result(connection: sa.Connection, id: str, parts: JobParts, now: dt.datetime) -> None:
    """Write down what this version of atleak says, in the place of what it said before."""
    mine = (results.c.job == id) & (results.c.atleak == __version__)
    record = parts.result
    connection.execute(results.delete().where(mine))
    connection.execute(
        results.insert().values(
            job=id,
            atleak=__version__,
            made_at=now,
            key=parts.case.key,
            profile=parts.diagnosis.profile.name,
            controller_sha256=record["controller"]["sha256"],
            fluid_sha256=record["fluid"]["sha256"],
            readings_sha256=record["readings"]["sha256"],
            road_test_sha256=parts.sources["road_test"].sha256 if "road_test" in parts.sources else None,
            verdict=str(record["verdict"]),
            record=packed(json.dumps(record, ensure_ascii=False).encode()),
        )
    )
    rows = [
        {name: land[name] for name in LAND_COLUMNS} | {"measured": land["measured"] == "measured"}
        for land in record["lands"]
    ]
    replace_rows(connection, lands, id, rows)


def keep_log_table(connection: sa.Connection, id: str, parts: JobParts) -> None:
    """Write down the channels of a job's log, in the place of those of an earlier one."""
    log = parts.diagnosis.log.road_test if parts.diagnosis.log else None
    rows = [] if log is None else [{"sha256": log.sha256, "rows": log.rows, "parquet": log_table(log)}]
    replace_rows(connection, log_tables, id, rows)
