"""Viscosity and density against published numbers, at the sources' own precision."""

from __future__ import annotations

import pytest

from atleak.equations.fluid import astm_d341, astm_d341_coefficients, dynamic_viscosity, study_density, study_viscosity

# Dziubak & Szczepaniak, Energies 2023, 16, 7667, table 2: temperature °C, viscosity mm²/s, density g/cm³.
TABLE_2 = [(80.0, 10.93, 0.783), (-40.0, 1923.0, 0.870), (20.0, 145.0, 0.826)]


@pytest.mark.parametrize(("temperature", "viscosity", "density"), TABLE_2)
def test_regressions_give_table_2(temperature: float, viscosity: float, density: float) -> None:
    # The exponent is printed with two digits, 0.0425 … 0.0435, which would allow 4 % at 80 °C.
    assert study_viscosity(temperature) * 1e6 == pytest.approx(viscosity, rel=0.01, abs=0.0)
    assert study_density(temperature) / 1e3 == pytest.approx(density, abs=0.003)


def test_regression_between_the_data_sheet_points_of_table_2() -> None:
    # Table 2 prints the data sheet's 42.0 and 7.0 here; the study's own regression says otherwise.
    assert study_viscosity(40.0) * 1e6 == pytest.approx(61.6, abs=0.05)
    assert study_viscosity(100.0) * 1e6 == pytest.approx(4.67, abs=0.005)


def test_astm_d341_of_a_published_spreadsheet() -> None:
    # A public D341 calculator for 32 and 5.4 mm²/s at 40 and 100 °C, kelvins counted from -273 °C.
    a, b = astm_d341_coefficients(313 - 273.15, 32e-6, 373 - 273.15, 5.4e-6)
    assert a == pytest.approx(9.5259, abs=0.00005)
    assert b == pytest.approx(3.7449, abs=0.00005)
    assert astm_d341(353 - 273.15, a, b) * 1e6 == pytest.approx(8.5, abs=0.05)


def test_astm_d341_of_the_study_fluid() -> None:
    # HIPOL ATF IID, 42 and 7.0 mm²/s; figures computed with 40 decimal digits.
    a, b = astm_d341_coefficients(40.0, 42e-6, 100.0, 7.0e-6)
    assert astm_d341(-40.0, a, b) * 1e6 == pytest.approx(35155.34360987331, rel=1e-10, abs=0.0)
    assert astm_d341(20.0, a, b) * 1e6 == pytest.approx(111.71808660326727, rel=1e-12, abs=0.0)
    assert astm_d341(80.0, a, b) * 1e6 == pytest.approx(11.146168227024881, rel=1e-12, abs=0.0)


def test_cold_fluid_is_some_18_times_as_viscous_as_the_regression_says() -> None:
    a, b = astm_d341_coefficients(40.0, 42e-6, 100.0, 7.0e-6)
    assert astm_d341(-40.0, a, b) / study_viscosity(-40.0) == pytest.approx(18.3, abs=0.05)
    # Real Dexron IID has about 33 000 mPa·s there.
    assert dynamic_viscosity(astm_d341(-40.0, a, b), 870.0) * 1e3 == pytest.approx(33000, rel=0.1, abs=0.0)
