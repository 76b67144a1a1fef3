"""A table of a sheet: its headings, its columns and rows, and what its title says of all.

`find_headers` finds the rows that hold headings; `read_together` says what each column is by all of them.
"""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import zip_longest
from typing import Any

from atleak.catalogue.instruments import Part
from atleak.common.errors import Message, Place, ReadingsError
from atleak.common.sentences import Option, Sentence
from atleak.readers.cells.sheet import Cell, Sheet
from atleak.readers.sheets.column_headings import (
    KEYS,
    OF_LANDS,
    SAYS_NOTHING,
    HeadedColumn,
    Role,
    both_ends,
    directions_in,
    is_explained,
    read_heading,
    spot_of_heading,
    tokens_of,
    unit_of_heading,
)
from atleak.readers.sheets.controller_names import (
    LABELLED,
    MILLIMETRE,
    UNITS,
    ControllerNames,
    Sizes,
    is_whole,
    label_apart,
    numbers_of,
    read_label,
)
from atleak.readers.sheets.words import (
    direction_of,
    is_blank,
    is_page_title,
    number_of,
    part_of,
    part_said,
    several_in,
    sheet_vocabulary,
    stated_number,
    text_of,
)


@dataclass(frozen=True)
class HeadedTable:
    """One table of a sheet, with headings in rows ``first`` to ``last`` from 0, of all columns in ``texts``.

    A table that goes on under another title, or on another sheet, has no headings of its own: ``last`` is then the row
    above its first one, -1 at the top of a sheet. ``sheet`` holds its cells at the places of the whole sheet, and
    nothing of the tables beside and below. ``part`` and ``component`` are what the title or the sheet's name says, with
    ``named_by`` naming it. ``left_aside`` is why a table holds no readings of this valve body, None where it may.
    ``filled`` are rows whose labels are those of a row
    above, and ``messages`` is what is to be said of both. ``mapped`` is whether a person named its columns.
    """

    sheet: Sheet
    first: int
    last: int
    columns: tuple[HeadedColumn, ...]
    texts: tuple[str, ...] = ()
    part: Part | None = None
    component: str | None = None
    named_by: Sentence | None = None
    left_aside: Sentence | None = None
    messages: tuple[Message, ...] = ()
    filled: frozenset[int] = frozenset()
    mapped: bool = False

    def heading(self, index: int) -> str:
        """Return a column's heading on one line; "" where it has none."""
        return " ".join(self.texts[index].split()) if index < len(self.texts) else ""

    def heading_place(self, index: int | None = None) -> Place:
        """Return the place of a column's heading, or of the row of headings."""
        return self.sheet.place(max(self.last, 0), index, "" if index is None else self.heading(index))

    def of(self, role: Role) -> tuple[HeadedColumn, ...]:
        """Return the columns of that role."""
        return tuple(column for column in self.columns if column.role == role)

    def role(self, index: int) -> Role | None:
        """Return the role of a column, None where its heading says nothing known."""
        return next((column.role for column in self.columns if column.index == index), None)

    @cached_property
    def values(self) -> tuple[HeadedColumn, ...]:
        """Return the columns of diameters and their coordinates."""
        return tuple(column for column in self.columns if column.holds_value)

    @cached_property
    def of_lands(self) -> tuple[HeadedColumn, ...]:
        """Return the columns of what a land itself has, or its component: contact length, position, fitted repair."""
        return tuple(column for column in self.columns if column.role in OF_LANDS)

    @property
    def labels(self) -> list[HeadedColumn]:
        """Return the columns that say of which component, part or place the rows are."""
        return [column for column in self.columns if column.role in ("component", "part", "plane", "land")]

    @property
    def roles(self) -> set[Role]:
        """Return what the headings name, of all that makes a reading."""
        return {column.role for column in self.columns}.difference(SAYS_NOTHING)

    @property
    def complete(self) -> bool:
        """Return whether the rows under the headings can be read at all."""
        return bool(self.of("component") and self.values)

    @property
    def score(self) -> float:
        """Return how much this looks like the headings of a measuring sheet."""
        named = self.roles
        distinct = {(column.role, column.coordinate, column.group) for column in self.values}
        return (
            2.0 * ("component" in named)
            + 2.0 * bool(distinct)
            + len(named & {"part", "plane", "land", "direction"})
            + 0.5 * ("repeat" in named)
            + 0.1 * min(len(distinct), 20)
            + 0.05 * any(column.unit for column in self.values)
            - 0.1 * (len(self.values) - len(distinct))
            - 0.01 * (self.last - self.first)
        )

    @property
    def has_part(self) -> bool:
        """Return whether a column says the part, or every heading of a value; also a "component" column of parts."""
        headed = bool(self.values) and all(column.part for column in self.values)
        return bool(self.of("part")) or headed or any(map(self.names_parts, self.of("component")))

    @property
    def is_of_lands(self) -> bool:
        """Return whether it holds no diameters, and what lands themselves have: lengths, repairs that are fitted."""
        return not self.values and bool(self.of_lands) and not self.left_aside

    @property
    def readable(self) -> bool:
        """Return whether readings can be read from the table at all."""
        has_component = self.of("component") or self.component is not None
        return bool(has_component and self.values and not self.left_aside)

    @cached_property
    def span(self) -> range:
        """Return the columns that the table spans."""
        wide = [index for index, text in enumerate(self.texts) if text]
        return range(min(wide), max(wide) + 1) if wide else range(self.sheet.width)

    @property
    def headed(self) -> tuple[str, ...]:
        """Return the headings as they stand in the file."""
        return tuple(text for index, text in enumerate(self.texts) if index not in self.sheet.derived)

    @property
    def rows(self) -> range:
        """Return the rows under the headings."""
        return range(self.last + 1, len(self.sheet.rows))

    def cells(self, index: int) -> dict[int, Cell]:
        """Return what stands in a column under its heading, by row; in each row of merged cells."""
        return {row: cell for row in self.rows if not is_blank(cell := self.sheet.filled(row, index))}

    def count_values(self) -> int:
        """Count the cells under the headings that hold something where a diameter belongs."""
        return sum(not is_blank(self.sheet.cell(row, column.index)) for row in self.rows for column in self.values)

    def names_parts(self, column: HeadedColumn) -> bool:
        """Return whether most cells of a column name a part, and nothing else."""
        cells = self.cells(column.index).values()
        return 2 * sum(part_said(text_of(cell)) is not None for cell in cells) > len(cells)

    def names_directions(self, column: HeadedColumn) -> bool:
        """Return whether all cells of a column say a direction, in words: a number may be another thing's."""
        texts = [text_of(cell) for cell in self.cells(column.index).values()]
        return bool(texts) and all(direction_of(text) is not None and number_of(text) is None for text in texts)

    def place(self, row: int, column: HeadedColumn) -> Place:
        """Return the place of a cell."""
        return self.sheet.place(row, column.index, column.name)

    @cached_property
    def block(self) -> range:
        """Return the rows under the headings up to the first empty one."""
        for row in self.rows[1:]:
            if all(is_blank(self.sheet.cell(row, column)) for column in self.span):
                return range(self.last + 1, row)
        return self.rows

    @cached_property
    def title(self) -> str:
        """Return the line of text above the headings, but no count of pages; "" where there is none."""
        above = (row for row in reversed(range(self.first)) if any(not is_blank(cell) for cell in self.sheet.rows[row]))
        line = next((line_of(self.sheet, row) for row in above), "")
        return "" if is_page_title(line) else line

    @cached_property
    def where(self) -> Sentence:
        """Return the rows from the headings to the last one, as a person counts them."""
        first = self.sheet.row_number(max(self.first, 0))
        rows = [row for row in self.block if not all(map(is_blank, self.sheet.rows[row]))]
        last = self.sheet.row_number(rows[-1]) if rows else first
        if self.sheet.name is None:
            return Sentence("rows {first} to {last}", first=first, last=last)
        return Sentence("sheet {name!r}, rows {first} to {last}", name=self.sheet.name, first=first, last=last)

    @property
    def as_it_stands(self) -> HeadedTable:
        """Return the table for what stands above its headings in the file, also where it was turned."""
        if not self.sheet.turned:
            return self
        first = min((column.index for column in self.columns if column.holds_size or column.role in KEYS), default=0)
        return replace(self, sheet=replace(self.sheet, turned=False), first=first)

    def with_columns(
        self,
        columns: Sequence[tuple[HeadedColumn, int]],
        cells: Callable[[int], Iterable[Cell]],
        instead_of: frozenset[int],
    ) -> HeadedTable:
        """Return the table with further columns behind its last one, ``instead_of`` some that are not read any more.

        Each of ``columns`` comes with the column of the file that it is made from, and gets its own index; ``cells``
        gives what stands in them in a row.
        """
        first = max(self.sheet.width, len(self.texts))
        added = [replace(column, index=first + at) for at, (column, _) in enumerate(columns)]
        sources = {column.index: source for column, (_, source) in zip(added, columns, strict=True)}
        rows = [[*row, *[""] * (first - len(row)), *cells(number)] for number, row in enumerate(self.sheet.rows)]
        texts = (*self.texts, *[""] * (first - len(self.texts)), *(column.heading for column in added))
        return replace(
            self,
            sheet=replace(self.sheet, rows=rows, derived={**self.sheet.derived, **sources}),
            columns=(*(column for column in self.columns if column.index not in instead_of), *added),
            texts=texts,
        )


