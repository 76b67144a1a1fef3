"""The importer beyond single quirks: mapping, memory, workbooks, MDF, JSON, tidy table, memory use."""

from __future__ import annotations

import gzip
import hashlib
import io
import json
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import openpyxl
import pytest
from hypothesis import given
from hypothesis import strategies as st

from atleak.common.errors import RoadTestError
from atleak.common.wording import wording
from atleak.job.case import Case, SourceFile
from atleak.readers.logs import (
    describe,
    forget_columns,
    read_road_test,
    recall,
    remember,
    signature,
    tidy_csv,
    understand,
)
from tests.unit.conftest import first_of

FIXTURES = Path(__file__).parent / "road_test_fixtures"

# --- the files in the folder of fixtures --------------------------------------------------------------------


def test_workshop_csv() -> None:
    test = read_road_test(FIXTURES / "workshop.csv")
    assert (test.rows, test.duration, test.delimiter, test.decimal) == (12, 1.1, ";", ",")
    assert test.values("engine_speed")[0] == pytest.approx(800 / 60, rel=1e-9, abs=0.0)
    assert test.values("main_pressure")[-1] == pytest.approx(5.5e5, rel=1e-9, abs=0.0)
    assert test.values("atf_temperature")[0] == pytest.approx(80.0, rel=1e-9, abs=0.0)
    assert test.kind("main_pressure") == "measured"
    assert test.file == "workshop.csv"
    assert len(test.sha256) == 64


def test_own_clock_per_channel_is_held_not_moved() -> None:
    test = read_road_test(FIXTURES / "clock_per_channel.csv")
    speed = test.channels["vehicle_speed"]
    assert speed.time.tolist() == pytest.approx([0.05, 0.45, 0.85, 1.25], rel=1e-9, abs=0.0)
    # at the first row's stamp the speed is not sampled yet; then the last own sample stands
    held = test.values("vehicle_speed")
    assert np.isnan(held[0])
    assert held[1:] * 3.6 == pytest.approx([10.0, 11.0, 12.0], rel=1e-9, abs=0.0)


def test_sparse_columns_hold_within_limits() -> None:
    rows = ["Time (s),RPM,ATF Temp (C)"]
    rows += [f"{i / 10:.1f},{800 + i},{80 + i / 100 if i % 5 == 0 and i < 40 else ''}" for i in range(100)]
    test = read_road_test("\n".join(rows).encode())
    atf = test.channels["atf_temperature"]
    assert atf.samples == 8
    assert atf.sampling_hz == pytest.approx(2.0, rel=1e-9, abs=0.0)
    held = test.values("atf_temperature")
    assert held[4] == 80.0
    assert held[49] == pytest.approx(80.35, rel=1e-9, abs=0.0)
    assert np.isnan(held[51:]).all(), "a sample older than three intervals is no longer true"


def test_nothing_is_held_across_a_gap() -> None:
    rows = ["Time (s),RPM,ATF Temp (C)"] + [f"{i / 10:.1f},{800 + i},{80 if i < 20 else ''}" for i in range(40)]
    rows += [f"{100 + i / 10:.1f},{900 + i},{90 if i else ''}" for i in range(20)]
    test = read_road_test("\n".join(rows).encode())
    assert len(test.segments) == 2
    held = test.values("atf_temperature")
    assert np.isnan(held[40])
    assert held[41] == 90.0


# --- mapping, units, constants ------------------------------------------------------------------------------


HEADERLESS = "".join(f"{i / 10};{800 + 10 * i};{400 + i};{85}\n" for i in range(30)).encode()


def test_headerless_needs_names_and_takes_them() -> None:
    understood = understand(HEADERLESS, name="log.txt")
    assert understood.road_test is None
    assert understood.problem is not None
    assert "column 1" in str(understood.problem)
    assert understood.preview[0] == ("0.0", "800", "400", "85")
    mapping = {"time": "column 1", "engine_speed": "2", "main_pressure": "column 3"}
    test = read_road_test(
        HEADERLESS, mapping=mapping, units={"time": "s", "engine_speed": "rpm", "main_pressure": "kPa"}
    )
    assert test.rows == 30
    assert test.duration == pytest.approx(2.9, rel=1e-9, abs=0.0)
    assert test.values("main_pressure")[0] == 400e3


