"""Compare the main pressure of a road test with what the valve body permits, and with what was commanded.

Only what lasts counts (`atleak.engine.extremes`): a departure is as large as it stays for a second. For each range of
fluid temperature it is told how long the log stays there, and how leakage, share and pressure are; samples in which the
engine stands or starts, and those of short shifts, do not count.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Literal

import numpy as np

from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_tables import StandingState
from atleak.catalogue.limits import ROUNDING, Steps
from atleak.catalogue.operating_point import IDLE_SPEED
from atleak.common.verdicts import BANDS, Band
from atleak.engine.extremes import CountedSamples, Lasting, smoothed
from atleak.engine.leakage import LeakageModel
from atleak.engine.road_leakage import RoadLeakage, channels_of
from atleak.engine.series import leakage_series
from atleak.measurements.events import Thresholds
from atleak.measurements.events.event import gear_engaged, rolling_samples, standing_samples
from atleak.measurements.road_test import RoadTest

STATES: tuple[StandingState, ...] = ("idle", "stall", "driving")
HELD_SECONDS = 3.0  # [s] that a temperature must last in a gear and state to count: choice of this project
SLUMP, SLUMP_SPAN = 0.05, 20.0  # least fall of a slump, of the pressure when cold; over so many K: choices likewise
_CLASS = 10.0  # [K] of the fluid's temperature over which pressure is averaged
NotJudged = Literal["no_main_pressure", "not_measured", "not_permitted", "no_engine_speed", "no_gear", "never_there"]


@dataclass(frozen=True)
class Departure:
    """How far pressure lies outside a limit, or how near it comes, for a second on end."""

    start: float  # [s] of the whole stretch outside the limit; of the second alone where it stays within
    stop: float  # [s]
    at: float  # [s] where in that second pressure is nearest to the limit
    gear: int
    state: StandingState
    pressure: float  # [Pa] there
    limit: float  # [Pa]
    fraction: float  # of the limit by which it lies outside; negative within
    source: str  # of the limit

    @property
    def outside(self) -> float:
        """Return how far it lies outside the limit [Pa]; negative within."""
        return self.fraction * self.limit


@dataclass(frozen=True)
class AtTemperature:
    """Main pressure in one gear and state while the fluid is within 10 K: means over time."""

    temperature: float  # [°C]
    pressure: float  # [Pa]
    seconds: float
    engine_speed: float  # [1/s]


@dataclass(frozen=True)
class PlaceFinding:
    """Main pressure in one gear and state: times [s], pressure [Pa] as it stays for a second."""

    gear: int
    state: StandingState
    judged: float  # time with a limit
    below: float  # time in stretches below it that last
    above: float
    worst: Departure | None  # below the low limit, or nearest to it; None without such a limit, or too short a time
    by_temperature: tuple[AtTemperature, ...] = ()  # the coldest first; none where no temperature is logged

    @property
    def held(self) -> tuple[AtTemperature, ...]:
        """Return main pressure at each temperature that lasted for some seconds."""
        return tuple(each for each in self.by_temperature if each.seconds >= HELD_SECONDS)

    @property
    def slump(self) -> tuple[AtTemperature, AtTemperature] | None:
        """Return main pressure at the coldest and the hottest, where it is right cold and low hot; None elsewhere."""
        if self.worst is None or not self.below or len(self.held) < 2:
            return None
        cold, hot = self.held[0], self.held[-1]
        falls = cold.pressure - hot.pressure >= SLUMP * cold.pressure
        warms = hot.temperature - cold.temperature >= SLUMP_SPAN
        return (cold, hot) if falls and warms and cold.pressure >= self.worst.limit > hot.pressure else None


@dataclass(frozen=True)
class RoadPressure:
    """Main pressure of a road test beside what the valve body permits in each gear and state."""

    places: tuple[PlaceFinding, ...]  # in the order of gears and states
    lowest: Departure | None  # the worst below a low limit, or the nearest to one
    highest: Departure | None  # the same of the high limits

    @property
    def judged(self) -> float:
        """Return for how long there was a limit [s]."""
        return sum(place.judged for place in self.places)

    @property
    def below(self) -> float:
        """Return for how long pressure stayed below what is permitted [s], in stretches that last."""
        return sum(place.below for place in self.places)

    @property
    def above(self) -> float:
        """Return for how long it stayed above [s], in stretches that last."""
        return sum(place.above for place in self.places)


@dataclass(frozen=True)
class CommandedPressure:
    """Main pressure as measured minus as commanded, as far as the difference stays for a second on end."""

    difference: float  # [Pa] the largest; negative where less is there than was commanded
    at: float  # [s]
    actual: float  # [Pa] there
    commanded: float  # [Pa] there
    start: float  # [s] of the stretch in which it stays on that side of zero
    stop: float  # [s]
    compared: float  # [s] for how long both are there


def judge_pressure(
    controller: Controller, road_test: RoadTest, counted: CountedSamples | None = None
) -> RoadPressure | NotJudged:
    """Compare main pressure with what the valve body permits in the gear and state of every sample.

    A sample idles under `IDLE_SPEED` where no logged speed shows that the car rolls; it stalls where a logged speed
    shows that the car stands in gear with the engine raised; else it drives. Without a gear that the valve body's file
    names there is no limit, nor while the engine stands or starts, while the car coasts as slowly as it idles, nor in
    shifts shorter than a second.

    Parameters
    ----------
    counted
        the log's samples that count, where they were found before.

    Returns
    -------
    RoadPressure | NotJudged
        the comparison, or why there is none: a pressure that was assumed or commanded is never judged.
    """
    why = _why_not_judged(controller, road_test)
    if why is not None:
        return why
    samples = _Permitted(controller, road_test, counted)
    return samples.judge() if samples.counted.time_of(samples.number >= 0) > 0.0 else "never_there"


def permitted_pressure(controller: Controller, road_test: RoadTest) -> tuple[np.ndarray, np.ndarray] | None:
    """Return the least and the largest main pressure permitted at each sample of a log.

    Returns
    -------
    tuple[np.ndarray, np.ndarray] | None
        two arrays of shape (samples,) [Pa], NaN where there is no limit; None where main pressure is not judged, as
        `judge_pressure` says.
    """
    if _why_not_judged(controller, road_test) is not None:
        return None
    samples = _Permitted(controller, road_test)
    return samples.low, samples.high


def _why_not_judged(controller: Controller, road_test: RoadTest) -> NotJudged | None:
    """Return what is missing to judge a log's main pressure, its samples apart; None where nothing is."""
    channel = road_test.channel("main_pressure")
    if channel is None:
        return "no_main_pressure"
    if channel.source != "logged" or channel.kind == "commanded":
        return "not_measured"
    if not controller.permissible_in_gear:
        return "not_permitted"
    if road_test.channel("engine_speed") is None:
        return "no_engine_speed"
    if road_test.channel("gear") is None:
        return "no_gear"
    return None


