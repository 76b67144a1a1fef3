# ruff: noqa: E501 - a case is a line, however long
"""The importer's parts by themselves: names, clocks, segments, units by value, checks."""

from __future__ import annotations

import itertools

import numpy as np
import pandas as pd
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from atleak.readers.dates import day_number, likely_order, month
from atleak.readers.logs import read_road_test, suspects
from atleak.readers.logs.clock import Motion, numeric_clock, text_clock
from atleak.readers.logs.log_table import find_dialect
from atleak.readers.logs.names import gear_of, match_name, name_kind, selector_of, split_unit, switch_of
from atleak.readers.logs.text_lines import to_text
from atleak.readers.logs.timeline import build, gap_limit
from atleak.readers.logs.units import fit

# --- names: every one seen, per quantity --------------------------------------------------------------------

SEEN = {
    "time": [
        "Time", "TIME", "time", "Time (sec)", "Time(s)", "Time[s]", "Time (msec)", "time(ms)", "Duration", "timestamp", "timestamp_s", "TimeStamp", "logtime",
        "SECONDS", "Interval", "Utc", "UTC Time", "Device Time", "GPS Time", "elapsed_time", "STAMP", "Zeit", "MARKE", "CZAS", "ZAPISU", "X_Value", "Offset",
    ],
    "engine_speed": [
        "RPM", "rpm", "engine_rpm", "Engine RPM(rpm)", "Engine RPM (rpm)", "ENGINE_RPM ()", "Engine Speed (rpm)", "Engine Speed", "Engine speed", "engine/rpm", "RPM(1/min)",
        "nmot_w", "Engine - Speed", "Motordrehzahl", "Drehzahl", "Обороты двигателя", "Obroty silnika", "PLX Engine Speed", "Zt-2 RPM", "Eng_Spd", "Engine RPM (SAE)", "ECM.RPM",
        "PCM.RPM", "ECM.RPM_F",
    ],
    "turbine_speed": [
        "Turbine Revolution Speed (rpm)", "AT Turbine Speed 1 (rpm)", "AT Turbine Speed 2 (rpm)", "turbine_rpm", "n2", "n3", "TCU: Input Shaft Speed", "Trans Input Shaft RPM",
        "TCM.TISS", "TSS",
    ],
    "output_speed": ["tailshaft_rpm", "Driveshaft RPM", "Trans Output Shaft RPM", "TCM.TOSS", "TCM.OSS", "ECM.TOS", "OSS"],
    "atf_temperature": [
        "ATF Temperature (C)", "Trans Temp (°F)", "transf", "Transmission Temperature(Method 1)(°C)", "Transmission Temperature(Method 2)(°C)", "TFT", "Transmission fluid temp", "Trans Fluid Temp", "Gearbox Oil T",
        "Trans Temp (°C)", "Transmission Fluid Temperature Sensor 1 (°F)", "TCM.TFT", "AT – ATF Temperature", "ATF Temperature 2", "ATF Temperature (Lookup)", "Automatic Transmission Fluid Temp (ATF)", "A/T Oil Temperature 1",
        "Getriebeöltemperatur", "Getriebeoeltemperatur", "Transmissionsoljetemperatur", "Temperatura oleju w skrzyni biegów", "Température huile boîte", "Temperatura do óleo da transmissão",
    ],
    "main_pressure": ["Gearbox Oil Pres", "P/L Solenoid Valve Pressure (kPa)", "Line Pressure", "Trans Line Pressure", "TCM.LINEPRS_A", "TCM.LINEPRSA", "EPC", "hydraulic oil pressure actual", "MPC", "p_g"],
    "commanded_pressure": ["TCM.LINEPRS_D", "TCM.LINEPRSD", "Desired Line Pressure (psi)", "line pressure commanded"],
    "converter_pressure": ["p_k", "Converter Pressure (kPa)", "Torque converter pressure", "Wandlerdruck"],
    "lock_up": ["L/U Solenoid Valve Pressure (kPa)", "TCU: TC Duty", "TCM.TCCPCSCP", "TCM.TCCDC", "TCC Duty Cycle"],
    "gear": [
        "Gear Position (gear)", "Gear", "gear", "Gear Position (Gear)", "Current Gear ()", "Current Gear (-)", "Detected Gear", "sensors/gear", "evalGear", "gangi", "GEAR", "Trans Current Gear", "TCM.CURGEAR", "TCM.GEAR",
    ],
    "selector": ["drivetrain/gearSelector/position", "drivetrain/gearbox/dsg/gearSelectorPosition", "TCU: Current Range", "TCM.PRNDL"],
    "vehicle_speed": [
        "Vehicle Speed", "Vehicle speed", "Vehicle Speed (km/h)", "Vehicle Speed (kph)", "Vehicle Speed (Mph)", "Vehicle speed (MPH)", "VEHICLE_SPEED ()", "Speed (OBD)(km/h)", "Speed (OBD)(mph)", "Speed", "mph", "VehicleSpeed",
        "Front Wheel Speed (km/h)", "Rear Wheel Speed (km/h)", "Wheel Speed FL (mph)", "Dyno_Spd[mph]", "Скорость автомобиля", "vfil_w", "GPS Speed", "SpeedVeh", "VSS1", "Vehicle Speed (SAE)", "ECM.VSS", "Prędkość pojazdu", "Vitesse du véhicule", "Velocidade do veículo",
    ],
}  # fmt: skip


