"""The dashboard's job is kept in the job book as it is typed, and comes back from there."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from threading import Event
from types import SimpleNamespace

import pytest
from streamlit.testing.v1 import AppTest

from atleak.common.errors import InputError
from atleak.job.case import Case
from atleak.job.parts import JobParts, job_parts
from atleak.job.zip_file import packed_job
from atleak.job_book.book import Book, open_book
from atleak.measurements.job_card import Job
from pages.shared import book as kept_in
from pages.shared.show import named
from pages.shared.state import InBook
from tests.unit.pages.conftest import go, number, press, texts, uploader

pytestmark = [pytest.mark.page("1_Job"), pytest.mark.saved]


@pytest.fixture
def book(app: AppTest) -> Book:
    """The book of the dashboard under test, in the folder that the fixture `app` has set."""
    return open_book()


def field(app: AppTest, label: str):
    return next(widget for widget in app.main.text_input if widget.label == label)


def reloaded(app: AppTest, page: str = "1_Job") -> AppTest:
    """The same address in a browser that knows nothing of the first."""
    other = AppTest.from_file(app._script_path, default_timeout=240)
    other.query_params["job"] = app.query_params["job"]
    return go(other, page)


def test_nothing_is_kept_of_a_sample_that_is_only_looked_at(app: AppTest, book: Book) -> None:
    assert "job" not in app.query_params
    assert not book.rows()


def test_of_a_sample_that_is_played_with_nothing_is_kept_unless_somebody_asks(app: AppTest, book: Book) -> None:
    field(app, "Name").set_value("Example Workshop").run()
    assert not book.rows()
    assert field(go(go(app, "4_Diagnosis"), "1_Job"), "Name").value == "Example Workshop"
    press(app, "Keep it in the job book")
    (row,) = book.rows()
    assert row.sample
    field(app, "Job number").set_value("17").run()
    assert [row.number for row in book.rows()] == ["17"]


def test_a_job_is_kept_from_its_first_digit_on_and_its_address_brings_it_back(app: AppTest, book: Book) -> None:
    press(app, "New, empty job")
    field(app, "Job number").set_value("2026-0417").run()
    number(app, "Mileage [km]").set_value("212345,5").run()
    (row,) = book.rows()
    assert (row.number, row.mileage_km, row.sample) == ("2026-0417", 212345.5, False)
    assert app.query_params["job"] == row.id
    again = reloaded(app)
    assert not again.exception
    assert field(again, "Job number").value == "2026-0417"
    assert number(again, "Mileage [km]").value == "212345.5"
    assert "In the job book: **2026-0417**" in texts(again)
    assert book.version(row.id) == 2, "opening a job saves nothing"


def test_two_runs_of_one_session_at_once_keep_one_job(monkeypatch: pytest.MonkeyPatch) -> None:
    """Streamlit begins a run for the next field while the last one still writes to the book."""
    saves: list[str | None] = []
    begun, go_on = Event(), Event()

    def save(parts: object, *, id: str | None, version: int | None, sample: bool) -> SimpleNamespace:
        saves.append(id)
        begun.set()
        assert go_on.wait(20)
        return SimpleNamespace(id=id or f"job{len(saves)}", version=len(saves))

    now = SimpleNamespace(in_book=InBook(state="as it was opened"), good=SimpleNamespace(sample=False))
    states = iter(["one field typed", "one field typed", "two fields typed", "two fields typed"])
    monkeypatch.setattr(kept_in, "session", lambda: now)
    monkeypatch.setattr(kept_in, "state_of_job", lambda: next(states))
    monkeypatch.setattr(kept_in, "book", lambda: SimpleNamespace(save=save))
    monkeypatch.setattr(kept_in, "st", SimpleNamespace(query_params={}))
    for name in ("job", "job_parts", "diagnosis_of", "case_with_columns"):
        monkeypatch.setattr(kept_in, name, lambda *_: None)
    with ThreadPoolExecutor(2) as runs:
        first = runs.submit(kept_in.keep, "Job")
        assert begun.wait(20)
        second = runs.submit(kept_in.keep, "Job")
        go_on.set()
        assert not first.result(20)
        assert not second.result(20)
    assert saves == [None, "job1"], "the second run saves the job that the first one put into the book"
    assert kept_in.st.query_params == {"job": "job1"}


def test_the_second_of_two_browsers_is_told_and_chooses(
    app: AppTest, book: Book, monkeypatch: pytest.MonkeyPatch
) -> None:
    press(app, "New, empty job")
    field(app, "Technician").set_value("first").run()
    other = reloaded(app)
    field(other, "Technician").set_value("second").run()
    field(app, "Make").set_value("BMW").run()
    assert "Changed elsewhere." in texts(app)
    assert "by second at" in texts(app)
    (row,) = book.rows()
    assert book.load(row.id).file.job.vehicle.make == ""
    monkeypatch.setenv("ATLEAK_DATABASE_URL", "postgresql://shop:secret@127.0.0.1:1/book")
    app.button(key="book-over").click().run()  # the book is away just then
    assert not app.exception
    assert "Not saved." in texts(app)
    monkeypatch.delenv("ATLEAK_DATABASE_URL")
    assert "Changed elsewhere." in texts(app.run().run())
    app.button(key="book-another").click().run()
    assert "Changed elsewhere." not in texts(app)
    kept = {row.id: book.load(row.id).file.job for row in book.rows()}
    assert sorted((job.technician, job.vehicle.make) for job in kept.values()) == [("first", "BMW"), ("second", "")]


def test_an_address_of_no_job_or_of_one_that_cannot_be_taken_is_refused_in_words(
    app: AppTest, book: Book, monkeypatch: pytest.MonkeyPatch
) -> None:
    app.query_params["job"] = "feed"
    app.run()
    assert not app.exception
    assert "job feed of the job book" in texts(app)
    assert "has no such job" in texts(app)

    def refused(*_: object) -> JobParts:
        raise InputError("the file of the fluid is no longer there")

    case = Case(controller="minimal_example")
    saved = book.save(job_parts(case.diagnose(), Job(number="17"), case))
    monkeypatch.setattr("pages.shared.book.job_parts", refused)
    app.query_params["job"] = saved.id
    app.run()
    assert not app.exception
    assert "the file of the fluid is no longer there" in texts(app)
    assert field(app, "Job number").value == ""


def test_a_book_that_cannot_be_used_costs_no_work(app: AppTest, monkeypatch: pytest.MonkeyPatch) -> None:
    press(app, "New, empty job")
    monkeypatch.setenv("ATLEAK_DATABASE_URL", "postgresql://shop:secret@127.0.0.1:1/book")
    field(app, "Job number").set_value("17").run()
    assert not app.exception
    assert "Not saved." in texts(app)
    assert "does not answer" in texts(app)
    assert field(app, "Job number").value == "17"
    monkeypatch.delenv("ATLEAK_DATABASE_URL")
    app.run()
    assert "In the job book: **17**" in texts(app.run())
    assert [row.number for row in open_book().rows()] == ["17"]


def test_a_job_that_is_judged_otherwise_today_says_so(
    app: AppTest, book: Book, monkeypatch: pytest.MonkeyPatch
) -> None:
    case = Case(controller="minimal_example")
    parts = job_parts(case.diagnose(), Job(), case)
    parts.__dict__["result"] = {**parts.result, "verdict": "ok"}  # as an earlier version might have said
    monkeypatch.setattr("atleak.job_book.book.__version__", "0.1.9")
    saved = book.save(parts)
    app.query_params["job"] = saved.id
    app.run()
    assert "Judged otherwise than when it was stored" in texts(app)
    assert "the unit: ok" in texts(app)


def test_a_job_file_whose_result_was_changed_says_so_when_it_is_opened(app: AppTest) -> None:
    case = Case(controller="minimal_example")
    parts = job_parts(case.diagnose(), Job(), case)
    sources = {slot: source.content for slot, source in parts.sources.items()}
    result = {**parts.result, "verdict": "ok", "atleak": "0.1.9"}
    content = packed_job(parts.choices.model_dump_json().encode(), sources, {}, result)
    uploader(app).upload("job.zip", content, "application/zip").run()
    assert "Judged otherwise than when it was stored" in texts(app)
    assert "0.1.9" in texts(app)
    assert "the unit: ok" in texts(app)


def test_files_are_named_after_the_workshops_number() -> None:
    assert [named("atleak", number) for number in ("2026-0417", "17/4", " ", "../x")] == [
        "atleak_2026-0417", "atleak_17_4", "atleak", "atleak____x",
    ]  # fmt: skip
