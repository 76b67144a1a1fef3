"""Compute leakage and pump flow of a log's samples, and say what of them had to be assumed or left out."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from atleak.catalogue.operating_point import OperatingPoint
from atleak.engine.extremes import share_of
from atleak.engine.leakage import LeakageModel
from atleak.engine.series import LeakageSeries, leakage_series
from atleak.errors import Message, Place, RoadTestError
from atleak.road_test import RoadTest
from atleak.sentence import Name, Sentence
from atleak.unit_systems import Quantity
from atleak.workshop_units import KPA


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
    def known(self) -> np.ndarray:
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
    if not samples.known.any():
        raise _nothing_known(model, series, road_test.file)
    return samples


def _refuse_without_pressure(road_test: RoadTest) -> None:
    values = road_test.values("main_pressure")
    known = np.empty(0) if values is None else values[~np.isnan(values)]
    why = road_test.refused.get("main_pressure")
    if road_test.channel("main_pressure") is None:
        missing = Sentence("the log has no main pressure")
        if why is not None:
            missing = Sentence("the log's column of main pressure is not usable: {why}", why=why)
    elif not known.size:
        missing = Sentence("the log has no usable sample of main pressure")
    elif not known.max() >= 0.0:
        missing = Sentence(
            "main pressure is below zero throughout this log ({low:.4g} to {high:.4g} {high.unit})",
            low=Quantity(float(known.min()) * KPA, "pressure"),
            high=Quantity(float(known.max()) * KPA, "pressure"),
        )
    else:
        return
    raise RoadTestError(
        Sentence("{missing}; without it leakage cannot be computed", missing=missing),
        place=Place(file=road_test.file),
        expected=Sentence("a column p_g [kPa] (or bar, psi) with the pressure above that of the surrounding air"),
    )


def said_of_assumed(road_test: RoadTest, assumed: OperatingPoint) -> Iterator[Message]:
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
            gear=assumed.gear,
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
            gears=model.controller.gears,
            low=Quantity(low, "temperature"),
            high=Quantity(high, "temperature"),
        ),
    )


def said_of_samples(model: LeakageModel, samples: RoadSamples, hotter: int) -> Iterator[Message]:
    """Say what of a log was left out, and what does not hold everywhere; ``hotter`` samples are so than the fluid."""
    capacity, total, size = samples.pump_capacity, samples.series.total, len(samples.main)
    if capacity is None:
        text = Sentence("The log has no engine speed: pump capacity and share over the log are not known.")
        yield Message("warning", "no_engine_speed", text)
    elif no_delivery := int(np.count_nonzero((capacity <= 0.0) & (total > 0.0))):
        without = {"count": no_delivery, "samples": size}
        if (share_of(total, capacity) >= 0.0).any():
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
        yield Message("warning", "pump_delivers_nothing", text)
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
    if series.unbalanced:
        text = Sentence(
            "In {count} of {size} samples no pressures were found at which all circuits balance.",
            count=series.unbalanced,
            size=size,
        )
        yield Message("warning", "circuits_not_balanced", text)
    if series.other_gear:
        text = Sentence(
            "{count} of {size} samples are in no gear of this valve body ({gears}) and are left out.",
            count=series.other_gear,
            size=size,
            gears=model.controller.gears,
        )
        yield Message("warning", "other_gear", text)
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
        yield Message("warning", "outside_fluid", text)
    missing = size - np.count_nonzero(samples.known) - series.other_gear - series.outside_fluid
    if missing > 0:
        text = Sentence(
            "{count} of {size} samples lack a usable value of pressure, temperature or gear and are left out.",
            count=int(missing),
            size=size,
        )
        yield Message("info", "samples_left_out", text)


def hottest(model: LeakageModel) -> float:
    """Return the highest temperature that the fluid's data cover [°C]."""
    return float(model.fluid.span(model.profile.viscosity)[1])
