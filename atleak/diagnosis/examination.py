"""Examine a unit: readings, road test and gauge readings become a diagnosis."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

from atleak.catalogue.controller import REFERENCE_TEMPERATURE, Controller
from atleak.catalogue.fluid import Fluid, FluidState, fresh_assumed, load_fluid
from atleak.catalogue.instruments import Instruments
from atleak.catalogue.limits import Limits
from atleak.catalogue.operating_point import OperatingPoint
from atleak.catalogue.pump import NO_CLEARANCES, PumpClearances
from atleak.catalogue.repairs import Complaint
from atleak.common.errors import translates_refusals
from atleak.common.memory import kept_with
from atleak.diagnosis.diagnosis import Diagnosis, mileage_of
from atleak.diagnosis.flows import find_flows, flow_messages
from atleak.diagnosis.gauge_card import GaugeCard
from atleak.diagnosis.gauge_check import check_pressures
from atleak.diagnosis.land import diagnosed_land, diagnosed_pump
from atleak.diagnosis.messages import messages_of, sheet_messages
from atleak.diagnosis.road import diagnosed_road
from atleak.diagnosis.rules import UnitRules, unit_rules
from atleak.diagnosis.uncertainty import DEFAULTS, GUARD_FACTOR, Assumptions, UnitUncertainty, assess
from atleak.diagnosis.vacuum import repaired_messages, vacuum_findings, vacuum_messages, with_vacuum
from atleak.diagnosis.warm_up import warm_up
from atleak.diagnosis.weighed_evidence import AllEvidence, Beside
from atleak.engine.operation import pressure_losses
from atleak.engine.profile import WORKSHOP, Profile
from atleak.engine.projection import BesideNew, project
from atleak.engine.road_leakage import RoadLeakage
from atleak.engine.unit import Unit
from atleak.measurements.clearances import clearances
from atleak.measurements.flow_readings import FlowTable
from atleak.measurements.gauge_readings import NO_GAUGES, PressureTable
from atleak.measurements.readings import Readings
from atleak.measurements.road_test import RoadTest
from atleak.measurements.vacuum import VacuumTable


@translates_refusals
def diagnose(
    controller: Controller,
    fluid: Fluid | None,
    limits: Limits,
    *,
    fluid_state: FluidState | None = None,
    readings: Readings | None = None,
    road_test: RoadTest | None = None,
    pressures: PressureTable | None = None,
    vacuum: VacuumTable | None = None,
    flows: FlowTable | None = None,
    profile: Profile = WORKSHOP,
    condition: OperatingPoint | None = None,
    mileage_km: float | None = None,
    measuring_temperature_c: float | None = None,
    pump_clearances: PumpClearances = NO_CLEARANCES,
    instruments: Instruments | None = None,
    assumptions: Assumptions = DEFAULTS,
    guard_factor: float = GUARD_FACTOR,
    complaint: Complaint | None = None,
) -> Diagnosis:
    """Diagnose a unit from its readings and a road test: a verdict for every land and for the whole.

    Parameters
    ----------
    controller
        the type of valve body, from the catalogue or the workshop's own file, as fluid and limits are.
    fluid
        the fluid in the transmission; None takes that of the controller's file.
    limits
        by which the unit is judged.
    fluid_state
        whether the fluid in the transmission is fresh or used; as its data are unless given, and a message says so.
    readings
        those of the measuring sheet; without them every land is at its mounting clearance and ``not_measured``.
    road_test
        log, over which leakage is computed where it holds main pressure.
    pressures
        gauge readings of the standing vehicle.
    vacuum
        readings of a vacuum stand: a plug on one land measures it, beside or instead of its diameters.
    flows
        caught in a jug: they bound or measure what the line leaves over.
    profile
        how the engine computes.
    condition
        condition at which leakage is projected; the controller's first operating point unless given.
    mileage_km
        of the vehicle [km], as the sheet's head states it unless given.
    measuring_temperature_c
        that of gauge and parts when they were measured [°C]; as the sheet's head states it unless given, else 20 °C.
    pump_clearances
        those measured of this job's pump; else as the sheet's head states them, or as of a new pump.
    instruments
        with which the readings were taken; the catalogue's defaults unless given.
    assumptions
        what else is uncertain; the catalogue's defaults unless given.
    guard_factor
        k of the guard band k·u around every limit; 1.645 leaves a risk of 5 %.
    complaint
        one of the controller's, which leads the result; it changes no number and no verdict.

    Returns
    -------
    Diagnosis
        with its inputs.

    Raises
    ------
    CatalogueError
        no fluid is given, and the one that the controller's file names is not in the catalogue.
    DomainError
        a condition's temperature outside the fluid's data.
    InputError
        a fluid that its data describe as used, taken as fresh; a vacuum reading of a land that the valve body does not
        have, or with a stand of which nothing tells how much air it draws.
    ReadingsError
        a sleeve that is smaller than its spool only after the correction from the measuring temperature to 20 °C.
    """
    fluid = load_fluid(controller.usual_fluid) if fluid is None else fluid
    mileage = mileage_of(mileage_km, readings)
    measured_pump = pump_clearances if readings is None else pump_clearances.or_else(readings.pump)
    described, controller = controller, controller.with_measured_pump(measured_pump)
    pump_new = None
    tested = readings is not None or vacuum is not None
    if tested and controller.pump.as_new is not None and profile.pump_efficiency == "wilson":
        pump_new = diagnose(
            described,
            fluid,
            limits,
            fluid_state=fluid_state,
            readings=readings and kept_with(readings, "pump", "new", partial(replace, readings, pump=NO_CLEARANCES)),
            vacuum=vacuum,
            profile=profile,
            condition=condition,
            mileage_km=mileage,
            measuring_temperature_c=measuring_temperature_c,
            instruments=instruments,
            assumptions=assumptions,
            guard_factor=guard_factor,
        )
    if readings is not None:
        controller = readings.own_lands.applied(controller)
    condition = condition or controller.operating_points[0]
    fluid_state_assumed = fluid_state is None and fluid.state == "fresh"
    required = controller.fluid
    fluid = fluid if required is None else required.taken(fluid)
    fluid = fluid if fluid_state is None else fluid.in_state(fluid_state)
    measured_at = None if readings is None else readings.measured_at(measuring_temperature_c)
    temperature = REFERENCE_TEMPERATURE if measured_at is None else measured_at.value
    states = clearances(readings, controller, temperature_c=temperature, instruments=instruments)
    if vacuum is not None:
        states = with_vacuum(states, readings, controller, vacuum, instruments, assumptions)
    model = Unit(controller, states, fluid, profile)
    unit = BesideNew.of(model, states, condition)
    road = diagnosed_road(road_test, model, condition, limits, assumptions, guard_factor)
    measured = [state.land.key for state in states if state.measured]
    findings = () if vacuum is None else vacuum_findings(vacuum, unit, limits, assumptions, guard_factor)
    rules, uncertainty = _judged(
        unit, limits, road.leakage, pump_new, readings, vacuum, instruments, assumptions, guard_factor
    )
    better = pump_new.unit_rules if pump_new else ()
    card = GaugeCard(unit.model, unit.as_unworn, readings, instruments, assumptions)
    caught = find_flows(flows, unit.model, assumptions)
    checked = (
        None
        if pressures is None and road.log is None
        else check_pressures(
            AllEvidence(pressures or NO_GAUGES, card, Beside(road.log, caught, findings), unit.now),
            limits,
            guard_factor,
        )
    )
    messages = [
        *messages_of(unit, road, readings),
        *limits.doubts,
        *(checked.messages if checked else ()),
        *road.messages,
        *(() if flows is None else (*flows.messages, *flow_messages(caught))),
        *(required.messages(fluid) if required else ()),
        *([fresh_assumed(fluid)] if fluid_state_assumed else ()),
        *sheet_messages(readings, measured_at, uncertainty, road_test, mileage),
        *(vacuum.messages if vacuum else ()),
        *(vacuum_messages(findings, vacuum.stand, assumptions) if vacuum else ()),
        *repaired_messages(findings, shown_before=bool(pressures or road_test or caught)),
    ]
    return Diagnosis(
        readings=readings,
        measured_at=measured_at,
        controller=controller,
        fluid=fluid,
        fluid_state_assumed=fluid_state_assumed,
        limits=limits,
        profile=profile,
        mileage=mileage,
        model=model,
        as_new=unit.as_new,
        as_unworn=unit.as_unworn,
        lands=tuple(diagnosed_land(state, unit.now, unit.new, rules, mileage, uncertainty) for state in states),
        projections=unit.now,
        new_projections=unit.new,
        unworn_projections=unit.unworn,
        losses=tuple(pressure_losses(unit.model, unit.as_new, each.condition, measured) for each in unit.now),
        road=road.leakage,
        log=road.log,
        gauge_card=card,
        pressures=checked if pressures else None,
        vacuum=findings,
        logged=checked.logged if checked else (),
        flow_table=flows,
        flows=caught,
        warm_up=None
        if road_test is None
        else kept_with(road_test, "warm_up", (card, condition), lambda: warm_up(road_test, card, condition), most=1),
        uncertainty=uncertainty,
        total_rules=rules.totals,
        pressure_rules=rules.pressures,
        pump=diagnosed_pump(controller.pump, rules, better, assumptions.pump_clearance, guard_factor),
        pump_new=pump_new,
        complaint=complaint,
        messages=tuple(dict.fromkeys(messages)),
        vacuum_table=vacuum,
    )


def _judged(
    unit: BesideNew,
    limits: Limits,
    road: RoadLeakage | None,
    pump_new: Diagnosis | None,
    readings: Readings | None,
    vacuum: VacuumTable | None,
    instruments: Instruments | None,
    assumptions: Assumptions,
    guard_factor: float,
) -> tuple[UnitRules, UnitUncertainty | None]:
    """Judge every rule of a unit; with diameters or a vacuum test by what is likely, and return how sure that is."""
    rules = unit_rules(unit.states, unit.now, unit.unworn, limits, unit.model.controller.operating_points)
    if readings is None and vacuum is None:
        return rules, None
    model = unit.model
    rests_on = model, limits, instruments, assumptions
    uncertainty = assess(
        model,
        unit.states,
        unit.now,
        rules,
        readings=readings,
        instants={at: project(model, road.condition_at(at)) for at in road.instants} if road else {},
        instruments=instruments,
        assumptions=assumptions,
        guard_factor=guard_factor,
        # carried through for these readings before, where nothing but the conditions has changed since
        cache=kept_with(readings or vacuum, "spreads", rests_on, dict, most=1),
    )
    if pump_new is not None and pump_new.uncertainty is not None:  # a worn pump makes no land worn
        uncertainty = uncertainty.with_lands_of(pump_new.uncertainty)
    return uncertainty.judged(rules), uncertainty
