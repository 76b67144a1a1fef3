"""What a person is asked of a sheet that cannot be read: the options that say which column is what.

They are guessed from headings, cells and sizes, the likeliest first, and tried on the file before they are printed.
"""

from __future__ import annotations

import re
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from itertools import chain, combinations, islice, product
from statistics import fmean, median
from string import ascii_lowercase

from atleak.common.errors import InputError, ReadingsError
from atleak.common.sentences import Option, Sentence
from atleak.measurements.clearances import NOMINAL_TOLERANCE
from atleak.measurements.readings import Readings
from atleak.readers.cells.sheet import Cell, Sheet, column_letter
from atleak.readers.sheets.column_headings import (
    HeadedColumn,
    besides_numbers,
    is_explained,
    tokens_of,
    unit_of_heading,
)
from atleak.readers.sheets.controller_names import (
    PLACES,
    UNITS,
    ControllerNames,
    Sizes,
    is_whole,
    label_apart,
    numbers_of,
    read_label,
)
from atleak.readers.sheets.layout import find_tables, mapped_tables, turned
from atleak.readers.sheets.mapping import ROLES, SheetMapping, diameter_role, diameter_said
from atleak.readers.sheets.repeats import APART
from atleak.readers.sheets.table import COLUMNS, HeadedTable, is_single, likely_table, line_of
from atleak.readers.sheets.valve_names import valves_by_name
from atleak.readers.sheets.words import is_blank, is_state, letters, number_of, part_in, part_said, plain, text_of

_LOOKED_AT = 60  # rows by which a column is told from another
_MOST_CELLS = 20_000  # of sheets on which suggestions are tried
_MOST_TRIED = 12  # offers
_LEFT = ("column_aside", "sheet_aside", "not_read")  # what is said where a diameter may have been left aside
_MOST_PARTS = 3  # words in a column that says spool or bore
_MOST_LANDS = 8  # of a valve
_OF_STATES = ("state", "person", "earlier", "whole_unit", "remark", "date")  # in a heading: no lands, no repeats
_WIDEST = 5e-3  # of a diameter: a tolerance
_FEWEST = 4  # rows of a column that tell what its numbers are
_ROUNDED = 6e-5  # of a diameter: how far a mean may be rounded
_AXES = {"x": "0°", "0": "0°", "y": "90°", "90": "90°"}
_ROMAN = re.compile(r"\bI{1,3}\b")
_NOT_MEASURED = ("specification", "remark", "gauge", "mean")


def column_name(table: HeadedTable, index: int) -> str:
    """Return how a mapping names a column: by its heading where no other one has it, or else by its letter."""
    heading = table.heading(index)
    unique = heading and sum(plain(text) == plain(heading) for text in table.texts) == 1
    return heading if unique else column_letter(table.sheet.derived.get(index, index))


def _number_in(word: str) -> int:
    """Return the one number in a word, or that of a single letter in its alphabet; 0 where it has neither."""
    numbers = re.findall(r"\d+", word)
    if len(numbers) == 1 and len(numbers[0]) == 1:
        return int(numbers[0])
    letter = word.strip(" .)").lower()
    first = max((each for each in "aαа" if each <= letter), default="") if len(letter) == 1 else ""
    return ord(letter) - ord(first) + 1 if first and not numbers else 0


def _counting(last: int) -> list[str]:
    return [str(number) for number in range(1, last + 1)]


