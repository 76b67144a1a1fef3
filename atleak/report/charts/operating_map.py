"""Gather a road test over engine speed and temperature, or over the values of one channel: how long, and what share."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from atleak.common.units import PERCENT
from atleak.engine.road_leakage import RoadLeakage
from atleak.measurements.events.event import segments
from atleak.measurements.road_test import RoadTest
from atleak.report.tables.road_test import Scale

_COLUMNS, _ROWS, _BARS = 16, 10, 24  # most cells of the map in a direction, and most bars of a histogram
_NARROWEST = 50.0, 1.0  # least width of a cell of the map, in rpm and in degrees: finer ones say nothing


@dataclass(frozen=True, eq=False)
class OperatingMap:
    """Time and share in each cell; arrays have shape (temperatures, speeds), and edges are in the reader's units.

    ``share`` is the mean over a cell's time, ``largest`` its largest sample [%]; both are None without a share, and NaN
    in a cell without one.
    """

    speeds: np.ndarray
    temperatures: np.ndarray
    seconds: np.ndarray
    share: np.ndarray | None
    largest: np.ndarray | None
    left_out: float  # [s] without a speed or a temperature


@dataclass(frozen=True, eq=False)
class Histogram:
    """How long a channel had its values: ``edges`` in the reader's unit, ``seconds`` between each and the next."""

    edges: np.ndarray
    seconds: np.ndarray
    left_out: float  # [s] without a value


def operating_map(test: RoadTest, road: RoadLeakage | None, speed: Scale, temperature: Scale) -> OperatingMap | None:
    """Return a log over engine speed and fluid temperature; None where it lacks one of them.

    Parameters
    ----------
    speed, temperature
        unit and function from SI in which the reader has them.
    """
    engine, fluid = test.values("engine_speed"), test.values("atf_temperature")
    if engine is None or fluid is None:
        return None
    seconds = sample_times(test)
    x, y = speed[1](engine), temperature[1](fluid)
    known = np.isfinite(x) & np.isfinite(y)
    if not known.any():
        return None
    across, up = _edges(x[known], _COLUMNS, _NARROWEST[0]), _edges(y[known], _ROWS, _NARROWEST[1])
    column, row = _cells(x[known], across), _cells(y[known], up)
    shape = (len(up) - 1, len(across) - 1)
    cell = row * shape[1] + column
    size = shape[0] * shape[1]
    time = np.bincount(cell, seconds[known], size).reshape(shape)
    mean = largest = None
    if road is not None and road.share is not None:
        share = road.share[known] * PERCENT
        there = np.isfinite(share)
        weight = np.bincount(cell[there], seconds[known][there], size)
        total = np.bincount(cell[there], (share * seconds[known])[there], size)
        top = np.full(size, -np.inf)
        np.maximum.at(top, cell[there], share[there])
        mean = np.divide(total, weight, out=np.full(size, np.nan), where=weight > 0.0).reshape(shape)
        largest = np.where(np.isfinite(top), top, np.nan).reshape(shape)
    return OperatingMap(across, up, time, mean, largest, float(seconds[~known].sum()))


def histogram(test: RoadTest, values: np.ndarray) -> Histogram | None:
    """Return how long a channel had its values; None where it has none.

    Parameters
    ----------
    values
        of the channel at the stamps of the log's rows, shape (samples,), in the reader's unit; NaN where unknown.
    """
    known = np.isfinite(values)
    if not known.any():
        return None
    seconds = sample_times(test)
    edges = _edges(values[known], _BARS)
    time = np.bincount(_cells(values[known], edges), seconds[known], len(edges) - 1)
    return Histogram(edges, time, float(seconds[~known].sum()))


def sample_times(test: RoadTest) -> np.ndarray:
    """Return how long each sample stands, until the next one of its stretch [s]; the last of a stretch takes none."""
    times = np.zeros(len(test.time))
    for part in segments(test):
        times[part.start : max(part.stop - 1, part.start)] = np.diff(test.time[part])
    return times


def _edges(values: np.ndarray, most: int, narrowest: float = 0.0) -> np.ndarray:
    """Return round edges around all values, at most so many cells, none narrower than that."""
    low, high = float(values.min()), float(values.max())
    least = max((high - low) / (most - 1), narrowest, 1e-9 * max(abs(low), abs(high), 1.0))
    power = 10.0 ** math.floor(math.log10(least))
    step = next(each * power for each in (1.0, 2.0, 2.5, 5.0, 10.0) if each * power >= least * (1.0 - 1e-9))
    first = math.floor(low / step + 1e-9)
    last = max(math.ceil(high / step - 1e-9), first + 1)
    return np.arange(first, last + 1) * step


def _cells(values: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Return the number of the cell of each value; the last edge belongs to the last cell."""
    cells = np.searchsorted(edges, values, side="right") - 1
    return np.clip(cells, 0, len(edges) - 2)
