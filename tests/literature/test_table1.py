"""Table 1 of the source study: the readings of spool 6, as printed.

Dziubak & Szczepaniak, Energies 2023, 16, 7667, doi 10.3390/en16227667. Printed in mm to 0.001. Of the
two directions only 90° is printed; the other one is 0°.
"""

from __future__ import annotations

import io

import openpyxl
import pytest

from atleak.catalogue.controller_file import load_controller
from atleak.measurements.clearances import clearances
from atleak.readers.sheets.measuring_sheet import read_readings

HEADINGS = (
    *("No. Acc. to Figure 8", "Component", "Measurement Plane", "Measurement Direction:"),
    *("Coordinate x1 (y1) [mm]", "Coordinate x2 (y2) [mm]"),
    *("Diameter: x1-x2 (y1-y2) [mm]", "Diameter Mean Value di (Di) [mm]"),
)
ROWS = (  # plane, direction, coordinate 1, coordinate 2, diameter, mean of the plane
    (1, "0°", 89.605, 79.666, 9.939, 9.939),
    (1, "0°", 79.666, 89.605, 9.939, 9.939),
    (1, "90°", 86.422, 76.483, 9.939, 9.939),
    (1, "90°", 76.483, 86.422, 9.939, 9.939),
    (2, "0°", 84.371, 74.430, 9.941, 9.942),
    (2, "0°", 74.430, 84.371, 9.941, 9.942),
    (2, "90°", 85.121, 75.178, 9.943, 9.942),
    (2, "90°", 75.178, 85.121, 9.943, 9.942),
)
MERGED = ("A2:A9", "B2:B9", "C2:C5", "C6:C9", "D2:D3", "D4:D5", "D6:D7", "D8:D9", "H2:H5", "H6:H9")


def as_workbook(*, diameters: bool, coordinates: bool = True) -> bytes:
    """The printed form: what holds for several rows stands once, in a merged cell."""
    book = openpyxl.Workbook()
    sheet = book.active
    sheet.append(HEADINGS)
    for plane, direction, one, other, diameter, mean in ROWS:
        both = (one, other) if coordinates else (None, None)
        sheet.append((6, "spool", plane, direction, *both, diameter if diameters else None, mean))
    for cells in MERGED:
        sheet.merge_cells(cells)
    buffer = io.BytesIO()
    book.save(buffer)
    return buffer.getvalue()


def as_text(delimiter: str, decimal: str) -> bytes:
    """Every cell written out, as text has no merged cells."""
    headings = ("component_no", "component", "measurement_plane", "measurement_direction", "coordinate_1_mm",
                "coordinate_2_mm", "diameter_mm", "diameter_mean_mm")  # fmt: skip
    lines = [delimiter.join(headings)]
    for plane, direction, *numbers in ROWS:
        written = [f"{number:.3f}".replace(".", decimal) for number in numbers]
        lines.append(delimiter.join(["6", "spool", str(plane), direction, *written]))
    return "\r\n".join(lines).encode()


SHEETS = {
    "workbook": as_workbook(diameters=True),
    "workbook, coordinates only": as_workbook(diameters=False),
    "workbook, diameters only": as_workbook(diameters=True, coordinates=False),
    "text": as_text(",", "."),
    "text, decimal comma": as_text(";", ","),
}


@pytest.fixture(scope="module")
def study():
    return load_controller("four_speed_2023")


@pytest.fixture(scope="module", params=SHEETS)
def readings(request, study):
    return read_readings(SHEETS[request.param], study, name="table 1")


def test_the_eight_readings_as_printed(readings):
    assert [(each.plane, f"{each.direction:g}°", each.repeat) for each in readings.readings] == [
        (str(plane), direction, 1 + index % 2) for index, (plane, direction, *_) in enumerate(ROWS)
    ]
    for each, (_, _, _, _, diameter, _) in zip(readings.readings, ROWS, strict=True):
        assert (each.component, each.part) == ("6", "spool")
        assert each.diameter * 1e3 == pytest.approx(diameter, abs=1e-12)
    assert (readings.unit, readings.unit_assumed) == ("mm", False)


def test_the_means_of_the_two_planes_as_printed(readings, study):
    states = {state.land.key: state for state in clearances(readings, study)}
    assert f"{states['6', 1].spool_diameter * 1e3:.3f}" == "9.939"
    assert f"{states['6', 2].spool_diameter * 1e3:.3f}" == "9.942"
    assert states["6", 1].spool_ovality == pytest.approx(0.0, abs=1e-15)
    assert states["6", 2].spool_ovality == pytest.approx(2e-6, abs=1e-15)
    assert {state.status for key, state in states.items() if key[0] == "6"} == {"spool_only"}
    assert {state.status for key, state in states.items() if key[0] != "6"} == {"not_measured"}


def test_its_repeats_only_swap_the_coordinates(readings, study):
    spool = {state.land.key: state for state in clearances(readings, study)}["6", 1]
    mirrored = "mirrored_repeats" in [message.code for message in spool.messages]
    if readings.readings[0].coordinates is None:  # diameters alone cannot show it
        assert not mirrored
        assert (spool.spool_repeats, spool.spool_repeat_spread) == (2, 0.0)
    else:
        assert mirrored
        assert (spool.spool_readings, spool.spool_repeats, spool.spool_repeat_spread) == (4, 1, None)
