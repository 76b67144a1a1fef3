"""Compute leakage and pump flow over a road test: for every sample, and at the instants worth knowing."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from atleak.catalogue.circuits import Circuit
from atleak.catalogue.controller import Controller
from atleak.catalogue.operating_point import OperatingPoint
from atleak.engine.extremes import Extremes, Instant, SeriesExtremes, first_largest, share_of, sustained_window
from atleak.engine.leakage import LeakageModel
from atleak.engine.road_samples import RoadSamples, Tally, refuse_without_pressure, said_of_assumed, samples_of
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
        return condition_of(self.road_test, instant.sample, instant, self.assumed)

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


def condition_of(road_test: RoadTest, row: int, instant: Instant, assumed: OperatingPoint) -> OperatingPoint:
    """Return the pressures, temperature, gear and speed of an instant, whose sample is a row of a road test."""
    logged: dict[str, Any] = {}
    for quantity in ("main_pressure", "converter_pressure", "atf_temperature", "engine_speed", "gear"):
        values = road_test.values(quantity)
        if values is not None and np.isfinite(values[row]):
            logged[_FIELDS.get(quantity, quantity)] = float(values[row])
    label = f"{instant.time:.2f} s of {road_test.file}"
    gear = int(logged.pop("gear", assumed.gear))
    source = f"sample {instant.sample + 1} of the log"
    name = f"sample_{instant.sample}"
    return replace(assumed, name=name, label=label, gear=gear, source=source, values_of=assumed.like, **logged)


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
    refuse_without_pressure(road_test, *ends_of(road_test.values("main_pressure")))
    samples, tally = samples_of(model, road_test, assumed), Tally()
    tally.add(model, samples)
    tally.refuse_nothing_known(model, road_test.file)
    series, capacity = samples.series, samples.pump_capacity
    messages = [*said_of_assumed(road_test, assumed), *tally.messages(model, with_speed=capacity is not None)]
    extremes, start = _extremes(road_test, series.total, capacity, messages)
    return RoadLeakage(
        road_test=road_test,
        assumed=assumed,
        time=road_test.time,
        leakage=series.total,
        sections=series.sections,
        circuits=series.circuits,
        circuit_ranges=_circuit_ranges(model.controller, road_test, samples),
        pump_capacity=capacity,
        gears=tuple(sorted(tally.gears)),
        section_shares=_section_shares(series.sections, road_test.time),
        extremes=extremes,
        start=start,
        lower_bound=tally.hotter > 0,
        messages=tuple(messages),
    )


def ends_of(values: np.ndarray | None) -> tuple[float, float]:
    """Return the lowest and highest of some values, NaN left out; NaN where there are none."""
    if values is None:
        return np.nan, np.nan
    return float(np.fmin.reduce(values, initial=np.nan)), float(np.fmax.reduce(values, initial=np.nan))


def _extremes(
    road_test: RoadTest, leakage: np.ndarray, capacity: np.ndarray | None, messages: list[Message]
) -> tuple[Extremes, Extremes | None]:
    """Return the extremes without the moments after a start of the engine, and those of these moments."""
    window = sustained_window(road_test)

    def of(counting: np.ndarray) -> Extremes:
        return SeriesExtremes(road_test.time, counting, capacity, road_test.segments, window)

    starts = engine_starts(road_test)
    starting = within(road_test.time, starts) & np.isfinite(leakage)
    if not starting.any():
        return of(leakage), None
    alone = not turning_apart(road_test, leakage, starting).any()
    messages.append(said_of_starts(len(starts), int(np.count_nonzero(starting)), alone=alone))
    if alone:
        return of(leakage), None
    return of(np.where(starting, np.nan, leakage)), of(np.where(starting, leakage, np.nan))


def turning_apart(road_test: RoadTest, leakage: np.ndarray, starting: np.ndarray) -> np.ndarray:
    """Return at which samples with a leakage the engine turns, its starts apart."""
    turning = np.asarray(road_test.values("engine_speed")) >= Thresholds.engine_standing
    apart: np.ndarray = np.isfinite(leakage) & turning & ~starting
    return apart


def said_of_starts(count: int, samples: int, *, alone: bool) -> Message:
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


def _circuit_ranges(controller: Controller, road_test: RoadTest, samples: RoadSamples) -> dict[str, CircuitRange]:
    """Return the lowest and mean pressure of every circuit that the log applies, with the engine running."""
    ranges = {}
    starting = within(road_test.time, engine_starts(road_test)) if controller.circuits else np.empty(0, bool)
    for circuit in controller.circuits:
        found = range_of(circuit, road_test, samples, starting)
        if found is not None:
            ranges[circuit.id] = found
    return ranges


def range_of(circuit: Circuit, road_test: RoadTest, samples: RoadSamples, starting: np.ndarray) -> CircuitRange | None:
    """Return what a circuit holds while it is applied and the engine runs; None where it never does.

    ``starting`` says which samples lie in a start of the engine.
    """
    pressure, counting = samples.series.circuits[circuit.id], ~starting
    speed = road_test.values("engine_speed")
    if speed is not None:
        counting &= speed >= Thresholds.engine_standing
    here = np.flatnonzero(counting & np.isfinite(pressure) & np.isin(samples.gear, list(circuit.gears)))
    if not here.size:
        return None
    held = pressure[here]
    at = int(here[first_largest(-held)])
    lowest, mean = float(pressure[at]), float(held.mean())
    return CircuitRange(lowest, mean, at, float(road_test.time[at]), here.size, circuit, float(samples.main[at]))


def _section_shares(sections: dict[str, np.ndarray], time: np.ndarray) -> dict[str, float | None]:
    """Return each section's part of the volume leaked."""
    steps = np.diff(time, append=np.nan)
    forward = steps[steps > 0.0]
    usual = float(np.median(forward)) if forward.size else np.nan
    return shares_of({name: volume_of(flow, steps, usual) for name, flow in sections.items()})


def volume_of(flow: np.ndarray, steps: np.ndarray, usual: float) -> float:
    """Return the volume that some samples leak.

    A sample stands for the time to the next one; where the log pauses or ends, for the usual step, or a second where
    there is none.
    """
    usual = usual if usual > 0.0 else 1.0
    steps = np.where((steps > 0.0) & (steps <= 10.0 * usual), steps, usual)
    return float(np.nansum(flow * steps))


def shares_of(volumes: dict[str, float]) -> dict[str, float | None]:
    """Return each section's part of the volume; None where there is none."""
    total = sum(volumes.values())
    return {name: volume / total if total > 0.0 else None for name, volume in volumes.items()}
