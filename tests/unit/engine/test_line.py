"""The line pressure that holds: closed forms, the pump's balance by scipy, and what starves or falls with it."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, Literal, get_args

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import brentq

from atleak.catalogue.circuits import Consumer, Following, SetPressure
from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.operating_point import OperatingPoint
from atleak.engine.flows import FlowKind, FlowPlace, flows_at
from atleak.engine.leakage import LeakageModel
from atleak.engine.network import Network
from atleak.engine.operation import Held, Operation, held_pressure, sections_held, with_new
from atleak.engine.profile import PAPER, WORKSHOP, Profile
from atleak.engine.projection import project
from atleak.engine.restrictions import GapBranch
from atleak.measurements.clearances import LandClearance, clearances
from tests.unit.conftest import first_of
from tests.unit.engine.test_flows import ENDS, into

LOSSLESS = WORKSHOP.with_options(entry_loss="off")
widths = st.floats(10e-6, 300e-6)
Law = Literal["orifice", "constant"]
laws = st.sampled_from(get_args(Law))
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
    return held_pressure(model.network(point), point, model.pump, model.dynamic_viscosity(point.temperature))


def taking(
    controller: Controller, before: float, after: float, law: Law = "orifice", pressure: float | None = None
) -> Controller:
    """The controller with these consumers [dm³/min] before and behind the line's regulator."""
    first = Consumer("before", "before", before / 60e3, False, "test", law, pressure)
    return replace(controller, consumers=(first, Consumer("after", "after", after / 60e3, True, "test")))


def following(controller: Controller, ratio: float, offset: float) -> Controller:
    return replace(controller, line=SetPressure(following=Following("epc", ratio, offset)))


def lacking(model: LeakageModel, point: OperatingPoint, main: float) -> float:
    """What the pump lacks at a line pressure [m³/s], consumers behind the line's regulator left out."""
    network = model.network(point)
    balance = network.balance(sections_held(model.controller, main, point.converter_pressure))
    taken = 0.0
    for each in model.controller.consumers:
        if not each.after_line:
            opened = math.sqrt(main / (each.pressure or point.main_pressure)) if each.law == "orifice" else 1.0
            taken += each.at(point) * opened
    return network.drawn_from_pump(balance) + taken - model.pump_capacity(point.engine_speed, main, point.temperature)


# --- the pump


@pytest.mark.parametrize("width", [100e-6, 150e-6, 250e-6])
@pytest.mark.parametrize("consumers", [0.0, 2.0])
@pytest.mark.parametrize(("law", "pressure"), [("orifice", None), ("orifice", 300e3), ("constant", None)])
def test_where_every_gap_leads_from_the_line_to_the_sump_a_closed_form_gives_the_pressure(
    minimal: Controller, hipol: Fluid, width: float, consumers: float, law: Law, pressure: float | None
) -> None:
    """Leakage and slip are in proportion to the pressure: p (G + S) + Q = V n, Q constant or with the root of p."""
    pump = replace(minimal.pump, slip_coefficient=5e-8)
    model = unit(taking(replace(minimal, pump=pump), consumers, 9.0, law, pressure), hipol, width, LOSSLESS)
    point = replace(minimal.operating_points[0], engine_speed=10.0)
    required, supplied, taken = point.main_pressure, pump.displacement * 10.0, consumers / 60e3
    leaking = (project(model, point).leakage + float(model.pump_slip(required, point.temperature))) / required
    if law == "constant":
        balanced = (supplied - taken) / leaking
    else:
        per_root = taken / math.sqrt(pressure or required)
        balanced = (2.0 * supplied / (per_root + math.sqrt(per_root**2 + 4.0 * leaking * supplied))) ** 2
    held = held_at(model, point)
    assert held.main_pressure == pytest.approx(min(required, balanced), rel=1e-9, abs=0.0)
    assert held.falls == (balanced < required)
    assert held.converged


