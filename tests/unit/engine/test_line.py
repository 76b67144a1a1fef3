"""The line pressure that holds: closed forms, the pump's balance by scipy, and what starves or falls with it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import brentq

from atleak.catalogue.circuits import Consumer, Following, SetPressure
from atleak.catalogue.controller import Controller, OperatingPoint
from atleak.catalogue.fluid import Fluid
from atleak.engine.leakage import LeakageModel
from atleak.engine.line import Held, hold, sections_held
from atleak.engine.profile import PAPER, WORKSHOP, Profile
from atleak.engine.projection import project
from atleak.engine.repaired import with_new
from atleak.readings import LandClearance, clearances

LOSSLESS = WORKSHOP.with_options(entry_loss="off")
widths = st.floats(10e-6, 300e-6)
points = st.integers(0, 1)


def worn(controller: Controller, width: float) -> tuple[LandClearance, ...]:
    """Every land at the same radial clearance."""
    return tuple(
        replace(state, radial_clearance=width, sleeve_diameter=state.spool_diameter + 2.0 * width)
        for state in clearances(None, controller)
    )


def unit(controller: Controller, fluid: Fluid, width: float, profile: Profile = WORKSHOP) -> LeakageModel:
    return LeakageModel(controller, worn(controller, width), fluid, profile)


def held_at(model: LeakageModel, point: OperatingPoint) -> Held:
    return hold(model.network(point), point, model.pump, model.dynamic_viscosity(point.temperature))


def taking(controller: Controller, before: float, after: float) -> Controller:
    """The controller with these consumers [dm³/min] before and behind the line's regulator."""
    consumers = tuple(
        Consumer(name, name, flow / 60e3, after_line, "test")
        for name, flow, after_line in (("before", before, False), ("after", after, True))
    )
    return replace(controller, consumers=consumers)


def following(controller: Controller, ratio: float, offset: float) -> Controller:
    return replace(controller, line=SetPressure(following=Following("epc", ratio, offset)))


def lacking(model: LeakageModel, point: OperatingPoint, main: float) -> float:
    """What the pump lacks at a line pressure [m³/s], consumers behind the line's regulator left out."""
    network = model.network(point)
    balance = network.balance(sections_held(model.controller, main, point.converter_pressure))
    taken = sum(each.at(point) for each in model.controller.consumers if not each.after_line)
    return network.drawn_from_pump(balance) + taken - model.pump_capacity(point.engine_speed, main, point.temperature)


# --- the pump


@pytest.mark.parametrize("width", [100e-6, 150e-6, 250e-6])
@pytest.mark.parametrize("consumers", [0.0, 2.0])
def test_where_every_gap_leads_from_the_line_to_the_sump_a_closed_form_gives_the_pressure(
    minimal: Controller, hipol: Fluid, width: float, consumers: float
) -> None:
    """Leakage and slip are both in proportion to the pressure: p (G + S) = V n − consumers."""
    pump = replace(minimal.pump, slip_coefficient=5e-8)
    model = unit(taking(replace(minimal, pump=pump), consumers, 9.0), hipol, width, LOSSLESS)
    point = replace(minimal.operating_points[0], engine_speed=10.0)
    required = point.main_pressure
    leaking = project(model, point).leakage + float(model.pump_slip(required, point.temperature))
    supplied = pump.displacement * 10.0 - consumers / 60e3
    held = held_at(model, point)
    assert held.main_pressure == pytest.approx(min(required, required * supplied / leaking), rel=1e-9, abs=0.0)
    assert held.falls == (supplied < leaking)
    assert held.converged


@given(widths, points, st.floats(0.0, 12.0))
def test_the_line_holds_what_is_required_or_what_the_pump_keeps_up(
    three_circuits: Controller, hipol: Fluid, width: float, number: int, consumers: float
) -> None:
    controller = taking(three_circuits, consumers, 3.0)
    model, point = unit(controller, hipol, width), controller.operating_points[number]
    held, required = held_at(model, point), point.main_pressure
    if lacking(model, point, required) <= 0.0:
        expected = required
    elif lacking(model, point, 0.0) >= 0.0:
        expected = 0.0
    else:
        expected = brentq(lambda main: lacking(model, point, main), 0.0, required, xtol=1e-6, rtol=1e-14)
    assert held.main_pressure == pytest.approx(expected, rel=1e-9, abs=1e-5)
    assert held.converged


