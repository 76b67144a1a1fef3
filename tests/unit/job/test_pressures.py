"""Gauge readings as a job, alone and beside the rest, and kept in its file."""

from __future__ import annotations

import io
from dataclasses import replace
from pathlib import Path

import openpyxl
import pytest

from atleak.common.errors import PressureTableError, ReadingsError
from atleak.common.verdicts import Verdict
from atleak.job.case import Case, SourceFile
from atleak.job.zip_file import read_job_file, write_job_file
from atleak.report.json.diagnosis import diagnosis_record
from atleak.report.sheets.measuring_sheet import write_template
from atleak.report.sheets.pressure_sheet import PRESSURES_TITLE

GAUGES = "range;slow idle [kPa];stall [kPa]\nD;380,5;1100\nP;400;\n"


def gauges(text: str = GAUGES, name: str = "gauges.csv") -> SourceFile:
    return SourceFile(name, text.encode())


def sheet_with_tab(content: bytes, drive: float | None = None) -> SourceFile:
    """A measuring sheet with a reading in drive at slow idle on its tab; none leaves the tab empty."""
    book = openpyxl.load_workbook(io.BytesIO(content))
    tab = book[PRESSURES_TITLE]
    row = next(row for row in tab.iter_rows(min_row=7) if row[0].value == "D")
    row[2].value = drive
    target = io.BytesIO()
    book.save(target)
    return SourceFile("sheet.xlsx", target.getvalue())


def test_gauge_readings_are_a_job_of_their_own() -> None:
    diagnosis = Case(pressures=gauges()).diagnose()
    assert diagnosis.readings is None
    assert (diagnosis.verdict, diagnosis.decision) == (Verdict.WATCH, "fail")
    assert diagnosis.pressures is not None
    assert len(diagnosis.pressures.readings) == 3


def test_a_template_of_which_only_the_tab_is_filled_in_is_a_job(four_speed) -> None:
    diagnosis = Case(readings=sheet_with_tab(write_template(four_speed), 300.0)).diagnose()
    assert diagnosis.readings is None
    assert diagnosis.verdict == Verdict.CRITICAL
    with pytest.raises(ReadingsError, match="no readings are filled in"):
        Case(readings=sheet_with_tab(write_template(four_speed))).diagnose()


def test_a_file_of_its_own_goes_before_the_tab_and_says_so(sample_readings: Path) -> None:
    sheet = sheet_with_tab(sample_readings.read_bytes(), 450.0)
    of_tab = Case(readings=sheet).diagnose()
    assert of_tab.pressures.table.file == "sheet.xlsx"
    assert [each.reading.pressure for each in of_tab.pressures.readings] == [450e3]
    both = Case(readings=sheet, pressures=gauges()).diagnose()
    assert both.pressures.table.file == "gauges.csv"
    assert any(message.code == "pressure_tab_aside" for message in both.messages)
    assert both.readings is not None


def test_a_bad_table_names_its_file() -> None:
    with pytest.raises(PressureTableError, match=r"gauges\.csv, row 2, column range"):
        Case(pressures=gauges("range;stall [kPa]\nX;400\n")).diagnose()


def test_a_table_changes_the_key_of_a_job() -> None:
    assert Case().key != Case(pressures=gauges()).key != Case(pressures=gauges(GAUGES.replace("380,5", "380,6"))).key


@pytest.mark.parametrize("kind", ["alone", "beside a sheet", "tab", "tab alone"])
def test_a_job_file_keeps_the_table_and_gives_the_same_result(kind: str, sample_readings: Path, four_speed) -> None:
    case = {
        "alone": lambda: Case(pressures=gauges()),
        "beside a sheet": lambda: Case(readings=SourceFile.at(sample_readings), pressures=gauges()),
        "tab": lambda: Case(readings=sheet_with_tab(sample_readings.read_bytes(), 450.0)),
        "tab alone": lambda: Case(readings=sheet_with_tab(write_template(four_speed), 300.0)),
    }[kind]()
    before = case.diagnose()
    opened = read_job_file(write_job_file(before, None, case))
    after = opened.diagnose()
    assert (opened.case.pressures is None) == ("tab" in kind)
    assert after.pressures.readings == before.pressures.readings
    assert after.verdict == before.verdict
    assert diagnosis_record(after)["pressure_table"] == opened.result["pressure_table"]


def test_a_job_file_wants_the_table_that_the_result_rests_on() -> None:
    case = Case(pressures=gauges())
    diagnosis = case.diagnose()
    other = replace(case, pressures=gauges(GAUGES.replace("380", "390")))
    with pytest.raises(Exception, match="table of gauge readings is not the one"):
        write_job_file(diagnosis, None, other)
