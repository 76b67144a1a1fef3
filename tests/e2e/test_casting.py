"""A photo of the opened valve body is loaded, its bores are marked, and every picture of the job has verdicts on it."""

from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path

import pypdfium2
import pytest

pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
from PIL import Image, ImageDraw
from playwright.sync_api import Page, expect

from .conftest import end, started, to, unfold


def idle(page: Page) -> None:
    page.locator("[data-testid=stApp][data-test-script-state=notRunning]").wait_for()


def plate() -> bytes:
    """A grey plate with two bores."""
    drawn = Image.new("RGB", (800, 600), "dimgrey")
    ImageDraw.Draw(drawn).rounded_rectangle((60, 60, 740, 540), 40, fill="silver")
    for y in (200, 400):
        ImageDraw.Draw(drawn).rounded_rectangle((150, y - 20, 450, y + 20), 20, fill="black")
    target = io.BytesIO()
    drawn.save(target, "JPEG")
    return target.getvalue()


def test_bores_are_marked_once_and_verdicts_stand_on_the_photo(tmp_path: Path, visit: Callable[[str], Page]) -> None:
    process, address = started(tmp_path, tmp_path / "home")
    try:
        page = visit(f"{address}/Library")
        page.set_viewport_size({"width": 1440, "height": 900})
        unfold(page, "Photo of the opened valve body")
        loader = page.get_by_test_id("stExpander").locator("input[type=file]").first
        loader.set_input_files({"name": "IMG_1.JPG", "mimeType": "image/jpeg", "buffer": plate()})
        photo, marked = page.locator(".marking img"), page.locator(".marking .marked")
        expect(marked).to_have_text("0 of 23 bores marked")
        bore = page.locator(".marking select")
        bore.select_option("25")
        box = photo.bounding_box()
        assert box is not None
        photo.click(position={"x": 0.8 * box["width"], "y": 0.8 * box["height"]})
        photo.click(position={"x": 0.375 * box["width"], "y": box["height"] / 3})  # the mark moves
        expect(marked).to_have_text("1 of 23 bores marked")
        page.locator(".marking .next").click()
        expect(bore).to_have_value("26")
        photo.click(position={"x": 0.375 * box["width"], "y": 2 * box["height"] / 3})
        page.keyboard.press("ArrowDown")
        page.keyboard.press("Enter")
        expect(bore).to_have_value("5")
        expect(marked).to_have_text("2 of 23 bores marked")
        page.locator(".marking .photo").blur()
        idle(page)

        to(page, "Diagnosis")
        shown = page.locator(".casting")
        expect(shown.locator("svg image")).to_be_visible()
        leaders = shown.locator("path.leader")
        expect(leaders).to_have_count(2 * 2)  # a dark line on a light one
        expect(leaders.last).to_be_visible()
        valve = shown.locator("g[data-pair='26']")
        expect(valve).to_contain_text("was 30")
        valve.focus()
        page.keyboard.press("Enter")
        expect(page.locator(".st-key-opened-pair h2")).to_contain_text("26 ")
        page.set_viewport_size({"width": 390, "height": 844})
        expect(leaders.last).to_be_hidden()
        expect(shown.locator(".number", has_text="25")).to_be_visible()
        expect(shown.locator(".below button", has_text="25/1: 57")).to_be_visible()
        page.set_viewport_size({"width": 1440, "height": 900})

        to(page, "Report")
        with page.expect_download() as waiting:
            page.get_by_role("button", name="Page as a file").click()
        html = Path(waiting.value.path()).read_text(encoding="utf-8")
        assert "data:image/jpeg;base64," in html
        assert html.count('class="leader"') == 2 * 2
        with page.expect_download() as waiting:
            page.get_by_role("button", name="PDF", exact=True).click()
        with pypdfium2.PdfDocument(Path(waiting.value.path()).read_bytes()) as document:
            pictures = {"filter": [pypdfium2.raw.FPDF_PAGEOBJ_IMAGE], "max_depth": 5}
            pictured = [number for number, each in enumerate(document) if any(each.get_objects(**pictures))]
        assert pictured[:2] == [0, 1]  # the customer's page and the annex
        again = visit(f"{address}/Library")
        unfold(again, "Photo of the opened valve body")
        expect(again.locator(".marking .marked")).to_have_text("2 of 23 bores marked")
    finally:
        end(process)
