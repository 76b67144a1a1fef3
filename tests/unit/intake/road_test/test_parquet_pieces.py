"""A Parquet log that is read in pieces is understood, to the last bit, as one that is read whole."""

from __future__ import annotations

import datetime as dt
import gzip
import io
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from atleak.errors import RoadTestError
from atleak.intake.native import process
from atleak.intake.road_test import understand
from atleak.intake.road_test.pieces import read_large_log, understand_in_pieces
from tests.unit.intake.road_test.messy_logs import messy_log
from tests.unit.intake.road_test.test_pieces import assert_same, cut, read_both


@pytest.fixture(autouse=True)
def small_pieces() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        cut(patch, 700, 23)
        yield


def messy_parquet(seed: int, seconds: float, row_group: int) -> bytes:
    """A log with all that goes wrong in logs, as Parquet: columns of numbers or texts, as they happen to be."""
    text = messy_log(seed, seconds).decode("utf-8-sig", "replace")
    lines = text.replace("\r\n", "\n").split("\n")
    delimiter = max(",;\t", key=lines[len(lines) // 2].count)
    rows = [line.split(delimiter) for line in lines if line]
    width = Counter(map(len, rows)).most_common(1)[0][0]
    names, *rows = (row for row in rows if len(row) == width)
    generator = np.random.default_rng(seed)
    columns = [column_of(list(cells), as_text=bool(generator.random() < 0.2)) for cells in zip(*rows, strict=True)]
    stream = io.BytesIO()
    pq.write_table(pa.table(columns, names=names), stream, row_group_size=row_group)
    return stream.getvalue()


def column_of(cells: list[str], *, as_text: bool) -> pa.Array:
    blank = [None if not cell.strip() else cell for cell in cells]
    for convert in () if as_text else (float, lambda cell: dt.datetime.strptime(cell, "%d.%m.%Y %H:%M:%S.%f")):
        try:
            return pa.array([None if cell is None else convert(cell) for cell in blank])
        except ValueError:
            continue
    return pa.array(blank, pa.string())


def test_logs_with_all_that_goes_wrong_are_understood_as_the_whole() -> None:
    codes = sum((assert_same(*read_both(messy_parquet(seed, 12.0, 37))) for seed in range(12)), Counter())
    assert {"gaps", "clock_restarted", "stray_stamps", "reordered", "suspect_samples", "cells_unreadable"} <= {*codes}


@pytest.mark.slow
@settings(max_examples=40)
@given(st.integers(0, 1_000_000), st.integers(2, 300), st.integers(1, 500), st.floats(3.0, 60.0))
def test_any_messy_log_is_understood_as_the_whole(seed: int, piece: int, row_group: int, seconds: float) -> None:
    with pytest.MonkeyPatch.context() as patch:
        cut(patch, 700, piece)
        assert_same(*read_both(messy_parquet(seed, seconds, row_group)))


def test_stamps_that_begin_with_blank_cells() -> None:
    moments = [None if each < 50 else dt.datetime(2026, 4, 17) + dt.timedelta(seconds=each / 10) for each in range(200)]
    speed = [800.0 + each for each in range(200)]
    stream = io.BytesIO()
    pq.write_table(pa.table({"time": moments, "engine_speed [rpm]": speed}), stream, row_group_size=20)
    codes = assert_same(*read_both(stream.getvalue()))
    assert "unreadable_stamps" in codes


def whole_rows(count: int) -> pa.Table:
    time = np.arange(count) / 10
    return pa.table({"Time (s)": time, "RPM (rpm)": 800.0 + np.arange(count) % 900})


def test_a_packed_log_is_read_in_pieces_too(tmp_path: Path) -> None:
    stream = io.BytesIO()
    pq.write_table(whole_rows(300), stream)
    path = tmp_path / "log.gz"
    path.write_bytes(gzip.compress(stream.getvalue()))
    log = read_large_log(path)
    assert log.head.rows == len(log) == 300
    log.close()


def test_what_reads_a_log_is_free_again_where_the_log_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "log.parquet"
    texts = {
        name: [*map(str, cells.to_pylist())] for name, cells in zip(("Time (s)", "RPM"), whole_rows(300), strict=True)
    }
    for name, cells in texts.items():
        cells[150] = name if name == "Time (s)" else "Speed"  # another header
    pq.write_table(pa.table(texts), path, row_group_size=10)
    kept = [understand_in_pieces(path) for _ in range(process.CHILDREN + 1)]
    assert all("another header" in str(each.problem) for each in kept)


def test_one_that_is_damaged_further_on_is_refused(tmp_path: Path) -> None:
    stream = io.BytesIO()
    pq.write_table(whole_rows(4000), stream, row_group_size=1000, use_dictionary=False)
    data = bytearray(stream.getvalue())
    last = pq.read_metadata(stream).row_group(3).column(0).data_page_offset
    data[last : last + 40] = bytes(40)
    path = tmp_path / "log.parquet"
    path.write_bytes(data)
    with pytest.raises(RoadTestError, match=r"log\.parquet: this Parquet file is damaged"):
        read_large_log(path)


def test_a_workbook_is_not_read_in_pieces(tmp_path: Path) -> None:
    path = tmp_path / "log.xlsx"
    path.write_bytes(b"PK\x03\x04" + bytes(2000))
    with pytest.raises(RoadTestError, match="a workbook is not read in pieces"):
        understand_in_pieces(path)


def test_the_choices_of_a_whole_log_hold_for_one_in_pieces(tmp_path: Path) -> None:
    path = tmp_path / "log.parquet"
    pq.write_table(whole_rows(300).rename_columns(["0", "1"]), path)
    choices = {"mapping": {"time": "column 1", "engine_speed": "column 2"}, "units": {"engine_speed": "rpm"}}
    whole, pieces = understand(path, **choices), understand_in_pieces(path, **choices)
    assert whole.road_test is not None
    assert_same(whole, pieces)
