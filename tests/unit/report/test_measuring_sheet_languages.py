"""The measuring sheet in the reader's language and units is read back as the same readings."""

from __future__ import annotations

import datetime as dt
import io
from dataclasses import replace

import openpyxl
import pytest

from atleak.analysis.record_doubts import with_sheet
from atleak.catalogue.controller_file import load_controller
from atleak.common.errors import ReadingsError
from atleak.common.translations import languages
from atleak.common.wording import wording
from atleak.measurements.gauge_readings import Engine, GaugeCell, GaugeReading, PressureTable
from atleak.measurements.job_card import Job, Transmission, Vehicle
from atleak.measurements.readings import OwnLands, OwnLength, Reading, Readings
from atleak.readers.sheets.measuring_sheet import read_readings
from atleak.report.sheets.measuring_columns import SHEET, UNWORN_END
from atleak.report.sheets.measuring_head import fields_of
from atleak.report.sheets.measuring_sheet import write_readings, write_template

READERS = [(language, units) for language in languages() for units in ("metric", "us")]
UM = 1e-6
JOB = Job(
    number="2026-0417",
    technician="K. Weber",
    measured_on=dt.date(2026, 4, 17),
    vehicle=Vehicle(make="Volvo", model="V70", vin="YV1SW61", mileage_km=212000.0),
    transmission=Transmission(serial="77-1"),
    measuring_temperature_c=26.5,
    pump_side_clearance_um=85.0,
    pump_tip_clearance_um=150.5,
    instruments=({"name": "M 1"}, {"name": "B 2"}),
)


@pytest.fixture(scope="module")
def unit():
    """A valve body with circuits, spools and pistons."""
    return load_controller("five_speed_2005")


def written(unit, language: str, units: str) -> bytes:
    """Six lands measured, their lengths, and gauges at the line and at a circuit."""
    found = [
        Reading(land.component, part, plane, angle, repeat, nominal + repeat * UM)
        for land in unit.lands[:6]
        for part, nominal in (("spool", land.nominal_diameter), ("sleeve", land.nominal_sleeve_diameter + 9 * UM))
        for plane in land.planes
        for angle in (0.0, 90.0)
        for repeat in (1, 2)
    ]
    gauges = (
        GaugeReading(GaugeCell("D", Engine.SLOW_IDLE), 412e3),
        GaugeReading(GaugeCell("R", Engine.STALL), 912e3),
        GaugeReading(GaugeCell("D", Engine.FAST_IDLE, "forward_clutch"), 500e3),
    )
    lands = unit.lands[:2]
    lengths = tuple(OwnLength(*land.key, land.contact_length + 0.1e-3, 5e-3) for land in lands)
    return write_readings(
        unit,
        found,
        fields=fields_of(JOB, units),
        pressures=PressureTable("", "", None, (), gauges),
        own_lands=OwnLands(lengths=lengths),
        language=language,
        units=units,
    )


def values_of(found: Readings) -> tuple:
    """What was read, without places; lengths to a tenth of a nanometre, pressures to a pascal."""
    readings = [replace(each, place=None, diameter=round(each.diameter, 9)) for each in found.readings]
    gauges = [(each.cell, round(each.pressure)) for each in found.pressures.readings]
    lengths = [(each.key, round(each.contact_length, 9), round(each.position, 9)) for each in found.own_lands.lengths]
    return readings, gauges, lengths, found.date, replace(found.identity, mileage=None)


@pytest.mark.parametrize(("language", "units"), READERS)
def test_a_sheet_of_any_language_and_units_is_read_back_as_the_same(unit, language, units):
    back = read_readings(written(unit, language, units), unit)
    assert values_of(back) == values_of(read_readings(written(unit, "en", "metric"), unit))
    assert (back.unit, back.date) == ("mm" if units == "metric" else "inch", dt.date(2026, 4, 17))
    beside = (back.temperature, back.identity.mileage, *back.pump.um)
    assert beside == pytest.approx((26.5, 212000.0, 85.0, 150.5), rel=1e-6, abs=0.0)
    again = with_sheet(None, back)
    own = {"mileage_km": None, "date": "2026-04-17"}  # the head's day is the job's
    assert again.identity | {"mileage_km": None} == JOB.identity | own
    assert again.instruments == JOB.instruments
    assert [message.code for message in back.messages] == ["rows_not_measured", "contact_length_measured"]


