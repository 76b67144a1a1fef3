"""What stands above the headings about the job: whose unit it is, and who measured it with what."""

from __future__ import annotations

import pytest

from atleak.catalogue.controller import Controller
from atleak.common.translations import languages
from atleak.measurements.readings import Reading, Readings, SheetIdentity
from atleak.readers.sheets.measuring_sheet import read_readings
from atleak.report.sheets.measuring_sheet import write_readings

TABLE = "Valve;Land;Part;Diameter [mm]\naccumulator;1;spool;17.998\naccumulator;1;sleeve;18.036"
MILES = 1.609344  # [km] the international mile


def under(head: str, controller: Controller) -> Readings:
    return read_readings(f"{head}\n\n{TABLE}".encode(), controller, name="sheet.csv")


@pytest.mark.parametrize(
    ("head", "said"),
    [
        ("Job;4711", {"job": "4711"}),
        ("Work order no. 77", {"job": "77"}),
        ("Job: 2026-117;;VIN: WVWZZZ1JZXW000001", {"job": "2026-117", "vin": "WVWZZZ1JZXW000001"}),
        ("Job;Vehicle;VIN\n12;Ford;1FA", {"job": "12", "vehicle": "Ford", "vin": "1FA"}),
        ("Vehicle identification number: XX1", {"vin": "XX1"}),
        ("Serial number;6HP-1;Instrument;micrometer", {"serial": "6HP-1", "instruments": ("micrometer",)}),
        ("Instrument for bores;gauge 2;Instrument for spools;micrometer", {"instruments": ("micrometer", "gauge 2")}),
        ("Messmittel Schieber: M1;;Messmittel für Bohrungen: M1", {"instruments": ("M1",)}),
        ("Measured by;\nInstrument for spools;", {}),
        ("Mileage;182 345 km", {"mileage": 182_345.0}),
        ("Mileage [mi];120000", {"mileage": 120_000.0 * MILES}),
        ("Mileage;120 000 miles", {"mileage": 120_000.0 * MILES}),
        ("Auftragsnummer;A-12;;Fahrzeug;Golf IV\nFIN;W1;;Kilometerstand;182345", None),
        ("Przebieg;182 000;;Mierzył;J. K.", {"mileage": 182_000.0, "technician": "J. K."}),
        ("Job;;;Vehicle;;Focus\nMileage;;;VIN;", {"vehicle": "Focus"}),
        ("Serial number of the micrometer;4711", {}),
        ("Vehicles in the yard;12", {}),
        (f"Job;{'x' * 300}", {}),
    ],
)
def test_a_field_of_the_head_is_read_under_its_label(
    controller: Controller, head: str, said: dict[str, str | float] | None
) -> None:
    expected = {"job": "A-12", "vehicle": "Golf IV", "vin": "W1", "mileage": 182_345.0} if said is None else said
    assert under(head, controller).identity == SheetIdentity(**expected)  # type: ignore[arg-type]


def test_a_field_stated_twice_differently_is_not_taken_and_told(controller: Controller) -> None:
    read = under("VIN;A\nVIN;B", controller)
    assert read.identity.empty
    (told,) = [message.text for message in read.messages if message.code == "head_unclear"]
    assert "'A' (sheet.csv, row 1, column 2) and 'B'" in told


@pytest.mark.parametrize(
    ("written", "reason"), [("unknown", "is not a number"), ("182.000 km", "can be read in two ways")]
)
def test_a_mileage_that_cannot_be_read_is_told_and_refuses_nothing(
    controller: Controller, written: str, reason: str
) -> None:
    read = under(f"Mileage;{written}", controller)
    assert read.identity.mileage is None
    assert len(read.readings) == 2
    assert reason in next(message.text for message in read.messages if message.code == "head_unclear")


@pytest.mark.parametrize("language", languages())
@pytest.mark.parametrize("filled", ["all of them", "Job", "Measured by"])
def test_what_is_written_in_the_form_is_read_from_it_in_any_language(
    controller: Controller, language: str, filled: str
) -> None:
    land = controller.lands[0]
    readings = [Reading(land.component, "spool", "1", 0.0, 1, land.nominal_diameter)]
    fields = {
        "Job": "4711",
        "Vehicle": "Golf IV",
        "Mileage": "182000 km",
        "Measured by": "J. K.",
        "VIN": "WVWZZZ1JZXW000001",
        "Serial number": "S-1",
        "Instrument for spools": "micrometer",
        "Instrument for bores": "Air gauge",
    }
    chosen = {name: text for name, text in fields.items() if filled in ("all of them", name)}
    sheet = write_readings(controller, readings, fields=chosen, language=language)
    keys = ("job", "vehicle", "mileage", "technician", "vin", "serial")
    expected = {key: chosen[name] for key, name in zip(keys, fields, strict=False) if name in chosen}
    instruments = ("micrometer", "Air gauge") if filled == "all of them" else ()
    if "mileage" in expected:
        expected["mileage"] = 182_000.0  # type: ignore[assignment]
    identity = read_readings(sheet, controller, name="sheet.xlsx").identity
    assert identity == SheetIdentity(**expected, instruments=instruments)  # type: ignore[arg-type]


@pytest.mark.parametrize("language", languages())
def test_a_bare_number_in_the_form_is_in_the_unit_of_its_label(controller: Controller, language: str) -> None:
    land = controller.lands[0]
    readings = [Reading(land.component, "spool", "1", 0.0, 1, land.nominal_diameter)]
    fields = {"Mileage": "120000", "Measuring temperature": "77"}
    sheet = write_readings(controller, readings, fields=fields, language=language, units="us")
    read = read_readings(sheet, controller, name="sheet.xlsx")
    assert (read.identity.mileage, read.temperature) == (120_000.0 * MILES, 25.0)
