"""Which row holds the headings, and what each column is."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Literal

from atleak.catalogue.instruments import Part
from atleak.intake.readings.heading_numbers import (
    besides_numbers,
    is_angle,
    is_explained,
    numbers_of_heading,
    spot_of_heading,
    tokens_of,
)
from atleak.intake.readings.words import (
    SPECIFICATIONS,
    STATES,
    is_blank,
    number_of,
    part_of,
    side_of,
    text_of,
    vocabulary,
)
from atleak.intake.sheets.sheet import Sheet
from atleak.intake.units import Unit, find_unit
from atleak.sentence import Sentence

Role = Literal[
    "component", "part", "plane", "land", "direction", "repeat", "unit", "diameter", "coordinate", "mean",
    "raw", "specification", "quantity", "remark", "gauge", "contact length", "position", "fitted repair",
]  # fmt: skip
KEYS: tuple[Role, ...] = ("component", "part", "plane", "land", "direction", "repeat")
OF_LANDS: tuple[Role, ...] = ("contact length", "position", "fitted repair")  # of a land itself, beside its diameters
_SAYS_NOTHING: tuple[Role, ...] = ("raw", "specification", "quantity", "remark", "gauge", *OF_LANDS)

EXPECTED = Sentence(
    "one row of headings with at least: component (or 'No.'), part (spool or sleeve), plane (or land), and either "
    "diameter or coordinate x1 and coordinate x2; also read: direction, repeat, unit"
)

_DEPTH = 4  # rows that headings may be spread over

_MEAN = vocabulary("mean", "mean_in_heading")
_SUM = vocabulary("sum")
_ACTUAL = vocabulary("actual")
_NOW = vocabulary("now")
_EARLIER = vocabulary("earlier")
_NEW = vocabulary("new")
_WHEN = vocabulary("when")
_CORRECTED = vocabulary("corrected")
_RAW = vocabulary("raw")
_STANDING = vocabulary("corrected", "raw")
_OUTCOME = vocabulary("actual", "corrected", "raw")
_QUANTITY = vocabulary("quantity", "clearance", "error", "spread")
_REMARK = vocabulary("remark")
_DIRECTION = vocabulary("direction")
_PLANE = vocabulary("plane")
_LAND = vocabulary("land")
_REPEAT = vocabulary("repeat")
_COUNTED = vocabulary("repeat", "reading")
_READING = vocabulary("reading", "actual")
_SAYS_NOW = vocabulary("reading", "actual", "now", "when")
_COORDINATE = vocabulary("coordinate")
_DIAMETER = vocabulary("diameter")
_SIZE = vocabulary("diameter", "coordinate")
_PART = vocabulary("part")
_COMPONENT = vocabulary("component")
_NUMBER = vocabulary("number")
_FIGURE = vocabulary("figure")
_NAME = vocabulary("name")
_GENERIC = vocabulary("generic")
_NUMBERED = vocabulary("number", "generic")
_UNIT = vocabulary("unit")
_UNDER_ANOTHER = vocabulary(
    "mean", "sum", "mean_in_heading", "specification", "specification_title", "actual", "reading"
)
_GAUGE = vocabulary("gauge")
_CONTACT_LENGTH = vocabulary("contact_length")
_CONTACT = vocabulary("contact")
_LENGTH = vocabulary("length")
_BESIDE_CONTACT_LENGTH = vocabulary("contact_length", "contact", "length", "beside_contact_length", "actual", "reading")
_POSITION = vocabulary("axial_position")
_LEFT = vocabulary("left")
_BESIDE_POSITION = vocabulary("axial_position", "left", "beside_position", "actual", "reading")
_FITTED = vocabulary("fitted")
_REPAIR = vocabulary("repair")
_FITTED_REPAIR = vocabulary("fitted", "repair")
_TRAILING_UNITS = {
    *("mm", "um", "µm", "μm", "micron", "microns", "micrometre", "micrometer", "inch", "inches", "in", "mil", "mils"),
    *("thou", "cm", "мм", "мкм"),
}
_LETTERED = re.compile(r"(?<![^\W_])([dD])(?:[xyi]|\d{1,2})?(?![^\W_])")  # d of the spool, D of its bore


@dataclass(frozen=True)
class Column:
    """One column of the table.

    ``rank`` says how surely a component column is one, by its heading. ``standing`` is what a heading says of a
    diameter beside others: as read from the instrument, or corrected. ``tentative`` is a "result" or "actual" without
    a unit: it is a diameter only if its cells are.
    """

    index: int
    heading: str
    role: Role
    unit: Unit | None = None
    coordinate: int | None = None  # 1 or 2
    part: Part | None = None
    direction: float | None = None
    repeat: int | None = None
    land: str | None = None
    plane: str | None = None
    rank: int = 0
    unsure: bool = False  # headed by a number alone: land, direction or repeat
    otherwise: Role | None = None  # what a tentative diameter is where its cells are none
    standing: Literal["raw", "corrected"] | None = None
    tentative: bool = False
    besides: frozenset[str] = frozenset()  # words of a value's heading that say none of this

    @property
    def name(self) -> str:
        """Return the heading on one line."""
        return " ".join(self.heading.split())

    @property
    def holds_value(self) -> bool:
        return self.role in {"diameter", "coordinate"}

    @property
    def holds_size(self) -> bool:
        """Return whether diameters may stand in it, measured or not."""
        return self.holds_value or self.role in {"specification", "mean", "gauge"}

    @property
    def of_lands(self) -> bool:
        """Return whether what lands themselves have stands in it."""
        return self.role in OF_LANDS

    @property
    def station(self) -> tuple[Part | None, float | None, str | None, str | None]:
        """Return what the columns of one place and its repeats have in common."""
        return self.part, self.direction, self.land, self.plane

    @property
    def group(self) -> tuple[object, ...]:
        """Return what the columns that make one diameter have in common."""
        return *self.station, self.repeat


@dataclass(frozen=True)
class Header:
    """The headings of a table: rows ``first`` to ``last`` from 0, of all columns in ``texts``.

    A table that goes on under another title, or on another sheet, has no headings of its own: ``last`` is then the row
    above its first one, -1 at the top of a sheet.
    """

    first: int
    last: int
    columns: tuple[Column, ...]
    texts: tuple[str, ...] = ()

    def text(self, index: int) -> str:
        """Return a column's heading on one line; "" where it has none."""
        return " ".join(self.texts[index].split()) if index < len(self.texts) else ""

    def of(self, role: Role) -> tuple[Column, ...]:
        return tuple(column for column in self.columns if column.role == role)

    @property
    def values(self) -> tuple[Column, ...]:
        return tuple(column for column in self.columns if column.holds_value)

    @property
    def of_lands(self) -> tuple[Column, ...]:
        """Return the columns of what a land itself has, or its component: contact length, position, fitted repair."""
        return tuple(column for column in self.columns if column.role in OF_LANDS)

    @property
    def roles(self) -> set[Role]:
        """Return what the headings name, of all that makes a reading."""
        return {column.role for column in self.columns}.difference(_SAYS_NOTHING)

    @property
    def complete(self) -> bool:
        """Return whether the rows under the headings can be read at all."""
        return bool(self.of("component")) and bool(self.values)

    @property
    def score(self) -> float:
        """Return how much this looks like the headings of a measuring sheet."""
        named = self.roles
        distinct = {(column.role, column.coordinate, column.group) for column in self.values}
        doubled = len(self.values) - len(distinct)
        return (
            2.0 * ("component" in named)
            + 2.0 * bool(distinct)
            + len(named & {"part", "plane", "land", "direction"})
            + 0.5 * ("repeat" in named)
            + 0.1 * min(len(distinct), 20)
            + 0.05 * any(column.unit for column in self.values)
            - 0.1 * doubled
            - 0.01 * (self.last - self.first)
        )

    @property
    def starts_table(self) -> bool:
        """Return whether this can only be headings: two sizes, or a size beside what it is of."""
        sizes = [column for column in self.columns if column.holds_size and _is_named_size(column)]
        others = [column for column in self.columns if column.role == "quantity" and column.unit is not None]
        others += self.of_lands
        keys = {column.role for column in self.columns}.intersection(KEYS)
        several = sum(column.holds_value for column in self.columns) > 1  # "spool" and "bore", or "0°" and "90°"
        return (len(sizes) or several) + bool(keys) > 1 or (bool(others) and len(keys) > 1)


