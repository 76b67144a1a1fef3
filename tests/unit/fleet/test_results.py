"""The folder of a fleet's results: written whole, read back, one row for every unit."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from atleak.fleet.columns import DATA_SETS, columns_of
from atleak.fleet.results import Results

from .made_up import CONTROLLERS, ERRORS, made_up_results


def test_what_is_written_is_read_back_by_atleak_and_by_others(tmp_path: Path) -> None:
    results = made_up_results(tmp_path / "fleet", units=20)
    assert results.controllers() == tuple(sorted(CONTROLLERS))
    assert (len(results.done()), len(results.failed())) == (20 + ERRORS, ERRORS)
    for data_set in DATA_SETS:
        table = results.table(data_set)
        by_others = pd.read_parquet(tmp_path / "fleet" / data_set)
        assert table.schema.names == [*columns_of(data_set).names, "controller"] == list(by_others.columns)
        assert table.num_rows == len(by_others)
    assert results.table("units").num_rows == 20


def test_results_are_written_twice_only_once(tmp_path: Path) -> None:
    made_up_results(tmp_path, units=20)
    results = made_up_results(tmp_path, units=20)
    assert results.table("units", ["input_sha256"]).num_rows == 20
    with Results.open(tmp_path, for_writing=True) as writing:
        writing.tidy()
    assert len(pd.read_parquet(tmp_path / "units")) == 20
    assert len(pd.read_parquet(tmp_path / "lands")) == results.table("lands").num_rows
