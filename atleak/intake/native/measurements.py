"""Reads MDF measurements (asammdf) in the child process."""

from __future__ import annotations

import io
import json
import warnings
from collections.abc import Iterator
from typing import Any

MdfPart = tuple[str, dict[str, Any]]


def mdf_parts(data: bytes) -> Iterator[MdfPart]:
    """Yield what an MDF file holds, part by part; arrays are the bytes of floats unless stated otherwise.

    ``file`` with its ``version``; then each ``channel`` that holds numbers, with ``label``, ``unit`` or None,
    ``values`` and ``stamps`` [s], these None where they are those of the channel before; then ``frames`` of each group
    of a CAN bus, with their ``count`` and, where they carry eight bytes, ``stamps`` [s], ``identifiers`` (int64) and
    ``data`` (uint8, shape (frames, 8)).
    """
    from asammdf import MDF

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        with MDF(io.BytesIO(data)) as mdf:
            yield "file", {"version": str(mdf.version)}
            for channel in _channels(mdf):
                yield "channel", channel
            for frames in _frames(mdf):
                yield "frames", frames


def mdf_contents(request: bytes) -> Iterator[MdfPart]:
    """Yield what an MDF file holds that lies at a path, without its numbers.

    ``file`` with its ``version``, then each ``channel`` that holds numbers, with ``label``, ``unit`` or None, its
    ``group`` and ``index``, by which `mdf_ranges` finds it, its ``count`` of samples, and whether it is ``marked``:
    the file says of each sample whether it is valid; then the ``count`` of ``frames`` of each group of a CAN bus.

    Parameters
    ----------
    request
        JSON, with the file's ``path``, in full.
    """
    from asammdf import MDF

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        with MDF(json.loads(request)["path"]) as mdf:
            yield "file", {"version": str(mdf.version)}
            for number, index, channel in _named(mdf):
                first = mdf.get(
                    group=number, index=index, record_offset=0, record_count=1, ignore_invalidation_bits=True
                )
                if _holds_numbers(first):
                    count = int(mdf.groups[number].channel_group.cycles_nr)
                    marked = first.invalidation_bits is not None
                    where = {"group": number, "index": index, "count": count, "marked": marked}
                    yield "channel", {"label": channel.name, "unit": first.unit or None, **where}
            for group in mdf.groups:
                if "CAN_DataFrame.ID" in {channel.name for channel in group.channels}:
                    yield "frames", {"count": int(group.channel_group.cycles_nr)}


def mdf_ranges(request: bytes) -> Iterator[MdfPart]:
    """Yield the samples of some channels, range by range: ``range`` with ``group``, ``stamps`` [s] and ``channels``.

    Of every channel that is asked for there are the ``values``, and the ``stamps`` of those that are valid, None where
    all are. Stamps and values are the bytes of floats.

    Parameters
    ----------
    request
        JSON, with the file's ``path``, in full, and the ``indexes`` of the channels by the number of their group.
    """
    import numpy as np
    from asammdf import MDF

    asked = json.loads(request)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        with MDF(asked["path"]) as mdf:
            for group, indexes in asked["indexes"].items():
                chosen = [(None, int(group), index) for index in indexes]
                count = int(mdf.groups[int(group)].channel_group.cycles_nr)
                for start in range(0, count, asked["length"]):
                    signals = mdf.select(chosen, record_offset=start, record_count=min(asked["length"], count - start))
                    stamps = np.asarray(signals[0].timestamps, float)
                    channels = [_valid(signal) for signal in signals]
                    yield "range", {"group": int(group), "stamps": bytearray(stamps), "channels": channels}


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
            if ("Frame" in channel.name and "_" in channel.name) or channel.name.lower() in ("timestamp", "time", "t"):
                continue
            yield number, index, channel


def _holds_numbers(signal: Any) -> bool:
    import numpy as np

    samples = np.asarray(signal.samples)
    return not samples.dtype.names and samples.ndim == 1 and samples.dtype.kind in "fiub" and len(samples) > 0


def _channels(mdf: Any) -> Iterator[dict[str, Any]]:
    import numpy as np

    before = None
    for number, index, channel in _named(mdf):
        signal = mdf.get(group=number, index=index)
        if not _holds_numbers(signal):
            continue
        stamps = np.asarray(signal.timestamps, float)
        same = before is not None and np.array_equal(stamps, before)
        before = stamps
        yield {
            "label": channel.name,
            "unit": signal.unit or None,
            "stamps": None if same else bytearray(stamps),
            "values": bytearray(np.asarray(signal.samples).astype(float)),
        }


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
