"""The pump's supply over engine speed against what is taken from it: it crosses where the engine says it does."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from atleak.common.wording import wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.engine.projection import project
from atleak.report.tables.pressures import pump_over_speed

EN = wording("en")


def test_supply_meets_demand_at_the_crossing_of_every_temperature(worn_clutch: Diagnosis, sample: Diagnosis) -> None:
    for diagnosis in (worn_clutch, sample):
        for projection in diagnosis.projections:
            data = pump_over_speed(diagnosis, projection, EN)
            assert np.all(np.diff(data.supply) > 0.0)
            for demand in data.demands:
                assert np.interp(demand.crossing, data.speeds, data.supply) == pytest.approx(
                    demand.flow, rel=1e-9, abs=0.0
                )
                assert data.speeds[-1] > demand.crossing


def test_at_the_crossing_the_reserve_is_one(worn_clutch: Diagnosis) -> None:
    for projection in worn_clutch.projections:
        for demand in pump_over_speed(worn_clutch, projection, EN).demands:
            at = replace(projection.condition, temperature=demand.temperature, engine_speed=demand.crossing)
            assert project(worn_clutch.model, at).reserve == pytest.approx(1.0, rel=1e-9, abs=0.0)


def test_the_conditions_own_demand_is_what_its_reserve_counts(worn_clutch: Diagnosis) -> None:
    for projection in worn_clutch.projections:
        data = pump_over_speed(worn_clutch, projection, EN)
        own = data.demand
        assert own.temperature == projection.condition.temperature
        assert own.crossing == projection.minimum_speed
        at_speed = np.interp(projection.condition.engine_speed, data.speeds, data.supply)
        assert at_speed / own.flow == pytest.approx(projection.reserve, rel=1e-9, abs=0.0)
        assert data.interval == worn_clutch.uncertainty.total(projection.condition.name).minimum_speed_interval


def test_temperatures_are_those_of_the_conditions_and_a_few_between(worn_clutch: Diagnosis) -> None:
    temperatures = [each.temperature for each in pump_over_speed(worn_clutch, worn_clutch.projection, EN).demands]
    assert temperatures == [80.0, 87.0, 93.0, 100.0]
    one = replace(worn_clutch, projections=worn_clutch.projections[:1])
    assert [each.temperature for each in pump_over_speed(one, one.projection, EN).demands] == [100.0]


def test_idle_is_marked_beside_the_condition(worn_clutch: Diagnosis) -> None:
    (idle, driving), say = worn_clutch.projections, wording("de")
    assert pump_over_speed(worn_clutch, idle, EN).marked == (("hot idle", 700.0 / 60.0),)
    assert pump_over_speed(worn_clutch, driving, say).marked == (
        (say.condition(driving.condition), 1500.0 / 60.0),
        (say.condition(idle.condition), 700.0 / 60.0),
    )
