"""The dashboard's pages, and every part of them, run in Streamlit's own test harness."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest
from streamlit.testing.v1 import AppTest

from pages.shared import places
from tests.unit.pages.conftest import PARTS, ROOT, choice, columns_of, go, part_shown, press, texts, uploader

PAGES = sorted(ROOT.joinpath("pages").glob("[0-9]*_*.py"))
OF_A_JOB = ("1_Job", "2_Measure", "3_In_the_car", "4_Diagnosis", "5_Plan", "6_Report")
GAUGES = b"range;condition;pressure [kPa]\nP;slow idle;400\nD;slow idle;450\n"


def walk(app: AppTest, pages: tuple[str, ...] = tuple(path.stem for path in PAGES)) -> Iterator[str]:
    """Go to every page, with each of its parts open in turn."""
    for page in pages:
        name = page.partition("_")[2].lower()
        for part in PARTS.get(page, (None,)):
            place = page if part is None else f"{page}?{name}={part}"
            go(app, place)
            assert not app.exception, place
            if part != "":  # of a job without a sheet a part is open from the start
                assert part_shown(app) == (None if part is None else f"{name}={part}"), place
            yield place


@pytest.mark.page("1_Job")
def test_every_page_and_part_runs_with_the_sample_and_with_nothing(app: AppTest) -> None:
    for place in walk(app):
        assert not app.error or place.startswith("4_Diagnosis"), place
        parts = next((each for each in app.get("button_group") if (each.key or "").startswith("part-of-")), None)
        listed = [name for name in PARTS.get(place.partition("?")[0], ()) if name]
        assert len(listed) == (len(parts.options) if parts else 0), "PARTS names every part"
    choice(app, "Valve body").select("minimal_example").run()
    for place in walk(app):
        assert not called_good(app), place
        assert not app.error, place


def step(app: AppTest) -> str:
    """What the navigation says of the diagnosis."""
    (label,) = [each.proto.label for each in app.get("page_link") if each.proto.label.startswith("Diagnosis ·")]
    return label


def called_good(app: AppTest) -> bool:
    """Tell whether a page says that the unit is good: at its head, in its texts, or on the way to the diagnosis."""
    return "green" in texts(app) or step(app).endswith("ok")


@pytest.mark.page("1_Job")
@pytest.mark.parametrize("job", ["empty", "gauges", "log", "log without main pressure"])
def test_a_unit_that_was_not_measured_is_nowhere_called_good(app: AppTest, sample_log: Path, job: str) -> None:
    press(app, "New, empty job")
    if job == "gauges":
        uploader(app).upload("gauges.csv", GAUGES, "text/csv").run()
        assert app.session_state["atleak"].good.pressures is not None
    elif job != "empty":
        kept = 6 if job == "log" else 2
        uploader(app).upload("alone.csv", columns_of(sample_log, kept), "text/csv").run()
        assert app.session_state["atleak"].good.road_test is not None
    assert ("ok so far" in step(app)) == (job in ("gauges", "log"))
    for place in walk(app, OF_A_JOB):
        assert not called_good(app), place
        assert not app.success or (place, job) == ("3_In_the_car", "gauges"), place  # of what the gauges show
        assert not app.error, place


def test_an_address_of_before_leads_to_the_page_and_part_of_today() -> None:
    assert places.moved("Readings", "") == "Measure"
    assert places.moved("Gauge_study", "job=1&own=a") == "Library?library=gauge_study&job=1&own=a"
    for now in places.MOVED.values():
        page, _, part = now.partition("?")
        assert places.name_of(places.page(page)) == page
        assert part.partition("=")[2] in ("", *PARTS.get(places.page(page).stem, ())), now


@pytest.mark.page("1_Job")
def test_a_fault_of_atleak_is_a_message_on_its_page(app: AppTest, monkeypatch: pytest.MonkeyPatch) -> None:
    def fault(*_: object, **__: object) -> None:
        raise ValueError("index values must not have NaT")

    monkeypatch.delenv("ATLEAK_TRACEBACK")
    for page, breaks in {
        "3_In_the_car": "pages.shared.road.findings",
        "4_Diagnosis": "pages.shared.answer.draw",
        "5_Plan?plan=what_if": "pages.shared.what_if._settings",
        "6_Report": "pages.shared.conditions.undecided",
    }.items():
        with monkeypatch.context() as broken:
            broken.setattr(breaks, fault)
            go(app, page)
        assert not app.exception
        assert app.error[-1].value.startswith("unexpected ValueError")
        assert "index values must not have NaT. This is a fault of atleak" in app.error[-1].value
    go(app, "1_Job")
    assert not app.error


def test_every_page_has_a_number_of_its_own() -> None:
    assert len({int(path.stem.partition("_")[0]) for path in PAGES}) == len(PAGES)
    assert {path.stem for path in places.STEPS} == set(OF_A_JOB)


def test_pages_are_short_and_compute_nothing() -> None:
    for path in PAGES:
        text = path.read_text(encoding="utf-8")
        functions = [each for each in ast.parse(text).body if isinstance(each, ast.FunctionDef)]
        lengths = [each.end_lineno - each.lineno + 1 for each in functions]
        assert max(lengths, default=0) <= 40, path.name
        assert len(text.splitlines()) - sum(lengths) <= 80, path.name
        assert "numpy" not in text, path.name
        assert "open(" not in text, path.name


def test_no_page_has_a_number_field_of_another_kind() -> None:
    for path in (ROOT / "pages").rglob("*.py"):
        text = path.read_text(encoding="utf-8")
        assert "number_input" not in text, path.name
        assert "data_editor" not in text or "NumberColumn" not in text, path.name  # a table that is only read may
