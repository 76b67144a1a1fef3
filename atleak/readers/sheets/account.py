"""No diameter is lost: every number of that size is read, left aside with a word, or the sheet is refused.

It looks at every cell of the visible sheets once more, whatever the headings were understood to say.
"""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, field, replace

from atleak.common.errors import Message, MessageLevel, Place, ReadingsError
from atleak.common.sentences import Option, Sentence, any_of, counted
from atleak.common.units import Unit, find_unit
from atleak.measurements.own_forms import MEASUREMENTS
from atleak.measurements.readings import CellKind, CellMeaning, SheetCells
from atleak.readers.cells.sheet import Sheet, sheet_cells
from atleak.readers.own_forms import said_by_form
from atleak.readers.sheets.column_headings import Role, unit_of_heading
from atleak.readers.sheets.controller_names import (
    INCH,
    MILLIMETRE,
    ROUNDED,
    ControllerNames,
    Sizes,
    is_coarse,
    is_whole,
    numbers_of,
)
from atleak.readers.sheets.rows import LABEL_OF, SheetRows, aside
from atleak.readers.sheets.table import HeadedTable, which_columns
from atleak.readers.sheets.words import Words, is_blank, letters, number_of, part_said, plain, text_of

_WHY: dict[Role, Sentence] = {
    "specification": Sentence("what the diameter should be or was, not what was measured"),
    "mean": Sentence("means of readings"),
    "raw": Sentence("raw readings beside corrected ones"),
    "remark": Sentence("remarks"),
    "quantity": Sentence("another quantity by its heading"),
    "gauge": Sentence("the diameter of a gauge or standard"),
}
_HEADING, _NEW, _HEAD, _LAND = map(CellMeaning, (CellKind.HEADING, CellKind.NEW, CellKind.HEAD, CellKind.LAND))
_OTHER_COLUMN = Sentence("a column that is not read")
_NOT_READ = aside(Sentence("not read, though of the size of a diameter"))
_SHOWN = 2


