"""The page on which a valve body is described. What is typed into its tables is tried in a browser: tests/e2e."""

from __future__ import annotations

import tomllib
from typing import Any

import pytest
from streamlit.testing.v1 import AppTest

from atleak.catalogue.entries import own_folder, read_tables
from atleak.catalogue.workbook.sheets import SHEETS
from atleak.common.files import drafts
from atleak.report.sheets.controller_workbook import write_controller_workbook
from pages.shared import entrance
from pages.shared.transmission import STEPS
from tests.unit.pages.conftest import choice, go, texts
from tests.unit.pages.test_learn_form import sheets

PAGE = "20_Library?library=transmission"


def labelled(elements: Any, label: str) -> Any:
    return next(element for element in elements if element.label.replace("\\", "") == label)


def start(app: AppTest, name: str = "minimal_example") -> AppTest:
    go(app, PAGE)
    labelled(app.selectbox, "Start from").select(name).run()
    return labelled(app.button, "Start").click().run()


def step(app: AppTest, name: str) -> AppTest:
    return next(group for group in app.button_group if "step" in group.key).set_value(name).run()


def test_every_sheet_of_the_workbook_has_its_place_on_the_page() -> None:
    assert sorted(name for names in STEPS.values() for name in names) == sorted(sheet.name for sheet in SHEETS)


def test_every_table_opens_for_a_unit_and_for_nothing(app: AppTest) -> None:
    for name in ("five_speed_2005", "an empty entry"):
        start(app, name)
        for each, tables in STEPS.items():
            step(app, each)
            assert not app.exception
            assert [heading.value for heading in app.header][: len(tables)] == list(tables)
        labelled(app.button, "Edit another one").click().run()


def test_a_copy_is_named_kept_saved_used_and_edited_again(app: AppTest) -> None:
    start(app)
    assert "Nothing is missing or wrong." in texts(app)
    labelled(app.text_input, "Name *").set_value("Our box").run()
    labelled(app.text_input, "Gears *").set_value("x").run()
    assert "cannot be read (found 'x')" in texts(app)
    assert labelled(app.button, "Save as own file").disabled
    go(app, "4_Diagnosis")
    go(app, PAGE)
    assert labelled(app.text_input, "Gears *").value == "x"
    labelled(app.text_input, "Gears *").set_value("R 1 2 3 4").run()
    step(app, "Pump")
    labelled(app.text_input, "Displacement of one revolution [mm³]").set_value("18").run()
    assert ":orange[? 18 mm³ is unusual for the displacement of one revolution" in texts(app)
    labelled(app.text_input, "Displacement of one revolution [mm³]").set_value("18 000").run()
    assert ":orange[" not in texts(app)
    step(app, "Head")
    assert labelled(app.button, "Use it for this job").disabled
    labelled(app.button, "Save as own file").click().run()
    path = own_folder("controllers") / "our_box.toml"
    assert f"Saved: {path}" in texts(app)
    assert tomllib.loads(path.read_text(encoding="utf-8"))["gears"] == [-1, 1, 2, 3, 4]
    assert not drafts()
    del app.session_state["transmission"]  # the page loaded anew
    app.run()
    assert labelled(app.text_input, "Name *").value == "Our box"
    assert f"Saved: {path}" in texts(app)
    labelled(app.button, "Use it for this job").click().run()
    assert choice(app, "Valve body").value == "our_box"
    assert "R" in next(box for box in app.sidebar.selectbox if box.label == "Gear").options
    labelled(app.text_input, "Gears *").set_value("1 2 3 4").run()
    labelled(app.button, "Save as own file").click().run()  # over the file that it was saved as
    assert tomllib.loads(path.read_text(encoding="utf-8"))["gears"] == [1, 2, 3, 4]
    assert not app.exception


def test_a_file_that_is_there_is_replaced_only_where_that_is_decided(app: AppTest) -> None:
    start(app)
    labelled(app.text_input, "Name *").set_value("Our box").run()
    labelled(app.button, "Save as own file").click().run()
    labelled(app.button, "Edit another one").click().run()
    start(app)
    labelled(app.text_input, "Name *").set_value("Our box").run()
    labelled(app.text_input, "Note").set_value("the second").run()
    labelled(app.button, "Save as own file").click().run()
    assert "our_box.toml: is in your catalogue already" in texts(app)
    labelled(app.checkbox, "Replace our_box.toml, which is in your catalogue already").check().run()
    labelled(app.button, "Save as own file").click().run()
    assert "Saved:" in texts(app)
    assert "the second" in (own_folder("controllers") / "our_box.toml").read_text(encoding="utf-8")


