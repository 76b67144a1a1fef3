"""Opens the binary logs of TunerStudio and MegaLogViewer (``.mlg``), form 1 and 2.

The form is that of EFI Analytics' *MLG Binary LOG Format*: numbers are big-endian; a head describes the fields, behind
it stand blocks of values, and between them markers of the driver. A value is (raw + transform) · scale.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from atleak.common.sentences import Sentence
from atleak.readers.logs.headings import Heading, HeadRow
from atleak.readers.logs.log_cells import Decimal
from atleak.readers.logs.log_file import LogFile
from atleak.readers.logs.log_sheets import text_of_cell
from atleak.readers.logs.log_table import Layout, LogTable
from atleak.readers.logs.names import clean_unit, split_unit

_TYPES = {0: "u1", 1: "i1", 2: ">u2", 3: ">i2", 4: ">u4", 5: ">i4", 6: ">i8", 7: ">f4", 10: "u1", 11: ">u2", 12: ">u4"}
_FIRST_OF_BITS = 10
_HEADS = {  # by the form's version
    version: np.dtype([("start", "S6"), ("version", ">i2"), ("time", ">i4"), ("info", info), ("data", ">i4"),
                       ("length", ">i2"), ("fields", ">i2")])
    for version, info in ((1, ">i2"), (2, ">i4"))
}  # fmt: skip
_FIELD = [("type", "u1"), ("name", "S34"), ("unit", "S10"), ("style", "u1"), ("scale", ">f4"), ("transform", ">f4"),
          ("digits", "i1")]  # fmt: skip
_FIELDS = {1: np.dtype(_FIELD), 2: np.dtype([*_FIELD, ("category", "S34")])}
_MARKER = 54  # bytes of a block with a marker
_SAMPLE = 400  # rows
_MOST_ARE_GOOD = 0.9


@dataclass(frozen=True)
class MlgLog(LogTable):
    """A binary log whose fields are known; ``blocks`` are its values as they stand in the file."""

    layout: Layout
    rows: int
    blocks: np.ndarray
    places: tuple[str, ...]  # of each column in the blocks
    scales: tuple[tuple[float, float], ...]  # by which, and after adding what
    decimal: Decimal = "."

    @property
    def sample(self) -> tuple[HeadRow, ...]:  # type: ignore[override]
        """Return the first rows as text."""
        columns = [self._column(index)[:_SAMPLE].tolist() for index in range(self.width)]
        return tuple([text_of_cell(cell) for cell in row] for row in zip(*columns, strict=True))

    def read(self, columns: Sequence[int], every: int = 1) -> pd.DataFrame:
        """Read these columns."""
        frame = pd.DataFrame({index: self._column(index, every) for index in columns}, copy=False)
        frame.attrs["lines"] = np.arange(0, self.rows, every)
        return frame

    def _column(self, index: int, every: int = 1) -> np.ndarray:
        scale, transform = self.scales[index]
        return np.round((self.blocks[self.places[index]][::every].astype(float) + transform) * scale, 9)


def open_mlg(source: LogFile) -> MlgLog:
    """Return the table of a binary log; refuse one that is damaged or of another version."""
    data = source.data
    damaged = source.error(Sentence("is a damaged log of {logger}", logger="TunerStudio"))
    version = int.from_bytes(data[6:8], "big")
    if version not in _HEADS:
        expected = Sentence("the log exported as CSV or text by {program}", program="MegaLogViewer")
        problem = Sentence("is a log of {logger} in a binary form that is not read", logger="TunerStudio")
        raise source.error(problem, version, expected)
    form = _FIELDS[version]
    at = _HEADS[version].itemsize
    head = np.frombuffer(data[:at].ljust(at, b"\x00"), _HEADS[version])[0]
    count = int(head["fields"])
    if not 0 < count * form.itemsize <= len(data) - at or not at <= head["data"] <= len(data):
        raise damaged
    fields = np.frombuffer(data, form, count, at)
    values = [(f"f{place}", _TYPES.get(int(kind), "u1")) for place, kind in enumerate(fields["type"])]
    block = np.dtype([("kind", "u1"), ("counter", "u1"), ("stamp", ">u2"), *values, ("sum", "u1")])
    if block.itemsize - 5 != head["length"]:
        raise damaged
    blocks = _blocks(data, int(head["data"]), block)
    if not len(blocks):
        raise source.error(Sentence("holds no rows: the logger wrote nothing"))
    summed = blocks.view((np.uint8, block.itemsize))[:, 4:-1].sum(axis=1, dtype=np.uint8)
    good = summed == blocks["sum"]
    if np.mean(good) < _MOST_ARE_GOOD:
        raise damaged
    note = Sentence("read as a log of {logger}", logger="TunerStudio")
    if wrong := int(np.count_nonzero(~good)):
        note = Sentence("{note}: {count} row(s) with a wrong checksum left out", note=note, count=wrong)
        blocks = blocks[good]
    used = [place for place, kind in enumerate(fields["type"]) if kind < _FIRST_OF_BITS]
    headings = tuple(_heading(index, fields[place]) for index, place in enumerate(used))
    scales = tuple((float(fields[place]["scale"]), float(fields[place]["transform"])) for place in used)
    layout = Layout(0, len(used), headings, True, (), (), note=note)
    return MlgLog(layout, len(blocks), blocks, tuple(f"f{place}" for place in used), scales)


def _blocks(data: bytes, at: int, block: np.dtype) -> np.ndarray:
    """Return the blocks of values between the markers; a last one that breaks off is left out."""
    parts = []
    while (count := (len(data) - at) // block.itemsize) > 0:
        part = np.frombuffer(data, block, count, at)
        markers = np.flatnonzero(part["kind"])
        part = part[: markers[0]] if len(markers) else part
        parts.append(part)
        at += len(part) * block.itemsize + _MARKER
        if not len(markers):
            break
    return np.concatenate(parts) if parts else np.empty(0, block)


def _heading(index: int, field: np.void) -> Heading:
    name, unit = (bytes(field[part]).split(b"\x00")[0].decode("utf-8", "replace").strip() for part in ("name", "unit"))
    split = split_unit(name)
    return Heading(
        index, name or f"column {index + 1}", (split.text,) if name else (), split.unit or clean_unit(unit) or None
    )
