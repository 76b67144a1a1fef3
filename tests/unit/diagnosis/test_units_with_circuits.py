"""Shipped valve bodies hold their pressures when new, and a worn circuit is seen where its clutch is applied."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from itertools import chain
from pathlib import Path

import numpy as np
import pytest

from atleak.catalogue.controller import Controller, Land
from atleak.catalogue.controller_file import controllers, load_controller
from atleak.catalogue.entries import read_tables
from atleak.catalogue.fluid import Fluid, fluids, load_fluid
from atleak.catalogue.limits import Limits, RuleKind
from atleak.catalogue.operating_point import OperatingPoint
from atleak.common.verdicts import Verdict
from atleak.diagnosis.examination import diagnose
from atleak.diagnosis.road import leakage_over
from atleak.diagnosis.rules import Rule, UnitRules, unit_rules
from atleak.engine.leakage import LeakageModel
from atleak.engine.profile import PROFILES
from atleak.engine.projection import Projection, project, project_unworn
from atleak.engine.road_leakage import evaluate_road_test
from atleak.measurements.clearances import clearances
from atleak.measurements.readings import Readings
from atleak.measurements.road_test import RoadTest
from atleak.readers.sheets.measuring_sheet import read_readings

Build = Callable[..., Readings]
KPA = 1e3
UM = 1e-6
every_controller = pytest.mark.parametrize("controller", controllers(), ids=lambda controller: controller.id)


def sheet(
    controller: Controller, readings_of: Build, worn: Mapping[tuple[str, int], float], *, widest: bool = False
) -> Readings:
    """Readings of a new unit, every pair at its mean or its widest, but for the lands that are worn [µm]."""

    def clearance(land: Land) -> float:
        return worn[land.key] * UM if land.key in worn else land.widest_new if widest else land.new_clearance

    return readings_of(
        controller,
        {land.key: (land.nominal_diameter, land.nominal_diameter + 2.0 * clearance(land)) for land in controller.lands},
    )


def projections(
    controller: Controller,
    fluid: Fluid,
    readings_of: Build,
    worn: Mapping[tuple[str, int], float] | None = None,
    *,
    widest: bool = False,
) -> dict[str, Projection]:
    """A unit at every operating point, by name."""
    states = clearances(sheet(controller, readings_of, worn or {}, widest=widest), controller)
    model = LeakageModel(controller, states, fluid, PROFILES["workshop"])
    return {point.name: project(model, point) for point in points_in(controller, fluid)}


def points_in(controller: Controller, fluid: Fluid) -> list[OperatingPoint]:
    """Return the operating points at which the fluid is known."""
    low, high = fluid.span(PROFILES["workshop"].viscosity)
    return [point for point in controller.operating_points if low <= point.temperature <= high]


# --- new ones


def thinnest_and_thickest() -> list[Fluid]:
    """Of all fluids at 100 °C: whatever flows is between what flows of these two."""
    by_viscosity = sorted(fluids(), key=lambda fluid: fluid.kinematic_viscosity(100.0))
    return [by_viscosity[0], by_viscosity[-1]]


@every_controller
@pytest.mark.parametrize("widest", [False, True], ids=["mean", "widest"])
@pytest.mark.parametrize("fluid", thinnest_and_thickest(), ids=lambda fluid: fluid.id)
def test_a_new_unit_holds_its_pressures_in_every_fluid(
    controller: Controller, fluid: Fluid, widest: bool, readings_of: Build
) -> None:
    """The loss of an applied clutch without a regulator is what its sealing rings and new lands take.

    So is the loss of a circuit whose regulator is set to more than what feeds it.
    """
    for projection in projections(controller, fluid, readings_of, widest=widest).values():
        line = projection.condition.main_pressure
        assert projection.main_pressure_held == pytest.approx(line, abs=1.0)
        assert projection.reserve > 1.5
        assert projection.starved == 0.0
        assert not {message.code for message in projection.messages} & {"demand_over_pump", "circuits_not_balanced"}
        for state in projection.circuits:
            if state.vented:
                assert (state.pressure, state.feed) == (0.0, 0.0)
            elif state.set_pressure is not None and state.set_pressure < line - 30 * KPA:
                assert state.pressure == pytest.approx(state.set_pressure, abs=1.0)
            else:
                assert line - 30 * KPA < state.pressure < line


@every_controller
def test_the_operating_points_are_within_what_is_permissible(controller: Controller) -> None:
    for point in controller.operating_points:
        permissible = controller.permissible_at(point.gear, point.state)
        if controller.permissible:
            assert permissible is not None
            assert permissible.low < point.main_pressure < permissible.high


@every_controller
@pytest.mark.parametrize("widest", [False, True], ids=["mean", "widest"])
def test_no_rule_flags_a_new_unit(
    controller: Controller, widest: bool, hipol: Fluid, limits: Limits, readings_of: Build
) -> None:
    rules = judged(controller, hipol, limits, sheet(controller, readings_of, {}, widest=widest))
    of_the_unit = (*rules.totals, *rules.pressures)
    kinds = {rule.kind for rule in of_the_unit}
    assert {RuleKind.TOTAL_SHARE, RuleKind.RESERVE} <= kinds
    assert (RuleKind.CIRCUIT_LOSS in kinds) == bool(controller.circuits)
    assert (RuleKind.PERMISSIBLE_PRESSURE in kinds) == bool(controller.permissible)
    assert {rule.verdict for rule in (*of_the_unit, *chain(*rules.lands.values()))} == {Verdict.OK}


@pytest.mark.parametrize(
    "controller",
    [
        pytest.param(each, id=each.id, marks=() if each.id == "five_speed_2005" else pytest.mark.slow)
        for each in controllers()
    ],
)
def test_a_new_unit_is_diagnosed_as_ok(
    controller: Controller, hipol: Fluid, limits: Limits, readings_of: Build
) -> None:
    diagnosis = diagnose(controller, hipol, limits, readings=sheet(controller, readings_of, {}, widest=True))
    assert {rule.verdict for rule in diagnosis.unit_rules} == {Verdict.OK}
    assert {land.verdict for land in diagnosis.lands} == {Verdict.OK}
    assert (diagnosis.verdict, diagnosis.decided_by) == (Verdict.OK, None)


def judged(controller: Controller, fluid: Fluid, limits: Limits, readings: Readings) -> UnitRules:
    """All rules of a unit at its operating points, without the draws that say how sure they are."""
    states = clearances(readings, controller)
    model = LeakageModel(controller, states, fluid, PROFILES["workshop"])
    now = [project(model, point) for point in controller.operating_points]
    return unit_rules(states, now, project_unworn(states, model, now), limits)


def flagged(controller: Controller, fluid: Fluid, limits: Limits, readings: Readings) -> list[Rule]:
    """The rules of pressure that a worn unit is past."""
    return [rule for rule in judged(controller, fluid, limits, readings).pressures if rule.verdict.flagged]


# --- the five-speed with circuits


@pytest.fixture(scope="module")
def five_speed() -> Controller:
    return load_controller("five_speed_2005")


def losses(new: Mapping[str, Projection], worn: Mapping[str, Projection]) -> dict[str, dict[str, float]]:
    """The pressure [kPa] that each circuit has lost at each operating point, where it is a kilopascal or more."""
    lost: dict[str, dict[str, float]] = {}
    for name, projection in worn.items():
        for state in projection.circuits:
            loss = (new[name].circuit(state.circuit.id).pressure - state.pressure) / KPA
            if loss >= 1.0:
                lost.setdefault(state.circuit.id, {})[name] = loss
    return lost


def test_it_is_described_with_as_many_parts_as_a_valve_body_has(five_speed: Controller) -> None:
    assert len(five_speed.components) >= 12
    assert len(five_speed.lands) >= 25
    assert {gap.key for gap in five_speed.gaps} == {land.key for land in five_speed.lands}
    leaking = {gap.high.section for gap in five_speed.gaps} | {gap.low.section for gap in five_speed.gaps}
    assert {circuit.id for circuit in five_speed.circuits} <= leaking


def test_what_is_not_published_of_it_says_so(five_speed: Controller) -> None:
    named = ("Ford", "Mazda", "Sonnax", "GM")
    sources = [
        *(circuit.source for circuit in five_speed.circuits),
        *(leak.source for leak in five_speed.leaks),
        *(consumer.source for consumer in five_speed.consumers),
        *(point.source for point in five_speed.operating_points),
        *(each.source for each in five_speed.permissible),
        five_speed.line_source,
    ]
    for source in sources:
        assert "assumed" in source or any(name in source for name in named), source
    published = [land for land in five_speed.lands if "nominal_diameter_mm" not in land.representative]
    assert {land.component for land in published} == {"boost_valve"}


@pytest.mark.parametrize(
    ("worn", "circuit", "at", "loss"),
    [
        ({("manual_valve", 3): 50.0, ("forward_engagement", 1): 52.0}, "forward_clutch", "hot_idle", 130.2),
        ({("boost_valve", 3): 60.0}, "reverse_servo", "reverse_idle", 143.4),
        ({("shift_3_4", 1): 50.0, ("direct_accumulator", 1): 55.0}, "direct_clutch", "cruising_fifth", 152.3),
        ({("converter_clutch_control", 1): 70.0}, "tcc_apply", "cruising_fifth", 55.9),
    ],
    ids=["forward", "reverse", "direct", "converter clutch"],
)
def test_worn_lands_lower_the_pressure_of_their_own_circuit(
    five_speed: Controller,
    hipol: Fluid,
    readings_of: Build,
    worn: dict[tuple[str, int], float],
    circuit: str,
    at: str,
    loss: float,
) -> None:
    """The losses were computed apart from the engine: each circuit by bracketing, one after the other till all rest."""
    new, now = (projections(five_speed, hipol, readings_of, each) for each in ({}, worn))
    lost = losses(new, now)
    largest = max(lost, key=lambda each: max(lost[each].values()))
    assert largest == circuit
    assert lost[circuit][at] == pytest.approx(loss, abs=0.1)
    applied = next(each for each in five_speed.circuits if each.id == circuit).gears
    assert all(now[name].condition.gear in applied for name in lost[circuit])


def test_the_rules_name_the_worn_circuit_and_where_it_shows(
    five_speed: Controller, hipol: Fluid, limits: Limits, readings_of: Build
) -> None:
    worn = {("manual_valve", 3): 50.0, ("forward_engagement", 1): 52.0}
    rules = flagged(five_speed, hipol, limits, sheet(five_speed, readings_of, worn))
    assert {rule.circuit.id for rule in rules if rule.circuit} == {"forward_clutch"}
    assert {rule.condition.name: str(rule.verdict) for rule in rules if rule.condition} == {
        "driving_third": "watch",
        "hot_idle": "replace",
        "stall": "replace",
        "cruising_fifth": "replace",
    }


def test_a_worn_control_circuit_is_seen_as_its_own_loss_and_a_line_below_the_permissible(
    five_speed: Controller, hipol: Fluid, limits: Limits, readings_of: Build
) -> None:
    worn = {("boost_valve", 1): 60.0, ("boost_valve", 2): 60.0}
    rules = flagged(five_speed, hipol, limits, sheet(five_speed, readings_of, worn))
    at_stall = {rule.circuit.id if rule.circuit else str(rule.kind) for rule in rules if rule.condition.name == "stall"}
    assert at_stall == {"epc", "forward_clutch", "permissible_pressure"}


def test_a_worn_control_circuit_lowers_the_line_and_every_clutch_with_it(
    five_speed: Controller, hipol: Fluid, readings_of: Build
) -> None:
    worn = {("boost_valve", 1): 60.0, ("boost_valve", 2): 60.0}
    new, now = (projections(five_speed, hipol, readings_of, each)["stall"] for each in ({}, worn))
    drop = (new.circuit("epc").pressure - now.circuit("epc").pressure) / KPA
    assert drop > 100.0
    assert new.main_pressure_held - now.main_pressure_held == pytest.approx(2.5 * drop * KPA, abs=10.0)
    assert now.circuit("forward_clutch").pressure < now.main_pressure_held
    assert now.reserve > 1.5  # the pump is not to blame
    permissible = five_speed.permissible_at(1, "stall")
    assert permissible is not None
    assert now.main_pressure_held < permissible.low < new.main_pressure_held


def test_a_gap_between_two_circuits_is_no_reversed_one(
    five_speed: Controller, hipol: Fluid, readings_of: Build
) -> None:
    """The overdrive band's larger feed holds more than the direct clutch; its worn lands turn the gap between round."""
    worn = {("shift_1_2", 1): 70.0, ("overdrive_servo_valve", 1): 70.0}
    now = projections(five_speed, hipol, readings_of, worn)["cruising_fifth"]
    (between,) = [gap for gap in now.gaps if str(gap.gap.low) == "direct_clutch"]
    assert between.pressure_drop < 0.0
    assert between.leakage < 0.0
    assert "reversed_pressure_drop" not in {message.code for message in now.messages}


