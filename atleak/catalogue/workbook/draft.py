"""An entry of the catalogue as it is typed on a page: tables of text, which become the tables of its file.

What is typed stays as it is, sign for sign, whether or not it can be read. Every fault and doubt has its cell, and is
said in the unit and with the text that were typed there. A `Subject` says which tables and columns there are.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import Any

from atleak.catalogue.controller_file import written_toml
from atleak.catalogue.doubts import doubts_of
from atleak.catalogue.entries import Shelf, id_from_name
from atleak.catalogue.workbook.cells import CellForm, Number, Units, as_text
from atleak.catalogue.workbook.shapes import (
    HEAD_DEFAULTS,
    Description,
    SheetColumn,
    SheetFault,
    Spot,
    WorkbookRow,
    WorkbookSheet,
)
from atleak.catalogue.workbook.sheets import Offered
from atleak.common.errors import CatalogueError, InputError
from atleak.common.file_faults import NotAccepted
from atleak.common.sentences import Sentence, any_of, in_a_row

_LENGTHS = {"mm": 1e-3, "µm": 1e-6, "inch": 0.0254}


def doubts(sheet: WorkbookSheet, rows: Iterable[WorkbookRow], units: Units) -> Iterator[tuple[Spot, Sentence]]:
    """Yield the cells whose numbers are accepted and yet look like those of another unit, each with what to ask.

    An inch sheet with a spool of 7.2, say: 183 mm is none of a valve body, 7.2 mm is.
    """
    for row in rows:
        for column in sheet.columns:
            kind = column.kind
            if not isinstance(kind, Number) or not kind.measure.is_doubted or column.heading not in row.values:
                continue
            if question := _other_unit(column, row, units):
                stands = f"{as_text(row.cells[column.heading])} {kind.label(units)}"
                text = Sentence(
                    "{stands} is unusual{converted}: {question}",
                    stands=stands,
                    converted=_converted(column, row, units),
                    question=question,
                )
                yield row.at(column.heading), text


def in_cells(
    error: CatalogueError,
    into: Description,
    sheets: Iterable[WorkbookSheet],
    rows: Mapping[str, Sequence[WorkbookRow]],
    units: Units,
) -> Iterator[SheetFault | InputError]:
    """Yield the faults of tables as those of the cells that say them; one that no cell says stays as it is.

    What is wrong with a default that lands take from the head is said once, at the head, and nothing is said of a cell
    that could not be read.
    """
    declared, at_head = {sheet.name: sheet for sheet in sheets}, set()
    for each in (error, *error.others):
        steps = each.place.steps
        if into.is_left_out(steps):
            continue
        spot = into.spot(steps)
        if spot is None:
            yield each
            continue
        columns = declared[spot.sheet].columns
        column = next((column for column in columns if column.heading == spot.heading), None)
        row = next((row for row in rows[spot.sheet] if row.spot.row == spot.row), WorkbookRow(spot, {}, {}))
        of_head = into.spots.get((HEAD_DEFAULTS, *steps[-1:]))
        if column is None:
            yield SheetFault(spot, each.problem, each.value, each.expected, each.nearest)
        elif each.value is None or of_head is None or column.heading in row.cells:
            yield fault_of_cell(each, column, row, units)
        elif (of_head, str(each.value)) not in at_head:
            at_head.add((of_head, str(each.value)))
            yield SheetFault(of_head, each.problem, each.value, each.expected, each.nearest)


def fault_of_cell(error: InputError, column: SheetColumn, row: WorkbookRow, units: Units) -> SheetFault:
    """Return a fault of the tables as one of the cell in which the value was typed, or is missing."""
    spot = row.at(column.heading)
    if column.heading not in row.cells:
        if error.value is not None:  # of a value that nobody typed
            return SheetFault(spot, error.problem, error.value, error.expected, error.nearest)
        expected = column.kind.wanted(units) if isinstance(column.kind, Number) else None
        return SheetFault(spot, Sentence("this cell must be filled in"), expected=expected)
    expected, question = error.expected, _other_unit(column, row, units)
    if expected and question:
        expected = in_a_row((expected, question))
    return SheetFault(
        spot,
        Sentence("{problem}{converted}", problem=error.problem, converted=_converted(column, row, units)),
        row.cells[column.heading],
        expected or question or None,
        error.nearest,
    )


def _converted(column: SheetColumn, row: WorkbookRow, units: Units) -> Sentence:
    """Say what a number is in the unit of the file, where that is another one, since limits are stated in it."""
    value, kind = row.values.get(column.heading), column.kind
    if not isinstance(kind, Number) or not isinstance(value, float) or kind.value(1.0, units) == 1.0:
        return Sentence("")
    return Sentence(" (it is {value:.6g} {unit})", value=value, unit=kind.label(Units()))


def _other_unit(column: SheetColumn, row: WorkbookRow, units: Units) -> Sentence:
    """Ask for the unit in which a length would be a usual one, where it is none as it stands."""
    kind, cell = column.kind, row.cells[column.heading]
    if not isinstance(kind, Number) or kind.measure.usual == (0.0, 0.0) or column.heading not in row.values:
        return Sentence("")
    low, high = kind.measure.usual
    if low <= row.values[column.heading] <= high:
        return Sentence("")
    try:
        number = float(kind.written(cell, units))
    except NotAccepted:  # a unit stands in the cell already
        return Sentence("")
    sides = 2.0 if kind.measure.of_clearance and units.clearance == "diametral" else 1.0
    names = [name for name, si in _LENGTHS.items() if low <= number * si / float(kind.measure.si) / sides <= high]
    return Sentence("was it in {units}?", units=any_of(names)) if names else Sentence("")


_Cells = Mapping[str, str]
"""A row by the headings of its columns; a heading that is missing is an empty cell."""

_NOTHING_YET = Sentence("nothing is filled in yet")
_FORMAT = 1
_DIGITS = range(15, 18)  # of a computed number
_COMPUTED = re.compile(r"-?\d+\.\d+(?:e[+-]\d+)?|-?\d{15,17}")


@dataclass(frozen=True)
class Subject:
    """A kind of entry that can be typed: its sheets, the first of which is its head, and how its file is checked."""

    shelf: Shelf[Any]
    sheets: tuple[WorkbookSheet, ...]
    names: Mapping[str, Offered] = field(default_factory=dict)  # that drop-downs offer

    @property
    def kind(self) -> str:
        """Return the folder of the catalogue."""
        return self.shelf.kind

    def sheet(self, name: str) -> WorkbookSheet:
        """Return a sheet by its name."""
        return next(sheet for sheet in self.sheets if sheet.name == name)

    def toml(self, data: Mapping[str, Any]) -> str:
        """Return tables as the text of their file."""
        return written_toml(data, self.shelf.model)


@dataclass(frozen=True)
class Draft:
    """What is typed so far: by table the rows, and the units in which its numbers are typed."""

    subject: Subject
    units: Units = Units()  # noqa: RUF009  frozen
    tables: Mapping[str, tuple[_Cells, ...]] = field(default_factory=dict)

    def rows(self, table: str) -> tuple[_Cells, ...]:
        """Return the rows of a table; those of a form are one."""
        rows = self.tables.get(table, ())
        return rows or ({},) if self.subject.sheet(table).is_form else rows

    def cell(self, table: str, heading: str) -> str:
        """Return what stands in a field of a form."""
        return self.rows(table)[0].get(heading, "")

    def with_rows(self, table: str, rows: Iterable[_Cells]) -> Draft:
        """Return the draft with other rows of a table; empty ones keep their place, but not at the end."""
        kept = [{heading: text for heading, text in row.items() if text.strip()} for row in rows]
        while kept and not kept[-1]:
            kept.pop()
        return replace(self, tables={**self.tables, table: tuple(kept)})

    def with_cell(self, table: str, heading: str, text: str) -> Draft:
        """Return the draft with another text in a field of a form."""
        return self.with_rows(table, [{**self.rows(table)[0], heading: text}])

    def in_units(self, units: Units) -> Draft:
        """Return the same entry typed in other units, each number converted exactly; what is none stays."""
        tables = {}
        for name, rows in self.tables.items():
            sheet = self.subject.sheet(name)
            tables[name] = tuple(
                {heading: _in_unit(sheet, heading, text, self.units, units) for heading, text in row.items()}
                for row in rows
            )
        return replace(self, units=units, tables=tables)

    def written(self) -> str:
        """Return the draft as JSON, which `read_draft` reads."""
        stored = {"format": _FORMAT, "kind": self.subject.kind, "units": asdict(self.units), "tables": self.tables}
        return json.dumps(stored, ensure_ascii=False)


@dataclass(frozen=True)
class Checked:
    """What a draft describes: the tables of a file, the entry where nothing is wrong, else every fault."""

    data: Mapping[str, Any]
    entry: Any  # None where something is wrong
    faults: tuple[SheetFault, ...]
    doubts: tuple[SheetFault, ...]  # values that are accepted, and probably a slip
    notes: tuple[Sentence, ...]  # what was taken for granted, in sentences

    def of(self, table: str) -> tuple[SheetFault, ...]:
        """Return the faults in one table."""
        return tuple(fault for fault in self.faults if fault.spot.sheet == table)

    def doubted_in(self, table: str) -> tuple[SheetFault, ...]:
        """Return the doubts in one table."""
        return tuple(doubt for doubt in self.doubts if doubt.spot.sheet == table)


def draft_of(subject: Subject, data: Mapping[str, Any], units: Units = Units()) -> Draft:  # noqa: B008  frozen
    """Return the tables of an entry's file as a draft, typed in these units."""
    draft = Draft(subject, units)
    for sheet in subject.sheets:
        columns = {column.heading: column for column in sheet.columns_for(data)}
        rows = [
            {heading: _text(columns[heading].kind, value, units) for heading, value in row.items()}
            for row in sheet.rows(data)
        ]
        draft = draft.with_rows(sheet.name, rows)
    return draft


