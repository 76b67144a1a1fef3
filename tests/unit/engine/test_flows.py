"""The flow from pump to sump: as much comes to every place as goes, and it adds up to what the engine counts."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

import pytest

from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.entries import catalogue_files
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.limits import Limits
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.engine.flows import FlowKind, FlowPlace, Flows, flows_at
from atleak.engine.profile import PAPER
from atleak.engine.projection import Projection, project
from atleak.measurements.readings import Readings
from tests.unit.conftest import first_of, with_clearances

Build = Callable[..., Readings]
LINE = FlowPlace(FlowKind.SECTION, "p_g")
SOURCES = {FlowKind.PUMP, FlowKind.BEYOND}
ENDS = {FlowKind.SLIP, FlowKind.CONSUMER, FlowKind.LEFT, FlowKind.ELSEWHERE, FlowKind.SUMP}


def into(flows: Flows, place: FlowPlace) -> float:
    return sum(each.flow for each in flows.flows if each.target == place)


def out_of(flows: Flows, place: FlowPlace) -> float:
    return sum(each.flow for each in flows.flows if each.source == place)


def places(flows: Flows) -> set[FlowPlace]:
    return {place for each in flows.flows for place in (each.source, each.target)}


def conditions(diagnosis: Diagnosis) -> Iterator[tuple[Projection, Flows]]:
    for projection in diagnosis.projections:
        yield projection, flows_at(diagnosis.model, projection.condition)


@pytest.fixture(
    scope="module",
    params=first_of(dict.fromkeys(["three_circuits", "five_speed_2005", *catalogue_files("controllers")])),
)
def unit(
    request: pytest.FixtureRequest, three_circuits: Controller, hipol: Fluid, limits: Limits, readings_of: Build
) -> Diagnosis:
    """Every shipped unit and one with circuits that feed one another, each with every third land worn."""
    controller = three_circuits if request.param == "three_circuits" else load_controller(request.param)
    readings = with_clearances(controller, readings_of, {land.key: 40e-6 for land in controller.lands[::3]})
    return diagnose(controller, hipol, limits, readings=readings)


def test_as_much_comes_to_every_place_as_goes(unit: Diagnosis) -> None:
    for projection, flows in conditions(unit):
        least = 1e-8 * projection.pump_supply
        for place in places(flows):
            if place.kind not in SOURCES | ENDS:
                assert into(flows, place) == pytest.approx(out_of(flows, place), abs=least), place
        ends = sum(into(flows, place) for place in places(flows) if place.kind in ENDS)
        assert ends == pytest.approx(projection.pump_supply, rel=1e-8, abs=0.0)
        assert all(each.flow > 0.0 for each in flows.flows)


def test_what_ends_in_the_sump_is_what_is_drawn_from_the_pump(unit: Diagnosis) -> None:
    held = [each for each in conditions(unit) if not each[0].pressure_falls]  # else less is drawn than demanded
    assert len(held) >= 0.5 * len(unit.projections)
    for projection, flows in held:
        assert into(flows, FlowPlace(FlowKind.SUMP)) == pytest.approx(projection.leakage, rel=1e-7, abs=0.0)
        assert into(flows, FlowPlace(FlowKind.SLIP)) == pytest.approx(projection.slip, rel=1e-7, abs=0.0)
        consumed = sum(into(flows, place) for place in places(flows) if place.kind is FlowKind.CONSUMER)
        assert consumed == pytest.approx(projection.consumers, rel=1e-9, abs=0.0)
        for land in unit.lands:
            through = sum(into(flows, place) for place in places(flows) if (place.name, place.land) == land.key)
            assert through == pytest.approx(
                abs(projection.leakage_of(land.key)), rel=1e-6, abs=1e-8 * projection.leakage
            )


def test_circuits_take_through_their_feeds_what_they_are_said_to_take(unit: Diagnosis) -> None:
    for projection, flows in conditions(unit):
        for state in projection.circuits:
            place = FlowPlace(FlowKind.SECTION, state.circuit.id)
            fed = sum(
                each.flow for each in flows.flows if each.target == place and each.source.kind is FlowKind.SECTION
            )
            back = sum(
                each.flow for each in flows.flows if each.source == place and each.target.kind is FlowKind.SECTION
            )
            fed_others = sum(
                feed.source == state.circuit.id for other in projection.circuits for feed in other.circuit.feeds
            )
            if not fed_others and not state.vented:
                assert fed - back == pytest.approx(state.feed, rel=1e-6, abs=1e-8 * projection.pump_supply)
            assert flows.pressures[state.circuit.id] == pytest.approx(state.pressure, rel=1e-9, abs=1e-6)


def test_consumers_behind_the_line_starve_before_the_line_falls(
    three_circuits: Controller, hipol: Fluid, limits: Limits
) -> None:
    diagnosis = diagnose(three_circuits, hipol, limits)
    idle = diagnosis.hot_idle
    assert idle is not None
    for speed, cooler_starves, lubrication_starves in ((11.0, False, False), (2.5, True, False), (0.2, True, True)):
        projection = project(diagnosis.model, replace(idle.condition, engine_speed=speed))
        flows = flows_at(diagnosis.model, projection.condition)
        cooler, lubrication = (into(flows, FlowPlace(FlowKind.CONSUMER, name)) for name in ("cooler", "lubrication"))
        assert (cooler < 3.0 / 60e3 * 0.999) is cooler_starves
        assert (lubrication < 1.0 / 60e3 * 0.999) is lubrication_starves
        assert FlowPlace(FlowKind.BEYOND) not in places(flows)


def test_a_demand_that_no_pump_meets_is_named_where_pressures_are_given(
    four_speed: Controller, hipol: Fluid, limits: Limits, readings_of: Build
) -> None:
    readings = with_clearances(four_speed, readings_of, {land.key: 200e-6 for land in four_speed.lands})
    diagnosis = diagnose(four_speed, hipol, limits, readings=readings, profile=PAPER)
    projection = diagnosis.hot_idle
    assert projection is not None
    assert projection.leakage > projection.pump_capacity
    flows = flows_at(diagnosis.model, projection.condition)
    beyond = out_of(flows, FlowPlace(FlowKind.BEYOND))
    assert beyond == pytest.approx(projection.leakage - projection.pump_capacity, rel=1e-9, abs=0.0)
    assert into(flows, LINE) == pytest.approx(out_of(flows, LINE), rel=1e-9, abs=0.0)
