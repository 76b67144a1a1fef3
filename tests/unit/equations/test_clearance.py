"""Clearances: round trips, properties, units and domain."""

from __future__ import annotations

import numpy as np
import pint
import pytest
from hypothesis import given
from hypothesis import strategies as st

from atleak.equations import DomainError, clearance
from tests.unit.equations import referees

spools = st.floats(2e-3, 50e-3)
clearances = st.floats(1e-6, 200e-6)
expansions = st.floats(0.0, 30e-6)
rises = st.floats(-60.0, 100.0)


@given(spools, clearances)
def test_clearance_of_the_diameters_it_makes(spool: float, c: float) -> None:
    assert clearance.radial_clearance(spool + 2 * c, spool) == pytest.approx(c, rel=1e-9, abs=0.0)


@given(spools, expansions, expansions, st.floats(-25.0, 40.0))
def test_a_diameter_is_corrected_as_gauge_and_part_shrink_back(
    diameter: float, part: float, gauge: float, rise: float
) -> None:
    exact = diameter * (1.0 + gauge * rise) / (1.0 + part * rise)  # the gauge's step has grown, and so has the part
    corrected = clearance.diameter_at_reference(diameter, part, gauge, rise)
    assert corrected == pytest.approx(exact, abs=1.01 * diameter * (part + gauge) * part * rise**2 + 1e-15)
    assert clearance.diameter_at_reference(diameter, part, part, rise) == diameter


def test_equal_diameters_leave_no_clearance() -> None:
    assert clearance.radial_clearance(0.01, 0.01) == 0.0


@given(clearances, st.floats(-1.0, 10.0))
def test_wear_and_worn_clearance_undo_each_other(c_m: float, z: float) -> None:
    assert clearance.wear(clearance.worn_clearance(c_m, z * c_m), c_m) == pytest.approx(z, abs=1e-14)


def test_a_pair_tighter_than_new_has_negative_wear() -> None:
    assert clearance.wear(27e-6, 30e-6) == pytest.approx(-0.1, rel=1e-9, abs=0.0)


@given(clearances, spools, expansions, expansions, rises)
def test_effective_clearance_is_that_of_the_grown_diameters(
    c: float, spool: float, beta_k: float, beta_s: float, rise: float
) -> None:
    sleeve = spool + 2 * c
    grown = (sleeve * (1 + beta_k * rise) - spool * (1 + beta_s * rise)) / 2
    if grown < 0.0:
        rate = clearance.thermal_rate(sleeve, spool, beta_k, beta_s)
        assert clearance.effective_clearance(c, rate, rise) == pytest.approx(0.0, abs=1e-18)
        return
    hot = referees.effective_clearance_two_temperatures(c, sleeve, spool, beta_k, beta_s, rise, rise)
    assert hot == pytest.approx(grown, abs=1e-15)
    rate = clearance.thermal_rate(sleeve, spool, beta_k, beta_s)
    assert hot == pytest.approx(clearance.effective_clearance(c, rate, rise), abs=1e-18)


def test_body_and_spool_may_warm_up_differently() -> None:
    hot = referees.effective_clearance_two_temperatures(30e-6, 0.01006, 0.010, 21.5e-6, 12e-6, 40.0, 60.0)
    u = pint.UnitRegistry()
    body = 21.5e-6 / u.delta_degC * 10.06 * u.mm * 40 * u.delta_degC
    spool = 12e-6 / u.delta_degC * 10.0 * u.mm * 60 * u.delta_degC
    assert hot == pytest.approx((30 * u.um + (body - spool) / 2).to(u.m).magnitude, rel=1e-12, abs=0.0)


@pytest.mark.parametrize("exponent", [1.0, 2.0, 3.0, 2.5, 7.0])
def test_wear_to_one_side_has_the_moments_of_its_profile(exponent: float) -> None:
    angles = np.linspace(0.0, 2.0 * np.pi, 40_000, endpoint=False)
    profile = np.maximum(np.cos(angles), 0.0) ** exponent
    profile *= 10e-6 / profile.mean()
    moments = [np.mean((profile - 10e-6) ** power) for power in (2, 3)]
    assert clearance.one_sided_moments(10e-6, exponent) == pytest.approx(moments, rel=1e-6, abs=0.0)
    opposite = 0.5 * (profile + np.roll(profile, 20_000)) / 10e-6
    assert clearance.seen_of_one_sided(angles, exponent) == pytest.approx(opposite, rel=1e-6, abs=1e-12)


def test_wear_to_one_side_has_the_moments_of_known_integrals() -> None:
    assert clearance.one_sided_moments(1.0) == pytest.approx((np.pi**2 / 4 - 1, 2 - np.pi**2 / 12), rel=1e-14, abs=0.0)
    assert clearance.one_sided_moments(1.0, 2.0) == pytest.approx((2.0, 3.0), rel=1e-14, abs=0.0)
    # Wallis: the means of max(cos θ, 0) to the powers of 3, 6 and 9 are 2/(3π), 5/32 and 128/(315π)
    square, cube = 5.0 / 32.0 / (2.0 / (3.0 * np.pi)) ** 2, 128.0 / 315.0 / np.pi / (2.0 / (3.0 * np.pi)) ** 3
    sharp = square - 1.0, cube - 3.0 * square + 2.0
    assert clearance.one_sided_moments(1.0, 3.0) == pytest.approx(sharp, rel=1e-14, abs=0.0)


@pytest.mark.parametrize(
    ("function", "arguments", "words"),
    [
        (clearance.radial_clearance, (0.00999, 0.010), "sleeve diameter must be at least the spool's"),
        (clearance.radial_clearance, (0.01, 0.0), "spool diameter"),
        (clearance.radial_clearance, (-0.01, 0.01), "sleeve diameter"),
        (clearance.worn_clearance, (-1e-6, 5e-6), "mounting clearance"),
        (clearance.worn_clearance, (1e-6, -5e-6), "worn clearance"),
        (clearance.wear, (30e-6, 0.0), "mounting clearance"),
        (clearance.one_sided_moments, (-1e-6,), "mean wear"),
        (clearance.one_sided_moments, (1e-6, 0.0), "exponent"),
        (clearance.seen_of_one_sided, (0.0, -1.0), "exponent"),
        (clearance.thermal_rate, (0.009, 0.01, 2e-5, 1e-5), "sleeve diameter"),
    ],
)
def test_out_of_domain_is_refused_by_name(function, arguments: tuple, words: str) -> None:
    with pytest.raises(DomainError, match=words):
        function(*arguments)


def test_the_offending_pair_is_named() -> None:
    with pytest.raises(DomainError, match=r"found 0\.00999 m at index 2"):
        clearance.radial_clearance(np.array([0.01001, np.nan, 0.00999]), 0.010)
