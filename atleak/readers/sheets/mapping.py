"""What a person says of a measuring sheet: which column is what, so that a sheet in any words and order can be read.

A mapping is written as pairs of a role and a column, as `atleak diagnose --map` takes them. It makes the same
`HeadedTable` as the headings do where they are understood; what it does not say they still may.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from atleak.catalogue.words import PART_WORDS
from atleak.common.errors import Message, ReadingsError, nearest_name, unknown
from atleak.common.sentences import Sentence
from atleak.measurements.readings import Readings, SheetCells
from atleak.measurements.road_test import QUANTITIES
from atleak.readers.cells.sheet import Cell, Sheet, column_letter, runs_of
from atleak.readers.remembered_columns import CONSTANT, RememberedColumns, recall_all, remember, signature
from atleak.readers.sheets.column_headings import (
    HeadedColumn,
    Role,
    is_explained,
    read_heading,
    spot_of_heading,
    tokens_of,
    unit_of_heading,
)
from atleak.readers.sheets.controller_names import ControllerNames, is_whole, numbers_of
from atleak.readers.sheets.table import (
    HeadedTable,
    best_header,
    each_reading,
    headings,
    read_together,
    split,
    with_sums,
)
from atleak.readers.sheets.words import direction_of, is_blank, number_of, part_said, plain, repeat_of, text_of

ROLES: Mapping[str, Role] = {
    **{role: role for role in ("component", "plane", "land", "part", "direction", "repeat")},
    "value": "diameter",
    "coordinate": "coordinate",
    "deviation": "diameter",
    "new": "specification",
}
ABOUT = ("header", "rows", "missing", "spool", "sleeve")  # the table as a whole, or words that stand in it
FORMAT = "measuring sheet"  # by which what is remembered of sheets is told from logs
_NAME = re.compile(r"([a-z]+)(?![^\W\d_])[\s:,._]*(.*)", re.DOTALL)
_WORDS = re.compile(r"[\w']+")
_LETTERS, _NUMBER = re.compile(r"[A-Z]{1,2}"), re.compile(r"(?:column\s*)?(\d{1,5})", re.IGNORECASE)
_LINES = re.compile(r"(\d+|[A-Z]{1,2})(?:\s*[-–]\s*(\d+|[A-Z]{1,2}))?")
_PLACES: tuple[Role, ...] = ("plane", "land")
_NAMED: tuple[Role, ...] = ("component", *_PLACES)  # of which a sheet may have words of its own
_KEPT_ROWS = 300  # among which headings are looked for
_DEPTH = 4  # rows that they may be spread over
_EXAMPLES = Sentence("a heading of the sheet; a letter such as C, or 'column 3'; or a value for all rows: =spool")


def is_role(name: str) -> bool:
    """Return whether a name is one of a sheet's, and not a quantity of a log.

    >>> is_role("value spool 0°"), is_role("header"), is_role("main_pressure")
    (True, True, False)
    """
    match = _NAME.fullmatch(name)
    return match is not None and (
        match[1] in ("value", "deviation", "coordinate", "rows", *_NAMED)
        or (match[1] == "new" and match[2] in PART_WORDS)
        or (not match[2] and match[1] in {*ROLES, *ABOUT})
    )


def require_known(names: Iterable[str]) -> None:
    """Refuse a name that is neither a role of a sheet nor a quantity of a log, with both listed."""
    for name in names:
        if not is_role(name) and name not in QUANTITIES:
            problem = Sentence("neither a role of a measuring sheet nor a quantity of a log")
            raise unknown(problem, name, [*ROLES, *ABOUT, *QUANTITIES])


class SheetMapping:
    """Which column of a sheet is what: by role the heading of its column, its letter or number.

    Behind ``=`` stands what holds for all rows; `NOT_LOGGED` says that no column holds it. ``value spool 0°`` says of
    what its diameters are; ``deviation`` is added to ``new``, each in its unit. ``header`` and ``rows`` count as the
    file's program does; ``rows`` may be several ranges, and of one sheet: ``rows Spools``. ``missing`` is what stands
    for no reading, several with ``|`` between; ``spool`` and ``sleeve`` are the sheet's words for them.
    """

    def __init__(self, chosen: Mapping[str, str]) -> None:
        require_known(chosen)
        self.chosen = {name: text.strip() for name, text in chosen.items()}
        self.header = next(iter(self._lines("header")), None)
        self.lines = {_words(name): self._lines(name) for name in self.chosen if _NAME.sub(r"\1", name) == "rows"}
        self._constants = {name: text[1:].strip() for name, text in self._roles if text.startswith(CONSTANT)}
        self._columns = {name: text for name, text in self._roles if text and not text.startswith(CONSTANT)}
        self._values = {name: self._value(name) for name in self._columns if _role(name) in ("diameter", "coordinate")}

    def __bool__(self) -> bool:
        """Tell whether it says of columns what they are: rows that count and words that stand for others do not."""
        return bool(self._columns or self._constants or self.header or "" in self.chosen.values())

    @property
    def _roles(self) -> Iterator[tuple[str, str]]:
        return ((name, text) for name, text in self.chosen.items() if names_column(name))

    def _lines(self, name: str) -> list[tuple[int, int]]:
        text = self.chosen.get(name, "")
        if not text or text == "none":
            return [(0, 0)] if text else []
        matches = [_LINES.fullmatch(part.strip()) for part in (text.split(",") if name != "header" else [text])]
        ranges = [(_line(match[1]), _line(match[2] or match[1])) if match else (0, 0) for match in matches]
        if not all(0 < first <= last for first, last in ranges):
            expected = Sentence(
                "rows as the sheet counts them, such as 3, 3-40 or 3-13,15-40; 'none' where no headings stand; a "
                "letter such as A where they run down a column"
            )
            raise _refused(Sentence("no rows of a sheet"), f"{name}={text}", expected)
        return ranges

    def leaves_out(self, sheet: Sheet) -> frozenset[int]:
        """Return the rows of a sheet that are said not to count."""
        rows = range(len(sheet.rows)) if self.lines else ()
        return frozenset(row for row in rows if not self.counts(sheet.name, sheet.row_number(row)))

    def counts(self, sheet: str | None, number: int) -> bool:
        """Tell whether a row of a sheet may count, by its number."""
        ranges = self.lines.get(_words(rows_role(sheet))) or self.lines.get("")
        return not ranges or any(first <= number <= last for first, last in ranges)

    @property
    def down(self) -> bool:
        """Return whether headings run down a column, which is named by its letter instead of a row."""
        return self.chosen.get("header", "")[:1].isupper()

    def _value(self, name: str) -> HeadedColumn:
        said = f"{_role(name)} {_words(name)}".strip()
        read = read_heading(said)
        if read is None or read.role != _role(name) or not is_explained(spot_of_heading(tokens_of(said))[1]):
            expected = Sentence("'value', or with part, plane, direction and repeat: 'value spool plane 1 0° repeat 2'")
            raise _refused(Sentence("not understood of which diameters this column is"), name, expected)
        return replace(read, tentative=False, besides=frozenset())

    def fits(self, sheet: Sheet) -> bool:
        """Return whether a sheet has the columns that are named."""
        return self._found(sheet) is not None

    def places(self, sheet: Sheet) -> dict[str, int]:
        """Return the column of each role."""
        found = self._found(sheet)
        return {} if found is None else found[2]

    def _found(self, sheet: Sheet) -> tuple[range, tuple[str, ...], dict[str, int]] | None:
        for rows in self._headers(sheet):
            texts = tuple(headings(sheet, rows[0], rows[-1])) if rows else ("",) * sheet.width
            places = {name: _place(text, texts, sheet) for name, text in self._columns.items()}
            if None not in places.values():
                return rows, texts, {name: at for name, at in places.items() if at is not None}
        return None

    def _headers(self, sheet: Sheet) -> Iterator[range]:
        if self.header is not None:
            first, last = self.header
            numbers = [row for row in range(len(sheet.rows)) if first <= sheet.row_number(row) <= last]
            yield range(numbers[0], numbers[-1] + 1) if numbers else range(0)
        elif all(_position(text) is not None for text in self._columns.values()):
            named = {plain(text) for text in self._columns.values()}
            for rows in _spans(sheet) if named else ():  # 1 and 2 may be headings
                cells = [cell for row in rows for cell in sheet.rows[row]]
                if named <= set(map(plain, headings(sheet, rows[0], rows[-1]))) and not any(_has_decimals(cells)):
                    yield rows
            yield self._above_numbers(sheet)
        yield from _spans(sheet) if self.header is None else ()

    def _above_numbers(self, sheet: Sheet) -> range:
        """Return the row above the first number of a diameter, if it holds text; else the headings that are likely."""
        columns = [at for name in self._values if (at := _position(self._columns[name])) is not None]
        first = min((first for ranges in self.lines.values() for first, _ in ranges), default=0)
        for row in range(len(sheet.rows)) if columns else ():
            cells = [sheet.cell(row, at) for at in columns]
            if sheet.row_number(row) >= first and any(number_of(text_of(cell)) for cell in cells if not is_blank(cell)):
                headed = row > 0 and any(isinstance(cell, str) and cell.strip() for cell in sheet.rows[row - 1])
                return range(row - 1, row) if headed else range(0)
        likely = None if columns else best_header(sheet)
        return range(0) if likely is None else range(likely.first, likely.last + 1)

    def not_found(self, sheets: Sequence[Sheet]) -> ReadingsError:
        """Return the error for a column that no sheet has."""
        likely = [found for sheet in sheets if (found := best_header(sheet)) is not None]
        widest = max((row for sheet in sheets for row in sheet.rows), key=lambda row: sum(map(bool, row)), default=[])
        texts = likely[0].texts if likely else tuple(text_of(cell) for cell in widest if isinstance(cell, str) and cell)
        lost = [text for text in self._columns.values() if _place(text, texts, sheets[0]) is None]
        heading = (lost or [*self._columns.values(), ""])[0]
        place = sheets[0].place(likely[0].last if likely else None)
        problem = Sentence("no column is headed {heading!r}", heading=heading)
        return ReadingsError(
            problem,
            place=place,
            value=", ".join(filter(None, texts)),
            expected=_EXAMPLES,
            nearest=nearest_name(heading, list(filter(None, texts))),
        )

    def table(self, sheet: Sheet, names: ControllerNames) -> HeadedTable:
        """Return the table with the columns as they are named; what is not named is as the headings say."""
        found = self._found(sheet)
        if found is None:
            raise self.not_found([sheet])
        rows, texts, at = found
        columns = self._all_columns(texts, at)
        first, last = (rows[0], rows[-1]) if rows else (-1, -1)
        view = self._as_said(sheet, columns, last + 1)
        table = HeadedTable(view, first, last, columns, texts, mapped=True)
        if (component := self._constants.get("component")) is not None:
            table = replace(table, component=names.require_component(component))
        for column in table.values:
            table = each_reading(table, column)
            said = read_heading(column.heading)
            if said is not None and said.role == "mean":
                text = Sentence("column {heading!r} holds means, by its heading: each counts as one reading")
                place, text = table.heading_place(column.index), text.of(heading=column.name)
                table = replace(table, messages=(*table.messages, Message("info", "means_as_readings", text, place)))
        for name in (name for name in self._values if name.startswith("deviation")):
            table = with_sums(table, at[name], at.get(f"new {self._values[name].part}", at.get("new")))
        for index in dict.fromkeys(at.values()):
            names_of = [name for name in at if at[name] == index]
            if len(names_of) > 1 and not self._values.keys().isdisjoint(names_of):
                problem = Sentence("one column is named for several: {names}", names=tuple(names_of))
                raise _refused(problem, column_letter(index), Sentence("a column of its own for each diameter"))
            if len(names_of) > 1:
                table = split(table, index, names)
                table = replace(table, sheet=self._as_said(table.sheet, table.columns, last + 1))
        return table

    def _all_columns(self, texts: Sequence[str], at: Mapping[str, int]) -> tuple[HeadedColumn, ...]:
        heading = dict(enumerate(texts))
        named = []
        for name, index in at.items():
            role_of = self._values.get(name) or HeadedColumn(0, "", _role(name), rank=9)
            text = heading.get(index, "")
            named.append(replace(role_of, index=index, heading=text, unit=unit_of_heading(text)[1]))
        values = [column for column in named if column.holds_value]
        read = [column for index, text in enumerate(texts) if (column := read_heading(text, index)) is not None]
        settled = self._settled(values)
        guessed = [
            column
            for column in read_together(read)
            if column.index not in at.values() and column.role not in settled and not (values and column.holds_value)
        ]
        said = self._said_of_all()
        values += [column for column in guessed if column.holds_value]
        others = [column for column in (*named, *guessed) if not column.holds_value]
        unsaid: dict[str, Any] = {role: None for role in at if role in ("part", "plane", "land", "direction", "repeat")}
        values = [replace(column, **{**unsaid, **said}) for column in values]
        return tuple(sorted((*others, *values), key=lambda column: column.index))

    def _settled(self, values: Iterable[HeadedColumn]) -> set[Role]:
        settled = {_role(name) for name, _ in self._roles} - {"specification"}
        for role in ("part", "plane", "land", "direction", "repeat"):
            settled |= {role} if any(getattr(column, role) is not None for column in values) else set()
        return settled | ({*_PLACES} if settled.intersection(_PLACES) else set())

    def _said_of_all(self) -> dict[str, Any]:
        read: dict[str, Callable[[str], Any]] = {
            "part": part_said,
            "direction": direction_of,
            "repeat": repeat_of,
            "plane": str,
            "land": str,
        }
        said: dict[str, Any] = {}
        for name, text in self._constants.items():
            if name == "component":
                continue
            said[name] = read[name](text) if name in read else None
            if said[name] is None:
                expected = Sentence("such as part==spool, direction==0° or repeat==1; 'value' and 'new' are columns")
                raise _refused(Sentence("not understood as {role}", role=name), text, expected)
        return said

    def named(self, role: str, text: str) -> str | None:
        """Return what a title, a line or a sheet's name says in the sheet's own words."""
        words = f" {' '.join(_WORDS.findall(plain(text)))} "
        own = self._own_words()[role].items() if self.chosen else ()
        found = {name for word, name in own if f" {' '.join(_WORDS.findall(word))} " in words}
        return found.pop() if len(found) == 1 else None

    def without_names(self, text: str) -> str:
        """Return a text without what is said to be the name of a component."""
        for word in self._own_words()["component"] if self.chosen else ():
            text = re.sub(re.escape(word), " ", text, flags=re.IGNORECASE)
        return text

    def _own_words(self) -> dict[str, dict[str, str]]:
        words: dict[str, dict[str, str]] = {"part": {}, "component": {}, "plane": {}}
        for name, text in self.chosen.items():
            if not text or not (name in PART_WORDS or _is_word(name)):
                continue
            role = "part" if name in PART_WORDS else "plane" if _role(name) in _PLACES else "component"
            for word in filter(None, map(plain, text.split("|"))):
                other = words[role].setdefault(word, _words(name) or name)
                if other != (_words(name) or name):
                    problem = Sentence("one word is said to be two things")
                    raise _refused(
                        problem, f"{name}={word}", Sentence("{word} as {other} alone", word=word, other=other)
                    )
        return {**words, "land": words["plane"]}

    def in_words(self, table: HeadedTable) -> HeadedTable:
        """Return a table found by its headings with our words for the sheet's own."""
        return replace(table, sheet=self._as_said(table.sheet, table.columns, table.last + 1)) if self.chosen else table

    def _as_said(self, sheet: Sheet, columns: Collection[HeadedColumn], below: int) -> Sheet:
        """Return the sheet without what stands for no reading, in our words; readings begin at row ``below``."""
        missing = {plain(text) for text in self.chosen.get("missing", "").split("|") if text.strip()}
        words = self._own_words()
        values = {column.index for column in columns if column.holds_value}
        of_column = {column.index: words.get(column.role) for column in columns}

        def said(index: int, cell: Cell) -> Cell:
            if index in values and missing and plain(text_of(cell)) in missing:
                return ""
            own = of_column.get(index)
            return own.get(plain(text_of(cell)), cell) if own else cell

        component = next((column.index for column in columns if column.role == "component"), None)
        for column in columns:
            if column.role in _NAMED and (own := of_column.get(column.index)):
                of = None if column.role == "component" else component
                _require_apart(sheet, range(below, len(sheet.rows)), column, own, of)
        rows = [[said(index, cell) for index, cell in enumerate(cells)] for cells in sheet.rows]
        faults = {at: why for at, why in sheet.faults.items() if not (at[1] in values and plain(why) in missing)}
        return replace(sheet, rows=rows, faults=faults)


