"""Diameters as written → readings in metres: their unit where the sheet names none, the numbers of their repeats.

`filled_down` fills the cells left empty under the first of a block, where the user asks for it; `broken_blocks` tells
where that cannot be what was meant.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from statistics import median

from atleak.catalogue.controller import Controller
from atleak.catalogue.instruments import Part
from atleak.catalogue.words import PART_WORDS, angle
from atleak.common.errors import Message, Place, ReadingsError
from atleak.common.sentences import Option, Sentence
from atleak.common.units import Unit, unit_names
from atleak.common.units import unit as unit_named
from atleak.measurements.own_forms import MEASUREMENTS
from atleak.measurements.readings import Reading
from atleak.readers.cells.sheet import Sheet, rows_named
from atleak.readers.own_forms import said_by_form
from atleak.readers.sheets.column_headings import Role
from atleak.readers.sheets.controller_names import MILLIMETRE, UNITS, ControllerNames, Sizes, numbers_of
from atleak.readers.sheets.table import HeadedTable
from atleak.readers.sheets.words import is_blank, plain, repeat_of, text_of

COORDINATES_AGREE = 2e-6  # [m] between a diameter and the distance of its coordinates, both rounded to 0.001 mm


@dataclass(frozen=True)
class PlaceKey:
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
    key: PlaceKey
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
        ends, size = raw.coordinates, unit.to_si(raw.size)
        coordinates = None if ends is None else (unit.to_si(ends[0]), unit.to_si(ends[1]))
        reading = Reading(key.component, key.part, key.plane, key.direction, 0, size, raw.place, coordinates)
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
    ratios = []
    for entry in unitless:
        land = controller.land_of_plane(entry.key.component, entry.key.plane)
        assert land is not None  # a key is only made for planes that the controller knows
        ratios.append(entry.raw.size / (land.nominal_diameter / MILLIMETRE.factor))
    middle = median(ratios)
    for unit in (unit_named(name, "length") for name in unit_names("length")):
        if 0.8 < middle * unit.factor / MILLIMETRE.factor < 1.25:
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


_FILLED: tuple[Role, ...] = ("component", "part", "plane", "land", "direction")
FILL_DOWN = Sentence("or {option}, if an empty cell means the one above it", option=Option("fill-down"))


@dataclass
class _Block:
    """The labels that count in a row: those of the rows above it, until one to their left changes."""

    sheet: Sheet
    keys: Sequence[int]
    counts: Sequence[int]  # columns of repeats
    labelled: dict[int, int] = field(default_factory=dict)  # of each column the row with the label that counts
    repeat: int = 0

    def enter(self, row: int) -> bool:
        """Go on to the next row; return whether it holds anything."""
        if all(is_blank(cell) for cell in self.sheet.rows[row]):
            self.labelled = {}
            return False
        given = [index for index in self.keys if not is_blank(self.sheet.filled(row, index))]
        changed = next((index for index in given if not self._goes_on(row, index)), None)
        repeat = next((number for index in self.counts if (number := repeat_of(self.sheet.filled(row, index)))), 0)
        if not given and 0 < repeat <= self.repeat:
            self.labelled = {}  # repeats that begin again under no label: one was forgotten
        self.repeat = repeat
        if changed is not None:
            self.labelled = {index: at for index, at in self.labelled.items() if index < changed}
        self.labelled |= dict.fromkeys(given, row)
        return True

    def _goes_on(self, row: int, index: int) -> bool:
        at, label = self.labelled.get(index), self.sheet.filled
        return at is not None and plain(text_of(label(at, index))) == plain(text_of(label(row, index)))


def filled_down(table: HeadedTable, asked: bool) -> HeadedTable:
    """Return the table with the empty cells of a block filled from the first one.

    ``asked`` is whether the user says that empty cells go on with the one above. Without it only the program's own form
    saved as text is filled, whose blocks are known. A label that changes ends what stands to the right of it.
    """
    own = table.sheet.is_text and any(
        said_by_form(MEASUREMENTS, table.heading(index)) == "nominal" for index in table.span
    )
    if not (asked or own):
        return table
    sheet = table.sheet
    keys = sorted({column.index for column in table.columns if column.role in _FILLED} - {*sheet.derived})
    nominal = [] if asked else [column.index for column in table.of("specification")]
    block = _Block(sheet, keys, [column.index for column in table.of("repeat")])
    filled: dict[tuple[int, int], tuple[int, int]] = {}
    for row in filter(block.enter, table.rows):
        for index in (*keys, *nominal):
            if not is_blank(sheet.filled(row, index)):
                block.labelled[index] = row
            elif (at := block.labelled.get(index)) is not None:
                filled[row, index] = sheet.merged.get((at, index), (at, index))
    if not filled:
        return table
    rows = sorted({row for row, _ in filled})
    text = Sentence(
        "empty cells under {headings} go on with the one above them ({rows})",
        headings=tuple(repr(table.heading(index)) for index in sorted({index for _, index in filled})),
        rows=rows_named(sheet, rows),
    )
    return replace(
        table,
        sheet=replace(sheet, merged={**sheet.merged, **filled}),
        messages=(*table.messages, Message("info", "filled_down", text, sheet.place(min(rows)))),
        filled=frozenset(rows),
    )


def broken_blocks(
    table: HeadedTable, entries: Sequence[DiameterCell], names: ControllerNames
) -> Iterator[ReadingsError]:
    """Yield a problem for each filled row that cannot go on with the one above: of another diameter, or come twice."""
    sizes = Sizes(names.controller)
    seen: dict[object, int] = {}
    before: list[object] = []
    row, here = -1, list[object]()
    for entry in entries:
        if entry.row != row:
            row, before, here = entry.row, here, []
        key = entry.key
        station = (key.component, key.part, key.plane, key.direction)
        here.append(station)
        if entry.row in table.filled:
            units = (entry.raw.unit,) if entry.raw.unit is not None else UNITS
            beside = [
                number
                for column in table.of("specification")
                for number in numbers_of(table.sheet.cell(entry.row, column.index))
                if sizes.near(number, units)
            ]
            written = [entry.raw.size, *beside]
            if not all(sizes.near_plane(size, units, key.component, key.plane) for size in written):
                yield _broken(table, entry, Sentence("and another nominal diameter than that stands here"))
            elif station in seen and station not in before and key.repeat is None:
                text = Sentence("which stands in row {row} already", row=table.sheet.row_number(seen[station]))
                yield _broken(table, entry, text)
        seen[station] = row


def _broken(table: HeadedTable, entry: DiameterCell, why: Sentence) -> ReadingsError:
    key = entry.key
    problem = Sentence("this row would go on with component {component}, plane {plane}, {why}: is its label missing?")
    return ReadingsError(
        problem.of(component=key.component, plane=key.plane, why=why),
        place=entry.raw.place,
        value=entry.raw.size,
        expected=Sentence("the label in the first row of every block"),
    )
