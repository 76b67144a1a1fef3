"""Find the tables of gauge readings on a sheet, and what their headings mean.

The words are those of ``gauge_vocabulary.toml``: ranges of the lever, what the engine does, taps.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any, Literal, cast

from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_tables import SelectorRange
from atleak.catalogue.written_numbers import decimal_number
from atleak.common.translations import languages
from atleak.common.units import Unit, find_unit
from atleak.common.wording import wording
from atleak.measurements.gauge_readings import LINE_TAP, Engine
from atleak.measurements.own_forms import ATF_TEMPERATURE, GAUGES, PRESSURES
from atleak.readers.cells.extent import MOST_TABLES
from atleak.readers.cells.sheet import BRACKETS, Cell, Sheet, text_of
from atleak.readers.cells.sheet import Cell as SheetCell
from atleak.readers.dates import vocabulary, words
from atleak.readers.own_forms import FormTable, form_tables

ColumnKind = Literal[
    "range", "engine", "tap", "temperature", "engine_speed", "repeat", "time", "gauge", "unit", "aside", "value"
]
Tokens = tuple[str, ...]

_SQUARE = re.compile(r"\[([^\]]*)\]")
_SPEED = re.compile(r"(\d[\d.,' ]*)\s*(?:rpm|1/min|min-1|r/min|u/min|obr\.?/min)", re.IGNORECASE)
_SEPARATORS = re.compile(r"[\s,;:_/|]+")
_NOTHING = frozenset(("", "-", "–", "—", "−", "/", "x", "?", "…", "..."))
_KINDS = {"temperature": "temperature", "engine_speed": "rotational_speed"}  # of columns other than of pressures
_UNIT_KINDS = ("pressure", "temperature", "rotational_speed")


@cache
def _phrases(table: str) -> Mapping[Tokens, str]:
    """Return the phrases of a table of the vocabulary, each with the name under which it stands."""
    return {
        tuple(phrase.split()): name
        for name, listed in vocabulary(__package__, "gauge_vocabulary.toml")[table].items()
        for phrase in listed
    }


def is_blank_heading(cell: SheetCell) -> bool:
    """Return whether a cell says that nothing was measured: it is empty, a dash, or says so in words."""
    if not isinstance(cell, str):
        return cell is None
    return cell.strip() in _NOTHING or tuple(words(cell).split()) in _phrases("not_measured")


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
    unit: Unit | None = None
    wrong_unit: str | None = None  # in square brackets, and none that is known

    @property
    def of_pressure(self) -> bool:
        """Return whether a unit or a word for pressure stands in it, if only a wrong one."""
        return bool(self.unit or self.wrong_unit or not self.said.anything)


@dataclass(frozen=True)
class GaugeWords:
    """The words of a controller's tables: everybody's, and its circuits by id and name."""

    taps: Mapping[Tokens, str] = field(default_factory=dict)
    tap_ids: tuple[str, ...] = (LINE_TAP,)
    _headings: dict[str, _Heading] = field(default_factory=dict, compare=False, repr=False)  # by text
    _sayings: dict[tuple[str, Sequence[str], bool], Said | None] = field(
        default_factory=dict, compare=False, repr=False
    )

    @classmethod
    def of(cls, controller: Controller) -> GaugeWords:
        """Return the words for a controller."""
        taps: dict[Tokens, str] = dict.fromkeys(_phrases("line"), LINE_TAP)
        for circuit in controller.circuits:
            named = (circuit.id, *(wording(language).name(circuit.name) for language in languages()))
            taps |= {tuple(words(name).split()): circuit.id for name in named}
        return cls(taps, (LINE_TAP, *(circuit.id for circuit in controller.circuits)))

    def said_by(self, cell: SheetCell, kind: str) -> Said | None:
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

    def heading(self, cell: SheetCell) -> _Heading:
        """Return what a heading means.

        >>> heading = GaugeWords({("line",): "line"}).heading("Line, slow idle [kPa]")
        >>> heading.kind, heading.said.tap, heading.said.engine.value, heading.unit.name
        ('value', 'line', 'slow_idle', 'kPa')
        """
        text = text_of(cell)
        if _is_number(text):
            return _Heading(text)
        if text not in self._headings:
            self._headings[text] = self._heading(text)
        return self._headings[text]

    def _heading(self, text: str) -> _Heading:
        rest, unit, kind, wrong = _without_unit(text)
        tokens = tuple(words(_SPEED.sub(" ", rest)).split())
        whole = _phrases("column").get(tokens)
        if whole is not None:
            return _Heading(text, cast("ColumnKind", whole), unit=unit)
        if not tokens and kind == "pressure":
            return _Heading(text, "value", unit=unit)
        said = self._said(rest, ("range", "engine", "tap"), heading=True)
        if said is not None and kind in (None, "pressure"):
            return _Heading(text, "value", said, unit, wrong)
        if any((token,) in _phrases("column") and _phrases("column")[token,] == "aside" for token in tokens):
            return _Heading(text, "aside", unit=unit)
        return _Heading(text, unit=unit)

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
        tokens = tuple(words(_SPEED.sub(" ", text)).split())
        tables = {"range": _phrases("ranges"), "engine": _phrases("engine"), "tap": self.taps}
        meanings = {phrase: (name, value) for name in reversed(about) for phrase, value in tables[name].items()}
        meanings = {**dict.fromkeys(_phrases("filler"), ("filler", "")), **meanings}
        if heading:
            meanings = {**dict.fromkeys(_phrases("pressure"), ("pressure", "")), **meanings}
        said: dict[str, str] = {}
        before = ""
        for name, value in _read(tokens, meanings):
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


def _read(tokens: Tokens, meanings: Mapping[Tokens, tuple[str, str]]) -> Iterator[tuple[str | None, str]]:
    """Yield what the longest known phrases say, one after the other; (None, word) for a word that is none."""
    longest = max(map(len, meanings), default=1)
    at = 0
    while at < len(tokens):
        for length in range(min(longest, len(tokens) - at), 0, -1):
            phrase = tokens[at : at + length]
            if phrase in meanings:
                yield meanings[phrase]
                at += length
                break
        else:
            yield None, tokens[at]
            at += 1


def _without_unit(text: str) -> tuple[str, Unit | None, str | None, str | None]:
    """Return a heading without its unit, the unit, its kind, and what stands in square brackets and is no unit."""
    for match in BRACKETS.finditer(text):
        for kind in _UNIT_KINDS:
            unit = find_unit(match[1], kind)
            if unit is not None:
                return text[: match.start()] + " " + text[match.end() :], unit, kind, None
    square = _SQUARE.search(text)
    if square is not None:
        return text[: square.start()] + " " + text[square.end() :], None, None, square[1]
    *parts, last = _SEPARATORS.split(text.strip())
    unit = find_unit(last, "pressure")
    if unit is not None:
        return " ".join(parts), unit, "pressure", None
    return text, None, None, None


def engine_words() -> list[str]:
    """Return the usual words for what the engine does."""
    return [str(engine.label) for engine in Engine]


def label_and_value(text: str, kind: str) -> str | None:
    """Return what stands behind a label of that kind in the same cell, ``""`` where only the label does, else None.

    >>> label_and_value("Unit: bar", "unit"), label_and_value("ATF temperature", "temperature")
    ('bar', '')
    """
    label, colon, rest = text.partition(":")
    tokens = tuple(words(BRACKETS.sub(" ", label)).split())
    if _phrases("column").get(tokens) != kind:
        return None
    return rest.strip() if colon else ""


_LOOKED_AT = 30  # rows below the headings in which a column without a heading may show what it is
_TITLES = 8  # rows above the headings that may speak of the table


@dataclass(frozen=True)
class _Head:
    """What stands above the headings: what all readings have in common, their unit and the fluid's temperature."""

    said: Said = Said()
    unit: tuple[str, int, int] | None = None  # text, row, column
    temperature: tuple[Cell, int, int, Unit | None] | None = None  # with the unit that its label says

    @property
    def in_pressure(self) -> bool:
        """Return whether its unit is one of pressure."""
        return self.unit is not None and find_unit(str(self.unit[0]), "pressure") is not None


