"""Gap flow against independent referees: integration, root finding, other units; and its properties."""

from __future__ import annotations

import math

import numpy as np
import pint
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad, solve_bvp
from scipy.optimize import brentq

from atleak.equations import DomainError, gap
from tests.unit.equations import referees

GAP = {
    "pressure_drop": 800e3,
    "diameter": 0.010,
    "clearance": 30e-6,
    "kinematic_viscosity": 10.93e-6,
    "density": 783.0,
    "contact_length": 0.008,
}

pressure_drops = st.floats(1e3, 2e6)
diameters = st.floats(2e-3, 50e-3)
clearances = st.floats(1e-6, 200e-6)
viscosities = st.floats(2e-6, 0.05)
densities = st.floats(700.0, 950.0)
lengths = st.floats(0.5e-3, 50e-3)
gaps = st.tuples(pressure_drops, diameters, clearances, viscosities, densities, lengths)


# --- units -----------------------------------------------------------------------------------------------


@given(gaps, st.floats(0.0, 1.0))
def test_annular_flow_equals_the_millimetre_form(values: tuple[float, ...], relative: float) -> None:
    p, d, c, nu, rho, length = values
    p_kpa, d_mm, c_mm, nu_mm2, rho_g, l_mm = p / 1e3, d * 1e3, c * 1e3, nu * 1e6, rho / 1e3, length * 1e3
    by_hand = 1e6 * p_kpa * math.pi * d_mm * c_mm**3 / (12 * nu_mm2 * rho_g * l_mm) * (1 + 1.5 * relative**2)
    assert gap.annular_flow(p, d, c, nu, rho, length, relative * c) * 1e9 == pytest.approx(by_hand, rel=1e-12, abs=0.0)


def test_the_factor_of_the_millimetre_form_is_a_million() -> None:
    u = pint.UnitRegistry()
    one = u.kPa * u.mm * u.mm**3 / ((u.mm**2 / u.s) * (u.g / u.cm**3) * u.mm)
    assert (1 * one).to(u.mm**3 / u.s).magnitude == pytest.approx(1e6, rel=1e-12, abs=0.0)
    literal = u.kPa * u.mm * u.mm**3 / (u.Pa * u.s * u.mm)
    assert (1 * literal).to(u.mm**3 / u.s).magnitude == pytest.approx(1e3, rel=1e-12, abs=0.0)


def test_pint_computes_the_same_flow() -> None:
    u = pint.UnitRegistry()
    q = (
        (800 * u.kPa * math.pi * 10 * u.mm * (30 * u.um) ** 3)
        / (12 * 10.93 * u.mm**2 / u.s * 0.783 * u.g / u.cm**3 * 8 * u.mm)
    ).to(u.m**3 / u.s)
    assert gap.annular_flow(**GAP) == pytest.approx(q.magnitude, rel=1e-12, abs=0.0)


# --- the gap law -----------------------------------------------------------------------------------------


@given(gaps, st.floats(1.01, 5.0))
def test_annular_flow_scales_as_it_should(values: tuple[float, ...], factor: float) -> None:
    p, d, c, nu, rho, length = values
    q = gap.annular_flow(*values)
    assert gap.annular_flow(p, d, c * factor, nu, rho, length) == pytest.approx(q * factor**3, rel=1e-12, abs=0.0)
    assert gap.annular_flow(p * factor, d, c, nu, rho, length) == pytest.approx(q * factor, rel=1e-12, abs=0.0)
    assert gap.annular_flow(p, d * factor, c, nu, rho, length) == pytest.approx(q * factor, rel=1e-12, abs=0.0)
    assert gap.annular_flow(p, d, c, nu * factor, rho, length) == pytest.approx(q / factor, rel=1e-12, abs=0.0)
    assert gap.annular_flow(p, d, c, nu, rho * factor, length) == pytest.approx(q / factor, rel=1e-12, abs=0.0)
    assert gap.annular_flow(p, d, c, nu, rho, length * factor) == pytest.approx(q / factor, rel=1e-12, abs=0.0)
    assert gap.annular_flow(-p, d, c, nu, rho, length) == -q


