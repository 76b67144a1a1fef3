"""What a single heading says of its column.

That of a diameter also says land, plane, direction, repeat, coordinate, or something else: by its words and numbers.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Literal

from atleak.catalogue.instruments import Part
from atleak.common.units import Unit, find_unit
from atleak.readers.sheets.words import ORDINALS, Words, direction_of, part_of, plain, sheet_vocabulary, side_of

_EXPLAINED = (
    *("repeat", "reading", "actual", "diameter", "coordinate", "number", "direction", "outer", "inner", "dimension"),
    *("land", "plane", "repeated"),
)  # what words of a heading may say of the place and the repeat of a diameter
_BESIDE_A_PART = {"of", "the", "der", "des", "du", "de", "la", "l", "le", "del", "at", "in", "an", "am"}
_ENDS = {"x1", "x2", "y1", "y2"}
_DIRECTED = {"x": 0.0, "dx": 0.0, "x-x": 0.0, "a-a": 0.0, "y": 90.0, "dy": 90.0, "y-y": 90.0, "b-b": 90.0}
_AXES = _ENDS | {"i", "ii", *_DIRECTED}
_ROMAN = {"i": "1", "ii": "2", "iii": "3", "iv": "4"}
_SAY_NO_MORE = ORDINALS | _AXES | {*_ROMAN, *_BESIDE_A_PART, "od", "id", "o", "clock", "uhr"}
_MOST_REPEATS = 30
_PLAIN_ANGLES = {"0", "90"}  # behind the word for the diameter also without "°"


_TOKEN = re.compile(
    r"(?<![^\W_])(?:x-x|y-y|a-a|b-b)(?![^\W_])|(?:12-6|6-12|3-9|9-3)(?=\s*(?:o'?\s?clock|uhr|godz|h\b))"
    r"|\d+(?:°|deg\b)|[ø⌀φ#]|[^\W\d_øφ]+\d*|\d+"
)
_COMPOUND = re.compile(r"(\w{4,}?)(durchmesser|durchm|mass)")


@lru_cache(maxsize=4096)
def tokens_of(text: str) -> Words:
    """Return the words and numbers of a heading without its unit; of a compound that names a part its two words.

    >>> tokens_of("Hülsendurchmesser 2"), tokens_of("Solldurchmesser"), tokens_of("Ø A-A")
    (('hulsen', 'durchmesser', '2'), ('solldurchmesser',), ('ø', 'a-a'))
    """
    return Words(word for token in _TOKEN.findall(plain(text).replace("_", " ")) for word in _halves(token))


def _halves(word: str) -> tuple[str, ...]:
    match = _COMPOUND.fullmatch(word)
    if match is None:
        return (word,)
    first = match[1]
    for singular in (first, first.removesuffix("s"), first.removesuffix("en"), first.removesuffix("n")):
        if part_of(singular) is not None or singular in {"aussen", "innen"}:
            return singular, match[2]
    return (word,)


def spot_of_heading(tokens: Sequence[str]) -> tuple[dict[str, str], Words]:
    """Return where a heading says that its diameters were taken: land, plane, direction by name; and its other words.

    >>> spot_of_heading(["spool", "land", "2"]), spot_of_heading(["2", "ebene", "ø"])
    (({'land': '2'}, ('spool',)), ({'plane': '2'}, ('ø',)))
    """
    words = [token for token in tokens if token not in ORDINALS]
    spot: dict[str, str] = {}
    others: list[str] = []
    at = 0
    while at < len(words):
        glued = re.fullmatch(r"([^\W\d]+)(\d{1,2})", words[at])
        kind = _kind(glued[1] if glued else words[at])
        step = 2 if at + 1 < len(words) and words[at + 1] in sheet_vocabulary("number") else 1
        name = glued[2] if glued else words[at + step] if at + step < len(words) else ""
        if kind is not None and kind not in spot and _names_spot(name, kind):
            spot[kind] = _ROMAN.get(name, name)
            at += 1 if glued else step + 1
        elif kind in ("land", "plane") and kind not in spot and others and others[-1].isdigit():
            spot[kind] = others.pop()
            at += 1
        else:
            others.append(words[at])
            at += 1
    return spot, Words(others)


def _kind(word: str) -> str | None:
    if word == "l":
        return "land"
    return next((kind for kind in ("land", "plane", "direction") if word in sheet_vocabulary(kind)), None)


def _names_spot(name: str, kind: str) -> bool:
    if kind == "direction":
        return direction_of(name) is not None
    return bool(re.fullmatch(r"\d{1,2}|[a-h]", name)) or name in _ROMAN


def is_explained(tokens: Iterable[str]) -> bool:
    """Return whether words say only of which part and place a diameter is, and which repeat."""
    return all(
        token in sheet_vocabulary(*_EXPLAINED)
        or token in _SAY_NO_MORE
        or token.isdigit()
        or is_angle(token)
        or part_of(token) is not None
        or direction_of(token) is not None
        for token in tokens
    )


def numbers_of_heading(role: str, tokens: Sequence[str]) -> tuple[int | None, float | None, int | None]:
    """Return coordinate 1 or 2, direction [°] and repeat from the words of a value's heading.

    A number is a repeat behind a word for one or beside the word for the diameter. In front of a unit, in a date, or
    behind any other word it says something else: a mileage, a temperature, a vehicle.

    >>> numbers_of_heading("diameter", ["diameter", "2"]), numbers_of_heading("diameter", ["diameter", "50", "km"])
    ((None, None, 2), (None, None, None))
    """
    repeat, beside = _counted(tokens)
    coordinate = None
    if role == "coordinate":
        ends = {token[1] for token in tokens if token in _ENDS}
        coordinate = int(ends.pop()) if len(ends) == 1 else beside.pop(0) if beside else None
    if repeat is None:  # "spool, repeated" stands beside "spool"
        repeat = beside[0] if beside else 2 if Words(tokens).any("repeated") else None
    directions = directions_in(role, tokens)
    return coordinate, directions[0] if len(directions) == 1 else None, repeat


_SAYS_ANGLE: tuple[Callable[[str, str, str], bool], ...] = (  # of a word, by those around it; the surest first
    lambda _, word, after: is_angle(word) and after not in sheet_vocabulary("before_unit"),
    lambda before, word, after: (
        word in _PLAIN_ANGLES
        and after not in sheet_vocabulary("before_unit")
        and (before in sheet_vocabulary("of_size") or part_of(before) is not None)
    ),
    lambda _, word, __: "-" in word or (word.isalpha() and len(word) > 3),
)


def directions_in(role: str, tokens: Sequence[str]) -> list[float]:
    """Return the directions [°] that a value's heading names, each once."""
    angles = [word for holds in _SAYS_ANGLE for before, word, after in _around(tokens) if holds(before, word, after)]
    directions = [angle for word in angles if (angle := direction_of(word)) is not None]
    axes_at = [(before, word) for before, word, _ in _around(tokens) if role == "diameter" and word in _DIRECTED]
    directions += [_DIRECTED[word] for before, word in axes_at if not before.isdigit()]  # "3 x"
    axes = {token[0] for token in tokens if token in _ENDS}
    directions += [0.0 if axes == {"x"} else 90.0] if len(axes) == 1 else []
    return list(dict.fromkeys(directions))


