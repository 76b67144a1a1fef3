"""Convert units to SI and back: as people and loggers write them, and in the one system in which a reader sees them.

Each kind of quantity is its own table in ``units.toml``: a temperature is no temperature difference, a pressure no
percentage; a name that a table does not hold is refused, never guessed. Records, files and the engine's results keep
their own units (µm, mm, kPa, °C, dm³/min, km); what people read and type is metric, metric with bar and litres, or US,
converted here and nowhere else. Names in capitals are factors from SI: ``metres * UM`` are micrometres.
"""

from __future__ import annotations

import math
import re
import tomllib
import unicodedata
from collections.abc import Mapping
from dataclasses import dataclass
from importlib import resources
from typing import Any, NamedTuple

from atleak.common.errors import unknown
from atleak.common.sentences import Sentence

HHMMSS = "HHMMSS"  # a clock's digits: 100059.5 is 10:00:59.5. No factor makes seconds of them: a log's clock is read so
UNIT_KINDS: Mapping[str, Sentence] = {  # as sentences name them
    "length": Sentence("length"),
    "pressure": Sentence("pressure"),
    "temperature": Sentence("temperature"),
    "rotational_speed": Sentence("rotational speed"),
    "speed": Sentence("speed"),
    "time": Sentence("time"),
    "ratio": Sentence("ratio"),
    "area": Sentence("area"),
    "flow": Sentence("flow"),
    "volume": Sentence("volume"),
}
_IN_NO_LOG = {"area", "flow", "volume"}  # kinds by which no column of a log is known
_UNKNOWN = {
    "length": Sentence("unknown unit of length"),
    "pressure": Sentence("unknown unit of pressure"),
    "temperature": Sentence("unknown unit of temperature"),
    "rotational_speed": Sentence("unknown unit of rotational speed"),
    "speed": Sentence("unknown unit of speed"),
    "time": Sentence("unknown unit of time"),
    "ratio": Sentence("unknown unit of ratio"),
    "area": Sentence("unknown unit of area"),
    "flow": Sentence("unknown unit of flow"),
    "volume": Sentence("unknown unit of volume"),
}
_LISTED = tomllib.loads(resources.files(__package__).joinpath("units.toml").read_text(encoding="utf-8"))
_FRACTION = re.compile(r"1\s*[/\u2044]\s*(10{1,4})\s*(\D+)")
_IN_TIME = re.compile(
    r"(?P<volume>[^\d/]+?3?)\s*(?:/| in | per | je | w )\s*(?P<number>\d+(?:[.,]\d+)?)?\s*(?P<time>\D+)"
)
DM3_MIN = 6.0e4  # m³/s → dm³/min
MM3_S = 1.0e9  # m³/s → mm³/s
KPA = 1.0e-3
IN_HG = 1.0 / 3386.389  # at 0 °C
MPA_S = 1.0e3  # Pa·s → mPa·s
MM = 1.0e3
UM = 1.0e6
MM2_S = 1.0e6  # m²/s → mm²/s
G_CM3 = 1.0e-3  # kg/m³ → g/cm³
RPM = 60.0  # 1/s → 1/min
PERCENT = 100.0
_INCH = 0.0254  # [m]
MILE = 1609.344  # [m]
PSI = 4.4482216152605 / _INCH**2  # [Pa], pound-force on a square inch: 6894.757293168361
GALLON = 231.0 * _INCH**3  # [m³], US liquid gallon
_POUND = 0.45359237  # [kg]
_INCHES = 1.0 / (_INCH * MM)
_TENTHS = 1.0e4 / (_INCH * UM)
_CUBIC_INCHES = _INCHES**3
_FAHRENHEIT = 9.0 / 5.0
_POUNDS_PER_GALLON = GALLON / (_POUND * G_CM3)
_GALLONS = 1.0e-3 / GALLON
_PSI = 1.0 / (PSI * KPA)


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
        """Convert a value or array in this unit to SI.

        Parameters
        ----------
        value
            a number or an array, in this unit.

        Returns
        -------
        float or numpy.ndarray
            in SI; a temperature in °C.
        """
        return value * self.factor + self.offset if self.offset else value * self.factor

    def from_si(self, value: Any) -> Any:
        """Convert an SI value or array to this unit.

        Parameters
        ----------
        value
            a number or an array, in SI; a temperature in °C.

        Returns
        -------
        float or numpy.ndarray
            in this unit.
        """
        return (value - self.offset) / self.factor if self.offset else value / self.factor


