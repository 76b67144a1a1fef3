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

from atleak.equations import DomainError


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


def refuse(
    name: str, value: NDArray[np.float64], bad: NDArray[np.bool_], expected: str, unit: str = "", **limits: float | str
) -> None:
    """Raise DomainError for the first value marked bad, if there is one."""
    bad = np.asarray(bad)
    if bad.any():
        index = np.unravel_index(int(np.argmax(bad)), bad.shape)
        first = float(np.broadcast_to(value, bad.shape)[index])
        raise DomainError(name, expected, first, unit, tuple(map(int, index)), limits)


def positive(name: str, given: ArrayLike, unit: str = "") -> NDArray[np.float64]:
    """Return the values, all of them above zero."""
    if isinstance(given, float) and given > 0.0:
        return np.float64(given)  # type: ignore[return-value]
    value = values(given)
    if value.size and not _least(value) > 0.0:
        refuse(name, value, value <= 0.0, "positive", unit)
    return value


def not_negative(name: str, given: ArrayLike, unit: str = "") -> NDArray[np.float64]:
    """Return the values, none of them below zero."""
    if isinstance(given, float) and given >= 0.0:
        return np.float64(given)  # type: ignore[return-value]
    value = values(given)
    if value.size and not _least(value) >= 0.0:
        refuse(name, value, value < 0.0, "zero or positive", unit)
    return value


def within(name: str, given: ArrayLike, low: float, high: float, unit: str = "") -> NDArray[np.float64]:
    """Return the values, all of them between low and high, both included."""
    value = values(given)
    if value.size and not (_least(value) >= low and _most(value) <= high):
        outside = (value < low) | (value > high)
        refuse(name, value, outside, "between {low:g} and {high:g}", unit, low=low, high=high)
    return value


def above(name: str, given: ArrayLike, low: float, unit: str = "") -> NDArray[np.float64]:
    """Return the values, all of them above low."""
    value = values(given)
    if value.size and not _least(value) > low:
        refuse(name, value, value <= low, "above {low:g}", unit, low=low)
    return value


def pair_of_diameters(sleeve_diameter: ArrayLike, spool_diameter: ArrayLike) -> tuple[Any, Any]:
    """Return both diameters, the sleeve's at least as large as the spool's."""
    sleeve = positive("sleeve diameter", sleeve_diameter, "m")
    spool = positive("spool diameter", spool_diameter, "m")
    refuse("sleeve diameter", sleeve, sleeve < spool, "at least the spool's", "m")
    return sleeve, spool
