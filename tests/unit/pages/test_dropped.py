"""Files handed to the job: each is told by its content, and what is refused leaves the job as it was."""

from __future__ import annotations

import io
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import openpyxl
import pytest
import streamlit as st
from streamlit.testing.v1 import AppTest

from atleak.catalogue.entries import catalogue_files
from atleak.common.wording import wording
from atleak.job.case import SourceFile
from atleak.readers.logs import understand
from atleak.report.sheets.measuring_sheet import write_template
from pages.shared import cases, panel
from pages.shared.state import give_up_log
from tests.unit.conftest import first_of
from tests.unit.pages.conftest import ROOT, XLSX, choice, flagged, flagged_pairs, press, texts, uploader

WATCH = "watch = { percent = 10.0, at_least_um = 4.0 }"  # of the default limits


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


@pytest.mark.page("4_Diagnosis?diagnosis=lands")
def test_a_refused_sheet_is_explained_and_the_last_job_stays(app: AppTest) -> None:
    before = flagged_pairs(app)
    target = io.BytesIO()
    openpyxl.Workbook().save(target)
    uploader(app, "Measuring sheet").upload("leer.xlsx", target.getvalue(), XLSX).run()
    assert not app.exception
    assert "leer.xlsx was not taken as measuring sheet" in texts(app)
    assert "the workbook is empty" in texts(app)
    assert flagged_pairs(app) == before
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


@pytest.mark.page("2_Measure")
def test_a_sheet_for_another_valve_body_is_taken_when_that_one_is_chosen(app: AppTest) -> None:
    sheet = (ROOT / "sample_data" / "measuring_sheet_five_speed.xlsx").read_bytes()
    uploader(app).upload("five.xlsx", without_its_valve_body(sheet), XLSX).run()
    assert "five.xlsx was not taken as measuring sheet" in texts(app)
    assert "Sample job" in texts(app)
    choice(app, "Valve body").set_value("five_speed_2005").run()
    assert not app.exception
    assert "was not taken" not in texts(app)
    assert "**five.xlsx** · 34 of 34 lands measured" in texts(app)


@pytest.mark.page("2_Measure")
def test_a_sheet_whose_head_names_another_valve_body_chooses_it_and_tells_whose_unit_it_is(app: AppTest) -> None:
    sheet = (ROOT / "sample_data" / "measuring_sheet_five_speed.xlsx").read_bytes()
    uploader(app).upload("five.xlsx", sheet, XLSX).run()
    assert not app.exception
    assert "Taken into the job from the head of the sheet: job number, vehicle, mileage, instrument." in texts(app)
    in_german = [notice(wording("de")) for notice in app.session_state["atleak"].notices]
    assert any(each.startswith("Aus dem Kopf des Messblatts in den Auftrag übernommen: Auftrag") for each in in_german)
    assert app.session_state["job-record"].vehicle.mileage_km == 212_000.0
    assert choice(app, "Valve body").value == "five_speed_2005"
    assert "The sheet's head names the valve body five_speed_2005: it was chosen." in texts(app)
    assert "**five.xlsx** · 34 of 34 lands measured" in texts(app)
    press(app, "Undo: five.xlsx taken in")
    assert app.session_state["job-record"].empty
    assert choice(app, "Valve body").value == "four_speed_2023"
    assert "Sample job" in texts(app)


@pytest.mark.page("21_Settings")
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


@pytest.mark.page("21_Settings")
def test_a_valve_body_of_ones_own_stays_where_a_sheet_for_it_is_refused(app: AppTest) -> None:
    own = catalogue_files("controllers")["minimal_example"].read_bytes()
    uploader(app).upload_all({"own.toml": own, "bad.csv": b"component;part;diameter [mm]\nnone;piston;18,0\n"}).run()
    assert not app.exception
    assert "bad.csv was not taken as measuring sheet" in texts(app)
    assert app.session_state["atleak"].good.controller.name == "own.toml"


@pytest.mark.page("2_Measure")
def test_an_unfilled_template_is_refused_by_name(app: AppTest, four_speed) -> None:
    uploader(app, "Measuring sheet").upload("blank.xlsx", write_template(four_speed), XLSX).run()
    assert "every diameter is empty" in texts(app)


