"""Hold published equations that only tests use, as referees for those that the product uses.

Nothing outside the tests calls them. Each gives in another way, or for a more general case, what an equation of this
package gives, so that a test can hold one against the other.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from atleak.equations._domain import (
    NOT_UNDER_SPOOL,
    net_areas,
    not_negative,
    pair_of_diameters,
    positive,
    refuse,
    result,
    values,
)
from atleak.errors import DomainError
from atleak.sentence import Sentence

# cosh L - sinh L / L = L² · (1/3 + L²/30 + L⁴/840 + …); the term of L^(2k) is 2k/(2k + 1)!
_ANNULUS_SERIES = tuple(2 * k / math.factorial(2 * k + 1) for k in range(9, 0, -1))

#: Highest modulated and control pressure of the source study, set by its solenoid valves [Pa].
MODULATED_LIMIT = 500e3


def effective_clearance_two_temperatures(
    radial_clearance: ArrayLike,
    sleeve_diameter: ArrayLike,
    spool_diameter: ArrayLike,
    body_expansion: ArrayLike,
    spool_expansion: ArrayLike,
    body_rise: ArrayLike,
    spool_rise: ArrayLike,
) -> Any:
    """Compute the radial clearance with body and spool at temperatures of their own.

    ``c_re = c_r + (β_k D ΔT_k − β_s d ΔT_s) / 2``

    Parameters
    ----------
    radial_clearance : float or array
        c_r, at the temperature of the measurement [m].
    sleeve_diameter : float or array
        D [m].
    spool_diameter : float or array
        d [m].
    body_expansion : float or array
        β_k, linear expansion coefficient of the body [1/K].
    spool_expansion : float or array
        β_s, linear expansion coefficient of the spool [1/K].
    body_rise : float or array
        ΔT_k, temperature of the body minus that of the measurement, 20 ± 0.5 °C [K].
    spool_rise : float or array
        ΔT_s, the same of the spool [K].

    Returns
    -------
    float or ndarray
        Effective clearance [m].

    Raises
    ------
    DomainError
        Negative clearance, cold or effective (the pair binds); sleeve smaller than the spool; a diameter not
        positive; a negative expansion coefficient.

    Notes
    -----
    Strain by pressure is left out: negligible up to 1000 kPa.

    References
    ----------
    Dziubak & Szczepaniak, Energies 2023, 16, 7667, eq. (2).

    Examples
    --------
    Steel spool in an aluminium body, 60 K warmer:

    >>> c_re = effective_clearance_two_temperatures(30e-6, 0.01006, 0.010, 21.5e-6, 12e-6, 60.0, 60.0)
    >>> round(c_re * 1e6, 4)
    32.8887
    """
    c_r = not_negative("radial clearance", radial_clearance, "m")
    sleeve, spool = pair_of_diameters(sleeve_diameter, spool_diameter)
    beta_k = not_negative("body expansion", body_expansion, "1/K")
    beta_s = not_negative("spool expansion", spool_expansion, "1/K")
    opening = beta_k * sleeve * values(body_rise) - beta_s * spool * values(spool_rise)
    return result(not_negative("effective clearance", c_r + 0.5 * opening, "m"))


def annular_flow_compressible(
    pressure_drop: ArrayLike,
    diameter: ArrayLike,
    clearance: ArrayLike,
    dynamic_viscosity: ArrayLike,
    contact_length: ArrayLike,
    mean_density: ArrayLike,
    reference_density: ArrayLike,
) -> Any:
    """Compute the laminar leakage through a thin concentric gap of a fluid whose density depends on pressure.

    ``q = π Δp d c³ ρ(p̄) / (12 μ l ρ(0))``

    Parameters
    ----------
    pressure_drop : float or array
        Pressure before the gap minus pressure behind it [Pa].
    diameter : float or array
        Diameter of the gap [m].
    clearance : float or array
        Radial clearance [m].
    dynamic_viscosity : float or array
        [Pa·s].
    contact_length : float or array
        [m].
    mean_density : float or array
        Density at the mean pressure in the gap [kg/m³].
    reference_density : float or array
        Density at atmospheric pressure [kg/m³].

    Returns
    -------
    float or ndarray
        Volume flow referred to atmospheric pressure [m³/s].

    Raises
    ------
    DomainError
        Negative clearance; diameter, viscosity, contact length or a density not positive.

    Notes
    -----
    Between 0.1 and 30 MPa the source study sets the ratio of densities to 1, which gives `annular_flow`. Its
    text gives μ in Pa·s beside a factor that closes only for mPa·s; in SI units no factor remains.

    References
    ----------
    Dziubak & Szczepaniak, Energies 2023, 16, 7667, eq. (3).

    Examples
    --------
    >>> q = annular_flow_compressible(800e3, 0.010, 30e-6, 8.55819e-3, 0.008, 783.0, 783.0)
    >>> round(q * 1e9, 1)
    825.9
    """
    p = values(pressure_drop)
    d = positive("diameter", diameter, "m")
    c = not_negative("radial clearance", clearance, "m")
    mu = positive("dynamic viscosity", dynamic_viscosity, "Pa·s")
    length = positive("contact length", contact_length, "m")
    mean = positive("mean density", mean_density, "kg/m³")
    reference = positive("reference density", reference_density, "kg/m³")
    return result((math.pi / 12.0) * (d * (c * c * c) / length) * p / mu * (mean / reference))


def exact_annulus_flow(
    pressure_drop: ArrayLike,
    spool_diameter: ArrayLike,
    sleeve_diameter: ArrayLike,
    dynamic_viscosity: ArrayLike,
    contact_length: ArrayLike,
) -> Any:
    """Compute the laminar flow through a concentric annulus of any thickness.

    ``q = π Δp / (8 μ l) · [r_o⁴ − r_i⁴ − (r_o² − r_i²)² / ln(r_o/r_i)]``, evaluated as
    ``π Δp / (2 μ l) · (r_i r_o)² · sinh L · (cosh L − sinh L / L)`` with ``L = ln(r_o/r_i)``, which loses no
    digits in a thin gap.

    Parameters
    ----------
    pressure_drop : float or array
        Pressure before the gap minus pressure behind it [Pa].
    spool_diameter : float or array
        Outer diameter of the spool [m].
    sleeve_diameter : float or array
        Inner diameter of the sleeve [m].
    dynamic_viscosity : float or array
        [Pa·s].
    contact_length : float or array
        [m].

    Returns
    -------
    float or ndarray
        Volume flow [m³/s].

    Raises
    ------
    DomainError
        Sleeve smaller than the spool; spool diameter, viscosity or contact length not positive.

    Notes
    -----
    Fully developed laminar flow of a fluid of constant viscosity. The thin-gap law on the mean diameter
    differs from this by about (c/r)²/60, on the spool's diameter it is low by about c/d.

    References
    ----------
    Bird R. B., Stewart W. E., Lightfoot E. N., Transport Phenomena, 2nd ed., Wiley 2002, section 2.4.

    Examples
    --------
    >>> exact = exact_annulus_flow(800e3, 0.010, 0.01006, 8.55819e-3, 0.008)
    >>> round(exact * 1e9, 1)
    828.4
    >>> thin = annular_flow_compressible(800e3, 0.01003, 30e-6, 8.55819e-3, 0.008, 1.0, 1.0)
    >>> abs(thin / exact - 1) < 1e-6
    True
    """
    p = values(pressure_drop)
    d = positive("spool diameter", spool_diameter, "m")
    sleeve = positive("sleeve diameter", sleeve_diameter, "m")
    gap = sleeve - d
    refuse("sleeve diameter", sleeve, gap < 0.0, NOT_UNDER_SPOOL, "m")
    mu = positive("dynamic viscosity", dynamic_viscosity, "Pa·s")
    length = positive("contact length", contact_length, "m")

    logarithm = np.log1p(gap / d)
    square = logarithm * logarithm
    series = np.zeros_like(square)
    for coefficient in _ANNULUS_SERIES:
        series = (series + coefficient) * square
    # The series is exact to the last digit up to L = 1; beyond that the closed form loses none.
    wide = np.maximum(logarithm, 1.0)
    shape = np.where(logarithm <= 1.0, series, np.cosh(wide) - np.sinh(wide) / wide)
    area = 0.25 * d * sleeve
    return result((math.pi / 2.0) * (area * area / length) * np.sinh(logarithm) * shape * p / mu)


def taper_cube(c1: ArrayLike, c2: ArrayLike) -> Any:
    """Compute the effective cubed clearance of a gap that narrows or widens linearly along its length.

    ``2 c₁² c₂² / (c₁ + c₂)``

    Parameters
    ----------
    c1, c2 : float or array
        Radial clearance at the two ends [m].

    Returns
    -------
    float or ndarray
        What stands for c³ in the gap law [m³]; zero where either end is closed.

    Raises
    ------
    DomainError
        Negative clearance.

    References
    ----------
    The harmonic mean of c³ along the gap, ``1 / mean(c⁻³)`` (see `axial_cube`), integrated for a straight
    taper.

    Examples
    --------
    >>> round(taper_cube(20e-6, 40e-6) ** (1 / 3) * 1e6, 3)
    27.734
    """
    a = not_negative("radial clearance", c1, "m")
    b = not_negative("radial clearance", c2, "m")
    total = a + b
    product = a * b
    return result(2.0 * (product * product) / np.where(total == 0.0, 1.0, total))


def oval_cube(mean_clearance: ArrayLike, lobe_amplitude: ArrayLike) -> Any:
    """Compute the effective cubed clearance of a two-lobe out-of-round gap, ``c(θ) = c₀ + a cos 2θ``.

    ``c₀³ (1 + 1.5 (a/c₀)²)``

    Parameters
    ----------
    mean_clearance : float or array
        c₀, radial clearance averaged over the circumference [m].
    lobe_amplitude : float or array
        a [m], of either sign; the two perpendicular diameters differ by 4a.

    Returns
    -------
    float or ndarray
        What stands for c³ in the gap law [m³].

    Raises
    ------
    DomainError
        Negative mean clearance; amplitude larger than the mean clearance.

    References
    ----------
    Average of ``(c₀ + a cos 2θ)³`` over the circumference; the same integral as for eccentricity, Dziubak &
    Szczepaniak, Energies 2023, 16, 7667, eq. (5).

    Examples
    --------
    >>> round(oval_cube(30e-6, 10e-6) / 30e-6**3, 6)
    1.166667
    """
    c = not_negative("mean radial clearance", mean_clearance, "m")
    a = values(lobe_amplitude)
    refuse("lobe amplitude", a, np.abs(a) > c, Sentence("at most the mean radial clearance"), "m")
    return result(c * (c * c + 1.5 * (a * a)))


def pressure_force(pressure: ArrayLike, area: ArrayLike) -> Any:
    """Compute the force of a pressure on an area, ``F = p A``.

    Parameters
    ----------
    pressure : float or array
        [Pa].
    area : float or array
        [m²].

    Returns
    -------
    float or ndarray
        [N].

    Raises
    ------
    DomainError
        Negative area.

    References
    ----------
    Dziubak & Szczepaniak, Energies 2023, 16, 7667, eq. (7) and (8); from kPa and mm² a factor 10⁻³ is needed
    that the article does not print.

    Examples
    --------
    >>> round(pressure_force(800e3, 58.905e-6), 3)
    47.124
    """
    return result(values(pressure) * not_negative("area", area, "m²"))


def spool_balance(
    control_pressure: ArrayLike,
    main_pressure: ArrayLike,
    spring_force: ArrayLike,
    a_1: ArrayLike,
    a_2w: ArrayLike,
    a_3w: ArrayLike,
    a_g1: ArrayLike,
    a_g2: ArrayLike,
) -> Any:
    """Compute what is left of the forces on the spool of valve 17; zero in equilibrium.

    ``F_s1 − F_g1 + F_g2 − F_s2 + F_s3 − F_sp``, with control pressure on A_1, A_2W and A_3W, main pressure on
    A_g1 and A_g2.

    Parameters
    ----------
    control_pressure : float or array
        p_s [Pa].
    main_pressure : float or array
        p_g [Pa].
    spring_force : float or array
        F_sp [N].
    a_1 : float or array
        Full end face [m²].
    a_2w, a_3w : float or array
        Rings that control pressure acts on [m²].
    a_g1, a_g2 : float or array
        Rings that main pressure acts on [m²].

    Returns
    -------
    float or ndarray
        Residual force [N].

    Raises
    ------
    DomainError
        Negative area.

    References
    ----------
    Dziubak & Szczepaniak, Energies 2023, 16, 7667, eq. (6) with (7) and (8).

    Examples
    --------
    >>> round(spool_balance(400e3, 800e3, 20.0, 113.1e-6, 58.9e-6, 44.0e-6, 58.9e-6, 44.0e-6), 3)
    7.36
    """
    p_s, p_g = values(control_pressure), values(main_pressure)
    control, main = net_areas(a_1, a_2w, a_3w, a_g1, a_g2)
    return result(p_s * control - p_g * main - values(spring_force))


def modulated_pressure(main_pressure: ArrayLike, ratio: ArrayLike, limit: ArrayLike = MODULATED_LIMIT) -> Any:
    """Compute the modulated pressure, proportional to main pressure up to a limit: ``p_m = min(α_m p_g, limit)``.

    Parameters
    ----------
    main_pressure : float or array
        p_g [Pa].
    ratio : float or array
        α_m, found on road tests [-].
    limit : float or array, optional
        [Pa].

    Returns
    -------
    float or ndarray
        p_m [Pa].

    Raises
    ------
    DomainError
        Negative ratio; limit not positive.

    References
    ----------
    Dziubak & Szczepaniak, Energies 2023, 16, 7667, eq. (14).

    Examples
    --------
    >>> modulated_pressure([600e3, 1200e3], 0.5).tolist()
    [300000.0, 500000.0]
    """
    alpha = not_negative("pressure ratio", ratio)
    highest = positive("limit of modulated pressure", limit, "Pa")
    return result(np.minimum(alpha * values(main_pressure), highest))


def wilson_efficiency(
    slip_coefficient: ArrayLike, pressure: ArrayLike, dynamic_viscosity: ArrayLike, speed: ArrayLike
) -> Any:
    """Compute the volumetric efficiency of a pump with laminar slip, ``η_v = 1 − C_s Δp / (μ ω)``, ``ω = 2 π n``.

    Parameters
    ----------
    slip_coefficient : float or array
        C_s [-].
    pressure : float or array
        Δp, from suction to delivery [Pa].
    dynamic_viscosity : float or array
        μ [Pa·s].
    speed : float or array
        n [1/s].

    Returns
    -------
    float or ndarray
        η_v [-]. Not clipped: zero or below means that the pump cannot hold this pressure at this speed.

    Raises
    ------
    DomainError
        Negative slip coefficient; viscosity or speed not positive. For a pump at rest use `slip_flow`.

    References
    ----------
    Wilson W. E., Positive-Displacement Pumps and Fluid Motors, Pitman 1950.

    Examples
    --------
    >>> round(wilson_efficiency(1e-7, 800e3, 8.55819e-3, 2500 / 60), 4)
    0.9643
    """
    c_s = not_negative("slip coefficient", slip_coefficient)
    mu = positive("dynamic viscosity", dynamic_viscosity, "Pa·s")
    n = positive("pump speed", speed, "1/s")
    return result(1.0 - c_s * values(pressure) / ((2.0 * math.pi) * mu * n))


def circumferential_cube(clearances: ArrayLike, axis: int = -1) -> Any:
    """Compute the effective cubed clearance of clearances measured around the circumference, ``mean(c³)``.

    Parameters
    ----------
    clearances : array
        Radial clearances at equally spaced directions [m]; a scalar counts as one direction.
    axis : int, optional
        The axis along which the directions lie; it disappears.

    Returns
    -------
    float or ndarray
        What stands for c³ in the gap law [m³]. Never below the cube of the mean clearance.

    Raises
    ------
    DomainError
        Negative clearance, or none at all.

    References
    ----------
    Paths side by side add their flows; the thin-gap law, Dziubak & Szczepaniak, Energies 2023, 16, 7667,
    eq. (4), integrated around the circumference.

    Examples
    --------
    >>> round(circumferential_cube([20e-6, 40e-6]) ** (1 / 3) * 1e6, 3)
    33.019
    """
    c = _several(clearances, axis)
    return result(np.mean(c * c * c, axis=axis))


def axial_cube(clearances: ArrayLike, axis: int = -1) -> Any:
    """Compute the effective cubed clearance of clearances measured along the length, ``1 / mean(c⁻³)``.

    Parameters
    ----------
    clearances : array
        Radial clearances at equally spaced planes [m]; a scalar counts as one plane.
    axis : int, optional
        The axis along which the planes lie; it disappears.

    Returns
    -------
    float or ndarray
        What stands for c³ in the gap law [m³]. Zero where one plane is closed.

    Raises
    ------
    DomainError
        Negative clearance, or none at all.

    References
    ----------
    Paths one behind the other add their pressure drops; the thin-gap law, Dziubak & Szczepaniak, Energies
    2023, 16, 7667, eq. (4), integrated along the gap.

    Examples
    --------
    >>> round(axial_cube([20e-6, 40e-6]) ** (1 / 3) * 1e6, 3)
    24.228
    """
    c = _several(clearances, axis)
    with np.errstate(divide="ignore", over="ignore"):
        resistance = np.mean(1.0 / (c * c * c), axis=axis)
        return result(1.0 / resistance)


def _several(clearances: ArrayLike, axis: int) -> Any:
    """Return clearances along an axis, at least one."""
    c = np.atleast_1d(not_negative("radial clearance", clearances, "m"))
    if c.shape[axis] == 0:
        raise DomainError(
            Sentence("radial clearances must be at least one along the axis that is averaged, found none")
        )
    return c
