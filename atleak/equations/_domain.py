"""Check what goes into the equations, and convert it to numbers and back.

A check costs one ``min()`` or ``max()`` over the array and copies nothing; only where that fails, or meets a
NaN, the array is looked through for the first offending value. NaN passes every check.

A single number stays a number: a diagnosis checks tens of thousands of them, and an array of one costs several times as
much.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from atleak.common.errors import DomainError
from atleak.common.sentences import Sentence

POSITIVE, _NOT_NEGATIVE = Sentence("positive"), Sentence("zero or positive")
# Those that a file or a person can state so that no equation holds; any other is named to programmers only.
STATED_NAMES: dict[str, Sentence] = {
    name: name
    for name in (
        Sentence("area left for control pressure (A_1 - A_2W + A_3W)"),
        Sentence("centre distance"),
        Sentence("density"),
        Sentence("diameter"),
        Sentence("diameter of the cam ring"),
        Sentence("dynamic viscosity"),
        Sentence("eccentricity"),
        Sentence("free length"),
        Sentence("gear width"),
        Sentence("inner diameter"),
        Sentence("kinematic viscosity"),
        Sentence("length of a tip"),
        Sentence("limit of the pressure"),
        Sentence("mean coil diameter"),
        Sentence("number of active coils"),
        Sentence("number of lobes"),
        Sentence("number of sealing tips"),
        Sentence("number of teeth"),
        Sentence("number of the ring gear's teeth"),
        Sentence("number of vanes"),
        Sentence("outer diameter of the land"),
        Sentence("pump displacement"),
        Sentence("pump speed"),
        Sentence("radial clearance"),
        Sentence("rod diameter"),
        Sentence("root diameter"),
        Sentence("rotor width"),
        Sentence("second kinematic viscosity"),
        Sentence("second temperature"),
        Sentence("shear modulus"),
        Sentence("side clearance"),
        Sentence("sleeve diameter"),
        Sentence("slip coefficient"),
        Sentence("spool diameter"),
        Sentence("spring deflection"),
        Sentence("spring length"),
        Sentence("spring rate"),
        Sentence("temperature"),
        Sentence("tip clearance"),
        Sentence("tip diameter"),
        Sentence("tip diameter of the ring gear"),
        Sentence("tooth height"),
        Sentence("tooth module"),
        Sentence("vane width"),
        Sentence("volumetric efficiency"),
        Sentence("wire diameter"),
    )
}


def values(given: ArrayLike) -> Any:
    """Return the given number as NumPy's float, numbers as a float array; float arrays are not copied."""
    return np.float64(given) if isinstance(given, float) else np.asarray(given, dtype=np.float64)


def _least(value: Any) -> Any:
    return value.min() if value.ndim else value


def _most(value: Any) -> Any:
    return value.max() if value.ndim else value


def result(computed: Any) -> Any:
    """Return a Python float where everything given was a scalar, the array otherwise."""
    return float(computed) if isinstance(computed, float) or np.ndim(computed) == 0 else computed


def refuse(name: str, value: NDArray[np.float64], bad: NDArray[np.bool_], expected: Sentence, unit: str) -> None:
    """Raise DomainError for the first value marked bad, if there is one."""
    bad = np.asarray(bad)
    if not bad.any():
        return
    place = np.unravel_index(int(np.argmax(bad)), bad.shape)
    first = float(np.broadcast_to(value, bad.shape)[place])
    said = Sentence(
        "{name} must be {expected}, found {found}",
        name=STATED_NAMES.get(name, name),
        expected=expected,
        found=_with_unit(Sentence("{number:g}", number=first), unit),
    )
    raise DomainError(Sentence("{said} at index {place}", said=said, place=tuple(map(int, place))) if place else said)


def _with_unit(number: Sentence, unit: str) -> Sentence:
    return Sentence("{number} {unit}", number=number, unit=unit) if unit else number


def positive(name: str, given: ArrayLike, unit: str = "") -> NDArray[np.float64]:
    """Return the values, all of them above zero."""
    if isinstance(given, float) and given > 0.0:
        return np.float64(given)  # type: ignore[return-value]
    value = values(given)
    if value.size and not _least(value) > 0.0:
        refuse(name, value, value <= 0.0, POSITIVE, unit)
    return value


def not_negative(name: str, given: ArrayLike, unit: str = "") -> NDArray[np.float64]:
    """Return the values, none of them below zero."""
    if isinstance(given, float) and given >= 0.0:
        return np.float64(given)  # type: ignore[return-value]
    value = values(given)
    if value.size and not _least(value) >= 0.0:
        refuse(name, value, value < 0.0, _NOT_NEGATIVE, unit)
    return value


def within(name: str, given: ArrayLike, low: float, high: float, unit: str = "") -> NDArray[np.float64]:
    """Return the values, all of them between low and high, both included."""
    value = values(given)
    if value.size and not (_least(value) >= low and _most(value) <= high):
        ends = Sentence("between {low:g} and {high:g}", low=low, high=high)
        refuse(name, value, (value < low) | (value > high), _with_unit(ends, unit), unit)
    return value


def above(name: str, given: ArrayLike, low: float, unit: str = "") -> NDArray[np.float64]:
    """Return the values, all of them above low."""
    value = values(given)
    if value.size and not _least(value) > low:
        refuse(name, value, value <= low, _with_unit(Sentence("above {low:g}", low=low), unit), unit)
    return value


def pair_of_diameters(sleeve_diameter: ArrayLike, spool_diameter: ArrayLike) -> tuple[Any, Any]:
    """Return both diameters, the sleeve's at least as large as the spool's."""
    sleeve = positive("sleeve diameter", sleeve_diameter, "m")
    spool = positive("spool diameter", spool_diameter, "m")
    refuse("sleeve diameter", sleeve, sleeve < spool, Sentence("at least the spool's"), "m")
    return sleeve, spool
