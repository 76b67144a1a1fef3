"""Which lines are rows, and the numbers of a column; what cannot be read is refused, never guessed."""

from __future__ import annotations

import numpy as np
import pandas as pd

from atleak.errors import Place, RoadTestError
from atleak.intake.road_test.channels.assign import Assigner, Candidate, plain_name
from atleak.intake.road_test.channels.protocol import LogTable
from atleak.intake.road_test.files.cells import MISSING, Decimal, is_clock, is_destroyed
from atleak.intake.road_test.files.delimited import numbers, words_of
from atleak.intake.road_test.files.layout import Heading
from atleak.intake.road_test.names import words_as_numbers
from atleak.intake.road_test.names.matching import match_name, split_unit, words
from atleak.road_test import QUANTITIES


def without_other_lines(
    frame: pd.DataFrame, times: list[Candidate], channels: list[Candidate], table: LogTable, assigner: Assigner
) -> tuple[pd.DataFrame, int]:
    """Takes out comments, markers, repeated headers and blank lines; a different header refuses the file."""
    stored = {index: words_of(frame, index, table.decimal) for index in frame.attrs.get("words", {})}
    if frame.empty or (all(dtype.kind in "fiub" for dtype in frame.dtypes) and not any(map(len, stored.values()))):
        return _without_blank_rows(frame)
    telling = np.zeros(len(frame), bool)
    wordy = np.zeros(len(frame), bool)
    worded = []
    for index in frame.columns:
        if frame[index].dtype.kind in "fiub":
            telling |= frame[index].notna().to_numpy()
            if index in stored:
                wordy[stored[index].index] = True
        else:
            worded.append(index)
    # only rows without a single number so far need a closer look
    unclear = np.flatnonzero(~telling)
    clocks_at = {one.heading.index for one in times if holds_clocks(table, one.heading)}
    for index in worded if len(unclear) else ():
        column = frame[index].iloc[unclear]
        text = column.astype("str").str.strip()
        plain = text.str.replace(",", ".", regex=False) if table.decimal == "," else text
        readable = pd.to_numeric(plain, errors="coerce").notna()
        if index in clocks_at:
            readable |= text.str.contains(r"\d:\d", regex=True, na=False)
        known = column.notna().to_numpy()
        number = readable.to_numpy(dtype=bool) & known
        telling[unclear] |= number
        wordy[unclear] |= ~number & known
    text_only = (wordy & ~telling) | _words_for_time(frame, times, table)
    if text_only.any():
        lines = frame[text_only].astype(object)
        for index, cells in stored.items():
            lines[index] = lines[index].where(lines[index].notna(), cells.reindex(lines.index))
        _refuse_another_header(lines, times + channels, assigner)
        # rows that hold nothing but words where the table has numbers are markers
        attributes = frame.attrs
        frame = frame[~text_only]
        frame.attrs = attributes
        assigner.say("lines_left_out", f"{int(text_only.sum())} comment, marker or repeated header line(s) left out")
    return _without_blank_rows(frame)


def _without_blank_rows(frame: pd.DataFrame) -> tuple[pd.DataFrame, int]:
    """Without the rows in which nothing at all was read, where the table ends with such."""
    if frame.empty or not frame.iloc[-1].isna().all():
        return frame, len(frame)
    filled = frame.notna().any(axis=1).to_numpy()
    if not filled.any():  # the columns read are blank throughout, the rows are there all the same
        return frame, len(frame)
    end = len(filled) - int(np.argmax(filled[::-1]))
    attributes = frame.attrs
    frame = frame.iloc[:end]
    frame.attrs = attributes
    return frame, len(frame)


def _words_for_time(frame: pd.DataFrame, times: list[Candidate], table: LogTable) -> np.ndarray:
    """Lines that have a word where the time should be: keys and values of a header in the middle, remarks."""
    result = np.zeros(len(frame), bool)
    for one in times[:1]:
        column = frame[one.heading.index]
        if column.dtype.kind == "M" or column.dtype == object or holds_clocks(table, one.heading):
            continue
        strange = words_of(frame, one.heading.index, table.decimal)
        if len(strange) and len(strange) < 0.3 * len(column):
            result[strange.index] = True
    return result


