"""Read tables with a value on each row, its unit behind it, beside it or over it; and say what cannot be read.

Tables of gauge readings and vacuum tests share this. Those of flows that were caught in a jug are nothing else: each
row has the operating point, what flowed (the cooler, or a consumer of the valve body's file), and how much, as
``3.8 l/min``, ``946 ml/15 s``, ``1 qt in 20 s`` or ``1.0 gpm``; see ``docs/vacuum-and-flows.md``.
"""

from __future__ import annotations

import datetime as dt
import hashlib
import re
from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product
from pathlib import Path

from atleak.catalogue.controller import Controller
from atleak.catalogue.written_numbers import AskedNumber, WrittenNumber, possible_values, read_number
from atleak.common.damage import own_errors_only
from atleak.common.errors import FlowTableError, InputError, Message, Place, nearest_name, one_of
from atleak.common.file_faults import faults_together
from atleak.common.sentences import Sentence
from atleak.common.translations import languages
from atleak.common.units import Unit, find_unit, unit, unit_names
from atleak.common.wording import wording
from atleak.measurements.flow_readings import FlowReading, FlowTable
from atleak.measurements.own_forms import FLOWS, OwnForm
from atleak.readers.cells.extent import FAULTS
from atleak.readers.cells.sheet import BRACKETS, Cell, Sheet, text_of
from atleak.readers.cells.sheet_file import open_sheets
from atleak.readers.dates import vocabulary, words
from atleak.readers.gauges.gauge_headings import is_blank_heading
from atleak.readers.own_forms import form_doubts, form_tables

_NUMBER_AND_UNIT = re.compile(r"([\d\s.,+\-−'’]*\d[.,]?)\s*([^\d.,\s+\-−'’].*)", re.DOTALL)
_SEARCHED = 60  # rows in which the headings are looked for
VALUE_WORDS = "value_vocabulary.toml"


@dataclass
class Faults:
    """What of a file cannot be read, and what was assumed or left aside."""

    error: type[InputError]
    problems: list[InputError] = field(default_factory=list)
    messages: list[Message] = field(default_factory=list)

    def refuse(
        self,
        problem: Sentence,
        place: Place,
        value: object = None,
        accepted: Sequence[str] = (),
        expected: Sentence | None = None,
        once: bool = False,
    ) -> None:
        """Note a problem, ``once`` at its place; ``accepted`` are the names that would have been valid."""
        if once and any(each.place == place for each in self.problems):
            return
        nearest = nearest_name(str(value), accepted) if accepted and value is not None else None
        wanted = expected or one_of(accepted)
        self.problems.append(self.error(problem, place=place, value=value, expected=wanted, nearest=nearest))

    def holds(self, sheet: Sheet, row: int, column: int, place: Place) -> bool:
        """Return whether something stands in a cell: what is crossed out does not, and a message says so."""
        if is_blank_heading(sheet.cell(row, column)) and (row, column) not in sheet.faults:
            return False
        if sheet.is_struck(row, column):
            text = Sentence("{found} is crossed out: not read", found=text_of(sheet.cell(row, column)))
            self.messages.append(Message("info", "struck_left_aside", text, place))
            return False
        return True


def is_number(cell: Cell) -> bool:
    """Return whether a cell is a number, or text that can be one."""
    return isinstance(cell, int | float) or bool(possible_values(str(cell)))


def not_typed_as_number(cell: Cell) -> bool:
    """Return whether a cell holds what a spreadsheet makes of something else that was typed: a date, a time, a yes."""
    return isinstance(cell, bool | dt.date | dt.time | dt.timedelta)


def split_cell(cell: Cell) -> tuple[str, str]:
    """Return a cell's number as text, and what stands behind it.

    >>> split_cell("4,5 bar"), split_cell(450.0), split_cell("946 ml/15 s")
    (('4,5', 'bar'), ('450.0', ''), ('946', 'ml/15 s'))
    """
    match = _NUMBER_AND_UNIT.fullmatch(str(cell).strip())
    return (match[1], match[2].strip()) if match and isinstance(cell, str) else (str(cell).strip(), "")


def written_in_cell(cell: Cell, text: str, asked: AskedNumber) -> WrittenNumber:
    """Return the number of a cell: a number is itself, text is read as people write numbers."""
    if not isinstance(cell, int | float):
        return read_number(text, asked)
    low, high = asked.limits
    if low <= cell <= high:
        return WrittenNumber(float(cell))
    return WrittenNumber(None, Sentence("{low:g} to {high:g} {unit}", low=low, high=high, unit=asked.unit))


