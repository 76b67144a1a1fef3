"""Make the screenshots and report pages of the documentation from the sample job.

    python tools/screenshots.py                     # all of them, into docs/pictures
    python tools/screenshots.py --only diagnosis    # one of them; may be repeated
    python tools/screenshots.py --check             # into a temporary folder, and compared with docs/pictures

It starts the dashboard on 127.0.0.1 for a user's folder of its own, drives it in Chromium, and ends the server that it
started. ``--check`` ends with status 1 and names every picture that cannot be made any more, or that differs
clearly from the one that is kept; dates are fixed and machine paths taken out, so that two runs give the same pictures.
Two pictures differ clearly where one is over `SIZE_APART` wider or higher than the other, or where, both reduced to
`SEEN_AT` pixels of width and to shades of grey, they differ by more than `MEAN_APART` of 255 shades on average, or more
than `DOTS_APART` of the reduced pixels by more than `DOT_APART` shades. Between
runs with other palettes the average was 0.6 at most, and no pixel was over 28.

It wants the extras ``test`` and ``fleet`` and Chromium.
"""

from __future__ import annotations

import argparse
import io
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import urllib.request
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

import picture_jobs as made
import pypdfium2
from PIL import Image, ImageChops, ImageStat
from playwright.sync_api import Browser, Error, Locator, Page, expect, sync_playwright

from atleak.analysis.comparison import compare
from atleak.fleet.results import Results
from atleak.fleet.summary import summed_up
from atleak.fleet.summary_pdf import write_summary_pdf
from atleak.report.pdf import write_pdf
from atleak.report.pdf.comparison import write_comparison_pdf

PICTURES = Path(__file__).resolve().parents[1] / "docs" / "pictures"
CHROMIUM = ("/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome")
WIDTH, PHONE = 1200, 390  # [px] of the window
TALL = 5200  # [px] of the window, so that whatever is shown is drawn
EDGE, ABOVE = 14, 4  # [px] around what is shown, and above it
PAGE_WIDTH = 900  # [px] of a report's page
WORN = 1.5  # times as measured, of what is tried
COLOURS = 256  # of a picture
LARGEST = 150_000  # bytes
START = 180.0  # [s] until the server must answer
SOON = 60_000  # [ms] until the page must show what was asked of it
REST = 300  # [ms] in which a page that is at rest stays the same
SIZE_APART, SEEN_AT, MEAN_APART = 0.04, 160, 1.5
DOT_APART, DOTS_APART = 48, 0.005

IDLE = "[data-testid=stApp][data-test-script-state=notRunning]"
BUSY = "[data-testid=stSkeleton], [data-testid=stSpinner], [data-testid=stToast]"
# Takes a folder of this machine out of all texts that are shown.
WITHOUT_FOLDER = """folder => {
    const walk = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT)
    while (walk.nextNode()) walk.currentNode.data = walk.currentNode.data.split(" · " + folder).join("")
    for (const field of document.querySelectorAll("input:not([type=file])"))
        field.value = field.value.split(" · " + folder).join("")
}"""

Frame = tuple[float, float, float, float]  # left, top, right, bottom [px]


@dataclass(frozen=True)
class Part:
    """What of a window is shown: from one element to another without the panel at the side, or all down to one."""

    last: Locator
    first: Locator | None = None

    def frame(self, page: Page) -> Frame:
        """Return where it is."""
        bottom = box(self.last)[3] + EDGE
        if self.first is None:
            return 0.0, 0.0, float(page.evaluate("window.innerWidth")), bottom
        column = page.get_by_test_id("stMainBlockContainer").locator("[data-testid=stVerticalBlock]").first
        left, _, right, _ = box(column)
        return left - EDGE, box(self.first)[1] - ABOVE, right + EDGE, bottom


@dataclass(frozen=True)
class Dashboard:
    """Where the dashboard is, and what it holds."""

    address: str
    jobs: Mapping[str, str]  # id by number
    folder: Path  # of the fleet's results


@dataclass(frozen=True)
class Shot:
    """A screenshot: from which page, what is done there, and which part of the window it shows."""

    address: str  # of the page; {SAMPLE-1} stands for the id of a job
    part: Callable[[Page], Part]
    width: int = WIDTH
    dark: bool = False


# --- what is done on a page, and what of it is shown


def box(place: Locator) -> Frame:
    """Return where an element is."""
    found = place.bounding_box()
    assert found is not None
    return found["x"], found["y"], found["x"] + found["width"], found["y"] + found["height"]


def title(page: Page) -> Locator:
    """Return the page's title."""
    return page.get_by_role("heading", level=1)


def heading(page: Page, text: str) -> Locator:
    """Return one of the page's headings."""
    return page.get_by_role("heading", name=text, exact=True).first


