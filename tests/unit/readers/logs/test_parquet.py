"""Parquet logs: names, units, types, pandas' index columns, blank cells, and files that are refused."""

from __future__ import annotations

import datetime as dt
import gzip
import io
import os
from decimal import Decimal
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from atleak.common.errors import RoadTestError
from atleak.readers.logs import describe, head_of_parquet, log_columns, log_file, read_road_test, understand
from atleak.readers.logs import parquet_log as parquet_table

ROWS = 200
TIME = np.arange(ROWS) / 10
SPEED = 900.0 + 5.0 * np.arange(ROWS)
PRESSURE = 500.0 + np.arange(ROWS)


def parquet(columns: dict[str, Any], units: dict[str, str] | None = None, **options: Any) -> bytes:
    table = pa.table(columns)
    fields = [
        field.with_metadata({"Unit": units[field.name]}) if field.name in (units or {}) else field
        for field in table.schema
    ]
    stream = io.BytesIO()
    pq.write_table(table.cast(pa.schema(fields)), stream, **options)
    return stream.getvalue()


def of_pandas(frame: pd.DataFrame) -> bytes:
    stream = io.BytesIO()
    frame.to_parquet(stream)
    return stream.getvalue()


LOG = {"Time (s)": TIME, "Engine RPM": SPEED, "Line Pressure (kPa)": PRESSURE}


def test_it_is_the_same_road_test_as_that_of_the_text() -> None:
    lines = ["Time (s),Engine RPM,Line Pressure (kPa)"]
    lines += [f"{a!r},{b!r},{c!r}" for a, b, c in zip(*(each.tolist() for each in LOG.values()), strict=True)]
    text, test = read_road_test("\n".join(lines).encode(), name="a.csv"), read_road_test(parquet(LOG), name="a.parquet")
    assert test.time.tolist() == text.time.tolist()
    assert set(test.channels) == set(text.channels)
    for name in test.channels:
        assert test.values(name).tolist() == text.values(name).tolist()
    assert (test.format, test.rows) == ("Parquet", ROWS)


def test_a_unit_of_the_files_own_metadata_counts() -> None:
    data = parquet({"t": TIME, "n_engine": SPEED, "main_pressure": PRESSURE / 100}, {"t": "s", "main_pressure": "bar"})
    test = read_road_test(data, name="a.parquet")
    assert test.channels["main_pressure"].unit == "bar"
    assert not test.channels["main_pressure"].unit_assumed
    assert test.values("main_pressure")[0] == pytest.approx(5e5, rel=1e-12, abs=0.0)


@pytest.mark.parametrize(
    "stamps",
    [
        pa.array([dt.datetime(2026, 4, 17, 10) + dt.timedelta(seconds=each) for each in TIME.tolist()]),
        pa.array((TIME * 1e3).round().astype("int64")).cast(pa.timestamp("ms", "Europe/Berlin")),
        pa.array((TIME * 1e9).round().astype("int64")).cast(pa.timestamp("ns")),
        pa.array((TIME * 1e6).round().astype("int64")).cast(pa.duration("us")),
        pa.array((TIME * 1e3).round().astype("int32")).cast(pa.time32("ms")),
        pa.array([f"10:00:{each:06.3f}" for each in TIME.tolist()]),
        pa.array([Decimal(f"{each:.1f}") for each in TIME.tolist()]),
    ],
    ids=lambda array: str(array.type),
)
def test_time_of_any_type(stamps: pa.Array) -> None:
    test = read_road_test(parquet({"time": stamps, "engine_speed [rpm]": SPEED}), name="a.parquet")
    assert test.time == pytest.approx(TIME, rel=0.0, abs=1e-6)


@pytest.mark.parametrize(
    "gears",
    [
        pa.array(["P"] * 50 + ["1"] * 150),
        pa.array(["P"] * 50 + ["1"] * 150).dictionary_encode(),
        pa.array([b"P"] * 50 + [b"1"] * 150),
        pa.array(["P"] * 50 + ["1"] * 150, pa.large_string()),
        pa.array([0] * 50 + [1] * 150, pa.int8()),
        pa.array([False] * 50 + [True] * 150),
        pa.array(np.repeat([0.0, 1.0], [50, 150]).astype(np.float16)),
    ],
    ids=lambda array: str(array.type),
)
def test_values_of_any_type(gears: pa.Array) -> None:
    test = read_road_test(parquet({"time": TIME, "engine_speed [rpm]": SPEED, "gear": gears}), name="a.parquet")
    assert test.values("gear").tolist() == [0.0] * 50 + [1.0] * 150