def _is_named_size(column: Column) -> bool:
    """Return whether a word of its own says a size, not only "spool" or "0°", which stand in readings too."""
    if not column.holds_value:
        return True
    words = set(tokens_of(column.heading))
    named = words & _SIZE or words & _READING or _both_ends(words) or column.role == "coordinate"
    return bool(named or column.unit is not None or column.standing)


def best_header(sheet: Sheet) -> Header | None:
    """Return the row (or up to three rows) that looks most like headings, or None where none does."""
    best: Header | None = None
    for first in range(len(sheet.rows)):
        if not _may_hold_headings(sheet, first):
            continue
        for header in _headers_at(sheet, first):
            if header.score > 2.0 and (best is None or header.score > best.score + 1e-9):
                best = header
    return best


def find_headers(sheet: Sheet, is_component: Callable[[str], bool]) -> list[Header]:
    """Return the headings of every table, from top to bottom. ``is_component`` knows the cells of readings."""
    candidates = []
    for first in range(len(sheet.rows)):
        if not _may_hold_headings(sheet, first) or _names_component(sheet, first, is_component):
            continue
        decimals = _holds_decimals(sheet, first)
        if decimals and sum(isinstance(cell, str) and read_heading(cell) is not None for cell in sheet.rows[first]) < 3:
            continue
        for header in _headers_at(sheet, first):
            last = header.last
            if last > first and (
                decimals or _names_component(sheet, last, is_component) or _holds_decimals(sheet, last)
            ):
                break
            # a row that holds a number is taken only where its headings leave no doubt
            if header.starts_table and (not decimals or (header.complete and len(header.roles) > 2)):
                candidates.append(header)
    headers: list[Header] = []
    for header in sorted(candidates, key=lambda each: (-round(each.score + _depth_bonus(sheet, each), 9), each.first)):
        if all(header.last < other.first or header.first > other.last for other in headers):
            headers.append(header)
    return sorted(headers, key=lambda each: each.first)


