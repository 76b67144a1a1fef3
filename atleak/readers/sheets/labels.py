"""Cells that say several things at once: "pressure_regulator/2", "No. 8, plane 1", "bore 90°".

`read_label` takes one apart; `with_split_labels` gives a table a column for each thing that such cells say.
"""

from __future__ import annotations

import datetime
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from atleak.common.errors import ReadingsError
from atleak.readers.cells.sheet import Cell
from atleak.readers.sheets.column_headings import (
    HeadedColumn,
    Role,
    is_angle,
    spot_of_heading,
    tokens_of,
    unit_of_heading,
)
from atleak.readers.sheets.controller_names import ControllerNames
from atleak.readers.sheets.table import HeadedTable
from atleak.readers.sheets.words import (
    direction_of,
    is_blank,
    number_of,
    part_of,
    part_said,
    plain,
    plane_names,
    sheet_vocabulary,
    text_of,
)

_LEADING_NUMBER = re.compile(r"(\d+'?)(?=[\s,;:./_()\-–—#]|$)")
_AXES = {"x": "0°", "y": "90°"}
_MONTH = (
    r"(?:jan|feb|mar|apr|may|mai|maj|jun|jul|aug|sep|oct|okt|nov|dec|dez|sty|lut|kwi|cze|lip|sie|wrz|paz|lis|gru)"
    r"[a-z]*\.?"
)
_DATE = re.compile(rf"\d{{1,2}}[-. ]+{_MONTH}|{_MONTH}[-. ]+\d{{1,2}}|\d{{4}}-\d\d-\d\d(?:[t ]00:00(?::00)?)?")


_ROLES: Mapping[str, Role] = {  # what a cell may say; a number stands for a land or a plane without saying which
    **{role: role for role in ("component", "part", "land", "plane", "direction", "repeat", "unit")},
    "number": "plane",
}
Label = dict[str, str]  # what one cell says of a diameter, each as a cell of its own column would say it


def read_label(cell: Cell, names: ControllerNames) -> Label | None:
    """Return what a cell says, if all of it is understood.

    >>> from atleak.catalogue.controller_file import load_controller
    >>> names = ControllerNames(load_controller("minimal_example"))
    >>> read_label("pressure_regulator (2), bore 90°", names)
    {'component': 'pressure_regulator', 'part': 'sleeve', 'plane': '2', 'direction': '90°'}
    >>> read_label("ring gauge 18.0", names), read_label("pressure_regulator/3", names)
    (None, None)
    """
    if isinstance(cell, bool | datetime.date | datetime.time) or cell is None:
        return None
    rest, unit = unit_of_heading(text_of(cell))
    folded = plain(rest)
    for component, other in (*_with_component(folded, names), (None, folded)):
        label: Label = {} if component is None else {"component": component}
        label |= {} if unit is None else {"unit": unit.name}
        if _takes_rest(other, label) and _is_placed(label, names) and label:
            return {name: label[name] for name in _ROLES if name in label}
    return None


def _with_component(folded: str, names: ControllerNames) -> Iterator[tuple[str, str]]:
    """Yield each component that a text may name, the longest name first, with the rest of the text."""
    for name, component in names.by_length:
        if component not in names.with_lands:
            continue
        if any(letter.isalpha() for letter in name):
            match = re.search(rf"(?<![^\W_]){re.escape(name)}(?![^\W_])", folded) if name in folded else None
            if match is not None:
                yield component, f"{folded[: match.start()]} {folded[match.end() :]}"
    leading = re.sub(r"^(?:(?:[^\W\d_]+|#)[\s.:]*)", _unless_label, folded)
    match = _LEADING_NUMBER.match(leading)
    numbered = names.component(match[1]) if match else None
    if match is not None and numbered is not None and numbered in names.with_lands:
        yield numbered, leading[match.end() :]


def _unless_label(match: re.Match[str]) -> str:
    is_label = match[0].strip(" .:") in sheet_vocabulary("number", "component", "generic")
    return "" if is_label or match[0].startswith("#") else match[0]


def _takes_rest(text: str, label: Label) -> bool:
    """Add what the other words of its cell say to a label; return whether all of them are understood."""
    part = part_said(text.strip(" -–_/.,;:()"))
    if part is not None:
        label["part"] = part
        return True
    spot, others = spot_of_heading(tokens_of(text.replace(".", " ").replace("°", "° ")))
    label |= spot
    before = ""
    for token in others:
        part = part_of(token) if len(token) > 1 else None
        if token.isdigit():
            repeats = before in sheet_vocabulary("of_repeat") and "repeat" not in label
            if not repeats and not label.keys().isdisjoint(("number", "land", "plane")):
                return False
            label["repeat" if repeats else "number"] = token
        elif (is_angle(token) or token in _AXES) and "direction" not in label:
            label["direction"] = _AXES.get(token, token)
        elif part is not None and label.get("part", part) == part:
            label["part"] = part
        elif token.isalpha() and len(token) > 3 and "direction" not in label and direction_of(token) is not None:
            label["direction"] = token
        elif token not in sheet_vocabulary("number", "diameter", "of_repeat"):
            return False
        before = token
    return True