def _counted(tokens: Sequence[str]) -> tuple[int | None, list[int]]:
    repeat = None
    beside: list[int] = []
    for before, token, after in _numbered(tokens):
        glued = re.fullmatch(r"([^\W\d]+)(\d+)", token)
        word, number = (glued[1], int(glued[2])) if glued else (before, int(token))
        another = after in sheet_vocabulary("before_unit") or after[:1].isdigit() or before.isdigit()
        if another or not 0 < number <= _MOST_REPEATS:
            continue
        if word in sheet_vocabulary("repeat", "of_reading") or word in {"#", "r"}:
            repeat = number if repeat is None else repeat
        elif word in sheet_vocabulary("of_size") or _may_be_numbered(word, after):
            beside.append(number)
    return repeat, beside


def besides_numbers(words: Iterable[str]) -> frozenset[str]:
    """Return the words of a value's heading that say neither what it is nor of which part, and numbers of no repeat."""
    return frozenset(
        word
        for word in words
        if (word.isdigit() and int(word) > _MOST_REPEATS)
        or (
            word.isalpha()
            and len(word) > 1
            and not (word in sheet_vocabulary(*_EXPLAINED) or word in ORDINALS or word in _AXES or word in _ROMAN)
            and part_of(word) is None
        )
    )


def is_angle(word: str) -> bool:
    return re.fullmatch(r"\d+(?:°|deg)", word) is not None


