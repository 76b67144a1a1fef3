"""A workbook that describes a valve body → the tables of a controller's file, checked.

`atleak.catalogue.workbook.sheets` declares the sheets; see ``docs/description-workbook.md``. Everything wrong is
listed at once, with sheet, row and column: cells that hold something else than their column asks for, and values that
do not fit each other.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from decimal import Decimal
from pathlib import Path
from typing import Any

from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import checked_controller
from atleak.catalogue.workbook.cells import (
    CLEARANCES,
    LENGTHS,
    PRESSURES,
    ChoiceCell,
    Number,
    SheetCellKind,
    Units,
    as_text,
)
from atleak.catalogue.workbook.draft import doubts, in_cells
from atleak.catalogue.workbook.shapes import Description, SheetColumn, SheetFault, Spot, WorkbookRow
from atleak.catalogue.workbook.shapes import WorkbookSheet as Declared
from atleak.catalogue.workbook.sheets import (
    EXAMPLE_MARK,
    FIELD,
    HEAD,
    HOW_KNOWN,
    INSTRUCTIONS,
    LISTS,
    NOTE_HEADING,
    SHEETS,
    UNIT_LINES,
    UNIT_MARK,
    VALUE,
    examples,
)
from atleak.common.damage import own_errors_only
from atleak.common.errors import CatalogueError, InputError, Place, ReadingsError, nearest_name, one_of
from atleak.common.file_faults import NotAccepted, faults_together
from atleak.common.sentences import Sentence
from atleak.common.units import find_unit
from atleak.readers.cells.sheet import Sheet, column_letter, rows_named
from atleak.readers.cells.sheet_file import read_bytes, read_workbook
from atleak.readers.dates import words

_LOOKED_AT = 40  # rows at the top of a sheet among which its headings are sought
_WITH_UNIT = re.compile(r"(.*?\d[.,]?)\s*([^\d\s.,][^\d]*)")


@dataclass
class Page:
    """A sheet and what was read of it: its rows, and where the cells of each heading stand."""

    sheet: Sheet
    declared: Declared
    units: Units  # in which its numbers are written; the head says so itself
    into: Description
    rows: list[WorkbookRow] = field(default_factory=list)
    columns: dict[str, int] = field(default_factory=dict)  # by heading
    lines: dict[str, int] = field(default_factory=dict)  # row by heading, of a form

    def read(self) -> bool:
        """Read the sheet as it is declared: one key on each line, or one table on each row; False without headings."""
        wanted = [FIELD, VALUE] if self.declared.is_form else [column.heading for column in self.declared.columns]
        top = self._heading_row(wanted)
        if top is not None:
            (self._read_form if self.declared.is_form else self._read_table)(top)
        return top is not None

    def _heading_row(self, headings: Sequence[str]) -> int | None:
        """Return the row in which most of the headings stand, the first of several; None where none does."""
        wanted = {words(heading) for heading in headings}
        found = [len({words(as_text(cell)) for cell in row} & wanted) for row in self.sheet.rows[:_LOOKED_AT]]
        most = max(found, default=0)
        return found.index(most) if most >= max(min(2, len(wanted)), 1) else None

    def _spot(self, row: int | None = None, heading: str | None = None) -> Spot:
        return Spot(self.declared.name, None if row is None else self.sheet.row_number(row), heading)

    def _fault(self, spot: Spot, problem: Sentence, cell: Any = None, expected: Sentence | None = None) -> None:
        self.into.faults.append(SheetFault(spot, problem, cell, expected))

    def _unknown(self, spot: Spot, problem: Sentence, cell: Any, known: Iterable[SheetColumn]) -> None:
        headings = [column.heading for column in known]
        nearest = nearest_name(as_text(cell), headings)
        self.into.faults.append(SheetFault(spot, problem, cell or None, one_of(headings), nearest))

    def _row(self, spot: Spot, places: Mapping[SheetColumn, tuple[int, int]]) -> WorkbookRow:
        """Read the cells of one table, each at its row and column."""
        cells: dict[str, Any] = {}
        values: dict[str, Any] = {}
        for column, (row, number) in places.items():
            cell, fault = _standing(self.sheet, row, number)
            if cell is None:
                continue
            cells[column.heading] = cell
            try:
                if fault is None:
                    values[column.heading] = _value(column, cell, self.units)
            except NotAccepted as error:
                fault = Sentence("not accepted"), error.wanted
            if fault is not None:
                self._fault(Spot(spot.sheet, spot.row, column.heading), fault[0], cell, fault[1])
        return WorkbookRow(spot, cells, values)

    def _read_form(self, top: int) -> None:
        headed = {words(as_text(cell)): number for number, cell in reversed(list(enumerate(self.sheet.rows[top])))}
        rows = range(top + 1, len(self.sheet.rows))
        places = self._places(rows, headed)
        self.columns = {line.heading: column for line, (_, column) in places.items()}
        self.lines = {line.heading: row for line, (row, _) in places.items()}
        note = headed.get(words(NOTE_HEADING))
        if note is not None:
            self._say_lost([row for row in rows if _own(self.sheet, row, note)])
        if self.declared is HEAD:
            chosen = self._row(self._spot(), {line: places.pop(line) for line in UNIT_LINES if line in places})
            for line in UNIT_LINES:
                if line.heading not in chosen.cells and isinstance(line.kind, ChoiceCell):
                    self.into.fault(chosen, line.heading, Sentence("not chosen"), one_of(line.kind.shown))
            values = chosen.values
            self.units = Units(**{line.key: values[line.heading] for line in UNIT_LINES if line.heading in values})
        row_read = self._row(self._spot(), places)
        self.rows = [row_read] if row_read.cells else []

    def _places(self, rows: range, headed: Mapping[str, int]) -> dict[SheetColumn, tuple[int, int]]:
        """Return where the value of each line of a form stands, and how it is known."""
        labels, values, how_known = headed[words(FIELD)], headed[words(VALUE)], headed.get(words(HOW_KNOWN))
        every = (*(UNIT_LINES if self.declared is HEAD else ()), *self.declared.columns)
        lines = {words(line.heading): line for line in every if not line.how_known}
        basis_lines = {line.how_known: line for line in every if line.how_known}
        places: dict[SheetColumn, tuple[int, int]] = {}
        for row in rows:
            label = as_text(self.sheet.cell(row, labels))
            line = lines.get(words(label))
            if line is None:
                if label and _raw(self.sheet, row, values) is not None:
                    self._unknown(self._spot(row), Sentence("unknown field"), label, lines.values())
                continue
            for column, asked in ((values, line), (how_known, basis_lines.get(line.key))):
                if asked is None or column is None:
                    continue
                if places.setdefault(asked, (row, column))[0] != row and _raw(self.sheet, row, column) is not None:
                    self._fault(self._spot(row), Sentence("field given twice"), label, Sentence("each field once"))
        return places

    def _read_table(self, top: int) -> None:
        sheet, columns = self.sheet, self._columns(top)
        self.columns = {column.heading: number for number, column in columns.items()}
        note = next((number for number in range(sheet.width) if _is(sheet.cell(top, number), NOTE_HEADING)), None)
        needed = [column.heading for column in self.declared.columns if column.required]
        absent = [heading for heading in needed if heading not in self.columns]
        for heading in absent:
            self._fault(self._spot(top), Sentence("the column {heading!r} is missing", heading=heading))
        remarks: list[int] = []
        for row in range(top + 1, len(sheet.rows)):
            mark = "" if note is None else sheet.cell(row, note)
            if row == top + 1 and _is(mark, UNIT_MARK):
                self._check_units(row, columns)
            elif not any(_own(sheet, row, number) for number in columns):
                continue
            elif not _is(mark, EXAMPLE_MARK):
                remarks += [row] if as_text(mark) else []
                read = self._row(self._spot(row), {column: (row, number) for number, column in columns.items()})
                self.rows.append(replace(read, absent=frozenset(absent)))
            elif not self._is_example(row, columns):
                problem = Sentence("a row marked as an example was changed")
                expected = Sentence("the example as it was, or no {mark!r} before a row of your own", mark=EXAMPLE_MARK)
                self._fault(self._spot(row), problem, expected=expected)
        self._say_lost(remarks)

    def _columns(self, top: int) -> dict[int, SheetColumn]:
        """Return the columns by place; a heading that means nothing is a fault where something stands below it."""
        sheet, by_words = self.sheet, {words(column.heading): column for column in self.declared.columns}
        columns: dict[int, SheetColumn] = {}
        for number in range(sheet.width):
            heading = sheet.cell(top, number)
            if _is(heading, NOTE_HEADING):
                continue
            column = by_words.get(words(as_text(heading)))
            column = column or (self.declared.further_column(heading) if heading != "" else None)
            spot = self._spot(top, as_text(heading) or None)
            if column is not None and all(column.heading != taken.heading for taken in columns.values()):
                columns[number] = column
            elif not any(_own(sheet, row, number) for row in range(top + 1, len(sheet.rows))):
                continue
            elif column is not None:
                self._fault(spot, Sentence("column given twice"), heading, Sentence("each column once"))
            else:
                problem = Sentence("unknown column")
                if heading == "":
                    letter = column_letter(number)
                    problem = Sentence("column {letter} holds something and has no heading", letter=letter)
                self._unknown(spot, problem, heading, self.declared.columns)
        return columns

    def _check_units(self, row: int, columns: Mapping[int, SheetColumn]) -> None:
        """Compare the units under the headings with those of the head, where a program has worked them out."""
        for number, column in columns.items():
            label, stands = column.kind.label(self.units), as_text(self.sheet.cell(row, number))
            if stands and words(stands) != words(label):
                as_said = Sentence("{unit}, as the sheet Head says", unit=label)
                problem = Sentence("another unit than that of the workbook")
                expected = as_said if label else Sentence("no unit")
                self._fault(self._spot(row, column.heading), problem, stands, expected)

    def _is_example(self, row: int, columns: Mapping[int, SheetColumn]) -> bool:
        """Return whether a row is an example as it was written, in whichever units."""
        cells = {column.heading: _raw(self.sheet, row, number) for number, column in columns.items()}
        shown = {heading: as_text(cell) for heading, cell in cells.items() if cell is not None}
        return any(
            shown
            == {
                column.heading: as_text(column.kind.cell(example[column.heading], Units(*choice)))
                for column in columns.values()
                if column.heading in example
            }
            for example in examples(self.declared)
            for choice in itertools.product(LENGTHS, CLEARANCES, PRESSURES)
        )

    def _say_lost(self, rows: Sequence[int]) -> None:
        """Say which remarks are not carried over."""
        if rows:
            text = Sentence("sheet {sheet!r}, {rows}: what stands under {heading} is not carried over")
            where = rows_named(self.sheet, rows)
            self.into.notes.append(text.of(sheet=self.sheet.name, rows=where, heading=NOTE_HEADING))


def _is(cell: SheetCellKind, mark: str) -> bool:
    return isinstance(cell, str) and cell.strip().casefold().rstrip(".") == mark.casefold().rstrip(".")


def _own(sheet: Sheet, row: int, column: int) -> bool:
    """Return whether something stands in the cell itself, a formula without a result too."""
    cell = sheet.cell(row, column)
    return (row, column) in sheet.faults or (cell.strip() != "" if isinstance(cell, str) else cell is not None)


def _raw(sheet: Sheet, row: int, column: int) -> SheetCellKind | None:
    """Return what stands in a cell, or in the one above with which it is merged; None where it is empty."""
    above, left = sheet.merged.get((row, column), (row, column))
    cell = sheet.cell(above, left) if left == column else ""
    return None if cell is None or (isinstance(cell, str) and not cell.strip()) else cell


def _standing(sheet: Sheet, row: int, number: int) -> tuple[Any, tuple[Sentence, Sentence] | None]:
    """Return what stands in a cell, None where it is empty, and what is wrong with it whatever its column asks for."""
    if (row, number) in sheet.faults:
        expected = Sentence("a value, or the workbook saved by a spreadsheet program, which works the formula out")
        return sheet.faults[row, number], (Sentence("a formula without a result"), expected)
    cell = _raw(sheet, row, number)
    if cell is not None and sheet.is_struck(row, number):
        return cell, (Sentence("crossed out"), Sentence("the value, or an empty cell"))
    return cell, None


def _value(column: SheetColumn, cell: SheetCellKind, units: Units) -> Any:
    """Return the value of a cell in the file's unit, from a unit of its own where it names one."""
    kind = column.kind
    if isinstance(cell, str) and isinstance(kind, Number) and kind.measure.quantity:
        parts = _WITH_UNIT.fullmatch(cell.strip())
        unit = None if parts is None else find_unit(parts[2], kind.measure.quantity)
        if parts is not None and unit is not None and not unit.offset:
            number = Decimal(str(Number().written(parts[1], units))) * Decimal(repr(unit.factor)) / kind.measure.si
            return float(number / 2 if kind.measure.of_clearance and units.clearance == "diametral" else number)
    return kind.value(cell, units)