NOTHING_SAID = SheetMapping({})


def _require_apart(
    sheet: Sheet, rows: range, column: HeadedColumn, own: Mapping[str, str], component: int | None
) -> None:
    """Refuse two words of one column for the same thing of a component: readings would be averaged as repeats."""
    found: dict[tuple[str, str], str] = {}
    for row in rows:
        word = text_of(sheet.cell(row, column.index))
        of = "" if component is None else plain(text_of(sheet.filled(row, component)))
        other = found.setdefault((of, own.get(plain(word), plain(word))), word) if word else word
        if plain(other) != plain(word):
            problem = Sentence("two words of one column are said to be the same")
            expected = Sentence("one word for each; this column has {other} too", other=other)
            raise ReadingsError(problem, place=sheet.place(row), value=word, expected=expected)


def rows_role(sheet: str | None) -> str:
    """Return the name under which is said which rows of a sheet count."""
    return f"rows {sheet or ''}".strip()


def rows_said(numbers: Iterable[int]) -> str:
    """Return the numbers of rows as they are said, in ranges."""
    return ",".join(f"{run[0]}" if len(run) == 1 else f"{run[0]}-{run[-1]}" for run in runs_of(numbers)) or "none"


def with_row_turned(chosen: Mapping[str, str], sheet: SheetCells, number: int) -> dict[str, str]:
    """Return what was said of a sheet, but that a row of it does not count, or that it counts again."""
    said, role = SheetMapping(chosen), rows_role(sheet.name)
    counted = [each for each in sheet.numbers if said.counts(sheet.name, each) != (each == number)]
    others = {name: text for name, text in chosen.items() if name != role}
    if len(counted) == len(sheet.numbers) and "rows" not in others:  # which would hold for this sheet too
        return others
    return {**others, role: rows_said(counted)}