@dataclass(frozen=True)
class Guess:
    """Which column of a table most likely is what."""

    table: HeadedTable
    names: ControllerNames

    @cached_property
    def _cells(self) -> dict[int, list[Cell]]:
        sheet = self.table.sheet
        lines = {row for row in self._rows if is_single(sheet, row)}
        found = {index: self.table.cells(index).items() for index in range(sheet.width)}
        return {
            index: [cell for row, cell in cells if row in self._rows and row not in lines][:_LOOKED_AT]
            for index, cells in found.items()
        }

    @cached_property
    def _rows(self) -> range:
        """Return the rows down to the last one that holds a diameter: below stand notes and names."""
        sizes, rows = Sizes(self.names.controller), self.table.rows
        for row in reversed(rows):
            cells = (cell for cell in self.table.sheet.rows[row] if not is_whole(cell))
            if any(sizes.near(value, UNITS) for cell in cells for value in numbers_of(cell)):
                return range(rows.start, row + 1)
        return rows

    @cached_property
    def labels(self) -> dict[str, int]:
        """Return by role the column that says it, by its heading or else by its cells."""
        table, names, cells = self.table, self.names, self._cells
        says: dict[str, Callable[[Cell], bool]] = {
            "component": lambda cell: names.component(cell) in names.with_lands and not is_state(cell),
            "part": lambda cell: part_said(text_of(cell)) is not None,
            "plane": lambda cell: names.is_plane(cell) or "land" in (read_label(cell, names) or {}),
            "direction": lambda _: False,
            "repeat": lambda _: False,
        }
        found: dict[str, int] = {}
        sure = {column.index for column in table.values if column.unit is not None}
        headed = {role: [column.index for column in table.of(ROLES[role])] for role in says}
        headed["plane"] += [column.index for column in table.of("land")]
        running = {index for index in cells if all(map(str.isdigit, map(text_of, cells[index])))}
        running -= {index for index in running if any(names.component(cell) for cell in cells[index])}
        headed["component"] = [index for index in headed["component"] if index not in running]
        for role, is_one in says.items():  # a heading whose cells say it, then any such cells
            shares = {index: sum(map(is_one, cells[index])) / max(len(cells[index]), 1) for index in cells}
            fits = [index for index in cells if shares[index] > 0.5 and index not in (*found.values(), *sure)]
            if role == "plane" and not {*found.values()}.issuperset(headed[role]):
                fits = [index for index in fits if index in headed[role]]  # bare numbers may count anything
            if role == "part":  # one word in all rows is a word before a diameter
                fits = [index for index in fits if index in headed[role] or len(set(map(text_of, cells[index]))) > 1]
            if fits:
                found[role] = max(fits, key=lambda index: (index in headed[role], shares[index]))
        for role, columns in headed.items():
            if columns and role not in found and columns[0] not in found.values():
                found[role] = columns[0]
        for index in cells:  # cells that say several things
            said = (label for cell in cells[index] if len(label := label_apart(cell, names)) > 1)
            meanings = Counter("plane" if name in ("land", "number") else name for label in said for name in label)
            most = {name for name, count in meanings.items() if 2 * count >= len(cells[index])} - {"unit"}
            found |= dict.fromkeys(sorted(most), index) if len(most) > 1 else {}
        words = {text_of(cell) for cell in cells.get(found.get("part", -1), ())}
        if len(words) > _MOST_PARTS and 2 * sum(part_in(word) is not None for word in words) < len(words):
            del found["part"]
        lines = any(is_single(table.sheet, row) for row in self._rows)  # which may say it
        if "component" not in found and not lines:
            others = cells.keys() - {*found.values(), *self._sized}
            texts = {index: [*map(text_of, cells[index])] for index in others}
            named = {at: of for at, of in texts.items() if not any(map(number_of, of))}
            kinds = {at: len(set(of)) for at, of in named.items() if 2 * sum(map(bool, map(part_in, of))) <= len(of)}
            if max(kinds.values(), default=0) > _MOST_PARTS:
                found["component"] = max(kinds, key=lambda index: (len(texts[index]), kinds[index], -index))
        if "plane" not in found and (counted := self._counted_lands(found)):
            found["plane"] = counted[0]
        if "part" not in found and (own := self._part_by_size([*found.values()])):
            found["part"] = own[0]
        return found

    def _valves(self, labels: Mapping[str, int], name: str = "") -> dict[int, str]:
        """Return by row the name of the valve that it is of, which may stand in the first of its rows or above them."""
        sheet, component, found = self.table.sheet, labels.get("component"), dict[int, str]()
        for row in sorted({*(() if name else range(max(self.table.first, 0))), *self.table.rows}):
            if component is not None:
                text = text_of(sheet.filled(row, component)) if row in self.table.rows else ""
                own = label_apart(text, self.names).get("component") if component == labels.get("plane") else None
                name = own or text or name
            elif is_single(sheet, row):
                name = text_of(line_of(sheet, row))
            found[row] = name
        return found

    def _counted_lands(self, labels: Mapping[str, int]) -> tuple[int, dict[str, str]] | None:
        """Return a column that counts the lands of each valve from 1 or A, in words of its own, and these with numbers.

        No column is one whose heading says a state, a person or anything else that is known.
        """
        valves, table = self._valves(labels), self.table
        others = self._cells.keys() - {*labels.values(), *self._sized}
        unknown = [at for at in others if table.role(at) is None and not letters(table.heading(at)).any(*_OF_STATES)]
        for index in [labels["plane"]] if "plane" in labels else sorted(unknown):
            of_valve, numbers = defaultdict[str, set[int]](set), dict[str, int]()
            for row, cell in table.cells(index).items():
                own = valves[row] and not is_single(table.sheet, row) and text_of(cell) != table.heading(index)
                if own and row in self._rows:
                    numbers[text_of(cell)] = _number_in(text_of(cell))
                    of_valve[valves[row]].add(numbers[text_of(cell)])
            whole = [set(range(1, len(of) + 1)) == of for of in of_valve.values()]
            counted = 2 * sum(whole) > len(whole) and {*numbers.values()} == set(range(1, len(numbers) + 1))
            told = len(set(numbers.values())) == len(numbers) and len(set(map(len, of_valve.values()))) > 1
            if counted and told and max(map(len, of_valve.values())) <= _MOST_LANDS:
                return index, {word: str(number) for word, number in numbers.items()}
        return None

    @cached_property
    def _lands(self) -> dict[str, str]:
        """Return the sheet's own words for lands, each with its number."""
        cells = self._cells[self.labels["plane"]] if "plane" in self.labels else ()
        known = all(self.names.is_plane(cell) or PLACES & label_apart(cell, self.names).keys() for cell in cells)
        counted = None if known else self._counted_lands(self.labels)
        return counted[1] if counted else {}

    @cached_property
    def _sized(self) -> dict[int, dict[int, float]]:
        """Return the numbers of each column that holds diameters by their size; whole ones only where µm are said."""
        sizes, found = Sizes(self.names.controller), {}
        for index, cells in self._cells.items():
            unit = unit_of_heading(self.table.heading(index))[1]
            fine = unit is not None and unit.factor < NOMINAL_TOLERANCE
            if sizes.fill([cell for cell in cells if fine or not is_whole(cell)]):
                numbers = {row: numbers_of(cell) for row, cell in self.table.cells(index).items()}
                found[index] = {row: of[0] for row, of in numbers.items() if of and sizes.near(of[0], UNITS)}
        return found

    @cached_property
    def _figures(self) -> frozenset[int]:
        """Return the columns of nominal sizes, and those of the smallest, the largest or the mean of those before."""
        sizes, readings, figures = Sizes(self.names.controller), list[int](), set[int]()
        for index, numbers in self._sized.items():
            of_new = all(map(sizes.is_nominal, numbers.values()))
            said = any(self._tells(index, readings[at:]) for at in range(len(readings) - 1))
            (figures.add if len(numbers) >= _FEWEST and (of_new or said) else readings.append)(index)
        pairs = product(readings, readings) if len(readings) > 2 else ()
        return frozenset({*figures, *(at for pair in pairs if self._are_limits(*pair) for at in pair)})

    def _are_limits(self, low: int, high: int) -> bool:
        """Return whether two columns are as far apart in every row as a tolerance is wide, of spools and of bores."""
        above = {row: value for row, value in self._sized[high].items() if row in self._sized[low]}
        widths = {round(value / self._sized[low][row] - 1.0, 4) for row, value in above.items()}
        apart = {round(value - self._sized[low][row], 6) for row, value in above.items()}
        return (
            min(widths, default=0.0) >= APART / 2 and max(widths) < _WIDEST and 1 < _FEWEST * len(apart) <= len(above)
        )

    def _tells(self, index: int, others: Sequence[int]) -> bool:
        rows = [(value, [self._sized[at].get(row) for at in others]) for row, value in self._sized[index].items()]
        beside = [(value, [other for other in of_row if other is not None]) for value, of_row in rows]
        return any(
            all(of_row and abs(of(of_row) - value) <= _ROUNDED * value for value, of_row in beside)
            for of in (min, max, fmean)
        )

    def _part_by_size(self, place: Sequence[int]) -> tuple[int, str, str] | None:
        """Return a column of words of which one is always at the smaller diameter: spools' words, then bores'."""
        for index in self._cells:
            words = {row: text_of(cell) for row, cell in self.table.cells(index).items() if row in self._rows}
            kinds = len(set(words.values()))
            if index in place or index in self._sized or len(place) < 2 or not 1 < kinds <= 2 * _MOST_PARTS:
                continue
            stations: dict[tuple[str, ...], dict[str, list[float]]] = defaultdict(lambda: defaultdict(list))
            sized = ((row, value) for of in self._sized.values() for row, value in of.items() if row in words)
            for row, value in sized:
                at = tuple(text_of(self.table.sheet.filled(row, label)) for label in place)
                stations[at][words[row]].append(value)
            pairs = [
                sorted((fmean(values), word) for word, values in of.items()) for of in stations.values() if len(of) == 2
            ]
            spools, sleeves = (dict.fromkeys(pair[at][1] for pair in pairs) for at in (0, 1))
            told = 2 * len(pairs) > len(stations) and spools.keys().isdisjoint(sleeves)
            if told and self._fit((spool, sleeve) for (spool, _), (sleeve, _) in pairs):
                return index, "|".join(spools), "|".join(sleeves)
        return None

    def _fit(self, pairs: Iterable[tuple[float, float]]) -> bool:
        """Return whether all pairs can be spool and bore: the second larger, by a clearance that they may have."""
        lands = self.names.controller.lands
        least = median(land.nominal_sleeve_diameter / land.nominal_diameter - 1.0 for land in lands) / 5.0
        most = 2.0 * NOMINAL_TOLERANCE / min(land.nominal_diameter for land in lands)
        some = False
        for spool, sleeve in pairs:  # up to the first that cannot be: of 200 columns most do not fit in one another
            some = bool(spool) and max(least, 1e-9) <= sleeve / spool - 1.0 <= most
            if not some:
                break
        return some

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
        headed = {column.index for column in self.headed}
        others = {*self._figures, *self.labels.values()}
        of_size = {index: self.table.role(index) for index in self._sized if index not in others}
        measured = sorted({*headed, *(index for index, role in of_size.items() if role not in _NOT_MEASURED)})
        means = [index for index in self._sized if self.table.role(index) == "mean"]
        return measured or [index for index in means if index not in self.labels.values()]

    @property
    def _coordinates(self) -> tuple[int, int] | None:
        """Return two columns whose numbers are a diameter apart in every row."""
        sizes, free = Sizes(self.names.controller), sorted(self._cells.keys() - {*self.labels.values()})
        for one, other in combinations(free, 2):
            apart = [abs(left - right) for left, right in self._beside(one, other)]
            if len(apart) >= _FEWEST and all(sizes.near(each, UNITS[:1]) for each in apart):
                return one, other
        return None

    @cached_property
    def _deviations(self) -> list[int]:
        found = []
        for index, cells in self._cells.items():
            numbers = [value for cell in cells for value in numbers_of(cell)]
            unit = unit_of_heading(self.table.heading(index))[1]
            small = unit is not None and numbers and max(map(abs, numbers)) <= NOMINAL_TOLERANCE / unit.factor
            if small and index not in self.labels.values() and not letters(self.table.heading(index)).any("clearance"):
                found.append((min(numbers) < 0.0, index))
        return [index for _, index in found] if any(below for below, _ in found) else []

    def _deviation(self, index: int) -> dict[str, str]:
        words = tokens_of(unit_of_heading(self.table.heading(index))[0])
        return diameter_said(f"deviation {' '.join(word for word in words if is_explained([word]))}")

    @property
    def roles(self) -> dict[str, int]:
        """Return the column of each role; of several diameters which is which, only a person may know."""
        values, first = self.diameters, next(self._sayings(), {})
        if any(role.startswith("new") for role in first) or (values and len(values) == len(first)):
            return self.labels | first
        roles, kind = dict(self.labels), "value" if values else "deviation"
        for number, index in enumerate(values or self._deviations, 1):
            part = next((f"{part} " for part, half in (self._halves or {}).items() if index in half), "")
            roles[f"{kind} {part}which {number}"] = index
        return roles

    @cached_property
    def _halves(self) -> dict[str, list[int]] | None:
        """Return the columns of spools and those of bores, where some of the diameters fit in the others."""
        every = self.diameters if "part" not in self.labels and len(self.diameters) > 1 else []
        splits = [(every[:place], every[place:]) for place in range(1, len(every))]
        for one, other in [
            *sorted(splits, key=lambda split: abs(len(split[0]) - len(split[1]))),
            (every[::2], every[1::2]),
        ]:
            for spools, sleeves in ((one, other), (other, one)):
                longer = zip(spools, sleeves, strict=True) if len(one) == len(other) else product(spools, sleeves)
                if every and self._fit(pair for at in longer for pair in self._beside(*at)):
                    return {"spool": spools, "sleeve": sleeves}
        return None

    def _sayings(self) -> Iterator[dict[str, int]]:
        """Yield what the columns of diameters may be, as far as headings and sizes tell, the likeliest first."""
        every, parts = self.diameters, {column.part for column in self.headed} - {None}
        means = all(self.table.role(index) == "mean" for index in every)
        told = [column for column in self.headed if column.index in every and (column.role == "diameter" or means)]
        headed = {_said(column): column.index for column in told}
        apart = len(headed) == len(told)
        headed = headed if apart and len(told) == len(self.headed) else {} if not (apart and parts) else headed
        unheaded = [index for index in every if not headed or self.table.role(index) != "diameter"]
        if not every and (ends := self._coordinates):
            yield {"coordinate 1": ends[0], "coordinate 2": ends[1]}
        deviations, new = self._deviations, self.table.of("specification")
        if deviations and new and set(every) <= {*deviations}:
            of_part = {f"new {part_in(column.heading)}": column.index for column in new}
            of_new = {"new": new[0].index} if len(new) == 1 else of_part
            said = [self._deviation(index) for index in deviations]
            named = any(part_in(self.table.heading(index)) for index in deviations)
            if len(said) == 2 and "part" not in self.labels and not named:
                in_order = sum(a - b for a, b in self._beside(*deviations)) < 0.0
                said = [{"part": part} for part in (("spool", "sleeve") if in_order else ("sleeve", "spool"))]
            roles = [diameter_role(each, "deviation") for each in said]
            if of_new.keys() in ({"new"}, {"new spool", "new sleeve"}) and len(set(roles)) == len(roles):
                yield of_new | dict(zip(roles, deviations, strict=True))
            return
        if deviations and not new and unheaded:
            return  # of sizes beside deviations only a person knows whether they are new ones or measured
        of_some = 0 < sum(column.part is not None for column in told) < len(told)
        if (len(headed) > 1 or (headed and not unheaded)) and not (of_some and "part" not in self.labels):
            yield headed
            if "plane" not in self.labels:
                yield {role.replace("repeat", "plane"): index for role, index in headed.items()}
        of_parts = [part for index in every if (part := part_in(self.table.heading(index)))]
        if len(every) == 2 and self._halves and len(set(of_parts)) == len(of_parts):
            yield {f"value {part}": half[0] for part, half in self._halves.items()}
        elif "part" in self.labels and self.headed and not headed:
            yield from ({"value": index} for index in reversed(every))
        elif len(every) == 1 and not headed:
            yield {"value": every[0]}
        yield from self._numbered(every if not parts or not apart else [])

    def _numbered(self, every: list[int]) -> Iterator[dict[str, int]]:
        """Yield columns whose headings differ in a number alone, as planes or repeats: of one part, or half of each."""
        place = "repeat" if "plane" in self.labels else "plane"
        if len(every) > 2 or (len(every) == 2 and "part" in self.labels):
            yield from self._counted({"value": every}, place)
        if len(every) > 2 and every == self.diameters and self._halves:
            yield from self._counted({f"value {part}": half for part, half in self._halves.items()}, place)

    def _directions(self, columns: Sequence[int]) -> Sequence[str]:
        """Return the directions of two columns whose headings differ in X and Y, or 0 and 90, and in nothing else."""
        texts = [re.findall(r"\d+|[^\W\d_]|\W", plain(self.table.heading(index))) for index in columns]
        apart = [pair for pair in zip(*texts, strict=False) if len(set(pair)) > 1]
        alike = len({len(text) for text in texts}) == 1 and len(apart) == 1
        said = [_AXES.get(text, "") for text in apart[0]] if alike else []
        return said if {*said} == {"0°", "90°"} else ()

    def _counted(self, groups: Mapping[str, list[int]], place: str) -> Iterator[dict[str, int]]:
        found: dict[str, int] = {}
        for role, columns in groups.items():
            if len(columns) == 1:
                found[role] = columns[0]
                continue
            if directions := self._directions(columns):
                found |= {f"{role} {said}": index for said, index in zip(directions, columns, strict=True)}
                continue
            headed = [self.table.heading(index) for index in columns]
            counting = _counting(len(columns))
            in_order = place == "plane" and list(map(plain, headed)) == [*ascii_lowercase[: len(columns)]]
            if in_order or (place == "repeat" and self._of_one_state(columns)):
                found |= {f"{role} {place} {number}": index for number, index in zip(counting, columns, strict=True)}
                continue
            if len(columns) > 2:  # of two, I and II may be directions, or before and after
                headed = [_ROMAN.sub(lambda found: str(len(found[0])), text) for text in headed]
            texts = [re.findall(r"\d+|\D+", text) for text in headed]
            numbers = ["".join(part for part in text if part.isdigit()) for text in texts]
            alike = {plain(" ".join(part for part in text if not part.isdigit())) for text in texts} or {""}
            counted = sorted(numbers) == counting if place == "repeat" else "" not in numbers
            if len(alike) > 1 or "" in alike or not counted:
                return
            besides = (besides_numbers(tokens_of(unit_of_heading(text)[0])) for text in headed)
            if place == "repeat" and any(besides):
                return  # "shift 1", "gearbox 1 spool": whether these are repeats, only a person knows
            found |= {f"{role} {place} {number}": index for number, index in zip(numbers, columns, strict=True)}
        if len(found) == sum(map(len, groups.values())):
            yield found

    def _of_one_state(self, columns: Sequence[int]) -> bool:
        """Return whether columns are repeats: alike in every row, under headings that differ in a number alone."""
        texts = [plain(re.sub(r"\d+", " ", self.table.heading(index))) for index in columns]
        rows = [[self._sized.get(index, {}).get(row) for index in columns] for row in self._rows]
        filled = [[size for size in of_row if size is not None] for of_row in rows if any(of_row)]
        alike = all(
            len(of_row) == len(columns) and max(of_row) - min(of_row) <= APART * max(of_row) for of_row in filled
        )
        return bool(filled) and alike and len(set(texts)) == 1 and not letters(texts[0]).any(*_OF_STATES)

    def _beside(self, left: int, right: int) -> Iterator[tuple[float, float]]:
        others = self.table.cells(right)
        for row, cell in self.table.cells(left).items():
            yield from zip(numbers_of(cell)[:1], numbers_of(others.get(row, ""))[:1], strict=False)

    @cached_property
    def words(self) -> dict[str, str]:
        """Return the sheet's own words, and those for no reading."""
        cells = {text_of(cell) for index in self.diameters for cell in self._cells[index]}.difference(self.table.texts)
        missing = [text for text in sorted(cells) if text.strip() and not any(map(str.isdigit, text))]
        return {**({"missing": "|".join(missing)} if 0 < len(missing) < _FEWEST else {}), **self.own}

    @cached_property
    def own(self) -> dict[str, str]:
        """Return the sheet's own words for parts, lands and valves, as far as numbers, sizes and words tell."""
        lands = {f"plane {number}": word for word, number in self._lands.items()}
        parts = self._part_by_size([index for role, index in self.labels.items() if role != "part"])
        if parts is not None and parts[0] == self.labels.get("part"):
            words = {"spool": parts[1], "sleeve": parts[2]}.items()
            lands |= {part: word for part, word in words if "|" not in word and part_said(word) is None}
        return lands | _own_valves(self.names, self.measured())

    def measured(self, name: str = "") -> dict[str, dict[str, list[float]]]:
        """Return the diameters under each name of a valve, by plane; ``name`` is that of the whole table."""
        plane, found = self.labels.get("plane"), dict[str, dict[str, list[float]]]()
        for row, valve in self._valves(self.labels, name).items():
            values = [numbers[row] for numbers in self._sized.values() if row in numbers]
            if valve and values:
                place = "" if plane is None else text_of(self.table.sheet.filled(row, plane))
                said = label_apart(place, self.names)  # "bore, land 2"
                place = self._lands.get(place) or said.get("plane") or said.get("land") or place
                found.setdefault(valve, {}).setdefault(place, []).extend(values)
        return found

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
            named = self._names(pages)
            own = {role: word for role, word in self.words.items() if not (named and role.startswith("component "))}
            mapping = {**header, **roles, **named, **own}
            yield mapping
            if "part" not in roles and not any("spool" in role for role in roles):
                yield from self._by_titles(mapping, pages)

    def _names(self, pages: Sequence[Sheet]) -> dict[str, str]:
        """Return the names of worksheets as words of the file for valves, where each holds one."""
        if "component" in self.labels or len(pages) < 2:
            return {}
        guesses = [(page.name or "", Guess(likely_table(page, self.names), self.names)) for page in pages]
        return _own_valves(
            self.names, {name: each for page, guess in guesses for name, each in guess.measured(page).items()}
        )

    def _by_titles(self, mapping: dict[str, str], pages: Sequence[Sheet]) -> Iterator[dict[str, str]]:
        """Yield the titles or names of two tables as words for the parts, that of the smaller ones for the spool."""
        said = SheetMapping(mapping)
        tables = [table for page in pages if said.fits(page) for table in mapped_tables(page, said, self.names)]
        if len(tables) == 2:
            names = [table.sheet.name or "" for table in tables]
            words = names if len(set(names)) > 1 else [unit_of_heading(table.title)[0].strip() for table in tables]
            cells = [[cell for at in table.values for cell in table.cells(at.index).values()] for table in tables]
            sums = [sum(numbers_of(cell)[0] for cell in of if numbers_of(cell)) for of in cells]
            spool, sleeve = (word for _, word in sorted(zip(sums, words, strict=True)))
            if all(words) and len(set(words)) > 1:
                yield {**mapping, "spool": spool, "sleeve": sleeve}