def copy_of(data: Mapping[str, Any]) -> dict[str, Any]:
    """Return an entry's tables as those of another one: under another name, from which its id will be made."""
    return {key: value for key, value in data.items() if key != "id"} | {"name": f"{data['name']}, own copy"}


def read_draft(subject: Subject, text: str) -> Draft | None:
    """Read a draft that was kept; None where it is damaged, of another version or of another kind of entry."""
    try:
        stored = json.loads(text)
        if stored["format"] != _FORMAT or stored.get("kind", "controllers") != subject.kind:
            return None
        draft = Draft(subject, Units(**stored["units"]))
        for name, rows in stored["tables"].items():
            if any(sheet.name == name for sheet in subject.sheets):
                draft = draft.with_rows(name, [{str(key): str(cell) for key, cell in row.items()} for row in rows])
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        return None
    return draft


def checked(draft: Draft) -> Checked:
    """Read a draft and check it as its file would be; name everything that is wrong, and what is in doubt."""
    subject, into, rows = draft.subject, Description(), {}
    for sheet in subject.sheets:
        rows[sheet.name] = _rows(draft, sheet, into)
        sheet.fill(rows[sheet.name], into)
    if "id" not in into.data and (made := id_from_name(into.data.get("name", "unnamed"))):
        into.data["id"] = made
    entry, faults = None, into.faults
    try:
        entry = subject.shelf.checked(into.data)
    except CatalogueError as error:
        further = in_cells(error, into, subject.sheets, rows, draft.units)
        faults = [*faults, *(_on_page(fault, draft) for fault in further)]
    order = {sheet.name: number for number, sheet in enumerate(subject.sheets)}
    different = {(fault.spot, str(fault.text)): fault for fault in faults}.values()
    faults = sorted(different, key=lambda fault: (order.get(fault.spot.sheet, -1), fault.spot.row or 0))
    wrong = {fault.spot for fault in faults}
    asked: dict[Spot, SheetFault] = {}
    for doubt in _doubts(draft, entry, into, rows):
        if doubt.spot not in wrong:
            asked.setdefault(doubt.spot, doubt)
    return Checked(into.data, None if faults else entry, tuple(faults), tuple(asked.values()), tuple(into.notes))


