"""Reads columns of delimited text fast, and row by row what the fast way cannot."""

from __future__ import annotations

import csv
import io
import warnings
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from atleak.intake.road_test.cells import MISSING, Decimal
from atleak.intake.road_test.source import HEAD, Source
from atleak.intake.road_test.table import WHITESPACE, Heading, Layout, Row, find_dialect, find_table, split_line
from atleak.intake.road_test.text import Text, to_text

_LONG_HEAD = 1 << 18
LOOK = 600
"""Lines among which the table's beginning is sought first."""


@dataclass(frozen=True)
class Delimited:
    """Delimited text whose table is found but not read yet."""

    text: Text
    delimiter: str
    decimal: Decimal
    layout: Layout
    offset: int
    sample: tuple[Row, ...]
    quoted: bool
    spaced: bool

    @property
    def headings(self) -> tuple[Heading, ...]:
        """The columns' headings."""
        return self.layout.headings

    @property
    def has_header(self) -> bool:
        """Whether any row names the columns."""
        return self.layout.has_header

    @property
    def preamble(self) -> tuple[Row, ...]:
        """The rows above the header."""
        return self.layout.preamble

    def read(self, columns: Sequence[int]) -> pd.DataFrame:
        """These columns of every line from the first data row on: numbers as floats, anything else as text."""
        frame = self._read(columns, None)
        mixed = [index for index in columns if frame[index].dtype == object]
        if mixed:  # numbers in one part of the file, text in another: one spelling for all
            frame[mixed] = self._read(mixed, "str")
        return frame

    def _read(self, columns: Sequence[int], dtype: str | None) -> pd.DataFrame:
        stream = io.BytesIO(self.text.data)
        stream.seek(self.offset)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", pd.errors.ParserWarning)
            warnings.simplefilter("ignore", pd.errors.DtypeWarning)
            return pd.read_csv(
                stream,
                sep=r"\s+" if self.delimiter == WHITESPACE else self.delimiter,
                decimal=self.decimal,
                header=None,
                names=list(range(self.layout.width)),
                index_col=False,
                usecols=sorted(columns),
                dtype=dtype,  # type: ignore[arg-type]
                engine="c",
                skipinitialspace=self.spaced,
                quoting=csv.QUOTE_MINIMAL if self.quoted else csv.QUOTE_NONE,
                encoding=self.text.codec,
                encoding_errors="replace",
            )


def _lines(data: bytes) -> list[bytes]:
    if b"\n" not in data[:HEAD] and b"\r" in data[:HEAD]:
        return data.split(b"\r")
    return data.split(b"\n")


def _sample_lines(text: Text, head: list[bytes]) -> list[str]:
    """Lines from the head's end and from four places further on in the file."""
    chosen = head[-200:]
    size = len(text.data)
    if size > _LONG_HEAD:
        for part in (0.3, 0.5, 0.75, 1.0):
            at = min(int(size * part), size - 1) - (1 << 14)
            chosen += _lines(text.data[at : at + (1 << 14)])[1:-1][:60]
    return [text.decode(line) for line in chosen]


def open_delimited(source: Source) -> Delimited | None:
    """Finds the table in a delimited text, or None when there is none."""
    text = to_text(source.data)
    if b"\n" not in text.data[:HEAD] and b"\r" in text.data[:HEAD]:
        text = Text(text.data.replace(b"\r", b"\n"), text.encoding, text.codec)
    text = without_cut_cell(text)
    head = _lines(text.data[:_LONG_HEAD])
    if len(text.data) > _LONG_HEAD:
        head = head[:-1]
    dialect = find_dialect(_sample_lines(text, head))
    if dialect is None:
        return None
    delimiter, decimal = dialect.delimiter, dialect.decimal
    rows: list[Row] = []
    layout = None
    for count in (LOOK, 4 * LOOK, len(head)):
        rows += [split_line(text.decode(line), delimiter) for line in head[len(rows) : count]]
        layout = find_table(rows, decimal, dialect.width)
        if (layout is not None and layout.start < 0.8 * len(rows)) or count >= len(head):
            break
    if layout is None:
        return None
    offset = sum(len(line) + 1 for line in head[: layout.start])
    body = (text.data[offset : offset + HEAD], text.data[-HEAD:])
    quoted = any(b'"' in part for part in body)
    spaced = any(delimiter.encode() + b" " in part for part in body)
    sample = tuple(rows[layout.start :][:400])
    return Delimited(text, delimiter, decimal, layout, offset, sample, quoted, spaced)


def without_cut_cell(text: Text) -> Text:
    """A log whose last line breaks off: the last, perhaps cut, cell is taken away, the row stays."""
    data = text.data
    if data.endswith((b"\n", b"\r")) or b"\n" not in data[-HEAD:]:
        return text
    lines = data[-HEAD:].split(b"\n")
    last, before = lines[-1], [line for line in lines[:-1] if line.strip()][-3:]
    for delimiter in (b"\t", b";", b","):
        usual = {line.count(delimiter) for line in before}
        if len(usual) == 1 and min(usual) > 0:
            if last.count(delimiter) < min(usual) and delimiter in last:
                return Text(data[: data.rindex(delimiter)], text.encoding, text.codec)
            break
    return text


def numbers(column: pd.Series, decimal: Decimal) -> tuple[np.ndarray, int]:
    """A column as floats and how many of its cells held something that is neither number nor a word for missing."""
    if column.dtype.kind in "fiub":
        values = column.to_numpy(dtype=float)
        if column.dtype.kind == "f" and not np.isfinite(values.sum()):
            values = np.where(np.isinf(values), np.nan, values)
        return values, 0
    text = column.astype("str").str.strip().str.strip('"').str.strip()
    blank = column.isna().to_numpy() | text.str.lower().isin(MISSING).to_numpy()
    if decimal == ",":
        dotted = text.str.contains(".", regex=False, na=False).to_numpy()
        text = text.str.replace(",", ".", regex=False).where(~dotted)
    values = pd.to_numeric(text, errors="coerce").to_numpy(dtype=float, na_value=np.nan)
    values = np.where(np.isinf(values), np.nan, values)
    return values, int((np.isnan(values) & ~blank).sum())
