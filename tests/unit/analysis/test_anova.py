"""The analysis of a gauge study against models fitted by least squares, and in the cases that need a decision."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from atleak.analysis.gauge_study import GaugeStudy, analysed
from atleak.common.errors import InputError
from atleak.measurements.gauge_study import StudyReadings

UM = 1e-6


def readings(values: np.ndarray) -> StudyReadings:
    parts, operators, _ = values.shape
    return StudyReadings(tuple(map(str, range(parts))), tuple(map(str, range(operators))), values, "study.xlsx")


def simulated(
    seed: int, *, part: float = 10.0, operator: float = 0.0, interaction: float = 0.0, repeat: float = 1.0,
    shape: tuple[int, int, int] = (10, 3, 3),
) -> np.ndarray:  # fmt: skip
    """Readings around 12.7 mm with these standard deviations [µm]."""
    random = np.random.default_rng(seed)
    parts, operators, _ = shape
    deviations = (
        part * random.standard_normal((parts, 1, 1))
        + operator * random.standard_normal((1, operators, 1))
        + interaction * random.standard_normal((parts, operators, 1))
        + repeat * random.standard_normal(shape)
    )
    return 12.7e-3 + deviations * UM


def codes(study: GaugeStudy) -> set[str]:
    return {message.code for message in study.messages}


def _left_over(values: np.ndarray, *columns: np.ndarray) -> float:
    """The sum of squares [µm²] that a model of these columns leaves, by least squares."""
    y = (values.ravel() - values.mean()) / UM
    design = np.column_stack([np.ones(y.size), *columns])
    fitted, *_ = np.linalg.lstsq(design, y, rcond=None)
    return float(((y - design @ fitted) ** 2).sum())


def _of_each(numbers: np.ndarray) -> np.ndarray:
    return np.eye(int(numbers.max()) + 1)[numbers.ravel()]


@given(
    seed=st.integers(0, 10_000),
    shape=st.tuples(st.integers(2, 6), st.integers(2, 4), st.integers(2, 4)),
    operator=st.floats(0.0, 5.0),
    interaction=st.floats(0.0, 5.0),
)
@settings(max_examples=25, deadline=None)
def test_sums_of_squares_are_what_nested_models_leave_over(
    seed: int, shape: tuple[int, int, int], operator: float, interaction: float
) -> None:
    values = simulated(seed, operator=operator, interaction=interaction, shape=shape)
    part, person, _ = np.indices(shape)
    of_part, of_person, of_pair = _of_each(part), _of_each(person), _of_each(part * shape[1] + person)
    study = analysed(readings(values))
    expected = {
        "part": _left_over(values) - _left_over(values, of_part),
        "operator": _left_over(values, of_part) - _left_over(values, of_part, of_person),
        "interaction": _left_over(values, of_part, of_person) - _left_over(values, of_pair),
        "repeatability": _left_over(values, of_pair),
        "total": _left_over(values),
    }
    for source, squares in expected.items():
        assert study.row(source).squares / UM**2 == pytest.approx(squares, abs=1e-6 * expected["total"])


def test_components_of_many_studies_average_to_those_they_were_made_with() -> None:
    made = {"part": 10.0, "operator": 2.0, "interaction": 1.5, "repeatability": 1.0}
    found = {name: [] for name in made}
    for seed in range(300):
        values = simulated(seed, operator=2.0, interaction=1.5, shape=(10, 5, 3))
        study = analysed(readings(values))
        for name in made:
            found[name].append(study.of(name).variance / UM**2)
    for name, deviation in made.items():
        middle, error = np.mean(found[name]), np.std(found[name]) / math.sqrt(300)
        assert middle == pytest.approx(deviation**2, abs=4.0 * float(error))


def test_variances_add_up_and_shares_follow_from_them() -> None:
    study = analysed(readings(simulated(3, operator=2.0, interaction=2.0)), tolerance=30e-6)
    parts = sum(study.of(name).variance for name in ("repeatability", "operator", "interaction", "part"))
    assert study.of("total").variance == pytest.approx(parts, abs=1e-9 * parts)
    grr = study.grr
    assert grr.of_tolerance == pytest.approx(6.0 * grr.deviation / 30e-6, abs=1e-12)
    assert study.judged == "refused"


def test_a_negative_variance_is_set_to_zero_and_said() -> None:
    values = simulated(1, operator=0.0)
    values = values - values.mean(axis=(0, 2), keepdims=True) + values.mean()  # people agree better than by chance
    study = analysed(readings(values))
    assert study.of("operator").variance == 0.0
    assert study.of("reproducibility").variance == 0.0
    (said,) = [message.text for message in study.messages if message.code == "variance_set_to_zero"]
    assert said == "The estimated variance of the operators came out negative and is set to zero."


def test_alpha_decides_whether_the_interaction_counts() -> None:
    values = readings(simulated(5, interaction=0.6))
    chance = analysed(values).row("interaction").probability
    assert chance is not None
    kept, pooled = analysed(values, alpha=chance * 1.01), analysed(values, alpha=chance * 0.99)
    assert (kept.pooled, pooled.pooled) == (False, True)
    assert kept.of("interaction").variance > 0.0 == pooled.of("interaction").variance
    assert f"not below {chance * 0.99:g}" in pooled.messages[0].text


def test_repeats_that_all_agree_are_said_to_hide_below_the_resolution() -> None:
    values = 12.7e-3 + UM * np.round(np.array([[[0.0] * 2, [3.0] * 2], [[10.0] * 2, [12.0] * 2]]))
    study = analysed(readings(values))
    assert study.of("repeatability").variance == 0.0
    assert "repeats_alike" in codes(study)


def test_readings_that_never_differ_show_nothing() -> None:
    study = analysed(readings(np.full((4, 3, 2), 12.7e-3)))
    assert (study.categories, study.judged, study.grr.of_study) == (None, None, None)
    assert "nothing_varies" in codes(study)


def test_a_gauge_that_steps_by_more_than_a_tenth_of_the_spread_is_called_coarse() -> None:
    values = np.round(simulated(2, part=3.0), 5)  # hundredths of a millimetre
    study = analysed(readings(values))
    assert study.readings.step == pytest.approx(10e-6, abs=1e-12)
    assert "coarse_steps" in codes(study)
    assert "coarse_steps" not in codes(analysed(readings(np.round(simulated(2), 7))))


@pytest.mark.parametrize("tolerance", [0.0, -1e-3, math.nan, math.inf])
def test_a_tolerance_that_is_no_width_is_refused(tolerance: float) -> None:
    with pytest.raises(InputError, match="the tolerance is no width"):
        analysed(readings(simulated(0)), tolerance=tolerance)


def test_a_level_of_significance_outside_of_its_range_is_refused() -> None:
    with pytest.raises(InputError, match=r"the level of significance is none \(found 5.0\)"):
        analysed(readings(simulated(0)), alpha=5.0)


def test_a_study_of_one_person_is_none() -> None:
    with pytest.raises(ValueError, match="at least 2 parts"):
        readings(np.zeros((5, 1, 3)))