def test_the_sample_sheet_shows_a_forward_clutch_that_loses_its_pressure(
    five_speed: Controller, hipol: Fluid, limits: Limits, root: Path
) -> None:
    readings = read_readings(root / "sample_data" / "measuring_sheet_five_speed.xlsx", five_speed)
    rules = flagged(five_speed, hipol, limits, readings)
    assert {rule.circuit.id for rule in rules if rule.circuit} == {"forward_clutch"}
    worst = max(rules, key=lambda rule: rule.value)
    assert (worst.condition.name, worst.verdict) == ("stall", Verdict.REPLACE)
    assert worst.value > 200 * KPA


# --- the units of many makers, shipped as starting points

STARTING_POINTS = sorted({each.id for each in controllers() if "compiled" in each.source} - {"five_speed_2005"})
WHO_SAYS_SO = (
    *("Ford", "GM", "Holden", "Chrysler", "Dodge", "Jeep", "Toyota", "Nissan", "Sonnax", "TransGo", "trutechtrans.com"),
    *("Suzuki", "TransTec", "Mazda", "Land Rover", "Jaguar", "rangerovers.net"),
)
with_circuits = [each for each in controllers() if each.circuits]


def clutches(controller: Controller) -> dict[str, Land]:
    """The land through which each clutch or band loses most: those are fed without a regulator, in their own gears."""
    found: dict[str, Land] = {}
    for circuit in controller.circuits:
        if circuit.set_pressure is None and circuit.gears < set(controller.gears):
            leaking = [controller.land(*gap.key) for gap in controller.gaps if gap.high.section == circuit.id]
            found[circuit.id] = max(leaking, key=lambda land: land.nominal_diameter / land.contact_length)
    return found


