"""Tell for how long a log stays in each range of fluid temperature, and how leakage, share and pressure are there.

Every sample counts until the next one of its stretch of the log. As for main pressure, those do not count in which the
engine stands or starts, nor those of short shifts (`atleak.engine.lasting`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np

from atleak.catalogue.limits import ROUNDING, Steps
from atleak.engine.lasting import CountedSamples
from atleak.engine.leakage import LeakageModel
from atleak.engine.road_leakage import RoadLeakage
from atleak.engine.road_samples import channels_of
from atleak.engine.series import leakage_series
from atleak.verdicts import BANDS, Band

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
    limits
        of the unit's share of the pump's flow (`Limits.total_share`).
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