def _depth_bonus(sheet: Sheet, header: Header) -> float:
    """Score headings under headings higher: "nominal" and "actual" under "diameter" make no table of their own."""
    return sum(
        0.02
        for row in range(header.first + 1, header.last + 1)
        if any(
            isinstance(cell, str) and (column := read_heading(cell)) is not None and column.holds_size
            for cell in sheet.rows[row]
        )
    )


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
        return len(texts) > 1
    return texts[0] > 0 and sheet.merged.get((row, texts[0] + 1)) == (row, texts[0])


def _headers_at(sheet: Sheet, first: int) -> Iterator[Header]:
    for last in range(first, min(first + _DEPTH, len(sheet.rows))):
        if last > first and not any(not is_blank(cell) for cell in sheet.rows[last]):
            return
        headings = _headings(sheet, first, last)
        columns = [column for index, text in enumerate(headings) if (column := read_heading(text, index)) is not None]
        columns += _numbered(columns, headings)
        header = Header(first, last, read_together(columns), tuple(headings))
        if last > first and _is_data(sheet, header, last):
            return
        yield header


def _headings(sheet: Sheet, first: int, last: int) -> list[str]:
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
            if any(below) and any(beside) and same_above and _heads_part(below):
                texts[column] = texts[column - 1]
    return [" ".join(dict.fromkeys(text for text in texts if text)) for texts in zip(*levels, strict=True)]


def _said(sheet: Sheet, row: int, column: int) -> str:
    cell = sheet.filled(row, column)
    return str(cell).strip() if isinstance(cell, str) else text_of(cell)


@lru_cache(maxsize=4096)
def _is_under_another(text: str) -> bool:
    rest, _ = split_unit(text)
    words = tokens_of(rest)
    return is_explained(spot_of_heading(words)[1]) or bool(set(words) & _UNDER_ANOTHER)


def _heads_part(texts: Sequence[str]) -> bool:
    """Return whether headings say only a part, a place or a repeat, so that what they are of stands over them."""
    return all(_is_under_another(text) for text in texts if text)


