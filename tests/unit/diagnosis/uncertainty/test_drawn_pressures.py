"""The line pressure that holds in every draw, where the line follows a circuit that it feeds, or feeds consumers."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np
import pytest

from atleak.catalogue.circuits import Consumer, Following, SetPressure
from atleak.catalogue.controller import Controller
from atleak.catalogue.fluid import Fluid
from atleak.diagnosis.uncertainty.drawn_unit import DemandShape, DrawnUnit
from atleak.engine.leakage import LeakageModel
from atleak.engine.operation import sections_held
from atleak.engine.profile import WORKSHOP
from atleak.engine.projection import project
from atleak.measurements.clearances import clearances


def test_in_every_draw_the_line_falls_as_far_as_small_steps_say(three_circuits: Controller, hipol: Fluid) -> None:
    line = SetPressure(following=Following("epc", 1.3, 30e3))
    controller = replace(three_circuits, line=line)
    point = controller.operating_points[1]
    required = point.main_pressure * np.array([0.9, 1.0, 1.02, 1.1])
    temperatures = np.array([40.0, 70.0, 90.0, 110.0])
    states = [replace(state, radial_clearance=60e-6) for state in clearances(None, controller)]
    model = LeakageModel(controller, tuple(states), hipol, WORKSHOP)
    network, viscosity = model.network(point, temperatures), model.dynamic_viscosity(temperatures)
    sections = controller.section_pressures(required, point.converter_pressure)
    balance = network.balance(sections)
    leakage = 1e-3 * network.drawn_from_pump(balance)  # the pump keeps up what is required
    unit = DrawnUnit(network, balance, leakage, sections, model.pump, viscosity)
    held, pressures = unit.held(DemandShape(model, point))
    fallen, falling = required, balance
    for _ in range(150):
        falling = network.balance(sections_held(controller, fallen, point.converter_pressure), falling)
        fallen = np.minimum(fallen, line.with_pressures(point, falling.pressures) * required / point.main_pressure)
    assert held == pytest.approx(fallen, rel=1e-9, abs=0.0)
    assert np.all(held < 0.999 * required)
    assert pressures["p_g"] == pytest.approx(held, rel=1e-12, abs=0.0)


@pytest.mark.parametrize("law", ["orifice", "constant"])
@pytest.mark.parametrize("stated_at", [None, 600e3])
def test_in_every_draw_consumers_take_what_the_pressure_lets_them(
    minimal: Controller, hipol: Fluid, law: Literal["orifice", "constant"], stated_at: float | None
) -> None:
    """As they do in each unit on its own; what is required of a draw is what an unstated pressure means there."""
    cooler = Consumer("cooler", "cooler", 24.0 / 60e3, False, "test", law, stated_at)
    controller = replace(minimal, consumers=(cooler,))
    point, temperature = controller.operating_points[0], 80.0
    states = [replace(state, radial_clearance=60e-6) for state in clearances(None, controller)]
    model = LeakageModel(controller, tuple(states), hipol, WORKSHOP.with_options(entry_loss="off"))
    required = point.main_pressure * np.array([0.9, 1.0, 1.02, 1.1])
    network, viscosity = model.network(point, temperature), model.dynamic_viscosity(temperature)
    sections = controller.section_pressures(required, point.converter_pressure)
    balance = network.balance(sections)
    unit = DrawnUnit(network, balance, network.drawn_from_pump(balance), sections, model.pump, viscosity)
    held, _ = unit.held(DemandShape(model, point))
    alone = [project(model, replace(point, main_pressure=float(each))) for each in required]
    assert held == pytest.approx([each.main_pressure_held for each in alone], rel=1e-9, abs=1e-3)
    assert unit.reserve(point) == pytest.approx([each.reserve for each in alone], rel=1e-12, abs=0.0)
    assert np.any(held < 0.99 * required)
