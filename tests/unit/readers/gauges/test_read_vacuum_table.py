"""Tables of vacuum tests, as a bench writes them."""

from __future__ import annotations

import datetime as dt
import io
import math
import re
from collections.abc import Sequence
from typing import Any

import openpyxl
import pytest

from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import load_controller
from atleak.common.errors import VacuumTableError
from atleak.common.translations import languages
from atleak.common.wording import wording
from atleak.diagnosis.vacuum_stand import flow_of_reading
from atleak.measurements.vacuum import STANDARD_ATMOSPHERE, USUAL_SUPPLY, VacuumTable
from atleak.readers.gauges.vacuum_table import read_vacuum_table
from tests.unit.docs.pages import text_of

INHG = 3386.389  # [Pa]


@pytest.fixture(scope="module")
def unit() -> Controller:
    return load_controller("five_speed_2005")


def read(text: str, unit: Controller) -> VacuumTable:
    return read_vacuum_table(text.encode(), unit, name="vacuum.csv")


def refused(text: str | bytes, unit: Controller) -> str:
    with pytest.raises(VacuumTableError) as caught:
        read_vacuum_table(text.encode() if isinstance(text, str) else text, unit, name="vacuum.csv")
    return str(caught.value)


def workbook(**sheets: Sequence[Sequence[Any]]) -> bytes:
    book = openpyxl.Workbook()
    book.remove(book.active)
    for name, rows in sheets.items():
        sheet = book.create_sheet(name)
        for row in rows:
            sheet.append(list(row))
    target = io.BytesIO()
    book.save(target)
    return target.getvalue()


TABLE = """supply,25,in-Hg
ambient,98.5,kPa
temperature,77,°F
calibration,0.5 mm,21.6 in-Hg
calibration,1.0,mm,12.1,in-Hg,0.5 mm
circuit or component/land,reading,unit,orifice,state
forward_clutch,17.5,in-Hg,1.0 mm,worn
manual_valve/1,60,kPa,,repaired
boost_valve/1 + pressure_regulator/2,-20,,0.5,
"""


def test_the_stand_and_its_readings_in_si(unit: Controller) -> None:
    lands = tuple(land.key for land in unit.lands_around("forward_clutch"))
    component = unit.lands[0].component
    table = read(TABLE.replace("manual_valve/1", f"{component}/1"), unit)
    stand = table.stand
    assert (stand.supply, stand.ambient, stand.temperature) == pytest.approx((25 * INHG, 98.5e3, 25.0), abs=0.0)
    assert [(each.orifice, each.vacuum, each.fitted) for each in stand.calibrations] == [
        (0.5e-3, pytest.approx(21.6 * INHG, abs=0.0), None),
        (1e-3, pytest.approx(12.1 * INHG, abs=0.0), 0.5e-3),
    ]
    circuit, one, two = table.readings
    assert (circuit.circuit, circuit.lands, circuit.orifice) == ("forward_clutch", lands, 1e-3)
    assert circuit.vacuum == pytest.approx(17.5 * INHG, abs=0.0)
    assert not circuit.repaired
    assert (one.circuit, one.lands, one.repaired, one.orifice) == (None, ((component, 1),), True, None)
    assert one.vacuum == 60e3
    assert two.lands == (("boost_valve", 1), ("pressure_regulator", 2))
    assert two.vacuum == pytest.approx(20 * INHG, abs=0.0)  # without a unit of its own: that of the supply
    assert two.orifice == 0.5e-3
    assert (two.place.row, two.place.column, two.target) == (9, "reading", "boost_valve/1 + pressure_regulator/2")


@pytest.mark.parametrize(
    ("unit_written", "factor"),
    [("in-Hg", INHG), ("inHg", INHG), ("in. Hg", INHG), ("mbar", 100.0), ("mmHg", 133.322387415), ("bar", 1e5)],
)
def test_units(unit_written: str, factor: float, unit: Controller) -> None:
    value = round(40e3 / factor, 3)
    for text in (
        f"supply;25 in-Hg\nforward_clutch;{value};{unit_written}\n",
        f"supply;25 in-Hg\ncircuit;vacuum [{unit_written}]\nforward_clutch;{str(value).replace('.', ',')}\n",
        f"supply;25 in-Hg\ncircuit;vacuum\nforward_clutch;{value} {unit_written}\n",
    ):
        assert read(text, unit).readings[0].vacuum == pytest.approx(value * factor, abs=0.0)


