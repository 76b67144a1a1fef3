# ruff: noqa: E501 - a case is a line, however long
"""Loggers that are known by their files, one short log each, made up for its test."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest

from atleak.common.errors import RoadTestError
from atleak.readers.logs import Understood, describe, log_columns, read_road_test, understand
from atleak.readers.logs.loggers import known_logger
from tests.effort import in_time

ROWS = 40


def read(text: str | bytes, name: str = "log", **choices: Any) -> Understood:
    return understand(text if isinstance(text, bytes) else text.encode(), name=name, **choices)


def logger_of(found: Understood) -> str:
    """Return what the first message says of the logger; "" where it says nothing."""
    first = next(iter(found.messages), None)
    return str(first.text) if first is not None and first.code == "logger" else ""


def table(row: str, rows: int = ROWS) -> str:
    """Rows of i, t [s], ms, the digits of a clock, a time of day, rpm, km/h, °C, kPa and a gear."""
    return "".join(
        row.format(
            i=i, t=i * 0.5, ms=i * 500, digits=f"{100000 + i // 2:06d}.{i % 2 * 50:02d}", clock=f"10:00:{i // 2:02d}.{i % 2 * 5}00",
            rpm=800 + 10 * i, kmh=i, temp=60 + i % 5, kpa=500 + i, gear=1 + i // 20,
        ) + "\n"
        for i in range(rows)
    )  # fmt: skip


VBOX = (
    "File created on 02/02/2024 at 10:00:00\n\n[header]\nsatellites\ntime\nlatitude\nlongitude\nvelocity kmh\nheading\nGearbox Oil Temp\nLine Pressure\n\n"
    "[channel units]\nC\npsi\n\n[comments]\nMade-up box\n\n[column names]\nsats time lat long velocity heading Gearbox Oil Temp Line Pressure\n\n[data]\n"
)
VBOX_ROW = "009 {digits} +03119.09973 +00058.49277 {kmh:07.3f} 321.85 {temp}.5 {kpa}"
HALTECH = (
    "%DataLog%\nDataLogVersion : 1.1\n\nSoftware : Made up\n"
    + "".join(f"Channel : {name}\nID : {place}\nType : {kind}\nDisplayMaxMin : 100,0\n\n"
              for place, (name, kind) in enumerate([("RPM", "EngineSpeed"), ("Gearbox Oil Temperature", "Temperature"), ("Vehicle Speed", "Speed")]))
    + "Log Source : 20\nLog : 20240202 10:00:00\n"
)  # fmt: skip
LABVIEW = "LabVIEW Measurement\t\nSeparator\tTab\nX_Columns\t{x}\n***End_of_Header***\t\n\t\nChannels\t2\t\t\nY_Unit_Label\tpsi\tdeg F\t\nX_Dimension\tTime\tTime\t\n***End_of_Header***\t\t\t\n"
VCDS = (
    "Friday,02,February,2024,10:00:00\n1BB 111 111 Y,,Some box    0002,\n\n,Group A:,'001,,Group B:,'005,\n,,RPM,Time,,Vehicle speed,Duty\n"
    ",TIME,,,TIME,,\nMarker,STAMP, /min, ms,STAMP, km/h, %\n"
)
AIM = '"Format","{name}"\n"Venue","Nowhere"\n"Vehicle","Made up"\n"Sample Rate","2"\n"Duration","19.5"\n\n"Time","RPM","Gearbox Oil T","SpeedVeh"\n"s","rpm","C","mph"\n\n'

# logger, the log, its duration, and by quantity the last value in the workshop's unit and the file's own unit
KNOWN: dict[str, tuple[str, str, float, dict[str, tuple[float, str]]]] = {
    "VBO": ("Racelogic VBOX: names and units as its head gives them, 'time' in HHMMSS", VBOX + table(VBOX_ROW), 19.5,
            {"vehicle_speed": (39.0, "km/h"), "atf_temperature": (64.5, "°C"), "main_pressure": (539 * 6.894757, "psi")}),
    "Haltech": ("Haltech: names and units as its head gives them", HALTECH + table("{clock},{rpm},35{temp},{kmh}0"), 19.5,
                {"engine_speed": (1190.0, "rpm"), "atf_temperature": (83.25, "0.1 K"), "vehicle_speed": (39.0, "0.1 km/h")}),
    "LabVIEW": ("LabVIEW: names and units as its head gives them", LABVIEW.format(x="One") + "X_Value\tLine Pressure\tATF\tComment\n" + table("{t}\t{kpa}.0\t1{temp}.0"), 19.5,
                {"main_pressure": (539 * 6.894757, "psi"), "atf_temperature": ((164 - 32) / 1.8, "°F")}),
    "LabVIEW, an x before each": ("LabVIEW: names and units as its head gives them", LABVIEW.format(x="Multi") + "X_Value\tLine Pressure\tX_Value\tATF\tComment\n" + table("{t}\t{kpa}.0\t{t}\t1{temp}.0"), 19.5,
                                  {"main_pressure": (539 * 6.894757, "psi"), "atf_temperature": ((164 - 32) / 1.8, "°F")}),
    "VCDS": ("VCDS: names and units as its head gives them, 'TIME' is time", VCDS + table(",{t},{rpm},4.5,{t},{kmh},7"), 19.5,
             {"engine_speed": (1190.0, "rpm"), "vehicle_speed": (39.0, "km/h")}),
    "RaceChrono": ("RaceChrono: names and units as its head gives them",
                   "This file is created using RaceChrono v7.0.0.\nFormat,3\nSession title,Made up\n\ntimestamp,speed,speed,rpm\nunix time,m/s,km/h,rpm\n,100: gps,201: obd,201: obd\n" + table("{t},99,{kmh},{rpm}"), 19.5,
                   {"vehicle_speed": (39.0, "km/h"), "engine_speed": (1190.0, "rpm")}),
    "EFILive": ("EFILive: names and units as its head gives them",
                "Frame,Time,Flags,ECM.RPM,TCM.TFT,TCM.TURBINE,TCM.GEAR\nEngine Speed,Trans Fluid Temp,Turbine Speed,Gear\n,s,,rpm,°C,rpm,\n" + table("{i},{t},0,{rpm},{temp},{rpm},{gear}"), 19.5,
                {"engine_speed": (1190.0, "rpm"), "atf_temperature": (64.0, "°C"), "turbine_speed": (1190.0, "rpm"), "gear": (2.0, "")}),
    "HP Tuners": ("HP Tuners: names and units as its head gives them",
                  "HP Tuners CSV Log File\nVersion: 1.0\n\n[Log Information]\nNotes: \n\n[Channel Information]\n0,12,13\nOffset,Engine RPM (SAE),Trans Fluid Temp\ns,rpm,°F\n\n[Channel Data]\n" + table("{t},{rpm},1{temp}"), 19.5,
                  {"engine_speed": (1190.0, "rpm"), "atf_temperature": ((164 - 32) / 1.8, "°F")}),
    "AiM": ("AiM Race Studio: names and units as its head gives them", AIM.format(name="AiM CSV File") + table('"{t}","{rpm}","{temp}","{kmh}"'), 19.5,
            {"engine_speed": (1190.0, "rpm"), "atf_temperature": (64.0, "°C"), "vehicle_speed": (39 * 1.609344, "mph")}),
    "MoTeC": ("MoTeC i2: names and units as its head gives them", AIM.format(name="MoTeC CSV File").replace("Gearbox Oil T", "Gearbox Oil Pres").replace('"C"', '"kPa"') + "\n" + table('"{t}","{rpm}","{kpa}","{kmh}"'), 19.5,
              {"engine_speed": (1190.0, "rpm"), "main_pressure": (539.0, "kPa"), "vehicle_speed": (39 * 1.609344, "mph")}),
    "TunerStudio": ("TunerStudio: names and units as its head gives them",
                    '"Made-up firmware 1.0"\n"Capture Date: Fri Feb 02 10:00:00 2024"\nTime\tRPM\tVSS1\tgammae\nsec\trpm\tmph\t°KW\n' + table("{t}\t{rpm}\t{kmh}\t100").replace("\n10.0\t", "\nMARK 001\n10.0\t"), 19.5,
                    {"engine_speed": (1190.0, "rpm"), "vehicle_speed": (39 * 1.609344, "mph")}),
    "Carly": ("Carly: '02.02.2024 10:00' is time", "02.02.2024 10:00\tMotordrehzahl [1/min]\tGeschwindigkeit [km/h]\n" + table("02.02.2024 {clock}\t{rpm}\t{kmh}"), 19.5,
              {"engine_speed": (1190.0, "rpm"), "vehicle_speed": (39.0, "km/h")}),
    "Torque": ("Torque", "GPS Time, Device Time,Engine RPM(rpm),Speed (OBD)(km/h)\n" + table("-,02-Feb-2024 {clock},{rpm},{kmh}"), 19.5,
               {"engine_speed": (1190.0, "rpm"), "vehicle_speed": (39.0, "km/h")}),
    "COBB": ("COBB Accessport", "Time (sec),RPM (RPM),Gear Position (Gear),AP Info:[made up]\n" + table("{t},{rpm},{gear},0"), 19.5,
             {"engine_speed": (1190.0, "rpm"), "gear": (2.0, "")}),
    "RomRaider": ("RomRaider", "Time (msec),Engine Speed (rpm),ATF Temperature (C)\n" + table("{ms},{rpm},{temp}"), 19.5,
                  {"engine_speed": (1190.0, "rpm"), "atf_temperature": (64.0, "°C")}),
    "Car Scanner": ("Car Scanner", '"SECONDS";"PID";"VALUE";"UNITS"\n' + table('"{t}";"Engine RPM";"{rpm}";"rpm"\n"{t}";"Vehicle speed";"{kmh}";"mph"'), 19.5,
                    {"engine_speed": (1190.0, "rpm"), "vehicle_speed": (39 * 1.609344, "mph")}),
    "ME7Logger": ("ME7Logger: 'TimeStamp' in s", "ME7Logger made up\n\nTimeStamp,nmot_w,vfil_w\n" + table("{t},{rpm},{kmh}"), 19.5, {"engine_speed": (1190.0, "rpm")}),
}  # fmt: skip


@pytest.mark.parametrize("name", KNOWN)
def test_a_logger_is_known_and_its_columns_are_what_they_are(name: str) -> None:
    logger, text, duration, quantities = KNOWN[name]
    found = read(text)
    assert logger_of(found) == f"read as a log of {logger}"
    assert found.road_test is not None, found.problem
    assert found.road_test.duration == pytest.approx(duration, rel=1e-9, abs=0.0)
    columns = {column["quantity"]: column for column in describe(found)["columns"]}
    for quantity, (last, unit) in quantities.items():
        assert (columns[quantity]["unit"] or "") == unit
        channel = found.road_test.channels[quantity]
        shown = {"engine_speed": 60.0, "turbine_speed": 60.0, "vehicle_speed": 3.6, "main_pressure": 1e-3}
        assert channel.values[-1] * shown.get(quantity, 1.0) == pytest.approx(last, rel=1e-6, abs=0.0)


@pytest.mark.parametrize("name", sorted(KNOWN.keys() - {"Car Scanner"}))  # whose headings name no quantities
def test_what_a_person_says_goes_before_what_is_known_of_the_logger(name: str) -> None:
    _, text, *_ = KNOWN[name]
    heading = next(
        column.label for column in log_columns(text.encode()) if column.quantity in ("engine_speed", "atf_temperature")
    )
    found = read(text, mapping={"turbine_speed": heading}, units={"turbine_speed": "1/s"})
    test = found.road_test
    assert test is not None
    assert not {"engine_speed", "atf_temperature"} & {
        quantity for quantity, channel in test.channels.items() if channel.column == heading
    }
    assert test.channels["turbine_speed"].column == heading


def test_the_unit_that_a_person_names_goes_before_the_logger_s() -> None:
    found = read(VBOX + table(VBOX_ROW), units={"time": "s", "main_pressure": "kPa"})
    assert found.time_unit == "s"
    assert found.road_test.values("main_pressure")[-1] == pytest.approx(539e3, rel=1e-9, abs=0.0)


def test_a_clock_of_digits_is_known_though_no_minute_begins_while_it_records() -> None:
    pauses = [0, 10, 30, 90, 150, 200]  # s, each followed by 8 s
    stamps = [36_001 + start + step for start in pauses for step in range(8)]
    rows = "".join(
        f"009 {t // 3600:02d}{t // 60 % 60:02d}{t % 60:02d}.00 +1 +2 {i}.0 3 64.5 500\n" for i, t in enumerate(stamps)
    )
    found = read(VBOX + rows)
    assert (found.time_unit, found.time_assumed, found.road_test.duration) == ("clock", False, 207.0)


# --- damaged: the table's own headings tell again ---------------------------------------------------------------


def test_a_head_that_names_fewer_channels_than_the_table_has_is_not_believed() -> None:
    found = read(VBOX.replace("latitude\n", "") + table(VBOX_ROW))
    assert logger_of(found) == "read as a log of Racelogic VBOX: 'time' in HHMMSS"
    assert (found.road_test.duration, "main_pressure" in found.road_test.channels) == (19.5, False)


def test_a_blank_among_the_units_leaves_all_of_them_to_be_asked() -> None:
    found = read(VBOX.replace("\nC\npsi\n", "\n\npsi\n\n") + table(VBOX_ROW))
    assert [heading.unit for heading in found.headings if heading.label in ("Gearbox Oil Temp", "Line Pressure")] == [
        None,
        None,
    ]
    assert {column["quantity"] for column in describe(found)["columns"] if column["unit_assumed"]} == {
        "atf_temperature",
        "main_pressure",
    }


def test_a_clock_with_sixty_seconds_is_none_of_digits() -> None:
    found = read(VBOX + table(VBOX_ROW.replace("{digits}", "{t}5"), rows=200))
    assert (found.time_unit, found.road_test.duration) == ("s", 99.5)


def test_a_row_of_units_that_is_missing_makes_no_units_of_the_names() -> None:
    text = KNOWN["TunerStudio"][1].replace("sec\trpm\tmph\t°KW\n", "")
    found = read(text)
    assert logger_of(found) == "read as a log of TunerStudio: 'Time' in s"
    assert {column["column"]: column["unit_assumed"] for column in describe(found)["columns"]} == {
        "Time": False,
        "RPM": False,  # named by its unit
        "VSS1": True,
    }


def test_a_head_of_another_version_is_read_as_any_table_is() -> None:
    text = HALTECH.replace("%DataLog%", "Some log") + table("{clock},{rpm},35{temp},{kmh}0")
    assert "has no header" in str(read(text).problem)
    text = AIM.format(name="Some CSV File") + table('"{t}","{rpm}","{temp}","{kmh}"')
    assert (logger_of(read(text)), read(text).road_test.duration) == ("", 19.5)


@pytest.mark.parametrize(
    "text",
    [
        "[header]\nmade up\n\nTime,RPM (rpm)\n" + table("{t},{rpm}"),
        ",Stamp,RPM (rpm)\n" + table("{i},{t},{rpm}"),
        "Time (s),Stamp,RPM (rpm)\n" + table("{t},{t},{rpm}"),
        "Frame,Time,RPM\n" + table("{i},{t},{rpm}"),
        "Logger of somebody\nTime,RPM\n" + table("{t},{rpm}"),
        "timestamp,name,RPM\n" + table("{t},a,{rpm}"),
        "Time,GPS: 3,RPM\n" + table("{t},1,{rpm}"),
        "Notes: HP Tuners CSV Log File\nTime,RPM\n" + table("{t},{rpm}"),
        "Time,ID,Engine data,RPM\n" + table("{t},1,2,{rpm}"),
        "Time,Canister (%),RPM\n" + table("{t},1,{rpm}"),
        "timestamp,engine_speed,vehicle_speed\n" + table("{t},{rpm},{kmh}"),
    ],
)
def test_what_only_looks_like_a_known_logger_is_not_taken_for_one(text: str) -> None:
    found = read(text)
    assert (logger_of(found), found.road_test.duration) == ("", pytest.approx(19.5, rel=1e-9, abs=0.0))


# --- frames of a bus, and binary logs ---------------------------------------------------------------------------

FRAMES = {
    "candump": "(1436509052.249713) vcan0 0{i:02d}#9E3C000000000000",
    "candump, in columns": " (001.{i:06d})  can1  1F{i:02d}   [8]  00 11 22 33 44 55 66 77",
    "candump without stamps": "  slcan0  1F{i:02d}   [3]  00 11 22",
    "PCAN-View": "{i:6d})  {t:10.1f}  Rx         03{i:02d}  8  00 11 22 33 44 55 66 77",
    "PCAN-View 1.0": "{i:6d})  {ms}  03{i:02d}  8  00 11 22 33 44 55 66 77",
    "CRTD": "15424739{i:02d}.020305 1R11 4{i:02d} 00 11 22 33 44 55 66 77",
    "Vector ASC": "   {t:.6f} 1  1F{i:02d}             Rx   d 8 00 11 22 33 44 55 66 77",
    "SavvyCAN": "{ms},00000{i:03d},false,Rx,0,8,00,00,00,00,00,00,00,00,",
    "BUSMASTER": "{clock} Rx 1 0x1F{i:02d} s 8 00 11 22 33 44 55 66 77",
    "CSV": "{t},0x1f{i:02d},0,0,0,8,AAECAwQFBgc=",
}
HEADS = {
    "SavvyCAN": "Time Stamp,ID,Extended,Dir,Bus,LEN,D1,D2,D3,D4,D5,D6,D7,D8\n", "BUSMASTER": "***BUSMASTER Ver 3.2.2***\n",
    "CSV": "timestamp,arbitration_id,extended,remote,error,dlc,data\n", "PCAN-View 1.0": ";   made up\n;---+---\n",
}  # fmt: skip


@pytest.mark.parametrize("form", FRAMES)
def test_a_text_dump_of_can_is_called_so(form: str) -> None:
    with pytest.raises(RoadTestError) as refused:
        read(HEADS.get(form, "") + table(FRAMES[form]))
    said = str(refused.value)
    assert f"is a CAN dump ({form.split(',')[0].split(' without')[0].removesuffix(' 1.0')})" in said
    assert "decoded with the DBC and saved as CSV" in said


@pytest.mark.parametrize(
    ("name", "data", "said"),
    [
        ("a.blf", b"LOGG\x90\x00\x00\x00" + bytes(range(200)), "CAN dump (Vector BLF)"),
        ("a.tdms", b"TDSm\x0e\x00" + bytes(range(200)), "by LabVIEW, DIAdem"),
        ("a.llg", b"\xd7\x00\x00\x00lf3" + bytes(range(200)), "by PCLink"),
        ("a.hpl", bytes(range(256)) * 40, "by VCM Scanner"),
        ("a.xrk", bytes(range(256)) * 40, "by Race Studio"),
        ("a.ld", bytes(range(256)) * 40, "by i2"),
        ("a.efi", bytes(range(256)) * 40, "by EFILive"),
    ],
)
def test_a_binary_log_is_called_one_with_the_program_that_exports_it(name: str, data: bytes, said: str) -> None:
    with pytest.raises(RoadTestError) as refused:
        read(data, name=name)
    assert said in str(refused.value)
    assert "no road-test log" not in str(refused.value)


# --- JSON -------------------------------------------------------------------------------------------------------


def signals(rows: int = ROWS) -> list[dict[str, Any]]:
    """What an OpenXC interface writes, made up: a signal at a time."""
    result: list[dict[str, Any]] = []
    for i in range(rows):
        values = {"engine_speed": 800 + 10 * i, "vehicle_speed": i, "transmission_gear_position": "first" if i < 20 else "second", "ignition_status": "run", "odometer": 500.0}  # fmt: skip
        result += [{"name": name, "value": value, "timestamp": round(1_700_000_000 + i * 0.5 + at * 0.01, 2)} for at, (name, value) in enumerate(values.items())]  # fmt: skip
    return result


def lines(objects: list[Any]) -> str:
    return "".join(json.dumps(each) + "\n" for each in objects)


def test_a_signal_a_line_is_read_with_a_stamp_of_its_own() -> None:
    found = read(lines([{"metadata": {"version": "v3.0"}}, *signals()]))
    test = found.road_test
    assert (found.format, logger_of(found)) == (
        "JSON",
        "read as a log of OpenXC: 'engine_speed' in rpm, 'vehicle_speed' in km/h, 'transmission_gear_position' is gear",
    )
    assert test.duration == pytest.approx(19.54, rel=1e-6, abs=0.0)
    assert test.channels["engine_speed"].values[-1] * 60 == pytest.approx(1190, rel=1e-9, abs=0.0)
    assert test.channels["vehicle_speed"].values[-1] * 3.6 == pytest.approx(39, rel=1e-9, abs=0.0)
    assert test.channels["vehicle_speed"].samples == ROWS
    assert test.channels["gear"].values[[0, -1]].tolist() == [1.0, 2.0]


def test_a_sample_a_line_is_read_with_what_stands_in_objects_within() -> None:
    objects = [
        {"time_ms": 500 * i, "obd": {"rpm": 800 + 10 * i, "note": None}, "atf_temperature_c": 60 + i % 5, "tcc": i > 20}
        for i in range(ROWS)
    ]
    found = read(lines(objects))
    assert (logger_of(found), found.road_test.duration) == ("", 19.5)
    assert found.road_test.values("engine_speed")[-1] * 60 == pytest.approx(1190, rel=1e-9, abs=0.0)
    assert found.road_test.values("lock_up")[[0, -1]].tolist() == [0.0, 1.0]
    assert [column.label for column in log_columns(lines(objects).encode())] == [
        "time_ms",
        "obd/rpm",
        "atf_temperature_c",
        "tcc",
    ]


def test_a_line_that_breaks_off_is_left_out_and_many_are_refused() -> None:
    found = read(lines(signals()) + '{"name":"engine_sp')
    assert [message.text for message in found.messages if message.code == "lines_left_out"] == [
        "1 line(s) that are no JSON object left out"
    ]
    with pytest.raises(RoadTestError, match=r"row 3.*is no JSON object.*found 'rpm 900'"):
        read(lines(signals(1)[:2]) + "rpm 900\n" * 40)


def test_signals_of_others_state_no_units() -> None:
    found = read(lines([each for each in signals() if each["name"].endswith("speed")]))
    assert logger_of(found) == ""
    assert {column["quantity"] for column in describe(found)["columns"] if column["unit_assumed"]} == {
        "engine_speed",
        "vehicle_speed",
    }


# --- the binary form of TunerStudio -----------------------------------------------------------------------------

FIELDS = [("Time", "s", 7, ">f4", 1.0, 0.0), ("RPM", "rpm", 2, ">u2", 1.0, 0.0), ("TFT", "C", 1, "i1", 0.5, 10.0), ("flags", "bits", 10, "u1", 0.0, 0.0), ("VSS1", "mph", 4, ">u4", 0.1, 0.0)]  # fmt: skip


def binary(version: int = 1, marker_at: int = 12, rows: int = ROWS) -> bytes:
    """A log in the form that TunerStudio writes, made up, with a marker."""
    field = np.dtype([("type", "u1"), ("name", "S34"), ("unit", "S10"), ("style", "u1"), ("scale", ">f4"), ("transform", ">f4"), ("digits", "i1"), *([("category", "S34")] if version == 2 else [])])  # fmt: skip
    described = np.zeros(len(FIELDS), field)
    for place, (name, unit, kind, _, scale, transform) in enumerate(FIELDS):
        described[place]["name"], described[place]["unit"], described[place]["type"] = name, unit, kind
        described[place]["scale"], described[place]["transform"] = scale, transform
    block = np.dtype([("kind", "u1"), ("counter", "u1"), ("stamp", ">u2"), *((name, form) for name, _, _, form, *_ in FIELDS), ("sum", "u1")])  # fmt: skip
    blocks = np.zeros(rows, block)
    at = np.arange(rows)
    blocks["Time"], blocks["RPM"], blocks["TFT"], blocks["VSS1"] = at * 0.5, 800 + 10 * at, 100 + at % 5, 10 * at
    blocks["sum"] = blocks.view((np.uint8, block.itemsize))[:, 4:-1].sum(axis=1, dtype=np.uint8)
    info = b"made up\n"
    size = (22 if version == 1 else 24) + described.nbytes
    numbers = ((6, None), (2, version), (4, 1_700_000_000), (2 if version == 1 else 4, size), (4, size + len(info)), (2, block.itemsize - 5), (2, len(FIELDS)))  # fmt: skip
    head = b"".join(b"MLVLG\x00" if value is None else value.to_bytes(width, "big") for width, value in numbers)
    marker = bytes([1, 0, 0, 0]) + b"MARK 001".ljust(50, b"\x00")
    return head + described.tobytes() + info + blocks[:marker_at].tobytes() + marker + blocks[marker_at:].tobytes()


@pytest.mark.parametrize("version", [1, 2])
def test_a_binary_log_of_tunerstudio_is_read(version: int) -> None:
    found = read(binary(version), name="a.mlg")
    test = found.road_test
    assert (found.format, logger_of(found), test.rows, test.duration) == (
        "MLG",
        "read as a log of TunerStudio",
        ROWS,
        19.5,
    )
    assert test.values("engine_speed")[-1] * 60 == pytest.approx(1190, rel=1e-9, abs=0.0)
    assert test.values("atf_temperature")[-1] == pytest.approx((104 + 10) * 0.5, rel=1e-9, abs=0.0)
    assert test.values("vehicle_speed")[-1] * 3.6 / 1.609344 == pytest.approx(39, rel=1e-6, abs=0.0)
    assert [column.label for column in log_columns(binary(version))] == ["Time", "RPM", "TFT", "VSS1"]
    thinned = read_road_test(binary(version), every=3)
    assert (thinned.rows, thinned.time[1]) == (14, pytest.approx(1.5, rel=1e-6, abs=0.0))


def test_rows_of_a_binary_log_with_a_wrong_checksum_are_left_out() -> None:
    data = bytearray(binary())
    data[-5] ^= 0x40
    found = read(bytes(data))
    assert logger_of(found) == "read as a log of TunerStudio: 1 row(s) with a wrong checksum left out"
    assert found.road_test.rows == ROWS - 1
    assert read(binary()[:-3]).road_test.rows == ROWS - 1


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (binary()[:30], "damaged"),
        (binary()[:200], "damaged"),
        (binary()[:18] + b"\x00\x07" + binary()[20:], "damaged"),
        (binary().replace(b"VSS1", b"VSS2")[:-600] + bytes(range(256)) * 3, "damaged|holds no rows"),
        (binary()[:6] + b"\x00\x09" + binary()[8:], "MegaLogViewer"),
        (binary(rows=0), "holds no rows"),
    ],
)
def test_a_damaged_binary_log_is_refused(data: bytes, said: str) -> None:
    with pytest.raises(RoadTestError, match=said):
        read(data)


@pytest.mark.parametrize(
    "part", ["can", " can", "a,", "1.5 ", "(1.2) ", " \n", "ID DLC ", "[header]\na\n", "timestamp,odometer,", "x: 1 "]
)
def test_no_expression_takes_long_on_a_text_made_to_delay_it(part: str) -> None:
    with in_time():
        assert known_logger(part * (1 << 18 >> (len(part) - 1).bit_length())) is None
