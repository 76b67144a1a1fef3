"""Judge a road test: what the log says by itself, whether or not the valve body was measured, and leakage over it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_tables import StandingState
from atleak.catalogue.limits import Limits, RuleKind
from atleak.catalogue.operating_point import OperatingPoint
from atleak.common.errors import Message, RoadTestError
from atleak.common.memory import kept_with
from atleak.common.printable import brief
from atleak.common.sentences import Sentence
from atleak.common.units import gear_name
from atleak.diagnosis.rules import Rule
from atleak.diagnosis.uncertainty import DEFAULTS, GUARD_FACTOR, Assumptions, RuleDecision
from atleak.diagnosis.uncertainty.decision import decide_normal
from atleak.engine.extremes import CountedSamples
from atleak.engine.leakage import LeakageModel
from atleak.engine.road_leakage import RoadLeakage, evaluate_road_test
from atleak.engine.road_pressure import (
    CommandedPressure,
    NotJudged,
    RoadPressure,
    compare_with_commanded,
    judge_pressure,
)
from atleak.measurements.events import ConverterSlip, Event, converter_slip, events
from atleak.measurements.road_test import RoadTest

NO_LEAKAGE = "no_leakage_over_log"  # code of the message why none is computed over a log
_LOGGED = ("main_pressure", "converter_pressure", "atf_temperature", "gear")  # channels from which leakage follows


@brief
@dataclass(frozen=True)
class RoadFindings:
    """What a log says by itself: its events, gears and temperatures, and its main pressure beside what it should be."""

    road_test: RoadTest
    events: tuple[Event, ...]
    gears: dict[int, float]  # gear → time in it with the engine running [s]; none where no gear is logged
    temperatures: tuple[float, float] | None  # lowest and highest of the fluid [°C]; None where not logged
    pressure: RoadPressure | NotJudged
    commanded: CommandedPressure | None
    decisions: tuple[RuleDecision, ...]  # on main pressure: beside what is permitted, beside what was commanded
    slip: ConverterSlip | None = None  # None where engine or turbine speed are not logged, or the car never drives

    @property
    def rules(self) -> tuple[Rule, ...]:
        """Return the rules that judge the log."""
        return tuple(each.rule for each in self.decisions)

    def decided(self, kind: RuleKind) -> RuleDecision | None:
        """Return the decision on one of the rules; None where the log was not judged by it."""
        return next((each for each in self.decisions if each.rule.kind is kind), None)

    @property
    def permitted(self) -> RoadPressure | None:
        """Return main pressure beside what is permitted; None where it could not be judged."""
        return self.pressure if isinstance(self.pressure, RoadPressure) else None

    @property
    def not_judged(self) -> NotJudged | None:
        """Return why main pressure could not be judged; None where it was."""
        return None if isinstance(self.pressure, RoadPressure) else self.pressure


def road_findings(
    controller: Controller,
    road_test: RoadTest,
    limits: Limits,
    assumptions: Assumptions = DEFAULTS,
    guard_factor: float = GUARD_FACTOR,
) -> RoadFindings:
    """Return what a log says by itself.

    Parameters
    ----------
    road_test
        any log: what it lacks is left out.
    assumptions, guard_factor
        how uncertain the gauge is, and the guard band of every limit.
    """
    key = (controller.gears, repr(controller.permissible))
    pressure, commanded, happened, in_gears = kept_with(
        road_test, "findings", key, lambda: _without_limits(controller, road_test)
    )
    judged = _judged(pressure, commanded, limits, assumptions.main_pressure)
    return RoadFindings(
        road_test=road_test,
        events=happened,
        gears=in_gears,
        temperatures=_span(road_test.values("atf_temperature")),
        pressure=pressure,
        commanded=commanded,
        decisions=tuple(decide_normal(rule, u, guard_factor) for rule, u in judged),
        slip=kept_with(road_test, "slip", "", lambda: converter_slip(road_test)),
    )


def _without_limits(
    controller: Controller, road_test: RoadTest
) -> tuple[RoadPressure | NotJudged, CommandedPressure | None, tuple[Event, ...], dict[int, float]]:
    """Return what follows from the log and the valve body's gears and permissible pressures alone."""
    counted = CountedSamples(road_test)
    return (
        judge_pressure(controller, road_test, counted),
        compare_with_commanded(road_test),
        events(road_test, gears=controller.gears),
        _gears(road_test, counted),
    )