def _titled(sheets: Sequence[Sheet], names: ControllerNames) -> dict[str, str]:
    """Return the titles of tables that name no component we know as words for those, as far as sizes tell."""
    measured: dict[str, dict[str, list[float]]] = defaultdict(lambda: defaultdict(list))
    for table in (table for sheet in sheets for table in find_tables(sheet, names)):
        untold = table.title and not (table.of("component") or table.component or table.left_aside)
        for column in table.values if untold else ():
            cells = table.cells(column.index).values()
            measured[table.title][column.plane or column.land or ""] += [
                size for cell in cells for size in numbers_of(cell)
            ]
    return _own_valves(names, measured)


def _own_valves(names: ControllerNames, measured: Mapping[str, Mapping[str, Sequence[float]]]) -> dict[str, str]:
    return {f"component {valve}": name for name, valve in valves_by_name(names, measured).items()}


def _said(column: HeadedColumn) -> str:
    angle = "" if column.direction is None else f"{column.direction:g}°"
    said = {"part": column.part, "direction": angle, "repeat": column.repeat, "plane": column.plane}
    role = diameter_role({name: str(word) for name, word in said.items() if word})
    return f"{role} land {column.land}" if column.land else role


def offers(sheets: Sequence[Sheet], names: ControllerNames) -> Iterator[dict[str, str]]:
    """Yield what may be said of the columns of a file, the likeliest first: as its sheets stand, then turned."""
    if sum(sheet.width * len(sheet.rows) for sheet in sheets) > _MOST_CELLS:
        return
    for page in (turn for sheet in _fullest(sheets) for turn in (sheet, turned(sheet))):
        yield from () if page is None else Guess(likely_table(page, names), names).offers(sheets)


