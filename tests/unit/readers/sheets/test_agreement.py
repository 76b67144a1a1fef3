"""What a sheet says twice must agree; where it does not, a message says so."""

from __future__ import annotations

import pytest

from atleak.catalogue.controller_file import load_controller
from atleak.common.errors import ReadingsError
from atleak.readers.sheets.measuring_sheet import read_readings
from atleak.report.sheets.measuring_sheet import write_template


def read(controller, *lines):
    return read_readings("\n".join(lines).encode(), controller, name="sheet.csv")


def warnings(readings, code):
    return [(message.place.row, message.text) for message in readings.messages if message.code == code]


WIDE = {
    "en": "Valve;Land;Piston [mm];Bore [mm];",
    "de": "Ventil;Steg;Kolben [mm];Bohrung [mm];",
    "pl": "Zawór;Land;Tłok [mm];Otwór [mm];",
}


@pytest.mark.parametrize(
    ("language", "heading", "right", "wrong", "says", "makes"),
    [
        ("en", "Clearance D-d [µm]", "43", "34", "34 µm", "54 µm"),
        ("en", "Radial clearance [µm]", "21.5", "17", "17 µm", "27 µm"),
        ("en", "Clearance", "0.043", "0.034", "0.034 mm", "0.054 mm"),
        ("de", "Spiel [µm]", "43", "34", "34 µm", "54 µm"),
        ("pl", "Luz [mm]", "0,043", "0,034", "0.034 mm", "0.054 mm"),
    ],
)
def test_a_clearance_that_contradicts_the_diameters_beside_it(controller, language, heading, right, wrong, says, makes):
    readings = read(
        controller,
        WIDE[language] + heading,
        f"accumulator;1;17.998;18.041;{right}",
        f"tcc_regulator;1;10.979;11.033;{wrong}",
    )
    assert len(readings.readings) == 4
    text = f"row 3: column {heading!r} says {says}, and the diameters make {makes}: a slip in one of them"
    assert warnings(readings, "clearance_disagrees") == [(3, text)]


@pytest.mark.parametrize(
    "heading", ["Mounting clearance [µm]", "Clearance max [µm]", "Sollspiel [µm]", "Luz nominalny [µm]"]
)
def test_a_clearance_that_is_not_of_these_diameters(controller, heading):
    readings = read(controller, WIDE["en"] + heading, "accumulator;1;17.998;18.041;20")
    assert warnings(readings, "clearance_disagrees") == []


def test_a_clearance_beside_the_bore_of_a_tidy_table(controller):
    readings = read(
        controller,
        "Valve;Land;Part;Diameter [mm];Clearance [mm]",
        *("accumulator;1;piston;17.998;", "accumulator;1;bore;18.041;0.063"),
    )
    assert [row for row, _ in warnings(readings, "clearance_disagrees")] == [3]


def test_many_contradictions_are_counted(controller):
    rows = [f"accumulator;1;{17.998 - index / 1000:.3f};18.041;99" for index in range(8)]
    readings = read(controller, WIDE["en"] + "Clearance [µm]", *rows)
    disagreements = warnings(readings, "clearance_disagrees")
    assert len(disagreements) == 6
    assert disagreements[-1][1].startswith("3 more rows")


@pytest.mark.parametrize(
    ("headings", "part", "mean"),
    [
        ("Valve;Land;Part;Diameter 1 [mm];Diameter 2 [mm]", "bore", "Mean [mm]"),
        ("Ventil;Steg;Teil;Messung 1 [mm];Messung 2 [mm]", "Bohrung", "Mittelwert [mm]"),
        ("Zawór;Land;Część;Pomiar 1 [mm];Pomiar 2 [mm]", "otwór", "Średnia [mm]"),
    ],
)
def test_a_column_of_means(controller, headings, part, mean):
    readings = read(
        controller,
        f"{headings};{mean}",
        f"accumulator;1;{part};18.041;18.043;18.042",
        f"tcc_regulator;1;{part};11.033;11.035;11.044",
    )
    ((row, text),) = warnings(readings, "mean_disagrees")
    assert row == 3
    assert "says 11.044 mm, and the diameters make 11.034 mm" in text


def test_a_mean_over_directions_in_its_first_row(controller):
    rows = ["accumulator;1;bore;0;18.041;18.043", "accumulator;1;bore;90;18.045;"]
    readings = read(controller, "Valve;Land;Part;Direction;Diameter [mm];Mean [mm]", *rows)
    assert warnings(readings, "mean_disagrees") == []


