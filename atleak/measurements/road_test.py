"""Defines a road test: channels in SI over time, with the stretches in which time runs without a break.

Nothing here knows a file format. ``atleak.readers.logs`` makes a `RoadTest` from a logger's file.
"""

from __future__ import annotations

import datetime as dt
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Literal

import numpy as np

from atleak.common.errors import Message
from atleak.common.printable import brief
from atleak.common.sentences import Sentence

_BREAKS = 400  # edges of stretches without values that are kept of each thinned series at most

ChannelKind = Literal["measured", "commanded", "unknown"]
ChannelSource = Literal["logged", "derived", "constant"]


@dataclass(frozen=True)
class _Quantity:
    """A quantity that a log can hold.

    ``unit_kind`` is the kind of unit in ``atleak.common.units`` (None: a plain number or code), ``workshop_unit``
    the unit people see, ``low`` and ``high`` the range in SI outside which a sample cannot be true.
    """

    name: str
    unit_kind: str | None
    workshop_unit: str
    low: float = -np.inf
    high: float = np.inf
    label: Sentence = Sentence("")  # noqa: RUF009  frozen, so safe to share
    said: Sentence = Sentence("")  # noqa: RUF009  its name as messages have it


_QUANTITIES = (
    _Quantity("time", "time", "s", label=Sentence("time"), said=Sentence("time")),
    _Quantity("engine_speed", "rotational_speed", "rpm", 0.0, 15000 / 60,
             Sentence("engine speed"), Sentence("engine_speed")),
    _Quantity("atf_temperature", "temperature", "°C", -50.0, 200.0,
             Sentence("ATF temperature"), Sentence("atf_temperature")),
    _Quantity("main_pressure", "pressure", "kPa", -101.4e3, 10e6,
             Sentence("main (line) pressure"), Sentence("main_pressure")),
    _Quantity("commanded_pressure", "pressure", "kPa", -101.4e3, 10e6,
             Sentence("commanded main pressure"), Sentence("commanded_pressure")),
    _Quantity("converter_pressure", "pressure", "kPa", -101.4e3, 5e6,
             Sentence("converter pressure"), Sentence("converter_pressure")),
    _Quantity("gear", None, "", -1.0, 12.0, Sentence("gear"), Sentence("gear")),
    _Quantity("vehicle_speed", "speed", "km/h", -1.0, 450 / 3.6,
             Sentence("vehicle speed"), Sentence("vehicle_speed")),
    _Quantity("turbine_speed", "rotational_speed", "rpm", -1.0, 15000 / 60,
             Sentence("turbine (input) speed"), Sentence("turbine_speed")),
    _Quantity("output_speed", "rotational_speed", "rpm", -20.0, 15000 / 60,
             Sentence("output speed"), Sentence("output_speed")),
    _Quantity("selector", None, "", label=Sentence("selector position"), said=Sentence("selector")),
    _Quantity("lock_up", None, "", label=Sentence("converter lock-up"), said=Sentence("lock_up")),
    _Quantity("coolant_temperature", "temperature", "°C", -50.0, 200.0,
             Sentence("engine coolant temperature"), Sentence("coolant_temperature")),
)  # fmt: skip
QUANTITIES: Mapping[str, _Quantity] = MappingProxyType({quantity.name: quantity for quantity in _QUANTITIES})


@dataclass(frozen=True, eq=False)
class Channel:
    """One quantity with the stamps at which it was sampled.

    Parameters
    ----------
    quantity
        One of `QUANTITIES`.
    time
        The channel's own stamps [s], ascending, on the road test's time axis.
    values
        What the logger wrote at those stamps, in SI; suspect samples stand here unchanged.
    suspect
        True where a check marks the sample as suspect.
    column, unit
        Its name and unit in the file.
    unit_assumed
        Nothing in the file states the unit.
    kind
        For a pressure: measured by a gauge, commanded by the gearbox computer, or unknown.
    source
        ``logged``, ``derived`` from other channels, or a ``constant`` the user gave.
    independent
        Samples that are not a mere repeat of the one before in a logger that repeats the last answer.
    sampling_hz
        The channel's true rate: independent samples per second, breaks not counted. [1/s]
    """

    quantity: str
    time: np.ndarray
    values: np.ndarray
    suspect: np.ndarray
    column: str = ""
    unit: str = ""
    unit_assumed: bool = False
    kind: ChannelKind = "unknown"
    source: ChannelSource = "logged"
    independent: int = 0
    sampling_hz: float = float("nan")

    @property
    def samples(self) -> int:
        """Return the number of its own samples."""
        return len(self.values)

    @property
    def good(self) -> np.ndarray:
        """Return the values with NaN where suspect."""
        return np.where(self.suspect, np.nan, self.values) if self.suspect.any() else self.values


