"""Thin a road test's leakage for a sheet or a page: few samples, no spike lost, gaps kept."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from atleak.engine.road_leakage import RoadLeakage
from atleak.sentence import Sentence
from atleak.thinning import thinned
from atleak.views.road_instants import RoadInstant, road_instants
from atleak.workshop_units import DM3_MIN, KPA, PERCENT, RPM


@dataclass(frozen=True)
class RoadSeries:
    """Columns of equal length by name, in workshop units; NaN where a sample is not usable."""

    columns: dict[str, np.ndarray]
    labels: dict[str, tuple[Sentence, str]]  # the same names → words and unit for people
    samples: int  # of the log
    instants: tuple[RoadInstant, ...]

    @property
    def thinned(self) -> bool:
        return self.samples > len(self.columns["time_s"])


def road_series(road: RoadLeakage, points: int) -> RoadSeries:
    """Return about ``points`` samples of a road test.

    They are `thinned` by leakage and share; the instants that the result names are among them.
    """
    series, instants = [road.leakage] if road.share is None else [road.leakage, road.share], road_instants(road)
    keep = thinned(series, points, keep=[row.instant.sample for row in instants])
    named = _columns(road)
    return RoadSeries(
        columns={name: array[keep] * factor for name, _, _, array, factor in named},
        labels={name: (label, unit) for name, label, unit, _, _ in named},
        samples=len(road.time),
        instants=instants,
    )


def _columns(road: RoadLeakage) -> list[tuple[str, Sentence, str, np.ndarray, float]]:
    """Return name, words, unit, values in SI and the factor from SI to the unit."""
    columns = [
        ("time_s", Sentence("time"), "s", road.time, 1.0),
        ("leakage_dm3_min", Sentence("leakage"), "dm³/min", road.leakage, DM3_MIN),
    ]
    share = road.share
    if road.pump_capacity is not None and share is not None:
        columns.append(("pump_capacity_dm3_min", Sentence("pump capacity"), "dm³/min", road.pump_capacity, DM3_MIN))
        columns.append(("share_percent", Sentence("share"), "%", share, PERCENT))
    for section, flow in road.sections.items():
        columns.append(
            (f"leakage_{section}_dm3_min", Sentence("leakage {section}", section=section), "dm³/min", flow, DM3_MIN)
        )
    for circuit, pressure in road.circuits.items():
        columns.append((f"{circuit}_kpa", Sentence("{circuit}, computed", circuit=circuit), "kPa", pressure, KPA))
    for quantity, name, said, unit, factor in (
        ("main_pressure", "p_g_kpa", Sentence("p_g"), "kPa", KPA),
        ("converter_pressure", "p_k_kpa", Sentence("p_k"), "kPa", KPA),
        ("engine_speed", "engine_rpm", Sentence("engine"), "1/min", RPM),
        ("atf_temperature", "temperature_c", Sentence("temperature"), "°C", 1.0),
        ("gear", "gear", Sentence("gear"), "", 1.0),
    ):
        values = road.road_test.values(quantity)
        if values is not None:
            columns.append((name, said, unit, values, factor))
    return columns