@pytest.mark.parametrize("controller", with_circuits, ids=lambda controller: controller.id)
def test_a_land_worn_to_45_um_shows_as_a_loss_of_its_clutch(
    controller: Controller, limits: Limits, readings_of: Build
) -> None:
    """One land of each clutch is worn: they do not meet, as the line is held."""
    worst = clutches(controller)
    worn = {land.key: 45.0 for land in worst.values()}
    fluid = load_fluid("mobil_multi_vehicle_atf")
    rules = flagged(controller, fluid, limits, sheet(controller, readings_of, worn))
    assert {rule.kind for rule in rules} == {RuleKind.CIRCUIT_LOSS}
    lost = {rule.circuit.id for rule in rules if rule.circuit}
    assert lost <= set(worst)
    assert lost == set(worst) if controller.id in STARTING_POINTS else lost


@pytest.mark.parametrize(
    ("unit", "worn", "kind", "name", "at"),
    [
        ("ford_4r70w", ("boost_valve", 2), "circuit_loss", "epc", "stall"),
        ("ford_4r70w", ("boost_valve", 2), "permissible_pressure", None, "stall"),
        ("ford_4r70w", ("boost_valve", 3), "circuit_loss", "reverse_clutch", "reverse_stall"),
        ("ford_4r70w", ("solenoid_regulator", 2), "circuit_loss", "solenoid_feed", "reverse_idle"),
        ("ford_4r70w", ("pressure_regulator", 1), "total_share", None, "hot_idle"),
        ("gm_4l60e", ("boost_valve", 2), "circuit_loss", "torque_signal", "stall"),
        ("gm_4l60e", ("boost_valve", 3), "circuit_loss", "reverse_input", "reverse_idle"),
        ("gm_4l60e", ("actuator_feed_limit", 2), "circuit_loss", "actuator_feed", "driving_third"),
        ("gm_4l60e", ("pressure_regulator", 1), "total_share", None, "hot_idle"),
        ("chrysler_41te", ("regulator", 1), "total_share", None, "hot_idle"),
        ("chrysler_41te", ("regulator_sleeve", 2), "circuit_loss", "overdrive_clutch", "cruising_fourth"),
        ("aisin_aw55_50sn", ("primary_regulator", 1), "total_share", None, "reverse_idle"),
        ("aisin_aw55_50sn", ("boost_valve", 1), "circuit_loss", "slt", "stall"),
        ("jatco_jf506e", ("pressure_regulator", 4), "permissible_pressure", None, "stall"),
        ("jatco_jf506e", ("pressure_modifier", 2), "circuit_loss", "modifier", "reverse_stall"),
        ("zf_6hp26", ("pressure_regulator", 1), "total_share", None, "hot_idle"),
        ("zf_6hp26", ("pressure_regulator_boost", 1), "circuit_loss", "eds_5", "stall"),
        ("toyota_a340e", ("primary_regulator", 1), "total_share", None, "hot_idle"),
        ("toyota_a340e", ("primary_regulator_plunger", 1), "circuit_loss", "throttle_pressure", "reverse_stall"),
        ("ford_4f27e", ("main_regulator", 1), "total_share", None, "hot_idle"),
        ("ford_4f27e", ("boost_valve", 2), "circuit_loss", "reverse_clutch", "reverse_stall"),
        ("chrysler_a518", ("regulator", 1), "total_share", None, "reverse_idle"),
        ("chrysler_a518", ("throttle_plug", 1), "circuit_loss", "front_clutch", "reverse_stall"),
        ("nissan_re4r01a", ("pressure_regulator", 1), "total_share", None, "hot_idle"),
        ("nissan_re4r01a", ("pressure_modifier", 2), "circuit_loss", "modifier", "reverse_stall"),
        ("gm_6l80", ("pressure_regulator", 1), "total_share", None, "hot_idle"),
        ("gm_6l80", ("actuator_feed_limit", 2), "circuit_loss", "actuator_feed", "reverse_idle"),
        ("gm_4l80e", ("pressure_regulator", 1), "total_share", None, "hot_idle"),
        ("gm_4l80e", ("reverse_boost", 1), "circuit_loss", "forward_clutch", "stall"),
    ],
)
def test_a_boost_or_regulator_land_worn_to_60_um_shows(
    unit: str,
    worn: tuple[str, int],
    kind: str,
    name: str | None,
    at: str,
    limits: Limits,
    readings_of: Build,
) -> None:
    controller = load_controller(unit)
    rules = judged(
        controller, load_fluid("mobil_multi_vehicle_atf"), limits, sheet(controller, readings_of, {worn: 60.0})
    )
    seen = {
        (str(rule.kind), rule.circuit.id if rule.circuit else None, rule.condition.name)
        for rule in (*rules.pressures, *rules.totals)
        if rule.verdict.flagged
    }
    assert (kind, name, at) in seen