def chart(page: Page, after: str) -> Locator:
    """Return the chart under a heading."""
    return heading(page, after).locator("xpath=following::*[@data-testid='stPlotlyChart'][1]")


def table(page: Page, after: str) -> Locator:
    """Return the table under a heading."""
    return heading(page, after).locator("xpath=following::*[@data-testid='stDataFrame'][1]")


def idle(page: Page) -> None:
    """Wait until everything is there that was asked for."""
    page.locator(IDLE).wait_for()
    page.wait_for_function(f"!document.querySelector({BUSY!r})")


def job(page: Page) -> Part:
    return Part(page.get_by_text("Logo and photos"))


def readings(page: Page) -> Part:
    page.get_by_role("tab", name="Clearances and wear").click()
    page.get_by_text("flagged", exact=True).click()
    idle(page)
    return Part(page.get_by_test_id("stPlotlyChart").first, title(page))


def typed_readings(page: Page) -> Part:
    page.get_by_role("button", name="Begin an empty job").click()
    page.get_by_text("Whole sheet").first.click()  # an empty job begins with the quick pass
    expect(page.locator(".measuring .state")).to_contain_text("0/376")
    idle(page)
    cells = page.locator(".measuring input")
    for first, values in ((4, ("14.069", "14.068", "14.071", "1407.0")), (0, ("13.999", "13.998", "13.999", "13.999"))):
        cells.nth(first).click()
        for value in values:
            page.keyboard.type(value)
            page.keyboard.press("Enter")
        page.locator(".measuring button").first.click()  # back to the first component
    expect(page.locator(".measuring .state")).to_contain_text("8/")
    idle(page)
    return Part(page.get_by_text("Enter or Tab: next cell"), page.get_by_role("tab", name="Type readings"))


def in_the_car(page: Page) -> Part:
    page.get_by_role("button", name="New, empty job").click()
    page.get_by_role("combobox", name="Valve body").click()
    page.keyboard.type("Five-speed after Ford's")
    page.keyboard.press("Enter")
    idle(page)
    uploader = page.get_by_test_id("stSidebar").locator("input[type=file]").first
    uploader.set_input_files(PICTURES.parents[1] / "sample_data" / "gauge_readings_five_speed.csv")
    page.get_by_text("10 gauge readings").first.wait_for()
    idle(page)
    page.get_by_text("What is likely worn, and what").click()
    idle(page)
    return Part(page.get_by_text("Forward clutch has lost").last, title(page))


def road_test(page: Page) -> Part:
    page.get_by_text("The log in full").click()
    idle(page)
    return Part(page.get_by_text("× suspect samples"), page.locator(".st-key-log-cursor"))


def diagnosis(page: Page) -> Part:
    return Part(page.get_by_text("Road-test log", exact=True).last)


def diagnosis_land(page: Page) -> Part:
    page.locator("button[data-pair='25']").first.click()
    expect(page.get_by_text("Ovality of the bore").first).to_be_visible()
    idle(page)
    shown = page.locator(".st-key-opened-pair")
    return Part(shown, shown)


def diagnosis_narrow(page: Page) -> Part:
    return Part(page.get_by_text("valves are within their limits").first)


def what_if(page: Page) -> Part:
    field = page.get_by_role("textbox", name="Temperature [°C]").last
    field.fill("110")
    field.press("Enter")
    expect(page.get_by_text("110 °C").first).to_be_visible()
    idle(page)
    wear = page.get_by_role("slider").first
    wear.focus()
    while float(wear.input_value()) < WORN:
        page.keyboard.press("ArrowRight")
    page.keyboard.press("Tab")
    expect(page.get_by_text(re.compile(r"Tried:.*wear × 1\.5"))).to_be_visible()
    idle(page)
    return Part(chart(page, "Share over temperature and wear"), title(page))


def report(page: Page) -> Part:
    return Part(page.get_by_role("button", name="Job file"))


def job_book(page: Page) -> Part:
    return Part(page.get_by_text("Units that may be one"), title(page))


def transmission(page: Page) -> Part:
    page.get_by_role("combobox", name="Start from").click()
    page.keyboard.type("Example of a workshop's own description")
    page.keyboard.press("Enter")
    idle(page)
    page.get_by_role("button", name="Start", exact=True).click()
    page.get_by_text("Components", exact=True).click()
    table(page, "Lands").wait_for()
    idle(page)
    return Part(table(page, "Components"), title(page))


def fleet(page: Page) -> Part:
    return Part(table(page, "Units, the worst first"), title(page))


def fleet_pairs(page: Page) -> Part:
    return Part(chart(page, "Wear over mileage"), heading(page, "Pairs that are most often to be replaced"))


def compare_page(page: Page) -> Part:
    return Part(table(page, "Totals and pressures"), title(page))


