"""Formulas over a log's channels: values against hand calculation, units carried, and what is refused, in words."""

from __future__ import annotations

import numpy as np
import pytest

from atleak.analysis.formulas import formula_channel, kind_in_words
from atleak.common.errors import FormulaError
from atleak.common.wording import wording
from atleak.measurements.road_test import Channel, RoadTest, Segment
from atleak.report.tables.road_test import channel_scales, formula_scale

SIZE = 40
TIME = np.arange(SIZE) * 0.1


@pytest.fixture
def log(log_of) -> RoadTest:
    return log_of(
        TIME,
        main_pressure=700e3 + 1e3 * np.arange(SIZE),
        converter_pressure=300e3,
        engine_speed=20.0,
        atf_temperature=80.0,
        gear=np.where(np.arange(SIZE) < 20, 0.0, 2.0),
    )


def test_a_difference_of_two_pressures_is_a_pressure(log: RoadTest) -> None:
    drop = formula_channel("drop", "p_g − p_k", log)
    assert drop.values == pytest.approx(400e3 + 1e3 * np.arange(SIZE), rel=1e-12, abs=0.0)
    assert drop.dimension == (("pressure", 1),)
    assert formula_scale(drop.dimension, wording("en"))[0] == "kPa"
    assert formula_scale(drop.dimension, wording("en", "us"))[0] == "psi"


@pytest.mark.parametrize(
    ("formula", "first"),
    [
        ("p_g - 1,5 bar", 550e3),
        ("p_g - 1.5 bar", 550e3),
        ("(p_g + p_k) ÷ 2", 500e3),
        ("p_g/p_k", 7.0 / 3.0),
        ("2 × p_g − p_k × 3", 500e3),
        ("−p_g", -700e3),
        ("p_g - p_k - p_k", 100e3),
        ("main_pressure", 700e3),
        ("MAIN_PRESSURE", 700e3),
        ("n / 1200 rpm", 1.0),
        ("T − 20 °C", 60.0),
        ("T + 10 K", 90.0),
        ("p_g / 50 %", 1400e3),
        ("100 kPa + p_k", 400e3),
    ],
)
def test_signs_numbers_and_units_mean_what_they_say(log: RoadTest, formula: str, first: float) -> None:
    assert formula_channel("x", formula, log).values[0] == pytest.approx(first, rel=1e-12, abs=0.0)


@pytest.mark.parametrize(
    ("formula", "kind"),
    [
        ("p_g / n", "pressure per rotational speed"),
        ("n × p_g", "pressure times rotational speed"),
        ("derivative(p_g)", "pressure per time"),
        ("derivative(T)", "temperature difference per time"),
        ("p_g / p_k", "plain number"),
        ("gear", "plain number"),
        ("T − T", "temperature difference"),
        ("filtered(T, 1)", "temperature"),
        ("1 / derivative(p_g)", "time per pressure"),
    ],
)
def test_units_are_carried(log: RoadTest, formula: str, kind: str) -> None:
    assert kind_in_words(formula_channel("x", formula, log).dimension) == kind


def test_a_compound_unit_is_written_and_converted(log: RoadTest) -> None:
    slope = formula_channel("x", "derivative(p_g)", log)
    unit, convert = formula_scale(slope.dimension, wording("en"))
    assert unit == "kPa/s"
    assert convert(slope.values) == pytest.approx(np.full(SIZE, 10.0), rel=1e-9, abs=0.0)
    per_bar = formula_channel("x", "n / p_g", log)
    unit, convert = formula_scale(per_bar.dimension, wording("en", "metric_bar"))
    assert unit == "rpm/bar"
    assert convert(per_bar.values[0]) == pytest.approx(1200.0 / 7.0, rel=1e-12, abs=0.0)
    assert formula_scale((("pressure", 2),), wording("en"))[0] == "kPa²"
    assert formula_scale((), wording("en"))[0] == ""


def test_channels_are_read_in_the_readers_unit(log: RoadTest) -> None:
    unit, convert = channel_scales(log, wording("en", "us"))["atf_temperature"]
    assert (unit, convert(80.0)) == ("°F", pytest.approx(176.0, rel=1e-12, abs=0.0))


@pytest.mark.parametrize(
    ("formula", "at", "says"),
    [
        ("p_g + n", 5, "a rotational speed cannot be added to a pressure"),
        ("n - p_g", 3, "a pressure cannot be taken from a rotational speed"),
        ("p_g − 100", 5, "a plain number cannot be taken from a pressure; expected a number with its unit"),
        ("p_g - p_k/p_g", 5, "a plain number cannot be taken from a pressure; expected two of one kind"),
        ("T + T", 3, "two temperatures in °C cannot be added"),
        ("T × 2", 3, "a temperature in °C cannot be multiplied"),
        ("−T", 1, "cannot change its sign"),
        ("10 K − T", 6, "a temperature cannot be taken from a temperature difference"),
        ("p_q − p_k", 1, "there is no channel 'p_q'"),
        ("v × 2", 1, "this log has no vehicle speed"),
        ("time", 1, "there is no channel 'time'"),
        ("p_g −", 6, "the formula ends here; expected a channel, a number, a function or '('"),
        ("", 1, "the formula ends here"),
        ("(p_g", 5, "the '(' at character 1 is still open"),
        ("p_g)", 4, "')' does not belong here; expected +, −, ×, ÷ or the end"),
        ("p_g p_k", 5, "'p_k' does not belong here"),
        ("p_g $ 2", 5, "'$' means nothing in a formula"),
        ("p_g ** 2", 6, "'*' does not belong here"),
        ("sqrt(p_g)", 1, "there is no function 'sqrt'; expected one of filtered, mean, derivative"),
        ("filtred(p_g, 1)", 1, "did you mean 'filtered'?"),
        ("filtered(p_g)", 1, "expected filtered(channel, seconds)"),
        ("derivative(p_g, 1)", 1, "expected derivative(channel)"),
        ("filtered(p_g, n)", 15, "a time that is the same throughout"),
        ("filtered(p_g, 0)", 15, "0 s cannot be filtered over"),
        ("filtered(p_g, 2 kPa)", 15, "a time that is the same throughout"),
        ("filtered(p_g, 0.01)", 15, "0.01 s hold too few samples of this channel"),
        ("filtered(2, 1)", 10, "needs what changes over the log"),
        ("2 + 3", 1, "nothing here changes over the log"),
        ("__import__(p_g)", 1, "there is no function '__import__'"),
        ("p_g.real", 4, "'.' means nothing in a formula"),
        ("((((" * 20 + "p_g" + "))))" * 20, 41, "too many parentheses"),
        ("p_g" + " + p_g" * 60, 301, "too long"),
    ],
)
def test_a_fault_names_the_character_and_what_was_expected(log: RoadTest, formula: str, at: int, says: str) -> None:
    with pytest.raises(FormulaError) as refused:
        formula_channel("x", formula, log)
    assert str(refused.value).startswith(f"at character {at}: ")
    assert says in str(refused.value)


