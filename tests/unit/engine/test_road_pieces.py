"""Leakage, pressure and gears over a log that comes in pieces: the same as over the whole, wherever it is cut."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import fields, is_dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from atleak.catalogue.circuits import PermissiblePressure
from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_reading import load_controller
from atleak.catalogue.fluid import load_fluid
from atleak.catalogue.limits import Limits, load_limits
from atleak.engine.leakage import LeakageModel
from atleak.engine.profile import WORKSHOP
from atleak.engine.projection import model_unworn
from atleak.engine.road_bands import temperature_classes
from atleak.engine.road_leakage import evaluate_road_test
from atleak.engine.road_pieces import evaluate_in_pieces
from atleak.errors import RoadTestError
from atleak.intake.readings import read_readings
from atleak.large_log import LargeLog
from atleak.readings import clearances
from atleak.road_findings import findings_in_pieces, road_findings
from atleak.road_test import RoadTest
from tests.unit.drives import ALL, drive

ROOT = Path(__file__).resolve().parents[3]
CLOSE = 1e-12
LogOf = Callable[..., RoadTest]
CHANNELS = (
    ALL,
    ("engine_speed", "vehicle_speed", "gear", "main_pressure", "atf_temperature"),
    ("main_pressure", "gear"),
    ("engine_speed", "turbine_speed", "output_speed", "main_pressure", "commanded_pressure"),
)


def permitted(gears: set[int], state: str, low: float | None, high: float | None) -> PermissiblePressure:
    return PermissiblePressure(frozenset(gears), state, low, high, source="a chart")  # type: ignore[arg-type]


@cache
def model_of(name: str) -> LeakageModel:
    """A unit as measured, with a chart that sample drives pass on both sides, or as new, with circuits."""
    chart = (
        permitted({1, 2}, "idle", 510e3, 560e3),
        permitted({1, 2, 3}, "stall", 800e3, None),
        permitted({1, 2}, "driving", 850e3, 1100e3),
        permitted({3, 4}, "driving", None, 900e3),
    )
    if name == "circuits":
        controller = load_controller(ROOT / "tests" / "three_circuits.toml")
        states = clearances(None, controller)
    else:
        controller = replace(load_controller("four_speed_2023"), permissible=chart)
        states = clearances(
            read_readings(ROOT / "sample_data" / "measuring_sheet_four_speed.xlsx", controller), controller
        )
    return LeakageModel(controller, states, load_fluid("hipol_atf_iid"), WORKSHOP)


@cache
def limits() -> Limits:
    return load_limits("project_default")


def whole(model: LeakageModel, road_test: RoadTest) -> dict[str, Any]:
    """All that is told of a log at once."""
    assumed = model.controller.operating_points[0]
    road = evaluate_road_test(model, road_test, assumed)
    classes = temperature_classes(road, limits().total_share, model_unworn(model.clearances, model))
    return told(road) | {"classes": classes} | told(road_findings(model.controller, road_test, limits()))


def in_pieces(model: LeakageModel, road_test: RoadTest, piece: int) -> dict[str, Any]:
    """All that is told of it when it is cut into pieces."""
    log, controller = LargeLog.of(road_test, piece), model.controller
    found = findings_in_pieces(controller, log, limits())
    unworn = model_unworn(model.clearances, model)
    road = evaluate_in_pieces(model, log, controller.operating_points[0], found.events, limits().total_share, unworn)
    return told(road) | {"classes": road.classes} | told(found)


def told(result: Any) -> dict[str, Any]:
    """What a result says of the whole log."""
    if hasattr(result, "events"):
        names = ("events", "gears", "temperatures", "pressure", "commanded", "decisions", "slip")
        return {name: getattr(result, name) for name in names}
    names = ("gears", "section_shares", "circuit_ranges", "lower_bound", "messages", "instants")
    return {
        **{f"road {name}": getattr(result, name) for name in names},
        "samples": [each.samples for each in (result.extremes, result.start) if each is not None],
        "conditions": [result.condition_at(instant) for instant in result.instants],
    }


def numbers(value: Any) -> Iterator[Any]:
    """Every number and word in a result, in order."""
    if is_dataclass(value) and not isinstance(value, Controller):
        for field in fields(value):
            yield from numbers(getattr(value, field.name))
    elif isinstance(value, dict) or hasattr(value, "items"):
        for key, each in value.items():
            yield key
            yield from numbers(each)
    elif isinstance(value, tuple | list | frozenset | set):
        for each in sorted(value) if isinstance(value, frozenset | set) else value:
            yield from numbers(each)
    else:
        yield value


def assert_same(found: dict[str, Any], expected: dict[str, Any]) -> None:
    assert found.keys() == expected.keys()
    for name, wanted in expected.items():
        ours, theirs = list(numbers(found[name])), list(numbers(wanted))
        assert len(ours) == len(theirs), name
        for one, other in zip(ours, theirs, strict=True):
            if isinstance(other, float) and not isinstance(one, bool):
                assert one == pytest.approx(other, rel=CLOSE, abs=1e-15, nan_ok=True), name
            else:
                assert one == other, name


def compare(name: str, road_test: RoadTest, piece: int) -> dict[str, Any]:
    """What is told of the whole, which is also told of the pieces."""
    model, refused = model_of(name), ""
    try:
        expected = whole(model, road_test)
    except RoadTestError as error:
        expected, refused = {}, str(error)
    if refused:
        with pytest.raises(RoadTestError) as also:
            in_pieces(model, road_test, piece)
        assert str(also.value) == refused
    else:
        assert_same(in_pieces(model, road_test, piece), expected)
    return expected


@pytest.mark.parametrize("channels", CHANNELS, ids=" ".join)
@pytest.mark.parametrize("name", ["four speeds", "circuits"])
def test_pieces_give_what_the_whole_gives(name: str, channels: tuple[str, ...]) -> None:
    for seed in (3, 4):
        assert compare(name, drive(seed, 40.0, channels), 173)


def test_a_long_stretch_below_and_starts_of_the_engine_are_among_them() -> None:
    found = [compare("four speeds", drive(seed, 120.0), 97) for seed in (1, 2, 5)]
    pressures = [each["pressure"] for each in found]
    assert max(pressure.below for pressure in pressures) > 3.0
    assert max(pressure.above for pressure in pressures) > 3.0
    assert any(len(each["samples"]) == 2 for each in found)
    assert all(each["commanded"] is not None and each["slip"] is not None for each in found)
    assert all(len(each["classes"]) > 5 for each in found)


@pytest.mark.parametrize("pressure", [math.nan, -20e3])
def test_a_log_without_a_pressure_is_refused_in_the_same_words(pressure: float) -> None:
    road_test = drive(1, 20.0)
    channel = road_test.channels["main_pressure"]
    spoilt = replace(channel, values=np.full(len(channel.values), pressure), suspect=np.isnan(channel.values))
    assert (
        compare("four speeds", replace(road_test, channels={**road_test.channels, "main_pressure": spoilt}), 31) == {}
    )


def test_an_engine_that_turns_in_its_start_alone_has_the_extremes_of_the_start(log_of: LogOf) -> None:
    time = np.arange(0.0, 6.0, 0.1)
    speed = np.where((time >= 2.0) & (time < 4.0), 12.0, 0.0)
    road_test = log_of(time, engine_speed=speed, main_pressure=500e3, gear=1.0, atf_temperature=40.0)
    expected = compare("four speeds", road_test, 7)
    assert "start_alone" in [message.code for message in expected["road messages"]]


@settings(max_examples=4)
@given(st.integers(0, 10_000), st.integers(2, 300))
def test_a_log_may_be_cut_anywhere(seed: int, piece: int) -> None:
    compare("four speeds", drive(seed, 10.0), piece)


@pytest.mark.slow
@settings(max_examples=40)
@given(
    st.integers(0, 1_000_000), st.integers(1, 700), st.floats(1.0, 60.0), st.sampled_from(CHANNELS),
    st.sampled_from(["four speeds", "four speeds", "circuits"]), st.sampled_from([0.01, 0.06, 0.3]), st.booleans(),
)  # fmt: skip
def test_many_logs_may_be_cut_anywhere(
    seed: int, piece: int, seconds: float, channels: tuple[str, ...], name: str, step: float, breaks: bool
) -> None:
    compare(name, drive(seed, seconds, channels, step, breaks), piece)
