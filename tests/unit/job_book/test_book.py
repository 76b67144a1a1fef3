"""What the job book keeps, on both databases: jobs come back whole, and nothing is written over unnoticed."""

from __future__ import annotations

import io
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pandas as pd
import pytest
import sqlalchemy as sa

from atleak.common.errors import BookError, ChangedElsewhere
from atleak.job.case import Case, SourceFile
from atleak.job.parts import JobParts, job_parts
from atleak.job.result import judged_otherwise
from atleak.job_book.book import Book, open_book
from atleak.job_book.database import database_url
from atleak.job_book.search import Query
from atleak.job_book.tables import files, jobs, lands, log_tables, results, units, visits
from atleak.job_book.units import unit_of_job
from atleak.measurements.job_card import Job
from atleak.version import __version__

MakeJob = Callable[..., JobParts]
RECORD = {
    "number": "2026-0417",
    "customer": {"name": "Zażółć Gęślą"},
    "vehicle": {"vin": "WDB2100371A123456", "registration": "KR 12345", "mileage_km": 212_000.0},
    "transmission": {"serial": "722.608 0147"},
    "notes": "zweite Zeile\n12,715",
}


def count(book: Book, table: sa.Table) -> int:
    with book.reading() as connection:
        return connection.execute(sa.select(sa.func.count()).select_from(table)).scalar_one()


def test_a_job_comes_back_to_the_last_digit_and_to_the_same_verdict(book: Book, small_job: MakeJob) -> None:
    parts = small_job(**RECORD)
    saved = book.save(parts)
    stored = book.load(saved.id)
    assert stored.file.job == parts.job
    assert stored.file.case.readings is not None
    assert stored.file.case.readings.content == parts.sources["readings"].content
    assert stored.file.case.readings.name == "small.csv"
    assert stored.file.result == parts.result
    assert stored.result_by == __version__
    again = stored.file.diagnose()
    assert not judged_otherwise(stored.file.result, job_parts(again, stored.file.job, stored.file.case).result)
    assert (stored.version, stored.archived_at, stored.sample) == (1, None, False)


def test_pictures_come_back_and_those_that_are_dropped_leave_the_book(book: Book, small_job: MakeJob) -> None:
    parts = small_job(photos=[{"file": "photos/bore.png", "caption": "scored"}])
    with_picture = replace(parts, pictures={"photos/bore.png": b"the picture"})
    saved = book.save(with_picture)
    assert book.load(saved.id).file.job.pictures == {"photos/bore.png": b"the picture"}
    held = count(book, files)
    book.save(small_job(), id=saved.id, version=saved.version)
    assert count(book, files) == held - 1


