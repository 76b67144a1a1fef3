"""Reads workbooks (xlsx, xlsb, xls, ods) in the child process."""

from __future__ import annotations

import io
import itertools
import zipfile
from array import array
from collections.abc import Iterable, Iterator
from typing import Any, TypedDict

from atleak.common.sentences import Sentence
from atleak.readers.cells.extent import COLUMNS as WIDTH
from atleak.readers.cells.extent import EXPECTED, MOST_SHEETS, excess, trimmed
from atleak.readers.cells.workbook_marks import CellRange, Marks, marks
from atleak.readers.process.child import Refused, of_library

NativeCell = Any  # str, float, int, bool, date or time; "" where empty

_CELLS = 1_000_000  # that a measuring sheet may span at most; a filled one spans thousands
# cells that a log may span, and more for each byte of its file: a cell takes three, if one in fifty is filled
LOG_CELLS, LOG_CELLS_PER_BYTE = 4_000_000, 16
_COLUMNS = 16_384  # of a sheet in a spreadsheet program
_LOOK = 300  # rows of a sheet in which it shows what it holds
_BLOCK = 20_000  # rows of a log that are handed over together
_NAN = float("nan")


class MeasuringSheet(TypedDict):
    """A worksheet with what its cells alone do not show; ``rows`` and all places count from cell A1."""

    name: str
    hidden: bool
    rows: list[list[NativeCell]]
    merged: list[CellRange]
    marks: dict[str, Any]  # the fields of `atleak.readers.cells.workbook_marks.Marks`


def measuring_sheets(data: bytes) -> Iterator[MeasuringSheet]:
    """Yield every worksheet, with merged ranges, formulas without a usable result, and what is hidden or crossed out.

    `Refused` says that the file is protected by a password, no workbook, or more than people fill in.
    """
    marked: dict[str, Marks] = {}
    for name, hidden, sheet in _worksheets(data):
        rows, columns = (0, 0) if sheet.end is None else (sheet.end[0] + 1, sheet.end[1] + 1)
        _refuse_vast(rows, columns, name, columns * rows > _CELLS)
        ranges = sheet.merged_cell_ranges
        with of_library():
            rows_of_cells = sheet.to_python(skip_empty_area=False)
        cells = trimmed(rows_of_cells)
        if (too_much := excess(cells)) is not None:
            raise Refused(too_much, sheet=name, expected=EXPECTED)
        marked = marked or marks(data)
        found = marked.get(name, Marks())
        yield {
            "name": name,
            "hidden": hidden,
            "rows": cells,
            "merged": _within(found.merged if ranges is None else ranges, cells, name),
            "marks": vars(found),
        }


def first_rows(data: bytes) -> Iterator[MeasuringSheet]:
    """Yield the first rows of every worksheet, of a log too, to see what it holds; merged ranges with them."""
    for name, hidden, sheet in _worksheets(data):
        rows: Iterable[list[NativeCell]] = ()
        if sheet.start is not None:
            _refuse_vast_log(sheet, name, len(data))
            rows = ([""] * sheet.start[1] + row for row in _rows(sheet))  # calamine's begin at its first column
        cells = trimmed([row[:WIDTH] for row in itertools.islice(rows, _LOOK)])
        ranges = [] if sheet.merged_cell_ranges is None else sheet.merged_cell_ranges
        merged = _within(ranges, cells, name)
        yield {"name": name, "hidden": hidden, "rows": cells, "merged": merged, "marks": vars(Marks())}


def log_blocks(data: bytes) -> Iterator[tuple[str, int, list[bytes | list[NativeCell | None]]]]:
    """Yield every worksheet in blocks: its name, how many rows, and their columns.

    A column is packed floats where every cell is a number or empty (NaN), which takes a quarter of the memory, else a
    list with None where a cell is empty. Empty cells before the first column and above the first row are left out.
    """
    for name, _, sheet in _worksheets(data):
        if sheet.start is None:
            continue
        _refuse_vast_log(sheet, name, len(data))
        rows = itertools.islice(_rows(sheet), sheet.start[0], None)
        while block := list(itertools.islice(rows, _BLOCK)):
            yield name, len(block), [_packed(column) for column in itertools.zip_longest(*block, fillvalue="")]


