"""A large log: read block by block it is the log read at once, one row in some is that row, too large is refused."""

from __future__ import annotations

import io
import re
import tracemalloc
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.csv
import pyarrow.parquet as pq
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from atleak.common.errors import InputError, RoadTestError
from atleak.readers.logs import columns as assign
from atleak.readers.logs import delimited, importer, read_road_test, understand
from atleak.readers.logs import mdf_log as mdf
from atleak.readers.logs.columns import BESIDE
from atleak.readers.logs.delimited import Filled
from atleak.readers.logs.understood import Understood
from tests.unit.readers.logs.messy_logs import messy_log
from tests.unit.readers.logs.test_changed_units import BARE, HEAD, IN_PSI, log, rows
from tests.unit.readers.logs.test_every_row import CLOCK_FORMS, ROWS
from tests.unit.readers.logs.test_quirks import CASES, REFUSED

SOME = [name for number, name in enumerate(CASES) if number % 6 == 0]


def in_blocks(patch: pytest.MonkeyPatch, block: int = 700) -> None:
    """Let even the logs of tests have several blocks."""
    patch.setattr(delimited, "BLOCK", block)
    patch.setattr(mdf, "RANGE", 41)


def both(data: bytes, block: int = 700, **choices: Any) -> tuple[Understood | str, Understood | str]:
    """What is understood of a log that is read at once, and of one in blocks; or why it is refused."""
    found: list[Understood | str] = []
    for blocks in (False, True):
        with pytest.MonkeyPatch.context() as patch:
            if blocks:
                in_blocks(patch, block)
            try:
                found.append(understand(data, **choices))
            except RoadTestError as error:
                found.append(str(error))
    return found[0], found[1]


def assert_same(whole: Understood | str, blocks: Understood | str) -> Counter[str]:
    """Compare all that is understood; return how often each kind of message is there."""
    if isinstance(whole, str) or isinstance(blocks, str):
        assert blocks == whole
        return Counter({"refused": 1})
    assert [str(each) for each in blocks.messages] == [str(each) for each in whole.messages]
    for name in ("headings", "preview", "signature", "ambiguous", "unused", "time_label", "rows_left_out", "sha256"):
        assert getattr(blocks, name) == getattr(whole, name), name
    assert str(blocks.problem) == str(whole.problem)
    one, other = whole.road_test, blocks.road_test
    if one is None or other is None:
        assert one is other
        return Counter({"problem": 1})
    for name in ("rows", "duration", "refused", "date", "format", "delimiter", "decimal", "segments"):
        assert getattr(other, name) == getattr(one, name), name
    np.testing.assert_array_equal(other.time, one.time)
    assert list(other.channels) == list(one.channels)
    for quantity, channel in one.channels.items():
        found = other.channels[quantity]
        for name in ("time", "values", "suspect"):
            np.testing.assert_array_equal(getattr(found, name), getattr(channel, name), quantity)
        for name in ("column", "unit", "unit_assumed", "kind", "source", "independent"):
            assert getattr(found, name) == getattr(channel, name), name
    return Counter(message.code for message in one.messages)


@pytest.mark.parametrize("name", SOME)
def test_a_log_of_any_kind_is_understood_as_at_once(name: str) -> None:
    assert_same(*both(CASES[name].bytes))


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in CASES if name not in SOME])
def test_every_kind_of_log_is_understood_as_at_once(name: str) -> None:
    assert_same(*both(CASES[name].bytes))


@pytest.mark.parametrize("name", [name for name in REFUSED if name not in ("MDF cut off", "zip bomb in gz")])
def test_what_is_no_log_is_refused_in_the_same_words(name: str) -> None:
    assert_same(*both(REFUSED[name][0]))


def test_logs_with_all_that_goes_wrong_are_understood_as_at_once() -> None:
    codes = sum((assert_same(*both(messy_log(seed, 12.0))) for seed in range(20)), Counter())
    assert {"gaps", "clock_restarted", "stray_stamps", "reordered", "unreadable_stamps", "suspect_samples"} <= {*codes}
    assert {"sample_and_hold", "cells_unreadable", "lines_left_out", "blank_rows", "time_counted"} <= {*codes}