EXPECTED_SHEET = Sentence(
    "one row of headings with at least: component (or 'No.'), part (spool or sleeve), plane (or land), and either "
    "diameter or coordinate x1 and coordinate x2; also read: direction, repeat, unit"
)

COLUMNS = "columns"  # role of a problem that is settled by saying which column is what

_DEPTH = 4  # rows that headings may be spread over


def which_columns(
    problem: Sentence, place: Place, value: object = None, expected: Sentence = EXPECTED_SHEET
) -> ReadingsError:
    """Return a problem that is settled by saying which column is what."""
    error = ReadingsError(problem, place=place, value=value, expected=expected)
    error.role = COLUMNS
    return error


def _starts_table(table: HeadedTable) -> bool:
    """Return whether this can only be headings: two sizes, or a size beside what it is of."""
    sizes = [column for column in table.columns if column.holds_size and _is_named_size(column)]
    others = [column for column in table.columns if column.role == "quantity" and column.unit is not None]
    keys = {column.role for column in table.columns}.intersection(KEYS)
    several = len(table.values) > 1 or any(not column.heading for column in table.of("part"))  # "0°" and "90°"
    return (len(sizes) or several) + bool(keys) > 1 or (bool(others or table.of_lands) and len(keys) > 1)


def _is_named_size(column: HeadedColumn) -> bool:
    """Return whether a word of its own says a size, not only "spool" or "0°", which stand in readings too."""
    words = tokens_of(column.heading)
    named = words.any("of_size", "of_reading") or both_ends(set(words)) or column.role == "coordinate"
    return not column.holds_value or named or column.unit is not None or bool(column.standing)


