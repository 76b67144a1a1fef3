"""The page that puts two jobs side by side."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from streamlit.testing.v1 import AppTest

from atleak.job.case import Case, SourceFile
from atleak.job.parts import job_parts
from atleak.job_book.book import open_book
from atleak.job_book.customer_links import links_of_job
from atleak.measurements.job_card import Job
from atleak.report.customer_screen import written
from tests.unit.pages.conftest import choice, go, press, texts, uploader

SHEET = "component;part;plane;direction;diameter [mm]\n" + "".join(
    f"{component};{part};1;{direction};{{{name}}}\n"
    for component, part, name in (
        ("tcc_regulator", "spool", "spool"), ("tcc_regulator", "sleeve", "sleeve"),
        ("accumulator", "piston", "piston"), ("accumulator", "sleeve", "bore"),
    )
    for direction in (0, 90)
)  # fmt: skip


@pytest.fixture
def kept() -> Callable[..., str]:
    """Keeps a job of the minimal example in the job book; its id."""

    def keep(sleeve: float, date: str, log: Path) -> str:
        sizes = {"spool": 11.0, "sleeve": sleeve, "piston": 17.999, "bore": 18.07}
        case = Case(
            readings=SourceFile(f"{date}.csv", SHEET.format(**sizes).encode()),
            road_test=SourceFile(log.name, log.read_bytes()),
            controller="minimal_example",
        )
        record = Job(number=f"of {date}", date=date, transmission={"serial": "MADE-UP-1"})
        return open_book().save(job_parts(case.diagnose(), record, replace(case, remember=False))).id

    return keep


@pytest.mark.page("1_Job")
def test_the_customer_sees_the_visit_before_and_the_later_one(
    app: AppTest, kept: Callable[..., str], sample_log: Path
) -> None:
    jobs = [kept(11.09, "2026-03-02", sample_log), kept(11.04, "2026-03-09", sample_log)]
    for job, says in zip(jobs, ("at a later visit", "At the visit before, "), strict=True):
        app.query_params["job"] = job
        go(app, "4_Diagnosis")
        press(app, "Show customer")
        assert not app.exception
        (link,) = links_of_job(open_book(), job)
        assert says in written(link.screen)


@pytest.mark.page("11_History?history=compare")
def test_two_visits_of_a_unit_stand_side_by_side(app: AppTest, kept: Callable[..., str], sample_log: Path) -> None:
    assert not app.exception
    assert "Choose a job for either side" in texts(app)
    before, after = kept(11.09, "2026-03-02", sample_log), kept(11.04, "2026-03-09", sample_log)
    app.query_params["job"] = after  # opened: the visit before it is the other side
    app.run()
    assert not app.exception
    assert {widget.label: widget.value for widget in app.selectbox}["Before"] == before
    assert "1 of 2 lands that were measured at both visits changed" in texts(app)
    shown = app.dataframe[0].value
    regulator = shown[shown["Pair"] == "converter clutch regulator valve/1"].iloc[0]
    assert (regulator["Before [µm]"], regulator["After [µm]"], regulator["Changed"]) == (45.0, 20.0, "yes")
    assert "-25.0 ± " in regulator["Change [µm]"].replace("−", "-")
    event = next(widget for widget in app.selectbox if widget.label == "Event")
    assert "shift 1 → 2" in event.options
    assert "Dashed: before; full: after" in texts(app)


@pytest.mark.page("11_History?history=compare")
def test_two_valve_bodies_are_refused_in_words(app: AppTest, kept: Callable[..., str], sample_log: Path) -> None:
    app.query_params["before"] = kept(11.09, "2026-03-02", sample_log)  # beside the sample job
    app.run()
    assert not app.exception
    assert "two different valve bodies" in texts(app)


@pytest.mark.page("11_History?history=compare")
def test_jobs_that_the_address_names_are_compared_however_old_they_are(
    app: AppTest, kept: Callable[..., str], sample_log: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pages.shared.comparison.LISTED", 1)
    before, after = kept(11.09, "2026-03-02", sample_log), kept(11.04, "2026-03-09", sample_log)
    book = open_book()
    book.save(job_parts((case := Case(controller="minimal_example")).diagnose(), Job(number="newest"), case))
    book.archive(before)
    app.query_params["before"], app.query_params["after"] = before, after
    app.run()
    assert not app.exception
    assert {widget.label: widget.value for widget in app.selectbox if widget.label in ("Before", "After")} == {
        "Before": before,
        "After": after,
    }
    app.query_params["before"] = "feed"
    app.run()
    assert "has no such job" in texts(app)


@pytest.mark.page("2_Measure")
@pytest.mark.parametrize("at_once", [True, False], ids=["at once", "one after the other"])
def test_two_sheets_of_one_unit_are_compared_though_the_job_holds_one(app: AppTest, at_once: bool) -> None:
    choice(app, "Valve body").select("minimal_example").run()
    sizes = {"spool": 11.0, "piston": 17.999, "bore": 18.07}
    dated = {"after.csv": (11.04, "2026-03-09"), "before.csv": (11.09, "2026-03-02")}  # as a folder lists them
    sheets = {
        name: f"Date;{date}\n{SHEET.format(sleeve=sleeve, **sizes)}".encode() for name, (sleeve, date) in dated.items()
    }
    for files in [sheets] if at_once else [{name: sheet} for name, sheet in sheets.items()]:
        uploader(app).upload_all(files).run()
    assert app.session_state["atleak"].good.readings.name == "before.csv"
    (link,) = (each for each in app.get("page_link") if each.proto.label == "Compare both sheets")
    assert link.proto.help == "after.csv"
    app.query_params["history"] = "compare"
    go(app, "11_History")
    assert not app.exception
    assert [choice(app, side).value for side in ("Before", "After")] == ["this_job", "sheet"]
    shown = app.dataframe[0].value
    regulator = shown[shown["Pair"] == "converter clutch regulator valve/1"].iloc[0]
    assert (regulator["Before [µm]"], regulator["After [µm]"], regulator["Changed"]) == (45.0, 20.0, "yes")
    app.button(key="away-readings").click().run()
    assert "Choose a job for either side" in texts(app)
