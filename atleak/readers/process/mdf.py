"""Reads MDF measurements (asammdf) in the child process."""

from __future__ import annotations

import io
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

MdfPart = tuple[str, dict[str, Any]]


@contextmanager
def _opened(source: bytes | str) -> Iterator[Any]:
    from asammdf import MDF

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        with MDF(io.BytesIO(source) if isinstance(source, bytes) else source) as mdf:
            yield mdf


def mdf_contents(source: bytes | str) -> Iterator[MdfPart]:
    """Yield what an MDF file holds without the numbers of its channels; arrays are bytes.

    ``file`` with its ``version``; then each ``channel`` that holds numbers, with ``label``, ``unit`` or None, its
    ``group`` and ``index``, by which `mdf_ranges` finds it, its ``count`` of valid samples among the ``cycles`` of its
    group; then ``frames`` of each group of a CAN bus, with their ``count`` and, where they carry eight bytes,
    ``stamps`` [s], ``identifiers`` (int64) and ``data`` (uint8, shape (frames, 8)).
    """
    with _opened(source) as mdf:
        yield "file", {"version": str(mdf.version)}
        held: dict[int, int] = {}  # records by group
        for number, index, channel in _named(mdf):
            first = mdf.get(group=number, index=index, record_offset=0, record_count=1, ignore_invalidation_bits=True)
            if not _holds_numbers(first):
                continue
            if number not in held:
                held[number] = _records(mdf, number, index)
            count = cycles = held[number]
            if first.invalidation_bits is not None:  # which says of each whether it is valid
                count = len(mdf.get(group=number, index=index).samples)
            if count:
                where = {"group": number, "index": index, "count": count, "cycles": cycles}
                yield "channel", {"label": channel.name, "unit": first.unit or None, **where}
        for frames in _frames(mdf):
            yield "frames", frames


def mdf_ranges(source: bytes | str, indexes: Mapping[int, Sequence[int]], length: int) -> Iterator[MdfPart]:
    """Yield the samples of some channels, range by range: ``range`` with ``group``, ``stamps`` [s] and ``channels``.

    Of every channel that is asked for there are the ``values``, and the ``stamps`` of those that are valid, None where
    all are. Stamps and values are the bytes of floats. ``indexes`` are those of the channels, by the number of their
    group, ``length`` is that of a range.
    """
    import numpy as np

    with _opened(source) as mdf:
        for group, those in indexes.items():
            chosen = [(None, group, index) for index in those]
            count = _records(mdf, group, those[0])
            for start in range(0, count, length):
                signals = mdf.select(chosen, record_offset=start, record_count=min(length, count - start))
                stamps = np.asarray(signals[0].timestamps, float)
                channels = [_valid(signal) for signal in signals]
                yield "range", {"group": group, "stamps": bytearray(stamps), "channels": channels}


def _records(mdf: Any, group: int, index: int) -> int:
    """Return how many records a group holds: a recorder that was cut off states more, and asammdf makes them up."""
    stated = int(mdf.groups[group].channel_group.cycles_nr)
    options = {"group": group, "index": index, "ignore_invalidation_bits": True, "raw": True}
    if len(mdf.get(**options, record_offset=stated - 1, record_count=1).samples):
        return stated
    return len(mdf.get(**options).samples)


def _valid(signal: Any) -> dict[str, bytearray | None]:
    """Return the values and stamps of the samples that are not marked as invalid, as a whole channel is read."""
    import numpy as np

    kept = signal.validate(copy=False)
    every = len(kept.samples) == len(signal.samples)
    stamps = None if every else bytearray(np.ascontiguousarray(kept.timestamps, float))
    return {"values": bytearray(np.asarray(kept.samples).astype(float)), "stamps": stamps}


def _named(mdf: Any) -> Iterator[tuple[int, int, Any]]:
    """Yield the channels that may hold a quantity, with the numbers of their groups and their own in them."""
    for number, group in enumerate(mdf.groups):
        if not group.channel_group.cycles_nr:
            continue
        for index, channel in enumerate(group.channels):
            of_bus = "Frame" in channel.name and "_" in channel.name
            if not of_bus and channel.name.lower() not in ("timestamp", "time", "t"):
                yield number, index, channel


def _holds_numbers(signal: Any) -> bool:
    import numpy as np

    samples = np.asarray(signal.samples)
    return not samples.dtype.names and samples.ndim == 1 and samples.dtype.kind in "fiub" and len(samples) > 0


def _frames(mdf: Any) -> Iterator[dict[str, Any]]:
    import numpy as np

    for number, group in enumerate(mdf.groups):
        names = {channel.name for channel in group.channels}
        if not group.channel_group.cycles_nr or "CAN_DataFrame.ID" not in names:
            continue
        ids = mdf.get("CAN_DataFrame.ID", group=number)
        payload = np.asarray(mdf.get("CAN_DataFrame.DataBytes", group=number).samples)
        frames: dict[str, Any] = {"count": len(ids.samples)}
        if payload.ndim == 2 and payload.shape[1] >= 8:
            frames["stamps"] = bytearray(np.ascontiguousarray(ids.timestamps, float))
            frames["identifiers"] = bytearray(np.ascontiguousarray(ids.samples, np.int64))
            frames["data"] = bytearray(np.ascontiguousarray(payload[:, :8], np.uint8))
        yield frames