def best_header(sheet: Sheet) -> HeadedTable | None:
    """Return the row (or up to three rows) that looks most like headings, or None where none does."""
    rows = (row for row in range(len(sheet.rows)) if _may_hold_headings(sheet, row))
    headers = [header for row in rows for header in _headers_at(sheet, row) if header.score > 2.0]
    return max(headers, key=lambda header: round(header.score, 9), default=None)


def find_headers(sheet: Sheet, is_component: Callable[[str], bool]) -> list[HeadedTable]:
    """Return the headings of every table, from top to bottom. ``is_component`` knows the cells of readings."""
    likely = [header for first in range(len(sheet.rows)) for header in _likely_headers(sheet, first, is_component)]
    headers: list[HeadedTable] = []
    taken: set[int] = set()
    for header in sorted(likely, key=lambda header: (-round(header.score, 9), header.first)):
        rows = range(header.first, header.last + 1)
        if taken.isdisjoint(rows):
            headers.append(header)
            taken.update(rows)
    return list(_joined(sorted(headers, key=lambda header: header.first)))


def _joined(headers: Sequence[HeadedTable]) -> Iterator[HeadedTable]:
    """Yield the headings, as one with those right under them that are none by themselves."""
    done = -1
    for above, below in zip_longest(headers, headers[1:]):
        if above.first <= done:
            continue
        if below is not None and above.last + 1 == below.first and above.complete and not below.complete:
            above = header_of(above.sheet, above.first, below.last)
        done = above.last
        yield above


