"""The closed forms of uncertainty against independent referees: quadrature, exact sums, published examples."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from scipy import integrate, special, stats

from atleak.equations import DomainError
from atleak.equations import statistics as equations
from tests.unit.equations import referees

CASES = [(25.0, 1.06), (30.0, 0.1), (10.0, 2.0), (3.0, 2.5), (40.0, 8.0)]


def _expectation(function, mean: float, spread: float) -> float:
    # split where the integrand peaks, so that the adaptive rule sees it
    def integrand(x: float) -> float:
        return function(x) * stats.norm.pdf(x, mean, spread)

    edges = [mean + k * spread for k in (-14, -6, -2, 0, 2, 6, 14)]
    parts = [integrate.quad(integrand, low, high, epsabs=0.0, epsrel=1e-13)[0] for low, high in pairwise(edges)]
    return math.fsum(parts)


@pytest.mark.parametrize(("c", "s"), CASES)
def test_moments_of_the_cube_against_quadrature(c: float, s: float) -> None:
    mean = _expectation(lambda x: x**3, c, s)
    square = _expectation(lambda x: (x**3 - mean) ** 2, c, s)
    assert referees.cube_mean(c, s) == pytest.approx(mean, rel=1e-9, abs=0.0)
    assert referees.cube_variance(c, s) == pytest.approx(square, rel=1e-9, abs=0.0)


@pytest.mark.parametrize(("c", "s"), [*CASES, (-2.0, 1.5), (0.0, 1.0)])
def test_moments_of_the_truncated_cube_against_quadrature(c: float, s: float) -> None:
    top = c + 14 * s
    edges = [max(0.0, c + k * s) for k in (-14, -6, -2, 0, 2, 6)] + [top]

    def moment(power: int) -> float:
        return math.fsum(
            integrate.quad(lambda x: x**power * stats.norm.pdf(x, c, s), low, high, epsabs=0.0, epsrel=1e-13)[0]
            for low, high in pairwise(edges)
            if high > low
        )

    mean, variance = referees.truncated_cube_moments(c, s)
    assert mean == pytest.approx(moment(3), rel=1e-9, abs=0.0)
    assert variance == pytest.approx(moment(6) - moment(3) ** 2, rel=1e-9, abs=0.0)


@pytest.mark.parametrize("correlation", [-0.7, 0.0, 0.5, 1.0])
def test_covariance_of_cubes_against_exact_hermite_quadrature(correlation: float) -> None:
    c_1, s_1, c_2, s_2 = 25.0, 3.0, 18.0, 4.0
    z, weights = np.polynomial.hermite_e.hermegauss(12)  # exact for polynomials up to degree 23
    weights = weights / weights.sum()
    a, b = np.meshgrid(z, z, indexing="ij")
    w = np.outer(weights, weights)
    x = c_1 + s_1 * a
    y = c_2 + s_2 * (correlation * a + math.sqrt(1.0 - correlation**2) * b)
    expected = np.sum(w * x**3 * y**3) - np.sum(w * x**3) * np.sum(w * y**3)
    covariance = referees.cube_covariance(c_1, s_1, c_2, s_2, correlation)
    assert covariance == pytest.approx(expected, rel=1e-9, abs=1e-6)


@pytest.mark.parametrize("probability", [1e-6, 0.025, 0.05, 0.5, 0.95, 0.975, 1 - 1e-6])
def test_quantiles_of_the_cube_against_scipy(probability: float) -> None:
    c, s = 25.0, 4.0
    assert equations.normal_quantile(probability) == pytest.approx(special.ndtri(probability), rel=1e-9, abs=1e-12)
    assert referees.cube_quantile(probability, c, s) == pytest.approx(
        stats.norm.ppf(probability, c, s) ** 3, rel=1e-9, abs=0.0
    )


def test_normal_cdf_against_scipy_in_both_tails() -> None:
    z = np.linspace(-30.0, 8.0, 500)
    np.testing.assert_allclose(equations.normal_cdf(z), special.ndtr(z), rtol=1e-12)


@pytest.mark.parametrize(("c", "s"), [(25.0, 1.06), (25.0, 6.0), (8.0, 8.0)])
def test_monte_carlo_agrees_within_three_standard_errors(c: float, s: float) -> None:
    draws = 400_000
    x = np.random.Generator(np.random.PCG64(5)).normal(c, s, draws)
    for cube, mean, variance in (
        (x**3, referees.cube_mean(c, s), referees.cube_variance(c, s)),
        (np.maximum(x, 0.0) ** 3, *referees.truncated_cube_moments(c, s)),
    ):
        assert abs(cube.mean() - mean) < 3.0 * math.sqrt(variance / draws)
        fourth = np.mean((cube - cube.mean()) ** 4)
        assert abs(cube.var() - variance) < 3.0 * math.sqrt((fourth - variance**2) / draws)
    for p in (0.025, 0.5, 0.975):
        below = np.mean(x**3 <= referees.cube_quantile(p, c, s))
        assert abs(below - p) < 3.0 * math.sqrt(p * (1.0 - p) / draws)


def _total_of_twenty(correlation: float, relative: float = 0.0283) -> float:
    """Relative standard deviation of the flow of 20 equal lands, against the flow at the clearances as measured."""
    n, c = 20, 25.0
    s = relative * c
    own = referees.cube_variance(c, s)
    shared = referees.cube_covariance(c, s, c, s, correlation)
    return math.sqrt(n * own + n * (n - 1) * shared) / (n * c**3)


@pytest.mark.parametrize(("correlation", "percent"), [(0.0, 1.90), (0.5, 6.16), (1.0, 8.50)])
def test_twenty_lands_do_not_average_a_common_error_out(correlation: float, percent: float) -> None:
    assert 100.0 * _total_of_twenty(correlation) == pytest.approx(percent, abs=0.005)
    each = math.sqrt(referees.cube_variance(25.0, 0.0283 * 25.0)) / 25.0**3 / 20.0
    assert 100.0 * referees.correlated_sum([each] * 20, correlation) == pytest.approx(percent, abs=0.006)


def test_two_diameters_of_one_and_a_half_micrometres() -> None:
    u = 0.5 * math.hypot(1.5e-6, 1.5e-6)
    assert u * 1e6 == pytest.approx(1.06, abs=0.005)
    assert u / 25e-6 == pytest.approx(0.04, abs=0.005)
    assert math.sqrt(referees.cube_variance(25e-6, u)) / 25e-6**3 == pytest.approx(0.13, abs=0.005)


def test_pooled_standard_deviation_is_that_of_the_residuals() -> None:
    rng = np.random.default_rng(3)
    groups = [rng.normal(m, 2.0, n) for m, n in ((0.0, 2), (5.0, 4), (9.0, 7))]
    pooled = equations.pooled_standard_deviation([g.std(ddof=1) for g in groups], [len(g) - 1 for g in groups])
    residuals = np.concatenate([g - g.mean() for g in groups])
    assert pooled == pytest.approx(math.sqrt(np.sum(residuals**2) / (len(residuals) - 3)), rel=1e-12, abs=0.0)
    assert math.isnan(equations.pooled_standard_deviation([], []))


@pytest.mark.parametrize("ratio", [0.0, 0.05, 0.11, 0.1125395, 0.12, 0.2, 0.35, 0.6])
def test_persistent_rounding_against_direct_integration(ratio: float) -> None:
    """The mean of round(x) over normal x, for true values across one step."""

    def error(true: float) -> float:
        if ratio == 0.0:
            return round(true) - true
        k = np.arange(-12, 13)
        mass = special.ndtr((k + 0.5 - true) / ratio) - special.ndtr((k - 0.5 - true) / ratio)
        return float(np.sum(k * mass)) - true

    expected = 2.0 * integrate.quad(lambda t: error(t) ** 2, 0.0, 0.5, epsabs=1e-15, epsrel=1e-12, limit=200)[0]
    assert equations.persistent_rounding_variance(1.0, ratio) == pytest.approx(expected, rel=1e-9, abs=1e-14)
    assert equations.persistent_rounding_variance(3.0, 3.0 * ratio) == pytest.approx(
        9.0 * expected, rel=1e-9, abs=1e-13
    )


def test_domains() -> None:
    with pytest.raises(DomainError, match="probability"):
        equations.normal_quantile([0.5, 1.0])
    with pytest.raises(DomainError, match="resolution"):
        equations.persistent_rounding_variance(-1.0, 0.0)
    assert equations.probability_over([1.0, 1.0 + 1e-12, math.nan], 1.0, 0.0).tolist()[:2] == [0.0, 1.0]
    assert math.isnan(equations.probability_over(math.nan, 1.0, 0.0))
    assert math.isnan(equations.normal_quantile(math.nan))
    assert equations.persistent_rounding_variance(0.0, 1.0) == 0.0
