"""Where on a sheet tables of gauge readings stand, and what their columns are."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from atleak.intake.gauge_table.words import Heading, Said, Words, is_blank, label_and_value
from atleak.intake.sheets.extent import TABLES
from atleak.intake.sheets.sheet import Cell, Sheet
from atleak.intake.units import find_unit

_LOOKED_AT = 30  # rows below the headings in which a column without a heading may show what it is
_TITLES = 8  # rows above the headings that may speak of the table


@dataclass(frozen=True)
class Head:
    """What stands above the headings: what all readings have in common, their unit and the fluid's temperature."""

    said: Said = Said()  # noqa: RUF009  frozen, so safe to share
    unit: tuple[str, int, int] | None = None  # text, row, column
    temperature: tuple[Cell, int, int] | None = None


@dataclass(frozen=True)
class GaugeTable:
    """One table: the row of its headings, its columns, and the rows below."""

    sheet: Sheet
    row: int  # of the headings
    last: int  # row
    headings: Mapping[int, Heading]  # by column
    head: Head = field(default_factory=Head)

    def column(self, kind: str) -> int | None:
        """Return the column of that kind; None where there is none."""
        return next((column for column, heading in self.headings.items() if heading.kind == kind), None)

    @property
    def rows(self) -> range:
        """Return the rows below the headings."""
        return range(self.row + 1, self.last + 1)

    @property
    def values(self) -> list[int]:
        """Return the columns of readings."""
        return [column for column, heading in self.headings.items() if heading.kind == "value"]

    def said(self, column: int) -> Said:
        """Return what heading and title say of the readings in a column."""
        return self.headings[column].said.over(self.head.said)


def find_gauge_tables(sheet: Sheet, words: Words) -> list[GaugeTable]:
    """Return the tables of gauge readings on a sheet: headings that give range, engine and pressure of each reading."""
    texts = {cell for row in sheet.rows for cell in row if isinstance(cell, str)}
    if not any((heading := words.heading(text)).said.engine or heading.kind == "engine" for text in texts):
        return []  # as on every sheet of diameters
    found: list[tuple[int, Mapping[int, Heading], Head]] = []
    free = 0  # first row that may stand above the next headings
    for row in range(len(sheet.rows)):
        headings = _headings(sheet, row, words)
        if not any(heading.kind == "value" for heading in headings.values()):
            continue
        head = _head(sheet, range(max(free, row - _TITLES), row), words)
        complete = _complete(sheet, row, _with_row_above(sheet, row, free, headings, words), head, words)
        if len(found) == TABLES:
            break
        if complete is not None:
            found.append((row, complete, head))
            free = row + 1
    ends = [_before_titles(sheet, row) for row, _, _ in found[1:]] + [len(sheet.rows) - 1]
    return [
        GaugeTable(sheet, row, end, headings, head) for (row, headings, head), end in zip(found, ends, strict=False)
    ]


def likeness(sheet: Sheet, words: Words) -> float:
    """Return how much of a sheet's headings is understood as those of gauge readings; 0 where there are none."""
    tables = find_gauge_tables(sheet, words)
    return float(max((sum(each.kind is not None for each in table.headings.values()) for table in tables), default=0))


def _before_titles(sheet: Sheet, row: int) -> int:
    """Return the last row above some headings that is no title of theirs: titles fill one cell."""
    above = row - 1
    while above > 0 and 0 < sum(not is_blank(cell) for cell in sheet.rows[above]) <= 1:
        above -= 1
    return above


def _headings(sheet: Sheet, row: int, words: Words) -> dict[int, Heading]:
    cells = ((column, sheet.filled(row, column)) for column in range(sheet.width))
    return {
        column: words.heading(cell)
        for column, cell in cells
        if isinstance(cell, str | int | float) and str(cell).strip()
    }


def _with_row_above(
    sheet: Sheet, row: int, free: int, headings: dict[int, Heading], words: Words
) -> dict[int, Heading]:
    """Return the headings with what stands over them in the row above, as in "stall" merged over P, R, N, D."""
    if row - 1 < free:
        return headings
    above = _headings(sheet, row - 1, words)
    if len(above) < 2:
        return headings  # one cell is a title
    joined = {}
    for column, heading in headings.items():
        upper = above.get(column)
        if heading.kind == "value" and upper is not None and upper.kind == "value":
            heading = replace(heading, said=heading.said.over(upper.said), unit=heading.unit or upper.unit)
        joined[column] = heading
    return joined


def _complete(
    sheet: Sheet, row: int, headings: dict[int, Heading], head: Head, words: Words
) -> dict[int, Heading] | None:
    """Return the headings where every reading gets a range and a state of the engine; None where one does not.

    A column without a heading that is understood may be the one that says it. Where neither a unit nor a word for
    pressure stands over the readings, their headings must be more than numbers, and the columns that say range and
    engine must hold such words: in a list of valves, one named "throttle" heads nothing.
    """
    values = [heading for heading in headings.values() if heading.kind == "value"]
    kinds = {heading.kind for heading in headings.values()}
    of_pressures = (head.unit is not None and find_unit(str(head.unit[0]), "pressure") is not None) or any(
        heading.unit or heading.wrong_unit or not heading.said.anything for heading in values
    )
    labelled = of_pressures
    if not of_pressures and all(heading.text.isdigit() for heading in values):
        return None
    for kind in ("range", "engine", "tap"):
        stated = [getattr(heading.said, kind) is not None for heading in values]
        if any(stated) and not all(stated):
            return None
        if kind in kinds and (of_pressures or kind == "tap"):
            continue
        if kind not in kinds and (all(stated) or getattr(head.said, kind) is not None):
            continue
        column = _column_that_says(sheet, row, headings, kind, words)
        if column is not None:
            text = headings[column].text if column in headings else ""
            headings, labelled = {**headings, column: Heading(text, kind)}, True
        elif kind != "tap":
            return None
    return headings if labelled else None


def _column_that_says(sheet: Sheet, row: int, headings: Mapping[int, Heading], kind: str, words: Words) -> int | None:
    """Return the first column, headed so or not understood, whose cells all say what is looked for."""
    rows = range(row + 1, min(row + 1 + _LOOKED_AT, len(sheet.rows)))
    for column in range(sheet.width):
        if column in headings and headings[column].kind not in (None, kind):
            continue
        said = [words.said_by(cell, kind) is not None for at in rows if not is_blank(cell := sheet.filled(at, column))]
        if said and said[0] and sum(said) * 2 > len(said):
            return column
    return None


def _head(sheet: Sheet, rows: Sequence[int], words: Words) -> Head:
    head = Head()
    for row in rows:
        filled = [(column, cell) for column, cell in enumerate(sheet.rows[row]) if not is_blank(cell)]
        for column, cell in filled:
            if not isinstance(cell, str):
                continue
            for kind in ("unit", "temperature"):
                value = _beside(sheet, row, column, label_and_value(cell, kind))
                if value is not None:
                    head = replace(head, unit=value) if kind == "unit" else replace(head, temperature=value)
        if len(filled) == 1 and isinstance(filled[0][1], str):
            head = replace(head, said=words.title(filled[0][1]).over(head.said))
    return head


def _beside(sheet: Sheet, row: int, column: int, told: str | None) -> tuple[Any, int, int] | None:
    """Return the value of a label with its place: behind it in the same cell, or in one of the next two."""
    if told:
        return told, row, column
    if told is None:
        return None
    places = ((sheet.cell(row, at), row, at) for at in (column + 1, column + 2))
    return next((place for place in places if not is_blank(place[0])), None)
