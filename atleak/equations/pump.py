"""Compute what the crescent pump delivers and what it loses to slip (the study's pump equations, Wilson's slip)."""

from __future__ import annotations

import math
from typing import Any

from numpy.typing import ArrayLike

from atleak.equations._domain import not_negative, positive, result, values, within


def displacement(module: ArrayLike, teeth: ArrayLike, width: ArrayLike, tooth_height: ArrayLike) -> Any:
    """Compute the displacement of an internal-gear pump with a crescent, ``q_p = π m z b h``.

    Parameters
    ----------
    module : float or array
        m, tooth module [m].
    teeth : float or array
        z, teeth of the pinion [-].
    width : float or array
        b, width of pinion and rotor gear [m].
    tooth_height : float or array
        h [m].

    Returns
    -------
    float or ndarray
        Displacement [m³ per revolution].

    Raises
    ------
    DomainError
        A value not positive.

    References
    ----------
    Dziubak & Szczepaniak, Energies 2023, 16, 7667, section 2, pump unit capacity (unnumbered).

    Examples
    --------
    >>> round(displacement(0.0045, 12, 0.012, 0.0084) * 1e9, 3)
    17100.317
    """
    m = positive("tooth module", module, "m")
    z = positive("number of teeth", teeth)
    b = positive("gear width", width, "m")
    h = positive("tooth height", tooth_height, "m")
    return result(math.pi * m * z * b * h)


def capacity(displacement: ArrayLike, speed: ArrayLike, volumetric_efficiency: ArrayLike) -> Any:
    """Compute the flow that a pump delivers, ``Q_p = q_p n η_v``.

    Parameters
    ----------
    displacement : float or array
        q_p [m³ per revolution].
    speed : float or array
        n, of the pump, which is the engine's [1/s].
    volumetric_efficiency : float or array
        η_v, 0 … 1 [-].

    Returns
    -------
    float or ndarray
        Q_p [m³/s].

    Raises
    ------
    DomainError
        Displacement not positive; negative speed; efficiency outside 0 … 1.

    References
    ----------
    Dziubak & Szczepaniak, Energies 2023, 16, 7667, section 2, pump capacity (unnumbered).

    Examples
    --------
    In dm³/min at 2500 revolutions per minute:

    >>> q_p = displacement(0.0045, 12, 0.012, 0.0084)
    >>> round(capacity(q_p, 2500 / 60, 0.95) * 60e3, 3)
    40.613
    """
    q_p = positive("pump displacement", displacement, "m³")
    n = not_negative("pump speed", speed, "1/s")
    return result(q_p * n * within("volumetric efficiency", volumetric_efficiency, 0.0, 1.0))


def slip_flow(
    displacement: ArrayLike, slip_coefficient: ArrayLike, pressure: ArrayLike, dynamic_viscosity: ArrayLike
) -> Any:
    """Compute the flow that slips back inside a pump, whatever its speed, ``q_p C_s Δp / (2 π μ)``.

    Parameters
    ----------
    displacement : float or array
        q_p [m³ per revolution].
    slip_coefficient : float or array
        C_s [-].
    pressure : float or array
        Δp, from suction to delivery [Pa].
    dynamic_viscosity : float or array
        μ [Pa·s].

    Returns
    -------
    float or ndarray
        [m³/s], of the sign of the pressure.

    Raises
    ------
    DomainError
        Displacement or viscosity not positive; negative slip coefficient.

    References
    ----------
    Wilson W. E., Positive-Displacement Pumps and Fluid Motors, Pitman 1950; ``q_p n (1 − η_v)`` with his η_v.

    Examples
    --------
    >>> round(slip_flow(17100.317e-9, 1e-7, 800e3, 8.55819e-3) * 60e3, 3)
    1.526
    """
    q_p = positive("pump displacement", displacement, "m³")
    c_s = not_negative("slip coefficient", slip_coefficient)
    mu = positive("dynamic viscosity", dynamic_viscosity, "Pa·s")
    return result(q_p * c_s * values(pressure) / ((2.0 * math.pi) * mu))


def minimum_speed(leakage: ArrayLike, slip: ArrayLike, displacement: ArrayLike) -> Any:
    """Compute the speed below which the pump cannot make up for what is lost, ``n_min = (q + slip) / q_p``.

    Parameters
    ----------
    leakage : float or array
        q, drawn from the pump by the controller [m³/s].
    slip : float or array
        What slips back inside the pump, of `slip_flow` [m³/s].
    displacement : float or array
        q_p [m³ per revolution].

    Returns
    -------
    float or ndarray
        n_min [1/s]. Below it main pressure cannot be held.

    Raises
    ------
    DomainError
        Displacement not positive.

    References
    ----------
    Balance of the pump, ``q_p n = slip + q``, with the slip of Wilson W. E., Positive-Displacement Pumps and
    Fluid Motors, Pitman 1950.

    Examples
    --------
    In revolutions per minute:

    >>> round(minimum_speed(8e-5, 2.5e-5, 17100.317e-9) * 60, 1)
    368.4
    """
    q_p = positive("pump displacement", displacement, "m³")
    return result((values(leakage) + values(slip)) / q_p)