@pytest.mark.parametrize(
    "heading", ["Ring error [µm]", "Correction [µm]", "Korrektur [µm]", "Poprawka [µm]", "Offset [µm]"]
)
def test_a_correction_is_not_applied_and_that_is_said(controller, heading):
    headings = f"Valve;Land;Part;Diameter [mm];{heading}"
    readings = read(controller, headings, "accumulator;1;piston;17.998;2", "accumulator;1;bore;18.041;0")
    assert [round(reading.diameter * 1e3, 6) for reading in readings.readings] == [17.998, 18.041]
    ((row, text),) = warnings(readings, "correction_not_applied")
    assert (row, "not applied" in text) == (2, True)
    readings = read(controller, headings, "accumulator;1;piston;17.998;0", "accumulator;1;bore;18.041;0.0")
    assert warnings(readings, "correction_not_applied") == []


@pytest.mark.parametrize("heading", ["Check gauge [mm]", "Setting ring [mm]", "Gauge check [mm]"])
def test_the_diameter_of_a_gauge_is_no_correction(controller, heading):
    headings = f"Valve;Land;Part;{heading};Diameter [mm]"
    found = read(controller, headings, "accumulator;1;piston;18.000;17.988", "accumulator;1;bore;18.000;18.071")
    assert [round(reading.diameter * 1e3, 6) for reading in found.readings] == [17.988, 18.071]
    assert warnings(found, "correction_not_applied") == []
    ((_, text),) = warnings(found, "column_aside")
    assert f"column {heading!r} is left aside (the diameter of a gauge or standard)" in text


@pytest.mark.parametrize(
    ("line", "count"), [("Ring error: +2 µm", 1), ("Korrektur;-0,001", 1), ("Ring error;0.000", 0)]
)
def test_a_correction_above_the_table(controller, line, count):
    readings = read(controller, line, "Valve;Land;Part;Diameter [mm]", "accumulator;1;piston;17.998")
    assert len(warnings(readings, "correction_not_applied")) == count


def test_a_corrected_diameter_needs_no_word(controller):
    readings = read(
        controller,
        "Valve;Land;Part;Indicated [mm];Correction [µm];Corrected [mm]",
        "accumulator;1;piston;17.996;2;17.998",
    )
    assert [round(reading.diameter * 1e3, 6) for reading in readings.readings] == [17.998]
    assert warnings(readings, "correction_not_applied") == []


@pytest.mark.parametrize(
    "line",
    [
        "Controller zf_five_speed",
        "Controller zf_five_speed. Yellow cells are to be filled in",
        "Controller: zf_five_speed",
        "Controller;zf_five_speed",
    ],
)
def test_a_sheet_of_another_controller_is_refused(controller, line):
    with pytest.raises(ReadingsError, match="made for controller zf_five_speed, not for minimal_example") as caught:
        read(controller, line, "Valve;Land;Part;Diameter [mm]", "accumulator;1;piston;17.998")
    assert caught.value.place.row == 1
    assert "--controller zf_five_speed" in caught.value.expected


@pytest.mark.parametrize(
    "line",
    [
        "Controller hv3",
        "Controller hv3. Yellow cells are to be filled in. All dimensions in mm",
        "Schieberkasten hv3. Gelbe Zellen sind auszufüllen. Alle Maße in mm",
        "Sterownik hv3. Wypełnia się żółte komórki. Wszystkie wymiary w mm",
    ],
)
def test_the_line_of_a_form_is_believed_whatever_the_id(controller, line):
    with pytest.raises(ReadingsError, match="made for controller hv3, not for minimal_example"):
        read(controller, line, "Valve;Land;Part;Diameter [mm]", "no_such_valve;1;piston;17.998")


@pytest.mark.parametrize(
    "line",
    [
        "Controller minimal_example",
        "Controller cleaned. Three valves were stuck",
        "Measurement of controller no. 3",
        "Controller: Mechatronik 0B5, no. 3",
        "Controller;third of May",
    ],
)
def test_a_sheet_that_names_this_controller_or_none(controller, line):
    readings = read(controller, line, "Valve;Land;Part;Diameter [mm]", "accumulator;1;piston;17.998")
    assert len(readings.readings) == 1


def test_the_form_of_another_controller_is_refused(controller):
    with pytest.raises(ReadingsError, match="made for controller four_speed_2023, not for minimal_example"):
        read_readings(write_template(load_controller("four_speed_2023")), controller)
