"""Say which sheets the workbook that describes a valve body has, in the order of its tabs.

A key of a controller's file that stands in no column would be lost on the way through a workbook; a test compares this
declaration with the models of the file.
"""

from __future__ import annotations

from dataclasses import dataclass

from atleak.catalogue.section_pressures import SECTIONS
from atleak.controller_sheets import pressure_sheets as pressures
from atleak.controller_sheets import valve_sheets as valve
from atleak.controller_sheets.circuit_shapes import LINE
from atleak.controller_sheets.kinds import Choice
from atleak.controller_sheets.shapes import Column, Sheet
from atleak.controller_sheets.units import CLEARANCES, LENGTHS, PRESSURES


@dataclass(frozen=True)
class Offered:
    """The names that a drop-down offers: fixed ones, then those of a column of another sheet."""

    sheet: str
    heading: str
    fixed: tuple[str, ...] = ()


NAMES = {
    "component": Offered("Components", "Id"),
    "circuit": Offered("Circuits", "Id"),
    "line or circuit": Offered("Circuits", "Id", (LINE,)),
    "pressure": Offered("Circuits", "Id", (*SECTIONS, "drain")),
    "section": Offered("Circuits", "Id", SECTIONS),
    "operating point": Offered("Operating points", "Name"),
    "material": Offered("Materials", "Name"),
    "consumer": Offered("Consumers", "Id"),
}

UNIT_LINES = (  # at the head of the first sheet; no keys of the file
    Column("Lengths are in", ("length",), Choice(LENGTHS), required=True),
    Column("Clearances are", ("clearance",), Choice(CLEARANCES), required=True),
    Column("Pressures are in", ("pressure",), Choice(PRESSURES), required=True),
)

HEAD = valve.HEAD
SHEETS: tuple[Sheet, ...] = (
    HEAD, valve.MATERIALS, valve.COMPONENTS, valve.LANDS, valve.PUMP, valve.POINTS,
    pressures.CIRCUITS, pressures.FEEDS, pressures.SET_PRESSURES, pressures.APPLY_CHART, pressures.GAPS,
    pressures.LINE_PRESSURES, pressures.SECTION_PRESSURES, pressures.LEAKS, pressures.CONSUMERS, pressures.FLOWS,
    valve.REPAIRS, valve.COMPLAINTS,
)  # fmt: skip
"""Every sheet, in the order in which a workbook is written and read: an id stands before it is used."""
INSTRUCTIONS = "How to fill in"

NOTE_HEADING, UNIT_MARK, EXAMPLE_MARK = "Note", "unit", "e.g."
"""The first column of every sheet: it marks the row of units and of examples; all else in it is a remark, not read."""
FIELD, VALUE, UNIT, HOW_KNOWN, ABOUT = FORM_HEADINGS = ("Field", "Value", "Unit", "How known", "About")
LISTS = "Lists"
"""A hidden sheet with the names that drop-downs offer."""
