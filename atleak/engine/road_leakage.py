"""Compute leakage and pump flow over a road test: for every sample, and at the instants worth knowing.

What has to be assumed or left out is said; main pressure that is not logged can be that of the operating points, by
gear and state.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from types import MappingProxyType
from typing import Any

import numpy as np

from atleak.catalogue.circuits import Circuit
from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_tables import State
from atleak.catalogue.operating_point import IDLE_SPEED, OperatingPoint
from atleak.common.errors import Message, MessageLevel, Place, RoadTestError, translates_refusals
from atleak.common.printable import brief
from atleak.common.sentences import Name, Sentence, counted, in_a_row
from atleak.common.units import KPA, Quantity, gear_name
from atleak.engine.extremes import Extremes, Instant, first_largest, share_of_samples, sustained_window
from atleak.engine.leakage import LeakageModel
from atleak.engine.series import LeakageSeries, leakage_series
from atleak.measurements.events import Thresholds, engine_starts
from atleak.measurements.events.event import within_span
from atleak.measurements.road_test import Channel, RoadTest


@dataclass(frozen=True)
class RoadSamples:
    """Channels, leakage and pump flow of some samples; arrays of shape (samples,), NaN where not known."""

    main: np.ndarray  # [Pa]
    converter: np.ndarray  # [Pa]
    temperature: np.ndarray  # [°C]
    gear: np.ndarray
    series: LeakageSeries
    pump_capacity: np.ndarray | None  # [m³/s]; None without an engine speed

    @cached_property
    def usable(self) -> np.ndarray:
        """Return which samples have a leakage."""
        return np.isfinite(self.series.total)


def channels_of(road_test: RoadTest, assumed: OperatingPoint) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return main and converter pressure [Pa], temperature [°C] and gear of every sample.

    What the log does not hold is that of the operating point, but for main pressure, which is then not known.
    """
    instead = {
        "main_pressure": np.nan,
        "converter_pressure": assumed.converter_pressure,
        "atf_temperature": assumed.temperature,
        "gear": float(assumed.gear),
    }
    main, converter, temperature, gear = (
        np.full(len(road_test.time), value) if (logged := road_test.values(quantity)) is None else logged
        for quantity, value in instead.items()
    )
    return main, converter, temperature, gear


def samples_of(model: LeakageModel, road_test: RoadTest, assumed: OperatingPoint) -> RoadSamples:
    """Compute leakage and pump flow of every sample of a log.

    Raises
    ------
    RoadTestError
        where no main pressure can be used, or no sample has a leakage: it says why.
    """
    _refuse_without_pressure(road_test)
    main, converter, temperature, gear = channels_of(road_test, assumed)
    series = leakage_series(model, main, converter, temperature, gear, sections=True, assumed=assumed)
    speed = road_test.values("engine_speed")
    capacity = None if speed is None else np.asarray(model.pump_capacity(speed, main, temperature), dtype=float)
    samples = RoadSamples(main, converter, temperature, gear, series, capacity)
    if not samples.usable.any():
        raise _nothing_known(model, series, road_test.file)
    return samples


def _refuse_without_pressure(road_test: RoadTest) -> None:
    values = road_test.values("main_pressure")
    values = np.empty(0) if values is None else values[~np.isnan(values)]
    why = road_test.refused.get("main_pressure")
    if road_test.channel("main_pressure") is None:
        missing = Sentence("the log has no main pressure")
        if why is not None:
            missing = Sentence("the log's column of main pressure is not usable: {why}", why=why)
    elif not values.size:
        missing = Sentence("the log has no usable sample of main pressure")
    elif not values.max() >= 0.0:
        missing = Sentence(
            "main pressure is below zero throughout this log ({low:.4g} to {high:.4g} {high.unit})",
            low=Quantity(float(values.min()) * KPA, "pressure"),
            high=Quantity(float(values.max()) * KPA, "pressure"),
        )
    else:
        return
    raise RoadTestError(
        Sentence("{missing}; without it leakage cannot be computed", missing=missing),
        place=Place(file=road_test.file),
        expected=Sentence("a column p_g [kPa] (or bar, psi) with the pressure above that of the surrounding air"),
    )


