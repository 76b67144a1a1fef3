"""Where the outermost cells of a sheet lie, told from its XML.

calamine lays a sheet out from its first cell to its last: a single stray cell in the last corner makes it ask for
half a terabyte and takes the process with it. So the cells are looked at before it is.
"""

from __future__ import annotations

import re
from collections.abc import Iterable

_REFERENCE = re.compile(rb'\br="([A-Z]{1,3})(\d{1,7})"')
_OVERLAP = 32  # bytes: longer than any reference


def column_index(letters: str) -> int:
    """A column's letters as a number from 0.

    >>> column_index("A"), column_index("AB")
    (0, 27)
    """
    index = 0
    for letter in letters:
        index = index * 26 + ord(letter) - 64
    return index - 1


def extent(parts: Iterable[bytes]) -> tuple[int, int, int]:
    """Rows, columns and number of the cells of a sheet, from its XML in pieces.

    >>> extent([b'<row r="2"><c r="B2"/><c r="AA', b'7"/></row>'])
    (7, 27, 2)
    """
    rows = count = 0
    columns: set[bytes] = set()
    kept = b""
    for part in parts:
        text = kept + part
        # a reference that ends in the overlap is found again, and counted, with the next piece
        done = max(len(text) - _OVERLAP, 0)
        for found in _REFERENCE.finditer(text):
            if found.end() > done:
                done = min(done, found.start())
                break
            count += 1
            columns.add(found[1])
            rows = max(rows, int(found[2]))
        kept = text[done:]
    for found in _REFERENCE.finditer(kept):
        count += 1
        columns.add(found[1])
        rows = max(rows, int(found[2]))
    return rows, max((column_index(letters.decode()) + 1 for letters in columns), default=0), count