@pytest.mark.parametrize(("quantity", "name"), [(quantity, name) for quantity, names in SEEN.items() for name in names])
def test_seen_names_are_known(quantity: str, name: str) -> None:
    match = match_name(split_unit(name).text)
    assert match is not None
    assert match.quantity == quantity


@pytest.mark.parametrize(
    "name",
    [
        "Line Pressure Correction (none)", "ATF Deterioration (%)", "Barometric pressure (kPa)", "Oil Pressure (psi)", "Distance travelled (total)", "Throttle Blip Gear", "TCU: Desired Gear", "TCM.CMDGEAR", "Trans Commanded Gear",
        "TCU: EPC Duty (%)", "TCM.LINEPRSDC", "EPC_V", "Fwd/B Solenoid Valve Target Pressure (kPa)", "D/C Solenoid Valve Pressure (kPa)", "AWD Solenoid Valve Pressure (kPa)", "tc_slip_ratio", "TCC Slip", "Engine Load(%)",
        "Engine Coolant Temperature Raw", "Intake Air Temperature(°C)", "Oil Temp (°C)", "Odometer(from ECU)(km)", "Idle Target RPM", "RPM Limit", "Average speed", "Fan Speed", "Fuel Rail Pressure", "Cooling Fan RPM", "G(x)", "Turbo Speed",
        "drivetrain/gearbox/dsg/nextGear", "No", "TCC Pressure", "TCM.TCCP", "Range (km)", "TFTV(V)", "Engine torque", "Accel Position (%)", "Altitude", "Longitude", "Trip Time(Since journey start)(s)",
    ],
)  # fmt: skip
def test_names_that_only_resemble_are_not_taken(name: str) -> None:
    match = match_name(split_unit(name).text)
    assert match is None or match.tier == 2


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("p_g", "measured"),
        ("P/L Solenoid Valve Pressure", "commanded"),
        ("Line Pressure", "unknown"),
        ("TCM.LINEPRSA", "measured"),
        ("Desired Line Pressure", "commanded"),
    ],
)
def test_kind_of_a_pressure(name: str, kind: str) -> None:
    match = match_name(name)
    assert match is not None
    assert match.kind == kind


def test_kind_from_words_alone() -> None:
    assert name_kind("Druck Solldruck") == "commanded"
    assert name_kind("gauge 2") == "measured"
    assert name_kind("channel 4") == "unknown"


# --- clocks -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("values", "unit", "name", "assumed"),
    [
        ([0.0, 0.1, 0.2, 0.31], None, "s", False),
        ([31, 125, 219, 313, 406], None, "ms", True),
        ([0, 1, 2, 3, 4], None, "s", True),
        ([1.7e9, 1.7e9 + 1], None, "s", False),
        ([1.7e12, 1.7e12 + 100], None, "ms", False),
        ([0, 40_000, 80_000], None, "µs", True),
        ([0, 250], "msec", "ms", False),
        ([45000.5, 45000.5 + 1 / 86400, 45000.5 + 2 / 86400], None, "d", False),
        ([1.7e12, 1.7e12 + 100], "s", "ms", False),
    ],
)
def test_time_unit(values: list[float], unit: str | None, name: str, assumed: bool) -> None:
    clock = numeric_clock(np.array(values, float), unit)
    assert (clock.unit, clock.unit_assumed) == (name, assumed)


