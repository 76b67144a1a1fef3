"""The main job: exit status, what stands on which stream, options, and messages for bad input."""

from __future__ import annotations

import json
import re
import shlex
from collections.abc import Callable
from pathlib import Path
from typing import Any

import openpyxl
import pikepdf
import pytest

from atleak.catalogue.controller import Controller
from atleak.catalogue.entries import catalogue_files
from atleak.job.case import SLOTS, Case
from atleak.job.zip_file import read_job_file

Run = Callable[..., tuple[int, str, str]]
WithPressure = Callable[..., Path]
RecordOf = Callable[..., dict[str, Any]]
SmallSheet = Callable[..., Path]
OWN_FILES = {
    "controller": "minimal_example",
    "fluid": "mobil_atf_220",
    "limits": Case.limits,
    "spool_instrument": Case.spool_instrument,
    "sleeve_instrument": Case.sleeve_instrument,
}


def test_json_stands_alone_on_standard_output(sample_readings: Path, sample_log: Path, record_of: RecordOf) -> None:
    record = record_of(sample_readings, "--road-test", sample_log)
    assert record["verdict"] == "replace"
    assert record["road_test"]["file"] == sample_log.name
    assert record["profile"]["name"] == "workshop"


def test_the_annex_carries_the_workbook_the_record_and_the_job_file(
    run: Run, sample_readings: Path, tmp_path: Path
) -> None:
    """Each the same bytes as when it is written by itself: one file by which the whole result can be judged."""
    files = {"workbook.xlsx": "--xlsx", "result.json": "--json", "job.zip": "--job-file"}
    asked = [argument for name, option in files.items() for argument in (option, tmp_path / name)]
    pdfs = {name: tmp_path / f"{name}.pdf" for name in ("annex", "all", "workshop")}
    printed = [argument for name, path in pdfs.items() for argument in ("--pdf", f"{name}={path}")]
    assert run("diagnose", sample_readings, *asked, *printed)[0] == 0
    for name, path in pdfs.items():
        with pikepdf.open(path) as pdf, pdf.open_metadata() as metadata:
            carried = {each: spec.get_file().read_bytes() for each, spec in pdf.attachments.items()}
            assert carried == ({} if name == "workshop" else {each: (tmp_path / each).read_bytes() for each in files})
            assert metadata["pdfaid:part"] == ("2" if name == "workshop" else "3")
            assert (metadata["pdfaid:conformance"], metadata["pdfuaid:part"]) == ("A", "1")
            related = {str(each.UF): str(each.AFRelationship) for each in pdf.Root.get("/AF", ())}
        if carried:
            assert related == {"workbook.xlsx": "/Alternative", "result.json": "/Data", "job.zip": "/Source"}
    assert openpyxl.load_workbook(tmp_path / "workbook.xlsx").sheetnames[0] == "Summary"
    assert read_job_file(tmp_path / "job.zip").diagnose().verdict == "replace"


def test_summary_names_totals_flagged_pairs_and_repair(run: Run, sample_readings: Path, sample_log: Path) -> None:
    status, out, err = run("diagnose", sample_readings, "--road-test", sample_log)
    assert (status, err) == (0, "")
    for word in ("47 of 47 lands measured", "■ replace", "25/1", "hot idle in drive", "rpm", "assumed"):
        assert word in out


def test_the_speed_that_covers_the_leakage_says_what_is_not_in_it(run: Run, sample_readings: Path) -> None:
    _, out, _ = run("diagnose", sample_readings)
    said = " ".join(out.split())
    assert said.count("covered from") == 2  # at each of the two conditions
    assert said.count("converter, lubrication and clutch fill are not in it") == 1  # once for both
    assert "needs" not in said


def test_every_condition_is_printed_and_the_worst_is_named(run: Run, sample_readings: Path) -> None:
    _, out, _ = run("diagnose", sample_readings)
    said = " ".join(out.split())
    assert "1. driving in second, 80 °C: 11.7 % of the pump's flow, red; 7.5 % when new" in said
    assert "2. hot idle in drive, 100 °C: 24.2 % of the pump's flow, red with a probability of 7" in said
    assert "spools concentric, 24 to 58 % as they may lie" in said
    assert said.count("the worst condition") == 1
    assert re.search(r"│ 25/1 │ [▲■] \d\.\d\d │ ■ \d\.\d\d │", said)
    assert "Order of repair, each land as new after those before it: 1. 25/1 main pressure valve: total share" in said
    assert "The plan ends green at every condition." in said