def assumption_messages(road_test: RoadTest, assumed: OperatingPoint) -> Iterator[Message]:
    """Say which channels the log does not hold, and what is taken for them."""
    if (pressure := road_test.channel("main_pressure")) is not None and pressure.source == "constant":
        text = Sentence(
            "Main pressure is not logged: {pressure:g} {pressure.unit} are assumed for all of it. No loss of pressure "
            "shows in it, and leakage and share over the log are estimates.",
            pressure=Quantity(float(pressure.values[0]) * KPA, "pressure"),
        )
        yield Message("warning", "pressure_assumed", text)
    instead = {
        "converter_pressure": Sentence(
            "The log has no converter pressure: {pressure:g} {pressure.unit} ({condition}) is assumed for all of it.",
            pressure=Quantity(assumed.converter_pressure * KPA, "pressure"),
            condition=assumed,
        ),
        "atf_temperature": Sentence(
            "The log has no atf temperature: {temperature:g} {temperature.unit} ({condition}) is assumed for all of "
            "it.",
            temperature=Quantity(assumed.temperature, "temperature"),
            condition=assumed,
        ),
        "gear": Sentence(
            "The log has no gear: gear {gear} ({condition}) is assumed for all of it.",
            gear=gear_name(assumed.gear),
            condition=assumed,
        ),
    }
    for quantity, text in instead.items():
        if road_test.channel(quantity) is None:
            yield Message("warning", f"assumed_{quantity}", text)


def _nothing_known(model: LeakageModel, series: LeakageSeries, file: str) -> RoadTestError:
    low, high = model.fluid.span(model.profile.viscosity)
    return RoadTestError(
        Sentence(
            "no sample of the log has usable values of pressure, temperature and gear together ({other_gear} in a "
            "gear this valve body does not have, {outside} at a temperature outside the fluid's data)",
            other_gear=series.other_gear,
            outside=series.outside_fluid,
        ),
        place=Place(file=file),
        expected=Sentence(
            "gears {gears}, temperatures from {low:g} to {high:g} {high.unit}",
            gears=tuple(map(gear_name, model.controller.gears)),
            low=Quantity(low, "temperature"),
            high=Quantity(high, "temperature"),
        ),
    )


def sample_messages(model: LeakageModel, samples: RoadSamples, hotter: int) -> Iterator[Message]:
    """Say what of a log was left out, and what does not hold everywhere; ``hotter`` samples are so than the fluid."""
    capacity, total, size = samples.pump_capacity, samples.series.total, len(samples.main)
    if capacity is None:
        text = Sentence("The log has no engine speed: pump capacity and share over the log are not known.")
        yield Message("warning", "no_engine_speed", text)
    elif no_delivery := int(np.count_nonzero((capacity <= 0.0) & (total > 0.0))):
        text = Sentence(
            "In {count} of {samples} samples the pump delivers nothing while pressure stands: no sample of this log "
            "has a share."
        )
        if (share_of_samples(total, capacity) >= 0.0).any():
            text = Sentence(
                "In {count} of {samples} samples the pump delivers nothing while pressure stands: no share can be "
                "given there, and the largest share is that of the other samples."
            )
        yield Message("warning", "pump_delivers_nothing", text.of(count=no_delivery, samples=size))
    yield from _left_out(model, samples)
    if hotter:
        text = Sentence(
            "{count} of the samples left out are hotter than {hottest:g} {hottest.unit}: the largest leakage and "
            "share of this log are lower bounds.",
            count=hotter,
            hottest=Quantity(hottest(model), "temperature"),
        )
        yield Message("warning", "lower_bound", text)
    for section, above in model.controller.above_main(samples.main).items():
        if count := int(np.count_nonzero(above)):
            text = Sentence(
                "In {count} of {samples} samples {section} would be above main pressure, where its relation does "
                "not hold: its leakage there is too high.",
                count=count,
                samples=size,
                section=section,
            )
            yield Message("warning", "pressure_relation", text)