def test_what_the_car_can_do_tells_seconds_from_milliseconds() -> None:
    slow = np.arange(40) * 10.0
    engine = 1500 + 700 * np.sin(np.arange(40) / 2)
    assert numeric_clock(slow, None).unit == "ms"
    assert numeric_clock(slow, None, [Motion(engine, 12000.0)]).unit == "s"


def test_an_epoch_that_was_not_set_yet_is_unreadable() -> None:
    seconds = numeric_clock(np.array([0.0, 0.0, 1.7e12, 1.7e12 + 500, 1.7e12 + 1000]), "ms").seconds
    assert np.isnan(seconds[:2]).all()
    assert seconds[2:].tolist() == [0.0, 0.5, 1.0]


@given(
    start=st.datetimes(min_value=pd.Timestamp("2001-01-01"), max_value=pd.Timestamp("2035-12-31")),
    steps=st.lists(st.integers(0, 5_000_000), min_size=3, max_size=40),
    form=st.sampled_from(
        ["%Y-%m-%d %H:%M:%S.%f", "%d.%m.%Y %H:%M:%S.%f", "%Y-%m-%dT%H:%M:%S.%fZ", "%d-%b-%Y %H:%M:%S.%f",
         "%Y%m%d %H:%M:%S.%f", "%a %b %d %H:%M:%S.%f %Y"]
    ),
)  # fmt: skip
def test_clock_strings_agree_with_the_calendar(start: pd.Timestamp, steps: list[int], form: str) -> None:
    stamps = pd.Timestamp(start).floor("us") + pd.to_timedelta(np.cumsum(steps), unit="ms")
    clock = text_clock(pd.Series([stamp.strftime(form) for stamp in stamps]))
    assert clock is not None
    expected = (stamps - stamps[0]).total_seconds()
    assert clock.seconds == pytest.approx(expected, abs=2e-6)


def test_clock_of_varying_width_and_missing_cells() -> None:
    clock = text_clock(pd.Series(["9:59:58.5", "9:59:59", None, "10:00:00.25", "rubbish", "10:00:01"]))
    assert clock is not None
    assert clock.seconds.tolist() == pytest.approx(
        [0.0, 0.5, np.nan, 1.75, np.nan, 2.5], nan_ok=True, rel=1e-9, abs=0.0
    )


def test_hours_and_minutes_alone_are_no_clock() -> None:
    assert text_clock(pd.Series(["10:01", "10:02", "10:03"])) is None


def test_dates() -> None:
    assert day_number("05/06/2024", "mdy") - day_number("05/06/2024", "dmy") == -31 + 1
    assert likely_order(["13/01/2024"], [None]) == "dmy"
    assert likely_order(["01/13/2024"], [None]) == "mdy"
    assert day_number("31.02.2024") is None
    months = [month(name) for name in ("Mai", "octobre", "wrz", "янв", "dez.", "Sam", "mardi")]
    assert months == [5, 10, 9, 1, 12, None, None]


@pytest.mark.parametrize(
    ("stamps", "date"),
    [
        (["2026-03-14 07:08:00", "2026-03-14 07:08:01"], "2026-03-14"),
        (["14/03/2026 07:08:00", "14/03/2026 07:08:01"], "2026-03-14"),
        (["04.03.2026 23:59:59", "05.03.2026 00:00:00"], "2026-03-04"),
        (["27-Sep-2014 07:08:00", "27-Sep-2014 07:08:01"], "2014-09-27"),
        (["03/04/2026 07:08:00", "03/04/2026 07:08:01"], None),  # March or April
        (["07:08:00", "07:08:01"], None),
    ],
)
def test_the_date_of_a_log_is_taken_where_it_cannot_be_mistaken(stamps: list[str], date: str | None) -> None:
    clock = text_clock(pd.Series(stamps))
    assert (clock.date and clock.date.isoformat()) == date


