"""A table of a vacuum test (workbook or text) → the stand and its readings, each with its place.

Rows about the stand begin with ``supply``, ``ambient``, ``temperature``, ``orifice``, ``flow area`` or ``calibration``;
all others are readings of a circuit or of lands, see ``docs/vacuum-and-flows.md``. Everything wrong is listed at once.
"""

from __future__ import annotations

import datetime as dt
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from itertools import zip_longest
from pathlib import Path
from typing import NamedTuple

from atleak.catalogue.controller import Controller
from atleak.catalogue.repairs import LandKey
from atleak.catalogue.written_numbers import AskedNumber
from atleak.common.damage import own_errors_only
from atleak.common.errors import InputError, Message, Place, ReadingsError, VacuumTableError, one_of
from atleak.common.sentences import Sentence
from atleak.common.units import Quantity, Unit, find_unit, unit
from atleak.measurements.gauge_readings import LINE_TAP
from atleak.measurements.own_forms import VACUUM
from atleak.measurements.vacuum import (
    STANDARD_ATMOSPHERE,
    USUAL_SUPPLY,
    Calibration,
    VacuumReading,
    VacuumStand,
    VacuumTable,
)
from atleak.readers.cells.sheet import Cell, text_of
from atleak.readers.dates import words
from atleak.readers.gauges.gauge_headings import GaugeWords
from atleak.readers.gauges.value_table import (
    Amount,
    Faults,
    ValueFile,
    ValueFinder,
    ValueTable,
    first_cell,
    is_nothing,
    is_number,
    label_of,
    not_typed_as_number,
    phrases,
    split_cell,
    unit_in,
)
from atleak.readers.sheets.controller_names import ControllerNames

_VACUUM = AskedNumber(Sentence("vacuum below ambient"), "in-Hg", 17.5, (0.0, 31.0))
_SUPPLY = AskedNumber(Sentence("supply vacuum"), "in-Hg", 25.0, (3.0, 31.0))
_AMBIENT = AskedNumber(Sentence("ambient pressure"), "kPa", 101.3, (60.0, 110.0))
_TEMPERATURE = AskedNumber(Sentence("temperature"), "°C", 20.5, (-10.0, 60.0))
_ORIFICE = AskedNumber(Sentence("orifice diameter"), "mm", 0.5, (0.05, 5.0))
_FLOW_AREA = AskedNumber(Sentence("flow area"), "mm²", 0.157, (0.001, 20.0))
_MM = unit("mm", "length")
_OVER_SUPPLY = 3386.389  # [Pa], 1 in-Hg, by which a gauge may show more than the supply: choice of this project
_ORDER = ("target", "reading", "unit", "orifice", "state")
_WANTED = Sentence("a table of a vacuum test as .xlsx workbook or .csv text")
_HEADINGS = Sentence(
    "rows for the stand (supply, 25, in-Hg) and headings such as: circuit or component/land, reading, unit, orifice, "
    "state"
)


class _Stated(NamedTuple):
    """A number of a row about the stand, and what is said of its unit."""

    cell: Cell
    column: int
    unit: str


@dataclass
class _Rows(Faults):
    """What the rows of all tables give."""

    error: type[InputError] = VacuumTableError
    readings: list[VacuumReading] = field(default_factory=list)
    calibrations: list[Calibration] = field(default_factory=list)
    stated: dict[str, float] = field(default_factory=dict)  # of the stand, in SI; temperatures in °C
    supply_place: Place = Place()  # noqa: RUF009  frozen, so safe to share
    rows: int = 0  # that are to hold a reading
    unit: Unit | None = None  # of the supply's vacuum: that of all where none is stated

    @property
    def ambient(self) -> float:
        """Return the pressure of the air [Pa], as stated or assumed."""
        return self.stated.get("ambient", STANDARD_ATMOSPHERE)

    @property
    def supply(self) -> float:
        """Return the supply's vacuum [Pa], as stated or assumed: then no more than the air's own pressure."""
        return self.stated.get("supply", min(USUAL_SUPPLY, self.ambient))

    def refuse_impossible(self) -> None:
        """Note a supply of more vacuum than there is air, and calibrations that no stand can show."""
        shown = self.unit or unit("in-Hg", "pressure")

        def written(vacuum: float) -> str:
            return f"{shown.from_si(vacuum):.4g} {shown.name}"

        if self.supply > self.ambient:
            problem = Sentence("more vacuum than the pressure of the air allows")
            expected = Sentence("at most {vacuum}", vacuum=written(self.ambient))
            self.refuse(problem, self.supply_place, written(self.supply), expected=expected)
        for each in self.calibrations:
            if not 0.0 < each.vacuum < self.supply:
                problem = Sentence("no stand shows this with air coming in through a known orifice")
                expected = Sentence("more than 0 and less than the supply's {vacuum}", vacuum=written(self.supply))
                self.refuse(problem, each.place, written(each.vacuum), expected=expected)


