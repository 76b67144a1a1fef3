"""The form that says which column of a measuring sheet is what, on the page Measure."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pandas as pd
import pytest
from streamlit.testing.v1 import AppTest

from atleak.catalogue.controller_file import load_controller
from atleak.common.errors import ReadingsError
from atleak.common.sentences import Sentence
from atleak.job.case import SourceFile
from atleak.readers.logs import default_path
from atleak.readers.remembered_columns import recall_all
from atleak.readers.sheets.mapping import remember_sheet
from atleak.readers.sheets.measuring_sheet import read_readings
from pages.shared import what_was_read
from pages.shared.cases import PageCase, diagnosis_of
from pages.shared.state import Refusal

ROOT = Path(__file__).resolve().parents[3]
ESTONIAN = "Leht\nNr;Lõige;Siiber;Auk\naccumulator;1;17.998;18.041\ntcc_regulator;1;10.998;11.031\n"


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
        f"    file = SourceFile('scheda.csv', {ESTONIAN.encode()!r})\n"
        "    now.refused['readings'] = Refusal('scheda.csv', ReadingsError(Sentence('no')), file)\n"
        "sheet_form.draw(now.case)\n",
        encoding="utf-8",
    )
    return AppTest.from_file(str(script), default_timeout=240).run()


def press(form: AppTest, label: str) -> AppTest:
    form = next(button for button in form.button if button.label.startswith(label)).click().run()
    assert not form.exception
    return form


def columns(form: AppTest) -> dict[str, tuple[object, ...]]:
    """Return what the table of columns says: of each column its role and of what its diameters are."""
    table = next(one.value for one in form.dataframe if "Example" in one.value)
    return {row[0]: (list(row[2]), *(None if pd.isna(cell) else cell for cell in row[3:])) for row in table.to_numpy()}


@pytest.fixture
def edit(monkeypatch: pytest.MonkeyPatch) -> Callable[..., None]:
    """Change cells of the table of columns as a hand does, by its row and the title of its column."""

    def change(**cells: object) -> None:
        def edited(frame: pd.DataFrame, **_: object) -> pd.DataFrame:
            frame = frame.copy()
            for name, value in cells.items():
                title, row = name.rsplit("_", 1)
                frame[title] = [value if at == int(row) else cell for at, cell in enumerate(frame[title])]
            return frame

        monkeypatch.setattr("streamlit.data_editor", edited)

    return change


@pytest.fixture
def choose(monkeypatch: pytest.MonkeyPatch) -> Callable[..., None]:
    """Choose a row or a column of the file's own table, counted from 0."""

    def spot(row: int | None = None, column: int | None = None) -> None:
        monkeypatch.setattr("pages.shared.what_was_read._table", lambda *_: what_was_read.Spot(row, column))

    return spot


def test_a_refused_sheet_opens_it_filled_in_with_what_was_understood(form: AppTest) -> None:
    assert not form.exception
    assert list(form.dataframe[0].value.iloc[1])[1:] == ["Nr", "Lõige", "Siiber", "Auk"]
    assert {text.label: text.value for text in form.text_input}["Rows of the headings"] == "2"
    assert columns(form) == {
        "A · Nr": (["Component"], None, None, None, None),
        "B · Lõige": (["Plane or land"], None, None, None, None),
        "C · Siiber": (["Diameters"], "spool", None, None, None),
        "D · Auk": (["Diameters"], "sleeve", None, None, None),
    }


def test_a_preview_shows_readings_or_what_a_guard_says_and_keeps_nothing(
    form: AppTest, edit: Callable[..., None]
) -> None:
    form = press(form, "Preview")
    assert list(form.dataframe[-1].value["Diameter [mm]"]) == [17.998, 18.041, 10.998, 11.031]
    assert any("names no unit" in warning.value for warning in form.warning)
    assert any(text.startswith("C · spool") for text in form.dataframe[0].value.columns)
    assert recall_all(default_path()) == {}
    edit(Part_2="sleeve", Part_3="spool")
    form = press(form.run(), "Preview")
    assert any("swapped" in error.value for error in form.error)
    form = press(form, "Use")
    assert any("swapped" in error.value for error in form.error)
    assert recall_all(default_path()) == {}
    assert form.session_state["atleak"].case.readings is None