def test_the_date_of_a_log_by_numbers() -> None:
    day = 1_773_446_400.0  # 2026-03-14, 00:00 UTC
    epochs = {"s": day, "ms": day * 1e3, "µs": day * 1e6}
    for factor, first in epochs.items():
        step = {"s": 1.0, "ms": 1e3, "µs": 1e6}[factor]
        clock = numeric_clock(first + step * np.arange(1.0, 40.0), None)
        assert (clock.unit, clock.date.isoformat()) == (factor, "2026-03-14")
    assert numeric_clock(46095.0 + np.arange(40) / 86400.0, None).date.isoformat() == "2026-03-14"
    assert numeric_clock(np.arange(40) / 10.0, None).date is None
    text = "".join(f"2026-03-14 07:08:{second:02d},{800 + second},{500 + second}\n" for second in range(40))
    assert read_road_test(f"Time,RPM,Line Pressure (kPa)\n{text}".encode()).date.isoformat() == "2026-03-14"
    assert read_road_test(f"Time,RPM,Line Pressure (kPa)\n{text.replace('2026-03-14 ', '')}".encode()).date is None


# --- segments -----------------------------------------------------------------------------------------------


def test_jitter_is_put_in_order_and_restarts_are_kept_apart() -> None:
    line = build(np.array([0.0, 0.1, 0.3, 0.2, 0.4, 0.5, 0.6]))
    assert line.time.tolist() == [0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6]
    assert line.order.tolist() == [0, 1, 3, 2, 4, 5, 6]
    assert len(line.segments) == 1
    line = build(np.concatenate([np.arange(20) * 0.1, np.arange(30) * 0.1]))
    assert [segment.rows for segment in line.segments] == [20, 30]
    assert line.duration == pytest.approx(1.9 + 2.9, rel=1e-9, abs=0.0)
    assert (np.diff(line.time) >= 0).all()


@given(st.lists(st.one_of(st.floats(0, 1e5), st.just(float("nan"))), min_size=1, max_size=60))
@example([32770.5870884603, 1.8528981677700358])
def test_time_base_is_always_ascending(stamps: list[float]) -> None:
    line = build(np.array(stamps))
    assert (np.diff(line.time) >= 0).all()
    assert sum(segment.rows for segment in line.segments) == len(line.time)
    assert line.duration >= -1e-9
    for earlier, later in itertools.pairwise(line.segments):
        assert later.start >= earlier.stop


def test_gap_limit() -> None:
    assert gap_limit(np.full(100, 0.32)) == pytest.approx(1.12, rel=1e-9, abs=0.0)
    uneven = np.tile([0.002, 0.002, 0.6], 100)
    assert gap_limit(uneven) == pytest.approx(3.0, rel=1e-9, abs=0.0)


# --- units by value -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("quantity", "stated", "values", "near", "unit", "assumed"),
    [
        ("atf_temperature", None, [80, 90, 97], (), "°C", True),
        ("atf_temperature", None, [175, 179.6], (), "°F", True),
        ("atf_temperature", None, [100, 120], ("mph", "psi"), "°F", True),
        ("atf_temperature", "°F", [175, 190], (), "°F", False),
        ("main_pressure", None, [5.2, 12.4], (), "bar", True),
        ("main_pressure", None, [60, 200], (), "psi", True),
        ("main_pressure", None, [400, 1700], (), "kPa", True),
        ("main_pressure", None, [0.5, 1.7], (), "MPa", True),
        ("main_pressure", None, [5000, 17000], (), "mbar", True),
        ("vehicle_speed", None, [0, 60], (), "km/h", True),
        ("vehicle_speed", None, [0, 60], ("°F",), "mph", True),
        ("engine_speed", None, [700, 3000], (), "rpm", True),
    ],
)
def test_unit_by_value(
    quantity: str, stated: str | None, values: list[float], near: tuple[str, ...], unit: str, assumed: bool
) -> None:
    column_fit = fit(quantity, stated, np.array(values, float), near)
    assert column_fit.unit.name == unit
    assert column_fit.assumed is assumed


@pytest.mark.parametrize(
    ("quantity", "stated", "values"),
    [
        ("atf_temperature", "V", [2.1, 2.2]),
        ("atf_temperature", "°C", [175, 190]),
        ("engine_speed", "rpm", [0.8, 6.35]),
        ("engine_speed", None, [0.8, 6.3]),
        ("main_pressure", "%", [40, 50]),
        ("main_pressure", "kPa", [4.1, 17.0]),
        ("gear", None, [3.45, 2.1]),
        ("gear", None, [900, 1200]),
    ],
)
def test_values_that_contradict_are_refused(quantity: str, stated: str | None, values: list[float]) -> None:
    assert fit(quantity, stated, np.array(values, float)).problem


# --- words --------------------------------------------------------------------------------------------------


