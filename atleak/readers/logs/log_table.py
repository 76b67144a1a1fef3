"""Locates the table in a log: delimiter and decimal sign, the first data row, the rows above that name columns."""

from __future__ import annotations

import csv
import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import pandas as pd

from atleak.common.sentences import Sentence
from atleak.readers.cells.extent import cut
from atleak.readers.logs.headings import Heading, HeadRow, headings_of, names_columns, units_share
from atleak.readers.logs.log_cells import CellKind, Decimal, kind_of_cells, to_float, unit_in_cells

WHITESPACE = " "
_DELIMITERS = (",", ";", "\t", "|", WHITESPACE)
_DECIMALS: tuple[Decimal, ...] = (".", ",")
_COMMENTS = ("#", "%", "//", "'", "*")


@dataclass(frozen=True)
class Layout:
    """The place of the table: ``start`` is the index of the first data row among the rows looked at.

    ``cell_units`` are the units that stand in every cell of a column; ``above`` counts rows of another table above;
    ``note`` says what was known of the logger.
    """

    start: int
    width: int
    headings: tuple[Heading, ...]
    has_header: bool
    preamble: tuple[HeadRow, ...]
    header_rows: tuple[HeadRow, ...]
    cell_units: Mapping[int, str] = field(default_factory=dict)
    above: int = 0
    note: Sentence | None = None


class LogTable:
    """A table of any file format: its layout, some rows as a sample, how many there are, and columns on request."""

    layout: Layout
    sample: tuple[HeadRow, ...]
    decimal: Decimal
    rows: int  # more or less

    @property
    def headings(self) -> tuple[Heading, ...]:
        """Return the columns' headings."""
        return self.layout.headings

    @property
    def has_header(self) -> bool:
        """Return whether any row names the columns."""
        return self.layout.has_header

    @property
    def width(self) -> int:
        """Return the number of cells in a data row."""
        return self.layout.width

    def sampled(self, index: int) -> list[str]:
        """Return the cells of a column in the sample."""
        return [row[index] for row in self.sample if index < len(row)]

    def bytes_of_row(self, columns: Sequence[int]) -> float:
        """Return how many bytes these cells of a row take: eight as a number, as text by their length."""
        width = 0.0
        for cells in map(self.sampled, columns):
            texts = [cell for cell in cells if cell and math.isnan(to_float(cell, self.decimal))]
            width += 8 + (20 + sum(map(len, texts)) / len(texts) if 2 * len(texts) > len(cells) else 0)
        return width

    def read(self, columns: Sequence[int], every: int = 1) -> pd.DataFrame:
        """Read these columns from the first data row on: numbers as floats, anything else as text.

        Every line is a row, of which each ``every``-th is kept. Cells of a column of numbers that are none stand in
        ``attrs["words"]``. How many rows were left out, because they have more numbers than the table has columns,
        stands in ``attrs["too_wide"]``, how many have fewer cells in ``attrs["short"]``, and whether the last line
        breaks off in ``attrs["breaks_off"]``. Where not all are kept, their numbers stand in ``attrs["lines"]``.

        A `RoadTestError` refuses a damaged file, one whose lines cannot be told apart, and one of which many have more
        numbers than the table has columns.
        """
        raise NotImplementedError


def split_line(line: str, delimiter: str) -> HeadRow:
    """Return the cells of one line without the blanks and quotes around them."""
    if delimiter == WHITESPACE:
        return line.split()
    line = line.strip("\r\n")
    if '"' in line:
        try:
            cells = next(csv.reader([line], delimiter=delimiter, skipinitialspace=True, strict=True), [])
            return [cut(cell.strip()) for cell in cells]
        except csv.Error:  # a quotation mark that none closes on this line parts nothing
            line = line.replace('"', "")
    return [cut(cell.strip()) for cell in line.split(delimiter)]


@dataclass(frozen=True)
class Dialect:
    """Delimiter, decimal sign and the usual number of cells in a row."""

    delimiter: str
    decimal: Decimal
    width: int


