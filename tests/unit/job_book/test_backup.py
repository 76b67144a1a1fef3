"""Backup, restore and verify, from each database to each; what is damaged or newer is refused and nothing changes."""

from __future__ import annotations

import shutil
import sqlite3
from collections.abc import Callable, Iterable
from contextlib import closing
from pathlib import Path

import pytest
import sqlalchemy as sa

from atleak.common.errors import BookError
from atleak.job.case import Case, SourceFile
from atleak.job.parts import JobParts, job_parts
from atleak.job_book import backup as backing_up
from atleak.job_book.backup import backup, restore, verify
from atleak.job_book.book import Book, open_book
from atleak.job_book.merges import merge
from atleak.job_book.search import Query
from atleak.job_book.tables import metadata, units
from atleak.measurements.job_card import Job

MakeJob = Callable[..., JobParts]
LOG = "time [s],engine speed [rpm],ATF temperature [°C]\n0,800,80\n1,900,81\n2,1000,82\n"


@pytest.fixture(scope="module")
def log_job() -> JobParts:
    case = Case(road_test=SourceFile("log.csv", LOG.encode()), controller="minimal_example", remember=False)
    return job_parts(case.diagnose(), Job(number="log"), case)


@pytest.fixture
def filled(new_book: Callable[[], Book], small_job: MakeJob, log_job: JobParts) -> Book:
    """A book of four jobs: two of one unit, an archived one, one with a log; one unit was merged into another."""
    book = new_book()
    first = book.save(small_job(number="1", customer={"name": "Gęślą"}, transmission={"serial": "A1"}))
    book.save(small_job(11.05, number="2", transmission={"serial": "A1"}))
    book.archive(book.save(small_job(11.06, number="3", transmission={"serial": "A2"})).id)
    book.save(log_job)
    book.save(small_job(number="1, later", transmission={"serial": "A1"}), id=first.id, version=1)
    unit_of = {row.serial: row.unit for row in book.rows(Query(archived=None))}
    merge(book, unit_of["A2"], unit_of["A1"])
    return book


def rows(book: Book) -> dict[str, list[tuple]]:
    """Every row of every table."""
    with book.reading() as connection:
        return {
            table.name: sorted(map(tuple, connection.execute(sa.select(table))), key=repr)
            for table in metadata.sorted_tables
        }


def changed(path: Path, *statements: str, parameters: Iterable = ()) -> None:
    """Change a SQLite file behind the book's back."""
    with closing(sqlite3.connect(path)) as connection, connection:
        for statement in statements:
            connection.execute(statement, tuple(parameters))


@pytest.fixture(params=["sqlite", "postgresql"])
def other_book(request: pytest.FixtureRequest, new_book_on: Callable[[str], Book]) -> Book:
    """An empty book on each of the databases, whichever the first one is on."""
    return new_book_on(request.param)


def test_a_backup_of_either_database_is_restored_to_either_row_by_row(
    filled: Book, other_book: Book, tmp_path: Path, small_job: MakeJob
) -> None:
    assert backup(filled, tmp_path / "backup.sqlite") == 4
    assert [path.name for path in tmp_path.glob("*backup*")] == ["backup.sqlite"]
    assert not list(tmp_path.glob(".atleak*"))
    assert restore(tmp_path / "backup.sqlite", other_book) == 4
    assert rows(other_book) == rows(filled)
    assert verify(other_book) == ()
    other_book.save(small_job(11.07, number="5", transmission={"serial": "A3"}))  # whose rows are numbered behind those
    assert other_book.count() == 4


