"""A measuring sheet to fill in."""

from __future__ import annotations

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
            page.cell(row, column["Diameter"]).value = nominal
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
    assert "Średnica [in]" in [cell.value for cell in book["Pomiary"][7]]


def test_what_is_known_of_the_job_stands_in_the_head_the_options_before_the_record(run: Run, tmp_path: Path) -> None:
    record, sheet = tmp_path / "job.toml", tmp_path / "sheet.xlsx"
    record.write_text('number = "2026-0417"\n[vehicle]\nvin = "YV1SW61"\nmileage_km = 212000\n', encoding="utf-8")
    told = ("--job", record, "--number", "2026-0418", "--serial", "=1+1", "--measured-by", "K. Weber")
    status, _, _ = run("template", "--controller", "minimal_example", *told, "-o", sheet)
    assert status == 0
    page = openpyxl.load_workbook(sheet).worksheets[0]
    assert [page[cell].value for cell in ("C4", "J5", "C5", "C6", "G5")] == [
        "2026-0418", "YV1SW61", "212000 km", "=1+1", "K. Weber",
    ]  # fmt: skip
    assert page["C6"].data_type == "s"


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