def test_blank_cells_are_no_samples() -> None:
    sparse = pa.array([80.0 if each % 4 == 0 else None for each in range(ROWS)])
    texts = pa.array([f"{each},5" if each % 2 else None for each in range(ROWS)])
    columns = {"time": TIME, "engine_speed [rpm]": SPEED, "atf_temperature [°C]": sparse, "speed [km/h]": texts}
    test = read_road_test(parquet({**columns, "empty": pa.nulls(ROWS)}), name="a.parquet")
    assert test.channels["atf_temperature"].samples == 50
    assert test.channels["vehicle_speed"].samples == 100
    assert test.channels["vehicle_speed"].good[:2] * 3.6 == pytest.approx([1.5, 3.5], rel=1e-12, abs=0.0)


def test_what_pandas_wrote_as_index_is_the_clock() -> None:
    index = pd.date_range("2026-04-17 10:00", periods=ROWS, freq="100ms")
    frame = pd.DataFrame({"engine_speed [rpm]": SPEED}, index=index)
    test = read_road_test(of_pandas(frame), name="a.parquet")
    assert test.time == pytest.approx(TIME, rel=0.0, abs=1e-6)
    assert test.date == dt.date(2026, 4, 17)


def test_an_index_of_pandas_that_a_column_holds_too_is_read_once() -> None:
    frame = pd.DataFrame({"time": TIME, "engine_speed [rpm]": SPEED}).set_index("time", drop=False)
    assert "__index_level_0__" in pq.read_schema(io.BytesIO(of_pandas(frame))).names
    understood = understand(of_pandas(frame), name="a.parquet")
    assert [heading.label for heading in understood.headings] == ["time", "engine_speed [rpm]"]
    assert understood.road_test is not None


def test_columns_of_one_name_and_names_with_points() -> None:
    stream = io.BytesIO()
    names = ["time", "speed", "speed", "speed.engine", "engine.speed [rpm]"]
    pq.write_table(pa.table([TIME, SPEED, SPEED + 1, SPEED + 2, SPEED + 3], names=names), stream)
    mapping = {"engine_speed": "column 3", "vehicle_speed": "", "turbine_speed": "", "output_speed": ""}
    test = read_road_test(stream.getvalue(), name="a.parquet", mapping=mapping, units={"engine_speed": "rpm"})
    assert test.values("engine_speed")[0] * 60 == pytest.approx(901.0, rel=1e-12, abs=0.0)
    test = read_road_test(
        stream.getvalue(), name="a.parquet", mapping={**mapping, "engine_speed": "engine.speed [rpm]"}
    )
    assert test.values("engine_speed")[0] * 60 == pytest.approx(903.0, rel=1e-12, abs=0.0)


@pytest.mark.parametrize("names", [("T.oil", "rpm", "T"), ("Oil Temp", "Engine Speed [rpm]", "Oil Temp. [C]")])
@pytest.mark.parametrize("asked", [0, 1, 2])
def test_a_name_may_be_the_first_part_of_another(names: tuple[str, ...], asked: int) -> None:
    stream = io.BytesIO()
    pq.write_table(pa.table([TIME, SPEED + 1, SPEED + 2, SPEED + 3], names=["time", *names]), stream)
    mapping = {"engine_speed": names[asked], "vehicle_speed": "", "atf_temperature": ""}
    test = read_road_test(stream.getvalue(), name="a.parquet", mapping=mapping, units={"engine_speed": "rpm"})
    assert test.values("engine_speed")[0] * 60 == pytest.approx(901.0 + asked, rel=1e-12, abs=0.0)


