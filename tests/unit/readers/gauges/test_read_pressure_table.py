"""Tables of gauge readings, as workshops write them."""

from __future__ import annotations

import datetime as dt
import io
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import openpyxl
import pytest
from hypothesis import given
from hypothesis import strategies as st

from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import load_controller
from atleak.common.errors import InputError, PressureTableError
from atleak.common.wording import wording
from atleak.measurements.gauge_readings import LINE_TAP, Engine, GaugeCell, PressureTable, ranges_of
from atleak.readers.gauges.gauge_table import read_pressure_table
from atleak.readers.sheets.measuring_sheet import read_readings
from atleak.report.sheets.measuring_sheet import write_template

UNITS = {"kPa": 1e3, "bar": 1e5, "psi": 6894.757293168361, "MPa": 1e6}


@pytest.fixture(scope="module")
def unit() -> Controller:
    """A unit with a circuit that has a gauge port of its own."""
    circuits: Any = (SimpleNamespace(id="clutch_c1", name="clutch C1 apply", gears=frozenset({1, 2})),)
    return replace(load_controller("four_speed_2023"), circuits=circuits)


def read(text: str, unit: Controller) -> PressureTable:
    return read_pressure_table(text.encode(), unit, name="gauges.csv")


def kpa(table: PressureTable) -> dict[tuple[str, str, str], float]:
    return {
        (each.cell.range, each.cell.engine.value, each.cell.tap): round(each.pressure / 1e3, 6)
        for each in table.readings
    }


def refused(text: str | bytes, unit: Controller) -> PressureTableError:
    with pytest.raises(PressureTableError) as caught:
        read_pressure_table(text.encode() if isinstance(text, str) else text, unit, name="gauges.csv")
    return caught.value


def workbook(*sheets: tuple[str, Sequence[Sequence[Any]]], merged: Sequence[str] = ()) -> bytes:
    book = openpyxl.Workbook()
    book.remove(book.active)
    for name, rows in sheets:
        sheet = book.create_sheet(name)
        for row in rows:
            sheet.append(list(row))
        for cells in merged:
            sheet.merge_cells(cells)
    target = io.BytesIO()
    book.save(target)
    return target.getvalue()


# --- layouts


def test_ranges_in_rows_and_engine_in_columns_and_an_empty_cell_was_not_measured(unit: Controller) -> None:
    table = read("range;slow idle [kPa];fast idle [kPa];stall [kPa]\nD;412,5;;1100\nR;–;600;\n", unit)
    assert kpa(table) == {
        ("D", "slow_idle", LINE_TAP): 412.5,
        ("D", "stall", LINE_TAP): 1100.0,
        ("R", "fast_idle", LINE_TAP): 600.0,
    }
    assert (table.sheet, table.units) == (None, ("kPa",))
    assert table.readings[0].place.row == 2
    assert table.readings[0].place.column == "slow idle [kPa]"


def test_ranges_in_columns_and_a_column_of_states_that_has_no_heading(unit: Controller) -> None:
    table = read(";P;R;N;D;2;1\nslow idle;3,9 bar;4,1 bar;;4.00 bar;;\nstall;;;;1,1 MPa;;\n", unit)
    assert kpa(table) == {
        ("P", "slow_idle", LINE_TAP): 390.0,
        ("R", "slow_idle", LINE_TAP): 410.0,
        ("D", "slow_idle", LINE_TAP): 400.0,
        ("D", "stall", LINE_TAP): 1100.0,
    }


def test_one_reading_a_row_with_headings_in_any_order(unit: Controller) -> None:
    head = "Pressure [psi],ATF temp [F],Tap,State,rpm,Range\n"
    table = read(f"{head}60.5,176,main pressure,idle,700,drive\n55,176,Clutch C1 apply,stall,,D\n", unit)
    first, second = table.readings
    assert first.cell == GaugeCell("D", Engine.SLOW_IDLE, LINE_TAP)
    assert first.pressure == pytest.approx(60.5 * UNITS["psi"], abs=1e-6)
    assert first.temperature == pytest.approx(80.0, abs=1e-9)
    assert first.engine_speed == pytest.approx(700.0 / 60.0, abs=1e-9)
    assert second.cell == GaugeCell("D", Engine.STALL, "clutch_c1")
    assert second.engine_speed is None


