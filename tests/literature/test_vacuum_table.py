"""A vacuum stand's readings, worked apart: two lands of 14.5 mm, 5 mm long, supply 25 in-Hg, C_d 0.8."""

from __future__ import annotations

import math

import pytest

from atleak.equations import vacuum

INCH = 3386.39  # [Pa]
AMBIENT = 101_325.0
KELVIN_293 = 293.0 - 273.15
CLEARANCES = (6, 10, 13, 20, 30, 45, 60)  # [µm], concentric
READINGS = {  # [in-Hg] laminar, without entry loss, by the stand's orifice [mm]
    0.5: (24.965, 24.256, 21.587, 10.727, 3.791, 1.181, 0.504),
    1.0: (24.998, 24.953, 24.774, 22.132, 12.130, 4.434, 1.964),
}
TOUCHING = {0.5: 4.990, 1.0: 14.765}  # 20 µm
WITH_ENTRY_LOSS = {30: 12.30, 45: 4.61, 60: 2.08}  # 1 mm
ROWS = [
    (orifice, clearance, 1.0, reading)
    for orifice, readings in READINGS.items()
    for clearance, reading in zip(CLEARANCES, readings, strict=True)
] + [(orifice, 20, 2.5, reading) for orifice, reading in TOUCHING.items()]


def reading_of(orifice: float, clearance: float, factor: float, loss: float) -> float:
    area = 0.8 * math.pi / 4.0 * (orifice * 1e-3) ** 2
    lands = [0.0145] * 2, [clearance * 1e-6] * 2, [0.005] * 2
    supply = AMBIENT - 25.0 * INCH
    pressure = vacuum.circuit_pressure(supply, AMBIENT, area, *lands, KELVIN_293, 1.81e-5, factor, loss)
    return (AMBIENT - pressure) / INCH


@pytest.mark.parametrize(("orifice", "clearance", "factor", "reading"), ROWS)
def test_the_laminar_table(orifice: float, clearance: float, factor: float, reading: float) -> None:
    assert reading_of(orifice, clearance, factor, 0.0) == pytest.approx(reading, abs=6e-4)


@pytest.mark.parametrize(("clearance", "reading"), WITH_ENTRY_LOSS.items())
def test_with_entry_loss(clearance: float, reading: float) -> None:
    assert reading_of(1.0, clearance, 1.0, 1.5) == pytest.approx(reading, abs=6e-3)


def test_what_half_an_inch_of_mercury_is_in_clearance() -> None:
    """± 0.5 in-Hg: 0.5 µm at 25 µm and 1.9 at 45 with 1 mm; 0.9 at 6 and 0.2 at 10 with 0.25 mm."""
    for orifice, clearance, expected in (
        (1.0, 25, 0.5),
        (1.0, 45, 1.9),
        (0.25, 6, 0.9),
        (0.25, 10, 0.2),
    ):
        near = [reading_of(orifice, clearance + step, 1.0, 0.0) for step in (-0.01, 0.01)]
        assert 0.5 * 0.02 / (near[0] - near[1]) == pytest.approx(expected, abs=0.06), (orifice, clearance)


def test_a_touching_spool_passes_more_than_twice_the_air() -> None:
    """A reading that means 30 µm concentric means 22 µm if the spool touches its bore."""
    area, supply = 0.8 * math.pi / 4.0 * 1e-6, AMBIENT - 25.0 * INCH
    pressure = AMBIENT - 12.30 * INCH
    flow = vacuum.orifice_air_flow(pressure, supply, area, KELVIN_293)
    lands = (flow, pressure, AMBIENT, [0.0145] * 2, [0.005] * 2, KELVIN_293, 1.81e-5)
    assert vacuum.equal_clearance(*lands) == pytest.approx(30e-6, abs=0.05e-6)
    assert vacuum.equal_clearance(*lands, 2.5) == pytest.approx(22e-6, abs=0.3e-6)
