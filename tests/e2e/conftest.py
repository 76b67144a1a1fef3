"""The dashboard's server, started as a user starts it, and a browser."""

from __future__ import annotations

import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import time
import urllib.request
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

playwright_api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")

CHROMIUM = ("/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome")
# Waits end when what they wait for is there; these only bound them, on a machine that does much else.
START = 180.0  # [s] until the server must answer
SOON = 90_000  # [ms] until the page must show what was asked of it

playwright_api.expect.set_options(timeout=SOON)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Run a browser test again that fails: mouse and keys can meet a page that is drawn anew on a busy machine."""
    for item in items:
        if item.path.parent == Path(__file__).parent:
            item.add_marker(pytest.mark.flaky(reruns=2))


# Comes back when an element has stood where it stands for a second.
AT_REST = """element => new Promise(done => {
    let last = "", since = performance.now()
    const look = () => {
        const {x, y, width, height} = element.getBoundingClientRect(), place = `${x} ${y} ${width} ${height}`
        if (place !== last) [last, since] = [place, performance.now()]
        performance.now() - since > 1000 ? done() : requestAnimationFrame(look)
    }
    look()
})"""


def step(page: playwright_api.Page, name: str) -> playwright_api.Locator:
    """The link to a page in the navigation at the head of the dashboard; a step of the job says how far it is."""
    links = page.locator(".st-key-steps").get_by_role("link")
    return links.filter(has_text=re.compile(rf"^{re.escape(name)}( · |$)"))


def to(page: playwright_api.Page, name: str) -> None:
    """Go to a page by the navigation; it is there when its heading is, a diagnosis with its answer."""
    step(page, name).click()
    named = page.get_by_role("heading", name=name, level=1)
    playwright_api.expect(page.locator(".st-key-answer") if name == "Diagnosis" else named).to_be_visible()
    page.locator("[data-testid=stApp][data-test-script-state=notRunning]").wait_for()


def open_part(page: playwright_api.Page, name: str) -> None:
    """Open a part of a page by its label."""
    page.get_by_test_id("stMain").get_by_role("radio", name=name).click()


def unfold(page: playwright_api.Page, label: str) -> None:
    """Open a fold by the beginning of its label."""
    page.get_by_test_id("stExpander").locator("summary", has_text=label).first.click()


def free_port() -> int:
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return listener.getsockname()[1]


@pytest.fixture(scope="session")
def server_home(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of the user who started the dashboard."""
    return tmp_path_factory.mktemp("home")


@pytest.fixture(scope="session")
def server(tmp_path_factory: pytest.TempPathFactory, server_home: Path) -> Iterator[str]:
    """Address of a dashboard started by ``python -m atleak app`` in a directory of its own."""
    folder = tmp_path_factory.mktemp("elsewhere")
    process, address = started(folder, server_home)
    try:
        yield address
    finally:
        end(process)


def started(folder: Path, home: Path, *options: str, port: int = 0) -> tuple[subprocess.Popen, str]:
    """Start a dashboard in a folder, for the user of a home; return its process and its address."""
    port = port or free_port()
    environment = {**os.environ, "ATLEAK_HOME": str(home), "NO_PROXY": "127.0.0.1"}
    environment["ATLEAK_TRACEBACK"] = "1"  # a fault of a page is an exception there
    environment["STREAMLIT_SERVER_HEADLESS"] = "true"  # no window of its own
    command = [sys.executable, "-m", "atleak", "app", "--port", str(port), *options]
    with (folder / "server.log").open("ab") as log:
        process = subprocess.Popen(
            command, cwd=folder, env=environment, stdout=log, stderr=subprocess.STDOUT, start_new_session=True
        )
    try:
        _wait(f"http://127.0.0.1:{port}/_stcore/health", process, folder / "server.log")
    except BaseException:
        end(process)
        raise
    return process, f"http://127.0.0.1:{port}"


def _wait(address: str, process: subprocess.Popen, log: Path) -> None:
    limit = time.monotonic() + START
    while time.monotonic() < limit and process.poll() is None:
        try:
            with urllib.request.urlopen(address, timeout=2) as answer:
                if answer.status == 200:
                    return
        except OSError:
            time.sleep(0.2)
    raise AssertionError(f"the server did not answer: {log.read_text(encoding='utf-8', errors='replace')[-2000:]}")


def end(process: subprocess.Popen, how: signal.Signals = signal.SIGTERM) -> None:
    """End the command and the server it started: its own process group, nothing else."""
    if os.name == "nt":
        subprocess.run(["taskkill", "/T", "/F", "/PID", str(process.pid)], capture_output=True, check=False)
    else:
        os.killpg(process.pid, how)
    process.wait(timeout=20)


@pytest.fixture(scope="session")
def browser() -> Iterator[playwright_api.Browser]:
    executable = next((path for path in CHROMIUM if Path(path).is_file()), shutil.which("chromium"))
    with playwright_api.sync_playwright() as driver:
        try:
            opened = driver.chromium.launch(executable_path=executable, args=["--no-sandbox"])
        except playwright_api.Error as error:
            pytest.skip(f"no browser to test with: {str(error).splitlines()[0]}")
        yield opened
        opened.close()


@pytest.fixture
def visit(browser: playwright_api.Browser) -> Iterator[Callable[[str], playwright_api.Page]]:
    """Opens an address as another visitor would, with nothing kept from the last."""
    contexts = []

    def opened(address: str) -> playwright_api.Page:
        contexts.append(browser.new_context(viewport={"width": 1280, "height": 900}))
        contexts[-1].set_default_timeout(SOON)
        page = contexts[-1].new_page()
        page.goto(address)
        return page

    yield opened
    for context in contexts:
        context.close()


@pytest.fixture
def page(
    request: pytest.FixtureRequest, visit: Callable[[str], playwright_api.Page], server: str
) -> playwright_api.Page:
    """The dashboard, freshly opened on the sample job: on the page of the test's mark, else on the diagnosis."""
    mark = request.node.get_closest_marker("page")
    opened = visit(f"{server}/{mark.args[0].partition('_')[2] if mark else 'Diagnosis'}")
    opened.get_by_text("Sample job: made-up data").wait_for()
    return opened
