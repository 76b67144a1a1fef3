"""What is learned from simulated units: it is right as often as it says, and it names the worn one.

The figures of the slow tests stand in ``docs/coverage.md``.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import pytest
from scipy import stats

from atleak.analysis.learning.learned_clearances import ClearanceEstimate, estimate_clearance
from atleak.analysis.learning.outliers import Outliers, WhyUnit, find_outliers
from tests.unit.analysis.learning.conftest import BETWEEN, WORN, Simulate, Simulated


class Run(NamedTuple):
    given: Simulated
    outliers: Outliers
    found: ClearanceEstimate

    @property
    def named(self) -> set[int]:
        """The units that are left out, wholly or in part."""
        pairs = (self.outliers.wide | self.outliers.tight).any(axis=1)
        return {*self.outliers.units, *map(int, np.flatnonzero(pairs))}

    @property
    def factor(self) -> np.ndarray:
        return stats.t.ppf(0.975, self.found.degrees)

    @property
    def covered(self) -> np.ndarray:
        """Which mounting clearances lie within the uncertainty that is stated for them."""
        off = np.abs(self.found.clearance - self.given.true)
        return off <= self.factor * self.found.standard_error


def runs(simulate: Simulate, times: int, seed: int = 1, **how) -> Iterator[Run]:
    random = np.random.default_rng(seed)
    for _ in range(times):
        given = simulate(random, **how)
        outliers = find_outliers(given.measured, given.own)
        yield Run(given, outliers, estimate_clearance(given.measured, given.own, outliers.kept))


def coverage(simulate: Simulate, times: int, **how) -> float:
    return float(np.mean([run.covered for run in runs(simulate, times, **how)]))


def rate(simulate: Simulate, times: int, **how) -> float:
    """How often the worn unit, or with none worn any unit, is named."""
    named = [run.named for run in runs(simulate, times, **how)]
    return sum(WORN in each if "depth" in how else bool(each) for each in named) / times


@pytest.mark.parametrize(
    "how",
    [
        {},
        {"units": 2},
        {"depth": 6e-6},
        pytest.param({"units": 3}, marks=pytest.mark.slow),
        pytest.param({"units": 5, "shift": 1e-6}, marks=pytest.mark.slow),
        pytest.param({"depth": 8e-6, "worn_lands": 5}, marks=pytest.mark.slow),
    ],
)
def test_mounting_clearances_lie_within_their_uncertainty_95_times_in_100(simulate: Simulate, how: dict) -> None:
    sets = 12  # of 29 lands, so that 95 % are told from 91 and 99
    assert coverage(simulate, sets, **how) == pytest.approx(0.95, abs=0.04)


@pytest.mark.slow
@pytest.mark.parametrize(
    "how",
    [
        {},
        {"units": 2},
        {"units": 4},
        {"shift": 1e-6},
        {"between": 0.5e-6},
        {"depth": 6e-6},
        {"depth": 8e-6, "worn_lands": 5},
        {"depth": 5e-6, "worn_lands": 3},
    ],
)
def test_they_do_so_over_many_sets(simulate: Simulate, how: dict) -> None:
    assert coverage(simulate, 200, **how) == pytest.approx(0.95, abs=0.015)


@pytest.mark.parametrize("units", [2, 12])
def test_the_tolerance_holds_95_of_100_new_pairs(simulate: Simulate, units: int) -> None:
    held = []
    for run in runs(simulate, 8, units=units):
        apart = stats.t.ppf(0.975, run.found.spread_degrees) * run.found.unresolved
        half = np.hypot(apart, run.factor * run.found.standard_error)
        low, high = ((run.found.clearance + way * half - run.given.true) / BETWEEN for way in (-1.0, 1.0))
        held.append(stats.norm.cdf(high) - stats.norm.cdf(low))
    assert np.mean(held) == pytest.approx(0.95, abs=0.02)


def test_the_spread_between_units_is_told_from_that_of_the_readings(simulate: Simulate) -> None:
    (run,) = runs(simulate, 1)
    assert np.median(run.found.spread) == pytest.approx(BETWEEN, abs=0.2e-6)
    assert run.found.measurement == pytest.approx(run.given.own[0], abs=1e-9)


def test_a_worn_unit_is_named_among_twelve_and_no_other_is(simulate: Simulate) -> None:
    named = [run.named for run in runs(simulate, 8, depth=5e-6)]
    assert named.count({WORN}) == len(named)


def test_a_unit_with_three_worn_lands_is_named_with_them(simulate: Simulate) -> None:
    for run in runs(simulate, 4, depth=12e-6, worn_lands=3):
        assert run.outliers.units[WORN] is WhyUnit.WIDE_LANDS
        assert run.outliers.wide[WORN].sum() >= 2


@pytest.mark.slow
@pytest.mark.parametrize(
    ("depth", "worn_lands", "at_least"),
    [
        (3e-6, 29, 0.97),
        (5e-6, 29, 0.99),
        (5e-6, 5, 0.35),
        (8e-6, 5, 0.95),
        (8e-6, 3, 0.75),
        (12e-6, 3, 0.97),
        (12e-6, 1, 0.78),
    ],
)
def test_how_often_a_worn_unit_is_named(simulate: Simulate, depth: float, worn_lands: int, at_least: float) -> None:
    assert rate(simulate, 200, depth=depth, worn_lands=worn_lands) >= at_least


@pytest.mark.slow
@pytest.mark.parametrize("how", [{}, {"units": 2}, {"units": 4}, {"shift": 0.7e-6}, {"between": 0.5e-6}])
def test_in_twenty_sets_of_new_units_about_one_has_a_false_alarm(simulate: Simulate, how: dict) -> None:
    assert rate(simulate, 300, **how) <= 0.08


def test_a_reading_that_is_too_small_is_left_out_too_and_not_called_wear() -> None:
    random = np.random.default_rng(5)
    measured = 15e-6 + random.normal(0.0, 1.5e-6, (8, 20))
    measured[2, 7] -= 15e-6
    outliers = find_outliers(measured, np.full(measured.shape, 1e-6))
    assert list(zip(*np.nonzero(outliers.tight), strict=True)) == [(2, 7)]
    assert not outliers.wide.any()
    assert not outliers.units


def test_of_two_units_the_wider_pair_is_left_out(simulate: Simulate) -> None:
    given = simulate(np.random.default_rng(2), units=2)
    given.measured[0, 4] += 20e-6
    outliers = find_outliers(given.measured, given.own)
    assert list(zip(*np.nonzero(outliers.wide), strict=True)) == [(0, 4)]
    assert outliers.kept[1, 4]


def test_units_that_differ_alike_in_all_lands_tell_as_much_as_two_values() -> None:
    random = np.random.default_rng(4)
    measured = 15e-6 + random.normal(0.0, 0.5e-6, (2, 30)) + np.array([[-3e-6], [3e-6]])
    found = estimate_clearance(measured, np.full(measured.shape, 0.3e-6), np.ones(measured.shape, dtype=bool))
    assert found.degrees[0] < 1.2  # Student's t of one degree of freedom: 12.7
    apart = estimate_clearance(
        15e-6 + random.normal(0.0, 3e-6, (2, 30)), np.full((2, 30), 0.3e-6), np.ones((2, 30), dtype=bool)
    )
    assert apart.degrees[0] > 15.0


def test_one_unit_shows_no_spread(simulate: Simulate) -> None:
    given = simulate(np.random.default_rng(2), units=1)
    outliers = find_outliers(given.measured, given.own)
    found = estimate_clearance(given.measured, given.own, outliers.kept)
    assert outliers.kept.all()
    assert np.isnan(found.spread).all()
    assert found.standard_error == pytest.approx(given.own[0], abs=1e-12)


def test_lands_that_nobody_measured_leave_the_others_alone(simulate: Simulate) -> None:
    given = simulate(np.random.default_rng(3), units=4)
    given.measured[:, 5] = np.nan
    given.measured[1:, 6] = np.nan
    outliers = find_outliers(given.measured, given.own)
    found = estimate_clearance(given.measured, np.where(np.isnan(given.measured), np.nan, given.own), outliers.kept)
    assert found.pairs[5] == 0
    assert np.isnan(found.clearance[5])
    assert found.pairs[6] == 1
    assert found.standard_error[6] == pytest.approx(2.0 * found.standard_error[0], abs=0.01e-6)  # pooled over all lands
    assert np.isfinite(found.standard_error[:5]).all()
