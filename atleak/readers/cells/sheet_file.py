"""A file's bytes → its sheets: a workbook's, or the one of a text, whose code page and separator are found out."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import groupby, pairwise, zip_longest
from pathlib import Path

from atleak.common.errors import Place, ReadingsError, reason_of
from atleak.common.sentences import Sentence
from atleak.measurements.own_forms import OWN_FORMS
from atleak.readers.cells.extent import EXPECTED, MOST_TEXT, bounded, excess
from atleak.readers.cells.sheet import NO_WIDTH, Cell, Sheet
from atleak.readers.cells.workbook_marks import CellRange, Marks
from atleak.readers.process.parent import WORKBOOK, read_apart
from atleak.readers.process.workbooks import first_rows, measuring_sheets

Knows = Callable[[str], bool]  # whether sheets of this kind use a word
_WANTED = Sentence("a measuring sheet as .xlsx workbook or .csv text")

_ALIGNED, _WORDS = "aligned", "words"
_DELIMITERS = {
    ";": Sentence("semicolon"),
    "\t": Sentence("tab"),
    ",": Sentence("comma"),
    "|": Sentence("bar"),
    _ALIGNED: Sentence("columns of spaces"),
    _WORDS: Sentence("single spaces"),
}
_LOOKED_AT = 400  # lines that are read to choose encoding and delimiter
_LOOKED_AT_NEXT = 4000  # the same, where nothing is found in those
_COMPLETE = 4.0  # score of headings that say what a diameter is of
_MARKS = {b"\xef\xbb\xbf": "utf-8-sig", b"\xff\xfe": "utf-16", b"\xfe\xff": "utf-16"}
_USUAL = ("cp1252", "cp1250")
_CODE_PAGES = ("cp1252", "cp1250", "cp1251", "cp1254", "cp850", "cp852", "cp866")
_FEWEST_KNOWN = 0.1  # of the words of a text, of which all others are not read in its code page
_OTHERS = ("gb18030", "shift_jis", "euc_kr", "cp1253")  # for texts of which no word is known
_RULE = re.compile(r"\s*:?[-=]{2,}:?\s*")  # between the headings and the rows of a table in Markdown
_MARK = rf'"?(?:{"|".join(OWN_FORMS)})"?'
_BESIDE_MARK = re.compile(rf"([;|,\t]){_MARK}|{_MARK}([;|,\t])")  # what parts the cells of a form of atleak's own
_WORD = re.compile(r"[^\W\d_]+")
_SIGNS = tuple(map(re.compile, (r"(?<!\w)µm", r"\d°", r"(?<!\w)[Øø](?!\w)", "±")))
_UNREADABLE = re.compile(r"[\ufffd\x80-\x9f\u2500-\u259f]|(?<=\d)[øш](?!\w)")  # "0°" of another code page ends in ø


def read_text(data: bytes, file: str, score: Callable[[Sheet], float], knows: Knows | None = None) -> Sheet:
    """Read a text file; encoding and delimiter are those with the highest `score`.

    ``knows`` says whether sheets of this kind use a word, which tells code pages with one byte per letter apart:
    without it only the two most usual ones are tried. A `ReadingsError` refuses what is no text, or no table.
    """
    if len(data) > MOST_TEXT:
        problem = Sentence("this text has {size} MB", size=len(data) >> 20)
        raise ReadingsError(problem, place=Place(file), expected=EXPECTED)
    ways: list[tuple[float, str, str, str]] = []
    for encoding, text in _decoded(data, file, knows):
        lines = text.splitlines(keepends=True)
        likeliest = _best_delimiter("".join(lines[:_LOOKED_AT]), file, score)
        if likeliest[0] <= 0.0 and len(lines) > _LOOKED_AT:
            likeliest = _best_delimiter("".join(lines[:_LOOKED_AT_NEXT]), file, score)
        ways.append((*likeliest, encoding, text))
    _, delimiter, encoding, text = max(ways, key=lambda way: way[0])
    note = Sentence("read as {encoding}, columns separated by {delimiter}")
    sheet = _sheet(text, file, delimiter, note.of(encoding=encoding, delimiter=_DELIMITERS[delimiter]))
    if (too_much := excess(sheet.rows)) is not None:
        raise ReadingsError(too_much, place=Place(file), expected=EXPECTED)
    return sheet


def _best_delimiter(start: str, file: str, score: Callable[[Sheet], float]) -> tuple[float, str]:
    def likeness(delimiter: str) -> float:
        sheet = _sheet(start, file, delimiter)
        return score(sheet) if excess(sheet.rows) is None else -1.0

    candidates = [(likeness(delimiter), delimiter) for delimiter in _delimiters(start)]
    best = max(candidates, key=lambda scored: scored[0])
    lines = [line for line in start.splitlines() if re.search(r"\d[.,]\d", line)]
    cut = any(lines and all(line.count(sign) > (sign != "\t") for line in lines) for sign in ";\t|")
    if best[0] < _COMPLETE and " " in start and not cut:
        by_spaces = [(likeness(spaces), spaces) for spaces in (_ALIGNED, _WORDS)]
        best = max([best, *(scored for scored in by_spaces if scored[0] >= _COMPLETE)], key=lambda scored: scored[0])
    if best[0] < _COMPLETE and _is_of_words(start, best[1]):
        return best[0], _WORDS
    return best


def _is_of_words(text: str, delimiter: str) -> bool:
    """Return whether all lines with decimals have as many words, and none of them is cut by the delimiter."""
    lines = [line for line in text.splitlines() if re.search(r"\d[.,]\d", line)]
    cut = re.compile(rf"(?<!\d){re.escape(delimiter)}|{re.escape(delimiter)}(?!\d)")
    words = {len(line.split()) for line in lines}
    return len(lines) > 1 and len(words) == 1 and max(words) > 2 and not any(map(cut.search, lines))


def csv_bytes(rows: Iterable[Sequence[str]]) -> bytes:
    """Return rows as text with semicolons, as the program itself writes what is typed."""
    target = io.StringIO(newline="")
    csv.writer(target, delimiter=";", lineterminator="\r\n").writerows(rows)
    return target.getvalue().encode()


def csv_rows(content: bytes) -> list[list[str]]:
    """Return the rows that `csv_bytes` wrote; none of any other file that is no such text."""
    try:
        return list(csv.reader(io.StringIO(content.decode(), newline=""), delimiter=";"))
    except (UnicodeDecodeError, csv.Error):
        return []


def stated_encoding(data: bytes) -> str | None:
    """Return the encoding that the first bytes of a text tell: its mark, or that every second one is zero."""
    marked = next((encoding for mark, encoding in _MARKS.items() if data.startswith(mark)), None)
    low, high = data[:4096:2], data[1:4096:2]
    wide = (("utf-16-le", high, low), ("utf-16-be", low, high))
    told = (name for name, half, other in wide if half.count(0) > 0.8 * len(half) and other.count(0) < 0.2 * len(other))
    return marked or next(told, None)


def _decoded(data: bytes, file: str, knows: Knows | None) -> Iterator[tuple[str, str]]:
    stated = stated_encoding(data)
    if stated is None and b"\0" in data[:4000]:
        raise _not_text(file)
    try:
        yield stated or "utf-8", data.decode(stated or "utf-8")
    except UnicodeDecodeError as error:
        if stated is not None:
            raise _not_text(file) from error
        # with one byte per letter, the words show which encoding is meant
        for encoding in _USUAL if knows is None else _by_words(data, knows):
            yield encoding, data.decode(encoding, "replace")


def _by_words(data: bytes, knows: Knows) -> Sequence[str]:
    """Return the code pages in which most of the words with other letters than English ones are known."""
    lines = (line for line in data.splitlines()[:_LOOKED_AT_NEXT] if not line.isascii())
    start = b"\n".join(lines)[: 1 << 16]
    scores = {encoding: _known(start.decode(encoding, "replace"), knows) for encoding in _CODE_PAGES}
    best = max(scores.values())
    words = {word for word in _WORD.findall(start.decode(_USUAL[0], "replace")) if not word.isascii()}
    if best < _FEWEST_KNOWN * len(words):
        from charset_normalizer import from_bytes  # of such texts alone

        likely = from_bytes(start, cp_isolation=[*_CODE_PAGES, *_OTHERS]).best()
        if likely is not None and likely.encoding in _OTHERS:
            return [likely.encoding]
    return [encoding for encoding, score in scores.items() if score == best][: len(_USUAL)]


def _known(text: str, knows: Knows) -> int:
    words = {word for word in _WORD.findall(text) if len(word) > 2 and not word.isascii()}
    signs = sum(sign.search(text) is not None for sign in _SIGNS)
    return sum(map(knows, words)) + signs - len(set(_UNREADABLE.findall(text)))


def _not_text(file: str) -> ReadingsError:
    return ReadingsError(Sentence("this is neither a workbook nor text"), place=Place(file), expected=_WANTED)


def _delimiters(text: str) -> tuple[str, ...]:
    first = text.split("\n", 1)[0].strip().strip('"').lower()
    if first.startswith("sep=") and len(first) == 5 and first[4] in _DELIMITERS:
        return (first[4],)
    if (beside := _BESIDE_MARK.search(text)) is not None:
        return (beside[1] or beside[2],)
    return tuple(delimiter for delimiter in _DELIMITERS if len(delimiter) == 1 and delimiter in text) or (",",)


def _sheet(text: str, file: str, delimiter: str, note: Sentence | None = None) -> Sheet:
    text = text.translate(NO_WIDTH)
    if delimiter in (_ALIGNED, _WORDS):
        rows = [line.split() for line in text.splitlines()] if delimiter == _WORDS else _aligned(text.splitlines())
        return Sheet(file=file, name=None, rows=bounded(rows), lines=range(1, len(rows) + 1), note=note)
    table: list[list[str]] = []
    lines: list[int] = []
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=delimiter)
    before = 0
    try:
        for record in reader:
            first = before == 0 and len(record) <= 2 and record and record[0].lower().startswith("sep=")
            filled = [cell for cell in record if cell.strip()]
            if not first and not (delimiter == "|" and filled and all(map(_RULE.fullmatch, filled))):
                table.append([value.strip() for value in record])
                lines.append(before + 1)
            before = reader.line_num
    except csv.Error as error:
        problem = Sentence("this text is no table ({reason})", reason=str(error))
        raise ReadingsError(problem, place=Place(file, row=before + 1), expected=_WANTED) from None
    table = bounded(table)
    return Sheet(file=file, name=None, rows=table, lines=lines[: len(table)], note=note)


def _aligned(lines: Sequence[str]) -> list[list[str]]:
    """Cut lines into cells where all lines of a block have spaces, two at least side by side; a title stays whole."""
    rows: list[list[str]] = []
    for blank, group in groupby((line.expandtabs() for line in lines), key=lambda line: not line.strip()):
        block = list(group)
        cut = [line for line in block if re.search(r"\S {2,}\S", line)]
        columns = zip_longest(*cut or block, fillvalue=" ")
        taken = "".join("x" if any(map(str.strip, signs)) else " " for signs in columns)
        edges = dict.fromkeys((0, *(gap.end() for gap in re.finditer(" {2,}", taken)), len(taken)))
        for line in block:
            whole = blank or (bool(cut) and line not in cut)
            rows.append([line.strip()] if whole else [line[begin:end].strip() for begin, end in pairwise(edges)])
    return rows


_FOREIGN: Mapping[bytes, Sentence] = {  # first bytes → what is neither a table nor text
    b"\x89PNG": Sentence("a PNG picture"),
    b"\xff\xd8\xff": Sentence("a JPEG picture"),
    b"GIF8": Sentence("a GIF picture"),
    b"%PDF": Sentence("a PDF document"),
    b"{\\rtf": Sentence("an RTF document"),
    b"7z\xbc\xaf": Sentence("a 7-Zip archive"),
    b"Rar!": Sentence("a RAR archive"),
    b"PARE": Sentence("an encrypted Parquet file"),
    b"\x89HDF": Sentence("an HDF5 file"),
    b"MATLAB 5.0": Sentence("a MATLAB file"),
}
_NO_SHEET = {
    b"\x1f\x8b": Sentence("a gzip archive"),
    b"MDF     ": Sentence("an MDF measurement file, so perhaps the road-test log"),
    b"PAR1": Sentence("a Parquet file, so perhaps the road-test log"),
}


def foreign_kind(data: bytes, others: Mapping[bytes, Sentence]) -> Sentence | None:
    """Return what a file's first bytes show it to be that is neither a table nor text, or is of some other kinds."""
    return next((kind for magic, kind in {**_FOREIGN, **others}.items() if data.startswith(magic)), None)


