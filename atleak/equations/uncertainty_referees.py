"""Hold closed forms for the cube of a normal variable and for sums, as referees for the draws of `atleak.uncertainty`.

Nothing outside the tests calls them: the product draws, because more than a clearance is uncertain of a flow. Where
nothing else is, a test holds the draws against these.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from atleak.equations._domain import not_negative, positive, result, values, within
from atleak.equations.uncertainty import normal_cdf, normal_quantile

_DENSITY_AT_ZERO = 1.0 / math.sqrt(2.0 * math.pi)


def normal_density(deviate: ArrayLike) -> Any:
    """Compute the density of the standard normal distribution, ``φ(z) = exp(−z²/2)/√(2π)``."""
    z = values(deviate)
    return result(_DENSITY_AT_ZERO * np.exp(-0.5 * z * z))


def correlated_sum(standard_uncertainties: ArrayLike, correlation: float) -> float:
    """Compute the standard uncertainty of a sum whose terms are all correlated alike, ``√((1−ρ) Σu² + ρ (Σu)²)``.

    Parameters
    ----------
    standard_uncertainties : array
        u of each term, negative for a term that is subtracted.
    correlation : float
        ρ, of every two terms, 0 … 1: 0 for independent errors, 1 for one error common to all.

    Raises
    ------
    DomainError
        Correlation outside 0 … 1.

    References
    ----------
    JCGM 100:2008 (GUM), eq. (16).

    Examples
    --------
    >>> [round(correlated_sum([1.0] * 4, rho), 3) for rho in (0.0, 0.5, 1.0)]
    [2.0, 3.162, 4.0]
    """
    u = values(standard_uncertainties)
    rho = float(within("correlation", correlation, 0.0, 1.0))
    return math.sqrt((1.0 - rho) * float(np.sum(u * u)) + rho * float(np.sum(u)) ** 2)


def half_difference_uncertainty(first: ArrayLike, second: ArrayLike) -> Any:
    """Compute the standard uncertainty of half the difference of two independent values, as of two diameters.

    Examples
    --------
    1.5 µm on each diameter:

    >>> round(half_difference_uncertainty(1.5, 1.5), 4)
    1.0607
    """
    return result(0.5 * np.hypot(not_negative("uncertainty", first), not_negative("uncertainty", second)))


def cube_mean(mean: ArrayLike, standard_uncertainty: ArrayLike) -> Any:
    """Compute the mean of the cube of a normal variable, ``c³ + 3 c s²``.

    Parameters
    ----------
    mean : float or array
        c.
    standard_uncertainty : float or array
        s, same unit.

    Raises
    ------
    DomainError
        Negative uncertainty.

    Examples
    --------
    >>> cube_mean(2.0, 1.0)
    14.0
    """
    c, s = _mean_and_spread(mean, standard_uncertainty)
    return result(c * (c * c + 3.0 * s * s))


def cube_variance(mean: ArrayLike, standard_uncertainty: ArrayLike) -> Any:
    """Compute the variance of the cube of a normal variable, ``9 c⁴s² + 36 c²s⁴ + 15 s⁶``.

    Raises
    ------
    DomainError
        Negative uncertainty.

    Examples
    --------
    >>> cube_variance(2.0, 1.0)
    303.0
    """
    c, s = _mean_and_spread(mean, standard_uncertainty)
    return result(s * s * (9.0 * c**4 + 36.0 * c * c * s * s + 15.0 * s**4))


def cube_covariance(
    mean_1: ArrayLike,
    standard_uncertainty_1: ArrayLike,
    mean_2: ArrayLike,
    standard_uncertainty_2: ArrayLike,
    correlation: ArrayLike,
) -> Any:
    """Compute the covariance of the cubes of two normal variables.

    ``9 ρ s₁s₂ (c₁² + s₁²)(c₂² + s₂²) + 18 ρ² c₁c₂ s₁²s₂² + 6 ρ³ s₁³s₂³``; with ρ = 1 and equal variables this is
    `cube_variance`.

    Parameters
    ----------
    mean_1, mean_2 : float or array
        c₁, c₂.
    standard_uncertainty_1, standard_uncertainty_2 : float or array
        s₁, s₂, same unit.
    correlation : float or array
        ρ, −1 … 1.

    Raises
    ------
    DomainError
        Negative uncertainty; correlation outside −1 … 1.

    References
    ----------
    Both cubes written in Hermite polynomials, whose mixed means are k! ρᵏ.

    Examples
    --------
    >>> cube_covariance(2.0, 1.0, 2.0, 1.0, 1.0) == cube_variance(2.0, 1.0)
    True
    """
    c_1, s_1 = _mean_and_spread(mean_1, standard_uncertainty_1)
    c_2, s_2 = _mean_and_spread(mean_2, standard_uncertainty_2)
    rho = within("correlation", correlation, -1.0, 1.0)
    joint = rho * s_1 * s_2
    first = 9.0 * (c_1 * c_1 + s_1 * s_1) * (c_2 * c_2 + s_2 * s_2)
    return result(joint * (first + joint * (18.0 * c_1 * c_2 + 6.0 * joint)))


def cube_quantile(probability: ArrayLike, mean: ArrayLike, standard_uncertainty: ArrayLike) -> Any:
    """Compute the quantile of the cube of a normal variable, ``(c + z s)³``: exact, because the cube rises throughout.

    Parameters
    ----------
    probability : float or array
        Above 0 and below 1.
    mean, standard_uncertainty : float or array
        c and s.

    Raises
    ------
    DomainError
        Probability outside (0, 1); negative uncertainty.

    Examples
    --------
    >>> round(cube_quantile(0.975, 25.0, 1.0) / 25.0**3, 4)
    1.2541
    """
    c, s = _mean_and_spread(mean, standard_uncertainty)
    return result((c + normal_quantile(probability) * s) ** 3)


def truncated_cube_moments(mean: ArrayLike, standard_uncertainty: ArrayLike) -> tuple[Any, Any]:
    """Compute the mean and variance of ``max(X, 0)³`` for a normal X: a clearance below zero leaks nothing.

    Parameters
    ----------
    mean, standard_uncertainty : float or array
        c and s of X; s above zero.

    Returns
    -------
    tuple of float or ndarray
        Mean and variance.

    Raises
    ------
    DomainError
        Uncertainty not positive.

    Notes
    -----
    With z = c/s: mean ``(c³ + 3cs²) Φ(z) + s (c² + 2s²) φ(z)``, mean square
    ``(c⁶ + 15c⁴s² + 45c²s⁴ + 15s⁶) Φ(z) + s (c⁵ + 14c³s² + 33cs⁴) φ(z)``.

    Examples
    --------
    Far from zero the truncation does nothing:

    >>> mean, variance = truncated_cube_moments(25.0, 1.0)
    >>> round(mean - cube_mean(25.0, 1.0), 9), round(variance / cube_variance(25.0, 1.0), 9)
    (0.0, 1.0)
    """
    c = values(mean)
    s = positive("standard uncertainty", standard_uncertainty)
    c_2, s_2 = c * c, s * s
    below, density = values(normal_cdf(c / s)), values(normal_density(c / s))
    first = c * (c_2 + 3.0 * s_2) * below + s * (c_2 + 2.0 * s_2) * density
    square = (c_2**3 + 15.0 * c_2 * c_2 * s_2 + 45.0 * c_2 * s_2 * s_2 + 15.0 * s_2**3) * below
    square = square + s * c * (c_2 * c_2 + 14.0 * c_2 * s_2 + 33.0 * s_2 * s_2) * density
    return result(first), result(square - first * first)


def _mean_and_spread(mean: ArrayLike, standard_uncertainty: ArrayLike) -> tuple[Any, Any]:
    return values(mean), not_negative("standard uncertainty", standard_uncertainty)
