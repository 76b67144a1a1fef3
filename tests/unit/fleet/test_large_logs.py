"""A unit whose log is read in pieces: its rows are those of the whole log, and nothing stays on the disk."""

from __future__ import annotations

import io
import math
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pyarrow.csv
import pyarrow.parquet as pq
import pytest

from atleak.engine.assumed_pressure import OPERATING_POINTS
from atleak.fleet import task
from atleak.fleet.rows import Rows
from atleak.fleet.table_units import TableUnits
from atleak.fleet.units import FleetUnit
from atleak.fleet.work import Room, evaluate
from atleak.intake.road_test import pieces
from atleak.intake.road_test.pieces import text_blocks, timelines
from atleak.job import file as job_file
from atleak.job.case import Case, SourceFile
from atleak.job.file import write_job_file
from atleak.job.record import Job
from atleak.version import __version__
from tests.unit.drives import drive
from tests.unit.intake.road_test.messy_logs import messy_log

SHEET = Path(__file__).resolve().parents[3] / "sample_data" / "measuring_sheet_four_speed.xlsx"
LITTLE = 200 << 20  # bytes of memory in which no log is held
_EACH_TIME = {"evaluated_at", "seconds"}
_OF_PIECES = {"result_sha256", "road_in_pieces"}
_COLUMNS = {
    "engine_speed": ("Engine speed [rpm]", 60.0),
    "gear": ("Gear", 1.0),
    "atf_temperature": ("ATF temperature [°C]", 1.0),
    "main_pressure": ("Line pressure [kPa]", 1e-3),
}


