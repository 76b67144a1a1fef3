"""Tell what of a log's values lasts: a value counts as large as it stays for a second on end.

Pressure rises and falls within a shift and sensors err for single samples; neither says anything of wear.
"""

from __future__ import annotations

import numpy as np
import pandas as pd
from pandas.api.indexers import BaseIndexer

from atleak.engine.extremes import SUSTAINED_SECONDS, clock_of, running_median
from atleak.events import Thresholds, engine_starts, gear_shifts
from atleak.events.event import segments, within
from atleak.road_test import RoadTest

LASTING = 1.0  # [s] that a value must last, and under which a shift does not count: choice of this project
_ENOUGH = LASTING * (1.0 - 1e-9)
_NEVER = -1e300  # stands for an unknown value, below all others: pandas' windows leave out what is not finite
_APART = 10.0 * LASTING  # [s] between two segments on the clock that counts: more than any window


class CountedSamples:
    """The samples of a log that count: not those of a standstill or start of the engine, nor of short shifts.

    What does not count is cut out of the clock: it neither lasts nor parts what lies before from what lies behind.
    """

    def __init__(self, road_test: RoadTest) -> None:
        self.time, self._segments = road_test.time, road_test.segments
        shifts = (event for event in gear_shifts(road_test) if event.duration < LASTING)
        cut_out = (*engine_starts(road_test), *shifts)
        engine, out = road_test.values("engine_speed"), within(self.time, cut_out)
        if engine is not None:
            out |= engine < Thresholds.idle_low
        part, steps = np.zeros(len(self.time), int), np.zeros(len(self.time))
        for number, each in enumerate(segments(road_test)):
            part[each] = number
            steps[each.start : max(each.stop - 1, each.start)] = np.diff(self.time[each])
        self.samples = np.flatnonzero(~out)
        self.part = part[self.samples]  # number of the segment of each that counts
        self.steps = np.where(
            out, 0.0, steps
        )  # [s] to the next sample of the same segment; 0 of one that does not count
        elapsed = np.cumsum(self.steps) - self.steps
        self.clock = elapsed[self.samples] + _APART * self.part  # [s] of those that count

    def time_of(self, mask: np.ndarray) -> float:
        """Return how long some of the log's samples take [s], each until the next one of its segment."""
        return float(np.sum(self.steps[mask]))

    def smooth(self, values: np.ndarray) -> np.ndarray:
        """Return the median of half a second where there are samples enough for one; what is unknown stays so."""
        clock = clock_of(self.time, self._segments, SUSTAINED_SECONDS)
        medians = running_median(values, clock, SUSTAINED_SECONDS)
        return np.where(np.isnan(values) | np.isnan(medians), values, medians)


class Lasting:
    """Values of a log, outside where they are positive, and what of them lasts.

    Parameters
    ----------
    counted
        the samples that count.
    values
        shape (samples of the log,); NaN ends a stretch.
    """

    def __init__(self, counted: CountedSamples, values: np.ndarray) -> None:
        self.excess, self._counted = values, counted
        samples, clock, part = counted.samples, counted.clock, counted.part
        known = np.where(np.isnan(values), _NEVER, values)[samples]
        begins = np.searchsorted(part, part)  # first sample of each one's segment
        since = np.searchsorted(clock, clock - _ENOUGH, side="right") - 1
        self._since = np.maximum(since, begins)
        # of the second that ends with each sample
        least = pd.Series(known).rolling(_Windows(self._since), min_periods=1).min().to_numpy()
        self._least = np.where(since >= begins, least, _NEVER)
        over = known > 0.0
        edges = np.flatnonzero((np.diff(over, prepend=~over[:1]) != 0) | (np.diff(part, prepend=-1) != 0))
        stops = np.append(edges[1:], len(samples))[: len(edges)] - 1
        kept = over[edges] & (clock[stops] - clock[edges] >= _ENOUGH)
        self._starts, self._stops = edges[kept], stops[kept]
        self.outside = np.zeros(len(values), bool)  # in a stretch outside that lasts
        for start, stop in zip(self._starts, self._stops, strict=True):
            self.outside[samples[start : stop + 1]] = True

    def worst(self, among: np.ndarray) -> int | None:
        """Return the sample at which the worst second is least bad; None where none of these samples ends one."""
        least = np.where(among[self._counted.samples], self._least, _NEVER)
        if not np.max(least, initial=_NEVER) > _NEVER:
            return None
        end = int(np.argmax(least))
        window = self._counted.samples[self._since[end] : end + 1]
        window = window[among[window]]
        return int(window[np.argmin(self.excess[window])])

    def stretch(self, sample: int) -> tuple[float, float]:
        """Return begin and end [s] of the stretch outside that a sample lies in; the sample's own where in none."""
        time, samples = self._counted.time, self._counted.samples
        place = int(np.searchsorted(samples, sample))
        number = int(np.searchsorted(self._starts, place, side="right")) - 1
        if number < 0 or place > self._stops[number]:
            return float(time[sample]), float(time[sample])
        return float(time[samples[self._starts[number]]]), float(time[samples[self._stops[number]]])


class _Windows(BaseIndexer):
    """Windows that end with each value and begin with a given one."""

    def __init__(self, begins: np.ndarray) -> None:
        super().__init__()
        self.begins = begins.astype(np.int64)

    def get_window_bounds(
        self,
        num_values: int = 0,
        min_periods: int | None = None,
        center: bool | None = None,
        closed: str | None = None,
        step: int | None = None,
    ) -> tuple[np.ndarray, np.ndarray]:
        return self.begins, np.arange(1, num_values + 1, dtype=np.int64)
