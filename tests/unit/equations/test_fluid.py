"""Viscosity and density: round trips, properties and domain."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import brentq

from atleak.equations import DomainError, fluid

# Data sheets: kinematic viscosity at 100 °C, and how many times that at 40 °C.
sheets = st.tuples(st.floats(2e-6, 30e-6), st.floats(1.5, 15.0))


@given(sheets)
def test_astm_d341_goes_through_both_points_in_either_order(sheet: tuple[float, float]) -> None:
    nu_100, times = sheet
    nu_40 = nu_100 * times
    constants = fluid.astm_d341_coefficients(40.0, nu_40, 100.0, nu_100)
    assert fluid.astm_d341(40.0, *constants) == pytest.approx(nu_40, rel=1e-11, abs=0.0)
    assert fluid.astm_d341(100.0, *constants) == pytest.approx(nu_100, rel=1e-11, abs=0.0)
    assert fluid.astm_d341_coefficients(100.0, nu_100, 40.0, nu_40) == pytest.approx(constants, rel=1e-11, abs=0.0)


@given(sheets, st.floats(-40.0, 150.0), st.floats(0.1, 20.0))
def test_astm_d341_falls_with_temperature(sheet: tuple[float, float], temperature: float, step: float) -> None:
    constants = fluid.astm_d341_coefficients(40.0, sheet[0] * sheet[1], 100.0, sheet[0])
    assert fluid.astm_d341(temperature + step, *constants) < fluid.astm_d341(temperature, *constants)


@given(sheets, st.floats(-40.0, 150.0))
def test_astm_d341_satisfies_the_printed_equation(sheet: tuple[float, float], temperature: float) -> None:
    a, b = fluid.astm_d341_coefficients(40.0, sheet[0] * sheet[1], 100.0, sheet[0])
    nu = fluid.astm_d341(temperature, a, b) * 1e6
    left = math.log10(math.log10(nu + 0.7))
    assert left == pytest.approx(a - b * math.log10(temperature + 273.15), abs=1e-12)


def test_temperature_is_found_back_from_viscosity() -> None:
    a, b = fluid.astm_d341_coefficients(40.0, 37e-6, 100.0, 7e-6)
    nu = fluid.astm_d341(63.0, a, b)
    assert brentq(lambda t: fluid.astm_d341(t, a, b) - nu, -20.0, 140.0, xtol=1e-12) == pytest.approx(
        63.0, rel=1e-9, abs=0.0
    )


def test_constants_of_several_fluids_at_once() -> None:
    nu_40, nu_100 = np.array([42e-6, 37e-6]), np.array([7.0e-6, 7.0e-6])
    a, b = fluid.astm_d341_coefficients(40.0, nu_40, 100.0, nu_100)
    both = fluid.astm_d341(np.array([[20.0], [80.0]]), a, b)
    assert both.shape == (2, 2)
    for i, nu in enumerate(nu_40):
        single = fluid.astm_d341_coefficients(40.0, float(nu), 100.0, 7.0e-6)
        assert both[1, i] == pytest.approx(fluid.astm_d341(80.0, *single), rel=1e-13, abs=0.0)


def test_astm_d341_reaches_down_to_its_own_limit() -> None:
    a, b = fluid.astm_d341_coefficients(40.0, 1e-6, 100.0, 0.31e-6)
    assert fluid.astm_d341(100.0, a, b) == pytest.approx(0.31e-6, rel=1e-9, abs=0.0)


def test_a_fluid_of_constant_viscosity() -> None:
    a, b = fluid.astm_d341_coefficients(40.0, 10e-6, 100.0, 10e-6)
    assert b == 0.0
    assert fluid.astm_d341([-20.0, 120.0], a, b).tolist() == pytest.approx([10e-6, 10e-6], rel=1e-12, abs=0.0)


@pytest.mark.parametrize(
    ("points", "words"),
    [
        ((-273.15, 42e-6, 100.0, 7e-6), "temperature must be above -273.15 °C, found -273.15 °C"),
        ((40.0, 42e-6, -300.0, 7e-6), "temperature"),
        ((40.0, 0.0, 100.0, 7e-6), "kinematic viscosity"),
        ((40.0, 42e-6, 100.0, -7e-6), "kinematic viscosity"),
        ((40.0, 42e-6, 100.0, 0.3e-6), "kinematic viscosity"),
        ((40.0, 42e-6, 40.0, 7e-6), "different from the first"),
        ((40.0, 7e-6, 100.0, 42e-6), "falls as temperature rises"),
        ((100.0, 42e-6, 40.0, 7e-6), "falls as temperature rises"),
    ],
)
def test_data_sheet_points_out_of_domain(points: tuple, words: str) -> None:
    with pytest.raises(DomainError, match=words):
        fluid.astm_d341_coefficients(*points)


@pytest.mark.parametrize("temperature", [-273.15, -1000.0])
def test_astm_d341_refuses_absolute_zero(temperature: float) -> None:
    a, b = fluid.astm_d341_coefficients(40.0, 42e-6, 100.0, 7e-6)
    with pytest.raises(DomainError, match=r"temperature must be above -273\.15 °C"):
        fluid.astm_d341(temperature, a, b)
    with pytest.raises(DomainError, match="at index 1"):
        fluid.astm_d341([20.0, temperature], a, b)


def test_astm_d341_refuses_to_be_infinite() -> None:
    a, b = fluid.astm_d341_coefficients(40.0, 42e-6, 100.0, 7e-6)
    for temperature in (-270.0, np.full(1000, -270.0)):
        with pytest.raises(DomainError, match="finite, found -270 °C"):
            fluid.astm_d341(temperature, a, b)


def test_astm_d341_is_reliable_from_minus_20() -> None:
    assert fluid.astm_d341_reliable(-20.0) is True
    assert fluid.astm_d341_reliable(-20.01) is False
    assert fluid.astm_d341_reliable(math.nan) is False
    answers = fluid.astm_d341_reliable(np.array([-40.0, 20.0, math.nan]))
    assert answers.dtype == bool
    assert answers.tolist() == [False, True, False]


@pytest.mark.parametrize("regression", [fluid.study_viscosity, fluid.study_density])
def test_regressions_end_where_the_study_ends(regression) -> None:
    assert regression(-40.0) > regression(100.0) > 0.0
    for outside in (-40.001, 100.001, math.inf):
        with pytest.raises(DomainError, match="between -40 and 100 °C"):
            regression(outside)
    assert np.isnan(regression([-40.0, math.nan, 100.0])).tolist() == [False, True, False]
    with pytest.raises(DomainError, match=r"found 101 °C at index 2"):
        regression([20.0, math.nan, 101.0, -50.0])


@given(st.floats(-40.0, 99.0), st.floats(0.01, 1.0))
def test_regressions_fall_with_temperature(temperature: float, step: float) -> None:
    assert fluid.study_viscosity(temperature + step) < fluid.study_viscosity(temperature)
    assert fluid.study_density(temperature + step) < fluid.study_density(temperature)


@given(st.floats(-40.0, 100.0))
def test_regressions_equal_their_printed_form(temperature: float) -> None:
    printed = 343.92 * math.exp(-0.043 * temperature)
    assert fluid.study_viscosity(temperature) * 1e6 == pytest.approx(printed, rel=1e-13, abs=0.0)
    assert fluid.study_density(temperature) / 1e3 == pytest.approx(-0.0007 * temperature + 0.8409, rel=1e-13, abs=0.0)


def test_dynamic_viscosity_in_the_units_of_the_trade() -> None:
    # mm²/s × g/cm³ = mPa·s
    assert fluid.dynamic_viscosity(7.0e-6, 768.0) * 1e3 == pytest.approx(7.0 * 0.768, rel=1e-14, abs=0.0)
    for bad in ((0.0, 800.0), (1e-5, 0.0), (-1e-5, 800.0)):
        with pytest.raises(DomainError):
            fluid.dynamic_viscosity(*bad)
