"""The job book under several writers, on a disk that takes no more, and beside other versions of atleak."""

from __future__ import annotations

import random
import shutil
import subprocess
import sys
import threading
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import pytest
import sqlalchemy as sa

from atleak.common.errors import BookError, ChangedElsewhere
from atleak.job.parts import JobParts
from atleak.job_book import database as opening
from atleak.job_book.backup import backup, verify
from atleak.job_book.book import Book, Saved, open_book
from atleak.job_book.tables import about, jobs

MakeJob = Callable[..., JobParts]

# Opens each of several new books in so many processes at once; they are forked after the imports, which take longest.
AT_ONCE = """
import os, sys, time
from atleak.job_book.book import open_book
import alembic.command, psycopg
failed = 0
for address in sys.argv[2:]:
    moment = time.time() + 0.1
    for _ in range(int(sys.argv[1])):
        if os.fork() == 0:
            try:
                time.sleep(max(moment - time.time(), 0))
                open_book(address).rows()
                os._exit(0)
            except BaseException as error:
                print(address, repr(error), file=sys.stderr, flush=True)
                os._exit(1)
    failed += sum(os.wait()[1] != 0 for _ in range(int(sys.argv[1])))
sys.exit(failed)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="processes are not forked there")
def test_eight_processes_that_open_a_new_book_at_the_same_moment_all_succeed(tmp_path: Path, postgresql: Any) -> None:
    addresses = [f"sqlite:///{tmp_path / 'book.sqlite'}", postgresql.address(postgresql.new_database())]
    command = [sys.executable, "-c", AT_ONCE, "8", *addresses]
    done = subprocess.run(command, capture_output=True, encoding="utf-8", check=False, timeout=120)
    assert (done.returncode, done.stderr) == (0, "")
    for address in addresses:
        book = open_book(address)
        with book.reading() as connection:
            assert len(connection.execute(sa.select(about)).all()) == 1
        assert book.rows() == []
        book.engine.dispose()


def at_once(*tasks: Callable[[], Any]) -> list[Any]:
    """Run tasks in threads that start at the same moment; an exception is a task's result."""
    results: list[Any] = [None] * len(tasks)
    start = threading.Barrier(len(tasks))

    def run(number: int) -> None:
        start.wait()
        try:
            results[number] = tasks[number]()
        except BookError as error:
            results[number] = error

    threads = [threading.Thread(target=run, args=(number,)) for number in range(len(tasks))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return results


def opened_again(book: Book) -> Book:
    """The same book as another workstation opens it."""
    return open_book(book.engine.url.render_as_string(hide_password=False))


def test_four_writers_lose_nothing(book: Book, small_job: MakeJob) -> None:
    """Each saves jobs of its own, all of the same unit, and one that all of them change."""
    shared = book.save(small_job(number="shared"))
    sheets = [small_job(11.03 + writer / 100, transmission={"serial": "A1"}) for writer in range(4)]

    def write(writer: int) -> tuple[list[str], int]:
        mine, ids, won = opened_again(book), [], 0
        for _ in range(5):
            saved = mine.save(sheets[writer])
            ids.append(mine.save(sheets[(writer + 1) % 4], id=saved.id, version=1).id)
            try:
                mine.save(sheets[writer], id=shared.id, version=mine.version(shared.id))
                won += 1
            except ChangedElsewhere:
                pass
        mine.engine.dispose()
        return ids, won

    written = at_once(*(lambda writer=writer: write(writer) for writer in range(4)))
    assert not [each for each in written if isinstance(each, Exception)]
    ids = {id for several, _ in written for id in several}
    assert {row.id for row in book.rows()} == {*ids, shared.id}
    assert {book.version(id) for id in ids} == {2}
    assert book.version(shared.id) == 1 + sum(won for _, won in written)
    assert len({row.unit for row in book.rows()}) == 1
    assert verify(book) == ()


def test_of_two_savers_of_one_job_exactly_one_wins(book: Book, small_job: MakeJob) -> None:
    other = opened_again(book)
    jobs = {book: small_job(11.05), other: small_job(11.06)}
    saved = book.save(small_job(number="0"))
    for _ in range(3):
        version = saved.version
        savers = (partial(each.save, jobs[each], id=saved.id, version=version) for each in jobs)
        results = at_once(*savers)
        (saved,) = [result for result in results if isinstance(result, Saved)]
        (lost,) = [result for result in results if not isinstance(result, Saved)]
        assert isinstance(lost, ChangedElsewhere), lost
        assert book.version(saved.id) == saved.version == version + 1
    other.engine.dispose()
    assert verify(book) == ()


# --- a disk that takes no more, and one that may not be written


@pytest.fixture
def held(new_book_on: Callable[[str], Book], small_job: MakeJob) -> tuple[Book, Saved]:
    """A book on SQLite with one job."""
    book = new_book_on("sqlite")
    return book, book.save(small_job(number="safe"))


def large(small_job: MakeJob) -> JobParts:
    """A job with a photo of a megabyte that cannot be packed."""
    parts = small_job(number="large", photos=[{"file": "bore.png"}])
    return replace(parts, pictures={"bore.png": random.Random(1).randbytes(1 << 20)})


def refused(book: Book, saved: Saved, parts: JobParts, said: str) -> None:
    """Saving is refused in words, and the book keeps what it had."""
    for id, version in ((None, None), (saved.id, saved.version)):
        with pytest.raises(BookError, match=rf"\.sqlite: the job book cannot be used: {said}"):
            book.save(parts, id=id, version=version)
    assert [(row.id, row.number) for row in book.rows()] == [(saved.id, "safe")]
    assert verify(book) == ()


def test_a_full_disk_is_said_and_the_book_stays(held: tuple[Book, Saved], small_job: MakeJob) -> None:
    """SQLite says the same where it may take no more pages as where the disk has none."""
    book, saved = held
    book.engine.dispose()

    def limit(connection: Any, _record: Any) -> None:
        (pages,) = connection.execute("PRAGMA page_count").fetchone()
        connection.execute(f"PRAGMA max_page_count = {pages + 3}")

    sa.event.listen(book.engine, "connect", limit)
    refused(book, saved, large(small_job), "the disk is full")
    sa.event.remove(book.engine, "connect", limit)
    book.engine.dispose()
    assert book.save(large(small_job), id=saved.id, version=saved.version).version == 2


def test_a_file_that_may_not_grow_is_said_and_the_book_stays(held: tuple[Book, Saved], small_job: MakeJob) -> None:
    """The system itself refuses to write: after a part of the save has been written."""
    resource = pytest.importorskip("resource", reason="this system has no such limit")
    book, saved = held
    parts, before = large(small_job), resource.getrlimit(resource.RLIMIT_FSIZE)
    grown = max(path.stat().st_size for path in Path(book.name).parent.glob("book_0.sqlite*"))
    resource.setrlimit(resource.RLIMIT_FSIZE, (grown + (600 << 10), before[1]))
    try:
        refused(book, saved, parts, "the disk cannot be written")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert book.save(parts, id=saved.id, version=saved.version).version == 2


def test_a_book_that_may_not_be_written_says_so(held: tuple[Book, Saved], small_job: MakeJob) -> None:
    book, saved = held
    book.engine.dispose()

    def forbid(connection: Any, _record: Any) -> None:
        connection.execute("PRAGMA query_only = ON")

    sa.event.listen(book.engine, "connect", forbid)
    refused(book, saved, small_job(11.05), "it may not be written")


def test_a_folder_in_which_no_book_can_be_made_is_named(tmp_path: Path) -> None:
    with pytest.raises(BookError, match=r"nowhere/book\.sqlite: .*its folder may not be written, or is not there"):
        open_book(f"sqlite:///{(tmp_path / 'nowhere' / 'book.sqlite').as_posix()}")


# --- other versions of atleak


def test_a_newer_book_is_refused_by_name_and_stays(book: Book, small_job: MakeJob) -> None:
    book.save(small_job(number="safe"))
    with book.writing() as connection:
        connection.exec_driver_sql("UPDATE alembic_version SET version_num = '9999'")
        connection.execute(about.update().values(atleak="7.1.0"))
    with pytest.raises(BookError, match=r"was made by atleak 7\.1\.0, which is newer than .* atleak to be updated"):
        opened_again(book)
    with book.writing() as connection:
        assert connection.execute(sa.select(jobs.c.number)).scalars().all() == ["safe"]
        assert connection.execute(sa.select(about.c.atleak)).scalars().all() == ["7.1.0"]
        connection.exec_driver_sql(f"UPDATE alembic_version SET version_num = '{opening.REVISION}'")
    opened_again(book).engine.dispose()


LATER = """
import sqlalchemy as sa
from alembic import op

revision, down_revision = "9999", "{before}"

def upgrade():
    op.create_table("later", sa.Column("id", sa.Integer, primary_key=True))
    with op.batch_alter_table("visits") as table:
        table.add_column(sa.Column("later", sa.String(8), server_default="new"))
    {then}
"""


@pytest.fixture
def later(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[str], None]:
    """Lets this version of atleak have a later revision of the tables; what its migration does last is told."""
    folder = tmp_path / "migrations"
    shutil.copytree(opening._MIGRATIONS, folder)
    before = opening.REVISION
    monkeypatch.setattr(opening, "_MIGRATIONS", folder)
    monkeypatch.setattr(opening, "REVISION", "9999")

    def write(then: str) -> None:
        text = LATER.format(before=before, then=then)
        (folder / "versions" / "r9999_later.py").write_text(text, encoding="utf-8")

    return write


def revision(book: Book) -> str:
    with book.reading() as connection:
        return connection.exec_driver_sql("SELECT version_num FROM alembic_version").scalar_one()


def test_a_book_of_an_earlier_version_is_brought_up_to_date(
    book: Book, small_job: MakeJob, later: Callable[[str], None]
) -> None:
    saved = book.save(small_job(number="safe"))
    later("pass")
    migrated = opened_again(book)
    assert revision(migrated) == "9999"
    assert migrated.load(saved.id).file.job.number == "safe"
    with migrated.reading() as connection:
        assert connection.exec_driver_sql("SELECT later FROM visits").scalars().all() == ["new"]
    assert verify(migrated) == ()
    migrated.engine.dispose()


def test_a_migration_that_fails_leaves_the_book_as_it_was(
    book: Book, small_job: MakeJob, later: Callable[[str], None]
) -> None:
    book.save(small_job(number="safe"))
    before = revision(book)
    later('raise RuntimeError("half-way")')
    with pytest.raises(RuntimeError, match="half-way"):
        opened_again(book)
    assert revision(book) == before
    assert not sa.inspect(book.engine).has_table("later")
    assert "later" not in {column["name"] for column in sa.inspect(book.engine).get_columns("visits")}
    assert verify(book) == ()


AS_BEFORE = """
CREATE TABLE vehicles (id SERIAL PRIMARY KEY, key VARCHAR(80) NOT NULL UNIQUE, vin VARCHAR(80), plate VARCHAR(80));
INSERT INTO vehicles (key, vin, plate) VALUES ('vin:V1', 'V1', 'P1');
ALTER TABLE visits ADD COLUMN vehicle INTEGER REFERENCES vehicles (id);
UPDATE visits SET vehicle = 1;
ALTER TABLE decisions ALTER COLUMN component TYPE VARCHAR(80);
DROP TABLE customer_links;
ALTER TABLE jobs DROP COLUMN made_on;
ALTER TABLE jobs DROP COLUMN erased;
ALTER TABLE units DROP COLUMN merged_with;
UPDATE units SET merged_into = id + 1 WHERE id < (SELECT max(id) FROM units);
UPDATE alembic_version SET version_num = '0001'
"""


def test_a_book_on_a_server_is_brought_up_to_date_from_the_first_tables(
    postgresql: Any, small_job: MakeJob, tmp_path: Path
) -> None:
    """Of those on SQLite the files of earlier releases tell."""
    address = postgresql.address(postgresql.new_database())
    book = open_book(address)
    for number in range(4):
        book.save(small_job(number=str(number)))
    days = [(row.number, row.made_on) for row in book.rows()]
    with book.writing() as connection:
        for statement in AS_BEFORE.split(";"):
            connection.exec_driver_sql(statement)
    book.engine.dispose()
    book = open_book(address)
    assert len({row.unit for row in book.rows()}) == 1
    assert [(row.number, row.made_on) for row in book.rows()] == days
    assert verify(book) == ()
    assert not sa.inspect(book.engine).has_table("vehicles")
    book.save(small_job(repair_decisions=[{"component": "c" * 200}]))
    assert backup(book, tmp_path / "backup") == 5
    book.engine.dispose()
