"""A file's bytes into sheets, by what kind of file it is."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from pathlib import Path

from atleak.errors import InputError, Place, ReadingsError
from atleak.intake.native.process import WORKBOOK, read_apart
from atleak.intake.native.workbooks import Range, first_rows, measuring_sheets, stray_cells
from atleak.intake.sheets.extent import bounded
from atleak.intake.sheets.sheet import NO_WIDTH, Cell, Sheet
from atleak.intake.sheets.text import WANTED, Knows, read_text
from atleak.intake.workbook_marks import Marks
from atleak.sentence import Sentence
from atleak.system.reasons import reason_of

_FOREIGN = (  # first bytes → what it is
    (b"\x89PNG", Sentence("a PNG picture")),
    (b"\xff\xd8\xff", Sentence("a JPEG picture")),
    (b"GIF8", Sentence("a GIF picture")),
    (b"BM", Sentence("a bitmap picture")),
    (b"II*\0", Sentence("a TIFF picture")),
    (b"MM\0*", Sentence("a TIFF picture")),
    (b"%PDF", Sentence("a PDF document")),
    (b"{\\rtf", Sentence("an RTF document")),
    (b"\x1f\x8b", Sentence("a gzip archive")),
    (b"7z\xbc\xaf", Sentence("a 7-Zip archive")),
    (b"Rar!", Sentence("a RAR archive")),
    (b"MDF     ", Sentence("an MDF measurement file, so perhaps the road-test log")),
    (b"PAR1", Sentence("a Parquet file, so perhaps the road-test log")),
)


def read_bytes(source: str | Path | bytes, name: str | None) -> tuple[bytes, str]:
    """Return the file's bytes and the name that messages give it.

    Raises
    ------
    ReadingsError
        where a path leads to no readable file.
    """
    if isinstance(source, bytes | bytearray | memoryview):
        return bytes(source), name or "readings"
    path = Path(source)
    try:
        return path.read_bytes(), name or path.name
    except OSError as error:
        problem = Sentence("cannot be read ({reason})", reason=reason_of(error))
        if isinstance(error, FileNotFoundError):
            problem = Sentence("no such file")
        raise ReadingsError(problem, place=Place(str(path)), expected=WANTED) from None


def open_sheets(
    source: str | Path | bytes,
    name: str | None,
    score: Callable[[Sheet], float],
    kind: type[InputError],
    wanted: Sentence,
) -> tuple[bytes, str, list[Sheet]]:
    """Return the bytes of a file that is no measuring sheet, the name that messages give it, and its sheets.

    Raises
    ------
    InputError
        of that kind, as `read_bytes` and `read_sheets` say; ``wanted`` is what was expected instead.
    """
    try:
        data, file = read_bytes(source, name)
        return data, file, read_sheets(data, file, score)
    except ReadingsError as error:
        raise kind(error.problem, place=error.place, value=error.value, expected=wanted) from error


def read_sheets(
    data: bytes, file: str, score: Callable[[Sheet], float], knows: Knows | None = None, *, only_look: bool = False
) -> list[Sheet]:
    """Read all sheets of a file; encoding and delimiter are those with the highest `score`, and with words one knows.

    Parameters
    ----------
    only_look
        read no more of a workbook than its sheets' first rows.

    Raises
    ------
    ReadingsError
        where the file is empty, neither a workbook nor text, or more than people fill in.
    """
    place = Place(file)
    if not data.strip(b"\0 \t\r\n\xef\xbb\xbf"):
        raise ReadingsError(Sentence("the file is empty"), place=place, expected=WANTED)
    if data.startswith((b"PK", b"\xd0\xcf\x11\xe0")):
        return [replace(sheet, rows=bounded(sheet.rows)) for sheet in read_workbook(data, file, only_look=only_look)]
    for magic, kind in _FOREIGN:
        if data.startswith(magic) and (magic != b"BM" or b"\0" in data[:64]):
            problem = Sentence("this is {kind}, whatever its name says", kind=kind)
            raise ReadingsError(problem, place=place, expected=WANTED)
    head = data[:2000].lstrip(b"\xef\xbb\xbf \t\r\n").lower()
    if head.startswith((b"<html", b"<!doctype html", b"<table", b"<?xml", b"<meta", b"<head")):
        raise ReadingsError(
            Sentence("this is a web page or XML file, whatever its name says"),
            place=place,
            expected=Sentence("the same table opened in a spreadsheet program and saved as .xlsx"),
        )
    return [read_text(data, file, score, knows)]


def read_workbook(data: bytes, file: str, *, only_look: bool = False) -> list[Sheet]:
    """Read all worksheets of a workbook.

    Parameters
    ----------
    only_look
        read no more than their first rows, of a workbook that holds a log too.

    Raises
    ------
    ReadingsError
        where the file is damaged, protected by a password, holds more cells than a measuring sheet can, or takes more
        time or memory than a workbook of its size may.
    """
    read = first_rows if only_look else measuring_sheets
    return [
        Sheet(
            file=file,
            name=worksheet["name"],
            rows=[_seen(row) for row in worksheet["rows"]],
            merged=_merged(worksheet["merged"]),
            faults=worksheet["faults"],
            hidden=worksheet["hidden"],
            marks=Marks(**worksheet["marks"]),
        )
        for worksheet in read_apart(read, data, file, ReadingsError, WORKBOOK, stray_cells)
    ]


def _seen(row: Sequence[Cell]) -> Sequence[Cell]:
    """Return a row without the signs in its texts that nobody sees."""
    if all(not isinstance(cell, str) or cell.isascii() for cell in row):
        return row
    return [cell.translate(NO_WIDTH).strip() if isinstance(cell, str) else cell for cell in row]


def _merged(ranges: Iterable[Range]) -> dict[tuple[int, int], tuple[int, int]]:
    return {
        (row, column): (top, left)
        for (top, left), (bottom, right) in ranges
        for row in range(top, bottom + 1)
        for column in range(left, right + 1)
        if (row, column) != (top, left)
    }
