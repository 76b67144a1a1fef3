"""Turn the cells of a workbook into values of a controller's file and back, without loss, in the units that it chose.

A cell is what a workbook's reader gives: text, a number, a truth value, a date; never empty here. Numbers are computed
with decimal digits, as people write them: 0.571 inch is 14.5034 mm and nothing beside it. One that its cell could not
hold to the last digit is written as text.
"""

from __future__ import annotations

import datetime
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from decimal import Context, Decimal
from types import MappingProxyType
from typing import Any, Literal, get_args

from atleak.catalogue.written_numbers import decimal_number
from atleak.common.file_faults import NotAccepted
from atleak.common.sentences import Sentence
from atleak.common.units import gear_name

_Length = Literal["mm", "inch"]
_Clearance = Literal["radial", "diametral"]
PressureUnit = Literal["kPa", "psi", "bar"]
LENGTHS: tuple[_Length, ...] = get_args(_Length)
CLEARANCES: tuple[_Clearance, ...] = get_args(_Clearance)
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

    length: _Length = "mm"
    clearance: _Clearance = "radial"
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


REVERSE, NEUTRAL = -1, 0
EVERY = "all"
_GEARS = {"R": REVERSE, "N": NEUTRAL, "P": NEUTRAL}
_SEPARATED = re.compile(r"[\s,;+]+")
_FROM_TO = re.compile(r"(\d+)[-–—‑…](\d+)|(\d+)\.{2,3}(\d+)")
_WHOLE = re.compile(r"[-−]?\d{1,3}")
_PLAIN = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,3})?")
_MOST_GEARS = 30
_DOTTED = re.compile(r"^(\d\d)\.(\d\d)\.(\d{4})$")  # day, month and year: dots stand in no other order
_YES, _NO = {"yes", "y", "true", "x", "1"}, {"no", "n", "false", "0"}

SheetCellKind = Any  # str, float, int, bool, date


@dataclass(frozen=True)
class CellForm:
    """What the cells of a column hold: text, unless a subclass says otherwise."""

    def label(self, units: Units) -> str:
        """Return the unit that stands under the column's heading."""
        return ""

    def value(self, cell: SheetCellKind, units: Units) -> Any:
        """Return the value of the controller's file.

        Raises
        ------
        NotAccepted
            with what is wanted.
        """
        return as_text(cell)

    def cell(self, value: Any, units: Units) -> str | float:
        """Return what stands in the cell for a value of the file."""
        return str(value)


@dataclass(frozen=True)
class Day(CellForm):
    """A date."""

    def value(self, cell: SheetCellKind, units: Units) -> str:
        if isinstance(cell, datetime.date):
            return cell.isoformat()[:10]
        text = _DOTTED.sub(r"\3-\2-\1", as_text(cell))
        try:
            return datetime.date.fromisoformat(text[:10] if text[10:].strip("T 0:") == "" else text).isoformat()
        except ValueError:
            raise NotAccepted(Sentence("a day such as 2026-01-31")) from None


@dataclass(frozen=True)
class YesNo(CellForm):
    """``yes`` or ``no``."""

    def value(self, cell: SheetCellKind, units: Units) -> bool:
        text = as_text(cell).casefold()
        if text in _YES | _NO:
            return text in _YES
        raise NotAccepted(Sentence("yes or no"))

    def cell(self, value: Any, units: Units) -> str:
        return "yes" if value else "no"


@dataclass(frozen=True)
class ChoiceCell(CellForm):
    """One word of a closed list; in the workbook a blank stands for each low line, unless it is a symbol."""

    options: tuple[str, ...]
    symbols: bool = False

    @property
    def shown(self) -> tuple[str, ...]:
        """Return the list as its drop-down shows it."""
        return tuple(self.cell(option, Units()) for option in self.options)

    def value(self, cell: SheetCellKind, units: Units) -> str:
        text = as_text(cell)
        for option in self.options:
            if _alike(text) == _alike(option):
                return str(option)
        raise NotAccepted(Sentence("one of {names}", names=self.shown))

    def cell(self, value: Any, units: Units) -> str:
        return str(value) if self.symbols else str(value).replace("_", " ")


@dataclass(frozen=True)
class Number(CellForm):
    """A number with a unit."""

    measure: Measure = NUMBER

    def label(self, units: Units) -> str:
        return self.measure.label(units)

    def value(self, cell: SheetCellKind, units: Units) -> float:
        return self.measure.file_number(self.written(cell, units), units)

    def written(self, cell: SheetCellKind, units: Units) -> float | Decimal:
        """Return the number as it stands in the cell, in the workbook's unit."""
        if isinstance(cell, int | float) and not isinstance(cell, bool):
            return cell
        text = as_text(cell).replace("−", "-").removesuffix(self.label(units)).strip()
        if _PLAIN.fullmatch(text):
            return Decimal(text)
        number = decimal_number(text)
        if number is None:
            raise NotAccepted(self.wanted(units))
        return Decimal(repr(number))

    def wanted(self, units: Units) -> Sentence:
        """Say what is wanted: ``a number in µm, diametral``."""
        label = self.label(units)
        return Sentence("a number in {unit}", unit=label) if label else Sentence("a number")

    def cell(self, value: Any, units: Units) -> str | float:
        return self.measure.cell_number(value, units)