def test_german_words_and_a_decimal_comma(unit: Controller) -> None:
    table = read(
        "Versorgung: 85,0 kPa\nLuftdruck;1013;mbar\nTemperatur;21,5\n"
        "Kalibrierung;Düse [mm];Unterdruck [kPa]\n;0,5;60,5\nKalibrierung;1,0;30\n"
        "Kreis;Unterdruck [mbar];Düse [mm];Zustand\n"
        "forward_clutch;600;0,5;instand gesetzt\nboost_valve/1;512,5;;verschlissen\n",
        unit,
    )
    assert (table.stand.supply, table.stand.ambient, table.stand.temperature) == (85e3, 101300.0, 21.5)
    assert [(each.orifice, each.vacuum) for each in table.stand.calibrations] == [(0.5e-3, 60.5e3), (1e-3, 30e3)]
    assert [(each.vacuum, each.repaired) for each in table.readings] == [(60e3, True), (51.25e3, False)]


@pytest.mark.parametrize("language", languages())
def test_the_words_that_a_refusal_asks_for_are_read(language: str, unit: Controller) -> None:
    with pytest.raises(VacuumTableError) as refused:
        read("a,b\n1,2\n", unit)
    asked = wording(language).sentence(refused.value.expected)
    supply = asked.partition("(")[2].partition(")")[0]
    headings = asked.rpartition(": ")[2]
    table = read(f"{supply}\n{headings}\nboost_valve/1,17,in-Hg,0.5,repaired\n", unit)
    assert table.stand.supply == pytest.approx(25 * INHG, abs=0.0)
    assert (table.readings[0].orifice, table.readings[0].repaired) == (0.5e-3, True)


def test_a_circuit_by_its_name_and_rows_without_headings(unit: Controller) -> None:
    circuit = next(each for each in unit.circuits if each.id == "forward_clutch")
    table = read(f"supply,25,inHg\n{circuit.name},17.5,inHg,1 mm,repaired\n", unit)
    assert (table.readings[0].circuit, table.readings[0].repaired) == ("forward_clutch", True)


def test_what_the_stand_does_not_say_is_assumed_and_told(unit: Controller) -> None:
    table = read("circuit,reading\nforward_clutch,17.5 in-Hg\n", unit)
    assert (table.stand.supply, table.stand.ambient) == (USUAL_SUPPLY, STANDARD_ATMOSPHERE)
    assert {"supply_assumed", "ambient_assumed", "temperature_assumed"} <= {each.code for each in table.messages}
    assert not {each.code for each in read(TABLE.replace("manual_valve", "boost_valve"), unit).messages} - {"read_as"}


def test_one_orifice_of_the_stand_counts_where_a_row_names_none(unit: Controller) -> None:
    table = read(
        "supply,25,in-Hg\norifice,1.0,mm\nflow area,0.628,mm²\ncircuit,reading,orifice\n"
        "forward_clutch,17.5,\nboost_valve/1,17.5,0.5\n",
        unit,
    )
    assert [each.orifice for each in table.readings] == [1e-3, 0.5e-3]
    assert table.stand.flow_area == pytest.approx(0.628e-6, abs=0.0)


def test_a_stand_alone_is_taken_for_its_card_and_says_so(unit: Controller) -> None:
    table = read("supply,24,in-Hg\ncalibration,0.5 mm,20\ncircuit,reading\n", unit)
    assert (table.readings, len(table.stand.calibrations)) == ((), 1)
    assert "no_vacuum_reading" in {each.code for each in table.messages if each.level == "warning"}


