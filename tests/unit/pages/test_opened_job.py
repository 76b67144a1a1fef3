"""A job file opened in the dashboard: the same verdict, and a panel that starts from the job."""

from __future__ import annotations

import io
from dataclasses import replace
from pathlib import Path

import openpyxl
import pytest
from streamlit.testing.v1 import AppTest

from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.entries import catalogue_files
from atleak.catalogue.fluid import load_fluid
from atleak.catalogue.instruments import load_instruments
from atleak.catalogue.limits import load_limits
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.diagnosis.uncertainty import DEFAULTS
from atleak.engine.profile import PROFILES
from atleak.engine.projection import stated_condition
from atleak.job.case import Case, SourceFile, load_source, pairs_of
from atleak.job.zip_file import read_job_file, write_job_file
from atleak.measurements.job_card import Job
from atleak.readers.logs import default_path, read_road_test, remember, understand
from atleak.readers.sheets.measuring_sheet import read_readings
from atleak.report.json.diagnosis import diagnosis_record
from tests.unit.pages.conftest import ROOT, go, uploader

pytestmark = pytest.mark.page("2_Measure")
LOG = (
    "time [s];engine_speed [rpm];line pressure 1 [kPa];line pressure 2 [kPa];gear\n"
    + "".join(f"{step / 10};{800 + step};{600 + step};{900 - step};2\n" for step in range(100))
).encode()
CHOICES = {"mapping": {"main_pressure": "line pressure 2 [kPa]"}, "units": {}, "constants": {"atf_temperature": 81.5}}
SHEET = {"sheet": "Second try", "unit": None}


@pytest.fixture(scope="module")
def sheet() -> bytes:
    """A workbook with two filled sheets, of which only the user can say which one counts."""
    book = openpyxl.load_workbook(ROOT / "sample_data" / "measuring_sheet_four_speed.xlsx")
    book.copy_worksheet(book["Measurements"]).title = "Second try"
    target = io.BytesIO()
    book.save(target)
    return target.getvalue()


@pytest.fixture(scope="module")
def own_limits() -> bytes:
    text = catalogue_files("limits")["project_default"].read_text(encoding="utf-8")
    return text.replace("watch = { percent = 10.0, at_least_um = 4.0 }", "watch = 2.0").encode()


@pytest.fixture(scope="module")
def diagnosis(sheet: bytes, own_limits: bytes) -> Diagnosis:
    """A job in which nothing is as it is by default."""
    controller = load_controller("four_speed_2023")
    return diagnose(
        controller,
        load_fluid("mobil_atf_220"),
        load_source(load_limits, SourceFile("our limits.toml", own_limits)),
        readings=read_readings(sheet, controller, name="two.xlsx", **SHEET),
        road_test=read_road_test(LOG, name="drive.csv", **CHOICES),
        profile=PROFILES["paper"].with_options(diameter="mean", eccentricity=0.33, entry_loss="on"),
        condition=stated_condition(controller, temperature=92.715, engine_speed=1234.5 / 60.0, gear=1),
        mileage_km=106_315.0,
        instruments=load_instruments("micrometer", "air_gauge"),
        assumptions=DEFAULTS.with_settings({"viscosity_percent": 7.0}),
        guard_factor=1.2,
        complaint=controller.complaint("slips_in_second"),
    )


@pytest.fixture(scope="module")
def content(diagnosis: Diagnosis, sheet: bytes, own_limits: bytes) -> bytes:
    return packed(diagnosis, sheet, own_limits)


def packed(diagnosis: Diagnosis, sheet: bytes, own_limits: bytes) -> bytes:
    return write_job_file(
        diagnosis,
        Job(number="A-17", notes="seen"),
        Case(
            mileage=106_315.0,
            readings=SourceFile("two.xlsx", sheet),
            road_test=SourceFile("drive.csv", LOG),
            limits=SourceFile("our limits.toml", own_limits),
            sheet_name=SHEET.get("sheet"),
            sheet_unit=SHEET.get("unit"),
            columns=pairs_of(CHOICES.get("mapping")),
            units=pairs_of(CHOICES.get("units")),
            constants=pairs_of(CHOICES.get("constants")),
        ),
    )


SEVERAL = (
    b"Inspection;Valve;Land;Part;Diameter [mm]\n"
    b"May;accumulator;1;piston;17.998\nMay;accumulator;1;bore;18.041\n"
    b"November;accumulator;1;piston;17.996\nNovember;accumulator;1;bore;18.050\n"
)