class _Targets:
    """The circuits and lands that a table may name."""

    def __init__(self, controller: Controller) -> None:
        self.controller, self.names = controller, ControllerNames(controller)
        self.circuits = {name: tap for name, tap in GaugeWords.of(controller).taps.items() if tap != LINE_TAP}

    def named(self, cell: Cell) -> tuple[str | None, tuple[LandKey, ...]]:
        """Return the circuit, where the whole cell names one, and the lands that are meant.

        A `ReadingsError` says which part names neither a circuit nor a land.
        """
        text, lands = text_of(cell), dict[LandKey, None]()
        whole = self.circuits.get(words(text))
        for part in text.split("+") if whole is None else (text,):
            circuit = self.circuits.get(words(part))
            component, slash, land = part.rpartition("/")
            if circuit is not None:
                lands |= dict.fromkeys(around.key for around in self.controller.lands_around(circuit))
            elif slash:
                lands[self.names.land(self.names.require_component(component.strip()), land.strip()).key] = None
            else:
                circuits = tuple(each.id for each in self.controller.circuits)
                expected = _LAND if not circuits else Sentence("{land}, or {names}", land=_LAND, names=one_of(circuits))
                raise ReadingsError(Sentence("no circuit or land of this unit"), value=part.strip(), expected=expected)
        return whole, tuple(lands)


_LAND = Sentence("component/land such as 8/1, several joined with +")


