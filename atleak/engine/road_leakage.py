"""Compute leakage and pump flow over a road test: for every sample, and at the instants worth knowing."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from atleak.catalogue.circuits import Circuit
from atleak.catalogue.controller import Controller
from atleak.catalogue.operating_point import OperatingPoint
from atleak.engine.extremes import Extremes, Instant, first_largest, share_of, sustained_window
from atleak.engine.leakage import LeakageModel
from atleak.engine.road_samples import RoadSamples, hottest, said_of_assumed, said_of_samples, samples_of
from atleak.errors import Message
from atleak.events import Thresholds, engine_starts
from atleak.events.event import within
from atleak.road_test import RoadTest
from atleak.sentence import Sentence

_FIELDS = {"atf_temperature": "temperature"}  # a log's quantity → the field of a condition, where they differ


@dataclass(frozen=True)
class CircuitRange:
    """What pressure a circuit holds while it is applied and the engine turns, the moments after a start apart."""

    lowest: float  # [Pa]
    mean: float  # [Pa] over the samples
    sample: int  # of the lowest
    time: float  # [s] of it
    samples: int  # that count
    circuit: Circuit
    main_pressure: float  # [Pa] measured where it is lowest


@dataclass(frozen=True)
class RoadLeakage:
    """Leakage over a road test; arrays have shape (samples,) and are NaN where a channel was not usable."""

    road_test: RoadTest
    assumed: OperatingPoint  # from which comes what the log does not hold
    time: np.ndarray  # [s]
    leakage: np.ndarray  # [m³/s]
    sections: dict[str, np.ndarray]  # [m³/s] of sections and circuits
    circuits: dict[str, np.ndarray]  # [Pa] the pressure that each holds at the measured line pressure, 0 where vented
    circuit_ranges: dict[str, CircuitRange]  # of those that the log applies
    pump_capacity: np.ndarray | None  # [m³/s]
    gears: tuple[int, ...]
    section_shares: dict[str, float | None]  # of the volume leaked
    extremes: Extremes  # without the moments after a start of the engine
    start: Extremes | None  # of those moments; None where the log has none
    lower_bound: bool  # whether hotter samples were left out, so that the true largest leakage may be larger
    messages: tuple[Message, ...]

    @property
    def share(self) -> np.ndarray | None:
        """Return leakage / pump capacity of every sample; NaN where the pump stands."""
        return None if self.pump_capacity is None else share_of(self.leakage, self.pump_capacity)

    @property
    def instants(self) -> tuple[Instant, ...]:
        """Return every extreme there is, also of the moments after a start."""
        return (*self.extremes.instants, *(self.start.instants if self.start else ()))

    def condition_at(self, instant: Instant) -> OperatingPoint:
        """Return the pressures, temperature, gear and speed of an instant's sample."""
        logged: dict[str, Any] = {}
        for quantity in ("main_pressure", "converter_pressure", "atf_temperature", "engine_speed", "gear"):
            values = self.road_test.values(quantity)
            if values is not None and np.isfinite(values[instant.sample]):
                logged[_FIELDS.get(quantity, quantity)] = float(values[instant.sample])
        return replace(
            self.assumed,
            name=f"sample_{instant.sample}",
            label=f"{instant.time:.2f} s of {self.road_test.file}",
            gear=int(logged.pop("gear", self.assumed.gear)),
            source=f"sample {instant.sample + 1} of the log",
            values_of=self.assumed.like,
            **logged,
        )

    @property
    def max_leakage(self) -> Instant:
        """Return the sample with the largest leakage, the moments after a start apart."""
        return self.extremes.max_leakage

    @property
    def min_leakage(self) -> Instant:
        """Return the sample with the smallest leakage, the moments after a start apart."""
        return self.extremes.min_leakage

    @property
    def max_share(self) -> Instant | None:
        """Return the sample with the largest share, the moments after a start apart; None where no sample has one."""
        return self.extremes.max_share