@dataclass(frozen=True)
class Whole(CellForm):
    """A whole number."""

    unit: str = ""

    def label(self, units: Units) -> str:
        return self.unit

    def value(self, cell: SheetCellKind, units: Units) -> int:
        return _whole(cell, Sentence("a whole number"))

    def cell(self, value: Any, units: Units) -> float:
        return int(value)


@dataclass(frozen=True)
class Gear(CellForm):
    """One gear: a number, R for reverse, N or P for neutral."""

    def value(self, cell: SheetCellKind, units: Units) -> int:
        gears = gears_written(cell)
        if len(gears) != 1:
            raise NotAccepted(Sentence("one gear: R, N or a number"))
        return gears[0]

    def cell(self, value: Any, units: Units) -> str | float:
        return gear_shown(value)


@dataclass(frozen=True)
class Gears(CellForm):
    """Several gears, as people write them: ``R N 1 2 3`` or ``1-5``; `EVERY` stands for all of the head's."""

    or_every: bool = True

    def value(self, cell: SheetCellKind, units: Units) -> list[int] | str:
        if self.or_every and as_text(cell).casefold() in {EVERY, "every", "every gear", "all gears"}:
            return EVERY
        return gears_written(cell)

    def cell(self, value: Any, units: Units) -> str:
        return " ".join(str(gear_shown(gear)) for gear in value)


@dataclass(frozen=True)
class Names(CellForm):
    """Several names, or words of a closed list, with commas between, or each on a line of its own."""

    options: tuple[str, ...] = ()
    or_every: bool = False  # `EVERY` stands for all names that there are

    def value(self, cell: SheetCellKind, units: Units) -> list[str] | str:
        if self.or_every and as_text(cell).casefold() == EVERY:
            return EVERY
        lines = isinstance(cell, str) and "\n" in cell
        names = [name.strip() for name in re.split(r"\n" if lines else r"[,;]", str(cell) if lines else as_text(cell))]
        names = [name for name in names if name]
        if self.options:
            names = [word for name in names for word in name.split()]
            known = {option.casefold(): option for option in self.options}
            if not all(name.casefold() in known for name in names):
                raise NotAccepted(Sentence("of {names}, with blanks or commas between", names=self.options))
            return [known[name.casefold()] for name in names]
        return names

    def cell(self, value: Any, units: Units) -> str:
        if value == EVERY:
            return EVERY
        if any(sign in name for name in value for sign in ",;"):
            return "\n".join([*value, ""])
        return ", ".join(value)


@dataclass(frozen=True)
class Wholes(CellForm):
    """Several whole numbers, with blanks or commas between."""

    def value(self, cell: SheetCellKind, units: Units) -> list[int]:
        wanted = Sentence("whole numbers with blanks between, such as 1 2 3")
        if isinstance(cell, str):
            return [_whole(part, wanted) for part in _SEPARATED.split(cell.strip()) if part]
        return [_whole(cell, wanted)]

    def cell(self, value: Any, units: Units) -> str:
        return " ".join(map(str, value))


def gears_written(cell: SheetCellKind) -> list[int]:
    """Return the gears that a cell names.

    Raises
    ------
    NotAccepted
        where it names none, or something else beside them.

    >>> gears_written("P R N 1-3, 5"), gears_written(4.0)
    ([0, -1, 1, 2, 3, 5], [4])
    """
    wanted = Sentence("gears such as R N 1 2 3, with blanks between, or 1-3")
    if not isinstance(cell, str):
        return [_whole(cell, wanted)]
    gears: list[int] = []
    for word in _SEPARATED.split(re.sub(r"(?<=\d)\s*([-–—‑…]|\.\.\.?)\s*(?=\d)", r"\1", cell.strip())):
        if word.upper() in _GEARS:
            if _GEARS[word.upper()] not in gears or word.upper() == "R":  # people write both P and N
                gears.append(_GEARS[word.upper()])
        elif ends := _FROM_TO.fullmatch(word):
            first, last = (int(end) for end in ends.groups() if end is not None)
            if not first < last <= first + _MOST_GEARS:
                raise NotAccepted(wanted)
            gears += range(first, last + 1)
        elif _WHOLE.fullmatch(word):
            gears.append(int(word.replace("−", "-")))
        else:
            raise NotAccepted(wanted)
    return gears


def gear_shown(gear: int) -> str | int:
    """Return a gear as a workbook shows it: R and N by their letters."""
    return gear if gear > NEUTRAL else gear_name(gear)


def as_text(cell: SheetCellKind) -> str:
    """Return a cell as text: a whole number without its decimal point, a day as it is written in a file.

    >>> as_text(8.0), as_text(" 12' "), as_text(0.5)
    ('8', "12'", '0.5')
    """
    if isinstance(cell, bool):
        return "yes" if cell else "no"
    if isinstance(cell, float) and cell.is_integer():
        return str(int(cell))
    if isinstance(cell, datetime.date):
        return cell.isoformat()
    return str(cell).strip()


def _whole(cell: SheetCellKind, wanted: Sentence) -> int:
    if isinstance(cell, str):
        cell = decimal_number(cell.replace("−", "-"))
    if isinstance(cell, int | float) and not isinstance(cell, bool) and float(cell).is_integer():
        return int(cell)
    raise NotAccepted(wanted)


def _alike(text: str) -> str:
    return re.sub(r"[\s_-]+", " ", text).strip().casefold()