def test_taps_in_columns(unit: Controller) -> None:
    table = read("range;engine;line [bar];clutch_c1 [bar]\nD;Leerlauf;4,1;3,0\n", unit)
    assert kpa(table) == {("D", "slow_idle", LINE_TAP): 410.0, ("D", "slow_idle", "clutch_c1"): 300.0}


def test_two_rows_of_headings_merged_over_one_another(unit: Controller) -> None:
    rows = [
        ["", "slow idle", None, "stall", None],
        ["range", "line [kPa]", "C1 apply", "line [kPa]", ""],
        ["D", 410, "", 1100, ""],
    ]
    rows[1] = ["range", "line [kPa]", "clutch_c1 [kPa]", "line [kPa]", "clutch_c1 [kPa]"]
    rows[2] = ["D", 410, 300, 1100, 990]
    data = workbook(("Drucktabelle", rows), merged=("B1:C1", "D1:E1"))
    table = read_pressure_table(data, unit, name="two.xlsx")
    assert kpa(table) == {
        ("D", "slow_idle", LINE_TAP): 410.0,
        ("D", "slow_idle", "clutch_c1"): 300.0,
        ("D", "stall", LINE_TAP): 1100.0,
        ("D", "stall", "clutch_c1"): 990.0,
    }
    assert table.sheet == "Drucktabelle"
    assert table.readings[-1].place.column == "E"


def test_a_title_says_what_all_readings_below_it_have_in_common(unit: Controller) -> None:
    text = "Gauge at clutch C1 apply\nrange;slow idle [kPa]\nD;400\n\nLine\nrange;slow idle [kPa]\nD;410\n"
    assert kpa(read(text, unit)) == {("D", "slow_idle", "clutch_c1"): 400.0, ("D", "slow_idle", LINE_TAP): 410.0}


def test_unit_and_temperature_above_the_table_hold_for_all_of_it(unit: Controller) -> None:
    table = read("Unit: bar\nATF temperature;82,5 °C\nrange;slow idle;fast idle 2000 rpm\nD;4,5;5\n", unit)
    slow, fast = table.readings
    assert (slow.pressure, slow.temperature) == (450e3, 82.5)
    assert slow.engine_speed is None
    assert fast.engine_speed == pytest.approx(2000.0 / 60.0, abs=1e-9)


def test_a_table_that_names_no_tap_is_the_lines_and_says_so(unit: Controller) -> None:
    table = read("range;stall [kPa]\nD;1100\n", unit)
    assert [message.code for message in table.messages] == ["read_as", "tap_assumed"]


def test_permissible_values_beside_the_readings_are_left_aside_and_named(unit: Controller) -> None:
    data = workbook(
        ("Pressures", [["range", "stall [kPa]", "permissible low [kPa]", "remark"], ["D", 1100, 1000, "cold"]])
    )
    table = read_pressure_table(data, unit, name="p.xlsx")
    assert kpa(table) == {("D", "stall", LINE_TAP): 1100.0}
    assert any("permissible low" in message.text for message in table.messages)


def test_numbers_keep_their_digits_in_a_workbook(unit: Controller) -> None:
    data = workbook(("P", [["range", "stall [MPa]"], ["D", 1.034], [3.0, "0,987"]]))
    assert kpa(read_pressure_table(data, unit)) == {("D", "stall", LINE_TAP): 1034.0, ("3", "stall", LINE_TAP): 987.0}


# --- times and gauges


@pytest.mark.parametrize(
    ("heading", "written", "seconds"),
    [
        ("time [s]", "90", 90.0),
        ("time", "90", 90.0),
        ("time [min]", "1,5", 90.0),
        ("minutes", "1.5", 90.0),
        ("Zeit [min]", "1,5", 90.0),
        ("time", "09:01:30", 32490.0),
        ("time [min]", "09:01:30", 32490.0),
        ("repeat", "2", None),
    ],
)
def test_a_time_is_taken_in_seconds_and_a_repeat_is_none(unit, heading: str, written: str, seconds) -> None:
    (reading,) = read(f"range;slow idle [kPa];{heading}\nD;400;{written}\n", unit).readings
    assert reading.time == seconds
    assert reading.round == (2.0 if seconds is None else seconds)


