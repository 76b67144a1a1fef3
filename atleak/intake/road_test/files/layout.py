"""Locates the table in a log: delimiter and decimal sign, the first data row, the rows above that name columns."""

from __future__ import annotations

import csv
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from atleak.intake.road_test.files.cells import CellKind, Decimal, is_clock, kind_of
from atleak.intake.road_test.names.matching import clean_unit, is_unit, match_name, split_unit
from atleak.intake.sheets.extent import cut

Row = list[str]
WHITESPACE = " "
_COMMENTS = ("#", "%", "//", "'", "*")


@dataclass(frozen=True)
class Heading:
    """A column as the rows above the data describe it.

    ``label`` is the name as written (the caller maps by it), ``names`` every name that may tell the quantity,
    the most telling first, without unit; ``unit`` the unit's text or None.
    """

    index: int
    label: str
    names: tuple[str, ...]
    unit: str | None


@dataclass(frozen=True)
class Layout:
    """The place of the table: ``start`` is the index of the first data row among the rows looked at."""

    start: int
    width: int
    headings: tuple[Heading, ...]
    has_header: bool
    preamble: tuple[Row, ...]
    header_rows: tuple[Row, ...]


def split_line(line: str, delimiter: str) -> Row:
    """Return the cells of one line without the blanks and quotes around them."""
    if delimiter == WHITESPACE:
        return line.split()
    if '"' in line:
        quoted = line.strip("\r\n").replace("\r", " ")  # a lone carriage return is no end of line to us
        cells = next(csv.reader([quoted], delimiter=delimiter, skipinitialspace=True), [])
        return [cut(cell.strip()) for cell in cells]
    return [cut(cell.strip()) for cell in line.strip("\r\n").split(delimiter)]


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
        tries += [_scored_dialect(lines[-count:]) for count in (60, 12) if count < len(lines)]
    dialects = [scored for scored in tries if scored is not None]
    best = max(dialects, key=lambda scored: scored[0], default=None)
    return best[1] if best is not None and best[0] >= 0.25 else None


def _scored_dialect(lines: Sequence[str]) -> tuple[float, Dialect] | None:
    """Return the dialect that makes most sense of these lines with its score, 0 to 1, or None."""
    best_score: tuple[float, int] = (0.0, 0)
    best_dialect: Dialect | None = None
    for delimiter in (",", ";", "\t", "|", WHITESPACE):
        rows = [split_line(line, delimiter) for line in lines]
        widths = Counter(len(row) for row in rows if len(row) > 1)
        if not widths:
            continue
        width = max(widths, key=lambda cells: (widths[cells] * min(cells, 8), cells))
        steady = sum(count for cells, count in widths.items() if abs(cells - width) <= 1) / len(rows)
        body = [row for row in rows if abs(len(row) - width) <= 1]
        for decimal in (".", ","):
            kinds = Counter(kind_of(cell, decimal) for row in body for cell in row)
            filled = sum(kinds.values()) - sum(1 for row in body for cell in row if not cell)
            telling = kinds["number"] + kinds["clock"]
            if not telling:
                continue
            text = kinds["text"] / max(filled, 1)
            # a blank also stands between a date and its time of day: it must be clearly better than the others
            worth = 0.85 if delimiter == WHITESPACE else 1.0
            score = (round(worth * steady * (1 - text), 3), width)
            if score > best_score:
                best_score, best_dialect = score, Dialect(delimiter, decimal, width)
    return (best_score[0], best_dialect) if best_dialect is not None else None


def find_table(rows: Sequence[Row], decimal: Decimal, width: int | None = None) -> Layout | None:
    """Return the table among rows of cells: the longest block of data rows with the rows that name its columns."""
    widths = Counter(len(row) for row in rows if _has_number(row, decimal) and len(row) > 1)
    if not widths:
        return None
    if width is None or width not in widths:
        width = max(widths, key=lambda cells: (widths[cells] * min(cells, 8), cells))
    expected = _expected_kinds([row for row in rows if len(row) == width], width, decimal)
    flags = [_is_data(row, expected, width, decimal) for row in rows]
    start = _longest_block(rows, flags, width, decimal)
    if start is None:
        return None
    header, top = _rows_above(rows, start, width, decimal)
    defined = defined_channels(rows[:start], width)
    if defined is not None:
        return Layout(start, width, defined, True, tuple(rows[:top]), ())
    headings = _headings(header, width)
    return Layout(start, width, headings, bool(header), tuple(rows[:top]), tuple(header))


# raw whole numbers by the channel's type; pressures are absolute, their zero on the gauge is 1013
_TYPE_UNITS = {
    "enginespeed": "rpm",
    "temperature": "0.1 K",
    "pressure": "0.1 kPa abs",
    "abspressure": "0.1 kPa abs",
    "speed": "0.1 km/h",
    "gear": "gear",
}


def defined_channels(rows: Sequence[Row], width: int) -> tuple[Heading, ...] | None:
    """Return the channels defined in blocks ``Channel : …``, ``ID : …``, ``Type : …`` above data without names.

    The first column of the data is the clock, the others follow the order of the blocks.
    """
    channels: list[list[str]] = []
    for row in rows:
        key, _, value = ",".join(row).partition(":")
        key = key.strip().lower()
        if key == "channel" and value.strip():
            channels.append([value.strip(), ""])
        elif key == "type" and channels:
            channels[-1][1] = value.strip()
    if not channels or abs(len(channels) + 1 - width) > 1:
        return None
    headings = [Heading(0, "time of day", ("time",), None)]
    for index, (name, kind) in enumerate(channels, start=1):
        unit = _TYPE_UNITS.get(kind.lower(), kind or None)
        headings.append(Heading(index, name, (name,), unit))
    return tuple(headings)


