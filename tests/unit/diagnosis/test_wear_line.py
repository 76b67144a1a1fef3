"""The straight line through clearances over mileage: rates, intervals, and where a limit is crossed."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from atleak.diagnosis.land import FARTHEST, WearLine, wear_line

UM = 1e-6
Z = 1.6448536269514722


def line_of(points: dict[float, float], u: float = 1.0, shared: float = 0.0) -> WearLine:
    """The line through clearances [µm] by mileage [km], each with an error of its own and one that all share [µm]."""
    covariance = (u**2 * np.eye(len(points)) + shared**2) * UM**2
    line = wear_line(list(points), [each * UM for each in points.values()], covariance)
    assert line is not None
    return line


def test_two_points_give_their_own_line_and_the_rate_is_as_sure_as_both() -> None:
    line = line_of({50_000.0: 24.0, 100_000.0: 29.0})
    assert line.rate * 1e4 / UM == pytest.approx(1.0, abs=1e-9)
    assert line.at(150_000.0) / UM == pytest.approx(34.0, abs=1e-9)
    low, high = (end * 1e4 / UM for end in line.rate_interval())
    assert (high - low) / 2.0 == pytest.approx(Z * math.sqrt(2.0) / 5.0, abs=1e-6)
    assert line.certain
    assert line.straight


def test_an_error_that_points_share_moves_the_line_and_not_its_rate() -> None:
    alone, together = line_of({5e4: 24.0, 1e5: 29.0}), line_of({5e4: 24.0, 1e5: 29.0}, shared=2.0)
    assert together.rate_interval() == pytest.approx(alone.rate_interval(), abs=1e-15)
    assert together.uncertainty_at(1e5) / UM == pytest.approx(math.hypot(1.0, 2.0), abs=1e-6)


def test_one_mileage_gives_no_line() -> None:
    assert wear_line([], [], np.zeros((0, 0))) is None
    assert wear_line([5e4, 5e4], [24e-6, 25e-6], np.eye(2) * UM**2) is None


def test_the_interval_of_a_crossing_is_that_of_drawn_lines() -> None:
    line = line_of({5e4: 24.0, 1e5: 29.0, 1.5e5: 33.5}, shared=1.5)
    at = line.reaches(40e-6, 1.5e5)
    draws = np.random.default_rng(1).multivariate_normal(
        [line.clearance / UM, line.rate / UM], line.covariance / UM**2, 400_000
    )
    drawn = np.maximum(line.origin + (40.0 - draws[:, 0]) / draws[:, 1], 1.5e5)
    assert (at.low, at.value, at.high) == pytest.approx(np.quantile(drawn, [0.05, 0.5, 0.95]), rel=3e-3, abs=0.0)
    assert at.foreseeable
    assert at.not_before is None


def test_a_rate_that_may_be_zero_has_no_end() -> None:
    line = line_of({5e4: 24.0, 1e5: 25.0})
    at = line.reaches(40e-6, 1e5)
    assert not line.certain
    assert at.high == math.inf
    assert 1e5 < at.low == at.not_before < FARTHEST


def test_a_clearance_that_falls_never_reaches_a_limit() -> None:
    at = line_of({5e4: 29.0, 1e5: 24.0}).reaches(40e-6, 1e5)
    assert (at.value, at.low, at.high) == (math.inf, math.inf, math.inf)
    assert at.not_before == FARTHEST


def test_what_may_have_happened_already_begins_now() -> None:
    at = line_of({5e4: 24.0, 1e5: 39.5}).reaches(40e-6, 1e5)
    assert at.low == 1e5 < at.value < at.high
    past = line_of({5e4: 24.0, 1e5: 45.0}).reaches(40e-6, 1e5)
    assert (past.low, past.value, past.high) == (1e5, 1e5, 1e5)


def test_points_off_a_straight_line_widen_it() -> None:
    straight, bent = line_of({4e4: 20.0, 8e4: 24.5, 12e4: 28.0}), line_of({4e4: 20.0, 8e4: 20.0, 12e4: 34.0})
    assert straight.straight
    assert not bent.straight
    assert bent.uncertainty_at(12e4) > 5.0 * straight.uncertainty_at(12e4)


def test_without_any_error_the_line_is_exact() -> None:
    line = line_of({5e4: 24.0, 1e5: 29.0}, u=0.0)
    at = line.reaches(34e-6, 1e5)
    assert (at.low, at.value, at.high) == pytest.approx((1.5e5, 1.5e5, 1.5e5), abs=1.0)


visits = st.lists(st.tuples(st.floats(0.0, 5e5), st.floats(10.0, 40.0), st.floats(0.3, 3.0)), min_size=3, max_size=8)


@given(visits, st.floats(0.0, 3.0))
def test_one_visit_more_never_widens_the_interval_of_a_rate(
    points: list[tuple[float, float, float]], shared: float
) -> None:
    mileages, clearances, us = map(list, zip(*points, strict=True))
    covariance = (np.diag(np.square(us)) + shared**2) * UM**2
    fewer = wear_line(mileages[:-1], [each * UM for each in clearances[:-1]], covariance[:-1, :-1])
    more = wear_line(mileages, [each * UM for each in clearances], covariance)
    if fewer is None:
        return
    assert more is not None
    u_fewer, u_more = (math.sqrt(line.covariance[1, 1]) / line.scatter for line in (fewer, more))
    assert u_more <= u_fewer * (1.0 + 1e-6)


@given(visits, st.floats(10.0, 80.0), st.sampled_from([0.0, 2e4]))
def test_a_crossing_is_in_order_and_where_its_band_meets_the_limit(
    points: list[tuple[float, float, float]], limit: float, driven_since: float
) -> None:
    mileages, clearances, us = map(list, zip(*sorted(points), strict=True))
    line = wear_line(mileages, [each * UM for each in clearances], np.diag(np.square(us)) * UM**2)
    if line is None:
        return
    present = mileages[-1] + driven_since
    at = line.reaches(limit * UM, present)
    assert present <= at.low <= at.value * (1.0 + 1e-9)
    assert at.value <= at.high * (1.0 + 1e-9)
    for end, sign in ((at.low, 1), (at.high, 0)):
        if present < end < 1e7:
            assert line.band(end)[sign] / UM == pytest.approx(limit, abs=1e-3)
