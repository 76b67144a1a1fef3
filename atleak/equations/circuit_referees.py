"""Hold a closed form of a fed circuit, as a referee for the solver of `atleak.engine`.

Nothing outside the tests calls it.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from atleak.equations._domain import not_negative, positive, result


def fed_pressure_turbulent(source_pressure: ArrayLike, coefficient: ArrayLike, conductance: ArrayLike) -> Any:
    """Compute the pressure that a circuit holds with one turbulent feed and laminar leaks to the sump.

    ``K √(p_src − p) = G p`` gives ``√(p_src − p) = (−K + √(K² + 4 G² p_src)) / (2 G)``.

    Parameters
    ----------
    source_pressure : float or array
        p_src, before the feed [Pa].
    coefficient : float or array
        K, of `atleak.equations.orifice.turbulent_coefficient` [m³/(s √Pa)].
    conductance : float or array
        G, flow of all leaks together per pressure [m³/(s Pa)].

    Returns
    -------
    float or ndarray
        p [Pa], 0 … p_src.

    Raises
    ------
    DomainError
        Coefficient not positive; negative source pressure or conductance.

    Notes
    -----
    The limit of a feed far above its transition pressure: too high where little flows.

    References
    ----------
    Own derivation from Merritt H. E., Hydraulic Control Systems, Wiley 1967, sections 3.3 and 3.4.

    Examples
    --------
    A circuit that leaks 0.1655 dm³/min at 209.4 kPa behind a feed of 0.5 mm from 414 kPa, in kPa:

    >>> round(fed_pressure_turbulent(414e3, 6.098e-9, 0.1655 / 60e3 / 209.4e3) / 1e3, 1)
    209.4
    """
    p_src = not_negative("source pressure", source_pressure, "Pa")
    k = positive("turbulent coefficient", coefficient, "m³/(s √Pa)")
    g = not_negative("conductance", conductance, "m³/(s Pa)")
    # The root of the quadratic with a sum below the line: nothing cancels, and G = 0 needs no exception.
    root = 2.0 * g * p_src / (k + np.sqrt(k * k + 4.0 * (g * g) * p_src))
    return result(p_src - root * root)
