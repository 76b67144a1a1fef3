"""Numbers between a controller's file and a workbook."""

from __future__ import annotations

import itertools

import pytest
from hypothesis import given
from hypothesis import strategies as st

from atleak.catalogue.workbook.cells import (
    CLEARANCE,
    CLEARANCES,
    EXPANSION,
    LENGTH,
    LENGTHS,
    NUMBER,
    PRESSURE,
    PRESSURES,
    SMALL_LENGTH,
    VOLUME,
    Measure,
    Number,
    Units,
)

EVERY = [Units(*choice) for choice in itertools.product(LENGTHS, CLEARANCES, PRESSURES)]
MEASURES = [LENGTH, SMALL_LENGTH, CLEARANCE, VOLUME, PRESSURE, EXPANSION, NUMBER]
INCH = Units("inch", "diametral", "psi")


@given(st.floats(1e-7, 1e7), st.sampled_from(EVERY), st.sampled_from(MEASURES))
def test_any_number_comes_back_to_the_last_digit(value: float, units: Units, measure: Measure) -> None:
    assert measure.file_number(measure.cell_number(value, units), units) == value


@given(st.integers(1, 99_999_999), st.integers(0, 7), st.sampled_from(EVERY), st.sampled_from(MEASURES))
def test_a_number_as_people_write_it_stays_a_number(digits: int, decimals: int, units: Units, measure: Measure) -> None:
    value = float(f"{digits}e-{decimals}")
    cell = measure.cell_number(value, units)
    assert isinstance(cell, float)
    assert measure.file_number(cell, units) == value
    # a program that keeps 15 digits of a number loses nothing either
    assert measure.file_number(float(f"{cell:.15g}"), units) == value


@pytest.mark.parametrize(
    ("cell", "measure", "value"),
    [
        (0.571, LENGTH, 14.5034),
        (0.388, LENGTH, 9.8552),
        (0.001, CLEARANCE, 12.7),
        (0.0005, CLEARANCE, 6.35),
        (100.0, PRESSURE, 689.4757293168),  # 100 lbf/in², NIST SP 811: 6894.757 Pa each
        (1.0, VOLUME, 16387.064),
    ],
)
def test_inches_and_diameters_are_converted_exactly(cell: float, measure: Measure, value: float) -> None:
    assert measure.file_number(cell, INCH) == value


def test_headings_say_the_unit_and_how_a_clearance_is_meant() -> None:
    assert Number(CLEARANCE).label(Units()) == "µm, radial"
    assert Number(CLEARANCE).label(INCH) == "inch, diametral"
    assert Number(PRESSURE).label(INCH) == "psi"
