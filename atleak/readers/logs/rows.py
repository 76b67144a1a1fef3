"""Decides which lines are rows and reads a column's numbers; a column that cannot be read is refused, never guessed.

A log in the middle of which another header, or another row of units, begins is refused: its columns change meaning. A
unit that only one of two headers states is asked about.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pandas as pd

from atleak.common.errors import MessageLevel, RoadTestError
from atleak.common.sentences import Sentence
from atleak.measurements.road_test import QUANTITIES
from atleak.readers.dates import words
from atleak.readers.logs import names as words_as_numbers
from atleak.readers.logs.columns import Assigner, Candidate
from atleak.readers.logs.delimited import numbers, words_of
from atleak.readers.logs.headings import Heading
from atleak.readers.logs.log_cells import HOLDS, MISSING, OFF, Decimal, cause, is_clock, is_destroyed, quoted
from atleak.readers.logs.log_table import LogTable
from atleak.readers.logs.names import is_unit, match_name, split_unit
from atleak.readers.logs.units import same_unit


class _Cell(NamedTuple):
    """A word in a line that is no row, and the column in which it stands."""

    column: Candidate
    text: str

    @property
    def repeats(self) -> bool:
        """Return whether it is the column's own name, with any unit."""
        heading = self.column.heading
        return self.text == heading.label or words(split_unit(self.text).text) in map(words, heading.names)


def refuse_another_header(lines: pd.DataFrame, used: list[Candidate], assigner: Assigner) -> None:
    """Refuse a log with a header among its rows that names other columns, or the same ones in other units.

    Each of the lines bears its number in the file as label.
    """
    columns = {candidate.heading.index: candidate for candidate in used}
    indices = [int(index) for index in lines.columns]
    for row, values in zip(lines.index.tolist(), lines.itertuples(index=False, name=None), strict=True):
        cells = [
            _Cell(columns[index], value.strip())
            for index, value in zip(indices, values, strict=True)
            if index in columns and isinstance(value, str) and value.strip().lower() not in MISSING
        ]
        others = _others(cells, alone=len(indices) == 1)
        if cells and all(is_unit(cell.text) for cell in cells):  # a column may be called rpm
            for cell in cells:
                _refuse_another_unit(cell, cell.text, int(row), assigner)
        elif others:
            problem = Sentence("another header with other columns begins in the middle of the log")
            expected = Sentence("one header; split the file at data row {row}", row=int(row) + 1)
            raise assigner.error(problem, others[0].text, expected, others[0].column.label)
        else:
            _compare_units([cell for cell in cells if cell.repeats], int(row), assigner)


def _compare_units(repeated: list[_Cell], row: int, assigner: Assigner) -> None:
    """Refuse another unit in the names that a line repeats; ask about one that a whole header leaves out."""
    for cell in repeated:
        unit, stated = split_unit(cell.text).unit, cell.column.unit
        if unit is not None and cell.text != cell.column.label:
            _refuse_another_unit(cell, unit, row, assigner)
        elif unit is None and len(repeated) >= 2 and stated and cell.column.quantity not in assigner.units:
            problem = Sentence("its unit ({unit}) is not stated again from data row {row} on", row=row + 1, unit=stated)
            raise _asked(problem, cell, stated, row, assigner)


def _others(cells: list[_Cell], alone: bool) -> list[_Cell]:
    """Return the cells of a line that name other columns; none where the line is a remark.

    One is enough where the rest of the line is the header; a name that nobody knows counts beside two of the header's.
    """
    repeated = sum(cell.repeats for cell in cells)
    odd = [cell for cell in cells if not cell.repeats]
    named = [cell for cell in odd if match_name(split_unit(cell.text).text) is not None]
    if len(named) >= 2 or (named and (alone or (repeated and len(named) == len(odd)))):
        return named
    return odd if repeated >= 2 and repeated > len(odd) else []