def in_si(cell: Cell, asked: AskedNumber, kind: str, stated: Unit | None) -> WrittenNumber:
    """Return a cell's value in SI; its unit stands behind it, is ``stated`` elsewhere, or is the one asked for.

    Without a value the reason is what was expected.
    """
    usual = unit(asked.unit, kind)
    text, written = split_cell(cell)
    shown = find_unit(written, kind) if written else (stated or usual)
    if shown is not None and not not_typed_as_number(cell):
        low, high = (shown.from_si(usual.to_si(end)) for end in asked.limits)
        number = written_in_cell(cell, text, AskedNumber(asked.name, shown.name, asked.example, (low, high)))
        if number.value is not None:
            return WrittenNumber(float(shown.to_si(number.value)))
        if len(possible_values(text)) > 1:
            return number
    elif written:
        units = one_of(unit_names(kind))
        return WrittenNumber(None, Sentence("a number, and behind it nothing or {units}", units=units))
    low, high = asked.limits
    return WrittenNumber(None, Sentence("{low:g} to {high:g} {unit}", low=low, high=high, unit=asked.unit))


# --- a table of rows, its columns named ------------------------------------------------------------------------------


def phrases(table: str) -> Mapping[str, str]:
    """Return the phrases of a table of the vocabulary, each with the name under which it stands."""
    listed = vocabulary(__package__, VALUE_WORDS)[table]
    return {phrase: name for name, each in listed.items() for phrase in each}


def label_of(cell: Cell, table: str) -> str | None:
    """Return what a cell names in a table of the vocabulary, a unit in brackets left out; None where nothing.

    >>> label_of("Düse [mm]", "vacuum_columns"), label_of("Unterdruck:", "vacuum_columns")
    ('orifice', 'reading')
    """
    if not isinstance(cell, str):
        return None
    return phrases(table).get(words(BRACKETS.sub(" ", cell)))


@dataclass(frozen=True)
class ValueTable:
    """A table on a sheet: what each of its columns holds, and where its rows begin."""

    sheet: Sheet
    columns: Mapping[str, int]
    row: int | None = None  # of the headings; None without any: the columns have their usual order

    def place(self, row: int, column: int | None = None) -> Place:
        """Return where a cell is."""
        headed = column is not None and self.row is not None and row > self.row
        heading = text_of(self.sheet.filled(self.row or 0, column or 0)) if headed else ""
        return self.sheet.place(row, column, heading)

    def cell(self, row: int, kind: str) -> Cell:
        """Return what a row says in the column of a kind; "" where it says nothing, or there is no such column."""
        column = self.columns.get(kind)
        cell = "" if column is None else self.sheet.filled(row, column)
        return "" if is_blank_heading(cell) or (column is not None and self.sheet.is_struck(row, column)) else cell

    def place_of(self, row: int, kind: str) -> Place:
        """Return the place of the cell in the column of a kind."""
        return self.place(row, self.columns.get(kind))

    def unit_over(self, column: int | None) -> str:
        """Return the unit in the brackets of a column's heading, whether or not there is such a unit."""
        if self.row is None or column is None:
            return ""
        inside = BRACKETS.search(text_of(self.sheet.filled(self.row, column)))
        return inside[1].strip() if inside else ""

    def value(
        self,
        rows: Faults,
        row: int,
        kind: str,
        asked: AskedNumber,
        of: str,
        usual: Unit | None = None,
        unit_beside: bool = False,
        changed: Callable[[Cell], Cell] = lambda cell: cell,
    ) -> float | None:
        """Return a row's value in SI; None where it is a problem.

        Parameters
        ----------
        asked
            the number in its usual unit, with its limits.
        usual
            unit where none is stated: None refuses such a value.
        unit_beside
            whether a column ``unit`` says the unit of these values.
        changed
            what a cell is taken as.
        """
        place, cell = self.place_of(row, kind), changed(self.cell(row, kind))
        fault = self.sheet.faults.get((row, self.columns.get(kind, -1)))
        if fault is not None:
            rows.refuse(Sentence("a formula without a usable result"), place, fault, expected=Sentence("a number"))
            return None
        stated = (text_of(self.cell(row, "unit")) if unit_beside else "") or self.unit_over(self.columns.get(kind))
        if split_cell(cell)[1]:
            known = None
        elif stated:
            known = find_unit(stated, of)
            if known is None:
                rows.refuse(Sentence("unknown unit"), place, stated, expected=one_of(unit_names(of)), once=True)
                return None
        else:
            known = usual
            if known is None and is_number(cell):
                expected = Sentence("{units}, behind the number or in a column of units", units=one_of(unit_names(of)))
                rows.refuse(Sentence("no unit stands with this value"), place, text_of(cell), expected=expected)
                return None
        number = in_si(cell, asked, of, known)
        if number.value is None:
            rows.refuse(
                Sentence("not accepted as {name}", name=asked.name), place, text_of(cell), expected=number.reason
            )
        return number.value


