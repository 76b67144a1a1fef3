"""Shows what every column of a log holds, so that a person can tell which is which: its range and its course."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from atleak.common.damage import own_errors_only
from atleak.common.errors import RoadTestError
from atleak.common.thinning import thinned
from atleak.readers.logs.columns import find_candidates, match_heading
from atleak.readers.logs.delimited import numbers, open_delimited
from atleak.readers.logs.headings import Heading
from atleak.readers.logs.log_file import LogFile, open_source
from atleak.readers.logs.log_sheets import open_log_sheets
from atleak.readers.logs.log_table import LogTable
from atleak.readers.logs.mdf_log import mdf_columns
from atleak.readers.logs.parquet_log import open_parquet
from atleak.readers.logs.table_reader import long_columns, long_shape

_POINTS = 60  # of a small curve
_WORDS = 6  # different cells that are shown of a column of words


@dataclass(frozen=True)
class LogColumn:
    """A column of a log as a person tells it from the others, in the file's own unit."""

    label: str  # heading, or ``column 3``
    unit: str | None  # as the file states it
    quantity: str | None  # that its name stands for; None where the name says nothing
    numbers: int  # how many cells hold one
    least: float | None = None  # None where it holds no number
    largest: float | None = None  # likewise
    curve: tuple[float, ...] = ()  # its course
    words: tuple[str, ...] = ()  # some of its cells that are no numbers


@own_errors_only(RoadTestError, "name", "source")
def log_columns(source: str | Path | bytes, *, name: str | None = None) -> tuple[LogColumn, ...]:
    """Return every column of a log, in file order; none where no table of numbers is found in it.

    Parameters are those of `atleak.readers.logs.read_road_test`.

    Raises
    ------
    RoadTestError
        when the file is no log at all: empty, a picture, damaged.
    """
    opened = open_source(source, name)
    try:
        read = list(_read(opened))
        labels = Counter(heading.label for heading, *_ in read)
        return tuple(_column(*parts, labels[parts[0].label] > 1) for parts in read)
    finally:
        opened.close()


def _read(opened: LogFile) -> Iterator[tuple[Heading, np.ndarray, Iterable[str]]]:
    if opened.form == "mdf":
        for heading, values in mdf_columns(opened):
            yield heading, values, ()
        return
    tables: list[LogTable] = []
    if opened.form == "workbook":
        tables += open_log_sheets(opened)
    elif opened.form == "parquet":
        tables.append(open_parquet(opened))
    elif (text := open_delimited(opened)) is not None:
        tables.append(text)
    for table in tables:
        shape = long_shape(table, find_candidates(table.headings), {})
        if shape is not None:
            yield from long_columns(table, shape)
            continue
        headings = [heading for heading in table.headings if heading.index < table.width]
        frame = table.read([heading.index for heading in headings])
        for heading in headings:
            yield heading, *numbers(frame, heading.index, table.decimal)


def _column(heading: Heading, values: np.ndarray, words: Iterable[str], repeated: bool) -> LogColumn:
    label = heading.numbered if repeated else heading.label
    match = match_heading(heading)
    good = values[np.isfinite(values)]
    some = tuple(dict.fromkeys(str(word) for word in pd.Series(words, dtype=object).head(10_000)))[:_WORDS]
    unit, quantity = heading.unit or (match.unit if match else None), match.quantity if match else None
    if not len(good):
        return LogColumn(label, unit, quantity, 0, words=some)
    curve = tuple(good[thinned([good], _POINTS)].tolist())
    return LogColumn(label, unit, quantity, len(good), float(good.min()), float(good.max()), curve, some)
