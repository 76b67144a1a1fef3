"""The columns of a road test: a unit with circuits has their leakage and their pressures among them."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from atleak.catalogue.controller import Controller
from atleak.catalogue.fluid import Fluid
from atleak.engine.leakage import LeakageModel
from atleak.engine.profile import WORKSHOP
from atleak.engine.road_leakage import evaluate_road_test
from atleak.measurements.clearances import clearances
from atleak.measurements.road_test import RoadTest
from atleak.report.tables.road_test import road_series


def test_every_circuit_has_a_column_of_its_leakage_and_of_its_pressure(
    three_circuits: Controller, hipol: Fluid, log_of: Callable[..., RoadTest]
) -> None:
    time = np.arange(0.0, 5.0, 0.5)
    log = log_of(
        time, main_pressure=np.linspace(9e5, 5e5, len(time)), converter_pressure=3e5, atf_temperature=80.0, gear=1
    )
    model = LeakageModel(three_circuits, clearances(None, three_circuits), hipol, WORKSHOP)
    road = evaluate_road_test(model, log, three_circuits.operating_points[0])
    series = road_series(road, 100)
    for circuit in three_circuits.circuits:
        assert series.columns[f"{circuit.id}_kpa"] * 1e3 == pytest.approx(road.circuits[circuit.id], rel=1e-12, abs=0.0)
        assert series.labels[f"{circuit.id}_kpa"] == (f"{circuit.id}, computed", "pressure")
        assert f"leakage_{circuit.id}_dm3_min" in series.columns
    assert series.columns["epc_kpa"] == pytest.approx(np.full(len(time), 200.0), rel=1e-9, abs=0.0)
    assert (series.columns["clutch_c2_kpa"] == 0.0).all()
    assert (np.diff(series.columns["clutch_c1_kpa"]) < 0.0).all()