def _around(tokens: Sequence[str]) -> Iterator[tuple[str, str, str]]:
    return zip(("", *tokens), tokens, (*tokens[1:], ""), strict=False)


def _numbered(tokens: Sequence[str]) -> Iterator[tuple[str, str, str]]:
    """Yield each number with the word before it, past "no.", and the word behind it, past "st" and "nd"."""
    words = [
        token for token in tokens if (token not in sheet_vocabulary("number") or token == "#") and token not in ORDINALS
    ]
    words = [
        _ROMAN[token] if token in _ROMAN and before in sheet_vocabulary("repeat", "of_reading") else token
        for before, token, _ in _around(words)
    ]
    for before, token, after in _around(words):
        if token.isdigit() or (re.fullmatch(r"[^\W\d]+\d+", token) and token not in _AXES):
            yield before, token, after


def _may_be_numbered(word: str, after: str) -> bool:
    """Return whether a part, a direction, or nothing stands before the word for the diameter: "1. diameter"."""
    if word == "":
        return after in sheet_vocabulary("diameter", "repeat", "of_reading") or part_of(after) is not None
    return (
        (part_of(word) is not None and word not in sheet_vocabulary("part_or_other")) or word in _AXES or is_angle(word)
    )


Role = Literal[
    "component", "part", "plane", "land", "direction", "repeat", "unit", "diameter", "coordinate", "mean",
    "raw", "specification", "quantity", "remark", "gauge", "contact length", "position", "fitted repair",
]  # fmt: skip
KEYS: tuple[Role, ...] = ("component", "part", "plane", "land", "direction", "repeat")
OF_LANDS: tuple[Role, ...] = ("contact length", "position", "fitted repair")  # of a land itself, beside its diameters
SAYS_NOTHING: tuple[Role, ...] = ("raw", "specification", "quantity", "remark", "gauge", *OF_LANDS)

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
class HeadedColumn:
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
    def station(self) -> tuple[Part | None, float | None, str | None, str | None]:
        """Return what the columns of one place and its repeats have in common."""
        return self.part, self.direction, self.land, self.plane

    @property
    def group(self) -> tuple[object, ...]:
        """Return what the columns that make one diameter have in common."""
        return *self.station, self.repeat


def read_heading(text: str, index: int = 0) -> HeadedColumn | None:
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
def _read_heading(text: str) -> HeadedColumn | None:
    heading = _Heading(*unit_of_heading(text))
    (spot, others), side = spot_of_heading(tokens_of(heading.text)), side_of(heading.text)
    role = _of_land(heading) or (_role_at_spot(heading, others) if spot else _role_of_part(heading))
    if role is None:
        return None
    if role == "diameter" and None not in (heading.part, side) and heading.part != side:
        role = "quantity"  # the outer diameter of a sleeve, say
    if role not in {"diameter", "coordinate"}:
        rank = _rank(heading.words) if role == "component" else 0
        return HeadedColumn(0, text, role, unit=heading.unit, rank=rank)
    coordinate, direction, repeat = numbers_of_heading(role, others)
    by_place = role != heading.role and heading.unit is None and not heading.says("of_size")
    is_outcome = heading.is_outcome and repeat is None
    return HeadedColumn(
        *(0, text, role, heading.unit, coordinate, heading.part or side),
        direction=direction_of(spot.get("direction", "")) if direction is None else direction,
        repeat=repeat,
        land=spot.get("land"),
        plane=spot.get("plane"),
        otherwise=heading.role if by_place else None,
        standing="corrected" if heading.says("corrected") else "raw" if heading.says("raw") else None,
        tentative=is_outcome or by_place or (heading.unit is None and heading.is_letter),
        besides=besides_numbers(others),
    )


