"""A road test's leakage thinned for a sheet or a page: few samples, no spike lost, gaps kept."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from tsdownsample import MinMaxDownsampler

from atleak.engine.road_leakage import Instant, RoadLeakage
from atleak.workshop_units import DM3_MIN, KPA, PERCENT, RPM

_BREAKS = 400  # edges of stretches without values that are kept at most


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

    Every stretch keeps its lowest and highest leakage and share, so that a spike of one sample stays; so do both ends,
    the instants the result names, and the edges of stretches without usable samples. Nothing is averaged.
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
    size = len(road.time)
    if size <= points:
        return np.arange(size)
    series = [road.leakage] if road.share is None else [road.leakage, road.share]
    each = max(points // len(series) // 2 * 2, 4)
    kept = [np.array([0, size - 1])]
    for values in series:
        kept.append(np.asarray(MinMaxDownsampler().downsample(np.ascontiguousarray(values), n_out=each), dtype=int))
        known = np.isfinite(values)
        edges = np.flatnonzero(known[1:] != known[:-1])
        kept.append(np.concatenate([edges, edges + 1])[:_BREAKS])
    for instant in (road.max_leakage, road.min_leakage, road.max_share):
        if instant is not None:
            kept.append(np.flatnonzero(road.time == instant.time)[:1])
    return np.unique(np.concatenate(kept))
