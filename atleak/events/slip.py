"""Tell how far the torque converter slips: engine speed minus turbine speed while the car drives."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from atleak.events.driving import lock_ups
from atleak.events.event import Thresholds, runs, standing_samples
from atleak.road_test import RoadTest

_TURNS = 100 / 60  # [1/s] of the turbine, below which the car stands
_FEWEST = 20  # samples of which a range is told


@dataclass(frozen=True)
class ConverterSlip:
    """Engine speed minus turbine speed [1/s] while the car drives: 5 and 95 of 100 samples lie below the ends."""

    low: float
    median: float
    high: float
    locked_seconds: float  # [s] with hardly any slip
    commanded_seconds: float | None  # [s] with lock-up commanded; None where that is not logged
    commanded_median: float | None  # [1/s] of slip then, either way


def converter_slip(road_test: RoadTest, thresholds: Thresholds | None = None) -> ConverterSlip | None:
    """Return the slip of the converter; None where engine or turbine speed are not logged, or the car never drives."""
    limits = thresholds or Thresholds()
    engine, turbine = road_test.values("engine_speed"), road_test.values("turbine_speed")
    if engine is None or turbine is None:
        return None
    slip, standing = engine - turbine, standing_samples(road_test, limits)
    driving = np.isfinite(slip) & (engine >= limits.idle_low) & (turbine > _TURNS)
    if standing is not None:
        driving &= ~standing
    if np.count_nonzero(driving) < _FEWEST:
        return None
    low, median, high = (float(each) for each in np.percentile(slip[driving], (5, 50, 95)))
    locked = sum(event.duration for event in lock_ups(road_test, limits))
    command = road_test.values("lock_up")
    if command is None or not np.isfinite(command).any() or not np.nanmax(command) > 0:
        return ConverterSlip(low, median, high, locked, None, None)
    wanted = driving & (command >= 0.5 * np.nanmax(command))
    spans = [slice(first, last + 1) for first, last in runs(road_test, wanted, limits.lock_up_seconds)]
    seconds = sum(float(road_test.time[span.stop - 1] - road_test.time[span.start]) for span in spans)
    then = np.concatenate([np.abs(slip[span]) for span in spans]) if spans else np.zeros(0)
    return ConverterSlip(low, median, high, locked, seconds, float(np.median(then)) if len(then) else None)
