"""What a person is asked of a sheet that cannot be read: the options that say which column is what.

They are guessed from headings, cells and sizes, the likeliest first, and tried on the file before they are printed.
"""

from __future__ import annotations

import re
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from atleak.common.errors import InputError, ReadingsError
from atleak.common.sentences import Option, Sentence
from atleak.measurements.clearances import NOMINAL_TOLERANCE
from atleak.measurements.readings import Readings
from atleak.readers.cells.sheet import Cell, Sheet, column_letter
from atleak.readers.sheets.column_headings import HeadedColumn, besides_numbers, tokens_of, unit_of_heading
from atleak.readers.sheets.controller_names import UNITS, ControllerNames, Sizes, is_whole, numbers_of, read_label
from atleak.readers.sheets.layout import is_single, mapped_tables, turned
from atleak.readers.sheets.mapping import ROLES, SheetMapping
from atleak.readers.sheets.table import COLUMNS, HeadedTable, best_header, header_of
from atleak.readers.sheets.words import is_blank, letters, number_of, part_of, part_said, plain, text_of

_LOOKED_AT = 60  # rows by which a column is told from another
_FIRST = 300  # rows among which the first reading is looked for
_MOST_CELLS = 20_000  # of sheets on which suggestions are tried
_MOST_TRIED = 12  # offers
_LEFT = ("column_aside", "not_read")  # what is said where a diameter may have been left aside
_NOT_MEASURED = ("specification", "remark", "gauge", "mean")


def likely_table(sheet: Sheet, names: ControllerNames) -> HeadedTable:
    """Return the table that a sheet most likely holds: with the headings above the first row of a reading."""
    table, sizes = best_header(sheet), Sizes(names.controller)
    for row, cells in enumerate(sheet.rows[:_FIRST]):
        named = any(read_label(cell, names) for cell in cells if not is_blank(cell))
        if named and any(
            sizes.near(value, UNITS) and not is_whole(cell) for cell in cells for value in numbers_of(cell)
        ):
            above = [at for at in range(row) if _filled(sheet, at) and not is_single(sheet, at)][-1:]
            if table is not None and [table.last] == above:
                return table
            headed = above and not any(number_of(text_of(cell)) for cell in sheet.rows[above[0]])
            headed = headed and _filled(sheet, above[0]) >= _filled(sheet, row) - 1
            without = HeadedTable(sheet, row - 1, row - 1, (), ("",) * sheet.width)
            return header_of(sheet, above[0], above[0]) if headed else without
    return table or HeadedTable(sheet, -1, -1, (), ())


def _filled(sheet: Sheet, row: int) -> int:
    return sum(not is_blank(cell) for cell in sheet.rows[row])


def column_name(table: HeadedTable, index: int) -> str:
    """Return how a mapping names a column: by its heading where no other one has it, or else by its letter."""
    heading = table.heading(index)
    unique = heading and sum(plain(text) == plain(heading) for text in table.texts) == 1
    return heading if unique else column_letter(table.sheet.derived.get(index, index))


