"""Clearances against the study's measurements and its thermal behaviour."""

from __future__ import annotations

import pytest

from atleak.equations.clearance import effective_clearance, radial_clearance, thermal_rate, wear, worn_clearance
from tests.unit.equations.referees import effective_clearance_two_temperatures


def test_radial_clearance_of_spool_6() -> None:
    # Dziubak & Szczepaniak, Energies 2023, 16, 7667, table 1: 9.939 and 9.942 mm; the sleeve is chosen here.
    assert radial_clearance(0.010000, 0.009939) * 1e6 == pytest.approx(30.5, rel=1e-9, abs=0.0)
    assert radial_clearance(0.010000, 0.009942) * 1e6 == pytest.approx(29.0, rel=1e-9, abs=0.0)


@pytest.mark.parametrize("nominal", [0.0, 0.1, 0.5])
def test_nominal_wear_of_table_2(nominal: float) -> None:
    assert wear(worn_clearance(24e-6, nominal * 24e-6), 24e-6) == pytest.approx(nominal, abs=1e-15)


def test_published_thermal_term_means_a_gap_of_30_um() -> None:
    # Table 3 follows from an opening of 0.0019 of the new clearance per kelvin; cast aluminium (21.5e-6/K) on
    # steel (12e-6/K) at 10 mm opens by 47.5 nm/K, so that clearance is about 25 µm, or 30 µm with 23.4e-6/K.
    rate = thermal_rate(0.010, 0.010, 21.5e-6, 12e-6)
    assert rate * 1e9 == pytest.approx(47.5, rel=1e-12, abs=0.0)
    assert rate / 0.0019 * 1e6 == pytest.approx(25.0, rel=1e-12, abs=0.0)
    assert thermal_rate(0.010, 0.010, 23.4e-6, 12e-6) / 0.0019 * 1e6 == pytest.approx(30.0, rel=1e-12, abs=0.0)


def test_aluminium_on_aluminium_hardly_opens() -> None:
    hot = effective_clearance(30e-6, thermal_rate(0.01006, 0.010, 21.5e-6, 21.5e-6), 80.0)
    assert hot * 1e6 == pytest.approx(30.0516, abs=5e-5)
    assert effective_clearance(30e-6, thermal_rate(0.01006, 0.010, 21.5e-6, 12e-6), 80.0) > 33.8e-6


def test_effective_clearance_is_equation_2_with_body_and_spool_equally_warm() -> None:
    for rise in (-60.0, 0.0, 80.0):
        whole = effective_clearance_two_temperatures(30e-6, 0.01006, 0.010, 21.5e-6, 12e-6, rise, rise)
        rate = thermal_rate(0.01006, 0.010, 21.5e-6, 12e-6)
        assert effective_clearance(30e-6, rate, rise) == pytest.approx(whole, rel=1e-12, abs=0.0)
