"""What the grid sends is put into the job, once; a browser stands in for itself here, as far as the server sees it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from streamlit.testing.v1 import AppTest

from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import load_controller
from atleak.common.wording import wording
from atleak.job.case import SourceFile
from atleak.readers.sheets.measuring_sheet import read_readings
from tests.unit.pages.conftest import ROOT

SCRIPT = """
import streamlit as st
from pages.shared import measuring_form
from pages.shared.cases import PageCase, diagnosis_of
from pages.shared.state import current_diagnosis, session

def browser(*, key, data, on_batch_change):
    st.session_state["seen"] = data
    if (batch := st.session_state.pop("sent", None)) is not None:
        st.session_state[key] = {"batch": batch}
        on_batch_change()
    if (unit := st.session_state.pop("chosen", None)) is not None:
        measuring_form._choose(measuring_form._typed(session().case).in_unit(unit))

measuring_form._GRID = browser
if st.session_state.setdefault("first", START) is not None:
    now = session()
    now.case, st.session_state["first"] = st.session_state["first"], None
current_diagnosis()
measuring_form.draw(session().good, diagnosis_of(session().good))
"""
FIRST = ["pressure_regulator", "spool", "1", 0, 1]
SECOND = ["pressure_regulator", "spool", "1", 0, 2]
Opened = Callable[[str], AppTest]


@pytest.fixture
def opened(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Opened:
    """Draws the grid of a job, given as the Python that makes it."""
    monkeypatch.syspath_prepend(str(ROOT))
    monkeypatch.setenv("ATLEAK_HOME", str(tmp_path / "home"))

    def draw(start: str) -> AppTest:
        script = tmp_path / "grid.py"
        script.write_text(f"from atleak.job.case import SourceFile\n{SCRIPT.replace('START', start)}", encoding="utf-8")
        drawn = AppTest.from_file(str(script), default_timeout=240).run()
        assert not drawn.exception
        return drawn

    return draw


def send(app: AppTest, number: int, *steps: dict[str, Any], page: str = "a") -> AppTest:
    numbered = [{**step, "number": number + later} for later, step in enumerate(steps)]
    app.session_state["sent"] = {"page": page, "steps": numbered, "again": 0}
    app.run()
    assert not app.exception
    return app.run()  # as the browser's message starts another run


def shown(app: AppTest) -> dict[tuple, str]:
    return {tuple(cell["key"]): cell["text"] for cell in app.session_state["seen"]["cells"] if cell["text"]}


def sheet_of(app: AppTest) -> SourceFile | None:
    return app.session_state["atleak"].good.readings


def put(cell: list, text: str) -> dict[str, Any]:
    return {"do": "put", "cell": cell, "text": text}


def test_what_was_typed_is_the_jobs_measuring_sheet(opened: Opened, minimal: Controller) -> None:
    app = opened("PageCase(controller='minimal_example')")
    assert (shown(app), sheet_of(app)) == ({}, None)
    how_much(app).set_value("whole").run()
    send(app, 1, put(FIRST, "15,001"), put(SECOND, "150,02"))
    assert shown(app) == {tuple(FIRST): "15,001", tuple(SECOND): "150,02"}
    assert app.session_state["seen"]["answer"] == {"page": "a", "number": 2, "at": None}
    readings = read_readings(sheet_of(app).content, minimal, name="typed.csv")
    assert [reading.diameter for reading in readings.readings] == [pytest.approx(15.001e-3, abs=1e-9)]
    doubts = {tuple(cell["key"]): cell["counts"] for cell in app.session_state["seen"]["cells"] if cell["doubt"]}
    assert doubts == {tuple(SECOND): False}
    send(app, 2, {"do": "undo"})  # the same number: sent again before the answer arrived
    assert len(shown(app)) == 2
    send(app, 2, put(SECOND, "1"), {"do": "undo"})  # the second of these is new
    assert shown(app) == {tuple(FIRST): "15,001"}
    send(app, 1, {"do": "undo"}, page="b")  # the page was loaded anew
    assert (shown(app), sheet_of(app)) == ({}, None)


def test_a_plan_that_changes_keeps_what_was_typed(opened: Opened) -> None:
    app = opened("PageCase(controller='minimal_example')")
    send(app, 1, put(FIRST, "15,001"), put(SECOND, "15,002"))  # the second is none of the quick pass
    repeats = next(widget for widget in app.selectbox if widget.label == "Repeats")
    repeats.set_value(1).run()
    assert not app.exception
    cells = app.session_state["seen"]["cells"]
    assert len(cells) == 20 + 1  # the second repeat that was measured stays
    assert len(shown(app)) == 2
    unit = next(widget for widget in app.selectbox if widget.label == "Unit of what is typed")
    unit.set_value("inch").run()
    assert shown(app)[tuple(FIRST)] == "15,001 mm"


def test_a_sheet_that_was_given_is_gone_on_from_with_its_gauge_readings(opened: Opened, four_speed: Controller) -> None:
    from atleak.measurements.gauge_readings import Engine, GaugeCell, GaugeReading, PressureTable
    from atleak.measurements.readings import Reading
    from atleak.report.sheets.measuring_sheet import write_readings

    one = Reading("8", "spool", "1", 0.0, 1, 10e-3)
    gauges = PressureTable("", "", None, ("kPa",), (GaugeReading(GaugeCell("D", Engine.SLOW_IDLE), 450e3),))
    content = write_readings(four_speed, [one], pressures=gauges)
    app = opened(f"PageCase(controller='four_speed_2023', readings=SourceFile('mine.xlsx', {content!r}))")
    assert shown(app) == {("8", "spool", "1", 0.0, 1): "10"}
    app.session_state["reader-language"] = "de"
    send(app, 1, put(["8", "spool", "1", 0, 2], "10,001"))
    assert shown(app) == {("8", "spool", "1", 0.0, 1): "10", ("8", "spool", "1", 0.0, 2): "10,001"}
    case = app.session_state["atleak"].good
    assert case.readings.name == "typed readings.csv"
    assert b"D;slow idle;line;450;" in case.pressures.content
    before = app.session_state["atleak"].steps.past[-1]
    assert before.case.readings.name == "mine.xlsx"
    assert before.done(wording("de")) == "Messwerte aus mine.xlsx von Hand fortgesetzt"


def test_the_samples_readings_can_only_be_looked_at(opened: Opened) -> None:
    app = opened("None")
    assert app.session_state["seen"]["readonly"]
    assert len(shown(app)) == 376
    before = sheet_of(app)
    send(app, 1, put(["5", "spool", "1", 0, 1], "1"))
    assert sheet_of(app) == before
    assert app.button[0].label == "Begin an empty job"


def test_a_choice_that_is_sent_once_more_leaves_the_sheet_the_file_that_it_is(opened: Opened) -> None:
    app = opened("None")
    before = sheet_of(app)
    for unit, same in (("mm", True), ("inch", False)):
        app.session_state["chosen"] = unit
        app.run().run()
        assert not app.exception
        assert (sheet_of(app) == before) is same


def how_much(app: AppTest) -> Any:
    (widget,) = (each for each in app.button_group if each.label == "How much is measured")
    return widget


def test_the_quick_pass_is_asked_for_first_and_stays_as_it_is_while_it_is_typed(opened: Opened) -> None:
    app = opened("PageCase(controller='minimal_example')")
    assert how_much(app).value == "quick"
    quick, whole = how_much(app).options
    how_much(app).set_value("whole").run()
    assert how_much(app).value == "whole", "though nothing is typed"
    whole_cells = len(app.session_state["seen"]["cells"])
    assert quick.startswith("Quick pass: ")
    assert whole == f"Whole sheet: 5 lands, {whole_cells} readings"
    how_much(app).set_value("quick").run()
    assert not app.exception
    cells = [tuple(cell["key"]) for cell in app.session_state["seen"]["cells"]]
    assert quick == f"Quick pass: {len(cells) // 2} lands, {len(cells)} readings"
    assert len(set(cells)) == len(cells) <= 10 < whole_cells
    strip = [each["name"] for each in app.session_state["seen"]["components"]]
    assert strip == list(dict.fromkeys(component for component, *_ in cells)), "as they are to be measured"
    assert not app.info, "nothing was read yet"
    lands = load_controller("minimal_example").lands_of(cells[0][0])
    new = next(land for land in lands if cells[0][2] in land.planes).nominal_diameter * 1e3
    send(app, 1, put([*cells[0]], f"{new:.3f}".replace(".", ",")))
    assert not app.info, "a land is half read"
    send(app, 2, put([*cells[1]], f"{new + 0.03:.3f}".replace(".", ",")))
    assert [tuple(cell["key"]) for cell in app.session_state["seen"]["cells"]] == cells
    assert "in this order" in app.info[0].value or "No further land" in app.info[0].value
    how_much(app).set_value("whole").run()
    assert len(app.session_state["seen"]["cells"]) == whole_cells
    assert len(shown(app)) == 2, "what was typed stays"


def test_beside_a_sheet_that_holds_every_land_no_quick_pass_is_worked_out(
    opened: Opened, monkeypatch: pytest.MonkeyPatch
) -> None:
    from atleak.diagnosis import evidence

    def never(*_: Any) -> None:
        raise AssertionError

    monkeypatch.setattr(evidence, "readings_by_value", never)
    app = opened("None")
    assert how_much(app).options[0] == "Quick pass", "no number before it is asked for"