def test_small_shares_are_not_rounded_to_nothing(run: Run, small_sheet: SmallSheet) -> None:
    _, out, _ = run("diagnose", small_sheet(sleeve=11.032), "--controller", "minimal_example")
    said = " ".join(out.split())
    assert "1. driving in second, 80 °C: 0.5 % of the pump's flow, green; 0.5 % when new, not grown" in said
    assert "spools concentric, 0.5 to 1.1 % as they may lie" in said


def test_many_conditions_are_printed_a_few_abreast(run: Run, small_sheet: SmallSheet, tmp_path: Path) -> None:
    """Eight columns of shares would not fit a terminal: no number of any may be cut."""
    text = catalogue_files("controllers")["minimal_example"].read_text(encoding="utf-8")
    point = text[text.index("[[operating_points]]") : text.index("[[complaints]]")].partition("\n\n[[")[0]
    more = "\n\n".join(point.replace("driving_second", f"point_{number}") for number in range(7))
    own = tmp_path / "own.toml"
    own.write_text(text.replace("[[complaints]]", f"{more}\n\n[[complaints]]"), encoding="utf-8")
    _, out, _ = run("diagnose", small_sheet(sleeve=11.06), "--controller", own)
    rows = [line for line in out.splitlines() if line.startswith("│ tcc_regulator/1 │")]
    assert [line.count("│") - 2 for line in rows] == [6, 3]
    assert not any("…" in line for line in rows)


def test_a_complaint_leads_the_result(run: Run, record_of: RecordOf, sample_readings: Path, tmp_path: Path) -> None:
    job = tmp_path / "job.zip"
    record = record_of(sample_readings, "--complaint", "slips_hot", "--job-file", job)
    complaint = record["complaint"]
    assert (complaint["id"], complaint["conditions"]) == ("slips_hot", ["hot_idle"])
    assert (complaint["measure_first"], complaint["explained_by"]) == ([], []), "all is measured and held"
    assert "no effect on a pressure" in complaint["text"]
    assert read_job_file(job).case.complaint == "slips_hot"
    assert record_of(sample_readings)["complaint"] is None
    _, out, _ = run("diagnose", sample_readings, "--complaint", "slips_hot")
    said = " ".join(out.split())
    assert said.index("Complaint: Slips or shifts late when hot. It shows at: hot idle") < said.index("1. hot idle")
    assert "2. driving in second" in said


def test_an_unknown_complaint_is_refused_with_the_known_ones(run: Run, sample_readings: Path) -> None:
    status, out, err = run("diagnose", sample_readings, "--complaint", "slips_htt")
    assert (status, out) == (2, "")
    assert "maps no such complaint (found 'slips_htt'); expected one of slips_hot, slips_in_second" in err


def test_json_and_workbook_are_written_to_files_and_named(run: Run, sample_readings: Path, tmp_path: Path) -> None:
    as_json, as_book = tmp_path / "ergebnis für Łódź.json", tmp_path / "out.xlsx"
    status, out, _ = run("diagnose", sample_readings, "--json", as_json, "--xlsx", as_book)
    assert status == 0
    assert json.loads(as_json.read_text(encoding="utf-8"))["format"] == 1
    assert len(openpyxl.load_workbook(as_book, read_only=True).sheetnames) >= 1
    assert "written:" in out
    assert "out.xlsx" in "".join(out.split())


def test_rows_of_one_inspection(run: Run, tmp_path: Path, record_of: RecordOf) -> None:
    sheet = tmp_path / "two.csv"
    rows = [
        ("May", "piston", 17.998),
        ("May", "bore", 18.041),
        ("November", "piston", 17.996),
        ("November", "bore", 18.05),
    ]
    lines = [f"{when};accumulator;1;{part};{size}" for when, part, size in rows]
    sheet.write_text("\n".join(["Inspection;Valve;Land;Part;Diameter [mm]", *lines]), encoding="utf-8")
    status, out, err = run("diagnose", sheet, "--controller", "minimal_example")
    assert (status, out) == (2, "")
    assert "--where Inspection=May" in err
    job = tmp_path / "job.zip"
    record = record_of(sheet, "--controller", "minimal_example", "--where", "Inspection=May", "--job-file", job)
    land = {land["component"]: land for land in record["lands"]}["accumulator"]
    assert land["radial_clearance_um"] == pytest.approx(21.5, abs=1e-6)
    again = read_job_file(job)
    assert again.case.sheet_where == (("Inspection", "May"),)
    assert [reading.diameter for reading in again.diagnose().readings.readings] == pytest.approx(
        [17.998e-3, 18.041e-3], abs=1e-12
    )


