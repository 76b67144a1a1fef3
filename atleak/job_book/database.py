"""Open a job book: find its database, make or migrate its tables under one lock, and say in words what goes wrong."""

from __future__ import annotations

import contextlib
import glob
import os
import shutil
import sqlite3
import tempfile
import weakref
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import quote

import sqlalchemy as sa
from sqlalchemy import exc

from atleak.common.errors import BookError, Place, extra_installed
from atleak.common.files import DATABASE_URL, PRIVATE, PRIVATE_FOLDER, home, made_folder, replacing
from atleak.common.sentences import Sentence
from atleak.job_book.tables import REVISION, about, metadata
from atleak.version import __version__

_FILE = "book.sqlite"
_BEFORE = ".before-"  # what is between a book's name and the revision of the tables that took the place of its own
_BESIDE = ("", "-wal", "-shm")  # what the names of a book's three files end in
_PACKAGE = Path(__file__).resolve().parents[1]
_WAITING = 30.0  # [s] for another writer
_LOCK = 0x61746C65616B  # of PostgreSQL, for all who make or migrate this book: any number that nothing else takes
_MIGRATIONS = Path(__file__).with_name("migrations")
_WRITING = {"atleak_writes": True}
_FAULTS = (  # what a database says, and what that means
    ("disk is full", Sentence("the disk is full")),
    ("no space left", Sentence("the disk is full")),
    ("disk i/o error", Sentence("the disk cannot be written: it is full or gone")),
    ("readonly database", Sentence("it may not be written")),
    ("unable to open database", Sentence("its folder may not be written, or is not there")),
    ("database is locked", Sentence("another program has held it for too long")),
    ("not a database", Sentence("the file is no job book")),
    (
        "malformed",
        Sentence(
            "the file is damaged: close atleak everywhere, move book.sqlite, book.sqlite-wal and book.sqlite-shm away, "
            "and `atleak jobs restore` brings a backup back"
        ),
    ),
    ("connection refused", Sentence("the database server does not answer")),
    ("could not translate host", Sentence("the database server is not known")),
    ("password authentication failed", Sentence("the database server refuses the password")),
    ("no module named", Sentence("the driver of that database is not installed")),
    ("int too large", Sentence("a number is larger than any that it can hold")),
    ("surrogates not allowed", Sentence("a text or file name cannot be written as UTF-8")),
)

_UNUSABLE = Sentence("the job book cannot be used")

# what SQLAlchemy and the drivers raise, and what a driver of SQLite says of a value before the database sees it
_REPORTED = (exc.DBAPIError, exc.NoSuchModuleError, exc.TimeoutError, sqlite3.Error, OverflowError, UnicodeEncodeError)


def database_url(url: str | None = None) -> sa.URL:
    """Return where the job book is: a URL, else ``ATLEAK_DATABASE_URL``, else a file in the user's folder.

    Raises
    ------
    BookError
        for a URL of neither SQLite nor PostgreSQL; for a folder that cannot be made, or is atleak's own.
    """
    url = url or os.environ.get(DATABASE_URL)
    if not url:
        return sa.URL.create("sqlite", database=_outside(made_folder(home()) / _FILE))
    expected = Sentence("sqlite:///C:/folder/book.sqlite or postgresql://user:password@server/name")
    try:
        parsed = sa.make_url(url)
    except (exc.ArgumentError, ValueError) as error:  # a port that is no number
        raise BookError(Sentence("names no database"), place=Place(file=DATABASE_URL), expected=expected) from error
    kind = parsed.get_backend_name()
    if kind == "sqlite" and parsed.database and not parsed.database.startswith((":memory:", "file:")):
        return sa.URL.create("sqlite", database=_outside(Path(parsed.database)))
    if kind == "postgresql":
        return parsed.set(drivername="postgresql+psycopg")
    problem = Sentence("a database that cannot hold the job book")
    raise BookError(problem, place=Place(file=DATABASE_URL), expected=expected)


def _outside(path: Path) -> str:
    """Return the path of a book, whatever folder a program is in; refuse one that an update of atleak replaces."""
    if path.resolve().is_relative_to(_PACKAGE):
        problem = Sentence("lies in a folder of atleak itself, which an update replaces")
        raise BookError(problem, place=Place(file=str(path)), expected=Sentence("another folder"))
    return str(path.absolute())


