"""Compare main pressure with what is permitted and commanded, and time in gears, over a log that comes in pieces.

What is found is what `atleak.engine.road_pressure` finds in the whole.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from atleak.catalogue.controller import Controller
from atleak.engine.extremes import SUSTAINED_SECONDS
from atleak.engine.lasting_pieces import CountedPiece, LastingInPieces, Worst, counted_pieces
from atleak.engine.road_pressure import (
    STATES,
    CommandedPressure,
    Departure,
    NotJudged,
    PermittedSamples,
    PlaceFinding,
    PressureByTemperature,
    RoadPressure,
    actual_and_commanded,
    commanded_is_logged,
    why_not_judged,
)
from atleak.events import Event
from atleak.large_log import LargeLog

_READ = ("main_pressure", "commanded_pressure", "engine_speed", "gear", "selector", "vehicle_speed", "output_speed",
         "atf_temperature")  # fmt: skip


@dataclass(frozen=True)
class PressureFindings:
    """What a log says of main pressure and gears by itself."""

    pressure: RoadPressure | NotJudged
    commanded: CommandedPressure | None
    gears: dict[int, float]  # gear → time in it with the engine running [s]; none where no gear is logged


def pressure_in_pieces(controller: Controller, log: LargeLog, events: Sequence[Event]) -> PressureFindings:
    """Compare main pressure with what is permitted and commanded, and add up the time in gears.

    Parameters
    ----------
    events
        those of the whole log.
    """
    why = why_not_judged(controller, log.head)
    judged = None if why is not None else _Judged(controller)
    compared = _Compared() if commanded_is_logged(log.head) else None
    gears: dict[int, list[float]] = defaultdict(list)
    logged = log.head.channel("gear") is not None
    for piece in counted_pieces(log, events, SUSTAINED_SECONDS, _READ):
        if judged is not None:
            judged.add(piece)
        if compared is not None:
            compared.add(piece)
        if logged:
            gear = np.asarray(piece.road_test.values("gear"))
            there = gear[piece.core]
            for each in np.unique(there[np.isfinite(there)]).tolist():
                gears[int(each)].append(piece.time_of(gear == each))
    return PressureFindings(
        pressure=judged.result if judged is not None else why or "never_there",
        commanded=None if compared is None else compared.result,
        gears={gear: math.fsum(times) for gear, times in sorted(gears.items())},
    )


class _Judged:
    """Main pressure beside what is permitted, as it grows from piece to piece; a group is a limit in one gear."""

    def __init__(self, controller: Controller) -> None:
        self.controller, self.under, self.over = controller, LastingInPieces(), LastingInPieces()
        self.groups = [
            (number, gear)
            for number, permitted in enumerate(controller.permissible)
            for gear in sorted(permitted.gears)
        ]
        self.times: dict[int, list[float]] = defaultdict(list)
        self.warmth = PressureByTemperature()

    def add(self, piece: CountedPiece) -> None:
        limits = PermittedSamples(self.controller, piece.road_test, piece.counted)
        group = np.full(len(limits.time), -1)
        for place, (number, gear) in enumerate(self.groups):
            here = (limits.number == number) & (limits.gear == gear)
            if here.any():
                group[here] = place
                self.times[place].append(piece.time_of(here))
                at = np.flatnonzero(here[piece.core]) + piece.core.start
                self.warmth.add(place, piece.counted.steps[at], limits.temperature[at], limits.pressure[at])
        excesses = (
            (self.under, 1.0 - limits.pressure / limits.low, limits.low),
            (self.over, limits.pressure / limits.high - 1.0, limits.high),
        )
        for lasting, excess, limit in excesses:
            _feed(lasting, piece, excess, group, pressure=limits.pressure, limit=limit)

    @property
    def result(self) -> RoadPressure | NotJudged:
        if not any(seconds > 0.0 for times in self.times.values() for seconds in times):
            return "never_there"
        places = []
        for place, (number, gear) in enumerate(self.groups):
            judged = math.fsum(self.times[place])
            if judged > 0.0:
                below, above = self.under.outside(place), self.over.outside(place)
                worst = self._departure(self.under.worst(place))
                state = self.controller.permissible[number].state
                places.append(PlaceFinding(gear, state, judged, below, above, worst, self.warmth.of(place)))
        places.sort(key=lambda each: (each.gear, STATES.index(each.state)))
        lowest, highest = self._departure(self.under.worst()), self._departure(self.over.worst())
        return RoadPressure(tuple(places), lowest, highest)

    def _departure(self, worst: Worst | None) -> Departure | None:
        if worst is None:
            return None
        number, gear = self.groups[int(worst.values["group"])]
        permitted = self.controller.permissible[number]
        start, stop = worst.span
        return Departure(
            start=start,
            stop=stop,
            at=worst.time,
            gear=gear,
            state=permitted.state,
            pressure=worst.values["pressure"],
            limit=worst.values["limit"],
            fraction=worst.excess,
            source=permitted.source,
        )


class _Compared:
    """Main pressure as measured minus as commanded, as it grows from piece to piece."""

    def __init__(self) -> None:
        self.sides = LastingInPieces(), LastingInPieces()
        self.times: list[float] = []

    def add(self, piece: CountedPiece) -> None:
        actual, commanded = actual_and_commanded(piece.road_test, piece.counted)
        difference, group = actual - commanded, np.zeros(len(actual), int)
        self.times.append(piece.time_of(np.isfinite(difference)))
        for lasting, side in zip(self.sides, (difference, -difference), strict=True):
            _feed(lasting, piece, side, group, difference=difference, actual=actual, commanded=commanded)

    @property
    def result(self) -> CommandedPressure | None:
        found = [worst for lasting in self.sides if (worst := lasting.worst()) is not None]
        if not found:
            return None
        largest = max(found, key=lambda worst: worst.excess)
        start, stop = largest.span
        return CommandedPressure(
            difference=largest.values["difference"],
            at=largest.time,
            actual=largest.values["actual"],
            commanded=largest.values["commanded"],
            start=start,
            stop=stop,
            compared=math.fsum(self.times),
        )


def _feed(
    lasting: LastingInPieces, piece: CountedPiece, excess: np.ndarray, group: np.ndarray, **values: np.ndarray
) -> None:
    """Add the samples of a piece that count."""
    here, counted = piece.counting, piece.counted
    lasting.add(
        counted.time[here],
        counted.steps[here],
        piece.stretch[here],
        excess[here],
        group[here],
        **{name: array[here] for name, array in values.items()},
    )
