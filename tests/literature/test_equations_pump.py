"""The study's pump against its own geometry and its printed capacity."""

from __future__ import annotations

import math

import pytest

from atleak.equations.pump import capacity, displacement, gear_pair_displacement, minimum_speed, slip_flow
from tests.unit.equations.referees import wilson_efficiency

STUDY_PUMP = (0.0045, 12, 0.012, 0.0084)


def test_displacement_of_the_study_pump() -> None:
    assert displacement(*STUDY_PUMP) * 1e9 == pytest.approx(17100.317, abs=0.0005)


def test_capacity_of_the_study_pump_at_2500_rpm() -> None:
    assert capacity(displacement(*STUDY_PUMP), 2500 / 60, 0.95) * 60e3 == pytest.approx(40.613, abs=0.0005)


def test_printed_capacity_needs_another_efficiency_or_speed() -> None:
    # The article prints 33.6 dm³/min at 2500 revolutions per minute.
    q_p = displacement(*STUDY_PUMP)
    assert capacity(q_p, 2500 / 60, 0.786) * 60e3 == pytest.approx(33.6, abs=0.05)
    assert capacity(q_p, 2068 / 60, 0.95) * 60e3 == pytest.approx(33.6, abs=0.05)


def test_wilson_slip_worked_by_hand() -> None:
    # C_s 1e-7, 1 MPa, 10 mPa·s: C_s Δp / μ = 10 rad/s lost of ω = 2π · 10 rad/s.
    assert wilson_efficiency(1e-7, 1e6, 0.01, 10.0) == pytest.approx(1 - 1 / (2 * math.pi), rel=1e-14, abs=0.0)
    assert slip_flow(2e-5, 1e-7, 1e6, 0.01) == pytest.approx(2e-5 * 10 / (2 * math.pi), rel=1e-14, abs=0.0)


def test_minimum_speed_of_the_study_pump() -> None:
    # W8 leaks 11.23 dm³/min: 657 revolutions per minute are needed for the leakage alone.
    assert minimum_speed(11.23 / 60e3, 0.0, displacement(*STUDY_PUMP)) * 60 == pytest.approx(656.7, abs=0.05)


def test_a_gear_pump_of_19_cm3_by_the_calliper() -> None:
    # UHE, Formula to calculate gear pump displacement: 50.39 mm over the tips, centres 42.06 mm apart, 16.14 mm wide;
    # π/2 b (D² − a²) gives 19.52 cm³, "the gear set in the photo is actually 19cc". It does not say how many teeth:
    # with 12 to 14, as such sets mostly have, what the mesh carries back takes off a little more than the difference.
    sizes = (0.05039, 0.04206, 0.01614)
    assert math.pi / 2 * sizes[2] * (sizes[0] ** 2 - sizes[1] ** 2) * 1e6 == pytest.approx(19.52, abs=0.005)
    for teeth, low in ((12, 0.979), (13, 0.986), (14, 0.992)):
        assert gear_pair_displacement(*sizes, teeth) * 1e6 / 19.0 == pytest.approx(low, abs=0.002)
