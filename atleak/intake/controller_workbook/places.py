"""Say in which cell of a workbook a fault stands, also one of meaning that was noticed among the tables."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from atleak.controller_sheets.description import Description, Fault, Row, Spot
from atleak.controller_sheets.kinds import Number
from atleak.controller_sheets.layout import SHEETS
from atleak.controller_sheets.shapes import Column
from atleak.controller_sheets.units import Units
from atleak.errors import CatalogueError, Place
from atleak.intake.controller_workbook.rows import Page
from atleak.intake.sheets.sheet import column_letter

_LENGTHS = {"mm": 1e-3, "µm": 1e-6, "inch": 0.0254}


@dataclass
class Places:
    """The sheets as they were read, by the names they are declared with."""

    file: str
    units: Units
    pages: dict[str, Page] = field(default_factory=dict)

    def fault(self, fault: Fault) -> CatalogueError:
        """Return a fault as an error that names sheet, row and column."""
        return CatalogueError(
            fault.problem,
            place=self.place(fault.spot),
            value=fault.value,
            expected=fault.expected,
            nearest=fault.nearest,
        )

    def place(self, spot: Spot) -> Place:
        """Return where a cell is: the column by its letter and heading."""
        page = self.pages.get(spot.sheet)
        if page is None:
            return Place(self.file, spot.sheet, spot.row, spot.heading)
        row, column = spot.row, page.columns.get(spot.heading or "")
        if spot.heading in page.lines:
            line, column = page.lines[spot.heading]
            row = page.sheet.row_number(line)
        heading = spot.heading if column is None else f"{column_letter(column)} ({spot.heading})"
        return Place(self.file, page.sheet.name, row, heading)

    def of_meaning(self, error: CatalogueError, into: Description) -> CatalogueError | None:
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
        if spot is None:
            return CatalogueError(
                error.problem,
                place=Place(self.file, table=error.place.table, key=error.place.key),
                value=error.value,
                expected=error.expected,
                nearest=error.nearest,
            )
        column, row = self._column(spot), self._row(spot)
        if column is None or row is None:
            return CatalogueError(
                error.problem,
                place=self.place(spot),
                value=error.value,
                expected=error.expected,
                nearest=error.nearest,
            )
        if column.heading not in row.cells:
            expected = column.kind.wanted(self.units) if isinstance(column.kind, Number) else None
            return CatalogueError("this cell must be filled in", place=self.place(spot), expected=expected)
        return CatalogueError(
            error.problem + self._converted(column, row),
            place=self.place(spot),
            value=row.cells[column.heading],
            expected=f"{error.expected or 'another value'}{self._other_unit(column, row)}",
            nearest=error.nearest,
        )

    def _converted(self, column: Column, row: Row) -> str:
        """Say what a number is in the unit of the file, where that is another one, since limits are stated in it."""
        value: Any = row.values.get(column.heading)
        kind = column.kind
        if not isinstance(kind, Number) or not isinstance(value, float) or kind.value(1.0, self.units) == 1.0:
            return ""
        return f" (it is {value:.6g} {kind.label(Units())})"

    def _other_unit(self, column: Column, row: Row) -> str:
        """Ask for the unit in which a length would be a usual one, where it is none as it stands."""
        kind, cell = column.kind, row.cells[column.heading]
        if not isinstance(kind, Number) or kind.measure.usual == (0.0, 0.0) or column.heading not in row.values:
            return ""
        low, high = kind.measure.usual
        if low <= row.values[column.heading] <= high:
            return ""
        number = float(kind.written(cell, self.units)) if isinstance(cell, int | float) else 0.0
        sides = 2.0 if kind.measure.of_clearance and self.units.clearance == "diametral" else 1.0
        names = [name for name, si in _LENGTHS.items() if low <= number * si / float(kind.measure.si) / sides <= high]
        return f"; was it in {' or '.join(names)}?" if names else ""

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
