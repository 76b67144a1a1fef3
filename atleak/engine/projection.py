"""Project a controller to stated conditions: other temperatures and speeds, other wear."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from atleak.catalogue.circuits import Circuit, Leak, PermissiblePressure
from atleak.catalogue.controller import Controller
from atleak.catalogue.operating_point import STATED, OperatingPoint
from atleak.common.errors import InputError, Message, one_of, translates_refusals
from atleak.common.printable import brief
from atleak.common.sentences import Name, Sentence
from atleak.common.units import KPA, PERCENT, Quantity, gear_name
from atleak.engine.balance import Balance
from atleak.engine.gap_messages import gap_messages
from atleak.engine.leakage import GapLeakage, LeakageModel
from atleak.engine.network import Network
from atleak.engine.operation import SURELY_LESS, Held, Operation, consumed
from atleak.engine.restrictions import leaks_both_ways
from atleak.equations.clearance import worn_clearance
from atleak.measurements.clearances import LandClearance


@dataclass(frozen=True)
class CircuitState:
    """The pressure that a circuit holds at one condition, with the line pressure that holds there."""

    circuit: Circuit  # as the controller's file describes it
    pressure: float  # [Pa]
    set_pressure: float | None  # [Pa] of its regulator; None without one
    feed: float  # [m³/s] what it takes through its feeds
    relief: float  # [m³/s] what it relieves to the sump
    vented: bool  # not applied in this gear


@dataclass(frozen=True)
class LeakFlow:
    """The flow of a leak beside the lands (rings, check balls) at one condition, at the required line pressure."""

    leak: Leak  # as the controller's file describes it
    flow: float  # [m³/s], negative where it leaks backwards
    leaks_back: bool  # whether it can
    drawn_from_pump: bool  # counts as leakage


@brief
@dataclass(frozen=True)
class Projection:
    """Leakage and pump flow at one stated condition."""

    condition: OperatingPoint  # as stated
    pressures: dict[str, float]  # [Pa] by section
    gaps: tuple[GapLeakage, ...]  # that see a pressure drop in its gear
    leakage: float  # [m³/s] drawn from the pump, as the profile counts it
    concentric_leakage: float  # [m³/s] the same with every spool concentric
    touching_leakage: float  # [m³/s] the same with every spool touching its bore
    pump_capacity: float  # [m³/s]
    pump_supply: float  # [m³/s] before slip
    slip: float  # [m³/s]
    consumers: float  # [m³/s] of all consumers, at the required line pressure
    leaks: tuple[LeakFlow, ...]  # of this gear: the part of the leakage that no land leaks
    relieved: float  # [m³/s] by circuits to the sump at the required pressure: another such part
    minimum_speed: float  # [1/s] from which the pump covers this leakage, its own slip and its consumers
    main_pressure_held: float  # [Pa] the required pressure, or less where the pump or the line's regulator holds less
    starved: float  # [m³/s] by which consumers behind the line's regulator get less than they take
    circuits: tuple[CircuitState, ...]  # in the order of the controller's file
    permissible: PermissiblePressure | None  # of main pressure in this gear and state
    messages: tuple[Message, ...]  # what a reader must know of it

    @property
    def other_leakage(self) -> float:
        """Return the part of the leakage that no land leaks [m³/s]: rings, check balls, relieved by circuits."""
        return sum(each.flow for each in self.leaks if each.drawn_from_pump) + self.relieved

    @property
    def reserve(self) -> float:
        """Return pump supply / (leakage + slip + consumers) at the required pressure; under 1 the pressure falls."""
        demand = self.leakage + self.slip + self.consumers
        return self.pump_supply / demand if demand > 0.0 else math.inf

    @property
    def pressure_falls(self) -> bool:
        """Return whether less line pressure holds than is required."""
        return self.main_pressure_held < self.condition.main_pressure * (1.0 - SURELY_LESS)

    def circuit(self, name: str) -> CircuitState:
        """Return the state of the circuit of that id."""
        return next(each for each in self.circuits if each.circuit.id == name)

    @property
    def share(self) -> float:
        """Return leakage / pump capacity; infinite where the pump delivers nothing."""
        return self.share_of(self.leakage)

    def share_of(self, leakage: float) -> float:
        """Return a leakage [m³/s] as a share of this condition's pump capacity; zero for no leakage at all."""
        if self.pump_capacity > 0.0:
            return leakage / self.pump_capacity
        return math.inf if leakage > 0.0 else 0.0

    def gaps_of(self, key: tuple[str, int]) -> tuple[GapLeakage, ...]:
        """Return the gaps of one land."""
        return self._gaps_by_land.get(key, ())

    @cached_property
    def _gaps_by_land(self) -> dict[tuple[str, int], tuple[GapLeakage, ...]]:
        by_land: dict[tuple[str, int], tuple[GapLeakage, ...]] = {}
        for gap in self.gaps:
            by_land[gap.gap.key] = (*by_land.get(gap.gap.key, ()), gap)
        return by_land

    def leakage_of(self, key: tuple[str, int]) -> float:
        """Return the leakage through every gap of one land [m³/s], whether or not it counts as drawn from the pump."""
        return sum(gap.leakage for gap in self.gaps_of(key))

    def drawn_by(self, key: tuple[str, int]) -> float:
        """Return the part of one land's leakage that counts in the total [m³/s]."""
        return sum(gap.leakage for gap in self.gaps_of(key) if gap.drawn_from_pump)

    def share_drawn_by(self, key: tuple[str, int]) -> float:
        """Return that part as a share of the pump's flow: all lands' and that of `other_leakage` are the total's."""
        return self.share_of(self.drawn_by(key))


