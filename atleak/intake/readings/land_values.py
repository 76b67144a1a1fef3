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
from atleak.errors import Message, Place, ReadingsError, one_of, unknown
from atleak.intake.readings.columns import Columns, find_columns
from atleak.intake.readings.controller_names import ControllerNames
from atleak.intake.readings.one_heading import Column
from atleak.intake.readings.sheet_tables import Table
from atleak.intake.readings.sizes import MM
from atleak.intake.readings.states import rows_left_out
from atleak.intake.readings.words import at, is_blank, number, text_of
from atleak.intake.sheets.sheet import Cell, Sheet
from atleak.intake.units import Unit, find_unit
from atleak.own_lands import LENGTHS_MEASURED, REPAIR_FITTED, FittedRepair, OwnLands, OwnLength
from atleak.phrases import named
from atleak.readings import NOMINAL_TOLERANCE
from atleak.sentence import Name, Sentence
from atleak.unit_systems import Quantity
from atleak.workshop_units import MM as TO_MM
from atleak.workshop_units import UM

SHORTEST, LONGEST = 0.2e-3, 0.1  # [m] of contact lengths that anybody measures: choice of this project
_DOUBTFUL = 2.0  # times the stated contact length, or its part: from here on a warning says so
_REFUSED = 10.0  # times, or its part: another unit, or a lost decimal point
_SAME = 1.0e-9  # [m]
_SHOWN = 6
_LENGTH = Sentence("a length such as 5.25")


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
            problem, wanted = Sentence("this cell's formula has no usable result"), Sentence("its value")
            place = sheet.place(row, column.index, column.name)
            self.values.problems.append(ReadingsError(problem, place=place, value=fault, expected=wanted))
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
        except ReadingsError as error:
            raise ReadingsError(error.problem, place=place, value=error.value, expected=_LENGTH) from error
        of_row = find_unit(text_of(table.sheet.filled(row, columns.unit.index)), "length") if columns.unit else None
        metres = (written or given_unit or of_row or column.unit or columns.sheet_unit or MM).to_si(value)
        if column.role == "contact length":
            self._check_contact_length(land, metres, cell, place)
        elif not 0.0 <= metres <= 1.0:
            problem = Sentence("no position on a spool")
            raise ReadingsError(problem, value=cell, expected=Sentence("0 or more, from the spool's left end"))
        known = self.lengths.setdefault((column.role, land.key), (metres, place))
        if abs(known[0] - metres) > _SAME:
            where = known[1].sentence
            other = Sentence("another position of {land} stands in {where} already", land=named(land), where=where)
            if column.role == "contact length":
                other = Sentence(
                    "another contact length of {land} stands in {where} already", land=named(land), where=where
                )
            raise ReadingsError(other, value=cell, expected=Sentence("each once"))

    def _component(self, table: Table, columns: Columns, row: int) -> str | None:
        """Return the component of a row; None where nothing names one, which a row of diameters reports itself."""
        if columns.component is None:
            if table.component is None and not table.header.values:
                problem = Sentence("nothing says which component this is of")
                raise ReadingsError(problem, expected=Sentence("a column 'No.'"))
            return table.component
        cell = table.sheet.filled(row, columns.component.index)
        holds = any(not is_blank(table.sheet.cell(row, value.index)) for value in table.header.values)
        if holds and self.names.component(cell) is None:
            return None
        if is_blank(cell):
            raise ReadingsError(Sentence("the row names no component"), expected=Sentence("its number or name"))
        return self.names.require_component(cell)

    def _land(self, columns: Columns, sheet: Sheet, row: int, component: str) -> Land | None:
        lands = self.controller.lands_of(component)
        column = columns.land or columns.plane
        cell = "" if column is None else sheet.filled(row, column.index)
        if column is None or is_blank(cell):
            if len(lands) == 1:
                return lands[0]
            problem = Sentence("nothing says which land of component {component} this is of", component=component)
            raise ReadingsError(problem, expected=one_of(str(land.land) for land in lands))
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
        name, stated = named(land), land.contact_length
        ratio = metres / stated
        near = any(
            abs(metres - size) <= NOMINAL_TOLERANCE for size in (land.nominal_diameter, land.nominal_sleeve_diameter)
        )
        about = Sentence(
            "about {length:.6g} {length.unit} ({land}, as the valve body's file states)", length=_mm(stated), land=name
        )
        if near and not 1.0 / _DOUBTFUL < ratio < _DOUBTFUL:
            problem = Sentence(
                "this contact length has the size of the land's diameter: a reading in the wrong column?"
            )
            raise ReadingsError(problem, value=cell, expected=about)
        if not SHORTEST <= metres <= LONGEST or not 1.0 / _REFUSED < ratio < _REFUSED:
            problem = Sentence(
                "the contact length is {ratio:.3g} times the stated one: another unit, or a decimal point lost?",
                ratio=ratio,
            )
            raise ReadingsError(problem, value=cell, expected=about)
        if not 1.0 / _DOUBTFUL < ratio < _DOUBTFUL:
            text = Sentence(
                "The contact length of {land} is {measured:.6g} {measured.unit} as measured and {stated:.6g} "
                "{stated.unit} in the valve body's file: the measured one is computed with.",
                land=name,
                measured=_mm(metres),
                stated=_mm(stated),
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
                problem = Sentence(
                    "the file of {controller} has no repairs of component {component}",
                    controller=self.controller.id,
                    component=component,
                )
                expected = Sentence("an empty cell, or [[repairs]] in that file")
                raise ReadingsError(problem, value=wanted, expected=expected)
            problem = Sentence("component {component} has no such repair", component=component)
            raise unknown(problem, wanted, options, kind=ReadingsError)
        column = columns.land or columns.plane
        if column is not None and not is_blank(sheet.filled(row, column.index)):
            land = self._land(columns, sheet, row, component)
            if land is not None and not repair.changes(land.key):
                mended = [land.land for land in self.controller.lands_of(component) if repair.changes(land.key)]
                problem = Sentence(
                    "{repair} does not change land {land} of component {component}",
                    repair=wanted,
                    land=land.land,
                    component=component,
                )
                raise ReadingsError(problem, value=wanted, expected=Sentence("land {names}", names=mended))
        for other in (options[known] for of, known in self.fitted if of == component and known != wanted):
            both = [land.land for land in self.controller.lands_of(component) if _both(repair, other, land)]
            if both:
                problem = Sentence(
                    "{repair} stands in {where} already, for land {land} too",
                    repair=other.id,
                    where=self.fitted[component, other.id].sentence,
                    land=both[0],
                )
                raise ReadingsError(problem, value=wanted, expected=Sentence("one repair of each land"))
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
    shown = tuple(
        Sentence(
            "{land} {measured:.6g} {measured.unit} ({stated:.6g})",
            land=f"{each.component}/{each.land}",
            measured=_mm(each.contact_length or 0.0),
            stated=_mm(controller.land(*each.key).contact_length),
        )
        for each in measured[:_SHOWN]
    )
    more = len(measured) - _SHOWN
    text = Sentence(
        "Contact lengths of {count} of {lands} lands are those measured on the sheet, in brackets those of the valve "
        "body's file: {shown}{more}.",
        count=len(measured),
        lands=len(controller.lands),
        shown=shown,
        more=Sentence(" and {count} more", count=more) if more > 0 else "",
    )
    yield Message("info", LENGTHS_MEASURED, text, measured[0].place)


def _about_repairs(own: OwnLands, controller: Controller) -> Iterator[Message]:
    for each in own.fitted:
        repair = next(option for option in controller.repairs_of(each.component) if option.id == each.repair)
        lands = [land for land in controller.lands_of(each.component) if repair.changes(land.key)]
        after = [land.with_repair(repair) for land in lands]
        if repair.keeps_clearance:
            text = Sentence(
                "Component {component} was given {repair}, which leaves its lands as worn as they were: none is new.",
                component=each.component,
                repair=Name(repair.label),
            )
            yield Message("info", REPAIR_FITTED, text, each.place)
            continue
        text = Sentence(
            "Component {component} has {repair} fitted, which counts as its new state: {sizes}.",
            component=each.component,
            repair=Name(repair.label),
            sizes=tuple(map(_size, after)),
        )
        yield Message("info", REPAIR_FITTED, text, each.place)


def _size(land: Land) -> Sentence:
    """Say the nominal diameter and the clearance that a land has after its repair."""
    diameter, ends = _mm(land.nominal_diameter), [Quantity(end * UM, "clearance", 1) for end in land.mounting_ends]
    if len(ends) == 1:
        return Sentence(
            "land {land} {diameter:.6g} {diameter.unit} with a new clearance of {clearance:.4g} {clearance.unit}",
            land=land.land,
            diameter=diameter,
            clearance=ends[0],
        )
    return Sentence(
        "land {land} {diameter:.6g} {diameter.unit} with a new clearance of {low:.4g} to {high:.4g} {high.unit}",
        land=land.land,
        diameter=diameter,
        low=ends[0],
        high=ends[1],
    )


def _mm(metres: float) -> Quantity:
    return Quantity(metres * TO_MM, "length", 3)
