"""Describe the form of a sheet or a log without what it says, to be shown to whoever is asked why it is not read.

Digits become 9. Letters become a or A, but for words that headings of sheets and logs use, and units. Of signs that
hold letters and digits, as plates and numbers of vehicles do, nothing stays.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from functools import cache
from pathlib import Path

from atleak.readers.cells.sheet import text_of
from atleak.readers.cells.sheet_file import read_workbook
from atleak.readers.logs.log_file import LogFile, open_source
from atleak.readers.logs.names import in_synonyms, is_unit
from atleak.readers.logs.text_lines import to_text
from atleak.readers.sheets.words import is_word

_FIRST, _LAST = 40, 3  # rows that are shown
_LONGEST = 400  # signs of a row
_MIXED = re.compile(r"(?=\w*\d)(?=\w*[^\W\d_])[^\W_]{5,}")  # a plate, a VIN, a part number
_WORD = re.compile(r"[^\W\d_]+")


def masked_file(source: str | Path | bytes, name: str | None = None) -> str:
    """Return the first and last rows of a log or a sheet, masked, below a line about the file.

    Of a log that is no text only its kind and size are told. ``name`` is what messages call it; it is not told either.
    An `InputError` says that there is no such file, or that it is neither a text nor a table.
    """
    file = open_source(source, name)
    try:
        return "\n".join([*_rows(file), ""])
    finally:
        file.close()


def masked(text: str) -> str:
    """Return a text with nothing in it but its form, and words of the trade.

    >>> masked("Oil temp [°C]; Kowalski; KR 7AB12; 12.5")
    'Oil temp [°C]; Aaaaaaaa; AA 9AA99; 99.9'
    """
    text = _MIXED.sub(lambda found: _signs(found[0]), text)
    return re.sub(r"\d", "9", _WORD.sub(lambda found: found[0] if _known(found[0]) else _signs(found[0]), text))


def _signs(text: str) -> str:
    return "".join(("A" if sign.isupper() else "a") if sign.isalpha() else sign for sign in text)


@cache
def _known(word: str) -> bool:
    """Tell whether sheets or logs use a word in their headings, or it is a unit; masked letters are no word."""
    return bool(set(word) - set("aA")) and (is_word(word) or in_synonyms(word) or is_unit(word))


def _rows(file: LogFile) -> Iterator[str]:
    yield f"{file.form}, {file.size} bytes"
    if file.form == "workbook":
        for sheet in read_workbook(file.data, file.file):
            yield f"sheet {masked(str(sheet.name))}, {len(sheet.rows)} rows"
            rows = enumerate(sheet.rows)
            yield from _shown((sheet.row_number(row), " | ".join(map(text_of, cells))) for row, cells in rows)
    elif file.form == "text":
        text = to_text(file.whole_lines)
        yield text.encoding
        yield from _shown(enumerate(text.decode(text.data).splitlines(), 1))


def _shown(rows: Iterable[tuple[int, str]]) -> Iterator[str]:
    every = list(rows)
    for number, row in every if len(every) <= _FIRST + _LAST else [*every[:_FIRST], *every[-_LAST:]]:
        yield f"{number}: {masked(row[:_LONGEST]).rstrip(' |')}"
