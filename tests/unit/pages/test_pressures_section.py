"""The diagnosis says what line and circuits hold, which lands cost them what, and where the flow goes."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from streamlit.testing.v1 import AppTest

from atleak.catalogue.controller_file import load_controller
from tests.unit.pages.conftest import choice, go, opened, texts, uploader

pytestmark = pytest.mark.page("2_Measure")


def frame_with(app: AppTest, column: str):
    return next(frame.value for frame in app.dataframe if column in frame.value)


def chart_names(app: AppTest) -> list[set[str]]:
    return [
        {trace.get("name", "") for trace in json.loads(each.proto.spec)["data"]} for each in app.get("plotly_chart")
    ]


def in_full_at(app: AppTest) -> Any:
    return next(widget for widget in app.selectbox if widget.label == "Pressures in full at")


def leaks_alone(app: AppTest) -> Any:
    return next(widget for widget in app.toggle if widget.label.startswith("The leaks alone"))


@pytest.fixture(scope="module")
def five_speed(tmp_path_factory: pytest.TempPathFactory, root: Path) -> Iterator[AppTest]:
    """The dashboard with the shipped sheet of a valve body with circuits; whoever chooses something undoes it."""
    for app in opened(tmp_path_factory.mktemp("five_speed"), "2_Measure"):
        choice(app, "Valve body").select("five_speed_2005").run()
        sheet = root / "sample_data" / "measuring_sheet_five_speed.xlsx"
        uploader(app, "Measuring sheet").upload(sheet.name, sheet.read_bytes(), "application/x").run()
        yield go(app, "4_Diagnosis?diagnosis=pressures#pressures-in-full")


def test_every_condition_stands_with_line_and_reserve_and_one_in_full(five_speed: AppTest) -> None:
    assert not five_speed.exception
    conditions = frame_with(five_speed, "Reserve")
    controller = load_controller("five_speed_2005")
    assert set(conditions["Operating point"]) == {point.label for point in controller.operating_points}
    assert {text.strip() for text in conditions["Verdict"]} == {"■ replace", "● ok"}
    shown = frame_with(five_speed, "Lands that cost it")
    clutch = shown[shown["Circuit"] == "forward clutch"].iloc[0]
    assert clutch["Verdict"].strip() == "■ replace"
    assert clutch["Lost [kPa]"] == pytest.approx(clutch["New [kPa]"] - clutch["Held [kPa]"], abs=1.0)  # whole kPa
    assert clutch["Low [kPa]"] < clutch["Held [kPa]"] < clutch["High [kPa]"]
    assert shown[shown["Circuit"] == "solenoid feed"]["Lands that cost it"].isna().all()
    table = next(frame for frame in five_speed.dataframe if "Lands that cost it" in frame.value)
    assert table.proto.placeholder == "–"  # not "None"
    assert clutch["Lands that cost it"].startswith("forward engagement valve/1: ")
    assert "Main pressure at “stall in drive, 90 °C”: the required 1 615 kPa is held" in texts(five_speed).replace(
        "\u00a0", " "
    )


def test_the_first_sentence_names_the_pressure_and_the_lands_to_look_at(five_speed: AppTest) -> None:
    said = texts(five_speed).replace("\u00a0", " ")
    assert "■ replace because of the pressure lost by forward clutch at “stall in drive, 90 °C”: " in said
    assert "Look first at forward engagement valve/1, manual valve/3;" in said


def test_another_condition_is_chosen_for_the_charts(five_speed: AppTest) -> None:
    labels = list(in_full_at(five_speed).options)
    assert labels[0] == "stall in drive, 90 °C"  # the worst first
    in_full_at(five_speed).select_index(labels.index("hot idle in reverse, 100 °C")).run()
    assert not five_speed.exception
    circuits = set(frame_with(five_speed, "Lands that cost it")["Circuit"])
    assert {"main pressure", "direct clutch", "low and reverse band servo"} <= circuits
    assert "forward clutch" not in circuits
    assert "Not applied in this gear: forward clutch" in texts(five_speed)
    assert any({"new", "set, or required"} <= names for names in chart_names(five_speed))
    assert any({"pump", "covered from here", "taken at 100\u00a0°C"} <= names for names in chart_names(five_speed))
    in_full_at(five_speed).select_index(0).run()


def test_the_flow_is_drawn_and_stands_as_a_table(five_speed: AppTest) -> None:
    rows = frame_with(five_speed, "Flow [dm³/min]")
    assert "pump" in set(rows["From"])
    leaks_alone(five_speed).set_value(True).run()
    assert not five_speed.exception
    rows = frame_with(five_speed, "Flow [dm³/min]")
    assert "pump" not in set(rows["From"])
    assert rows["From"].str.startswith("main pressure p_g").any()
    leaks_alone(five_speed).set_value(False).run()


@pytest.mark.page("4_Diagnosis?diagnosis=pressures")
def test_a_valve_body_without_circuits_says_so_in_one_sentence(app: AppTest) -> None:
    assert "This valve body's file describes no circuits: only the line is judged." in texts(app)
    assert not any("Lands that cost it" in frame.value for frame in app.dataframe)


@pytest.mark.page("4_Diagnosis?diagnosis=pressures")
def test_without_a_sheet_no_pressure_is_green(app: AppTest) -> None:
    choice(app, "Valve body").select("five_speed_2005").run()
    assert not app.exception
    for column in ("Reserve", "Lands that cost it", "Held [kPa]"):
        for frame in (each.value for each in app.dataframe if column in each.value):
            assert not frame["Verdict"].str.contains("ok").any()