def diameter_said(name: str) -> dict[str, str]:
    """Return of what the diameters of a role are, as far as it says.

    >>> diameter_said("value spool plane 2 90° repeat 1")
    {'part': 'spool', 'plane': '2', 'direction': '90°', 'repeat': '1'}
    """
    said = f"diameter {_words(name)}".strip()
    read = read_heading(said)
    if read is None or not is_explained(spot_of_heading(tokens_of(said))[1]):
        return {}
    direction = None if read.direction is None else f"{read.direction:g}°"
    found = {"part": read.part, "plane": read.plane or read.land, "direction": direction, "repeat": read.repeat}
    return {role: str(said) for role, said in found.items() if said is not None}


def diameter_role(said: Mapping[str, str], role: str = "value") -> str:
    """Return the role of diameters that are of this.

    >>> diameter_role({"part": "spool", "plane": "2", "direction": "90°", "repeat": "1"})
    'value spool plane 2 90° repeat 1'
    """
    words = {"part": "{}", "plane": "plane {}", "direction": "{}", "repeat": "repeat {}"}
    return " ".join([role, *(word.format(said[name]) for name, word in words.items() if said.get(name))])


def _role(name: str) -> Role:
    match = _NAME.fullmatch(name)
    assert match is not None
    return ROLES[match[1]]


