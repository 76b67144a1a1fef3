"""Hold published equations, one pure function each: numbers or arrays in, the same kind out.

Everything is in SI units; a temperature is in °C, a temperature difference in K, a rotational speed in
revolutions per second. Scalars give a Python ``float``, arrays (anything ``numpy.asarray`` takes) broadcast
and give an ``ndarray``; NaN stays NaN. A value outside the domain in which an equation means something raises
:class:`atleak.common.errors.DomainError`, which names the quantity and the first offending value.

Equation numbers follow the cross-references of the source study, Dziubak T., Szczepaniak P., *Modelling
Internal Leakage in the Automatic Transmission Electro-Hydraulic Controller, Taking into Account Operating
Conditions*, Energies 2023, 16(22), 7667, doi 10.3390/en16227667, whose text prints none.
"""

from __future__ import annotations

from atleak.equations import clearance, fluid, gap, orifice, pressure, pump

__all__ = ["clearance", "fluid", "gap", "orifice", "pressure", "pump"]