@given(widths, points, st.floats(0.0, 15.0))
def test_a_reserve_of_one_or_more_means_that_the_pressure_holds(
    three_circuits: Controller, hipol: Fluid, width: float, number: int, consumers: float
) -> None:
    controller = taking(three_circuits, consumers, 0.0)
    projection = project(unit(controller, hipol, width), controller.operating_points[number])
    assert (projection.reserve >= 1.0) == (not projection.pressure_falls)
    assert (projection.main_pressure_held == projection.condition.main_pressure) == (projection.reserve >= 1.0)


@given(widths, points, st.floats(0.01, 15.0))
def test_consumers_behind_the_line_starve_before_the_pressure_falls(
    three_circuits: Controller, hipol: Fluid, width: float, number: int, consumers: float
) -> None:
    point = three_circuits.operating_points[number]
    without, behind = (
        project(unit(taking(three_circuits, 0.5, after), hipol, width), point) for after in (0.0, consumers)
    )
    assert behind.main_pressure_held == without.main_pressure_held
    left = max(without.pump_capacity - without.leakage - 0.5 / 60e3, 0.0)
    assert behind.starved == pytest.approx(max(consumers / 60e3 - left, 0.0), rel=0.0, abs=1e-15)
    assert (behind.starved > 1e-15) == (behind.reserve < 1.0)


@given(widths, points, st.floats(0.1, 10.0))
def test_consumers_before_the_line_only_lower_it(
    three_circuits: Controller, hipol: Fluid, width: float, number: int, consumers: float
) -> None:
    point = three_circuits.operating_points[number]
    more, less = (
        held_at(unit(taking(three_circuits, flow, 0.0), hipol, width), point).main_pressure
        for flow in (consumers, 0.5 * consumers)
    )
    assert more <= less * (1.0 + 1e-9)


@given(widths, points)
def test_no_section_is_above_the_line_that_supplies_it(
    three_circuits: Controller, hipol: Fluid, width: float, number: int
) -> None:
    held = held_at(unit(three_circuits, hipol, width), three_circuits.operating_points[number])
    pressures = held.balance.pressures
    assert pressures["p_g"] == pytest.approx(held.main_pressure, rel=1e-12, abs=0.0)
    assert max(pressures.values()) <= held.main_pressure * (1.0 + 1e-12)


def test_the_line_holds_what_is_required_where_nothing_is_balanced(three_circuits: Controller, hipol: Fluid) -> None:
    for profile in (PAPER, WORKSHOP.with_options(circuits="off")):
        held = held_at(unit(three_circuits, hipol, 300e-6, profile), three_circuits.operating_points[0])
        assert (held.main_pressure, held.required) == (500e3, 500e3)


# --- a line that follows a circuit


def by_small_steps(model: LeakageModel, point: OperatingPoint, start: float) -> float:
    """Let the line fall to its set pressure again and again, from above."""
    network, line = model.network(point), model.controller.line
    assert line is not None
    main = start
    for _ in range(3000):
        sections = sections_held(model.controller, main, point.converter_pressure)
        lower = min(main, float(line.with_pressures(point, network.balance(sections).pressures)))
        if main - lower <= 1e-10 * main:
            break
        main = lower
    return main


