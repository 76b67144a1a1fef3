"""The source study's Tables 2 and 3 and the stated points of its test, cell by cell at the printed precision.

Dziubak & Szczepaniak, Energies 2023, 16, 7667. The controller and the road test are representative and were found so
that these values come out (``tools/fit_source_study.py``): the tests say that the engine still gives them. What the
printed rows allow at all is tested at the end, without controller and road test.
"""

from __future__ import annotations

from decimal import Decimal
from pathlib import Path

import numpy as np
import pytest

from atleak.analysis.source_study import (
    VARIANTS,
    ComparedPoint,
    VariantResult,
    compare_points,
    gear_at_most_leakage,
    run_variants,
)
from atleak.catalogue.controller import Controller
from atleak.readers.logs import read_road_test

# variant: fluid temperature °C, wear %, kinematic viscosity mm²/s, density g/cm³
TABLE_2 = {
    "W1": ("80", "0", "10.93", "0.783"),
    "W2": ("80", "0", "8.40", "0.783"),
    "W3": ("80", "10", "10.93", "0.783"),
    "W4": ("80", "50", "10.93", "0.783"),
    "W5": ("-40", "50", "1923.0", "0.870"),
    "W6": ("20", "50", "145.0", "0.826"),
    "W7": ("40", "50", "42.0", "0.812"),
    "W8": ("100", "50", "7.0", "0.768"),
}
# variant: maximum leakage dm³/min, its share of the pump's instantaneous capacity %
TABLE_3 = {
    "W1": ("2.16", "8.89"),
    "W2": ("2.81", "11.6"),
    "W3": ("3.64", "14.9"),
    "W4": ("8.56", "35.2"),
    "W5": ("0.021", "0.086"),
    "W6": ("0.38", "1.56"),
    "W7": ("1.43", "5.89"),
    "W8": ("11.23", "56.2"),
}
#: shares whose last digit is out of reach together with the others' (see the last test): within 1 % all the same
OUT_OF_REACH = ("W3", "W6", "W7")
STATED = {
    "W4-start": "6.37",
    "W4-before-shift": "6.22",
    "W4-least": "5.09",
    "W4-after-rise": "8.46",
    "W4-most": "8.56",
    "W8-least": "6.67",
    "W8-most": "11.23",
    "pump-most": "33.6",
}
DM3_MIN = 6e4


@pytest.fixture(scope="module")
def results(four_speed: Controller, sample_log: Path) -> dict[str, VariantResult]:
    computed_variants = run_variants(four_speed, read_road_test(sample_log))
    return {result.variant.name: result for result in computed_variants}


@pytest.fixture(scope="module")
def points(results: dict[str, VariantResult]) -> dict[str, ComparedPoint]:
    return {each.point.key: each for each in compare_points(list(results.values()))}


def half_digit(printed: str) -> float:
    return 0.5 * 10.0 ** int(Decimal(printed).as_tuple().exponent)


def reaches(printed: str, value: float) -> bool:
    return abs(value - float(printed)) <= half_digit(printed)


@pytest.mark.parametrize(
    ("variant", "column", "printed"),
    [
        pytest.param(name, column, printed, id=f"table2-{name}-{word}")
        for name, row in TABLE_2.items()
        for column, (word, printed) in enumerate(
            zip(("temperature", "wear", "kinematic_viscosity", "density"), row, strict=True)
        )
    ],
)
def test_table_2_is_what_the_variants_hold(variant: str, column: int, printed: str) -> None:
    held = next(each for each in VARIANTS if each.name == variant)
    values = (held.temperature, held.wear * 100, held.kinematic_viscosity * 1e6, held.density * 1e-3)
    assert values[column] == pytest.approx(float(printed), rel=1e-12, abs=0.0)


@pytest.mark.parametrize("variant", [pytest.param(name, id=f"table3-{name}-printed") for name in TABLE_3])
def test_printed_results_are_kept_with_their_digits(variant: str) -> None:
    held = next(each for each in VARIANTS if each.name == variant)
    assert (str(held.printed_max_leakage), str(held.printed_max_share)) == TABLE_3[variant]


@pytest.mark.parametrize("variant", [pytest.param(name, id=f"table3-{name}-max_leakage") for name in TABLE_3])
def test_maximum_leakage_to_every_printed_digit(variant: str, results: dict[str, VariantResult]) -> None:
    computed = results[variant].computed.max_leakage
    printed = TABLE_3[variant][0]
    assert reaches(printed, computed.leakage * DM3_MIN)
    assert computed.leakage * DM3_MIN == pytest.approx(float(printed), rel=0.01, abs=0.0)
    assert computed.time == pytest.approx(2.1, abs=0.05)
    assert gear_at_most_leakage(results[variant].computed) == 2


@pytest.mark.parametrize(
    "variant",
    [pytest.param(name, id=f"table3-{name}-max_share") for name in TABLE_3 if name not in {*OUT_OF_REACH, "W8"}],
)
def test_share_at_that_instant_to_every_printed_digit(variant: str, results: dict[str, VariantResult]) -> None:
    share = results[variant].computed.max_leakage.share * 100
    assert reaches(TABLE_3[variant][1], share)
    assert share == pytest.approx(float(TABLE_3[variant][1]), rel=0.01, abs=0.0)


