"""Give words and numbers in a reader's language and units."""

from __future__ import annotations

import datetime as dt
import math
import re
import unicodedata
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from decimal import Decimal
from functools import cache
from gettext import NullTranslations
from typing import Any, Protocol, runtime_checkable

from atleak.common.errors import AtleakError, Place
from atleak.common.sentences import Listed, Name, Sentence, filled
from atleak.common.style import look_of
from atleak.common.translations import Text, catalogue, english
from atleak.common.units import PERCENT, RPM, Quantity, ShownUnit, UnitOf, gear_name, unit_system
from atleak.common.verdicts import Band, Verdict

_PLACE = re.compile(r"\{(\w+)\}")
_UNIT = "unit_"  # begins a place that holds the reader's unit of a kind of quantity
_FIXED = re.compile(r",?\.(\d)f")  # how a place of a sentence asks for decimal places
_FROM_THE_RIGHT = ("R", "AL", "AN")  # Unicode's classes of letters and digits
_NARROW = "\u00a0"  # between thousands, and between a number and its unit: no line breaks there


def isolated(text: str) -> str:
    r"""Mark a text from right to left, so that it leaves the order of the text around it.

    Without this, a number between hyphens beside an Arabic name is shown with its parts exchanged.

    >>> isolated("2026-0417"), isolated("שלום").encode("unicode_escape")
    ('2026-0417', b'\\u2068\\u05e9\\u05dc\\u05d5\\u05dd\\u2069')
    """
    from_the_right = any(unicodedata.bidirectional(letter) in _FROM_THE_RIGHT for letter in text)
    return f"\u2068{text}\u2069" if from_the_right else text


def joined(parts: Iterable[str], between: str = ", ") -> str:
    """Join the parts that are not empty; each keeps its own direction of writing."""
    return between.join(isolated(part) for part in parts if part)


def begun(sentence: str) -> str:
    """Begin a sentence with a capital letter.

    >>> begun("it is stated"), begun("")
    ('It is stated', '')
    """
    return sentence[:1].upper() + sentence[1:]


@runtime_checkable
class _Condition(Protocol):
    """What is named of an operating point."""

    @property
    def name(self) -> str:
        """How files refer to it."""

    @property
    def is_stated(self) -> bool:
        """Whether a person stated it, so that it has no name of its own."""

    @property
    def label(self) -> str:
        """How its file words it, in English and °C."""

    @property
    def temperature(self) -> float:
        """The temperature of the fluid [°C]."""

    @property
    def engine_speed(self) -> float:
        """The speed of the engine [1/s]."""

    @property
    def gear(self) -> int:
        """The gear that is engaged."""


