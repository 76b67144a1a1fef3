"""Read tables of values under headings: each form declares its columns, and every fault is listed with its place.

Tables of gauge readings, vacuum tests, flows and gauge studies share this. Those of flows that were caught in a jug are
nothing else: each row has the operating point, what flowed (the cooler, or a consumer of the valve body's file), and
how much, as ``3.8 l/min``, ``946 ml/15 s``, ``1 qt in 20 s`` or ``1.0 gpm``; see ``docs/vacuum-and-flows.md``.
"""

from __future__ import annotations

import datetime as dt
import hashlib
import re
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from itertools import product
from pathlib import Path
from typing import Any, Generic, NamedTuple, TypeVar

from atleak.catalogue.controller import Controller
from atleak.catalogue.written_numbers import AskedNumber, possible_values, read_number
from atleak.common.damage import own_errors_only
from atleak.common.errors import FlowTableError, InputError, Message, Place, ReadingsError, nearest_name, one_of
from atleak.common.file_faults import faults_together
from atleak.common.sentences import Sentence
from atleak.common.translations import languages
from atleak.common.units import Unit, find_unit, unit, unit_names
from atleak.common.wording import wording
from atleak.measurements.flow_readings import FlowReading, FlowTable
from atleak.measurements.own_forms import FLOWS, OwnForm
from atleak.readers.cells.extent import FAULTS
from atleak.readers.cells.sheet import BRACKETS, Cell, Sheet, text_of
from atleak.readers.cells.sheet_file import read_bytes, read_sheets
from atleak.readers.dates import vocabulary, words
from atleak.readers.own_forms import form_doubts, form_tables

_NUMBER_AND_UNIT = re.compile(r"([\d\s.,+\-−'’]*\d[.,]?)\s*([^\d.,\s+\-−'’].*)", re.DOTALL)
_NOTHING = frozenset(("", "-", "–", "—", "−", "/", "x", "?", "…", "..."))
SEARCHED = 60  # rows in which the headings are looked for


@cache
def phrases(table: str) -> Mapping[str, str]:
    """Return the phrases of a table of the vocabulary, each with the name under which it stands."""
    listed = vocabulary(__package__, "vocabulary.toml")[table]
    return {phrase: name for name, each in listed.items() for phrase in each}


def label_of(cell: Cell, table: str) -> str | None:
    """Return what a cell names in a table of the vocabulary, a unit in brackets left out; None where nothing.

    >>> label_of("Düse [mm]", "vacuum_columns"), label_of("Unterdruck:", "vacuum_columns")
    ('orifice', 'reading')
    """
    return phrases(table).get(words(BRACKETS.sub(" ", cell))) if isinstance(cell, str) else None


def is_nothing(cell: Cell) -> bool:
    """Return whether a cell says that nothing was measured: it is empty, a dash, or says so in words."""
    if not isinstance(cell, str):
        return cell is None
    return cell.strip() in _NOTHING or words(cell) in phrases("not_measured")


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


def unit_in(label: str) -> str:
    """Return what stands in the brackets of a label; "" without any."""
    inside = BRACKETS.search(label)
    return inside[1].strip() if inside else ""


def first_cell(sheet: Sheet, row: int) -> tuple[Cell, int]:
    """Return the first cell of a row that holds anything, with its column; "" in an empty row."""
    filled = ((cell, column) for column, cell in enumerate(sheet.rows[row]) if not is_nothing(cell))
    return next(filled, ("", 0))


def asked_in(asked: AskedNumber, shown: Unit, of: str) -> AskedNumber:
    """Return what is asked for in another unit of its kind."""
    usual = unit(asked.unit, of)
    example, low, high = (float(shown.from_si(usual.to_si(each))) for each in (asked.example, *asked.limits))
    return AskedNumber(asked.name, shown.name, float(f"{example:.4g}"), (low, high))


