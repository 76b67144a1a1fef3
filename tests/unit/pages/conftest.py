"""The dashboard in Streamlit's own test harness, and how its widgets are reached there."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree

import pytest
from streamlit.components.v2 import manifest_scanner
from streamlit.testing.v1 import AppTest

from atleak.common import memory
from pages.shared import book

ROOT = Path(__file__).resolve().parents[3]
PARTS = {  # of the pages that have some, as their addresses name them; a diagnosis is shown with none open, too
    "4_Diagnosis": ("", "pressures", "lands", "log", "remarks"),
    "5_Plan": ("repairs", "what_if"),
    "11_History": ("unit", "compare"),
    "20_Library": ("catalogue", "transmission", "workshop_data", "gauge_study"),
}
XLSX = "application/vnd.openxmlformats-officedocument.spreadsheetml.sheet"


@pytest.fixture(scope="session", autouse=True)
def components_looked_for_once() -> Iterator[None]:
    """Look through the installed packages for components of Streamlit once, not for every test: none is used here."""
    found = manifest_scanner.scan_component_manifests()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(manifest_scanner, "scan_component_manifests", lambda: found)
        yield


@pytest.fixture(scope="session", autouse=True)
def no_collection_after_a_visit() -> Iterator[None]:
    """Let no page ask for a look through all objects some seconds later: it is tested with ``common/memory.py``."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(memory, "_collect", lambda: None)
        yield


@pytest.fixture(autouse=True)
def nothing_saved(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Let no change be saved to the job book, which takes as long as a change itself, but where a test marks that."""
    if request.node.get_closest_marker("saved") is None:
        monkeypatch.setattr(book, "_save", lambda *_: None)


@pytest.fixture
def app(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[AppTest]:
    """The dashboard, run once: on the page that the test's mark names, else on the diagnosis.

    The diagnosis is the page that takes longest: a test of what every page has starts on a quicker one.
    """
    mark = request.node.get_closest_marker("page")
    yield from opened(tmp_path, *(mark.args if mark else ("4_Diagnosis",)))


def opened(folder: Path, page: str, language: str = "en") -> Iterator[AppTest]:
    """Open the dashboard on a page, with the user's folder in another one, until the fixture that yields from it ends.

    The harness cannot go from one language to another: it looks for what is chosen among the choices of before.

    The harness takes a main script beside a ``pages`` folder for an app without `st.navigation`, so it is given one
    that stands elsewhere and runs ``app.py``.
    """
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(ROOT))
        patch.setenv("ATLEAK_HOME", str(folder / "home"))
        patch.setenv("ATLEAK_TRACEBACK", "1")  # a fault of a page ends its test
        patch.setenv("ATLEAK_ALLOWED", "")  # as on one machine alone, wherever the tests are started
        main = folder / "main.py"
        main.write_text(f"import runpy\nrunpy.run_path({str(ROOT / 'app.py')!r})\n", encoding="utf-8")
        app = AppTest.from_file(str(main), default_timeout=240)
        app.context["locale"] = language
        app.session_state["reader-cookies"] = {"language": None, "units": None}  # not the harness's mock of a client's
        yield go(app, page)


def go(app: AppTest, page: str) -> AppTest:
    """Go to a page; of ``page?page=part#fold`` that part and that fold are opened, too."""
    address, _, fold = page.partition("#")
    name, _, part = address.partition("?")
    app.switch_page(str(ROOT / "pages" / f"{name}.py"))
    if part:
        app.query_params[part.partition("=")[0]] = part.partition("=")[2]
    app.run()
    return unfold(app, fold) if fold else app


def part(app: AppTest, name: str, page: str = "diagnosis") -> AppTest:
    """Open a part of the page that is shown, as a link to it does; an empty name leaves none open."""
    app.query_params[page] = name
    return app.run()


def part_shown(app: AppTest) -> str | None:
    """The part that is open of the page that is shown: ``diagnosis=lands``; None on a page without parts."""
    groups = [each for each in app.get("button_group") if (each.key or "").startswith("part-of-")]
    return f"{groups[0].key.removeprefix('part-of-')}={groups[0].value or ''}" if groups else None


def texts(app: AppTest) -> str:
    kinds = (*app.markdown, *app.caption, *app.error, *app.warning, *app.info, *app.success, *app.title)
    return "\n".join(widget.value for widget in kinds).replace("\\", "")


SLOTS = {"Measuring sheet": "readings", "Road-test log": "road_test", "Gauge readings": "pressures"}


class InJob:
    """A file of the job: dropped into the panel, which tells by its content what it is, or taken away by its button."""

    def __init__(self, app: AppTest, label: str) -> None:
        self.app, self.label = app, label

    def upload(self, name: str, content: bytes, kind: str) -> AppTest:
        return next(zone for zone in self.app.sidebar.file_uploader).upload(name, content, kind)

    def upload_all(self, files: dict[str, bytes]) -> AppTest:
        zone = next(zone for zone in self.app.sidebar.file_uploader)
        return zone.set_value([(name, content, "") for name, content in files.items()])

    def set_value(self, value: tuple[str, bytes, str] | None):
        if value is not None:
            return self.upload(*value)
        return next(each for each in self.app.button if each.key == f"away-{SLOTS[self.label]}").click()


def uploader(app: AppTest, label: str = "") -> InJob:
    return InJob(app, label)


def settle(app: AppTest, page: str, label: str, value: object) -> AppTest:
    """Make a choice on the page of settings, and come back to a page."""
    go(app, "21_Settings")
    choice(app, label).select(value).run()
    return go(app, page)


def choice(app: AppTest, label: str):
    return next(widget for widget in (*app.sidebar.selectbox, *app.selectbox) if widget.label == label)


def press(app: AppTest, label: str) -> AppTest:
    return next(widget for widget in app.button if widget.label.replace("\\", "") == label).click().run()


def number(app: AppTest, label: str):
    return next(widget for widget in app.sidebar.text_input if widget.label == label)


def tables(app: AppTest) -> list[list[dict[str, str]]]:
    """The tables that are shown as cards on a phone: every row by its headings."""
    mounted = (json.loads(each.proto.json) for each in app.get("bidi_component"))
    trees = [ElementTree.fromstring(f"<page>{each['html']}</page>") for each in mounted if "html" in each]
    return [
        [{cell.get("data-label", ""): "".join(cell.itertext()) for cell in row.iter("td")} for row in table.iter("tr")][
            1:
        ]
        for tree in trees
        for table in tree.iter("table")
        if table.get("class") == "cards"
    ]


def flagged_pairs(app: AppTest) -> list[dict[str, str]]:
    """The rows of the table of flagged pairs, in the part of the diagnosis that shows it; none where there is none."""
    if part_shown(app) != "diagnosis=lands":
        part(app, "lands")
    return next((rows for rows in tables(app) if rows and "Pair" in rows[0]), [])


def flagged(app: AppTest) -> list[str]:
    return [row["Verdict"] for row in flagged_pairs(app)]


def unfold(app: AppTest, name: str) -> AppTest:
    """Open a fold whose content is made when it is opened."""
    app.session_state[f"{name}-{app.session_state['atleak'].generation}"] = True
    return app.run()


def columns_of(log: Path, kept: int) -> bytes:
    """The first columns of a log; of the sample two are its time and engine speed."""
    lines = log.read_text(encoding="utf-8").splitlines()
    return "\n".join(";".join(line.split(";")[:kept]) for line in lines).encode()
