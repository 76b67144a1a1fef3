"""Reads MDF measurements (asammdf) in the child process."""

from __future__ import annotations

import io
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


def _channels(mdf: Any) -> Iterator[dict[str, Any]]:
    import numpy as np

    before = None
    for number, group in enumerate(mdf.groups):
        if not group.channel_group.cycles_nr:
            continue
        for index, channel in enumerate(group.channels):
            if ("Frame" in channel.name and "_" in channel.name) or channel.name.lower() in ("timestamp", "time", "t"):
                continue
            signal = mdf.get(group=number, index=index)
            samples = np.asarray(signal.samples)
            if samples.dtype.names or samples.ndim != 1 or samples.dtype.kind not in "fiub" or not len(samples):
                continue
            stamps = np.asarray(signal.timestamps, float)
            same = before is not None and np.array_equal(stamps, before)
            before = stamps
            yield {
                "label": channel.name,
                "unit": signal.unit or None,
                "stamps": None if same else bytearray(stamps),
                "values": bytearray(samples.astype(float)),
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