@pytest.fixture(autouse=True)
def small_pieces(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let even the logs of tests have several pieces."""
    monkeypatch.setattr(text_blocks, "BLOCK", 9_000)
    monkeypatch.setattr(timelines, "PIECE", 300)
    monkeypatch.setattr(pieces, "PIECE", 170)


def log_of(*quantities: str, seed: int = 3) -> bytes:
    test = drive(seed, 60.0, quantities)
    columns = [test.time, *(np.asarray(test.values(name)) * _COLUMNS[name][1] for name in quantities)]
    lines = [",".join("" if math.isnan(cell) else f"{cell:.3f}" for cell in row) for row in zip(*columns, strict=True)]
    return "\n".join([",".join(["Time [s]", *(_COLUMNS[name][0] for name in quantities)]), *lines, ""]).encode()


def unit_of(log: SourceFile, sheet: bytes | None = None, **choices: Any) -> FleetUnit:
    readings = SourceFile(SHEET.name, SHEET.read_bytes() if sheet is None else sheet)
    return FleetUnit("unit", "file:unit", case=Case(readings=readings, road_test=log, remember=False, **choices))


def on_disk(folder: Path, log: bytes) -> SourceFile:
    path = folder / "log.csv"
    path.write_bytes(log)
    return SourceFile.at(path)


def both(unit: FleetUnit, folder: Path) -> tuple[Rows, Rows]:
    """The rows of a unit whose log is held, and of the same one in pieces, after which nothing is left there."""
    scratch = folder / "scratch"
    scratch.mkdir()
    whole, parts = evaluate(unit), evaluate(unit, room=Room(LITTLE, scratch))
    assert list(scratch.iterdir()) == []
    return whole, parts


def _cells(rows: Rows, without: set[str]) -> Iterator[tuple[str, Any]]:
    for data_set, table in rows.tables.items():
        for number, row in enumerate(table.to_pylist()):
            yield from ((f"{data_set} {number} {name}", row[name]) for name in row if name not in without)


def assert_same(found: Rows, expected: Rows) -> None:
    assert (found.controller, found.input_sha256, found.verdict) == (
        expected.controller,
        expected.input_sha256,
        expected.verdict,
    )
    ours, theirs = (dict(_cells(each, _EACH_TIME | _OF_PIECES)) for each in (found, expected))
    assert ours.keys() == theirs.keys()
    for name, wanted in theirs.items():
        close = pytest.approx(wanted, rel=1e-12, abs=1e-15) if isinstance(wanted, float) else wanted
        assert ours[name] == close, name


def the(rows: Rows, data_set: str) -> Mapping[str, Any]:
    (row,) = rows.tables[data_set].to_pylist()  # type: ignore[index]
    return row  # type: ignore[no-any-return]


@pytest.mark.parametrize("quantities", [tuple(_COLUMNS), ("engine_speed", "main_pressure")], ids=["all", "two"])
def test_a_unit_has_the_rows_of_its_whole_log(tmp_path: Path, quantities: tuple[str, ...]) -> None:
    whole, parts = both(unit_of(on_disk(tmp_path, log_of(*quantities))), tmp_path)
    assert_same(parts, whole)
    assert [the(each, "units")["road_in_pieces"] for each in (whole, parts)] == [False, True]
    assert the(parts, "units")["max_leakage_dm3_min"] > 0.0
    assert ("temperatures" in parts.tables) == ("atf_temperature" in quantities)


@pytest.mark.parametrize("seed", [4, *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(5, 15))])
def test_a_log_with_all_that_goes_wrong_in_logs_has_them_too(tmp_path: Path, seed: int) -> None:
    whole, parts = both(unit_of(on_disk(tmp_path, messy_log(seed, 40.0))), tmp_path)
    assert_same(parts, whole)


@pytest.mark.parametrize("names", [("engine_speed", "gear", "atf_temperature"), tuple(_COLUMNS)], ids=["", "logged"])
def test_an_assumed_main_pressure_is_that_of_the_whole_log(tmp_path: Path, names: tuple[str, ...]) -> None:
    choices = (("main_pressure", OPERATING_POINTS),)
    whole, parts = both(unit_of(on_disk(tmp_path, log_of(*names)), constants=choices), tmp_path)
    assert_same(parts, whole)
    assert the(parts, "units")["road_in_pieces"]


def test_a_log_that_goes_wrong_in_the_middle_is_refused_in_the_same_words(tmp_path: Path) -> None:
    lines = log_of(*_COLUMNS).decode().split("\n")
    lines.insert(700, lines[0].replace("kPa", "psi"))
    whole, parts = both(unit_of(on_disk(tmp_path, "\n".join(lines).encode())), tmp_path)
    assert_same(parts, whole)
    assert "the unit changes from kPa to psi" in the(parts, "errors")["message"]


def test_nothing_is_left_where_another_file_of_the_unit_is_at_fault(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(*given: Any, **options: Any) -> None:
        assert len(list((tmp_path / "scratch").glob("atleak-log-*"))) == 1
        raise ZeroDivisionError

    unit = unit_of(on_disk(tmp_path, log_of(*_COLUMNS)))
    monkeypatch.setattr("atleak.driven.findings_in_pieces", broken)
    _, parts = both(unit, tmp_path)
    assert "ZeroDivisionError" in the(parts, "errors")["message"]


def test_a_large_log_of_a_job_file_is_unpacked_to_the_disk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(job_file, "_LARGE", 1000)
    case = unit_of(on_disk(tmp_path, log_of(*_COLUMNS))).opened()[0]
    path = tmp_path / "job.zip"
    path.write_bytes(write_job_file(case.diagnose(), Job(number="7"), case))
    unit = FleetUnit("job.zip", f"file:{path}", job_file=SourceFile.at(path))
    kept, _ = unit.opened(tmp_path)
    assert kept.road_test is not None
    assert (kept.road_test.name, kept.road_test.data) == ("log.csv", None)
    whole, parts = both(unit, tmp_path)
    assert_same(parts, whole)
    assert (the(parts, "units")["number"], the(parts, "units")["road_in_pieces"]) == ("7", True)


def test_a_row_of_a_table_may_name_a_large_log(tmp_path: Path) -> None:
    on_disk(tmp_path, log_of(*_COLUMNS))
    (tmp_path / SHEET.name).write_bytes(SHEET.read_bytes())
    table = tmp_path / "fleet.csv"
    table.write_text(f"Sheet;Log\n{SHEET.name};log.csv\n", encoding="utf-8")
    (unit,) = TableUnits(table, Case(remember=False))
    whole, parts = both(unit, tmp_path)
    assert_same(parts, whole)
    assert the(parts, "units")["road_in_pieces"]


def test_a_parquet_log_is_as_large_as_it_unfolds(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    table, path = pyarrow.csv.read_csv(io.BytesIO(log_of(*_COLUMNS))), tmp_path / "log.parquet"
    pq.write_table(table, path, row_group_size=130)
    unit = unit_of(SourceFile.at(path))
    whole, parts = both(unit, tmp_path)
    assert_same(parts, whole)
    assert the(parts, "units")["road_in_pieces"]
    monkeypatch.setattr("atleak.intake.road_test.pieces.any_size.LARGE", 8 * table.num_rows * table.num_columns - 1)
    assert the(evaluate(unit), "units")["road_in_pieces"]
    monkeypatch.setattr("atleak.intake.road_test.pieces.any_size.LARGE", 8 * table.num_rows * table.num_columns)
    assert not the(evaluate(unit), "units")["road_in_pieces"]


def test_a_log_that_is_not_read_in_pieces_is_read_whole_where_there_is_memory(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    unit = unit_of(on_disk(tmp_path, log_of(*_COLUMNS).decode().encode("utf-16")))
    whole, parts = both(unit, tmp_path)
    assert "too large to be held in memory" in the(parts, "errors")["message"]
    assert the(parts, "errors")["kind"] == "refused"
    monkeypatch.setattr("atleak.intake.road_test.pieces.any_size.LARGE", 1000)
    assert_same(evaluate(unit, room=Room(LITTLE + (1 << 30))), whole)


def test_nothing_is_left_with_temporary_files_either(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    unit = unit_of(SourceFile("log.csv", log_of(*_COLUMNS)))
    assert the(evaluate(unit, room=Room(LITTLE)), "units")["road_in_pieces"]
    assert list(tmp_path.iterdir()) == []


def test_a_worker_reads_in_pieces_what_its_memory_does_not_hold(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "scratch").mkdir()
    memory = SimpleNamespace(memory_limit=LITTLE)
    worker = SimpleNamespace(memory_manager=memory, local_directory=str(tmp_path / "scratch"))
    monkeypatch.setattr(task, "get_worker", lambda: worker)
    unit = task.packed_unit(unit_of(on_disk(tmp_path, log_of(*_COLUMNS))))
    for limit, in_pieces in ((LITTLE, True), (LITTLE + (1 << 30), False), (0, False)):
        memory.memory_limit = limit
        assert the(task.on_worker(unit, "unit", 1, None, __version__).rows, "units")["road_in_pieces"] == in_pieces
    assert list((tmp_path / "scratch").iterdir()) == []
