"""Read a number as people write it: the values it can mean, and whether it can be what was asked for.

The writer's country is not known: comma and point each serve as decimal sign and between thousands. A number that can
be read in two ways is reported, and neither way is chosen.
"""

from __future__ import annotations

import math
import re
import unicodedata
from dataclasses import dataclass, replace

from atleak.catalogue import usual
from atleak.wording import Wording, wording

_SIGNS = str.maketrans(
    {
        **dict.fromkeys("−–‐‑﹣－", "-"),
        **dict.fromkeys("’‘ʼ′´`＇", "'"),
        **dict.fromkeys("，٬", ","),
        **dict.fromkeys("．٫", "."),
        "＋": "+",
    }
)
_DECIMAL = re.compile(r"[+-]? ?(?:\d+[.,]?\d*|[.,]\d+)(?:[eE][+-]?\d{1,3})?")
_GROUPED = re.compile(
    r"(?P<whole>[+-]? ?[1-9]\d{0,2}(?P<sign>[ '.,])\d{3}(?:(?P=sign)\d{3})*)(?:(?!(?P=sign))[.,](?P<rest>\d*))?"
)


@dataclass(frozen=True)
class AskedNumber:
    """A number that people are asked for: it is refused outside ``limits`` and doubted outside ``usual``.

    ``kind`` is the kind of quantity, where a reader may have it in another unit.
    """

    name: str
    unit: str
    example: float = 1.5
    limits: tuple[float, float] = (-math.inf, math.inf)
    usual: tuple[float, float] = (-math.inf, math.inf)
    kind: str | None = None

    def to(self, say: Wording) -> AskedNumber:
        """Return what is asked for in the reader's words and unit."""
        named = replace(self, name=say.get("asked", self.name), unit=say.get("units", self.unit))
        if self.kind is None:
            return named
        example, *ends = (say.convert(value, self.kind) for value in (self.example, *self.limits, *self.usual))
        return replace(
            named,
            unit=say.unit(self.kind),
            example=float(f"{example:.4g}"),
            limits=(ends[0], ends[1]),
            usual=(ends[2], ends[3]),
        )


@dataclass(frozen=True)
class WrittenNumber:
    """The number read from an entry: its value where it is accepted, and any doubt about it, in sentences."""

    value: float | None
    doubt: str = ""


TEMPERATURE = AskedNumber("temperature", "°C", 95.5, (-60.0, 200.0), usual.TEMPERATURE.ends, "temperature")
MEASURING_TEMPERATURE = AskedNumber("measuring temperature", "°C", 21.5, (-20.0, 60.0), (10.0, 35.0), "temperature")
PUMP_SIDE_CLEARANCE = AskedNumber(
    "pump side clearance", "µm", 45.5, (1.0, 2_000.0), usual.SIDE_CLEARANCE.ends, "clearance"
)
PUMP_TIP_CLEARANCE = AskedNumber("pump tip clearance", "µm", 150.5, (1.0, 2e3), usual.TIP_CLEARANCE.ends, "clearance")
ENGINE_SPEED = AskedNumber("engine speed", "rpm", 850.5, (1.0, 15_000.0), usual.ENGINE_SPEED.ends, "engine_speed")
MILEAGE = AskedNumber("mileage", "km", 106315.0, (0.0, 9_999_999.0), (1_000.0, 1_000_000.0), "distance")
PRICE = AskedNumber("price", "", 61.5, (0.0, 1e8), (0.0, 1e6))
HOURS = AskedNumber("time", "h", 1.5, (0.0, 1_000.0), (0.0, 60.0))
LABOUR_RATE = AskedNumber("labour rate", "per hour", 95.0, (0.0, 1e7), (0.0, 1e5))
TAX = AskedNumber("tax", "%", 23.0, (0.0, 100.0), (0.0, 30.0))
SHIFT = AskedNumber("shift", "s", 1.5, (-1e7, 1e7), (-86_400.0, 86_400.0))


def possible_values(text: str) -> tuple[float, ...]:
    """Return every value that a written number can mean; none where it is no number.

    Of two values the first takes the sign before the last three digits as decimal sign, the second as a thousands
    separator.

    >>> possible_values("850,5"), possible_values("1 234,5"), possible_values("1.234.567"), possible_values("95 °C")
    ((850.5,), (1234.5,), (1234567.0,), ())
    >>> possible_values("123.456"), possible_values("0.456"), possible_values("123.4560")
    ((123.456, 123456.0), (0.456,), (123.456,))
    """
    plain = "".join(map(_plain_sign, text.translate(_SIGNS))).strip()
    values = []
    if _DECIMAL.fullmatch(plain):
        values.append(float(plain.replace(",", ".").replace(" ", "")))
    if grouped := _GROUPED.fullmatch(plain):
        whole = re.sub("[ '.,]", "", grouped["whole"])
        values.append(float(f"{whole}.{grouped['rest'] or ''}"))
    return tuple(value for value in values if math.isfinite(value))


