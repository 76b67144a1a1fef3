"""From the start to the printed report by the keyboard alone, with the focus in sight at every stop."""

from __future__ import annotations

from pathlib import Path

import pytest

pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
from playwright.sync_api import Page, expect

STOPS = 120  # as far as Tab must go
ACCENT = "rgb(11, 110, 143)"  # of a field's frame
# What has the focus is called, and whether a ring or a frame in the accent shows it: its own, or that of what holds it.
FOCUSED = """accent => {
    let at = document.activeElement
    while (at.shadowRoot?.activeElement) at = at.shadowRoot.activeElement
    const label = at.closest("label") ?? at
    const called = (at.getAttribute("aria-label") ?? label.innerText).trim()
    const holders = [at, at.parentElement, at.parentElement?.parentElement, label].filter(Boolean)
    const seen = at === document.body || holders.map(each => getComputedStyle(each)).some(style =>
        style.outlineStyle !== "none" && style.outlineWidth !== "0px" || style.boxShadow !== "none" ||
        style.borderTopColor === accent)
    return [called, seen, at.matches(":focus-visible")]
}"""


def tab_to(page: Page, name: str) -> None:
    """Press Tab until that has the focus whose name begins so."""
    passed = []
    for _ in range(STOPS):
        page.keyboard.press("Tab")
        called, seen, by_keyboard = page.evaluate(FOCUSED, ACCENT)
        for _ in range(50):  # a page's looks may come after what it shows
            if seen:
                break
            page.wait_for_timeout(100)
            called, seen, by_keyboard = page.evaluate(FOCUSED, ACCENT)
        assert seen, f"nobody sees that the focus is on {called!r}; keyboard: {by_keyboard}"
        passed.append(called[:40])
        if called.startswith(name):
            assert by_keyboard
            return
    raise AssertionError(f"Tab does not lead to {name!r}: {passed}")


def idle(page: Page) -> None:
    page.locator("[data-testid=stApp][data-test-script-state=notRunning]").wait_for()


@pytest.mark.page("0_")
def test_the_sample_is_diagnosed_repaired_and_printed_without_a_mouse(page: Page) -> None:
    page.locator(".st-key-steps a").first.wait_for()
    idle(page)
    tab_to(page, "See the sample job")
    page.keyboard.press("Enter")
    expect(page.locator(".st-key-answer")).to_be_visible()
    idle(page)
    tab_to(page, "25 main pressure valve")
    page.keyboard.press("Enter")
    expect(page.locator(".st-key-opened-pair h2")).to_have_text("25 main pressure valve")
    idle(page)
    tab_to(page, "25/1 main pressure valve")
    switch = page.get_by_role("switch", name="25/1 main pressure valve")
    expect(switch).to_be_checked()
    page.keyboard.press("Space")
    expect(switch).not_to_be_checked()
    idle(page)
    expect(switch).to_be_focused()  # for the next one
    page.keyboard.press("Space")
    expect(switch).to_be_checked()
    idle(page)
    tab_to(page, "Report")
    page.keyboard.press("Enter")
    expect(page.get_by_role("heading", name="Report", level=1)).to_be_visible()
    idle(page)
    tab_to(page, "PDF")
    with page.expect_download() as waiting:
        page.keyboard.press("Enter")
    assert Path(waiting.value.path()).read_bytes().startswith(b"%PDF-")
