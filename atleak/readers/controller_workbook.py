"""A workbook that describes a valve body → the tables of a controller's file, checked.

`atleak.catalogue.workbook.sheets` declares the sheets; see ``docs/describing-a-controller.md``. Everything wrong is
listed at once, with sheet, row and column: cells that hold something else than their column asks for, and values that
do not fit each other.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterator, Mapping, Sequence
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
    """A sheet as it was read: its rows, and where the cells of each heading stand."""

    sheet: Sheet
    declared: Declared
    units: Units  # in which its numbers are written
    rows: list[WorkbookRow] = field(default_factory=list)
    columns: dict[str, int] = field(default_factory=dict)  # by heading
    lines: dict[str, int] = field(default_factory=dict)  # row by heading, of a form

    def read(self, spot: Spot, places: Mapping[SheetColumn, tuple[int, int]], into: Description) -> WorkbookRow:
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
                into.faults.append(SheetFault(Spot(spot.sheet, spot.row, column.heading), fault[0], cell, fault[1]))
        return WorkbookRow(spot, cells, values)


def form_page(sheet: Sheet, declared: Declared, units: Units, into: Description) -> Page | None:
    """Read a sheet with one key on each line; None where its headings are missing.

    Parameters
    ----------
    units
        in which its numbers are written, unless it is the head, which says so itself.
    """
    top = _heading_row(sheet, [FIELD, VALUE])
    if top is None:
        return None
    headed = {words(as_text(cell)): number for number, cell in reversed(list(enumerate(sheet.rows[top])))}
    places = _places(sheet, declared, range(top + 1, len(sheet.rows)), headed, into)
    page = Page(
        *(sheet, declared, units),
        columns={line.heading: column for line, (_, column) in places.items()},
        lines={line.heading: row for line, (row, _) in places.items()},
    )
    note = headed.get(words(NOTE_HEADING))
    if note is not None:
        _say_lost(sheet, [row for row in range(top + 1, len(sheet.rows)) if _own(sheet, row, note)], into)
    if declared is HEAD:
        of_units = {line: places.pop(line) for line in UNIT_LINES if line in places}
        page.units = _chosen(page.read(Spot(declared.name), of_units, into), into)
    row_read = page.read(Spot(declared.name), places, into)
    page.rows = [row_read] if row_read.cells else []
    return page


def _places(
    sheet: Sheet, declared: Declared, rows: range, headed: Mapping[str, int], into: Description
) -> dict[SheetColumn, tuple[int, int]]:
    """Return where the value of each line of a form stands, and how it is known."""
    label_column, value_column, known_column = headed[words(FIELD)], headed[words(VALUE)], headed.get(words(HOW_KNOWN))
    every = (*(UNIT_LINES if declared is HEAD else ()), *declared.columns)
    lines = {words(line.heading): line for line in every if not line.how_known}
    basis_lines = {line.how_known: line for line in every if line.how_known}
    places: dict[SheetColumn, tuple[int, int]] = {}
    for row in rows:
        label = as_text(sheet.cell(row, label_column))
        line, spot = lines.get(words(label)), Spot(declared.name, sheet.row_number(row))
        if line is None:
            if label and _raw(sheet, row, value_column) is not None:
                headings = [known_line.heading for known_line in lines.values()]
                nearest = nearest_name(label, headings)
                into.faults.append(SheetFault(spot, Sentence("unknown field"), label, one_of(headings), nearest))
            continue
        for column, asked in ((value_column, line), (known_column, basis_lines.get(line.key))):
            if asked is None or column is None:
                continue
            if places.setdefault(asked, (row, column))[0] != row and _raw(sheet, row, column) is not None:
                into.faults.append(SheetFault(spot, Sentence("field given twice"), label, Sentence("each field once")))
    return places


def _chosen(row: WorkbookRow, into: Description) -> Units:
    """Return what the workbook's numbers are written in."""
    for line in UNIT_LINES:
        if line.heading not in row.cells and isinstance(line.kind, ChoiceCell):
            into.fault(row, line.heading, Sentence("not chosen"), one_of(line.kind.shown))
    return Units(**{line.key: row.values[line.heading] for line in UNIT_LINES if line.heading in row.values})


