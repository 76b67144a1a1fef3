"""Find the tables of gauge readings on a sheet, and what their headings mean.

The words are those of ``vocabulary.toml``: ranges of the lever, what the engine does, taps.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal, cast

from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_tables import SelectorRange
from atleak.catalogue.written_numbers import decimal_number
from atleak.common.errors import Place
from atleak.common.translations import languages
from atleak.common.units import find_unit
from atleak.common.wording import wording
from atleak.measurements.gauge_readings import LINE_TAP, Engine
from atleak.measurements.own_forms import GAUGES, PRESSURES
from atleak.readers.cells.extent import MOST_TABLES
from atleak.readers.cells.sheet import BRACKETS, Cell, Sheet, text_of
from atleak.readers.dates import words
from atleak.readers.gauges.value_table import ValueTable, is_nothing, label_of, phrases, unit_in
from atleak.readers.own_forms import FormTable, form_tables

ColumnKind = Literal[
    "range", "engine", "tap", "temperature", "engine_speed", "repeat", "time", "gauge", "unit", "aside", "value"
]

_SPEED = re.compile(r"(\d[\d.,' ]*)\s*(?:rpm|1/min|min-1|r/min|u/min|obr\.?/min)", re.IGNORECASE)
_SEPARATORS = re.compile(r"[\s,;:_/|]+")
_UNIT_KINDS = ("pressure", "temperature", "rotational_speed")
_LOOKED_AT = 30  # rows below the headings in which a column without a heading may show what it is
_TITLES = 8  # rows above the headings that may speak of the table


@dataclass(frozen=True)
class Said:
    """What a text says of a cell of the table, None for what it does not say."""

    range: SelectorRange | None = None
    engine: Engine | None = None
    tap: str | None = None
    engine_speed: float | None = None  # [1/s]
    repeat: int | None = None

    @property
    def anything(self) -> bool:
        """Return whether it places a reading in range, engine or tap."""
        return (self.range, self.engine, self.tap) != (None, None, None)

    def over(self, other: Said) -> Said:
        """Return what this says, and what only the other one does."""
        return replace(other, **{name: value for name, value in vars(self).items() if value is not None})


@dataclass(frozen=True)
class _Heading:
    """What the heading of a column means; ``kind`` is None where it means nothing known."""

    text: str
    kind: ColumnKind | None = None
    said: Said = Said()
    unit: str = ""  # as it is written, and perhaps none

    @property
    def of_pressure(self) -> bool:
        """Return whether a unit or a word for pressure stands in it, if only a wrong one."""
        return bool(self.unit or not self.said.anything)


@dataclass(frozen=True)
class GaugeWords:
    """The words of a controller's tables: everybody's, and its circuits by id and name."""

    taps: Mapping[str, str] = field(default_factory=dict)
    tap_ids: tuple[str, ...] = (LINE_TAP,)
    _headings: dict[str, _Heading] = field(default_factory=dict, compare=False, repr=False)  # by text
    _sayings: dict[tuple[str, Sequence[str], bool], Said | None] = field(
        default_factory=dict, compare=False, repr=False
    )

    @classmethod
    def of(cls, controller: Controller) -> GaugeWords:
        """Return the words for a controller."""
        taps = dict.fromkeys(phrases("line"), LINE_TAP)
        for circuit in controller.circuits:
            named = (circuit.id, *(wording(language).name(circuit.name) for language in languages()))
            taps |= {words(name): circuit.id for name in named}
        return cls(taps, (LINE_TAP, *(circuit.id for circuit in controller.circuits)))

    def said_by(self, cell: Cell, kind: str) -> Said | None:
        """Return the range, the state of the engine or the tap that a cell names; None where it names none.

        >>> [GaugeWords().said_by(cell, "range").range for cell in ("Reverse", 3.0, "D range")]
        ['R', '3', 'D']
        >>> GaugeWords().said_by("fast idle, 1200 rpm", "engine").engine_speed
        20.0
        """
        said = self._said(text_of(cell), (kind,))
        return said if said is not None and getattr(said, kind) is not None else None

    def title(self, text: str) -> Said:
        """Return what a line above a table says of all its readings; nothing where it says something else too."""
        return self._said(BRACKETS.sub(" ", text), ("engine", "tap", "range"), heading=True) or Said()

    def heading(self, cell: Cell) -> _Heading:
        """Return what a heading means.

        >>> heading = GaugeWords({"line": "line"}).heading("Line, slow idle [kPa]")
        >>> heading.kind, heading.said.tap, heading.said.engine.value, heading.unit
        ('value', 'line', 'slow_idle', 'kPa')
        """
        text = text_of(cell)
        if _is_number(text):
            return _Heading(text)
        if text not in self._headings:
            self._headings[text] = self._heading(text)
        return self._headings[text]

    def _heading(self, text: str) -> _Heading:
        rest, unit, kind = _without_unit(text)
        rest_words = words(_SPEED.sub(" ", rest))
        whole = phrases("column").get(rest_words)
        if whole is not None:
            return _Heading(text, cast("ColumnKind", whole), unit=unit)
        if not rest_words and kind == "pressure":
            return _Heading(text, "value", unit=unit)
        said = self._said(rest, ("range", "engine", "tap"), heading=True)
        if said is not None and kind in (None, "pressure"):
            return _Heading(text, "value", said, unit)
        aside = any(phrases("column").get(word) == "aside" for word in rest_words.split())
        return _Heading(text, "aside" if aside else None, unit=unit)

    def _said(self, text: str, about: Sequence[str], *, heading: bool = False) -> Said | None:
        """Return what a text says about some of range, engine and tap; None where it says anything else, or twice.

        What two of them know is the first one's: a tap may be called "stall". In a heading the words for pressure may
        stand beside it, and a number behind them counts a repeat.
        """
        if _is_number(text):
            return None
        key = text, about, heading
        if key not in self._sayings:
            self._sayings[key] = self._read(text, about, heading)
        return self._sayings[key]

    def _read(self, text: str, about: Sequence[str], heading: bool) -> Said | None:
        speed = _SPEED.search(text)
        tables = {"range": phrases("ranges"), "engine": phrases("engine"), "tap": self.taps}
        meanings = {phrase: (name, value) for name in reversed(about) for phrase, value in tables[name].items()}
        meanings = {**dict.fromkeys(phrases("filler"), ("filler", "")), **meanings}
        if heading:
            meanings = {**dict.fromkeys(phrases("pressure"), ("pressure", "")), **meanings}
        said: dict[str, str] = {}
        before = ""
        for name, value in _read(words(_SPEED.sub(" ", text)).split(), meanings):
            if name == "range" and before == "pressure" and value.isdigit():
                name = "repeat"
            if name is None or said.get(name, value) != value:
                return None
            said[name] = value
            before = name
        if not {*about, "pressure"} & set(said) and not (heading and said):
            return None
        number = decimal_number(speed[1]) if speed else None
        return Said(
            range=cast("SelectorRange | None", said.get("range")),
            engine=Engine(said["engine"]) if "engine" in said else None,
            tap=said.get("tap"),
            engine_speed=None if number is None else number / 60.0,
            repeat=int(said["repeat"]) if "repeat" in said else None,
        )


def _is_number(text: str) -> bool:
    """Return whether a text is a number, as most cells are, and no digit that may name a range."""
    return len(text.strip()) > 1 and not any(map(str.isalpha, text))


def _read(said: Sequence[str], meanings: Mapping[str, tuple[str, str]]) -> Iterator[tuple[str | None, str]]:
    """Yield what the longest known phrases say, one after the other; (None, word) for a word that is none."""
    longest = 1 + max((phrase.count(" ") for phrase in meanings), default=0)
    at = 0
    while at < len(said):
        ends = range(min(at + longest, len(said)), at, -1)
        end = next((end for end in ends if " ".join(said[at:end]) in meanings), None)
        yield (None, said[at]) if end is None else meanings[" ".join(said[at:end])]
        at = end or at + 1


def _without_unit(text: str) -> tuple[str, str, str | None]:
    """Return a heading without its unit, the unit, or what else stands in square brackets, and its kind."""
    found = list(BRACKETS.finditer(text))
    inside = [(match, next((kind for kind in _UNIT_KINDS if find_unit(match[1], kind)), None)) for match in found]
    inside = [each for each in inside if each[1]] or [each for each in inside if each[0][0].startswith("[")]
    if inside:
        match, kind = inside[0]
        return f"{text[: match.start()]} {text[match.end() :]}", match[1], kind
    *parts, last = _SEPARATORS.split(text.strip())
    return (" ".join(parts), last, "pressure") if find_unit(last, "pressure") else (text, "", None)


_Stated = tuple[Cell, Place, str]  # beside a label: the value, where it stands, and the unit in the label


@dataclass(frozen=True)
class _Head:
    """What stands above the headings: what all readings have in common, their unit and the fluid's temperature."""

    said: Said = Said()
    unit: _Stated | None = None
    temperature: _Stated | None = None


