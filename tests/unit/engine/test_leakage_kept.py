"""The leakage over a log is computed anew only where something changed on which it rests."""

from __future__ import annotations

import numpy as np
import pytest

from atleak.catalogue.controller_file import load_controller
from atleak.diagnosis import road as module
from atleak.diagnosis.examination import diagnose
from atleak.engine.projection import stated_condition


@pytest.fixture
def counted(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The logs over which leakage was computed."""
    computed: list[str] = []
    evaluate = module.evaluate_road_test

    def counting(model, road_test, assumed):
        computed.append(road_test.file)
        return evaluate(model, road_test, assumed)

    monkeypatch.setattr(module, "evaluate_road_test", counting)
    return computed


@pytest.fixture
def unit():
    return load_controller("minimal_example")


def test_a_mileage_or_a_condition_leaves_it_and_another_fluid_does_not(unit, hipol, limits, log_of, counted) -> None:
    log = log_of(
        np.arange(50.0),
        main_pressure=600e3,
        converter_pressure=300e3,
        atf_temperature=80.0,
        gear=1.0,
        engine_speed=20.0,
    )
    first = diagnose(unit, hipol, limits, road_test=log)
    warmer = stated_condition(unit, temperature=95.0)
    second = diagnose(unit, hipol, limits, road_test=log, mileage_km=120e3, condition=warmer)
    assert len(counted) == 1
    assert second.road.leakage is first.road.leakage
    assert second.road.assumed == warmer
    used = diagnose(unit, hipol, limits, road_test=log, fluid_state="used")
    assert len(counted) == 2
    assert used.road.leakage[0] > first.road.leakage[0]


def test_a_condition_that_stands_for_what_is_not_logged_counts(unit, hipol, limits, log_of, counted) -> None:
    log = log_of(np.arange(50.0), main_pressure=600e3, engine_speed=20.0)
    cold, warm = (
        diagnose(unit, hipol, limits, road_test=log, condition=stated_condition(unit, temperature=each))
        for each in (40.0, 90.0)
    )
    assert len(counted) == 2
    assert warm.road.leakage[0] > cold.road.leakage[0]


def test_findings_of_another_valve_body_are_its_own(unit, four_speed, hipol, limits, log_of) -> None:
    log = log_of(np.arange(50.0), main_pressure=100e3, atf_temperature=80.0, gear=2.0, engine_speed=40.0)
    found = [diagnose(each, hipol, limits, road_test=log).log for each in (four_speed, unit, four_speed)]
    assert (found[0].permitted is None, found[1].permitted is None) == (False, not unit.permissible)
    assert found[2].permitted == found[0].permitted