def test_mapping_settles_an_ambiguity() -> None:
    text = "Time (s),Front Wheel Speed (km/h),Rear Wheel Speed (km/h)\n" + "".join(
        f"{i},{i},{i * 2}\n" for i in range(20)
    )
    understood = understand(text.encode())
    assert understood.ambiguous[0].candidates == ("Front Wheel Speed (km/h)", "Rear Wheel Speed (km/h)")
    test = read_road_test(text.encode(), mapping={"vehicle_speed": "Rear Wheel Speed"})
    assert test.values("vehicle_speed")[-1] * 3.6 == pytest.approx(38.0, rel=1e-9, abs=0.0)


def test_mapping_keeps_that_a_pressure_is_commanded() -> None:
    text = "Time (s),Desired Line Pressure (kPa)\n" + "".join(f"{i},{400 + i}\n" for i in range(20))
    test = read_road_test(text.encode(), mapping={"main_pressure": "Desired Line Pressure (kPa)"})
    assert test.kind("main_pressure") == "commanded"
    assert "pressure_commanded" in {message.code for message in test.messages}


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"mapping": {"engine_sped": "RPM"}}, "engine_speed"),
        ({"mapping": {"engine_speed": "RPN"}}, "RPM"),
        ({"units": {"engine_speed": "furlong"}}, "rpm"),
        ({"units": {"gear": "rpm"}}, "no unit"),
        ({"constants": {"nothing": 1.0}}, "engine_speed"),
        ({"constants": {"atf_temperature": 900.0}}, "ATF temperature"),
    ],
)
def test_wrong_options_are_named(options: dict[str, dict[str, str]], said: str) -> None:
    text = b"Time (s),RPM,gear\n" + b"".join(b"%d,%d,2\n" % (i, 800 + i) for i in range(10))
    with pytest.raises(RoadTestError, match=said):
        read_road_test(text, name="a.csv", **options)  # type: ignore[arg-type]


def test_constants_stand_in_for_missing_channels_only() -> None:
    text = b"Time (s),RPM,gear\n" + b"".join(b"%d,%d,2\n" % (i, 800 + i) for i in range(10))
    test = read_road_test(text, constants={"atf_temperature": 85.0, "converter_pressure": 3e5, "gear": 4.0})
    assert test.values("atf_temperature").tolist() == [85.0] * 10
    assert test.channels["atf_temperature"].source == "constant"
    assert test.values("gear").tolist() == [2.0] * 10


def test_mapping_is_remembered_by_the_header(tmp_path: Path) -> None:
    store = tmp_path / "deep" / "columns.json"
    text = b"Time (s);A;B\n" + b"".join(b"%d;%d;%d\n" % (i, 800 + i, 400 + i) for i in range(20))
    other = text.replace(b"19;", b"25;")
    understood = understand(text, remembered=store)
    assert not understood.road_test.channels
    remember(
        store,
        understood.signature,
        {"engine_speed": "A", "main_pressure": "B"},
        {"engine_speed": "rpm", "main_pressure": "kPa"},
    )
    test = read_road_test(other, remembered=store)
    assert set(test.channels) == {"engine_speed", "main_pressure"}
    assert "remembered" in {message.code for message in test.messages}
    # what the user says now counts more
    test = read_road_test(other, remembered=store, mapping={"engine_speed": "B"}, units={"main_pressure": "kPa"})
    assert test.channels["engine_speed"].column == "B"
    forget_columns(store, understood.signature)
    assert recall(store, understood.signature) is None
    store.write_text("damaged", encoding="utf-8")
    assert recall(store, understood.signature) is None


def test_a_signature_tells_columns_apart() -> None:
    assert signature(["a", "b"]) != signature(["ab"])


# --- workbooks ----------------------------------------------------------------------------------------------


def workbook(sheets: dict[str, list[list[object]]]) -> bytes:
    book = openpyxl.Workbook()
    book.remove(book.active)
    for name, rows in sheets.items():
        sheet = book.create_sheet(name)
        for row in rows:
            sheet.append(row)
    stream = io.BytesIO()
    book.save(stream)
    return stream.getvalue()


