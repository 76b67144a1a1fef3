"""The page In the car: its steps, what is typed in them, what that gives, and what is refused."""

from __future__ import annotations

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st
from streamlit.testing.v1 import AppTest

from atleak.job.case import Case, SourceFile
from atleak.job.zip_file import write_job_file
from atleak.measurements.gauge_readings import RANGES, Engine, GaugeCell
from atleak.readers.gauges.typed_values import TYPED_GAUGES_FILE, TypedGauges
from pages.shared import guide
from pages.shared.typed_form import GaugeForm
from tests.unit.pages.conftest import choice, go, press, texts, unfold, uploader

PAGE = "3_In_the_car#step-gauges"
pytestmark = pytest.mark.page(PAGE)


def field(app: AppTest, label: str):
    return next(widget for widget in app.main.text_input if widget.label == label)


def tap(app: AppTest, label: str):
    return next(widget for widget in app.main.selectbox if widget.label == label)


def step_line(app: AppTest, heading: str) -> str:
    """What stands beneath the heading of a step."""
    said = [(widget.type, widget.value) for widget in app.main if widget.type in ("header", "markdown")]
    return said[said.index(("header", heading)) + 1][1]


@pytest.fixture
def page(app: AppTest) -> AppTest:
    return app


def shown(app: AppTest) -> list[dict]:
    return app.main.dataframe[0].value.to_dict("records")


def test_a_decimal_comma_is_read_and_survives_leaving_the_page(page: AppTest) -> None:
    field(page, "D, slow idle [kPa]").set_value("380,5").run()
    assert not page.exception
    (row,) = shown(page)
    assert (row["Range"], row["State"], row["Gauge [kPa]"]) == ("D", "slow idle", pytest.approx(380.5, abs=1e-9))
    assert row["Verdict"].strip() == "▲ watch"
    assert "main pressure below the permissible" in texts(page).replace("\\", "")
    go(page, "2_Measure")
    go(page, PAGE)
    assert field(page, "D, slow idle [kPa]").value == "380,5"
    assert len(shown(page)) == 1


def test_what_is_typed_is_a_job_of_its_own_and_the_sample_goes(page: AppTest) -> None:
    field(page, "R, stall [kPa]").set_value("1500").run()
    case = page.session_state["atleak"].good
    assert case.readings is None
    assert case.road_test is None
    assert b"R;stall;line;1500" in case.pressures.content
    go(page, "4_Diagnosis")
    assert not page.exception


def test_a_unit_and_further_cells_are_kept_with_what_was_typed_before(page: AppTest) -> None:
    tap(page, "Unit").select("bar").run()
    field(page, "D, slow idle [bar]").set_value("4,5").run()
    field(page, "ATF temperature [°C]").set_value("85").run()
    field(page, "D, fast idle [bar]").set_value("5").run()
    assert not page.exception
    assert [row["Gauge [kPa]"] for row in shown(page)] == pytest.approx([450.0, 500.0], abs=1e-9)
    readings = page.session_state["atleak"].good.pressures.content.decode()
    assert readings.count(";85;") == 2
    field(page, "Fast idle [rpm]").set_value("2000").run()
    assert "Expected [kPa]" in shown(page)[0]


def test_a_fold_shows_what_the_gauges_should_show(page: AppTest) -> None:
    field(page, "D, slow idle [kPa]").set_value("480").run()
    assert len(page.main.dataframe) == 1
    unfold(page, "gauge-card")
    assert not page.exception
    expected, readings = (each.value.to_dict("records") for each in page.main.dataframe[:2])
    row = next(each for each in expected if (each["Range"], each["State"]) == ("D, 3, 2, 1", "slow idle"))
    assert re.fullmatch(r"500 \(\d+–\d+\)", row["New [kPa]"])
    assert {each["New [kPa]"] for each in expected if each["Range"] == "R"} == {"not computed"}
    assert readings[0]["Reads"] == "as new"


def said_wrong(app: AppTest, label: str) -> list[str]:
    """What is said beneath a field of a value that is not taken; of no field anything is said elsewhere."""
    said = {
        widget.label: [error.value.replace("\\", "") for error in column.error]
        for column in app.main.columns
        for widget in column.text_input
    }
    everywhere = [error.value for error in app.error if re.search(r"use|not taken", error.value)]
    assert len(everywhere) == sum(map(len, said.values()))
    return said[label]


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("1.050", "'1.050' can be read in two ways"),
        ("4oo", "'4oo' is not a number"),
        ("450 miles", "'450 miles' is not a number"),
    ],
)
def test_what_is_no_pressure_is_said_once_at_its_field_and_the_others_stay(page: AppTest, text: str, why: str) -> None:
    field(page, "D, slow idle [kPa]").set_value("450").run()
    field(page, "R, slow idle [kPa]").set_value(text).run()
    assert not page.exception
    (said,) = said_wrong(page, "R, slow idle [kPa]")
    assert why in said
    assert said.startswith(f"'{text}'")
    assert said.endswith("No pressure is used.")
    assert not re.search(r"typed gauge readings|row|column", said)
    assert field(page, "R, slow idle [kPa]").value == text
    field(page, "1, slow idle [kPa]").set_value("420").run()
    assert [row["Range"] for row in shown(page)] == ["D", "1"]
    go(page, "2_Measure")
    assert not page.error
    go(page, PAGE)
    assert field(page, "R, slow idle [kPa]").value == text
    assert len(said_wrong(page, "R, slow idle [kPa]")) == 1
    field(page, "R, slow idle [kPa]").set_value("400").run()
    assert len(shown(page)) == 3
    assert not page.error


