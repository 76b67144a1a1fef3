"""A job's values written anew into plain files: read back they are the same, and nothing else stands there."""

from __future__ import annotations

import datetime as dt
from dataclasses import replace

import numpy as np
import pytest

from atleak.catalogue.controller import Controller
from atleak.catalogue.pump import PumpClearances
from atleak.job_book.plain_files import plain_gauges, plain_log, plain_sheet
from atleak.measurements.readings import FittedRepair, OwnLands, OwnLength, Readings
from atleak.readers.gauges.gauge_table import read_pressure_table
from atleak.readers.logs import understand
from atleak.readers.sheets.measuring_sheet import read_readings

INCH = b"""No.;Note;part;plane;diameter 1 [inch];diameter 2 [inch]
6;of Zyxwvut;spool;1;0,39130;0,39134
6;;sleeve;1;0,39492;0,39488
8;;spool;1;0,39370;0,39371
"""


def diameters(readings: Readings) -> dict[tuple[object, ...], list[float]]:
    said: dict[tuple[object, ...], list[float]] = {}
    for each in readings.readings:
        said.setdefault(each.station, []).append(each.diameter)
    return said


def test_a_sheet_in_inches_without_directions_reads_the_same_in_millimetres(four_speed: Controller) -> None:
    readings = read_readings(INCH, four_speed, name="of Zyxwvut.csv")
    plain = plain_sheet(readings, four_speed)
    assert plain is not None
    again = read_readings(plain.content, four_speed)
    assert set(diameters(again)) == set(diameters(readings))
    for station, values in diameters(readings).items():
        assert diameters(again)[station] == pytest.approx(values, abs=1e-12)


def test_head_lengths_and_fitted_repairs_are_kept(three_circuits: Controller) -> None:
    sheet = b"component,part,plane,diameter [mm]\n2,spool,1,10.000\n2,sleeve,1,10.070\n"
    lengths = OwnLands((OwnLength("2", 1, 0.0052, 0.011),))
    readings = replace(
        read_readings(sheet, three_circuits),
        temperature=31.5,
        date=dt.date(2026, 4, 17),
        own_lands=lengths,
        pump=PumpClearances.of_um(32.5, None),
    )
    plain = plain_sheet(readings, three_circuits)
    assert plain is not None
    again = read_readings(plain.content, three_circuits)
    assert (again.temperature, again.date, again.pump) == (31.5, dt.date(2026, 4, 17), readings.pump)
    (length,) = again.own_lands.lengths
    assert length.key == ("2", 1)
    assert (length.contact_length, length.position) == pytest.approx((0.0052, 0.011), abs=1e-12)


def test_what_would_be_read_otherwise_is_not_given(four_speed: Controller) -> None:
    readings = read_readings(INCH, four_speed)
    unknown = replace(readings, own_lands=OwnLands((), (FittedRepair("6", "no_such_repair"),)))
    assert plain_sheet(unknown, four_speed) is None


@pytest.mark.parametrize(
    "log",
    [
        # a clock of the day, a stretch without rows, an error code, a column with a name in it
        "Zyxwvut;time;rpm;line pressure [psi];ATF temperature [F]\n"
        + "".join(
            f"x;10:{row // 600 + (row > 300):02d}:{row % 600 / 10:04.1f};{65535 if row == 40 else 900 + row};"
            f"{70 + row / 10:.1f};{150 + row / 50:.2f}\n"
            for row in range(600)
        ),
        # the clock starts anew half-way
        "time [s],rpm,gear\n" + "".join(f"{row % 200 / 10},{800 + row},{1 + row // 200}\n" for row in range(400)),
        # each channel with its own clock
        "time [s],rpm,time [s],line pressure [kPa]\n"
        + "".join(f"{row / 10},{800 + row},{row / 10 + 0.03:.2f},{500 + row % 7}\n" for row in range(200)),
    ],
)
def test_the_channels_of_a_log_read_the_same(log: str) -> None:
    test = understand(log.encode(), name="of Zyxwvut.csv").road_test
    assert test is not None
    plain = plain_log(test, ())
    assert plain is not None
    assert b"Zyxwvut" not in plain.file.content
    again = understand(plain.file.content, mapping=dict(plain.columns), units=dict(plain.units)).road_test
    assert again is not None
    assert len(again.segments) == len(test.segments)
    for quantity, channel in test.channels.items():
        np.testing.assert_allclose(again.channels[quantity].good, channel.good, rtol=1e-9, atol=1e-9)


def test_gauge_readings_keep_repeats_temperature_and_speed(three_circuits: Controller) -> None:
    table = read_pressure_table(
        "range;state;repeat;gauge [psi];ATF temperature [°C];engine speed [rpm];by\n"
        "D;idle;1;60,5;82;700;Zyxwvut\nD;idle;2;61;82;700;Zyxwvut\nR;stall;1;200;85;2100;Zyxwvut\n".encode(),
        three_circuits,
    )
    plain = plain_gauges(table, three_circuits)
    assert plain is not None
    assert b"Zyxwvut" not in plain.content
    again = read_pressure_table(plain.content, three_circuits)
    assert [each.pressure for each in again.readings] == pytest.approx(
        [each.pressure for each in table.readings], abs=1e-3
    )
    assert [(each.temperature, each.repeat) for each in again.readings] == [(82.0, 1), (82.0, 2), (85.0, 1)]