@dataclass(frozen=True)
class GaugeTable(ValueTable):
    """One table; ``values`` says of every column of readings what its heading and the title do."""

    headings: Mapping[int, _Heading] = field(default_factory=dict)  # by column
    head: _Head = field(default_factory=_Head)

    @classmethod
    def of(cls, sheet: Sheet, row: int, last: int, headings: Mapping[int, _Heading], head: _Head) -> GaugeTable:
        """Return the table under some headings."""
        columns = {str(heading.kind): column for column, heading in reversed([*headings.items()]) if heading.kind}
        values = {at: heading.said.over(head.said) for at, heading in headings.items() if heading.kind == "value"}
        return cls(sheet, columns, values, row, last, headings, head)

    def unit_over(self, column: int) -> str:
        return self.headings[column].unit

    def unit_said(self, row: int, column: int) -> tuple[str, Place]:
        """Return the unit that is stated for a cell, and where: of a value also above the table."""
        said, unit = super().unit_said(row, column), self.head.unit
        return (str(unit[0]), unit[1]) if unit is not None and not said[0] and column in self.values else said


def find_gauge_tables(sheet: Sheet, words: GaugeWords) -> list[GaugeTable]:
    """Return the tables of gauge readings on a sheet: headings that give range, engine and pressure of each reading."""
    own = form_tables(sheet, PRESSURES, GAUGES)
    if own is not None:
        return [_of_form(table) for table in own]
    texts = {cell for row in sheet.rows for cell in row if isinstance(cell, str)}
    if not any((heading := words.heading(text)).said.engine or heading.kind == "engine" for text in texts):
        return []  # as on every sheet of diameters
    headers: list[tuple[int, Mapping[int, _Heading], _Head]] = []
    free = 0  # first row that may stand above the next headings
    for row in range(len(sheet.rows)):
        headings = _headings(sheet, row, words)
        if not any(heading.kind == "value" for heading in headings.values()):
            continue
        head = _head(sheet, range(max(free, row - _TITLES), row), words)
        complete = _complete(sheet, row, _with_row_above(sheet, row, free, headings, words), head, words)
        if len(headers) == MOST_TABLES:
            break
        if complete is not None:
            headers.append((row, complete, head))
            free = row + 1
    ends = [_before_titles(sheet, row) for row, _, _ in headers[1:]] + [len(sheet.rows) - 1]
    return [
        GaugeTable.of(sheet, row, end, headings, head)
        for (row, headings, head), end in zip(headers, ends, strict=False)
    ]