def test_workbook_with_preamble_and_gaps() -> None:
    rows: list[list[object]] = [
        ["Live data"],
        ["Car", "X"],
        ["Aug 17, 2025"],
        ["Time (s)", "Engine RPM (rpm)", "Trans Temp (°F)", "Note"],
    ]
    rows += [[i * 0.5, 800 + i, 180.0 + i % 3 if i % 4 == 0 else None, "-"] for i in range(30)]
    described = describe(understand(workbook({"Summary": [["nothing here"]], "Log": rows}), name="log.csv"))
    assert (described["format"], described["rows"], described["duration_s"]) == ("workbook", 30, 14.5)
    columns = {column["quantity"]: column for column in described["columns"]}
    assert columns["atf_temperature"]["unit"] == "°F"
    assert columns["atf_temperature"]["samples"] == 8
    assert columns["engine_speed"]["max"] == pytest.approx(829, rel=1e-9, abs=0.0)


def test_workbook_with_a_sheet_per_signal() -> None:
    def sheet(value: float, step: float) -> list[list[object]]:
        return [["Time (s)", "Value"], *([i * step, value + i] for i in range(20))]

    data = workbook(
        {"Engine RPM (rpm)": sheet(800, 0.1), "Vehicle Speed (kph)": sheet(10, 0.25), "Lambda": sheet(1, 0.5)}
    )
    test = read_road_test(data)
    assert set(test.channels) == {"engine_speed", "vehicle_speed"}
    assert test.channels["vehicle_speed"].sampling_hz == pytest.approx(4.0, rel=1e-9, abs=0.0)
    assert test.channels["engine_speed"].samples == 20


def test_a_quantity_that_one_sheet_asks_about_is_taken_from_no_other() -> None:
    pressure, speed = "Line Pressure [psi]", "Engine Speed [rpm]"
    first = [
        ["t [ms]", pressure, "t [ms]", pressure],
        *([i, 90 + i % 7, i + 50, 91 + i % 5] for i in range(0, 6000, 100)),
    ]
    second = [
        ["t [ms]", speed, "t [ms]", speed, pressure],
        *([i, 900 + i, i + 50, 9 + i, 92] for i in range(0, 6000, 100)),
    ]
    found = understand(workbook({"S1": first, "S2": second}))
    asked = {question.quantity: question.candidates for question in found.ambiguous}
    assert asked["main_pressure"] == (f"{pressure} (column 2)", f"{pressure} (column 4)", f"S2: {pressure}")
    assert "main_pressure" in found.road_test.refused
    with pytest.raises(RoadTestError, match="several sheets hold it"):
        Case(road_test=SourceFile("log.xlsx", workbook({"S1": first, "S2": second}))).diagnose()


def test_workbook_with_text_numbers_and_times() -> None:
    import datetime as dt

    rows: list[list[object]] = [["Zeit", "Motordrehzahl (1/min)", "Getriebeöltemperatur (°C)"]]
    start = dt.datetime(2024, 5, 6, 23, 59, 50)
    rows += [[start + dt.timedelta(seconds=i), f"{800 + i},5", 80.5] for i in range(20)]
    test = read_road_test(workbook({"Blatt": rows}))
    assert test.duration == pytest.approx(19.0, abs=1e-5)
    assert test.values("engine_speed")[0] * 60 == pytest.approx(800.5, rel=1e-9, abs=0.0)


def test_zip_that_is_no_workbook() -> None:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        archive.writestr("log.csv", "Time,RPM\n1,2\n")
    with pytest.raises(RoadTestError, match="ZIP archive"):
        understand(stream.getvalue())


# --- MDF ----------------------------------------------------------------------------------------------------


def mdf_bytes(signals: list[object]) -> bytes:
    asammdf = pytest.importorskip("asammdf", reason="the extra mdf is not installed")
    with asammdf.MDF(version="4.10") as mdf:
        for signal in signals:
            mdf.append([signal])
        stream = io.BytesIO()
        mdf.save(stream)
    return stream.getvalue()


@pytest.mark.filterwarnings("ignore")
def test_mdf_physical_channels() -> None:
    asammdf = pytest.importorskip("asammdf", reason="the extra mdf is not installed")
    time = np.arange(50) * 0.1
    data = mdf_bytes(
        [
            asammdf.Signal(800 + 10 * np.arange(50.0), time, name="Engine Speed", unit="rpm"),
            asammdf.Signal(176 + np.zeros(25), time[::2], name="ATF Temperature", unit="°F"),
        ]
    )
    for packed in (data, gzip.compress(data)):
        test = read_road_test(packed)
        assert test.format.startswith("MDF 4")
        assert test.rows == 50
        assert test.channels["atf_temperature"].samples == 25
        assert test.values("atf_temperature")[10] == pytest.approx(80.0, rel=1e-9, abs=0.0)


