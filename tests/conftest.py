"""What every kind of test shares: the catalogue's objects and the sample job."""

from __future__ import annotations

import gc
import importlib
import io
import os
import shutil
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Callable, Generator, Iterator
from pathlib import Path
from typing import Any

# Two threads of one small product of matrices wait for each other longer than they compute.
os.environ["OPENBLAS_NUM_THREADS"] = os.environ["OMP_NUM_THREADS"] = "1"

import openpyxl
import pytest
from hypothesis import settings
from openpyxl.utils.cell import coordinate_to_tuple
from python_calamine import CalamineWorkbook

from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.fluid import Fluid, load_fluid
from atleak.catalogue.limits import Limits, load_limits
from atleak.catalogue.operating_point import HOT_IDLE, OperatingPoint
from atleak.diagnosis.uncertainty import weighing
from atleak.diagnosis.uncertainty.propagation import DRAWS, DRAWS_OF_CIRCUITS

ROOT = Path(__file__).resolve().parents[1]

# No deadline: how long an example takes says more about the machine than about the code. The README's round tries the
# same examples everywhere, so that it fails for what was changed; continuous integration tries as many others (the
# thorough profile, with a seed). --hypothesis-profile=search looks for new ones at every run; what it finds becomes an
# @example.
settings.register_profile("quick", deadline=None, max_examples=20, derandomize=True)
settings.register_profile("thorough", deadline=None, max_examples=20, database=None)
settings.register_profile("few", deadline=None, max_examples=2, derandomize=True)  # a lowest version: is the call there
settings.register_profile("search", deadline=None, max_examples=1000)
settings.load_profile("quick")

# A machine without a browser or an office program skips the tests that need one. Where everything is installed, as in
# continuous integration, a skip is a failure.
NOTHING_MAY_SKIP = bool(os.environ.get("ATLEAK_NOTHING_MAY_SKIP"))

# No test reads or writes what belongs to the user of this machine. Set before any test is collected, as some are made
# from the catalogue's entries.
_HOME = tempfile.TemporaryDirectory(prefix="atleak-tests-")
os.environ["ATLEAK_HOME"] = _HOME.name

# Where Python is told to keep no compiled modules, every process that a test starts would compile all of them anew.
_COMPILED = tempfile.TemporaryDirectory(prefix="atleak-tests-compiled-")
if os.environ.pop("PYTHONDONTWRITEBYTECODE", ""):
    os.environ["PYTHONPYCACHEPREFIX"] = _COMPILED.name

# What is left out of the quick round.
WHOLE = (
    "e2e", "unit/cli", "unit/pages", "unit/report", "unit/readers/process", "unit/test_rounds.py",
    *(f"unit/common/test_{name}.py" for name in ("files", "marks", "verdicts")),
)  # fmt: skip

# A page that is tested leaves itself behind as the main module, which every process that a later test spawns would run.
_MAIN = sys.modules["__main__"]

# What is set in every language is set in English each time, a few things in Polish too, and all of it in every language
# in the longer round.
IN_POLISH_TOO = (
    "test_every_language_is_archival_and_says_its_words",
    "test_a_sheet_of_any_language_and_units_is_read_back_as_the_same",
    "test_the_first_page_says_what_is_wrong_how_bad_it_is_and_what_to_do",
)

# The job book's own tests run on both databases each time, those of what is built on it on PostgreSQL in the longer
# round.
ON_POSTGRESQL = ("test_book.py", "test_erase.py", "test_safety.py")


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--first-case", action="store_true", help="of a test with parameters only the first case")


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Function]) -> None:
    if config.getoption("first_case"):
        cases = {item.nodeid.partition("[")[0]: item for item in reversed(items) if not item.get_closest_marker("slow")}
        first = set(cases.values())
        config.hook.pytest_deselected(items=[item for item in items if item not in first])
        items[:] = [item for item in items if item in first]
    folders = [ROOT / "tests" / name for name in WHOLE]
    whole = {path: any(path.is_relative_to(folder) for folder in folders) for path in {item.path for item in items}}
    for item in items:
        chosen = getattr(item, "callspec", None)  # of a test with parameters
        given = {} if chosen is None else chosen.params
        if whole[item.path]:
            item.add_marker("whole")
            language = given.get("language", "en")
            if language != "en" and not (language == "pl" and item.originalname in IN_POLISH_TOO):
                item.add_marker("slow")
        if given.get("database") == "postgresql" and item.path.name not in ON_POSTGRESQL:
            item.add_marker("slow")


