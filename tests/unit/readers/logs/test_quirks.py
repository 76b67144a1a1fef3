# ruff: noqa: E501 - a case is a line, however long
"""Every quirk seen in loggers' files, one short log each, written for this test."""

from __future__ import annotations

import gzip
from dataclasses import dataclass, field

import numpy as np
import pytest

from atleak.common.errors import RoadTestError
from atleak.readers.logs import describe, read_road_test, understand
from atleak.readers.logs.understood import workshop_unit

ROWS = 40


def table(head: str, row: str, rows: int = ROWS, step: float = 0.1, comma: bool = False, end: str = "\n") -> str:
    """A log: ``row`` is formatted with i, t [s], ms, rpm, kmh, temp, kpa, gear."""
    lines = [head] if head else []
    for i in range(rows):
        line = row.format(
            i=i, t=i * step, ms=round(i * step * 1000), rpm=800 + 37 * i, kmh=float(i), mph=i * 0.621371, temp=80 + i % 5,
            tempf=(80 + i % 5) * 1.8 + 32, kpa=400 + 11 * i, bar=4 + 0.11 * i, psi=(400 + 11 * i) / 6.894757, gear=1 + i // 10,
            h=10 + (i + 55) // 60, m=(i + 55) % 60, s=i % 60,
        )  # fmt: skip
        lines.append(line.replace(".", ",") if comma else line)
    return end.join(lines) + end


@dataclass(frozen=True)
class Case:
    """A log and what must come of it; ``has``: quantity → (last value in workshop units, file's unit)."""

    data: bytes | str
    rows: int = ROWS
    duration: float = 0.1 * (ROWS - 1)
    has: dict[str, tuple[float, str]] = field(default_factory=dict)
    absent: tuple[str, ...] = ()
    ambiguous: tuple[str, ...] = ()
    codes: tuple[str, ...] = ()
    segments: int = 1
    assumed: tuple[str, ...] = ()

    @property
    def bytes(self) -> bytes:
        return self.data if isinstance(self.data, bytes) else self.data.encode("utf-8")


RPM, KMH, ATF, KPA, GEAR = 800 + 37 * 39, 39.0, 84.0, 400 + 11 * 39, 4.0
_HEAD = "Time (s),Engine Speed (rpm),ATF Temperature (°C),Vehicle Speed (km/h)"
_ROW = "{t:.2f},{rpm},{temp},{kmh}"
_BASIC = {"engine_speed": (RPM, "rpm"), "atf_temperature": (ATF, "°C"), "vehicle_speed": (KMH, "km/h")}

