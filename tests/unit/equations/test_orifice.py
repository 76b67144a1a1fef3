"""Flow through feeds and leaks: two limits, slopes, units, and the pressure that a fed circuit holds."""

from __future__ import annotations

import math

import numpy as np
import pint
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import brentq

from atleak.equations import DomainError, gap, orifice

diameters = st.floats(0.2e-3, 10e-3)
discharges = st.floats(0.5, 1.0)
viscosities = st.floats(2e-6, 0.05)
densities = st.floats(700.0, 950.0)
drops = st.floats(-2e6, 2e6)
coefficients = st.floats(1e-10, 1e-5)
transitions = st.floats(1.0, 1e6)


# --- units -----------------------------------------------------------------------------------------------


def test_pint_computes_the_same_coefficient_and_transition() -> None:
    u = pint.UnitRegistry()
    d, c_d, nu, rho = 0.5 * u.mm, 0.62, 6.2 * u.mm**2 / u.s, 0.797 * u.g / u.cm**3
    area = math.pi * d**2 / 4
    flow = (c_d * area * (2 * 100 * u.kPa / rho) ** 0.5).to(u.m**3 / u.s).magnitude
    assert orifice.turbulent_coefficient(0.5e-3, 0.62, 797.0) * math.sqrt(100e3) == pytest.approx(
        flow, rel=1e-12, abs=0.0
    )
    transition = (math.pi * rho / (8 * area) * (nu * 150 / c_d) ** 2).to(u.Pa).magnitude
    assert orifice.transition_pressure(0.5e-3, 0.62, 6.2e-6, 797.0) == pytest.approx(transition, rel=1e-12, abs=0.0)


@given(diameters, discharges, viscosities, densities)
def test_the_transition_is_where_the_discharged_velocity_has_the_critical_reynolds_number(
    d: float, c_d: float, nu: float, rho: float
) -> None:
    p = orifice.transition_pressure(d, c_d, nu, rho, 150.0)
    assert c_d * math.sqrt(2.0 * p / rho) * d / nu == pytest.approx(150.0, rel=1e-12, abs=0.0)


# --- the orifice -----------------------------------------------------------------------------------------


@given(drops, coefficients, transitions)
def test_flow_is_odd_and_its_slope_even(p: float, k: float, p_cr: float) -> None:
    assert orifice.orifice_flow(-p, k, p_cr) == -orifice.orifice_flow(p, k, p_cr)
    (flow, slope), (back, other) = (orifice.orifice_flow_and_slope(each, k, p_cr) for each in (p, -p))
    assert flow == -back == orifice.orifice_flow(p, k, p_cr)
    assert slope == other > 0.0


@given(drops, st.floats(1e-3, 1e6), coefficients, transitions)
def test_flow_rises_with_the_pressure_drop(p: float, more: float, k: float, p_cr: float) -> None:
    assert orifice.orifice_flow(p + more, k, p_cr) > orifice.orifice_flow(p, k, p_cr)


@given(st.floats(-50.0, 50.0), coefficients, transitions)
def test_the_slope_is_the_derivative(ratio: float, k: float, p_cr: float) -> None:
    p, step = ratio * p_cr, 1e-5 * p_cr
    rise = orifice.orifice_flow(p + step, k, p_cr) - orifice.orifice_flow(p - step, k, p_cr)
    assert orifice.orifice_flow_and_slope(p, k, p_cr)[1] == pytest.approx(rise / (2 * step), rel=1e-7, abs=0.0)


@given(coefficients, transitions)
def test_far_from_the_transition_flow_is_turbulent_or_laminar(k: float, p_cr: float) -> None:
    high, low = 1e4 * p_cr, 1e-4 * p_cr
    assert orifice.orifice_flow(high, k, p_cr) == pytest.approx(k * math.sqrt(high), rel=1e-8, abs=0.0)
    assert orifice.orifice_flow(low, k, p_cr) == pytest.approx(k * low / math.sqrt(p_cr), rel=1e-8, abs=0.0)
    assert orifice.orifice_flow(p_cr, k, p_cr) == pytest.approx(k * math.sqrt(p_cr) * 2**-0.25, rel=1e-12, abs=0.0)