@dataclass
class Places:
    """The sheets as they were read, by the names they are declared with."""

    file: str
    pages: dict[str, Page] = field(default_factory=dict)

    def fault(self, fault: SheetFault | InputError) -> CatalogueError:
        """Return a fault as an error that names sheet, row and column, or table and key where no sheet says it."""
        if isinstance(fault, SheetFault):
            place = self.place(fault.spot)
        else:
            place = Place(self.file, table=fault.place.table, key=fault.place.key)
        stands, expected, nearest = fault.value, fault.expected, fault.nearest
        return CatalogueError(fault.problem, place=place, value=stands, expected=expected, nearest=nearest)

    def place(self, spot: Spot) -> Place:
        """Return where a cell is: the column by its letter and heading."""
        page = self.pages.get(spot.sheet)
        if page is None:
            return Place(self.file, spot.sheet, spot.row, spot.heading)
        name = spot.heading or ""
        row, column = spot.row, page.columns.get(name)
        if name in page.lines:
            row = page.sheet.row_number(page.lines[name])
        heading = spot.heading if column is None else f"{column_letter(column)} ({spot.heading})"
        return Place(self.file, page.sheet.name, row, heading)

    def order(self, error: CatalogueError) -> tuple[int, int, str]:
        """Return the key by which faults are listed: sheet by sheet, row by row."""
        assert error.place is not None
        names = [*(self.place(Spot(declared.name)).sheet for declared in SHEETS), error.place.sheet]
        return names.index(error.place.sheet), error.place.row or 0, error.place.column or ""


