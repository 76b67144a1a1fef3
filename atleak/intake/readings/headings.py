"""Which row holds the headings, and what each column is."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Literal

from atleak.catalogue.instruments import Part
from atleak.intake.readings.heading_numbers import besides_numbers, is_angle, numbers_of_heading
from atleak.intake.readings.words import (
    SPECIFICATIONS,
    STATES,
    is_blank,
    number_of,
    part_of,
    plain,
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

_DEPTH = 3  # rows that headings may be spread over

_MEAN = vocabulary("mean", "mean_in_heading")
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
_BETWEEN = " ,/:;"  # a heading and its unit
_TRAILING_UNITS = {
    *("mm", "um", "µm", "μm", "micron", "microns", "micrometre", "micrometer", "inch", "inches", "in", "mil", "mils"),
    *("thou", "cm", "мм", "мкм"),
}
_TOKEN = re.compile(r"\d+(?:°|deg\b)|[ø⌀φ#]|[^\W\d_øφ]+\d*|\d+")


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
    rank: int = 0
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
    def group(self) -> tuple[Part | None, float | None, int | None]:
        """Return what the columns that make one diameter have in common."""
        return self.part, self.direction, self.repeat


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
    words = set(_TOKEN.findall(plain(column.heading).replace("_", " ")))
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
    taken: set[int] = set()
    for header in sorted(candidates, key=lambda each: (-round(each.score + _depth_bonus(sheet, each), 9), each.first)):
        rows = range(header.first, header.last + 1)
        if taken.isdisjoint(rows):
            headers.append(header)
            taken.update(rows)
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
        width = max(len(row) for row in sheet.rows[first : last + 1])
        headings = [_heading(sheet, first, last, column) for column in range(width)]
        columns = [column for index, text in enumerate(headings) if (column := read_heading(text, index)) is not None]
        header = Header(first, last, read_together(columns), tuple(headings))
        if last > first and _is_data(sheet, header, last):
            return
        yield header


def _heading(sheet: Sheet, first: int, last: int, column: int) -> str:
    cells = [sheet.filled(row, column) for row in range(first, last + 1)]
    texts = [str(cell).strip() if isinstance(cell, str) else text_of(cell) for cell in cells]
    return " ".join(dict.fromkeys(text for text in texts if text))


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
    tokens = _TOKEN.findall(plain(rest).replace("_", " "))
    words = set(tokens)
    if not words:
        return None
    of_land = _of_land(words, unit)
    if of_land is not None:
        return Column(index, text, of_land, unit=unit)
    role, rank = _role(words, rest, unit)
    if role is None:
        return None
    if role not in {"diameter", "coordinate"}:
        return Column(index, text, role, unit=unit, rank=rank)
    coordinate, direction, repeat = numbers_of_heading(role, tokens)
    standing: Literal["raw", "corrected"] | None = (
        "corrected" if words & _CORRECTED else "raw" if words & _RAW else None
    )
    outcome = bool(words & _NOW) or (unit is None and bool(words & _OUTCOME))
    tentative = outcome and not words & _SIZE and repeat is None
    part = _part(words, rest)
    return Column(
        *(index, text, role, unit, coordinate, part, direction, repeat),
        standing=standing,
        tentative=tentative,
        besides=besides_numbers(words),
    )


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
        (plain(text) in {"d", "di"} and unit is not None, "diameter"),
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
    return bool(set(_TOKEN.findall(plain(column.heading).replace("_", " "))) & _COUNTED)


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
    before, unit_text = _last_word(text)
    if before is not None and unit_text.lower() in _TRAILING_UNITS:
        return before, find_unit(unit_text, "length")
    if text.strip().lower() in _TRAILING_UNITS - {"in"}:
        return "", find_unit(text, "length")
    return text, None


def _last_word(text: str) -> tuple[str | None, str]:
    """Return what stands before the last word of a heading, and the word; None before a word that stands alone.

    >>> _last_word("Diameter_mm "), _last_word("Diameter,/mm"), _last_word("mm")
    (('Diameter', 'mm'), ('Diameter', 'mm'), (None, 'mm'))
    """
    spaced = re.sub(r"[\s_]", " ", text).rstrip()
    start = spaced.rfind(" ") + 1
    word = spaced[start:].lstrip(_BETWEEN)
    if not start:
        start = next((at for at, sign in enumerate(spaced) if sign in _BETWEEN), len(spaced))
        word = spaced[start:].lstrip(_BETWEEN) or spaced
    before = spaced[: len(spaced) - len(word)]
    return (text[: len(before.rstrip(_BETWEEN))] if before else None), word


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
    angles = {column.direction for column in columns if column.holds_value} - {None}
    # "x1" and "x2" without "y1" and "y2" are only the names of two coordinates
    only_names = len(angles) == 1 and any(re.search(r"\b[xy][12]\b", column.heading.lower()) for column in columns)
    together = []
    for column in columns:
        if column.holds_value and ("direction" in roles or only_names):
            column = replace(column, direction=None)
        if column.holds_value and "part" in roles:
            column = replace(column, part=None)
        together.append(column)
    counted: dict[tuple[Part | None, float | None], set[int | None]] = defaultdict(set)
    for column in together:
        if column.holds_value:
            counted[column.group[:2]].add(column.repeat)
    # repeats count from 1, behind a word for them with one left out at most: 12 and 24 are something else
    gaps = {
        column.group[:2]
        for column in together
        if column.repeat is not None
        and (
            column.repeat > len(counted[column.group[:2]]) + _is_counted(column)
            or {None, 1} <= counted[column.group[:2]]  # "measurement 1", "measurement 2", "result"
        )
    }
    return tuple(replace(column, repeat=None) if column.group[:2] in gaps else column for column in together)
