"""Compute leakage and pump flow over a log that is larger than memory: what `atleak.engine.road_leakage` gives of it.

One look through the log finds the lowest and highest of its channels, which decide how gaps are computed; a second one
computes every sample once. Sums are of sums over pieces, added up exactly (`math.fsum`), so that they do not
depend on where the log is cut by more than a few times the rounding of one number.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from atleak.catalogue.controller import OperatingPoint
from atleak.catalogue.limits import Steps
from atleak.engine.extremes import (
    FoundExtremes,
    Instant,
    SeriesExtremes,
    clock_of,
    larger,
    share_of,
    sustained_window,
)
from atleak.engine.lasting_pieces import CountedPiece, counted_pieces
from atleak.engine.leakage import LeakageModel
from atleak.engine.road_bands import TemperatureClass, TemperatureSums, bands_of
from atleak.engine.road_leakage import (
    CircuitRange,
    RoadLeakage,
    condition_of,
    ends_of,
    range_of,
    said_of_starts,
    shares_of,
    turning_apart,
    volume_of,
)
from atleak.engine.road_samples import (
    Ends,
    RoadSamples,
    Tally,
    channels_of,
    refuse_without_pressure,
    said_of_assumed,
    samples_of,
)
from atleak.engine.series import leakage_series
from atleak.events import Event
from atleak.events.event import within
from atleak.large_log import LargeLog, rows_of


@dataclass(frozen=True)
class RoadLeakageInPieces(RoadLeakage):
    """Leakage over a log that is larger than memory: all that is known of the whole, and no sample of it."""

    classes: tuple[TemperatureClass, ...]
    conditions: Mapping[Instant, OperatingPoint]

    def condition_at(self, instant: Instant) -> OperatingPoint:
        """Return the pressures, temperature, gear and speed of one of the instants."""
        return self.conditions[instant]


def evaluate_in_pieces(
    model: LeakageModel,
    log: LargeLog,
    assumed: OperatingPoint,
    events: Sequence[Event],
    limits: Steps,
    unworn: LeakageModel | None,
) -> RoadLeakageInPieces:
    """Compute leakage and pump flow over a log, as `atleak.engine.road_leakage.evaluate_road_test` does.

    Parameters
    ----------
    model, assumed
        as there.
    events
        of the whole log.
    limits, unworn
        by which the share is judged in the classes of temperature, as `atleak.engine.road_bands` takes them.

    Raises
    ------
    RoadTestError
        as there.
    """
    ends = _ends(log, assumed)
    refuse_without_pressure(log.head, *(float(end) for end in ends[0]))
    whole = _Whole(model, log, assumed, events, ends)
    bands = _Bands(whole, limits, unworn)
    for piece in counted_pieces(log, events, whole.window):
        samples = whole.add(piece)
        bands.add(piece, samples)
    whole.tally.refuse_nothing_known(model, log.head.file)
    with_speed = log.head.channel("engine_speed") is not None
    messages = [*said_of_assumed(log.head, assumed), *whole.tally.messages(model, with_speed=with_speed)]
    extremes, start = whole.driving, None
    if whole.starting:
        messages.append(said_of_starts(len(whole.starts), whole.starting, alone=not whole.turning_apart))
        extremes, start = (whole.driving, whole.at_start.found) if whole.turning_apart else (whole.all(), None)
    instants = (*extremes.found.instants, *(start.instants if start else ()))
    nothing = np.empty(0)
    return RoadLeakageInPieces(
        road_test=log.head,
        assumed=assumed,
        time=nothing,
        leakage=nothing,
        sections=dict.fromkeys(whole.volumes, nothing),
        circuits={circuit.id: nothing for circuit in model.controller.circuits},
        circuit_ranges=whole.circuit_ranges,
        pump_capacity=nothing if with_speed else None,
        gears=tuple(sorted(whole.tally.gears)),
        section_shares=shares_of({name: math.fsum(parts) for name, parts in whole.volumes.items()}),
        extremes=extremes.found,
        start=start,
        lower_bound=whole.tally.hotter > 0,
        messages=tuple(messages),
        classes=bands.sums.classes,
        conditions={at: condition_of(log.part(at.sample, at.sample + 1), 0, at, assumed) for at in instants},
    )


_CHANNELS = ("main_pressure", "converter_pressure", "atf_temperature")


def _ends(log: LargeLog, assumed: OperatingPoint) -> Ends:
    """Return the lowest and highest main pressure, converter pressure and temperature of a log; NaN without any."""
    ends = [np.array([np.nan, np.nan]) for _ in range(3)]
    for start, stop in log.spans():
        for end, values in zip(ends, channels_of(log.part(start, stop, _CHANNELS), assumed), strict=False):
            low, high = ends_of(values)
            end[:] = np.fmin(end[0], low), np.fmax(end[1], high)
    main, converter, temperature = ends
    return main, converter, temperature


class _Extremes:
    """The extremes of some samples as they grow from piece to piece."""

    def __init__(self, window: float) -> None:
        self.window, self.samples = window, 0
        self.best: dict[str, Instant] = {}

    def add(self, extremes: SeriesExtremes) -> None:
        self.samples += extremes.samples
        for name, worth in _WORTH.items():
            if not (extremes.samples or name.endswith("sustained")):  # whose middle may be a sample that is not known
                continue
            instant: Instant | None = getattr(extremes, name)
            if instant is not None and (name not in self.best or larger(worth(instant), worth(self.best[name]))):
                self.best[name] = instant

    @property
    def found(self) -> FoundExtremes:
        return FoundExtremes(
            window=self.window,
            samples=self.samples,
            max_leakage=self.best["max_leakage"],
            min_leakage=self.best["min_leakage"],
            max_share=self.best.get("max_share"),
            max_leakage_sustained=self.best.get("max_leakage_sustained"),
            max_share_sustained=self.best.get("max_share_sustained"),
        )


_WORTH: Mapping[str, Callable[[Instant], float]] = {
    "max_leakage": lambda instant: instant.leakage,
    "min_leakage": lambda instant: -instant.leakage,
    "max_share": lambda instant: instant.share or 0.0,
    "max_leakage_sustained": lambda instant: instant.leakage,
    "max_share_sustained": lambda instant: instant.share or 0.0,
}


class _Whole:
    """What is known of the whole log, as it grows from piece to piece."""

    def __init__(
        self, model: LeakageModel, log: LargeLog, assumed: OperatingPoint, events: Sequence[Event], ends: Ends
    ) -> None:
        self.model, self.log, self.assumed, self.ends = model, log, assumed, ends
        self.events = events
        self.starts = [event for event in events if event.kind == "engine_start"]
        self.window = sustained_window(log.head, log.usual_step)
        self.tally = Tally()
        self.driving, self.at_start = _Extremes(self.window), _Extremes(self.window)
        self.starting = 0  # samples in a start that have a leakage
        self.turning_apart = False  # whether there are others at which the engine turns
        self.volumes: dict[str, list[float]] = defaultdict(list)
        self._ranges: dict[str, list[CircuitRange]] = defaultdict(list)

    def add(self, piece: CountedPiece) -> RoadSamples:
        """Add a piece; return what was computed of its samples."""
        samples, leakage, capacity = self._computed(piece)
        self.tally.add(self.model, samples)
        core, counts = piece.core, leakage
        starting = within(piece.road_test.time, piece.near(self.starts))
        if self.starts:
            starting &= np.isfinite(leakage)
            self.starting += int(np.count_nonzero(starting[core]))
            self.turning_apart |= bool(turning_apart(piece.road_test, leakage, starting)[core].any())
            self.at_start.add(self._extremes(piece, np.where(starting, leakage, np.nan), capacity))
            counts = np.where(starting, np.nan, leakage)
        self.driving.add(self._extremes(piece, counts, capacity))
        self._add_volumes(piece, samples)
        self._add_ranges(piece, samples)
        return samples

    def all(self) -> _Extremes:
        """Return the extremes of all samples, those of the starts among them."""
        extremes = _Extremes(self.window)
        for piece in counted_pieces(self.log, self.events, self.window):
            _, leakage, capacity = self._computed(piece)
            extremes.add(self._extremes(piece, leakage, capacity))
        return extremes

    @property
    def circuit_ranges(self) -> dict[str, CircuitRange]:
        """Return what every circuit held that the log applies."""
        ranges = {}
        for name, parts in ((circuit.id, self._ranges[circuit.id]) for circuit in self.model.controller.circuits):
            if not parts:
                continue
            lowest = parts[0]
            for part in parts[1:]:
                lowest = part if larger(-part.lowest, -lowest.lowest) else lowest
            samples = sum(part.samples for part in parts)
            mean = math.fsum(part.mean * part.samples for part in parts) / samples
            ranges[name] = replace(lowest, mean=mean, samples=samples)
        return ranges

    def _computed(self, piece: CountedPiece) -> tuple[RoadSamples, np.ndarray, np.ndarray | None]:
        """Return what is computed of a piece's samples, and leakage and pump flow of these and those around them."""
        core, size = piece.core, len(piece.road_test.time)
        parts = [
            samples_of(self.model, rows_of(piece.road_test, low, high), self.assumed, self.ends)
            for low, high in ((0, core.start), (core.start, core.stop), (core.stop, size))
        ]
        leakage = np.concatenate([part.series.total for part in parts])
        capacities = [part.pump_capacity for part in parts if part.pump_capacity is not None]
        return parts[1], leakage, np.concatenate(capacities) if capacities else None

    def _extremes(self, piece: CountedPiece, leakage: np.ndarray, capacity: np.ndarray | None) -> SeriesExtremes:
        part, origin = piece.road_test, float(self.log.time[0])
        clock = clock_of(part.time, part.segments, self.window, origin, int(piece.stretch[0]) - 1)
        return SeriesExtremes(
            part.time, leakage, capacity, part.segments, self.window, clock=clock, core=piece.core, first=piece.first
        )

    def _add_volumes(self, piece: CountedPiece, samples: RoadSamples) -> None:
        """Add what the sections leak; the time to the next sample may lead into another stretch of the log."""
        begin, end = piece.first + piece.core.start, piece.first + piece.core.stop
        time = self.log.time[begin : end + 1]
        steps = np.diff(time) if end < len(self.log) else np.diff(time, append=np.nan)
        for name, flow in samples.series.sections.items():
            self.volumes[name].append(volume_of(flow, steps, self.log.usual_step))

    def _add_ranges(self, piece: CountedPiece, samples: RoadSamples) -> None:
        part, circuits = rows_of(piece.road_test, piece.core.start, piece.core.stop), self.model.controller.circuits
        starting = within(part.time, piece.near(self.starts)) if circuits else np.empty(0, bool)
        for circuit in circuits:
            found = range_of(circuit, part, samples, starting)
            if found is not None:
                row = piece.first + piece.core.start + found.sample
                self._ranges[circuit.id].append(replace(found, sample=row))