def test_a_draft_is_gone_on_with_in_its_units_and_thrown_away(app: AppTest) -> None:
    start(app)
    labelled(app.text_input, "Name *").set_value("Half a box").run()
    labelled(app.text_input, "Contact length unless stated [mm]").set_value("2,54").run()
    labelled(app.selectbox, "Lengths are in").select("inch").run()
    labelled(app.button, "Edit another one").click().run()
    assert labelled(app.selectbox, "Go on with a draft").options[0].startswith("Half a box, ")
    labelled(app.button, "Go on").click().run()
    assert labelled(app.text_input, "Name *").value == "Half a box"
    assert labelled(app.text_input, "Contact length unless stated [inch]").value == "0.1"
    labelled(app.button, "Edit another one").click().run()
    labelled(app.button, "Throw it away").click().run()
    assert not drafts()
    assert not app.exception


def other_window(app: AppTest) -> AppTest:
    """The address of a draft, opened once more."""
    other = AppTest.from_file(app._script_path, default_timeout=240)
    other.query_params["draft"] = app.query_params["draft"]
    return go(other, PAGE)


def test_a_draft_that_two_windows_change_becomes_two_and_the_second_is_told(app: AppTest) -> None:
    labelled(start(app).text_input, "Name *").set_value("Half a box").run()
    other = other_window(app)
    assert labelled(other.text_input, "Name *").value == "Half a box"
    labelled(app.text_input, "Name *").set_value("First window").run()
    labelled(other.text_input, "Name *").set_value("Second window").run()
    assert not other.exception
    assert "changed in another window meanwhile" in texts(other)
    labelled(app.text_input, "Note").set_value("typed on").run()
    labelled(other.text_input, "Note").set_value("typed on as well").run()
    assert "another window" not in texts(app)
    assert [labelled(each.text_input, "Name *").value for each in (app, other)] == ["First window", "Second window"]
    labelled(app.button, "Edit another one").click().run()
    names = [option.split(",")[0] for option in labelled(app.selectbox, "Go on with a draft").options]
    assert sorted(names) == ["First window", "Second window"]


def test_saving_leaves_a_draft_that_another_window_has_changed(app: AppTest) -> None:
    labelled(start(app).text_input, "Name *").set_value("Our box").run()
    other = other_window(app)
    labelled(other.text_input, "Note").set_value("typed elsewhere").run()
    labelled(app.button, "Save as own file").click().run()
    assert "Saved:" in texts(app)
    (path,) = drafts().values()
    assert "typed elsewhere" in path.read_text(encoding="utf-8")


def test_a_draft_of_somebody_who_is_signed_in_is_offered_to_nobody_else(
    app: AppTest, monkeypatch: pytest.MonkeyPatch
) -> None:
    whose = "https://shop ana"
    monkeypatch.setattr(entrance, "person", lambda: whose)
    labelled(start(app).text_input, "Name *").set_value("Box of Ana").run()
    labelled(app.button, "Edit another one").click().run()
    assert len(labelled(app.selectbox, "Go on with a draft").options) == 1
    whose = "https://shop bert"
    assert labelled(app.run().selectbox, "Go on with a draft").options == []


def test_a_workbook_is_read_into_the_tables_and_a_damaged_one_refused(app: AppTest) -> None:
    content = write_controller_workbook(read_tables("controllers", "minimal_example")[0])
    go(app, PAGE)
    upload = labelled(app.file_uploader, "or read a workbook or a TOML file")
    upload.upload("torn.xlsx", content[:300], "").run()
    assert "torn.xlsx was not taken" in texts(app)
    labelled(app.file_uploader, "or read a workbook or a TOML file").upload("box.xlsx", content, "").run()
    assert not app.exception
    assert "Nothing is missing or wrong." in texts(app)
    assert labelled(app.text_input, "Id *").value == "minimal_example"


def test_clearances_are_learned_from_sheets_of_new_units_into_the_lands(app: AppTest) -> None:
    start(app)
    step(app, "New parts")
    labelled(app.file_uploader, "Measuring sheets, one for each unit").set_value(sheets(5)).run()
    labelled(app.button, "Take these over").click().run()
    assert not app.exception
    assert "Nothing is missing or wrong." in texts(app)
    lands = app.session_state["transmission"].draft.rows("Lands")
    assert {land["Learned from"] for land in lands} == {"5"}
    assert all(13.0 < float(land["Mounting clearance"]) < 17.0 for land in lands)  # made with 15 µm