# job-book comes before typed-readings, which puts a job of its own into the book
SHOTS: dict[str, Shot] = {
    "job-book": Shot("Jobs", job_book),
    "compare": Shot("History?history=compare&before={SAMPLE-1}&after={SAMPLE-2}", compare_page),
    "fleet": Shot("Fleet", fleet),
    "fleet-pairs": Shot("Fleet", fleet_pairs),
    "job": Shot("Job?job={SAMPLE-1}", job),
    "readings": Shot("Measure", readings),
    "in-the-car": Shot("In_the_car", in_the_car),
    "road-test": Shot("In_the_car", road_test),
    "diagnosis": Shot("Diagnosis", diagnosis),
    "diagnosis-dark": Shot("Diagnosis", diagnosis, dark=True),
    "diagnosis-narrow": Shot("Diagnosis", diagnosis_narrow, width=PHONE),
    "diagnosis-land": Shot("Diagnosis", diagnosis_land),
    "what-if": Shot("Plan?plan=what_if", what_if),
    "report": Shot("Report", report),
    "transmission": Shot("Library?library=transmission", transmission),
    "typed-readings": Shot("Measure", typed_readings),
}


def taken(browser: Browser, dashboard: Dashboard, shot: Shot) -> Image.Image:
    """Open a page as a visitor with nothing kept, do what is to be done there, and return the part that is shown."""
    context = browser.new_context(
        viewport={"width": shot.width, "height": TALL},
        locale="en-GB",
        timezone_id="UTC",
        color_scheme="dark" if shot.dark else "light",
        reduced_motion="reduce",
    )
    try:
        context.set_default_timeout(SOON)
        page = context.new_page()
        address = re.sub(r"\{(.*?)\}", lambda found: dashboard.jobs[found[1]], shot.address)
        page.goto(f"{dashboard.address}/{address}")
        page.get_by_text(re.compile("job book", re.IGNORECASE)).first.wait_for(state="attached")  # hidden on a phone
        idle(page)
        shown = shot.part(page)
        page.mouse.move(0, 0)
        page.evaluate("document.activeElement?.blur?.()")
        page.evaluate(WITHOUT_FOLDER, str(dashboard.folder.parent))
        return _at_rest(page, shown)
    finally:
        context.close()


def _at_rest(page: Page, shown: Part) -> Image.Image:
    """Return the picture as soon as it stays the same for a moment."""
    limit, last = time.monotonic() + SOON / 1000, b""
    while time.monotonic() < limit:
        now = page.screenshot(animations="disabled", caret="hide")
        if now == last:
            return Image.open(io.BytesIO(now)).convert("RGB").crop(tuple(map(round, shown.frame(page))))
        last = now
        page.wait_for_timeout(REST)
        idle(page)
    raise Error("the page does not come to rest")


# --- pages of reports


def report_pages(folder: Path) -> Iterator[tuple[str, Callable[[], bytes]]]:
    """Return by the name of its picture how each report is written of which the first page is shown."""

    def of_report() -> bytes:
        _, found, record = next(made.visits())
        return write_pdf(found, record)

    def of_comparison() -> bytes:
        (_, first, before), (_, second, after) = made.visits()
        return write_comparison_pdf(compare(first, second), before, after)

    def of_fleet() -> bytes:
        summary = summed_up(Results.open(folder), by="supplier")
        return write_summary_pdf(replace(summary, folder=folder.name))

    yield "report-page-1", of_report
    yield "compare-page", of_comparison
    yield "fleet-page", of_fleet


def first_page(pdf: bytes) -> Image.Image:
    """Return the first page of a report as a picture."""
    page = pypdfium2.PdfDocument(pdf)[0]
    return page.render(scale=PAGE_WIDTH / page.get_width()).to_pil().convert("RGB")


# --- the dashboard and the browser


@contextmanager
def served(folder: Path, with_fleet: bool) -> Iterator[Dashboard]:
    """Start a dashboard whose job book and fleet hold samples alone; end it by its own process group."""
    home, elsewhere = folder / "home", folder / "elsewhere"
    elsewhere.mkdir()
    with made.user_folder(home):
        jobs, fleet_folder = made.fill_book(), folder / made.FLEET
        if with_fleet:
            made.make_fleet(folder)
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        port = listener.getsockname()[1]
    environment = {**os.environ, "ATLEAK_HOME": str(home), "NO_PROXY": "127.0.0.1", "STREAMLIT_SERVER_HEADLESS": "true"}
    command = [sys.executable, "-m", "atleak", "app", "--port", str(port)]
    with (folder / "server.log").open("ab") as log:
        process = subprocess.Popen(
            command, cwd=elsewhere, env=environment, stdout=log, stderr=subprocess.STDOUT, start_new_session=True
        )
    try:
        _wait(f"http://127.0.0.1:{port}/_stcore/health", process, folder / "server.log")
        yield Dashboard(f"http://127.0.0.1:{port}", jobs, fleet_folder)
    finally:
        if os.name == "nt":
            subprocess.run(["taskkill", "/T", "/F", "/PID", str(process.pid)], capture_output=True, check=False)
        else:
            os.killpg(process.pid, signal.SIGTERM)
        process.wait(timeout=20)


