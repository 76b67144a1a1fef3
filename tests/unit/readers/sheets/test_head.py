"""What stands above the headings about the measurement: its temperature and its date."""

from __future__ import annotations

import datetime as dt
import io

import openpyxl
import pytest

from atleak.common.errors import ReadingsError
from atleak.readers.sheets.measuring_sheet import read_readings
from atleak.report.sheets.measuring_columns import SHEET
from atleak.report.sheets.measuring_sheet import write_readings, write_template

TABLE = "Valve;Land;Part;Diameter [mm]\naccumulator;1;spool;17.998\naccumulator;1;sleeve;18.036"


def under(head, controller, table=TABLE):
    return read_readings(f"{head}\n\n{table}".encode(), controller, name="sheet.csv")


def codes(readings):
    return {message.code for message in readings.messages}


@pytest.mark.parametrize(
    ("head", "celsius"),
    [
        ("Temperature;23,5 °C", 23.5),
        ("Temperature;23.5", 23.5),
        ("Temperature [°C];;23,5", 23.5),
        ("Measuring temperature: 35 °C", 35.0),
        ("Room temperature 21", 21.0),
        ("Temp. of the parts = 19,5", 19.5),
        ("Temperature;20 ± 0,5 °C", 20.0),
        ("Temperature;21 °C (room)", 21.0),
        ("Temperature [°F];77", 25.0),
        ("Temperature;77;°F", 25.0),
        ("Temperature;-5", -5.0),
        ("Date;Temperature;Operator\n2026-03-14;22,4;JK", 22.4),
        ("Messtemperatur: 35 °C", 35.0),
        ("Raumtemperatur;22", 22.0),
        ("Temperatura pomiaru;21,5", 21.5),
        ("Measured at 24.1 °C", 24.1),
        ("Measured at;75.2 °F", 24.0),
        ("All diameters referred to 20 °C", 20.0),
        ("Values corrected to: 20 °C", 20.0),
        ("Messwerte bezogen auf 20 °C", 20.0),
        ("Wartości odniesione do 20 °C", 20.0),
        ("Température des pièces : 19,8 °C", 19.8),
        ("Temperatura de medición;24", 24.0),
        ("Temperatura di misura;24", 24.0),
        ("Температура измерения;23", 23.0),
        ("Teplota při měření;23", 23.0),
    ],
)
def test_the_measuring_temperature_is_read_in_the_words_of_workshops(controller, head, celsius):
    readings = under(head, controller)
    assert readings.temperature == pytest.approx(celsius, abs=1e-9)
    assert len(readings.readings) == 2


@pytest.mark.parametrize(
    "head",
    [
        "Oil temperature;95 °C",
        "Öltemperatur: 80 °C",
        "Reference temperature 20 °C",
        "Temperature",
        "Temperature;",
        "Temperature;Operator",
        "Temperature;;Date;2026-03-14",
        "Temperature range of the fluid;-40",
        "Measured at;Kraków",
        "Measured on 2026-03-14",
        "Measured at 10:30",
    ],
)
def test_another_temperature_or_an_empty_field_is_none(controller, head):
    assert under(head, controller).temperature is None


@pytest.mark.parametrize(
    ("head", "column", "value", "said"),
    [
        ("Temperature;warm", "2", "'warm'", "no temperature"),
        ("Temperature;20-22 °C", "2", "'20-22 °C'", "no temperature"),
        ("Temperature;23 bar", "2", "'23 bar'", "no temperature"),
        ("Temperature;235", "2", "'235'", "from −20 to 60 °C"),
        ("Temperature: 293 K (20 °C) or so", "1", "'293 K (20 °C) or so'", "no temperature"),
    ],
)
def test_nonsense_is_refused_with_its_place(controller, head, column, value, said):
    with pytest.raises(ReadingsError) as caught:
        under(head, controller)
    text = str(caught.value)
    assert f"sheet.csv, row 1, column {column}: " in text
    assert value in text
    assert said in text
    assert "expected" in text


def test_a_decimal_comma_between_commas_is_not_cut_off(controller):
    table = TABLE.replace(";", ",")
    assert under("Temperature,23.5", controller, table).temperature == 23.5
    with pytest.raises(ReadingsError, match="no temperature") as caught:
        under("Temperature,23,5", controller, table)
    assert "'23 | 5'" in str(caught.value)


def test_two_temperatures_that_differ_are_named_and_not_chosen_from(controller):
    readings = under("Room temperature;22;Part temperature;21", controller)
    assert readings.temperature is None
    (message,) = [each for each in readings.messages if each.code == "measuring_temperature_unclear"]
    assert message.level == "warning"
    assert "22 °C (sheet.csv, row 1, column 2) and 21 °C (sheet.csv, row 1, column 4)" in message.text
    assert under("Room temperature;22;Part temperature;22,0", controller).temperature == 22.0
    both = under("Measured at 24.1 °C\nReferred to 20 °C", controller)
    assert (both.temperature, "measuring_temperature_unclear" in codes(both)) == (None, True)


