"""The pages of job and report: what is typed there stays, and is in what is taken along."""

from __future__ import annotations

import io
import json
import re
import shutil
from pathlib import Path

import pytest
from PIL import Image
from streamlit.testing.v1 import AppTest

from atleak.measurements.job_card import Job
from atleak.report.pdf.body import DOCUMENTS
from tests.unit.pages.conftest import ROOT, go, uploader

pytestmark = pytest.mark.page("1_Job")


def field(app: AppTest, label: str):
    return next(widget for widget in (*app.text_input, *app.text_area) if widget.label == label)


@pytest.mark.page("6_Report")
def test_opens_without_a_word_and_offers_everything(app: AppTest) -> None:
    assert not app.exception
    assert not app.error
    labels = {widget.proto.label for widget in app.get("download_button")}
    assert labels == {"PDF", "Excel workbook", "JSON", "Job record", "Job file", "Page as a file"}


def test_what_was_typed_is_still_there_after_another_page(app: AppTest) -> None:
    field(app, "Job number").set_value("A-17")
    field(app, "Complaint, in the customer's words").set_value("late 1-2 shift: 12.715")
    app.run()
    go(app, "2_Measure")
    go(app, "1_Job")
    assert not app.exception
    assert field(app, "Job number").value == "A-17"
    assert field(app, "Complaint, in the customer's words").value == "late 1-2 shift: 12.715"
    job: Job = app.session_state["job-record"]
    assert job.number == "A-17"


def test_the_measuring_temperature_of_the_form_changes_the_diagnosis(app: AppTest) -> None:
    def measured() -> str:
        go(app, "2_Measure")
        (said,) = [caption.value for caption in app.caption if "Temperature of measuring" in caption.value]
        go(app, "1_Job")
        return said

    assert "assumed 20 °C" in measured()
    field(app, "Measuring temperature [°C]").set_value("35,0").run()
    assert not app.exception
    assert app.session_state["job-record"].measuring_temperature_c == 35.0
    assert app.session_state["atleak"].good.measuring_temperature == 35.0
    assert "35 °C, diameters corrected to 20 °C" in measured()
    assert field(app, "Measuring temperature [°C]").value == "35,0"
    field(app, "Measuring temperature [°C]").set_value("").run()
    assert "assumed 20 °C" in measured()
    field(app, "Pump side clearance [µm]").set_value("85,5").run()
    assert not app.exception
    assert app.session_state["job-record"].pump_side_clearance_um == 85.5
    assert app.session_state["atleak"].good.pump_clearances.um == (85.5, None)


def test_fault_codes_and_tables_reach_the_record(app: AppTest) -> None:
    field(app, "Fault codes, separated by commas").set_value("P0730, P0741")
    key = "job0-repair_decisions"
    app.session_state[key] = {
        "edited_rows": {},
        "added_rows": [{"component": "8", "work": "ream", "decision": "declined", "reason": "too dear"}],
        "deleted_rows": [],
    }
    app.run()
    job: Job = app.session_state["job-record"]
    assert job.fault_codes == ("P0730", "P0741")
    assert job.repair_decisions[0].reason == "too dear"
    go(app, "2_Measure")
    go(app, "1_Job")
    assert app.session_state["job-record"].repair_decisions == job.repair_decisions


def test_a_decision_at_fault_costs_nothing_else_that_was_typed(app: AppTest) -> None:
    field(app, "Technician").set_value("bench 2")
    rows = {"edited_rows": {}, "deleted_rows": []}
    app.session_state["job0-repair_decisions"] = {**rows, "added_rows": [{"component": "25", "land": 9}]}
    app.session_state["job0-scratches"] = {**rows, "added_rows": [{"component": "8", "description": "long"}]}
    app.run()
    job: Job = app.session_state["job-record"]
    assert (job.technician, job.scratches[0].description, job.repair_decisions) == ("bench 2", "long", ())
    assert sum("component 25 has no such land" in each.value for each in app.error) == 1
    app.session_state["job0-scratches"] = {**rows, "added_rows": [{"land": 12, "description": "long"}]}
    field(app, "Technician").set_value("bench 3").run()
    assert app.session_state["job-record"].technician == "bench 3"


