"""``atleak fleet summary``: what it prints and writes, and what it says where there is nothing to sum up."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pypdfium2
import pytest
from PIL import Image
from python_calamine import CalamineWorkbook

from atleak.catalogue.controller_file import load_controller
from atleak.common.verdicts import Verdict
from atleak.common.wording import wording
from atleak.fleet.folder import known_folders
from atleak.fleet.results import Results
from tests.unit.cli.test_schema import closed
from tests.unit.fleet.few_units import Measured, Unit, condition, results_of, temperature_class
from tests.unit.fleet.made_up import CONTROLLERS, made_up_results

Run = Callable[..., tuple[int, str, str]]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("fleet")
    made_up_results(folder, units=60)
    return folder


def test_the_record_is_as_its_schema_says(run: Run, folder: Path) -> None:
    status, out, _ = run("fleet", "summary", folder, "--json", "-")
    assert status == 0
    record = json.loads(out)
    closed("fleet-summary").validate(record)
    assert record["counts"]["units"] == 60
    assert [body["comparison"] for body in record["controllers"]] == [None, None]


def test_groups_side_by_side_are_as_the_schema_says(run: Run, tmp_path: Path) -> None:
    units = [
        Unit(f"unit {n}", {("8", 1): Measured(20.0 + n)}, own={"group": "abcde"[n % 5], "mileage_km": 1e5})
        for n in range(50)
    ]
    results_of(tmp_path, units)
    status, out, _ = run("fleet", "summary", tmp_path, "--by", "group", "--json", "-")
    assert status == 0
    record = json.loads(out)
    closed("fleet-summary").validate(record)
    lands = record["controllers"][0]["comparison"]["lands"]
    assert {(each["second"], each["mean_points"]["differs"]) for each in lands} == {(None, False)}


def test_a_unit_with_nothing_but_its_verdict_is_as_the_schema_says(run: Run, tmp_path: Path) -> None:
    units = [
        Unit("plain", {("8", 1): Measured()}, own={"group": "a"}),
        Unit("full", {("8", 1): Measured()}, conditions=[condition()], temperatures=[temperature_class()]),
        Unit("other", own={"group": "b", "decided_by_kind": "reserve"}),
    ]
    results_of(tmp_path, units)
    status, out, _ = run("fleet", "summary", tmp_path, "--by", "group", "--json", "-")
    assert status == 0
    closed("fleet-summary").validate(json.loads(out))


def test_one_unit_is_said_in_the_singular_and_one_without_a_sheet_as_in_no_rate(run: Run, tmp_path: Path) -> None:
    results_of(tmp_path, [Unit("log", verdict=Verdict.OK, own={"provisional": True})])
    status, printed, _ = run("fleet", "summary", tmp_path)
    out = " ".join(printed.split())
    assert status == 0
    assert "units: 1 with a verdict: 0 results: 1 valve body: body_a" in out
    assert "Nothing was measured of the one unit: it has no verdict of its lands." in out
    assert "Judged by log or gauges alone, no land being measured, and in no rate: 1." in out
    assert "Verdicts that rest on assumed values: 1." in out
    assert not [word for word in ("1 units", "1 results") if word in out]


def test_it_is_printed_for_people(run: Run, folder: Path) -> None:
    status, out, _ = run("fleet", "summary", folder, "--by", "group")
    assert status == 0
    for text in (
        "results: 60",
        "groups by: group",
        *(load_controller(each).name for each in CONTROLLERS),
        "Pairs that are most often to be replaced",
        "Wear over mileage",
        "Share and pressure over temperature",
        "At the stated conditions",
        "Groups side by side",
        "at the same",
        "fewer than ten units",
        "Refused: the files are at fault: 1",
        "Units, the worst first",
    ):
        assert text in out


def test_units_without_any_measurement_are_not_said_to_be_within_limits(run: Run, tmp_path: Path) -> None:
    results_of(tmp_path, [Unit("log alone", {("8", 1): Measured(None, Verdict.NOT_MEASURED, "not_measured")})])
    status, out, _ = run("fleet", "summary", tmp_path)
    assert status == 0
    assert "Nothing was measured of the one unit" in out
    assert "No pair is flagged" not in out


def test_names_from_files_are_printed_as_they_are(run: Run, tmp_path: Path) -> None:
    results_of(tmp_path, [Unit("[red]a[/red]", {("[b]8", 1): Measured(30.0, Verdict.WATCH)}, own={"group": "[x"})])
    status, out, _ = run("fleet", "summary", tmp_path, "--by", "group")
    assert status == 0
    assert "[red]a[/red]" in out
    assert "[b]8/1" in out


def test_the_record_goes_to_a_file_too(run: Run, folder: Path, tmp_path: Path) -> None:
    target = tmp_path / "fleet.json"
    status, out, _ = run("fleet", "summary", folder, "--controller", CONTROLLERS[0], "--list", "2", "--json", target)
    assert (status, "written: " in out) == (0, True)
    record = json.loads(target.read_bytes())
    assert [body["controller"] for body in record["controllers"]] == [CONTROLLERS[0]]
    assert len(record["worst"]) == 2


def test_what_cannot_be_summed_up_is_said_in_one_sentence(run: Run, folder: Path, tmp_path: Path) -> None:
    (tmp_path / "something").mkdir()
    (tmp_path / "something" / "else.txt").write_text("no results", encoding="utf-8")
    with Results.open(tmp_path / "begun", for_writing=True):
        pass
    with Results.open(tmp_path / "later", for_writing=True):
        pass
    run_file = tmp_path / "later" / "run.json"
    said = json.loads(run_file.read_bytes())
    run_file.write_text(json.dumps({**said, "format": said["format"] + 1, "atleak": "99.0"}), encoding="utf-8")
    refused = {
        ("something",): "holds no results of a fleet",
        ("nowhere",): "holds no results of a fleet",
        ("begun",): "holds no unit yet, neither a result nor an error",
        ("later",): "holds results of atleak 99.0",
        (folder, "--by", "batsh"): "did you mean 'batch'?",
        (folder, "--controller", "four_speed"): "did you mean 'four_speed_2023'?",
    }
    for (name, *options), text in refused.items():
        status, out, err = run("fleet", "summary", tmp_path / name, *options)
        assert (status, out) == (2, "")
        assert text in err
        assert err.count("\n") == 1


def test_the_summary_goes_to_a_pdf_and_a_workbook_in_the_reader_s_language(run: Run, tmp_path: Path) -> None:
    units = [Unit(f"unit {number}", {("8", 1): Measured(30.0, Verdict.WATCH)}) for number in range(12)]
    results_of(tmp_path / "results", units)
    pdf, xlsx = tmp_path / "fleet.pdf", tmp_path / "fleet.xlsx"
    status, out, err = run("fleet", "summary", tmp_path / "results", "--pdf", pdf, "--xlsx", xlsx, "--language", "de")
    assert (status, err) == (0, "")
    assert f"written: {pdf}" in out
    status, out, _ = run("fleet", "summary", tmp_path / "results", "--xlsx", tmp_path / "en.xlsx", "--json", "-")
    assert (status, json.loads(out)["visits"]) == (0, 12)
    with pypdfium2.PdfDocument(pdf) as document:
        assert wording("de")("fleet_summary.title") in document[0].get_textpage().get_text_range()
    pairs = CalamineWorkbook.from_path(xlsx).get_sheet_by_name(wording("de")("fleet_sheets.pairs")).to_python()
    assert [row[1] for row in pairs[1:]] == ["8/1"]
    pdf.write_bytes(b"somebody's own")
    status, _, err = run("fleet", "summary", tmp_path / "results", "--pdf", pdf)
    assert status == 2
    assert "fleet.pdf" in err
    assert pdf.read_bytes() == b"somebody's own"


def test_a_language_without_a_paper_is_doubted(run: Run, tmp_path: Path) -> None:
    results_of(tmp_path, [Unit("plain", {("8", 1): Measured()})])
    status, _, err = run("fleet", "summary", tmp_path, "--language", "de")
    assert status == 0
    assert "--language does nothing without --pdf or --xlsx" in err


def test_the_folder_is_offered_on_the_pages_and_a_home_that_cannot_be_written_stops_nothing(
    run: Run, folder: Path, own_home: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert run("fleet", "summary", folder, "--json", "-")[0] == 0
    assert [each.path for each in known_folders()] == [folder.resolve()]
    (tmp_path / "file").write_bytes(b"no folder")
    monkeypatch.setenv("ATLEAK_HOME", str(tmp_path / "file"))
    status, out, _ = run("fleet", "summary", folder, "--json", "-")
    assert (status, json.loads(out)["counts"]["units"]) == (0, 60)


def test_the_workshop_of_a_job_record_stands_at_the_head_of_the_pdf_and_nobody_else_of_it(
    run: Run, folder: Path, tmp_path: Path
) -> None:
    record, printed = tmp_path / "record.toml", tmp_path / "fleet.pdf"
    record.write_text(
        'number = "N 4711"\n[workshop]\nname = "Hall of Stands"\nlogo = "logo.png"\n[customer]\nname = "Bo Berg"\n',
        encoding="utf-8",
    )
    Image.new("RGB", (40, 20), "navy").save(tmp_path / "logo.png")
    status, _, said = run("fleet", "summary", folder, "--pdf", printed, "--job", record)
    assert (status, said) == (0, "")
    with pypdfium2.PdfDocument(printed) as document:
        first = document[0].get_textpage().get_text_range()
        kinds = [each.type for each in document[0].get_objects()]
        text = " ".join(page.get_textpage().get_text_range() for page in document)
    assert first.startswith("Hall of Stands")
    assert pypdfium2.raw.FPDF_PAGEOBJ_IMAGE in kinds
    assert not [word for word in ("Bo Berg", "4711") if word in text]
