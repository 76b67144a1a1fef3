"""Cuts a large sheet of an xlsx between rows, so that calamine reads one slice of it after the other.

calamine lays out all cells of a sheet before it gives the first of them. Each slice is a small workbook with the texts,
styles and dates of the large one: its cells come out as they would from the whole, and memory is needed for one slice.
"""

from __future__ import annotations

import io
import re
import zipfile
from collections.abc import Iterator
from functools import cached_property
from typing import IO

from atleak.intake.native.child import Refused
from atleak.intake.workbook_marks import sheet_paths
from atleak.sentence import Sentence

LARGE = 24 << 20
"""Bytes of a sheet's unpacked XML from which on it is cut."""
SLICE = 8 << 20
"""Bytes of XML in a slice."""
_LONGEST_ROW = 64 << 20
_READ = 1 << 20
_SHARED = frozenset(
    {
        "[content_types].xml", "_rels/.rels", "xl/workbook.xml", "xl/_rels/workbook.xml.rels", "xl/styles.xml",
        "xl/sharedstrings.xml",
    }
)  # fmt: skip
"""The parts of a workbook, in small letters, without which a sheet cannot be understood."""

_BEGIN = re.compile(rb"<((?:\w{1,20}:)?)sheetData\b[^<>]*(?<!/)>")
_ROW = re.compile(rb"<(?:\w{1,20}:)?row\b([^<>]*)>")
_NUMBER = re.compile(rb"""(?:^|\s)r\s*=\s*["'](\d{1,9})["']""")


class Slices:
    """The large sheets of an xlsx, those of them whose rows can be told apart in their XML."""

    def __init__(self, data: bytes) -> None:
        self._archive = zipfile.ZipFile(io.BytesIO(data))
        entries = {entry.filename.lower(): entry for entry in self._archive.infolist()}
        self._sheets: dict[str, zipfile.ZipInfo] = {}
        self._cut: dict[str, zipfile.ZipInfo] = {}
        if "xl/workbook.xml" in entries and any(entry.file_size > LARGE for entry in entries.values()):
            for name, path in sheet_paths(self._archive).items():
                if (sheet := entries.get(path.lower())) is not None:
                    large = sheet.file_size > LARGE and self._begin(sheet) is not None
                    (self._cut if large else self._sheets)[name] = sheet
        self._entries = [entry for name, entry in entries.items() if name in _SHARED]

    @property
    def names(self) -> frozenset[str]:
        """Return the names of the sheets that are cut."""
        return frozenset(self._cut)

    @cached_property
    def _shared(self) -> dict[str, bytes]:
        return {entry.filename: self._archive.read(entry) for entry in self._entries}

    def rest(self) -> bytes:
        """Return the workbook with its other sheets only."""
        return self._workbook({entry.filename: self._archive.read(entry) for entry in self._sheets.values()})

    def of(self, name: str) -> Iterator[bytes]:
        """Yield the slices of a sheet, each a workbook in which this sheet holds the next rows.

        Raises
        ------
        Refused
            where a row takes more than 64 MB.
        """
        # the texts that all cells share are read again with every slice
        length = max(SLICE, sum(map(len, self._shared.values())) // 2)
        with self._archive.open(self._cut[name]) as stream:
            for xml in _cut(stream, length):
                yield self._workbook({self._cut[name].filename: xml})

    def _begin(self, sheet: zipfile.ZipInfo) -> re.Match[bytes] | None:
        with self._archive.open(sheet) as stream:
            return _BEGIN.search(stream.read(_READ))

    def _workbook(self, sheets: dict[str, bytes]) -> bytes:
        packed = io.BytesIO()
        with zipfile.ZipFile(packed, "w", zipfile.ZIP_STORED) as archive:
            for name, content in (self._shared | sheets).items():
                archive.writestr(name, content)
        return packed.getvalue()


def _cut(stream: IO[bytes], length: int) -> Iterator[bytes]:
    """Yield the XML of a sheet in slices of some length, each with what stands in front of the first row."""
    buffer = bytearray(stream.read(_READ))
    begin = _BEGIN.search(buffer)
    assert begin is not None  # or the sheet would not be cut
    prefix = bytes(begin[1])
    head, end_of_row = bytes(buffer[: begin.end()]), b"</" + prefix + b"row>"
    end_of_rows = b"</" + prefix + b"sheetData"
    tail = end_of_rows + b"></" + prefix + b"worksheet>"
    del buffer[: begin.end()]
    row, looked = 0, 0  # the number of the last row so far; how far the buffer holds no end
    while True:
        end = buffer.find(end_of_rows, max(0, looked - len(end_of_rows)))
        looked = len(buffer)
        if end >= 0:
            yield head + _after(row, prefix) + buffer[:end] + tail
            return
        if looked >= length:
            end = buffer.rfind(end_of_row) + len(end_of_row)
            if end >= len(end_of_row):
                rows = bytes(buffer[:end])
                del buffer[:end]
                looked = 0
                yield head + _after(row, prefix) + rows + tail
                row = _last_row(rows, row, prefix)
            elif looked > _LONGEST_ROW:
                raise Refused(
                    Sentence("a row of this workbook takes more than {size} MB", size=_LONGEST_ROW >> 20),
                    expected=Sentence("a table: delete the stray cells far outside it"),
                )
        more = stream.read(_READ)
        if not more:  # the file breaks off: calamine says so
            yield head + _after(row, prefix) + buffer
            return
        buffer += more


def _after(row: int, prefix: bytes) -> bytes:
    """Return an empty row of that number, behind which rows without a number go on counting; nothing for none."""
    return b'<%brow r="%d"></%brow>' % (prefix, row, prefix) if row else b""


def _last_row(xml: bytes, row: int, prefix: bytes) -> int:
    """Return the number of the last row, counted on from the one before where it is not stated."""
    last = _ROW.match(xml, xml.rfind(b"<" + prefix + b"row"))
    if last is not None and (number := _NUMBER.search(last[1])):
        return int(number[1])
    for tag in _ROW.finditer(xml):
        number = _NUMBER.search(tag[1])
        row = int(number[1]) if number else row + 1
    return row
