"""Compute the normal distribution, the sources of a reading's uncertainty, and decisions about a limit: closed forms.

All uncertainties are standard uncertainties (one standard deviation) in the unit of the value they belong to. The
normal distribution is exact to the digits of the standard library; no root finding, no tables.
"""

from __future__ import annotations

import math
from statistics import NormalDist
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from atleak.equations._domain import not_negative, refuse, result, values

_NORMAL = NormalDist()
_SQRT_HALF = math.sqrt(0.5)
_each_erfc = np.frompyfunc(math.erfc, 1, 1)
_each_quantile = np.frompyfunc(_NORMAL.inv_cdf, 1, 1)


def normal_cdf(deviate: ArrayLike) -> Any:
    """Compute the probability that a standard normal variable is below a deviate, ``Φ(z)``.

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
    """Compute the deviate below which a standard normal variable lies with a given probability.

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
    refuse("probability", p, (p <= 0.0) | (p >= 1.0), "above 0 and below 1")
    quantiles = np.full(p.shape, np.nan)
    known = ~np.isnan(p)
    quantiles[known] = np.asarray(_each_quantile(p[known]), dtype=float)
    return result(quantiles)


# --- sources


def rectangular(half_width: ArrayLike) -> Any:
    """Compute the standard uncertainty of a value known to lie within ± a half width, ``a/√3``.

    Parameters
    ----------
    half_width : float or array
        a, in any unit.

    Returns
    -------
    float or array
        u, in the same unit.

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
    """Compute the standard deviation common to several groups, ``√(Σ ν s² / Σ ν)``.

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
    """Compute the variance of the rounding error that stays however often a reading is repeated.

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


# --- decisions


def probability_over(value: ArrayLike, limit: ArrayLike, standard_uncertainty: ArrayLike) -> Any:
    """Compute the probability that a true value is above an upper limit, ``Φ((y − T)/u)``.

    Parameters
    ----------
    value : float or array
        y, as measured.
    limit : float or array
        T, in the unit of y.
    standard_uncertainty : float or array
        u, likewise. Where it is zero the probability is 0 up to the limit and 1 above.

    Returns
    -------
    float or array
        0 to 1.

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
    """Compute the distance to keep from a limit, ``k u``; 1.645 leaves a one-sided risk of 5 %.

    Parameters
    ----------
    standard_uncertainty : float or array
        u, in any unit.
    factor : float
        k.

    Returns
    -------
    float or array
        in the unit of u.

    Raises
    ------
    DomainError
        Negative uncertainty or factor.

    References
    ----------
    JCGM 106:2012, 8.3, and ILAC-G8:09/2019.

    Examples
    --------
    >>> round(guard_band(1.06), 3)
    1.744
    """
    return result(not_negative("guard factor", factor) * not_negative("standard uncertainty", standard_uncertainty))