def _words(name: str) -> str:
    match = _NAME.fullmatch(name)
    return match[2] if match else ""


def _refused(problem: Sentence, value: str, expected: Sentence) -> ReadingsError:
    return ReadingsError(problem, value=value, expected=expected)


def _place(text: str, texts: Sequence[str], sheet: Sheet) -> int | None:
    headed = [index for index, heading in enumerate(texts) if heading and plain(heading) == plain(text)]
    if len(headed) > 1:
        letters = ", ".join(column_letter(index) for index in headed)
        problem = Sentence("several columns are headed {heading!r} ({letters})", heading=text, letters=letters)
        raise _refused(problem, text, Sentence("one by its letter, or 'column {number}'", number=headed[0] + 1))
    position = _position(text)
    return headed[0] if headed else position if position is not None and position < sheet.width else None


def _position(text: str) -> int | None:
    """Return the column that a letter or number names."""
    if _LETTERS.fullmatch(text):
        return sum((ord(letter) - ord("A") + 1) * 26**at for at, letter in enumerate(reversed(text))) - 1
    match = _NUMBER.fullmatch(text)
    return int(match[1]) - 1 if match and int(match[1]) else None


def _has_decimals(cells: Iterable[Cell]) -> Iterator[bool]:
    return (bool(numbers_of(cell)) and not is_whole(cell) for cell in cells)


