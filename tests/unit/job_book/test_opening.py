"""Where a book is, whose it is, and what is said where it is none that can be used."""

from __future__ import annotations

import datetime as dt
import gc
import gzip
import os
import shutil
import stat
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import sqlalchemy as sa

from atleak.common.errors import BookError
from atleak.job.case import Case, SourceFile
from atleak.job.parts import JobParts, job_parts
from atleak.job_book import database as opening
from atleak.job_book.backup import backup, verify
from atleak.job_book.book import Book, local_time, open_book
from atleak.job_book.exchange import job_file
from atleak.job_book.search import Query
from atleak.job_book.tables import jobs, visits
from atleak.job_book.unit_history import visits_of_unit
from atleak.measurements.job_card import Job
from atleak.measurements.own_forms import TYPED

Small = Callable[..., JobParts]
RELEASE = Path(__file__).parents[2] / "releases" / "0.2.0"
POSIX = pytest.mark.skipif(os.name != "posix", reason="permissions of POSIX")


@pytest.fixture
def opened() -> Iterator[Callable[..., Book]]:
    """Opens books as a program does that is started anew."""
    books: list[Book] = []

    def make(url: str | None = None) -> Book:
        books.append(open_book(url))
        return books[-1]

    yield make
    for book in books:
        book.engine.dispose()


# --- one book, whatever the form of its path


@pytest.mark.parametrize(
    ("variable", "value", "file"),
    [
        ("ATLEAK_HOME", "shop", "shop/book.sqlite"),
        ("ATLEAK_DATABASE_URL", "sqlite:///mine.sqlite", "mine.sqlite"),
        ("ATLEAK_DATABASE_URL", "sqlite:///./mine.sqlite?timeout=5", "mine.sqlite"),
    ],
)
def test_a_relative_path_is_of_the_folder_in_which_it_was_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, opened: Callable[..., Book], variable: str, value: str, file: str
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv(variable, value)
    book = opened()
    assert Path(book.name) == tmp_path / file
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    assert book.rows() == []
    book.engine.dispose()
    assert book.rows() == []
    assert not list((tmp_path / "elsewhere").iterdir())


def test_no_book_is_made_in_a_folder_of_the_package(monkeypatch: pytest.MonkeyPatch) -> None:
    package = Path(opening.__file__).parents[1]
    monkeypatch.chdir(package)
    with pytest.raises(BookError, match=r"book\.sqlite: lies in a folder of atleak itself, which an update replaces"):
        open_book("sqlite:///book.sqlite")
    assert not (package / "book.sqlite").exists()


# --- a file that is moved away while it is open


def test_what_is_saved_after_the_file_was_moved_away_is_refused_until_one_is_there(
    tmp_path: Path, opened: Callable[..., Book], small_job: Small
) -> None:
    book = opened(f"sqlite:///{tmp_path / 'book.sqlite'}")
    saved = book.save(small_job(number="before"))
    (tmp_path / "away").mkdir()
    for file in tmp_path.glob("book.sqlite*"):
        file.rename(tmp_path / "away" / file.name)
    with pytest.raises(BookError, match=r"book\.sqlite: the job book was moved away while atleak had it open"):
        book.save(small_job(number="lost"))
    assert not list(tmp_path.glob("book.sqlite*"))
    other = opened(f"sqlite:///{tmp_path / 'other.sqlite'}")
    other.save(small_job(number="other"))
    other.engine.dispose()
    shutil.move(tmp_path / "other.sqlite", tmp_path / "book.sqlite")  # as a backup is brought back
    kept = book.save(small_job(number="kept"))
    assert {row.number for row in book.rows()} == {"other", "kept"}
    with pytest.raises(BookError, match="no such job"):
        book.save(small_job(number="again"), id=saved.id, version=saved.version)
    now = opened(f"sqlite:///{tmp_path / 'book.sqlite'}")
    assert kept.id in {row.id for row in now.rows()}
    assert verify(now) == ()


def test_a_file_that_took_the_place_of_the_open_one_is_the_book(
    tmp_path: Path, opened: Callable[..., Book], small_job: Small
) -> None:
    paths = [tmp_path / name / "book.sqlite" for name in ("one", "two")]
    for path in paths:
        path.parent.mkdir()
        opened(f"sqlite:///{path}").save(small_job(number=path.parent.name))
    book = opened(f"sqlite:///{paths[0]}")
    assert [row.number for row in book.rows()] == ["one"]
    backup(opened(f"sqlite:///{paths[1]}"), tmp_path / "copy")
    for path in paths[0].parent.glob("book.sqlite*"):
        path.unlink()
    shutil.copy(tmp_path / "copy", paths[0])
    assert [row.number for row in book.rows()] == ["two"]


def test_the_advice_on_a_damaged_file_names_all_three(tmp_path: Path, opened: Callable[..., Book]) -> None:
    path = tmp_path / "book.sqlite"
    opened(f"sqlite:///{path}").engine.dispose()
    content = bytearray(path.read_bytes())
    content[100:4096] = bytes(3996)
    path.write_bytes(content)
    with pytest.raises(BookError, match=r"move book\.sqlite, book\.sqlite-wal and book\.sqlite-shm away"):
        opened(f"sqlite:///{path}").rows()


