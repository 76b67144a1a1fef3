"""Reads workbooks (xlsx, xlsb, xls, ods) in the child process."""

from __future__ import annotations

import html
import io
import itertools
import re
import zipfile
from array import array
from collections.abc import Iterable, Iterator
from typing import IO, Any, TypedDict
from xml.etree import ElementTree
from xml.parsers import expat

from atleak.intake.native.child import Refused, of_library
from atleak.intake.native.sheet_slices import Slices
from atleak.intake.sheets.extent import COLUMNS as WIDTH
from atleak.intake.sheets.extent import EXPECTED, SHEETS, excess, trimmed
from atleak.intake.workbook_marks import Marks, column_index, marks, sheet_paths, unpacked_part, whole_number
from atleak.sentence import Sentence

NativeCell = Any  # str, float, int, bool, date or time; "" where empty
Range = tuple[tuple[int, int], tuple[int, int]]  # first and last (row, column), both from 0

CELLS = 1_000_000
"""Cells that a measuring sheet may span at most; a filled one spans thousands."""
LOG_CELLS, LOG_CELLS_PER_BYTE = 4_000_000, 16
"""Cells that a log may span, and more for each byte of its file: a cell takes three, if one in fifty is filled."""
COLUMNS = 16_384
"""Columns of a sheet in a spreadsheet program."""
LOOK = 300
"""Rows of a sheet in which it shows what it holds."""
HEAD, BLOCK = 2_000, 20_000
"""Rows of a log in its first item, among which its table is sought, and in every other."""
_NAN = float("nan")

_CELL = re.compile(rb"<(?:\w+:)?c\b([^>]*?)(?:/>|>(.*?)</(?:\w+:)?c>)", re.DOTALL)
_FORMULA = re.compile(rb"<(?:\w+:)?f(?:\s[^>]*)?/?>([^<]*)")
_VALUE = re.compile(rb"<(?:\w+:)?[vt]\b[^>]*>([^<]+)")
_REFERENCE = re.compile(rb'\br="([A-Z]{1,3})(\d{1,9})"')
_ODS = "{urn:oasis:names:tc:opendocument:xmlns:table:1.0}"


class MeasuringSheet(TypedDict):
    """A worksheet with what its cells alone do not show; ``rows`` and all places count from cell A1."""

    name: str
    hidden: bool
    rows: list[list[NativeCell]]
    merged: list[Range]
    faults: dict[tuple[int, int], str]
    marks: dict[str, Any]  # the fields of `atleak.intake.workbook_marks.Marks`


def measuring_sheets(data: bytes) -> Iterator[MeasuringSheet]:
    """Yield every worksheet, with merged ranges, formulas without a usable result, and what is hidden or crossed out.

    Raises
    ------
    Refused
        where the file is protected by a password, no workbook, or holds more cells than a measuring sheet can.
    """
    _refuse_other_kinds(data)
    merges, faults = _merges_and_faults(data) if data.startswith(b"PK") else ({}, {})
    marked = marks(data)
    for name, hidden, sheet in _worksheets(data):
        rows, columns = (0, 0) if sheet.end is None else (sheet.end[0] + 1, sheet.end[1] + 1)
        _refuse_vast(rows, columns, name, columns * rows > CELLS)
        ranges = sheet.merged_cell_ranges
        with of_library():
            rows_of_cells = sheet.to_python(skip_empty_area=False)
        cells = trimmed(rows_of_cells)
        if (too_much := excess(cells)) is not None:
            raise Refused(too_much, sheet=name, expected=EXPECTED)
        yield {
            "name": name,
            "hidden": hidden,
            "rows": cells,
            "merged": _within(merges.get(name, []) if ranges is None else ranges, cells, name),
            "faults": faults.get(name, {}),
            "marks": vars(marked.get(name, Marks())),
        }


