"""The cells of a long sheet are kept column by column, numbers packed, and none is lost on the way."""

from __future__ import annotations

import io
from collections.abc import Callable

import numpy as np
import openpyxl
import pytest

from atleak.readers.logs import read_road_test
from atleak.readers.logs.log_sheets import SheetCells
from atleak.readers.process import workbooks
from tests.unit.readers.logs.test_importer import workbook


def test_a_column_of_numbers_is_one_array_and_any_other_a_list() -> None:
    packed, blank = np.array([3.0, np.nan, 5.0]).tobytes(), np.full(2, np.nan).tobytes()
    sheet = SheetCells(
        [(3, [["Time", 1, 2], ["RPM", 10.0, None]]), (3, [packed, ["a", None, 7.0]]), (2, [blank, [None, None]])]
    )
    assert sheet.rows == 8
    assert sheet.head(2) == [["Time", "RPM"], [1, 10.0]]
    assert np.array_equal(sheet.column(0, 1), [1, 2, 3, np.nan, 5, np.nan, np.nan], equal_nan=True)
    assert sheet.column(1, 1) == [10.0, None, "a", None, 7.0, None, None]
    assert sheet.column(0, 0)[:4] == ["Time", 1, 2, 3.0]
    assert sheet.column(5, 1) == [None] * 7


def test_a_workbook_of_several_blocks_reads_as_one(monkeypatch: pytest.MonkeyPatch) -> None:
    rows: list[list[object]] = [["Time (s)", "RPM (rpm)", "Gear"]]
    rows += [[i * 0.1, 900 + i if i % 7 else None, "R" if i == 60 else i // 25 + 1] for i in range(90)]
    data = workbook({"Log": rows})
    monkeypatch.setattr(workbooks, "_BLOCK", 30)
    blocks = list(workbooks.log_blocks(data))
    assert [(name, count) for name, count, _ in blocks] == [("Log", 30)] * 3 + [("Log", 1)]
    assert [type(column) for column in blocks[2][2]] == [bytes, bytes, list]
    test = read_road_test(data)
    assert test.rows == 90
    assert test.values("gear")[59:62].tolist() == [3.0, -1.0, 3.0]
    assert test.channels["engine_speed"].samples == 77


def test_a_table_that_begins_in_another_column_and_row() -> None:
    book = openpyxl.Workbook()
    for row in range(61):
        cells = [row * 0.1, 900.0 + row, row // 25 + 1] if row else ["Time (s)", "RPM (rpm)", "Gear"]
        for column, cell in enumerate(cells):
            book.active.cell(3 + row, 4 + column, cell)
    stream = io.BytesIO()
    book.save(stream)
    test = read_road_test(stream.getvalue())
    assert test.rows == 60
    assert test.values("gear")[[0, -1]].tolist() == [1.0, 3.0]
    (seen,) = workbooks.first_rows(stream.getvalue())
    assert seen["rows"][2] == ["", "", "", "Time (s)", "RPM (rpm)", "Gear"]


@pytest.mark.slow
def test_a_long_log_is_read_whole(bare_workbook: Callable[..., bytes]) -> None:
    names = ("Time (s)", "RPM (rpm)", "ATF (°C)")
    head = "".join(f'<c r="{letter}1" t="str"><v>{name}</v></c>' for letter, name in zip("ABC", names, strict=True))
    rows = "".join(
        f'<row r="{n}"><c r="A{n}"><v>{n / 10}</v></c><c r="B{n}"><v>{900 + n % 50}</v></c><c><v>80.5</v></c></row>'
        for n in range(2, 260_002)
    )
    data = bare_workbook(f'<sheetData><row r="1">{head}</row>{rows}</sheetData>')
    test = read_road_test(data)
    assert (test.rows, test.duration) == (260_000, pytest.approx(25999.9, abs=1e-6))
    assert np.array_equal(np.round(test.values("engine_speed") * 60, 6), 900 + np.arange(2, 260_002) % 50.0)
