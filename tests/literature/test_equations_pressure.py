"""Balance of a spool against a worked example and against the article's printed forms."""

from __future__ import annotations

import math

import pytest

from atleak.equations.pressure import (
    annulus_area,
    control_pressure,
    regulated_pressure,
    spring_deflection,
    spring_force,
    spring_rate,
)
from tests.unit.equations.referees import spool_balance

# Worked by hand in mm, kPa, N: lands of 12, 10 and 9 mm, a rod of 5 mm; wire 1.0, 10 coils, coil diameter 8.
A_1 = math.pi * 12**2 / 4
A_2W = math.pi * (10**2 - 5**2) / 4
A_3W = math.pi * (9**2 - 5**2) / 4


def test_worked_example_of_valve_17() -> None:
    rate = spring_rate(80_000e6, 0.001, 10, 0.008)
    assert rate / 1e3 == pytest.approx(1.953125, rel=1e-14, abs=0.0)
    force = spring_force(rate, spring_deflection(0.032, 0.022))
    assert force == pytest.approx(19.53125, rel=1e-13, abs=0.0)
    ring_2, ring_3 = annulus_area(0.010, 0.005), annulus_area(0.009, 0.005)
    assert ring_2 * 1e6 == pytest.approx(A_2W, rel=1e-14, abs=0.0)
    assert ring_3 * 1e6 == pytest.approx(A_3W, rel=1e-14, abs=0.0)
    p_s = control_pressure(800e3, force, annulus_area(0.012), ring_2, ring_3, ring_2, ring_3)
    assert p_s / 1e3 == pytest.approx(320.5437, abs=0.00005)
    assert p_s / 1e3 == pytest.approx((800 * (A_2W - A_3W) + 1000 * 19.53125) / (A_1 - A_2W + A_3W), rel=1e-13, abs=0.0)


def test_printed_form_does_not_solve_the_balance() -> None:
    # p_s = p_g A_2W / A_1W + F / A_1 as printed leaves newtons on the spool, with or without the factor 1000.
    areas = [a * 1e-6 for a in (A_1, A_2W, A_3W, A_2W, A_3W)]
    a_1w = A_1 - math.pi * 5**2 / 4
    for factor in (1.0, 1000.0):
        printed = 800 * A_2W / a_1w + factor * 19.53125 / A_1
        assert abs(spool_balance(printed * 1e3, 800e3, 19.53125, *areas)) > 10.0


def test_modulated_pressure_stops_at_500_kpa() -> None:
    main = [400e3, 1000e3, 1001e3, 2000e3]
    assert regulated_pressure(main, 0.5, 0.0, 500e3).tolist() == [200e3, 500e3, 500e3, 500e3]


def test_control_pressure_is_a_regulated_one() -> None:
    areas = [a * 1e-6 for a in (A_1, A_2W, A_3W, A_2W, A_3W)]
    ratio, offset = control_pressure(1.0, 0.0, *areas), control_pressure(0.0, 19.53125, *areas)
    for main in (0.0, 400e3, 800e3):
        line = regulated_pressure(main, ratio, offset)
        assert line == pytest.approx(control_pressure(main, 19.53125, *areas), rel=1e-12, abs=0.0)
        assert spool_balance(line, main, 19.53125, *areas) == pytest.approx(0.0, abs=1e-9)