def test_no_pressure_drop_or_no_clearance_no_flow() -> None:
    assert gap.annular_flow(**{**GAP, "pressure_drop": 0.0}) == 0.0
    assert gap.annular_flow(**{**GAP, "clearance": 0.0}) == 0.0
    assert gap.entry_loss_flow(**{**GAP, "clearance": 0.0}) == 0.0


@given(gaps, st.floats(0.0, 1.0))
def test_compressible_form_with_equal_densities_is_the_incompressible_one(
    values: tuple[float, ...], ratio: float
) -> None:
    p, d, c, nu, rho, length = values
    q = gap.annular_flow(*values)
    assert referees.annular_flow_compressible(p, d, c, nu * rho, length, rho, rho) == pytest.approx(
        q, rel=1e-12, abs=0.0
    )
    denser = rho * (1 + ratio)
    assert referees.annular_flow_compressible(p, d, c, nu * rho, length, denser, rho) == pytest.approx(
        q * (1 + ratio), rel=1e-12, abs=0.0
    )


@pytest.mark.parametrize("relative", [0.0, 0.1, 0.5, 0.9, 1.0])
def test_eccentricity_factor_is_the_mean_cube_around_the_circumference(relative: float) -> None:
    total, _ = quad(lambda angle: (1 + relative * math.cos(angle)) ** 3, 0, 2 * math.pi, epsrel=1e-12)
    assert gap.eccentricity_factor(relative * 30e-6, 30e-6) == pytest.approx(total / (2 * math.pi), rel=1e-12, abs=0.0)
    q = gap.annular_flow(**GAP)
    assert gap.annular_flow(**GAP, eccentricity=relative * 30e-6) == pytest.approx(
        q * total / (2 * math.pi), rel=1e-12, abs=0.0
    )


@given(clearances, st.floats(0.0, 1.0), st.floats(0.0, 1.0))
def test_eccentricity_factor_rises_from_1_to_2_5(c: float, one: float, other: float) -> None:
    low, high = sorted((one, other))
    assert 1.0 <= gap.eccentricity_factor(low * c, c) <= gap.eccentricity_factor(high * c, c) <= 2.5


def test_eccentricity_factor_of_a_closed_gap_is_1() -> None:
    assert gap.eccentricity_factor([0.0, 15e-6], [0.0, 30e-6]).tolist() == [1.0, 1.375]


# --- the exact annulus -----------------------------------------------------------------------------------


@pytest.mark.parametrize("ratio", [1e-4, 1e-3, 6e-3, 0.05, 0.5, 1.0, 1.7, 1.72, 3.0, 50.0])
def test_exact_annulus_is_the_integral_of_its_velocity_profile(ratio: float) -> None:
    # The axial momentum balance of the annulus, (r u')' / r = -Δp/(μ l), solved as a boundary-value problem
    # across the gap (y from 0 to 1, source 1), knows nothing of the closed form.
    r_i, pressure_drop, viscosity, length = 0.005, 800e3, 0.0085, 0.008
    c = ratio * r_i

    def slope(y: np.ndarray, state: np.ndarray) -> np.ndarray:
        return np.vstack([state[1], -1.0 - ratio / (1 + ratio * y) * state[1]])

    def no_slip(inner: np.ndarray, outer: np.ndarray) -> np.ndarray:
        return np.array([inner[0], outer[0]])

    mesh = np.linspace(0.0, 1.0, 41)
    guess = np.vstack([0.5 * mesh * (1 - mesh), 0.5 - mesh])
    profile = solve_bvp(slope, no_slip, mesh, guess, tol=1e-8, max_nodes=20_000)
    assert profile.success
    integral, _ = quad(lambda y: (1 + ratio * y) * profile.sol(y)[0], 0.0, 1.0, epsrel=1e-10, limit=200)
    q = 2 * math.pi * r_i * c * (pressure_drop / (viscosity * length) * c * c) * integral
    exact = referees.exact_annulus_flow(pressure_drop, 2 * r_i, 2 * (r_i + c), viscosity, length)
    assert exact == pytest.approx(q, rel=1e-8, abs=0.0)


