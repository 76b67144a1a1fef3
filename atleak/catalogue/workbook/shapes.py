"""Turn the rows of each sheet into tables of a controller's file, and those tables into rows.

Every shape does both: `Sheet.rows` writes what `Sheet.fill` reads. Rows are dictionaries by the heading of a column, in
the units of the controller's file; it is remembered in which cell each value stood.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from difflib import SequenceMatcher
from typing import Any, NamedTuple

from atleak.catalogue.workbook.cells import EVERY, CellForm, Gears
from atleak.common.errors import InputError, KeySteps, nearest_name, one_of
from atleak.common.sentences import Sentence

_SURELY = 0.85  # how alike two names are of which one is a slip of the pen


class Spot(NamedTuple):
    """A cell of the workbook: sheet by the name it is declared with, row as numbered there, column by its heading."""

    sheet: str
    row: int | None = None
    heading: str | None = None


@dataclass(frozen=True)
class SheetFault:
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
class WorkbookRow:
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
    faults: list[SheetFault] = field(default_factory=list)
    notes: list[Sentence] = field(default_factory=list)  # what was taken for granted, in sentences
    spots: dict[KeySteps, Spot] = field(default_factory=dict)
    left_out: set[KeySteps] = field(default_factory=set)  # values whose cell has a fault already

    def mark(self, steps: KeySteps, spot: Spot) -> None:
        """Remember the cell of a value; the first cell of what several make up is the one that counts."""
        self.spots.setdefault(steps, spot)

    def spot(self, steps: KeySteps) -> Spot | None:
        """Return the cell of a value, or of the smallest table around it that has one."""
        for length in range(len(steps), 0, -1):
            if steps[:length] in self.spots:
                return self.spots[steps[:length]]
        return None

    def is_left_out(self, steps: KeySteps) -> bool:
        """Return whether a value, or the table around it, was left out because of a fault that is reported already."""
        return any(steps[:length] in self.left_out for length in range(1, len(steps) + 1))

    def table(self, at: KeySteps) -> dict[str, Any]:
        """Return the table at these steps, made where it is missing."""
        table = self.data
        for step in at:
            table = table.setdefault(str(step), {})
        return table

    def entries(self, key: str) -> list[dict[str, Any]]:
        """Return the list of tables under a key, made where it is missing."""
        listed: list[dict[str, Any]] = self.data.setdefault(key, [])
        return listed

    def fault(self, row: WorkbookRow, heading: str | None, problem: Sentence, expected: Sentence | None = None) -> None:
        """Report a cell."""
        cell = row.cells.get(heading) if heading else None
        self.faults.append(SheetFault(row.at(heading), problem, cell, expected))

    def unknown(self, row: WorkbookRow, heading: str, problem: Sentence, known: Sequence[str]) -> str | None:
        """Report a name that is none of those known; return the one that was surely meant, if any."""
        cell = row.cells.get(heading)
        nearest = None if cell is None else nearest_name(str(cell), known)
        self.faults.append(SheetFault(row.at(heading), problem, cell, one_of(known), nearest))
        alike = 0.0 if nearest is None else SequenceMatcher(None, str(cell), nearest).ratio()
        return nearest if alike >= _SURELY else None


Values = dict[str, Any]
HEAD_DEFAULTS, _REPRESENTATIVE = "defaults", "representative_values"  # of the head: for lands that state nothing
_LISTS = ("measured", "published", "representative")  # keys that list which values of a table are known how


@dataclass(frozen=True)
class SheetColumn:
    """A column of a sheet, or a line of a form: one key of the file, and what its cells hold.

    ``end`` is 0 and 1 for the ends of a range that may also be one number; ``how_known`` names the key whose
    origin (measured, published, representative) the column states.
    """

    heading: str
    keys: tuple[str, ...]
    kind: CellForm = CellForm()  # noqa: RUF009  frozen, so safe to share
    required: bool = False
    help: str = ""
    names: str = ""  # whose names its drop-down offers: one of `layout.NAMES`
    end: int | None = None
    how_known: str = ""
    width: int = 14

    def of(self, table: Mapping[str, Any], end: int | None = None) -> Any:
        """Return the column's value of a table, or the given end of its range; None where it states none."""
        if self.how_known:
            return next((name for name in _LISTS if self.how_known in table.get(name, ())), None)
        value: Any = table
        for key in self.keys:
            value = value.get(key) if isinstance(value, Mapping) else None
        end = self.end if end is None else end
        if end is not None and value is not None:
            ends = value if isinstance(value, list) else [value]
            return ends[end] if end < len(ends) else None
        return value

    def put(self, table: Values, value: Any) -> None:
        """Write the column's value into a table."""
        if self.how_known:
            table.setdefault(value, []).append(self.how_known)
            return
        for key in self.keys[:-1]:
            table = table.setdefault(key, {})
        last = self.keys[-1]
        table[last] = [table[last], value] if self.end else value

    @property
    def key(self) -> str:
        """Return the key of the value; "" where it is none of a single key."""
        return self.keys[-1] if self.keys else ""

    @property
    def is_stated(self) -> bool:
        """Return whether the column states something of its row's table; one that names the table does not."""
        return bool(self.keys or self.how_known)

    def steps(self) -> list[KeySteps]:
        """Return where in its table the column's value stands, as a fault may name it."""
        if self.how_known:
            return []
        return [self.keys] if self.end is None else [(*self.keys, 1)] if self.end else [self.keys, (*self.keys, 0)]


