"""List, for a workbook, the events of a road test and the gears and states in which it was judged."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from atleak.engine.road_pressure import RoadPressure
from atleak.events import Event
from atleak.sentence import Sentence
from atleak.views.road_words import event_remark
from atleak.wording import Wording, wording
from atleak.workshop_units import KPA, PERCENT


def event_rows(events: Iterable[Event], say: Wording | None = None) -> list[dict[str, Any]]:
    """Return one row for every event, in English unless the words of another language are given."""
    say = say or wording("en")
    return [
        {
            Sentence("event"): say(f"events.{event.kind}"),
            Sentence("gears"): None if event.to_gear is None else f"{event.from_gear} → {event.to_gear}",
            Sentence("start [s]"): event.start,
            Sentence("end [s]"): event.stop,
            Sentence("lasts [s]"): event.duration,
            Sentence("source"): event.source,
            Sentence("note"): event_remark(event, say) or None,
        }
        for event in events
    ]


def place_rows(permitted: RoadPressure, say: Wording | None = None) -> list[dict[str, Any]]:
    """Return one row for every gear and state in which main pressure was judged, in workshop units.

    They are in English unless the words of another language are given.
    """
    say = say or wording("en")
    return [
        {
            Sentence("gear"): place.gear,
            Sentence("state"): say(f"states.{place.state}"),
            Sentence("judged for [s]"): place.judged,
            Sentence("lowest, lasting [kPa]"): place.worst and place.worst.pressure * KPA,
            Sentence("permitted at least [kPa]"): place.worst and place.worst.limit * KPA,
            Sentence("below by [%]"): place.worst and max(place.worst.fraction, 0.0) * PERCENT,
            Sentence("below for [s]"): place.below,
            Sentence("above for [s]"): place.above,
            Sentence("limits from"): place.worst and place.worst.source,
        }
        for place in permitted.places
    ]
