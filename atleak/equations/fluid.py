"""Compute viscosity and density of automatic transmission fluid over temperature (equations 29 and 30, ASTM D341)."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from atleak.equations import DomainError
from atleak.equations._domain import above, positive, refuse, result, values, within

#: Temperatures for which the source study states its regressions [°C].
STUDY_LOWEST, STUDY_HIGHEST = -40.0, 100.0

#: Below this temperature ASTM D341 under-predicts real fluids [°C].
ASTM_D341_RELIABLE_FROM = -20.0

#: Kinematic viscosity at or below which the double logarithm of ASTM D341 does not exist [m²/s].
ASTM_D341_LOWEST_VISCOSITY = 0.3e-6

#: Of the study's regressions, eqs. (29) and (30): ν [mm²/s] is the first of a pair times e to the second times T,
#: ρ [kg/m³] the first and the second times T, with T in °C.
STUDY_VISCOSITY = (343.92, -0.043)
STUDY_DENSITY = (840.9, -0.7)

#: What ASTM D341 adds to a kinematic viscosity [mm²/s] before it takes logarithms.
ASTM_D341_SHIFT = 0.7

#: [°C].
ABSOLUTE_ZERO = -273.15
_LN10 = math.log(10.0)
_LN_LN10 = math.log(_LN10)


def study_viscosity(temperature: ArrayLike) -> Any:
    """Compute the kinematic viscosity of the source study's fluid by its regression, ``ν = 343.92 e^(−0.043 T)`` mm²/s.

    Parameters
    ----------
    temperature : float or array
        [°C], −40 … 100.

    Returns
    -------
    float or ndarray
        Kinematic viscosity [m²/s].

    Raises
    ------
    DomainError
        Temperature outside −40 … 100 °C.

    Notes
    -----
    R² is 0.9853. The regression is no replacement for a data sheet: at 40 and 100 °C it gives 61.6 and
    4.67 mm²/s where the study's own table uses 42 and 7.0, and at −40 °C 1923 where real fluids have some
    35 000.

    References
    ----------
    Dziubak & Szczepaniak, Energies 2023, 16, 7667, eq. (29).

    Examples
    --------
    >>> round(study_viscosity(-40.0) * 1e6)
    1921
    """
    t = within("temperature", temperature, STUDY_LOWEST, STUDY_HIGHEST, "°C")
    return result(STUDY_VISCOSITY[0] * 1e-6 * np.exp(STUDY_VISCOSITY[1] * t))


def study_density(temperature: ArrayLike) -> Any:
    """Compute the density of the source study's fluid by its regression, ``ρ = −0.0007 T + 0.8409`` g/cm³.

    Parameters
    ----------
    temperature : float or array
        [°C], −40 … 100.

    Returns
    -------
    float or ndarray
        Density [kg/m³].

    Raises
    ------
    DomainError
        Temperature outside −40 … 100 °C.

    Notes
    -----
    About 4 % below real fluids at 15 °C.

    References
    ----------
    Dziubak & Szczepaniak, Energies 2023, 16, 7667, eq. (30).

    Examples
    --------
    >>> round(study_density(80.0), 1)
    784.9
    """
    t = within("temperature", temperature, STUDY_LOWEST, STUDY_HIGHEST, "°C")
    return result(STUDY_DENSITY[0] + STUDY_DENSITY[1] * t)


def astm_d341_coefficients(
    temperature_1: ArrayLike, viscosity_1: ArrayLike, temperature_2: ArrayLike, viscosity_2: ArrayLike
) -> tuple[Any, Any]:
    """Compute the two constants of ASTM D341 from two data-sheet points.

    ``log₁₀ log₁₀(ν + 0.7) = A − B log₁₀ T`` with ν in mm²/s and T in K.

    Parameters
    ----------
    temperature_1, temperature_2 : float or array
        Temperatures of the two points [°C], in either order.
    viscosity_1, viscosity_2 : float or array
        Kinematic viscosities there [m²/s].

    Returns
    -------
    A, B : float or ndarray
        The constants as the standard defines them, for ν in mm²/s [-].

    Raises
    ------
    DomainError
        Temperature at or below absolute zero; both temperatures equal; a viscosity of 0.3 mm²/s or less,
        where the double logarithm does not exist; viscosity rising with temperature.

    Notes
    -----
    The standard's short form, with the constant 0.7, holds from 2 to 2·10⁷ mm²/s.

    References
    ----------
    ASTM D341, Standard Practice for Viscosity-Temperature Equations and Charts for Liquid Petroleum or
    Hydrocarbon Products.

    Examples
    --------
    >>> A, B = astm_d341_coefficients(40.0, 42.0e-6, 100.0, 7.0e-6)
    >>> round(A, 4), round(B, 4)
    (8.8874, 3.4759)
    """
    t_1 = above("temperature", temperature_1, ABSOLUTE_ZERO, "°C")
    t_2 = above("temperature", temperature_2, ABSOLUTE_ZERO, "°C")
    refuse("second temperature", t_2, t_1 == t_2, "different from the first", "°C")
    nu_1 = above("kinematic viscosity", viscosity_1, ASTM_D341_LOWEST_VISCOSITY, "m²/s")
    nu_2 = above("kinematic viscosity", viscosity_2, ASTM_D341_LOWEST_VISCOSITY, "m²/s")
    rising = (nu_2 - nu_1) * np.sign(t_2 - t_1) > 0.0
    name = "second kinematic viscosity"
    refuse(name, nu_2, rising, "such that viscosity falls as temperature rises", "m²/s")
    x_1, x_2 = np.log10(t_1 - ABSOLUTE_ZERO), np.log10(t_2 - ABSOLUTE_ZERO)
    y_1 = np.log10(np.log10(1e6 * nu_1 + ASTM_D341_SHIFT))
    y_2 = np.log10(np.log10(1e6 * nu_2 + ASTM_D341_SHIFT))
    slope = (y_1 - y_2) / (x_2 - x_1)
    return result(y_1 + slope * x_1), result(slope)


def astm_d341(temperature: ArrayLike, A: ArrayLike, B: ArrayLike) -> Any:
    """Compute the kinematic viscosity at a temperature by ASTM D341 (Walther's equation).

    ``log₁₀ log₁₀(ν + 0.7) = A − B log₁₀ T`` with ν in mm²/s and T in K.

    Parameters
    ----------
    temperature : float or array
        [°C].
    A, B : float or array
        The constants of `astm_d341_coefficients` [-].

    Returns
    -------
    float or ndarray
        Kinematic viscosity [m²/s].

    Raises
    ------
    DomainError
        Temperature at or below absolute zero, or so low that the viscosity exceeds every number.

    Notes
    -----
    Follows the data sheet between and somewhat beyond its two points. `astm_d341_reliable` says
    where it does not; below the pour point a fluid has no viscosity to compute, which the equation cannot
    know.

    References
    ----------
    ASTM D341, Standard Practice for Viscosity-Temperature Equations and Charts for Liquid Petroleum or
    Hydrocarbon Products.

    Examples
    --------
    >>> A, B = astm_d341_coefficients(40.0, 42.0e-6, 100.0, 7.0e-6)
    >>> round(astm_d341(80.0, A, B) * 1e6, 2)
    11.15
    """
    t = above("temperature", temperature, ABSOLUTE_ZERO, "°C")
    # 10^10^(A − B log₁₀ T) with natural functions, the second base folded into the first exponent; worked out in one
    # array, because taking fresh memory costs more than the arithmetic
    shape = np.broadcast_shapes(t.shape, np.shape(A), np.shape(B))
    nu = np.subtract(t, ABSOLUTE_ZERO, out=np.empty(shape))
    np.log(nu, out=nu)
    nu *= -values(B)
    nu += values(A) * _LN10 + _LN_LN10
    try:
        with np.errstate(over="raise"):
            np.exp(nu, out=nu)
            np.exp(nu, out=nu)
    except FloatingPointError:
        lowest = float(np.nanmin(t))
        raise DomainError("temperature", "one at which ASTM D341 is finite", lowest, "°C") from None
    nu -= ASTM_D341_SHIFT
    nu *= 1e-6
    return result(nu)


def astm_d341_reliable(temperature: ArrayLike) -> Any:
    """Tell whether ASTM D341 can be relied on at a temperature.

    Below −20 °C real fluids (Brookfield) are 1.2 to 3.4 times as viscous as it says.

    Parameters
    ----------
    temperature : float or array
        [°C].

    Returns
    -------
    bool or ndarray of bool
        True from −20 °C upwards; False below it and for NaN.

    References
    ----------
    ASTM D341 against published Brookfield viscosities of automatic transmission fluids.

    Examples
    --------
    >>> astm_d341_reliable(80.0)
    True
    >>> astm_d341_reliable([-40.0, -20.0]).tolist()
    [False, True]
    """
    reliable = values(temperature) >= ASTM_D341_RELIABLE_FROM
    return bool(reliable) if np.ndim(reliable) == 0 else reliable


def dynamic_viscosity(kinematic_viscosity: ArrayLike, density: ArrayLike) -> Any:
    """Compute the dynamic viscosity, ``μ = ν ρ``.

    Parameters
    ----------
    kinematic_viscosity : float or array
        [m²/s].
    density : float or array
        [kg/m³].

    Returns
    -------
    float or ndarray
        [Pa·s].

    Raises
    ------
    DomainError
        Viscosity or density not positive.

    References
    ----------
    Dziubak & Szczepaniak, Energies 2023, 16, 7667, below eq. (3).

    Examples
    --------
    >>> round(dynamic_viscosity(10.93e-6, 783.0) * 1e3, 4)
    8.5582
    """
    nu = positive("kinematic viscosity", kinematic_viscosity, "m²/s")
    rho = positive("density", density, "kg/m³")
    return result(nu * rho)