CASES: dict[str, Case] = {
    # --- bytes
    "utf-8 with mark": Case(b"\xef\xbb\xbf" + table(_HEAD, _ROW).encode(), has=_BASIC),
    "utf-16 le with mark": Case(b"\xff\xfe" + table(_HEAD, _ROW).encode("utf-16-le"), has=_BASIC),
    "utf-16 be with mark": Case(b"\xfe\xff" + table(_HEAD, _ROW).encode("utf-16-be"), has=_BASIC),
    "utf-16 without mark": Case(table(_HEAD, _ROW).encode("utf-16-le"), has=_BASIC),
    "cp1252": Case(table(_HEAD, _ROW).encode("cp1252"), has=_BASIC),
    "cp1252 German": Case(
        table("Zeit (s);Motordrehzahl (1/min);Getriebeöltemperatur (°C)", "{t:.2f};{rpm};{temp}", comma=True).encode("cp1252"),
        has={"engine_speed": (RPM, "rpm"), "atf_temperature": (ATF, "°C")},
    ),
    "cp1251 Russian": Case(
        table("Время (с);Обороты двигателя (об/мин);Температура масла АКПП (°C);Скорость автомобиля (км/ч)",
              "{t:.2f};{rpm};{temp};{kmh}").encode("cp1251"), has=_BASIC,
    ),
    "cp1250 Polish": Case(
        table("Czas (s);Obroty silnika (obr/min);Prędkość pojazdu (km/h);Temperatura oleju w skrzyni biegów (°C)",
              "{t:.2f};{rpm};{kmh};{temp}", comma=True).encode("cp1250"), has=_BASIC,
    ),
    "℃ is °C": Case(table("Time(s),Engine RPM(rpm),Trans Temp(℃)", "{t:.2f},{rpm},{temp}"), has={"atf_temperature": (ATF, "°C")}),
    "plain C": Case(table("Time(s),Engine RPM(rpm),ATF Temp(C)", "{t:.2f},{rpm},{temp}"), has={"atf_temperature": (ATF, "°C")}),
    "deg C": Case(table("Time(s),Engine RPM(rpm),ATF Temp(deg C)", "{t:.2f},{rpm},{temp}"), has={"atf_temperature": (ATF, "°C")}),
    "*C": Case(table("Time(s),Engine RPM(rpm),ATF Temp(*C)", "{t:.2f},{rpm},{temp}"), has={"atf_temperature": (ATF, "°C")}),
    "NUL bytes": Case(table(_HEAD, _ROW).replace(",80,", ",8\x000,").encode(), has=_BASIC),
    "CRLF": Case(table(_HEAD, _ROW, end="\r\n"), has=_BASIC),
    "CR only": Case(table(_HEAD, _ROW, end="\r"), has=_BASIC),
    "CRLF and LF mixed": Case(table(_HEAD, _ROW, end="\r\n") + table("", "{t:.2f},{rpm},{temp},{kmh}").replace("\r", "")[:0], has=_BASIC),
    "gz": Case(gzip.compress(table(_HEAD, _ROW).encode()), has=_BASIC),
    # --- delimiter and decimal sign
    "semicolon, decimal comma": Case(table(_HEAD.replace(",", ";"), _ROW.replace(",", ";"), comma=True), has=_BASIC),
    "semicolon, decimal point": Case(table(_HEAD.replace(",", ";"), _ROW.replace(",", ";")), has=_BASIC),
    "tab, decimal comma": Case(table(_HEAD.replace(",", "\t"), _ROW.replace(",", "\t"), comma=True), has=_BASIC),
    "tab, decimal point": Case(table(_HEAD.replace(",", "\t"), _ROW.replace(",", "\t")), has=_BASIC),
    "comma, semicolons in names": Case(
        table("Time (s),Engine Speed (rpm),Lambda; bank 1,Fuel; trim; long,ATF Temp (C)", "{t:.2f},{rpm},1.01,3.5,{temp}"),
        has={"engine_speed": (RPM, "rpm"), "atf_temperature": (ATF, "°C")},
    ),
    "blanks, ragged": Case(table("time[s]  rpm   speed[km/h]", "  {t:.2f}    {rpm}  {kmh}"), has={"engine_speed": (RPM, "rpm"), "vehicle_speed": (KMH, "km/h")}),
    "quoted, decimal comma and comma": Case(
        table('"Time (s)","Engine RPM (rpm)","Speed (km/h)"', '"{i},5","{rpm},25","{kmh:.0f},5"', step=1.0), duration=39.0,
        has={"engine_speed": (RPM + 0.25, "rpm"), "vehicle_speed": (39.5, "km/h")},
    ),
    "leading point and exponents": Case(
        table("Time (s),RPM,Load (%)", "{i}.500000000000E+0000,{rpm}.00376101000000E+0000,.635", step=1.0), duration=39.0,
        has={"engine_speed": (RPM + 0.00376101, "rpm")},
    ),
    "exponents with comma": Case(
        table("Time (s);RPM;x", "{i},000000E0;{rpm},500000;1,000000E-5", step=1.0), duration=39.0, has={"engine_speed": (RPM + 0.5, "rpm")},
    ),
    "words for missing": Case(
        table(_HEAD, _ROW).replace("\n0.50,985,80", "\n0.50,Not Running,80").replace(",82,", ",-,", 1).replace(",83,", ",OFF,", 1).replace(",84,", ",none,", 1),
        has=_BASIC,
    ),
    "inf and NaN": Case(table(_HEAD, _ROW).replace(",82,", ",inf,", 1).replace(",83,", ",NaN,", 1), has=_BASIC),
    "German word for not running": Case(
        table("Zeit (s);Motordrehzahl (1/min);Fahrzeuggeschwindigkeit (km/h)", "{t:.2f};{rpm};{kmh}", comma=True).replace(";837;", ";Läuft nicht;"),
        has={"engine_speed": (RPM, "rpm"), "vehicle_speed": (KMH, "km/h")},
    ),
    # --- finding the table
    "two preamble lines": Case("# StartTime = 05/05/2023 04:17:36.1827 PM\n" + table(" Time (sec), Engine RPM (RPM), Vehicle speed (MPH)", "{t:.2f}, {rpm}, {mph:.4f}"),
        has={"engine_speed": (RPM, "rpm"), "vehicle_speed": (39.0, "mph")}),
    "preamble of other widths": Case('App,Version 3\nAug 17, 2025\nVIN,XXXX,YY\n' + table(_HEAD, _ROW), has=_BASIC),
    "small table before": Case("Vehicle,Mass (kg)\nCar,1500\n\n" + table(_HEAD, _ROW), has=_BASIC),
    "small table of the same width before": Case("Vehicle,Mass (kg),Axle,Tyre\nCar,1500,3.2,2.1\n\n" + table(_HEAD, _ROW), has=_BASIC),
    "names and units rows": Case(table("Time,RPM,CLT,VSS\ns,RPM,°C,km/h", _ROW), has={"engine_speed": (RPM, "rpm"), "vehicle_speed": (KMH, "km/h"), "coolant_temperature": (ATF, "°C")}),
    "names, units, blank line": Case(table("Time,Engine Speed,ATF Temperature\n(ms),(rpm),(°C)\n", "{ms},{rpm},{temp}"), has={"engine_speed": (RPM, "rpm"), "atf_temperature": (ATF, "°C")}),
    "names, units, alias": Case(table("TimeStamp,nmot_w,vfil_w,tmot\nsec.,1/min,km/h,°C\nTIME,EngineSpeed,VehicleSpeed,CoolantTemperature", _ROW.replace("{temp},{kmh}", "{kmh},{temp}")),
        has={"engine_speed": (RPM, "rpm"), "vehicle_speed": (KMH, "km/h")}),
    "quoted signature and MARK": Case('"speeduino 202009"\n"Capture Date: Mon Jan 1"\n' + table("Time\tRPM\tMAP\tCLT\tMAP\ns\trpm\tkpa\tC\tkpa", "{t:.3f}\t{rpm}\t40\t{temp}\t41").replace("\n1.000\t", "\nMARK 001\n1.000\t"),
        has={"engine_speed": (RPM, "rpm"), "coolant_temperature": (ATF, "°C")}),
    "17 preamble lines, quoted": Case(
        "".join(f'"Key {i}","Value {i}"\n' for i in range(12)) + '"Sample Rate","10"\n"Segment Times","0:03.9"\n\n'
        + table('"Time","Engine RPM","GPS Speed"\n"s","rpm","km/h"\n', '"{t:.3f}","{rpm}","{kmh}"'),
        has={"engine_speed": (RPM, "rpm"), "vehicle_speed": (KMH, "km/h")}, codes=("second_choice",)),
    "464 preamble lines": Case("".join(f"Key {i} : some text {i},x\n" for i in range(464)) + table(_HEAD, _ROW), has=_BASIC),
    "2000 preamble lines": Case("".join(f"Key {i} : some text {i},x\n" for i in range(2000)) + table(_HEAD, "{t:.2f},900,{temp},50", rows=3000), rows=3000, duration=299.9),
    "channel blocks, no names row": Case(
        "%DataLog%\nDataLogVersion : 1.1\n"
        + "".join(f"Channel : {n}\nID : {k}\nType : {ty}\nDisplayMaxMin : {a},{b}\n" for k, (n, ty, a, b) in enumerate(
            [("RPM", "EngineSpeed", 9000, 0), ("Transmission Oil Temperature", "Temperature", 4231, 2331), ("Vehicle Speed", "Speed", 4000, 0), ("Oil Pressure", "Pressure", 11013, 1013)]))
        + "Log Source : 20\nLog Number : 7\nLog : 20250718 02:15:46\n"
        + table("", "14:15:4{i}.500,{rpm},35{temp},{kmh:.0f}0,5000", rows=10),
        rows=10, duration=9.0, has={"engine_speed": (800 + 37 * 9, "rpm"), "vehicle_speed": (9.0, "0.1 km/h"), "atf_temperature": (85.25, "0.1 K")}),
    "section markers": Case(
        "HP Tuners CSV Log File\nVersion: 1.0\n\n[Log Information]\nCreation Time: 1/2/2024 3:04:05 PM\n\n[Channel Information]\n0,12,13,2114\nOffset,Engine RPM (SAE),Vehicle Speed (SAE),Trans Fluid Temp\ns,rpm,km/h,°C\n\n[Channel Data]\n"
        + table("", "{t:.2f},{rpm},{kmh},{temp}"), has=_BASIC),
    "unit between bars": Case(table('"Interval"|"ms"|0|0|1,"Utc"|"ms"|0|0|1,"RPM"|""|0|10000|25,"Speed"|"mph"|0|150|10', "{ms},1500000{ms:06d},{rpm},{mph:.4f}"),
        has={"engine_speed": (RPM, "rpm"), "vehicle_speed": (39.0, "mph")}),
    "empty units": Case(table("TIME ( s ),ENGINE_RPM ( ),VEHICLE_SPEED ()", "{t:.2f},{rpm},{kmh}"), has={"engine_speed": (RPM, "rpm"), "vehicle_speed": (KMH, "km/h")}, assumed=("vehicle_speed",)),
    "unit twice": Case(table("Time (s) (s),Line Pressure (Bar) (Bar),Engine RPM (rpm)", "{t:.2f},{bar:.2f},{rpm}"), has={"main_pressure": (829.0, "bar"), "engine_speed": (RPM, "rpm")}),
    "brackets that are no unit": Case(table("Time(s),Speed (OBD)(km/h),O2 Volts (alternate),Catalyst Temperature (Bank 1 Sensor 1)(°C),Engine RPM(rpm)", "{t:.2f},{kmh},0.4,500,{rpm}"),
        has={"engine_speed": (RPM, "rpm"), "vehicle_speed": (KMH, "km/h")}, absent=("atf_temperature",)),
    "empty and repeated names": Case(table("Time (s),,RPM,MAP,MAP, ATF Temp (C) ,Comment", "{t:.2f},1,{rpm},40,41,{temp}"), has={"engine_speed": (RPM, "rpm"), "atf_temperature": (ATF, "°C")}),
    "more cells than names": Case(table(_HEAD, _ROW + ",7"), has=_BASIC),
    "trailing delimiter": Case(table(_HEAD, _ROW + ","), has=_BASIC),
    "comments in the middle": Case(table(_HEAD, _ROW).replace("\n2.00,", "\n# Lap 1: 00:01:02.3\n\nMARK\n2.00,"), has=_BASIC, codes=("lines_left_out",)),
    "comment with delimiters": Case(table(_HEAD, _ROW).replace("\n2.00,", "\n# Lap 1, of 3, fast\n2.00,"), has=_BASIC),
    "header repeated": Case(table(_HEAD, _ROW).replace("\n2.00,", f"\n{_HEAD}\n2.00,"), has=_BASIC, codes=("lines_left_out",)),
    "blank rows at the end": Case(table(_HEAD, _ROW) + ",,,\n,,,\n\n", has=_BASIC),
    "last line cut off": Case(table(_HEAD, _ROW)[:-3], has={"engine_speed": (RPM, "rpm")}),
    "long format": Case(
        table('"SECONDS";"PID";"VALUE";"UNITS"', '"{t:.3f}";"Engine RPM";"{rpm}";"rpm"\n"{t:.3f}";"Vehicle speed";"{kmh}";"km/h"\n"{t:.3f}";"Fuel used";"1,5";"l"'.replace("1,5", "1.5")),
        rows=3 * ROWS, has={"engine_speed": (RPM, "rpm"), "vehicle_speed": (KMH, "km/h")}),
    "time column per channel": Case(
        table("Marker,TIME,Loc. 1,TIME,Loc. 2,\n,STAMP,Engine RPM,STAMP,Vehicle speed,\n,, /min,, km/h,", ",{t:.2f},{rpm},{t:.2f}5,{kmh},"),
        has={"engine_speed": (RPM, "rpm"), "vehicle_speed": (KMH, "km/h")}),
    "time column per channel, German": Case(
        table("Marke;Zeit;Gruppe A;Zeit;Gruppe B\n;MARKE;Motordrehzahl;MARKE;Getriebeöltemperatur\n;;/min;;°C", ";{t:.2f};{rpm};{t:.2f};{temp}", comma=True),
        has={"engine_speed": (RPM, "rpm"), "atf_temperature": (ATF, "°C")}),
    "header is a date": Case(table("28.01.2016 11:46\tMotordrehzahl [1/min]\tGeschwindigkeit [km/h]", "28.01.2016 11:46:{s:02d}\t{rpm}\t{kmh}", comma=False),
        duration=39.0, has={"engine_speed": (RPM, "rpm"), "vehicle_speed": (KMH, "km/h")}),
    # --- time
    "ms": Case(table("Time (msec),Engine Speed (rpm)", "{ms},{rpm}"), has={"engine_speed": (RPM, "rpm")}),
    "ms without unit": Case(table("Time,Engine Speed (rpm)", "{ms},{rpm}", step=0.094), duration=0.094 * 39, has={"engine_speed": (RPM, "rpm")}, codes=("unit_assumed",)),
    "s in whole numbers": Case(table("Time,Engine Speed (rpm)", "{i},{rpm}"), duration=39.0, has={"engine_speed": (RPM, "rpm")}),
    "time_ms": Case(table("time_ms,engine_rpm", "{ms},{rpm}"), has={"engine_speed": (RPM, "rpm")}),
    "epoch s": Case(table("timestamp,rpm", "17000000{i:02d}.5,{rpm}", step=1), duration=39.0, has={"engine_speed": (RPM, "rpm")}),
    "epoch ms": Case(table("timestamp,rpm", "17000000{i:02d}500,{rpm}", step=1), duration=39.0, has={"engine_speed": (RPM, "rpm")}),
    "seconds since midnight": Case(table("SECONDS;RPM", "431{i:02d}.25;{rpm}"), duration=39.0, has={"engine_speed": (RPM, "rpm")}),
    "excel days": Case("Time,RPM (rpm)\n" + "".join(f"{42000 + 0.25 + i / 86400:.10f},{800 + 37 * i}\n" for i in range(40)), duration=39.0, has={"engine_speed": (RPM, "rpm")}),
    "27-Sep-2014": Case(table("GPS Time, Device Time,Engine RPM(rpm)", "-,27-Sep-2014 13:40:{s:02d}.474,{rpm}"), duration=39.0, has={"engine_speed": (RPM, "rpm")}),
    "28-oct.-2021": Case("Device Time,Engine RPM(rpm)\n" + "".join(f"{'28-oct.-2021 23:59' if i < 20 else '29-oct.-2021 00:00'}:{(40 + i) % 60:02d}.474,{800 + 37 * i}\n" for i in range(40)), duration=39.0, has={"engine_speed": (RPM, "rpm")}),
    "GPS clock with zone": Case(table("GPS Time, Device Time,Engine RPM(rpm)", "Tue Aug 21 18:21:{s:02d} MESZ 2012,21-Aug-2012 18:21:{s:02d}.5,{rpm}"), duration=39.0, has={"engine_speed": (RPM, "rpm")}),
    "weekday before": Case(table("Time,Engine RPM(rpm)", "Sam Sep 30 15:06:{s:02d}.191 2017,{rpm}"), duration=39.0, has={"engine_speed": (RPM, "rpm")}),
    "dd.mm.yyyy": Case(table("Zeit;Drehzahl (U/min)", "28.01.2016 11:46:{s:02d};{rpm}"), duration=39.0, has={"engine_speed": (RPM, "rpm")}),
    "time of day": Case(table("Time,RPM", "10:19:{s:02d}.004,{rpm}"), duration=39.0, has={"engine_speed": (RPM, "rpm")}),
    "past midnight": Case("Time,RPM\n" + "".join(f"{(86380 + i) // 3600 % 24:02d}:{(86380 + i) // 60 % 60:02d}:{(86380 + i) % 60:02d},{800 + 37 * i}\n" for i in range(40)), duration=39.0, has={"engine_speed": (RPM, "rpm")}),
    "half days past noon": Case("Time,RPM\n" + "".join(f"05/05/2023 {'11:59' if i < 20 else '12:00'}:{(40 + i) % 60:02d}.5 {'AM' if i < 20 else 'PM'},{800 + 37 * i}\n" for i in range(40)), duration=39.0, has={"engine_speed": (RPM, "rpm")}),
    "iso": Case(table("time,rpm", "2024-05-06T07:08:{s:02d}.125Z,{rpm}"), duration=39.0, has={"engine_speed": (RPM, "rpm")}),
    "hours cut off, wrapping": Case("Time,RPM\n" + "".join(f"{(59 * 60 + 50 + i) // 60 % 60}:{(50 + i) % 60:02d}.5,{800 + 37 * i}\n" for i in range(40)), duration=39.0, has={"engine_speed": (RPM, "rpm")}, codes=("clock",)),
    "total minutes": Case("Time,RPM\n" + "".join(f"72:{4354 + (i + 29) // 60}:{(i + 29) % 60:02d}.928,{800 + 37 * i}\n" for i in range(40)), duration=39.0, has={"engine_speed": (RPM, "rpm")}),
    "decimal comma in the clock": Case(table("Zeit;Drehzahl (1/min);x", "10:19:{s:02d},004;{rpm};1,5"), duration=39.0, has={"engine_speed": (RPM, "rpm")}),
    "date and time apart": Case(table("Date,Time,RPM", "2024-05-06,07:08:{s:02d},{rpm}"), duration=39.0, has={"engine_speed": (RPM, "rpm")}),
    "two clocks": Case(table("GPS Time,Device Time,RPM", "10:0{gear}:{s:02d},11:00:{s:02d}.0,{rpm}"), duration=39.0, has={"engine_speed": (RPM, "rpm")}, codes=("clocks_disagree",)),
    "stale first stamp": Case(table("Time (s),RPM", "{t:.3f},{rpm}").replace("\n0.000,", "\n71.406,"), duration=3.8, has={"engine_speed": (RPM, "rpm")}, codes=("stray_stamps",)),
    "first stamp missing": Case(table("Time (s),RPM,Speed (km/h)", "{t:.3f},{rpm},{kmh}").replace("\n0.000,", "\nNaN,"), duration=3.8, has={"engine_speed": (RPM, "rpm")}, codes=("unreadable_stamps",)),
    "equal stamps": Case("Time,RPM\n" + "".join(f"10:00:{i // 16:02d},{800 + 37 * i}\n" for i in range(40)), duration=2.0, has={"engine_speed": (RPM, "rpm")}),
    "concatenated": Case(table("Time (s),RPM", "{t:.2f},{rpm}") + table("", "{t:.2f},{rpm}"), rows=80, duration=7.8, segments=2, codes=("clock_restarted",), has={"engine_speed": (RPM, "rpm")}),
    "gap": Case(table("Time (s),RPM", "{t:.2f},{rpm}") + table("", "24078.{i:02d},{rpm}"), rows=80, duration=24078.39, segments=2, codes=("gaps",), has={"engine_speed": (RPM, "rpm")}),
    "interval in the head": Case("Delta_X\t0.1\n***End_of_Header***\n" + table("RPM (rpm)\tATF Temp (C)", "{rpm}\t{temp}"), has={"engine_speed": (RPM, "rpm")}, codes=("time_counted",)),
    "interval in the head, decimal comma": Case("Abtastintervall;0,25 s\n\n" + table("Motordrehzahl (1/min);Getriebeöltemperatur (°C)", "{rpm}.5;{temp}.0", comma=True), duration=9.75, has={"engine_speed": (RPM + 0.5, "rpm")}, codes=("time_counted",)),
    "sample rate in the head": Case("Sample Rate,10\n\n" + table("Engine RPM (rpm),ATF Temp (C),x", "{rpm},{temp},1"), has={"engine_speed": (RPM, "rpm")}, codes=("time_counted",)),
    # --- values
    "sparse columns": Case("Time (s),RPM,ATF Temp (C)\n" + "".join(f"{i / 10:.1f},{800 + 37 * i if i % 2 else ''},{80 + i % 5 if i % 10 == 9 else ''}\n" for i in range(40)), has={"engine_speed": (RPM, "rpm"), "atf_temperature": (84.0, "°C")}),
    "both unit systems": Case(table("Time (s),RPM,Trans Temp (°F),Oil Temp (°C)", "{t:.2f},{rpm},{tempf:.1f},95"), has={"atf_temperature": (ATF, "°F")}),
    "°F by its range": Case(table("Time (s),RPM,CLT,Speed (mph)", "{t:.2f},{rpm},{tempf:.1f},{mph:.4f}"), has={"coolant_temperature": (ATF, "°F")}, assumed=("coolant_temperature",)),
    "°C by its range": Case(table("Time (s),RPM,Trans Temp", "{t:.2f},{rpm},{temp}"), has={"atf_temperature": (ATF, "°C")}, assumed=("atf_temperature",)),
    "°C stated, °F meant": Case(table("Time (s),RPM,ATF Temp (C)", "{t:.2f},{rpm},{tempf:.1f}"), absent=("atf_temperature",), ambiguous=("atf_temperature",), codes=("column_misfit",)),
    "sensor volts": Case(table("Time (s),RPM,TFT(V)", "{t:.2f},{rpm},2.1"), absent=("atf_temperature",), codes=("column_misfit",)),
    "veto words": Case(
        table("Time (s),RPM,Line Pressure Correction (none),ATF Deterioration (%),Barometric pressure (kPa),Oil Pressure (kPa),Target Gear,Idle Target RPM (rpm),TCU: EPC Duty (%),Distance travelled (total) (km),Throttle Blip Gear",
              "{t:.2f},{rpm},1.0,5,100,{kpa},3,750,40,123,2"),
        has={"engine_speed": (RPM, "rpm")}, absent=("main_pressure", "atf_temperature", "gear", "converter_pressure", "lock_up")),
    "GPS speed beside speed": Case(table("Time (s),GPS Speed (m/s),Speed (OBD)(km/h),RPM", "{t:.2f},99,{kmh},{rpm}"), has={"vehicle_speed": (KMH, "km/h")}),
    "column always missing": Case(table("Time (s),RPM,Transmission Temperature(Method 1)(°C)", "{t:.2f},{rpm},-"), absent=("atf_temperature",), codes=("column_empty",)),
    "ATF always zero": Case(table("Time (s),RPM,transf", "{t:.2f},{rpm},0"), absent=("atf_temperature",), codes=("column_empty",)),
    "ATF always at the end of the scale": Case(table("Time (s),RPM,ATF Temp (°C)", "{t:.2f},{rpm},-40"), absent=("atf_temperature",), codes=("column_empty",)),
    "composite cells": Case(table("Time (s),RPM,EGR", "{t:.2f},{rpm},EGR A:34/34/0 % / EGR B:20/20/0 %"), has={"engine_speed": (RPM, "rpm")}),
    "sentinel": Case(table(_HEAD, _ROW).replace(f",{800 + 37 * 7},", ",65535,"), has=_BASIC, codes=("suspect_samples",)),
    "start-up rubbish": Case(table(_HEAD, _ROW, rows=60).replace("0.00,800,80", "0.00,800,236").replace("0.10,837,81", "0.10,837,125").replace("0.20,874,82", "0.20,874,118"), rows=60, duration=5.9, has={"atf_temperature": (ATF, "°C")}, codes=("suspect_samples",)),
    "destroyed by thousands signs": Case(table("Time (s);RPM;Speed (km/h)", "{t:.2f};-583.206.639;{kmh}"), absent=("engine_speed",), has={"vehicle_speed": (KMH, "km/h")}, codes=("column_refused",)),
    "thousands sign taken for a decimal": Case("Time (s);RPM\n" + "".join(f"{i};{'' if 700 + 37 * i < 1000 else '1.' if 700 + 37 * i < 2000 else '2.'}{(700 + 37 * i) % 1000 if 700 + 37 * i < 1000 else f'{(700 + 37 * i) % 1000:03d}'}\n" for i in range(40)), duration=39.0, absent=("engine_speed",), codes=("column_refused",)),
    "gears in words": Case("Time (s),RPM,Gear\n" + "".join(f"{i / 10:.1f},{800 + 37 * i},{['Park', 'First', 'Second', 'Third'][i // 10]}\n" for i in range(40)), has={"gear": (3.0, "")}),
    "letters beside gears": Case("Time (s),RPM,Gear\n" + "".join(f"{i / 10:.1f},{800 + 37 * i},{'PNRD1D23'[i // 5]}\n" for i in range(40)), has={"gear": (3.0, "")}, codes=("gear_not_named",)),
    "gear is a selector": Case("Time (s),RPM,Gear\n" + "".join(f"{i / 10:.1f},{800 + 37 * i},{'PRND'[i // 10]}\n" for i in range(40)), absent=("gear",), codes=("gear_is_selector",)),
    "negative gears": Case(table("Time (s),RPM,Gear", "{t:.2f},{rpm},-1"), has={"gear": (-1.0, "")}),
    "two gears": Case(table("Time (s),RPM,Current Gear,Detected Gear,TCU: Desired Gear", "{t:.2f},{rpm},{gear},2,{gear}"), absent=("gear",), ambiguous=("gear",)),
    "two that agree": Case(table("Time (s),RPM,Vehicle Speed (km/h),Vehicle Speed (mph)", "{t:.2f},{rpm},{kmh},{mph:.3f}"), has={"vehicle_speed": (KMH, "km/h")}, codes=("same_twice",)),
    "two wheel speeds": Case(table("Time (s),RPM,Front Wheel Speed (km/h),Rear Wheel Speed (km/h)", "{t:.2f},{rpm},{kmh},{i}9"), absent=("vehicle_speed",), ambiguous=("vehicle_speed",)),
    "commanded pressure": Case(table("Time (s),RPM,P/L Solenoid Valve Pressure (kPa)", "{t:.2f},{rpm},{kpa}"), has={"main_pressure": (KPA, "kPa")}, codes=("pressure_commanded",)),
    "a desired pressure alone is offered": Case(table("Time (s),RPM,Desired Line Pressure (psi)", "{t:.2f},{rpm},{psi:.2f}"), has={"commanded_pressure": (KPA, "psi")}, absent=("main_pressure",), ambiguous=("main_pressure",)),
    "measured beside desired": Case(table("Time (s),TCM.LINEPRS_D (kPa),TCM.LINEPRS_A (kPa),RPM", "{t:.2f},999,{kpa},{rpm}"), has={"main_pressure": (KPA, "kPa"), "commanded_pressure": (999.0, "kPa")}),
    "absolute pressure": Case(table("Time (s),RPM,Line Pressure (kPa abs)", "{t:.2f},{rpm},{kpa}"), has={"main_pressure": (KPA - 101.325, "kPa")}, codes=("pressure_absolute",)),
    "psi": Case(table("time [s],engine_speed [rpm],p_g [psi],p_k [bar],atf_temperature [°F],gear", "{t:.2f},{rpm},{psi:.4f},{bar},{tempf:.1f},{gear}"),
        has={"main_pressure": (KPA, "psi"), "converter_pressure": (829.0, "bar"), "atf_temperature": (ATF, "°F"), "gear": (GEAR, "")}),
    "paths as names": Case(table("time,engine/rpm,sensors/gear,drivetrain/gearSelector/position", "{t:.2f},{rpm},{gear},3"), has={"engine_speed": (RPM, "rpm"), "gear": (GEAR, ""), "selector": (3.0, "")}),
    "French": Case(table("Temps (s);Régime moteur (tr/min);Vitesse du véhicule (km/h);Température huile boîte (°C)", "{t:.2f};{rpm};{kmh};{temp}", comma=True), has=_BASIC),
    "Portuguese": Case(table("Tempo (s);RPM do motor (rpm);Velocidade do veículo (km/h);Temperatura do óleo da transmissão (°C)", "{t:.2f};{rpm};{kmh};{temp}", comma=True), has=_BASIC),
    # --- whole formats
    "groups with a clock each": Case(
        "Tuesday,15,November,2011,19:12:10,Release 10.6.4\n03G 906 021 AN,,R4 2.0l,\n\n,,Group A:,'011,,,Group B:,'003,\n,,RPM,Boost,,,RPM,Load\n,TIME,Engine Speed,Charge Pressure (specified),,TIME,Engine Speed,Engine Load\nMarker,STAMP, /min, mbar,,STAMP, /min, %\n"
        + table("", ",{t:.2f},{rpm},1000,,{t:.2f}5,{rpm},30"), has={"engine_speed": (RPM, "rpm")}, codes=("same_twice",)),
    "measurement file with two heads": Case(
        "LabVIEW Measurement\nWriter_Version\t2\nSeparator\tTab\nDecimal_Separator\t,\nDate\t2012/08/21\nTime\t16:10:08,4583\n***End_of_Header***\n\nChannels\t2\nSamples\t100\t100\nDate\t2012/08/21\t2012/08/21\nTime\t16:10:08,45\t16:10:08,45\nY_Unit_Label\tVolts\tVolts\nX0\t0,0000000000000000E+0\t0,0000000000000000E+0\nDelta_X\t0,100000\t0,100000\n***End_of_Header***\n"
        + table("X_Value\tRPM (1/min)\tATF Temp (°C)\tComment", "{t:.6f}\t{rpm}\t{temp}", comma=True), has={"engine_speed": (RPM, "rpm"), "atf_temperature": (ATF, "°C")}),
    "head repeated between blocks": Case(
        table("X_Value\tRPM (1/min)\tVoltage", "{t:.6f}\t{rpm}\t1,5", comma=True).replace("\n2,000000\t", "\nChannels\t2\t\nSamples\t100\t100\nX0\t0,0\t0,0\nX_Value\tRPM (1/min)\tVoltage\n2,000000\t"),
        has={"engine_speed": (RPM, "rpm")}, codes=("lines_left_out",)),
    "footnotes after the unit": Case(
        "# RaceRender Data: some app\n# Vehicle: none\n" + table('"Time","UTC Time","Lap","GPS_Update","Latitude","Engine Speed (rpm) *OBD","Vehicle Speed (km/h) *OBD"', "{t:.3f},17000000{i:02d}.5,0,1,48.1,{rpm},{kmh}").replace("\n2.000,", "\n# Lap 1: 00:01:02\n2.000,"),
        has={"engine_speed": (RPM, "rpm"), "vehicle_speed": (KMH, "km/h")}),
    "engine run time for a clock": Case(table("ENGINE_RUN_TINE (),ENGINE_RPM (),VEHICLE_SPEED ()", "{i},{rpm},{kmh}"), duration=39.0, has={"engine_speed": (RPM, "rpm"), "vehicle_speed": (KMH, "km/h")}, assumed=("vehicle_speed",)),
    "long format, Russian": Case(
        table('"SECONDS";"PID";"VALUE";"UNITS"', '"431{i:02d}.5";"Обороты двигателя";"{rpm}";"об/мин"\n"431{i:02d}.5";"Скорость автомобиля";"{kmh}";"км/ч"\n"431{i:02d}.6";"Температура масла АКПП";"{temp}";"℃"'),
        rows=3 * ROWS, duration=39.1, has=_BASIC),
    "long format, German": Case(
        table('"SECONDS";"PID";"VALUE";"UNITS"', '"431{i:02d}.5";"Motordrehzahl";"{rpm}";"1/min"\n"431{i:02d}.5";"Fahrzeuggeschwindigkeit";"{kmh}";"km/h"'),
        rows=2 * ROWS, duration=39.0, has={"engine_speed": (RPM, "rpm"), "vehicle_speed": (KMH, "km/h")}),
    "°F without unit": Case("Firmware 20/25,Map 2,x\nVehicle,N55\nNotes:\n\n\n" + table("timestamp,rpm,ect_psi,mph,gear,transf,waterf", "{t:.2f},{rpm},14.2,{mph:.4f},{gear},{tempf:.0f},200"),
        has={"engine_speed": (RPM, "rpm"), "vehicle_speed": (39.0, "mph"), "gear": (GEAR, ""), "atf_temperature": (183 * 5 / 9 - 160 / 9, "°F")}, assumed=("atf_temperature",)),
    "codes, descriptions shifted, units": Case(
        table("Frame,Time,Flags,ECM.RPM,TCM.TFT,TCM.TOSS,TCM.CURGEAR\nEngine Speed,Trans Fluid Temp,Output Speed,Gear\n,s,,rpm,°C,rpm,", "{i},{t:.2f},0,{rpm},{temp},{rpm},{gear}"),
        has={"engine_speed": (RPM, "rpm"), "atf_temperature": (ATF, "°C"), "output_speed": (RPM, "rpm"), "gear": (GEAR, "")}),
    "blank rows between": Case(table(_HEAD, _ROW, end="\n\n"), has=_BASIC),
    "hectopascal and pascal": Case(table("Time (s),RPM,Line Pressure (hPa),Converter Pressure (Pa)", "{t:.2f},{rpm},{kpa}0,{kpa}000"), has={"main_pressure": (KPA, "mbar"), "converter_pressure": (KPA, "Pa")}),
    "bar without unit": Case(table("Time (s),RPM,Hauptdruck", "{t:.2f},{rpm},{bar:.2f}"), has={"main_pressure": (829.0, "bar")}, assumed=("main_pressure",)),
    "thousands of rpm": Case(table("Time (s),Engine Speed (1000 rpm)", "{t:.2f},2.243"), has={"engine_speed": (2243.0, "1000 rpm")}),
    "rpm stated, thousands meant": Case(table("Time (s),Engine Speed (rpm),Speed (km/h)", "{t:.2f},2.{i}5,{kmh}"), absent=("engine_speed",), ambiguous=("engine_speed",), codes=("column_misfit",)),
    "T in °C is no time": Case(table("t (s),T (°C),RPM", "{t:.2f},{temp},{rpm}"), has={"engine_speed": (RPM, "rpm")}),
    "failed sensor": Case(table(_HEAD, _ROW).replace(",84,", ",-40,", 3), has=_BASIC, codes=("suspect_samples",)),
    "spike": Case(table(_HEAD, _ROW).replace(f",{800 + 37 * 7},", ",14000,"), has=_BASIC, codes=("suspect_samples",)),
    "small decimal cells in one column only": Case(table("Time;RPM;Load", "{i};{rpm};12,5"), duration=39.0, has={"engine_speed": (RPM, "rpm")}),
    "interval in the head, empty time column": Case(
        "Separator\tTab\nX_Columns\tNo\n***End_of_Header***\nDelta_X\t1.0E-1\t1.0E-1\n***End_of_Header***\n" + table("X_Value\tTemp1\tRPM (rpm)\tComment", "\t20.5\t{rpm}"), has={"engine_speed": (RPM, "rpm")}, codes=("time_counted",)),
    "blank cells for most channels": Case(
        table('"Interval"|"ms"|0|0|1,"RPM"|""|0|8000|25,"Speed"|"MPH"|0|150|10,"Gear"|""|0|5|10', "{ms},{rpm},,"), has={"engine_speed": (RPM, "rpm")}, codes=("column_empty",)),
    "nothing known": Case(table("Time (s),Lambda,MAF (g/s)", "{t:.2f},1.0,3.4"), codes=("no_quantity",)),
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_quirk(name: str) -> None:
    case = CASES[name]
    understood = understand(case.bytes, name="log.bin")
    described = describe(understood)
    assert described["needs"] is None
    assert described["rows"] == case.rows
    assert described["duration_s"] == pytest.approx(case.duration, abs=1e-6)
    assert len(described["segments"]) == case.segments
    columns = {column["quantity"]: column for column in described["columns"]}
    assert understood.road_test is not None
    for quantity, (last, unit) in case.has.items():
        assert quantity in columns, described["messages"]
        assert (columns[quantity]["unit"] or "") == unit
        channel = understood.road_test.channels[quantity]
        shown = workshop_unit(quantity, channel)
        good = channel.good[np.isfinite(channel.good)]
        value = shown.from_si(good[-1]) if shown else good[-1]
        assert value == pytest.approx(last, rel=1e-4, abs=0.0)
        assert columns[quantity]["unit_assumed"] is (quantity in case.assumed)
    for quantity in case.absent:
        assert quantity not in columns
    assert {question["quantity"] for question in described["ambiguous"]} == set(case.ambiguous)
    assert {message["code"] for message in described["messages"]} >= set(case.codes)


REFUSED: dict[str, tuple[bytes, str]] = {
    "empty": (b"", "empty"),
    "blank lines": (b"\r\n\r\n  \n", "empty"),
    "zeros": (bytes(300_000), "zero bytes"),
    "zeros written as digits": (b"0" * 300_000, "no table"),
    "picture": (b"\x89PNG\r\n\x1a\n" + bytes(range(256)) * 8, "PNG picture"),
    "zip bomb in gz": (gzip.compress(b"1,2,3\n" * 30_000_000), "unfolds"),
    "zeros in gz": (gzip.compress(bytes(3_000_000)), "zero bytes"),
    "damaged gz": (gzip.compress(b"Time,RPM\n1,2\n" * 500)[:60], "damaged"),
    "prose": (b"Dear customer,\nyour car is ready.\nRegards\n", "no table"),
    "no time": (table("RPM,Speed (km/h),Load (%)", "{rpm},{kmh},3").encode(), "no time column"),
    "time destroyed": (table("Time;RPM;Speed (km/h)", "1,51E+12;{rpm};{kmh}").encode(), r"1,51E\+12"),
    "no header": (table("", "{t:.2f};{rpm};{kmh};{temp}").encode(), "no header"),
    "no header, comma": (table("", "{t:.6f}\t{rpm}.5", comma=True).encode(), "no header"),
    "another header in the middle": (
        (table("Time (s),RPM,Speed (km/h)", "{t:.2f},{rpm},{kmh}") + table("Time (s),Speed (km/h),RPM", "{t:.2f},{kmh},{rpm}")).encode(),
        "another header",
    ),
    "decimal comma as delimiter": (table("Time (s),RPM,Speed (km/h)", "{i},5,{rpm},0,{kmh:.0f},5").encode(), "twice as many cells"),
    "CAN trace": (b";$FILEVERSION=1.1\n;$STARTTIME=42000.5\n" + b"".join(b"%6d) %9.1f  Rx  0280  8  01 1E 2B\n" % (i, i * 1.1) for i in range(50)), "DBC"),
    "clock that stands": (table("Time (s),RPM", "5.0,{rpm}").encode(), "no time column"),
    "interval, not time": (("Interval (ms),RPM\n" + "".join(f"{100 + 7 * i % 13},{800 + i}\n" for i in range(60))).encode(), "no time column"),
    "MDF cut off": (b"MDF     4.10    TGT 15.0" + bytes(400), "MDF"),
}  # fmt: skip


@pytest.mark.parametrize("name", REFUSED)
def test_refused_with_a_reason(name: str) -> None:
    data, reason = REFUSED[name]
    with pytest.raises(RoadTestError, match=reason) as caught:
        read_road_test(data, name="log.csv")
    assert caught.value.place.file == "log.csv"
