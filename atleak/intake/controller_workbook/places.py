"""Say in which cell of a workbook a fault stands, also one of meaning that was noticed among the tables."""

from __future__ import annotations

from dataclasses import dataclass, field

from atleak.controller_sheets.description import Fault, Spot
from atleak.controller_sheets.layout import SHEETS
from atleak.errors import CatalogueError, InputError, Place
from atleak.intake.controller_workbook.rows import Page
from atleak.intake.sheets.sheet import column_letter


@dataclass
class Places:
    """The sheets as they were read, by the names they are declared with."""

    file: str
    pages: dict[str, Page] = field(default_factory=dict)

    def fault(self, fault: Fault | InputError) -> CatalogueError:
        """Return a fault as an error that names sheet, row and column, or table and key where no sheet says it."""
        if isinstance(fault, Fault):
            return _at(self.place(fault.spot), fault)
        return _at(Place(self.file, table=fault.place.table, key=fault.place.key), fault)

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
        names = [self.pages[each.name].sheet.name if each.name in self.pages else each.name for each in SHEETS]
        number = names.index(error.place.sheet) if error.place.sheet in names else len(names)
        return number, error.place.row or 0, error.place.column or ""


def _at(place: Place, fault: Fault | InputError) -> CatalogueError:
    """Return a fault as it is, at a place of the workbook."""
    return CatalogueError(fault.problem, place=place, value=fault.value, expected=fault.expected, nearest=fault.nearest)
