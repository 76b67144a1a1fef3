"""A log whose units, columns or way of writing numbers change is refused or told, never read in the first unit."""

from __future__ import annotations

import pytest

from atleak.common.errors import RoadTestError
from atleak.readers.logs import Understood, read_road_test, understand

HEAD = "Time [s],Engine speed [rpm],ATF temperature [°C],Main pressure [kPa],Gear"


def rows(start: int = 0, count: int = 30, pressure: str = "{:.1f}") -> list[str]:
    return [
        f"{i / 10:.1f},{800 + i},{80 + i % 3},{pressure.format(700 + i % 5)},2" for i in range(start, start + count)
    ]


def log(*parts: str | list[str]) -> bytes:
    lines = [line for part in parts for line in ([part] if isinstance(part, str) else part)]
    return "\n".join([*lines, ""]).encode()


def read(data: bytes) -> Understood:
    return understand(data, name="log.csv")


def said(understood: Understood, code: str) -> list[str]:
    return [message.text for message in understood.messages if message.code == code]


@pytest.mark.parametrize(
    "again",
    [HEAD.replace("kPa", "psi"), HEAD.replace("kPa", "kPa abs"), HEAD.replace("°C", "°F"), "s,rpm,°C,psi,", ",,,psi,"],
)
def test_a_header_or_a_row_of_units_that_returns_in_other_units_is_refused_with_both(again: str) -> None:
    with pytest.raises(RoadTestError, match=r"changes from (kPa|°C) to (psi|kPa abs|°F).*data row 31") as caught:
        read_road_test(log(HEAD, rows(), again, rows(30)), name="log.csv")
    assert caught.value.place is not None
    assert caught.value.place.column == ("ATF temperature [°C]" if "°F" in again else "Main pressure [kPa]")


@pytest.mark.parametrize("again", [HEAD, "s,rpm,°C,kPa,", "Time (sec),engine speed [1/min],ATF temperature [°C],,Gear"])
def test_a_header_or_a_row_of_units_that_returns_in_the_same_units_is_left_out(again: str) -> None:
    understood = read(log(HEAD, rows(), again, rows(30)))
    assert (understood.rows, understood.rows_left_out) == (60, 1)


@pytest.mark.parametrize("name", ["Desired line pressure [kPa]", "Throttle [%]"])
def test_a_header_that_returns_with_one_other_column_is_refused(name: str) -> None:
    again = HEAD.replace("Main pressure [kPa]", name)
    with pytest.raises(RoadTestError, match=r"another header with other columns .*split the file at data row 31"):
        read_road_test(log(HEAD, rows(), again, rows(30)), name="log.csv")


def test_a_row_of_units_below_columns_that_are_called_by_units_is_asked_about_as_units() -> None:
    lines = [f"{i / 10},{800 + i},{20 + i % 3},1" for i in range(30)]
    with pytest.raises(RoadTestError, match=r"unit is stated from data row 31 on only \(s\)"):
        read_road_test(log("Time,RPM,MPH,Gear", lines, "s,rpm,mph,", lines), name="log.csv")


def test_a_remark_that_names_a_column_is_no_header() -> None:
    understood = read(log(HEAD, rows(), "Main pressure,,,,", "Lap 2,,,,", rows(30)))
    assert (understood.rows, understood.rows_left_out) == (60, 2)


def test_a_name_whose_unit_changes_in_a_long_log_is_not_used() -> None:
    lines = [
        line
        for i in range(30)
        for line in (
            f"{i / 10},Engine speed,{800 + i},rpm",
            f"{i / 10},Main pressure,{700 + i if i < 15 else 101},{'kPa' if i < 15 else 'psi'}",
        )
    ]
    understood = read(log("Time,Name,Value,Unit", lines))
    assert understood.road_test is not None
    assert set(understood.road_test.channels) == {"engine_speed"}
    assert "several units (kPa, psi)" in said(understood, "column_refused")[0]


def test_a_column_of_units_beside_a_channel_states_its_unit_and_two_of_them_refuse_it() -> None:
    head = "Time [s],Engine speed [rpm],Main pressure,Unit"
    lines = [f"{i / 10},{800 + i},{101 + i % 3},psi" for i in range(30)]
    understood = read(log(head, lines))
    assert understood.road_test is not None
    channel = understood.road_test.channels["main_pressure"]
    assert (channel.unit, channel.unit_assumed, understood.unused) == ("psi", False, ())
    lines[20:] = [line.replace("psi", "kPa") for line in lines[20:]]
    understood = read(log(head, lines))
    assert understood.road_test is not None
    assert "main_pressure" not in understood.road_test.channels
    assert "several units (psi, kPa)" in understood.road_test.refused["main_pressure"]


def test_a_pressure_in_which_1_001_means_1001_is_refused_and_that_of_a_pump_at_rest_is_not() -> None:
    head = "Time [s];Engine speed [rpm];Main pressure [kPa]"
    thousands = [f"{i};{800 + i};{('998', '1.001', '1.002', '999')[i % 4]}" for i in range(40)]
    understood = read(log(head, thousands))
    assert understood.road_test is not None
    assert "parts thousands" in understood.road_test.refused["main_pressure"]
    at_rest = [f"{i};{800 + i};{(700 + i) if i > 8 else f'{1.5 + i / 10:.1f}'}" for i in range(40)]
    understood = read(log(head, at_rest))
    assert understood.road_test is not None
    assert "main_pressure" in understood.road_test.channels