def test_columns_of_a_sheet_are_named_remembered_shared_and_forgotten(run: Run, tmp_path: Path) -> None:
    sheet, job, file = tmp_path / "scheda.csv", tmp_path / "job.zip", tmp_path / "map.json"
    sheet.write_text("Nr;Lõige;Siiber;Auk\naccumulator;1;17.998;18.041\n", encoding="utf-8")
    command = ("diagnose", sheet, "--controller", "minimal_example")
    status, _, err = run(*command)
    assert status == 2
    options = shlex.split(err[err.index("--map") :])
    assert options[-1] == "value sleeve=Auk"
    status, _, err = run(*command, *options, "--unit", "value=mm", "--map-file", file, "--job-file", job)
    assert (status, err) == (0, f"atleak: columns are written to {file}\n")
    again = read_job_file(job)
    assert dict(again.case.sheet_columns)["value sleeve"] == "Auk"
    assert len(again.diagnose().readings.readings) == 2
    status, _, err = run(*command)  # remembered
    assert status == 0
    assert err.startswith("atleak: columns are taken as settled on ")
    assert run(*command, "--forget")[0] == 2
    assert run(*command)[0] == 2
    assert run(*command, "--map-file", file, "--forget")[0] == 0
    assert run(*command)[0] == 2
    assert run(*command, "--map-file", file)[0] == 0
    assert run("controller", "learn", sheet, "--controller", "minimal_example", "--map-file", file)[0] == 0


@pytest.mark.parametrize("option", ["--map", "--unit"])
def test_an_unknown_name_lists_roles_and_quantities(run: Run, sample_readings: Path, option: str) -> None:
    status, out, err = run("diagnose", sample_readings, option, "valeu=A")
    assert (status, out) == (2, "")
    assert "component" in err
    assert "main_pressure" in err
    status, _, err = run("diagnose", sample_readings, "--map", "value=A", "--map", "value=B")
    assert status == 2
    assert "given twice" in err
    assert run("diagnose", sample_readings, "--map-file", "none.json")[0] == 2


def test_empty_cells_of_a_block_go_on_with_the_one_above(run: Run, tmp_path: Path, record_of: RecordOf) -> None:
    sheet, job = tmp_path / "blocks.csv", tmp_path / "job.zip"
    sheet.write_text("Valve;Land;Part;Diameter [mm]\naccumulator;1;piston;17.998\n;;bore;18.041\n", encoding="utf-8")
    status, _, err = run("diagnose", sheet, "--controller", "minimal_example")
    assert status == 2
    assert "--fill-down" in err
    record = record_of(sheet, "--controller", "minimal_example", "--fill-down", "--job-file", job)
    land = {land["component"]: land for land in record["lands"]}["accumulator"]
    assert (land["spool_readings"], land["sleeve_readings"]) == (1, 1)
    again = read_job_file(job)
    assert again.case.sheet_fill_down
    assert len(again.diagnose().readings.readings) == 2


def test_without_a_flagged_land_it_says_so(run: Run, small_sheet: SmallSheet) -> None:
    sheet = small_sheet(sleeve=11.032)
    status, out, _ = run("diagnose", sheet, "--controller", "minimal_example", "--temperature", "40")
    assert status == 0
    assert "1 of 5 lands measured in small.csv" in out


@pytest.mark.parametrize(("fail_on", "status"), [("watch", 1), ("replace", 1), ("critical", 0)])
def test_fail_on_ends_with_1_at_or_past_it(run: Run, sample_readings: Path, fail_on: str, status: int) -> None:
    assert run("diagnose", sample_readings, "--fail-on", fail_on)[0] == status


def test_fail_on_with_json_keeps_the_record(run: Run, sample_readings: Path) -> None:
    status, out, err = run("diagnose", sample_readings, "--fail-on", "watch", "--json", "-")
    assert (status, err) == (1, "")
    assert json.loads(out)["verdict"] == "replace"


