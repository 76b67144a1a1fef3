"""A large sheet read in slices gives the cells that calamine gives of the whole."""

from __future__ import annotations

import datetime as dt
import io
import zipfile
from collections.abc import Callable

import openpyxl
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from atleak.intake.native import sheet_slices, workbooks
from atleak.intake.native.child import Damaged, Refused
from atleak.intake.native.workbooks import first_rows, log_blocks
from atleak.intake.road_test.files.sheet_cells import SheetCells

Build = Callable[..., bytes]

pytestmark = pytest.mark.usefixtures("small_slices")


@pytest.fixture(scope="module")
def small_slices() -> object:
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(sheet_slices, "SLICE", 1)  # so that half the shared parts' length counts, some 3 kB
        patched.setattr(sheet_slices, "_READ", 2048)
        patched.setattr(workbooks, "HEAD", 20)
        patched.setattr(workbooks, "BLOCK", 30)
        yield patched


def cells_of(data: bytes, large: int) -> dict[str, tuple[int | None, int, list[object]]]:
    """Return of each sheet its first column, its number of rows, and all its cells, column by column."""
    sheets: dict[str, SheetCells] = {}
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(sheet_slices, "LARGE", large)
        for name, *block in log_blocks(data):
            sheets.setdefault(name, SheetCells()).add(*block)
    return {
        name: (cells.left, cells.rows, [list(map(_plain, cells.column(index, 0))) for index in range(12)])
        for name, cells in sheets.items()
    }


def _plain(cell: object) -> object:
    """Return a cell with its kind; a number as the float that a packed column holds, and of those None for NaN."""
    if isinstance(cell, float | int) and not isinstance(cell, bool):
        return None if cell != cell else float(cell)
    return (type(cell).__name__, cell) if cell is not None else None


def slices_of(data: bytes) -> int:
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(sheet_slices, "LARGE", 0)
        slices = sheet_slices.Slices(data)
        return sum(1 for name in slices.names for _ in slices.of(name))


def assert_alike(data: bytes) -> None:
    assert cells_of(data, 0) == cells_of(data, sheet_slices.LARGE)


CELL = st.one_of(
    st.none(),
    st.floats(-1e6, 1e6),
    st.integers(-1000, 1000),
    st.booleans(),
    st.sampled_from(["Off", "", "13:40", " x ", "<&>", "1,5", "#N/A", "äöü 😀", "</row>"]),
    st.datetimes(dt.datetime(1950, 1, 1), dt.datetime(2080, 1, 1)).map(lambda day: day.replace(microsecond=0)),
    st.times().map(lambda time: time.replace(microsecond=0)),
    st.timedeltas(dt.timedelta(0), dt.timedelta(days=3)),
)


@pytest.mark.hypothesis
@settings(deadline=None)
@given(
    rows=st.lists(st.tuples(st.integers(1, 40), st.integers(0, 3), st.lists(CELL, max_size=5)), max_size=60),
    counted_from_1904=st.booleans(),
)
def test_slices_give_what_the_whole_gives(rows: list[tuple[int, int, list[object]]], counted_from_1904: bool) -> None:
    book = openpyxl.Workbook()
    if counted_from_1904:
        book.epoch = openpyxl.utils.datetime.CALENDAR_MAC_1904
    sheet = book.active
    number = 0
    for onward, left, cells in rows:
        number += onward
        for index, cell in enumerate(cells):
            sheet.cell(number, left + index + 1, cell)
    book.create_sheet("Other").append(["Time", "RPM"])
    stream = io.BytesIO()
    book.save(stream)
    assert_alike(stream.getvalue())


def long_sheet(rows: str, prefix: str = "") -> str:
    return f"<{prefix}sheetData>{rows}</{prefix}sheetData>"


def test_rows_without_numbers_are_counted_on(bare_workbook: Build) -> None:
    numbered = "".join(f'<row r="{n}"><c><v>{n}</v></c><c><v>{n * 2}</v></c></row>' for n in range(3, 40))
    counted = "".join(f"<row><c><v>{n}</v></c><c/><c><v>1</v></c></row><row/>" for n in range(200))
    data = bare_workbook(long_sheet(numbered + counted))
    assert slices_of(data) > 5
    assert_alike(data)


@pytest.mark.parametrize(
    "row",
    [
        "<row spans='1:2' r='{n}' ><c r='A{n}'><v>{n}</v></c><c t='b' r='B{n}'><v>1</v></c></row>",
        '<row r="{n}"><c r="C{n}" t="inlineStr"><is><t>a &lt;/row&gt; {n}</t></is></c></row>',
        '<row r="{n}"><c r="C{n}" t="str"><f>A1&amp;B1</f><v>text</v></c><c r="D{n}" t="e"><v>#DIV/0!</v></c></row>',
    ],
)
def test_cells_written_in_other_ways(bare_workbook: Build, row: str) -> None:
    data = bare_workbook(long_sheet("".join(row.format(n=n) for n in range(1, 200))))
    assert slices_of(data) > 5
    assert_alike(data)