def first_cell(sheet: Sheet, row: int) -> tuple[Cell, int]:
    """Return the first cell of a row that holds anything, with its column; "" in an empty row."""
    filled = ((cell, column) for column, cell in enumerate(sheet.rows[row]) if not is_blank_heading(cell))
    return next(filled, ("", 0))


@dataclass(frozen=True)
class ValueFinder:
    """Finds the tables of one kind.

    Parameters
    ----------
    form
        of atleak's own, in which such a table is written
    table
        of the vocabulary, which says what the headings mean
    needed
        kinds of columns that its headings must name
    order
        of the columns, where no row holds headings
    begins
        tells whether a cell is what the first of a row of the table may be
    """

    form: OwnForm
    table: str
    needed: Sequence[str]
    order: Sequence[str]
    begins: Callable[[Cell], bool]

    def find(self, sheet: Sheet) -> ValueTable | None:
        """Return the table of a sheet; None where there is none."""
        if (own := form_tables(sheet, self.form)) is not None:
            return ValueTable(sheet, own[0].columns, own[0].row) if own else None
        for row in range(min(len(sheet.rows), _SEARCHED)):
            columns: dict[str, int] = {}
            for column in range(sheet.width):
                kind = label_of(sheet.filled(row, column), self.table)
                if kind is not None:
                    columns.setdefault(kind, column)
            if columns.keys() >= set(self.needed):
                return ValueTable(sheet, columns, row)
        return ValueTable(sheet, {kind: at for at, kind in enumerate(self.order)}) if self.rows_of(sheet) else None

    def rows_of(self, sheet: Sheet) -> int:
        """Count the rows of a sheet that begin as those of the table."""
        rows = range(len(sheet.rows))
        return sum(len(sheet.rows[row]) > 1 and self.begins(first_cell(sheet, row)[0]) for row in rows)

    def likeness(self, sheet: Sheet) -> float:
        """Return how much of a sheet is understood as such a table: of a text, whether it is split the right way."""
        table = self.find(sheet)
        if table is None:
            return 0.0
        return float(len(table.columns) if table.row is not None else 1) + min(self.rows_of(sheet), 20)


@dataclass(frozen=True)
class ValueFile:
    """A file's tables of one kind, at least one."""

    file: str
    sha256: str
    tables: Sequence[ValueTable]

    @classmethod
    def open(
        cls,
        source: str | Path | bytes,
        name: str | None,
        finder: ValueFinder,
        missing: InputError,
        wanted: Sentence,
    ) -> ValueFile:
        """Open a file; ``missing`` is raised, naming it, where no sheet that is shown holds such a table.

        Parameters
        ----------
        wanted
            the kinds of file that can be read.
        """
        data, file, sheets = open_sheets(source, name, finder.likeness, type(missing), wanted)
        found = (finder.find(sheet) for sheet in sheets if not sheet.hidden)
        tables = [table for table in found if table is not None]
        if not tables:
            missing.rename_file(lambda _: file)
            raise missing
        return cls(file, hashlib.sha256(data).hexdigest(), tables)

    @property
    def sheet(self) -> str | None:
        """Return the names of its sheets; None of a text."""
        return ", ".join(table.sheet.name for table in self.tables if table.sheet.name) or None

    @property
    def notes(self) -> tuple[Message, ...]:
        """Return how a text was read."""
        notes = dict.fromkeys(table.sheet.note for table in self.tables if table.sheet.note)
        read_as = (Message("info", "read_as", note, Place(self.file)) for note in notes)
        return (*read_as, *form_doubts(table.sheet for table in self.tables))


# --- flows

_FLOW = AskedNumber(Sentence("flow"), "l/min", 3.8, (0.0, 100.0))
_ORDER = ("condition", "what", "value", "unit")
_WANTED = Sentence("a table of flows as .xlsx workbook or .csv text")
_HEADINGS = Sentence("headings: condition, what, value, unit; and below them such as: hot_idle, cooler, 946, ml/15 s")


@dataclass
class _Flows(Faults):
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


def _read(table: ValueTable, names: _Names, rows: _Flows) -> None:
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


def _named(table: ValueTable, row: int, kind: str, names: Mapping[str, str], rows: _Flows) -> str | None:
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
    rows = _Flows()
    for table in held.tables:
        _read(table, names, rows)
    if rows.problems:
        raise faults_together(rows.problems)
    if not rows.readings:
        problem, expected = Sentence("no flow is filled in"), Sentence("at least one flow")
        raise FlowTableError(problem, place=Place(held.file), expected=expected)
    return FlowTable(held.file, held.sha256, held.sheet, tuple(rows.readings), (*held.notes, *rows.messages))
