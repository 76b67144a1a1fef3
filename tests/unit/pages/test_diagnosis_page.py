"""The page Diagnosis says which part it is, opens pairs, and switches repairs on and off in the job's decisions."""

from __future__ import annotations

import itertools
import json
import re

import pytest
import streamlit as st
from streamlit.testing.v1 import AppTest

from atleak.catalogue.controller import Controller
from tests.unit.pages.conftest import choice, flagged, flagged_pairs, go, part, press, tables, texts, unfold, uploader


def switches(app: AppTest) -> list[bool]:
    return [widget.value for widget in app.main.toggle]


def decisions(app: AppTest) -> dict[str, str | None]:
    return {each.pair: each.decision for each in app.session_state["job-record"].repair_decisions}


def starred(app: AppTest) -> list[float]:
    """Where the totals end with the repairs that are switched on, as the star on the bar shows it."""
    traces = [trace for each in app.get("plotly_chart") for trace in json.loads(each.proto.spec)["data"]]
    return next((trace["x"] for trace in traces if trace.get("name") == "with the repairs that are switched on"), [])


def parts_sum(app: AppTest) -> dict[str, str]:
    """The sum of the parts on the page Plan, by the state of its lines."""
    (sums,) = [table.value for table in app.dataframe if "Net" in table.value]
    return dict(zip(sums["State"], sums["Parts"], strict=True))


def drawings(app: AppTest) -> str:
    return " ".join(json.loads(each.proto.json).get("html", "") for each in app.get("bidi_component"))