@pytest.mark.parametrize("language", languages())
def test_what_is_chosen_for_an_unworn_end_is_read_in_every_language(unit, language):
    say = wording(language)
    book = openpyxl.load_workbook(io.BytesIO(written(unit, language, "metric")))
    sheet = book[say.sentence(SHEET)]
    row = next(row for row in sheet.iter_rows(min_row=9) if isinstance(row[7].value, float))
    row[16].value = say.sentence(UNWORN_END)
    target = io.BytesIO()
    book.save(target)
    assert len(read_readings(target.getvalue(), unit).unworn) == 2  # of both repeats


@pytest.mark.parametrize("language", languages())
def test_the_head_names_its_valve_body_in_every_language(unit, language):
    land = unit.lands[0]
    found = Reading(land.component, "spool", land.planes[0], 0.0, 1, land.nominal_diameter)
    with pytest.raises(ReadingsError, match=f"made for controller {unit.id}, not for minimal_example"):
        read_readings(write_readings(unit, [found], language=language), load_controller("minimal_example"))


@pytest.mark.parametrize("language", languages())
def test_titles_and_what_is_assumed_are_said_in_the_reader_s_language(unit, language):
    say = wording(language)
    sheets = openpyxl.load_workbook(io.BytesIO(write_template(unit, language=language))).worksheets
    name, assumed = say.name(unit.name), say("how_to_measure.nominal_values")
    assert (name == unit.name) == (language == "en")
    assert [name in sheet["A1"].value for sheet in sheets] == [True, True, True, False]
    assert name in sheets[0].oddFooter.left.text
    assert sheets[0]["A3"].value == assumed
    assert any(assumed in str(cell.value) for cell in sheets[3]["B"])


@pytest.mark.parametrize("language", languages())
def test_the_head_of_a_sheet_in_inches_says_miles_fahrenheit_and_inches(unit, language):
    book = openpyxl.load_workbook(io.BytesIO(written(unit, language, "us")))
    texts = [str(cell.value) for row in book.worksheets[0]["A4:N7"] for cell in row if cell.value]
    assert {"131730.7 mi", "79.7 °F", "0.003346457 in", "0.005925197 in"} <= set(texts)
    assert [sum(f"[{name}]" in text for text in texts) for name in ("mi", "°F", "in")] == [1, 1, 2]
    assert not [text for text in texts if "km" in text.split() or "µm" in text or "°C" in text]


def test_headings_say_the_reader_s_units(unit):
    sheets = openpyxl.load_workbook(io.BytesIO(write_template(unit, language="de", units="us")))
    headings = [cell.value for cell in sheets["Messungen"][8]]
    assert {"Durchmesser 1 [in]", "Einbauspiel [0.0001 in]"} <= set(headings)
    assert "Leerlauf [psi]" in [cell.value for cell in sheets["Drücke"][6]]


def test_a_german_sheet_with_the_words_of_before_is_read_as_the_same(unit):
    """Its tab was "Bunde", its contact length "Überdeckungslänge"; a heading of one's own may have either plural."""
    book = openpyxl.load_workbook(io.BytesIO(written(unit, "de", "metric")))
    lands = book["Bünde"]
    lands.title = "Bunde"
    for cell in (cell for row in lands.iter_rows() for cell in row if isinstance(cell.value, str)):
        if cell.value == "Bund":
            cell.value = "Bunde"
        cell.value = cell.value.replace("Bünde", "Bunde").replace("Dichtlänge", "Überdeckungs-\nlänge")
    target = io.BytesIO()
    book.save(target)
    back = read_readings(target.getvalue(), unit)
    assert values_of(back) == values_of(read_readings(written(unit, "en", "metric"), unit))
    assert "contact_length_measured" in [message.code for message in back.messages]