def table_page(sheet: Sheet, declared: Declared, units: Units, into: Description) -> Page | None:
    """Read a sheet with one table on each row; None where its headings are missing. Parameters as of `form_page`."""
    top = _heading_row(sheet, [column.heading for column in declared.columns])
    if top is None:
        return None
    columns = _columns(sheet, top, declared, into)
    page = Page(sheet, declared, units, columns={column.heading: number for number, column in columns.items()})
    note = next((number for number in range(sheet.width) if _is(sheet.cell(top, number), NOTE_HEADING)), None)
    absent = [column.heading for column in declared.columns if column.required and column.heading not in page.columns]
    for heading in absent:
        problem = Sentence("the column {heading!r} is missing", heading=heading)
        into.faults.append(SheetFault(Spot(declared.name, sheet.row_number(top)), problem))
    remarks: list[int] = []
    for row in range(top + 1, len(sheet.rows)):
        mark = "" if note is None else sheet.cell(row, note)
        spot = Spot(declared.name, sheet.row_number(row))
        if row == top + 1 and _is(mark, UNIT_MARK):
            _check_units(sheet, row, columns, declared, units, into)
        elif not any(_own(sheet, row, number) for number in columns):
            continue
        elif not _is(mark, EXAMPLE_MARK):
            remarks += [row] if as_text(mark) else []
            read = page.read(spot, {column: (row, number) for number, column in columns.items()}, into)
            page.rows.append(replace(read, absent=frozenset(absent)))
        elif not _is_example(sheet, row, columns, declared):
            problem = Sentence("a row marked as an example was changed")
            expected = Sentence("the example as it was, or no {mark!r} before a row of your own", mark=EXAMPLE_MARK)
            into.faults.append(SheetFault(spot, problem, expected=expected))
    _say_lost(sheet, remarks, into)
    return page


def _heading_row(sheet: Sheet, headings: Sequence[str]) -> int | None:
    """Return the row in which most of the headings stand, the first of several; None where none does."""
    wanted = {words(heading) for heading in headings}
    best, most = None, 0
    for row in range(min(len(sheet.rows), _LOOKED_AT)):
        score = len({words(as_text(cell)) for cell in sheet.rows[row]} & wanted)
        if score > most:
            best, most = row, score
    return best if most >= min(2, len(wanted)) else None


def _columns(sheet: Sheet, top: int, declared: Declared, into: Description) -> dict[int, SheetColumn]:
    """Return the columns by their place; a heading that means nothing is a fault where something stands below it."""
    by_words = {words(column.heading): column for column in declared.columns}
    columns: dict[int, SheetColumn] = {}
    for number in range(sheet.width):
        heading = sheet.cell(top, number)
        if _is(heading, NOTE_HEADING):
            continue
        column = by_words.get(words(as_text(heading))) or (declared.further_column(heading) if heading != "" else None)
        spot = Spot(declared.name, sheet.row_number(top), as_text(heading) or None)
        if column is not None and all(column.heading != taken.heading for taken in columns.values()):
            columns[number] = column
        elif any(_own(sheet, row, number) for row in range(top + 1, len(sheet.rows))):
            if column is not None:
                into.faults.append(
                    SheetFault(spot, Sentence("column given twice"), heading, Sentence("each column once"))
                )
                continue
            headings = [column.heading for column in declared.columns]
            nearest = nearest_name(as_text(heading), headings)
            problem = Sentence("unknown column")
            if heading == "":
                letter = column_letter(number)
                problem = Sentence("column {letter} holds something and has no heading", letter=letter)
            into.faults.append(SheetFault(spot, problem, heading or None, one_of(headings), nearest))
    return columns


def _check_units(
    sheet: Sheet, row: int, columns: Mapping[int, SheetColumn], declared: Declared, units: Units, into: Description
) -> None:
    """Compare the units under the headings with those of the head, where a program has worked them out."""
    for number, column in columns.items():
        label, stands = column.kind.label(units), as_text(sheet.cell(row, number))
        if stands and words(stands) != words(label):
            spot = Spot(declared.name, sheet.row_number(row), column.heading)
            as_said = Sentence("{unit}, as the sheet Head says", unit=label)
            expected = as_said if label else Sentence("no unit")
            into.faults.append(SheetFault(spot, Sentence("another unit than that of the workbook"), stands, expected))