def _has_number(row: Row, decimal: Decimal) -> bool:
    return any(kind_of(cell, decimal) in ("number", "clock") for cell in row)


def _expected_kinds(rows: Sequence[Row], width: int, decimal: Decimal) -> list[CellKind]:
    expected: list[CellKind] = []
    body = rows[len(rows) // 3 :] or rows
    for column in range(width):
        kinds = Counter(kind_of(row[column], decimal) for row in body)
        del kinds["missing"]
        expected.append(kinds.most_common(1)[0][0] if kinds else "missing")
    return expected


def _is_data(row: Row, expected: list[CellKind], width: int, decimal: Decimal) -> bool:
    if len(row) < 2 or len(row) < width // 2:
        return False
    good = bad = readable = 0
    for cell, expected_kind in zip(row, expected, strict=False):
        kind = kind_of(cell, decimal)
        readable += kind in ("number", "clock")
        if expected_kind in ("number", "clock"):
            if kind == "text" or (kind == "clock" and expected_kind == "number"):
                bad += 1
            else:
                good += 1
    return readable > 0 and good > bad


def is_name_row(row: Row, width: int, decimal: Decimal) -> bool:
    """Return whether a row can name columns (or their units): mostly text, wide enough."""
    filled = [cell for cell in row if cell]
    if len(row) < 2 or (width > 3 and len(row) < width / 2) or not filled:
        return False
    kinds = Counter(kind_of(cell, decimal) for cell in filled)
    wordy = kinds["text"] + sum(1 for cell in filled if kind_of(cell, decimal) == "missing" and len(cell) > 1)
    return kinds["number"] <= 0.3 * len(filled) and (wordy >= 0.4 * len(filled) or _units_share(row) > 0.5)


def is_comment(row: Row) -> bool:
    """Return whether a row is a blank line, a marker or a comment between data rows."""
    filled = [cell for cell in row if cell]
    return len(filled) <= 1 or row[0].startswith(_COMMENTS)


def _longest_block(rows: Sequence[Row], flags: list[bool], width: int, decimal: Decimal) -> int | None:
    """Return the first row of the block with most data rows; comments and its own header repeated do not end it."""
    best, best_count = None, 0
    start, count, header, pending = None, 0, None, None
    for index, row in enumerate(rows):
        if flags[index]:
            if pending is not None and pending != header:  # another table begins
                start, count, header = None, 0, pending
            if start is None:
                start = index
            count += 1
            pending = None
            if count > best_count:
                best, best_count = start, count
        elif not is_comment(row) and is_name_row(row, width, decimal):
            if pending is None:
                pending = row
            if start is None:
                header = pending
    return best


def _rows_above(rows: Sequence[Row], start: int, width: int, decimal: Decimal) -> tuple[list[Row], int]:
    header_rows: list[Row] = []
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


def _uncommented(row: Row) -> Row:
    first = row[0]
    if len(first) > 1 and first.startswith(_COMMENTS[:3]):
        first = first.lstrip("#%/ ")
    return [first, *row[1:]]


def _units_share(row: Row) -> float:
    filled = [cell for cell in row if cell.strip() and cell.strip() != "-"]
    if not filled:
        return 0.0
    return sum(is_unit(cell) for cell in filled) / len(filled)


def _known_names(row: Row) -> int:
    return sum(match_name(split_unit(cell).text) is not None for cell in row if cell)


def _headings(header: list[Row], width: int) -> tuple[Heading, ...]:
    units: Row = []
    names = list(header)
    if len(header) > 1:
        shares = [(_units_share(row), index) for index, row in enumerate(header)]
        share, place = max(shares)
        others = [row for index, row in enumerate(header) if index != place]
        if share >= 0.5 and (place > 0 or max(map(_known_names, others)) >= _known_names(header[0])):
            units, names = header[place], others
    # a row of descriptions shifted against the data says nothing about columns
    straight = [row for row in names if abs(_filled_width(row) - width) <= 1]
    names = straight or names
    names = sorted(names, key=_known_names, reverse=True)
    columns = max([width, *(_filled_width(row) for row in names)])
    headings = []
    for index in range(columns):
        written = [row[index] for row in names if index < len(row) and row[index]]
        split = [split_unit(name) for name in written]
        unit = next((part.unit for part in split if part.unit is not None), None)
        if unit is None and index < len(units) and clean_unit(units[index]):
            unit = clean_unit(units[index])
        label = written[0].replace("\ufeff", "").strip() if written else f"column {index + 1}"
        label = split[0].text if label.count("|") >= 2 else label
        headings.append(Heading(index, label, tuple(dict.fromkeys(part.text for part in split)), unit))
    return tuple(headings)


def _filled_width(row: Row) -> int:
    """Return the number of cells up to the last one that is not blank."""
    return max((index + 1 for index, cell in enumerate(row) if cell), default=0)


def named_by_a_date(heading: Heading) -> bool:
    """Return whether a column's header is itself a date, which one app writes above its clock."""
    return bool(heading.names) and is_clock(heading.names[0])
