"""Which lines are rows, and the numbers of a column; what cannot be read is refused, never guessed."""

from __future__ import annotations

import numpy as np
import pandas as pd

from atleak.errors import Place, RoadTestError
from atleak.intake.road_test import words_as_numbers
from atleak.intake.road_test.assign import Assigner, Candidate, plain_name
from atleak.intake.road_test.cells import MISSING, Decimal, is_clock, is_destroyed
from atleak.intake.road_test.delimited import numbers
from atleak.intake.road_test.names import match_name, split_unit, words
from atleak.intake.road_test.protocol import Table
from atleak.intake.road_test.table import Heading
from atleak.road_test import QUANTITIES


def without_other_lines(
    frame: pd.DataFrame, times: list[Candidate], channels: list[Candidate], table: Table, assigner: Assigner
) -> tuple[pd.DataFrame, int]:
    """Takes out comments, markers, repeated headers and blank lines; a different header refuses the file."""
    if frame.empty or all(dtype.kind in "fiub" for dtype in frame.dtypes):
        if not frame.empty and frame.iloc[-1].isna().all():
            blank = frame.isna().all(axis=1).to_numpy()
            tail = len(frame) - int(np.argmax(~blank[::-1])) if not blank.all() else 0
            frame = frame.iloc[:tail]
        return frame, len(frame)
    telling = np.zeros(len(frame), bool)
    worded = []
    for index in frame.columns:
        if frame[index].dtype.kind in "fiub":
            telling |= frame[index].notna().to_numpy()
        else:
            worded.append(index)
    # only rows without a single number so far need a closer look
    unclear = np.flatnonzero(~telling)
    wordy = np.zeros(len(frame), bool)
    clocks_at = {one.heading.index for one in times if holds_clocks(table, one.heading)}
    for index in worded if len(unclear) else ():
        column = frame[index].iloc[unclear]
        text = column.astype("str").str.strip()
        plain = text.str.replace(",", ".", regex=False) if table.decimal == "," else text
        number = pd.to_numeric(plain, errors="coerce").notna()
        if index in clocks_at:
            number |= text.str.contains(r"\d:\d", regex=True, na=False)
        known = column.notna().to_numpy()
        number = number.to_numpy(dtype=bool) & known
        telling[unclear] |= number
        wordy[unclear] |= ~number & known
    text_only = (wordy & ~telling) | _words_for_time(frame, times, table)
    if text_only.any():
        _refuse_another_header(frame[text_only], times + channels, assigner)
        # rows that hold nothing but words where the table has numbers are markers
        frame = frame[~text_only]
        assigner.say("lines_left_out", f"{int(text_only.sum())} comment, marker or repeated header line(s) left out")
    blank = frame.isna().all(axis=1).to_numpy()
    if blank.any():
        frame = frame[~blank]
    return frame, len(frame)


def _words_for_time(frame: pd.DataFrame, times: list[Candidate], table: Table) -> np.ndarray:
    """Lines that have a word where the time should be: keys and values of a header in the middle, remarks."""
    result = np.zeros(len(frame), bool)
    for one in times[:1]:
        column = frame[one.heading.index]
        if column.dtype.kind in "fiubM" or column.dtype == object or holds_clocks(table, one.heading):
            continue
        values, strange = numbers(column, table.decimal)
        if strange and strange < 0.3 * len(values):
            text = column.astype("str").str.strip().str.lower()
            result |= np.isnan(values) & column.notna().to_numpy() & ~text.isin(MISSING).to_numpy()
    return result


def holds_clocks(table: Table, heading: Heading) -> bool:
    cells = [row[heading.index] for row in table.sample if heading.index < len(row)]
    return sum(is_clock(cell) for cell in cells) > 0.5 * len(cells)


def _refuse_another_header(lines: pd.DataFrame, used: list[Candidate], assigner: Assigner) -> None:
    headings = {one.heading.index: one.heading for one in used}
    for row, cells in lines.iterrows():
        other = []
        for index, cell in cells.items():
            heading = headings.get(int(index))  # type: ignore[arg-type]
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
                expected=f"one header; split the file at data row {int(row) + 1}",  # type: ignore[call-overload]
            )


def column_numbers(one: Candidate, frame: pd.DataFrame, decimal: Decimal, assigner: Assigner) -> np.ndarray:
    column = frame[one.heading.index]
    values, strange = numbers(column, decimal)
    if not strange:
        return _without_thousands(one, values, assigner)
    texts = column.dropna().astype("str")
    if one.quantity in ("gear", "selector", "lock_up"):
        if one.quantity == "gear" and words_as_numbers.only_positions(column):
            assigner.say("gear_is_selector", f"{one.label!r} holds selector positions, no gears", "info", one.label)
            return np.full(len(values), np.nan)
        worded = words_as_numbers.as_numbers(one.quantity, column)
        return np.where(np.isnan(values), worded, values)
    bad = texts[pd.to_numeric(texts.str.replace(",", ".", regex=False), errors="coerce").isna()]
    bad = bad[~bad.str.strip().str.lower().isin(MISSING)]
    destroyed = next((text for text in bad.head(50) if is_destroyed(text)), None)
    if destroyed is not None or strange > 0.02 * len(values):
        shown = destroyed or (bad.iloc[0] if len(bad) else "")
        what = "numbers a spreadsheet has destroyed" if destroyed else "text instead of numbers"
        assigner.say("column_refused", f"{one.label!r} holds {what} ({shown}): it is not used", "warning", one.label)
        return np.full(len(values), np.nan)
    assigner.say(
        "cells_unreadable",
        f"{one.label!r}: {strange} cell(s) are no numbers ({bad.iloc[0] if len(bad) else ''}) and left out",
        "warning",
        one.label,
    )
    return values


def _without_thousands(one: Candidate, values: np.ndarray, assigner: Assigner) -> np.ndarray:
    """Refuses a column in which 1.250 stands for 1250: whole numbers up to 999 beside small ones with three decimals."""
    if QUANTITIES[one.quantity].unit_kind != "rotational_speed" or not len(values):
        return values
    part = values[:: max(1, len(values) // 50_000)]
    small = part[(part >= 1) & (part < 16) & (part != np.round(part))]
    whole = part[part == np.round(part)]
    if len(small) < 3 or np.abs(small * 1000 - np.round(small * 1000)).max() > 1e-6:
        return values
    if len(whole) and np.median(whole) > 100 and len(small) + len(whole) + np.isnan(part).sum() == len(part):
        text = f"{one.label!r} mixes numbers such as {small[0]:.3f} and {whole[0]:.0f}: a thousands sign was taken for a decimal sign"
        assigner.say("column_refused", text + "; it is not used", "warning", one.label)
        return np.full(len(values), np.nan)
    return values