def gear_name(gear: int) -> str:
    """Name a gear as people do.

    >>> gear_name(-1), gear_name(0), gear_name(3)
    ('R', 'N', '3')
    """
    return {-1: "R", 0: "N"}.get(gear) or str(gear)


def _spelling(name: str) -> str:
    # NFKC turns ℃ into °C, the micro sign and Greek mu into one letter, superscripts into digits
    text = unicodedata.normalize("NFKC", name).strip().lower().replace("μ", "µ").replace("\u2212", "-")
    return re.sub(r"\s+", " ", text)


_KINDS = {
    kind: [Unit(name, each["factor"], each.get("offset", 0.0)) for name, each in units.items()]
    for kind, units in _LISTED.items()
}
_TABLE: dict[str, dict[str, Unit]] = {
    kind: {_spelling(alias): unit for unit in units for alias in _LISTED[kind][unit.name]["spellings"]}
    for kind, units in _KINDS.items()
}


def find_unit(name: str, kind: str) -> Unit | None:
    """Return the unit of that kind with that name, or None.

    Of lengths also a decimal fraction of one, and of flows a volume in a time.

    Parameters
    ----------
    name
        as people write it, in any of its spellings.
    kind
        of quantity: ``length``, ``pressure`` …

    Returns
    -------
    Unit or None
        None where no unit of that kind has such a name; `unit` raises an error instead.

    Examples
    --------
    >>> find_unit("℃", "temperature").name
    '°C'
    >>> find_unit("%", "pressure") is None
    True
    >>> find_unit("1/100 mm", "length"), find_unit("1/1000mm", "length").name
    (Unit(name='1/100 mm', factor=1e-05, offset=0.0), 'µm')
    >>> round(1e6 * find_unit("ml in 15 s", "flow").to_si(946.0), 2), find_unit("dm³/min", "flow").name
    (63.07, 'dm³/min')
    """
    known = _TABLE[kind].get(_spelling(name))
    if known is None and kind == "flow":
        return _volume_in_time(name.strip())
    return _fraction(_spelling(name)) if known is None and kind == "length" else known


def _volume_in_time(name: str) -> Unit | None:
    """Return a flow that is a volume in a time, as it is caught in a jug: ``ml/15 s``, ``qt in 20 s``, ``l/min``."""
    match = _IN_TIME.fullmatch(_spelling(name))
    volume, time = (find_unit(match["volume"], "volume"), find_unit(match["time"], "time")) if match else (None, None)
    if match is None or volume is None or time is None or time.name == HHMMSS:
        return None
    seconds = float((match["number"] or "1").replace(",", ".")) * time.factor
    return Unit(name, volume.factor / seconds) if seconds > 0.0 else None


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
    """Return every kind of a log that has a unit of that name: ``"m"`` is a length only, ``"min"`` a time."""
    return [kind for kind in _TABLE if kind not in _IN_NO_LOG and find_unit(name, kind)]