def _likely_headers(sheet: Sheet, first: int, is_component: Callable[[str], bool]) -> Iterator[HeadedTable]:
    if not _may_hold_headings(sheet, first) or _names_component(sheet, first, is_component):
        return
    decimals = _holds_decimals(sheet, first)
    texts = [cell for cell in sheet.rows[first] if isinstance(cell, str) and not _has_decimals(cell)]
    if decimals and sum(read_heading(text) is not None for text in texts) < 3:
        return
    for header in _headers_at(sheet, first):
        last = header.last
        if last > first and (decimals or _names_component(sheet, last, is_component) or _holds_decimals(sheet, last)):
            return
        sure = header.complete and len(header.roles) > 2
        if _starts_table(header) and (sure or not decimals):
            yield header


def _names_component(sheet: Sheet, row: int, is_component: Callable[[str], bool]) -> bool:
    return any(isinstance(cell, str) and cell and is_component(cell) for cell in sheet.rows[row])


def _holds_decimals(sheet: Sheet, row: int) -> bool:
    return any(
        _has_decimals(cell) if isinstance(cell, str) else isinstance(cell, float) and not cell.is_integer()
        for cell in sheet.rows[row]
    )


@lru_cache(maxsize=16384)
def _has_decimals(text: str) -> bool:
    return re.search(r"\d[.,]\d|^[.,]\d", text) is not None and number_of(text) is not None


def _may_hold_headings(sheet: Sheet, row: int) -> bool:
    """Return whether a row has two texts, or one over several columns; over the first column it is a title."""
    texts = [column for column, cell in enumerate(sheet.rows[row]) if isinstance(cell, str) and cell.strip()]
    if len(texts) != 1:
        return len(texts) > 1 and not is_single(sheet, row)
    return any(map(_is_place, sheet.rows[row][texts[0] : texts[0] + 1])) or (
        texts[0] > 0 and sheet.merged.get((row, texts[0] + 1)) == (row, texts[0])
    )


def _headers_at(sheet: Sheet, first: int) -> Iterator[HeadedTable]:
    for last in range(first, min(first + _DEPTH, len(sheet.rows))):
        if last > first and not any(not is_blank(cell) for cell in sheet.rows[last]):
            return
        header = header_of(sheet, first, last)
        if last > first and _is_data(header):
            return
        yield header


def header_of(sheet: Sheet, first: int, last: int) -> HeadedTable:
    """Return the table whose headings stand in these rows."""
    texts = headings(sheet, first, last)
    columns = [column for index, text in enumerate(texts) if (column := read_heading(text, index)) is not None]
    columns += [HeadedColumn(index, "", "part") for index in _beside_parts(sheet, last, texts, columns)]
    return HeadedTable(sheet, first, last, read_together(columns), tuple(texts))


def _beside_parts(sheet: Sheet, last: int, texts: Sequence[str], columns: Sequence[HeadedColumn]) -> Iterator[int]:
    """Yield the column that names parts under no heading, where the other headings say only a land or plane each."""
    headed = [bool(unit_of_heading(text)[0].strip()) for text in texts]
    places = [text for text, said in zip(texts, headed, strict=True) if said]
    if places and all(map(_is_place, places)) and all(column.holds_value for column in columns):
        words = {at: text_of(sheet.cell(last + 1, at)).split() for at in range(headed.index(True))[-1:]}
        yield from (at for at, said in words.items() if any(map(part_of, said)))


