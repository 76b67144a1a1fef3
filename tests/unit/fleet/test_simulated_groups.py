"""Groups of simulated units: what does not differ is seldom called a difference, what differs is found.

The figures of the slow tests stand in ``docs/fleet.md``.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from atleak.fleet.groups import mean_differences
from tests.unit.fleet.simulated_groups import Called, called

WORSE = 30.0  # points of wear, on three of the lands


def runs(times: int, units: Sequence[int], **how: float) -> list[Called]:
    random = np.random.default_rng(20)
    return [called(random, units, **how) for _ in range(times)]


def test_groups_that_do_not_differ_are_seldom_called_different() -> None:
    found = runs(12, (14, 20))
    assert sum(each.any for each in found) <= 2  # of 12 with a probability of 5 %, more come twice in a hundred


def test_lands_that_differ_are_found() -> None:
    found = runs(4, (40, 40), worse=WORSE, worse_lands=3)
    assert all(any(each.wear) and any(each.same_mileage) for each in found)
    assert sum(sum(each.same_mileage) for each in found) <= 4 * 3 + 1, "others are not"


def test_units_that_were_driven_further_wear_the_same_at_the_same_mileage() -> None:
    found = runs(4, (60, 60), further=60e3)
    assert sum(any(each.wear) for each in found) >= 2
    assert not any(any(each.same_mileage) for each in found)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("units", "times", "most"),
    [
        ((12, 12), 100, 9),  # of 100 with a probability of 5 %, more than 9 come once in forty
        ((30, 30), 100, 9),
        ((12, 150), 100, 9),
        ((20, 20, 20), 100, 9),
        ((15,) * 8, 60, 7),
        ((100, 100), 100, 9),
    ],
)
def test_at_most_one_comparison_in_twenty_calls_anything_where_nothing_differs(
    units: Sequence[int], times: int, most: int
) -> None:
    assert sum(each.any for each in runs(times, units)) <= most


@pytest.mark.slow
@pytest.mark.parametrize(
    ("units", "how", "found_at_least"),
    [
        ((60, 60), {"worse": 12.0}, 0.95),
        ((60, 60), {"worse": 12.0, "worse_lands": 3}, 0.5),
        ((20, 20), {"worse": WORSE, "worse_lands": 3}, 0.9),
    ],
)
def test_what_differs_is_found(units: Sequence[int], how: dict[str, float], found_at_least: float) -> None:
    found = runs(40, units, **how)
    assert np.mean([any(each.wear) or any(each.same_mileage) for each in found]) >= found_at_least


def missed(times: int, units: tuple[int, int], sigma: float, apart: float) -> tuple[float, float]:
    """How often an interval of one difference, and any interval of all, misses the true difference.

    47 lands, skewed as the logarithmic normal distribution is and correlated over a unit.
    """
    random, first, second = np.random.default_rng(7), *units
    groups = np.repeat([0, 1], units)
    own, of_all = [], []
    for _ in range(times):
        common = random.standard_normal((first + second, 1))
        own_part = random.standard_normal((first + second, 47))
        values = np.exp(sigma * (np.sqrt(0.3) * common + np.sqrt(0.7) * own_part)) + apart * (groups == 0)[:, None]
        found = mean_differences(values, groups, [(0, 1)], level=0.05, shuffles=199)
        off = np.abs(found.value - apart) / found.error
        own.append(np.mean(off > found.own_reach))
        of_all.append(np.any(off > found.reach_of_all))
    return float(np.mean(own)), float(np.mean(of_all))


def test_intervals_of_small_skewed_groups_hold_the_true_difference() -> None:
    own, of_all = missed(30, (10, 40), 0.5, 1.0)
    assert own <= 0.08
    assert of_all <= 0.17  # of 30 with a probability of 5 %, more than 5 come twice in a thousand


@pytest.mark.slow
@pytest.mark.parametrize("units", [(10, 10), (10, 40), (10, 500), (50, 50)])
@pytest.mark.parametrize(("sigma", "apart"), [(0.5, 0.0), (0.5, 3.0), (1.0, 1.0), (1.0, 3.0)])
def test_intervals_hold_as_often_as_they_say(units: tuple[int, int], sigma: float, apart: float) -> None:
    own, of_all = missed(300, units, sigma, apart)
    assert own <= 0.065
    assert of_all <= 0.085  # of 300 with a probability of 5 %, more come twice in a thousand