def _left_out(model: LeakageModel, samples: RoadSamples) -> Iterator[Message]:
    series, size = samples.series, len(samples.main)
    for section, count in series.reversed_samples.items():
        if count:
            text = Sentence(
                "In {count} of {size} samples a pressure drop of section {section} is negative and counts as no "
                "leakage.",
                count=count,
                size=size,
                section=section,
            )
            yield Message("warning", "reversed_pressure_drop", text)
    low, high = (Quantity(end, "temperature") for end in model.fluid.span(model.profile.viscosity))
    values = {
        "gears": tuple(map(gear_name, model.controller.gears)),
        "fluid": Name(model.fluid.name),
        "low": low,
        "high": high,
    }
    missing = size - int(np.count_nonzero(samples.usable)) - series.other_gear - series.outside_fluid
    met: tuple[tuple[int, MessageLevel, str, Sentence], ...] = (
        (series.unbalanced, "warning", "circuits_not_balanced", Sentence(
            "In {count} of {size} samples no pressures were found at which all circuits balance."
        )),
        (series.other_gear, "warning", "other_gear", Sentence(
            "{count} of {size} samples are in no gear of this valve body ({gears}) and are left out."
        )),
        (series.outside_fluid, "warning", "outside_fluid", Sentence(
            "{count} of {size} samples are at a temperature outside the data of {fluid} ({low:g} to {high:g} "
            "{high.unit}) and are left out."
        )),
        (missing, "info", "samples_left_out", Sentence(
            "{count} of {size} samples lack a usable value of pressure, temperature or gear and are left out."
        )),
    )  # fmt: skip
    for count, level, code, text in met:
        if count > 0:
            yield Message(level, code, text.of(count=count, size=size, **values))


def hottest(model: LeakageModel) -> float:
    """Return the highest temperature that the fluid's data cover [°C]."""
    return float(model.fluid.span(model.profile.viscosity)[1])


_FIELDS = {"atf_temperature": "temperature"}  # a log's quantity → the field of a condition, where they differ


@dataclass(frozen=True)
class CircuitRange:
    """What pressure a circuit holds while it is applied and the engine turns, the moments after a start apart."""

    lowest: float  # [Pa]
    mean: float  # [Pa] over the samples
    sample: int  # of the lowest
    time: float  # [s] of it
    samples: int  # that count
    circuit: Circuit  # as the controller's file describes it
    main_pressure: float  # [Pa] measured where it is lowest


@brief
@dataclass(frozen=True)
class RoadLeakage:
    """Leakage over a road test; arrays have shape (samples,) and are NaN where a channel was not usable."""

    road_test: RoadTest  # over which it was computed
    assumed: OperatingPoint  # from which comes what the log does not hold
    time: np.ndarray  # [s]
    leakage: np.ndarray  # [m³/s]
    sections: dict[str, np.ndarray]  # [m³/s] of sections and circuits
    circuits: dict[str, np.ndarray]  # [Pa] the pressure that each holds at the measured line pressure, 0 where vented
    circuit_ranges: dict[str, CircuitRange]  # of those that the log applies
    pump_capacity: np.ndarray | None  # [m³/s]
    gears: tuple[int, ...]  # for which it was computed
    section_shares: dict[str, float | None]  # of the volume leaked
    extremes: Extremes  # without the moments after a start of the engine
    start: Extremes | None  # of those moments; None where the log has none
    lower_bound: bool  # whether hotter samples were left out, so that the true largest leakage may be larger
    messages: tuple[Message, ...]  # what a reader must know of it

    @property
    def share(self) -> np.ndarray | None:
        """Return leakage / pump capacity of every sample; NaN where the pump stands."""
        return None if self.pump_capacity is None else share_of_samples(self.leakage, self.pump_capacity)

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


