"""Whether a number has the size of a diameter of the controller.

Which of a controller's components and lands a sheet means; `read_label` takes apart cells that say several things.
"""

from __future__ import annotations

import datetime
import re
from bisect import bisect_left
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping
from functools import cached_property

from atleak.catalogue.controller import Controller, Land
from atleak.common.errors import ReadingsError, nearest_name
from atleak.common.sentences import Name, Sentence
from atleak.common.translations import languages
from atleak.common.units import Unit, unit
from atleak.common.wording import wording
from atleak.measurements.clearances import NOMINAL_TOLERANCE
from atleak.readers.cells.sheet import Cell
from atleak.readers.sheets.column_headings import Role, is_angle, spot_of_heading, tokens_of, unit_of_heading
from atleak.readers.sheets.words import (
    Words,
    direction_of,
    letters,
    numbers_in,
    part_of,
    part_said,
    plain,
    plane_names,
    sheet_vocabulary,
    text_of,
)

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

    def near(self, value: float, units: Iterable[Unit], within: float = NOMINAL_TOLERANCE) -> bool:
        """Return whether a number in one of the units is within 0.5 mm, or less, of any nominal diameter."""
        for length_unit in units:
            size = length_unit.to_si(value)
            if length_unit == INCH and round(value, _INCH_DECIMALS - 1) == value:
                continue
            above = bisect_left(self._all, size - within)
            if above < len(self._all) and self._all[above] <= size + within:
                return True
        return False

    def is_nominal(self, value: float) -> bool:
        """Return whether a number is one of the nominal diameters, in any unit."""
        return self.near(value, UNITS, ROUNDED)

    def fill(self, cells: Collection[Cell]) -> bool:
        """Return whether at least half of the cells hold a number of that size, in mm, µm or inches."""
        sized = sum(any(self.near(value, UNITS) for value in numbers_of(cell)) for cell in cells)
        return bool(sized) and 2 * sized >= len(cells)

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


_WHOLE_NUMBER = re.compile(r"(?<![\d.,])\d+'?(?![.,]?\d)")
_LISTED = 12  # valid names worth listing in a message


