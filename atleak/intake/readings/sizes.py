"""Whether a number has the size of a diameter of the controller."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Collection, Iterable

from atleak.catalogue.controller import Controller
from atleak.intake.readings.words import numbers_in
from atleak.intake.sheets.sheet import Cell
from atleak.intake.units import Unit, unit
from atleak.readings import NOMINAL_TOLERANCE

_INCH_DECIMALS = 3  # a diameter in inches has at least so many; 0.5 is half a millimetre of something
ROUNDED = 0.51e-6  # [m] by which a number that was rounded to a micrometre may be off
UNITS = MM, UM, INCH = tuple(unit(name, "length") for name in ("mm", "µm", "inch"))


class Sizes:
    """The nominal diameters [m] of a controller, spools and sleeves."""

    def __init__(self, controller: Controller) -> None:
        self._by_plane = {
            (land.component, plane): (land.nominal_diameter, land.nominal_sleeve_diameter)
            for land in controller.lands
            for plane in land.planes
        }
        self._all = sorted({size for sizes in self._by_plane.values() for size in sizes})

    def near(self, value: float, units: Iterable[Unit]) -> bool:
        """Return whether a number in one of the units is within 0.5 mm of any nominal diameter."""
        for each in units:
            size = each.to_si(value)
            if each == INCH and round(value, _INCH_DECIMALS - 1) == value:
                continue
            above = bisect_left(self._all, size - NOMINAL_TOLERANCE)
            if above < len(self._all) and self._all[above] <= size + NOMINAL_TOLERANCE:
                return True
        return False

    def fill(self, cells: Collection[Cell]) -> bool:
        """Return whether most of the cells hold a number of that size, in mm, µm or inches."""
        return 2 * sum(any(self.near(value, UNITS) for value in numbers_of(cell)) for cell in cells) > len(cells)

    def near_plane(
        self, value: float, units: Iterable[Unit], component: str, plane: str, within: float = NOMINAL_TOLERANCE
    ) -> bool:
        """Return whether a number is within 0.5 mm of the nominal diameters of one plane, or within another limit."""
        nominal = self._by_plane.get((component, plane), ())
        return any(abs(each.to_si(value) - size) <= within for each in units for size in nominal)


def numbers_of(cell: Cell) -> tuple[float, ...]:
    """Return the number of a cell, or those that its text mentions."""
    if isinstance(cell, bool):
        return ()
    if isinstance(cell, int | float):
        return (float(cell),)
    return numbers_in(cell) if isinstance(cell, str) and cell else ()


def is_coarse(cell: Cell) -> bool:
    """Return whether a number in millimetres has one decimal at most: a length, a temperature, a running number.

    >>> is_coarse(18.2), is_coarse("18.000"), is_coarse(17.998)
    (True, True, False)
    """
    return all(round(value, 1) == value for value in numbers_of(cell))


def is_whole(cell: Cell) -> bool:
    """Return whether a number is written without decimals: a count or a name more often than a diameter."""
    if isinstance(cell, str):
        return not any(sign in cell for sign in ".,")
    return isinstance(cell, int) or (isinstance(cell, float) and cell.is_integer())