def _role_at_spot(heading: _Heading, others: Words) -> Role | None:
    """Return what a heading is that says a land, plane or direction by its name: a diameter, or a figure of one.

    "Land" is the column of their numbers, "Land 1" may be a diameter there, and "Land 1 mean" is a mean.
    """
    if heading.role not in (None, "plane", "land", "direction", "part", "component", "repeat"):
        return heading.role
    if is_explained(others):
        return "coordinate" if others.any("coordinate") else "diameter"
    of_others = _Heading(" ".join(others), heading.unit).role
    return of_others if of_others in ("mean", "diameter", *SAYS_NOTHING) else heading.role


def _role_of_part(heading: _Heading) -> Role | None:
    """Return what a heading is that names a part: a diameter too, where it says a direction or repeat besides."""
    named, part, side, tokens = heading.role, heading.part, side_of(heading.text), tokens_of(heading.text)
    alone, explained = part is None and heading.unit is None, is_explained(tokens)
    if side is not None and part in (None, side) and explained and (named is None or not alone):
        return "diameter" if named in (None, "component") else named
    if named is not None or alone or not explained or (part is None and not set(tokens).isdisjoint("xy")):
        return named
    return "diameter" if any(number is not None for number in numbers_of_heading("diameter", tokens)) else None


def _of_land(heading: _Heading) -> Role | None:
    """Return what a heading says of a land itself; only where it says so and nothing else.

    A plain "position" is as often the number of a row, or the depth at which a diameter was measured.

    >>> read_heading("Contact length [mm]").role, read_heading("Contact length tolerance [mm]").role
    ('contact length', 'specification')
    """
    says, only = heading.says, heading.words.only
    contact = says("contact_length") or (says("contact") and says("length"))
    if contact and only("contact_length", "contact", "length", "beside_contact_length", "of_reading"):
        return "contact length"
    placed = heading.unit is not None and says("axial_position") and says("left")
    if placed and only("axial_position", "left", "beside_position", "of_reading"):
        return "position"
    return "fitted repair" if says("fitted") and says("repair") and only("fitted", "repair") else None


@dataclass(frozen=True)
class _Heading:
    text: str
    unit: Unit | None

    @cached_property
    def words(self) -> Words:
        return Words(dict.fromkeys(tokens_of(self.text)))

    def says(self, *meanings: str) -> bool:
        return self.words.any(*meanings)

    @cached_property
    def parts(self) -> set[Part]:
        return {part for word in self.words if len(word) > 2 and (part := part_of(word)) is not None}

    @cached_property
    def axes(self) -> set[str]:
        return {"x1", "x2", "y1", "y2"}.intersection(self.words)

    @property
    def sized(self) -> bool:
        return self.says("diameter") or self.unit is not None

    @property
    def is_key(self) -> bool:
        return self.says("direction", "plane", "land", "repeat", "component", "part", "number")

    @property
    def is_numbered(self) -> bool:
        return any(re.fullmatch(r"\d+", word) for word in self.words)

    @property
    def is_letter(self) -> bool:
        return LETTERED.fullmatch(self.text.strip()) is not None

    @property
    def is_earlier(self) -> bool:
        """Return whether it says what a diameter was, or was when new; a "standard" by itself is a gauge."""
        when_new = self.says("new") and (not self.says("of_reading") or self.says("when"))
        if not (self.says("earlier") or when_new) or self.words.only("gauge") or self.says("of_quantity"):
            return False
        return self.sized or (bool(self.parts) and not self.is_key) or self.words.only("earlier", "new", "when")

    @property
    def says_now_alone(self) -> bool:
        now = self.says("actual", "now")
        return now and all(part_of(word) for word in self.words.but("of_reading", "now", "when"))

    @property
    def is_outcome(self) -> bool:
        outcome = self.says("now") or (self.unit is None and self.says("actual", "corrected", "raw"))
        return outcome and not self.says("of_size")

    @cached_property
    def part(self) -> Part | None:
        letter = part_of(self.text.strip())
        if letter is not None and len(self.text.strip()) <= 2:
            return letter
        return next(iter(self.parts)) if len(self.parts) == 1 else None

    @cached_property
    def role(self) -> Role | None:
        stated = next((role for role, holds in _RULES if holds(self)), None)
        return stated or ("component" if _rank(self.words) else None)