def _refuse_another_unit(cell: _Cell, unit: str, row: int, assigner: Assigner) -> None:
    quantity = cell.column.quantity
    stated, kind = cell.column.unit or assigner.units.get(quantity), QUANTITIES[quantity].unit_kind
    if kind is not None and stated is None:
        problem = Sentence("its unit is stated from data row {row} on only ({unit})", row=row + 1, unit=unit)
        raise _asked(problem, cell, unit, row, assigner)
    if kind is None or stated is None or same_unit(stated, unit, kind):
        return
    problem = Sentence("the unit changes from {first} to {other} in the middle of the log", first=stated, other=unit)
    expected = Sentence("one unit in every column; split the file at data row {row}", row=row + 1)
    raise assigner.error(problem, cell.text, expected, cell.column.label)


def _asked(problem: Sentence, cell: _Cell, unit: str, row: int, assigner: Assigner) -> RoadTestError:
    """Return the error that asks for the unit of the rows for which none is stated."""
    expected = Sentence("the unit of all rows, such as {quantity} = {unit!r}; or the file split at data row {row}")
    expected = expected.of(quantity=cell.column.quantity, unit=unit, row=row + 1)
    return assigner.error(problem, cell.text, expected, cell.column.label)


@dataclass
class LeftOutRow:
    """What of a table's lines is no row, and what else was met in reading them."""

    above: int = 0  # rows of another table above
    too_wide: int = 0  # rows with more numbers than columns
    short: int = 0  # rows with fewer cells, which are taken
    breaks_off: bool = False  # whether the last line does
    lines: int = 0  # comments, markers and repeated headers
    blank: int = 0  # at the end

    @classmethod
    def of(cls, frame: pd.DataFrame, table: LogTable) -> LeftOutRow:
        """Return what was met when the file was read."""
        too_wide, short = (int(frame.attrs.get(name, 0)) for name in ("too_wide", "short"))
        return cls(table.layout.above, too_wide, short, bool(frame.attrs.get("breaks_off")))

    @property
    def rows(self) -> int:
        """Return how many lines were left out."""
        return self.above + self.too_wide + self.lines + self.blank

    def say(self, assigner: Assigner) -> None:
        """Say how many rows were left out, and why."""
        for name, (level, code, text) in _LEFT_OUT.items():
            if count := getattr(self, name):
                assigner.say(code, text, level, count=count)


_LEFT_OUT: Mapping[str, tuple[MessageLevel, str, Sentence]] = {  # by the field of `LeftOutRow` that counts it
    "above": ("warning", "table_above", Sentence("{count} row(s) of another table above this one are not read")),
    "too_wide": ("warning", "rows_too_wide", Sentence(
        "{count} row(s) have more numbers than there are columns: which belongs to which is not known, they are left "
        "out"
    )),
    "short": ("info", "rows_short", Sentence(
        "{count} row(s) have fewer cells than the others: what they lack is taken as blank"
    )),
    "breaks_off": ("info", "line_breaks_off", Sentence(
        "the last line breaks off: its last value, perhaps half-written, is left out"
    )),
    "lines": ("info", "lines_left_out", Sentence("{count} comment, marker or repeated header line(s) left out")),
    "blank": ("info", "blank_rows", Sentence("{count} blank row(s) at the end left out")),
}  # fmt: skip


class LogRows(NamedTuple):
    """The rows of a table, and how many of its lines are none."""

    frame: pd.DataFrame
    left_out: int

    @property
    def number(self) -> int:
        """Return how many rows there are."""
        return len(self.frame)

    @property
    def places(self) -> np.ndarray:
        """Return how many rows of the file stand before each, be they read or not."""
        return lines_of(self.frame) - (self.frame.index.to_numpy() - np.arange(self.number))


def lines_of(frame: pd.DataFrame) -> np.ndarray:
    """Return the number in the file of each line, of which not every one need have been read."""
    labels = frame.index.to_numpy()
    return frame.attrs["lines"][labels] if "lines" in frame.attrs else labels


