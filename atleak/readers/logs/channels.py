"""Makes the channels of a `RoadTest` from signals and stamps: SI units, suspect samples, true rates, constants."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from itertools import pairwise
from types import MappingProxyType

import numpy as np

from atleak.common.errors import RoadTestError, unknown
from atleak.common.sentences import Sentence
from atleak.common.units import KPA, Quantity
from atleak.measurements.road_test import QUANTITIES, Channel, Segment
from atleak.readers.logs import suspects
from atleak.readers.logs.columns import Assigner, Signal
from atleak.readers.logs.timeline import Timeline

_NOTHING = np.empty(0)


def channels(assigner: Assigner, timeline: Timeline, constants: Mapping[str, float]) -> Mapping[str, Channel]:
    """Return the channels of a road test, in the order of `QUANTITIES`."""
    built: dict[str, Channel] = {}
    beside = [name for name in SPEEDS if name in assigner.signals][:2]  # one, and another for itself
    speeds = [assigner.signals[name] for name in beside]
    logged = {name: signal for name, signal in assigner.signals.items() if name != "time"}

    for quantity in QUANTITIES:
        if quantity in logged:
            signal = logged[quantity]
            speed = next((speed for speed in speeds if speed is not signal), None)
            built[quantity] = _channel(assigner, signal, speed, timeline)
            if quantity not in beside:  # the file's numbers are let go of as soon as nothing asks for them
                assigner.signals[quantity] = logged[quantity] = replace(signal, values=_NOTHING)
        elif quantity in constants and quantity != "time":  # of which the constant is the interval between rows
            built[quantity] = _constant(assigner, quantity, constants[quantity], timeline.time[:1])
    possible = [name for name in QUANTITIES if name != "time"]
    for name in constants:
        if name not in QUANTITIES:
            raise unknown(Sentence("unknown quantity for a constant"), name, possible, kind=RoadTestError)
    return MappingProxyType(built)


SPEEDS = ("engine_speed", "vehicle_speed", "output_speed", "turbine_speed")  # each tells whether the car moves


def _channel(assigner: Assigner, signal: Signal, speed: Signal | None, timeline: Timeline) -> Channel:
    """Return a signal as a channel, checked beside another speed of the car, and say what is wrong with it."""
    candidate, raw, time = signal.candidate, signal.values, signal.time
    if time is None:
        time = timeline.time
        raw = timeline.in_order(raw)
        if np.isnan(raw.sum()):
            present = ~np.isnan(raw)
            raw, time = raw[present], time[present]
    si = signal.fit.to_si(raw)

    def moving() -> np.ndarray | None:
        if speed is None or speed.time is not None or signal.time is not None or len(raw) != len(timeline.time):
            return None
        return np.concatenate([[False], np.diff(timeline.in_order(speed.values)) != 0])

    suspect, label = np.zeros(len(raw), bool), candidate.label
    for name, mask in suspects.suspect(candidate.quantity, raw, si, time, moving).items():
        suspect |= mask
        text = Sentence("{column!r}: {count} of {total} samples are suspect ({check}) and left out")
        text = text.of(count=int(mask.sum()), total=len(raw), check=suspects.CHECKS[name], column=label)
        assigner.say("suspect_samples", text, "warning", label)
    kind, commanded = QUANTITIES[candidate.quantity].unit_kind, candidate.kind == "commanded"
    independent = len(raw)
    if kind in ("rotational_speed", "pressure", "speed") and not commanded and suspects.is_sample_and_hold(raw):
        independent -= int(np.count_nonzero(raw[1:] == raw[:-1]))
        text = Sentence("{column!r}: the logger repeats its last answer; {count} of {total} are true samples")
        assigner.say("sample_and_hold", text, "info", label, count=independent, total=len(raw))
    span = _span(time, timeline.segments)
    return Channel(
        candidate.quantity,
        time,
        si.astype(float, copy=False),
        suspect,
        label,
        signal.fit.unit.name if signal.fit.unit else "",
        signal.fit.assumed,
        candidate.kind if kind == "pressure" or candidate.quantity == "lock_up" else "unknown",
        "logged",
        independent,
        (independent - 1) / span if span > 0 and independent > 1 else float("nan"),
    )


def _span(time: np.ndarray, segments: tuple[Segment, ...]) -> float:
    """Return the time [s] that a channel's samples cover, without the gaps."""
    if not len(time):
        return 0.0
    breaks = sum(
        later.start - earlier.stop
        for earlier, later in pairwise(segments)
        if earlier.stop >= time[0] and later.start <= time[-1]
    )
    return float(time[-1] - time[0]) - breaks


def _constant(assigner: Assigner, quantity: str, value: float, time: np.ndarray) -> Channel:
    """Return a channel that is a constant; ``time`` is the log's first stamp."""
    info = QUANTITIES[quantity]
    problem = Sentence("a constant outside what {quantity} can be", quantity=info.label)
    if quantity == "main_pressure" and value <= 0:
        found = Sentence("{pressure:g} {pressure.unit}", pressure=Quantity(value * KPA, "pressure"))
        raise RoadTestError(problem, value=found, expected=Sentence("a pressure above 0 (gauge)"))
    if not info.low <= value <= info.high:
        expected = Sentence("{low:g} to {high:g} (SI)", low=info.low, high=info.high)
        raise RoadTestError(problem, value=value, expected=expected)
    assigner.say("constant", Sentence("{quantity} is not in the log: the given constant is used", quantity=info.said))
    return Channel(quantity, time, np.array([float(value)]), np.zeros(1, bool), source="constant", independent=1)


def time_messages(assigner: Assigner, timeline: Timeline) -> None:
    """Report what is unusual about the clock."""
    if timeline.restarts:
        text = Sentence("the clock jumps back {count} time(s): the log consists of {parts} recordings, kept apart")
        assigner.say("clock_restarted", text, "warning", count=timeline.restarts, parts=timeline.restarts + 1)
    if timeline.gaps:
        text = Sentence("{count} gap(s) in the recording, the longest {longest:.1f} s: nothing is filled in")
        assigner.say("gaps", text, "warning", count=len(timeline.gaps), longest=max(timeline.gaps))
    say_strays(assigner, timeline)
    if count := timeline.unreadable:
        text = Sentence("{count} row(s) without a readable time are left out")
        assigner.say("unreadable_stamps", text, "warning", count=count)
    if count := timeline.reordered:
        assigner.say("reordered", Sentence("{count} row(s) stood out of turn and were put in order", count=count))


def say_strays(assigner: Assigner, timeline: Timeline, column: str | None = None) -> None:
    """Say how many rows are left out for their stray stamps; of one clock among several, which."""
    if timeline.stale:
        text = Sentence("{count} row(s) with a stray time stamp are left out", count=timeline.stale)
        assigner.say("stray_stamps", text, "warning", column)
