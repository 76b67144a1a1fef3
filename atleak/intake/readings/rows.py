"""The rows under the headings → readings with their places, and every row that says nothing usable."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from statistics import median

from atleak.errors import Message, Place, ReadingsError, nearest_name
from atleak.intake.readings.headings import Column, Header
from atleak.intake.readings.names import Names
from atleak.intake.readings.sheet import Cell, Sheet
from atleak.intake.readings.words import at, direction_of, is_blank, number, part_of, part_words, plain, text_of
from atleak.intake.units import Unit, find_unit, unit_names
from atleak.readings import Part, Reading

COORDINATES_AGREE = 2e-6  # [m] between a diameter and the distance of its coordinates, both rounded to 0.001 mm
MM = 1e-3
_MERGE_HINT = (
    "the value in every row. Cells left empty under a first one are understood only where the workbook has merged them"
)


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


@dataclass
class Table:
    """What `read_rows` found."""

    readings: list[Reading]
    units: list[str]  # names in order of appearance
    unit_assumed: bool
    problems: list[ReadingsError]
    messages: list[Message]
    rows_without_reading: int
    values: int  # cells that hold anything where a diameter belongs


@dataclass(frozen=True)
class _Key:
    component: str
    part: Part
    plane: str
    direction: float | None
    repeat: int | None  # None: the next free one
    explicit: bool  # a column of its own says it


def count_values(sheet: Sheet, header: Header) -> int:
    """How many cells under the headings hold something where a diameter belongs."""
    return sum(
        not is_blank(sheet.cell(row, column.index))
        for row in range(header.last + 1, len(sheet.rows))
        for column in header.values
    )


def read_rows(sheet: Sheet, header: Header, names: Names, told: Unit | None) -> Table:
    """Every reading under the headings of a sheet."""
    return _Reader(sheet, header, names, told).read()


class _Reader:
    def __init__(self, sheet: Sheet, header: Header, names: Names, told: Unit | None) -> None:
        self.sheet, self.header, self.names, self.told = sheet, header, names, told
        self.problems: list[ReadingsError] = []
        self.messages: list[Message] = []
        self.blanks: dict[Column, dict[int, None]] = defaultdict(dict)
        self.found: list[tuple[_Key, RawValue]] = []
        self.component = self._component_column()
        self.part = self._part_column()
        self.groups = self._value_groups()
        self.sheet_unit = self._sheet_unit()
        self.has_directions = self._any("direction")
        self.has_repeats = self._any("repeat")
        self.overridden: set[str] = set()

    # --- which column ---------------------------------------------------------------------------------------------

    def _column_cells(self, column: Column) -> Iterator[Cell]:
        for row in range(self.header.last + 1, len(self.sheet.rows)):
            cell = self.sheet.filled(row, column.index)
            if not is_blank(cell):
                yield cell

    def _part_column(self) -> Column | None:
        """A column headed "part", or one headed "component" whose cells are parts, as in the study's Table 1."""
        named = self.header.of("part")
        if named:
            return named[0]
        for column in self.header.of("component"):
            if self._names_parts(column):
                return column
        return None

    def _names_parts(self, column: Column) -> bool:
        cells = list(self._column_cells(column))
        return bool(cells) and sum(part_of(text_of(cell)) is not None for cell in cells) > 0.5 * len(cells)

    def _component_column(self) -> Column | None:
        """Of the columns that may number or name the components, the one whose cells the controller knows."""
        best: tuple[float, int, Column] | None = None
        for column in self.header.of("component"):
            if not self.header.of("part") and self._names_parts(column):
                continue
            cells = list(self._column_cells(column))
            known = sum(self.names.component(cell) is not None for cell in cells) / len(cells) if cells else 0.0
            if best is None or (known, column.rank) > best[:2]:
                best = (known, column.rank, column)
        return best[2] if best else None

    def _value_groups(self) -> list[dict[str, Column]]:
        groups: dict[object, dict[str, Column]] = {}
        for column in self.header.values:
            name = "diameter" if column.role == "diameter" else f"coordinate {column.coordinate}"
            group = groups.setdefault(column.group, {})
            if name in group:
                self._say(
                    f"two columns are read as the same {name}: {group[name].heading!r} and {column.heading!r}",
                    self.sheet.place(self.header.last, column.index, column.heading),
                    expected="headings that tell repeats apart, such as 'diameter 1 [mm]' and 'diameter 2 [mm]'",
                )
            else:
                group[name] = column
        for group in groups.values():
            for one, other in (("coordinate 1", "coordinate 2"), ("coordinate 2", "coordinate 1")):
                if one in group and other not in group and "diameter" not in group:
                    self._say(
                        f"there is a column of {one} but none of {other}",
                        self.sheet.place(self.header.last, group[one].index, group[one].heading),
                        expected="both coordinates, or the diameter",
                    )
        return list(groups.values())

    def _sheet_unit(self) -> Unit | None:
        """The unit that holds where a heading names none: its only sibling's, or the one stated above the table."""
        headed = {column.unit for column in self.header.values if column.unit is not None}
        if len(headed) == 1:
            return headed.pop()
        for row in range(self.header.first):
            for index, cell in enumerate(self.sheet.rows[row]):
                words = plain(cell).replace(":", " ").replace("=", " ").split() if isinstance(cell, str) else []
                if not words:
                    continue
                after = self.sheet.cell(row, index + 1)
                if words[0] in {"unit", "units", "einheit", "einheiten", "jednostka", "jednostki"}:
                    candidates = [*words[1:], str(after)]
                elif "in" in words[:-1] or "w" in words[:-1]:
                    candidates = words[-1:]
                else:
                    continue
                for candidate in candidates:
                    unit = find_unit(candidate.strip("[]()., "), "length") if candidate.strip("[]()., ") else None
                    if unit is not None:
                        return unit
        return None

    # --- row by row -----------------------------------------------------------------------------------------------

    def read(self) -> Table:
        unread = values = 0
        if self._columns_missing():
            return Table([], [], False, self.problems, self.messages, 0, 1)
        faulty_rows = {row for row, _ in self.sheet.faults}
        for row in range(self.header.last + 1, len(self.sheet.rows)):
            cells = self.sheet.rows[row]
            if all(is_blank(cell) for cell in cells) and row not in faulty_rows:
                continue
            if self._repeats_headings(row):
                continue
            raw = list(self._raw_values(row))
            values += len(raw)
            if not raw:
                unread += bool(self.component and not is_blank(self.sheet.filled(row, self.component.index)))
                continue
            self._overlong(row)
            for group, value in raw:
                key = self._key(row, group)
                if key is not None and value is not None:
                    self.found.append((key, value))
        self._tell_blanks()
        readings, units, assumed = self._converted()
        self.problems.sort(key=lambda problem: problem.place.row or 0)
        return Table(readings, units, assumed, self.problems, self.messages, unread, values)

    def _columns_missing(self) -> bool:
        missing = []
        if self.component is None:
            missing.append("the component's number")
        if self.part is None and not all(column.part for column in self.header.values):
            missing.append("the part (spool or sleeve)")
        places = self.header.of("plane") + self.header.of("land")
        single = len(self.names.controller.lands) == len(self.names.with_lands)
        if not places and not single:
            missing.append("the measurement plane (or land)")
        if missing:
            headings = [column.heading for column in self.header.columns]
            self._say(
                f"no column holds {' nor '.join(missing)}",
                self.sheet.place(self.header.last),
                value=", ".join(repr(" ".join(heading.split())) for heading in headings),
                expected="headings such as 'No.', 'Part', 'Plane', 'Direction', 'Diameter [mm]'",
            )
        return bool(self.problems)

    def _any(self, role: str) -> bool:
        return any(not is_blank(cell) for column in self.header.of(role) for cell in self._column_cells(column))  # type: ignore[arg-type]

    def _repeats_headings(self, row: int) -> bool:
        """Headings printed again at the top of a page."""
        same = [
            plain(self.sheet.cell(row, column.index)) == plain(self.sheet.filled(self.header.first, column.index))
            for column in self.header.columns
            if not is_blank(self.sheet.cell(row, column.index))
        ]
        return len(same) >= 2 and all(same)

    def _overlong(self, row: int) -> None:
        width = max(column.index for column in self.header.columns) + 1
        if not self.sheet.is_text:
            return
        header_width = len(self.sheet.rows[self.header.last])
        extra = [cell for cell in self.sheet.rows[row][max(width, header_width) :] if not is_blank(cell)]
        if extra:
            self._say(
                f"the row has {len(self.sheet.rows[row])} cells under {header_width} headings: a decimal comma in a "
                "file whose columns are separated by commas?",
                self.sheet.place(row),
                value=", ".join(str(cell) for cell in self.sheet.rows[row]),
                expected="semicolons or tabs between the columns, or decimal points",
            )

    def _raw_values(self, row: int) -> Iterator[tuple[dict[str, Column], RawValue | None]]:
        """Each diameter of a row; None for one that is there and cannot be read (the problem is noted)."""
        for group in self.groups:
            given = {name: column for name, column in group.items() if not is_blank(self.sheet.cell(row, column.index))}
            faulty = [
                column for name, column in group.items() if name not in given and self._fault(row, column, bool(given))
            ]
            if not given and not faulty:
                continue
            if faulty or self._half_given(row, group, given):
                yield group, None
                continue
            yield group, self._raw_value(row, given)

    def _fault(self, row: int, column: Column, others: bool) -> bool:
        fault = self.sheet.faults.get((row, column.index))
        if fault is None or others:
            return False
        if not fault.startswith("#") and len(self.groups[0]) > 1:
            return False  # a formula over coordinates that are not filled in yet
        self._say(
            "this cell's formula has no result" if not fault.startswith("#") else "this cell's formula gives an error",
            self._place(row, column),
            value=fault,
            expected="a diameter: open the workbook in a spreadsheet program and save it again"
            if not fault.startswith("#")
            else "a diameter such as 9.939",
        )
        return True

    def _half_given(self, row: int, group: dict[str, Column], given: dict[str, Column]) -> bool:
        if "diameter" in given:
            return False
        for name in ("coordinate 1", "coordinate 2"):
            if name not in given and name in group:
                self._say(
                    f"{name} is missing beside the other one",
                    self._place(row, group[name]),
                    expected="both coordinates, or the diameter",
                )
                return True
        return False

    def _raw_value(self, row: int, given: dict[str, Column]) -> RawValue | None:
        numbers: dict[str, float] = {}
        units: set[Unit | None] = set()
        for name, column in given.items():
            place = self._place(row, column)
            try:
                value, written = number(self.sheet.cell(row, column.index))
            except ReadingsError as problem:
                self.problems.append(at(place, problem))
                return None
            if name == "diameter" and value <= 0.0:
                self._say("a diameter must be positive", place, value=value, expected="a diameter such as 9.939")
                return None
            numbers[name] = value
            units.add(self._unit(row, column, written))
        main = given.get("diameter") or given["coordinate 1"]
        place = self._place(row, main)
        coordinates = None
        if "coordinate 1" in numbers and "coordinate 2" in numbers:
            coordinates = (numbers["coordinate 1"], numbers["coordinate 2"])
        if coordinates is not None and coordinates[0] == coordinates[1]:
            self._say("both coordinates are equal: no diameter between them", place, value=coordinates[0])
            return None
        if len(units) > 1:
            return self._mixed(row, given, numbers)
        unit = units.pop()
        return RawValue(numbers.get("diameter"), coordinates, unit, place)

    def _mixed(self, row: int, given: dict[str, Column], numbers: dict[str, float]) -> RawValue:
        """Diameter and coordinates in different units: all into millimetres."""
        mm = find_unit("mm", "length")
        in_mm: dict[str, float] = {}
        for name, column in given.items():
            _, written = number(self.sheet.cell(row, column.index))
            unit = self._unit(row, column, written) or mm
            in_mm[name] = numbers[name] * (unit.factor / MM)
        coordinates = None
        if "coordinate 1" in in_mm and "coordinate 2" in in_mm:
            coordinates = (in_mm["coordinate 1"], in_mm["coordinate 2"])
        place = self._place(row, given.get("diameter") or given["coordinate 1"])
        return RawValue(in_mm.get("diameter"), coordinates, mm, place)

    def _agrees(self, raw: RawValue, unit: Unit) -> bool:
        if raw.diameter is None or raw.coordinates is None:
            return True
        distance = abs(raw.coordinates[0] - raw.coordinates[1])
        if abs(raw.diameter - distance) * unit.factor <= COORDINATES_AGREE + 1e-12:
            return True
        self._say(
            f"the diameter and the distance of its coordinates ({distance:.6g}) disagree",
            raw.place,
            value=raw.diameter,
            expected="a diameter equal to |x1 − x2|, or one of the two left empty",
        )
        return False

    def _unit(self, row: int, column: Column, written: Unit | None) -> Unit | None:
        if written is not None:
            return written
        if self.told is not None:
            if column.unit is not None and column.unit != self.told:
                self.overridden.add(column.heading)
            return self.told
        for unit_column in self.header.of("unit"):
            cell = self.sheet.filled(row, unit_column.index)
            if not is_blank(cell):
                unit = find_unit(text_of(cell), "length")
                if unit is None:
                    known = unit_names("length")
                    self._once(
                        ReadingsError(
                            "unknown unit of length",
                            place=self._place(row, unit_column),
                            value=text_of(cell),
                            expected="one of " + ", ".join(known),
                            nearest=nearest_name(text_of(cell), known),
                        )
                    )
                return unit
        return column.unit or self.sheet_unit

    # --- what the row is about ------------------------------------------------------------------------------------

    def _key(self, row: int, group: dict[str, Column]) -> _Key | None:
        column = next(iter(group.values()))
        component = self._component(row)
        part = column.part or self._part(row)
        plane = self._plane(row, component) if component is not None else None
        direction, known = self._direction(row, column)
        repeat, explicit, countable = self._repeat(row, column)
        if component is None or part is None or plane is None or not known or not countable:
            return None
        return _Key(component, part, plane, direction, repeat, explicit)

    def _required(self, row: int, column: Column) -> Cell | None:
        cell = self.sheet.filled(row, column.index)
        if not is_blank(cell):
            return cell
        self.blanks[column][row] = None
        return None

    def _component(self, row: int) -> str | None:
        cell = self._required(row, self.component)
        if cell is None:
            return None
        try:
            return self.names.require_component(cell)
        except ReadingsError as problem:
            self._once(at(self._place(row, self.component), problem))
            return None

    def _part(self, row: int) -> Part | None:
        cell = self._required(row, self.part)
        if cell is None:
            return None
        part = part_of(text_of(cell))
        if part is None:
            near = nearest_name(plain(text_of(cell)), part_words())
            self._once(
                ReadingsError(
                    "unknown part",
                    place=self._place(row, self.part),
                    value=text_of(cell),
                    expected="spool (or piston), or sleeve (or bore)",
                    nearest=part_of(near) if near else None,
                )
            )
        return part

    def _plane(self, row: int, component: str) -> str | None:
        planes, lands = self.header.of("plane"), self.header.of("land")
        try:
            if not planes and not lands:
                return self.names.controller.lands_of(component)[0].planes[0]
            land = plane = None
            column = (planes or lands)[0]
            if lands:
                column = lands[0]
                cell = self._required(row, column)
                if cell is None:
                    return None
                land = self.names.land(component, cell)
            if planes:
                column = planes[0]
                cell = self._required(row, column) if land is None else self.sheet.filled(row, column.index)
                if cell is None or (land is None and is_blank(cell)):
                    return None
                plane = None if is_blank(cell) else self.names.plane(component, cell)
            if land is None:
                return plane
            if plane is not None and plane not in land.planes:
                raise ReadingsError(
                    f"plane {plane} of component {component} is not on land {land.land}",
                    value=plane,
                    expected=f"plane {', '.join(land.planes)}",
                )
            return plane or land.planes[0]
        except ReadingsError as problem:
            self._once(at(self._place(row, column), problem))
            return None

    def _direction(self, row: int, value: Column) -> tuple[float | None, bool]:
        columns = self.header.of("direction")
        if not columns or not self.has_directions:
            return value.direction, True
        cell = self._required(row, columns[0])
        if cell is None:
            return None, False
        direction = direction_of(cell)
        if direction is None:
            self._once(
                ReadingsError(
                    "unknown measuring direction",
                    place=self._place(row, columns[0]),
                    value=text_of(cell),
                    expected="an angle such as 0° or 90°, or x1-x2, y1-y2, I, II",
                )
            )
        return direction, direction is not None

    def _repeat(self, row: int, value: Column) -> tuple[int | None, bool, bool]:
        """The repeat's number, whether a column says it, and whether it could be read."""
        columns = self.header.of("repeat")
        if not columns or not self.has_repeats or value.repeat is not None:
            return value.repeat, False, True
        cell = self._required(row, columns[0])
        if cell is None:
            return None, True, False
        digits = "".join(sign for sign in text_of(cell) if sign.isdigit())
        roman = {"i": 1, "ii": 2, "iii": 3, "iv": 4}.get(plain(cell))
        if not digits and roman is None:
            self._once(
                ReadingsError(
                    "not the number of a repeat",
                    place=self._place(row, columns[0]),
                    value=text_of(cell),
                    expected="1, 2, 3 …",
                )
            )
            return None, True, False
        return int(digits) if digits else roman, True, True

    # --- all rows together ----------------------------------------------------------------------------------------

    def _tell_blanks(self) -> None:
        for column, rows in self.blanks.items():
            numbers = [self.sheet.row_number(row) for row in rows]
            more = f" and in {len(numbers) - 1} more: {_numbers(numbers[1:])}" if len(numbers) > 1 else ""
            self._say(
                f"column {' '.join(column.heading.split())!r} is empty in a row that holds a reading{more}",
                self._place(next(iter(rows)), column),
                expected=_MERGE_HINT,
            )

    def _converted(self) -> tuple[list[Reading], list[str], bool]:
        assumed = self._assumed_unit() if any(raw.unit is None for _, raw in self.found) else None
        if self.overridden:
            self.messages.append(
                Message(
                    "warning",
                    "unit_told",
                    f"read in {self.told.name} as told, although the heading says otherwise: "
                    + ", ".join(sorted(" ".join(heading.split()) for heading in self.overridden)),
                    self.sheet.place(self.header.last),
                )
            )
        readings: list[Reading] = []
        units: list[str] = []
        taken: dict[tuple[object, int], Reading] = {}
        counters: dict[object, int] = defaultdict(int)
        for key, raw in self.found:
            unit = raw.unit or assumed
            if unit is None:
                continue
            if unit.name not in units:
                units.append(unit.name)
            if not self._agrees(raw, unit):
                continue
            reading = _reading(key, raw, unit)
            repeat = key.repeat
            if key.explicit and (reading.station, repeat) in taken:
                earlier = taken[reading.station, repeat]
                self._say(
                    f"repeat {repeat} of component {key.component}, {key.part}, plane {key.plane}"
                    f"{'' if key.direction is None else f', {key.direction:g}°'} stands in row "
                    f"{earlier.place.row} already",
                    raw.place,
                    value=raw.size,
                    expected="each repeat once",
                )
                continue
            if repeat is None or (reading.station, repeat) in taken:
                repeat = counters[reading.station] + 1
                while (reading.station, repeat) in taken:
                    repeat += 1
                counters[reading.station] = repeat
            reading = replace(reading, repeat=repeat)
            taken[reading.station, repeat] = reading
            readings.append(reading)
        return readings, units, assumed is not None

    def _assumed_unit(self) -> Unit | None:
        """The unit in which the diameters come nearest to the nominal ones."""
        ratios = [
            raw.size / (self.names.controller.land_of_plane(key.component, key.plane).nominal_diameter / MM)
            for key, raw in self.found
            if raw.unit is None
        ]
        place = self.sheet.place(self.header.last, self.header.values[0].index, self.header.values[0].heading)
        middle = median(ratios)
        for name in unit_names("length"):
            unit = find_unit(name, "length")
            if 0.8 < middle * unit.factor / MM < 1.25:
                self.messages.append(
                    Message(
                        "warning",
                        "unit_assumed",
                        f"the sheet names no unit: {unit.name} assumed, in which the diameters come near the "
                        "nominal ones",
                        place,
                    )
                )
                return unit
        self._say(
            f"the sheet names no unit, and in none are the diameters near the nominal ones (they are {middle:.3g} "
            "times the nominal diameters in mm)",
            place,
            expected="a unit in the heading, such as 'Diameter [mm]'",
        )
        return None

    def _place(self, row: int, column: Column) -> Place:
        return self.sheet.place(row, column.index, " ".join(column.heading.split()))

    def _say(self, problem: str, place: Place, **details: object) -> None:
        self.problems.append(ReadingsError(problem, place=place, **details))  # type: ignore[arg-type]

    def _once(self, problem: ReadingsError) -> None:
        """A problem of the row, not of each of its values."""
        if problem.place not in {known.place for known in self.problems[-8:]}:
            self.problems.append(problem)


def _reading(key: _Key, raw: RawValue, unit: Unit) -> Reading:
    coordinates = None
    if raw.coordinates is not None:
        coordinates = (unit.to_si(raw.coordinates[0]), unit.to_si(raw.coordinates[1]))
    return Reading(
        component=key.component,
        part=key.part,
        plane=key.plane,
        direction=key.direction,
        repeat=0,
        diameter=unit.to_si(raw.size),
        place=raw.place,
        coordinates=coordinates,
    )


def _numbers(numbers: Sequence[int]) -> str:
    shown = ", ".join(str(number) for number in numbers[:20])
    return shown + (" …" if len(numbers) > 20 else "")