def rows_of_log(
    frame: pd.DataFrame, times: list[Candidate], channels: list[Candidate], table: LogTable, assigner: Assigner
) -> LogRows:
    """Leave out comments, markers, repeated headers and blank rows at the end, each counted in a message."""
    left, word_for_time = LeftOutRow.of(frame, table), _words_for_time(frame, times, table)
    if len(word_for_time) >= _REMARKS * len(frame):
        word_for_time = word_for_time[:0]
    frame, left.lines = _without_words(frame, times, channels, table, assigner, word_for_time)
    if len(frame) and frame.iloc[-1].isna().all():
        filled = np.flatnonzero(frame.notna().any(axis=1))
        end = int(filled[-1]) + 1 if len(filled) else len(frame)  # blank throughout, but the rows exist
        left.blank = len(frame) - end
        attributes, frame = frame.attrs, frame.iloc[:end]
        frame.attrs = attributes
    left.say(assigner)
    return LogRows(frame, left.rows)


_REMARKS = 0.3  # part of a log's lines that may have a word in place of the time: more are no remarks


def _without_words(
    frame: pd.DataFrame, times: list[Candidate], channels: list[Candidate], table: LogTable, assigner: Assigner,
    word_for_time: np.ndarray,
) -> tuple[pd.DataFrame, int]:  # fmt: skip
    """Remove comments, markers, repeated headers and blank lines; return the rest, and how many there were.

    Lines with a word in place of the time (``word_for_time``) are markers, too.
    """
    words_in_columns = {index: words_of(frame, index, table.decimal) for index in frame.attrs.get("words", {})}
    if frame.empty or (
        all(dtype.kind in "fiub" for dtype in frame.dtypes) and not any(map(len, words_in_columns.values()))
    ):
        return frame, 0
    has_number = np.zeros(len(frame), bool)
    has_word = np.zeros(len(frame), bool)
    text_columns = []
    for index in frame.columns:
        if frame[index].dtype.kind in "fiub":
            has_number |= frame[index].notna().to_numpy()
            if index in words_in_columns:
                has_word[words_in_columns[index].index] = True
        else:
            text_columns.append(index)
    # only rows without a single number so far need a closer look
    without_number = np.flatnonzero(~has_number)
    clocks_at = {candidate.heading.index for candidate in times if holds_clocks(table, candidate.heading)}
    for index in text_columns if len(without_number) else ():
        column = frame[index].iloc[without_number]
        text = column.astype("str").str.strip()
        plain = text.str.replace(",", ".", regex=False) if table.decimal == "," else text
        readable = pd.to_numeric(plain, errors="coerce").notna()
        if index in clocks_at:
            readable |= text.str.contains(r"\d:\d", regex=True, na=False)
        filled = column.notna().to_numpy()
        number = readable.to_numpy(dtype=bool) & filled
        has_number[without_number] |= number
        has_word[without_number] |= ~number & filled
    text_only = has_word & ~has_number
    text_only[word_for_time] = True
    count = int(text_only.sum())
    if count:
        lines = frame[text_only].astype(object)
        for index, cells in words_in_columns.items():
            lines[index] = lines[index].where(lines[index].notna(), cells.reindex(lines.index))
        refuse_another_header(lines.set_axis(lines_of(lines)), times + channels, assigner)
        # rows that hold nothing but words where the table has numbers are markers
        attributes = frame.attrs
        frame = frame[~text_only]
        frame.attrs = attributes
    return frame, count


def _words_for_time(frame: pd.DataFrame, times: list[Candidate], table: LogTable) -> np.ndarray:
    """Return the lines with a word in place of the time: remarks, or a header in the middle of the log."""
    if not times:
        return np.empty(0, int)
    column = frame[times[0].heading.index]
    # before its version 3 pandas keeps text as objects, too
    objects = column.dtype == object and pd.api.types.infer_dtype(column) != "string"
    if column.dtype.kind == "M" or objects or holds_clocks(table, times[0].heading):
        return np.empty(0, int)
    return words_of(frame, times[0].heading.index, table.decimal).index.to_numpy()


def holds_clocks(table: LogTable, heading: Heading, most: float = 0.5) -> bool:
    """Return whether most cells of a column are clock readings."""
    cells = table.sampled(heading.index)
    return sum(map(is_clock, cells)) > most * len(cells)


