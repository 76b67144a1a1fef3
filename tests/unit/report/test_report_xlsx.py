"""The workbook, read back."""

from __future__ import annotations

import io
from dataclasses import replace

import openpyxl
import pandas as pd
import pytest

from atleak.report.xlsx import write_workbook


def test_plain_sheets_are_read_by_pandas(worn):
    sheets = pd.read_excel(io.BytesIO(write_workbook(worn)), sheet_name=None, engine="calamine")
    assert list(sheets) == ["Summary", "Lands", "Gaps", "Rules", "Road test", "Messages", "Provenance"]
    lands = sheets["Lands"]
    assert lands["component"].astype(str).tolist() == [found.state.land.component for found in worn.lands]
    assert lands["radial_clearance_um"].tolist() == pytest.approx(
        [found.state.radial_clearance * 1e6 for found in worn.lands], rel=1e-12
    )
    assert len(sheets["Gaps"]) == len(worn.projection.gaps)


def test_nothing_a_user_typed_becomes_a_formula(worn, hostile):
    for text in hostile:
        readings = replace(worn.readings, file=text)
        book = openpyxl.load_workbook(io.BytesIO(write_workbook(replace(worn, readings=readings))))
        found = [cell for sheet in book for row in sheet.iter_rows() for cell in row if cell.value == text]
        assert found, text
        assert {cell.data_type for cell in found} == {"s"}
        assert all(cell.hyperlink is None for cell in found)
