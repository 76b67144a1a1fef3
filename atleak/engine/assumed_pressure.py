"""Give a road test without main pressure that of the valve body's operating points, by gear and state, and say so."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from atleak.catalogue.circuit_tables import State
from atleak.catalogue.circuits import IDLE_SPEED
from atleak.catalogue.controller import Controller, OperatingPoint
from atleak.errors import Message
from atleak.large_log import LargeLog
from atleak.road_test import Channel, RoadTest
from atleak.sentence import Sentence, in_a_row
from atleak.unit_systems import Quantity
from atleak.workshop_units import KPA

OPERATING_POINTS = "operating_points"
"""In place of a constant main pressure: that of the valve body's operating points."""


def with_assumed_pressure(controller: Controller, road_test: RoadTest) -> RoadTest:
    """Return the road test with a main pressure that is assumed by the gear and state of every sample.

    Idle is an engine speed under `IDLE_SPEED`. A gear of which no operating point is stated has the pressure of the
    nearest gear in the same state. Without a logged gear or speed the first operating point's stands for it. The log is
    returned as it is where it holds a main pressure, with a message that nothing was assumed.
    """
    if road_test.channel("main_pressure") is not None:
        return replace(road_test, messages=(*road_test.messages, _not_assumed()))
    assumed = _Assumed(controller)
    pressure = assumed.at(road_test.values("gear"), road_test.values("engine_speed"), len(road_test.time))
    channel = Channel("main_pressure", road_test.time, pressure, np.zeros(len(pressure), bool), source="derived")
    messages = (*road_test.messages, _said(assumed.points))
    channels = MappingProxyType({**road_test.channels, "main_pressure": channel})
    return replace(road_test, channels=channels, messages=messages, _held={})


def with_assumed_pressure_in_pieces(controller: Controller, log: LargeLog) -> LargeLog:
    """Return a log that is larger than memory with such a main pressure, as `with_assumed_pressure` does."""
    if log.head.channel("main_pressure") is not None:
        return replace(log, head=replace(log.head, messages=(*log.head.messages, _not_assumed())))
    assumed, nothing = _Assumed(controller), np.empty(0)
    parts = (
        assumed.at(log.values("gear", start, stop), log.values("engine_speed", start, stop), stop - start)
        for start, stop in log.spans()
    )
    channel = Channel("main_pressure", nothing, nothing, np.empty(0, bool), source="derived")
    with_pressure = log.with_channel(channel, parts)
    head = with_pressure.head
    return replace(with_pressure, head=replace(head, messages=(*head.messages, _said(assumed.points))))


class _Assumed:
    """The main pressure that is assumed, and by which operating points."""

    def __init__(self, controller: Controller) -> None:
        self._points = controller.operating_points
        self._used: dict[tuple[float, int], OperatingPoint] = {}

    @property
    def points(self) -> list[OperatingPoint]:
        """Return the operating points that were used, by gear, that of idle first."""
        return [self._used[key] for key in sorted(self._used)]

    def at(self, gear: np.ndarray | None, speed: np.ndarray | None, count: int) -> np.ndarray:
        """Return the pressure of some samples [Pa]."""
        first = self._points[0]
        gears = np.full(count, float(first.gear)) if gear is None else np.nan_to_num(gear, nan=float(first.gear))
        idle = np.full(count, first.state == "idle") if speed is None else speed < IDLE_SPEED
        pressure = np.full(count, np.nan)
        for each in np.unique(gears).tolist():
            for rank, there in enumerate((idle, ~idle)):
                here = there & (gears == each)
                if here.any():
                    point = _nearest(self._points, int(each), "driving" if rank else "idle")
                    pressure[here] = point.main_pressure
                    self._used[each, rank] = point
        return pressure


def _not_assumed() -> Message:
    text = Sentence("The log has a main pressure: none is assumed from the valve body's operating points.")
    return Message("warning", "pressure_not_assumed", text)


def _nearest(points: Sequence[OperatingPoint], gear: int, state: State) -> OperatingPoint:
    """Return the operating point of this state, or else of any other, whose gear is nearest."""
    return min(points, key=lambda point: (point.state != state, abs(point.gear - gear)))


def _said(points: Sequence[OperatingPoint]) -> Message:
    parts = [
        Sentence(
            "{pressure:g} {pressure.unit} ({condition})",
            pressure=Quantity(point.main_pressure * KPA, "pressure"),
            condition=point,
        )
        for point in dict.fromkeys(points)
    ]
    text = Sentence(
        "Main pressure is not logged: that of the valve body's operating points is assumed by gear and engine speed: "
        "{points}. No loss of pressure shows in it, and leakage and share over the log are estimates.",
        points=in_a_row(parts),
    )
    return Message("warning", "pressure_assumed", text)
