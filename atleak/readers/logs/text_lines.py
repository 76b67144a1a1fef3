"""Decodes the bytes of a log and makes every line of it a row.

Encodings may have a byte-order mark or not, and embedded NULs; line ends are of all kinds, quotation marks
may stay open, lines may have too many cells.
"""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from atleak.readers.cells.sheet_file import stated_encoding

_CYRILLIC_RUN = re.compile(rb"[\xc0-\xff]{3,}")
_POLISH = re.compile(rb"(?<=[A-Za-z])[\xb3\xb9\xbf\x9c\x9f\xea\xe6](?=[A-Za-z])")
_WESTERN = re.compile(rb"(?<=[A-Za-z])[\xe4\xf6\xfc\xdf\xe9\xe8\xe0\xe7](?=[A-Za-z])")


@dataclass(frozen=True)
class LogText:
    """A log's text as UTF-8 (or plain single-byte) bytes and what it was encoded in.

    ``encoding`` is for people and JSON; ``decode`` turns pieces of ``data`` into ``str``.
    """

    data: bytes
    encoding: str
    codec: str

    def decode(self, piece: bytes) -> str:
        """Decode a piece of the text; what the encoding cannot hold becomes a replacement sign."""
        return piece.decode(self.codec, errors="replace")


def to_text(data: bytes) -> LogText:
    """Determine the encoding. Single-byte text stays as it is: numbers are plain ASCII in every such encoding."""
    stated = stated_encoding(data)
    if stated == "utf-8-sig":
        return LogText(without_nul(data[3:]), stated, "utf-8")
    if stated is not None:
        return LogText(data.decode(stated, errors="replace").replace("\x00", "").encode(), stated, "utf-8")
    body = without_nul(data)
    codec = _single_byte(body)
    return LogText(body, codec, codec)


def without_nul(data: bytes) -> bytes:
    """Return a text without zero bytes."""
    return data.replace(b"\x00", b"") if b"\x00" in data else data


def _single_byte(data: bytes) -> str:
    if data.isascii():
        return "utf-8"
    head = data[: 1 << 20]
    try:
        head.decode("utf-8")
    except UnicodeDecodeError as error:
        cut_at_the_end = len(data) > len(head) and error.start >= len(head) - 4
        valid_before = any(byte >= 0x80 for byte in head[: error.start])
        if cut_at_the_end and valid_before:
            return "utf-8"
        if _CYRILLIC_RUN.search(head):
            return "cp1251"
        return "cp1250" if len(_POLISH.findall(head)) > len(_WESTERN.findall(head)) else "cp1252"
    return "utf-8"


QUOTE = b'"'
_LINE_FEED = 10
_REMARK = b"#"  # what is left of a line of quotation marks


def one_line_end(data: bytes) -> bytes:
    r"""Return a text whose lines all end with a line feed, perhaps behind a carriage return.

    >>> one_line_end(b"a\rb\r\nc\n")
    b'a\nb\nc\n'
    """
    if b"\r" not in data or data.count(b"\r") == data.count(b"\r\n"):
        return data
    return data.replace(b"\r\n", b"\n").replace(b"\r", b"\n")


def even_rows(data: bytes, delimiter: str, per_line: tuple[int, int] | None, quoted: bool, rows: int) -> bool:
    """Return whether a text is that many rows, each with the same number of delimiters and quotation marks.

    Lines and quotation marks are counted only where these marks may reach over a line's end, ``quoted``.
    """
    if per_line is None:
        return False
    signs = np.frombuffer(data, np.uint8)

    def count(sign: int) -> int:
        return int(np.count_nonzero(signs == sign))

    if count(ord(delimiter)) != rows * per_line[0]:
        return False
    lines = count(_LINE_FEED) + (not data.endswith(b"\n")) if quoted else rows
    return lines == rows and (not quoted or count(QUOTE[0]) == rows * per_line[1])


def signs_per_line(lines: Sequence[bytes], delimiter: str) -> tuple[int, int] | None:
    """Return how many delimiters and quotation marks each line has; None where lines differ or blanks part cells."""
    counts = {(line.count(delimiter.encode()), line.count(QUOTE)) for line in lines if line.strip()}
    return counts.pop() if len(counts) == 1 and delimiter != " " else None


@dataclass(frozen=True)
class Mended:
    """Rows in which no quotation mark reaches over a line's end.

    ``count`` are the rows, ``too_wide`` those that were left out because they have more numbers than there are columns,
    ``short`` those that begin with a number and have fewer cells than there are columns; ``changed``: whether anything
    differs from the lines as they stood.
    """

    data: bytes
    count: int
    too_wide: int
    changed: bool
    short: int = 0


def mended(data: bytes, delimiter: str, width: int, pad: bool = False) -> Mended:
    """Return rows that a fast reader reads line by line.

    A quotation mark that none closes on its own line is removed. A row with more numbers than the table has columns is
    left out: which of them belongs to which column is not known. ``pad``: rows with fewer cells get blank ones.
    """
    sign, count, too_wide, short, changed = delimiter.encode(), 0, 0, 0, False
    rows, blank = io.BytesIO(), b" \r\f\v" if delimiter == "\t" else b" \t\r\f\v"
    for whole in io.BytesIO(data):  # one line at a time: all of them at once take many times the file's size
        line = whole.removesuffix(b"\n")
        if not line.strip(blank):
            continue
        beyond: Sequence[bytes] = ()
        if QUOTE in line:
            cells = _quoted(line, delimiter)
            if cells is None:
                line, changed = line.replace(QUOTE, b""), True
                line = line if line.strip() else _REMARK
                cells = line.split(sign)
            beyond = cells[width:]
        elif delimiter == " ":
            beyond = line.split()[width:]
        elif line.count(sign) >= width:
            beyond = line.split(sign)[width:]
        if any(map(_starts_like_a_number, beyond)):
            too_wide += 1
            continue
        if delimiter != " " and line.count(sign) < width - 1 and _starts_like_a_number(line):
            short += 1
        if pad:
            line = line.rstrip(b"\r") + sign * max(0, width - 1 - line.count(sign))
        rows.write(line + b"\n")
        count += 1
    return Mended(rows.getvalue(), count, too_wide, changed or pad or too_wide > 0, short)


def _quoted(line: bytes, delimiter: str) -> list[bytes] | None:
    """Return the cells of a line with quotation marks; None where they are not in pairs."""
    text = line.decode("latin-1").strip("\r")
    try:
        cells = next(csv.reader([text], delimiter=delimiter, skipinitialspace=True, strict=True), [])
    except csv.Error:
        return None
    return [cell.encode("latin-1") for cell in cells]


def _starts_like_a_number(cell: bytes) -> bool:
    return cell.strip().lstrip(b"+-.,")[:1].isdigit()