def test_a_repeat_counts_and_a_time_beside_it_stays_one(unit) -> None:
    first, second = read("range;slow idle [kPa];repeat;time\nD;400;1;70\nD;390;2;10\n", unit).readings
    assert [(each.pressure, each.round, each.time) for each in (first, second)] == [
        (400e3, 1.0, 70.0),
        (390e3, 2.0, 10.0),
    ]


@pytest.mark.parametrize("heading", ["gauge no", "Manometer", "nr manometru", "Gauge used"])
def test_the_gauge_of_each_reading_is_kept(unit, heading: str) -> None:
    table = read(f"range;slow idle [kPa];{heading}\nD;400;7\nR;700;B\nN;400;-\n", unit)
    assert {each.cell.range: each.gauge for each in table.readings} == {"D": "7", "R": "B", "N": ""}


# --- repeats


def test_readings_of_one_cell_are_counted_by_a_column(unit: Controller) -> None:
    table = read("range;engine;time;pressure [kPa]\nD;idle;10:05;400\nD;idle;10:01;420\nD;idle;10:09;380\n", unit)
    assert [(each.repeat, each.pressure) for each in table.at(GaugeCell("D", Engine.SLOW_IDLE))] == [
        (1, 420e3),
        (2, 400e3),
        (3, 380e3),
    ]
    assert [each.round for each in table.at(GaugeCell("D", Engine.SLOW_IDLE))] == [36060.0, 36300.0, 36540.0]


def test_readings_of_one_cell_may_stand_in_numbered_columns(unit: Controller) -> None:
    table = read("range;engine;pressure 1 [kPa];pressure 2 [kPa]\nD;idle;400;390\n", unit)
    assert [(each.repeat, each.pressure) for each in table.readings] == [(1, 400e3), (2, 390e3)]


def test_a_cell_given_twice_is_refused_and_names_the_first(unit: Controller) -> None:
    error = refused("range;slow idle [kPa]\nD;400\nD;390\n", unit)
    assert error.place.row == 3
    assert "stands in row 2, column slow idle [kPa] already" in str(error)


# --- what is refused


@pytest.mark.parametrize(
    ("text", "row", "column", "value", "expected"),
    [
        ("range;slow idle [kPa]\nX;400\n", 2, "range", "X", "P, R, N, D, 3, 2, 1"),
        ("range;slow idle [kPa]\n;400\n", 2, "range", None, "P, R, N, D, 3, 2, 1"),
        ("range;slow idle [kPa]\n7;400\n", 2, "range", "7", "P, R, N, D, 3, 2, 1"),
        (";D;7\nslow idle;4 bar;4 bar\n", 1, "7", "7", "P, R, N, D, 3, 2, 1"),
        ("range;state;pressure [kPa]\nD;cruise;400\n", 2, "state", "cruise", "slow idle, fast idle, stall"),
        ("range;state;tap;pressure [kPa]\nD;idle;clutch_c2;400\n", 2, "tap", "clutch_c2", "line, clutch_c1"),
        ("range;state;tap;pressure [kPa]\nD;idle;;400\n", 2, "tap", None, "line, clutch_c1"),
        ("range;slow idle [kPs]\nD;400\n", 1, "slow idle [kPs]", "kPs", "kPa, bar"),
        ("range;slow idle\nD;400\n", 1, "slow idle", None, "kPa, bar"),
        ("range;slow idle [kPa]\nD;about 400\n", 2, "slow idle [kPa]", "about 400", "450"),
        ("range;slow idle [kPa]\nD;-400\n", 2, "slow idle [kPa]", "-400", "0 to 6000 kPa"),
        ("range;slow idle [bar]\nD;400\n", 2, "slow idle [bar]", "400", "0 to 60 bar"),
        ("range;slow idle [kPa]\nD;1.034\n", 2, "slow idle [kPa]", "1.034", "1034 for 1034 kPa"),
        ("range;slow idle [kPa]\nD;400 furlongs\n", 2, "slow idle [kPa]", "400 furlongs", "kPa, bar"),
        ("range;slow idle [kPa];ATF [°C]\nD;400;warm\n", 2, "ATF [°C]", "warm", "-60 to 200"),
        ("range;slow idle [kPa];repeat\nD;400;twice\n", 2, "repeat", "twice", "a time"),
    ],
)
def test_what_is_not_understood_is_named_with_its_place(
    unit: Controller, text: str, row: int, column: str, value: str | None, expected: str
) -> None:
    error = refused(text, unit)
    assert error.place.file == "gauges.csv"
    assert (error.place.row, error.place.column, error.value) == (row, column, value)
    assert expected in str(error.expected)