def test_no_pressure_drop_or_a_shut_orifice_passes_nothing() -> None:
    assert orifice.orifice_flow(0.0, 6e-9, 3587.0) == 0.0
    assert orifice.orifice_flow(4e5, 0.0, 3587.0) == 0.0
    assert orifice.orifice_flow_and_slope(4e5, 0.0, 3587.0) == (0.0, 0.0)


# --- leaks known by one measurement ----------------------------------------------------------------------


@given(st.floats(1e-9, 1e-4), st.floats(1e4, 2e6), st.floats(1e-3, 0.1), st.floats(0.1, 10.0))
def test_leaks_pass_their_measured_flow_and_scale_by_their_law(q: float, p: float, mu: float, ratio: float) -> None:
    assert orifice.laminar_leak(p, q, p, mu, mu) == pytest.approx(q, rel=1e-15, abs=0.0)
    assert orifice.laminar_leak(ratio * p, q, p, mu, mu) == pytest.approx(ratio * q, rel=1e-12, abs=0.0)
    assert orifice.laminar_leak(p, q, p, mu, ratio * mu) == pytest.approx(q / ratio, rel=1e-12, abs=0.0)
    assert orifice.orifice_leak(p, q, p, 800.0, 800.0) == pytest.approx(q, rel=1e-15, abs=0.0)
    assert orifice.orifice_leak(ratio * p, q, p, 800.0, 800.0) == pytest.approx(
        math.sqrt(ratio) * q, rel=1e-12, abs=0.0
    )
    assert orifice.orifice_leak(p, q, p, 800.0, ratio * 800.0) == pytest.approx(
        q / math.sqrt(ratio), rel=1e-12, abs=0.0
    )


@given(drops)
def test_leaks_run_backwards_under_a_reversed_pressure_drop(p: float) -> None:
    assert orifice.laminar_leak(-p, 1e-6, 4e5, 5e-3, 6e-3) == -orifice.laminar_leak(p, 1e-6, 4e5, 5e-3, 6e-3)
    assert orifice.orifice_leak(-p, 1e-6, 4e5, 800.0, 790.0) == -orifice.orifice_leak(p, 1e-6, 4e5, 800.0, 790.0)


# --- the pressure that a fed circuit holds ---------------------------------------------------------------

# Two lands of 14.5 mm, 5 mm long, from a circuit to the sump; a feed of 0.5 mm from 414 kPa; ν 6.2 mm²/s, 797 kg/m³.
# Radial clearance [µm], pressure held [kPa], leakage [dm³/min], the same pressure in the turbulent limit [kPa]:
WORKED = [
    (13.0, 410.8596, 0.016643, 411.9205),
    (20.0, 389.1379, 0.057397, 389.3640),
    (35.0, 209.3679, 0.165505, 209.3786),
    (50.0, 90.3221, 0.208162, 90.3245),
]
SOURCE = 414e3
COEFFICIENT = orifice.turbulent_coefficient(0.5e-3, 0.62, 797.0)
TRANSITION = orifice.transition_pressure(0.5e-3, 0.62, 6.2e-6, 797.0)


def leakage(pressure: float, clearance: float) -> float:
    return 2 * gap.annular_flow(pressure, 14.5e-3, clearance, 6.2e-6, 797.0, 5e-3)


def held(clearance: float, coefficient: float, transition: float) -> float:
    def surplus(p: float) -> float:
        return orifice.orifice_flow(SOURCE - p, coefficient, transition) - leakage(p, clearance)

    return brentq(surplus, 0.0, SOURCE, xtol=1e-9, rtol=1e-15)


