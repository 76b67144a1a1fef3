"""Checks of one channel: each takes a Series and gives a boolean Series in which True means *suspect*.

Nothing is removed: a suspect sample stays in the channel and is counted.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
import pandas as pd

from atleak.common.sentences import Sentence
from atleak.measurements.road_test import QUANTITIES

# a full counter, a sign bit alone, an error code of a bus: never a measured value
SENTINELS = (
    65535.0, 65534.0, -2147483617.0, -2147483648.0, 2147483647.0, 4294967295.0, 32767.0, -32768.0, 16383.75, 8191.875,
    6553.5, 655.35, 1e9, -9999.0, 9999.0, 99999.0, 999999.0,
)  # fmt: skip
CHECKS: Mapping[str, Sentence] = {  # what messages call them
    "sentinel": Sentence("sentinel"),
    "out of range": Sentence("out of range"),
    "failed sensor": Sentence("failed sensor"),
    "start-up": Sentence("start-up"),
    "spike": Sentence("spike"),
    "frozen": Sentence("frozen"),
}
_STEP = {  # what a channel can change between two samples at most, per kind, in SI; for spikes
    "rotational_speed": 2000.0 / 60,
    "temperature": 15.0,
    "speed": 40.0 / 3.6,
    "pressure": 2.5e6,
}
_HELD = 5  # equal samples that may be one answer, held
START_UP = 8.0  # [K] between two samples with which a channel starts up
ORDINARY = -15.0  # [°C] that the other samples of a failed sensor are above
LEAST_RUN = 20  # samples of a run that may be frozen
FEW_MOVES = 10  # changes of the car's other speed that show nothing
FEW, LIVELY = 0.1, 0.25  # share of samples that may be frozen, and of others that change, where nothing else moves
SCALE = (-39.9, 214.9)  # [°C] from which on a temperature may be the end of a sensor's scale
FROZEN_SECONDS = {"rotational_speed": 15.0, "temperature": 3600.0, "pressure": 600.0}


def _ends(values: np.ndarray) -> tuple[float, float]:
    """Return the least and the greatest value, NaN left out."""
    if not len(values):
        return np.inf, -np.inf
    least, most = float(values.min()), float(values.max())
    if least != least:  # the slower way only where there are NaN
        least, most = float(np.fmin.reduce(values, initial=np.inf)), float(np.fmax.reduce(values, initial=-np.inf))
    return least, most


def sentinel(series: pd.Series) -> pd.Series:
    """Mark error codes in the file's own unit: 65535, −2147483617 and the like.

    >>> sentinel(pd.Series([800.0, 65535.0])).tolist()
    [False, True]
    """
    codes = pd.Series(np.isin(series, SENTINELS), series.index)
    return codes & bool(codes.mean() <= 0.5)  # else it is an ordinary value of this channel


def out_of_range(series: pd.Series, low: float, high: float) -> pd.Series:
    """Mark values outside the range that the quantity can have."""
    return (series < low) | (series > high)


def start_up(series: pd.Series, step: float, rows: int = 10) -> pd.Series:
    """Mark wrong values at the start and end of a channel: all beyond a step within ``rows`` of an end.

    For slow channels such as a temperature: 236, 125, 118, 118 … is suspect up to the 125.
    """
    values = series.to_numpy()
    result = np.zeros(len(values), bool)
    if len(values) < 3 * rows:
        return pd.Series(result, series.index)
    with np.errstate(invalid="ignore"):
        head = np.flatnonzero(np.abs(np.diff(values[: rows + 1])) > step)
        tail = np.flatnonzero(np.abs(np.diff(values[-rows - 1 :])) > step)
    if len(head):
        result[: head[-1] + 1] = True
    if len(tail):
        result[len(values) - rows + tail[0] :] = True
    return pd.Series(result, series.index)


def spikes(series: pd.Series, step: float) -> pd.Series:
    """Mark samples that leave their neighbours by more than ``step`` and come straight back.

    It is one sample, or a few equal ones: a logger's held answer.
    """
    values = series.to_numpy()
    result = np.zeros(len(values), bool)
    if len(values) >= 3:
        change = np.diff(values)
        big = np.flatnonzero((change > step) | (change < -step))
        leaves, returns = big[:-1], big[1:]
        near = (returns - leaves <= _HELD) & (change[leaves] * change[returns] < 0)
        near &= np.abs(values[returns + 1] - values[leaves]) < 0.25 * np.abs(change[leaves])
        for first, last in zip(leaves[near] + 1, returns[near], strict=True):
            if (values[first:last] == values[last]).all():
                result[first : last + 1] = True
    return pd.Series(result, series.index)


def frozen(series: pd.Series, seconds: float, moving: Callable[[], np.ndarray | None] | None = None) -> pd.Series:
    """Mark where a channel repeats one value other than zero for longer than ``seconds`` (index: stamps in s).

    ``moving`` gives the samples at which the car's other speed changes: a run counts only where it does. None of it:
    no other speed is logged, and a run counts where it is short beside samples that keep changing.
    """
    values, time = series.to_numpy(), series.index.to_numpy()
    result = np.zeros(len(values), bool)
    if len(values) < LEAST_RUN:
        return pd.Series(result, series.index)
    same = values[1:] == values[:-1]
    still = np.int8(0)  # of the size of the others
    edges = np.flatnonzero(np.diff(same.view(np.int8), prepend=still, append=still))
    starts, stops = edges[::2], edges[1::2]  # first and last samples of one value
    long = (stops - starts >= LEAST_RUN) & (time[stops] - time[starts] > seconds) & (values[starts] != 0)
    starts, stops = starts[long], stops[long]
    beside = moving() if moving is not None and len(starts) else None
    if moving is not None and beside is None:  # nothing else moves: long runs must be few beside samples that change
        held = int(np.sum(stops - starts + 1))
        others = len(values) - np.count_nonzero(same) - len(starts)
        if held >= FEW * len(values) or others <= LIVELY * max(len(values) - held, 1):
            return pd.Series(result, series.index)
    for start, stop in zip(starts, stops, strict=True):
        if beside is None or np.count_nonzero(beside[start : stop + 1]) > FEW_MOVES:
            result[start : stop + 1] = True
    return pd.Series(result, series.index)


def failed_sensor(series: pd.Series) -> pd.Series:
    """Mark temperatures [°C] at the end of a sensor's scale, −40 or 215, where others are ordinary."""
    ends = ((series + 40).abs() < 0.06) | ((series - 215).abs() < 0.06)
    return ends & bool(series[~ends & np.isfinite(series)].median() > ORDINARY)