def find_dialect(lines: Sequence[str]) -> Dialect | None:
    """Return the delimiter and decimal sign that together make most sense of these lines, or None.

    The last lines are also tried by themselves: a short log may have more lines above the table than rows.

    >>> find_dialect(["0;1,5;700", "0;1,75;800"])
    Dialect(delimiter=';', decimal=',', width=3)
    """
    lines = [line for line in lines if line.strip()]
    tries = [_scored_dialect(lines)]
    if len(lines) > 12:
        tries += [_scored_dialect(lines[-count:]) for count in (60, 12, 4) if count < len(lines)]
    dialects = [scored for scored in tries if scored is not None]
    best = max(dialects, key=lambda scored: scored[0], default=None)
    return best[1] if best is not None and best[0] >= 0.25 else None


def _scored_dialect(lines: Sequence[str]) -> tuple[float, Dialect] | None:
    """Return the dialect that makes most sense of these lines with its score, 0 to 1, or None."""
    present = [each for each in _DELIMITERS if each == WHITESPACE or any(each in line for line in lines)]
    scored = (dialect for delimiter in present for dialect in _dialects(lines, delimiter))
    return max(scored, key=lambda each: (each[0], each[1].width), default=None)


def _dialects(lines: Sequence[str], delimiter: str) -> Iterator[tuple[float, Dialect]]:
    """Yield the dialects of a delimiter with which these lines hold readings, each with its score."""
    rows = [split_line(line, delimiter) for line in lines]
    widths = Counter(len(row) for row in rows if len(row) > 1)
    if not widths:
        return
    width = _usual(widths)
    # a blank also stands between a date and its time of day: it must be clearly better than the others
    worth = 0.85 if delimiter == WHITESPACE else 1.0
    steady = sum(widths[near] for near in (width - 1, width, width + 1)) / len(rows)
    cells = [cell for row in rows if abs(len(row) - width) <= 1 for cell in row]
    for decimal in _DECIMALS:
        kinds = Counter(kind_of_cells(cell, decimal) for cell in cells)
        if kinds["number"] or kinds["clock"]:
            text = kinds["text"] / max(sum(map(bool, cells)), 1)
            yield round(worth * steady * (1 - text), 3), Dialect(delimiter, decimal, width)


def _usual(widths: Counter[int]) -> int:
    """Return the number of cells that most rows have, wide rows before narrow ones."""
    return max(widths, key=lambda cells: (widths[cells] * min(cells, 8), cells))


def _width(rows: Sequence[HeadRow], decimal: Decimal, wanted: int | None) -> int | None:
    """Return how many cells rows with readings have: as many as wanted, where any have."""
    several = (row for row in rows if len(row) > 1)
    widths = Counter(
        len(row) for row in several if any(kind_of_cells(cell, decimal) in ("number", "clock") for cell in row)
    )
    if wanted in widths:
        return wanted
    return _usual(widths) if widths else None


def find_table(rows: Sequence[HeadRow], decimal: Decimal, width: int | None = None) -> Layout | None:
    """Return the table among rows of cells: the longest block of data rows with the rows that name its columns."""
    width = _width(rows, decimal, width)
    if width is None:
        return None
    expected = _expected_kinds([row for row in rows if len(row) == width], width, decimal)
    flags = [_is_data(row, expected, width, decimal) for row in rows]
    start = _longest_block(rows, flags, width, decimal)
    if start is None:
        return None
    header, top = _rows_above(rows, start, width, decimal)
    # rows of numbers, as wide as the table, stand above it under a header of their own
    above = sum(flag and len(row) == width for row, flag in zip(rows[:top], flags, strict=False))
    preamble, above = tuple(rows[:top]), above if above >= _FEW else 0
    columns = ([row[index] for row in rows[start:] if index < len(row)] for index in range(width))
    cell_units = {index: unit for index, cells in enumerate(columns) if (unit := unit_in_cells(cells, decimal))}
    headings = tuple(
        replace(heading, unit=cell_units.get(heading.index, heading.unit)) for heading in headings_of(header, width)
    )
    return Layout(start, width, headings, names_columns(header), preamble, tuple(header), cell_units, above)


