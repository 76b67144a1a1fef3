"""The dashboard in a window of its own: the server ends with it."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import time
import urllib.request
from contextlib import suppress
from pathlib import Path

import pytest

pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
from playwright.sync_api import Browser, Error

from .conftest import CHROMIUM, START, end, free_port


@pytest.mark.skipif(os.name == "nt", reason="the browser is named by a script of a shell")
def test_the_server_ends_with_its_window(browser: Browser, tmp_path: Path) -> None:
    chromium = next((path for path in CHROMIUM if Path(path).is_file()), shutil.which("chromium"))
    if chromium is None:
        pytest.skip("no chromium is installed")
    debugged, program = free_port(), tmp_path / "bin" / "google-chrome"
    program.parent.mkdir()
    as_tested = f"--headless=new --no-sandbox --remote-debugging-port={debugged}"
    program.write_text(f'#!/bin/sh\nexec {chromium} {as_tested} "$@"\n', encoding="utf-8")
    program.chmod(0o755)
    home = tmp_path / "home"
    environment = {**os.environ, "ATLEAK_HOME": str(home), "PATH": f"{program.parent}{os.pathsep}{os.environ['PATH']}"}
    command = [sys.executable, "-m", "atleak", "app", "--window"]
    window = subprocess.Popen(command, cwd=tmp_path, env=environment, start_new_session=True)
    try:
        shown = _shown(browser, debugged)
        port, *_ = (home / "window" / "server").read_text(encoding="utf-8").split()
        assert shown == [f"http://127.0.0.1:{port}/"]
        time.sleep(5)  # a browser that ends sooner has not started, or handed its window on
        over = browser.browser_type.connect_over_cdp(f"http://127.0.0.1:{debugged}")
        over.new_browser_cdp_session().send("Browser.close")  # as closing its last window does on a screen
        assert window.wait(30) == 0
        with pytest.raises(OSError, match="refused"):
            urllib.request.urlopen(shown[0], timeout=5)
    finally:
        with suppress(ProcessLookupError):  # it has ended, and all that it started
            end(window)


def _shown(browser: Browser, port: int) -> list[str]:
    """The addresses that the windows of another browser show, once there is one."""
    limit, shown = time.monotonic() + START, list[str]()
    while not shown and time.monotonic() < limit:
        time.sleep(0.5)
        with suppress(Error):  # it is not there yet
            over = browser.browser_type.connect_over_cdp(f"http://127.0.0.1:{port}")
            shown = [page.url for context in over.contexts for page in context.pages if page.url.startswith("http")]
    return shown
