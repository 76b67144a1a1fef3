"""Jobs go out of the book as files and come in again: with the same verdict, and never twice."""

from __future__ import annotations

import datetime as dt
import io
import zipfile
from collections.abc import Callable

import pandas as pd
import pytest

from atleak.common.errors import BookError, InputError
from atleak.job.parts import JobParts
from atleak.job.zip_file import packed_job, read_job_file
from atleak.job_book.book import Book
from atleak.job_book.compared_jobs import job_of, named_job
from atleak.job_book.exchange import exported, import_job, job_file, job_file_name, table_bytes
from atleak.job_book.tables import jobs
from atleak.job_book.unit_history import across_units

Small = Callable[..., JobParts]


def test_a_job_comes_in_with_the_verdict_it_went_out_with_and_is_recognised(
    new_book: Callable[[], Book], small_job: Small
) -> None:
    book, other = new_book(), new_book()
    parts = small_job(number="7", date="2026-04-17", customer={"name": "Ana Lima"})
    id = book.save(parts).id
    content = job_file(book, id)
    assert read_job_file(content).result == parts.result
    assert import_job(book, content).known
    taken = import_job(other, content)
    assert (taken.known, taken.verdict, taken.differs) == (False, str(parts.diagnosis.verdict), ())
    assert other.load(taken.id).file.result == parts.result
    again = import_job(other, content)
    assert (again.known, again.id) == (True, taken.id)
    assert import_job(other, job_file(other, taken.id)).id == taken.id
    assert len(other.rows()) == 1


@pytest.mark.parametrize("database", ["sqlite"], indirect=True)
def test_the_same_files_with_another_record_are_another_job(book: Book, small_job: Small) -> None:
    first = job_file(book, book.save(small_job(number="7")).id)
    book.save(small_job(number="8"))
    book.save(small_job(number="7", notes="second visit"))
    book.save(small_job(sleeve=11.05, number="7"))
    assert import_job(book, first).known
    book.archive(named_job(book, import_job(book, first).id))
    assert import_job(book, first).known  # an archived job is not taken in anew
    assert len(book.rows()) == 3


@pytest.mark.parametrize("database", ["sqlite"], indirect=True)
def test_a_verdict_that_this_version_does_not_share_is_said(book: Book, small_job: Small) -> None:
    held = book.load(book.save(small_job()).id)
    assert held.result["verdict"] == "watch"
    earlier = packed_job(held.choices, held.sources, held.pictures, {**held.result, "verdict": "critical"})
    taken = import_job(book, earlier)
    (otherwise,) = taken.differs
    assert (taken.verdict, str(otherwise).startswith("the unit: critical")) == ("watch", True)
    with pytest.raises(InputError, match="no sound zip"):
        import_job(book, b"PK", name="torn.zip")


def test_tables_hold_jobs_lands_and_decisions(book: Book, small_job: Small) -> None:
    decisions = [{"component": "tcc_regulator", "land": 1, "work": "ream", "decision": "declined", "reason": "price"}]
    ids = [book.save(small_job(number=str(each), repair_decisions=decisions)).id for each in (1, 2)]
    book.archive(ids[0])
    files = {str(path.as_posix()): content for path, content in exported(book, ids)}
    assert [name for name in files if name.endswith(".zip")] == [job_file_name(ids[0], "1"), job_file_name(ids[1], "2")]
    jobs = pd.read_parquet(io.BytesIO(files["tables/jobs.parquet"]))
    assert sorted(jobs["id"]) == sorted(ids)
    assert jobs["archived_at"].notna().sum() == 1
    lands = pd.read_csv(io.BytesIO(files["tables/lands.csv"]))
    measured = lands[lands["measured"]]
    assert list(measured["radial_clearance_um"]) == pytest.approx([20.0, 20.0], abs=1e-9)
    decided = pd.read_csv(io.BytesIO(files["tables/decisions.csv"]))
    assert decided[["job", "decision", "reason"]].to_numpy().tolist() == [[id, "declined", "price"] for id in ids]


def test_no_text_of_a_table_is_a_formula() -> None:
    frame = pd.DataFrame({"customer": ["=1+1", "@x", "Ana"], "wear_percent": [-1.5, 2.0, 3.0]})
    assert table_bytes(frame, "csv").decode().splitlines() == [
        "customer,wear_percent",
        "'=1+1,-1.5",
        "'@x,2.0",
        "Ana,3.0",
    ]


def test_a_job_is_named_by_id_its_beginning_or_its_number(book: Book, small_job: Small) -> None:
    one, two = (book.save(small_job(number=number)).id for number in ("2026/117", "12"))
    book.archive(two)
    assert named_job(book, one) == named_job(book, one[:8]) == named_job(book, "2026-117") == one
    assert named_job(book, "12") == two
    assert named_job(book, two[:5].upper()) == two
    assert job_of("2026/117", book).job.number == "2026/117"
    with pytest.raises(BookError, match="no such job"):
        named_job(book, "2026")
    with pytest.raises(BookError, match="no such job"):
        named_job(book, "%%%%")
    book.save(small_job(number="12"))
    with pytest.raises(BookError, match="2 jobs of the job book are called so"):
        named_job(book, "12")


def test_what_the_book_alone_knows_of_a_job_goes_along(new_book: Callable[[], Book], small_job: Small) -> None:
    book, other = new_book(), new_book()
    sample = book.save(small_job(notes="sample played with", transmission={"serial": "A1"}), sample=True).id
    archived = book.save(small_job(number="8", transmission={"serial": "A2"})).id
    book.archive(archived)
    with book.writing() as connection:
        connection.execute(jobs.update().values(made_on=dt.date(2020, 2, 29)))
    for id in (sample, archived):
        kept = book.load(id)
        taken = other.load(import_job(other, job_file(book, id)).id)
        assert (taken.sample, taken.archived_at, taken.made_on) == (kept.sample, kept.archived_at, kept.made_on)
        assert job_file(other, taken.id) == job_file(book, id)
    assert across_units(other, "minimal_example").units == across_units(book, "minimal_example").units == 0


@pytest.mark.parametrize("database", ["sqlite"], indirect=True)
def test_a_job_of_which_the_book_knows_nothing_more_is_a_file_as_any_other(book: Book, small_job: Small) -> None:
    content = io.BytesIO(job_file(book, book.save(small_job(number="7", date="2026-04-17")).id))
    with zipfile.ZipFile(content, "a") as bundle:
        assert "book.json" not in bundle.namelist()
        bundle.writestr("book.json", '{"archived_at": "yesterday"}')
    with pytest.raises(InputError, match=r"job file: book\.json, key 'archived_at'"):
        import_job(book, content.getvalue())