class Amount(NamedTuple):
    """A number that was read: its value in SI, of a temperature in °C, and the unit in which it was written."""

    si: float
    unit: Unit


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

    def settle(self) -> None:
        """Raise the problems, if any, in the order in which they stand in the file."""
        if self.problems:
            raise faults_together(sorted(self.problems, key=lambda each: (each.place.sheet or "", each.place.row or 0)))

    def number(
        self,
        cell: Cell,
        place: Place,
        asked: AskedNumber,  # in any unit of its kind, with its limits
        of: str,  # kind of quantity
        said: tuple[str, Place],  # the unit that is stated for the cell, "" for none, and where
        usual: Unit | None = None,  # where none is stated: None refuses such a number
        problem: Sentence | None = None,  # of a cell that is no such number
    ) -> Amount | None:
        """Return the number of a cell, in the unit behind it or that which is stated; None where it is a problem."""
        text, behind = split_cell(cell)
        name, where = (behind, place) if behind else said
        shown = find_unit(name, of) if name else usual
        expected: Sentence | None
        if not_typed_as_number(cell):
            expected = Sentence("a number: format the cell as number or text and type it again")
        elif shown is None and is_number(text):
            expected = one_of(unit_names(of))
            if not name:
                expected = Sentence(
                    "{units}, behind the number, in its heading or in a column of units", units=expected
                )
            problem = Sentence("unknown unit") if name else Sentence("no unit stands with this value")
            found = text_of(cell) if where == place else name or None
            self.refuse(problem, where, found, expected=expected, once=True)
            return None
        else:
            shown = shown or unit(asked.unit, of)
            asked = asked_in(asked, shown, of)
            low, high = asked.limits
            values = (float(cell),) if isinstance(cell, int | float) else possible_values(text)
            possible = [value for value in values if low <= value <= high]
            if len(possible) == 1:
                return Amount(float(shown.to_si(possible[0])), shown)
            expected = read_number(text, asked).reason
            if not possible:
                limits = {"low": low, "high": high, "unit": shown.name, "example": asked.example}
                expected = Sentence("{low:g} to {high:g} {unit}, such as {example:g}", **limits)
        problem = problem or Sentence("not accepted as {name}", name=asked.name)
        self.refuse(problem, place, text_of(cell), expected=expected)
        return None


@dataclass(frozen=True)
class ValueTable:
    """A table on a sheet: which column says what of a row, and what each column of values says of those in it."""

    sheet: Sheet
    columns: Mapping[str, int]
    values: Mapping[int, Any]
    row: int = -1  # of the headings; -1 without any: the columns have their usual order
    last: int | None = None  # row; None for the last of the sheet

    @property
    def rows(self) -> range:
        """Return the rows below the headings."""
        return range(self.row + 1, len(self.sheet.rows) if self.last is None else self.last + 1)

    def heading(self, column: int | None) -> str:
        """Return the heading of a column."""
        return "" if self.row < 0 or column is None else text_of(self.sheet.filled(self.row, column))

    def place(self, row: int, column: int | None = None) -> Place:
        """Return where a cell is."""
        return self.sheet.place(row, column, self.heading(column) if row >= self.row else "")

    def place_of(self, row: int, kind: str) -> Place:
        """Return the place of the cell in the column of a kind."""
        return self.place(row, self.columns.get(kind))

    def cell(self, row: int, kind: str) -> Cell:
        """Return what a row says in the column of a kind; "" where it says nothing, or there is no such column."""
        column = self.columns.get(kind)
        cell = "" if column is None else self.sheet.filled(row, column)
        return "" if is_nothing(cell) or (column is not None and self.sheet.is_struck(row, column)) else cell

    def filled(self, rows: Iterable[int], faults: Faults) -> Iterator[tuple[int, list[int]]]:
        """Yield the rows that hold values, each with the columns of these, until there are too many faults."""
        for row in rows:
            if len(faults.problems) > FAULTS:
                return
            columns = [column for column in self.values if self._holds(row, column, faults)]
            if columns:
                yield row, columns

    def _holds(self, row: int, column: int, faults: Faults) -> bool:
        """Return whether something stands in a cell: what is crossed out does not, and a message says so."""
        if is_nothing(self.sheet.cell(row, column)) and (row, column) not in self.sheet.faults:
            return False
        if not self.sheet.is_struck(row, column):
            return True
        text = Sentence("{found} is crossed out: not read", found=text_of(self.sheet.cell(row, column)))
        faults.messages.append(Message("info", "struck_left_aside", text, self.place(row, column)))
        return False

    def unit_over(self, column: int) -> str:
        """Return the unit that stands in a column's heading, whether or not there is such a unit; "" for none."""
        return unit_in(self.heading(column))

    def unit_said(self, row: int, column: int) -> tuple[str, Place]:
        """Return the unit that is stated for a cell, and where: in the row of a value, else over its column."""
        beside = text_of(self.cell(row, "unit")) if column in self.values else ""
        if beside:
            return beside, self.place_of(row, "unit")
        return self.unit_over(column), self.place(row if self.row < 0 else self.row, column)

    def number(
        self,
        faults: Faults,
        row: int,
        column: int,
        asked: AskedNumber,
        of: str,
        usual: Unit | None = None,
        problem: Sentence | None = None,
        change: Callable[[Cell], Cell] = lambda cell: cell,  # makes of the cell what is read of it
    ) -> Amount | None:
        """Return the number of a cell as `Faults.number` does, with the unit of its row or its column."""
        place = self.place(row, column)
        if (row, column) in self.sheet.faults:
            found = self.sheet.faults[row, column]
            faults.refuse(Sentence("a formula without a usable result"), place, found, expected=Sentence("a number"))
            return None
        said = self.unit_said(row, column)
        return faults.number(change(self.sheet.filled(row, column)), place, asked, of, said, usual, problem)


