"""A browser reads the dashboard in its own language and units, and remembers what was chosen."""

from __future__ import annotations

import re

import pytest

pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
from playwright.sync_api import Browser, Page, expect

from .conftest import SOON, to, unfold


def idle(page: Page) -> None:
    page.locator("[data-testid=stApp][data-test-script-state=notRunning]").wait_for()


def chosen(page: Page, label: str, option: str) -> None:
    page.get_by_test_id("stMain").get_by_role("combobox", name=label).click()
    page.get_by_role("option", name=re.compile(option)).click()
    idle(page)


def test_a_german_browser_reads_german_with_commas_and_keeps_the_us_units_it_chose(
    browser: Browser, server: str
) -> None:
    context = browser.new_context(viewport={"width": 1280, "height": 900}, locale="de-DE")
    context.set_default_timeout(SOON)
    page = context.new_page()
    try:
        page.goto(f"{server}/Uncertainty")
        page.wait_for_url("**/Diagnosis?diagnosis=lands")  # the page is a part of that today
        expect(page.get_by_role("heading", name="■ ersetzen", level=1)).to_be_visible()
        page.wait_for_function("document.documentElement.lang === 'de'")
        unfold(page, "Wie sicher diese Zahlen sind")
        fold = page.get_by_test_id("stExpander").filter(has_text="Was von allem angenommen ist")
        expect(
            fold.locator("[data-testid^=glide-cell-1-]").filter(has_text=re.compile(r"^\d+,\d+\s\S+$")).first
        ).to_be_attached()
        page.get_by_text("Angegebener Betriebspunkt").click()
        field = page.get_by_role("textbox", name="Temperatur [°C]")
        field.fill("95,5")
        field.press("Enter")
        idle(page)
        to(page, "Einstellungen")
        chosen(page, "Einheiten", "^US")
        expect(page.get_by_role("textbox", name="Temperatur [°F]")).to_have_value("203,9")
        page.goto(f"{server}/Uncertainty")  # as after a reload: another session
        unfold(page, "Wie sicher diese Zahlen sind")
        expect(page.get_by_text("Radialspiel [0.0001 in], 95 %-Intervall").first).to_be_visible()
        assert {each["name"]: each["value"] for each in context.cookies()}["atleak-units"] == "us"
        to(page, "Einstellungen")
        chosen(page, "Sprache", "English")
        expect(page.get_by_role("heading", name="Settings", level=1)).to_be_visible()
        page.wait_for_function("document.documentElement.lang === 'en'")
    finally:
        context.close()
