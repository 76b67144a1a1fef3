"""Detect what happened in a road test: shifts, idle, stall, lock-up, steady driving, minimum-acceleration test.

Every event is a window of time; `RoadTest.window` gives the samples in it. The thresholds are choices of this project,
gathered in `Thresholds`, except where the field's source is named.
"""

from __future__ import annotations

from collections.abc import Sequence

from atleak.measurements.events.acceleration import minimum_acceleration
from atleak.measurements.events.driving import (
    ConverterSlip,
    converter_slip,
    engine_starts,
    gear_shifts,
    hot_idle,
    lock_ups,
    ratio_levels,
    stalls,
    steady_driving,
    with_derived_gear,
)
from atleak.measurements.events.event import USUAL, AccelerationTest, Event, EventKind, Thresholds, runs
from atleak.measurements.road_test import RoadTest

__all__ = [
    "AccelerationTest", "ConverterSlip", "Event", "EventKind", "Thresholds", "converter_slip", "engine_starts",
    "events", "gear_shifts", "hot_idle", "lock_ups", "minimum_acceleration", "ratio_levels", "runs", "stalls",
    "steady_driving", "with_derived_gear",
]  # fmt: skip


def events(road_test: RoadTest, limits: Thresholds = USUAL, gears: Sequence[int] = ()) -> tuple[Event, ...]:
    """Return all events of a road test by their start; a missing channel leaves out only the events that need it.

    Parameters
    ----------
    gears
        those of the valve body: a minimum-acceleration test goes through all of them.
    """
    all_events = [
        *gear_shifts(road_test, limits),
        *hot_idle(road_test, limits),
        *stalls(road_test, limits),
        *lock_ups(road_test, limits),
        *steady_driving(road_test, limits),
        *minimum_acceleration(road_test, limits, gears),
        *engine_starts(road_test, limits),
    ]
    return tuple(sorted(all_events, key=lambda event: (event.start, event.kind)))
