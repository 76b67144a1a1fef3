"""Workbooks (xlsx, xls, ods) into sheets, merged ranges and unusable formulas included."""

from __future__ import annotations

import html
import io
import re
import zipfile
import zlib
from xml.etree import ElementTree

from python_calamine import CalamineError, CalamineWorkbook, PasswordError, SheetTypeEnum, SheetVisibleEnum

from atleak.errors import Place, ReadingsError
from atleak.intake.readings.sheet import Cell, Sheet
from atleak.intake.workbook_cells import column_index, extent
from atleak.intake.workbook_marks import Marks, marks, sheet_paths

_UNPACKED = 300e6  # bytes; a measuring sheet is a thousandth of it
_CELLS = 4_000_000  # a sheet's outermost cells span at most this many
_CELL = re.compile(rb"<(?:\w+:)?c\b([^>]*?)(?:/>|>(.*?)</(?:\w+:)?c>)", re.DOTALL)
_FORMULA = re.compile(rb"<(?:\w+:)?f(?:\s[^>]*)?/?>([^<]*)")
_VALUE = re.compile(rb"<(?:\w+:)?[vt]\b[^>]*>([^<]+)")
_REFERENCE = re.compile(rb'\br="([A-Z]{1,3})(\d{1,7})"')
_DAMAGE = (
    zipfile.BadZipFile,
    zlib.error,
    ElementTree.ParseError,
    EOFError,
    KeyError,
    NotImplementedError,
    RuntimeError,
    ValueError,
)
_ODS = "{urn:oasis:names:tc:opendocument:xmlns:table:1.0}"


def read_workbook(data: bytes, file: str) -> list[Sheet]:
    """All worksheets of a workbook.

    Raises
    ------
    ReadingsError
        where the file is damaged, protected by a password, or spans more cells than a measuring sheet can.
    """
    merges: dict[str, dict[tuple[int, int], tuple[int, int]]] = {}
    faults: dict[str, dict[tuple[int, int], str]] = {}
    marked: dict[str, Marks] = {}
    if data.startswith(b"PK"):
        merges, faults = _look_inside(data, file)
        marked = _marks(data, file)
    elif "EncryptedPackage".encode("utf-16-le") in data:
        raise _protected(file)
    try:
        with CalamineWorkbook.from_filelike(io.BytesIO(data)) as workbook:
            sheets = []
            for meta in workbook.sheets_metadata:
                if meta.typ != SheetTypeEnum.WorkSheet:
                    continue
                sheet = workbook.get_sheet_by_name(meta.name)
                rows: list[list[Cell]] = sheet.to_python(skip_empty_area=False)
                ranges = sheet.merged_cell_ranges
                sheets.append(
                    Sheet(
                        file=file,
                        name=meta.name,
                        rows=rows,
                        merged=merges.get(meta.name, {}) if ranges is None else _merged(ranges),
                        faults=faults.get(meta.name, {}),
                        hidden=meta.visible != SheetVisibleEnum.Visible,
                        marks=marked.get(meta.name, Marks()),
                    )
                )
            return sheets
    except PasswordError:
        raise _protected(file) from None
    except CalamineError as error:
        raise ReadingsError(
            f"this workbook is damaged or of a kind that cannot be read ({error})",
            place=Place(file),
            expected="an .xlsx workbook: open it in a spreadsheet program and save it again as .xlsx",
        ) from None


def _protected(file: str) -> ReadingsError:
    return ReadingsError(
        "this workbook is protected by a password", place=Place(file), expected="the workbook saved without a password"
    )


def _merged(ranges: list[tuple[tuple[int, int], tuple[int, int]]]) -> dict[tuple[int, int], tuple[int, int]]:
    return {
        (row, column): (top, left)
        for (top, left), (bottom, right) in ranges
        for row in range(top, bottom + 1)
        for column in range(left, right + 1)
        if (row, column) != (top, left)
    }


