"""Decides which unit a column is in: the stated one if the values allow it, else by the range of the values."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from atleak.common.errors import InputError
from atleak.common.sentences import Sentence, any_of
from atleak.common.units import UNIT_KINDS, Unit, find_unit, kinds_of, unit
from atleak.measurements.road_test import QUANTITIES
from atleak.readers.logs.names import clean_unit

ATMOSPHERE = 101325.0
_ABSOLUTE = re.compile(r"^((?:0\.1 )?k?pa|m?bar|mpa|hpa|psi)\s*[ (_]?\s*(?:a|abs\.?|absolute?)\s*\)?$", re.IGNORECASE)
_FITS_NONE = Sentence("no unit is stated and its values fit none")
_SAYS_NOTHING = frozenset({"", "-", "none", "index", "gear", "raw", "n/a", "unitless", "?", "value"})


@dataclass(frozen=True)
class Fit:
    """A column's unit: None with a ``problem`` where the column cannot be used.

    ``foreign``: the stated unit is of another kind. ``absolute`` pressures are turned into gauge pressures by `to_si`.
    """

    unit: Unit | None
    assumed: bool = False
    absolute: bool = False
    problem: Sentence | None = None
    doubt: Sentence | None = None
    foreign: bool = False

    def to_si(self, values: np.ndarray) -> np.ndarray:
        """Convert the file's numbers to SI (gauge for pressures)."""
        if self.unit is None or (self.unit.factor == 1.0 and not self.unit.offset):
            result = values
        else:
            with np.errstate(over="ignore"):
                result = self.unit.to_si(values)
        return result - ATMOSPHERE if self.absolute else result


def split_absolute(text: str) -> tuple[str, bool]:
    """Return the unit without the word that makes it absolute, and whether there was one.

    >>> split_absolute("kPa abs"), split_absolute("bar(a)"), split_absolute("kPa")
    (('kPa', True), ('bar', True), ('kPa', False))
    """
    match = _ABSOLUTE.match(clean_unit(text)) or _ABSOLUTE.match(text.strip())
    return (match[1], True) if match else (text, False)


def same_unit(one: str, other: str, kind: str | None) -> bool:
    """Return whether two texts mean the same unit of a kind, both absolute or neither.

    >>> same_unit("[°C]", "degC", "temperature"), same_unit("kPa", "kPa abs", "pressure"), same_unit("l", "dm3", None)
    (True, False, False)
    """
    (first, absolute), (second, other_absolute) = split_absolute(one), split_absolute(other)
    first, second = clean_unit(first), clean_unit(second)
    if absolute != other_absolute:
        return False
    unit = find_unit(first, kind) if kind else None
    return first.lower() == second.lower() or (unit is not None and unit == find_unit(second, kind or ""))


def given(quantity: str, name: str) -> Fit:
    """Return the unit that the user states for a quantity."""
    kind = QUANTITIES[quantity].unit_kind
    if kind is None:
        label = QUANTITIES[quantity].said
        raise InputError(Sentence("{quantity} is a plain number and has no unit", quantity=label), value=name)
    base, absolute = split_absolute(name) if kind == "pressure" else (name, False)
    return Fit(unit(base, kind), absolute=absolute)