class _Permitted:
    """What is permitted at every sample of a log; arrays of shape (samples,), NaN where there is no limit."""

    def __init__(self, controller: Controller, road_test: RoadTest, counted: CountedSamples | None = None) -> None:
        self.controller, self.time = controller, road_test.time
        self.gear, self.counted = np.asarray(gear_engaged(road_test)), counted or CountedSamples(road_test)
        temperature = road_test.values("atf_temperature")
        self.temperature = np.full(len(self.time), np.nan) if temperature is None else temperature
        self.pressure = smoothed(road_test, "main_pressure")
        self.engine_speed = np.asarray(road_test.values("engine_speed"))
        self.low, self.high = (np.full(len(self.time), np.nan) for _ in range(2))
        self.number = np.full(len(self.time), -1)  # of the limits in the valve body's file
        states = standing_states(road_test, self.gear)
        for number, permitted in enumerate(controller.permissible_in_gear):
            here = np.isin(self.gear, list(permitted.gears)) & states[permitted.state] & np.isfinite(self.pressure)
            self.number[here] = number
            self.low[here] = np.nan if permitted.low is None else permitted.low
            self.high[here] = np.nan if permitted.high is None else permitted.high

    def judge(self) -> RoadPressure:
        under = Lasting(self.counted, 1.0 - self.pressure / self.low)
        over = Lasting(self.counted, self.pressure / self.high - 1.0)
        places = []
        for number, permitted in enumerate(self.controller.permissible_in_gear):
            for gear in sorted(permitted.gears):
                here = (self.number == number) & (self.gear == gear)
                judged = self.counted.time_of(here)
                if judged > 0.0:
                    below, above = (self.counted.time_of(each.outside & here) for each in (under, over))
                    worst = self._departure(under, self.low, here)
                    found = self._by_temperature(here)
                    places.append(PlaceFinding(gear, permitted.state, judged, below, above, worst, found))
        places.sort(key=lambda place: (place.gear, STATES.index(place.state)))
        limited = self.number >= 0
        lowest, highest = self._departure(under, self.low, limited), self._departure(over, self.high, limited)
        return RoadPressure(tuple(places), lowest, highest)

    def _departure(self, lasting: Lasting, limit: np.ndarray, among: np.ndarray) -> Departure | None:
        sample = lasting.worst(among)
        if sample is None:
            return None
        permitted = self.controller.permissible_in_gear[self.number[sample]]
        start, stop = lasting.stretch(sample)
        return Departure(
            start=start,
            stop=stop,
            at=float(self.time[sample]),
            gear=int(self.gear[sample]),
            state=permitted.state,
            pressure=float(self.pressure[sample]),
            limit=float(limit[sample]),
            fraction=float(lasting.excess[sample]),
            source=permitted.source,
        )

    def _by_temperature(self, here: np.ndarray) -> tuple[AtTemperature, ...]:
        """Return main pressure over the fluid's temperature at some samples, the coldest first."""
        temperature, pressure, speed = self.temperature[here], self.pressure[here], self.engine_speed[here]
        known = np.isfinite(temperature) & np.isfinite(pressure) & np.isfinite(speed)
        classes = np.floor(temperature[known] / _CLASS).astype(int)
        seconds = self.counted.steps[here][known]
        rows = np.stack([np.ones(len(classes)), temperature[known], pressure[known], speed[known]]) * seconds
        sums = (rows[:, classes == each].sum(axis=1) for each in np.unique(classes))
        return tuple(
            AtTemperature(float(t / s), float(p / s), float(s), float(n / s)) for s, t, p, n in sums if s > 0.0
        )