def _fullest(sheets: Sequence[Sheet]) -> list[Sheet]:
    return sorted(sheets, key=lambda sheet: -sum(not is_blank(cell) for cells in sheet.rows for cell in cells))


def options(said: Mapping[str, str], down: bool = False) -> Sentence:
    """Return what is said of a sheet as it is typed."""
    typed = " ".join([*(f"--map {_quoted(role, text)}" for role, text in said.items()), *["--fill-down"] * down])
    told = Sentence("which column is what: {options}", options=Option("map", text=typed))
    if not any(role in ("spool", "value spool") or role.startswith(("component ", "plane ")) for role in said):
        return told
    return Sentence("check which valve, land and part each word means, told by sizes and numbers; {told}", told=told)


def to_fill_in(sheet: Sheet, names: ControllerNames) -> Sentence:
    """Return the options that would settle which column is what, with COLUMN where only a person knows."""
    guess = Guess(likely_table(sheet, names), names)
    found = {role: column_name(guess.table, index) for role, index in guess.roles.items()} | guess.words
    needed = {"component", "plane", "part", "value"}
    needed -= {"part"} if any("spool" in role for role in found) else set()
    needed -= {"plane"} if any(" plane " in role for role in found) else set()
    needed -= {"value"} if any(role.startswith(("deviation", "coordinate", "value ")) for role in found) else set()
    return options(found | dict.fromkeys(sorted(needed - found.keys()), "COLUMN"))


