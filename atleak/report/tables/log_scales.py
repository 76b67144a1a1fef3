"""Say in which unit a reader sees each channel of a log, and what a formula gives."""

from __future__ import annotations

from atleak.analysis.formulas import Dimension
from atleak.common.units import Unit, unit
from atleak.common.wording import Wording
from atleak.measurements.road_test import RoadTest
from atleak.readers.logs.understood import workshop_unit
from atleak.report.tables.road_test import Scale

_SHOWN = {  # kind of quantity → the reader's kind, and the unit that atleak's records have it in
    "pressure": ("pressure", unit("kPa", "pressure")),
    "rotational_speed": ("engine_speed", unit("rpm", "rotational_speed")),
    "speed": ("speed", unit("km/h", "speed")),
    "temperature": ("temperature", unit("°C", "temperature")),
    "temperature_difference": ("temperature_difference", Unit("°C", 1.0)),
    "time": ("time", unit("s", "time")),
}
_POWERS = {2: "²", 3: "³"}


def channel_scales(test: RoadTest, say: Wording) -> dict[str, Scale]:
    """Return, by quantity, the unit that the reader has it in and the function from SI to it."""
    scales: dict[str, Scale] = {}
    for name, channel in test.channels.items():
        shown = workshop_unit(name, channel)
        kind = next((kind for kind, (_, record) in _SHOWN.items() if record == shown), None)
        if kind is not None:
            scales[name] = _scale(kind, say)
        elif shown is not None:
            scales[name] = (shown.name, shown.from_si)
    return scales


def formula_scale(dimension: Dimension, say: Wording) -> Scale:
    """Return the unit that the reader has a formula's values in, such as ``kPa/s``, and the function from SI to it."""
    if not dimension:
        return "", lambda value: value
    if len(dimension) == 1 and dimension[0][1] == 1:
        return _scale(dimension[0][0], say)
    factor = 1.0
    above: list[str] = []
    below: list[str] = []
    for kind, power in dimension:
        name, convert = _scale(kind, say)
        factor *= (convert(1.0) - convert(0.0)) ** power
        (above if power > 0 else below).append(name + _POWERS.get(abs(power), "" if abs(power) == 1 else f"^{power}"))
    name = "/".join(["·".join(above) or "1", *below])
    return name, lambda value: value * factor


def _scale(kind: str, say: Wording) -> Scale:
    shown, record = _SHOWN[kind]
    return say.unit(shown), lambda value: say.convert(record.from_si(value), shown)