@dataclass
class Account:
    """What became of the cells of a file, by the sheet's name; `close` reports the rest, `sheets` shows all."""

    names: ControllerNames
    units: Sequence[str]  # of the diameters that were read
    problems: list[ReadingsError] = field(default_factory=list)
    messages: list[Message] = field(default_factory=list)
    _done: dict[str | None, dict[tuple[int, int], CellMeaning]] = field(default_factory=lambda: defaultdict(dict))
    _derived: dict[str | None, dict[int, int]] = field(default_factory=lambda: defaultdict(dict))
    _tables: dict[str | None, list[tuple[range, HeadedTable]]] = field(default_factory=lambda: defaultdict(list))

    def __post_init__(self) -> None:
        self._sizes = Sizes(self.names.controller)
        stated = [unit for name in self.units if (unit := find_unit(name, "length")) is not None]
        self._units = tuple(dict.fromkeys((*stated, MILLIMETRE, INCH)))

    def enter(self, rows: SheetRows) -> None:
        """Account for a table that was read, and judge its columns that were not."""
        table, sheet, columns = rows.table, rows.table.sheet, rows.columns
        done = self._enter(table, table.rows)
        done |= rows.cells
        for column in columns.keys:
            for row in table.rows:
                if not self._is_size(sheet, row, column.index):
                    done.setdefault((row, column.index), LABEL_OF[column.role])
        for (line, index), meaning in rows.cells.items():  # of a column made from another, which was read thereby
            done.setdefault((line, sheet.derived.get(index, index)), meaning)
        used = {column.index for column in (*columns.keys, *table.values, *table.of_lands)} | {*sheet.derived.values()}
        others = [index for index in range(sheet.width) if index not in used and not self._is_figure(rows, index)]
        self._slipped(rows)
        others = [index for index in others if not self._is_quantity(rows, index)]
        rivals = [index for index in others if self._is_rival(rows, index)]
        if table.mapped:  # a person said which one is the measurement
            for index in rivals:
                self._leave_column(table, index, self._sizes_in(rows, index), None)
        elif rivals:
            self.problems.append(_which(table, rivals))

    def enter_lands(self, table: HeadedTable) -> None:
        """Account for a table of what lands themselves have: its numbers and names, and its other quantities."""
        columns = [column.index for column in table.columns if not column.holds_size]
        done, other = self._enter(table, table.block), aside(_OTHER_COLUMN)
        for index in columns:
            meaning = LABEL_OF.get(table.role(index) or "", other)
            for row in table.block:
                done.setdefault((row, index), meaning)

    def leave_table(self, table: HeadedTable) -> None:
        """Leave aside a table that holds no readings of this valve body."""
        done = self._enter(table, table.block)
        of_sizes = {column.index for column in table.columns if column.holds_size}
        cells = [(row, column) for row in table.block for column in table.span]
        sizes = [at for at in cells if self._is_size(table.sheet, *at, headed=table, whole=at[1] in of_sizes)]
        for at in cells:
            done.setdefault(at, aside(table.left_aside or _OTHER_COLUMN))
        if sizes:
            text = Sentence("the table in {where} is left aside, {why}: {shown}")
            text = text.of(where=table.where, why=table.left_aside or "", shown=self._shown(table.sheet, sizes))
            self.messages.append(Message("info", "table_aside", text, table.sheet.place(max(table.first, 0))))

    def holds_sizes(self, table: HeadedTable) -> bool:
        """Return whether numbers of the size of a diameter stand where a table's headings say diameter."""
        return any(
            self._is_size(table.sheet, row, column.index, headed=table) for row in table.rows for column in table.values
        )

    def leave_sheet(self, sheet: Sheet) -> None:
        """Leave a whole sheet aside, because the user or its name says so."""
        cells = [(row, column) for row, cells in enumerate(sheet.rows) for column in range(len(cells))]
        sizes = [at for at in cells if self._is_size(sheet, *at)]
        self._done[sheet.name] |= dict.fromkeys(cells, aside(Sentence("a sheet that is not read")))
        if sizes:
            text = Sentence("sheet {name!r} is left aside: {shown}", name=sheet.name, shown=self._shown(sheet, sizes))
            self.messages.append(Message("info", "sheet_aside", text, Place(sheet.file, sheet.name)))

    def take(self, cells: Iterable[tuple[str | None, int, int]], *, of_lands: bool = False) -> None:
        """Account for cells that were read outside of the tables, each by sheet, row and column."""
        for name, row, column in cells:
            self._done[name][row, column] = _LAND if of_lands else _HEAD

    def close(self, sheets: Sequence[Sheet]) -> None:
        """Name every number of the size of a diameter that is neither read nor left aside."""
        for sheet in sheets:
            done = self._done[sheet.name]
            groups: dict[tuple[str, int], list[tuple[int, int]]] = defaultdict(list)
            block, before = 0, -2
            for row, cells in enumerate(sheet.rows):
                lost = [
                    column
                    for column, cell in enumerate(cells)
                    if cell != "" and (row, column) not in done and self._is_size(sheet, row, column)
                ]
                table = self._table_at(sheet, row, lost[0]) if lost else None
                if lost and table is None:
                    lost = [column for column in lost if not self._is_labelled(sheet, row, column)]
                    fine = not all(is_coarse(cells[column]) for column in lost)
                    if lost and self._looks_read(sheet, row, fine=fine):
                        self.problems.append(_without_headings(sheet, row, lost[0]))
                        continue
                    block = block if before == row - 1 else row
                    before = row
                for column in lost:
                    done[row, column] = _NOT_READ
                    groups[("rows", block) if table is None else ("column", column)].append((row, column))
            for (kind, index), cells_lost in groups.items():
                self.messages.append(self._lost(sheet, kind, index, cells_lost))
            for rows, table in self._tables[sheet.name]:
                for at, role in ((at, table.role(at)) for at in table.span):
                    meaning = aside(_WHY.get(role, _OTHER_COLUMN) if role else _OTHER_COLUMN)
                    for row in rows:
                        done.setdefault((row, at), meaning)

    def sheets(
        self, pages: Iterable[Sheet], problems: Iterable[ReadingsError], around: Collection[str | None]
    ) -> tuple[SheetCells, ...]:
        """Return sheets as they stand in the file, with what their cells became; those of problems are refused.

        A sheet of notes alone, of which nothing was made, is left out.
        """
        by_sheet: dict[str | None, list[ReadingsError]] = defaultdict(list)
        for problem in problems:
            by_sheet[problem.place.sheet].append(problem)
        made = []
        for page in pages:
            first = self._derived[page.name]
            became = sorted(self._done[page.name].items(), key=lambda item: item[0][1] in first)
            done = {(row, first.get(column, column)): meaning for (row, column), meaning in became}
            if page.name in around:
                done = {(column, row): meaning for (row, column), meaning in done.items()}
            cells = sheet_cells(page, done, by_sheet[page.name])
            made.append(replace(cells, turned=page.name in around))
        told = [cells for cells in made if any(one and one != _HEADING for row in cells.meanings for one in row)]
        return tuple(told or made)

    def _enter(self, table: HeadedTable, rows: range) -> dict[tuple[int, int], CellMeaning]:
        sheet = table.sheet
        self._derived[sheet.name] |= sheet.derived
        self._tables[sheet.name].append((rows, table))
        for row in range(max(table.first, 0), table.last + 1):
            for column in table.span:
                cell = sheet.cell(row, column)
                # under a turned table's headings stand notes as well
                if number_of(text_of(cell)) is None and not (sheet.turned and numbers_of(cell)):
                    self._done[sheet.name][row, column] = _HEADING
        return self._done[sheet.name]

    def _is_figure(self, rows: SheetRows, index: int) -> bool:
        """Return whether a column holds specifications, means or raw readings by its heading; it is left aside."""
        table, role = rows.table, rows.table.role(index)
        words = letters(unit_of_heading(table.heading(index))[0])
        # "gauge" alone may be what was read from one
        of_gauge = role == "gauge" and (len(words) > 1 or words.any("earlier"))
        if role not in ("specification", "mean", "raw") and not of_gauge:
            return False
        if role == "specification" and self._is_of_controller(rows, index):
            self._mark(table, index, _NEW)
        else:
            self._leave_column(table, index, self._sizes_in(rows, index), role)
        return True

    def _is_of_controller(self, rows: SheetRows, index: int) -> bool:
        """Return whether this is the form's own column of nominal diameters, unchanged since it was written."""
        heading = rows.table.heading(index)
        if "[" not in heading or said_by_form(MEASUREMENTS, heading) != "nominal":
            return False
        units, cell = self._units_of(rows.table, index), rows.table.sheet.filled
        return all(
            any(
                self._sizes.near_plane(value, units, keys[0].component, keys[0].plane, ROUNDED)
                for value in numbers_of(cell(row, index))
            )
            for row, keys in rows.of_row.items()
        )

    def _is_quantity(self, rows: SheetRows, index: int) -> bool:
        """Return whether a column holds another quantity; not one in mm that has the size of the diameters."""
        table, heading = rows.table, rows.table.heading(index)
        bracketed = re.search(r"\[[^\]\d]+\]", heading)  # "RH [%]", "Mass [g]"
        other = table.role(index) == "quantity" or (bracketed and unit_of_heading(heading)[1] is None)
        if not other or (_units(table, index) and self._is_diameter(rows, index)):
            return False
        self._leave_column(table, index, self._sizes_under(table, index), "quantity")
        return True

    def _sizes_in(self, rows: SheetRows, index: int) -> list[tuple[int, int]]:
        return sorted({*self._sizes_under(rows.table, index), *self._near(rows, index)})

    def _sizes_under(self, table: HeadedTable, index: int) -> list[tuple[int, int]]:
        return [(row, index) for row in table.rows if self._is_size(table.sheet, row, index, headed=table)]

    def _is_rival(self, rows: SheetRows, index: int) -> bool:
        """Return whether an unread column could be the measurement as well; remarks and counts could not."""
        if not self._is_diameter(rows, index):
            return False
        table, near = rows.table, self._near(rows, index)
        if table.role(index) == "remark":
            self._leave_column(table, index, self._sizes_in(rows, index), "remark")
            return False
        units = self._units_of(table, index)
        if units[0].factor >= MILLIMETRE.factor and all(is_coarse(table.sheet.cell(*at)) for at in near):
            self._leave_column(table, index, self._sizes_in(rows, index), None)
            return False
        return True

    def _is_diameter(self, rows: SheetRows, index: int) -> bool:
        """Return whether a column holds the diameters of its rows: in most cells, and not in one of many."""
        filled = sum(not is_blank(rows.table.sheet.cell(row, index)) for row in rows.of_row)
        near = len(self._near(rows, index))
        return 2 * near > filled and (near > 1 or 2 * near > len(rows.of_row))

    def _units_of(self, table: HeadedTable, index: int) -> tuple[Unit, ...]:
        return _units(table, index) or self._units

    def _near(self, rows: SheetRows, index: int) -> list[tuple[int, int]]:
        units = self._units_of(rows.table, index)
        return [
            (row, index)
            for row, keys in rows.of_row.items()
            if any(
                self._sizes.near_plane(value, units, component, plane)
                for value in numbers_of(rows.table.sheet.cell(row, index))
                for component, plane in {(key.component, key.plane) for key in keys}
            )
        ]

    def _leave_column(self, table: HeadedTable, index: int, sizes: list[tuple[int, int]], role: Role | None) -> None:
        sheet = table.sheet
        self._mark(table, index, _NEW if role == "specification" else aside(_WHY[role] if role else _OTHER_COLUMN))
        if sizes:
            text = Sentence(
                "column {name} is left aside{why}: {shown}",
                name=_name(table, index),
                why=Sentence(" ({why})", why=_WHY[role]) if role else "",
                shown=self._shown(sheet, sizes),
            )
            level: MessageLevel = "warning" if role in (None, "remark") else "info"
            self.messages.append(Message(level, "column_aside", text, table.heading_place(index)))

    def _mark(self, table: HeadedTable, index: int, meaning: CellMeaning) -> None:
        for row in table.rows:
            self._done[table.sheet.name].setdefault((row, index), meaning)

    def _slipped(self, rows: SheetRows) -> None:
        table, sheet = rows.table, rows.table.sheet
        # numbers of that size are usual in a column of another quantity: 18.2 °C, say
        quantities = (index for index in range(sheet.width) if table.role(index) == "quantity")
        usual = {index for index in quantities if any(self._is_size(sheet, row, index) for row in rows.of_row)}
        for row in table.rows:
            groups = ([sheet.cell(row, column.index) for column in of.values()] for of in rows.columns.groups)
            named = any(not is_blank(sheet.filled(row, key.index)) for key in rows.columns.keys)
            if not named or not any(all(map(is_blank, cells)) for cells in groups):
                continue
            for index, cell in enumerate(sheet.rows[row]):
                if index in usual or (row, index) in self._done[sheet.name]:
                    continue
                lone = not isinstance(cell, str) or number_of(cell) is not None
                if lone and self._is_size(sheet, row, index, headed=table):
                    self.problems.append(_slip(table, row, index))
                    self._done[sheet.name][row, index] = _NOT_READ

    def _table_at(self, sheet: Sheet, row: int, column: int) -> HeadedTable | None:
        tables = [table for rows, table in self._tables[sheet.name] if row in rows]
        return next((table for table in tables if column in table.span), next(iter(tables), None))

    def _is_size(
        self, sheet: Sheet, row: int, column: int, headed: HeadedTable | None = None, whole: bool = False
    ) -> bool:
        """Return whether a cell holds a number of the size of a diameter, in its heading's unit where that has one."""
        cell = sheet.cell(row, column)
        values = numbers_of(cell)
        if not values:
            return False
        headed = headed or self._table_at(sheet, row, column)
        units = self._units if headed is None else self._units_of(headed, column)
        if headed is not None and not whole and is_whole(cell):
            units = tuple(unit for unit in units if unit.factor < MILLIMETRE.factor)
        return any(self._sizes.near(value, units) for value in values)

    def _is_labelled(self, sheet: Sheet, row: int, column: int) -> bool:
        """Return whether a number outside of the tables is another quantity or a count, by the words before it."""
        before = (cell for cell in reversed(sheet.rows[row][:column]) if isinstance(cell, str) and cell)
        label = next((cell for cell in before if number_of(cell) is None), None)
        if label is None or self.names.is_named(label) or part_said(label):
            return False
        words = Words(plain(label).replace(":", " ").split())
        if words.any("diameter", "of_reading", "of_specification", "mean", "raw", "calibration", "gauge"):
            return False
        return words.any("of_quantity") or is_whole(sheet.cell(row, column))

    def _looks_read(self, sheet: Sheet, row: int, *, fine: bool) -> bool:
        done = self._done[sheet.name]
        cells = [cell for column, cell in enumerate(sheet.rows[row]) if (row, column) not in done]
        texts = [text_of(cell) for cell in cells if not is_blank(cell)]
        parts = (text for text in texts if part_said(text) is not None and (fine or len(text) > 1))  # "D" of a gear
        return any(map(self.names.is_named, texts)) or any(parts)

    def _lost(self, sheet: Sheet, kind: str, index: int, cells: list[tuple[int, int]]) -> Message:
        rows = sorted({sheet.row_number(row) for row, _ in cells})
        table = self._table_at(sheet, *cells[0]) if kind == "column" else None
        if table is not None:
            where = Sentence("column {name}", name=_name(table, index))
        elif len(rows) == 1:
            where = Sentence("row {number}", number=rows[0])
        else:
            where = Sentence("rows {first} to {last}", first=rows[0], last=rows[-1])
        text = Sentence(
            "{where}: not read, though of the size of a diameter: {shown}", where=where, shown=self._shown(sheet, cells)
        )
        prose = all(isinstance(sheet.cell(*at), str) and number_of(sheet.cell(*at)) is None for at in cells)
        return Message("info" if prose else "warning", "not_read", text, sheet.place(cells[0][0], cells[0][1]))

    def _shown(self, sheet: Sheet, cells: Sequence[tuple[int, int]]) -> Sentence:
        shown = tuple(
            Sentence("{cell} (row {row})", cell=text_of(sheet.cell(*at)), row=sheet.row_number(at[0]))
            for at in cells[:_SHOWN]
        )
        more = len(cells) - _SHOWN
        return Sentence(
            "{shown}{more}", shown=shown, more=Sentence(" and {count} more", count=more) if more > 0 else ""
        )