def test_everything_wrong_is_listed_with_row_column_value_and_what_was_expected(unit: Controller) -> None:
    said = refused(
        "supply,25,in-Hg\ncircuit,reading,unit,orifice,state\nforward_clutc,17.5,in-Hg,,\nboost_valve/9,26.5,in-Hg,9,foo\n"
        "boost_valve/1,17,furlong,,\nboost_valve/1,abc,in-Hg,,\n",
        unit,
    )
    lines = said.splitlines()
    assert "vacuum.csv, row 3, column circuit: no circuit or land" in lines[0]
    assert "'forward_clutc'" in lines[0]
    assert any("no such land (found '9')" in line for line in lines)
    assert any("row 4, column reading: more than the stand's supply (found '26.5')" in line for line in lines)
    assert any("column orifice" in line and "expected 0.05 to 5 mm" in line for line in lines)
    assert any("expected one of worn, repaired" in line for line in lines)
    assert any("'furlong'" in line and "in-Hg" in line for line in lines)
    assert any("'abc'" in line and "expected 0 to 31 in-Hg" in line for line in lines)
    assert len(lines) == 7


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "the file is empty"),
        ("a,b\n1,2\n", "holds no table of a vacuum test"),
        ("circuit,reading\nforward_clutch,17\n", "no unit stands with this value"),
        ("supply,25\nforward_clutch,17 in-Hg\n", "row 1, column 2: no unit stands with this value"),
        ("supply,250,in-Hg\nforward_clutch,17\n", "not accepted as supply vacuum (found '250'); expected 3 to 31"),
        ("supply,25,in-Hg\ncircuit,reading\nforward_clutch,\n", "no reading is filled in"),
        ("supply,25,in-Hg\ncalibration,0.5 mm\nforward_clutch,17\n", "not a calibration"),
    ],
)
def test_refused(text: str, said: str, unit: Controller) -> None:
    assert said in refused(text, unit)


def test_a_workbook_and_the_date_that_a_spreadsheet_makes_of_a_land(unit: Controller) -> None:
    head = [["supply", 25, "in-Hg"], ["circuit", "reading [in-Hg]", "orifice [mm]", "state"]]
    right = workbook(Notes=[["nothing"]], Stand=[*head, ["forward_clutch", 17.5, 0.5, "repaired"]])
    table = read_vacuum_table(right, unit, name="v.xlsx")
    assert (table.sheet, table.readings[0].vacuum) == ("Stand", pytest.approx(17.5 * INHG, abs=0.0))
    assert (table.readings[0].place.sheet, table.readings[0].place.column) == ("Stand", "B")
    said = refused(workbook(Stand=[*head, [dt.datetime(2026, 1, 8), 17.5]]), unit)
    assert "sheet 'Stand', row 3, column A: the spreadsheet made a date of a land" in said
    assert "holds no table of a vacuum test" in refused(workbook(Wrong=[["P", "R"], [1, 2]]), unit)


def test_a_supply_of_more_vacuum_than_there_is_air_is_refused_and_never_assumed(unit: Controller) -> None:
    high = "ambient,83.4,kPa\nforward_clutch,17.5,in-Hg,1 mm\n"
    said = refused(f"{high}supply,25,in-Hg\n", unit)
    assert all(part in said for part in ("row 3", "25 in-Hg", "at most 24.63 in-Hg")), said
    table = read(high, unit)
    assert table.stand.supply == table.stand.ambient == pytest.approx(83.4e3, abs=0.0)
    (assumed,) = (each for each in table.messages if each.code == "supply_assumed")
    assert "24.63 in-Hg" in str(assumed.text)


@pytest.mark.parametrize("shown", ["0", "25", "26"])
def test_a_calibration_that_no_stand_can_show_is_refused(shown: str, unit: Controller) -> None:
    said = refused(f"supply,25,in-Hg\ncalibration,0.5 mm,{shown} in-Hg\nforward_clutch,17.5,in-Hg,1 mm\n", unit)
    assert all(part in said for part in ("row 2", f"{shown} in-Hg", "less than the supply's 25 in-Hg")), said


def test_the_stand_of_the_documented_table_is_calibrated_with_each_of_its_orifices(unit: Controller) -> None:
    (text,) = re.findall(r"^```text\n(supply.*?)^```", text_of("docs/vacuum-and-flows.md"), re.MULTILINE | re.DOTALL)
    table = read(text, unit)
    assert {each.orifice for each in table.readings} == {0.5e-3, 1e-3}
    for each in table.readings:
        assert each.orifice is not None
        flow = flow_of_reading(table, each)
        assert flow.known
        assert flow.area / (0.25 * math.pi * each.orifice**2) == pytest.approx(0.8, abs=0.02)