@pytest.mark.page("4_Diagnosis?diagnosis=log")
def test_own_files_replace_the_sample_one_by_one(app: AppTest, sample_readings: Path, sample_log: Path) -> None:
    uploader(app, "Measuring sheet").upload("mine.xlsx", sample_readings.read_bytes(), XLSX).run()
    assert "No road-test log in the job." in texts(app)
    uploader(app, "Road-test log").upload("drive.csv", sample_log.read_bytes(), "text/csv").run()
    assert not app.exception
    assert "No road-test log in the job." not in texts(app)
    assert app.dataframe[0].value.shape[0] > 0  # extremes of the leakage over it
    assert "1201 rows" in texts(app)
    uploader(app, "Road-test log").set_value(None).run()
    assert "No road-test log in the job." in texts(app)
    next(widget for widget in app.button if widget.label == "Take the sample job").click().run()
    assert "Sample job" in texts(app)
    assert "No road-test log in the job." not in texts(app)
    assert app.dataframe[0].value.shape[0] > 0  # extremes of the leakage over it


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


@pytest.mark.page("2_Measure")
@pytest.mark.parametrize("name", first_of(["two\nlines.toml", "a:b?.toml", "con", "x" * 300 + ".toml"]))
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


def bad_file(slot: str) -> tuple[str, bytes, str]:
    target = io.BytesIO()
    openpyxl.Workbook().save(target)
    return ("bad.xlsx", target.getvalue(), XLSX) if slot == "Measuring sheet" else ("bad.csv", b"no log\n", "text/csv")


@pytest.mark.page("4_Diagnosis?diagnosis=lands")
@pytest.mark.parametrize("slot", ["Measuring sheet", "Road-test log"])
def test_a_bad_file_in_place_of_an_own_good_one_leaves_the_good_one(
    app: AppTest, sample_readings: Path, sample_log: Path, slot: str
) -> None:
    uploader(app, "Measuring sheet").upload("mine.xlsx", sample_readings.read_bytes(), XLSX).run()
    uploader(app, "Road-test log").upload("drive.csv", sample_log.read_bytes(), "text/csv").run()
    before, said = flagged_pairs(app), app.title[0].value
    uploader(app, slot).set_value(bad_file(slot)).run()
    assert not app.exception
    assert "was not taken" in texts(app)
    mine = "mine.xlsx" if slot == "Measuring sheet" else "drive.csv"
    assert f"Shown are still the results of {mine}" in texts(app)
    assert flagged_pairs(app) == before
    assert app.title[0].value == said
    uploader(app, slot).set_value(None).run()
    assert "was not taken" not in texts(app)
    assert flagged_pairs(app) == before
    assert app.session_state["atleak"].good.road_test.name == "drive.csv"


@pytest.mark.page("2_Measure")
def test_a_sheet_that_was_taken_away_comes_back_by_undo_alone(app: AppTest, sample_readings: Path) -> None:
    uploader(app, "Measuring sheet").upload("mine.xlsx", sample_readings.read_bytes(), XLSX).run()
    uploader(app, "Measuring sheet").set_value(None).run()
    uploader(app, "Measuring sheet").set_value(bad_file("Measuring sheet")).run()
    assert "The job is as it was" in texts(app)
    assert app.session_state["atleak"].good.readings is None
    press(app, "Undo: mine.xlsx taken away")
    assert app.session_state["atleak"].good.readings.name == "mine.xlsx"


@pytest.mark.page("2_Measure")
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


@pytest.mark.page("4_Diagnosis?diagnosis=pressures")
def test_a_vacuum_test_and_flows_are_taken_shown_and_explained_where_they_are_wrong(app: AppTest) -> None:
    choice(app, "Valve body").select("five_speed_2005").run()
    flows, vacuum = (
        b"condition;what;value\nhot_idle;cooler;1,5 l/min\n",
        b"supply;25 in-Hg\nboost_valve/1;17 in-Hg;;1\n",
    )
    uploader(app, "Measuring sheet").upload("jug.csv", flows, "text/csv").run()
    assert not app.exception
    assert "**jug.csv** · 1 flow" in texts(app)
    uploader(app, "Measuring sheet").upload("stand.csv", vacuum, "text/csv").run()
    assert not app.exception
    assert "**stand.csv** · 1 vacuum reading" in texts(app)
    assert "**jug.csv**" in texts(app)
    titles = [each.value for each in app.header]
    assert "Flows caught in a jug" in titles
    assert "Vacuum test" in titles
    uploader(app, "Measuring sheet").upload("worse.csv", flows.replace(b"1,5 l", b"1,5 x"), "text/csv").run()
    assert "worse.csv was not taken as flows caught in a jug" in texts(app)
    assert "**jug.csv** · 1 flow" in texts(app)


