"""A job that was typed is there again after its tab and its server were killed, and two browsers never cross."""

from __future__ import annotations

import signal
import time
from collections.abc import Callable
from pathlib import Path

import pytest

pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
from playwright.sync_api import Page, expect

from atleak.job_book.book import Book, open_book
from atleak.measurements.job_card import Job

from .conftest import SOON, end, started, to

TYPED = {"Job number": "2026-0417", "Technician": "K. N.", "Make": "Mercedes", "VIN": "WDB2100371A123456"}


def typed_in(page: Page, label: str, text: str) -> None:
    """Type as a person does: click, keys, on to the next field; wait until the address names the job."""
    field = page.get_by_label(label, exact=True)
    field.click()
    page.keyboard.press("ControlOrMeta+a")
    page.keyboard.type(text, delay=30)
    page.keyboard.press("Tab")


def wait_until_kept(book: Book, job: str, kept: Callable[[Job], bool]) -> None:
    """Wait until the record in the book is as it was typed."""
    limit = time.monotonic() + SOON / 1000
    while not kept(book.load(job).file.job):
        assert time.monotonic() < limit, "what was typed is not in the book"
        time.sleep(0.1)


@pytest.mark.slow
def test_a_killed_tab_and_a_killed_server_lose_no_digit_and_the_second_browser_is_told(
    visit: Callable[[str], Page], tmp_path: Path
) -> None:
    process, address = started(tmp_path, tmp_path / "home")
    try:
        page = visit(f"{address}/Job")
        page.get_by_role("button", name="New, empty job").click()  # nothing of the sample is kept
        expect(page.get_by_text("No measuring sheet yet")).to_be_visible()
        for label, text in TYPED.items():
            typed_in(page, label, text)
        page.wait_for_url("**job=*")
        expect(page.get_by_text("In the job book: 2026-0417")).to_be_visible()
        job = page.url.partition("job=")[2]
        book = open_book(f"sqlite:///{tmp_path / 'home' / 'book.sqlite'}")
        wait_until_kept(book, job, lambda record: record.vehicle.vin == TYPED["VIN"])
        page.close()
        end(process, signal.SIGKILL)
        process, address = started(tmp_path, tmp_path / "home")

        first = visit(f"{address}/Job?job={job}")
        for label, text in TYPED.items():
            expect(first.get_by_label(label, exact=True)).to_have_value(text)
        to(first, "Measure")
        first.wait_for_url(f"**/Measure?job={job}")
        to(first, "Job")
        expect(first.get_by_label("VIN", exact=True)).to_have_value(TYPED["VIN"])
        second = visit(f"{address}/Job?job={job}")
        expect(second.get_by_label("VIN", exact=True)).to_have_value(TYPED["VIN"])
        typed_in(second, "Make", "BMW")
        wait_until_kept(book, job, lambda record: record.vehicle.make == "BMW")
        typed_in(first, "Technician", "A. B.")
        expect(first.get_by_text("Changed elsewhere.")).to_be_visible()
        first.get_by_role("button", name="Show the newer state").click()
        expect(first.get_by_label("Make", exact=True).first).to_have_value("BMW")  # beside the old form for a moment
        expect(first.get_by_label("Technician", exact=True).first).to_have_value(TYPED["Technician"])
    finally:
        end(process)