def _quoted(role: str, column: str) -> str:
    return f"{role}={column}" if re.fullmatch(r"[\w.]+", role + column) else f'"{role}={column}"'


Read = Callable[[SheetMapping, bool], Readings]  # with what is said of the columns, and whether empty cells go on


def _tried(likely: Iterable[dict[str, str]], said: SheetMapping, read: Read) -> tuple[dict[str, str], bool] | None:
    """Return the first offer with which the file is read, and whether empty cells go on; rather one that leaves none.

    What is said already goes first.
    """
    second = None
    values = any(name.startswith(("value", "deviation")) for name in said.chosen)
    for offer in likely:
        kept = {role: text for role, text in offer.items() if not (values and role.startswith(("value", "deviation")))}
        mapping = {**kept, **said.chosen}
        for down in (False, True):
            with suppress(InputError):
                warned = {each.code for each in read(SheetMapping(mapping), down).messages if each.level == "warning"}
                if warned.isdisjoint(_LEFT):
                    return mapping, down
                second = second or (mapping, down)
    return second


def suggest(
    error: ReadingsError, sheets: Sequence[Sheet], names: ControllerNames, said: SheetMapping, read: Read
) -> None:
    """Say at the first problem that asks for columns how they are said, so that the file is read."""
    problems: Sequence[ReadingsError] = getattr(error, "problems", (error,))
    asking = next(
        (problem for problem in problems if problem.role in (COLUMNS, "component", "plane", "land", "part")), None
    )
    if asking is None:
        return
    named = [sheet for sheet in sheets if sheet.name == asking.place.sheet]
    pages = _fullest(named or sheets)
    page = next((page for page in pages if Guess(likely_table(page, names), names).diameters), pages[0])
    columns = any(problem.role == COLUMNS for problem in problems)
    turns = [] if columns else filter(None, (page, turned(page)))
    own = next(filter(None, (Guess(likely_table(turn, names), names).own for turn in turns)), {})
    if not columns and not own:
        return
    own = own or _titled(sheets, names)
    likely = islice(chain([own] if own else [], offers(sheets, names)), _MOST_TRIED)
    found = None
    with suppress(InputError):  # headings may say what no role is
        found = _tried(likely, said, read)
    if found is None:
        typed = options(own) if own else to_fill_in(page, names)
    else:
        error.offer = found[0]
        new = {role: text for role, text in found[0].items() if said.chosen.get(role) != text}
        typed = options(new, found[1])
    asking.expected = Sentence("{headings}; or {suggestion}", headings=asking.expected or "", suggestion=typed)
    error.expected = problems[0].expected
