"""The line pressure that holds in every draw, where the line follows a circuit that it feeds itself."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from atleak.catalogue.circuits import Following, SetPressure
from atleak.catalogue.controller import Controller
from atleak.catalogue.fluid import Fluid
from atleak.engine.leakage import LeakageModel
from atleak.engine.line import sections_held
from atleak.engine.profile import WORKSHOP
from atleak.readings import clearances
from atleak.uncertainty.pressures import DrawnUnit, demand_shape


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
    held, pressures = unit.held(point, demand_shape(model, point))
    fallen, falling = required, balance
    for _ in range(150):
        falling = network.balance(sections_held(controller, fallen, point.converter_pressure), falling)
        fallen = np.minimum(fallen, line.with_pressures(point, falling.pressures) * required / point.main_pressure)
    assert held == pytest.approx(fallen, rel=1e-9, abs=0.0)
    assert np.all(held < 0.999 * required)
    assert pressures["p_g"] == pytest.approx(held, rel=1e-12, abs=0.0)