@dataclass(frozen=True)
class OneOrSeveral(SheetColumn):
    """A column of two keys, of which a table has one: ``one`` for a single value, the column's own for several."""

    one: str = ""

    def of(self, table: Mapping[str, Any], end: int | None = None) -> Any:
        return [table[self.one]] if self.one in table else super().of(table, end)

    def put(self, table: Values, value: Any) -> None:
        if isinstance(value, list) and len(value) == 1:
            table[self.one] = value[0]
        else:
            super().put(table, value)

    def steps(self) -> list[KeySteps]:
        return [self.keys, (self.one,)]


@dataclass(frozen=True)
class KnownOfAll(SheetColumn):
    """A field of the head that says how one value of all lands is known, where a land does not say otherwise."""

    value_of_all: str = ""

    @property
    def is_stated(self) -> bool:
        return True

    def of(self, table: Mapping[str, Any], end: int | None = None) -> Any:
        for name in _LISTS[:2]:
            if self.value_of_all in table.get(HEAD_DEFAULTS, {}).get(name, ()):
                return name
        return "representative" if self.value_of_all in table.get(_REPRESENTATIVE, ()) else None

    def put(self, table: Values, value: Any) -> None:
        if value == "representative":
            table.setdefault(_REPRESENTATIVE, []).append(self.value_of_all)
        else:
            table.setdefault(HEAD_DEFAULTS, {}).setdefault(value, []).append(self.value_of_all)

    def steps(self) -> list[KeySteps]:
        return []


@dataclass(frozen=True)
class WorkbookSheet:
    """A sheet of the workbook, declared once."""

    name: str
    about: str  # what it is for, in a sentence or two
    columns: tuple[SheetColumn, ...]
    at: KeySteps = ()  # of its table or list of tables in the file
    needed: bool = False  # no valve body goes without it
    is_form: bool = field(default=False, init=False)

    def rows(self, data: Mapping[str, Any]) -> Iterator[Values]:
        """Yield the sheet's rows for a controller's tables."""
        raise NotImplementedError

    def fill(self, rows: Sequence[WorkbookRow], into: Description) -> None:
        """Add what the rows say to a description."""
        raise NotImplementedError

    def columns_for(self, data: Mapping[str, Any]) -> tuple[SheetColumn, ...]:
        """Return the columns to write for a controller's tables."""
        return self.columns

    def further_column(self, heading: Any) -> SheetColumn | None:
        """Return the column of a heading that is none of the declared ones; None where there is no such column."""
        return None

    def _values(self, table: Mapping[str, Any]) -> Values:
        """Return the row of a table."""
        given = ((column.heading, column.of(table)) for column in self.columns if column.is_stated)
        return {heading: value for heading, value in given if value is not None}

    def _read(self, row: WorkbookRow, at: KeySteps, into: Description) -> Values:
        """Return the table that a row states, and remember its cells."""
        table: Values = {}
        into.mark(at, row.spot)
        for column in self.columns:
            for steps in column.steps():
                into.mark((*at, *steps), row.at(column.heading))
            if not column.is_stated:
                continue
            value = row.values.get(column.heading)
            if value == EVERY and isinstance(column.kind, Gears):
                value = into.data.get("gears")  # the head is read first
            if value is None:
                if column.heading in row.cells and column.keys and not column.end:
                    value = row.cells[column.heading]  # as it stands: what rests on it is then no fault of its own
                if column.heading in row.cells or column.heading in row.absent:
                    into.left_out.add((*at, *column.keys))
            if value is None:
                continue
            if column.end and column.of(table, end=0) is None:
                problem = Sentence("the upper end of a range without its lower one")
                into.fault(row, column.heading, problem, Sentence("both, or neither"))
                continue
            column.put(table, value)
        return table


@dataclass(frozen=True)
class Form(WorkbookSheet):
    """One table, a key on each line."""

    is_form: bool = field(default=True, init=False)

    def rows(self, data: Mapping[str, Any]) -> Iterator[Values]:
        table: Any = data
        for step in self.at:
            table = table.get(step, {})
        yield self._values(table)

    def fill(self, rows: Sequence[WorkbookRow], into: Description) -> None:
        for row in rows:
            stated = self._read(row, self.at, into)
            if stated:
                into.table(self.at).update(stated)


@dataclass(frozen=True)
class Tables(WorkbookSheet):
    """A list of tables, one on each row."""

    def rows(self, data: Mapping[str, Any]) -> Iterator[Values]:
        yield from map(self._values, data.get(self._key, ()))

    def fill(self, rows: Sequence[WorkbookRow], into: Description) -> None:
        for row in rows:
            entries = into.entries(self._key)
            entries.append(self._read(row, (self._key, len(entries)), into))

    @property
    def _key(self) -> str:
        return str(self.at[0])


