"""Say in which unit each kind of quantity is read: metric, metric with bar and litres, or US.

Records, files and the engine's results keep their own units (µm, mm, kPa, °C, dm³/min, km); only what people read and
type is converted, here and nowhere else. Names in capitals are factors from SI: ``metres * UM`` are micrometres.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from atleak.common.errors import unknown
from atleak.common.sentences import Sentence

DM3_MIN = 6.0e4  # m³/s → dm³/min
MM3_S = 1.0e9  # m³/s → mm³/s
KPA = 1.0e-3
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
QUART = 0.946352946e-3  # [m³], US liquid quart: 57.75 in³


@dataclass(frozen=True)
class ShownUnit:
    """A unit that people read: ``shown = carried · factor + offset``, carried as atleak's records carry it.

    ``finer`` lets neither unit hide what the other shows. ``spelled`` stands where a column's unit would be read as a
    factor: 0.00012 in, and 1.2 below *[0.0001 in]*.
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


_METRIC = {
    "clearance": ShownUnit("µm", 1),
    "length": ShownUnit("mm", 3),
    "pressure": ShownUnit("kPa"),
    "temperature": ShownUnit("°C"),
    "temperature_difference": ShownUnit("°C", 1),
    "flow": ShownUnit("dm³/min", 2),
    "distance": ShownUnit("km"),
    "speed": ShownUnit("km/h"),
    "displacement": ShownUnit("mm³"),
    "engine_speed": ShownUnit("rpm"),
    "viscosity": ShownUnit("mm²/s", 1),
    "density": ShownUnit("g/cm³", 3),
    "time": ShownUnit("s", 1),
    "percent": ShownUnit("%", 1),
    "number": ShownUnit("", 2),
}
_INCHES = 1.0 / (_INCH * MM)
_TENTHS = 1.0e4 / (_INCH * UM)
_CUBIC_INCHES = _INCHES**3
_FAHRENHEIT = 9.0 / 5.0

SYSTEMS: Mapping[str, Mapping[str, ShownUnit]] = {
    "metric": _METRIC,
    "metric_bar": _METRIC | {"pressure": ShownUnit("bar", 2, 0.01, finer=2), "flow": ShownUnit("l/min", 2)},
    "us": _METRIC
    | {
        "clearance": ShownUnit("0.0001 in", 2, _TENTHS, finer=1, spelled=ShownUnit("in", 5, _TENTHS / 1.0e4, finer=4)),
        "length": ShownUnit("in", 5, _INCHES, finer=2),
        "pressure": ShownUnit("psi", 1, 1.0 / (PSI * KPA), finer=1),
        "temperature": ShownUnit("°F", 0, _FAHRENHEIT, 32.0),
        "temperature_difference": ShownUnit("°F", 1, _FAHRENHEIT),
        "flow": ShownUnit("qt/min", 2, 1.0e-3 / QUART),
        "distance": ShownUnit("mi", 0, 1.0e3 / MILE),
        "speed": ShownUnit("mph", 0, 1.0e3 / MILE),
        "displacement": ShownUnit("in³", 4, _CUBIC_INCHES, finer=4),
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