def test_fail_on_counts_the_total(run: Run, tmp_path: Path, four_speed: Controller) -> None:
    """With every clearance doubled no land is critical by itself; together they take more than the pump delivers."""
    rows = ["component,part,plane,direction,diameter mm"]
    for land in four_speed.lands:
        for plane in land.planes:
            sleeve = land.nominal_diameter + 4.0 * land.mounting_clearance
            rows.append(f"{land.component},{land.part},{plane},0,{land.nominal_diameter * 1e3:.4f}")
            rows.append(f"{land.component},sleeve,{plane},0,{sleeve * 1e3:.4f}")
    sheet = tmp_path / "doubled.csv"
    sheet.write_text("\n".join(rows) + "\n", encoding="utf-8")
    status, out, _ = run("diagnose", sheet, "--fail-on", "critical", "--json", tmp_path / "out.json")
    unit = json.loads((tmp_path / "out.json").read_text(encoding="utf-8"))["unit"]
    assert (status, unit["verdict"], unit["decided_by"]["kind"]) == (1, "critical", "total")
    assert "decided by the total share of pump flow" in " ".join(out.split())


@pytest.mark.parametrize(("sleeve", "status"), [(11.032, 0), (11.039, 0), (11.040, 1), (11.048, 1)])
def test_fail_on_watch_follows_the_verdict(
    run: Run, tmp_path: Path, sleeve: float, status: int, small_sheet: SmallSheet
) -> None:
    own = tmp_path / "own.toml"
    text = catalogue_files("limits")["project_default"].read_text(encoding="utf-8")
    own.write_text(text[: text.index("# What one pair")] + text[text.index("# What all") :], encoding="utf-8")
    sheet = small_sheet(sleeve)
    outcome = run("diagnose", sheet, "--controller", "minimal_example", "--limits", own, "--fail-on", "watch")
    assert outcome[0] == status


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("missing.xlsx", None, ("missing.xlsx", "no such file")),
        ("empty.xlsx", b"", ("empty.xlsx", "empty")),
        ("empty.csv", b"", ("empty.csv", "empty")),
        ("not.xlsx", b"PK\x03\x04 no workbook", ("not.xlsx",)),
        ("image.csv", bytes(range(256)) * 8, ("image.csv",)),
        ("other.csv", b"name,price\nbolt,3\n", ("other.csv", "expected")),
    ],
)
def test_readings_that_are_none(
    run: Run, tmp_path: Path, name: str, content: bytes | None, words: tuple[str, ...]
) -> None:
    if content is not None:
        (tmp_path / name).write_bytes(content)
    status, out, err = run("diagnose", tmp_path / name)
    assert (status, out) == (2, "")
    assert err.startswith("atleak: ")
    for word in words:
        assert word in err


@pytest.mark.parametrize("option", ["READINGS", "--road-test", "--controller", "--fluid", "--limits"])
def test_a_folder_in_place_of_a_file(run: Run, sample_readings: Path, tmp_path: Path, option: str) -> None:
    arguments = [tmp_path] if option == "READINGS" else [sample_readings, option, tmp_path]
    status, out, err = run("diagnose", *arguments)
    assert (status, out) == (2, "")
    assert tmp_path.name in err


def test_a_workbook_of_another_kind_names_what_it_lacks(run: Run, tmp_path: Path) -> None:
    book = openpyxl.Workbook()
    book.active.title = "Invoice"  # type: ignore[union-attr]
    book.active.append(["bolt", 3, 4.5])  # type: ignore[union-attr]
    book.save(tmp_path / "invoice.xlsx")
    status, _, err = run("diagnose", tmp_path / "invoice.xlsx")
    assert status == 2
    assert "invoice.xlsx" in err