def pytest_collection_finish() -> None:
    """Let later collections of garbage be rarer, and pass over the tests themselves and what was imported for them."""
    gc.collect()
    gc.freeze()
    gc.set_threshold(50_000, 20, 20)


def pytest_unconfigure() -> None:
    _HOME.cleanup()
    _COMPILED.cleanup()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport() -> Generator[None, pytest.TestReport, pytest.TestReport]:
    report = yield
    if NOTHING_MAY_SKIP and report.skipped:
        report.outcome = "failed"
        report.longrepr = f"skipped where nothing may skip: {report.longrepr}"
    return report


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report() -> Generator[None, pytest.CollectReport, pytest.CollectReport]:
    report = yield
    if NOTHING_MAY_SKIP and report.skipped:
        report.outcome = "failed"
        report.longrepr = f"skipped where nothing may skip: {report.longrepr}"
    return report


FEW_DRAWS, FEW_DRAWS_OF_GAUGED = 1_024, 2_048
_DRAWS_OF_GAUGED = weighing.DRAWS


def drawing(draws: int, of_circuits: int, of_gauged: int) -> Iterator[None]:
    """Let a diagnosis draw so many times, until the fixture that yields from this ends."""
    module = importlib.import_module(
        "atleak.diagnosis.uncertainty.assess"
    )  # the package's name for it is the function in it
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "DRAWS", draws)
        patch.setattr(module, "DRAWS_OF_CIRCUITS", of_circuits)
        patch.setattr(weighing, "DRAWS", of_gauged)
        yield


def pytest_runtest_setup() -> None:
    sys.modules["__main__"] = _MAIN


@pytest.fixture(scope="session", autouse=True)
def few_draws() -> Iterator[None]:
    """Let a diagnosis draw less often than it does for users: half of its time goes into its draws.

    What a test says of intervals and probabilities must hold all the same; where digits count, it asks for `all_draws`.
    """
    yield from drawing(FEW_DRAWS, FEW_DRAWS, FEW_DRAWS_OF_GAUGED)


@pytest.fixture(scope="module")
def all_draws() -> Iterator[None]:
    """Let a diagnosis draw as often as it does for users, in all tests of one file."""
    yield from drawing(DRAWS, DRAWS_OF_CIRCUITS, _DRAWS_OF_GAUGED)


@pytest.fixture(scope="session")
def root() -> Path:
    """The root of the checkout."""
    return ROOT


@pytest.fixture
def own_home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The user's folder, empty and of this test alone."""
    folder = tmp_path / "home"
    monkeypatch.setenv("ATLEAK_HOME", str(folder))
    return folder


@pytest.fixture(scope="session")
def sample_readings() -> Path:
    return ROOT / "sample_data" / "measuring_sheet_four_speed.xlsx"


@pytest.fixture(scope="session")
def sample_log() -> Path:
    return ROOT / "sample_data" / "minimum_acceleration_test.csv"


@pytest.fixture(scope="session")
def four_speed() -> Controller:
    return load_controller("four_speed_2023")


@pytest.fixture(scope="session")
def hot_idle(four_speed: Controller) -> OperatingPoint:
    return next(point for point in four_speed.operating_points if point.name == HOT_IDLE)


@pytest.fixture(scope="session")
def minimal() -> Controller:
    return load_controller("minimal_example")