def _doubts(
    draft: Draft, entry: Any, into: Description, rows: Mapping[str, Sequence[WorkbookRow]]
) -> Iterable[SheetFault]:
    """Yield what looks like a number of another unit as it was typed, then what is unusual in its file."""
    for sheet in draft.subject.sheets:
        yield from (SheetFault(*doubt) for doubt in doubts(sheet, rows[sheet.name], draft.units))
    shelf, head = draft.subject.shelf, Spot(draft.subject.sheets[0].name)
    of_file = entry.doubts if entry is not None else doubts_of(shelf.kind, shelf.model, into.data, "")
    for message in of_file:
        yield SheetFault((message.place and into.spot(message.place.steps)) or head, message.text)


# --- cells --------------------------------------------------------------------------------------------------------


def _rows(draft: Draft, sheet: WorkbookSheet, into: Description) -> list[WorkbookRow]:
    """Read the cells of a table; each that cannot be read is a fault."""
    rows = []
    for number, cells in enumerate(draft.rows(sheet.name), start=1):
        if not cells and not sheet.is_form:
            continue
        spot, values = Spot(sheet.name, None if sheet.is_form else number), {}
        for heading, text in cells.items():
            column = _column(sheet, heading)
            if column is None:
                problem = Sentence("no column of this table")
                into.faults.append(SheetFault(spot._replace(heading=heading), problem, text))
                continue
            try:
                values[heading] = column.kind.value(_cell(text), draft.units)
            except NotAccepted as error:
                problem = Sentence("cannot be read")
                into.faults.append(SheetFault(spot._replace(heading=heading), problem, text, error.wanted))
        rows.append(WorkbookRow(spot, dict(cells), values))
    return rows


