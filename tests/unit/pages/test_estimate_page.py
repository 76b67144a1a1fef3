"""The page Plan: lines start from the verdict, keep what is typed, and say what is missing."""

from __future__ import annotations

import pytest
from streamlit.testing.v1 import AppTest

from atleak.measurements.job_card import Job
from tests.unit.pages.conftest import go, texts, uploader

pytestmark = pytest.mark.page("5_Plan")


def fields(app: AppTest, label: str) -> list:
    return [widget for widget in (*app.main.text_input, *app.main.selectbox) if widget.label.startswith(label)]


def test_what_is_typed_of_a_line_stays_on_every_page_and_counts_in_the_sums(app: AppTest) -> None:
    assert {widget.value for widget in fields(app, "State")} == {"proposed"}
    fields(app, "Currency")[0].set_value("EUR")
    fields(app, "Labour rate")[0].set_value("95,50")
    fields(app, "Price")[0].set_value("61,55")
    fields(app, "Work")[0].set_value("1,25").run()
    assert not app.exception
    fields(app, "State")[1].select("declined").run()
    assert "Why was it declined?" in texts(app)
    fields(app, "Reason")[1].set_value(" too dear ").run()
    assert "Why was it declined?" not in texts(app)
    job: Job = app.session_state["job-record"]
    first, second = job.repair_decisions
    assert (first.price, first.hours, first.decision) == (61.55, 1.25, "proposed")
    assert (second.decision, second.reason) == ("declined", "too dear")
    assert (job.estimate.currency, job.estimate.labour_rate) == ("EUR", 95.5)
    (sums,) = [table.value for table in app.dataframe if "Net" in table.value]
    assert list(sums["Parts"]) == ["≥ 61.55", "–"]  # of the lines that are only proposed no price is known
    assert list(sums["Work"]) == ["≥ 119.38", "–"]
    go(app, "6_Report")
    assert app.session_state["job-record"].repair_decisions == job.repair_decisions
    assert "To be replaced, and not decided yet" in texts(app)  # the first is only proposed
    go(app, "5_Plan")
    assert not app.exception
    assert app.session_state["job-record"] == job
    assert [fields(app, name)[0].value for name in ("Price", "Work", "Labour rate")] == ["61,55", "1,25", "95,50"]


@pytest.mark.page("1_Job")
def test_a_record_with_a_decision_on_a_land_that_the_valve_body_lacks_is_refused_by_name(app: AppTest) -> None:
    record = b'[[repair_decisions]]\ncomponent = "25"\nland = 9\n'
    uploader(app).upload("job.toml", record, "application/toml").run()
    assert not app.session_state["job-record"].repair_decisions
    assert any("component 25 has no such land" in widget.value for widget in app.error)


def test_the_paper_is_that_of_the_readers_units(app: AppTest) -> None:
    (paper,) = fields(app, "Paper")
    assert paper.value == "a4"
    app.session_state["reader-units"] = "us"
    app.run()
    (paper,) = fields(app, "Paper")
    assert paper.value == "letter"


@pytest.mark.page("1_Job")
def test_work_that_no_limit_asks_for_is_doubted_on_both_pages(app: AppTest) -> None:
    record = b'[[repair_decisions]]\ncomponent = "15"\nland = 1\nprice = 34.0\ndecision = "approved"\n'
    uploader(app).upload("job.toml", record, "application/toml").run()
    for page in ("1_Job", "5_Plan"):
        go(app, page)
        assert any("work is decided here that no limit asks for" in widget.value for widget in app.warning), page
