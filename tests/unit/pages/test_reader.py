"""Each browser reads its own language and units, from its own choice or, without one, its own locale."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from streamlit.testing.v1 import AppTest

from atleak.common.wording import wording
from tests.unit.pages.conftest import ROOT, choice, go
from tests.unit.pages.conftest import opened as dashboard


def page() -> None:
    """A page of one table and the choices, as a page of the dashboard shows them."""
    import streamlit as st

    from atleak.catalogue.written_numbers import TEMPERATURE
    from atleak.common.verdicts import Verdict
    from atleak.report.tables.table import Column, Table
    from pages.shared import fields, reader, show

    reader.mark_page()
    rows: list[dict[str, Any]] = [
        {"verdict": Verdict.CRITICAL, "clearance": 25.4, "held": 1000.0},
        {"verdict": None, "clearance": None, "held": None},
    ]
    columns = Column("verdict", "verdict"), Column("clearance", "clearance"), Column("held", "pressure")
    show.table(Table("", columns, rows, reader.say()))
    st.text(reader.say().quantity(95.5, "temperature", 1))
    st.code(fields.number("T", TEMPERATURE, 80.0, key="t"))
    reader.draw_choices()


def opened(locale: str | None = None) -> AppTest:
    app = AppTest.from_function(page, default_timeout=60)
    if locale is not None:
        app.context["locale"] = locale
    return app.run()


def shown(app: AppTest) -> tuple[list[str], str]:
    assert not app.exception
    return list(app.dataframe[0].value), app.text[0].value


@pytest.mark.parametrize(
    ("locale", "headings", "temperature"),
    [
        (None, ["Verdict", "Clearance [µm]", "Held [kPa]"], "95.5\xa0°C"),
        ("en-US", ["Verdict", "Clearance [µm]", "Held [kPa]"], "95.5\xa0°C"),
        ("fr-FR", ["Verdict", "Clearance [µm]", "Held [kPa]"], "95.5\xa0°C"),
        ("de-AT", ["Befund", "Spiel [µm]", "Gehalten [kPa]"], "95,5\xa0°C"),
        ("pl", ["Ocena", "Luz [µm]", "Utrzymane [kPa]"], "95,5\xa0°C"),
    ],
)
def test_without_a_choice_the_browsers_locale_gives_the_language(
    locale: str | None, headings: list[str], temperature: str
) -> None:
    assert shown(opened(locale)) == (headings, temperature)


def test_a_choice_holds_at_once_and_for_its_own_session_alone() -> None:
    mine, other = opened("de-DE"), opened("de-DE")
    language, units = mine.selectbox
    assert (language.value, units.value) == ("de", "metric")
    units.select("us").run()
    assert shown(mine) == (["Befund", "Spiel [0.0001 in]", "Gehalten [psi]"], "203,9\xa0°F")
    mine.selectbox[0].select("en").run()
    assert shown(mine) == (["Verdict", "Clearance [0.0001 in]", "Held [psi]"], "203.9\xa0°F")
    assert mine.dataframe[0].value["Clearance [0.0001 in]"].tolist()[0] == 10.0
    assert shown(other.run()) == (["Befund", "Spiel [µm]", "Gehalten [kPa]"], "95,5\xa0°C")


def test_a_verdict_is_said_in_the_readers_language_and_nothing_judged_is_a_dash() -> None:
    first, second = opened("pl-PL").dataframe[0].value["Ocena"]
    assert first.strip("\u200a").endswith("krytyczny")
    assert second == "–"


def test_a_number_is_typed_in_the_readers_unit_and_stays_the_same_value_in_every_other() -> None:
    app = opened("de-DE")
    (field,) = app.text_input
    assert (field.label, field.value) == ("T [°C]", "80")
    field.set_value("95,5").run()
    assert app.code[0].value == "95.5"
    app.selectbox[1].select("us").run()
    (field,) = app.text_input
    assert (field.label, field.value, app.code[0].value) == ("T [°F]", "203,9", "95.5")
    field.set_value("212").run()
    assert app.code[0].value == "100.0"
    app.selectbox[1].select("metric").run()
    (field,) = app.text_input
    assert (field.label, field.value, app.code[0].value) == ("T [°C]", "100", "100.0")
    field.set_value("heiß").run()
    assert [each.value.replace("\\", "") for each in app.error] == [
        "'heiß' ist keine Zahl: Temperatur in °C schreiben, etwa 95,5. Es bleibt bei 100 °C."
    ]
    assert app.code[0].value == "100.0"


@pytest.mark.parametrize("language", ["de", pytest.param("pl", marks=pytest.mark.slow)])
def test_every_page_is_shown_in_the_readers_language(tmp_path: Path, language: str) -> None:
    (app,) = dashboard(tmp_path, "21_Settings", language)
    choice(app, wording(language)("slots.controller")).select("minimal_example").run()
    for path in sorted((ROOT / "pages").glob("[0-9]*_*.py")):
        shown = go(app, path.stem)
        assert not shown.exception, path.stem
        files = next(each for each in shown.sidebar.file_uploader if each.key.startswith("drop-zone-job"))
        assert files.label == wording(language)("panel.files")


@pytest.mark.page("4_Diagnosis?diagnosis=lands#how-sure")
def test_what_is_assumed_and_what_is_asked_stand_in_the_readers_units(app: AppTest) -> None:
    app.session_state["reader-units"] = "us"
    app.run()
    assumed = next(table.value for table in app.dataframe if "room temperature" in table.value.iloc[:, 0].tolist())
    by_name = dict(zip(*(assumed.iloc[:, column] for column in (0, 1)), strict=True))
    assert (by_name["contact length"], by_name["room temperature"]) == ("0.0039\xa0in", "0.9\xa0°F")
    assert by_name["viscosity"] == "5\xa0%"
    go(app, "3_In_the_car#step-gauges")
    assert choice(app, "Unit").value == "psi"