_WANTED = Sentence("a workbook (.xlsx) as 'atleak controller template' writes it")
_ALIKE = 0.6  # of a sheet's headings, by which it is recognised under another name


@dataclass(frozen=True)
class DescribedController:
    """A valve body that a workbook describes."""

    data: dict[str, Any]  # the tables, as a TOML file of the same content gives them
    controller: Controller  # as its file would give it
    units: Units  # in which the workbook's numbers are written
    notes: tuple[Sentence, ...]  # what was taken for granted and what was not read, in sentences


def is_workbook(path: str | Path) -> bool:
    """Return whether a file is a workbook, whatever its name says; False where it cannot be read."""
    try:
        with Path(path).open("rb") as stream:
            return stream.read(4) in {b"PK\x03\x04", b"\xd0\xcf\x11\xe0"}
    except OSError:
        return False


def describes_controller(sheets: Sequence[Sheet]) -> bool:
    """Return whether these sheets of a workbook describe a valve body: every sheet is there that one needs."""
    matched = _matched([sheet for sheet in sheets if not sheet.is_text], Description())
    return all(sheet.name in matched for sheet in SHEETS if sheet.needed)


@own_errors_only(CatalogueError, "name", "source")
def read_controller_workbook(source: str | Path | bytes, *, name: str | None = None) -> DescribedController:
    """Return the valve body that a workbook describes.

    Parameters
    ----------
    source
        path of a workbook (xlsx, also ods and xls), or its bytes.
    name
        what to call the file in messages; the path's own name by default.

    Raises
    ------
    CatalogueError
        with everything that is wrong in ``others``, each with its sheet, row and column; or where the file is no such
        workbook, or none is filled in.
    """
    try:
        data, file = read_bytes(source, name)
        if not data.startswith((b"PK", b"\xd0\xcf\x11\xe0")):
            raise CatalogueError(Sentence("this is no workbook"), place=Place(file), expected=_WANTED)
        sheets = read_workbook(data, file)
    except ReadingsError as error:
        expected = _WANTED if error.expected is None or "measuring sheet" in error.expected else error.expected
        raise CatalogueError(error.problem, place=error.place, value=error.value, expected=expected) from error
    into = Description()
    matched = _matched(sheets, into)
    if not matched:
        names = ", ".join(sheet.name or "" for sheet in sheets[:5])
        raise CatalogueError(Sentence("describes no valve body"), place=Place(file), value=names, expected=_WANTED)
    places = Places(file, dict(_pages(matched, into)))
    pages = list(places.pages.values())
    if not any(page.rows for page in pages):
        needed = tuple(sheet.name for sheet in SHEETS if sheet.needed)
        expected = Sentence("the sheets {sheets} filled in, at least", sheets=needed)
        raise CatalogueError(Sentence("nothing is filled in yet"), place=Place(file), expected=expected)
    units = pages[-1].units
    faults = [places.fault(fault) for fault in into.faults]
    try:
        controller = checked_controller(into.data, file)
    except CatalogueError as error:
        rows = {name: page.rows for name, page in places.pages.items()}
        faults += [places.fault(fault) for fault in in_cells(error, into, SHEETS, rows, units)]
        if not faults:
            raise
    if faults:
        raise faults_together(sorted(faults, key=places.order))
    for page in pages:
        into.notes += [
            Sentence("{where}: {problem}", where=places.place(spot).sentence, problem=text)
            for spot, text in doubts(page.declared, page.rows, units)
        ]
    return DescribedController(into.data, controller, units, tuple(into.notes))