def test_the_last_good_value_of_a_field_stays_in_use(page: AppTest) -> None:
    field(page, "ATF temperature [°C]").set_value("8o").run()  # before any reading
    assert said_wrong(page, "ATF temperature [°C]")[0].endswith("No temperature is used.")
    field(page, "ATF temperature [°C]").set_value("85").run()
    field(page, "D, slow idle [kPa]").set_value("450,5").run()
    field(page, "D, slow idle [kPa]").set_value("1.050").run()
    assert said_wrong(page, "D, slow idle [kPa]")[0].endswith("450,5 kPa stays in use.")
    assert shown(page)[0]["Gauge [kPa]"] == pytest.approx(450.5, abs=1e-9)
    field(page, "ATF temperature [°C]").set_value("850").run()
    (said,) = said_wrong(page, "ATF temperature [°C]")
    assert said == "850 °C is not taken: the temperature must be from −60 to 200 °C. 85 °C stays in use."
    assert shown(page)[0]["Gauge [kPa]"] == pytest.approx(450.5, abs=1e-9)
    field(page, "D, slow idle [kPa]").set_value("450").run()
    tap(page, "Unit").select("bar").run()  # 450 kPa are no 450 bar
    assert said_wrong(page, "D, slow idle [bar]")[0].endswith("No pressure is used.")
    assert page.session_state["atleak"].good.pressures is None


def test_the_last_reading_taken_away_leaves_no_table(page: AppTest) -> None:
    field(page, "D, slow idle [kPa]").set_value("450").run()
    field(page, "D, slow idle [kPa]").set_value("xyz").run()
    field(page, "D, slow idle [kPa]").set_value("").run()
    assert not page.exception
    assert page.session_state["atleak"].good.pressures is None
    assert "xyz" not in texts(page)
    assert step_line(page, "3 Gauges").startswith("**○ not done** · Tell which circuit loses pressure")


def test_an_uploaded_table_is_shown_with_its_file_and_not_typed_over(page: AppTest) -> None:
    table = "range;slow idle [kPa];fast idle [kPa]\n" + "".join(f"{name};330;520\n" for name in ("D", "3", "2", "1"))
    uploader(page, "Gauge readings").upload("gauges.csv", table.encode(), "text/csv").run()
    assert not page.exception
    assert len(shown(page)) == 8
    assert "Read from **gauges.csv**" in texts(page).replace("\\", "")
    assert not [widget for widget in page.main.text_input if widget.label.startswith("D,")]
    assert "look at the pump first" in texts(page)
    assert "8 readings" in texts(page)


def test_circuits_have_fields_of_their_own(page: AppTest) -> None:
    choice(page, "Valve body").select("five_speed_2005").run()
    field(page, "D, slow idle [kPa]").set_value("900").run()
    tap(page, "Gauge at").select("forward_clutch").run()
    field(page, "D, slow idle [kPa]").set_value("700").run()
    assert not page.exception
    line, circuit = shown(page)
    assert (line["Tap"], circuit["Tap"]) == ("line", "forward clutch")
    assert 103.0 < circuit["Lost [kPa]"] < 230.0
    assert circuit["Past limit"].endswith("%")
    tap(page, "Gauge at").select("line").run()
    assert field(page, "D, slow idle [kPa]").value == "900"


def test_an_opened_job_shows_what_was_typed_in_it(page: AppTest) -> None:
    typed = TypedGauges({GaugeCell("D", Engine.SLOW_IDLE): "3,9"}, "bar", "85").written()
    case = Case(pressures=SourceFile(TYPED_GAUGES_FILE, typed))
    uploader(page).upload("job.zip", write_job_file(case.diagnose(), None, case), "application/zip").run()
    go(page, PAGE)
    assert not page.exception
    assert field(page, "D, slow idle [bar]").value == "3,9"
    assert field(page, "ATF temperature [°C]").value == "85"
    assert shown(page)[0]["Gauge [kPa]"] == pytest.approx(390.0, abs=1e-9)
    next(widget for widget in page.button if widget.label == "New, empty job").click().run()
    unfold(page, "step-gauges")
    assert field(page, "D, slow idle [kPa]").value == ""


