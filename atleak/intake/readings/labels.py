"""Cells that say several things at once: "pressure_regulator/2", "No. 8, plane 1", "bore 90°"."""

from __future__ import annotations

import datetime
import re
from collections.abc import Iterator
from dataclasses import dataclass, replace

from atleak.errors import ReadingsError
from atleak.intake.readings.controller_names import ControllerNames
from atleak.intake.readings.heading_numbers import is_angle, spot_of_heading, tokens_of
from atleak.intake.readings.one_heading import split_unit
from atleak.intake.readings.words import direction_of, part_of, part_said, plain, text_of, vocabulary
from atleak.intake.sheets.sheet import Cell

_LEADING_NUMBER = re.compile(r"(\d+'?)(?=[\s,;:./_()\-–—#]|$)")
_AXES = {"x": "0°", "y": "90°"}
_MONTH = (
    r"(?:jan|feb|mar|apr|may|mai|maj|jun|jul|aug|sep|oct|okt|nov|dec|dez|sty|lut|kwi|cze|lip|sie|wrz|paz|lis|gru)"
    r"[a-z]*\.?"
)
_DATE = re.compile(rf"\d{{1,2}}[-. ]+{_MONTH}|{_MONTH}[-. ]+\d{{1,2}}|\d{{4}}-\d\d-\d\d(?:[t ]00:00(?::00)?)?")


@dataclass(frozen=True)
class Label:
    """What one cell says of a diameter, each as a cell of its own column would say it; None where it does not.

    ``number`` is one that stands for a land or a plane without saying which of them.
    """

    component: str | None = None
    part: str | None = None
    land: str | None = None
    plane: str | None = None
    direction: str | None = None
    repeat: str | None = None
    unit: str | None = None
    number: str | None = None

    @property
    def said(self) -> dict[str, str]:
        """Return what is said, by what it is."""
        return {name: value for name, value in vars(self).items() if value is not None}


def read_label(cell: Cell, names: ControllerNames) -> Label | None:
    """Return what a cell says, if all of it is understood.

    >>> from atleak.catalogue.controller_reading import load_controller
    >>> names = ControllerNames(load_controller("minimal_example"))
    >>> read_label("pressure_regulator (2), bore 90°", names).said
    {'component': 'pressure_regulator', 'part': 'sleeve', 'plane': '2', 'direction': '90°'}
    >>> read_label("ring gauge 18.0", names), read_label("pressure_regulator/3", names)
    (None, None)
    """
    if isinstance(cell, bool | datetime.date | datetime.time) or cell is None:
        return None
    text = text_of(cell)
    rest, unit = split_unit(text)
    folded = plain(rest)
    for component, other in (*_with_component(folded, names), (None, folded)):
        label = _read_rest(other, replace(Label(), component=component, unit=None if unit is None else unit.name))
        if label is not None and (label := _placed(label, names)) is not None and label.said:
            return label
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
    is_label = match[0].strip(" .:") in vocabulary("number", "component", "generic")
    return "" if is_label or match[0].startswith("#") else match[0]


def _read_rest(text: str, label: Label) -> Label | None:
    """Return the label with what the other words of its cell say; None where one of them says something else."""
    part = part_said(text.strip(" -–_/.,;:()"))
    if part is not None:
        return replace(label, part=part)
    spot, others = spot_of_heading(tokens_of(text.replace(".", " ").replace("°", "° ")))
    label = replace(label, **spot)
    before = ""
    for token in others:
        if token.isdigit():
            if before in vocabulary("of_repeat") and label.repeat is None:
                label = replace(label, repeat=token)
            elif label.number is None and label.land is None and label.plane is None:
                label = replace(label, number=token)
            else:
                return None
        elif (is_angle(token) or token in _AXES) and label.direction is None:
            label = replace(label, direction=_AXES.get(token, token))
        elif (said := part_of(token) if len(token) > 1 else None) is not None and label.part in (None, said):
            label = replace(label, part=said)
        elif token.isalpha() and len(token) > 3 and label.direction is None and direction_of(token) is not None:
            label = replace(label, direction=token)
        elif token not in vocabulary("number", "diameter", "of_repeat"):
            return None
        before = token
    return label


def _placed(label: Label, names: ControllerNames) -> Label | None:
    """Return the label with its number as the plane or land of its component; None where it has no such one."""
    if label.component is None:
        return label
    try:
        if label.number is not None:
            return replace(label, number=None, plane=names.plane(label.component, label.number))
        if label.plane is not None:
            names.plane(label.component, label.plane)
        if label.land is not None:
            names.land(label.component, label.land)
    except ReadingsError:
        return None
    return label


def says_date(cell: Cell) -> bool:
    """Return whether a spreadsheet program may have made a date of "8-1" here.

    >>> says_date(datetime.date(2026, 8, 1)), says_date("08-Jan"), says_date("1. Aug"), says_date("8/1")
    (True, True, True, False)
    """
    if isinstance(cell, datetime.date):
        return True
    return isinstance(cell, str) and _DATE.fullmatch(plain(cell)) is not None
