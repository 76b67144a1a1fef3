"""Knows single loggers by their files, and says of a table what a person would otherwise have to say.

What a logger's files are told by, and how their head, clock and units are, stands in ``loggers.toml``; of all others,
and of what is not said there, the table's own headings and cells tell.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import PurePath

from atleak.common.errors import Place, RoadTestError
from atleak.common.sentences import Sentence
from atleak.common.units import HHMMSS
from atleak.measurements.road_test import QUANTITIES
from atleak.readers.dates import vocabulary
from atleak.readers.logs.headings import Heading, HeadRow, headings_by_rows
from atleak.readers.logs.log_cells import to_float
from atleak.readers.logs.log_table import Layout
from atleak.readers.logs.names import clean_unit, is_unit, match_name, split_unit

_FLAGS = re.IGNORECASE | re.MULTILINE
SHOWN = 1 << 14
"""Bytes of a file that show which logger wrote it."""


@dataclass(frozen=True)
class Logger:
    """What ``loggers.toml`` says of a logger; the file explains its entries."""

    name: str
    known: str = r"\A\Z"
    rows: Sequence[str] = ()
    names: str | None = None
    first: Sequence[str] = ()
    units: str | None = None
    step: int = 1
    spelled: Mapping[str, str] = field(default_factory=dict)
    stated: Mapping[str, str] = field(default_factory=dict)
    means: Mapping[str, str] = field(default_factory=dict)
    clock: str | None = None
    bus: bool = False
    endings: Sequence[str] = ()
    export: str = ""

    def refusal(self, file: str) -> RoadTestError | None:
        """Return the error for a file of it that is not read, with what would be; None for one that is."""
        problem = Sentence("is a log of {logger} in a binary form that is not read", logger=self.name)
        expected = Sentence("the log exported as CSV or text by {program}", program=self.export)
        if self.bus:
            problem = Sentence(
                "is a CAN dump ({form}): turning its frames into quantities needs the car's database (DBC)",
                form=self.name,
            )
            expected = Sentence("the frames decoded with the DBC and saved as CSV, such as by SavvyCAN or CANalyzer")
        return RoadTestError(problem, place=Place(file=file), expected=expected) if self.bus or self.export else None

    def described(self, layout: Layout, head: str, body: Sequence[HeadRow]) -> Layout:
        """Return a table's layout with the names and units that this logger is known to give its columns.

        ``head`` are the lines above the data, ``body`` the first rows.
        """
        headings = self._named_in_head(layout, head) or self._named_by_rows(layout)
        said = [] if headings is None else [Sentence("names and units as its head gives them")]
        result = []
        for heading in headings or layout.headings:
            heading = replace(heading, unit=layout.cell_units.get(heading.index, heading.unit))
            known, fact = self._known(heading, layout, [row[heading.index] for row in body if heading.index < len(row)])
            result.append(known)
            said += [fact] if fact else []
        note = Sentence("read as a log of {logger}", logger=self.name)
        if said:
            note = Sentence("{note}: {facts}", note=note, facts=tuple(dict.fromkeys(said)))
        return replace(layout, headings=tuple(result), has_header=layout.has_header or bool(headings), note=note)

    def _named_in_head(self, layout: Layout, head: str) -> tuple[Heading, ...] | None:
        """Return the headings whose names or units the lines above the table list; None where they do not."""
        units = [clean_unit(self.spelled.get(unit.lower(), unit)) or None for unit in _listed(self.units, head)]
        if self.names is None:
            of_column = {1 + self.step * place: unit for place, unit in enumerate(units)}
            named = (replace(each, unit=each.unit or of_column.get(each.index)) for each in layout.headings)
            return tuple(named) if any(units) else None
        names = [*self.first, *_listed(self.names, head)]
        if None in units:  # whether a blank line stands for a unit is not sure, nor whose unit is below it
            units = []
        if not len(names) <= layout.width <= len(names) + bool(self.first) or len(units) > len(names):
            return None
        rows = [names, [""] * (len(names) - len(units)) + [unit or "" for unit in units]]
        return headings_by_rows(rows[:1], rows[1], [], len(names))

    def _named_by_rows(self, layout: Layout) -> tuple[Heading, ...] | None:
        """Return the headings by the rows above the data, of which it is known what each holds."""
        rows = dict[str, list[HeadRow]]()
        for role, row in zip(self.rows, reversed(layout.header_rows), strict=False):
            rows.setdefault(role, []).insert(0, row)
        names, (units, sources) = rows.get("names"), (rows.get(role, [[]])[0] for role in ("units", "sources"))
        if not names or _names_in(units) > max(map(_names_in, names)):  # a row is missing, or one more is there
            return None
        return headings_by_rows(names, units, sources, layout.width)

    def _known(self, heading: Heading, layout: Layout, cells: Sequence[str]) -> tuple[Heading, Sentence | None]:
        """Return a heading with what is known of the column, and that in words."""
        if self.clock is not None:
            above = (row[heading.index] for row in layout.header_rows if heading.index < len(row))
            if any(re.fullmatch(self.clock, cell, _FLAGS) for cell in above):
                return replace(heading, names=("time",), unit=None), _fact(heading, "time")
            heading = replace(heading, names=tuple(name for name in heading.names if _quantity(name) != "time"))
        fact, meant = None, self.means.get(heading.label)
        if meant is not None:
            heading, fact = replace(heading, names=(meant,)), _fact(heading, meant)
        match = next(filter(None, map(match_name, heading.names)), None)
        unit = self.stated.get(match.quantity) if match and (heading.unit or match.unit) is None else None
        # numbers with 60 seconds or minutes are no digits of a clock
        values = [to_float(cell, ".") % 10_000 for cell in cells] if unit == HHMMSS else []
        if unit is None or any(value % 100 >= 60 or value >= 6000 for value in values):
            return heading, fact
        return replace(heading, unit=unit), Sentence("{column!r} in {unit}", column=heading.label, unit=unit)


def _fact(heading: Heading, quantity: str) -> Sentence:
    return Sentence("{column!r} is {quantity}", column=heading.label, quantity=QUANTITIES[quantity].said)


def _names_in(row: HeadRow) -> int:
    return sum(not is_unit(cell) and _quantity(split_unit(cell).text) is not None for cell in row)


def _quantity(name: str) -> str | None:
    match = match_name(name)
    return match.quantity if match else None


def _listed(pattern: str | None, head: str) -> list[str]:
    """Return what an expression finds in the lines above a table, a line or a cell each."""
    found = re.finditer(pattern, head, _FLAGS) if pattern else ()
    return [cell.strip() for match in found for cell in re.split(r"[\t\n]", match[1].removesuffix("\n"))]


@cache
def _loggers() -> tuple[Logger, ...]:
    return tuple(Logger(**entry) for entry in vocabulary("atleak.readers.logs", "loggers.toml").values())


def known_logger(head: str) -> Logger | None:
    """Return the logger that wrote a file, by its first characters; None where it is none that is known."""
    return next((logger for logger in _loggers() if head and re.search(logger.known, head, _FLAGS)), None)


def logger_by_name(file: str) -> Logger | None:
    """Return the logger whose binary files are called so."""
    ending = PurePath(file).suffix.lower()
    return next((logger for logger in _loggers() if ending in logger.endings), None)
