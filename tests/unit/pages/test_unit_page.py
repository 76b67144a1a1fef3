"""The part of the page History on a unit: visits, what was left undone, wear, and how it stands among its kind."""

from __future__ import annotations

from typing import Any

import pytest
from streamlit.testing.v1 import AppTest

from atleak.analysis.history.series import Restart
from atleak.common.wording import signed
from atleak.job.case import Case, SourceFile
from atleak.job.parts import job_parts
from atleak.job_book.book import Book, open_book
from atleak.job_book.unit_history import unit_of_visit, visits_of_unit
from atleak.measurements.job_card import Job
from pages.shared import unit
from tests.unit.pages.conftest import go, part_shown, texts


def saved(book: Book, sleeve: float, year: int, mileage: float, **record: Any) -> str:
    """A job of one land of the minimal example in the book."""
    rows = ["component,part,plane,direction,diameter [mm]"]
    for direction in (0, 90):
        rows += [f"tcc_regulator,spool,1,{direction},11.000", f"tcc_regulator,sleeve,1,{direction},{sleeve:.3f}"]
    case = Case(readings=SourceFile("small.csv", "\n".join(rows).encode()), controller="minimal_example")
    told = {"number": str(year), "date": f"{year}-05-01", "vehicle": {"mileage_km": mileage}}
    job = Job(**{**told, "transmission": {"serial": "0147"}, **record})
    return book.save(job_parts(case.diagnose(), job, case)).id


@pytest.mark.page("20_Library")
def test_a_unit_shows_its_visits_its_wear_and_what_was_left_undone(app: AppTest) -> None:
    book = open_book()
    declined = {"component": "tcc_regulator", "land": 1, "decision": "declined", "reason": "too dear", "work": "sleeve"}
    first = saved(book, 11.036, 2024, 100_000.0)
    last = saved(book, 11.042, 2026, 160_000.0, repair_decisions=[declined])
    this = unit_of_visit(book, last)
    book.engine.dispose()
    app.query_params["unit"] = str(this)
    go(app, "11_History")
    assert not app.exception
    said = texts(app)
    assert "serial **0147**" in said
    assert "tcc_regulator/1, sleeve **declined**: too dear (2026-05-01)" in said
    visits, wear = app.dataframe[0].value, app.dataframe[2].value
    assert list(visits["Date"]) == ["2026-05-01", "2024-05-01"]
    assert wear["µm per 10\u00a0000 km"][0].startswith("0.50 (")
    assert wear[f"{signed('replace')} at"][0].startswith(("2", "not before"))
    assert "shown from 10 other units on" in said
    # a visit beside the one before
    next(button for button in app.button if button.label == "Compare with the visit before").click().run()
    assert not app.exception
    assert part_shown(app) == "history=compare"
    assert app.selectbox(key=f"compare-before-{first}").value == first
    go(app, "11_History?history=unit")
    # another one is looked for
    other = next(widget for widget in app.text_input if widget.label == "Look for another unit")
    other.set_value("no such thing").run()
    assert "No job of the book is found by that." in texts(app)


def test_a_visit_without_a_sheet_tells_the_mileage_and_what_was_repaired_at_it() -> None:
    book = open_book()
    saved(book, 11.036, 2022, 100_000.0)
    saved(book, 11.042, 2024, 160_000.0)
    case = Case(controller="minimal_example")
    done = {"component": "tcc_regulator", "land": 1, "decision": "done"}
    record = {"date": "2026-05-01", "vehicle": {"mileage_km": 170_000.0}, "transmission": {"serial": "0147"}}
    last = book.save(job_parts(case.diagnose(), Job(**record, repair_decisions=[done]), case)).id
    seen = unit.seen(visits_of_unit(book, unit_of_visit(book, last)))
    book.engine.dispose()
    assert seen.history.present == 170_000.0
    land = seen.history.land(("tcc_regulator", 1))
    assert (land.line, land.series.restart) == (None, Restart.REPAIRED)
