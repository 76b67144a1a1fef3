"""The workbook of a gauge study: what is filled in is read back."""

from __future__ import annotations

import io

import numpy as np
import openpyxl
import pytest

from atleak.common.translations import languages
from atleak.common.wording import wording
from atleak.measurements.gauge_study import GaugeStudyError
from atleak.readers.gauges.gauge_study import read_study
from atleak.report.sheets.gauge_study_form import STUDY_HEADER, write_study_form


@pytest.mark.parametrize("language", languages())
def test_a_form_that_is_filled_in_is_read_back(language: str) -> None:
    book = openpyxl.load_workbook(io.BytesIO(write_study_form(4, 3, 2, wording(language))))
    random = np.random.default_rng(0)
    sheet = book.active
    for row in range(STUDY_HEADER + 2, sheet.max_row + 1):
        sheet.cell(row, 4).value = 12.7 + round(float(random.random()) / 100, 4)
    target = io.BytesIO()
    book.save(target)
    study = read_study(target.getvalue())
    assert study.values.shape == (4, 3, 2)
    assert study.operators == ("A", "B", "C")


def test_an_empty_form_is_refused_as_not_filled_in() -> None:
    with pytest.raises(GaugeStudyError, match="no reading is filled in"):
        read_study(write_study_form())


def test_everybody_measures_all_parts_before_anybody_begins_again() -> None:
    sheet = openpyxl.load_workbook(io.BytesIO(write_study_form(2, 2, 2))).active
    rows = [[cell.value for cell in row[:3]] for row in sheet.iter_rows(min_row=STUDY_HEADER + 2)]
    assert rows[:4] == [[1, "A", 1], [2, "A", 1], [1, "B", 1], [2, "B", 1]]
    assert {row[2] for row in rows[4:]} == {2}


def test_a_study_of_one_person_has_no_form() -> None:
    with pytest.raises(ValueError, match="2 to 60"):
        write_study_form(operators=1)
