"""The form that learns mounting clearances from measuring sheets."""

from __future__ import annotations

import numpy as np
import pytest
from streamlit.testing.v1 import AppTest

from atleak.catalogue.controller_file import load_controller
from tests.unit.pages.conftest import ROOT, go, texts

NAME = "minimal_example"


def script() -> None:
    import streamlit as st

    from atleak.catalogue.entries import read_tables
    from pages.shared.transmission import learn_form

    taken = learn_form(read_tables("controllers", "minimal_example")[0])
    if taken is not None:
        st.session_state["taken"] = taken


@pytest.fixture
def form(monkeypatch: pytest.MonkeyPatch) -> AppTest:
    monkeypatch.syspath_prepend(str(ROOT))
    return AppTest.from_function(script, default_timeout=120).run()


def sheets(count: int, worn: int | None = None) -> list[tuple[str, bytes, str]]:
    random = np.random.default_rng(2)
    files = []
    for number in range(count):
        rows = ["component,part,plane,diameter [mm]"]
        for land in load_controller(NAME).lands:
            new = 15e-6 + (20e-6 if number == worn else 0.0) + random.normal(0.0, 1e-6)
            for part, diameter in (("spool", land.nominal_diameter), ("sleeve", land.nominal_diameter + 2.0 * new)):
                rows.append(f"{land.component},{part},{land.planes[0]},{diameter * 1e3 + random.normal(0.0, 5e-4):.4f}")
        files.append((f"unit_{number}.csv", "\n".join(rows).encode(), "text/csv"))
    return files


def test_sheets_become_clearances_that_are_taken_over(form: AppTest) -> None:
    assert not form.exception
    assert not form.button
    form.file_uploader[0].set_value(sheets(6, worn=2)).run()
    assert not form.exception
    assert "from 5 units" in texts(form)
    assert any("unit_2.csv is left out as a whole" in each.value.replace("\\", "") for each in form.warning)
    rows = form.dataframe[0].value
    assert len(rows) == len(load_controller(NAME).lands)
    assert (rows["Units"] == 5).all()
    assert "taken" not in form.session_state
    form.button[0].click().run()
    lands = [land for each in form.session_state["taken"]["components"] for land in each.get("lands", [])]
    assert {land["learned_from_units"] for land in lands} == {5}


def test_a_sheet_that_cannot_be_used_is_named(form: AppTest) -> None:
    form.file_uploader[0].set_value(
        [*sheets(2), ("other.csv", b"component,part,plane,diameter [mm]\n9,spool,1,8\n", "")]
    )
    form.run()
    assert not form.exception
    assert "other.csv" in texts(form)
    assert not form.button


def step(app: AppTest, name: str) -> None:
    next(group for group in app.button_group if "step" in group.key).set_value(name).run()


def test_the_page_takes_them_over_into_its_tables(app: AppTest) -> None:
    go(app, "20_Library?library=transmission")
    next(box for box in app.selectbox if box.label == "Start from").select(NAME).run()
    next(button for button in app.button if button.label == "Start").click().run()
    step(app, "New parts")
    uploader = next(each for each in app.main.file_uploader if each.label.startswith("Measuring sheets"))
    uploader.set_value(sheets(3)).run()
    assert not app.exception
    next(button for button in app.button if button.label == "Take these over").click().run()
    assert not app.exception
    assert "Nothing is missing or wrong." in texts(app)
    assert not next(each for each in app.main.file_uploader if each.label.startswith("Measuring sheets")).value
    step(app, "Head")
    assert "were learned on" in next(field for field in app.text_input if field.label == "Note").value
