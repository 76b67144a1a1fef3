"""Reads the columns of delimited text in blocks of whole lines."""

from __future__ import annotations

import csv
import io
import os
import warnings
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple, TypeVar

import numpy as np
import pandas as pd

from atleak.common.errors import InputError
from atleak.common.sentences import Sentence
from atleak.readers.logs.headings import HeadRow
from atleak.readers.logs.log_cells import MISSING, OFF, Decimal, kind_of_cells, without_unit
from atleak.readers.logs.log_file import HEAD_BYTES, LARGE, LogFile
from atleak.readers.logs.log_table import WHITESPACE, Dialect, Layout, LogTable, find_dialect, find_table, split_line
from atleak.readers.logs.loggers import SHOWN, known_logger
from atleak.readers.logs.text_lines import (
    QUOTE,
    LogText,
    even_rows,
    mended,
    one_line_end,
    signs_per_line,
    to_text,
    without_nul,
)

_BLOCK = 1 << 15
"""Numbers in a block: 256 kB."""

_Item = TypeVar("_Item")
_Result = TypeVar("_Result")


class Filled:
    """An array that takes each ``every``-th of some numbers that come part by part, ``count`` of them at most."""

    def __init__(self, count: int, every: int, kind: Any = float) -> None:
        self._room, self._every, self._met = np.empty(-(-count // every), kind), every, 0

    @property
    def numbers(self) -> np.ndarray:
        """Return those that came: a file may hold fewer than it states."""
        return self._room[: -(-self._met // self._every)]

    def add(self, part: np.ndarray) -> None:
        """Add the next numbers."""
        kept, first = part[-self._met % self._every :: self._every], len(self.numbers)
        if first + len(kept) > len(self._room):
            raise InputError(Sentence("is damaged: it holds more samples than it states"))
        self._room[first : first + len(kept)] = kept
        self._met += len(part)


def in_turn(work: Callable[[_Item], _Result], items: Iterable[_Item]) -> Iterator[_Result]:
    """Yield what work makes of every item, a few of them at once: numpy and pandas leave the cores free."""
    cores = min(4, os.cpu_count() or 1)
    with ThreadPoolExecutor(cores) as pool:
        waiting: deque[Future[_Result]] = deque()
        for item in items:
            waiting.append(pool.submit(work, item))
            if len(waiting) > cores:
                yield waiting.popleft().result()
        while waiting:
            yield waiting.popleft().result()


def turned_columns(table: np.ndarray) -> np.ndarray:
    """Return a long table of few columns as rows of its columns.

    >>> turned_columns(np.array([[1, 2], [3, 4], [5, 6]])).tolist()
    [[1, 3, 5], [2, 4, 6]]
    """
    result = np.empty(table.shape[::-1], table.dtype)
    for start in range(0, len(table), _BLOCK):
        result[:, start : start + _BLOCK] = table[start : start + _BLOCK].T
    return result


BLOCK = 4 << 20
"""Bytes of a block of whole lines: little is held beside its numbers."""
_LONGEST = 64 << 20  # bytes of a line
_LOOK = 150
"""Number of lines in which the table's beginning is sought first."""


@dataclass(frozen=True)
class Delimited(LogTable):
    """Delimited text whose table is located but not read yet.

    ``source`` holds the whole text where no byte of the file tells where its lines end. The rows lie between the bytes
    ``start`` and ``end``; behind them stands at most a last cell that breaks off. ``per_line``: how many delimiters and
    quotation marks each of the first rows has, where all have as many.
    """

    source: LogFile
    codec: str
    encoding: str
    delimiter: str
    decimal: Decimal
    layout: Layout
    start: int
    end: int
    breaks_off: bool
    sample: tuple[HeadRow, ...]
    quoted: bool
    spaced: bool
    per_line: tuple[int, int] | None

    @cached_property
    def rows(self) -> int:  # type: ignore[override]
        """Return how many rows there are, more or less: as if all were as long as the first ones."""
        first = self.source.part(self.start, min(self.start + LARGE, self.end))
        return int((self.end - self.start) / max(len(first), 1) * (first.count(b"\n") + 1))

    def read(self, columns: Sequence[int], every: int = 1) -> pd.DataFrame:
        """Read these columns block by block."""
        self.source.digest.start()
        joined = {index: _Joined(self.rows // every, self.decimal) for index in columns}
        places: list[np.ndarray] = []
        lines = kept = too_wide = short = 0
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", pd.errors.ParserWarning)
            for frame in in_turn(lambda block: self._read_block(block, columns), self._blocks()):
                too_wide, short = too_wide + frame.attrs["too_wide"], short + frame.attrs["short"]
                some = every_nth(frame, every, lines)
                for index, column in joined.items():
                    column.add(some[index], some.attrs["words"].get(index), kept)
                places.append(some.attrs.get("lines", np.empty(0, int)))
                lines, kept = lines + len(frame), kept + len(some)
                self.source.tell(lines)
        if too_wide > 0.1 * (lines + too_wide):
            problem = Sentence("{count} of its rows have more numbers than it has columns", count=too_wide)
            expected = Sentence("as many cells in every row; is the decimal comma used as delimiter too?")
            raise self.source.error(problem, expected=expected)
        result = pd.DataFrame({index: column.cells(kept) for index, column in joined.items()}, copy=False)
        result.attrs = {
            "words": {index: pd.concat(column.words) for index, column in joined.items() if column.words},
            "too_wide": too_wide,
            # where many rows have fewer cells, the logger writes blanks so
            "short": max(short - self.breaks_off, 0) if 2 * short < lines else 0,
            "breaks_off": self.breaks_off,
        }
        if every > 1:
            result.attrs["lines"] = np.concatenate(places)
        return result

    def _blocks(self) -> Iterator[bytes]:
        """Yield the rows in blocks of whole lines."""
        at, size = self.start, BLOCK
        while at < self.end:
            data = self.source.part(at, min(at + size, self.end))
            length = len(data) if at + len(data) >= self.end else data.rfind(b"\n") + 1
            if length:
                block = one_line_end(without_nul(data[:length]))
                if block.strip(b" \r\n\f\v" if self.delimiter == "\t" else None):  # a row of tabs alone is one
                    yield block
                at, size = at + length, BLOCK
            elif size > _LONGEST:
                problem = Sentence("has a line of more than {size} MB", size=_LONGEST >> 20)
                raise self.source.error(problem)
            else:
                size *= 2

    def _read_block(self, data: bytes, columns: Sequence[int]) -> pd.DataFrame:
        """Read a block; mend its rows first where they cannot be read fast, or differ."""
        try:
            frame = self._parsed(data, columns, self.quoted)
        except pd.errors.ParserError:
            frame = None
        too_wide = short = 0
        if frame is None or not even_rows(data, self.delimiter, self.per_line, self.quoted, len(frame)):
            rows = mended(data, self.delimiter, self.width, pad=frame is None)
            too_wide, short = rows.too_wide, rows.short
            if frame is None or rows.changed or rows.count != len(frame):
                try:
                    frame = self._parsed(rows.data, columns, True)
                except pd.errors.ParserError as error:
                    problem = Sentence("its lines cannot be read: {reason}", reason=str(error))
                    raise self.source.error(problem) from error
        for index, unit in self.layout.cell_units.items():  # which stands behind every number
            if index in frame and frame[index].dtype.kind not in "fiub":
                frame[index] = without_unit(frame[index], unit)
        words = {}
        for index in self._numeric.keys() & set(columns):
            if frame[index].dtype.kind not in "fiub":
                frame[index], words[index] = split_words(frame[index], self.decimal)
        frame.attrs = {"words": words, "too_wide": too_wide, "short": short}
        return frame

    @cached_property
    def _numeric(self) -> dict[int, bool]:
        """Return the columns of numbers by the sample, and whether no cell of them is a word for *missing*."""
        numeric = {}
        for index in range(self.width):
            kinds = {kind_of_cells(row[index], self.decimal) for row in self.sample if index < len(row) and row[index]}
            if "number" in kinds and kinds <= {"number", "missing"} and index not in self.layout.cell_units:
                numeric[index] = kinds == {"number"}
        return numeric

    def _parsed(self, data: bytes, columns: Sequence[int], quoted: bool) -> pd.DataFrame:
        options: dict[str, Any] = {
            "sep": r"\s+" if self.delimiter == WHITESPACE else self.delimiter,
            "decimal": self.decimal,
            "header": None,
            "names": list(range(self.width)),
            "usecols": sorted(columns),
            "index_col": False,
            "engine": "c",
            "low_memory": False,  # a column with a word is text throughout
            "skipinitialspace": self.spaced,
            "quoting": csv.QUOTE_MINIMAL if quoted else csv.QUOTE_NONE,
            "encoding": self.codec,
            "encoding_errors": "replace",
        }
        try:
            clean = {index: "float64" for index in columns if self._numeric.get(index)}
            return pd.read_csv(io.BytesIO(data), dtype=clean, **options)
        except ValueError:  # a word where only numbers were expected
            return pd.read_csv(io.BytesIO(data), **options)


class _Joined:
    """A column whose cells come in blocks: numbers in one array, the cells that are none apart, or all of them as text.

    Where some blocks hold text alone and others numbers alone, it is read cell by cell.
    """

    def __init__(self, rows: int, decimal: Decimal) -> None:
        self._numbers, self._decimal, self._texts = np.empty(rows + 1), decimal, list[pd.Series]()
        self._blank = True  # whether no number was met so far
        self.words: list[pd.Series] = []

    def add(self, cells: pd.Series, words: pd.Series | None, before: int) -> None:
        """Add the next cells, of which so many stand before; ``words`` are known of numbers that were read as such."""
        is_text = cells.dtype.kind not in "fiub"
        if self._blank and (is_text or (self._texts and cells.isna().all())):
            if not self._texts:
                self._texts.append(pd.Series([None] * before, dtype="str"))
            # without what stands in the frame's attrs, which pandas would compare
            self._texts.append(pd.Series(cells.array) if is_text else pd.Series([None] * len(cells), dtype="str"))
            return
        texts, self._texts, at = self._texts, [], 0
        for each in texts:
            self._put(*split_words(each, self._decimal), at)
            at += len(each)
        if is_text:
            self._put(*split_words(pd.Series(cells.array), self._decimal), before)
        else:
            self._put(cells.to_numpy(dtype=float), _NO_WORDS if words is None else words, before)

    def _put(self, values: np.ndarray, words: pd.Series, before: int) -> None:
        if before + len(values) > len(self._numbers):
            self._numbers = np.concatenate([self._numbers, np.empty(len(self._numbers) // 4 + len(values))])
        self._numbers[before : before + len(values)] = values
        self._blank = self._blank and not len(words) and bool(np.isnan(values).all())
        if len(words):
            self.words.append(words.set_axis(words.index + before))

    def cells(self, count: int) -> np.ndarray | pd.Series:
        """Return all cells."""
        return pd.concat(self._texts, ignore_index=True) if self._texts else self._numbers[:count]


_WORD = r"\s*[^\W\d]|\s*#"  # what begins like no number and no clock


def every_nth(frame: pd.DataFrame, every: int, before: int = 0) -> pd.DataFrame:
    """Return each ``every``-th row, and those without a number but with a word: remarks, and headers among the rows.

    So many rows of the same table stand ``before`` these.
    """
    if every == 1:
        return frame
    keep = (before + np.arange(len(frame))) % every == 0
    words, numeric = frame.attrs.get("words", {}), frame.select_dtypes("number")
    without_number = numeric.isna().all(axis=1).to_numpy() if len(numeric.columns) else np.zeros(len(frame), bool)
    for cells in words.values():
        keep[cells.index] |= without_number[cells.index]
    rows = np.flatnonzero(without_number)
    for index in frame.columns.difference(numeric.columns) if len(rows) else ():
        keep[rows] |= frame[index].iloc[rows].astype("str").str.match(_WORD, na=False).to_numpy(dtype=bool)
    result, places = frame[keep].reset_index(drop=True), np.cumsum(keep) - 1
    kept = {index: cells[keep[cells.index]] for index, cells in words.items()}
    result.attrs = {
        **frame.attrs, "lines": before + np.flatnonzero(keep),
        "words": {index: cells.set_axis(places[cells.index]) for index, cells in kept.items()},
    }  # fmt: skip
    return result


def must_be_held(source: LogFile) -> bool:
    """Return whether a text has to be held as a whole while it is read: no byte tells where its lines end."""
    head = source.head.removesuffix(b"\r")
    other_ends = b"\r" in head and (b"\n" not in head[:HEAD_BYTES] or one_line_end(head) is not head)
    return other_ends or b"\x00" in head or to_text(source.whole_lines).encoding.startswith("utf-16")


def open_delimited(source: LogFile) -> Delimited | None:
    """Locate the table in a delimited text; None when there is none."""
    if source.size > LARGE and not any(end in source.head for end in (b"\n", b"\r")):
        return None  # one endless line
    if must_be_held(source):
        text = to_text(source.data)
        text = LogText(one_line_end(text.data), text.encoding, text.codec)
        source, mark = replace(source, content=text.data, size=len(text.data)), 0
    else:
        text = to_text(source.whole_lines)
        mark = 3 * text.encoding.endswith("sig")
    size = source.size
    tail = source.part(max(size - HEAD_BYTES, 0), size)
    end = size - _half_written(tail)
    head = text.data[: min(LARGE, end - mark)].split(b"\n")
    if size > LARGE:
        head = head[:-1]
    lines = head[-80:]  # from the end of the head and from four places further on in the file
    for share in (0.3, 0.5, 0.75, 1.0) if size > LARGE else ():
        at = min(int(size * share), size - 1) - (1 << 14)
        lines += source.part(at, at + (1 << 14)).split(b"\n")[1:-1][:20]
    dialect = find_dialect([text.decode(line) for line in lines])
    if dialect is None:
        return None
    delimiter = dialect.delimiter
    layout, rows = _locate(head, text, dialect)
    if layout is None:
        return None
    if logger := known_logger(text.decode(text.data[:SHOWN]).replace("\r", "")):
        above = text.decode(b"\n".join(head[: layout.start])).replace("\r", "")
        layout = logger.described(layout, above, rows[layout.start :][:400])
    start = mark + sum(len(line) + 1 for line in head[: layout.start])
    body = (source.part(start, start + HEAD_BYTES), tail)
    return Delimited(
        source, text.codec, text.encoding, delimiter, dialect.decimal, layout, start, end, end < size,
        sample=tuple(rows[layout.start :][:400]),
        quoted=any(QUOTE in part for part in body),
        spaced=any(delimiter.encode() + b" " in part for part in body),
        per_line=signs_per_line(head[layout.start :][:400], delimiter),
    )  # fmt: skip


def _locate(head: Sequence[bytes], text: LogText, dialect: Dialect) -> tuple[Layout | None, list[HeadRow]]:
    """Return where the table is, and the lines looked at for it, more of them until it is sure, in cells."""
    rows: list[HeadRow] = []
    layout = None
    for count in (_LOOK, 4 * _LOOK, 16 * _LOOK, len(head)):
        rows += [split_line(text.decode(line), dialect.delimiter) for line in head[len(rows) : count]]
        layout = find_table(rows, dialect.decimal, dialect.width)
        # lines of the head may look like a table until one with as many cells as the rows comes
        met = layout is not None and abs(layout.width - dialect.width) <= 1 and layout.start < 0.8 * len(rows)
        if met or count >= len(head):
            break
    return layout, rows


def _half_written(tail: bytes) -> int:
    """Return how many bytes the last cell takes, perhaps half-written, of a log whose last line breaks off."""
    if tail.endswith((b"\n", b"\r")) or b"\n" not in tail:
        return 0
    lines = tail.split(b"\n")
    last, before = lines[-1], [line for line in lines[:-1] if line.strip(b" \r")][-3:]
    for delimiter in (b"\t", b";", b","):
        usual = {line.count(delimiter) for line in before}
        if len(usual) == 1 and min(usual) > 0:
            cut = last.count(delimiter) < min(usual) and delimiter in last
            return len(last) - last.rindex(delimiter) if cut else 0
    return 0


_NO_WORDS = pd.Series([], dtype="str")


class Cells(NamedTuple):
    """A column as floats, and those of its cells that are neither a number nor a word for *missing*."""

    values: np.ndarray
    words: pd.Series


def split_words(column: pd.Series, decimal: Decimal) -> Cells:
    """Part a column's numbers from its words."""
    if column.dtype.kind in "fiub":
        values = column.to_numpy(dtype=float)
        return Cells(np.where(np.isinf(values), np.nan, values) if np.isinf(values).any() else values, _NO_WORDS)
    text = column.astype("str").str.strip().str.strip('"').str.strip()
    plain = text
    if decimal == ",":
        dotted = text.str.contains(".", regex=False, na=False).to_numpy()
        plain = text.str.replace(",", ".", regex=False).where(~dotted)
    values = pd.to_numeric(plain, errors="coerce").to_numpy(dtype=float, na_value=np.nan)
    values = np.where(np.isinf(values), np.nan, values)
    rest = text[np.isnan(values) & column.notna().to_numpy()]
    return Cells(values, rest[~rest.str.lower().isin(MISSING - {OFF})])


def words_of(frame: pd.DataFrame, index: int, decimal: Decimal) -> pd.Series:
    """Return the cells of a column that are no numbers, by row label."""
    stored = frame.attrs.get("words", {}).get(index)
    if stored is not None:
        return stored[stored.index.isin(frame.index)] if len(stored) else stored
    return split_words(frame[index], decimal).words


def numbers(frame: pd.DataFrame, index: int, decimal: Decimal) -> Cells:
    """Return a column as floats and its cells that are no numbers."""
    cells = split_words(frame[index], decimal)
    if index in frame.attrs.get("words", {}):
        return cells._replace(words=words_of(frame, index, decimal))
    return cells