class _Reader:
    """Reads the rows of one table."""

    def __init__(self, table: ValueTable, targets: _Targets, rows: _Rows) -> None:
        self.table, self.sheet, self.targets, self.rows = table, table.sheet, targets, rows
        self.calibrated = dict[int, str]()  # units over the columns of calibrations

    def read(self) -> None:
        """Read the rows about the stand, its supply first, whose unit holds for all that state none."""
        stand, readings = [], []
        going_on: int | None = None  # the column of a label whose rows go on below it
        for row in range(len(self.sheet.rows)):
            cell, column = first_cell(self.sheet, row)
            label = label_of(str(cell).partition(":")[0], "vacuum_stand") if row != self.table.row else None
            if label is None and going_on is not None and column > going_on and is_number(split_cell(cell)[0]):
                stand.append(("calibration", row, going_on))
            elif label is not None:
                stand.append((label, row, column))
                going_on = column if label == "calibration" else None
            else:
                going_on = None
                if cell != "" and row > self.table.row:
                    readings.append(row)
        for label, row, column in sorted(stand, key=lambda each: each[0] != "supply"):
            self._stand(label, row, column)
        self.rows.rows += len(readings)
        for row, (column,) in self.table.filled(readings, self.rows):
            self._reading(row, column)

    def _stand(self, label: str, row: int, column: int) -> None:
        stated = self._numbers(row, column)
        if label == "calibration":
            self._calibration(row, column, stated)
        elif not stated:
            cell = self.sheet.cell(row, column)
            problem, expected = Sentence("no value stands beside it"), Sentence("a number with its unit")
            self.rows.refuse(problem, self.table.place(row, column), text_of(cell), expected=expected)
        else:
            asked, of = _OF_STAND[label]
            amount = self._amount(row, stated[0], asked, of, None if of == "pressure" else unit(asked.unit, of))
            if amount is not None:
                self.rows.stated[label] = amount.si
                if label == "supply":
                    self.rows.supply_place, self.rows.unit = self.table.place(row, stated[0].column), amount.unit

    def _numbers(self, row: int, column: int) -> list[_Stated]:
        """Return the numbers behind a label, each with the unit behind it, in the next cell or in the label."""
        sheet, found = self.sheet, []
        text = text_of(sheet.cell(row, column))
        rest = text.partition(":")[2].strip()
        cells: list[tuple[Cell, int]] = [(rest, column)] if rest and sheet.merged.get((row, column)) is None else []
        cells += [(sheet.cell(row, at), at) for at in range(column + 1, len(sheet.rows[row]))]
        for (cell, at), (beside, _) in zip_longest(cells, cells[1:], fillvalue=("", 0)):
            number, behind = split_cell(cell)
            if is_nothing(cell) or not (is_number(number) or not_typed_as_number(cell)):
                continue
            if not behind and isinstance(beside, str) and not is_number(split_cell(beside)[0]):
                behind = beside.strip()
            found.append(_Stated(cell, at, behind or unit_in(text) or self.calibrated.get(at, "")))
        return found

    def _amount(self, row: int, stated: _Stated, asked: AskedNumber, of: str, usual: Unit | None) -> Amount | None:
        """Return a number about the stand; None where it is a problem."""
        place = self.table.place(row, stated.column)
        cell = _without_sign(stated.cell) if of == "pressure" else stated.cell
        return self.rows.number(cell, place, asked, of, (stated.unit, place), usual)

    def _calibration(self, row: int, column: int, stated: Sequence[_Stated]) -> None:
        """Read the known orifice, what the stand showed, and the stand's own orifice where that is stated."""
        if not stated:  # headings over calibrations that stand below
            texts = ((at, unit_in(text_of(cell))) for at, cell in enumerate(self.sheet.rows[row]))
            self.calibrated = {at: said for at, said in texts if said}
            return
        said = [
            [kind for kind in ("length", "pressure") if each.unit and find_unit(each.unit, kind)] for each in stated
        ]
        kinds = [next(iter(kind), None) for kind in said]
        if None in kinds and "pressure" not in kinds and len(kinds) > 1:
            free = [at for at, kind in enumerate(kinds) if kind is None]
            kinds[next((at for at in free if at > 0), free[0])] = "pressure"
        sizes = [each for each, kind in zip(stated, kinds, strict=True) if kind != "pressure"]
        shown = [each for each, kind in zip(stated, kinds, strict=True) if kind == "pressure"]
        place = self.table.place(row, column)
        if not sizes or len(shown) != 1:
            expected = Sentence("the known orifice and what the stand showed: calibration, 0.5 mm, 21.6 in-Hg")
            self.rows.refuse(Sentence("not a calibration"), place, expected=expected)
            return
        known, *own = (self._amount(row, each, _ORIFICE, "length", _MM) for each in sizes[:2])
        vacuum = self._amount(row, shown[0], _VACUUM, "pressure", self.rows.unit)
        if vacuum is not None and known is not None and None not in own:
            fitted = own[0].si if own and own[0] else None
            self.rows.calibrations.append(Calibration(known.si, vacuum.si, fitted, place))

    def _reading(self, row: int, column: int) -> None:
        table, rows = self.table, self.rows
        named = self._target(row)
        vacuum = self._vacuum(row, column)
        orifice = None
        if table.cell(row, "orifice") != "":
            orifice = table.number(rows, row, table.columns["orifice"], _ORIFICE, "length", _MM)
        state = text_of(table.cell(row, "state"))
        known = phrases("vacuum_states").get(words(state)) if state else "worn"
        if known is None:
            accepted = ("worn", "repaired")
            rows.refuse(Sentence("no such state of a bore"), table.place_of(row, "state"), state, accepted)
        if named is not None and vacuum is not None and known is not None:
            target, size, place = text_of(table.cell(row, "target")), orifice and orifice.si, table.place(row, column)
            rows.readings.append(VacuumReading(target, *named, vacuum, size, known == "repaired", place))

    def _target(self, row: int) -> tuple[str | None, tuple[LandKey, ...]] | None:
        cell, place = self.table.cell(row, "target"), self.table.place_of(row, "target")
        problem, expected = Sentence("no land leaks from this circuit"), _LAND
        if isinstance(cell, dt.date | dt.time):
            problem = Sentence("the spreadsheet made a date of a land")
            expected = Sentence("{land}, in a cell formatted as text", land=_LAND)
        else:
            try:
                circuit, lands = self.targets.named(cell)
            except ReadingsError as error:
                self.rows.problems.append(
                    VacuumTableError(
                        error.problem, place=place, value=error.value, expected=error.expected, nearest=error.nearest
                    )
                )
                return None
            if lands:
                return circuit, lands
        self.rows.refuse(problem, place, text_of(cell), expected=expected)
        return None

    def _vacuum(self, row: int, column: int) -> float | None:
        """Return what the gauge showed [Pa]; never more than the supply, as far as that is known."""
        table, rows = self.table, self.rows
        vacuum = table.number(rows, row, column, _VACUUM, "pressure", rows.unit, change=_without_sign)
        if vacuum is None or vacuum.si <= rows.supply + _OVER_SUPPLY:
            return None if vacuum is None else vacuum.si
        shown = rows.unit or vacuum.unit
        expected = Sentence("0 to {supply:.4g} {unit}", supply=shown.from_si(rows.supply), unit=shown.name)
        found = text_of(self.sheet.filled(row, column))
        rows.refuse(Sentence("more than the stand's supply"), table.place(row, column), found, expected=expected)
        return None