@dataclass(frozen=True)
class Segment:
    """A stretch in which time runs on without a gap or a backward jump."""

    start_row: int  # on the road test's ``time``
    rows: int  # likewise
    start: float  # [s]
    duration: float  # [s]

    @property
    def stop(self) -> float:
        """Return the last stamp [s]."""
        return self.start + self.duration


@brief
@dataclass(frozen=True, eq=False)
class RoadTest:
    """A road test as the engine takes it.

    `values` puts a channel on the common base by holding its last own sample, never across a segment's end, never for
    longer than three of the channel's usual intervals; before the first sample there is NaN. Nothing is interpolated.

    Attributes
    ----------
    file
        the log's name.
    sha256
        of its bytes.
    rows
        data rows of the file.
    duration
        from the first stamp to the last [s], of each stretch between backward jumps for itself.
    time
        common base [s], ascending, shape ``(samples,)``: the stamps of the log's rows (of its channels, where each has
        its own). A log whose clock jumps back goes on behind the stretch before it, as a segment of its own.
    channels
        by quantity.
    segments
        stretches without a gap or a backward jump.
    messages
        what was assumed, and what is suspect.
    format
        of the file, as ``csv`` or ``mdf``.
    encoding
        of a text.
    delimiter
        of a text, between its columns.
    decimal
        of a text, the decimal sign.
    refused
        of quantities that the log lacks: why the column that bears the name was not taken.
    date
        of the first sample, where the log states it beyond doubt.
    """

    file: str
    sha256: str
    rows: int
    duration: float
    time: np.ndarray
    channels: Mapping[str, Channel]
    segments: tuple[Segment, ...] = ()
    messages: tuple[Message, ...] = ()
    format: str = ""
    encoding: str | None = None
    delimiter: str | None = None
    decimal: str | None = None
    refused: Mapping[str, Sentence] = field(default_factory=dict)
    date: dt.date | None = None
    _held: dict[str, np.ndarray] = field(default_factory=dict, repr=False)

    @property
    def quantities(self) -> tuple[str, ...]:
        """Return the quantities this log holds, time first."""
        return ("time", *self.channels)

    def channel(self, quantity: str) -> Channel | None:
        """Return the channel of a quantity with its own stamps; None when the log has none.

        Parameters
        ----------
        quantity
            one of `QUANTITIES`.

        Raises
        ------
        KeyError
            for a quantity that `QUANTITIES` does not know.
        """
        QUANTITIES[quantity]
        return self.channels.get(quantity)

    def kind(self, quantity: str) -> ChannelKind | None:
        """Return whether a pressure is measured, commanded or unknown; None when the log has none.

        Parameters
        ----------
        quantity
            one of `QUANTITIES`.
        """
        channel = self.channel(quantity)
        return channel.kind if channel else None

    def values(self, quantity: str) -> np.ndarray | None:
        """Put a channel on the common base.

        Parameters
        ----------
        quantity
            one of `QUANTITIES`.

        Returns
        -------
        array or None
            shape ``(len(time),)``, SI, NaN where not sampled or suspect; None when the log does not hold the quantity.
            The array is shared: do not write into it.

        Raises
        ------
        KeyError
            for a quantity that `QUANTITIES` does not know.
        """
        if quantity == "time":
            return self.time
        channel = self.channel(quantity)
        if channel is None:
            return None
        if quantity not in self._held:
            self._held[quantity] = self._hold(channel)
        return self._held[quantity]

    def _hold(self, channel: Channel) -> np.ndarray:
        if channel.source == "constant":
            return np.full(len(self.time), channel.values[0])
        if channel.time is self.time:
            return channel.good
        return hold(channel.time, channel.good, self.time, self.segments)

    def window(self, start: float, stop: float) -> RoadTest:
        """Return a part; its ``rows`` count the base's stamps inside.

        Parameters
        ----------
        start, stop
            its first and last stamp [s], both inside.
        """
        inside = (self.time >= start) & (self.time <= stop)
        time = self.time[inside]
        channels = {}
        for name, channel in self.channels.items():
            if channel.source == "constant":
                channels[name] = channel
                continue
            if channel.time is self.time:
                mask, own = inside, time
            else:
                mask = (channel.time >= start) & (channel.time <= stop)
                own = channel.time[mask]
            channels[name] = replace(channel, time=own, values=channel.values[mask], suspect=channel.suspect[mask])
        segments, first = [], int(np.argmax(inside)) if len(time) else 0
        for segment in self.segments:
            low = max(segment.start_row, first)
            high = min(segment.start_row + segment.rows, first + len(time))
            if high > low:
                begin, end = float(self.time[low]), float(self.time[high - 1])
                segments.append(Segment(low - first, high - low, begin, end - begin))
        return replace(
            self,
            rows=len(time),
            duration=float(time[-1] - time[0]) if len(time) else 0.0,
            time=time,
            channels=MappingProxyType(channels),
            segments=tuple(segments),
            _held={},
        )