class ControllerNames:
    """The names that a sheet for one controller may use."""

    def __init__(self, controller: Controller) -> None:
        self.controller = controller
        self._known: dict[str, str | None] = {}
        self._planes: dict[tuple[str, str], Land] = {
            (land.component, plain(plane)): land for land in controller.lands for plane in land.planes
        }

    @cached_property
    def with_lands(self) -> tuple[str, ...]:
        return tuple(dict.fromkeys(land.component for land in self.controller.lands))

    @cached_property
    def spellings(self) -> dict[str, str]:
        """Return every name of a component with its id."""
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

    def spelled(self, component: str) -> list[str]:
        """Return the ways in which a component may be named."""
        return [name for name, named in self.spellings.items() if named == component]

    @cached_property
    def by_length(self) -> list[tuple[str, str]]:
        """Return the names of components with lands and their ids, the longest first."""
        named = ((name, of) for name, of in self.spellings.items() if any(map(str.isalpha, name)))
        return sorted((pair for pair in named if pair[1] in self.with_lands), key=lambda pair: -len(pair[0]))

    def component(self, cell: Cell) -> str | None:
        """Return the component that a cell names, by number or name, with or without lands; None where none is."""
        text = text_of(cell)
        if text not in self._known:
            self._known[text] = self._told(text)
        return self._known[text]

    def _told(self, text: str) -> str | None:
        first, _, rest = plain(text).partition(" ")
        named = rest if Words((first.rstrip(".:"),)).only("number", "component", "generic") else ""
        number = self._numbered(text)
        number = number if self._by_name(plain(text)) <= {number} else None
        return self.spellings.get(plain(text)) or self.spellings.get(named) or number

    def _numbered(self, text: str, *, titled: bool = False) -> str | None:
        """Return the component whose number stands before a name, or behind it in brackets; None if two numbers are.

        In a title only a word for a component before it tells that it is the number of one.
        """
        found = [match for match in _WHOLE_NUMBER.finditer(plain(text)) if match[0] in self.with_lands]
        numbers = {match[0]: match for match in reversed(found)}
        if len(numbers) != 1:
            return None
        number, match = numbers.popitem()
        before, after = match.string[: match.start()].rstrip(), match.string[match.end() :]
        bracketed = before.endswith("(") and after.startswith(")") and not titled
        leading = letters(before).only("number", "component", "generic")
        leading = leading and (
            letters(before).any("component") if titled else bool(before) or max(map(len, letters(after)), default=0) > 2
        )
        said = spot_of_heading(tokens_of(match.string))[0] or direction_of(text) is not None
        if said or not (bracketed or leading):
            return None
        return number

    def _by_name(self, folded: str) -> set[str]:
        spaced = " ".join(["", *re.sub(r"[^\w/-]", " ", folded).split(), ""])
        return {number for name, number in self.spellings.items() if len(name) > 3 and f" {name} " in spaced}

    def is_plane(self, cell: Cell) -> bool:
        """Return whether a cell names a plane of any component."""
        return any(plain(name) == plane for name in plane_names(cell) for _, plane in self._planes)

    def is_named(self, text: str) -> bool:
        """Return whether a text names a component by more than a bare number."""
        return any(map(str.isalpha, text)) and self.component(text) is not None

    def component_in(self, text: str) -> str | None:
        """Return the component in a title: its name alone or behind a colon, or its number behind "valve" …"""
        if self.is_named(text):
            return self.component(text)
        components = {*self._by_name(plain(text)), self._numbered(text, titled=True)} - {None}
        return components.pop() if len(components) == 1 else None

    def require_component(self, cell: Cell) -> str:
        """Return the component that a cell names, which must have lands; the error names the valid ones."""
        component = self.component(cell)
        if component in self.with_lands:
            return component
        text = text_of(cell)
        if component is not None:
            problem = Sentence("component {component} ({name}) of {controller} has no precision pair to measure")
            raise ReadingsError(
                problem.of(
                    component=component, name=Name(self.controller.components[component]), controller=self.controller.id
                ),
                value=text,
                expected=Sentence("one of {names}", names=_list(self.with_lands)),
            )
        near = nearest_name(plain(text), [*map(plain, self.with_lands), *self.spellings])
        raise ReadingsError(
            Sentence("unknown component of controller {controller}", controller=self.controller.id),
            value=text,
            expected=Sentence("one of {names}", names=_list(self.with_lands)),
            nearest=self.spellings.get(near) if near else None,
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


# --- cells that say several things at once: "pressure_regulator/2", "No. 8, plane 1", "bore 90°"

_LEADING_NUMBER = re.compile(r"0*(\d+'?)(?=[\s,;:./_()\-–—#]|$)")
_AXES = {"x": "0°", "y": "90°"}
LABELLED: Mapping[str, Role] = {  # what a cell may say; a number stands for a land or a plane without saying which
    **{role: role for role in ("component", "part", "land", "plane", "direction", "repeat", "unit")},
    "number": "plane",
}
_OF_SIDE = {"od": "spool", "id": "sleeve"}  # behind a land or part: before them OD may be overdrive
PLACES = {"plane", "land"}
Label = dict[str, str]  # what one cell says of a diameter, each as a cell of its own column would say it


def read_label(cell: Cell, names: ControllerNames, *, dotted: bool = False) -> Label | None:
    """Return what a cell says, if all of it is understood; ``dotted`` where "8.1" is no size, but valve and land.

    >>> from atleak.catalogue.controller_file import load_controller
    >>> names = ControllerNames(load_controller("minimal_example"))
    >>> read_label("pressure_regulator (2), bore 90°", names)
    {'component': 'pressure_regulator', 'part': 'sleeve', 'plane': '2', 'direction': '90°'}
    >>> read_label("bore 25/1", ControllerNames(load_controller("four_speed_2023")))
    {'component': '25', 'part': 'sleeve', 'plane': '1'}
    >>> read_label("SPOOL_6_L1", ControllerNames(load_controller("four_speed_2023")))
    {'component': '6', 'part': 'spool', 'land': '1'}
    >>> read_label("ring gauge 18.0", names), read_label("pressure_regulator/3", names)
    (None, None)
    >>> read_label("bore 25.1 mm", ControllerNames(load_controller("four_speed_2023")))
    """
    if isinstance(cell, bool | datetime.date | datetime.time) or cell is None:
        return None
    rest, unit = unit_of_heading(text_of(cell))
    folded = plain(rest)
    for component, other in (*_with_component(folded, names, dotted), (None, folded)):
        label: Label = {} if component is None else {"component": component}
        label |= {} if unit is None else {"unit": unit.name}
        if _takes_rest(other, label) and _is_placed(label, names) and label:
            return {name: label[name] for name in LABELLED if name in label}
    return None


def label_apart(cell: Cell, names: ControllerNames) -> Label:
    """Return what a cell says, also of a component by a name that nobody knows.

    >>> from atleak.catalogue.controller_file import load_controller
    >>> label_apart("Reg valve L1", ControllerNames(load_controller("four_speed_2023")))
    {'component': 'Reg valve', 'land': '1'}
    """
    text, label = text_of(cell), read_label(cell, names, dotted=True)
    for match in re.finditer(r"[\s_/,;:]+(?:[–-]\s+)?(?=([^\s_/,;:]*))", text) if label is None else ():
        rest = read_label(text[match.end() :], names) or {}
        of_valve = letters(match[1]).only("component", "generic")  # "valve" is no word for the spool here
        if match.start() and PLACES & rest.keys() and "component" not in rest and not of_valve:
            return {"component": text[: match.start()], **rest}
    return label or {}


def _with_component(folded: str, names: ControllerNames, dotted: bool) -> Iterator[tuple[str, str]]:
    for name, component in names.by_length:
        match = re.search(rf"(?<![^\W_]){re.escape(name)}(?![^\W_])", folded) if name in folded else None
        if match is not None:
            yield component, f"{folded[: match.start()]} {folded[match.end() :]}"
    words = folded.replace("_", " ").split()
    sized = re.search(r"\d[.,]\d", folded) and not dotted  # "bore 12.1"
    placed = len(re.findall(r"\d+", folded)) > 1 and not sized
    for _ in range(len(words) - 1) if placed else ():
        if len(words[0]) > 1 and (part_of(words[0]) or words[0] in sheet_vocabulary("diameter")):
            words.append(words.pop(0))  # "bore 14/1" as "14/1 bore"
    leading = re.sub(r"^(?:(?:[^\W\d_]+|#)[\s.:]*)", _unless_label, " ".join(words))
    match = _LEADING_NUMBER.match(leading)
    numbered = names.component(match[1]) if match else None
    if match is not None and numbered is not None and numbered in names.with_lands:
        yield numbered, leading[match.end() :]


def _unless_label(match: re.Match[str]) -> str:
    is_label = match[0].strip(" .:") in sheet_vocabulary("number", "component", "generic")
    return "" if is_label or match[0].startswith("#") or match[0] == "v" else match[0]  # V14, of a valve


def _takes_rest(text: str, label: Label) -> bool:
    """Add what the other words of its cell say to a label; return whether all of them are understood."""
    part = part_said(text.strip(" -–_/.,;:()"))
    if part is not None:
        label["part"] = part
        return True
    tokens = tokens_of(text.replace(".", " ").replace("°", "° "))
    spot, others = spot_of_heading(tokens)
    label |= spot
    before = ""
    for token in others:
        part = part_of(token) if len(token) > 1 else None
        if token.isdigit():
            repeats = before in sheet_vocabulary("of_repeat") and "repeat" not in label
            if not repeats and not label.keys().isdisjoint(("number", "land", "plane")):
                return False
            label["repeat" if repeats else "number"] = token
        elif (is_angle(token) or token in _AXES) and "direction" not in label:
            label["direction"] = _AXES.get(token, token)
        elif part is not None and label.get("part", part) == part:
            label["part"] = part
        elif token.isalpha() and len(token) > 3 and "direction" not in label and direction_of(token) is not None:
            label["direction"] = token
        elif token in _OF_SIDE and _OF_SIDE[token] == label.get("part", _OF_SIDE[token]) and tokens[0] != token:
            label["part"] = _OF_SIDE[token]
        elif token not in sheet_vocabulary("number", "diameter", "of_repeat"):
            return False
        before = token
    return True


def _is_placed(label: Label, names: ControllerNames) -> bool:
    """Take the number of a label for a plane; return whether its component has that plane or land."""
    component = label.get("component")
    if component is None:
        return True
    try:
        if "number" in label:
            label["plane"] = names.plane(component, label.pop("number"))
        elif "plane" in label:
            names.plane(component, label["plane"])
        if "land" in label:
            names.land(component, label["land"])
    except ReadingsError:
        return False
    return True
