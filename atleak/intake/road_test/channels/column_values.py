"""Decides which lines are rows and reads a column's numbers; a column that cannot be read is refused, never guessed."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pandas as pd

from atleak.intake.road_test.blocks import each
from atleak.intake.road_test.channels.assign import Assigner, Candidate
from atleak.intake.road_test.channels.headers_between import refuse_another_header
from atleak.intake.road_test.channels.protocol import LogTable
from atleak.intake.road_test.channels.spoilt_numbers import cause, holds, quoted
from atleak.intake.road_test.files.cells import OFF, Decimal, is_clock, is_destroyed
from atleak.intake.road_test.files.delimited import Cells, numbers, words_of
from atleak.intake.road_test.files.headings import Heading
from atleak.intake.road_test.names import words_as_numbers
from atleak.road_test import QUANTITIES
from atleak.sentence import Sentence


class Rows(NamedTuple):
    """The rows of a table, and how many of its lines are none."""

    frame: pd.DataFrame
    left_out: int

    @property
    def number(self) -> int:
        """Return how many rows there are."""
        return len(self.frame)


def rows_of(
    frame: pd.DataFrame, times: list[Candidate], channels: list[Candidate], table: LogTable, assigner: Assigner
) -> Rows:
    """Leave out comments, markers, repeated headers and blank rows at the end, each counted in a message.

    Raises
    ------
    RoadTestError
        where another header with other columns begins.
    """
    too_wide = say_left_out(frame, table, assigner)
    frame, words_alone = _without_words(frame, times, channels, table, assigner)
    attributes, end = frame.attrs, _end(frame)
    blank = len(frame) - end
    if blank:
        frame = frame.iloc[:end]
        frame.attrs = attributes
        assigner.say("blank_rows", Sentence("{count} blank row(s) at the end left out", count=blank))
    return Rows(frame, too_wide + words_alone + blank)


def say_left_out(frame: pd.DataFrame, table: LogTable, assigner: Assigner) -> int:
    """Say how many rows were left out when the file was read, also of another table above this one; return it."""
    if table.above:
        text = Sentence("{count} row(s) of another table above this one are not read", count=table.above)
        assigner.say("table_above", text, "warning")
    too_wide = int(frame.attrs.get("too_wide", 0))
    if too_wide:
        text = Sentence(
            "{count} row(s) have more numbers than there are columns: which belongs to which is not known, they are "
            "left out",
            count=too_wide,
        )
        assigner.say("rows_too_wide", text, "warning")
    if short := int(frame.attrs.get("short", 0)):
        text = Sentence(
            "{count} row(s) have fewer cells than the others: what they lack is taken as blank", count=short
        )
        assigner.say("rows_short", text)
    if frame.attrs.get("breaks_off"):
        text = Sentence("the last line breaks off: its last value, perhaps half-written, is left out")
        assigner.say("line_breaks_off", text)
    return too_wide + table.above


def _without_words(
    frame: pd.DataFrame, times: list[Candidate], channels: list[Candidate], table: LogTable, assigner: Assigner
) -> tuple[pd.DataFrame, int]:
    """Remove comments, markers, repeated headers and blank lines; refuse a file in which another header begins."""
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
    text_only = (has_word & ~has_number) | _words_for_time(frame, times, table)
    count = int(text_only.sum())
    if count:
        lines = frame[text_only].astype(object)
        for index, cells in words_in_columns.items():
            lines[index] = lines[index].where(lines[index].notna(), cells.reindex(lines.index))
        refuse_another_header(lines, times + channels, assigner)
        # rows that hold nothing but words where the table has numbers are markers
        attributes = frame.attrs
        frame = frame[~text_only]
        frame.attrs = attributes
        said = Sentence("{count} comment, marker or repeated header line(s) left out", count=count)
        assigner.say("lines_left_out", said)
    return frame, count


def _end(frame: pd.DataFrame) -> int:
    """Return the number of rows up to the last one that is not blank."""
    if frame.empty or not frame.iloc[-1].isna().all():
        return len(frame)
    filled = frame.notna().any(axis=1).to_numpy()
    if not filled.any():  # the columns are blank throughout, but the rows exist
        return len(frame)
    return len(filled) - int(np.argmax(filled[::-1]))


def _words_for_time(frame: pd.DataFrame, times: list[Candidate], table: LogTable) -> np.ndarray:
    """Mark lines with a word in place of the time: remarks, or a header in the middle of the log."""
    result = np.zeros(len(frame), bool)
    for candidate in times[:1]:
        column = frame[candidate.heading.index]
        if column.dtype.kind == "M" or column.dtype == object or holds_clocks(table, candidate.heading):
            continue
        unreadable = words_of(frame, candidate.heading.index, table.decimal)
        if len(unreadable) and len(unreadable) < 0.3 * len(column):
            result[unreadable.index] = True
    return result


def holds_clocks(table: LogTable, heading: Heading) -> bool:
    """Return whether most cells of a column are clock readings."""
    cells = [row[heading.index] for row in table.sample if heading.index < len(row)]
    return sum(is_clock(cell) for cell in cells) > 0.5 * len(cells)


def columns_of_numbers(
    channels: list[Candidate], frame: pd.DataFrame, decimal: Decimal, assigner: Assigner
) -> dict[int, np.ndarray]:
    """Return each channel's numbers by its column, NaN where there is none.

    A column that cannot be read is NaN throughout.
    """

    def cells(channel: Candidate) -> Cells:
        return numbers(frame, channel.heading.index, decimal)

    plain = all(dtype.kind == "f" for dtype in frame.dtypes)  # text takes much memory: one column at a time
    read = each(cells, channels, len(frame) if plain else 0)
    return {
        channel.heading.index: _column_numbers(channel, found, frame.index, decimal, assigner)
        for channel, found in zip(channels, read, strict=True)
    }


def _column_numbers(
    candidate: Candidate, cells: Cells, index: pd.Index, decimal: Decimal, assigner: Assigner
) -> np.ndarray:
    values, unreadable, ends = cells
    if len(unreadable) and candidate.quantity != "lock_up":  # of a switch it is a value
        unreadable = unreadable[unreadable.str.lower() != OFF]
    if not len(unreadable):
        if ends is not None:
            assigner.ends[candidate.heading.index] = ends
        return _without_thousands(candidate, values, assigner)
    if candidate.quantity in ("gear", "selector", "lock_up"):
        if candidate.quantity == "gear" and np.isnan(values).all() and words_as_numbers.only_positions(unreadable):
            said = Sentence("{column!r} holds selector positions, no gears", column=candidate.label)
            assigner.say("gear_is_selector", said, "info", candidate.label)
            return np.full(len(values), np.nan)
        values = values.copy()
        in_words = words_as_numbers.as_numbers(candidate.quantity, unreadable)
        values[index.get_indexer(unreadable.index)] = in_words
        drive = unreadable[np.isnan(in_words)]
        if candidate.quantity == "gear" and len(drive) and words_as_numbers.only_positions(drive):
            said = Sentence(
                "{column!r}: {words} names no gear, so it is not known at {count} of {total} samples",
                column=candidate.label,
                words=tuple(sorted({str(word).strip() for word in drive})),
                count=len(drive),
                total=len(values),
            )
            assigner.say("gear_not_named", said, "info", candidate.label)
        return values
    if len(unreadable) > 0.02 * len(values) or any(map(is_destroyed, unreadable.head(50))):
        what, found = cause(unreadable, values, decimal)
        assigner.refuse(candidate, "column_refused", holds(candidate.label, what, found))
        return np.full(len(values), np.nan)
    said = Sentence(
        "{column!r}: {count} cell(s) are no numbers ({found}) and left out",
        column=candidate.label,
        count=len(unreadable),
        found=quoted(unreadable.iloc[0]),
    )
    assigner.say("cells_unreadable", said, "warning", candidate.label)
    return values


def _without_thousands(candidate: Candidate, values: np.ndarray, assigner: Assigner) -> np.ndarray:
    """Refuse a column in which 1.250 means 1250: whole numbers beside small ones with three decimals."""
    kind = QUANTITIES[candidate.quantity].unit_kind
    if kind not in ("rotational_speed", "pressure") or not len(values):
        return values
    sample = values[:: max(1, len(values) // 50_000)]
    small = sample[(sample >= 1) & (sample < 16) & (sample != np.round(sample))]
    whole = sample[sample == np.round(sample)]
    if len(small) < 3 or np.abs(small * 1000 - np.round(small * 1000)).max() > 1e-6:
        return values
    if (
        kind == "pressure" and np.abs(small * 10 - np.round(small * 10)).max() < 1e-6
    ):  # such as 1.5 kPa of a pump at rest
        return values
    if len(whole) and np.median(whole) > 100 and len(small) + len(whole) + np.isnan(sample).sum() == len(sample):
        text = Sentence(
            "{column!r} mixes numbers such as {small} and {whole}: the sign in it parts thousands; it is not used",
            column=candidate.label,
            small=f"{small[0]:.3f}",
            whole=f"{whole[0]:.0f}",
        )
        assigner.refuse(candidate, "column_refused", text)
        return np.full(len(values), np.nan)
    return values