class _Bands:
    """The classes of temperature, as they grow from piece to piece."""

    def __init__(self, whole: _Whole, limits: Steps, unworn: LeakageModel | None) -> None:
        self.whole, self.limits, self.unworn = whole, limits, unworn
        self.sums = TemperatureSums()
        head = whole.log.head
        self.logged = head.channel("atf_temperature") is not None
        pressure = head.channel("main_pressure")
        self.gauged = pressure is not None and pressure.source == "logged"

    def add(self, piece: CountedPiece, samples: RoadSamples) -> None:
        if not self.logged:
            return
        capacity, leakage = samples.pump_capacity, samples.series.total
        share = None if capacity is None else share_of(leakage, capacity)
        self.sums.add(
            seconds=piece.counted.steps[piece.core],
            temperature=samples.temperature,
            leakage=leakage,
            share=share,
            pressure=samples.main if self.gauged else None,
            bands=None if share is None or capacity is None else self._bands(samples, share, capacity),
        )

    def _bands(self, samples: RoadSamples, share: np.ndarray, capacity: np.ndarray) -> np.ndarray | None:
        if self.unworn is None:
            return None
        channels = samples.main, samples.converter, samples.temperature, samples.gear
        new = leakage_series(self.unworn, *channels, assumed=self.whole.assumed, ends=self.whole.ends).total
        return bands_of(share, share_of(new, capacity), self.limits)
