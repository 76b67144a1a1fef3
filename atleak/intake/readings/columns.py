"""What the columns of a sheet are for, by their headings and by what stands under them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import reduce
from itertools import pairwise

from atleak.errors import ReadingsError
from atleak.intake.readings.controller_names import ControllerNames
from atleak.intake.readings.headings import Header
from atleak.intake.readings.labels import says_date
from atleak.intake.readings.one_heading import Column, Role
from atleak.intake.readings.sheet_tables import Table
from atleak.intake.readings.words import is_blank, part_said, plain, text_of, vocabulary
from atleak.intake.sheets.sheet import Cell, Sheet
from atleak.intake.units import Unit, find_unit
from atleak.sentence import Sentence

_UNIT_WORDS = vocabulary("unit")
_VALUE_WORDS = {
    "diameter": Sentence("diameter"),
    "coordinate 1": Sentence("coordinate 1"),
    "coordinate 2": Sentence("coordinate 2"),
}


@dataclass(frozen=True)
class Columns:
    """The columns to read from; None or empty where the sheet has none of a kind."""

    component: Column | None
    names: tuple[Column, ...]  # further columns that say the component too, by name beside the number
    part: Column | None
    plane: Column | None
    land: Column | None
    direction: Column | None  # None also where it is empty throughout
    repeat: Column | None  # the same
    unit: Column | None
    groups: tuple[dict[str, Column], ...]  # each makes one diameter: "diameter", "coordinate 1", "coordinate 2"
    sheet_unit: Unit | None  # where a heading names none
    hidden: tuple[Column, ...] = ()  # diameters left aside because a visible column holds the same part
    hidden_read: tuple[Column, ...] = ()  # hidden diameters that are read because none does
    problems: list[ReadingsError] = field(default_factory=list)

    @property
    def keys(self) -> tuple[Column, ...]:
        """Return the columns that say what a diameter is of, and its unit."""
        keys = (self.component, *self.names, self.part, self.plane, self.land, self.direction, self.repeat, self.unit)
        return tuple(column for column in keys if column is not None)

    @property
    def read(self) -> frozenset[int]:
        """Return the index of every column that something is read from."""
        values = (column for group in self.groups for column in group.values())
        return frozenset(column.index for column in (*self.keys, *values))


def find_columns(table: Table, names: ControllerNames) -> Columns:
    """Decide which column is what. What is missing or contradictory is among the ``problems``."""
    sheet, header = table.sheet, table.header
    component = _component(sheet, header, names)
    problems: list[ReadingsError] = []
    shown, hidden, hidden_read = _shown(sheet, header)
    columns = Columns(
        component=component,
        names=tuple(_same(sheet, header, names, component)),
        part=_part(sheet, header),
        plane=_plane(sheet, header, names),
        land=next(iter(header.of("land")), None),
        direction=_used(sheet, header, "direction"),
        repeat=_used(sheet, header, "repeat"),
        unit=_used(sheet, header, "unit"),
        groups=tuple(_groups(sheet, header, shown, problems)),
        sheet_unit=_sheet_unit(sheet, header),
        hidden=hidden,
        hidden_read=hidden_read,
        problems=problems,
    )
    problems.extend(_missing(table, names, columns))
    return columns


def count_values(sheet: Sheet, header: Header) -> int:
    """Count the cells under the headings that hold something where a diameter belongs."""
    return sum(
        not is_blank(sheet.cell(row, column.index))
        for row in range(header.last + 1, len(sheet.rows))
        for column in header.values
    )


def _cells(sheet: Sheet, header: Header, column: Column) -> Iterator[Cell]:
    for row in range(header.last + 1, len(sheet.rows)):
        cell = sheet.filled(row, column.index)
        if not is_blank(cell):
            yield cell


def _used(sheet: Sheet, header: Header, role: Role) -> Column | None:
    return next((column for column in header.of(role) if any(True for _ in _cells(sheet, header, column))), None)


def _names_parts(sheet: Sheet, header: Header, column: Column) -> bool:
    cells = list(_cells(sheet, header, column))
    return bool(cells) and sum(part_said(text_of(cell)) is not None for cell in cells) > 0.5 * len(cells)


def _part(sheet: Sheet, header: Header) -> Column | None:
    """Return the column headed "part", or one headed "component" whose cells are parts, as in the study's Table 1."""
    candidates = header.of("part") or tuple(
        column for column in header.of("component") if _names_parts(sheet, header, column)
    )
    return next(iter(candidates), None)


