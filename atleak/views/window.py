"""Describe a part of a road test: the events in it, and each channel's least, mean and largest value."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np

from atleak.engine.road_leakage import RoadLeakage
from atleak.engine.road_pressure import RoadPressure
from atleak.events import Event
from atleak.road_test import QUANTITIES, RoadTest
from atleak.views.road_words import event_name, event_remark
from atleak.wording import Wording, wording
from atleak.workshop_units import DM3_MIN, KPA, PERCENT

Scales = Mapping[str, tuple[str, Callable[[Any], Any]]]


def event_label(event: Event) -> str:
    """Return an event in words: ``shift 1 → 2, 0.9 to 1.4 s``."""
    return f"{event_name(event, wording('en'))}, {event.start:.1f} to {event.stop:.1f} s"


def event_rows(events: Iterable[Event], say: Wording | None = None) -> list[dict[str, Any]]:
    """Return one row for every event, in English unless the words of another language are given."""
    say = say or wording("en")
    return [
        {
            "event": say(f"events.{event.kind}"),
            "gears": None if event.to_gear is None else f"{event.from_gear} → {event.to_gear}",
            "start [s]": event.start,
            "end [s]": event.stop,
            "lasts [s]": event.duration,
            "source": event.source,
            "note": event_remark(event, say) or None,
        }
        for event in events
    ]


def place_rows(permitted: RoadPressure) -> list[dict[str, Any]]:
    """Return one English row for every gear and state in which main pressure was judged, in workshop units."""
    say = wording("en")
    return [
        {
            "gear": place.gear,
            "state": say(f"states.{place.state}"),
            "judged for [s]": place.judged,
            "lowest, lasting [kPa]": place.worst and place.worst.pressure * KPA,
            "permitted at least [kPa]": place.worst and place.worst.limit * KPA,
            "below by [%]": place.worst and max(place.worst.fraction, 0.0) * PERCENT,
            "below for [s]": place.below,
            "above for [s]": place.above,
            "limits from": place.worst and place.worst.source,
        }
        for place in permitted.places
    ]


def circuit_rows(road: RoadLeakage) -> list[dict[str, Any]]:
    """Return one English row for every circuit that the log applies: what it holds, in workshop units."""
    return [
        {
            "circuit": each.circuit.name,
            "lowest [kPa]": each.lowest * KPA,
            "at main pressure [kPa]": each.main_pressure * KPA,
            "at [s]": each.time,
            "mean [kPa]": each.mean * KPA,
        }
        for each in road.circuit_ranges.values()
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