def test_a_sheet_of_another_controller_says_so(run: Run, sample_readings: Path) -> None:
    status, _, err = run("diagnose", sample_readings, "--controller", "minimal_example")
    assert status == 2
    for word in (sample_readings.name, "row 2", "made for controller four_speed_2023", "--controller four_speed_2023"):
        assert word in err


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--road-test", "nope.csv"], ("nope.csv",)),
        (["--controller", "four_sped_2023"], ("'four_sped_2023'", "did you mean 'four_speed_2023'?")),
        (["--fluid", "dexron"], ("'dexron'", "mobil_atf_220")),
        (["--limits", "own.toml"], ("'own.toml'", "no such file")),
        (["--set", "entry_los=on"], ("'entry_los'", "did you mean 'entry_loss'?")),
        (["--set", "viscosity=water"], ("'water'", "d341")),
        (["--set", "eccentricity=2"], ("'2'", "a number 0 to 1, or unknown")),
        (["--assume", "eccentricity=nobody knows"], ("'nobody knows'", "a number 0 to 1, or unknown")),
        (["--assume", "eccentricity=unknown", "--set", "eccentricity=0"], ("twice", "--set or --assume, not both")),
        (["--set", "entry_loss=maybe"], ("'maybe'", "auto, on, off")),
        (["--set", "entry_loss"], ("--set", "'entry_loss'", "NAME=VALUE")),
        (["--set", "=on"], ("--set", "NAME=VALUE")),
        (["--gear", "9"], ("9", "one of 1, 2, 3, 4")),
        (["--gear", "two"], ("--gear", "'two'")),
        (["--temperature", "500"], ("500 °C", "from −60 to 200 °C")),
        (["--temperature", "190"], ("190 °C", "-20 to 150 °C")),
        (["--temperature", "1e3"], ("1e3 °C",)),
        (["--temperature", "-30"], ("-30 °C",)),
        (["--temperature", "warm"], ("--temperature", "'warm'")),
        (["--temperature", "nan"], ("nan",)),
        (["--rpm", "0"], ("0 rpm", "from 1 to 15000 rpm")),
        (["--rpm", "-800"], ("−800 rpm", "from 1 to 15000 rpm")),
        (["--rpm", "1.250"], ("'1.250'", "two ways", "1250", "1.25 ")),
        (["--mileage", "-1"], ("--mileage", "−1 km")),
        (["--mileage", "nan"], ("--mileage", "'nan'")),
        (["--mileage", "106.315"], ("--mileage", "'106.315'", "two ways")),
        (["--mileage", "106,315"], ("'106,315'", "two ways")),
        (["--mileage", "far"], ("--mileage", "'far'")),
        (["--profile", "papr"], ("--profile", "workshop")),
        (["--fail-on", "ok"], ("--fail-on", "critical")),
        (["--xlsx", "-"], ("standard output",)),
        (["--pdf", "-"], ("standard output",)),
        (["--pdf", "annex=-"], ("standard output",)),
        (["--pdf", "annx=a.pdf"], ("annx=a.pdf", "customer|workshop|annex|all")),
        (["--pdf", "a.pdf", "--pdf", "report=b.pdf"], ("report is asked for twice",)),
        (["--pdf", "customer=a.pdf", "--sections", "limits"], ("no such section", "'limits'", "signatures")),
        (["--pdf", "annex="], ("annex=", "customer|workshop|annex|all")),
        (["--assume", "room=1"], ("'room'", "room_temperature_k")),
        (["--guard", "-1"], ("-1", "1.645")),
        (["--spool-instrument", "micrometre"], ("did you mean 'micrometer'?",)),
        (["--sheet", "Nope"], ("'Nope'", "Measurements")),
        (["--sheet-unit", "furlong"], ("'furlong'", "inch")),
        (["--jsn", "-"], ("--jsn",)),
        (["--fluid-state", "usd"], ("'usd'", "did you mean 'used'?")),
        (["--fluid", "hipol_atf_iid_used", "--fluid-state", "fresh"], ("describe a used fluid",)),
    ],
)
def test_a_bad_option_is_named_with_its_value(
    run: Run, sample_readings: Path, options: list[str], words: tuple[str, ...]
) -> None:
    status, out, err = run("diagnose", sample_readings, *options)
    assert (status, out) == (2, "")
    for word in words:
        assert word in err


@pytest.mark.parametrize("option", ["--json", "--xlsx", "--pdf"])
@pytest.mark.parametrize("target", ["nowhere/out.file", "."])
def test_an_output_that_cannot_be_written(
    run: Run, small_sheet: SmallSheet, tmp_path: Path, option: str, target: str
) -> None:
    status, _, err = run("diagnose", small_sheet(), "--controller", "minimal_example", option, tmp_path / target)
    assert status == 2
    assert "cannot be written" in err
    assert tmp_path.name in err


def test_nothing_is_written_over_what_is_read(run: Run, tmp_path: Path, small_sheet: SmallSheet) -> None:
    sheet = small_sheet()
    before = sheet.read_bytes()
    again = tmp_path / "folder" / ".." / sheet.name
    (tmp_path / "folder").mkdir()
    for options in (
        ["--xlsx", sheet],
        ["--json", again],
        ["--pdf", sheet],
        ["--json", tmp_path / "a", "--xlsx", tmp_path / "a"],
    ):
        status, _, err = run("diagnose", sheet, "--controller", "minimal_example", *options)
        assert status == 2
        assert "would be written over" in err
    assert sheet.read_bytes() == before
    assert not (tmp_path / "a").exists()


