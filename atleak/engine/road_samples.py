"""Compute leakage and pump flow of a log's samples, and say what of them had to be assumed or left out."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field

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

Ends = tuple[np.ndarray, np.ndarray, np.ndarray]
"""Lowest and highest main pressure, converter pressure and temperature of a log, as `leakage_series` has them."""


@dataclass(frozen=True)
class RoadSamples:
    """Channels, leakage and pump flow of some samples; arrays of shape (samples,), NaN where not known."""

    main: np.ndarray  # [Pa]
    converter: np.ndarray  # [Pa]
    temperature: np.ndarray  # [°C]
    gear: np.ndarray
    series: LeakageSeries
    pump_capacity: np.ndarray | None  # [m³/s]; None without an engine speed


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


def samples_of(
    model: LeakageModel, road_test: RoadTest, assumed: OperatingPoint, ends: Ends | None = None
) -> RoadSamples:
    """Compute leakage and pump flow of every sample, which may be a part of a log with these ends."""
    main, converter, temperature, gear = channels_of(road_test, assumed)
    series = leakage_series(model, main, converter, temperature, gear, sections=True, assumed=assumed, ends=ends)
    speed = road_test.values("engine_speed")
    capacity = None if speed is None else np.asarray(model.pump_capacity(speed, main, temperature), dtype=float)
    return RoadSamples(main, converter, temperature, gear, series, capacity)


def refuse_without_pressure(road_test: RoadTest, lowest: float, highest: float) -> None:
    """Refuse a log in which no main pressure can be used.

    Parameters
    ----------
    lowest, highest
        of its main pressure [Pa]; NaN where no sample is usable.

    Raises
    ------
    RoadTestError
        saying why.
    """
    why = road_test.refused.get("main_pressure")
    if road_test.channel("main_pressure") is None:
        missing = Sentence("the log has no main pressure")
        if why is not None:
            missing = Sentence("the log's column of main pressure is not usable: {why}", why=why)
    elif np.isnan(highest):
        missing = Sentence("the log has no usable sample of main pressure")
    elif not highest >= 0.0:
        missing = Sentence(
            "main pressure is below zero throughout this log ({low:.4g} to {high:.4g} {high.unit})",
            low=Quantity(lowest * KPA, "pressure"),
            high=Quantity(highest * KPA, "pressure"),
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


@dataclass
class Tally:
    """How many samples of a log have a leakage, and why the others have none."""

    samples: int = 0
    known: int = 0  # with a leakage
    no_delivery: int = 0  # at which the pump delivers nothing while pressure stands
    any_share: bool = False
    hotter: int = 0  # than the fluid's data
    other_gear: int = 0
    outside_fluid: int = 0
    unbalanced: int = 0
    reversed_drops: Counter[str] = field(default_factory=Counter)  # by section
    above_main: Counter[str] = field(default_factory=Counter)
    gears: set[int] = field(default_factory=set)  # of samples with a leakage

    def add(self, model: LeakageModel, each: RoadSamples) -> None:
        """Add some samples."""
        series, capacity = each.series, each.pump_capacity
        known = np.isfinite(series.total)
        self.samples += len(known)
        self.known += int(np.count_nonzero(known))
        if capacity is not None:
            self.no_delivery += int(np.count_nonzero((capacity <= 0.0) & (series.total > 0.0)))
            self.any_share = self.any_share or bool((share_of(series.total, capacity) >= 0.0).any())
        self.hotter += int(np.count_nonzero((each.temperature > _hottest(model)) & (each.main > 0.0)))
        self.other_gear += series.other_gear
        self.outside_fluid += series.outside_fluid
        self.unbalanced += series.unbalanced
        for section, count in series.reversed_samples.items():
            self.reversed_drops[section] += count
        for section, above in model.controller.above_main(each.main).items():
            self.above_main[section] += int(np.count_nonzero(above))
        self.gears |= {int(number) for number in np.unique(each.gear[known])}

    def refuse_nothing_known(self, model: LeakageModel, file: str) -> None:
        """Refuse a log of which no sample has a leakage.

        Raises
        ------
        RoadTestError
            saying why they have none.
        """
        if self.known:
            return
        low, high = model.fluid.span(model.profile.viscosity)
        raise RoadTestError(
            Sentence(
                "no sample of the log has usable values of pressure, temperature and gear together ({other_gear} in a "
                "gear this valve body does not have, {outside} at a temperature outside the fluid's data)",
                other_gear=self.other_gear,
                outside=self.outside_fluid,
            ),
            place=Place(file=file),
            expected=Sentence(
                "gears {gears}, temperatures from {low:g} to {high:g} {high.unit}",
                gears=model.controller.gears,
                low=Quantity(low, "temperature"),
                high=Quantity(high, "temperature"),
            ),
        )

    def messages(self, model: LeakageModel, *, with_speed: bool) -> Iterator[Message]:
        """Say what was left out, and what does not hold everywhere."""
        if not with_speed:
            text = Sentence("The log has no engine speed: pump capacity and share over the log are not known.")
            yield Message("warning", "no_engine_speed", text)
        elif self.no_delivery:
            without = {"count": self.no_delivery, "samples": self.samples}
            if self.any_share:
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
        yield from self._left_out(model)
        if self.hotter:
            text = Sentence(
                "{count} of the samples left out are hotter than {hottest:g} {hottest.unit}: the largest leakage and "
                "share of this log are lower bounds.",
                count=self.hotter,
                hottest=Quantity(_hottest(model), "temperature"),
            )
            yield Message("warning", "lower_bound", text)
        for section, count in self.above_main.items():
            if count:
                text = Sentence(
                    "In {count} of {samples} samples {section} would be above main pressure, where its relation does "
                    "not hold: its leakage there is too high.",
                    count=count,
                    samples=self.samples,
                    section=section,
                )
                yield Message("warning", "pressure_relation", text)

    def _left_out(self, model: LeakageModel) -> Iterator[Message]:
        size = self.samples
        for section, count in self.reversed_drops.items():
            if count:
                text = Sentence(
                    "In {count} of {size} samples a pressure drop of section {section} is negative and counts as no "
                    "leakage.",
                    count=count,
                    size=size,
                    section=section,
                )
                yield Message("warning", "reversed_pressure_drop", text)
        if self.unbalanced:
            text = Sentence(
                "In {count} of {size} samples no pressures were found at which all circuits balance.",
                count=self.unbalanced,
                size=size,
            )
            yield Message("warning", "circuits_not_balanced", text)
        if self.other_gear:
            text = Sentence(
                "{count} of {size} samples are in no gear of this valve body ({gears}) and are left out.",
                count=self.other_gear,
                size=size,
                gears=model.controller.gears,
            )
            yield Message("warning", "other_gear", text)
        if self.outside_fluid:
            low, high = model.fluid.span(model.profile.viscosity)
            text = Sentence(
                "{count} of {size} samples are at a temperature outside the data of {fluid} ({low:g} to {high:g} "
                "{high.unit}) and are left out.",
                count=self.outside_fluid,
                size=size,
                fluid=Name(model.fluid.name),
                low=Quantity(low, "temperature"),
                high=Quantity(high, "temperature"),
            )
            yield Message("warning", "outside_fluid", text)
        missing = size - self.known - self.other_gear - self.outside_fluid
        if missing > 0:
            text = Sentence(
                "{count} of {size} samples lack a usable value of pressure, temperature or gear and are left out.",
                count=missing,
                size=size,
            )
            yield Message("info", "samples_left_out", text)


def _hottest(model: LeakageModel) -> float:
    return float(model.fluid.span(model.profile.viscosity)[1])
