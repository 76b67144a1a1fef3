"""The form that says which column of a measuring sheet is what, on the page Readings."""

from __future__ import annotations

from pathlib import Path

import pytest
from streamlit.testing.v1 import AppTest

from atleak.catalogue.controller_file import load_controller
from atleak.job.case import SourceFile
from atleak.readers.logs import default_path
from atleak.readers.remembered_columns import recall_all
from atleak.readers.sheets.mapping import remember_sheet
from atleak.readers.sheets.measuring_sheet import read_readings
from pages.shared.cases import PageCase

ROOT = Path(__file__).resolve().parents[3]
ITALIAN = "Scheda di oggi\nN.;Sezione;Cursore;Sede\naccumulator;1;17.998;18.041\ntcc_regulator;1;10.998;11.031\n"


@pytest.fixture
def form(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, own_home: Path) -> AppTest:
    """Return the form of a sheet that was refused."""
    monkeypatch.syspath_prepend(str(ROOT))
    script = tmp_path / "form.py"
    script.write_text(
        "from atleak.common.errors import ReadingsError\nfrom atleak.common.sentences import Sentence\n"
        "from atleak.job.case import SourceFile\nfrom pages.shared import sheet_form\n"
        "from pages.shared.cases import PageCase\nfrom pages.shared.state import Refusal, session\nnow = session()\n"
        "if now.case.sample:\n"
        "    now.case = PageCase(controller='minimal_example')\n"
        f"    file = SourceFile('scheda.csv', {ITALIAN.encode()!r})\n"
        "    now.refused['readings'] = Refusal('scheda.csv', ReadingsError(Sentence('no')), file)\n"
        "sheet_form.draw(now.case)\n",
        encoding="utf-8",
    )
    return AppTest.from_file(str(script), default_timeout=240).run()


def press(form: AppTest, label: str) -> AppTest:
    form = next(button for button in form.button if button.label.startswith(label)).click().run()
    assert not form.exception
    return form


def picked(form: AppTest) -> dict[str, object]:
    return {box.label: box.value for box in form.selectbox}


def test_a_refused_sheet_opens_it_filled_in_with_what_was_understood(form: AppTest) -> None:
    assert not form.exception
    assert list(form.dataframe[0].value.iloc[1]) == ["N.", "Sezione", "Cursore", "Sede"]
    assert {text.label: text.value for text in form.text_input}["Rows of the headings"] == "2"
    chosen = picked(form)
    assert (chosen["Component"], chosen["Plane or land"]) == ("N.", "Sezione")
    assert (chosen["Diameters 1"], chosen["Diameters 2"]) == ("Cursore", "Sede")


def test_a_preview_shows_readings_or_what_a_guard_says_and_keeps_nothing(form: AppTest) -> None:
    form = press(form, "Preview")
    assert list(form.dataframe[1].value["Diameter [mm]"]) == [17.998, 18.041, 10.998, 11.031]
    assert any("names no unit" in warning.value for warning in form.warning)
    assert recall_all(default_path()) == {}
    next(box for box in form.selectbox if box.label == "Diameters 1").select("Sede")
    next(box for box in form.selectbox if box.label == "Diameters 2").select("Cursore")
    form = press(form, "Preview")
    assert any("swapped" in error.value for error in form.error)
    form = press(form, "Use")
    assert any("swapped" in error.value for error in form.error)
    assert recall_all(default_path()) == {}
    assert form.session_state["atleak"].case.readings is None


def test_what_is_used_is_remembered_and_makes_the_job(form: AppTest) -> None:
    next(
        box for box in form.selectbox if box.label == "Unit of the diameters" and box.form_id == "sheet-columns"
    ).select("mm")
    form = press(form, "Use")
    case = form.session_state["atleak"].case
    assert case.readings is not None
    assert case.readings.name == "scheda.csv"
    assert (dict(case.sheet_columns)["value sleeve"], case.sheet_unit) == ("Sede", "mm")
    (kept,) = recall_all(default_path()).values()
    assert (kept.mapping["component"], dict(kept.units)) == ("N.", {"value": "mm"})
    from pages.shared.cases import diagnosis_of

    assert len(diagnosis_of(case).readings.readings) == 4


def test_other_rows_of_headings_are_shown_and_wrong_ones_told(form: AppTest) -> None:
    header = next(text for text in form.text_input if text.label == "Rows of the headings")
    header.set_value("1")
    form = press(form, "Show it so")
    assert picked(form)["Component"] == "Scheda di oggi"
    assert "B · B: 1" in next(box for box in form.selectbox if box.label == "Plane or land").options
    next(text for text in form.text_input if text.label == "Rows of the headings").set_value("here")
    form = press(form, "Show it so")
    assert any("no rows" in error.value for error in form.error)


@pytest.mark.page("3_Readings")
def test_the_page_says_first_since_when_columns_are_settled(app: AppTest, own_home: Path) -> None:
    columns = {"component": "N.", "plane": "Sezione", "value spool": "Cursore", "value sleeve": "Sede"}
    settled = read_readings(ITALIAN.encode(), load_controller("minimal_example"), name="a.csv", mapping=columns)
    remember_sheet(default_path(), settled)
    sheet = SourceFile("b.csv", ITALIAN.replace("18.041", "18.042").encode())
    app.session_state["atleak"].case = PageCase(controller="minimal_example", readings=sheet)
    app.run()
    assert not app.exception
    assert any("settled on" in caption.value for caption in app.caption)