def opened_engine(url: sa.URL, *, a_copy: bool = False) -> sa.Engine:
    """Return the engine of a database whose tables are there and are today's; a file that may only be read is read.

    Parameters
    ----------
    a_copy
        whether the file is a copy, which is not kept as it was before its tables are brought up to date.

    Raises
    ------
    BookError
        a database that cannot be opened or made, or that a newer atleak has made.
    """
    name = shown(url)
    with in_words(name):
        try:
            engine = sa.create_engine(url, **_options(url))
        except ImportError as error:
            problem = Sentence("cannot be opened: the driver of PostgreSQL is not installed")
            raise BookError(problem, place=Place(file=name), expected=extra_installed("postgres")) from error
        if url.get_backend_name() == "sqlite":
            sa.event.listen(engine, "connect", _prepare_sqlite)
            sa.event.listen(engine, "begin", _begin_sqlite)
        else:
            sa.event.listen(engine, "connect", _prepare_postgresql)
        path = _file(url)
        if path is not None:
            sa.event.listen(engine, "checkout", _at_its_place)
        try:
            with engine.connect() as connection:
                current = _revision(connection)
            if current != REVISION:
                if path is not None and _mode(path) != "rw":
                    copy = _brought_up_elsewhere(engine)
                    engine.dispose()
                    return copy
                with writing(engine) as connection:
                    if url.get_backend_name() == "postgresql":
                        connection.execute(sa.select(sa.func.pg_advisory_xact_lock(_LOCK)))
                    _bring_up(connection, name, None if a_copy else path)
                if path is not None and path.is_relative_to(home()):
                    _keep_private(path)
        except BaseException:
            engine.dispose()  # its connections, which nobody else closes
            raise
    return engine


def _brought_up_elsewhere(engine: sa.Engine) -> sa.Engine:
    """Return the engine of a copy of an earlier book that may only be read: today's tables, to be read likewise."""
    folder = tempfile.mkdtemp(prefix="atleak-book-")
    url = sa.URL.create("sqlite", database=str(Path(folder) / _FILE))
    try:
        with contextlib.closing(engine.raw_connection()) as source:
            copy_file(source.driver_connection, Path(folder) / _FILE)
        opened_engine(url, a_copy=True).dispose()
    except BaseException:
        shutil.rmtree(folder, ignore_errors=True)
        raise
    copy = sa.create_engine(url, **_options(url), poolclass=sa.NullPool)  # which holds no file that is to be deleted
    sa.event.listen(copy, "connect", _prepare_sqlite)
    sa.event.listen(copy, "connect", lambda connection, _: connection.execute("PRAGMA query_only = ON"))
    sa.event.listen(copy, "begin", _begin_sqlite)
    weakref.finalize(copy, shutil.rmtree, folder, ignore_errors=True)
    return copy


def copy_file(source: Any, path: Path) -> None:
    """Write what a connection of SQLite sees as one file, with none beside it."""
    with contextlib.closing(sqlite3.connect(path)) as target:
        source.backup(target)
        target.execute("PRAGMA journal_mode = DELETE")


def kept_before(path: Path) -> list[Path]:
    """Return what was kept of a book as it was before an update of its tables."""
    return sorted(path.parent.glob(f"{glob.escape(path.name)}{_BEFORE}*"))


@contextlib.contextmanager
def writing(engine: sa.Engine) -> Iterator[sa.Connection]:
    """Open a transaction that writes: on SQLite the one writer's from its start, so that it never fails half-way."""
    with engine.connect().execution_options(**_WRITING) as connection, connection.begin():
        yield connection


@contextlib.contextmanager
def in_words(name: str, problem: Sentence = _UNUSABLE) -> Iterator[None]:
    """Turn what a database reports into a `BookError` that says what it means."""
    try:
        yield
    except _REPORTED as error:
        reason = str(getattr(error, "orig", None) or error).strip()
        reported = Sentence("{reason}", reason=reason.splitlines()[0][:200])
        meaning = next((words for sign, words in _FAULTS if sign in reason.lower()), reported)
        text = Sentence("{problem}: {reason}", problem=problem, reason=meaning)
        raise BookError(text, place=Place(file=name)) from error


def shown(url: sa.URL) -> str:
    """Return a database's name for people: the file's path, or the URL without its password."""
    if url.get_backend_name() == "sqlite":
        return str(url.database)
    shown = url.set(drivername="postgresql", password=None)
    return shown.difference_update_query(
        shown.query
    ).render_as_string()  # a password may stand in what follows the name


def _options(url: sa.URL) -> dict[str, Any]:
    if url.get_backend_name() != "sqlite":
        return {"pool_pre_ping": True, "connect_args": {"connect_timeout": 5}}
    arguments: dict[str, Any] = {"timeout": _WAITING, "check_same_thread": False, "isolation_level": None}
    path = _file(url)
    if path is None:
        return {"creator": lambda: sqlite3.connect("", **arguments)}  # in memory, what is too large in a nameless file
    with contextlib.suppress(OSError):  # which SQLite says in its way; a new file is its owner's alone from the start
        os.close(os.open(path, os.O_CREAT | os.O_EXCL, PRIVATE))
    address = path.as_posix()
    address = f"file://{'' if address.startswith('/') else '/'}{quote(address, safe='/:')}?mode={_mode(path)}"
    return {"creator": lambda: _connected(path, address, arguments)}


