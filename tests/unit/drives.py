"""Makes up drives for tests: an engine that stands, starts, idles, stalls and pulls through the gears."""

from __future__ import annotations

from collections.abc import Collection
from itertools import pairwise
from types import MappingProxyType

import numpy as np

from atleak.measurements.road_test import Channel, RoadTest, Segment

NAN = float("nan")
ALL = (
    "engine_speed", "vehicle_speed", "turbine_speed", "output_speed", "gear", "selector", "lock_up", "main_pressure",
    "commanded_pressure", "converter_pressure", "atf_temperature",
)  # fmt: skip
# engine speed [1/min], vehicle speed [km/h] and gear at the end of a phase; how long it takes at most [s]
_PHASES = {
    "off": (0.0, 0.0, 0.0, 4.0),
    "flicker": (60.0, 0.0, 0.0, 0.8),
    "idle": (780.0, 0.0, 1.0, 9.0),
    "neutral": (800.0, 0.0, 0.0, 4.0),
    "stall": (2200.0, 0.0, 1.0, 3.0),
    "revved": (3900.0, 0.0, 0.0, 3.0),
    "first": (2300.0, 22.0, 1.0, 5.0),
    "to second": (1650.0, 23.0, 2.0, 0.4),
    "second": (2250.0, 41.0, 2.0, 5.0),
    "to third": (1600.0, 43.0, 3.0, 0.4),
    "third": (2200.0, 62.0, 3.0, 5.0),
    "to fourth": (1550.0, 63.0, 4.0, 0.4),
    "fourth": (1700.0, 88.0, 4.0, 6.0),
    "cruise": (1700.0, 88.0, 4.0, 14.0),
    "fast": (3300.0, 95.0, 3.0, 3.0),
    "reverse": (1200.0, 6.0, -1.0, 3.0),
    "unknown": (1500.0, 50.0, 9.0, 2.0),
}
_AFTER = {
    "off": ("flicker", "idle", "idle", "off"),
    "flicker": ("off", "idle"),
    "idle": ("first", "first", "stall", "neutral", "off", "reverse"),
    "neutral": ("idle", "revved", "off"),
    "stall": ("idle", "first"),
    "revved": ("neutral",),
    "first": ("to second", "to second", "to second", "idle"),
    "to second": ("second", "second", "second", "first"),
    "second": ("to third", "to third", "to third", "fast"),
    "to third": ("third",),
    "third": ("to fourth", "to fourth", "second", "idle"),
    "to fourth": ("fourth",),
    "fourth": ("cruise", "fast", "third"),
    "cruise": ("third", "fast", "cruise", "unknown"),
    "fast": ("third", "fourth"),
    "reverse": ("idle",),
    "unknown": ("cruise", "idle"),
}
_RATIOS = np.array([2.8, 1.5, 1.0, 0.7])


def drive(
    seed: int, seconds: float = 60.0, channels: Collection[str] = ALL, step: float = 0.06, breaks: bool = True
) -> RoadTest:
    """Return a drive with these channels; NaN are suspect samples, and its clock pauses where ``breaks`` says so."""
    generator = np.random.default_rng(seed)
    ends, targets, phase = [0.0], [(0.0, 0.0, 0.0)], str(generator.choice(["off", "idle", "cruise"]))
    targets[0] = _PHASES[phase][:3]
    while ends[-1] < seconds:
        *values, longest = _PHASES[phase]
        ends.append(ends[-1] + generator.uniform(0.2, longest))
        targets.append(tuple(values))
        phase = str(generator.choice(_AFTER[phase]))
    steps = generator.choice([step, step, step, 0.5 * step, 0.0], int(seconds / step))
    time = np.round(np.cumsum(steps), 6)
    count = len(time)
    rpm, km_h, gear = (np.interp(time, ends, column) for column in np.array(targets).T)
    gear = np.array([target[2] for target in targets])[np.minimum(np.searchsorted(ends, time), len(ends) - 1)]
    rpm = np.where(rpm > 1.0, np.maximum(rpm + generator.normal(0.0, 6.0, count), 0.0), 0.0)
    ratio = _RATIOS[np.clip(gear - 1, 0, 3).astype(int)]
    output = km_h / 3.6 * 8.0 / 60.0 * 10.0
    locked = generator.random(count) < 0.97
    values = {
        "engine_speed": rpm / 60.0,
        "vehicle_speed": km_h / 3.6,
        "output_speed": output,
        "turbine_speed": np.where(locked & (km_h > 70.0), rpm / 60.0, output * ratio),
        "gear": gear,
        "selector": np.where(gear > 0, 10.0, 0.0),
        "lock_up": np.where(km_h > 60.0, 100.0, 0.0),
        "main_pressure": 250e3 + 350.0 * rpm + generator.normal(0.0, 25e3, count) - 120e3 * (gear == 2),
        "commanded_pressure": 260e3 + 340.0 * rpm,
        "converter_pressure": 200e3 + 30.0 * rpm,
        "atf_temperature": np.linspace(62.0, 62.0 + 0.5 * seconds, count),
    }
    found = {}
    for name in channels:
        series = np.round(values[name], 6)
        for _ in range(int(generator.integers(0, 3))):
            at = int(generator.integers(0, count))
            series[at : at + int(generator.integers(1, 12))] = NAN
        found[name] = series
    cuts = sorted({0, count, *generator.integers(1, count, int(generator.integers(0, 4)) if breaks else 0).tolist()})
    for cut in cuts[1:-1]:
        time[cut:] += 8.0
    segments = tuple(
        Segment(low, high - low, float(time[low]), float(time[high - 1] - time[low])) for low, high in pairwise(cuts)
    )
    logged = {
        name: Channel(name, time, series, np.isnan(series), column=name, kind="measured", sampling_hz=1.0 / step)
        for name, series in found.items()
    }
    return RoadTest("drive.csv", "0" * 64, count, float(time[-1] - time[0]), time, MappingProxyType(logged), segments)
