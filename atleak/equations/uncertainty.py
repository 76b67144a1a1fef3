"""What measurement uncertainty does to a difference, to its cube and to a decision: closed forms.

All uncertainties are standard uncertainties (one standard deviation) in the unit of the value they belong to. The
normal distribution is exact to the digits of the standard library; no root finding, no tables.
"""

from __future__ import annotations

import math
from statistics import NormalDist
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from atleak.equations._domain import not_negative, positive, refuse, result, values, within

_NORMAL = NormalDist()
_SQRT_HALF = math.sqrt(0.5)
_DENSITY_AT_ZERO = 1.0 / math.sqrt(2.0 * math.pi)
_each_erfc = np.frompyfunc(math.erfc, 1, 1)
_each_quantile = np.frompyfunc(_NORMAL.inv_cdf, 1, 1)


def normal_cdf(deviate: ArrayLike) -> Any:
    """Probability that a standard normal variable is below a deviate, ``Φ(z)``.

    Parameters
    ----------
    deviate : float or array
        z [-].

    Returns
    -------
    float or ndarray
        Φ(z), 0 … 1; accurate in both tails.

    Examples
    --------
    >>> round(normal_cdf(1.6448536269514722), 12)
    0.95
    """
    return result(0.5 * np.asarray(_each_erfc(values(deviate) * -_SQRT_HALF), dtype=float))


def normal_quantile(probability: ArrayLike) -> Any:
    """The deviate below which a standard normal variable lies with a given probability.

    Parameters
    ----------
    probability : float or array
        Above 0 and below 1.

    Returns
    -------
    float or ndarray
        z [-].

    Raises
    ------
    DomainError
        Probability outside (0, 1).

    Examples
    --------
    >>> round(normal_quantile(0.95), 6)
    1.644854
    """
    p = values(probability)
    refuse("probability", p, (p <= 0.0) | (p >= 1.0), "above 0 and below 1", "")
    found = np.full(p.shape, np.nan)
    known = ~np.isnan(p)
    found[known] = _each_quantile(p[known]).astype(float)
    return result(found)


def normal_density(deviate: ArrayLike) -> Any:
    """Density of the standard normal distribution, ``φ(z) = exp(−z²/2)/√(2π)``."""
    z = values(deviate)
    return result(_DENSITY_AT_ZERO * np.exp(-0.5 * z * z))


# --- sources


def rectangular(half_width: ArrayLike) -> Any:
    """Standard uncertainty of a value known to lie within ± a half width, ``a/√3``.

    Raises
    ------
    DomainError
        Negative half width.

    References
    ----------
    JCGM 100:2008 (GUM), 4.3.7.

    Examples
    --------
    Reading to the nearest 0.001 mm, in µm:

    >>> round(rectangular(0.5), 4)
    0.2887
    """
    return result(not_negative("half width", half_width) / math.sqrt(3.0))


def pooled_standard_deviation(standard_deviations: ArrayLike, degrees_of_freedom: ArrayLike) -> Any:
    """Standard deviation common to several groups, ``√(Σ ν s² / Σ ν)``.

    Parameters
    ----------
    standard_deviations : array
        s of each group.
    degrees_of_freedom : array
        ν of each group, its number of values less one.

    Returns
    -------
    float
        NaN where no group has a degree of freedom.

    Raises
    ------
    DomainError
        A negative standard deviation or number of degrees of freedom.

    References
    ----------
    JCGM 100:2008 (GUM), 4.2.4 and H.3.6.

    Examples
    --------
    >>> round(pooled_standard_deviation([1.0, 2.0], [1, 3]), 6)
    1.802776
    """
    s = not_negative("standard deviation", standard_deviations)
    degrees = not_negative("degrees of freedom", degrees_of_freedom)
    total = float(np.sum(degrees))
    return math.sqrt(float(np.sum(degrees * s * s)) / total) if total > 0.0 else math.nan