@pytest.mark.parametrize("ratio", [1e-3, 6e-3, 0.02, 0.1])
def test_thin_gap_law_differs_from_the_exact_one_as_documented(ratio: float) -> None:
    d = 0.010
    c = ratio * d / 2
    exact = referees.exact_annulus_flow(800e3, d, d + 2 * c, 0.0085, 0.008)
    on_mean = referees.annular_flow_compressible(800e3, d + c, c, 0.0085, 0.008, 1.0, 1.0)
    on_shaft = referees.annular_flow_compressible(800e3, d, c, 0.0085, 0.008, 1.0, 1.0)
    assert abs(on_mean / exact - 1) == pytest.approx(ratio**2 / 60, rel=0.12, abs=0.0)
    assert 1 - on_shaft / exact == pytest.approx(c / d, rel=0.12, abs=0.0)


# --- entry loss ------------------------------------------------------------------------------------------


@given(gaps, st.floats(0.0, 3.0))
def test_entry_loss_flow_solves_its_quadratic(values: tuple[float, ...], k: float) -> None:
    p, d, c, nu, rho, length = values
    laminar = gap.annular_flow(*values) / (math.pi * d * c)

    def unspent(u: float) -> float:
        return p - 12 * nu * rho * length * u / c**2 - k * rho * u**2 / 2

    velocity = brentq(unspent, 0.0, laminar * (1 + 1e-9), xtol=1e-300, rtol=1e-14)
    assert gap.entry_loss_flow(*values, k) == pytest.approx(math.pi * d * c * velocity, rel=1e-11, abs=0.0)


@given(gaps, st.floats(0.0, 3.0))
def test_entry_loss_flow_is_odd_and_never_above_the_laminar_one(values: tuple[float, ...], k: float) -> None:
    q = gap.entry_loss_flow(*values, k)
    assert 0.0 < q <= gap.annular_flow(*values) * (1 + 1e-14)
    assert gap.entry_loss_flow(-values[0], *values[1:], k) == -q
    assert gap.entry_loss_flow(*values, 0.0) == pytest.approx(gap.annular_flow(*values), rel=1e-13, abs=0.0)


@given(gaps, st.floats(1.001, 3.0))
def test_entry_loss_flow_rises_with_pressure_less_than_linearly(values: tuple[float, ...], factor: float) -> None:
    q, more = gap.entry_loss_flow(*values), gap.entry_loss_flow(values[0] * factor, *values[1:])
    assert q < more <= q * factor * (1 + 1e-14)


@given(pressure_drops, st.floats(1e-13, 1e-10), st.floats(0.0, 1e-4))
def test_the_slope_is_the_derivative_of_the_same_flow(p: float, g: float, bend: float) -> None:
    flow, slope = gap.restricted_flow_and_slope(p, g, bend)
    assert flow == gap.restricted_flow(p, g, bend)
    step = 1e-4 * p
    rise = gap.restricted_flow(p + step, g, bend) - gap.restricted_flow(p - step, g, bend)
    assert slope == pytest.approx(rise / (2.0 * step), rel=1e-6, abs=0.0)


def test_entry_loss_alone_is_the_orifice_law() -> None:
    # Nearly no friction: u = sqrt(2 Δp / (K ρ)).
    q = gap.entry_loss_flow(800e3, 0.01, 1e-3, 1e-12, 800.0, 1e-3, 1.5)
    assert q == pytest.approx(math.pi * 0.01 * 1e-3 * math.sqrt(2 * 800e3 / (1.5 * 800.0)), rel=1e-6, abs=0.0)


@given(gaps, st.floats(0.0, 1.0))
def test_entry_loss_flow_of_an_eccentric_gap_lies_between_its_limits(values: tuple[float, ...], e: float) -> None:
    p, d, c, _, rho, _ = values
    factor = gap.eccentricity_factor(e * c, c)
    q, concentric = gap.entry_loss_flow(*values, eccentricity_factor=factor), gap.entry_loss_flow(*values)
    assert concentric * (1 - 1e-14) <= q <= factor * concentric * (1 + 1e-14)
    assert q <= factor * gap.annular_flow(*values) * (1 + 1e-14)
    assert q < math.pi * d * c * math.sqrt(p / (0.75 * rho)) * (1 + 1e-14)  # nothing spent on friction


