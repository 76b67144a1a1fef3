"""The columns of a measuring sheet's table, in their order; the words that its tabs share, and the formats of cells.

The rows of a measuring sheet in the order of measuring, and which of them share a cell.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum
from itertools import groupby
from typing import Any

import xlsxwriter
from xlsxwriter.format import Format
from xlsxwriter.utility import xl_col_to_name

from atleak.catalogue.controller import Controller, Land
from atleak.catalogue.instruments import Part
from atleak.common.sentences import Sentence
from atleak.common.style import SHEET_COLOURS
from atleak.common.wording import Wording
from atleak.measurements.measuring_plan import DIRECTIONS, PLAN_PARTS, REPEATS, Plan
from atleak.measurements.own_forms import MEASUREMENTS
from atleak.measurements.readings import Reading
from atleak.report.sheets.paging import RowBlock


class FormColumn(IntEnum):
    """A column, by its number from 0: what it holds, of which kind its unit is, least width in characters.

    Those up to `ORIGIN` are printed. A repeat beyond the second has its columns behind all these, `of_repeat`.
    """

    COMPONENT = "component", None, 5
    NAME = "name", None, 14
    PART = "part", None, 7
    PLANE = "plane", None, 6
    DIRECTION = "direction", None, 5
    X1 = "coordinate 1, repeat 1", "length", 9
    X2 = "coordinate 2, repeat 1", "length", 9
    DIAMETER = "diameter, repeat 1", "length", 11
    SECOND_X1 = "coordinate 1, repeat 2", "length", 9
    SECOND_X2 = "coordinate 2, repeat 2", "length", 9
    SECOND_DIAMETER = "diameter, repeat 2", "length", 11
    NOMINAL = "nominal", "length", 8
    CLEARANCE = "clearance", "clearance", 8
    ORIGIN = "origin", None, 8
    DEVIATION = "deviation, repeat 1", "clearance", 11
    SECOND_DEVIATION = "deviation, repeat 2", "clearance", 11
    TAKEN_AT = "taken at", None, 11

    holds: str
    kind: str | None
    least_width: int

    def __new__(cls, holds: str, kind: str | None, least_width: int) -> FormColumn:
        """Number the columns as they stand here."""
        column = int.__new__(cls, len(cls.__members__))
        column._value_ = len(cls.__members__)
        column.holds, column.kind, column.least_width = holds, kind, least_width
        return column

    @property
    def letter(self) -> str:
        """Return what a spreadsheet calls it."""
        return str(xl_col_to_name(self))

    def said(self, say: Wording) -> str:
        """Return the heading with its unit."""
        return heading_of(self.holds, self.kind, say)

    def width(self, say: Wording) -> int:
        """Return the width in characters: no word of the heading is broken."""
        return max(self.least_width, 1 + max(map(len, self.said(say).split())))


_OF_REPEAT = len(("coordinate 1", "coordinate 2", "diameter"))


def of_repeat(repeat: int) -> range:
    """Return the columns of a repeat: its two coordinates and its diameter."""
    beyond = len(FormColumn) - FormColumn.X1 if repeat > REPEATS else 0
    first = FormColumn.X1 + beyond + _OF_REPEAT * (repeat - 1 - (REPEATS if beyond else 0))
    return range(first, first + _OF_REPEAT)


def heading_of(holds: str, kind: str | None, say: Wording) -> str:
    """Return the heading of a column by what it holds, with the unit of its kind."""
    return say.sentence(MEASUREMENTS.headings[holds]) + (f" [{say.unit(kind)}]" if kind else "")


SHEET = Sentence("Measurements")
UNWORN_END = Sentence("unworn end")  # what marks a reading there; the reader's vocabulary knows it in every language
PUMP_SIDE, PUMP_TIP = Sentence("Pump side clearance"), Sentence("Pump tip clearance")  # the reader knows them
REPRESENTATIVE, AS_STATED = Sentence("assumed"), Sentence("as stated")
FORM_PART_NAMES: Mapping[str, Sentence] = {
    "spool": Sentence("spool"),
    "piston": Sentence("piston"),
    "end plug": Sentence("end plug"),
    "sleeve": Sentence("sleeve"),
}


def formats_of(book: xlsxwriter.Workbook, say: Wording) -> dict[str, Format]:
    """Return the formats for every tab; lengths have the digits that its notes ask for: 0.001 mm, 0.00005 in."""
    length = "0.000" if say.unit("length") == "mm" else "0.00000"
    shade = SHEET_COLOURS
    cell = {"border": 1, "border_color": shade["border"], "valign": "vcenter"}
    given = {**cell, "bg_color": shade["given"]}
    entry = {**cell, "bg_color": shade["entry"], "locked": False}
    soft = {**given, "font_color": shade["soft"]}
    wrapped = {"text_wrap": True, "valign": "top"}
    heading = {"bg_color": shade["heading"], "font_color": shade["on_heading"]}
    properties: Mapping[str, Mapping[str, Any]] = {
        "title": {"bold": True, "font_size": 14},
        "field label": {"bold": True, "text_wrap": True, "valign": "vcenter"},
        "field": {"bottom": 1, "bg_color": shade["entry"], "text_wrap": True, "valign": "vcenter"},
        "mark": {"font_size": 8, "font_color": shade["note"]},
        "note": {**wrapped, "italic": True, "font_color": shade["note"]},
        "heading": {**cell, **heading, "bold": True, "text_wrap": True, "align": "center"},
        "text": {**given, "text_wrap": True, "align": "left"},
        "upright": {**given, "align": "center", "rotation": 90},
        "on top": {**given, **wrapped, "align": "left"},
        "number": {**given, "align": "center"},
        "angle": {**given, "align": "center", "num_format": '0"°"'},
        "input": {**entry, "num_format": length},
        "choice": entry,
        "nominal": {**soft, "num_format": length},
        "clearance": {**soft, "num_format": "0.0"},
        "pressure": {**entry, "num_format": "0.0"},
        "origin": {**soft, "italic": True, "text_wrap": True},
        "deviation": {**given, "num_format": "0"},
        "alarm": {"bg_color": shade["alarm"], "font_color": shade["on_heading"], "bold": True},
        "wrap": wrapped,
        "topic": {**wrapped, "bold": True},
    }
    return {name: book.add_format(dict(look)) for name, look in properties.items()}


@dataclass(frozen=True)
class FormRow:
    """The readings that are to be taken in one direction, by their repeat, and what they were if they were taken."""

    land: Land
    part: Part
    plane: str
    direction: float | None
    repeats: Mapping[int, Reading | None]

    @property
    def nominal(self) -> float:
        """Return nominal diameter of the part [m]."""
        return self.land.nominal_of(self.part)


_Key = Callable[[FormRow], tuple[Any, ...]]


def of_component(row: FormRow) -> tuple[Any, ...]:
    """Return what the rows of a component have alike."""
    return (row.land.component,)


def of_part(row: FormRow) -> tuple[Any, ...]:
    """Return what the rows of a part have alike."""
    return *of_component(row), row.part


def of_plane(row: FormRow) -> tuple[Any, ...]:
    """Return what the rows of a plane have alike."""
    return *of_part(row), row.plane


def rows_of_form(controller: Controller, readings: Iterable[Reading], blank_rows: bool) -> list[FormRow]:
    """Return the rows in the order in which a part is measured, `how_to_measure.order` of the texts."""
    given: dict[tuple[Any, ...], dict[int, Reading]] = defaultdict(dict)
    directions: dict[tuple[str, Part, str], list[float | None]] = defaultdict(list)
    for reading in readings:
        repeats = given[reading.station]
        repeats[reading.repeat if reading.repeat not in repeats else max(repeats) + 1] = reading
        known = directions[reading.component, reading.part, reading.plane]
        if reading.direction not in known:
            known.append(reading.direction)

    def rows_of_part(component: str, part: Part) -> Iterator[FormRow]:
        for land in controller.lands_of(component):
            for plane in land.planes:
                measured = directions[component, part, plane]
                wanted = [angle for angle in DIRECTIONS if angle not in measured] if blank_rows else []
                for direction in sorted([*measured, *wanted], key=lambda angle: -1.0 if angle is None else angle):
                    repeats = given[component, part, plane, direction]
                    asked = dict.fromkeys(range(1, REPEATS + 1) if blank_rows else ())
                    yield FormRow(land, part, plane, direction, {**asked, **repeats})

    components = dict.fromkeys(land.component for land in controller.lands)
    return [row for component in components for part in PLAN_PARTS for row in rows_of_part(component, part)]


def rows_of_plan(controller: Controller, plan: Plan) -> list[FormRow]:
    """Return an empty row for every direction in which a plan asks for readings, in its order."""
    asked: dict[tuple[Land, Part, str, float | None], dict[int, None]] = defaultdict(dict)
    for cell in plan.cells(controller):
        land = controller.land_of_plane(cell.component, cell.plane)
        if land is not None:
            asked[land, cell.part, cell.plane, cell.direction][cell.repeat] = None
    return [FormRow(*place, repeats) for place, repeats in asked.items()]


def runs_of_cells(
    numbered: Sequence[tuple[int, FormRow]], pages: Sequence[int], key: _Key
) -> Iterator[tuple[int, int, FormRow]]:
    """Return first number, last number and first row of every run of rows with the same key on the same page."""
    for _, block in groupby(zip(numbered, pages, strict=True), key=lambda each: (each[1], key(each[0][1]))):
        inside = [entry for entry, _ in block]
        yield inside[0][0], inside[-1][0], inside[0][1]


def blocks_of(rows: Sequence[FormRow], keys: Sequence[_Key] = (of_component, of_part, of_plane)) -> list[RowBlock]:
    """Return the numbers of rows of components, within them of parts, of planes."""
    key, *finer = keys
    groups = [list(block) for _, block in groupby(rows, key=key)]
    return [blocks_of(group, finer) if finer else len(group) for group in groups]