def hold_limit(time: np.ndarray) -> float:
    """Return how long a sample may be held [s]: three usual intervals, and no less than nine in ten intervals last.

    >>> hold_limit(np.array([0.0, 0.1, 0.2, 0.3]))
    0.3
    """
    steps = np.diff(time)
    steps = steps[steps > 0]
    if not len(steps):
        return np.inf
    return float(np.round(max(3 * np.median(steps), np.percentile(steps, 90)), 9))


def hold(own_time: np.ndarray, values: np.ndarray, time: np.ndarray, segments: tuple[Segment, ...] = ()) -> np.ndarray:
    """Return a channel's last own sample at each stamp of another base.

    NaN before the first sample, after `hold_limit`, and where the last sample lies in an earlier segment.
    """
    if not len(own_time):
        return np.full(len(time), np.nan)
    last = np.searchsorted(own_time, time, side="right") - 1
    begin = np.full(len(time), -np.inf)
    for segment in segments:
        begin[segment.start_row : segment.start_row + segment.rows] = segment.start
    stamp = own_time[np.maximum(last, 0)]
    usable = (last >= 0) & (stamp >= begin) & (time - stamp <= hold_limit(own_time) * (1 + 1e-9))
    return np.where(usable, values[np.maximum(last, 0)], np.nan)


def thinned(series: Sequence[np.ndarray], points: int, keep: Sequence[int] = ()) -> np.ndarray:
    """Choose about ``points`` samples that show the course of several series of equal length.

    Every stretch keeps its lowest and highest value, so that a spike of one sample stays; so do both ends and the edges
    of stretches without values. Nothing is averaged.

    Parameters
    ----------
    series
        arrays of shape (n,) on one time base; NaN where a value is missing.
    points
        how many samples are wanted; a series that has no more is taken whole.
    keep
        indices that stay in any case.

    Returns
    -------
    numpy.ndarray
        rising indices into the series.
    """
    from tsdownsample import MinMaxDownsampler  # most runs draw no series

    size = len(series[0])
    if size <= points:
        return np.arange(size)
    each = max(points // len(series) // 2 * 2, 4)
    chosen = [np.array([0, size - 1, *keep])]
    for values in series:
        known = np.isfinite(values)
        usable = np.flatnonzero(known)
        if len(usable) > each:
            extremes = MinMaxDownsampler().downsample(np.ascontiguousarray(values[usable], dtype=float), n_out=each)
            usable = usable[np.asarray(extremes, dtype=int)]
        edges = np.flatnonzero(known[1:] != known[:-1])[:_BREAKS]
        chosen += [usable, edges, edges + 1]
    return np.unique(np.concatenate(chosen))
