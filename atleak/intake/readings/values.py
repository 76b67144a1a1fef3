"""Diameters as written → readings in metres: the unit where none is stated, and the numbers of the repeats."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from statistics import median

from atleak.catalogue.controller import Controller
from atleak.catalogue.instruments import Part
from atleak.errors import Message, Place, ReadingsError
from atleak.intake.units import Unit, unit_names
from atleak.intake.units import unit as unit_named
from atleak.phrases import PART_WORDS, angle
from atleak.readings import Reading
from atleak.sentence import Sentence

COORDINATES_AGREE = 2e-6  # [m] between a diameter and the distance of its coordinates, both rounded to 0.001 mm
MM = 1e-3


@dataclass(frozen=True)
class Key:
    """What a diameter is of."""

    component: str
    part: Part
    plane: str
    direction: float | None
    repeat: int | None  # None: the next free one
    explicit: bool  # whether a column of its own says it
    unworn: bool = False  # marked as taken at an unworn end


@dataclass(frozen=True)
class RawValue:
    """One diameter as written: the numbers, still in the sheet's unit."""

    diameter: float | None
    coordinates: tuple[float, float] | None
    unit: Unit | None
    place: Place

    @property
    def size(self) -> float:
        if self.diameter is not None:
            return self.diameter
        assert self.coordinates is not None
        return abs(self.coordinates[0] - self.coordinates[1])


@dataclass(frozen=True)
class DiameterCell:
    """A diameter with the row and column, from 0, that it stands in."""

    row: int
    column: int
    key: Key
    raw: RawValue


@dataclass
class Converted:
    """Readings, their units, and the problems and messages that came up."""

    readings: list[Reading] = field(default_factory=list)
    unworn: list[Reading] = field(default_factory=list)
    units: list[str] = field(default_factory=list)  # names in order of appearance
    unit_assumed: bool = False
    problems: list[ReadingsError] = field(default_factory=list)
    messages: list[Message] = field(default_factory=list)


def convert(entries: Sequence[DiameterCell], controller: Controller, headings: Place) -> Converted:
    """Convert diameters as written into readings; ``headings`` is the place to name where the unit is missing."""
    result = Converted()
    unitless = [entry for entry in entries if entry.raw.unit is None]
    assumed = _assumed_unit(unitless, controller, headings, result) if unitless else None
    result.unit_assumed = assumed is not None
    taken: dict[tuple[object, int], Reading] = {}
    counted: dict[object, int] = defaultdict(int)
    for entry in entries:
        key, raw = entry.key, entry.raw
        unit = raw.unit or assumed
        if unit is None or not _agrees(raw, unit, result.problems):
            continue
        if unit.name not in result.units:
            result.units.append(unit.name)
        reading = _reading(key, raw, unit)
        station, repeat = (reading.station, key.unworn), key.repeat
        if key.explicit and repeat is not None and (station, repeat) in taken:
            result.problems.append(_twice(reading, raw, repeat, taken[station, repeat]))
            continue
        while repeat is None or (station, repeat) in taken:
            counted[station] += 1
            repeat = counted[station]
        taken[station, repeat] = replace(reading, repeat=repeat)
        (result.unworn if key.unworn else result.readings).append(taken[station, repeat])
    return result


def _agrees(raw: RawValue, unit: Unit, problems: list[ReadingsError]) -> bool:
    if raw.diameter is None or raw.coordinates is None:
        return True
    distance = abs(raw.coordinates[0] - raw.coordinates[1])
    if abs(raw.diameter - distance) * unit.factor <= COORDINATES_AGREE + 1e-12:
        return True
    problem = Sentence("the diameter and the distance of its coordinates ({distance:.6g}) disagree", distance=distance)
    expected = Sentence("a diameter equal to |x1 − x2|, or one of the two left empty")
    problems.append(ReadingsError(problem, place=raw.place, value=raw.diameter, expected=expected))
    return False


def _reading(key: Key, raw: RawValue, unit: Unit) -> Reading:
    ends = raw.coordinates
    coordinates = None if ends is None else (unit.to_si(ends[0]), unit.to_si(ends[1]))
    size = unit.to_si(raw.size)
    return Reading(key.component, key.part, key.plane, key.direction, 0, size, raw.place, coordinates)


def _twice(reading: Reading, raw: RawValue, repeat: int, earlier: Reading) -> ReadingsError:
    problem = Sentence(
        "repeat {repeat} of component {component}, {part}, plane {plane}{direction} stands in row {row} already",
        repeat=repeat,
        component=reading.component,
        part=PART_WORDS[reading.part],
        plane=reading.plane,
        direction=angle(reading.direction),
        row=earlier.place.row,
    )
    return ReadingsError(problem, place=raw.place, value=raw.size, expected=Sentence("each repeat once"))


def _assumed_unit(
    unitless: Sequence[DiameterCell], controller: Controller, headings: Place, result: Converted
) -> Unit | None:
    """Return the unit in which the diameters come near the nominal ones."""
    ratios = []
    for entry in unitless:
        land = controller.land_of_plane(entry.key.component, entry.key.plane)
        assert land is not None  # a key is only made for planes that the controller knows
        ratios.append(entry.raw.size / (land.nominal_diameter / MM))
    middle = median(ratios)
    for unit in (unit_named(name, "length") for name in unit_names("length")):
        if 0.8 < middle * unit.factor / MM < 1.25:
            text = Sentence(
                "the sheet names no unit: {unit} assumed, in which the diameters come near the nominal ones",
                unit=unit.said,
            )
            result.messages.append(Message("warning", "unit_assumed", text, headings))
            return unit
    problem = Sentence(
        "the sheet names no unit, and in none are the diameters near the nominal ones (the numbers are {times:.3g} "
        "times the nominal diameters in mm)",
        times=middle,
    )
    expected = Sentence("a unit in the heading, such as 'Diameter [mm]'")
    result.problems.append(ReadingsError(problem, place=headings, expected=expected))
    return None