@pytest.mark.parametrize(
    "variant", [pytest.param(name, id=f"table3-{name}-max_share-within_1_percent") for name in OUT_OF_REACH]
)
def test_share_at_that_instant_within_1_percent(variant: str, results: dict[str, VariantResult]) -> None:
    assert results[variant].computed.max_leakage.share * 100 == pytest.approx(
        float(TABLE_3[variant][1]), rel=0.01, abs=0.0
    )


@pytest.mark.parametrize(
    ("variant", "expected"),
    [pytest.param("W3", "2.80", id="table3-W3-as_tabulated"), pytest.param("W4", "6.58", id="table3-W4-as_tabulated")],
)
def test_table_2s_viscosity_does_not_give_table_3(
    variant: str, expected: str, results: dict[str, VariantResult]
) -> None:
    """W3 and W4 follow from 8.40 mm²/s: with the 10.93 that Table 2 prints they are a quarter smaller."""
    tabulated = results[variant].as_tabulated.max_leakage.leakage * DM3_MIN
    assert reaches(expected, tabulated)
    assert tabulated / float(TABLE_3[variant][0]) == pytest.approx(8.40 / 10.93, rel=1e-3, abs=0.0)


def test_only_w3_and_w4_differ_between_computed_and_as_tabulated(results: dict[str, VariantResult]) -> None:
    assert {name for name, result in results.items() if result.as_tabulated is not result.computed} == {"W3", "W4"}


def test_share_of_w8_is_46_and_not_56_percent(results: dict[str, VariantResult]) -> None:
    """table3-W8-max_share: 11.23 dm³/min of the pump flow that all other rows share; 56.2 % needs another pump flow."""
    share = results["W8"].computed.max_leakage.share * 100
    assert 46.1 <= share <= 46.2
    assert abs(11.23 / 0.562 - 19.98) <= 0.005
    flows = [float(q) / float(u) * 100 for name, (q, u) in TABLE_3.items() if name != "W8"]
    assert min(flows) > 24.2
    assert results["W8"].computed.max_leakage.pump_capacity * DM3_MIN == pytest.approx(24.34, rel=0.01, abs=0.0)


@pytest.mark.parametrize("key", [pytest.param(key, id=f"test-{key}") for key in STATED])
def test_stated_points_of_the_test_to_every_printed_digit(key: str, points: dict[str, ComparedPoint]) -> None:
    assert str(points[key].point.printed) == STATED[key]
    assert reaches(STATED[key], points[key].computed)


def test_pump_at_the_instant_of_most_leakage(points: dict[str, ComparedPoint]) -> None:
    """24.34 dm³/min is not printed; it lies within what the printed rows allow, 24.31 to 24.37."""
    assert 24.31 <= points["pump-at-most-leakage"].computed <= 24.37


def test_least_leakage_follows_the_stated_0_8_s_and_precedes_the_rise(points: dict[str, ComparedPoint]) -> None:
    assert 0.8 < points["W4-least"].time < points["W4-after-rise"].time < points["W4-most"].time


def test_printed_rows_of_w1_to_w7_allow_one_pump_flow() -> None:
    """Each row's leakage and share, with their rounding, give a range of pump flows; together 24.31 to 24.37."""
    low = max((float(q) - half_digit(q)) / (float(u) + half_digit(u)) * 100 for q, u in rows_but_w8())
    high = min((float(q) + half_digit(q)) / (float(u) - half_digit(u)) * 100 for q, u in rows_but_w8())
    assert (low, high) == (pytest.approx(24.31, abs=0.005), pytest.approx(24.37, abs=0.005))


def rows_but_w8() -> list[tuple[str, str]]:
    return [row for name, row in TABLE_3.items() if name != "W8"]


def test_no_one_gap_law_and_pump_flow_give_every_digit_of_every_share() -> None:
    """q = K (1 + Z + a (T - 20))³ / (ν ρ) over one pump flow: every leakage can be met, the seven shares cannot.

    W6's 1.56 % wants more leakage at 20 °C than 11.23 dm³/min at 100 °C leave room for.
    """
    temperature, wear, viscosity, density = np.array(
        [[float(value) for value in row] for row in TABLE_2.values()]
    ).T.copy()
    viscosity[[2, 3]] = 8.40  # W3 and W4, as above
    leakage, share = (np.array([float(row[column]) for row in TABLE_3.values()]) for column in (0, 1))
    half_q, half_u = (np.array([half_digit(row[column]) for row in TABLE_3.values()]) for column in (0, 1))
    K, a = np.meshgrid(np.linspace(13.30, 13.50, 401), np.linspace(0.00184, 0.00194, 401), indexing="ij")
    growth = 1 + wear / 100 + a[..., None] * (temperature - 20)
    flow = K[..., None] * growth**3 / (viscosity * density)
    met = np.all(np.abs(flow - leakage) <= half_q, axis=-1)
    assert met.any()
    assert (K[met].min(), K[met].max()) == (pytest.approx(13.361, abs=0.002), pytest.approx(13.444, abs=0.002))
    reached = max(
        int(np.max(np.sum(np.abs(flow[met] / pump * 100 - share) <= half_u, axis=-1)))
        for pump in np.arange(24.20, 24.50, 0.005)
    )
    assert reached == 5  # W1, W2, W4, W6 and W7, and then W5 is off by 1.8 %