def test_a_temperature_of_the_size_of_a_diameter_is_no_lost_reading(controller):
    assert "not_read" not in codes(under("Messtemperatur;18,1", controller))
    assert "not_read" in codes(under("Kennzahl;18,1", controller))


@pytest.mark.parametrize(
    ("head", "date"),
    [
        ("Date;2026-03-14", dt.date(2026, 3, 14)),
        ("Date: 14/03/2026", dt.date(2026, 3, 14)),
        ("Datum;4.3.2026", dt.date(2026, 3, 4)),
        ("Data pomiaru: 14 marca 2026", dt.date(2026, 3, 14)),
        ("Date;03/04/2026", None),
        ("Date;soon", None),
        ("Date of manufacture;2011-01-05", None),
        ("Mileage;106 315 km", None),
    ],
)
def test_the_date_is_read_where_day_and_month_cannot_be_mistaken(controller, head, date):
    assert under(head, controller).date == date


def test_the_printed_form_takes_temperature_and_date(controller):
    template = write_template(controller)
    book = openpyxl.load_workbook(io.BytesIO(template))
    sheet = book[SHEET]
    places = {cell.value: cell for row in sheet["A4:N7"] for cell in row if cell.value}
    asked = {"Job", "Date", "Vehicle", "VIN", "Serial number", "Mileage [km]", "Measured by"}
    assert set(places) == {*asked, "Instrument for spools", "Instrument for bores", "Measuring temperature [°C]"}
    places["Measuring temperature [°C]"].offset(0, 2).value = "35,0 °C"
    places["Date"].offset(0, 2).value = dt.datetime(2026, 3, 14)
    sheet["H9"] = sheet["L9"].value  # the first diameter as the nominal one beside it
    saved = io.BytesIO()
    book.save(saved)
    readings = read_readings(saved.getvalue(), controller, name="form.xlsx")
    assert (readings.temperature, readings.date) == (35.0, dt.date(2026, 3, 14))
    fields = {"Measuring temperature": "23,5 °C", "Instrument for spools": "microscope"}
    again = read_readings(write_readings(controller, readings.readings, fields=fields), controller)
    assert again.temperature == 23.5


@pytest.mark.parametrize(
    ("head", "side_um", "tip_um"),
    [
        ("Pump side clearance [µm];85", 85.0, None),
        ("Pump side clearance [µm];0.0033 in", 83.82, None),
        ("Pump side clearance [in];0.0033\nPump tip clearance [in];.0063", 83.82, 160.02),
        ("Pump tip clearance: 0,16 mm", None, 160.0),
        ("Oil pump axial play;60 µm;Pump tip clearance;120", 60.0, 120.0),
        ("Pumpenseitenspiel: 60 µm", 60.0, None),
        ("Luz boczny pompy [mm];0,06", 60.0, None),
        ("Pump;side", None, None),
        ("Pump body clearance;120", None, None),
    ],
)
def test_the_pump_s_clearances_are_read_in_the_units_of_workshops(controller, head, side_um, tip_um):
    pump = under(head, controller).pump
    assert (pump.side, pump.tip) == tuple(
        None if um is None else pytest.approx(um * 1e-6, rel=1e-9, abs=0.0) for um in (side_um, tip_um)
    )


@pytest.mark.parametrize(
    ("head", "words"),
    [
        ("Pump side clearance [µm];0.0033", ("no pump side clearance that a pump has", "0.0033", "from 1 to 2000 µm")),
        ("Pump tip clearance;large", ("no pump tip clearance", "large", "such as 150.5 µm")),
        ("Pump side clearance;20 °C", ("no pump side clearance", "20 °C")),
    ],
)
def test_what_is_no_clearance_of_a_pump_is_refused_with_its_place(controller, head, words):
    with pytest.raises(ReadingsError) as caught:
        under(head, controller)
    for word in words:
        assert word in str(caught.value)


def test_two_clearances_of_one_pump_are_named_and_none_is_taken(controller):
    readings = under("Pump side clearance;85 µm\nPump side clearance;0.09 mm", controller)
    assert readings.pump.side is None
    assert "pump_clearance_unclear" in codes(readings)


def test_a_crossed_out_temperature_is_not_read(controller):
    book = openpyxl.Workbook()
    book.active.append(["Temperature", 35.0])
    book.active["B1"].font = openpyxl.styles.Font(strike=True)
    book.active.append([])
    for line in TABLE.split("\n"):
        book.active.append([float(cell) if "." in cell else cell for cell in line.split(";")])
    saved = io.BytesIO()
    book.save(saved)
    assert read_readings(saved.getvalue(), controller, name="form.xlsx").temperature is None


def test_a_date_that_is_not_taken_is_told(controller):
    for head, said in (
        ("Date;03/04/2026", "it can be read in two ways"),
        ("Date;2026-03-14\nDate;2026-03-15", "more than"),
    ):
        read = under(head, controller)
        assert read.date is None
        assert said in next(message.text for message in read.messages if message.code == "head_unclear")
