"""A road test's leakage thinned for a sheet or a page: few samples, no spike lost, gaps kept."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from atleak.engine.road_leakage import Instant, RoadLeakage
from atleak.thinning import thinned
from atleak.workshop_units import DM3_MIN, KPA, PERCENT, RPM


@dataclass(frozen=True)
class RoadSeries:
    """Columns of equal length by name, in workshop units; NaN where a sample is not usable."""

    columns: dict[str, np.ndarray]
    samples: int  # of the log
    instants: dict[str, Instant]

    @property
    def thinned(self) -> bool:
        return self.samples > len(self.columns["time_s"])


def road_series(road: RoadLeakage, points: int) -> RoadSeries:
    """About ``points`` samples of a road test.

    They are `thinned` by leakage and share; the instants that the result names are among them.
    """
    keep = _samples(road, points)
    instants = {"max_leakage": road.max_leakage, "min_leakage": road.min_leakage, "max_share": road.max_share}
    columns = {name: array[keep] * factor for name, array, factor in _columns(road)}
    return RoadSeries(columns, len(road.time), {name: found for name, found in instants.items() if found})


def _columns(road: RoadLeakage) -> list[tuple[str, np.ndarray, float]]:
    found = [("time_s", road.time, 1.0), ("leakage_dm3_min", road.leakage, DM3_MIN)]
    share = road.share
    if road.pump_capacity is not None and share is not None:
        found += [("pump_capacity_dm3_min", road.pump_capacity, DM3_MIN), ("share_percent", share, PERCENT)]
    found += [(f"leakage_{name}_dm3_min", flow, DM3_MIN) for name, flow in road.sections.items()]
    for quantity, name, factor in (
        ("main_pressure", "p_g_kpa", KPA),
        ("converter_pressure", "p_k_kpa", KPA),
        ("engine_speed", "engine_rpm", RPM),
        ("atf_temperature", "temperature_c", 1.0),
        ("gear", "gear", 1.0),
    ):
        values = road.road_test.values(quantity)
        if values is not None:
            found.append((name, values, factor))
    return found


def _samples(road: RoadLeakage, points: int) -> np.ndarray:
    instants = [at.time for at in (road.max_leakage, road.min_leakage, road.max_share) if at is not None]
    series = [road.leakage] if road.share is None else [road.leakage, road.share]
    return thinned(series, points, keep=[int(np.argmin(np.abs(road.time - time))) for time in instants])