@pytest.mark.slow
@settings(max_examples=50)
@given(st.integers(0, 1_000_000), st.integers(150, 5000), st.floats(3.0, 60.0))
def test_any_messy_log_is_understood_as_at_once(seed: int, block: int, seconds: float) -> None:
    assert_same(*both(messy_log(seed, seconds), block))


@pytest.mark.parametrize("form", list(CLOCK_FORMS))
def test_a_damaged_stamp_is_left_out_in_blocks_too(form: str) -> None:
    heading, written = CLOCK_FORMS[form]
    for at, cell in ((0, "1e17"), (22, "00:00:00"), (ROWS - 1, "0")):
        stamps = [written(row / 2) for row in range(ROWS)]
        stamps[at] = cell
        lines = "".join(f"{stamp};{800 + row};{500 + 3 * row}\n" for row, stamp in enumerate(stamps))
        assert_same(*both(f"{heading};RPM (rpm);Line Pressure (kPa)\n{lines}".encode()))


@pytest.mark.parametrize(
    ("head", "again", "after"),
    [(BARE, HEAD.replace("kPa", "psi"), IN_PSI), (BARE, "s,rpm,°C,psi,", IN_PSI), (HEAD, BARE, rows(30))],
)
def test_a_unit_that_is_stated_again_is_met_in_blocks_too(head: str, again: str, after: list[str]) -> None:
    assert_same(*both(log(head, rows(), [], again, after)))


def words_from(row: int) -> str:
    """A log in which gears are words from a row on, and blank between two others."""
    gears = ["" if 100 <= each < 200 else "PRND"[each % 4] if each >= row else str(1 + each % 4) for each in range(400)]
    lines = (f"{each / 10:.1f},{800 + each % 900},{gear}\n" for each, gear in enumerate(gears))
    return "Time (s),RPM (rpm),Gear\n" + "".join(lines)


@pytest.mark.parametrize("row", [0, 50, 250, 400])
def test_a_column_of_words_in_some_blocks_and_numbers_in_others_is_one_column(row: int) -> None:
    assert_same(*both(words_from(row).encode()))


def test_text_is_read_as_text_after_blocks_of_blank_cells() -> None:
    lines = ["Time (s),RPM (rpm),Selector"] + [f"{row / 10:.1f},{800 + row}," for row in range(300)]
    lines += [f"{row / 10:.1f},{800 + row},{'PRND'[row % 4]}" for row in range(300, 400)]
    assert_same(*both("\n".join(lines).encode()))


def test_too_many_rows_that_are_too_wide_are_refused_as_of_the_whole() -> None:
    lines = [f"{row / 10:.1f};{800 + row};{80 + row % 5};" for row in range(200)]
    lines = [line if index % 3 else line.replace(".", ";", 1) + "1" for index, line in enumerate(lines)]
    whole, blocks = both(("Time (s);RPM (rpm);ATF Temp (C);Note\n" + "\n".join(lines) + "\n").encode())
    assert isinstance(blocks, Understood)
    assert "more numbers than it has columns" in str(blocks.problem)
    assert_same(whole, blocks)


# --- memory