def evaluate_road_test(model: LeakageModel, road_test: RoadTest, assumed: OperatingPoint) -> RoadLeakage:
    """Compute leakage and pump flow of every sample of a road test.

    Parameters
    ----------
    model
        controller with its clearances, fluid and profile.
    road_test
        needs main pressure. Converter pressure, temperature and gear are taken from ``assumed`` where the log has
        none, and a message says so; without engine speed there is no pump capacity and no share.

    Raises
    ------
    RoadTestError
        where the log has no main pressure, no usable column or sample of it, or only negative ones: it says which.
    """
    samples = samples_of(model, road_test, assumed)
    series, capacity = samples.series, samples.pump_capacity
    hotter = int(np.count_nonzero((samples.temperature > hottest(model)) & (samples.main > 0.0)))
    messages = [*said_of_assumed(road_test, assumed), *said_of_samples(model, samples, hotter)]
    starts = engine_starts(road_test)
    starting = within(road_test.time, starts)
    extremes, start = _extremes(road_test, samples, starting & samples.known, len(starts), messages)
    return RoadLeakage(
        road_test=road_test,
        assumed=assumed,
        time=road_test.time,
        leakage=series.total,
        sections=series.sections,
        circuits=series.circuits,
        circuit_ranges=_circuit_ranges(model.controller, road_test, samples, starting),
        pump_capacity=capacity,
        gears=tuple(sorted({int(number) for number in np.unique(samples.gear[samples.known])})),
        section_shares=_section_shares(series.sections, road_test.time),
        extremes=extremes,
        start=start,
        lower_bound=hotter > 0,
        messages=tuple(messages),
    )


def _extremes(
    road_test: RoadTest, samples: RoadSamples, starting: np.ndarray, starts: int, messages: list[Message]
) -> tuple[Extremes, Extremes | None]:
    """Return the extremes without the moments after a start of the engine, and those of these moments."""
    window, leakage = sustained_window(road_test), samples.series.total

    def of(counting: np.ndarray) -> Extremes:
        return Extremes(road_test.time, counting, samples.pump_capacity, road_test.segments, window)

    if not starting.any():
        return of(leakage), None
    turning = np.asarray(road_test.values("engine_speed")) >= Thresholds.engine_standing
    alone = not (samples.known & turning & ~starting).any()
    messages.append(_said_of_starts(starts, int(np.count_nonzero(starting)), alone=alone))
    if alone:
        return of(leakage), None
    return of(np.where(starting, np.nan, leakage)), of(np.where(starting, leakage, np.nan))


def _said_of_starts(count: int, samples: int, *, alone: bool) -> Message:
    """Say that the moments after the starts of the engine are given apart, or that there are no others."""
    if alone:
        text = Sentence(
            "The engine turns only in its start, which ends {seconds:g} s after the engine runs: the extremes are "
            "those of the start.",
            seconds=Thresholds.start_seconds,
        )
        return Message("warning", "start_alone", text)
    counts = {"samples": samples, "seconds": Thresholds.start_seconds}
    if count > 1:
        text = Sentence(
            "The engine is started {count} times in this log: the extremes of {samples} samples until {seconds:g} s "
            "after the engine runs are given apart.",
            count=count,
            **counts,
        )
    else:
        text = Sentence(
            "The engine is started 1 time in this log: the extremes of {samples} samples until {seconds:g} s after the "
            "engine runs are given apart.",
            **counts,
        )
    return Message("info", "start_apart", text)


def _circuit_ranges(
    controller: Controller, road_test: RoadTest, samples: RoadSamples, starting: np.ndarray
) -> dict[str, CircuitRange]:
    """Return the lowest and mean pressure of every circuit that the log applies, with the engine running."""
    counting, speed = ~starting, road_test.values("engine_speed")
    if speed is not None:
        counting &= speed >= Thresholds.engine_standing
    ranges = {}
    for circuit in controller.circuits:
        pressure = samples.series.circuits[circuit.id]
        here = np.flatnonzero(counting & np.isfinite(pressure) & np.isin(samples.gear, list(circuit.gears)))
        if here.size:
            held = pressure[here]
            at = int(here[first_largest(-held)])
            lowest, mean, main = float(pressure[at]), float(held.mean()), float(samples.main[at])
            ranges[circuit.id] = CircuitRange(lowest, mean, at, float(road_test.time[at]), here.size, circuit, main)
    return ranges


def _section_shares(sections: dict[str, np.ndarray], time: np.ndarray) -> dict[str, float | None]:
    """Return each section's part of the volume leaked; None where nothing leaks.

    A sample stands for the time to the next one; where the log pauses or ends, for the usual step, or a second where
    there is none.
    """
    steps = np.diff(time, append=np.nan)
    forward = steps[steps > 0.0]
    usual = float(np.median(forward)) if forward.size else 1.0
    steps = np.where((steps > 0.0) & (steps <= 10.0 * usual), steps, usual)
    volumes = {name: float(np.nansum(flow * steps)) for name, flow in sections.items()}
    total = sum(volumes.values())
    return {name: volume / total if total > 0.0 else None for name, volume in volumes.items()}