def test_words_as_numbers() -> None:
    assert [gear_of(word) for word in ("First", "2nd", "3. Gang", "R", "Neutral", "D4")] == [1, 2, 3, -1, 0, 4]
    assert np.isnan(gear_of("Sport"))
    assert [selector_of(word) for word in ("P", "R", "N", "D", "3")] == [-2, -1, 0, 10, 3]
    assert [switch_of(word) for word in ("On", "unlocked")] == [1, 0]


# --- checks: Series in, boolean Series out, True is suspect -------------------------------------------------


def test_checks_keep_the_index_and_say_true_where_suspect() -> None:
    index = np.arange(60) * 0.5
    lively = pd.Series(800 + 50 * np.sin(np.arange(60)), index)
    for mask in (
        suspects.sentinel(lively), suspects.out_of_range(lively, 0, 9000), suspects.spikes(lively, 500.0),
        suspects.frozen(lively, 10.0), suspects.start_up(lively, 200.0), suspects.failed_sensor(lively * 0 + 80),
    ):  # fmt: skip
        assert mask.dtype == bool
        assert mask.index.equals(lively.index)
        assert not mask.any()


def test_each_check_finds_its_fault() -> None:
    index = np.arange(60) * 0.5
    values = 800 + 50 * np.sin(np.arange(60.0))
    spiked = values.copy()
    spiked[30] = 9000
    assert suspects.spikes(pd.Series(spiked, index), 2000).to_numpy().nonzero()[0].tolist() == [30]
    stepped = np.where(np.arange(60) < 30, 800.0, 4000.0)
    assert not suspects.spikes(pd.Series(stepped, index), 2000).any(), "a step that stays is no spike"
    stuck = values.copy()
    stuck[10:50] = 812.0
    assert suspects.frozen(pd.Series(stuck, index), 10.0).sum() == 40
    assert not suspects.frozen(pd.Series(stuck, index), 10.0, lambda: np.zeros(60, bool)).any()
    assert not suspects.frozen(pd.Series(np.zeros(60), index), 10.0).any(), "a car that stands is not frozen"
    rubbish = np.concatenate([[236.0, 125.0], np.full(58, 80.0)])
    assert suspects.start_up(pd.Series(rubbish, index), 8.0).sum() == 2
    ends = np.concatenate([np.full(58, 80.0), [0.0, 0.0]])
    assert suspects.start_up(pd.Series(ends, index), 8.0).to_numpy().nonzero()[0].tolist() == [58, 59]
    assert suspects.sentinel(pd.Series([80.0, -2147483617.0, 81.0])).tolist() == [False, True, False]
    assert suspects.failed_sensor(pd.Series([80.0, -40.0, 81.0])).tolist() == [False, True, False]
    assert suspects.out_of_range(pd.Series([80.0, np.nan, 250.0]), -50, 200).tolist() == [False, False, True]


def test_sample_and_hold_is_told_from_a_quiet_signal() -> None:
    noise = np.random.default_rng(3)
    true = np.cumsum(noise.integers(-40, 41, 400)).astype(float)
    assert not suspects.is_sample_and_hold(true)
    assert suspects.is_sample_and_hold(np.repeat(np.round(1500 + 700 * np.sin(np.arange(100) / 7)), 4))
    assert not suspects.is_sample_and_hold(np.repeat(np.arange(100.0), 4)), "a slow signal in steps of its resolution"


# --- text ---------------------------------------------------------------------------------------------------


def test_dialect_is_decided_over_many_lines() -> None:
    assert find_dialect(["a;b,c;d", "1;2,5;3", "2;2,75;4"]).decimal == ","
    assert find_dialect(["1,2,3", "4,5,6"]).delimiter == ","
    assert find_dialect(["just words", "no table"]) is None


@pytest.mark.parametrize(
    ("data", "encoding"),
    [
        ("Öl".encode("utf-8-sig"), "utf-8-sig"),
        ("Öl".encode("utf-16"), "utf-16"),
        ("Getriebeöl °C".encode("cp1252"), "cp1252"),
        ("Обороты двигателя".encode("cp1251"), "cp1251"),
        ("Prędkość, wału".encode("cp1250"), "cp1250"),
        ("Обороты".encode(), "utf-8"),
    ],
)
def test_encoding(data: bytes, encoding: str) -> None:
    text = to_text(data)
    assert text.encoding == encoding
    assert text.decode(text.data).strip("\ufeff") == data.decode(encoding)
