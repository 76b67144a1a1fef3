# ruff: noqa: E501 - a case is a line, however long
"""Layouts of logs that could be read in two ways: each short log is written for its test."""

from __future__ import annotations

import datetime as dt
import io
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
import openpyxl
import pytest

from atleak.common.errors import OutputError, RoadTestError
from atleak.measurements.road_test import QUANTITIES
from atleak.readers.logs import (
    Understood,
    describe,
    log_columns,
    read_road_test,
    recall,
    remember,
    suspects,
    understand,
)
from atleak.readers.logs.clock import numeric_clock
from atleak.readers.logs.log_cells import unit_in_cells


def understood(text: str | bytes, **choices: Any) -> Understood:
    return understand(text if isinstance(text, bytes) else text.encode(), name="log.csv", **choices)


def columns(found: Understood) -> dict[str, dict[str, Any]]:
    return {column["quantity"]: column for column in describe(found)["columns"]}


def codes(found: Understood) -> set[str]:
    return {message.code for message in found.messages}


# --- groups of channels, each with a clock of its own ---------------------------------------------------------

GROUPS = (
    "Friday,02,February,2024,08:00:00\n1BB 111 111 Y,,Some box    0002,\n\n"
    ",Group A:,'001,,,Group B:,'005,,,Group C:,'031\n"
    ",,RPM,Load,Angle,,{names},,Volt 1,Volt 2,Volt 3\n"
    ",{clock},,,,{clock},,,,{clock},,,\n{mark}, /min, %, deg,STAMP, ms, ms, %,STAMP, V, V, V\n"
)
GROUP_ROWS = "".join(f",{i * 0.5:.2f},{900 + i},20,6,{i * 0.5 + 0.2:.2f},4.5,{3 + i * 0.01:.2f},7,{i * 0.5 + 0.4:.2f},.5,.6,.7\n" for i in range(50))  # fmt: skip


@pytest.mark.parametrize("names", ["Time,Time,Duty", "Inj. A,Inj. B,Duty"])
@pytest.mark.parametrize(("clock", "mark"), [("TIME", "Marker,STAMP"), ("Zeit", "Marker,MARKE")])
def test_the_clock_of_a_group_is_the_column_that_is_marked_so(names: str, clock: str, mark: str) -> None:
    head = GROUPS.format(names=names, clock=clock, mark=mark).replace("STAMP", mark.split(",")[1])
    found = understood(head + GROUP_ROWS)
    assert (found.time_label, found.road_test.duration) == (clock, pytest.approx(24.5, rel=1e-9, abs=0.0))
    assert found.road_test.values("engine_speed")[-1] * 60 == pytest.approx(949, rel=1e-9, abs=0.0)


def test_a_channel_of_a_later_group_keeps_the_stamps_of_its_own_group() -> None:
    head = GROUPS.format(names="Vehicle speed,Time,Duty", clock="TIME", mark="Marker,STAMP").replace(
        " ms,", " km/h,", 1
    )
    speed = understood(head + GROUP_ROWS).road_test.channels["vehicle_speed"]
    assert speed.time[:3].tolist() == pytest.approx([0.2, 0.7, 1.2], rel=1e-9, abs=0.0)


def test_a_clock_in_ms_by_which_the_log_takes_no_time_is_asked() -> None:
    text = ",Time (ms),RPM\n" + "".join(f"{i * 0.1:.1f},{2 + i * 0.01:.2f},{900 + i}\n" for i in range(60))
    problem = understood(text).problem
    assert problem is not None
    assert "time = 'column 1'" in str(problem)
    assert understood(text, mapping={"time": "column 1"}).road_test.duration == pytest.approx(5.9, rel=1e-9, abs=0.0)
    assert understood(text, mapping={"time": "Time (ms)"}).road_test is not None


# --- words and units in cells ----------------------------------------------------------------------------------


def test_off_is_a_value_of_a_switch_and_no_speed() -> None:
    text = "Time (s),RPM,TCC\n" + "".join(
        f"{i / 10},{'OFF' if i < 5 else 900 + i},{'On' if i % 3 else 'Off'}\n" for i in range(60)
    )
    test = understood(text).road_test
    assert test.channels["lock_up"].values.tolist() == [float(i % 3 > 0) for i in range(60)]
    assert test.channels["engine_speed"].samples == 55


