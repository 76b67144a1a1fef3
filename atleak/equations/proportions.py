"""Compute intervals of a share of some units, and of the difference of two such shares."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from atleak.equations._domain import not_negative, refuse, result, values
from atleak.equations.statistics import normal_quantile


def wilson_interval(count: ArrayLike, of: ArrayLike, coverage: float = 0.95) -> tuple[Any, Any]:
    """Compute the score interval of a share: all shares whose own standard error explains the one that was counted.

    Parameters
    ----------
    count : float or array
        x, how many it is true of [-], 0 … n.
    of : float or array
        n [-], one or more.
    coverage : float
        Probability that such intervals hold the true share, above 0 and below 1.

    Returns
    -------
    tuple of float or ndarray
        Both ends of the interval [-], 0 … 1.

    Raises
    ------
    DomainError
        A count below 0 or above n, or n below one.

    References
    ----------
    E. B. Wilson, J. Am. Stat. Assoc. 22 (1927) 209-212; R. G. Newcombe, Stat. Med. 17 (1998) 857-872, method 3.

    Examples
    --------
    >>> [round(end, 4) for end in wilson_interval(15, 148)]
    [0.0624, 0.1605]
    """
    x, n = np.broadcast_arrays(not_negative("count", count), values(of))
    refuse("number of units", n, n < 1.0, "one or more")
    refuse("count", x, x > n, "at most the number of units")
    z = float(normal_quantile(0.5 + 0.5 * coverage))
    middle, half = 2.0 * x + z**2, z * np.sqrt(z**2 + 4.0 * x * (1.0 - x / n))
    width = 2.0 * (n + z**2)
    low = np.where(x == 0.0, 0.0, (middle - half) / width)
    high = np.where(x == n, 1.0, (middle + half) / width)
    return result(low), result(high)


def newcombe_interval(
    first: ArrayLike, of_first: ArrayLike, second: ArrayLike, of_second: ArrayLike, coverage: float = 0.95
) -> tuple[Any, Any]:
    """Compute the interval of the difference of two independent shares, second minus first, from their score intervals.

    Parameters
    ----------
    first, of_first, second, of_second : float or array
        x₁, n₁, x₂, n₂ [-]: of how many of each it is true, 0 … n, and how many there are, one or more.
    coverage : float
        Probability that such intervals hold the true difference, above 0 and below 1.

    Returns
    -------
    tuple of float or ndarray
        Both ends of the interval [-], −1 … 1.

    Raises
    ------
    DomainError
        A count below 0 or above n, or n below one.

    References
    ----------
    R. G. Newcombe, Stat. Med. 17 (1998) 873-890, method 10 (hybrid score).

    Examples
    --------
    >>> [round(end, 4) for end in newcombe_interval(48, 80, 56, 70)]
    [0.0524, 0.3339]
    """
    low_1, high_1 = wilson_interval(first, of_first, coverage)
    low_2, high_2 = wilson_interval(second, of_second, coverage)
    p_1, p_2 = values(first) / values(of_first), values(second) / values(of_second)
    difference = p_2 - p_1
    low = difference - np.hypot(p_2 - low_2, high_1 - p_1)
    high = difference + np.hypot(high_2 - p_2, p_1 - low_1)
    return result(low), result(high)