_OF_STAND = {
    "supply": (_SUPPLY, "pressure"),
    "ambient": (_AMBIENT, "pressure"),
    "temperature": (_TEMPERATURE, "temperature"),
    "orifice": (_ORIFICE, "length"),
    "flow_area": (_FLOW_AREA, "area"),
}


def _without_sign(cell: Cell) -> Cell:
    """Return a vacuum that is written as a negative pressure as what it is below ambient."""
    if isinstance(cell, int | float) and not isinstance(cell, bool):
        return abs(cell)
    return cell.strip().lstrip("-−– ") if isinstance(cell, str) else cell


def vacuum_finder(controller: Controller) -> ValueFinder:
    """Return what finds tables of vacuum tests."""
    targets = _Targets(controller)

    def begins(cell: Cell) -> bool:
        with suppress(ReadingsError):
            return isinstance(cell, str) and bool(targets.named(cell)[1])
        return False

    return ValueFinder(VACUUM, "vacuum_columns", ("target", "reading"), _ORDER, begins)


@own_errors_only(VacuumTableError, "name", "source")
def read_vacuum_table(source: str | Path | bytes, controller: Controller, *, name: str | None = None) -> VacuumTable:
    """Return a vacuum test from a file: the stand, and what its gauge showed of circuits and lands.

    Pressures are in pascals and sizes in metres, each with its place in the file; ``messages`` say what was assumed.

    Raises
    ------
    VacuumTableError
        with all problems found: an unknown circuit, land, state or unit, a cell that is no vacuum, more vacuum than
        the supply, a supply of more than the air's pressure, a calibration that no stand can show; or where the file
        as a whole holds no such table, or none filled in.
    """
    targets, finder = _Targets(controller), vacuum_finder(controller)
    missing = VacuumTableError(Sentence("holds no table of a vacuum test"), expected=_HEADINGS)
    held = ValueFile.open(source, name, finder.find, finder.likeness, missing, _WANTED)
    rows = _Rows()
    for table in held.tables:
        _Reader(table, targets, rows).read()
    rows.refuse_impossible()
    rows.settle()
    if not rows.readings and (rows.rows or not rows.stated):
        problem, expected = Sentence("no reading is filled in"), Sentence("at least one reading of a circuit or land")
        raise VacuumTableError(problem, place=Place(held.file), expected=expected)
    orifice = rows.stated.pop("orifice", None)
    if orifice is not None:
        rows.readings = [each if each.orifice else replace(each, orifice=orifice) for each in rows.readings]
    return VacuumTable(
        held.file,
        held.sha256,
        held.sheet,
        VacuumStand(**{**rows.stated, "supply": rows.supply}, calibrations=tuple(rows.calibrations)),
        tuple(rows.readings),
        (*held.notes, *_assumed(rows, Place(held.file)), *rows.messages),
    )


def _assumed(rows: _Rows, place: Place) -> Iterator[Message]:
    """Yield what of the stand is assumed because the table does not say it."""
    shown = rows.unit or unit("in-Hg", "pressure")
    stated = {
        "supply": (rows.supply, Sentence("the table states no supply vacuum: {value:.4g} {unit} assumed")),
        "ambient": (STANDARD_ATMOSPHERE, Sentence("the table states no ambient pressure: {value:.4g} {unit} assumed")),
    }
    for name, (value, text) in stated.items():
        if name not in rows.stated:
            yield Message("info", f"{name}_assumed", text.of(value=shown.from_si(value), unit=shown.name), place)
    if not rows.readings:
        text = Sentence("the table describes a stand, and holds no reading")
        yield Message("warning", "no_vacuum_reading", text, place)
    if "temperature" not in rows.stated:
        text = Sentence("the table states no temperature: {value:g} {value.unit} assumed")
        yield Message("info", "temperature_assumed", text.of(value=Quantity(20.0, "temperature")), place)
