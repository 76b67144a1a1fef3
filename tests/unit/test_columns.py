"""Columns on disk, and ranks among numbers that come in pieces, against numpy with all of them at once."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from atleak import columns
from atleak.columns import DiskColumn, median_of, percentiles_of, positive, ranked, spans, steps_of, stream_of

NUMBERS = st.lists(st.floats(-1e150, 1e150), min_size=1, max_size=60)


def in_pieces(values: np.ndarray, length: int) -> Callable[[], Iterator[np.ndarray]]:
    return lambda: (values[low:high] for low, high in spans(len(values), length))


@pytest.fixture
def few_are_sorted(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(columns, "_FEW", 3)


def test_a_column_is_read_as_it_was_written(tmp_path: Path) -> None:
    values = np.random.default_rng(1).normal(size=1000)
    column = DiskColumn(tmp_path / "column")
    column.append(values[:400])
    column.append(values[400:])
    assert len(column) == 1000
    np.testing.assert_array_equal(column[:], values)
    np.testing.assert_array_equal(column[17:830], values[17:830])
    np.testing.assert_array_equal(column[990:2000], values[990:])
    assert len(column[500:400]) == 0
    assert (column[3], column[-1]) == (values[3], values[-1])
    column.write(100, np.zeros(5))
    assert column[99:106].tolist() == [values[99], 0.0, 0.0, 0.0, 0.0, 0.0, values[105]]
    column.remove()
    assert not (tmp_path / "column").exists()


@pytest.mark.parametrize("step", [2, 7, 10, 11, 300])
def test_every_so_many_th_number_is_that_of_the_whole(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, step: int
) -> None:
    monkeypatch.setattr(columns, "PIECE", 10)
    column = DiskColumn(tmp_path / "column", np.int64)
    column.append(np.arange(997))
    np.testing.assert_array_equal(column[::step], np.arange(997)[::step])
    np.testing.assert_array_equal(column[5:900:step], np.arange(997)[5:900:step])


@given(NUMBERS, st.integers(1, 70), st.floats(0.0, 100.0))
def test_medians_and_percentiles_are_numpys(numbers: list[float], length: int, percent: float) -> None:
    values = np.array(numbers)
    stream = in_pieces(values, length)
    assert median_of(stream) == np.median(values)
    close = 1e-12 * float(np.max(np.abs(values)))
    assert percentiles_of(stream, [percent])[0] == pytest.approx(np.percentile(values, percent), rel=1e-12, abs=close)


@pytest.mark.usefixtures("few_are_sorted")
@pytest.mark.parametrize("seed", range(5))
def test_numbers_too_many_to_sort_have_the_same_ranks(seed: int) -> None:
    generator = np.random.default_rng(seed)
    values = generator.choice([generator.normal(), -0.25, 0.01, 0.010000000000000002, 1e300, -1e-300, 0.0], 500)
    values[::7] = generator.normal(size=len(values[::7]))
    assert ranked(in_pieces(values, 33), range) == np.sort(values).tolist()


def test_of_nothing_there_is_no_rank() -> None:
    assert ranked(lambda: iter([np.empty(0)]), lambda count: [count]) == []
    assert math.isnan(median_of(lambda: iter([])))
    assert math.isnan(percentiles_of(lambda: iter([]), [90.0])[0])


def test_steps_do_not_end_with_a_piece() -> None:
    time = np.array([0.0, 1.0, 1.0, 4.0, 4.5, 4.0, 9.0])
    parts = list(steps_of(time, length=2)())
    assert np.concatenate(parts).tolist() == np.diff(time).tolist()
    assert np.concatenate(list(positive(steps_of(time, 1, 5, length=3))())).tolist() == [3.0, 0.5]
    assert np.concatenate(list(stream_of(time, 3)())).tolist() == time.tolist()