def first_rows(data: bytes) -> Iterator[MeasuringSheet]:
    """Yield the first rows of every worksheet, of a log too, to see what it holds; merged ranges with them.

    Raises
    ------
    Refused
        as `log_blocks`.
    """
    _refuse_other_kinds(data)
    for name, hidden, sheets in _worksheets_of_a_log(data):
        sheet = next(sheets)
        rows: Iterable[list[NativeCell]] = ()
        if sheet.start is not None:
            _Extent(data, name).add(sheet.start, sheet.end)
            rows = _from_column_a(sheet)
        cells = trimmed([row[:WIDTH] for row in itertools.islice(rows, LOOK)])
        ranges = [] if sheet.merged_cell_ranges is None else sheet.merged_cell_ranges
        merged = _within(ranges, cells, name)
        yield {"name": name, "hidden": hidden, "rows": cells, "merged": merged, "faults": {}, "marks": vars(Marks())}


LogRows = list[list[NativeCell | None]]
LogColumns = list[bytes | list[NativeCell | None]]


def log_blocks(data: bytes) -> Iterator[tuple[str, int, int, LogRows, LogColumns]]:
    """Yield every worksheet in blocks: its name, its first column so far, how many rows, and their rows or columns.

    The first block of a sheet comes in rows, all others in columns: packed floats where every cell is a number or
    empty (NaN), which takes a quarter of the memory, else a list. Empty cells are None, those before the first column
    and above the first row are left out.

    Raises
    ------
    Refused
        where the file is protected by a password, no workbook, or spans more cells than a log of its size can.
    """
    _refuse_other_kinds(data)
    for name, _, sheets in _worksheets_of_a_log(data):
        extent = _Extent(data, name)
        rows = _rows(sheets, extent)
        if first := list(itertools.islice(rows, HEAD)):
            left, width = extent.left, max(map(len, first))
            head = [[None if cell == "" else cell for cell in row[left:]] for row in first]
            yield name, left, len(head), [row + [None] * (width - left - len(row)) for row in head], []
        while block := list(itertools.islice(rows, BLOCK)):
            columns = itertools.islice(itertools.zip_longest(*block, fillvalue=""), extent.left, None)
            yield name, extent.left, len(block), [], [_packed(column) for column in columns]


class _Extent:
    """How far the cells of a sheet reach, as far as they were read."""

    def __init__(self, data: bytes, name: str) -> None:
        self._data, self._name = data, name
        self._area: tuple[int, int, int, int] | None = None

    def add(self, start: tuple[int, int], end: tuple[int, int]) -> None:
        """Count in another part of the sheet.

        Raises
        ------
        Refused
            where all parts together span more cells than a log can.
        """
        top, left, bottom, right = self._area or (*start, *end)
        self._area = min(top, start[0]), min(left, start[1]), max(bottom, end[0]), max(right, end[1])
        top, left, bottom, right = self._area
        most = LOG_CELLS + LOG_CELLS_PER_BYTE * len(self._data)
        vast = (bottom - top + 1) * (right - left + 1) > most
        _refuse_vast(bottom + 1, right + 1, self._name, vast)

    @property
    def left(self) -> int:
        """Return the first column in which a cell was filled."""
        return self._area[1] if self._area is not None else 0


def _rows(sheets: Iterable[Any], extent: _Extent) -> Iterator[list[NativeCell]]:
    """Yield the rows of a sheet that comes in parts, from the first one that is filled on, each from column A on."""
    next_row: int | None = None
    for sheet in sheets:
        if sheet.start is None:
            continue
        top, bottom = sheet.start[0], sheet.end[0]
        extent.add(sheet.start, sheet.end)
        if next_row is not None and top < next_row:
            raise Refused(
                Sentence("the rows of this sheet are not in the order of their numbers"),
                sheet=sheet.name,
                expected=Sentence("a workbook as a spreadsheet program saves it: open it there and save it anew"),
            )
        yield from ([] for _ in range(top - (top if next_row is None else next_row)))
        # of a later part the blank rows above it are many
        yield from _filled_area(sheet) if next_row else itertools.islice(_from_column_a(sheet), top, None)
        next_row = bottom + 1


def _from_column_a(sheet: Any) -> Iterator[list[NativeCell]]:
    """Yield all rows of a sheet; calamine's own begin at the first column that is filled."""
    with of_library():
        yield from ([""] * sheet.start[1] + row for row in sheet.iter_rows())


def _filled_area(sheet: Any) -> Iterator[list[NativeCell]]:
    """Yield the rows of a sheet from the first one that is filled on."""
    with of_library():
        filled = sheet.to_python(skip_empty_area=True)
    yield from ([""] * sheet.start[1] + row for row in filled)


