"""Rows of a road-test log for a page: its events, and each channel's values over a part and at both of its ends."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from atleak.engine.road_leakage import RoadLeakage
from atleak.engine.road_pressure import RoadPressure
from atleak.events import Event
from atleak.road_test import RoadTest
from atleak.views.road_words import event_remark
from atleak.wording import Wording
from atleak.workshop_units import DM3_MIN, KPA, PERCENT

Scale = tuple[str, Callable[[Any], Any]]  # a unit's name, and the function from SI to it
Scales = Mapping[str, Scale]  # by quantity
Curve = tuple[str, np.ndarray, np.ndarray, str]  # name, stamps [s], values in the reader's unit, that unit


def event_rows(events: Iterable[Event], say: Wording) -> list[dict[str, Any]]:
    """Return one row for every event, by the keys of the page's columns; times in s."""
    return [
        {
            "event": say(f"events.{event.kind}"),
            "event_gears": None if event.to_gear is None else f"{event.from_gear} → {event.to_gear}",
            "event_start": round(event.start, 2),
            "event_stop": round(event.stop, 2),
            "event_lasts": round(event.duration, 2),
            "event_source": say.get("event_sources", event.source),
            "event_note": event_remark(event, say) or None,
        }
        for event in events
    ]


def place_rows(permitted: RoadPressure, say: Wording) -> list[dict[str, Any]]:
    """Return one row for every gear and state in which main pressure was judged, in the units of atleak's records."""
    return [
        {
            "place_gear": str(place.gear),
            "place_state": say(f"states.{place.state}"),
            "place_judged": place.judged,
            "place_lowest": place.worst and place.worst.pressure * KPA,
            "place_limit": place.worst and place.worst.limit * KPA,
            "place_below_by": place.worst and max(place.worst.fraction, 0.0) * PERCENT,
            "place_below": place.below,
            "place_above": place.above,
            "place_source": place.worst and place.worst.source,
        }
        for place in permitted.places
    ]


def circuit_rows(road: RoadLeakage) -> list[dict[str, Any]]:
    """Return one row for every circuit that the log applies: what it holds, in the units of atleak's records."""
    return [
        {
            "circuit": each.circuit.name,
            "circuit_lowest": each.lowest * KPA,
            "circuit_at_main": each.main_pressure * KPA,
            "circuit_at": each.time,
            "circuit_mean": each.mean * KPA,
        }
        for each in road.circuit_ranges.values()
    ]


def log_curves(test: RoadTest, road: RoadLeakage | None, scales: Scales, say: Wording, file: str = "") -> list[Curve]:
    """Return every channel of a log, and its leakage, pump flow and share, in the reader's units; suspect ones are NaN.

    Parameters
    ----------
    road
        the leakage over the log, if there is one.
    scales
        quantity → unit's name and the function from SI to that unit.
    file
        named beside each channel: of a log that is laid over another one.
    """

    def named(name: str) -> str:
        return say("road_test.of_log", channel=name, file=file) if file else name

    curves: list[Curve] = []
    for name in test.channels:
        channel = test.channels[name]
        unit, convert = scales.get(name, (channel.unit, _as_it_is))
        curves.append((named(say(f"log_quantities.{name}")), channel.time, convert(channel.good), unit))
    if road is not None:
        flow = say.unit("flow")
        leakage = say.convert(road.leakage * DM3_MIN, "flow")
        curves.append((named(say("road_test.leakage_row")), road.time, leakage, flow))
        if road.pump_capacity is not None and road.share is not None:
            pump = say.convert(road.pump_capacity * DM3_MIN, "flow")
            curves.append((named(say("road_test.pump_flow")), road.time, pump, flow))
            curves.append((named(say("road_test.share")), road.time, road.share * PERCENT, "%"))
    return curves


def value_rows(curves: Sequence[Curve], ends: tuple[float, float], say: Wording) -> list[dict[str, str]]:
    """Return one row for every curve that has a value: its least, mean, largest, and the last value at each end.

    Parameters
    ----------
    ends
        the cursors [s].

    Notes
    -----
    The mean is that of a channel's own samples, each counting alike.
    """
    rows = []
    for name, time, values, unit in curves:
        good = values[np.isfinite(values)]
        if not len(good):
            continue
        rows.append(
            {
                "log_channel": name,
                "log_in": unit,
                "log_least": short(float(good.min()), say),
                "log_mean": short(float(good.mean()), say),
                "log_largest": short(float(good.max()), say),
                "log_first": short(_last_at(time, values, ends[0]), say),
                "log_second": short(_last_at(time, values, ends[1]), say),
                "log_samples": whole(len(good), say),
            }
        )
    return rows


def _last_at(time: np.ndarray, values: np.ndarray, moment: float) -> float | None:
    """Return the last value at or before a moment; None before the first and where that sample has none."""
    if not len(time):
        return None
    if len(time) == 1:  # a constant
        return float(values[0])
    place = int(np.searchsorted(time, moment + 1e-9, side="right")) - 1
    return float(values[place]) if place >= 0 and math.isfinite(values[place]) else None


def short(value: float | None, say: Wording) -> str:
    """Return a number with three digits and every digit before the decimal sign: ``1.65``, ``92.7``, ``2 346``."""
    if value is None or not math.isfinite(value):
        return say.number(None, 0)
    size = abs(value)
    if value.is_integer():
        return say.number(value, 0)
    digits = 3 if size < 0.001 else min(max(2 - math.floor(math.log10(size)), 0), 5)
    return say.number(value, digits)


def whole(count: int | None, say: Wording) -> str:
    """Return a count with its thousands parted: ``1 800 000``."""
    return say.number(None if count is None else float(count), 0)


def _as_it_is(values: Any) -> Any:
    return values
