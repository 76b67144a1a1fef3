"""Long columns looked through a block at a time: the same as looking at the whole."""

from __future__ import annotations

import hashlib
from pathlib import Path

import numpy as np
import pytest

from atleak.intake.road_test import blocks
from atleak.intake.road_test.blocks import ends_of, ends_of_steps, steps_over
from atleak.intake.road_test.clock.timeline import build
from atleak.intake.road_test.files.log_file import open_source

LENGTHS = [1, 2, blocks._BLOCK - 1, blocks._BLOCK, blocks._BLOCK + 1, blocks._BLOCK + 2, 3 * blocks._BLOCK]


@pytest.mark.parametrize("length", LENGTHS)
def test_blocks_say_what_the_whole_column_says(length: int) -> None:
    values = np.random.default_rng(length).normal(0, 100, length)
    steps = np.diff(values)
    assert ends_of(values) == (values.min(), values.max())
    assert ends_of_steps(values) == ((steps.min(), steps.max()) if length > 1 else None)
    assert steps_over(values, 150.0).tolist() == np.flatnonzero(steps > 150.0).tolist()


@pytest.mark.parametrize("strange", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("place", [0, blocks._BLOCK, -1])
def test_one_cell_that_is_no_finite_number_is_found(strange: float, place: int) -> None:
    values = np.arange(2.0 * blocks._BLOCK)
    values[place] = strange
    assert ends_of(values) is None
    assert ends_of_steps(values) is None


def test_a_gap_between_two_blocks_parts_the_log() -> None:
    time = np.arange(300_000) * 0.01
    time[2 * blocks._BLOCK :] += 60.0
    timeline = build(time)
    assert [segment.start for segment in timeline.segments] == [0.0, time[2 * blocks._BLOCK]]
    assert timeline.gaps == (float(time[2 * blocks._BLOCK] - time[2 * blocks._BLOCK - 1]),)


def test_the_digest_is_that_of_the_whole_file(tmp_path: Path) -> None:
    content = b"1,2\n" * 300_000
    path = tmp_path / "log.csv"
    path.write_bytes(content)
    assert open_source(path).sha256 == open_source(content).sha256 == hashlib.sha256(content).hexdigest()
