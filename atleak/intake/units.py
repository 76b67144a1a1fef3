"""Converts units as people and loggers write them to SI, by kind of quantity.

Each kind is its own table: a temperature is no temperature difference, a pressure no percentage. A name that a
table does not hold is refused, never guessed.
"""

from __future__ import annotations

import math
import re
import unicodedata
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from atleak.errors import unknown
from atleak.sentence import Sentence
from atleak.workshop_units import INCH, PSI

HHMMSS = "HHMMSS"


@dataclass(frozen=True)
class Unit:
    """A unit: ``si = value · factor + offset``."""

    name: str
    factor: float
    offset: float = 0.0

    @property
    def said(self) -> str:
        """Return its name in a sentence: one that is a word has other words in other languages."""
        return Sentence("inch") if self.name == "inch" else self.name

    def to_si(self, value: Any) -> Any:
        """Convert a value or array in this unit to SI."""
        return value * self.factor + self.offset if self.offset else value * self.factor

    def from_si(self, value: Any) -> Any:
        """Convert an SI value or array to this unit."""
        return (value - self.offset) / self.factor if self.offset else value / self.factor


_KINDS: dict[str, dict[Unit, tuple[str, ...]]] = {
    "length": {
        Unit("mm", 1e-3): ("mm", "millimetre", "millimeter", "мм"),
        Unit("µm", 1e-6): ("µm", "um", "micron", "microns", "micrometre", "micrometer", "mkm", "мкм"),
        Unit("inch", INCH): ("inch", "in", "inches", '"', "zoll", "cal"),
        Unit("mil", INCH / 1000): ("mil", "thou"),
        Unit("0.0001 in", INCH / 10000): ("0.0001 in", "0,0001 in"),
        Unit("cm", 1e-2): ("cm",),
        Unit("m", 1.0): ("m",),
    },
    "pressure": {
        Unit("kPa", 1e3): ("kpa", "kpag", "кпа", "kilopascal"),
        Unit("bar", 1e5): ("bar", "barg", "bars", "бар"),
        Unit("mbar", 1e2): ("mbar", "hpa", "millibar"),
        Unit("MPa", 1e6): ("mpa", "мпа"),
        Unit("psi", PSI): ("psi", "psig", "lbf/in2", "lb/in2", "psi(g)", "pounds per square inch"),
        Unit("Pa", 1.0): ("pa",),
        Unit("0.1 kPa", 1e2): ("0.1 kpa",),
        Unit("kgf/cm²", 98066.5): ("kgf/cm2", "kg/cm2", "кгс/см2"),
    },
    "temperature": {
        Unit("°C", 1.0): (
            "°c",
            "c",
            "degc",
            "deg c",
            "*c",
            "celsius",
            "grad c",
            "º c",
            "ºc",
            "° c",
            "°с",
            "grad",
            "degrees c",
            "celcius",
            "deg. c",
            "c°",
            "â°c",
            "�c",
            "��c",
            "¡æ",
            "gr c",
            ".c",
        ),
        Unit("°F", 5.0 / 9.0, -160.0 / 9.0): (
            "°f",
            "f",
            "degf",
            "deg f",
            "*f",
            "fahrenheit",
            "ºf",
            "° f",
            "degrees f",
            "deg. f",
            "f°",
            ".f",
            "â°f",
            "�f",
        ),
        Unit("K", 1.0, -273.15): ("k", "kelvin"),
        Unit("0.1 K", 0.1, -273.15): ("0.1 k",),
    },
    "rotational_speed": {
        Unit("rpm", 1.0 / 60.0): (
            "rpm",
            "1/min",
            "/min",
            "u/min",
            "min-1",
            "min^-1",
            "r/min",
            "rev/min",
            "revs/min",
            "obr/min",
            "obr./min",
            "ob/min",
            "об/мин",
            "tr/min",
            "t/min",
            "rpms",
            "1/minute",
            "upm",
        ),
        Unit("1000 rpm", 1000.0 / 60.0): (
            "1000 rpm",
            "rpm x1000",
            "x1000 rpm",
            "rpm*1000",
            "krpm",
            "1000/min",
        ),
        Unit("1/s", 1.0): ("1/s", "rps", "hz"),
        Unit("rad/s", 0.15915494309189535): ("rad/s",),
    },
    "speed": {
        Unit("km/h", 1.0 / 3.6): (
            "km/h",
            "kph",
            "kmh",
            "kmph",
            "km/hr",
            "км/ч",
            "kilometers/hour",
            "kilometres/hour",
        ),
        Unit("mph", 0.44704): ("mph", "mi/h", "miles/h", "miles/hour", "mile/h"),
        Unit("0.1 km/h", 1.0 / 36.0): ("0.1 km/h",),
        Unit("m/s", 1.0): ("m/s", "mps", "meters/second", "metres/second", "meter/s", "м/с"),
    },
    "time": {
        Unit("s", 1.0): (
            "s",
            "sec",
            "secs",
            "sec.",
            "second",
            "seconds",
            "sek",
            "sek.",
            "sekunden",
            "с",
            "сек",
            "сек.",
            "seg",
        ),
        Unit("ms", 1e-3): ("ms", "msec", "msecs", "millisecond", "milliseconds", "millis", "мс"),
        Unit("µs", 1e-6): ("µs", "us", "usec", "microsecond", "microseconds"),
        Unit("min", 60.0): ("min", "minute", "minutes"),
        Unit("h", 3600.0): ("h", "hour", "hours"),
        Unit("ns", 1e-9): ("ns", "nsec", "nanosecond", "nanoseconds"),
        Unit("d", 86400.0): ("d", "day", "days"),
        # a clock's digits: 100059.5 is 10:00:59.5. No factor makes seconds of them: the clock of a log is read so
        Unit(HHMMSS, 1.0): ("hhmmss", "hhmmss.s", "hhmmss.ss", "hhmmss.sss"),
    },
    "ratio": {
        Unit("1", 1.0): ("1", "-", "ratio", ""),
        Unit("%", 1e-2): ("%", "percent"),
    },
}
_UNKNOWN = {
    "length": Sentence("unknown unit of length"),
    "pressure": Sentence("unknown unit of pressure"),
    "temperature": Sentence("unknown unit of temperature"),
    "rotational_speed": Sentence("unknown unit of rotational speed"),
    "speed": Sentence("unknown unit of speed"),
    "time": Sentence("unknown unit of time"),
    "ratio": Sentence("unknown unit of ratio"),
}


