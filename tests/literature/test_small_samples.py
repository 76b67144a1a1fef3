"""Student's distribution and one-sided sums of squares against scipy's, and the GUM's own table."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from atleak.equations.small_samples import one_sided_squares_tail, student_quantile, student_tail
from atleak.errors import DomainError

DEGREES = np.array([1.0, 1.7, 2.0, 3.3, 7.0, 29.0, 330.5, 5000.0])[:, None]


def test_student_s_tail_is_that_of_scipy() -> None:
    t = np.array([-3.0, -0.1, 0.0, 0.5, 2.0, 4.0, 7.0, 20.0])
    assert student_tail(t, DEGREES) == pytest.approx(stats.t.sf(t, DEGREES), abs=2e-12)


def test_student_s_quantile_is_that_of_scipy_as_far_out_as_outliers_are_judged() -> None:
    p = np.array([0.6, 0.9, 0.975, 0.9999, 1.0 - 1e-5])
    assert student_quantile(p, DEGREES) == pytest.approx(stats.t.ppf(p, DEGREES), rel=1e-5, abs=1e-9)


@pytest.mark.parametrize(("degrees", "printed"), [(1, 12.71), (2, 4.30), (5, 2.57), (20, 2.09), (50, 2.01)])
def test_the_factors_of_the_guide_s_table_are_met(degrees: int, printed: float) -> None:
    """JCGM 100:2008, table G.2, 95 %."""
    assert student_quantile(0.975, degrees) == pytest.approx(printed, abs=0.005)


@pytest.mark.parametrize("number", [1, 2, 7, 29])
def test_a_sum_of_one_sided_squares_is_a_mixture_of_chi_squared(number: int) -> None:
    q, k = np.array([0.5, 3.0, 12.0, 40.0]), np.arange(1, number + 1)
    mixture = stats.chi2.sf(q[:, None], k) @ stats.binom.pmf(k, number, 0.5)
    assert one_sided_squares_tail(q, number) == pytest.approx(mixture, rel=1e-10, abs=1e-15)


def test_less_than_one_degree_of_freedom_is_refused() -> None:
    with pytest.raises(DomainError, match="one or more"):
        student_tail(1.0, 0.5)
