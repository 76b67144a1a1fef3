"""Measure the dashboard in a browser, as CPU time of its server, beside a Streamlit hello-world in the same run.

    python benchmarks/dashboard.py [--small] [--starts 4] [--repeats 4] [--rows 1800000] [--only start,sample,...]

prints, with the goals:

- start: CPU of a server from its start until its first visitor sees content, and until the page has come to rest, as a
  ratio to a hello-world that imports pandas and plotly (goals 1.2 and 1.4);
- sample, log: CPU from changing one control until the page is at rest again, on the sample job and with a made-up log
  of 1.8 million rows (goals 0.25 s and 0.5 s); no number is typed twice, as results are kept;
- drop: CPU from dropping that log beside the sample's sheet until the page is at rest and the job is saved, as a ratio
  to pandas reading it (goal 3);
- memory: what the server holds before a visitor uploads that log, with it, and after the window was closed and
  Streamlit's two minutes for coming back are over.

A control is looked for by its label, first on the page that is shown, then on the pages of `PAGES`.
"""

from __future__ import annotations

import argparse
import re
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from playwright.sync_api import Browser, Locator, Page, sync_playwright
from road_test_import import write_logs
from servers import PATIENCE, ROOT, Server
from timing import options

SHEET = ROOT / "sample_data" / "measuring_sheet_four_speed.xlsx"
OPTIONS = options(__doc__)
OPTIONS.add_argument("--starts", type=int, default=4)
OPTIONS.add_argument("--repeats", type=int, default=4)
OPTIONS.add_argument("--rows", type=int, default=1_800_000)
PARTS = ("start", "sample", "drop", "log", "memory")
OPTIONS.add_argument("--only", default=",".join(PARTS), help="which parts, of " + ", ".join(PARTS))
SMALL = {"starts": 1, "repeats": 1, "rows": 2_000}

HELLO = """import pandas
import plotly.graph_objects
import streamlit

streamlit.title("Hello")
streamlit.write("world")
"""
PAGES = ("Diagnosis", "Job", "Settings", "Plan", "Measure", "In_the_car")
SHOWN = "Diagnosis"  # the page on which controls of the panel are changed
MAIN, PANEL = "[data-testid=stMain]", "[data-testid=stSidebar]"
FIRST = f"{MAIN} h1"
# Opens every closed fold that holds a field of that label; returns how many.
OPEN_FOLDS = """label => {
    const closed = [...document.querySelectorAll("details:not([open])")]
    const holding = closed.filter(fold => fold.textContent.includes(label))
    holding.forEach(fold => fold.querySelector("summary").click())
    return holding.length
}"""
PANDAS = (
    "import pandas, sys, time; t = time.process_time(); pandas.read_csv(sys.argv[1]); print(time.process_time() - t)"
)
QUIET = 0.4  # [s] without any work of the server: the page is at rest
FORGOTTEN = 125.0  # [s] after which Streamlit forgets a session that does not come back
LEAVING = 45.0  # [s] in which a server notices that a window was closed, and gives back what it held
GOALS = {"first content": 1.2, "at rest": 1.4}
DROP_GOAL = 3.0
CHANGE_GOALS = {"sample": 0.25, "log": 0.5}  # [s]


@dataclass(frozen=True)
class Control:
    """Something that is changed on a page: by typing another number, or by choosing the next option."""

    name: str
    label: str  # as on the page, from its start
    numbers: tuple[int, int] | None = None  # the first, and the step from one to the next


CONTROLS = (
    Control("fluid", "Fluid"),
    Control("limits", "Limits"),
    Control("temperature", "Temperature", (81, 1)),
    Control("engine speed", "Engine speed", (900, 10)),
    Control("mileage", "Mileage", (120_000, 500)),
    Control("spools' instrument", "Spools"),
)


def main(chosen: argparse.Namespace) -> None:
    if chosen.small:
        for name, value in SMALL.items():
            setattr(chosen, name, value)
    parts = chosen.only.split(",")
    with tempfile.TemporaryDirectory() as folder, _browser() as browser:
        place = Path(folder)
        if "start" in parts:
            _starts(browser, place, chosen.starts, small=chosen.small)
        if set(parts) - {"start"}:
            with Visited.of_atleak(place / "home") as server:
                log = write_logs(place, chosen.rows)["clean"] if set(parts) & {"drop", "log", "memory"} else None
                controls = CONTROLS[2:3] if chosen.small else CONTROLS
                _changes(browser, server, parts, controls, chosen.repeats, log)
                if "memory" in parts:
                    _closed(browser, server, wait=0.0 if chosen.small else FORGOTTEN)


