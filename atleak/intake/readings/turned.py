"""A sheet whose headings run down its first column → the same with rows and columns exchanged."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import zip_longest

from atleak.intake.readings.controller_names import ControllerNames
from atleak.intake.readings.labels import read_label
from atleak.intake.readings.one_heading import Role, read_heading
from atleak.intake.readings.sizes import numbers_of
from atleak.intake.readings.words import is_blank, text_of
from atleak.intake.sheets.sheet import Cell, Sheet
from atleak.intake.workbook_marks import Marks

_MOST_CELLS = 200_000  # of a sheet that is turned; a measuring sheet has a hundredth of them
_KEYS: tuple[Role, ...] = ("component", "part", "plane", "land", "direction")
_HEADINGS = {"component": "Component", "part": "Part", "land": "Land", "plane": "Plane", "direction": "Direction"}


def turned(sheet: Sheet, names: ControllerNames) -> Sheet | None:
    """Return the sheet with rows and columns exchanged; None where it is too large for a measuring sheet.

    Where the cells beside a label name components or parts, and the label does not, it is headed so. An empty cell
    behind such a name goes on with it if a further name under it says of what: a heading over several columns.
    """
    if sheet.width * len(sheet.rows) > _MOST_CELLS:
        return None
    rows = [list(cells) for cells in zip_longest(*sheet.rows, fillvalue="")]
    merged = {(column, row): (left, top) for (row, column), (top, left) in sheet.merged.items()}
    marks = Marks(
        hidden_rows=dict.fromkeys(sheet.marks.hidden_columns, "by hand"),
        hidden_columns=frozenset(sheet.marks.hidden_rows),
        struck=frozenset((column, row) for row, column in sheet.marks.struck),
        colours={(column, row): colour for (row, column), colour in sheet.marks.colours.items()},
        comments={(column, row): words for (row, column), words in sheet.marks.comments.items()},
    )
    faults = {(column, row): why for (row, column), why in sheet.faults.items()}
    around = replace(sheet, rows=rows, merged=merged, faults=faults, marks=marks, turned=not sheet.turned)
    first = next((row for row, cells in enumerate(rows) if any(isinstance(cell, str) and cell for cell in cells)), None)
    return around if first is None else _headed(around, first, names)


def _headed(sheet: Sheet, first: int, names: ControllerNames) -> Sheet:
    """Return the turned sheet with headings in row ``first`` for keys that have none, and keys spread over theirs."""
    headings = list(sheet.rows[first])
    rows: list[list[Cell]] = [*map(list, sheet.rows[:first]), headings, *map(list, sheet.rows[first + 1 :])]
    keys: list[int] = []
    titles: dict[int, str] = {}
    named = False
    for column, heading in enumerate(headings):
        said = read_heading(text_of(heading)) if isinstance(heading, str) and heading else None
        below = [cell for row in range(first + 1, len(sheet.rows)) if not is_blank(cell := sheet.cell(row, column))]
        if not below and isinstance(heading, str) and (component := names.component_in(heading)) is not None:
            titles[column] = component
        if not below:
            headings[column] = heading if numbers_of(heading) else ""  # a title or a note beside nothing
            continue
        kind = _kind(below, names)
        if kind is not None and (said is None or said.role != kind):
            headings[column] = _HEADINGS[kind]
        if kind is not None or (said is not None and said.role in _KEYS):
            keys.append(column)
            named = named or kind == "component" or (said is not None and said.role == "component")
    empty = (row for row in range(first + 1, len(rows)) if all(map(is_blank, rows[row])))
    end = next(empty, len(rows))
    for column, component in () if named else titles.items():  # "Valve: accumulator" over its own rows
        headings[column] = _HEADINGS["component"]
        for cells in rows[first + 1 : end]:
            cells[column] = component
    return replace(sheet, rows=rows, merged={**sheet.merged, **_spread(sheet, first, keys)})


def _kind(cells: Sequence[Cell], names: ControllerNames) -> str | None:
    """Return what all cells name and name alone: components, parts, lands, planes or directions."""
    texts = [cell for cell in cells if isinstance(cell, str)]
    if not texts or len(texts) < len(cells):
        return None
    kinds: set[str] = set()
    for text in dict.fromkeys(texts):
        label = read_label(text, names)
        kinds |= set() if label is None else set(label.said) - {"unit"}
        if label is None or len(kinds) != 1:
            return None
    kind = kinds.pop()
    return kind if kind in _HEADINGS else None


def _spread(sheet: Sheet, first: int, keys: Sequence[int]) -> dict[tuple[int, int], tuple[int, int]]:
    """Return which empty cells of a key go on with the one before: those beside a further key of their own."""
    spread: dict[tuple[int, int], tuple[int, int]] = {}
    for at, column in enumerate(keys[:-1]):
        for row in range(first + 2, len(sheet.rows)):
            if not is_blank(sheet.filled(row, column)) or is_blank(sheet.filled(row - 1, column)):
                continue
            inner = any(not is_blank(sheet.cell(row, other)) for other in keys[at + 1 :])
            outer = any(not is_blank(sheet.cell(row, other)) for other in keys[:at])
            if inner and not outer:
                spread[row, column] = spread.get((row - 1, column), (row - 1, column))
                sheet = replace(sheet, merged={**sheet.merged, (row, column): spread[row, column]})
    return spread