TEXTS = st.text(st.characters(exclude_categories=["Cs", "Cc"]), max_size=8)


@pytest.mark.hypothesis
@given(
    st.dictionaries(
        st.builds(GaugeCell, st.sampled_from(RANGES), st.sampled_from(list(Engine))), TEXTS.filter(str.strip)
    ),
    st.sampled_from(GaugeForm.units),
    TEXTS,
)
def test_whatever_is_typed_stands_in_the_file_sign_for_sign(
    cells: dict[GaugeCell, str], unit: str, temperature: str
) -> None:
    typed = TypedGauges(unit=unit, temperature=temperature)
    for cell, text in cells.items():
        typed = typed.with_text(cell, text)
    content = typed.written()
    assert (content is None) == (not cells)
    back = TypedGauges.read(content) if content is not None else typed
    assert back is not None
    assert (dict(back.cells), back.unit, back.temperature) == (dict(typed.cells), unit, temperature)


@pytest.mark.parametrize("content", [b"", b"\xff\xfe\x00", b"range;slow idle [kPa]\nD;400\n", b'"', b"a;b;c;d;e;f\n"])
def test_another_file_is_not_taken_for_a_typed_one(content: bytes) -> None:
    assert TypedGauges.read(content) is None


# --- the steps


HEADINGS = ["1 Complaint", "2 Scan and fluid", "3 Gauges", "4 Drive", "5 Jug", "6 Vacuum"]
GUIDE = "3_In_the_car"


def steps(app: AppTest) -> dict[str, str]:
    """The line beneath each step's heading."""
    return {heading: step_line(app, heading) for heading in HEADINGS}


def opened_steps(app: AppTest) -> list[str]:
    return [name for name in guide.STEPS if app.session_state[f"step-{name}-{job(app)}"]]


def job(app: AppTest) -> int:
    return app.session_state["atleak"].generation


@pytest.mark.page(GUIDE)
def test_each_step_says_what_it_would_add_until_it_is_done_or_skipped_and_the_next_one_opens(app: AppTest) -> None:
    press(app, "New, empty job")
    assert all(line.startswith("**○ not done** · ") for line in steps(app).values())
    assert opened_steps(app) == ["complaint"]
    press(app, "Skip this step")
    assert opened_steps(app) == ["fluid"]
    assert steps(app)["1 Complaint"].startswith("**○ skipped** · ")
    text = next(widget for widget in app.text_input if widget.label == "Fault codes, separated by commas")
    text.set_value("P0730, P0871").run()
    assert steps(app)["2 Scan and fluid"] == "**P0730** · **P0871**"
    assert app.session_state["job-record"].fault_codes == ("P0730", "P0871")
    assert opened_steps(app) == ["fluid"]  # nothing opens or closes while somebody types
    press(app, "Next step")
    field(app, "D, slow idle [kPa]").set_value("380,5").run()
    assert opened_steps(app) == ["gauges"]
    assert steps(app)["3 Gauges"] == "**▲ watch** · 1 gauge reading"
    go(app, "2_Measure")
    go(app, GUIDE)
    assert opened_steps(app) == ["gauges", "drive"]  # as it was left, and what comes next
    assert steps(app)["1 Complaint"].startswith("**○ skipped** · ")
    assert not app.exception


@pytest.mark.page(GUIDE)
def test_nothing_that_was_not_measured_is_green(app: AppTest) -> None:
    press(app, "New, empty job")
    assert "●" not in "".join(steps(app).values())
    unfold(app, "step-gauges")
    choice(app, "Valve body").select("five_speed_2005").run()
    tap(app, "Gauge at").select("forward_clutch").run()
    field(app, "P, slow idle [kPa]").set_value("870").run()  # of a clutch that is not applied there
    assert steps(app)["3 Gauges"] == "**○ not measured** · 1 gauge reading"


@pytest.mark.page(GUIDE)
def test_a_complaint_is_chosen_here_or_in_the_panel(app: AppTest) -> None:
    here = next(widget for widget in app.main.selectbox if widget.label == "Complaint")
    here.select("slips_hot").run()
    assert choice(app, "Complaint").value == "slips_hot"
    assert steps(app)["1 Complaint"] == "**Slips or shifts late when hot**"
    choice(app, "Complaint").select_index(0).run()
    assert next(widget for widget in app.main.selectbox if widget.label == "Complaint").value == ""
    next(widget for widget in app.text_area).set_value("bangs into R\nonly cold").run()
    assert steps(app)["1 Complaint"] == "**bangs into R**"
    go(app, "1_Job")
    assert next(widget for widget in app.text_area if "customer" in widget.label).value == "bangs into R\nonly cold"