@pytest.mark.skipif(os.name == "nt", reason="paths are Unicode there")
def test_a_path_need_not_be_utf_8(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(log_file, "LARGE", 100)
    path = tmp_path / os.fsdecode(b"l\xff.parquet")
    try:
        path.write_bytes(parquet({"time": TIME, "engine_speed [rpm]": SPEED}))
    except OSError:
        pytest.skip("this disk takes no such name")
    assert read_road_test(path).values("engine_speed")[0] * 60 == pytest.approx(900.0, rel=1e-12, abs=0.0)


def test_columns_without_names_need_them() -> None:
    data = parquet({"0": TIME, "1": SPEED})
    understood = understand(data, name="a.parquet")
    assert understood.problem is not None
    assert "no header" in str(understood.problem)
    test = read_road_test(data, name="a.parquet", mapping={"time": "column 1", "engine_speed": "column 2"})
    assert test.duration == pytest.approx(TIME[-1], rel=1e-12, abs=0.0)


def test_a_packed_one_and_one_on_the_disk_are_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    data = parquet(LOG)
    whole = read_road_test(data, name="a.parquet")
    monkeypatch.setattr(log_file, "LARGE", 1000)  # bytes from which on it is not held
    (tmp_path / "drive.log").write_bytes(data)
    (tmp_path / "drive.gz").write_bytes(gzip.compress(data))
    for name in ("drive.log", "drive.gz"):
        test = read_road_test(tmp_path / name)
        assert test.values("main_pressure").tolist() == whole.values("main_pressure").tolist()
    assert read_road_test(tmp_path / "drive.log").sha256 == whole.sha256


def test_blocks_are_put_together(monkeypatch: pytest.MonkeyPatch) -> None:
    texts = ["a", "b"] * (ROWS // 2)
    data = parquet({**LOG, "remark": texts, "gear": ["1", "2"] * (ROWS // 2)}, row_group_size=30)
    test = read_road_test(data, name="a.parquet")
    assert test.values("engine_speed") * 60 == pytest.approx(SPEED, rel=1e-12, abs=0.0)
    assert test.values("gear").tolist() == [1.0, 2.0] * (ROWS // 2)


def test_every_column_is_shown() -> None:
    data = parquet({**LOG, "Remark": ["on", "off"] * (ROWS // 2)}, {"Engine RPM": "1/min"})
    shown = {column.label: column for column in log_columns(data, name="a.parquet")}
    assert shown["Engine RPM"].unit == "1/min"
    assert (shown["Line Pressure (kPa)"].least, shown["Line Pressure (kPa)"].largest) == (500.0, 699.0)
    assert "on" in shown["Remark"].words


def test_what_is_understood_can_be_told_as_json() -> None:
    told = describe(understand(parquet(LOG), name="a.parquet"))
    assert (told["format"], told["rows"], told["encoding"]) == ("Parquet", ROWS, None)


def test_the_head_tells_the_columns_as_the_whole_does() -> None:
    data = parquet({**LOG, "gear": np.ones(ROWS, int)}, {"Engine RPM": "1/min"})
    few = parquet_table.head_of_parquet(data, "a.parquet")
    whole, head = understand(data, name="a.parquet"), understand(few, name="a.parquet")
    assert (head.signature, head.headings) == (whole.signature, whole.headings)
    assert head.signature


# --- refused ------------------------------------------------------------------------------------------------


def nested(kind: str) -> bytes:
    cells = {"list": [[1.0, 2.0]] * ROWS, "record": [{"a": 1, "b": 2}] * ROWS}[kind]
    return parquet({"time": TIME, "engine_speed": SPEED, "frames": cells})


@pytest.mark.parametrize("kind", ["list", "record"])
def test_several_values_in_a_cell_are_refused(kind: str) -> None:
    with pytest.raises(RoadTestError, match="'frames' holds several values in a cell") as caught:
        read_road_test(nested(kind), name="bus.parquet")
    assert caught.value.place.file == "bus.parquet"
    assert "one value in a cell" in str(caught.value.expected)


@pytest.mark.parametrize(
    "data",
    [
        b"PAR1",
        b"PAR1" + bytes(1000) + b"PAR1",
        parquet(LOG)[:2000],
        parquet(LOG)[:-40] + bytes(32) + b"\x10\x00\x00\x00PAR1",
        b"PAR1" + bytes(2000) + parquet(LOG)[2004:],
    ],
    ids=["magic alone", "zeros", "cut", "footer", "pages"],
)
def test_a_damaged_one_is_refused(data: bytes) -> None:
    for read in (read_road_test, log_columns):
        with pytest.raises(RoadTestError, match=r"cut\.parquet: this Parquet file is damaged"):
            read(data, name="cut.parquet")  # type: ignore[operator]
    with pytest.raises(RoadTestError, match="damaged"):
        head_of_parquet(data, "cut.parquet")


def test_without_rows_or_encrypted() -> None:
    with pytest.raises(RoadTestError, match="holds no rows"):
        read_road_test(parquet({"time": pa.array([], pa.float64()), "n": pa.array([], pa.float64())}), name="a.parquet")
    with pytest.raises(RoadTestError, match="encrypted"):
        read_road_test(b"PARE" + bytes(2000) + b"PARE", name="a.parquet")


def test_what_unfolds_without_end_is_refused_before_it_is_read(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(parquet_table, "_LARGEST", 0)
    data = parquet({"time": np.repeat(TIME, 1000), "engine_speed [rpm]": np.zeros(1000 * ROWS)})
    assert 30 * len(data) < 16 * 1000 * ROWS
    with pytest.raises(RoadTestError, match="unfolds to 200000 rows of 2 columns"):
        read_road_test(data, name="bomb.parquet")
