"""The cells of a long sheet are kept column by column, numbers packed, and none is lost on the way."""

from __future__ import annotations

import io
from collections.abc import Callable

import numpy as np
import openpyxl
import pytest

from atleak.intake.native import sheet_slices, workbooks
from atleak.intake.road_test import read_road_test
from atleak.intake.road_test.files.sheet_cells import SheetCells

from .test_importer import workbook


def cells() -> SheetCells:
    packed = np.array([3.0, np.nan, 5.0]).tobytes()
    blank = np.full(2, np.nan).tobytes()
    return SheetCells([["Time", "RPM"], [1, 10.0], [2, None]], [(3, [packed, ["a", None, 7.0]]), (2, [blank, [None, None]])])  # fmt: skip  # noqa: E501


def test_a_column_of_numbers_is_one_array_and_any_other_a_list() -> None:
    sheet = cells()
    assert sheet.rows == 8
    assert np.array_equal(sheet.column(0, 1), [1, 2, 3, np.nan, 5, np.nan, np.nan], equal_nan=True)
    assert sheet.column(1, 1) == [10.0, None, "a", None, 7.0, None, None]
    assert sheet.column(0, 0)[:4] == ["Time", 1, 2, 3.0]
    assert sheet.column(5, 1) == [None] * 7


def test_blank_rows_at_the_end_go_and_those_between_stay() -> None:
    sheet = cells()
    sheet.drop_blank_end()
    assert sheet.rows == 6
    sheet.blocks[-1] = (3, [np.array([3.0, np.nan, np.nan]).tobytes(), ["a", None, None]])
    sheet.drop_blank_end()
    assert (sheet.rows, sheet.column(1, 3)) == (4, ["a"])


def test_a_workbook_of_several_blocks_reads_as_one(monkeypatch: pytest.MonkeyPatch) -> None:
    rows: list[list[object]] = [["Time (s)", "RPM (rpm)", "Gear"]]
    rows += [[i * 0.1, 900 + i if i % 7 else None, "R" if i == 60 else i // 25 + 1] for i in range(90)]
    data = workbook({"Log": rows})
    monkeypatch.setattr(workbooks, "HEAD", 20)
    monkeypatch.setattr(workbooks, "BLOCK", 30)
    blocks = list(workbooks.log_blocks(data))
    assert [(count, len(head), len(columns)) for _, _, count, head, columns in blocks] == [
        (20, 20, 0), (30, 0, 3), (30, 0, 3), (11, 0, 3),
    ]  # fmt: skip
    assert [type(column) for column in blocks[2][4]] == [bytes, bytes, list]
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


def test_cells_further_to_the_left_come_later() -> None:
    sheet = SheetCells()
    sheet.add(3, 2, [["Time"], [1]], [])
    sheet.add(3, 2, [], [np.array([2.0, 3.0]).tobytes()])
    sheet.add(1, 1, [], [["note"], np.array([np.nan]).tobytes(), np.array([4.0]).tobytes()])
    assert sheet.column(0, 0) == [None, None, None, None, "note"]
    assert sheet.column(2, 0) == ["Time", 1, 2.0, 3.0, 4.0]


@pytest.mark.slow
def test_a_log_of_many_slices_is_read_whole(bare_workbook: Callable[..., bytes]) -> None:
    names = ("Time (s)", "RPM (rpm)", "ATF (°C)")
    head = "".join(f'<c r="{letter}1" t="str"><v>{name}</v></c>' for letter, name in zip("ABC", names, strict=True))
    rows = "".join(
        f'<row r="{n}"><c r="A{n}"><v>{n / 10}</v></c><c r="B{n}"><v>{900 + n % 50}</v></c><c><v>80.5</v></c></row>'
        for n in range(2, 260_002)
    )
    data = bare_workbook(f'<sheetData><row r="1">{head}</row>{rows}</sheetData>')
    assert len(rows) > sheet_slices.LARGE
    test = read_road_test(data)
    assert (test.rows, test.duration) == (260_000, pytest.approx(25999.9, abs=1e-6))
    assert np.array_equal(np.round(test.values("engine_speed") * 60, 6), 900 + np.arange(2, 260_002) % 50.0)