@given(widths, points, st.floats(0.0, 12.0), laws, st.none() | st.floats(100e3, 900e3))
def test_the_line_holds_what_is_required_or_what_the_pump_keeps_up(
    three_circuits: Controller,
    hipol: Fluid,
    width: float,
    number: int,
    consumers: float,
    law: Law,
    pressure: float | None,
) -> None:
    controller = taking(three_circuits, consumers, 3.0, law, pressure)
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


@given(widths, points, st.floats(0.0, 15.0), laws, st.none() | st.floats(100e3, 900e3))
def test_a_reserve_of_one_or_more_means_that_the_pressure_holds(
    three_circuits: Controller,
    hipol: Fluid,
    width: float,
    number: int,
    consumers: float,
    law: Law,
    pressure: float | None,
) -> None:
    controller = taking(three_circuits, consumers, 0.0, law, pressure)
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


@given(widths, points, st.floats(0.1, 60.0), st.floats(1e-6, 0.5))
def test_the_line_sags_by_no_more_than_twice_what_consumers_take_more(
    three_circuits: Controller, hipol: Fluid, width: float, number: int, consumers: float, more: float
) -> None:
    """At a pressure (1 + more)² times lower they take as before, no more leaks and the pump gives no less."""
    point = three_circuits.operating_points[number]
    before, after = (
        held_at(unit(taking(three_circuits, flow, 0.0), hipol, width), point).main_pressure
        for flow in (consumers, consumers * (1.0 + more))
    )
    assert before * (1.0 + more) ** -2 * (1.0 - 1e-9) <= after <= before * (1.0 + 1e-9)
    assert after > 0.0


def test_a_consumer_that_takes_one_percent_too_much_does_not_empty_the_line(minimal: Controller, hipol: Fluid) -> None:
    (idle,) = (point for point in minimal.operating_points if point.name == "hot_idle")
    flows = np.linspace(11.48, 11.60, 13)

    def held(law: Law) -> list[float]:
        models = (unit(taking(minimal, flow, 0.0, law), hipol, 18e-6) for flow in flows)
        return [held_at(model, idle).main_pressure for model in models]

    sags, falls = held("orifice"), held("constant")
    assert sags[0] == falls[0] == idle.main_pressure
    assert np.all(np.diff(sags) <= 0.0)
    assert sags[-1] > 0.98 * idle.main_pressure
    assert falls[-1] == 0.0


@pytest.mark.parametrize("name", first_of(["five_speed_2005", "chrysler_41te", "gm_4l60e"]))
def test_shipped_units_with_half_the_pump_sag_and_balance(name: str, hipol: Fluid) -> None:
    shipped = load_controller(name)
    pump = replace(shipped.pump, displacement=0.5 * shipped.pump.displacement)
    consumers = tuple(replace(each, after_line=False) for each in shipped.consumers)
    controller = replace(shipped, pump=pump, consumers=consumers, line=None)  # by nothing but the pump
    constant = replace(controller, consumers=tuple(replace(each, law="constant") for each in consumers))
    sagged = 0
    for point in controller.operating_points:
        model, steady = (unit(each, hipol, 40e-6) for each in (controller, constant))
        held, lower = held_at(model, point), held_at(steady, point)
        assert held.falls == lower.falls
        assert (held.main_pressure > lower.main_pressure) == held.falls
        flows = flows_at(model, point)
        ends = sum(each.flow for each in flows.flows if each.target.kind in ENDS)
        assert ends == pytest.approx(pump.displacement * point.engine_speed, rel=1e-9, abs=0.0)
        assert project(model, point).reserve == project(steady, point).reserve
        if held.falls:
            sagged += 1
            missing = lacking(model, point, held.main_pressure)
            assert missing == pytest.approx(0.0, abs=1e-9 * pump.displacement * point.engine_speed)
            taken = sum(into(flows, FlowPlace(FlowKind.CONSUMER, each.id)) for each in consumers)
            stated = sum(each.at(point) for each in consumers)
            opened = math.sqrt(held.main_pressure / point.main_pressure)
            assert taken == pytest.approx(stated * opened, rel=1e-9, abs=0.0)
    assert sagged