def test_two_columns_that_nothing_tells_apart_are_told(form: AppTest, edit: Callable[..., None]) -> None:
    edit(Part_3="spool")
    form = form.run()
    assert any("Siiber and Auk are both said to be" in error.value for error in form.error)
    assert next(button for button in form.button if button.label == "Preview").disabled


def test_twelve_columns_of_diameters_are_said_in_a_table(form: AppTest, edit: Callable[..., None]) -> None:
    kinds = [(part, angle, n) for part in ("spool", "sleeve") for angle in ("0°", "90°") for n in "123"]
    sizes = [size + 0.001 * int(n) for size in (17.99, 18.04) for _ in "ab" for n in "123"]
    sheet = ";".join(["Nr", "Sez.", *(f"k{n}" for n in range(12))]) + "\naccumulator;1;" + ";".join(map(str, sizes))
    file = SourceFile("twelve.csv", sheet.encode())
    form.session_state["atleak"].refused["readings"] = Refusal("twelve.csv", ReadingsError(Sentence("no")), file)
    cells: dict[str, object] = {}
    for row, (part, angle, repeat) in enumerate(kinds, 2):
        cells |= {f"Part_{row}": part, f"Direction_{row}": angle, f"Repeat_{row}": repeat, f"Is_{row}": ["Diameters"]}
    edit(**cells)
    form = press(form.run(), "Use")
    case = form.session_state["atleak"].case
    assert dict(case.sheet_columns)["value sleeve 90° repeat 3"] == "k11"
    assert len(diagnosis_of(case).readings.readings) == 12


def test_what_is_used_is_remembered_and_makes_the_job(form: AppTest) -> None:
    [box for box in form.selectbox if box.label == "Unit of the diameters"][-1].select("mm").run()
    form = press(form, "Use")
    case = form.session_state["atleak"].case
    assert case.readings is not None
    assert case.readings.name == "scheda.csv"
    assert (dict(case.sheet_columns)["value sleeve"], case.sheet_unit) == ("Auk", "mm")
    (kept,) = recall_all(default_path()).values()
    assert (kept.mapping["component"], dict(kept.units)) == ("Nr", {"value": "mm"})
    assert len(diagnosis_of(case).readings.readings) == 4


def test_a_click_leaves_a_row_out_or_fills_in_the_form_of_a_refused_sheet(
    form: AppTest, choose: Callable[..., None]
) -> None:
    choose(row=3)
    form = press(form.run(), "Row 4 does not count")
    assert {text.label: text.value for text in form.text_input}["Rows that count"] == "1-3"
    assert len(form.dataframe[-1].value) == 2
    assert form.session_state["atleak"].case.readings is None
    choose(column=3)
    next(box for box in form.run().selectbox if box.label == "Column D is").select("new").run()
    assert columns(form)["D · Auk"][0] == ["When new, or nominal"]
    choose(row=0)
    form = press(form.run(), "The headings are in row 1")
    assert "A · Leht" in columns(form)


OWN = "Valve;Land;Part;Diameter [mm]\n" + "".join(
    f"{row}\n" for row in ("accumulator;1;spool;17.998", "accumulator;1;spool;17.990", "accumulator;1;sleeve;18.041")
)


@pytest.mark.page("2_Measure")
def test_a_row_of_the_jobs_own_sheet_counts_no_more_and_again_by_one_click(
    app: AppTest, own_home: Path, choose: Callable[..., None]
) -> None:
    sheet = SourceFile("own.csv", OWN.encode())
    app.session_state["atleak"].case = PageCase(controller="minimal_example", readings=sheet)
    choose(row=2)
    app.session_state["folds"] = {f"sheet-columns-{sheet.sha256}-False": True}
    app.run()
    app = press(app, "Row 3 does not count")
    case = app.session_state["atleak"].good
    assert case.sheet_columns == (("rows", "1-2,4"),)
    assert [round(one.diameter * 1e3, 3) for one in diagnosis_of(case).readings.readings] == [17.998, 18.041]
    assert recall_all(default_path()) == {}
    app = press(app, "Row 3 counts again")
    assert app.session_state["atleak"].good.sheet_columns == ()
    press(app, "Undo")
    assert app.session_state["atleak"].good.sheet_columns == (("rows", "1-2,4"),)