@pytest.fixture
def none_small(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let even the logs of tests count as large."""
    monkeypatch.setattr(assign, "SMALL", 1)


COUNT = 200_000


def numbers_of(count: int) -> pa.Table:
    row = np.arange(count)
    known = {"Time (s)": row / 100, "RPM (rpm)": 800.0 + row % 900, "ATF Temp (C)": 60.0 + row % 7}
    return pa.table(known | {f"Sensor {number} (V)": row % 5 / 10 for number in range(10)})


def written(table: pa.Table, path: Path) -> Path:
    if path.suffix == ".csv":
        pyarrow.csv.write_csv(table, path, pyarrow.csv.WriteOptions(quoting_style="needed"))
    else:
        pq.write_table(table, path)
    return path


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_little_is_held_beside_the_channels_that_are_known(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, suffix: str
) -> None:
    in_blocks(monkeypatch, 200_000)
    path = written(numbers_of(COUNT), tmp_path / f"log{suffix}")
    read_road_test(written(numbers_of(100), tmp_path / f"small{suffix}"))  # what is imported and kept once
    tracemalloc.start()
    test = read_road_test(path)
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert test.rows == COUNT
    assert most < 2.5 * (3 * 8 * COUNT) + 10e6  # thirteen columns alone would be 20.8 MB, pandas' text of one 10 MB


@pytest.mark.usefixtures("none_small")
@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_a_log_that_would_not_fit_is_refused_before_it_is_read_and_what_fits_is_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, suffix: str
) -> None:
    path = written(numbers_of(20_000), tmp_path / f"log{suffix}")
    monkeypatch.setattr(importer, "free_memory", lambda: BESIDE + 1_000_000)
    problem = understand(path).problem
    said = r"would take 0\.2 GB of memory with its evaluation, and 0\.2 GB are free; expected part of the drive, or one"
    found = re.search(said + r" row in (\d+): --every \1$", str(problem))
    assert found is not None
    every = int(found[1])
    assert every == 3  # 20 000 rows of three numbers, six times
    assert understand(path, every=every).road_test is not None
    monkeypatch.setattr(importer, "free_memory", lambda: 1 << 40)
    assert understand(path).road_test is not None
    assert "would take" in str(understand(path, memory=BESIDE + 1_000_000).problem)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16"])
def test_a_small_log_is_read_however_little_memory_is_free(monkeypatch: pytest.MonkeyPatch, encoding: str) -> None:
    monkeypatch.setattr(importer, "free_memory", lambda: 100 << 20)
    data = "Time (s),RPM (rpm)\n" + "".join(f"{row / 10},{800 + row}\n" for row in range(300))
    assert read_road_test(data.encode(encoding)).rows == 300


@pytest.mark.usefixtures("none_small")
def test_what_a_process_may_take_counts_whatever_is_free_at_the_moment(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(importer, "free_memory", lambda: 0)
    data = forms(numbers_of(100))["text"]
    assert "would take" in str(understand(data).problem)
    assert understand(data, memory=BESIDE + 1_000_000).problem is None


@pytest.mark.usefixtures("none_small")
def test_a_text_that_is_held_to_be_read_is_refused_where_the_memory_does_not_suffice(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    in_blocks(monkeypatch)
    monkeypatch.setattr(importer, "free_memory", lambda: BESIDE)
    with pytest.raises(RoadTestError, match=r"takes up to 0\.2 GB .* read whole.*UTF-8 or a code page"):
        understand(words_from(0).encode("utf-16"))


def test_a_log_for_which_the_memory_does_not_suffice_after_all_says_what_to_do(monkeypatch: pytest.MonkeyPatch) -> None:
    def short(*given: Any, **options: Any) -> None:
        raise MemoryError

    monkeypatch.setattr(importer, "read_table", short)
    with pytest.raises(RoadTestError, match=r"too large for the memory of this computer.*part of the drive$") as caught:
        understand(CASES["utf-8 with mark"].bytes)
    assert isinstance(caught.value.__cause__, MemoryError)


# --- one row in some


def forms(table: pa.Table) -> dict[str, bytes]:
    text, parquet, workbook = io.BytesIO(), io.BytesIO(), io.BytesIO()
    pyarrow.csv.write_csv(table, text, pyarrow.csv.WriteOptions(quoting_style="needed"))
    pq.write_table(table, parquet, row_group_size=130)
    table.to_pandas().to_excel(workbook, index=False)
    return {"text": text.getvalue(), "Parquet": parquet.getvalue(), "workbook": workbook.getvalue()}


@pytest.mark.parametrize("every", [2, 7])
@pytest.mark.parametrize("form", ["text", "text in blocks", "Parquet", "workbook"])
def test_of_some_rows_one_is_read_and_that_is_said(monkeypatch: pytest.MonkeyPatch, form: str, every: int) -> None:
    if form == "text in blocks":
        in_blocks(monkeypatch)
    data = forms(numbers_of(1000))[form.removesuffix(" in blocks")]
    whole, some = read_road_test(data), read_road_test(data, every=every)
    assert some.rows == -(-1000 // every)
    np.testing.assert_array_equal(some.time, whole.time[::every])
    for name in some.channels:
        np.testing.assert_array_equal(some.values(name), whole.values(name)[::every])
    assert [each.text for each in some.messages if each.code == "thinned"] == [
        f"only one row in {every} of the log is read"
    ]
    assert "thinned" not in {each.code for each in whole.messages}


def test_an_interval_is_that_between_the_rows_of_the_file() -> None:
    data = b"RPM (rpm),ATF Temp (C)\n" + b"".join(b"%d,80\n" % (800 + row) for row in range(100))
    test = read_road_test(data, constants={"time": 0.1}, every=4)
    np.testing.assert_allclose(test.time, np.arange(25) * 0.4, rtol=1e-12)


@pytest.mark.parametrize("blocks", [False, True])
def test_remarks_and_headers_among_the_rows_are_met_though_they_are_no_row_that_is_read(
    monkeypatch: pytest.MonkeyPatch, blocks: bool
) -> None:
    if blocks:
        in_blocks(monkeypatch)
    lines = [f"{row / 10:.1f},{800 + row},{row % 50}" for row in range(300)]
    lines[101:101] = ["Lap 2,,", "# stop,,"]
    text = "\n".join(["Time (s),RPM (rpm),Speed (km/h)", *lines])
    some = understand(text.encode(), every=10)
    assert some.rows == 31  # of 302 lines
    assert some.rows_left_out == 2
    lines[203:203] = ["Time (s),RPM (rpm),Speed (mph)"]
    text = "\n".join(["Time (s),RPM (rpm),Speed (km/h)", *lines])
    some, whole = (understand(text.encode(), every=every).problem for every in (10, 1))
    assert "the unit changes from km/h to mph" in str(some)
    assert "at data row 204" in str(some)
    assert str(some) == str(whole)


@pytest.mark.parametrize("blocks", [False, True])
def test_a_unit_stated_later_is_asked_about_with_its_row(monkeypatch: pytest.MonkeyPatch, blocks: bool) -> None:
    if blocks:
        in_blocks(monkeypatch)
    lines = [f"{row / 10:.1f},{800 + row},{60 + row / 10}" for row in range(300)]
    lines[203:203] = ["Time (s),RPM (rpm),ATF Temp (°C)"]
    text = "\n".join(["Time (s),RPM (rpm),ATF Temp", *lines])
    some, whole = (str(understand(text.encode(), every=every).problem) for every in (10, 1))
    assert some == whole
    assert "from data row 204 on" in some


@pytest.mark.parametrize("blocks", [False, True])
def test_a_stated_interval_does_not_count_the_remarks_among_the_rows(
    monkeypatch: pytest.MonkeyPatch, blocks: bool
) -> None:
    if blocks:
        in_blocks(monkeypatch)
    lines = [f"{800 + row},{row % 50}" for row in range(300)]
    lines[101:101] = ["Lap 2,", "# stop,"]
    test = read_road_test("\n".join(["RPM (rpm),Speed (km/h)", *lines]).encode(), constants={"time": 0.1}, every=10)
    rows_read = test.values("engine_speed") * 60.0 - 800.0
    np.testing.assert_allclose(test.time - test.time[0], (rows_read - rows_read[0]) * 0.1, rtol=0, atol=1e-9)
    assert len(test.time) == 31


def test_of_a_table_with_one_signal_below_the_other_each_signal_keeps_one_sample_in_some() -> None:
    lines = ["time,name,value"]
    for row in range(100):
        lines += [f"{row / 10},Engine speed [rpm],{800 + row}", f"{row / 10},ATF temperature [°C],{60 + row / 10}"]
    test = read_road_test("\n".join(lines).encode(), every=4)
    for name in ("engine_speed", "atf_temperature"):
        np.testing.assert_allclose(test.channels[name].time, np.arange(25) * 0.4, rtol=1e-12)


@pytest.mark.parametrize("every", [0, -1])
def test_of_no_rows_none_is_read(every: int) -> None:
    with pytest.raises(RoadTestError, match="a whole number above 0"):
        understand(words_from(0).encode(), every=every)


# --- MDF


def mdf_of(groups: list[list[Any]]) -> bytes:
    asammdf = pytest.importorskip("asammdf", reason="the extra mdf is not installed")
    with asammdf.MDF(version="4.10") as file:
        for signals in groups:
            file.append(signals)
        stream = io.BytesIO()
        file.save(stream, compression=2)
        return stream.getvalue()


TIME = np.arange(500) / 10


def signal(values: np.ndarray, label: str, unit: str, time: np.ndarray = TIME, invalid: slice | None = None) -> Any:
    asammdf = pytest.importorskip("asammdf", reason="the extra mdf is not installed")
    bits = None
    if invalid is not None:
        bits = np.zeros(len(values), bool)
        bits[invalid] = True
    return asammdf.Signal(values, time, name=label, unit=unit, invalidation_bits=bits)


def mixed_mdf(invalid: slice) -> bytes:
    """Two groups: one with a channel of which some samples are not valid, one five times as slow."""
    oil = np.full(500, 80.0)
    oil[invalid] = 20.0
    load = signal(np.where(np.arange(500) < 250, 100.0, 400.0), "Line Pressure", "kPa")
    of_rows = [
        signal(900.0 + np.arange(500), "Engine Speed", "rpm"),
        signal(oil, "ATF Temperature", "°C", TIME, invalid),
    ]
    slow = [signal(TIME[::5], "Vehicle Speed", "km/h", TIME[::5])]
    return mdf_of([[*of_rows, signal(TIME, "Throttle", "%"), load], slow])


@pytest.mark.parametrize("invalid", [slice(100, 300), slice(0, 60), slice(0, 0), slice(410, 500, 3)])
def test_the_channels_of_an_mdf_file_are_those_of_its_ranges(invalid: slice) -> None:
    data = mixed_mdf(invalid)
    whole, ranges = both(data)
    assert_same(whole, ranges)
    assert isinstance(whole, Understood)
    test = whole.road_test
    assert test is not None
    oil = test.channels["atf_temperature"]
    valid = np.ones(500, bool)
    valid[invalid] = False
    np.testing.assert_array_equal(oil.time, TIME[valid])
    assert set(oil.values) == {80.0}
    np.testing.assert_allclose(test.values("engine_speed") * 60.0, 900.0 + np.arange(500), rtol=1e-12)
    np.testing.assert_array_equal(test.channels["vehicle_speed"].time, TIME[::5])
    assert test.channels["main_pressure"].time is test.channels["engine_speed"].time is test.time


@pytest.mark.parametrize("every", [3, 50])
def test_of_the_samples_of_an_mdf_file_one_in_some_is_kept(monkeypatch: pytest.MonkeyPatch, every: int) -> None:
    in_blocks(monkeypatch)
    data = mixed_mdf(slice(100, 300))
    whole, some = read_road_test(data), read_road_test(data, every=every)
    for name, channel in some.channels.items():
        for what in ("time", "values"):
            np.testing.assert_array_equal(getattr(channel, what), getattr(whole.channels[name], what)[::every])


@pytest.mark.parametrize("every", [1, 7])
@pytest.mark.parametrize("blocks", [False, True])
def test_of_an_mdf_file_that_was_cut_off_there_are_the_samples_that_it_holds(
    monkeypatch: pytest.MonkeyPatch, blocks: bool, every: int
) -> None:
    if blocks:
        in_blocks(monkeypatch)
    whole = mixed_mdf(slice(100, 300))
    cut, of_stated = bytearray(whole), whole.index((500).to_bytes(8, "little"), whole.index(b"##CG"))
    cut[of_stated : of_stated + 8] = (700).to_bytes(8, "little")
    one, other = read_road_test(whole, every=every), read_road_test(bytes(cut), every=every)
    assert one.rows == other.rows == -(-500 // every)
    for name, channel in one.channels.items():
        for what in ("time", "values"):
            np.testing.assert_array_equal(getattr(other.channels[name], what), getattr(channel, what))


@pytest.mark.parametrize("every", [1, 3])
def test_of_numbers_that_come_part_by_part_those_that_came_are_given_out_and_no_more_are_taken(every: int) -> None:
    filled = Filled(10, every)
    for part in (np.arange(4.0), np.arange(4.0, 7.0)):
        filled.add(part)
    assert filled.numbers.tolist() == np.arange(7.0)[::every].tolist()
    with pytest.raises(InputError, match="holds more samples than it states"):
        filled.add(np.arange(7.0))


def test_a_channel_without_a_valid_sample_is_none(monkeypatch: pytest.MonkeyPatch) -> None:
    speed = signal(900.0 + np.arange(500), "Engine Speed", "rpm")
    test = read_road_test(mdf_of([[speed, signal(np.zeros(500), "ATF Temperature", "°C", TIME, slice(None))]]))
    assert list(test.channels) == ["engine_speed"]


@pytest.mark.usefixtures("none_small")
def test_an_mdf_file_that_would_not_fit_is_refused_with_what_fits(monkeypatch: pytest.MonkeyPatch) -> None:
    data = mixed_mdf(slice(0, 0))
    monkeypatch.setattr(importer, "free_memory", lambda: BESIDE + 10_000)
    with pytest.raises(RoadTestError, match=r"would take 0\.2 GB of memory .*--every \d+"):
        understand(data)


def test_a_frame_that_is_thinned_keeps_its_words_in_their_rows() -> None:
    frame = pd.DataFrame({0: [0.0, np.nan, 2.0, 3.0, 4.0], 1: [1.0, np.nan, np.nan, 4.0, 5.0]})
    frame.attrs["words"] = {0: pd.Series(["Lap 2"], [1]), 1: pd.Series(["x", "y"], [1, 2])}
    thinned = delimited.every_nth(frame, 2)
    assert thinned[0].tolist()[2:] == [2.0, 4.0]
    assert thinned.attrs["lines"].tolist() == [0, 1, 2, 4]
    assert delimited.every_nth(frame, 2, 3).attrs["lines"].tolist() == [4, 6]
    words = {index: cells.to_dict() for index, cells in thinned.attrs["words"].items()}
    assert words == {0: {1: "Lap 2"}, 1: {1: "x", 2: "y"}}


@pytest.mark.parametrize("form", ["csv", "parquet"])
def test_rows_are_counted_while_they_are_read_and_whoever_is_told_may_end_that(
    form: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    in_blocks(monkeypatch)
    table, target, counted = (
        pa.table({"time [s]": np.arange(400) / 10.0, "p_g [kPa]": np.full(400, 500.0)}),
        io.BytesIO(),
        [],
    )
    (pq.write_table if form == "parquet" else pyarrow.csv.write_csv)(table, target)
    understand(target.getvalue(), tell=counted.append)
    assert counted == sorted(counted)
    assert counted[-1] == 400
    assert form == "parquet" or len(counted) == 5

    def enough(rows: int) -> None:
        raise InterruptedReading

    with pytest.raises(InterruptedReading):
        understand(target.getvalue(), tell=enough)


class InterruptedReading(Exception):
    """Raised by who is told."""
