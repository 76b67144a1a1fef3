"""What a sheet says of a land itself, beside its diameters: contact length, position, and which repair is fitted.

The columns may stand among the diameters or in a table of their own, as on the form's tab of lands. One cell filled in
is enough for a land, and one for a repair.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from itertools import product

from atleak.catalogue.controller import Controller, Land
from atleak.catalogue.repairs import LandKey
from atleak.catalogue.words import named
from atleak.common.errors import Message, Place, ReadingsError, one_of, unknown
from atleak.common.sentences import Name, Sentence
from atleak.common.units import MM as TO_MM
from atleak.common.units import UM, Quantity, Unit, find_unit
from atleak.measurements.clearances import NOMINAL_TOLERANCE
from atleak.measurements.readings import LENGTHS_MEASURED, REPAIR_FITTED, FittedRepair, OwnLands, OwnLength
from atleak.readers.cells.sheet import Cell
from atleak.readers.sheets.column_headings import HeadedColumn
from atleak.readers.sheets.columns import find_columns
from atleak.readers.sheets.controller_names import MILLIMETRE, ControllerNames
from atleak.readers.sheets.repeats import rows_left_out
from atleak.readers.sheets.table import HeadedTable
from atleak.readers.sheets.words import at, is_blank, number, text_of

SHORTEST, _LONGEST = 0.2e-3, 0.1  # [m] of contact lengths that anybody measures: choice of this project
_DOUBTFUL = 2.0  # times the stated contact length, or its part: from here on a warning says so
_REFUSED = 10.0  # times, or its part: another unit, or a lost decimal point
_SAME = 1.0e-9  # [m]
_LENGTH = Sentence("a length such as 5.25")


def read_land_values(
    tables: Sequence[HeadedTable],
    names: ControllerNames,
    given_unit: Unit | None = None,
    where: Mapping[str, str] | None = None,
) -> LandValues:
    """Read contact lengths, positions and fitted repairs from the tables that have such columns.

    ``given_unit`` is that of the lengths where the user states it, and ``where`` says which rows count.
    """
    values = LandValues(names)
    for table in tables:
        if table.of_lands:
            _LandRows(values, table, given_unit).read(rows_left_out(table, where or {}))
    values.messages += [*_about_lengths(values.own, names.controller), *_about_repairs(values.own, names.controller)]
    return values


class LandValues:
    """What was read of lands themselves; ``cells`` are those it was read from, by sheet, row and column."""

    def __init__(self, names: ControllerNames) -> None:
        self.names = names
        self.lengths: dict[LandKey, dict[str, tuple[float, Place]]] = defaultdict(dict)
        self.fitted: dict[tuple[str, str], Place] = {}
        self.cells: list[tuple[str | None, int, int]] = []
        self.problems: list[ReadingsError] = []
        self.messages: list[Message] = []

    @cached_property
    def own(self) -> OwnLands:
        """Return what lands have of their own, once all is read."""
        lengths = tuple(_own_length(key, stated) for key, stated in self.lengths.items())
        return OwnLands(lengths, tuple(FittedRepair(*key, place) for key, place in self.fitted.items()))


class _LandRows:
    def __init__(self, values: LandValues, table: HeadedTable, given_unit: Unit | None) -> None:
        self.values, self.table, self.sheet, self.given_unit = values, table, table.sheet, given_unit
        self.names, self.controller = values.names, values.names.controller
        self.columns = find_columns(table, self.names)
        self.place_column = self.columns.land or self.columns.plane

    def read(self, left_out: frozenset[int]) -> None:
        for row, column in product(self.table.rows, self.table.of_lands):
            self.values.cells.append((self.sheet.name, row, column.index))
            if row in left_out or self.sheet.is_struck(row, column.index):
                continue
            place = self.table.place(row, column)
            try:
                self._read_cell(row, column, place)
            except ReadingsError as problem:
                self.values.problems.append(problem if problem.place.file else at(place, problem))

    def _read_cell(self, row: int, column: HeadedColumn, place: Place) -> None:
        cell, fault = self.sheet.cell(row, column.index), self.sheet.faults.get((row, column.index))
        if is_blank(cell) and fault is not None:
            problem, wanted = Sentence("this cell's formula has no usable result"), Sentence("its value")
            raise ReadingsError(problem, value=fault, expected=wanted)
        component = None if is_blank(cell) else self._component(row)
        if component is None:
            return
        if column.role == "fitted repair":
            self._take_repair(component, row, text_of(cell), place)
            return
        land = self._land(row, component)
        try:
            value, written = number(cell)
        except ReadingsError as error:
            raise ReadingsError(error.problem, value=error.value, expected=_LENGTH) from error
        unit, of_row = self.columns.unit, None
        if unit is not None:
            of_row = find_unit(text_of(self.sheet.filled(row, unit.index)), "length")
        stated = written or self.given_unit or of_row or column.unit or self.columns.sheet_unit
        metres = (stated or MILLIMETRE).to_si(value)
        template = Sentence("another position of {land} stands in {where} already")
        if column.role == "contact length":
            self._check_contact_length(land, metres, cell, place)
            template = Sentence("another contact length of {land} stands in {where} already")
        elif not 0.0 <= metres <= 1.0:
            problem = Sentence("no position on a spool")
            raise ReadingsError(problem, value=cell, expected=Sentence("0 or more, from the spool's left end"))
        earlier = self.values.lengths[land.key].setdefault(column.role, (metres, place))
        if abs(earlier[0] - metres) > _SAME:
            problem = template.of(land=named(land), where=earlier[1].sentence)
            raise ReadingsError(problem, value=cell, expected=Sentence("each once"))

    def _component(self, row: int) -> str | None:
        """Return the component of a row; None where nothing names one, which a row of diameters reports itself."""
        table = self.table
        if self.columns.component is None:
            if table.component is None and not table.values:
                problem = Sentence("nothing says which component this is of")
                raise ReadingsError(problem, expected=Sentence("a column 'No.'"))
            return table.component
        cell = self.sheet.filled(row, self.columns.component.index)
        holds = any(not is_blank(self.sheet.cell(row, value.index)) for value in table.values)
        if holds and self.names.component(cell) is None:
            return None
        if is_blank(cell):
            raise ReadingsError(Sentence("the row names no component"), expected=Sentence("its number or name"))
        return self.names.require_component(cell)

    def _place_cell(self, row: int) -> Cell:
        cell = "" if self.place_column is None else self.sheet.filled(row, self.place_column.index)
        return "" if is_blank(cell) else cell

    def _land(self, row: int, component: str) -> Land:
        lands, cell = self.controller.lands_of(component), self._place_cell(row)
        if cell == "" and len(lands) == 1:
            return lands[0]
        if cell == "":
            problem = Sentence("nothing says which land of component {component} this is of", component=component)
            raise ReadingsError(problem, expected=one_of(str(land.land) for land in lands))
        if self.columns.land is not None:
            return self.names.land(component, cell)
        plane = self.names.plane(component, cell)
        return next(land for land in lands if plane in land.planes)

    def _check_contact_length(self, land: Land, metres: float, cell: Cell, place: Place) -> None:
        name, stated = named(land), land.contact_length
        ratio = metres / stated
        doubtful = not 1.0 / _DOUBTFUL < ratio < _DOUBTFUL
        diameters = (land.nominal_diameter, land.nominal_sleeve_diameter)
        problem = None
        if doubtful and any(abs(metres - size) <= NOMINAL_TOLERANCE for size in diameters):
            problem = Sentence(
                "this contact length has the size of the land's diameter: a reading in the wrong column?"
            )
        elif not SHORTEST <= metres <= _LONGEST or not 1.0 / _REFUSED < ratio < _REFUSED:
            problem = Sentence(
                "the contact length is {ratio:.3g} times the stated one: another unit, or a decimal point lost?",
                ratio=ratio,
            )
        if problem is not None:
            about = Sentence("about {length:.6g} {length.unit} ({land}, as the valve body's file states)")
            raise ReadingsError(problem, value=cell, expected=about.of(length=_mm(stated), land=name))
        if doubtful:
            text = Sentence(
                "The contact length of {land} is {measured:.6g} {measured.unit} as measured and {stated:.6g} "
                "{stated.unit} in the valve body's file: the measured one is computed with."
            )
            text = text.of(land=name, measured=_mm(metres), stated=_mm(stated))
            self.values.messages.append(Message("warning", "contact_length_differs", text, place))

    def _take_repair(self, component: str, row: int, wanted: str, place: Place) -> None:
        options = {repair.id: repair for repair in self.controller.repairs_of(component)}
        if not options:
            problem = Sentence("the file of {controller} has no repairs of component {component}")
            raise ReadingsError(
                problem.of(controller=self.controller.id, component=component),
                value=wanted,
                expected=Sentence("an empty cell, or [[repairs]] in that file"),
            )
        if wanted not in options:
            problem = Sentence("component {component} has no such repair", component=component)
            raise unknown(problem, wanted, options, kind=ReadingsError)
        repair, lands, fitted = options[wanted], self.controller.lands_of(component), self.values.fitted
        if self._place_cell(row) != "":
            land = self._land(row, component)
            if not repair.changes(land.key):
                mended = [land.land for land in lands if repair.changes(land.key)]
                problem = Sentence("{repair} does not change land {land} of component {component}")
                raise ReadingsError(
                    problem.of(repair=wanted, land=land.land, component=component),
                    value=wanted,
                    expected=Sentence("land {names}", names=mended),
                )
        for other in (options[repair_id] for of, repair_id in fitted if of == component and repair_id != wanted):
            both = [land.land for land in lands if repair.changes(land.key) and other.changes(land.key)]
            if both:
                problem = Sentence("{repair} stands in {where} already, for land {land} too")
                where = fitted[component, other.id].sentence
                raise ReadingsError(
                    problem.of(repair=other.id, where=where, land=both[0]),
                    value=wanted,
                    expected=Sentence("one repair of each land"),
                )
        fitted.setdefault((component, wanted), place)


def _own_length(key: LandKey, stated: Mapping[str, tuple[float, Place]]) -> OwnLength:
    contact, position = stated.get("contact length", (None,)), stated.get("position", (None,))
    return OwnLength(*key, contact[0], position[0], next(place for _, place in stated.values()))


def _about_lengths(own: OwnLands, controller: Controller) -> Iterator[Message]:
    measured = [length for length in own.lengths if length.contact_length is not None]
    if not measured:
        return
    text = Sentence(
        "Contact lengths of {count} of {lands} lands are those measured on the sheet, not those of the valve body's "
        "file.",
        count=len(measured),
        lands=len(controller.lands),
    )
    yield Message("info", LENGTHS_MEASURED, text, measured[0].place)


def _about_repairs(own: OwnLands, controller: Controller) -> Iterator[Message]:
    for fitted in own.fitted:
        repair = next(option for option in controller.repairs_of(fitted.component) if option.id == fitted.repair)
        lands = [land for land in controller.lands_of(fitted.component) if repair.changes(land.key)]
        template = Sentence("Component {component} has {repair} fitted, which counts as its new state: {sizes}.")
        if repair.keeps_clearance:
            template = Sentence(
                "Component {component} was given {repair}, which leaves its lands as worn as they were: none is new."
            )
        sizes = () if repair.keeps_clearance else tuple(_size(land.with_repair(repair)) for land in lands)
        text = template.of(component=fitted.component, repair=Name(repair.label), sizes=sizes)
        yield Message("info", REPAIR_FITTED, text, fitted.place)


def _size(land: Land) -> Sentence:
    ends = [Quantity(end * UM, "clearance", 1) for end in land.mounting_ends]
    template = Sentence("land {land} {diameter:.6g} {diameter.unit} with a new clearance of {low:.4g} {low.unit}")
    if len(ends) > 1:
        template = Sentence(
            "land {land} {diameter:.6g} {diameter.unit} with a new clearance of {low:.4g} to {high:.4g} {high.unit}"
        )
    return template.of(land=land.land, diameter=_mm(land.nominal_diameter), low=ends[0], high=ends[-1])


def _mm(metres: float) -> Quantity:
    return Quantity(metres * TO_MM, "length", 3)
