"""A file's bytes into sheets: what kind of file it is, and how a text file is written."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Iterator
from pathlib import Path

from atleak.errors import Place, ReadingsError
from atleak.intake.sheets.extent import EXPECTED, TEXT, bounded, excess
from atleak.intake.sheets.sheet import Sheet
from atleak.sentence import Sentence
from atleak.system.reasons import reason_of

WANTED = Sentence("a measuring sheet as .xlsx workbook or .csv text")

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
)
_DELIMITERS = {";": Sentence("semicolon"), "\t": Sentence("tab"), ",": Sentence("comma"), "|": Sentence("bar")}
_LOOKED_AT = 400  # lines that are read to choose encoding and delimiter


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


def read_sheets(data: bytes, file: str, score: Callable[[Sheet], float], *, only_look: bool = False) -> list[Sheet]:
    """Read all sheets of a file; encoding and delimiter are those with the highest `score` as readings.

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
        from atleak.intake.sheets.workbook import read_workbook  # calamine only where it is needed

        return read_workbook(data, file, only_look=only_look)
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
    return [_read_text(data, file, score)]


def _read_text(data: bytes, file: str, score: Callable[[Sheet], float]) -> Sheet:
    if len(data) > TEXT:
        problem = Sentence("this text has {size} MB", size=len(data) >> 20)
        raise ReadingsError(problem, place=Place(file), expected=EXPECTED)
    best: tuple[float, str, str, str] | None = None
    too_much: Sentence | None = None
    for encoding, text in _decoded(data, file):
        start = "".join(text.splitlines(keepends=True)[:_LOOKED_AT])
        for delimiter in _delimiters(start):
            sheet = _sheet(start, file, delimiter)
            if (found := excess(sheet.rows)) is not None:
                too_much = too_much or found
                continue
            likeness = score(sheet)
            if best is None or likeness > best[0]:
                best = (likeness, encoding, delimiter, text)
    if best is not None:
        _, encoding, delimiter, text = best
        note = Sentence(
            "read as {encoding}, columns separated by {delimiter}", encoding=encoding, delimiter=_DELIMITERS[delimiter]
        )
        sheet = _sheet(text, file, delimiter, note)
        too_much = excess(sheet.rows)
        if too_much is None:
            return sheet
    assert too_much is not None  # at least one encoding decodes
    raise ReadingsError(too_much, place=Place(file), expected=EXPECTED)


def _decoded(data: bytes, file: str) -> Iterator[tuple[str, str]]:
    for mark, encoding in ((b"\xef\xbb\xbf", "utf-8-sig"), (b"\xff\xfe", "utf-16"), (b"\xfe\xff", "utf-16")):
        if data.startswith(mark):
            try:
                yield encoding, data.decode(encoding)
            except UnicodeDecodeError as error:
                raise _not_text(file) from error
            return
    start = data[:4000]
    if b"\0" in start:
        # UTF-16 without its mark: every second byte of plain text is zero
        for encoding, zeros in (("utf-16-le", start[1::2]), ("utf-16-be", start[0::2])):
            if zeros.count(0) > 0.8 * len(zeros):
                try:
                    yield encoding, data.decode(encoding)
                except UnicodeDecodeError as error:
                    raise _not_text(file) from error
                return
        raise _not_text(file)
    try:
        yield "utf-8", data.decode("utf-8")
    except UnicodeDecodeError:
        # with one byte per letter, the headings show which encoding is meant
        yield "cp1252", data.decode("cp1252", "replace")
        yield "cp1250", data.decode("cp1250", "replace")


def _not_text(file: str) -> ReadingsError:
    return ReadingsError(Sentence("this is neither a workbook nor text"), place=Place(file), expected=WANTED)


def _delimiters(text: str) -> tuple[str, ...]:
    first = text.split("\n", 1)[0].strip().strip('"').lower()
    if first.startswith("sep=") and len(first) == 5 and first[4] in _DELIMITERS:
        return (first[4],)
    return tuple(delimiter for delimiter in _DELIMITERS if delimiter in text) or (",",)


def _sheet(text: str, file: str, delimiter: str, note: Sentence | None = None) -> Sheet:
    rows: list[list[str]] = []
    lines: list[int] = []
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=delimiter)
    before = 0
    try:
        for record in reader:
            if not (before == 0 and len(record) <= 2 and record and record[0].lower().startswith("sep=")):
                rows.append([value.strip() for value in record])
                lines.append(before + 1)
            before = reader.line_num
    except csv.Error as error:
        problem = Sentence("this text is no table ({reason})", reason=str(error))
        raise ReadingsError(problem, place=Place(file, row=before + 1), expected=WANTED) from None
    rows = bounded(rows)
    return Sheet(file=file, name=None, rows=rows, lines=lines[: len(rows)], note=note)
