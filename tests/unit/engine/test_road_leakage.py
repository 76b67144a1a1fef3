"""The engine over a log: what is missing is assumed and said, what cannot be used is left out and counted."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from atleak.catalogue.controller import Controller
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.operating_point import OperatingPoint
from atleak.common.errors import RoadTestError
from atleak.engine.leakage import LeakageModel
from atleak.engine.profile import WORKSHOP
from atleak.engine.road_leakage import RoadLeakage, evaluate_road_test
from atleak.measurements.clearances import clearances
from atleak.measurements.road_test import RoadTest

LogOf = Callable[..., RoadTest]
Over, Full = Callable[..., RoadLeakage], dict[str, object]
TIME = np.arange(0.0, 5.0, 0.5)
NAN = math.nan


@pytest.fixture(scope="module")
def model(four_speed: Controller, hipol: Fluid) -> LeakageModel:
    return LeakageModel(four_speed, clearances(None, four_speed), hipol, WORKSHOP)


@pytest.fixture
def assumed(four_speed: Controller) -> OperatingPoint:
    return four_speed.operating_points[0]


@pytest.fixture
def over(model: LeakageModel, assumed: OperatingPoint, log_of: LogOf) -> Over:
    """The leakage over a log of these channels, at `TIME` unless given."""
    return lambda time=TIME, **channels: evaluate_road_test(model, log_of(time, **channels), assumed)


@pytest.fixture
def full() -> Full:
    """Every channel, rising pressure and speed."""
    return {
        "main_pressure": np.linspace(500e3, 900e3, len(TIME)),
        "converter_pressure": 300e3,
        "atf_temperature": 80.0,
        "gear": 2.0,
        "engine_speed": np.linspace(15.0, 40.0, len(TIME)),
    }


def codes(road: RoadLeakage) -> list[str]:
    return [message.code for message in road.messages]


def test_a_complete_log_has_nothing_to_say(over: Over, full: Full) -> None:
    road = over(**full)
    assert codes(road) == []
    assert road.gears == (2,)
    assert road.leakage.shape == TIME.shape
    np.testing.assert_allclose(sum(road.sections.values()), road.leakage, rtol=1e-12)
    assert road.share is not None
    np.testing.assert_allclose(road.share, road.leakage / road.pump_capacity, rtol=1e-15)


@pytest.mark.parametrize(
    ("quantity", "value", "words"),
    [
        ("atf_temperature", 80.0, "80 °C"),
        ("converter_pressure", 400e3, "400 kPa"),
        ("gear", 2.0, "gear 2"),
    ],
)
def test_a_channel_the_log_does_not_hold_is_assumed_and_said(
    quantity: str,
    value: float,
    words: str,
    over: Over,
    full: Full,
) -> None:
    without = {name: channel for name, channel in full.items() if name != quantity}
    road = over(**without)
    assert codes(road) == [f"assumed_{quantity}"]
    assert road.messages[0].level == "warning"
    assert words in road.messages[0].text
    assert road.assumed.label in road.messages[0].text
    given = over(**{**full, quantity: value})
    np.testing.assert_array_equal(road.leakage, given.leakage)


def test_without_engine_speed_there_is_no_share(over: Over, full: Full) -> None:
    full.pop("engine_speed")
    road = over(**full)
    assert codes(road) == ["no_engine_speed"]
    assert road.pump_capacity is road.share is road.max_share is None
    assert road.max_leakage is not None
    assert (road.max_leakage.pump_capacity, road.max_leakage.share) == (None, None)


@pytest.mark.parametrize(("pressure", "words"), [(None, "no main pressure"), (NAN, "no usable sample of main")])
def test_without_main_pressure_there_is_no_leakage(
    pressure: float | None,
    words: str,
    over: Over,
    full: Full,
) -> None:
    full.pop("main_pressure")
    if pressure is not None:
        full["main_pressure"] = pressure
    with pytest.raises(RoadTestError, match=words) as caught:
        over(**full)
    assert caught.value.place.file == "own.csv"
    assert "p_g [kPa]" in (caught.value.expected or "")


def test_a_pressure_that_is_negative_throughout_is_refused_with_its_range(over: Over, full: Full) -> None:
    full["main_pressure"] = np.linspace(-67e3, -33e3, len(TIME))
    with pytest.raises(RoadTestError, match=r"below zero throughout this log \(-67 to -33 kPa\)"):
        over(**full)


@pytest.mark.parametrize(
    "channel", [{"gear": 9.0}, {"gear": NAN}, {"atf_temperature": 190.0}, {"atf_temperature": NAN}]
)
def test_a_log_of_which_nothing_can_be_used(channel: dict[str, float], over: Over, full: Full) -> None:
    with pytest.raises(RoadTestError, match="no sample of the log") as caught:
        over(**{**full, **channel})
    assert caught.value.expected == "gears 1, 2, 3, 4, temperatures from -20 to 150 °C"


def test_samples_that_cannot_be_used_are_counted_and_left_out(over: Over, full: Full) -> None:
    gear = np.full(len(TIME), 2.0)
    gear[:3] = (0.0, 6.0, NAN)
    temperature = np.full(len(TIME), 80.0)
    temperature[3:5] = 160.0
    pressure = np.array(full["main_pressure"])
    pressure[5] = NAN
    road = over(**{**full, "gear": gear, "atf_temperature": temperature, "main_pressure": pressure})
    assert np.isnan(road.leakage).tolist() == [True] * 6 + [False] * 4
    assert codes(road) == ["other_gear", "outside_fluid", "samples_left_out", "lower_bound"]
    other_gear, outside, left_out, _ = (message.text for message in road.messages)
    assert other_gear.startswith("2 of 10 samples")
    assert outside.startswith("2 of 10 samples")
    assert "-20 to 150 °C" in outside
    assert left_out.startswith("2 of 10 samples")
    assert road.gears == (2,)
    assert sum(share for share in road.section_shares.values() if share) == pytest.approx(1.0, rel=1e-12, abs=0.0)


def test_a_pump_at_rest_has_no_share(over: Over, full: Full) -> None:
    full["engine_speed"] = np.concatenate([np.zeros(3), np.full(len(TIME) - 3, 30.0)])
    road = over(**full)
    assert road.share is not None
    assert np.isnan(road.share).tolist() == [True] * 3 + [False] * 7
    said = {message.code: message.text for message in road.messages}["pump_delivers_nothing"]
    assert said.startswith("In 3 of 10 samples")
    full["engine_speed"] = 0.0
    standing = over(**full)
    assert standing.max_share is None
    assert standing.max_leakage is not None
    assert (standing.max_leakage.pump_capacity, standing.max_leakage.share) == (0.0, None)


def test_a_log_in_which_the_engine_never_turns_has_no_other_samples(over: Over, full: Full) -> None:
    full["engine_speed"] = 0.0
    road = over(**full)
    said = {message.code: message.text for message in road.messages}["pump_delivers_nothing"]
    assert said.endswith("no sample of this log has a share.")
    assert "other samples" not in said


def test_where_the_hottest_samples_are_left_out_the_largest_leakage_is_a_lower_bound(over: Over, full: Full) -> None:
    temperature = np.full(len(TIME), 80.0)
    temperature[4] = -25.0  # colder than the fluid's data: nothing larger is missing
    cold = over(**{**full, "atf_temperature": temperature})
    assert (cold.lower_bound, codes(cold)) == (False, ["outside_fluid"])
    temperature[7] = 151.0
    hot = over(**{**full, "atf_temperature": temperature})
    assert hot.lower_bound
    said = {message.code: message.text for message in hot.messages}["lower_bound"]
    assert said.startswith("1 of the samples left out are hotter than 150 °C")


def started(begins_running: bool) -> tuple[np.ndarray, dict[str, object]]:
    """Ten times a second: the engine stands 2 s, is cranked 1 s and runs; pressure overshoots in the first second."""
    time = np.round(np.arange(0.0, 12.0, 0.1), 9)
    speed = np.select([time < 2.0, time < 3.0], [0.0, 200.0 / 60.0], 800.0 / 60.0)
    main = np.select([time < 2.0, time < 3.0, time < 4.0], [0.0, 300e3, 900e3], 600e3)
    if begins_running:
        speed = np.full(len(time), 800.0 / 60.0)
    return time, {
        "main_pressure": main,
        "converter_pressure": 200e3,
        "atf_temperature": 80.0,
        "gear": 2.0,
        "engine_speed": speed,
    }


def test_the_first_moments_after_a_start_of_the_engine_are_given_apart(over: Over) -> None:
    time, channels = started(begins_running=False)
    road = over(time, **channels)
    assert road.start is not None
    assert road.start.samples == 41  # from 2.0 s, when it turns, to 6.0 s, three seconds after it runs
    assert 3.0 <= road.start.max_leakage.time < 4.0
    assert road.max_leakage.time > 6.0
    assert road.max_leakage.leakage < 0.8 * road.start.max_leakage.leakage
    assert road.start.max_share is not None
    assert road.max_share is not None
    assert 2.0 <= road.start.max_share.time < 3.0  # cranked: hardly any flow of the pump
    assert road.max_share.time > 6.0
    assert road.extremes.max_leakage_sustained is not None
    assert road.extremes.max_leakage_sustained.time > 6.0
    assert [code for code in codes(road) if code.startswith("start")] == ["start_apart"]


def test_a_log_that_begins_with_the_engine_running_has_no_start(over: Over) -> None:
    time, channels = started(begins_running=True)
    road = over(time, **channels)
    assert road.start is None
    assert 3.0 <= road.max_leakage.time < 4.0
    assert "start_apart" not in codes(road)


def test_a_log_that_ends_in_the_start_keeps_its_extremes_and_says_so(over: Over) -> None:
    time, channels = started(begins_running=False)
    first = time <= 5.0
    cut = {name: value[first] if isinstance(value, np.ndarray) else value for name, value in channels.items()}
    road = over(time[first], **cut)
    assert road.start is None
    assert 3.0 <= road.max_leakage.time < 4.0
    assert "start_alone" in codes(road)


def test_a_reversed_drop_is_counted_by_section(over: Over, full: Full) -> None:
    pressure = np.full(len(TIME), 800e3)
    pressure[2:6] = 60e5  # 0.1 p_g above the limit of p_s
    road = over(**{**full, "main_pressure": pressure})
    assert codes(road) == ["reversed_pressure_drop"]
    assert road.messages[0].text.startswith("In 4 of 10 samples a pressure drop of section p_s is negative")


def test_section_shares_are_of_the_volume_so_a_dense_stretch_weighs_no_more(over: Over) -> None:
    def shares(time: np.ndarray) -> dict[str, float | None]:
        pressure = np.where(time < 2.0, 500e3, 900e3)
        channels = {"converter_pressure": 300e3, "atf_temperature": 80.0, "gear": 2.0}
        return over(time, main_pressure=pressure, **channels).section_shares

    even = shares(np.arange(0.0, 4.0, 0.01))
    dense = shares(np.concatenate([np.arange(0.0, 2.0, 0.002), np.arange(2.0, 4.0, 0.01)]))
    for name, share in even.items():
        assert dense[name] == pytest.approx(share, rel=2e-3, abs=0.0)


def test_a_pause_of_the_logger_counts_as_one_step(over: Over) -> None:
    # A pause of an hour after the last sample at low pressure must not make that sample all of the volume.
    time = np.concatenate([np.arange(0.0, 1.0, 0.1), 3600.0 + np.arange(0.0, 1.0, 0.1)])
    closed_up = np.arange(20) * 0.1
    pressure = np.where(np.arange(20) < 10, 300e3, 900e3)
    channels = {"main_pressure": pressure, "converter_pressure": 300e3, "atf_temperature": 80.0, "gear": 2.0}
    paused = over(time, **channels).section_shares
    assert paused == pytest.approx(over(closed_up, **channels).section_shares, rel=1e-9, abs=0.0)


def test_a_log_gives_the_lowest_pressure_of_every_circuit_while_it_is_applied_and_the_engine_runs(
    three_circuits: Controller, hipol: Fluid, full: dict[str, object], log_of: LogOf
) -> None:
    assumed = three_circuits.operating_points[0]
    worn = tuple(replace(state, radial_clearance=40e-6) for state in clearances(None, three_circuits))
    model = LeakageModel(three_circuits, worn, hipol, WORKSHOP)
    main = np.linspace(900e3, 400e3, len(TIME))
    gear, speed = np.repeat([1.0, 2.0], len(TIME) // 2), np.full(len(TIME), 20.0)
    main[-1], speed[-1] = 0.0, 0.0  # the engine stands at last
    log = log_of(TIME, **{**full, "main_pressure": main, "gear": gear, "engine_speed": speed})
    road = evaluate_road_test(model, log, assumed)
    held = road.circuit_ranges["clutch_c1"]
    assert held.samples == len(TIME) // 2
    assert (held.sample, held.time) == (len(TIME) // 2 - 1, TIME[len(TIME) // 2 - 1])
    assert held.lowest == road.circuits["clutch_c1"][held.sample] < road.circuits["clutch_c1"][0] < main[0]
    assert held.mean == pytest.approx(np.mean(road.circuits["clutch_c1"][: len(TIME) // 2]), rel=1e-12, abs=0.0)
    assert road.circuit_ranges["clutch_c2"].sample == len(TIME) - 2
    assert (road.circuits["clutch_c2"][gear == 1.0] == 0.0).all()
    assert road.circuit_ranges["epc"].samples == len(TIME) - 1
    np.testing.assert_allclose(sum(road.sections.values()), road.leakage, rtol=1e-12)
    assert sum(share for share in road.section_shares.values() if share) == pytest.approx(1.0, rel=1e-12, abs=0.0)
    only_first = log_of(TIME, **{**full, "gear": 1.0})
    assert "clutch_c2" not in evaluate_road_test(model, only_first, assumed).circuit_ranges


def test_set_pressures_over_a_log_are_those_of_the_assumed_point(
    three_circuits: Controller, hipol: Fluid, full: dict[str, object], log_of: LogOf
) -> None:
    model = LeakageModel(three_circuits, clearances(None, three_circuits), hipol, WORKSHOP)
    for point, kilopascals in zip(three_circuits.operating_points, (200.0, 450.0), strict=True):
        road = evaluate_road_test(model, log_of(TIME, **full), point)
        assert road.circuits["epc"] / 1e3 == pytest.approx(np.full(len(TIME), kilopascals), rel=1e-9, abs=0.0)


def test_a_log_of_one_sample(model: LeakageModel, assumed: OperatingPoint, log_of: LogOf) -> None:
    log = log_of([7.0], main_pressure=800e3, converter_pressure=400e3, atf_temperature=80.0, gear=2.0, engine_speed=25)
    model = replace(model, profile=WORKSHOP.with_options(entry_loss="on"))  # auto leaves it out where it is small
    road = evaluate_road_test(model, log, assumed)
    at_once = model.gaps(assumed)
    expected = math.fsum(gap.leakage for gap in at_once if gap.drawn_from_pump)
    assert road.leakage[0] == pytest.approx(expected, rel=1e-12, abs=0.0)
    assert road.max_leakage == road.min_leakage == road.max_share
    assert sum(share for share in road.section_shares.values() if share) == pytest.approx(1.0, rel=1e-12, abs=0.0)


def test_control_pressure_above_main_pressure_is_said(over: Over, full: Full) -> None:
    # below 234.6 kPa the spring alone gives more control pressure than there is main pressure
    pressure = np.full(len(TIME), 800e3)
    pressure[:4] = (-500.0, 0.0, 234e3, 235e3)
    pressure[4] = NAN
    road = over(**{**full, "main_pressure": pressure})
    said = [message.text for message in road.messages if message.code == "pressure_relation"]
    assert len(said) == 1
    assert said[0].startswith("In 3 of 10 samples p_s would be above main pressure")


def test_without_pressure_no_gap_of_that_pressure_leaks(over: Over, full: Full) -> None:
    still = {**full, "main_pressure": 0.0, "converter_pressure": 0.0}
    road = over(**still)
    for section in ("p_g", "p_m", "p_k"):
        assert road.sections[section].tolist() == [0.0] * len(TIME)