def test_an_earlier_backup_stays_where_a_new_one_cannot_be_made(
    filled: Book, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    target = tmp_path / "backup.sqlite"
    backup(filled, target)
    before = target.read_bytes()

    def full(*_: object) -> None:
        raise sqlite3.OperationalError("database or disk is full")

    monkeypatch.setattr("atleak.job_book.backup._check", full)
    with pytest.raises(BookError, match=r"backup\.sqlite: no backup of .* can be made: the disk is full"):
        backup(filled, target)
    assert target.read_bytes() == before
    assert not list(tmp_path.glob(".atleak*"))


def test_a_backup_into_a_folder_that_is_not_there_says_so(book: Book, tmp_path: Path) -> None:
    with pytest.raises(BookError, match="its folder may not be written, or is not there"):
        backup(book, tmp_path / "nowhere" / "backup.sqlite")


def test_a_job_saved_while_a_backup_is_made_does_not_come_into_it_by_halves(
    new_book_on: Callable[[str], Book], tmp_path: Path, small_job: MakeJob, monkeypatch: pytest.MonkeyPatch
) -> None:
    """SQLite copies its file at one go; of PostgreSQL one table is read after another, all as they were then."""
    book = new_book_on("postgresql")
    book.save(small_job(number="before"))
    copy_rows = backing_up.copy_rows

    def copied(source: sa.Connection, target: sa.Connection) -> None:
        source.execute(sa.select(units.c.id)).all()
        book.save(small_job(11.09, number="meanwhile"))
        copy_rows(source, target)

    monkeypatch.setattr(backing_up, "copy_rows", copied)
    assert backup(book, tmp_path / "backup.sqlite") == 1
    assert book.count() == 2


def test_a_book_with_jobs_is_replaced_only_where_that_is_said(
    filled: Book, new_book: Callable[[], Book], tmp_path: Path, small_job: MakeJob
) -> None:
    backup(filled, tmp_path / "backup.sqlite")
    mine = new_book()
    mine.save(small_job(number="mine"))
    before = rows(mine)
    with pytest.raises(BookError, match="holds 1 job, and nothing was restored; expected an empty book, or --force"):
        restore(tmp_path / "backup.sqlite", mine)
    assert rows(mine) == before
    assert restore(tmp_path / "backup.sqlite", mine, force=True) == 4
    assert rows(mine) == rows(filled)


def test_a_restore_that_fails_half_way_leaves_the_book_as_it_was(
    filled: Book, new_book: Callable[[], Book], tmp_path: Path, small_job: MakeJob, monkeypatch: pytest.MonkeyPatch
) -> None:
    backup(filled, tmp_path / "backup.sqlite")
    mine = new_book()
    mine.save(small_job(number="mine"))
    before = rows(mine)
    monkeypatch.setattr("atleak.job_book.backup._count_on", lambda _: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        restore(tmp_path / "backup.sqlite", mine, force=True)
    assert rows(mine) == before


@pytest.fixture
def sqlite_book(new_book_on: Callable[[str], Book]) -> Book:
    return new_book_on("sqlite")


@pytest.fixture
def kept(sqlite_book: Book, small_job: MakeJob, tmp_path: Path) -> Path:
    """A backup of two jobs."""
    for number in ("1", "2"):
        sqlite_book.save(small_job(number=number))
    path = tmp_path / "kept.sqlite"
    backup(sqlite_book, path)
    return path


def test_what_is_no_backup_is_refused_in_words(kept: Path, sqlite_book: Book, tmp_path: Path) -> None:
    before = rows(sqlite_book)
    (tmp_path / "text.sqlite").write_text("no database, however long it is " * 20, encoding="utf-8")
    (tmp_path / "empty.sqlite").write_bytes(b"")
    damaged = kept.read_bytes()
    (tmp_path / "cut.sqlite").write_bytes(damaged[: len(damaged) // 2])
    for name, said in (
        ("nowhere.sqlite", "nowhere.sqlite: is not there; expected a file that `atleak jobs backup` has written"),
        ("text.sqlite", "text.sqlite: the backup cannot be restored: the file is no job book"),
        ("empty.sqlite", "empty.sqlite: is no backup of a job book"),
        ("cut.sqlite", r"cut.sqlite: .*(is damaged|malformed)"),
    ):
        with pytest.raises(BookError, match=said):
            restore(tmp_path / name, sqlite_book, force=True)
    with pytest.raises(BookError, match="is the job book itself"):
        restore(sqlite_book.name, sqlite_book, force=True)
    with pytest.raises(BookError, match="is the job book itself"):
        backup(sqlite_book, sqlite_book.name)
    assert rows(sqlite_book) == before


def test_a_backup_with_a_damaged_job_names_it_and_is_taken_only_where_that_is_said(
    kept: Path, new_book_on: Callable[[str], Book]
) -> None:
    changed(kept, "UPDATE results SET record = x'00' WHERE job = (SELECT id FROM jobs WHERE number = '2')")
    mine = new_book_on("sqlite")
    with pytest.raises(BookError, match=r"(?s)jobs of the backup are damaged, and nothing was restored.*\n  job 2 \("):
        restore(kept, mine, force=True)
    assert mine.count() == 0
    assert restore(kept, mine, damaged=True) == 2
    assert [fault.number for fault in verify(mine)] == ["2"]


def test_a_backup_of_a_newer_atleak_is_refused_and_the_book_stays(kept: Path, sqlite_book: Book) -> None:
    changed(kept, "UPDATE alembic_version SET version_num = '9999'", "UPDATE about SET atleak = '7.1.0'")
    before, content = rows(sqlite_book), kept.read_bytes()
    with pytest.raises(BookError, match=r"kept\.sqlite: this job book was made by atleak 7\.1\.0, which is newer"):
        restore(kept, sqlite_book, force=True)
    assert rows(sqlite_book) == before
    assert kept.read_bytes() == content


def test_a_copy_of_the_books_file_is_a_backup_too(kept: Path, sqlite_book: Book, tmp_path: Path) -> None:
    sqlite_book.engine.dispose()
    shutil.copyfile(sqlite_book.name, tmp_path / "copy.sqlite")
    assert restore(tmp_path / "copy.sqlite", sqlite_book, force=True) == 2


ITS_SHEET = "(SELECT sha256 FROM job_files WHERE slot = 'readings')"
ITS_FLUID = "(SELECT sha256 FROM job_files WHERE slot = 'fluid')"
DAMAGE = {
    f"UPDATE files SET content = x'00' WHERE sha256 IN {ITS_SHEET}": "job whole was damaged",
    f"UPDATE files SET content = (SELECT content FROM files WHERE sha256 IN {ITS_FLUID}) WHERE sha256 IN {ITS_SHEET}": (
        "small.csv of job whole was damaged"
    ),
    "UPDATE jobs SET choices = x'00'": "damaged",
    "DELETE FROM results": "the stored result of job whole is missing",
    "UPDATE results SET record = (SELECT choices FROM jobs)": "its stored result cannot be read",
    "UPDATE results SET verdict = 'ok'": "its stored result says critical, its row ok",
    "UPDATE results SET readings_sha256 = 'x'": "rests on another measuring sheet than the one it holds",
    "DELETE FROM lands": "the lands of its stored result are not those of its rows",
    "UPDATE lands SET radial_clearance_um = radial_clearance_um + 1e-9": "the lands of its stored result are not",
    "DELETE FROM job_files WHERE slot = 'limits'": "holds no catalogue/limits.toml, which its record names",
    "UPDATE jobs SET visit = 77": "row 1 of jobs refers to no row of visits",
}


def test_verify_says_what_is_wrong_with_which_job(sqlite_book: Book, small_job: MakeJob, tmp_path: Path) -> None:
    sqlite_book.save(small_job(11.4, number="whole"))
    assert verify(sqlite_book) == ()
    sqlite_book.engine.dispose()
    for statement, said in DAMAGE.items():
        shutil.copyfile(sqlite_book.name, tmp_path / "damaged.sqlite")
        changed(tmp_path / "damaged.sqlite", statement)
        damaged = open_book(f"sqlite:///{tmp_path / 'damaged.sqlite'}")
        faults = [str(fault) for fault in verify(damaged)]
        damaged.engine.dispose()
        assert any(said in fault for fault in faults), (said, faults)


def test_verify_reads_the_table_of_a_logs_channels(sqlite_book: Book, log_job: JobParts) -> None:
    sqlite_book.save(log_job)
    assert verify(sqlite_book) == ()
    for statement, said in (
        ("UPDATE log_tables SET rows = 4", "has 3 rows in place of 4"),
        ("UPDATE log_tables SET sha256 = 'x'", "is of another log than the one it holds"),
        ("UPDATE log_tables SET parquet = x'00'", "its table of channels is damaged"),
    ):
        changed(Path(sqlite_book.name), statement)
        assert any(said in str(fault) for fault in verify(sqlite_book)), said


def test_pages_of_the_file_that_are_damaged_are_named(sqlite_book: Book, small_job: MakeJob) -> None:
    for number in range(3):
        sqlite_book.save(small_job(11.05 + number / 100, number=str(number)))
    sqlite_book.engine.dispose()
    path = Path(sqlite_book.name)
    content = bytearray(path.read_bytes())
    with closing(sqlite3.connect(path)) as connection:
        (page,) = connection.execute("SELECT rootpage FROM sqlite_master WHERE name = 'ix_lands_job'").fetchone()
        (size,) = connection.execute("PRAGMA page_size").fetchone()
    content[(page - 1) * size : (page - 1) * size + 200] = bytes(200)
    path.write_bytes(content)
    book = open_book(f"sqlite:///{path}")
    try:
        said = [str(fault) for fault in verify(book)]
    except BookError as error:
        said = [str(error)]
    finally:
        book.engine.dispose()
    assert any("damaged" in text for text in said), said


def test_a_result_of_an_earlier_sheet_that_another_version_replaced_is_written_anew(
    book: Book, small_job: MakeJob, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Two versions of atleak on one book: the newest result is that of the files that the job holds."""
    first, second = small_job(11.04), small_job(11.4)
    saved = book.save(first)
    with monkeypatch.context() as older:
        older.setattr("atleak.job_book.book.__version__", "0.1.9")
        saved = book.save(second, id=saved.id, version=saved.version)
    book.save(first, id=saved.id, version=saved.version)
    assert book.load(saved.id).file.result["lands"] == first.result["lands"]
    assert verify(book) == ()