def test_a_switch_that_is_always_off_is_open_throughout() -> None:
    assert (
        understood("Time (s),RPM,TCC\n" + "".join(f"{i},{900 + i},Off\n" for i in range(20)))
        .road_test.values("lock_up")
        .tolist()
        == [0.0] * 20
    )


def test_a_unit_in_every_cell_is_taken_from_the_number() -> None:
    text = "Time;RPM;Speed;ATF Temp\n" + "".join(f"{i / 2};{900 + i}RPM;{20 + i / 4:.2f} km/h;85C\n" for i in range(60))
    test = understood(text).road_test
    assert test.values("vehicle_speed")[-1] * 3.6 == pytest.approx(34.75, rel=1e-9, abs=0.0)
    assert {name: (channel.unit, channel.unit_assumed) for name, channel in test.channels.items()} == {
        "engine_speed": ("rpm", False), "vehicle_speed": ("km/h", False), "atf_temperature": ("°C", False),
    }  # fmt: skip
    changing = understood(text.replace("20.00 km/h", "12mph"))
    assert changing.road_test.channels["vehicle_speed"].samples == 59


def test_two_units_in_the_cells_of_a_column_are_none() -> None:
    assert unit_in_cells(["20km/h"] * 30, ".") == "km/h"
    assert unit_in_cells(["20km/h", "12mph"] * 15, ".") is None
    assert unit_in_cells(["20", "21 km/h"] * 15, ".") is None


# --- what is remembered -----------------------------------------------------------------------------------------


def test_nothing_is_remembered_for_logs_without_a_header(tmp_path: Path) -> None:
    store = tmp_path / "columns.json"
    first = understood("".join(f"{i / 10};{800 + i};{80 + i % 3}\n" for i in range(60)))
    mapping = {"time": "column 1", "engine_speed": "column 2"}
    assert (first.signature, recall(store, first.signature)) == ("", None)
    with pytest.raises(OutputError, match="names no columns"):
        remember(store, first.signature, mapping)
    second = "".join(f"{i / 10};{90 + i % 3};{1500 + i}\n" for i in range(60))
    assert understood(second, remembered=store).road_test is None


# --- clocks -----------------------------------------------------------------------------------------------------


