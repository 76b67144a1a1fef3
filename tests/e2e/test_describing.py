"""A valve body is described, saved and diagnosed without a file being touched by hand."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest

pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
from playwright.sync_api import Page, expect

from .conftest import AT_REST, open_part, to

ROW = 35  # pixels
EXAMPLE = "Example of a workshop's own description"


def wait_until_idle(page: Page) -> None:
    page.locator("[data-testid=stApp][data-test-script-state=notRunning]").wait_for()


def type_into(page: Page, table: int, row: int, column: int, text: str) -> None:
    """Type over a cell as people do: reach it with the arrow keys, press Enter, type, press Enter.

    On a busy machine the table may be drawn anew just then, and what is typed goes nowhere: then one tries again.
    """
    editor = page.get_by_test_id("stDataFrame").nth(table)
    cell = editor.get_by_test_id(f"glide-cell-{column}-{row - 1}")
    editor.scroll_into_view_if_needed()
    for _ in range(5):
        page.evaluate(AT_REST, editor.element_handle())
        box = editor.bounding_box()
        assert box is not None
        page.mouse.click(box["x"] + 20, box["y"] + ROW * (row + 0.5))  # the head is one row high
        for _ in range(column):
            page.keyboard.press("ArrowRight")
        page.keyboard.press("Enter")
        page.keyboard.press("Control+A")
        page.keyboard.type(text, delay=30)
        page.keyboard.press("Enter")
        try:
            expect(cell).to_have_text(text, timeout=5000)
        except AssertionError:
            continue
        wait_until_idle(page)
        return
    expect(cell).to_have_text(text)


@pytest.mark.slow
def test_a_copy_of_a_shipped_unit_is_edited_saved_chosen_and_diagnosed(
    page: Page, server: str, server_home: Path
) -> None:
    to(page, "Library")
    open_part(page, "Transmission")
    page.get_by_role("combobox", name="Start from").click()
    page.keyboard.type(EXAMPLE)
    page.keyboard.press("Enter")
    wait_until_idle(page)
    page.get_by_role("button", name="Start", exact=True).click()
    expect(page.get_by_text("Nothing is missing or wrong.")).to_be_visible()
    page.get_by_role("textbox", name="Name *").fill("Our box, 2012")
    page.get_by_role("radio", name="Components").click()
    expect(page.get_by_text("our_box_2012")).to_be_visible()
    wait_until_idle(page)
    type_into(page, 1, 1, 3, "1500")
    expect(page.get_by_text("Missing or wrong: 1.")).to_be_visible()
    expect(page.get_by_text("row 1, Diameter: value not accepted (found '1500')")).to_be_visible()
    type_into(page, 1, 1, 3, "15,1")
    expect(page.get_by_text("Nothing is missing or wrong.")).to_be_visible()

    page.get_by_role("radio", name="Pump").click()
    displacement = page.get_by_role("textbox", name="Displacement of one revolution")
    displacement.fill("18")
    displacement.press("Tab")
    below = page.get_by_text("? 18 mm³ is unusual for the displacement of one revolution").last
    expect(below).to_be_visible()
    wait_until_idle(page)
    field, doubt = displacement.bounding_box(), below.bounding_box()
    assert field is not None
    assert doubt is not None
    assert abs(doubt["x"] - field["x"]) < 20
    assert 0 < doubt["y"] - field["y"] < 120
    displacement.fill("18000")
    displacement.press("Tab")
    expect(page.get_by_text("Nothing is missing or wrong.")).to_be_visible()

    to(page, "Measure")
    to(page, "Library")  # the part is the one that was open
    expect(page.get_by_text("our_box_2012")).to_be_visible()
    page.reload()  # a new session
    expect(page.get_by_text("our_box_2012")).to_be_visible()

    page.get_by_role("button", name="Save as own file").click()
    expect(page.get_by_text("Saved:")).to_be_visible()
    saved = tomllib.loads((server_home / "catalogue/controllers/our_box_2012.toml").read_text(encoding="utf-8"))
    assert (saved["name"], saved["components"][0]["lands"][0]["nominal_diameter_mm"]) == ("Our box, 2012", 15.1)
    page.get_by_role("button", name="Use it for this job").click()
    wait_until_idle(page)
    chosen = page.get_by_test_id("stSidebar").get_by_role("combobox", name="Valve body")
    expect(chosen).to_have_value("Our box, 2012 (own: our_box_2012)")
    to(page, "Diagnosis")
    expect(page.get_by_text("nothing was measured").first).to_be_visible()
