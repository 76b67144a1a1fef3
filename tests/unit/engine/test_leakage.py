"""The engine at one condition: against the exact annulus, and what it says of gaps and pump."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from atleak.catalogue.controller import Controller, OperatingPoint, PressureRelation
from atleak.catalogue.fluid import Fluid
from atleak.engine.leakage import LeakageModel, entry_loss_share, gap_messages
from atleak.engine.profile import PAPER, WORKSHOP
from atleak.equations import referees
from atleak.errors import DomainError
from atleak.readings import clearances


def test_mean_diameter_follows_the_exact_annulus(four_speed: Controller, hipol: Fluid) -> None:
    model = LeakageModel(four_speed, clearances(None, four_speed), hipol, WORKSHOP)
    for gap in model.gaps(four_speed.operating_points[0]):
        spool = gap.diameter - gap.effective_clearance
        exact = referees.exact_annulus_flow(
            gap.pressure_drop,
            spool,
            spool + 2.0 * gap.effective_clearance,
            gap.kinematic_viscosity * gap.density,
            gap.contact_length,
        )
        assert gap.leakage == pytest.approx(exact, rel=1e-6, abs=0.0)


def test_flow_between_sections_is_not_drawn_twice(four_speed: Controller, hipol: Fluid) -> None:
    states = clearances(None, four_speed)
    gaps = LeakageModel(four_speed, states, hipol, WORKSHOP).gaps(four_speed.operating_points[0])
    not_drawn = {str(gap.gap.low) for gap in gaps if not gap.drawn_from_pump}
    assert not_drawn == {"p_m"}
    assert all(
        gap.drawn_from_pump
        for gap in LeakageModel(four_speed, states, hipol, PAPER).gaps(four_speed.operating_points[0])
    )


def test_temperature_outside_the_fluid_is_refused(four_speed: Controller, hipol: Fluid) -> None:
    model = LeakageModel(four_speed, clearances(None, four_speed), hipol, PAPER)
    hot = replace(four_speed.operating_points[0], temperature=101.0)
    with pytest.raises(DomainError, match=r"101 °C is outside the fluid's data \(tabulated\), -40 to 100 °C"):
        model.gaps(hot)


def test_messages_of_gaps(four_speed: Controller, hipol: Fluid) -> None:
    relations = {**four_speed.relations, "p_s": PressureRelation("line", 0.01, 0.0, None)}
    controller = replace(four_speed, relations=relations)
    model = LeakageModel(controller, clearances(None, controller), hipol, PAPER)
    codes = {
        message.code: message.text
        for message in gap_messages(model.gaps(controller.operating_points[0]), controller.operating_points[0])
    }
    assert "13 land 1" in codes["reversed_pressure_drop"]
    reversed_ = [gap for gap in model.gaps(controller.operating_points[0]) if gap.pressure_drop < 0]
    assert reversed_
    assert all(gap.leakage == 0.0 for gap in reversed_)


def test_entry_loss_is_said_where_it_matters(four_speed: Controller, hot_idle: OperatingPoint, hipol: Fluid) -> None:
    wide = tuple(
        replace(state, radial_clearance=60e-6, sleeve_diameter=state.spool_diameter + 120e-6)
        for state in clearances(None, four_speed)
    )
    model = LeakageModel(four_speed, wide, hipol, PAPER)
    gaps = model.gaps(hot_idle)
    assert max(entry_loss_share(gap) for gap in gaps) > 0.02
    assert "entry_loss" in {message.code for message in gap_messages(gaps, hot_idle)}
    lossy = LeakageModel(four_speed, wide, hipol, PAPER.with_options(entry_loss="on")).gaps(hot_idle)
    for plain, less in zip(gaps, lossy, strict=True):
        assert less.leakage == pytest.approx(plain.leakage * (1.0 - entry_loss_share(plain)), rel=1e-12, abs=0.0)


def test_pump_with_slip_and_without(four_speed: Controller, hipol: Fluid) -> None:
    states = clearances(None, four_speed)
    constant = LeakageModel(four_speed, states, hipol, PAPER)
    slipping = LeakageModel(four_speed, states, hipol, WORKSHOP)
    assert constant.pump_capacity(2500 / 60, 8e5, 80.0) * 6e4 == pytest.approx(40.613, abs=5e-4)
    # Wilson: η_v = 1 − C_s Δp / (μ ω)
    viscous = slipping.dynamic_viscosity(80.0)
    efficiency = 1.0 - four_speed.pump.slip_coefficient * 8e5 / (viscous * 2.0 * np.pi * 2500 / 60)
    ideal = constant.pump_capacity(2500 / 60, 8e5, 80.0) / 0.95
    assert slipping.pump_capacity(2500 / 60, 8e5, 80.0) == pytest.approx(ideal * efficiency, rel=1e-12, abs=0.0)
    assert slipping.pump_capacity(0.01, 8e5, 80.0) == 0.0
    leakage = 5e-5
    speed = slipping.minimum_speed(leakage, 8e5, 80.0)
    assert slipping.pump_capacity(speed, 8e5, 80.0) == pytest.approx(leakage, rel=1e-12, abs=0.0)
    assert constant.pump_capacity(constant.minimum_speed(leakage, 8e5, 80.0), 8e5, 80.0) == pytest.approx(
        leakage, rel=1e-12, abs=0.0
    )
    without = replace(four_speed, pump=replace(four_speed.pump, slip_coefficient=None))
    assert not LeakageModel(without, states, hipol, WORKSHOP).uses_slip