def _rows(sheet: Any) -> Iterator[list[NativeCell]]:
    with of_library():
        yield from sheet.iter_rows()


def _refuse_vast_log(sheet: Any, name: str, size: int) -> None:
    (top, left), (bottom, right) = sheet.start, sheet.end
    vast = (bottom - top + 1) * (right - left + 1) > LOG_CELLS + LOG_CELLS_PER_BYTE * size
    _refuse_vast(bottom + 1, right + 1, name, vast)


def _packed(column: tuple[NativeCell, ...]) -> bytes | list[NativeCell | None]:
    """Return a column as packed floats, or as a list where a cell is neither a number nor empty."""
    try:
        return array("d", [_NAN if cell == "" else cell for cell in column]).tobytes()
    except TypeError:
        return [None if cell == "" else cell for cell in column]


def _worksheets(data: bytes) -> Iterator[tuple[str, bool, Any]]:
    """Yield every worksheet's name, whether it is hidden, and its cells."""
    from python_calamine import CalamineWorkbook, PasswordError, SheetTypeEnum, SheetVisibleEnum

    protected = Refused(
        Sentence("this workbook is protected by a password"), expected=Sentence("the workbook saved without a password")
    )
    if data.startswith(b"PK"):
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            names = archive.namelist()
        if not {"xl/workbook.xml", "xl/workbook.bin", "content.xml"} & set(names):
            raise Refused(
                Sentence("this file is a ZIP archive, not a workbook"),
                value=", ".join(names[:3]),
                expected=Sentence("the file itself: unpack the archive and give the workbook or text file inside"),
            )
    elif "EncryptedPackage".encode("utf-16-le") in data:
        raise protected
    with of_library():
        try:
            workbook = CalamineWorkbook.from_filelike(io.BytesIO(data))
        except PasswordError:
            raise protected from None
    if len(workbook.sheets_metadata) > MOST_SHEETS:
        problem = Sentence("this workbook has {count} sheets", count=len(workbook.sheets_metadata))
        raise Refused(problem, expected=Sentence("at most {count}", count=MOST_SHEETS))
    for meta in workbook.sheets_metadata:
        if meta.typ == SheetTypeEnum.WorkSheet:
            with of_library():
                sheet = workbook.get_sheet_by_name(meta.name)
            yield meta.name, meta.visible != SheetVisibleEnum.Visible, sheet


def _refuse_vast(rows: int, columns: int, sheet: str | None, vast: bool) -> None:
    if vast or columns > _COLUMNS:
        problem = Sentence(
            "the cells of this sheet reach row {row} and column number {column}", row=rows, column=columns
        )
        raise Refused(problem, sheet=sheet, expected=Sentence("a table: delete the stray cells far outside it"))


def _within(ranges: list[CellRange], cells: list[list[NativeCell]], sheet: str) -> list[CellRange]:
    """Cut merged ranges to the cells that exist; refuse ranges that cover more than those, since they overlap."""
    rows, columns = len(cells), max(map(len, cells), default=0)
    kept, covered = [], 0
    for (top, left), (bottom, right) in ranges:
        bottom, right = min(bottom, rows - 1), min(right, columns - 1)
        if bottom >= top and right >= left:
            kept.append(((top, left), (bottom, right)))
            covered += (bottom - top + 1) * (right - left + 1)
    if covered > rows * columns:
        problem = Sentence("merged ranges of this sheet overlap: the workbook is damaged")
        expected = Sentence("a workbook as a spreadsheet program saves it: open it there and save it anew")
        raise Refused(problem, sheet=sheet, expected=expected)
    return kept
