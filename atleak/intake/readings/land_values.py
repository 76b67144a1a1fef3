"""What a sheet says of a land itself, beside its diameters: contact length, position, and which repair is fitted.

The columns may stand among the diameters or in a table of their own, as on the form's tab of lands. One cell filled in
is enough for a land, and one for a repair.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from atleak.catalogue.complaints import LandKey
from atleak.catalogue.controller import Controller, Land
from atleak.catalogue.repairs import Repair
from atleak.errors import Message, Place, ReadingsError, unknown
from atleak.intake.readings.columns import Columns, find_columns
from atleak.intake.readings.controller_names import ControllerNames
from atleak.intake.readings.headings import Column
from atleak.intake.readings.sheet_tables import Table
from atleak.intake.readings.sizes import MM
from atleak.intake.readings.states import rows_left_out
from atleak.intake.readings.words import at, is_blank, number, text_of
from atleak.intake.sheets.sheet import Cell, Sheet
from atleak.intake.units import Unit, find_unit
from atleak.own_lands import LENGTHS_MEASURED, REPAIR_FITTED, FittedRepair, OwnLands, OwnLength
from atleak.readings import NOMINAL_TOLERANCE

SHORTEST, LONGEST = 0.2e-3, 0.1  # [m] of contact lengths that anybody measures: choice of this project
_DOUBTFUL = 2.0  # times the stated contact length, or its part: from here on a warning says so
_REFUSED = 10.0  # times, or its part: another unit, or a lost decimal point
_SAME = 1.0e-9  # [m]
_SHOWN = 6
_LENGTH = "a length such as 5.25"


@dataclass
class LandValues:
    """What was read of lands themselves; ``cells`` are those it was read from, by sheet, row and column."""

    own: OwnLands = field(default_factory=OwnLands)
    cells: list[tuple[str | None, int, int]] = field(default_factory=list)
    problems: list[ReadingsError] = field(default_factory=list)
    messages: list[Message] = field(default_factory=list)


def read_land_values(
    tables: Sequence[Table],
    names: ControllerNames,
    given_unit: Unit | None = None,
    where: Mapping[str, str] | None = None,
) -> LandValues:
    """Read contact lengths, positions and fitted repairs from the tables that have such columns.

    Parameters
    ----------
    tables
        those with diameters, and those of lands alone.
    given_unit
        unit of the lengths, as of the diameters, where the user states it.
    where
        which rows count, by heading and value.
    """
    reader = _Reader(names)
    for table in tables:
        if table.header.of_lands:
            reader.read(table, given_unit, rows_left_out(table, where or {}))
    return reader.result()


class _Reader:
    def __init__(self, names: ControllerNames) -> None:
        self.names, self.controller = names, names.controller
        self.lengths: dict[tuple[str, LandKey], tuple[float, Place]] = {}
        self.fitted: dict[tuple[str, str], Place] = {}
        self.values = LandValues()

    def read(self, table: Table, given_unit: Unit | None, left_out: frozenset[int]) -> None:
        sheet, columns = table.sheet, find_columns(table, self.names)
        for row in table.rows:
            for column in table.header.of_lands:
                self.values.cells.append((sheet.name, row, column.index))
                cell = sheet.cell(row, column.index)
                if row in left_out or sheet.is_struck(row, column.index) or self._is_empty(sheet, row, column):
                    continue
                try:
                    self._read_cell(table, columns, row, column, cell, given_unit)
                except ReadingsError as problem:
                    place = sheet.place(row, column.index, column.name)
                    self.values.problems.append(problem if problem.place.file else at(place, problem))

    def _is_empty(self, sheet: Sheet, row: int, column: Column) -> bool:
        fault = sheet.faults.get((row, column.index))
        if fault is not None and is_blank(sheet.cell(row, column.index)):
            problem = "this cell's formula has no usable result"
            place = sheet.place(row, column.index, column.name)
            self.values.problems.append(ReadingsError(problem, place=place, value=fault, expected="its value"))
        return is_blank(sheet.cell(row, column.index))

    def _read_cell(
        self, table: Table, columns: Columns, row: int, column: Column, cell: Cell, given_unit: Unit | None
    ) -> None:
        place = table.sheet.place(row, column.index, column.name)
        component = self._component(table, columns, row)
        if component is None:
            return
        if column.role == "fitted repair":
            self._take_repair(component, columns, table.sheet, row, text_of(cell), place)
            return
        land = self._land(columns, table.sheet, row, component)
        if land is None:
            return
        try:
            value, written = number(cell)
        except ReadingsError as problem:
            raise ReadingsError(problem.problem, place=place, value=problem.value, expected=_LENGTH) from problem
        of_row = find_unit(text_of(table.sheet.filled(row, columns.unit.index)), "length") if columns.unit else None
        metres = (written or given_unit or of_row or column.unit or columns.sheet_unit or MM).to_si(value)
        if column.role == "contact length":
            self._check_contact_length(land, metres, cell, place)
        elif not 0.0 <= metres <= 1.0:
            raise ReadingsError("no position on a spool", value=cell, expected="0 or more, from the spool's left end")
        known = self.lengths.setdefault((column.role, land.key), (metres, place))
        if abs(known[0] - metres) > _SAME:
            other = f"another {column.role} of component {land.component} land {land.land} stands in {known[1]} already"
            raise ReadingsError(other, value=cell, expected="each once")

    def _component(self, table: Table, columns: Columns, row: int) -> str | None:
        """Return the component of a row; None where nothing names one, which a row of diameters reports itself."""
        if columns.component is None:
            if table.component is None and not table.header.values:
                raise ReadingsError("nothing says which component this is of", expected="a column 'No.'")
            return table.component
        cell = table.sheet.filled(row, columns.component.index)
        holds = any(not is_blank(table.sheet.cell(row, value.index)) for value in table.header.values)
        if holds and self.names.component(cell) is None:
            return None
        if is_blank(cell):
            raise ReadingsError("the row names no component", expected="its number or name")
        return self.names.require_component(cell)

    def _land(self, columns: Columns, sheet: Sheet, row: int, component: str) -> Land | None:
        lands = self.controller.lands_of(component)
        column = columns.land or columns.plane
        cell = "" if column is None else sheet.filled(row, column.index)
        if column is None or is_blank(cell):
            if len(lands) == 1:
                return lands[0]
            expected = f"one of {', '.join(str(land.land) for land in lands)}"
            raise ReadingsError(f"nothing says which land of component {component} this is of", expected=expected)
        if column is columns.land:
            return self.names.land(component, cell)
        return self.controller.land_of_plane(component, self.names.plane(component, cell))

    def _check_contact_length(self, land: Land, metres: float, cell: Cell, place: Place) -> None:
        """Refuse what is no contact length of that land.

        Raises
        ------
        ReadingsError
            a length that nobody measures, one that the land's diameter is taken for, or one off by a factor of units.
        """
        name, stated = f"component {land.component} land {land.land}", land.contact_length
        ratio = metres / stated
        near = any(
            abs(metres - size) <= NOMINAL_TOLERANCE for size in (land.nominal_diameter, land.nominal_sleeve_diameter)
        )
        about = f"about {_mm(stated)} mm ({name}, as the valve body's file states)"
        if near and not 1.0 / _DOUBTFUL < ratio < _DOUBTFUL:
            problem = "this contact length has the size of the land's diameter: a reading in the wrong column?"
            raise ReadingsError(problem, value=cell, expected=about)
        if not SHORTEST <= metres <= LONGEST or not 1.0 / _REFUSED < ratio < _REFUSED:
            problem = f"the contact length is {ratio:.3g} times the stated one: another unit, or a decimal point lost?"
            raise ReadingsError(problem, value=cell, expected=about)
        if not 1.0 / _DOUBTFUL < ratio < _DOUBTFUL:
            text = (
                f"The contact length of {name} is {_mm(metres)} mm as measured and {_mm(stated)} mm in the valve "
                "body's file: the measured one is computed with."
            )
            self.values.messages.append(Message("warning", "contact_length_differs", text, place))

    def _take_repair(self, component: str, columns: Columns, sheet: Sheet, row: int, wanted: str, place: Place) -> None:
        """Note a repair that is fitted.

        Raises
        ------
        ReadingsError
            one that the controller's file does not have for that component or land, or that stands beside another.
        """
        options = {repair.id: repair for repair in self.controller.repairs_of(component)}
        repair = options.get(wanted)
        if repair is None:
            if not options:
                problem = f"the file of {self.controller.id} has no repairs of component {component}"
                raise ReadingsError(problem, value=wanted, expected="an empty cell, or [[repairs]] in that file")
            raise unknown(f"component {component} has no such repair", wanted, options, kind=ReadingsError)
        column = columns.land or columns.plane
        if column is not None and not is_blank(sheet.filled(row, column.index)):
            land = self._land(columns, sheet, row, component)
            if land is not None and not repair.changes(land.key):
                mended = [land.land for land in self.controller.lands_of(component) if repair.changes(land.key)]
                problem = f"{wanted} does not change land {land.land} of component {component}"
                raise ReadingsError(problem, value=wanted, expected=f"land {', '.join(map(str, mended))}")
        for other in (options[known] for of, known in self.fitted if of == component and known != wanted):
            both = [land.land for land in self.controller.lands_of(component) if _both(repair, other, land)]
            if both:
                problem = f"{other.id} stands in {self.fitted[component, other.id]} already, for land {both[0]} too"
                raise ReadingsError(problem, value=wanted, expected="one repair of each land")
        self.fitted.setdefault((component, wanted), place)

    def result(self) -> LandValues:
        lengths: dict[LandKey, dict[str, tuple[float, Place]]] = {}
        for (role, key), stated in self.lengths.items():
            lengths.setdefault(key, {})[role] = stated
        own = OwnLands(
            tuple(_own_length(key, stated) for key, stated in lengths.items()),
            tuple(FittedRepair(component, repair, place) for (component, repair), place in self.fitted.items()),
        )
        self.values.own = own
        self.values.messages += [*_about_lengths(own, self.controller), *_about_repairs(own, self.controller)]
        return self.values


def _both(repair: Repair, other: Repair, land: Land) -> bool:
    return repair.changes(land.key) and other.changes(land.key)


def _own_length(key: LandKey, stated: Mapping[str, tuple[float, Place]]) -> OwnLength:
    contact, position = stated.get("contact length"), stated.get("position")
    first = contact or position
    assert first is not None
    return OwnLength(*key, contact and contact[0], position and position[0], first[1])


def _about_lengths(own: OwnLands, controller: Controller) -> Iterator[Message]:
    measured = [each for each in own.lengths if each.contact_length is not None]
    if not measured:
        return
    shown = ", ".join(
        f"{each.component}/{each.land} {_mm(each.contact_length or 0.0)} mm "
        f"({_mm(controller.land(*each.key).contact_length)})"
        for each in measured[:_SHOWN]
    )
    more = f" and {len(measured) - _SHOWN} more" if len(measured) > _SHOWN else ""
    text = (
        f"Contact lengths of {len(measured)} of {len(controller.lands)} lands are those measured on the sheet, in "
        f"brackets those of the valve body's file: {shown}{more}."
    )
    yield Message("info", LENGTHS_MEASURED, text, measured[0].place)


def _about_repairs(own: OwnLands, controller: Controller) -> Iterator[Message]:
    for each in own.fitted:
        repair = next(option for option in controller.repairs_of(each.component) if option.id == each.repair)
        lands = [land for land in controller.lands_of(each.component) if repair.changes(land.key)]
        after = [land.with_repair(repair) for land in lands]
        sizes = ", ".join(
            f"land {land.land} {_mm(land.nominal_diameter)} mm with a new clearance of "
            + " to ".join(f"{end * 1e6:.4g}" for end in land.mounting_ends)
            + " µm"
            for land in after
        )
        text = f"Component {each.component} has {repair.label} fitted, which counts as its new state: {sizes}."
        yield Message("info", REPAIR_FITTED, text, each.place)


def _mm(metres: float) -> str:
    return f"{metres * 1e3:.6g}"