def _file(url: sa.URL) -> Path | None:
    """Return the file of a database; None where it has none of this machine's."""
    on_disk = url.get_backend_name() == "sqlite" and url.database not in (None, "", ":memory:")
    return Path(str(url.database)) if on_disk else None


def _mode(path: Path) -> str:
    """Return how SQLite opens a file that is there; on a medium that may not be written it can keep no journal."""
    journal = path.with_name(f"{path.name}-wal")
    if not path.exists() or (os.access(path, os.W_OK) and (journal.exists() or os.access(path.parent, os.W_OK))):
        return "rw"  # never makes one in the place of a file that was moved away
    return "ro" if journal.exists() and journal.stat().st_size else "ro&immutable=1"


def _connected(path: Path, address: str, arguments: dict[str, Any]) -> sqlite3.Connection:
    if not path.exists() and path.parent.is_dir():
        problem = Sentence("the job book was moved away while atleak had it open, and nothing is saved")
        expected = Sentence("the file back in its place, a backup there, or atleak to be started again")
        raise BookError(problem, place=Place(file=str(path)), expected=expected)
    return sqlite3.connect(address, uri=True, **arguments)


def _at_its_place(connection: sqlite3.Connection, record: Any, _proxy: Any) -> None:
    """Refuse a connection to a file that is no longer the one at its path; the pool opens the one there instead."""
    _, _, path = connection.execute("PRAGMA database_list").fetchone()
    try:
        now = os.stat(path)  # noqa: PTH116
    except OSError:
        now = None
    if now is None or not os.path.samestat(now, record.info.setdefault("file", now)):
        raise exc.DisconnectionError


def _keep_private(path: Path) -> None:
    """Leave a book that is made or brought up to date, and the user's folder, to their owner alone."""
    with contextlib.suppress(OSError):  # another owner's, or a file system without owners
        for end in _BESIDE:
            if (file := path.with_name(path.name + end)).exists():
                file.chmod(PRIVATE)
        if path.parent == home():
            path.parent.chmod(PRIVATE_FOLDER)


def _prepare_sqlite(connection: Any, _record: Any) -> None:
    with contextlib.suppress(sqlite3.OperationalError):  # a file that may only be read keeps what it has
        connection.execute("PRAGMA journal_mode = WAL")
    for setting in ("synchronous = FULL", "foreign_keys = ON", "secure_delete = ON"):
        connection.execute(f"PRAGMA {setting}")


def _prepare_postgresql(connection: Any, _record: Any) -> None:
    connection.execute("SET TIME ZONE 'UTC'")  # in which a day of a moment is the same everywhere
    connection.commit()


def _begin_sqlite(connection: sa.Connection) -> None:
    options = connection.get_execution_options()
    if options.get("isolation_level") == "AUTOCOMMIT":
        return  # what rewrites the whole file cannot be part of a transaction
    connection.exec_driver_sql("BEGIN IMMEDIATE" if _WRITING.items() <= options.items() else "BEGIN")


def _revision(connection: sa.Connection) -> str | None:
    """Return the revision of the tables; None in a database without any."""
    if not sa.inspect(connection).has_table("alembic_version"):
        return None
    return connection.exec_driver_sql("SELECT version_num FROM alembic_version").scalar()


def _bring_up(connection: sa.Connection, name: str, path: Path | None) -> None:
    """Make the tables of a new book, or bring those of an earlier version to today's; a file is kept as it was."""
    current = _revision(connection)
    if current == REVISION:
        return  # another process was first
    from alembic import command
    from alembic.config import Config
    from alembic.script import ScriptDirectory

    config = Config()
    config.set_main_option("script_location", str(_MIGRATIONS).replace("%", "%%"))
    config.attributes["connection"] = connection
    if current is None:
        if sa.inspect(connection).get_table_names():
            problem = Sentence("the database holds other tables, and no job book")
            raise BookError(problem, place=Place(file=name), expected=Sentence("an empty one"))
        metadata.create_all(connection)
        command.stamp(config, "head")
    elif current not in {each.revision for each in ScriptDirectory.from_config(config).walk_revisions()}:
        by = connection.execute(sa.select(about.c.atleak)).scalar()
        problem = Sentence(
            "this job book was made by atleak {by}, which is newer than this one ({version})",
            by=by,
            version=__version__,
        )
        raise BookError(problem, place=Place(file=name), expected=Sentence("atleak to be updated; nothing was changed"))
    else:
        if path is not None:
            before = path.with_name(f"{path.name}{_BEFORE}{REVISION}")
            with replacing(before, mode=PRIVATE) as beside, contextlib.closing(sqlite3.connect(path)) as as_it_is:
                copy_file(as_it_is, beside)
        command.upgrade(config, "head")
    connection.execute(about.delete())
    connection.execute(about.insert().values(atleak=__version__))