def test_no_column_to_type_into_drops_a_decimal_comma(app: AppTest) -> None:
    """A column of numbers takes a pasted ``23,4`` for 234; one of text or choices keeps it."""
    kinds = {
        f"{title}: {name}": column["type_config"]["type"]
        for title, table in zip(("decisions", "scratches", "instruments"), app.dataframe, strict=True)
        for name, column in json.loads(table.proto.columns).items()
        if not column.get("hidden")
    }
    assert set(kinds.values()) == {"text", "selectbox", "date"}
    assert kinds["decisions: work"] == kinds["scratches: description"] == kinds["instruments: serial"] == "text"


def test_a_record_fills_the_form(app: AppTest) -> None:
    record = {"number": "9", "vehicle": {"vin": "W1"}, "notes": "seen"}
    uploader(app).upload("job.json", json.dumps(record).encode(), "application/json").run()
    assert not app.exception
    assert field(app, "VIN").value == "W1"
    assert field(app, "Notes").value == "seen"


def test_a_record_that_cannot_be_used_is_refused_with_its_reason(app: AppTest) -> None:
    uploader(app).upload("job.toml", b"numbr = 1\ncustomer = 2", "application/toml").run()
    assert any("did you mean" in widget.value for widget in app.error)
    assert app.session_state["job-record"].empty


def test_the_form_stays_open_while_it_is_filled_and_a_new_photo_has_its_caption(app: AppTest) -> None:
    target = io.BytesIO()
    Image.new("RGB", (40, 30)).save(target, "PNG")

    def folds() -> list[tuple[str, bool]]:
        return [(widget.label, widget.proto.expanded) for widget in app.expander]

    before = folds()
    field(app, "Make").set_value("Mercedes").run()
    assert folds() == before
    photos = next(widget for widget in app.file_uploader if widget.label == "Photos")
    photos.set_value([("a.png", target.getvalue(), "image/png")]).run()
    field(app, "Caption").set_value("scored").run()
    assert app.session_state["job-record"].photos[0].caption == "scored"


def test_photos_are_kept_and_a_damaged_one_is_refused(app: AppTest) -> None:
    target = io.BytesIO()
    Image.new("RGB", (40, 30)).save(target, "PNG")
    photos = next(widget for widget in app.file_uploader if widget.label == "Photos")
    photos.set_value([("a.png", target.getvalue(), "image/png"), ("b.png", b"no picture", "image/png")]).run()
    assert not app.exception
    assert any("b.png" in widget.value.replace("\\", "") for widget in app.error)
    job: Job = app.session_state["job-record"]
    assert list(job.pictures) == ["photos/a.png"]
    go(app, "2_Measure")
    go(app, "1_Job")
    assert list(app.session_state["job-record"].pictures) == ["photos/a.png"]
    # a job file may bring one that is none, under the name of a picture
    app.session_state["job-record"] = app.session_state["job-record"].with_photo("c.png", b"no picture")
    app.run()
    assert not app.exception
    assert any("photos/c.png" in widget.value.replace("\\", "") for widget in app.error)


def test_the_example_of_the_documentation_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text = (ROOT / "docs" / "reports.md").read_text(encoding="utf-8")
    (example,) = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    shutil.copytree(ROOT / "sample_data", tmp_path / "sample_data")
    monkeypatch.chdir(tmp_path)
    exec(compile(example, "reports.md", "exec"), {})
    assert (tmp_path / "report.pdf").read_bytes().startswith(b"%PDF")
    assert (tmp_path / "report.xlsx").read_bytes().startswith(b"PK")


@pytest.mark.page("6_Report")
def test_sections_are_all_chosen_and_paper_is_named_as_people_do(app: AppTest) -> None:
    assert next(widget for widget in app.selectbox if widget.label == "Paper").options == ["A4", "Letter"]
    (sections,) = app.get("button_group")
    assert list(sections.value) == list(DOCUMENTS["report"])
    next(each for each in app.radio if each.label == "What is printed").set_value("annex").run()
    (sections,) = app.get("button_group")
    assert list(sections.value) == list(DOCUMENTS["annex"])