@pytest.mark.parametrize("unit", STARTING_POINTS)
def test_every_table_says_what_it_is_known_from_and_names_who_says_so(unit: str) -> None:
    data, _ = read_tables("controllers", unit)
    lists = ("operating_points", "permissible_pressure", "circuits", "leaks", "consumers", "repairs")
    sourced = [*data["materials"].values(), data["line"], *chain.from_iterable(data.get(name, ()) for name in lists)]
    for table in sourced:
        known = table["evidence"], table.get("set_evidence", table["evidence"])
        assert "published" not in known or any(name in table["source"] for name in WHO_SAYS_SO), table
        assert "representative" not in known or "assumed" in table["source"], table
    assert all("set_evidence" in table for table in data["circuits"] if "set_kpa" in table)
    feeds = chain.from_iterable(table.get("feeds", []) for table in data["circuits"])
    assert all("evidence" in table for table in (*feeds, *data["gaps"]))
    assert {"nominal_diameter_mm", "contact_length_mm"} <= set(data["representative_values"])
    assert data["defaults"]["published"] == ["mounting_clearance_um"]
    assert {"displacement_mm3", "volumetric_efficiency", "slip_coefficient"} <= set(data["pump"]["representative"])


def test_the_documents_say_of_each_what_is_published(root: Path) -> None:
    text = (root / "docs" / "description-workbook.md").read_text(encoding="utf-8")
    table = text.partition("| id | unit | published of it |\n")[2].partition("\n\n")[0]
    assert [line.split("`")[1] for line in table.splitlines()[1:]] == STARTING_POINTS