def test_without_the_extra_the_way_to_get_it_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "asammdf", None)
    with pytest.raises(RoadTestError, match=r'pip install "\.\[mdf\]"'):
        read_road_test(b"MDF     4.10    " + bytes(48) + b"##HD" + bytes(400), name="log.mf4")


@pytest.mark.filterwarnings("ignore")
def test_bus_recording_needs_a_database() -> None:
    asammdf = pytest.importorskip("asammdf", reason="the extra mdf is not installed")
    frames = np.rec.fromarrays(
        [np.full(30, 0x123, np.uint32), np.full(30, 8, np.uint8), np.tile(np.arange(8, dtype=np.uint8), (30, 1))],
        dtype=[
            ("CAN_DataFrame.ID", "<u4"),
            ("CAN_DataFrame.DataLength", "u1"),
            ("CAN_DataFrame.DataBytes", "u1", (8,)),
        ],
    )
    signal = asammdf.Signal(frames, np.arange(30) * 0.1, name="CAN_DataFrame")
    with pytest.raises(RoadTestError, match="DBC"):
        read_road_test(mdf_bytes([signal]), name="bus.mf4")


def test_obd2_answers_among_frames() -> None:
    from atleak.readers.logs.mdf_log import decode_obd2

    frames = [
        (0x7DF, [2, 0x01, 0x0C, 0, 0, 0, 0, 0]),  # a question
        (0x7E8, [4, 0x41, 0x0C, 0x1A, 0xF8, 0, 0, 0]),  # 1726 rpm
        (0x7E8, [6, 0x41, 0x0D, 50, 0x05, 0x7B, 0, 0]),  # 50 km/h and 83 °C in one frame
        (0x7E9, [4, 0x41, 0x0C, 0x00, 0x00, 0, 0, 0]),  # another control unit
        (0x18DAF110, [6, 0x41, 0xA4, 0, 0x30, 0, 0, 0]),  # third gear
        (0x7E8, [3, 0x7F, 0x01, 0x12, 0, 0, 0, 0]),  # refused
        (0x123, [4, 0x41, 0x0C, 0xFF, 0xFF, 0, 0, 0]),  # no answer
    ]
    answers = decode_obd2(
        np.arange(7.0),
        np.array([frame[0] for frame in frames]),
        np.array([frame[1] for frame in frames], dtype=np.uint8),
    )
    assert answers[0x0C][1].tolist() == [1726.0]
    assert answers[0x0D][1].tolist() == [50.0]
    assert answers[0x05][1].tolist() == [83.0]
    assert answers[0xA4][1].tolist() == [3.0]
    assert answers[0x0D][0].tolist() == [2.0]


# --- what is described --------------------------------------------------------------------------------------


def test_json_form_and_tidy_table_agree() -> None:
    understood = understand(FIXTURES / "workshop.csv")
    form = describe(understood)
    assert json.loads(json.dumps(form)) == form
    assert set(form) >= {
        "file", "sha256", "format", "encoding", "delimiter", "decimal", "rows", "duration_s", "segments", "columns",
        "ambiguous", "unused", "messages",
    }  # fmt: skip
    assert form["segments"] == [{"start_row": 0, "rows": 12, "start_s": 0.0, "duration_s": 1.1}]
    assert set(form["columns"][0]) >= {
        "quantity", "column", "unit", "unit_assumed", "kind", "samples", "min", "max", "sampling_hz",
    }  # fmt: skip
    assert form["unused"] == ["Lambda"]
    again = read_road_test(tidy_csv(understood.road_test).encode())
    assert set(again.channels) == set(understood.road_test.channels)
    for quantity in again.channels:
        assert again.values(quantity) == pytest.approx(understood.road_test.values(quantity), rel=1e-9, abs=0.0)


def test_extension_and_name_do_not_matter(tmp_path: Path) -> None:
    data = (FIXTURES / "workshop.csv").read_bytes()
    odd = tmp_path / "photo.png"
    odd.write_bytes(data)
    assert read_road_test(odd).rows == 12
    assert read_road_test(data, name="x").file == "x"
    with pytest.raises(RoadTestError, match="cannot be opened"):
        read_road_test(tmp_path / "missing.csv")


