"""From the picture of the valve body to the repairs that are decided, in a browser."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
from playwright.sync_api import Locator, Page, expect

from .conftest import AT_REST, open_part, to


def idle(page: Page) -> None:
    page.locator("[data-testid=stApp][data-test-script-state=notRunning]").wait_for()


def switch(page: Page, name: str) -> Locator:
    """The switch of a repair: what is pressed of it."""
    return page.get_by_test_id("stMain").get_by_test_id("stCheckbox").filter(has_text=name).locator("label")


def test_a_pair_is_opened_by_the_picture_a_row_and_the_list(page: Page) -> None:
    idle(page)
    valve = page.locator("button[data-pair='25']").first
    valve.focus()
    page.keyboard.press("Enter")
    opened = page.locator(".st-key-opened-pair h2")
    expect(opened).to_have_text("25 main pressure valve")
    expect(valve).to_have_attribute("aria-pressed", "true")
    expect(page).to_have_url(re.compile(r"[?&]pair=25"))
    open_part(page, "Lands")
    page.locator("table.cards button", has_text="26/2").first.click()
    expect(opened).to_contain_text("26 ")
    expect(page).to_have_url(re.compile(r"[?&]pair=26"))
    page.get_by_test_id("stMain").get_by_role("combobox", name="Open a valve").click()
    page.get_by_role("option", name=re.compile("^17 ")).click()
    expect(opened).to_contain_text("17 ")
    page.reload()
    expect(opened).to_contain_text("17 ")
    expect(page.get_by_role("radio", name="Lands")).to_be_checked()


def test_repairs_are_switched_priced_and_the_record_holds_what_was_decided(page: Page) -> None:
    idle(page)
    said = page.get_by_test_id("stMain").get_by_text("totals and pressures are green at every condition.")
    expect(said).to_be_visible()
    switch(page, "25/1 main pressure valve").click()
    expect(page.get_by_text("Flagged, and brought within its limits by no line")).to_be_visible()
    prices = page.get_by_role("link", name="Prices and estimate")
    prices.evaluate(AT_REST)  # what is said above it grew
    prices.click()
    on = page.get_by_test_id("stMain").get_by_test_id("stCheckbox").locator("input").first
    price = page.get_by_role("textbox", name=re.compile("^Price")).first
    price.fill("61,55")
    switch(page, "25/1 main pressure valve").click()  # straight from the field
    expect(on).to_be_checked()
    expect(page.locator("[data-testid^=glide-cell]", has_text="≥ 61.55").first).to_be_attached()
    expect(price).to_have_value(re.compile(r"61[.,]55"))
    page.get_by_role("button", name="Undo: repairs taken into the decisions").click()
    expect(on).not_to_be_checked()
    page.get_by_role("button", name="Fewest").click()
    expect(on).to_be_checked()
    idle(page)
    to(page, "Report")
    with page.expect_download() as waiting:
        page.get_by_role("button", name="Job record").click()
    record = json.loads(Path(waiting.value.path()).read_text(encoding="utf-8"))
    decided = {(each["component"], each["land"]): each["decision"] for each in record["repair_decisions"]}
    assert decided == dict.fromkeys([("25", 1), ("26", 2), ("17", 2), ("20", 1), ("14", 1)], "proposed")
    assert [each.get("price") for each in record["repair_decisions"] if each["component"] == "25"] == [61.55]