@pytest.mark.parametrize("unit", STARTING_POINTS)
def test_each_of_them_can_be_judged_in_reverse_at_idle_and_under_load(unit: str) -> None:
    controller = load_controller(unit)
    states = {(point.gear, str(point.state)) for point in controller.operating_points}
    assert {(1, "idle"), (-1, "idle"), (1, "stall")} <= states
    applied = {point.gear for point in controller.operating_points}
    assert all(circuit.gears & applied for circuit in controller.circuits)
    assert {gap.key for gap in controller.gaps} == {land.key for land in controller.lands}
    named = set(chain.from_iterable(complaint.conditions for complaint in controller.complaints))
    assert {"hot_idle", "reverse_idle"} <= named


def test_leakage_over_a_log_rests_on_nothing_of_the_condition_that_the_log_holds(
    five_speed: Controller, log_of: Callable[..., RoadTest]
) -> None:
    held = {"main_pressure": 900e3, "converter_pressure": 400e3, "atf_temperature": 80.0, "gear": 2.0}
    log = log_of(np.arange(0.0, 5.0, 0.1), **held, engine_speed=20.0)
    model = LeakageModel(
        five_speed, clearances(None, five_speed), load_fluid(five_speed.usual_fluid), PROFILES["workshop"]
    )
    point, *others = five_speed.operating_points
    first = leakage_over(model, log, point)
    warmer = replace(point, temperature=point.temperature + 20.0, engine_speed=50.0)
    again = leakage_over(model, log, warmer)
    assert again.leakage is first.leakage
    assert again.assumed is warmer
    anew = evaluate_road_test(model, log, warmer)
    np.testing.assert_array_equal(again.leakage, anew.leakage)
    assert again.messages == anew.messages
    assert leakage_over(model, log, others[0]).leakage is not first.leakage
