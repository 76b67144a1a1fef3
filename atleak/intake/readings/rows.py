"""The rows under the headings → readings with their places, and every row that says nothing usable."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from atleak.catalogue.instruments import Part
from atleak.errors import Message, Place, ReadingsError, nearest_name, one_of
from atleak.intake.readings import author_marks, states
from atleak.intake.readings.asides import Asides
from atleak.intake.readings.columns import Columns, find_columns
from atleak.intake.readings.controller_names import ControllerNames
from atleak.intake.readings.filled_down import FILL_DOWN, broken_blocks
from atleak.intake.readings.one_heading import Column
from atleak.intake.readings.sheet_tables import Table
from atleak.intake.readings.sizes import MM as MILLIMETRE
from atleak.intake.readings.values import MM, DiameterCell, Key, RawValue
from atleak.intake.readings.words import (
    A_DIAMETER,
    at,
    diameter,
    direction_of,
    is_blank,
    is_page_title,
    number,
    part_said,
    part_words,
    plain,
    repeat_of,
    says_unworn,
    summary_of,
    text_of,
)
from atleak.intake.sheets.extent import FAULTS
from atleak.intake.sheets.sheet import Cell, column_letter
from atleak.intake.units import Unit, find_unit, unit_names
from atleak.phrases import PART_WORDS
from atleak.sentence import Name, Sentence, all_of

_EVERY_ROW = Sentence("the value in every row; or merged cells in a workbook; {fill_down}", fill_down=FILL_DOWN)
_IN_TEXT = Sentence(
    "the value in every row; or the workbook itself, as a text file does not keep merged cells; {fill_down}",
    fill_down=FILL_DOWN,
)


@dataclass
class Rows:
    """The diameters of a table as written, and what is wrong with it.

    ``cells`` are those that were read or left aside with a word, by row and column; ``of_row`` is what the rows that
    were read are of.
    """

    table: Table
    columns: Columns
    entries: list[DiameterCell] = field(default_factory=list)
    problems: list[ReadingsError] = field(default_factory=list)
    messages: list[Message] = field(default_factory=list)
    rows_without_reading: int = 0
    cells: set[tuple[int, int]] = field(default_factory=set)
    of_row: dict[int, list[Key]] = field(default_factory=dict)


def read_rows(
    table: Table, names: ControllerNames, given_unit: Unit | None, where: Mapping[str, str] | None = None
) -> Rows:
    """Read every diameter of a table, and note everything that is wrong with it."""
    columns = find_columns(table, names)
    if columns.problems:
        return Rows(table, columns, problems=columns.problems)
    return _Reader(table, columns, names, given_unit, where or {}).read()


class _Reader:
    def __init__(
        self, table: Table, columns: Columns, names: ControllerNames, given_unit: Unit | None, where: Mapping[str, str]
    ) -> None:
        self.table, self.columns, self.names, self.given_unit, self.where = table, columns, names, given_unit, where
        self.sheet, self.header = table.sheet, table.header
        self.values = [column.index for group in columns.groups for column in group.values()]
        self.asides = Asides(table, columns, names)
        self.left_out = states.rows_left_out(table, where)
        self.entries: list[DiameterCell] = []
        self.breaks: list[states.Break] = []
        self.problems: list[ReadingsError] = []
        self.messages: list[Message] = []
        self.blanks: dict[Column, dict[int, None]] = defaultdict(dict)
        self.overridden: set[str] = set()
        self.cells: set[tuple[int, int]] = set()
        self.of_row: dict[int, list[Key]] = {}

    def read(self) -> Rows:
        unread = left_out = 0
        faulty_rows = {row for row, _ in self.sheet.faults}
        for row in self.table.rows:
            if len(self.problems) > FAULTS:
                break
            cells = self.sheet.rows[row]
            if all(is_blank(cell) for cell in cells) and row not in faulty_rows:
                continue
            holds = any(not is_blank(self.sheet.cell(row, index)) for index in self.values)
            if row in self.left_out:
                left_out += holds
                self._account_for_row(row)
            elif holds and self.asides.takes(row):
                self._account_for_row(row)
            elif not self._read_row(row):
                if title := self._title(row):
                    self.breaks.append(states.Break(row, title))
                else:
                    unread += self._is_named(row)
        self._read_means_alone()
        self._report_blanks()
        self._report_overridden()
        self._report_hidden_columns()
        if left_out:
            chosen = all_of(
                Sentence("{heading} is {value!r}", heading=heading, value=value)
                for heading, value in self.where.items()
            )
            text = Sentence("{count} row left aside: read were those where {chosen}", count=left_out, chosen=chosen)
            if left_out > 1:
                text = Sentence(
                    "{count} rows left aside: read were those where {chosen}", count=left_out, chosen=chosen
                )
            self.messages.append(Message("info", "rows_left_out", text, self.sheet.place()))
        self.problems += broken_blocks(self.table, self.entries, self.names)
        question = states.question(self.entries, self.breaks, self.table, self.columns)
        if question is not None:
            self.problems.append(question)
        self.messages += self.asides.messages(self.entries)
        self.messages += author_marks.messages(self.table, self.of_row, self.columns)
        self.messages += states.messages(self.entries, self.table, self.columns, self.names.controller)
        return Rows(
            self.table, self.columns, self.entries, self.problems, self.messages, unread, self.cells, self.of_row
        )

    def _read_row(self, row: int) -> bool:
        """Read a row's diameters; return whether there are any, readable or not."""
        values = list(self._raw_values(row))
        if values:
            self._report_overlong(row)
            self.cells.update((row, column.index) for column in self.columns.keys)
        for group, value in values:
            key = self._key(row, group)
            if key is not None and value is not None:
                column = (group.get("diameter") or next(iter(group.values()))).index
                self.entries.append(DiameterCell(row, column, key, value))
                self.of_row.setdefault(row, []).append(key)
                self.cells.update((row, column.index) for column in group.values())
        return bool(values) or row in self.asides.struck

    def _account_for_row(self, row: int) -> None:
        """Note that all cells of a row are accounted for, because a message names the row."""
        self.cells.update((row, index) for index in range(len(self.sheet.rows[row])))

    def _is_named(self, row: int) -> bool:
        columns = self.columns
        named = columns.component or columns.part or columns.plane or columns.land
        return named is not None and not is_blank(self.sheet.filled(row, named.index))

    def _title(self, row: int) -> str:
        """Return what a row without numbers says, unless it is one that was not measured."""
        column = self.columns.component
        if column is None or self.names.component(self.sheet.filled(row, column.index)) is not None:
            return ""
        title = " ".join(text_of(cell) for cell in self.sheet.rows[row] if isinstance(cell, str) and cell.strip())
        return "" if is_page_title(title) else title[:80]

    def _read_means_alone(self) -> None:
        """Read means as readings where their single readings are not on the sheet."""
        read = tuple(self.entries)
        for summary in [each for each in self.asides.summaries if self.asides.stands_alone(each, read)]:
            self.asides.summaries.remove(summary)
            self._read_row(summary.row)
            text = Sentence(
                "row {row} is said to be a {what}, and its single readings are not there: read as one reading",
                row=self.sheet.row_number(summary.row),
                what=summary.name,
            )
            self.messages.append(Message("info", "summary_as_reading", text, self.sheet.place(summary.row)))

    def _report_overlong(self, row: int) -> None:
        """Report a text row with more cells than headings: its decimal commas were taken for the ends of cells."""
        width = len(self.header.texts)
        if self.sheet.is_text and any(not is_blank(cell) for cell in self.sheet.rows[row][width:]):
            self._add_problem(
                Sentence(
                    "the row has {cells} cells under {headings} headings: a decimal comma in a file whose columns are "
                    "separated by commas?",
                    cells=len(self.sheet.rows[row]),
                    headings=width,
                ),
                self.sheet.place(row),
                value=", ".join(str(cell) for cell in self.sheet.rows[row]),
                expected=Sentence("semicolons or tabs between the columns, or decimal points"),
            )

    def _raw_values(self, row: int) -> Iterator[tuple[dict[str, Column], RawValue | None]]:
        """Yield each diameter of a row; None for one that is there and cannot be read (the problem is noted)."""
        for group in self.columns.groups:
            given = {name: column for name, column in group.items() if not is_blank(self.sheet.cell(row, column.index))}
            if any((row, column.index) in self.sheet.marks.struck for column in given.values()):
                self.asides.struck.append(row)
                self.cells.update((row, column.index) for column in given.values())
                continue
            faulty = [
                column
                for name, column in group.items()
                if name not in given and self._fault(row, column, group, bool(given))
            ]
            if not given and not faulty:
                continue
            if faulty or self._half_given(row, group, given):
                yield group, None
                continue
            yield group, self._raw_value(row, given)

    def _fault(self, row: int, column: Column, group: dict[str, Column], others: bool) -> bool:
        fault = self.sheet.faults.get((row, column.index))
        if fault is None or others:
            return False
        if fault.startswith("#"):
            problem = Sentence("this cell's formula gives an error")
            self._add_problem(problem, self._place(row, column), value=fault, expected=A_DIAMETER)
            return True
        coordinates = [other.index for name, other in group.items() if name.startswith("coordinate")]
        if any(re.search(rf"\b{column_letter(index)}{row + 1}\b", fault.replace("$", "")) for index in coordinates):
            return False  # a formula over coordinates that are not filled in yet
        self._add_problem(
            Sentence("this cell's formula has no stored result"),
            self._place(row, column),
            value=fault,
            expected=Sentence("a diameter such as 9.939: open the workbook in a spreadsheet program and save it again"),
        )
        return True

    def _half_given(self, row: int, group: dict[str, Column], given: dict[str, Column]) -> bool:
        if "diameter" in given:
            return False
        for number_of_it in (1, 2):
            name = f"coordinate {number_of_it}"
            if name not in given:
                self._add_problem(
                    Sentence("coordinate {number} is missing beside the other one", number=number_of_it),
                    self._place(row, group.get(name) or next(iter(given.values()))),
                    expected=Sentence("both coordinates, or the diameter"),
                )
                return True
        return False

    def _raw_value(self, row: int, given: dict[str, Column]) -> RawValue | None:
        numbers: dict[str, float] = {}
        units: dict[str, Unit | None] = {}
        for name, column in given.items():
            place = self._place(row, column)
            try:
                read = diameter if name == "diameter" else number
                numbers[name], written = read(self.sheet.cell(row, column.index))
            except ReadingsError as error:
                self.problems.append(at(place, error))
                return None
            units[name] = written or self._unit(row, column)
        unit = next(iter(units.values()))
        if len(set(units.values())) > 1:  # diameter and coordinates each in its own unit
            numbers = {name: value * ((units[name] or MILLIMETRE).factor / MM) for name, value in numbers.items()}
            unit = MILLIMETRE
        place = self._place(row, given.get("diameter") or given["coordinate 1"])
        coordinates = None
        if "coordinate 1" in numbers and "coordinate 2" in numbers:
            coordinates = (numbers["coordinate 1"], numbers["coordinate 2"])
            if coordinates[0] == coordinates[1]:
                problem = Sentence("both coordinates are equal: no diameter between them")
                self._add_problem(problem, place, value=coordinates[0])
                return None
        return RawValue(numbers.get("diameter"), coordinates, unit, place)

    def _unit(self, row: int, column: Column) -> Unit | None:
        """Return the unit of a cell that states none: the user's, the row's, the heading's, or that above the table."""
        if column.index in self.sheet.derived:
            return column.unit  # a sum of columns, made in this unit
        if self.given_unit is not None:
            if column.unit is not None and column.unit != self.given_unit:
                self.overridden.add(column.name)
            return self.given_unit
        unit_column = self.columns.unit
        cell = self.sheet.filled(row, unit_column.index) if unit_column else ""
        if unit_column is None or is_blank(cell):
            return column.unit or self.columns.sheet_unit
        unit = find_unit(text_of(cell), "length")
        if unit is None:
            known = unit_names("length")
            self._add_problem_once(
                ReadingsError(
                    Sentence("unknown unit of length"),
                    place=self._place(row, unit_column),
                    value=text_of(cell),
                    expected=one_of(known),
                    nearest=nearest_name(text_of(cell), known),
                )
            )
        return unit

    # --- what the row is about ------------------------------------------------------------------------------------

    def _key(self, row: int, group: dict[str, Column]) -> Key | None:
        column = next(iter(group.values()))
        component = self._component(row)
        part = column.part or self._part(row)
        plane = self._plane(row, component, column)
        direction, known = self._direction(row, column)
        repeat, explicit, countable = self._repeat(row, column)
        if component is None or part is None or plane is None or not known or not countable:
            return None
        return Key(component, part, plane, direction, repeat, explicit, self._is_unworn(row))

    def _is_unworn(self, row: int) -> bool:
        """Return whether a cell of its own says that the row's diameter was taken at an unworn end."""
        cells = (self.sheet.filled(row, index) for index in range(self.sheet.width) if index not in self.columns.read)
        return any(isinstance(cell, str) and says_unworn(cell) for cell in cells)

    def _required(self, row: int, column: Column) -> Cell | None:
        cell = self.sheet.filled(row, column.index)
        if not is_blank(cell):
            return cell
        self.blanks[column][row] = None
        return None

    def _component(self, row: int) -> str | None:
        column = self.columns.component
        if column is None:
            return self.table.component
        cell = self._required(row, column)
        if cell is None:
            return None
        try:
            component = self.names.require_component(cell)
            for column in self.columns.names:
                self._same_component(component, self.sheet.filled(row, column.index))
            return component
        except ReadingsError as problem:
            self._add_problem_once(at(self._place(row, column), problem))
            return None

    def _same_component(self, component: str, cell: Cell) -> None:
        """Refuse a row whose number and name contradict each other."""
        named = None if is_blank(cell) else self.names.component(cell)
        if named is not None and named != component:
            raise ReadingsError(
                Sentence(
                    "this is component {named}, in a row of component {component}", named=named, component=component
                ),
                value=text_of(cell),
                expected=Sentence(
                    "{component} or {name}",
                    component=component,
                    name=Name(self.names.controller.components[component]),
                ),
            )

    def _part(self, row: int) -> Part | None:
        if self.columns.part is None:
            return self.table.part
        cell = self._required(row, self.columns.part)
        if cell is None:
            return None
        part = part_said(text_of(cell))
        if part is None:
            near = nearest_name(plain(text_of(cell)), part_words())
            meant = part_said(near) if near else None
            self._add_problem_once(
                ReadingsError(
                    Sentence("unknown part"),
                    place=self._place(row, self.columns.part),
                    value=text_of(cell),
                    expected=Sentence("spool (or piston), or sleeve (or bore)"),
                    nearest=PART_WORDS[meant] if meant else None,
                )
            )
        return part

    def _plane(self, row: int, component: str | None, value: Column) -> str | None:
        """Return the plane as the controller spells it: of the planes or lands that columns or the heading name."""
        columns = self.columns
        if component is None:  # reported already; whether a plane is given at all is still reported
            self._named(row, None if value.land else columns.land or columns.plane, value.land)
            return None
        land_cell = self._named(row, columns.land, value.land)
        needed = columns.land is None and value.land is None
        plane_cell = self._named(row, columns.plane, value.plane, needed=needed)
        if needed and plane_cell is None:
            return self._only_plane(row, component) if columns.plane is None and value.plane is None else None
        if not needed and land_cell is None:
            return None
        column = value if needed and value.plane else columns.plane or columns.land or value
        try:
            if needed:
                return self.names.plane(component, plane_cell)
            column = value if value.land else columns.land or value
            land = self.names.land(component, land_cell)
            if plane_cell is None:
                return land.planes[0]
            column = value if value.plane else columns.plane or value
            plane = self.names.plane(component, plane_cell)
            if plane not in land.planes:
                raise ReadingsError(
                    Sentence(
                        "this plane of component {component} is not on land {land}", component=component, land=land.land
                    ),
                    value=plane,
                    expected=Sentence("plane {names}", names=land.planes),
                )
            return plane
        except ReadingsError as problem:
            self._add_problem_once(at(self._place(row, column), problem))
            return None

    def _named(self, row: int, column: Column | None, headed: str | None, needed: bool = True) -> Cell | None:
        """Return what the value's heading names, or else the cell of the row; None where it is empty."""
        if headed is not None or column is None:
            return headed
        if needed:
            return self._required(row, column)
        cell = self.sheet.filled(row, column.index)
        return None if is_blank(cell) else cell

    def _only_plane(self, row: int, component: str) -> str | None:
        """Return the plane of a component with one land, which nothing need name."""
        lands = self.names.controller.lands_of(component)
        return lands[0].planes[0] if len(lands) == 1 else None

    def _direction(self, row: int, value: Column) -> tuple[float | None, bool]:
        column = self.columns.direction
        if column is None:
            return value.direction, True
        cell = self._required(row, column)
        if cell is None:
            return None, False
        direction = direction_of(cell)
        if direction is None:
            self._add_problem_once(
                ReadingsError(
                    Sentence("unknown measuring direction"),
                    place=self._place(row, column),
                    value=text_of(cell),
                    expected=Sentence("an angle such as 0° or 90°, or x1-x2, y1-y2, I, II"),
                )
            )
        return direction, direction is not None

    def _repeat(self, row: int, value: Column) -> tuple[int | None, bool, bool]:
        """Return the repeat's number, whether a column says it, and whether it could be read."""
        column = self.columns.repeat
        if column is None or value.repeat is not None:
            return value.repeat, False, True
        cell = self._required(row, column)
        if cell is None:
            return None, True, False
        repeat = repeat_of(cell)
        if repeat is None and summary_of(cell, key=True):  # a mean that stands for its single readings
            return None, False, True
        if repeat is None:
            self._add_problem_once(
                ReadingsError(
                    Sentence("not the number of a repeat"),
                    place=self._place(row, column),
                    value=text_of(cell),
                    expected=Sentence("1, 2, 3 …"),
                )
            )
            return None, True, False
        return repeat, True, True

    # --- all rows together ----------------------------------------------------------------------------------------

    def _report_blanks(self) -> None:
        for column, rows in self.blanks.items():
            numbers = [self.sheet.row_number(row) for row in rows]
            heading = " ".join(column.heading.split())
            problem = Sentence("column {heading!r} is empty in a row that holds a reading", heading=heading)
            if len(numbers) > 1:
                problem = Sentence(
                    "column {heading!r} is empty in a row that holds a reading and in {count} more: {rows}",
                    heading=heading,
                    count=len(numbers) - 1,
                    rows=_numbers(numbers[1:]),
                )
            self._add_problem(
                problem,
                self._place(next(iter(rows)), column),
                expected=_IN_TEXT if self.sheet.is_text else _EVERY_ROW,
            )

    def _report_overridden(self) -> None:
        if self.given_unit is not None and self.overridden:
            text = Sentence(
                "read in {unit} as told, although the heading says otherwise: {headings}",
                unit=self.given_unit.said,
                headings=tuple(sorted(self.overridden)),
            )
            self.messages.append(Message("warning", "unit_told", text, self.sheet.place(max(self.header.last, 0))))

    def _report_hidden_columns(self) -> None:
        for column in self.columns.hidden:
            self.cells.update((row, column.index) for row in self.table.rows)
        for columns, done in (
            (self.columns.hidden, Sentence("left aside, because a visible column holds the same part")),
            (self.columns.hidden_read, Sentence("read, because no visible column holds the same part")),
        ):
            if columns:
                names = tuple(repr(self.header.text(column.index)) for column in columns)
                text = Sentence("hidden column {names} {done}", names=names, done=done)
                if len(columns) > 1:
                    text = Sentence("hidden columns {names} {done}", names=names, done=done)
                self.messages.append(Message("warning", "hidden_columns", text, self.sheet.place(self.header.last)))

    def _place(self, row: int, column: Column) -> Place:
        return self.sheet.place(row, column.index, column.name)

    def _add_problem(
        self, problem: Sentence, place: Place, *, value: object = None, expected: Sentence | None = None
    ) -> None:
        self.problems.append(ReadingsError(problem, place=place, value=value, expected=expected))

    def _add_problem_once(self, problem: ReadingsError) -> None:
        """Add a problem of the row once, not for each of its values."""
        if problem.place not in {known.place for known in self.problems[-8:]}:
            self.problems.append(problem)


def _numbers(numbers: Sequence[int]) -> str:
    shown = ", ".join(str(number) for number in numbers[:20])
    return shown + (" …" if len(numbers) > 20 else "")
