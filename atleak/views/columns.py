"""Say what a table's column is called, what it means and how its cells are written, for the reader of one browser.

A page gives rows of plain values in the units of atleak's records, and its columns; language and units follow from
``say``. Headings stand in the texts as ``columns.KEY``, what a column means, where that needs saying, as
``column_help.KEY``; every page's file of texts may add its own to these two tables.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from atleak.wording import Wording

VERDICT = "verdict"


@dataclass(frozen=True)
class Column:
    """A column of a table.

    Parameters
    ----------
    key
        name of the cell in each row, and of the column in the texts
    kind
        kind of quantity, which gives the unit in the heading's brackets; ``"verdict"`` for a verdict or a band; None
        for words, and for numbers without a unit
    digits
        decimal places that the value takes in the unit of atleak's records; None for the usual ones of its kind, and
        for what is no number
    width
        least width [px]; None to let the table choose
    words_of
        kind of quantity that its cells hold as words, such as a range; the heading names the unit
    words
        the heading, where it is no text of its own, such as a verdict's word
    """

    key: str
    kind: str | None = None
    digits: int | None = None
    width: int | None = None
    words: str | None = None
    words_of: str | None = None

    @property
    def is_number(self) -> bool:
        """Tell whether its cells are numbers, to be sorted and set as such."""
        return self.kind != VERDICT and (self.kind is not None or self.digits is not None)

    @property
    def dtype(self) -> str:
        """Return the type of its cells as pandas names it."""
        return "float" if self.is_number else "object"

    def heading(self, say: Wording) -> str:
        """Return the words of its heading, with the unit of its cells: ``Clearance [µm]``."""
        heading = self.words or say(f"columns.{self.key}")
        kind = self.kind if self.is_number else self.words_of
        return heading if kind is None else f"{heading} [{say.unit(kind)}]"

    def help(self, say: Wording) -> str | None:
        """Return what the column means; None where its heading says enough."""
        return say.texts["column_help"].get(self.key)

    def value(self, carried: Any, say: Wording) -> Any:
        """Return the value of a cell in the reader's unit, as exact as it is shown."""
        if carried is None or not self.is_number:
            return carried
        shown = carried if self.kind is None else say.convert(carried, self.kind)
        return round(float(shown), self._places(say))

    def written(self, shown: float | None, say: Wording) -> str:
        """Return the text of a number that `value` returned."""
        return say.number(shown, self._places(say))

    def _places(self, say: Wording) -> int:
        return self.digits or 0 if self.kind is None else say.digits(self.kind, self.digits)