def read_bytes(source: str | Path | bytes, name: str | None) -> tuple[bytes, str]:
    """Return the file's bytes and the name that messages give it; a `ReadingsError` where it cannot be read."""
    if isinstance(source, bytes | bytearray | memoryview):
        return bytes(source), name or "readings"
    path = Path(source)
    try:
        return path.read_bytes(), name or path.name
    except OSError as error:
        problem = Sentence("cannot be read ({reason})", reason=reason_of(error))
        problem = Sentence("no such file") if isinstance(error, FileNotFoundError) else problem
        raise ReadingsError(problem, place=Place(str(path)), expected=_WANTED) from None


def read_sheets(
    data: bytes, file: str, score: Callable[[Sheet], float], knows: Knows | None = None, *, only_look: bool = False
) -> list[Sheet]:
    """Read all sheets of a file; a `ReadingsError` refuses what is neither workbook nor text, or too much of it."""
    place = Place(file)
    if not data.strip(b"\0 \t\r\n\xef\xbb\xbf"):
        raise ReadingsError(Sentence("the file is empty"), place=place, expected=_WANTED)
    if data.startswith((b"PK", b"\xd0\xcf\x11\xe0")):
        return [replace(sheet, rows=bounded(sheet.rows)) for sheet in read_workbook(data, file, only_look=only_look)]
    if (kind := foreign_kind(data, _NO_SHEET)) is not None:
        problem = Sentence("this is {kind}, whatever its name says", kind=kind)
        raise ReadingsError(problem, place=place, expected=_WANTED)
    head = data[:2000].lstrip(b"\xef\xbb\xbf \t\r\n").lower()
    if head.startswith((b"<html", b"<!doctype html", b"<table", b"<?xml", b"<meta", b"<head")):
        problem = Sentence("this is a web page or XML file, whatever its name says")
        expected = Sentence("the same table opened in a spreadsheet program and saved as .xlsx")
        raise ReadingsError(problem, place=place, expected=expected)
    return [read_text(data, file, score, knows)]