_FEW = 3  # lines with as many cells as the table above it, which are no other table


def _expected_kinds(rows: Sequence[HeadRow], width: int, decimal: Decimal) -> list[CellKind]:
    expected: list[CellKind] = []
    body = rows[len(rows) // 3 :] or rows
    for column in range(width):
        kinds = Counter(kind_of_cells(row[column], decimal) for row in body)
        del kinds["missing"]
        expected.append(kinds.most_common(1)[0][0] if kinds else "missing")
    return expected


def _is_data(row: HeadRow, expected: list[CellKind], width: int, decimal: Decimal) -> bool:
    if len(row) < 2 or len(row) < width // 2:
        return False
    good = bad = readable = 0
    for cell, expected_kind in zip(row, expected, strict=False):
        kind = kind_of_cells(cell, decimal)
        readable += kind in ("number", "clock")
        if expected_kind in ("number", "clock"):
            if kind == "text" or (kind == "clock" and expected_kind == "number"):
                bad += 1
            else:
                good += 1
    return readable > 0 and good > bad


def is_name_row(row: HeadRow, width: int, decimal: Decimal) -> bool:
    """Return whether a row can name columns (or their units): mostly text, wide enough."""
    filled = [cell for cell in row if cell]
    if len(row) < 2 or (width > 3 and len(row) < width / 2) or not filled:
        return False
    kinds = Counter(kind_of_cells(cell, decimal) for cell in filled)
    wordy = kinds["text"] + sum(1 for cell in filled if kind_of_cells(cell, decimal) == "missing" and len(cell) > 1)
    return kinds["number"] <= 0.3 * len(filled) and (wordy >= 0.4 * len(filled) or units_share(row) > 0.5)


def is_comment(row: HeadRow) -> bool:
    """Return whether a row is a blank line, a marker or a comment between data rows."""
    filled = [cell for cell in row if cell]
    return len(filled) <= 1 or row[0].startswith(_COMMENTS)


def _longest_block(rows: Sequence[HeadRow], flags: list[bool], width: int, decimal: Decimal) -> int | None:
    """Return the first row of the block with most data rows; comments and its own header repeated do not end it.

    Rows as wide as the table count before all others: lines of the head may hold numbers, too.
    """
    best, best_count = None, (0, 0)
    start, count, header, pending = None, (0, 0), None, None
    for index, row in enumerate(rows):
        if flags[index]:
            if pending is not None and pending != header:  # another table begins
                start, count, header = None, (0, 0), pending
            if start is None:
                start = index
            count = count[0] + (abs(len(row) - width) <= 1), count[1] + 1
            pending = None
            if count > best_count:
                best, best_count = start, count
        elif not is_comment(row) and is_name_row(row, width, decimal):
            if pending is None or row == header:
                pending = row
            if start is None:
                header = pending
    return best


def _rows_above(rows: Sequence[HeadRow], start: int, width: int, decimal: Decimal) -> tuple[list[HeadRow], int]:
    header_rows: list[HeadRow] = []
    index, skipped = start - 1, 0
    while index >= 0 and len(header_rows) < 4:
        row = rows[index]
        if is_name_row(row, width, decimal):
            header_rows.insert(0, _uncommented(row))
        elif header_rows or skipped >= 3 or len([cell for cell in row if cell]) > 1:
            break
        else:
            skipped += 1
        index -= 1
    return header_rows, index + 1


def _uncommented(row: HeadRow) -> HeadRow:
    first = row[0]
    if len(first) > 1 and first.startswith(_COMMENTS[:3]):
        first = first.lstrip("#%/ ")
    return [first, *row[1:]]
