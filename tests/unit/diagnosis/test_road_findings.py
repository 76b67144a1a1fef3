"""What a log says by itself: gears, temperatures, events, and the verdict on its main pressure with its certainty."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import controllers, load_controller
from atleak.catalogue.limits import LimitOrigin, Limits, RuleKind
from atleak.common.units import KPA, RPM
from atleak.common.verdicts import Verdict
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.diagnosis.next_checks import next_checks
from atleak.diagnosis.road import RoadFindings, road_findings
from atleak.diagnosis.uncertainty import DEFAULTS
from atleak.measurements.road_test import RoadTest
from atleak.readers.logs import read_road_test

LogOf = Callable[..., RoadTest]


@pytest.fixture
def at_pressure(four_speed: Controller, limits: Limits, log_of: LogOf) -> Callable[..., RoadFindings]:
    """Twenty seconds of driving in second gear at a main pressure [kPa], where 412 are the least."""

    def build(kpa: float, **more: object) -> RoadFindings:
        time = np.arange(400) * 0.05
        log = log_of(time, engine_speed=2000.0 / RPM, gear=2.0, main_pressure=kpa / KPA, **more)
        return road_findings(four_speed, log, limits)

    return build


AtPressure = Callable[..., RoadFindings]
COURSES: dict[str, Callable[[np.ndarray], np.ndarray]] = {  # of main pressure beside the least, over 20 to 110 °C
    "hot slump": lambda celsius: 1.1 - 0.6 * (celsius - 20.0) / 90.0,
    "low from cold": lambda celsius: np.full(len(celsius), 0.7),
    "rising": lambda celsius: 0.7 + 0.4 * (celsius - 20.0) / 90.0,
    "as it should be": lambda celsius: np.full(len(celsius), 1.1),
}


@pytest.mark.parametrize(
    ("course", "first"),
    [("hot slump", "falls_with_heat"), ("low from cold", "low_everywhere"), ("rising", "low_everywhere"),
     ("as it should be", None)],
)  # fmt: skip
@pytest.mark.parametrize("unit", ["aisin_aw55_50sn", "chrysler_41te", "ford_4r70w", "four_speed_2023"])
def test_an_idle_from_cold_to_hot_tells_what_comes_first(
    unit: str, course: str, first: str | None, limits: Limits, log_of: LogOf
) -> None:
    valve_body = load_controller(unit)
    least = {gear: each.low for each in valve_body.permissible for gear in each.gears if each.state == "idle"}
    gears = sorted(gear for gear, low in least.items() if low and gear != 0)[:3]
    celsius = np.linspace(20.0, 110.0, 3600)
    gear = np.array(gears * 12).repeat(100)  # each for five seconds at a time
    pressure = COURSES[course](celsius) * np.array([least[each] for each in gear.tolist()])
    time = np.arange(3600) * 0.05
    speeds = {"engine_speed": 700.0 / RPM, "vehicle_speed": 0.0}
    more = {"gear": gear.astype(float), "main_pressure": pressure}
    warm, unknown = (
        next_checks(road_findings(valve_body, log_of(time, **speeds, **more, **temperature), limits), None)
        for temperature in ({"atf_temperature": celsius}, {})
    )
    assert [check.code for check in warm][:1] == ([first] if first else [])
    slumps = course == "hot slump"
    assert [check.code for check in unknown][:1] == (["low_everywhere"] if slumps else [first or "log_temperature"])
    if slumps:
        said = {name: warm[0].values[name].value for name in ("cold", "cold_at", "hot", "hot_at")}
        assert said["cold_at"] < 30.0 < 100.0 < said["hot_at"]
        assert said["hot"] == pytest.approx(0.5 * said["cold"], rel=0.06, abs=0.0)


@pytest.mark.parametrize(
    ("kpa", "verdict"),
    [
        (500.0, Verdict.OK),
        (412.0, Verdict.OK),
        (411.0, Verdict.WATCH),
        (372.0, Verdict.WATCH),
        (370.0, Verdict.REPLACE),
        (310.0, Verdict.REPLACE),
        (308.0, Verdict.CRITICAL),
        (0.0, Verdict.CRITICAL),
    ],
)
def test_the_verdict_follows_how_far_pressure_is_below_what_is_permitted(
    at_pressure: AtPressure, kpa: float, verdict: Verdict
) -> None:
    (rule,) = at_pressure(kpa).rules
    assert (rule.kind, rule.verdict) == (RuleKind.PERMISSIBLE_PRESSURE, verdict)
    assert rule.value == pytest.approx(1.0 - kpa / 412.0, abs=1e-12)
    assert rule.origin is LimitOrigin.PROJECT
    assert rule.where == "gear 2, driving, at 0.0 s of the road test"


@pytest.mark.parametrize(
    ("kpa", "probability", "decision"),
    [
        (500.0, 0.0, "pass"),
        (415.0, 0.36, "conditional_pass"),
        (409.0, 0.64, "conditional_fail"),
        (395.0, 0.984, "fail"),
    ],
)
def test_the_decision_follows_the_uncertainty_of_the_gauge(
    at_pressure: AtPressure, kpa: float, probability: float, decision: str
) -> None:
    decided = at_pressure(kpa).decided(RuleKind.PERMISSIBLE_PRESSURE)
    # the true pressure is normally distributed about what the gauge shows, by 2 % of it
    assert decided.probability_over_limit == pytest.approx(probability, abs=0.005)
    assert decided.decision == decision
    assert decided.standard_uncertainty == pytest.approx(DEFAULTS.main_pressure * kpa / 412.0, rel=1e-12, abs=0.0)


def test_a_gauge_below_zero_is_judged_as_any_other(at_pressure: Callable[..., RoadFindings]) -> None:
    decided = at_pressure(-20.0).decided(RuleKind.PERMISSIBLE_PRESSURE)
    assert decided is not None
    assert decided.rule.verdict == Verdict.CRITICAL
    assert decided.standard_uncertainty > 0.0


def test_a_gauge_without_doubt_decides(four_speed: Controller, limits: Limits, log_of: LogOf) -> None:
    log = log_of(np.arange(100) * 0.05, engine_speed=30.0, gear=2.0, main_pressure=411e3)
    sure = road_findings(four_speed, log, limits, replace(DEFAULTS, main_pressure=0.0))
    decided = sure.decided(RuleKind.PERMISSIBLE_PRESSURE)
    assert (decided.decision, decided.probability_over_limit) == ("fail", 1.0)


@pytest.mark.parametrize(("kpa", "verdict"), [(-69.0, Verdict.WATCH), (68.0, Verdict.OK), (69.0, Verdict.WATCH)])
def test_69_kpa_off_what_was_commanded_is_watch_either_way(
    at_pressure: AtPressure, kpa: float, verdict: Verdict
) -> None:
    found = at_pressure(600.0 + kpa, commanded_pressure=600e3)
    decided = found.decided(RuleKind.COMMANDED_PRESSURE)
    assert decided.rule.verdict == verdict
    assert decided.rule.value * KPA == pytest.approx(abs(kpa), abs=1e-9)
    assert decided.rule.origin is LimitOrigin.PUBLISHED
    assert decided.standard_uncertainty * KPA == pytest.approx(0.02 * (600.0 + kpa), abs=1e-9)


def test_limits_that_say_nothing_of_pressures_judge_none(four_speed: Controller, limits: Limits, log_of: LogOf) -> None:
    log = log_of(np.arange(100) * 0.05, engine_speed=30.0, gear=2.0, main_pressure=1e3, commanded_pressure=6e5)
    silent = replace(limits, below_permissible=None, commanded_pressure=None)
    assert road_findings(four_speed, log, silent).rules == ()


def test_gears_and_temperatures_are_findings(four_speed: Controller, limits: Limits, log_of: LogOf) -> None:
    time = np.arange(200) * 0.1
    gear = np.repeat([1.0, 3.0], 100)
    log = log_of(time, engine_speed=30.0, gear=gear, atf_temperature=np.linspace(60.0, 90.0, 200))
    found = road_findings(four_speed, log, limits)
    assert found.gears == pytest.approx({1: 9.9, 3: 9.8}, abs=1e-9)  # without the shift between
    assert found.temperatures == (60.0, 90.0)
    assert found.not_judged == "no_main_pressure"
    bare = road_findings(four_speed, log_of(time, vehicle_speed=3.0), limits)
    assert (bare.gears, bare.temperatures) == ({}, None)


# --- the shipped units


@pytest.fixture(scope="module")
def scaled(sample_log: Path) -> Callable[[float], RoadTest]:
    """The sample log with its main pressure multiplied."""

    def build(factor: float) -> RoadTest:
        log = read_road_test(sample_log)
        channel = log.channels["main_pressure"]
        changed = replace(channel, values=channel.values * factor)
        return replace(log, channels={**log.channels, "main_pressure": changed}, _held={})

    return build


def test_the_sample_log_is_within_what_its_unit_permits(
    four_speed: Controller, limits: Limits, scaled: Callable[[float], RoadTest]
) -> None:
    found = road_findings(four_speed, scaled(1.0), limits)
    (decided,) = found.decisions
    assert (decided.rule.verdict, decided.decision) == (Verdict.OK, "pass")
    assert (found.permitted.below, found.permitted.above) == (0.0, 0.0)


def test_at_two_fifths_of_its_pressure_it_is_critical_whatever_was_measured(
    sample: Diagnosis, scaled: Callable[[float], RoadTest]
) -> None:
    def of(factor: float, **more: object) -> Diagnosis:
        inputs = (sample.controller, sample.fluid, sample.limits)
        return diagnose(*inputs, road_test=scaled(factor), profile=sample.profile, **more)

    low = of(0.4, readings=sample.readings)
    assert (low.verdict, low.decided_by.kind) == (Verdict.CRITICAL, RuleKind.PERMISSIBLE_PRESSURE)
    assert low.decision == "fail"
    assert of(1.0, readings=sample.readings).verdict == sample.verdict
    alone = of(0.4)
    assert (alone.verdict, alone.decided_by) == (Verdict.CRITICAL, alone.log_rules[0])
    assert of(1.0).verdict == Verdict.OK
    assert of(1.0).decided_by is None


@pytest.mark.parametrize("controller", controllers(), ids=lambda controller: controller.id)
def test_a_log_at_the_limits_of_any_shipped_unit_is_fine_and_below_them_is_not(
    controller: Controller, limits: Limits, log_of: LogOf
) -> None:
    if not controller.permissible:
        log = log_of(np.arange(100) * 0.05, engine_speed=30.0, gear=1.0, main_pressure=1e5)
        assert road_findings(controller, log, limits).not_judged == "not_permitted"
        return
    speeds = {"idle": 800.0 / RPM, "driving": 2000.0 / RPM, "stall": 2000.0 / RPM}
    for permitted in controller.permissible:
        for gear in permitted.gears:
            if permitted.low is None or (permitted.state == "stall" and gear == 0):
                continue
            standing = {"vehicle_speed": 0.0} if permitted.state == "stall" else {}
            channels = {"engine_speed": speeds[permitted.state], "gear": float(gear), **standing}
            for factor, verdict in ((1.0, Verdict.OK), (0.95, Verdict.WATCH), (0.7, Verdict.CRITICAL)):
                log = log_of(np.arange(100) * 0.05, main_pressure=factor * permitted.low, **channels)
                found = road_findings(controller, log, limits)
                assert found.rules[0].verdict == verdict, (permitted, gear)
                assert found.permitted.lowest.state == permitted.state