def read_workbook(data: bytes, file: str, *, only_look: bool = False) -> list[Sheet]:
    """Read all worksheets of a workbook; with ``only_look`` no more than their first rows, where it holds a log too.

    A `ReadingsError` refuses one that is damaged, protected by a password, holds more cells than a measuring sheet can,
    or takes more time or memory than a workbook of its size may.
    """
    read = first_rows if only_look else measuring_sheets
    return [
        Sheet(
            file=file,
            name=worksheet["name"],
            rows=[_seen(row) for row in worksheet["rows"]],
            merged=_merged(worksheet["merged"]),
            faults=worksheet["marks"]["faults"],
            hidden=worksheet["hidden"],
            marks=Marks(**worksheet["marks"]),
        )
        for worksheet in read_apart(read, data, file, ReadingsError, WORKBOOK)
    ]


def _seen(row: Sequence[Cell]) -> Sequence[Cell]:
    """Return a row without the signs in its texts that nobody sees."""
    if all(not isinstance(cell, str) or cell.isascii() for cell in row):
        return row
    return [cell.translate(NO_WIDTH).strip() if isinstance(cell, str) else cell for cell in row]


def _merged(ranges: Iterable[CellRange]) -> dict[tuple[int, int], tuple[int, int]]:
    return {
        (row, column): (top, left)
        for (top, left), (bottom, right) in ranges
        for row in range(top, bottom + 1)
        for column in range(left, right + 1)
        if (row, column) != (top, left)
    }