def test_large_file_reads_as_its_bytes_do(tmp_path: Path) -> None:
    lines = ["Time (s);Motordrehzahl (1/min);Hauptdruck (bar)"]
    lines += [f"{i / 100:.2f};{800 + i % 1000};{5 + i % 7 / 10:.1f}".replace(".", ",") for i in range(40_000)]
    lines[20_000] = "# Runde 2"
    path = tmp_path / "log"
    for text in ("\n".join(lines), "\n".join(lines).replace("\n0,50;", "\n0,50\x00;"), "\n".join(lines) + "\n"):
        path.write_bytes(text.encode())
        there, here = read_road_test(path), read_road_test(text.encode())
        assert there.rows == here.rows == 39_999
        assert there.sha256 == here.sha256 == hashlib.sha256(text.encode()).hexdigest()
        assert there.values("engine_speed") == pytest.approx(
            here.values("engine_speed"), nan_ok=True, rel=1e-9, abs=0.0
        )


MEASURE = """
import sys
from atleak.readers.logs import read_road_test
from atleak.common.errors import RoadTestError
try:
    read_road_test(sys.argv[1])
except RoadTestError:
    pass
with open("/proc/self/status", encoding="ascii") as status:
    print(next(line.split()[1] for line in status if line.startswith("VmHWM")))
"""


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="the system does not tell the peak memory")
@pytest.mark.parametrize("what", first_of(["log", "remarks", "zeros", "clocks", "digits"]))
def test_memory_stays_within_six_times_the_size(tmp_path: Path, what: str) -> None:
    path = tmp_path / "log.csv"
    if what == "zeros":
        with path.open("wb") as stream:
            stream.truncate(2 << 30)
    elif what == "digits":
        path.write_bytes(b"0" * (300 << 20))
    else:
        rows = [f"{i / 100:.2f},{800 + i % 997}.5,{400 + i % 91},{80 + i % 9}" for i in range(400_000)]
        if what == "remarks":
            rows[200_000:200_000] = ["# Lap", "Time (s),RPM,Line Pressure (kPa),ATF Temp (C)"]
        if what == "clocks":
            rows = [
                f"10:{i // 6000 % 60:02d}:{i // 100 % 60:02d}.{i % 100:02d}0,{row.split(',', 1)[1]}"
                for i, row in enumerate(rows)
            ]
        path.write_text("Time (s),RPM,Line Pressure (kPa),ATF Temp (C)\n" + "\n".join(rows) + "\n", encoding="utf-8")
    run = subprocess.run([sys.executable, "-c", MEASURE, str(path)], capture_output=True, text=True, check=True)
    size = 0 if what in ("zeros", "digits") else path.stat().st_size  # these are not even read
    assert int(run.stdout) / 1024 <= 6 * size / 2**20 + 200


# --- properties ---------------------------------------------------------------------------------------------


@given(
    delimiter=st.sampled_from([",", ";", "\t"]),
    comma=st.booleans(),
    encoding=st.sampled_from(["utf-8", "utf-8-sig", "utf-16", "cp1252"]),
    unit=st.sampled_from(["kPa", "bar", "psi", "MPa"]),
    preamble=st.integers(0, 30),
    rows=st.integers(8, 120),
    end=st.sampled_from(["\n", "\r\n"]),
    brackets=st.sampled_from(["[]", "()"]),
)
def test_any_dialect_gives_the_same_road_test(
    delimiter: str, comma: bool, encoding: str, unit: str, preamble: int, rows: int, end: str, brackets: str
) -> None:
    if delimiter == "," and comma:
        comma = False
    factor = {"kPa": 1e3, "bar": 1e5, "psi": 6894.757293168361, "MPa": 1e6}[unit]
    left, right = brackets
    names = [
        f"time {left}s{right}",
        f"engine_speed {left}rpm{right}",
        f"p_g {left}{unit}{right}",
        f"atf_temperature {left}°C{right}",
    ]
    lines = [f"Remark number {i}" for i in range(preamble)] + [delimiter.join(names)]
    for i in range(rows):
        cells = [f"{i * 0.05:.2f}", f"{900 + 13.5 * i:.1f}", f"{(5e5 + 1e3 * i) / factor:.6f}", f"{75 + i % 4}"]
        lines.append(delimiter.join(cell.replace(".", ",") if comma else cell for cell in cells))
    test = read_road_test((end.join(lines) + end).encode(encoding))
    assert test.rows == rows
    assert test.duration == pytest.approx(0.05 * (rows - 1), rel=1e-9, abs=0.0)
    assert test.values("engine_speed") * 60 == pytest.approx(900 + 13.5 * np.arange(rows), rel=1e-9, abs=0.0)
    assert test.values("main_pressure") == pytest.approx(5e5 + 1e3 * np.arange(rows), rel=1e-5, abs=0.0)
    assert test.values("atf_temperature") == pytest.approx(75 + np.arange(rows) % 4, rel=1e-9, abs=0.0)


