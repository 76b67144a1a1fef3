"""A valve body is measured at the keyboard: no mouse, commas, a slip told at its cell, and nothing lost by a reload."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
from playwright.sync_api import Locator, Page, expect

ROOT = Path(__file__).resolve().parents[2]
SIXTH = """
[[components]]
id = "manual_valve"
name = "manual valve"
lands = [{ land = 1, nominal_diameter_mm = 14.0, mounting_clearance_um = 18.0 }]
"""
SPOOLS = (15.0, 12.5, 11.0, 9.5, 18.0, 14.0)  # [mm], as the file names them
NEW = (0.018, 0.018, 0.016, 0.014, 0.020, 0.018)  # [mm] radial


def entries() -> list[str]:
    """Every diameter in the order of measuring: all spools, then all bores, each worn by 3 µm."""
    sizes = [*SPOOLS, *(size + 2 * (new + 0.003) for size, new in zip(SPOOLS, NEW, strict=True))]
    return [f"{size + 0.001 * (number % 2):.3f}".replace(".", ",") for size in sizes for number in range(4)]


def cell(page: Page, name: str) -> Locator:
    return page.get_by_role("textbox", name=name, exact=True)


def written(page: Page, text: str, key: str = "Enter") -> None:
    page.keyboard.type(text)  # as fast as callipers send it
    page.keyboard.press(key)


@pytest.fixture
def six_lands(server_home: Path) -> Iterator[None]:
    """A valve body of six lands in the catalogue of the user who started the dashboard."""
    minimal = (ROOT / "atleak" / "catalogue" / "controllers" / "minimal_example.toml").read_text(encoding="utf-8")
    own = minimal.replace('"minimal_example"', '"six_lands"').replace('"Example of', '"Six lands,')
    path = server_home / "catalogue" / "controllers" / "six_lands.toml"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(own + SIXTH, encoding="utf-8")
    yield
    path.unlink()


@pytest.mark.page("2_Measure")
@pytest.mark.usefixtures("six_lands")
def test_six_lands_are_measured_by_keyboard_alone(page: Page, visit: Callable[[str], Page], server_home: Path) -> None:
    page.reload()
    box = page.get_by_test_id("stSidebar").get_by_role("combobox", name="Valve body")
    box.fill("Six lands")
    box.press("Enter")
    state = page.locator(".measuring .state")
    expect(page.get_by_role("radio", name="Quick pass")).to_be_checked()
    page.get_by_role("radio", name="Whole sheet").press("Space")
    expect(state).to_have_text("0/48 · all in the job")
    page.get_by_role("tab", name="Type readings").focus()
    for _ in range(30):  # as far as Tab must go
        page.keyboard.press("Tab")
        if page.evaluate("document.activeElement.shadowRoot?.activeElement?.tagName") == "INPUT":
            break
    expect(cell(page, "pressure regulator valve, Spool, plane 1, 0°, Repeat 1")).to_be_focused()

    values = entries()
    for number, value in enumerate(values[:40]):
        slip = value.replace(",", "") if number == 5 else value
        written(page, slip, "Tab" if number % 2 else "Enter")
    said = page.locator(".measuring .said")
    expect(said).to_contain_text(
        "pressure regulator valve, Spool, plane 2, 0°, Repeat 2: 12501: the diameter is 1000 times"
    )
    written(page, "99")
    page.keyboard.press("Shift+Tab")
    expect(state).to_have_text("41/48 · all in the job")
    page.keyboard.press("Control+z")
    expect(cell(page, "accumulator piston, Bore, plane 1, 0°, Repeat 1")).to_have_value("")

    block = "\\r\\n".join("\\t".join(values[at : at + 2]) for at in range(40, 48, 2))
    page.evaluate(
        f"""() => {{
            const data = new DataTransfer(), field = document.activeElement.shadowRoot.activeElement
            data.setData("text/plain", "{block}\\r\\n")
            field.dispatchEvent(new ClipboardEvent("paste", {{clipboardData: data, bubbles: true, cancelable: true}}))
        }}"""
    )
    expect(state).to_have_text("48/48 · all in the job")
    page.keyboard.press("F8")
    slipped = cell(page, "pressure regulator valve, Spool, plane 2, 0°, Repeat 2")
    expect(slipped).to_be_focused()
    expect(slipped).to_have_attribute("aria-invalid", "true")
    written(page, values[5])
    expect(said).to_have_text("")
    lands = page.locator(".measuring .lands tr")
    expect(lands.nth(2)).to_have_text(re.compile(r"Land 2.*21.0.µm.*17.%.*0.0.µm.*ok"))
    expect(page.get_by_text("48 readings in mm; 6 of 6 lands measured.")).to_be_visible()

    page.keyboard.type("12,3")  # of the next cell, no Enter yet
    page.wait_for_url("**job=*")
    page.reload()
    expect(state).to_have_text("48/48 · all in the job")
    expect(cell(page, "pressure regulator valve, Spool, plane 2, 90°, Repeat 1")).to_have_value("12,3")
    second = visit(page.url)
    expect(second.locator(".measuring .state")).to_have_text("48/48 · all in the job")
    expect(cell(second, "pressure regulator valve, Bore, plane 1, 0°, Repeat 1")).to_have_value(values[24])
    expect(cell(second, "pressure regulator valve, Spool, plane 2, 90°, Repeat 1")).to_have_value("12,3")


@pytest.mark.page("2_Measure")
@pytest.mark.usefixtures("six_lands")
def test_at_the_bench_one_reading_fills_the_screen_and_the_last_one_says_so(page: Page) -> None:
    page.reload()
    box = page.get_by_test_id("stSidebar").get_by_role("combobox", name="Valve body")
    box.fill("Six lands")
    box.press("Enter")
    state, field = page.locator(".measuring .state"), page.locator(".measuring input:visible")
    page.get_by_role("radio", name="Whole sheet").click()
    expect(state).to_have_text("0/48 · all in the job")
    page.get_by_role("button", name="One at a time, full screen").click()
    expect(field).to_have_count(1)
    expect(field).to_be_focused()
    expect(field).to_have_css("font-size", "80px")
    for value in entries()[:2]:
        written(page, value)  # as a gauge sends it
    expect(field).to_have_attribute("aria-label", "pressure regulator valve, Spool, plane 1, 90°, Repeat 1")
    for _ in range(46):
        page.keyboard.press("Enter")
    said = page.locator(".measuring .said")
    expect(said).to_have_text("That was the last reading of the sheet. Still empty: 46.")
    page.get_by_role("button", name="Back to the sheet").click()
    expect(page.locator(".measuring.bench")).to_have_count(0)
    expect(state).to_have_text("2/48 · all in the job")
