"""Collect what the rows of a workbook say about a valve body, and remember which cell each value stood in."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from difflib import SequenceMatcher
from typing import Any, NamedTuple

from atleak.errors import InputError, Steps, nearest_name, one_of
from atleak.sentence import Sentence

_SURELY = 0.85  # how alike two names are of which one is a slip of the pen


class Spot(NamedTuple):
    """A cell of the workbook: sheet by the name it is declared with, row as numbered there, column by its heading."""

    sheet: str
    row: int | None = None
    heading: str | None = None


@dataclass(frozen=True)
class Fault:
    """What is wrong with a cell, row or sheet."""

    spot: Spot
    problem: Sentence
    value: Any = None
    expected: Sentence | None = None
    nearest: str | None = None

    @property
    def text(self) -> Sentence:
        """Return what is wrong, without where."""
        return InputError(self.problem, value=self.value, expected=self.expected, nearest=self.nearest).sentence


@dataclass(frozen=True)
class Row:
    """A row that holds something: what stands in its cells, and the values of those that could be read."""

    spot: Spot  # without a heading
    cells: Mapping[str, Any]  # by heading, those that are not empty
    values: Mapping[str, Any]  # in the units of the controller's file
    absent: frozenset[str] = frozenset()  # needed columns that the sheet does not have: a fault of its own

    def at(self, heading: str | None) -> Spot:
        """Return one of its cells."""
        return Spot(self.spot.sheet, self.spot.row, heading)


@dataclass
class Description:
    """A valve body as a workbook describes it: the tables of its file, and what was wrong on the way there."""

    data: dict[str, Any] = field(default_factory=dict)
    faults: list[Fault] = field(default_factory=list)
    notes: list[Sentence] = field(default_factory=list)  # what was taken for granted, in sentences
    spots: dict[Steps, Spot] = field(default_factory=dict)
    unread: set[Steps] = field(default_factory=set)  # values left out because their cell has a fault already

    def mark(self, steps: Steps, spot: Spot) -> None:
        """Remember the cell of a value; the first cell of what several make up is the one that counts."""
        self.spots.setdefault(steps, spot)

    def spot(self, steps: Steps) -> Spot | None:
        """Return the cell of a value, or of the smallest table around it that has one."""
        for length in range(len(steps), 0, -1):
            if steps[:length] in self.spots:
                return self.spots[steps[:length]]
        return None

    def is_unread(self, steps: Steps) -> bool:
        """Return whether a value, or the table around it, was left out because of a fault that is reported already."""
        return any(steps[:length] in self.unread for length in range(1, len(steps) + 1))

    def table(self, at: Steps) -> dict[str, Any]:
        """Return the table at these steps, made where it is missing."""
        table = self.data
        for step in at:
            table = table.setdefault(str(step), {})
        return table

    def entries(self, key: str) -> list[dict[str, Any]]:
        """Return the list of tables under a key, made where it is missing."""
        listed: list[dict[str, Any]] = self.data.setdefault(key, [])
        return listed

    def fault(self, row: Row, heading: str | None, problem: Sentence, expected: Sentence | None = None) -> None:
        """Report a cell."""
        cell = row.cells.get(heading) if heading else None
        self.faults.append(Fault(row.at(heading), problem, cell, expected))

    def unknown(self, row: Row, heading: str, problem: Sentence, known: Sequence[str]) -> str | None:
        """Report a name that is none of those known; return the one that was surely meant, if any."""
        cell = row.cells.get(heading)
        nearest = None if cell is None else nearest_name(str(cell), known)
        self.faults.append(Fault(row.at(heading), problem, cell, one_of(known), nearest))
        alike = 0.0 if nearest is None else SequenceMatcher(None, str(cell), nearest).ratio()
        return nearest if alike >= _SURELY else None
