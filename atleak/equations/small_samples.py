"""Compute the distributions that few values follow: Student's t, and sums of squares of which only one side counts."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from atleak.equations._domain import not_negative, refuse, result, values
from atleak.sentence import Sentence

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(64)
_HALVINGS = 60
_MOST_DEGREES = 1e5  # of freedom, from where on Student's distribution is the normal one to five digits

_each_lgamma = np.frompyfunc(math.lgamma, 1, 1)


def student_tail(deviate: ArrayLike, degrees_of_freedom: ArrayLike) -> Any:
    """Compute the probability that a variable of Student's distribution is above a deviate, ``P(T > t)``.

    With t = √ν tan θ the distribution is an integral of ``cos^(ν−1) θ``, which is smooth and evaluated by Gauss's rule.

    Parameters
    ----------
    deviate : float or array
        t [-].
    degrees_of_freedom : float or array
        ν ≥ 1 [-], not necessarily whole; from 100 000 on, and infinite, the distribution is the normal one.

    Returns
    -------
    float or ndarray
        P [-], to about 1e-11.

    Raises
    ------
    DomainError
        Fewer than one degree of freedom.

    References
    ----------
    JCGM 100:2008 (GUM), G.3; Student, Biometrika 6 (1908) 1-25.

    Examples
    --------
    >>> round(student_tail(2.228139, 10), 6)
    0.025
    """
    t, nu = np.broadcast_arrays(values(deviate), _degrees(degrees_of_freedom))
    angle = np.arctan(np.abs(t) / np.sqrt(nu))
    # beyond eight times its width nothing of the integrand is left
    angle = np.minimum(angle, 8.0 / np.sqrt(nu + 1.0) + np.where(nu < 100.0, math.pi, 0.0))
    at = 0.5 * angle[..., None] * (_NODES + 1.0)
    integral = 0.5 * angle * np.sum(_WEIGHTS * np.cos(at) ** (nu[..., None] - 1.0), axis=-1)
    log_scale = _each_lgamma(0.5 * (nu + 1.0)) - _each_lgamma(0.5 * nu)
    scale = np.exp(np.asarray(log_scale, dtype=float)) / math.sqrt(math.pi)
    tail = np.clip(0.5 - scale * integral, 0.0, 0.5)
    return result(np.where(t < 0.0, 1.0 - tail, tail))


def student_quantile(probability: ArrayLike, degrees_of_freedom: ArrayLike) -> Any:
    """Compute the deviate below which a variable of Student's distribution lies with a given probability.

    Parameters
    ----------
    probability : float or array
        From 0.5 to below 1.
    degrees_of_freedom : float or array
        ν ≥ 1 [-], not necessarily whole; from 100 000 on, and infinite, the distribution is the normal one.

    Returns
    -------
    float or ndarray
        t [-], zero or positive.

    Raises
    ------
    DomainError
        Probability outside [0.5, 1), or fewer than one degree of freedom.

    References
    ----------
    JCGM 100:2008 (GUM), G.3 and table G.2.

    Examples
    --------
    >>> round(student_quantile(0.975, 10), 4)
    2.2281
    """
    p = values(probability)
    refuse("probability", p, (p < 0.5) | (p >= 1.0), Sentence("from 0.5 to below 1"), "")
    p, nu = np.broadcast_arrays(p, _degrees(degrees_of_freedom))
    low, high = np.zeros(p.shape), np.full(p.shape, 0.5 * math.pi)  # of the angle whose tangent is t/√ν
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        above = np.asarray(student_tail(np.sqrt(nu) * np.tan(middle), nu)) > 1.0 - p
        low, high = np.where(above, middle, low), np.where(above, high, middle)
    return result(np.where(np.isnan(p + nu), np.nan, np.sqrt(nu) * np.tan(0.5 * (low + high))))


def one_sided_squares_tail(value: ArrayLike, number: int) -> Any:
    """Compute the probability that Σ max(zᵢ, 0)² of independent standard normal zᵢ is above a value.

    Each zᵢ counts with probability ½, so the sum is a mixture of χ² distributions with binomial weights ("chi-bar
    squared"): ``Σ_k C(n, k) 2⁻ⁿ P(χ²_k > q)``.

    Parameters
    ----------
    value : float or array
        q ≥ 0 [-].
    number : int
        n, how many variables there are.

    Returns
    -------
    float or ndarray
        P [-], 0 … 1.

    Raises
    ------
    DomainError
        Negative value.

    References
    ----------
    A. Shapiro, Biometrika 72 (1985) 133-144; χ² by the recurrence of the incomplete gamma function (DLMF 8.8.2).

    Examples
    --------
    >>> round(one_sided_squares_tail(2.705543, 1), 6)
    0.05
    """
    half = 0.5 * not_negative("value", value)
    tails = {0: np.zeros(half.shape), 1: np.asarray(np.frompyfunc(math.erfc, 1, 1)(np.sqrt(half)), dtype=float)}
    total = math.ldexp(1.0, -number) * number * tails[1] if number else np.zeros(half.shape)
    with np.errstate(divide="ignore"):
        log_half = np.log(half)
    for k in range(2, number + 1):
        step = np.exp((0.5 * k - 1.0) * log_half - half - math.lgamma(0.5 * k)) if k > 2 else np.exp(-half)
        tails[k] = tails[k - 2] + step
        total = total + math.exp(math.log(math.comb(number, k)) - number * math.log(2.0)) * tails[k]
    return result(np.clip(total, 0.0, 1.0))


def _degrees(given: ArrayLike) -> Any:
    nu = values(given)
    refuse("degrees of freedom", nu, nu < 1.0, Sentence("one or more"), "")
    return np.minimum(nu, _MOST_DEGREES)