def fit(
    quantity: str, stated: str | None, values: np.ndarray, neighbours: Iterable[str] = (), *, commanded: bool = False
) -> Fit:
    """Determine the unit of a column from what the file states, else from its values.

    ``neighbours`` are the units stated elsewhere in the file: a log in °F and mph is likely to be so throughout.
    ``commanded``: it is known to be a command, which alone of a state may be a pressure.
    """
    kind = QUANTITIES[quantity].unit_kind
    part = values[:: max(1, len(values) // 20_000)]
    good = part[np.isfinite(part)]
    if not len(good):
        good = values[np.isfinite(values)]
    if kind is None:
        return _number(quantity, stated, good, commanded)
    text = clean_unit(stated or "")
    base, absolute = split_absolute(stated or "") if kind == "pressure" else (text, False)
    if absolute:
        text = base
    stated_unit = find_unit(text, kind) if text.lower() not in _SAYS_NOTHING else None
    if stated_unit is None and text.lower() not in _SAYS_NOTHING:
        problem = Sentence(
            "unit {unit!r} is {meaning}, not a unit of {kind}", unit=text, meaning=_meaning(text), kind=UNIT_KINDS[kind]
        )
        return Fit(None, problem=problem, foreign=True)
    if stated_unit is not None:
        result = Fit(stated_unit, absolute=absolute)
        si = result.to_si(good)
        misfit = _misfit(quantity, si[np.isfinite(si)], stated_unit)
        return Fit(None, problem=misfit) if misfit else result
    return _guess(quantity, good, tuple(neighbours))


def _meaning(text: str) -> Sentence:
    """Return what a unit that does not belong to the quantity is a unit of."""
    if text.lower() in ("v", "mv", "volt", "volts"):
        return Sentence("a sensor's voltage: its characteristic curve is needed")
    kinds = [UNIT_KINDS[kind] for kind in kinds_of(text)]
    return any_of(kinds) if kinds else Sentence("something else")


def _number(quantity: str, stated: str | None, good: np.ndarray, commanded: bool) -> Fit:
    text = clean_unit(stated or "")
    kinds = kinds_of(text) if text.lower() not in _SAYS_NOTHING | {"text", "gears"} else []
    if quantity == "lock_up" and text:
        # a solenoid is commanded a pressure or a duty; that in the clutch's circuit says nothing of what is commanded
        for kind in ("pressure", "ratio") if commanded else ("ratio",):
            if (stated_unit := find_unit(text, kind)) is not None:
                return Fit(stated_unit)
    if quantity == "gear" and len(good):
        inside = np.mean((good >= -3) & (good <= 12) & (good == np.round(good)))
        # a sentinel among gears is fine, ratios and speeds are not gears
        if inside < 0.9:
            return Fit(None, problem=Sentence("its values are no gear numbers"))
    if kinds and (quantity == "gear" or kinds != ["ratio"]):
        label = QUANTITIES[quantity].label
        problem = Sentence("unit {unit!r} does not belong to {quantity}", unit=text, quantity=label)
        return Fit(None, problem=problem, foreign=True)
    return Fit(None)


def _misfit(quantity: str, si: np.ndarray, stated: Unit) -> Sentence | None:
    if not len(si):
        return None
    info = QUANTITIES[quantity]
    if np.mean((si >= info.low) & (si <= info.high)) < 0.5:
        return Sentence("most of its values cannot be {quantity} in {unit}", quantity=info.label, unit=stated.name)
    kind = info.unit_kind
    if kind == "temperature" and float(np.median(si)) > 165.0:
        return Sentence("its values are too high for {unit}: °F?", unit=stated.name)
    if kind == "rotational_speed" and stated.name == "rpm":
        top = float(np.percentile(si, 99.5)) * 60
        if 0 < top < 15 and not np.allclose(si * 60, np.round(si * 60)):
            return Sentence("its values are too small for rpm: thousands of rpm?")
    if quantity == "main_pressure" and stated.name in ("kPa", "psi", "bar", "MPa"):
        top = float(np.percentile(si, 99.5))
        if 0 < top < 20e3:
            return Sentence("its values are too small for a main pressure in {unit}", unit=stated.name)
    return None


_IMPERIAL = {"°f", "f", "mph", "psi", "miles", "mi", "ft-lb", "lb-ft", "lb/min", "mpg", "inhg", "degf", "gal", "ft"}
_METRIC = {"°c", "c", "km/h", "kph", "kpa", "bar", "km", "nm", "l", "l/100km", "hpa", "mbar", "degc", "℃", "kmh"}


def imperial(neighbours: Iterable[str]) -> bool | None:
    """Return whether the file's other units are imperial, metric, or (None) do not say."""
    lowered = [clean_unit(text).lower() for text in neighbours]
    are_imperial, are_metric = (any(text in names for text in lowered) for names in (_IMPERIAL, _METRIC))
    return None if are_imperial == are_metric else are_imperial


def _guess(quantity: str, good: np.ndarray, neighbours: tuple[str, ...]) -> Fit:
    kind = QUANTITIES[quantity].unit_kind
    assert kind is not None
    if not len(good):
        usual = {"temperature": "°C", "pressure": "kPa"}.get(kind)
        return Fit(unit(usual, kind) if usual else None, assumed=True)
    top, middle = float(np.percentile(good, 99)), float(np.median(good))
    if kind == "temperature":
        return _guess_temperature(top, middle, imperial(neighbours))
    if kind == "rotational_speed":
        if top > 200 or top <= 0:
            return Fit(unit("rpm", kind), assumed=True)
        return Fit(None, problem=Sentence("its values are too small for rpm and no unit is stated"))
    if kind == "speed":
        name = "mph" if imperial(neighbours) else "km/h"
        return Fit(unit(name, kind), assumed=True, doubt=Sentence("km/h or mph cannot be told from the values"))
    ends = ((2.8, "MPa"), (35.0, "bar"), (300.0, "psi"), (4000.0, "kPa"), (40000.0, "mbar"), (1e7, "Pa"))
    if top < 0.4 or top > ends[-1][0]:
        return Fit(None, problem=_FITS_NONE)
    return Fit(unit(next(name for end, name in ends if top <= end), kind), assumed=True)


def _guess_temperature(top: float, middle: float, is_imperial: bool | None) -> Fit:
    if middle > 330 and top < 470:
        return Fit(unit("K", "temperature"), assumed=True)
    if top > 150 or (is_imperial and top > 60):
        return Fit(unit("°F", "temperature"), assumed=True)
    if top > 170:
        return Fit(None, problem=_FITS_NONE)
    return Fit(unit("°C", "temperature"), assumed=True)
