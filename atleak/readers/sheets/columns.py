"""What the columns of a sheet are for, by their headings and by what stands under them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, reduce
from itertools import pairwise

from atleak.common.errors import ReadingsError
from atleak.common.sentences import Option, Sentence
from atleak.common.units import Unit, find_unit
from atleak.readers.sheets.column_headings import HeadedColumn, Role
from atleak.readers.sheets.controller_names import ControllerNames
from atleak.readers.sheets.table import HeadedTable, which_columns
from atleak.readers.sheets.words import plain, says_date, sheet_vocabulary, text_of

_NUMBER = Sentence("the component's number")
_HEADINGS = Sentence("headings such as 'No.', 'Part', 'Plane', 'Direction', 'Diameter [mm]'")
_BY_TITLE = Sentence("a column 'No.'; or say which one the title means: {option}")
_COORDINATES = ("coordinate 1", "coordinate 2")


@dataclass(frozen=True)
class Columns:
    """The columns to read from; None or empty where the sheet has none of a kind."""

    component: HeadedColumn | None
    names: tuple[HeadedColumn, ...]  # further columns that say the component too, by name beside the number
    part: HeadedColumn | None
    plane: HeadedColumn | None
    land: HeadedColumn | None
    direction: HeadedColumn | None  # None also where it is empty throughout
    repeat: HeadedColumn | None  # the same
    unit: HeadedColumn | None
    groups: tuple[dict[str, HeadedColumn], ...]  # each makes one diameter: "diameter", "coordinate 1", "coordinate 2"
    sheet_unit: Unit | None  # where a heading names none
    hidden: tuple[HeadedColumn, ...] = ()  # diameters left aside because a visible column holds the same part
    hidden_read: tuple[HeadedColumn, ...] = ()  # hidden diameters that are read because none does
    problems: list[ReadingsError] = field(default_factory=list)

    @cached_property
    def keys(self) -> tuple[HeadedColumn, ...]:
        """Return the columns that say what a diameter is of, and its unit."""
        keys = (self.component, *self.names, self.part, self.plane, self.land, self.direction, self.repeat, self.unit)
        return tuple(column for column in keys if column is not None)

    @cached_property
    def read(self) -> frozenset[int]:
        """Return the index of every column that something is read from."""
        values = (column for group in self.groups for column in group.values())
        return frozenset(column.index for column in (*self.keys, *values))


def find_columns(table: HeadedTable, names: ControllerNames) -> Columns:
    """Decide which column is what. What is missing or contradictory is among the ``problems``."""
    component = _component(table, names)
    hidden, hidden_read = _hidden(table)
    values = [column for column in table.values if column not in hidden]
    groups: dict[object, dict[str, HeadedColumn]] = {}
    problems: list[ReadingsError] = []
    for column in values:
        name = "diameter" if column.role == "diameter" else f"coordinate {column.coordinate}"
        other = groups.setdefault(column.group, {}).setdefault(name, column)
        if other is not column:
            problems.append(_same_value(table, name, other, column))
    columns = Columns(
        component=component,
        names=tuple(_same(table, names, component)),
        part=next(iter(table.of("part") or filter(table.names_parts, table.of("component"))), None),
        plane=_plane(table, names),
        land=next(iter(table.of("land")), None),
        direction=_used(table, "direction"),
        repeat=_used(table, "repeat"),
        unit=_used(table, "unit"),
        groups=tuple(groups.values()),
        sheet_unit=_sheet_unit(table),
        hidden=hidden,
        hidden_read=hidden_read,
        problems=problems,
    )
    problems += [*_two_states(table, values), *_alone(table, groups.values())]
    problems += _missing(table, names, columns)
    return columns


def _used(table: HeadedTable, role: Role) -> HeadedColumn | None:
    return next((column for column in table.of(role) if table.cells(column.index)), None)


def _component(table: HeadedTable, names: ControllerNames) -> HeadedColumn | None:
    """Return the column whose cells the controller knows, of those that may number or name the components.

    One whose cells are parts, as in the study's Table 1, is that of parts.
    """

    def sureness(column: HeadedColumn) -> tuple[float, float, int]:
        cells = table.cells(column.index).values()
        named = sum(names.component(cell) is not None for cell in cells)
        numbered = sum(text_of(cell) in names.with_lands for cell in cells)
        return named / max(len(cells), 1), numbered / max(len(cells), 1), column.rank

    columns = [column for column in table.of("component") if table.of("part") or not table.names_parts(column)]
    return max(columns, key=sureness, default=None)


def _plane(table: HeadedTable, names: ControllerNames) -> HeadedColumn | None:
    planes = {column: sum(map(names.is_plane, table.cells(column.index).values())) for column in table.of("plane")}
    return max(planes, key=lambda column: planes[column], default=None)


def _same(table: HeadedTable, names: ControllerNames, component: HeadedColumn | None) -> Iterator[HeadedColumn]:
    """Yield further columns that name the component, or number it in most rows, as no running number does."""
    numbered = {} if component is None else table.cells(component.index)
    for column in table.of("component") if component is not None else ():
        if column != component:
            cells = table.cells(column.index)
            pairs = [(names.component(numbered.get(row, "")), names.component(cell)) for row, cell in cells.items()]
            agree = [one == other for one, other in pairs if one is not None and other is not None]
            named = sum(names.is_named(text_of(cell)) for cell in cells.values())
            if 2 * sum(agree) > len(agree) or named > sum(agree):
                yield column


def _hidden(table: HeadedTable) -> tuple[tuple[HeadedColumn, ...], tuple[HeadedColumn, ...]]:
    concealed = [column for column in table.values if column.index in table.sheet.marks.hidden_columns]
    visible = [column for column in table.values if column not in concealed and table.cells(column.index)]
    # hidden coordinates beside the diameter that they make belong to the same reading
    lone = [column for column in concealed if not any(_makes_one(column, other) for other in visible)]
    aside = [
        column for column in lone if any(column.part in (None, other.part) or other.part is None for other in visible)
    ]
    return tuple(aside), tuple(column for column in lone if column not in aside)


def _makes_one(column: HeadedColumn, other: HeadedColumn) -> bool:
    return column.group == other.group and (column.role, column.coordinate) != (other.role, other.coordinate)


def _same_value(table: HeadedTable, name: str, first: HeadedColumn, second: HeadedColumn) -> ReadingsError:
    return which_columns(
        Sentence(
            "two columns are read as the same {what}: {first!r} and {second!r}",
            what=Sentence("diameter") if name == "diameter" else Sentence("coordinate"),
            first=first.name,
            second=second.name,
        ),
        table.heading_place(second.index),
        expected=Sentence(
            "one state of the valve body: delete or hide the other column; or, if they are repeats, headings such as "
            "'diameter 1 [mm]' and 'diameter 2 [mm]'"
        ),
    )


def _alone(table: HeadedTable, groups: Iterable[Mapping[str, HeadedColumn]]) -> Iterator[ReadingsError]:
    for group in groups:
        if "diameter" not in group and not group.keys() >= {*_COORDINATES}:
            column = next(iter(group.values()))
            yield ReadingsError(
                Sentence("one coordinate alone makes no diameter"),
                place=table.heading_place(column.index),
                value=column.name,
                expected=Sentence("both coordinates (x1 and x2), or the diameter"),
            )


def _two_states(table: HeadedTable, values: Sequence[HeadedColumn]) -> Iterator[ReadingsError]:
    for column, other in pairwise(values):
        numbered = column.station == other.station and column.repeat != other.repeat
        if numbered and column.besides != other.besides:
            problem = Sentence(
                "the columns {first!r} and {second!r} are told apart by more than the number of a repeat: two states?"
            )
            yield ReadingsError(
                problem.of(first=column.name, second=other.name),
                place=table.heading_place(other.index),
                value=", ".join(sorted(column.besides ^ other.besides)),
                expected=Sentence(
                    "one state of the valve body: delete or hide the other column; or headings that differ in the "
                    "number of the repeat only"
                ),
            )


def _sheet_unit(table: HeadedTable) -> Unit | None:
    headed = {column.unit for column in table.values if column.unit is not None}
    if len(headed) == 1:
        return headed.pop()
    for row in range(table.first):
        for index, cell in enumerate(table.sheet.rows[row]):
            words = plain(cell).replace(":", " ").replace("=", " ").split() if isinstance(cell, str) else []
            candidates: list[str] = []
            if words and words[0] in sheet_vocabulary("unit"):
                candidates = [*words[1:], str(table.sheet.cell(row, index + 1))]
            elif "in" in words[:-1] or "w" in words[:-1]:  # "all dimensions in mm"
                candidates = words[-1:]
            for bare in filter(None, (candidate.strip("[]()., ") for candidate in candidates)):
                if (unit := find_unit(bare, "length")) is not None:
                    return unit
    return None


def _missing(table: HeadedTable, names: ControllerNames, columns: Columns) -> Iterator[ReadingsError]:
    dated = _dated(table, columns)
    if dated is not None:
        yield dated
        return
    missing = []
    if columns.component is None and table.component is None:
        missing.append(_NUMBER)
    if columns.part is None and table.part is None and not all(column.part for column in table.values):
        missing.append(Sentence("the part (spool or sleeve)"))
    placed = bool(table.values) and all(column.land or column.plane for column in table.values)
    if columns.plane is None and columns.land is None and not placed and not _of_one_land(table, names, columns):
        missing.append(Sentence("the measurement plane (or land)"))
    if missing:
        what = reduce(lambda first, second: Sentence("{first} nor {second}", first=first, second=second), missing)
        yield which_columns(
            Sentence("no column holds {what}", what=what),
            table.sheet.place(max(table.last, 0)),
            ", ".join(column.name for column in table.columns),
            _HEADINGS
            if what != _NUMBER or not table.title
            else _BY_TITLE.of(option=Option("name", text=f'--map "component …={table.title}"')),
        )


def _of_one_land(table: HeadedTable, names: ControllerNames, columns: Columns) -> bool:
    column = columns.component
    named = {table.component} if column is None else set(map(names.component, table.cells(column.index).values()))
    return bool(named) and all(len(lands) == 1 for lands in map(names.controller.lands_of, filter(None, named)))


def _dated(table: HeadedTable, columns: Columns) -> ReadingsError | None:
    for column in filter(None, (columns.component, columns.plane, columns.land)):
        for row, cell in table.cells(column.index).items():
            if says_date(cell):
                return ReadingsError(
                    Sentence("the spreadsheet program has made a date of this cell"),
                    place=table.place(row, column),
                    value=text_of(cell).removesuffix(" 00:00:00"),
                    expected=Sentence(
                        "component and plane, such as 8/1: format the column as text and type them again, or write a "
                        "column for each"
                    ),
                )
    return None