@translates_refusals
def evaluate_road_test(model: LeakageModel, road_test: RoadTest, assumed: OperatingPoint) -> RoadLeakage:
    """Compute leakage and pump flow of every sample of a road test.

    Parameters
    ----------
    road_test
        needs main pressure; without engine speed there is no pump capacity and no share.
    assumed
        stands for converter pressure, temperature and gear where the log has none; a message says so.

    Returns
    -------
    RoadLeakage
        arrays of shape (samples,), flows [m³/s].

    Raises
    ------
    RoadTestError
        where the log has no main pressure, no usable column or sample of it, or only negative ones: it says which.
    """
    samples = samples_of(model, road_test, assumed)
    series, capacity = samples.series, samples.pump_capacity
    hotter = int(np.count_nonzero((samples.temperature > hottest(model)) & (samples.main > 0.0)))
    messages = [*assumption_messages(road_test, assumed), *sample_messages(model, samples, hotter)]
    starts = engine_starts(road_test)
    starting = within_span(road_test.time, starts)
    extremes, start = _extremes(road_test, samples, starting & samples.usable, len(starts), messages)
    return RoadLeakage(
        road_test=road_test,
        assumed=assumed,
        time=road_test.time,
        leakage=series.total,
        sections=series.sections,
        circuits=series.circuits,
        circuit_ranges=_circuit_ranges(model.controller, road_test, samples, starting),
        pump_capacity=capacity,
        gears=tuple(sorted({int(number) for number in np.unique(samples.gear[samples.usable])})),
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
    alone = not (samples.usable & turning & ~starting).any()
    messages.append(_start_message(starts, int(np.count_nonzero(starting)), alone=alone))
    if alone:
        return of(leakage), None
    return of(np.where(starting, np.nan, leakage)), of(np.where(starting, leakage, np.nan))


def _start_message(count: int, samples: int, *, alone: bool) -> Message:
    """Say that the moments after the starts of the engine are given apart, or that there are no others."""
    if alone:
        text = Sentence(
            "The engine turns only in its start, which ends {seconds:g} s after the engine runs: the extremes are "
            "those of the start.",
            seconds=Thresholds.start_seconds,
        )
        return Message("warning", "start_alone", text)
    text = counted(
        count,
        "The engine is started 1 time in this log: the extremes of {samples} samples until {seconds:g} s after the "
        "engine runs are given apart.",
        "The engine is started {count} times in this log: the extremes of {samples} samples until {seconds:g} s "
        "after the engine runs are given apart.",
        samples=samples,
        seconds=Thresholds.start_seconds,
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


OPERATING_POINTS = "operating_points"
"""In place of a constant main pressure: that of the valve body's operating points."""


def with_assumed_pressure(controller: Controller, road_test: RoadTest) -> RoadTest:
    """Return the road test with a main pressure that is assumed by the gear and state of every sample.

    Idle is an engine speed under `IDLE_SPEED`. A gear of which no operating point is stated has the pressure of the
    nearest gear in the same state. Without a logged gear or speed the first operating point's stands for it.

    Parameters
    ----------
    road_test
        returned as it is where it holds a main pressure, with a message that nothing was assumed.
    """
    if road_test.channel("main_pressure") is not None:
        text = Sentence("The log has a main pressure: none is assumed from the valve body's operating points.")
        message = Message("warning", "pressure_not_assumed", text)
        return replace(road_test, messages=(*road_test.messages, message))
    points, used = controller.operating_points, dict[tuple[float, int], OperatingPoint]()
    first, count = points[0], len(road_test.time)
    gear, speed = road_test.values("gear"), road_test.values("engine_speed")
    gears = np.full(count, float(first.gear)) if gear is None else np.nan_to_num(gear, nan=float(first.gear))
    idle = np.full(count, first.state == "idle") if speed is None else speed < IDLE_SPEED
    pressure = np.full(count, np.nan)
    for each in np.unique(gears).tolist():
        for rank, there in enumerate((idle, ~idle)):
            here = there & (gears == each)
            if here.any():
                used[each, rank] = _nearest(points, int(each), "driving" if rank else "idle")
                pressure[here] = used[each, rank].main_pressure
    channel = Channel("main_pressure", road_test.time, pressure, np.zeros(len(pressure), bool), source="derived")
    messages = (*road_test.messages, _assumed_pressures([used[key] for key in sorted(used)]))
    channels = MappingProxyType({**road_test.channels, "main_pressure": channel})
    return replace(road_test, channels=channels, messages=messages, _held={})


def _nearest(points: Sequence[OperatingPoint], gear: int, state: State) -> OperatingPoint:
    """Return the operating point of this state, or else of any other, whose gear is nearest."""
    return min(points, key=lambda point: (point.state != state, abs(point.gear - gear)))


def _assumed_pressures(points: Sequence[OperatingPoint]) -> Message:
    parts = [
        Sentence(
            "{pressure:g} {pressure.unit} ({condition})",
            pressure=Quantity(point.main_pressure * KPA, "pressure"),
            condition=point,
        )
        for point in dict.fromkeys(points)
    ]
    text = Sentence(
        "Main pressure is not logged: that of the valve body's operating points is assumed by gear and engine speed: "
        "{points}. No loss of pressure shows in it, and leakage and share over the log are estimates.",
        points=in_a_row(parts),
    )
    return Message("warning", "pressure_assumed", text)
