"""Match the events of two road tests, so that the logs can be laid over one another event by event."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass

from atleak.events import Event
from atleak.road_findings import RoadFindings
from atleak.road_test import RoadTest

MARGIN = 2.0  # [s] shown before an event and after it
_What = tuple[str, int | None, int | None]


@dataclass(frozen=True)
class EventPair:
    """An event of one log and its like in the other: the same kind, for shifts the same gears, in the same place.

    ``order`` counts from 1 among the events of the same kind and gears. One of the sides may have no such event.
    """

    order: int
    before: Event | None
    after: Event | None

    @property
    def event(self) -> Event:
        """Return the event of the side that has it, of both the one before."""
        event = self.before or self.after
        assert event is not None
        return event

    @property
    def matched(self) -> bool:
        """Return whether both logs hold it."""
        return self.before is not None and self.after is not None

    @property
    def lasts(self) -> float:
        """Return the longer of both durations [s]."""
        return max(each.duration for each in (self.before, self.after) if each is not None)


@dataclass(frozen=True)
class LogComparison:
    """Two road tests and their events, matched."""

    before: RoadFindings
    after: RoadFindings
    pairs: tuple[EventPair, ...]  # by the time of the log before; what only the log after holds comes last

    @property
    def matched(self) -> tuple[EventPair, ...]:
        """Return the events that both logs hold."""
        return tuple(pair for pair in self.pairs if pair.matched)

    def windows(self, pair: EventPair) -> tuple[tuple[RoadTest, float], ...]:
        """Return of each side the part of its log around a matched event, and the event's own start on its time [s].

        Both parts reach equally far before the start and behind it.
        """
        logs = ((self.before, pair.before), (self.after, pair.after))
        return tuple(
            (findings.road_test.window(event.start - MARGIN, event.start + pair.lasts + MARGIN), event.start)
            for findings, event in logs
            if event is not None
        )


def compared_logs(before: RoadFindings, after: RoadFindings) -> LogComparison:
    """Return two logs with their events matched by kind and order, each to be aligned at its own start."""
    return LogComparison(before, after, match_events(before.events, after.events))


def match_events(before: Sequence[Event], after: Sequence[Event]) -> tuple[EventPair, ...]:
    """Match the events of two logs: the first of a kind with the first, the second with the second, and so on.

    A shift is matched with one between the same gears.
    """
    waiting: dict[_What, list[Event]] = defaultdict(list)
    for event in after:
        waiting[_what(event)].append(event)
    counted: dict[_What, int] = defaultdict(int)
    pairs = []
    for event in before:
        what = _what(event)
        counted[what] += 1
        pairs.append(EventPair(counted[what], event, waiting[what].pop(0) if waiting[what] else None))
    for what, left in waiting.items():
        pairs += [EventPair(counted[what] + number, None, event) for number, event in enumerate(left, start=1)]
    return tuple(pairs)


def _what(event: Event) -> _What:
    return event.kind, event.from_gear, event.to_gear