def persistent_rounding_variance(resolution: ArrayLike, standard_deviation: ArrayLike) -> Any:
    """Variance of the rounding error that stays however often a reading is repeated.

    ``Σ_k q²/(2π²k²) · exp(−4π²k²s²/q²)`` with q the step of the reading and s the spread of single readings before
    they are rounded. Where they do not spread at all it is q²/12; from s = q/2 on repeats average rounding out.

    Parameters
    ----------
    resolution : float or array
        q, the step between two possible readings.
    standard_deviation : float or array
        s, same unit.

    Returns
    -------
    float or ndarray
        In the square of the unit.

    Raises
    ------
    DomainError
        A negative value.

    Notes
    -----
    The mean of rounded normal readings is a Fourier series of the true value; this is its variance over a true value
    that lies anywhere within a step.

    References
    ----------
    Widrow B., Kollár I., Quantization Noise, Cambridge 2008, chapter 5 (moments of quantised signals).

    Examples
    --------
    >>> round(persistent_rounding_variance(1.0, 0.0) * 12, 6)
    1.0
    >>> persistent_rounding_variance(1.0, 0.5) < 1e-3 / 12
    True
    """
    step = not_negative("resolution", resolution)
    s = not_negative("standard deviation", standard_deviation)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        a = np.minimum((2.0 * math.pi * s / step) ** 2, 1e3)
    few = math.pi**2 / 6.0 - np.sqrt(math.pi * a) + 0.5 * a  # the same sum after Poisson's formula, for small a
    k = np.arange(1.0, 11.0)
    many = np.sum(np.exp(-a[..., None] * k * k) / (k * k), axis=-1)
    series = np.where(a < 0.5, few, many)
    return result(np.where(step > 0.0, step * step * series / (2.0 * math.pi**2), 0.0 * s))


def correlated_sum(standard_uncertainties: ArrayLike, correlation: float) -> float:
    """Standard uncertainty of a sum whose terms are all correlated alike, ``√((1−ρ) Σu² + ρ (Σu)²)``.

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
    """Standard uncertainty of half the difference of two independent values: of a clearance from two diameters.

    Examples
    --------
    1.5 µm on each diameter:

    >>> round(half_difference_uncertainty(1.5, 1.5), 4)
    1.0607
    """
    return result(0.5 * np.hypot(not_negative("uncertainty", first), not_negative("uncertainty", second)))


# --- the cube of a normal variable


def cube_mean(mean: ArrayLike, standard_uncertainty: ArrayLike) -> Any:
    """Mean of the cube of a normal variable, ``c³ + 3 c s²``.

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
    """Variance of the cube of a normal variable, ``9 c⁴s² + 36 c²s⁴ + 15 s⁶``.

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
    """Covariance of the cubes of two normal variables.

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
    """Quantile of the cube of a normal variable, ``(c + z s)³``: exact, because the cube rises throughout.

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
    """Mean and variance of ``max(X, 0)³`` for a normal X: a clearance below zero leaks nothing.

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


# --- decisions


def probability_over(value: ArrayLike, limit: ArrayLike, standard_uncertainty: ArrayLike) -> Any:
    """Probability that a true value is above an upper limit, ``Φ((y − T)/u)``.

    Parameters
    ----------
    value : float or array
        y, as measured.
    limit : float or array
        T.
    standard_uncertainty : float or array
        u. Where it is zero the probability is 0 up to the limit and 1 above.

    Raises
    ------
    DomainError
        Negative uncertainty.

    References
    ----------
    JCGM 106:2012, 7.3, with no knowledge of the value before it was measured.

    Examples
    --------
    >>> round(probability_over(30.0, 30.0, 1.0), 3), round(probability_over(28.0, 30.0, 1.0), 4)
    (0.5, 0.0228)
    """
    u = not_negative("standard uncertainty", standard_uncertainty)
    excess = values(value) - values(limit)
    shape = np.broadcast(excess, u).shape
    with np.errstate(divide="ignore"):
        step = np.where(excess > 0.0, np.inf, np.where(np.isnan(excess), np.nan, -np.inf))
        deviate = np.divide(excess, u, out=np.array(np.broadcast_to(step, shape)), where=u > 0.0)
    return normal_cdf(deviate)


def guard_band(standard_uncertainty: ArrayLike, factor: float = 1.645) -> Any:
    """Distance to keep from a limit, ``k u``; 1.645 leaves a one-sided risk of 5 %.

    Raises
    ------
    DomainError
        Negative uncertainty or factor.

    Examples
    --------
    >>> round(guard_band(1.06), 3)
    1.744
    """
    return result(not_negative("guard factor", factor) * not_negative("standard uncertainty", standard_uncertainty))


def _mean_and_spread(mean: ArrayLike, standard_uncertainty: ArrayLike) -> tuple[Any, Any]:
    return values(mean), not_negative("standard uncertainty", standard_uncertainty)
