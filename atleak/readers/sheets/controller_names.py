"""Whether a number has the size of a diameter of the controller.

Which of a controller's components and lands a sheet means.
"""

from __future__ import annotations

import re
from bisect import bisect_left
from collections import Counter
from collections.abc import Collection, Iterable
from functools import cached_property

from atleak.catalogue.controller import Controller, Land
from atleak.common.errors import ReadingsError, nearest_name
from atleak.common.sentences import Name, Sentence
from atleak.common.translations import languages
from atleak.common.units import Unit, unit
from atleak.common.wording import wording
from atleak.measurements.clearances import NOMINAL_TOLERANCE
from atleak.readers.cells.sheet import Cell
from atleak.readers.sheets.words import numbers_in, plain, plane_names, text_of

_INCH_DECIMALS = 3  # a diameter in inches has at least so many; 0.5 is half a millimetre of something
ROUNDED = 0.51e-6  # [m] by which a number that was rounded to a micrometre may be off
UNITS = MILLIMETRE, _UM, INCH = tuple(unit(name, "length") for name in ("mm", "µm", "inch"))


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
        for length_unit in units:
            size = length_unit.to_si(value)
            if length_unit == INCH and round(value, _INCH_DECIMALS - 1) == value:
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
        return any(abs(length_unit.to_si(value) - size) <= within for length_unit in units for size in nominal)


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


_LEADING = re.compile(
    r"^(?:no|nr|number|component|comp|valve|damper|item|pos|bauteil|ventil|element|#)[\s.:]*(?=\S)", re.I
)
_LISTED = 12  # valid names worth listing in a message


class ControllerNames:
    """The names that a sheet for one controller may use."""

    def __init__(self, controller: Controller) -> None:
        self.controller = controller
        self._named: dict[str, bool] = {}
        self._planes: dict[tuple[str, str], Land] = {
            (land.component, plain(plane)): land for land in controller.lands for plane in land.planes
        }

    @cached_property
    def with_lands(self) -> tuple[str, ...]:
        return tuple(dict.fromkeys(land.component for land in self.controller.lands))

    @cached_property
    def _spellings(self) -> dict[str, str]:
        spelled: dict[str, str] = {}
        for language in languages():
            say = wording(language)
            names = {part: plain(say.name(name)) for part, name in self.controller.components.items()}
            often = Counter(names.values())
            spelled |= {name: component for component, name in names.items() if often[name] == 1}
        for component in self.controller.components:
            spelled[plain(component)] = component
            spelled.setdefault(plain(component.replace("_", " ")), component)
        return spelled

    @cached_property
    def by_length(self) -> list[tuple[str, str]]:
        """Return every spelling of a component with its id, the longest first."""
        return sorted(self._spellings.items(), key=lambda pair: -len(pair[0]))

    def component(self, cell: Cell) -> str | None:
        """Return the component that a cell names, by number or name, with or without lands; None where none is."""
        text = text_of(cell)
        for spelling in (text, _LEADING.sub("", text)):
            component = self._spellings.get(plain(spelling))
            if component is not None:
                return component
        head, _, tail = text.partition(" ")
        number = self._spellings.get(plain(head.rstrip(".:,–-")))
        named = self._spellings.get(plain(tail.lstrip("–-:, ")))
        return number if number is not None and number == named else None

    def is_plane(self, cell: Cell) -> bool:
        """Return whether a cell names a plane of any component."""
        return any(plain(name) == plane for name in plane_names(cell) for _, plane in self._planes)

    def is_named(self, text: str) -> bool:
        """Return whether a text names a component by more than a bare number."""
        if text not in self._named:
            self._named[text] = any(letter.isalpha() for letter in text) and self.component(text) is not None
        return self._named[text]

    def component_in(self, text: str) -> str | None:
        """Return the component in a title: its name alone or behind a colon, or its number behind "valve" …"""
        for part in (text, text.rpartition(":")[2].strip()):
            if self.is_named(part):
                return self.component(part)
        folded = f" {plain(text)} "
        components = {number for name, number in self._spellings.items() if len(name) > 3 and f" {name} " in folded}
        return components.pop() if len(components) == 1 else None

    def require_component(self, cell: Cell) -> str:
        """Return the component that a cell names, which must have lands; the error names the valid ones."""
        component = self.component(cell)
        if component in self.with_lands:
            return component
        text = text_of(cell)
        if component is not None:
            raise ReadingsError(
                Sentence(
                    "component {component} ({name}) of {controller} has no precision pair to measure",
                    component=component,
                    name=Name(self.controller.components[component]),
                    controller=self.controller.id,
                ),
                value=text,
                expected=Sentence("one of {names}", names=_list(self.with_lands)),
            )
        near = nearest_name(plain(text), [*map(plain, self.with_lands), *self._spellings])
        raise ReadingsError(
            Sentence("unknown component of controller {controller}", controller=self.controller.id),
            value=text,
            expected=Sentence("one of {names}", names=_list(self.with_lands)),
            nearest=self._spellings.get(near) if near else None,
        )

    def plane(self, component: str, cell: Cell) -> str:
        """Return the plane that a cell names, as the controller spells it; the error names the component's planes."""
        for name in plane_names(cell):
            land = self._planes.get((component, plain(name)))
            if land is not None:
                return next(plane for plane in land.planes if plain(plane) == plain(name))
        planes = [plane for land in self.controller.lands_of(component) for plane in land.planes]
        raise ReadingsError(
            Sentence("component {component} has no such measurement plane", component=component),
            value=text_of(cell),
            expected=Sentence("plane {names}", names=_list(planes)),
            nearest=nearest_name(text_of(cell), planes),
        )

    def land(self, component: str, cell: Cell) -> Land:
        """Return the land of that component with that number; the error names the component's lands."""
        lands = {str(land.land): land for land in self.controller.lands_of(component)}
        for name in plane_names(cell):
            if name in lands:
                return lands[name]
        raise ReadingsError(
            Sentence("component {component} has no such land", component=component),
            value=text_of(cell),
            expected=Sentence("land {names}", names=_list(lands)),
        )


def _list(names: Iterable[str]) -> Sentence:
    listed = tuple(names)
    if len(listed) > _LISTED:
        return Sentence("{names} … ({count} in all)", names=listed[:_LISTED], count=len(listed))
    return Sentence("{names}", names=listed)
