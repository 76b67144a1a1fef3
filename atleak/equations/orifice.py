"""Compute flow through a feed orifice, smooth from laminar to turbulent, and through leaks known by one measurement."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from atleak.equations._domain import not_negative, positive, result, values

#: Reynolds number at which flow through an orifice turns from laminar to turbulent [-] (MathWorks, Simscape, Local
#: Restriction (IL), default value).
CRITICAL_REYNOLDS = 150.0


def turbulent_coefficient(diameter: ArrayLike, discharge_coefficient: ArrayLike, density: ArrayLike) -> Any:
    """Compute what the root of the pressure drop is multiplied by in turbulent flow, ``K = C_d A √(2/ρ)``, A = π d²/4.

    Parameters
    ----------
    diameter : float or array
        d, of the orifice [m].
    discharge_coefficient : float or array
        C_d [-].
    density : float or array
        ρ [kg/m³].

    Returns
    -------
    float or ndarray
        K [m³/(s √Pa)].

    Raises
    ------
    DomainError
        Diameter, discharge coefficient or density not positive.

    References
    ----------
    Merritt H. E., Hydraulic Control Systems, Wiley 1967, section 3.4 (flow through orifices).

    Examples
    --------
    A feed of 0.5 mm under 100 kPa, in dm³/min:

    >>> round(turbulent_coefficient(0.5e-3, 0.62, 797.0) * math.sqrt(100e3) * 60e3, 4)
    0.1157
    """
    c_d = positive("discharge coefficient", discharge_coefficient)
    return result(c_d * _area(diameter) * np.sqrt(2.0 / positive("density", density, "kg/m³")))


def transition_pressure(
    diameter: ArrayLike,
    discharge_coefficient: ArrayLike,
    kinematic_viscosity: ArrayLike,
    density: ArrayLike,
    critical_reynolds: ArrayLike = CRITICAL_REYNOLDS,
) -> Any:
    """Compute the pressure drop at which flow turns turbulent, ``Δp_cr = π ρ / (8 A) · (ν Re_cr / C_d)²``, A = π d²/4.

    Parameters
    ----------
    diameter : float or array
        d, of the orifice [m].
    discharge_coefficient : float or array
        C_d [-].
    kinematic_viscosity : float or array
        ν [m²/s].
    density : float or array
        ρ [kg/m³].
    critical_reynolds : float or array, optional
        Re_cr, on the diameter of the orifice and the velocity ``√(2 Δp/ρ)`` times C_d [-].

    Returns
    -------
    float or ndarray
        Δp_cr [Pa].

    Raises
    ------
    DomainError
        Diameter, discharge coefficient, viscosity, density or critical Reynolds number not positive.

    References
    ----------
    MathWorks, Simscape Fluids, block Fixed Orifice (transition by Reynolds number).

    Examples
    --------
    A feed of 0.5 mm at 100 °C, in kPa:

    >>> round(transition_pressure(0.5e-3, 0.62, 6.2e-6, 797.0) / 1e3, 3)
    3.587
    """
    c_d = positive("discharge coefficient", discharge_coefficient)
    nu = positive("kinematic viscosity", kinematic_viscosity, "m²/s")
    rho = positive("density", density, "kg/m³")
    turning = nu * positive("critical Reynolds number", critical_reynolds) / c_d
    return result((math.pi / 8.0) * rho * (turning * turning) / _area(diameter))


def orifice_flow(pressure_drop: ArrayLike, coefficient: ArrayLike, transition: ArrayLike) -> Any:
    """Compute the flow through an orifice, ``Q = K Δp / (Δp² + Δp_cr²)^¼``.

    Parameters
    ----------
    pressure_drop : float or array
        Δp, pressure before the orifice minus pressure behind it [Pa]. A negative drop gives a negative flow.
    coefficient : float or array
        K, of `turbulent_coefficient` [m³/(s √Pa)]; zero where the orifice is shut.
    transition : float or array
        Δp_cr, of `transition_pressure` [Pa].

    Returns
    -------
    float or ndarray
        Volume flow [m³/s].

    Raises
    ------
    DomainError
        Negative coefficient; transition pressure not positive.

    Notes
    -----
    Tends to ``K √Δp`` far above the transition and to the laminar ``K Δp / √Δp_cr`` far below it; at the transition
    it is 16 % below either. It rises with the pressure drop everywhere, as
    `orifice_flow_and_slope` says.

    References
    ----------
    MathWorks, Simscape Fluids, block Fixed Orifice.

    Examples
    --------
    A feed of 0.5 mm from 414 kPa into a circuit that holds 389.1 kPa, at 100 °C, in dm³/min:

    >>> k = turbulent_coefficient(0.5e-3, 0.62, 797.0)
    >>> transition = transition_pressure(0.5e-3, 0.62, 6.2e-6, 797.0)
    >>> round(orifice_flow(414e3 - 389.1e3, k, transition) * 60e3, 4)
    0.0574
    """
    p = values(pressure_drop)
    k = not_negative("turbulent coefficient", coefficient, "m³/(s √Pa)")
    p_cr = positive("transition pressure", transition, "Pa")
    # The root of a root: exact to the last digit alike for numbers and arrays, which a power is not.
    return result(k * p / np.sqrt(np.sqrt(p * p + p_cr * p_cr)))


def orifice_flow_and_slope(pressure_drop: ArrayLike, coefficient: ArrayLike, transition: ArrayLike) -> Any:
    """Compute `orifice_flow`, and how steeply it rises, ``dQ/dΔp = K (Δp²/2 + Δp_cr²) / (Δp² + Δp_cr²)^(5/4)``.

    Parameters
    ----------
    pressure_drop : float or array
        Δp, of either sign [Pa].
    coefficient : float or array
        K, of `turbulent_coefficient` [m³/(s √Pa)]; zero where the orifice is shut.
    transition : float or array
        Δp_cr, of `transition_pressure` [Pa].

    Returns
    -------
    tuple of float or ndarray
        Volume flow [m³/s], and how steeply it rises [m³/(s Pa)]: positive wherever the orifice is open, the same for a
        drop and its negative.

    Raises
    ------
    DomainError
        Negative coefficient; transition pressure not positive.

    References
    ----------
    as `orifice_flow`, and its derivative by the pressure drop.

    Examples
    --------
    Without pressure drop it is the laminar conductance ``K / √Δp_cr``:

    >>> flow, slope = orifice_flow_and_slope(0.0, 6e-9, 3600.0)
    >>> flow, round(slope * 1e9, 12)
    (0.0, 0.1)
    """
    p = values(pressure_drop)
    k = not_negative("turbulent coefficient", coefficient, "m³/(s √Pa)")
    p_cr = positive("transition pressure", transition, "Pa")
    laminar = p_cr * p_cr
    both = p * p + laminar
    root = np.sqrt(np.sqrt(both))
    return result(k * p / root), result(k * (0.5 * (both + laminar)) / (both * root))


def laminar_leak(
    pressure_drop: ArrayLike,
    flow: ArrayLike,
    at_pressure_drop: ArrayLike,
    at_viscosity: ArrayLike,
    dynamic_viscosity: ArrayLike,
) -> Any:
    """Compute a laminar leak from one measurement of it, ``Q = Q₁ (Δp/Δp₁) (μ₁/μ)``.

    Parameters
    ----------
    pressure_drop : float or array
        Δp [Pa]. A negative drop gives a negative flow.
    flow : float or array
        Q₁, measured [m³/s].
    at_pressure_drop : float or array
        Δp₁, at the measurement [Pa].
    at_viscosity : float or array
        μ₁, dynamic viscosity at the measurement [Pa·s].
    dynamic_viscosity : float or array
        μ [Pa·s].

    Returns
    -------
    float or ndarray
        Volume flow [m³/s].

    Raises
    ------
    DomainError
        Negative flow; pressure drop of the measurement or a viscosity not positive.

    Notes
    -----
    For sealing rings and narrow clearances whose size is not known and does not change with pressure.

    References
    ----------
    Merritt H. E., Hydraulic Control Systems, Wiley 1967, section 3.3 (laminar flow in narrow passages).

    Examples
    --------
    Rings that lose 0.05 dm³/min at 400 kPa and 5.6 mPa·s, at half the pressure and twice the viscosity:

    >>> round(laminar_leak(200e3, 0.05 / 60e3, 400e3, 5.6e-3, 11.2e-3) * 60e3, 6)
    0.0125
    """
    q_1 = not_negative("measured leakage", flow, "m³/s")
    p_1 = positive("pressure drop of the measurement", at_pressure_drop, "Pa")
    mu_1 = positive("dynamic viscosity of the measurement", at_viscosity, "Pa·s")
    mu = positive("dynamic viscosity", dynamic_viscosity, "Pa·s")
    return result(q_1 * (values(pressure_drop) / p_1) * (mu_1 / mu))


def orifice_leak(
    pressure_drop: ArrayLike,
    flow: ArrayLike,
    at_pressure_drop: ArrayLike,
    at_density: ArrayLike,
    density: ArrayLike,
) -> Any:
    """Compute a turbulent leak from one measurement of it, ``Q = Q₁ √(Δp/Δp₁ · ρ₁/ρ)``.

    Parameters
    ----------
    pressure_drop : float or array
        Δp [Pa]. A negative drop gives a negative flow.
    flow : float or array
        Q₁, measured [m³/s].
    at_pressure_drop : float or array
        Δp₁, at the measurement [Pa].
    at_density : float or array
        ρ₁, at the measurement [kg/m³].
    density : float or array
        ρ [kg/m³].

    Returns
    -------
    float or ndarray
        Volume flow [m³/s].

    Raises
    ------
    DomainError
        Negative flow; pressure drop of the measurement or a density not positive.

    Notes
    -----
    For a hole, a bleed or a check ball that does not close. Its slope has no bound where the pressure drop is zero.

    References
    ----------
    Merritt H. E., Hydraulic Control Systems, Wiley 1967, section 3.4 (flow through orifices).

    Examples
    --------
    A check ball that loses 0.3 dm³/min at 400 kPa, at a quarter of the pressure:

    >>> round(orifice_leak(100e3, 0.3 / 60e3, 400e3, 797.0, 797.0) * 60e3, 6)
    0.15
    """
    p = values(pressure_drop)
    q_1 = not_negative("measured leakage", flow, "m³/s")
    p_1 = positive("pressure drop of the measurement", at_pressure_drop, "Pa")
    rho_1 = positive("density of the measurement", at_density, "kg/m³")
    rho = positive("density", density, "kg/m³")
    return result(q_1 * np.sign(p) * np.sqrt((np.abs(p) / p_1) * (rho_1 / rho)))


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


def _area(diameter: ArrayLike) -> Any:
    """Return the area of a round orifice [m²]."""
    d = positive("orifice diameter", diameter, "m")
    return (math.pi / 4.0) * (d * d)