@dataclass(frozen=True)
class Guess:
    """Which column of a table most likely is what."""

    table: HeadedTable
    names: ControllerNames

    @cached_property
    def _cells(self) -> dict[int, list[Cell]]:
        every = range(self.table.sheet.width)
        return {index: list(self.table.cells(index).values())[:_LOOKED_AT] for index in every}

    @cached_property
    def labels(self) -> dict[str, int]:
        """Return by role the column that says it, by its heading or else by its cells."""
        table, names, cells = self.table, self.names, self._cells
        says: dict[str, Callable[[Cell], bool]] = {
            "component": lambda cell: names.component(cell) in names.with_lands,
            "part": lambda cell: part_said(text_of(cell)) is not None,
            "plane": lambda cell: names.is_plane(cell) or "land" in (read_label(cell, names) or {}),
            "direction": lambda _: False,
            "repeat": lambda _: False,
        }
        found: dict[str, int] = {}
        headed = {role: [column.index for column in table.of(ROLES[role])] for role in says}
        headed["plane"] += [column.index for column in table.of("land")]
        for role, is_one in says.items():  # a heading whose cells say it, then any such cells
            shares = {index: sum(map(is_one, cells[index])) / max(len(cells[index]), 1) for index in cells}
            fits = [index for index in cells if shares[index] > 0.5 and index not in found.values()]
            if role == "part":  # one word in all rows is a word before a diameter
                fits = [index for index in fits if index in headed[role] or len(set(map(text_of, cells[index]))) > 1]
            if fits:
                found[role] = max(fits, key=lambda index: (index in headed[role], shares[index]))
        for role, columns in headed.items():
            if columns and role not in found and columns[0] not in found.values():
                found[role] = columns[0]
        for index in cells:  # cells that say several things
            meanings = Counter(
                "plane" if name == "land" else name
                for cell in cells[index]
                for name in read_label(cell, names, dotted=True) or {}
            )
            most = {name for name, count in meanings.items() if 2 * count > len(cells[index])} - {"unit"}
            found |= dict.fromkeys(sorted(most), index) if len(most) > 1 else {}
        return found

    @cached_property
    def headed(self) -> tuple[HeadedColumn, ...]:
        """Return the columns that are headed as diameters, and hold numbers."""
        columns = (column for column in self.table.values if column.index not in self.labels.values())
        return tuple(
            column for column in columns if any(map(str.isdigit, "".join(map(str, self._cells[column.index]))))
        )

    @cached_property
    def diameters(self) -> list[int]:
        """Return the columns of diameters: those headed so, and others whose cells are some."""
        sizes, headed = Sizes(self.names.controller), {column.index for column in self.headed}
        of_size = {
            index: self.table.role(index)
            for index, cells in self._cells.items()
            if index not in self.labels.values()
            and sizes.fill([cell for cell in cells if not is_whole(cell)])
            and any(map(numbers_of, cells))
        }
        measured = sorted({*headed, *(index for index, role in of_size.items() if role not in _NOT_MEASURED)})
        return measured or [index for index, role in of_size.items() if role == "mean"]

    @cached_property
    def _deviations(self) -> list[int]:
        found = []
        for index, cells in self._cells.items():
            numbers = [value for cell in cells for value in numbers_of(cell)]
            unit = unit_of_heading(self.table.heading(index))[1]
            small = unit is not None and numbers and max(map(abs, numbers)) <= NOMINAL_TOLERANCE / unit.factor
            if small and index not in self.labels.values():
                found.append((min(numbers) < 0.0, index))
        return [index for _, index in found] if any(below for below, _ in found) and len(found) < 3 else []

    @property
    def roles(self) -> dict[str, int]:
        """Return the column of each role; of several diameters which is which, only a person may know."""
        values, first = self.diameters, next(self._sayings(), {})
        if "new" in first or len(values) == len(first):
            return self.labels | first
        return self.labels | {f"value which {number}": index for number, index in enumerate(values, 1)}

    def _sayings(self) -> Iterator[dict[str, int]]:
        """Yield what the columns of diameters may be, as far as headings and sizes tell, the likeliest first."""
        headed = {_said(column): column.index for column in self.headed if column.role == "diameter"}
        every, parts = self.diameters, {column.part for column in self.headed} - {None}
        if len(headed) < len(self.headed) and not parts:
            headed = {}  # nothing tells them apart
        unheaded = [index for index in every if not headed or self.table.role(index) != "diameter"]
        deviations, new = self._deviations, self.table.of("specification")
        if deviations and new and set(every) <= {*deviations}:
            words = [letters(self.table.heading(index)) for index in deviations]
            headed_parts = [next(filter(None, map(part_of, headed_by)), None) for headed_by in words]
            if len(deviations) == 2 and (None in headed_parts or len(set(headed_parts)) == 2):
                in_order = headed_parts == ["spool", "sleeve"] or self._smaller(deviations[:1], deviations[1:])
                spool, sleeve = deviations if in_order else reversed(deviations)
                yield {"new": new[0].index, "deviation spool": spool, "deviation sleeve": sleeve}
            yield {"new": new[0].index, "deviation": deviations[0]}
            return
        if deviations and not new and unheaded:
            return  # of sizes beside deviations only a person knows whether they are new ones or measured
        if len(headed) > 1 or (headed and not unheaded):
            yield headed
        if len(every) == 2 and unheaded and "part" not in self.labels:
            spool, sleeve = every if self._smaller(every[:1], every[1:]) else reversed(every)
            if parts:
                known = headed.popitem()[1]
                spool, sleeve = (known, *unheaded) if "spool" in parts else (*unheaded, known)
            yield {"value spool": spool, "value sleeve": sleeve}
        elif "part" in self.labels and self.headed and not headed:
            yield from ({"value": index} for index in reversed(every))
        elif len(every) == 1 and not headed:
            yield {"value": every[0]}
        yield from self._numbered(every if not parts else [])

    def _numbered(self, every: list[int]) -> Iterator[dict[str, int]]:
        """Yield columns whose headings differ in a number alone, as planes or repeats: of one part, or half of each."""
        place = "repeat" if "plane" in self.labels else "plane"
        half = len(every) // 2
        if len(every) > 2 or (len(every) == 2 and "part" in self.labels):
            yield from self._counted({"value": every}, place)
        if len(every) > 2 and len(every) % 2 == 0 and "part" not in self.labels:
            for one, other in ((every[:half], every[half:]), (every[::2], every[1::2])):
                spools, sleeves = (one, other) if self._smaller(one, other) else (other, one)
                yield from self._counted({"value spool": spools, "value sleeve": sleeves}, place)

    def _counted(self, groups: Mapping[str, list[int]], place: str) -> Iterator[dict[str, int]]:
        found: dict[str, int] = {}
        for role, columns in groups.items():
            headed = [self.table.heading(index) for index in columns]
            texts = [re.findall(r"\d+|\D+", text) for text in headed]
            numbers = ["".join(part for part in text if part.isdigit()) for text in texts]
            alike = {plain(" ".join(part for part in text if not part.isdigit())) for text in texts} or {""}
            counted = [str(number + 1) for number in range(len(columns))]
            if len(alike) > 1 or "" in alike or (sorted(numbers) != counted if place == "repeat" else "" in numbers):
                return
            if place == "repeat" and any(besides_numbers(tokens_of(unit_of_heading(text)[0])) for text in headed):
                return  # "shift 1": whether these are repeats, only a person knows
            found |= {f"{role} {place} {number}": index for number, index in zip(numbers, columns, strict=True)}
        if len(found) == sum(map(len, groups.values())):
            yield found

    def _smaller(self, one: Sequence[int], other: Sequence[int]) -> bool:
        pairs = zip(one, other, strict=True)
        return sum(a - b for left, right in pairs for a, b in self._beside(left, right)) < 0.0

    def _beside(self, left: int, right: int) -> Iterator[tuple[float, float]]:
        others = self.table.cells(right)
        for row, cell in self.table.cells(left).items():
            yield from zip(numbers_of(cell)[:1], numbers_of(others.get(row, ""))[:1], strict=False)

    # --- the sheet's own words

    def _own_parts(self) -> Iterator[dict[str, str]]:
        """Yield a column with two words, the one always beside the smaller diameter: that of the spool."""
        place = [self.labels[role] for role in ("component", "plane") if role in self.labels]
        if len(self.diameters) != 1 or len(place) < 2:
            return
        sizes = self.table.cells(self.diameters[0])
        for index in self._cells:
            words = self.table.cells(index)
            if index in place or index == self.diameters[0] or len(set(map(text_of, words.values()))) != 2:
                continue
            stations: dict[tuple[str, ...], list[tuple[float, str]]] = defaultdict(list)
            for row, size in sizes.items():
                at = tuple(text_of(self.table.sheet.filled(row, label)) for label in place)
                stations[at] += [(value, text_of(words.get(row, ""))) for value in numbers_of(size)[:1]]
            pairs = {tuple(word for _, word in sorted(found)) for found in stations.values() if len(found) > 1}
            if len(pairs) == 1 and len(set(pair := pairs.pop())) == 2 == len(pair):
                column = column_name(self.table, index)
                yield {"part": column, "spool": pair[0], "sleeve": pair[1]}

    def _lines(self) -> dict[str, str]:
        """Return the lines between the rows that hold the number of a component, as words of the sheet for it."""
        named: dict[str, list[str]] = defaultdict(list)
        sheet = self.table.sheet
        for row in self.table.rows if "component" not in self.labels else ():
            if is_single(sheet, row):
                text = next(text_of(cell) for cell in sheet.rows[row] if not is_blank(cell))
                ids = [word for word in re.findall(r"\d+'?", text) if word in self.names.with_lands]
                if len(ids) == 1 and text not in named[f"component {ids[0]}"]:
                    named[f"component {ids[0]}"].append(text)
        return {role: "|".join(texts) for role, texts in named.items() if texts}

    def offers(self, pages: Sequence[Sheet]) -> Iterator[dict[str, str]]:
        """Yield what may be said of the sheet, in the order in which it is likely."""
        table = self.table
        header = {"header": column_letter(max(table.last, 0))} if table.sheet.turned else {}
        if not any(table.texts) and self.diameters:
            held = [row for row, cell in table.cells(self.diameters[0]).items() if numbers_of(cell)]
            first, last = (table.sheet.row_number(row) for row in (table.last + 1, max(held, default=0)))
            header = {"header": "none", "rows": f"{first}-{last}"}
        for said in self._sayings():
            roles = {role: column_name(self.table, index) for role, index in (self.labels | said).items()}
            mapping = {**header, **roles, **self._lines()}
            own = [{**mapping, **words} for words in self._own_parts()]
            yield from [mapping, *own] if "part" in roles else [*own, mapping]
            if "part" not in roles and not any("spool" in role for role in roles):
                yield from self._by_titles(mapping, pages)

    def _by_titles(self, mapping: dict[str, str], pages: Sequence[Sheet]) -> Iterator[dict[str, str]]:
        """Yield the titles or names of two tables as words for the parts, that of the smaller ones for the spool."""
        said = SheetMapping(mapping)
        tables = [table for page in pages if said.fits(page) for table in mapped_tables(page, said, self.names)]
        if len(tables) == 2:
            names = [table.sheet.name or "" for table in tables]
            words = names if len(set(names)) > 1 else [unit_of_heading(table.title)[0].strip() for table in tables]
            columns = [(table.cells(column.index).values() for column in table.values) for table in tables]
            sums = [sum(numbers_of(cell)[0] for cells in of for cell in cells if numbers_of(cell)) for of in columns]
            spool, sleeve = (word for _, word in sorted(zip(sums, words, strict=True)))
            if all(words) and len(set(words)) > 1:
                yield {**mapping, "spool": spool, "sleeve": sleeve}