ANGLES = (np.arange(720) + 0.5) * math.pi / 720
HOT = (6e-6, 790.0)  # viscosity, density
# pressure drop, diameter, mean clearance, length, e/c; what friction alone would leave of the flow is 0.14 to 0.99
ECCENTRIC = [
    (400e3, 0.01, 60e-6, 2e-3, 0.9),
    (1500e3, 0.01, 110e-6, 10e-3, 1.0),
    (1500e3, 0.01, 110e-6, 10e-3, 0.5),
    (400e3, 0.02, 30e-6, 0.5e-3, 0.9),
    (400e3, 0.01, 110e-6, 0.5e-3, 1.0),
    (400e3, 0.01, 20e-6, 5e-3, 0.7),
]


@pytest.mark.parametrize(("p", "d", "c", "length", "e"), ECCENTRIC)
def test_eccentric_gap_with_entry_loss_leaks_at_most_12_percent_less_than_by_its_mean_velocity(
    p: float, d: float, c: float, length: float, e: float
) -> None:
    def thickness(angle: np.ndarray) -> np.ndarray:
        return c * (1.0 + e * np.cos(angle))

    factor = gap.eccentricity_factor(e * c, c)
    q = gap.entry_loss_flow(p, d, c, *HOT, length, eccentricity_factor=factor)
    strips = referees.flow_of_strips(p, d, thickness(ANGLES), *HOT, length)
    around = referees.flow_around(p, d, thickness, *HOT, length)
    assert 0.88 * q < strips < around < q
    assert around < 1.06 * strips
    lossless = referees.flow_around(p, d, thickness, *HOT, length, 0.0)
    assert lossless == pytest.approx(gap.annular_flow(p, d, c, *HOT, length, e * c), rel=2e-4, abs=0.0)


# depth of wear to one side [µm] and contact length [mm], and how much more the even gap of the same cube leaks [%]
ONE_SIDED = [(30, 5, 1), (60, 10, 2), (60, 5, 8), (60, 2, 28), (110, 5, 32)]


@pytest.mark.parametrize(("depth", "length", "more"), ONE_SIDED)
def test_entry_loss_of_a_bore_worn_to_one_side_is_more_than_that_of_the_even_gap_of_the_same_cube(
    depth: float, length: float, more: float
) -> None:
    def thickness(angle: np.ndarray) -> np.ndarray:
        return 15e-6 + depth * 1e-6 * np.maximum(np.cos(angle), 0.0)

    even = float(np.cbrt(np.mean(thickness(ANGLES) ** 3)))
    q = gap.entry_loss_flow(900e3, 0.012, even, *HOT, length * 1e-3)
    around = referees.flow_around(900e3, 0.012, thickness, *HOT, length * 1e-3)
    assert 100.0 * (q / around - 1.0) == pytest.approx(more, abs=1.0)


# --- a gap that is not the same all around ---------------------------------------------------------------


@given(st.lists(st.floats(1e-6, 200e-6), min_size=1, max_size=8), st.floats(0.0, 50e-6))
def test_flow_equal_clearance_is_the_mean_cube_while_the_gap_is_open(several: list[float], opened: float) -> None:
    c = np.array(several)
    mean = float(c.mean())
    even = gap.flow_equal_clearance(mean + opened, float(((c - mean) ** 2).mean()), float(((c - mean) ** 3).mean()))
    assert even**3 == pytest.approx(float(np.mean((c + opened) ** 3)), rel=1e-9, abs=0.0)


@given(st.floats(1e-9, 500e-6), st.floats(0.0, 100e-6), st.floats(0.0, 100e-6), st.floats(-3.0, 3.0))
def test_flow_equal_clearance_rises_and_is_never_below_the_mean(c: float, more: float, u: float, skew: float) -> None:
    moments = u**2, skew * u**3
    even = gap.flow_equal_clearance(c, *moments)
    assert even >= c * (1 - 1e-15)
    assert gap.flow_equal_clearance(c + more, *moments) >= even * (1 - 1e-15)


# --- Reynolds number -------------------------------------------------------------------------------------