@lru_cache(maxsize=4096)
def _is_place(text: str) -> bool:
    spot, others = spot_of_heading(tokens_of(unit_of_heading(text)[0]))
    return not spot.keys().isdisjoint(("land", "plane")) and not others


def headings(sheet: Sheet, first: int, last: int) -> list[str]:
    """Return the text over every column: a heading over several columns counts for each of them, merged or not."""
    width = max(len(row) for row in sheet.rows[first : last + 1])
    levels = [[_said(sheet, row, column) for column in range(width)] for row in range(first, last + 1)]
    for depth, texts in enumerate(levels[:-1]):
        for column in range(1, width):
            if texts[column] or (first + depth, column) in sheet.merged:
                continue
            below = [level[column] for level in levels[depth + 1 :]]
            beside = [level[column - 1] for level in levels[depth + 1 :]]
            same_above = all(level[column] == level[column - 1] for level in levels[:depth])
            # below stand only a part, a place or a repeat, so that what they are of stands over them
            if any(below) and any(beside) and same_above and all(map(_is_under_another, filter(None, below))):
                texts[column] = texts[column - 1]
    return [" ".join(dict.fromkeys(text for text in texts if text)) for texts in zip(*levels, strict=True)]


def _said(sheet: Sheet, row: int, column: int) -> str:
    cell = sheet.filled(row, column)
    return str(cell).strip() if isinstance(cell, str) else text_of(cell)


@lru_cache(maxsize=4096)
def _is_under_another(text: str) -> bool:
    rest, _ = unit_of_heading(text)
    words = tokens_of(rest)
    of_another = words.any("mean", "sum", "mean_in_heading", "of_specification", "of_reading")
    return of_another or is_explained(spot_of_heading(words)[1])


def _is_data(header: HeadedTable) -> bool:
    cell = header.sheet.cell
    return any(
        not is_blank(cell(header.last, column.index))
        and any(not is_blank(cell(above, column.index)) for above in range(header.first, header.last))
        for column in header.of("component")
    )


def read_together(columns: Sequence[HeadedColumn]) -> tuple[HeadedColumn, ...]:
    """Correct what single headings say by what all of them say together, one correction after the other."""
    for corrected in (_without_bare_parts, _said_once, _counted_from_one):
        columns = corrected(columns)
    return tuple(columns)


def _without_bare_parts(columns: Sequence[HeadedColumn]) -> Sequence[HeadedColumn]:
    """Return "spool" and "sleeve" as diameters only where both stand there, and nothing else is one."""
    bare = [column for column in columns if column.role == "diameter" and part_of(column.heading) and not column.unit]
    others = any(column.role == "part" or (column.holds_value and column not in bare) for column in columns)
    if not others and len({column.part for column in bare}) > 1:
        return columns
    return [column for column in columns if column not in bare]


def _said_once(columns: Sequence[HeadedColumn]) -> Sequence[HeadedColumn]:
    """Return headings of values without the part, place or direction that a column of its own says."""
    angles = {column.direction for column in columns if column.holds_value} - {None}
    # "x1" and "x2" without "y1" and "y2" are only the names of two coordinates
    only_names = len(angles) == 1 and any(re.search(r"\b[xy][12]\b", column.heading.lower()) for column in columns)
    elsewhere = {column.role for column in columns}.intersection(("part", "land", "plane", "direction"))
    unsaid: dict[str, Any] = dict.fromkeys((*elsewhere, *(("direction",) if only_names else ())))
    return [replace(column, **unsaid) if column.holds_value else column for column in columns]


