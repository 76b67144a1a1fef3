"""Tables of a road-test log: its events, its pressures, and each channel's values over a part and at its ends."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from atleak.engine.road_leakage import RoadLeakage
from atleak.engine.road_pressure import Departure, PlaceFinding, RoadPressure
from atleak.events import Event
from atleak.road_test import RoadTest
from atleak.views.road_words import event_remark
from atleak.views.table import Column, Table
from atleak.wording import Wording
from atleak.workshop_units import DM3_MIN, KPA, PERCENT

Scale = tuple[str, Callable[[Any], Any]]  # a unit's name, and the function from SI to it
Scales = Mapping[str, Scale]  # by quantity
Curve = tuple[str, np.ndarray, np.ndarray, str]  # name, stamps [s], values in the reader's unit, that unit


def event_table(events: Sequence[Event], say: Wording) -> Table:
    """Return a row for every event of a log."""
    columns = (
        Column("event", of=lambda event: say(f"events.{event.kind}"), width=150),
        Column("event_gears", of=lambda each: None if each.to_gear is None else f"{each.from_gear} → {each.to_gear}"),
        Column("event_start", "time", 2, of="start"),
        Column("event_stop", "time", 2, of="stop"),
        Column("event_lasts", "time", 2, of="duration"),
        Column("event_source", of=lambda event: say.get("event_sources", event.source)),
        Column("event_note", of=lambda event: event_remark(event, say) or None, width=300),
    )
    return Table("events", columns, events, say)


def place_table(permitted: RoadPressure, say: Wording) -> Table:
    """Return a row for every gear and state in which main pressure was judged."""

    def worst(place: PlaceFinding, of: Callable[[Departure], Any]) -> Any:
        return None if place.worst is None else of(place.worst)

    columns = (
        Column("place_gear", digits=0, of="gear"),
        Column("place_state", of=lambda place: say(f"states.{place.state}"), width=100),
        Column("place_judged", "time", 2, of="judged"),
        Column("place_lowest", "pressure", 0, of=lambda place: worst(place, lambda at: at.pressure), times=KPA),
        Column("place_limit", "pressure", 0, of=lambda place: worst(place, lambda at: at.limit), times=KPA),
        Column(
            "place_below_by",
            "percent",
            1,
            of=lambda place: worst(place, lambda at: max(at.fraction, 0.0)),
            times=PERCENT,
        ),
        Column("place_below", "time", 2, of="below"),
        Column("place_above", "time", 2, of="above"),
        Column("place_source", of=lambda place: worst(place, lambda at: at.source)),
    )
    return Table("places", columns, permitted.places, say)


def circuit_table(road: RoadLeakage, say: Wording) -> Table:
    """Return a row for every circuit that the log applies: what it holds."""
    columns = (
        Column("circuit", of=lambda each: each.circuit.name),
        Column("circuit_lowest", "pressure", 0, of="lowest", times=KPA),
        Column("circuit_at_main", "pressure", 0, of="main_pressure", times=KPA),
        Column("circuit_at", "time", 1, of="time"),
        Column("circuit_mean", "pressure", 0, of="mean", times=KPA),
    )
    return Table("circuits", columns, [*road.circuit_ranges.values()], say)


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
        unit, convert = scales.get(name, (channel.unit, as_it_is))
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


def as_it_is(values: Any) -> Any:
    """Return values in the unit that they are in."""
    return values