def _of_form(table: FormTable) -> GaugeTable:
    """Return the table of a form that atleak wrote, whose columns are known."""
    headings = dict[int, _Heading]()
    for key, at in table.columns.items():
        said = Said(engine=Engine(key)) if key in {*Engine} else Said()
        kind = "value" if said.engine else "aside" if key.startswith("permissible") else key
        heading = table.heading(key)
        headings[at] = _Heading(heading, cast("ColumnKind", kind), said, unit_in(heading))
    head = _Head(temperature=_labelled(table.sheet, range(table.row), "temperature"))
    return GaugeTable.of(table.sheet, table.row, len(table.sheet.rows) - 1, headings, head)


def likeness(sheet: Sheet, words: GaugeWords) -> float:
    """Return how much of a sheet's headings is understood as those of gauge readings; 0 where there are none."""
    tables = find_gauge_tables(sheet, words)
    return float(max((sum(each.kind is not None for each in table.headings.values()) for table in tables), default=0))


def _before_titles(sheet: Sheet, row: int) -> int:
    """Return the last row above some headings that is no title of theirs: titles fill one cell."""
    above = row - 1
    while above > 0 and 0 < sum(not is_nothing(cell) for cell in sheet.rows[above]) <= 1:
        above -= 1
    return above


def _headings(sheet: Sheet, row: int, words: GaugeWords) -> dict[int, _Heading]:
    cells = ((column, sheet.filled(row, column)) for column in range(sheet.width))
    return {
        column: words.heading(cell)
        for column, cell in cells
        if isinstance(cell, str | int | float) and str(cell).strip()
    }