def _pages(matched: Mapping[str, Sheet], into: Description) -> Iterator[tuple[str, Page]]:
    """Yield what each sheet holds, by its name; the head, which comes first, says the units of all."""
    units = Units()
    for declared in SHEETS:
        sheet = matched.get(declared.name)
        page = None if sheet is None else Page(sheet, declared, units, into)
        if page is not None and page.read():
            units = page.units
            if declared.at:
                into.mark(declared.at, Spot(declared.name))
            declared.fill(page.rows, into)
            yield declared.name, page
        elif declared.needed:  # and nothing more is said about what it should hold
            problem = Sentence("this sheet is missing, or its headings are")
            into.faults.append(SheetFault(Spot(declared.name), problem))
            into.left_out |= {declared.at} if declared.at else {column.keys for column in declared.columns}


def _matched(sheets: list[Sheet], into: Description) -> dict[str, Sheet]:
    """Return the workbook's sheets by the names they are declared with; a renamed one is known by its headings."""
    by_name = {words(sheet.name or ""): sheet for sheet in reversed(sheets)}
    matched = {declared.name: by_name[words(declared.name)] for declared in SHEETS if words(declared.name) in by_name}
    settled = {*map(id, matched.values()), *(id(by_name.get(words(name))) for name in (INSTRUCTIONS, LISTS))}
    for sheet in sheets:
        if id(sheet) in settled or not any(any(row) for row in sheet.rows):
            continue
        alike = [(_likeness(sheet, declared), declared.name) for declared in SHEETS if declared.name not in matched]
        likeness, best = max(alike, key=lambda each: each[0], default=(0.0, ""))
        text = Sentence("sheet {sheet!r} is not read", sheet=sheet.name)
        if likeness >= _ALIKE:
            matched[best] = sheet
            text = Sentence("sheet {sheet!r} is read as {known!r}, by its headings", sheet=sheet.name, known=best)
        into.notes.append(text)
    return matched


def _likeness(sheet: Sheet, declared: Declared) -> float:
    """Return which share of a sheet's headings, or of a form's lines, stands on a sheet of the workbook."""
    standing = {words(cell) for row in sheet.rows for cell in row if isinstance(cell, str)}
    headings = [column.heading for column in declared.columns if not (declared.is_form and column.how_known)]
    return sum(words(heading) in standing for heading in headings) / len(headings) if len(headings) > 1 else 0.0
