"""The workbook's verdict counts what a road test says of main pressure among its rules."""

from __future__ import annotations

from dataclasses import replace

import pytest

from atleak.diagnosis import Diagnosis, diagnose
from atleak.report.xlsx import write_workbook
from atleak.verdicts import Verdict
from atleak.wording import signed


@pytest.mark.parametrize("factor", [0.4, 1.0])
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
    assert sheets.value("Summary", "B2") == signed(both.verdict)
    assert sheets.value("Summary", "B4").startswith(f"Provisional. {signed(both.verdict)}: ")
