"""Balance of a spool: the solved form against the balance, units, properties and domain."""

from __future__ import annotations

import math

import pint
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.optimize import brentq

from atleak.equations import DomainError, pressure
from tests.unit.equations import referees

AREAS = (113.097e-6, 58.905e-6, 43.982e-6, 58.905e-6, 43.982e-6)
areas = st.tuples(*[st.floats(1e-6, 1e-3)] * 5)


@given(st.floats(0.0, 2e6), st.floats(0.0, 100.0), areas)
def test_solved_pressure_balances_the_spool(p_g: float, force: float, faces: tuple[float, ...]) -> None:
    a_1, a_2w, a_3w, a_g1, a_g2 = faces
    assume(a_1 - a_2w + a_3w > 1e-6)
    p_s = pressure.control_pressure(p_g, force, *faces)
    largest = max(force, p_g * a_g1, p_g * a_g2, abs(p_s) * a_1, abs(p_s) * a_2w, abs(p_s) * a_3w, 1e-9)
    assert abs(referees.spool_balance(p_s, p_g, force, *faces)) <= 1e-12 * largest


@given(st.floats(0.0, 2e6), st.floats(0.0, 2e6), st.floats(0.0, 100.0), areas)
def test_balance_is_the_sum_of_its_forces(p_s: float, p_g: float, f_sp: float, faces: tuple[float, ...]) -> None:
    a_1, a_2w, a_3w, a_g1, a_g2 = faces
    forces = [p_s * a_1, -p_g * a_g1, p_g * a_g2, -p_s * a_2w, p_s * a_3w, -f_sp]
    residual = referees.spool_balance(p_s, p_g, f_sp, *faces)
    assert residual == pytest.approx(math.fsum(forces), abs=1e-11 * (1 + max(map(abs, forces))))


def test_root_of_the_balance_is_the_solved_pressure() -> None:
    root = brentq(lambda p: referees.spool_balance(p, 800e3, 19.53125, *AREAS), 0.0, 2e6, xtol=1e-9, rtol=1e-14)
    assert pressure.control_pressure(800e3, 19.53125, *AREAS) == pytest.approx(root, rel=1e-12, abs=0.0)


@given(st.floats(0.0, 2e6), st.floats(0.0, 2e6))
def test_control_pressure_is_affine_in_main_pressure(one: float, other: float) -> None:
    def p_s(p_g: float) -> float:
        return pressure.control_pressure(p_g, 19.53125, *AREAS)

    assert p_s((one + other) / 2) == pytest.approx((p_s(one) + p_s(other)) / 2, rel=1e-12, abs=0.0)
    assert p_s(0.0) == pytest.approx(19.53125 / (AREAS[0] - AREAS[1] + AREAS[2]), rel=1e-12, abs=0.0)


@given(st.floats(1e-3, 50e-3), st.floats(0.0, 1.0))
def test_ring_is_the_integral_of_its_circles(d: float, relative: float) -> None:
    rod = relative * d
    area, _ = quad(lambda r: 2 * math.pi * r, rod / 2, d / 2, epsrel=1e-13)
    assert pressure.annulus_area(d, rod) == pytest.approx(area, rel=1e-10, abs=1e-18)


def test_disc_without_a_rod_and_rod_without_a_ring() -> None:
    assert pressure.annulus_area(0.012) == pytest.approx(math.pi * 0.012**2 / 4, rel=1e-14, abs=0.0)
    assert pressure.annulus_area(0.012, 0.012) == 0.0


def test_spring_in_the_units_of_the_trade() -> None:
    u = pint.UnitRegistry()
    rate = (0.8e5 * u.MPa * (1.2 * u.mm) ** 4 / (8 * 7.5 * (9.3 * u.mm) ** 3)).to(u.N / u.m)
    assert pressure.spring_rate(80e9, 1.2e-3, 7.5, 9.3e-3) == pytest.approx(rate.magnitude, rel=1e-12, abs=0.0)
    force = (rate * (31.5 * u.mm - 24.0 * u.mm)).to(u.N)
    deflection = pressure.spring_deflection(31.5e-3, 24.0e-3)
    assert pressure.spring_force(rate.magnitude, deflection) == pytest.approx(force.magnitude, rel=1e-12, abs=0.0)


def test_an_unloaded_spring_is_not_deflected() -> None:
    assert pressure.spring_deflection(0.03, 0.03) == 0.0


@given(st.floats(-1e5, 3e6), st.floats(0.0, 2.0), st.floats(1e5, 1e6))
def test_modulated_pressure_is_the_smaller_of_two(p_g: float, ratio: float, limit: float) -> None:
    assert pressure.regulated_pressure(p_g, ratio, 0.0, limit) == min(ratio * p_g, limit)


def test_a_regulated_pressure_without_limit_is_a_straight_line() -> None:
    assert pressure.regulated_pressure([0.0, 800e3], 0.25, 50e3).tolist() == [50e3, 250e3]


@pytest.mark.parametrize(
    ("function", "arguments", "words"),
    [
        (pressure.annulus_area, (0.0,), "diameter"),
        (pressure.annulus_area, (0.01, -0.001), "rod diameter"),
        (pressure.annulus_area, (0.01, 0.011), "rod diameter must be at most the diameter"),
        (pressure.spring_force, (0.0, 0.01), "spring rate"),
        (pressure.spring_force, (2000.0, -0.01), "spring deflection"),
        (pressure.spring_rate, (0.0, 1e-3, 10, 8e-3), "shear modulus"),
        (pressure.spring_rate, (80e9, 0.0, 10, 8e-3), "wire diameter"),
        (pressure.spring_rate, (80e9, 1e-3, 0, 8e-3), "number of active coils"),
        (pressure.spring_rate, (80e9, 1e-3, 10, 1e-3), "mean coil diameter"),
        (pressure.spring_deflection, (0.02, 0.021), "at most the free length"),
        (pressure.spring_deflection, (0.0, 0.021), "free length"),
        (pressure.spring_deflection, (0.02, 0.0), "spring length"),
        (pressure.control_pressure, (8e5, 20.0, 1e-4, 1.5e-4, 5e-5, 6e-5, 4e-5), "area left"),
        (pressure.control_pressure, (8e5, 20.0, 1e-4, 1.6e-4, 5e-5, 6e-5, 4e-5), "area left"),
        (pressure.control_pressure, (8e5, 20.0, 0.0, 0.0, 0.0, 6e-5, 4e-5), "area left"),
        (pressure.control_pressure, (8e5, 20.0, 1e-4, 1e-5, 5e-5, -6e-5, 4e-5), "area A_g1"),
        (pressure.regulated_pressure, (8e5, 0.5, 0.0, 0.0), "limit of the pressure"),
    ],
)
def test_out_of_domain_is_refused_by_name(function, arguments: tuple, words: str) -> None:
    with pytest.raises(DomainError, match=words):
        function(*arguments)
