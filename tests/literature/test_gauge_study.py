"""Gauge studies whose data and results are published, in millimetres here whatever they were measured in."""

from __future__ import annotations

import numpy as np
import pytest

from atleak.analysis.gauge_study import GaugeStudy, analysed
from atleak.measurements.gauge_study import StudyReadings

# AIAG, Measurement Systems Analysis, 4th ed., chapter III: 10 parts (columns), 3 appraisers, 3 trials of each (rows).
AIAG = """
 0.29 -0.56 1.34 0.47 -0.80  0.02 0.59 -0.31 2.26 -1.36
 0.41 -0.68 1.17 0.50 -0.92 -0.11 0.75 -0.20 1.99 -1.25
 0.64 -0.58 1.27 0.64 -0.84 -0.21 0.66 -0.17 2.01 -1.31
 0.08 -0.47 1.19 0.01 -0.56 -0.20 0.47 -0.63 1.80 -1.68
 0.25 -1.22 0.94 1.03 -1.20  0.22 0.55  0.08 2.12 -1.62
 0.07 -0.68 1.34 0.20 -1.28  0.06 0.83 -0.34 2.19 -1.50
 0.04 -1.38 0.88 0.14 -1.46 -0.29 0.02 -0.46 1.77 -1.49
-0.11 -1.13 1.09 0.20 -1.07 -0.67 0.01 -0.56 1.45 -1.77
-0.15 -0.96 0.67 0.11 -1.45 -0.49 0.21 -0.49 1.87 -2.16
"""
# Houf & Berman, IEEE Transactions on Components, Hybrids and Manufacturing Technology 11 (1988), 516: thermal
# impedance of 10 power modules (rows), 3 operators with 3 tests each (columns).
HOUF_BERMAN = """
37 38 37 41 41 40 41 42 41
42 41 43 42 42 42 43 42 43
30 31 31 31 31 31 29 30 28
42 43 42 43 43 43 42 42 42
28 30 29 29 30 29 31 29 29
42 42 43 45 45 45 44 46 45
25 26 27 28 28 30 29 27 27
40 40 40 43 42 42 43 43 41
25 25 25 27 29 28 26 26 26
35 34 34 35 35 34 35 34 35
"""
MM = 1e-3


def _study(values: np.ndarray) -> GaugeStudy:
    parts = tuple(map(str, range(1, values.shape[0] + 1)))
    return analysed(StudyReadings(parts, ("A", "B", "C"), values * MM, "published"))


@pytest.fixture(scope="module")
def aiag() -> GaugeStudy:
    rows = np.array(AIAG.split(), float).reshape(3, 3, 10)
    return _study(rows.transpose(2, 0, 1))


@pytest.fixture(scope="module")
def houf_berman() -> GaugeStudy:
    return _study(np.array(HOUF_BERMAN.split(), float).reshape(10, 3, 3))


@pytest.mark.parametrize(
    ("source", "squares", "freedom"),
    [
        ("part", 88.3619, 9),
        ("operator", 3.1673, 2),
        ("interaction", 0.3590, 18),
        ("repeatability", 2.7589, 60),
        ("total", 94.6471, 89),
    ],
)
def test_the_analysis_of_variance_of_aiags_example_is_the_printed_one(
    aiag: GaugeStudy, source: str, squares: float, freedom: int
) -> None:
    row = aiag.row(source)
    assert row.squares / MM**2 == pytest.approx(squares, abs=5e-5)
    assert row.freedom == freedom


def test_the_interaction_of_aiags_example_is_pooled_as_printed(aiag: GaugeStudy) -> None:
    row = aiag.row("interaction")
    assert row.f == pytest.approx(0.434, abs=5e-4)
    assert row.probability == pytest.approx(0.974, abs=5e-4)
    assert aiag.pooled


@pytest.mark.parametrize(
    ("component", "variance", "of_study_percent", "contribution_percent"),
    [
        ("grr", 0.09143, 27.86, 7.76),
        ("repeatability", 0.03997, 18.42, 3.39),
        ("reproducibility", 0.05146, 20.90, 4.37),
        ("part", 1.08645, 96.04, 92.24),
        ("total", 1.17788, 100.0, 100.0),
    ],
)
def test_the_components_of_aiags_example_are_the_printed_ones(
    aiag: GaugeStudy, component: str, variance: float, of_study_percent: float, contribution_percent: float
) -> None:
    found = aiag.of(component)
    assert found.variance / MM**2 == pytest.approx(variance, abs=1e-5)
    assert found.of_study is not None
    assert found.of_study * 100 == pytest.approx(of_study_percent, abs=5e-3)
    assert found.contribution is not None
    assert found.contribution * 100 == pytest.approx(contribution_percent, abs=5e-3)


def test_the_gauge_of_aiags_example_tells_four_groups_apart(aiag: GaugeStudy) -> None:
    assert aiag.categories == 4
    assert aiag.judged == "marginal"


@pytest.mark.parametrize(
    ("component", "variance"),
    [
        ("grr", 1.804),
        ("repeatability", 0.511),
        ("reproducibility", 1.293),
        ("operator", 0.565),
        ("interaction", 0.728),
        ("part", 48.293),
        ("total", 50.096),
    ],
)
def test_a_significant_interaction_is_kept_as_five_programs_do(
    houf_berman: GaugeStudy, component: str, variance: float
) -> None:
    # variance components by hand, Minitab, JMP, R and JASP alike: JASP verification project, chapter 10
    assert not houf_berman.pooled
    assert houf_berman.of(component).variance / MM**2 == pytest.approx(variance, abs=5e-4)
