"""Tables of which one column says several things in a cell → the same with a column for each of them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from atleak.intake.readings.controller_names import ControllerNames
from atleak.intake.readings.labels import Label, read_label
from atleak.intake.readings.one_heading import Column, Role
from atleak.intake.readings.table import Table
from atleak.intake.readings.words import is_blank, number_of, part_said, plane_names, text_of
from atleak.intake.sheets.sheet import Cell

_ROLES: Mapping[str, Role] = {
    **{role: role for role in ("component", "part", "land", "plane", "direction", "repeat", "unit")},
    "number": "plane",
}


def with_split_labels(table: Table, names: ControllerNames) -> Table:
    """Return a table with further columns behind its last one, for what a cell says besides its own column's meaning.

    A column is split where most cells beside a diameter are understood as a whole, and say more than its heading does
    or something that no other column says. A cell that is not understood stays in the first of the new columns.
    """
    cell = table.sheet.cell
    rows = [row for row in table.rows if any(not is_blank(cell(row, column.index)) for column in table.values)]
    if not rows or (table.sheet.is_text and any(len(table.sheet.rows[row]) > len(table.texts) for row in rows)):
        return table
    for index in range(len(table.texts)):
        if not any(column.index == index for column in (*table.values, *table.of_lands)):
            labels = _labels(table, index, rows, names)
            if labels:
                table = _split(table, index, labels)
    return table


def _labels(table: Table, index: int, rows: Sequence[int], names: ControllerNames) -> Mapping[int, Label]:
    """Return what the cells of a column to be split say; nothing where it is none."""
    role = table.role(index)
    if role not in (None, "component", "part"):
        return {}
    cells = {row: cell for row in rows if not is_blank(cell := table.sheet.filled(row, index))}
    strange = [cell for cell in cells.values() if not _is_plain(cell, role, names)]
    if 2 * len(strange) <= len(cells) or (role is None and all(map(_is_number, cells.values()))):
        return {}
    labels = {row: label for row, cell in cells.items() if (label := read_label(cell, names)) is not None}
    said = {name for label in labels.values() for name in label.said}
    if role is not None and role not in said:
        return {}
    needed = {name for name in said if not _is_said(table, _ROLES[name], index)} - {"unit"}
    if role is None:  # an "x" is a tick as often, and "No. 2" may be anything's
        needed -= {"direction", "repeat"} if said & {"component", "part"} else {"direction", "repeat", "number"}
    agree = all(_agrees(label, row, table, index, names) for row, label in labels.items())
    return labels if 2 * len(labels) > len(cells) and needed and agree else {}


def _agrees(label: Label, row: int, table: Table, besides: int, names: ControllerNames) -> bool:
    """Return whether a label contradicts no other column, and no heading that says the part of its diameters."""
    part = part_said(label.part or "")
    parts = {column.part for column in table.values} - {None}
    places = {each for each in (label.land, label.plane, label.number) if each is not None}

    def differs(role: Role, cell: Cell) -> bool:
        if role in ("plane", "land"):
            return bool(places) and places.isdisjoint(plane_names(cell))
        if role == "part":
            return label.part is not None and part_said(text_of(cell)) != part
        other = names.component(cell) if role == "component" and label.component is not None else None
        return other in names.with_lands and other != label.component

    others = [column for column in table.columns if column.index != besides]
    cells = [(column.role, cell) for column in others if not is_blank(cell := table.sheet.filled(row, column.index))]
    return not (label.part is not None and parts and part not in parts) and not any(differs(*each) for each in cells)


def _is_plain(cell: Cell, role: Role | None, names: ControllerNames) -> bool:
    """Return whether a cell says what its heading promises and nothing else."""
    if role == "component":
        return names.component(cell) is not None
    return role == "part" and part_said(text_of(cell)) is not None


def _is_number(cell: Cell) -> bool:
    return not isinstance(cell, str) or number_of(cell) is not None


def _is_said(table: Table, role: Role, besides: int) -> bool:
    """Return whether another column says it, or every heading of a diameter."""
    places: tuple[Role, ...] = ("plane", "land")
    roles = places if role in places else (role,)
    if any(column.role in roles and column.index != besides for column in table.columns):
        return True
    if role in places:
        return all(column.plane or column.land for column in table.values)
    return role != "component" and all(getattr(column, role) is not None for column in table.values)


def _split(table: Table, index: int, labels: Mapping[int, Label]) -> Table:
    said = dict.fromkeys(name for label in labels.values() for name in label.said)
    wanted = [name for name in said if not _is_said(table, _ROLES[name], index)]
    columns = [(Column(0, table.texts[index], _ROLES[name], rank=9), index) for name in wanted]

    def cells(row: int) -> Iterator[Cell]:
        label = labels.get(row)
        for at, name in enumerate(wanted):
            unread = table.sheet.filled(row, index) if label is None and at == 0 else ""
            yield unread if label is None else label.said.get(name, "")

    return table.with_columns(columns, cells, frozenset({index}))