def _spelling(name: str) -> str:
    # NFKC turns ℃ into °C, the micro sign and Greek mu into one letter, superscripts into digits
    text = unicodedata.normalize("NFKC", name).strip().lower().replace("μ", "µ").replace("\u2212", "-")
    return re.sub(r"\s+", " ", text)


_TABLE: dict[str, dict[str, Unit]] = {
    kind: {_spelling(alias): unit for unit, aliases in units.items() for alias in aliases}
    for kind, units in _KINDS.items()
}


def find_unit(name: str, kind: str) -> Unit | None:
    """Return the unit of that kind with that name, or None; of lengths also a decimal fraction of one.

    >>> find_unit("℃", "temperature").name
    '°C'
    >>> find_unit("%", "pressure") is None
    True
    >>> find_unit("1/100 mm", "length"), find_unit("1/1000mm", "length").name
    (Unit(name='1/100 mm', factor=1e-05, offset=0.0), 'µm')
    """
    known = _TABLE[kind].get(_spelling(name))
    return _fraction(_spelling(name)) if known is None and kind == "length" else known


_FRACTION = re.compile(r"1\s*[/\u2044]\s*(10{1,4})\s*(\D+)")


def _fraction(spelling: str) -> Unit | None:
    """Return a tenth to a ten-thousandth of a unit of length: a unit of its own, or one that is as large."""
    match = _FRACTION.fullmatch(spelling)
    whole = _TABLE["length"].get(match[2]) if match else None
    if match is None or whole is None:
        return None
    factor = whole.factor / int(match[1])
    alike = (each for each in _KINDS["length"] if math.isclose(each.factor, factor, rel_tol=1e-9))
    return next(alike, Unit(f"1/{match[1]} {whole.name}", factor))


def unit(name: str, kind: str) -> Unit:
    """Return the unit of that kind with that name, as `find_unit`, but refuse an unknown name.

    Raises
    ------
    InputError
        for an unknown name; it lists the units of that kind and the nearest one.
    """
    match = find_unit(name, kind)
    if match is None:
        raise unknown(_UNKNOWN[kind], name, unit_names(kind))
    return match


def unit_names(kind: str) -> list[str]:
    """Return the usual names of a kind's units, the most common unit first."""
    return [each.name for each in _KINDS[kind]]


def kinds_of(name: str) -> list[str]:
    """Return every kind that has a unit of that name: ``"m"`` is a length only, ``"min"`` a time."""
    return [kind for kind in _TABLE if find_unit(name, kind)]


KINDS: Mapping[str, Sentence] = {  # as sentences name them
    "length": Sentence("length"),
    "pressure": Sentence("pressure"),
    "temperature": Sentence("temperature"),
    "rotational_speed": Sentence("rotational speed"),
    "speed": Sentence("speed"),
    "time": Sentence("time"),
    "ratio": Sentence("ratio"),
}
