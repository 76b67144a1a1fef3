"""Tell for how long a log stays in each range of fluid temperature, and how leakage, share and pressure are there.

Every sample counts until the next one of its stretch of the log. As for main pressure, those do not count in which the
engine stands or starts, nor those of short shifts (`atleak.engine.lasting`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

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
    sums = TemperatureSums()
    if (temperature := road.road_test.values("atf_temperature")) is not None:
        sums.add(
            seconds=CountedSamples(road.road_test).steps,
            temperature=temperature,
            leakage=road.leakage,
            share=road.share,
            pressure=logged_pressure(road),
            bands=None if unworn is None else share_bands(road, limits, unworn),
        )
    return sums.classes


def logged_pressure(road: RoadLeakage) -> np.ndarray | None:
    """Return the main pressure of every sample [Pa]; None where it is only assumed."""
    channel = road.road_test.channel("main_pressure")
    return None if channel is None or channel.source != "logged" else road.road_test.values("main_pressure")


def share_bands(road: RoadLeakage, limits: Steps, unworn: LeakageModel) -> np.ndarray | None:
    """Return the place in `BANDS` of every sample's share, −1 where it is not known; None where no share is.

    Growth is judged against what the unworn unit draws at the same sample, of the flow that the pump delivers now.
    """
    if road.share is None or road.pump_capacity is None:
        return None
    channels = channels_of(road.road_test, road.assumed)
    new = leakage_series(unworn, *channels, assumed=road.assumed).total
    return bands_of(road.share, new / np.where(road.pump_capacity > 0.0, road.pump_capacity, np.nan), limits)


def bands_of(share: np.ndarray, new: np.ndarray, limits: Steps) -> np.ndarray:
    """Return the place in `BANDS` of every share, beside that of the same unit new; −1 where one is not known."""
    known = np.isfinite(share) & np.isfinite(new)
    places = np.where(known, BANDS.index(Band.GREEN), -1)
    for level, limit in limits.over(new):
        reached = np.where(limit == 0.0, share > ROUNDING, share > limit - ROUNDING * np.abs(limit))
        places[known & reached] = BANDS.index(Band(level))
    return places


@dataclass
class _Sums:
    """Sums over the samples of one class: times [s], and values times time."""

    seconds: float = 0.0
    bands: np.ndarray = field(default_factory=lambda: np.zeros(len(BANDS)))
    leakage: float = 0.0
    with_share: float = 0.0  # [s]
    share: float = 0.0
    share_max: float = -np.inf
    with_pressure: float = 0.0  # [s]
    pressure: float = 0.0
    pressure_min: float = np.inf


class TemperatureSums:
    """The classes of a log as they grow; samples may be added in several parts."""

    def __init__(self) -> None:
        self._sums: dict[int, _Sums] = {}

    def add(
        self,
        *,
        seconds: np.ndarray,
        temperature: np.ndarray,
        leakage: np.ndarray,
        share: np.ndarray | None,
        pressure: np.ndarray | None,
        bands: np.ndarray | None,
    ) -> None:
        """Add some samples; arrays have shape (samples,).

        Parameters
        ----------
        seconds
            for which each counts.
        temperature, leakage, share, pressure
            [°C], [m³/s], a fraction, [Pa]; NaN where not known, and None where they are not at all.
        bands
            place in `BANDS` of every share, −1 where it is in none; None where none is judged.
        """
        counting = (seconds > 0.0) & np.isfinite(temperature) & np.isfinite(leakage)
        numbers = np.floor(np.where(counting, temperature, 0.0) / CLASS_WIDTH).astype(int)
        for number in np.unique(numbers[counting]).tolist():
            here = np.flatnonzero(counting & (numbers == number))
            sums, time = self._sums.setdefault(number, _Sums()), seconds[here]
            sums.seconds += float(np.sum(time))
            sums.leakage += float(np.sum(leakage[here] * time))
            if bands is not None:
                sums.bands += [float(np.sum(time[bands[here] == place])) for place in range(len(BANDS))]
            if share is not None and (known := np.isfinite(share[here])).any():
                values = share[here][known]
                sums.with_share += float(np.sum(time[known]))
                sums.share += float(np.sum(values * time[known]))
                sums.share_max = max(sums.share_max, float(values.max()))
            if pressure is not None and (known := np.isfinite(pressure[here])).any():
                values = pressure[here][known]
                sums.with_pressure += float(np.sum(time[known]))
                sums.pressure += float(np.sum(values * time[known]))
                sums.pressure_min = min(sums.pressure_min, float(values.min()))

    @property
    def classes(self) -> tuple[TemperatureClass, ...]:
        """Return the classes as they stand, the coldest first."""
        return tuple(
            TemperatureClass(
                low=number * CLASS_WIDTH,
                high=(number + 1) * CLASS_WIDTH,
                seconds=sums.seconds,
                in_bands=MappingProxyType(dict(zip(BANDS, sums.bands.tolist(), strict=True))),
                share_mean=sums.share / sums.with_share if sums.with_share else None,
                share_max=sums.share_max if sums.with_share else None,
                pressure_mean=sums.pressure / sums.with_pressure if sums.with_pressure else None,
                pressure_min=sums.pressure_min if sums.with_pressure else None,
                leakage_mean=sums.leakage / sums.seconds,
            )
            for number, sums in sorted(self._sums.items())
        )