def _component(sheet: Sheet, header: Header, names: ControllerNames) -> Column | None:
    """Return the column whose cells the controller knows, of those that may number or name the components."""
    best: tuple[float, float, int, Column] | None = None
    for column in header.of("component"):
        if not header.of("part") and _names_parts(sheet, header, column):
            continue
        cells = list(_cells(sheet, header, column))
        known = sum(names.component(cell) is not None for cell in cells) / len(cells) if cells else 0.0
        numbered = sum(text_of(cell) in names.with_lands for cell in cells) / len(cells) if cells else 0.0
        if best is None or (known, numbered, column.rank) > best[:3]:
            best = (known, numbered, column.rank, column)
    return best[3] if best else None


def _plane(sheet: Sheet, header: Header, names: ControllerNames) -> Column | None:
    """Return the column of planes; of several the one whose cells the controller knows."""
    columns = header.of("plane")
    if len(columns) < 2:
        return next(iter(columns), None)
    return max(columns, key=lambda column: sum(map(names.is_plane, _cells(sheet, header, column))))


def _same(sheet: Sheet, header: Header, names: ControllerNames, component: Column | None) -> Iterator[Column]:
    """Yield further columns that name the component, or number it in most rows, as no running number does."""
    for column in header.of("component"):
        if component is None or column == component:
            continue
        agree = differ = named = 0
        for row in range(header.last + 1, len(sheet.rows)):
            named += names.is_named(text_of(sheet.filled(row, column.index)))
            one, other = (names.component(sheet.filled(row, each.index)) for each in (component, column))
            if one is not None and other is not None:
                agree, differ = agree + (one == other), differ + (one != other)
        if agree > differ or named > agree:
            yield column


def _shown(sheet: Sheet, header: Header) -> tuple[tuple[Column, ...], tuple[Column, ...], tuple[Column, ...]]:
    """Return the columns of diameters to read, the hidden ones left aside, and the hidden ones that are read."""
    concealed = [column for column in header.values if column.index in sheet.marks.hidden_columns]
    if not concealed:
        return header.values, (), ()
    visible = [
        column
        for column in header.values
        if column not in concealed and any(True for _ in _cells(sheet, header, column))
    ]
    # hidden coordinates beside the diameter that they make belong to the same reading
    beside = [column for column in concealed if any(_makes_one(column, other) for other in visible)]
    aside = [
        column
        for column in concealed
        if column not in beside and any(column.part in (None, other.part) or other.part is None for other in visible)
    ]
    read = tuple(column for column in concealed if column not in aside and column not in beside)
    return tuple(column for column in header.values if column not in aside), tuple(aside), read


def _makes_one(column: Column, other: Column) -> bool:
    return column.group == other.group and (column.role, column.coordinate) != (other.role, other.coordinate)


def _groups(
    sheet: Sheet, header: Header, values: Sequence[Column], problems: list[ReadingsError]
) -> list[dict[str, Column]]:
    groups: dict[object, dict[str, Column]] = {}
    for column in values:
        name = "diameter" if column.role == "diameter" else f"coordinate {column.coordinate}"
        group = groups.setdefault(column.group, {})
        if name in group:
            problems.append(
                ReadingsError(
                    Sentence(
                        "two columns are read as the same {what}: {first!r} and {second!r}",
                        what=_VALUE_WORDS.get(name, Sentence("coordinate")),
                        first=group[name].name,
                        second=column.name,
                    ),
                    place=sheet.place(header.last, column.index, column.heading),
                    expected=Sentence(
                        "one state of the valve body: delete or hide the other column; or, if they are repeats, "
                        "headings such as 'diameter 1 [mm]' and 'diameter 2 [mm]'"
                    ),
                )
            )
        group.setdefault(name, column)
    problems.extend(_unsure(sheet, header, values))
    problems.extend(_two_states(sheet, header, values))
    for group in groups.values():
        coordinates = [name for name in ("coordinate 1", "coordinate 2") if name in group]
        if "diameter" not in group and len(coordinates) != 2:
            column = next(iter(group.values()))
            problems.append(
                ReadingsError(
                    Sentence("one coordinate alone makes no diameter"),
                    place=sheet.place(header.last, column.index, column.heading),
                    value=column.name,
                    expected=Sentence("both coordinates (x1 and x2), or the diameter"),
                )
            )
    return list(groups.values())