def _numbered(columns: Sequence[Column], headings: Sequence[str]) -> list[Column]:
    """Return columns headed 1, 2 … alone beside component and part, where no other holds a diameter."""
    roles = {column.role for column in columns}
    if not {"component", "part"} <= roles or any(column.holds_size for column in columns):
        return []
    numbered = [index for index, text in enumerate(headings) if re.fullmatch(r"[1-9]", text)]
    if len(numbered) < 2 or [headings[index] for index in numbered] != [str(at + 1) for at in range(len(numbered))]:
        return []
    return [
        Column(index, headings[index], "diameter", repeat=int(headings[index]), tentative=True, unsure=True)
        for index in numbered
    ]


def _is_data(sheet: Sheet, header: Header, row: int) -> bool:
    """Return whether the last row taken for headings is a reading: it names a component of its own."""
    return any(
        not is_blank(sheet.cell(row, column.index))
        and any(not is_blank(sheet.cell(above, column.index)) for above in range(header.first, row))
        for column in header.of("component")
    )


@lru_cache(maxsize=4096)
def read_heading(text: str, index: int = 0) -> Column | None:
    """Return what a heading says of its column; None where it says nothing.

    >>> column = read_heading("Coordinate x1 (y1) [mm]")
    >>> column.role, column.coordinate, column.unit.name
    ('coordinate', 1, 'mm')
    >>> read_heading("Diameter Mean Value di (Di) [mm]").role
    'mean'
    >>> column = read_heading("spool_diameter_2_um")
    >>> column.role, column.part, column.repeat, column.unit.name
    ('diameter', 'spool', 2, 'µm')
    """
    rest, unit = split_unit(text)
    tokens = tokens_of(rest)
    words = set(tokens)
    if not words:
        return None
    of_land = _of_land(words, unit)
    if of_land is not None:
        return Column(index, text, of_land, unit=unit)
    named, rank = _role(words, rest, unit)
    part, side = _part(words, rest), side_of(rest)
    spot, others = spot_of_heading(tokens)
    role = _role_at_spot(named, others, unit) if spot.is_somewhere else _role_of_part(named, tokens, part, side, unit)
    if role is None:
        return None
    if role == "diameter" and None not in (part, side) and part != side:
        role = "quantity"  # the outer diameter of a sleeve, say
    if role not in {"diameter", "coordinate"}:
        return Column(index, text, role, unit=unit, rank=rank)
    coordinate, direction, repeat = numbers_of_heading(role, others)
    standing: Literal["raw", "corrected"] | None = (
        "corrected" if words & _CORRECTED else "raw" if words & _RAW else None
    )
    outcome = bool(words & _NOW) or (unit is None and bool(words & _OUTCOME))
    by_place = role != named and unit is None and not words & _SIZE
    return Column(
        *(index, text, role, unit, coordinate, part or side, spot.direction if direction is None else direction),
        *(repeat, spot.land, spot.plane),
        otherwise=named if by_place else None,
        standing=standing,
        tentative=(outcome and not words & _SIZE and repeat is None) or by_place,
        besides=besides_numbers(others),
    )


def _role_at_spot(named: Role | None, others: Sequence[str], unit: Unit | None) -> Role | None:
    """Return what a heading is that says a land, plane or direction by its name: a diameter, or a figure of one.

    "Land" is the column of their numbers, "Land 1" may be a diameter there, and "Land 1 mean" is a mean.
    """
    if named not in (None, "plane", "land", "direction", "part", "component", "repeat"):
        return named
    if is_explained(others):
        return "coordinate" if set(others) & _COORDINATE else "diameter"
    of_others = _role(set(others), " ".join(others), unit)[0]
    return of_others if of_others in ("mean", "diameter", *_SAYS_NOTHING) else named


def _role_of_part(
    named: Role | None, tokens: Sequence[str], part: Part | None, side: Part | None, unit: Unit | None
) -> Role | None:
    """Return what a heading is that names a part: a diameter too, where it says a direction or repeat besides."""
    alone = part is None and unit is None
    if side is not None and part in (None, side) and is_explained(tokens) and (named is None or not alone):
        return "diameter" if named in (None, "component") else named
    if named is not None or alone or not is_explained(tokens) or (part is None and not set(tokens).isdisjoint("xy")):
        return named
    return "diameter" if any(each is not None for each in numbers_of_heading("diameter", tokens)) else None


