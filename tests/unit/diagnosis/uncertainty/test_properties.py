"""What must hold whatever the numbers are."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from atleak.diagnosis.uncertainty import DECISIONS, decide
from atleak.equations import statistics as equations
from tests.unit.equations import referees

CLEARANCE = st.floats(1.0, 200.0)
RELATIVE = st.floats(1e-4, 0.5)
PROBABILITY = st.floats(1e-6, 1.0 - 1e-6)


@given(CLEARANCE, RELATIVE, PROBABILITY)
def test_quantile_and_probability_are_each_others_inverse(c: float, r: float, p: float) -> None:
    limit = referees.cube_quantile(p, c, r * c)
    assert equations.probability_over(c, math.cbrt(limit), r * c) == pytest.approx(1.0 - p, rel=1e-6, abs=1e-12)


@given(st.floats(0.1, 10.0), st.floats(0.0, 3.0), st.floats(0.0, 3.0))
def test_readings_that_spread_more_keep_less_of_the_rounding(step: float, first: float, second: float) -> None:
    low, high = sorted((first, second))
    kept = [equations.persistent_rounding_variance(step, ratio * step) for ratio in (low, high)]
    assert 0.0 <= kept[1] <= kept[0] * (1.0 + 1e-9) + 1e-15
    assert kept[0] <= step**2 / 12.0 * (1.0 + 1e-12)


@given(st.floats(-5.0, 5.0), st.floats(0.01, 3.0), st.floats(0.0, 5.0), st.floats(0.0, 2.0))
def test_a_larger_value_is_never_decided_more_kindly(value: float, u: float, step: float, k: float) -> None:
    first, second = (DECISIONS.index(decide(y, 0.0, u, k)) for y in (value, value + step))
    assert first <= second


@given(st.floats(-5.0, 5.0), st.floats(0.01, 3.0))
def test_decision_and_probability_tell_the_same(value: float, u: float) -> None:
    over = equations.probability_over(value, 0.0, u)
    match decide(value, 0.0, u):
        case "pass":
            assert over <= 0.05
        case "conditional_pass":
            assert 0.0499 <= over <= 0.5
        case "conditional_fail":
            assert 0.5 <= over <= 0.9501
        case "fail":
            assert over >= 0.95
