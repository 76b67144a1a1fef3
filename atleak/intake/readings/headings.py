"""Which row holds the headings, and what each column is."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any

from atleak.intake.readings.head_labels import is_row_of_fields
from atleak.intake.readings.heading_numbers import is_explained, spot_of_heading, tokens_of
from atleak.intake.readings.one_heading import KEYS, LETTERED, Column, both_ends, read_heading, split_unit
from atleak.intake.readings.table import Table
from atleak.intake.readings.words import is_blank, number_of, part_of, side_of, text_of
from atleak.intake.sheets.sheet import Sheet
from atleak.sentence import Sentence

EXPECTED = Sentence(
    "one row of headings with at least: component (or 'No.'), part (spool or sleeve), plane (or land), and either "
    "diameter or coordinate x1 and coordinate x2; also read: direction, repeat, unit"
)

_DEPTH = 4  # rows that headings may be spread over


def _starts_table(table: Table) -> bool:
    """Return whether this can only be headings: two sizes, or a size beside what it is of."""
    sizes = [column for column in table.columns if column.holds_size and _is_named_size(column)]
    others = [column for column in table.columns if column.role == "quantity" and column.unit is not None]
    keys = {column.role for column in table.columns}.intersection(KEYS)
    several = len(table.values) > 1  # "spool" and "bore", or "0°" and "90°"
    return (len(sizes) or several) + bool(keys) > 1 or (bool(others or table.of_lands) and len(keys) > 1)


def _is_named_size(column: Column) -> bool:
    """Return whether a word of its own says a size, not only "spool" or "0°", which stand in readings too."""
    words = tokens_of(column.heading)
    named = words.any("of_size", "of_reading") or both_ends(set(words)) or column.role == "coordinate"
    return not column.holds_value or named or column.unit is not None or bool(column.standing)


def best_header(sheet: Sheet) -> Table | None:
    """Return the row (or up to three rows) that looks most like headings, or None where none does."""
    rows = (row for row in range(len(sheet.rows)) if _may_hold_headings(sheet, row))
    found = [header for row in rows for header in _headers_at(sheet, row) if header.score > 2.0]
    return max(found, key=lambda header: round(header.score, 9), default=None)


def find_headers(sheet: Sheet, is_component: Callable[[str], bool]) -> list[Table]:
    """Return the headings of every table, from top to bottom. ``is_component`` knows the cells of readings."""
    candidates = []
    for first in range(len(sheet.rows)):
        if not _may_hold_headings(sheet, first) or _names_component(sheet, first, is_component):
            continue
        decimals = _holds_decimals(sheet, first)
        if decimals and sum(isinstance(cell, str) and read_heading(cell) is not None for cell in sheet.rows[first]) < 3:
            continue
        for header in _headers_at(sheet, first):
            last = header.last
            if last > first and (
                decimals or _names_component(sheet, last, is_component) or _holds_decimals(sheet, last)
            ):
                break
            if last > first and is_row_of_fields(sheet.rows[first]):
                continue
            # a row that holds a number is taken only where its headings leave no doubt
            if _starts_table(header) and (not decimals or (header.complete and len(header.roles) > 2)):
                candidates.append(header)
    headers: list[Table] = []
    taken: set[int] = set()
    for header in sorted(candidates, key=lambda each: (-round(each.score + _depth_bonus(each), 9), each.first)):
        rows = range(header.first, header.last + 1)
        if taken.isdisjoint(rows):
            headers.append(header)
            taken.update(rows)
    return sorted(headers, key=lambda each: each.first)


def _depth_bonus(table: Table) -> float:
    """Score headings under headings higher: "nominal" and "actual" under "diameter" make no table of their own."""
    return sum(
        0.02
        for row in range(table.first + 1, table.last + 1)
        if any(
            isinstance(cell, str) and (column := read_heading(cell)) is not None and column.holds_size
            for cell in table.sheet.rows[row]
        )
    )


def _names_component(sheet: Sheet, row: int, is_component: Callable[[str], bool]) -> bool:
    return any(isinstance(cell, str) and cell and is_component(cell) for cell in sheet.rows[row])


def _holds_decimals(sheet: Sheet, row: int) -> bool:
    return any(
        _has_decimals(cell) if isinstance(cell, str) else isinstance(cell, float) and not cell.is_integer()
        for cell in sheet.rows[row]
    )


@lru_cache(maxsize=16384)
def _has_decimals(text: str) -> bool:
    return re.search(r"\d[.,]\d|^[.,]\d", text) is not None and number_of(text) is not None


def _may_hold_headings(sheet: Sheet, row: int) -> bool:
    """Return whether a row has two texts, or one over several columns; over the first column it is a title."""
    texts = [column for column, cell in enumerate(sheet.rows[row]) if isinstance(cell, str) and cell.strip()]
    if len(texts) != 1:
        return len(texts) > 1
    return texts[0] > 0 and sheet.merged.get((row, texts[0] + 1)) == (row, texts[0])


def _headers_at(sheet: Sheet, first: int) -> Iterator[Table]:
    for last in range(first, min(first + _DEPTH, len(sheet.rows))):
        if last > first and not any(not is_blank(cell) for cell in sheet.rows[last]):
            return
        headings = _headings(sheet, first, last)
        columns = [column for index, text in enumerate(headings) if (column := read_heading(text, index)) is not None]
        columns += _numbered(columns, headings)
        header = Table(sheet, first, last, read_together(columns), tuple(headings))
        if last > first and _is_data(header):
            return
        yield header


def _headings(sheet: Sheet, first: int, last: int) -> list[str]:
    """Return the text over every column: a heading over several columns counts for each of them, merged or not."""
    width = max(len(row) for row in sheet.rows[first : last + 1])
    levels = [[_said(sheet, row, column) for column in range(width)] for row in range(first, last + 1)]
    for depth, texts in enumerate(levels[:-1]):
        for column in range(1, width):
            if texts[column] or (first + depth, column) in sheet.merged:
                continue
            below = [level[column] for level in levels[depth + 1 :]]
            beside = [level[column - 1] for level in levels[depth + 1 :]]
            same_above = all(level[column] == level[column - 1] for level in levels[:depth])
            # below stand only a part, a place or a repeat, so that what they are of stands over them
            if any(below) and any(beside) and same_above and all(map(_is_under_another, filter(None, below))):
                texts[column] = texts[column - 1]
    return [" ".join(dict.fromkeys(text for text in texts if text)) for texts in zip(*levels, strict=True)]


def _said(sheet: Sheet, row: int, column: int) -> str:
    cell = sheet.filled(row, column)
    return str(cell).strip() if isinstance(cell, str) else text_of(cell)


@lru_cache(maxsize=4096)
def _is_under_another(text: str) -> bool:
    rest, _ = split_unit(text)
    words = tokens_of(rest)
    of_another = words.any("mean", "sum", "mean_in_heading", "of_specification", "of_reading")
    return of_another or is_explained(spot_of_heading(words)[1])


def _numbered(columns: Sequence[Column], headings: Sequence[str]) -> list[Column]:
    """Return columns headed 1, 2 … alone beside component and part, where no other holds a diameter."""
    roles = {column.role for column in columns}
    if not {"component", "part"} <= roles or any(column.holds_size for column in columns):
        return []
    numbered = [index for index, text in enumerate(headings) if re.fullmatch(r"[1-9]", text)]
    if len(numbered) < 2 or [headings[index] for index in numbered] != [str(at + 1) for at in range(len(numbered))]:
        return []
    return [
        Column(index, headings[index], "diameter", repeat=int(headings[index]), tentative=True, unsure=True)
        for index in numbered
    ]


def _is_data(header: Table) -> bool:
    """Return whether the last row taken for headings is a reading: it names a component of its own."""
    cell = header.sheet.cell
    return any(
        not is_blank(cell(header.last, column.index))
        and any(not is_blank(cell(above, column.index)) for above in range(header.first, header.last))
        for column in header.of("component")
    )


def read_together(columns: list[Column]) -> tuple[Column, ...]:
    """Correct what single headings say by what all columns say together.

    A direction or part in a value's heading holds only where no column of its own says it. "Spool" and "sleeve" are
    diameters where both stand there and nothing else is one.
    """
    roles = {column.role for column in columns}
    bare = [column for column in columns if column.role == "diameter" and part_of(column.heading) and not column.unit]
    others = any(column.holds_value and column not in bare for column in columns)
    if others or "part" in roles or len({column.part for column in bare}) < 2:
        columns = [column for column in columns if column not in bare]
    columns = _lettered(columns)
    if any(column.part == "spool" and side_of(column.heading) for column in columns):
        columns = [_as_inner(column) for column in columns]
    angles = {column.direction for column in columns if column.holds_value} - {None}
    # "x1" and "x2" without "y1" and "y2" are only the names of two coordinates
    only_names = len(angles) == 1 and any(re.search(r"\b[xy][12]\b", column.heading.lower()) for column in columns)
    said = {
        "direction": "direction" in roles or only_names,
        **{role: role in roles for role in ("part", "land", "plane")},
    }
    unsaid: dict[str, Any] = {name: None for name, elsewhere in said.items() if elsewhere}
    together = [replace(column, **unsaid) if column.holds_value and unsaid else column for column in columns]
    counted: dict[tuple[object, ...], set[int | None]] = defaultdict(set)
    for column in together:
        if column.holds_value:
            counted[column.station].add(column.repeat)
    # repeats count from 1, behind a word for them with one left out at most: 12 and 24 are something else
    gaps = {
        column.station
        for column in together
        if column.repeat is not None
        and (
            column.repeat > len(counted[column.station]) + tokens_of(column.heading).any("of_repeat")
            or {None, 1} <= counted[column.station]  # "measurement 1", "measurement 2", "result"
        )
    }
    return tuple(replace(column, repeat=None) if column.station in gaps else column for column in together)


def _lettered(columns: list[Column]) -> list[Column]:
    """Return diameters headed "dx" and "Dx" as of spool and bore, where both letters stand there."""
    letters = {
        column.index: match[1]
        for column in columns
        if column.holds_value and (match := LETTERED.search(column.heading))
    }
    if set(letters.values()) != {"d", "D"}:
        return columns
    return [
        replace(column, part=part_of(letters[column.index])) if column.index in letters and not column.part else column
        for column in columns
    ]


def _as_inner(column: Column) -> Column:
    """Return a column headed "ID" beside one headed "OD" as the bore's diameter."""
    if column.role != "component" or side_of(column.heading) != "sleeve":
        return column
    return replace(column, role="diameter", part="sleeve", rank=0, tentative=column.unit is None)