def test_cells_further_to_the_left_and_a_stray_one_below(bare_workbook: Build) -> None:
    rows = "".join(f'<row r="{n}"><c r="D{n}"><v>{n}</v></c><c r="E{n}"><v>0</v></c></row>' for n in range(5, 150))
    rows += '<row r="150"><c r="B150"><v>7</v></c></row><row r="400"><c r="J400"><v>8</v></c></row>'
    data = bare_workbook(long_sheet(rows))
    assert slices_of(data) > 3
    assert_alike(data)
    left, count, columns = cells_of(data, 0)["Sheet"]
    assert (left, count) == (1, 396)
    assert columns[0][145] == 7.0
    assert columns[8][395] == 8.0


def test_a_sheet_whose_names_have_a_prefix(bare_workbook: Build) -> None:
    rows = "".join(f'<x:row r="{n}"><x:c r="A{n}"><x:v>{n}</x:v></x:c></x:row>' for n in range(1, 200))
    data = bare_workbook(long_sheet(rows, "x:"))
    assert slices_of(data) > 3
    assert_alike(data)


def test_a_sheet_that_breaks_off_is_refused_either_way(bare_workbook: Build) -> None:
    rows = "".join(f'<row r="{n}"><c r="A{n}"><v>{n}</v></c></row>' for n in range(1, 400))
    data = bare_workbook("<sheetData>" + rows + '<row r="400"><c r="A4')
    for large in (0, sheet_slices.LARGE):
        with pytest.raises(Damaged, match=r"not closed|before end of input"):
            cells_of(data, large)


def test_rows_out_of_order_are_refused_and_not_mixed_up(bare_workbook: Build) -> None:
    rows = "".join(f'<row r="{n}"><c r="A{n}"><v>{n}</v></c></row>' for n in (*range(200, 400), *range(1, 100)))
    with pytest.raises(Refused, match="not in the order"):
        cells_of(bare_workbook(long_sheet(rows)), 0)


def test_a_row_without_end_is_refused(bare_workbook: Build, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sheet_slices, "_LONGEST_ROW", 10_000)
    data = bare_workbook(long_sheet('<row r="1">' + "<c><v>1</v></c>" * 3000 + "</row>"))
    with pytest.raises(Refused, match="a row of this workbook takes more than"):
        cells_of(data, 0)


def test_a_log_of_more_cells_than_its_size_allows_is_refused_slice_by_slice(
    bare_workbook: Build, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(workbooks, "LOG_CELLS", 1000)
    monkeypatch.setattr(workbooks, "LOG_CELLS_PER_BYTE", 0)
    rows = "".join(f'<row r="{n}"><c r="A{n}"><v>1</v></c><c r="E{n}"><v>1</v></c></row>' for n in range(1, 300))
    for large in (0, sheet_slices.LARGE):
        with pytest.raises(Refused, match="the cells of this sheet reach row"):
            cells_of(bare_workbook(long_sheet(rows)), large)


def test_a_look_at_a_log_reads_its_first_slice_only(bare_workbook: Build, monkeypatch: pytest.MonkeyPatch) -> None:
    rows = "".join(f'<row r="{n}"><c r="A{n}"><v>{n}</v></c></row>' for n in range(1, 400))
    data = bare_workbook(long_sheet(rows))
    monkeypatch.setattr(sheet_slices, "LARGE", 0)
    opened: list[int] = []
    whole = workbooks._opened
    monkeypatch.setattr(workbooks, "_opened", lambda part: opened.append(len(part)) or whole(part))
    (sheet,) = first_rows(data)
    assert sheet["rows"][:2] == [[1.0], [2.0]]
    assert len(opened) == 2, "the workbook without its large sheet, and one slice"


def test_texts_that_sheets_share_and_a_second_small_sheet(monkeypatch: pytest.MonkeyPatch) -> None:
    book = openpyxl.Workbook()
    for number in range(300):
        book.active.append([number * 0.1, f"text {number % 50}"])
    book.create_sheet("Notes").append(["a note"])
    stream = io.BytesIO()
    book.save(stream)
    data = stream.getvalue()
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        sizes = {entry.filename: entry.file_size for entry in archive.infolist()}
    monkeypatch.setattr(sheet_slices, "LARGE", sizes["xl/worksheets/sheet1.xml"] - 1)
    assert sheet_slices.Slices(data).names == {"Sheet"}
    assert cells_of(data, sheet_slices.LARGE) == cells_of(data, 1 << 30)


def test_a_workbook_of_another_form_is_not_cut() -> None:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        archive.writestr("content.xml", "<office/>" * 100)
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(sheet_slices, "LARGE", 0)
        assert sheet_slices.Slices(stream.getvalue()).names == frozenset()
