"""A long series is thinned for the eye: no spike, no end and no gap is lost."""

from __future__ import annotations

import numpy as np

from atleak.measurements.road_test import thinned


def test_a_short_series_stays_as_it_is() -> None:
    assert thinned([np.zeros(2000)], 2000).tolist() == list(range(2000))


def test_spikes_ends_gaps_and_what_is_asked_for_stay() -> None:
    values = np.sin(np.arange(500_000.0) / 5000)
    values[123_456], values[400_001] = 9.0, -9.0
    values[250_000:250_100] = np.nan
    kept = thinned([values], 2000, keep=[77_777])
    assert len(kept) <= 2010
    assert (kept[0], kept[-1]) == (0, 499_999)
    assert {123_456, 400_001, 77_777, 249_999, 250_000, 250_099, 250_100} <= set(kept.tolist())
    assert (np.diff(kept) > 0).all()


def test_each_of_several_series_keeps_its_own_spike() -> None:
    leakage, share = np.zeros(100_000), np.zeros(100_000)
    leakage[1234], share[56_789] = 1.0, -1.0
    assert {1234, 56_789} <= set(thinned([leakage, share], 400).tolist())


def test_few_values_in_a_long_gap_all_stay() -> None:
    values = np.full(100_000, np.nan)
    values[[10, 500, 99_000]] = 1.0
    assert {10, 500, 99_000} <= set(thinned([values], 100).tolist())


def test_a_series_without_a_value_keeps_its_ends() -> None:
    assert thinned([np.full(10_000, np.nan)], 100).tolist() == [0, 9999]
