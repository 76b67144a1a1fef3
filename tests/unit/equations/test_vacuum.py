"""Air past lands and through orifices: the balance and its inverse, choking, limits and the calibration of a stand."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from atleak.equations import DomainError, vacuum

AMBIENT, SUPPLY = 101_325.0, 16_665.0
MU = 1.81e-5
AREA = 0.8 * math.pi / 4.0 * 1e-6

clearances = st.floats(3e-6, 120e-6)
orifices = st.floats(0.2e-3, 1.5e-3)
factors = st.floats(1.0, 2.5)
losses = st.floats(0.0, 2.0)
lengths = st.floats(1e-3, 15e-3)


@given(clearances, orifices, factors, losses, st.lists(lengths, min_size=1, max_size=4))
def test_the_inverse_of_a_reading_is_the_clearance(
    clearance: float, orifice: float, factor: float, loss: float, contact: list[float]
) -> None:
    area = 0.8 * math.pi / 4.0 * orifice**2
    diameters = [0.008 + 0.003 * place for place in range(len(contact))]
    p = vacuum.circuit_pressure(
        SUPPLY, AMBIENT, area, diameters, [clearance] * len(contact), contact, 20.0, MU, factor, loss
    )
    if not SUPPLY + 1.0 < p < AMBIENT - 1.0:
        return  # the gauge shows supply or nothing: such a reading tells no clearance
    flow = vacuum.orifice_air_flow(p, SUPPLY, area, 20.0)
    found = vacuum.equal_clearance(flow, p, AMBIENT, diameters, contact, 20.0, MU, factor, loss)
    assert found == pytest.approx(clearance, rel=1e-7, abs=0.0)


def test_the_laminar_law_integrates_along_the_gap() -> None:
    """dp/dx = −12 μ G/(ρ c²) with ρ = p/(R T), marched from ambient to the end of the land."""
    c, length, d, temperature = 25e-6, 0.005, 0.0145, 35.0
    kelvin = temperature + 273.15
    flow = vacuum.gap_air_flow(60e3, AMBIENT, d, c, length, temperature, MU, 1.0, 0.0)
    flux = flow / (math.pi * d * c)
    marched = solve_ivp(
        lambda _, p: -12.0 * MU * flux * 287.0 * kelvin / (p * c * c), (0.0, length), [AMBIENT], rtol=1e-10, atol=1e-6
    )
    assert marched.y[0, -1] == pytest.approx(60e3, rel=1e-8, abs=0.0)


def test_the_loss_is_three_halves_of_a_velocity_head() -> None:
    """Where friction is nothing, 1.5 ½ρu² is all of a small pressure drop."""
    drop, kelvin = 20.0, 293.15
    flow = vacuum.gap_air_flow(AMBIENT - drop, AMBIENT, 0.02, 1e-3, 1e-6, 20.0, MU)
    density = AMBIENT / (287.0 * kelvin)
    speed = flow / (density * math.pi * 0.02 * 1e-3)
    assert 1.5 * 0.5 * density * speed**2 == pytest.approx(drop, rel=2e-3, abs=0.0)


def test_an_orifice_chokes_and_turns_smoothly() -> None:
    choked = vacuum.orifice_air_flow(60e3, [0.0, 10e3, 0.5283 * 60e3], AREA, 20.0)
    assert np.ptp(choked) < 1e-12 * choked[0]
    # the textbook's 0.6847 p A / √(R T)
    assert choked[0] == pytest.approx(0.6847 * 60e3 * AREA / math.sqrt(287.0 * 293.15), rel=1e-4, abs=0.0)
    rising = vacuum.orifice_air_flow(60e3, np.linspace(0.53, 1.0, 50) * 60e3, AREA, 20.0)
    assert (np.diff(rising) < 0.0).all()
    assert rising[-1] == 0.0
    small = 100.0  # incompressible where the drop is small
    density = 60e3 / (287.0 * 293.15)
    assert vacuum.orifice_air_flow(60e3, 60e3 - small, AREA, 20.0) == pytest.approx(
        AREA * math.sqrt(2.0 * density * small), rel=2e-3, abs=0.0
    )


def test_a_closed_circuit_reaches_the_supply_and_tells_no_clearance() -> None:
    p = vacuum.circuit_pressure(SUPPLY, AMBIENT, AREA, [0.01, 0.01], [0.0, 0.0], [0.005, 0.005], 20.0, MU)
    assert p == pytest.approx(SUPPLY, rel=1e-12, abs=0.0)
    for tight in (SUPPLY, SUPPLY - 500.0):  # a gauge that shows as much as the closed stand, or more
        assert vacuum.orifice_air_flow(tight, SUPPLY, AREA, 20.0) == 0.0
        assert vacuum.equal_clearance(0.0, tight, AMBIENT, 0.01, 0.005, 20.0, MU) == 0.0


def test_draws_are_computed_at_once() -> None:
    generator = np.random.default_rng(7)
    widths, ease = generator.uniform(8e-6, 60e-6, (3, 50)), generator.uniform(1.0, 2.5, (3, 50))
    d, length = np.full((3, 1), 0.0145), np.array([[0.004], [0.006], [0.009]])
    area = AREA * generator.uniform(0.9, 1.1, 50)
    together = vacuum.circuit_pressure(SUPPLY, AMBIENT, area, d, widths, length, 20.0, MU, ease)
    assert together.shape == (50,)
    for place in (0, 17, 49):
        lands = d[:, 0], widths[:, place], length[:, 0]

        def lacking(p: float, lands: tuple = lands, place: int = place) -> float:
            gaps = vacuum.gap_air_flow(p, AMBIENT, *lands, 20.0, MU, ease[:, place]).sum()
            return gaps - vacuum.orifice_air_flow(p, SUPPLY, area[place], 20.0)

        assert together[place] == pytest.approx(brentq(lacking, SUPPLY, AMBIENT, xtol=1e-9), rel=1e-10, abs=0.0)


@given(st.floats(0.5, 1.0), st.lists(st.floats(0.3e-3, 1.5e-3), min_size=2, max_size=4, unique=True))
def test_a_stand_is_calibrated_by_known_orifices(coefficient: float, known: list[float]) -> None:
    area = coefficient * math.pi / 4.0 * 1e-6
    pressures = [
        brentq(
            lambda p, d=d: (
                vacuum.orifice_air_flow(AMBIENT, p, 0.8 * math.pi / 4.0 * d * d, 20.0)
                - vacuum.orifice_air_flow(p, SUPPLY, area, 20.0)
            ),
            SUPPLY,
            AMBIENT,
        )
        for d in known
    ]
    found, u = vacuum.stand_flow_area(known, pressures, SUPPLY, AMBIENT, 0.8, 1000.0)
    assert found == pytest.approx(area, rel=1e-6, abs=0.0)
    assert u > 0.0
    finer = vacuum.stand_flow_area(known, pressures, SUPPLY, AMBIENT, 0.8, 500.0)[1]
    assert finer == pytest.approx(0.5 * u, rel=1e-3, abs=0.0)


def test_calibrations_that_scatter_widen_the_uncertainty() -> None:
    even = vacuum.stand_flow_area([0.5e-3, 1e-3], [27407.8, 83799.0], SUPPLY, AMBIENT, 0.8, 1000.0)
    apart = vacuum.stand_flow_area([0.5e-3, 1e-3], [31407.8, 79799.0], SUPPLY, AMBIENT, 0.8, 1000.0)
    assert apart[1] > 2.0 * even[1]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"pressure": AMBIENT}, "ambient pressure must be above the pressure in the circuit"),
        ({"temperature": -300.0}, "temperature must be above -100"),
        ({"diameters": 0.0}, "diameter must be positive"),
        ({"flow": -1.0}, "flow of air must be zero or positive"),
    ],
)
def test_what_no_stand_can_show_is_refused(change: dict[str, float], words: str) -> None:
    land = {"flow": 1e-5, "pressure": 60e3, "ambient": AMBIENT, "diameters": 0.01, "contact_lengths": 5e-3}
    with pytest.raises(DomainError, match=words):
        vacuum.equal_clearance(**{**land, "temperature": 20.0, "viscosity": MU, **change})


def test_a_supply_above_ambient_is_refused() -> None:
    with pytest.raises(DomainError, match="ambient pressure must be above the supply pressure"):
        vacuum.circuit_pressure(AMBIENT, AMBIENT, AREA, 0.01, 1e-5, 0.005, 20.0, MU)