def test_a_log_without_main_pressure_is_told_and_the_sheet_judged_all_the_same(
    run: Run, sample_readings: Path, tmp_path: Path
) -> None:
    log = tmp_path / "log.csv"
    log.write_text("time [s],engine_speed [rpm],gear\n0,800,1\n1,900,1\n2,950,1\n", encoding="utf-8")
    status, out, _ = run("diagnose", sample_readings, "--road-test", log, "--fail-on", "replace")
    said = " ".join(out.split())
    assert status == 1
    assert "The log holds no main pressure: how well it is held is not known." in said
    assert "No leakage is computed over log.csv: the log has no main pressure" in said


@pytest.mark.parametrize(
    ("pressure", "why"), [("0", "'p_g [kPa]' is 0 throughout"), ("", "'p_g [kPa]' holds no values")]
)
def test_a_main_pressure_that_is_there_but_not_usable_is_not_called_missing(
    run: Run, sample_readings: Path, with_pressure: WithPressure, pressure: str, why: str
) -> None:
    log = with_pressure("dead.csv", lambda _: pressure)
    _, out, _ = run("diagnose", sample_readings, "--road-test", log)
    said = " ".join(out.split())
    assert f"The log holds no usable main pressure: how well it is held is not known. {why}" in said
    assert "the log's column of main pressure is not usable" in said
    assert "no main pressure" not in said


@pytest.mark.parametrize("alone", [True, False])
def test_a_log_is_not_taken_while_it_is_open_which_column_is_its_main_pressure(
    run: Run, sample_readings: Path, with_pressure: WithPressure, alone: bool
) -> None:
    negative = with_pressure("negative.csv", lambda kpa: f"-{kpa}")
    sheet = () if alone else (sample_readings,)
    status, _, err = run("diagnose", *sheet, "--road-test", negative)
    assert status == 2
    assert "negative.csv" in err
    assert "the log's column of main pressure is not usable" in err
    assert "most of its values cannot be main (line) pressure in kPa" in err
    assert "no main pressure" not in err


def test_several_faults_of_a_catalogue_file_are_said_at_once(run: Run, sample_readings: Path, tmp_path: Path) -> None:
    own = tmp_path / "own.toml"
    text = catalogue_files("limits")["project_default"].read_text(encoding="utf-8")
    text = text.replace("percent = 10.0,", "percent = -10.0,").replace("replace = 50.0", 'replace = "50"')
    own.write_text(text, encoding="utf-8")
    status, _, err = run("diagnose", sample_readings, "--limits", own)
    assert status == 2
    assert "-10.0" in err
    assert "key 'replace'" in err


def test_decimal_comma_in_options(sample_readings: Path, record_of: RecordOf) -> None:
    with_comma = record_of(sample_readings, "--temperature", "85,5", "--rpm", "1200,5", "--set", "eccentricity=0,5")
    with_point = record_of(sample_readings, "--temperature", "85.5", "--rpm", "1200.5", "--set", "eccentricity=0.5")
    assert with_comma == with_point
    assert with_comma["projection"]["temperature_c"] == 85.5
    assert with_comma["projection"]["engine_rpm"] == pytest.approx(1200.5, rel=1e-12, abs=0.0)
    assert with_comma["profile"]["eccentricity"] == 0.5


def test_a_stated_condition_reaches_the_projection_and_leaves_hot_idle(
    sample_readings: Path, record_of: RecordOf
) -> None:
    plain = record_of(sample_readings)
    stated = record_of(sample_readings, "--gear", "3", "--temperature", "60", "--rpm", "2000")
    projection = stated["projection"]
    assert (projection["gear"], projection["temperature_c"], projection["engine_rpm"]) == (
        3,
        60.0,
        pytest.approx(2000.0, rel=1e-12, abs=0.0),
    )
    assert stated["hot_idle"] == plain["hot_idle"]
    assert plain["projection"]["name"] == "driving_second"


