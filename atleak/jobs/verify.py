"""Check that every job of a book opens and that its stored result is whole."""

from __future__ import annotations

import io
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import sqlalchemy as sa
from sqlalchemy import exc

from atleak.errors import AtleakError, BookError
from atleak.jobs.book import LAND_COLUMNS, Book, StoredJob
from atleak.jobs.opening import in_words, opened_engine, writing
from atleak.jobs.rows import copy_rows
from atleak.jobs.tables import jobs, lands, log_tables, results, units
from atleak.sentence import Sentence
from atleak.verdicts import level_named


@dataclass(frozen=True)
class Fault:
    """What is wrong with a job, or with the book's file as a whole."""

    problem: Sentence
    id: str | None = None  # of the job
    number: str = ""  # which the workshop gave it

    @property
    def sentence(self) -> Sentence:
        """Return what is wrong, and with which job."""
        if self.id is None:
            return self.problem
        called = Sentence("job {name}", name=self.number or self.id)
        if self.number:
            called = Sentence("{job} ({id})", job=called, id=self.id)
        return Sentence("{where}: {problem}", where=called, problem=self.problem)

    def __str__(self) -> str:
        return str(self.sentence)


def verify(book: Book) -> tuple[Fault, ...]:
    """Return what is wrong with a book: nothing where it can be restored, and every job opens with a whole result.

    Archived jobs are checked too. A job is opened with every file of it against its SHA-256, and its result compared
    with the lands, the hashes and the log that the tables hold of it. All rows are put into a new book in memory as
    `atleak.jobs.backup.restore` does.

    Raises
    ------
    BookError
        a database that cannot be read at all.
    """
    faults = [Fault(Sentence("the file is damaged: {reason}", reason=reason)) for reason in _damage(book)]
    with book.reading() as connection:
        every = connection.execute(sa.select(jobs.c.id, jobs.c.number).order_by(jobs.c.id)).all()
    for id, number in every:
        faults += [Fault(problem, id, number) for problem in problems_of(book, id)]
    return tuple(faults or map(Fault, _restored(book)))


def _damage(book: Book) -> Iterator[str]:
    """Say what SQLite finds wrong with the file's pages and references; a server looks after its own."""
    if book.engine.dialect.name != "sqlite":
        return
    with book.reading() as connection:
        said = list(connection.exec_driver_sql("PRAGMA integrity_check(10)").scalars())
        yield from said if said != ["ok"] else []
        for table, row, other, _ in connection.exec_driver_sql("PRAGMA foreign_key_check"):
            yield Sentence("row {row} of {table} refers to no row of {other}", row=row, table=table, other=other)


def _restored(book: Book) -> Iterator[Sentence]:
    """Put all rows into a new book in memory, and say where that fails or a unit leads to one that is none."""
    engine = opened_engine(sa.URL.create("sqlite", database=":memory:"))
    try:
        problem = Sentence("a backup of it cannot be restored")
        with book.reading() as rows, in_words(book.name, problem), writing(engine) as copy:
            copy_rows(rows, copy, contents=False)
            led = copy.execute(sa.select(units.c.id, units.c.merged_into, units.c.merged_with)).all()
    except BookError as error:
        yield error.sentence
        return
    finally:
        engine.dispose()
    merged = {row.id: (row.merged_into, row.merged_with) for row in led}
    for row, (into, other) in merged.items():
        where = None if other is None else merged[other][0] or other
        if into != where or (into is not None and merged[into][0] is not None):
            yield Sentence("unit {row} leads to {other}, which is no unit of its own", row=row, other=into)


def problems_of(book: Book, id: str) -> Iterator[Sentence]:
    """Say what is wrong with one job, as `verify` does of every one."""
    try:
        stored = book.load(id)
        yield from _result_problems(book, stored)
    except exc.NoResultFound:
        yield Sentence("its visit is missing")
    except (AtleakError, ValueError, KeyError, TypeError) as error:
        if _is_there(book, id):  # and was not erased meanwhile
            reason = error.sentence if isinstance(error, AtleakError) else None
            yield reason or Sentence("its stored result cannot be read: {reason}", reason=str(error))


def _is_there(book: Book, id: str) -> bool:
    with book.reading() as connection:
        return connection.execute(sa.select(jobs.c.id).where(jobs.c.id == id)).scalar() is not None


def _result_problems(book: Book, stored: StoredJob) -> Iterator[Sentence]:
    record, case = stored.file.result, stored.file.case
    with book.reading() as connection:
        of_job = results.c.job == stored.id
        newest = sa.select(results).where(of_job).order_by(results.c.made_at.desc(), results.c.id.desc()).limit(1)
        result = connection.execute(newest).one()
        columns = [lands.c[name] for name in LAND_COLUMNS]
        kept = connection.execute(sa.select(*columns).where(lands.c.job == stored.id)).mappings().all()
        log = connection.execute(sa.select(log_tables).where(log_tables.c.job == stored.id)).one_or_none()
    if record["verdict"] != result.verdict:
        said = level_named(record["verdict"]), level_named(result.verdict)
        yield Sentence("its stored result says {verdict}, its row {other}", verdict=said[0], other=said[1])
    if _by_land(kept) != _by_land(record["lands"]):
        yield Sentence("the lands of its stored result are not those of its rows")
    held = {name: None if source is None else source.sha256 for name, source in vars(case).items() if name in _OWN}
    for name, sha256 in (("readings", result.readings_sha256), ("road_test", result.road_test_sha256)):
        if sha256 is not None and sha256 != held[name]:
            yield _OWN[name]
    if log is not None:
        yield from _log_problems(log, held["road_test"])


_OWN = {
    "readings": Sentence("its stored result rests on another measuring sheet than the one it holds"),
    "road_test": Sentence("its stored result rests on another log than the one it holds"),
}


def _by_land(rows: Any) -> dict[tuple[str, int], tuple[Any, ...]]:
    return {(row["component"], row["land"]): tuple(row[name] for name in LAND_COLUMNS) for row in rows}


def _log_problems(log: Any, sha256: str | None) -> Iterator[Sentence]:
    import pyarrow.lib
    import pyarrow.parquet

    if log.sha256 != sha256:
        yield Sentence("its table of channels is of another log than the one it holds")
    try:
        rows = pyarrow.parquet.read_table(io.BytesIO(log.parquet)).num_rows
    except (pyarrow.lib.ArrowException, OSError):
        yield Sentence("its table of channels is damaged")
    else:
        if rows != log.rows:
            wanted = log.rows
            yield Sentence("its table of channels has {rows} rows in place of {wanted}", rows=rows, wanted=wanted)
