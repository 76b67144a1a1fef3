"""Compute clearances from diameters, as read, cold and warm (equations 1, 2 and 28)."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from atleak.equations._domain import not_negative, pair_of_diameters, positive, result, values


def diameter_at_reference(
    diameter: ArrayLike, part_expansion: ArrayLike, gauge_expansion: ArrayLike, temperature_rise: ArrayLike
) -> Any:
    """Correct a diameter that was read away from the reference temperature, ``D (1 − (β_part − β_gauge) ΔT)``.

    Part and gauge are at one temperature: a warm gauge has grown too, and what both share does not show.

    Parameters
    ----------
    diameter : float or array
        D, as read [m].
    part_expansion : float or array
        β_part, of the measured part [1/K].
    gauge_expansion : float or array
        β_gauge, of the gauge's scale, or of the master it is set with [1/K].
    temperature_rise : float or array
        ΔT, of part and gauge above the reference temperature of 20 °C [K].

    Returns
    -------
    float or ndarray
        Diameter at the reference temperature [m].

    Raises
    ------
    DomainError
        A diameter not positive; a negative expansion coefficient.

    Notes
    -----
    To the first order in β ΔT. The second is under 2 nm for 20 mm of aluminium at 40 °C.

    References
    ----------
    JCGM 100:2008, eq. (H.2), with gauge and part at one temperature; ISO 1:2022 for the reference temperature.

    Examples
    --------
    An aluminium bore, read at 35 °C with a gauge set in a steel ring, measures 1.5 µm more than at 20 °C:

    >>> round((0.010 - diameter_at_reference(0.010, 21.5e-6, 11.5e-6, 15.0)) * 1e6, 6)
    1.5
    """
    read = positive("diameter", diameter, "m")
    part = not_negative("expansion of the part", part_expansion, "1/K")
    gauge = not_negative("expansion of the gauge", gauge_expansion, "1/K")
    return result(read * (1.0 - (part - gauge) * values(temperature_rise)))


def radial_clearance(sleeve_diameter: ArrayLike, spool_diameter: ArrayLike) -> Any:
    """Compute the radial clearance of a pair from its two diameters, ``(D − d) / 2``.

    Parameters
    ----------
    sleeve_diameter : float or array
        D, inner diameter of the sleeve [m].
    spool_diameter : float or array
        d, outer diameter of the spool or piston [m].

    Returns
    -------
    float or ndarray
        Radial clearance at the temperature of the measurement [m].

    Raises
    ------
    DomainError
        Sleeve smaller than the spool; a diameter not positive.

    References
    ----------
    Dziubak & Szczepaniak, Energies 2023, 16, 7667, eq. (28).

    Examples
    --------
    >>> round(radial_clearance(0.010000, 0.009940) * 1e6, 6)
    30.0
    """
    sleeve, spool = pair_of_diameters(sleeve_diameter, spool_diameter)
    return result((sleeve - spool) * 0.5)


def worn_clearance(mounting_clearance: ArrayLike, wear_increment: ArrayLike) -> Any:
    """Compute the radial clearance after wear, ``c_r = c_m + Δc_e``.

    Parameters
    ----------
    mounting_clearance : float or array
        c_m, radial clearance when new [m].
    wear_increment : float or array
        Δc_e, what wear has added to it [m].

    Returns
    -------
    float or ndarray
        Radial clearance [m].

    Raises
    ------
    DomainError
        Negative mounting clearance; an increment that makes the clearance negative.

    References
    ----------
    Dziubak & Szczepaniak, Energies 2023, 16, 7667, eq. (1).

    Examples
    --------
    >>> round(worn_clearance(24e-6, 12e-6) * 1e6, 6)
    36.0
    """
    mounting = not_negative("mounting clearance", mounting_clearance, "m")
    worn = mounting + values(wear_increment)
    return result(not_negative("worn clearance", worn, "m"))


def wear(radial_clearance: ArrayLike, mounting_clearance: ArrayLike) -> Any:
    """Compute the wear of a pair, ``Z = (c_r − c_m) / c_m``.

    Parameters
    ----------
    radial_clearance : float or array
        c_r, radial clearance as measured [m]; negative where the sleeve measures smaller than the spool.
    mounting_clearance : float or array
        c_m, radial clearance when new [m].

    Returns
    -------
    float or ndarray
        Wear as a fraction [-]: 0.5 is 50 %. Negative for a pair tighter than when new.

    Raises
    ------
    DomainError
        Mounting clearance not positive.

    References
    ----------
    Dziubak & Szczepaniak, Energies 2023, 16, 7667, eq. (1) with the nominal degree of wear of its Table 2.

    Examples
    --------
    >>> round(wear(36e-6, 24e-6), 12)
    0.5
    """
    c_r = values(radial_clearance)
    c_m = positive("mounting clearance", mounting_clearance, "m")
    return result((c_r - c_m) / c_m)


def thermal_rate(
    sleeve_diameter: ArrayLike,
    spool_diameter: ArrayLike,
    body_expansion: ArrayLike,
    spool_expansion: ArrayLike,
) -> Any:
    """Compute how fast a radial clearance opens when body and spool warm up together, ``(β_k D − β_s d) / 2``.

    Parameters
    ----------
    sleeve_diameter : float or array
        D [m].
    spool_diameter : float or array
        d [m].
    body_expansion : float or array
        β_k [1/K].
    spool_expansion : float or array
        β_s [1/K].

    Returns
    -------
    float or ndarray
        Change of radial clearance per temperature [m/K]; negative where the gap closes with heat.

    Raises
    ------
    DomainError
        Sleeve smaller than the spool; a diameter not positive; a negative expansion coefficient.

    References
    ----------
    Dziubak & Szczepaniak, Energies 2023, 16, 7667, eq. (2) with ΔT_k = ΔT_s.

    Examples
    --------
    >>> round(thermal_rate(0.010, 0.010, 21.5e-6, 12e-6) * 1e9, 6)
    47.5
    """
    sleeve, spool = pair_of_diameters(sleeve_diameter, spool_diameter)
    beta_k = not_negative("body expansion", body_expansion, "1/K")
    beta_s = not_negative("spool expansion", spool_expansion, "1/K")
    return result(0.5 * (beta_k * sleeve - beta_s * spool))


def effective_clearance(radial_clearance: ArrayLike, thermal_rate: ArrayLike, temperature_rise: ArrayLike) -> Any:
    """Compute the radial clearance at operating temperature, with body and spool equally warm.

    ``c_re = c_r + (β_k D − β_s d) ΔT / 2``, and zero where the pair binds.

    Parameters
    ----------
    radial_clearance : float or array
        c_r, at the temperature of the measurement [m].
    thermal_rate : float or array
        (β_k D − β_s d) / 2, of `thermal_rate` [m/K].
    temperature_rise : float or array
        ΔT, of body and spool above the temperature of the measurement, 20 ± 0.5 °C [K].

    Returns
    -------
    float or ndarray
        Effective clearance [m], never below zero.

    Raises
    ------
    DomainError
        Never: a clearance below zero, cold or warm, is a pair that binds and leaks nothing.

    Notes
    -----
    Strain by pressure is left out: negligible up to 1000 kPa.

    References
    ----------
    Dziubak & Szczepaniak, Energies 2023, 16, 7667, eq. (2) with ΔT_k = ΔT_s.

    Examples
    --------
    Steel spool in an aluminium body, 60 K warmer:

    >>> rate = thermal_rate(0.01006, 0.010, 21.5e-6, 12e-6)
    >>> round(effective_clearance(30e-6, rate, 60.0) * 1e6, 4)
    32.8887
    """
    warm = values(radial_clearance) + values(thermal_rate) * values(temperature_rise)
    return result(np.maximum(warm, 0.0))


def cube_mean(low: ArrayLike, high: ArrayLike) -> Any:
    """Compute the clearance whose cube is the mean cube of a range, all of it alike likely.

    ``c = ((high⁴ − low⁴) / (4 (high − low)))^(1/3)``, written as a sum so that equal ends need no exception.

    Parameters
    ----------
    low, high : float or array
        Ends of the range of radial clearances [m].

    Returns
    -------
    float or ndarray
        The clearance that leaks as much as the pairs of the range do on average [m].

    Raises
    ------
    DomainError
        A negative clearance.

    References
    ----------
    Mean of c³ over a rectangular distribution; the flow goes with the cube, Dziubak & Szczepaniak, Energies 2023, 16,
    7667, eq. (4).

    Examples
    --------
    >>> round(cube_mean(6.4e-6, 20e-6) * 1e6, 2)
    14.28
    """
    a, b = not_negative("radial clearance", low, "m"), not_negative("radial clearance", high, "m")
    return result(np.cbrt(0.25 * (a + b) * (a * a + b * b)))


def seen_of_one_sided(angle: ArrayLike, exponent: float = 1.0) -> Any:
    """Compute what one two-point diameter shows of wear to one side, over the mean of that wear.

    A diameter at the angle θ from the worn side grows by ``w₀ |cos θ|^n``, and half of that is taken as clearance:
    ``|cos θ|^n / 2`` over m(n), the mean of ``max(cos θ, 0)^n``.

    Parameters
    ----------
    angle : float or array
        θ, between the diameter and the middle of the worn side [rad].
    exponent : float, optional
        n of the profile [-].

    Returns
    -------
    float or ndarray
        What shows of the mean wear [-]; 1 on average over all angles.

    Raises
    ------
    DomainError
        An exponent that is not positive.

    References
    ----------
    Follows from the profile, as `one_sided_moments` has it.

    Examples
    --------
    >>> round(seen_of_one_sided(0.0), 4), round(seen_of_one_sided(0.0, 2.0), 4)
    (1.5708, 2.0)
    """
    mean = _mean_of_one_sided(float(positive("exponent", exponent)))
    return result(0.5 * np.abs(np.cos(values(angle))) ** exponent / mean)


def one_sided_moments(mean_wear: ArrayLike, exponent: float = 1.0) -> tuple[Any, Any]:
    """Compute how wear to one side spreads the clearance around the circumference.

    The bore is taken as worn by ``w₀ max(cos θ, 0)^n``, whose mean is w₀ m(n), with ``m(n) = B((n + 1)/2, 1/2) / 2π``.
    With a and b for m(2n)/m(n)² and m(3n)/m(n)³ the moments are ``(a − 1) w²`` and ``(b − 3a + 2) w³``.

    Parameters
    ----------
    mean_wear : float or array
        Mean over the circumference of what wear has added to the radial clearance on one side [m].
    exponent : float, optional
        n [-]: 1 for a half cosine; the larger, the sharper the crescent.

    Returns
    -------
    tuple of float or ndarray
        Second [m²] and third [m³] central moment of the clearance over the circumference.

    Raises
    ------
    DomainError
        A negative mean wear; an exponent that is not positive.

    References
    ----------
    The beta function as an integral of powers of a cosine: NIST Digital Library of Mathematical Functions, 5.12.2. For
    n = 1 the moments are (π²/4 − 1) w² and (2 − π²/12) w³. That a bore wears to one side is the trade's experience; the
    profile is a choice of this project.

    Examples
    --------
    >>> square, cube = one_sided_moments(10e-6)
    >>> round(square * 1e12, 2), round(cube * 1e18, 1)
    (146.74, 1177.5)
    """
    w = not_negative("mean wear", mean_wear, "m")
    n = float(positive("exponent", exponent))
    mean, square, cube = (_mean_of_one_sided(power * n) for power in (1.0, 2.0, 3.0))
    a, b = square / mean**2, cube / mean**3
    return result((a - 1.0) * (w * w)), result((b - 3.0 * a + 2.0) * (w * w * w))


def _mean_of_one_sided(exponent: float) -> float:
    """Return the mean of max(cos θ, 0)^n around the circumference: 1/π, 1/4 and 2/(3π) for n of 1, 2 and 3."""
    return math.gamma(0.5 * (exponent + 1.0)) / (2.0 * math.sqrt(math.pi) * math.gamma(0.5 * exponent + 1.0))