@dataclass(frozen=True, eq=False)
class Wording:
    """The texts of one language, and a system of units; there is one of each pair."""

    language: str
    catalogue: NullTranslations
    units: str
    system: Mapping[str, ShownUnit]
    _tables: dict[str, Mapping[str, str]] = field(default_factory=dict, repr=False)

    def __call__(self, key: str, /, **values: Any) -> str:
        """Return the text of a dotted key, its ``{places}`` filled in, ``{unit_pressure}`` with the reader's unit.

        A place may be given a `Quantity`, which is written in the reader's unit. A text with plural forms takes the one
        of ``count``, and writes it as a number.

        Raises
        ------
        KeyError
            if there is no text of this key.
        """
        table, _, name = key.partition(".")
        text = english()[table][name]
        if text.several:
            template = text.translated(self.catalogue, values["count"])
            values["count"] = self.number(values["count"], 0)
        else:
            template = self.table(table)[name]
        return _PLACE.sub(lambda match: self._filled(match[1], values), template)

    def _filled(self, place: str, values: Mapping[str, object]) -> str:
        if place not in values and place.startswith(_UNIT):
            return self.unit(place.removeprefix(_UNIT))
        value = values[place]
        return self.value(*value) if isinstance(value, Quantity) else isolated(self.sentence(value))

    def table(self, name: str) -> Mapping[str, str]:
        """Return the texts of one table in the reader's language, by key."""
        if name not in self._tables:
            self._tables[name] = {key: text.translated(self.catalogue) for key, text in english()[name].items()}
        return self._tables[name]

    def get(self, table: str, name: str) -> str:
        """Return the text for a name, or the name itself where no text is known for it."""
        return self.table(table).get(name, name)

    def name(self, name: str, context: str = "name") -> str:
        """Return a name in the reader's language: a valve's, a circuit's, an operating point's.

        Those of the shipped files are known, and in the context ``form`` the headings of the forms in which such files
        are typed; any other stays as it is, were it a word of the program.
        """
        return Text(name, context=context).translated(self.catalogue)

    def condition(self, point: _Condition) -> str:
        """Return the name of an operating point in the reader's language and unit."""
        if self.as_filed:
            return point.label
        temperature = self.plain_value(point.temperature, "temperature")
        if point.is_stated:
            speed = self.number(point.engine_speed * RPM, 0)
            return self("conditions.stated", gear=gear_name(point.gear), temperature=temperature, speed=speed)
        stated, name = f", {point.temperature:g} °C", self.name(point.label)
        if name == point.label and self.language != "en" and point.name in self.table("conditions"):
            name = self(f"conditions.{point.name}") + stated
        if name.endswith(stated):
            name = self("conditions.at", name=name.removesuffix(stated), temperature=temperature)
        return name.replace(" °", f"{_NARROW}°")

    @property
    def as_filed(self) -> bool:
        """Whether language and unit of the temperature are those of the catalogue's files."""
        return self.language == "en" and self.unit("temperature") == "°C"

    def sentence(self, said: object) -> str:
        """Return a sentence of the program in the reader's language and units; any other text as it is.

        Parameters
        ----------
        said
            an `atleak.common.sentences.Sentence`, such as the text of a message, or an error or a place, which have
            one.
        """
        if isinstance(said, AtleakError | Place):
            said = said.sentence
        if not isinstance(said, Sentence) or (self.language == "en" and self.units == "metric"):
            return str(said)
        return filled(
            said.translated(self.catalogue), {name: _spoken(value, self) for name, value in said.values.items()}
        )

    @property
    def decimal(self) -> str:
        """The language's decimal sign."""
        return self.table("language")["decimal"]

    def level(self, level: Verdict | Band) -> str:
        """Return the word of a verdict or a band."""
        return self.table("bands" if isinstance(level, Band) else "verdicts")[level]

    def signed(self, level: Verdict | Band) -> str:
        """Return sign and word of a verdict or a band: ``■ replace``."""
        return f"{look_of(level).sign} {self.level(level)}"

    def number(self, value: float | None, digits: int) -> str:
        """Return a number with the language's decimal sign; a dash where there is none.

        >>> wording("de").number(-1234.5, 1)
        '−1\u00a0234,5'
        """
        if value is None or not math.isfinite(value):
            return "–"
        text = f"{value:,.{digits}f}".replace(",", _NARROW).replace(".", self.decimal)
        return text.replace("-", "−") if float(f"{value:.{digits}f}") != 0.0 else text.replace("-", "")

    def percent(self, fraction: float | None, digits: int = 1) -> str:
        """Return a fraction as a percentage with its sign."""
        return self.number(None if fraction is None else fraction * PERCENT, digits) + f"{_NARROW}%"

    def plain(self, value: float, digits: int = 6) -> str:
        """Return a number with no more digits than it has."""
        text = f"{value:.{digits}g}"
        text = f"{Decimal(text):f}" if "e" in text else text  # 0.00003937 in, not 3.937e-05
        return text.replace(".", self.decimal).replace("-", "−")

    def date(self, value: dt.date) -> str:
        """Return a date in the language's form; English has ISO 8601: its readers disagree about day and month."""
        day, month, year = f"{value.day:02d}", f"{value.month:02d}", f"{value.year:04d}"
        return self.table("language")["date"].format(day=day, month=month, year=year)

    def moment(self, value: dt.datetime) -> str:
        """Write a moment as this machine's clock shows it, to the minute."""
        here = value.astimezone()
        return f"{self.date(here.date())} {here:%H:%M}"

    def unit(self, kind: str) -> str:
        """Return the unit in which the reader has a kind of quantity: ``µm``."""
        return self.get("units", self.system[kind].name)

    def convert(self, value: Any, kind: str) -> Any:
        """Convert a value or array from the unit of atleak's records to the reader's."""
        return self.system[kind].shown(value)

    def back(self, value: Any, kind: str) -> Any:
        """Convert a value or array from the reader's unit to that of atleak's records."""
        return self.system[kind].carried(value)

    def digits(self, kind: str, digits: int | None = None) -> int:
        """Return the decimal places of a value in the reader's unit.

        ``digits`` are those that it would take in the unit of atleak's records; None for those that are usual.
        """
        return self.system[kind].places(digits)

    def value(self, value: float | None, kind: str, digits: int | None = None) -> str:
        """Return a value of atleak's records in the reader's unit, without naming it, as below a heading that does."""
        return self._in(self.system[kind], value, digits)

    def quantity(self, value: float | None, kind: str, digits: int | None = None) -> str:
        """Return a value of atleak's records in the reader's unit, with that unit.

        >>> wording("de").quantity(3.06, "clearance"), wording("en", "us").quantity(3.06, "clearance")
        ('3,1\u00a0µm', '0.00012\u00a0in')
        """
        return self.span([value], kind, digits)

    def span(self, values: Iterable[float | None], kind: str, digits: int | None = None) -> str:
        """Return values of atleak's records in the reader's unit, with that unit behind the last: ``15.0–18.0 µm``."""
        numbers = "–".join(self.spelled(value, kind, digits) for value in values)
        return f"{numbers}{_NARROW}{self.spelled_unit(kind)}"

    def spelled(self, value: float | None, kind: str, digits: int | None = None) -> str:
        """Return the number of `quantity` alone, for what stands beside one in a sentence."""
        return self._in(self._spelled(kind), value, digits)

    def plain_value(self, value: float, kind: str) -> str:
        """Return a value of atleak's records in the reader's unit with no more digits than it has, without the unit."""
        return self._plain_in(self.system[kind], value)

    def plain_quantity(self, value: float, kind: str) -> str:
        """Return a value of atleak's records in the reader's unit with no more digits than it has, with that unit."""
        return f"{self.plain_spelled(value, kind)}{_NARROW}{self.spelled_unit(kind)}"

    def plain_spelled(self, value: float, kind: str) -> str:
        """Return the number of `plain_quantity` alone."""
        return self._plain_in(self._spelled(kind), value)

    def spelled_unit(self, kind: str) -> str:
        """Return the unit in which the reader has a single quantity in a sentence."""
        return self.get("units", self._spelled(kind).name)

    def _spelled(self, kind: str) -> ShownUnit:
        return self.system[kind].spelled or self.system[kind]

    def _plain_in(self, unit: ShownUnit, value: float) -> str:
        return self.plain(unit.stated(value))

    def _in(self, unit: ShownUnit, value: float | None, digits: int | None) -> str:
        return self.number(None if value is None else unit.shown(value), unit.places(digits))


