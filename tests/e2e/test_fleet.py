"""A fleet's results in a browser: chosen, kept over a reload, and down to one unit's own job and back."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
from playwright.sync_api import Page, expect

from atleak.fleet.folder import note
from atleak.fleet.results import Results
from atleak.fleet.sources import find_units
from atleak.fleet.worker import evaluate_unit
from atleak.job.zip_file import write_job_file
from atleak.measurements.job_card import Job

from ..unit.fleet.small_units import small_unit
from .conftest import AT_REST, to

ROW, HALF = 35, 17  # [px] of a row of a table


@pytest.fixture
def evaluated(tmp_path: Path, server_home: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The results of three units of two groups, known to the server."""
    for number, group in enumerate(("north", "north", "south")):
        unit = small_unit(number)
        assert unit.case is not None
        (tmp_path / "jobs" / group).mkdir(parents=True, exist_ok=True)
        content = write_job_file(unit.case.diagnose(), Job(number=f"2026-04-{number}"), unit.case)
        (tmp_path / "jobs" / group / f"unit_{number}.zip").write_bytes(content)
    with Results.open(tmp_path / "spring", for_writing=True) as results:
        results.add([evaluate_unit(unit) for unit in find_units([tmp_path / "jobs"])])
    monkeypatch.setenv("ATLEAK_HOME", str(server_home))
    note(tmp_path / "spring")
    return tmp_path / "spring"


@pytest.mark.slow
def test_from_a_fleet_down_to_one_unit_and_back_with_what_was_chosen(page: Page, evaluated: Path) -> None:
    to(page, "Fleet")
    expect(page.get_by_text("Units to be replaced, or worse: 0 of 3.", exact=True)).to_be_visible()
    expect(page.get_by_role("button", name="Excel workbook")).to_be_visible()  # the last of the page
    groups = page.get_by_test_id("stMain").get_by_role("combobox", name="Groups by")
    groups.scroll_into_view_if_needed()  # scrolling closes a list that is open
    groups.evaluate(AT_REST)
    groups.click()
    page.get_by_role("option", name="Group", exact=True).click()
    expect(page.get_by_text("The 2 groups by “group”, each compared with each.")).to_be_visible()
    page.wait_for_url("**by=group**")
    page.reload()
    expect(page.get_by_text("The 2 groups by “group”, each compared with each.")).to_be_visible()
    expect(page.get_by_text(re.compile("too few units to call anything a difference")).first).to_be_visible()
    expect(page.get_by_role("button", name="Excel workbook")).to_be_visible()
    table = page.locator("[data-testid=stDataFrame]:visible").first
    table.scroll_into_view_if_needed()
    table.evaluate(AT_REST)
    table.click(position={"x": HALF, "y": 3 * ROW + HALF})  # the third unit
    expect(page.get_by_text("Number: 2026-04-2", exact=False)).to_be_visible()
    page.get_by_role("button", name="Open its job").click()
    page.wait_for_url("**/Diagnosis**")
    expect(page.get_by_role("button", name="Undo: 2026-04-2 opened")).to_be_visible()
    expect(page.get_by_test_id("stSidebar").get_by_text("2.csv")).to_be_visible()
    to(page, "Fleet")
    expect(page.get_by_text("The 2 groups by “group”, each compared with each.")).to_be_visible()
    page.wait_for_url("**by=group**")
    with page.expect_download() as download:
        page.get_by_role("button", name="Excel workbook").click()
    assert Path(download.value.path()).read_bytes().startswith(b"PK")
    page.get_by_role("button", name="Undo: 2026-04-2 opened").click()
    expect(page.get_by_text("Sample job: made-up data")).to_be_visible()