def test_sets_of_draws_hold_what_each_holds_on_its_own(three_circuits: Controller, hipol: Fluid) -> None:
    """Of which some fall and some do not."""
    point = three_circuits.operating_points[0]
    model = unit(three_circuits, hipol, 60e-6)
    pump, viscosity = model.pump, model.dynamic_viscosity(point.temperature)
    factors = np.random.default_rng(1).uniform(0.1, 8.0, (3, 300))

    def times(factor: Any) -> Network:
        network = model.network(point)
        gaps = ((land, land.restriction) for land in network.lands)
        lands = (land.with_restriction(GapBranch(each.conductance * factor, each.bend)) for land, each in gaps)
        return replace(network, lands=tuple(lands))

    held = held_pressure(times(factors), point, pump, viscosity)
    assert 0.1 < np.mean(held.falls) < 0.9
    assert np.all(held.converged)
    for at in [(0, 0), (0, 299), (1, 17), (2, 150), np.unravel_index(factors.argmax(), factors.shape)]:
        alone = held_pressure(times(float(factors[at])), point, pump, viscosity)
        for name, pressure in alone.balance.pressures.items():
            assert np.broadcast_to(held.balance.pressures[name], factors.shape)[at] == pytest.approx(
                pressure, rel=1e-8, abs=1e-2
            )


@given(widths, points)
def test_no_section_is_above_the_line_that_supplies_it(
    three_circuits: Controller, hipol: Fluid, width: float, number: int
) -> None:
    held = held_at(unit(three_circuits, hipol, width), three_circuits.operating_points[number])
    pressures = held.balance.pressures
    assert pressures["p_g"] == pytest.approx(held.main_pressure, rel=1e-12, abs=0.0)
    assert max(pressures.values()) <= held.main_pressure * (1.0 + 1e-12)


def test_the_line_holds_what_is_required_where_nothing_is_balanced(three_circuits: Controller, hipol: Fluid) -> None:
    controller, point = taking(three_circuits, 2.0, 0.0, "orifice", 125e3), three_circuits.operating_points[0]
    for profile in (PAPER, WORKSHOP.with_options(circuits="off")):
        model = unit(controller, hipol, 300e-6, profile)
        held = held_at(model, point)
        assert (held.main_pressure, held.required) == (500e3, 500e3)
        assert project(model, point).consumers == 2.0 / 60e3
    assert project(unit(controller, hipol, 13e-6), point).consumers == pytest.approx(4.0 / 60e3, rel=1e-12, abs=0.0)


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
@pytest.mark.parametrize(("ratio", "offset_kpa"), first_of([(2.0, 100.0), (1.5, 0.0), (1.3, 30.0)]))
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


@pytest.mark.parametrize("width_um", [13.0, 110.0])
@pytest.mark.parametrize("number", [0, 1])
def test_temperatures_at_once_give_what_each_gives_on_its_own(
    three_circuits: Controller, hipol: Fluid, width_um: float, number: int
) -> None:
    model, point = unit(three_circuits, hipol, width_um * 1e-6), three_circuits.operating_points[number]
    temperatures = np.array([40.0, 75.0, 110.0])
    at_once = Operation.of(model, point, temperatures)
    held = at_once.pressures((each.id for each in three_circuits.circuits), temperatures.shape)
    for place, temperature in enumerate(temperatures):
        alone = project(model, replace(point, temperature=float(temperature)))
        assert at_once.leakage[place] == pytest.approx(alone.leakage, rel=1e-9, abs=0.0)
        assert held["p_g"][place] == pytest.approx(alone.main_pressure_held, rel=1e-9, abs=0.0)
        for state in alone.circuits:
            assert held[state.circuit.id][place] == pytest.approx(state.pressure, rel=1e-9, abs=1e-3)


@pytest.mark.parametrize("width_um", first_of([60.0, 200.0, 110.0]))
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
