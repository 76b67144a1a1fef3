"""Every row of a log's file is read, or left out with a reason and a count, or the file is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from atleak.common.errors import RoadTestError
from atleak.readers.logs import read_road_test, understand

HEAD = "Time (s);RPM (rpm);ATF Temp (C);Note"


def lines(count: int = 200) -> list[str]:
    return [f"{i / 10:.1f};{800 + i};{80 + i % 5};" for i in range(count)]


def log(rows: list[str], end: str = "\n") -> bytes:
    return end.join([HEAD, *rows, ""]).encode()


@pytest.mark.parametrize("column", [1, 3])
def test_rows_between_two_quotation_marks_are_all_read(column: int) -> None:
    rows = lines()
    for index in (60, 90):
        cells = rows[index].split(";")
        cells[column] = '"' + cells[column]
        rows[index] = ";".join(cells)
    test = read_road_test(log(rows))
    assert (test.rows, len(test.segments)) == (200, 1)
    assert test.values("engine_speed") * 60 == pytest.approx(800 + np.arange(200.0), rel=1e-9, abs=0.0)


def test_one_quotation_mark_that_nothing_closes_costs_no_row() -> None:
    rows = lines()
    rows[120] = '12.0;"920;80;'
    assert read_road_test(log(rows)).values("engine_speed")[120] * 60 == pytest.approx(920, rel=1e-9, abs=0.0)


def test_quoted_cells_with_delimiters_and_remarks_over_two_lines_are_understood() -> None:
    rows = lines()
    rows[50] += '"left; then right"'
    rows[51] += '"a remark'
    rows[52:52] = ['over two lines"']
    understood = understand(log(rows), name="log.csv")
    assert (understood.rows, understood.rows_left_out) == (200, 1)
    assert understood.road_test.values("atf_temperature")[-1] == 84.0


def test_a_row_with_more_numbers_than_columns_is_left_out_and_said() -> None:
    rows = lines()
    rows[150] = "15,0;9;50,5;80;7;1"
    understood = understand(log(rows), name="log.csv")
    assert (understood.rows, understood.rows_left_out) == (199, 1)
    assert "rows_too_wide" in {message.code for message in understood.messages}
    words = [row + ";a remark; and another" if index == 150 else row for index, row in enumerate(lines())]
    assert read_road_test(log(words)).rows == 200


def test_a_log_with_many_rows_too_wide_is_refused() -> None:
    rows = [row if index % 3 else row.replace(".", ";", 1) + "1" for index, row in enumerate(lines())]
    with pytest.raises(RoadTestError, match="more numbers than it has columns"):
        read_road_test(log(rows), name="log.csv")


@pytest.mark.parametrize("ends", [("\r", "\n"), ("\r\n", "\r"), ("\r", "\r\n")])
def test_any_mix_of_line_ends_gives_the_same_rows(ends: tuple[str, str]) -> None:
    head, *rows = log(lines(60)).decode().splitlines()
    text = f"Some logger 1.0{ends[0]}{head}{ends[1]}" + "".join(
        row + ends[0 if index < 40 else 1] for index, row in enumerate(rows)
    )
    test = read_road_test(text.encode() + b"\n")
    assert (test.rows, test.duration) == (60, pytest.approx(5.9, rel=1e-9, abs=0.0))
    assert test.channels["engine_speed"].column == "RPM (rpm)"


def test_a_large_file_with_a_quotation_mark_far_from_its_ends_loses_no_row(tmp_path: Path) -> None:
    rows = lines(20_000)
    rows[9_000] = '900.0;"9800;80;'
    rows[9_400] = '940.0;10200;80;"'
    path = tmp_path / "log.csv"
    path.write_bytes(log(rows))
    assert (read_road_test(path).rows, len(read_road_test(path).segments)) == (20_000, 1)


def test_rows_of_another_table_above_are_counted() -> None:
    other = ["Gauge;Zero;Full scale;Serial", *(f"{i};{i * 2};{400 + i};{90 + i}" for i in range(6)), ""]
    understood = understand("\n".join([*other, HEAD, *lines()]).encode(), name="log.csv")
    assert (understood.rows, understood.rows_left_out) == (200, 6)
    said = next(message.text for message in understood.messages if message.code == "table_above")
    assert said.startswith("6 row(s)")


ODD = st.sampled_from(
    ['"', '5" pipe;1;2;',
     '12.3;"900;81;', '12.3;900";81;x', "# Lap 1", "MARK", "1;2;3;4;5;6", ";;;", HEAD, "-;-;-;-", "",
     '12.4;901;80;"a;b"', "12.5;902", '""', '"12.6";"903";"82";""', "12.7;904;81;\r12.8;905;81;"]
)  # fmt: skip


@given(st.lists(st.tuples(st.integers(3, 60), ODD), max_size=6), st.sampled_from(["\n", "\r\n", "\r"]))
@example([(10, '12.3;"900;81;'), (40, '12.3;"900;81;')], "\n")
@example([(5, "1;2;3;4;5;6"), (6, "12.5")], "\r\n")
@example([(7, ";;;")], "\n")
def test_rows_read_and_rows_left_out_are_the_rows_in_the_file(odd: list[tuple[int, str]], end: str) -> None:
    rows = lines(60)
    for place, line in odd:
        rows[place:place] = [line]
    data = log(rows, end)
    try:
        understood = understand(data, name="log.csv")
    except RoadTestError:
        return
    if understood.road_test is None:
        return
    written = [line for line in data.decode().replace("\r", "\n").split("\n")[1:] if line.strip()]
    assert understood.rows + understood.rows_left_out == len(written)
    assert understood.rows >= 60
    if understood.rows_left_out:
        assert {message.code for message in understood.messages} & {
            "lines_left_out", "rows_too_wide", "blank_rows", "table_above",
        }  # fmt: skip


# --- one damaged row --------------------------------------------------------------------------------------------

BEGIN = 71_941.0  # [s] of the day: a minute ends in the log


def of_day(seconds: float) -> str:
    clock = BEGIN + seconds
    return f"{int(clock // 3600) % 24:02d}:{int(clock % 3600 // 60):02d}:{clock % 60:05.2f}"


CLOCK_FORMS = {
    "seconds": ("Time (s)", lambda t: f"{t:.2f}"),
    "milliseconds": ("Time (ms)", lambda t: f"{t * 1e3:.0f}"),
    "no unit": ("Time", lambda t: f"{t:.2f}"),
    "epoch": ("timestamp", lambda t: f"{1.7e12 + t * 1e3:.0f}"),
    "days": ("Time", lambda t: f"{45000.4 + t / 86400:.9f}"),
    "digits": ("Time", lambda t: of_day(t).replace(":", "")),
    "time of day": ("Time", of_day),
    "date and time": ("Time", lambda t: f"2024-05-02 {of_day(t)}"),
}
DAMAGE = ["1e17", "1e9", "-1e17", "2e306", "0", "", "abc", "-5000", "-1", "0.5", "99999", "1700000000000000",
          "25:61:61", "00:00:00", "23:59:59", "1970-01-01 00:00:00", "65535", "-40"]  # fmt: skip
ROWS = 80


def stamps_of(data: list[list[str]], heading: str) -> dict[tuple[str, int], float]:
    """When every value of engine speed [rpm] and pressure [kPa] was read; each stands in one row alone."""
    text = "\n".join([f"{heading};RPM (rpm);Line Pressure (kPa)", *(";".join(row) for row in data), ""])
    test = understand(text.encode(), name="log.csv").road_test
    assert test is not None
    assert test.duration <= ROWS
    found = {}
    for name, factor in (("engine_speed", 60), ("main_pressure", 1e-3)):
        channel = test.channels[name]
        good = ~channel.suspect
        found |= {(name, round(v)): t for v, t in zip(channel.values[good] * factor, channel.time[good], strict=True)}
    return found


@given(st.sampled_from(list(CLOCK_FORMS)), st.sampled_from([0, 1, 2, 38, 39, ROWS - 3, ROWS - 2, ROWS - 1]),
       st.integers(0, 2), st.sampled_from(DAMAGE))  # fmt: skip
@example("seconds", ROWS - 1, 0, "1e17")
@example("seconds", 2, 2, "2e306")
@example("seconds", 1, 0, "-1")
@example("milliseconds", 2, 0, "0")
@example("days", 0, 0, "2e306")
@example("digits", 38, 0, "1e17")
@example("digits", 0, 0, "99999")
@example("time of day", 38, 0, "00:00:00")
@example("date and time", ROWS - 1, 0, "1970-01-01 00:00:00")
@example("time of day", 39, 0, "25:61:61")
def test_with_one_damaged_row_the_other_rows_stay(form: str, at: int, column: int, cell: str) -> None:
    heading, written = CLOCK_FORMS[form]
    data = [[written(row / 2), f"{800 + row}", f"{500 + 3 * row}"] for row in range(ROWS)]
    sound = stamps_of(data, heading)
    data[at][column] = cell
    damaged = stamps_of(data, heading)
    others = sound.keys() - {("engine_speed", 800 + at), ("main_pressure", 500 + 3 * at)}
    assert others <= damaged.keys()
    moved = [damaged[key] - sound[key] for key in others]  # all alike: the first row may be the one that is left out
    assert moved == pytest.approx([moved[0]] * len(moved), abs=1e-5, rel=0.0)


@pytest.mark.parametrize(("later", "leap"), [(1e9, "1e+09"), (1.7e15, "1.7e+12")])
def test_a_clock_that_is_set_while_it_records_is_refused(later: float, leap: str) -> None:
    unit, step = ("s", 1.0) if later < 1e12 else ("ms", 1000.0)
    stamps = [*(row * step for row in range(40)), *(later + row * step for row in range(40))]
    text = "".join(f"{stamp:.0f};{800 + row};80;\n" for row, stamp in enumerate(stamps))
    with pytest.raises(RoadTestError, match=r"column Time.* years; expected the stamps of one drive") as raised:
        read_road_test(f"Time ({unit});RPM (rpm);ATF Temp (C);Note\n{text}".encode(), name="log.csv")
    assert f"leaps by {leap} s" in str(raised.value)


def test_a_stray_stamp_of_one_clock_among_several_is_told_with_its_column() -> None:
    rows = [f"{row / 2};{800 + row};{row / 2 + 0.2};{500 + row}" for row in range(100)]
    rows[-1] = "49.5;899;1e17;600"
    text = "Time;Engine speed (rpm);Time;Line pressure (kPa)\n" + "\n".join(rows) + "\n"
    test = understand(text.encode(), name="log.csv").road_test
    assert test.channels["main_pressure"].time[-1] == pytest.approx(49.2, rel=1e-9, abs=0.0)
    assert [message.place.column for message in test.messages if message.code == "stray_stamps"] == ["Time"]