_Table = TypeVar("_Table", bound=ValueTable)


@dataclass(frozen=True)
class ValueFinder:
    """Finds the tables of one kind."""

    form: OwnForm  # in which atleak itself writes such a table
    table: str  # of the vocabulary, which says what the headings mean
    needed: Sequence[str]  # kinds of columns that its headings must name, that of the values last
    order: Sequence[str]  # of the columns, where no row holds headings
    begins: Callable[[Cell], bool]  # tells whether a cell is what the first of a row of the table may be

    def find(self, sheet: Sheet) -> list[ValueTable]:
        """Return the table of a sheet, if there is one."""
        if (own := form_tables(sheet, self.form)) is not None:
            return [self._table(sheet, each.columns, each.row) for each in own[:1]]
        for row in range(min(len(sheet.rows), SEARCHED)):
            kinds = [label_of(sheet.filled(row, column), self.table) for column in range(sheet.width)]
            if set(self.needed) <= set(kinds):
                return [self._table(sheet, {kind: kinds.index(kind) for kind in kinds if kind}, row)]
        return [self._table(sheet, {kind: at for at, kind in enumerate(self.order)})] if self.rows_of(sheet) else []

    def _table(self, sheet: Sheet, columns: Mapping[str, int], row: int = -1) -> ValueTable:
        return ValueTable(sheet, columns, {columns[self.needed[-1]]: None}, row)

    def rows_of(self, sheet: Sheet) -> int:
        """Count the rows of a sheet that begin as those of the table."""
        rows = range(len(sheet.rows))
        return sum(len(sheet.rows[row]) > 1 and self.begins(first_cell(sheet, row)[0]) for row in rows)

    def likeness(self, sheet: Sheet) -> float:
        """Return how much of a sheet is understood as such a table: of a text, whether it is split the right way."""
        tables = self.find(sheet)
        headed = sum(len(table.columns) if table.row >= 0 else 1 for table in tables)
        return float(headed + min(self.rows_of(sheet), 20)) if tables else 0.0


@dataclass(frozen=True)
class ValueFile(Generic[_Table]):
    """A file's tables of one kind."""

    file: str
    sha256: str
    tables: Sequence[_Table]

    @classmethod
    def open(
        cls,
        source: str | Path | bytes,
        name: str | None,
        find: Callable[[Sheet], Sequence[_Table]],
        likeness: Callable[[Sheet], float],  # how much of a sheet is understood as such a table
        missing: InputError,
        wanted: Sentence,  # the kinds of file that can be read
        sheet: str | None = None,  # the one to look at; all by default
    ) -> ValueFile[_Table]:
        """Open a file; ``missing`` is raised, naming it, where no sheet that is shown holds such a table."""
        try:
            data, file = read_bytes(source, name)
            sheets = read_sheets(data, file, likeness)
        except ReadingsError as error:
            raise type(missing)(error.problem, place=error.place, value=error.value, expected=wanted) from error
        shown = [each for each in sheets if not each.hidden]
        if sheet is not None and not any(each.name == sheet for each in shown):
            names = one_of(repr(each.name) for each in shown)
            raise type(missing)(Sentence("no such sheet"), place=Place(file), value=sheet, expected=names)
        tables = [table for each in shown if sheet in (None, each.name) for table in find(each)]
        if not tables:
            missing.rename_file(lambda _: file)
            raise missing
        return cls(file, hashlib.sha256(data).hexdigest(), tables)

    @property
    def sheet(self) -> str | None:
        """Return the names of its sheets; None of a text."""
        return ", ".join(dict.fromkeys(table.sheet.name for table in self.tables if table.sheet.name)) or None

    @property
    def notes(self) -> tuple[Message, ...]:
        """Return how a text was read."""
        notes = dict.fromkeys(table.sheet.note for table in self.tables if table.sheet.note)
        read_as = (Message("info", "read_as", note, Place(self.file)) for note in notes)
        return (*read_as, *form_doubts(table.sheet for table in self.tables))