@pytest.mark.parametrize("width_um", [13.0, 60.0, 80.0, pytest.param(150.0, marks=pytest.mark.slow)])
@pytest.mark.parametrize(("ratio", "offset_kpa"), [(2.0, 100.0), (1.3, 30.0), (1.5, 0.0)])
@pytest.mark.parametrize("number", [0, 1])
def test_a_line_that_follows_a_worn_circuit_falls_with_it_from_above(
    three_circuits: Controller, hipol: Fluid, width_um: float, ratio: float, offset_kpa: float, number: int
) -> None:
    controller = following(three_circuits, ratio, offset_kpa * 1e3)
    model, point = unit(controller, hipol, width_um * 1e-6), controller.operating_points[number]
    free = replace(model, controller=replace(controller, line=None))
    start = float(held_at(free, point).main_pressure)
    held = held_at(model, point)
    fallen = by_small_steps(model, point, start)
    if fallen < 1e-3 * point.main_pressure:  # a feed that is laminar at last: it goes down to nothing, however slowly
        assert held.main_pressure <= max(fallen, 1e-3)
    else:
        assert held.main_pressure == pytest.approx(fallen, rel=1e-7, abs=0.0)
    assert held.converged
    epc = held.balance.pressures["epc"]
    assert held.main_pressure == pytest.approx(min(start, ratio * epc + offset_kpa * 1e3), rel=1e-9, abs=1e-3)


def test_a_line_that_follows_a_worn_circuit_holds_less_than_one_that_does_not(
    three_circuits: Controller, hipol: Fluid
) -> None:
    controller = following(three_circuits, 1.5, 50e3)
    point = controller.with_line(controller.operating_points[1])
    assert point.main_pressure == pytest.approx(1.5 * 450e3 + 50e3, rel=1e-12, abs=0.0)
    new, old = (held_at(unit(controller, hipol, width), point).main_pressure for width in (13e-6, 80e-6))
    assert new == pytest.approx(point.main_pressure, rel=1e-12, abs=0.0)
    assert old < 0.8 * new


# --- several at once


@pytest.mark.parametrize("width_um", [60.0, 110.0, 200.0])
@pytest.mark.parametrize("line", [None, (1.5, 0.0)])
@pytest.mark.parametrize("number", [0, 1])
def test_lands_chosen_to_be_new_give_what_each_unit_gives_on_its_own(
    three_circuits: Controller, hipol: Fluid, width_um: float, line: tuple[float, float] | None, number: int
) -> None:
    controller = three_circuits if line is None else following(three_circuits, *line)
    point = controller.operating_points[number]
    model, new = unit(controller, hipol, width_um * 1e-6), unit(controller, hipol, 13e-6)
    keys = [land.key for land in controller.lands]
    choices = [set(), set(keys), {keys[0]}, {("4", 1)}, {("2", 1), ("3", 1)}]
    held = with_new(model, new, point, choices)
    assert held.leakage.shape == held.pressures["p_g"].shape == (len(choices),)
    for at, lands in enumerate(choices):
        states = tuple(
            then if then.land.key in lands else now
            for now, then in zip(worn(controller, width_um * 1e-6), worn(controller, 13e-6), strict=True)
        )
        alone = project(replace(model, clearances=states), point)
        assert held.leakage[at] == pytest.approx(alone.leakage, rel=1e-8, abs=0.0)
        assert held.pressures["p_g"][at] == pytest.approx(alone.main_pressure_held, rel=1e-9, abs=1e-3)
        for circuit in alone.circuits:
            assert held.pressures[circuit.circuit.id][at] == pytest.approx(circuit.pressure, rel=1e-8, abs=1e-2)


def test_a_new_land_never_lowers_the_line(three_circuits: Controller, hipol: Fluid) -> None:
    model, new, point = (
        unit(three_circuits, hipol, 150e-6),
        unit(three_circuits, hipol, 13e-6),
        three_circuits.operating_points[0],
    )
    keys = [land.key for land in three_circuits.lands]
    held = with_new(model, new, point, [set(), *({key} for key in keys), set(keys)]).pressures["p_g"]
    assert np.all(held[1:] >= held[0] * (1.0 - 1e-9))
    assert held[0] < 0.9 * point.main_pressure
    assert held[-1] == pytest.approx(point.main_pressure, rel=1e-12, abs=0.0)
