"""What to check next after a road test: read from where main pressure is low, what was commanded, what is missing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import pytest

from atleak.catalogue.controller_tables import State
from atleak.common.translations import languages
from atleak.common.wording import wording
from atleak.diagnosis.next_checks import next_checks
from atleak.diagnosis.road import RoadFindings
from atleak.engine.road_pressure import (
    AtTemperature,
    CommandedPressure,
    Departure,
    NotJudged,
    PlaceFinding,
    RoadPressure,
)
from atleak.measurements.events import AccelerationTest, Event
from atleak.measurements.road_test import RoadTest

LIMIT = 69e3
Place = tuple[int, State, bool]


def place(gear: int, state: State, low: bool, above: float = 0.0) -> PlaceFinding:
    fraction = 0.2 if low else -0.2
    worst = Departure(1.0, 4.0, 2.0, gear, state, 4e5 * (1.0 - fraction), 4e5, fraction, "a chart")
    return PlaceFinding(gear, state, 10.0, 3.0 if low else 0.0, above, worst)


def pressure(*places: Place) -> RoadPressure:
    every = tuple(place(*each) for each in places)
    lowest = max((each.worst for each in every if each.worst), key=lambda worst: worst.fraction)
    return RoadPressure(every, lowest, None)


def commanded(kpa: float) -> CommandedPressure:
    return CommandedPressure(kpa * 1e3, 2.0, 5e5 + kpa * 1e3, 5e5, 1.0, 4.0, 20.0)


def findings(
    judged: RoadPressure | NotJudged,
    against: CommandedPressure | None = None,
    events: Sequence[Event] = (),
    temperatures: tuple[float, float] | None = (75.0, 85.0),
) -> RoadFindings:
    return RoadFindings(RoadTest("a.csv", "", 0, 0.0, None, {}), tuple(events), {}, temperatures, judged, against, ())  # type: ignore[arg-type]


def codes(found: RoadFindings, limit: float | None = LIMIT) -> list[str]:
    return [check.code for check in next_checks(found, limit)]


@pytest.mark.parametrize(
    ("places", "first", "source"),
    [
        ([(1, "idle", True), (1, "driving", True), (2, "driving", True)], "low_everywhere", "project"),
        ([(2, "driving", True)], "low_where_judged", "project"),
        ([(1, "idle", True), (1, "driving", False), (2, "driving", False)], "low_at_idle_only", "practice"),
        ([(1, "driving", False), (3, "driving", True), (4, "driving", False)], "low_in_one_gear", "practice"),
        ([(1, "idle", False), (1, "driving", True), (2, "driving", True)], "low_under_load", "project"),
        ([(1, "driving", False), (3, "driving", True), (4, "driving", True)], "low_in_some", "project"),
    ],
)
def test_where_pressure_is_low_says_what_comes_first(places: list[Place], first: str, source: str) -> None:
    checks = next_checks(findings(pressure(*places)), LIMIT)
    assert (checks[0].code, checks[0].source) == (first, source)
    assert [check.code for check in checks[1:]] == ["then_measure", "log_commanded"]


def over_temperature(gear: int, state: State, *held: tuple[float, float]) -> PlaceFinding:
    """A place at so many °C and kPa, where 400 kPa are the least."""
    found = tuple(AtTemperature(celsius, kpa * 1e3, 10.0, 12.0) for celsius, kpa in held)
    least = min(each.pressure for each in found)
    worst = Departure(1.0, 4.0, 2.0, gear, state, least, 4e5, 1.0 - least / 4e5, "a chart")
    return PlaceFinding(gear, state, 30.0, 10.0 if least < 4e5 else 0.0, 0.0, worst, found)


def over_temperatures(*places: PlaceFinding, against: CommandedPressure | None = None) -> RoadFindings:
    ends = [each.temperature for place in places for each in place.by_temperature]
    return findings(RoadPressure(places, places[0].worst, None), against, temperatures=(min(ends), max(ends)))


FINE = over_temperature(2, "idle", (35.0, 420.0), (111.0, 410.0))
SLUMP = over_temperature(1, "idle", (35.0, 420.0), (75.0, 380.0), (111.0, 180.0))


@pytest.mark.parametrize(
    ("places", "expected"),
    [
        ([SLUMP], ["falls_with_heat"]),
        ([SLUMP, over_temperature(2, "driving", (40.0, 500.0), (108.0, 390.0))], ["falls_with_heat"]),
        ([SLUMP, FINE], ["falls_with_heat", "low_in_one_gear"]),
        # in second gear the fluid was not seen hot: nothing tells that the first alone is low
        ([SLUMP, over_temperature(2, "idle", (35.0, 420.0))], ["falls_with_heat"]),
        ([SLUMP, over_temperature(2, "idle", (35.0, 300.0), (111.0, 290.0))], ["falls_with_heat", "low_everywhere"]),
        ([over_temperature(1, "idle", (35.0, 300.0), (111.0, 290.0))], ["low_where_judged", "then_measure"]),
        ([over_temperature(1, "idle", (35.0, 300.0), (111.0, 180.0))], ["low_where_judged", "then_measure"]),
        ([over_temperature(1, "idle", (35.0, 300.0), (111.0, 420.0))], ["low_where_judged", "then_measure"]),
        ([over_temperature(1, "idle", (90.0, 300.0))], ["low_where_judged", "compare_cold", "then_measure"]),
        # no fall to speak of, and too few degrees
        ([over_temperature(1, "idle", (35.0, 402.0), (111.0, 397.0))], ["low_where_judged", "then_measure"]),
        ([over_temperature(1, "idle", (40.0, 420.0), (55.0, 380.0))], ["low_where_judged", "then_measure"]),
    ],
)
def test_pressure_that_falls_with_the_temperature_is_told_first(
    places: list[PlaceFinding], expected: list[str]
) -> None:
    assert codes(over_temperatures(*places)) == [*expected, "log_commanded"]


def test_the_fall_is_told_with_its_numbers() -> None:
    check = next_checks(over_temperatures(FINE, SLUMP), LIMIT)[0]
    said = wording("en", "us")("checks.falls_with_heat", **check.values)
    assert said.startswith("Main pressure falls with the fluid's temperature: 61 psi at 95 °F and 26 psi at 232 °F")
    assert "58 psi are the least" in said


def test_a_pressure_that_falls_as_it_was_commanded_shows_no_leak() -> None:
    found = over_temperatures(SLUMP, against=commanded(-20.0))
    assert codes(found) == ["low_where_judged", "then_measure", "low_as_commanded"]
    assert codes(over_temperatures(SLUMP, against=commanded(-200.0))) == ["falls_with_heat", "below_commanded"]


def test_without_a_temperature_a_low_pressure_asks_for_it() -> None:
    assert codes(findings(pressure((1, "idle", True)), temperatures=None))[-1] == "log_temperature_low"


def test_the_gears_that_are_low_are_named() -> None:
    one = next_checks(findings(pressure((1, "driving", False), (3, "driving", True))), LIMIT)[0]
    assert dict(one.values) == {"gear": "3"}
    some = next_checks(findings(pressure((1, "driving", False), (4, "driving", True), (3, "driving", True))), LIMIT)[0]
    assert dict(some.values) == {"gears": "3, 4"}


@pytest.mark.parametrize(
    ("kpa", "low", "code"),
    [
        (-69.0, False, "below_commanded"),
        (-90.0, True, "below_commanded"),
        (80.0, False, "above_commanded"),
        (-40.0, True, "low_as_commanded"),
        (40.0, False, None),
    ],
)
def test_actual_beside_commanded_tells_a_fault_of_the_command_from_one_of_the_pressure(
    kpa: float, low: bool, code: str | None
) -> None:
    found = findings(pressure((1, "idle", low), (2, "driving", low)), commanded(kpa))
    assert (code in codes(found)) == (code is not None)
    assert "log_commanded" not in codes(found)
    told = {"below_commanded", "above_commanded", "low_as_commanded"} & set(codes(found))
    assert told == ({code} if code else set())
    assert not told & set(codes(found, limit=None))  # limits that say nothing of commanded pressure


def test_nothing_is_asked_for_where_all_is_well() -> None:
    assert codes(findings(pressure((1, "idle", False), (2, "driving", False)))) == []


@pytest.mark.parametrize(
    "why", ["no_main_pressure", "not_measured", "not_permitted", "no_engine_speed", "no_gear", "never_there"]
)
def test_what_was_not_judged_says_what_to_gauge_or_to_log(why: NotJudged) -> None:
    assert codes(findings(why)) == [f"{why}_next"]


def test_nobody_is_asked_to_gauge_what_was_gauged() -> None:
    for why in ("no_main_pressure", "not_measured"):
        assert next_checks(findings(why), LIMIT, gauged=True) == ()
    assert len(next_checks(findings("no_gear"), LIMIT, gauged=True)) == 1


def test_a_cold_log_and_one_without_temperature_are_told() -> None:
    fine = pressure((1, "idle", False))
    assert codes(findings(fine, temperatures=(20.0, 49.0))) == ["warm_up"]
    assert codes(findings(fine, temperatures=(20.0, 50.0))) == []
    assert codes(findings(fine, temperatures=None)) == ["log_temperature"]


def test_a_test_is_driven_again_only_where_none_was_driven_as_it_is_meant_to_be() -> None:
    good = AccelerationTest((1, 2), (), 30.0, 2.0, 41.7, None)
    fast = replace(good, highest_speed=45.0, fault="too_fast")
    events = [Event("minimum_acceleration", 0.0, 9.0, test=each) for each in (fast, good)]
    fine = pressure((1, "idle", False))
    assert codes(findings(fine, events=events[:1])) == ["repeat_test"]
    assert codes(findings(fine, events=events)) == []


def test_above_what_is_permitted_is_told() -> None:
    high = RoadPressure((place(1, "idle", False, above=2.0),), place(1, "idle", False).worst, None)
    assert codes(findings(high)) == ["above_permitted"]


@pytest.mark.parametrize("language", languages())
def test_every_check_has_its_words_in_every_language(language: str) -> None:
    say = wording(language)
    cases = [
        findings(pressure((1, "idle", True), (1, "driving", True)), commanded(-100.0), temperatures=(10.0, 20.0)),
        findings(pressure((1, "driving", False), (3, "driving", True))),
        findings(pressure((1, "driving", False), (3, "driving", True), (4, "driving", True)), commanded(-20.0)),
        findings("no_main_pressure", temperatures=None),
        findings(pressure((1, "idle", True)), temperatures=None),
        over_temperatures(SLUMP),
        over_temperatures(over_temperature(1, "idle", (90.0, 300.0))),
    ]
    for case in cases:
        for check in next_checks(case, LIMIT):
            said = say(f"checks.{check.code}", **check.values)
            assert "{" not in said
            assert say(f"check_sources.{check.source}")