def _unsure(sheet: Sheet, header: Header, values: Sequence[Column]) -> Iterator[ReadingsError]:
    """Yield a problem for columns headed by numbers alone, where the nominal diameters do not tell them for lands."""
    unsure = [column for column in values if column.unsure]
    if unsure and unsure[0].index in sheet.derived:
        yield ReadingsError(
            Sentence("nothing says in which unit the deviations are"),
            place=sheet.place(header.last, unsure[0].index, unsure[0].heading),
            value=unsure[0].name,
            expected=Sentence("the unit in the heading, such as 'Deviation [µm]'"),
        )
    elif unsure:
        yield ReadingsError(
            Sentence(
                "columns {names} are headed by numbers alone: lands, directions or repeats?",
                names=tuple(repr(column.name) for column in unsure),
            ),
            place=sheet.place(header.last, unsure[0].index, unsure[0].heading),
            expected=Sentence("headings such as 'land 1', '0°' or 'diameter 1'"),
        )


def _two_states(sheet: Sheet, header: Header, values: Sequence[Column]) -> Iterator[ReadingsError]:
    """Yield a problem for columns that number repeats and differ in other words: "diameter 1 before", "2 after"."""
    for column, other in pairwise(values):
        numbered = column.station == other.station and column.repeat != other.repeat
        if numbered and column.besides != other.besides:
            yield ReadingsError(
                Sentence(
                    "the columns {first!r} and {second!r} are told apart by more than the number of a repeat: two "
                    "states?",
                    first=column.name,
                    second=other.name,
                ),
                place=sheet.place(header.last, other.index, other.heading),
                value=", ".join(sorted(column.besides ^ other.besides)),
                expected=Sentence(
                    "one state of the valve body: delete or hide the other column; or headings that differ in the "
                    "number of the repeat only"
                ),
            )


def _sheet_unit(sheet: Sheet, header: Header) -> Unit | None:
    """Return the unit where a heading names none: that of the other headings, or the one stated above the table."""
    headed = {column.unit for column in header.values if column.unit is not None}
    if len(headed) == 1:
        return headed.pop()
    for row in range(header.first):
        for index, cell in enumerate(sheet.rows[row]):
            words = plain(cell).replace(":", " ").replace("=", " ").split() if isinstance(cell, str) else []
            if words and words[0] in _UNIT_WORDS:
                candidates = [*words[1:], str(sheet.cell(row, index + 1))]
            elif "in" in words[:-1] or "w" in words[:-1]:  # "all dimensions in mm"
                candidates = words[-1:]
            else:
                continue
            for candidate in candidates:
                bare = candidate.strip("[]()., ")
                unit = find_unit(bare, "length") if bare else None
                if unit is not None:
                    return unit
    return None


def _missing(table: Table, names: ControllerNames, columns: Columns) -> Iterator[ReadingsError]:
    sheet, header = table.sheet, table.header
    dated = _dated(table, columns)
    if dated is not None:
        yield dated
        return
    missing = []
    if columns.component is None and table.component is None:
        missing.append(Sentence("the component's number"))
    if columns.part is None and table.part is None and not all(column.part for column in header.values):
        missing.append(Sentence("the part (spool or sleeve)"))
    placed = bool(header.values) and all(column.land or column.plane for column in header.values)
    if columns.plane is None and columns.land is None and not placed and not _of_one_land(table, names, columns):
        missing.append(Sentence("the measurement plane (or land)"))
    if missing:
        what = reduce(lambda first, second: Sentence("{first} nor {second}", first=first, second=second), missing)
        yield ReadingsError(
            Sentence("no column holds {what}", what=what),
            place=sheet.place(max(header.last, 0)),
            value=", ".join(column.name for column in header.columns),
            expected=Sentence("headings such as 'No.', 'Part', 'Plane', 'Direction', 'Diameter [mm]'"),
        )


def _of_one_land(table: Table, names: ControllerNames, columns: Columns) -> bool:
    """Return whether every component that the table names has one land, so that nothing need say which."""
    cells = [] if columns.component is None else list(_cells(table.sheet, table.header, columns.component))
    named = {table.component} if columns.component is None else {names.component(cell) for cell in cells}
    return bool(named) and all(len(names.controller.lands_of(each)) == 1 for each in named if each is not None)


def _dated(table: Table, columns: Columns) -> ReadingsError | None:
    """Return an error where a spreadsheet program has made dates of "8-1" in a column that says what rows are of."""
    for column in (columns.component, columns.plane, columns.land):
        for row in () if column is None else table.rows:
            assert column is not None
            cell = table.sheet.filled(row, column.index)
            if says_date(cell):
                return ReadingsError(
                    Sentence("the spreadsheet program has made a date of this cell"),
                    place=table.sheet.place(row, column.index, column.name),
                    value=text_of(cell).removesuffix(" 00:00:00"),
                    expected=Sentence(
                        "component and plane, such as 8/1: format the column as text and type them again, or write a "
                        "column for each"
                    ),
                )
    return None