def standing_states(road_test: RoadTest, gear: np.ndarray) -> dict[StandingState, np.ndarray]:
    """Return at which samples the engine idles, the converter stalls and the car drives; none of it where unknown.

    Notes
    -----
    Only a logged speed behind the gears shows that the car stands: where it rolls, the engine as slow as at idle, it
    coasts, for which there is no limit.
    """
    engine, limits = np.asarray(road_test.values("engine_speed")), Thresholds()
    slow, standing = engine < IDLE_SPEED, standing_samples(road_test, limits)
    stalls = np.zeros(len(engine), bool)
    if standing is not None:
        stalls = standing & (gear != 0) & (engine > limits.stall_speed)
    return {
        "idle": slow & ~rolling_samples(road_test, limits),
        "stall": stalls,
        "driving": np.isfinite(engine) & ~slow & ~stalls,
    }


def compare_with_commanded(road_test: RoadTest) -> CommandedPressure | None:
    """Compare main pressure with what the gearbox computer commanded; None where one of them is not logged."""
    names = "main_pressure", "commanded_pressure"
    channels = [road_test.channel(name) for name in names]
    logged = [each for each in channels if each is not None and each.source == "logged"]
    if len(logged) < len(names) or logged[0].kind == "commanded":
        return None
    counted = CountedSamples(road_test)
    actual, commanded = (smoothed(road_test, name) for name in names)
    difference, everywhere = actual - commanded, np.ones(len(road_test.time), bool)
    sides = (Lasting(counted, difference), Lasting(counted, -difference))
    largest = [(lasting, sample) for lasting in sides if (sample := lasting.worst(everywhere)) is not None]
    if not largest:
        return None
    lasting, sample = max(largest, key=lambda each: float(each[0].excess[each[1]]))
    start, stop = lasting.stretch(sample)
    return CommandedPressure(
        difference=float(difference[sample]),
        at=float(road_test.time[sample]),
        actual=float(actual[sample]),
        commanded=float(commanded[sample]),
        start=start,
        stop=stop,
        compared=counted.time_of(np.isfinite(difference)),
    )


CLASS_WIDTH = 5.0  # [°C] of a class of temperature: choice of this project


