"""The workbook's verdict counts what a road test says of main pressure among its rules."""

from __future__ import annotations

import io
from dataclasses import replace
from pathlib import Path

import openpyxl
import pytest

from atleak.common.verdicts import Verdict
from atleak.common.wording import signed
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.job.case import Case, SourceFile
from atleak.report.xlsx import write_workbook
from tests.unit.conftest import first_of


@pytest.mark.parametrize("factor", first_of([0.4, 1.0]))
def test_the_verdict_of_a_sheet_and_a_log_follows_from_the_workbooks_cells(
    sample_diagnoses: dict[str, Diagnosis], calculator: type, factor: float
) -> None:
    sample = sample_diagnoses["workshop"]
    log = sample.log.road_test
    main = log.channels["main_pressure"]
    scaled = replace(main, values=main.values * factor)
    low = replace(log, channels={**log.channels, "main_pressure": scaled}, _held={})
    both = diagnose(sample.controller, sample.fluid, sample.limits, readings=sample.readings, road_test=low)
    assert (both.verdict == Verdict.CRITICAL) == (factor < 1.0)
    sheets = calculator(write_workbook(both))
    assert sheets.value("Summary", "B5") == signed(both.verdict)
    assert sheets.value("Summary", "B7").startswith(f"Provisional. {signed(both.verdict)}: ")


@pytest.mark.parametrize(("name", "heading"), [("Road test", "Lowest, lasting"), ("Gauge readings", "Gauge")])
def test_values_are_in_the_reader_s_unit_that_their_heading_names(
    sample_diagnoses: dict[str, Diagnosis], sample_readings: Path, name: str, heading: str
) -> None:
    diagnosis = sample_diagnoses["workshop"]
    if name == "Gauge readings":
        gauges = SourceFile.at(sample_readings.with_name("gauge_readings_five_speed.csv"))
        diagnosis = Case(controller="five_speed_2005", pressures=gauges).diagnose()
    read = {}
    for units, unit in (("metric", "kPa"), ("us", "psi")):
        sheet = openpyxl.load_workbook(io.BytesIO(write_workbook(diagnosis, units=units)))[name]
        (head,) = [cell for row in sheet.iter_rows() for cell in row if str(cell.value).startswith(heading)]
        assert str(head.value).endswith(f"[{unit}]")
        cells = [sheet.cell(head.row + at, head.column).value for at in range(1, 5)]
        read[units] = [value for value in cells if value is not None]
    assert read["us"] == pytest.approx([kpa / 6.894757293168361 for kpa in read["metric"]], rel=1e-12, abs=0.0)


def test_a_gear_is_a_number_and_seconds_have_two_decimals(sample_diagnoses: dict[str, Diagnosis]) -> None:
    sheet = openpyxl.load_workbook(io.BytesIO(write_workbook(sample_diagnoses["workshop"])))["Road test"]
    (gear,) = [cell for row in sheet.iter_rows() for cell in row if cell.value == "Gear"]
    first = {sheet.cell(gear.row, at).value: sheet.cell(gear.row + 1, at) for at in range(1, 10)}
    assert isinstance(first["Gear"].value, int | float)
    assert {key: cell.number_format for key, cell in first.items() if key.endswith("[s]")} == {
        "Judged for [s]": "#,##0.00",
        "Below for [s]": "#,##0.00",
        "Above for [s]": "#,##0.00",
    }
