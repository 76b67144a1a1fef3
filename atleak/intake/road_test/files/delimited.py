"""Reads columns of delimited text fast, and cell by cell those that the fast way cannot read."""

from __future__ import annotations

import csv
import io
import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Literal, NamedTuple

import numpy as np
import pandas as pd

from atleak.errors import Place, RoadTestError
from atleak.intake.road_test.blocks import Ends, ends_of
from atleak.intake.road_test.files.cells import MISSING, OFF, Decimal, kind_of, without_unit
from atleak.intake.road_test.files.decoding import LogText, to_text, without_nul
from atleak.intake.road_test.files.headings import Heading, Row
from atleak.intake.road_test.files.layout import WHITESPACE, Layout, OfLayout, find_dialect, find_table, split_line
from atleak.intake.road_test.files.log_file import HEAD, LARGE, PIECE, LogFile, Look, beside
from atleak.intake.road_test.files.rows import QUOTE, Tallying, mended, one_line_end, signs_per_line
from atleak.sentence import Sentence

_Numeric = dict[int, Literal["float64"]]  # column → how it is read

_LONG_HEAD = 1 << 18
BLOCKS = 64 << 20
"""Bytes of a text from which on it is read in blocks of whole lines: then little is held beside its numbers."""
BLOCK = 8 << 20
"""Bytes of such a block."""
_LONGEST = 64 << 20  # bytes of a line
LOOK = 150
"""Number of lines in which the table's beginning is sought first."""


