"""The rows under the headings → readings with their places, and every row that says nothing usable."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from atleak.catalogue.instruments import Part
from atleak.catalogue.words import PART_WORDS
from atleak.common.errors import Message, ReadingsError, nearest_name, unknown
from atleak.common.sentences import Name, Option, Sentence, all_of, counted
from atleak.common.units import Unit, find_unit, unit_names
from atleak.measurements.readings import CellKind, CellMeaning
from atleak.readers.cells.extent import FAULTS
from atleak.readers.cells.sheet import Cell, column_letter, rows_named
from atleak.readers.sheets.column_headings import HeadedColumn, Role
from atleak.readers.sheets.columns import Columns, find_columns
from atleak.readers.sheets.controller_names import MILLIMETRE, ControllerNames, label_apart, read_label
from atleak.readers.sheets.diameters import FILL_DOWN, DiameterCell, PlaceKey, RawValue, broken_blocks
from atleak.readers.sheets.exclusions import Exclusions, mark_messages
from atleak.readers.sheets.repeats import Break, repeat_messages, rows_left_out, states_question
from atleak.readers.sheets.table import COLUMNS, HeadedTable
from atleak.readers.sheets.words import (
    A_DIAMETER,
    PART_SPELLINGS,
    at,
    diameter,
    direction_of,
    is_blank,
    is_page_title,
    number,
    part_of,
    part_said,
    plain,
    repeat_of,
    says_unworn,
    several_in,
    summary_of,
    text_of,
)

_EVERY_ROW = Sentence("the value in every row; or merged cells in a workbook; {fill_down}", fill_down=FILL_DOWN)
_IN_TEXT = Sentence(
    "the value in every row; or the workbook itself, as a text file does not keep merged cells; {fill_down}",
    fill_down=FILL_DOWN,
)


_LABELS = (
    *(Sentence("component"), Sentence("part"), Sentence("plane"), Sentence("land"), Sentence("direction")),
    *(Sentence("repeat"), Sentence("unit")),
)
LABEL_OF: Mapping[str, CellMeaning] = {str(said): CellMeaning(CellKind.LABEL, said) for said in _LABELS}
_DIAMETER_OF: Mapping[Part, CellMeaning] = {part: CellMeaning(CellKind(part)) for part in ("spool", "sleeve")}


def aside(why: Sentence) -> CellMeaning:
    """Return that a cell was left aside, and why."""
    return CellMeaning(CellKind.ASIDE, why)


_OWN_WORDS: Collection[Role] = ("component", "plane", "land", "part")  # that a sheet may have for one
# what a cell of a key says: how it is read, and what is wrong where that fails
_KEYS: Mapping[str, tuple[Callable[[Cell], Any], Sentence, Sentence]] = {
    "part": (
        lambda cell: part_said(text_of(cell)),
        Sentence("unknown part"),
        Sentence("spool (or piston), or sleeve (or bore)"),
    ),
    "direction": (
        direction_of,
        Sentence("unknown measuring direction"),
        Sentence("an angle such as 0° or 90°, or x1-x2, y1-y2, I, II"),
    ),
    "repeat": (repeat_of, Sentence("not the number of a repeat"), Sentence("1, 2, 3 …")),
    "unit": (lambda cell: find_unit(text_of(cell), "length"), Sentence("unknown unit of length"), Sentence("")),
}


@dataclass
class SheetRows:
    """The diameters of a table as written, and what is wrong with it.

    ``cells`` says what those became that were read or left aside with a word, by row and column; ``of_row`` is what
    the rows that were read are of.
    """

    table: HeadedTable
    columns: Columns
    entries: list[DiameterCell] = field(default_factory=list)
    problems: list[ReadingsError] = field(default_factory=list)
    messages: list[Message] = field(default_factory=list)
    rows_without_reading: int = 0
    cells: dict[tuple[int, int], CellMeaning] = field(default_factory=dict)
    of_row: dict[int, list[PlaceKey]] = field(default_factory=dict)


def read_rows(
    table: HeadedTable,
    names: ControllerNames,
    given_unit: Unit | None,
    where: Mapping[str, str] | None = None,
    left_out: Collection[int] = (),
) -> SheetRows:
    """Read every diameter of a table but those of rows that are left out, and note everything that is wrong with it."""
    columns = find_columns(table, names)
    if columns.problems:
        return SheetRows(table, columns, problems=columns.problems)
    reader = _Reader(table, columns, names, given_unit)
    reader.read(where or {}, left_out)
    return reader.rows


class _Reader:
    def __init__(self, table: HeadedTable, columns: Columns, names: ControllerNames, given_unit: Unit | None) -> None:
        self.table, self.columns, self.names, self.given_unit = table, columns, names, given_unit
        self.sheet, self.rows = table.sheet, SheetRows(table, columns)
        self.exclusions = Exclusions(table, columns, names)
        self.blanks: dict[HeadedColumn, dict[int, None]] = defaultdict(dict)
        self.overridden: set[str] = set()
        self.asked: set[tuple[int, str, str]] = set()  # of words of the sheet's own, by column

    def read(self, where: Mapping[str, str], said: Collection[int]) -> None:
        others = Sentence("other rows were chosen")
        unwanted = dict.fromkeys(rows_left_out(self.table, where), others)
        unwanted |= dict.fromkeys(said, Sentence("said not to count"))
        dropped, breaks = self._read_all_rows(unwanted)
        self._read_means_alone()
        self._report_blanks()
        self._report_overridden()
        self._report_hidden_columns()
        rows, table, columns = self.rows, self.table, self.columns
        by_choice = [row for row in dropped if unwanted[row] is others]
        if by_choice:
            chosen = all_of(
                Sentence("{heading} is {value!r}", heading=heading, value=value) for heading, value in where.items()
            )
            template = Sentence("{rows} left aside: read were those where {chosen}")
            self._say_left_out(template.of(rows=rows_named(self.sheet, by_choice), chosen=chosen))
        if len(by_choice) < len(dropped):
            named = rows_named(self.sheet, [row for row in dropped if row not in by_choice])
            self._say_left_out(Sentence("{rows} left aside, as said", rows=named))
        rows.problems += broken_blocks(table, rows.entries, self.names)
        question = states_question(rows.entries, breaks, table, columns)
        rows.problems += [] if question is None else [question]
        rows.messages += self.exclusions.messages(rows.entries)
        rows.messages += mark_messages(table, rows.of_row, columns)
        rows.messages += repeat_messages(rows.entries, table, columns, self.names.controller)

    def _say_left_out(self, text: Sentence) -> None:
        self.rows.messages.append(Message("info", "rows_left_out", text, self.sheet.place()))

    def _read_all_rows(self, unwanted: Mapping[int, Sentence]) -> tuple[list[int], list[Break]]:
        left_out: list[int] = []
        breaks: list[Break] = []
        columns = self.columns
        values = [column.index for group in self.columns.groups for column in group.values()]
        faulty_rows = {row for row, _ in self.sheet.faults}
        for row in self.table.rows:
            if len(self.rows.problems) > FAULTS:
                break
            cells = self.sheet.rows[row]
            if all(is_blank(cell) for cell in cells) and row not in faulty_rows:
                continue
            holds = any(not is_blank(self.sheet.cell(row, index)) for index in values)
            why = unwanted.get(row) or (self.exclusions.takes(row) if holds else None)
            if why is not None:
                left_out += [row] if holds and row in unwanted else []
                self.rows.cells |= dict.fromkeys(((row, index) for index in range(len(cells))), aside(why))
            elif not self._read_row(row):
                if title := self._title(row):
                    breaks.append((row, title))
                else:
                    named = columns.component or columns.part or columns.plane or columns.land
                    empty = named is None or is_blank(self.sheet.filled(row, named.index))
                    self.rows.rows_without_reading += not empty
        return left_out, breaks

    def _read_row(self, row: int) -> bool:
        if self._says_nothing(row):
            return False
        values, rows = list(self._raw_values(row)), self.rows
        if values:
            self._report_overlong(row)
            rows.cells |= {(row, column.index): LABEL_OF[column.role] for column in self.columns.keys}
        for group, value in values:
            key = self._key(row, next(iter(group.values())))
            if key is not None and value is not None:
                column = (group.get("diameter") or next(iter(group.values()))).index
                rows.entries.append(DiameterCell(row, column, key, value))
                rows.of_row.setdefault(row, []).append(key)
                rows.cells |= dict.fromkeys(((row, column.index) for column in group.values()), _DIAMETER_OF[key.part])
        return bool(values) or row in self.exclusions.struck

    def _says_nothing(self, row: int) -> bool:
        """Return whether a row has no label, and no number where diameters stand: who measured, below a table."""
        labels = [self.sheet.filled(row, column.index) for column in self.columns.keys]
        values = [self.sheet.cell(row, column.index) for group in self.columns.groups for column in group.values()]
        return bool(labels) and all(map(is_blank, labels)) and not any(map(str.isdigit, "".join(map(str, values))))

    def _title(self, row: int) -> str:
        column = self.columns.component
        if column is None or self.names.component(self.sheet.filled(row, column.index)) is not None:
            return ""
        title = " ".join(text_of(cell) for cell in self.sheet.rows[row] if isinstance(cell, str) and cell.strip())
        return "" if is_page_title(title) else title[:80]

    def _read_means_alone(self) -> None:
        for row, what in self.exclusions.take_back_means(tuple(self.rows.entries)):
            self.rows.cells = {at: meaning for at, meaning in self.rows.cells.items() if at[0] != row}
            self._read_row(row)
            text = Sentence(
                "row {row} is said to be a {what}, and its single readings are not there: read as one reading",
                row=self.sheet.row_number(row),
                what=what,
            )
            self.rows.messages.append(Message("info", "summary_as_reading", text, self.sheet.place(row)))

    def _report_overlong(self, row: int) -> None:
        """Report a text row with more cells than headings: its decimal commas were taken for the ends of cells."""
        cells, width = self.sheet.rows[row], len(self.table.texts)
        if not any(self.table.texts):  # without headings their number does not tell
            width = len(cells) - any(
                str(self.sheet.cell(row, index)).isdigit() and str(self.sheet.cell(row, index + 1)).isdigit()
                for group in self.columns.groups
                for index in (column.index for column in group.values())
            )
        if self.sheet.is_text and any(not is_blank(cell) for cell in cells[width:]):
            problem = Sentence(
                "the row has {cells} cells under {headings} headings: a decimal comma in a file whose columns are "
                "separated by commas?",
                cells=len(cells),
                headings=width,
            )
            expected = Sentence("semicolons or tabs between the columns, or decimal points")
            self._refuse(problem, row, None, ", ".join(map(str, cells)), expected)

    def _raw_values(self, row: int) -> Iterator[tuple[dict[str, HeadedColumn], RawValue | None]]:
        """Yield each diameter of a row; None for one that is there and cannot be read (the problem is noted)."""
        for group in self.columns.groups:
            given = {name: column for name, column in group.items() if not is_blank(self.sheet.cell(row, column.index))}
            if any((row, column.index) in self.sheet.marks.struck for column in given.values()):
                self.exclusions.struck.append(row)
                struck = aside(Sentence("crossed out"))
                self.rows.cells |= dict.fromkeys(((row, column.index) for column in given.values()), struck)
            elif given:
                yield group, None if self._half_given(row, group, given) else self._raw_value(row, given)
            elif any([self._fault(row, column, group) for column in group.values()]):  # noqa: C419  all are reported
                yield group, None

    def _fault(self, row: int, column: HeadedColumn, group: dict[str, HeadedColumn]) -> bool:
        fault = self.sheet.faults.get((row, column.index))
        if fault is None:
            return False
        if fault.startswith("#"):
            self._refuse(Sentence("this cell's formula gives an error"), row, column, fault, A_DIAMETER)
            return True
        coordinates = [other.index for name, other in group.items() if name.startswith("coordinate")]
        if any(re.search(rf"\b{column_letter(index)}{row + 1}\b", fault.replace("$", "")) for index in coordinates):
            return False  # a formula over coordinates that are not filled in yet
        expected = Sentence("a diameter such as 9.939: open the workbook in a spreadsheet program and save it again")
        self._refuse(Sentence("this cell's formula has no stored result"), row, column, fault, expected)
        return True

    def _half_given(self, row: int, group: dict[str, HeadedColumn], given: dict[str, HeadedColumn]) -> bool:
        for which in () if "diameter" in given else (1, 2):
            name = f"coordinate {which}"
            if name not in given:
                problem = Sentence("coordinate {number} is missing beside the other one", number=which)
                column = group.get(name) or next(iter(given.values()))
                self._refuse(problem, row, column, None, Sentence("both coordinates, or the diameter"))
                return True
        return False

    def _raw_value(self, row: int, given: dict[str, HeadedColumn]) -> RawValue | None:
        numbers: dict[str, float] = {}
        units: dict[str, Unit | None] = {}
        for name, column in given.items():
            try:
                read = diameter if name == "diameter" else number
                numbers[name], written = read(self.sheet.cell(row, column.index))
            except ReadingsError as error:
                cell = text_of(self.sheet.cell(row, column.index))
                if several_in(cell) and not self.table.mapped:
                    each = Sentence("{expected}; where each of them is a reading, name the columns")
                    error.expected, error.role = each.of(expected=error.expected or A_DIAMETER), COLUMNS
                elif isinstance(error.value, float) and not self.table.mapped:
                    error.role = COLUMNS  # of deviations, perhaps
                elif not re.search(r"\d", cell):
                    stands = Sentence("{expected}; or, for no reading, {option}")
                    missing = Option("map", f'"missing={cell}"')
                    error.expected = stands.of(expected=error.expected or A_DIAMETER, option=missing)
                self.rows.problems.append(at(self.table.place(row, column), error))
                return None
            units[name] = written or self._unit(row, column)
        unit = next(iter(units.values()))
        if len(set(units.values())) > 1:  # diameter and coordinates each in its own unit
            numbers = {
                name: value * ((units[name] or MILLIMETRE).factor / MILLIMETRE.factor)
                for name, value in numbers.items()
            }
            unit = MILLIMETRE
        column = given.get("diameter") or given["coordinate 1"]
        coordinates = None
        if "coordinate 1" in numbers and "coordinate 2" in numbers:
            coordinates = (numbers["coordinate 1"], numbers["coordinate 2"])
            if coordinates[0] == coordinates[1]:
                problem = Sentence("both coordinates are equal: no diameter between them")
                self._refuse(problem, row, column, coordinates[0])
                return None
        return RawValue(numbers.get("diameter"), coordinates, unit, self.table.place(row, column))

    def _unit(self, row: int, column: HeadedColumn) -> Unit | None:
        """Return the unit of a cell that states none: the user's, the row's, the heading's, or that above the table."""
        if column.index in self.sheet.derived:
            return column.unit  # a sum of columns, made in this unit
        if self.given_unit is not None:
            if column.unit is not None and column.unit != self.given_unit:
                self.overridden.add(column.name)
            return self.given_unit
        of_row = self.columns.unit
        if of_row is None or is_blank(self.sheet.filled(row, of_row.index)):
            return column.unit or self.columns.sheet_unit
        unit: Unit | None = self._read_key(row, of_row, "unit")
        return unit

    def _key(self, row: int, value: HeadedColumn) -> PlaceKey | None:
        columns = self.columns
        component = self._component(row)
        part: Part | None = value.part or self.table.part
        if value.part is None and columns.part is not None:
            part = self._read_key(row, columns.part, "part")
        plane = self._plane(row, component, value)
        direction, complete = value.direction, True
        if columns.direction is not None:
            direction = self._read_key(row, columns.direction, "direction")
            complete = direction is not None
        repeat, explicit = value.repeat, False
        if columns.repeat is not None and repeat is None:
            # a mean that stands for its single readings has no number
            cell = self.sheet.filled(row, columns.repeat.index)
            explicit = repeat_of(cell) is not None or summary_of(cell, key=True) is None
            repeat = self._read_key(row, columns.repeat, "repeat") if explicit else None
            complete = complete and (repeat is not None or not explicit)
        if component is None or part is None or plane is None or not complete:
            return None
        others = (self.sheet.filled(row, index) for index in range(self.sheet.width) if index not in columns.read)
        unworn = any(isinstance(cell, str) and says_unworn(cell) for cell in others)
        return PlaceKey(component, part, plane, direction, repeat, explicit, unworn)

    def _read_key(self, row: int, column: HeadedColumn, name: str) -> Any:
        """Return what the cell of a key says; None where it is empty or not understood, which is a problem."""
        cell = self._required(row, column)
        if cell is None:
            return None
        read, problem, expected = _KEYS[name]
        value = read(cell)
        if value is None and name == "part":  # with words beside it that change nothing: "Spool diameter"
            label = read_label(cell, self.names) or {}
            value = label.get("part") if len(label) == 1 else None
        if value is None:
            error = ReadingsError(problem, value=text_of(cell), expected=expected)
            if name == "part":
                named = next((part for word in plain(text_of(cell)).split() if (part := part_of(word))), None)
                meant = named or part_said(nearest_name(plain(text_of(cell)), PART_SPELLINGS) or "")
                error.nearest = PART_WORDS[meant] if meant else None
            elif name == "unit":
                error = unknown(problem, text_of(cell), unit_names("length"), kind=ReadingsError)
            self._once(row, column, self._settled(cell, column, error))
        return value

    def _settled(self, cell: Cell, column: HeadedColumn, error: ReadingsError) -> ReadingsError:
        """Say how a column is named whose cells say several things at once, or what stands in it for one thing."""
        if len(label_apart(cell, self.names).keys() - {"unit"}) > 1 and not self.table.mapped:
            error.role = COLUMNS
        elif column.role in _OWN_WORDS and "=" not in text_of(cell):
            error.role = column.role
            of = "" if column.role == "part" else f"{column.role} "
            own = Option("name", text=f'--map "{of}…={text_of(cell)}"')
            settled = Sentence("{expected}; or say which one the sheet means: {option}")
            error.expected = settled.of(expected=error.expected or "", option=own)
        return error

    def _required(self, row: int, column: HeadedColumn) -> Cell | None:
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
            for column in self.columns.names:  # where a fault stands
                self._same_component(component, self.sheet.filled(row, column.index))
            return component
        except ReadingsError as problem:
            self._once(row, column, self._settled(cell, column, problem))
            return None

    def _same_component(self, component: str, cell: Cell) -> None:
        named = None if is_blank(cell) else self.names.component(cell)
        if named is not None and named != component:
            name = Name(self.names.controller.components[component])
            raise ReadingsError(
                Sentence(
                    "this is component {named}, in a row of component {component}", named=named, component=component
                ),
                value=text_of(cell),
                expected=Sentence("{component} or {name}", component=component, name=name),
            )

    def _plane(self, row: int, component: str | None, value: HeadedColumn) -> str | None:
        """Return the plane as the controller spells it: of the planes or lands that columns or the heading name."""
        lands = () if component is None else self.names.controller.lands_of(component)
        several = len(lands) > 1  # of a component with one land nothing need name it
        of_land, land_cell = self._named(row, value, value.land, self.columns.land, several)
        of_plane, plane_cell = self._named(row, value, value.plane, self.columns.plane, several and of_land is None)
        if component is None:
            return None  # reported already, and what of its place is missing too
        column = of_land or of_plane
        if column is None or (plane_cell if of_land is None else land_cell) is None:
            return lands[0].planes[0] if len(lands) == 1 else None
        try:
            land = None if of_land is None else self.names.land(component, land_cell)
            if land is not None and plane_cell is None:
                return land.planes[0]
            column = of_plane or column
            plane = self.names.plane(component, plane_cell)
            if land is None or plane in land.planes:
                return plane
            problem = Sentence(
                "this plane of component {component} is not on land {land}", component=component, land=land.land
            )
            raise ReadingsError(problem, value=plane, expected=Sentence("plane {names}", names=land.planes))
        except ReadingsError as error:
            cell = plane_cell if column is of_plane else land_cell
            self._once(row, column, error if cell is None else self._settled(cell, column, error))
            return None

    def _named(
        self, row: int, value: HeadedColumn, headed: str | None, column: HeadedColumn | None, needed: bool
    ) -> tuple[HeadedColumn | None, Cell | None]:
        """Return what a value's heading names, or else the cell of its row, and the column; None where it is empty."""
        if headed is not None:
            return value, headed
        if column is None:
            return None, None
        cell = self._required(row, column) if needed else self.sheet.filled(row, column.index)
        return column, None if is_blank(cell) else cell

    def _report_blanks(self) -> None:
        for column, rows in self.blanks.items():
            others = [self.sheet.row_number(row) for row in rows][1:]
            problem = Sentence("column {heading!r} is empty in a row that holds a reading", heading=column.name)
            if others:
                problem = Sentence(
                    "column {heading!r} is empty in a row that holds a reading and in {count} more: {rows}",
                    heading=column.name,
                    count=len(others),
                    rows=", ".join(map(str, others[:20])) + (" …" if len(others) > 20 else ""),
                )
            self._refuse(problem, next(iter(rows)), column, None, _IN_TEXT if self.sheet.is_text else _EVERY_ROW)

    def _report_overridden(self) -> None:
        if self.given_unit is not None and self.overridden:
            text = Sentence(
                "read in {unit} as told, although the heading says otherwise: {headings}",
                unit=self.given_unit.said,
                headings=tuple(sorted(self.overridden)),
            )
            self.rows.messages.append(Message("warning", "unit_told", text, self.table.heading_place()))

    def _report_hidden_columns(self) -> None:
        for column in self.columns.hidden:
            hidden = aside(Sentence("a hidden column"))
            self.rows.cells |= dict.fromkeys(((row, column.index) for row in self.table.rows), hidden)
        for columns, done in (
            (self.columns.hidden, Sentence("left aside, because a visible column holds the same part")),
            (self.columns.hidden_read, Sentence("read, because no visible column holds the same part")),
        ):
            if columns:
                text = counted(
                    len(columns),
                    "hidden column {names} {done}",
                    "hidden columns {names} {done}",
                    names=tuple(repr(column.name) for column in columns),
                    done=done,
                )
                self.rows.messages.append(Message("warning", "hidden_columns", text, self.table.heading_place()))

    def _refuse(
        self,
        problem: Sentence,
        row: int,
        column: HeadedColumn | None,
        value: object = None,
        expected: Sentence | None = None,
    ) -> None:
        place = self.sheet.place(row) if column is None else self.table.place(row, column)
        self.rows.problems.append(ReadingsError(problem, place=place, value=value, expected=expected))

    def _once(self, row: int, column: HeadedColumn, problem: ReadingsError) -> None:
        """Report a problem of a cell, of a sheet's own word once and not in every row."""
        place = self.table.place(row, column)
        word = (column.index, str(problem), problem.role)
        if place in {earlier.place for earlier in self.rows.problems[-8:]} or (problem.role and word in self.asked):
            return
        self.asked.add(word)
        self.rows.problems.append(at(place, problem))
