"""Read a number as people write it: the values it can mean, and whether it can be what was asked for.

The writer's country is not known: comma and point each serve as decimal sign and between thousands. A number that can
be read in two ways is reported, and neither way is chosen.
"""

from __future__ import annotations

import math
import re
import unicodedata
from dataclasses import dataclass, replace

from atleak.catalogue import usual_values as usual
from atleak.common.sentences import Sentence
from atleak.common.wording import Wording

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

    name: Sentence
    unit: str
    example: float = 1.5
    limits: tuple[float, float] = (-math.inf, math.inf)
    usual: tuple[float, float] = (-math.inf, math.inf)
    kind: str | None = None

    def to(self, say: Wording) -> AskedNumber:
        """Return what is asked for in the reader's unit."""
        named = replace(self, unit=say.get("units", self.unit))
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
    """The number read from an entry: its value where it is accepted, and the reason of any doubt about it."""

    value: float | None
    reason: Sentence = Sentence("")  # noqa: RUF009  frozen, so safe to share

    @property
    def doubt(self) -> Sentence:
        """Return the doubt as a sentence of its own; nothing where there is none."""
        return Sentence("{reason}.", reason=self.reason) if self.reason else self.reason


TEMPERATURE = AskedNumber(
    Sentence("temperature"), "°C", 95.5, (-60.0, 200.0), usual.USUAL_TEMPERATURE.ends, "temperature"
)
MEASURING_TEMPERATURE = AskedNumber(
    Sentence("measuring temperature"), "°C", 21.5, (-20.0, 60.0), (10.0, 35.0), "temperature"
)
PUMP_SIDE_CLEARANCE = AskedNumber(
    Sentence("pump side clearance"), "µm", 45.5, (1.0, 2_000.0), usual.SIDE_CLEARANCE.ends, "clearance"
)
PUMP_TIP_CLEARANCE = AskedNumber(
    Sentence("pump tip clearance"), "µm", 150.5, (1.0, 2e3), usual.TIP_CLEARANCE.ends, "clearance"
)
ENGINE_SPEED = AskedNumber(
    Sentence("engine speed"), "rpm", 850.5, (1.0, 15_000.0), usual.USUAL_ENGINE_SPEED.ends, "engine_speed"
)
MILEAGE = AskedNumber(Sentence("mileage"), "km", 106315.0, (0.0, 9_999_999.0), (1_000.0, 1_000_000.0), "distance")
PRICE = AskedNumber(Sentence("price"), "", 61.5, (0.0, 1e8), (0.0, 1e6))
HOURS = AskedNumber(Sentence("time"), "h", 1.5, (0.0, 1_000.0), (0.0, 60.0))
LABOUR_RATE = AskedNumber(Sentence("labour rate"), "per hour", 95.0, (0.0, 1e7), (0.0, 1e5))
TAX = AskedNumber(Sentence("tax"), "%", 23.0, (0.0, 100.0), (0.0, 30.0))
INTERVAL = AskedNumber(Sentence("row interval"), "s", 0.033, (1e-6, 3_600.0), (1e-3, 60.0))
SHIFT = AskedNumber(Sentence("shift"), "s", 1.5, (-1e7, 1e7), (-86_400.0, 86_400.0))


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