LOG = "time [s],engine speed [rpm],p_g [kPa]\n" + "".join(f"{row / 10},800,{500 + row % 7}\n" for row in range(9000))


@pytest.fixture
def unhurried(monkeypatch: pytest.MonkeyPatch) -> Callable[[], None]:
    """Lets a log be read only once what it returns was called; it counts two rows, and more again and again."""
    hurry: list[bool] = []

    def read(*log: object, tell: Callable[[int], object], **choices: object) -> object:
        tell(2)
        while not hurry:
            tell(20)
        return understand(*log, **choices)

    monkeypatch.setattr(cases, "LARGE", 120_000)
    monkeypatch.setattr(cases, "understand", read)
    return lambda: hurry.append(True)


@pytest.mark.page("1_Job")
def test_the_rows_of_a_large_log_are_counted_until_it_is_read(
    app: AppTest, unhurried: Callable[[], None], monkeypatch: pytest.MonkeyPatch
) -> None:
    said = []

    def seen(count: int, _: object) -> str:
        said.append(count)
        unhurried()
        return str(count)

    monkeypatch.setattr(panel, "whole", seen)
    uploader(app).upload("drive.csv", LOG.encode(), "text/csv").run()
    assert not app.exception
    assert set(said) == {20}
    assert "**drive.csv** · 9000 rows, 900 s" in texts(app)
    assert "rows so far" not in texts(app)


@pytest.mark.page("1_Job")
def test_a_large_log_that_is_not_read_to_its_end_leaves_the_job_as_it_was(
    app: AppTest, unhurried: Callable[[], None], monkeypatch: pytest.MonkeyPatch
) -> None:
    waited: list[cases.LogReading] = []

    def cancel(_: object, reading: cases.LogReading) -> None:
        """What *Cancel* does while it waits: it begins the page anew, with its callback."""
        waited.append(reading)
        give_up_log()
        st.rerun()

    monkeypatch.setattr(panel, "_count_rows", cancel)
    before = app.session_state["atleak"].good, app.session_state["atleak"].case
    uploader(app).upload("drive.csv", LOG.encode(), "text/csv").run()
    assert not app.exception
    assert "drive.csv was not read to its end, and is not in the job." in texts(app)
    assert (app.session_state["atleak"].good, app.session_state["atleak"].case) == before
    assert app.session_state["large-logs"] == {}
    assert isinstance(waited[0].understood.exception(timeout=10.0), cases.CancelledError)


@pytest.mark.page("1_Job")
def test_where_a_log_of_the_job_is_read_anew_to_no_end_it_stays_in_the_job_and_nobody_says_otherwise(
    app: AppTest, unhurried: Callable[[], None], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(panel, "_count_rows", lambda place, reading: unhurried())
    uploader(app).upload("drive.csv", LOG.encode(), "text/csv").run()
    good = app.session_state["atleak"].good

    def cancel(_: object, reading: cases.LogReading) -> None:
        give_up_log()
        st.rerun()

    monkeypatch.setattr(panel, "_count_rows", cancel)
    app.session_state["atleak"].case = replace(good, every=2)
    app.run()
    assert not app.exception
    assert "not read to its end" not in texts(app)
    assert app.session_state["atleak"].case == app.session_state["atleak"].good == good


def test_a_large_log_that_failed_once_is_read_again(monkeypatch: pytest.MonkeyPatch) -> None:
    read = iter([MemoryError("none free"), "read"])

    def understand(*_: object, **__: object) -> object:
        if isinstance(found := next(read), Exception):
            raise found
        return found

    monkeypatch.setattr(cases, "understand", understand)
    monkeypatch.setattr(st, "session_state", {})
    log = SourceFile("drive.csv", LOG.encode())
    with pytest.raises(MemoryError):
        cases._understood_here("log", log, {}, False)
    assert cases._understood_here("log", log, {}, False) == "read"