def holds_clocks(table: LogTable, heading: Heading) -> bool:
    cells = [row[heading.index] for row in table.sample if heading.index < len(row)]
    return sum(is_clock(cell) for cell in cells) > 0.5 * len(cells)


def _refuse_another_header(lines: pd.DataFrame, used: list[Candidate], assigner: Assigner) -> None:
    headings = {one.heading.index: one.heading for one in used}
    indices = lines.columns.tolist()
    for row, cells in zip(lines.index.tolist(), lines.itertuples(index=False, name=None), strict=True):
        other = []
        for index, cell in zip(indices, cells, strict=True):
            heading = headings.get(int(index))
            if heading is None or not isinstance(cell, str) or not cell.strip() or cell.strip().lower() in MISSING:
                continue
            if cell.strip() == heading.label or plain_name(cell) in [words(name) for name in heading.names]:
                continue
            if match_name(split_unit(cell).text) is not None:
                other.append((cell.strip(), heading.label))
        if len(other) >= 2 or (other and len(lines.columns) == 1):
            raise RoadTestError(
                "another header with other columns begins in the middle of the log",
                place=Place(file=assigner.file, row=None, column=other[0][1]),
                value=other[0][0],
                expected=f"one header; split the file at data row {int(row) + 1}",
            )


def column_numbers(one: Candidate, frame: pd.DataFrame, decimal: Decimal, assigner: Assigner) -> np.ndarray:
    column = frame[one.heading.index]
    values, strange = numbers(frame, one.heading.index, decimal)
    if not len(strange):
        return _without_thousands(one, values, assigner)
    if one.quantity in ("gear", "selector", "lock_up"):
        if one.quantity == "gear" and np.isnan(values).all() and words_as_numbers.only_positions(strange):
            assigner.say("gear_is_selector", f"{one.label!r} holds selector positions, no gears", "info", one.label)
            return np.full(len(values), np.nan)
        values = values.copy()
        values[column.index.get_indexer(strange.index)] = words_as_numbers.as_numbers(one.quantity, strange)
        return values
    destroyed = next((text for text in strange.head(50) if is_destroyed(text)), None)
    if destroyed is not None or len(strange) > 0.02 * len(values):
        shown = destroyed or strange.iloc[0]
        what = "numbers a spreadsheet has destroyed" if destroyed else "text instead of numbers"
        assigner.say("column_refused", f"{one.label!r} holds {what} ({shown}): it is not used", "warning", one.label)
        return np.full(len(values), np.nan)
    assigner.say(
        "cells_unreadable",
        f"{one.label!r}: {len(strange)} cell(s) are no numbers ({strange.iloc[0]}) and left out",
        "warning",
        one.label,
    )
    return values


def _without_thousands(one: Candidate, values: np.ndarray, assigner: Assigner) -> np.ndarray:
    """Refuses a column in which 1.250 stands for 1250: whole numbers beside small ones with three decimals."""
    if QUANTITIES[one.quantity].unit_kind != "rotational_speed" or not len(values):
        return values
    part = values[:: max(1, len(values) // 50_000)]
    small = part[(part >= 1) & (part < 16) & (part != np.round(part))]
    whole = part[part == np.round(part)]
    if len(small) < 3 or np.abs(small * 1000 - np.round(small * 1000)).max() > 1e-6:
        return values
    if len(whole) and np.median(whole) > 100 and len(small) + len(whole) + np.isnan(part).sum() == len(part):
        text = f"{one.label!r} mixes numbers such as {small[0]:.3f} and {whole[0]:.0f}: the sign in it parts thousands"
        assigner.say("column_refused", text + "; it is not used", "warning", one.label)
        return np.full(len(values), np.nan)
    return values
