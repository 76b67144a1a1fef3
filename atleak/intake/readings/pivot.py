"""A pivot table of a spreadsheet program → the usual headings, and every label in every row."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import pairwise

from atleak.intake.readings.controller_names import ControllerNames
from atleak.intake.readings.labels import Label, read_label
from atleak.intake.readings.one_heading import read_heading, split_unit
from atleak.intake.readings.words import letters, summary_of, text_of, vocabulary
from atleak.intake.sheets.sheet import Cell, Sheet

_MEASURE = re.compile(r"(?P<how>[^\W\d_]+)(?:\s+(?:of|von|z|de|di|du|по полю|по))?\s+(?P<what>\S.*)", re.IGNORECASE)
_AXIS = vocabulary("pivot_axis")
_COLUMNS = ("component", "part", "land", "plane", "number", "direction", "repeat")
_HEADINGS = {"component": "Component", "part": "Part", "number": "Plane", "direction": "Direction", "repeat": "Repeat"}
_COMPUTED = {"mean": "Average", "sum": "Total", "largest": "Max", "smallest": "Min"}


def without_pivot(sheet: Sheet, names: ControllerNames) -> Sheet:
    """Return the sheet with the headings and labels of its pivot table written out; the sheet itself where it has none.

    The table is known by "Average of Diameter [mm]", or a sum, largest or smallest of diameters, over its corner.
    """
    for row, cells in enumerate(sheet.rows):
        for column, cell in enumerate(cells):
            measure = _measured(cell)
            if measure is not None:
                return _written_out(sheet, (row, column), measure, names)
    return sheet


def _measured(cell: Cell) -> tuple[str, str] | None:
    """Return what a pivot table computes and the heading of its diameters, None where this is no such corner."""
    match = _MEASURE.fullmatch(cell.strip()) if isinstance(cell, str) and cell else None
    computed = _COMPUTED.get(summary_of(match["how"]) or "") if match else None
    if match is None or computed is None:
        return None
    heading = read_heading(match["what"])
    return (computed, match["what"]) if heading is not None and heading.role == "diameter" else None


def _written_out(sheet: Sheet, corner: tuple[int, int], measure: tuple[str, str], names: ControllerNames) -> Sheet:
    top, left = corner
    rows = [[*cells, *[""] * (sheet.width - len(cells))] for cells in sheet.rows]
    last = next((row for row in range(top + 1, min(top + 4, len(rows))) if text_of(rows[row][left])), None)
    across = next((column for column in range(left + 1, sheet.width) if text_of(rows[top][column])), None)
    if last is None or across is None:  # nothing over the columns: a list with one heading more
        return sheet
    computed, heading = measure
    field = text_of(rows[top][across])
    rows[top][left] = ""
    for column in range(across, sheet.width):
        items = [text_of(rows[row][column]) for row in range(top + 1, last + 1)]
        rows[top][column] = heading if any(items) else ""
        rows[last][column] = _item(field, text_of(rows[last][column]))
    end = next((row for row in range(last + 1, len(rows)) if not any(map(text_of, rows[row]))), len(rows))
    body = range(last + 1, end)
    for row in body:
        if _is_total(rows[row][left]):
            rows[row][left] = f"{computed} ({text_of(rows[row][left])})"
    written = replace(sheet, rows=rows)
    if any(word in _AXIS for word in letters(rows[last][left])):
        return _in_columns(written, last, left, body, computed, names)
    _fill(rows, range(left, across), body, computed)
    return written


def _is_total(cell: Cell) -> bool:
    return isinstance(cell, str) and summary_of(cell, key=True) is not None


def _item(field: str, item: str) -> str:
    """Return the heading of one item: "0" under "Direction" is 0°, "1" under "Land" is land 1."""
    if not item.isdigit() or any(word in _AXIS for word in letters(field)):
        return item
    heading = read_heading(field)
    if heading is not None and heading.role == "direction":
        return f"{item}°"
    return f"{split_unit(field)[0]} {item}"


def _fill(rows: list[list[Cell]], keys: range, body: range, computed: str) -> None:
    """Write the labels that stand in the first row of their group into its other rows; mark rows of subtotals."""
    inner = keys[-1]
    subtotals = [row for row, after in pairwise(body) if not text_of(rows[row][inner]) and text_of(rows[after][inner])]
    for row in body[1:]:
        first = next((at for at in keys if text_of(rows[row][at])), keys.start)
        for column in range(keys.start, first):
            rows[row][column] = rows[row - 1][column]
    for row in subtotals:
        rows[row][inner] = computed


def _in_columns(sheet: Sheet, last: int, left: int, body: range, computed: str, names: ControllerNames) -> Sheet:
    """Return the sheet with the labels of the compact form, all in one column, in a column for each kind."""
    labels = list(_labels([sheet.cell(row, left) for row in body], computed, names))
    if len(labels) < len(body):
        return sheet
    said = {name for label in labels for name in label.said}
    kinds = [kind for kind in _COLUMNS if kind in said]
    width = sheet.width
    rows = [[*cells, *[""] * len(kinds)] for cells in sheet.rows]
    rows[last][left] = ""
    rows[last][width:] = [_HEADINGS.get(kind, kind.capitalize()) for kind in kinds]
    for row, label in zip(body, labels, strict=True):
        rows[row][width:] = [label.said.get(kind, "") for kind in kinds]
    return replace(sheet, rows=rows, derived={width + at: left for at in range(len(kinds))})


def _labels(cells: Sequence[Cell], computed: str, names: ControllerNames) -> Iterator[Label]:
    """Yield what each row is of, with what the rows over it say; a row over further ones holds what is computed."""
    read = [Label(component=cell) if _is_total(cell) else read_label(cell, names) for cell in cells]
    above: list[Label] = []
    for label, cell, following in zip(read, cells, [*read[1:], None], strict=True):
        if label is None:
            return
        kinds = [set(each.said) for each in above]
        if set(label.said) in kinds:
            above = above[: kinds.index(set(label.said))]
        above.append(label)
        kinds = [set(each.said) for each in above]
        if _is_total(cell) or (following is not None and set(following.said) not in kinds):
            yield Label(component=f"{computed} ({text_of(cell)})")
        else:
            yield Label(**{name: value for each in above for name, value in each.said.items()})
