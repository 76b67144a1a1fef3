"""A log that is read in pieces is understood, to the last bit, as one that is read whole."""

from __future__ import annotations

import gzip
import tempfile
import threading
import time
import tracemalloc
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from atleak import columns as all_columns
from atleak.errors import RoadTestError
from atleak.intake.road_test import importer, pieces, understand
from atleak.intake.road_test.files import log_file
from atleak.intake.road_test.files.log_file import BESIDE, LARGE, TIMES
from atleak.intake.road_test.outcome import Understood
from atleak.intake.road_test.pieces import (
    columns,
    read_large_log,
    samples,
    spool,
    table,
    text_blocks,
    timelines,
    understand_in_pieces,
)
from atleak.large_log import LargeLog
from tests.unit.intake.road_test.messy_logs import messy_log
from tests.unit.intake.road_test.test_changed_units import BARE, HEAD, IN_PSI, log, rows
from tests.unit.intake.road_test.test_every_row import CLOCK_FORMS, ROWS
from tests.unit.intake.road_test.test_quirks import CASES, REFUSED

NOT_IN_PIECES = {
    *(f"utf-16 {kind}" for kind in ("le with mark", "be with mark", "without mark")), "NUL bytes", "CR only",
    "long format", "long format, Russian", "long format, German", "time column per channel",
    "time column per channel, German", "groups with a clock each",
}  # fmt: skip
SOME = [name for number, name in enumerate(CASES) if number % 6 == 0 and name not in NOT_IN_PIECES]


@pytest.fixture(autouse=True)
def small_pieces() -> Iterator[None]:
    """Blocks of some lines, pieces of some rows."""
    with pytest.MonkeyPatch.context() as patch:
        cut(patch, 700, 23)
        yield


def cut(patch: pytest.MonkeyPatch, block: int, piece: int) -> None:
    patch.setattr(text_blocks, "BLOCK", block)
    for module in (timelines, samples, table, columns, all_columns):
        patch.setattr(module, "PIECE", piece)


