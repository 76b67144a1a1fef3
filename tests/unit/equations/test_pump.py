"""The pump: slip against efficiency, properties, units and domain."""

from __future__ import annotations

import math

import pint
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import brentq

from atleak.equations import DomainError, pump
from tests.unit.equations import referees

displacements = st.floats(5e-6, 5e-5)
slips = st.floats(0.0, 1e-6)
pressures = st.floats(1e5, 2e6)
viscosities = st.floats(2e-3, 0.1)
speeds = st.floats(5.0, 100.0)


@given(displacements, slips, pressures, viscosities, speeds)
def test_what_efficiency_takes_is_what_slips(q_p: float, c_s: float, p: float, mu: float, n: float) -> None:
    lost = q_p * n * (1 - referees.wilson_efficiency(c_s, p, mu, n))
    assert pump.slip_flow(q_p, c_s, p, mu) == pytest.approx(lost, rel=1e-12, abs=1e-14 * q_p * n)


@given(displacements, st.floats(1e-8, 1e-6), pressures, viscosities, st.floats(0.0, 3e-4))
def test_minimum_speed_is_where_delivery_meets_demand(
    q_p: float, c_s: float, p: float, mu: float, leakage: float
) -> None:
    def surplus(n: float) -> float:
        return q_p * n * referees.wilson_efficiency(c_s, p, mu, n) - leakage

    slowest = pump.minimum_speed(leakage, pump.slip_flow(q_p, c_s, p, mu), q_p)
    root = brentq(surplus, slowest / 10, slowest * 10, rtol=1e-14)
    assert slowest == pytest.approx(root, rel=1e-9, abs=0.0)


def test_efficiency_is_not_clipped() -> None:
    assert referees.wilson_efficiency(1e-6, 2e6, 0.004, 5.0) < 0.0
    with pytest.raises(DomainError, match="volumetric efficiency"):
        pump.capacity(1.7e-5, 5.0, referees.wilson_efficiency(1e-6, 2e6, 0.004, 5.0))


@given(st.floats(1e-8, 1e-6), pressures, viscosities, speeds, st.floats(1.01, 3.0))
def test_efficiency_rises_with_speed_and_viscosity_and_falls_with_pressure(
    c_s: float, p: float, mu: float, n: float, factor: float
) -> None:
    efficiency = referees.wilson_efficiency(c_s, p, mu, n)
    assert referees.wilson_efficiency(c_s, p, mu, n * factor) > efficiency
    assert referees.wilson_efficiency(c_s, p, mu * factor, n) > efficiency
    assert referees.wilson_efficiency(c_s, p * factor, mu, n) < efficiency
    assert efficiency < 1.0


@given(displacements, speeds, st.floats(1e-3, 1.0))
def test_capacity_in_the_units_of_the_trade(q_p: float, n: float, efficiency: float) -> None:
    printed = (q_p * 1e9) * 1e-6 * (n * 60) * efficiency
    assert pump.capacity(q_p, n, efficiency) * 60e3 == pytest.approx(printed, rel=1e-12, abs=0.0)


def test_pint_computes_the_same_pump() -> None:
    u = pint.UnitRegistry()
    q_p = math.pi * 4.5 * u.mm * 12 * 12 * u.mm * 8.4 * u.mm
    assert pump.displacement(0.0045, 12, 0.012, 0.0084) == pytest.approx(q_p.to(u.m**3).magnitude, rel=1e-12, abs=0.0)
    flow = (q_p * 2500 / u.min * 0.95).to(u.L / u.min)
    assert flow.magnitude == pytest.approx(pump.capacity(17100.317e-9, 2500 / 60, 0.95) * 60e3, rel=1e-6, abs=0.0)


def test_a_pump_at_rest_delivers_nothing() -> None:
    assert pump.capacity(1.7e-5, 0.0, 0.95) == 0.0


@pytest.mark.parametrize(
    ("function", "arguments", "words"),
    [
        (pump.displacement, (0.0, 12, 0.012, 0.0084), "tooth module"),
        (pump.displacement, (0.0045, 0, 0.012, 0.0084), "number of teeth"),
        (pump.displacement, (0.0045, 12, -0.012, 0.0084), "gear width"),
        (pump.displacement, (0.0045, 12, 0.012, 0.0), "tooth height"),
        (pump.capacity, (0.0, 40.0, 0.95), "pump displacement"),
        (pump.capacity, (1.7e-5, -1.0, 0.95), "pump speed"),
        (pump.capacity, (1.7e-5, 40.0, 1.01), "volumetric efficiency must be between 0 and 1, found 1.01"),
        (pump.capacity, (1.7e-5, 40.0, -0.1), "volumetric efficiency"),
        (pump.slip_flow, (0.0, 1e-8, 8e5, 0.01), "pump displacement"),
        (pump.slip_flow, (1.7e-5, -1e-8, 8e5, 0.01), "slip coefficient"),
        (pump.slip_flow, (1.7e-5, 1e-8, 8e5, -0.01), "dynamic viscosity"),
        (pump.minimum_speed, (1e-4, 0.0, 0.0), "pump displacement"),
    ],
)
def test_out_of_domain_is_refused_by_name(function, arguments: tuple, words: str) -> None:
    with pytest.raises(DomainError, match=words):
        function(*arguments)
