"""Converts units as people and loggers write them to SI, by kind of quantity.

Each kind is its own table in ``units.toml``: a temperature is no temperature difference, a pressure no percentage. A
name that a table does not hold is refused, never guessed.
"""

from __future__ import annotations

import math
import re
import tomllib
import unicodedata
from collections.abc import Mapping
from dataclasses import dataclass
from importlib import resources
from typing import Any

from atleak.common.errors import unknown
from atleak.common.sentences import Sentence

HHMMSS = "HHMMSS"  # a clock's digits: 100059.5 is 10:00:59.5. No factor makes seconds of them: a log's clock is read so


@dataclass(frozen=True)
class Unit:
    """A unit: ``si = value · factor + offset``."""

    name: str  # as people write it
    factor: float  # SI for one of it
    offset: float = 0.0  # SI at its zero

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


UNIT_KINDS: Mapping[str, Sentence] = {  # as sentences name them
    "length": Sentence("length"),
    "pressure": Sentence("pressure"),
    "temperature": Sentence("temperature"),
    "rotational_speed": Sentence("rotational speed"),
    "speed": Sentence("speed"),
    "time": Sentence("time"),
    "ratio": Sentence("ratio"),
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


_LISTED = tomllib.loads(resources.files(__package__).joinpath("units.toml").read_text(encoding="utf-8"))
_KINDS = {
    kind: [Unit(name, each["factor"], each.get("offset", 0.0)) for name, each in units.items()]
    for kind, units in _LISTED.items()
}
_TABLE: dict[str, dict[str, Unit]] = {
    kind: {_spelling(alias): unit for unit in units for alias in _LISTED[kind][unit.name]["spellings"]}
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
    """Return a unit.

    Parameters
    ----------
    name
        as people write it.
    kind
        of quantity: ``length``, ``pressure`` …

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