def _said(column: HeadedColumn) -> str:
    place = f"land {column.land}" if column.land else f"plane {column.plane}" if column.plane else ""
    angle = "" if column.direction is None else f"{column.direction:g}°"
    repeat = f"repeat {column.repeat}" if column.repeat else ""
    return " ".join(filter(None, ("value", column.part, place, angle, repeat)))


def offers(sheets: Sequence[Sheet], names: ControllerNames) -> Iterator[dict[str, str]]:
    """Yield what may be said of the columns of a file, the likeliest first: as its sheets stand, then turned."""
    if sum(sheet.width * len(sheet.rows) for sheet in sheets) > _MOST_CELLS:
        return
    sheet = _fullest(sheets)
    for page in filter(None, (sheet, turned(sheet))):
        yield from Guess(likely_table(page, names), names).offers(sheets)


def _fullest(sheets: Sequence[Sheet]) -> Sheet:
    return max(sheets, key=lambda sheet: sum(not is_blank(cell) for cells in sheet.rows for cell in cells))


def options(said: Mapping[str, str], down: bool = False) -> Sentence:
    """Return what is said of a sheet as it is typed."""
    typed = " ".join([*(f"--map {_quoted(role, text)}" for role, text in said.items()), *["--fill-down"] * down])
    return Sentence("which column is what: {options}", options=Option("map", text=typed))


