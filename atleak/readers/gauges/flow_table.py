"""A table of flows that were caught in a jug (workbook or text) → readings, each with its place.

Each row has the operating point, what flowed (the cooler, or a consumer of the valve body's file), and how much, as
``3.8 l/min``, ``946 ml/15 s``, ``1 qt in 20 s`` or ``1.0 gpm``; see ``docs/vacuum-and-flows.md``.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import product
from pathlib import Path

from atleak.catalogue.controller import Controller
from atleak.catalogue.written_numbers import AskedNumber
from atleak.common.damage import own_errors_only
from atleak.common.errors import FlowTableError, InputError, Place
from atleak.common.file_faults import faults_together
from atleak.common.sentences import Sentence
from atleak.common.translations import languages
from atleak.common.wording import wording
from atleak.measurements.flow_readings import FlowReading, FlowTable
from atleak.measurements.own_forms import FLOWS
from atleak.readers.cells.extent import FAULTS
from atleak.readers.cells.sheet import Cell, text_of
from atleak.readers.dates import words
from atleak.readers.gauges.value_table import Faults, ValueFile, ValueFinder, ValueTable, first_cell, phrases

_FLOW = AskedNumber(Sentence("flow"), "l/min", 3.8, (0.0, 100.0))
_ORDER = ("condition", "what", "value", "unit")
_WANTED = Sentence("a table of flows as .xlsx workbook or .csv text")
_HEADINGS = Sentence("headings: condition, what, value, unit; and below them such as: hot_idle, cooler, 946, ml/15 s")


@dataclass
class _Rows(Faults):
    """What the rows of all tables give."""

    error: type[InputError] = FlowTableError
    readings: list[FlowReading] = field(default_factory=list)


@dataclass(frozen=True)
class _Names:
    """The operating points and consumers that a table may name, each by every way to write it."""

    conditions: Mapping[str, str]
    consumers: Mapping[str, str]

    @classmethod
    def of(cls, controller: Controller) -> _Names:
        """Return the names of a valve body's file, in every language; of points also without their temperature."""
        conditions, consumers = defaultdict[str, set[str]](set), dict[str, str](phrases("flow_of"))
        for language, units in product(languages(), ("metric", "us")):
            say = wording(language, units)
            for point in controller.operating_points:
                label = say.name(point.label)
                bare = label.removesuffix(f", {point.temperature:g} °C")
                for name in (point.name, label, bare, say.condition(point)):
                    conditions[words(name)].add(point.name)
            for consumer in controller.consumers:
                consumers |= dict.fromkeys((words(consumer.id), words(say.name(consumer.name))), consumer.id)
        return cls({name: each.pop() for name, each in conditions.items() if len(each) == 1}, consumers)

    def begins(self, cell: Cell) -> bool:
        """Return whether a cell names an operating point."""
        return isinstance(cell, str) and words(cell) in self.conditions


def _read(table: ValueTable, names: _Names, rows: _Rows) -> None:
    """Read every row that holds a value."""
    value = table.columns["value"]
    for row in range(0 if table.row is None else table.row + 1, len(table.sheet.rows)):
        if len(rows.problems) > FAULTS:
            return
        if table.row is None and not names.begins(first_cell(table.sheet, row)[0]):
            continue
        if not rows.holds(table.sheet, row, value, table.place(row, value)):
            continue
        condition = _named(table, row, "condition", names.conditions, rows)
        what = _named(table, row, "what", names.consumers, rows)
        flow = table.value(rows, row, "value", _FLOW, "flow", unit_beside=True)
        if condition is not None and what is not None and flow is not None:
            rows.readings.append(FlowReading(condition, what, flow, table.place(row, value)))


def _named(table: ValueTable, row: int, kind: str, names: Mapping[str, str], rows: _Rows) -> str | None:
    """Return what a cell names; None where that is a problem."""
    text = text_of(table.cell(row, kind))
    known = names.get(words(text))
    if known is None:
        place, accepted = table.place_of(row, kind), tuple(dict.fromkeys(names.values()))
        problem = _NOT_UNDERSTOOD[kind][bool(text)]
        rows.refuse(problem, place, text or None, accepted)
    return known


_NOT_UNDERSTOOD = {  # what is said of an empty cell, and of one that names nothing known
    "condition": (Sentence("no operating point in this row"), Sentence("no such operating point of this unit")),
    "what": (Sentence("nothing says what flowed in this row"), Sentence("no such consumer of this unit")),
}


def flow_finder(controller: Controller) -> ValueFinder:
    """Return what finds tables of flows."""
    return ValueFinder(FLOWS, "flow_columns", ("condition", "what", "value"), _ORDER, _Names.of(controller).begins)


@own_errors_only(FlowTableError, "name", "source")
def read_flow_table(source: str | Path | bytes, controller: Controller, *, name: str | None = None) -> FlowTable:
    """Return the flows of a table.

    Parameters
    ----------
    source, name
        as `atleak.read_pressure_table` takes them.
    controller
        whose operating points and consumers the rows name.

    Returns
    -------
    FlowTable
        flows in m³/s, each with its place in the file.

    Raises
    ------
    FlowTableError
        with all problems found: an unknown operating point, consumer or unit, a cell that is no flow; or where the
        file as a whole holds no such table, or none filled in.
    """
    names = _Names.of(controller)
    missing = FlowTableError(Sentence("holds no table of flows"), expected=_HEADINGS)
    held = ValueFile.open(source, name, flow_finder(controller), missing, _WANTED)
    rows = _Rows()
    for table in held.tables:
        _read(table, names, rows)
    if rows.problems:
        raise faults_together(rows.problems)
    if not rows.readings:
        problem, expected = Sentence("no flow is filled in"), Sentence("at least one flow")
        raise FlowTableError(problem, place=Place(held.file), expected=expected)
    return FlowTable(held.file, held.sha256, held.sheet, tuple(rows.readings), (*held.notes, *rows.messages))
