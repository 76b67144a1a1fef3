"""The panel beside every page: condition, mileage, valve body, and another job."""

from __future__ import annotations

from pathlib import Path

import pytest
from streamlit.testing.v1 import AppTest

from tests.unit.pages.conftest import ROOT, XLSX, choice, go, number, press, settle, texts, uploader


@pytest.mark.page("4_Diagnosis?diagnosis=pressures")
def test_choices_and_digits_survive_a_page_change(app: AppTest) -> None:
    number(app, "Temperature [°C]").set_value("92.715").run()
    settle(app, "4_Diagnosis", "Fluid", "mobil_atf_220")
    shown = app.dataframe[0].value
    assert shown["Operating point"].str.contains("92.715").sum() == 1
    go(app, "2_Measure")
    go(app, "4_Diagnosis")
    assert number(app, "Temperature [°C]").value == "92.715"
    assert app.dataframe[0].value.equals(shown)
    go(app, "21_Settings")
    assert choice(app, "Fluid").value == "mobil_atf_220"


@pytest.mark.page("4_Diagnosis?diagnosis=pressures")
def test_a_temperature_outside_the_fluid_keeps_the_last_result(app: AppTest) -> None:
    before = app.dataframe[0].value
    number(app, "Temperature [°C]").set_value("190.0").run()
    assert not app.exception
    assert "cannot be computed" in texts(app)
    assert "190 °C" in texts(app)
    assert app.dataframe[0].value.equals(before)
    number(app, "Temperature [°C]").set_value("95.0").run()
    assert "cannot be computed" not in texts(app)


def doubts(app: AppTest) -> list[str]:
    return [widget.value.replace("\\", "") for widget in (*app.sidebar.error, *app.sidebar.warning)]


@pytest.mark.page("2_Measure")
def test_a_mileage_that_can_be_read_in_two_ways_is_asked_and_the_last_one_stays(app: AppTest) -> None:
    number(app, "Mileage [km]").set_value("106 315").run()
    assert app.session_state["atleak"].good.mileage == 106315.0
    assert doubts(app) == []
    number(app, "Mileage [km]").set_value("123.456").run()
    go(app, "20_Library")
    go(app, "2_Measure")
    assert not app.exception
    assert app.session_state["atleak"].good.mileage == 106315.0
    assert number(app, "Mileage [km]").value == "123.456"
    (doubt,) = doubts(app)
    assert "write 123456 for 123456 km, or 123.4560 for 123.456 km. 106315 km stays in use." in doubt
    number(app, "Mileage [km]").set_value("").run()
    assert app.session_state["atleak"].good.mileage is None
    assert doubts(app) == []


@pytest.mark.page("2_Measure")
def test_a_wrong_entry_leaves_the_result_and_an_unusual_one_says_so(app: AppTest) -> None:
    before = app.session_state["atleak"].good
    for text in ("955", "abc", "", "1e999"):
        number(app, "Temperature [°C]").set_value(text).run()
        assert not app.exception
        assert len(doubts(app)) == 1
        assert "80 °C stays in use" in doubts(app)[0]
        assert app.session_state["atleak"].good == before
    number(app, "Temperature [°C]").set_value("80").run()
    number(app, "Engine speed [rpm]").set_value("8505").run()
    assert app.session_state["atleak"].good.engine_speed * 60.0 == pytest.approx(8505.0, abs=1e-6)
    assert "8505 rpm is taken, but unusual" in doubts(app)[0]


@pytest.mark.page("1_Job")
@pytest.mark.parametrize("label", ["New, empty job", "Take the sample job"])
def test_another_job_has_an_empty_record(app: AppTest, sample_readings: Path, label: str) -> None:
    settle(app, "1_Job", "Fluid", "mobil_atf_220")
    uploader(app, "Measuring sheet").upload("mine.xlsx", sample_readings.read_bytes(), XLSX).run()
    number(app, "Mileage [km]").set_value("120000.0").run()
    next(widget for widget in app.text_input if widget.label == "Technician").set_value("T. Old").run()
    assert app.session_state["job-record"].technician == "T. Old"
    press(app, label)
    assert not app.exception
    assert next(widget for widget in app.text_input if widget.label == "Technician").value == ""
    assert app.session_state["job-record"].empty
    assert number(app, "Mileage [km]").value == ""
    case = app.session_state["atleak"].good
    assert case.sample == (label != "New, empty job")
    if not case.sample:
        assert (case.readings, case.road_test, case.fluid) == (None, None, "mobil_atf_220")
    press(app, f"Undo: {label.lower() if 'New' in label else 'sample job taken'}")
    assert next(widget for widget in app.text_input if widget.label == "Technician").value == "T. Old"
    assert number(app, "Mileage [km]").value == "120000"
    assert app.session_state["atleak"].good.readings.name == "mine.xlsx"


@pytest.mark.page("2_Measure")
def test_a_valve_body_without_complaints_says_so(app: AppTest) -> None:
    text = (ROOT / "atleak" / "catalogue" / "controllers" / "minimal_example.toml").read_text(encoding="utf-8")
    head, _, rest = text.partition("[[complaints]]")
    bare = head + rest[rest.index("[[components]]") :]
    uploader(app).upload("bare.toml", bare.encode(), "text/plain").run()
    assert not app.exception
    assert choice(app, "Complaint").disabled
    assert "maps no complaint" in choice(app, "Complaint").help
