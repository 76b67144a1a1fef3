"""The dashboard's pages run in Streamlit's own test harness."""

from __future__ import annotations

import io
import re
from pathlib import Path

import openpyxl
import plotly.graph_objects as plotly_objects
import pytest
from streamlit.testing.v1 import AppTest

from atleak.catalogue.controller import Controller
from atleak.catalogue.entries import catalogue_files
from atleak.common.style import PAPER_INKS
from atleak.common.wording import wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.report.charts.drawing import controller_svg, on_dark, spool_svg
from atleak.report.charts.land_figures import land_wear, leakage_ranking
from atleak.report.sheets.measuring_sheet import write_template
from tests.unit.pages.conftest import (
    ROOT,
    choice,
    flagged,
    flagged_pairs,
    go,
    number,
    settle,
    tables,
    texts,
    unfold,
    uploader,
)

PAGES = (
    "0_Start", "1_Job", "22_Settings",
    "4_Diagnosis", "2_Readings", "21_Uncertainty", "3_Road_test", "6_Report", "28_Source_study", "26_Catalogue",
    "20_Pressures", "5_What_if", "27_Transmission", "10_Job_book", "11_Unit", "12_Compare", "13_Estimate",
    "14_Fleet",
    "23_Gauge_study", "24_Workshop_data",
)  # fmt: skip
WATCH = "watch = { percent = 10.0, at_least_um = 4.0 }"  # of the default limits
XLSX = "application/vnd.openxmlformats-officedocument.spreadsheetml.sheet"


def test_a_fresh_start_shows_flagged_pairs_of_the_sample_job(app: AppTest) -> None:
    assert not app.exception
    assert set(flagged(app)) == {"■ replace", "▲ watch"}
    assert flagged(app) == sorted(flagged(app), key=["■ replace", "▲ watch"].index)
    assert [widget.value for widget in app.title] == ["Diagnosis"]
    counted = r"\*\*■ replace · provisional:\*\* \d+ ■ replace, \d+ ▲ watch of 47 measured lands; 25/1 main "
    assert re.match(counted, app.error[0].value)
    assert "converter, lubrication and clutch fill are not in it" in texts(app)
    assert "Representative" in texts(app) or "representative" in texts(app)


@pytest.mark.parametrize("page", [pytest.param(page, marks=pytest.mark.page(page)) for page in PAGES])
def test_every_page_runs_with_the_sample_and_with_nothing(app: AppTest, page: str) -> None:
    assert not app.exception
    choice(app, "Valve body").select("minimal_example").run()
    assert not app.exception
    assert not app.error or "not" in app.error[0].value


