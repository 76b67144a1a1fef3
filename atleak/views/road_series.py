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
    labels: dict[str, tuple[str, str]]  # the same names → words and unit for people
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
    named = _columns(road)
    return RoadSeries(
        columns={name: array[keep] * factor for name, _, _, array, factor in named},
        labels={name: (label, unit) for name, label, unit, _, _ in named},
        samples=len(road.time),
        instants={name: instant for name, instant in instants.items() if instant},
    )


def _columns(road: RoadLeakage) -> list[tuple[str, str, str, np.ndarray, float]]:
    """Name, words, unit, values in SI and the factor from SI to the unit."""
    columns = [
        ("time_s", "time", "s", road.time, 1.0),
        ("leakage_dm3_min", "leakage", "dm³/min", road.leakage, DM3_MIN),
    ]
    share = road.share
    if road.pump_capacity is not None and share is not None:
        columns.append(("pump_capacity_dm3_min", "pump capacity", "dm³/min", road.pump_capacity, DM3_MIN))
        columns.append(("share_percent", "share", "%", share, PERCENT))
    for section, flow in road.sections.items():
        columns.append((f"leakage_{section}_dm3_min", f"leakage {section}", "dm³/min", flow, DM3_MIN))
    for quantity, name, label, unit, factor in (
        ("main_pressure", "p_g_kpa", "p_g", "kPa", KPA),
        ("converter_pressure", "p_k_kpa", "p_k", "kPa", KPA),
        ("engine_speed", "engine_rpm", "engine", "1/min", RPM),
        ("atf_temperature", "temperature_c", "temperature", "°C", 1.0),
        ("gear", "gear", "gear", "", 1.0),
    ):
        values = road.road_test.values(quantity)
        if values is not None:
            columns.append((name, label, unit, values, factor))
    return columns


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
