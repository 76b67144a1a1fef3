"""A measuring sheet to fill in."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import openpyxl
import pytest

from atleak.catalogue.controller import Controller
from atleak.readers.sheets.measuring_sheet import read_readings

Run = Callable[..., tuple[int, str, str]]
RecordOf = Callable[..., dict[str, Any]]

Process = Callable[..., subprocess.CompletedProcess[bytes]]


@pytest.mark.parametrize("name", ["four_speed_2023", "minimal_example"])
def test_a_filled_template_is_diagnosed(run: Run, tmp_path: Path, name: str, record_of: RecordOf) -> None:
    sheet = tmp_path / "sheet.xlsx"
    status, out, _ = run("template", "--controller", name, "-o", sheet)
    assert status == 0
    assert "written:" in out
    book = openpyxl.load_workbook(sheet)
    page = next(page for page in book if any(_heading(page)))
    heading = next(row for row in page.iter_rows() if any("Diameter" in str(cell.value) for cell in row))
    column = {str(cell.value).split("\n")[0].split(" [")[0]: cell.column for cell in heading}
    filled = 0
    for row in range(heading[0].row + 1, page.max_row + 1):
        nominal = page.cell(row, column["Nominal"]).value
        if isinstance(nominal, int | float):
            page.cell(row, column["Diameter 1"]).value = nominal
            filled += 1
    assert filled > 0
    book.save(sheet)
    record = record_of(sheet, "--controller", name)
    assert record["readings"]["lands_measured"] == record["readings"]["lands_total"]
    assert {land["verdict"] for land in record["lands"]} == {"ok"}
    for land in record["lands"]:
        assert land["wear_percent"] == pytest.approx(0.0, abs=0.5)


def _heading(page: Any) -> list[bool]:
    return [any("Diameter" in str(cell.value) for cell in row) for row in page.iter_rows(max_row=12)]


@pytest.mark.parametrize("output", ["sheet.xls", "sheet", "nowhere/sheet.xlsx"])
def test_a_template_wants_a_workbook_s_name(run: Run, tmp_path: Path, output: str) -> None:
    status, _, err = run("template", "-o", tmp_path / output)
    assert status == 2
    assert "sheet" in err


def test_a_file_written_by_a_process_reads_back(tmp_path: Path, four_speed: Controller, process: Process) -> None:
    finished = process("template", "-o", tmp_path / "sheet.xlsx")
    assert finished.returncode == 0
    with pytest.raises(Exception, match="sheet"):  # nothing is filled in yet
        read_readings(tmp_path / "sheet.xlsx", four_speed)


def test_a_template_has_the_language_and_units_that_are_asked_for(run: Run, tmp_path: Path) -> None:
    sheet = tmp_path / "sheet.xlsx"
    status, _, _ = run("template", "--controller", "minimal_example", "--language", "pl", "--units", "us", "-o", sheet)
    assert status == 0
    book = openpyxl.load_workbook(sheet, read_only=True)
    assert book.sheetnames == ["Pomiary", "Stopnie", "Ciśnienia", "Jak mierzyć"]
    assert "Średnica 1 [in]" in [cell.value for cell in book["Pomiary"][8]]


def test_what_is_known_of_the_job_stands_in_the_head_the_options_before_the_record(run: Run, tmp_path: Path) -> None:
    record, sheet = tmp_path / "job.toml", tmp_path / "sheet.xlsx"
    record.write_text('number = "2026-0417"\n[vehicle]\nvin = "YV1SW61"\nmileage_km = 212000\n', encoding="utf-8")
    told = ("--job", record, "--number", "2026-0418", "--serial", "=1+1", "--measured-by", "K. Weber")
    status, _, _ = run("template", "--controller", "minimal_example", *told, "-o", sheet)
    assert status == 0
    page = openpyxl.load_workbook(sheet).worksheets[0]
    assert [page[cell].value for cell in ("C4", "C6", "C7", "L5", "H4")] == [
        "2026-0418", "YV1SW61", "212000 km", "=1+1", "K. Weber",
    ]  # fmt: skip
    assert page["L5"].data_type == "s"


def test_a_vacuum_card_needs_nothing_and_takes_a_stand(run: Run, tmp_path: Path) -> None:
    card, stand = tmp_path / "card.pdf", tmp_path / "stand.csv"
    status, out, err = run("vacuum-card", "--controller", "five_speed_2005", "-o", card)
    assert (status, err) == (0, "")
    assert "card.pdf" in out
    assert card.read_bytes().startswith(b"%PDF")
    stand.write_text("supply,24,in-Hg\ncalibration,0.5 mm,20\ncircuit,reading\n")
    assert run("vacuum-card", "--vacuum", stand, "--controller", "five_speed_2005", "-o", card, "--force")[0] == 0
    assert run("vacuum-card", "--vacuum", tmp_path / "none.csv", "-o", card, "--force")[0] == 2
    assert run("vacuum-card", "-o", tmp_path / "card.xlsx")[0] == 2


def test_a_gauge_card_needs_no_readings_and_takes_a_sheet(run: Run, tmp_path: Path) -> None:
    card = tmp_path / "card.pdf"
    status, out, err = run("gauge-card", "--controller", "five_speed_2005", "-o", card)
    assert (status, err) == (0, "")
    assert "written:" in out
    assert card.read_bytes().startswith(b"%PDF")
    assert run("gauge-card", "nowhere.xlsx", "-o", card)[0] == 2
    status, _, err = run("gauge-card", "-o", tmp_path / "card.xlsx")
    assert status == 2
    assert ".pdf" in err


@pytest.fixture
def gauges(tmp_path: Path) -> Path:
    path = tmp_path / "gauges.csv"
    path.write_text("tap,range,slow idle [kPa]\nline,D,857\nforward clutch,D,610\n", encoding="utf-8")
    return path


def _filled(sheet: Path, lands: int) -> None:
    """Fill in the first lands of a quick sheet as new ones, two rows each."""
    book = openpyxl.load_workbook(sheet)
    page = book.worksheets[0]
    heading = next(row for row in page.iter_rows() if any("Diameter" in str(cell.value) for cell in row))
    column = {str(cell.value).split("\n")[0].split(" [")[0]: cell.column for cell in heading}
    for row in range(heading[0].row + 1, heading[0].row + 1 + 2 * lands):
        page.cell(row, column["Diameter 1"]).value = page.cell(row, column["Nominal"]).value
    book.save(sheet)


def test_a_quick_sheet_asks_for_the_lands_that_tell_most_in_their_order(run: Run, tmp_path: Path, gauges: Path) -> None:
    sheet, five = tmp_path / "quick.xlsx", ("--controller", "five_speed_2005", "--pressures", gauges)
    assert run("template", "--quick", *five, "-o", sheet)[0] == 0
    told = json.loads(run("evidence", *five, "--json", "-")[1])["next"]
    page = openpyxl.load_workbook(sheet).worksheets[0]
    rows = [row[:5] for row in page.iter_rows(min_row=9, values_only=True) if row[4] is not None]
    assert 2 * len(told) <= len(rows) <= 20
    component, asked = "", list[tuple[str, int]]()
    for row in rows[::2]:  # spool and sleeve
        component = row[0] or component  # written once where its lands follow one another
        asked.append((component, row[3]))
    assert asked[:3] == [(each["component"], each["land"]) for each in told], (
        "a land of this unit has the plane of its number"
    )
    assert {row[4] for row in rows} == {0}
    assert "in this order" in str(page["A2"].value)


def test_a_quick_sheet_reads_back_and_says_whether_more_is_worth_it(
    run: Run, tmp_path: Path, gauges: Path, record_of: RecordOf
) -> None:
    sheet, five = tmp_path / "quick.xlsx", ("--controller", "five_speed_2005", "--pressures", gauges)
    run("template", "--quick", *five, "-o", sheet)
    _filled(sheet, 3)
    record = record_of(sheet, *five)
    assert record["readings"]["lands_measured"] == 3
    assert [each["verdict"] for each in record["lands"]].count("not_measured") == 31
    codes = [each["code"] for each in record["messages"]]
    assert "one_direction" not in codes
    assert codes.count("clearance_lower_bound") == 1, "one direction is said once of all lands"
    assert "in this order" in " ".join(run("diagnose", sheet, *five)[1].split())
    measured = [each["measured"] for each in json.loads(run("evidence", sheet, *five, "--json", "-")[1])["lands"]]
    assert measured.count(True) == 3
    again = tmp_path / "again.xlsx"
    assert run("template", "--quick", sheet, *five, "-o", again)[0] == 0
    first = [row[0] for row in openpyxl.load_workbook(sheet).worksheets[0].iter_rows(min_row=9, values_only=True)]
    next_ones = [row[0] for row in openpyxl.load_workbook(again).worksheets[0].iter_rows(min_row=9, values_only=True)]
    assert first[:6] != next_ones[:6], "what was measured is not asked for again"


def test_where_every_land_was_measured_no_quick_sheet_is_written(run: Run, tmp_path: Path) -> None:
    whole, quick, minimal = tmp_path / "whole.xlsx", tmp_path / "quick.xlsx", ("--controller", "minimal_example")
    run("template", "--quick", *minimal, "-o", whole)
    _filled(whole, 5)
    status, _, err = run("template", "--quick", whole, *minimal, "-o", quick)
    assert (status, quick.exists()) == (2, False)
    assert "no further land is worth a reading" in err


def test_what_only_a_quick_sheet_rests_on_is_doubted_without_it(run: Run, tmp_path: Path, gauges: Path) -> None:
    err = run("template", "--controller", "five_speed_2005", "--pressures", gauges, "-o", tmp_path / "sheet.xlsx")[2]
    assert "--pressures does nothing without --quick" in err
