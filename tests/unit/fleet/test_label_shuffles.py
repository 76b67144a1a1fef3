"""Differences of means over many lands, against least squares solved anew and labels dealt out one by one."""

from __future__ import annotations

import numpy as np
import pytest

from atleak.fleet.groups import mean_differences


@pytest.fixture
def measured() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Wear of 60 units at 6 lands, some not measured, in three groups and four classes."""
    random = np.random.default_rng(3)
    groups, classes = random.integers(0, 3, 60), random.integers(0, 4, 60)
    values = random.lognormal(0.0, 0.6, (60, 6)) * (1.0 + 0.3 * classes[:, None]) + 0.4 * (groups == 1)[:, None]
    values[random.random(values.shape) < 0.1] = np.nan
    return values, groups, classes


def least_squares(values: np.ndarray, is_first: np.ndarray, classes: np.ndarray) -> tuple[float, float]:
    """A difference between two sides with a mean for each class, and its standard error by White's sandwich."""
    kept = ~np.isnan(values)
    values, is_first, classes = values[kept], is_first[kept].astype(float), classes[kept]
    design = np.column_stack([is_first, *(classes == each for each in np.unique(classes))]).astype(float)
    inverse = np.linalg.inv(design.T @ design)
    effects = inverse @ design.T @ values
    off = values - design @ effects
    covariance = inverse @ (design.T * off**2) @ design @ inverse
    return float(effects[0]), float(np.sqrt(covariance[0, 0]))


@pytest.mark.parametrize("by_class", [False, True])
def test_differences_and_their_errors_are_those_of_least_squares(
    measured: tuple[np.ndarray, np.ndarray, np.ndarray], by_class: bool
) -> None:
    values, groups, classes = measured
    pairings = [(0, 1), (2, 0), (1, None)]
    found = mean_differences(values, groups, pairings, level=0.05, classes=classes if by_class else None, shuffles=19)
    for row, (first, second) in enumerate(pairings):
        here = np.ones(len(groups), bool) if second is None else np.isin(groups, (first, second))
        within = classes[here] if by_class else np.zeros(here.sum())
        for land in range(values.shape[1]):
            expected = least_squares(values[here, land], groups[here] == first, within)
            assert (found.value[row, land], found.error[row, land]) == pytest.approx(expected, rel=1e-9, abs=0.0)


def test_without_classes_a_difference_is_that_of_the_means(
    measured: tuple[np.ndarray, np.ndarray, np.ndarray],
) -> None:
    values, groups, _ = measured
    found = mean_differences(values, groups, [(0, 1)], level=0.05, shuffles=19)
    means = [np.nanmean(values[groups == group], axis=0) for group in (0, 1)]
    assert found.value[0] == pytest.approx(means[0] - means[1], abs=1e-12)


def test_reaches_are_what_labels_give_that_are_dealt_out_one_after_the_other(
    measured: tuple[np.ndarray, np.ndarray, np.ndarray],
) -> None:
    values, groups, _ = measured
    two = groups < 2
    values, groups = values[two], groups[two]
    apart = values - np.where(groups[:, None] == 0, *(np.nanmean(values[groups == each], axis=0) for each in (0, 1)))
    random, one = np.random.default_rng(99), np.zeros(len(groups))
    own, largest = [], []
    for kind in (values, apart):
        ratios = []
        for _ in range(600):
            dealt = random.permutation(groups)
            pairs = [least_squares(kind[:, land], dealt == 0, one) for land in range(kind.shape[1])]
            ratios.append([abs(value) / error for value, error in pairs])
        own.append(np.quantile(ratios, 0.95, axis=0))
        largest.append(np.quantile(np.max(ratios, axis=1), 0.95))
    found = mean_differences(values, groups, [(0, 1)], level=0.05, shuffles=999)
    assert found.reach_of_all == pytest.approx(max(largest), rel=0.08, abs=0.0)
    assert found.own_reach[0] == pytest.approx(np.maximum(*own), rel=0.12, abs=0.0)
    assert found.reach_of_all > 1.2 * found.own_reach.max()


def test_the_same_units_give_the_same_reaches(measured: tuple[np.ndarray, np.ndarray, np.ndarray]) -> None:
    values, groups, _ = measured
    first, again = (mean_differences(values, groups, [(0, 1)], level=0.05, shuffles=99) for _ in range(2))
    assert first.reach_of_all == again.reach_of_all


def test_what_is_of_too_few_units_has_no_reach() -> None:
    random = np.random.default_rng(1)
    values, groups = random.normal(size=(40, 2)), np.repeat([0, 1], 20)
    values[9:20, 0] = np.nan
    found = mean_differences(values, groups, [(0, 1)], level=0.05, shuffles=99)
    assert list(found.enough[0]) == [False, True]
    assert np.isnan(found.own_reach[0, 0])
    assert np.isfinite([found.own_reach[0, 1], found.value[0, 0], found.reach_of_all]).all()
    values[9:20, 1] = np.nan
    assert np.isnan(mean_differences(values, groups, [(0, 1)], level=0.05, shuffles=99).reach_of_all)


def test_a_land_that_nobody_measured_or_that_is_alike_everywhere_is_no_difference() -> None:
    values, groups = np.column_stack([np.full(24, np.nan), np.full(24, 3.0)]), np.repeat([0, 1], 12)
    found = mean_differences(values, groups, [(0, 1)], level=0.05, shuffles=99)
    assert np.isnan(found.value[0, 0])
    assert (found.value[0, 1], found.error[0, 1], found.reach_of_all) == (0.0, 0.0, 0.0)
