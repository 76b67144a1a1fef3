"""Makes the channels of a large log from the columns on disk: each is looked through, and then held onto the base."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from atleak.columns import DiskColumn
from atleak.intake.road_test.channels.assign import Assigner
from atleak.intake.road_test.channels.build import (
    SPEEDS,
    channel_of,
    constant,
    rate_of,
    refuse_unknown,
    repeats_answers,
    say_samples,
)
from atleak.intake.road_test.pieces.samples import Facts, OwnSamples, held, hold_limit, judged, middle_of
from atleak.intake.road_test.pieces.spool import Spool
from atleak.intake.road_test.pieces.timelines import LargeTimeline
from atleak.road_test import QUANTITIES, Channel

_NOTHING, _NONE = np.empty(0), np.empty(0, bool)


def large_channels(
    assigner: Assigner, timeline: LargeTimeline, constants: Mapping[str, float], spool: Spool
) -> tuple[Mapping[str, Channel], Mapping[str, DiskColumn]]:
    """Return the channels of a large log without their samples, and these on the base [SI], NaN where not known.

    The channels are in the order of `QUANTITIES`; the columns that the signals came from are deleted.
    """
    built: dict[str, Channel] = {}
    columns: dict[str, DiskColumn] = {}
    signals = {name: signal for name, signal in assigner.signals.items() if name != "time"}
    speeds = [signals[name] for name in SPEEDS if name in signals]
    for quantity in QUANTITIES:
        if quantity in signals:
            signal = signals[quantity]
            own = OwnSamples(signal, timeline, next((speed for speed in speeds if speed is not signal), None))
            built[quantity], columns[quantity] = _channel(assigner, own, spool)
        elif quantity in constants and quantity != "time":
            built[quantity] = constant(assigner, quantity, constants[quantity], timeline.time[:1])
    refuse_unknown(constants)
    for column in {id(signal.on_disk): signal.on_disk for signal in signals.values()}.values():
        if column is not None:
            column.remove()
    return MappingProxyType(built), columns


def _channel(assigner: Assigner, own: OwnSamples, spool: Spool) -> tuple[Channel, DiskColumn]:
    signal, timeline, facts, counts = own.signal, own.timeline, Facts.of(own), dict[str, int]()
    column = spool.column()
    if facts.whole and (signal.time is None or signal.time is timeline.time):
        for _, values in judged(own, facts, counts):
            column.append(values)
    else:
        limit = hold_limit(own.steps()) if facts.count else np.inf
        for values in held(timeline, lambda: judged(own, facts, counts), facts.count, limit):
            column.append(values)
    independent, repeated = facts.count, repeats_answers(signal, middle_of(own, facts.count))
    if repeated:
        independent -= facts.repeats
    doubted = {name: count for name, count in counts.items() if count}
    say_samples(assigner, signal, facts.count, doubted, independent if repeated else None)
    rate = rate_of(independent, _span(timeline, facts))
    return channel_of(signal, _NOTHING, _NOTHING, _NONE, independent, rate), column


def _span(timeline: LargeTimeline, facts: Facts) -> float:
    """Return the time [s] that a channel's samples cover, without the gaps."""
    firsts, lasts = timeline.stretches
    breaks = (lasts[:-1] >= facts.span[0]) & (firsts[1:] <= facts.span[1])
    return facts.span[1] - facts.span[0] - float(np.sum((firsts[1:] - lasts[:-1])[breaks]))