@given(st.binary(max_size=3000))
def test_rubbish_is_refused_or_understood_but_never_crashes(data: bytes) -> None:
    try:
        understood = understand(data)
    except RoadTestError:
        return
    assert understood.road_test is not None or understood.problem is not None
    describe(understood)


@given(
    st.lists(
        st.lists(
            st.sampled_from(["Time", "RPM", "1", "2,5", "3.5", "-", "", "10:00:01", "Gear", "bar", "x;y", "#"]),
            min_size=1,
            max_size=5,
        ),
        max_size=30,
    ),
    st.sampled_from([",", ";", "\t"]),
)
def test_odd_tables_never_crash(rows: list[list[str]], delimiter: str) -> None:
    data = "\n".join(delimiter.join(row) for row in rows).encode()
    try:
        understood = understand(data)
    except RoadTestError:
        return
    describe(understood)


def test_a_stray_cell_in_the_last_corner_is_told_not_followed() -> None:
    """Laid out from first cell to last, such a sheet asks for half a terabyte."""
    book = openpyxl.Workbook()
    sheet = book.active
    sheet.append(["time [s]", "p_g [kPa]"])
    for i in range(20):
        sheet.append([i / 10, 700.0])
    sheet["XFD1048576"] = 1
    stream = io.BytesIO()
    book.save(stream)
    with pytest.raises(RoadTestError, match="cells far outside its table"):
        read_road_test(stream.getvalue(), name="stray.xlsx")


@pytest.mark.parametrize(
    "content",
    [bytes(range(256)) * 40, b'"\r";"a\rb"\n' * 50, b'time,"rpm\r\n1,2\r"\n' * 30],
    ids=["all bytes", "quotes", "mixed"],
)
def test_rubbish_with_quotes_and_carriage_returns_is_refused_with_a_reason(content: bytes) -> None:
    with pytest.raises(RoadTestError):
        read_road_test(content, name="rubbish.csv")


def test_what_is_said_of_a_log_is_said_in_german_with_its_quantities_and_decimal_sign() -> None:
    log = "Time;Main pressure;ATF temp;TFT;Gear\n" + "".join(
        f"{row / 10:g};{600 + row};{80 + row};{90 + row};{'D' if row < 50 else 3}\n"
        for row in [*range(60), *range(90, 99)]
    )
    understood = understand(log.encode(), name="log.csv")
    said = [wording("de").sentence(each.text) for each in understood.messages]
    assert "'Gear': D nennt keinen Gang, daher ist er bei 50 von 69 Werten nicht bekannt" in said
    assert (
        "'Main pressure' nennt keine Einheit; angenommen wird kPa (Hauptdruck): die Einheit bestätigen oder nennen"
        in said
    )
    assert "ATF-Temperatur: mehrere Spalten kommen in Frage: 'ATF temp', 'TFT'; eine davon wählen" in said
    assert "1 Lücke(n) in der Aufzeichnung, die längste 3,1 s: nichts wird aufgefüllt" in said
    problem = understand(b"a;b\n" + b"1;2\n" * 20, name="x.csv").problem
    assert problem is not None
    assert wording("de").sentence(problem.sentence).startswith("x.csv: keine Zeitspalte (gefunden: 'a, b'); erwartet: ")
    absolute = "Time (s),Line pressure (kPa abs)\n" + "".join(f"{row / 10:g},{700 + row}\n" for row in range(60))
    said = [wording("de", "us").sentence(each.text) for each in understand(absolute.encode(), name="x").messages]
    assert any("ist absolut; 14,696 psi werden abgezogen" in each for each in said), said