def _packed(column: tuple[NativeCell, ...]) -> bytes | list[NativeCell | None]:
    """Return a column as packed floats, or as a list where a cell is neither a number nor empty."""
    try:
        return array("d", [_NAN if cell == "" else cell for cell in column]).tobytes()
    except TypeError:
        return [None if cell == "" else cell for cell in column]


def stray_cells(data: bytes) -> Iterator[None]:
    """Refuse a workbook (xlsx) whose outermost cells span more than memory can hold.

    calamine lays a sheet out from its first cell to its last: one cell in the last corner makes it ask for half a
    terabyte, which ends the process. This looks at the XML instead, which is slower, so it runs only afterwards.

    Raises
    ------
    Refused
        naming the sheet's part of the workbook and how far its cells reach.
    """
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        sheets = {path: name for name, path in sheet_paths(archive).items()}
        for path in archive.namelist():
            if path.startswith("xl/worksheets/") and path.endswith(".xml"):
                with archive.open(path) as stream:
                    rows, columns = _outermost(stream)
                _refuse_vast(rows, columns, sheets.get(path), rows * columns > LOG_CELLS)
    yield None


def _outermost(stream: IO[bytes]) -> tuple[int, int]:
    """Return the number of rows and columns up to the outermost cells of a sheet's XML."""
    rows = columns = 0

    def start(tag: str, attributes: dict[str, str]) -> None:
        nonlocal rows, columns
        if tag.rpartition(":")[2] == "c":
            reference = _REFERENCE.match(f'r="{attributes.get("r", "").upper()}"'.encode())
            if reference:
                row, column = _row_and_column(reference)
                rows, columns = max(rows, row + 1), max(columns, column + 1)

    parser = expat.ParserCreate()
    parser.StartElementHandler = start
    parser.ParseFile(stream)
    return rows, columns


def _refuse_other_kinds(data: bytes) -> None:
    if "EncryptedPackage".encode("utf-16-le") in data and not data.startswith(b"PK"):
        raise _protected()
    if data.startswith(b"PK"):
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            names = archive.namelist()
        if not {"xl/workbook.xml", "xl/workbook.bin", "content.xml"} & set(names):
            raise Refused(
                Sentence("this file is a ZIP archive, not a workbook"),
                value=", ".join(names[:3]),
                expected=Sentence("the file itself: unpack the archive and give the workbook or text file inside"),
            )


def _protected() -> Refused:
    return Refused(
        Sentence("this workbook is protected by a password"),
        expected=Sentence("the workbook saved without a password"),
    )


def _worksheets(data: bytes) -> Iterator[tuple[str, bool, Any]]:
    """Yield every worksheet's name, whether it is hidden, and its cells."""
    workbook = _opened(data)
    for name, hidden in _listed(workbook):
        yield name, hidden, _sheet(workbook, name)


def _worksheets_of_a_log(data: bytes) -> Iterator[tuple[str, bool, Iterator[Any]]]:
    """Yield every worksheet's name, whether it is hidden, and its cells: in several parts where they are many."""
    slices = Slices(data) if data.startswith(b"PK") else None
    if slices is None or not slices.names:
        for name, hidden, sheet in _worksheets(data):
            yield name, hidden, iter([sheet])
        return
    workbook = _opened(slices.rest())
    for name, hidden in _listed(workbook):
        cut = name in slices.names
        yield name, hidden, _parts(slices, name) if cut else iter([_sheet(workbook, name)])


def _parts(slices: Slices, name: str) -> Iterator[Any]:
    for part in slices.of(name):
        yield _sheet(_opened(part), name)


def _opened(data: bytes) -> Any:
    from python_calamine import CalamineWorkbook, PasswordError

    with of_library():
        try:
            workbook = CalamineWorkbook.from_filelike(io.BytesIO(data))
        except PasswordError:
            raise _protected() from None
    if len(workbook.sheets_metadata) > SHEETS:
        raise Refused(
            Sentence("this workbook has {count} sheets", count=len(workbook.sheets_metadata)),
            expected=Sentence("at most {count}", count=SHEETS),
        )
    return workbook