def test_the_verdict_and_what_decides_are_seen_before_what_takes_longer(
    app: AppTest, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pages.shared.answer.answer_facts", lambda *_: st.stop())
    app.run()
    assert "replace" in app.title[0].value
    assert "25/1 main pressure valve decides" in texts(app)
    assert not switches(app)


def test_a_switch_changes_decisions_star_and_sums_and_undo_takes_it_back(app: AppTest) -> None:
    assert switches(app) == [True] * 5
    assert "totals and pressures are green at every condition." in texts(app)
    assert decisions(app) == {}, "nobody touched a line"
    all_on = starred(app)
    app.main.toggle[0].set_value(False).run()
    assert not app.exception
    assert switches(app) == [False, *[True] * 4]
    assert "Flagged, and brought within its limits by no line that is proposed, approved or done: 25/1." in texts(app)
    assert all(less < more for less, more in zip(all_on, starred(app), strict=True))
    off = {"25/1": None}
    assert decisions(app) == off, "the others follow the verdict as before"
    press(app, "Undo: repairs taken into the decisions")
    assert (decisions(app), starred(app)) == ({}, all_on)
    press(app, "Redo: repairs taken into the decisions")
    assert decisions(app) == off

    go(app, "5_Plan")
    assert switches(app) == [False, *[True] * 4]
    assert parts_sum(app) == {"proposed": "–"}
    first = next(widget for widget in app.main.text_input if widget.label.startswith("Price"))
    first.set_value("61,55")
    app.main.toggle[0].set_value(True).run()  # with the price still in its field
    assert not app.exception
    assert decisions(app) == off | {"25/1": "proposed"}
    assert parts_sum(app) == {"proposed": "≥ 61.55"}
    press(app, "Undo: repairs taken into the decisions")
    assert (decisions(app), switches(app)[0], parts_sum(app)) == (off, False, {"proposed": "–"})
    assert next(widget for widget in app.main.text_input if widget.label.startswith("Price")).value == "61.55"

    press(app, "Nothing")
    assert switches(app) == [False] * 5
    go(app, "4_Diagnosis")
    assert starred(app) == []
    press(app, "Undo: repairs taken into the decisions")
    assert decisions(app) == off


def test_a_fresh_start_says_which_part_it_is_and_shows_the_flagged_pairs_of_the_sample_job(app: AppTest) -> None:
    assert not app.exception
    assert [widget.value for widget in app.title] == [":red[■ replace] · provisional"]
    said = texts(app)
    for line in ("**What is wrong:** ", "**What to do:** 25/1 main pressure valve: ", "**How sure:** "):
        assert line in said
    assert re.search(r"\n\d+ ■ replace, \d+ ▲ watch of 47 measured lands; 25/1 main ", said)
    (waits,) = (switch.label for switch in app.toggle if r"as new \(can wait\)" in switch.label)
    assert waits.startswith("14/1 ")
    assert set(flagged(app)) == {"■ replace", "▲ watch"}
    assert flagged(app) == sorted(flagged(app), key=["■ replace", "▲ watch"].index)

    first = flagged_pairs(app)[0]
    shares = [f"Share, {label}" for label in ("driving in second, 80 °C", "hot idle in drive, 100 °C")]
    assert list(first)[:4] == ["Verdict", "Pair", *shares]
    assert first["Pair"] == "25/1 main pressure valve"
    assert first[shares[1]] == "■ 6.58\u00a0%"
    assert first["Decided by"].startswith("share of the pump's flow, one land 6.6\u00a0% (limit 4.0\u00a0%), hot idle")
    assert "Lands that cost it" not in {column for frame in app.dataframe for column in frame.value}

    unfold(app, "all-lands")
    shares = ["Driving in second, 80 °C [%]", "Hot idle in drive, 100 °C [%]"]
    matrix = next(widget.value for widget in app.dataframe if shares[1] in widget.value)
    assert list(matrix)[1:3] == shares
    assert matrix.iloc[0, 0].startswith("25/1")
    assert "leaks into p_m, not drawn from the pump" in set(matrix.iloc[:, -1])
    go(app, "5_Plan")
    effect = next(rows for rows in tables(app) if "Reserve" in rows[0])
    for total, row in zip(matrix[shares].sum(), effect, strict=True):
        assert float(row["Share"].split("\u00a0")[0]) == pytest.approx(total, abs=0.2)  # of shares that are rounded

    go(app, "4_Diagnosis?diagnosis=pressures#pressures-in-full")
    assert "converter, lubrication and clutch fill are not in it" in texts(app)
    part(app, "remarks")
    assert "kinds of value are assumed: neither measured nor published" in texts(app)


@pytest.mark.page("4_Diagnosis?diagnosis=lands")
def test_a_pair_is_opened_by_the_list_and_stays_open_on_every_page(app: AppTest) -> None:
    pick = choice(app, "Open a valve")
    assert pick.value is None
    assert pick.options[0].startswith("25 main")  # the worst first
    pick.select("17").run()
    assert not app.exception
    assert app.query_params["pair"] == "17"
    assert "Ovality of the bore" in drawings(app)
    unfold(app, "made-of")
    assert any("Uncertain because of" in table.value or "Source" in table.value for table in app.dataframe)
    go(app, "2_Measure")
    go(app, "4_Diagnosis")
    assert choice(app, "Open a valve").value == "17"
    choice(app, "Valve body").select("minimal_example").run()
    assert choice(app, "Open a valve").value is None


@pytest.mark.page("2_Measure")
def test_a_sheet_with_a_repeat_that_is_far_off_is_not_shown_green(app: AppTest, minimal: Controller) -> None:
    choice(app, "Valve body").select("minimal_example").run()
    lines = ["component;land;part;direction;repeat;diameter [mm]"]
    for land in minimal.lands:
        spool, sleeve = 1e3 * land.nominal_diameter, 1e3 * land.nominal_sleeve_diameter
        for side, diameter in (("spool", spool), ("sleeve", sleeve)):
            for direction, repeat in itertools.product((0, 90), (1, 2)):
                slip = 0.0095 if (land.component, side, repeat) == ("tcc_regulator", "spool", 2) else 0.0
                lines.append(f"{land.component};{land.land};{side};{direction};{repeat};{diameter + slip:.4f}")
    uploader(app, "Measuring sheet").upload("slip.csv", "\n".join(lines).encode(), "text/csv").run()
    go(app, "4_Diagnosis")
    assert not app.exception
    assert not app.success
    assert "1 in doubt, to be measured again (converter clutch regulator valve/1)" in texts(app)
    assert app.title[0].value.startswith(":blue[○ not all is sure]")


@pytest.mark.page("4_Diagnosis?diagnosis=lands")
def test_a_land_measured_on_one_part_only_is_never_called_ok_and_says_which_part_lacks(app: AppTest) -> None:
    choice(app, "Valve body").select("minimal_example").run()
    head, rows = "component;part;plane;direction;diameter [mm]\n", "accumulator;piston;1;{};17,999\n"
    spool_only = head + rows.format(0) + rows.format(90)
    uploader(app, "Measuring sheet").upload("piston.csv", spool_only.encode(), "text/csv").run()
    assert not app.exception
    assert "measured on one part only" in texts(app)
    assert app.title[0].value.startswith(":blue[○ not all is sure]")
    row = next(row for row in tables(unfold(app, "all-lands"))[-1] if row["Pair"] == "accumulator piston/1")
    assert row["Verdict"].endswith("not measured")
    assert row["Decided by"] == "sleeve not measured"
    sheet = "component;part;plane;direction;diameter [mm]\naccumulator;sleeve;1;0;18,2\naccumulator;sleeve;1;90;18,2\n"
    uploader(app, "Measuring sheet").upload("sleeve.csv", sheet.encode(), "text/csv").run()
    assert not app.exception
    assert flagged(app)[0] in ("■ replace", "✖ critical")
    assert flagged_pairs(app)[0]["Decided by"].endswith("; spool not measured")
    assert "nothing was measured" not in texts(app)


def test_a_step_that_lowers_no_total_says_why_it_is_on_the_list(app: AppTest, four_speed: Controller) -> None:
    land = four_speed.land("5", 1)  # leaks from main into modulated pressure: nothing more is drawn from the pump
    bore = 1e3 * land.nominal_sleeve_diameter + 0.04
    lines = [f"5;piston;1;{at};{1e3 * land.nominal_diameter:.3f}\n5;sleeve;1;{at};{bore:.3f}\n" for at in (0, 90)]
    sheet = "component;part;plane;direction;diameter [mm]\n" + "".join(lines)
    uploader(app, "Measuring sheet").upload("worn.csv", sheet.encode(), "text/csv").run()
    assert "46 of 47 lands were not measured and count as new" in texts(app)
    (switch,) = app.main.toggle
    assert switch.label.replace("\\", "").startswith("5/1 ")
    unfold(go(app, "5_Plan"), "order-of-repair")
    assert "Without it: no total and no pressure is worse." in texts(app)
    steps = next(widget.value for widget in app.dataframe if "Helps most at" in widget.value)
    assert steps["Helps most at"].tolist() == ["for its own verdict: it draws no more from the pump than a new one"]
    assert "what is missing is taken as new" in texts(app)


@pytest.mark.page("4_Diagnosis?diagnosis=lands")
def test_a_complaint_stands_at_the_head_and_leads_the_lands(app: AppTest) -> None:
    assert choice(app, "Complaint").options == ["none chosen", "Slips or shifts late when hot", "Slips in second gear"]
    choice(app, "Complaint").select("slips_hot").run()
    assert not app.exception
    assert texts(app).startswith("**Four-speed valve body of the source study** · **Slips or shifts late when hot**")
    assert "Complaint: Slips or shifts late when hot" in [widget.value for widget in app.header]
    shows = "It shows at **hot idle in drive, 100 °C**. By calculation the leaks have no effect on a pressure there."
    assert shows in texts(app)
    assert "Every land that leaks there is measured." in texts(app)
    unfold(app, "all-lands")
    shares = ["Hot idle in drive, 100 °C [%]", "Driving in second, 80 °C [%]"]
    matrix = next(widget.value for widget in app.dataframe if shares[0] in widget.value)
    assert list(matrix)[1:3] == shares
    go(app, "2_Measure")
    assert choice(app, "Complaint").value == "slips_hot"
    choice(app, "Valve body").select("minimal_example").run()
    assert choice(app, "Complaint").value == ""
    assert choice(app, "Complaint").options == ["none chosen", "Slips or shifts late when hot"]
