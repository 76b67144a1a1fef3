"""Intervals of shares and of their differences, against the tables of the papers that compare them."""

from __future__ import annotations

import pytest

from atleak.equations import DomainError
from atleak.equations.proportions import newcombe_interval, wilson_interval


@pytest.mark.parametrize(
    ("count", "of", "interval"),
    [
        (81, 263, (0.2553, 0.3662)),
        (15, 148, (0.0624, 0.1605)),
        (0, 20, (0.0, 0.1611)),
        (1, 29, (0.0061, 0.1718)),
    ],
)
def test_score_intervals_of_newcombe_s_first_table(count: int, of: int, interval: tuple[float, float]) -> None:
    # R. G. Newcombe, Stat. Med. 17 (1998) 857-872, table I, method 3
    assert wilson_interval(count, of) == pytest.approx(interval, abs=5.1e-5)


@pytest.mark.parametrize(
    ("first", "of_first", "second", "of_second", "interval"),
    [
        (56, 70, 48, 80, (0.0524, 0.3339)),
        (9, 10, 3, 10, (0.1705, 0.8090)),
        (6, 7, 2, 7, (0.0582, 0.8062)),
        (5, 56, 0, 29, (-0.0381, 0.1926)),
        (0, 10, 0, 20, (-0.1611, 0.2775)),
        (0, 10, 0, 10, (-0.2775, 0.2775)),
        (10, 10, 0, 20, (0.6791, 1.0)),
        (10, 10, 0, 10, (0.6075, 1.0)),
    ],
)
def test_hybrid_score_intervals_of_newcombe_s_second_table(
    first: int, of_first: int, second: int, of_second: int, interval: tuple[float, float]
) -> None:
    # R. G. Newcombe, Stat. Med. 17 (1998) 873-890, table II, method 10: there the difference is first minus second
    assert newcombe_interval(second, of_second, first, of_first) == pytest.approx(interval, abs=5.1e-5)


def test_intervals_come_as_arrays_where_counts_do() -> None:
    low, high = wilson_interval([0, 15], [20, 148])
    assert (list(low), list(high)) == (
        pytest.approx([0.0, 0.0624], abs=5e-5),
        pytest.approx([0.1611, 0.1605], abs=5e-5),
    )


@pytest.mark.parametrize(("count", "of"), [(-1, 10), (11, 10), (0, 0)])
def test_counts_that_are_none_are_refused(count: int, of: int) -> None:
    with pytest.raises(DomainError):
        wilson_interval(count, of)