@pytest.mark.parametrize(
    ("page", "breaks"),
    [
        pytest.param("3_Road_test", "pages.shared.road.findings", marks=pytest.mark.page("1_Job")),
        pytest.param("4_Diagnosis", "atleak.report.json.diagnosis.diagnosis_record", marks=pytest.mark.page("1_Job")),
        pytest.param("5_What_if", "pages.shared.what_if_form.draw", marks=pytest.mark.page("1_Job")),
        pytest.param("6_Report", "pages.shared.conditions.undecided", marks=pytest.mark.page("1_Job")),
    ],
)
def test_a_fault_of_atleak_is_a_message_on_its_page(
    app: AppTest, page: str, breaks: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fault(*_: object, **__: object) -> None:
        raise ValueError("index values must not have NaT")

    monkeypatch.delenv("ATLEAK_TRACEBACK")
    monkeypatch.setattr(breaks, fault)
    go(app, page)
    assert not app.exception
    assert app.error[-1].value.startswith("unexpected ValueError")
    assert "index values must not have NaT. This is a fault of atleak" in app.error[-1].value
    go(app, "1_Job")
    assert not app.error


def test_every_page_has_a_number_of_its_own() -> None:
    stems = [path.stem for path in (ROOT / "pages").glob("[0-9]*.py")]
    assert sorted(stems) == sorted(PAGES)
    assert len({int(name.split("_")[0]) for name in stems}) == len(stems)


@pytest.mark.parametrize("page", PAGES)
def test_pages_are_short_and_compute_nothing(page: str) -> None:
    text = (ROOT / "pages" / f"{page}.py").read_text(encoding="utf-8")
    assert len(text.splitlines()) <= 90
    assert "numpy" not in text
    assert "open(" not in text


def test_another_controller_drops_the_samples_files_and_offers_its_own_sheet(app: AppTest) -> None:
    choice(app, "Valve body").select("minimal_example").run()
    assert "nothing was measured" in texts(app)
    sheet = "component;part;plane;direction;diameter [mm]\n" + "".join(
        f"accumulator;{part};1;{direction};{size}\n"
        for part, size in (("piston", "18,000"), ("sleeve", "18,070"))
        for direction in (0, 90)
    )
    uploader(app, "Measuring sheet").upload("eigene.csv", sheet.encode(), "text/csv").run()
    assert not app.exception
    assert "eigene.csv" in texts(app)
    assert flagged(app) == ["■ replace"]


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


def test_a_refused_sheet_is_explained_and_the_last_job_stays(app: AppTest) -> None:
    before = app.dataframe[0].value
    target = io.BytesIO()
    openpyxl.Workbook().save(target)
    uploader(app, "Measuring sheet").upload("leer.xlsx", target.getvalue(), XLSX).run()
    assert not app.exception
    assert "leer.xlsx was not taken as measuring sheet" in texts(app)
    assert "the workbook is empty" in texts(app)
    assert app.dataframe[0].value.equals(before)
    assert "Sample job" in texts(app)
    uploader(app, "Measuring sheet").set_value(None).run()
    assert "not taken" not in texts(app)


def without_its_valve_body(sheet: bytes) -> bytes:
    """The same sheet with no valve body named at its head."""
    book = openpyxl.load_workbook(io.BytesIO(sheet))
    for row in book["Measurements"].iter_rows(max_row=8):
        for cell in row:
            if isinstance(cell.value, str) and "five_speed_2005" in cell.value:
                cell.value = None
    target = io.BytesIO()
    book.save(target)
    return target.getvalue()


@pytest.mark.page("2_Readings")
def test_a_sheet_for_another_valve_body_is_taken_when_that_one_is_chosen(app: AppTest) -> None:
    sheet = (ROOT / "sample_data" / "measuring_sheet_five_speed.xlsx").read_bytes()
    uploader(app).upload("five.xlsx", without_its_valve_body(sheet), XLSX).run()
    assert "five.xlsx was not taken as measuring sheet" in texts(app)
    assert "Sample job" in texts(app)
    choice(app, "Valve body").set_value("five_speed_2005").run()
    assert not app.exception
    assert "was not taken" not in texts(app)
    assert "**five.xlsx** · 34 of 34 lands measured" in texts(app)


@pytest.mark.page("2_Readings")
def test_a_sheet_whose_head_names_another_valve_body_chooses_it_and_tells_whose_unit_it_is(app: AppTest) -> None:
    sheet = (ROOT / "sample_data" / "measuring_sheet_five_speed.xlsx").read_bytes()
    uploader(app).upload("five.xlsx", sheet, XLSX).run()
    assert not app.exception
    assert "Taken into the job from the head of the sheet: job number, vehicle, mileage, instrument." in texts(app)
    assert app.session_state["job-record"].vehicle.mileage_km == 212_000.0
    assert choice(app, "Valve body").value == "five_speed_2005"
    assert "The sheet's head names the valve body five_speed_2005: it was chosen." in texts(app)
    assert "**five.xlsx** · 34 of 34 lands measured" in texts(app)
    press(app, "Undo: five.xlsx taken in")
    assert app.session_state["job-record"].empty
    assert choice(app, "Valve body").value == "four_speed_2023"
    assert "Sample job" in texts(app)


@pytest.mark.page("22_Settings")
def test_of_files_dropped_at_once_each_is_taken_or_named(app: AppTest) -> None:
    sheet = (ROOT / "sample_data" / "measuring_sheet_five_speed.xlsx").read_bytes()
    own = catalogue_files("limits")["project_default"].read_text(encoding="utf-8").replace(WATCH, 'watch = "ten"')
    files = {"scan.pdf": b"%PDF-1.4", "notes.txt": b"hello\n", "five.xlsx": sheet, "bad.toml": own.encode()}
    uploader(app).upload_all({**files, "record.json": b'{"numbr": 1, "notes": ""}'}).run()
    assert not app.exception
    assert app.session_state["atleak"].good.readings.name == "five.xlsx"
    assert choice(app, "Valve body").value == "five_speed_2005"
    said = texts(app)
    assert "notes.txt was not taken as road-test log" in said
    assert "scan.pdf was left out: notes.txt came with it" in said
    assert "bad.toml was not taken" in said
    assert "record.json was not taken" in said
    press(app, "Undo: bad.toml, record.json, five.xlsx, scan.pdf, notes.txt taken in")
    assert app.session_state["atleak"].good.sample


@pytest.mark.page("22_Settings")
def test_a_valve_body_of_ones_own_stays_where_a_sheet_for_it_is_refused(app: AppTest) -> None:
    own = catalogue_files("controllers")["minimal_example"].read_bytes()
    uploader(app).upload_all({"own.toml": own, "bad.csv": b"component;part;diameter [mm]\nnone;piston;18,0\n"}).run()
    assert not app.exception
    assert "bad.csv was not taken as measuring sheet" in texts(app)
    assert app.session_state["atleak"].good.controller.name == "own.toml"


@pytest.mark.page("2_Readings")
def test_an_unfilled_template_is_refused_by_name(app: AppTest, four_speed) -> None:
    uploader(app, "Measuring sheet").upload("blank.xlsx", write_template(four_speed), XLSX).run()
    assert "every diameter is empty" in texts(app)


def test_own_files_replace_the_sample_one_by_one(app: AppTest, sample_readings: Path, sample_log: Path) -> None:
    uploader(app, "Measuring sheet").upload("mine.xlsx", sample_readings.read_bytes(), XLSX).run()
    assert "Over the road test" not in [widget.value for widget in app.subheader]
    uploader(app, "Road-test log").upload("drive.csv", sample_log.read_bytes(), "text/csv").run()
    assert not app.exception
    assert "Over the road test" in [widget.value for widget in app.subheader]
    assert "1201 rows" in texts(app)
    uploader(app, "Road-test log").set_value(None).run()
    assert "Over the road test" not in [widget.value for widget in app.subheader]
    next(widget for widget in app.button if widget.label == "Take the sample job").click().run()
    assert "Sample job" in texts(app)
    assert "Over the road test" in [widget.value for widget in app.subheader]


def test_choices_and_digits_survive_a_page_change(app: AppTest) -> None:
    number(app, "Temperature [°C]").set_value("92.715").run()
    settle(app, "4_Diagnosis", "Fluid", "mobil_atf_220")
    shown = app.dataframe[0].value
    assert "92.715 °C" in texts(app)
    go(app, "2_Readings")
    go(app, "4_Diagnosis")
    assert number(app, "Temperature [°C]").value == "92.715"
    assert "92.715 °C" in texts(app)
    assert app.dataframe[0].value.equals(shown)
    go(app, "22_Settings")
    assert choice(app, "Fluid").value == "mobil_atf_220"


def test_a_temperature_outside_the_fluid_keeps_the_last_result(app: AppTest) -> None:
    before = app.dataframe[0].value
    number(app, "Temperature [°C]").set_value("190.0").run()
    assert not app.exception
    assert "cannot be computed" in texts(app)
    assert "190 °C" in texts(app)
    assert app.dataframe[0].value.equals(before)
    number(app, "Temperature [°C]").set_value("95.0").run()
    assert "cannot be computed" not in texts(app)


def doubts(app: AppTest) -> list[str]:
    return [widget.value.replace("\\", "") for widget in (*app.sidebar.error, *app.sidebar.warning)]


@pytest.mark.page("2_Readings")
def test_a_mileage_that_can_be_read_in_two_ways_is_asked_and_the_last_one_stays(app: AppTest) -> None:
    number(app, "Mileage [km]").set_value("106 315").run()
    assert app.session_state["atleak"].good.mileage == 106315.0
    assert doubts(app) == []
    number(app, "Mileage [km]").set_value("123.456").run()
    go(app, "26_Catalogue")
    go(app, "2_Readings")
    assert not app.exception
    assert app.session_state["atleak"].good.mileage == 106315.0
    assert number(app, "Mileage [km]").value == "123.456"
    (doubt,) = doubts(app)
    assert "write 123456 for 123456 km, or 123.4560 for 123.456 km. 106315 km stays in use." in doubt
    number(app, "Mileage [km]").set_value("").run()
    assert app.session_state["atleak"].good.mileage is None
    assert doubts(app) == []


@pytest.mark.page("2_Readings")
def test_a_wrong_entry_leaves_the_result_and_an_unusual_one_says_so(app: AppTest) -> None:
    before = app.session_state["atleak"].good
    for text in ("955", "abc", "", "1e999"):
        number(app, "Temperature [°C]").set_value(text).run()
        assert not app.exception
        assert len(doubts(app)) == 1
        assert "80 °C stays in use" in doubts(app)[0]
        assert app.session_state["atleak"].good == before
    number(app, "Temperature [°C]").set_value("80").run()
    number(app, "Engine speed [rpm]").set_value("8505").run()
    assert app.session_state["atleak"].good.engine_speed * 60.0 == pytest.approx(8505.0, abs=1e-6)
    assert "8505 rpm is taken, but unusual" in doubts(app)[0]


def test_no_page_has_a_number_field_of_another_kind() -> None:
    for path in (ROOT / "pages").rglob("*.py"):
        text = path.read_text(encoding="utf-8")
        assert "number_input" not in text, path.name
        assert "data_editor" not in text or "NumberColumn" not in text, path.name  # a table that is only read may


def test_profile_options_reach_the_engine(app: AppTest) -> None:
    settle(app, "4_Diagnosis", "Profile", "paper")
    assert "Profile: **paper**" in texts(app)
    settle(app, "22_Settings", "Diameter in the gap law", "mean")
    settle(app, "4_Diagnosis", "Loss at a gap's entry and exit", "on")
    assert "paper, diameter=mean, entry_loss=on" in texts(app)


@pytest.mark.page("22_Settings")
def test_where_the_spools_lie_can_be_unknown(app: AppTest) -> None:
    def position():
        return next(widget for widget in app.toggle if "spools lie" in widget.label)

    def ratio():
        return next(widget for widget in app.slider if widget.label == "Eccentricity e/c")

    def options() -> dict:
        return dict(app.session_state["atleak"].good.options)

    ratio().set_value(0.4).run()
    assert options() == {"eccentricity": 0.4}
    position().set_value(True).run()
    assert options() == {"eccentricity": "unknown"}
    assert ratio().disabled
    position().set_value(False).run()
    assert options() == {"eccentricity": 0.4}
    go(app, "4_Diagnosis")
    assert "workshop, eccentricity=0.4" in texts(app)


def test_the_state_of_the_fluid_is_asked_and_reaches_the_result(app: AppTest) -> None:
    assert "taken as fresh (not stated)" in texts(app)
    go(app, "22_Settings")
    states = next(widget for widget in app.radio if widget.label == "The fluid is")
    assert states.value is None
    states.set_value("used").run()
    assert not app.exception
    go(app, "4_Diagnosis")
    assert "after 106 315 km" in texts(app)
    assert "taken as fresh" not in "".join(widget.value for widget in app.main.caption)
    go(app, "22_Settings")
    assert next(widget for widget in app.radio if widget.label == "The fluid is").value == "used"


def test_own_limits_are_taken_by_upload_and_bad_ones_explained(app: AppTest) -> None:
    text = (ROOT / "atleak" / "catalogue" / "limits" / "project_default.toml").read_text(encoding="utf-8")
    uploader(app).upload("strict.toml", text.replace(WATCH, "watch = 1.0").encode(), "text/plain").run()
    assert not app.exception
    more = len(flagged(app))
    assert more > 8
    uploader(app).upload("bad.toml", text.replace(WATCH, 'watch = "ten"').encode(), "text/plain").run()
    assert not app.exception
    assert "bad.toml" in texts(app)
    assert "wear_percent" in texts(app)
    assert len(flagged(app)) == more


@pytest.mark.page("2_Readings")
@pytest.mark.parametrize("name", ["a:b?.toml", "con", "x" * 300 + ".toml", "two\nlines.toml"])
def test_an_own_files_name_is_shown_and_never_a_path(app: AppTest, name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    written: list[str] = []
    write = Path.write_bytes
    monkeypatch.setattr(Path, "write_bytes", lambda path, data: written.append(path.name) or write(path, data))
    text = (ROOT / "atleak" / "catalogue" / "limits" / "project_default.toml").read_text(encoding="utf-8")
    uploader(app).upload(name, text.replace(WATCH, "watch = 1.0").encode(), "text/plain").run()
    assert not app.exception
    taken = app.session_state["atleak"].good.limits
    assert (taken.name, b"watch = 1.0" in taken.content) == (name, True)
    uploader(app).upload(name, text.replace(WATCH, 'watch = "ten"').encode(), "text/plain").run()
    assert any(name.replace("\n", "  \n") in widget.value.replace("\\", "") for widget in app.error)
    assert len(written) == 2
    assert {name} & set(written) == set()


@pytest.mark.page("2_Readings")
def test_a_workbook_with_two_filled_sheets_is_settled_by_the_form(app: AppTest, sample_readings: Path) -> None:
    book = openpyxl.load_workbook(sample_readings)
    book.copy_worksheet(book["Measurements"]).title = "Second try"
    target = io.BytesIO()
    book.save(target)
    uploader(app, "Measuring sheet").upload("two.xlsx", target.getvalue(), XLSX).run()
    assert "2 sheets hold readings" in texts(app)
    next(widget for widget in app.main.text_input if widget.label == "Sheet").set_value("Second try")
    next(widget for widget in app.button if widget.label == "Read two.xlsx again").click().run()
    assert not app.exception
    assert "not taken" not in texts(app)
    assert "two.xlsx**, sheet Second try" in texts(app)


@pytest.mark.page("2_Readings")
def test_a_files_name_is_shown_sign_for_sign(app: AppTest, sample_log: Path) -> None:
    name = "<b>x $y$ :red[z] *w* [a](b) `c`.csv"
    uploader(app, "Road-test log").upload(name, sample_log.read_bytes(), "text/csv").run()
    assert not app.exception
    shown = next(widget.value for widget in app.sidebar.caption if "1201 rows" in widget.value)
    for sign in ("\\<b\\>", "\\$y\\$", "\\:red\\[z\\]", "\\*w\\*", "\\`c\\`"):
        assert sign in shown


def bad_file(slot: str) -> tuple[str, bytes, str]:
    target = io.BytesIO()
    openpyxl.Workbook().save(target)
    return ("bad.xlsx", target.getvalue(), XLSX) if slot == "Measuring sheet" else ("bad.csv", b"no log\n", "text/csv")


@pytest.mark.parametrize("slot", ["Measuring sheet", "Road-test log"])
def test_a_bad_file_in_place_of_an_own_good_one_leaves_the_good_one(
    app: AppTest, sample_readings: Path, sample_log: Path, slot: str
) -> None:
    uploader(app, "Measuring sheet").upload("mine.xlsx", sample_readings.read_bytes(), XLSX).run()
    uploader(app, "Road-test log").upload("drive.csv", sample_log.read_bytes(), "text/csv").run()
    before, said = app.dataframe[0].value, app.error[0].value
    uploader(app, slot).set_value(bad_file(slot)).run()
    assert not app.exception
    assert "was not taken" in texts(app)
    mine = "mine.xlsx" if slot == "Measuring sheet" else "drive.csv"
    assert f"Shown are still the results of {mine}" in texts(app)
    assert app.dataframe[0].value.equals(before)
    assert said in [widget.value for widget in app.error]
    uploader(app, slot).set_value(None).run()
    assert "was not taken" not in texts(app)
    assert app.dataframe[0].value.equals(before)
    assert app.session_state["atleak"].good.road_test.name == "drive.csv"


@pytest.mark.page("2_Readings")
def test_a_sheet_that_was_taken_away_comes_back_by_undo_alone(app: AppTest, sample_readings: Path) -> None:
    uploader(app, "Measuring sheet").upload("mine.xlsx", sample_readings.read_bytes(), XLSX).run()
    uploader(app, "Measuring sheet").set_value(None).run()
    uploader(app, "Measuring sheet").set_value(bad_file("Measuring sheet")).run()
    assert "The job is as it was" in texts(app)
    assert app.session_state["atleak"].good.readings is None
    press(app, "Undo: mine.xlsx taken away")
    assert app.session_state["atleak"].good.readings.name == "mine.xlsx"


def press(app: AppTest, label: str) -> AppTest:
    return next(widget for widget in app.button if widget.label.replace("\\", "") == label).click().run()


@pytest.mark.page("1_Job")
@pytest.mark.parametrize("label", ["New, empty job", "Take the sample job"])
def test_another_job_has_an_empty_record(app: AppTest, sample_readings: Path, label: str) -> None:
    settle(app, "1_Job", "Fluid", "mobil_atf_220")
    uploader(app, "Measuring sheet").upload("mine.xlsx", sample_readings.read_bytes(), XLSX).run()
    number(app, "Mileage [km]").set_value("120000.0").run()
    next(widget for widget in app.text_input if widget.label == "Technician").set_value("T. Old").run()
    assert app.session_state["job-record"].technician == "T. Old"
    press(app, label)
    assert not app.exception
    assert next(widget for widget in app.text_input if widget.label == "Technician").value == ""
    assert app.session_state["job-record"].empty
    assert number(app, "Mileage [km]").value == ""
    case = app.session_state["atleak"].good
    assert case.sample == (label != "New, empty job")
    if not case.sample:
        assert (case.readings, case.road_test, case.fluid) == (None, None, "mobil_atf_220")
    press(app, f"Undo: {label.lower() if 'New' in label else 'sample job taken'}")
    assert next(widget for widget in app.text_input if widget.label == "Technician").value == "T. Old"
    assert number(app, "Mileage [km]").value == "120000"
    assert app.session_state["atleak"].good.readings.name == "mine.xlsx"


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
    go(app, "2_Readings")
    assert choice(app, "Complaint").value == "slips_hot"
    choice(app, "Valve body").select("minimal_example").run()
    assert choice(app, "Complaint").value is None
    assert choice(app, "Complaint").options == ["none chosen", "Slips or shifts late when hot"]


@pytest.mark.page("2_Readings")
def test_a_valve_body_without_complaints_says_so(app: AppTest) -> None:
    text = (ROOT / "atleak" / "catalogue" / "controllers" / "minimal_example.toml").read_text(encoding="utf-8")
    head, _, rest = text.partition("[[complaints]]")
    bare = head + rest[rest.index("[[components]]") :]
    uploader(app).upload("bare.toml", bare.encode(), "text/plain").run()
    assert not app.exception
    assert choice(app, "Complaint").disabled
    assert "maps no complaint" in choice(app, "Complaint").help


@pytest.mark.page("22_Settings")
def test_options_have_plain_labels_and_keep_their_value_in_the_help(app: AppTest) -> None:
    box = choice(app, "Viscosity")
    assert box.options[0] == "ASTM D341"
    assert "viscosity=d341" in box.help
    assert choice(app, "Pump efficiency").options[0] == "Wilson slip"
    for label in ("Diameter in the gap law", "Viscosity", "Counted as drawn from the pump", "Pump efficiency"):
        assert not any("_" in option for option in choice(app, label).options)


def test_means_have_sensible_digits() -> None:
    from pages.shared.show import rounded

    assert [rounded(value) for value in (2.8, 1.6512, 92.715, 99.97, 2345.6, 0.0, -0.0, 1e-9)] == [
        "2.8", "1.65", "92.7", "100", "2346", "0.000", "0.000", "0.000",
    ]  # fmt: skip


@pytest.mark.parametrize(("theme", "paper"), [("light", "#ffffff"), ("dark", "#10171c")])
def test_a_charts_words_stand_out_from_its_ground(
    sample: Diagnosis, monkeypatch: pytest.MonkeyPatch, theme: str, paper: str
) -> None:
    from pages.shared import show

    def luminance(colour: str) -> float:
        parts = [int(colour[at : at + 2], 16) / 255.0 for at in (1, 3, 5)]
        linear = [part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts]
        return sum(weight * part for weight, part in zip((0.2126, 0.7152, 0.0722), linear, strict=True))

    def contrast(colour: str) -> float:
        low, high = sorted((luminance(colour), luminance(paper)))
        return (high + 0.05) / (low + 0.05)

    drawn = []
    monkeypatch.setattr(show, "dark", lambda: theme == "dark")
    monkeypatch.setattr(show.st, "plotly_chart", lambda figure, key: drawn.append(figure))
    show.chart(leakage_ranking(sample), "any")
    figure = plotly_objects.Figure(drawn[0].to_dict())
    bars = [trace for trace in figure.data if trace.type == "bar"]
    inks = [figure.layout.xaxis.tickfont.color, figure.layout.yaxis.title.font.color, figure.layout.legend.font.color]
    inks += [bar.error_x.color for bar in bars]
    assert len(bars) > 1
    assert min(contrast(ink) for ink in inks) >= 4.5


def test_a_charts_numbers_have_the_readers_decimal_sign_and_no_finger_zooms_it(
    sample: Diagnosis, monkeypatch: pytest.MonkeyPatch
) -> None:
    from pages.shared import show

    drawn = []
    monkeypatch.setattr(show, "dark", lambda: False)
    monkeypatch.setattr(show.reader, "say", lambda: wording("de"))
    monkeypatch.setattr(show.st, "plotly_chart", lambda figure, key: drawn.append(figure.to_dict()["layout"]))
    show.chart(leakage_ranking(sample), "any")
    assert drawn[0]["separators"] == ",\u00a0"
    assert drawn[0]["dragmode"] is False


def test_of_a_chart_without_a_point_no_axes_are_drawn(unmeasured: Diagnosis, monkeypatch: pytest.MonkeyPatch) -> None:
    from pages.shared import show

    said = []
    monkeypatch.setattr(show, "dark", lambda: False)
    monkeypatch.setattr(show.st, "plotly_chart", lambda figure, key: pytest.fail("empty axes"))
    monkeypatch.setattr(show.st, "caption", said.append)
    show.chart(land_wear(unmeasured), "any", empty="Nothing measured.")
    assert said == ["Nothing measured."]


def test_a_drawing_on_a_dark_ground_has_light_words(four_speed) -> None:
    for drawing in (spool_svg(four_speed, "25"), controller_svg(four_speed)):
        assert PAPER_INKS.ink in drawing
        assert PAPER_INKS.ink not in on_dark(drawing)
        assert 'rx="4" fill="#FFFFFF"' not in on_dark(drawing)


@pytest.mark.page("3_Road_test")
def test_moving_the_cursors_diagnoses_and_reads_nothing_again(app: AppTest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Only the leakage between them is computed, by the engine that the diagnosis keeps."""

    def again(*_: object, **__: object) -> None:
        raise AssertionError("the whole job is worked on again")

    works = "job.case.diagnose", "diagnosis.examination.assess", "job.case.understand", "job.case.read_readings"
    for worked in works:
        monkeypatch.setattr(f"atleak.{worked}", again)
    for reading in ("understand", "read_readings"):
        monkeypatch.setattr(f"pages.shared.cases.{reading}", again)
    whole = app.dataframe[-1].value
    cursors = next(widget for widget in app.main.slider if "cursors" in widget.label)
    cursors.set_value((3.0, 9.0)).run()
    assert not app.exception
    assert not app.dataframe[-1].value.equals(whole)
