"""The page Diagnosis opens pairs, ticks repairs and takes them into the job's decisions."""

from __future__ import annotations

import itertools
import json

import pytest
from streamlit.testing.v1 import AppTest

from atleak.catalogue.controller import Controller
from tests.unit.pages.conftest import choice, go, tables, texts, uploader


def ticked(app: AppTest) -> list[bool]:
    return [widget.value for widget in app.main.checkbox]


def effect(app: AppTest) -> list[dict[str, str]]:
    return next(rows for rows in tables(app) if "Reserve" in rows[0])


def press(app: AppTest, label: str) -> AppTest:
    return next(widget for widget in app.main.button if widget.label == label).click().run()


def drawings(app: AppTest) -> str:
    return " ".join(json.loads(each.proto.json).get("html", "") for each in app.get("bidi_component"))


def test_a_tick_changes_what_is_shown_and_the_decisions_follow_only_when_they_are_taken(app: AppTest) -> None:
    before = effect(app)
    assert not any(ticked(app))
    app.main.checkbox[0].check().run()
    assert not app.exception
    after = effect(app)
    assert [row["Share"] for row in after] == [row["Share"] for row in before]
    assert after[0]["then"] != before[0]["then"]
    assert app.query_params["repairs"] == "25/1"
    assert not app.session_state["job-record"].repair_decisions
    press(app, "Fewest")
    assert ticked(app)[:5] == [True] * 5
    assert "With 5 repairs every total and pressure is within its limits." in texts(app)
    press(app, "Take into the decisions")
    assert not app.exception
    decided = app.session_state["job-record"].repair_decisions
    assert {(each.component, each.land, each.decision) for each in decided} == {
        ("25", 1, "proposed"), ("26", 2, "proposed"), ("17", 2, "proposed"), ("20", 1, "proposed"),
        ("14", 1, "proposed"),
    }  # fmt: skip
    go(app, "13_Estimate")
    states = [widget.value for widget in app.main.selectbox if widget.label == "State"]
    assert states == ["proposed"] * 5
    assert app.session_state["job-record"].repair_decisions == decided
    go(app, "4_Diagnosis")
    assert ticked(app)[:5] == [True] * 5
    assert "The repair decisions of this job are those ticked here." in texts(app)


def test_a_pair_is_opened_by_the_list_and_stays_open_on_every_page(app: AppTest) -> None:
    pick = next(widget for widget in app.main.selectbox if widget.label == "Open pair")
    assert pick.value is None
    assert pick.options[0].startswith("25 main")  # the worst first
    pick.select("17").run()
    assert not app.exception
    assert app.query_params["pair"] == "17"
    assert "Ovality of the bore" in drawings(app)
    go(app, "2_Readings")
    go(app, "4_Diagnosis")
    assert next(widget for widget in app.main.selectbox if widget.label == "Open pair").value == "17"
    choice(app, "Valve body").select("minimal_example").run()
    assert next(widget for widget in app.main.selectbox if widget.label == "Open pair").value is None


@pytest.mark.page("2_Readings")
def test_a_sheet_with_a_repeat_that_is_far_off_is_not_shown_green(app: AppTest, minimal: Controller) -> None:
    choice(app, "Valve body").select("minimal_example").run()
    lines = ["component;land;part;direction;repeat;diameter [mm]"]
    for land in minimal.lands:
        spool, sleeve = 1e3 * land.nominal_diameter, 1e3 * land.nominal_sleeve_diameter
        for part, diameter in (("spool", spool), ("sleeve", sleeve)):
            for direction, repeat in itertools.product((0, 90), (1, 2)):
                slip = 0.0095 if (land.component, part, repeat) == ("tcc_regulator", "spool", 2) else 0.0
                lines.append(f"{land.component};{land.land};{part};{direction};{repeat};{diameter + slip:.4f}")
    uploader(app, "Measuring sheet").upload("slip.csv", "\n".join(lines).encode(), "text/csv").run()
    go(app, "4_Diagnosis")
    assert not app.exception
    assert not app.success
    assert "1 in doubt, to be measured again (converter clutch regulator valve/1)" in texts(app)
    assert "green" not in app.main.info[0].value