def test_the_rows_of_one_inspection_are_chosen_on_the_readings_page_and_kept_with_the_job(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.syspath_prepend(str(ROOT))
    script = tmp_path / "form.py"
    script.write_text(
        "from atleak.job.case import SourceFile\nfrom pages.shared import sheet_form\n"
        "from pages.shared.cases import PageCase\nfrom pages.shared.state import session\nnow = session()\n"
        "if now.case.sample:\n"
        f"    now.case = PageCase(readings=SourceFile('two.csv', {SEVERAL!r}), controller='minimal_example')\n"
        "sheet_form.draw(now.case)\n",
        encoding="utf-8",
    )
    form = AppTest.from_file(str(script), default_timeout=240).run()
    by_label = {widget.label: widget for widget in form.text_input}
    by_label["Only rows where column"].set_value("Inspection")
    by_label["says"].set_value("November")
    form.checkbox[0].check()
    form.button[0].click().run()
    assert not form.exception
    from pages.shared.cases import case_with_columns, diagnosis_of, opened_case

    case = form.session_state["atleak"].case
    assert case.sheet_where == (("Inspection", "November"),)
    diagnosis = diagnosis_of(case)
    assert [reading.place.row for reading in diagnosis.readings.readings] == [4, 5]
    again = opened_case(read_job_file(write_job_file(diagnosis, case=case_with_columns(case))).case)
    assert again.sheet_where == case.sheet_where
    assert case.sheet_fill_down
    assert again.sheet_fill_down
    without = again.with_file("readings", None)
    assert (without.sheet_where, without.sheet_fill_down) == ((), False)


def open_job(app: AppTest, content: bytes, name: str = "job.zip") -> AppTest:
    return uploader(app).upload(name, content, "application/zip").run()


def shown(app: AppTest) -> dict:
    from pages.shared.cases import diagnosis_of

    return diagnosis_record(diagnosis_of(app.session_state["atleak"].good))


def field(app: AppTest, label: str):
    kinds = (*app.selectbox, *app.text_input, *app.slider, *app.toggle)
    return next(widget for widget in kinds if widget.label == label)


def test_a_job_file_opens_to_the_same_result_and_stays_so(app: AppTest, content: bytes, diagnosis: Diagnosis) -> None:
    # what this computer remembers of such logs must not count for a job from elsewhere
    remember(default_path(), understand(LOG, name="drive.csv").signature, {"main_pressure": "line pressure 1 [kPa]"})
    open_job(app, content)
    assert not app.exception
    assert not [error.value for error in app.error if "not taken" in error.value]
    expected = diagnosis_record(diagnosis)
    assert shown(app) == expected
    go(app, "4_Diagnosis")
    app.run()
    assert shown(app) == expected


def test_a_file_on_its_way_stays_out_of_another_job_but_follows_the_job_file_that_it_came_with(
    app: AppTest, content: bytes
) -> None:
    place = app.sidebar.file_uploader[0].proto.id
    open_job(app, content)
    assert app.sidebar.file_uploader[0].proto.id == place
    next(button for button in app.sidebar.button if button.label == "New, empty job").click().run()
    assert app.sidebar.file_uploader[0].proto.id != place


def test_panel_and_settings_start_from_the_job(app: AppTest, content: bytes) -> None:
    open_job(app, content)
    go(app, "21_Settings")
    expected = {
        "Valve body": "four_speed_2023",
        "Fluid": "mobil_atf_220",
        "Spools measured with": "micrometer",
        "Sleeves measured with": "air_gauge",
        "Complaint": "slips_in_second",
        "Profile": "paper",
        "Diameter in the gap law": "mean",
        "Loss at a gap's entry and exit": "on",
        "Where the spools lie is unknown": False,
        "Eccentricity e/c": 0.33,
        "Temperature [°C]": "92.715",
        "Gear": 1,
        "Mileage [km]": "106315",
    }
    assert {label: field(app, label).value for label in expected} == expected
    assert field(app, "Limits").value.name == "our limits.toml"
    assert field(app, "Engine speed [rpm]").value == "1234.5"
    said = "\n".join(widget.value for widget in app.sidebar.caption).replace("\\", "")
    for text in ("two.xlsx", "drive.csv", "guard factor, assumptions, values for the log"):
        assert text in said
    assert app.session_state["job-record"].number == "A-17"


def test_a_job_file_written_again_holds_the_same_choices(app: AppTest, content: bytes) -> None:
    from pages.shared.cases import case_with_columns, diagnosis_of

    open_job(app, content)
    good = app.session_state["atleak"].good
    again = write_job_file(diagnosis_of(good), app.session_state["job-record"], case_with_columns(good))
    assert read_job_file(again).case == read_job_file(content).case


def test_a_change_after_opening_reaches_the_result(app: AppTest, content: bytes) -> None:
    open_job(app, content)
    before = shown(app)
    field(app, "Temperature [°C]").set_value("60").run()
    after = shown(app)
    assert after["projection"]["leakage_dm3_min"] < before["projection"]["leakage_dm3_min"]
    field(app, "Valve body").select("minimal_example").run()
    assert not app.exception
    own = load_controller("minimal_example").operating_points[0]
    assert field(app, "Temperature [°C]").value == f"{own.temperature:g}"


def test_a_condition_that_the_panel_cannot_state_is_kept(
    app: AppTest, diagnosis: Diagnosis, sheet: bytes, own_limits: bytes
) -> None:
    other = replace(diagnosis.projection.condition, name="bench", label="on the bench", main_pressure=432e3)
    odd = diagnose(
        diagnosis.controller,
        diagnosis.fluid,
        diagnosis.limits,
        readings=diagnosis.readings,
        road_test=diagnosis.road.road_test,
        condition=other,
    )
    open_job(app, packed(odd, sheet, own_limits))
    assert not app.exception
    assert shown(app) == diagnosis_record(odd)
    app.run()
    assert shown(app) == diagnosis_record(odd)


@pytest.mark.parametrize("bad", [b"no zip", b""])
def test_what_is_no_job_file_is_refused_and_the_job_stays(app: AppTest, content: bytes, bad: bytes) -> None:
    open_job(app, content)
    before = shown(app)
    open_job(app, bad, "photo.zip")
    assert not app.exception
    assert any("photo.zip was not taken as " in error.value.replace("\\", "") for error in app.error)
    assert shown(app) == before
    app.run()
    assert any("photo.zip" in error.value.replace("\\", "") for error in app.error)


def test_a_sheet_of_ones_own_takes_the_place_of_the_jobs(app: AppTest, content: bytes, sample_readings: Path) -> None:
    open_job(app, content)
    uploader(app).upload("mine.xlsx", sample_readings.read_bytes(), "application/octet-stream").run()
    assert not app.exception
    good = app.session_state["atleak"].good
    assert (good.readings.name, good.sheet_name, good.road_test.name) == ("mine.xlsx", None, "drive.csv")