@pytest.fixture(scope="session")
def three_circuits() -> Controller:
    """A small valve body with every kind of circuit, leak and consumer."""
    return load_controller(ROOT / "tests" / "three_circuits.toml")


@pytest.fixture(scope="session")
def hipol() -> Fluid:
    return load_fluid("hipol_atf_iid")


@pytest.fixture(scope="session")
def limits() -> Limits:
    return load_limits("project_default")


_XLSX = {
    "[Content_Types].xml": '<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">'
    '<Default Extension="xml" ContentType="application/xml"/></Types>',
    "_rels/.rels": '<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships"><Relationship '
    'Id="rId1" Type="http://schemas.openxmlformats.org/officeDocument/2006/relationships/officeDocument" '
    'Target="xl/workbook.xml"/></Relationships>',
    "xl/workbook.xml": '<workbook xmlns="http://schemas.openxmlformats.org/spreadsheetml/2006/main" xmlns:r="http://'
    'schemas.openxmlformats.org/officeDocument/2006/relationships"><sheets><sheet name="Sheet" sheetId="1" '
    'r:id="rId1"/></sheets></workbook>',
    "xl/_rels/workbook.xml.rels": '<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">'
    '<Relationship Id="rId1" Type="http://schemas.openxmlformats.org/officeDocument/2006/relationships/worksheet" '
    'Target="worksheets/sheet1.xml"/></Relationships>',
}


@pytest.fixture(scope="session")
def bare_workbook() -> Callable[..., bytes]:
    """An xlsx of one sheet, given as the XML that stands in it; ``parts`` replaces or adds parts of the workbook."""

    def build(inside: str | bytes, parts: dict[str, str] | None = None) -> bytes:
        stream = io.BytesIO()
        with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
            for name, text in (_XLSX | (parts or {})).items():
                archive.writestr(name, text)
            inside = inside.encode() if isinstance(inside, str) else inside
            start = b'<worksheet xmlns="http://schemas.openxmlformats.org/spreadsheetml/2006/main">'
            archive.writestr("xl/worksheets/sheet1.xml", start + inside + b"</worksheet>")
        return stream.getvalue()

    return build


@pytest.fixture(scope="session")
def stray_workbook(bare_workbook: Callable[..., bytes]) -> bytes:
    """An xlsx of which one cell stands in the last corner, its place between single quotes."""
    return bare_workbook("<sheetData><row r='1'><c r='A1'><v>1</v></c><c r='XFD1048576'><v>1</v></c></row></sheetData>")


@pytest.fixture(scope="session")
def convert(tmp_path_factory: pytest.TempPathFactory) -> Callable[[Path, str], None]:
    """LibreOffice, writing a workbook anew beside itself; its profile, which takes it longest, is made once."""
    soffice = shutil.which("soffice") or shutil.which("libreoffice")
    if soffice is None:
        pytest.skip("LibreOffice is not installed; other tests check the same cells")
    profile = tmp_path_factory.mktemp("office").as_uri()

    def run(workbook: Path, kind: str) -> None:
        command = [soffice, f"-env:UserInstallation={profile}", "--headless", "--convert-to", kind]
        subprocess.run([*command, "--outdir", workbook.parent, workbook], check=True, capture_output=True, timeout=600)

    return run


@pytest.fixture
def recalculated(tmp_path, convert) -> Callable[[openpyxl.Workbook], Callable[[str, str], Any]]:
    """LibreOffice again: it gets formulas without cached values, and says what each cell gives."""

    def run(book):
        book.save(tmp_path / "in.xlsx")  # openpyxl writes no cached values
        convert(tmp_path / "in.xlsx", "ods")
        sheets = CalamineWorkbook.from_path(tmp_path / "in.ods")
        rows = {name: sheets.get_sheet_by_name(name).to_python(skip_empty_area=False) for name in sheets.sheet_names}

        def value(sheet, address):
            row, column = coordinate_to_tuple(address)
            return rows[sheet][row - 1][column - 1]

        return value

    return run