def _is_placed(label: Label, names: ControllerNames) -> bool:
    """Take the number of a label for a plane; return whether its component has that plane or land."""
    component = label.get("component")
    if component is None:
        return True
    try:
        if "number" in label:
            label["plane"] = names.plane(component, label.pop("number"))
        elif "plane" in label:
            names.plane(component, label["plane"])
        if "land" in label:
            names.land(component, label["land"])
    except ReadingsError:
        return False
    return True


def says_date(cell: Cell) -> bool:
    """Return whether a spreadsheet program may have made a date of "8-1" here.

    >>> says_date(datetime.date(2026, 8, 1)), says_date("08-Jan"), says_date("1. Aug"), says_date("8/1")
    (True, True, True, False)
    """
    if isinstance(cell, datetime.date):
        return True
    return isinstance(cell, str) and _DATE.fullmatch(plain(cell)) is not None


def with_split_labels(table: HeadedTable, names: ControllerNames) -> HeadedTable:
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
            table = _LabelColumn(table, index, names).split(rows)
    return table


@dataclass(frozen=True)
class _LabelColumn:
    """A column of which it is asked whether its cells say several things at once."""

    table: HeadedTable
    index: int
    names: ControllerNames

    def split(self, rows: Sequence[int]) -> HeadedTable:
        """Return the table with a column for each thing that the cells say; as it is where they say one at most."""
        labels = self._labels(rows)
        meanings = dict.fromkeys(name for label in labels.values() for name in label)
        wanted = [name for name in meanings if not self._is_said(_ROLES[name])]
        texts, filled = self.table.texts, self.table.sheet.filled
        columns = [(HeadedColumn(0, texts[self.index], _ROLES[name], rank=9), self.index) for name in wanted]

        def cells(row: int) -> Iterator[Cell]:
            label = labels.get(row)
            for at, name in enumerate(wanted):
                whole = filled(row, self.index) if at == 0 else ""
                yield whole if label is None else label.get(name, "")

        return self.table.with_columns(columns, cells, frozenset({self.index})) if labels else self.table

    def _labels(self, rows: Sequence[int]) -> Mapping[int, Label]:
        """Return what the cells of a column to be split say; nothing where it is none."""
        role = self.table.role(self.index)
        cells = {row: cell for row in rows if not is_blank(cell := self.table.sheet.filled(row, self.index))}
        if role is None:
            candidate = not all(map(_is_number, cells.values()))
        else:
            plain_cells = sum(self._is_plain(cell, role) for cell in cells.values())
            candidate = role in ("component", "part") and 2 * plain_cells < len(cells)
        if not candidate:
            return {}
        labels = {row: label for row, cell in cells.items() if (label := read_label(cell, self.names)) is not None}
        meanings = {name for label in labels.values() for name in label}
        needed = {name for name in meanings if not self._is_said(_ROLES[name])} - {"unit"}
        if role is None:  # an "x" is a tick as often, and "No. 2" may be anything's
            needed -= {"direction", "repeat"} if meanings & {"component", "part"} else {"direction", "repeat", "number"}
        agree = needed and role in (None, *meanings) and all(self._agrees(label, row) for row, label in labels.items())
        return labels if agree and 2 * len(labels) > len(cells) else {}

    def _is_plain(self, cell: Cell, role: Role) -> bool:
        """Return whether a cell says what its heading promises and nothing else."""
        if role == "component":
            return self.names.component(cell) is not None
        return part_said(text_of(cell)) is not None

    def _agrees(self, label: Label, row: int) -> bool:
        """Return whether a label contradicts no other column, and no heading that says the part of its diameters."""
        part = part_said(label.get("part", ""))
        parts = {column.part for column in self.table.values} - {None}
        places = {label[name] for name in ("land", "plane", "number") if name in label}

        def differs(role: Role, cell: Cell) -> bool:
            if is_blank(cell):
                return False
            if role in ("plane", "land"):
                return bool(places) and places.isdisjoint(plane_names(cell))
            if role == "part":
                return "part" in label and part_said(text_of(cell)) != part
            other = self.names.component(cell) if role == "component" and "component" in label else None
            return other in self.names.with_lands and other != label["component"]

        others = (column for column in self.table.columns if column.index != self.index)
        return not ("part" in label and parts and part not in parts) and not any(
            differs(column.role, self.table.sheet.filled(row, column.index)) for column in others
        )

    def _is_said(self, role: Role) -> bool:
        """Return whether another column says it, or every heading of a diameter."""
        places: tuple[Role, ...] = ("plane", "land")
        roles = places if role in places else (role,)
        if any(column.role in roles and column.index != self.index for column in self.table.columns):
            return True
        if role in places:
            return all(column.plane or column.land for column in self.table.values)
        return role != "component" and all(getattr(column, role) is not None for column in self.table.values)


def _is_number(cell: Cell) -> bool:
    return not isinstance(cell, str) or number_of(cell) is not None