# --- whose it is


@POSIX
def test_book_backup_and_folder_are_the_users_alone(
    own_home: Path, opened: Callable[..., Book], small_job: Small, tmp_path: Path
) -> None:
    book = opened()
    book.save(small_job())
    (tmp_path / "shop.backup").write_bytes(b"an earlier one")
    backup(book, tmp_path / "shop.backup")
    files = [*own_home.glob("book.sqlite*"), tmp_path / "shop.backup"]
    assert len(files) == 4
    assert {stat.S_IMODE(file.stat().st_mode) for file in files} == {0o600}
    assert stat.S_IMODE(own_home.stat().st_mode) == 0o700


@pytest.mark.parametrize(
    "where", ["postgresql://shop:{}@127.0.0.1:1/book", "postgresql://shop@127.0.0.1:1/book?password={}"]
)
def test_no_password_is_said(where: str) -> None:
    with pytest.raises(BookError) as refused:
        open_book(where.format("TOPSECRET"))
    assert str(refused.value).startswith("postgresql://shop")
    assert "TOPSECRET" not in str(refused.value)
    assert opening.shown(opening.database_url(where.format("TOPSECRET"))).endswith("127.0.0.1:1/book")


# --- a book that may only be read


@pytest.fixture
def unwritable(tmp_path: Path, opened: Callable[..., Book], small_job: Small, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A book of one job on a medium that may not be written."""
    path = tmp_path / "archive" / "book.sqlite"
    path.parent.mkdir()
    book = opened(f"sqlite:///{path}")
    book.save(small_job(number="kept"))
    book.engine.dispose()
    assert [file.name for file in path.parent.iterdir()] == ["book.sqlite"]
    path.chmod(0o400)
    path.parent.chmod(0o500)
    may = os.access  # who runs tests may be allowed everything

    def may_here(where: str | Path, mode: int, **_: object) -> bool:
        return may(where, mode) and not (mode == os.W_OK and Path(where).is_relative_to(path.parent))

    monkeypatch.setattr(os, "access", may_here)
    return path


def test_a_book_that_may_only_be_read_is_listed_shown_exported_and_backed_up(
    unwritable: Path, opened: Callable[..., Book], small_job: Small, tmp_path: Path
) -> None:
    book = opened(f"sqlite:///{unwritable}")
    (row,) = book.rows()
    assert book.load(row.id).file.job.number == "kept"
    assert job_file(book, row.id)
    assert verify(book) == ()
    assert backup(book, tmp_path / "copy") == 1
    with pytest.raises(BookError, match="it may not be written"):
        book.save(small_job())
    with pytest.raises(BookError, match="it may not be written"):
        book.archive(row.id)
    assert [file.name for file in unwritable.parent.iterdir()] == ["book.sqlite"]


def test_an_earlier_book_that_may_only_be_read_is_read_from_a_copy_that_goes_with_it(
    unwritable: Path, small_job: Small, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    unwritable.parent.chmod(0o700)
    unwritable.chmod(0o600)
    unwritable.write_bytes(gzip.decompress((RELEASE / "book.sqlite.gz").read_bytes()))
    held = unwritable.read_bytes()
    (copies := tmp_path / "copies").mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(copies))
    book = open_book(f"sqlite:///{unwritable}")
    assert book.name == str(unwritable)
    assert {row.number for row in book.rows()} == {"", "A-1", "A-2", "B-7"}
    assert verify(book) == ()
    assert backup(book, tmp_path / "copy") == 5
    with pytest.raises(BookError, match="it may not be written"):
        book.save(small_job())
    with pytest.raises(BookError, match="it may not be written"):
        book.archive(book.rows()[0].id)
    assert list(copies.iterdir())
    del book
    gc.collect()
    assert not list(copies.iterdir())
    assert [file.name for file in unwritable.parent.iterdir()] == ["book.sqlite"]
    assert unwritable.read_bytes() == held


# --- numbers that 0.2.0 made of a plan

PLAN = '"parts", "directions": 2, "repeats": 2, "planes": null, "lands": []}'


@pytest.fixture
def typed_job() -> Callable[..., JobParts]:
    """Makes a job of readings that were typed in one plan, for one vehicle; the keywords are those of its record."""
    rows = ["sep=;", TYPED.mark + ';"{""order"": ' + PLAN.replace('"', '""') + '"', "Controller minimal_example"]
    rows += ["No.;Part;Plane;Direction;Repeat;Diameter [mm];Counts;Taken at"]
    rows += [
        f"tcc_regulator;{part};1;{d};1;11.0{n};yes;" for n, part in enumerate(("spool", "sleeve")) for d in (0, 90)
    ]
    case = Case(readings=SourceFile("typed readings.csv", "\r\n".join(rows).encode()), controller="minimal_example")
    diagnosis = case.diagnose()

    def make(**record: Any) -> JobParts:
        return job_parts(diagnosis, Job(**record, vehicle={"vin": "WVWZZZ1JZXW000001"}), case)

    return make


def test_a_number_that_was_a_plan_is_emptied_once_and_noted_and_no_other(
    book: Book, opened: Callable[..., Book], typed_job: Callable[..., JobParts], small_job: Small
) -> None:
    mine = {
        "of a plan": typed_job(number=PLAN, notes="leaks when hot", date=dt.date(2026, 3, 2)),
        "of a plan, later": typed_job(number=PLAN, date=dt.date(2026, 4, 2)),
        "typed": typed_job(number=PLAN.replace("2", "3")),
        "without such a sheet": small_job(number=PLAN),
    }
    ids = {name: book.save(parts).id for name, parts in mine.items()}
    assert len({row.visit for row in book.rows()}) == 3  # those of a plan are one
    with book.writing() as connection:  # the book as 0.2.0 would have it
        connection.exec_driver_sql("DROP TABLE customer_links")
        connection.exec_driver_sql("ALTER TABLE jobs DROP COLUMN erased")
        connection.exec_driver_sql("UPDATE alembic_version SET version_num = '0002'")
    url = book.engine.url.render_as_string(hide_password=False)
    book.engine.dispose()
    for _ in range(2):
        now = opened(url)
        rows = {row.id: row for row in now.rows()}
        assert {name: rows[id].number for name, id in ids.items()} == {
            "of a plan": "",
            "of a plan, later": "",
            "typed": mine["typed"].job.number,
            "without such a sheet": PLAN,
        }
        assert len({row.visit for row in rows.values()}) == 4
        assert len({row.unit for row in rows.values()}) == 2
        stored = [now.load(ids[name]) for name in mine]
        assert [each.version for each in stored] == [2, 2, 1, 1]
        first, *rest = stored[0].file.job.notes.splitlines()
        assert first == "leaks when hot"
        assert [line.endswith(f"It read: {PLAN}") for line in (*rest, stored[1].file.job.notes)] == [True, True]
        assert stored[2].file.job.notes == stored[3].file.job.notes == ""
        with now.reading() as connection:
            days = connection.execute(sa.select(visits.c.date).where(visits.c.number == "")).scalars()
            assert sorted(days) == [dt.date(2026, 3, 2), dt.date(2026, 4, 2)]
        assert now.count(Query(number="lands")) == 2
        assert verify(now) == ()


# --- moments and days


@pytest.fixture
def in_zone(monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[str], None]]:
    """Sets the clock of this machine to a zone."""
    if not hasattr(time, "tzset"):
        pytest.skip("this system's zone cannot be changed for one process")

    def set_to(zone: str) -> None:
        monkeypatch.setenv("TZ", zone)
        time.tzset()

    with monkeypatch.context():
        yield set_to
    monkeypatch.undo()
    time.tzset()


@pytest.mark.parametrize("zone", ["MST7", "JST-9", "UTC0"])
def test_days_are_those_of_the_shop_and_moments_alike_on_both_databases(
    book: Book, small_job: Small, in_zone: Callable[[str], None], zone: str
) -> None:
    in_zone(zone)
    if book.engine.dialect.name == "postgresql":
        with book.writing() as connection:  # a server that counts in another zone
            connection.exec_driver_sql(
                f"ALTER DATABASE {book.engine.url.database} SET timezone TO 'America/Los_Angeles'"
            )
        book.engine.dispose()
    today = dt.date.today()
    saved = book.save(small_job(transmission={"serial": "A1"}))
    stored = book.load(saved.id)
    assert stored.changed_at.utcoffset() == dt.timedelta(0)
    assert abs(stored.changed_at - dt.datetime.now(dt.UTC)) < dt.timedelta(minutes=5)
    assert stored.made_on in (today, dt.date.today())
    (visited,) = visits_of_unit(book, stored.unit)
    assert visited.date == stored.made_on
    with book.reading() as connection:
        assert connection.execute(sa.select(sa.func.date(jobs.c.changed_at))).scalar() in (
            stored.changed_at.date(),
            stored.changed_at.date().isoformat(),
        )
    said = {"MST7": "2026-04-17 18:30-07:00", "JST-9": "2026-04-18 10:30+09:00", "UTC0": "2026-04-18 01:30+00:00"}
    assert local_time(dt.datetime(2026, 4, 18, 1, 30, tzinfo=dt.UTC)) == said[zone]
    if book.engine.dialect.name == "postgresql":
        with book.writing() as connection:
            connection.exec_driver_sql(f"ALTER DATABASE {book.engine.url.database} RESET timezone")


# --- what one database takes, the other takes


def test_a_name_of_any_length_is_taken(book: Book, small_job: Small) -> None:
    long = "transmission range select valve " * 5
    texts = {
        "number": long,
        "transmission": {"serial": "S1" * 60},
        "vehicle": {"vin": "V1" * 60, "registration": "P" * 99},
    }
    saved = book.save(small_job(**texts, repair_decisions=[{"component": long, "work": long, "decision": "done"}]))
    assert book.load(saved.id).file.job.repair_decisions[0].component == long.strip()
    assert verify(book) == ()
