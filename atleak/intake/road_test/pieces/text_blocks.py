"""Reads a large delimited text block by block: each block of whole lines as a file of its own would be read."""

from __future__ import annotations

from collections.abc import Generator, Iterator, Sequence
from dataclasses import replace

import pandas as pd

from atleak.errors import Place, RoadTestError
from atleak.intake.road_test.files.decoding import LogText, without_nul
from atleak.intake.road_test.files.delimited import Delimited, without_cut_cell
from atleak.intake.road_test.files.rows import one_line_end
from atleak.sentence import Sentence

BLOCK = 16 << 20
"""Bytes of text that are read at once."""
_LONGEST = 64 << 20  # bytes of a line


def blocks_of_text(table: Delimited, columns: Sequence[int]) -> Generator[pd.DataFrame]:
    """Yield columns of a table whose text is not held, as `Delimited.read` gives them, block by block.

    Raises
    ------
    RoadTestError
        as `Delimited.read`, and for a line without end.
    """
    for data, last in _whole_lines(table):
        whole = LogText(one_line_end(without_nul(data)), table.encoding, table.codec)
        text = without_cut_cell(whole) if last else whole
        block = replace(table, text=text, offset=0, breaks_off=text is not whole, of_many=True)
        frame = block.read(columns)
        if len(frame) or frame.attrs.get("too_wide"):
            yield frame


def _whole_lines(table: Delimited) -> Iterator[tuple[bytes, bool]]:
    """Yield the bytes behind the header in blocks of whole lines, and whether a block is the last one."""
    path = table.source.path
    assert path is not None
    rest, ready = b"", b""
    with path.open("rb") as stream:
        stream.seek(table.offset + 3 * table.encoding.endswith("sig"))
        while chunk := stream.read(BLOCK):
            data = rest + chunk
            end = data.rfind(b"\n") + 1
            if not end and len(data) > _LONGEST:
                problem = Sentence("has a line of more than {size} MB", size=_LONGEST >> 20)
                raise RoadTestError(problem, place=Place(file=table.source.file))
            if end and ready:
                yield ready, False
            ready, rest = (data[:end], data[end:]) if end else (ready, data)
    yield ready + rest, True
