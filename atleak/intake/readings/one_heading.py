"""What a single heading says of its column."""

from __future__ import annotations

import re
from collections.abc import Sequence
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
    COUNTED,
    QUANTITIES,
    READINGS,
    SIZES,
    SPECIFICATIONS,
    STATES,
    part_of,
    side_of,
    vocabulary,
)
from atleak.intake.units import Unit, find_unit

Role = Literal[
    "component", "part", "plane", "land", "direction", "repeat", "unit", "diameter", "coordinate", "mean",
    "raw", "specification", "quantity", "remark", "gauge", "contact length", "position", "fitted repair",
]  # fmt: skip
KEYS: tuple[Role, ...] = ("component", "part", "plane", "land", "direction", "repeat")
OF_LANDS: tuple[Role, ...] = ("contact length", "position", "fitted repair")  # of a land itself, beside its diameters
SAYS_NOTHING: tuple[Role, ...] = ("raw", "specification", "quantity", "remark", "gauge", *OF_LANDS)

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
_REMARK = vocabulary("remark")
_DIRECTION = vocabulary("direction")
_PLANE = vocabulary("plane")
_LAND = vocabulary("land")
_REPEAT = vocabulary("repeat")
_SAYS_NOW = vocabulary("reading", "actual", "now", "when")
_COORDINATE = vocabulary("coordinate")
_DIAMETER = vocabulary("diameter")
_PART = vocabulary("part")
_COMPONENT = vocabulary("component")
_NUMBER = vocabulary("number")
_FIGURE = vocabulary("figure")
_NAME = vocabulary("name")
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
_TRAILING_UNITS = {
    *("mm", "um", "µm", "μm", "micron", "microns", "micrometre", "micrometer", "inch", "inches", "in", "mil", "mils"),
    *("thou", "cm", "мм", "мкм"),
}
_UNITS = "|".join(sorted(_TRAILING_UNITS, key=len, reverse=True))
# "1/100 mm" is a unit; "0.01 mm" is one, or what the gauge shows: no unit is stated then
_TRAILING_FRACTION = re.compile(
    rf"[\s_,:;]+(1\s*[/\u2044]\s*10{{1,4}}\s*(?:{_UNITS})|0[.,]0*1\s*(?:{_UNITS}))\s*$", re.IGNORECASE
)
LETTERED = re.compile(r"(?<![^\W_])([dD])(?:[xyi]|\d{1,2})?(?![^\W_])")  # d of the spool, D of its bore


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
    column = _read_heading(text)
    return replace(column, index=index) if column is not None and index else column


@lru_cache(maxsize=4096)
def _read_heading(text: str) -> Column | None:
    rest, unit = split_unit(text)
    tokens = tokens_of(rest)
    words = set(tokens)
    if not words:
        return None
    of_land = _of_land(words, unit)
    if of_land is not None:
        return Column(0, text, of_land, unit=unit)
    named, rank = _role(words, rest, unit)
    part, side = _part(words, rest), side_of(rest)
    spot, others = spot_of_heading(tokens)
    role = _role_at_spot(named, others, unit) if spot.is_somewhere else _role_of_part(named, tokens, part, side, unit)
    if role is None:
        return None
    if role == "diameter" and None not in (part, side) and part != side:
        role = "quantity"  # the outer diameter of a sleeve, say
    if role not in {"diameter", "coordinate"}:
        return Column(0, text, role, unit=unit, rank=rank)
    coordinate, direction, repeat = numbers_of_heading(role, others)
    standing: Literal["raw", "corrected"] | None = (
        "corrected" if words & _CORRECTED else "raw" if words & _RAW else None
    )
    outcome = bool(words & _NOW) or (unit is None and bool(words & _OUTCOME))
    by_place = role != named and unit is None and not words & SIZES
    return Column(
        *(0, text, role, unit, coordinate, part or side, spot.direction if direction is None else direction),
        *(repeat, spot.land, spot.plane),
        otherwise=named if by_place else None,
        standing=standing,
        tentative=(outcome and not words & SIZES and repeat is None) or by_place or _is_bare_letter(rest, unit),
        besides=besides_numbers(others),
    )