def _with_row_above(
    sheet: Sheet, row: int, free: int, headings: dict[int, _Heading], words: GaugeWords
) -> dict[int, _Heading]:
    """Return the headings with what stands over them in the row above, as in "stall" merged over P, R, N, D."""
    above = _headings(sheet, row - 1, words) if row > free else {}
    uppers = {column: upper for column, upper in above.items() if upper.kind == "value" and len(above) > 1}  # no title
    joined = dict(headings)
    for column, heading in headings.items():
        if heading.kind == "value" and (upper := uppers.get(column)):
            joined[column] = replace(heading, said=heading.said.over(upper.said), unit=heading.unit or upper.unit)
    return joined


def _complete(
    sheet: Sheet, row: int, headings: dict[int, _Heading], head: _Head, words: GaugeWords
) -> dict[int, _Heading] | None:
    """Return the headings where every reading gets a range and a state of the engine; None where one does not.

    A column without a heading that is understood may be the one that says it. Where neither a unit nor a word for
    pressure stands over the readings, their headings must be more than numbers, and the columns that say range and
    engine must hold such words: in a list of valves, one named "throttle" heads nothing.
    """
    values = [heading for heading in headings.values() if heading.kind == "value"]
    kinds = {heading.kind for heading in headings.values()}
    in_pressure = head.unit is not None and find_unit(str(head.unit[0]), "pressure") is not None
    of_pressures = in_pressure or any(heading.of_pressure for heading in values)
    labelled = of_pressures
    if not of_pressures and all(heading.text.isdigit() for heading in values):
        return None
    for kind in ("range", "engine", "tap"):
        stated = {getattr(heading.said, kind) is not None for heading in values}
        if len(stated) > 1:
            return None
        if kind in kinds:
            settled = of_pressures or kind == "tap"
        else:
            settled = all(stated) or getattr(head.said, kind) is not None
        if settled:
            continue
        column = _column_that_says(sheet, row, headings, kind, words)
        if column is not None:
            text = headings[column].text if column in headings else ""
            headings, labelled = {**headings, column: _Heading(text, kind)}, True
        elif kind != "tap":
            return None
    return headings if labelled else None


def _column_that_says(
    sheet: Sheet, row: int, headings: Mapping[int, _Heading], kind: str, words: GaugeWords
) -> int | None:
    """Return the first column, headed so or not understood, whose cells all say what is looked for."""
    rows = range(row + 1, min(row + 1 + _LOOKED_AT, len(sheet.rows)))
    for column in range(sheet.width):
        if column in headings and headings[column].kind not in (None, kind):
            continue
        said = [
            words.said_by(cell, kind) is not None for at in rows if not is_nothing(cell := sheet.filled(at, column))
        ]
        if said and said[0] and sum(said) * 2 > len(said):
            return column
    return None


def _head(sheet: Sheet, rows: Sequence[int], words: GaugeWords) -> _Head:
    said = Said()
    for row in rows:
        filled = [cell for cell in sheet.rows[row] if not is_nothing(cell)]
        if len(filled) == 1 and isinstance(filled[0], str):
            said = words.title(filled[0]).over(said)
    return _Head(said, _labelled(sheet, rows, "unit"), _labelled(sheet, rows, "temperature"))


def _labelled(sheet: Sheet, rows: Sequence[int], kind: str) -> _Stated | None:
    """Return what stands behind a label of a kind in the same cell, or in one of the next two; the last of several."""
    found = None
    for row in rows:
        for column, cell in enumerate(sheet.rows[row]):
            label, _, rest = str(cell).partition(":")
            if label_of(label, "column") != kind:
                continue
            places = [(rest, column), *((sheet.cell(row, at), at) for at in (column + 1, column + 2))]
            beside = next(((value, at) for value, at in places if not is_nothing(value)), None)
            if beside is not None:
                found = beside[0], sheet.place(row, beside[1]), unit_in(label)
    return found