def _spans(sheet: Sheet) -> Iterator[range]:
    """Yield the rows that may be headings: every single one before any two, since a title may stand over them."""
    most = min(len(sheet.rows), _KEPT_ROWS)
    for depth in range(1, _DEPTH + 1):
        yield from (range(first, first + depth) for first in range(most - depth + 1))


def _line(text: str) -> int:
    """Return the number of a row, or of a column where rows and columns are exchanged."""
    position = _position(text)
    return 0 if position is None else position + 1


def fingerprint(texts: Iterable[str]) -> str:
    """Return the key under which a mapping is kept for sheets with these headings; "" where nothing stands in them."""
    texts = [text for text in texts if text]
    return signature([FORMAT, *texts]) if texts else ""


def remember_sheet(path: Path, readings: Readings, unit: str | None = None) -> None:
    """Keep the columns that a sheet was read with for sheets with the same headings; not the rows of this one file."""
    columns = {name: text for name, text in readings.columns if _NAME.sub(r"\1", name) not in ("header", "rows")}
    if not columns:
        return
    units = {"value": unit} if unit else {}
    remember(path, fingerprint(readings.headings), columns, units, format=FORMAT, columns=readings.headings)


def names_column(name: str) -> bool:
    """Tell whether a role is said with a column, and not with rows or a word of the sheet."""
    return _NAME.sub(r"\1", name) not in ABOUT and not _is_word(name)