def _is_bare_letter(text: str, unit: Unit | None) -> bool:
    return unit is None and LETTERED.fullmatch(text.strip()) is not None


def _role_at_spot(named: Role | None, others: Sequence[str], unit: Unit | None) -> Role | None:
    """Return what a heading is that says a land, plane or direction by its name: a diameter, or a figure of one.

    "Land" is the column of their numbers, "Land 1" may be a diameter there, and "Land 1 mean" is a mean.
    """
    if named not in (None, "plane", "land", "direction", "part", "component", "repeat"):
        return named
    if is_explained(others):
        return "coordinate" if set(others) & _COORDINATE else "diameter"
    of_others = _role(set(others), " ".join(others), unit)[0]
    return of_others if of_others in ("mean", "diameter", *SAYS_NOTHING) else named


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
    numbered_letter = text.strip()[1:].isdigit()  # "d1": of a diameter if its cells are
    simple: list[tuple[bool, Role]] = [
        (_is_earlier(words, sized or (bool(parts) and not key)) and not words & QUANTITIES, "specification"),
        (bool(words & _STANDING) and (sized or bool(words & READINGS) or len(words) == 1), "diameter"),
        (bool(words & _MEAN) or "x\u0304" in text or "x\u0305" in text, "mean"),
        (bool(words & QUANTITIES) and not words & SPECIFICATIONS, "quantity"),
        (bool(words & SPECIFICATIONS) and (sized or not key or bool(words & QUANTITIES)), "specification"),
        (bool(words & _SUM), "mean"),
        (bool(words & _REMARK) and not (words & _GAUGE and unit is not None), "remark"),
        (bool(words & _DIRECTION), "direction"),
        (bool(words & _PLANE), "plane"),
        (bool(words & _LAND) and (numbered or not diameter), "land"),
        (bool(words & _COORDINATE) or (len(axes) >= 1 and not both_ends(axes) and not diameter), "coordinate"),
        (diameter or both_ends(axes), "diameter"),
        (bool(words & COUNTED or words & _ACTUAL or words & _NOW) and unit is not None, "diameter"),
        (bool(words & COUNTED) and numbered and len(words) <= 3, "diameter"),
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
        (bool(LETTERED.fullmatch(text.strip())) and (unit is not None or numbered_letter), "diameter"),
        (all(is_angle(word) for word in words), "diameter"),
        (bool(words & _GAUGE) and unit is not None, "gauge"),
    ]
    for holds, role in simple:
        if holds:
            return role, 0
    return _component_rank(words)


def _is_earlier(words: set[str], sized: bool) -> bool:
    """Return whether a heading says what a diameter was, or was when new; a "standard" by itself is a gauge."""
    earlier = words & _EARLIER or (words & _NEW and (not words & READINGS or words & _WHEN))
    if not earlier or all(word in _GAUGE for word in words):
        return False
    return sized or all(word in _EARLIER or word in _NEW or word in _WHEN for word in words)


def _component_rank(words: set[str]) -> tuple[Role | None, int]:
    if words & READINGS or words & STATES:
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


def both_ends(axes: set[str]) -> bool:
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
    fraction = _TRAILING_FRACTION.search(text.replace("_", " "))
    if fraction:
        return text[: fraction.start()], find_unit(fraction[1], "length")
    trailing = re.search(r"[\s_,/:;]+(\S+?)\s*$", text.replace("_", " "))
    if trailing and trailing[1].lower() in _TRAILING_UNITS:
        return text[: trailing.start()], find_unit(trailing[1], "length")
    if text.strip().lower() in _TRAILING_UNITS - {"in"}:
        return "", find_unit(text, "length")
    return text, None