@translates_refusals
def project(model: LeakageModel, condition: OperatingPoint) -> Projection:
    """Compute leakage, pump flow and share at one condition.

    Returns
    -------
    Projection
        flows [m³/s], pressures [Pa].

    Raises
    ------
    DomainError
        temperature outside the fluid's data.
    """
    at, controller = Operation.of(model, condition), model.controller
    network, demanded, held = at.network, at.demanded, at.held
    where = (condition.main_pressure, condition.temperature)
    gaps = model.gaps(condition, demanded.pressures, network)
    drawn = [gap for gap in gaps if gap.drawn_from_pump]
    leaks, relieved = _leak_flows(network, demanded), float(sum(demanded.relief.values()))
    other = sum(each.flow for each in leaks if each.drawn_from_pump) + relieved
    leakage = sum(gap.leakage for gap in drawn) + other
    capacity = float(model.pump_capacity(condition.engine_speed, *where))
    required = (condition.main_pressure, condition.main_pressure)
    consumers = consumed(network, *required)
    left = capacity - leakage - consumed(network, *required, after_line=False)
    return Projection(
        condition=condition,
        pressures={name: float(value) for name, value in demanded.pressures.items()},
        gaps=gaps,
        leakage=leakage,
        concentric_leakage=sum(gap.concentric_leakage for gap in drawn) + other,
        touching_leakage=sum(gap.touching_leakage for gap in drawn) + other,
        pump_capacity=capacity,
        pump_supply=float(model.pump.per_revolution * condition.engine_speed),
        slip=float(model.pump_slip(*where)),
        consumers=consumers,
        leaks=leaks,
        relieved=relieved,
        minimum_speed=model.minimum_speed(leakage + consumers, *where),
        main_pressure_held=float(held.main_pressure),
        starved=max(consumed(network, *required, after_line=True) - max(left, 0.0), 0.0),
        circuits=tuple(_circuit_state(circuit, network, held, condition) for circuit in controller.circuits),
        permissible=controller.permissible_at(condition.gear, condition.state),
        messages=(
            *gap_messages(model.law, gaps, condition),
            *_messages(controller, condition, held, leakage / capacity if capacity > 0.0 else 0.0),
        ),
    )


def _leak_flows(network: Network, balance: Balance) -> tuple[LeakFlow, ...]:
    leaks = (each for each in network.controller.leaks if network.point.gear in each.gears)
    return tuple(
        LeakFlow(
            leak, float(network.flow(branch, balance.pressures)), leaks_both_ways(branch, network.solved), branch.counts
        )
        for leak, branch in zip(leaks, network.leaks, strict=True)
    )