def suspect(
    quantity: str,
    raw: np.ndarray,
    si: np.ndarray,
    time: np.ndarray,
    moving: Callable[[], np.ndarray | None] | None = None,
) -> dict[str, np.ndarray]:
    """Return, by name of the check, which samples each check of a quantity doubts; checks without doubt are left out.

    ``raw`` are the file's numbers, ``si`` the same in SI, ``time`` the channel's stamps.
    """
    limits, kind = QUANTITIES[quantity], QUANTITIES[quantity].unit_kind
    clean, masks = pd.Series(si, time, copy=False), {}
    raw_ends, (least, most) = _ends(raw), _ends(si)
    # most checks are of values that lie at an end: of the usual channel none is
    if least < limits.low or most > limits.high or np.isin(raw_ends, SENTINELS).any():
        masks["sentinel"] = sentinel(clean if raw is si else pd.Series(raw, time, copy=False))
        masks["out of range"] = out_of_range(clean, limits.low, limits.high)
        suspect_so_far = masks["sentinel"].to_numpy() | masks["out of range"].to_numpy()
        clean = pd.Series(np.where(suspect_so_far, np.nan, si), time) if suspect_so_far.any() else clean
    if kind == "temperature":
        if least <= SCALE[0] or most >= SCALE[1]:
            masks["failed sensor"] = failed_sensor(clean)
            if masks["failed sensor"].to_numpy().any():
                clean = clean.mask(masks["failed sensor"])
        masks["start-up"] = start_up(clean, START_UP)
    if kind in _STEP and most - least > _STEP[kind]:
        masks["spike"] = spikes(clean, _STEP[kind])
    if kind in FROZEN_SECONDS:
        masks["frozen"] = frozen(clean, FROZEN_SECONDS[kind], moving)
    arrays = {name: mask.to_numpy() for name, mask in masks.items()}
    return {name: mask for name, mask in arrays.items() if mask.any()}


def is_sample_and_hold(values: np.ndarray) -> bool:
    """Return whether a logger repeats a channel's last answer between true ones.

    A true signal creeps by its resolution; one that stands still and then leaps, again and again, is held.
    """
    if len(values) > 20_000:
        middle = len(values) // 2
        values = values[middle - 10_000 : middle + 10_000]
    change = np.abs(np.diff(values))
    change = change[np.isfinite(change)]
    moves = change[change > 0]
    if len(change) < 20 or len(moves) < 8:
        return False
    stands = 1 - len(moves) / len(change)
    return bool(0.45 < stands < 0.98 and np.median(moves) >= 4 * moves.min() and np.median(moves) > 0)
