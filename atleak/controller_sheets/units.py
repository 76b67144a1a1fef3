"""Convert the numbers of a controller's file to the units that a workbook's author chose, and back without loss.

Everything is computed with decimal digits, as people write them: 0.571 inch is 14.5034 mm and nothing beside it. A
number that its cell could not hold to the last digit is written as text.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from decimal import Context, Decimal
from types import MappingProxyType
from typing import Literal, get_args

Length = Literal["mm", "inch"]
Clearance = Literal["radial", "diametral"]
PressureUnit = Literal["kPa", "psi", "bar"]
LENGTHS: tuple[Length, ...] = get_args(Length)
CLEARANCES: tuple[Clearance, ...] = get_args(Clearance)
PRESSURES: tuple[PressureUnit, ...] = get_args(PressureUnit)

_KPA: dict[str, Decimal] = {
    "kPa": Decimal(1),
    "psi": Decimal("6.894757293168361336722673"),  # 4.4482216152605 N on (25.4 mm)²
    "bar": Decimal(100),
}
_MM = Decimal("25.4")  # of an inch, by definition
_EXACT = Context(prec=40)
_CELL = Context(prec=13)  # digits of a converted number: two fewer than every spreadsheet program keeps


@dataclass(frozen=True)
class Units:
    """What a workbook's numbers are written in; chosen once, on its first sheet."""

    length: Length = "mm"
    clearance: Clearance = "radial"
    pressure: PressureUnit = "kPa"


@dataclass(frozen=True)
class Measure:
    """A kind of number: its unit in a workbook, and how much one of it is in the unit of the controller's file."""

    metric: str  # the unit, where lengths are in mm
    inch: str = ""  # where they are in inches; "" for the same
    factor: Decimal = Decimal(1)  # the file's value of one of the metric unit
    inch_factor: Decimal = Decimal(1)
    of_clearance: bool = False  # twice as much where clearances are diametral
    of_pressure: bool = False
    quantity: str = ""  # as the table of units calls it, where a cell may name a unit of its own: "length"
    si: Decimal = Decimal(1)  # of one of the file's unit
    usual: tuple[float, float] = (0.0, 0.0)  # in the file's unit: outside of it another unit may have been meant
    is_doubted: bool = False  # outside of that range, even where the file's check accepts it

    def label(self, units: Units) -> str:
        """Return the unit as the column's heading says it."""
        if self.of_pressure:
            return units.pressure
        label = self.inch if self.inch and units.length == "inch" else self.metric
        return f"{label}, {units.clearance}" if self.of_clearance else label

    def file_number(self, cell: float | str | Decimal, units: Units) -> float:
        """Return what a cell's number is in the unit of the controller's file.

        A number is converted to 13 digits, since a spreadsheet program keeps 15 of it; digits that stand as text are
        all taken.

        >>> LENGTH.file_number(0.571, Units("inch")), LENGTH.file_number(14.503 / 25.4, Units("inch"))
        (14.5034, 14.503)
        """
        number = Decimal(repr(float(cell))) if isinstance(cell, int | float) else Decimal(cell)
        converted = _EXACT.multiply(number, self._factor(units))
        if isinstance(cell, int | float) and converted != number:
            converted = _CELL.plus(converted)
        return float(converted)

    def cell_number(self, value: float, units: Units) -> float | str:
        """Return what stands in a cell for a number of the file, so that `file_number` gives it back to the last digit.

        >>> LENGTH.cell_number(14.503, Units()), LENGTH.cell_number(14.5034, Units("inch"))
        (14.503, 0.571)
        """
        exact = _EXACT.divide(Decimal(repr(float(value))), self._factor(units))
        number = float(f"{float(exact):.16g}")  # as a workbook keeps it
        return number if self.file_number(number, units) == float(value) else str(Context(prec=30).plus(exact))

    def _factor(self, units: Units) -> Decimal:
        if self.of_pressure:
            return _KPA[units.pressure]
        factor = self.inch_factor if self.inch and units.length == "inch" else self.factor
        return factor / 2 if self.of_clearance and units.clearance == "diametral" else factor


LENGTH = Measure("mm", "inch", Decimal(1), _MM, quantity="length", si=Decimal("1e-3"), usual=(0.5, 100.0))
SMALL_LENGTH = Measure("µm", "inch", Decimal(1), _MM * 1000, quantity="length", si=Decimal("1e-6"))
CLEARANCE = replace(SMALL_LENGTH, of_clearance=True)
PRESSURE = Measure("kPa", of_pressure=True, quantity="pressure", si=Decimal(1000))
VOLUME = Measure("mm³", "inch³", Decimal(1), _MM**3)
EXPANSION = Measure("10⁻⁶/K", factor=Decimal("1e-6"))
NUMBER = Measure("")
MEASURES: Mapping[str, Measure] = MappingProxyType(  # by the unit of a file's key, where a workbook may have another
    {
        "mm": LENGTH,
        "µm": SMALL_LENGTH,
        "mm³": VOLUME,
        "kPa": PRESSURE,
        "1/K": EXPANSION,
    }
)