def _circuit_state(circuit: Circuit, network: Network, held: Held, condition: OperatingPoint) -> CircuitState:
    balance, stated = held.balance, circuit.set_pressure
    return CircuitState(
        circuit=circuit,
        pressure=float(balance.pressures[circuit.id]),
        set_pressure=None if stated is None else float(stated.with_pressures(condition, balance.pressures)),
        feed=float(balance.feeds.get(circuit.id, 0.0)),
        relief=float(balance.relief[circuit.id]),
        vented=circuit.id in network.vented,
    )


def _messages(controller: Controller, condition: OperatingPoint, held: Held, share: float) -> Iterator[Message]:
    """Yield what does not hold at a condition: a relation of pressures, a share over 1, a balance of circuits."""
    for section, above in controller.above_main(condition.main_pressure).items():
        if above:
            text = Sentence(
                "{condition}: {section} would be above main pressure, where its relation does not hold.",
                condition=condition,
                section=section,
            )
            yield Message("warning", "pressure_relation", text)
    if share > 1.0:
        text = Sentence(
            "{condition}: the share of {share:.0f} % is a demand that the pump cannot meet, not a flow: main pressure "
            "will fall until no more leaks than the pump delivers."
        )
        if held.main_pressure < condition.main_pressure:
            text = Sentence(
                "{condition}: the share of {share:.0f} % is a demand that the pump cannot meet, not a flow: main "
                "pressure will fall until no more leaks than the pump delivers, at {held} of {required} "
                "{required.unit}."
            )
        pressures = {"held": held.main_pressure, "required": condition.main_pressure}
        shown = {name: Quantity(float(pressure) * KPA, "pressure") for name, pressure in pressures.items()}
        yield Message("warning", "demand_over_pump", text.of(condition=condition, share=share * PERCENT, **shown))
    if not np.all(held.converged):
        text = Sentence(
            "{condition}: no pressures were found at which all circuits balance; theirs are not to be relied on.",
            condition=condition,
        )
        yield Message("warning", "circuits_not_balanced", text)


def stated_condition(
    controller: Controller,
    *,
    temperature: float | None = None,
    engine_speed: float | None = None,
    gear: int | None = None,
    main_pressure: float | None = None,
    base: OperatingPoint | None = None,
) -> OperatingPoint:
    """Return an operating point, the controller's first unless given, with the given values in place of its own.

    Parameters
    ----------
    temperature
        [°C].
    engine_speed
        [1/s].
    main_pressure
        p_g that is required [Pa]; what the line is set to there unless given.

    Raises
    ------
    InputError
        a gear the controller does not have, or a speed or pressure that is not positive.
    """
    point = controller.operating_points[0] if base is None else base
    if temperature is None and engine_speed is None and gear is None and main_pressure is None:
        return point
    if gear is not None and gear not in controller.gears:
        problem = Sentence("{controller} has no such gear", controller=Name(controller.name))
        raise InputError(problem, value=gear, expected=one_of(map(str, controller.gears)))
    if engine_speed is not None and not (engine_speed > 0.0 and math.isfinite(engine_speed)):
        raise InputError(
            Sentence("engine speed not accepted"), value=engine_speed * 60.0, expected=Sentence("more than 0 rpm")
        )
    if main_pressure is not None and not (main_pressure > 0.0 and math.isfinite(main_pressure)):
        expected = Sentence("more than 0 kPa")
        raise InputError(Sentence("main pressure not accepted"), value=main_pressure * KPA, expected=expected)
    if temperature is not None and not math.isfinite(temperature):
        raise InputError(Sentence("temperature not accepted"), value=temperature, expected=Sentence("a number in °C"))
    point = replace(
        point,
        name=STATED,
        values_of=point.like,
        temperature=point.temperature if temperature is None else temperature,
        engine_speed=point.engine_speed if engine_speed is None else engine_speed,
        gear=point.gear if gear is None else gear,
        source=f"set by the user; pressures of {point.label}",
    )
    label = f"gear {gear_name(point.gear)}, {point.temperature:g} °C, {point.engine_speed * 60.0:.0f} rpm"
    if main_pressure is None:
        return controller.with_line(replace(point, label=label))
    return replace(point, label=f"{label}, {main_pressure * KPA:.0f} kPa", main_pressure=main_pressure)


