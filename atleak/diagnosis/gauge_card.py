"""Say what gauges should show on a unit: at every tap, in every range and state of the engine, new and as measured."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Literal, NamedTuple, cast

import numpy as np

from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_tables import SelectorRange
from atleak.catalogue.instruments import Instruments, load_instruments
from atleak.catalogue.operating_point import OperatingPoint
from atleak.common.printable import brief
from atleak.diagnosis.uncertainty import Assumptions
from atleak.diagnosis.uncertainty.posterior import PosteriorUnit
from atleak.diagnosis.uncertainty.sources import LandSources, find_sources
from atleak.engine.leakage import LeakageModel
from atleak.engine.operation import LINE as LINE_SECTION
from atleak.engine.projection import Projection, project
from atleak.equations.statistics import normal_quantile
from atleak.measurements.clearances import LandClearance
from atleak.measurements.gauge_readings import LINE_TAP, Engine, GaugeCell, applied, gear_in, ranges_of, taps_of
from atleak.measurements.readings import Readings

USUAL_FAST_IDLE = 1500.0 / 60.0  # [1/s] where no speed is stated, as in Chrysler's table: choice of this project
_ERRORS = normal_quantile((np.arange(64) + 0.5) / 64)  # of a gauge, alike likely [standard uncertainties]
_ENDS = (0.025, 0.975)

StandsToExpected = Literal["as_new", "as_measured", "between", "below", "above"]


class Shows(NamedTuple):
    """What a gauge shows: at best estimate, and between which pressures in 95 of 100 cases [Pa]."""

    value: float
    low: float
    high: float


@dataclass(frozen=True)
class Expected:
    """What a gauge would show at one tap and operating point."""

    new: Shows  # on the same unit new
    now: Shows  # as measured: the very same where nothing was measured

    @property
    def measured(self) -> bool:
        """Return whether anything was measured that could set the unit apart from a new one."""
        return self.now is not self.new

    def stands(self, pressure: float) -> StandsToExpected:
        """Return how a gauge's reading [Pa] stands to what it would show.

        Returns
        -------
        str
            ``as_new`` within what a new unit would show, else ``as_measured`` within what this one would; ``below`` or
            ``above`` both, or ``between`` them.
        """
        if self.new.low <= pressure <= self.new.high:
            return "as_new"
        if self.now.low <= pressure <= self.now.high:
            return "as_measured"
        if pressure < min(self.new.low, self.now.low):
            return "below"
        return "above" if pressure > max(self.new.high, self.now.high) else "between"


@dataclass(frozen=True)
class CardRow:
    """A tap in the ranges in which one gear is engaged, in one state of the engine."""

    tap: str
    ranges: tuple[SelectorRange, ...]
    engine: Engine
    point: OperatingPoint | None  # that is like it; None where the valve body's file has none
    expected: Expected | None  # None where nothing can be computed there


def standing_point(
    controller: Controller,
    gear: int | None,
    state: str,
    temperature: float | None = None,
    engine_speed: float | None = None,
) -> OperatingPoint | None:
    """Return the operating point of a gear and state, with its temperature and speed where none are stated."""
    points = (each for each in controller.operating_points if each.gear == gear and each.state == state)
    point = next(points, None)
    if point is None:
        return None
    return replace(
        point,
        temperature=point.temperature if temperature is None else temperature,
        engine_speed=point.engine_speed if engine_speed is None else engine_speed,
        stated_state=point.stated_state if engine_speed is None else point.state,
    )


def point_of(
    controller: Controller, cell: GaugeCell, temperature: float | None = None, engine_speed: float | None = None
) -> OperatingPoint | None:
    """Return the operating point of the gear and state of a cell, at a temperature and speed that are stated.

    At a fast idle line pressure is that of idle, and only a stated speed says what the pump delivers.
    """
    if cell.engine is Engine.FAST_IDLE and engine_speed is None:
        return None
    state = "stall" if cell.engine is Engine.STALL else "idle"
    return standing_point(controller, gear_in(cell.range, controller.gears), state, temperature, engine_speed)


@brief
@dataclass(frozen=True)
class GaugeCard:
    """What gauges should show on a unit.

    Each draw of the unit, as uncertain as clearances, fluid, pump and feeds are and without any fault that nobody saw,
    is read by gauges that err as the assumption ``main_pressure`` says.
    """

    model: LeakageModel  # as measured
    unworn: LeakageModel  # as it may have been when new
    readings: Readings | None  # None where no land was measured
    instruments: Instruments | None  # with which they were taken
    assumptions: Assumptions

    @property
    def measured(self) -> bool:
        """Return whether lands or the pump were measured: else the unit is as new."""
        by_leak = any(state.leak for state in self._clearances)
        return self.readings is not None or by_leak or self.model.controller.pump.measured.any_known

    def rows(self, fast_idle: float = USUAL_FAST_IDLE) -> Iterator[CardRow]:
        """Yield what can be read: the line in all ranges, a circuit where it is applied; no stall in park and neutral.

        ``fast_idle`` is the speed of the engine then [1/s].
        """
        controller = self.model.controller
        for tap in taps_of(controller):
            alike: dict[tuple[int | None, bool], list[SelectorRange]] = {}
            for selected in ranges_of(controller):
                if applied(controller, GaugeCell(selected, Engine.SLOW_IDLE, tap)):
                    driving = selected not in ("P", "N")
                    alike.setdefault((gear_in(selected, controller.gears), driving), []).append(selected)
            for (_, driving), ranges in alike.items():
                for engine in Engine:
                    if driving or engine is not Engine.STALL:
                        speed = fast_idle if engine is Engine.FAST_IDLE else None
                        point = point_of(controller, GaugeCell(ranges[0], engine, tap), engine_speed=speed)
                        expected = None if point is None else self.at(project(self.model, point), tap)
                        yield CardRow(tap, tuple(ranges), engine, point, expected)

    def at(self, projection: Projection, tap: str) -> Expected | None:
        """Return what a gauge would show; None at a circuit that is vented or that nothing is computed of.

        Parameters
        ----------
        projection
            of the unit as measured.
        tap
            the line's, or the id of a circuit.
        """
        if held_at(projection, tap) is None or any(
            each.vented for each in projection.circuits if each.circuit.id == tap
        ):
            return None
        section = section_of(tap)
        shows = [self._shows(held_at(state, tap) or 0.0, drawn[section]) for state, drawn in self._states(projection)]
        return Expected(shows[0], shows[-1])

    def _states(self, now: Projection) -> list[tuple[Projection, Mapping[str, Any]]]:
        """Return the unit new and, where anything was measured, as measured: what it holds, and in each draw [Pa]."""
        point = now.condition
        if point not in self._drawn:
            unit = PosteriorUnit(self.model, self.sources, self.assumptions, [now])
            states = [project(self.unworn, point), *([now] if self.measured else [])]
            self._drawn[point] = [
                (each, unit.pressures(unit.as_measured, point, new=each is not now)) for each in states
            ]
        return self._drawn[point]

    def _shows(self, held: float, drawn: Any) -> Shows:
        read = np.multiply.outer(drawn, 1.0 + self.assumptions.main_pressure * _ERRORS)
        low, high = np.quantile(read, _ENDS).tolist()
        return Shows(held, min(low, held), max(high, held))

    @cached_property
    def _drawn(self) -> dict[OperatingPoint, list[tuple[Projection, Mapping[str, Any]]]]:
        return {}

    @property
    def _clearances(self) -> Sequence[LandClearance]:
        return cast("Sequence[LandClearance]", self.model.clearances)

    @cached_property
    def sources(self) -> tuple[LandSources, ...]:
        """Return every land with what makes its clearance uncertain."""
        controller = self.model.controller
        return find_sources(self._clearances, self.readings, controller, self.gauges, self.assumptions)[0]

    @property
    def gauges(self) -> Instruments:
        """Return the instruments, the catalogue's defaults where none are stated."""
        return self.instruments or load_instruments()


def held_at(projection: Projection, tap: str) -> float | None:
    """Return what pump or circuit hold at a tap [Pa]; None at a circuit that is not computed."""
    if tap == LINE_TAP:
        return projection.main_pressure_held
    return next((each.pressure for each in projection.circuits if each.circuit.id == tap), None)


def section_of(tap: str) -> str:
    """Return the section whose pressure a tap shows."""
    return LINE_SECTION if tap == LINE_TAP else tap
