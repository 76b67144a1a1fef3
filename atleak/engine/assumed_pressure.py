"""Give a road test without main pressure that of the valve body's operating points, by gear and state, and say so."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from atleak.catalogue.circuit_tables import State
from atleak.catalogue.controller import Controller
from atleak.catalogue.operating_point import IDLE_SPEED, OperatingPoint
from atleak.errors import Message
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
        text = Sentence("The log has a main pressure: none is assumed from the valve body's operating points.")
        said = Message("warning", "pressure_not_assumed", text)
        return replace(road_test, messages=(*road_test.messages, said))
    points, used = controller.operating_points, dict[tuple[float, int], OperatingPoint]()
    first, count = points[0], len(road_test.time)
    gear, speed = road_test.values("gear"), road_test.values("engine_speed")
    gears = np.full(count, float(first.gear)) if gear is None else np.nan_to_num(gear, nan=float(first.gear))
    idle = np.full(count, first.state == "idle") if speed is None else speed < IDLE_SPEED
    pressure = np.full(count, np.nan)
    for each in np.unique(gears).tolist():
        for rank, there in enumerate((idle, ~idle)):
            here = there & (gears == each)
            if here.any():
                used[each, rank] = _nearest(points, int(each), "driving" if rank else "idle")
                pressure[here] = used[each, rank].main_pressure
    channel = Channel("main_pressure", road_test.time, pressure, np.zeros(len(pressure), bool), source="derived")
    messages = (*road_test.messages, _said([used[key] for key in sorted(used)]))
    channels = MappingProxyType({**road_test.channels, "main_pressure": channel})
    return replace(road_test, channels=channels, messages=messages, _held={})


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
