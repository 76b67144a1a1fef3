"""Hold published equations, one pure function each: numbers or arrays in, the same kind out.

Everything is in SI units; a temperature is in °C, a temperature difference in K, a rotational speed in
revolutions per second. Scalars give a Python ``float``, arrays (anything ``numpy.asarray`` takes) broadcast
and give an ``ndarray``; NaN stays NaN. A value outside the domain in which an equation means something raises
:class:`DomainError`, which names the quantity and the first offending value. Nothing else of atleak is imported.

Equation numbers follow the cross-references of the source study, Dziubak T., Szczepaniak P., *Modelling
Internal Leakage in the Automatic Transmission Electro-Hydraulic Controller, Taking into Account Operating
Conditions*, Energies 2023, 16(22), 7667, doi 10.3390/en16227667, whose text prints none.
"""

from __future__ import annotations

from collections.abc import Mapping


class DomainError(ValueError):
    """A number outside the domain in which an equation holds.

    Parameters
    ----------
    name
        of the quantity: ``"spring rate"``.
    expected
        what it must be, with places for ``limits``: ``"above {low:g}"``.
    found
        the first value that is not so.
    unit
        of that value and of limits that are numbers; "" where it has none.
    index
        where in an array the value stands.
    limits
        what stands at the places of ``expected``: numbers, or the name of another quantity.
    """

    def __init__(
        self,
        name: str,
        expected: str,
        found: float,
        unit: str = "",
        index: tuple[int, ...] = (),
        limits: Mapping[str, float | str] | None = None,
    ) -> None:
        super().__init__(name, expected, found, unit, index, limits)
        self.name, self.expected, self.found, self.unit, self.index = name, expected, found, unit, index
        self.limits = dict(limits or {})

    @property
    def limited_by_numbers(self) -> bool:
        """Return whether ``expected`` is written with numbers, which have the unit of the quantity."""
        return bool(self.limits) and not any(isinstance(limit, str) for limit in self.limits.values())

    def __str__(self) -> str:
        expected = self.expected.format(**self.limits) if self.limits else self.expected
        unit = f" {self.unit}" if self.unit else ""
        at = f" at index {', '.join(map(str, self.index))}" if self.index else ""
        return f"{self.name} must be {expected}{unit * self.limited_by_numbers}, found {self.found:g}{unit}{at}"