def _of_land(words: set[str], unit: Unit | None) -> Role | None:
    """Return what a heading says of a land itself; only where it says so and nothing else.

    A plain "position" is as often the number of a row, or the depth at which a diameter was measured.

    >>> read_heading("Contact length [mm]").role, read_heading("Contact length tolerance [mm]").role
    ('contact length', 'specification')
    >>> read_heading("Position from left end [mm]").role, read_heading("Position").role
    ('position', 'component')
    """
    contact = words & _CONTACT_LENGTH or (words & _CONTACT and words & _LENGTH)
    if contact and all(word in _BESIDE_CONTACT_LENGTH for word in words):
        return "contact length"
    if unit is not None and words & _POSITION and words & _LEFT and all(word in _BESIDE_POSITION for word in words):
        return "position"
    if words & _FITTED and words & _REPAIR and all(word in _FITTED_REPAIR for word in words):
        return "fitted repair"
    return None


def _role(words: set[str], text: str, unit: Unit | None) -> tuple[Role | None, int]:
    axes = words & {"x1", "x2", "y1", "y2"}
    diameter = bool(words & _DIAMETER)
    sized = diameter or unit is not None
    parts = {part_of(word) for word in words if len(word) > 2} - {None}
    numbered = any(re.fullmatch(r"\d+", word) for word in words)
    key = any(words & each for each in (_DIRECTION, _PLANE, _LAND, _REPEAT, _COMPONENT, _PART, _NUMBER))
    simple: list[tuple[bool, Role]] = [
        (_is_earlier(words, sized or (bool(parts) and not key)) and not words & _QUANTITY, "specification"),
        (bool(words & _STANDING) and (sized or bool(words & _READING) or len(words) == 1), "diameter"),
        (bool(words & _MEAN) or "x\u0304" in text or "x\u0305" in text, "mean"),
        (bool(words & _QUANTITY) and not words & SPECIFICATIONS, "quantity"),
        (bool(words & SPECIFICATIONS) and (sized or not key or bool(words & _QUANTITY)), "specification"),
        (bool(words & _SUM), "mean"),
        (bool(words & _REMARK) and not (words & _GAUGE and unit is not None), "remark"),
        (bool(words & _DIRECTION), "direction"),
        (bool(words & _PLANE), "plane"),
        (bool(words & _LAND) and (numbered or not diameter), "land"),
        (bool(words & _COORDINATE) or (len(axes) >= 1 and not _both_ends(axes) and not diameter), "coordinate"),
        (diameter or _both_ends(axes), "diameter"),
        (bool(words & _COUNTED or words & _ACTUAL or words & _NOW) and unit is not None, "diameter"),
        (bool(words & _COUNTED) and numbered and len(words) <= 3, "diameter"),
        (bool(words & _REPEAT), "repeat"),
        (bool(words & {"value", "reading"}), "diameter"),
        (bool(words & _UNIT) and not sized, "unit"),
        (bool(words & _PART) and not words & _NUMBER, "part"),
        (len(parts) == 2 and unit is None, "part"),
        (
            bool(words & _ACTUAL or words & _NOW) and all(word in _SAYS_NOW or part_of(word) for word in words),
            "diameter",
        ),
        (len(parts) == 1 and unit is not None, "diameter"),
        (len(parts) == 1 and len(words) == 1 and not words & _COMPONENT, "diameter"),
        (bool(_LETTERED.fullmatch(text.strip())) and unit is not None, "diameter"),
        (all(is_angle(word) for word in words), "diameter"),
        (bool(words & _GAUGE) and unit is not None, "gauge"),
    ]
    for holds, role in simple:
        if holds:
            return role, 0
    return _component_rank(words)


def _is_earlier(words: set[str], sized: bool) -> bool:
    """Return whether a heading says what a diameter was, or was when new; a "standard" by itself is a gauge."""
    earlier = words & _EARLIER or (words & _NEW and (not words & _READING or words & _WHEN))
    if not earlier or all(word in _GAUGE for word in words):
        return False
    return sized or all(word in _EARLIER or word in _NEW or word in _WHEN for word in words)


def _component_rank(words: set[str]) -> tuple[Role | None, int]:
    if words & _READING or words & STATES:
        return None, 0  # a measurement, vehicle or inspection by its number
    if words & _NAME:
        return "component", 1
    if words & _COMPONENT:
        return "component", 4 if words & _NUMBER else 3
    if words & _NUMBER and words & _FIGURE:
        return "component", 4
    if words & _NUMBERED and len([word for word in words if word not in _NUMBERED]) <= 1:
        return "component", 2
    return None, 0