def read_both(data: bytes, **choices: Any) -> tuple[Understood | str, Understood | str]:
    """What is understood of a log that is read whole, and of one in pieces; or why it is refused."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "log.bin"
        path.write_bytes(data)
        found: list[Understood | str] = []
        for read in (understand, understand_in_pieces):
            try:
                found.append(read(path, **choices))
            except RoadTestError as error:
                found.append(str(error))
        return found[0], found[1]


def assert_same(whole: Understood | str, pieces: Understood | str) -> Counter[str]:
    """Compare all that is understood; return how often each kind of message is there."""
    if isinstance(whole, str) or isinstance(pieces, str):
        assert pieces == whole
        return Counter({"refused": 1})
    assert [str(each) for each in pieces.messages] == [str(each) for each in whole.messages]
    for name in ("headings", "preview", "signature", "ambiguous", "unused", "time_label", "rows_left_out", "sha256"):
        assert getattr(pieces, name) == getattr(whole, name), name
    assert str(pieces.problem) == str(whole.problem)
    test, large = whole.road_test, pieces.large
    assert (test is None) == (large is None)
    if test is None or large is None:
        return Counter({"problem": 1})
    head = large.head
    for name in ("file", "sha256", "rows", "duration", "refused", "date", "format", "encoding", "delimiter", "decimal"):
        assert getattr(head, name) == getattr(test, name), name
    np.testing.assert_array_equal(large.time[:], test.time)
    assert large.begins.tolist() == [segment.start_row for segment in test.segments]
    assert list(head.channels) == list(test.channels)
    for quantity, channel in test.channels.items():
        np.testing.assert_array_equal(large.values(quantity, 0, len(large)), test.values(quantity), quantity)
        same = ("column", "unit", "unit_assumed", "kind", "source", "independent")
        assert [getattr(head.channels[quantity], name) for name in same] == [getattr(channel, name) for name in same]
        np.testing.assert_allclose(head.channels[quantity].sampling_hz, channel.sampling_hz, rtol=1e-12)
    large.close()
    return Counter(message.code for message in test.messages)


@pytest.mark.parametrize("name", SOME)
def test_a_log_of_any_kind_is_understood_as_the_whole(name: str) -> None:
    assert_same(*read_both(CASES[name].bytes))


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in CASES if name not in {*SOME, *NOT_IN_PIECES}])
def test_every_kind_of_log_is_understood_as_the_whole(name: str) -> None:
    assert_same(*read_both(CASES[name].bytes))


@pytest.mark.parametrize("name", [name for name in REFUSED if name not in ("MDF cut off", "zip bomb in gz")])
def test_what_is_no_log_is_refused_in_the_same_words(name: str) -> None:
    assert_same(*read_both(REFUSED[name][0]))


@pytest.mark.parametrize("name", sorted(NOT_IN_PIECES))
def test_what_is_not_read_in_pieces_is_refused_with_what_to_do(name: str) -> None:
    _, pieces = read_both(CASES[name].bytes)
    told = pieces if isinstance(pieces, str) else str(pieces.problem)
    assert "too large to be held in memory" in told
    assert "expected" in told


def test_logs_with_all_that_goes_wrong_are_understood_as_the_whole() -> None:
    codes = sum((assert_same(*read_both(messy_log(seed, 12.0))) for seed in range(30)), Counter())
    assert {"gaps", "clock_restarted", "stray_stamps", "reordered", "unreadable_stamps", "suspect_samples"} <= {*codes}
    assert {"sample_and_hold", "cells_unreadable", "lines_left_out", "blank_rows", "time_counted"} <= {*codes}


@pytest.mark.parametrize("form", list(CLOCK_FORMS))
def test_a_damaged_stamp_in_a_log_is_left_out_as_in_the_whole(form: str) -> None:
    heading, written = CLOCK_FORMS[form]
    for at, cell in ((0, "1e17"), (0, "99999"), (22, "00:00:00"), (23, "-1"), (ROWS - 1, "1e9"), (ROWS - 1, "0")):
        stamps = [written(row / 2) for row in range(ROWS)]
        stamps[at] = cell
        rows = "".join(f"{stamp};{800 + row};{500 + 3 * row}\n" for row, stamp in enumerate(stamps))
        assert_same(*read_both(f"{heading};RPM (rpm);Line Pressure (kPa)\n{rows}".encode()))
    both = [*map(written, range(40)), *(written(4e7 + row) for row in range(40))]
    rows = "".join(f"{stamp};{800 + row};{500 + 3 * row}\n" for row, stamp in enumerate(both))
    assert_same(*read_both(f"{heading};RPM (rpm);Line Pressure (kPa)\n{rows}".encode()))


@pytest.mark.slow
@settings(max_examples=50)
@given(st.integers(0, 1_000_000), st.integers(150, 5000), st.integers(2, 300), st.floats(3.0, 60.0))
def test_any_messy_log_is_understood_as_the_whole(seed: int, block: int, piece: int, seconds: float) -> None:
    with pytest.MonkeyPatch.context() as patch:
        cut(patch, block, piece)
        assert_same(*read_both(messy_log(seed, seconds)))


def test_choices_and_constants_count_as_for_the_whole() -> None:
    data = CASES["utf-8 with mark"].bytes
    choices = {
        "mapping": {"output_speed": "Engine Speed"}, "units": {"vehicle_speed": "mph"},
        "constants": {"main_pressure": 800e3},
    }  # fmt: skip
    whole, pieces = read_both(data, **choices)
    assert isinstance(whole, Understood)
    assert whole.road_test is not None
    assert "main_pressure" in whole.road_test.channels
    assert_same(whole, pieces)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ("Time (s),Speed (km/h),RPM\n", "another header with other columns begins in the middle of the log"),
        ("s,1/s,mph\n", "the unit changes from"),
        ("Time (s),RPM (rpm),Speed (mph)\n", "the unit changes from km/h to mph in the middle of the log"),
    ],
)
def test_what_changes_on_the_way_is_refused_and_where(tmp_path: Path, change: str, words: str) -> None:
    rows = [f"{row / 10:.1f},{800 + row},{row % 50}\n" for row in range(300)]
    path = tmp_path / "log.csv"
    path.write_text("Time (s),RPM (rpm),Speed (km/h)\n" + "".join([*rows[:250], change, *rows[250:]]), encoding="utf-8")
    refusals = []
    for read in (understand, understand_in_pieces):
        problem = read(path).problem
        assert problem is not None
        refusals.append(str(problem))
    assert words in refusals[0]
    assert "data row 251" in refusals[0]
    assert refusals[0] == refusals[1]


_BLANK = [f"{i / 10:.1f},{800 + i},80,,2" for i in range(30)]
_NO_CLOCK, _MS = HEAD.replace(" [s]", ""), [f"{i * 100},{800 + i},80,700,2" for i in range(30, 60)]
_IN_BAR = HEAD.replace("kPa", "bar")  # which 700 cannot be
_BETWEEN = ["", ",,,,", "# a remark", ",,,,", "Lap 2,,,,"]


@pytest.mark.parametrize("between", [[], _BETWEEN], ids=["", "with lines that are no rows"])
@pytest.mark.parametrize(
    ("head", "before", "again", "after", "asked"),
    [
        (BARE, rows(), HEAD.replace("kPa", "psi"), IN_PSI, True),
        (BARE, rows(), "s,rpm,°C,psi,", IN_PSI, True),
        (BARE, rows(), HEAD, rows(30), False),
        (HEAD, rows(), BARE, IN_PSI, True),
        (HEAD, rows(), BARE, rows(30), False),
        (BARE, _BLANK, HEAD.replace("kPa", "psi"), IN_PSI, False),
        (BARE, _BLANK, _IN_BAR, rows(30), False),  # one number before the line, and it would be asked
        (_IN_BAR, rows(), BARE, _BLANK, False),  # likewise one behind it
        (_NO_CLOCK, rows(), _NO_CLOCK.replace("Time", "Time [ms]"), _MS, True),
        (_NO_CLOCK, rows(), HEAD, rows(30), False),
    ],
)
def test_a_unit_that_is_stated_again_is_asked_about_as_of_the_whole(
    head: str, before: list[str], again: str, after: list[str], asked: bool, between: list[str]
) -> None:
    data = log(head, before, between, again, after)
    found = assert_same(*read_both(data))
    assert ("problem" in found) == asked
    assert_same(*read_both(data, units={"main_pressure": "psi"}))


def test_rows_with_another_separator_are_left_out_and_counted() -> None:
    rows = [f"{row / 10:.1f},{800 + row},{row % 50}" for row in range(300)]
    rows[200:210] = [row.replace(",", ";") for row in rows[200:210]]
    data = ("Time (s),RPM (rpm),Speed (km/h)\n" + "\n".join(rows) + "\n").encode()
    whole, pieces = read_both(data)
    assert isinstance(pieces, Understood)
    assert (pieces.rows_left_out, pieces.rows) == (10, 290)
    assert_same(whole, pieces)


@pytest.mark.parametrize("cut_off", [1, 2])
def test_the_head_may_end_within_a_character(monkeypatch: pytest.MonkeyPatch, cut_off: int) -> None:
    cut(monkeypatch, 100_000, 20_000)
    head = "Time (s),RPM (rpm),ATF-Öltemperatur (°C),Note\n".encode()
    rows = "".join(f"{row / 10:.1f},{800 + row % 900},80,\n" for row in range(20_000)).encode()[: LARGE - len(head)]
    until = head + rows[: rows.rfind(b"\n", 0, -30) + 1]
    filler = b"5000.0,900,80," + b"x" * 40
    data = until + filler[: LARGE - cut_off - len(until)] + "€\n".encode() + b"5000.1,900,80,\n"
    assert data[:LARGE].decode("utf-8", "replace").endswith("\ufffd")
    whole, pieces = read_both(data)
    assert isinstance(pieces, Understood)
    assert [each.label for each in pieces.headings][2] == "ATF-Öltemperatur (°C)"
    assert_same(whole, pieces)


def test_too_many_rows_that_are_too_wide_are_refused_alone() -> None:
    rows = [f"{row / 10:.1f};{800 + row};{80 + row % 5};" for row in range(200)]
    rows = [row if index % 3 else row.replace(".", ";", 1) + "1" for index, row in enumerate(rows)]
    whole, pieces = read_both(("Time (s);RPM (rpm);ATF Temp (C);Note\n" + "\n".join(rows) + "\n").encode())
    assert isinstance(pieces, Understood)
    assert "more numbers than it has columns" in str(pieces.problem)
    assert_same(whole, pieces)


@pytest.mark.parametrize("rows", [300, 40_000])
def test_a_packed_log_is_read_from_where_it_is_unpacked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, rows: int
) -> None:
    cut(monkeypatch, 100_000, 20_000)
    path = tmp_path / "log.csv.gz"
    lines = [f"{row / 10:.1f},{800 + row % 900}\n" for row in range(rows)]
    path.write_bytes(gzip.compress("".join(["Time (s),RPM\n", *lines]).encode()))
    log = read_large_log(path)
    assert log.head.rows == len(log) == rows
    log.close()


def test_nothing_is_left_on_the_disk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    path = tmp_path / "log.csv"
    path.write_bytes(CASES["utf-8 with mark"].bytes)
    with pytest.raises(RoadTestError):
        read_large_log(path, mapping={"gear": "no such column"})
    assert [each.name for each in tmp_path.iterdir()] == ["log.csv"]
    log = read_large_log(path)
    assert len(list(tmp_path.iterdir())) == 2
    log.close()
    assert [each.name for each in tmp_path.iterdir()] == ["log.csv"]


def test_a_disk_without_room_is_named_before_anything_is_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "log.csv"
    path.write_bytes(CASES["utf-8 with mark"].bytes)
    monkeypatch.setattr(spool.shutil, "disk_usage", lambda folder: type("Usage", (), {"free": 100})())
    with pytest.raises(RoadTestError, match=r"is read in pieces, for which .* needs 0\.0 GB and has 0\.0"):
        read_large_log(path)


def room_asked_and_taken(data: bytes) -> tuple[float, int]:
    """How many bytes are asked for before a log is read, and how many its columns take at most while it is."""
    taken, asked, put = [0], list[float](), all_columns.DiskColumn._put

    def measured(column: all_columns.DiskColumn, *given: Any) -> None:
        put(column, *given)
        taken.append(sum(each.stat().st_size for each in column.path.parent.glob("*.column")))

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(all_columns.DiskColumn, "_put", measured)
        patch.setattr(spool.Spool, "check_room", lambda _, numbers: asked.append(numbers * 8))
        _, pieces = read_both(data)
    assert isinstance(pieces, Understood)
    assert pieces.large is not None
    pieces.large.close()
    return asked[0], max(taken)


@pytest.mark.parametrize("channels", [1, 3])
@pytest.mark.parametrize("kind", ["plain", "clock strings", "restarted clock"])
def test_as_much_room_is_asked_for_as_is_taken(channels: int, kind: str) -> None:
    lines = [",".join(["Time", "RPM (rpm)", "Speed (km/h)", "ATF (°C)"][: channels + 1])]
    for row in range(400):
        second = (row - 200 * (kind == "restarted clock" and row > 250)) / 10
        time = f"10:00:{second:06.3f}" if kind == "clock strings" else f"{second:.1f}"
        lines.append(",".join([time, str(800 + row), str(row % 50), "80"][: channels + 1]))
    asked, taken = room_asked_and_taken(("\n".join(lines) + "\n").encode())
    assert taken <= asked <= 2.5 * taken


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="there is no disk here that is always full")
def test_a_disk_that_is_full_is_told_as_such(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "log.csv"
    path.write_bytes(CASES["utf-8 with mark"].bytes)
    new = spool.Spool.column

    def full(own: spool.Spool, dtype: Any = np.float64) -> all_columns.DiskColumn:
        column = new(own, dtype)
        column.path.unlink()
        column.path.symlink_to("/dev/full")
        return column

    monkeypatch.setattr(spool.Spool, "column", full)
    with pytest.raises(RoadTestError, match=r"has no room left for the samples .* another folder .* \(TMPDIR"):
        read_large_log(path)


def test_a_refused_log_is_open_no_more(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    begun = list[threading.Thread]()

    def slowly(_: Path) -> Iterator[memoryview]:
        begun.append(threading.current_thread())
        for _ in range(100):
            time.sleep(0.01)
            yield memoryview(b"10:00")

    monkeypatch.setattr(log_file, "pieces_of", slowly)
    path = tmp_path / "log.csv"
    path.write_bytes(("Time (s);RPM\n" + "1;800\n" * LARGE).encode("utf-16"))
    with pytest.raises(RoadTestError, match="is not read in pieces"):
        read_large_log(path)
    assert [each.is_alive() for each in begun] == [False]


def test_rows_out_of_turn_by_the_million_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(timelines, "_FALLS", 10)
    path = tmp_path / "log.csv"
    stamps = [row + (3 if row % 5 == 0 else 0) for row in range(300)]
    path.write_text("Time (s),RPM\n" + "".join(f"{stamp},{800 + stamp}\n" for stamp in stamps), encoding="utf-8")
    with pytest.raises(RoadTestError, match="out of turn"):
        read_large_log(path)


def test_a_large_log_gives_parts_like_any_road_test(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_bytes(CASES["utf-8 with mark"].bytes)
    log: LargeLog = read_large_log(path)
    part = log.part(10, 20)
    assert (part.rows, len(part.time), part.in_pieces) == (10, 10, True)
    np.testing.assert_array_equal(part.values("engine_speed"), log.values("engine_speed", 10, 20))
    assert (log.back(20, 0.25), log.onward(20, 0.25)) == (18, 23)
    log.close()


def test_a_log_that_the_memory_does_not_hold_is_refused_and_where_it_can_be_read_is_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "log.csv"
    path.write_bytes(CASES["utf-8 with mark"].bytes)
    size = path.stat().st_size
    monkeypatch.setattr(importer, "of_machine", lambda: TIMES * size + BESIDE)
    assert understand(path).road_test is not None
    monkeypatch.setattr(importer, "of_machine", lambda: TIMES * (size - 1) + BESIDE)
    with pytest.raises(RoadTestError, match=r"log\.csv: takes up to 0\.2 GB of memory.*atleak fleet run reads large"):
        understand(path)
    read_large_log(path).close()


def test_a_log_for_which_the_memory_does_not_suffice_says_where_it_can_be_read(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def short(*given: Any, **options: Any) -> None:
        raise MemoryError

    monkeypatch.setattr(importer, "read_table", short)
    with pytest.raises(
        RoadTestError, match=r"is too large for the memory of this computer.*atleak fleet run"
    ) as caught:
        understand(CASES["utf-8 with mark"].bytes)
    assert isinstance(caught.value.__cause__, MemoryError)


def test_what_is_held_of_samples_that_are_looked_through_does_not_grow_with_the_log(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    cut(monkeypatch, 100_000, 2_000)
    path, most, large_channels = tmp_path / "log.csv", [], pieces.large_channels

    def traced(*given: Any) -> Any:
        tracemalloc.start()
        made = large_channels(*given)
        most.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
        return made

    monkeypatch.setattr(pieces, "large_channels", traced)
    for count in (30_000, 80_000):  # more than are looked at in the middle
        lines = (f"{row / 100:.2f},{60 + row // 100 % 7}\n" for row in range(count))
        path.write_text("Time (s),ATF Temp (C)\n" + "".join(lines), encoding="utf-8")
        read_large_log(path).close()
    assert most[1] - most[0] < 50_000 * 8 / 4, "a quarter of one column"