def to_fill_in(sheet: Sheet, names: ControllerNames) -> Sentence:
    """Return the options that would settle which column is what, with COLUMN where only a person knows."""
    guess = Guess(likely_table(sheet, names), names)
    found = {role: column_name(guess.table, index) for role, index in guess.roles.items()}
    needed = {"component", "plane", "part", "value"}
    needed -= {"part"} if any("spool" in role for role in found) else set()
    needed -= {"value"} if any(role.startswith(("deviation", "value ")) for role in found) else set()
    return options(found | dict.fromkeys(sorted(needed - found.keys()), "COLUMN"))


def _quoted(role: str, column: str) -> str:
    return f"{role}={column}" if re.fullmatch(r"[\w.]+", role + column) else f'"{role}={column}"'


Read = Callable[[SheetMapping, bool], Readings]  # with what is said of the columns, and whether empty cells go on


def tried(
    sheets: Sequence[Sheet], names: ControllerNames, said: SheetMapping, read: Read, downs: Sequence[bool] = (False,)
) -> tuple[dict[str, str], bool] | None:
    """Return the first offer with which the file is read, beside what is said of it; rather one that leaves none aside.

    ``downs`` are whether empty cells of a label may go on with the one above, to be tried one after the other.
    """
    second = None
    values = any(name.startswith(("value", "deviation")) for name in said.chosen)
    for _, offer in zip(range(_MOST_TRIED), offers(sheets, names), strict=False):
        kept = {role: text for role, text in offer.items() if not (values and role.startswith(("value", "deviation")))}
        for down in downs:
            mapping = {**kept, **said.chosen}
            try:
                messages = read(SheetMapping(mapping), down).messages
            except InputError:
                continue
            if not any(message.level == "warning" and message.code in _LEFT for message in messages):
                return mapping, down
            second = second or (mapping, down)
    return second


def suggest(
    error: ReadingsError, sheets: Sequence[Sheet], names: ControllerNames, said: SheetMapping, read: Read
) -> None:
    """Say at the first problem that asks for columns how they are said, so that the file is read."""
    problems: Sequence[ReadingsError] = getattr(error, "problems", (error,))
    asking = next((problem for problem in problems if problem.role == COLUMNS), None)
    if asking is None:
        return
    found = tried(sheets, names, said, read, (False, True))
    if found is None:
        named = [sheet for sheet in sheets if sheet.name == asking.place.sheet]
        typed = to_fill_in(_fullest(named or sheets), names)
    else:
        error.offer = found[0]
        new = {role: text for role, text in found[0].items() if said.chosen.get(role) != text}
        typed = options(new, found[1])
    asking.expected = Sentence("{headings}; or {suggestion}", headings=asking.expected or "", suggestion=typed)
    error.expected = problems[0].expected
