"""The columns of a measuring sheet's table, in their order; the words that its tabs share, and the formats of cells."""

from __future__ import annotations

from collections.abc import Mapping
from enum import IntEnum
from typing import Any

import xlsxwriter
from xlsxwriter.format import Format
from xlsxwriter.utility import xl_col_to_name

from atleak.look import SHEET_COLOURS
from atleak.readings import NOMINAL_HEADING
from atleak.sentence import Sentence
from atleak.wording import Wording


class Column(IntEnum):
    """A column, by its number from 0: heading, kind of quantity that its unit is of, least width in characters."""

    COMPONENT = Sentence("No."), None, 5
    NAME = Sentence("Component"), None, 20
    PART = Sentence("Part"), None, 8
    PLANE = Sentence("Plane"), None, 7
    DIRECTION = Sentence("Direction"), None, 9
    REPEAT = Sentence("Repeat"), None, 8
    X1 = Sentence("Coordinate\nx1 (y1)"), "length", 12
    X2 = Sentence("Coordinate\nx2 (y2)"), "length", 12
    DIAMETER = Sentence("Diameter"), "length", 12
    NOMINAL = NOMINAL_HEADING, "length", 10
    CLEARANCE = Sentence("Mounting\nclearance"), "clearance", 10
    ORIGIN = Sentence("Nominal values\nare"), None, 14
    DEVIATION = Sentence("Deviation from\nnominal"), "clearance", 11
    TAKEN_AT = Sentence("Taken at"), None, 11

    heading: Sentence
    kind: str | None
    least_width: int

    def __new__(cls, heading: Sentence, kind: str | None, least_width: int) -> Column:
        """Number the columns as they stand here."""
        column = int.__new__(cls, len(cls.__members__))
        column._value_ = len(cls.__members__)
        column.heading, column.kind, column.least_width = heading, kind, least_width
        return column

    @property
    def letter(self) -> str:
        """Return what a spreadsheet calls it."""
        return str(xl_col_to_name(self))

    def said(self, say: Wording) -> str:
        """Return the heading with its unit."""
        return say.sentence(self.heading) + (f" [{say.unit(self.kind)}]" if self.kind else "")

    def width(self, say: Wording) -> int:
        """Return the width in characters: no word of the heading is broken."""
        return max(self.least_width, 1 + max(map(len, self.said(say).split())))


SHEET = Sentence("Measurements")
UNWORN_END = Sentence("unworn end")  # what marks a reading there; the intake's vocabulary knows it in every language
PUMP_SIDE, PUMP_TIP = Sentence("Pump side clearance"), Sentence("Pump tip clearance")  # the intake reads them
REPRESENTATIVE, AS_STATED = Sentence("representative"), Sentence("as stated")
PART_NAMES: Mapping[str, Sentence] = {
    "spool": Sentence("spool"),
    "piston": Sentence("piston"),
    "end plug": Sentence("end plug"),
    "sleeve": Sentence("sleeve"),
}


def formats_of(book: xlsxwriter.Workbook, say: Wording) -> dict[str, Format]:
    """Return the formats for every tab; lengths have as many digits as the reader's unit wants."""
    length = f"0.{'0' * say.digits('length', 3)}"
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
        "note": {**wrapped, "italic": True, "font_size": 8, "font_color": shade["note"]},
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