def test_other_rows_of_headings_are_shown_and_wrong_ones_told(form: AppTest) -> None:
    next(text for text in form.text_input if text.label == "Rows of the headings").set_value("1").run()
    assert columns(form)["A · Leht"][0] == ["Component"]
    next(text for text in form.text_input if text.label == "Rows of the headings").set_value("here").run()
    assert any("no rows" in error.value for error in form.error)


def test_a_cell_a_row_or_a_column_of_the_table_is_what_is_chosen() -> None:
    headings = ["A · component", "B"]
    for selection, spot in (
        ({"rows": [1], "columns": []}, (301, None)),
        ({"rows": [], "columns": ["B"]}, (None, 1)),
        ({"rows": [], "columns": [], "cells": [(0, "A · component")]}, (300, 0)),
        ({"rows": [], "columns": [], "cells": [(0, "What became of it")]}, (300, None)),
    ):
        assert what_was_read.spot_of({"selection": selection}, range(300, 400), headings) == spot


@pytest.mark.page("2_Measure")
def test_the_page_names_its_own_fields_in_place_of_options_of_the_command_line(app: AppTest, own_home: Path) -> None:
    file = SourceFile("scheda.csv", ESTONIAN.encode())
    with pytest.raises(ReadingsError, match=r"--map component=Nr --map") as caught:
        read_readings(file.content, load_controller("minimal_example"), name=file.name)
    app.session_state["atleak"].refused["readings"] = Refusal(file.name, caught.value, file)
    app.run()
    said = next(error.value for error in app.error if "not taken as measuring sheet" in error.value)
    assert "“What was read, and which column is what” on the page Measure" in said
    assert "map component" not in said


@pytest.mark.page("2_Measure")
def test_the_page_fills_in_which_component_a_word_of_the_sheet_names(app: AppTest, own_home: Path) -> None:
    file = SourceFile("own.csv", b"Valve;Land;Spool mm;Bore mm\nAccum.;1;17.998;18.041\nTCC reg.;1;10.998;11.034")
    with pytest.raises(ReadingsError) as caught:
        read_readings(file.content, load_controller("minimal_example"), name=file.name)
    app.session_state["atleak"].case = PageCase(controller="minimal_example")
    app.session_state["atleak"].refused["readings"] = Refusal(file.name, caught.value, file)
    app.run()
    for word, component in (("Accum.", "accumulator"), ("TCC reg.", "tcc_regulator")):
        asked = next(each for each in app.selectbox if each.label == f"Component {word} is")
        assert asked.value == component, "the diameters under the name tell it, to be checked"
    next(button for button in app.button if button.label.startswith("Use and remember")).click().run()
    assert not app.exception
    readings = app.session_state["atleak"].good.readings
    assert readings is not None
    assert readings.name == "own.csv"
    assert dict(app.session_state["atleak"].good.sheet_columns)["component accumulator"] == "Accum."


@pytest.mark.page("2_Measure")
def test_the_page_says_first_since_when_columns_are_settled(app: AppTest, own_home: Path) -> None:
    columns = {"component": "Nr", "plane": "Lõige", "value spool": "Siiber", "value sleeve": "Auk"}
    settled = read_readings(ESTONIAN.encode(), load_controller("minimal_example"), name="a.csv", mapping=columns)
    remember_sheet(default_path(), settled)
    sheet = SourceFile("b.csv", ESTONIAN.replace("18.041", "18.042").encode())
    app.session_state["atleak"].case = PageCase(controller="minimal_example", readings=sheet)
    app.run()
    assert not app.exception
    assert any("settled on" in caption.value for caption in app.caption)
