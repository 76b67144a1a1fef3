"""The numbers with which ``docs/source-study.md`` shows where the article contradicts itself, each derived again."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from atleak.analysis.source_study import VariantResult, run_variants
from atleak.catalogue.controller import Controller
from atleak.catalogue.fluid import load_fluid
from atleak.engine.profile import PAPER
from atleak.equations import clearance, fluid, gap, pressure, pump
from atleak.readers.logs import read_road_test
from tests.unit.equations import referees

DM3_MIN = 6e4


@pytest.fixture(scope="module")
def results(four_speed: Controller, sample_log: Path) -> dict[str, VariantResult]:
    return {each.variant.name: each for each in run_variants(four_speed, read_road_test(sample_log))}


def test_1_viscosity_in_pascal_seconds_would_be_a_factor_of_1000() -> None:
    """10⁶ Δp π d c³ / (12 μ l) with kPa and mm is mm³/s for μ in mPa·s."""
    exact = gap.annular_flow(800e3, 10e-3, 30e-6, 10.93e-6, 783.0, 4e-3) * 1e9  # mm³/s
    printed = 1e6 * 800 * np.pi * 10 * 0.030**3 / (12 * 10.93 * 0.783 * 4)
    assert printed == pytest.approx(exact, rel=1e-12, abs=0.0)
    in_pascal_seconds = 1e6 * 800 * np.pi * 10 * 0.030**3 / (12 * 10.93e-3 * 0.783 * 4)
    assert in_pascal_seconds / exact == pytest.approx(1000.0, rel=1e-12, abs=0.0)


def test_2_leakage_is_inversely_proportional_to_viscosity() -> None:
    at = [gap.annular_flow(800e3, 10e-3, 30e-6, nu, 783.0, 4e-3) for nu in (5e-6, 10e-6, 20e-6)]
    assert at[0] / at[1] == pytest.approx(2.0, rel=1e-12, abs=0.0)
    assert at[1] - at[0] != pytest.approx((at[2] - at[1]) / 2, rel=0.1, abs=0.0)  # as a straight line would have it


def test_3_pump_at_2500_rpm() -> None:
    q_p = pump.displacement(4.5e-3, 12, 12e-3, 8.4e-3)
    assert q_p * 1e9 == pytest.approx(17100.317, abs=5e-4)
    assert pump.capacity(q_p, 2500 / 60, 0.95) * DM3_MIN == pytest.approx(40.613, abs=5e-4)
    assert 33.6 / DM3_MIN / (q_p * 2500 / 60) == pytest.approx(0.786, abs=5e-4)
    assert 33.6 / DM3_MIN / (q_p * 0.95) * 60 == pytest.approx(2068, abs=0.5)


def test_4_kilopascal_times_square_millimetre_is_millinewton() -> None:
    assert pressure.control_pressure(0.0, 1e-3, 1e-6, 0.0, 0.0, 0.0, 0.0) == pytest.approx(1e3, rel=1e-9, abs=0.0)


def test_5_spring_rate_needs_megapascal() -> None:
    """0.8·10⁵ GPa would make a spring of 1 mm wire a thousand times stiffer: 1953 instead of 1.953 N/mm."""
    assert pressure.spring_rate(80_000e6, 1e-3, 10, 8e-3) * 1e-3 == pytest.approx(1.953125, rel=1e-9, abs=0.0)
    assert pressure.spring_rate(80_000e9, 1e-3, 10, 8e-3) * 1e-3 == pytest.approx(1953.125, rel=1e-9, abs=0.0)


def test_6_deflection_counts_from_the_free_length() -> None:
    """Free 30 mm, built in at 25, working at 20: 10 mm, of which the pre-tensioned length shows only 5."""
    assert pressure.spring_deflection(30e-3, 20e-3) == pytest.approx(10e-3, rel=1e-9, abs=0.0)
    assert pressure.spring_deflection(25e-3, 20e-3) == pytest.approx(5e-3, rel=1e-9, abs=0.0)


def test_7_printed_form_of_the_control_pressure(four_speed: Controller) -> None:
    """With the shipped valve 17 at 800 kPa: 320.5 kPa solve the balance, the printed form's 676.9 do not."""
    area = {d: pressure.annulus_area(d * 1e-3, 5e-3) for d in (12, 10, 9)}
    a_1, force = pressure.annulus_area(12e-3), 19.53125
    solved = pressure.control_pressure(800e3, force, a_1, area[10], area[9], area[10], area[9])
    balance = referees.spool_balance(solved, 800e3, force, a_1, area[10], area[9], area[10], area[9])
    assert (
        solved
        == pytest.approx(four_speed.section_pressures(800e3, 0.0)["p_s"], rel=1e-9, abs=0.0)
        == pytest.approx(320.5437e3, abs=0.05)
    )
    assert balance == pytest.approx(0.0, abs=1e-9)
    printed = 800e3 * area[10] / area[12] + force / a_1
    assert printed == pytest.approx(676.9e3, abs=50)
    assert abs(referees.spool_balance(printed, 800e3, force, a_1, area[10], area[9], area[10], area[9])) > 30.0


def test_8_three_conventions_of_drains_stay_as_printed(four_speed: Controller) -> None:
    lows = {str(gap.low) for gap in four_speed.gaps_in(2) if gap.published}
    assert {"0.1*p_g", "0.1*p_m", "0.1*p_k", "drain"} <= lows


def test_9_land_1_of_valve_8_is_two_gaps(four_speed: Controller) -> None:
    ends = {(str(gap.high), str(gap.low)) for gap in four_speed.gaps_in(2) if gap.key == ("8", 1)}
    assert ends == {("p_g", "p_m"), ("p_m", "0.1*p_m")}


