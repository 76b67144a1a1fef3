"""Compute leakage and pump flow over a road test: for every sample, and at the instants worth knowing."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from atleak.catalogue.circuits import Circuit
from atleak.catalogue.controller import Controller, OperatingPoint
from atleak.engine.extremes import Extremes, Instant, share_of, sustained_window
from atleak.engine.leakage import LeakageModel
from atleak.engine.series import LeakageSeries, leakage_series
from atleak.errors import Message, Place, RoadTestError
from atleak.events import Event, Thresholds, engine_starts
from atleak.road_test import RoadTest
from atleak.sentence import Name, Sentence
from atleak.unit_systems import Quantity
from atleak.workshop_units import KPA

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
        label = f"{instant.time:.2f} s of {self.road_test.file}"
        gear = int(logged.pop("gear", self.assumed.gear))
        source = f"sample {instant.sample + 1} of the log"
        name, like = f"sample_{instant.sample}", self.assumed.like
        return replace(self.assumed, name=name, label=label, gear=gear, source=source, values_of=like, **logged)

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
    main = _main_pressure(road_test)
    messages: list[Message] = []
    if (pressure := road_test.channel("main_pressure")) is not None and pressure.source == "constant":
        text = Sentence(
            "Main pressure is not logged: {pressure:g} {pressure.unit} are assumed for all of it. No loss of pressure "
            "shows in it, and leakage and share over the log are estimates.",
            pressure=Quantity(float(pressure.values[0]) * KPA, "pressure"),
        )
        messages.append(Message("warning", "pressure_assumed", text))

    def channel(quantity: str, value: float, text: Sentence) -> np.ndarray:
        values = road_test.values(quantity)
        if values is not None:
            return values
        messages.append(Message("warning", f"assumed_{quantity}", text))
        return np.full(len(road_test.time), value)

    converter = channel(
        "converter_pressure",
        assumed.converter_pressure,
        Sentence(
            "The log has no converter pressure: {pressure:g} {pressure.unit} ({condition}) is assumed for all of it.",
            pressure=Quantity(assumed.converter_pressure * KPA, "pressure"),
            condition=assumed,
        ),
    )
    temperature = channel(
        "atf_temperature",
        assumed.temperature,
        Sentence(
            "The log has no atf temperature: {temperature:g} {temperature.unit} ({condition}) is assumed for all of "
            "it.",
            temperature=Quantity(assumed.temperature, "temperature"),
            condition=assumed,
        ),
    )
    gear = channel(
        "gear",
        float(assumed.gear),
        Sentence(
            "The log has no gear: gear {gear} ({condition}) is assumed for all of it.",
            gear=assumed.gear,
            condition=assumed,
        ),
    )
    series = leakage_series(model, main, converter, temperature, gear, sections=True, assumed=assumed)
    if not np.isfinite(series.total).any():
        low, high = model.fluid.span(model.profile.viscosity)
        raise RoadTestError(
            Sentence(
                "no sample of the log has usable values of pressure, temperature and gear together ({other_gear} in a "
                "gear this valve body does not have, {outside} at a temperature outside the fluid's data)",
                other_gear=series.other_gear,
                outside=series.outside_fluid,
            ),
            place=Place(file=road_test.file),
            expected=Sentence(
                "gears {gears}, temperatures from {low:g} to {high:g} {high.unit}",
                gears=model.controller.gears,
                low=Quantity(low, "temperature"),
                high=Quantity(high, "temperature"),
            ),
        )
    speed = road_test.values("engine_speed")
    if speed is None:
        text = Sentence("The log has no engine speed: pump capacity and share over the log are not known.")
        messages.append(Message("warning", "no_engine_speed", text))
        capacity = None
    else:
        capacity = np.asarray(model.pump_capacity(speed, main, temperature), dtype=float)
        idle = int(np.count_nonzero((capacity <= 0.0) & (series.total > 0.0)))
        if idle:
            without = {"count": idle, "samples": len(road_test.time)}
            if (share_of(series.total, capacity) >= 0.0).any():
                text = Sentence(
                    "In {count} of {samples} samples the pump delivers nothing while pressure stands: no share can be "
                    "given there, and the largest share is that of the other samples.",
                    **without,
                )
            else:
                text = Sentence(
                    "In {count} of {samples} samples the pump delivers nothing while pressure stands: no sample of "
                    "this log has a share.",
                    **without,
                )
            messages.append(Message("warning", "pump_delivers_nothing", text))
    messages += _series_messages(series, len(road_test.time), model)
    hottest = model.fluid.span(model.profile.viscosity)[1]
    hotter = int(np.count_nonzero((temperature > hottest) & (main > 0.0)))
    if hotter:
        text = Sentence(
            "{count} of the samples left out are hotter than {hottest:g} {hottest.unit}: the largest leakage and share "
            "of this log are lower bounds.",
            count=hotter,
            hottest=Quantity(hottest, "temperature"),
        )
        messages.append(Message("warning", "lower_bound", text))
    for section, above in model.controller.above_main(main).items():
        if above.any():
            text = Sentence(
                "In {count} of {samples} samples {section} would be above main pressure, where its relation does not "
                "hold: its leakage there is too high.",
                count=int(np.count_nonzero(above)),
                samples=len(above),
                section=section,
            )
            messages.append(Message("warning", "pressure_relation", text))
    known_gears = gear[np.isfinite(series.total)]
    extremes, start = _extremes(road_test, series.total, capacity, messages)
    return RoadLeakage(
        road_test=road_test,
        assumed=assumed,
        time=road_test.time,
        leakage=series.total,
        sections=series.sections,
        circuits=series.circuits,
        circuit_ranges=_circuit_ranges(model.controller, road_test, series, gear, main),
        pump_capacity=capacity,
        gears=tuple(int(number) for number in np.unique(known_gears)),
        section_shares=_section_shares(series.sections, road_test.time),
        extremes=extremes,
        start=start,
        lower_bound=hotter > 0,
        messages=tuple(messages),
    )


def channels_of(
    road_test: RoadTest, assumed: OperatingPoint
) -> tuple[np.ndarray | float, np.ndarray | float, np.ndarray | float, np.ndarray | float]:
    """Return main and converter pressure [Pa], temperature [°C] and gear of a log, as far as it holds them."""
    instead = {
        "main_pressure": np.nan,
        "converter_pressure": assumed.converter_pressure,
        "atf_temperature": assumed.temperature,
        "gear": float(assumed.gear),
    }
    main, converter, temperature, gear = (
        value if (logged := road_test.values(quantity)) is None else logged for quantity, value in instead.items()
    )
    return main, converter, temperature, gear


def _main_pressure(road_test: RoadTest) -> np.ndarray:
    main, why = road_test.values("main_pressure"), road_test.refused.get("main_pressure")
    if main is None:
        missing = Sentence("the log has no main pressure")
        if why is not None:
            missing = Sentence("the log's column of main pressure is not usable: {why}", why=why)
    elif not np.isfinite(main).any():
        missing = Sentence("the log has no usable sample of main pressure")
    elif not (main >= 0.0).any():
        missing = Sentence(
            "main pressure is below zero throughout this log ({low:.4g} to {high:.4g} {high.unit})",
            low=Quantity(float(np.nanmin(main)) * KPA, "pressure"),
            high=Quantity(float(np.nanmax(main)) * KPA, "pressure"),
        )
    else:
        return main
    raise RoadTestError(
        Sentence("{missing}; without it leakage cannot be computed", missing=missing),
        place=Place(file=road_test.file),
        expected=Sentence("a column p_g [kPa] (or bar, psi) with the pressure above that of the surrounding air"),
    )


def _extremes(
    road_test: RoadTest, leakage: np.ndarray, capacity: np.ndarray | None, messages: list[Message]
) -> tuple[Extremes, Extremes | None]:
    """Return the extremes without the moments after a start of the engine, and those of these moments."""
    window = sustained_window(road_test)

    def of(counting: np.ndarray) -> Extremes:
        return Extremes(road_test.time, counting, capacity, road_test.segments, window)

    starts = engine_starts(road_test)
    starting = _within(road_test.time, starts) & np.isfinite(leakage)
    if not starting.any():
        return of(leakage), None
    turning = np.asarray(road_test.values("engine_speed")) >= Thresholds.engine_standing
    if not (np.isfinite(leakage) & turning & ~starting).any():
        text = Sentence(
            "The engine turns only in its start, which ends {seconds:g} s after the engine runs: the extremes are "
            "those of the start.",
            seconds=Thresholds.start_seconds,
        )
        messages.append(Message("warning", "start_alone", text))
        return of(leakage), None
    counts = {"samples": int(np.count_nonzero(starting)), "seconds": Thresholds.start_seconds}
    if len(starts) > 1:
        text = Sentence(
            "The engine is started {count} times in this log: the extremes of {samples} samples until {seconds:g} s "
            "after the engine runs are given apart.",
            count=len(starts),
            **counts,
        )
    else:
        text = Sentence(
            "The engine is started 1 time in this log: the extremes of {samples} samples until {seconds:g} s after the "
            "engine runs are given apart.",
            **counts,
        )
    messages.append(Message("info", "start_apart", text))
    return of(np.where(starting, np.nan, leakage)), of(np.where(starting, leakage, np.nan))


def _circuit_ranges(
    controller: Controller, road_test: RoadTest, series: LeakageSeries, gear: np.ndarray, main: np.ndarray
) -> dict[str, CircuitRange]:
    """Return the lowest and mean pressure of every circuit that the log applies, with the engine running."""
    counting = ~_within(road_test.time, engine_starts(road_test)) if series.circuits else np.array([])
    speed = road_test.values("engine_speed")
    if speed is not None and series.circuits:
        counting &= speed >= Thresholds.engine_standing
    ranges = {}
    for circuit in controller.circuits:
        pressure = series.circuits[circuit.id]
        samples = np.flatnonzero(counting & np.isfinite(pressure) & np.isin(gear, list(circuit.gears)))
        if samples.size:
            held = pressure[samples]
            at = int(samples[np.argmin(held)])
            lowest, mean = float(pressure[at]), float(held.mean())
            time, line = float(road_test.time[at]), float(main[at])
            ranges[circuit.id] = CircuitRange(lowest, mean, at, time, samples.size, circuit, line)
    return ranges


def _within(time: np.ndarray, events: list[Event]) -> np.ndarray:
    """Return which stamps lie in one of the events, ends included."""
    inside = np.zeros(len(time), bool)
    for event in events:
        inside[np.searchsorted(time, event.start) : np.searchsorted(time, event.stop, side="right")] = True
    return inside


def _section_shares(sections: dict[str, np.ndarray], time: np.ndarray) -> dict[str, float | None]:
    """Return each section's part of the volume leaked.

    A sample stands for the time to the next one; where the log pauses, for the usual step.
    """
    steps = np.diff(time, append=np.nan)
    forward = steps[steps > 0.0]
    usual = float(np.median(forward)) if forward.size else 1.0
    steps = np.where((steps > 0.0) & (steps <= 10.0 * usual), steps, usual)
    volumes = {name: float(np.nansum(flow * steps)) for name, flow in sections.items()}
    total = sum(volumes.values())
    return {name: volume / total if total > 0.0 else None for name, volume in volumes.items()}


def _series_messages(series: LeakageSeries, size: int, model: LeakageModel) -> list[Message]:
    messages = []
    for section, count in series.reversed_samples.items():
        if count:
            text = Sentence(
                "In {count} of {size} samples a pressure drop of section {section} is negative and counts as no "
                "leakage.",
                count=count,
                size=size,
                section=section,
            )
            messages.append(Message("warning", "reversed_pressure_drop", text))
    if series.unbalanced:
        text = Sentence(
            "In {count} of {size} samples no pressures were found at which all circuits balance.",
            count=series.unbalanced,
            size=size,
        )
        messages.append(Message("warning", "circuits_not_balanced", text))
    if series.other_gear:
        text = Sentence(
            "{count} of {size} samples are in no gear of this valve body ({gears}) and are left out.",
            count=series.other_gear,
            size=size,
            gears=model.controller.gears,
        )
        messages.append(Message("warning", "other_gear", text))
    if series.outside_fluid:
        low, high = model.fluid.span(model.profile.viscosity)
        text = Sentence(
            "{count} of {size} samples are at a temperature outside the data of {fluid} ({low:g} to {high:g} "
            "{high.unit}) and are left out.",
            count=series.outside_fluid,
            size=size,
            fluid=Name(model.fluid.name),
            low=Quantity(low, "temperature"),
            high=Quantity(high, "temperature"),
        )
        messages.append(Message("warning", "outside_fluid", text))
    missing = int(np.count_nonzero(~np.isfinite(series.total))) - series.other_gear - series.outside_fluid
    if missing > 0:
        text = Sentence(
            "{count} of {size} samples lack a usable value of pressure, temperature or gear and are left out.",
            count=missing,
            size=size,
        )
        messages.append(Message("info", "samples_left_out", text))
    return messages
