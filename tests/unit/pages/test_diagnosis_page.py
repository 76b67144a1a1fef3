"""The page Diagnosis opens pairs, ticks repairs and takes them into the job's decisions."""

from __future__ import annotations

import itertools
import json
import re

import pytest
from streamlit.testing.v1 import AppTest

from atleak.catalogue.controller import Controller
from tests.unit.pages.conftest import choice, flagged, flagged_pairs, go, press, tables, texts, unfold, uploader


def ticked(app: AppTest) -> list[bool]:
    return [widget.value for widget in app.main.checkbox]


def effect(app: AppTest) -> list[dict[str, str]]:
    return next(rows for rows in tables(app) if "Reserve" in rows[0])


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
    go(app, "5_Plan")
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
    go(app, "2_Measure")
    go(app, "4_Diagnosis")
    assert next(widget for widget in app.main.selectbox if widget.label == "Open pair").value == "17"
    choice(app, "Valve body").select("minimal_example").run()
    assert next(widget for widget in app.main.selectbox if widget.label == "Open pair").value is None


@pytest.mark.page("2_Measure")
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


def test_a_fresh_start_shows_flagged_pairs_of_the_sample_job(app: AppTest) -> None:
    assert not app.exception
    assert set(flagged(app)) == {"■ replace", "▲ watch"}
    assert flagged(app) == sorted(flagged(app), key=["■ replace", "▲ watch"].index)
    assert [widget.value for widget in app.title] == ["Diagnosis"]
    counted = r"\*\*■ replace · provisional:\*\* \d+ ■ replace, \d+ ▲ watch of 47 measured lands; 25/1 main "
    assert re.match(counted, app.error[0].value)
    assert "converter, lubrication and clutch fill are not in it" in texts(app)
    assert "kinds of value are assumed: neither measured nor published" in texts(app)


def test_a_land_measured_on_one_part_only_is_never_called_ok(app: AppTest) -> None:
    choice(app, "Valve body").select("minimal_example").run()
    head, rows = "component;part;plane;direction;diameter [mm]\n", "accumulator;piston;1;{};17,999\n"
    spool_only = head + rows.format(0) + rows.format(90)
    uploader(app, "Measuring sheet").upload("piston.csv", spool_only.encode(), "text/csv").run()
    assert not app.exception
    (said,) = [widget.value for widget in app.info if "on one part only" in widget.value]
    assert said.startswith("**○ not all is sure")
    assert not app.success
    row = next(row for row in tables(unfold(app, "all-lands"))[-1] if row["Pair"] == "accumulator piston/1")
    assert row["Verdict"].endswith("not measured")
    assert row["Decided by"] == "sleeve not measured"


def test_a_flagged_land_says_which_part_was_not_measured(app: AppTest) -> None:
    choice(app, "Valve body").select("minimal_example").run()
    sheet = "component;part;plane;direction;diameter [mm]\naccumulator;sleeve;1;0;18,2\naccumulator;sleeve;1;90;18,2\n"
    uploader(app, "Measuring sheet").upload("sleeve.csv", sheet.encode(), "text/csv").run()
    assert not app.exception
    assert flagged(app)[0] in ("■ replace", "✖ critical")
    assert flagged_pairs(app)[0]["Decided by"].endswith("; spool not measured")
    assert "nothing was measured" not in texts(app)


def test_the_flagged_table_is_led_by_what_counts_and_says_rules_in_words(app: AppTest) -> None:
    first = flagged_pairs(app)[0]
    shares = [f"Share, {label}" for label in ("driving in second, 80 °C", "hot idle in drive, 100 °C")]
    assert list(first)[:4] == ["Verdict", "Pair", *shares]
    assert first["Pair"] == "25/1 main pressure valve"
    assert first[shares[1]] == "■ 6.58\u00a0%"
    assert first["Decided by"].startswith("share of the pump's flow, one land 6.6\u00a0% (limit 4.0\u00a0%), hot idle")
    assert "Lands that cost it" not in {column for frame in app.dataframe for column in frame.value}


def test_a_step_that_lowers_no_total_says_why_it_is_on_the_list(app: AppTest, four_speed: Controller) -> None:
    land = four_speed.land("5", 1)  # leaks from main into modulated pressure: nothing more is drawn from the pump
    bore = 1e3 * land.nominal_sleeve_diameter + 0.04
    lines = [f"5;piston;1;{at};{1e3 * land.nominal_diameter:.3f}\n5;sleeve;1;{at};{bore:.3f}\n" for at in (0, 90)]
    sheet = "component;part;plane;direction;diameter [mm]\n" + "".join(lines)
    uploader(app, "Measuring sheet").upload("worn.csv", sheet.encode(), "text/csv").run()
    assert "46 of 47 lands were not measured and count as new" in texts(app)
    assert "lowers no total" in next(widget.label for widget in app.checkbox if "5/1" in widget.label)
    unfold(app, "order-of-repair")
    steps = next(widget.value for widget in app.dataframe if "Helps most at" in widget.value)
    assert steps["Helps most at"].tolist() == ["for its own verdict: it draws no more from the pump than a new one"]
    assert "what is missing is taken as new" in texts(app)


def test_every_land_that_leaks_stands_beside_every_condition(app: AppTest) -> None:
    shares = ["Driving in second, 80 °C [%]", "Hot idle in drive, 100 °C [%]"]
    matrix = next(widget.value for widget in app.dataframe if shares[1] in widget.value)
    assert list(matrix)[1:3] == shares
    assert matrix.iloc[0, 0].startswith("25/1")
    totals = matrix[shares].sum()
    effect = next(rows for rows in tables(app) if "Reserve" in rows[0])
    for total, row in zip(totals, effect, strict=True):
        assert float(row["Share"].split("\u00a0")[0]) == pytest.approx(total, abs=0.2)  # of shares that are rounded
    assert "leaks into p_m, not drawn from the pump" in set(matrix.iloc[:, -1])


def test_a_complaint_leads_the_page(app: AppTest) -> None:
    assert choice(app, "Complaint").options == ["none chosen", "Slips or shifts late when hot", "Slips in second gear"]
    choice(app, "Complaint").select("slips_hot").run()
    assert not app.exception
    assert "Complaint: Slips or shifts late when hot" in [widget.value for widget in app.subheader]
    shows = "It shows at **hot idle in drive, 100 °C**. By calculation the leaks have no effect on a pressure there."
    assert shows in texts(app)
    assert "Every land that leaks there is measured." in texts(app)
    shares = ["Hot idle in drive, 100 °C [%]", "Driving in second, 80 °C [%]"]
    matrix = next(widget.value for widget in app.dataframe if shares[0] in widget.value)
    assert list(matrix)[1:3] == shares
    go(app, "2_Measure")
    assert choice(app, "Complaint").value == "slips_hot"
    choice(app, "Valve body").select("minimal_example").run()
    assert choice(app, "Complaint").value == ""
    assert choice(app, "Complaint").options == ["none chosen", "Slips or shifts late when hot"]