def _starts(browser: Browser, folder: Path, starts: int, *, small: bool) -> None:
    """Print what the first visit after a server's start costs; the two kinds of server take turns."""
    hello = folder / "hello.py"
    hello.write_text(HELLO, encoding="utf-8")
    kinds: dict[str, Callable[[int], Visited]] = {
        "hello-world": lambda _: Visited([sys.executable, "-m", "streamlit", "run", str(hello)], folder / "home"),
        "bare address": lambda number: Visited.of_atleak(folder / f"home{number}"),
        SHOWN: lambda number: Visited.of_atleak(folder / f"home{number}", SHOWN),
    }
    if small:
        del kinds[SHOWN]
    found: dict[str, list[tuple[float, float]]] = {name: [] for name in kinds}
    for number in range(starts + (starts > 1)):  # the first compiles what is imported, and is not counted
        for name, start in kinds.items():
            with start(number) as server, server.visit(browser) as page:
                page.locator(FIRST).first.wait_for()
                content = server.cpu()
                server.rest(page)
                found[name].append((content, server.cpu()))
        if number == 0 and starts > 1:
            found = {name: [] for name in kinds}
    medians = {name: [statistics.median(each) for each in zip(*times, strict=True)] for name, times in found.items()}
    print(f"first visit after the server's start: CPU of the server [s], median of {starts}, and over hello-world")
    for name, times in medians.items():
        ratios = (time / own for time, own in zip(times, medians["hello-world"], strict=True))
        cells = (
            f"{what} {time:5.2f}  {ratio:4.2f} (goal {GOALS[what]})"
            for what, time, ratio in zip(GOALS, times, ratios, strict=True)
        )
        print(f"  {name:14}", "   ".join(cells))


def _changes(
    browser: Browser,
    server: Visited,
    parts: list[str],
    controls: tuple[Control, ...],
    repeats: int,
    log: Path | None,
) -> None:
    """Print what a changed control costs, on the sample job and then with a long log in the place of the sample's."""
    with server.visit(browser, SHOWN) as page:
        page.locator(FIRST).first.wait_for()
        server.rest(page)
        print(f"memory: {server.memory():.0f} MB after the first visit")
        if "sample" in parts:
            _measure(page, server, "sample", controls, repeats)
        if log is None:
            return
        _upload(page, server, SHEET)
        before = server.cpu()
        _upload(page, server, log)
        spent = server.cpu() - before
        if "drop" in parts:
            command = [sys.executable, "-c", PANDAS, str(log)]
            own = float(subprocess.run(command, capture_output=True, text=True, check=True).stdout)
            print(f"the log dropped: CPU {spent:.2f} s, {spent / own:.1f} times pandas' {own:.2f} s (goal {DROP_GOAL})")
        _go(page, server, SHOWN)
        print(f"memory: {server.memory():.0f} MB with a log of {log.stat().st_size / 1e6:.0f} MB")
        if "log" in parts:
            _measure(page, server, "log", controls, repeats)
            print(f"memory: {server.memory():.0f} MB after these changes")


def _measure(page: Page, server: Visited, what: str, controls: tuple[Control, ...], repeats: int) -> None:
    print(f"one control changed, {what}: CPU of the server until the page is at rest [s] (goal {CHANGE_GOALS[what]})")
    for control in controls:
        times, where = [], ""
        for number in range(repeats + (repeats > 1)):  # the first time also fills caches
            element, where = _find(page, server, control.label)
            if element is None:
                break
            before = server.cpu()
            _change(page, element, control, number + (repeats + 1) * (what == "log"))
            server.rest(page)
            times.append(server.cpu() - before)
        if not times:
            print(f"  {control.name:20} not to be seen on any page")
            continue
        several = times[1:] or times
        spread = f"{min(several):.2f} … {max(several):.2f}; the first {times[0]:.2f}"
        print(f"  {control.name:20} {statistics.median(several):5.2f}   ({spread}), on {where}")
    _go(page, server, SHOWN)