@pytest.mark.page(GUIDE)
def test_a_log_shows_its_findings_and_in_a_fold_its_picture(app: AppTest) -> None:
    assert steps(app)["4 Drive"].startswith("**● ok** · ")
    assert "Main pressure stayed nowhere below" in texts(app)
    assert "What happened" not in [widget.value for widget in app.header]
    unfold(app, "log-in-full")
    assert "What happened" in [widget.value for widget in app.header]


@pytest.mark.page(GUIDE)
def test_a_flow_in_a_jug_is_typed_and_bounds_what_is_left(app: AppTest) -> None:
    press(app, "New, empty job")
    choice(app, "Valve body").select("five_speed_2005").run()
    unfold(app, "step-jug")
    field(app, "cooler [l/min]").set_value("3,8").run()
    assert steps(app)["5 Jug"] == "**1 flow**"
    (row,) = app.main.dataframe[0].value.to_dict("records")
    assert row["Operating point"].startswith("hot idle in drive")
    assert "at least " in "".join(map(str, row.values()))
    tap(app, "Caught at").select("reverse_idle").run()
    field(app, "cooler [l/min]").set_value("a lot").run()
    assert app.main.error[0].value.startswith("'a lot' is not a number")
    assert app.session_state["atleak"].good.flows.content.splitlines()[2:] == [b"hot_idle;cooler;3,8"]
    go(app, "2_Measure")
    go(app, GUIDE)
    tap(app, "Caught at").select("reverse_idle").run()
    assert field(app, "cooler [l/min]").value == "a lot"
    tap(app, "Unit").select("gpm").run()
    assert field(app, "cooler [gpm]").value == "a lot"
    assert app.session_state["atleak"].good.flows.content.splitlines()[2:] == [b"hot_idle;cooler;3,8"]


@pytest.mark.page(GUIDE)
def test_a_vacuum_test_is_typed_and_waits_for_what_the_stand_draws(app: AppTest) -> None:
    press(app, "New, empty job")
    choice(app, "Valve body").select("five_speed_2005").run()
    unfold(app, "step-vacuum")
    field(app, "forward clutch, as found [in-Hg]").set_value("17,5").run()
    assert app.main.error[0].value.startswith("Nothing tells how much air the stand draws")
    assert app.session_state["atleak"].good.vacuum is None
    assert steps(app)["6 Vacuum"].startswith("**○ not done** · ")
    field(app, "Orifice of the stand [mm]").set_value("0,5").run()
    assert not app.error
    assert steps(app)["6 Vacuum"].endswith(" · 1 vacuum reading")
    tap(app, "Plugged").select("manual_valve").run()
    field(app, "manual valve/1, as found [in-Hg]").set_value("28").run()  # over the usual supply
    assert "than the stand's supply" in app.main.error[0].value
    field(app, "Supply, the stand closed [in-Hg]").set_value("28.5").run()
    assert not app.error
    go(app, "2_Measure")
    go(app, GUIDE)
    assert field(app, "forward clutch, as found [in-Hg]").value == "17,5"
    assert [each.target for each in app.session_state["atleak"].results[-1].vacuum_table.readings] == [
        "forward_clutch",
        "manual_valve/1",
    ]


@pytest.mark.page(GUIDE)
def test_files_of_each_step_find_their_places(app: AppTest) -> None:
    press(app, "New, empty job")
    choice(app, "Valve body").select("five_speed_2005").run()
    vacuum = b"supply;25;in-Hg\norifice;0,5;mm\ncircuit or land;reading [in-Hg]\nforward_clutch;17,5\n"
    flows = b"condition;what;value [l/min]\nhot_idle;cooler;1,9\n"
    unfold(app, "step-jug")
    zone = next(each for each in app.main.file_uploader)
    zone.set_value([("a.csv", vacuum, ""), ("b.csv", flows, "")]).run()
    assert not app.exception
    assert steps(app)["5 Jug"] == "**1 flow**"
    assert steps(app)["6 Vacuum"].endswith(" · 1 vacuum reading")
    said = texts(app)
    assert "**a.csv** · 1 vacuum reading" in said
    assert "Read from **b.csv**" in said


@pytest.mark.page(GUIDE)
def test_the_last_step_says_what_is_likely_worn_and_leads_to_the_readings(app: AppTest) -> None:
    press(app, "New, empty job")
    choice(app, "Valve body").select("five_speed_2005").run()
    unfold(app, "step-open")
    assert "this is what is assumed of any used unit" in texts(app)
    unfold(app, "step-gauges")
    field(app, "D, slow idle [kPa]").set_value("860").run()
    tap(app, "Gauge at").select("forward_clutch").run()
    field(app, "D, slow idle [kPa]").set_value("735").run()
    assert "Forward clutch has lost" in texts(app)
    assert "To the readings" in [link.proto.label for link in app.main.get("page_link")]
