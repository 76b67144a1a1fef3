"""Limits, instruments and fluids typed on a page: doubts at the field, own files of the job, and undo."""

from __future__ import annotations

import pytest
from streamlit.testing.v1 import AppTest

from atleak.catalogue.entries import own_files, write_own
from atleak.catalogue.limits import load_limits
from atleak.common.verdicts import Verdict
from atleak.report.printed_fonts import FONTS, keep_font, kept_file
from tests.unit.pages.conftest import texts

pytestmark = pytest.mark.page("20_Library?library=workshop_data")


def press(app: AppTest, label: str) -> None:
    next(each for each in app.button if each.label.replace("\\", "") == label).click().run()
    assert not app.exception


def type_in(app: AppTest, label: str, text: str) -> None:
    next(each for each in app.text_input if each.label.removesuffix(" *") == label).set_value(text).run()
    assert not app.exception


def show(app: AppTest, step: str) -> None:
    next(each for each in app.button_group if each.key and each.key.endswith("-step")).set_value(step).run()
    assert not app.exception


def test_a_copy_of_the_limits_is_checked_as_it_is_typed_saved_and_used_by_the_job(app: AppTest) -> None:
    next(each for each in app.selectbox if each.key.endswith("-start")).set_value("project_default").run()
    press(app, "Start")
    type_in(app, "Name", "Our limits")
    show(app, "Wear")
    type_in(app, "Replace [%]", "5000")
    assert "5000 % is unusual for a limit of wear: most are from 2 to 300 %." in texts(app)
    type_in(app, "Replace [%]", "5")
    assert "replace above watch (10)" in texts(app)
    save = next(each for each in app.button if each.label == "Save as own file")
    assert save.disabled
    type_in(app, "Replace [%]", "45,5")
    press(app, "Save as own file")
    steps = load_limits("our_limits").wear
    assert steps is not None
    assert steps.limit_of(Verdict.REPLACE) == pytest.approx(0.455, abs=1e-12)
    press(app, "Use it for this job")
    assert app.session_state["atleak"].case.limits == "our_limits"
    assert "This job uses it." in texts(app)


def test_an_own_instrument_is_renamed_and_deleted_and_both_are_undone(app: AppTest) -> None:
    text = (
        'id = "mike"\nname = "Mike"\nsource = "certificate"\ndate = "2026-01-31"\nmeasures = ["spool"]\n'
        "resolution_um = 1.0\ncalibration_um = 1.5\ncommon_part = 0.5\n"
    )
    write_own("instruments", "mike", text)
    next(each for each in app.button_group if each.key == "part-of-kind").set_value("instruments").run()
    press(app, "Edit")
    type_in(app, "Id", "mike_2")
    next(
        each for each in app.checkbox if each.label.replace("\\", "").startswith("Rename mike to mike_2")
    ).check().run()
    press(app, "Save as own file")
    assert list(own_files("instruments")) == ["mike_2"]
    press(app, "Undo")
    assert list(own_files("instruments")) == ["mike"]
    app.session_state["atleak"].case = app.session_state["atleak"].case.__class__(spool_instrument="mike")
    press(app, "Delete")
    assert "mike was deleted." in texts(app)
    assert not own_files("instruments")
    assert app.session_state["atleak"].case.spool_instrument.name == "mike.toml"
    press(app, "Undo")
    assert list(own_files("instruments")) == ["mike"]


def test_the_font_that_is_kept_for_reports_is_named_and_can_be_let_go(app: AppTest) -> None:
    keep_font((FONTS / "NotoSans-Bold.ttf").read_bytes(), "Workshop.ttf")
    app.run()
    assert "Kept for all reports: Workshop.ttf" in texts(app)
    press(app, "Keep none")
    assert kept_file() is None
    assert "None is kept." in texts(app)