def test_where_the_spools_lie_is_one_option_whichever_way_it_is_said(
    sample_readings: Path, record_of: RecordOf
) -> None:
    plain = record_of(sample_readings)
    touching = record_of(sample_readings, "--assume", "eccentricity=1")
    unknown = record_of(sample_readings, "--assume", "eccentricity=unknown")
    assert unknown == record_of(sample_readings, "--set", "eccentricity=unknown")
    assert unknown["profile"]["eccentricity"] == "unknown"
    assert "eccentricity" not in "".join(unknown["uncertainty"]["assumptions"])
    for name in ("projection", "hot_idle"):
        # entry loss takes a little off the factor of wide gaps
        ratio = unknown[name]["leakage_dm3_min"] / plain[name]["leakage_dm3_min"]
        assert ratio == pytest.approx(1.5, rel=0.02, abs=0.0)
        factor = touching[name]["leakage_dm3_min"] / plain[name]["leakage_dm3_min"]
        for record in (plain, unknown):
            factors = record[name]["concentric_factor_low"], record[name]["concentric_factor_high"]
            assert factors == pytest.approx((1.0, factor), rel=1e-9, abs=0.0)
    fixed = record_of(sample_readings, "--assume", "eccentricity=0,8", "--assume", "viscosity_percent=3")
    assert fixed["profile"]["eccentricity"] == 0.8
    assert fixed["uncertainty"]["assumptions"]["viscosity_percent"] == pytest.approx(3.0, rel=1e-12, abs=0.0)
    for condition, concentric in zip(fixed["conditions"], plain["conditions"], strict=True):
        factor = condition["leakage_dm3_min"] / concentric["leakage_dm3_min"]
        factors = condition["concentric_factor_low"], condition["concentric_factor_high"]
        assert factors == pytest.approx((factor, factor), rel=1e-9, abs=0.0)


def test_profile_and_set_reach_the_engine(sample_readings: Path, record_of: RecordOf) -> None:
    paper = record_of(sample_readings, "--profile", "paper")
    assert all(gap["drawn_from_pump"] for gap in paper["gaps"])
    changed = record_of(sample_readings, "--profile", "paper", "--set", "diameter=mean", "--set", "entry_loss=on")
    assert (changed["profile"]["diameter"], changed["profile"]["entry_loss"]) == ("mean", "on")
    assert changed["gaps"][0]["diameter_mm"] > paper["gaps"][0]["diameter_mm"]


def test_the_state_of_the_fluid_is_assumed_and_said_or_as_it_was_stated(
    run: Run, sample_readings: Path, record_of: RecordOf
) -> None:
    assumed = record_of(sample_readings)
    stated = record_of(sample_readings, "--fluid-state", "fresh")
    used = record_of(sample_readings, "--fluid-state", "used")
    states = [(each["fluid"]["state"], each["fluid"]["state_assumed"]) for each in (assumed, stated, used)]
    assert states == [("fresh", True), ("fresh", False), ("used", False)]
    said = [any(message["code"] == "fluid_state_assumed" for message in each["messages"]) for each in (assumed, stated)]
    assert said == [True, False]
    leakage = [each["hot_idle"]["leakage_dm3_min"] for each in (assumed, stated, used)]
    assert leakage[0] == leakage[1]
    assert leakage[2] == pytest.approx(leakage[0] * 7.0 / 5.28, rel=0.01, abs=0.0)  # as thin as the study's used oil
    assert used["fluid"]["id"] == "hipol_atf_iid_used"
    _, out, _ = run("diagnose", sample_readings)
    assert "taken as fresh (not stated)" in " ".join(out.split())


def test_the_last_of_an_option_set_twice_counts(sample_readings: Path, record_of: RecordOf) -> None:
    record = record_of(sample_readings, "--set", "diameter=spool", "--set", "diameter=mean")
    assert record["profile"]["diameter"] == "mean"


def test_mileage_reaches_the_record(sample_readings: Path, record_of: RecordOf) -> None:
    record = record_of(sample_readings, "--mileage", "106315")
    assert record["mileage_km"] == 106315.0
    assert {land["replace_mileage_km"] for land in record["lands"]} == {None}  # one visit, nothing measured at 0 km
    assert "no_wear_over_mileage" in {message["code"] for message in record["messages"]}


def test_own_files_by_path(tmp_path: Path, record_of: RecordOf, small_sheet: SmallSheet) -> None:
    own = {}
    for kind, name in (("controllers", "minimal_example"), ("fluids", "mobil_atf_220"), ("limits", "project_default")):
        own[kind] = tmp_path / f"{kind}.toml"
        own[kind].write_bytes(catalogue_files(kind)[name].read_bytes().replace(b'id = "', b'id = "own_', 1))
    record = record_of(
        small_sheet(),
        *("--controller", own["controllers"], "--fluid", own["fluids"], "--limits", own["limits"]),
    )
    assert [record[key]["id"] for key in ("controller", "fluid", "limits")] == [
        "own_minimal_example",
        "own_mobil_atf_220",
        "own_project_default",
    ]
    assert record["readings"]["lands_measured"] == 1


