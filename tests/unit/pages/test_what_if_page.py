"""What is tried in the part What if of the page Plan never reaches the job, and one button takes it back."""

from __future__ import annotations

import pytest
from streamlit.testing.v1 import AppTest

from pages.shared.what_if import read_tried
from tests.unit.pages.conftest import go, texts


def share(app: AppTest) -> str:
    return app.metric[0].value


def slider(app: AppTest, label: str):
    return next(widget for widget in app.main.slider if widget.label.startswith(label))


def field(app: AppTest, label: str):
    return next(widget for widget in app.main.text_input if widget.label.startswith(label))


def reset(app: AppTest) -> AppTest:
    return next(button for button in app.main.button if button.label.startswith("Back to")).click().run()


@pytest.mark.page("5_Plan?plan=what_if")
def test_what_is_tried_stays_until_it_is_reset_and_leaves_the_job_alone(app: AppTest) -> None:
    job = share(app)
    assert "Nothing is changed yet" in texts(app)
    slider(app, "Wear").set_value(2.0).run()
    field(app, "Temperature").set_value("101,5").run()
    tried = share(app)
    assert not app.exception
    assert tried != job
    assert "Tried: 101.5 °C" in texts(app).replace("\u00a0", " ")
    assert app.main.dataframe[0].value["At"].str.startswith("80").iloc[0]
    go(app, "4_Diagnosis")
    switch = app.main.toggle[0].label  # what its repair does to the total
    assert job in switch
    assert tried not in switch + texts(app)
    go(app, "5_Plan?plan=what_if")
    assert (share(app), slider(app, "Wear").value, field(app, "Temperature").value) == (tried, 2.0, "101,5")
    reset(app)
    assert (share(app), slider(app, "Wear").value, field(app, "Temperature").value) == (job, 1.0, "80")


@pytest.mark.page("5_Plan?plan=what_if")
def test_a_temperature_outside_the_fluid_s_data_is_said_and_the_maps_stay(app: AppTest) -> None:
    field(app, "Temperature").set_value("160").run()
    assert not app.exception
    assert "160 °C is outside the fluid's data" in "\n".join(error.value for error in app.main.error)
    assert not app.metric
    assert "Computed at 31 temperatures" in texts(app)


@pytest.mark.page("5_Plan?plan=what_if")
def test_what_is_tried_stands_in_the_address_and_comes_back_from_it(app: AppTest) -> None:
    slider(app, "Wear").set_value(2.0).run()
    field(app, "Temperature").set_value("101,5").run()
    tried = share(app)
    assert app.query_params["tried"] == "temperature:101.5;wear:2.0"
    for kept in ("in-address", "taken-numbers"):  # the page loaded anew
        del app.session_state[kept]
    app.session_state["what-if-resets"] = 1
    app.query_params["tried"] = "temperature:101.5;wear:2.0;growth:9999;gear:x;nothing:1"
    app.run()
    assert not app.exception
    assert (share(app), slider(app, "Wear").value, field(app, "Temperature").value) == (tried, 2.0, "101.5")
    reset(app)
    assert "tried" not in app.query_params


def test_an_address_written_by_hand_tries_only_what_can_be_tried() -> None:
    assert read_tried("wear:2.0;gear:3;position:unknown;state:used") == {
        "wear": 2.0, "gear": 3, "position": "unknown", "state": "used"
    }  # fmt: skip
    numbers = ("wear:unknown", "wear:9", "growth:-1", "temperature:unknown", "temperature:9999", "speed:-5", "gear:")
    for wrong in (*numbers, "x:1"):
        assert read_tried(wrong) == {}, wrong