@given(gaps)
def test_reynolds_number_from_mean_velocity_and_hydraulic_diameter(values: tuple[float, ...]) -> None:
    _, d, c, nu, _, _ = values
    q = gap.annular_flow(*values)
    area, perimeter = math.pi * ((d + 2 * c) ** 2 - d**2) / 4, math.pi * (2 * d + 2 * c)
    reynolds = q / area * (4 * area / perimeter) / nu
    # The function takes the perimeter on one diameter; on the mean diameter both agree.
    assert gap.reynolds_number(q, d + c, nu) == pytest.approx(reynolds, rel=1e-9, abs=0.0)
    assert gap.reynolds_number(-q, d, nu) == gap.reynolds_number(q, d, nu)


# --- obliteration ----------------------------------------------------------------------------------------


def test_obliteration_of_clearances_that_come_from_diameters() -> None:
    # (12.040 - 12.000) / 2 is a hair above 20 µm in floats, and 20 µm is not free.
    assert gap.obliteration((12.040 - 12.000) / 2 * 1e-3) == "partial"
    assert gap.obliteration((12.010 - 12.000) / 2 * 1e-3) == "partial"
    assert gap.obliteration(0.0) == "closed"


def test_obliteration_keeps_shape_and_kind() -> None:
    states = gap.obliteration(np.array([[1e-6, 10e-6], [25e-6, math.nan]]))
    assert states.tolist() == [["closed", "partial"], ["free", ""]]
    assert type(gap.obliteration(np.float64(1e-6))) is str
    assert gap.obliteration(math.nan) == ""
    with pytest.raises(DomainError):
        gap.obliteration(-1e-6)


# --- domain ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("clearance", -1e-9, "radial clearance must be zero or positive, found -1e-09 m"),
        ("diameter", 0.0, "diameter must be positive, found 0 m"),
        ("diameter", -0.01, "diameter"),
        ("kinematic_viscosity", 0.0, "kinematic viscosity"),
        ("kinematic_viscosity", -1e-6, "kinematic viscosity"),
        ("density", 0.0, "density"),
        ("contact_length", 0.0, "contact length"),
        ("contact_length", -1e-3, "contact length"),
    ],
)
@pytest.mark.parametrize("function", [gap.annular_flow, gap.entry_loss_flow])
def test_out_of_domain_is_refused_by_name(function, name: str, value: float, words: str) -> None:
    with pytest.raises(DomainError, match=words):
        function(**{**GAP, name: value})
    with pytest.raises(DomainError, match=words):
        function(**{**GAP, name: np.array([math.nan, GAP[name], value])})


@pytest.mark.parametrize("eccentricity", [-1e-9, 31e-6])
def test_eccentricity_outside_the_gap_is_refused(eccentricity: float) -> None:
    with pytest.raises(DomainError, match="eccentricity"):
        gap.annular_flow(**GAP, eccentricity=eccentricity)
    with pytest.raises(DomainError, match="eccentricity"):
        gap.eccentricity_factor(eccentricity, 30e-6)


def test_first_offending_value_and_its_place_are_named() -> None:
    with pytest.raises(DomainError, match=r"found -2e-06 m at index 1, 0$"):
        gap.annular_flow(**{**GAP, "clearance": np.array([[30e-6, math.nan], [-2e-6, -3e-6]])})


@pytest.mark.parametrize(
    ("function", "arguments"),
    [
        (gap.entry_loss_flow, (8e5, 0.010, 3e-5, 1e-5, 783.0, 0.008, -0.1)),
        (gap.entry_loss_flow, (8e5, 0.010, 3e-5, 1e-5, 783.0, 0.008, 1.5, 0.0)),
        (gap.flow_equal_clearance, (-1e-6, 1e-12, 0.0)),
        (gap.flow_equal_clearance, (3e-5, -1e-12, 0.0)),
        (gap.reynolds_number, (1e-6, 0.0, 1e-5)),
        (gap.reynolds_number, (1e-6, 0.01, 0.0)),
    ],
)
def test_other_domains(function, arguments: tuple) -> None:
    with pytest.raises(DomainError):
        function(*arguments)