def read_number(text: str, asked: AskedNumber) -> WrittenNumber:
    """Read an entry as the number that was asked for, in its unit; the unit itself may stand behind it.

    >>> read_number("850,5", ENGINE_SPEED)
    WrittenNumber(value=850.5, reason='')
    >>> read_number("123.456", MILEAGE).doubt
    "'123.456' can be read in two ways: write 123456 for 123456 km, or 123.4560 for 123.456 km."
    >>> read_number("8505", ENGINE_SPEED).doubt
    '8505 rpm is taken, but unusual: the engine speed is mostly from 400 to 7000 rpm.'
    """
    bare = text.strip().removesuffix(asked.unit).strip()
    values = possible_values(bare)
    if not values:
        return WrittenNumber(None, _no_number(text.strip(), asked))
    possible = [value for value in values if _within(value, asked.limits)]
    if not possible:
        reason = Sentence(
            "{value} is not taken: the {name} must be {range}",
            value=_with_unit(bare, asked),
            name=asked.name,
            range=_range(asked.limits, asked),
        )
        return WrittenNumber(None, reason)
    if len(possible) > 1:
        reason = Sentence(
            "{text!r} can be read in two ways: write {whole} for {whole_meant}, or {fraction} for {fraction_meant}",
            text=bare,
            whole=_Spelled(possible[1], written(possible[1], asked)),
            whole_meant=_with_unit(_spelled(possible[1]), asked),
            fraction=_Spelled(possible[0], written(possible[0], asked)),
            fraction_meant=_with_unit(_spelled(possible[0]), asked),
        )
        return WrittenNumber(None, reason)
    (value,) = possible
    if _within(value, asked.usual):
        return WrittenNumber(value)
    reason = Sentence(
        "{value} is taken, but unusual: the {name} is mostly {range}",
        value=_with_unit(_spelled(value), asked),
        name=asked.name,
        range=_range(asked.usual, asked),
    )
    return WrittenNumber(value, reason)


def _no_number(text: str, asked: AskedNumber) -> Sentence:
    example = _Spelled(asked.example, written(asked.example, asked))
    values = {"text": text, "name": asked.name, "example": example}
    if asked.unit:
        unit = asked.unit
        return Sentence("{text!r} is not a number: write the {name} in {unit}, such as {example}", unit=unit, **values)
    return Sentence("{text!r} is not a number: write the {name}, such as {example}", **values)


def written(value: float, asked: AskedNumber, say: Wording | None = None) -> str:
    """Write a number so that it is read back without a doubt, with the decimal sign of ``say``, a point unless given.

    >>> written(80.0, TEMPERATURE), written(92.715, TEMPERATURE), written(123.456, MILEAGE)
    ('80', '92.715', '123.4560')
    >>> from atleak.common.wording import wording
    >>> written(92.715, TEMPERATURE, wording("de"))
    '92,715'
    """
    text = repr(float(value)).removesuffix(".0")
    possible = [each for each in possible_values(text) if _within(each, asked.limits)]
    text = f"{text}0" if len(possible) > 1 else text
    return text if say is None else text.replace(".", say.decimal)


def _within(value: float, ends: tuple[float, float]) -> bool:
    return ends[0] <= value <= ends[1]


class _Spelled(float):
    """A number that is written with just these signs; another language has its own decimal sign in it."""

    text: str

    def __new__(cls, value: float, text: str) -> _Spelled:
        spelled = super().__new__(cls, value)
        spelled.text = text
        return spelled

    def __getnewargs__(self) -> tuple[float, str]:  # type: ignore[override]
        return float(self), self.text

    def __format__(self, specification: str) -> str:
        return self.text


def _spelled(value: float, digits: int = 15) -> _Spelled:
    return _Spelled(value, f"{value:.{digits}g}".replace("-", "−"))


def _range(ends: tuple[float, float], asked: AskedNumber) -> Sentence:
    low, high = (_spelled(end, 7) for end in ends)
    if asked.unit:
        return Sentence("from {low} to {high} {unit}", low=low, high=high, unit=asked.unit)
    return Sentence("from {low} to {high}", low=low, high=high)


def _with_unit(value: _Spelled | str, asked: AskedNumber) -> Sentence:
    shown = value.replace("-", "−") if isinstance(value, str) else value
    return Sentence("{value} {unit}", value=shown, unit=asked.unit) if asked.unit else Sentence("{value}", value=shown)


def _plain_sign(sign: str) -> str:
    """Return one sign as plain ASCII: digits of any script, blanks of any width; direction marks become nothing."""
    category = unicodedata.category(sign)
    if category == "Nd":
        return str(unicodedata.decimal(sign))
    return " " if category == "Zs" else "" if category == "Cf" else sign