def _units(table: HeadedTable, index: int) -> tuple[Unit, ...]:
    """Return the unit that a heading states; "Micrometer" alone is the instrument."""
    rest, unit = unit_of_heading(table.heading(index))
    return () if unit is None or not rest.strip() else (unit,)


def _name(table: HeadedTable, index: int) -> Sentence:
    text = table.heading(index)
    if text:
        return Sentence("{heading!r}", heading=text)
    return Sentence("{column} (without a heading)", column=table.sheet.place(0, index).column)


def _slip(table: HeadedTable, row: int, index: int) -> ReadingsError:
    problem = Sentence(
        "this number has the size of a diameter and stands in a column that is not read, while the row's diameter is "
        "empty: slipped into the wrong column?"
    )
    headings = any_of(repr(column.name) for column in table.values)
    return ReadingsError(
        problem,
        place=table.sheet.place(row, index, table.heading(index)),
        value=table.sheet.cell(row, index),
        expected=Sentence("the diameter under {headings}", headings=headings),
    )


def _which(table: HeadedTable, rivals: Sequence[int]) -> ReadingsError:
    problem = counted(
        len(rivals),
        "column {names} holds numbers of the size of the diameters as {read} does: which is the measurement?",
        "columns {names} hold numbers of the size of the diameters as {read} does: which is the measurement?",
        names=tuple(_name(table, index) for index in rivals),
        read=tuple(repr(column.name) for column in table.values),
    )
    return which_columns(
        problem,
        table.heading_place(rivals[0]),
        expected=Sentence(
            "headings that say so: 'measured [mm]', or 'nominal', 'mean', 'remark' over what is not the measurement; "
            "'diameter 1', 'diameter 2' over repeats"
        ),
    )


def _without_headings(sheet: Sheet, row: int, column: int) -> ReadingsError:
    return ReadingsError(
        Sentence("this row looks like a reading, and stands under no headings"),
        place=sheet.place(row, column),
        value=sheet.cell(row, column),
        expected=Sentence(
            "the row in the table, in the same columns, or headings above it; or the columns by their letters, as in "
            "{option}",
            option=Option("map", "component=A"),
        ),
    )