def test_a_large_file_comes_back_and_is_named_where_it_was_damaged(book: Book, small_job: MakeJob) -> None:
    large = b"0.01;800.0;671.05\n" * 80_000
    parts = small_job(photos=[{"file": "photos/bore.png"}])
    saved = book.save(replace(parts, pictures={"photos/bore.png": large}))
    assert book.load(saved.id).file.job.pictures == {"photos/bore.png": large}
    with book.writing() as connection:
        kept = connection.execute(sa.select(files.c.content).where(files.c.size == len(large))).scalar_one()
        connection.execute(files.update().where(files.c.size == len(large)).values(content=kept[: len(kept) // 2]))
    with pytest.raises(BookError, match="was damaged in the database"):
        book.load(saved.id)


def test_two_jobs_share_the_bytes_of_a_file_and_keep_it_until_both_have_dropped_it(
    book: Book, small_job: MakeJob
) -> None:
    first, second = book.save(small_job()), book.save(small_job())
    held = count(book, files)
    book.save(small_job(11.05), id=first.id, version=1)
    assert count(book, files) == held + 1
    book.save(small_job(11.05), id=second.id, version=1)
    assert count(book, files) == held
    assert book.load(second.id).file.diagnose().measured == 1


def test_a_log_is_kept_as_a_table_of_its_channels_too(book: Book) -> None:
    log = "time [s],engine speed [rpm],ATF temperature [°C]\n0,800,80\n1,900,81\n2,1000,82\n"
    case = Case(road_test=SourceFile("log.csv", log.encode()), controller="minimal_example", remember=False)
    book.save(job_parts(case.diagnose(), Job(), case))
    with book.reading() as connection:
        content = connection.execute(sa.select(log_tables.c.parquet)).scalar_one()
    table = pd.read_parquet(io.BytesIO(content))
    assert list(table["time"]) == [0.0, 1.0, 2.0]
    assert table["engine_speed"].iloc[2] * 60.0 == pytest.approx(1000.0, abs=1e-9)
    assert list(table["atf_temperature"]) == [80.0, 81.0, 82.0]


def test_the_second_of_two_savers_is_told_and_nothing_is_written_over(book: Book, small_job: MakeJob) -> None:
    saved = book.save(small_job(technician="first"))
    book.save(small_job(technician="second"), id=saved.id, version=saved.version)
    with pytest.raises(ChangedElsewhere, match="saved elsewhere by second at"):
        book.save(small_job(technician="third"), id=saved.id, version=saved.version)
    assert book.load(saved.id).file.job.technician == "second"
    assert book.version(saved.id) == 2


def test_a_job_that_is_not_there_is_named(book: Book, small_job: MakeJob) -> None:
    for ask in (book.load, book.version, book.archive, lambda id: book.save(small_job(), id=id, version=1)):
        with pytest.raises(BookError, match=r"has no such job \(found 'feed'\)"):
            ask("feed")


def test_a_save_that_fails_leaves_the_book_as_it_was(
    book: Book, small_job: MakeJob, monkeypatch: pytest.MonkeyPatch
) -> None:
    saved = book.save(small_job(number="1"))
    before = [count(book, table) for table in (files, results, lands, visits, units)]

    def fail(*_: object) -> None:
        raise RuntimeError("in the middle")

    monkeypatch.setattr("atleak.job_book.book._keep_result", fail)
    with pytest.raises(RuntimeError):
        book.save(small_job(11.05, number="2"), id=saved.id, version=1)
    assert [count(book, table) for table in (files, results, lands, visits, units)] == before
    assert book.load(saved.id).file.job.number == "1"


LOOK_UPS = [
    (Query(text="zażółć"), True),
    (Query(text="GĘŚ 2026"), True),
    (Query(text="3456"), True),  # the end of the VIN
    (Query(text="kr12345"), True),
    (Query(vin="wdb 210-037"), True),
    (Query(plate="KR 123"), True),
    (Query(serial="7226080147"), True),
    (Query(number="2026 0417"), True),
    (Query(customer="Gęślą"), True),
    (Query(customer="WDB"), False),  # which is no customer
    (Query(text="zażółć 2025"), False),
    (Query(text="żółć"), False),  # not the beginning of a word
    (Query(controller="minimal_example"), True),
    (Query(controller="four_speed_2023"), False),
]


def test_a_job_is_looked_up_by_what_a_workshop_knows_of_it(book_of_two: Book) -> None:
    for query, meant in LOOK_UPS:
        numbers = {row.number for row in book_of_two.rows(query)}
        assert ("2026-0417" in numbers) is meant, query
        assert book_of_two.count(query) == len(numbers)


@pytest.fixture
def book_of_two(book: Book, small_job: MakeJob) -> Book:
    book.save(small_job(number="other", customer={"name": "Other"}))
    book.save(small_job(**RECORD))
    return book


def test_the_list_is_newest_first_and_leaves_archived_jobs_out(book_of_two: Book, small_job: MakeJob) -> None:
    newest, other = book_of_two.rows()
    assert (newest.number, other.number) == ("2026-0417", "other")
    assert (newest.mileage_km, newest.serial) == (212_000.0, "722.608 0147")
    assert newest.verdict == small_job(**RECORD).diagnosis.verdict
    book_of_two.archive(newest.id)
    assert [row.id for row in book_of_two.rows()] == [other.id]
    assert [row.id for row in book_of_two.rows(Query(archived=True))] == [newest.id]
    assert book_of_two.load(newest.id).archived_at is not None
    book_of_two.archive(newest.id, back=True)
    assert book_of_two.count() == 2
    assert [row.id for row in book_of_two.rows(Query(limit=1, offset=1))] == [other.id]


def test_a_unit_is_told_by_serial_else_vin_else_plate(book: Book, small_job: MakeJob) -> None:
    def unit(serial: str = "", vin: str = "", plate: str = "") -> int:
        record = {"transmission": {"serial": serial}, "vehicle": {"vin": vin, "registration": plate}}
        return book.load(book.save(small_job(**record)).id).unit

    assert unit(serial="722 608") == unit(serial="722-608", vin="another car")
    assert unit(vin="WDB 1") == unit(vin="wdb1", plate="KR 1") != unit(vin="WDB 2")
    assert unit(plate="KR 1") == unit(plate="kr1")
    assert unit() != unit()
    assert unit(serial="unknown", vin="WDB 7") != unit(serial="unknown", vin="WDB 8"), "which is no number"


def test_correcting_a_vin_leaves_no_unit_or_visit_behind(book: Book, small_job: MakeJob) -> None:
    saved = book.save(small_job(number="1", vehicle={"vin": "WDB1"}))
    book.save(small_job(number="1", vehicle={"vin": "WDB2"}), id=saved.id, version=1)
    assert (count(book, units), count(book, visits)) == (1, 1)


def test_jobs_of_one_number_and_unit_are_one_visit(book: Book, small_job: MakeJob) -> None:
    before = book.save(small_job(number="17", vehicle={"vin": "WDB1"}))
    after = book.save(small_job(11.02, number="17", vehicle={"vin": "WDB1"}))
    later = book.save(small_job(number="18", vehicle={"vin": "WDB1"}))
    rows = {row.id: row for row in book.rows()}
    assert rows[before.id].visit == rows[after.id].visit != rows[later.id].visit
    assert len({row.unit for row in rows.values()}) == 1
    assert len(book.rows(Query(unit=rows[before.id].unit))) == 3


def test_each_version_of_the_program_keeps_its_own_result(
    book: Book, small_job: MakeJob, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("atleak.job_book.book.__version__", "0.1.9")
    saved = book.save(small_job())
    assert book.load(saved.id).result_by == "0.1.9"
    monkeypatch.undo()
    book.save(small_job(11.05), id=saved.id, version=1)
    assert book.load(saved.id).result_by == __version__
    assert count(book, results) == 2
    assert count(book, lands) == len(small_job().diagnosis.lands)


def test_a_verdict_that_differs_is_named_with_what_it_was(small_job: MakeJob) -> None:
    worn, new = small_job(11.04).result, small_job(11.02).result
    assert not judged_otherwise(worn, worn)
    differing = [str(each) for each in judged_otherwise(new, worn)]
    assert differing[0].startswith("the unit: ")
    assert "tcc_regulator/1: ok (conditional pass), today watch (conditional fail)" in differing
    assert "not judged, today" in str(judged_otherwise({}, worn)[0])


@pytest.mark.parametrize("url", ["mysql://server/book", "sqlite://", "no url", "postgresql://u:p@server:port/book"])
def test_a_database_that_holds_no_book_is_refused_in_words(url: str) -> None:
    with pytest.raises(BookError, match="expected sqlite:///"):
        open_book(url)


def test_whatever_driver_a_url_names_the_one_that_is_installed_is_taken() -> None:
    urls = [database_url(f"{name}:///book") for name in ("sqlite+aiosqlite", "postgresql+asyncpg")]
    assert [url.drivername for url in urls] == ["sqlite", "postgresql+psycopg"]


def test_a_password_is_never_shown() -> None:
    with pytest.raises(BookError, match="does not answer") as refused:
        open_book("postgresql://shop:secret@127.0.0.1:1/book")
    assert "secret" not in str(refused.value)


def test_damaged_bytes_are_noticed(book: Book, small_job: MakeJob) -> None:
    saved = book.save(small_job())
    with book.writing() as connection:
        connection.execute(files.update().values(content=b"x"))
    with pytest.raises(BookError, match=r"damaged in the database"):
        book.load(saved.id)


def test_a_job_is_loaded_as_it_was_at_one_moment(
    book: Book, small_job: MakeJob, monkeypatch: pytest.MonkeyPatch
) -> None:
    saved = book.save(small_job(11.04, number="before"))

    def saved_meanwhile(connection: Any, visit: int) -> int:
        monkeypatch.undo()
        book.save(small_job(11.06, number="after"), id=saved.id, version=saved.version)
        return unit_of_job(connection, visit)

    monkeypatch.setattr("atleak.job_book.book.unit_of_job", saved_meanwhile)
    stored = book.load(saved.id)
    assert stored.file.job.number == "before"
    assert stored.file.case.readings == small_job(11.04).case.readings
    assert stored.file.result["readings"]["sha256"] == stored.file.case.readings.sha256
    assert book.load(saved.id).file.job.number == "after"


def test_a_save_that_waited_for_one_that_waited_for_it_is_tried_again(
    book: Book, small_job: MakeJob, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Deadlock(Exception):
        sqlstate = "40P01"

    save_in = Book.save_in

    def crossed(self: Book, connection: Any, *given: Any) -> Any:
        monkeypatch.undo()
        save_in(self, connection, *given)
        raise sa.exc.OperationalError("UPDATE vehicles", None, Deadlock("deadlock detected"))

    monkeypatch.setattr(Book, "save_in", crossed)
    saved = book.save(small_job(number="once"))
    assert [(row.id, row.number) for row in book.rows()] == [(saved.id, "once")]


def test_a_job_that_is_gone_since_it_was_opened_was_changed_elsewhere(book: Book, small_job: MakeJob) -> None:
    saved = book.save(small_job())
    with book.writing() as connection:
        connection.execute(jobs.delete())
    with pytest.raises(ChangedElsewhere, match="no such job"):
        book.save(small_job(number="17"), id=saved.id, version=saved.version)
    assert book.count() == 0


def test_a_job_without_its_result_is_refused_in_words(book: Book, small_job: MakeJob) -> None:
    saved = book.save(small_job(number="17"))
    with book.writing() as connection:
        connection.execute(results.delete())
    with pytest.raises(BookError, match="the stored result of job 17 is missing"):
        book.load(saved.id)


def test_what_no_database_can_hold_is_refused_in_words(book: Book) -> None:
    for asked in (Query(unit=10**30), Query(controller="\ud800")):
        with pytest.raises(BookError, match="the job book cannot be used"):
            book.rows(asked)


def test_a_result_is_computed_before_a_transaction_makes_others_wait(
    book: Book, small_job: MakeJob, monkeypatch: pytest.MonkeyPatch
) -> None:
    save_in, computed = Book.save_in, []

    def watched(self: Book, connection: Any, parts: JobParts, *given: Any) -> Any:
        computed.append("result" in vars(parts))
        return save_in(self, connection, parts, *given)

    monkeypatch.setattr(Book, "save_in", watched)
    saved = book.save(small_job())
    book.save(small_job(number="17"), id=saved.id, version=saved.version)  # of the same files and choices: not needed
    assert computed == [True, False]
