"""Gather what a road-test log says by itself, whether or not the valve body was measured, and judge its pressure."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_tables import StandingState
from atleak.catalogue.limits import Limits, RuleKind
from atleak.common.cache import kept_with
from atleak.common.sentences import Sentence
from atleak.diagnosis.rules import Rule
from atleak.diagnosis.uncertainty import DEFAULTS, GUARD_FACTOR, Assumptions, RuleDecision
from atleak.diagnosis.uncertainty.decision import decide_normal
from atleak.engine.extremes import CountedSamples
from atleak.engine.road_pressure import (
    CommandedPressure,
    NotJudged,
    RoadPressure,
    compare_with_commanded,
    judge_pressure,
)
from atleak.measurements.events import ConverterSlip, Event, converter_slip, events
from atleak.measurements.road_test import RoadTest


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
    controller
        the valve body, with its gears and what it permits of main pressure.
    road_test
        any log: what it lacks is left out.
    limits
        by which main pressure is judged.
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
    return (
        judge_pressure(controller, road_test),
        compare_with_commanded(road_test),
        events(road_test, gears=controller.gears),
        _gears(road_test),
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
        return Sentence("gear {gear}, idle, at {time:.1f} s of the road test", gear=gear, time=time)
    if state == "stall":
        return Sentence("gear {gear}, stall, at {time:.1f} s of the road test", gear=gear, time=time)
    return Sentence("gear {gear}, driving, at {time:.1f} s of the road test", gear=gear, time=time)


def _gears(road_test: RoadTest) -> dict[int, float]:
    gear = road_test.values("gear")
    if gear is None:
        return {}
    counted = CountedSamples(road_test)
    return {int(each): counted.time_of(gear == each) for each in np.unique(gear[np.isfinite(gear)])}


def _span(logged: np.ndarray | None) -> tuple[float, float] | None:
    if logged is None or not np.isfinite(logged).any():
        return None
    return float(np.nanmin(logged)), float(np.nanmax(logged))
