"""From the picture of the valve body to the repairs that are decided, in a browser."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
from playwright.sync_api import Page, expect


def test_a_pair_is_opened_repairs_are_ticked_and_the_record_holds_what_was_decided(page: Page) -> None:
    page.locator("[data-testid=stApp][data-test-script-state=notRunning]").wait_for()
    valve = page.locator("button[data-pair='25']").first
    valve.focus()
    page.keyboard.press("Enter")
    expect(page.get_by_text("Ovality of the bore").first).to_be_visible()
    expect(valve).to_have_attribute("aria-pressed", "true")
    expect(page).to_have_url(re.compile(r"[?&]pair=25"))
    idle = page.locator("table.cards", has_text="Main pressure held").locator("tbody tr").nth(1)
    before = idle.inner_text()
    tick = page.get_by_test_id("stCheckbox").filter(has_text="25/1 main pressure valve")
    tick.locator("label").click()
    expect(idle).not_to_have_text(before)
    page.get_by_role("button", name="Fewest").click()
    expect(page.get_by_text("With 5 repairs every total and pressure is within its limits.")).to_be_visible()
    page.get_by_role("button", name="Take into the decisions").click()
    expect(page.get_by_text("The repair decisions of this job are those ticked here.")).to_be_visible()
    page.reload()
    expect(page.get_by_text("Ovality of the bore").first).to_be_visible()
    page.get_by_test_id("stTopNav").get_by_role("link", name="Report").click()
    with page.expect_download() as waiting:
        page.get_by_role("button", name="Job record").click()
    record = json.loads(Path(waiting.value.path()).read_text(encoding="utf-8"))
    decided = {(each["component"], each["land"]): each["decision"] for each in record["repair_decisions"]}
    assert decided == dict.fromkeys([("25", 1), ("26", 2), ("17", 2), ("20", 1), ("14", 1)], "proposed")