def _is_example(sheet: Sheet, row: int, columns: Mapping[int, SheetColumn], declared: Declared) -> bool:
    """Return whether a row is an example as it was written, in whichever units."""
    cells = {column.heading: _raw(sheet, row, number) for number, column in columns.items()}
    shown = {heading: as_text(cell) for heading, cell in cells.items() if cell is not None}
    return any(
        shown
        == {
            column.heading: as_text(column.kind.cell(example[column.heading], Units(*choice)))
            for column in columns.values()
            if column.heading in example
        }
        for example in examples(declared)
        for choice in itertools.product(LENGTHS, CLEARANCES, PRESSURES)
    )


def _say_lost(sheet: Sheet, rows: Sequence[int], into: Description) -> None:
    """Say which remarks are not carried over."""
    if rows:
        where = rows_named(sheet, rows)
        into.notes.append(
            Sentence(
                "sheet {sheet!r}, {rows}: what stands under {heading} is not carried over",
                sheet=sheet.name,
                rows=where,
                heading=NOTE_HEADING,
            )
        )


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
        return CatalogueError(
            fault.problem, place=place, value=fault.value, expected=fault.expected, nearest=fault.nearest
        )

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
        names = [self.place(Spot(declared.name)).sheet for declared in SHEETS]
        number = names.index(error.place.sheet) if error.place.sheet in names else len(names)
        return number, error.place.row or 0, error.place.column or ""


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
    return _described(sheets, file)


def _described(sheets: list[Sheet], file: str) -> DescribedController:
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
        sheet, read = matched.get(declared.name), form_page if declared.is_form else table_page
        page = None if sheet is None else read(sheet, declared, units, into)
        if page is None:
            _miss(declared, into)
            continue
        units = page.units
        if declared.at:
            into.mark(declared.at, Spot(declared.name))
        declared.fill(page.rows, into)
        yield declared.name, page


def _matched(sheets: list[Sheet], into: Description) -> dict[str, Sheet]:
    """Return the workbook's sheets by the names they are declared with; a renamed one is known by its headings."""
    by_name = {words(sheet.name or ""): sheet for sheet in reversed(sheets)}
    matched = {declared.name: by_name[words(declared.name)] for declared in SHEETS if words(declared.name) in by_name}
    taken = {id(sheet) for sheet in matched.values()}
    without_entries = {words(INSTRUCTIONS), words(LISTS)}
    for sheet in sheets:
        if id(sheet) in taken or words(sheet.name or "") in without_entries or not any(any(row) for row in sheet.rows):
            continue
        likeness = {declared.name: _likeness(sheet, declared) for declared in SHEETS if declared.name not in matched}
        best = max(likeness, key=lambda name: likeness[name], default=None)
        if best is not None and likeness[best] >= _ALIKE:
            matched[best] = sheet
            into.notes.append(
                Sentence("sheet {sheet!r} is read as {known!r}, by its headings", sheet=sheet.name, known=best)
            )
        else:
            into.notes.append(Sentence("sheet {sheet!r} is not read", sheet=sheet.name))
    return matched


def _likeness(sheet: Sheet, declared: Declared) -> float:
    """Return which share of a sheet's headings, or of a form's lines, stands on a sheet of the workbook."""
    standing = {words(cell) for row in sheet.rows for cell in row if isinstance(cell, str)}
    headings = [column.heading for column in declared.columns if not (declared.is_form and column.how_known)]
    return sum(words(heading) in standing for heading in headings) / len(headings) if len(headings) > 1 else 0.0


def _miss(declared: Declared, into: Description) -> None:
    """Say that a sheet is missing which no valve body goes without, and nothing more about what it should hold."""
    if not declared.needed:
        return
    into.faults.append(SheetFault(Spot(declared.name), Sentence("this sheet is missing, or its headings are")))
    if declared.at:
        into.left_out.add(declared.at)
    else:
        into.left_out.update(column.keys for column in declared.columns)
