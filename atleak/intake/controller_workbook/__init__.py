"""A workbook that describes a valve body → the tables of a controller's file, checked.

`atleak.controller_sheets.layout` declares the sheets; see ``docs/describing-a-controller.md``. Everything wrong is
listed at once, with sheet, row and column: cells that hold something else than their column asks for, and values that
do not fit each other.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_reading import checked_controller
from atleak.controller_sheets.description import Description, Fault, Spot
from atleak.controller_sheets.layout import INSTRUCTIONS, LISTS, SHEETS
from atleak.controller_sheets.meaning import doubts, in_cells
from atleak.controller_sheets.shapes import Sheet as Declared
from atleak.controller_sheets.units import Units
from atleak.doors import own_errors_only
from atleak.errors import CatalogueError, Place, ReadingsError
from atleak.faults import together
from atleak.intake.controller_workbook.places import Places
from atleak.intake.controller_workbook.rows import form_page, table_page
from atleak.intake.plain_words import words
from atleak.intake.sheets.sheet import Sheet
from atleak.intake.sheets.sheet_file import read_bytes, read_workbook
from atleak.sentence import Sentence

WANTED = Sentence("a workbook (.xlsx) as 'atleak controller template' writes it")
_ALIKE = 0.6  # of a sheet's headings, by which it is recognised under another name


@dataclass(frozen=True)
class DescribedController:
    """A valve body that a workbook describes."""

    data: dict[str, Any]  # the tables, as a TOML file of the same content gives them
    controller: Controller
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
            raise CatalogueError(Sentence("this is no workbook"), place=Place(file), expected=WANTED)
        sheets = read_workbook(data, file)
    except ReadingsError as error:
        expected = WANTED if error.expected is None or "measuring sheet" in error.expected else error.expected
        raise CatalogueError(error.problem, place=error.place, value=error.value, expected=expected) from error
    return _described(sheets, file)


def _described(sheets: list[Sheet], file: str) -> DescribedController:
    into = Description()
    matched = _matched(sheets, into)
    if not matched:
        names = ", ".join(sheet.name or "" for sheet in sheets[:5])
        raise CatalogueError(Sentence("describes no valve body"), place=Place(file), value=names, expected=WANTED)
    units, places = Units(), Places(file)
    is_empty = True
    for declared in SHEETS:
        sheet, read = matched.get(declared.name), form_page if declared.is_form else table_page
        page = None if sheet is None else read(sheet, declared, units, into)
        if page is None:
            _miss(declared, into)
            continue
        places.pages[declared.name] = page
        units = page.units
        is_empty = is_empty and not page.rows
        if declared.at:
            into.mark(declared.at, Spot(declared.name))
        declared.fill(page.rows, into)
    if is_empty:
        needed = tuple(sheet.name for sheet in SHEETS if sheet.needed)
        expected = Sentence("the sheets {sheets} filled in, at least", sheets=needed)
        raise CatalogueError(Sentence("nothing is filled in yet"), place=Place(file), expected=expected)
    faults = [places.fault(fault) for fault in into.faults]
    try:
        controller = checked_controller(into.data, file)
    except CatalogueError as error:
        rows = {name: page.rows for name, page in places.pages.items()}
        faults += [places.fault(fault) for fault in in_cells(error, into, SHEETS, rows, units)]
        if not faults:
            raise
    if faults:
        raise together(sorted(faults, key=places.order))
    for page in places.pages.values():
        into.notes += [
            Sentence("{where}: {problem}", where=places.place(spot).sentence, problem=text)
            for spot, text in doubts(page.declared, page.rows, units)
        ]
    return DescribedController(into.data, controller, units, tuple(into.notes))


def _matched(sheets: list[Sheet], into: Description) -> dict[str, Sheet]:
    """Return the workbook's sheets by the names they are declared with; a renamed one is known by its headings."""
    by_name = {words(sheet.name or ""): sheet for sheet in reversed(sheets)}
    matched = {each.name: by_name[words(each.name)] for each in SHEETS if words(each.name) in by_name}
    taken = {id(sheet) for sheet in matched.values()}
    known = {words(INSTRUCTIONS), words(LISTS)}
    for sheet in sheets:
        if id(sheet) in taken or words(sheet.name or "") in known or not any(any(row) for row in sheet.rows):
            continue
        likeness = {each.name: _likeness(sheet, each) for each in SHEETS if each.name not in matched}
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
    into.faults.append(Fault(Spot(declared.name), Sentence("this sheet is missing, or its headings are")))
    if declared.at:
        into.unread.add(declared.at)
    else:
        into.unread.update(column.keys for column in declared.columns)