def columns_of_numbers(
    channels: list[Candidate], frame: pd.DataFrame, decimal: Decimal, assigner: Assigner
) -> dict[int, np.ndarray]:
    """Return each channel's numbers by its column, NaN where there is none.

    A column that cannot be read is NaN throughout.
    """
    columns = {}
    for channel in channels:
        index = channel.heading.index
        values, words = numbers(frame, index, decimal)
        if len(words) and channel.quantity != "lock_up":  # of a switch it is a value
            words = words[words.str.lower() != OFF]
        if not len(words):
            usable = _without_thousands(channel, values, assigner)
        elif channel.quantity in ("gear", "selector", "lock_up"):
            in_words = words_as_numbers.as_numbers(channel.quantity, words)
            usable = channel.quantity != "gear" or _names_gears(channel, values, words, in_words, assigner)
            values = values.copy()
            values[frame.index.get_indexer(words.index)] = in_words
        else:
            usable = _numbers_but_for_few(channel, values, words, decimal, assigner)
        columns[index] = values if usable else np.full(len(values), np.nan)
    return columns


_FEW_WORDS = 0.02  # part of a column's cells that may be no numbers


def _numbers_but_for_few(
    candidate: Candidate, values: np.ndarray, words: pd.Series, decimal: Decimal, assigner: Assigner
) -> bool:
    """Tell whether few cells of a column are no numbers, and say how many."""
    if len(words) > _FEW_WORDS * len(values) or any(is_destroyed(str(cell)) for cell in words.head(50)):
        what, example = cause(words, values[:: max(1, len(values) // 50_000)], decimal)
        assigner.refuse(candidate, "column_refused", HOLDS, what=what, found=example)
        return False
    text = Sentence("{column!r}: {count} cell(s) are no numbers ({found}) and left out")
    assigner.say("cells_unreadable", text, "warning", candidate.label, count=len(words), found=quoted(words.iloc[0]))
    return True


def _names_gears(
    candidate: Candidate, values: np.ndarray, words: pd.Series, in_words: np.ndarray, assigner: Assigner
) -> bool:
    """Tell whether the numbers and words of a column name gears, and which words do not."""
    if np.isnan(values).all() and words_as_numbers.only_positions(words):
        text = Sentence("{column!r} holds selector positions, no gears")
        assigner.say("gear_is_selector", text, "info", candidate.label)
        return False
    unnamed = words[np.isnan(in_words)].astype("str").str.strip()
    if words_as_numbers.only_positions(unnamed):
        text = Sentence("{column!r}: {words} names no gear, so it is not known at {count} of {total} samples")
        text = text.of(
            column=candidate.label, words=tuple(sorted(unnamed.unique())), count=len(unnamed), total=len(values)
        )
        assigner.say("gear_not_named", text, "info", candidate.label)
    return True


def _without_thousands(candidate: Candidate, values: np.ndarray, assigner: Assigner) -> bool:
    """Refuse a column in which 1.250 means 1250: whole numbers beside small ones with three decimals."""
    kind = QUANTITIES[candidate.quantity].unit_kind
    if kind not in ("rotational_speed", "pressure") or not len(values):
        return True
    sample = values[:: max(1, len(values) // 50_000)]
    small = sample[(sample >= 1) & (sample < 16) & (sample != np.round(sample))]
    whole = sample[sample == np.round(sample)]
    if len(small) < 3 or np.abs(small * 1000 - np.round(small * 1000)).max() > 1e-6:
        return True
    # such as 1.5 kPa of a pump at rest
    if kind == "pressure" and np.abs(small * 10 - np.round(small * 10)).max() < 1e-6:
        return True
    if len(whole) and np.median(whole) > 100 and len(small) + len(whole) + np.isnan(sample).sum() == len(sample):
        text = Sentence(
            "{column!r} mixes numbers such as {small} and {whole}: the sign in it parts thousands; it is not used"
        )
        assigner.refuse(candidate, "column_refused", text, small=f"{small[0]:.3f}", whole=f"{whole[0]:.0f}")
        return False
    return True