def test_a_column_of_numbers_under_a_heading_that_means_nothing_is_refused(unit: Controller) -> None:
    data = workbook(("P", [["range", "stall [kPa]", "clutch C9 [kPa]"], ["D", 1100, 900]]))
    error = refused(data, unit)
    assert (error.value, error.place.column) == ("clutch C9 [kPa]", "C")
    of_text = refused("range;stall [kPa];clutch C9 [kPa]\nD;1100;900,5\n", unit)
    assert (of_text.value, of_text.place.row) == ("clutch C9 [kPa]", 1)


def test_a_column_of_words_says_nothing_and_one_without_a_heading_is_named(unit: Controller) -> None:
    table = read("range;stall [kPa];mechanic;\nD;1100;J. B.;17\n", unit)
    assert kpa(table) == {("D", "stall", LINE_TAP): 1100.0}
    (aside,) = [message.text for message in table.messages if message.code == "column_aside"]
    assert aside.endswith("'D'")


def test_an_empty_table_with_other_numbers_refuses_no_measuring_sheet(four_speed, sample_readings: Path) -> None:
    rows = [["range", "slow idle [kPa]", "mileage"], ["D", None, 120000]]
    assert read_readings(with_tab(sample_readings.read_bytes(), rows), four_speed).pressures is None


def test_all_problems_are_listed_at_once(unit: Controller) -> None:
    error = refused("range;slow idle [kPa]\nX;400\nD;abc\nR;1.034\n", unit)
    assert len(error.others) == 2
    assert str(error).count("gauges.csv") == 3


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (b"", "empty"),
        (b"a;b\n1;2\n", "holds no table of gauge readings"),
        (b"range;slow idle [kPa]\nD;\n", "no pressure is filled in"),
        (b"\x89PNG\r\n" * 9, "a PNG picture"),
        (b"PK\x03\x04 no workbook", "gauges.csv"),
    ],
)
def test_a_file_that_holds_no_readings_is_refused(unit: Controller, data: bytes, said: str) -> None:
    error = refused(data, unit)
    assert said in str(error)


def test_a_cell_that_became_a_date_is_refused(unit: Controller) -> None:
    error = refused(workbook(("P", [["range", "stall [bar]"], ["D", dt.date(2026, 5, 3)]])), unit)
    assert "format the cell" in str(error)


def test_a_missing_file_is_named(tmp_path: Path, unit: Controller) -> None:
    with pytest.raises(PressureTableError, match="no such file"):
        read_pressure_table(tmp_path / "none.xlsx", unit)


# --- a tab of the measuring sheet


def with_tab(template: bytes, rows: Sequence[Sequence[Any]], *, name: str = "Gauges") -> bytes:
    book = openpyxl.load_workbook(io.BytesIO(template))
    sheet = book.create_sheet(name)
    for row in rows:
        sheet.append(list(row))
    target = io.BytesIO()
    book.save(target)
    return target.getvalue()


def test_a_tab_of_the_measuring_sheet_is_read_with_it(four_speed: Controller, sample_readings: Path) -> None:
    # 10.3 bar lies within 0.5 mm of a spool of 10 mm: it must not be taken for a diameter
    data = with_tab(sample_readings.read_bytes(), [["range", "slow idle [bar]", "stall [bar]"], ["D", 4.1, 10.3]])
    alone = read_readings(sample_readings, four_speed)
    readings = read_readings(data, four_speed, name="sheet.xlsx")
    assert readings.pressures is not None
    assert kpa(readings.pressures) == {("D", "slow_idle", LINE_TAP): 410.0, ("D", "stall", LINE_TAP): 1030.0}
    assert [(each.station, each.diameter) for each in readings.readings] == [
        (each.station, each.diameter) for each in alone.readings
    ]
    assert [message.code for message in readings.messages] == [message.code for message in alone.messages]


def test_a_tab_left_empty_is_no_table(four_speed: Controller, sample_readings: Path) -> None:
    data = with_tab(sample_readings.read_bytes(), [["range", "slow idle [kPa]"], ["D", None], ["R", None]])
    assert read_readings(data, four_speed).pressures is None


