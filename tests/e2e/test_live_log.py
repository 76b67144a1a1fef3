"""A log that is followed on the page changes by itself, and what somebody types there meanwhile stays."""

from __future__ import annotations

import threading
import time
from pathlib import Path

import pytest

pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
from playwright.sync_api import Page, expect

from .conftest import unfold

SAMPLE = Path(__file__).resolve().parents[2] / "sample_data" / "minimum_acceleration_test.csv"


@pytest.mark.page("3_In_the_car")
def test_what_is_typed_while_a_log_is_followed_stays(page: Page, tmp_path: Path) -> None:
    log, lines = tmp_path / "trackLog.csv", SAMPLE.read_bytes().splitlines(keepends=True)
    log.write_bytes(b"".join(lines[:101]))
    unfold(page, "Drop the log")
    unfold(page, "Follow a log while it is being written")
    path = page.get_by_label("Path of the log")
    path.fill(str(log))
    path.press("Enter")
    page.get_by_role("button", name="Follow it").click()
    expect(page.get_by_text("100 rows so far")).to_be_visible(timeout=30_000)

    def grow() -> None:
        with log.open("ab") as stream:
            for first in range(101, len(lines), 100):
                stream.write(b"".join(lines[first : first + 100]))
                stream.flush()
                time.sleep(0.5)

    logger = threading.Thread(target=grow)
    logger.start()
    path.press("End")
    path.press_sequentially(" typed by hand", delay=300)
    logger.join()
    expect(page.get_by_text("1\xa0201 rows so far")).to_be_visible(timeout=30_000)
    expect(page.get_by_text("shift 3 → 4, 8.5 to 8.5 s")).to_be_visible()
    assert path.input_value() == f"{log} typed by hand"
    page.get_by_role("button", name="Stop, and take it into the job").click()
    expect(page.get_by_test_id("stSidebar").get_by_text("trackLog.csv · 1201 rows")).to_be_visible(timeout=30_000)
    expect(page.get_by_text("Following")).to_have_count(0)