@pytest.mark.parametrize(
    ("pressure", "why"),
    [
        ('"1,{:.1f}"', "',' parts thousands ("),
        ('"1,{:.0f}"', "',' parts thousands or is the decimal sign ("),
        ("{:.0f}'000", '"\'" parts thousands ('),
        ("{:.1f} x", "text instead of numbers ("),
    ],
)
def test_a_column_that_holds_no_numbers_is_told_once_with_the_cause(pressure: str, why: str) -> None:
    told = [message.text for message in read(log(HEAD, rows(pressure=pressure))).messages if "Main" in message.text]
    assert len(told) == 1
    assert why in told[0]


def test_units_in_the_cells_that_change_are_named() -> None:
    lines = [*rows(pressure="{:.1f} kPa"), *rows(30, pressure="{:.1f} psi")]
    understood = read(log(HEAD.replace(" [kPa]", ""), lines))
    assert "several units (704.0 kPa, 704.0 psi)" in said(understood, "column_refused")[0]


def test_a_time_with_another_decimal_sign_than_the_rest_is_refused_with_that_cause() -> None:
    lines = [f"{i // 10},{i % 10};{800 + i};1.{300 + i}" for i in range(60)]
    understood = read(log("Time [s];Engine speed [rpm];Main pressure [kPa]", lines))
    assert "decimal sign ',', beside others with '.'" in str(understood.problem)


def test_a_cell_of_5000_digits_is_cut_in_the_message() -> None:
    lines = rows(count=80)
    lines[40] = f"4.0,{'9' * 5000},80,700.0,2"
    assert max(len(message.text) for message in read(log(HEAD, lines)).messages) < 200


@pytest.mark.parametrize("constant", [0.0, -300e3])
def test_a_constant_main_pressure_that_is_none_is_refused(constant: float) -> None:
    lines = [f"{i / 10},{800 + i}" for i in range(30)]
    with pytest.raises(RoadTestError, match=r"kPa.*above 0"):
        read_road_test(log("Time [s],Engine speed [rpm]", lines), constants={"main_pressure": constant})


def test_rows_with_too_few_cells_and_a_last_line_that_breaks_off_are_told() -> None:
    lines = rows()
    lines[10], lines[12] = "1.0,810", "1.2,812,81"
    understood = read(log(HEAD, lines).rstrip(b"\n").removesuffix(b"0,2"))
    assert understood.rows == 30
    assert said(understood, "rows_short")[0].startswith("2 row(s)")
    assert len(said(understood, "line_breaks_off")) == 1
    assert not said(read(log(HEAD, rows())), "rows_short")


BARE = HEAD.replace(" [kPa]", "")
IN_PSI = [line.replace(",70", ",10") for line in rows(30)]


@pytest.mark.parametrize("again", [HEAD.replace("kPa", "psi"), "s,rpm,°C,psi,", HEAD.replace("kPa", "kPa abs")])
def test_a_unit_that_is_stated_later_only_is_asked_about(again: str) -> None:
    data, unit = log(BARE, rows(), again, IN_PSI), "kPa abs" if "abs" in again else "psi"
    with pytest.raises(RoadTestError, match=rf"stated from data row 31 on only \({unit}\).*split at") as caught:
        read_road_test(data, name="log.csv")
    assert caught.value.place.column == "Main pressure"
    test = read_road_test(data, name="log.csv", units={"main_pressure": unit})
    assert (test.rows, test.channels["main_pressure"].unit_assumed) == (60, False)
    with pytest.raises(RoadTestError, match=rf"changes from bar to {unit}.*data row 31"):
        read_road_test(data, name="log.csv", units={"main_pressure": "bar"})


def test_a_unit_that_is_not_stated_again_is_asked_about() -> None:
    with pytest.raises(RoadTestError, match=r"its unit \(kPa\) is not stated again from data row 31 on"):
        read_road_test(log(HEAD, rows(), BARE, IN_PSI), name="log.csv")
    test = read_road_test(log(HEAD, rows(), BARE, rows(30)), name="log.csv", units={"main_pressure": "kPa"})
    assert (test.rows, test.channels["main_pressure"].unit) == (60, "kPa")


def test_a_speed_whose_unit_is_stated_later_is_asked_about() -> None:
    lines, head = [f"{i / 10},{800 + i},{20 + i % 3}" for i in range(30)], "Time [s],Engine speed [rpm],Vehicle speed"
    with pytest.raises(RoadTestError, match=r"such as vehicle_speed = 'km/h'"):
        read_road_test(log(head, lines, f"{head} [km/h]", lines), name="log.csv")


def test_a_clock_whose_unit_is_stated_later_is_asked_about() -> None:
    bare, milliseconds = HEAD.replace(" [s]", ""), [f"{i * 100},{800 + i},80,700,2" for i in range(30, 60)]
    with pytest.raises(RoadTestError, match=r"column Time: its unit is stated from data row 31 on only \(ms\)"):
        read_road_test(log(bare, rows(), bare.replace("Time", "Time [ms]"), milliseconds), name="log.csv")


def test_a_unit_that_the_user_states_instead_of_the_file_s_is_no_change() -> None:
    test = read_road_test(log(HEAD, rows(), HEAD, rows(30)), name="log.csv", units={"main_pressure": "psi"})
    assert (test.rows, test.channels["main_pressure"].unit) == (60, "psi")