def decimal_number(text: str) -> float | None:
    """Return the number where a single comma or point can only be a decimal sign, as in a diameter; None for none.

    >>> decimal_number("12,034"), decimal_number("1.234,5"), decimal_number("twelve")
    (12.034, 1234.5, None)
    """
    return next(iter(possible_values(text)), None)


def read_number(text: str, asked: AskedNumber, say: Wording | None = None) -> WrittenNumber:
    """Read an entry as the number that was asked for, in its unit; the unit itself may stand behind it.

    Doubts are said in the words of ``say``, English unless given.

    >>> read_number("850,5", ENGINE_SPEED)
    WrittenNumber(value=850.5, doubt='')
    >>> read_number("123.456", MILEAGE).doubt
    "'123.456' can be read in two ways: write 123456 for 123456 km, or 123.4560 for 123.456 km."
    >>> read_number("8505", ENGINE_SPEED).doubt
    '8505 rpm is taken, but unusual: most engine speeds are from 400 to 7000 rpm.'
    """
    say = say or wording("en")
    bare = text.strip().removesuffix(asked.unit).strip()
    values = possible_values(bare)
    if not values:
        unit = say("written.in_unit", unit=asked.unit) if asked.unit else ""
        example = written(asked.example, asked, say)
        doubt = say("written.no_number", text=repr(text.strip()), name=asked.name, unit=unit, example=example)
        return WrittenNumber(None, doubt)
    possible = [value for value in values if _within(value, asked.limits)]
    if not possible:
        within = _range(asked.limits, asked, say)
        return WrittenNumber(None, say("written.outside", value=_with_unit(bare, asked), name=asked.name, range=within))
    if len(possible) > 1:
        fraction, whole = (written(value, asked, say) for value in possible)
        meant = [_with_unit(_plain_text(value, say), asked) for value in possible]
        doubt = say(
            "written.two_ways",
            text=repr(bare),
            whole=whole,
            whole_meant=meant[1],
            fraction=fraction,
            fraction_meant=meant[0],
        )
        return WrittenNumber(None, doubt)
    (value,) = possible
    if _within(value, asked.usual):
        return WrittenNumber(value)
    taken, usual = _with_unit(_plain_text(value, say), asked), _range(asked.usual, asked, say)
    return WrittenNumber(value, say("written.unusual", value=taken, name=asked.name, range=usual))


def written(value: float, asked: AskedNumber, say: Wording | None = None) -> str:
    """Write a number so that it is read back without a doubt, with the decimal sign of ``say``, a point unless given.

    >>> written(80.0, TEMPERATURE), written(92.715, TEMPERATURE), written(123.456, MILEAGE)
    ('80', '92.715', '123.4560')
    >>> written(92.715, TEMPERATURE, wording("de"))
    '92,715'
    """
    text = repr(float(value)).removesuffix(".0")
    possible = [each for each in possible_values(text) if _within(each, asked.limits)]
    text = f"{text}0" if len(possible) > 1 else text
    return text if say is None else text.replace(".", say.texts["decimal"])


def _within(value: float, ends: tuple[float, float]) -> bool:
    return ends[0] <= value <= ends[1]


def _range(ends: tuple[float, float], asked: AskedNumber, say: Wording) -> str:
    low, high = (_plain_text(end, say, 7) for end in ends)
    return _with_unit(say("written.range", low=low, high=high), asked)


def _plain_text(value: float, say: Wording, digits: int = 15) -> str:
    return f"{value:.{digits}g}".replace(".", say.texts["decimal"])


def _with_unit(text: str, asked: AskedNumber) -> str:
    return f"{text} {asked.unit}".strip().replace("-", "−")


def _plain_sign(sign: str) -> str:
    """Return one sign as plain ASCII: digits of any script, blanks of any width; direction marks become nothing."""
    category = unicodedata.category(sign)
    if category == "Nd":
        return str(unicodedata.decimal(sign))
    return " " if category == "Zs" else "" if category == "Cf" else sign