def _judged(
    pressure: RoadPressure | NotJudged, commanded: CommandedPressure | None, limits: Limits, relative: float
) -> Iterator[tuple[Rule, float]]:
    """Yield every rule with the standard uncertainty of its value; ``relative`` is that of main pressure."""
    lowest = pressure.lowest if isinstance(pressure, RoadPressure) else None
    if lowest is not None and limits.below_permissible is not None:
        where = _lowest_at(lowest.gear, lowest.state, lowest.at)
        kind, steps = RuleKind.PERMISSIBLE_PRESSURE, limits.below_permissible
        yield Rule(kind, None, lowest.fraction, steps, where=where), relative * abs(lowest.pressure) / lowest.limit
    if commanded is not None and limits.commanded_pressure is not None:
        where = Sentence("at {time:.1f} s of the road test", time=commanded.at)
        kind, steps = RuleKind.COMMANDED_PRESSURE, limits.commanded_pressure
        yield Rule(kind, None, abs(commanded.difference), steps, where=where), relative * abs(commanded.actual)


def _lowest_at(gear: int, state: StandingState, time: float) -> Sentence:
    if state == "idle":
        return Sentence("gear {gear}, idle, at {time:.1f} s of the road test", gear=gear_name(gear), time=time)
    if state == "stall":
        return Sentence("gear {gear}, stall, at {time:.1f} s of the road test", gear=gear_name(gear), time=time)
    return Sentence("gear {gear}, driving, at {time:.1f} s of the road test", gear=gear_name(gear), time=time)


def _gears(road_test: RoadTest, counted: CountedSamples) -> dict[int, float]:
    gear = road_test.values("gear")
    if gear is None:
        return {}
    return {int(each): counted.time_of(gear == each) for each in np.unique(gear[np.isfinite(gear)])}


def _span(logged: np.ndarray | None) -> tuple[float, float] | None:
    if logged is None or not np.isfinite(logged).any():
        return None
    return float(np.nanmin(logged)), float(np.nanmax(logged))


@dataclass(frozen=True)
class RoadDiagnosis:
    """What a unit's road test says; nothing where none was driven."""

    log: RoadFindings | None = None  # what it says by itself
    leakage: RoadLeakage | None = None  # None where no leakage can be computed over it
    messages: tuple[Message, ...] = ()  # of a log without leakage over it: its own, and why


def diagnosed_road(
    road_test: RoadTest | None,
    model: LeakageModel,
    condition: OperatingPoint,
    limits: Limits,
    assumptions: Assumptions,
    guard_factor: float,
) -> RoadDiagnosis:
    """Evaluate a road test, if there is one.

    Parameters
    ----------
    condition
        which stands for what the log does not hold.
    limits, assumptions, guard_factor
        by which the log is judged, and what is uncertain.
    """
    if road_test is None:
        return RoadDiagnosis()
    log = road_findings(model.controller, road_test, limits, assumptions, guard_factor)
    try:
        return RoadDiagnosis(log, leakage_over(model, road_test, condition))
    except RoadTestError as error:
        text = Sentence(
            "No leakage is computed over {file}: {problem}.", file=log.road_test.file, problem=error.problem
        )
        return RoadDiagnosis(log, None, (*log.road_test.messages, Message("warning", NO_LEAKAGE, text)))


def leakage_over(model: LeakageModel, road_test: RoadTest, condition: OperatingPoint) -> RoadLeakage:
    """Compute the leakage over a log, or take it from the last time, where nothing has changed on which it rests.

    Of the condition counts only what stands for what the log does not hold, and what sets the pressure of circuits.

    Raises
    ------
    RoadTestError
        a road test without usable main pressure.
    """
    logged = all(name in road_test.channels for name in _LOGGED)
    sets = (condition.name, condition.like, condition.solenoid_current, condition.lockup_duty)
    rests_on = (model, (sets if model.controller.circuits else None) if logged else condition)

    def made() -> dict[str, Any]:
        road = vars(evaluate_road_test(model, road_test, condition))
        return {name: value for name, value in road.items() if name not in ("road_test", "assumed")}

    return RoadLeakage(
        road_test=road_test, assumed=condition, **kept_with(road_test, "leakage", rests_on, made, most=1)
    )