_FLOW = AskedNumber(Sentence("flow"), "l/min", 3.8, (0.0, 100.0))
_ORDER = ("condition", "what", "value", "unit")
_WANTED = Sentence("a table of flows as .xlsx workbook or .csv text")
_HEADINGS = Sentence("headings: condition, what, value, unit; and below them such as: hot_idle, cooler, 946, ml/15 s")
_NOT_UNDERSTOOD = {  # what is said of an empty cell, and of one that names nothing known
    "condition": (Sentence("no operating point in this row"), Sentence("no such operating point of this unit")),
    "what": (Sentence("nothing says what flowed in this row"), Sentence("no such consumer of this unit")),
}


def _names(controller: Controller) -> dict[str, dict[str, str]]:
    """Return the operating points and consumers that a table may name, each by every way to write it.

    They are those of a valve body's file, in every language; points also without their temperature.
    """
    conditions, consumers = defaultdict[str, set[str]](set), dict(phrases("flow_of"))
    for language, units in product(languages(), ("metric", "us")):
        say = wording(language, units)
        for point in controller.operating_points:
            label = say.name(point.label)
            bare = label.removesuffix(f", {point.temperature:g} °C")
            for name in (point.name, label, bare, say.condition(point)):
                conditions[words(name)].add(point.name)
        for consumer in controller.consumers:
            consumers |= dict.fromkeys((words(consumer.id), words(say.name(consumer.name))), consumer.id)
    return {"condition": {name: each.pop() for name, each in conditions.items() if len(each) == 1}, "what": consumers}


def flow_finder(controller: Controller) -> ValueFinder:
    """Return what finds tables of flows."""
    conditions = _names(controller)["condition"]

    def begins(cell: Cell) -> bool:
        return isinstance(cell, str) and words(cell) in conditions

    return ValueFinder(FLOWS, "flow_columns", ("condition", "what", "value"), _ORDER, begins)


@own_errors_only(FlowTableError, "name", "source")
def read_flow_table(source: str | Path | bytes, controller: Controller, *, name: str | None = None) -> FlowTable:
    """Return the flows of a table in m³/s, each with its place in the file.

    Raises
    ------
    FlowTableError
        with all problems found: an unknown operating point, consumer or unit, a cell that is no flow; or where the
        file as a whole holds no such table, or none filled in.
    """
    finder, names = flow_finder(controller), _names(controller)
    missing = FlowTableError(Sentence("holds no table of flows"), expected=_HEADINGS)
    held = ValueFile.open(source, name, finder.find, finder.likeness, missing, _WANTED)
    faults, readings = Faults(FlowTableError), list[FlowReading]()
    for table in held.tables:
        rows = (row for row in table.rows if table.row >= 0 or finder.begins(first_cell(table.sheet, row)[0]))
        for row, (column,) in table.filled(rows, faults):
            condition, what = (_named(table, row, kind, known, faults) for kind, known in names.items())
            flow = table.number(faults, row, column, _FLOW, "flow")
            if condition is not None and what is not None and flow is not None:
                readings.append(FlowReading(condition, what, flow.si, table.place(row, column)))
    faults.settle()
    if not readings:
        problem, expected = Sentence("no flow is filled in"), Sentence("at least one flow")
        raise FlowTableError(problem, place=Place(held.file), expected=expected)
    return FlowTable(held.file, held.sha256, held.sheet, tuple(readings), (*held.notes, *faults.messages))


def _named(table: ValueTable, row: int, kind: str, names: Mapping[str, str], faults: Faults) -> str | None:
    """Return what a cell names; None where that is a problem."""
    text = text_of(table.cell(row, kind))
    known = names.get(words(text))
    if known is None:
        accepted = tuple(dict.fromkeys(names.values()))
        faults.refuse(_NOT_UNDERSTOOD[kind][bool(text)], table.place_of(row, kind), text or None, accepted)
    return known