@dataclass(frozen=True)
class NamedTables(WorkbookSheet):
    """Tables by name, one on each row; the first column is the name."""

    def rows(self, data: Mapping[str, Any]) -> Iterator[Values]:
        for name, table in data.get(str(self.at[0]), {}).items():
            yield {self.columns[0].heading: name, **self._values(table)}

    def fill(self, rows: Sequence[WorkbookRow], into: Description) -> None:
        heading = self.columns[0].heading
        for row in rows:
            name = row.values.get(heading)
            if name is None:
                if heading not in row.cells:
                    into.fault(row, heading, Sentence("this row has no name"), Sentence("a name, or an empty row"))
                continue
            tables = into.table(self.at)
            if name in tables:
                into.fault(row, heading, Sentence("given twice"), Sentence("each name once"))
                continue
            tables[name] = self._read(row, (*self.at, name), into)


@dataclass(frozen=True)
class Parts(WorkbookSheet):
    """Tables that belong to those of another sheet, whose id stands in the first column."""

    under: str = ""  # key of their list: "lands"

    def rows(self, data: Mapping[str, Any]) -> Iterator[Values]:
        for owner in data.get(str(self.at[0]), ()):
            for table in owner.get(self.under, ()):
                yield {self.columns[0].heading: owner["id"], **self._values(table)}

    def fill(self, rows: Sequence[WorkbookRow], into: Description) -> None:
        owners = by_id(into, str(self.at[0]))
        for row in rows:
            owner = owner_of(row, self.columns[0].heading, owners, into)
            if owner is not None:
                number, table = owners[owner]
                listed = table.setdefault(self.under, [])
                listed.append(self._read(row, (*self.at, number, self.under, len(listed)), into))


@dataclass(frozen=True)
class ValuesByPoint(WorkbookSheet):
    """One key of tables of another sheet: a number, or one for each operating point; columns are id, point, number."""

    def rows(self, data: Mapping[str, Any]) -> Iterator[Values]:
        owner, point, number = (column.heading for column in self.columns)
        for table in data.get(str(self.at[0]), ()):
            stated = table.get(self._key)
            for name, value in (stated if isinstance(stated, dict) else {None: stated}).items():
                row = {owner: table["id"], point: name, number: value}
                yield {heading: value for heading, value in row.items() if value is not None}

    def fill(self, rows: Sequence[WorkbookRow], into: Description) -> None:
        owner, point, number = (column.heading for column in self.columns)
        owners = by_id(into, str(self.at[0]))
        for row in rows:
            name = owner_of(row, owner, owners, into)
            if name is None:
                continue
            place, table = owners[name]
            at = (*self.at, place, self._key)
            into.mark(at, row.at(number))
            where = point_of(row, point, into) if point in row.cells else None
            stated = table.get(self._key)
            if number not in row.cells:
                into.fault(row, number, Sentence("no number"), Sentence("a number, or an empty row"))
            if number not in row.values or (where is None and point in row.cells):
                into.left_out.add(at)
            elif where is None and stated is None:
                table[self._key] = row.values[number]
            elif where is None or not isinstance(table.setdefault(self._key, {}), dict) or where in table[self._key]:
                expected = Sentence("one number for all operating points, or one for each of them")
                into.fault(row, point, Sentence("a further number of {name}", name=name), expected)
            else:
                into.mark((*at, where), row.at(number))
                table[self._key][where] = row.values[number]
        for name, (place, table) in owners.items():
            if self._key not in table and (*self.at, place, self._key) not in into.left_out:
                problem = Sentence("no row says it of {name}", name=name)
                into.faults.append(SheetFault(Spot(self.name), problem, expected=Sentence("a row for it")))
                into.left_out.add((*self.at, place, self._key))

    @property
    def _key(self) -> str:
        return self.columns[-1].keys[-1]


def by_id(into: Description, key: str) -> dict[str, tuple[int, Values]]:
    """Return the tables of a list by their ids, each with its place in the list."""
    tables: dict[str, tuple[int, Values]] = {}
    for place, table in enumerate(into.data.get(key, ())):
        if "id" in table:
            tables.setdefault(table["id"], (place, table))
    return tables


def owner_of(row: WorkbookRow, heading: str, owners: Mapping[str, Any], into: Description) -> str | None:
    """Return the id of the table that a row belongs to; a fault where there is no such table.

    Then it is the id that was probably meant, if any, so that what rests on the row is not called missing as well.
    """
    name = row.values.get(heading)
    if name in owners:
        return str(name)
    if heading in row.values:
        return into.unknown(row, heading, Sentence("no such id here"), list(owners))
    if heading not in row.cells:
        problem = Sentence("this row does not say to what it belongs")
        into.fault(row, heading, problem, Sentence("an id, or an empty row"))
    return None


def point_of(row: WorkbookRow, heading: str, into: Description) -> str | None:
    """Return the operating point that a cell names; None, and a fault, where there is no such point."""
    name = row.values.get(heading)
    points = [str(table["name"]) for table in into.data.get("operating_points", ()) if "name" in table]
    if name is None or name in points:
        return name
    into.unknown(row, heading, Sentence("no such operating point"), points)
    return None