def _counted_from_one(columns: Sequence[HeadedColumn]) -> Sequence[HeadedColumn]:
    """Return values without repeats that do not count from 1, behind a word for them with one left out at most.

    12 and 24 are something else, and so are "measurement 1" and "measurement 2" beside a "result".
    """
    counted: dict[tuple[object, ...], set[int | None]] = defaultdict(set)
    for column in columns:
        if column.holds_value:
            counted[column.station].add(column.repeat)
    uncounted = {
        column.station
        for column in columns
        if column.repeat is not None
        and (
            column.repeat > len(counted[column.station]) + tokens_of(column.heading).any("of_repeat")
            or {None, 1} <= counted[column.station]
        )
    }
    return [replace(column, repeat=None) if column.station in uncounted else column for column in columns]


def is_single(sheet: Sheet, row: int) -> bool:
    """Return whether a row holds one text and nothing else: a title, or a line between the rows."""
    return line_of(sheet, row) != ""


def line_of(sheet: Sheet, row: int) -> str:
    """Return the text that stands alone in a row, or behind a label with a colon; "" where there is none."""
    cells = [cell for cell in sheet.rows[row] if not is_blank(cell)]
    *label, text = cells or [0]
    alone = isinstance(text, str) and number_of(text) is None and len(label) < 2
    return str(text) if alone and all(str(cell).rstrip().endswith(":") for cell in label) else ""


_FIRST = 300  # rows among which the first reading is looked for
_IN_UM = 1000.0  # a whole number from here on may be a diameter


def likely_table(sheet: Sheet, names: ControllerNames) -> HeadedTable:
    """Return the table that a sheet most likely holds: with the headings above the first row of a reading."""
    table, sizes = best_header(sheet), Sizes(names.controller)

    def measured(cells: Sequence[Cell]) -> bool:
        return any(
            sizes.near(value, UNITS) and (value >= _IN_UM or not is_whole(cell))
            for cell in cells
            for value in numbers_of(cell)
        )

    def named(cells: Sequence[Cell]) -> bool:
        return any(
            read_label(cell, names) or names.component(cell) in names.with_lands for cell in cells if not is_blank(cell)
        )

    rows = [row for row, cells in enumerate(sheet.rows[:_FIRST]) if measured(cells)]
    of_valve = (row for row in rows if named(sheet.rows[row]))
    row = next(of_valve, next((row for row in rows if row + 1 in rows), -1))
    if row < 0:
        return table or HeadedTable(sheet, -1, -1, (), ())
    sized = [at for at, cell in enumerate(sheet.rows[row]) if measured([cell])]
    while row and any(sizes.near(value, UNITS) for at in sized for value in numbers_of(sheet.cell(row - 1, at))):
        row -= 1  # of a valve by a name that nobody knows, or a round number
    above = [at for at in range(row) if _filled(sheet, at) and not is_single(sheet, at)][-2:]
    if table is not None and [table.last] == above[-1:]:
        return table
    headers = [header_of(sheet, first, above[-1]) for first in reversed(above) if first > above[-1] - len(above)]
    for header in headers:
        texts = [text for text in header.texts if text]
        sized = [at for at, cell in enumerate(sheet.rows[row]) if measured([cell])]
        numbered = any(number_of(text_of(cell)) for cells in sheet.rows[header.first : row] for cell in cells)
        told_apart = len(set(texts)) == len(texts) or header is headers[-1]
        if not numbered and told_apart and texts and all(map(header.heading, sized)):
            return header
    return HeadedTable(sheet, row - 1, row - 1, (), ("",) * sheet.width)


def _filled(sheet: Sheet, row: int) -> int:
    return sum(not is_blank(cell) for cell in sheet.rows[row])


# --- columns made from others

_DIGITS = 6  # of a sum in mm, that no digit of the sheet is lost in
_OF_NEW = Sentence("the column of nominal diameters, as in {option}", option=Option("map", "new=Nominal"))


