"""Tables of which one column says several things in a cell → the same with a column for each of them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from atleak.intake.readings.controller_names import ControllerNames
from atleak.intake.readings.headings import Header
from atleak.intake.readings.labels import Label, read_label
from atleak.intake.readings.one_heading import Column, Role
from atleak.intake.readings.words import is_blank, number_of, part_said, plane_names, text_of
from atleak.intake.sheets.sheet import Cell, Sheet

_ROLES: Mapping[str, Role] = {
    "component": "component",
    "part": "part",
    "land": "land",
    "plane": "plane",
    "number": "plane",
    "direction": "direction",
    "repeat": "repeat",
    "unit": "unit",
}


def with_split_labels(sheet: Sheet, header: Header, names: ControllerNames) -> tuple[Sheet, Header]:
    """Return a table with further columns behind its last one, for what a cell says besides its own column's meaning.

    A column is split where most cells beside a diameter are understood as a whole, and say more than its heading does
    or something that no other column says. A cell that is not understood stays in the first of the new columns.
    """
    rows = [
        row
        for row in range(header.last + 1, len(sheet.rows))
        if any(not is_blank(sheet.cell(row, column.index)) for column in header.values)
    ]
    if not rows or (sheet.is_text and any(len(sheet.rows[row]) > len(header.texts) for row in rows)):
        return sheet, header
    for index in range(len(header.texts)):
        if not any(column.index == index and (column.holds_value or column.of_lands) for column in header.columns):
            labels = _labels(sheet, header, index, rows, names)
            if labels:
                sheet, header = _split(sheet, header, index, labels)
    return sheet, header


def _labels(
    sheet: Sheet, header: Header, index: int, rows: Sequence[int], names: ControllerNames
) -> Mapping[int, Label]:
    """Return what the cells of a column to be split say; nothing where it is none."""
    role = next((column.role for column in header.columns if column.index == index), None)
    if role not in (None, "component", "part"):
        return {}
    cells = {row: cell for row in rows if not is_blank(cell := sheet.filled(row, index))}
    strange = [cell for cell in cells.values() if not _is_plain(cell, role, names)]
    if 2 * len(strange) <= len(cells) or (role is None and all(map(_is_number, cells.values()))):
        return {}
    labels = {row: label for row, cell in cells.items() if (label := read_label(cell, names)) is not None}
    said = {name for label in labels.values() for name in label.said}
    if role is not None and role not in said:
        return {}
    needed = {name for name in said if not _is_said(header, _ROLES[name], index)} - {"unit"}
    if role is None:  # an "x" is a tick as often, and "No. 2" may be anything's
        needed -= {"direction", "repeat"} if said & {"component", "part"} else {"direction", "repeat", "number"}
    agree = all(_agrees(label, row, sheet, header, index, names) for row, label in labels.items())
    return labels if 2 * len(labels) > len(cells) and needed and agree else {}


def _agrees(label: Label, row: int, sheet: Sheet, header: Header, besides: int, names: ControllerNames) -> bool:
    """Return whether a label contradicts no other column, and no heading that says the part of its diameters."""
    parts = {column.part for column in header.values} - {None}
    if label.part is not None and parts and part_said(label.part) not in parts:
        return False
    places = {each for each in (label.land, label.plane, label.number) if each is not None}
    for column in header.columns:
        cell = sheet.filled(row, column.index)
        if column.index == besides or is_blank(cell):
            continue
        if column.role in ("plane", "land") and places and places.isdisjoint(plane_names(cell)):
            return False
        if column.role == "part" and label.part is not None and part_said(text_of(cell)) != part_said(label.part):
            return False
        if column.role == "component" and label.component is not None:
            other = names.component(cell)
            if other in names.with_lands and other != label.component:
                return False
    return True


def _is_plain(cell: Cell, role: Role | None, names: ControllerNames) -> bool:
    """Return whether a cell says what its heading promises and nothing else."""
    if role == "component":
        return names.component(cell) is not None
    return role == "part" and part_said(text_of(cell)) is not None


def _is_number(cell: Cell) -> bool:
    return not isinstance(cell, str) or number_of(cell) is not None


def _is_said(header: Header, role: Role, besides: int) -> bool:
    """Return whether another column says it, or every heading of a diameter."""
    if any(column.role == role and column.index != besides for column in header.columns):
        return True
    if role in ("plane", "land"):
        others = [column for column in header.columns if column.role in ("plane", "land") and column.index != besides]
        return bool(others) or all(column.plane or column.land for column in header.values)
    named = {"part": "part", "direction": "direction", "repeat": "repeat", "unit": "unit"}.get(role)
    return named is not None and all(getattr(column, named) is not None for column in header.values)


def _split(sheet: Sheet, header: Header, index: int, labels: Mapping[int, Label]) -> tuple[Sheet, Header]:
    said = dict.fromkeys(name for label in labels.values() for name in label.said)
    wanted = [name for name in said if not _is_said(header, _ROLES[name], index)]
    heading = header.texts[index]
    first = max(sheet.width, len(header.texts))
    columns = [Column(first + at, heading, _ROLES[name], rank=9) for at, name in enumerate(wanted)]
    rows = [
        [*cells, *[""] * (first - len(cells)), *_cells(sheet, row, index, wanted, labels.get(row))]
        for row, cells in enumerate(sheet.rows)
    ]
    texts = (*header.texts, *[""] * (first - len(header.texts)), *[heading] * len(wanted))
    others = [column for column in header.columns if column.index != index]
    return (
        replace(sheet, rows=rows, derived={**sheet.derived, **{column.index: index for column in columns}}),
        replace(header, columns=(*others, *columns), texts=texts),
    )


def _cells(sheet: Sheet, row: int, index: int, wanted: Sequence[str], label: Label | None) -> Iterator[Cell]:
    said = {} if label is None else label.said
    for at, name in enumerate(wanted):
        unread = sheet.filled(row, index) if label is None and at == 0 else ""
        yield said.get(name, unread)