def test_columns_settled_earlier_travel_with_the_job(run: Run, sample_readings: Path, tmp_path: Path) -> None:
    log = tmp_path / "two.csv"
    rows = "".join(f"{i / 10:.1f};1500;8.0;8.1;80;2\n" for i in range(30))
    log.write_text(
        "time [s];engine_speed [rpm];p_g one [bar];p_g two [bar];atf_temperature [°C];gear\n" + rows, encoding="utf-8"
    )
    mapping = ("--map", "main_pressure=p_g two [bar]")
    assert run("import-log", log, *mapping)[0] == 0
    bundle = tmp_path / "job.zip"
    assert run("diagnose", sample_readings, "--road-test", log, "--job-file", bundle)[0] == 0
    assert dict(read_job_file(bundle).case.columns)["main_pressure"] == "p_g two [bar]"


def test_constants_stand_for_channels_the_log_lacks(sample_readings: Path, tmp_path: Path, record_of: RecordOf) -> None:
    log = tmp_path / "pressure only.csv"
    log.write_text(
        "time [s],engine_speed [rpm],p_g [kPa]\n" + "".join(f"{i / 10},1500,800\n" for i in range(20)), encoding="utf-8"
    )
    constants = ("--constant", "atf_temperature=90", "--constant", "converter_pressure=300,5", "--constant", "gear=3")
    record = record_of(sample_readings, "--road-test", log, *constants)
    assert record["road_test"]["gears"] == [3]
    assert not {message["code"] for message in record["messages"]} & {"assumed_gear", "assumed_converter_pressure"}
    hotter = record_of(sample_readings, "--road-test", log, *constants[2:], "--constant", "atf_temperature=100")
    most = [each["road_test"]["max_leakage"]["leakage_dm3_min"] for each in (hotter, record)]
    assert most[0] > most[1]


def test_a_constant_of_no_quantity_is_refused(run: Run, sample_readings: Path, sample_log: Path) -> None:
    status, _, err = run("diagnose", sample_readings, "--road-test", sample_log, "--constant", "atf_temp=90")
    assert status == 2
    assert "did you mean 'atf_temperature'?" in err


@pytest.mark.parametrize("slot", SLOTS)
def test_force_never_writes_over_a_catalogue_file_of_the_command(run: Run, small_sheet: SmallSheet, slot: str) -> None:
    sheet = small_sheet()
    own = sheet.with_name("mine.toml")
    own.write_bytes(catalogue_files(SLOTS[slot].folder)[OWN_FILES[slot]].read_bytes())
    before = own.read_bytes()
    controller = () if slot == "controller" else ("--controller", "minimal_example")
    option = f"--{slot.replace('_', '-')}"
    status, out, err = run("diagnose", sheet, *controller, option, own, "--json", own, "--force")
    assert (status, out) == (2, "")
    assert "would be written over another file of this command" in err
    assert own.read_bytes() == before


@pytest.mark.parametrize(
    ("option", "typed", "shown"),
    [("--rpm", "8505", "8505 rpm"), ("--temperature", "-35", "−35 °C"), ("--mileage", "106", "106 km")],
)
def test_an_unusual_number_is_taken_and_doubted_in_one_line(
    run: Run, small_sheet: SmallSheet, option: str, typed: str, shown: str
) -> None:
    job = ("diagnose", small_sheet(), "--controller", "minimal_example", "--fluid", "mobil_atf_220", "--json", "-")
    status, out, err = run(*job, option, typed)
    assert status == 0
    assert json.loads(out)["format"] == 1
    assert err.startswith("atleak: ")
    assert shown in err
    assert err.count("\n") == 1


def test_without_options_the_command_line_takes_every_default_of_a_job(
    small_sheet: SmallSheet, record_of: RecordOf, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Case, "__init__", _with_other_defaults(Case.__init__))
    record = record_of(small_sheet(), "--controller", "minimal_example")
    assert record["profile"]["name"] == "paper"


def _with_other_defaults(make: Callable[..., None]) -> Callable[..., None]:
    return lambda case, **fields: make(case, **{"profile": "paper", **fields})


def test_a_decision_on_a_land_that_the_valve_body_lacks_ends_with_its_name(
    run: Run, sample_readings: Path, tmp_path: Path
) -> None:
    record = tmp_path / "job.toml"
    record.write_text('[[repair_decisions]]\ncomponent = "25"\nland = 9\nwork = "sleeve"\n', encoding="utf-8")
    status, out, err = run("diagnose", sample_readings, "--job", record)
    assert (status, out) == (2, "")
    assert "job.toml" in err
    assert "repair_decisions 1" in err
    assert "component 25 has no such land" in err