@dataclass(frozen=True)
class GaugeTable:
    """One table: the row of its headings, its columns, and the rows below."""

    sheet: Sheet
    row: int  # of the headings
    last: int  # row
    headings: Mapping[int, _Heading]  # by column
    head: _Head = field(default_factory=_Head)

    def column(self, kind: str) -> int | None:
        """Return the column of that kind; None where there is none."""
        return next((column for column, heading in self.headings.items() if heading.kind == kind), None)

    @property
    def rows(self) -> range:
        """Return the rows below the headings."""
        return range(self.row + 1, self.last + 1)

    @property
    def values(self) -> list[int]:
        """Return the columns of readings."""
        return [column for column, heading in self.headings.items() if heading.kind == "value"]

    def said(self, column: int) -> Said:
        """Return what heading and title say of the readings in a column."""
        return self.headings[column].said.over(self.head.said)


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
        GaugeTable(sheet, row, end, headings, head) for (row, headings, head), end in zip(headers, ends, strict=False)
    ]


def _of_form(table: FormTable) -> GaugeTable:
    """Return the table of a form that atleak wrote, whose columns are known."""
    sheet, headings = table.sheet, dict[int, _Heading]()
    for key, at in table.columns.items():
        said = Said(engine=Engine(key)) if key in {*Engine} else Said()
        kind = "value" if said.engine else "aside" if key.startswith("permissible") else key
        heading = _Heading(table.heading(key), cast("ColumnKind", kind), said)
        headings[at] = replace(heading, unit=table.unit(key, _KINDS.get(kind, "pressure")))
    labels = {wording(language).sentence(ATF_TEMPERATURE) for language in languages()}
    warm = (
        (*place, _unit_of_label(cell))
        for row in range(table.row)
        for column, cell in enumerate(sheet.rows[row])
        if text_of(cell).partition(" [")[0] in labels and (place := _beside(sheet, row, column, ""))
    )
    return GaugeTable(sheet, table.row, len(sheet.rows) - 1, headings, _Head(temperature=next(warm, None)))