def _wait(address: str, process: subprocess.Popen[bytes], log: Path) -> None:
    limit = time.monotonic() + START
    while time.monotonic() < limit and process.poll() is None:
        try:
            with urllib.request.urlopen(address, timeout=2) as answer:
                if answer.status == 200:
                    return
        except OSError:
            time.sleep(0.2)
    raise SystemExit(f"the dashboard did not answer: {log.read_text(encoding='utf-8', errors='replace')[-2000:]}")


# --- pictures kept and compared


def written(picture: Image.Image) -> bytes:
    """Return a picture as a small PNG: its colours drawn together to as many as the eye tells apart in it."""
    target = io.BytesIO()
    few = picture.quantize(COLOURS, method=Image.Quantize.MAXCOVERAGE, kmeans=4, dither=Image.Dither.NONE)
    few.save(target, "PNG", optimize=True)
    return target.getvalue()


def difference(now: Image.Image, kept: Image.Image) -> str:
    """Say in which way a picture differs clearly from the one that is kept; nothing where it does not."""
    for name, new, old in zip(("width", "height"), now.size, kept.size, strict=True):
        if abs(new - old) > SIZE_APART * old:
            return f"its {name} is {new} px, that of the one kept {old} px"
    size = SEEN_AT, round(SEEN_AT * kept.height / kept.width)
    small = [each.convert("RGB").resize(size, Image.Resampling.BOX).convert("L") for each in (now, kept)]
    apart = ImageChops.difference(*small)
    mean, shades = ImageStat.Stat(apart).mean[0], apart.histogram()
    dots = sum(shades[DOT_APART:]) / sum(shades)
    if mean > MEAN_APART or dots > DOTS_APART:
        return f"it differs by {mean:.1f} of 255 shades, and {dots:.1%} of it by more than {DOT_APART}"
    return ""


def make(names: set[str], target: Path) -> dict[str, str]:
    """Make the pictures of these names in a folder; return by name why some cannot be made."""
    faults = {}
    with_fleet = any(name.startswith("fleet") for name in names)
    with (
        tempfile.TemporaryDirectory() as folder,
        served(Path(folder), with_fleet) as dashboard,
        sync_playwright() as driver,
    ):
        executable = next((path for path in CHROMIUM if Path(path).is_file()), shutil.which("chromium"))
        browser = driver.chromium.launch(executable_path=executable, args=["--no-sandbox"])
        of_pages = {name: lambda shot=shot: taken(browser, dashboard, shot) for name, shot in SHOTS.items()}
        of_reports = {name: lambda pdf=pdf: first_page(pdf()) for name, pdf in report_pages(dashboard.folder)}
        for name, picture in (of_pages | of_reports).items():
            if name not in names:
                continue
            try:
                content = written(picture())
            except (Error, AssertionError) as error:
                faults[name] = f"it cannot be made: {str(error).splitlines()[0]}"
                continue
            if len(content) > LARGEST:
                faults[name] = f"it has {len(content)} bytes, where {LARGEST} are allowed"
            (target / f"{name}.png").write_bytes(content)
            print(f"{name}.png", f"{len(content) / 1000:.0f} kB", flush=True)
        browser.close()
    return faults


def check(names: set[str]) -> dict[str, str]:
    """Make pictures anew; return by name what is wrong with those that are kept."""
    with tempfile.TemporaryDirectory() as folder:
        faults = make(names, Path(folder))
        for name in names - faults.keys():
            kept = PICTURES / f"{name}.png"
            if not kept.is_file():
                faults[name] = "it is not kept"
                continue
            with Image.open(Path(folder) / kept.name) as new, Image.open(kept) as old:
                if said := difference(new, old):
                    faults[name] = said
    return faults


NAMES = (*SHOTS, "report-page-1", "compare-page", "fleet-page")


def main() -> int:
    """Make the pictures, or check those that are kept."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--only", metavar="NAME", action="append", choices=NAMES, help="one of the pictures")
    parser.add_argument("--check", action="store_true", help="compare with those that are kept, and write none")
    options = parser.parse_args()
    names = set(options.only or NAMES)
    if options.check:
        faults = check(names)
    else:
        PICTURES.mkdir(parents=True, exist_ok=True)
        faults = make(names, PICTURES)
    for name, said in faults.items():
        print(f"{name}.png: {said}", file=sys.stderr)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
