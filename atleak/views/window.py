"""Describe a part of a road test: the events in it, and each channel's least, mean and largest value."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np

from atleak.engine.road_leakage import RoadLeakage
from atleak.events import Event
from atleak.road_test import QUANTITIES, RoadTest
from atleak.workshop_units import DM3_MIN, PERCENT

Scales = Mapping[str, tuple[str, Callable[[Any], Any]]]
EVENT_NAMES = {
    "minimum_acceleration": "minimum-acceleration test",
    "gear_shift": "shift",
    "hot_idle": "hot idle",
    "stall": "stall",
    "lock_up": "lock-up",
    "steady_driving": "steady driving",
    "engine_start": "start of the engine",
}


def event_label(event: Event) -> str:
    """Return an event in words: ``shift 1 → 2, 0.9 to 1.4 s``."""
    gears = "" if event.to_gear is None else f" {event.from_gear} → {event.to_gear}"
    return f"{EVENT_NAMES[event.kind]}{gears}, {event.start:.1f} to {event.stop:.1f} s"


def event_rows(events: Iterable[Event]) -> list[dict[str, Any]]:
    """Return one row for every event."""
    return [
        {
            "event": EVENT_NAMES[event.kind],
            "gears": None if event.to_gear is None else f"{event.from_gear} → {event.to_gear}",
            "start [s]": event.start,
            "end [s]": event.stop,
            "lasts [s]": event.duration,
            "source": event.source,
            "note": event.note or None,
        }
        for event in events
    ]


def window_rows(test: RoadTest, road: RoadLeakage | None, scales: Scales) -> list[dict[str, Any]]:
    """Return the least, mean and largest value of every channel and of leakage, pump flow and share.

    Suspect samples are left out.

    Parameters
    ----------
    test, road
        a road test, or a window of one, and the leakage over it.
    scales
        quantity → unit's name and the function from SI to that unit.

    Notes
    -----
    The mean is that of a channel's own samples, each counting alike.
    """
    rows = []
    for name, channel in test.channels.items():
        unit, convert = scales.get(name, (channel.unit, lambda value: value))
        rows += _row(QUANTITIES[name].label, unit, convert(channel.good))
    if road is not None:
        rows += _row("leakage", "dm³/min", road.leakage * DM3_MIN)
        if road.pump_capacity is not None and road.share is not None:
            rows += _row("pump flow", "dm³/min", road.pump_capacity * DM3_MIN)
            rows += _row("share", "%", road.share * PERCENT)
    return rows


def _row(label: str, unit: str, values: np.ndarray) -> list[dict[str, Any]]:
    good = values[np.isfinite(values)]
    if not len(good):
        return []
    return [
        {
            "what": label,
            "unit": unit,
            "least": float(good.min()),
            "mean": float(good.mean()),
            "largest": float(good.max()),
            "samples": len(good),
        }
    ]