_RULES: tuple[tuple[Role, Callable[[_Heading], bool]], ...] = (
    ("specification", lambda it: it.is_earlier),
    ("diameter", lambda it: it.says("corrected", "raw") and (it.sized or it.says("of_reading") or len(it.words) == 1)),
    ("mean", lambda it: it.says("mean", "mean_in_heading") or "x\u0304" in it.text or "x\u0305" in it.text),
    ("quantity", lambda it: it.says("of_quantity") and not it.says("of_specification")),
    ("specification", lambda it: it.says("of_specification") and (it.sized or not it.is_key or it.says("of_quantity"))),
    ("mean", lambda it: it.says("sum")),
    ("remark", lambda it: it.says("remark") and not (it.says("gauge") and it.unit is not None)),
    ("direction", lambda it: it.says("direction")),
    ("plane", lambda it: it.says("plane")),
    ("land", lambda it: it.says("land") and (it.is_numbered or not it.says("diameter"))),
    ("coordinate", lambda it: it.says("coordinate")),
    ("coordinate", lambda it: bool(it.axes) and not both_ends(it.axes) and not it.says("diameter")),
    ("diameter", lambda it: it.says("diameter") or both_ends(it.axes)),
    ("diameter", lambda it: it.says("of_repeat", "actual", "now") and it.unit is not None),
    ("diameter", lambda it: it.says("of_repeat") and it.is_numbered and len(it.words) <= 3),
    ("diameter", lambda it: it.says("repeated") and len(it.parts) == len(it.words.but("repeated")) == 1),
    ("repeat", lambda it: it.says("repeat")),
    ("diameter", lambda it: bool({"value", "reading"}.intersection(it.words))),
    ("unit", lambda it: it.says("unit") and not it.sized and not it.says("head_serial")),
    ("part", lambda it: it.says("part") and not it.says("number")),
    ("part", lambda it: len(it.parts) == 2 and it.unit is None),
    ("diameter", lambda it: it.says_now_alone),
    ("diameter", lambda it: len(it.parts) == 1 and it.unit is not None),
    ("diameter", lambda it: len(it.parts) == len(it.words) == 1 and not it.says("component")),
    # "d1" is of a diameter if its cells are
    ("diameter", lambda it: it.is_letter and (it.unit is not None or it.text.strip()[1:].isdigit())),
    ("diameter", lambda it: bool(it.words) and all(map(is_angle, it.words))),
    ("gauge", lambda it: it.says("gauge") and it.unit is not None),
)


def _rank(words: Words) -> int:
    """Return how surely a heading is that of a column of components; 0 where it is none."""
    if words.any("of_reading", "state"):
        return 0  # a measurement, vehicle or inspection by its number
    if words.any("name"):
        return 1
    if words.any("component"):
        return 4 if words.any("number") else 3
    if words.any("number") and words.any("figure"):
        return 4
    return 2 if words.any("number", "generic") and len(words.but("number", "generic")) <= 1 else 0


def both_ends(axes: set[str]) -> bool:
    return {"x1", "x2"} <= axes or {"y1", "y2"} <= axes


@lru_cache(maxsize=4096)
def unit_of_heading(text: str) -> tuple[str, Unit | None]:
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
