"""Readings that a sheet marks as taken at the unworn end of a bore."""

from __future__ import annotations

import io

import openpyxl
import pytest

from atleak.common.errors import ReadingsError
from atleak.measurements.clearances import clearances
from atleak.readers.sheets.measuring_sheet import read_readings
from atleak.report.sheets.measuring_columns import SHEET, UNWORN_END
from atleak.report.sheets.measuring_sheet import write_template

HEADINGS = "Valve;Part;Plane;Direction;Diameter [mm];Remark"
WORN = ["tcc_regulator;spool;1;0;10.999;", "tcc_regulator;sleeve;1;0;11.060;"]


def sheet(*rows, headings=HEADINGS):
    return "\n".join([headings, *rows]).encode()


@pytest.mark.parametrize(
    "mark", ["unworn end", "New end of the bore", "unverschlissenes Ende", "niezużyty koniec", "Unworn end (sleeve)"]
)
def test_a_reading_at_an_unworn_end_is_of_the_new_pair_and_not_of_its_wear(controller, mark) -> None:
    readings = read_readings(sheet(*WORN, f"tcc_regulator;sleeve;1;0;11.035;{mark}"), controller)
    assert [each.diameter for each in readings.unworn] == [pytest.approx(11.035e-3, abs=1e-12)]
    worn = next(each for each in clearances(readings, controller) if each.measured)
    new = next(each for each in clearances(readings.when_new, controller) if each.measured)
    assert worn.radial_clearance == pytest.approx(30.5e-6, abs=1e-12)
    assert new.radial_clearance == pytest.approx(18e-6, abs=1e-12)  # beside the spool as it is
    (said,) = [message.text for message in readings.messages if message.code == "unworn_ends"]
    assert "1 reading at an unworn end (component tcc_regulator, plane 1)" in said


@pytest.mark.parametrize("remark", ["looks unworn", "no unworn end", "new", "end"])
def test_a_remark_that_says_something_else_is_none(controller, remark) -> None:
    rows = [*WORN, f"tcc_regulator;sleeve;1;90;11.035;{remark}"]
    readings = read_readings(sheet(*rows), controller)
    assert not readings.unworn
    assert len(readings.readings) == 3
    assert readings.when_new is readings


def test_a_spool_with_an_unworn_end_of_its_own_is_taken_there(controller) -> None:
    rows = [*WORN, "tcc_regulator;sleeve;1;0;11.035;unworn end", "tcc_regulator;spool;1;0;11.003;unworn end"]
    readings = read_readings(sheet(*rows), controller)
    new = next(each for each in clearances(readings.when_new, controller) if each.measured)
    assert new.radial_clearance == pytest.approx(16e-6, abs=1e-12)
    alone = read_readings(sheet(*WORN, rows[-1]), controller)
    assert not alone.when_new.readings  # the bore is worn, whatever the spool was


def test_their_repeats_count_by_themselves(controller) -> None:
    rows = [
        "tcc_regulator;spool;1;0;1;10.999;",
        "tcc_regulator;sleeve;1;0;1;11.060;",
        "tcc_regulator;sleeve;1;0;2;11.061;",
        "tcc_regulator;sleeve;1;0;1;11.034;unworn end",
        "tcc_regulator;sleeve;1;0;2;11.036;unworn end",
    ]
    headings = "Valve;Part;Plane;Direction;Repeat;Diameter [mm];Remark"
    readings = read_readings(sheet(*rows, headings=headings), controller)
    assert [each.repeat for each in readings.unworn] == [1, 2]
    assert not [message for message in readings.messages if message.level == "warning" and "repeat" in message.code]


def test_a_bore_that_is_smaller_than_its_spool_at_its_unworn_end_is_refused(controller) -> None:
    with pytest.raises(ReadingsError, match=r"row 4.*smaller than the spool"):
        read_readings(sheet(*WORN, "tcc_regulator;sleeve;1;0;10.980;unworn end"), controller)


def test_the_form_s_last_column_marks_them(controller) -> None:
    book = openpyxl.load_workbook(io.BytesIO(write_template(controller)))
    page = book[SHEET]
    first = next(row for row in range(1, page.max_row) if page.cell(row, 1).value == "No.") + 1
    rows = [row for row in range(first, page.max_row) if page.cell(row, 3).value == "sleeve"]
    page.cell(rows[0], 8).value = page.cell(rows[0], 12).value
    page.cell(rows[0], 17).value = UNWORN_END
    out = io.BytesIO()
    book.save(out)
    readings = read_readings(out.getvalue(), controller, name="filled.xlsx")
    assert (len(readings.unworn), len(readings.readings)) == (1, 0)
