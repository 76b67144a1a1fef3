"""The folder of a fleet's results: written whole, read back, one row for every unit."""

from __future__ import annotations

import errno
import json
from pathlib import Path
from typing import Any

import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from atleak.common.errors import FleetError, OutputError
from atleak.fleet import folder as parts
from atleak.fleet import results
from atleak.fleet.columns import DATA_SETS, columns_of
from atleak.fleet.results import Results
from atleak.version import __version__
from tests.unit.fleet.made_up import CONTROLLERS, ERRORS, made_up_results
from tests.unit.fleet.writing import LANDS, failed, unit


def rows_in(folder: Path, data_set: str) -> int:
    """How many rows another program reads."""
    return len(pd.read_parquet(folder / data_set))


def written(folder: Path, data_set: str) -> list[Path]:
    """The parts of a data set, the earliest first."""
    return sorted((folder / data_set).glob("controller=*/part-*.parquet"), key=lambda path: path.name)


def told(folder: Path) -> dict[str, tuple[str, int]]:
    """Of every unit with a result its hash and the number of its evaluation, by its reference."""
    table = Results.open(folder).table("units", ["reference", "input_sha256", "tries"])
    return {reference: (sha256, tries) for reference, sha256, tries in zip(*table.to_pydict().values(), strict=True)}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with two units, A and B, whose hashes are a and b."""
    with Results.open(tmp_path / "fleet", for_writing=True) as writing:
        writing.add([unit("A", "a"), unit("B", "b")])
    return tmp_path / "fleet"


def test_what_is_written_is_read_back_by_atleak_and_by_others(tmp_path: Path) -> None:
    made_up = made_up_results(tmp_path / "fleet", units=20)
    assert made_up.controllers() == tuple(sorted(CONTROLLERS))
    assert (len(made_up.done()), len(made_up.failed())) == (20 + ERRORS, ERRORS)
    for data_set in DATA_SETS:
        table = made_up.table(data_set)
        by_others = pd.read_parquet(tmp_path / "fleet" / data_set)
        assert table.schema.names == [*columns_of(data_set).names, "controller"] == list(by_others.columns)
        assert table.num_rows == len(by_others)
    units, lands = made_up.table("units"), made_up.table("lands", ["input_sha256", "controller"])
    assert units.num_rows == 20
    assert set(lands["input_sha256"].to_pylist()) == set(units["input_sha256"].to_pylist())
    assert set(lands["controller"].to_pylist()) == set(CONTROLLERS)


def test_only_the_columns_and_valve_bodies_asked_for_are_read(tmp_path: Path) -> None:
    made_up = made_up_results(tmp_path, units=20)
    one = made_up.table("units", ["controller", "verdict"], controllers=[CONTROLLERS[0]])
    assert one.schema.names == ["controller", "verdict"]
    assert one["controller"].to_pylist() == [CONTROLLERS[0]] * 10
    assert made_up.table("errors", ["kind"], controllers=[]).num_rows == 0
    assert set(made_up.table("errors", ["controller"])["controller"].to_pylist()) == {None, CONTROLLERS[0]}


def test_a_data_set_without_a_row_can_be_read_by_others(folder: Path) -> None:
    by_others = pd.read_parquet(folder / "errors")
    assert len(by_others) == 0
    assert list(by_others.columns) == [*columns_of("errors").names, "controller"]


def test_an_id_of_digits_stays_a_text(tmp_path: Path) -> None:
    with Results.open(tmp_path, for_writing=True) as writing:
        writing.add([unit("A", "a", controller="722"), failed("B", "b"), failed("C", "c", controller="0722")])
    assert Results.open(tmp_path).controllers() == ("722",)
    assert list(pd.read_parquet(tmp_path / "units").controller) == ["722"]
    assert set(pd.read_parquet(tmp_path / "errors").controller) == {"0722", "not-known"}


def test_the_result_of_a_corrected_job_takes_the_place_of_the_earlier_one(folder: Path) -> None:
    with Results.open(folder, for_writing=True) as writing:
        writing.add([unit("A", "a corrected", 2, controller="five_speed_2005")])
        assert writing.done() == {"a corrected", "b"}
        assert told(folder) == {"A": ("a corrected", 2), "B": ("b", 1)}
        assert writing.table("lands").num_rows == 2 * LANDS
        writing.tidy()
    assert (rows_in(folder, "units"), rows_in(folder, "lands")) == (2, 2 * LANDS)
    assert told(folder) == {"A": ("a corrected", 2), "B": ("b", 1)}


def test_an_error_goes_once_the_unit_has_a_result_and_the_other_way_round(folder: Path) -> None:
    with Results.open(folder, for_writing=True) as writing:
        writing.add([failed("C", "c"), failed("A", "a broken", 2, "four_speed_2023")])
        assert (writing.done(), writing.failed()) == ({"a broken", "b", "c"}, {"a broken", "c"})
        writing.add([unit("C", "c", 2)])
        assert (writing.done(), writing.failed()) == ({"a broken", "b", "c"}, {"a broken"})
        writing.tidy()
    assert (rows_in(folder, "units"), rows_in(folder, "errors")) == (2, 1)
    assert told(folder) == {"B": ("b", 1), "C": ("c", 2)}


def test_the_last_of_several_rows_of_a_unit_in_one_batch_counts(tmp_path: Path) -> None:
    with Results.open(tmp_path, for_writing=True) as writing:
        writing.add([unit("A", "a"), failed("A", "a", 2), unit("A", "a", 3), unit("B", "a", 4)])
    assert told(tmp_path) == {"B": ("a", 4)}
    assert rows_in(tmp_path, "errors") == 0


def test_parts_without_their_units_do_not_count_and_go(folder: Path) -> None:
    for path in written(folder, "units"):
        path.unlink()
    unfinished = written(folder, "lands")[0].with_name(".atleak-0123456789abcdef.part")
    unfinished.write_bytes(b"PAR1")
    assert Results.open(folder).table("lands").num_rows == 0
    assert Results.open(folder).done() == set()
    with Results.open(folder, for_writing=True) as writing:
        writing.tidy()
    assert [*written(folder, "lands"), *written(folder, "conditions")] == []
    assert not unfinished.exists()


def test_small_parts_are_merged_and_large_ones_left_alone(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(results, "_SMALL", 4)
    with Results.open(folder, for_writing=True) as writing:
        writing.add([unit(f"C{number}", f"c{number}") for number in range(4)])
        large = written(folder, "units")[-1]
        for number in range(3):
            writing.add([unit(f"D{number}", f"d{number}", controller="722")])
        before = {each: writing.table(each).sort_by("input_sha256") for each in ("units", "lands", "conditions")}
        writing.add([unit("E", "e"), unit("F", "f")])
        writing.tidy()
        assert large in written(folder, "units")
        assert len(written(folder, "units")) == len(written(folder, "lands")) == 3
        writing.add([failed("E", "e"), failed("F", "f")])
        writing.tidy()
        names = [path.name for data_set in DATA_SETS for path in written(folder, data_set)]
        writing.tidy()
    assert [path.name for data_set in DATA_SETS for path in written(folder, data_set)] == names, "nothing to tidy"
    after = Results.open(folder)
    assert {each: after.table(each).sort_by("input_sha256") for each in before} == before


def test_a_later_part_counts_even_where_the_clock_went_back(folder: Path) -> None:
    for path in [path for data_set in DATA_SETS for path in written(folder, data_set)]:
        path.rename(path.with_name("part-29990101T000000.000000Z-00000000.parquet"))
    with Results.open(folder, for_writing=True) as writing:
        writing.add([unit("A", "a corrected", 2)])
    assert told(folder)["A"] == ("a corrected", 2)
    assert written(folder, "units")[-1].name.startswith("part-29990101T000000.000001Z-")


def test_who_reads_while_parts_are_merged_reads_every_row(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with Results.open(folder, for_writing=True) as writing:
        writing.add([unit("C", "c")])
        reading, read_part, tidied = Results.open(folder), parts.read_part, []

        def read_late(where: Path, part: parts.ResultPart, columns: list[str]) -> object:
            if part.data_set == "lands" and not tidied:
                tidied.append(part)
                writing.tidy()
            return read_part(where, part, columns)

        monkeypatch.setattr(results, "read_part", read_late)
        assert reading.table("lands").num_rows == 3 * LANDS
    assert tidied


def test_one_run_writes_at_a_time_and_anybody_reads(folder: Path) -> None:
    with Results.open(folder, for_writing=True), pytest.raises(FleetError) as refused:
        Results.open(folder, for_writing=True)
    expected = "another run is writing its results there; expected another folder, or that run to end first"
    assert str(refused.value) == f"{folder}: {expected}"
    with Results.open(folder, for_writing=True), Results.open(folder) as reading:
        assert reading.table("units").num_rows == 2


def test_results_of_another_version_are_refused_unless_they_are_replaced(folder: Path) -> None:
    run = folder / "run.json"
    run.write_text(json.dumps({**json.loads(run.read_bytes()), "atleak": "0.0.7"}), encoding="utf-8")
    with pytest.raises(FleetError, match=rf"atleak 0\.0\.7, and this is atleak {__version__}; .*--replace"):
        Results.open(folder, for_writing=True)
    assert Results.open(folder).table("units").num_rows == 2, "they can be read"
    with Results.open(folder, for_writing=True, replace=True) as writing:
        assert writing.done() == set()
    assert json.loads(run.read_bytes())["atleak"] == __version__
    assert rows_in(folder, "lands") == 0
    run.write_text(json.dumps({**json.loads(run.read_bytes()), "format": 99}), encoding="utf-8")
    with pytest.raises(FleetError, match="holds results of atleak"):
        Results.open(folder)


@pytest.mark.parametrize("data_set", ["units", "errors"])
def test_what_cannot_be_removed_stops_before_another_version_takes_the_folder(
    folder: Path, monkeypatch: pytest.MonkeyPatch, data_set: str
) -> None:
    with Results.open(folder, for_writing=True) as writing:
        writing.add([failed("C", "c")])
    before, held, unlink = (folder / "run.json").read_bytes(), written(folder, data_set)[-1], Path.unlink
    before = before.replace(__version__.encode(), b"0.0.1")
    (folder / "run.json").write_bytes(before)

    def refusing(self: Path, missing_ok: bool = False) -> None:
        if self == held:  # as Windows does where another program has it open
            raise PermissionError(errno.EACCES, "The process cannot access the file", str(self))
        unlink(self, missing_ok)

    monkeypatch.setattr(Path, "unlink", refusing)
    with pytest.raises(OutputError, match=r"cannot be removed: .*; expected a file that no other") as raised:
        Results.open(folder, for_writing=True, replace=True)
    assert raised.value.place.file == str(held)
    assert (folder / "run.json").read_bytes() == before
    monkeypatch.undo()
    Results.open(folder, for_writing=True, replace=True).close()  # and the folder is free again


@pytest.mark.parametrize("replace", [False, True])
def test_a_folder_that_holds_something_else_is_refused(tmp_path: Path, replace: bool) -> None:
    (tmp_path / "letter.txt").write_text("Dear all", encoding="utf-8")
    with pytest.raises(FleetError, match=r"holds something else: letter\.txt; expected a folder that is new or empty"):
        Results.open(tmp_path, for_writing=True, replace=replace)
    assert [path.name for path in tmp_path.iterdir()] == ["letter.txt"]
    with pytest.raises(FleetError, match="holds no results of a fleet"):
        Results.open(tmp_path)


@pytest.mark.parametrize("content", ["{", "[1]", '{"name": "my application"}'])
def test_another_program_s_run_file_is_refused(tmp_path: Path, content: str) -> None:
    (tmp_path / "run.json").write_text(content, encoding="utf-8")
    for how in ({}, {"for_writing": True}, {"for_writing": True, "replace": True}):
        with pytest.raises(FleetError, match=r"run\.json: is not what a fleet's run wrote"):
            Results.open(tmp_path, **how)
    assert (tmp_path / "run.json").read_text(encoding="utf-8") == content


def test_a_folder_that_cannot_be_made_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_bytes(b"")
    for path in (tmp_path / "file", tmp_path / "file" / "fleet"):
        with pytest.raises(FleetError if path.name == "file" else (FleetError, OutputError), match="file"):
            Results.open(path, for_writing=True)


def test_of_a_batch_for_which_the_disk_has_no_space_nothing_stays(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    writer = pq.ParquetWriter.write_table

    def full(self: pq.ParquetWriter, table: pa.Table, **options: Any) -> None:
        if "tries" in table.schema.names:  # of the units, when the others are written
            raise OSError(errno.ENOSPC, "No space left on device")
        writer(self, table, **options)

    with Results.open(folder, for_writing=True) as writing:
        files = sorted(folder.rglob("*"))
        monkeypatch.setattr(pq.ParquetWriter, "write_table", full)
        with pytest.raises(OutputError, match="No space left on device") as raised:
            writing.add([unit("C", "c")])
        assert raised.value.place.file.startswith(str(folder / "units"))
        assert sorted(folder.rglob("*")) == files
        monkeypatch.undo()
        writing.add([unit("C", "c")])
    assert set(told(folder)) == {"A", "B", "C"}


@pytest.mark.parametrize("damage", ["cut", "turned", "gone"])
@pytest.mark.parametrize("data_set", ["units", "lands"])
def test_a_damaged_part_is_named_and_so_is_the_way_out(folder: Path, data_set: str, damage: str) -> None:
    part, of_units = written(folder, data_set)[0], written(folder, "units")[0]
    content = part.read_bytes()
    if damage == "cut":
        part.write_bytes(content[: len(content) // 2])
    elif damage == "turned":
        part.write_bytes(content[:30] + bytes(each ^ 0xFF for each in content[30:40]) + content[40:])
    else:
        part.unlink()
    if (damage, data_set) == ("gone", "units"):
        assert Results.open(folder).done() == set()  # that is the way out
        return
    with pytest.raises(FleetError) as raised:
        Results.open(folder).table(data_set)  # type: ignore[arg-type]  # one of two texts
    assert raised.value.place.file == str(part)
    assert f"once {of_units} is deleted, the next run evaluates its units anew" in str(raised.value)
    of_units.unlink()
    with Results.open(folder, for_writing=True) as writing:
        writing.tidy()
        assert writing.done() == set()
        writing.add([unit("A", "a", 2)])
    assert told(folder) == {"A": ("a", 2)}


def test_what_an_earlier_version_did_not_write_is_null(folder: Path) -> None:
    part = written(folder, "lands")[0]
    now = pq.read_table(part)
    rule = pa.struct([("rule", pa.string()), ("value", pa.float32())])  # of which today there is more
    earlier = now.select(["input_sha256", "land"]).append_column(
        "rules", pa.array([[{"rule": "wear", "value": 0.5}], None, []] * 2, pa.list_(rule))
    )
    pq.write_table(earlier.append_column("no_longer", pa.nulls(6, pa.string())), part)
    table = Results.open(folder).table("lands")
    assert table.schema.names == [*columns_of("lands").names, "controller"]
    assert table["wear_percent"].null_count == table.num_rows == 2 * LANDS
    rules = table["rules"].to_pylist()
    assert [each if each is None else len(each) for each in rules] == [1, None, 0] * 2
    assert (rules[0][0]["value"], rules[0][0]["decision"]) == (0.5, None)
    assert Results.open(folder).table("lands", ["verdict"])["verdict"].null_count == 2 * LANDS


def test_rows_of_some_units_alone_are_read(folder: Path) -> None:
    with Results.open(folder, for_writing=True) as writing:
        writing.add([unit("C", "c"), unit("A", "a2", 2)])  # A was corrected
    results = Results.open(folder)
    assert sorted(results.table("units", ["reference"], hashes=["a2", "b"])["reference"].to_pylist()) == ["A", "B"]
    lands = results.table("lands", ["spool_readings"], hashes=["a2"])["spool_readings"].to_pylist()
    assert lands == [2] * LANDS
    assert results.table("units", hashes=["a"]).num_rows == 0  # its result counts no more
    assert results.table("lands", hashes=[]).num_rows == 0


def test_the_state_changes_with_the_results_and_with_nothing_else(folder: Path) -> None:
    state = Results.open(folder).state()
    assert Results.open(folder).state() == state
    with Results.open(folder, for_writing=True) as writing:
        assert writing.state() == state
        writing.add([failed("D", "d")])
        with_error = writing.state()
        assert with_error != state
        writing.add([unit("E", "e")])
        assert writing.state() not in (state, with_error)