@dataclass(frozen=True)
class ShownUnit:
    """A unit that people read: ``shown = carried · factor + offset``, carried as atleak's records carry it.

    Its digits are those that its trade reads: whole psi of a gauge, a tenth of what a micrometer gives. ``spelled``
    stands where a column's unit would be read as a factor: 0.00012 in, and 1.2 below *[0.0001 in]*.
    """

    name: str  # as people write it
    digits: int = 0  # decimal places that a value usually has
    factor: float = 1.0  # shown for one carried
    offset: float = 0.0  # shown at zero carried
    finer: int = 0  # decimal places more than the same value takes in the unit carried
    spelled: ShownUnit | None = None  # for a single quantity in a sentence

    def shown(self, carried: Any) -> Any:
        """Convert a value or array from the unit carried."""
        return carried * self.factor + self.offset

    def carried(self, shown: Any) -> Any:
        """Convert a value or array back to the unit carried."""
        return (shown - self.offset) / self.factor

    def places(self, digits: int | None) -> int:
        """Return how many decimal places a value takes that takes so many as it is carried; None for the usual ones."""
        return self.digits if digits is None else max(0, digits + self.finer)

    def stated(self, carried: float) -> float:
        """Convert a value that somebody stated, without the digits that converting alone brings.

        The usual ones of the unit stay, and two that count: 55 kPa, which a source says for 8 psi, are 8 psi again.
        """
        shown = self.shown(carried)
        if shown == carried or not math.isfinite(shown) or shown == 0.0:
            return shown
        return round(shown, max(self.digits, 1 - math.floor(math.log10(abs(shown)))))


class Quantity(NamedTuple):
    """A value in the unit of atleak's records, to be written in the reader's, with so many places in its own.

    In a `atleak.common.sentences.Sentence` it stands as ``{name} {name.unit}``; ``{name:g}`` and ``{name:.1f}`` say how
    many digits it takes there.
    """

    value: float  # in the unit of atleak's records
    kind: str  # of quantity, as ``clearance``
    digits: int = 0  # decimal places in the unit of the records

    def __format__(self, specification: str) -> str:
        """Write the value in the unit of atleak's records, without naming it; no line breaks between its thousands."""
        return format(self.value, specification or f".{self.digits}f").replace(",", "\u00a0")

    @property
    def unit(self) -> str:
        """Return the unit of atleak's records."""
        return _METRIC[self.kind].name


class UnitOf(NamedTuple):
    """The unit in which a kind of quantity is read, as what stands at a place of a sentence: ``clearance [{unit}]``."""

    kind: str

    def __format__(self, _: str) -> str:
        """Write the unit of atleak's records."""
        return _METRIC[self.kind].name


_METRIC = {
    "clearance": ShownUnit("µm", 1),
    "uncertainty": ShownUnit("µm", 2),  # of a clearance or diameter
    "length": ShownUnit("mm", 3),
    "pressure": ShownUnit("kPa"),
    "vacuum": ShownUnit("in-Hg", 1),  # as gauges of stands are marked
    "temperature": ShownUnit("°C"),
    "temperature_difference": ShownUnit("°C", 1),
    "flow": ShownUnit("dm³/min", 2),
    "leak": ShownUnit("dm³/min", 2),  # through the gaps of one land
    "distance": ShownUnit("km"),
    "speed": ShownUnit("km/h"),
    "displacement": ShownUnit("mm³"),
    "engine_speed": ShownUnit("rpm"),
    "viscosity": ShownUnit("mm²/s", 1),
    "density": ShownUnit("g/cm³", 3),
    "time": ShownUnit("s", 1),
    "percent": ShownUnit("%", 1),
    "number": ShownUnit("", 2),
    # of the workbook's formulas
    "clearance_squared": ShownUnit("µm²", 2),
    "clearance_cubed": ShownUnit("µm³", 2),
    "clearance_per_kelvin": ShownUnit("µm/K", 4),
    "gap_leak": ShownUnit("mm³/s", 3),
    "displacement_per_turn": ShownUnit("mm³/rev", 3),
    "kelvin": ShownUnit("K", 1),
    "above_absolute_zero": ShownUnit("K", 2),
    "per_kelvin": ShownUnit("1/K", 6),
    "expansion": ShownUnit("1e-6/K", 1),
    "density_per_kelvin": ShownUnit("g/(cm³·K)", 6),
    "dynamic_viscosity": ShownUnit("mPa·s", 2),
    "tip_slip": ShownUnit("dm³/min/kPa", 4),
    "tip_bend": ShownUnit("mPa²·s²/kPa", 4),
}

