"""Gap flow against published numbers, at the sources' own precision."""

from __future__ import annotations

import math

import pytest

from atleak.equations.clearance import effective_clearance, thermal_rate, worn_clearance
from atleak.equations.gap import annular_flow, eccentricity_factor, entry_loss_flow, obliteration
from tests.unit.equations.referees import annular_flow_compressible, exact_annulus_flow

# White F. M., Fluid Mechanics, 7th ed., McGraw-Hill 2011, table of laminar friction factors for a concentric
# annulus: ratio of the radii, f Re on the hydraulic diameter.
WHITE_ANNULUS = [
    (0.00001, 70.09),
    (0.0001, 71.78),
    (0.001, 74.68),
    (0.01, 80.11),
    (0.05, 86.27),
    (0.1, 89.37),
    (0.2, 92.35),
    (0.4, 94.71),
    (0.6, 95.59),
    (0.8, 95.92),
]


@pytest.mark.parametrize(("ratio", "f_re"), WHITE_ANNULUS)
def test_exact_annulus_gives_published_friction_factors(ratio: float, f_re: float) -> None:
    outer, pressure_drop, viscosity, length = 0.010, 1000.0, 0.02, 0.3
    q = exact_annulus_flow(pressure_drop, 2 * ratio * outer, 2 * outer, viscosity, length)
    velocity = q / (math.pi * outer**2 * (1 - ratio**2))
    hydraulic_diameter = 2 * outer * (1 - ratio)
    assert 2 * pressure_drop * hydraulic_diameter**2 / (viscosity * velocity * length) == pytest.approx(
        f_re, abs=0.0051
    )


def test_exact_annulus_tends_to_parallel_plates() -> None:
    outer, inner = 0.010, 0.010 * (1 - 1e-7)
    q = exact_annulus_flow(1000.0, 2 * inner, 2 * outer, 0.02, 0.3)
    velocity = q / (math.pi * (outer - inner) * (outer + inner))
    assert 2 * 1000.0 * (2 * (outer - inner)) ** 2 / (0.02 * velocity * 0.3) == pytest.approx(96.0, rel=1e-6, abs=0.0)


def test_fully_eccentric_spool_leaks_two_and_a_half_times_as_much() -> None:
    assert eccentricity_factor(30e-6, 30e-6) == 2.5
    concentric = annular_flow(800e3, 0.01, 30e-6, 11e-6, 783.0, 0.008)
    assert annular_flow(800e3, 0.01, 30e-6, 11e-6, 783.0, 0.008, 30e-6) / concentric == pytest.approx(
        2.5, rel=1e-14, abs=0.0
    )


def test_viscosity_taken_literally_is_a_factor_of_1000() -> None:
    # The article gives μ in Pa·s beside the factor 10⁶ of its mm-kPa form, which closes only for mPa·s.
    pressure_drop, d, c, length, nu, rho = 800.0, 10.0, 0.03, 8.0, 10.93, 0.783
    si = annular_flow_compressible(pressure_drop * 1e3, d / 1e3, c / 1e3, nu * rho / 1e3, length / 1e3, 1.0, 1.0)

    def printed(mu: float) -> float:
        return 1e6 * pressure_drop * math.pi * d * c**3 / (12 * mu * length)

    assert printed(nu * rho) == pytest.approx(si * 1e9, rel=1e-12, abs=0.0)
    assert printed(nu * rho * 1e-3) == pytest.approx(si * 1e12, rel=1e-12, abs=0.0)


# Dziubak & Szczepaniak, Energies 2023, 16, 7667, tables 2 and 3: temperature °C, wear, the viscosity mm²/s
# its results follow from, density g/cm³, printed maximum leakage dm³/min and its last digit.
VARIANTS = {
    "W1": (80, 0.0, 10.93, 0.783, 2.16, 0.01),
    "W2": (80, 0.0, 8.40, 0.783, 2.81, 0.01),
    "W3": (80, 0.1, 8.40, 0.783, 3.64, 0.01),
    "W4": (80, 0.5, 8.40, 0.783, 8.56, 0.01),
    "W5": (-40, 0.5, 1923.0, 0.870, 0.021, 0.001),
    "W6": (20, 0.5, 145.0, 0.826, 0.38, 0.01),
    "W7": (40, 0.5, 42.0, 0.812, 1.43, 0.01),
    "W8": (100, 0.5, 7.0, 0.768, 11.23, 0.01),
}


def variant_flow(temperature: float, wear: float, viscosity: float, density: float) -> float:
    """One land, 10 mm and 30 µm when new, that opens by 0.19 % of its new clearance per kelvin."""
    c_m, sleeve, spool, beta_s = 30e-6, 0.01006, 0.010, 12e-6
    beta_k = (2 * 0.0019 * c_m + beta_s * spool) / sleeve
    cold = worn_clearance(c_m, wear * c_m)
    rise = temperature - 20.0
    hot = effective_clearance(cold, thermal_rate(sleeve, spool, beta_k, beta_s), rise)
    return annular_flow(800e3, spool, hot, viscosity * 1e-6, density * 1e3, 0.008)


@pytest.mark.parametrize("variant", VARIANTS)
def test_equations_reproduce_every_row_of_table_3(variant: str) -> None:
    # 13.39 is the only fitted number: the flow in dm³/min at 20 °C, without wear, for ν ρ = 1 mm²/s · g/cm³.
    temperature, wear, viscosity, density, printed, digit = VARIANTS[variant]
    scale = 13.39 / variant_flow(20.0, 0.0, 1.0, 1.0)
    assert scale * variant_flow(temperature, wear, viscosity, density) == pytest.approx(printed, abs=digit / 2)


def test_tabulated_viscosity_of_w3_and_w4_does_not_give_table_3() -> None:
    scale = 13.39 / variant_flow(20.0, 0.0, 1.0, 1.0)
    assert scale * variant_flow(80, 0.1, 10.93, 0.783) == pytest.approx(2.80, abs=0.01)
    assert scale * variant_flow(80, 0.5, 10.93, 0.783) == pytest.approx(6.58, abs=0.01)


@pytest.mark.parametrize(("length", "loss"), [(5e-3, 0.02), (2e-3, 0.10)])
def test_entry_loss_takes_2_to_10_percent_of_a_wide_hot_gap(length: float, loss: float) -> None:
    gap = (1000e3, 0.010, 45e-6, 7.0e-6, 768.0, length)
    assert 1 - entry_loss_flow(*gap) / annular_flow(*gap) == pytest.approx(loss, abs=0.015)


def test_entry_loss_is_negligible_at_30_um_and_80_degrees() -> None:
    gap = (800e3, 0.010, 30e-6, 10.93e-6, 783.0, 8e-3)
    assert 1 - entry_loss_flow(*gap) / annular_flow(*gap) < 1e-3


def test_obliteration_limits_of_the_study() -> None:
    assert [obliteration(c * 1e-6) for c in (4.9, 5.1, 19.9, 20.1)] == [
        "closed",
        "partial",
        "partial",
        "free",
    ]