def _look_inside(
    data: bytes, file: str
) -> tuple[dict[str, dict[tuple[int, int], tuple[int, int]]], dict[str, dict[tuple[int, int], str]]]:
    """What calamine does not tell: merged ranges of an ods, formulas without result of an xlsx.

    It also keeps out what calamine would not survive: a single stray cell in the last corner makes it ask for half a
    terabyte and takes the process with it.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            if sum(entry.file_size for entry in archive.infolist()) > _UNPACKED:
                raise ReadingsError(
                    "this workbook unpacks to more than 300 MB", place=Place(file), expected="a measuring sheet"
                )
            names = set(archive.namelist())
            if "content.xml" in names and "xl/workbook.xml" not in names:
                return _ods_merges(archive.read("content.xml")), {}
            if "xl/workbook.xml" not in names:
                if "xl/workbook.bin" in names:
                    return {}, {}
                raise ReadingsError(
                    "this file is an archive, not a workbook",
                    place=Place(file),
                    expected="an .xlsx workbook or a CSV file",
                )
            return {}, {
                sheet: _formula_faults(archive.read(path), file, sheet)
                for sheet, path in sheet_paths(archive).items()
                if path in names
            }
    except _DAMAGE as error:
        raise _damaged(error, file) from None


def _marks(data: bytes, file: str) -> dict[str, Marks]:
    try:
        return marks(data)
    except _DAMAGE as error:
        raise _damaged(error, file) from None


def _damaged(error: Exception, file: str) -> ReadingsError:
    return ReadingsError(
        f"this workbook is damaged ({error})",
        place=Place(file),
        expected="an .xlsx workbook that opens in a spreadsheet program",
    )


def _formula_faults(xml: bytes, file: str, sheet: str) -> dict[tuple[int, int], str]:
    found: dict[tuple[int, int], str] = {}
    if not _FORMULA.search(xml) and b't="e"' not in xml and _span(xml) <= _CELLS:
        return found  # the usual case, in a tenth of the time
    rows, columns = [0], [0]
    for attributes, content in _CELL.findall(xml):
        reference = _REFERENCE.search(attributes)
        if reference is None:
            continue
        row, column = int(reference[2]) - 1, column_index(reference[1].decode())
        value, formula = _VALUE.search(content), _FORMULA.search(content)
        if value or formula:
            rows.append(row)
            columns.append(column)
        if b't="e"' in attributes:
            found[row, column] = value[1].decode("utf-8", "replace") if value else "an error"
        elif formula and not value and b't="str"' not in attributes:  # an empty text is a result too
            found[row, column] = "=" + html.unescape(formula[1].decode("utf-8", "replace"))
    if (max(rows) + 1) * (max(columns) + 1) > _CELLS:
        raise ReadingsError(
            f"the cells of this sheet reach row {max(rows) + 1} and column number {max(columns) + 1}",
            place=Place(file, sheet),
            expected="a measuring sheet: delete the stray cells far outside the table",
        )
    return found


def _span(xml: bytes) -> int:
    rows, columns, _ = extent([xml])
    return rows * columns


def _ods_merges(xml: bytes) -> dict[str, dict[tuple[int, int], tuple[int, int]]]:
    merges: dict[str, dict[tuple[int, int], tuple[int, int]]] = {}
    for table in ElementTree.fromstring(xml).iter(f"{_ODS}table"):
        ranges = []
        row = 0
        for line in table.iter(f"{_ODS}table-row"):
            column = 0
            for cell in line:
                down = int(cell.get(f"{_ODS}number-rows-spanned", "1"))
                across = int(cell.get(f"{_ODS}number-columns-spanned", "1"))
                if down * across > 1 and down * across < _CELLS:
                    ranges.append(((row, column), (row + down - 1, column + across - 1)))
                column += int(cell.get(f"{_ODS}number-columns-repeated", "1"))
            row += int(line.get(f"{_ODS}number-rows-repeated", "1"))
        merges[table.get(f"{_ODS}name", "")] = _merged(ranges)
    return merges