@dataclass(frozen=True)
class TemperatureClass:
    """What a log holds in one class of fluid temperature; means are over time."""

    low: float  # [°C], within the class
    high: float  # [°C], the next class's
    seconds: float  # with leakage known
    in_bands: Mapping[Band, float]  # [s] of them with the share in each band; in none where it is not known
    share_mean: float | None  # a fraction; None where no sample has one
    share_max: float | None
    pressure_mean: float | None  # main pressure [Pa]; None where it is not logged
    pressure_min: float | None  # [Pa]
    leakage_mean: float  # [m³/s]


def temperature_classes(road: RoadLeakage, limits: Steps, unworn: LeakageModel | None) -> tuple[TemperatureClass, ...]:
    """Return the classes of fluid temperature that a log passes through, the coldest first.

    Parameters
    ----------
    road
        the leakage over the log; one without a logged temperature has no classes.
    unworn
        the same unit as it may have been when new (`model_unworn`), over which growth is judged; None for one that was
        not measured, whose share is in no band.
    """
    temperature = road.road_test.values("atf_temperature")
    if temperature is None:
        return ()
    seconds = CountedSamples(road.road_test).steps
    counting = (seconds > 0.0) & np.isfinite(temperature) & np.isfinite(road.leakage)
    numbers = np.floor(np.where(counting, temperature, 0.0) / CLASS_WIDTH).astype(int)
    channel = road.road_test.channel("main_pressure")
    logged = channel is not None and channel.source == "logged"
    pressure = road.road_test.values("main_pressure") if logged else None
    bands = None if unworn is None else _share_bands(road, limits, unworn)
    return tuple(
        _class(number, np.flatnonzero(counting & (numbers == number)), seconds, road, pressure, bands)
        for number in np.unique(numbers[counting]).tolist()
    )


def _class(
    number: int,
    here: np.ndarray,
    seconds: np.ndarray,
    road: RoadLeakage,
    pressure: np.ndarray | None,
    bands: np.ndarray | None,
) -> TemperatureClass:
    """Sum up the samples of one class; ``bands`` has the place in `BANDS` of every share, −1 where it is in none."""
    time, share = seconds[here], road.share
    whole = float(np.sum(time))
    in_bands = [0.0 if bands is None else float(np.sum(time[bands[here] == place])) for place in range(len(BANDS))]
    share_mean, share_max = (None, None) if share is None else _mean_and(np.max, share[here], time)
    pressure_mean, pressure_min = (None, None) if pressure is None else _mean_and(np.min, pressure[here], time)
    return TemperatureClass(
        low=number * CLASS_WIDTH,
        high=(number + 1) * CLASS_WIDTH,
        seconds=whole,
        in_bands=MappingProxyType(dict(zip(BANDS, in_bands, strict=True))),
        share_mean=share_mean,
        share_max=share_max,
        pressure_mean=pressure_mean,
        pressure_min=pressure_min,
        leakage_mean=float(np.sum(road.leakage[here] * time)) / whole,
    )


def _mean_and(
    end: Callable[[np.ndarray], Any], values: np.ndarray, time: np.ndarray
) -> tuple[float, float] | tuple[None, None]:
    """Return the mean over time of the values that are known, and their least or largest; None of none."""
    known = np.isfinite(values)
    if not known.any():
        return None, None
    return float(np.sum(values[known] * time[known])) / float(np.sum(time[known])), float(end(values[known]))


def _share_bands(road: RoadLeakage, limits: Steps, unworn: LeakageModel) -> np.ndarray | None:
    """Return the place in `BANDS` of every sample's share, −1 where it is not known; None where no share is.

    Growth is judged against what the unworn unit draws at the same sample, of the flow that the pump delivers now.
    """
    if road.share is None or road.pump_capacity is None:
        return None
    channels = channels_of(road.road_test, road.assumed)
    of_new = leakage_series(unworn, *channels, assumed=road.assumed).total
    share, new = road.share, of_new / np.where(road.pump_capacity > 0.0, road.pump_capacity, np.nan)
    known = np.isfinite(share) & np.isfinite(new)
    places = np.where(known, BANDS.index(Band.GREEN), -1)
    for level, limit in limits.over(new):
        reached = np.where(limit == 0.0, share > ROUNDING, share > limit - ROUNDING * np.abs(limit))
        places[known & reached] = BANDS.index(Band(level))
    return places