def _column(sheet: WorkbookSheet, heading: str) -> SheetColumn | None:
    declared = next((column for column in sheet.columns if column.heading == heading), None)
    return declared or sheet.further_column(heading)


def _in_unit(sheet: WorkbookSheet, heading: str, text: str, before: Units, after: Units) -> str:
    column = _column(sheet, heading)
    if column is None or column.kind.label(before) == column.kind.label(after):
        return text
    try:
        return _text(column.kind, column.kind.value(_cell(text), before), after)
    except NotAccepted:
        return text


def _text(kind: CellForm, value: Any, units: Units) -> str:
    """Return what is typed for a value of the file, so that it is read back to the last digit."""
    cell = kind.cell(value, units)
    if isinstance(cell, float):
        texts = (f"{cell:.{digits}g}" for digits in _DIGITS)
        return next((text for text in texts if kind.value(_cell(text), units) == value), f"{cell:#.{_DIGITS[0]}g}")
    return str(cell)


def _cell(text: str) -> str | float:
    """Return a text as a cell: a number of so many digits was computed, not typed, and is one of a workbook's."""
    digits = len(text.split("e")[0].replace(".", "").lstrip("-0"))
    return float(text) if digits in _DIGITS and _COMPUTED.fullmatch(text) else text


# --- faults -------------------------------------------------------------------------------------------------------


def _on_page(fault: SheetFault | InputError, draft: Draft) -> SheetFault:
    """Return a fault of the tables where it stands on the page: of what is empty altogether, that it is."""
    sheets = draft.subject.sheets
    if isinstance(fault, SheetFault):
        cells = draft.rows(fault.spot.sheet)[(fault.spot.row or 1) - 1]
        return fault if fault.spot.heading or cells else replace(fault, problem=_NOTHING_YET)
    steps = fault.place.steps
    sheet = next((sheet for sheet in sheets if sheet.at[:1] == steps[:1]), sheets[0])
    problem = _NOTHING_YET if len(steps) == 1 else fault.problem
    return SheetFault(Spot(sheet.name), problem, fault.value, fault.expected, fault.nearest)