@translates_refusals
def with_wear(clearances: Iterable[LandClearance], increment: float) -> tuple[LandClearance, ...]:
    """Widen every cold radial clearance: the sleeve opens, the spool keeps its diameter.

    This is how the source study models wear (W3, W4): the thermal term is added afterwards and not scaled. The form of
    a gap, its deviations from its mean, stays as it is.

    Parameters
    ----------
    increment
        as a fraction of each clearance.
    """
    return tuple(
        _with_clearance(state, worn_clearance(state.radial_clearance, increment * state.radial_clearance))
        for state in clearances
    )


def repaired(clearances: Iterable[LandClearance], lands: Iterable[tuple[str, int]]) -> tuple[LandClearance, ...]:
    """Return the same unit with some lands brought back to the clearance of new pairs, the same all around."""
    chosen = set(lands)
    return tuple(
        with_even_clearance(state, state.land.new_clearance) if state.land.key in chosen else state
        for state in clearances
    )


def model_new(states: Iterable[LandClearance], model: LeakageModel) -> LeakageModel:
    """Return the model of the same unit with every land as new pairs are, and its pump as new."""
    states = tuple(states)
    clearances = repaired(states, [state.land.key for state in states])
    return replace(model, controller=model.controller.with_new_pump, clearances=clearances)


def model_unworn(states: Iterable[LandClearance], model: LeakageModel) -> LeakageModel:
    """Return the model of the same unit with every land as wide as it may have been when new, given its reading.

    This is what growth is judged against: where only a range or a type's value is known of new pairs, a reading within
    it is no wear. Where each pair's own clearance is known, it is the unit of `model_new`.
    """
    clearances = (
        with_even_clearance(
            state, state.land.unworn(state.radial_clearance) if state.measured else state.land.new_clearance
        )
        for state in states
    )
    return replace(model, controller=model.controller.with_new_pump, clearances=tuple(clearances))


def project_beside(model: LeakageModel, projections: Iterable[Projection]) -> tuple[Projection, ...]:
    """Project another state of a unit for comparison with it as it is: its pump counts in pressures and reserve.

    Shares are those of the flow that the pump delivers now: a valve body's share does not grow by a worn pump.
    """
    return tuple(replace(project(model, now.condition), pump_capacity=now.pump_capacity) for now in projections)


def project_unworn(
    states: Iterable[LandClearance], model: LeakageModel, projections: Iterable[Projection]
) -> tuple[Projection, ...]:
    """Project the unit of `model_unworn` beside the same unit as it is."""
    return project_beside(model_unworn(states, model), projections)


@dataclass(frozen=True)
class BesideNew:
    """A unit as measured, new, and as it may have been when new, at every condition; the stated one first."""

    model: LeakageModel  # as measured
    as_new: LeakageModel
    as_unworn: LeakageModel
    states: tuple[LandClearance, ...]
    now: tuple[Projection, ...]
    new: tuple[Projection, ...]
    unworn: tuple[Projection, ...]

    @classmethod
    def of(cls, model: LeakageModel, states: tuple[LandClearance, ...], condition: OperatingPoint) -> BesideNew:
        """Compute the unit of a model with the clearances as measured, at a condition and the valve body's own."""
        others = (point for point in model.controller.operating_points if point != condition)
        now = tuple(project(model, point) for point in (condition, *others))
        new, unworn = model_new(states, model), model_unworn(states, model)
        return cls(model, new, unworn, states, now, project_beside(new, now), project_beside(unworn, now))


def _with_clearance(state: LandClearance, radial_clearance: float) -> LandClearance:
    sleeve = state.spool_diameter + 2.0 * radial_clearance
    return replace(state, radial_clearance=radial_clearance, sleeve_diameter=sleeve)


def with_even_clearance(state: LandClearance, radial_clearance: float) -> LandClearance:
    """Return a land with another clearance, the same all around: the form that was measured is gone."""
    return replace(
        _with_clearance(state, radial_clearance),
        stations=(),
        min_clearance=radial_clearance,
        max_clearance=radial_clearance,
        worst_direction=None,
        spool_ovality=None,
        sleeve_ovality=None,
        spool_taper=None,
        sleeve_taper=None,
    )
