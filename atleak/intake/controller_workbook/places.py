"""Say in which cell of a workbook a fault stands, also one of meaning that was noticed among the tables."""

from __future__ import annotations

from dataclasses import dataclass, field

from atleak.controller_sheets.description import Description, Fault, Row, Spot
from atleak.controller_sheets.layout import SHEETS
from atleak.controller_sheets.meaning import fault_of_cell
from atleak.controller_sheets.shapes import DEFAULTS, Column
from atleak.controller_sheets.units import Units
from atleak.errors import CatalogueError, InputError, Place
from atleak.intake.controller_workbook.rows import Page
from atleak.intake.sheets.sheet import column_letter


@dataclass
class Places:
    """The sheets as they were read, by the names they are declared with."""

    file: str
    units: Units
    pages: dict[str, Page] = field(default_factory=dict)
    _said: set[tuple[Spot, str]] = field(default_factory=set)  # what was said of the head for the first of many lands

    def fault(self, fault: Fault) -> CatalogueError:
        """Return a fault as an error that names sheet, row and column."""
        return _at(self.place(fault.spot), fault)

    def place(self, spot: Spot) -> Place:
        """Return where a cell is: the column by its letter and heading."""
        page = self.pages.get(spot.sheet)
        if page is None:
            return Place(self.file, spot.sheet, spot.row, spot.heading)
        name = spot.heading or ""
        row, column = spot.row, page.columns.get(name)
        if name in page.lines:
            line, column = page.lines[name]
            row = page.sheet.row_number(line)
        heading = spot.heading if column is None else f"{column_letter(column)} ({spot.heading})"
        return Place(self.file, page.sheet.name, row, heading)

    def of_meaning(self, error: InputError, into: Description) -> CatalogueError | None:
        """Return a fault of the tables as one of the workbook; None where its cell has one already.

        Parameters
        ----------
        error
            as the check of the tables gives it, with its steps.
        into
            the description, which remembers the cell of each value.
        """
        assert error.place is not None
        steps = error.place.steps
        if into.is_unread(steps):
            return None
        spot = into.spot(steps)
        if spot is None:  # no sheet says it
            place = Place(self.file, table=error.place.table, key=error.place.key)
            return _at(place, error)
        column, row = self._column(spot), self._row(spot)
        if column is None:
            return _at(self.place(spot), error)
        if error.value is not None and (row is None or column.heading not in row.cells):
            of_all = into.spots.get((DEFAULTS, *steps[-1:]))  # a land that states nothing takes what the head says
            if of_all is not None:
                said = (of_all, str(error.value)) in self._said
                self._said.add((of_all, str(error.value)))
                return None if said else _at(self.place(of_all), error)
        return self.fault(fault_of_cell(error, column, row or Row(spot, {}, {}), self.units))

    def order(self, error: CatalogueError) -> tuple[int, int, str]:
        """Return the key by which faults are listed: sheet by sheet, row by row."""
        assert error.place is not None
        names = [self.pages[each.name].sheet.name if each.name in self.pages else each.name for each in SHEETS]
        number = names.index(error.place.sheet) if error.place.sheet in names else len(names)
        return number, error.place.row or 0, error.place.column or ""

    def _column(self, spot: Spot) -> Column | None:
        page = self.pages.get(spot.sheet)
        columns = () if page is None else page.declared.columns
        return next((column for column in columns if column.heading == spot.heading), None)

    def _row(self, spot: Spot) -> Row | None:
        page = self.pages.get(spot.sheet)
        return None if page is None else next((row for row in page.rows if row.spot.row == spot.row), None)


def _at(place: Place, fault: Fault | InputError) -> CatalogueError:
    """Return a fault as it is, at a place of the workbook."""
    return CatalogueError(fault.problem, place=place, value=fault.value, expected=fault.expected, nearest=fault.nearest)
