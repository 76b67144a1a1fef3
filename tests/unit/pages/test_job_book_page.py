"""The page of the job book: jobs are looked up, opened, archived, merged and erased there."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from streamlit.testing.v1 import AppTest

from atleak.job.case import Case, SourceFile
from atleak.job.parts import JobParts, job_parts
from atleak.job_book.book import Book, open_book
from atleak.job_book.search import Query
from atleak.measurements.job_card import Job
from tests.unit.pages.conftest import go, part_shown, texts

VIN = "WVWZZZ1JZXW000001"


def small_job(**record: Any) -> JobParts:
    rows = ["component,part,plane,direction,diameter [mm]"]
    for direction in (0, 90):
        rows += [f"tcc_regulator,spool,1,{direction},11.000", f"tcc_regulator,sleeve,1,{direction},11.040"]
    case = Case(readings=SourceFile("small.csv", "\n".join(rows).encode()), controller="minimal_example")
    return job_parts(case.diagnose(), Job(**record), case)


@pytest.fixture
def book(own_home: Path) -> Book:
    own_home.mkdir()
    return open_book(f"sqlite:///{own_home / 'book.sqlite'}")


@pytest.fixture
def filled(book: Book) -> dict[str, str]:
    """Three jobs; their ids by customer."""
    customers = {"Ana Lima": VIN, "Bo Berg": VIN[:-1] + "9", "Cy Core": ""}
    return {
        name: book.save(small_job(customer={"name": name}, vehicle={"vin": vin, "mileage_km": 90_000})).id
        for name, vin in customers.items()
    }


def table(app: AppTest) -> Any:
    return app.dataframe[0]


def pick(app: AppTest, *rows: int) -> AppTest:
    app.session_state[table(app).key] = {"selection": {"rows": list(rows), "columns": [], "cells": []}}
    return app.run()


@pytest.mark.page("10_Jobs")
def test_jobs_are_looked_up_merged_erased_archived_and_opened(filled: dict[str, str], book: Book, app: AppTest) -> None:
    assert not app.exception
    assert list(table(app).value["Customer"]) == ["Cy Core", "Bo Berg", "Ana Lima"]
    assert {text.strip() for text in table(app).value["Verdict"]} == {"▲ watch"}
    assert app.button(key="job-open").disabled
    app.button(key="job-duplicates").click().run()
    (merge,) = [each for each in app.button if (each.key or "").startswith("job-merge-")]
    merge.click().run()
    assert len({row.unit for row in book.rows()}) == 2
    app.button(key="job-part").click().run()
    assert len({row.unit for row in book.rows()}) == 3
    app.text_input(key="job-list-text").set_value("lim").run()
    assert list(table(app).value["Customer"]) == ["Ana Lima"]
    pick(app, 0).button(key="job-erase").click().run()
    assert "Ana Lima" in app.warning[0].value
    assert "Backups and exports made earlier still hold it all" in app.warning[0].value
    app.button(key="job-erase-now").click().run()
    assert not app.exception
    assert "The customer's data are erased; jobs: 1." in texts(app)
    assert "No job fits." in texts(app)
    assert book.load(filled["Ana Lima"]).file.job.customer.name == ""
    app.text_input(key="job-list-text").set_value("cy core").run()
    pick(app, 0).button(key="job-archive").click().run()
    assert [row.customer for row in book.rows(Query(archived=True))] == ["Cy Core"]
    app.text_input(key="job-list-text").set_value("").run()
    compared = pick(app, 0, 1).button(key="job-compare").click().run()
    assert part_shown(compared) == "history=compare"
    assert compared.query_params["before"] == filled["Ana Lima"]
    go(app, "10_Jobs")
    pick(app, 0).button(key="job-open").click().run()
    assert not app.exception
    assert part_shown(app) == "diagnosis="
    assert app.query_params["job"] == filled["Bo Berg"]


@pytest.mark.page("10_Jobs")
def test_an_empty_book_says_what_will_stand_here(app: AppTest) -> None:
    assert not app.exception
    assert "The job book is empty." in texts(app)


@pytest.fixture
def torn_book(own_home: Path) -> None:
    own_home.mkdir()
    (own_home / "book.sqlite").write_bytes(b"no database at all" * 400)


@pytest.mark.page("10_Jobs")
def test_a_book_that_cannot_be_opened_leaves_the_rest_at_work(torn_book: None, app: AppTest) -> None:
    assert not app.exception
    assert "the file is no job book" in texts(app)
    assert "Everything else works as ever" in texts(app)
