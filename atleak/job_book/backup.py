"""Keep a job book safe: back it up as one file, bring that file back, and check that every job is whole.

A backup is a SQLite file whatever database the book is on, so that it can be restored to either.
"""

from __future__ import annotations

import contextlib
import io
import sqlite3
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import sqlalchemy as sa
from sqlalchemy import exc

from atleak.common.errors import AtleakError, BookError, Place
from atleak.common.files import PRIVATE, replacing
from atleak.common.sentences import Sentence, counted
from atleak.common.verdicts import level_named
from atleak.job_book.book import LAND_COLUMNS, Book, StoredJob
from atleak.job_book.database import copy_file, in_words, opened_engine, writing
from atleak.job_book.tables import COPIED, copy_rows, jobs, lands, log_tables, results, units


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
    `atleak.job_book.backup.restore` does.

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
        faults = list(connection.exec_driver_sql("PRAGMA integrity_check(10)").scalars())
        yield from faults if faults != ["ok"] else []
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
        verdicts = level_named(record["verdict"]), level_named(result.verdict)
        yield Sentence("its stored result says {verdict}, its row {other}", verdict=verdicts[0], other=verdicts[1])
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


_A_BACKUP = Sentence("a file that `atleak jobs backup` has written")


def backup(book: Book, path: str | Path) -> int:
    """Write all of a book as one file, as it is at one moment, while others may save; return how many jobs it holds.

    Parameters
    ----------
    path
        of the file; an earlier one is replaced by the whole new one, or stays as it is.

    Raises
    ------
    BookError
        a book that cannot be read, or a file that cannot be written.
    OutputError
        a folder that may not be written.
    """
    target = Path(path)
    _refuse_the_book_itself(book, target)
    problem = Sentence("no backup of {book} can be made", book=book.name)
    with in_words(str(target), problem), replacing(target, mode=PRIVATE) as beside:
        if book.engine.dialect.name == "sqlite":
            connection = book.engine.raw_connection()
            try:
                copy_file(connection.driver_connection, beside)
            finally:
                connection.close()
        else:
            _copy_out(book, beside)
        with contextlib.closing(sqlite3.connect(beside)) as copy:
            copy.execute("PRAGMA journal_mode = DELETE")  # one file, with none beside it
            _check(copy, target)
            return int(copy.execute("SELECT count(*) FROM jobs").fetchone()[0])


def restore(path: str | Path, book: Book, *, force: bool = False, damaged: bool = False) -> int:
    """Fill a book with all that a backup holds, or leave it as it is; return how many jobs it holds then.

    Parameters
    ----------
    force
        whether a book that holds jobs loses them.
    damaged
        whether a backup with damaged jobs is taken as it is.

    Raises
    ------
    BookError
        no backup, a damaged one, or one of a newer atleak; a book that is not empty.
    """
    source = Path(path)
    _refuse_the_book_itself(book, source)
    with _opened(source) as held:
        if not damaged and (faults := verify(held)):
            others = [BookError(fault.sentence) for fault in faults]
            raise BookError(
                Sentence("jobs of the backup are damaged, and nothing was restored"),
                place=Place(file=str(source)),
                expected=Sentence("another backup, or --damaged to take this one with what is left of them"),
                others=others,
            )
        with held.reading() as rows, book.writing() as connection:
            _keep_others_out(connection)
            there = _count(connection)
            if there and not force:
                raise BookError(
                    counted(
                        there,
                        "the job book holds {count} job, and nothing was restored",
                        "the job book holds {count} jobs, and nothing was restored",
                    ),
                    place=Place(file=book.name),
                    expected=Sentence("an empty book, or --force to put the backup in its place"),
                )
            for table in reversed(COPIED):
                connection.execute(table.delete())
            copy_rows(rows, connection)
            _count_on(connection)
            return _count(connection)


def _refuse_the_book_itself(book: Book, path: Path) -> None:
    of_book = book.engine.url.database if book.engine.dialect.name == "sqlite" else None
    with contextlib.suppress(OSError):
        if of_book is not None and path.samefile(of_book):
            problem = Sentence("is the job book itself")
            raise BookError(problem, place=Place(file=str(path)), expected=Sentence("another file"))


def _count(connection: sa.Connection) -> int:
    return connection.execute(sa.select(sa.func.count()).select_from(jobs)).scalar_one()


# --- files


@contextlib.contextmanager
def _opened(path: Path) -> Iterator[Book]:
    """Open a copy of a backup as a book, which brings one of an earlier version up to date."""
    place = Place(file=str(path))
    if not path.is_file():
        raise BookError(Sentence("is not there"), place=place, expected=_A_BACKUP)
    with (
        tempfile.TemporaryDirectory(prefix="atleak-restore-", ignore_cleanup_errors=True) as folder,
        in_words(str(path), Sentence("the backup cannot be restored")),
    ):
        copy = Path(folder) / "book.sqlite"
        with contextlib.closing(sqlite3.connect(f"{path.resolve().as_uri()}?mode=ro", uri=True)) as connection:
            _check(connection, path)
            copy_file(connection, copy)
        try:
            engine = opened_engine(sa.URL.create("sqlite", database=str(copy)), a_copy=True)
        except BookError as error:
            error.rename_file(lambda _: str(path))
            raise
        try:
            yield Book(engine, str(path))
        finally:
            engine.dispose()


def _check(connection: sqlite3.Connection, path: Path) -> None:
    """Refuse a file that is no job book, or one whose pages are damaged."""
    place = Place(file=str(path))
    held = {name for (name,) in connection.execute("SELECT name FROM sqlite_master WHERE type = 'table'")}
    if not {"alembic_version", "jobs"} <= held:
        raise BookError(Sentence("is no backup of a job book"), place=place, expected=_A_BACKUP)
    faults = [text for (text,) in connection.execute("PRAGMA integrity_check(3)")]
    if faults != ["ok"]:
        problem = Sentence("the file is damaged: {reason}", reason=faults[0])
        raise BookError(problem, place=place, expected=Sentence("another backup"))


# --- rows


def _copy_out(book: Book, path: Path) -> None:
    """Write all rows of a book, as they are at one moment, into a new file."""
    engine = opened_engine(sa.URL.create("sqlite", database=str(path)))
    try:
        with book.engine.connect() as source:
            source = source.execution_options(isolation_level="REPEATABLE READ", postgresql_readonly=True)
            with source.begin(), writing(engine) as target:
                copy_rows(source, target)
    finally:
        engine.dispose()


def _keep_others_out(connection: sa.Connection) -> None:
    """Let nobody else write until the transaction ends; SQLite has one writer anyway."""
    if connection.dialect.name == "postgresql":
        names = ", ".join(table.name for table in COPIED)
        connection.exec_driver_sql(f"LOCK TABLE {names} IN SHARE ROW EXCLUSIVE MODE")


def _count_on(connection: sa.Connection) -> None:
    """Let PostgreSQL number new rows behind those that came with their numbers; SQLite does so by itself."""
    if connection.dialect.name != "postgresql":
        return
    for table in COPIED:
        for column in table.primary_key:
            if isinstance(column.type, sa.Integer):
                sequence = sa.func.pg_get_serial_sequence(table.name, column.name)
                last = sa.select(sa.func.max(column)).scalar_subquery()
                connection.execute(sa.select(sa.func.setval(sequence, sa.func.coalesce(last, 1), last.is_not(None))))