def _is_word(name: str) -> bool:
    match = _NAME.fullmatch(name)
    return match is not None and match[1] in _NAMED and bool(match[2])


@dataclass(frozen=True)
class Earlier:
    """What was settled earlier for a sheet with such headings: its key, and the rows in which they stand here."""

    key: str
    entry: RememberedColumns
    header: str

    def with_chosen(self, chosen: Mapping[str, str]) -> dict[str, str]:
        """Return it with what is chosen now, which goes first."""
        roles = {name if _is_word(name) else _NAME.sub(r"\1", name) for name in chosen}
        kept = {name: text for name, text in self.entry.mapping.items() if is_role(name)}
        kept = {name: text for name, text in kept.items() if _is_word(name) or _NAME.sub(r"\1", name) not in roles}
        kept = {name: text for name, text in kept.items() if not text or text not in chosen.values()}
        return {"header": self.header, **kept, **chosen}


def recalled(path: Path, sheets: Iterable[Sheet]) -> Earlier | None:
    """Return what is remembered at a path for the first of the sheets that has such headings; None where nothing is."""
    kept = {key: entry for key, entry in recall_all(path).items() if entry.format == FORMAT}
    for sheet in sheets if kept else ():
        for rows in _spans(sheet):
            key = fingerprint(headings(sheet, rows[0], rows[-1]))
            if key in kept:
                return Earlier(key, kept[key], f"{sheet.row_number(rows[0])}-{sheet.row_number(rows[-1])}")
    return None