def _is_counted(column: Column) -> bool:
    return bool(set(tokens_of(column.heading)) & _COUNTED)


def _both_ends(axes: set[str]) -> bool:
    return {"x1", "x2"} <= axes or {"y1", "y2"} <= axes


def _part(words: set[str], text: str) -> Part | None:
    letter = part_of(text.strip())
    if letter is not None and len(text.strip()) <= 2:
        return letter
    parts = {part_of(word) for word in words if len(word) > 2} - {None}
    return parts.pop() if len(parts) == 1 else None


@lru_cache(maxsize=4096)
def split_unit(text: str) -> tuple[str, Unit | None]:
    for bracketed in re.finditer(r"[\[\(<{]([^\[\]\(\)<>{}]*)[\]\)>}]", text):
        inner = re.sub(r"^\s*in\s+(?=\S)", "", bracketed[1])
        unit = find_unit(inner, "length") if inner.strip() else None
        if unit is not None:
            return f"{text[: bracketed.start()]} {text[bracketed.end() :]}", unit
    trailing = re.search(r"[\s_,/:;]+(\S+?)\s*$", text.replace("_", " "))
    if trailing and trailing[1].lower() in _TRAILING_UNITS:
        return text[: trailing.start()], find_unit(trailing[1], "length")
    if text.strip().lower() in _TRAILING_UNITS - {"in"}:
        return "", find_unit(text, "length")
    return text, None


def read_together(columns: list[Column]) -> tuple[Column, ...]:
    """Correct what single headings say by what all columns say together.

    A direction or part in a value's heading holds only where no column of its own says it. "Spool" and "sleeve" are
    diameters where both stand there and nothing else is one.
    """
    roles = {column.role for column in columns}
    bare = [column for column in columns if column.role == "diameter" and part_of(column.heading) and not column.unit]
    others = any(column.holds_value and column not in bare for column in columns)
    if others or "part" in roles or len({column.part for column in bare}) < 2:
        columns = [column for column in columns if column not in bare]
    columns = _lettered(columns)
    if any(column.part == "spool" and side_of(column.heading) for column in columns):
        columns = [_as_inner(column) for column in columns]
    angles = {column.direction for column in columns if column.holds_value} - {None}
    # "x1" and "x2" without "y1" and "y2" are only the names of two coordinates
    only_names = len(angles) == 1 and any(re.search(r"\b[xy][12]\b", column.heading.lower()) for column in columns)
    together = []
    for column in columns:
        if column.holds_value and ("direction" in roles or only_names):
            column = replace(column, direction=None)
        if column.holds_value and "part" in roles:
            column = replace(column, part=None)
        if column.holds_value:
            column = replace(
                column,
                land=None if "land" in roles else column.land,
                plane=None if "plane" in roles else column.plane,
            )
        together.append(column)
    counted: dict[tuple[object, ...], set[int | None]] = defaultdict(set)
    for column in together:
        if column.holds_value:
            counted[column.station].add(column.repeat)
    # repeats count from 1, behind a word for them with one left out at most: 12 and 24 are something else
    gaps = {
        column.station
        for column in together
        if column.repeat is not None
        and (
            column.repeat > len(counted[column.station]) + _is_counted(column)
            or {None, 1} <= counted[column.station]  # "measurement 1", "measurement 2", "result"
        )
    }
    return tuple(replace(column, repeat=None) if column.station in gaps else column for column in together)


def _lettered(columns: list[Column]) -> list[Column]:
    """Return diameters headed "dx" and "Dx" as of spool and bore, where both letters stand there."""
    letters = {
        column.index: match[1]
        for column in columns
        if column.holds_value and (match := _LETTERED.search(column.heading))
    }
    if set(letters.values()) != {"d", "D"}:
        return columns
    return [
        replace(column, part=part_of(letters[column.index])) if column.index in letters and not column.part else column
        for column in columns
    ]


def _as_inner(column: Column) -> Column:
    """Return a column headed "ID" beside one headed "OD" as the bore's diameter."""
    if column.role != "component" or side_of(column.heading) != "sleeve":
        return column
    return replace(column, role="diameter", part="sleeve", rank=0, tentative=column.unit is None)