class _Spoken:
    """A value as a sentence in the reader's language writes it."""

    __slots__ = ("say", "value")

    def __init__(self, value: Any, say: Wording) -> None:
        self.value, self.say = value, say

    def __repr__(self) -> str:
        return repr(self.say.sentence(self.value) if isinstance(self.value, Sentence) else self.value)

    def __str__(self) -> str:
        return format(self, "")

    @property
    def unit(self) -> str:
        """The reader's unit of a quantity."""
        return self.say.spelled_unit(self.value.kind)

    def __format__(self, specification: str) -> str:
        value, say = self.value, self.say
        if isinstance(value, Sentence):
            return say.sentence(value)
        if isinstance(value, Name):
            return isolated(say.name(value))
        if isinstance(value, Verdict | Band):
            return say.level(value)
        if isinstance(value, Quantity):
            return self._quantity(value, specification)
        if isinstance(value, UnitOf):
            return say.unit(value.kind)
        if isinstance(value, float | int):
            return self._number(format(value, specification))
        if isinstance(value, _Condition):
            return isolated(say.condition(value))
        return isolated(format(value, specification))

    def _quantity(self, quantity: Quantity, specification: str) -> str:
        value, kind, digits = quantity
        if specification.endswith("g"):
            return self.say.plain_spelled(float(format(value, specification)), kind)
        places = _FIXED.fullmatch(specification)
        return self.say.spelled(value, kind, int(places[1]) if places else digits)

    def _number(self, written: str) -> str:
        return written.translate(str.maketrans(",.-", f"{_NARROW}{self.say.decimal}−"))


class _SpokenList(Listed):
    """Several values as a sentence writes them: semicolons between numbers that have a decimal comma."""

    __slots__ = ()

    def __format__(self, specification: str) -> str:
        comma = any(isinstance(each.value, Quantity | float) and each.say.decimal == "," for each in self.values)
        return ("; " if comma else ", ").join(format(each, specification) for each in self.values)


def _spoken(value: Any, say: Wording) -> Any:
    if type(value) in (tuple, list):
        return _SpokenList(type(value)(_Spoken(each, say) for each in value))
    return _Spoken(value, say)


def wording(language: str, units: str = "metric") -> Wording:
    """Return the texts of a language.

    A text that a language lacks is the English one.

    Parameters
    ----------
    language
        one of `atleak.common.translations.languages`.
    units
        system of units in which quantities are written: metric, metric_bar or us.

    Raises
    ------
    InputError
        if no text is written in that language, or there is no such system of units.
    """
    return _wording(language, units)


@cache
def _wording(language: str, units: str) -> Wording:
    return Wording(language, catalogue(language), units, unit_system(units))


def signed(level: Verdict | Band) -> str:
    """Return sign and English word of a verdict or a band: ``■ replace``."""
    return wording("en").signed(level)