def likeness(sheet: Sheet, words: GaugeWords) -> float:
    """Return how much of a sheet's headings is understood as those of gauge readings; 0 where there are none."""
    tables = find_gauge_tables(sheet, words)
    return float(max((sum(each.kind is not None for each in table.headings.values()) for table in tables), default=0))


def _before_titles(sheet: Sheet, row: int) -> int:
    """Return the last row above some headings that is no title of theirs: titles fill one cell."""
    above = row - 1
    while above > 0 and 0 < sum(not is_blank_heading(cell) for cell in sheet.rows[above]) <= 1:
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
    if row - 1 < free:
        return headings
    above = _headings(sheet, row - 1, words)
    if len(above) < 2:
        return headings  # one cell is a title
    joined = {}
    for column, heading in headings.items():
        upper = above.get(column)
        if heading.kind == "value" and upper is not None and upper.kind == "value":
            heading = replace(heading, said=heading.said.over(upper.said), unit=heading.unit or upper.unit)
        joined[column] = heading
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
    of_pressures = head.in_pressure or any(heading.of_pressure for heading in values)
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
            words.said_by(cell, kind) is not None
            for at in rows
            if not is_blank_heading(cell := sheet.filled(at, column))
        ]
        if said and said[0] and sum(said) * 2 > len(said):
            return column
    return None


def _head(sheet: Sheet, rows: Sequence[int], words: GaugeWords) -> _Head:
    head = _Head()
    for row in rows:
        filled = [(column, cell) for column, cell in enumerate(sheet.rows[row]) if not is_blank_heading(cell)]
        for column, cell in filled:
            if not isinstance(cell, str):
                continue
            for kind in ("unit", "temperature"):
                value = _beside(sheet, row, column, label_and_value(cell, kind))
                if value is not None:
                    changed: dict[str, Any] = {kind: value if kind == "unit" else (*value, _unit_of_label(cell))}
                    head = replace(head, **changed)
        if len(filled) == 1 and isinstance(filled[0][1], str):
            head = replace(head, said=words.title(filled[0][1]).over(head.said))
    return head


def _unit_of_label(label: str) -> Unit | None:
    inside = BRACKETS.search(label)
    return find_unit(inside[1], "temperature") if inside else None


def _beside(sheet: Sheet, row: int, column: int, value: str | None) -> tuple[Any, int, int] | None:
    """Return the value of a label with its place: behind it in the same cell, or in one of the next two."""
    if value:
        return value, row, column
    if value is None:
        return None
    places = ((sheet.cell(row, at), row, at) for at in (column + 1, column + 2))
    return next((place for place in places if not is_blank_heading(place[0])), None)
