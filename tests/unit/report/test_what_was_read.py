"""The workbook shows the file's own table as it was read: numbers as numbers, a colour and a word for every kind."""

from __future__ import annotations

import io

import openpyxl
import pytest

from atleak.common.style import cell_colour
from atleak.job.case import Case, Reader, SourceFile
from atleak.measurements.readings import CellKind
from atleak.report.tables.what_was_read import KIND_WORDS
from atleak.report.xlsx import write_workbook

SHEET = """Valve;Land;Part;Diameter [mm];Remark
5;1;spool;14.001;=1+1
5;1;spool;13.999;
5;1;sleeve;14.069;
5;1;mean;14.069;
"""
FILE = SourceFile("sheet.csv", SHEET.encode())


@pytest.mark.parametrize(("language", "name"), [("en", "What was read"), ("de", "Was gelesen wurde")])
def test_the_sheet_of_what_was_read(language, name):
    written = write_workbook(Case(readings=FILE).diagnose(), language=language)
    page = openpyxl.load_workbook(io.BytesIO(written))[name]
    rows = {row[0].value: row for row in page.iter_rows() if isinstance(row[0].value, int)}
    assert [rows[number][5].value for number in (2, 3, 4, 5)] == [14.001, 13.999, 14.069, 14.069]
    fills = [rows[number][5].fill.fgColor.rgb[2:] for number in (2, 4, 5)]
    assert fills == [cell_colour(kind, on_screen=False)[1:] for kind in ("spool", "sleeve", "aside")]
    assert rows[2][6].value == "=1+1"
    assert rows[2][6].data_type == "s"
    words = {cell.value for cell in page["B"]}
    if language == "en":
        assert {"this row counts", "left aside: mean", KIND_WORDS[CellKind.SPOOL]} <= words
    assert page.page_setup.fitToHeight == 0


def test_without_cells_the_workbook_has_no_such_sheet():
    class WithoutCells(Reader):
        with_cells = False

    written = write_workbook(Case(readings=FILE).diagnose(WithoutCells()))
    assert "What was read" not in openpyxl.load_workbook(io.BytesIO(written)).sheetnames