@pytest.mark.parametrize(("clearance_um", "kilopascals", "dm3_min", "turbulent"), WORKED)
def test_a_fed_circuit_holds_the_pressure_of_the_worked_table(
    clearance_um: float, kilopascals: float, dm3_min: float, turbulent: float
) -> None:
    clearance = clearance_um * 1e-6
    p = held(clearance, COEFFICIENT, TRANSITION)
    assert p / 1e3 == pytest.approx(kilopascals, abs=1e-4)
    assert leakage(p, clearance) * 60e3 == pytest.approx(dm3_min, abs=1e-6)
    conductance = leakage(1.0, clearance)
    closed = orifice.fed_pressure_turbulent(SOURCE, COEFFICIENT, conductance)
    assert closed / 1e3 == pytest.approx(turbulent, abs=1e-4)


@given(st.floats(1e3, 2e6), coefficients, st.floats(0.0, 1e-8))
def test_the_closed_form_balances_feed_and_leakage(source: float, k: float, g: float) -> None:
    p = orifice.fed_pressure_turbulent(source, k, g)
    assert 0.0 <= p <= source
    # Of k √(p_src − p) and g p the difference is small against either, but for the digits that p_src − p loses.
    assert g * p == pytest.approx(k * math.sqrt(source - p), rel=1e-6, abs=k * math.sqrt(source) * 1e-7)


@pytest.mark.parametrize("clearance_um", [13.0, 20.0, 35.0, 50.0])
def test_the_closed_form_is_the_limit_of_a_thin_fluid(clearance_um: float) -> None:
    clearance = clearance_um * 1e-6
    closed = orifice.fed_pressure_turbulent(SOURCE, COEFFICIENT, leakage(1.0, clearance))
    assert held(clearance, COEFFICIENT, 1e-3) == pytest.approx(closed, abs=1e-3)


# --- refusals --------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("compute", "arguments", "names"),
    [
        (orifice.turbulent_coefficient, (0.0, 0.62, 797.0), "orifice diameter must be positive, found 0 m"),
        (orifice.turbulent_coefficient, (5e-4, 0.0, 797.0), "discharge coefficient must be positive, found 0"),
        (orifice.turbulent_coefficient, (5e-4, 0.62, -1.0), "density must be positive"),
        (orifice.transition_pressure, (5e-4, 0.62, 0.0, 797.0), "kinematic viscosity must be positive"),
        (orifice.transition_pressure, (5e-4, 0.62, 6e-6, 797.0, 0.0), "critical Reynolds number must be positive"),
        (orifice.orifice_flow, (1e5, -1e-9, 3e3), "turbulent coefficient must be zero or positive"),
        (orifice.orifice_flow, (1e5, 1e-9, 0.0), "transition pressure must be positive"),
        (orifice.orifice_flow_and_slope, ([1e5, 1e5], [1e-9, 1e-9], [3e3, 0.0]), "transition pressure .* at index 1"),
        (orifice.laminar_leak, (1e5, -1e-6, 4e5, 5e-3, 5e-3), "measured leakage must be zero or positive"),
        (orifice.laminar_leak, (1e5, 1e-6, 4e5, 5e-3, 0.0), "dynamic viscosity must be positive"),
        (orifice.orifice_leak, (1e5, 1e-6, 0.0, 800.0, 800.0), "pressure drop of the measurement must be positive"),
        (orifice.orifice_leak, (1e5, 1e-6, 4e5, 800.0, 0.0), "density must be positive"),
        (orifice.fed_pressure_turbulent, (4e5, 0.0, 1e-11), "turbulent coefficient must be positive"),
    ],
)
def test_values_without_meaning_are_refused_by_name(compute, arguments: tuple, names: str) -> None:
    with pytest.raises(DomainError, match=names):
        compute(*arguments)


def test_a_log_of_pressures_is_computed_at_once() -> None:
    p = np.linspace(-4e5, 4e5, 1001)
    q = orifice.orifice_flow(p, COEFFICIENT, TRANSITION)
    assert np.all(np.diff(q) > 0.0)
    assert q[::-1].tolist() == (-q).tolist()