def test_a_decimal_comma_and_the_comma_between_arguments_are_told_apart(log: RoadTest) -> None:
    whole = [formula_channel("x", formula, log).values for formula in ("mean(p_g, 0,5)", "mean(p_g;0.5)")]
    assert whole[0] == pytest.approx(whole[1], rel=1e-12, abs=0.0)


def test_the_moving_median_takes_a_spike_of_one_sample_out_and_the_mean_spreads_it(log_of) -> None:
    pressure = np.full(SIZE, 600e3)
    pressure[20] = 900e3
    log = log_of(TIME, main_pressure=pressure)
    median = formula_channel("x", "filtered(p_g, 0.6)", log).values
    assert median[1:-1] == pytest.approx(np.full(SIZE - 2, 600e3), rel=1e-12, abs=0.0)
    assert np.isnan(median[[0, -1]]).all()  # fewer than five samples tell no median
    mean = formula_channel("x", "mean(p_g, 0.6)", log).values
    assert mean[20] == pytest.approx(600e3 + 300e3 / 7.0, rel=1e-9, abs=0.0)
    assert mean[10] == pytest.approx(600e3, rel=1e-9, abs=0.0)


def test_nothing_is_filtered_or_differentiated_over_a_break(log_of) -> None:
    pressure = np.where(np.arange(SIZE) < 20, 500e3, 800e3)
    parts = (Segment(0, 20, 0.0, 1.9), Segment(20, 20, 2.0, 1.9))
    log = log_of(TIME, main_pressure=pressure)
    broken = RoadTest(log.file, "", SIZE, 3.9, log.time, log.channels, parts)
    assert formula_channel("x", "mean(p_g, 1)", broken).values == pytest.approx(pressure, rel=1e-12, abs=0.0)
    assert formula_channel("x", "derivative(p_g)", broken).values == pytest.approx(np.zeros(SIZE), abs=1e-9)
    whole = formula_channel("x", "derivative(p_g)", RoadTest(log.file, "", SIZE, 3.9, log.time, log.channels))
    assert whole.values.max() == pytest.approx(1500e3, rel=1e-9, abs=0.0)


def test_where_it_divides_by_zero_there_is_no_value_and_that_is_counted(log: RoadTest) -> None:
    result = formula_channel("x", "p_g / gear", log)
    assert result.undefined == 20
    assert np.isnan(result.values[:20]).all()
    assert np.isfinite(result.values[20:]).all()


def test_suspect_samples_have_no_value(log: RoadTest) -> None:
    log.channels["main_pressure"].suspect[7] = True
    values = formula_channel("x", "filtered(p_g, 1) − p_k", log).values
    assert np.flatnonzero(np.isnan(values)).tolist() == [7]


def test_channels_with_stamps_of_their_own_meet_at_those_of_the_rows(log: RoadTest) -> None:
    slow = np.arange(0.0, 4.0, 0.5)
    own = Channel("converter_pressure", slow, 300e3 + 10e3 * slow, np.zeros(len(slow), bool))
    mixed = RoadTest("own.csv", "", SIZE, 3.9, log.time, {**log.channels, "converter_pressure": own})
    drop = formula_channel("x", "p_g − p_k", mixed)
    assert drop.time is mixed.time
    assert drop.values[7] == pytest.approx(707e3 - 305e3, rel=1e-12, abs=0.0)  # the sample at 0.5 s is held
    alone = formula_channel("x", "derivative(p_k)", mixed)
    assert alone.time is slow
    assert alone.values == pytest.approx(np.full(len(slow), 10e3), rel=1e-9, abs=0.0)


def test_a_formula_uses_those_above_it(log: RoadTest) -> None:
    drop = formula_channel("drop", "p_g − p_k", log)
    slope = formula_channel("slope", "derivative(drop)", log, {"drop": drop})
    assert slope.values == pytest.approx(np.full(SIZE, 10e3), rel=1e-9, abs=0.0)
    with pytest.raises(FormulaError, match="there is no channel 'drop'"):
        formula_channel("slope", "derivative(drop)", log)


def test_the_channels_there_are_are_offered(log: RoadTest) -> None:
    with pytest.raises(FormulaError, match="expected one of p_g, p_k, n, T, gear; did you mean 'p_g'"):
        formula_channel("x", "p_gg", log)