def _find(page: Page, server: Visited, label: str) -> tuple[Locator | None, str]:
    """Return the field with a label and the page on which it stands, and show that page."""
    shown = _name(page)
    for name in dict.fromkeys([shown, *PAGES]):
        if name != _name(page):
            _go(page, server, name)
        if page.evaluate(OPEN_FOLDS, label):
            server.rest(page)
        wanted = re.compile(rf"(^|\. ){re.escape(label)}")
        fields = page.get_by_label(wanted).locator("visible=true").and_(page.locator("input, [role=combobox]"))
        if fields.count():
            return fields.first, name
    return None, ""


def _change(page: Page, element: Locator, control: Control, number: int) -> None:
    element.scroll_into_view_if_needed()
    if control.numbers is not None:
        first, step = control.numbers
        element.fill(str(first + step * number))
        element.press("Enter")
        return
    element.click()
    for key in ("ArrowDown" if number % 2 == 0 else "ArrowUp", "Enter"):
        time.sleep(0.1)
        page.keyboard.press(key)


def _upload(page: Page, server: Visited, file: Path) -> None:
    """Give a file to the uploader that names its kind, or to the one that takes all."""
    words = "Measuring sheet" if file == SHEET else "Road-test log"
    for name in (_name(page), "Job"):
        if name != _name(page):
            _go(page, server, name)
        uploaders = page.get_by_test_id("stFileUploader")
        for uploader in (uploaders.filter(has_text=words), uploaders):
            if uploader.count():
                uploader.first.locator("input[type=file]").set_input_files(file)
                time.sleep(1.0)
                server.rest(page)
                return
    raise SystemExit("no page takes a file")


def _closed(browser: Browser, server: Visited, wait: float) -> None:
    """Print what the server holds when the window was closed and Streamlit has forgotten its session.

    Streamlit looks for sessions to forget where another one comes or goes.
    """
    print(f"memory: {server.memory():.0f} MB where the window was just closed")
    time.sleep(wait)
    with server.visit(browser) as page:
        page.locator(FIRST).first.wait_for()
        server.rest(page)
    time.sleep(LEAVING if wait else 1.0)
    print(f"memory: {server.memory():.0f} MB {wait:.0f} s later, when another visitor has come and gone")


def _name(page: Page) -> str:
    return page.url.partition("?")[0].rstrip("/").rsplit("/", 1)[-1]


def _go(page: Page, server: Visited, name: str) -> None:
    """Show a page by its link, where there is one: the session stays."""
    link = page.locator(f"a[href$='{name}'], a[href*='{name}?']").locator("visible=true")
    if link.count():
        link.first.click()
    else:
        for group in page.get_by_test_id("stTopNavSection").all():
            group.click()
            item = page.get_by_role("menuitem", name=name.replace("_", " "), exact=True)
            if item.count():
                item.first.click()
                break
            page.keyboard.press("Escape")
    server.rest(page)


@contextmanager
def _browser() -> Iterator[Browser]:
    names = ("chromium", "chromium-browser", "google-chrome")
    executable = next((found for found in map(shutil.which, names) if found), None)
    with sync_playwright() as driver:
        opened = driver.chromium.launch(executable_path=executable, args=["--no-sandbox", "--disable-gpu"])
        yield opened
        opened.close()


class Visited(Server):
    """A server that a browser visits."""

    @contextmanager
    def visit(self, browser: Browser, page: str | None = None) -> Iterator[Page]:
        """Open a page of it in a new window."""
        context = browser.new_context(viewport={"width": 1280, "height": 900})
        context.set_default_timeout(PATIENCE * 1e3)
        window = context.new_page()
        window.goto(f"{self.address}/{self.page if page is None else page}")
        yield window
        context.close()

    def rest(self, page: Page) -> None:
        """Wait until the page runs no script and shows nothing old, and the server has nothing to do."""
        limit = time.monotonic() + PATIENCE
        before, since = self.cpu(), time.monotonic()
        while time.monotonic() < limit:
            time.sleep(0.05)
            idle = page.evaluate(
                """() => document.querySelector("[data-testid=stApp][data-test-script-state=notRunning]") !== null
                && document.querySelector("[data-stale=true]") === null"""
            )
            now = self.cpu()
            if not idle or now - before > 0.011:
                before, since = now, time.monotonic()
            elif time.monotonic() - since > QUIET:
                return
        raise SystemExit("a page did not come to rest")


if __name__ == "__main__":
    main(OPTIONS.parse_args())
