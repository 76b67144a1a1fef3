"""The columns of a measuring sheet's table, in their order."""

from __future__ import annotations

from enum import IntEnum

from xlsxwriter.utility import xl_col_to_name

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