def each_reading(table: HeadedTable, column: HeadedColumn) -> HeadedTable:
    """Return the table with a column of its own for each of the readings that stand in one cell.

    They are of the directions that the heading names, if those are as many in every cell; else repeats.
    """
    cells = {row: several_in(cell) or (cell,) for row, cell in table.cells(column.index).items()}
    most = max(map(len, cells.values()), default=1)
    if most == 1:
        return table
    angles = directions_in("diameter", tokens_of(unit_of_heading(column.heading)[0]))
    if len(angles) == most == min(map(len, cells.values())):
        text = Sentence("cells of column {heading!r} hold several readings: one of each direction")
        columns = [(replace(column, direction=angle), column.index) for angle in angles]
    elif not table.mapped:
        return table  # a person says whether they are repeats
    else:
        text = Sentence("cells of column {heading!r} hold several readings: each counts as a repeat")
        columns = [(replace(column, repeat=repeat), column.index) for repeat in range(1, most + 1)]
    made = table.with_columns(
        columns, lambda row: (*cells.get(row, ()), *[""] * most)[:most], frozenset({column.index})
    )
    message = Message("info", "several_in_a_cell", text.of(heading=column.name), table.heading_place(column.index))
    return replace(made, messages=(*made.messages, message))


def with_sums(table: HeadedTable, index: int, new: int | None) -> HeadedTable:
    """Return the table with diameters behind its last column: deviations, and what they are from."""
    column = next(column for column in table.values if column.index == index)
    nominal = next((column for column in table.of("specification") if column.index == new), None)
    place, cells = table.place(max(table.last, 0), column), table.sheet
    if nominal is None:
        raise ReadingsError(Sentence("nothing says what the deviations are from"), place=place, expected=_OF_NEW)
    if column.unit is None:
        problem = Sentence("nothing says in which unit the deviations are")
        raise ReadingsError(
            problem, place=place, expected=Sentence("the unit in the heading, such as 'Deviation [µm]'")
        )
    if any(token in sheet_vocabulary("below") for token in tokens_of(column.heading)):
        problem = Sentence("a heading that says 'below' leaves open which way its numbers count")
        expected = Sentence("deviations with their sign, those of smaller parts with −, under a heading 'Deviation'")
        raise ReadingsError(problem, place=place, value=column.heading, expected=expected)
    small, unit = column.unit, nominal.unit or MILLIMETRE

    def sums(row: int) -> Iterator[Cell]:
        off, size = cells.cell(row, index), cells.filled(row, nominal.index)
        apart, whole = (None, None) if is_blank(off) or row <= table.last else (stated_number(off), stated_number(size))
        if apart is None or whole is None:
            yield "" if is_blank(off) or row <= table.last else f"{size} {off}"
        else:
            total = (whole[1] or unit).to_si(whole[0]) + (apart[1] or small).to_si(apart[0])
            yield round(total / MILLIMETRE.factor, _DIGITS)

    text = Sentence(
        "diameters are those of column {nominal!r} plus the deviations of column {deviation!r}",
        nominal=nominal.name,
        deviation=column.name,
    )
    made = table.with_columns([(replace(column, unit=MILLIMETRE), index)], sums, frozenset({index}))
    return replace(made, messages=(*made.messages, Message("info", "diameters_of_deviations", text, place)))


def split(table: HeadedTable, index: int, names: ControllerNames) -> HeadedTable:
    """Return a table with further columns behind its last one, for each thing that the cells of a column say.

    A cell that is not understood stays as a whole in the first of the new columns, to be refused there.
    """
    filled = table.sheet.filled
    labels = {row: label_apart(cell, names) for row, cell in table.cells(index).items()}
    wanted = list(dict.fromkeys(name for label in labels.values() for name in label)) or ["component"]
    columns = [(HeadedColumn(0, table.heading(index), LABELLED[name], rank=9), index) for name in wanted]

    def cells(row: int) -> Iterator[Cell]:
        label = labels.get(row)
        for at, name in enumerate(wanted):
            yield label[name] if label and name in label else filled(row, index) if label == {} and at == 0 else ""

    return table.with_columns(columns, cells, frozenset({index}))