def test_10_every_land_of_valve_26_has_its_own_entry_at_half_the_main_pressure(four_speed: Controller) -> None:
    gaps = [gap for gap in four_speed.gaps_in(2) if gap.component == "26"]
    assert [(gap.land, str(gap.high), str(gap.low)) for gap in gaps] == [
        (land, "p_g", "0.5*p_g") for land in (1, 2, 3, 4)
    ]


def test_11_what_flows_into_p_m_is_counted_twice(four_speed: Controller, sample_log: Path) -> None:
    sump = run_variants(four_speed, read_road_test(sample_log), profile=PAPER.with_options(pump_draw="into_sump"))
    every = run_variants(four_speed, read_road_test(sample_log))
    ratio = [s.computed.max_leakage.leakage / e.computed.max_leakage.leakage for s, e in zip(sump, every, strict=True)]
    assert ratio == pytest.approx([0.883] * 8, abs=0.001)


def test_12_regression_against_the_data_sheet() -> None:
    assert fluid.study_viscosity(40.0) * 1e6 == pytest.approx(61.6, abs=0.05)
    assert fluid.study_viscosity(100.0) * 1e6 == pytest.approx(4.67, abs=0.005)


def test_13_cold_viscosity() -> None:
    assert fluid.study_viscosity(-40.0) * 1e6 == pytest.approx(1921, abs=0.5)
    assert fluid.astm_d341(-40.0, *fluid.astm_d341_coefficients(40, 42e-6, 100, 7e-6)) * 1e6 == pytest.approx(
        35155, abs=0.5
    )


def test_14_slope_of_the_density() -> None:
    assert abs((0.768 - 0.870) / 140 + 0.00073) <= 5e-6
    assert fluid.study_density(15.0) * 1e-3 == pytest.approx(0.830, abs=5e-4)
    assert load_fluid("mobil_atf_220").density(15.0) * 1e-3 == pytest.approx(0.870, rel=1e-9, abs=0.0)


def test_15_w3_and_w4_follow_from_the_used_oil(results: dict[str, VariantResult]) -> None:
    for name, printed, tabulated in (("W3", 3.64, 2.80), ("W4", 8.56, 6.58)):
        assert results[name].computed.max_leakage.leakage * DM3_MIN == pytest.approx(printed, abs=0.005)
        assert results[name].as_tabulated.max_leakage.leakage * DM3_MIN == pytest.approx(tabulated, abs=0.005)


def test_16_share_of_w8(results: dict[str, VariantResult]) -> None:
    assert abs(11.23 / 0.562 - 19.98) <= 0.005
    assert abs(100 * 11.23 / 24.37 - 46.1) <= 0.05
    assert abs(100 * 11.23 / 24.31 - 46.2) <= 0.05
    assert results["W8"].computed.max_leakage.share * 100 == pytest.approx(46.2, abs=0.05)


def test_17_w7_is_1_43(results: dict[str, VariantResult]) -> None:
    computed = results["W7"].computed.max_leakage.leakage * DM3_MIN
    assert abs(computed - 1.43) < 0.005 < abs(computed - 1.41)


def test_18_share_is_largest_at_idle(results: dict[str, VariantResult], sample_log: Path) -> None:
    speed = read_road_test(sample_log).values("engine_speed") * 60
    for result in results.values():
        worst, most = result.computed.max_share, result.computed.max_leakage
        assert worst.share > 1.3 * most.share
        assert speed[np.argmin(np.abs(result.time - worst.time))] == pytest.approx(800, abs=5)
        assert worst.leakage < most.leakage


def test_19_and_20_shares_of_the_conclusions(results: dict[str, VariantResult]) -> None:
    assert results["W2"].computed.max_leakage.share * 100 == pytest.approx(11.6, abs=0.05)
    assert results["W3"].computed.max_leakage.share * 100 == pytest.approx(15.0, abs=0.05)
    assert results["W3"].as_tabulated.max_leakage.share * 100 == pytest.approx(11.5, abs=0.05)
    assert results["W3"].computed.max_share.share * 100 == pytest.approx(20.8, abs=0.05)


def test_21_lower_viscosity_and_higher_leakage(results: dict[str, VariantResult]) -> None:
    assert abs(8.40 / 10.93 - 1 + 0.231) <= 5e-4
    first, second = (results[name].computed.max_leakage.leakage for name in ("W1", "W2"))
    assert second / first - 1 == pytest.approx(0.301, abs=5e-4)


def test_22_a_bore_measured_across_its_wear_hides_it() -> None:
    """A bore worn 10 µm to one side: across it still measures 10.060 mm, so a clearance of 30 µm, along it 35."""
    across, along = (clearance.radial_clearance(bore, 10.000e-3) for bore in (10.060e-3, 10.070e-3))
    assert (across * 1e6, along * 1e6) == (
        pytest.approx(30.0, rel=1e-9, abs=0.0),
        pytest.approx(35.0, rel=1e-9, abs=0.0),
    )


def test_23_repeats_of_table_1_swap_the_coordinates() -> None:
    first, second = (89.605, 79.666), (79.666, 89.605)
    assert second == first[::-1]
    assert abs(first[0] - first[1]) == abs(second[0] - second[1]) == pytest.approx(9.939, rel=1e-9, abs=0.0)


def test_errata_of_the_document_are_numbered_without_a_gap(root: Path) -> None:
    text = (root / "docs" / "source-study.md").read_text(encoding="utf-8").partition("## Errata")[2]
    numbers = re.findall(r"^(\d+)\. \*.+\.\* .+$", text, flags=re.MULTILINE)
    assert [int(number) for number in numbers] == list(range(1, 24))