SYSTEMS: Mapping[str, Mapping[str, ShownUnit]] = {
    "metric": _METRIC,
    "metric_bar": _METRIC
    | dict.fromkeys(("flow", "leak"), ShownUnit("l/min", 2))
    | {
        "pressure": ShownUnit("bar", 2, 0.01, finer=2),
        "vacuum": ShownUnit("mbar", 0, 33.86389),
        "tip_slip": ShownUnit("l/min/bar", 2, 100.0),
        "tip_bend": ShownUnit("mPa²·s²/bar", 2, 100.0),
    },
    "us": _METRIC
    | {
        "clearance": ShownUnit("0.0001 in", 1, _TENTHS, spelled=ShownUnit("in", 5, _TENTHS / 1.0e4, finer=4)),
        "uncertainty": ShownUnit("µin", 0, _TENTHS * 100.0, finer=-2),
        "length": ShownUnit("in", 4, _INCHES, finer=1),
        "pressure": ShownUnit("psi", 0, _PSI),
        "temperature": ShownUnit("°F", 0, _FAHRENHEIT, 32.0),
        "temperature_difference": ShownUnit("°F", 1, _FAHRENHEIT),
        "flow": ShownUnit("gpm", 2, _GALLONS),  # as pumps are rated, and coolers flow-checked
        "leak": ShownUnit("in³/min", 1, 1.0e6 * _CUBIC_INCHES, finer=-1),  # 0.00 gpm tells no land from another
        "distance": ShownUnit("mi", 0, 1.0e3 / MILE),
        "speed": ShownUnit("mph", 0, 1.0e3 / MILE),
        "displacement": ShownUnit("in³", 3, _CUBIC_INCHES, finer=3),
        "viscosity": ShownUnit("cSt", 1),
        "density": ShownUnit("lb/gal", 2, _POUNDS_PER_GALLON, finer=-1),
        "clearance_squared": ShownUnit("(0.0001 in)²", 2, _TENTHS**2),
        "clearance_cubed": ShownUnit("(0.0001 in)³", 2, _TENTHS**3),
        "clearance_per_kelvin": ShownUnit(
            "0.0001 in/°F",
            4,
            _TENTHS / _FAHRENHEIT,
            spelled=ShownUnit("µin/°F", 1, _TENTHS * 100.0 / _FAHRENHEIT, finer=-2),
        ),
        "gap_leak": ShownUnit("in³/min", 3, 60.0 * _CUBIC_INCHES),
        "displacement_per_turn": ShownUnit("in³/rev", 3, _CUBIC_INCHES),
        "kelvin": ShownUnit("°F", 1, _FAHRENHEIT),
        "above_absolute_zero": ShownUnit("°F", 2, _FAHRENHEIT),
        "per_kelvin": ShownUnit("1/°F", 6, 1.0 / _FAHRENHEIT),
        "expansion": ShownUnit("1e-6/°F", 1, 1.0 / _FAHRENHEIT),
        "density_per_kelvin": ShownUnit("lb/(gal·°F)", 6, _POUNDS_PER_GALLON / _FAHRENHEIT),
        "dynamic_viscosity": ShownUnit("cP", 2),
        "tip_slip": ShownUnit("gpm/psi", 4, _GALLONS / _PSI),
        "tip_bend": ShownUnit("cP²/psi", 4, 1.0 / _PSI),
    },
}
"""Each system of units by its name; every system has every kind of quantity."""


def unit_system(name: str) -> Mapping[str, ShownUnit]:
    """Return a system of units: the unit of each kind of quantity.

    Parameters
    ----------
    name
        one of `SYSTEMS`.

    Raises
    ------
    InputError
        if there is no such system.
    """
    if name not in SYSTEMS:
        raise unknown(Sentence("no such system of units"), name, tuple(SYSTEMS))
    return SYSTEMS[name]