@dataclass(frozen=True)
class Delimited(OfLayout):
    """Delimited text whose table is located but not read yet.

    ``text`` is the whole text, or None where the fast reader may take the file at ``source.path``, or blocks of it, as
    it is. ``per_line``: how many delimiters and quotation marks each of the first rows has, where all have as many.
    ``breaks_off``: whether the last line's last cell, perhaps half-written, is left out. ``of_many``: whether it is one
    block of many: how many of all rows are too wide is then for others to judge.
    """

    source: LogFile
    text: LogText | None
    codec: str
    encoding: str
    delimiter: str
    decimal: Decimal
    layout: Layout
    offset: int
    sample: tuple[Row, ...]
    quoted: bool
    spaced: bool
    per_line: tuple[int, int] | None
    breaks_off: bool = False
    of_many: bool = False

    @property
    def headings(self) -> tuple[Heading, ...]:
        """Return the columns' headings."""
        return self.layout.headings

    @property
    def has_header(self) -> bool:
        """Return whether any row names the columns."""
        return self.layout.has_header

    @cached_property
    def rows(self) -> int:
        """Return how many rows there are, more or less: as if all were as long as the first ones."""
        first = self.source.whole_lines[self.offset :] if self.text is None else self.text.data[self.offset :][:LARGE]
        size = self.source.size if self.text is None else len(self.text.data)
        return int((size - self.offset) / max(len(first), 1) * (first.count(b"\n") + 1))

    def read(self, columns: Sequence[int], every: int = 1) -> pd.DataFrame:
        """Read these columns from the first data row on: numbers as floats, anything else as text.

        Every line is a row, of which each ``every``-th is kept. How many were left out, because they have more numbers
        than the table has columns, stands in ``attrs["too_wide"]``, how many have fewer cells in ``attrs["short"]``,
        and whether the last line breaks off in ``attrs["breaks_off"]``. Where not all are kept, their numbers stand in
        ``attrs["lines"]``.

        Raises
        ------
        RoadTestError
            when its lines cannot be told apart, or many of them have more numbers than the table has columns.
        """
        if self.text is None and self.source.size > BLOCKS:
            return self._joined(columns, every)
        return thinned(self._read_lines(columns), every)

    def _joined(self, columns: Sequence[int], every: int) -> pd.DataFrame:
        """Read columns of a text that is not held, block by block."""
        self.source.digest.start()
        joined = {index: _Joined(self.rows // every, self.decimal) for index in columns}
        places: list[np.ndarray] = []
        lines = kept = too_wide = short = 0
        breaks_off = False
        for block in self._blocks():
            frame = block._read_lines(columns)
            too_wide, short = too_wide + frame.attrs.get("too_wide", 0), short + frame.attrs.get("short", 0)
            some = thinned(frame, every, lines)
            for index, column in joined.items():
                column.add(some[index], some.attrs.get("words", {}).get(index), kept)
            places.append(some.attrs.get("lines", np.empty(0, int)))
            lines, kept, breaks_off = lines + len(frame), kept + len(some), block.breaks_off
        refuse_too_wide(too_wide, lines, self.source.file)
        result = pd.DataFrame({index: column.cells(kept) for index, column in joined.items()}, copy=False)
        words = {index: pd.concat(column.words) for index, column in joined.items() if column.words}
        short = counted_short(short, lines, breaks_off)
        result.attrs = {"words": words, "too_wide": too_wide, "short": short, "breaks_off": breaks_off}
        if every > 1:
            result.attrs["lines"] = np.concatenate(places)
        return result

    def _blocks(self) -> Iterator[Delimited]:
        """Yield tables of whole lines that together are this one.

        Raises
        ------
        RoadTestError
            for a line without end.
        """
        rest, at = b"", self.offset + 3 * self.encoding.endswith("sig")
        while True:
            data = self.source.part(at, at + BLOCK)
            at, last = at + len(data), at + len(data) >= self.source.size or not data
            data = rest + data
            end = len(data) if last else data.rfind(b"\n") + 1
            if not end and len(data) > _LONGEST:
                problem = Sentence("has a line of more than {size} MB", size=_LONGEST >> 20)
                raise RoadTestError(problem, place=Place(file=self.source.file))
            whole = LogText(one_line_end(without_nul(data[:end])), self.encoding, self.codec)
            text, rest = without_cut_cell(whole) if last else whole, data[end:]
            if text.data.strip():
                yield replace(self, text=text, offset=0, breaks_off=text is not whole, of_many=True)
            if last:
                return

    def _read_lines(self, columns: Sequence[int]) -> pd.DataFrame:
        """Read columns of a text that is held, or that the fast reader takes at once."""
        tallying = Tallying(self.delimiter, self.quoted)
        wait = self._look_through(tallying.add)
        try:
            frame = self._read_once(columns)
        except pd.errors.ParserError:
            frame = None
        wait()
        if tallying.tally().even(-1 if frame is None else len(frame), self.per_line) and frame is not None:
            frame.attrs["breaks_off"] = self.breaks_off
            return self._without_cell_units(frame)
        text = self.text or prepared(self.source)
        rows = mended(text.data[self.offset :], self.delimiter, self.width, pad=frame is None)
        if not self.of_many:
            refuse_too_wide(rows.too_wide, rows.count, self.source.file)
        if frame is None or rows.changed or rows.count != len(frame):
            again = replace(self, text=LogText(rows.data, text.encoding, text.codec), offset=0, quoted=True)
            try:
                frame = again._read_once(columns)
            except pd.errors.ParserError as error:
                problem = Sentence("its lines cannot be read: {reason}", reason=str(error))
                raise RoadTestError(problem, place=Place(file=self.source.file)) from error
        frame.attrs["too_wide"] = rows.too_wide
        frame.attrs["short"] = rows.short if self.of_many else counted_short(rows.short, rows.count, self.breaks_off)
        frame.attrs["breaks_off"] = self.breaks_off
        return self._without_cell_units(frame)

    def _look_through(self, look: Look) -> Callable[[], None]:
        """Show the bytes of the rows, a piece at a time, in a thread; return what waits until that is done."""
        if self.text is None:
            return self.source.look_through(self.offset + 3 * self.encoding.endswith("sig"), look)
        data = memoryview(self.text.data)
        return beside(look, (data[at : at + PIECE] for at in range(self.offset, len(data), PIECE)))

    def _without_cell_units(self, frame: pd.DataFrame) -> pd.DataFrame:
        """Take the unit out of the cells of the columns in which it stands behind every number."""
        for index, unit in self.layout.cell_units.items():
            if index in frame and frame[index].dtype.kind not in "fiub":
                frame[index] = without_unit(frame[index], unit)
        return frame

    def _read_once(self, columns: Sequence[int]) -> pd.DataFrame:
        clean, dirty = self._expected(columns)
        rest = [index for index in columns if index not in dirty]
        frame = self._read_numbers(rest, clean) if rest else pd.DataFrame()
        if frame is None:  # a word where only numbers were expected
            return self._in_pieces(columns, {*clean, *dirty})
        odd = [index for index in columns if index in dirty or frame[index].dtype == object]
        if not odd:
            return frame
        pieces = self._in_pieces(odd, {*clean, *dirty})
        if rest:
            words, pieces = pieces.attrs["words"], frame.drop(columns=odd, errors="ignore").join(pieces, how="right")
            pieces.attrs["words"] = words
        return pieces

    def _expected(self, columns: Sequence[int]) -> tuple[set[int], set[int]]:
        """Return the columns that hold only numbers in the sample, and those that also hold words for *missing*."""
        clean, dirty = set(), set()
        for index in columns:
            if index in self.layout.cell_units:
                continue
            cells = [row[index] for row in self.sample if index < len(row) and row[index]]
            kinds = {kind_of(cell, self.decimal) for cell in cells}
            if kinds == {"number"}:
                clean.add(index)
            elif kinds == {"number", "missing"}:
                dirty.add(index)
        return clean, dirty

    def _read_numbers(self, columns: Sequence[int], clean: set[int]) -> pd.DataFrame | None:
        numeric: _Numeric = {index: "float64" for index in columns if index in clean}
        frame = self._read_file(columns, numeric) if self.text is None else None
        if frame is not None:
            return frame
        try:
            return self._read(self.text or prepared(self.source), columns, numeric)
        except ValueError:
            return None

    def _in_pieces(self, columns: Sequence[int], numeric: set[int]) -> pd.DataFrame:
        """Read the columns cell by cell: numbers as floats, other cells in ``attrs["words"]``.

        It reads in pieces, because pandas makes an object of every cell before it packs them.
        """
        text = self.text or prepared(self.source)
        stream = io.BytesIO(text.data)
        stream.seek(self.offset)
        parts: dict[int, list[Any]] = {index: [] for index in columns}
        words: dict[int, list[pd.Series]] = {index: [] for index in columns if index in numeric}
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", pd.errors.ParserWarning)
            with pd.read_csv(
                stream,
                usecols=sorted(columns),
                dtype="str",
                encoding=text.codec,
                encoding_errors="replace",
                chunksize=25_000,
                **self._options(),
            ) as reader:
                for piece in reader:
                    for index in columns:
                        if index in numeric:
                            cells = split_words(piece[index], self.decimal)
                            parts[index].append(cells.values)
                            words[index].append(cells.words)
                        else:
                            parts[index].append(piece[index])
        frame = pd.DataFrame(
            {
                index: np.concatenate(part) if index in numeric else pd.concat(part, ignore_index=True)
                for index, part in parts.items()
                if part
            }
        )
        frame.attrs["words"] = {index: pd.concat(part) for index, part in words.items() if part}
        return frame

    def _read_file(self, columns: Sequence[int], numeric: _Numeric) -> pd.DataFrame | None:
        """Let pandas read the file itself, on several cores where it can; None where the text must be mended first."""
        whole = 2 * len(columns) >= self.layout.width
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", pd.errors.ParserWarning)
                warnings.simplefilter("ignore", pd.errors.DtypeWarning)
                frame = pd.read_csv(
                    str(self.source.path),
                    skiprows=self.layout.start,
                    usecols=None if whole else sorted(columns),
                    dtype=numeric,
                    encoding="utf-8",
                    **self._options(),
                )
        except (ValueError, UnicodeDecodeError):  # pandas' parser errors are ValueErrors
            return None
        # a zero byte among numbers would have stopped the reader; in text it must be looked for
        if any(frame[index].dtype.kind not in "fiub" for index in columns) and self.source.digest.has_nul:
            return None
        return frame[list(columns)] if whole and len(columns) < self.layout.width else frame

    def _read(self, text: LogText, columns: Sequence[int], numeric: _Numeric) -> pd.DataFrame:
        stream = io.BytesIO(text.data)
        stream.seek(self.offset)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", pd.errors.ParserWarning)
            warnings.simplefilter("ignore", pd.errors.DtypeWarning)
            return pd.read_csv(
                stream,
                usecols=sorted(columns),
                dtype=numeric,
                encoding=text.codec,
                encoding_errors="replace",
                **self._options(),
            )

    def _options(self) -> dict[str, Any]:
        return {
            "sep": r"\s+" if self.delimiter == WHITESPACE else self.delimiter,
            "decimal": self.decimal,
            "header": None,
            "names": list(range(self.layout.width)),
            "index_col": False,
            "engine": "c",
            "skipinitialspace": self.spaced,
            "quoting": csv.QUOTE_MINIMAL if self.quoted else csv.QUOTE_NONE,
        }


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
        cells = pd.Series(cells.array)  # without what stands in the frame's attrs, which pandas would compare
        is_text = cells.dtype.kind not in "fiub"
        if self._blank and (is_text or (self._texts and cells.isna().all())):
            if not self._texts:
                self._texts.append(pd.Series([None] * before, dtype="str"))
            self._texts.append(cells if is_text else pd.Series([None] * len(cells), dtype="str"))
            return
        texts, self._texts, at = self._texts, [], 0
        for each in texts:
            self._put(split_words(each, self._decimal), at)
            at += len(each)
        read = split_words(cells, self._decimal)
        self._put(read if words is None else read._replace(words=words), before)

    def _put(self, cells: Cells, before: int) -> None:
        values, words, _ = cells
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


def thinned(frame: pd.DataFrame, every: int, before: int = 0) -> pd.DataFrame:
    """Return each ``every``-th row, and those without a number but with a word: remarks, and headers among the rows.

    Parameters
    ----------
    before
        how many rows of the same table stand before these.
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


def counted_short(short: int, rows: int, breaks_off: bool) -> int:
    """Return how many rows have fewer cells, but for a last one that breaks off; 0 where many write blanks so."""
    return max(short - breaks_off, 0) if 2 * short < rows else 0


def refuse_too_wide(too_wide: int, rows: int, file: str) -> None:
    """Refuse a table of which many rows have more numbers than it has columns.

    Raises
    ------
    RoadTestError
        saying how many they are beside those that have not.
    """
    if too_wide > 0.1 * (rows + too_wide):
        problem = Sentence("{count} of its rows have more numbers than it has columns", count=too_wide)
        expected = Sentence("as many cells in every row; is the decimal comma used as delimiter too?")
        raise RoadTestError(problem, place=Place(file=file), expected=expected)


def prepared(source: LogFile) -> LogText:
    """Return the whole text of a log, mended: no zero bytes, line feeds at line ends, no half-written cell."""
    return without_cut_cell(_whole(source))


def _whole(source: LogFile) -> LogText:
    text = to_text(source.data)
    return LogText(one_line_end(text.data), text.encoding, text.codec)


def _plain_head(source: LogFile) -> LogText | None:
    """Return the head of a large file if the fast reader can take the file as it is, else None."""
    if source.in_memory or source.size <= LARGE:
        return None
    head = to_text(source.whole_lines)
    tail = source.part(source.size - HEAD, source.size)
    if head.codec != "utf-8" or not head.encoding.startswith("utf-8") or b"\n" not in source.head[:HEAD]:
        return None
    if b"\x00" in source.head or not tail.endswith(b"\n") or one_line_end(source.head) is not source.head:
        return None
    return head


def must_be_held(source: LogFile) -> bool:
    """Return whether a text has to be held as a whole while it is read: no byte tells where its lines end."""
    head = source.head.removesuffix(b"\r")
    other_ends = b"\r" in head and (b"\n" not in head[:HEAD] or one_line_end(head) is not head)
    return other_ends or b"\x00" in head or to_text(source.whole_lines).encoding.startswith("utf-16")


def open_delimited(source: LogFile) -> Delimited | None:
    """Locate the table in a delimited text; None when there is none."""
    if source.size > LARGE and not any(end in source.head for end in (b"\n", b"\r")):
        return None  # one endless line
    held = source.size <= BLOCKS or must_be_held(source)
    plain = _plain_head(source) if held else to_text(source.whole_lines)
    whole = plain or _whole(source)
    text = plain or without_cut_cell(whole)
    head = text.data[:_LONG_HEAD].split(b"\n")
    if source.size > _LONG_HEAD:
        head = head[:-1]
    dialect = find_dialect(_sample_lines(source, text, head, plain is not None))
    if dialect is None:
        return None
    delimiter, decimal = dialect.delimiter, dialect.decimal
    rows: list[Row] = []
    layout = None
    for count in (LOOK, 4 * LOOK, 16 * LOOK, len(head)):
        rows += [split_line(text.decode(line), delimiter) for line in head[len(rows) : count]]
        layout = find_table(rows, decimal, dialect.width)
        # lines of the head may look like a table until one with as many cells as the rows comes
        met = layout is not None and abs(layout.width - dialect.width) <= 1
        if (met and layout is not None and layout.start < 0.8 * len(rows)) or count >= len(head):
            break
    if layout is None:
        return None
    offset = sum(len(line) + 1 for line in head[: layout.start])
    end = source.part(source.size - HEAD, source.size) if plain else text.data[-HEAD:]
    body = (text.data[offset : offset + HEAD], end)
    quoted = any(QUOTE in part for part in body)
    spaced = any(delimiter.encode() + b" " in part for part in body)
    sample = tuple(rows[layout.start :][:400])
    return Delimited(
        source,
        None if plain else text,
        text.codec,
        text.encoding,
        delimiter,
        decimal,
        layout,
        offset,
        sample,
        quoted,
        spaced,
        signs_per_line(head[layout.start :][:400], delimiter),
        text is not whole,
    )


def _sample_lines(source: LogFile, text: LogText, head: list[bytes], plain: bool) -> list[str]:
    """Return lines from the end of the head and from four places further on in the file."""
    chosen = head[-80:]
    size = source.size if plain else len(text.data)
    if size > _LONG_HEAD:
        for share in (0.3, 0.5, 0.75, 1.0):
            at = min(int(size * share), size - 1) - (1 << 14)
            part = source.part(at, at + (1 << 14)) if plain else text.data[at : at + (1 << 14)]
            chosen += part.split(b"\n")[1:-1][:20]
    return [text.decode(line) for line in chosen]


def without_cut_cell(text: LogText) -> LogText:
    """Remove the last cell, perhaps half-written, of a log whose last line breaks off; the row stays."""
    data = text.data
    if data.endswith((b"\n", b"\r")) or b"\n" not in data[-HEAD:]:
        return text
    lines = data[-HEAD:].split(b"\n")
    last, before = lines[-1], [line for line in lines[:-1] if line.strip(b" \r")][-3:]
    for delimiter in (b"\t", b";", b","):
        usual = {line.count(delimiter) for line in before}
        if len(usual) == 1 and min(usual) > 0:
            if last.count(delimiter) < min(usual) and delimiter in last:
                return LogText(data[: data.rindex(delimiter)], text.encoding, text.codec)
            break
    return text


_NO_WORDS = pd.Series([], dtype="str")


class Cells(NamedTuple):
    """A column as floats, and those of its cells that are neither a number nor a word for *missing*.

    ``ends``: its least and its greatest number, where every cell is a finite one and they are known.
    """

    values: np.ndarray
    words: pd.Series
    ends: Ends | None = None


def split_words(column: pd.Series, decimal: Decimal) -> Cells:
    """Part a column's numbers from its words."""
    if column.dtype.kind in "fiub":
        values = column.to_numpy(dtype=float)
        ends = ends_of(values)
        if ends is None and np.isinf(values).any():
            values = np.where(np.isinf(values), np.nan, values)
        return Cells(values, _NO_WORDS, ends)
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