def _sheet(workbook: Any, name: str) -> Any:
    with of_library():
        return workbook.get_sheet_by_name(name)


def _listed(workbook: Any) -> Iterator[tuple[str, bool]]:
    """Yield every worksheet's name, and whether it is hidden."""
    from python_calamine import SheetTypeEnum, SheetVisibleEnum

    for meta in workbook.sheets_metadata:
        if meta.typ == SheetTypeEnum.WorkSheet:
            yield meta.name, meta.visible != SheetVisibleEnum.Visible


def _refuse_vast(rows: int, columns: int, sheet: str | None, vast: bool) -> None:
    if vast or columns > COLUMNS:
        raise Refused(
            Sentence("the cells of this sheet reach row {row} and column number {column}", row=rows, column=columns),
            sheet=sheet,
            expected=Sentence("a table: delete the stray cells far outside it"),
        )


def _within(ranges: list[Range], cells: list[list[NativeCell]], sheet: str) -> list[Range]:
    """Cut merged ranges to the cells that exist; refuse ranges that cover more than those, since they overlap."""
    rows, columns = len(cells), max(map(len, cells), default=0)
    kept, covered = [], 0
    for (top, left), (bottom, right) in ranges:
        bottom, right = min(bottom, rows - 1), min(right, columns - 1)
        if bottom >= top and right >= left:
            kept.append(((top, left), (bottom, right)))
            covered += (bottom - top + 1) * (right - left + 1)
    if covered > rows * columns:
        raise Refused(
            Sentence("merged ranges of this sheet overlap: the workbook is damaged"),
            sheet=sheet,
            expected=Sentence("a workbook as a spreadsheet program saves it: open it there and save it anew"),
        )
    return kept


def _merges_and_faults(data: bytes) -> tuple[dict[str, list[Range]], dict[str, dict[tuple[int, int], str]]]:
    """Return what calamine does not read: merged ranges of an ods, formulas without result of an xlsx."""
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        names = set(archive.namelist())
        if "xl/workbook.xml" in names:
            return {}, {
                sheet: _formula_faults(unpacked_part(archive, path))
                for sheet, path in sheet_paths(archive).items()
                if path in names
            }
        return (_ods_merges(unpacked_part(archive, "content.xml")) if "content.xml" in names else {}), {}


def _formula_faults(xml: bytes) -> dict[tuple[int, int], str]:
    """Return the cells whose formula has an error or no stored result."""
    faults: dict[tuple[int, int], str] = {}
    if not _FORMULA.search(xml) and b't="e"' not in xml:
        return faults  # the usual case, in a tenth of the time
    for attributes, content in _CELL.findall(xml):
        reference = _REFERENCE.search(attributes)
        if reference is None:
            continue
        place = _row_and_column(reference)
        value, formula = _VALUE.search(content), _FORMULA.search(content)
        if b't="e"' in attributes:
            faults[place] = value[1].decode("utf-8", "replace") if value else "an error"
        elif formula and not value and b't="str"' not in attributes:  # an empty text is a result too
            faults[place] = "=" + html.unescape(formula[1].decode("utf-8", "replace"))
    return faults


def _row_and_column(reference: re.Match[bytes]) -> tuple[int, int]:
    """Return row and column, both from 0.

    >>> _row_and_column(_REFERENCE.search(b'<c r="AB7">'))
    (6, 27)
    """
    return int(reference[2]) - 1, column_index(reference[1].decode())


def _ods_merges(xml: bytes) -> dict[str, list[Range]]:
    merges: dict[str, list[Range]] = {}
    for table in ElementTree.fromstring(xml).iter(f"{_ODS}table"):
        ranges = merges.setdefault(table.get(f"{_ODS}name", ""), [])
        row = 0
        for line in table.iter(f"{_ODS}table-row"):
            column = 0
            for cell in line:
                down = whole_number(cell.get(f"{_ODS}number-rows-spanned", "1"))
                across = whole_number(cell.get(f"{_ODS}number-columns-spanned", "1"))
                if down * across > 1:
                    ranges.append(((row, column), (row + down - 1, column + across - 1)))
                column += whole_number(cell.get(f"{_ODS}number-columns-repeated", "1"))
            row += whole_number(line.get(f"{_ODS}number-rows-repeated", "1"))
    return merges
