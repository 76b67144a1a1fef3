"""Keep a job book safe: back it up as one file, bring that file back, and check that every job is whole.

A backup is a SQLite file whatever database the book is on, so that it can be restored to either.
"""

from __future__ import annotations

import contextlib
import sqlite3
import tempfile
from collections.abc import Iterator
from pathlib import Path

import sqlalchemy as sa

from atleak.errors import BookError, Place
from atleak.jobs.book import Book
from atleak.jobs.opening import copy_file, in_words, opened_engine, writing
from atleak.jobs.rows import COPIED, copy_rows
from atleak.jobs.tables import jobs
from atleak.jobs.verify import Fault, verify
from atleak.sentence import Sentence
from atleak.system.files import PRIVATE, replacing

__all__ = ["Fault", "backup", "restore", "verify"]

_A_BACKUP = Sentence("a file that `atleak jobs backup` has written")


def backup(book: Book, path: str | Path) -> int:
    """Write all of a book as one file, as it is at one moment; others may go on saving meanwhile.

    Parameters
    ----------
    path
        of the file; an earlier one is replaced by the whole new one, or stays as it is.

    Returns
    -------
    int
        how many jobs the backup holds.

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
    """Fill a book with all that a backup holds, or leave it as it is.

    Parameters
    ----------
    path
        of the backup.
    book
        on either database.
    force
        whether a book that holds jobs loses them.
    damaged
        whether a backup with damaged jobs is taken as it is.

    Returns
    -------
    int
        how many jobs the book holds now.

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
                    Sentence("the job book holds {count} job, and nothing was restored", count=there)
                    if there == 1
                    else Sentence("the job book holds {count} jobs, and nothing was restored", count=there),
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
    said = [text for (text,) in connection.execute("PRAGMA integrity_check(3)")]
    if said != ["ok"]:
        problem = Sentence("the file is damaged: {reason}", reason=said[0])
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