def test_a_sheet_of_which_only_the_tab_is_filled_in_holds_no_diameters(four_speed: Controller) -> None:
    data = with_tab(write_template(four_speed), [["range", "slow idle [kPa]"], ["D", 400]])
    readings = read_readings(data, four_speed)
    assert readings.readings == ()
    assert readings.pressures is not None


def test_a_table_of_gauges_in_place_of_the_measuring_sheet_is_read_as_one(four_speed: Controller) -> None:
    readings = read_readings(b"range;slow idle [kPa]\nD;400\n", four_speed, name="g.csv")
    assert readings.pressures is not None
    assert readings.readings == ()


def test_a_tab_with_a_mistake_refuses_the_sheet(four_speed: Controller, sample_readings: Path) -> None:
    data = with_tab(sample_readings.read_bytes(), [["range", "slow idle [kPa]"], ["Y", 400]])
    with pytest.raises(PressureTableError) as caught:
        read_readings(data, four_speed, name="sheet.xlsx")
    assert caught.value.place.sheet == "Gauges"
    assert (caught.value.place.row, caught.value.place.column, caught.value.value) == (2, "A", "Y")


# --- any table


CELLS = st.dictionaries(
    st.tuples(st.sampled_from(["P", "R", "N", "D", "3", "2", "1"]), st.sampled_from(list(Engine))),
    st.integers(1, 59999).map(lambda tenths: tenths / 10.0),
    min_size=1,
)


@pytest.mark.hypothesis
@given(cells=CELLS, unit_name=st.sampled_from(sorted(UNITS)), comma=st.booleans(), turned=st.booleans())
def test_any_table_is_read_back_as_it_was_written(
    cells: dict[tuple[str, Engine], float], unit_name: str, comma: bool, turned: bool
) -> None:
    four_speed = load_controller("four_speed_2023")
    ranges, engines = [key[0] for key in cells], list(Engine)
    written = {
        key: f"{value * 1e3 / UNITS[unit_name]:.7f}0".replace(".", "," if comma else ".")
        for key, value in cells.items()
    }
    if turned:
        columns = list(dict.fromkeys(ranges))
        lines = [["", *(f"{name} [{unit_name}]" for name in columns)]]
        lines += [[engine.label, *(written.get((name, engine), "") for name in columns)] for engine in engines]
    else:
        lines = [["range", *(f"{engine.label} ({unit_name})" for engine in engines)]]
        lines += [[name, *(written.get((name, engine), "") for engine in engines)] for name in dict.fromkeys(ranges)]
    table = read("\n".join(";".join(line) for line in lines), four_speed)
    got = {(each.cell.range, each.cell.engine): each.pressure for each in table.readings}
    assert got.keys() == cells.keys()
    for key, value in cells.items():
        assert got[key] == pytest.approx(value * 1e3, abs=1e-6 * UNITS[unit_name])


@pytest.mark.hypothesis
@given(
    st.lists(
        st.lists(
            st.sampled_from(
                ["", "range", "D", "R", "stall", "slow idle [kPa]", "400", "x", "4,1 bar", "-", "tap", "line"]
            ),
            max_size=5,
        ),
        max_size=6,
    )
)
def test_any_jumble_of_cells_is_read_or_refused_in_words(rows: list[list[str]]) -> None:
    four_speed = load_controller("four_speed_2023")
    said = ""
    try:
        readings = read("\n".join(";".join(row) for row in rows), four_speed).readings
    except InputError as error:
        readings, said = (), str(error)
    assert readings or "gauges.csv" in said


def test_every_range_of_a_unit_is_read(unit: Controller) -> None:
    rows = "\n".join(f"{name};400" for name in ranges_of(unit))
    assert len(read(f"range;idle [kPa]\n{rows}\n", unit).readings) == len(ranges_of(unit)) == 7


def test_what_is_wrong_with_a_table_is_said_in_german(unit: Controller) -> None:
    error = refused("range;slow idle [kPa]\nD;1.250\nX;400\n", unit)
    said = wording("de").sentence(error.sentence)
    assert "D, Leerlauf: kein Druck (gefunden: '1.250')" in said
    assert "lässt sich auf zwei Arten lesen: 1250 schreiben für 1250 kPa, oder 1,25 für 1,25 kPa" in said
    assert "diese Fahrstufe hat das Getriebe nicht (gefunden: 'X'); erwartet: eines von " in said