def test_the_digits_of_a_clock_are_read_as_hours_minutes_and_seconds() -> None:
    stamps = [39_590.0 + i * 0.5 for i in range(100)]  # over 10:59:59 and 11:00:00
    digits = np.array([10_000 * (t // 3600) + 100 * (t % 3600 // 60) + t % 60 for t in stamps])
    clock = numeric_clock(digits, None)
    assert (clock.form, clock.unit_assumed) == ("time of day, HHMMSS", False)
    assert clock.seconds == pytest.approx(np.arange(100) * 0.5, rel=1e-9, abs=1e-9)


def test_the_digits_of_a_clock_go_on_past_midnight() -> None:
    stamps = [(86_370.0 + i) % 86_400 for i in range(100)]
    digits = np.array([10_000 * (t // 3600) + 100 * (t % 3600 // 60) + t % 60 for t in stamps])
    assert numeric_clock(digits, None).seconds == pytest.approx(np.arange(100.0), rel=1e-9, abs=1e-9)


def digits(stamps: Iterable[float]) -> list[float]:
    return [10_000 * (t // 3600) + 100 * (t % 3600 // 60) + t % 60 for t in stamps]


def test_the_digits_of_a_clock_are_known_whatever_the_pauses() -> None:
    stamps = np.array([t for t in 36_041 + 0.5 * np.arange(460) if not (36_095 < t < 36_130 or 36_215 < t < 36_250)])
    clock = numeric_clock(np.array(digits(stamps)), None)
    assert (clock.form, clock.unit_assumed) == ("time of day, HHMMSS", False)
    assert clock.seconds == pytest.approx(stamps - stamps[0], rel=1e-9, abs=1e-9)


def test_digits_of_which_no_minute_begins_while_recording_are_assumed_to_be_seconds_and_can_be_named() -> None:
    stamps = np.r_[36_001:36_040, 36_125:36_170].astype(float)
    rows = "".join(f"{value:.0f};{800 + row}\n" for row, value in enumerate(digits(stamps)))
    asked, named = (understood(f"Time;RPM (rpm)\n{rows}", units=units) for units in ({}, {"time": "HHMMSS"}))
    assert (asked.time_unit, asked.time_assumed) == ("s", True)
    assert (named.time_unit, named.time_assumed) == ("clock", False)
    assert named.road_test.time == pytest.approx(stamps - stamps[0], rel=1e-9, abs=1e-9)
    stated = understood(f"Time [HHMMSS.ss];RPM (rpm)\n{rows}")
    assert (stated.time_unit, stated.road_test.duration) == ("clock", pytest.approx(168.0, rel=1e-9, abs=0.0))


def test_a_fourth_number_of_a_clock_counts_milliseconds() -> None:
    stamps = [0, 157, 300, 945, 998, 1003, 1008, 1050, 2100, 3001]
    rows = [f"10:{ms // 60_000:02d}:{ms // 1000 % 60:02d}:{ms % 1000};{800 + i}" for i, ms in enumerate(stamps)]
    found = understood("Time;RPM (rpm)\n" + "\n".join(rows) + "\n")
    assert found.road_test.time == pytest.approx(np.array(stamps) / 1000, rel=1e-9, abs=1e-9)
    assert "reordered" not in {message.code for message in found.messages}


def test_a_column_that_is_named_as_the_time_is_read_wherever_a_time_stands_in_its_cells() -> None:
    rows = "".join(f"@Wed May  2 10:24:{row:02d} 2018,{800 + row},85\n" for row in range(40))
    mapping = {"time": "column 1", "engine_speed": "column 2"}
    found = understood(rows, mapping=mapping).road_test
    assert (found.duration, found.date) == (pytest.approx(39.0, rel=1e-9, abs=0.0), dt.date(2018, 5, 2))
    why = understood(rows, mapping={**mapping, "time": "column 3"}).problem
    assert "'column 3' tells no time that runs on (85)" in str(why)


@pytest.mark.parametrize("values", [np.arange(0, 90.0), np.r_[0:50, 110:150].astype(float), np.arange(0, 5000.0, 100)])
def test_seconds_are_no_digits_of_a_clock(values: np.ndarray) -> None:
    assert numeric_clock(values, None).form != "time of day, HHMMSS"


SECTIONS = "File created on 02/02/2024\n\n[header]\nsatellites\ntime\nvelocity kmh\nEngine Speed\nLine Pressure\n\n[channel units]\nrpm\npsi\n\n[column names]\nsats time velocity Engine Speed Line Pressure\n\n[data]\n"


def test_names_and_units_in_sections_are_read() -> None:
    rows = "".join(f"005 1000{50 + i // 2:02d}.{i % 2 * 5}0 {20 + i / 10:.3f}  {900 + i} {90 + i}\n" for i in range(19))
    rows += "".join(f"005 1001{i // 2:02d}.{i % 2 * 5}0 {22 + i / 10:.3f}  {920 + i} {110 + i}\n" for i in range(40))
    found = understood(SECTIONS + rows)
    test = found.road_test
    assert test.duration == pytest.approx(29.5, rel=1e-9, abs=0.0)
    assert (test.channels["main_pressure"].unit, test.channels["engine_speed"].column) == ("psi", "Engine Speed")
    assert test.values("main_pressure")[-1] / 6894.757293168361 == pytest.approx(149, rel=1e-9, abs=0.0)
    assert test.values("vehicle_speed")[0] * 3.6 == pytest.approx(20, rel=1e-9, abs=0.0)


def test_an_epoch_that_a_spreadsheet_has_cut_never_beats_a_good_clock() -> None:
    row = "{i};{cut};{rpm};00:00:{s:02d}\n"
    text = "id;TIME;ENGINE_RPM;RUNTIME\n" + "".join(
        row.format(i=i, cut=1513550000000 if i < 30 else 1513560000000, rpm=900 + i, s=i) for i in range(60)
    )
    assert (understood(text).time_label, understood(text).road_test.duration) == ("RUNTIME", 59.0)
    alone = "\n".join(line.rsplit(";", 1)[0] for line in text.splitlines())
    assert "cut its numbers short" in str(understood(alone).problem)


def test_a_clock_with_few_stamps_loses_against_one_with_many_and_a_number_of_rows_against_both() -> None:
    text = "Time (s),Elapsed,RPM\n" + "".join(f"{i // 10},{i / 10},{900 + i}\n" for i in range(60))
    assert understood(text).time_label == "Elapsed"
    text = "logtime, TimeStamp, nmot_w\n" + "".join(f"{i}, {i * 0.1:.2f}, {2000 + i}\n" for i in range(50))
    assert (understood(text).time_label, understood(text).road_test.duration) == (
        "TimeStamp",
        pytest.approx(4.9, rel=1e-9, abs=0.0),
    )


def test_a_clock_column_without_a_telling_name_serves_where_the_named_one_is_destroyed() -> None:
    text = "TIME;RPM;RUN\n" + "".join(f"1,51336E+12;{900 + i};00:00:{i:02d}\n" for i in range(60))
    assert (understood(text).time_label, understood(text).road_test.duration) == ("RUN", 59.0)


def test_seconds_of_the_day_are_no_excel_days() -> None:
    text = "time_of_day,TIME,RPM\n" + "".join(
        f"{28301.65 + i * 0.0101:.4f},{i * 0.0101:.4f},{900 + i}\n" for i in range(60)
    )
    assert understood(text).road_test.duration == pytest.approx(0.5959, rel=1e-6, abs=0.0)


def test_an_x_column_that_starts_again_is_named() -> None:
    problem = understood(
        "X_Value,RPM,ATF Temp (C)\n" + "".join(f"{i % 2 * 1e-5},{900 + i},80\n" for i in range(60))
    ).problem
    assert "'X_Value' starts again every few rows" in str(problem)


def test_a_log_without_any_clock_is_counted_by_a_stated_interval() -> None:
    text = "".join(f"{900 + i % 7} {1450 - i % 9} {85 + i % 2}\n" for i in range(60))
    problem = understood(text).problem
    assert "the interval between rows" in str(problem)
    assert "column 1" not in str(problem).partition("expected")[2]
    mapping, units = (
        {"engine_speed": "column 1", "turbine_speed": "column 2"},
        {"engine_speed": "rpm", "turbine_speed": "rpm"},
    )
    found = understood(text, mapping=mapping, units=units, constants={"time": 0.033})
    assert found.road_test.duration == pytest.approx(59 * 0.033, rel=1e-9, abs=0.0)
    assert set(found.road_test.channels) == {"engine_speed", "turbine_speed"}
    with_clock = understood(
        "Time (s),RPM\n" + "".join(f"{i},{900 + i}\n" for i in range(20)), constants={"time": 0.033}
    )
    assert (with_clock.road_test.duration, "interval_not_used" in codes(with_clock)) == (19.0, True)
    with pytest.raises(RoadTestError, match="interval"):
        understood(text, constants={"time": -1.0})


# --- names and units above the data ------------------------------------------------------------------------------


def test_a_unit_stated_in_the_head_of_a_measurement_file_is_seen() -> None:
    head = "LabVIEW Measurement\t\nSeparator\tTab\nX_Columns\tOne\n***End_of_Header***\t\n\nChannels\t2\t\t\nY_Unit_Label\tpsi\tdeg F\t\nX_Dimension\tTime\tTime\t\nX0\t0.0\t0.0\t\nDelta_X\t0.01\t0.01\t\n***End_of_Header***\t\t\t\n"
    text = (
        head
        + "X_Value\tLine Pressure\tATF\tComment\n"
        + "".join(f"{i * 0.01:.2f}\t{100 + i % 5}.0\t{170 + i % 3}.0\n" for i in range(60))
    )
    found = columns(understood(text))
    assert [(found[name]["unit"], found[name]["unit_assumed"]) for name in ("main_pressure", "atf_temperature")] == [
        ("psi", False),
        ("°F", False),
    ]


UNITS = "TimeStamp, b1, b2, b3, ped, {name}\nsec.ms, °KW, °KW, °KW, PED, rpm\n"


def test_a_row_of_mostly_unknown_units_is_no_row_of_names() -> None:
    rows = "".join(f"{i * 0.05:.3f}, 0, 0, 0, 12, {2000 + i}\n" for i in range(60))
    found = understood(UNITS.format(name="nx") + rows)
    assert [heading.label for heading in found.headings] == ["TimeStamp", "b1", "b2", "b3", "ped", "nx"]
    assert (columns(found)["engine_speed"]["column"], found.road_test.duration) == (
        "nx",
        pytest.approx(2.95, rel=1e-9, abs=0.0),
    )
    alias = understood(UNITS.format(name="qq") + '"TIME","R1","R2","R3","Pedal","EngineSpeed"\n' + rows)
    assert columns(alias)["engine_speed"]["unit"] == "rpm"
    assert alias.headings[5].names == ("EngineSpeed", "qq")


def test_names_of_groups_above_the_names_do_not_make_units_of_them() -> None:
    found = understood(
        "Engine;Engine;Trans;Trans\nTime;rpm;temp;gear\n" + "".join(f"{i / 10};{900 + i};80;2\n" for i in range(60))
    )
    assert (found.time_label, columns(found)["engine_speed"]["column"]) == ("Time", "rpm")


def test_more_than_forty_channels_defined_in_blocks_are_read() -> None:
    channels = "".join(f"Channel : Chan {k}\nID : {k}\nType : Raw\nDisplayMaxMin : 100,0\n" for k in range(119))
    head = f"%DataLog%\n{channels}Channel : RPM\nID : 200\nType : EngineSpeed\nDisplayMaxMin : 9000,0\nLog : 20240202 01:00:00\n"
    found = understood(head + "".join(f"13:00:{i * 0.02:06.3f}," + "5," * 119 + f"{900 + i}\n" for i in range(100)))
    assert (found.rows, found.road_test.values("engine_speed")[-1] * 60) == (100, pytest.approx(999, rel=1e-9, abs=0.0))


def test_a_head_longer_than_its_table_does_not_hide_it() -> None:
    head = "".join(f"Setting {k}: value {k}, checked by nobody\n" for k in range(23))
    found = understood(head + "Time (s);RPM;ATF Temp (C)\n" + "".join(f"{i};{900 + i};80\n" for i in range(4)))
    assert (found.rows, found.road_test.duration) == (4, 3.0)
    numbers = "".join(f"Setting {k},{k},{2 * k}\n" for k in range(23))
    wide = "Time (s),RPM,ATF Temp (C),Gear,Speed (km/h)\n" + "".join(f"{i},{900 + i},80,2,30\n" for i in range(4))
    assert understood(numbers + "\n" + wide).rows == 4


# --- several columns of one name -----------------------------------------------------------------------------------

SOURCED = "timestamp,speed,speed,speed,engine_rpm\ns,m/s,km/h,km/h,rpm\n,{sources},200: canbus\n"
SOURCED_ROWS = "".join(f"{i / 10},{99 + i},{i},{50 + i},{900 + i}\n" for i in range(60))


def test_of_equal_names_the_car_s_own_bus_comes_first() -> None:
    found = understood(SOURCED.format(sources="100: gps,200: canbus,calc") + SOURCED_ROWS)
    assert found.road_test.values("vehicle_speed")[-1] * 3.6 == pytest.approx(59, rel=1e-9, abs=0.0)
    assert not found.ambiguous


def test_equal_names_are_told_apart_by_their_place_and_source() -> None:
    text = (SOURCED.format(sources="100: gps,200: canbus,201: canbus") + SOURCED_ROWS).encode()
    question = understood(text).ambiguous[0]
    assert question.candidates == ("speed (column 3, 200: canbus)", "speed (column 4, 201: canbus)")
    test = read_road_test(text, mapping={"vehicle_speed": question.candidates[1]})
    assert test.values("vehicle_speed")[0] * 3.6 == pytest.approx(50, rel=1e-9, abs=0.0)
    assert question.candidates[1] in [column.label for column in log_columns(text)]


def test_a_speed_of_gps_is_asked_where_a_name_resembles_the_vehicle_s() -> None:
    found = understood(
        "Time (s),GPS Speed (km/h),Car A Vehicle Speed (km/h),RPM\n"
        + "".join(f"{i},{i},{i + 3},{900 + i}\n" for i in range(40))
    )
    assert found.ambiguous[0].candidates == ("GPS Speed (km/h)", "Car A Vehicle Speed (km/h)")
    assert "vehicle_speed" not in found.road_test.channels


@pytest.mark.parametrize(
    ("name", "quantity"),
    [("Motortemperatur (°C)", "coolant_temperature"), ("EngineTemp (C)", "coolant_temperature"), ("Getriebeöltemp. (°C)", "atf_temperature"),
     ("Velocity (m/s)", "vehicle_speed"), ("N (rpm)", "engine_speed"), ("VS (km/h)", "vehicle_speed"), ("ATF Temp (.C)", "atf_temperature")],
)  # fmt: skip
def test_further_names(name: str, quantity: str) -> None:
    found = understood(
        f"Time (s),{name},x\n" + "".join(f"{i},{500 + i if 'rpm' in name else 60 + i % 9},1\n" for i in range(40))
    )
    assert found.road_test.channels[quantity].column == name


def test_a_short_name_means_nothing_in_another_unit() -> None:
    assert not understood(
        "Time (s),N (Nm),VS (V)\n" + "".join(f"{i},{500 + i},{i}\n" for i in range(40))
    ).road_test.channels


# --- workbooks -----------------------------------------------------------------------------------------------------


def test_sheets_whose_columns_a_spreadsheet_has_numbered_hold_the_time_and_the_signal() -> None:
    book = openpyxl.Workbook()
    book.remove(book.active)
    for name, first in (("Engine RPM (rpm)", 900), ("ATF Temp (°C)", 80), ("Lambda", 1)):
        sheet = book.create_sheet(name)
        for row in [["Column1", "Column2"], *([i * 0.5, first + i % 30] for i in range(60))]:
            sheet.append(row)
    stream = io.BytesIO()
    book.save(stream)
    test = understood(stream.getvalue()).road_test
    assert set(test.channels) == {"engine_speed", "atf_temperature"}
    assert (test.duration, test.values("engine_speed")[0] * 60) == (29.5, pytest.approx(900, rel=1e-9, abs=0.0))


# --- checks --------------------------------------------------------------------------------------------------------


def test_a_constant_speed_is_frozen_only_where_something_else_of_the_car_changes() -> None:
    head, rows = "Time (s),RPM (rpm)", [f"{i / 10},2300" for i in range(600)]
    assert not codes(understood("\n".join([head, *rows])))
    moving = "\n".join([f"{head},Speed (km/h)", *(f"{row},{20 + i % 40}" for i, row in enumerate(rows))])
    assert "suspect_samples" in codes(understood(moving))


def test_a_gear_that_is_none_is_left_out() -> None:
    found = understood(
        "Time (s),RPM,Gear\n" + "".join(f"{i / 10},{900 + i},{(-3, -1, 0, 1)[i % 4]}\n" for i in range(80))
    )
    assert (columns(found)["gear"]["min"], columns(found)["gear"]["suspect_samples"]) == (-1.0, 20)


def test_a_few_equal_samples_off_all_others_are_a_spike() -> None:
    import pandas as pd

    values = 88.0 + np.arange(60) % 2
    values[[30, 31]] = -35.0
    assert suspects.spikes(pd.Series(values), 15.0).to_numpy().nonzero()[0].tolist() == [30, 31]
    values[30] = -37.0
    assert not suspects.spikes(pd.Series(values), 15.0).any(), "two different samples are no held answer"
    values[30:40] = -35.0
    assert not suspects.spikes(pd.Series(values), 15.0).any(), "what lasts is no spike"


# --- no logs -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "data", "said"),
    [
        ("a.blf", b"LOGG\x90\x00" + bytes(100), "Vector"),
        ("a.txt", b"\xd7\x00\x00\x00lf3" + bytes(300), "Link"),
        ("a.emulog", bytes(range(256)) * 40, "ECUMaster"),
        ("a.fsl", bytes(range(256)) * 40, "FORScan"),
        ("a.bin", bytes(range(256)) * 40, "no text"),
        ("a.dat", b"DIAEXTENDED  {@:ENGLISH\n#BEGINGLOBALHEADER\n1,WINDOWS 32Bit\n#ENDGLOBALHEADER\n", "DIAdem"),
        ("a.json", b'[{"Time (s)": 0.1, "RPM": 900},\n {"Time (s)": 0.2, "RPM": 910}]\n', "JSON"),
        ("a.json", b'{"rows": [\n[0.1, 900],\n[0.2, 910]\n]}\n', "JSON"),
        ("a.dfq", b"K0100 2\nK1001/1 Spool\nK2002/1 Land 1\n12.701\n12.702\n12.701\n", "Q-DAS"),
        ("a.txt", "Element;Nennmaß;Istmaß;Abweichung;Toleranz\n".encode() + b"".join(b"Kreis %d;12,700;12,69%d;0,005;0,01\n" % (i, i) for i in range(9)), "measuring machine"),
    ],
)  # fmt: skip
def test_what_is_no_log_is_named(name: str, data: bytes, said: str) -> None:
    with pytest.raises(RoadTestError, match=said):
        read_road_test(data, name=name)


# --- what is a state, and what a pressure -----------------------------------------------------------------------


@pytest.mark.parametrize(
    ("column", "quantity", "taken"),
    [
        ("TCC Pressure (psi)", "lock_up", False),
        ("TCC (psi)", "lock_up", False),
        ("Lock Up [bar]", "lock_up", False),
        ("Torque Converter Clutch (kPa)", "lock_up", False),
        ("Gear Selector (kPa)", "selector", False),
        ("Gear (bar)", "gear", False),
        ("TCC (%)", "lock_up", True),
        ("TCC Status", "lock_up", True),
        ("L/U Solenoid Valve Pressure (kPa)", "lock_up", True),
    ],
)
def test_a_pressure_is_no_state_but_where_a_solenoid_is_commanded_one(column: str, quantity: str, taken: bool) -> None:
    rows = "".join(f"{i / 10};{800 + i};{i % 4}\n" for i in range(60))
    found = understood(f"Time (s);RPM (rpm);{column}\n{rows}")
    assert (quantity in found.road_test.channels) == taken
    if taken or "Pressure" in column:
        return
    assert f"does not belong to {QUANTITIES[quantity].label}" in found.road_test.refused[quantity]


# --- a speed without a unit -------------------------------------------------------------------------------------


def drive_up(rpm_at_100: float, top: int, in_mph: bool, column: str = "Speed", also: str = "") -> str:
    """A car that goes through its gears to 110 km/h; its engine turns so fast at 100 km/h in the highest."""
    rows = []
    for row in range(600):
        kmh = 20 + row * 0.15
        gear = min(top, 1 + int(kmh // (90 / top)))
        speed = kmh / 1.609344 if in_mph else kmh
        rows.append(f"{row / 10:.1f},{rpm_at_100 * kmh / 100 * 1.35 ** (top - gear):.0f},{speed:.1f},{gear},90")
    return f"Time (s),Engine RPM,{column},Gear,ATF Temp ({also or 'C'})\n" + "\n".join(rows) + "\n"


@pytest.mark.parametrize(
    ("rpm", "top", "in_mph", "column", "taken"),
    [
        (2146, 6, True, "Speed", None),
        (2300, 5, True, "Vehicle Speed", None),
        (1700, 8, True, "Speed", None),
        (2146, 6, False, "Speed", "km/h"),
        (2800, 6, False, "Speed", "km/h"),
        (2700, 4, False, "Speed", "km/h"),
        (2146, 6, True, "Speed (mph)", "mph"),
    ],
)
def test_a_speed_without_unit_is_asked_about_where_gear_and_engine_speed_are_against_it(
    rpm: float, top: int, in_mph: bool, column: str, taken: str | None
) -> None:
    found = understood(drive_up(rpm, top, in_mph, column))
    channel = found.road_test.channels.get("vehicle_speed")
    assert (channel.unit if channel else None) == taken
    assert [question.quantity for question in found.ambiguous] == ([] if taken else ["vehicle_speed"])
    if taken is None:
        why = found.ambiguous[0].why
        assert f"gear {top}" in why
        assert f"{rpm} rpm if it is mph" in why
        assert f"{rpm * 1.609344:.0f}"[:3] in why
        answered = understood(drive_up(rpm, top, in_mph, column), units={"vehicle_speed": "mph"})
        assert (answered.ambiguous, answered.road_test.channels["vehicle_speed"].unit) == ((), "mph")


def test_miles_assumed_by_the_neighbours_are_asked_about_likewise() -> None:
    slow = understood(drive_up(1500, 6, False, also="F"))
    assert [question.quantity for question in slow.ambiguous] == ["vehicle_speed"]
    assert understood(drive_up(2146, 6, False)).ambiguous == ()
